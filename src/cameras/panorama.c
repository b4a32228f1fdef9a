/* Everything around: columns are equal steps of longitude, rows of latitude (equirectangular). The
 * middle looks at `at`; the top row is `up`, squared to the view. */
#include "cameras/camera.h"

#include "maths/functions.h"

#define PANORAMA_FIELDS(F, T) CAMERA_FIELDS(F, T)
DESCRIBE(panorama, PANORAMA_FIELDS)

static snell_status check(const void *desc) { return camera_check(desc, "panorama"); }

static void prepare(const void *desc, camera_frame *f) {
    (void)desc;
    (void)f;
}

static bool make_ray(const camera_frame *f, const camera_sample *s, vec3 *o, dvec3 *d) {
    /* A filter that reaches over the top comes down on the other side, as it should. */
    double longitude = (s->x / f->width - 0.5) * 2 * PI, polar = s->y / f->height * PI;
    double sine = fn_sin(polar);
    dvec3 level = dvec3_add(dvec3_scale(f->forward, fn_cos(longitude)),
                            dvec3_scale(f->right, fn_sin(longitude)));
    *o = f->origin;
    *d = dvec3_add(dvec3_scale(level, sine), dvec3_scale(f->up, fn_cos(polar)));
    return true;
}

static bool project(const camera_frame *f, dvec3 v, double *x, double *y) {
    double along = dvec3_dot(v, f->forward), across = dvec3_dot(v, f->right);
    double level = sqrt(along * along + across * across);
    if (!(dvec3_length(v) > 0)) return false;
    *x = (fn_atan2(across, along) / (2 * PI) + 0.5) * f->width;
    *y = fn_atan2(level, dvec3_dot(v, f->up)) / PI * f->height;
    return true;
}

const camera_type camera_panorama = {
    .info = TYPE_INFO(CATEGORY_CAMERA, panorama, "panorama",
                      "everything around, longitude by latitude; twice as wide as high"),
    .check = check,
    .prepare = prepare,
    .ray = make_ray,
    .project = project,
};
