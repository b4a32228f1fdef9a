/* PNG, 8 or 16 bits, sRGB, straight alpha; the tag is a text chunk with the keyword "snell". */
#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/png.h"

static const char keyword[] = "snell";

/* ---- writing ---- */

typedef struct png_job {
    const image_pixels *pixels;
    const image_options *options;
    image_buffer *out;
    uint8_t *row;
    char text[128]; /* what libpng says when it fails */
} png_job;

static void on_error(png_structp png, png_const_charp text) {
    png_job *job = png_get_error_ptr(png);
    strncpy(job->text, text, sizeof job->text - 1);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text) {
    (void)png; /* nothing that a caller could act on */
    (void)text;
}

static void on_write(png_structp png, png_bytep data, size_t size) {
    png_job *job = png_get_io_ptr(png);
    if (!image_buffer_add(job->out, data, size)) png_error(png, "out of memory");
}

static void on_flush(png_structp png) { (void)png; }

static bool is_ascii(const char *text) {
    for (; *text; text++)
        if ((unsigned char)*text >= 0x80) return false;
    return true;
}

/* All that may jump; nothing here is read after a jump but what `job` points to. */
static bool write_png(png_structp png, png_infop info, png_job *job) {
    if (setjmp(png_jmpbuf(png))) return false;
    uint32_t channels = job->pixels->channels;
    png_set_write_fn(png, job, on_write, on_flush);
    png_set_IHDR(png, info, job->pixels->width, job->pixels->height, (int)job->options->bits,
                 channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_RELATIVE);
    if (job->options->tag[0]) {
        /* tEXt is Latin-1, iTXt is UTF-8. libpng takes the text as char *, but only reads it. */
        png_text text = {.compression = is_ascii(job->options->tag) ? PNG_TEXT_COMPRESSION_NONE
                                                                    : PNG_ITXT_COMPRESSION_NONE,
                         .key = (png_charp)(uintptr_t)keyword,
                         .text = (png_charp)(uintptr_t)job->options->tag};
        png_set_text(png, info, &text, 1);
    }
    png_set_compression_level(png, 4); /* 2.5 times as fast as 6, and 0.6 % longer */
    png_write_info(png, info);
    for (uint32_t y = 0; y < job->pixels->height; y++) {
        if (job->options->bits == 16)
            image_row_16bit(job->pixels, job->options, y, channels, job->row);
        else
            image_row_8bit(job->pixels, job->options, y, channels, job->row);
        png_write_row(png, job->row);
    }
    png_write_end(png, info);
    return true;
}

static snell_status encode(const image_pixels *pixels, const image_options *options,
                           image_buffer *out) {
    png_job job = {pixels, options, out, NULL, ""};
    job.row = memory_resize(NULL, pixels->width, (size_t)pixels->channels * (options->bits / 8));
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &job, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    bool ready = job.row && info, done = ready && write_png(png, info, &job);
    png_destroy_write_struct(&png, &info);
    free(job.row);
    if (done) return SNELL_OK;
    if (!ready || strcmp(job.text, "out of memory") == 0) return error_no_memory();
    return error_set(SNELL_ERR_INTERNAL, "try .ppm", "libpng failed: %s", job.text);
}

snell_status png_encode_bytes(const void *pixels, uint32_t width, uint32_t height,
                              uint32_t channels, image_buffer *out) {
    png_image image = {.version = PNG_IMAGE_VERSION, .width = width, .height = height};
    image.format = channels == 1   ? PNG_FORMAT_GRAY
                   : channels == 3 ? PNG_FORMAT_RGB
                                   : PNG_FORMAT_RGBA;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
    void *data = memory_resize(NULL, size, 1);
    if (data == NULL) return error_no_memory();
    bool done = png_image_write_to_memory(&image, data, &size, 0, pixels, 0, NULL) != 0;
    bool kept = done && image_buffer_add(out, data, size);
    free(data);
    if (kept) return SNELL_OK;
    if (done) return error_no_memory();
    return error_set(SNELL_ERR_UNSUPPORTED, "make the image smaller", "libpng failed: %s",
                     image.message);
}

/* ---- reading the head: signature, then chunks of length, type, data, CRC ---- */

static uint32_t big_endian(const uint8_t *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

static bool read_header(const uint8_t *p, uint32_t length, image_info *out) {
    static const uint8_t channels[7] = {1, 0, 3, 3, 2, 0, 4}; /* by colour type; 3 is a palette */
    if (length != 13 || p[9] > 6 || channels[p[9]] == 0) return false;
    out->width = big_endian(p);
    out->height = big_endian(p + 4);
    out->bits = p[9] == 3 ? 8 : p[8];
    out->channels = channels[p[9]];
    return out->width - 1 < INT32_MAX && out->height - 1 < INT32_MAX && p[8] >= 1 && p[8] <= 16;
}

/* The text of a tEXt or iTXt chunk with our keyword; NULL when it is another, or compressed. */
static const uint8_t *find_text(const uint8_t *p, uint32_t length, bool international,
                                size_t *size) {
    if (length < sizeof keyword || memcmp(p, keyword, sizeof keyword) != 0) return NULL;
    const uint8_t *end = p + length;
    p += sizeof keyword;
    if (international) { /* compression flag and method, language, translated keyword */
        if (end - p < 2 || p[0] != 0) return NULL;
        p += 2;
        for (int i = 0; i < 2; i++) {
            const uint8_t *zero = memchr(p, 0, (size_t)(end - p));
            if (zero == NULL) return NULL;
            p = zero + 1;
        }
    }
    *size = (size_t)(end - p);
    return p;
}

static bool read_info(const uint8_t *data, size_t size, image_info *out, snell_status *status) {
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    if (size < 8 || memcmp(data, signature, 8) != 0) return false;
    bool have_header = false;
    for (size_t at = 8; size - at >= 12;) {
        uint32_t length = big_endian(data + at);
        const uint8_t *type = data + at + 4, *p = data + at + 8;
        if (length > size - at - 12 || memcmp(type, "IDAT", 4) == 0) break;
        if (!have_header) {
            if (memcmp(type, "IHDR", 4) != 0 || !read_header(p, length, out)) break;
            have_header = true;
        }
        if (memcmp(type, "acTL", 4) == 0 && length == 8) out->frames = big_endian(p);
        bool plain = memcmp(type, "tEXt", 4) == 0, international = memcmp(type, "iTXt", 4) == 0;
        size_t text_size;
        const uint8_t *text =
            plain || international ? find_text(p, length, international, &text_size) : NULL;
        if (text && !image_info_set_tag(out, text, text_size)) {
            *status = error_no_memory();
            return true;
        }
        at += 12 + (size_t)length;
    }
    if (!have_header) *status = error_set(SNELL_ERR_SYNTAX, NULL, "the PNG file's head is broken");
    return true;
}

extern const image_codec image_codec_png;
const image_codec image_codec_png = {
    .name = "png",
    .extension = ".png",
    .help = "8 or 16 bits, sRGB, tone-mapped; with alpha",
    .has_tag = true,
    .has_alpha = true,
    .bits = 8,
    .bits_other = 16,
    .encode = encode,
    .read_info = read_info,
};
