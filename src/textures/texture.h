/* What varies over a surface. One file per texture; one line in textures.def. */
#ifndef SNELL_TEXTURES_TEXTURE_H
#define SNELL_TEXTURES_TEXTURE_H

#include "base/field.h"
#include "maths/vec.h"

/* Where a texture is looked up. */
typedef struct texture_point {
    double u, v; /* the surface's own coordinates */
    bool has_uv; /* false: u and v are only a parametrisation (planes, meshes without uvs) */
    dvec3 local; /* the point in the shape's own space, metres */
    dvec3 n;     /* its normal there, unit */
} texture_point;

typedef struct texel {
    dvec3 color; /* linear */
    double alpha;
} texel;

typedef struct texture_type {
    type_info info;
    snell_status (*check)(const void *desc); /* beyond the table; NULL: nothing */
    texel (*evaluate)(const void *desc, const texture_point *point);
    void (*size)(const void *desc, uint32_t *width, uint32_t *height); /* in pixels; NULL: none */
} texture_type;

extern const texture_type *const texture_types[];
extern const uint32_t texture_type_count;

/* A frozen texture: what an input refers to by index. */
typedef struct texture {
    const texture_type *type;
    const void *desc;
} texture;

/* An input's value at a point: value times texture. `textures` is the frozen scene's array; the
 * id's index + 1 was checked at commit. */
dvec3 input_color(const snell_input *input, const texture *textures, const texture_point *point);
double input_scalar(const snell_input *input, const texture *textures, const texture_point *point);

/* How a point becomes two coordinates; the choices of every `map` field. */
#define MAP_CHOICES "auto|uv|object|xz"
enum { MAP_AUTO, MAP_UV, MAP_OBJECT, MAP_XZ };
vec2 texture_map(int map, const texture_point *point);

#endif
