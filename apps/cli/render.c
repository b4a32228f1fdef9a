/* snell render: load, light, commit, render, write, one file after the other. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "batch.h"
#include "commands.h"
#include "output.h"
#include "progress.h"
#include "report.h"
#include "session.h"
#include "stage.h"
#include "tag.h"
#include "text.h"
#include "values.h"

/* An animation so far. */
typedef struct movie_progress {
    output output; /* of the file */
    char *partial; /* where it ended instead */
    uint32_t frames, width, height, samples;
    double fps, seconds;
    snell_integrator integrator;
} movie_progress;

/* What all pictures of a command share. */
typedef struct run {
    const options *options;
    const render_values *values;
    session *session;
    snell_film *film;
    json_t *results;
    size_t pictures, failed, planned;
    stage kept; /* prepared for the next view of the same scene; no scene: none is */
    uint32_t kept_frame;
    snell_movie *movie; /* NULL: none is begun */
    movie_progress done;
} run;

typedef struct job {
    stage stage;
    output output;
    run *run;
    snell_film *film;
    snell_render_stats stats;
    char *partial;
    bool rendered, movie;
    double load, build, render, write;
} job;

/* ---- render and write ---- */

static int write_picture(job *j, bool partial) {
    snell_image_desc image = stage_image(&j->stage);
    char *tag = NULL;
    if (j->stage.options->value[OPT_STRIP] == NULL) {
        tag = tag_make(&j->stage, j->film, partial);
        if (tag == NULL) return report_error(EXIT_MEMORY, NULL, "out of memory");
    }
    image.tag = tag;
    int code = partial ? output_write_partial(&j->output, j->film, &image, &j->partial)
                       : output_write(&j->output, j->film, &image);
    free(tag);
    return code;
}

static bool write_standard(void *user, const void *data, size_t size) {
    (void)user;
    return fwrite(data, 1, size, stdout) == size && fflush(stdout) == 0;
}

/* The first frame begins the file. `asked`: as the render was described. */
static int begin_movie(job *j, const snell_image_desc *image, const snell_render_desc *asked) {
    movie_progress *done = &j->run->done;
    snell_animation clock = {.struct_size = sizeof clock};
    snell_status status = snell_scene_get_animation(j->stage.scene, &clock);
    if (status != SNELL_OK) return report_status(status, NULL);
    double fps = j->stage.values->fps;
    if (fps == 0) fps = clock.frame_count > 0 ? (double)clock.fps : 24;
    bool standard = output_is_standard(&j->output);
    snell_image_desc first = *image;
    char *tag = NULL;
    if (j->stage.options->value[OPT_STRIP] == NULL) {
        tag = tag_make_movie(&j->stage, asked, j->film, fps);
        if (tag == NULL) return report_error(EXIT_MEMORY, NULL, "out of memory");
    }
    first.tag = tag;
    snell_movie_desc desc = SNELL_INIT(movie_desc);
    desc.format = j->output.format.name;
    desc.fps = fps;
    desc.image = &first;
    desc.write = write_standard;
    const char *chroma = j->stage.options->value[OPT_CHROMA]; /* 420 or 444 */
    if (chroma != NULL) desc.chroma = (uint32_t)strtoul(chroma, NULL, 10);
    status = snell_movie_create(standard ? NULL : j->output.path, &desc, &j->run->movie);
    free(tag);
    if (status != SNELL_OK) return report_status(status, j->output.path);
    done->output = j->output; /* its path goes with it */
    j->output.path = strdup(j->output.path);
    done->fps = fps;
    done->integrator = j->stage.desc.integrator;
    return j->output.path != NULL ? EXIT_DONE : report_error(EXIT_MEMORY, NULL, "out of memory");
}

static int add_frame(job *j, const snell_render_desc *asked) {
    movie_progress *done = &j->run->done;
    snell_image_desc image = stage_image(&j->stage);
    int code = j->run->movie == NULL ? begin_movie(j, &image, asked) : EXIT_DONE;
    if (code != EXIT_DONE) return code;
    snell_status status = snell_movie_add(j->run->movie, j->film, &image);
    if (status != SNELL_OK) return report_status(status, j->output.path);
    snell_film_pixels(j->film, &done->width, &done->height, NULL);
    done->frames++;
    if (j->stage.desc.samples > done->samples) done->samples = j->stage.desc.samples;
    return EXIT_DONE;
}

static bool in_rounds(const job *j) {
    return j->stage.desc.noise > 0 || j->stage.desc.time_limit > 0;
}

static int render_and_write(job *j) {
    double start = progress_seconds();
    const snell_render_desc asked = j->stage.desc;
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
    if (stopped) { /* an animation keeps its whole frames */
        code = j->movie ? EXIT_DONE : write_picture(j, true);
        if (code == EXIT_DONE) code = EXIT_SOME_FAILED;
    } else if (code == EXIT_DONE) {
        code = j->movie ? add_frame(j, &asked) : write_picture(j, false);
        j->rendered = code == EXIT_DONE;
    }
    j->write = progress_seconds() - start;
    return code;
}

static int plan(job *j, const bool whole) {
    uint32_t frame = j->stage.session->turn > 0 ? j->stage.session->turn : j->stage.session->frame;
    bool numbered = j->stage.values->many_frames && !j->movie;
    return output_plan(
        &j->output, j->stage.options,
        &(output_subject){j->stage.input, whole, numbered ? frame : 0, j->stage.camera});
}

/* What is said of a file is said once, not again for its next view. */
static bool is_next_view(const job *j) {
    const session *s = j->stage.session;
    return s->camera > 0 || s->turn > j->stage.values->frame_first;
}

static void forget_scene(run *r) {
    snell_scene_destroy(r->kept.scene);
    r->kept.scene = NULL;
}

/* Where only the camera is another one, the scene is the one of the picture before. */
static int prepare(job *j) {
    run *r = j->run;
    stage *s = &j->stage;
    if (r->kept_frame != s->session->frame) forget_scene(r);
    if (r->kept.scene != NULL) {
        *s = r->kept;
        r->kept.scene = NULL;
        return stage_look_again(s);
    }
    int code = stage_load(s, s->options->value[OPT_STRIP] == NULL);
    j->load = progress_seconds();
    return code == EXIT_DONE ? stage_prepare(s) : code;
}

/* The next picture may want the scene; not one that something is wrong with. */
static void keep_scene(job *j, bool well) {
    const render_values *v = j->stage.values;
    run *r = j->run;
    if (well && (v->turntable > 0 || v->all_cameras)) {
        r->kept = j->stage;
        r->kept_frame = j->stage.session->frame;
    } else {
        snell_scene_destroy(j->stage.scene);
    }
    j->stage.scene = NULL;
}

static int run_job(job *j, bool whole) {
    /* The name of a camera is known when the file is read. */
    bool early = !j->stage.values->all_cameras;
    int code = early ? plan(j, whole) : EXIT_DONE;
    report_mute(is_next_view(j));
    if (code == EXIT_DONE) code = prepare(j);
    report_mute(false);
    if (code == EXIT_DONE && !early) code = plan(j, whole);
    if (code == EXIT_DONE) code = output_check_size(&j->output, &j->stage.desc);
    if (code == EXIT_DONE) code = output_check_aovs(&j->output, j->stage.desc.aov);
    j->build = progress_seconds() - j->load;
    if (code == EXIT_DONE) code = render_and_write(j);
    progress_end();
    keep_scene(j, code == EXIT_DONE);
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

/* All pixels have some samples, and --noise or --time-limit wanted more. */
static void say_stopped_between(const job *j) {
    const snell_render_stats *s = &j->stats;
    char under[64] = "";
    if (s->noise_blocks > 0)
        snprintf(under, sizeof under, ", %.3g %% of the blocks under %g %%",
                 floor(1000 * (double)s->noise_blocks_done / (double)s->noise_blocks) / 10,
                 100 * (double)j->stage.desc.noise);
    report_note("stopped after %.*f samples a pixel%s; the picture is in %s",
                s->samples_mean < 100 ? 1 : 0, s->samples_mean, under, j->partial);
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
    if (in_rounds(j) && done >= 1)
        say_stopped_between(j);
    else
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
    snell_image_desc image = stage_image(&j->stage);
    float exposure;
    const char *tonemap = snell_film_look(j->film, &exposure), *white = image.white_balance;
    if (image.exposure_set) exposure = image.exposure;
    if (image.tonemap != NULL) tonemap = image.tonemap;
    if (white == NULL) white = snell_film_white_balance(j->film);
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
    uint32_t frame = j->stage.session->turn > 0 ? j->stage.session->turn : j->stage.session->frame;
    if (frame > 0) set_count(root, "frame", frame);
    if (j->stage.camera[0] != '\0')
        json_object_set_new(root, "camera", report_text(j->stage.camera));
    json_object_set_new(root, "exposure", json_real((double)exposure));
    json_object_set_new(root, "tonemap", json_string(tonemap));
    json_object_set_new(root, "white_balance", report_text(white));
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

/* ---- animations ---- */

static void say_movie(const run *r, uint32_t wanted) {
    const movie_progress *m = &r->done;
    const char *name = output_is_standard(&m->output) ? "standard output" : m->output.path;
    if (m->frames < wanted) {
        report_note(m->partial != NULL || output_is_standard(&m->output)
                        ? "stopped after %" PRIu32 " of %" PRIu32 " frames; they are in %s"
                        : "stopped after %" PRIu32 " of %" PRIu32 " frames; nothing was written",
                    m->frames, wanted, m->partial != NULL ? m->partial : name);
        return;
    }
    report_note("%s  %" PRIu32 "x%" PRIu32 "  %" PRIu32 " frames, %.6g a second  %s  %" PRIu32
                " sample%s  %.*f s",
                name, m->width, m->height, m->frames, m->fps, integrator_name(m->integrator),
                m->samples, m->samples == 1 ? "" : "s", m->seconds < 10 ? 2 : 1, m->seconds);
}

/* The whole file, or what is done of it in OUT.partial.EXT. `before`: how the frames ended; a disk that
 * is full for a frame is full here too, and was reported. */
static int end_movie(run *r, uint32_t wanted, int before) {
    movie_progress *m = &r->done;
    int code = EXIT_DONE;
    if (r->movie == NULL) return EXIT_DONE; /* not even one frame */
    bool partial = m->frames < wanted && !output_is_standard(&m->output);
    char *path = partial ? output_partial_path(&m->output) : NULL;
    if (partial && path == NULL) code = report_error(EXIT_MEMORY, NULL, "out of memory");
    if (partial && code == EXIT_DONE) code = output_check_owner(&m->output, path);
    if (code == EXIT_DONE && m->frames > 0) {
        snell_status status = snell_movie_finish(r->movie, path);
        if (status != SNELL_OK)
            code = before == EXIT_IO ? before : report_status(status, m->output.path);
        if (status == SNELL_OK && partial) {
            m->partial = path;
            path = NULL;
        }
    } else {
        snell_movie_destroy(r->movie);
    }
    r->movie = NULL;
    free(path);
    say_movie(r, wanted);
    return code;
}

/* ---- the command ---- */

/* Gives the number of cameras that --camera all has to visit. */
static int render_picture(run *r, const char *input, bool whole, bool movie, uint32_t *cameras) {
    job j = {.stage = {.options = r->options,
                       .values = r->values,
                       .session = r->session,
                       .input = input},
             .run = r,
             .movie = movie,
             .film = r->film};
    if (r->pictures > 0) report_begin();
    progress_part(r->pictures++, r->values->many_frames ? r->planned : 1);
    progress_begin(session_label(input));
    int code = run_job(&j, whole);
    r->failed += code != EXIT_DONE && signals_caught() == 0; /* one that was stopped did not fail */
    r->done.seconds += progress_seconds();
    if (j.rendered && !movie)
        say_done(&j);
    else if (!j.rendered && !movie && signals_caught() != 0)
        say_stopped(&j);
    if (report_json()) json_array_append_new(r->results, json_job(&j));
    *cameras = j.stage.camera_count;
    output_free(&j.output);
    free(j.partial);
    return code;
}

/* All frames of an input, seen by the session's camera. */
static int render_frames(run *r, const char *input, bool whole, uint32_t *cameras) {
    const render_values *v = r->values;
    bool movie = output_is_movie(r->options, v->many_frames);
    uint32_t frames = v->many_frames ? v->frame_last - v->frame_first + 1 : 1;
    int code = EXIT_DONE;
    for (uint32_t i = 0; i < frames && signals_caught() == 0; i++) {
        if (v->frame_first > 0) stage_set_frame(r->session, v, v->frame_first + i);
        code = render_picture(r, input, whole, movie, cameras);
        if (movie && code != EXIT_DONE) break; /* a film with a hole in it helps nobody */
        if (code == EXIT_USAGE) break;         /* the next do not exist either */
    }
    int ended = movie ? end_movie(r, frames, code) : EXIT_DONE;
    r->failed += code == EXIT_DONE && ended != EXIT_DONE;
    output_free(&r->done.output);
    if (report_json() && r->done.partial != NULL)
        json_object_set_new(json_array_get(r->results, json_array_size(r->results) - 1), "partial",
                            report_text(r->done.partial));
    free(r->done.partial);
    r->done = (movie_progress){.frames = 0};
    return code != EXIT_DONE ? code : ended;
}

static int render_cameras(run *r, const char *input, bool whole) {
    uint32_t cameras = 1;
    int code = EXIT_DONE;
    r->session->camera = 0;
    do {
        code = render_frames(r, input, whole, &cameras);
    } while (r->values->all_cameras && ++r->session->camera < cameras && signals_caught() == 0);
    forget_scene(r);
    return code;
}

static void say_all(const run *r, const batch *b) {
    bool files = r->pictures == b->options.operands.count;
    if (r->failed > 0 && r->pictures > 1)
        report_note("%zu of %zu %s failed", r->failed, r->pictures, files ? "files" : "pictures");
    if (b->others > 0)
        report_note("%zu other file%s in the folder%s left alone: no model%s", b->others,
                    b->others == 1 ? "" : "s", b->folders == 1 ? "" : "s",
                    b->others == 1 ? "" : "s");
}

static int emit(run *r, const batch *b, int code) {
    if (!report_json() || json_array_size(r->results) == 0) return code;
    json_t *root = json_incref(json_array_get(r->results, 0));
    if (r->pictures > 1 || b->folders > 0) {
        json_decref(root);
        root = json_object();
        json_object_set_new(root, "schema", json_integer(1));
        set_count(root, "failed", r->failed);
        if (b->folders > 0) set_count(root, "others", b->others);
        json_object_set(root, "files", r->results);
    }
    return report_emit(root, code);
}

static int render_all(session *s, const render_values *values, const batch *b) {
    run r = {.options = &b->options, .values = values, .session = s, .results = json_array()};
    const string_list *files = &b->options.operands;
    uint32_t frames = values->many_frames ? values->frame_last - values->frame_first + 1 : 1;
    r.planned = files->count * frames;
    if (values->many_frames && values->turntable == 0) s->frame_last = values->frame_last;
    snell_status status = snell_film_create(s->context, &r.film);
    int code = status == SNELL_OK ? EXIT_DONE : report_status(status, NULL);
    for (size_t i = 0; r.film != NULL && i < files->count && signals_caught() == 0; i++)
        code = render_cameras(&r, files->items[i], b->whole[i]);
    if (r.pictures > 1) code = r.failed > 0 ? EXIT_SOME_FAILED : EXIT_DONE;
    if (r.pictures > 1 || b->others > 0) say_all(&r, b);
    snell_film_destroy(r.film);
    code = emit(&r, b, code);
    json_decref(r.results);
    return code;
}

static int render_batch(const batch *b) {
    const options *o = &b->options;
    render_values values;
    int code = values_read(o, &values);
    if (code == EXIT_DONE) code = output_check_all(o, &values, b->whole);
    if (code != EXIT_DONE) return code;
    signals_setup();
    progress_setup(o->value[OPT_PROGRESS]);
    session s;
    code = session_open(&s, o);
    if (code == EXIT_DONE) code = render_all(&s, &values, b);
    session_close(&s);
    return code;
}

int render_command(const options *o) {
    const char *aov = o->value[OPT_AOV];
    if (aov != NULL && strcmp(aov, "list") == 0) return help_aovs();
    if (o->operands.count == 0) {
        return report_usage("such as: snell render duck.glb; 'snell example' prints scenes",
                            "render needs a FILE");
    }
    batch b;
    int code = batch_open(o, &b);
    if (code == EXIT_DONE) code = render_batch(&b);
    batch_free(&b);
    return code;
}
