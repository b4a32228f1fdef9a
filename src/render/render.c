#include "render/render.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/memory.h"
#include "integrators/aov.h"
#include "render/adaptive.h"

typedef struct job job;

/* One worker's own things; they are made when the worker takes its first block. */
typedef struct render_worker {
    job *job;
    wave *wave;
    film_block *blocks; /* of each scramble */
    aov_block *aovs;    /* NULL: none are wanted, or each block has its own */
    uint64_t rays_reported;
} render_worker;

/*  workers ──▶ next block (the pool's counter) ──▶ own wave and block sums ──▶ own pixels of the film
 *     │                                                                   (in rounds: by way of its sums)
 *     └─ now and then: progress, under `lock`, by whoever comes first after 50 ms; the others go on */
struct job {
    const render_options *options;
    film *film;
    uint32_t first_block_x, first_block_y, blocks_x, blocks_y;
    render_worker *workers;
    /* Of a render in rounds; else there are no sums, and one round is all. */
    adaptive plan;
    film_sums sums;
    aov_block **aovs; /* of each block, made in its first round; NULL: none are wanted */
    bool in_rounds;
    uint32_t from, to; /* samples per pixel before and after the round */
    uint32_t sharing;
    _Atomic uint64_t round_overflows; /* of sums */
    double started;
    _Atomic uint64_t pixels_done, rays;
    _Atomic uint64_t work;         /* samples of a pixel, times pixels */
    double work_before, work_left; /* the same, when the round began: roughly */
    _Atomic int stop;              /* snell_status of the first failure */
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

/* Of a render in rounds what is left is guessed, but never more than there is time for. */
static snell_progress progress_now(const job *j, double now) {
    const render_options *o = j->options;
    double passed = now - j->started, work = (double)atomic_load(&j->work);
    double done = work / (j->work_before + j->work_left);
    if (o->time_limit > 0 && done < passed / o->time_limit) done = passed / o->time_limit;
    if (done > 1) done = 1;
    return (snell_progress){.struct_size = sizeof(snell_progress),
                            .phase = "render",
                            .fraction = done,
                            .seconds_left = done > 0.01 ? passed * (1 - done) / done : -1,
                            .rays_traced = atomic_load(&j->rays),
                            .x1 = o->crop_width,
                            .y1 = o->crop_height,
                            .noise = j->plan.bound_max};
}

static void report(job *j, bool last) {
    const render_options *o = j->options;
    if (o->progress == NULL || pthread_mutex_trylock(&j->lock) != 0) return;
    double now = time_seconds();
    if (last || now - j->last_report >= 1e-3 * PROGRESS_MS) {
        j->last_report = now;
        snell_progress progress = progress_now(j, now);
        if (last) progress.fraction = 1;
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
    w->blocks = memory_aligned(w->job->plan.scrambles * sizeof *w->blocks);
    if (w->blocks == NULL) return error_no_memory();
    const wave_settings *settings = &w->job->options->wave;
    snell_status status = wave_create(settings, &w->wave);
    if (status || settings->aovs == NULL || w->job->in_rounds) return status;
    return aov_block_create(settings->aovs, &w->aovs);
}

static uint32_t least(uint32_t a, uint32_t b) { return a < b ? a : b; }
static uint32_t most(uint32_t a, uint32_t b) { return a > b ? a : b; }

typedef struct block_place {
    uint32_t x0, y0, x1, y1; /* of the whole picture */
} block_place;

static block_place place_of(const job *j, size_t block) {
    const render_options *o = j->options;
    uint32_t bx = j->first_block_x + (uint32_t)(block % j->blocks_x),
             by = j->first_block_y + (uint32_t)(block / j->blocks_x);
    return (block_place){most(bx * FILM_BLOCK, o->crop_x), most(by * FILM_BLOCK, o->crop_y),
                         least((bx + 1) * FILM_BLOCK, o->crop_x + o->crop_width),
                         least((by + 1) * FILM_BLOCK, o->crop_y + o->crop_height)};
}

/* Where the block's layers are added up, which goes on from round to round; NULL: nowhere. */
static aov_block *aovs_of(const job *j, const render_worker *w, size_t block) {
    return j->aovs ? j->aovs[block] : w->aovs;
}

static snell_status prepare_aovs(job *j, const render_worker *w, size_t block) {
    if (j->aovs && j->aovs[block] == NULL)
        return aov_block_create(j->options->wave.aovs, &j->aovs[block]);
    aov_block *aovs = aovs_of(j, w, block);
    if (aovs && j->from == 0) aov_block_clear(aovs);
    return SNELL_OK;
}

/* The round's samples, scramble by scramble, into the worker's own blocks. */
static snell_status render_samples(job *j, render_worker *w, size_t block, block_place at) {
    snell_status status = prepare_worker(w);
    uint32_t scrambles = j->plan.scrambles;
    if (!status) status = prepare_aovs(j, w, block);
    if (!status) wave_collect(w->wave, aovs_of(j, w, block));
    for (uint32_t i = 0; !status && i < scrambles; i++) {
        const wave_samples samples = {j->from / scrambles, j->to / scrambles, i, j->sharing};
        status = wave_render_block(w->wave, at.x0, at.y0, at.x1, at.y1, &samples, &w->blocks[i],
                                   go_on, w);
    }
    return status;
}

/* Only a whole round is added, so that the scrambles have the same number of samples. */
static void add_round(job *j, const render_worker *w, size_t block, block_place at) {
    const render_options *o = j->options;
    adaptive_block *b = &j->plan.blocks[block];
    const aov_block *aovs = aovs_of(j, w, block);
    uint64_t overflows = 0;
    uint32_t pixel = 0;
    b->sums = (noise_sums){.pixels = 0};
    b->samples = j->to;
    for (uint32_t y = at.y0 - o->crop_y; y < at.y1 - o->crop_y; y++)
        for (uint32_t x = at.x0 - o->crop_x; x < at.x1 - o->crop_x; x++, pixel++) {
            double rgb, variance;
            for (uint32_t i = 0; i < j->plan.scrambles; i++)
                film_sums_add(&j->sums, i, x, y, w->blocks[i].sums[pixel], &overflows);
            film_set_from(j->film, x, y, &j->sums, j->to, &rgb, &variance);
            noise_add(&b->sums, rgb, variance);
            if (aovs) aov_block_set(aovs, pixel, j->to, j->film, x, y);
        }
    atomic_fetch_add(&j->round_overflows, overflows);
}

static void set_block(job *j, const render_worker *w, block_place at) {
    const render_options *o = j->options;
    uint32_t pixel = 0;
    for (uint32_t y = at.y0 - o->crop_y; y < at.y1 - o->crop_y; y++)
        for (uint32_t x = at.x0 - o->crop_x; x < at.x1 - o->crop_x; x++, pixel++) {
            film_set(j->film, x, y, w->blocks[0].sums[pixel], o->samples);
            if (w->aovs) aov_block_set(w->aovs, pixel, o->samples, j->film, x, y);
        }
}

static void render_block(void *data, size_t index, uint32_t worker) {
    job *j = data;
    if (atomic_load_explicit(&j->stop, memory_order_relaxed) != SNELL_OK) return;
    render_worker *w = &j->workers[worker];
    size_t block = j->in_rounds ? j->plan.active[index] : index;
    block_place at = place_of(j, block);
    snell_status status = render_samples(j, w, block, at);
    if (status) {
        stop_all(j, status);
        return;
    }
    if (j->in_rounds)
        add_round(j, w, block, at);
    else
        set_block(j, w, at);
    uint64_t pixels = (uint64_t)(at.x1 - at.x0) * (at.y1 - at.y0);
    if (j->from == 0) atomic_fetch_add(&j->pixels_done, pixels);
    atomic_fetch_add(&j->work, pixels * (j->to - j->from));
}

/* ---- rounds ---- */

static void run_round(job *j, thread_pool *pool, uint32_t to, size_t block_count) {
    j->to = to;
    j->work_before = (double)atomic_load(&j->work);
    thread_pool_run(pool, block_count, render_block, j);
    j->from = to;
}

/* The footprint of a sample depends on how many there are: a first round says how many there can be. */
static void start_over(job *j) {
    uint32_t samples = adaptive_start_over(&j->plan, time_seconds());
    if (samples == 0) return;
    film_sums_clear(&j->sums);
    j->sharing = samples;
    j->from = 0;
    atomic_store(&j->pixels_done, 0);
    atomic_store(&j->work, 0);
    atomic_store(&j->round_overflows, 0);
}

static bool stopped(const job *j) { return atomic_load(&j->stop) != SNELL_OK; }

static void run_rounds(job *j, thread_pool *pool) {
    adaptive *a = &j->plan;
    double now = time_seconds();
    bool unknown = !(a->noise > 0) && j->options->wave.scene->needs_footprint;
    if (unknown) j->sharing = adaptive_next(a, now);
    for (uint32_t to; !stopped(j) && (to = adaptive_next(a, now)) > 0;) {
        double begun = now;
        run_round(j, pool, to, a->active_count);
        now = time_seconds();
        if (stopped(j)) break;
        adaptive_decide(a, to, now - begun);
        if (unknown) start_over(j);
        unknown = false;
        j->work_left = adaptive_work_left(a) * FILM_BLOCK * FILM_BLOCK;
    }
}

static snell_status prepare_rounds(job *j) {
    const render_options *o = j->options;
    adaptive *a = &j->plan;
    j->in_rounds = o->noise > 0 || o->time_limit > 0;
    a->scrambles = o->noise > 0 ? NOISE_SCRAMBLES : 1;
    if (!j->in_rounds) return SNELL_OK;
    a->noise = o->noise;
    a->time_limit = o->time_limit;
    a->samples_max = o->samples / a->scrambles * a->scrambles;
    a->started = j->started;
    if (!adaptive_begin(a, (size_t)j->blocks_x * j->blocks_y)) return error_no_memory();
    snell_status status =
        film_sums_create(o->crop_width, o->crop_height, j->film->channels, a->scrambles, &j->sums);
    if (!status && o->noise > 0) status = film_keep_variance(j->film);
    if (status || o->wave.aovs == NULL) return status;
    j->aovs = memory_zeroed(a->block_count, sizeof(aov_block *));
    return j->aovs ? SNELL_OK : error_no_memory();
}

/* ---- statistics ---- */

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

/* Of a picture whose blocks have different numbers. */
static void count_samples(const job *j, snell_render_stats *out) {
    const adaptive *a = &j->plan;
    double samples = 0, pixels = 0;
    out->samples_min = out->samples_done = j->options->samples;
    out->samples_mean = j->options->samples;
    if (!j->in_rounds) return;
    out->samples_min = UINT64_MAX;
    out->samples_done = 0;
    for (size_t i = 0; i < a->block_count; i++) {
        const adaptive_block *b = &a->blocks[i];
        samples += (double)b->samples * b->sums.pixels;
        pixels += b->sums.pixels;
        out->samples_min = b->samples < out->samples_min ? b->samples : out->samples_min;
        out->samples_done = b->samples > out->samples_done ? b->samples : out->samples_done;
    }
    out->samples_mean = pixels > 0 ? samples / pixels : 0;
    if (!(a->noise > 0)) return;
    out->noise_bound = a->bound_max;
    out->noise_confidence = NOISE_CONFIDENCE;
    out->noise_blocks = a->block_count;
    out->noise_blocks_done = a->under;
}

/* *spent: did a ray meet more of a solid than it can hold? */
static void collect(job *j, uint32_t worker_count, snell_render_stats *out, bool *spent) {
    *out = (snell_render_stats){.struct_size = sizeof *out};
    fixed128 dropped = 0;
    for (uint32_t i = 0; i < worker_count; i++) {
        if (j->workers[i].wave) {
            const wave_stats *stats = wave_get_stats(j->workers[i].wave);
            add_stats(out, stats, &dropped);
            out->memory_rays +=
                wave_memory(j->workers[i].wave) + j->plan.scrambles * sizeof *j->workers[i].blocks;
            *spent |= stats->spent_solids > 0;
        }
        wave_destroy(j->workers[i].wave);
        memory_free_aligned(j->workers[i].blocks);
        aov_block_destroy(j->workers[i].aovs);
    }
    out->film_overflows += atomic_load(&j->round_overflows);
    const film *f = j->film;
    out->memory_film = (uint64_t)f->width * f->height * f->channels * sizeof *f->pixels +
                       j->sums.count * sizeof *j->sums.sums;
    out->pixels_done = atomic_load(&j->pixels_done);
    count_samples(j, out);
    if (atomic_load(&j->work))
        out->dropped_weight = fixed_to(dropped) / (double)atomic_load(&j->work);
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
    j.work_left = (double)o->crop_width * o->crop_height * o->samples;
    j.sharing = o->sharing;
    snell_status prepared = prepare_rounds(&j);
    for (uint32_t i = 0; i < thread_pool_size(pool); i++) j.workers[i].job = &j;
    pthread_mutex_init(&j.lock, NULL);
    if (!prepared) {
        if (j.in_rounds)
            run_rounds(&j, pool);
        else
            run_round(&j, pool, o->samples, (size_t)j.blocks_x * j.blocks_y);
        status = (snell_status)atomic_load(&j.stop);
    }
    if (!prepared && !status) report(&j, true);
    pthread_mutex_destroy(&j.lock);
    bool spent = false;
    collect(&j, thread_pool_size(pool), stats, &spent);
    free(j.workers);
    for (size_t i = 0; j.aovs && i < j.plan.block_count; i++) aov_block_destroy(j.aovs[i]);
    free(j.aovs);
    adaptive_free(&j.plan);
    film_sums_free(&j.sums);
    return prepared ? prepared : render_status(status, spent);
}
