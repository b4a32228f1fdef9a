/* geometry: every registered shape against slow solvers in long double, the reference values, and
 * the promise that a ray cannot meet the surface it leaves. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "geometry/mesh.h"
#include "geometry/surface.h"
#include "maths/functions.h"
#include "reference.h"

typedef long double real;
typedef struct vec {
    real x, y, z;
} vec;

static vec wide(vec3 a) { return (vec){a.x, a.y, a.z}; }
static vec wide_d(dvec3 a) { return (vec){a.x, a.y, a.z}; }
static vec plus(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
static vec minus(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
static vec times(vec a, real s) { return (vec){a.x * s, a.y * s, a.z * s}; }
static real dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec cross(vec a, vec b) {
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static real length(vec a) { return sqrtl(dot(a, a)); }

/* ---- random numbers: splitmix64 ---- */
static uint64_t random_state;
static uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}
static double uniform(void) { return (double)(random_bits() >> 11) * 0x1p-53; }
static double between(double low, double high) { return low + (high - low) * uniform(); }
static dvec3 direction(void) {
    for (;;) {
        dvec3 v;
        v.x = between(-1, 1);
        v.y = between(-1, 1);
        v.z = between(-1, 1);
        double square = dvec3_dot(v, v);
        if (square > 0.01 && square <= 1) return dvec3_normalize(v);
    }
}
static dvec3 in_ball(dvec3 center, double radius) {
    double distance = radius * uniform(); /* one draw per statement: compilers agree on the order */
    return dvec3_add(center, dvec3_scale(direction(), distance));
}

/* ---- the slow solvers ---- */

/* A place where the ray's line meets the shape's surface. margin: how far, relative to the shape,
 * from its edge or from being tangent; negative when it is outside. slack: the error allowed in t
 * besides the rounding to float. */
typedef struct root {
    real t, margin, slack;
} root;

#define ROOTS 16

/* A shape under test; sizes are about `size`, the middle about `at`. */
typedef struct subject {
    const char *name;
    void (*make)(void *desc, dvec3 at, double size);
    int (*solve)(const void *desc, vec o, vec d, root roots[ROOTS]);
    real (*distance)(const void *desc, vec p); /* signed, to the whole surface's plane if flat */
    real (*edge)(const void *desc, vec p);     /* how far from a corner; NULL: see at_edge */
    bool winding;                              /* a ray that leaves it outwards may meet it again */
    bool upright;                              /* its axis is the Y axis */
} subject;

/* The shapes keep their structs to themselves; these are the public ones, field by field. */
typedef struct sphere_like {
    size_t struct_size;
    vec3 center;
    float radius;
} sphere_like;
typedef struct plane_like {
    size_t struct_size;
    vec3 point, normal;
} plane_like;
typedef struct box_like {
    size_t struct_size;
    vec3 min, max;
} box_like;
typedef struct disk_like {
    size_t struct_size;
    vec3 center, normal;
    float radius, inner_radius;
} disk_like;
typedef struct quad_like {
    size_t struct_size;
    vec3 corner, u, v;
} quad_like;

static void make_sphere(void *desc, dvec3 at, double size) {
    sphere_like *s = desc;
    s->center = vec3_from(at);
    s->radius = (float)(size * between(0.1, 0.5));
}
static int solve_sphere(const void *desc, vec o, vec d, root roots[ROOTS]) {
    const sphere_like *s = desc;
    vec f = minus(wide(s->center), o);
    real r = s->radius, a = dot(d, d), middle = dot(f, d) / a;
    vec nearest = minus(f, times(d, middle));
    real discriminant = r * r - dot(nearest, nearest), margin = discriminant / (r * r);
    real half = discriminant > 0 ? sqrtl(discriminant / a) : 0;
    real slack = 1e-9L * r / sqrtl(a);
    roots[0] = (root){middle - half, margin, slack};
    roots[1] = (root){middle + half, margin, slack};
    return 2;
}
static real distance_sphere(const void *desc, vec p) {
    const sphere_like *s = desc;
    return length(minus(p, wide(s->center))) - s->radius;
}

static root plane_root(vec point, vec n, vec o, vec d) {
    real slope = dot(n, d), t = dot(n, minus(point, o)) / slope;
    real cosine = fabsl(slope) / (length(n) * length(d));
    vec f = minus(point, o);
    real slack = 1e-14L * (length(f) / length(d) + fabsl(t)) / cosine;
    return (root){t, slope != 0 ? 1 : -1, slack};
}
static void make_plane(void *desc, dvec3 at, double size) {
    (void)size;
    plane_like *s = desc;
    s->point = vec3_from(at);
    s->normal = vec3_from(direction());
}
static int solve_plane(const void *desc, vec o, vec d, root roots[ROOTS]) {
    const plane_like *s = desc;
    roots[0] = plane_root(wide(s->point), wide(s->normal), o, d);
    return roots[0].margin > 0;
}
static real distance_plane(const void *desc, vec p) {
    const plane_like *s = desc;
    return dot(minus(p, wide(s->point)), wide(s->normal)) / length(wide(s->normal));
}

static void make_disk(void *desc, dvec3 at, double size) {
    disk_like *s = desc;
    s->center = vec3_from(at);
    s->normal = vec3_from(direction());
    s->radius = (float)(size * between(0.1, 0.5));
    s->inner_radius = random_bits() & 1 ? 0 : s->radius * 0.4f;
}
static int solve_disk(const void *desc, vec o, vec d, root roots[ROOTS]) {
    const disk_like *s = desc;
    roots[0] = plane_root(wide(s->center), wide(s->normal), o, d);
    if (roots[0].margin < 0) return 0;
    real r = s->radius, inner = s->inner_radius;
    real rho = length(minus(plus(o, times(d, roots[0].t)), wide(s->center)));
    roots[0].margin = (r - rho) / r;
    if (inner > 0 && (rho - inner) / r < roots[0].margin) roots[0].margin = (rho - inner) / r;
    return 1;
}
static real distance_disk(const void *desc, vec p) {
    const disk_like *s = desc;
    return dot(minus(p, wide(s->center)), wide(s->normal)) / length(wide(s->normal));
}

static void make_quad(void *desc, dvec3 at, double size) {
    quad_like *s = desc;
    double a = size * between(0.2, 0.6), b = size * between(0.2, 0.6);
    s->u = vec3_from(dvec3_scale(direction(), a));
    do s->v = vec3_from(dvec3_scale(direction(), b));
    while (length(cross(wide(s->u), wide(s->v))) < 0.01L * size * size);
    s->corner = vec3_from(at);
}
/* Cramer's rule for a u + b v - t d = o - corner. */
static int solve_quad(const void *desc, vec o, vec d, root roots[ROOTS]) {
    const quad_like *s = desc;
    vec u = wide(s->u), v = wide(s->v), f = minus(o, wide(s->corner)), n = cross(u, v);
    real det = -dot(n, d);
    if (det == 0) return 0;
    roots[0] = plane_root(wide(s->corner), n, o, d);
    roots[0].t = dot(n, f) / det;
    real a = -dot(cross(f, v), d) / det, b = -dot(cross(u, f), d) / det;
    real margin = a < 1 - a ? a : 1 - a;
    if (b < margin) margin = b;
    if (1 - b < margin) margin = 1 - b;
    roots[0].margin = margin;
    return 1;
}
static real distance_quad(const void *desc, vec p) {
    const quad_like *s = desc;
    vec n = cross(wide(s->u), wide(s->v));
    return dot(minus(p, wide(s->corner)), n) / length(n);
}

static void make_box(void *desc, dvec3 at, double size) {
    box_like *s = desc;
    double x = size * between(0.05, 0.3), y = size * between(0.05, 0.3);
    dvec3 half = {x, y, size * between(0.05, 0.3)};
    s->min = vec3_from(dvec3_sub(at, half));
    s->max = vec3_from(dvec3_add(at, half));
}
/* Every face on its own: the plane of the face, then is the point within the other two slabs? */
static int solve_box(const void *desc, vec o_, vec d_, root roots[ROOTS]) {
    const box_like *s = desc;
    real low[3] = {s->min.x, s->min.y, s->min.z}, high[3] = {s->max.x, s->max.y, s->max.z};
    real o[3] = {o_.x, o_.y, o_.z}, d[3] = {d_.x, d_.y, d_.z};
    int count = 0;
    for (int face = 0; face < 6; face++) {
        int axis = face / 2;
        if (d[axis] == 0) continue;
        real t = ((face & 1 ? high : low)[axis] - o[axis]) / d[axis], margin = 1;
        for (int k = 1; k < 3; k++) {
            int i = (axis + k) % 3;
            real x = o[i] + t * d[i], size = high[i] - low[i];
            if ((x - low[i]) / size < margin) margin = (x - low[i]) / size;
            if ((high[i] - x) / size < margin) margin = (high[i] - x) / size;
        }
        roots[count++] = (root){t, margin, 1e-15L * fabsl(t)};
    }
    return count;
}
static real distance_box(const void *desc, vec p) {
    const box_like *s = desc;
    real out[] = {s->min.x - p.x, p.x - s->max.x, s->min.y - p.y,
                  p.y - s->max.y, s->min.z - p.z, p.z - s->max.z};
    real largest = out[0];
    for (int i = 1; i < 6; i++) largest = out[i] > largest ? out[i] : largest;
    return largest;
}

/* ---- what is turned about an axis ---- */

typedef struct cylinder_like {
    size_t struct_size;
    vec3 from, to;
    float radius;
    bool capped;
} cylinder_like;
typedef struct cone_like {
    size_t struct_size;
    vec3 from, to;
    float radius, radius_to;
    bool capped;
} cone_like;
typedef struct lathe_like {
    size_t struct_size;
    const vec2 *profile;
    size_t profile_count;
    bool smooth;
} lathe_like;
typedef struct torus_like {
    size_t struct_size;
    vec3 center, axis;
    float major, minor;
} torus_like;

typedef struct turned {
    vec origin, axis;
    int count;
    real r[8], y[8], size;
} turned;

static turned turned_frustum(vec3 from, vec3 to, float r0, float r1, bool capped) {
    vec axis = minus(wide(to), wide(from));
    real height = length(axis);
    turned made = {.origin = wide(from), .axis = times(axis, 1 / height), .size = height + r0 + r1};
    const real r[4] = {0, r0, r1, 0}, y[4] = {0, 0, height, height};
    for (int i = capped ? 0 : 1; i < (capped ? 4 : 3); i++) {
        made.r[made.count] = r[i];
        made.y[made.count++] = y[i];
    }
    return made;
}
static turned turned_lathe(const lathe_like *s) {
    turned made = {.axis = {0, 1, 0}, .count = (int)s->profile_count};
    for (int i = 0; i < made.count; i++) {
        made.r[i] = s->profile[i].x;
        made.y[i] = s->profile[i].y;
        made.size = fmaxl(made.size, made.r[i] + fabsl(made.y[i] - made.y[0]));
    }
    return made;
}

/* One piece by its quadratic x^2 + z^2 = (r + k (y - y0))^2; o and d relative to the axis. */
static int solve_frustum(const turned *s, int i, vec o, vec d, root *roots) {
    real r0 = s->r[i], y0 = s->y[i], r1 = s->r[i + 1], y1 = s->y[i + 1];
    real oy = dot(o, s->axis), dy = dot(d, s->axis);
    vec flat_o = minus(o, times(s->axis, oy)), flat_d = minus(d, times(s->axis, dy));
    if ((r0 == 0 && r1 == 0) || (r0 == r1 && y0 == y1)) return 0;
    if (y0 == y1) {
        if (dy == 0) return 0;
        real t = (y0 - oy) / dy, rho = length(plus(flat_o, times(flat_d, t)));
        real low = fminl(r0, r1), margin = fmaxl(r0, r1) - rho;
        if (low > 0) margin = fminl(margin, rho - low);
        roots[0] = (root){t, margin / s->size, 1e-13L * s->size / fabsl(dy)};
        return 1;
    }
    real k = (r1 - r0) / (y1 - y0), w = r0 + k * (oy - y0);
    real a = dot(flat_d, flat_d) - k * k * dy * dy, b = dot(flat_o, flat_d) - w * k * dy;
    real c = dot(flat_o, flat_o) - w * w, discriminant = b * b - a * c;
    real tangent = a != 0 ? discriminant / (a * a) * dot(d, d) / (s->size * s->size) : 1;
    real half = sqrtl(fmaxl(discriminant, 0)), q = b > 0 ? -b - half : half - b;
    const real t[2] = {a != 0 ? q / a : INFINITY, q != 0 ? c / q : INFINITY};
    int count = 0;
    for (int n = 0; n < 2; n++) {
        real place = (oy + t[n] * dy - y0) / (y1 - y0);
        real margin = fminl(tangent, fminl(place, 1 - place));
        if (!isfinite(t[n]) || !isfinite(place)) continue;
        /* Heights are rounded to doubles; a nearly tangent ray multiplies what that does. */
        real rounding = 0x1p-50L * fabsl(y0) / sqrtl(fminl(fmaxl(tangent, 1e-9L), 1));
        roots[count++] = (root){t[n], margin, (1e-9L * s->size + rounding) / length(d)};
    }
    return count;
}
static int solve_turned(const turned *s, vec o, vec d, root roots[ROOTS]) {
    vec middle = plus(s->origin, times(s->axis, (s->y[0] + s->y[s->count - 1]) / 2));
    real shift = dot(minus(middle, o), d) / dot(d, d);
    o = minus(plus(o, times(d, shift)), s->origin);
    int count = 0;
    for (int i = 0; i + 1 < s->count; i++) count += solve_frustum(s, i, o, d, roots + count);
    for (int i = 0; i < count; i++) roots[i].t += shift;
    return count;
}

static real segment_distance(real r, real y, real r0, real y0, real r1, real y1) {
    real dr = r1 - r0, dy = y1 - y0, square = dr * dr + dy * dy;
    real s = square > 0 ? ((r - r0) * dr + (y - y0) * dy) / square : 0;
    s = s < 0 ? 0 : s > 1 ? 1 : s;
    return hypotl(r - r0 - s * dr, y - y0 - s * dy);
}
/* Of an open tube: to the endless cone that it is a part of. */
static real distance_turned(const turned *s, vec p) {
    vec f = minus(p, s->origin);
    real y = dot(f, s->axis), r = length(minus(f, times(s->axis, y)));
    if (s->count == 2) {
        real dr = s->r[1] - s->r[0], dy = s->y[1] - s->y[0];
        return (dy * (r - s->r[0]) - dr * (y - s->y[0])) / hypotl(dr, dy);
    }
    real nearest = INFINITY;
    bool inside = false;
    for (int i = 0; i + 1 < s->count; i++) {
        real r0 = s->r[i], y0 = s->y[i], r1 = s->r[i + 1], y1 = s->y[i + 1];
        if (r0 > 0 || r1 > 0) nearest = fminl(nearest, segment_distance(r, y, r0, y0, r1, y1));
        if ((y0 > y) != (y1 > y) && r < r0 + (y - y0) / (y1 - y0) * (r1 - r0)) inside = !inside;
    }
    return inside ? -nearest : nearest;
}
static real edge_turned(const turned *s, vec p) {
    vec f = minus(p, s->origin);
    real y = dot(f, s->axis), r = length(minus(f, times(s->axis, y))), nearest = INFINITY;
    for (int i = 0; i < s->count; i++) nearest = fminl(nearest, hypotl(r - s->r[i], y - s->y[i]));
    return nearest;
}

static void make_ends(vec3 *from, vec3 *to, dvec3 at, double size) {
    double half = size * between(0.05, 0.3);
    dvec3 axis = dvec3_scale(random_bits() & 1 ? (dvec3){0, 1, 0} : direction(), half);
    *from = vec3_from(dvec3_sub(at, axis));
    *to = vec3_from(dvec3_add(at, axis));
}
static void make_cylinder(void *desc, dvec3 at, double size) {
    cylinder_like *s = desc;
    make_ends(&s->from, &s->to, at, size);
    s->radius = (float)(size * between(0.05, 0.3));
    s->capped = random_bits() % 4 != 0;
}
static turned turned_cylinder(const cylinder_like *s) {
    return turned_frustum(s->from, s->to, s->radius, s->radius, s->capped);
}
static int solve_cylinder(const void *desc, vec o, vec d, root roots[ROOTS]) {
    turned s = turned_cylinder(desc);
    return solve_turned(&s, o, d, roots);
}
static real distance_cylinder(const void *desc, vec p) {
    turned s = turned_cylinder(desc);
    return distance_turned(&s, p);
}
static real edge_cylinder(const void *desc, vec p) {
    turned s = turned_cylinder(desc);
    return edge_turned(&s, p);
}

static void make_cone(void *desc, dvec3 at, double size) {
    cone_like *s = desc;
    make_ends(&s->from, &s->to, at, size);
    s->radius = (float)(size * between(0.05, 0.3));
    s->radius_to = random_bits() & 1 ? 0 : (float)(size * between(0.05, 0.3));
    s->capped = random_bits() % 4 != 0;
}
static turned turned_cone(const cone_like *s) {
    return turned_frustum(s->from, s->to, s->radius, s->radius_to, s->capped);
}
static int solve_cone(const void *desc, vec o, vec d, root roots[ROOTS]) {
    turned s = turned_cone(desc);
    return solve_turned(&s, o, d, roots);
}
static real distance_cone(const void *desc, vec p) {
    turned s = turned_cone(desc);
    return distance_turned(&s, p);
}
static real edge_cone(const void *desc, vec p) {
    turned s = turned_cone(desc);
    return edge_turned(&s, p);
}

/* A goblet with a hollow foot or a solid one, drawn upwards or downwards. */
static void make_lathe(void *desc, dvec3 at, double size) {
    static vec2 profile[7];
    lathe_like *s = desc;
    double r[7] = {0, 0.4, 0.1, 0.45, 0.25, 0.1, 0}, y[7] = {-0.4, -0.4, 0, 0.5, 0.5, 0.2, 0.15};
    if (random_bits() & 1) y[0] = -0.2;
    bool down = random_bits() & 1;
    for (int i = 0; i < 7; i++) {
        double wider = between(-0.03, 0.03), higher = between(-0.03, 0.03);
        if (r[i] > 0) r[i] = size * (r[i] + wider);
        if (i > 1) y[i] += higher; /* the foot stays flat */
        profile[down ? 6 - i : i] = (vec2){(float)r[i], (float)(at.y + size * y[i])};
    }
    s->profile = profile;
    s->profile_count = 7;
    s->smooth = random_bits() & 1;
}
static int solve_lathe(const void *desc, vec o, vec d, root roots[ROOTS]) {
    turned s = turned_lathe(desc);
    return solve_turned(&s, o, d, roots);
}
static real distance_lathe(const void *desc, vec p) {
    turned s = turned_lathe(desc);
    return distance_turned(&s, p);
}
static real edge_lathe(const void *desc, vec p) {
    turned s = turned_lathe(desc);
    return edge_turned(&s, p);
}

static void make_torus(void *desc, dvec3 at, double size) {
    torus_like *s = desc;
    double minor = between(0.02, 0.95);
    s->center = vec3_from(at);
    s->axis = random_bits() & 1 ? (vec3){0, 1, 0} : vec3_from(direction());
    s->major = (float)(size * 0.5 / (1 + minor));
    s->minor = (float)(minor * (double)s->major);
}
static real distance_torus(const void *desc, vec p) {
    const torus_like *s = desc;
    vec f = minus(p, wide(s->center)), axis = times(wide(s->axis), 1 / length(wide(s->axis)));
    real y = dot(f, axis), rho = length(minus(f, times(axis, y)));
    return hypotl(rho - s->major, y) - s->minor;
}
/* The quartic's critical points by Cardano's and Viete's formulas; between them, halving. */
static int solve_torus(const void *desc, vec o, vec d, root roots[ROOTS]) {
    const torus_like *s = desc;
    real speed = length(d), major = s->major, minor = s->minor;
    vec axis = times(wide(s->axis), 1 / length(wide(s->axis))), f = minus(o, wide(s->center));
    d = times(d, 1 / speed);
    real shift = -dot(f, d), y, dy = dot(d, axis);
    f = plus(f, times(d, shift));
    y = dot(f, axis);
    real far = (major + minor) * (major + minor) * 1.0001L - dot(f, f);
    if (far < 0) return 0;
    real p = dot(f, f) - major * major - minor * minor + 2 * major * major * dy * dy;
    real q = 2 * major * major * y * dy, inner = q * q / 4 + p * p * p / 27;
    real at[5] = {-sqrtl(far)};
    int splits = 1;
    if (inner >= 0) {
        real w = sqrtl(inner);
        at[splits++] = cbrtl(-q / 2 + w) + cbrtl(-q / 2 - w);
        if (p < 0 && inner == 0) at[splits++] = cbrtl(q / 2);
    } else {
        real m = 2 * sqrtl(-p / 3), angle = acosl(fmaxl(-1, fminl(1, 3 * q / (p * m)))) / 3;
        for (int k = 2; k >= 0; k--) at[splits++] = m * cosl(angle - 2 * (real)PI * k / 3);
    }
    for (int i = 1; i < splits; i++) /* in order */
        for (int k = i; k > 1 && at[k] < at[k - 1]; k--) {
            real swap = at[k];
            at[k] = at[k - 1];
            at[k - 1] = swap;
        }
    at[splits++] = sqrtl(far);
    int count = 0;
    vec center = wide(s->center);
    for (int i = 0; i + 1 < splits; i++) {
        real low = at[i], high = at[i + 1];
        real one = distance_torus(desc, plus(center, plus(f, times(d, low))));
        real other = distance_torus(desc, plus(center, plus(f, times(d, high))));
        real margin = fminl(fabsl(one), fabsl(other)) / minor;
        real slack = 1e-9L * (major + minor) / speed;
        if ((one > 0) == (other > 0)) {
            if (margin < 1e-8L) /* nearly tangent: too close to call */
                roots[count++] = (root){(low + shift) / speed, 0, slack};
            continue;
        }
        for (int n = 0; n < 70; n++) {
            real middle = (low + high) / 2;
            real value = distance_torus(desc, plus(center, plus(f, times(d, middle))));
            *((value > 0) == (one > 0) ? &low : &high) = middle;
        }
        if (margin < 1e-8L) margin = 0;
        roots[count++] = (root){(low + shift) / speed, margin, slack};
    }
    return count;
}

static const subject subjects[] = {
    {"sphere", make_sphere, solve_sphere, distance_sphere, NULL, false, false},
    {"plane", make_plane, solve_plane, distance_plane, NULL, false, false},
    {"disk", make_disk, solve_disk, distance_disk, NULL, false, false},
    {"quad", make_quad, solve_quad, distance_quad, NULL, false, false},
    {"box", make_box, solve_box, distance_box, NULL, false, false},
    {"cylinder", make_cylinder, solve_cylinder, distance_cylinder, edge_cylinder, false, false},
    {"cone", make_cone, solve_cone, distance_cone, edge_cone, false, false},
    {"torus", make_torus, solve_torus, distance_torus, NULL, true, false},
    {"lathe", make_lathe, solve_lathe, distance_lathe, edge_lathe, true, true},
};

static const subject *subject_of(const primitive_type *type) {
    for (size_t i = 0; i < sizeof subjects / sizeof subjects[0]; i++)
        if (strcmp(subjects[i].name, type->info.name) == 0) return &subjects[i];
    fail_msg("no slow solver here for the shape '%s'", type->info.name);
    return NULL;
}

/* ---- the comparison ---- */

typedef union any_desc {
    sphere_like sphere;
    plane_like plane;
    box_like box;
    disk_like disk;
    quad_like quad;
    cylinder_like cylinder;
    cone_like cone;
    torus_like torus;
    lathe_like lathe;
} any_desc;

/* One shape at one scale and place. */
typedef struct setting {
    const primitive_type *type;
    const subject *subject;
    any_desc desc;
    dvec3 at;
    double size;
    long hits, misses, unclear, exits,
        instanced; /* counted, so that a test that tests nothing fails */
} setting;

static void setting_make(setting *s, double size, double offset) {
    s->size = size;
    s->at = dvec3_from(vec3_from(dvec3_scale(direction(), size * offset)));
    if (s->subject->upright) s->at.x = s->at.z = 0;
    desc_init(&s->type->info, &s->desc);
    s->subject->make(&s->desc, s->at, size);
    assert_int_equal(desc_check(&s->type->info, &s->desc, NULL), SNELL_OK);
    if (s->type->check) assert_int_equal(s->type->check(&s->desc), SNELL_OK);
}

static bool clearly(real a, real b, real slack) {
    return fabsl(a - b) > slack + 0x1p-22L * fabsl(b);
}

/* Holds intersect against the slow solver; true if there is a hit. */
static bool compare(setting *s, const local_ray *beam, hit *found) {
    root roots[ROOTS];
    int count = s->subject->solve(&s->desc, wide(beam->o), wide(beam->d), roots);
    const root *nearest = NULL;
    bool unclear = false;
    for (int i = 0; i < count; i++) {
        const root *r = &roots[i];
        if (r->margin < -1e-9L) continue;
        bool near_end = !clearly(r->t, beam->t_min, r->slack) ||
                        (beam->t_max < INFINITY && !clearly(r->t, beam->t_max, r->slack));
        if (r->margin < 1e-9L || near_end) unclear = true;
        if (r->t > beam->t_min && r->t < beam->t_max && (!nearest || r->t < nearest->t))
            nearest = r;
    }
    *found = (hit){.t = INFINITY, .u = NAN, .v = NAN};
    bool is_hit = s->type->intersect(&s->desc, beam, found);
    if (is_hit) assert_true(found->t > beam->t_min && found->t < beam->t_max);
    if (unclear) {
        s->unclear++;
        return is_hit;
    }
    if (is_hit != (nearest != NULL))
        fail_msg("%s: hit %d, expected %d; size %g", s->type->info.name, is_hit, nearest != NULL,
                 s->size);
    s->hits += is_hit;
    s->misses += !is_hit;
    if (is_hit && fabsl(found->t - nearest->t) > nearest->slack + 0x1p-24L * fabsl(nearest->t))
        fail_msg("%s: t %.9g, expected %.12Lg; size %g", s->type->info.name, (double)found->t,
                 nearest->t, s->size);
    return is_hit;
}

static void check_surface(const setting *s, const surface *at) {
    const double numbers[] = {at->p.x, at->p.y,   at->p.z,   at->n.x,   at->n.y,
                              at->n.z, at->ns.x,  at->ns.y,  at->ns.z,  at->u,
                              at->v,   at->error, at->alpha, at->tint.x};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        assert_true(isfinite(numbers[i]));
    assert_true(at->error >= 0 && fabs(dvec3_length(at->n) - 1) < 1e-14);
    assert_true(dvec3_dot(at->n, at->ns) > 0);
    /* The point is on the surface as exactly as its own error says, which is next to nothing. */
    double magnitude = fabs(at->p.x) + fabs(at->p.y) + fabs(at->p.z);
    double exact = 1e-13 * (4 * magnitude + 100 * s->size), ulp = 0x1p-23 * magnitude;
    real distance = fabsl(s->subject->distance(&s->desc, wide_d(at->p)));
    assert_true(distance <= at->error && distance <= exact);
    assert_true(at->error <= exact + ulp * ulp * at->curvature);
    bounds3 box = s->type->bounds(&s->desc);
    assert_true(at->p.x >= (double)box.min.x && at->p.x <= (double)box.max.x);
    assert_true(at->p.y >= (double)box.min.y && at->p.y <= (double)box.max.y);
    assert_true(at->p.z >= (double)box.min.z && at->p.z <= (double)box.max.z);
}

/* A ray that leaves: its origin is on the side it goes to, and it does not meet where it came from.
 * `shape_ray` is the ray as the shape sees it. */
static void check_leaving(setting *s, const surface *at, const local_ray *shape_ray, double side) {
    real distance = s->subject->distance(&s->desc, wide(shape_ray->o));
    real along = dot(minus(wide(shape_ray->o), wide_d(at->p)), wide_d(at->n)) * side;
    /* Near an edge of a box the origin may lie on the other face: not outside of it, though. */
    if (!(along > 0 && (side > 0 ? distance > 0 : distance <= 0)))
        fail_msg("%s: the next origin is %Lg from the surface, side %g", s->type->info.name,
                 distance, side);
    hit again;
    bool is_hit = compare(s, shape_ray, &again);
    if (s->type->flat || (side > 0 && !s->subject->winding)) {
        assert_false(is_hit); /* flat or convex: nothing to meet on that side */
        return;
    }
    if (!is_hit) return;
    surface exit;
    s->type->surface(&s->desc, shape_ray, &again, &exit);
    /* It leaves, or enters, by another point. */
    assert_true(dvec3_dot(exit.n, dvec3_from(shape_ray->d)) * (side > 0 ? -1 : 1) > 0);
    s->exits++;
}

/* Where two faces of a turned shape meet, the origin that is rounded to floats, which moves it along
 * the face too, may lie beyond the other face. */
static bool at_joint(const setting *s, const surface *at) {
    if (s->subject->edge == NULL) return false;
    real near = 0x1p-20L * (length(wide_d(s->at)) + 200 * s->size);
    return s->subject->edge(&s->desc, wide_d(at->p)) < near;
}

static void check_no_self_hit(setting *s, const surface *at) {
    if (at_joint(s, at)) return;
    for (int i = 0; i < 2; i++) {
        dvec3 d = direction();
        if (i == 1) { /* along the surface, up to 1e-7 out of it */
            double out = dvec3_dot(d, at->n);
            d = dvec3_sub(d, dvec3_scale(at->n, out * (1 - 1e-7)));
        }
        local_ray next = {{0, 0, 0}, vec3_from(d), 0, INFINITY};
        double side = dvec3_dot(at->n, dvec3_from(next.d));
        if (side == 0) continue;
        next.o = surface_offset_origin(at, side);
        check_leaving(s, at, &next, side);
    }
}

static transform random_transform(double size) {
    dvec3 z = direction(), x, y;
    dvec3_frame(z, &x, &y);
    double a = between(0.1, 3), b = between(0.1, 3), c = between(-3, -0.1);
    dvec3 move = dvec3_scale(direction(), size * 100);
    return (transform){{{(float)(a * x.x), (float)(b * y.x), (float)(c * z.x), (float)move.x},
                        {(float)(a * x.y), (float)(b * y.y), (float)(c * z.y), (float)move.y},
                        {(float)(a * x.z), (float)(b * y.z), (float)(c * z.z), (float)move.z}}};
}

/* Within a few float roundings of the box's edge, where "inside" is not a matter of one face: in an
 * instance the origin is rounded along the face too. */
static bool at_edge(const setting *s, const surface *at) {
    if (s->subject->edge) return at_joint(s, at);
    if (strcmp(s->type->info.name, "box") != 0) return false;
    surface other = *at;
    double near = 0x1p-20 * (dvec3_length(s->at) + 200 * s->size);
    for (int i = 0; i < 4; i++) { /* stepping along the face leaves it */
        dvec3 t, b;
        dvec3_frame(at->n, &t, &b);
        dvec3 step = dvec3_scale(i & 1 ? t : b, i & 2 ? near : -near);
        other.p = dvec3_add(at->p, step);
        if (s->subject->distance(&s->desc, wide_d(other.p)) > 0) return true;
    }
    return false;
}

/* The same in an instance: the origin is found in the world and brought back in float. */
static void check_no_self_hit_in_instance(setting *s, const surface *at) {
    if (at_edge(s, at)) return;
    transform to_world = random_transform(s->size), to_local;
    assert_true(transform_inverse(&to_world, &to_local));
    surface world = *at;
    surface_to_world(&world, &to_world, &to_local);
    double norm = 0;
    for (int i = 0; i < 9; i++)
        norm += (double)to_local.m[i / 3][i % 3] * (double)to_local.m[i / 3][i % 3];
    if (dvec3_length(world.p) * sqrt(norm) > 16384 * s->size) return; /* too far for floats */
    s->instanced++;
    assert_true(fabs(dvec3_length(world.n) - 1) < 1e-14 && isfinite(world.error));
    vec3 d = vec3_from(direction());
    double side = dvec3_dot(world.n, dvec3_from(d));
    if (fabs(side) < 1e-5) return; /* rounding d in the instance may change its side */
    vec3 o = surface_offset_origin(&world, side);
    local_ray next = {vec3_from(transform_point(&to_local, dvec3_from(o))),
                      vec3_from(transform_vector(&to_local, dvec3_from(d))), 0, INFINITY};
    check_leaving(s, at, &next, side);
}

/* ---- kinds of rays ---- */

static local_ray ray_between(dvec3 from, dvec3 to) {
    vec3 o = vec3_from(from);
    dvec3 d = dvec3_scale(dvec3_normalize(dvec3_sub(to, dvec3_from(o))), between(0.3, 3));
    return (local_ray){o, vec3_from(d), 0, INFINITY};
}

/* last: a surface point met before. */
static local_ray random_ray(const setting *s, int kind, const surface *last) {
    dvec3 target = in_ball(s->at, s->size * 0.6);
    double far = s->size * exp2(between(0, 14));
    switch (kind) {
    case 0: return ray_between(dvec3_add(s->at, dvec3_scale(direction(), far)), target);
    case 1: return ray_between(in_ball(s->at, 0.3 * s->size), target);
    case 2: { /* along an axis */
        local_ray beam = ray_between(in_ball(s->at, 2 * s->size), target);
        float step = random_bits() & 1 ? 1.0f : -1.0f;
        int axis = (int)(random_bits() % 3);
        beam.d = (vec3){axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0};
        return beam;
    }
    case 3: { /* grazes: through a point of the surface, along a tangent or nearly so */
        dvec3 t, b;
        dvec3_frame(last->n, &t, &b);
        double angle = between(0, 2 * PI);
        dvec3 d = dvec3_add(dvec3_scale(t, cos(angle)), dvec3_scale(b, sin(angle)));
        double out = exp2(-between(1, 50));
        d = dvec3_add(d, dvec3_scale(last->n, random_bits() & 1 ? out : -out));
        return ray_between(dvec3_sub(last->p, dvec3_scale(d, far)), last->p);
    }
    case 4: return ray_between(last->p, target); /* starts on the surface, as near as floats are */
    default: {                                   /* with a range */
        local_ray beam = ray_between(in_ball(s->at, 2 * s->size), target);
        beam.t_min = (float)(s->size * between(0, 2));
        beam.t_max = beam.t_min + (float)(s->size * between(0, 2));
        return beam;
    }
    }
}

static void every_shape_agrees_with_a_slow_solver(void **state) {
    (void)state;
    const double sizes[] = {1e-3, 1, 1e3, 1e6}, offsets[] = {0, 1, 128, 16384};
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        setting s = {.type = primitive_types[i]};
        if (s.type->primitive_count) continue; /* test_shapes_parts.c, test_accel.c */
        s.subject = subject_of(s.type);
        random_state = 12345 + i;
        surface last = {0};
        bool met = false;
        for (int n = 0; n < 100000; n++) {
            int place = n / 50 % 16;
            if (n % 50 == 0) {
                setting_make(&s, sizes[place % 4], offsets[place / 4]);
                met = false;
            }
            local_ray beam = random_ray(&s, met ? n % 6 : 0, &last);
            hit found;
            if (!compare(&s, &beam, &found)) continue;
            s.type->surface(&s.desc, &beam, &found, &last);
            met = true;
            check_surface(&s, &last);
            check_no_self_hit(&s, &last);
            check_no_self_hit_in_instance(&s, &last);
        }
        printf("%s: %ld hits, %ld misses, %ld too close to call, %ld exits, %ld instanced\n",
               s.type->info.name, s.hits, s.misses, s.unclear, s.exits, s.instanced);
        assert_true(s.instanced > 10000);
        assert_true(s.hits > 10000 && s.misses > 20000 && s.unclear < 60000);
        if (!s.type->flat) assert_true(s.exits > 10000);
    }
}

static void odd_rays_give_no_nan_and_no_hit(void **state) {
    (void)state;
    const float odd[] = {0, -0.0f, NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e-45f, 1, -1};
    const int count = sizeof odd / sizeof odd[0];
    random_state = 99;
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        setting s = {.type = primitive_types[i]};
        if (s.type->primitive_count) continue; /* test_shapes_parts.c, test_accel.c */
        s.subject = subject_of(s.type);
        setting_make(&s, 1, 1);
        for (int n = 0; n < 20000; n++) {
            float x[6];
            for (int k = 0; k < 6; k++) x[k] = odd[random_bits() % (uint64_t)count];
            local_ray beam = {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}, 0, INFINITY};
            hit found;
            if (s.type->intersect(&s.desc, &beam, &found)) {
                assert_true(found.t > 0 && found.t < INFINITY);
                surface at;
                s.type->surface(&s.desc, &beam, &found, &at);
            }
        }
        local_ray still = {{0, 0, 0}, {0, 0, 0}, 0, INFINITY};
        hit found;
        assert_false(s.type->intersect(&s.desc, &still, &found));
    }
}

/* ---- reference values ---- */

static vec3 json_vec3(const json_t *array) {
    return (vec3){(float)reference_number(array, 0), (float)reference_number(array, 1),
                  (float)reference_number(array, 2)};
}

static int references_used;

static void check_reference(const reference_case *c) {
    json_t *shape = json_array_get(json_object_get(c->scene, "geometry"), 0);
    json_t *line = json_object_get(c->scene, "ray");
    const primitive_type *type = primitive_find(json_string_value(json_object_get(shape, "type")));
    if (type == NULL) return; /* triangles are tested by the kernels */
    any_desc desc;
    desc_init(&type->info, &desc);
    const char *key;
    json_t *value;
    json_object_foreach(shape, key, value) {
        if (strcmp(key, "type") == 0) continue;
        snell_param param = {.name = key, .kind = SNELL_PARAM_VEC3, .value.v = json_vec3(value)};
        if (strcmp(key, "R") == 0) param.name = "major";
        if (strcmp(key, "r") == 0) param.name = "minor";
        if (json_is_string(value)) { /* the torus' axis */
            assert_string_equal(json_string_value(value), "z");
            param.value.v = (vec3){0, 0, 1};
        }
        if (json_is_number(value)) {
            param.kind = SNELL_PARAM_FLOAT;
            param.value.f = json_number_value(value);
        }
        assert_int_equal(desc_set(&type->info, &desc, &param), SNELL_OK);
    }
    local_ray beam = {json_vec3(json_object_get(line, "o")), json_vec3(json_object_get(line, "d")),
                      0, INFINITY};
    size_t count = json_array_size(c->expected);
    for (size_t i = 0; i < count; i++) {
        hit found;
        assert_true(type->intersect(&desc, &beam, &found));
        assert_true(reference_agrees(c, (double)found.t, reference_number(c->expected, i)));
        beam.t_min = found.t; /* the next root */
    }
    hit found;
    assert_false(type->intersect(&desc, &beam, &found));
    references_used++;
}

static void reference_intersections(void **state) {
    (void)state;
    assert_true(reference_each("L.intersections", check_reference) == 8);
    assert_int_equal(references_used, 7); /* three spheres, a box, three tori */
}

/* ---- texture coordinates and frames ---- */

static surface look_at(const primitive_type *type, const void *desc, dvec3 from, dvec3 to) {
    local_ray beam = {vec3_from(from), vec3_from(dvec3_sub(to, from)), 0, INFINITY};
    hit found;
    assert_true(type->intersect(desc, &beam, &found));
    surface out;
    type->surface(desc, &beam, &found, &out);
    if (type->parametrise) type->parametrise(desc, &out);
    return out;
}

static void assert_uv(const surface *s, double u, double v) {
    if (fabs(s->u - u) > 1e-6 || fabs(s->v - v) > 1e-6)
        fail_msg("uv is %g %g, not %g %g", s->u, s->v, u, v);
}

static void texture_coordinates_lie_as_documented(void **state) {
    (void)state;
    const dvec3 middle = {0, 0, 0};
    const primitive_type *type = primitive_find("sphere");
    any_desc desc;
    desc_init(&type->info, &desc);
    surface s = look_at(type, &desc, (dvec3){0, 0, 5}, middle);
    assert_uv(&s, 0.5, 0.5);
    s = look_at(type, &desc, (dvec3){5, 0, 0}, middle); /* right of +Z, seen from outside */
    assert_uv(&s, 0.75, 0.5);
    s = look_at(type, &desc, (dvec3){0, 5, 5}, middle);
    assert_uv(&s, 0.5, 0.75);

    type = primitive_find("plane");
    desc_init(&type->info, &desc);
    s = look_at(type, &desc, (dvec3){3, 5, -2}, (dvec3){3, 0, -2});
    assert_uv(&s, 3, 2);

    type = primitive_find("disk");
    desc_init(&type->info, &desc);
    s = look_at(type, &desc, (dvec3){0.5, 5, 0}, (dvec3){0.5, 0, 0});
    assert_uv(&s, 0, 0.5);
    s = look_at(type, &desc, (dvec3){0, 5, -0.25}, (dvec3){0, 0, -0.25});
    assert_uv(&s, 0.25, 0.25);

    type = primitive_find("quad");
    desc_init(&type->info, &desc);
    desc.quad.u = (vec3){2, 0, 0};
    desc.quad.v = (vec3){0, 4, 0};
    s = look_at(type, &desc, (dvec3){0.5, 1, 3}, (dvec3){0.5, 1, 0});
    assert_uv(&s, 0.25, 0.25);
    assert_true(s.n.z == 1);

    type = primitive_find("box");
    desc_init(&type->info, &desc);
    desc.box.min = (vec3){-1, -1, -1};
    desc.box.max = (vec3){1, 1, 1};
    /* A point right of and above the middle of each face, as seen from outside with +Y up. */
    const dvec3 outward[6] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    const dvec3 up[6] = {{0, 1, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {0, 1, 0}, {0, 1, 0}};
    for (int i = 0; i < 6; i++) {
        dvec3 right = dvec3_cross(up[i], outward[i]);
        dvec3 at = dvec3_add(dvec3_scale(right, 0.5), dvec3_scale(up[i], 0.2));
        s = look_at(type, &desc, dvec3_add(at, dvec3_scale(outward[i], 3)), at);
        assert_true(dvec3_dot(s.n, outward[i]) == 1);
        assert_uv(&s, 0.75, 0.6);
    }
}

static void closed_shapes_and_half_spaces_have_sides(void **state) {
    (void)state;
    any_desc desc;
    const primitive_type *type = primitive_find("sphere");
    desc_init(&type->info, &desc);
    assert_int_equal(type->side(&desc, (dvec3){0.5, 0, 0}), 1);
    assert_int_equal(type->side(&desc, (dvec3){1.5, 0, 0}), -1);
    type = primitive_find("plane");
    desc_init(&type->info, &desc);
    assert_int_equal(type->side(&desc, (dvec3){7, -1, 0}), 1);
    assert_int_equal(type->side(&desc, (dvec3){7, 1, 0}), -1);
    type = primitive_find("box");
    desc_init(&type->info, &desc);
    desc.box.max = (vec3){1, 1, 1};
    assert_int_equal(type->side(&desc, (dvec3){0.5, 0.5, 0.5}), 1);
    assert_int_equal(type->side(&desc, (dvec3){0.5, 0.5, 1.5}), -1);
    assert_null(primitive_find("quad")->side);
    assert_null(primitive_find("ball"));
}

static void senseless_shapes_are_refused(void **state) {
    (void)state;
    any_desc desc;
    const primitive_type *type = primitive_find("disk");
    desc_init(&type->info, &desc);
    desc.disk.inner_radius = 1;
    assert_int_equal(type->check(&desc), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text,
                        "disk: 'inner_radius' is 1; it must be less than 'radius', 1");
    type = primitive_find("box");
    desc_init(&type->info, &desc);
    desc.box.min = (vec3){0, 2, 0};
    desc.box.max = (vec3){1, 1, 1};
    assert_int_equal(type->check(&desc), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "box: 'min' y is 2 and 'max' y is 1");
    type = primitive_find("quad");
    desc_init(&type->info, &desc);
    desc.quad.u = (vec3){0.1f, 0.2f, 0.3f};
    desc.quad.v = (vec3){0.2f, 0.4f, 0.6f};
    assert_int_equal(type->check(&desc), SNELL_ERR_ARGUMENT);
}

/* ---- meshes ---- */

static const vec3 corners[] = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {2, 2, 0}};
static const uint32_t two_triangles[] = {0, 1, 2, 1, 3, 2};

static mesh_desc square(void) {
    return (mesh_desc){
        .positions = corners, .positions_count = 4, .indices = two_triangles, .indices_count = 6};
}

static void a_mesh_is_checked(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("mesh");
    mesh_desc mesh = square();
    assert_int_equal(type->check(&mesh), SNELL_OK);
    bounds3 box = type->bounds(&mesh);
    assert_true(box.min.x == 0 && box.max.x == 2 && box.max.y == 2 && box.max.z == 0);
    mesh.positions_count = 3;
    assert_int_equal(type->check(&mesh), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text,
                        "mesh: index 3 of triangle 1 is out of range: there are 3 positions");
    mesh = square();
    mesh.indices_count = 5;
    assert_int_equal(type->check(&mesh), SNELL_ERR_ARGUMENT);
    mesh = square();
    mesh.normals = corners;
    mesh.normals_count = 3;
    assert_int_equal(type->check(&mesh), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "mesh: 'normals' has 3 entries for 4 positions");
    mesh = square();
    const uint32_t slots[] = {0, 1};
    const snell_material_id materials[2] = {{1, 0}, {2, 0}};
    mesh.material_slots = slots;
    mesh.material_slots_count = 2;
    mesh.materials = materials;
    mesh.materials_count = 1;
    assert_int_equal(type->check(&mesh), SNELL_ERR_ARGUMENT);
    mesh.materials_count = 2;
    assert_int_equal(type->check(&mesh), SNELL_OK);
    mesh.material_slots_count = 1;
    assert_int_equal(type->check(&mesh), SNELL_ERR_ARGUMENT);
    mesh = (mesh_desc){.struct_size = sizeof mesh}; /* empty */
    assert_int_equal(type->check(&mesh), SNELL_OK);
    assert_true(bounds3_is_empty(type->bounds(&mesh)));
}

static void a_point_on_a_mesh_is_blended(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("mesh");
    mesh_desc mesh = square();
    const vec3 normals[] = {{0, 0, 2}, {1, 0, 0}, {0, 0, 5}, {0, 0, 0}};
    const vec2 uvs[] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    const vec3 colors[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    const uint8_t alphas[] = {255, 0, 255, 255};
    const uint32_t slots[] = {7, 3};
    local_ray beam = {{0.5f, 0.5f, 1}, {0, 0, -1}, 0, INFINITY};
    hit found = {.t = 1, .u = 0.25f, .v = 0.25f};
    surface s;
    type->surface(&mesh, &beam, &found, &s);
    assert_true(s.p.x == 0.5 && s.p.y == 0.5 && s.p.z == 0 && s.n.z == 1 && s.ns.z == 1);
    assert_uv(&s, 0.25, 0.25); /* barycentrics */
    assert_true(s.tint.x == 1 && s.alpha == 1 && s.material_slot == 0);

    mesh.normals = normals;
    mesh.uvs = uvs;
    mesh.colors = colors;
    mesh.alphas = alphas;
    mesh.material_slots = slots;
    mesh.normals_count = mesh.uvs_count = mesh.colors_count = mesh.alphas_count = 4;
    mesh.material_slots_count = 2;
    type->surface(&mesh, &beam, &found, &s);
    double length_ns = sqrt(0.75 * 0.75 + 0.25 * 0.25);
    assert_true(fabs(s.ns.x - 0.25 / length_ns) < 1e-12 && fabs(s.ns.z - 0.75 / length_ns) < 1e-12);
    assert_uv(&s, 0.25, 0.25);
    assert_true(s.tint.x == 0.5 && s.tint.y == 0.25 && s.tint.z == 0.25 && s.alpha == 0.75);
    assert_int_equal(s.material_slot, 7);
    found = (hit){.t = 1, .u = 1, .v = 0, .primitive = 1}; /* at a vertex without a normal */
    type->surface(&mesh, &beam, &found, &s);
    assert_true(s.ns.z == 1 && s.p.x == 2 && s.p.y == 2 && s.material_slot == 3);
    assert_uv(&s, 1, 1);
    found = (hit){.t = 1, .u = 0.7f, .v = 0.7f}; /* rounding: never outside the triangle */
    type->surface(&mesh, &beam, &found, &s);
    assert_true(fabs(s.p.x - 1) < 1e-12 && fabs(s.p.y - 1) < 1e-12);

    const uint32_t degenerate[] = {0, 0, 1};
    mesh.indices = degenerate;
    mesh.indices_count = 3;
    found = (hit){.t = 1};
    type->surface(&mesh, &beam, &found, &s);
    assert_true(s.n.z == 1 && isfinite(s.ns.x)); /* faces the ray */
}

/* The float test that the kernels use (Woop, Benthin, Wald 2013), without its double case. */
static bool float_triangle(const vec3 v[3], const local_ray *beam, float *t) {
    float d[3] = {beam->d.x, beam->d.y, beam->d.z};
    int kz = fabsf(d[0]) > fabsf(d[1]) ? (fabsf(d[0]) > fabsf(d[2]) ? 0 : 2)
                                       : (fabsf(d[1]) > fabsf(d[2]) ? 1 : 2);
    int kx = (kz + 1) % 3, ky = (kz + 2) % 3;
    float sx = d[kx] / d[kz], sy = d[ky] / d[kz], sz = 1 / d[kz], x[3], y[3], z[3];
    for (int i = 0; i < 3; i++) {
        float a[3] = {v[i].x - beam->o.x, v[i].y - beam->o.y, v[i].z - beam->o.z};
        x[i] = a[kx] - sx * a[kz];
        y[i] = a[ky] - sy * a[kz];
        z[i] = sz * a[kz];
    }
    float e0 = x[2] * y[1] - y[2] * x[1], e1 = x[0] * y[2] - y[0] * x[2],
          e2 = x[1] * y[0] - y[1] * x[0];
    if ((e0 < 0 || e1 < 0 || e2 < 0) && (e0 > 0 || e1 > 0 || e2 > 0)) return false;
    float det = e0 + e1 + e2;
    if (det == 0) return false;
    *t = (e0 * z[0] + e1 * z[1] + e2 * z[2]) / det;
    return *t > 0;
}

/* On a flat floor of triangles a ray that leaves one must not meet its neighbours: their planes
 * agree only up to the rounding of their vertices, and the kernels test in float. To that test a
 * ray within 32 roundings of the tangent plane sees the floor edge-on, and its t may be anything.
 */
static void a_ray_that_leaves_a_floor_meets_no_neighbour(void **state) {
    (void)state;
    enum { SIDE = 4, COUNT = SIDE * SIDE };
    const primitive_type *type = primitive_find("mesh");
    uint32_t indices[6 * (SIDE - 1) * (SIDE - 1)];
    size_t used = 0;
    for (uint32_t i = 0; i + 1 < SIDE; i++)
        for (uint32_t j = 0; j + 1 < SIDE; j++) {
            uint32_t a = i * SIDE + j,
                     cell[6] = {a, a + 1, a + SIDE, a + 1, a + SIDE + 1, a + SIDE};
            memcpy(indices + used, cell, sizeof cell);
            used += 6;
        }
    random_state = 7;
    long tested = 0, near_hits = 0, edge_on = 0;
    for (int n = 0; n < 8000; n++) {
        double size = exp2(between(-10, 20)), far = size * exp2(between(-4, 14));
        dvec3 at = dvec3_scale(direction(), far), x, y, z = direction();
        if (n % 4 == 0) z = (dvec3){0, 1, 0};
        dvec3_frame(z, &x, &y);
        vec3 positions[COUNT];
        for (int i = 0; i < COUNT; i++) {
            double a = size * (i / SIDE + between(-0.3, 0.3));
            double b = size * (i % SIDE + between(-0.3, 0.3));
            dvec3 offset = dvec3_add(dvec3_scale(x, a), dvec3_scale(y, b));
            positions[i] = vec3_from(dvec3_add(at, offset));
        }
        mesh_desc mesh = {.positions = positions,
                          .positions_count = COUNT,
                          .indices = indices,
                          .indices_count = used};
        hit found = {.t = 1, .primitive = (uint32_t)(random_bits() % (used / 3))};
        found.u = (float)exp2(-between(1, 24)); /* also near an edge */
        found.v = (float)exp2(-between(1, 24));
        local_ray first = {{0, 0, 0}, vec3_from(dvec3_negate(z)), 0, INFINITY};
        surface s;
        type->surface(&mesh, &first, &found, &s);
        for (int k = 0; k < 16; k++) {
            dvec3 d = direction();
            double slope = exp2(-between(0, 26)); /* also nearly along the floor */
            if (k & 1) d = dvec3_sub(d, dvec3_scale(s.n, dvec3_dot(d, s.n) * (1 - slope)));
            local_ray next = {{0, 0, 0}, vec3_from(d), 0, INFINITY};
            double side = dvec3_dot(s.n, dvec3_from(next.d));
            next.o = surface_offset_origin(&s, side);
            for (size_t i = 0; i < used / 3; i++) {
                if (i == found.primitive) continue;
                vec3 v[3];
                for (int c = 0; c < 3; c++) v[c] = positions[indices[3 * i + (size_t)c]];
                vec normal = cross(minus(wide(v[1]), wide(v[0])), minus(wide(v[2]), wide(v[0])));
                real height = dot(normal, minus(wide(next.o), wide(v[0]))) * side;
                float t;
                bool is_hit = float_triangle(v, &next, &t);
                tested++;
                /* A rounded floor has real dents: below the neighbour's plane a hit is true. */
                if (is_hit && height <= 0) near_hits++;
                if (!(is_hit && height > 0 && dot(normal, wide(next.d)) * side > 0)) continue;
                if (fabs(side) <= 32 * FLOAT_EPSILON * dvec3_length(dvec3_from(next.d)))
                    edge_on++;
                else
                    fail_msg("met a neighbour at t %g, size %g", (double)t, size);
            }
        }
    }
    printf("floor: %ld tests, %ld true hits of dents, %ld edge-on\n", tested, near_hits, edge_on);
    assert_true(tested > 500000 && edge_on < 100);
}

/* Guards against an origin that steps beyond p along n, but is rounded so far along the surface that
 * the sphere bends away under it: n lies along an axis on which p has a small coordinate. */
static void inside_a_far_small_sphere_the_origin_stays_inside(void **state) {
    (void)state;
    random_state = 11;
    setting s = {.type = primitive_find("sphere")};
    s.subject = subject_of(s.type);
    for (int n = 0; n < 100000; n++) {
        s.at = (dvec3){16384, between(-1, 1), between(-1, 1)};
        s.size = 1;
        desc_init(&s.type->info, &s.desc);
        s.desc.sphere.center = vec3_from(s.at);
        s.desc.sphere.radius = 0.1f;
        dvec3 target = dvec3_from(s.desc.sphere.center);
        target.y += 0.09;
        target.x += 0.01 * between(-1, 1);
        dvec3 from = target;
        from.y += 1;
        from.x += 0.01 * between(-1, 1);
        local_ray beam = ray_between(from, target);
        hit found;
        if (!s.type->intersect(&s.desc, &beam, &found)) continue;
        surface at;
        s.type->surface(&s.desc, &beam, &found, &at);
        check_no_self_hit(&s, &at);
        check_no_self_hit_in_instance(&s, &at);
    }
    assert_true(s.exits > 50000);
}

static void the_next_origin_is_beyond(void **state) {
    (void)state;
    random_state = 3;
    for (int n = 0; n < 200000; n++) {
        dvec3 place = dvec3_scale(direction(), exp2(between(-20, 30)));
        double error = exp2(between(-60, 10));
        surface s = surface_make(place, direction(), error);
        if (n % 3 == 0) s.n = (dvec3){0, n & 1 ? 1 : -1, 0};
        if (n % 5 == 0) s.error = 0;
        if (n % 7 == 0) s.p = dvec3_from(vec3_from(place)); /* exactly on floats */
        double side = n & 2 ? 1 : -1;
        vec3 o = surface_offset_origin(&s, side);
        vec moved = minus(wide(o), wide_d(s.p));
        real out = dot(moved, wide_d(s.n)) * side;
        assert_true(out > 0 && out >= s.error * (1 - 1e-15));
        real ulp = 0x1p-23L * length(wide_d(s.p)) + 0x1p-149L;
        assert_true(length(moved) <= 2 * s.error + 4 * ulp); /* and not needlessly far */
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_shape_agrees_with_a_slow_solver),
        cmocka_unit_test(odd_rays_give_no_nan_and_no_hit),
        cmocka_unit_test(reference_intersections),
        cmocka_unit_test(texture_coordinates_lie_as_documented),
        cmocka_unit_test(closed_shapes_and_half_spaces_have_sides),
        cmocka_unit_test(senseless_shapes_are_refused),
        cmocka_unit_test(a_mesh_is_checked),
        cmocka_unit_test(a_point_on_a_mesh_is_blended),
        cmocka_unit_test(a_ray_that_leaves_a_floor_meets_no_neighbour),
        cmocka_unit_test(inside_a_far_small_sphere_the_origin_stays_inside),
        cmocka_unit_test(the_next_origin_is_beyond),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    reference_free();
    return failed;
}
