#include "tag.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "report.h"
#include "text.h"
#include "values.h"

static void append(json_t *list, const char *name, const char *value) {
    size_t size = strlen(name) + strlen(value) + 4;
    char *word = malloc(size);
    if (word == NULL) return;
    snprintf(word, size, *value != '\0' ? "--%s=%s" : "--%s", name, value);
    json_array_append_new(list, report_text(word));
    free(word);
}

/* What the picture was made with, whether the command line or the scene said it. */
static void append_settings(json_t *list, const options *o, const snell_render_desc *desc,
                            const snell_film *film, uint32_t frame) {
    char text[32];
    append(list, "integrator", integrator_name(desc->integrator));
    snprintf(text, sizeof text, "%" PRIu32 "x%" PRIu32, desc->width, desc->height);
    append(list, "size", text);
    /* --samples 1 also means the pixel's centre: a scene that wants otherwise says so again. */
    if (o->value[OPT_SAMPLES] != NULL || desc->pixel_center == (desc->samples == 1)) {
        snprintf(text, sizeof text, "%" PRIu32, desc->samples);
        append(list, "samples", text);
    }
    snprintf(text, sizeof text, "%" PRIu32, desc->max_depth);
    append(list, "max-depth", text);
    text_format_float(desc->min_weight, text);
    append(list, "min-weight", text);
    snprintf(text, sizeof text, "%" PRIu64, desc->seed);
    append(list, "seed", text);
    snprintf(text, sizeof text, "%" PRIu32, frame);
    if (frame > 0) append(list, "frame", text);
    float exposure;
    const char *tonemap = snell_film_look(film, &exposure);
    text_format_float(exposure, text);
    append(list, "exposure", o->value[OPT_EXPOSURE] != NULL ? o->value[OPT_EXPOSURE] : text);
    append(list, "tonemap", o->value[OPT_TONEMAP] != NULL ? o->value[OPT_TONEMAP] : tonemap);
}

static bool is_setting(option_id id) {
    return id == OPT_INTEGRATOR || id == OPT_SIZE || id == OPT_SAMPLES || id == OPT_MAX_DEPTH ||
           id == OPT_MIN_WEIGHT || id == OPT_SEED || id == OPT_FRAME || id == OPT_EXPOSURE ||
           id == OPT_TONEMAP;
}

char *tag_make(const options *o, const char *file, uint64_t hash, const snell_render_desc *desc,
               const snell_film *film, uint32_t frame, bool partial) {
    json_t *tag = json_object(), *list = json_array();
    char digits[32];
    snprintf(digits, sizeof digits, "%016" PRIx64, hash);
    append_settings(list, o, desc, film, frame);
    for (size_t i = 0; i < option_table_count; i++) {
        const option_info *info = &option_table[i];
        if ((info->flags & OPTION_PICTURE) == 0 || (info->flags & OPTION_HIDDEN) != 0) continue;
        const string_list *values = info->id == OPT_SET ? &o->set : &o->allow;
        if ((info->flags & OPTION_REPEATS) != 0) {
            for (size_t k = 0; k < values->count; k++) append(list, info->name, values->items[k]);
        } else if (!is_setting(info->id) && o->value[info->id] != NULL) {
            append(list, info->name, o->value[info->id]);
        }
    }
    json_object_set_new(tag, "snell", json_string(snell_version()));
    json_object_set_new(tag, "file", report_text(file));
    json_object_set_new(tag, "scene", json_string(digits));
    json_object_set_new(tag, "options", list);
    if (partial) json_object_set_new(tag, "partial", json_true());
    char *text = json_dumps(tag, JSON_COMPACT);
    json_decref(tag);
    return text;
}

bool tag_is_picture(const char *path) {
    static const char *const endings[] = {".png", ".exr", ".pfm", ".ppm"};
    size_t length = strlen(path);
    for (size_t i = 0; i < sizeof endings / sizeof endings[0]; i++) {
        if (length > 4 && strcasecmp(path + length - 4, endings[i]) == 0) return true;
    }
    return false;
}

/* A picture may come from anywhere: only options that decide pictures are handed on, so that the
 * command line printed from them cannot be made to write elsewhere. */
static bool option_is_fine(const json_t *item) {
    const char *text = json_string_value(item);
    if (text == NULL || strncmp(text, "--", 2) != 0) return false;
    const option_info *info = option_find(text + 2, strcspn(text + 2, "="));
    return info != NULL && (info->flags & OPTION_PICTURE) != 0;
}

json_t *tag_read(const char *tag) {
    json_t *root = json_loads(tag, JSON_REJECT_DUPLICATES, NULL);
    const json_t *list = json_object_get(root, "options");
    bool fine = json_is_string(json_object_get(root, "snell")) &&
                json_is_string(json_object_get(root, "file")) && json_is_array(list);
    for (size_t i = 0; fine && i < json_array_size(list); i++) {
        fine = option_is_fine(json_array_get(list, i));
    }
    if (fine) return root;
    json_decref(root);
    return NULL;
}

/* The place of the option's value in an item such as "--seed=5"; NULL when it is another. */
static const char *value_in(const json_t *item, const char *name) {
    const char *text = json_string_value(item);
    size_t length = strlen(name);
    if (text == NULL || strncmp(text, "--", 2) != 0) return NULL;
    bool same = strncmp(text + 2, name, length) == 0 && text[2 + length] == '=';
    return same ? text + 2 + length + 1 : NULL;
}

const char *tag_option(const json_t *tag, const char *name) {
    const json_t *list = json_object_get(tag, "options");
    for (size_t i = json_array_size(list); i > 0; i--) {
        const char *value = value_in(json_array_get(list, i - 1), name);
        if (value != NULL) return value;
    }
    return NULL;
}

static void replace(json_t *list, const char *name, const char *value) {
    for (size_t i = json_array_size(list); i > 0; i--) {
        if (value_in(json_array_get(list, i - 1), name) != NULL) json_array_remove(list, i - 1);
    }
    append(list, name, value);
}

char *tag_convert(const char *text, const options *o, bool linear) {
    static const option_id ids[] = {OPT_LAYER, OPT_EXPOSURE, OPT_TONEMAP};
    static const char *const names[] = {"layer", "exposure", "tonemap"};
    json_t *tag = tag_read(text);
    if (tag == NULL) return strdup(text);
    json_t *list = json_object_get(tag, "options");
    json_t *converted = json_incref(json_object_get(tag, "converted"));
    if (!json_is_array(converted)) {
        json_decref(converted);
        converted = json_array();
    }
    bool plain = linear && o->value[OPT_LAYER] == NULL;
    for (size_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        const char *value = o->value[ids[i]];
        if (value == NULL) continue;
        if (plain && ids[i] != OPT_LAYER)
            replace(list, names[i], value);
        else
            append(converted, names[i], value);
    }
    if (json_array_size(converted) > 0) json_object_set(tag, "converted", converted);
    json_decref(converted);
    char *made = json_dumps(tag, JSON_COMPACT);
    json_decref(tag);
    return made;
}
