#include "cameras/camera.h"

#define CAMERA(name) extern const camera_type camera_##name;
#include "cameras/cameras.def"
#undef CAMERA
const camera_type *const camera_types[] = {
#define CAMERA(name) &camera_##name,
#include "cameras/cameras.def"
#undef CAMERA
};
const uint32_t camera_type_count = sizeof camera_types / sizeof camera_types[0];

snell_status camera_check(const void *desc, const char *name) {
    const camera_common *c = desc;
    dvec3 view = dvec3_sub(dvec3_from(c->at), dvec3_from(c->from));
    if (!(dvec3_length(view) > 0))
        return error_set(SNELL_ERR_ARGUMENT, "move one of them",
                         "%s: 'from' and 'at' are the same point", name);
    if (!(dvec3_length(dvec3_cross(dvec3_normalize(view), dvec3_from(c->up))) > 1e-6))
        return error_set(SNELL_ERR_ARGUMENT, "choose another 'up'", "%s: 'up' is along the view",
                         name);
    if (!(c->shutter.x <= c->shutter.y))
        return error_set(SNELL_ERR_ARGUMENT, "such as {0, 0.5}",
                         "%s: 'shutter' closes before it opens", name);
    return c->motion_count ? motion_check(c->motion, c->motion_count, name) : SNELL_OK;
}

void camera_prepare(const camera_type *type, const void *desc, uint32_t width, uint32_t height,
                    const motion *moved, camera_frame *out) {
    const camera_common *c = desc;
    dvec3 forward = dvec3_normalize(dvec3_sub(dvec3_from(c->at), dvec3_from(c->from)));
    dvec3 right = dvec3_normalize(dvec3_cross(forward, dvec3_from(c->up)));
    *out = (camera_frame){.position = c->from,
                          .motion = moved,
                          .origin = c->from,
                          .forward = forward,
                          .right = right,
                          .up = dvec3_cross(right, forward),
                          .width = width,
                          .height = height};
    if (moved)
        out->position = vec3_from(transform_point(&moved->steps[0].transform, dvec3_from(c->from)));
    type->prepare(desc, out);
}

bool camera_ray(const camera_type *type, const camera_frame *frame, const camera_sample *sample,
                vec3 *o, vec3 *d) {
    dvec3 direction;
    if (!type->ray(frame, sample, o, &direction)) return false;
    if (frame->motion) {
        transform at = motion_transform(frame->motion, sample->time);
        *o = vec3_from(transform_point(&at, dvec3_from(*o)));
        direction = transform_vector(&at, direction);
    }
    *d = vec3_from(dvec3_normalize(direction));
    return true;
}

/* From the origin, in the camera's own space, which is at `at` (NULL: it stands still). false: it has no size. */
static bool to_own_space(const camera_frame *frame, const transform *at, dvec3 p, dvec3 *v) {
    transform back;
    if (at) {
        if (!transform_inverse(at, &back)) return false;
        p = transform_point(&back, p);
    }
    *v = dvec3_sub(p, dvec3_from(frame->origin));
    return true;
}

bool camera_project(const camera_type *type, const camera_frame *frame, float time, dvec3 p,
                    double *x, double *y) {
    dvec3 v;
    transform at;
    if (frame->motion) at = motion_by_keys(frame->motion, time);
    return to_own_space(frame, frame->motion ? &at : NULL, p, &v) && type->project(frame, v, x, y);
}

double camera_depth(const camera_type *type, const camera_frame *frame, float time, dvec3 p) {
    dvec3 v;
    transform at;
    if (frame->motion) at = motion_transform(frame->motion, time);
    if (!to_own_space(frame, frame->motion ? &at : NULL, p, &v)) return 0;
    return type->has_plane ? dvec3_dot(v, frame->forward) : dvec3_length(v);
}
