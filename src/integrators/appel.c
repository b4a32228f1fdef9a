/* Appel 1968, Some Techniques for Shading Machine Renderings of Solids: one ray finds the surface,
 * one ray per light tells whether it is in shadow. Nothing is followed further; mirrors and glass
 * shade as Lambert in their colour, so that nothing is black. */
#include "integrators/integrator.h"

/* Every lobe that would be traced becomes Lambert of the same weight; a glaze's is Fresnel's. */
static bsdf without_traced_lobes(const bsdf *b, const shade_point *p) {
    bsdf matte = *b;
    for (int i = 0; i < matte.lobe_count; i++) {
        lobe *l = &matte.lobes[i];
        if (l->type->class == LOBE_MIRROR) l->weight = lobe_mirrored(l, b, p->ns, p->wo);
        if (l->type->evaluate == NULL || l->type->transmits) l->type = &lobe_lambert;
    }
    return matte;
}

static void hit_surface(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    bsdf matte = without_traced_lobes(b, p);
    emit_own_light(w, r, &matte);
    emit_direct_light(w, r, p, &matte, LOBES_LIT, LIGHT_CENTERS);
}

const integrator integrator_appel = {
    .name = "appel",
    .help = "visibility and shadow rays (1968)",
    .samples = 4,
    .max_depth = 0,
    .max_depth_media = 0,
    .hit = hit_surface,
    .miss = emit_background,
};
