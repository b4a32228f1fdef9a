/* snell render: load, light, commit, render, write, one file after the other. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "commands.h"
#include "output.h"
#include "progress.h"
#include "report.h"
#include "session.h"
#include "stage.h"
#include "tag.h"
#include "text.h"
#include "values.h"

typedef struct job {
    stage stage;
    output output;
    snell_film *film;
    snell_render_stats stats;
    char *partial;
    bool rendered;
    double load, build, render, write;
} job;

/* ---- render and write ---- */

static int write_picture(job *j, bool partial) {
    snell_image_desc image = stage_image(&j->stage);
    char *tag = NULL;
    if (j->stage.options->value[OPT_STRIP] == NULL) {
        tag = tag_make(j->stage.options, j->stage.input, j->stage.hash, &j->stage.desc, j->film,
                       j->stage.session->frame, partial);
        if (tag == NULL) return report_error(EXIT_MEMORY, NULL, "out of memory");
    }
    image.tag = tag;
    int code = partial ? output_write_partial(&j->output, j->film, &image, &j->partial)
                       : output_write(&j->output, j->film, &image);
    free(tag);
    return code;
}

static bool in_rounds(const job *j) {
    return j->stage.desc.noise > 0 || j->stage.desc.time_limit > 0;
}

static int render_and_write(job *j) {
    double start = progress_seconds();
    snell_status status = snell_render(j->stage.scene, &j->stage.desc, j->film);
    j->render = progress_seconds() - start;
    j->stats = (snell_render_stats){.struct_size = sizeof j->stats};
    bool stopped = status == SNELL_CANCELLED;
    if (status != SNELL_OK && !stopped) {
        return report_status(status, session_label(j->stage.input));
    }
    snell_status counted = snell_film_get_stats(j->film, &j->stats);
    if (counted != SNELL_OK) return report_status(counted, NULL);
    /* What was chosen on the way: the same again gives the same picture. Stopped before a bound was
     * reached, it is still to be. */
    bool chosen = j->stage.desc.noise > 0 ? !stopped : j->stats.samples_done > 0;
    if (in_rounds(j) && chosen) j->stage.desc.samples = (uint32_t)j->stats.samples_done;
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
    int code = output_plan(&j->output, j->stage.options, j->stage.input,
                           j->stage.values->many_frames ? j->stage.session->frame : 0);
    if (code == EXIT_DONE) code = session_load(j->stage.session, j->stage.input, &j->stage.scene);
    j->load = progress_seconds();
    if (code == EXIT_DONE && j->stage.options->value[OPT_STRIP] == NULL)
        code = stage_status(&j->stage, snell_scene_hash(j->stage.scene, &j->stage.hash));
    if (code == EXIT_DONE) code = stage_prepare(&j->stage);
    if (code == EXIT_DONE) code = output_check_aovs(&j->output, j->stage.desc.aov);
    j->build = progress_seconds() - j->load;
    if (code == EXIT_DONE) code = render_and_write(j);
    progress_end();
    snell_scene_destroy(j->stage.scene);
    j->stage.scene = NULL;
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

/* With a picture that holds them their names, else their files. */
static void say_aovs(const job *j) {
    snell_aov aov;
    char text[400] = "";
    for (uint32_t i = 0; snell_film_aov(j->film, i, &aov) && strlen(text) < 300; i++) {
        char *file = output_has_aov_files(&j->output) ? output_aov_path(j->output.path, aov.name)
                                                      : strdup(aov.name);
        size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "%s%.90s", i > 0 ? ", " : "",
                 file != NULL ? file : aov.name);
        free(file);
        if (strlen(text) >= 300) snprintf(text + strlen(text), 8, ", ..");
    }
    if (text[0] != '\0') report_note("with %s", text);
}

/* Two digits, rounded up: a bound is never said to be smaller than it is. */
static double percent_up(double bound) {
    if (!(bound > 0)) return 0;
    double unit = pow(10, floor(log10(100 * bound)) - 1);
    return ceil(100 * bound / unit - 1e-6) * unit;
}

static void format_samples(const job *j, char *out, size_t size) {
    const snell_render_stats *s = &j->stats;
    if (s->noise_blocks == 0) {
        snprintf(out, size, "%" PRIu32 " sample%s", j->stage.desc.samples,
                 j->stage.desc.samples == 1 ? "" : "s");
        return;
    }
    int used = snprintf(out, size, "error under %.3g %% (%g %% confidence)",
                        percent_up(s->noise_bound), 100 * s->noise_confidence);
    if (s->noise_blocks_done < s->noise_blocks)
        used += snprintf(out + used, size - (size_t)used, ", under %g %% in %.3g %% of blocks",
                         100 * (double)j->stage.desc.noise,
                         floor(1000 * (double)s->noise_blocks_done / (double)s->noise_blocks) / 10);
    if (s->samples_min == s->samples_done)
        snprintf(out + used, size - (size_t)used, "  %" PRIu64 " samples", s->samples_done);
    else
        snprintf(out + used, size - (size_t)used, "  %" PRIu64 " to %" PRIu64 " samples, mean %.*f",
                 s->samples_min, s->samples_done, s->samples_mean < 100 ? 1 : 0, s->samples_mean);
}

static void say_done(const job *j) {
    uint32_t width = 0, height = 0;
    snell_film_pixels(j->film, &width, &height, NULL);
    const char *name = strcmp(j->output.path, "-") == 0 ? "standard output" : j->output.path;
    if (report_level() >= LEVEL_VERBOSE) {
        char memory[32];
        text_format_bytes(session_memory_peak(RUSAGE_SELF), memory);
        report_note("load %.2f  build %.2f  render %.2f  write %.2f s   %.3g rays  %.2f Mrays/s  "
                    "%" PRIu32 " threads  %s  %s",
                    j->load, j->build, j->render, j->write, (double)rays_total(&j->stats),
                    rays_per_second(&j->stats) * 1e-6,
                    snell_context_thread_count(j->stage.session->context),
                    snell_isa_name(snell_context_isa(j->stage.session->context)), memory);
    }
    double total = progress_seconds();
    say_aovs(j);
    char samples[160];
    format_samples(j, samples, sizeof samples);
    report_note("%s  %" PRIu32 "x%" PRIu32 "  %s  %s  %.*f s", name, width, height,
                integrator_name(j->stage.desc.integrator), samples, total < 10 ? 2 : 1, total);
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

static void json_aovs(json_t *root, const job *j) {
    json_t *list = json_array();
    snell_aov aov;
    for (uint32_t i = 0; snell_film_aov(j->film, i, &aov); i++) {
        json_t *item = json_object(), *channels = json_array();
        char name[256];
        for (uint32_t c = 0; c < aov.channel_count; c++)
            if (snell_film_aov_channel(j->film, i, c, name, sizeof name) == SNELL_OK)
                json_array_append_new(channels, report_text(name));
        char *file = output_has_aov_files(&j->output) ? output_aov_path(j->output.path, aov.name)
                                                      : strdup(j->output.path);
        json_object_set_new(item, "name", report_text(aov.name));
        json_object_set_new(item, "channels", channels);
        json_object_set_new(item, "output", report_text(file != NULL ? file : ""));
        json_array_append_new(list, item);
        free(file);
    }
    json_object_set_new(root, "aovs", list);
}

static void json_picture(json_t *root, const job *j) {
    uint32_t width = 0, height = 0;
    char hash[32], weight[32];
    snell_film_pixels(j->film, &width, &height, NULL);
    json_object_set_new(root, "output", report_text(j->output.path));
    set_count(root, "width", width);
    set_count(root, "height", height);
    if (j->stats.noise_blocks > 0) json_object_set_new(root, "noise", tag_noise(&j->stats));
    json_object_set_new(root, "integrator", json_string(integrator_name(j->stage.desc.integrator)));
    set_count(root, "samples", j->stage.desc.samples);
    set_count(root, "max_depth", j->stage.desc.max_depth);
    text_format_float(j->stage.desc.min_weight, weight);
    json_object_set_new(root, "min_weight", json_real(strtod(weight, NULL)));
    set_count(root, "seed", j->stage.desc.seed);
    if (j->stage.session->frame > 0) set_count(root, "frame", j->stage.session->frame);
    json_seconds(root, j);
    json_rays(root, &j->stats);
    set_count(root, "threads", snell_context_thread_count(j->stage.session->context));
    json_object_set_new(root, "isa",
                        json_string(snell_isa_name(snell_context_isa(j->stage.session->context))));
    set_count(root, "memory_peak", session_memory_peak(RUSAGE_SELF));
    set_count(root, "memory_peak_import", session_memory_peak(RUSAGE_CHILDREN));
    json_object_set_new(root, "dropped_weight", json_real(j->stats.dropped_weight));
    snprintf(hash, sizeof hash, "%016" PRIx64, snell_film_hash(j->film));
    json_object_set_new(root, "image_hash", json_string(hash));
    json_aovs(root, j);
    json_object_set_new(root, "added", report_text(j->stage.added));
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
    json_object_set_new(root, "file", report_text(j->stage.input));
    if (j->rendered) json_picture(root, j);
    if (j->partial != NULL) json_object_set_new(root, "partial", report_text(j->partial));
    if (error == NULL && signals_caught() != 0 && !j->rendered) error = json_stopped();
    if (error != NULL) json_object_set_new(root, "error", error);
    json_object_set_new(root, "warnings", report_take_warnings());
    return root;
}

static int render_file(session *s, const render_values *values, const char *input, snell_film *film,
                       json_t **result) {
    job j = {.stage = {.options = s->options, .values = values, .session = s, .input = input},
             .film = film};
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
    const char *aov = o->value[OPT_AOV];
    if (aov != NULL && strcmp(aov, "list") == 0) return help_aovs();
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
