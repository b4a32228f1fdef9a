#include "integrators/follow.h"

#include "integrators/differential.h"

dvec3 bent_back(const shade_point *p, dvec3 d) {
    double height = dvec3_dot(d, p->n);
    return height > 0 ? d : dvec3_normalize(dvec3_sub(d, dvec3_scale(p->n, 2 * height)));
}

static void emit_mirrored(wave *w, const path_ray *r, const shade_point *p, dvec3 n, dvec3 weight,
                          uint32_t slot) {
    dvec3 d = bent_back(p, reflect_direction(p->wo, n));
    path_ray *child = emit_ray(w, r, p, d, weight, &r->media, slot, RAY_REFLECTED);
    differential_of_mirror(r, p, n, child);
}

void follow_mirror(wave *w, const path_ray *r, const shade_point *p, const bsdf *b, const lobe *l,
                   double share, uint32_t slot) {
    dvec3 weight = lobe_mirrored(l, b, p->ns, p->wo);
    if (share < 1) weight = dvec3_scale(weight, share);
    emit_mirrored(w, r, p, lobe_normal(l, b, p->ns), weight, slot);
}

/* The refracted direction; about the geometric normal where the shading normal's would stay above. */
static bool refracted_direction(const shade_point *p, const lobe *l, double eta, dvec3 *d) {
    *d = dvec3_negate(p->wo);
    if (l->type->thin) return true;
    if (!refract_direction(p->wo, p->ns, eta, d)) return false;
    return dvec3_dot(*d, p->n) < 0 || refract_direction(p->wo, p->n, eta, d);
}

/* Colours part: what is reflected stays together, and three rays are refracted, each of one colour. */
static void follow_colors(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                          const lobe *l, double passing, uint32_t slot) {
    double cosine = dvec3_dot(p->wo, p->ns);
    dvec3 reflected = {0, 0, 0};
    for (int color = 0; color < 3; color++) {
        double ior1 = b->ior1_by_color[color], ior2 = b->ior2_by_color[color],
               part = fresnel_dielectric(cosine, ior1, ior2);
        dvec3 alone = color_alone(color), d;
        reflected = dvec3_add(reflected, dvec3_scale(alone, part));
        if (!refracted_direction(p, l, ior1 / ior2, &d)) continue;
        dvec3 weight = dvec3_scale(dvec3_mul(l->weight, alone), passing * (1 - part));
        path_ray *child = emit_ray(w, r, p, d, weight, wave_beyond(w), color_slot(slot + 1, color),
                                   RAY_REFRACTED);
        if (child) child->color = (uint8_t)(1 + color);
        differential_of_interface(r, p, ior1 / ior2, child);
    }
    dvec3 weight = dvec3_scale(dvec3_mul(l->reflected, reflected), passing);
    emit_mirrored(w, r, p, p->ns, weight, slot);
}

void follow_interface(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                      const lobe *l, uint32_t slot) {
    double cosine = dvec3_dot(p->wo, p->ns),
           passing = lobe_passing(l, b, p->wo, dvec3_negate(p->wo), cosine, -cosine);
    if (b->disperses && !l->type->thin) {
        follow_colors(w, r, p, b, l, passing, slot);
        return;
    }
    double reflected = interface_reflected(l, b, cosine);
    emit_mirrored(w, r, p, p->ns, dvec3_scale(l->reflected, passing * reflected), slot);
    double eta = l->type->thin ? 1 : b->ior1 / b->ior2;
    dvec3 d;
    if (!refracted_direction(p, l, eta, &d)) return;
    path_ray *child = emit_ray(w, r, p, d, dvec3_scale(l->weight, passing * (1 - reflected)),
                               wave_beyond(w), slot + 1, RAY_REFRACTED);
    differential_of_interface(r, p, eta, child);
}
