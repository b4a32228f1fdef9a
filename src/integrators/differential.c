#include "integrators/differential.h"

void differential_of_camera(const wave_settings *s, uint32_t sharing, const camera_sample *at,
                            path_ray *r) {
    double step = 1 / sqrt((double)sharing);
    camera_sample right = *at, down = *at;
    right.x += step;
    down.y += step;
    vec3 ox, dx, oy, dy;
    if (!camera_ray(s->camera, &s->frame, &right, &ox, &dx)) return;
    if (!camera_ray(s->camera, &s->frame, &down, &oy, &dy)) return;
    r->differential = (ray_differential){vec3_sub(ox, r->ray.o), vec3_sub(dx, r->ray.d),
                                         vec3_sub(oy, r->ray.o), vec3_sub(dy, r->ray.d)};
    r->has_differential = true;
}

/* Igehy's equation 15: R = D - 2 (D.N) N. */
static dvec3 mirrored(dvec3 d, dvec3 n, dvec3 dd, dvec3 dn) {
    double cosine = dvec3_dot(d, n), change = dvec3_dot(dd, n) + dvec3_dot(d, dn);
    dvec3 bent = dvec3_add(dvec3_scale(dn, cosine), dvec3_scale(n, change));
    return dvec3_sub(dd, dvec3_scale(bent, 2));
}

/* Igehy's equations 17 to 19: T = eta D - mu N with mu = eta D.N - T.N. */
static dvec3 refracted(dvec3 d, dvec3 n, double eta, dvec3 dd, dvec3 dn) {
    double cosine = dvec3_dot(d, n), change = dvec3_dot(dd, n) + dvec3_dot(d, dn);
    double square = 1 - eta * eta * (1 - cosine * cosine);
    double beyond = -sqrt(double_max(square, 1e-6)); /* T.N; 0 at the critical angle */
    double mu = eta * cosine - beyond, dmu = (eta - eta * eta * cosine / beyond) * change;
    return dvec3_sub(dvec3_scale(dd, eta), dvec3_add(dvec3_scale(dn, mu), dvec3_scale(n, dmu)));
}

static void start_at(const shade_point *p, path_ray *child, dvec3 ddx, dvec3 ddy) {
    child->differential =
        (ray_differential){vec3_from(p->dpdx), vec3_from(ddx), vec3_from(p->dpdy), vec3_from(ddy)};
    child->has_differential = true;
}

void differential_of_mirror(const path_ray *r, const shade_point *p, dvec3 n, path_ray *child) {
    if (child == NULL || !r->has_differential) return;
    dvec3 d = dvec3_negate(p->wo);
    start_at(p, child, mirrored(d, n, dvec3_from(r->differential.ddx), p->dndx),
             mirrored(d, n, dvec3_from(r->differential.ddy), p->dndy));
}

void differential_of_interface(const path_ray *r, const shade_point *p, double eta,
                               path_ray *child) {
    if (child == NULL || !r->has_differential) return;
    dvec3 d = dvec3_negate(p->wo);
    start_at(p, child, refracted(d, p->ns, eta, dvec3_from(r->differential.ddx), p->dndx),
             refracted(d, p->ns, eta, dvec3_from(r->differential.ddy), p->dndy));
}
