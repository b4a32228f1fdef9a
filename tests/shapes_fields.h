/* Slow solvers of implicit, blob and julia: the function written anew in C, looked at in very many places
 * along the ray, in double; sign changes are narrowed down and minima between them searched, in long
 * double where it becomes close. */
#ifndef SNELL_TESTS_SHAPES_FIELDS_H
#define SNELL_TESTS_SHAPES_FIELDS_H

#include <stdio.h>
#include <string.h>
#include <tgmath.h>

#include "shape_subject.h"

/* A function that is negative inside, of a point in units of the shape's size from its middle. */
typedef struct field_function {
    real (*value)(const void *user, real x, real y, real z);
    double (*quick)(const void *user, double x, double y, double z);
    const void *user;
    double steep; /* it changes by no more than this per unit; INFINITY: unknown */
} field_function;

static real least(real a, real b) { return a < b ? a : b; }
static real most(real a, real b) { return a > b ? a : b; }

static real field_at(const field_function *f, vec p) { return f->value(f->user, p.x, p.y, p.z); }

static vec field_gradient(const field_function *f, vec p) {
    const real h = 1e-7L, twice = 2 * h;
    return (vec){
        (field_at(f, (vec){p.x + h, p.y, p.z}) - field_at(f, (vec){p.x - h, p.y, p.z})) / twice,
        (field_at(f, (vec){p.x, p.y + h, p.z}) - field_at(f, (vec){p.x, p.y - h, p.z})) / twice,
        (field_at(f, (vec){p.x, p.y, p.z + h}) - field_at(f, (vec){p.x, p.y, p.z - h})) / twice};
}

/* To first order, which near the surface is enough. */
static real field_distance(const field_function *f, vec p) {
    real steep = length(field_gradient(f, p));
    return field_at(f, p) / (steep > 1e-9L ? steep : 1e-9L);
}

/* A ray's line o + s d, |d| = 1, in the field's own units; start, per_t: how to get back. */
typedef struct field_line {
    const field_function *f;
    vec o, d;
    real start, per_t;
    real away; /* how many sizes the shape is from the origin of its coordinates */
} field_line;

static real line_value(const field_line *line, real s) {
    return field_at(line->f, plus(line->o, times(line->d, s)));
}

/* In double, whose rounding is not allowed to decide on a sign. */
static real line_quick(const field_line *line, real s) {
    const double at = (double)s;
    double x = (double)line->o.x + at * (double)line->d.x,
           y = (double)line->o.y + at * (double)line->d.y,
           z = (double)line->o.z + at * (double)line->d.z;
    real value = line->f->quick(line->f->user, x, y, z);
    return fabsl(value) < 1e-10L ? line_value(line, s) : value;
}

/* The change of sign between low and high: the chord's root, and the middle whenever three of those have
 * not halved what is left (an end that stays counts half as much each time). */
static real line_root(const field_line *line, real low, real high) {
    real at_low = line_quick(line, low), at_high = line_quick(line, high);
    real width = high - low;
    bool low_is_inside = at_low < 0;
    for (int n = 1; n < 200 && high - low > 1e-18L; n++) {
        real s = low + (high - low) * (at_low / (at_low - at_high));
        if (n % 3 == 0) {
            if (high - low > width / 2) s = (low + high) / 2;
            width = high - low;
        }
        if (!(s > low && s < high)) s = (low + high) / 2;
        if (!(s > low && s < high)) break;
        real value = line_quick(line, s);
        if (value == 0) return s;
        if ((value < 0) == low_is_inside) {
            low = s, at_low = value;
            at_high /= 2;
        } else {
            high = s, at_high = value;
            at_low /= 2;
        }
    }
    return (low + high) / 2;
}

/* Looks between low and high, where sign * f seems to have its least value, for that or for any place
 * where it is negative, by golden sections. false: it is clearly positive all over. */
static bool line_extreme(const field_line *line, real low, real high, real sign, real *at,
                         real *least_value) {
    const real golden = (sqrtl(5) - 1) / 2, steep = line->f->steep;
    real one = high - golden * (high - low), other = low + golden * (high - low);
    real value = sign * line_quick(line, one), value_other = sign * line_quick(line, other);
    for (int n = 0; n < 60; n++) {
        if (least(value, value_other) < -1e-6L || high - low < 1e-11L) break;
        if (least(value, value_other) - steep * (high - low) > 1e-6L) return false;
        if (value < value_other) {
            high = other, other = one, value_other = value;
            one = high - golden * (high - low);
            value = sign * line_quick(line, one);
        } else {
            low = one, one = other, value = value_other;
            other = low + golden * (high - low);
            value_other = sign * line_quick(line, other);
        }
    }
    *at = value < value_other ? one : other;
    *least_value = sign * line_value(line, *at);
    return true;
}

/* Nearly along the surface the rounding of a far place is multiplied; too near, nobody can say. */
static void field_root(const field_line *line, real s, root *out) {
    const real h = 1e-6L;
    real steep = length(field_gradient(line->f, plus(line->o, times(line->d, s))));
    real slope = (line_value(line, s + h) - line_value(line, s - h)) / (2 * h);
    real part = fabsl(slope) / (steep > 0 ? steep : 1);
    *out = (root){s, part < 1e-5L ? 0 : part, 1e-9L + 1e-14L * (1 + line->away) / part};
}

/* One stretch between two places that were looked at; adds its roots. */
static int line_stretch(const field_line *line, const real s[2], const real value[2],
                        const real slope[2], root *out) {
    real sign = value[0] < 0 ? -1 : 1, extreme, least_value;
    if ((value[0] < 0) != (value[1] < 0)) {
        field_root(line, line_root(line, s[0], s[1]), out);
        return 1;
    }
    if (sign * slope[0] >= 0 || sign * slope[1] <= 0) return 0;
    if (!line_extreme(line, s[0], s[1], sign, &extreme, &least_value)) return 0;
    if (least_value > 1e-9L) return 0;
    if (least_value > -1e-9L) {
        *out = (root){extreme, 0, 1e-9L}; /* too close to call */
        return 1;
    }
    field_root(line, line_root(line, s[0], extreme), &out[0]);
    field_root(line, line_root(line, extreme, s[1]), &out[1]);
    return 2;
}

/* All roots of the line between low and high. Steps are a `places`th of that, or as far as the function
 * cannot reach 0. Where it nearly is 0 the stretch is looked at again, in parts. */
static int field_scan(const field_line *line, real low, real high, int places, root roots[ROOTS]) {
    enum { PARTS = 40 };
    const real h = 1e-7L, steep = line->f->steep, step = (high - low) / places;
    const bool again = places <= PARTS;
    const real close = isfinite(steep) ? most(1e-4L, steep * step / 8) : 1e-4L;
    real s[2] = {low, 0}, value[2] = {line_quick(line, low), 0}, slope[2] = {NAN, NAN};
    int count = 0;
    while (s[0] < high && count < ROOTS - 4) {
        s[1] = s[0] + most(step, fabsl(value[0]) / steep);
        if (s[1] > high - step / 1024) s[1] = high;
        value[1] = line_quick(line, s[1]);
        bool changes = (value[0] < 0) != (value[1] < 0);
        bool far = fabsl(value[0]) + fabsl(value[1]) > steep * (s[1] - s[0]) + 1e-6L;
        bool near = changes || least(fabsl(value[0]), fabsl(value[1])) < close;
        if (!again && near) {
            root few[ROOTS];
            int found = field_scan(line, s[0], s[1], PARTS, few);
            for (int k = 0; k < found && count < ROOTS - 4; k++) roots[count++] = few[k];
        } else if (changes || !far) {
            for (int i = 0; i < 2 && !changes; i++)
                if (isnan(slope[i])) slope[i] = line_quick(line, s[i] + h) - value[i];
            count += line_stretch(line, s, value, slope, roots + count);
        }
        s[0] = s[1], value[0] = value[1], slope[0] = slope[1];
        slope[1] = NAN;
    }
    return count;
}

/* From where it is nearest to the middle. */
static field_line field_line_of(const field_function *f, vec o, vec d, vec middle, real size) {
    real speed = length(d), shift = dot(minus(middle, o), d) / (speed * speed);
    vec at = minus(plus(o, times(d, shift)), middle);
    return (field_line){f,     times(at, 1 / size), times(d, 1 / speed),
                        shift, size / speed,        length(middle) / size};
}

/* What is thinner than the resolution that level_set.h states, as at the rim of an edge, may be missed. */
static void field_to_ray(const field_line *line, root *roots, int count) {
    for (int i = 1; i < count; i++)
        if (fabsl(roots[i].t - roots[i - 1].t) < 4e-7L) roots[i].margin = roots[i - 1].margin = 0;
    for (int i = 0; i < count; i++) {
        roots[i].t = line->start + roots[i].t * line->per_t;
        roots[i].slack = roots[i].slack * line->per_t + 1e-14L * fabsl(line->start);
    }
}

/* ---- descriptions, and the functions in two precisions ---- */

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

typedef struct julia_like {
    size_t struct_size;
    vec3 c;
    float c_k, slice;
    int32_t iterations;
    float escape;
} julia_like;
static real julia_escape_squared;

#define NUMBER double
#define NAMED(name) name##_quick
#include "field_values.h"
#define NUMBER real
#define NAMED(name) name
#include "field_values.h"

/* ---- implicit ---- */

/* Its text for the library; X, Y, Z are in units of the size from the middle. */
static const char *const formula_texts[] = {
    "X^2 + Y^2 + Z^2 - a + 0.02 * sin(9*X) * sin(9*Y) * cos(9*Z)",
    "length(length(X, Z) - a, Y) - b",
    "smooth_min(max(abs(X), abs(Y), abs(Z)) - a, length(X - 0.2, Y, Z) - b, 0.1)",
    ("max(abs(sin(8*X)*cos(8*Y) + sin(8*Y)*cos(8*Z) + sin(8*Z)*cos(8*X)) - 0.5, X*X + Y*Y + Z*Z - "
     "a)"),
    "exp(-4*(X^2 + Y^2))*a - 1.5*Z^2 - 0.1",
    "Y - a*atan(5*X)/(1 + Z^2) + 0.1*sqrt(X^2 + 0.01)"};
enum { FORMULAS = sizeof formula_texts / sizeof formula_texts[0] };

static field_function formula_field = {formula_value, formula_value_quick, NULL, INFINITY};

/* Of every kind within half a size along each axis, for the a and b below 0.35. A product of three sines
 * is a sum of four waves of a quarter, whose gradients are 9 sqrt(3) / 4 long at most; a distance, or
 * what is blended of two, has 1; and each partial derivative of the sum of products is below 8
 * sqrt(2). */
static const double formula_steep[FORMULAS] = {2.06, 1, 1, 19.7, 1.65, 2.2};

static void make_implicit(void *desc, dvec3 at, double size) {
    static char text[1024];
    implicit_like *s = desc;
    int kind = formula.kind = (int)(random_bits() % FORMULAS);
    double a = kind == 0 ? between(0.1, 0.2) : kind == 3 ? between(0.1, 0.2) : between(0.2, 0.35);
    double b = kind == 1 ? between(0.05, 0.15) : between(0.2, 0.3), half = between(0.3, 0.5);
    formula.a = a, formula.b = b;
    formula_field.steep = formula_steep[kind] * 1.001;
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
    field_line line = field_line_of(&formula_field, o, d, formula.middle, formula.size);
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
    int count = field_scan(&line, from, to, 120, roots);
    for (int end = 0; end < 2 && count < ROOTS; end++) {
        real at = end ? to : from;
        real value = line_value(&line, at);
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
    real to_surface = field_distance(&formula_field, at);
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
        bend =
            fabsl(fabsl(formula_wave(x, y, z)) - 0.5L - (x * x + y * y + z * z - formula.a)) / 20;
    }
    real faces[3] = {fabsl(x), fabsl(y), fabsl(z)},
         half = (s->max.x - s->min.x) / (2 * formula.size);
    int near = 0;
    for (int i = 0; i < 3; i++) near += fabsl(faces[i] - half) < 0.01L;
    real rim =
        near > 1 ? 0 : most(fabsl(formula_box(s, at)), fabsl(field_distance(&formula_field, at)));
    return least(bend, rim) * formula.size;
}

/* ---- blob ---- */

static field_function balls_field = {balls_value, balls_value_quick, NULL, INFINITY};

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
/* What the line passes is all that counts; (1 - q^2)^3 is steepest at q^2 = 1/5: 1.7173. */
static int solve_blob(const void *desc, vec o, vec d, root roots[ROOTS]) {
    (void)desc;
    field_line line = field_line_of(&balls_field, o, d, balls.middle, balls.size);
    real low = INFINITY, high = -INFINITY;
    balls_field.steep = 0;
    for (int i = 0; i < BALLS; i++) {
        vec to = minus(balls.center[i], line.o);
        real along = dot(to, line.d), r = balls.radius[i];
        vec aside = minus(to, times(line.d, along));
        real left = r * r - dot(aside, aside);
        if (left < 0) continue;
        low = least(low, along - sqrtl(left) - 1e-3L);
        high = most(high, along + sqrtl(left) + 1e-3L);
        balls_field.steep += 1.718 * (double)(fabsl(balls.strength[i]) / r);
    }
    if (!(low < high)) return 0;
    int count = field_scan(&line, low, high, 200, roots);
    field_to_ray(&line, roots, count);
    return count;
}
static real distance_blob(const void *desc, vec p) {
    (void)desc;
    vec at = times(minus(p, balls.middle), 1 / balls.size);
    return field_distance(&balls_field, at) * balls.size;
}

/* ---- julia ---- */

static field_function julia_field(const void *desc) {
    return (field_function){julia_value, julia_value_quick, desc, INFINITY};
}
static void make_julia(void *desc, dvec3 at, double size) {
    (void)at, (void)size;
    julia_like *s = desc;
    s->c = vec3_from(dvec3_scale(direction(), between(0, 0.8)));
    s->c_k = (float)between(-0.3, 0.3);
    s->slice = (float)between(-0.2, 0.2);
    s->iterations = 1 + (int)(random_bits() % 4);
    s->escape = random_bits() & 1 ? 0 : 3;
    vec c = wide(s->c);
    real far = sqrtl(dot(c, c) + s->c_k * (real)s->c_k);
    real escape = most((1 + sqrtl(1 + 4 * far)) / 2 * (1 + 0x1p-40L), 2);
    if (s->escape > 0) escape = s->escape;
    julia_escape_squared = escape * escape;
}
static int solve_julia(const void *desc, vec o, vec d, root roots[ROOTS]) {
    field_function f = julia_field(desc);
    field_line line = field_line_of(&f, o, d, (vec){0, 0, 0}, 1);
    real left = 9 - dot(line.o, line.o);
    if (left < 0) return 0;
    int count = field_scan(&line, -sqrtl(left), sqrtl(left), 200, roots);
    field_to_ray(&line, roots, count);
    return count;
}
static real distance_julia(const void *desc, vec p) {
    field_function f = julia_field(desc);
    return field_distance(&f, p);
}

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
