/* From one colour to another along a line. */
#include "base/error.h"
#include "textures/texture.h"

#define GRADIENT_FIELDS(F, T)                                                                      \
    F(T, color_a, COLOR, DEFAULT(0, 0, 0), NOT_NEGATIVE, "", "at 'from' and before it")            \
    F(T, color_b, COLOR, DEFAULT(1, 1, 1), NOT_NEGATIVE, "", "at 'to' and beyond it")              \
    F(T, from, VEC3, DEFAULT(0, 0, 0), ANY, "m", "in u, v, 0 where map says so")                   \
    F(T, to, VEC3, DEFAULT(0, 1, 0), ANY, "m", "by default along v, or up")                        \
    F(T, wrap, CHOICE, DEFAULT(0), CHOICES("clamp|repeat|mirror"), "", "beyond 'from' and 'to'")   \
    F(T, map, CHOICE, DEFAULT(0), CHOICES(MAP_CHOICES), "",                                        \
      "auto: the shape's own u, v, else the point in object space")
DESCRIBE(gradient, GRADIENT_FIELDS)

enum { WRAP_CLAMP, WRAP_REPEAT, WRAP_MIRROR };

static snell_status check(const void *desc) {
    const gradient_desc *g = desc;
    dvec3 way = dvec3_sub(dvec3_from(g->to), dvec3_from(g->from));
    if (dvec3_dot(way, way) > 0) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "move one of them",
                     "gradient: 'from' and 'to' are the same point");
}

static texel evaluate(const texture *t, const texture_point *point) {
    const gradient_desc *g = t->desc;
    double width;
    dvec3 from = dvec3_from(g->from), way = dvec3_sub(dvec3_from(g->to), from);
    dvec3 p = dvec3_sub(texture_solid(t->map, point, &width), from);
    double part = dvec3_dot(p, way) / dvec3_dot(way, way);
    if (g->wrap == WRAP_REPEAT) part -= floor(part);
    if (g->wrap == WRAP_MIRROR) {
        part = part / 2 - floor(part / 2);
        part = part < 0.5 ? 2 * part : 2 - 2 * part;
    }
    part = clamp01(part);
    return (texel){dvec3_add(dvec3_scale(dvec3_from(g->color_a), 1 - part),
                             dvec3_scale(dvec3_from(g->color_b), part)),
                   1};
}

const texture_type texture_gradient = {
    .info = TYPE_INFO(CATEGORY_TEXTURE, gradient, "gradient", "from one colour to another"),
    .check = check,
    .evaluate = evaluate,
};
