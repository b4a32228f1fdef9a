#include "scene/seen.h"

#include "maths/functions.h"
#include "sampling/warp.h"
#include "scene/instances.h"

/* Things that let light through, between the point and the shape, at most. */
enum { STEPS_MAX = 64 };

void seen_measure(surface_light *l, const scene_instance *at) {
    bounds3 box = at->type->bounds(at->shape);
    dvec3 low = dvec3_from(box.min), high = dvec3_from(box.max);
    l->middle = dvec3_scale(dvec3_add(low, high), 0.5);
    l->radius = 0.5 * dvec3_length(dvec3_sub(high, low));
}

bool seen_can_be_sampled(const scene *s, const scene_instance *at) {
    if (at->type->unbounded) return false;
    for (uint32_t i = 0; i < instance_slot_count(at); i++)
        if (!s->materials[instance_slot(at, i)].opaque_alpha) return false;
    return true;
}

/* How much longer a vector may become: the root of a bound on the largest eigenvalue of M^T M, exact
 * where the axes stay orthogonal. */
static double stretch(const transform *m) {
    double most = 0;
    for (int i = 0; i < 3; i++) {
        double sum = 0;
        for (int j = 0; j < 3; j++) {
            double dot = 0;
            for (int k = 0; k < 3; k++) dot += (double)m->m[k][i] * (double)m->m[k][j];
            sum += fabs(dot);
        }
        most = double_max(most, sum);
    }
    return sqrt(most);
}

/* The cone that holds the ball, as seen from a point: its axis and 1 - cos of its half angle; from
 * inside the ball all directions. */
static double cone_of(const surface_light *l, const scene_instance *at, dvec3 from, dvec3 *axis) {
    dvec3 to =
        dvec3_sub(at->identity ? l->middle : transform_point(&at->to_world, l->middle), from);
    double radius = l->radius * (at->identity ? 1 : stretch(&at->to_world)) * (1 + 0x1p-20);
    double distance2 = dvec3_dot(to, to), sine2 = radius * radius / distance2;
    *axis = (dvec3){0, 0, 1};
    if (!(sine2 < 1)) return 2;
    *axis = dvec3_normalize(to);
    return sine2 / (1 + sqrt(1 - sine2));
}

double seen_pdf(const surface_light *l, const scene_instance *at, dvec3 from) {
    dvec3 axis;
    return 1 / (2 * PI * cone_of(l, at, from, &axis));
}

bool seen_sample(const scene *s, const surface_light *l, const scene_instance *at,
                 const shade_point *from, float time, sample2 u, shade_point *found, double *pdf) {
    dvec3 axis;
    double cone = cone_of(l, at, from->p, &axis);
    *pdf = 1 / (2 * PI * cone);
    ray r;
    scene_spawn_ray(from, dvec3_from_frame(axis, warp_cone(u, cone)), INFINITY, &r);
    r.time = time;
    r.mask = ~(uint32_t)MASK_LIGHT_HIDDEN;
    for (int step = 0; step < STEPS_MAX; step++) {
        hit h;
        accel_trace(s->accel, SNELL_ISA_AUTO, &r, &h, 1, NULL);
        if (h.instance == NO_ID) return false;
        if (h.instance == l->instance) {
            scene_shade_point(s, &r, &h, found);
            return true;
        }
        if (instance_mask(s, scene_part(s, h.instance)) & MASK_OPAQUE) return false;
        r.after_t = h.t;
        r.after_instance = h.instance;
        r.after_primitive = h.primitive;
    }
    return false;
}
