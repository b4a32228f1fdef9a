#include "integrators/record.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "integrators/wave.h"

snell_status record_create(uint32_t samples, uint32_t wave_size, record **out) {
    record *r = memory_zeroed(1, sizeof *r);
    if (r == NULL) return error_no_memory();
    r->sums = memory_zeroed(samples, sizeof *r->sums);
    r->waiting = memory_zeroed(wave_size, sizeof *r->waiting);
    r->stopped_by.instance = NO_ID;
    r->scrambles = 1;
    *out = r;
    if (r->sums && r->waiting) return SNELL_OK;
    record_destroy(r);
    return error_no_memory();
}

void record_destroy(record *r) {
    if (r == NULL) return;
    free(r->rays);
    free(r->lights);
    free(r->sums);
    free(r->waiting);
    free(r);
}

void record_add(record_sum sum, const double contribution[4]) {
    uint64_t overflows = 0; /* the film counts them */
    for (int c = 0; c < 4; c++)
        sum[c] += contribution[c] != 0 ? fixed_from(contribution[c], &overflows) : 0;
}

static void put3(double out[3], dvec3 v) {
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

/* ---- rays ---- */

/* Of all samples of the pixel, whose scrambles take turns. */
static uint32_t sample_number(const wave *w, const path_ray *r) {
    const record *k = w->settings.record;
    return r->sample * k->scrambles + k->scramble;
}

static recorded_ray *node_of(const wave *w, const path_ray *r) {
    return r->node == NO_ID ? NULL : &w->settings.record->rays[r->node];
}

/* Room for a ray of a sample; NULL: it is not wanted, or there is no more room. */
static recorded_ray *new_ray(record *k, uint32_t sample) {
    if (sample < k->first_sample || sample >= k->end_sample) return NULL;
    k->full |= k->ray_count >= k->rays_max;
    if (k->full || k->no_memory) return NULL;
    if (!ARRAY_GROW(k->rays, k->ray_count, k->ray_capacity, 1)) {
        k->no_memory = true;
        return NULL;
    }
    recorded_ray *made = &k->rays[k->ray_count++];
    *made = (recorded_ray){.material = NO_ID};
    return made;
}

static snell_ray_kind kind_said(uint8_t kind) {
    static const snell_ray_kind kinds[RAY_KIND_COUNT] = {SNELL_RAY_CAMERA, SNELL_RAY_REFLECTED,
                                                         SNELL_RAY_REFRACTED, SNELL_RAY_CONTINUED};
    return kinds[kind];
}

/* Where a ray begins its way: one that walks on, where it does so. */
static double start_of(const ray *r) { return r->after_t > 0 ? (double)r->after_t : 0; }

static void start_ray(const wave *w, uint32_t parent, path_ray *r, dvec3 weight) {
    record *k = w->settings.record;
    recorded_ray *made = new_ray(k, sample_number(w, r));
    r->node = made ? (uint32_t)(made - k->rays) : NO_ID;
    if (made == NULL) return;
    dvec3 d = dvec3_from(r->ray.d), o = dvec3_from(r->ray.o);
    made->said =
        (snell_explained_ray){.parent = parent,
                              .sample = sample_number(w, r),
                              .depth = r->depth,
                              .kind = kind_said(r->kind),
                              .end = SNELL_RAY_LEFT,
                              .origin = vec3_from(dvec3_add(o, dvec3_scale(d, start_of(&r->ray)))),
                              .direction = vec3_from(dvec3_normalize(d)),
                              .time = r->ray.time,
                              .transmittance = {1, 1, 1},
                              .alpha = 1,
                              .ior_from = 1,
                              .ior_to = 1};
    put3(made->said.weight, weight);
}

void record_camera_ray(const wave *w, path_ray *r) {
    start_ray(w, UINT32_MAX, r, (dvec3){1, 1, 1});
}

void record_child(const wave *w, const path_ray *parent, path_ray *child, dvec3 weight) {
    start_ray(w, parent->node, child, weight);
}

static void end_unborn(const wave *w, const path_ray *parent, dvec3 origin, dvec3 d, dvec3 weight,
                       ray_kind kind, snell_ray_end why) {
    recorded_ray *made =
        parent->node == NO_ID ? NULL : new_ray(w->settings.record, sample_number(w, parent));
    if (made == NULL) return;
    made->said = (snell_explained_ray){.parent = parent->node,
                                       .sample = sample_number(w, parent),
                                       .depth = parent->depth + (kind == RAY_CONTINUED ? 0u : 1u),
                                       .kind = kind_said((uint8_t)kind),
                                       .end = why,
                                       .origin = vec3_from(origin),
                                       .direction = vec3_from(dvec3_normalize(d)),
                                       .time = parent->ray.time,
                                       .transmittance = {1, 1, 1},
                                       .throughput =
                                           vec3_from(dvec3_mul(dvec3_from(parent->weight), weight)),
                                       .alpha = 1,
                                       .ior_from = 1,
                                       .ior_to = 1};
    put3(made->said.weight, weight);
}

void record_unborn(const wave *w, const path_ray *parent, const shade_point *p, dvec3 d,
                   dvec3 weight, ray_kind kind, snell_ray_end why) {
    end_unborn(w, parent, p->p, d, weight, kind, why);
}

void record_ended(const wave *w, const path_ray *parent, dvec3 weight) {
    dvec3 o = dvec3_from(parent->ray.o), d = dvec3_from(parent->ray.d);
    double t = start_of(&parent->ray);
    end_unborn(w, parent, dvec3_add(o, dvec3_scale(d, t)), d, weight, RAY_CONTINUED,
               SNELL_RAY_TOO_FAINT);
}

void record_absorbed(const wave *w, const path_ray *r, dvec3 transmittance) {
    recorded_ray *node = node_of(w, r);
    if (node) put3(node->said.transmittance, transmittance);
}

void record_color(const wave *w, const path_ray *r, dvec3 kept) {
    recorded_ray *node = node_of(w, r);
    if (node == NULL) return;
    const double *t = node->said.transmittance;
    put3(node->said.transmittance, (dvec3){t[0] * kept.x, t[1] * kept.y, t[2] * kept.z});
}

/* By Fresnel's formulas, of the first part that has them. */
static dvec3 fresnel_at(const bsdf *b, dvec3 n, dvec3 wo) {
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *l = &b->lobes[i];
        if (l->type->transmits) {
            double reflected = interface_reflected(l, b, dvec3_dot(wo, n));
            return (dvec3){reflected, reflected, reflected};
        }
        if (l->fresnel.kind != FRESNEL_NONE)
            return fresnel_evaluate(&l->fresnel, dvec3_dot(wo, lobe_normal(l, b, n)));
    }
    return (dvec3){0, 0, 0};
}

void record_hit(const wave *w, const path_ray *r, const hit *h, const shade_point *p, const bsdf *b,
                snell_ray_end end) {
    recorded_ray *node = node_of(w, r);
    if (node == NULL) return;
    snell_explained_ray *said = &node->said;
    said->end = end;
    said->throughput = r->weight;
    said->pdf = (double)r->drawn_pdf;
    said->distance = ((double)h->t - start_of(&r->ray)) * dvec3_length(dvec3_from(r->ray.d));
    dvec3 n = p->outside ? p->n : dvec3_negate(p->n);
    said->hit = (snell_hit){.t = h->t,
                            .u = h->u,
                            .v = h->v,
                            .primitive = h->primitive,
                            .normal = vec3_from(n),
                            .number = h->instance};
    said->position = vec3_from(p->p);
    said->normal = vec3_from(p->ns);
    said->inside = !p->outside;
    said->alpha = b->alpha;
    said->cosine = dvec3_dot(p->wo, p->ns);
    if (material_bounds_medium(p->material->type, p->material->desc)) {
        said->ior_from = b->ior1;
        said->ior_to = b->ior2;
    }
    put3(said->fresnel, fresnel_at(b, p->ns, p->wo));
    node->emission = b->emission;
    node->material = (uint32_t)(p->material - w->settings.scene->materials);
}

void record_miss(const wave *w, const path_ray *r) {
    recorded_ray *node = node_of(w, r);
    if (node == NULL) return;
    node->said.throughput = r->weight;
    node->said.pdf = (double)r->drawn_pdf;
    node->said.distance = INFINITY;
}

/* ---- light ---- */

static recorded_light *new_light(const wave *w, const path_ray *r, snell_light_source source) {
    record *k = w->settings.record;
    if (r->node == NO_ID || k->no_memory) return NULL;
    if (!ARRAY_GROW(k->lights, k->light_count, k->light_capacity, 1)) {
        k->no_memory = true;
        return NULL;
    }
    recorded_light *made = &k->lights[k->light_count++];
    *made = (recorded_light){.said = {.ray = r->node,
                                      .source = source,
                                      .distance = INFINITY,
                                      .choice = 1,
                                      .cosine = 1,
                                      .bsdf = {1, 1, 1},
                                      .weight = 1,
                                      .visibility = {1, 1, 1}},
                             .light = NO_ID,
                             .blocker = NO_ID};
    return made;
}

/* To the sample's sum, and to its light where that is kept. */
static void contribute(record *k, uint32_t sample, recorded_light *of, dvec3 radiance) {
    const double added[4] = {radiance.x, radiance.y, radiance.z, 0};
    record_add(k->sums[sample], added);
    if (of) memcpy(of->said.contribution, added, sizeof added);
}

/* What the film is given of a radiance. */
static dvec3 weighted(const path_ray *r, dvec3 radiance) {
    return dvec3_mul(dvec3_from(r->weight), radiance);
}

static bool is_zero(dvec3 v) { return v.x == 0 && v.y == 0 && v.z == 0; }

void record_surface(const wave *w, const path_ray *r, dvec3 radiance) {
    if (is_zero(radiance)) return;
    recorded_light *made = new_light(w, r, SNELL_SOURCE_EMISSION);
    contribute(w->settings.record, sample_number(w, r), made, weighted(r, radiance));
    if (made == NULL) return;
    put3(made->said.incoming, radiance);
    dvec3 whole = node_of(w, r)->emission;
    if (is_zero(whole)) made->said.source = SNELL_SOURCE_AMBIENT;
    if (!w->settings.integrator->one_branch) return;
    /* Of which `path` counts a part. */
    put3(made->said.incoming, whole);
    made->said.weight = dvec3_largest(radiance) / dvec3_largest(whole);
}

void record_sky(const wave *w, const path_ray *r, dvec3 radiance) {
    if (is_zero(radiance)) return;
    recorded_light *made = new_light(w, r, SNELL_SOURCE_SKY);
    contribute(w->settings.record, sample_number(w, r), made, weighted(r, radiance));
    if (made == NULL) return;
    put3(made->said.incoming, radiance);
    const scene *s = w->settings.scene;
    dvec3 d = dvec3_normalize(dvec3_from(r->ray.d));
    uint32_t seen = NO_ID, count = 0;
    for (uint32_t i = 0; i < s->light_count; i++) {
        if (!scene_light_is_seen(s, i, r->primary)) continue;
        if (!(dvec3_largest(s->lights[i].type->radiance(&s->lights[i], d)) > 0)) continue;
        seen = i;
        count++;
    }
    if (count == 1) made->light = seen;
}

void record_coverage(const wave *w, const path_ray *r, double alpha) {
    const double added[4] = {0, 0, 0, alpha};
    record_add(w->settings.record->sums[sample_number(w, r)], added);
    recorded_light *made = new_light(w, r, SNELL_SOURCE_COVERAGE);
    if (made) made->said.contribution[3] = alpha;
}

/* In the numbering of the integrator: lights, or sources of light (scene/lights.h). */
static void name_light(const wave *w, recorded_light *out) {
    const scene *s = w->settings.scene;
    out->light = w->asked;
    out->is_instance = w->asked >= s->light_count;
    if (!out->is_instance) return;
    uint32_t index = w->asked - s->light_count;
    out->light = w->settings.integrator->one_branch ? s->emitters[index].instance
                                                    : s->surface_lights[index].instance;
}

/* What is left of a product when one of its factors, or 0 where that is 0, is taken out. */
static double without(double product, double factor) { return factor > 0 ? product / factor : 0; }

/* The shadow ray, if there is one, is the next that waits: so there must be room for it. */
void record_asked(wave *w, const path_ray *r, const shade_point *p, const light_sample *sample,
                  double weight, dvec3 radiance, bool casts_shadow) {
    record *k = w->settings.record;
    if (w->shadow_count == w->settings.wave_size) wave_test_shadows(w);
    recorded_light *made = new_light(w, r, SNELL_SOURCE_LIGHT);
    k->waiting[w->shadow_count].light = made ? (uint32_t)(made - k->lights) : NO_ID;
    k->waiting[w->shadow_count].sample = sample_number(w, r);
    if (!casts_shadow) contribute(k, sample_number(w, r), made, weighted(r, radiance));
    if (made == NULL) return;
    dvec3 wi = dvec3_normalize(sample->to_light), l = sample->light;
    double cosine = fabs(dvec3_dot(p->ns, wi)), rest = cosine * weight;
    snell_explained_light *said = &made->said;
    name_light(w, made);
    said->direction = vec3_from(wi);
    if (!sample->infinite) said->distance = dvec3_length(sample->to_light);
    put3(said->incoming, l);
    if (w->asked_chance > 0) said->choice = w->asked_chance;
    said->pdf = said->choice * sample->pdf;
    said->cosine = cosine;
    put3(said->bsdf, (dvec3){without(radiance.x, l.x * rest), without(radiance.y, l.y * rest),
                             without(radiance.z, l.z * rest)});
    said->weight = weight;
    said->tested = casts_shadow && dvec3_largest(weighted(r, radiance)) > 0;
    if (said->tested) put3(said->visibility, (dvec3){0, 0, 0}); /* until something comes through */
}

void record_irradiance(const wave *w, const path_ray *r, dvec3 f, dvec3 irradiance) {
    recorded_light *made = new_light(w, r, SNELL_SOURCE_LIGHT);
    contribute(w->settings.record, sample_number(w, r), made,
               weighted(r, dvec3_mul(f, irradiance)));
    if (made == NULL) return;
    name_light(w, made);
    put3(made->said.incoming, irradiance);
    put3(made->said.bsdf, f);
}

static recorded_light *waiting_light(const record *k, size_t index) {
    uint32_t number = k->waiting[index].light;
    return number == NO_ID ? NULL : &k->lights[number];
}

static void set_blocker(const wave *w, size_t index, const hit *h) {
    recorded_light *of = waiting_light(w->settings.record, index);
    if (of == NULL || h->instance == NO_ID) return;
    of->blocker = h->instance;
    of->said.blocker_distance = (double)h->t * dvec3_length(dvec3_from(w->shadow_rays[index].d));
}

/* The loop only asks whether anything is in the way; here the nearest is found. */
void record_blocked(const wave *w) {
    for (size_t i = 0; i < w->shadow_count; i++) {
        if (!w->blocked[i] || waiting_light(w->settings.record, i) == NULL) continue;
        hit h;
        accel_trace(w->settings.scene->accel, w->settings.isa, &w->shadow_rays[i], &h, 1, NULL);
        set_blocker(w, i, &h);
    }
}

void record_stopped(const wave *w, const hit *by) { w->settings.record->stopped_by = *by; }

void record_filtered(const wave *w, size_t index, dvec3 through) {
    record *k = w->settings.record;
    recorded_light *of = waiting_light(k, index);
    if (of) put3(of->said.visibility, through);
    set_blocker(w, index, &k->stopped_by);
    k->stopped_by.instance = NO_ID;
    k->filtered = true;
}

void record_shadow(const wave *w, size_t index, dvec3 contribution) {
    record *k = w->settings.record;
    recorded_light *of = waiting_light(k, index);
    contribute(k, k->waiting[index].sample, of, contribution);
    if (of && !k->filtered) put3(of->said.visibility, (dvec3){1, 1, 1});
    k->filtered = false;
}
