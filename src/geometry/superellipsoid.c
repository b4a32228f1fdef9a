/* A superellipsoid (Barr, Superquadrics and Angle-Preserving Transformations, IEEE CG&A 1(1), 1981):
 *     (|x|^(2/e1) + |z|^(2/e1))^(e1/e2) + |y|^(2/e2) = 1    in units of the radii.
 * With an exponent near 0 the edges around it are sharp, 1 is round, 2 is bevelled: (1, 1) is an
 * ellipsoid, (0.1, 0.1) a box with rounded edges, (1, 0.1) a cylinder, (2, 2) an octahedron. Texture
 * coordinates are those of the sphere around it, seen from the centre. hit.u and hit.v carry the
 * direction from the centre, in units of the radii, for `bend`.
 *
 * With p = 2 / e1 and q = 2 / e2, both at least 1, the left side is N^q with
 *     N(x, y, z) = |(|(x, z)|_p, y)|_q
 * a norm. So N is convex along every line: it equals 1 twice at most, and Newton's method from outside
 * comes ever nearer to a root and never passes it. */
#include "geometry/by_lines.h"
#include "maths/functions.h"

#define SUPERELLIPSOID_FIELDS(F, T)                                                                \
    F(T, center, VEC3, DEFAULT(0, 0, 0), ANY, "m", "the centre")                                   \
    F(T, radii, VEC3, DEFAULT(1, 1, 1), POSITIVE, "m", "half the size along x, y and z")           \
    F(T, e1, FLOAT, DEFAULT(1), RANGE(0.015625, 2), "",                                            \
      "seen from above: 0 a square, 1 round, 2 a diamond")                                         \
    F(T, e2, FLOAT, DEFAULT(1), RANGE(0.015625, 2), "",                                            \
      "seen from the side: 0 a square, 1 round, 2 a diamond")
DESCRIBE(superellipsoid, SUPERELLIPSOID_FIELDS)

extern const primitive_type primitive_superellipsoid;

static dvec3 divide(dvec3 a, dvec3 b) { return (dvec3){a.x / b.x, a.y / b.y, a.z / b.z}; }

static dvec3 radii_of(const superellipsoid_desc *shape) { return dvec3_from(shape->radii); }

static bounds3 bounds(const void *desc) {
    const superellipsoid_desc *shape = desc;
    dvec3 c = dvec3_from(shape->center), r = dvec3_scale(radii_of(shape), 1 + 0x1p-40);
    return bounds3_outward(dvec3_sub(c, r), dvec3_add(c, r));
}

/* ---- the norm ---- */

/* |(a, b)|_p of a, b >= 0, and its derivatives by both. */
typedef struct norm2 {
    double value, by_a, by_b;
} norm2;

static norm2 norm2_at(double a, double b, double p) {
    double large = double_max(a, b), small = double_min(a, b);
    if (!(large > 0)) return (norm2){0, 0, 0};
    double ratio = small / large, power, sum, root;
    if (p == 2) {
        power = ratio;
        sum = 1 + ratio * ratio;
        root = sqrt(sum);
    } else if (p == 1) {
        power = 1;
        sum = root = 1 + ratio;
    } else {
        power = ratio > 0 ? fn_pow(ratio, p - 1) : 0;
        sum = 1 + power * ratio;
        root = fn_pow(sum, 1 / p);
    }
    double by_large = root / sum; /* (large / value)^(p - 1) */
    double by_small = power * by_large;
    bool first = a >= b;
    return (norm2){large * root, first ? by_large : by_small, first ? by_small : by_large};
}

typedef struct exponents {
    double p, q;
} exponents;

static exponents exponents_of(const superellipsoid_desc *shape) {
    return (exponents){2 / (double)shape->e1, 2 / (double)shape->e2};
}

static double sign(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

/* N at x, in units of the radii, and its gradient. */
static double norm_at(exponents e, dvec3 x, dvec3 *gradient) {
    norm2 flat = norm2_at(fabs(x.x), fabs(x.z), e.p), all = norm2_at(flat.value, fabs(x.y), e.q);
    *gradient = (dvec3){all.by_a * flat.by_a * sign(x.x), all.by_b * sign(x.y),
                        all.by_a * flat.by_b * sign(x.z)};
    return all.value;
}

/* ---- rays ---- */

#define STEPS_MAX 100

/* From t outside, where N > 1, towards a root beyond it: sign +1 upwards, -1 downwards. Each step is
 * to where the tangent meets 1, so the root is never passed but by rounding; where N falls no more
 * there is none. */
static bool approach(exponents e, dvec3 o, dvec3 d, double way, double end, double *t) {
    for (int i = 0; i < STEPS_MAX; i++) {
        dvec3 gradient;
        double over = norm_at(e, dvec3_add(o, dvec3_scale(d, *t)), &gradient) - 1;
        double slope = dvec3_dot(gradient, d) * way;
        if (over <= 0) return true;
        if (!(slope < 0)) return false;
        double step = over / -slope;
        *t += way * step;
        if (!((end - *t) * way >= 0)) return false; /* beyond the other root's bound */
        if (step < 0x1p-54) return true;
    }
    return true;
}

/* Both roots and the points there in units of the radii. The line is brought to the unit cube first:
 * d is made unit and its origin moved to where it is nearest to the centre. */
static bool solve(const superellipsoid_desc *shape, const local_ray *beam, double t[2],
                  dvec3 at[2]) {
    exponents e = exponents_of(shape);
    dvec3 radii = radii_of(shape), d = divide(dvec3_from(beam->d), radii);
    dvec3 o = divide(dvec3_sub(dvec3_from(beam->o), dvec3_from(shape->center)), radii);
    double speed = dvec3_length(d);
    if (!(speed > 0)) return false;
    d = dvec3_scale(d, 1 / speed);
    double shift = -dvec3_dot(o, d);
    o = dvec3_add(o, dvec3_scale(d, shift));
    const double from[3] = {o.x, o.y, o.z}, way[3] = {d.x, d.y, d.z};
    double low = -2, high = 2; /* the cube's corners are sqrt(3) away */
    for (int i = 0; i < 3; i++) {
        double size = 1 + 0x1p-44; /* outside, or so near that it does not matter */
        if (way[i] == 0) {
            if (!(fabs(from[i]) <= size)) return false;
            continue;
        }
        double one = (-size - from[i]) / way[i], other = (size - from[i]) / way[i];
        low = double_max(low, double_min(one, other));
        high = double_min(high, double_max(one, other));
    }
    if (!(low <= high)) return false;
    if (!approach(e, o, d, 1, high, &low) || !approach(e, o, d, -1, low, &high)) return false;
    at[0] = dvec3_add(o, dvec3_scale(d, low));
    at[1] = dvec3_add(o, dvec3_scale(d, high));
    t[0] = (shift + low) / speed;
    t[1] = (shift + high) / speed;
    return true;
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    double t[2];
    dvec3 at[2];
    return solve(desc, beam, t, at) && surface_accept_either(beam, t, at, found);
}

/* ---- points ---- */

/* How steeply the derivative of |(a, b)|_p turns: its second derivatives are `turn` w w^T with w = (b,
 * -a) / value. At a flat point 0; where p < 2 it is infinite at a = 0 or b = 0: as good as. */
static double turn_of(double a, double b, double p, norm2 at) {
    if (!(at.value > 0) || p == 1) return 0;
    double x = double_max(a / at.value, 0x1p-60), y = double_max(b / at.value, 0x1p-60);
    double by_x = p == 2 ? 1 : fn_pow(x, p - 2), by_y = p == 2 ? 1 : fn_pow(y, p - 2);
    return (p - 1) * by_x * by_y / at.value;
}

/* The second derivatives of N times v, at x, both in units of the radii: one part each from the outer
 * and the inner norm. */
typedef struct hessian {
    double outer, inner;
    dvec3 outer_w, inner_w;
} hessian;

static hessian hessian_at(exponents e, dvec3 x) {
    dvec3 size = {fabs(x.x), fabs(x.y), fabs(x.z)};
    norm2 flat = norm2_at(size.x, size.z, e.p), all = norm2_at(flat.value, size.y, e.q);
    hessian made = {.outer = turn_of(flat.value, size.y, e.q, all),
                    .inner = all.by_a * turn_of(size.x, size.z, e.p, flat)};
    double up = size.y / all.value, out = flat.value / all.value;
    made.outer_w =
        (dvec3){up * flat.by_a * sign(x.x), -out * sign(x.y), up * flat.by_b * sign(x.z)};
    if (flat.value > 0)
        made.inner_w =
            (dvec3){size.z / flat.value * sign(x.x), 0, -size.x / flat.value * sign(x.z)};
    return made;
}

/* Of the surface in metres: the sum of both curvatures, neither of which is negative, bounds each. */
static double curvature_at(exponents e, dvec3 x, dvec3 radii, dvec3 n, double gradient) {
    hessian h = hessian_at(e, x);
    dvec3 one = divide(h.outer_w, radii), other = divide(h.inner_w, radii);
    one = dvec3_sub(one, dvec3_scale(n, dvec3_dot(n, one)));
    other = dvec3_sub(other, dvec3_scale(n, dvec3_dot(n, other)));
    double sum = (h.outer * dvec3_dot(one, one) + h.inner * dvec3_dot(other, other)) / gradient;
    return double_min(sum, 0x1p40 / dvec3_largest(radii));
}

/* The surface in the direction x from the centre, in units of the radii. */
static void surface_at(const superellipsoid_desc *shape, dvec3 x, surface *out) {
    exponents e = exponents_of(shape);
    dvec3 center = dvec3_from(shape->center), radii = radii_of(shape), gradient;
    double norm = norm_at(e, x, &gradient);
    if (!(norm > 0)) norm = norm_at(e, x = (dvec3){0, 1, 0}, &gradient);
    x = dvec3_scale(x, 1 / norm);
    dvec3 g = divide(gradient, radii), n = dvec3_normalize(g);
    dvec3 p = dvec3_add(center, dvec3_mul(x, radii));
    double curvature = curvature_at(e, x, radii, n, dvec3_length(g));
    double size = 2 * dvec3_largest(radii) + fabs(center.x) + fabs(center.y) + fabs(center.z);
    *out = surface_make(p, n, 64 * DOUBLE_EPSILON * size + surface_shift_error(p, curvature));
    out->curvature = curvature;
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    double t[2];
    dvec3 at[2];
    if (!solve(desc, beam, t, at)) {
        at[0] = at[1] = surface_unfold(found->u, found->v);
        t[0] = t[1] = found->t;
    }
    bool second = fabs(t[1] - found->t) < fabs(t[0] - found->t);
    surface_at(desc, at[second], out);
}

static dvec3 to_unit(const superellipsoid_desc *shape, dvec3 p) {
    return divide(dvec3_sub(p, dvec3_from(shape->center)), radii_of(shape));
}

/* A point of the surface is its direction from the centre over N of that. */
static dvec3 along_surface(dvec3 x, dvec3 gradient, dvec3 turn) {
    return dvec3_sub(turn, dvec3_scale(x, dvec3_dot(gradient, turn)));
}

static void parametrise(const void *desc, surface *s) {
    const superellipsoid_desc *shape = desc;
    dvec3 x = to_unit(shape, s->p), radii = radii_of(shape);
    /* By the normal that is known: where p < 2 the gradient at a rounded point may be another one. */
    dvec3 gradient = dvec3_mul(s->n, radii);
    gradient = dvec3_scale(gradient, 1 / dvec3_dot(gradient, x)); /* Euler: N = gradient . x = 1 */
    surface_globe(s, dvec3_normalize(x), dvec3_length(x));
    s->dpdu = dvec3_mul(along_surface(x, gradient, s->dpdu), radii);
    s->dpdv = dvec3_mul(along_surface(x, gradient, s->dpdv), radii);
}

static dvec3 bend(const void *desc, const hit *found, dvec3 dp) {
    const superellipsoid_desc *shape = desc;
    exponents e = exponents_of(shape);
    dvec3 x = surface_unfold(found->u, found->v), radii = radii_of(shape), gradient;
    x = dvec3_scale(x, 1 / norm_at(e, x, &gradient));
    hessian h = hessian_at(e, x);
    dvec3 g = divide(gradient, radii), n = dvec3_normalize(g), v = divide(dp, radii);
    dvec3 change = dvec3_add(dvec3_scale(h.outer_w, h.outer * dvec3_dot(h.outer_w, v)),
                             dvec3_scale(h.inner_w, h.inner * dvec3_dot(h.inner_w, v)));
    change = dvec3_scale(divide(change, radii), 1 / dvec3_length(g));
    return dvec3_sub(change, dvec3_scale(n, dvec3_dot(n, change)));
}

static int side(const void *desc, dvec3 p) {
    dvec3 gradient;
    return norm_at(exponents_of(desc), to_unit(desc, p), &gradient) < 1 ? 1 : -1;
}

static int spans(const void *desc, const local_ray *beam, span *out, int capacity) {
    double t[2];
    dvec3 at[2];
    surface_crossing ends[2];
    if (!solve(desc, beam, t, at)) return 0;
    for (int i = 0; i < 2; i++) {
        ends[i] = (surface_crossing){.t = t[i]};
        surface_fold(at[i], &ends[i].u, &ends[i].v);
    }
    return surface_add_span(out, 0, capacity, ends[0], ends[1]);
}

/* ---- area ---- */

/* How much of the surface lies over a piece of the unit cube's face, seen from the centre: the point x
 * of the surface is c / N(c), and its derivatives by two coordinates of c are along_surface / N. */
static double area_density(const superellipsoid_desc *shape, int face, double a, double b) {
    const dvec3 corners[3] = {{1, a, b}, {b, 1, a}, {a, b, 1}};
    const dvec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    dvec3 gradient, radii = radii_of(shape), turn[2];
    double norm = norm_at(exponents_of(shape), corners[face], &gradient);
    dvec3 x = dvec3_scale(corners[face], 1 / norm);
    for (int i = 0; i < 2; i++) {
        dvec3 step = along_surface(x, gradient, axes[(face + 1 + i) % 3]);
        turn[i] = dvec3_scale(dvec3_mul(step, radii), 1 / norm);
    }
    return dvec3_length(dvec3_cross(turn[0], turn[1]));
}

/* The sum over an eighth of the cube. What is sharp in the surface lies in its planes of symmetry or,
 * when edges are sharp, where two coordinates are equal: on the borders of the squares, where the
 * substitution s^3 (10 - 15 s + 6 s^2) puts the points close together and their weight to 0. */
static double area(const void *desc, uint32_t primitive) {
    (void)primitive;
    enum { POINTS = 96 };
    double sum = 0, place[POINTS], weight[POINTS];
    for (int i = 0; i < POINTS; i++) {
        double s = (i + 0.5) / POINTS;
        place[i] = s * s * s * (10 - 15 * s + 6 * s * s);
        weight[i] = 30 * s * s * (1 - s) * (1 - s) / POINTS;
    }
    for (int face = 0; face < 3; face++)
        for (int i = 0; i < POINTS; i++)
            for (int k = 0; k < POINTS; k++)
                sum += weight[i] * weight[k] * area_density(desc, face, place[i], place[k]);
    return 8 * sum;
}

static void sample_area(const void *desc, uint32_t primitive, double u, double v, surface *out) {
    (void)primitive;
    by_lines_sample(&primitive_superellipsoid, desc, 2, u, v, out);
}

const primitive_type primitive_superellipsoid = {
    .info = TYPE_INFO(CATEGORY_SHAPE, superellipsoid, "superellipsoid",
                      "between a sphere, a box, a cylinder and an octahedron"),
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
