/* An ellipsoid along the axes. Texture coordinates are those of the sphere that it is stretched from.
 * hit.u and hit.v carry the point of that sphere, for `bend`. */
#include "geometry/surface.h"
#include "maths/functions.h"
#include "sampling/sampling.h"

#define ELLIPSOID_FIELDS(F, T)                                                                     \
    F(T, center, VEC3, DEFAULT(0, 0, 0), ANY, "m", "the centre")                                   \
    F(T, radii, VEC3, DEFAULT(1, 1, 1), POSITIVE, "m", "half the size along x, y and z")
DESCRIBE(ellipsoid, ELLIPSOID_FIELDS)

static dvec3 divide(dvec3 a, dvec3 b) { return (dvec3){a.x / b.x, a.y / b.y, a.z / b.z}; }

static bounds3 bounds(const void *desc) {
    const ellipsoid_desc *ellipsoid = desc;
    dvec3 c = dvec3_from(ellipsoid->center), r = dvec3_from(ellipsoid->radii);
    return bounds3_outward(dvec3_sub(c, r), dvec3_add(c, r));
}

/* Both roots, t[0] <= t[1], and the points of the unit sphere there. In units of the radii this is a
 * sphere's problem, and solved like one: the origin goes to where the line is nearest to the centre
 * before the discriminant is formed, and the nearer root is c / q. */
static bool solve(const ellipsoid_desc *ellipsoid, const local_ray *beam, double t[2],
                  dvec3 at[2]) {
    dvec3 radii = dvec3_from(ellipsoid->radii);
    dvec3 o = divide(dvec3_sub(dvec3_from(beam->o), dvec3_from(ellipsoid->center)), radii);
    dvec3 d = divide(dvec3_from(beam->d), radii);
    double a = dvec3_dot(d, d), b = -dvec3_dot(o, d);
    if (!(a > 0)) return false;
    dvec3 nearest = dvec3_add(o, dvec3_scale(d, b / a));
    double discriminant = 1 - dvec3_dot(nearest, nearest);
    if (!(discriminant >= 0)) return false;
    double c = dvec3_dot(o, o) - 1, root = sqrt(a * discriminant);
    double q = b > 0 ? b + root : b - root;
    double one = q / a, other = q != 0 ? c / q : one;
    t[0] = double_min(one, other);
    t[1] = double_max(one, other);
    dvec3 step = dvec3_scale(d, sqrt(discriminant / a));
    at[0] = dvec3_normalize(dvec3_sub(nearest, step));
    at[1] = dvec3_normalize(dvec3_add(nearest, step));
    return true;
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    double t[2];
    dvec3 at[2];
    return solve(desc, beam, t, at) && surface_accept_either(beam, t, at, found);
}

/* The largest curvature at the point `at` of the unit sphere. The gradient of |p / r|^2 / 2 is g =
 * at / r and its second derivatives are 1 / r^2: the two curvatures have the sum (sum 1 / r_i^2 - n
 * r^-2 n) / |g| and the product 1 / (r_x r_y r_z |g|^2)^2. */
static double curvature_at(dvec3 radii, dvec3 g) {
    double length = dvec3_length(g), volume = radii.x * radii.y * radii.z * length * length;
    dvec3 n = dvec3_scale(g, 1 / length), across = divide(n, radii);
    dvec3 inverse = divide((dvec3){1, 1, 1}, radii);
    double half = (dvec3_dot(inverse, inverse) - dvec3_dot(across, across)) / (2 * length);
    return half + sqrt(double_max(half * half - 1 / (volume * volume), 0));
}

/* The point above the point n of the unit sphere. */
static void surface_at(const ellipsoid_desc *ellipsoid, dvec3 n, surface *out) {
    dvec3 center = dvec3_from(ellipsoid->center), radii = dvec3_from(ellipsoid->radii);
    dvec3 p = dvec3_add(center, dvec3_mul(n, radii)), g = divide(n, radii);
    double size = dvec3_largest(radii) + fabs(center.x) + fabs(center.y) + fabs(center.z);
    double curvature = curvature_at(radii, g);
    *out = surface_make(p, dvec3_normalize(g),
                        32 * DOUBLE_EPSILON * size + surface_shift_error(p, curvature));
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

/* The point of the unit sphere. */
static dvec3 to_sphere(const ellipsoid_desc *ellipsoid, dvec3 p) {
    return divide(dvec3_sub(p, dvec3_from(ellipsoid->center)), dvec3_from(ellipsoid->radii));
}

static void parametrise(const void *desc, surface *s) {
    const ellipsoid_desc *ellipsoid = desc;
    dvec3 radii = dvec3_from(ellipsoid->radii);
    surface_globe(s, dvec3_normalize(to_sphere(ellipsoid, s->p)), 1);
    s->dpdu = dvec3_mul(s->dpdu, radii);
    s->dpdv = dvec3_mul(s->dpdv, radii);
}

/* The gradient changes by dp / r^2; its part along the normal does not turn the normal. */
static dvec3 bend(const void *desc, const hit *found, dvec3 dp) {
    dvec3 radii = dvec3_from(((const ellipsoid_desc *)desc)->radii);
    dvec3 g = divide(surface_unfold(found->u, found->v), radii);
    double length = dvec3_length(g);
    dvec3 n = dvec3_scale(g, 1 / length);
    dvec3 change = dvec3_scale(divide(divide(dp, radii), radii), 1 / length);
    return dvec3_sub(change, dvec3_scale(n, dvec3_dot(n, change)));
}

static int side(const void *desc, dvec3 p) {
    dvec3 at = to_sphere(desc, p);
    return dvec3_dot(at, at) < 1 ? 1 : -1;
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

/* Carlson's R_F and R_D by his duplication theorem (Numerical Computation of Real or Complex Elliptic
 * Integrals, Numerical Algorithms 10, 1995; NIST DLMF 19.36). Each step brings the arguments four
 * times nearer to their mean; the series that remains is exact to a double. */
static void carlson(double x, double y, double z, double *rf, double *rd) {
    double scale = 1, sum = 0;
    for (int i = 0; i < 40; i++) {
        double a = sqrt(x), b = sqrt(y), c = sqrt(z), lambda = a * b + b * c + c * a;
        sum += scale / (c * (z + lambda));
        scale /= 4;
        x = (x + lambda) / 4;
        y = (y + lambda) / 4;
        z = (z + lambda) / 4;
    }
    *rf = 1 / sqrt((x + y + z) / 3);
    double mean = (x + y + 3 * z) / 5;
    *rd = 3 * sum + scale / (mean * sqrt(mean));
}

/* 4 pi R_G of the squared products of two radii each (DLMF 19.33.1), where 2 R_G = z R_F - (x - z)(y -
 * z) R_D / 3 + sqrt(x y / z) (19.21.10); z is the middle one: then nothing cancels. In units of the
 * largest product, x. */
static double area(const void *desc, uint32_t primitive) {
    (void)primitive;
    dvec3 r = dvec3_from(((const ellipsoid_desc *)desc)->radii);
    double one = r.x * r.y, two = r.y * r.z, three = r.z * r.x, rf, rd;
    double largest = double_max(double_max(one, two), three);
    double least = double_min(double_min(one, two), three);
    double middle = double_max(double_min(one, two), double_min(double_max(one, two), three));
    double y = least / largest, z = middle / largest;
    double y2 = y * y, z2 = z * z;
    carlson(1, y2, z2, &rf, &rd);
    return 2 * PI * largest * (z2 * rf + (1 - z2) * (z2 - y2) * rd / 3 + y / z);
}

/* A point of the sphere, kept with a chance that is proportional to how much the ellipsoid stretches
 * its surroundings: |n / r| times the radii's product, at most the product of the two largest. No
 * less than half of the points are kept, whatever the radii. */
static void sample_area(const void *desc, uint32_t primitive, double u, double v, surface *out) {
    (void)primitive;
    const ellipsoid_desc *ellipsoid = desc;
    dvec3 radii = dvec3_from(ellipsoid->radii), n = {0, 1, 0};
    double least = double_min(double_min(radii.x, radii.y), radii.z);
    double x = u, around = v;
    for (uint32_t i = 0; i < 384; i += 3) {
        double y = 1 - 2 * x, ring = sqrt(4 * x * (1 - x)), angle = 2 * PI * around;
        n = dvec3_normalize((dvec3){ring * fn_sin(angle), y, ring * fn_cos(angle)});
        if (sample_more(u, v, i) <= least * dvec3_length(divide(n, radii))) break;
        x = sample_more(u, v, i + 1);
        around = sample_more(u, v, i + 2);
    }
    surface_at(ellipsoid, n, out);
}

extern const primitive_type primitive_ellipsoid;
const primitive_type primitive_ellipsoid = {
    .info = TYPE_INFO(CATEGORY_SHAPE, ellipsoid, "ellipsoid", "a stretched sphere"),
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
