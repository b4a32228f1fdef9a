/* An infinite plane. Texture coordinates are metres from `point` along the two axes of the normal's
 * frame (dvec3_frame): for the normal +Y, u is x and v is -z, right and up on a map seen from
 * above. It bounds a half-space: inside is the side that the normal points away from. */
#include "geometry/surface.h"

#define PLANE_FIELDS(F, T)                                                                         \
    F(T, point, VEC3, DEFAULT(0, 0, 0), ANY, "m", "a point on the plane")                          \
    F(T, normal, VEC3, DEFAULT(0, 1, 0), DIRECTION, "", "the direction it faces")
DESCRIBE(plane, PLANE_FIELDS)

static bounds3 bounds(const void *desc) {
    (void)desc;
    return (bounds3){{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
}

/* False when the ray runs along the plane. */
static bool solve(const plane_desc *plane, const local_ray *beam, double *t) {
    dvec3 n = dvec3_from(plane->normal);
    double slope = dvec3_dot(n, dvec3_from(beam->d));
    *t = dvec3_dot(n, dvec3_sub(dvec3_from(plane->point), dvec3_from(beam->o))) / slope;
    return slope != 0;
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    double t;
    found->u = found->v = 0;
    return solve(desc, beam, &t) && surface_accept(beam, t, &found->t);
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    const plane_desc *plane = desc;
    dvec3 point = dvec3_from(plane->point), o = dvec3_from(beam->o);
    dvec3 n = dvec3_normalize(dvec3_from(plane->normal)), along, across;
    double t;
    if (!solve(plane, beam, &t)) t = found->t;
    dvec3 offset = dvec3_sub(dvec3_add(o, dvec3_scale(dvec3_from(beam->d), t)), point);
    offset = dvec3_sub(offset, dvec3_scale(n, dvec3_dot(offset, n)));
    dvec3 p = dvec3_add(point, offset);
    double size = fabs(p.x) + fabs(p.y) + fabs(p.z) + fabs(point.x) + fabs(point.y) + fabs(point.z);
    *out = surface_make(p, n, 16 * DOUBLE_EPSILON * size);
    dvec3_frame(n, &along, &across);
    out->u = dvec3_dot(offset, along);
    out->v = dvec3_dot(offset, across);
    out->dpdu = along;
    out->dpdv = across;
}

static int side(const void *desc, dvec3 p) {
    const plane_desc *plane = desc;
    dvec3 offset = dvec3_sub(p, dvec3_from(plane->point));
    return dvec3_dot(offset, dvec3_from(plane->normal)) < 0 ? 1 : -1;
}

/* A line along the plane is inside as a whole, or not at all. */
static int spans(const void *desc, const local_ray *beam, span *out, int capacity) {
    const plane_desc *plane = desc;
    surface_crossing enter = {.t = -INFINITY}, leave = {.t = INFINITY};
    double t;
    if (!solve(plane, beam, &t)) {
        if (side(plane, dvec3_from(beam->o)) < 0) return 0;
    } else if (dvec3_dot(dvec3_from(plane->normal), dvec3_from(beam->d)) > 0) {
        leave.t = t;
    } else {
        enter.t = t;
    }
    return surface_add_span(out, 0, capacity, enter, leave);
}

extern const primitive_type primitive_plane;
const primitive_type primitive_plane = {
    .info = TYPE_INFO(CATEGORY_SHAPE, plane, "plane", "an infinite plane"),
    .flat = true,
    .unbounded = true,
    .bounds = bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .side = side,
    .spans = spans,
};
