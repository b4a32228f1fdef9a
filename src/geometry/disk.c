/* A flat disk or ring. Texture coordinates are polar: u is the angle about the normal as a fraction
 * of a turn, counter-clockwise seen from the front, 0 along the first axis of the normal's frame
 * (+X for the normal +Y); v is 0 at the inner edge (or centre) and 1 at the outer edge. */
#include "base/error.h"
#include "geometry/surface.h"
#include "maths/functions.h"
#include "sampling/warp.h"

#define DISK_FIELDS(F, T)                                                                          \
    F(T, center, VEC3, DEFAULT(0, 0, 0), ANY, "m", "the centre")                                   \
    F(T, normal, VEC3, DEFAULT(0, 1, 0), DIRECTION, "", "the direction it faces")                  \
    F(T, radius, FLOAT, DEFAULT(1), POSITIVE, "m", "the outer radius")                             \
    F(T, inner_radius, FLOAT, DEFAULT(0), NOT_NEGATIVE, "m", "the radius of the hole, 0 for none")
DESCRIBE(disk, DISK_FIELDS)

static snell_status check(const void *desc) {
    const disk_desc *disk = desc;
    if (disk->inner_radius < disk->radius) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "the hole must be smaller than the disk",
                     "disk: 'inner_radius' is %g; it must be less than 'radius', %g",
                     (double)disk->inner_radius, (double)disk->radius);
}

/* Half the disk's size along an axis is r sqrt(1 - n_i^2). The box is widened by a few float
 * roundings: a ray that meets the rim of a thin box must not miss the box. */
static bounds3 bounds(const void *desc) {
    const disk_desc *disk = desc;
    dvec3 c = dvec3_from(disk->center), n = dvec3_normalize(dvec3_from(disk->normal));
    double r = disk->radius;
    dvec3 half = {r * sqrt(n.y * n.y + n.z * n.z), r * sqrt(n.x * n.x + n.z * n.z),
                  r * sqrt(n.x * n.x + n.y * n.y)};
    double wider =
        4 * FLOAT_EPSILON * (r + double_max(double_max(fabs(c.x), fabs(c.y)), fabs(c.z)));
    half = dvec3_add(half, (dvec3){wider, wider, wider});
    return bounds3_outward(dvec3_sub(c, half), dvec3_add(c, half));
}

/* t and the point in the disk's plane, relative to the centre. */
static bool solve(const disk_desc *disk, const local_ray *beam, double *t, dvec3 *offset) {
    dvec3 n = dvec3_from(disk->normal), d = dvec3_from(beam->d);
    dvec3 f = dvec3_sub(dvec3_from(beam->o), dvec3_from(disk->center));
    double slope = dvec3_dot(n, d);
    *t = -dvec3_dot(n, f) / slope;
    *offset = dvec3_add(f, dvec3_scale(d, *t));
    return slope != 0;
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    const disk_desc *disk = desc;
    double t, r = disk->radius, inner = disk->inner_radius;
    dvec3 offset;
    found->u = found->v = 0;
    if (!solve(disk, beam, &t, &offset)) return false;
    double square = dvec3_dot(offset, offset);
    return square <= r * r && square >= inner * inner && surface_accept(beam, t, &found->t);
}

static surface surface_at(const disk_desc *disk, dvec3 offset, dvec3 n) {
    dvec3 center = dvec3_from(disk->center);
    double r = disk->radius;
    double size = 2 * r + fabs(center.x) + fabs(center.y) + fabs(center.z);
    return surface_make(dvec3_add(center, offset), n, 16 * DOUBLE_EPSILON * size);
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    const disk_desc *disk = desc;
    dvec3 center = dvec3_from(disk->center), n = dvec3_normalize(dvec3_from(disk->normal));
    dvec3 offset;
    double t;
    if (!solve(disk, beam, &t, &offset))
        offset = dvec3_sub(
            dvec3_add(dvec3_from(beam->o), dvec3_scale(dvec3_from(beam->d), found->t)), center);
    offset = dvec3_sub(offset, dvec3_scale(n, dvec3_dot(offset, n)));
    *out = surface_at(disk, offset, n);
}

static void parametrise(const void *desc, surface *s) {
    const disk_desc *disk = desc;
    double r = disk->radius, inner = disk->inner_radius;
    dvec3 offset = dvec3_sub(s->p, dvec3_from(disk->center)), along, across;
    dvec3_frame(s->n, &along, &across);
    double x = dvec3_dot(offset, along), y = dvec3_dot(offset, across), out = dvec3_length(offset);
    double turn = fn_atan2(y, x) / (2 * PI);
    s->u = turn < 0 ? turn + 1 : turn;
    s->v = clamp01((out - inner) / (r - inner));
    if (!(out > 0)) return; /* the centre: u has no direction */
    s->dpdu = dvec3_scale(dvec3_sub(dvec3_scale(across, x), dvec3_scale(along, y)), 2 * PI);
    s->dpdv = dvec3_scale(offset, (r - inner) / out);
}

static double area(const void *desc, uint32_t primitive) {
    (void)primitive;
    const disk_desc *disk = desc;
    double r = disk->radius, inner = disk->inner_radius;
    return PI * (r - inner) * (r + inner);
}

static void sample_area(const void *desc, uint32_t primitive, double u, double v, surface *out) {
    (void)primitive;
    const disk_desc *disk = desc;
    double r = disk->radius, inner = disk->inner_radius;
    warp_polar polar = warp_disk_polar((sample2){u, v});
    double square = polar.radius * polar.radius;
    double distance =
        inner > 0 ? sqrt(inner * inner + square * (r - inner) * (r + inner)) : polar.radius * r;
    dvec3 n = dvec3_normalize(dvec3_from(disk->normal)), along, across;
    dvec3_frame(n, &along, &across);
    dvec3 side = dvec3_add(dvec3_scale(along, polar.cosine), dvec3_scale(across, polar.sine));
    *out = surface_at(disk, dvec3_scale(side, distance), n);
}

extern const primitive_type primitive_disk;
const primitive_type primitive_disk = {
    .info = TYPE_INFO(CATEGORY_SHAPE, disk, "disk", "a flat disk, or a ring"),
    .flat = true,
    .check = check,
    .bounds = bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .parametrise = parametrise,
    .area = area,
    .sample_area = sample_area,
};
