/* The pinhole: every ray starts at one point (Bikker, "Whitted"; Cornell CS4620, eye ray
 * generation). With a lens it starts anywhere on a disk and goes through the point that the pinhole's
 * ray meets in the plane of focus (Cook, Porter, Carpenter, Distributed Ray Tracing, SIGGRAPH 1984):
 * the thin lens, seen from in front of the camera. */
#include "cameras/camera.h"

#include "maths/functions.h"
#include "sampling/warp.h"

DESCRIBE_TABLE(perspective, PERSPECTIVE_FIELDS)

static snell_status check(const void *desc) {
    const perspective_desc *c = desc;
    if (c->blades == 1 || c->blades == 2)
        return error_set(SNELL_ERR_ARGUMENT, "3 to 16, or 0 for a round one",
                         "perspective: an aperture cannot have %d blades", c->blades);
    return camera_check(desc, "perspective");
}

static void prepare(const void *desc, camera_frame *f) {
    const perspective_desc *c = desc;
    double pixel = 2 * fn_tan((double)c->fov / 2) / f->height; /* its side at distance 1 */
    dvec3 to_left = dvec3_scale(f->right, -pixel * f->width / 2),
          to_top = dvec3_scale(f->up, pixel * f->height / 2);
    f->corner = dvec3_add(f->forward, dvec3_add(to_left, to_top));
    f->column = dvec3_scale(f->right, pixel);
    f->row = dvec3_scale(f->up, -pixel);
    f->lens_radius = (double)c->lens_radius;
    f->focus = c->focus > 0 ? (double)c->focus
                            : dvec3_length(dvec3_sub(dvec3_from(c->at), dvec3_from(c->from)));
    f->blades = (unsigned)c->blades;
    f->blade_rotation = (double)c->blade_rotation;
}

static bool make_ray(const camera_frame *f, const camera_sample *s, vec3 *o, dvec3 *d) {
    dvec3 across = dvec3_add(dvec3_scale(f->column, s->x), dvec3_scale(f->row, s->y));
    *o = f->origin;
    *d = dvec3_add(f->corner, across); /* 1 along the view */
    if (!(f->lens_radius > 0)) return true;
    dvec3 eye = dvec3_from(f->origin), sharp = dvec3_add(eye, dvec3_scale(*d, f->focus));
    sample2 lens =
        f->blades ? warp_polygon(s->lens, f->blades, f->blade_rotation) : warp_disk(s->lens);
    dvec3 on_lens = dvec3_add(dvec3_scale(f->right, lens.x * f->lens_radius),
                              dvec3_scale(f->up, lens.y * f->lens_radius));
    *o = vec3_from(dvec3_add(eye, on_lens));
    *d = dvec3_sub(sharp, dvec3_from(*o)); /* from the rounded origin: sharp stays sharp */
    return true;
}

static bool project(const camera_frame *f, dvec3 v, double *x, double *y) {
    double depth = dvec3_dot(v, f->forward);
    if (!(depth > 0)) return false;
    dvec3 from_corner = dvec3_sub(dvec3_scale(v, 1 / depth), f->corner);
    *x = dvec3_dot(from_corner, f->column) / dvec3_dot(f->column, f->column);
    *y = dvec3_dot(from_corner, f->row) / dvec3_dot(f->row, f->row);
    return true;
}

const camera_type camera_perspective = {
    .info = TYPE_INFO(CATEGORY_CAMERA, perspective, "perspective",
                      "a pinhole camera, or a thin lens with depth of field"),
    .check = check,
    .prepare = prepare,
    .ray = make_ray,
    .project = project,
    .has_plane = true,
};
