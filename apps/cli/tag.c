#include "tag.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "output.h"
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
    bool in_rounds = desc->noise > 0 || desc->time_limit > 0;
    if (o->value[OPT_SAMPLES] != NULL || in_rounds || desc->pixel_center == (desc->samples == 1)) {
        snprintf(text, sizeof text, "%" PRIu32, desc->samples);
        append(list, "samples", text);
    }
    if (desc->noise > 0) {
        text_format_float(desc->noise, text);
        append(list, "noise", text);
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
    const char *white = o->value[OPT_WHITE_BALANCE];
    if (white == NULL) white = snell_film_white_balance(film);
    if (*white != '\0') append(list, "white-balance", white);
}

static bool is_setting(option_id id) {
    return id == OPT_INTEGRATOR || id == OPT_SIZE || id == OPT_SAMPLES || id == OPT_NOISE ||
           id == OPT_MAX_DEPTH || id == OPT_MIN_WEIGHT || id == OPT_SEED || id == OPT_FRAME ||
           id == OPT_EXPOSURE || id == OPT_TONEMAP || id == OPT_WHITE_BALANCE;
}

/* ---- what a noise reached ---- */

/* The samples of blocks, row by row: one character each, its place after '0' among the counts that
 * there are, which are few. */
enum { BLOCK = 16, COUNTS_MAX = 40, TAG_BLOCKS_MAX = 1 << 19 };

typedef struct block_grid {
    uint32_t left, top, width, height, columns, rows; /* of pixels; of blocks */
} block_grid;

static block_grid grid_of(const snell_render_desc *d) {
    bool crop = d->crop_width > 0;
    block_grid g = {.left = crop ? d->crop_x % BLOCK : 0,
                    .top = crop ? d->crop_y % BLOCK : 0,
                    .width = crop ? d->crop_width : d->width,
                    .height = crop ? d->crop_height : d->height};
    g.columns = (g.left + g.width + BLOCK - 1) / BLOCK;
    g.rows = (g.top + g.height + BLOCK - 1) / BLOCK;
    return g;
}

/* Where a block begins in the film. */
static uint32_t first_of(uint32_t block, uint32_t offset) {
    return block == 0 ? 0 : block * BLOCK - offset;
}

static void append_blocks(json_t *to, const snell_render_desc *desc, const uint32_t *samples) {
    block_grid g = grid_of(desc);
    size_t count = (size_t)g.columns * g.rows, kinds = 0;
    char *letters = count <= TAG_BLOCKS_MAX ? malloc(count + 1) : NULL;
    uint32_t counts[COUNTS_MAX];
    if (letters == NULL || samples == NULL) {
        free(letters);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        uint32_t x = first_of((uint32_t)(i % g.columns), g.left),
                 y = first_of((uint32_t)(i / g.columns), g.top);
        uint32_t has = samples[(size_t)y * g.width + x];
        size_t k = 0;
        while (k < kinds && counts[k] != has) k++;
        if (k == kinds && kinds < COUNTS_MAX) counts[kinds++] = has;
        letters[i] = (char)('0' + k);
    }
    json_t *list = json_array();
    for (size_t k = 0; k < kinds; k++) json_array_append_new(list, json_integer(counts[k]));
    json_object_set_new(to, "counts", list);
    json_object_set_new(to, "of_blocks", json_stringn(letters, count));
    free(letters);
}

uint32_t tag_samples(const json_t *tag, const snell_render_desc *desc, uint32_t x, uint32_t y) {
    const json_t *noise = json_object_get(tag, "noise");
    const json_t *letters = json_object_get(noise, "of_blocks");
    block_grid g = grid_of(desc);
    size_t block = (size_t)((y + g.top) / BLOCK) * g.columns + (x + g.left) / BLOCK;
    if (block >= json_string_length(letters)) return 0;
    size_t kind = (size_t)(unsigned char)json_string_value(letters)[block] - '0';
    json_int_t has = json_integer_value(json_array_get(json_object_get(noise, "counts"), kind));
    return has >= 4 && has <= desc->samples ? (uint32_t)has : 0;
}

json_t *tag_noise(const snell_render_stats *s) {
    json_t *noise = json_object(), *samples = json_object();
    json_object_set_new(noise, "bound", json_real(s->noise_bound));
    json_object_set_new(noise, "confidence", json_real(s->noise_confidence));
    json_object_set_new(noise, "blocks", json_integer((json_int_t)s->noise_blocks));
    json_object_set_new(noise, "blocks_done", json_integer((json_int_t)s->noise_blocks_done));
    json_object_set_new(samples, "min", json_integer((json_int_t)s->samples_min));
    json_object_set_new(samples, "mean", json_real(s->samples_mean));
    json_object_set_new(samples, "max", json_integer((json_int_t)s->samples_done));
    json_object_set_new(noise, "samples", samples);
    return noise;
}

static json_t *noise_of(const snell_render_desc *desc, const snell_film *film) {
    snell_render_stats stats = {.struct_size = sizeof stats};
    snell_film_get_stats(film, &stats);
    json_t *noise = tag_noise(&stats);
    append_blocks(noise, desc, snell_film_samples(film));
    return noise;
}

static json_t *begin_tag(const stage *s, const snell_render_desc *desc, const snell_film *film,
                         uint32_t frame) {
    const options *o = s->options;
    json_t *tag = json_object(), *list = json_array();
    char digits[32];
    snprintf(digits, sizeof digits, "%016" PRIx64, s->hash);
    append_settings(list, o, desc, film, frame);
    if (s->camera[0] != '\0') append(list, "camera", s->camera);
    for (size_t i = 0; i < option_table_count; i++) {
        const option_info *info = &option_table[i];
        if ((info->flags & OPTION_PICTURE) == 0 || (info->flags & OPTION_HIDDEN) != 0) continue;
        const string_list *values = info->id == OPT_SET ? &o->set : &o->allow;
        if ((info->flags & OPTION_REPEATS) != 0) {
            for (size_t k = 0; k < values->count; k++) append(list, info->name, values->items[k]);
        } else if (info->id == OPT_CAMERA && s->values->all_cameras) {
            continue;
        } else if (!is_setting(info->id) && o->value[info->id] != NULL) {
            append(list, info->name, o->value[info->id]);
        }
    }
    json_object_set_new(tag, "snell", json_string(snell_version()));
    json_object_set_new(tag, "file", report_text(s->input));
    json_object_set_new(tag, "scene", json_string(digits));
    json_object_set_new(tag, "options", list);
    return tag;
}

static char *end_tag(json_t *tag) {
    char *text = json_dumps(tag, JSON_COMPACT | JSON_REAL_PRECISION(6));
    json_decref(tag);
    return text;
}

char *tag_make(const stage *s, const snell_film *film, bool partial) {
    const snell_render_desc *desc = &s->desc;
    json_t *tag =
        begin_tag(s, desc, film, s->session->turn > 0 ? s->session->turn : s->session->frame);
    if (desc->noise > 0) json_object_set_new(tag, "noise", noise_of(desc, film));
    if (partial) json_object_set_new(tag, "partial", json_true());
    return end_tag(tag);
}

char *tag_make_movie(const stage *s, const snell_render_desc *asked, const snell_film *film,
                     double fps) {
    const char *frames = s->options->value[OPT_FRAMES];
    uint32_t one = s->options->value[OPT_FRAME] != NULL ? s->values->frame_first : 0;
    json_t *tag = begin_tag(s, asked, film, one), *movie = json_object();
    if (frames != NULL) json_object_set_new(movie, "frames", report_text(frames));
    json_object_set_new(movie, "fps", json_real(fps));
    json_object_set_new(tag, "animation", movie);
    return end_tag(tag);
}

bool tag_is_picture(const char *path) {
    snell_picture_format_info format;
    return output_find_format(output_extension(path), &format) && (format.tag || format.picture);
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

bool tag_has_frames(const json_t *tag) {
    bool chosen = json_object_get(json_object_get(tag, "animation"), "frames") != NULL;
    return chosen || (tag_option(tag, "turntable") != NULL && tag_option(tag, "frame") == NULL);
}

uint32_t tag_first_frame(const json_t *tag) {
    const json_t *movie = json_object_get(tag, "animation");
    const char *frames = json_string_value(json_object_get(movie, "frames"));
    if (frames == NULL || tag_option(tag, "turntable") != NULL) return 0;
    return (uint32_t)strtoul(frames, NULL, 10);
}

static void replace(json_t *list, const char *name, const char *value) {
    for (size_t i = json_array_size(list); i > 0; i--) {
        if (value_in(json_array_get(list, i - 1), name) != NULL) json_array_remove(list, i - 1);
    }
    append(list, name, value);
}

char *tag_convert(const char *text, const options *o, bool linear) {
    static const option_id ids[] = {OPT_LAYER, OPT_EXPOSURE, OPT_TONEMAP, OPT_WHITE_BALANCE};
    static const char *const names[] = {"layer", "exposure", "tonemap", "white-balance"};
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
    char *made = json_dumps(tag, JSON_COMPACT | JSON_REAL_PRECISION(6));
    json_decref(tag);
    return made;
}
