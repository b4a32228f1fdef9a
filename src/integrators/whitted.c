/* Whitted 1980, An Improved Illumination Model for Shaded Display: the recursive ray tree.
 *
 *     Color Trace(ray r)
 *         I, N, mat = NearestIntersection(scene, r)
 *         diffuse:    mat.color * DirectIllumination(I, N)
 *         mirror:     mat.color * Trace(I, reflect(r.D, N))
 *         dielectric: F * Trace(I, reflect) + (1 - F) * mat.color * Trace(I, refract)
 *
 * and Beer's law on the way, which the wave loop applies to every ray before its hit is asked about
 * (Bikker, "Whitted", where glass has no colour of its own). Microfacets are lit by the lights; of
 * what they mirror they show a sharp image, as strong as their mirror_share. */
#include "integrators/follow.h"

static void hit_surface(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    emit_own_light(w, r, b);
    emit_direct_light(w, r, p, b, LOBES_LIT | LOBES_NOT_MIRRORED, LIGHT_CENTERS);
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *l = &b->lobes[i];
        uint32_t slot = 2 * (uint32_t)i;
        if (l->type->transmits)
            follow_interface(w, r, p, b, l, slot);
        else if (l->type->class == LOBE_MIRROR)
            follow_mirror(w, r, p, b, l, 1, slot);
        else if (l->mirror_share > 0)
            follow_mirror(w, r, p, b, l, l->mirror_share, slot);
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
