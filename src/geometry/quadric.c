/* A surface of the second degree, within a box:
 *     a x^2 + b y^2 + c z^2 + d xy + e xz + f yz + g x + h y + i z + j = 0
 * with square = {a, b, c}, mixed = {d, e, f}, linear = {g, h, i}, constant = j. It faces where the
 * left side is positive. Nothing closes what the box cuts off; an ellipsoid that the box does not
 * cut is a solid, and faces outwards whatever the signs.
 *
 * Texture coordinates: u around the vertical line through the box's middle, as on a sphere, v from 0
 * at the bottom of the box to 1 at its top. hit.u carries the normal in 24 bits, hit.v the gradient's
 * length, for `bend`. */
#include "base/error.h"
#include "geometry/by_lines.h"
#include "maths/functions.h"

#define QUADRIC_FIELDS(F, T)                                                                       \
    F(T, square, VEC3, DEFAULT(0, 0, 0), ANY, "", "the factors of x^2, y^2 and z^2")               \
    F(T, mixed, VEC3, DEFAULT(0, 0, 0), ANY, "", "the factors of xy, xz and yz")                   \
    F(T, linear, VEC3, DEFAULT(0, 0, 0), ANY, "", "the factors of x, y and z")                     \
    F(T, constant, FLOAT, DEFAULT(0), ANY, "", "what is added: the sum is 0 on the surface")       \
    F(T, min, VEC3, DEFAULT(-1, -1, -1), ANY, "m", "the box's smallest coordinates")               \
    F(T, max, VEC3, DEFAULT(1, 1, 1), ANY, "m", "the box's largest coordinates")
DESCRIBE(quadric, QUADRIC_FIELDS)

extern const primitive_type primitive_quadric;

/* The quadric about the middle of its box: Q(middle + x) = x M x + linear x + constant, where the rows
 * of M are xx, xy, xz; xy, yy, yz; xz, yz, zz. */
typedef struct form {
    double xx, yy, zz, xy, xz, yz;
    dvec3 linear;
    double constant;
    dvec3 middle, half; /* of the box */
    double slack;       /* m; what lies so far outside of the box counts as inside */
} form;

static dvec3 times_matrix(const form *f, dvec3 v) {
    return (dvec3){f->xx * v.x + f->xy * v.y + f->xz * v.z, f->xy * v.x + f->yy * v.y + f->yz * v.z,
                   f->xz * v.x + f->yz * v.y + f->zz * v.z};
}
static double value_at(const form *f, dvec3 x) {
    return dvec3_dot(x, dvec3_add(times_matrix(f, x), f->linear)) + f->constant;
}
static dvec3 gradient_at(const form *f, dvec3 x) {
    return dvec3_add(dvec3_scale(times_matrix(f, x), 2), f->linear);
}
static double determinant(const form *f) {
    return f->xx * (f->yy * f->zz - f->yz * f->yz) - f->xy * (f->xy * f->zz - f->yz * f->xz) +
           f->xz * (f->xy * f->yz - f->yy * f->xz);
}

static form form_of(const void *desc) {
    const quadric_desc *q = desc;
    dvec3 low = dvec3_from(q->min), high = dvec3_from(q->max);
    form f = {q->square.x,
              q->square.y,
              q->square.z,
              (double)q->mixed.x / 2,
              (double)q->mixed.y / 2,
              (double)q->mixed.z / 2,
              dvec3_from(q->linear),
              q->constant,
              dvec3_scale(dvec3_add(low, high), 0.5),
              dvec3_scale(dvec3_sub(high, low), 0.5),
              0};
    f.slack =
        0x1p-40 * (dvec3_largest(f.half) + fabs(f.middle.x) + fabs(f.middle.y) + fabs(f.middle.z));
    double constant = value_at(&f, f.middle);
    f.linear = gradient_at(&f, f.middle);
    f.constant = constant;
    /* By Sylvester's criterion of -M: then the ellipsoid would face inwards. */
    if (f.xx < 0 && f.xx * f.yy - f.xy * f.xy > 0 && determinant(&f) < 0) {
        f.xx = -f.xx, f.yy = -f.yy, f.zz = -f.zz;
        f.xy = -f.xy, f.xz = -f.xz, f.yz = -f.yz;
        f.linear = dvec3_negate(f.linear);
        f.constant = -f.constant;
    }
    return f;
}

static snell_status check(const void *desc) {
    const quadric_desc *q = desc;
    const vec3 sets[3] = {q->square, q->mixed, q->linear};
    bool any = false;
    for (int i = 0; i < 3; i++) any = any || sets[i].x != 0 || sets[i].y != 0 || sets[i].z != 0;
    if (any) return surface_check_box("quadric", q->min, q->max);
    return error_set(SNELL_ERR_ARGUMENT,
                     "a sphere is quadric { square = {1, 1, 1}, constant = -1 }",
                     "quadric: all of 'square', 'mixed' and 'linear' are 0");
}

/* By the middle's value and the most that each term can change it within the box. */
static const char *nothing(const void *desc) {
    form f = form_of(desc);
    double x = f.half.x + f.slack, y = f.half.y + f.slack, z = f.half.z + f.slack;
    double sway = fabs(f.linear.x) * x + fabs(f.linear.y) * y + fabs(f.linear.z) * z +
                  2 * (fabs(f.xy) * x * y + fabs(f.xz) * x * z + fabs(f.yz) * y * z);
    double low = f.constant - sway, high = f.constant + sway, rounding = 0;
    const double squares[3] = {f.xx * x * x, f.yy * y * y, f.zz * z * z};
    for (int i = 0; i < 3; i++) {
        low += double_min(squares[i], 0);
        high += double_max(squares[i], 0);
        rounding += fabs(squares[i]);
    }
    rounding = 0x1p-40 * (rounding + sway + fabs(f.constant));
    return low > rounding || high < -rounding ? "does not reach into its box" : NULL;
}

static bounds3 bounds(const void *desc) {
    form f = form_of(desc);
    dvec3 half = dvec3_add(f.half, (dvec3){f.slack, f.slack, f.slack});
    return bounds3_outward(dvec3_sub(f.middle, half), dvec3_add(f.middle, half));
}

/* ---- rays ---- */

/* The part of the line, from the middle, within the box. */
static bool clip(const form *f, dvec3 o, dvec3 d, double *low, double *high) {
    const double from[3] = {o.x, o.y, o.z}, way[3] = {d.x, d.y, d.z};
    const double half[3] = {f->half.x, f->half.y, f->half.z};
    *low = -INFINITY;
    *high = INFINITY;
    for (int i = 0; i < 3; i++) {
        double size = half[i] + f->slack;
        if (way[i] == 0) {
            if (!(fabs(from[i]) <= size)) return false;
            continue;
        }
        double one = (-size - from[i]) / way[i], other = (size - from[i]) / way[i];
        *low = double_max(*low, double_min(one, other));
        *high = double_min(*high, double_max(one, other));
    }
    return *low <= *high;
}

/* Up to two roots in ascending order. The origin is moved to the line's point nearest to the middle,
 * then to the vertex of the quadratic, if that is near: there the linear term vanishes, and the
 * constant one, Q itself, says without cancelling how far the ray is from being tangent. */
static int solve(const form *f, const local_ray *beam, double t[2]) {
    dvec3 d = dvec3_from(beam->d), o = dvec3_sub(dvec3_from(beam->o), f->middle);
    double square = dvec3_dot(d, d), shift = -dvec3_dot(o, d) / square, low, high;
    o = dvec3_add(o, dvec3_scale(d, shift));
    if (!(square > 0) || !clip(f, o, d, &low, &high)) return 0;
    double a = dvec3_dot(d, times_matrix(f, d)), b = dvec3_dot(d, gradient_at(f, o)) / 2;
    double reach = 4 * dvec3_length(f->half), vertex = 0;
    if (a != 0 && b * b * square <= reach * reach * a * a) {
        vertex = -b / a; /* if it is farther away no ray is tangent within the box */
        o = dvec3_add(o, dvec3_scale(d, vertex));
        b = dvec3_dot(d, gradient_at(f, o)) / 2;
    }
    double c = value_at(f, o), discriminant = b * b - a * c;
    if (!(discriminant >= 0)) return 0;
    double root = sqrt(discriminant), q = b > 0 ? -(b + root) : root - b;
    double one = a != 0 ? q / a : INFINITY, other = q != 0 ? c / q : one;
    const double roots[2] = {double_min(one, other), double_max(one, other)};
    int count = 0;
    for (int i = 0; i < 2; i++) {
        double at = vertex + roots[i];
        if (at >= low && at <= high) t[count++] = shift + at;
    }
    return count;
}

/* The point of the line at t, from the middle. */
static dvec3 point_at(const form *f, const local_ray *beam, double t) {
    dvec3 o = dvec3_sub(dvec3_from(beam->o), f->middle);
    return dvec3_add(o, dvec3_scale(dvec3_from(beam->d), t));
}

/* What `bend` needs to know, in the two floats of a hit: 12 bits each for the two coordinates of the
 * folded normal, and the gradient's length. */
static void note_gradient(const form *f, const local_ray *beam, double t, float *u, float *v) {
    dvec3 g = gradient_at(f, point_at(f, beam, t));
    float x, y;
    *u = *v = 0;
    if (!(dvec3_dot(g, g) > 0)) return;
    surface_fold(g, &x, &y);
    double column = floor((x + 1.0) * 2047.5), row = floor((y + 1.0) * 2047.5);
    *u = (float)(4096 * column + row);
    *v = (float)dvec3_length(g);
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    form f = form_of(desc);
    double t[2];
    int count = solve(&f, beam, t);
    for (int i = 0; i < count; i++) {
        if (!surface_accept(beam, t[i], &found->t)) continue;
        note_gradient(&f, beam, t[i], &found->u, &found->v);
        return true;
    }
    return false;
}

/* ---- points ---- */

/* H dp / |g| without its part along n: how the normal turns. H is 2 M. */
static dvec3 normal_turn(const form *f, dvec3 n, double gradient, dvec3 dp) {
    dvec3 change = dvec3_scale(times_matrix(f, dp), 2 / gradient);
    return dvec3_sub(change, dvec3_scale(n, dvec3_dot(n, change)));
}

/* The larger one of both curvatures' sizes: eigenvalues of the turn in the tangent plane. */
static double curvature_at(const form *f, dvec3 n, double gradient) {
    dvec3 x, y;
    dvec3_frame(n, &x, &y);
    dvec3 turn_x = normal_turn(f, n, gradient, x), turn_y = normal_turn(f, n, gradient, y);
    double xx = dvec3_dot(x, turn_x), xy = dvec3_dot(x, turn_y), yy = dvec3_dot(y, turn_y);
    double half = (xx - yy) / 2;
    return fabs(xx + yy) / 2 + sqrt(half * half + xy * xy);
}

/* By how much rounding may change Q at x, where its terms cancel. */
static double rounding_at(const form *f, dvec3 x) {
    dvec3 size = {fabs(x.x) + fabs(f->middle.x), fabs(x.y) + fabs(f->middle.y),
                  fabs(x.z) + fabs(f->middle.z)};
    form positive = {fabs(f->xx),
                     fabs(f->yy),
                     fabs(f->zz),
                     fabs(f->xy),
                     fabs(f->xz),
                     fabs(f->yz),
                     {fabs(f->linear.x), fabs(f->linear.y), fabs(f->linear.z)},
                     fabs(f->constant),
                     {0, 0, 0},
                     {0, 0, 0},
                     0};
    return 16 * DOUBLE_EPSILON * value_at(&positive, size);
}

/* The surface near x, which is from the middle: one step of Newton's method along the gradient. At
 * the tip of a cone there is none. */
static void surface_at(const form *f, dvec3 x, dvec3 away, surface *out) {
    double size = dvec3_length(f->half) + fabs(f->middle.x) + fabs(f->middle.y) + fabs(f->middle.z);
    dvec3 g = gradient_at(f, x);
    double square = dvec3_dot(g, g), rounding = rounding_at(f, x);
    if (square > 0) {
        dvec3 step = dvec3_scale(g, value_at(f, x) / square);
        if (dvec3_length(step) < 0x1p-20 * size) {
            x = dvec3_sub(x, step);
            g = gradient_at(f, x);
        }
    }
    double length = dvec3_length(g);
    dvec3 p = dvec3_add(f->middle, x), n = dvec3_normalize(g);
    if (!(length > 0)) {
        *out = surface_make(p, dvec3_normalize(away), 0x1p-20 * size);
        return;
    }
    double curvature = curvature_at(f, n, length), error = rounding / length;
    /* Near a tip the surface is at most where Q has curved to what rounding makes of it. */
    if (!(error * curvature <= 1)) error = sqrt(rounding / (curvature * length));
    *out =
        surface_make(p, n, 32 * DOUBLE_EPSILON * size + error + surface_shift_error(p, curvature));
    out->curvature = curvature;
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    form f = form_of(desc);
    double roots[2], t = found->t;
    int count = solve(&f, beam, roots);
    if (count == 1) t = roots[0];
    if (count == 2) t = fabs(roots[0] - t) <= fabs(roots[1] - t) ? roots[0] : roots[1];
    surface_at(&f, point_at(&f, beam, t), dvec3_negate(dvec3_from(beam->d)), out);
}

/* Steps in the tangent plane: level, for u, and without turning about the vertical line, for v. */
static void parametrise(const void *desc, surface *s) {
    form f = form_of(desc);
    dvec3 x = dvec3_sub(s->p, f.middle), n = s->n;
    double ring = x.x * x.x + x.z * x.z, height = 2 * f.half.y;
    s->u = 0.5 + fn_atan2(x.x, x.z) / (2 * PI);
    s->v = clamp01(0.5 + x.y / height);
    dvec3 level = {-n.z, 0, n.x};          /* n x (0, 1, 0) */
    double facing = n.x * x.x + n.z * x.z; /* level . (-z, 0, x): 0 on a floor */
    if (!(ring > 0) || !(fabs(facing) > 0x1p-40 * sqrt(ring))) return;
    s->dpdu = dvec3_scale(level, -2 * PI * ring / facing);
    /* (x, 0, z) k + (0, 1, 0) is tangent. */
    double k = -n.y / facing;
    s->dpdv = dvec3_scale((dvec3){k * x.x, 1, k * x.z}, height);
}

static dvec3 bend(const void *desc, const hit *found, dvec3 dp) {
    form f = form_of(desc);
    if (!(found->v > 0)) return (dvec3){0, 0, 0};
    double packed = found->u, column = floor(packed / 4096), row = packed - 4096 * column;
    dvec3 n =
        surface_unfold((float)((column + 0.5) / 2047.5 - 1), (float)((row + 0.5) / 2047.5 - 1));
    return normal_turn(&f, n, found->v, dp);
}

/* ---- inside ---- */

/* Is it an ellipsoid that the box does not cut? Its centre is where the gradient is 0, -M^-1 linear /
 * 2, and with k = -Q there it reaches sqrt(k (M^-1)_ii) along axis i. */
static bool is_closed(const form *f) {
    double xx = f->yy * f->zz - f->yz * f->yz, yy = f->xx * f->zz - f->xz * f->xz;
    double zz = f->xx * f->yy - f->xy * f->xy, all = determinant(f);
    if (!(f->xx > 0 && zz > 0 && all > 0)) return false;
    form inverse = {xx / all,
                    yy / all,
                    zz / all,
                    (f->xz * f->yz - f->xy * f->zz) / all,
                    (f->xy * f->yz - f->xz * f->yy) / all,
                    (f->xy * f->xz - f->xx * f->yz) / all,
                    {0, 0, 0},
                    0,
                    {0, 0, 0},
                    {0, 0, 0},
                    0};
    dvec3 center = dvec3_scale(times_matrix(&inverse, f->linear), -0.5);
    double k = -value_at(f, center);
    if (!(k > 0)) return false;
    const double c[3] = {center.x, center.y, center.z}, half[3] = {f->half.x, f->half.y, f->half.z};
    const double reach[3] = {sqrt(k * inverse.xx), sqrt(k * inverse.yy), sqrt(k * inverse.zz)};
    for (int i = 0; i < 3; i++)
        if (!(fabs(c[i]) + reach[i] <= half[i] + f->slack)) return false;
    return true;
}

static int side(const void *desc, dvec3 p) {
    form f = form_of(desc);
    return is_closed(&f) && value_at(&f, dvec3_sub(p, f.middle)) < 0 ? 1 : -1;
}

static int spans(const void *desc, const local_ray *beam, span *out, int capacity) {
    form f = form_of(desc);
    double t[2];
    surface_crossing ends[2];
    if (!is_closed(&f)) return -1;
    if (solve(&f, beam, t) != 2) return 0;
    for (int i = 0; i < 2; i++) {
        ends[i] = (surface_crossing){.t = t[i]};
        note_gradient(&f, beam, t[i], &ends[i].u, &ends[i].v);
    }
    return surface_add_span(out, 0, capacity, ends[0], ends[1]);
}

static double area(const void *desc, uint32_t primitive) {
    (void)primitive;
    return by_lines_area(&primitive_quadric, desc, 256);
}

static void sample_area(const void *desc, uint32_t primitive, double u, double v, surface *out) {
    (void)primitive;
    by_lines_sample(&primitive_quadric, desc, 2, u, v, out);
}

const primitive_type primitive_quadric = {
    .info = TYPE_INFO(CATEGORY_SHAPE, quadric, "quadric",
                      "a surface of the second degree within a box: hyperboloids, bowls, saddles"),
    .check = check,
    .nothing = nothing,
    .bounds = bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .parametrise = parametrise,
    .bend = bend,
    .side = side,
    .spans = spans,
    .area = area,
    .sample_area = sample_area,
};
