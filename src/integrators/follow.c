#include "integrators/follow.h"

#include "integrators/differential.h"

dvec3 mirror_direction(const shade_point *p) {
    dvec3 d = reflect_direction(p->wo, p->ns);
    double height = dvec3_dot(d, p->n);
    return height > 0 ? d : dvec3_normalize(dvec3_sub(d, dvec3_scale(p->n, 2 * height)));
}

void follow_mirror(wave *w, const path_ray *r, const shade_point *p, const lobe *l, double share,
                   uint32_t slot) {
    dvec3 reflected = fresnel_evaluate(&l->fresnel, dvec3_dot(p->wo, p->ns));
    dvec3 weight = dvec3_mul(l->weight, reflected);
    if (share < 1) weight = dvec3_scale(weight, share);
    path_ray *child =
        emit_ray(w, r, p, mirror_direction(p), weight, &r->media, slot, RAY_REFLECTED);
    differential_of_mirror(r, p, child);
}

void follow_interface(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                      const lobe *l, uint32_t slot) {
    double reflected = fresnel_dielectric(dvec3_dot(p->wo, p->ns), b->ior1, b->ior2);
    path_ray *child =
        emit_ray(w, r, p, mirror_direction(p), (dvec3){reflected, reflected, reflected}, &r->media,
                 slot, RAY_REFLECTED);
    differential_of_mirror(r, p, child);
    double eta = b->ior1 / b->ior2;
    dvec3 d;
    if (!refract_direction(p->wo, p->ns, eta, &d)) return;
    if (dvec3_dot(d, p->n) >= 0 && !refract_direction(p->wo, p->n, eta, &d)) return;
    child = emit_ray(w, r, p, d, dvec3_scale(l->weight, 1 - reflected), wave_beyond(w), slot + 1,
                     RAY_REFRACTED);
    differential_of_interface(r, p, eta, child);
}
