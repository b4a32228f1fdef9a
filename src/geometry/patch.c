/* Bicubic Bezier patches, as many as one likes in one shape: 16 controls each, four rows of four, u
 * along a row and v from row to row. The front is where u runs to the right and v up. Texture
 * coordinates are the patch's own u and v.
 *
 * Each patch is cut into CELLS x CELLS parts with boxes of their own. Across the ray a part is a map
 * from (u, v) to the plane, and the ray is its point (0, 0). The part is halved until that point is
 * outside the box of the controls, which holds the surface, or until the map is regular: all its
 * derivatives by u turn the same way from all those by v, so that it does not fold. There Newton's
 * method finds the one root there may be. Next to a silhouette, where the map folds, halving ends after
 * DEPTH_MAX steps. A root counts up to ROOM beyond the edges of a part: a ray finds a seam in both
 * patches that share it, not in none, if their controls along it are the same. */
#include "base/error.h"
#include "geometry/bernstein.h"
#include "geometry/surface.h"

#define PATCH_FIELDS(F, T)                                                                         \
    F(T, points, VEC3S, NO_DEFAULT, REQUIRED, "m", "the controls, 16 per patch, or for 'indices'") \
    F(T, indices, UINTS, NO_DEFAULT, ANY, "", "16 numbers of points, from 0, per patch")
DESCRIBE(patch, PATCH_FIELDS)

enum { CELLS = 4, PARTS = CELLS * CELLS, DEPTH_MAX = 24, PATCHES_MAX = 1 << 23, ROOTS_MAX = 18 };
/* Pieces that one ray looks at in a part. Patches that are a line or a point would take 2^DEPTH_MAX. */
enum { LOOKS_MAX = 1 << 13 };
#define ROOM 0x1p-30

static size_t patch_count(const patch_desc *patch) {
    return (patch->indices_count ? patch->indices_count : patch->points_count) / 16;
}

static snell_status check(const void *desc) {
    const patch_desc *patch = desc;
    const char *name = patch->indices_count ? "indices" : "points";
    size_t count = patch->indices_count ? patch->indices_count : patch->points_count;
    if (count % 16 != 0 || count == 0)
        return error_set(SNELL_ERR_ARGUMENT, "four rows of four controls per patch",
                         "patch: '%s' has %zu entries; it must have 16 for each patch", name,
                         count);
    if (count / 16 > PATCHES_MAX)
        return error_set(SNELL_ERR_ARGUMENT, "split them into several shapes",
                         "patch: %zu patches are too many", count / 16);
    for (size_t i = 0; i < patch->indices_count; i++)
        if (patch->indices[i] >= patch->points_count)
            return error_set(SNELL_ERR_ARGUMENT, "indices count from 0",
                             "patch: index %u of patch %zu is out of range: there are %zu points",
                             patch->indices[i], i / 16 + 1, patch->points_count);
    return SNELL_OK;
}

/* Coordinates of the controls, 4 v + u, of a patch or a piece of one. */
typedef struct net {
    double x[16], y[16], z[16];
} net;

/* As seen from `o`, along the axes x, y and z. */
static void net_of(const patch_desc *patch, size_t index, dvec3 o, dvec3 x, dvec3 y, dvec3 z,
                   net *out) {
    for (size_t i = 0; i < 16; i++) {
        size_t at = 16 * index + i;
        dvec3 p = dvec3_from(patch->points[patch->indices_count ? patch->indices[at] : at]);
        p = dvec3_sub(p, o);
        out->x[i] = dvec3_dot(p, x);
        out->y[i] = dvec3_dot(p, y);
        out->z[i] = dvec3_dot(p, z);
    }
}

static void plain_net(const patch_desc *patch, size_t index, net *out) {
    net_of(patch, index, (dvec3){0, 0, 0}, (dvec3){1, 0, 0}, (dvec3){0, 1, 0}, (dvec3){0, 0, 1},
           out);
}

/* Where a part begins, in 1 / CELLS. */
static void cell_of(uint32_t part, double *u, double *v) {
    *u = (double)(part % CELLS) / CELLS;
    *v = (double)(part % PARTS / CELLS) / CELLS;
}

static void restrict_coordinate(double c[16], double u, double v) {
    for (int row = 0; row < 4; row++) bernstein_restrict(c + 4 * row, 3, u, u + 1.0 / CELLS);
    for (int column = 0; column < 4; column++) {
        double line[4];
        for (int row = 0; row < 4; row++) line[row] = c[4 * row + column];
        bernstein_restrict(line, 3, v, v + 1.0 / CELLS);
        for (int row = 0; row < 4; row++) c[4 * row + column] = line[row];
    }
}

static void restrict_net(net *n, uint32_t part) {
    double u, v;
    cell_of(part, &u, &v);
    restrict_coordinate(n->x, u, v);
    restrict_coordinate(n->y, u, v);
    restrict_coordinate(n->z, u, v);
}

typedef struct jet {
    double value, du, dv;
} jet;

static jet jet_at(const double c[16], double u, double v) {
    double along[4], slope[4];
    jet j;
    for (int row = 0; row < 4; row++) along[row] = bernstein_value(c + 4 * row, 3, u, &slope[row]);
    j.value = bernstein_value(along, 3, v, &j.dv);
    j.du = bernstein_value(slope, 3, v, NULL);
    return j;
}

/* ---- boxes ---- */

static uint32_t primitive_count(const void *desc) { return (uint32_t)patch_count(desc) * PARTS; }

static void extend(const double c[16], double *low, double *high) {
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < 16; i++) {
        *low = double_min(*low, c[i]);
        *high = double_max(*high, c[i]);
    }
}

/* Of the part's controls; wider by a few float roundings, as for a disk. */
static bounds3 primitive_bounds(const void *desc, uint32_t part) {
    net n;
    dvec3 low, high;
    plain_net(desc, part / PARTS, &n);
    restrict_net(&n, part);
    extend(n.x, &low.x, &high.x);
    extend(n.y, &low.y, &high.y);
    extend(n.z, &low.z, &high.z);
    double largest = double_max(dvec3_largest(high), dvec3_largest(dvec3_negate(low)));
    double wider = 4 * FLOAT_EPSILON * (largest + dvec3_largest(dvec3_sub(high, low)));
    dvec3 margin = {wider, wider, wider};
    return bounds3_outward(dvec3_sub(low, margin), dvec3_add(high, margin));
}

static bounds3 bounds(const void *desc) {
    bounds3 box = bounds3_empty();
    uint32_t count = primitive_count(desc);
    for (uint32_t i = 0; i < count; i++) box = bounds3_union(box, primitive_bounds(desc, i));
    return box;
}

/* ---- rays ---- */

/* A place where the ray meets the part: t along it, u and v of the part. */
typedef struct root {
    double t, u, v;
} root;

typedef struct search {
    const double *z; /* of the whole part */
    root *roots;     /* in ascending order of t */
    int count;
    int looks; /* left */
} search;

/* Once: two halves that meet at a root both find it. */
static void add_root(search *s, double u, double v) {
    for (int i = 0; i < s->count; i++)
        if (fabs(s->roots[i].u - u) < 8 * ROOM && fabs(s->roots[i].v - v) < 8 * ROOM) return;
    if (s->count == ROOTS_MAX) return;
    root made = {jet_at(s->z, u, v).value, u, v};
    int i = s->count++;
    for (; i > 0 && s->roots[i - 1].t > made.t; i--) s->roots[i] = s->roots[i - 1];
    s->roots[i] = made;
}

/* Do all differences of controls along u turn the same way from all those along v? */
static bool is_regular(const net *n) {
    double ux[12], uy[12], vx[12], vy[12];
    for (int i = 0; i < 12; i++) {
        int a = i / 3 * 4 + i % 3; /* a and its neighbour along u */
        ux[i] = n->x[a + 1] - n->x[a];
        uy[i] = n->y[a + 1] - n->y[a];
        vx[i] = n->x[i + 4] - n->x[i];
        vy[i] = n->y[i + 4] - n->y[i];
    }
    bool left = ux[0] * vy[0] - uy[0] * vx[0] > 0;
    for (int i = 0; i < 12; i++)
        for (int j = 0; j < 12; j++) {
            double turn = ux[i] * vy[j] - uy[i] * vx[j];
            if (left ? !(turn > 0) : !(turn < 0)) return false;
        }
    return true;
}

/* Newton's method from the middle. False: it does not settle. */
static bool settle(const net *n, double *u, double *v) {
    *u = *v = 0.5;
    for (int i = 0; i < 16; i++) {
        jet x = jet_at(n->x, *u, *v), y = jet_at(n->y, *u, *v);
        double det = x.du * y.dv - x.dv * y.du;
        double du = (x.dv * y.value - y.dv * x.value) / det;
        double dv = (y.du * x.value - x.du * y.value) / det;
        *u += du;
        *v += dv;
        if (!(fabs(*u - 0.5) < 4 && fabs(*v - 0.5) < 4)) return false;
        if (fabs(du) < 0x1p-46 && fabs(dv) < 0x1p-46) return true;
    }
    return false;
}

/* 4 values `step` apart, at their middle: the controls of both halves. */
static void halve(const double *c, int step, double *left, double *right) {
    double a = c[0], b = c[step], d = c[2 * step], e = c[3 * step];
    double ab = (a + b) / 2, bd = (b + d) / 2, de = (d + e) / 2;
    double abd = (ab + bd) / 2, bde = (bd + de) / 2, middle = (abd + bde) / 2;
    left[0] = a, left[step] = ab, left[2 * step] = abd, left[3 * step] = middle;
    right[0] = middle, right[step] = bde, right[2 * step] = de, right[3 * step] = e;
}

static double extent(const net *n, int step) {
    double sum = 0; /* from the first controls to the last ones along u (1) or v (4) */
    for (int i = 0; i < 4; i++) {
        int a = step == 1 ? 4 * i : i, b = a + 3 * step;
        sum += fabs(n->x[b] - n->x[a]) + fabs(n->y[b] - n->y[a]);
    }
    return sum;
}

static bool holds_zero(const double c[16]) {
    double low, high;
    extend(c, &low, &high);
    return low <= 0 && high >= 0;
}

/* A piece that is seen nearly edge on is a thin strip, askew in its box. Are all controls on one side
 * of the line along it through the ray, by more than rounding? */
static bool passes_beside(const net *n, int step) {
    double dx = 0, dy = 0, low = INFINITY, high = -INFINITY, size = 0;
    for (int i = 0; i < 4; i++) {
        int a = step == 1 ? 4 * i : i, b = a + 3 * step;
        dx += n->x[b] - n->x[a];
        dy += n->y[b] - n->y[a];
    }
    for (int i = 0; i < 16; i++) {
        double left = n->x[i] * dy, right = n->y[i] * dx;
        low = double_min(low, left - right);
        high = double_max(high, left - right);
        size = double_max(size, fabs(left) + fabs(right));
    }
    return low > 0x1p-48 * size || high < -0x1p-48 * size;
}

typedef struct window {
    double u, v, width_u, width_v;
} window;

/* The recursion ends at DEPTH_MAX, or when it has looked at enough. */
static void find(search *s, const net *n, window w, int depth) {
    if (s->looks-- <= 0 || !holds_zero(n->x) || !holds_zero(n->y)) return;
    int step = extent(n, 1) >= extent(n, 4) ? 1 : 4;
    if (passes_beside(n, step)) return;
    bool last = depth == DEPTH_MAX;
    if (last || is_regular(n)) {
        double u, v, room_u = ROOM / w.width_u, room_v = ROOM / w.width_v;
        bool settled = settle(n, &u, &v);
        if (settled && u >= -room_u && u <= 1 + room_u && v >= -room_v && v <= 1 + room_v) {
            add_root(s, clamp01(w.u + w.width_u * u), clamp01(w.v + w.width_v * v));
            return;
        }
        /* What settles outside may have jumped over a root inside. */
    }
    if (last) return;
    net left, right;
    if (depth % 4 == 3) step = w.width_u >= w.width_v ? 1 : 4; /* where both seem to be short */
    for (int i = 0; i < 4; i++) {
        int at = step == 1 ? 4 * i : i;
        halve(n->x + at, step, left.x + at, right.x + at);
        halve(n->y + at, step, left.y + at, right.y + at);
    }
    window other = w;
    if (step == 1) {
        w.width_u = other.width_u /= 2;
        other.u += w.width_u;
    } else {
        w.width_v = other.width_v /= 2;
        other.v += w.width_v;
    }
    find(s, &left, w, depth + 1);
    find(s, &right, other, depth + 1);
}

/* All roots, t in the ray's own. */
static int solve(const patch_desc *patch, uint32_t part, const local_ray *beam,
                 root roots[ROOTS_MAX]) {
    dvec3 d = dvec3_from(beam->d), o = dvec3_from(beam->o), x, y;
    double speed = dvec3_length(d);
    if (!(speed > 0)) return 0;
    d = dvec3_scale(d, 1 / speed);
    dvec3_frame(d, &x, &y);
    size_t first = 16 * (part / (size_t)PARTS);
    dvec3 near = dvec3_from(patch->points[patch->indices_count ? patch->indices[first] : first]);
    double shift = dvec3_dot(dvec3_sub(near, o), d);
    net n;
    net_of(patch, part / PARTS, dvec3_add(o, dvec3_scale(d, shift)), x, y, d, &n);
    restrict_net(&n, part);
    search s = {.z = n.z, .roots = roots, .looks = LOOKS_MAX};
    find(&s, &n, (window){0, 0, 1, 1}, 0);
    for (int i = 0; i < s.count; i++) roots[i].t = (roots[i].t + shift) / speed;
    return s.count;
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    root roots[ROOTS_MAX];
    int count = solve(desc, found->primitive, beam, roots);
    double u, v;
    cell_of(found->primitive, &u, &v);
    for (int i = 0; i < count; i++) {
        if (!surface_accept(beam, roots[i].t, &found->t)) continue;
        found->u = (float)(u + roots[i].u / CELLS);
        found->v = (float)(v + roots[i].v / CELLS);
        return true;
    }
    return false;
}

/* ---- points ---- */

typedef struct point {
    dvec3 p, du, dv;
} point;

static point point_at(const net *n, double u, double v) {
    jet x = jet_at(n->x, u, v), y = jet_at(n->y, u, v), z = jet_at(n->z, u, v);
    return (point){{x.value, y.value, z.value}, {x.du, y.du, z.du}, {x.dv, y.dv, z.dv}};
}

/* The normal; where an edge of the patch is one point, that of a point beside it. */
static dvec3 normal_at(const net *n, double u, double v) {
    for (double step = 0x1p-20;; step *= 16) {
        point at = point_at(n, u, v);
        dvec3 normal = dvec3_cross(at.du, at.dv);
        double size = dvec3_length(at.du) * dvec3_length(at.dv);
        if (dvec3_length(normal) > 0x1p-36 * size) return dvec3_normalize(normal);
        if (step > 0.25) return (dvec3){0, 1, 0}; /* a patch without any area */
        u += u < 0.5 ? step : -step;
        v += v < 0.5 ? step : -step;
    }
}

/* The larger principal curvature: of the first and second fundamental forms. */
static double curvature_at(const net *n, double u, double v, dvec3 normal) {
    const double step = 0x1p-10;
    point at = point_at(n, u, v), right = point_at(n, u + step, v), left = point_at(n, u - step, v),
          above = point_at(n, u, v + step), below = point_at(n, u, v - step);
    double e = dvec3_dot(at.du, at.du), f = dvec3_dot(at.du, at.dv), g = dvec3_dot(at.dv, at.dv);
    double l = dvec3_dot(dvec3_sub(right.du, left.du), normal) / (2 * step);
    double m = dvec3_dot(dvec3_sub(right.dv, left.dv), normal) / (2 * step);
    double k = dvec3_dot(dvec3_sub(above.dv, below.dv), normal) / (2 * step);
    double area = e * g - f * f, mean = (e * k - 2 * f * m + g * l) / (2 * area);
    double square = mean * mean - (l * k - m * m) / area;
    double largest = fabs(mean) + sqrt(double_max(square, 0));
    return largest <= 0x1p100 ? largest : 0; /* at a pole: none */
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    root roots[ROOTS_MAX];
    int count = solve(desc, found->primitive, beam, roots);
    double u, v, best = INFINITY, at_u = (double)found->u, at_v = (double)found->v;
    cell_of(found->primitive, &u, &v);
    for (int i = 0; i < count; i++) {
        double off = fabs(roots[i].t - (double)found->t);
        if (off >= best) continue;
        best = off;
        at_u = u + roots[i].u / CELLS;
        at_v = v + roots[i].v / CELLS;
    }
    net n;
    plain_net(desc, found->primitive / PARTS, &n);
    point at = point_at(&n, at_u, at_v);
    dvec3 normal = normal_at(&n, at_u, at_v);
    double low[3], high[3], size = 0;
    extend(n.x, &low[0], &high[0]);
    extend(n.y, &low[1], &high[1]);
    extend(n.z, &low[2], &high[2]);
    for (int i = 0; i < 3; i++) size += double_max(fabs(low[i]), fabs(high[i])) + high[i] - low[i];
    double curvature = curvature_at(&n, at_u, at_v, normal);
    *out = surface_make(at.p, normal,
                        128 * DOUBLE_EPSILON * size + surface_shift_error(at.p, curvature));
    out->curvature = curvature;
    out->u = at_u;
    out->v = at_v;
    out->dpdu = at.du;
    out->dpdv = at.dv;
}

/* dp is du dp/du + dv dp/dv, by least squares; the normal a part of that way on. */
static dvec3 bend(const void *desc, const hit *found, dvec3 dp) {
    const double part = 0x1p-20;
    double u = (double)found->u, v = (double)found->v;
    net n;
    plain_net(desc, found->primitive / PARTS, &n);
    point at = point_at(&n, u, v);
    double e = dvec3_dot(at.du, at.du), f = dvec3_dot(at.du, at.dv), g = dvec3_dot(at.dv, at.dv);
    double a = dvec3_dot(at.du, dp), b = dvec3_dot(at.dv, dp), det = e * g - f * f;
    double du = (a * g - b * f) / det, dv = (b * e - a * f) / det;
    double longest = double_max(fabs(du), fabs(dv)), scale = part / longest;
    if (!(longest > 0 && longest <= 0x1p60 && det > 0)) return (dvec3){0, 0, 0};
    dvec3 before = normal_at(&n, u - du * scale, v - dv * scale);
    dvec3 after = normal_at(&n, u + du * scale, v + dv * scale);
    return dvec3_scale(dvec3_sub(after, before), 1 / (2 * scale));
}

extern const primitive_type primitive_patch;
const primitive_type primitive_patch = {
    .info = TYPE_INFO(CATEGORY_SHAPE, patch, "patch", "bicubic Bezier patches"),
    .check = check,
    .bounds = bounds,
    .primitive_count = primitive_count,
    .primitive_bounds = primitive_bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .bend = bend,
};
