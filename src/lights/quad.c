/* A rectangle or parallelogram that shines to the side of cross(u, v). It is given by a corner and
 * two sides, or by its centre, a point that it faces, width and height. */
#include "base/error.h"
#include "lights/surface_light.h"
#include "maths/functions.h"

#define QUAD_LIGHT_FIELDS(F, T)                                                                    \
    F(T, corner, VEC3, DEFAULT(0, 0, 0), ANY, "m", "one corner")                                   \
    F(T, u, VEC3, DEFAULT(0, 0, 0), ANY, "m", "from the corner along one side")                    \
    F(T, v, VEC3, DEFAULT(0, 0, 0), ANY, "m", "along the other; it shines towards cross(u, v)")    \
    F(T, center, VEC3, DEFAULT(0, 0, 0), ANY, "m", "instead of corner: the centre")                \
    F(T, at, VEC3, DEFAULT(0, 0, 0), ANY, "m", "a point that it faces")                            \
    F(T, width, FLOAT, DEFAULT(0), NOT_NEGATIVE, "m", "of the level side; 0: corner, u and v")     \
    F(T, height, FLOAT, DEFAULT(0), NOT_NEGATIVE, "m", "of the other; 0: as wide")                 \
    SURFACE_LIGHT_FIELDS(F, T)
DESCRIBE(quad_light, QUAD_LIGHT_FIELDS)

typedef struct sides {
    dvec3 corner, u, v;
} sides;

/* The level side is across the way it faces and +Y; a quad that faces straight up or down has one
 * side along +X. */
static sides sides_of(const quad_light_desc *l) {
    if (!(l->width > 0)) return (sides){dvec3_from(l->corner), dvec3_from(l->u), dvec3_from(l->v)};
    dvec3 center = dvec3_from(l->center);
    dvec3 n = dvec3_normalize(dvec3_sub(dvec3_from(l->at), center));
    dvec3 level = dvec3_cross((dvec3){0, 1, 0}, n);
    level = dvec3_length(level) > 1e-6 ? dvec3_normalize(level) : (dvec3){1, 0, 0};
    double height = (double)(l->height > 0 ? l->height : l->width);
    dvec3 u = dvec3_scale(level, (double)l->width);
    dvec3 v = dvec3_scale(dvec3_cross(n, level), height);
    return (sides){dvec3_sub(center, dvec3_scale(dvec3_add(u, v), 0.5)), u, v};
}

static double area(const quad_light_desc *l) {
    sides s = sides_of(l);
    return dvec3_length(dvec3_cross(s.u, s.v));
}

static snell_status check(const void *desc) {
    const quad_light_desc *l = desc;
    if (!(l->width > 0) && l->height > 0)
        return error_set(SNELL_ERR_ARGUMENT, "give the width too",
                         "light.quad: 'height' without 'width'");
    if (l->width > 0 && !(dvec3_length(dvec3_sub(dvec3_from(l->at), dvec3_from(l->center))) > 0))
        return error_set(SNELL_ERR_ARGUMENT, "move one of them",
                         "light.quad: 'center' and 'at' are the same point");
    sides s = sides_of(l);
    if (!(dvec3_length(dvec3_cross(s.u, s.v)) > 0))
        return error_set(SNELL_ERR_ARGUMENT, "corner, u, v; or center, at, width, height",
                         "light.quad: its sides span no area");
    return surface_light_check("quad", l->power, area(l));
}

static snell_status shape(const void *desc, light_shape *out) {
    const quad_light_desc *l = desc;
    sides s = sides_of(l);
    const snell_param params[] = {vec3_param("corner", vec3_from(s.corner)),
                                  vec3_param("u", vec3_from(s.u)), vec3_param("v", vec3_from(s.v))};
    out->radiance = surface_light_radiance(l->radiance, l->power, area(l));
    out->visible = l->visible;
    return surface_light_shape("quad", params, 3, out);
}

static dvec3 power(const light *l, double scene_radius) {
    (void)scene_radius;
    const quad_light_desc *desc = l->desc;
    return surface_light_power(desc->radiance, desc->power, area(desc));
}

const light_type light_quad = {
    .info =
        TYPE_INFO_EITHER(CATEGORY_LIGHT, quad_light, "quad", "a rectangle that shines to one side",
                         "corner u v|center at width height;radiance|power"),
    .check = check,
    .shape = shape,
    .power = power,
    .casts_shadow = true,
};
