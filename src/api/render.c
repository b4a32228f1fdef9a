/* Settings, rendering and films. */
#include "render/render.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/api.h"

#include "base/thread.h"
#include "base/memory.h"
#include "image/aov.h"
#include "image/tonemap.h"
#include "integrators/aov.h"
#include "render/adaptive.h"
#include "render/notes.h"
#include "scene/settings.h"

static const float DEFAULT_MIN_WEIGHT = 0.002f;

static const render_desc *render_settings(const snell_scene *s) {
    const object *o = description_setting(s->description, "render");
    return o ? o->desc : NULL;
}

static snell_status find_integrator(snell_integrator which, const integrator **out) {
    if (which < SNELL_APPEL || which > SNELL_PATH)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "integrator %d does not exist", (int)which);
    *out = integrators[which - 1];
    if (*out == NULL)
        return error_set(SNELL_ERR_UNSUPPORTED, "use appel or whitted",
                         "this integrator is not in this version");
    return SNELL_OK;
}

static bool has_clear_background(const description *d) {
    const object *background = description_setting(d, "background");
    return background && ((const background_desc *)background->desc)->alpha < 1;
}

static uint32_t usual_depth(const snell_scene *s, const integrator *policy) {
    return description_has_dielectric(s->description) ? policy->max_depth_media : policy->max_depth;
}

/* A scene's samples and depth are meant for its own integrator: another takes its own, unless the
 * caller chose some. The note has the line of render{}. */
static void say_meant_for(const snell_scene *s, const snell_render_desc *chosen,
                          const integrator *policy) {
    const render_desc *r = render_settings(s);
    if (r == NULL || r->integrator == 0 || r->integrator == (int)chosen->integrator) return;
    bool samples = r->samples > 0 && (uint32_t)r->samples != chosen->samples &&
                   chosen->samples == policy->samples;
    bool depth = r->max_depth >= 0 && (uint32_t)r->max_depth != chosen->max_depth &&
                 chosen->max_depth == usual_depth(s, policy);
    if (!samples && !depth) return;
    char text[128], instead[32];
    snprintf(text, sizeof text, "%s %d", samples ? "samples" : "max_depth",
             samples ? r->samples : r->max_depth);
    snprintf(instead, sizeof instead, "%u", samples ? chosen->samples : chosen->max_depth);
    if (samples && depth) {
        snprintf(text, sizeof text, "samples %d and max_depth %d", r->samples, r->max_depth);
        snprintf(instead, sizeof instead, "%u and %u", chosen->samples, chosen->max_depth);
    }
    const object *said = description_setting(s->description, "render");
    log_write(&s->context->log, SNELL_INFO, (source_place){said->file, said->line, 0}, "",
              "the scene's %s %s meant for %s: %s takes its own, %s", text, samples ? "are" : "is",
              integrators[r->integrator - 1]->name, policy->name, instead);
}

static void say_depth(const snell_scene *s, const snell_render_desc *chosen,
                      const integrator *policy) {
    const render_desc *r = render_settings(s);
    bool own =
        r && r->max_depth >= 0 && (r->integrator == 0 || r->integrator == (int)chosen->integrator);
    uint32_t depth = usual_depth(s, policy);
    if (own || depth == policy->max_depth || chosen->max_depth != depth) return;
    log_write(&s->context->log, SNELL_INFO, (source_place){0}, "",
              "max_depth is %u, not %u: the scene has glass", depth, policy->max_depth);
}

static snell_status settings(const snell_scene *s, snell_integrator which, snell_render_desc *out) {
    render_desc defaults;
    desc_init(&setting_render, &defaults);
    const render_desc *r = render_settings(s);
    bool same = r == NULL || which == 0 || r->integrator == 0 || (int)which == r->integrator;
    if (r == NULL) r = &defaults;
    if (which == 0) which = r->integrator > 0 ? (snell_integrator)r->integrator : SNELL_WHITTED;
    const integrator *policy = NULL;
    snell_status status = find_integrator(which, &policy);
    if (status) return status;
    bool own_depth = same && r->max_depth >= 0;
    uint32_t samples = r->noise > 0 ? SNELL_NOISE_SAMPLES : policy->samples;
    if (same && r->samples > 0) samples = (uint32_t)r->samples;
    *out = (snell_render_desc){
        .struct_size = sizeof *out,
        .integrator = which,
        .width = r->width > 0 ? (uint32_t)r->width : DEFAULT_WIDTH,
        .height = r->height > 0 ? (uint32_t)r->height : DEFAULT_HEIGHT,
        .samples = samples,
        .noise = r->noise,
        .max_depth = own_depth ? (uint32_t)r->max_depth : usual_depth(s, policy),
        .min_weight = r->min_weight >= 0 ? r->min_weight : DEFAULT_MIN_WEIGHT,
        .filter = (snell_filter)r->filter,
        .filter_radius = r->filter_radius,
        .pixel_center = r->pixel_center,
        .transparent = has_clear_background(s->description),
        .seed = (uint64_t)r->seed,
        .aov = r->aov[0] ? r->aov : NULL};
    return SNELL_OK;
}

snell_status snell_scene_settings(const snell_scene *s, snell_integrator which,
                                  snell_render_desc *out) {
    if (out == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    snell_status status = scene_begin_look(s);
    if (status) return status;
    status = settings(s, which, out);
    scene_end_read(s);
    return status;
}

static snell_status check_render(const snell_render_desc *r) {
    if (r->struct_size != sizeof *r)
        return error_set(SNELL_ERR_VERSION, "compile against the library's own header",
                         "snell_render: the description has another version's size");
    if (r->width < 1 || r->width > 65536 || r->height < 1 || r->height > 65536 ||
        (uint64_t)r->width * r->height > 1u << 30)
        return error_set(SNELL_ERR_ARGUMENT, "sides are 1 to 65536 pixels, at most 2^30 in all",
                         "a picture cannot be %u x %u pixels", r->width, r->height);
    if (r->crop_width > 0 &&
        (r->crop_height == 0 || (uint64_t)r->crop_x + r->crop_width > r->width ||
         (uint64_t)r->crop_y + r->crop_height > r->height))
        return error_set(SNELL_ERR_ARGUMENT, NULL,
                         "the crop %ux%u+%u+%u is not inside the picture of %u x %u pixels",
                         r->crop_width, r->crop_height, r->crop_x, r->crop_y, r->width, r->height);
    if (r->samples < 1 || r->samples > 1u << 20)
        return error_set(SNELL_ERR_ARGUMENT, "1 to 1048576", "samples cannot be %u", r->samples);
    if (!(r->noise >= 0 && r->noise <= 1))
        return error_set(SNELL_ERR_ARGUMENT, "0, or a relative error up to 1, such as 0.01",
                         "noise cannot be %g", (double)r->noise);
    if (r->noise > 0 && r->samples < NOISE_SCRAMBLES)
        return error_set(SNELL_ERR_ARGUMENT, "the error is estimated from four groups of samples",
                         "with a noise, samples cannot be under %d", NOISE_SCRAMBLES);
    if (!(r->time_limit >= 0))
        return error_set(SNELL_ERR_ARGUMENT, "seconds; 0: none", "time_limit cannot be %g",
                         r->time_limit);
    if (r->max_depth > 1000)
        return error_set(SNELL_ERR_ARGUMENT, "at most 1000", "max_depth cannot be %u",
                         r->max_depth);
    if (!(r->min_weight >= 0 && r->min_weight <= 1))
        return error_set(SNELL_ERR_ARGUMENT, "0 to 1", "min_weight cannot be %g",
                         (double)r->min_weight);
    if ((int)r->filter < SNELL_FILTER_BOX || r->filter > SNELL_FILTER_BLACKMAN_HARRIS)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "filter %d does not exist", (int)r->filter);
    if (!(r->filter_radius >= 0 && r->filter_radius <= FILTER_RADIUS_MAX))
        return error_set(SNELL_ERR_ARGUMENT, "0 to 16 pixels", "filter_radius cannot be %g",
                         (double)r->filter_radius);
    if (r->wave_size > 1u << 20)
        return error_set(SNELL_ERR_ARGUMENT, "at most 1048576", "wave_size cannot be %u",
                         r->wave_size);
    return SNELL_OK;
}

/* The camera of the render: its type and description; `view` becomes a perspective camera by value.
 */
static snell_status choose_camera(const snell_scene *s, const snell_render_desc *r,
                                  perspective_desc *by_value, const camera_type **type,
                                  const void **desc) {
    if (r->view && r->view->struct_size != sizeof *r->view)
        return error_set(SNELL_ERR_VERSION, "compile against the library's own header",
                         "snell_render: the view has another version's size");
    if (r->view) {
        *by_value = view_to_perspective(r->view);
        snell_status status = desc_check(&camera_perspective.info, by_value, NULL);
        if (!status) status = camera_perspective.check(by_value);
        *type = &camera_perspective;
        *desc = by_value;
        return status;
    }
    const object_list *cameras = &s->description->objects[CATEGORY_CAMERA];
    uint32_t index = r->camera.index1 ? r->camera.index1 - 1 : 0;
    if (cameras->count == 0)
        return error_set(SNELL_ERR_ARGUMENT, "add one, set view, or call snell_scene_add_studio",
                         "the scene has no camera");
    if (index >= cameras->count || r->camera.generation != 0)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "there is no camera %u", index + 1);
    *type = (const camera_type *)cameras->items[index].type;
    *desc = cameras->items[index].desc;
    return SNELL_OK;
}

/* What the scene wants done to the picture when it is written. */
static void keep_look(const snell_scene *s, snell_film *f) {
    free(f->layers);
    f->layers = NULL;
    const render_desc *r = render_settings(s);
    snprintf(f->white_balance, sizeof f->white_balance, "%s", r ? r->white_balance : "");
    f->exposure = r ? r->exposure : 0;
    f->tonemap = r ? r->tonemap : 0;
    if (f->tonemap == 0)
        f->tonemap = choice_find(TONEMAP_CHOICES, s->description->is_model ? "neutral" : "clip");
}

/* When the shutter is open, which is one moment where nothing moves; and how the camera moves
 * then: *moved has no steps where it does not. */
static snell_status open_shutter(const snell_scene *s, const camera_common *camera, double times[2],
                                 motion *moved) {
    const scene *frozen = s->frozen;
    scene_shutter(s->description, camera, times);
    if (camera->motion_count == 0 && !frozen->changes) {
        times[1] = times[0];
        return SNELL_OK;
    }
    if (frozen->changes && (times[0] < frozen->time_open || times[1] > frozen->time_close))
        return error_set(SNELL_ERR_STATE, "give a camera of the scene this shutter and commit",
                         "the shutter is open when nothing was committed for: %g to %g s, not "
                         "within %g to %g s",
                         times[0], times[1], frozen->time_open, frozen->time_close);
    if (camera->motion_count == 0) return SNELL_OK;
    return motion_prepare(camera->motion, camera->motion_count, times[0], times[1], moved);
}

void prepared_render_free(prepared_render *p) {
    pixel_filter_free(&p->filter);
    motion_free(&p->moved);
}

static snell_status prepare_with(const snell_scene *s, const snell_render_desc *r,
                                 const camera_type *camera, const void *camera_desc,
                                 const integrator *policy, prepared_render *out) {
    const scene *frozen = s->frozen;
    double times[2];
    snell_status status = open_shutter(s, camera_desc, times, &out->moved);
    if (status) return status;
    if (!pixel_filter_create((int)r->filter, (double)r->filter_radius, &out->filter)) {
        motion_free(&out->moved);
        return error_no_memory();
    }
    camera_frame frame;
    solid_take_spent();
    camera_prepare(camera, camera_desc, r->width, r->height, out->moved.count ? &out->moved : NULL,
                   &frame);
    /* A lens, or the plane of parallel rays, counts as being where its middle is. */
    const media beyond_the_lens =
        media_around(frozen, s->context->isa, frame.position, (float)times[0]);
    if (solid_take_spent()) {
        prepared_render_free(out);
        return solid_error_spent();
    }
    bool crop = r->crop_width > 0;
    out->options = (render_options){.wave = {.scene = frozen,
                                             .integrator = policy,
                                             .camera = camera,
                                             .frame = frame,
                                             .camera_media = beyond_the_lens,
                                             .filter = &out->filter,
                                             .shutter_open = times[0],
                                             .shutter_close = times[1],
                                             .width = r->width,
                                             .height = r->height,
                                             .max_depth = r->max_depth,
                                             .min_weight = r->min_weight,
                                             .seed = r->seed,
                                             .pixel_center = r->pixel_center,
                                             .transparent = r->transparent,
                                             .wave_size = r->wave_size,
                                             .timed = r->timed,
                                             .isa = s->context->isa},
                                    .crop_x = crop ? r->crop_x : 0,
                                    .crop_y = crop ? r->crop_y : 0,
                                    .crop_width = crop ? r->crop_width : r->width,
                                    .crop_height = crop ? r->crop_height : r->height,
                                    .samples = r->samples,
                                    .sharing = r->noise > 0 ? NOISE_FIRST : r->samples,
                                    .noise = (double)r->noise,
                                    .time_limit = r->time_limit,
                                    .progress = r->progress,
                                    .user = r->user};
    return SNELL_OK;
}

snell_status prepare_render(const snell_scene *s, const snell_render_desc *r,
                            prepared_render *out) {
    const integrator *policy = NULL;
    const camera_type *camera = NULL;
    const void *camera_desc = NULL;
    perspective_desc by_value;
    *out = (prepared_render){.moved = {0}};
    snell_status status = check_render(r);
    if (!status) status = find_integrator(r->integrator, &policy);
    if (!status) status = choose_camera(s, r, &by_value, &camera, &camera_desc);
    if (status) return status;
    say_depth(s, r, policy);
    say_meant_for(s, r, policy);
    render_notes(s->description, s->frozen, policy, &s->context->log);
    return prepare_with(s, r, camera, camera_desc, policy, out);
}

static snell_status render(const snell_scene *s, const snell_render_desc *r, snell_film *out) {
    prepared_render prepared;
    aov_set aovs;
    aov_plan *plan = NULL;
    snell_status status = aov_parse(r->aov, &aovs);
    if (!status) status = prepare_render(s, r, &prepared);
    if (status) return status;
    if (aovs) status = aov_plan_create(aovs, &prepared.options.wave, s->description, &plan);
    if (status) {
        prepared_render_free(&prepared);
        return status;
    }
    const char *joined = "";
    uint32_t joined_count = plan ? aov_plan_joined(plan, &joined) : 0;
    if (joined_count > 0)
        log_write(&s->context->log, SNELL_WARNING, (source_place){0},
                  "give lights that may share a layer one name",
                  "%d lights have layers of their own, %u more share light.other: %s",
                  LIGHT_LAYERS_MAX, joined_count, joined);
    prepared.options.wave.aovs = plan;
    keep_look(s, out);
    status = render_film(&prepared.options, s->context->pool, &out->film, &out->stats);
    if (out->stats.film_overflows > 0)
        log_write(&s->context->log, SNELL_WARNING, (source_place){0},
                  "lights and emission should be under 1e13",
                  "%llu times light was too bright to count: it is missing from the picture",
                  (unsigned long long)out->stats.film_overflows);
    aov_plan_destroy(plan);
    prepared_render_free(&prepared);
    return status;
}

snell_status snell_render(const snell_scene *s, const snell_render_desc *desc, snell_film *f) {
    if (desc == NULL || f == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_render: an argument is NULL");
    snell_status status = scene_begin_read(s);
    if (status) return status;
    unsigned saved = floatenv_enter();
    status = render(s, desc, f);
    floatenv_leave(saved);
    scene_end_read(s);
    return status;
}

static snell_status project(const snell_scene *s, const snell_render_desc *r,
                            const snell_vec3 *points, snell_vec2 *pixels, size_t count) {
    const camera_type *camera = NULL;
    const void *camera_desc = NULL;
    perspective_desc by_value;
    camera_frame frame;
    double times[2];
    motion moved = {0};
    snell_status status = check_render(r);
    if (!status) status = choose_camera(s, r, &by_value, &camera, &camera_desc);
    if (!status) status = open_shutter(s, camera_desc, times, &moved);
    if (status) return status;
    camera_prepare(camera, camera_desc, r->width, r->height, moved.count ? &moved : NULL, &frame);
    double left = r->crop_width ? r->crop_x : 0, top = r->crop_width ? r->crop_y : 0;
    for (size_t i = 0; i < count; i++) {
        double x = NAN, y = NAN;
        dvec3 p = dvec3_from(points[i]);
        if (!camera_project(camera, &frame, (float)times[0], p, &x, &y)) x = y = NAN;
        pixels[i] = (snell_vec2){(float)(x - left), (float)(y - top)};
    }
    motion_free(&moved);
    return SNELL_OK;
}

snell_status snell_scene_project(const snell_scene *s, const snell_render_desc *desc,
                                 const snell_vec3 *points, snell_vec2 *pixels, size_t count) {
    if (desc == NULL || (count > 0 && (points == NULL || pixels == NULL)))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_scene_project: an argument is NULL");
    snell_status status = scene_begin_read(s);
    if (status) return status;
    unsigned saved = floatenv_enter();
    status = project(s, desc, points, pixels, count);
    floatenv_leave(saved);
    scene_end_read(s);
    return status;
}

/* ---- films ---- */

snell_status snell_film_create(snell_context *context, snell_film **out) {
    if (context == NULL || out == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_film_create: an argument is NULL");
    *out = memory_zeroed(1, sizeof **out);
    if (*out == NULL) return error_no_memory();
    (*out)->context = context;
    return SNELL_OK;
}

void snell_film_destroy(snell_film *f) {
    if (f == NULL) return;
    free(f->layers);
    film_free(&f->film);
    free(f);
}

snell_status snell_film_get_stats(const snell_film *f, snell_render_stats *out) {
    if (f == NULL || out == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    if (out->struct_size != sizeof *out)
        return error_set(SNELL_ERR_VERSION, NULL, "struct_size is another version's");
    *out = f->stats;
    out->struct_size = sizeof *out;
    return SNELL_OK;
}

const float *snell_film_pixels(const snell_film *f, uint32_t *width, uint32_t *height,
                               uint32_t *channels) {
    if (f == NULL) return NULL;
    if (width) *width = f->film.width;
    if (height) *height = f->film.height;
    if (channels) *channels = f->film.channels;
    return f->film.pixels;
}

const char *snell_film_look(const snell_film *f, float *exposure) {
    char word[32];
    const tonemap *map;
    choice_word(TONEMAP_CHOICES, f && f->tonemap ? f->tonemap : 1, word, sizeof word);
    if (exposure) *exposure = f ? f->exposure : 0;
    return tonemap_find(word, &map) ? tonemaps[0]->name : map->name;
}

const char *snell_film_white_balance(const snell_film *f) { return f ? f->white_balance : ""; }

/* ---- AOVs ---- */

const char *snell_aov_name(uint32_t index, const char **channels, const char **help) {
    static _Thread_local char text[AOV_CHANNELS_MAX * 24];
    if (index >= AOV_COUNT) return NULL;
    const aov_info *info = &aov_table[index];
    size_t used = 0;
    for (const char *at = info->channels; *at; at += strcspn(at, "|"), at += *at == '|')
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%s%.*s", used ? " " : "",
                                 info->layer, (int)strcspn(at, "|"), at);
    if (channels) *channels = text;
    if (help) *help = info->help;
    return info->name;
}

bool snell_film_aov(const snell_film *f, uint32_t index, snell_aov *out) {
    if (f == NULL || out == NULL || index >= f->film.layer_count) return false;
    const film_layer *layer = &f->film.layers[index];
    *out = (snell_aov){layer->name, layer->channels, layer->pixels,
                       layer->manifest ? layer->manifest : ""};
    return true;
}

snell_status snell_film_aov_channel(const snell_film *f, uint32_t index, uint32_t channel,
                                    char *out, size_t size) {
    if (f == NULL || out == NULL || size == 0)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    if (index >= f->film.layer_count || channel >= f->film.layers[index].channels)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "the film has no channel %u of an AOV %u",
                         channel, index);
    char name[AOV_NAME_MAX];
    aov_channel_name(&f->film.layers[index], channel, name);
    snprintf(out, size, "%s", name);
    return SNELL_OK;
}

uint64_t snell_film_hash(const snell_film *f) { return f ? film_hash(&f->film) : 0; }

const float *snell_film_variance(const snell_film *f) { return f ? f->film.variance : NULL; }

const uint32_t *snell_film_samples(const snell_film *f) { return f ? f->film.samples : NULL; }
