/* Slow solvers of capsule, ellipsoid, quadric and superellipsoid. */
#ifndef SNELL_TESTS_SHAPES_ANALYTIC_H
#define SNELL_TESTS_SHAPES_ANALYTIC_H

#include "shape_subject.h"

/* ---- capsule: two spheres and a tube ---- */

typedef struct capsule_like {
    size_t struct_size;
    vec3 from, to;
    float radius;
} capsule_like;

static void make_capsule(void *desc, dvec3 at, double size) {
    capsule_like *s = desc;
    double half = size * between(0.05, 0.3);
    dvec3 axis = dvec3_scale(random_bits() & 1 ? (dvec3){0, 1, 0} : direction(), half);
    s->from = vec3_from(dvec3_sub(at, axis));
    s->to = vec3_from(dvec3_add(at, axis));
    s->radius = (float)(size * between(0.05, 0.25));
}
static real distance_capsule(const void *desc, vec p) {
    const capsule_like *s = desc;
    vec axis = minus(wide(s->to), wide(s->from)), f = minus(p, wide(s->from));
    real along = dot(f, axis) / dot(axis, axis);
    along = along < 0 ? 0 : along > 1 ? 1 : along;
    return length(minus(f, times(axis, along))) - s->radius;
}
/* Where |o + t d| = r, if the place along the axis (0 to 1 on the tube) is where this part is. */
static int solve_capsule_part(const capsule_like *s, int part, vec o, vec d, root *roots) {
    vec axis = minus(wide(s->to), wide(s->from));
    vec f = minus(o, wide(part == 2 ? s->to : s->from)), e = d;
    real square = dot(axis, axis), r = s->radius;
    if (part == 1) {
        f = minus(f, times(axis, dot(f, axis) / square));
        e = minus(d, times(axis, dot(d, axis) / square));
        if (dot(e, e) < 1e-30L * dot(d, d)) return 0;
    }
    real nearest = -dot(f, e) / dot(e, e);
    vec at = plus(f, times(e, nearest));
    real discriminant = r * r - dot(at, at);
    real half = discriminant > 0 ? sqrtl(discriminant / dot(e, e)) : 0;
    int count = 0;
    for (int i = 0; i < 2; i++) {
        real t = nearest + (i ? half : -half);
        vec p = minus(plus(o, times(d, t)), wide(s->from));
        real place = dot(p, axis) / square;
        bool here = part == 0   ? place <= 1e-9L
                    : part == 2 ? place >= 1 - 1e-9L
                                : place >= -1e-9L && place <= 1 + 1e-9L;
        if (here) roots[count++] = (root){t, discriminant / (r * r), 1e-9L * r / length(d)};
    }
    return count;
}
static int solve_capsule(const void *desc, vec o, vec d, root roots[ROOTS]) {
    const capsule_like *s = desc;
    vec middle = times(plus(wide(s->from), wide(s->to)), 0.5L);
    real shift = dot(minus(middle, o), d) / dot(d, d);
    o = plus(o, times(d, shift));
    int count = 0;
    for (int part = 0; part < 3; part++) count += solve_capsule_part(s, part, o, d, roots + count);
    for (int i = 0; i < count; i++) roots[i].t += shift;
    return count;
}

/* ---- ellipsoid: a sphere in other units ---- */

typedef struct ellipsoid_like {
    size_t struct_size;
    vec3 center, radii;
} ellipsoid_like;

static vec over(vec a, vec3 b) { return (vec){a.x / b.x, a.y / b.y, a.z / b.z}; }

static void make_ellipsoid(void *desc, dvec3 at, double size) {
    ellipsoid_like *s = desc;
    s->center = vec3_from(at);
    s->radii.x = (float)(size * between(0.05, 0.5));
    s->radii.y = (float)(size * between(0.05, 0.5));
    s->radii.z = (float)(size * between(0.05, 0.5));
}
static int solve_ellipsoid(const void *desc, vec o, vec d, root roots[ROOTS]) {
    const ellipsoid_like *s = desc;
    o = over(minus(o, wide(s->center)), s->radii);
    d = over(d, s->radii);
    real middle = -dot(o, d) / dot(d, d);
    vec nearest = plus(o, times(d, middle));
    real margin = 1 - dot(nearest, nearest);
    real half = margin > 0 ? sqrtl(margin / dot(d, d)) : 0, slack = 1e-9L / length(d);
    roots[0] = (root){middle - half, margin, slack};
    roots[1] = (root){middle + half, margin, slack};
    return 2;
}
/* To first order, which near the surface is enough. */
static real distance_ellipsoid(const void *desc, vec p) {
    const ellipsoid_like *s = desc;
    vec at = over(minus(p, wide(s->center)), s->radii);
    real norm = length(at);
    return norm > 0 ? (norm - 1) * norm / length(over(at, s->radii)) : -(real)s->radii.x;
}

/* ---- quadric: its polynomial ---- */

typedef struct quadric_like {
    size_t struct_size;
    vec3 square, mixed, linear;
    float constant;
    vec3 min, max;
} quadric_like;

static real quadric_value(const quadric_like *s, vec p) {
    real squares = s->square.x * p.x * p.x + s->square.y * p.y * p.y + s->square.z * p.z * p.z;
    real mixed = s->mixed.x * p.x * p.y + s->mixed.y * p.x * p.z + s->mixed.z * p.y * p.z;
    return squares + mixed + dot(wide(s->linear), p) + s->constant;
}
static vec quadric_gradient(const quadric_like *s, vec p) {
    return (vec){2 * s->square.x * p.x + s->mixed.x * p.y + s->mixed.y * p.z + s->linear.x,
                 2 * s->square.y * p.y + s->mixed.x * p.x + s->mixed.z * p.z + s->linear.y,
                 2 * s->square.z * p.z + s->mixed.y * p.x + s->mixed.z * p.y + s->linear.z};
}

/* One of the nine kinds, turned, moved and multiplied by something; the ellipsoid is often whole. */
static void make_quadric(void *desc, dvec3 at, double size) {
    static const double kinds[][5] = {/* of x^2, y^2, z^2, y, 1 */
                                      {1, 1, 1, 0, -1},  {1, 1, 1, 0, -1},  {-1, -1, -1, 0, 1},
                                      {1, -1, 1, 0, -1}, {1, -1, 1, 0, 1},  {1, -1, 1, 0, 0},
                                      {1, 0, 1, -1, 0},  {1, 0, -1, -1, 0}, {1, 0, 1, 0, -1},
                                      {1, 0, 0, 1, 0},   {0, 0, 0, 1, 0}};
    quadric_like *s = desc;
    const double *kind = kinds[random_bits() % 11];
    dvec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          center = dvec3_add(at, dvec3_scale(direction(), 0.1 * size));
    if (random_bits() & 1) {
        axis[1] = direction();
        dvec3_frame(axis[1], &axis[2], &axis[0]);
    }
    double factor = between(0.2, 5) / (size * size), m[3][3] = {{0}}, g[3] = {0},
           constant = kind[4];
    for (int k = 0; k < 3; k++) {
        double r = size * between(0.1, 0.3), scale = kind[k] / (r * r);
        const double a[3] = {axis[k].x, axis[k].y, axis[k].z};
        double offset = dvec3_dot(axis[k], center), slope = k == 1 ? kind[3] / r : 0;
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) m[i][j] += scale * a[i] * a[j];
            g[i] += (slope - 2 * scale * offset) * a[i];
        }
        constant += scale * offset * offset - slope * offset;
    }
    factor *= size * size;
    s->square = vec3_from(dvec3_scale((dvec3){m[0][0], m[1][1], m[2][2]}, factor));
    s->mixed = vec3_from(dvec3_scale((dvec3){m[0][1], m[0][2], m[1][2]}, 2 * factor));
    s->linear = vec3_from(dvec3_scale((dvec3){g[0], g[1], g[2]}, factor));
    s->constant = (float)(factor * constant);
    double half = size * between(0.2, 0.5);
    s->min = vec3_from(dvec3_add(at, (dvec3){-half, -half * 0.8, -half * 0.9}));
    s->max = vec3_from(dvec3_add(at, (dvec3){half * 0.95, half, half}));
}
static real quadric_size(const quadric_like *s) {
    return length(minus(wide(s->max), wide(s->min)));
}
static vec quadric_middle(const quadric_like *s) {
    return times(plus(wide(s->min), wide(s->max)), 0.5L);
}
/* How large Q's terms may be within the box; as they are given, and about the box's middle. */
static real quadric_terms(const quadric_like *s) {
    vec a = wide(s->square), b = wide(s->mixed), c = wide(s->linear);
    real size = quadric_size(s) + length(quadric_middle(s));
    return (length(a) + length(b)) * size * size + length(c) * size + fabsl(s->constant);
}
static real quadric_terms_about(const quadric_like *s) {
    vec a = wide(s->square), b = wide(s->mixed), middle = quadric_middle(s);
    real size = quadric_size(s), slope = length(quadric_gradient(s, middle));
    return (length(a) + length(b)) * size * size + slope * size + fabsl(quadric_value(s, middle));
}
static int solve_quadric(const void *desc, vec o, vec d, root roots[ROOTS]) {
    const quadric_like *s = desc;
    vec middle = quadric_middle(s);
    real shift = dot(minus(middle, o), d) / dot(d, d), size = quadric_size(s);
    o = plus(o, times(d, shift));
    if (length(minus(o, middle)) > 2 * size) return 0;
    real a = dot(quadric_gradient(s, d), d) / 2 - dot(wide(s->linear), d) / 2;
    real b = dot(quadric_gradient(s, o), d) / 2, c = quadric_value(s, o);
    real discriminant = b * b - a * c;
    real steep = quadric_terms_about(s) / size * length(d);
    real tangent = discriminant / (steep * steep);
    real half = sqrtl(fmaxl(discriminant, 0)), q = b > 0 ? -b - half : half - b;
    const real t[2] = {a != 0 ? q / a : INFINITY, q != 0 ? c / q : a != 0 ? q / a : INFINITY};
    real slack = 1e-9L * size / length(d) + 1e-14L * quadric_terms(s) / fmaxl(half, 1e-9L * steep);
    int count = 0;
    for (int n = 0; n < 2; n++) {
        if (!isfinite(t[n])) continue;
        vec p = plus(o, times(d, t[n]));
        real in[7] = {tangent,        p.x - s->min.x, s->max.x - p.x, p.y - s->min.y,
                      s->max.y - p.y, p.z - s->min.z, s->max.z - p.z};
        real margin = in[0];
        for (int i = 1; i < 7; i++) margin = fminl(margin, in[i] / size);
        roots[count++] = (root){t[n] + shift, margin, slack};
    }
    return count;
}
/* Negative definite, by the minors: a shape that would face inwards. */
static bool quadric_is_negative(const quadric_like *s) {
    real a = s->square.x, b = s->square.y, c = s->square.z;
    real d = s->mixed.x / 2.0L, e = s->mixed.y / 2.0L, f = s->mixed.z / 2.0L;
    real all = a * b * c + 2 * d * e * f - a * f * f - b * e * e - c * d * d;
    return a < 0 && a * b - d * d > 0 && all < 0;
}
static real distance_quadric(const void *desc, vec p) {
    const quadric_like *s = desc;
    return (quadric_is_negative(s) ? -1 : 1) * quadric_value(s, p) / length(quadric_gradient(s, p));
}
/* Far from the origin its terms nearly cancel. */
static real blur_quadric(const void *desc, vec p) {
    const quadric_like *s = desc;
    return 0x1p-48L * quadric_terms(s) / length(quadric_gradient(s, p));
}
/* From the tip of a cone, where the gradient is 0. */
static real edge_quadric(const void *desc, vec p) {
    const quadric_like *s = desc;
    vec g = quadric_gradient(s, p);
    real steep = fabsl(s->square.x) + fabsl(s->square.y) + fabsl(s->square.z);
    return steep > 0 ? length(g) / (2 * steep) : INFINITY;
}

/* ---- superellipsoid: its formula, which is convex; a search for the least value, then halving ---- */

typedef struct superellipsoid_like {
    size_t struct_size;
    vec3 center, radii;
    float e1, e2;
} superellipsoid_like;

static void make_superellipsoid(void *desc, dvec3 at, double size) {
    const float choices[8] = {0.05f, 0.1f, 0.3f, 1, 1.5f, 2, 0.6f, 1.1f};
    superellipsoid_like *s = desc;
    make_ellipsoid(desc, at, size);
    s->e1 = choices[random_bits() % 8];
    s->e2 = choices[random_bits() % 8];
}
/* Several times as quick as powl, and exact enough: exponents are 40 at most. */
static real power(real x, real y) { return x > 0 ? expl(y * logl(x)) : y == 0; }
static real superellipsoid_norm(const superellipsoid_like *s, vec at) {
    real p = 2 / (real)s->e1, q = 2 / (real)s->e2;
    real flat = power(fabsl(at.x), p) + power(fabsl(at.z), p);
    return power(power(flat, q / p) + power(fabsl(at.y), q), 1 / q);
}
static real distance_superellipsoid(const void *desc, vec point) {
    const superellipsoid_like *s = desc;
    real p = 2 / (real)s->e1, q = 2 / (real)s->e2;
    vec at = over(minus(point, wide(s->center)), s->radii);
    real norm = superellipsoid_norm(s, at);
    if (!(norm > 0)) return -(real)s->radii.x;
    vec on = times(at, 1 / norm);
    real flat = power(power(fabsl(on.x), p) + power(fabsl(on.z), p), q / p - 1);
    if (on.x == 0 && on.z == 0) flat = 0;
    vec g = {flat * power(fabsl(on.x), p - 1), power(fabsl(on.y), q - 1),
             flat * power(fabsl(on.z), p - 1)};
    return (norm - 1) / length(over(g, s->radii));
}
/* The same in double along the line o + t d; by exp and log, as pow is the library's own. */
static double power_quick(double x, double y) { return x > 0 ? exp(y * log(x)) : 0; }
static double superellipsoid_quick(const superellipsoid_like *s, vec o, vec d, real t) {
    const double at = (double)t, p = 2 / (double)s->e1, q = 2 / (double)s->e2;
    double x = fabs((double)o.x + at * (double)d.x), y = fabs((double)o.y + at * (double)d.y),
           z = fabs((double)o.z + at * (double)d.z);
    double flat = power_quick(x, p) + power_quick(z, p);
    return power_quick((p == q ? flat : power_quick(flat, q / p)) + power_quick(y, q), 1 / q);
}
/* Where the norm is least, or any place at which it is clearly below 1, by golden sections. */
static real superellipsoid_inside(const superellipsoid_like *s, vec o, vec d, real reach) {
    const real golden = (sqrtl(5) - 1) / 2;
    real low = -reach, high = reach;
    real one = high - golden * (high - low), other = low + golden * (high - low);
    double value = superellipsoid_quick(s, o, d, one);
    double value_other = superellipsoid_quick(s, o, d, other);
    for (int i = 0; i < 46 && (value < value_other ? value : value_other) > 1 - 1e-6; i++) {
        if (value < value_other) {
            high = other, other = one, value_other = value;
            one = high - golden * (high - low);
            value = superellipsoid_quick(s, o, d, one);
        } else {
            low = one, one = other, value = value_other;
            other = low + golden * (high - low);
            value_other = superellipsoid_quick(s, o, d, other);
        }
    }
    return value < value_other ? one : other;
}
/* Halved in double, whose rounding does not decide: in long double where it is close. */
static real superellipsoid_edge(const superellipsoid_like *s, vec o, vec d, real in, real out) {
    for (int i = 0; i < 48; i++) {
        real middle = (in + out) / 2, value = superellipsoid_quick(s, o, d, middle);
        if (fabsl(value - 1) < 1e-12L) value = superellipsoid_norm(s, plus(o, times(d, middle)));
        *(value < 1 ? &in : &out) = middle;
    }
    return in;
}
static int solve_superellipsoid(const void *desc, vec o, vec d, root roots[ROOTS]) {
    const superellipsoid_like *s = desc;
    o = over(minus(o, wide(s->center)), s->radii);
    d = over(d, s->radii);
    real speed = length(d), shift = -dot(o, d) / dot(d, d), reach = 1.75L / speed;
    o = plus(o, times(d, shift));
    if (length(o) > 1.75L) return 0;
    real inside = superellipsoid_inside(s, o, d, reach);
    real margin = 1 - superellipsoid_norm(s, plus(o, times(d, inside)));
    if (margin < 0) {
        roots[0] = (root){inside + shift, margin, 1e-9L / speed};
        return 1;
    }
    for (int k = 0; k < 2; k++) {
        real at = superellipsoid_edge(s, o, d, inside, k ? reach : -reach);
        roots[k] = (root){at + shift, margin, 1e-9L / speed};
    }
    return 2;
}
/* Exponents above 1 make creases where a coordinate is 0. */
static real edge_superellipsoid(const void *desc, vec p) {
    const superellipsoid_like *s = desc;
    vec f = minus(p, wide(s->center));
    return s->e1 > 1 || s->e2 > 1 ? fminl(fabsl(f.x), fminl(fabsl(f.y), fabsl(f.z))) : INFINITY;
}

static const subject subjects_analytic[] = {
    {.name = "capsule", .make = make_capsule, .solve = solve_capsule, .distance = distance_capsule},
    {.name = "ellipsoid",
     .make = make_ellipsoid,
     .solve = solve_ellipsoid,
     .distance = distance_ellipsoid},
    {.name = "quadric",
     .make = make_quadric,
     .solve = solve_quadric,
     .distance = distance_quadric,
     .edge = edge_quadric,
     .blur = blur_quadric,
     .winding = true,
     .centered = true,
     .own_offset = 16},
    {.name = "superellipsoid",
     .make = make_superellipsoid,
     .solve = solve_superellipsoid,
     .distance = distance_superellipsoid,
     .edge = edge_superellipsoid},
};

#endif
