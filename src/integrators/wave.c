/* The wave loop: rays wait in a pool; the newest of them are traced together. Contributions are
 * added in fixed point, so the order in which anything happens is free and never shows in the
 * picture. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/thread.h"
#include "integrators/aov.h"
#include "integrators/differential.h"
#include "integrators/record.h"
#include "integrators/wave.h"
#include "sampling/sampling.h"
/* Over twice a wave the pool is worked off in small bites, depth first. */
enum { SMALL_BITE = 64 };

/* A larger wave leaves the second-level cache, and keeps progress and cancelling waiting. */
enum { WAVE_DEFAULT = 2048, WORK_BETWEEN_LOOKS = 16384 };

snell_status wave_create(const wave_settings *settings, wave **out) {
    wave *w = memory_zeroed(1, sizeof *w);
    if (w == NULL) return error_no_memory();
    w->settings = *settings;
    if (w->settings.wave_size == 0) w->settings.wave_size = WAVE_DEFAULT;
    if (w->settings.wave_size > WAVE_SIZE_MAX) w->settings.wave_size = WAVE_SIZE_MAX;
    size_t size = w->settings.wave_size;
    w->rays = memory_resize(NULL, size, sizeof *w->rays);
    w->hits = memory_resize(NULL, size, sizeof *w->hits);
    w->blocked = memory_resize(NULL, size, sizeof *w->blocked);
    w->shadows = memory_resize(NULL, size, sizeof *w->shadows);
    w->shadow_rays = memory_resize(NULL, size, sizeof *w->shadow_rays);
    if (settings->aovs) w->light_ways = memory_resize(NULL, size, sizeof *w->light_ways);
    bool room = w->rays && w->hits && w->blocked && w->shadows && w->shadow_rays;
    if (!room || (settings->aovs && !w->light_ways)) {
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
    free(w->shadow_rays);
    free(w->next);
    free(w->rays);
    free(w->hits);
    free(w->blocked);
    free(w->light_ways);
    free(w);
}

const wave_stats *wave_get_stats(const wave *w) { return &w->stats; }

size_t wave_memory(const wave *w) {
    size_t each = sizeof *w->rays + sizeof *w->hits + sizeof *w->blocked + sizeof *w->shadows +
                  sizeof *w->shadow_rays;
    return sizeof *w + (w->pool_capacity + w->next_capacity) * sizeof *w->pool +
           w->settings.wave_size * each;
}

wave_phase wave_begin_phase(wave *w, wave_phase next) {
    wave_phase last = w->phase;
    if (!w->settings.timed) return last;
    double now = time_cpu_seconds();
    w->stats.seconds[last] += now - w->phase_began;
    w->phase_began = now;
    w->phase = next;
    return last;
}

void wave_collect(wave *w, aov_block *to) { w->aovs = to; }
const scene *wave_scene(const wave *w) { return w->settings.scene; }
uint32_t wave_max_depth(const wave *w) { return w->settings.max_depth; }
dvec3 wave_eye(const wave *w) { return dvec3_from(w->settings.frame.position); }
const media *wave_beyond(const wave *w) { return &w->beyond; }

void wave_ask(wave *w, uint32_t number, double chance) {
    w->asked = number;
    w->asked_chance = chance;
}

sample2 wave_draw(const wave *w, const path_ray *r, sample_purpose purpose) {
    return sample_point(sample_stream(w->streams[r->pixel], r->code, purpose), r->sample);
}

sample2 wave_draw_child(const wave *w, const path_ray *r, uint32_t slot, sample_purpose purpose) {
    uint64_t code = path_code_child(r->code, slot);
    return sample_point(sample_stream(w->streams[r->pixel], code, purpose), r->sample);
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
    if (w->settings.record) record_absorbed(w, r, through);
}

/* A ray of one colour has the indices of that. */
static void set_color_iors(const path_ray *r, const medium *before, const medium *after, bsdf *b) {
    if (!medium_disperses(before) && !medium_disperses(after)) return;
    b->ior1_by_color = before->ior_by_color;
    b->ior2_by_color = after->ior_by_color;
    b->disperses = r->color == 0;
    if (!b->disperses) bsdf_take_color(b, r->color - 1);
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
    set_color_iors(r, before, after, b);
    return before == after;
}

/* Colours part: a path goes on with one of them, which stands for all three. */
static void draw_color(const wave *w, path_ray *r, bsdf *b) {
    int color = (int)(3 * wave_draw(w, r, SAMPLE_COLOR).x);
    dvec3 kept = dvec3_scale(color_alone(color), 3);
    r->weight = vec3_from(dvec3_mul(dvec3_from(r->weight), kept));
    r->color = (uint8_t)(1 + color);
    bsdf_take_color(b, color);
    if (w->settings.record) record_color(w, r, kept);
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
    if (p.material->bends || p.material->grained) scene_bend_normal(w->settings.scene, &p);
    bsdf b;
    material_evaluate(p.material, &p.at, &b);
    bool hidden = cross_interface(w, r, &p, &b, &w->beyond);
    if (b.alpha < 1 && w->settings.integrator->one_branch) {
        if (!is_there(w, r, h, b.alpha)) {
            if (w->settings.record) record_hit(w, r, h, &p, &b, SNELL_RAY_PASSED);
            if (material_casts_full_shadow(p.material)) r->drawn_pdf = 0;
            emit_continued(w, r, h, (dvec3){1, 1, 1}, &r->media);
            return;
        }
    } else if (b.alpha < 1) {
        double pass = 1 - b.alpha;
        float coverage = r->coverage;
        r->coverage = (float)((double)coverage * pass);
        if (w->settings.record) record_hit(w, r, h, &p, &b, SNELL_RAY_PASSED);
        emit_continued(w, r, h, (dvec3){pass, pass, pass}, &r->media);
        if (b.alpha <= 0) return;
        r->coverage = (float)((double)coverage * b.alpha);
        r->weight = vec3_from(dvec3_scale(dvec3_from(r->weight), b.alpha));
    }
    if (b.disperses && !hidden && w->settings.integrator->one_branch) draw_color(w, r, &b);
    if (w->settings.record) record_hit(w, r, h, &p, &b, hidden ? SNELL_RAY_PASSED : SNELL_RAY_HIT);
    if (hidden) {
        emit_continued(w, r, h, (dvec3){1, 1, 1}, &w->beyond);
        return;
    }
    if (r->primary && w->settings.transparent) wave_add_coverage(w, r, (double)r->coverage);
    if (w->aovs && r->primary) aov_hit(w, r, h, &p, &b);
    bool straight = w->settings.integrator->one_branch && b.alpha >= 1 && wave_goes_straight_on(&b);
    if (straight) b.lobe_count = 0; /* it only shines */
    w->at = h;
    w->has_origin[0] = w->has_origin[1] = false;
    w->settings.integrator->hit(w, r, &p, &b);
    if (straight) {
        r->primary = false; /* the surface has covered the pixel, as one that refracts has */
        if (r->route == RAY_CAMERA) r->route = RAY_REFRACTED;
        if (material_casts_full_shadow(p.material)) r->drawn_pdf = 0;
        emit_continued(w, r, h, b.lobes[0].weight, &w->beyond);
    }
    /* It hides nothing from shadow rays, so not from these either: its light comes on top. */
    if (scene_part(w->settings.scene, h->instance)->hidden_light)
        emit_continued(w, r, h, (dvec3){1, 1, 1}, &r->media);
}

static void handle_miss(wave *w, path_ray *r) {
    absorb(w, r, INFINITY);
    if (w->settings.record) record_miss(w, r);
    w->settings.integrator->miss(w, r);
}

/* Traces the newest `count` rays of the pool; what they emit takes their place. */
static void trace_wave(wave *w, size_t count) {
    path_ray *current = w->pool + (w->pool_count - count);
    wave_begin_phase(w, WAVE_TRACE);
    for (size_t i = 0; i < count; i++) w->rays[i] = current[i].ray;
    accel_trace(w->settings.scene->accel, w->settings.isa, w->rays, w->hits, count,
                &w->stats.counters);
    wave_begin_phase(w, WAVE_SHADE);
    if (w->aovs) aov_traced(w, current, count);
    w->next_count = 0;
    /* `path` asks one light at a time. */
    size_t lights = w->settings.integrator->one_branch ? 1 : scene_light_count(w->settings.scene);
    size_t work = 0; /* roughly, in lights looked at */
    for (size_t i = 0; i < count && !w->stopped; i++) {
        if (w->hits[i].instance == NO_ID)
            handle_miss(w, &current[i]);
        else
            handle_hit(w, &current[i], &w->hits[i]);
        work += 1 + lights;
        if (work < WORK_BETWEEN_LOOKS) continue;
        wave_look_up(w);
        work = 0;
    }
    wave_test_shadows(w);
    w->pool_count -= count;
    if (w->pool_count == 0) { /* mostly: nothing to copy */
        path_ray *pool = w->pool;
        size_t capacity = w->pool_capacity;
        w->pool = w->next;
        w->pool_count = w->next_count;
        w->pool_capacity = w->next_capacity;
        w->next = pool;
        w->next_capacity = capacity;
        return;
    }
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
    r->ray = ray_make(o, d, 0, INFINITY);
    r->ray.mask = ~(uint32_t)MASK_LIGHT_HIDDEN;
    r->ray.time = at.time;
    r->weight = (vec3){1, 1, 1};
    r->pixel = c->pixel;
    r->sample = c->sample;
    r->code = PATH_CODE_CAMERA;
    r->media = s->camera_media;
    r->depth = 0;
    r->kind = r->route = RAY_CAMERA;
    r->color = 0;
    r->primary = true;
    r->coverage = 1;
    r->drawn_pdf = 0;
    r->has_differential = false;
    if (s->scene->needs_footprint) differential_of_camera(s, w->sharing, &at, r);
    w->stats.rays[RAY_CAMERA]++;
    if (s->record) record_camera_ray(w, r);
}

snell_status wave_render_block(wave *w, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1,
                               const wave_samples *samples, film_block *block,
                               bool (*go_on)(void *user, const wave_stats *stats), void *user) {
    block_cursor next = {x0, y0, x1, y1, x0, y0, 0, samples->first};
    for (block_cursor c = next; c.sample == samples->first; advance(&c))
        w->streams[c.pixel] =
            sample_scramble(sample_pixel_stream(w->settings.seed, c.x, c.y), samples->scramble);
    size_t size = w->settings.wave_size;
    solid_take_spent();
    film_block_clear(block);
    w->film = block;
    w->scramble = samples->scramble;
    w->sharing = samples->sharing;
    w->go_on = go_on;
    w->user = user;
    w->stopped = false;
    w->pool_count = w->shadow_count = 0;
    w->phase = WAVE_CAMERA;
    if (w->settings.timed) w->phase_began = time_cpu_seconds();
    while (next.sample < samples->end || w->pool_count > 0) {
        if (!ARRAY_GROW(w->pool, w->pool_count, w->pool_capacity, size)) return error_no_memory();
        /* Half-empty waves are topped up with new samples, so that the tail of a tree does not
         * starve the kernel. */
        for (size_t tried = 0; next.sample < samples->end && w->pool_count < size &&
                               tried < size; /* a camera may have no ray for any of them */
             advance(&next), tried++)
            push_camera_ray(w, &next);
        size_t bite = w->pool_count > 2 * size ? SMALL_BITE : size;
        if (bite > size) bite = size;
        trace_wave(w, w->pool_count < bite ? w->pool_count : bite);
        wave_begin_phase(w, WAVE_CAMERA);
        if (w->out_of_memory) return error_no_memory();
        wave_look_up(w);
        if (w->stopped) return SNELL_CANCELLED;
    }
    w->stats.film_overflows += block->overflows;
    return w->stats.blocked_by_cap || w->stats.spent_solids ? SNELL_ERR_UNSUPPORTED : SNELL_OK;
}
