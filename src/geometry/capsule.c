/* A cylinder with half a ball at each end: all points nearer than the radius to the line between two
 * points. Texture coordinates: u around as on a cylinder, v by area from 0 at the tip beyond `from` to
 * 1 at the tip beyond `to`. hit.u carries the part: 0 the ball at `from`, 1 the wall, 2 the ball at
 * `to`. */
#include "base/error.h"
#include "geometry/surface.h"
#include "maths/functions.h"

#define CAPSULE_FIELDS(F, T)                                                                       \
    F(T, from, VEC3, NO_DEFAULT, REQUIRED, "m", "the centre of the ball at one end")               \
    F(T, to, VEC3, NO_DEFAULT, REQUIRED, "m", "the centre of the ball at the other end")           \
    F(T, radius, FLOAT, DEFAULT(1), POSITIVE, "m", "the radius")
DESCRIBE(capsule, CAPSULE_FIELDS)

static snell_status check(const void *desc) {
    const capsule_desc *capsule = desc;
    vec3 a = capsule->from, b = capsule->to;
    if (a.x != b.x || a.y != b.y || a.z != b.z) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "give two different points, or a 'sphere'",
                     "capsule: 'from' and 'to' are the same point");
}

static bounds3 bounds(const void *desc) {
    const capsule_desc *capsule = desc;
    dvec3 a = dvec3_from(capsule->from), b = dvec3_from(capsule->to);
    double r = capsule->radius;
    return bounds3_outward(
        (dvec3){double_min(a.x, b.x) - r, double_min(a.y, b.y) - r, double_min(a.z, b.z) - r},
        (dvec3){double_max(a.x, b.x) + r, double_max(a.y, b.y) + r, double_max(a.z, b.z) + r});
}

/* The axis: from `middle`, `half` metres either way along the unit vector y. */
typedef struct spine {
    dvec3 middle, y;
    double half, radius;
} spine;

static spine spine_of(const capsule_desc *capsule) {
    dvec3 a = dvec3_from(capsule->from), b = dvec3_from(capsule->to), along = dvec3_sub(b, a);
    return (spine){dvec3_scale(dvec3_add(a, b), 0.5), dvec3_normalize(along),
                   dvec3_length(along) / 2, capsule->radius};
}

static void widen(surface_crossing *enter, surface_crossing *leave, double near, double far,
                  float part) {
    if (near < enter->t) *enter = (surface_crossing){.t = near, .u = part};
    if (far > leave->t) *leave = (surface_crossing){.t = far, .u = part};
}

/* Where |o + t d| = r: the discriminant is formed at the line's nearest point, as for a sphere. */
static bool solve_round(dvec3 o, dvec3 d, double r, double *near, double *far) {
    double a = dvec3_dot(d, d), nearest = -dvec3_dot(o, d) / a;
    dvec3 at = dvec3_add(o, dvec3_scale(d, nearest));
    double discriminant = r * r - dvec3_dot(at, at);
    if (!(a > 0) || !(discriminant >= 0)) return false;
    double half = sqrt(discriminant / a);
    *near = nearest - half;
    *far = nearest + half;
    return true;
}

/* The capsule is the two balls and the cylinder between them, and convex: a line is inside from where
 * it first enters one of the three until it has left them all. The ends of the cylinder lie within
 * the balls. The origin is first moved to where the line is nearest to the middle. */
static bool solve(const capsule_desc *capsule, const local_ray *beam, surface_crossing *enter,
                  surface_crossing *leave) {
    spine s = spine_of(capsule);
    dvec3 d = dvec3_from(beam->d), o = dvec3_sub(dvec3_from(beam->o), s.middle);
    double square = dvec3_dot(d, d), shift = -dvec3_dot(o, d) / square, near, far;
    if (!(square > 0)) return false;
    o = dvec3_add(o, dvec3_scale(d, shift));
    *enter = (surface_crossing){.t = INFINITY};
    *leave = (surface_crossing){.t = -INFINITY};
    dvec3 end = dvec3_scale(s.y, s.half);
    if (solve_round(dvec3_add(o, end), d, s.radius, &near, &far)) widen(enter, leave, near, far, 0);
    if (solve_round(dvec3_sub(o, end), d, s.radius, &near, &far)) widen(enter, leave, near, far, 2);
    double oy = dvec3_dot(o, s.y), dy = dvec3_dot(d, s.y);
    dvec3 flat_o = dvec3_sub(o, dvec3_scale(s.y, oy)), flat_d = dvec3_sub(d, dvec3_scale(s.y, dy));
    if (solve_round(flat_o, flat_d, s.radius, &near, &far)) {
        double low = (dy > 0 ? -s.half : s.half) - oy, high = (dy > 0 ? s.half : -s.half) - oy;
        bool along = dy == 0 && fabs(oy) <= s.half;
        if (along || (dy != 0 && near >= low / dy && near <= high / dy))
            widen(enter, leave, near, leave->t, 1);
        if (along || (dy != 0 && far >= low / dy && far <= high / dy))
            widen(enter, leave, enter->t, far, 1);
    }
    enter->t += shift;
    leave->t += shift;
    return enter->t <= leave->t;
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    surface_crossing enter, leave;
    if (!solve(desc, beam, &enter, &leave)) return false;
    found->u = enter.u;
    found->v = 0;
    if (surface_accept(beam, enter.t, &found->t)) return true;
    found->u = leave.u;
    return surface_accept(beam, leave.t, &found->t);
}

/* The point at the height `along` the axis from its middle, in the direction n (unit). */
static surface surface_at(const spine *s, double along, dvec3 n) {
    double r = s->radius;
    dvec3 p = dvec3_add(s->middle, dvec3_add(dvec3_scale(s->y, along), dvec3_scale(n, r)));
    double size = r + s->half + fabs(s->middle.x) + fabs(s->middle.y) + fabs(s->middle.z);
    surface made = surface_make(p, n, 32 * DOUBLE_EPSILON * size + surface_shift_error(p, 1 / r));
    made.curvature = 1 / r;
    return made;
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    spine s = spine_of(desc);
    surface_crossing enter, leave;
    double t = found->t;
    if (solve(desc, beam, &enter, &leave))
        t = fabs(enter.t - t) <= fabs(leave.t - t) ? enter.t : leave.t;
    dvec3 o = dvec3_sub(dvec3_from(beam->o), s.middle);
    dvec3 p = dvec3_add(o, dvec3_scale(dvec3_from(beam->d), t));
    double along = double_max(-s.half, double_min(dvec3_dot(p, s.y), s.half));
    dvec3 n = dvec3_normalize(dvec3_sub(p, dvec3_scale(s.y, along)));
    if (!(dvec3_dot(n, n) > 0)) n = s.y;
    *out = surface_at(&s, along, n);
}

static void parametrise(const void *desc, surface *s) {
    spine axis = spine_of(desc);
    double r = axis.radius, total = 2 * (axis.half + r);
    dvec3 x, across;
    dvec3_frame(axis.y, &x, &across);
    dvec3 z = dvec3_negate(across), p = dvec3_sub(s->p, axis.middle);
    double px = dvec3_dot(p, x), py = dvec3_dot(p, axis.y), pz = dvec3_dot(p, z);
    double ring = sqrt(px * px + pz * pz), height = dvec3_dot(s->n, axis.y);
    s->u = 0.5 + fn_atan2(px, pz) / (2 * PI);
    s->v = clamp01(0.5 + py / total);
    if (!(ring > 0x1p-40 * r)) return; /* a tip: u has no direction */
    s->dpdu = dvec3_scale(dvec3_sub(dvec3_scale(x, pz), dvec3_scale(z, px)), 2 * PI);
    /* Down a meridian of a ball the ring grows by -height / sqrt(1 - height^2) of a step up. */
    dvec3 outward = dvec3_add(dvec3_scale(x, px / ring), dvec3_scale(z, pz / ring));
    double steep = sqrt(double_max(1 - height * height, 0));
    if (!(steep > 0)) return;
    dvec3 up = dvec3_sub(axis.y, dvec3_scale(outward, height / steep));
    s->dpdv = dvec3_scale(up, total);
}

/* Along the wall the normal does not turn. */
static dvec3 bend(const void *desc, const hit *found, dvec3 dp) {
    spine s = spine_of(desc);
    if (found->u == 1) dp = dvec3_sub(dp, dvec3_scale(s.y, dvec3_dot(dp, s.y)));
    return dvec3_scale(dp, 1 / s.radius);
}

static int side(const void *desc, dvec3 point) {
    spine s = spine_of(desc);
    dvec3 p = dvec3_sub(point, s.middle);
    double along = double_max(-s.half, double_min(dvec3_dot(p, s.y), s.half));
    dvec3 away = dvec3_sub(p, dvec3_scale(s.y, along));
    return dvec3_dot(away, away) < s.radius * s.radius ? 1 : -1;
}

static int spans(const void *desc, const local_ray *beam, span *out, int capacity) {
    surface_crossing enter, leave;
    if (!solve(desc, beam, &enter, &leave)) return 0;
    return surface_add_span(out, 0, capacity, enter, leave);
}

static double area(const void *desc, uint32_t primitive) {
    (void)primitive;
    spine s = spine_of(desc);
    return 4 * PI * s.radius * (s.half + s.radius);
}

/* Archimedes: equal heights are equal areas, on the balls as on the wall. */
static void sample_area(const void *desc, uint32_t primitive, double u, double v, surface *out) {
    (void)primitive;
    spine s = spine_of(desc);
    double height = (2 * u - 1) * (s.half + s.radius), angle = 2 * PI * v;
    double along = double_max(-s.half, double_min(height, s.half));
    double up = (height - along) / s.radius, ring = sqrt(double_max(1 - up * up, 0));
    dvec3 x, across;
    dvec3_frame(s.y, &x, &across);
    dvec3 outward = dvec3_sub(dvec3_scale(x, fn_sin(angle)), dvec3_scale(across, fn_cos(angle)));
    dvec3 n = dvec3_add(dvec3_scale(outward, ring), dvec3_scale(s.y, up));
    *out = surface_at(&s, along, dvec3_normalize(n));
}

extern const primitive_type primitive_capsule;
const primitive_type primitive_capsule = {
    .info = TYPE_INFO(CATEGORY_SHAPE, capsule, "capsule", "a cylinder with rounded ends"),
    .check = check,
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
