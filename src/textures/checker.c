/* Squares (cubes, over "object") of two colours. */
#include "textures/texture.h"

#define CHECKER_FIELDS(F, T)                                                                       \
    F(T, color_a, COLOR, DEFAULT(0.8f, 0.8f, 0.8f), NOT_NEGATIVE, "",                              \
      "of the square at the origin")                                                               \
    F(T, color_b, COLOR, DEFAULT(0.1f, 0.1f, 0.1f), NOT_NEGATIVE, "", "of its neighbours")         \
    F(T, size, FLOAT, DEFAULT(1), POSITIVE, "m", "of a square; in u, v where map says so")         \
    F(T, map, CHOICE, DEFAULT(0), CHOICES(MAP_CHOICES), "",                                        \
      "auto: the shape's own u, v, else the point in object space")                                \
    F(T, filter, BOOL, DEFAULT(0), ANY, "", "average the squares that a sample covers")
DESCRIBE(checker, CHECKER_FIELDS)

/* The mean of a square wave (1 over even squares of side 1, -1 over odd ones) over a width about x:
 * the difference of its integral, a triangle wave. */
static double triangle(double x) {
    double part = x / 2 - floor(x / 2); /* 0..1: an even square, then an odd one */
    return part < 0.5 ? 2 * part : 2 - 2 * part;
}
static double mean_wave(double x, double width) {
    return (triangle(x + width / 2) - triangle(x - width / 2)) / width;
}

static texel mixed(const checker_desc *checker, double wave) {
    dvec3 a = dvec3_from(checker->color_a), b = dvec3_from(checker->color_b);
    double part = clamp01((1 - wave) / 2);
    return (texel){dvec3_add(dvec3_scale(a, 1 - part), dvec3_scale(b, part)), 1};
}

static texel plain(const checker_desc *checker, double cells) {
    bool odd = floor(cells / 2) * 2 != cells;
    return (texel){dvec3_from(odd ? checker->color_b : checker->color_a), 1};
}

/* The footprint's box along an axis; the least one keeps the mean's difference exact enough. */
static double box_width(double dx, double dy, double size) {
    return double_max(double_max(fabs(dx), fabs(dy)) / size, 0x1p-20);
}

static texel look_up(const texture *t, const map_point *at) {
    const checker_desc *checker = t->desc;
    double size = (double)checker->size, u = at->u / size, v = at->v / size;
    if (!checker->filter) return plain(checker, floor(u) + floor(v));
    return mixed(checker, mean_wave(u, box_width(at->dudx, at->dudy, size)) *
                              mean_wave(v, box_width(at->dvdx, at->dvdy, size)));
}

static texel evaluate(const texture *t, const texture_point *point) {
    const checker_desc *checker = t->desc;
    double size = (double)checker->size;
    bool solid = t->map == MAP_OBJECT || (t->map == MAP_AUTO && !point->has_uv);
    if (!solid) return texture_through_map(t, point, look_up);
    /* A point on a face of a cell belongs to the cell under the surface: else rounding would speckle
     * planes that lie on a cell's face. */
    dvec3 p = dvec3_sub(point->local, dvec3_scale(point->n, 1e-4 * size));
    if (!checker->filter)
        return plain(checker, floor(p.x / size) + floor(p.y / size) + floor(p.z / size));
    dvec3 dx = point->dpdx, dy = point->dpdy;
    return mixed(checker, mean_wave(p.x / size, box_width(dx.x, dy.x, size)) *
                              mean_wave(p.y / size, box_width(dx.y, dy.y, size)) *
                              mean_wave(p.z / size, box_width(dx.z, dy.z, size)));
}

static bool filters(const void *desc) { return ((const checker_desc *)desc)->filter; }

const texture_type texture_checker = {
    .info = TYPE_INFO(CATEGORY_TEXTURE, checker, "checker", "a chessboard of two colours"),
    .filters = filters,
    .evaluate = evaluate,
};
