/* The triangle mesh's description, which the acceleration structure reads too. */
#ifndef SNELL_GEOMETRY_MESH_H
#define SNELL_GEOMETRY_MESH_H

#include "geometry/primitive.h"

/* Indices: three per triangle. normals, uvs, uvs2, colors, alphas: none or one per vertex.
 * material_slots: none or one per triangle, an index into `materials`; without, the instance's
 * material is used. key_times: none, or those of the keys of a mesh that deforms; then positions, and
 * normals if there are any, hold all vertices at the first key, then all at the second, and so on. */
#define MESH_FIELDS(F, T)                                                                          \
    F(T, positions, VEC3S, NO_DEFAULT, REQUIRED, "m", "the vertices")                              \
    F(T, indices, UINTS, NO_DEFAULT, REQUIRED, "",                                                 \
      "three vertex numbers, from 0, per triangle, counter-clockwise")                             \
    F(T, normals, VEC3S, NO_DEFAULT, ANY, "", "one per vertex, for smooth shading; any length")    \
    F(T, uvs, VEC2S, NO_DEFAULT, ANY, "", "texture coordinates, one per vertex")                   \
    F(T, colors, VEC3S, NO_DEFAULT, ANY, "",                                                       \
      "linear colours, one per vertex, that multiply the material's colour")                       \
    F(T, alphas, BYTES, NO_DEFAULT, ANY, "",                                                       \
      "one byte per vertex, 255 opaque, that multiplies the material's alpha")                     \
    F(T, material_slots, UINTS, NO_DEFAULT, ANY, "", "one per triangle: an index into materials")  \
    F(T, materials, MATERIALS, NO_DEFAULT, ANY, "",                                                \
      "the materials that material_slots choose from")                                             \
    F(T, key_times, FLOATS, NO_DEFAULT, ANY, "s",                                                  \
      "of a mesh that deforms: ascending times; positions and normals are lists for each, one "    \
      "after the other, and linear in between")                                                    \
    F(T, uvs2, VEC2S, NO_DEFAULT, ANY, "",                                                         \
      "a second set of texture coordinates, one per vertex, for textures whose map is uv2")        \
    F(T, tangents, FLOATS, NO_DEFAULT, ANY, "",                                                    \
      "four per vertex, for normal maps and anisotropy: where red points, and 1 or -1, by which "  \
      "green is that times the normal's cross product with it; none: from uvs")
DESCRIBE_STRUCT(mesh, MESH_FIELDS)

/* More keys are refused: a mesh is kept once for each that a shutter sees. */
enum { MESH_KEYS_MAX = 1 << 16 };

static inline size_t mesh_triangle_count(const mesh_desc *mesh) { return mesh->indices_count / 3; }
static inline size_t mesh_key_count(const mesh_desc *mesh) {
    return mesh->key_times_count ? mesh->key_times_count : 1;
}
/* At each key. */
static inline size_t mesh_vertex_count(const mesh_desc *mesh) {
    return mesh->positions_count / mesh_key_count(mesh);
}

/* Wherever it goes. */
bounds3 mesh_triangle_bounds(const mesh_desc *mesh, size_t triangle);

/* A triangle as it is at one time. normal: as they are given, of any length; if there are any. */
typedef struct mesh_corners {
    dvec3 vertex[3], normal[3];
} mesh_corners;

/* What a point on a triangle looks like, given its barycentric weights. `away`: which way a triangle
 * without an area faces. */
void mesh_surface(const mesh_desc *mesh, uint32_t triangle, const mesh_corners *at,
                  const double weight[3], dvec3 away, surface *out);
mesh_corners mesh_corners_of(const mesh_desc *mesh, uint32_t triangle);
/* The barycentric weights of a point on a triangle. false: it has no area. */
bool mesh_point_weights(const mesh_corners *at, dvec3 p, double weight[3]);
/* The second set of texture coordinates there, and how the point moves with them; 0 where they say
 * nothing. The mesh has uvs2. */
void mesh_second_uv(const mesh_desc *mesh, uint32_t triangle, const mesh_corners *at,
                    const double weight[3], double uv[2], dvec3 *dpdu, dvec3 *dpdv);
/* The tangent there, of any length, and its sign; the mesh has tangents. */
dvec3 mesh_tangent(const mesh_desc *mesh, uint32_t triangle, const double weight[3], double *sign);
/* primitive_type.bend, area. */
dvec3 mesh_bend(const mesh_desc *mesh, const mesh_corners *at, const hit *found, dvec3 dp);
double mesh_corners_area(const mesh_corners *at);
/* Barycentric weights of the hit, in [0,1] and of sum 1 whatever the float test has rounded. */
void mesh_hit_weights(const hit *found, double weight[3]);

#endif
