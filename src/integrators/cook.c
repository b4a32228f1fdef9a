/* Cook, Porter, Carpenter 1984, Distributed Ray Tracing: Whitted's tree, but every ray is drawn from
 * a distribution: over the pixel, the lens, the shutter, the light's area and the gloss of a
 * reflection. Antialiasing, depth of field, motion blur, soft shadows and blurred reflections are
 * then one integral, and the samples of a pixel share it.
 *
 * A microfacet lobe is traced and meets lights by itself, except those of a point or a direction,
 * which no ray could hit. Lambert and Phong lobes are lit by one point drawn on each light; an
 * infinite plane that shines has no such point, so it lights only what mirrors it. */
#include "integrators/follow.h"

/* One ray for the whole lobe; it carries `share` of what it finds. */
static path_ray *follow_gloss(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                              const lobe *l, dvec3 share, uint32_t slot) {
    dvec3 wi, n = lobe_normal(l, b, p->ns);
    sample2 u = wave_draw_child(w, r, slot, SAMPLE_DIRECTION);
    if (!l->type->sample(l, b, n, p->wo, u, &wi)) return NULL;
    double cosine = dvec3_dot(n, wi), pdf = l->type->pdf(l, b, n, p->wo, wi);
    if (!(cosine * dvec3_dot(p->n, wi) > 0) || !(pdf > 0)) return NULL;
    dvec3 f = l->type->evaluate(l, b, n, p->wo, wi);
    double passing = lobe_passing(l, b, p->wo, wi, dvec3_dot(n, p->wo), cosine);
    dvec3 weight = dvec3_scale(f, passing * fabs(cosine) / pdf);
    path_ray *child =
        emit_ray(w, r, p, wi, dvec3_mul(weight, share), cosine < 0 ? wave_beyond(w) : &r->media,
                 slot, cosine < 0 ? RAY_REFRACTED : RAY_REFLECTED);
    if (child) child->drawn_pdf = (float)pdf;
    return child;
}

/* Where colours part at rough glass, each has a ray of its own. */
static void follow_gloss_by_color(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                                  const lobe *l, uint32_t slot) {
    for (int color = 0; color < 3; color++) {
        bsdf alone = *b;
        bsdf_take_color(&alone, color);
        path_ray *child =
            follow_gloss(w, r, p, &alone, l, color_alone(color), color_slot(slot, color));
        if (child) child->color = (uint8_t)(1 + color);
    }
}

static void hit_surface(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    emit_own_light(w, r, b);
    emit_direct_light(w, r, p, b, LOBES_LIT, LIGHT_AREAS);
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *l = &b->lobes[i];
        uint32_t slot = 2 * (uint32_t)i;
        if (l->type->class == LOBE_MIRROR) follow_mirror(w, r, p, b, l, 1, slot);
        if (l->type->class == LOBE_INTERFACE) follow_interface(w, r, p, b, l, slot);
        if (l->type->class != LOBE_GLOSSY) continue;
        if (b->disperses && l->type->transmits)
            follow_gloss_by_color(w, r, p, b, l, slot);
        else
            follow_gloss(w, r, p, b, l, (dvec3){1, 1, 1}, slot);
    }
}

const integrator integrator_cook = {
    .name = "cook",
    .help = "soft shadows, gloss, depth of field, motion blur (1984)",
    .samples = 64,
    .max_depth = 10,
    .max_depth_media = 24,
    .hit = hit_surface,
    .miss = emit_background,
};
