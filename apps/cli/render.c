/* snell render: load, light, commit, render, write, one file after the other. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "commands.h"
#include "output.h"
#include "progress.h"
#include "report.h"
#include "session.h"
#include "tag.h"
#include "text.h"
#include "values.h"

/* The direction (1, .6, 1.4) of a model that brings no camera, as azimuth atan2(1, 1.4) and
 * elevation atan(.6 / sqrt(1 + 1.4^2)). */
static const float default_view[2] = {0.62024949f, 0.33555448f};
static const float default_fov = 0.69813170f; /* 40 degrees */

typedef struct job {
    const options *options;
    const render_values *values;
    session *session;
    const char *input; /* as typed */
    output output;
    snell_scene *scene;
    snell_film *film;
    snell_render_desc desc;
    snell_view view;
    snell_render_stats stats;
    const char *studio; /* what it added */
    char added[96];
    char *partial;
    bool rendered;
    double load, build, render, write;
} job;

static int status_of(const job *j, snell_status status) {
    if (signals_caught() != 0) return EXIT_SOME_FAILED;
    return status == SNELL_OK ? EXIT_DONE : report_status(status, session_label(j->input));
}

/* ---- the picture's settings ---- */

static uint32_t scaled(uint32_t side, uint32_t numerator, uint32_t denominator) {
    uint64_t value = ((uint64_t)side * numerator + denominator / 2) / denominator;
    return value < 1 ? 1 : value > UINT32_MAX ? UINT32_MAX : (uint32_t)value;
}

static int apply_size(job *j) {
    const render_values *v = j->values;
    snell_render_desc *d = &j->desc;
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
                                j->options->value[OPT_CROP], d->width, d->height);
        }
        d->crop_x = v->crop_x;
        d->crop_y = v->crop_y;
        d->crop_width = v->crop_width;
        d->crop_height = v->crop_height;
    }
    return EXIT_DONE;
}

static int apply_settings(job *j) {
    const render_values *v = j->values;
    snell_render_desc *d = &j->desc;
    *d = (snell_render_desc){.struct_size = sizeof *d};
    int code = status_of(j, snell_scene_settings(j->scene, v->integrator, d));
    if (code != EXIT_DONE) return code;
    if (v->samples > 0) {
        d->samples = v->samples;
        d->pixel_center = v->samples == 1;
    }
    if (v->has_max_depth) d->max_depth = v->max_depth;
    if (v->has_min_weight) d->min_weight = v->min_weight;
    if (v->has_seed) d->seed = v->seed;
    if (v->transparent) d->transparent = true;
    if (v->has_filter) { /* another filter has another radius */
        if (v->filter != d->filter) d->filter_radius = 0;
        d->filter = v->filter;
    }
    if (v->filter_radius > 0) d->filter_radius = v->filter_radius;
    d->progress = progress_report;
    return apply_size(j);
}

/* ---- the camera ---- */

static int no_camera(const job *j, uint32_t count, const char *wanted) {
    const char *names[64];
    size_t used = 0;
    snell_object_info info;
    char hint[200];
    for (uint32_t i = 0; i < count && used < 64; i++) {
        if (snell_scene_get_camera(j->scene, i, &info, NULL) == SNELL_OK) names[used++] = info.name;
    }
    const char *near = text_closest(wanted, names, used);
    if (near != NULL)
        snprintf(hint, sizeof hint, "did you mean '%.120s'?", near);
    else
        snprintf(hint, sizeof hint, "it has %" PRIu32 "; 'snell info' lists them", count);
    return report_usage(hint, "--camera: %s has no camera '%s'", session_label(j->input), wanted);
}

static int choose_camera(job *j, uint32_t count) {
    const char *wanted = j->options->value[OPT_CAMERA];
    uint64_t number = 0;
    if (wanted == NULL) return EXIT_DONE;
    for (uint32_t i = 0; i < count; i++) {
        snell_object_info info;
        snell_camera_id id;
        int code = status_of(j, snell_scene_get_camera(j->scene, i, &info, &id));
        if (code != EXIT_DONE) return code;
        if (strcmp(info.name, wanted) != 0) continue;
        j->desc.camera = id;
        return EXIT_DONE;
    }
    if (!text_uint(wanted, 1, count, &number)) return no_camera(j, count, wanted);
    snell_object_info info;
    return status_of(
        j, snell_scene_get_camera(j->scene, (uint32_t)(number - 1), &info, &j->desc.camera));
}

/* Frames everything, for --view and for files without a camera; where there are only planes, a
 * box around the origin. */
static int frame_all(job *j) {
    const render_values *v = j->values;
    const float *at = v->has_view ? v->view : default_view;
    snell_bounds bounds;
    int code = status_of(j, snell_scene_bounds(j->scene, &bounds));
    if (code != EXIT_DONE) return code;
    j->view = SNELL_INIT(view);
    j->view.fov = v->fov > 0 ? v->fov : default_fov;
    float aspect = (float)j->desc.width / (float)j->desc.height;
    return status_of(j, snell_view_frame(&j->view, &bounds, at[0], at[1], aspect));
}

/* A file without a camera gets one, so that the studio lights for it; a file's own gives way to
 * --view by value, and --fov changes no more than its angle. */
static int choose_view(job *j, bool own_camera) {
    const render_values *v = j->values;
    int code = EXIT_DONE;
    if (v->has_view || !own_camera) {
        code = frame_all(j);
    } else if (v->fov > 0) {
        code = status_of(j, snell_scene_get_view(j->scene, j->desc.camera, &j->view));
        j->view.fov = v->fov;
    } else {
        return EXIT_DONE;
    }
    j->desc.view = &j->view;
    if (code == EXIT_DONE && !own_camera) {
        snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
        camera.from = j->view.from;
        camera.at = j->view.at;
        camera.up = j->view.up;
        camera.fov = j->view.fov;
        code = status_of(j, snell_scene_add_perspective_camera(j->scene, &camera, &j->desc.camera));
    }
    return code;
}

/* ---- load and light ---- */

/* What the file lacked; a background that the command line gave was not added by the studio. */
static void say_added(job *j, bool own_camera) {
    static const char background[] = "background";
    char studio[64];
    snprintf(studio, sizeof studio, "%s", j->studio == NULL ? "" : j->studio);
    size_t length = strlen(studio), cut = sizeof background - 1;
    if (j->values->has_background && length >= cut &&
        strcmp(studio + length - cut, background) == 0) {
        studio[length > cut + 2 ? length - cut - 2 : 0] = '\0';
    }
    snprintf(j->added, sizeof j->added, "%s%s%s", own_camera ? "" : "camera",
             own_camera || studio[0] == '\0' ? "" : ", ", studio);
    if (j->added[0] != '\0') {
        const char *slash = strrchr(j->input, '/');
        report_note("added: %s (%s has none)", j->added,
                    session_label(slash != NULL && slash[1] != '\0' ? slash + 1 : j->input));
    }
}

/* --light none leaves the studio out: what is dark then should not surprise. */
static void warn_of_darkness(const job *j, const snell_scene_stats *s) {
    bool lit = s->light_count > 0 || s->has_emission || s->has_ambient || s->has_background;
    if (!j->values->light_none || lit || j->values->has_background) return;
    report_warning("leave out --light none, or give the file a light",
                   "%s has no light: the picture will be black", session_label(j->input));
}

/* A model made elsewhere may look past what matters; -v says how to see all of it. */
static void say_camera(const job *j, const snell_scene_stats *s) {
    if (report_level() < LEVEL_VERBOSE || s->camera_count == 0 || j->values->has_view) return;
    if (strcmp(s->format, "lua") == 0) return;
    report_note("seen by the file's own camera; --view iso frames the whole model");
}

static int commit(job *j) {
    return status_of(j, snell_scene_commit(j->scene, progress_report, NULL));
}

/* The ground comes after the framing: it is larger than what stands on it. The background comes
 * after the studio, which takes one for a sign that the scene is lit. */
static int dress(job *j) {
    const render_values *v = j->values;
    snell_instance_id id;
    int code = EXIT_DONE;
    if (!v->light_none) {
        const float *from = v->has_view ? v->view : NULL;
        code = status_of(j, snell_scene_add_studio(j->scene, from, &j->studio));
    }
    if (code == EXIT_DONE && v->has_background) {
        code = status_of(j, snell_scene_set_background(j->scene, v->background, 1));
    }
    if (code == EXIT_DONE && v->has_ground) {
        code = status_of(j, snell_scene_add_ground(j->scene, v->ground, &id));
    }
    return code;
}

static int prepare(job *j) {
    snell_scene_stats stats = {.struct_size = sizeof stats};
    int code = status_of(j, snell_scene_get_stats(j->scene, &stats));
    bool own_camera = stats.camera_count > 0;
    if (code == EXIT_DONE && stats.instance_count == 0 && !own_camera) {
        code = report_error(EXIT_INPUT, "it has neither shapes nor a camera",
                            "%s: there is nothing to see", session_label(j->input));
    }
    if (code == EXIT_DONE) code = apply_settings(j);
    if (code == EXIT_DONE) code = choose_camera(j, stats.camera_count);
    if (code == EXIT_DONE) code = choose_view(j, own_camera);
    if (code == EXIT_DONE) code = dress(j);
    if (code == EXIT_DONE) code = commit(j);
    if (code == EXIT_DONE) {
        warn_of_darkness(j, &stats);
        say_camera(j, &stats);
        say_added(j, own_camera);
    }
    return code == EXIT_DONE ? report_strict() : code;
}

/* ---- render and write ---- */

static snell_image_desc image_settings(const job *j) {
    snell_image_desc image = SNELL_INIT(image_desc);
    image.tonemap = j->options->value[OPT_TONEMAP];
    image.exposure = j->values->exposure;
    image.exposure_set = j->values->has_exposure;
    return image;
}

static int write_picture(job *j, bool partial) {
    snell_image_desc image = image_settings(j);
    char *tag = NULL;
    if (j->options->value[OPT_STRIP] == NULL) {
        tag = tag_make(j->options, j->input, &j->desc, j->film, j->session->frame, partial);
        if (tag == NULL) return report_error(EXIT_MEMORY, NULL, "out of memory");
    }
    image.tag = tag;
    int code = partial ? output_write_partial(&j->output, j->film, &image, &j->partial)
                       : output_write(&j->output, j->film, &image);
    free(tag);
    return code;
}

static int render_and_write(job *j) {
    double start = progress_seconds();
    snell_status status = snell_render(j->scene, &j->desc, j->film);
    j->render = progress_seconds() - start;
    j->stats = (snell_render_stats){.struct_size = sizeof j->stats};
    bool stopped = status == SNELL_CANCELLED;
    if (status != SNELL_OK && !stopped) {
        return report_status(status, session_label(j->input));
    }
    snell_status counted = snell_film_get_stats(j->film, &j->stats);
    if (counted != SNELL_OK) return report_status(counted, NULL);
    progress_end();
    start = progress_seconds();
    int code = report_strict();
    if (stopped) {
        code = write_picture(j, true);
        if (code == EXIT_DONE) code = EXIT_SOME_FAILED;
    } else if (code == EXIT_DONE) {
        code = write_picture(j, false);
        j->rendered = code == EXIT_DONE;
    }
    j->write = progress_seconds() - start;
    return code;
}

static int run_job(job *j) {
    int code = output_plan(&j->output, j->options, j->input,
                           j->values->many_frames ? j->session->frame : 0);
    if (code == EXIT_DONE) code = session_load(j->session, j->input, &j->scene);
    j->load = progress_seconds();
    if (code == EXIT_DONE) code = prepare(j);
    j->build = progress_seconds() - j->load;
    if (code == EXIT_DONE) code = render_and_write(j);
    progress_end();
    snell_scene_destroy(j->scene);
    j->scene = NULL;
    return code;
}

/* ---- what is said of it ---- */

static uint64_t rays_total(const snell_render_stats *s) {
    return s->rays_camera + s->rays_reflected + s->rays_refracted + s->rays_shadow +
           s->rays_continued;
}

static double rays_per_second(const snell_render_stats *s) {
    return s->seconds > 0 ? (double)rays_total(s) / s->seconds : 0;
}

static uint64_t memory_peak(int who) {
    struct rusage usage;
    return getrusage(who, &usage) == 0 ? (uint64_t)usage.ru_maxrss * 1024 : 0;
}

static void say_done(const job *j) {
    uint32_t width = 0, height = 0;
    snell_film_pixels(j->film, &width, &height, NULL);
    const char *name = strcmp(j->output.path, "-") == 0 ? "standard output" : j->output.path;
    if (report_level() >= LEVEL_VERBOSE) {
        char memory[32];
        text_format_bytes(memory_peak(RUSAGE_SELF), memory);
        report_note("load %.2f  build %.2f  render %.2f  write %.2f s   %.3g rays  %.2f Mrays/s  "
                    "%" PRIu32 " threads  %s  %s",
                    j->load, j->build, j->render, j->write, (double)rays_total(&j->stats),
                    rays_per_second(&j->stats) * 1e-6,
                    snell_context_thread_count(j->session->context),
                    snell_isa_name(snell_context_isa(j->session->context)), memory);
    }
    double total = progress_seconds();
    report_note("%s  %" PRIu32 "x%" PRIu32 "  %s  %" PRIu32 " sample%s  %.*f s", name, width,
                height, integrator_name(j->desc.integrator), j->desc.samples,
                j->desc.samples == 1 ? "" : "s", total < 10 ? 2 : 1, total);
}

static void say_stopped(const job *j) {
    double done = 0;
    uint32_t width = 0, height = 0;
    if (j->partial == NULL) {
        report_note("stopped; nothing was written");
        return;
    }
    snell_film_pixels(j->film, &width, &height, NULL);
    if (width > 0 && height > 0) done = (double)j->stats.pixels_done / ((double)width * height);
    report_note("stopped with %d %% of the pixels done; they are in %s", (int)(done * 100),
                j->partial);
}

static void set_count(json_t *object, const char *key, uint64_t value) {
    json_object_set_new(object, key, json_integer((json_int_t)value));
}

static void json_rays(json_t *root, const snell_render_stats *s) {
    json_t *rays = json_object(), *counters = json_object();
    set_count(rays, "camera", s->rays_camera);
    set_count(rays, "reflected", s->rays_reflected);
    set_count(rays, "refracted", s->rays_refracted);
    set_count(rays, "shadow", s->rays_shadow);
    set_count(rays, "continued", s->rays_continued);
    set_count(rays, "total", rays_total(s));
    json_object_set_new(rays, "per_second", json_real(rays_per_second(s)));
    json_object_set_new(root, "rays", rays);
    set_count(counters, "nodes", s->nodes);
    set_count(counters, "boxes", s->boxes);
    set_count(counters, "triangles", s->triangles);
    set_count(counters, "primitives", s->primitives);
    set_count(counters, "media_mismatches", s->media_mismatches);
    set_count(counters, "film_overflows", s->film_overflows);
    json_object_set_new(root, "counters", counters);
}

static void json_seconds(json_t *root, const job *j) {
    json_t *seconds = json_object();
    json_object_set_new(seconds, "load", json_real(j->load));
    json_object_set_new(seconds, "build", json_real(j->build));
    json_object_set_new(seconds, "render", json_real(j->render));
    json_object_set_new(seconds, "write", json_real(j->write));
    json_object_set_new(seconds, "total", json_real(progress_seconds()));
    json_object_set_new(root, "seconds", seconds);
}

static void json_picture(json_t *root, const job *j) {
    uint32_t width = 0, height = 0;
    char hash[32], weight[32];
    snell_film_pixels(j->film, &width, &height, NULL);
    json_object_set_new(root, "output", report_text(j->output.path));
    set_count(root, "width", width);
    set_count(root, "height", height);
    json_object_set_new(root, "integrator", json_string(integrator_name(j->desc.integrator)));
    set_count(root, "samples", j->desc.samples);
    set_count(root, "max_depth", j->desc.max_depth);
    text_format_float(j->desc.min_weight, weight);
    json_object_set_new(root, "min_weight", json_real(strtod(weight, NULL)));
    set_count(root, "seed", j->desc.seed);
    if (j->session->frame > 0) set_count(root, "frame", j->session->frame);
    json_seconds(root, j);
    json_rays(root, &j->stats);
    set_count(root, "threads", snell_context_thread_count(j->session->context));
    json_object_set_new(root, "isa",
                        json_string(snell_isa_name(snell_context_isa(j->session->context))));
    set_count(root, "memory_peak", memory_peak(RUSAGE_SELF));
    set_count(root, "memory_peak_import", memory_peak(RUSAGE_CHILDREN));
    json_object_set_new(root, "dropped_weight", json_real(j->stats.dropped_weight));
    snprintf(hash, sizeof hash, "%016" PRIx64, snell_film_hash(j->film));
    json_object_set_new(root, "image_hash", json_string(hash));
    json_object_set_new(root, "added", report_text(j->added));
}

/* The error when a signal came, which is nobody's fault. */
static json_t *json_stopped(void) {
    json_t *error = json_object();
    json_object_set_new(error, "status", json_string("cancelled"));
    json_object_set_new(error, "message", json_string("stopped by a signal"));
    json_object_set_new(error, "hint", json_string(""));
    json_object_set_new(error, "file", json_string(""));
    set_count(error, "line", 0);
    set_count(error, "column", 0);
    json_object_set_new(error, "exit", json_integer(128 + signals_caught()));
    return error;
}

static json_t *json_job(const job *j) {
    json_t *root = json_object(), *error = report_take_error();
    json_object_set_new(root, "schema", json_integer(1));
    json_object_set_new(root, "file", report_text(j->input));
    if (j->rendered) json_picture(root, j);
    if (j->partial != NULL) json_object_set_new(root, "partial", report_text(j->partial));
    if (error == NULL && signals_caught() != 0 && !j->rendered) error = json_stopped();
    if (error != NULL) json_object_set_new(root, "error", error);
    json_object_set_new(root, "warnings", report_take_warnings());
    return root;
}

static int render_file(session *s, const render_values *values, const char *input, snell_film *film,
                       json_t **result) {
    job j = {.options = s->options, .values = values, .session = s, .input = input, .film = film};
    progress_begin(session_label(input));
    int code = run_job(&j);
    if (j.rendered)
        say_done(&j);
    else if (signals_caught() != 0)
        say_stopped(&j);
    if (report_json()) *result = json_job(&j);
    output_free(&j.output);
    free(j.partial);
    return code;
}

/* ---- the command ---- */

static int render_all(session *s, const render_values *values) {
    const string_list *files = &s->options->operands;
    json_t *results = json_array(), *result = NULL;
    snell_film *film = NULL;
    size_t failed = 0;
    snell_status status = snell_film_create(s->context, &film);
    int code = status == SNELL_OK ? EXIT_DONE : report_status(status, NULL);
    size_t frames = values->many_frames ? values->frame_last - values->frame_first + 1 : 1;
    size_t count = files->count * frames;
    for (size_t i = 0; film != NULL && i < count && signals_caught() == 0; i++) {
        if (i > 0) report_begin();
        if (values->frame_first > 0) s->frame = values->frame_first + (uint32_t)(i % frames);
        progress_part(i, values->many_frames ? count : 1);
        code = render_file(s, values, files->items[i / frames], film, &result);
        failed += code != EXIT_DONE;
        if (result != NULL) json_array_append_new(results, result);
        result = NULL;
    }
    if (film != NULL && count > 1) {
        code = failed > 0 ? EXIT_SOME_FAILED : EXIT_DONE;
        if (failed > 0)
            report_note("%zu of %zu %s failed", failed, count, frames > 1 ? "pictures" : "files");
    }
    snell_film_destroy(film);
    if (report_json() && json_array_size(results) > 0) {
        json_t *root = json_incref(json_array_get(results, 0));
        if (count > 1) {
            json_decref(root);
            root = json_object();
            json_object_set_new(root, "schema", json_integer(1));
            json_object_set_new(root, "failed", json_integer((json_int_t)failed));
            json_object_set(root, "files", results);
        }
        code = report_emit(root, code);
    }
    json_decref(results);
    return code;
}

int render_command(const options *o) {
    render_values values;
    if (o->operands.count == 0) {
        return report_usage("such as: snell render duck.glb; 'snell example' prints scenes",
                            "render needs a FILE");
    }
    int code = values_read(o, &values);
    if (code == EXIT_DONE) code = output_check_all(o);
    if (code != EXIT_DONE) return code;
    signals_setup();
    progress_setup(o->value[OPT_PROGRESS]);
    session s;
    code = session_open(&s, o);
    if (code == EXIT_DONE) code = render_all(&s, &values);
    session_close(&s);
    return code;
}
