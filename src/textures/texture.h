/* What varies over a surface. One file per texture; one line in textures.def. */
#ifndef SNELL_TEXTURES_TEXTURE_H
#define SNELL_TEXTURES_TEXTURE_H

#include "base/field.h"
#include "maths/vec.h"

/* Where a texture is looked up. */
typedef struct texture_point {
    double u, v;      /* the surface's own coordinates */
    bool has_uv;      /* false: u and v are only a parametrisation (planes, meshes without uvs) */
    dvec3 local;      /* the point in the shape's own space, metres */
    dvec3 n;          /* its normal there, unit */
    dvec3 dpdu, dpdv; /* how `local` moves with u, v; 0: not smoothly */
    bool has_uv2;     /* of a mesh with a second set; else the rest is not set */
    double u2, v2;
    dvec3 dpdu2, dpdv2;
    /* The footprint: how far the point is from that of the picture's next sample to the right (x) and
     * down (y). All 0: unknown, a point. */
    dvec3 dpdx, dpdy;
    double dudx, dvdx, dudy, dvdy;
} texture_point;

typedef struct texel {
    dvec3 color; /* linear */
    double alpha;
} texel;

typedef struct texture texture;

typedef struct texture_type {
    type_info info;
    snell_status (*check)(const void *desc); /* beyond the table; NULL: nothing */
    /* What a commit makes once, such as mip maps; several textures at a time. NULL: nothing. Fails
     * only for lack of memory. */
    snell_status (*prepare)(const void *desc, void **state);
    void (*destroy)(void *state);
    size_t (*state_size)(const void *state); /* bytes */
    bool (*filters)(const void *desc);       /* looks at the footprint; NULL: never */
    texel (*evaluate)(const texture *t, const texture_point *point);
    void (*size)(const void *desc, uint32_t *width, uint32_t *height); /* in pixels; NULL: none */
} texture_type;

extern const texture_type *const texture_types[];
extern const uint32_t texture_type_count;

/* A frozen texture: what an input refers to by index. */
struct texture {
    const texture_type *type;
    const void *desc;
    void *state; /* made by type->prepare, owned; NULL: none */
    int map;     /* MAP_..., of the type's field `map` */
};

/* A frozen texture without its state. */
texture texture_make(const texture_type *type, const void *desc);
snell_status texture_prepare(texture *t);
void texture_destroy(texture *t);
bool texture_filters(const texture *t);

/* An input's value at a point: value times texture. `textures` is the frozen scene's array; the
 * id's index + 1 was checked at commit. */
dvec3 input_color(const snell_input *input, const texture *textures, const texture_point *point);
double input_scalar(const snell_input *input, const texture *textures, const texture_point *point);
texel texture_look_up(snell_texture_id id, const texture *textures, const texture_point *point);

/* ---- maps: how a point becomes coordinates; the choices of every `map` field ----
 *
 * auto       uv where the shape has texture coordinates, else object
 * uv         the shape's own u, v
 * object     x, y of the point in the shape's space: projected along z
 * xz         x, z: projected along y, for floors
 * triplanar  projected along x, y and z, as on the faces of a box, and blended by the normal^4
 * spherical  longitude and latitude about +Y seen from the shape's origin, as on a sphere
 * uv2        a mesh's second set of texture coordinates; where there is none, uv */
#define MAP_CHOICES "auto|uv|object|xz|triplanar|spherical|uv2"
enum { MAP_AUTO, MAP_UV, MAP_OBJECT, MAP_XZ, MAP_TRIPLANAR, MAP_SPHERICAL, MAP_UV2 };

/* Two coordinates and their footprint. */
typedef struct map_point {
    double u, v;
    double dudx, dvdx, dudy, dvdy;
} map_point;

/* For every map but triplanar, which has three answers (its first two are x and y here). u and v are
 * rounded to float. */
map_point texture_map(int map, const texture_point *point);
/* What a flat pattern shows through a map: one look, or three blended ones. */
texel texture_through_map(const texture *t, const texture_point *point,
                          texel (*flat)(const texture *t, const map_point *at));
/* Three coordinates: u, v, 0 or x, y, z (z is 0 for uv and spherical, y for xz), and in *width the
 * length of the footprint in them. For patterns that fill space; triplanar is object then. */
dvec3 texture_solid(int map, const texture_point *point, double *width);
/* In which directions, local and of any length, u and v of a map grow; 0 where that is unknown. */
void texture_axes(int map, const texture_point *point, dvec3 *along_u, dvec3 *along_v);
/* The change of u, v for a step on the surface: least squares. 0 where dpdu, dpdv span no plane. */
void texture_uv_change(dvec3 dpdu, dvec3 dpdv, dvec3 dp, double *du, double *dv);

#endif
