/* A cylinder between two points. Texture coordinates of the wall: u around as on a sphere, seen from
 * outside with `to` above, v from 0 at `from` to 1 at `to`; of the caps: u the same, v from 0 in the
 * middle to 1 at the rim. For the axis +Y, u = 0.5 faces +Z. */
#include "base/error.h"
#include "geometry/revolved.h"

#define CYLINDER_FIELDS(F, T)                                                                      \
    F(T, from, VEC3, NO_DEFAULT, REQUIRED, "m", "the middle of one end")                           \
    F(T, to, VEC3, NO_DEFAULT, REQUIRED, "m", "the middle of the other end")                       \
    F(T, radius, FLOAT, DEFAULT(1), POSITIVE, "m", "the radius")                                   \
    F(T, capped, BOOL, DEFAULT(1), ANY, "", "closed by a disk at both ends")
DESCRIBE(cylinder, CYLINDER_FIELDS)

static snell_status check(const void *desc) {
    const cylinder_desc *cylinder = desc;
    vec3 a = cylinder->from, b = cylinder->to;
    if (a.x != b.x || a.y != b.y || a.z != b.z) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "give two different points, or a 'disk'",
                     "cylinder: 'from' and 'to' are the same point");
}

static revolved revolved_of(const void *desc) {
    const cylinder_desc *cylinder = desc;
    double r = cylinder->radius;
    return revolved_frustum(cylinder->from, cylinder->to, r, r, cylinder->capped);
}

static bounds3 bounds(const void *desc) {
    revolved shape = revolved_of(desc);
    return revolved_bounds(&shape);
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    revolved shape = revolved_of(desc);
    return revolved_intersect(&shape, beam, found);
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    revolved shape = revolved_of(desc);
    revolved_surface(&shape, beam, found, out);
}

static void parametrise(const void *desc, surface *s) {
    revolved shape = revolved_of(desc);
    revolved_parametrise(&shape, s);
}

static int side(const void *desc, dvec3 p) {
    revolved shape = revolved_of(desc);
    return revolved_side(&shape, p);
}

static int spans(const void *desc, const local_ray *beam, span *out, int capacity) {
    revolved shape = revolved_of(desc);
    return revolved_spans(&shape, beam, out, capacity);
}

static double area(const void *desc, uint32_t primitive) {
    (void)primitive;
    revolved shape = revolved_of(desc);
    return revolved_area(&shape);
}

static void sample_area(const void *desc, uint32_t primitive, double u, double v, surface *out) {
    (void)primitive;
    revolved shape = revolved_of(desc);
    revolved_sample_area(&shape, u, v, out);
}

extern const primitive_type primitive_cylinder;
const primitive_type primitive_cylinder = {
    .info = TYPE_INFO(CATEGORY_SHAPE, cylinder, "cylinder", "a cylinder, closed or a tube"),
    .check = check,
    .bounds = bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .parametrise = parametrise,
    .side = side,
    .spans = spans,
    .area = area,
    .sample_area = sample_area,
};
