/* OpenEXR: linear floats, ZIP, channels R G B (A, premultiplied) of 32 or 16 bits, and, always of 32, of a render with a noise
 * variance.R variance.G variance.B and samples (whole numbers); the tag is the string attribute
 * "snell". A film with layers becomes a file of several parts: the picture, then each layer, named
 * after it. Written by OpenEXRCore into memory; a file's head is read by hand, since a
 * foreign file must not meet a decoder outside of the sandbox. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/aov.h"
#include "image/codec.h"

static const char attribute[] = "snell";

/* ---- writing ---- */

#if SNELL_HAS_OPENEXR
#include <openexr.h>

typedef struct exr_stream {
    image_buffer *out;
    bool no_memory;
} exr_stream;

/* The file is a buffer: what lies beyond its end is filled with zeros first. */
static int64_t write_at(exr_const_context_t context, void *user, const void *data, uint64_t size,
                        uint64_t offset, exr_stream_error_func_ptr_t report) {
    (void)context;
    (void)report;
    exr_stream *stream = user;
    static const uint8_t zeros[256];
    image_buffer *out = stream->out;
    while (out->size < offset) {
        uint64_t gap = offset - out->size;
        if (!image_buffer_add(out, zeros, gap < sizeof zeros ? (size_t)gap : sizeof zeros)) {
            stream->no_memory = true;
            return -1;
        }
    }
    uint64_t over = out->size - offset; /* rewritten, such as the table of chunks */
    if (over > size) over = size;
    if (over) memcpy(out->data + offset, data, (size_t)over);
    if (!image_buffer_add(out, (const uint8_t *)data + over, (size_t)(size - over))) {
        stream->no_memory = true;
        return -1;
    }
    return (int64_t)size;
}

static void on_error(exr_const_context_t context, exr_result_t code, const char *text) {
    (void)context; /* the result says enough; the default would print */
    (void)code;
    (void)text;
}

/* To the nearest half, ties to even; what is finite stays finite. */
static uint16_t half_of(float value) {
    enum { EXPONENT_ALL = 0x7f800000, LARGEST = 0x477fe000, SMALLEST_NORMAL = 0x38800000 };
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t sign = bits >> 16 & 0x8000, size = bits & 0x7fffffff;
    if (size > EXPONENT_ALL) return (uint16_t)(sign | 0x7e00);
    if (size == EXPONENT_ALL) return (uint16_t)(sign | 0x7c00);
    if (size >= LARGEST) return (uint16_t)(sign | 0x7bff);
    if (size < SMALLEST_NORMAL) /* in steps of 2^-24 */
        return (uint16_t)(sign | (uint32_t)lrint(fabs((double)value) * 0x1p24));
    return (uint16_t)(sign | (size - 0x38000000 + 0xfff + (size >> 13 & 1)) >> 13);
}

/* NULL: no memory. */
static uint16_t *halves_of(const image_pixels *pixels) {
    size_t count = (size_t)pixels->width * pixels->height * pixels->channels;
    uint16_t *halves = memory_resize(NULL, count, sizeof *halves);
    for (size_t i = 0; halves && i < count; i++) halves[i] = half_of(pixels->data[i]);
    return halves;
}

typedef struct exr_channel {
    char name[AOV_NAME_MAX];
    exr_pixel_type_t type;
    const void *first;
    uint32_t stride; /* bytes from one pixel's value to the next's */
    exr_perceptual_treatment_t kind;
} exr_channel;

enum { PART_CHANNELS_MAX = AOV_CHANNELS_MAX };
_Static_assert(PART_CHANNELS_MAX >= 4 + 3 + 1, "a picture, its variance, its samples");

/* What becomes one part of the file. */
typedef struct exr_part {
    const char *name; /* NULL: the file has no other */
    uint32_t width, height, channel_count;
    exr_channel channels[PART_CHANNELS_MAX];
    const film_layer *layer; /* NULL: the picture */
} exr_part;

static exr_channel *add_channel(exr_part *p, const float *pixels, uint32_t place, uint32_t count) {
    exr_channel *c = &p->channels[p->channel_count++];
    *c = (exr_channel){"", EXR_PIXEL_FLOAT, pixels + place, 4 * count, EXR_PERCEPTUALLY_LINEAR};
    return c;
}

/* halves: the picture's, NULL where it is written as it is. */
static void picture_part(const image_pixels *pixels, const image_options *options,
                         const uint16_t *halves, exr_part *p) {
    *p = (exr_part){.name = options->layer_count ? "picture" : NULL,
                    .width = pixels->width,
                    .height = pixels->height};
    for (uint32_t i = 0; i < pixels->channels; i++) {
        exr_channel *c = add_channel(p, pixels->data, i, pixels->channels);
        snprintf(c->name, sizeof c->name, "%c", "RGBA"[i]);
        if (halves) {
            c->type = EXR_PIXEL_HALF;
            c->first = halves + i;
            c->stride = 2 * pixels->channels;
        }
        c->kind = EXR_PERCEPTUALLY_LOGARITHMIC;
    }
    for (uint32_t i = 0; options->variance && i < 3; i++)
        snprintf(add_channel(p, options->variance, i, 3)->name, AOV_NAME_MAX, "variance.%c",
                 "RGB"[i]);
    if (options->samples)
        p->channels[p->channel_count++] =
            (exr_channel){"samples", EXR_PIXEL_UINT, options->samples, 4, EXR_PERCEPTUALLY_LINEAR};
}

static void layer_part(const film_layer *layer, exr_part *p) {
    *p = (exr_part){
        .name = layer->name, .width = layer->width, .height = layer->height, .layer = layer};
    for (uint32_t i = 0; i < layer->channels; i++)
        aov_channel_name(layer, i, add_channel(p, layer->pixels, i, layer->channels)->name);
}

static void part_of(const image_pixels *pixels, const image_options *options,
                    const uint16_t *halves, size_t index, exr_part *out) {
    if (index == 0)
        picture_part(pixels, options, halves, out);
    else
        layer_part(&options->layers[index - 1], out);
}

/* Cryptomatte's four attributes, under the first seven digits of the hash of its name. */
static exr_result_t write_manifest(exr_context_t file, int part, const film_layer *layer) {
    const char *name = layer->kind->layer;
    const char *const rows[4][2] = {{"name", name},
                                    {"hash", "MurmurHash3_32"},
                                    {"conversion", "uint32_to_float32"},
                                    {"manifest", layer->manifest}};
    exr_result_t failed = EXR_ERR_SUCCESS;
    for (size_t i = 0; !failed && i < sizeof rows / sizeof rows[0]; i++) {
        char key[64];
        snprintf(key, sizeof key, "cryptomatte/%.7x/%s", crypto_hash(name) >> 4, rows[i][0]);
        failed = exr_attr_set_string(file, part, key, rows[i][1]);
    }
    return failed;
}

static exr_result_t write_part_head(exr_context_t file, const exr_part *p, const char *tag) {
    int part;
    exr_result_t failed = exr_add_part(file, p->name, EXR_STORAGE_SCANLINE, &part);
    if (!failed)
        failed = exr_initialize_required_attr_simple(file, part, (int32_t)p->width,
                                                     (int32_t)p->height, EXR_COMPRESSION_ZIP);
    if (!failed) failed = exr_set_zip_compression_level(file, part, 4);
    for (uint32_t i = 0; !failed && i < p->channel_count; i++) {
        const exr_channel *c = &p->channels[i];
        failed = exr_add_channel(file, part, c->name, c->type, c->kind, 1, 1);
    }
    if (!failed && p->layer && p->layer->manifest) failed = write_manifest(file, part, p->layer);
    if (!failed && !p->layer && tag[0]) failed = exr_attr_set_string(file, part, attribute, tag);
    return failed;
}

static exr_result_t write_head(exr_context_t file, const image_pixels *pixels,
                               const image_options *options, const uint16_t *halves) {
    exr_result_t failed = exr_set_longname_support(file, 1);
    for (size_t i = 0; !failed && i <= options->layer_count; i++) {
        exr_part p;
        part_of(pixels, options, halves, i, &p);
        failed = write_part_head(file, &p, options->tag);
    }
    return failed ? failed : exr_write_header(file);
}

/* The file sorts channels by name. */
static const exr_channel *find_channel(const exr_part *p, const char *name) {
    uint32_t i = 0;
    while (i + 1 < p->channel_count && strcmp(p->channels[i].name, name) != 0) i++;
    return &p->channels[i];
}

static exr_result_t write_rows(exr_context_t file, int part, const exr_part *p) {
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t step = 0;
    const exr_channel *sources[PART_CHANNELS_MAX];
    bool started = false;
    exr_result_t failed = exr_get_scanlines_per_chunk(file, part, &step);
    for (uint32_t y = 0; !failed && y < p->height; y += (uint32_t)step) {
        exr_chunk_info_t chunk;
        failed = exr_write_scanline_chunk_info(file, part, (int)y, &chunk);
        if (failed) break;
        failed = started ? exr_encoding_update(file, part, &chunk, &pipeline)
                         : exr_encoding_initialize(file, part, &chunk, &pipeline);
        if (failed) break;
        for (int16_t c = 0; c < pipeline.channel_count; c++) {
            exr_coding_channel_info_t *channel = &pipeline.channels[c];
            if (!started) sources[c] = find_channel(p, channel->channel_name);
            const exr_channel *from = sources[c];
            size_t row = (size_t)p->width * from->stride;
            channel->encode_from_ptr = (const uint8_t *)from->first + y * row;
            channel->user_bytes_per_element = from->type == EXR_PIXEL_HALF ? 2 : 4;
            channel->user_data_type = (uint16_t)from->type;
            channel->user_pixel_stride = (int32_t)from->stride;
            channel->user_line_stride = (int32_t)row;
        }
        if (!started) failed = exr_encoding_choose_default_routines(file, part, &pipeline);
        started = true;
        if (!failed) failed = exr_encoding_run(file, part, &pipeline);
    }
    if (started) exr_encoding_destroy(file, &pipeline);
    return failed;
}

static snell_status encode(const image_pixels *pixels, const image_options *options,
                           image_buffer *out) {
    exr_stream stream = {out, false};
    uint16_t *halves = options->bits == 16 ? halves_of(pixels) : NULL;
    if (options->bits == 16 && halves == NULL) return error_no_memory();
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.user_data = &stream;
    setup.write_fn = write_at;
    setup.error_handler_fn = on_error;
    exr_context_t file = NULL;
    exr_result_t failed = exr_start_write(&file, "picture", EXR_WRITE_FILE_DIRECTLY, &setup);
    if (!failed) failed = write_head(file, pixels, options, halves);
    for (size_t i = 0; !failed && i <= options->layer_count; i++) {
        exr_part p;
        part_of(pixels, options, halves, i, &p);
        failed = write_rows(file, (int)i, &p);
    }
    if (file) {
        exr_result_t closing = exr_finish(&file);
        if (!failed) failed = closing;
    }
    free(halves);
    if (!failed) return SNELL_OK;
    if (stream.no_memory || failed == EXR_ERR_OUT_OF_MEMORY) return error_no_memory();
    return error_set(SNELL_ERR_INTERNAL, "try .pfm", "OpenEXR failed: %s",
                     exr_get_default_error_message(failed));
}

#endif

/* ---- reading the head: magic, version, then attributes of name, type, size, value ---- */

typedef struct exr_reader {
    const uint8_t *at, *end;
} exr_reader;

static uint32_t little_endian(const uint8_t *p) {
    return (uint32_t)p[3] << 24 | (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 | p[0];
}

/* A string that ends with a zero, of at most 255 bytes; NULL when there is none. */
static const char *read_name(exr_reader *r) {
    size_t left = (size_t)(r->end - r->at), most = left < 256 ? left : 256;
    const uint8_t *start = r->at, *zero = most ? memchr(start, 0, most) : NULL;
    if (zero == NULL) return NULL;
    r->at = zero + 1;
    return (const char *)start;
}

/* name, pixel type, linear flag and padding, x and y sampling; an empty name ends the list. */
static bool read_channels(exr_reader r, image_info *out) {
    out->channels = 0;
    out->bits = 16;
    for (;;) {
        const char *name = read_name(&r);
        if (name == NULL) return false;
        if (name[0] == '\0') return out->channels > 0;
        if (r.end - r.at < 16) return false;
        uint32_t type = little_endian(r.at);
        if (type > 2) return false;
        if (type != 1) out->bits = 32; /* 0 unsigned int, 1 half, 2 float */
        r.at += 16;
        out->channels++;
    }
}

static bool read_window(exr_reader r, image_info *out) {
    if (r.end - r.at != 16) return false;
    int64_t low[2], high[2], size[2];
    for (int i = 0; i < 2; i++) {
        low[i] = (int32_t)little_endian(r.at + 4 * i);
        high[i] = (int32_t)little_endian(r.at + 8 + 4 * i);
        size[i] = high[i] - low[i] + 1;
        if (size[i] < 1 || size[i] > INT32_MAX) return false;
    }
    out->width = (uint32_t)size[0];
    out->height = (uint32_t)size[1];
    return true;
}

static bool is_attribute(const char *name, const char *type, const char *its_name,
                         const char *its_type) {
    return strcmp(name, its_name) == 0 && strcmp(type, its_type) == 0;
}

/* The places of two attributes, empty where there are none. */
typedef struct exr_header {
    exr_reader name, channels;
} exr_header;

/* The attributes of one header, behind which *r then stands. */
static bool read_attributes(exr_reader *r, exr_header *head, image_info *out,
                            snell_status *status) {
    bool channels = false, window = false;
    *head = (exr_header){{NULL, NULL}, {NULL, NULL}};
    for (;;) {
        const char *name = read_name(r);
        if (name == NULL) return false;
        if (name[0] == '\0') return channels && window;
        const char *type = read_name(r);
        if (type == NULL || r->end - r->at < 4) return false;
        uint32_t size = little_endian(r->at);
        r->at += 4;
        if (size > (size_t)(r->end - r->at)) return false;
        exr_reader value = {r->at, r->at + size};
        r->at += size;
        if (is_attribute(name, type, "channels", "chlist")) {
            if (!read_channels(value, out)) return false;
            head->channels = value;
            channels = true;
        } else if (is_attribute(name, type, "dataWindow", "box2i")) {
            if (!read_window(value, out)) return false;
            window = true;
        } else if (is_attribute(name, type, "name", "string")) {
            head->name = value;
        } else if (is_attribute(name, type, attribute, "string") &&
                   !image_info_set_tag(out, value.at, size)) {
            *status = error_no_memory();
            return true;
        }
    }
}

/* ---- the layers, as image_info has them ---- */

enum { LAYERS_SIZE_MAX = 1 << 16 };

typedef struct layer_list {
    char *text;
    size_t size, capacity;
    bool no_memory;
} layer_list;

/* Names are anybody's: what would break a line does not stay. */
static void list_text(layer_list *l, const void *text, size_t length, bool as_it_is) {
    const uint8_t *from = text;
    if (l->size + length > LAYERS_SIZE_MAX || l->no_memory) return;
    l->no_memory = !ARRAY_GROW(l->text, l->size, l->capacity, length + 1);
    if (l->no_memory) return;
    for (size_t i = 0; i < length; i++)
        l->text[l->size++] = (char)(from[i] >= ' ' || as_it_is ? from[i] : '?');
    l->text[l->size] = '\0';
}

static bool is_color(const char *name) {
    return name[0] && name[1] == '\0' && strchr("RGBAY", name[0]) != NULL;
}

/* All channels of a part, but the colours of the first, which has no name here. */
static void list_part(const exr_header *head, bool first, layer_list *out) {
    exr_reader r = head->channels;
    const char *channel;
    bool begun = false;
    while ((channel = read_name(&r)) != NULL && channel[0] && r.end - r.at >= 16) {
        r.at += 16;
        if (first && is_color(channel)) continue;
        if (begun) list_text(out, " ", 1, true);
        if (!begun && !first && head->name.at) {
            list_text(out, head->name.at, (size_t)(head->name.end - head->name.at), false);
            list_text(out, ": ", 2, true);
        }
        begun = true;
        list_text(out, channel, strlen(channel), false);
    }
    if (begun) list_text(out, "\n", 1, true);
}

/* Of the headers of further parts only their names count: the file may be longer than what is here. */
static snell_status read_layers(exr_reader r, const exr_header *first, bool has_parts,
                                image_info *out) {
    layer_list list = {NULL, 0, 0, false};
    list_part(first, true, &list);
    while (has_parts && r.at < r.end && *r.at) {
        image_info unused = {.tag = NULL};
        exr_header head;
        snell_status status = SNELL_OK;
        bool fine = read_attributes(&r, &head, &unused, &status);
        image_info_free(&unused);
        if (!fine || status) break;
        list_part(&head, false, &list);
    }
    out->layers = list.text;
    return list.no_memory ? error_no_memory() : SNELL_OK;
}

static bool read_info(const uint8_t *data, size_t size, image_info *out, snell_status *status) {
    static const uint8_t magic[4] = {0x76, 0x2f, 0x31, 0x01};
    enum { HAS_PARTS = 16 };
    if (size < 8 || memcmp(data, magic, 4) != 0) return false;
    exr_reader r = {data + 8, data + size};
    exr_header head;
    if (data[4] != 2 || !read_attributes(&r, &head, out, status))
        *status = error_set(SNELL_ERR_SYNTAX, NULL, "the EXR file's head is broken");
    else if (!*status)
        *status = read_layers(r, &head, (data[5] & HAS_PARTS) != 0, out);
    return true;
}

extern const image_codec image_codec_exr;
const image_codec image_codec_exr = {
    .name = "exr",
    .extension = ".exr",
    .help = "floats, linear; with alpha and layers",
    .has_tag = true,
    .has_alpha = true,
    .linear = true,
    .has_layers = true,
    .bits = 32,
    .bits_other = 16,
#if SNELL_HAS_OPENEXR
    .encode = encode,
#else
    .missing = "write .pfm, or build with -DSNELL_OPENEXR=ON",
#endif
    .read_info = read_info,
};
