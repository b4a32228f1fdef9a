#include "render/render.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/memory.h"
#include "integrators/aov.h"

typedef struct job job;

/* One worker's own things; they are made when the worker takes its first block. */
typedef struct render_worker {
    job *job;
    wave *wave;
    film_block *block;
    aov_block *aovs; /* NULL: none are wanted */
    uint64_t rays_reported;
} render_worker;

/*  workers ──▶ next block (the pool's counter) ──▶ own wave and block sums ──▶ own pixels of the film
 *     │
 *     └─ now and then: progress, under `lock`, by whoever comes first after 50 ms; the others go on */
struct job {
    const render_options *options;
    film *film;
    uint32_t first_block_x, first_block_y, blocks_x, blocks_y;
    render_worker *workers;
    double started;
    _Atomic uint64_t pixels_done, rays;
    _Atomic int stop; /* snell_status of the first failure */
    pthread_mutex_t lock;
    double last_report;
};

static uint64_t count_rays(const wave_stats *stats) {
    uint64_t sum = stats->shadow_rays;
    for (int i = 0; i < RAY_KIND_COUNT; i++) sum += stats->rays[i];
    return sum;
}

static void stop_all(job *j, snell_status status) {
    int none = SNELL_OK;
    atomic_compare_exchange_strong(&j->stop, &none, (int)status);
}

static void report(job *j, bool last) {
    const render_options *o = j->options;
    if (o->progress == NULL || pthread_mutex_trylock(&j->lock) != 0) return;
    double now = time_seconds();
    if (last || now - j->last_report >= 1e-3 * PROGRESS_MS) {
        j->last_report = now;
        double done =
            (double)atomic_load(&j->pixels_done) / ((double)o->crop_width * o->crop_height);
        snell_progress progress = {.struct_size = sizeof progress,
                                   .phase = "render",
                                   .fraction = done,
                                   .seconds_left =
                                       done > 0.01 ? (now - j->started) * (1 - done) / done : -1,
                                   .rays_traced = atomic_load(&j->rays),
                                   .x1 = o->crop_width,
                                   .y1 = o->crop_height};
        if (!o->progress(o->user, &progress)) stop_all(j, SNELL_CANCELLED);
    }
    pthread_mutex_unlock(&j->lock);
}

static bool go_on(void *user, const wave_stats *stats) {
    render_worker *w = user;
    uint64_t rays = count_rays(stats);
    atomic_fetch_add_explicit(&w->job->rays, rays - w->rays_reported, memory_order_relaxed);
    w->rays_reported = rays;
    report(w->job, false);
    return atomic_load_explicit(&w->job->stop, memory_order_relaxed) == SNELL_OK;
}

static snell_status prepare_worker(render_worker *w) {
    if (w->wave) return SNELL_OK;
    w->block = memory_aligned(sizeof *w->block);
    if (w->block == NULL) return error_no_memory();
    const wave_settings *settings = &w->job->options->wave;
    snell_status status = wave_create(settings, &w->wave);
    if (status || settings->aovs == NULL) return status;
    status = aov_block_create(settings->aovs, &w->aovs);
    wave_collect(w->wave, w->aovs);
    return status;
}

static uint32_t least(uint32_t a, uint32_t b) { return a < b ? a : b; }
static uint32_t most(uint32_t a, uint32_t b) { return a > b ? a : b; }

static void render_block(void *data, size_t index, uint32_t worker) {
    job *j = data;
    if (atomic_load_explicit(&j->stop, memory_order_relaxed) != SNELL_OK) return;
    const render_options *o = j->options;
    render_worker *w = &j->workers[worker];
    uint32_t bx = j->first_block_x + (uint32_t)(index % j->blocks_x),
             by = j->first_block_y + (uint32_t)(index / j->blocks_x);
    uint32_t x0 = most(bx * FILM_BLOCK, o->crop_x),
             x1 = least((bx + 1) * FILM_BLOCK, o->crop_x + o->crop_width);
    uint32_t y0 = most(by * FILM_BLOCK, o->crop_y),
             y1 = least((by + 1) * FILM_BLOCK, o->crop_y + o->crop_height);
    snell_status status = prepare_worker(w);
    if (!status && w->aovs) aov_block_clear(w->aovs);
    if (!status) status = wave_render_block(w->wave, x0, y0, x1, y1, w->block, go_on, w);
    if (status) {
        stop_all(j, status);
        return;
    }
    for (uint32_t y = y0; y < y1; y++)
        for (uint32_t x = x0; x < x1; x++) {
            uint32_t pixel = (y - y0) * (x1 - x0) + (x - x0), left = x - o->crop_x,
                     top = y - o->crop_y;
            film_set(j->film, left, top, w->block, pixel, o->wave.samples);
            if (w->aovs) aov_block_set(w->aovs, pixel, o->wave.samples, j->film, left, top);
        }
    atomic_fetch_add(&j->pixels_done, (uint64_t)(x1 - x0) * (y1 - y0));
}

static void add_stats(snell_render_stats *out, const wave_stats *in, fixed128 *dropped) {
    out->rays_camera += in->rays[RAY_CAMERA];
    out->rays_reflected += in->rays[RAY_REFLECTED];
    out->rays_refracted += in->rays[RAY_REFRACTED];
    out->rays_continued += in->rays[RAY_CONTINUED];
    out->rays_shadow += in->shadow_rays;
    const trace_counters *nearest = &in->counters, *shadow = &in->shadow_counters;
    out->nodes += nearest->nodes + shadow->nodes;
    out->boxes += nearest->boxes + shadow->boxes;
    out->triangles += nearest->triangles + shadow->triangles;
    out->primitives += nearest->primitives + shadow->primitives;
    out->shadow_nodes += shadow->nodes;
    out->shadow_boxes += shadow->boxes;
    out->shadow_triangles += shadow->triangles;
    out->shadow_primitives += shadow->primitives;
    out->seconds_camera += in->seconds[WAVE_CAMERA];
    out->seconds_trace += in->seconds[WAVE_TRACE];
    out->seconds_shade += in->seconds[WAVE_SHADE];
    out->seconds_shadows += in->seconds[WAVE_SHADOWS];
    out->media_mismatches += in->media_mismatches;
    out->film_overflows += in->film_overflows;
    *dropped += in->dropped_weight;
}

/* *spent: did a ray meet more of a solid than it can hold? */
static void collect(job *j, uint32_t worker_count, snell_render_stats *out, bool *spent) {
    const render_options *o = j->options;
    *out = (snell_render_stats){.struct_size = sizeof *out};
    fixed128 dropped = 0;
    for (uint32_t i = 0; i < worker_count; i++) {
        if (j->workers[i].wave) {
            const wave_stats *stats = wave_get_stats(j->workers[i].wave);
            add_stats(out, stats, &dropped);
            out->memory_rays += wave_memory(j->workers[i].wave) + sizeof *j->workers[i].block;
            *spent |= stats->spent_solids > 0;
        }
        wave_destroy(j->workers[i].wave);
        memory_free_aligned(j->workers[i].block);
        aov_block_destroy(j->workers[i].aovs);
    }
    out->samples_done = o->wave.samples;
    out->memory_film =
        (uint64_t)j->film->width * j->film->height * j->film->channels * sizeof *j->film->pixels;
    out->pixels_done = atomic_load(&j->pixels_done);
    if (out->pixels_done)
        out->dropped_weight =
            fixed_to(dropped) / ((double)out->pixels_done * (double)o->wave.samples);
    out->seconds = time_seconds() - j->started;
}

snell_status render_status(snell_status status, bool spent) {
    if (status == SNELL_CANCELLED)
        return error_set(SNELL_CANCELLED, NULL, "the render was cancelled");
    if (status == SNELL_ERR_UNSUPPORTED && spent) return solid_error_spent();
    if (status == SNELL_ERR_UNSUPPORTED)
        return error_set(status, "make some of them opaque to shadows, or fewer",
                         "a shadow ray meets too many surfaces that let light through");
    return status ? error_no_memory() : SNELL_OK;
}

snell_status render_film(const render_options *o, thread_pool *pool, film *out,
                         snell_render_stats *stats) {
    snell_status status =
        film_resize(out, o->crop_width, o->crop_height, o->wave.transparent ? 4 : 3);
    if (!status && o->wave.aovs) status = aov_plan_add_layers(o->wave.aovs, out);
    if (status) return status;
    uint32_t last_x = (o->crop_x + o->crop_width - 1) / FILM_BLOCK,
             last_y = (o->crop_y + o->crop_height - 1) / FILM_BLOCK;
    job j = {.options = o,
             .film = out,
             .first_block_x = o->crop_x / FILM_BLOCK,
             .first_block_y = o->crop_y / FILM_BLOCK,
             .workers = memory_zeroed(thread_pool_size(pool), sizeof *j.workers),
             .started = time_seconds()};
    if (j.workers == NULL) return error_no_memory();
    j.blocks_x = last_x - j.first_block_x + 1;
    j.blocks_y = last_y - j.first_block_y + 1;
    j.last_report = j.started;
    for (uint32_t i = 0; i < thread_pool_size(pool); i++) j.workers[i].job = &j;
    pthread_mutex_init(&j.lock, NULL);
    thread_pool_run(pool, (size_t)j.blocks_x * j.blocks_y, render_block, &j);
    status = (snell_status)atomic_load(&j.stop);
    if (!status) report(&j, true);
    pthread_mutex_destroy(&j.lock);
    bool spent = false;
    collect(&j, thread_pool_size(pool), stats, &spent);
    free(j.workers);
    return render_status(status, spent);
}
