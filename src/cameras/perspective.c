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

static void make_ray(const void *desc, const camera_sample *s, vec3 *o, vec3 *d) {
    const perspective_desc *c = desc;
    dvec3 forward = dvec3_normalize(dvec3_sub(dvec3_from(c->at), dvec3_from(c->from)));
    dvec3 right = dvec3_normalize(dvec3_cross(forward, dvec3_from(c->up)));
    dvec3 up = dvec3_cross(right, forward);
    double half = fn_tan((double)c->fov / 2); /* half the picture's height at distance 1 */
    double x = (2 * s->x - s->width) / s->height * half,
           y = (s->height - 2 * s->y) / s->height * half;
    dvec3 direction = dvec3_add(forward, dvec3_add(dvec3_scale(right, x), dvec3_scale(up, y)));
    *o = c->from;
    *d = vec3_from(dvec3_normalize(direction));
}

static vec3 position(const void *desc) { return ((const perspective_desc *)desc)->from; }

const camera_type camera_perspective = {
    .info = TYPE_INFO(CATEGORY_CAMERA, perspective, "perspective", "a pinhole camera"),
    .check = check,
    .ray = make_ray,
    .position = position,
};
