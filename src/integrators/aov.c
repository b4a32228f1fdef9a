#include "integrators/aov.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "integrators/wave.h"
#include "scene/names.h"

enum { PIXELS = FILM_BLOCK * FILM_BLOCK, LABEL_MAX = 160, MATTES = 2, NUMBERS = 3 };

/* What does not come from a light of the scene. */
typedef enum light_place { PLACE_BACKGROUND, PLACE_AMBIENT, PLACE_OTHER, PLACE_COUNT } light_place;

struct aov_plan {
    aov_set wanted;
    const wave_settings *settings;
    /* Sums: of every sample, so many channels a pixel; where those of an AOV begin. */
    uint32_t channel_count, first[AOV_COUNT];
    /* Layers of light. */
    char (*light_names)[LABEL_MAX];
    uint32_t light_count;
    uint32_t *registry, *surfaces; /* layers of s->lights and of s->surface_lights */
    uint32_t places[PLACE_COUNT];
    uint32_t joined;        /* lights without a layer of their own, .. */
    char joined_names[240]; /* .. and the first of their names */
    /* Cryptomatte's ids, by part of the scene and by material; and what they stand for. */
    uint32_t *ids[MATTES];
    char *manifests[MATTES];
};

static bool wants(const aov_plan *p, aov_id id) { return aov_has(p->wanted, id); }

/* ---- lights ---- */

/* One more light that has only light.other. Names end with " .." where they are not all. */
static void join(aov_plan *p, const char *label) {
    size_t used = strlen(p->joined_names), room = sizeof p->joined_names - used,
           length = strlen(label);
    p->joined++;
    if (used > 2 && strcmp(p->joined_names + used - 3, " ..") == 0) return;
    if (length + sizeof ", .." > room - 3)
        snprintf(p->joined_names + used, room, " ..");
    else
        snprintf(p->joined_names + used, room, "%s%s", used > 0 ? ", " : "", label);
}

/* The layer of this name; made if there is room. */
static uint32_t light_layer(aov_plan *p, const char *label) {
    char name[LABEL_MAX];
    snprintf(name, sizeof name, "light.%s", label);
    for (uint32_t i = 0; i < p->light_count; i++)
        if (strcmp(p->light_names[i], name) == 0) return i;
    if (p->light_count >= LIGHT_LAYERS_MAX && strcmp(label, "other") != 0) {
        join(p, label);
        return light_layer(p, "other");
    }
    memcpy(p->light_names[p->light_count], name, sizeof name);
    return p->light_count++;
}

static uint32_t layer_of(aov_plan *p, scene_name name) {
    char label[LABEL_MAX - 8];
    scene_label(name, "light", label, sizeof label);
    return light_layer(p, label);
}

static bool part_shines(const scene *s, const scene_instance *at) {
    for (uint32_t i = 0; i < instance_slot_count(at); i++)
        if (s->materials[instance_slot(at, i)].shines) return true;
    return false;
}

/* Shapes that shine but are no lights, such as planes. */
static bool has_other_emission(const scene *s) {
    for (uint32_t i = 0; i < s->part_count; i++) {
        const scene_instance *at = &s->instances[i];
        if (at->group == NO_ID && !at->shines && part_shines(s, at)) return true;
    }
    return false;
}

static snell_status plan_lights(aov_plan *p, const description *d) {
    const scene *s = p->settings->scene;
    p->light_names = memory_zeroed(LIGHT_LAYERS_MAX + PLACE_COUNT, sizeof *p->light_names);
    p->registry = memory_zeroed(s->light_count + 1, sizeof *p->registry);
    p->surfaces = memory_zeroed(s->surface_light_count + 1, sizeof *p->surfaces);
    if (!p->light_names || !p->registry || !p->surfaces) return error_no_memory();
    for (uint32_t i = 0; i < s->light_count; i++)
        p->registry[i] = layer_of(p, scene_name_light(s, d, i));
    for (uint32_t i = 0; i < s->surface_light_count; i++) {
        const scene_instance *at = scene_part(s, s->surface_lights[i].instance);
        p->surfaces[i] = layer_of(p, scene_name_part(s, d, at));
    }
    bool sky = s->has_gradient || dvec3_largest(s->background) > 0;
    if (sky) p->places[PLACE_BACKGROUND] = light_layer(p, "background");
    bool ambient = dvec3_largest(s->ambient) > 0 && !p->settings->integrator->one_branch;
    if (ambient) p->places[PLACE_AMBIENT] = light_layer(p, "ambient");
    if (p->joined > 0 || has_other_emission(s) || p->light_count == 0)
        p->places[PLACE_OTHER] = light_layer(p, "other");
    return SNELL_OK;
}

/* ---- cryptomatte ---- */

typedef struct matte_name {
    char label[LABEL_MAX];
    uint32_t id;
} matte_name;

static int by_label(const void *a, const void *b) {
    return strcmp(((const matte_name *)a)->label, ((const matte_name *)b)->label);
}

static bool add_text(char **text, size_t *size, size_t *capacity, const char *more) {
    size_t length = strlen(more);
    if (!ARRAY_GROW(*text, *size, *capacity, length + 1)) return false;
    memcpy(*text + *size, more, length + 1);
    *size += length;
    return true;
}

/* {"name":"id",..}, each name once, in order. What JSON does not take in a text stands as \u00XX. */
static char *write_manifest(matte_name *names, size_t count) {
    char *text = NULL, piece[LABEL_MAX * 6 + 32];
    size_t size = 0, capacity = 0;
    qsort(names, count, sizeof *names, by_label);
    bool room = add_text(&text, &size, &capacity, "{");
    for (size_t i = 0; room && i < count; i++) {
        if (i > 0 && strcmp(names[i].label, names[i - 1].label) == 0) continue;
        char *to = piece;
        to += sprintf(to, "%s\"", i > 0 ? "," : "");
        for (const unsigned char *c = (const unsigned char *)names[i].label; *c; c++) {
            if (*c < ' ' || *c == '"' || *c == '\\')
                to += sprintf(to, "\\u%04x", *c);
            else
                *to++ = (char)*c;
        }
        sprintf(to, "\":\"%08x\"", names[i].id);
        room = add_text(&text, &size, &capacity, piece);
    }
    if (room && add_text(&text, &size, &capacity, "}")) return text;
    free(text);
    return NULL;
}

typedef scene_name name_fn(const scene *s, const description *d, uint32_t index);

static scene_name name_of_part(const scene *s, const description *d, uint32_t index) {
    return scene_name_part(s, d, &s->instances[index]);
}

static snell_status plan_matte(aov_plan *p, const description *d, int which, uint32_t count,
                               name_fn *name) {
    matte_name *names = memory_zeroed(count + 1, sizeof *names);
    p->ids[which] = memory_zeroed(count + 1, sizeof *p->ids[which]);
    if (names && p->ids[which]) {
        for (uint32_t i = 0; i < count; i++) {
            scene_label(name(p->settings->scene, d, i), "default", names[i].label, LABEL_MAX);
            p->ids[which][i] = names[i].id = crypto_id(names[i].label);
        }
        p->manifests[which] = write_manifest(names, count);
    }
    free(names);
    return p->manifests[which] ? SNELL_OK : error_no_memory();
}

/* ---- the plan ---- */

static const aov_id mattes[MATTES] = {AOV_crypto_object, AOV_crypto_material};
static const aov_id numbers[NUMBERS] = {AOV_object_id, AOV_material_id, AOV_primitive_id};

static void place_sums(aov_plan *p) {
    for (int i = 0; i < AOV_COUNT; i++) {
        const aov_info *info = &aov_table[i];
        p->first[i] = p->channel_count;
        if (!wants(p, (aov_id)i) || info->mean > AOV_COVERED) continue;
        p->channel_count += info->channel_count * (i == AOV_light ? p->light_count : 1);
    }
}

snell_status aov_plan_create(aov_set wanted, const wave_settings *settings, const description *d,
                             aov_plan **out) {
    aov_plan *p = memory_zeroed(1, sizeof *p);
    if (p == NULL) return error_no_memory();
    const scene *s = settings->scene;
    p->wanted = wanted;
    p->settings = settings;
    snell_status status = SNELL_OK;
    if (wants(p, AOV_light)) status = plan_lights(p, d);
    if (!status && wants(p, AOV_crypto_object))
        status = plan_matte(p, d, 0, s->part_count, name_of_part);
    if (!status && wants(p, AOV_crypto_material))
        status = plan_matte(p, d, 1, s->material_count + 1 + s->body_count, scene_name_material);
    place_sums(p);
    if (status) {
        aov_plan_destroy(p);
        return status;
    }
    *out = p;
    return SNELL_OK;
}

void aov_plan_destroy(aov_plan *p) {
    if (p == NULL) return;
    free(p->light_names);
    free(p->registry);
    free(p->surfaces);
    for (int i = 0; i < MATTES; i++) {
        free(p->ids[i]);
        free(p->manifests[i]);
    }
    free(p);
}

uint32_t aov_plan_joined(const aov_plan *p, const char **names) {
    *names = p->joined_names;
    return p->joined;
}

snell_status aov_plan_add_layers(const aov_plan *p, film *f) {
    snell_status status = SNELL_OK;
    for (int i = 0; i < AOV_COUNT && !status; i++) {
        const aov_info *info = &aov_table[i];
        const char *manifest = NULL;
        if (!wants(p, (aov_id)i)) continue;
        for (int k = 0; k < MATTES; k++)
            if (mattes[k] == (aov_id)i) manifest = p->manifests[k];
        if (i != AOV_light)
            status = film_add_layer(f, info, info->name, info->channel_count, manifest);
        for (uint32_t k = 0; i == AOV_light && k < p->light_count && !status; k++)
            status = film_add_layer(f, info, p->light_names[k], info->channel_count, NULL);
    }
    return status;
}

/* ---- the sums of a block ---- */

typedef struct matte {
    uint32_t id;
    fixed128 coverage;
} matte;

typedef struct matte_list { /* by id, rising */
    matte *items;
    size_t count, capacity;
} matte_list;

typedef struct sky_share {
    uint32_t layer;
    dvec3 radiance;
} sky_share;

struct aov_block {
    const aov_plan *plan;
    fixed128 *sums; /* channel_count for each pixel */
    fixed128 covered[PIXELS];
    float numbers[NUMBERS][PIXELS];
    matte_list mattes[MATTES][PIXELS];
    uint64_t rays[PIXELS];
    sky_share
        shares[LIGHT_LAYERS_MAX + PLACE_COUNT]; /* of the ray that leaves, one for each layer */
    uint32_t share_count;
    uint64_t overflows; /* the film counts those of light */
    bool no_memory;
};

snell_status aov_block_create(const aov_plan *plan, aov_block **out) {
    aov_block *b = memory_zeroed(1, sizeof *b);
    if (b == NULL) return error_no_memory();
    b->plan = plan;
    b->sums = memory_zeroed(PIXELS * (size_t)(plan->channel_count + 1), sizeof *b->sums);
    *out = b;
    if (b->sums) return SNELL_OK;
    aov_block_destroy(b);
    return error_no_memory();
}

void aov_block_destroy(aov_block *b) {
    if (b == NULL) return;
    for (int k = 0; k < MATTES; k++)
        for (int i = 0; i < PIXELS; i++) free(b->mattes[k][i].items);
    free(b->sums);
    free(b);
}

void aov_block_clear(aov_block *b) {
    memset(b->sums, 0, PIXELS * (size_t)b->plan->channel_count * sizeof *b->sums);
    memset(b->covered, 0, sizeof b->covered);
    memset(b->numbers, 0, sizeof b->numbers);
    memset(b->rays, 0, sizeof b->rays);
    for (int k = 0; k < MATTES; k++)
        for (int i = 0; i < PIXELS; i++) b->mattes[k][i].count = 0;
}

static fixed128 *sums_of(aov_block *b, uint32_t pixel, uint32_t channel) {
    return b->sums + (size_t)pixel * b->plan->channel_count + channel;
}

/* ---- surfaces ---- */

static void add_values(aov_block *b, uint32_t pixel, aov_id id, const double *values,
                       double coverage) {
    if (!wants(b->plan, id)) return;
    fixed128 *sum = sums_of(b, pixel, b->plan->first[id]);
    for (uint32_t c = 0; c < aov_table[id].channel_count; c++)
        fixed_add(&sum[c], fixed_from(values[c] * coverage, &b->overflows), &b->overflows);
}

static void add_vector(aov_block *b, uint32_t pixel, aov_id id, dvec3 v, double coverage) {
    add_values(b, pixel, id, (const double[]){v.x, v.y, v.z}, coverage);
}

static void add_matte(aov_block *b, int which, uint32_t pixel, uint32_t id, double coverage) {
    matte_list *list = &b->mattes[which][pixel];
    size_t low = 0, high = list->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (list->items[middle].id < id)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == list->count || list->items[low].id != id) {
        if (!ARRAY_GROW(list->items, list->count, list->capacity, 1)) {
            b->no_memory = true;
            return;
        }
        memmove(list->items + low + 1, list->items + low,
                (list->count++ - low) * sizeof *list->items);
        list->items[low] = (matte){id, 0};
    }
    fixed_add(&list->items[low].coverage, fixed_from(coverage, &b->overflows), &b->overflows);
}

/* Where the point is in the picture a frame after the shutter opens, from where it is when that does. */
static void find_motion(const wave *w, const path_ray *r, const hit *h, double out[2]) {
    const wave_settings *s = &w->settings;
    out[0] = out[1] = 0;
    if (!s->scene->changes && s->frame.motion == NULL) return;
    const float times[2] = {(float)s->shutter_open,
                            (float)(s->shutter_open + s->scene->frame_length)};
    double x[2], y[2];
    for (int i = 0; i < 2; i++) {
        dvec3 p = scene_hit_moved(s->scene, &r->ray, h, times[i]);
        if (!camera_project(s->camera, &s->frame, times[i], p, &x[i], &y[i])) return;
    }
    out[0] = x[1] - x[0];
    out[1] = y[1] - y[0];
}

static void set_numbers(aov_block *b, const path_ray *r, const shade_point *p, uint32_t made_of) {
    if (r->sample > 0 || b->numbers[0][r->pixel] > 0) return;
    b->numbers[0][r->pixel] = (float)p->instance + 1;
    b->numbers[1][r->pixel] = (float)made_of + 1;
    b->numbers[2][r->pixel] = (float)p->primitive + 1;
}

void aov_hit(wave *w, const path_ray *r, const hit *h, const shade_point *p, const bsdf *b) {
    aov_block *to = w->aovs;
    const wave_settings *s = &w->settings;
    double coverage = (double)r->coverage, depth, pair[2];
    uint32_t made_of = (uint32_t)(p->material - s->scene->materials);
    fixed_add(&to->covered[r->pixel], fixed_from(coverage, &to->overflows), &to->overflows);
    depth = camera_depth(s->camera, &s->frame, r->ray.time, p->p);
    add_values(to, r->pixel, AOV_depth, &depth, coverage);
    add_vector(to, r->pixel, AOV_position, p->p, coverage);
    add_vector(to, r->pixel, AOV_normal, p->ns, coverage);
    add_vector(to, r->pixel, AOV_geometric_normal, p->n, coverage);
    if (wants(to->plan, AOV_albedo))
        add_vector(to, r->pixel, AOV_albedo, bsdf_albedo(b, p->ns, p->wo), coverage);
    if (wants(to->plan, AOV_uv)) {
        scene_hit_uv(s->scene, &r->ray, h, pair);
        add_values(to, r->pixel, AOV_uv, pair, coverage);
    }
    if (wants(to->plan, AOV_motion)) {
        find_motion(w, r, h, pair);
        add_values(to, r->pixel, AOV_motion, pair, coverage);
    }
    if (w->scramble == 0) set_numbers(to, r, p, made_of);
    const scene_instance *part = scene_part(s->scene, p->instance);
    const uint32_t index[MATTES] = {(uint32_t)(part - s->scene->instances), made_of};
    for (int k = 0; k < MATTES; k++)
        if (to->plan->ids[k]) add_matte(to, k, r->pixel, to->plan->ids[k][index[k]], coverage);
    if (to->no_memory) w->out_of_memory = true;
}

/* ---- light ---- */

typedef struct fixed3 {
    fixed128 v[3];
} fixed3;

/* As the film takes it. */
static fixed3 to_fixed3(aov_block *b, dvec3 v) {
    return (fixed3){{fixed_from(v.x, &b->overflows), fixed_from(v.y, &b->overflows),
                     fixed_from(v.z, &b->overflows)}};
}

static fixed3 fixed3_sub(fixed3 a, fixed3 b) {
    return (fixed3){{a.v[0] - b.v[0], a.v[1] - b.v[1], a.v[2] - b.v[2]}};
}

static void add_light(aov_block *b, uint32_t pixel, aov_id id, uint32_t layer, fixed3 value) {
    if (!wants(b->plan, id)) return;
    fixed128 *sum = sums_of(b, pixel, b->plan->first[id] + 3 * layer);
    for (int c = 0; c < 3; c++) fixed_add(&sum[c], value.v[c], &b->overflows);
}

/* Is light sorted at all? */
static bool sorts_light(const aov_plan *p) {
    const aov_set all = 1u << AOV_emission | 1u << AOV_direct | 1u << AOV_indirect |
                        1u << AOV_reflection | 1u << AOV_refraction | 1u << AOV_light;
    return (p->wanted & all) != 0;
}

static void add_by_way(aov_block *b, uint32_t pixel, light_way way, fixed3 value) {
    aov_id by_depth = way.depth == 0 ? AOV_emission : way.depth == 1 ? AOV_direct : AOV_indirect;
    add_light(b, pixel, by_depth, 0, value);
    if (way.route == RAY_REFLECTED) add_light(b, pixel, AOV_reflection, 0, value);
    if (way.route == RAY_REFRACTED) add_light(b, pixel, AOV_refraction, 0, value);
    add_light(b, pixel, AOV_light, way.layer, value);
}

static dvec3 weighted(const path_ray *r, dvec3 radiance) {
    return dvec3_mul(dvec3_from(r->weight), radiance);
}

/* The layer of a shape that shines. */
static uint32_t layer_of_shape(const aov_plan *p, uint32_t shape) {
    if (!wants(p, AOV_light)) return 0;
    const scene *s = p->settings->scene;
    const surface_light *found = scene_surface_light(s, shape);
    return found ? p->surfaces[found - s->surface_lights] : p->places[PLACE_OTHER];
}

/* Of light or source number w->asked, in the numbering of the integrator (scene/lights.h). */
static uint32_t layer_of_asked(const wave *w) {
    const aov_plan *p = w->aovs->plan;
    const scene *s = w->settings.scene;
    if (!wants(p, AOV_light)) return 0;
    if (w->asked < s->light_count) return p->registry[w->asked];
    uint32_t index = w->asked - s->light_count;
    return w->settings.integrator->one_branch ? layer_of_shape(p, s->emitters[index].instance)
                                              : p->surfaces[index];
}

/* Ambient light stands for what has been scattered often. */
void aov_surface(wave *w, const path_ray *r, dvec3 radiance, dvec3 ambient) {
    aov_block *b = w->aovs;
    if (!sorts_light(b->plan)) return;
    light_way way = {UINT32_MAX, r->route, b->plan->places[PLACE_AMBIENT]};
    fixed3 sum = to_fixed3(b, weighted(r, radiance));
    if (dvec3_largest(ambient) > 0) {
        bool alone = memcmp(&radiance, &ambient, sizeof ambient) == 0;
        fixed3 part = to_fixed3(b, weighted(r, ambient));
        add_by_way(b, r->pixel, way, part);
        if (alone) return;
        sum = fixed3_sub(sum, part);
    }
    way = (light_way){r->depth, r->route, layer_of_shape(b->plan, w->at->instance)};
    add_by_way(b, r->pixel, way, sum);
}

void aov_sky_share(wave *w, uint32_t number, dvec3 radiance) {
    aov_block *b = w->aovs;
    if (!wants(b->plan, AOV_light)) return;
    uint32_t i = 0, layer = number == NO_ID ? b->plan->places[PLACE_BACKGROUND]
                                            : b->plan->registry[number];
    while (i < b->share_count && b->shares[i].layer != layer) i++;
    if (i == b->share_count) b->shares[b->share_count++] = (sky_share){layer, {0, 0, 0}};
    b->shares[i].radiance = dvec3_add(b->shares[i].radiance, radiance);
}

/* Each its own share and the last the rest, so that together they are what the film is given. */
void aov_sky(wave *w, const path_ray *r, dvec3 radiance, double alpha) {
    aov_block *b = w->aovs;
    if (!sorts_light(b->plan)) return;
    light_way way = {r->depth, r->route, 0};
    fixed3 rest = to_fixed3(b, weighted(r, radiance));
    for (uint32_t i = 0; i < b->share_count; i++) {
        way.layer = b->shares[i].layer;
        if (i + 1 == b->share_count) break;
        fixed3 part = to_fixed3(b, weighted(r, dvec3_scale(b->shares[i].radiance, alpha)));
        add_by_way(b, r->pixel, way, part);
        rest = fixed3_sub(rest, part);
    }
    b->share_count = 0;
    add_by_way(b, r->pixel, way, rest);
}

void aov_asked(wave *w, const path_ray *r, dvec3 radiance) {
    light_way way = {r->depth + 1u, r->route, layer_of_asked(w)};
    if (!sorts_light(w->aovs->plan)) return;
    add_by_way(w->aovs, r->pixel, way, to_fixed3(w->aovs, weighted(r, radiance)));
}

void aov_waits(wave *w, const path_ray *r) {
    w->light_ways[w->shadow_count] = (light_way){r->depth + 1u, r->route, layer_of_asked(w)};
}

void aov_shadow(wave *w, size_t index, dvec3 contribution) {
    if (!sorts_light(w->aovs->plan)) return;
    add_by_way(w->aovs, w->shadows[index].pixel, w->light_ways[index],
               to_fixed3(w->aovs, contribution));
}

/* ---- work ---- */

void aov_traced(wave *w, const path_ray *rays, size_t count) {
    for (size_t i = 0; i < count; i++) w->aovs->rays[rays[i].pixel]++;
}

void aov_traced_shadows(wave *w) {
    for (size_t i = 0; i < w->shadow_count; i++) w->aovs->rays[w->shadows[i].pixel]++;
}

/* ---- to the film ---- */

/* A mean, or where there is nothing to take one of, what stands for nothing. */
static float mean_of(fixed128 sum, double over, aov_id id) {
    if (over > 0) return (float)(fixed_to(sum) / over);
    return id == AOV_depth ? 1e10f : 0;
}

/* Does `a` come before `b`? More coverage first; of equal ones the lower id. */
static bool ranks_before(const matte *a, const matte *b) {
    return a->coverage != b->coverage ? a->coverage > b->coverage : a->id < b->id;
}

static void set_mattes(const matte_list *list, uint32_t samples, float *out) {
    const matte *last = NULL;
    for (int rank = 0; rank < CRYPTO_RANKS; rank++) {
        const matte *best = NULL;
        for (const matte *at = list->items, *end = at + list->count; at < end; at++)
            if ((!last || ranks_before(last, at)) && (!best || ranks_before(at, best))) best = at;
        if (best == NULL) return;
        out[2 * rank] = crypto_float(best->id);
        out[2 * rank + 1] = (float)(fixed_to(best->coverage) / samples);
        last = best;
    }
}

const fixed128 *aov_block_sums(const aov_block *b, aov_id id, uint32_t lamp, uint32_t pixel) {
    return b->sums + (size_t)pixel * b->plan->channel_count + b->plan->first[id] + 3 * lamp;
}

static void set_layer(const aov_block *b, aov_id id, uint32_t lamp, uint32_t pixel,
                      uint32_t samples, float *out) {
    const aov_info *info = &aov_table[id];
    double over = info->mean == AOV_COVERED ? fixed_to(b->covered[pixel]) : samples;
    const fixed128 *sums = aov_block_sums(b, id, lamp, pixel);
    if (info->mean <= AOV_COVERED)
        for (uint32_t c = 0; c < info->channel_count; c++) out[c] = mean_of(sums[c], over, id);
    for (int k = 0; k < NUMBERS; k++)
        if (numbers[k] == id) out[0] = b->numbers[k][pixel];
    for (int k = 0; k < MATTES; k++)
        if (mattes[k] == id) set_mattes(&b->mattes[k][pixel], samples, out);
    if (id == AOV_rays) out[0] = (float)b->rays[pixel];
}

void aov_block_set(const aov_block *b, uint32_t pixel, uint32_t samples, film *f, uint32_t x,
                   uint32_t y) {
    size_t layer = 0, place = (size_t)y * f->width + x;
    for (int i = 0; i < AOV_COUNT; i++) {
        uint32_t count = i == AOV_light ? b->plan->light_count : 1;
        for (uint32_t k = 0; wants(b->plan, (aov_id)i) && k < count; k++, layer++)
            set_layer(b, (aov_id)i, k, pixel, samples,
                      f->layers[layer].pixels + place * f->layers[layer].channels);
    }
}
