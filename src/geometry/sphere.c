/* A sphere. Texture coordinates are longitude and latitude about +Y, seen from outside: u grows to
 * the right, 0.5 faces +Z, the seam faces -Z; v is 0 at the south pole (-Y) and 1 at the north. */
#include "geometry/sphere.h"

#include "geometry/surface.h"
#include "maths/functions.h"
#include "sampling/warp.h"

DESCRIBE_TABLE(sphere, SPHERE_FIELDS)

static bounds3 bounds(const void *desc) {
    const sphere_desc *sphere = desc;
    dvec3 c = dvec3_from(sphere->center);
    double r = sphere->radius;
    return bounds3_outward((dvec3){c.x - r, c.y - r, c.z - r}, (dvec3){c.x + r, c.y + r, c.z + r});
}

/* Both roots, t[0] <= t[1]. The origin is moved to the ray's closest approach to the centre before
 * the discriminant is formed, and the nearer root is c/q, so that neither cancels (Haines,
 * Guenther, Akenine-Moeller, Precision Improvements for Ray/Sphere Intersection, Ray Tracing Gems
 * 2019). meet_spheres (accel/kernels/spheres.inl) does the same for eight rays. */
static bool solve(const sphere_desc *sphere, const local_ray *beam, double t[2]) {
    dvec3 d = dvec3_from(beam->d);
    dvec3 f = dvec3_sub(dvec3_from(sphere->center), dvec3_from(beam->o));
    double r = sphere->radius, a = dvec3_dot(d, d), b = dvec3_dot(f, d);
    if (!(a > 0)) return false;
    dvec3 nearest = dvec3_sub(f, dvec3_scale(d, b / a));
    double discriminant = r * r - dvec3_dot(nearest, nearest);
    if (!(discriminant >= 0)) return false;
    double c = dvec3_dot(f, f) - r * r, root = sqrt(a * discriminant);
    double q = b > 0 ? b + root : b - root;
    double one = q / a, other = q != 0 ? c / q : one;
    t[0] = double_min(one, other);
    t[1] = double_max(one, other);
    return true;
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    double t[2];
    if (!solve(desc, beam, t)) return false;
    found->u = found->v = 0;
    return surface_accept(beam, t[0], &found->t) || surface_accept(beam, t[1], &found->t);
}

/* The point in the direction n (unit) from the centre. */
static void surface_at(const sphere_desc *sphere, dvec3 n, surface *out) {
    dvec3 center = dvec3_from(sphere->center);
    double r = sphere->radius;
    dvec3 p = dvec3_add(center, dvec3_scale(n, r));
    /* From an origin near p every term of the quadratic is at most r^2 and relatively exact to a
     * few roundings; so is the centre's subtraction. */
    double size = r + fabs(center.x) + fabs(center.y) + fabs(center.z);
    *out = surface_make(p, n, 16 * DOUBLE_EPSILON * size + surface_shift_error(p, 1 / r));
    out->curvature = 1 / r;
}

/* The roots are solved again in double: the float t of a far ray would move the point sideways. */
static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    const sphere_desc *sphere = desc;
    dvec3 center = dvec3_from(sphere->center), d = dvec3_from(beam->d);
    double t = found->t, roots[2];
    if (solve(sphere, beam, roots))
        t = fabs(roots[0] - t) <= fabs(roots[1] - t) ? roots[0] : roots[1];
    dvec3 from_center = dvec3_sub(dvec3_add(dvec3_from(beam->o), dvec3_scale(d, t)), center);
    dvec3 n = dvec3_normalize(from_center);
    if (!(dvec3_dot(n, n) > 0)) n = (dvec3){0, 1, 0};
    surface_at(sphere, n, out);
}

static void parametrise(const void *desc, surface *s) {
    const sphere_desc *sphere = desc;
    surface_globe(s, s->n, sphere->radius);
}

static int side(const void *desc, dvec3 p) {
    const sphere_desc *sphere = desc;
    dvec3 f = dvec3_sub(p, dvec3_from(sphere->center));
    double r = sphere->radius;
    return dvec3_dot(f, f) < r * r ? 1 : -1;
}

static int spans(const void *desc, const local_ray *beam, span *out, int capacity) {
    double t[2];
    if (!solve(desc, beam, t)) return 0;
    return surface_add_span(out, 0, capacity, (surface_crossing){.t = t[0]},
                            (surface_crossing){.t = t[1]});
}

static double area(const void *desc, uint32_t primitive) {
    (void)primitive;
    double r = ((const sphere_desc *)desc)->radius;
    return 4 * PI * r * r;
}

/* Archimedes: equal heights are equal areas. */
static void sample_area(const void *desc, uint32_t primitive, double u, double v, surface *out) {
    (void)primitive;
    double y = 1 - 2 * u, ring = sqrt(4 * u * (1 - u)), angle = 2 * PI * v;
    dvec3 n = dvec3_normalize((dvec3){ring * fn_sin(angle), y, ring * fn_cos(angle)});
    surface_at(desc, n, out);
}

/* The cone that the sphere fills at `from`: the squared sine of its half-angle and 1 - the cosine,
 * which a tiny or far sphere would lose if it were subtracted. False: not outside, or so close that
 * it might not be: a point of the sphere itself is as often out of it as in it, and the origin of a
 * ray that leaves there is a float or two away. */
static bool cone_from(const sphere_desc *sphere, dvec3 from, double *sin2, double *one_minus_cos) {
    dvec3 f = dvec3_sub(dvec3_from(sphere->center), from);
    double r = sphere->radius, square = dvec3_dot(f, f);
    double close = r + 0x1p-15 * r + 0x1p-21 * (fabs(from.x) + fabs(from.y) + fabs(from.z));
    if (!(square > close * close)) return false;
    *sin2 = r * r / square;
    if (!(*sin2 < 1 && *sin2 > 0)) return false;
    *one_minus_cos = *sin2 / (1 + sqrt(1 - *sin2));
    return true;
}

/* A direction at the angle theta from the axis meets the sphere where the normal stands at
 * beta - theta from the axis reversed; sin beta = sin theta / sin theta_max (law of sines). */
static bool sample_toward(const void *desc, dvec3 from, double u, double v, surface *out,
                          double *pdf_solid_angle) {
    const sphere_desc *sphere = desc;
    double sin2_max, width;
    if (!cone_from(sphere, from, &sin2_max, &width)) return false;
    warp_polar disk = warp_disk_polar((sample2){u, v});
    double below = disk.radius * disk.radius * width; /* 1 - cos theta */
    double sin2 = below * (2 - below), sin = sqrt(sin2), cos = 1 - below;
    double sin_beta = double_min(sqrt(sin2 / sin2_max), 1);
    double cos_beta = sqrt(1 - sin_beta * sin_beta);
    double sin_alpha = sin_beta * cos - cos_beta * sin, cos_alpha = cos_beta * cos + sin_beta * sin;
    dvec3 axis = dvec3_normalize(dvec3_sub(from, dvec3_from(sphere->center))), along, across;
    dvec3_frame(axis, &along, &across);
    dvec3 side = dvec3_add(dvec3_scale(along, disk.cosine), dvec3_scale(across, disk.sine));
    dvec3 n = dvec3_add(dvec3_scale(axis, cos_alpha), dvec3_scale(side, sin_alpha));
    surface_at(sphere, dvec3_normalize(n), out);
    *pdf_solid_angle = 1 / (2 * PI * width);
    return true;
}

static double pdf_toward(const void *desc, dvec3 from, dvec3 d) {
    (void)d;
    double sin2, width;
    return cone_from(desc, from, &sin2, &width) ? 1 / (2 * PI * width) : 0;
}

const primitive_type primitive_sphere = {
    .info = TYPE_INFO(CATEGORY_SHAPE, sphere, "sphere", "a sphere"),
    .bounds = bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .parametrise = parametrise,
    .side = side,
    .spans = spans,
    .area = area,
    .sample_area = sample_area,
    .sample_toward = sample_toward,
    .pdf_toward = pdf_toward,
};
