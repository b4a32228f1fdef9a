/* The filled Julia set of q -> q^2 + c in quaternions, cut by the three-dimensional space whose fourth
 * coordinate is `slice`: x is the real part, y and z the first two imaginary ones (Hart, Sandin,
 * Kauffman, Ray Tracing Deterministic 3-D Fractals, SIGGRAPH 1989). Solid: the points that after
 * `iterations` steps have not gone further than `escape` from the origin. That is a polynomial's level
 * set, so it has an exact surface and normal, and more iterations show more of the fractal.
 *
 * Hart's estimate |q| log|q| / (2 |q'|) of the distance to the set is a bound for complex numbers;
 * here, balls do: if q lies within r of m, then q^2 lies within 2 |m| r + r^2 of m^2, as |a b| =
 * |a| |b| in quaternions. Followed through the steps that bounds where a whole stretch of a ray goes,
 * and, with its derivative in the same way, how fast: what level_isolate asks for. */
#include <stdlib.h>

#include "base/error.h"
#include "base/memory.h"
#include "geometry/level_set.h"

#define JULIA_FIELDS(F, T)                                                                         \
    F(T, c, VEC3, DEFAULT(-0.2f, 0.6f, 0.2f), RANGE(-100, 100), "",                                \
      "the constant: real part, i, j")                                                             \
    F(T, c_k, FLOAT, DEFAULT(0.2f), RANGE(-100, 100), "", "its fourth part, k")                    \
    F(T, slice, FLOAT, DEFAULT(0), RANGE(-100, 100), "m", "the fourth coordinate of the cut")      \
    F(T, iterations, INT, DEFAULT(9), RANGE(1, 60), "", "steps of q -> q^2 + c: the detail")       \
    F(T, escape, FLOAT, DEFAULT(0), NOT_NEGATIVE, "m",                                             \
      "how far a point may go; 0: as far as is sure never to come back")
DESCRIBE(julia, JULIA_FIELDS)

typedef struct quaternion {
    double r, i, j, k;
} quaternion;

typedef struct prepared {
    julia_desc desc;
    quaternion c;
    double slice, escape, size;
    int iterations;
} prepared;

static double length_of(quaternion q) {
    return sqrt(q.r * q.r + q.i * q.i + q.j * q.j + q.k * q.k);
}
static double dot_of(quaternion a, quaternion b) {
    return a.r * b.r + a.i * b.i + a.j * b.j + a.k * b.k;
}
/* q^2 + c */
static quaternion next_of(quaternion q, quaternion c) {
    double v2 = q.i * q.i + q.j * q.j + q.k * q.k;
    return (quaternion){q.r * q.r - v2 + c.r, 2 * q.r * q.i + c.i, 2 * q.r * q.j + c.j,
                        2 * q.r * q.k + c.k};
}
/* q a + a q, the derivative of q^2 where q changes by a; the cross products cancel. */
static quaternion slope_of(quaternion q, quaternion a) {
    return (quaternion){2 * (q.r * a.r - q.i * a.i - q.j * a.j - q.k * a.k),
                        2 * (q.r * a.i + a.r * q.i), 2 * (q.r * a.j + a.r * q.j),
                        2 * (q.r * a.k + a.r * q.k)};
}

/* ---- the description ---- */

static double size_of_c(const julia_desc *julia) {
    return length_of((quaternion){julia->c.x, julia->c.y, julia->c.z, julia->c_k});
}

/* Beyond this |q^2 + c| >= |q|^2 - |c| > |q|: it never comes back. */
static double escape_of(const julia_desc *julia) {
    double sure = (1 + sqrt(1 + 4 * size_of_c(julia))) / 2;
    return julia->escape > 0 ? julia->escape : double_max(sure * (1 + 0x1p-40), 2);
}

static snell_status check(const void *desc) {
    const julia_desc *julia = desc;
    double sure = (1 + sqrt(1 + 4 * size_of_c(julia))) / 2;
    if (!(julia->escape > 0) || julia->escape > sure) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "0 stands for a distance that will do",
                     "julia: 'escape' is %g; with this constant it must be greater than %g",
                     (double)julia->escape, sure);
}

/* Of the ball about the origin that holds it: |q|^2 <= |q^2 + c| + |c|, backwards from the last step.
 * 0: the slice is beyond. */
static double radius_of(const julia_desc *julia) {
    double c = size_of_c(julia), r = escape_of(julia), slice = julia->slice;
    for (int n = 0; n < julia->iterations; n++) r = sqrt(r + c);
    r *= 1 + 0x1p-40;
    return r > fabs(slice) ? sqrt(r * r - slice * slice) * (1 + 0x1p-40) : 0;
}

static bounds3 bounds(const void *desc) {
    double r = radius_of(desc);
    return r > 0 ? bounds3_outward((dvec3){-r, -r, -r}, (dvec3){r, r, r}) : bounds3_empty();
}

static void *prepare(const void *desc) {
    const julia_desc *julia = desc;
    prepared *made = memory_zeroed(1, sizeof *made);
    if (made == NULL) return NULL;
    *made = (prepared){.desc = *julia,
                       .c = {julia->c.x, julia->c.y, julia->c.z, julia->c_k},
                       .slice = julia->slice,
                       .escape = escape_of(julia),
                       .size = radius_of(julia),
                       .iterations = julia->iterations};
    return made;
}

static size_t prepared_size(const void *desc) {
    (void)desc;
    return sizeof(prepared);
}

static dvec3 middle(const void *shape) {
    (void)shape;
    return (dvec3){0, 0, 0};
}
static double size(const void *shape) { return ((const prepared *)shape)->size; }

/* ---- |q|^2 - escape^2 after the last step ---- */

/* With its slopes along the directions; where it has grown beyond all use the steps end. */
static double follow(const prepared *julia, dvec3 p, const dvec3 *along, int count,
                     double *slopes) {
    const double far = 1e60;
    quaternion q = {p.x, p.y, p.z, julia->slice}, a[3];
    for (int k = 0; k < count; k++) a[k] = (quaternion){along[k].x, along[k].y, along[k].z, 0};
    for (int n = 0; n < julia->iterations && dot_of(q, q) < far; n++) {
        for (int k = 0; k < count; k++) a[k] = slope_of(q, a[k]);
        q = next_of(q, julia->c);
    }
    for (int k = 0; k < count; k++) slopes[k] = 2 * dot_of(q, a[k]);
    return dot_of(q, q) - julia->escape * julia->escape;
}

static double value_at(const void *shape, const level_line *line, double s, double *slope) {
    return follow(shape, level_line_at(line, s), &line->d, 1, slope);
}

static double gradient_at(const void *shape, dvec3 p, dvec3 *gradient) {
    const dvec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double g[3], value = follow(shape, p, axes, 3, g);
    *gradient = (dvec3){g[0], g[1], g[2]};
    return value;
}

/* ---- balls ---- */

#define ROUNDING                                                                                   \
    0x1p-49 /* of one step, relative: more than its few roundings, and the radius' own */

/* Where a ball goes in all steps. */
typedef enum fate { FATE_UNKNOWN, FATE_ESCAPES, FATE_STAYS } fate;

typedef struct ball {
    quaternion m;
    double length, radius; /* |m| */
} ball;

static ball first_ball(const prepared *julia, dvec3 p, double radius) {
    quaternion q = {p.x, p.y, p.z, julia->slice};
    double length = length_of(q);
    return (ball){q, length, radius + ROUNDING * (length + julia->size)};
}

static ball next_ball(const ball *b, quaternion c, double size_of_c) {
    ball next = {.m = next_of(b->m, c)};
    double grown = (2 * b->length + b->radius) * b->radius;
    next.radius = grown + ROUNDING * (b->length * b->length + size_of_c + grown);
    next.length = length_of(next.m);
    return next;
}

static fate follow_ball(const prepared *julia, dvec3 p, double radius, ball *last) {
    double c = length_of(julia->c), sure = julia->escape * (1 + ROUNDING);
    ball b = first_ball(julia, p, radius);
    for (int n = 0;; n++) {
        if (b.length * (1 - ROUNDING) - b.radius > sure) return FATE_ESCAPES;
        if (n == julia->iterations) break;
        if (b.radius > b.length + sure) return FATE_UNKNOWN; /* it will only grow */
        b = next_ball(&b, julia->c, c);
    }
    *last = b;
    bool stays = (b.length + b.radius) * (1 + ROUNDING) < julia->escape;
    return stays ? FATE_STAYS : FATE_UNKNOWN;
}

/* How fast |q|^2 may change along the ray: the derivative in a ball of its own. */
static interval slope_over(const prepared *julia, const level_line *line, double s, double radius) {
    double c = length_of(julia->c), spread = ROUNDING;
    ball b = first_ball(julia, level_line_at(line, s), radius);
    quaternion a = {line->d.x, line->d.y, line->d.z, 0};
    for (int n = 0; n < julia->iterations; n++) {
        double along = length_of(a);
        spread = 2 * (b.length * spread + along * b.radius + b.radius * spread);
        spread += ROUNDING * (spread + 2 * b.length * along);
        a = slope_of(b.m, a);
        b = next_ball(&b, julia->c, c);
    }
    double along = length_of(a), wide = b.length * spread + along * b.radius + b.radius * spread;
    wide += ROUNDING * (wide + b.length * along);
    double slope = dot_of(b.m, a);
    return interval_outward(2 * (slope - wide), 2 * (slope + wide));
}

static void range_over(const void *shape, const level_line *line, double low, double high,
                       level_range *out) {
    const prepared *julia = shape;
    double s = (low + high) / 2, radius = interval_up((high - low) / 2);
    ball last = {.radius = INFINITY};
    fate found = follow_ball(julia, level_line_at(line, s), radius, &last);
    *out = (level_range){interval_entire(), interval_entire(), true};
    if (found == FATE_ESCAPES) out->value = interval_point(1);
    if (found == FATE_STAYS) out->value = interval_point(-1);
    if (found == FATE_UNKNOWN && last.radius < julia->escape)
        out->slope = slope_over(julia, line, s, radius);
}

static const level_function function = {value_at, range_over};

static void walk(const void *shape, const level_line *line, double from, double to,
                 level_visit *visit, void *user) {
    const prepared *julia = shape;
    level_stretch where = {.from = from, .to = to};
    bool inside;
    if (!level_line_clip(line, julia->size, &where.low, &where.high)) return;
    if (where.low < to && where.high > from)
        level_isolate(&function, shape, line, where, 0x1p-24 * julia->size, &inside, visit, user);
}

static double noise_at(const void *shape, dvec3 p) {
    const prepared *julia = shape;
    ball last = {.radius = INFINITY};
    follow_ball(julia, p, 0, &last);
    return (2 * last.length + last.radius) * last.radius;
}

static const level_shape kind = {middle, size, walk, gradient_at, noise_at};

static bool intersect(const void *shape, const local_ray *beam, hit *found) {
    return level_intersect(&kind, shape, beam, found);
}

static int spans(const void *shape, const local_ray *beam, span *out, int capacity) {
    return level_spans(&kind, shape, beam, out, capacity);
}

static void fill_surface(const void *shape, const local_ray *beam, const hit *found, surface *out) {
    level_surface(&kind, shape, beam, found, out);
}

static void parametrise(const void *shape, surface *s) { level_parametrise(middle(shape), s); }

static int side(const void *shape, dvec3 p) { return follow(shape, p, NULL, 0, NULL) < 0 ? 1 : -1; }

extern const primitive_type primitive_julia;
const primitive_type primitive_julia = {
    .info = TYPE_INFO(CATEGORY_SHAPE, julia, "julia", "a quaternion Julia set"),
    .check = check,
    .bounds = bounds,
    .prepare = prepare,
    .prepared_size = prepared_size,
    .release = free,
    .intersect = intersect,
    .surface = fill_surface,
    .parametrise = parametrise,
    .side = side,
    .spans = spans,
};
