/* Shadow rays: first any opaque blocker is asked for, for many rays at once; those that remain walk
 * through everything that lets light through. */
#include "integrators/aov.h"
#include "integrators/record.h"
#include "integrators/wave.h"

enum { FILTER_STEPS_MAX = 10000 };

bool wave_goes_straight_on(const bsdf *b) {
    return b->lobe_count == 1 && b->lobes[0].type->class == LOBE_INTERFACE &&
           !b->lobes[0].type->thin && b->ior1 == b->ior2;
}

/* What light that paths would not meet otherwise passes the face of a dielectric: all of it where it
 * goes straight on, else what finds the solid not there (it meets none of its faces). */
static dvec3 path_filter(const scene *s, const shade_point *p, double alpha, media *m) {
    if (p->outside && alpha < 1) return (dvec3){1 - alpha, 1 - alpha, 1 - alpha};
    const medium *before = media_current(m, s);
    bool known = p->outside ? media_enter(m, p->instance) : media_leave(m, p->instance);
    const medium *after = media_current(m, s);
    if (!known || before == after) return (dvec3){1, 1, 1};
    bsdf b;
    material_evaluate(p->material, &p->at, &b);
    b.ior1 = before->ior;
    b.ior2 = after->ior;
    return wave_goes_straight_on(&b) ? bsdf_passing(&b) : (dvec3){0, 0, 0};
}

/* What one surface lets through straight on: 1 - alpha, and at the face of a dielectric 1 - F of
 * its colour. The angle of a straight ray counts as that in the rarer medium, at both faces: then a
 * pane lets through exactly what Fresnel's formulas say (light that leaves it again is never
 * totally reflected), and a ball does not cast a ring of false total reflection. */
static dvec3 surface_filter(wave *w, const shade_point *p, bool met, media *m) {
    const scene *s = w->settings.scene;
    const material_common *common = p->material->desc;
    if (common->shadow == SHADOW_NONE && !met) return (dvec3){1, 1, 1};
    if (common->shadow == SHADOW_OPAQUE) return (dvec3){0, 0, 0};
    double alpha = material_alpha(p->material, &p->at), through = 1 - alpha;
    if (!(alpha > 0)) return (dvec3){1, 1, 1}; /* nothing is there, nor behind it */
    dvec3 sum = {through, through, through};
    bsdf b;
    if (p->material->thin) {
        material_evaluate(p->material, &p->at, &b);
        bool smooth = w->settings.integrator->one_branch; /* paths find what a rough one scatters */
        dvec3 straight = bsdf_straight(&b, dvec3_dot(p->wo, p->ns), smooth);
        return dvec3_add(sum, dvec3_scale(straight, alpha));
    }
    if (!material_bounds_medium(p->material->type, p->material->desc)) return sum;
    if (w->settings.integrator->one_branch) return path_filter(s, p, alpha, m);
    const medium *before = media_current(m, s);
    if (p->outside)
        media_enter(m, p->instance);
    else
        media_leave(m, p->instance);
    const medium *after = media_current(m, s);
    if (before == after) return (dvec3){1, 1, 1}; /* a face inside what has priority */
    double ior1 = double_min(before->ior, after->ior), ior2 = double_max(before->ior, after->ior);
    double pass = alpha * (1 - fresnel_dielectric(dvec3_dot(p->wo, p->ns), ior1, ior2));
    material_evaluate(p->material, &p->at, &b);
    return dvec3_add(sum, dvec3_scale(bsdf_passing(&b), pass));
}

/* Walks through everything that filters; in appel and whitted light goes straight on through glass.
 * Light that a path may meet by itself has to pass what casts no shadow too: else it would count
 * through it as a shadow ray, and again, or not at all, as what the path meets. */
static dvec3 shadow_filter(wave *w, shadow_ray *of, ray *r) {
    const scene *s = w->settings.scene;
    dvec3 through = {1, 1, 1};
    double from = 0, length = dvec3_length(dvec3_from(r->d)); /* metres */
    r->mask = MASK_FILTER | (of->met ? MASK_NO_SHADOW : 0u);
    for (int step = 0; step < FILTER_STEPS_MAX; step++) {
        hit h;
        accel_trace(s->accel, w->settings.isa, r, &h, 1, &w->stats.shadow_counters);
        double end = h.instance == NO_ID ? (double)r->t_max : (double)h.t;
        through = dvec3_mul(through, media_transmittance(&of->media, s, (end - from) * length));
        if (h.instance == NO_ID) return through;
        shade_point p;
        scene_shade_point(s, r, &h, &p);
        through = dvec3_mul(through, surface_filter(w, &p, of->met, &of->media));
        if (!(dvec3_largest(through) > 0)) {
            if (w->settings.record) record_stopped(w, &h);
            return through;
        }
        from = end;
        r->after_t = h.t;
        r->after_instance = h.instance;
        r->after_primitive = h.primitive;
    }
    w->stats.blocked_by_cap++;
    return (dvec3){0, 0, 0};
}

/* The caller may trace rays of its own on this thread while it is told. */
void wave_look_up(wave *w) {
    w->stats.spent_solids += solid_take_spent();
    if (w->go_on && !w->stopped && !w->go_on(w->user, &w->stats)) w->stopped = true;
}

void wave_test_shadows(wave *w) {
    enum { WALKS_BETWEEN_LOOKS = 256 };
    const scene *s = w->settings.scene;
    shadow_ray *shadows = w->shadows;
    wave_phase before = wave_begin_phase(w, WAVE_SHADOWS);
    accel_occluded(s->accel, w->settings.isa, w->shadow_rays, w->blocked, w->shadow_count,
                   &w->stats.shadow_counters);
    if (w->settings.record) record_blocked(w);
    if (w->aovs) aov_traced_shadows(w);
    for (size_t i = 0; i < w->shadow_count && !w->stopped; i++) {
        if (w->blocked[i]) continue;
        dvec3 arriving = dvec3_from(shadows[i].light);
        if (s->has_filters || (shadows[i].met && s->has_unshadowing)) {
            dvec3 through = shadow_filter(w, &shadows[i], &w->shadow_rays[i]);
            if (w->settings.record) record_filtered(w, i, through);
            arriving = dvec3_mul(arriving, through);
            if (i % WALKS_BETWEEN_LOOKS == WALKS_BETWEEN_LOOKS - 1) wave_look_up(w);
        }
        if (w->settings.record) record_shadow(w, i, arriving);
        if (w->aovs) aov_shadow(w, i, arriving);
        film_block_add(w->film, shadows[i].pixel, arriving);
    }
    w->shadow_count = 0;
    wave_begin_phase(w, before);
}
