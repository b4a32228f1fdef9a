#include "stage.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "picture.h"
#include "progress.h"
#include "report.h"
#include "text.h"

/* The direction (1, .6, 1.4) of a model that brings no camera, as azimuth atan2(1, 1.4) and
 * elevation atan(.6 / sqrt(1 + 1.4^2)). */
static const float default_view[2] = {0.62024949f, 0.33555448f};
static const float default_fov = 0.69813170f; /* 40 degrees */

int stage_status(const stage *s, snell_status status) {
    if (signals_caught() != 0) return EXIT_SOME_FAILED;
    return status == SNELL_OK ? EXIT_DONE : report_status(status, session_label(s->input));
}

/* ---- the picture's settings ---- */

static uint32_t scaled(uint32_t side, uint32_t numerator, uint32_t denominator) {
    uint64_t value = ((uint64_t)side * numerator + denominator / 2) / denominator;
    return value < 1 ? 1 : value > UINT32_MAX ? UINT32_MAX : (uint32_t)value;
}

static int apply_size(stage *s) {
    const render_values *v = s->values;
    snell_render_desc *d = &s->desc;
    uint32_t width = d->width, height = d->height;
    if (v->percent > 0) {
        double w = width * v->percent / 100 + 0.5, h = height * v->percent / 100 + 0.5;
        d->width = w < 1 ? 1 : w > 1e9 ? 1000000000 : (uint32_t)w;
        d->height = h < 1 ? 1 : h > 1e9 ? 1000000000 : (uint32_t)h;
    } else if (v->width > 0 && v->height > 0) {
        d->width = v->width;
        d->height = v->height;
    } else if (v->width > 0) {
        d->width = v->width;
        d->height = scaled(v->width, height, width);
    } else if (v->height > 0) {
        d->height = v->height;
        d->width = scaled(v->height, width, height);
    }
    if (d->width > IMAGE_SIDE_MAX || d->height > IMAGE_SIDE_MAX ||
        (uint64_t)d->width * d->height > (1u << 30)) {
        return report_usage("sides up to 65536, 2^30 pixels in all",
                            "--size: %" PRIu32 "x%" PRIu32 " is too large", d->width, d->height);
    }
    if (v->has_crop) {
        if (v->crop_x + v->crop_width > d->width || v->crop_y + v->crop_height > d->height) {
            return report_usage(NULL, "--crop: %s lies outside the picture of %" PRIu32 "x%" PRIu32,
                                s->options->value[OPT_CROP], d->width, d->height);
        }
        d->crop_x = v->crop_x;
        d->crop_y = v->crop_y;
        d->crop_width = v->crop_width;
        d->crop_height = v->crop_height;
    }
    return EXIT_DONE;
}

/* A scene's samples are meant for a picture without a bound, unless it says one itself. */
static void apply_stopping(const render_values *v, snell_render_desc *d) {
    bool own = d->noise > 0 || v->samples > 0;
    if (v->noise > 0) d->noise = v->noise;
    d->time_limit = v->time_limit;
    if (own) return;
    if (d->noise > 0)
        d->samples = SNELL_NOISE_SAMPLES;
    else if (d->time_limit > 0)
        d->samples = SAMPLES_MAX;
}

static int apply_settings(stage *s) {
    const render_values *v = s->values;
    snell_render_desc *d = &s->desc;
    *d = (snell_render_desc){.struct_size = sizeof *d};
    int code = stage_status(s, snell_scene_settings(s->scene, v->integrator, d));
    if (code != EXIT_DONE) return code;
    if (v->samples > 0) {
        d->samples = v->samples;
        d->pixel_center = v->samples == 1;
    }
    apply_stopping(v, d);
    if (v->has_max_depth) d->max_depth = v->max_depth;
    if (v->has_min_weight) d->min_weight = v->min_weight;
    if (v->has_seed) d->seed = v->seed;
    if (v->transparent) d->transparent = true;
    if (v->has_filter) { /* another filter has another radius */
        if (v->filter != d->filter) d->filter_radius = 0;
        d->filter = v->filter;
    }
    if (v->filter_radius > 0) d->filter_radius = v->filter_radius;
    if (v->aov != NULL) d->aov = v->aov;
    d->progress = progress_report;
    return apply_size(s);
}

/* ---- the camera ---- */

/* How far a turntable's frame is turned, in radians. */
static double turned(const stage *s) {
    const double whole = 6.283185307179586;
    uint32_t count = s->values->turntable, frame = s->session->turn;
    return count > 0 && frame > 0 ? whole * (frame - 1) / count : 0;
}

static int no_camera(const stage *s, uint32_t count, const char *wanted) {
    const char *names[64];
    size_t used = 0;
    snell_object_info info;
    char hint[200];
    for (uint32_t i = 0; i < count && used < 64; i++) {
        if (snell_scene_get_camera(s->scene, i, &info, NULL) == SNELL_OK) names[used++] = info.name;
    }
    const char *near = text_closest(wanted, names, used);
    if (near != NULL)
        snprintf(hint, sizeof hint, "did you mean '%.120s'?", near);
    else
        snprintf(hint, sizeof hint, "it has %" PRIu32 "; 'snell info' lists them", count);
    return report_usage(hint, "--camera: %s has no camera '%s'", session_label(s->input), wanted);
}

/* The index-th camera, and what it is called: its number where it has no name of its own. */
static int take_camera(stage *s, uint32_t index) {
    snell_object_info other, info;
    int code = stage_status(s, snell_scene_get_camera(s->scene, index, &info, &s->desc.camera));
    if (code != EXIT_DONE) return code;
    snprintf(s->camera, sizeof s->camera, "%s", info.name);
    bool own = s->camera[0] != '\0';
    for (uint32_t i = 0; i < index && own; i++)
        own = snell_scene_get_camera(s->scene, i, &other, NULL) != SNELL_OK ||
              strcmp(other.name, s->camera) != 0;
    if (!own) snprintf(s->camera, sizeof s->camera, "%" PRIu32, index + 1);
    return EXIT_DONE;
}

static int choose_camera(stage *s) {
    const char *wanted = s->options->value[OPT_CAMERA];
    uint32_t count = s->camera_count;
    uint64_t number = 0;
    if (s->values->all_cameras && count > 0) return take_camera(s, s->session->camera);
    if (wanted == NULL || s->values->all_cameras) return EXIT_DONE;
    for (uint32_t i = 0; i < count; i++) {
        snell_object_info info;
        snell_camera_id id;
        int code = stage_status(s, snell_scene_get_camera(s->scene, i, &info, &id));
        if (code != EXIT_DONE) return code;
        if (strcmp(info.name, wanted) != 0) continue;
        s->desc.camera = id;
        return EXIT_DONE;
    }
    if (!text_uint(wanted, 1, count, &number)) return no_camera(s, count, wanted);
    snell_object_info info;
    return stage_status(
        s, snell_scene_get_camera(s->scene, (uint32_t)(number - 1), &info, &s->desc.camera));
}

/* Frames everything, for --view and for files without a camera; where there are only planes, a
 * box around the origin. All of --frames are seen as the first is, or the camera would jump, and a
 * turntable's are as far from it. */
static int frame_all(stage *s) {
    const render_values *v = s->values;
    const float *from = v->has_view ? v->view : default_view;
    session *kept = s->session;
    if (v->many_frames && kept->framed_file == s->input) {
        s->view = kept->framed;
        return EXIT_DONE;
    }
    s->view = SNELL_INIT(view);
    s->view.fov = v->fov > 0 ? v->fov : default_fov;
    float aspect = (float)s->desc.width / (float)s->desc.height;
    int code = stage_status(
        s, snell_view_frame_scene(&s->view, s->scene, from[0], from[1], aspect, v->turntable > 0));
    if (code != EXIT_DONE || !v->many_frames) return code;
    kept->framed_file = s->input;
    kept->framed = s->view;
    return code;
}

/* Around the middle of what there is. */
static int turn_view(stage *s) {
    const snell_bounds *b = &s->bounds;
    snell_vec3 center = {0, 0, 0};
    if (b->min.x <= b->max.x)
        center = (snell_vec3){(b->min.x + b->max.x) / 2, (b->min.y + b->max.y) / 2,
                              (b->min.z + b->max.z) / 2};
    return stage_status(s, snell_view_turn(&s->view, center, (float)turned(s)));
}

/* A file's own camera gives way to --view by value, and --fov changes no more than its angle. */
static int choose_view(stage *s) {
    const render_values *v = s->values;
    int code = EXIT_DONE;
    if (v->has_view || s->camera_count == 0) {
        code = frame_all(s);
    } else if (v->fov > 0 || v->turntable > 0) {
        code = stage_status(s, snell_scene_get_view(s->scene, s->desc.camera, &s->view));
        if (v->fov > 0) s->view.fov = v->fov;
    } else {
        return EXIT_DONE;
    }
    s->desc.view = &s->view;
    return code;
}

/* ---- load and light ---- */

/* What the file lacked; a background that the command line gave was not added by the studio. Of frames, the first
 * says it for all. */
static void say_added(stage *s, const snell_scene_stats *has) {
    bool later = s->values->many_frames && s->session->frame > s->values->frame_first;
    static const char background[] = "background";
    const char *alone = s->camera_count > 0 ? "" : "camera";
    snprintf(s->added, sizeof s->added, "%s", s->studio != NULL ? s->studio : alone);
    size_t length = strlen(s->added), cut = sizeof background - 1;
    if (s->values->has_background && length >= cut &&
        strcmp(s->added + length - cut, background) == 0) {
        s->added[length > cut + 2 ? length - cut - 2 : 0] = '\0';
    }
    if (s->added[0] != '\0' && !later) {
        const char *slash = strrchr(s->input, '/');
        /* What is up in an STL file is a guess. */
        bool guessed = strcmp(has->format, "stl") == 0 && s->options->value[OPT_UP] == NULL;
        report_note("added: %s (%s has none)%s", s->added,
                    session_label(slash != NULL && slash[1] != '\0' ? slash + 1 : s->input),
                    guessed ? "; if it lies on its side: --up y" : "");
    }
}

/* --light none leaves the studio out: what is dark then should not surprise. */
static void warn_of_darkness(const stage *s, const snell_scene_stats *has) {
    bool lit = has->light_count > 0 || has->has_emission || has->has_ambient || has->has_background;
    if (!s->values->light_none || lit || s->values->has_background) return;
    report_warning("leave out --light none, or give the file a light",
                   "%s has no light: the picture will be black", session_label(s->input));
}

/* A model made elsewhere may look past what matters; -v says how to see all of it. */
static void say_camera(const stage *s, const snell_scene_stats *has) {
    if (report_level() < LEVEL_VERBOSE || has->camera_count == 0 || s->values->has_view) return;
    if (strcmp(has->format, "lua") == 0) return;
    report_note("seen by the file's own camera; --view iso frames the whole model");
}

static int commit(stage *s) {
    return stage_status(s, snell_scene_commit(s->scene, progress_report, NULL));
}

/* As texels: surroundings have no alpha, and a broken pixel gives no light. */
static float *surroundings(const snell_film *film, snell_image_texture_desc *image) {
    uint32_t width, height, channels;
    const float *pixels = snell_film_pixels(film, &width, &height, &channels);
    size_t count = (size_t)width * height;
    float *texels = malloc(count * 4 * sizeof *texels);
    for (size_t i = 0; texels != NULL && i < count; i++) {
        for (size_t k = 0; k < 3; k++) {
            float x = pixels[i * channels + k];
            texels[4 * i + k] = x > 0 && isfinite(x) ? x : 0;
        }
        texels[4 * i + 3] = 1;
    }
    image->width = (int32_t)width;
    image->height = (int32_t)height;
    image->format = SNELL_IMAGE_TEXTURE_FORMAT_RGBA32F;
    image->pixels = texels;
    image->pixels_count = count * 4 * sizeof *texels;
    return texels;
}

/* --light IMAGE: all around, and seen unless there is a background by value. */
int stage_add_light(stage *s) {
    if (s->values->light_image == NULL) return EXIT_DONE;
    picture_file picture;
    snell_image_texture_desc image = SNELL_INIT(image_texture_desc);
    snell_environment_light_desc light = SNELL_INIT(environment_light_desc);
    snell_light_id id;
    int code = picture_open(s->session, s->values->light_image, &picture);
    if (code != EXIT_DONE) return code;
    float *texels = surroundings(picture.film, &image);
    if (texels == NULL) code = report_error(EXIT_MEMORY, NULL, "out of memory");
    if (code == EXIT_DONE)
        code = stage_status(
            s, snell_scene_add_image_texture(s->scene, &image, &light.radiance.texture));
    light.visible = !s->values->has_background;
    if (code == EXIT_DONE)
        code = stage_status(s, snell_scene_add_environment_light(s->scene, &light, &id));
    free(texels);
    picture_close(&picture);
    return code;
}

int stage_load(stage *s, bool hashed) {
    int code = session_load(s->session, s->input, &s->scene);
    if (code == EXIT_DONE) code = stage_add_light(s);
    if (code == EXIT_DONE && hashed) code = stage_status(s, snell_scene_hash(s->scene, &s->hash));
    return code;
}

/* The ground comes after the framing: it is larger than what stands on it. The background comes
 * after the studio, which takes one for a sign that the scene is lit. */
static int dress(stage *s) {
    const render_values *v = s->values;
    snell_instance_id id;
    int code = EXIT_DONE;
    if (v->light_sky)
        code = stage_status(
            s, snell_scene_add_daylight(s->scene, s->desc.view, !v->has_background, &s->studio));
    else if (!v->light_none && v->light_image == NULL)
        code = stage_status(s, snell_scene_add_studio(s->scene, s->desc.view, &s->studio));
    if (code == EXIT_DONE && v->has_background) {
        code = stage_status(s, snell_scene_set_background(s->scene, v->background, 1));
    }
    if (code == EXIT_DONE && v->has_ground) {
        code = stage_status(s, snell_scene_add_ground(s->scene, v->ground, &id));
    }
    return code;
}

/* The camera, and the studio's lights, which go where a turntable's camera goes. */
static int look(stage *s, bool first) {
    bool turns = s->values->turntable > 0;
    s->desc = s->usual;
    int code = choose_camera(s);
    if (code == EXIT_DONE) code = choose_view(s);
    if (code == EXIT_DONE && first && turns)
        code = stage_status(s, snell_scene_bounds(s->scene, &s->bounds));
    if (code == EXIT_DONE && first) code = dress(s);
    if (code == EXIT_DONE && turns) code = turn_view(s);
    if (code == EXIT_DONE && turns)
        code = stage_status(s, snell_scene_turn_studio(s->scene, turned(s)));
    return code;
}

int stage_look_again(stage *s) { return look(s, false); }

int stage_prepare(stage *s) {
    snell_scene_stats stats = {.struct_size = sizeof stats};
    int code = stage_status(s, snell_scene_get_stats(s->scene, &stats));
    s->camera_count = stats.camera_count;
    if (code == EXIT_DONE && stats.instance_count == 0 && s->camera_count == 0) {
        code = report_error(EXIT_INPUT, "it has neither shapes nor a camera",
                            "%s: there is nothing to see", session_label(s->input));
    }
    if (code == EXIT_DONE) code = apply_settings(s);
    s->usual = s->desc;
    if (code == EXIT_DONE) code = look(s, true);
    if (code == EXIT_DONE) code = commit(s);
    if (code == EXIT_DONE) {
        warn_of_darkness(s, &stats);
        say_camera(s, &stats);
        say_added(s, &stats);
    }
    return code == EXIT_DONE ? report_strict() : code;
}

void stage_set_frame(session *of, const render_values *values, uint32_t frame) {
    bool turns = values->turntable > 0;
    of->frame = turns ? 0 : frame;
    of->turn = turns ? frame : 0;
}

snell_image_desc stage_image(const stage *s) {
    snell_image_desc image = SNELL_INIT(image_desc);
    image.tonemap = s->options->value[OPT_TONEMAP];
    image.exposure = s->values->exposure;
    image.exposure_set = s->values->has_exposure;
    if (s->values->has_white_balance) image.white_balance = s->values->white_balance;
    image.bits = s->values->bits;
    image.quality = s->values->quality;
    return image;
}
