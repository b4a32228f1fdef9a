/* The pinhole: every ray starts at one point (Bikker, "Whitted"; Cornell CS4620, eye ray
 * generation). */
#include "cameras/camera.h"

#include "base/error.h"
#include "maths/functions.h"

DESCRIBE_TABLE(perspective, PERSPECTIVE_FIELDS)

static snell_status check(const void *desc) {
    const perspective_desc *c = desc;
    dvec3 view = dvec3_sub(dvec3_from(c->at), dvec3_from(c->from));
    if (!(dvec3_length(view) > 0))
        return error_set(SNELL_ERR_ARGUMENT, "move one of them",
                         "perspective: 'from' and 'at' are the same point");
    if (!(dvec3_length(dvec3_cross(dvec3_normalize(view), dvec3_from(c->up))) > 1e-6))
        return error_set(SNELL_ERR_ARGUMENT, "choose another 'up'",
                         "perspective: 'up' is along the view");
    return SNELL_OK;
}

static void prepare(const void *desc, uint32_t width, uint32_t height, camera_frame *out) {
    const perspective_desc *c = desc;
    dvec3 forward = dvec3_normalize(dvec3_sub(dvec3_from(c->at), dvec3_from(c->from)));
    dvec3 right = dvec3_normalize(dvec3_cross(forward, dvec3_from(c->up)));
    dvec3 up = dvec3_cross(right, forward);
    double pixel = 2 * fn_tan((double)c->fov / 2) / height; /* its side at distance 1 */
    dvec3 to_left = dvec3_scale(right, -pixel * width / 2),
          to_top = dvec3_scale(up, pixel * height / 2);
    *out = (camera_frame){.position = c->from,
                          .corner = dvec3_add(forward, dvec3_add(to_left, to_top)),
                          .right = dvec3_scale(right, pixel),
                          .down = dvec3_scale(up, -pixel)};
}

static void make_ray(const camera_frame *frame, const camera_sample *s, vec3 *o, vec3 *d) {
    dvec3 across = dvec3_add(dvec3_scale(frame->right, s->x), dvec3_scale(frame->down, s->y));
    *o = frame->position;
    *d = vec3_from(dvec3_normalize(dvec3_add(frame->corner, across)));
}

const camera_type camera_perspective = {
    .info = TYPE_INFO(CATEGORY_CAMERA, perspective, "perspective", "a pinhole camera"),
    .check = check,
    .prepare = prepare,
    .ray = make_ray,
};
