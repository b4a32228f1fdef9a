#include "render/explain.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "integrators/record.h"
#include "render/adaptive.h"
#include "scene/names.h"

enum { RAYS_MAX = 1 << 20 };

void explanation_destroy(explanation *e) {
    if (e == NULL) return;
    free(e->rays);
    free(e->lights);
    free(e->samples);
    free(e);
}

/* ---- names ---- */

static const snell_object_info nobody = {"", "", 0};

static snell_object_info info_of_shape(const scene *s, const description *d, uint32_t number) {
    return scene_name_part(s, d, scene_part(s, number)).info;
}

static snell_object_info info_of_light(const scene *s, const description *d,
                                       const recorded_light *l) {
    if (l->light == NO_ID) return nobody;
    return l->is_instance ? info_of_shape(s, d, l->light) : scene_name_light(s, d, l->light).info;
}

/* The id of the instance in the world that a shape is drawn by; {0} of the body of a light. */
static snell_instance_id id_of_shape(const scene *s, const description *d, uint32_t number) {
    shape_path path;
    scene_find_path(s, number, 0, &path);
    uint32_t id = s->instance_ids[path.levels[0] - s->instances];
    return id == NO_ID ? (snell_instance_id){0, 0}
                       : (snell_instance_id){id + 1, d->instances[id].generation};
}

static void name_ray(const scene *s, const description *d, recorded_ray *r) {
    r->said.shape = r->said.material = nobody;
    if (r->material == NO_ID) return;
    r->said.shape = info_of_shape(s, d, r->said.hit.number);
    r->said.hit.instance = id_of_shape(s, d, r->said.hit.number);
    r->said.material = scene_name_material(s, d, r->material).info;
}

/* ---- order and sums ---- */

typedef struct tree {
    uint32_t *size, *place, *free_place; /* of each ray as recorded */
    record_sum *sums;
} tree;

static void tree_free(tree *t) {
    free(t->size);
    free(t->place);
    free(t->free_place);
    free(t->sums);
}

static bool tree_make(size_t count, tree *t) {
    *t = (tree){
        memory_zeroed(count + 1, sizeof *t->size), memory_zeroed(count + 1, sizeof *t->place),
        memory_zeroed(count + 1, sizeof *t->free_place), memory_zeroed(count + 1, sizeof *t->sums)};
    return t->size && t->place && t->free_place && t->sums;
}

static bool is_root(const recorded_ray *r) { return r->said.parent == UINT32_MAX; }

static void add_sums(record_sum to, const record_sum from) {
    for (int c = 0; c < 4; c++) to[c] += from[c];
}

static void put_sums(double out[4], const record_sum sum) {
    for (int c = 0; c < 4; c++) out[c] = fixed_to(sum[c]);
}

/* Sizes and sums from the leaves to the roots: parents were recorded before their children. */
static void gather(const record *k, tree *t) {
    for (size_t i = 0; i < k->light_count; i++)
        record_add(t->sums[k->lights[i].said.ray], k->lights[i].said.contribution);
    for (size_t i = k->ray_count; i-- > 0;) {
        t->size[i]++;
        if (is_root(&k->rays[i])) continue;
        t->size[k->rays[i].said.parent] += t->size[i];
        add_sums(t->sums[k->rays[i].said.parent], t->sums[i]);
    }
}

/* Places from the roots to the leaves: a sample after the other, siblings as they were recorded. */
static void arrange(const record *k, tree *t, explanation *e) {
    for (size_t i = 0; i < k->ray_count; i++)
        if (is_root(&k->rays[i])) e->samples[k->rays[i].said.sample].ray_count = t->size[i];
    uint32_t next = 0;
    for (uint32_t i = 0; i < e->sample_count; i++) {
        e->samples[i].first_ray = next;
        next += e->samples[i].ray_count;
    }
    for (size_t i = 0; i < k->ray_count; i++) {
        const snell_explained_ray *r = &k->rays[i].said;
        if (is_root(&k->rays[i])) {
            t->place[i] = e->samples[r->sample].first_ray;
        } else {
            t->place[i] = t->free_place[r->parent];
            t->free_place[r->parent] += t->size[i];
        }
        t->free_place[i] = t->place[i] + 1;
    }
}

static void copy_rays(const record *k, const tree *t, explanation *e) {
    for (size_t i = 0; i < k->ray_count; i++) {
        snell_explained_ray *r = &e->rays[t->place[i]];
        *r = k->rays[i].said;
        if (r->parent != UINT32_MAX) r->parent = t->place[r->parent];
        r->ray_count = t->size[i];
        put_sums(r->radiance, t->sums[i]);
    }
}

static void copy_lights(const record *k, const tree *t, explanation *e) {
    for (size_t i = 0; i < k->light_count; i++)
        e->rays[t->place[k->lights[i].said.ray]].light_count++;
    uint32_t next = 0;
    for (size_t i = 0; i < e->ray_count; i++) {
        e->rays[i].first_light = next;
        next += e->rays[i].light_count;
        e->rays[i].light_count = 0;
    }
    for (size_t i = 0; i < k->light_count; i++) {
        uint32_t place = t->place[k->lights[i].said.ray];
        snell_explained_ray *of = &e->rays[place];
        snell_explained_light *l = &e->lights[of->first_light + of->light_count++];
        *l = k->lights[i].said;
        l->ray = place;
    }
}

static snell_status collect(record *k, const scene *s, const description *d, explanation *e) {
    e->ray_count = k->ray_count;
    e->light_count = k->light_count;
    e->rays = memory_zeroed(k->ray_count + 1, sizeof *e->rays);
    e->lights = memory_zeroed(k->light_count + 1, sizeof *e->lights);
    tree t;
    bool room = tree_make(k->ray_count, &t) && e->rays && e->lights;
    for (size_t i = 0; room && i < k->ray_count; i++) name_ray(s, d, &k->rays[i]);
    for (size_t i = 0; room && i < k->light_count; i++) {
        recorded_light *l = &k->lights[i];
        l->said.light = info_of_light(s, d, l);
        l->said.blocker = l->blocker == NO_ID ? nobody : info_of_shape(s, d, l->blocker);
    }
    if (room) {
        gather(k, &t);
        arrange(k, &t, e);
        copy_rays(k, &t, e);
        copy_lights(k, &t, e);
        for (uint32_t i = 0; i < e->sample_count; i++) put_sums(e->samples[i].radiance, k->sums[i]);
    }
    tree_free(&t);
    return room ? SNELL_OK : error_no_memory();
}

/* ---- the run ---- */

typedef struct run {
    const render_options *options;
    const record *record;
    uint32_t samples;
    double started, reported;
} run;

static bool go_on(void *user, const wave_stats *stats) {
    run *r = user;
    const render_options *o = r->options;
    if (r->record->full || r->record->no_memory) return false;
    double now = time_seconds(), done = (double)stats->rays[RAY_CAMERA] / r->samples;
    if (o->progress == NULL || now - r->reported < 1e-3 * PROGRESS_MS) return true;
    r->reported = now;
    snell_progress progress = {.struct_size = sizeof progress,
                               .phase = "render",
                               .fraction = done,
                               .seconds_left =
                                   done > 0.01 ? (now - r->started) * (1 - done) / done : -1,
                               .rays_traced = stats->rays[RAY_CAMERA],
                               .x1 = 1,
                               .y1 = 1};
    return o->progress(o->user, &progress);
}

/* The film's own pixel; and whether what was recorded adds up to it. */
static bool set_pixel(const record *k, const film_block *blocks, explanation *e) {
    film one = {.width = 1, .height = 1, .channels = e->channels, .pixels = e->pixel};
    record_sum recorded = {0, 0, 0, 0}, rendered = {0, 0, 0, 0};
    uint64_t overflows = 0;
    for (uint32_t i = 0; i < k->scrambles; i++) {
        film_add(rendered, blocks[i].sums[0], 4, &overflows);
        overflows += blocks[i].overflows;
    }
    film_set(&one, 0, 0, rendered, e->sample_count);
    for (uint32_t i = 0; i < e->sample_count; i++) add_sums(recorded, k->sums[i]);
    /* What is too bright the film does not add up. */
    return overflows > 0 || memcmp(recorded, rendered, sizeof recorded) == 0;
}

static snell_status run_pixel(const render_options *o, const snell_explain_desc *what,
                              uint32_t samples, record *k, film_block *blocks) {
    wave_settings settings = o->wave;
    settings.record = k;
    settings.wave_size = WAVE_SIZE_MAX;
    wave *w;
    snell_status status = wave_create(&settings, &w);
    if (status) return status;
    run r = {.options = o, .record = k, .samples = samples, .started = time_seconds()};
    r.reported = r.started;
    uint32_t x = o->crop_x + what->x, y = o->crop_y + what->y;
    for (uint32_t i = 0; !status && i < k->scrambles; i++) {
        const wave_samples part = {0, samples / k->scrambles, i, o->sharing};
        k->scramble = i;
        status = wave_render_block(w, x, y, x + 1, y + 1, &part, &blocks[i], go_on, &r);
    }
    bool spent = wave_get_stats(w)->spent_solids > 0;
    wave_destroy(w);
    if (k->no_memory) return error_no_memory();
    if (k->full)
        return error_set(SNELL_ERR_MEMORY, "keep the rays of one sample, or raise min_weight",
                         "there are more than %u rays behind this pixel", k->rays_max);
    return render_status(status, spent);
}

static void set_wanted(const snell_explain_desc *what, uint32_t samples, record *k) {
    k->rays_max = what->rays_max ? what->rays_max : RAYS_MAX;
    k->first_sample = what->sample_count ? what->first_sample : 0;
    k->end_sample = what->sample_count ? what->first_sample + what->sample_count : samples;
}

snell_status explain_pixel(const render_options *o, const description *d,
                           const snell_explain_desc *what, explanation **out) {
    uint32_t samples = what->samples ? what->samples : o->samples;
    record *k = NULL;
    snell_status status = record_create(samples, WAVE_SIZE_MAX, &k);
    if (status) return status;
    set_wanted(what, samples, k);
    if (o->noise > 0) k->scrambles = NOISE_SCRAMBLES;
    film_block *blocks = memory_aligned(k->scrambles * sizeof *blocks);
    explanation *e = memory_zeroed(1, sizeof *e);
    if (e) {
        e->sample_count = samples;
        e->channels = o->wave.transparent ? 4 : 3;
        e->samples = memory_zeroed(samples, sizeof *e->samples);
    }
    status = blocks && e && e->samples ? run_pixel(o, what, samples, k, blocks) : error_no_memory();
    if (!status && !set_pixel(k, blocks, e))
        status = error_set(SNELL_ERR_INTERNAL, NULL, "the rays do not add up to the pixel");
    if (!status) status = collect(k, o->wave.scene, d, e);
    memory_free_aligned(blocks);
    record_destroy(k);
    if (status) {
        explanation_destroy(e);
        return status;
    }
    *out = e;
    return SNELL_OK;
}
