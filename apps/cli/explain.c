/* snell explain: the rays behind one pixel of a scene, or of a picture that snell made. */
#include "explain.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "progress.h"
#include "report.h"
#include "tag.h"
#include "text.h"

/* ---- words that the drawings share ---- */

const char *explain_label(const snell_object_info *info, char *out) {
    char *at = out;
    if (info->name[0] == '\0') {
        snprintf(out, EXPLAIN_LABEL, info->line > 0 ? "%s:%" PRIu32 : "%s", info->type, info->line);
        return out;
    }
    *at++ = '"';
    for (const char *c = info->name; *c != '\0' && at < out + EXPLAIN_LABEL - 8; c++)
        *at++ = (unsigned char)*c < 32 || *c == 127 || *c == '"' ? '?' : *c;
    strcpy(at, "\"");
    return out;
}

const char *explain_color(const double c[3], char *out) {
    bool grey = fabs(c[0] - c[1]) <= 1e-6 * fabs(c[0]) && fabs(c[0] - c[2]) <= 1e-6 * fabs(c[0]);
    if (grey)
        snprintf(out, EXPLAIN_COLOR, "%.3g", c[0]);
    else
        snprintf(out, EXPLAIN_COLOR, "%.3g %.3g %.3g", c[0], c[1], c[2]);
    return out;
}

const char *explain_kind(snell_ray_kind kind) {
    static const char *const words[] = {"", "camera", "reflected", "refracted", "continued"};
    return words[kind];
}

const char *explain_source(snell_light_source source) {
    static const char *const words[] = {"", "emission", "ambient", "sky", "light", "coverage"};
    return words[source];
}

double explain_angle(snell_vec3 direction, snell_vec3 normal) {
    double cosine = (double)direction.x * (double)normal.x +
                    (double)direction.y * (double)normal.y + (double)direction.z * (double)normal.z;
    cosine = fabs(cosine);
    return acos(cosine < 1 ? cosine : 1) * 180 / 3.14159265358979323846;
}

const snell_explained_ray *explain_origin(const explained *e, const snell_explained_ray *ray) {
    while (ray->kind == SNELL_RAY_CONTINUED) ray = &e->rays[ray->parent];
    return ray->parent == UINT32_MAX ? NULL : &e->rays[ray->parent];
}

bool explain_shows(const explained *e, const snell_explained_ray *ray) {
    return ray->depth <= e->levels;
}

/* ---- a picture's tag ---- */

typedef struct source {
    json_t *tag; /* NULL: a scene was given */
    const char **words;
    char *path; /* of the scene, where the tag's is beside the picture */
} source;

static void source_free(source *s) {
    json_decref(s->tag);
    free(s->words);
    free(s->path);
}

static int read_tag(const char *picture, source *out) {
    snell_picture_info info = {.struct_size = sizeof info};
    snell_status status = snell_picture_read_info(picture, &info);
    if (status != SNELL_OK) return report_status(status, picture);
    bool has_tag = info.tag != NULL && info.tag[0] != '\0';
    out->tag = has_tag ? tag_read(info.tag) : NULL;
    snell_free(info.tag);
    snell_free(info.layers);
    if (out->tag != NULL) return EXIT_DONE;
    return report_error(
        EXIT_INPUT,
        "explain the scene, with the options that made the picture: snell explain SCENE X Y",
        has_tag ? "%s was made by a snell that this one does not understand"
                : "%s does not say how it was made",
        picture);
}

/* As it was typed; else beside the picture. */
static int find_scene(const char *picture, source *s, const char **out) {
    const char *file = json_string_value(json_object_get(s->tag, "file"));
    *out = file;
    if (strcmp(file, "-") == 0) {
        if (!isatty(STDIN_FILENO)) return EXIT_DONE;
        return report_usage("give it again: snell explain PICTURE X Y < SCENE",
                            "%s was made of standard input", picture);
    }
    if (access(file, R_OK) == 0) return EXIT_DONE;
    const char *slash = strrchr(picture, '/');
    if (slash != NULL && file[0] != '/') {
        size_t folder = (size_t)(slash - picture) + 1, size = folder + strlen(file) + 1;
        s->path = malloc(size);
        if (s->path == NULL) return report_error(EXIT_MEMORY, NULL, "out of memory");
        snprintf(s->path, size, "%.*s%s", (int)folder, picture, file);
        *out = s->path;
        if (access(s->path, R_OK) == 0) return EXIT_DONE;
    }
    return report_error(EXIT_IO, "run this where the picture was made, or explain the scene itself",
                        "%s was made of '%s', which is not there", picture, file);
}

/* The picture's options join those of the command line, of which none may say otherwise. */
static int take_options(const char *picture, source *s, const options *o, options *out) {
    for (size_t i = 0; i < option_table_count; i++) {
        const option_info *info = &option_table[i];
        bool decides = (info->flags & OPTION_PICTURE) != 0 && info->id != OPT_ALLOW;
        if (info->id == OPT_FRAME && tag_has_frames(s->tag)) continue;
        if (decides && o->given[info->id] > 0)
            return report_usage("explain the scene to see it otherwise",
                                "--%s: %s says itself how it was made", info->name, picture);
    }
    if (tag_has_frames(s->tag) && o->value[OPT_FRAME] == NULL)
        return report_usage("such as --frame 1", "%s has several frames: --frame says which",
                            picture);
    const json_t *list = json_object_get(s->tag, "options");
    size_t count = json_array_size(list);
    s->words = calloc(count + 1, sizeof *s->words);
    if (s->words == NULL) return report_error(EXIT_MEMORY, NULL, "out of memory");
    for (size_t i = 0; i < count; i++) s->words[i] = json_string_value(json_array_get(list, i));
    return options_with(o, s->words, count, out);
}

/* Pictures may change between versions, so another one's may differ where its scene does not. */
static void check_version(const json_t *tag, const char *picture) {
    const char *version = json_string_value(json_object_get(tag, "snell"));
    if (strcmp(version, snell_version()) != 0)
        report_warning("render it again to be sure", "%s was made by snell %s, this is %s", picture,
                       version, snell_version());
    bool counted = json_object_get(json_object_get(tag, "noise"), "of_blocks") != NULL;
    if (json_is_true(json_object_get(tag, "partial")))
        report_note("%s was stopped before it was done: this is of the %s", picture,
                    counted ? "samples that it had" : "whole picture");
}

static int check_hash(const json_t *tag, const char *picture, const char *scene, uint64_t hash) {
    const char *made_of = json_string_value(json_object_get(tag, "scene"));
    char now[32];
    snprintf(now, sizeof now, "%016" PRIx64, hash);
    if (made_of == NULL) {
        report_warning("render it again to be sure", "%s does not tell which state of %s it shows",
                       picture, scene);
    } else if (strcmp(made_of, now) != 0) {
        return report_error(
            EXIT_INPUT,
            "render it again; or explain the scene as it is now: snell explain SCENE X Y",
            "%s, or what it loads, changed since %s was made", scene, picture);
    }
    return EXIT_DONE;
}

/* ---- the command ---- */

static int read_place(const options *o, explained *e) {
    uint64_t n[2];
    if (o->operands.count != 3) {
        return report_usage("such as: snell explain balls.png 400 300",
                            "explain needs a FILE and the pixel's X and Y");
    }
    for (int i = 0; i < 2; i++) {
        const char *text = o->operands.items[i + 1];
        if (!text_uint(text, 0, IMAGE_SIDE_MAX - 1, &n[i]))
            return report_usage("they count from the top left, from 0", "%c: '%s' is no pixel",
                                "XY"[i], text);
    }
    e->file = o->operands.items[0];
    e->x = (uint32_t)n[0];
    e->y = (uint32_t)n[1];
    return EXIT_DONE;
}

static int read_choices(const options *o, explained *e) {
    uint64_t whole;
    int forms = (o->value[OPT_DOT] != NULL) + (o->value[OPT_SVG] != NULL) + report_json();
    if (forms > 1) return report_usage(NULL, "--json, --dot and --svg exclude one another");
    e->levels = report_json() ? LEVELS_ALL : LEVELS_DEFAULT;
    if (o->value[OPT_LEVELS] != NULL) {
        if (!text_uint(o->value[OPT_LEVELS], 0, DEPTH_MAX, &whole))
            return report_usage(NULL, "--levels: '%s' is not a whole number from 0 to %d",
                                o->value[OPT_LEVELS], DEPTH_MAX);
        e->levels = (uint32_t)whole;
    }
    if (o->value[OPT_SAMPLE] != NULL) {
        if (!text_uint(o->value[OPT_SAMPLE], 0, SAMPLES_MAX - 1, &whole))
            return report_usage("they count from 0", "--sample: '%s' is no number of a sample",
                                o->value[OPT_SAMPLE]);
        e->has_sample = true;
        e->sample = (uint32_t)whole;
    }
    return EXIT_DONE;
}

static int check_inside(const explained *e) {
    const snell_render_desc *d = &e->stage->desc;
    uint32_t width = d->crop_width > 0 ? d->crop_width : d->width,
             height = d->crop_width > 0 ? d->crop_height : d->height;
    if (e->x >= width || e->y >= height)
        return report_usage("X and Y count from the top left, from 0",
                            "there is no pixel %" PRIu32 ",%" PRIu32 ": the picture is %" PRIu32
                            "x%" PRIu32,
                            e->x, e->y, width, height);
    return EXIT_DONE;
}

/* With a noise, a pixel's samples are decided by the whole picture: its tag tells, or it is rendered. */
static int count_samples(explained *e) {
    snell_render_desc *d = &e->stage->desc;
    uint32_t has = e->tag != NULL ? tag_samples(e->tag, d, e->x, e->y) : 0;
    if (has == 0 && d->noise > 0) {
        snell_film *film = NULL;
        uint32_t width = 0;
        int code = stage_status(e->stage, snell_film_create(e->stage->session->context, &film));
        if (code == EXIT_DONE)
            code = stage_status(e->stage, snell_render(e->stage->scene, d, film));
        if (code == EXIT_DONE) {
            snell_film_pixels(film, &width, NULL, NULL);
            has = snell_film_samples(film)[(size_t)e->y * width + e->x];
        }
        snell_film_destroy(film);
        if (code != EXIT_DONE) return code;
    }
    e->samples_given = d->noise > 0 ? has : 0;
    uint32_t count = d->noise > 0 ? has : d->samples;
    if (e->has_sample && e->sample >= count)
        return report_usage("they count from 0",
                            "--sample: there is no sample %" PRIu32 ": the pixel has %" PRIu32,
                            e->sample, count);
    return EXIT_DONE;
}

/* The sample whose colour is nearest to the pixel's; the first of several. */
static uint32_t find_typical(const explained *e) {
    uint32_t best = 0;
    double best_distance = INFINITY;
    for (uint32_t i = 0; i < e->sample_count; i++) {
        double distance = 0;
        for (int c = 0; c < 3; c++) {
            double off = e->samples[i].radiance[c] - (double)e->pixel[c];
            distance += off * off;
        }
        if (!(distance < best_distance)) continue;
        best_distance = distance;
        best = i;
    }
    return best;
}

static int print_explained(const explained *e) {
    if (e->options->value[OPT_DOT] != NULL) return explain_dot(e);
    if (e->options->value[OPT_SVG] != NULL) return explain_svg(e, e->options->value[OPT_SVG]);
    if (!report_json()) return explain_text(e);
    json_t *root = explain_json(e);
    json_object_set_new(root, "added", report_text(e->stage->added));
    json_object_set_new(root, "warnings", report_take_warnings());
    return report_emit_exactly(root, EXIT_DONE);
}

static int explain_stage(explained *e) {
    snell_explain_desc pixel = SNELL_INIT(explain_desc);
    snell_explanation *found = NULL;
    pixel.x = e->x;
    pixel.y = e->y;
    pixel.samples = e->samples_given;
    if (e->has_sample) {
        pixel.first_sample = e->sample;
        pixel.sample_count = 1;
    }
    int code =
        stage_status(e->stage, snell_explain(e->stage->scene, &e->stage->desc, &pixel, &found));
    progress_end();
    if (code == EXIT_DONE) code = report_strict();
    if (code == EXIT_DONE) {
        e->samples = snell_explanation_samples(found, &e->sample_count);
        e->rays = snell_explanation_rays(found, &e->ray_count);
        e->lights = snell_explanation_lights(found, NULL);
        e->pixel = snell_explanation_pixel(found, &e->channels);
        if (!e->has_sample) e->sample = find_typical(e);
        code = print_explained(e);
    }
    snell_explanation_destroy(found);
    return code;
}

/* `from`: where it is not NULL, the scene is to be the one that the picture was made of. */
static int load_made(stage *s, const source *from, const char *picture) {
    int code = stage_load(s, from != NULL);
    return code == EXIT_DONE && from != NULL
               ? check_hash(from->tag, picture, session_label(s->input), s->hash)
               : code;
}

static int explain_scene(explained *e, const source *from, const char *scene) {
    const options *o = e->options;
    render_values values;
    session s;
    int code = values_read(o, &values);
    if (code != EXIT_DONE) return code;
    code = session_open(&s, o);
    stage staged = {.options = o, .values = &values, .session = &s, .input = scene};
    e->stage = &staged;
    stage_set_frame(&s, &values, values.frame_first);
    progress_begin(session_label(scene));
    uint32_t first = from != NULL ? tag_first_frame(from->tag) : 0;
    bool other = code == EXIT_DONE && first > 0 && first != values.frame_first;
    if (other) { /* the tag's hash is of the first */
        stage_set_frame(&s, &values, first);
        code = load_made(&staged, from, e->file);
        snell_scene_destroy(staged.scene);
        staged.scene = NULL;
        stage_set_frame(&s, &values, values.frame_first);
    }
    if (code == EXIT_DONE) code = load_made(&staged, other ? NULL : from, e->file);
    if (code == EXIT_DONE) code = stage_prepare(&staged);
    if (code == EXIT_DONE) code = check_inside(e);
    if (code == EXIT_DONE) code = count_samples(e);
    if (code == EXIT_DONE) code = explain_stage(e);
    progress_end();
    snell_scene_destroy(staged.scene);
    session_close(&s);
    return signals_caught() != 0 && code == EXIT_DONE ? EXIT_SOME_FAILED : code;
}

static int explain_picture(explained *e) {
    options joined = {.command = NULL};
    source from = {.tag = NULL};
    const char *scene = NULL;
    int code = read_tag(e->file, &from);
    if (code == EXIT_DONE) check_version(from.tag, e->file);
    if (code == EXIT_DONE) code = find_scene(e->file, &from, &scene);
    if (code == EXIT_DONE) code = take_options(e->file, &from, e->options, &joined);
    e->options = &joined;
    e->tag = from.tag;
    if (code == EXIT_DONE) code = explain_scene(e, &from, scene);
    options_free(&joined);
    source_free(&from);
    return code;
}

int explain_command(const options *o) {
    explained e = {.options = o};
    int code = read_place(o, &e);
    if (code == EXIT_DONE) code = read_choices(o, &e);
    if (code != EXIT_DONE) return code;
    signals_setup();
    progress_setup(o->value[OPT_PROGRESS]);
    if (tag_is_picture(e.file)) return explain_picture(&e);
    return explain_scene(&e, NULL, e.file);
}
