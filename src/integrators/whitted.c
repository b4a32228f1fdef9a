/* Whitted 1980, An Improved Illumination Model for Shaded Display: the recursive ray tree.
 *
 *     Color Trace(ray r)
 *         I, N, mat = NearestIntersection(scene, r)
 *         diffuse:    mat.color * DirectIllumination(I, N)
 *         mirror:     mat.color * Trace(I, reflect(r.D, N))
 *         dielectric: F * Trace(I, reflect) + (1 - F) * mat.color * Trace(I, refract)
 *
 * and Beer's law on the way, which the wave loop applies to every ray before its hit is asked about
 * (Bikker, "Whitted", where glass has no colour of its own). */
#include "integrators/integrator.h"

/* A reflection about a shading normal that would go below the surface is bent back above it. */
static dvec3 mirror_direction(const shade_point *p) {
    dvec3 d = reflect_direction(p->wo, p->ns);
    double height = dvec3_dot(d, p->n);
    return height > 0 ? d : dvec3_normalize(dvec3_sub(d, dvec3_scale(p->n, 2 * height)));
}

static void follow_mirror(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                          const lobe *l, uint32_t slot) {
    dvec3 weight = lobe_mirrored(l, b, dvec3_dot(p->wo, p->ns));
    emit_ray(w, r, p, mirror_direction(p), weight, &r->media, slot, RAY_REFLECTED);
}

/* Both branches of the tree, by Snell and Fresnel. */
static void follow_interface(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                             const lobe *l, uint32_t slot) {
    media beyond = r->media;
    double cosine = dvec3_dot(p->wo, p->ns), passing = lobe_passing(l, b, cosine, -cosine);
    if (!l->type->thin && p->outside)
        media_enter(&beyond, p->instance);
    else if (!l->type->thin)
        media_leave(&beyond, p->instance);
    double ior1 = media_current(&r->media, wave_scene(w))->ior,
           ior2 = media_current(&beyond, wave_scene(w))->ior;
    double reflected = l->type->thin ? fresnel_evaluate(&l->fresnel, cosine).x
                                     : fresnel_dielectric(cosine, ior1, ior2);
    emit_ray(w, r, p, mirror_direction(p), dvec3_scale(l->reflected, passing * reflected),
             &r->media, slot, RAY_REFLECTED);
    dvec3 d = dvec3_negate(p->wo);
    if (!l->type->thin) {
        if (!refract_direction(p->wo, p->ns, ior1 / ior2, &d)) return;
        if (dvec3_dot(d, p->n) >= 0 && !refract_direction(p->wo, p->n, ior1 / ior2, &d)) return;
    }
    emit_ray(w, r, p, d, dvec3_scale(l->weight, passing * (1 - reflected)), &beyond, slot + 1,
             RAY_REFRACTED);
}

static void hit_surface(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    emit_own_light(w, r, b);
    emit_direct_light(w, r, p, b);
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *l = &b->lobes[i];
        if (l->type->class == LOBE_MIRROR) follow_mirror(w, r, p, b, l, 2 * (uint32_t)i);
        if (l->type->transmits) follow_interface(w, r, p, b, l, 2 * (uint32_t)i);
    }
}

const integrator integrator_whitted = {
    .name = "whitted",
    .help = "the recursive ray tree: mirrors, glass (1980)",
    .samples = 16,
    .max_depth = 10,
    .max_depth_media = 24,
    .hit = hit_surface,
    .miss = emit_background,
};
