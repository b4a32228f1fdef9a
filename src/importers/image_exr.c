/* OpenEXR, by OpenEXRCore: the channels of one layer, in rows or tiles (of mip maps the largest), of any sample type
 * and compression but those that the core of 3.1 lacks, DWA, or gets wrong, B44 of channels of 32 bits. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/image_float.h"

#if SNELL_HAS_OPENEXR
#include <openexr.h>

typedef struct memory_file {
    const uint8_t *data;
    size_t size;
} memory_file;

static int64_t read_at(exr_const_context_t context, void *user, void *buffer, uint64_t size,
                       uint64_t offset, exr_stream_error_func_ptr_t report) {
    (void)context, (void)report;
    const memory_file *file = user;
    if (offset >= file->size) return 0;
    uint64_t left = file->size - offset, count = size < left ? size : left;
    memcpy(buffer, file->data + offset, (size_t)count);
    return (int64_t)count;
}

static int64_t file_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((const memory_file *)user)->size;
}

static void on_error(exr_const_context_t context, exr_result_t code, const char *text) {
    (void)context, (void)code, (void)text; /* the result says enough; the default would print */
}

/* ---- which channels ---- */

typedef struct exr_channel {
    const char *full, *base; /* the name, and what stands after its last dot */
    const char *layer;       /* what stands before, or the name of the part */
    size_t layer_length;
    const char *part; /* the name of the part, "" without one */
    bool is_plain;    /* of the first part, without a dot */
} exr_channel;

/* The names belong to the open file; places that stay NULL are 0, alpha 1. */
typedef struct exr_selection {
    int part;
    const char *places[4]; /* full names for red, green, blue, alpha */
    bool is_grey;          /* the first goes to all three */
} exr_selection;

static exr_channel channel_of(const char *part_name, int part, const char *name) {
    const char *dot = strrchr(name, '.');
    if (part_name == NULL) part_name = "";
    if (dot) return (exr_channel){name, dot + 1, name, (size_t)(dot - name), part_name, false};
    return (exr_channel){name, name, part_name, strlen(part_name), part_name, part == 0};
}

static bool is_color(const char *base) {
    static const char *const names[] = {"R", "G", "B", "A", "Y", "RY", "BY"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (strcmp(base, names[i]) == 0) return true;
    return false;
}

static bool is_in_layer(const exr_channel *c, const char *layer) {
    if (layer[0] == '\0') return c->is_plain && is_color(c->base);
    if (strcmp(c->part, layer) == 0) return true;
    return c->layer_length == strlen(layer) && memcmp(c->layer, layer, c->layer_length) == 0;
}

enum { LAYER_CHANNELS_MAX = 64 };
typedef struct exr_layer {
    exr_channel channels[LAYER_CHANNELS_MAX];
    size_t count;
} exr_layer;

static const char *find_base(const exr_layer *layer, const char *base) {
    for (size_t i = 0; i < layer->count; i++)
        if (strcmp(layer->channels[i].base, base) == 0) return layer->channels[i].full;
    return NULL;
}

/* Colours, X Y Z, U V, or grey; else the first three. False: there is nothing but alpha. */
static bool choose_places(const exr_layer *layer, exr_selection *out) {
    static const char *const sets[][3] = {{"R", "G", "B"}, {"X", "Y", "Z"}, {"U", "V", "W"}};
    out->places[3] = find_base(layer, "A");
    for (size_t i = 0; i < sizeof sets / sizeof sets[0]; i++) {
        size_t found = 0;
        for (int c = 0; c < 3; c++)
            if ((out->places[c] = find_base(layer, sets[i][c])) != NULL) found++;
        if (found > (i > 0)) return true; /* Y alone is grey */
    }
    memset(out->places, 0, 3 * sizeof out->places[0]);
    out->places[0] = find_base(layer, "Y");
    out->is_grey = out->places[0] != NULL;
    for (size_t i = 0, c = 0; !out->is_grey && i < layer->count && c < 3; i++)
        if (layer->channels[i].full != out->places[3]) out->places[c++] = layer->channels[i].full;
    if (out->places[1] == NULL) out->is_grey = true;
    return out->places[0] != NULL;
}

typedef bool visit_channel(void *user, int part, const exr_channel *channel);

/* Calls for each channel of each part, until false. */
static void each_channel(exr_context_t file, visit_channel *visit, void *user) {
    int parts = 0;
    if (exr_get_count(file, &parts)) return;
    for (int part = 0; part < parts; part++) {
        const exr_attr_chlist_t *list;
        const char *part_name = NULL;
        exr_get_name(file, part, &part_name); /* without a name NULL stays */
        if (exr_get_channels(file, part, &list)) continue;
        for (int i = 0; i < list->num_channels; i++) {
            exr_channel channel = channel_of(part_name, part, list->entries[i].name.str);
            if (!visit(user, part, &channel)) return;
        }
    }
}

typedef struct exr_search {
    const char *wanted;
    exr_layer layer;
    exr_selection selection; /* part -1: not found */
    const char *full;        /* the channel of this full name, and its part */
    int full_part;
} exr_search;

static bool search(void *user, int part, const exr_channel *c) {
    exr_search *s = user;
    if (s->selection.part >= 0 && part != s->selection.part) return false;
    if (s->full == NULL && strcmp(c->full, s->wanted) == 0) s->full = c->full, s->full_part = part;
    if (!is_in_layer(c, s->wanted)) return true;
    s->selection.part = part;
    if (s->layer.count < LAYER_CHANNELS_MAX) s->layer.channels[s->layer.count++] = *c;
    return true;
}

static bool select_channels(exr_context_t file, const char *layer, exr_selection *out) {
    exr_search s = {.wanted = layer, .selection = {.part = -1}};
    each_channel(file, search, &s);
    *out = s.selection;
    if (out->part >= 0) return choose_places(&s.layer, out);
    *out = (exr_selection){.part = s.full_part, .places = {s.full}, .is_grey = true};
    return s.full != NULL;
}

/* ---- the names of all layers, one after the other ---- */

enum { NAMES_MAX = 256, NAME_LENGTH_MAX = 255 };

typedef struct exr_names {
    image_names *names;
    size_t count, capacity;
    bool no_memory;
} exr_names;

static bool has_name(const image_names *names, const char *name, size_t length) {
    for (const char *at = names->text; at < names->text + names->size; at += strlen(at) + 1)
        if (strlen(at) == length && memcmp(at, name, length) == 0) return true;
    return false;
}

static bool add_name(exr_names *n, const char *name, size_t length) {
    if (length == 0 || length > NAME_LENGTH_MAX || has_name(n->names, name, length)) return true;
    if (!ARRAY_GROW(n->names->text, n->names->size, n->capacity, length + 1)) {
        n->no_memory = true;
        return false;
    }
    memcpy(n->names->text + n->names->size, name, length);
    n->names->text[n->names->size + length] = '\0';
    n->names->size += length + 1;
    return ++n->count < NAMES_MAX;
}

/* That of a part, and those of the layers in it. */
static bool collect_name(void *user, int part, const exr_channel *c) {
    exr_names *n = user;
    if (part > 0 && !add_name(n, c->part, strlen(c->part))) return false;
    bool by_itself = c->layer_length == 0 || (c->is_plain && !is_color(c->base));
    const char *name = by_itself ? c->full : c->layer;
    size_t length = by_itself ? strlen(name) : c->layer_length;
    if (by_itself && is_color(c->full)) return true; /* what no name at all stands for */
    return add_name(n, name, length);
}

static snell_status collect_names(exr_context_t file, image_names *out) {
    exr_names n = {.names = out};
    each_channel(file, collect_name, &n);
    return n.no_memory ? error_no_memory() : SNELL_OK;
}

static snell_status no_such_layer(exr_context_t file, const char *layer) {
    image_names names = {0};
    const char *list[NAMES_MAX];
    size_t count = 0;
    char hint[512] = "";
    snell_status status = collect_names(file, &names);
    for (const char *at = names.text; at < names.text + names.size; at += strlen(at) + 1) {
        size_t used = strlen(hint);
        snprintf(hint + used, sizeof hint - used, "%s%s", count ? ", " : "its layers: ", at);
        list[count++] = at;
    }
    const char *near = layer[0] ? closest_word(layer, list, count) : NULL;
    if (near) snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    if (!status && layer[0])
        status = error_set(SNELL_ERR_ARGUMENT, hint[0] ? hint : "it has no layers",
                           "there is no layer '%s'", layer);
    else if (!status)
        status = error_set(SNELL_ERR_SYNTAX, hint[0] ? hint : NULL,
                           "an OpenEXR image without channels R, G, B or Y");
    free(names.text);
    return status;
}

/* ---- pixels ---- */

typedef struct exr_job {
    exr_context_t file;
    exr_selection selection;
    exr_decode_pipeline_t decode;
    bool started, lacks; /* lacks: the compression */
    float *rows; /* of one chunk: five places, one after the other, each of all its pixels */
} exr_job;

/* Each channel to pixels of its own: OpenEXRCore 3.1 exchanges the channels of R G B A in 16 bits
 * where they are to be interleaved. Where there are no more than four it writes to all of them, wanted or
 * not: those go to a fifth place. false: a channel that is coarser than the picture. */
static bool aim_channels(exr_job *job, const exr_chunk_info_t *chunk) {
    for (int c = 0; c < job->decode.channel_count; c++) {
        exr_coding_channel_info_t *channel = &job->decode.channels[c];
        size_t place = 0;
        while (place < 4 && (job->selection.places[place] == NULL ||
                             strcmp(channel->channel_name, job->selection.places[place]) != 0))
            place++;
        channel->decode_to_ptr = NULL;
        if (place == 4 && job->decode.channel_count > 4) continue;
        if (place < 4 && (channel->x_samples != 1 || channel->y_samples != 1)) return false;
        float *pixels = job->rows + place * (size_t)chunk->width * (size_t)chunk->height;
        channel->decode_to_ptr = (uint8_t *)pixels;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = (int32_t)((size_t)chunk->width * sizeof(float));
    }
    return true;
}

/* To `to`, the first pixel of the chunk in rows of so many pixels. */
static bool read_chunk(exr_job *job, const exr_chunk_info_t *chunk, float *to, size_t row_width) {
    int part = job->selection.part;
    bool first = !job->started;
    if (first ? exr_decoding_initialize(job->file, part, chunk, &job->decode)
              : exr_decoding_update(job->file, part, chunk, &job->decode))
        return false;
    job->started = true;
    if (!aim_channels(job, chunk)) return false;
    if (first && exr_decoding_choose_default_routines(job->file, part, &job->decode)) return false;
    exr_result_t failed = exr_decoding_run(job->file, part, &job->decode);
    job->lacks = failed == EXR_ERR_FEATURE_NOT_IMPLEMENTED;
    if (failed) return false;
    size_t width = (size_t)chunk->width, height = (size_t)chunk->height, count = width * height;
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++)
            for (size_t place = 0; place < 4; place++)
                if (job->selection.places[place])
                    to[4 * (y * row_width + x) + place] = job->rows[place * count + y * width + x];
    return true;
}

static bool read_rows(exr_job *job, const exr_attr_box2i_t *window, int32_t step,
                      decoded_image *image) {
    for (int64_t y = window->min.y; y <= window->max.y; y += step) {
        exr_chunk_info_t chunk;
        if (exr_read_scanline_chunk_info(job->file, job->selection.part, (int)y, &chunk))
            return false;
        if (chunk.start_y < window->min.y || chunk.height > window->max.y - chunk.start_y + 1 ||
            chunk.height < 1 || chunk.height > step || (uint32_t)chunk.width != image->width)
            return false;
        float *to = (float *)(void *)image->pixels +
                    (size_t)(chunk.start_y - window->min.y) * image->width * 4;
        if (!read_chunk(job, &chunk, to, image->width)) return false;
    }
    return true;
}

/* Those at the right and below are cut off by the picture. */
static bool read_tiles(exr_job *job, uint32_t tile_width, uint32_t tile_height,
                       decoded_image *image) {
    float *pixels = (float *)(void *)image->pixels;
    for (uint32_t y = 0; y < image->height; y += tile_height)
        for (uint32_t x = 0; x < image->width; x += tile_width) {
            exr_chunk_info_t chunk;
            if (exr_read_tile_chunk_info(job->file, job->selection.part, (int)(x / tile_width),
                                         (int)(y / tile_height), 0, 0, &chunk))
                return false;
            uint32_t right = image->width - x, below = image->height - y;
            if (chunk.width != (int32_t)(right < tile_width ? right : tile_width) ||
                chunk.height != (int32_t)(below < tile_height ? below : tile_height))
                return false;
            if (!read_chunk(job, &chunk, pixels + 4 * ((size_t)y * image->width + x), image->width))
                return false;
        }
    return true;
}

/* OpenEXRCore 3.1 gives wrong pixels. */
static bool is_garbled(exr_job *job) {
    exr_compression_t compression;
    const exr_attr_chlist_t *list;
    if (exr_get_compression(job->file, job->selection.part, &compression) ||
        exr_get_channels(job->file, job->selection.part, &list))
        return false;
    if (compression != EXR_COMPRESSION_B44 && compression != EXR_COMPRESSION_B44A) return false;
    for (int i = 0; i < list->num_channels; i++)
        if (list->entries[i].pixel_type != EXR_PIXEL_HALF) return true;
    return false;
}

/* *width and *height: of a tile, or of the rows of a chunk, no more than the picture has. */
static bool chunk_size(exr_job *job, bool tiled, const decoded_image *image, uint32_t *width,
                       uint32_t *height) {
    uint32_t tile[2] = {image->width, 0};
    int32_t rows;
    exr_tile_level_mode_t levels;
    exr_tile_round_mode_t rounding;
    if (tiled) {
        if (exr_get_tile_descriptor(job->file, job->selection.part, &tile[0], &tile[1], &levels,
                                    &rounding))
            return false;
    } else {
        if (exr_get_scanlines_per_chunk(job->file, job->selection.part, &rows) || rows < 1)
            return false;
        tile[1] = (uint32_t)rows;
    }
    *width = tile[0] < image->width ? tile[0] : image->width;
    *height = tile[1] < image->height ? tile[1] : image->height;
    return tile[0] > 0 && tile[1] > 0;
}

static void complete(const exr_selection *selection, decoded_image *image) {
    float *p = (float *)(void *)image->pixels;
    size_t count = (size_t)image->width * image->height;
    image->opaque = selection->places[3] == NULL;
    for (size_t i = 0; i < count; i++, p += 4) {
        if (selection->is_grey) p[1] = p[2] = p[0];
        if (image->opaque) p[3] = 1;
    }
}

static snell_status read_part(exr_job *job, size_t size_max, decoded_image *out) {
    int part = job->selection.part;
    exr_attr_box2i_t window;
    exr_storage_t storage;
    if (exr_get_data_window(job->file, part, &window) || exr_get_storage(job->file, part, &storage))
        return error_set(SNELL_ERR_SYNTAX, NULL, "a broken OpenEXR image");
    bool tiled = storage == EXR_STORAGE_TILED;
    if (!tiled && storage != EXR_STORAGE_SCANLINE)
        return error_set(SNELL_ERR_UNSUPPORTED, "save it flattened",
                         "an OpenEXR image of deep pixels cannot be read");
    int64_t width = (int64_t)window.max.x - window.min.x + 1,
            height = (int64_t)window.max.y - window.min.y + 1;
    out->width = width < 0 || width > UINT32_MAX ? 0 : (uint32_t)width;
    out->height = height < 0 || height > UINT32_MAX ? 0 : (uint32_t)height;
    uint32_t across, down;
    snell_status status = image_make_float_room(out, size_max);
    if (status) return status;
    if (!chunk_size(job, tiled, out, &across, &down))
        return error_set(SNELL_ERR_SYNTAX, NULL, "a broken OpenEXR image");
    job->rows = memory_resize(NULL, (size_t)across * down, 5 * sizeof(float));
    if (job->rows == NULL) return error_no_memory();
    job->lacks = is_garbled(job);
    bool done = !job->lacks && (tiled ? read_tiles(job, across, down, out)
                                      : read_rows(job, &window, (int32_t)down, out));
    if (job->lacks)
        return error_set(SNELL_ERR_UNSUPPORTED, "save it with another, such as ZIP or PIZ",
                         "an OpenEXR image whose compression cannot be read");
    if (!done)
        return error_set(SNELL_ERR_SYNTAX, NULL,
                         "an OpenEXR image that is broken, or whose channels are not all as fine");
    complete(&job->selection, out);
    return SNELL_OK;
}

snell_status image_decode_exr(const void *data, size_t size, size_t size_max, const char *layer,
                              image_names *layers, decoded_image *out) {
    memory_file memory = {data, size};
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.user_data = &memory;
    how.read_fn = read_at;
    how.size_fn = file_size;
    how.error_handler_fn = on_error;
    exr_job job = {.decode = EXR_DECODE_PIPELINE_INITIALIZER};
    if (exr_start_read(&job.file, "image", &how))
        return error_set(SNELL_ERR_SYNTAX, NULL, "a broken OpenEXR image");
    snell_status status = select_channels(job.file, layer, &job.selection)
                              ? read_part(&job, size_max, out)
                              : no_such_layer(job.file, layer);
    if (!status && layers) status = collect_names(job.file, layers);
    if (job.started) exr_decoding_destroy(job.file, &job.decode);
    exr_finish(&job.file);
    free(job.rows);
    return status;
}

#else

snell_status image_decode_exr(const void *data, size_t size, size_t size_max, const char *layer,
                              image_names *layers, decoded_image *out) {
    (void)data, (void)size, (void)size_max, (void)layer, (void)layers, (void)out;
    return error_set(SNELL_ERR_UNSUPPORTED, "build with -DSNELL_OPENEXR=ON",
                     "this build cannot read OpenEXR images");
}

#endif
