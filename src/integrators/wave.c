/* The wave loop: rays wait in a pool; the newest of them are traced together. Contributions are
 * added in fixed point, so the order in which anything happens is free and never shows in the
 * picture. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "integrators/differential.h"
#include "integrators/integrator.h"
#include "maths/functions.h"
#include "sampling/sampling.h"

/* A shadow ray: what it adds to the film if light gets through. */
typedef struct shadow_ray {
    ray ray;
    vec3 light; /* weighted */
    uint32_t pixel;
    double length; /* of ray.d, metres */
    media media;
} shadow_ray;

struct wave {
    wave_settings settings;
    path_ray *pool; /* a stack: the newest rays are traced first, which bounds it */
    size_t pool_count, pool_capacity;
    path_ray *next; /* what the wave that is being traced emits */
    size_t next_count, next_capacity;
    shadow_ray *shadows;
    size_t shadow_count; /* at most a wave: then they are tested */
    /* what is being traced */
    ray *rays;
    hit *hits;
    uint8_t *blocked;
    film_block *film;
    uint64_t streams[FILM_BLOCK * FILM_BLOCK]; /* of the random numbers of each pixel's place */
    media beyond;                              /* of the surface that a policy is asked about */
    bool out_of_memory, stopped;
    bool (*go_on)(void *user, const wave_stats *stats);
    void *user;
    wave_stats stats;
};

/* Over twice a wave the pool is worked off in small bites, depth first. */
enum { SMALL_BITE = 64, FILTER_STEPS_MAX = 10000 };

/* A larger wave leaves the second-level cache, and keeps progress and cancelling waiting. */
enum { WAVE_DEFAULT = 2048, WAVE_MAX = 4096, WORK_BETWEEN_LOOKS = 16384 };

snell_status wave_create(const wave_settings *settings, wave **out) {
    wave *w = memory_zeroed(1, sizeof *w);
    if (w == NULL) return error_no_memory();
    w->settings = *settings;
    if (w->settings.wave_size == 0) w->settings.wave_size = WAVE_DEFAULT;
    if (w->settings.wave_size > WAVE_MAX) w->settings.wave_size = WAVE_MAX;
    size_t size = w->settings.wave_size;
    w->rays = memory_resize(NULL, size, sizeof *w->rays);
    w->hits = memory_resize(NULL, size, sizeof *w->hits);
    w->blocked = memory_resize(NULL, size, sizeof *w->blocked);
    w->shadows = memory_resize(NULL, size, sizeof *w->shadows);
    if (!w->rays || !w->hits || !w->blocked || !w->shadows) {
        wave_destroy(w);
        return error_no_memory();
    }
    *out = w;
    return SNELL_OK;
}

void wave_destroy(wave *w) {
    if (w == NULL) return;
    free(w->pool);
    free(w->shadows);
    free(w->next);
    free(w->rays);
    free(w->hits);
    free(w->blocked);
    free(w);
}

const wave_stats *wave_get_stats(const wave *w) { return &w->stats; }
const scene *wave_scene(const wave *w) { return w->settings.scene; }
uint32_t wave_max_depth(const wave *w) { return w->settings.max_depth; }
dvec3 wave_eye(const wave *w) { return dvec3_from(w->settings.frame.position); }
const media *wave_beyond(const wave *w) { return &w->beyond; }

sample2 wave_draw(const wave *w, const path_ray *r, sample_purpose purpose) {
    return sample_point(sample_stream(w->streams[r->pixel], r->code, purpose), r->sample);
}

sample2 wave_draw_child(const wave *w, const path_ray *r, uint32_t slot, sample_purpose purpose) {
    uint64_t code = path_code_child(r->code, slot);
    return sample_point(sample_stream(w->streams[r->pixel], code, purpose), r->sample);
}

/* ---- emitting ---- */

void emit_radiance(wave *w, const path_ray *r, dvec3 radiance) {
    if (radiance.x == 0 && radiance.y == 0 && radiance.z == 0) return;
    film_block_add(w->film, r->pixel, dvec3_mul(dvec3_from(r->weight), radiance));
}

void emit_own_light(wave *w, const path_ray *r, const bsdf *b) {
    emit_radiance(w, r, dvec3_add(b->emission, dvec3_mul(b->ambient, w->settings.scene->ambient)));
}

/* In a transparent picture the camera sees through to nothing, or to as much of the background as the
 * scene's alpha says. */
void emit_sky(wave *w, const path_ray *r, light_weight_fn *weight) {
    const scene *s = w->settings.scene;
    dvec3 d = dvec3_normalize(dvec3_from(r->ray.d)), radiance = {0, 0, 0};
    bool sees_lights = false;
    for (uint32_t i = 0; i < s->light_count; i++) {
        if (!scene_light_is_seen(s, i, r->primary)) continue;
        const light *l = &s->lights[i];
        dvec3 here = l->type->radiance(l, d);
        sees_lights |= l->type->irradiance != NULL; /* a disk in the sky is not all of it */
        if (!(dvec3_largest(here) > 0)) continue;
        radiance = dvec3_add(radiance, dvec3_scale(here, weight ? weight(w, r, i) : 1));
    }
    if (!sees_lights) radiance = dvec3_add(radiance, scene_background(s, dvec3_from(r->ray.d)));
    if (r->primary && w->settings.transparent) {
        double alpha = s->background_alpha < 1 ? s->background_alpha : 0;
        film_block_add_alpha(w->film, r->pixel, (double)r->coverage * alpha);
        radiance = dvec3_scale(radiance, alpha);
    }
    emit_radiance(w, r, radiance);
}

void emit_background(wave *w, const path_ray *r) { emit_sky(w, r, NULL); }

static path_ray *push_ray(wave *w, const path_ray *child) {
    if (!ARRAY_GROW(w->next, w->next_count, w->next_capacity, 1)) {
        w->out_of_memory = true;
        return NULL;
    }
    w->stats.rays[child->kind]++;
    w->next[w->next_count] = *child;
    return &w->next[w->next_count++];
}

/* min_weight only saves time: what it drops is counted. */
static bool matters(wave *w, vec3 weight) {
    double largest = (double)vec3_largest(weight);
    if (w->settings.integrator->one_branch) return largest > 0; /* chance ends the path */
    double brightest = double_max(1, w->settings.scene->brightest_background);
    if (largest * brightest >= (double)w->settings.min_weight && largest > 0) return true;
    w->stats.dropped_weight += fixed_from(largest, &w->stats.film_overflows);
    return false;
}

path_ray *emit_ray(wave *w, const path_ray *r, const shade_point *p, dvec3 d, dvec3 weight,
                   const media *m, uint32_t slot, ray_kind kind) {
    if (r->depth >= w->settings.max_depth) return NULL;
    path_ray child = {.ray = scene_spawn_ray(p, d, INFINITY),
                      .weight = vec3_from(dvec3_mul(dvec3_from(r->weight), weight)),
                      .pixel = r->pixel,
                      .sample = r->sample,
                      .code = path_code_child(r->code, slot),
                      .media = *m,
                      .depth = (uint16_t)(r->depth + 1),
                      .kind = (uint8_t)kind};
    child.ray.time = r->ray.time;
    return matters(w, child.weight) ? push_ray(w, &child) : NULL;
}

void emit_continued(wave *w, const path_ray *r, const hit *from, dvec3 weight, const media *m) {
    path_ray child = *r;
    child.ray.after_t = from->t;
    child.ray.after_instance = from->instance;
    child.ray.after_primitive = from->primitive;
    child.weight = vec3_from(dvec3_mul(dvec3_from(r->weight), weight));
    child.media = *m;
    child.kind = RAY_CONTINUED;
    if (matters(w, child.weight)) push_ray(w, &child);
}

static void test_shadows(wave *w);

/* What shadow rays pass as if it were not there does not absorb them either. */
static media media_for_shadows(const media *m, const scene *s) {
    media seen = {0};
    for (uint32_t i = 0; i < m->count; i++) {
        const material *of = &s->materials[s->instances[m->instances[i]].medium_material];
        if (((const material_common *)of->desc)->shadow != SHADOW_NONE)
            media_enter(&seen, m->instances[i]);
    }
    return seen;
}

void emit_shadow_ray(wave *w, const path_ray *r, const shade_point *p, const light_sample *from,
                     dvec3 radiance) {
    vec3 carried = vec3_from(dvec3_mul(dvec3_from(r->weight), radiance));
    if (!(vec3_largest(carried) > 0)) return;
    if (w->shadow_count == w->settings.wave_size) test_shadows(w);
    const media *m = dvec3_dot(p->n, from->to_light) > 0 ? &r->media : &w->beyond;
    /* From the surface to the light: t = 1 is the light itself. */
    shadow_ray *s = &w->shadows[w->shadow_count++];
    *s = (shadow_ray){.ray = scene_spawn_ray(p, from->to_light, from->infinite ? INFINITY : 1),
                      .light = carried,
                      .pixel = r->pixel,
                      .media = media_for_shadows(m, w->settings.scene)};
    if (!from->infinite) {
        dvec3 end = dvec3_add(p->p, from->to_end);
        s->ray.d = vec3_from(dvec3_sub(end, dvec3_from(s->ray.o)));
    }
    s->length = dvec3_length(dvec3_from(s->ray.d));
    s->ray.mask = MASK_OPAQUE | MASK_LIGHT;
    s->ray.time = r->ray.time;
    w->stats.shadow_rays++;
}

dvec3 light_reflected(const shade_point *p, const bsdf *b, lobe_set lobes,
                      const light_sample *sample) {
    dvec3 wi = dvec3_normalize(sample->to_light);
    double cosine = dvec3_dot(p->ns, wi);
    if (!(cosine * dvec3_dot(p->n, wi) > 0)) return (dvec3){0, 0, 0};
    dvec3 f = bsdf_evaluate(b, lobes, p->ns, p->wo, wi);
    return dvec3_scale(dvec3_mul(f, sample->light), fabs(cosine));
}

/* One sample of a light. */
static void emit_light(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                       lobe_set lobes, const light_sample *sample, bool casts_shadow) {
    dvec3 radiance = light_reflected(p, b, lobes, sample);
    if (sample->pdf > 0) radiance = dvec3_scale(radiance, 1 / sample->pdf);
    if (casts_shadow)
        emit_shadow_ray(w, r, p, sample, radiance);
    else
        emit_radiance(w, r, radiance);
}

/* Light from everywhere on matte lobes, with nothing in the way; they look as they do to light along
 * the normal. */
static void emit_irradiance(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                            const light *l) {
    double cosine = dvec3_dot(p->ns, p->wo);
    dvec3 sum = {0, 0, 0};
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *part = &b->lobes[i];
        if (!part->type->matte) continue;
        dvec3 f = part->type->evaluate(part, b, p->ns, p->wo, p->ns);
        sum = dvec3_add(sum, dvec3_scale(f, lobe_passing(part, b, cosine, 1)));
    }
    emit_radiance(w, r, dvec3_mul(sum, l->type->irradiance(l, p->ns)));
}

static void emit_centers(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                         lobe_set lobes, uint32_t light_index) {
    const scene *s = w->settings.scene;
    const light_type *type = scene_light_type(s, light_index);
    if (type && type->irradiance) {
        emit_irradiance(w, r, p, b, &s->lights[light_index]);
        return;
    }
    uint32_t count = scene_light_center_count(s, light_index);
    for (uint32_t k = 0; k < count; k++) {
        light_sample sample;
        if (scene_sample_light_center(s, light_index, k, p->p, wave_eye(w), r->ray.time, &sample))
            emit_light(w, r, p, b, lobes, &sample, !type || type->casts_shadow);
    }
}

static void emit_area(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                      lobe_set lobes, uint32_t light_index) {
    const scene *s = w->settings.scene;
    const light_type *type = scene_light_type(s, light_index);
    light_sample sample;
    sample2 u = wave_draw_child(w, r, light_index, SAMPLE_LIGHT);
    if (!scene_sample_light(s, light_index, p->p, wave_eye(w), r->ray.time, u, &sample)) return;
    if (sample.pdf > 0) lobes &= LOBES_DIFFUSE;
    emit_light(w, r, p, b, lobes, &sample, !type || type->casts_shadow);
}

void emit_direct_light(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                       lobe_set lobes, light_places places) {
    if (!bsdf_is_lit(b, lobes)) return;
    uint32_t count = scene_light_count(w->settings.scene);
    for (uint32_t i = 0; i < count; i++)
        (places == LIGHT_CENTERS ? emit_centers : emit_area)(w, r, p, b, lobes, i);
}

/* ---- shadows ---- */

/* A smooth face between media of one ior: light goes straight on, and in `path` that is no new
 * direction. Of what is there in part, that is only true of what has entered. */
static bool goes_straight_on(const bsdf *b) {
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
    return goes_straight_on(&b) ? bsdf_passing(&b) : (dvec3){0, 0, 0};
}

/* What one surface lets through straight on: 1 - alpha, and at the face of a dielectric 1 - F of
 * its colour. The angle of a straight ray counts as that in the rarer medium, at both faces: then a
 * pane lets through exactly what Fresnel's formulas say (light that leaves it again is never
 * totally reflected), and a ball does not cast a ring of false total reflection. */
static dvec3 surface_filter(wave *w, const shade_point *p, media *m) {
    const scene *s = w->settings.scene;
    const material_common *common = p->material->desc;
    if (common->shadow == SHADOW_NONE) return (dvec3){1, 1, 1};
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
 */
static dvec3 shadow_filter(wave *w, shadow_ray *r) {
    const scene *s = w->settings.scene;
    dvec3 through = {1, 1, 1};
    double from = 0;
    r->ray.mask = MASK_FILTER;
    for (int step = 0; step < FILTER_STEPS_MAX; step++) {
        hit h;
        accel_trace(s->accel, w->settings.isa, &r->ray, &h, 1, &w->stats.counters);
        double end = h.instance == NO_ID ? (double)r->ray.t_max : (double)h.t;
        through = dvec3_mul(through, media_transmittance(&r->media, s, (end - from) * r->length));
        if (h.instance == NO_ID) return through;
        shade_point p;
        scene_shade_point(s, &r->ray, &h, &p);
        through = dvec3_mul(through, surface_filter(w, &p, &r->media));
        if (!(dvec3_largest(through) > 0)) return through;
        from = end;
        r->ray.after_t = h.t;
        r->ray.after_instance = h.instance;
        r->ray.after_primitive = h.primitive;
    }
    w->stats.blocked_by_cap++;
    return (dvec3){0, 0, 0};
}

/* Progress and cancelling, after some work in the midst of a wave. */
static void look_up(wave *w) {
    if (w->go_on && !w->stopped && !w->go_on(w->user, &w->stats)) w->stopped = true;
}

/* Uses w->rays and w->blocked, which nothing needs any more once the wave's hits are known. */
static void test_shadows(wave *w) {
    enum { WALKS_BETWEEN_LOOKS = 256 };
    const scene *s = w->settings.scene;
    shadow_ray *shadows = w->shadows;
    for (size_t i = 0; i < w->shadow_count; i++) w->rays[i] = shadows[i].ray;
    accel_occluded(s->accel, w->settings.isa, w->rays, w->blocked, w->shadow_count,
                   &w->stats.counters);
    for (size_t i = 0; i < w->shadow_count && !w->stopped; i++) {
        if (w->blocked[i]) continue;
        dvec3 arriving = dvec3_from(shadows[i].light);
        if (s->has_filters) {
            arriving = dvec3_mul(arriving, shadow_filter(w, &shadows[i]));
            if (i % WALKS_BETWEEN_LOOKS == WALKS_BETWEEN_LOOKS - 1) look_up(w);
        }
        film_block_add(w->film, shadows[i].pixel, arriving);
    }
    w->shadow_count = 0;
}

/* ---- hits and misses ---- */

/* Beer's law on the way to the hit or, for a miss, to infinity. */
static void absorb(wave *w, path_ray *r, double t) {
    if (r->media.count == 0) return;
    /* A walked-on ray has paid up to where it walked on from. */
    double from = r->ray.after_t > 0 ? (double)r->ray.after_t : 0;
    double length = dvec3_length(dvec3_from(r->ray.d));
    dvec3 through = media_transmittance(&r->media, w->settings.scene, (t - from) * length);
    r->weight = vec3_from(dvec3_mul(dvec3_from(r->weight), through));
}

/* Crosses the face of a dielectric: *beyond is what the ray is in after it. true: nothing changes
 * across it, being inside a medium of higher priority.
 *
 * Of what is there in part, a ray meets all or nothing: what passed the face where it would have
 * entered goes by the other faces too, and what did enter finds them wholly there. */
static bool cross_interface(wave *w, const path_ray *r, const shade_point *p, bsdf *b,
                            media *beyond) {
    const scene *s = w->settings.scene;
    *beyond = r->media;
    if (!material_bounds_medium(p->material->type, p->material->desc) || b->alpha <= 0)
        return false;
    bool known = p->outside ? media_enter(beyond, p->instance) : media_leave(beyond, p->instance);
    if (!known && (p->outside || b->alpha >= 1)) w->stats.media_mismatches++;
    if (!p->outside) b->alpha = 1;
    const medium *before = media_current(&r->media, s), *after = media_current(beyond, s);
    b->ior1 = before->ior;
    b->ior2 = after->ior;
    return before == after;
}

/* Of what is there in part, a path meets all or nothing. The draw is the surface's own, so that two
 * that coincide are independent, and the place's: a ball is met twice. */
static bool is_there(const wave *w, const path_ray *r, const hit *h, double alpha) {
    uint32_t place;
    memcpy(&place, &h->t, sizeof place);
    uint64_t code =
        r->code ^ hash_mix(((uint64_t)h->instance << 32 | h->primitive) + hash_mix(place));
    uint64_t stream = sample_stream(w->streams[r->pixel], code, SAMPLE_ALPHA);
    return sample_point(stream, r->sample).x < alpha;
}

static void handle_hit(wave *w, path_ray *r, const hit *h) {
    absorb(w, r, (double)h->t);
    shade_point p;
    scene_shade_point(w->settings.scene, &r->ray, h, &p);
    if (r->has_differential)
        scene_set_footprint(w->settings.scene, &r->ray, &r->differential, h, &p);
    if (p.material->bends) scene_bend_normal(w->settings.scene, &p);
    bsdf b;
    material_evaluate(p.material, &p.at, &b);
    bool hidden = cross_interface(w, r, &p, &b, &w->beyond);
    if (b.alpha < 1 && w->settings.integrator->one_branch) {
        if (!is_there(w, r, h, b.alpha)) {
            emit_continued(w, r, h, (dvec3){1, 1, 1}, &r->media);
            return;
        }
    } else if (b.alpha < 1) {
        double pass = 1 - b.alpha;
        float coverage = r->coverage;
        r->coverage = (float)((double)coverage * pass);
        emit_continued(w, r, h, (dvec3){pass, pass, pass}, &r->media);
        if (b.alpha <= 0) return;
        r->coverage = (float)((double)coverage * b.alpha);
        r->weight = vec3_from(dvec3_scale(dvec3_from(r->weight), b.alpha));
    }
    if (hidden) {
        emit_continued(w, r, h, (dvec3){1, 1, 1}, &w->beyond);
        return;
    }
    if (r->primary && w->settings.transparent)
        film_block_add_alpha(w->film, r->pixel, (double)r->coverage);
    bool straight = w->settings.integrator->one_branch && b.alpha >= 1 && goes_straight_on(&b);
    if (straight) b.lobe_count = 0; /* it only shines */
    w->settings.integrator->hit(w, r, &p, &b);
    if (straight) {
        r->primary = false; /* the surface has covered the pixel, as one that refracts has */
        emit_continued(w, r, h, b.lobes[0].weight, &w->beyond);
    }
    /* It hides nothing from shadow rays, so not from these either: its light comes on top. */
    if (w->settings.scene->instances[h->instance].hidden_light)
        emit_continued(w, r, h, (dvec3){1, 1, 1}, &r->media);
}

static void handle_miss(wave *w, path_ray *r) {
    absorb(w, r, INFINITY);
    w->settings.integrator->miss(w, r);
}

/* Traces the newest `count` rays of the pool; what they emit takes their place. */
static void trace_wave(wave *w, size_t count) {
    path_ray *current = w->pool + (w->pool_count - count);
    for (size_t i = 0; i < count; i++) w->rays[i] = current[i].ray;
    accel_trace(w->settings.scene->accel, w->settings.isa, w->rays, w->hits, count,
                &w->stats.counters);
    w->next_count = 0;
    size_t work = 0; /* roughly, in lights looked at */
    for (size_t i = 0; i < count && !w->stopped; i++) {
        if (w->hits[i].instance == NO_ID)
            handle_miss(w, &current[i]);
        else
            handle_hit(w, &current[i], &w->hits[i]);
        work += 1 + w->settings.scene->light_count;
        if (work < WORK_BETWEEN_LOOKS) continue;
        look_up(w);
        work = 0;
    }
    test_shadows(w);
    w->pool_count -= count;
    if (!ARRAY_GROW(w->pool, w->pool_count, w->pool_capacity, w->next_count)) {
        w->out_of_memory = true;
        return;
    }
    if (w->next_count) memcpy(w->pool + w->pool_count, w->next, w->next_count * sizeof *w->next);
    w->pool_count += w->next_count;
}

/* ---- camera rays ---- */

/* Walks over the samples of a block: every pixel's first sample, then every pixel's second, ... */
typedef struct block_cursor {
    uint32_t x0, y0, x1, y1, x, y, pixel, sample;
} block_cursor;

static void advance(block_cursor *c) {
    c->pixel++;
    if (++c->x < c->x1) return;
    c->x = c->x0;
    if (++c->y < c->y1) return;
    c->y = c->y0;
    c->pixel = 0;
    c->sample++;
}

static sample2 camera_point(const wave *w, const block_cursor *c, sample_purpose purpose) {
    return sample_point(sample_stream(w->streams[c->pixel], PATH_CODE_CAMERA, purpose), c->sample);
}

static camera_sample sample_camera(const wave *w, const block_cursor *c) {
    const wave_settings *s = &w->settings;
    double x = 0, y = 0, moment = 0; /* from the pixel's centre; of the shutter's time */
    if (!s->pixel_center) {
        sample2 place = camera_point(w, c, SAMPLE_PIXEL);
        x = pixel_filter_offset(s->filter, place.x);
        y = pixel_filter_offset(s->filter, place.y);
    }
    if (s->shutter_close > s->shutter_open) moment = camera_point(w, c, SAMPLE_TIME).x;
    camera_sample at = {
        .x = c->x + (0.5 + x),
        .y = c->y + (0.5 + y),
        .time = (float)(s->shutter_open + (s->shutter_close - s->shutter_open) * moment)};
    if (s->frame.lens_radius > 0) at.lens = camera_point(w, c, SAMPLE_LENS);
    return at;
}

/* The next camera ray, into room that the pool has; none where the camera sees nothing. */
static void push_camera_ray(wave *w, const block_cursor *c) {
    const wave_settings *s = &w->settings;
    camera_sample at = sample_camera(w, c);
    vec3 o, d;
    if (!camera_ray(s->camera, &s->frame, &at, &o, &d)) return;
    path_ray *r = &w->pool[w->pool_count++];
    *r = (path_ray){.ray = ray_make(o, d, 0, INFINITY),
                    .weight = {1, 1, 1},
                    .pixel = c->pixel,
                    .sample = c->sample,
                    .code = PATH_CODE_CAMERA,
                    .media = s->camera_media,
                    .kind = RAY_CAMERA,
                    .primary = true,
                    .coverage = 1};
    r->ray.mask = ~(uint32_t)MASK_LIGHT_HIDDEN;
    if (s->scene->needs_footprint) differential_of_camera(s, &at, r);
    r->ray.time = at.time;
    w->stats.rays[RAY_CAMERA]++;
}

snell_status wave_render_block(wave *w, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1,
                               film_block *block,
                               bool (*go_on)(void *user, const wave_stats *stats), void *user) {
    block_cursor next = {x0, y0, x1, y1, x0, y0, 0, 0};
    for (block_cursor c = next; c.sample == 0; advance(&c))
        w->streams[c.pixel] = sample_pixel_stream(w->settings.seed, c.x, c.y);
    size_t size = w->settings.wave_size;
    film_block_clear(block);
    w->film = block;
    w->go_on = go_on;
    w->user = user;
    w->stopped = false;
    w->pool_count = w->shadow_count = 0;
    if (!ARRAY_GROW(w->pool, 0, w->pool_capacity, size)) return error_no_memory();
    while (next.sample < w->settings.samples || w->pool_count > 0) {
        /* Half-empty waves are topped up with new samples, so that the tail of a tree does not
         * starve the kernel. */
        for (size_t tried = 0; next.sample < w->settings.samples && w->pool_count < size &&
                               tried < size; /* a camera may have no ray for any of them */
             advance(&next), tried++)
            push_camera_ray(w, &next);
        size_t bite = w->pool_count > 2 * size ? SMALL_BITE : size;
        if (bite > size) bite = size;
        trace_wave(w, w->pool_count < bite ? w->pool_count : bite);
        if (w->out_of_memory) return error_no_memory();
        look_up(w);
        if (w->stopped) return SNELL_CANCELLED;
    }
    w->stats.film_overflows += block->overflows;
    return w->stats.blocked_by_cap ? SNELL_ERR_UNSUPPORTED : SNELL_OK;
}
