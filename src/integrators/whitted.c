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
#include "integrators/differential.h"

/* A reflection about a shading normal that would go below the surface is bent back above it. */
static dvec3 mirror_direction(const shade_point *p) {
    dvec3 d = reflect_direction(p->wo, p->ns);
    double height = dvec3_dot(d, p->n);
    return height > 0 ? d : dvec3_normalize(dvec3_sub(d, dvec3_scale(p->n, 2 * height)));
}

static void follow_mirror(wave *w, const path_ray *r, const shade_point *p, const lobe *l,
                          uint32_t slot) {
    double fresnel = l->ior > 0 ? fresnel_dielectric(dvec3_dot(p->wo, p->ns), 1, l->ior) : 1;
    path_ray *child = emit_ray(w, r, p, mirror_direction(p), dvec3_scale(l->weight, fresnel),
                               &r->media, slot, RAY_REFLECTED);
    differential_of_mirror(r, p, child);
}

/* Both branches of the tree, by Snell and Fresnel. */
static void follow_interface(wave *w, const path_ray *r, const shade_point *p, const lobe *l,
                             uint32_t slot) {
    media beyond = r->media;
    if (p->outside)
        media_enter(&beyond, p->instance);
    else
        media_leave(&beyond, p->instance);
    double ior1 = media_current(&r->media, wave_scene(w))->ior,
           ior2 = media_current(&beyond, wave_scene(w))->ior;
    double fresnel = fresnel_dielectric(dvec3_dot(p->wo, p->ns), ior1, ior2);
    path_ray *child = emit_ray(w, r, p, mirror_direction(p), (dvec3){fresnel, fresnel, fresnel},
                               &r->media, slot, RAY_REFLECTED);
    differential_of_mirror(r, p, child);
    dvec3 d;
    if (!refract_direction(p->wo, p->ns, ior1 / ior2, &d)) return;
    if (dvec3_dot(d, p->n) >= 0 && !refract_direction(p->wo, p->n, ior1 / ior2, &d)) return;
    child =
        emit_ray(w, r, p, d, dvec3_scale(l->weight, 1 - fresnel), &beyond, slot + 1, RAY_REFRACTED);
    differential_of_interface(r, p, ior1 / ior2, child);
}

static void hit_surface(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    emit_own_light(w, r, b);
    emit_direct_light(w, r, p, b);
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *l = &b->lobes[i];
        if (l->type->class == LOBE_MIRROR) follow_mirror(w, r, p, l, 2 * (uint32_t)i);
        if (l->type->class == LOBE_INTERFACE) follow_interface(w, r, p, l, 2 * (uint32_t)i);
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
