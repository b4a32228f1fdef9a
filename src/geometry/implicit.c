/* Where a formula in x, y, z is below 0, within a box: solid, and closed by the box's faces where it
 * is cut (`capped`). What counts as inside is f < 0; NaN is outside. The formula is in expression.h;
 * how rays find the surface, and what they may miss, in level_set.h: bounds come from interval
 * arithmetic. Where those are wide (sums of many terms that cancel) a stated bound of the gradient
 * helps: `lipschitz` = 1 for a distance. It is believed, after a look at some thousand points. */
#include <stdlib.h>

#include "base/error.h"
#include "base/memory.h"
#include "geometry/expression.h"
#include "geometry/level_set.h"

#define IMPLICIT_FIELDS(F, T)                                                                      \
    F(T, f, STRING, NO_DEFAULT, REQUIRED, "",                                                      \
      "formula in x, y, z: \"x^2 + y^2 + z^2 - 1\"; solid where below 0")                          \
    F(T, min, VEC3, NO_DEFAULT, REQUIRED, "m", "the lowest corner of the box it lies in")          \
    F(T, max, VEC3, NO_DEFAULT, REQUIRED, "m", "the highest corner")                               \
    F(T, capped, BOOL, DEFAULT(1), ANY, "", "closed by the faces of the box where that cuts it")   \
    F(T, lipschitz, FLOAT, DEFAULT(0), NOT_NEGATIVE, "",                                           \
      "f changes by at most this per metre: 1 for distances; 0: not known")
DESCRIBE(implicit, IMPLICIT_FIELDS)

/* What rays are traced against: begins with the description. */
typedef struct prepared {
    implicit_desc desc;
    expression *f;
    dvec3 middle, half;
    double size;
} prepared;

static dvec3 middle(const void *shape) { return ((const prepared *)shape)->middle; }
static double size(const void *shape) { return ((const prepared *)shape)->size; }

static void *prepare(const void *desc) {
    const implicit_desc *implicit = desc;
    prepared *made = memory_zeroed(1, sizeof *made);
    if (made == NULL) return NULL;
    if (expression_create("implicit: 'f'", implicit->f, &made->f)) {
        free(made);
        return NULL;
    }
    dvec3 low = dvec3_from(implicit->min), high = dvec3_from(implicit->max);
    made->desc = *implicit;
    made->half = dvec3_scale(dvec3_sub(high, low), 0.5);
    made->middle = dvec3_add(low, made->half);
    made->size = dvec3_length(made->half);
    return made;
}

static size_t prepared_size(const void *desc) {
    (void)desc;
    return sizeof(prepared) + expression_size;
}

static void release(void *shape) {
    expression_destroy(((prepared *)shape)->f);
    free(shape);
}

/* ---- checking ---- */

static const dvec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* Points spread evenly: the R3 sequence of Roberts (2018), steps by the powers of 1/1.2207... */
static snell_status check_lipschitz(const implicit_desc *implicit, const expression *f) {
    enum { POINTS = 4096 };
    dvec3 low = dvec3_from(implicit->min), high = dvec3_from(implicit->max);
    for (int i = 1; i <= POINTS; i++) {
        const double steps[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
        double part[3], g[3];
        for (int k = 0; k < 3; k++) part[k] = i * steps[k] - floor(i * steps[k]);
        dvec3 p = {low.x + (high.x - low.x) * part[0], low.y + (high.y - low.y) * part[1],
                   low.z + (high.z - low.z) * part[2]};
        double value = expression_at(f, p, axes, 3, g),
               slope = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
        if (!(isfinite(value) && slope > (double)implicit->lipschitz * (1 + 1e-6))) continue;
        return error_set(SNELL_ERR_ARGUMENT, "give the largest slope of f, or none",
                         "implicit: 'lipschitz' is %g, but f changes by %.3g per metre at "
                         "(%.3g, %.3g, %.3g)",
                         (double)implicit->lipschitz, slope, p.x, p.y, p.z);
    }
    return SNELL_OK;
}

static snell_status check(const void *desc) {
    const implicit_desc *implicit = desc;
    snell_status status = surface_check_box("implicit", implicit->min, implicit->max);
    if (status) return status;
    expression *f = NULL;
    status = expression_create("implicit: 'f'", implicit->f, &f);
    if (!status && implicit->lipschitz > 0) status = check_lipschitz(implicit, f);
    expression_destroy(f);
    return status;
}

/* Piece number i of `count` between low and high. */
static interval piece(float low, float high, int i, int count) {
    double from = (double)low, size = (double)high - from;
    return interval_wider(from + size * i / count, from + size * (i + 1) / count, 4);
}

/* The formula's bounds in 8 x 8 x 8 pieces of the box: mostly one of the first says that it is not
 * so. */
static const char *nothing(const void *desc) {
    enum { PIECES = 8 };
    const implicit_desc *implicit = desc;
    vec3 a = implicit->min, b = implicit->max;
    expression *f = NULL;
    if (expression_create("implicit: 'f'", implicit->f, &f)) return NULL;
    bool outside = true, inside = !implicit->capped;
    for (int i = 0; i < PIECES * PIECES * PIECES && (outside || inside); i++) {
        const interval box[3] = {piece(a.x, b.x, i % PIECES, PIECES),
                                 piece(a.y, b.y, i / PIECES % PIECES, PIECES),
                                 piece(a.z, b.z, i / (PIECES * PIECES), PIECES)};
        expression_range found;
        expression_over(f, box, NULL, 0, &found);
        outside = outside && (found.undefined || found.value.low >= 0);
        inside = inside && found.value.high < 0 && !found.undefined_somewhere;
    }
    expression_destroy(f);
    if (outside) return "is nowhere below 0 in its box";
    return inside ? "is below 0 in all of its box, which is not capped" : NULL;
}

static bounds3 bounds(const void *desc) {
    const implicit_desc *implicit = desc;
    return (bounds3){implicit->min, implicit->max};
}

/* ---- the function along a ray ---- */

static double value_at(const void *shape, const level_line *line, double s, double *slope) {
    const prepared *implicit = shape;
    return expression_at(implicit->f, dvec3_add(implicit->middle, level_line_at(line, s)), &line->d,
                         1, slope);
}

static interval along(double middle, double o, double d, interval s) {
    return interval_add(interval_point(middle),
                        interval_add(interval_point(o), interval_scale(s, d)));
}

static void look(const prepared *implicit, const level_line *line, interval s,
                 expression_range *out) {
    dvec3 m = implicit->middle, o = line->o, d = line->d;
    const interval box[3] = {along(m.x, o.x, d.x, s), along(m.y, o.y, d.y, s),
                             along(m.z, o.z, d.z, s)};
    expression_over(implicit->f, box, &d, 1, out);
}

/* The formula's own bounds, and if they do not decide, what f in the middle and the slope allow. */
static void range_over(const void *shape, const level_line *line, double low, double high,
                       level_range *out) {
    const prepared *implicit = shape;
    expression_range found, centre;
    look(implicit, line, (interval){low, high}, &found);
    double most = implicit->desc.lipschitz;
    out->defined = !found.undefined_somewhere;
    out->value = found.undefined ? interval_point(1) : found.value;
    out->slope = found.derivatives[0];
    if (found.undefined || out->value.low >= 0) return;
    if (!out->defined || out->value.high < 0) return;
    if (most > 0) out->slope = interval_both(out->slope, (interval){-most, most});
    if (out->slope.low > 0 || out->slope.high < 0) return;
    if (!(interval_magnitude(out->slope) < INFINITY)) return;
    double s = (low + high) / 2;
    look(implicit, line, interval_point(s), &centre);
    interval reach = interval_outward(low - s, high - s);
    interval by_slope = interval_add(centre.value, interval_mul(out->slope, reach));
    out->value = interval_both(out->value, by_slope);
}

static const level_function function = {value_at, range_over};

/* ---- the box ---- */

typedef struct box_crossing {
    double s;
    int face; /* 2 axis + (upper) */
} box_crossing;

static bool cross_box(const prepared *implicit, const level_line *line, box_crossing *in,
                      box_crossing *out) {
    const double o[3] = {line->o.x, line->o.y, line->o.z};
    const double d[3] = {line->d.x, line->d.y, line->d.z};
    const double half[3] = {implicit->half.x, implicit->half.y, implicit->half.z};
    *in = (box_crossing){-INFINITY, 0};
    *out = (box_crossing){INFINITY, 0};
    for (int axis = 0; axis < 3; axis++) {
        if (d[axis] == 0) {
            if (!(fabs(o[axis]) <= half[axis])) return false;
            continue;
        }
        bool forward = d[axis] > 0;
        double near = ((forward ? -half[axis] : half[axis]) - o[axis]) / d[axis];
        double far = ((forward ? half[axis] : -half[axis]) - o[axis]) / d[axis];
        if (near > in->s) *in = (box_crossing){near, 2 * axis + !forward};
        if (far < out->s) *out = (box_crossing){far, 2 * axis + forward};
    }
    return in->s < out->s;
}

/* The part of a crossing is 0 for the formula, 1 + face for the box. */
static void walk(const void *shape, const level_line *line, double from, double to,
                 level_visit *visit, void *user) {
    const prepared *implicit = shape;
    box_crossing in, out;
    if (!cross_box(implicit, line, &in, &out)) return;
    level_stretch where = {in.s, out.s, from, to};
    bool capped = implicit->desc.capped, inside;
    double slope;
    if (!(in.s < to && out.s > from)) return;
    if (capped && in.s >= from && value_at(shape, line, in.s, &slope) < 0 &&
        !visit(user, in.s, true, 1 + in.face))
        return;
    if (level_isolate(&function, shape, line, where, 0x1p-24 * implicit->size, &inside, visit,
                      user) &&
        capped && inside && out.s <= to)
        visit(user, out.s, false, 1 + out.face);
}

static double gradient_at(const void *shape, dvec3 p, dvec3 *gradient) {
    const prepared *implicit = shape;
    double g[3];
    double value = expression_at(implicit->f, dvec3_add(implicit->middle, p), axes, 3, g);
    *gradient = (dvec3){g[0], g[1], g[2]};
    return value;
}

/* By intervals: the formula's own rounding, and that of the points. */
static double noise_at(const void *shape, dvec3 p) {
    const prepared *implicit = shape;
    dvec3 m = implicit->middle;
    const double at[3] = {m.x + p.x, m.y + p.y, m.z + p.z};
    interval box[3];
    for (int i = 0; i < 3; i++) {
        double step = 8 * DOUBLE_EPSILON * (implicit->size + fabs(at[i]));
        box[i] = (interval){at[i] - step, at[i] + step};
    }
    expression_range found;
    expression_over(implicit->f, box, NULL, 0, &found);
    return found.undefined_somewhere ? INFINITY : found.value.high - found.value.low;
}

static const level_shape kind = {middle, size, walk, gradient_at, noise_at};

static bool intersect(const void *shape, const local_ray *beam, hit *found) {
    return level_intersect(&kind, shape, beam, found);
}

static int spans(const void *shape, const local_ray *beam, span *out, int capacity) {
    if (!((const prepared *)shape)->desc.capped) return -1;
    return level_spans(&kind, shape, beam, out, capacity);
}

static dvec3 into_box(const prepared *implicit, dvec3 p) {
    dvec3 low = dvec3_from(implicit->desc.min), high = dvec3_from(implicit->desc.max);
    return (dvec3){double_min(double_max(p.x, low.x), high.x),
                   double_min(double_max(p.y, low.y), high.y),
                   double_min(double_max(p.z, low.z), high.z)};
}

static surface surface_of_face(const prepared *implicit, int face, dvec3 p) {
    const vec3 corner = face & 1 ? implicit->desc.max : implicit->desc.min;
    dvec3 at = into_box(implicit, p), n = {0, 0, 0};
    double upper = face & 1 ? 1 : -1;
    if (face / 2 == 0) at.x = corner.x, n.x = upper;
    if (face / 2 == 1) at.y = corner.y, n.y = upper;
    if (face / 2 == 2) at.z = corner.z, n.z = upper;
    double magnitude = fabs(at.x) + fabs(at.y) + fabs(at.z) + implicit->size;
    return surface_make(at, n, 64 * DOUBLE_EPSILON * magnitude);
}

static void fill_surface(const void *shape, const local_ray *beam, const hit *found, surface *out) {
    const prepared *implicit = shape;
    if (!(found->v >= 1 && found->v <= 6)) {
        level_surface(&kind, shape, beam, found, out);
        out->p = into_box(implicit, out->p); /* the gradient may have led a rounding out of it */
        return;
    }
    level_line line = {.speed = 1};
    level_line_make(beam, implicit->middle, &line);
    dvec3 p = dvec3_add(implicit->middle, level_hit_point(&line, found));
    *out = surface_of_face(implicit, (int)found->v - 1, p);
}

static void parametrise(const void *shape, surface *s) { level_parametrise(middle(shape), s); }

static int side(const void *shape, dvec3 p) {
    const prepared *implicit = shape;
    dvec3 low = dvec3_from(implicit->desc.min), high = dvec3_from(implicit->desc.max);
    bool held = implicit->desc.capped && p.x > low.x && p.x < high.x && p.y > low.y &&
                p.y < high.y && p.z > low.z && p.z < high.z;
    return held && expression_at(implicit->f, p, NULL, 0, NULL) < 0 ? 1 : -1;
}

extern const primitive_type primitive_implicit;
const primitive_type primitive_implicit = {
    .info = TYPE_INFO(CATEGORY_SHAPE, implicit, "implicit",
                      "where a formula in x, y, z is below 0; distance fields too"),
    .check = check,
    .nothing = nothing,
    .bounds = bounds,
    .prepare = prepare,
    .prepared_size = prepared_size,
    .release = release,
    .intersect = intersect,
    .surface = fill_surface,
    .parametrise = parametrise,
    .side = side,
    .spans = spans,
};
