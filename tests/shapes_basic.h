/* Slow solvers of what is flat, of spheres and boxes, and of what is turned about an axis. */
#ifndef SNELL_TESTS_SHAPES_BASIC_H
#define SNELL_TESTS_SHAPES_BASIC_H

#include "shape_subject.h"

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

static const subject subjects_basic[] = {
    {.name = "sphere", .make = make_sphere, .solve = solve_sphere, .distance = distance_sphere},
    {.name = "plane", .make = make_plane, .solve = solve_plane, .distance = distance_plane},
    {.name = "disk", .make = make_disk, .solve = solve_disk, .distance = distance_disk},
    {.name = "quad", .make = make_quad, .solve = solve_quad, .distance = distance_quad},
    {.name = "box", .make = make_box, .solve = solve_box, .distance = distance_box},
    {.name = "cylinder",
     .make = make_cylinder,
     .solve = solve_cylinder,
     .distance = distance_cylinder,
     .edge = edge_cylinder},
    {.name = "cone",
     .make = make_cone,
     .solve = solve_cone,
     .distance = distance_cone,
     .edge = edge_cone},
    {.name = "torus",
     .make = make_torus,
     .solve = solve_torus,
     .distance = distance_torus,
     .winding = true},
    {.name = "lathe",
     .make = make_lathe,
     .solve = solve_lathe,
     .distance = distance_lathe,
     .edge = edge_lathe,
     .winding = true,
     .upright = true},
};

#endif
