/* Slow solvers of implicit, blob and julia: the function in long double, written anew in C, looked at
 * in very many places along the ray; sign changes are halved, minima between them searched. */
#ifndef SNELL_TESTS_SHAPES_FIELDS_H
#define SNELL_TESTS_SHAPES_FIELDS_H

#include <stdio.h>

#include "shape_subject.h"

/* A function that is negative inside, of a point in units of the shape's size from its middle. */
typedef real field_fn(const void *user, vec p);

static vec field_gradient(field_fn *f, const void *user, vec p) {
    const real h = 1e-7L;
    return (vec){(f(user, (vec){p.x + h, p.y, p.z}) - f(user, (vec){p.x - h, p.y, p.z})) / (2 * h),
                 (f(user, (vec){p.x, p.y + h, p.z}) - f(user, (vec){p.x, p.y - h, p.z})) / (2 * h),
                 (f(user, (vec){p.x, p.y, p.z + h}) - f(user, (vec){p.x, p.y, p.z - h})) / (2 * h)};
}

/* To first order, which near the surface is enough. */
static real field_distance(field_fn *f, const void *user, vec p) {
    real steep = length(field_gradient(f, user, p));
    return f(user, p) / (steep > 1e-9L ? steep : 1e-9L);
}

static real field_halve(field_fn *f, const void *user, vec o, vec d, real low, real high) {
    bool inside = f(user, plus(o, times(d, low))) < 0;
    for (int n = 0; n < 60; n++) {
        real middle = (low + high) / 2;
        *((f(user, plus(o, times(d, middle))) < 0) == inside ? &low : &high) = middle;
    }
    return (low + high) / 2;
}

/* Where the function is least, or most, between low and high, by thirds. */
static real field_extreme(field_fn *f, const void *user, vec o, vec d, real low, real high,
                          real sign) {
    for (int n = 0; n < 80; n++) {
        real a = low + (high - low) / 3, b = high - (high - low) / 3;
        bool first = sign * f(user, plus(o, times(d, a))) < sign * f(user, plus(o, times(d, b)));
        *(first ? &high : &low) = first ? b : a;
    }
    return (low + high) / 2;
}

/* Nearly along the surface the rounding of a far place is multiplied; too near, nobody can say. */
static void field_root(field_fn *f, const void *user, vec o, vec d, real s, real away, root *out) {
    const real h = 1e-6L;
    real steep = length(field_gradient(f, user, plus(o, times(d, s))));
    real slope = (f(user, plus(o, times(d, s + h))) - f(user, plus(o, times(d, s - h)))) / (2 * h);
    real part = fabsl(slope) / (steep > 0 ? steep : 1);
    *out = (root){s, part < 1e-5L ? 0 : part, 1e-9L + 1e-14L * (1 + away) / part};
}

/* All roots of the line o + s d, |d| = 1, between low and high; away: how many sizes the shape is from
 * the origin. Cells at whose ends there is nearly a root are looked at again, in parts. */
static int field_scan(field_fn *f, const void *user, vec o, vec d, real low, real high, real away,
                      int places, root roots[ROOTS]) {
    enum { PLACES = 200, PARTS = 40 };
    const real h = 1e-7L;
    int count = 0, parts = places > PARTS ? PARTS : PARTS - 1;
    real value[PLACES + 1], slope[PLACES + 1], step = (high - low) / places;
    for (int i = 0; i <= places; i++) {
        real s = low + i * step, ahead = f(user, plus(o, times(d, s + h)));
        value[i] = f(user, plus(o, times(d, s)));
        slope[i] = ahead - value[i];
    }
    for (int i = 0; i < places && count < ROOTS - 4; i++) {
        real s = low + i * step, sign = value[i] < 0 ? -1 : 1;
        if (places >= PARTS && (fabsl(value[i]) < 1e-4L || fabsl(value[i + 1]) < 1e-4L)) {
            root few[ROOTS];
            int found = field_scan(f, user, o, d, s, s + step, away, parts, few);
            for (int k = 0; k < found && count < ROOTS - 4; k++) roots[count++] = few[k];
            continue;
        }
        if ((value[i] < 0) != (value[i + 1] < 0)) {
            real at = field_halve(f, user, o, d, s, s + step);
            field_root(f, user, o, d, at, away, &roots[count++]);
            continue;
        }
        if (sign * slope[i] >= 0 || sign * slope[i + 1] <= 0) continue;
        real extreme = field_extreme(f, user, o, d, s, s + step, sign);
        real least_value = sign * f(user, plus(o, times(d, extreme)));
        if (least_value > 1e-7L) continue;
        if (least_value > -1e-7L) {
            roots[count++] = (root){extreme, 0, 1e-9L}; /* too close to call */
            continue;
        }
        real one = field_halve(f, user, o, d, s, extreme);
        field_root(f, user, o, d, one, away, &roots[count++]);
        real other = field_halve(f, user, o, d, extreme, s + step);
        field_root(f, user, o, d, other, away, &roots[count++]);
    }
    return count;
}

/* The line in the field's own units: where it is nearest to the middle, its unit direction, and how to
 * get back. */
typedef struct field_line {
    vec o, d;
    real start, per_t;
} field_line;

static field_line field_line_of(vec o, vec d, vec middle, real size) {
    real speed = length(d), shift = dot(minus(middle, o), d) / (speed * speed);
    vec at = minus(plus(o, times(d, shift)), middle);
    return (field_line){times(at, 1 / size), times(d, 1 / speed), shift, size / speed};
}

static void field_to_ray(const field_line *line, root *roots, int count) {
    for (int i = 0; i < count; i++) {
        roots[i].t = line->start + roots[i].t * line->per_t;
        roots[i].slack = roots[i].slack * line->per_t + 1e-14L * fabsl(line->start);
    }
}

/* ---- implicit ---- */

typedef struct implicit_like {
    size_t struct_size;
    const char *f;
    vec3 min, max;
    bool capped;
    float lipschitz;
} implicit_like;

/* The formula that was made last, in C. */
static struct {
    int kind;
    vec middle;
    real size, a, b, low, high;
    bool capped;
} formula;

static real least(real a, real b) { return a < b ? a : b; }
static real most(real a, real b) { return a > b ? a : b; }

static real formula_value(const void *user, vec p) {
    (void)user;
    real a = formula.a, b = formula.b, x = p.x, y = p.y, z = p.z;
    switch (formula.kind) {
    case 0: return x * x + y * y + z * z - a + 0.02L * sinl(9 * x) * sinl(9 * y) * cosl(9 * z);
    case 1: return hypotl(hypotl(x, z) - a, y) - b;
    case 2: {
        real box = most(most(fabsl(x), fabsl(y)), fabsl(z)) - a;
        real ball = sqrtl((x - 0.2L) * (x - 0.2L) + y * y + z * z) - b;
        real h = most(1 - fabsl(box - ball) / 0.1L, 0);
        return least(box, ball) - h * h * 0.1L / 4;
    }
    case 3: {
        real wave =
            sinl(8 * x) * cosl(8 * y) + sinl(8 * y) * cosl(8 * z) + sinl(8 * z) * cosl(8 * x);
        return most(fabsl(wave) - 0.5L, x * x + y * y + z * z - a);
    }
    case 4: return expl(-4 * (x * x + y * y)) * a - 1.5L * z * z - 0.1L;
    default: return y - a * atanl(5 * x) / (1 + z * z) + 0.1L * sqrtl(x * x + 0.01L);
    }
}

/* The same, for the library; X, Y, Z are in units of the size from the middle. */
static const char *const formula_texts[] = {
    "X^2 + Y^2 + Z^2 - a + 0.02 * sin(9*X) * sin(9*Y) * cos(9*Z)",
    "length(length(X, Z) - a, Y) - b",
    "smooth_min(max(abs(X), abs(Y), abs(Z)) - a, length(X - 0.2, Y, Z) - b, 0.1)",
    ("max(abs(sin(8*X)*cos(8*Y) + sin(8*Y)*cos(8*Z) + sin(8*Z)*cos(8*X)) - 0.5, X*X + Y*Y + Z*Z - "
     "a)"),
    "exp(-4*(X^2 + Y^2))*a - 1.5*Z^2 - 0.1",
    "Y - a*atan(5*X)/(1 + Z^2) + 0.1*sqrt(X^2 + 0.01)"};
enum { FORMULAS = sizeof formula_texts / sizeof formula_texts[0] };

static void make_implicit(void *desc, dvec3 at, double size) {
    static char text[1024];
    implicit_like *s = desc;
    int kind = formula.kind = (int)(random_bits() % FORMULAS);
    double a = kind == 0 ? between(0.1, 0.2) : kind == 3 ? between(0.1, 0.2) : between(0.2, 0.35);
    double b = kind == 1 ? between(0.05, 0.15) : between(0.2, 0.3), half = between(0.3, 0.5);
    formula.a = a, formula.b = b;
    formula.middle = wide_d(at), formula.size = size;
    snprintf(text, sizeof text,
             "X = (x - %.17g) / %.17g; Y = (y - %.17g) / %.17g; Z = (z - %.17g) / %.17g; "
             "a = %.17g; b = %.17g; ",
             at.x, size, at.y, size, at.z, size, a, b);
    strncat(text, formula_texts[kind], sizeof text - strlen(text) - 1);
    s->f = text;
    dvec3 corner = {half * size, half * size, half * size};
    s->min = vec3_from(dvec3_sub(at, corner));
    s->max = vec3_from(dvec3_add(at, corner));
    s->capped = formula.capped = random_bits() % 4 != 0;
    s->lipschitz = kind == 1 ? (float)(1.0001 / size) : 0;
}

/* In units of the size: how far p is out of the box; the nearest face, if inside. */
static real formula_box(const implicit_like *s, vec p) {
    real low[3] = {s->min.x, s->min.y, s->min.z}, high[3] = {s->max.x, s->max.y, s->max.z};
    real at[3] = {p.x, p.y, p.z},
         middle[3] = {formula.middle.x, formula.middle.y, formula.middle.z};
    real out = -INFINITY;
    for (int i = 0; i < 3; i++) {
        out = most(out, (low[i] - middle[i]) / formula.size - at[i]);
        out = most(out, at[i] - (high[i] - middle[i]) / formula.size);
    }
    return out;
}

static vec formula_point(vec p) { return times(minus(p, formula.middle), 1 / formula.size); }

static int solve_implicit(const void *desc, vec o, vec d, root roots[ROOTS]) {
    const implicit_like *s = desc;
    field_line line = field_line_of(o, d, formula.middle, formula.size);
    real low[3] = {s->min.x, s->min.y, s->min.z}, high[3] = {s->max.x, s->max.y, s->max.z};
    real o_[3] = {o.x, o.y, o.z}, d_[3] = {d.x, d.y, d.z}, in = -INFINITY, out = INFINITY;
    for (int i = 0; i < 3; i++) {
        if (d_[i] == 0) {
            if (o_[i] < low[i] || o_[i] > high[i]) return 0;
            continue;
        }
        real one = (low[i] - o_[i]) / d_[i], other = (high[i] - o_[i]) / d_[i];
        in = most(in, least(one, other));
        out = least(out, most(one, other));
    }
    if (!(in < out)) {
        if (in - out < 1e-9L * line.per_t) /* past a corner */
            roots[0] = (root){in, 0, 1e-9L * line.per_t};
        return in - out < 1e-9L * line.per_t;
    }
    real from = (in - line.start) / line.per_t, to = (out - line.start) / line.per_t;
    int count = field_scan(formula_value, NULL, line.o, line.d, from, to,
                           length(formula.middle) / formula.size, 120, roots);
    for (int end = 0; end < 2 && count < ROOTS; end++) {
        real at = end ? to : from;
        real value = formula_value(NULL, plus(line.o, times(line.d, at)));
        if (s->capped || fabsl(value) < 1e-7L)
            roots[count++] = (root){at, value > -1e-7L && value < 1e-7L ? 0 : -value, 1e-9L};
    }
    field_to_ray(&line, roots, count);
    return count;
}

/* Without caps: to the endless surface. */
static real distance_implicit(const void *desc, vec p) {
    const implicit_like *s = desc;
    vec at = formula_point(p);
    real to_surface = field_distance(formula_value, NULL, at);
    if (s->capped) to_surface = most(to_surface, formula_box(s, at));
    return to_surface * formula.size;
}

/* The box's edge, where the formula bends, and where it is 0 on the box: whichever is nearest. */
static real edge_implicit(const void *desc, vec p) {
    const implicit_like *s = desc;
    vec at = formula_point(p);
    real bend = INFINITY, x = at.x, y = at.y, z = at.z;
    if (formula.kind == 2) {
        real ax = fabsl(x), ay = fabsl(y), az = fabsl(z);
        bend = least(fabsl(ax - ay), least(fabsl(ay - az), fabsl(az - ax)));
    }
    if (formula.kind == 3) {
        real wave =
            sinl(8 * x) * cosl(8 * y) + sinl(8 * y) * cosl(8 * z) + sinl(8 * z) * cosl(8 * x);
        bend = fabsl(fabsl(wave) - 0.5L - (x * x + y * y + z * z - formula.a)) / 20;
    }
    real faces[3] = {fabsl(x), fabsl(y), fabsl(z)},
         half = (s->max.x - s->min.x) / (2 * formula.size);
    int near = 0;
    for (int i = 0; i < 3; i++) near += fabsl(faces[i] - half) < 0.01L;
    real rim =
        near > 1 ? 0
                 : most(fabsl(formula_box(s, at)), fabsl(field_distance(formula_value, NULL, at)));
    return least(bend, rim) * formula.size;
}

/* ---- blob ---- */

typedef struct blob_like {
    size_t struct_size;
    const vec3 *points;
    size_t points_count;
    float radius, strength;
    const vec2 *sizes;
    size_t sizes_count;
    float threshold;
} blob_like;

enum { BALLS = 7 };
static struct {
    vec center[BALLS];
    real radius[BALLS], strength[BALLS], threshold, size;
    vec middle;
} balls;

static real balls_value(const void *user, vec p) {
    (void)user;
    real sum = balls.threshold;
    for (int i = 0; i < BALLS; i++) {
        vec r = minus(p, balls.center[i]);
        real left = 1 - dot(r, r) / (balls.radius[i] * balls.radius[i]);
        if (left > 0) sum -= balls.strength[i] * left * left * left;
    }
    return sum;
}

static void make_blob(void *desc, dvec3 at, double size) {
    static vec3 points[BALLS];
    static vec2 sizes[BALLS];
    blob_like *s = desc;
    balls.middle = wide_d(at);
    balls.size = size;
    for (int i = 0; i < BALLS; i++) {
        points[i] = vec3_from(in_ball(at, 0.3 * size));
        sizes[i].x = (float)(size * between(0.1, 0.4));
        sizes[i].y = (float)(i == 0 ? between(-1, -0.2) : between(0.3, 1.5));
        balls.center[i] = times(minus(wide(points[i]), balls.middle), 1 / balls.size);
        balls.radius[i] = sizes[i].x / balls.size;
        balls.strength[i] = sizes[i].y;
    }
    s->threshold = (float)between(0.1, 0.6);
    balls.threshold = s->threshold;
    s->points = points;
    s->sizes = sizes;
    s->points_count = s->sizes_count = BALLS;
}
static int solve_blob(const void *desc, vec o, vec d, root roots[ROOTS]) {
    (void)desc;
    field_line line = field_line_of(o, d, balls.middle, balls.size);
    real left = 1 - dot(line.o, line.o);
    if (left < 0) return 0;
    int count = field_scan(balls_value, NULL, line.o, line.d, -sqrtl(left), sqrtl(left),
                           length(balls.middle) / balls.size, 200, roots);
    field_to_ray(&line, roots, count);
    return count;
}
static real distance_blob(const void *desc, vec p) {
    (void)desc;
    vec at = times(minus(p, balls.middle), 1 / balls.size);
    return field_distance(balls_value, NULL, at) * balls.size;
}

/* ---- julia ---- */

typedef struct julia_like {
    size_t struct_size;
    vec3 c;
    float c_k, slice;
    int32_t iterations;
    float escape;
} julia_like;

/* A quaternion by the product of any two: (r, v) (s, w) = (r s - v w, r w + s v + v x w). */
static real julia_value(const void *user, vec p) {
    const julia_like *s = user;
    real r = p.x, k = s->slice,
         size2 = s->c.x * (real)s->c.x + s->c.y * (real)s->c.y + s->c.z * (real)s->c.z +
                 s->c_k * (real)s->c_k;
    vec v = {p.y, p.z, k};
    for (int n = 0; n < s->iterations && r * r + dot(v, v) < 1e40L; n++) {
        vec twist = cross(v, v), w = plus(plus(times(v, r), times(v, r)), twist);
        r = r * r - dot(v, v) + s->c.x;
        v = plus(w, (vec){s->c.y, s->c.z, s->c_k});
    }
    real escape = most((1 + sqrtl(1 + 4 * sqrtl(size2))) / 2 * (1 + 0x1p-40L), 2);
    if (s->escape > 0) escape = s->escape;
    return logl((r * r + dot(v, v) + 1e-30L) / (escape * escape)) / ldexpl(1, s->iterations);
}
static void make_julia(void *desc, dvec3 at, double size) {
    (void)at, (void)size;
    julia_like *s = desc;
    s->c = vec3_from(dvec3_scale(direction(), between(0, 0.8)));
    s->c_k = (float)between(-0.3, 0.3);
    s->slice = (float)between(-0.2, 0.2);
    s->iterations = 1 + (int)(random_bits() % 4);
    s->escape = random_bits() & 1 ? 0 : 3;
}
static int solve_julia(const void *desc, vec o, vec d, root roots[ROOTS]) {
    field_line line = field_line_of(o, d, (vec){0, 0, 0}, 1);
    real left = 9 - dot(line.o, line.o);
    if (left < 0) return 0;
    int count =
        field_scan(julia_value, desc, line.o, line.d, -sqrtl(left), sqrtl(left), 0, 200, roots);
    field_to_ray(&line, roots, count);
    return count;
}
static real distance_julia(const void *desc, vec p) { return field_distance(julia_value, desc, p); }

static const subject subjects_fields[] = {
    {.name = "implicit",
     .make = make_implicit,
     .solve = solve_implicit,
     .distance = distance_implicit,
     .edge = edge_implicit,
     .winding = true},
    {.name = "blob",
     .make = make_blob,
     .solve = solve_blob,
     .distance = distance_blob,
     .winding = true},
    {.name = "julia",
     .make = make_julia,
     .solve = solve_julia,
     .distance = distance_julia,
     .winding = true,
     .centered = true,
     .fixed_size = 3},
};

#endif
