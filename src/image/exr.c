/* OpenEXR: 32-bit linear floats, ZIP, channels R G B (A, premultiplied); the tag is the string
 * attribute "snell". Written by OpenEXRCore into memory; a file's head is read by hand, since a
 * foreign file must not meet a decoder outside of the sandbox. */
#include <stdlib.h>
#include <string.h>

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

static exr_result_t write_head(exr_context_t file, const image_pixels *pixels, const char *tag) {
    static const char *const names[] = {"R", "G", "B", "A"};
    int part;
    exr_result_t failed = exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &part);
    if (!failed)
        failed = exr_initialize_required_attr_simple(file, part, (int32_t)pixels->width,
                                                     (int32_t)pixels->height, EXR_COMPRESSION_ZIP);
    if (!failed) failed = exr_set_zip_compression_level(file, part, 4);
    for (uint32_t c = 0; !failed && c < pixels->channels; c++)
        failed = exr_add_channel(file, part, names[c], EXR_PIXEL_FLOAT,
                                 EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    if (!failed && tag[0]) failed = exr_attr_set_string(file, part, attribute, tag);
    return failed ? failed : exr_write_header(file);
}

/* Where the channel of this name begins in a pixel; the file sorts them by name. */
static uint32_t channel_offset(const char *name) {
    return name[0] == 'R' ? 0 : name[0] == 'G' ? 1 : name[0] == 'B' ? 2 : 3;
}

static exr_result_t write_rows(exr_context_t file, const image_pixels *pixels) {
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t step = 0;
    bool started = false;
    exr_result_t failed = exr_get_scanlines_per_chunk(file, 0, &step);
    for (uint32_t y = 0; !failed && y < pixels->height; y += (uint32_t)step) {
        exr_chunk_info_t chunk;
        failed = exr_write_scanline_chunk_info(file, 0, (int)y, &chunk);
        if (failed) break;
        failed = started ? exr_encoding_update(file, 0, &chunk, &pipeline)
                         : exr_encoding_initialize(file, 0, &chunk, &pipeline);
        if (failed) break;
        for (int16_t c = 0; c < pipeline.channel_count; c++) {
            exr_coding_channel_info_t *channel = &pipeline.channels[c];
            const float *first = pixels->data + (size_t)y * pixels->width * pixels->channels +
                                 channel_offset(channel->channel_name);
            channel->encode_from_ptr = (const uint8_t *)first;
            channel->user_bytes_per_element = 4;
            channel->user_data_type = EXR_PIXEL_FLOAT;
            channel->user_pixel_stride = (int32_t)(4 * pixels->channels);
            channel->user_line_stride = (int32_t)(4 * pixels->channels * pixels->width);
        }
        if (!started) failed = exr_encoding_choose_default_routines(file, 0, &pipeline);
        started = true;
        if (!failed) failed = exr_encoding_run(file, 0, &pipeline);
    }
    if (started) exr_encoding_destroy(file, &pipeline);
    return failed;
}

static snell_status encode(const image_pixels *pixels, const image_options *options,
                           image_buffer *out) {
    exr_stream stream = {out, false};
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.user_data = &stream;
    setup.write_fn = write_at;
    setup.error_handler_fn = on_error;
    exr_context_t file = NULL;
    exr_result_t failed = exr_start_write(&file, "picture", EXR_WRITE_FILE_DIRECTLY, &setup);
    if (!failed) failed = write_head(file, pixels, options->tag);
    if (!failed) failed = write_rows(file, pixels);
    if (file) {
        exr_result_t closing = exr_finish(&file);
        if (!failed) failed = closing;
    }
    if (!failed) return SNELL_OK;
    if (stream.no_memory || failed == EXR_ERR_OUT_OF_MEMORY) return error_no_memory();
    return error_set(SNELL_ERR_INTERNAL, "try .pfm", "OpenEXR failed: %s",
                     exr_get_default_error_message(failed));
}

#else

static snell_status encode(const image_pixels *pixels, const image_options *options,
                           image_buffer *out) {
    (void)pixels;
    (void)options;
    (void)out;
    return error_set(SNELL_ERR_UNSUPPORTED, "write .pfm, or build with -DSNELL_OPENEXR=ON",
                     "this snell was built without OpenEXR");
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

/* The attributes of the (first) header. */
static bool read_attributes(exr_reader r, image_info *out, snell_status *status) {
    bool channels = false, window = false;
    for (;;) {
        const char *name = read_name(&r);
        if (name == NULL) return false;
        if (name[0] == '\0') return channels && window;
        const char *type = read_name(&r);
        if (type == NULL || r.end - r.at < 4) return false;
        uint32_t size = little_endian(r.at);
        r.at += 4;
        if (size > (size_t)(r.end - r.at)) return false;
        exr_reader value = {r.at, r.at + size};
        r.at += size;
        if (is_attribute(name, type, "channels", "chlist")) {
            if (!read_channels(value, out)) return false;
            channels = true;
        } else if (is_attribute(name, type, "dataWindow", "box2i")) {
            if (!read_window(value, out)) return false;
            window = true;
        } else if (is_attribute(name, type, attribute, "string") &&
                   !image_info_set_tag(out, value.at, size)) {
            *status = error_no_memory();
            return true;
        }
    }
}

static bool read_info(const uint8_t *data, size_t size, image_info *out, snell_status *status) {
    static const uint8_t magic[4] = {0x76, 0x2f, 0x31, 0x01};
    if (size < 8 || memcmp(data, magic, 4) != 0) return false;
    if (data[4] != 2 || !read_attributes((exr_reader){data + 8, data + size}, out, status))
        *status = error_set(SNELL_ERR_SYNTAX, NULL, "the EXR file's head is broken");
    return true;
}

extern const image_codec image_codec_exr;
const image_codec image_codec_exr = {
    .name = "exr",
    .extension = ".exr",
    .help = "32-bit floats, linear",
    .has_tag = true,
    .encode = encode,
    .read_info = read_info,
};
