/* snell info: what is in a model, a scene or a picture. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "commands.h"
#include "output.h"
#include "progress.h"
#include "report.h"
#include "session.h"
#include "tag.h"
#include "text.h"
#include "values.h"

enum { SHOWN_MAX = 20 };

/* ---- pictures ---- */

/* A file name that begins with a dash would be read as an option. */
static void print_file(const char *file) {
    if (file[0] == '-' && file[1] != '\0') fputs("./", stdout);
    text_print_shell(stdout, file);
}

/* What the file's own format tells: how it is packed, and an animation's frames. */
static void print_packing(const json_t *tag, const snell_picture_info *info) {
    const json_t *movie = json_object_get(tag, "animation");
    const char *frames = json_string_value(json_object_get(movie, "frames"));
    if (info->bits == 16) printf(" --bits=16");
    if (frames != NULL) {
        printf(" --frames=");
        text_print_shell(stdout, frames);
    }
    if (movie != NULL) printf(" --fps=%.6g", json_number_value(json_object_get(movie, "fps")));
}

static void print_command(const json_t *tag, const char *picture, const snell_picture_info *info) {
    const char *file = json_string_value(json_object_get(tag, "file"));
    const json_t *list = json_object_get(tag, "options");
    fputs("  snell render ", stdout);
    print_file(file);
    for (size_t i = 0; i < json_array_size(list); i++) {
        fputc(' ', stdout);
        text_print_shell(stdout, json_string_value(json_array_get(list, i)));
    }
    print_packing(tag, info);
    fputs(" -o ", stdout);
    print_file(picture);
    fputs(strcmp(file, "-") == 0 ? " < SCENE\n" : "\n", stdout);
}

/* What no render does, on a line of its own. */
static void print_conversion(const json_t *tag) {
    const json_t *list = json_object_get(tag, "converted");
    if (json_array_size(list) == 0) return;
    fputs("and then snell convert with", stdout);
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *text = json_string_value(json_array_get(list, i));
        fputc(' ', stdout);
        text_print_shell(stdout, text != NULL ? text : "?");
    }
    fputc('\n', stdout);
}

static void print_layers(const char *layers) {
    for (const char *at = layers; *at != '\0';) {
        size_t length = strcspn(at, "\n");
        char *line = strndup(at, length);
        printf("%-11s ", at == layers ? "layers" : "");
        char *first = line != NULL ? strstr(line, ": ") : NULL;
        char *second = first != NULL && length > 60 ? strchr(first + 2, ' ') : NULL;
        if (second != NULL) *second = '\0'; /* a Cryptomatte has twelve */
        if (line != NULL) text_print_safe(stdout, line);
        puts(second != NULL ? " .." : "");
        free(line);
        at += length + (at[length] == '\n');
    }
}

/* {"name": the part's or "", "channels": "N.X N.Y N.Z"} */
static json_t *json_layers(const char *layers) {
    json_t *list = json_array();
    for (const char *at = layers; *at != '\0';) {
        size_t length = strcspn(at, "\n");
        char *line = strndup(at, length), *colon = line != NULL ? strstr(line, ": ") : NULL;
        json_t *item = json_object();
        if (colon != NULL) *colon = '\0';
        json_object_set_new(item, "name", report_text(colon != NULL ? line : ""));
        json_object_set_new(item, "channels",
                            report_text(colon != NULL  ? colon + 2
                                        : line != NULL ? line
                                                       : ""));
        json_array_append_new(list, item);
        free(line);
        at += length + (at[length] == '\n');
    }
    return list;
}

/* What --noise reached. */
static void print_noise(const json_t *noise) {
    double bound = json_number_value(json_object_get(noise, "bound")),
           confidence = json_number_value(json_object_get(noise, "confidence"));
    json_int_t blocks = json_integer_value(json_object_get(noise, "blocks")),
               done = json_integer_value(json_object_get(noise, "blocks_done"));
    if (blocks <= 0) return;
    printf("error under %.3g %% (%g %% confidence); %" JSON_INTEGER_FORMAT
           " of %" JSON_INTEGER_FORMAT " blocks under the noise\n",
           100 * bound, 100 * confidence, done, blocks);
}

/* range: NULL: not known */
static void print_picture(const char *path, const snell_picture_info *info, const float *range) {
    text_print_safe(stdout, path);
    printf(": %s picture, %" PRIu32 "x%" PRIu32 ", %" PRIu32 " channels of %" PRIu32 " bits",
           info->format, info->width, info->height, info->channels, info->bits);
    if (info->frames > 0)
        printf(", %" PRIu32 " frame%s", info->frames, info->frames > 1 ? "s" : "");
    putchar('\n');
    if (range != NULL) printf("%-11s %.6g to %.6g\n", "values", (double)range[0], (double)range[1]);
    if (info->layers != NULL) print_layers(info->layers);
    if (info->tag == NULL || info->tag[0] == '\0') {
        puts("  it does not say how it was made");
        return;
    }
    json_t *tag = tag_read(info->tag);
    if (tag == NULL) {
        fputs("  made by a snell that this one does not understand:\n  ", stdout);
        text_print_safe(stdout, info->tag);
        fputc('\n', stdout);
        return;
    }
    fputs("made by snell ", stdout);
    text_print_safe(stdout, json_string_value(json_object_get(tag, "snell")));
    bool partial = json_is_true(json_object_get(tag, "partial"));
    puts(partial ? ", stopped before it was done; the whole picture:" : " with");
    print_command(tag, path, info);
    print_noise(json_object_get(tag, "noise"));
    print_conversion(tag);
    json_decref(tag);
}

/* The least and the largest of a picture's floats, numbers that they are; false: there is none. */
static bool find_range(const snell_film *film, float out[2]) {
    uint32_t width, height, channels;
    const float *pixels = snell_film_pixels(film, &width, &height, &channels);
    uint32_t colors = channels == 2 || channels == 4 ? channels - 1 : channels; /* no alpha */
    out[0] = INFINITY, out[1] = -INFINITY;
    for (size_t i = 0; i < (size_t)width * height; i++)
        for (uint32_t c = 0; c < colors; c++) {
            float x = pixels[i * channels + c];
            if (!isfinite(x)) continue;
            out[0] = x < out[0] ? x : out[0];
            out[1] = x > out[1] ? x : out[1];
        }
    return out[0] <= out[1];
}

static bool is_hdr(const char *path) {
    const char *extension = output_extension(path);
    return strcasecmp(extension, "hdr") == 0;
}

/* What pictures of floats hold; of a Radiance HDR, which has no tag, all else too. An EXR may have
 * layers alone, and no colours. */
static int read_floats(session *s, const char *path, snell_picture_info *info, float range[2],
                       bool *has_range) {
    bool hdr = is_hdr(path), exr = strcmp(info->format, "exr") == 0;
    if (!hdr && !exr && strcmp(info->format, "pfm") != 0) return EXIT_DONE;
    snell_film_read_desc desc = SNELL_INIT(film_read_desc);
    desc.memory_max = s->memory_max;
    desc.progress = progress_report;
    snell_film *film = NULL;
    snell_status status = snell_film_create(s->context, &film);
    if (status == SNELL_OK) status = snell_film_read(film, path, &desc);
    int code = EXIT_DONE;
    if (signals_caught() != 0)
        code = EXIT_SOME_FAILED;
    else if (status == SNELL_ERR_SYNTAX && exr)
        report_warning(NULL, "%s: its colours are not looked at: %s", path,
                       snell_last_error()->text);
    else if (status != SNELL_OK)
        code = report_status(status, path);
    *has_range = status == SNELL_OK && find_range(film, range);
    if (status == SNELL_OK && hdr) {
        snprintf(info->format, sizeof info->format, "hdr");
        snell_film_pixels(film, &info->width, &info->height, &info->channels);
        info->bits = 8; /* beside an exponent for all three */
    }
    snell_film_destroy(film);
    return code;
}

static int picture_info(session *s, const char *path, json_t *root) {
    snell_picture_info info = {.struct_size = sizeof info};
    float range[2];
    bool has_range = false;
    int code = session_check_file(path);
    if (code != EXIT_DONE) return code;
    snell_status status = is_hdr(path) ? SNELL_OK : snell_picture_read_info(path, &info);
    if (status != SNELL_OK) return report_status(status, path);
    code = read_floats(s, path, &info, range, &has_range);
    if (code != EXIT_DONE) {
        snell_free(info.tag);
        snell_free(info.layers);
        return code;
    }
    if (report_json()) {
        bool made = info.tag != NULL && info.tag[0] != '\0';
        json_t *tag = made ? json_loads(info.tag, 0, NULL) : NULL;
        json_object_set_new(root, "kind", json_string("picture"));
        json_object_set_new(root, "format", report_text(info.format));
        json_object_set_new(root, "width", json_integer(info.width));
        json_object_set_new(root, "height", json_integer(info.height));
        json_object_set_new(root, "channels", json_integer(info.channels));
        json_object_set_new(root, "bits", json_integer(info.bits));
        if (info.frames > 0) json_object_set_new(root, "frames", json_integer(info.frames));
        if (has_range)
            json_object_set_new(root, "range",
                                json_pack("[f,f]", (double)range[0], (double)range[1]));
        json_object_set_new(root, "layers", json_layers(info.layers != NULL ? info.layers : ""));
        if (tag == NULL) tag = made ? report_text(info.tag) : json_null();
        json_object_set_new(root, "made", tag);
    } else {
        print_picture(path, &info, has_range ? range : NULL);
    }
    snell_free(info.tag);
    snell_free(info.layers);
    return EXIT_DONE;
}

/* ---- scenes ---- */

typedef snell_status get_object(const snell_scene *scene, uint32_t index, snell_object_info *out);

static snell_status get_camera(const snell_scene *scene, uint32_t index, snell_object_info *out) {
    snell_camera_id id;
    return snell_scene_get_camera(scene, index, out, &id);
}

static void print_objects(const snell_scene *scene, const char *title, uint32_t count,
                          get_object *get) {
    snell_object_info info;
    for (uint32_t i = 0; i < count && i < SHOWN_MAX; i++) {
        if (get(scene, i, &info) != SNELL_OK) return;
        printf("%-11s %3" PRIu32 "  %-14s ", i == 0 ? title : "", i + 1, info.type);
        text_print_safe(stdout, info.name);
        if (info.name[0] == '\0' && info.line == 0) fputs("unnamed", stdout);
        if (info.line > 0) printf("%sline %" PRIu32, info.name[0] != '\0' ? ", " : "", info.line);
        fputc('\n', stdout);
    }
    if (count > SHOWN_MAX)
        printf("%-11s      and %" PRIu32 " more (--json)\n", "", count - SHOWN_MAX);
}

static void print_params(const snell_scene *scene, uint32_t count) {
    snell_scene_param p;
    for (uint32_t i = 0; i < count; i++) {
        if (snell_scene_get_param(scene, i, &p) != SNELL_OK) return;
        printf("%-11s -D ", i == 0 ? "takes" : "");
        text_print_safe(stdout, p.name);
        fputc('=', stdout);
        text_print_safe(stdout, p.value);
        printf("  (%s", p.kind);
        if (strcmp(p.value, p.default_value) != 0) {
            fputs(", default ", stdout);
            text_print_safe(stdout, p.default_value);
        }
        fputs(")  ", stdout);
        text_print_safe(stdout, p.help);
        fputc('\n', stdout);
    }
}

/* Nothing is built where the structure takes nothing. */
static void print_memory(const snell_scene_stats *s) {
    char bytes[32];
    text_format_bytes(s->memory_geometry, bytes);
    printf("%-11s %s geometry", "memory", bytes);
    text_format_bytes(s->memory_accel, bytes);
    if (s->memory_accel > 0) printf(", %s acceleration structure", bytes);
    text_format_bytes(s->memory_textures, bytes);
    printf(", %s textures\n", bytes);
    text_format_bytes(s->memory_planned, bytes);
    printf("%-11s %s more at most while the structure is built, stated before\n", "", bytes);
}

static void print_counts(const snell_scene_stats *s) {
    char a[32], b[32];
    text_format_count(s->instance_count, a);
    printf("%-11s %s instance%s of %" PRIu32 " shape%s", "contents", a,
           s->instance_count == 1 ? "" : "s", s->shape_count, s->shape_count == 1 ? "" : "s");
    if (s->triangle_count > 0) {
        text_format_count(s->triangle_count, a);
        text_format_count(s->unique_triangle_count, b);
        printf(": %s triangle%s", a, s->triangle_count == 1 ? "" : "s");
        if (s->unique_triangle_count != s->triangle_count) printf(", %s of them stored", b);
    }
    printf("\n%-11s materials %" PRIu32 ", textures %" PRIu32 ", lights %" PRIu32
           ", cameras %" PRIu32 "\n",
           "", s->material_count, s->texture_count, s->light_count, s->camera_count);
    print_memory(s);
    if (s->has_emission || s->has_background || s->has_ambient || s->has_dielectric) {
        printf("%-11s%s%s%s%s\n", "has", s->has_emission ? " emission" : "",
               s->has_background ? " background" : "", s->has_ambient ? " ambient" : "",
               s->has_dielectric ? " glass" : "");
    }
}

static bool is_empty(const snell_bounds *b) { return !(b->min.x <= b->max.x); }

static void print_scene(const char *path, const snell_scene *scene, const snell_scene_stats *s,
                        const snell_bounds *b) {
    text_print_safe(stdout, session_label(path));
    printf(": %s\n", s->format[0] != '\0' ? s->format : "scene");
    print_counts(s);
    if (!is_empty(b)) {
        printf("%-11s %.6g %.6g %.6g  to  %.6g %.6g %.6g", "bounds", (double)b->min.x,
               (double)b->min.y, (double)b->min.z, (double)b->max.x, (double)b->max.y,
               (double)b->max.z);
        printf("  (%.6g x %.6g x %.6g)\n", (double)(b->max.x - b->min.x),
               (double)(b->max.y - b->min.y), (double)(b->max.z - b->min.z));
    }
    print_objects(scene, "cameras", s->camera_count, get_camera);
    print_objects(scene, "lights", s->light_count, snell_scene_get_light);
    print_objects(scene, "materials", s->material_count, snell_scene_get_material);
    print_params(scene, s->param_count);
    snell_animation clock = {.struct_size = sizeof clock};
    if (snell_scene_get_animation(scene, &clock) == SNELL_OK && clock.frame_count > 0)
        printf("%-11s frames %d to %d, %.6g a second; this is frame %d\n", "animation", clock.first,
               clock.last, (double)clock.fps, clock.frame);
}

static json_t *json_objects(const snell_scene *scene, uint32_t count, get_object *get) {
    json_t *list = json_array();
    snell_object_info info;
    for (uint32_t i = 0; i < count && get(scene, i, &info) == SNELL_OK; i++) {
        json_t *item = json_object();
        json_object_set_new(item, "type", report_text(info.type));
        json_object_set_new(item, "name", report_text(info.name));
        json_object_set_new(item, "line", json_integer(info.line));
        json_array_append_new(list, item);
    }
    return list;
}

static json_t *json_params(const snell_scene *scene, uint32_t count) {
    json_t *list = json_array();
    snell_scene_param p;
    for (uint32_t i = 0; i < count && snell_scene_get_param(scene, i, &p) == SNELL_OK; i++) {
        json_t *item = json_object();
        json_object_set_new(item, "name", report_text(p.name));
        json_object_set_new(item, "kind", report_text(p.kind));
        json_object_set_new(item, "value", report_text(p.value));
        json_object_set_new(item, "default", report_text(p.default_value));
        json_object_set_new(item, "help", report_text(p.help));
        json_array_append_new(list, item);
    }
    return list;
}

static json_t *json_vec3(snell_vec3 v) {
    return json_pack("[f,f,f]", (double)v.x, (double)v.y, (double)v.z);
}

static void json_scene(json_t *root, const snell_scene *scene, const snell_scene_stats *s,
                       const snell_bounds *b) {
    json_t *counts = json_object(), *memory = json_object();
    const struct {
        const char *name;
        uint64_t value;
    } rows[] = {{"instances", s->instance_count}, {"primitives", s->primitive_count},
                {"triangles", s->triangle_count}, {"unique_triangles", s->unique_triangle_count},
                {"shapes", s->shape_count},       {"textures", s->texture_count}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        json_object_set_new(counts, rows[i].name, json_integer((json_int_t)rows[i].value));
    }
    json_object_set_new(memory, "geometry", json_integer((json_int_t)s->memory_geometry));
    json_object_set_new(memory, "accel", json_integer((json_int_t)s->memory_accel));
    json_object_set_new(memory, "planned", json_integer((json_int_t)s->memory_planned));
    json_object_set_new(memory, "textures", json_integer((json_int_t)s->memory_textures));
    json_object_set_new(root, "kind", json_string("scene"));
    json_object_set_new(root, "format", report_text(s->format));
    json_object_set_new(root, "counts", counts);
    json_object_set_new(
        root, "bounds",
        is_empty(b) ? json_null()
                    : json_pack("{s:o,s:o}", "min", json_vec3(b->min), "max", json_vec3(b->max)));
    json_object_set_new(root, "cameras", json_objects(scene, s->camera_count, get_camera));
    json_object_set_new(root, "lights", json_objects(scene, s->light_count, snell_scene_get_light));
    json_object_set_new(root, "materials",
                        json_objects(scene, s->material_count, snell_scene_get_material));
    json_object_set_new(root, "params", json_params(scene, s->param_count));
    snell_animation clock = {.struct_size = sizeof clock};
    if (snell_scene_get_animation(scene, &clock) == SNELL_OK && clock.frame_count > 0)
        json_object_set_new(root, "animation",
                            json_pack("{s:f,s:i,s:i,s:i}", "fps", (double)clock.fps, "first",
                                      clock.first, "last", clock.last, "frame", clock.frame));
    json_object_set_new(root, "memory", memory);
    json_object_set_new(root, "has_emission", json_boolean(s->has_emission));
    json_object_set_new(root, "has_background", json_boolean(s->has_background));
    json_object_set_new(root, "has_ambient", json_boolean(s->has_ambient));
    json_object_set_new(root, "has_dielectric", json_boolean(s->has_dielectric));
}

static int scene_info(session *s, const char *path, json_t *root) {
    snell_scene *scene = NULL;
    snell_scene_stats stats = {.struct_size = sizeof stats};
    snell_bounds bounds = {{1, 1, 1}, {-1, -1, -1}};
    int code = session_load(s, path, &scene);
    if (code != EXIT_DONE) return code;
    snell_status status = SNELL_OK;
    if (s->options->given[OPT_NO_BUILD] == 0)
        status = snell_scene_commit(scene, progress_report, NULL);
    if (status == SNELL_OK) status = snell_scene_bounds(scene, &bounds);
    if (status == SNELL_OK) status = snell_scene_get_stats(scene, &stats);
    if (signals_caught() != 0)
        code = EXIT_SOME_FAILED;
    else if (status != SNELL_OK)
        code = report_status(status, session_label(path));
    if (code == EXIT_DONE) code = report_strict();
    if (code == EXIT_DONE && report_json()) json_scene(root, scene, &stats, &bounds);
    if (code == EXIT_DONE && !report_json()) print_scene(path, scene, &stats, &bounds);
    snell_scene_destroy(scene);
    return code;
}

/* ---- the command ---- */

static int file_info(session *s, const char *path, json_t *results) {
    json_t *root = json_object();
    json_object_set_new(root, "schema", json_integer(1));
    json_object_set_new(root, "file", report_text(path));
    int code = tag_is_picture(path) || is_hdr(path) ? picture_info(s, path, root)
                                                    : scene_info(s, path, root);
    json_t *error = report_take_error();
    if (error != NULL) json_object_set_new(root, "error", error);
    json_object_set_new(root, "warnings", report_take_warnings());
    json_array_append_new(results, root);
    return code;
}

static int info_all(session *s, const options *o) {
    json_t *results = json_array();
    size_t count = o->operands.count, failed = 0;
    int code = EXIT_DONE;
    for (size_t i = 0; i < count && signals_caught() == 0; i++) {
        if (i > 0) report_begin();
        if (i > 0 && !report_json()) putchar('\n');
        code = file_info(s, o->operands.items[i], results);
        failed += code != EXIT_DONE;
    }
    if (count > 1) code = failed > 0 ? EXIT_SOME_FAILED : EXIT_DONE;
    if (report_json()) {
        json_t *root = json_incref(json_array_get(results, 0));
        if (count > 1) {
            json_decref(root);
            root = json_pack("{s:i,s:I,s:O}", "schema", 1, "failed", (json_int_t)failed, "files",
                             results);
        }
        code = report_emit(root, code);
    }
    json_decref(results);
    return code;
}

int info_command(const options *o) {
    if (o->operands.count == 0) {
        return report_usage("such as: snell info duck.glb", "info needs a FILE");
    }
    signals_setup();
    progress_setup(NULL);
    session s;
    int code = session_open(&s, o);
    if (code == EXIT_DONE) {
        uint32_t last;
        code = values_read_frames(o, &s.frame, &last);
    }
    if (code == EXIT_DONE) {
        progress_begin("info");
        code = info_all(&s, o);
        progress_end();
    }
    session_close(&s);
    return code;
}
