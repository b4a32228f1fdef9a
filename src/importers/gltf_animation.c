/* glTF animations: which one is wanted, its clock, and where it puts a node at a time.
 *
 * A frame is seen while a shutter is open: every node that an animation moves gets its place at
 * CLOCK_TIMES moments from a frame before to a frame after, and motion is linear in between. */
#include "importers/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "maths/functions.h"
#include "scene/settings.h"

static const char *const paths[TRACK_KINDS] = {"translation", "rotation", "scale", "weights"};

/* ---- what the JSON says ---- */

static const json_t *animation_list(const json_t *animation, const char *list, size_t index) {
    return json_array_get(json_at(animation, list), index);
}

static int path_kind(const char *path) {
    for (int i = 0; i < TRACK_KINDS; i++)
        if (strcmp(paths[i], path) == 0) return i;
    return TRACK_KINDS;
}

static int interpolation_of(const json_t *sampler) {
    const char *word = json_text(sampler, "interpolation");
    if (word == NULL) return INTERPOLATE_LINEAR;
    return choice_find("STEP|LINEAR|CUBICSPLINE", word);
}

/* Morph targets of the node's mesh. */
static size_t target_count(const gltf *g, size_t node) {
    size_t number = json_index(json_item(g, "nodes", node), "mesh", SIZE_MAX);
    const json_t *mesh = number == SIZE_MAX ? NULL : json_item(g, "meshes", number);
    return json_array_size(json_at(json_array_get(json_at(mesh, "primitives"), 0), "targets"));
}

static snell_status check_sampler(gltf *g, const json_t *sampler, const char *where) {
    size_t input = json_index(sampler, "input", 0);
    const json_t *times = json_item(g, "accessors", input);
    if (interpolation_of(sampler) < 0)
        return gltf_error(g, SNELL_ERR_SYNTAX, where,
                          "interpolation: '%.40s' is not one of STEP|LINEAR|CUBICSPLINE",
                          json_text(sampler, "interpolation"));
    if (strcmp(json_text(times, "type"), "SCALAR") != 0 ||
        json_index(times, "componentType", 0) != GL_FLOAT)
        return gltf_error(g, SNELL_ERR_SYNTAX, where,
                          "input: accessors[%zu] must hold one float per key", input);
    if (!json_at(times, "min") || !json_at(times, "max"))
        return gltf_warn(g, "%s: input: accessors[%zu] has no min and max", where, input);
    return SNELL_OK;
}

/* Elements of the output per key, each of `components` numbers. */
static size_t elements_per_key(const gltf *g, int kind, int interpolation, size_t node) {
    return (kind == TRACK_WEIGHTS ? target_count(g, node) : 1) *
           (interpolation == INTERPOLATE_CUBIC ? 3 : 1);
}

static unsigned components_of(int kind) {
    return kind == TRACK_WEIGHTS ? 1 : kind == TRACK_ROTATION ? 4 : 3;
}

static snell_status check_channel(gltf *g, const json_t *animation, const json_t *channel,
                                  const char *where) {
    const json_t *target = json_at(channel, "target");
    size_t number = json_index(channel, "sampler", 0), node = json_index(target, "node", SIZE_MAX);
    const json_t *sampler = animation_list(animation, "samplers", number);
    int kind = path_kind(json_text(target, "path"));
    if (sampler == NULL)
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "there is no sampler %zu", number);
    if (kind == TRACK_KINDS)
        return gltf_warn(g, "%s: cannot animate '%.40s': ignored", where,
                         json_text(target, "path"));
    if (node == SIZE_MAX) return SNELL_OK;
    if (kind != TRACK_WEIGHTS && json_at(json_item(g, "nodes", node), "matrix"))
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "nodes[%zu] has a matrix and is animated",
                          node);
    if (kind == TRACK_WEIGHTS && target_count(g, node) == 0)
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "nodes[%zu] has no morph targets", node);
    size_t output = json_index(sampler, "output", 0);
    if (gltf_accessor_components(g, output) != components_of(kind))
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "accessors[%zu] does not hold a %s", output,
                          paths[kind]);
    int interpolation = interpolation_of(sampler);
    size_t keys = gltf_accessor_count(g, json_index(sampler, "input", 0)),
           each = elements_per_key(g, kind, interpolation, node);
    if (interpolation == INTERPOLATE_CUBIC && keys < 2)
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "a CUBICSPLINE has two keys or more");
    if (keys == 0 || gltf_accessor_count(g, output) / keys != each ||
        gltf_accessor_count(g, output) % keys != 0)
        return gltf_error(g, SNELL_ERR_SYNTAX, where,
                          "accessors[%zu] has %zu elements; %zu keys need %zu each", output,
                          gltf_accessor_count(g, output), keys, each);
    return SNELL_OK;
}

static int compare_targets(const void *a, const void *b) {
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

/* No two channels of an animation move the same. */
static snell_status check_targets(gltf *g, const json_t *channels, size_t index) {
    size_t count = json_array_size(channels), used = 0;
    uint64_t *targets = memory_zeroed(count + 1, sizeof *targets);
    if (targets == NULL) return error_no_memory();
    for (size_t i = 0; i < count; i++) {
        const json_t *target = json_at(json_array_get(channels, i), "target");
        size_t node = json_index(target, "node", SIZE_MAX);
        int kind = path_kind(json_text(target, "path"));
        if (node == SIZE_MAX || kind == TRACK_KINDS) continue;
        targets[used++] = (uint64_t)node * TRACK_KINDS + (uint64_t)kind;
    }
    qsort(targets, used, sizeof *targets, compare_targets);
    snell_status status = SNELL_OK;
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "animations[%zu].channels", index);
    for (size_t i = 1; i < used && !status; i++)
        if (targets[i] == targets[i - 1])
            status =
                gltf_error(g, SNELL_ERR_SYNTAX, where, "two move nodes[%zu].%s",
                           (size_t)(targets[i] / TRACK_KINDS), paths[targets[i] % TRACK_KINDS]);
    free(targets);
    return status;
}

snell_status gltf_check_animation(gltf *g, size_t index) {
    const json_t *animation = json_item(g, "animations", index);
    const json_t *channels = json_at(animation, "channels"),
                 *samplers = json_at(animation, "samplers");
    snell_status status = SNELL_OK;
    char where[JSON_PATH_SIZE];
    for (size_t i = 0; i < json_array_size(samplers) && !status; i++) {
        snprintf(where, sizeof where, "animations[%zu].samplers[%zu]", index, i);
        status = check_sampler(g, json_array_get(samplers, i), where);
    }
    for (size_t i = 0; i < json_array_size(channels) && !status; i++) {
        snprintf(where, sizeof where, "animations[%zu].channels[%zu]", index, i);
        status = check_channel(g, animation, json_array_get(channels, i), where);
    }
    return status ? status : check_targets(g, channels, index);
}

/* ---- tracks ---- */

static snell_status check_times(gltf *g, const gltf_track *t, size_t accessor) {
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "accessors[%zu]", accessor);
    for (size_t i = 0; i < t->count; i++) {
        double time = (double)t->times[i];
        if (!(time >= 0 && time < 1e6) || (i > 0 && !(t->times[i] > t->times[i - 1])))
            return gltf_error(g, SNELL_ERR_SYNTAX, where,
                              "the time %g of key %zu is negative, too large or not ascending",
                              time, i);
    }
    return SNELL_OK;
}

static snell_status read_track(gltf *g, const json_t *animation, const json_t *channel,
                               const char *where) {
    const json_t *target = json_at(channel, "target"),
                 *sampler =
                     animation_list(animation, "samplers", json_index(channel, "sampler", 0));
    size_t node = json_index(target, "node", SIZE_MAX), input = json_index(sampler, "input", 0);
    int kind = path_kind(json_text(target, "path"));
    if (node == SIZE_MAX || kind == TRACK_KINDS) return SNELL_OK;
    gltf_track **place = &g->nodes[node].tracks[kind];
    if (*place) return SNELL_OK; /* of several animations the first that moves it */
    gltf_track *t = memory_zeroed(1, sizeof *t);
    if (t == NULL) return error_no_memory();
    *place = t;
    t->interpolation = interpolation_of(sampler);
    t->count = gltf_accessor_count(g, input);
    t->width = components_of(kind) * (kind == TRACK_WEIGHTS ? target_count(g, node) : 1);
    snell_status status = gltf_accessor_floats(g, input, 1, where, &t->times);
    if (!status) status = check_times(g, t, input);
    if (!status)
        status = gltf_accessor_floats(g, json_index(sampler, "output", 0), components_of(kind),
                                      where, &t->values);
    if (!status) g->duration = double_max(g->duration, (double)t->times[t->count - 1]);
    return status;
}

static snell_status read_tracks(gltf *g, size_t index) {
    const json_t *animation = json_item(g, "animations", index),
                 *channels = json_at(animation, "channels");
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < json_array_size(channels) && !status; i++) {
        char where[JSON_PATH_SIZE];
        snprintf(where, sizeof where, "animations[%zu].channels[%zu]", index, i);
        status = read_track(g, animation, json_array_get(channels, i), where);
    }
    return status;
}

/* Number k of key i: 0 the tangent that comes in, 1 the value, 2 the tangent that goes out. */
static const float *key_values(const gltf_track *t, size_t i, int k) {
    return t->interpolation == INTERPOLATE_CUBIC ? t->values + (3 * i + (size_t)k) * t->width
                                                 : t->values + i * t->width;
}

/* The specification's appendix C.5: cubic Hermite splines; tangents count in values a second. */
static void cubic(const gltf_track *t, size_t i, double s, double length, double *out) {
    const float *from = key_values(t, i, 1), *leave = key_values(t, i, 2),
                *to = key_values(t, i + 1, 1), *arrive = key_values(t, i + 1, 0);
    double s2 = s * s, s3 = s2 * s, at_to = 3 * s2 - 2 * s3, at_leave = length * (s3 - 2 * s2 + s),
           at_arrive = length * (s3 - s2);
    for (size_t c = 0; c < t->width; c++)
        out[c] = (1 - at_to) * (double)from[c] + at_leave * (double)leave[c] +
                 at_to * (double)to[c] + at_arrive * (double)arrive[c];
}

static void normalise(double q[4]) {
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int c = 0; c < 4 && length > 0; c++) q[c] /= length;
}

/* Appendix C.4: along the shorter arc. */
static void slerp(const float *from, const float *to, double s, double *out) {
    double a[4], b[4], cosine = 0;
    for (int c = 0; c < 4; c++) a[c] = (double)from[c], b[c] = (double)to[c];
    normalise(a), normalise(b);
    for (int c = 0; c < 4; c++) cosine += a[c] * b[c];
    double sign = cosine < 0 ? -1 : 1, angle = fn_acos(double_min(fabs(cosine), 1)),
           sine = fn_sin(angle), first = 1 - s, second = s;
    if (sine > 1e-6) {
        first = fn_sin((1 - s) * angle) / sine;
        second = fn_sin(s * angle) / sine;
    }
    for (int c = 0; c < 4; c++) out[c] = first * a[c] + sign * second * b[c];
    normalise(out);
}

void gltf_track_at(const gltf_track *t, int kind, double time, double *out) {
    size_t low = 0, high = t->count - 1; /* the last key that is not after the time, or 0 */
    while (low < high) {
        size_t middle = low + (high - low + 1) / 2;
        if ((double)t->times[middle] <= time)
            low = middle;
        else
            high = middle - 1;
    }
    const float *here = key_values(t, low, 1);
    bool still = low + 1 == t->count || !(time > (double)t->times[low]) ||
                 t->interpolation == INTERPOLATE_STEP;
    double length = still ? 1 : (double)t->times[low + 1] - (double)t->times[low],
           s = (time - (double)t->times[low]) / length;
    if (still)
        for (size_t c = 0; c < t->width; c++) out[c] = (double)here[c];
    else if (t->interpolation == INTERPOLATE_CUBIC)
        cubic(t, low, s, length, out);
    else if (kind == TRACK_ROTATION)
        slerp(here, key_values(t, low + 1, 1), s, out);
    else
        for (size_t c = 0; c < t->width; c++)
            out[c] = (1 - s) * (double)here[c] + s * (double)key_values(t, low + 1, 1)[c];
}

/* ---- which animation, which frame ---- */

/* By what its samplers' accessors say, which is enough to tell people. */
static double said_duration(const gltf *g, size_t index) {
    const json_t *samplers = json_at(json_item(g, "animations", index), "samplers");
    double longest = 0;
    for (size_t i = 0; i < json_array_size(samplers); i++) {
        size_t input = json_index(json_array_get(samplers, i), "input", 0);
        double end = 0;
        json_numbers(json_item(g, "accessors", input), "max", &end, 1);
        longest = double_max(longest, end);
    }
    return longest;
}

static int32_t last_frame(double duration, double fps) {
    double last = floor(duration * fps + 1e-4) + 1;
    return last < FRAME_MAX ? (int32_t)last : FRAME_MAX;
}

static const char *animation_name(const gltf *g, size_t index) {
    const char *name = json_text(json_item(g, "animations", index), "name");
    return name ? name : "";
}

/* "1 Survey (3.42 s, frames 1 to 83), 2 Walk (...)" */
static void list_animations(const gltf *g, double fps, char *out, size_t size) {
    size_t used = 0;
    *out = '\0';
    for (size_t i = 0; i < json_count(g, "animations") && used + 160 < size; i++) {
        double duration = said_duration(g, i);
        const char *name = animation_name(g, i);
        used += (size_t)snprintf(out + used, size - used, "%s%zu%s%.60s (%.4g s, frames 1 to %d)",
                                 i ? ", " : "", i + 1, *name ? " " : "", name, duration,
                                 last_frame(duration, fps));
    }
    if (used + 160 >= size) snprintf(out + used, size - used, ", ...");
}

static const char *find_param(const import_options *options, const char *name) {
    size_t length = strlen(name);
    for (size_t i = 0; i < options->param_count; i++)
        if (strncmp(options->params[i], name, length) == 0 && options->params[i][length] == '=')
            return options->params[i] + length + 1;
    return NULL;
}

static snell_status check_param_names(const gltf *g) {
    const import_options *o = g->options;
    for (size_t i = 0; i < o->param_count; i++) {
        size_t length = strcspn(o->params[i], "=");
        bool known = (length == 9 && strncmp(o->params[i], "animation", length) == 0) ||
                     (length == 3 && strncmp(o->params[i], "fps", length) == 0);
        if (known && o->params[i][length] == '=') continue;
        return error_set_at(SNELL_ERR_ARGUMENT, (source_place){g->path, 0, 0},
                            "such as -D fps=30 or -D animation=NAME",
                            "-D %.60s: a glTF file with animations takes 'animation' and 'fps'",
                            o->params[i]);
    }
    return SNELL_OK;
}

static snell_status wrong_argument(const gltf *g, const char *format, const char *value,
                                   const char *hint) {
    return error_set_at(SNELL_ERR_ARGUMENT, (source_place){g->path, 0, 0}, hint, format, value);
}

enum { ALL_ANIMATIONS = -1 };

/* A name, a number from 1, or "all". */
static snell_status find_animation(const gltf *g, const char *word, int64_t *out) {
    size_t count = json_count(g, "animations");
    for (size_t i = 0; i < count; i++)
        if (strcmp(animation_name(g, i), word) == 0) {
            *out = (int64_t)i;
            return SNELL_OK;
        }
    char *end;
    long number = strtol(word, &end, 10);
    bool all = strcmp(word, "all") == 0;
    *out = all ? ALL_ANIMATIONS : number - 1;
    if (all || (*word && *end == '\0' && number >= 1 && (size_t)number <= count)) return SNELL_OK;
    char list[400], hint[480];
    list_animations(g, 24, list, sizeof list);
    snprintf(hint, sizeof hint, "there are %s; or all", list);
    return wrong_argument(g, "there is no animation '%.60s'", word, hint);
}

static snell_status read_fps(const gltf *g, double *fps) {
    const char *word = find_param(g->options, "fps");
    *fps = g->options->fps > 0 ? g->options->fps : 24;
    if (word == NULL || g->options->within) return SNELL_OK;
    char *end;
    *fps = strtod(word, &end);
    if (*word && *end == '\0' && *fps >= 0.001 && *fps <= 100000) return SNELL_OK;
    return wrong_argument(g, "fps: '%.60s' is not a number from 0.001 to 100000", word,
                          "such as -D fps=30");
}

static snell_status add_clock(gltf *g, double fps, uint32_t frame, int32_t last,
                              const char *chosen) {
    char list[1000], number[32];
    list_animations(g, fps, list, sizeof list);
    snprintf(number, sizeof number, "%.6g", fps);
    const char *first = *animation_name(g, 0) ? animation_name(g, 0) : "1";
    snell_param params[] = {
        {.name = "first", .kind = SNELL_PARAM_INT, .value.i = 1},
        {.name = "last", .kind = SNELL_PARAM_INT, .value.i = last},
        {.name = "frame", .kind = SNELL_PARAM_INT, .value.i = frame ? frame : 1},
        {.name = "fps", .kind = SNELL_PARAM_FLOAT, .value.f = fps}};
    snell_status status =
        description_add_param(g->d, "animation", "string", chosen ? chosen : first, first, list);
    if (!status)
        status = description_add_param(g->d, "fps", "number", number, "24", "frames in a second");
    if (!status)
        status = description_add(g->d, CATEGORY_SETTING, "animation", params, 4,
                                 (object_source){NULL, g->path, 0}, NULL);
    if (status || frame) return status;
    return description_add_message(g->d, SNELL_INFO, g->path, 0, "--frame N shows one",
                                   "the model is shown at rest; it has animations: %s", list);
}

/* Times about the frame's own, from a frame before to a frame after. */
static void set_times(gltf *g, double start, double frame) {
    for (int i = 0; i < CLOCK_TIMES; i++) {
        double part = (double)(i - CLOCK_NOW) / CLOCK_NOW;
        g->times[i] = (float)(start + part * frame);
    }
}

snell_status gltf_choose_animation(gltf *g) {
    const import_options *o = g->options;
    if (json_count(g, "animations") == 0)
        return o->animation ? gltf_error(g, SNELL_ERR_ARGUMENT, "", "it has no animations")
                            : SNELL_OK;
    const char *word = o->within ? o->animation : find_param(o, "animation");
    int64_t chosen = 0;
    double fps;
    snell_status status = o->within ? SNELL_OK : check_param_names(g);
    if (!status && word) status = find_animation(g, word, &chosen);
    if (!status) status = read_fps(g, &fps);
    if (status) return status;
    uint32_t frame = o->frame == 0 && word ? 1 : o->frame;
    if (frame == 0) {
        if (o->within) return SNELL_OK;
        return add_clock(g, fps, 0, last_frame(said_duration(g, 0), fps), word);
    }
    for (size_t i = 0; i < json_count(g, "animations") && !status; i++)
        if (chosen == ALL_ANIMATIONS || (size_t)chosen == i) status = read_tracks(g, i);
    if (status) return status;
    int32_t last = last_frame(g->duration, fps);
    if (!o->within && frame > (uint32_t)last)
        return error_set_at(SNELL_ERR_ARGUMENT, (source_place){g->path, 0, 0}, NULL,
                            "frame %u: the animation has frames 1 to %d", frame, last);
    g->posed = true;
    set_times(g, (frame - 1) / fps, 1 / fps);
    return o->within ? SNELL_OK : add_clock(g, fps, frame, last, word);
}

void gltf_free_animation(gltf *g) {
    for (size_t i = 0; g->nodes && i < json_count(g, "nodes"); i++) {
        for (int k = 0; k < TRACK_KINDS; k++) {
            gltf_track *t = g->nodes[i].tracks[k];
            if (t == NULL) continue;
            free(t->times);
            free(t->values);
            free(t);
        }
        free(g->nodes[i].worlds);
    }
}
