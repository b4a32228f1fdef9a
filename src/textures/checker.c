/* Squares (cubes, over "object") of two colours. */
#include "textures/texture.h"

#define CHECKER_FIELDS(F, T)                                                                       \
    F(T, color_a, COLOR, DEFAULT(0.8f, 0.8f, 0.8f), NOT_NEGATIVE, "",                              \
      "of the square at the origin")                                                               \
    F(T, color_b, COLOR, DEFAULT(0.1f, 0.1f, 0.1f), NOT_NEGATIVE, "", "of its neighbours")         \
    F(T, size, FLOAT, DEFAULT(1), POSITIVE, "m", "of a square; in u, v where map says so")         \
    F(T, map, CHOICE, DEFAULT(0), CHOICES(MAP_CHOICES), "",                                        \
      "auto: the shape's own u, v, else the point in object space")
DESCRIBE(checker, CHECKER_FIELDS)

static texel evaluate(const void *desc, const texture_point *point) {
    const checker_desc *checker = desc;
    double size = (double)checker->size, cells;
    bool flat = checker->map == MAP_UV || checker->map == MAP_XZ ||
                (checker->map == MAP_AUTO && point->has_uv);
    if (flat) {
        vec2 uv = texture_map(checker->map, point);
        cells = floor((double)uv.x / size) + floor((double)uv.y / size);
    } else {
        /* A point on a face of a cell belongs to the cell under the surface: else rounding would
         * speckle planes that lie on a cell's face. */
        dvec3 p = dvec3_sub(point->local, dvec3_scale(point->n, 1e-4 * size));
        cells = floor(p.x / size) + floor(p.y / size) + floor(p.z / size);
    }
    bool odd = floor(cells / 2) * 2 != cells;
    return (texel){dvec3_from(odd ? checker->color_b : checker->color_a), 1};
}

const texture_type texture_checker = {
    .info = TYPE_INFO(CATEGORY_TEXTURE, checker, "checker", "a chessboard of two colours"),
    .evaluate = evaluate,
};
