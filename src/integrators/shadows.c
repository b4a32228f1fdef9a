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
        dvec3 straight = bsdf_straight(&b, p->ns, p->wo, smooth);
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

/* Shadow rays that walk through what filters, side by side; in appel and whitted light goes straight on
 * through glass. Light that a path may meet by itself has to pass what casts no shadow too: else it would
 * count through it as a shadow ray, and again, or not at all, as what the path meets. */
enum { WALKS = 128 };
typedef struct walks {
    size_t count;
    uint32_t shadow[WALKS]; /* which it is */
    ray rays[WALKS];
    hit hits[WALKS];
    double from[WALKS], length[WALKS]; /* of the last hit; of the direction, metres */
    dvec3 through[WALKS];
} walks;

static bool must_walk(const wave *w, const shadow_ray *of) {
    const scene *s = w->settings.scene;
    return s->has_filters || (of->met && s->has_unshadowing);
}

static void add_walk(walks *k, const wave *w, uint32_t shadow) {
    size_t i = k->count++;
    const ray *r = &w->shadow_rays[shadow];
    k->shadow[i] = shadow;
    k->rays[i] = *r;
    k->rays[i].mask = MASK_FILTER | (w->shadows[shadow].met ? MASK_NO_SHADOW : 0u);
    k->from[i] = 0;
    k->length[i] = dvec3_length(dvec3_from(r->d));
    k->through[i] = (dvec3){1, 1, 1};
}

/* From what was met, or the light. False: it ends there. */
static bool step_walk(wave *w, walks *k, size_t i) {
    const scene *s = w->settings.scene;
    shadow_ray *of = &w->shadows[k->shadow[i]];
    ray *r = &k->rays[i];
    const hit *h = &k->hits[i];
    double end = h->instance == NO_ID ? (double)r->t_max : (double)h->t;
    dvec3 passed = media_transmittance(&of->media, s, (end - k->from[i]) * k->length[i]);
    k->through[i] = dvec3_mul(k->through[i], passed);
    if (h->instance == NO_ID) return false;
    shade_point p;
    scene_shade_point(s, r, h, &p);
    k->through[i] = dvec3_mul(k->through[i], surface_filter(w, &p, of->met, &of->media));
    if (!(dvec3_largest(k->through[i]) > 0)) {
        if (w->settings.record) record_stopped(w, h);
        return false;
    }
    k->from[i] = end;
    r->after_t = h->t;
    r->after_instance = h->instance;
    r->after_primitive = h->primitive;
    return true;
}

/* The caller may trace rays of its own on this thread while it is told. */
void wave_look_up(wave *w) {
    w->stats.spent_solids += solid_take_spent();
    if (w->go_on && !w->stopped && !w->go_on(w->user, &w->stats)) w->stopped = true;
}

static void light_arrives(wave *w, size_t shadow, dvec3 arriving) {
    if (w->settings.record) record_shadow(w, shadow, arriving);
    if (w->aovs) aov_shadow(w, shadow, arriving);
    film_block_add(w->film, w->shadows[shadow].pixel, arriving);
}

static void end_walk(wave *w, const walks *k, size_t i, dvec3 through) {
    uint32_t shadow = k->shadow[i];
    if (w->settings.record) record_filtered(w, shadow, through);
    light_arrives(w, shadow, dvec3_mul(dvec3_from(w->shadows[shadow].light), through));
}

/* All step by step, until none is left. */
static void finish_walks(wave *w, walks *k) {
    for (int step = 0; step < FILTER_STEPS_MAX && k->count > 0; step++) {
        size_t left = 0;
        accel_trace(w->settings.scene->accel, w->settings.isa, k->rays, k->hits, k->count,
                    &w->stats.shadow_counters);
        for (size_t i = 0; i < k->count; i++) {
            if (!step_walk(w, k, i)) {
                end_walk(w, k, i, k->through[i]);
                continue;
            }
            k->shadow[left] = k->shadow[i];
            k->rays[left] = k->rays[i];
            k->from[left] = k->from[i], k->length[left] = k->length[i];
            k->through[left++] = k->through[i];
        }
        k->count = left;
    }
    w->stats.blocked_by_cap += k->count;
    for (size_t i = 0; i < k->count; i++) end_walk(w, k, i, (dvec3){0, 0, 0});
    k->count = 0;
    wave_look_up(w);
}

void wave_test_shadows(wave *w) {
    walks k;
    k.count = 0;
    wave_phase before = wave_begin_phase(w, WAVE_SHADOWS);
    accel_occluded(w->settings.scene->accel, w->settings.isa, w->shadow_rays, w->blocked,
                   w->shadow_count, &w->stats.shadow_counters);
    if (w->settings.record) record_blocked(w);
    if (w->aovs) aov_traced_shadows(w);
    for (size_t i = 0; i < w->shadow_count && !w->stopped; i++) {
        if (w->blocked[i]) continue;
        if (!must_walk(w, &w->shadows[i])) {
            light_arrives(w, i, dvec3_from(w->shadows[i].light));
            continue;
        }
        add_walk(&k, w, (uint32_t)i);
        if (k.count == WALKS) finish_walks(w, &k);
    }
    if (k.count > 0 && !w->stopped) finish_walks(w, &k);
    w->shadow_count = 0;
    wave_begin_phase(w, before);
}
