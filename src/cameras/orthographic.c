/* Parallel rays: size does not depend on distance. */
#include "cameras/camera.h"

#define ORTHOGRAPHIC_FIELDS(F, T)                                                                  \
    CAMERA_FIELDS(F, T)                                                                            \
    F(T, height, FLOAT, DEFAULT(2), POSITIVE, "m", "what the picture is high, around 'at'")
DESCRIBE(orthographic, ORTHOGRAPHIC_FIELDS)

static snell_status check(const void *desc) { return camera_check(desc, "orthographic"); }

static void prepare(const void *desc, camera_frame *f) {
    const orthographic_desc *c = desc;
    double pixel = (double)c->height / f->height;
    dvec3 to_left = dvec3_scale(f->right, -pixel * f->width / 2),
          to_top = dvec3_scale(f->up, pixel * f->height / 2);
    f->corner = dvec3_add(dvec3_from(f->origin), dvec3_add(to_left, to_top));
    f->column = dvec3_scale(f->right, pixel);
    f->row = dvec3_scale(f->up, -pixel);
}

static bool make_ray(const camera_frame *f, const camera_sample *s, vec3 *o, dvec3 *d) {
    dvec3 across = dvec3_add(dvec3_scale(f->column, s->x), dvec3_scale(f->row, s->y));
    *o = vec3_from(dvec3_add(f->corner, across));
    *d = f->forward;
    return true;
}

static bool project(const camera_frame *f, dvec3 v, double *x, double *y) {
    dvec3 from_corner = dvec3_sub(dvec3_add(v, dvec3_from(f->origin)), f->corner);
    *x = dvec3_dot(from_corner, f->column) / dvec3_dot(f->column, f->column);
    *y = dvec3_dot(from_corner, f->row) / dvec3_dot(f->row, f->row);
    return dvec3_dot(v, f->forward) > 0;
}

const camera_type camera_orthographic = {
    .info = TYPE_INFO(CATEGORY_CAMERA, orthographic, "orthographic",
                      "parallel rays: the same size near and far"),
    .check = check,
    .prepare = prepare,
    .ray = make_ray,
    .project = project,
    .has_plane = true,
};
