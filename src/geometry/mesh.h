/* The triangle mesh's description, which the acceleration structure reads too. */
#ifndef SNELL_GEOMETRY_MESH_H
#define SNELL_GEOMETRY_MESH_H

#include "base/field.h"
#include "maths/vec.h"

/* Indices: three per triangle. normals, uvs, colors, alphas: none or one per position.
 * material_slots: none or one per triangle, an index into `materials`; without, the instance's
 * material is used. */
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
    F(T, materials, MATERIALS, NO_DEFAULT, ANY, "", "the materials that material_slots choose from")
DESCRIBE_STRUCT(mesh, MESH_FIELDS)

static inline size_t mesh_triangle_count(const mesh_desc *mesh) { return mesh->indices_count / 3; }
bounds3 mesh_triangle_bounds(const mesh_desc *mesh, size_t triangle);

#endif
