/* A circle that touches the picture's nearer edges: the distance from its middle is the angle from
 * the view (equidistant). Outside the circle there is nothing. */
#include "cameras/camera.h"

#include "maths/functions.h"

#define FISHEYE_FIELDS(F, T)                                                                       \
    CAMERA_FIELDS(F, T)                                                                            \
    F(T, fov, FLOAT, DEFAULT(3.1415927f), RANGE(1e-4, 6.2831855), "rad", "across the circle")
DESCRIBE(fisheye, FISHEYE_FIELDS)

static snell_status check(const void *desc) { return camera_check(desc, "fisheye"); }

static void prepare(const void *desc, camera_frame *f) {
    f->fov = (double)((const fisheye_desc *)desc)->fov;
}

static bool make_ray(const camera_frame *f, const camera_sample *s, vec3 *o, dvec3 *d) {
    double radius = double_min(f->width, f->height) / 2;
    double x = (s->x - f->width / 2) / radius, y = (f->height / 2 - s->y) / radius;
    double r = sqrt(x * x + y * y);
    if (r > 1) return false;
    double angle = r * f->fov / 2, scale = r > 0 ? fn_sin(angle) / r : 0;
    *o = f->origin;
    *d = dvec3_add(dvec3_scale(f->forward, fn_cos(angle)),
                   dvec3_add(dvec3_scale(f->right, x * scale), dvec3_scale(f->up, y * scale)));
    return true;
}

static bool project(const camera_frame *f, dvec3 v, double *x, double *y) {
    double across = dvec3_dot(v, f->right), up = dvec3_dot(v, f->up);
    double off = sqrt(across * across + up * up);
    double r = fn_atan2(off, dvec3_dot(v, f->forward)) / (f->fov / 2);
    if (!(r <= 1) || !(dvec3_length(v) > 0)) return false;
    double radius = double_min(f->width, f->height) / 2, scale = off > 0 ? r * radius / off : 0;
    *x = f->width / 2 + across * scale;
    *y = f->height / 2 - up * scale;
    return true;
}

const camera_type camera_fisheye = {
    .info = TYPE_INFO(CATEGORY_CAMERA, fisheye, "fisheye",
                      "a wide circle: angles from the view are distances from its middle"),
    .check = check,
    .prepare = prepare,
    .ray = make_ray,
    .project = project,
};
