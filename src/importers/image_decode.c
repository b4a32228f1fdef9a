#include "importers/image_decode.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

#if SNELL_HAS_JPEG
#include <turbojpeg.h>
#endif
#if SNELL_HAS_WEBP
#include <webp/decode.h>
#endif

enum { SIDE_MAX = 65536 };

void image_free(decoded_image *image) {
    free(image->pixels);
    *image = (decoded_image){0};
}

const char *image_format_word(const decoded_image *image) {
    if (image->floats) return "rgba32f";
    return image->channels == 1 ? "gray8" : image->channels == 3 ? "rgb8" : "rgba8";
}

snell_status image_make_room(decoded_image *image, size_t size_max) {
    if (image->width == 0 || image->height == 0 || image->width > SIDE_MAX ||
        image->height > SIDE_MAX)
        return error_set(SNELL_ERR_SYNTAX, NULL, "an image of %u x %u pixels cannot be read",
                         image->width, image->height);
    size_t size = (size_t)image->width * image->height * image->channels * (image->wide ? 2 : 1);
    if (size > IMAGE_SIZE_MAX) /* more memory would not help */
        return error_set(SNELL_ERR_UNSUPPORTED, "make the image smaller",
                         "an image of %u x %u pixels is too large", image->width, image->height);
    if (size > size_max)
        return error_set(SNELL_ERR_MEMORY, "make the image smaller",
                         "an image of %u x %u pixels is too large", image->width, image->height);
    image->pixels = memory_resize(NULL, size, 1);
    return image->pixels ? SNELL_OK : error_no_memory();
}

/* ---- PNG ---- */

typedef struct png_job {
    png_structp png;
    png_infop info;
    const uint8_t *data;
    size_t size, used, size_max;
    bool keep_16;
    decoded_image image;
    png_bytep *rows;
    snell_status status;
    char text[128];
} png_job;

static void png_fail(png_structp png, png_const_charp text) {
    png_job *job = png_get_error_ptr(png);
    strncpy(job->text, text, sizeof job->text - 1);
    png_longjmp(png, 1);
}

static void png_ignore(png_structp png, png_const_charp text) { (void)png, (void)text; }

static void png_take(png_structp png, png_bytep out, size_t size) {
    png_job *job = png_get_io_ptr(png);
    if (size > job->size - job->used) png_error(png, "the file ends early");
    memcpy(out, job->data + job->used, size);
    job->used += size;
}

/* Palettes, 1, 2 and 4 bits and transparent colours all become 8-bit channels, 16 bits too unless
 * they are to be kept; gamma chunks are not applied, as glTF asks. */
static snell_status png_read_pixels(png_job *job) {
    png_structp png = job->png;
    png_read_info(png, job->info);
    png_set_expand(png);
    if (!job->keep_16) png_set_scale_16(png);
    int color = png_get_color_type(png, job->info);
    if (color == PNG_COLOR_TYPE_GRAY_ALPHA ||
        (color == PNG_COLOR_TYPE_GRAY && png_get_valid(png, job->info, PNG_INFO_tRNS)))
        png_set_gray_to_rgb(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, job->info);
    decoded_image *image = &job->image;
    image->width = png_get_image_width(png, job->info);
    image->height = png_get_image_height(png, job->info);
    image->channels = png_get_channels(png, job->info);
    image->wide = png_get_bit_depth(png, job->info) == 16;
    if (image->channels == 2 || image->channels > 4) png_error(png, "odd channels");
    snell_status status = image_make_room(image, job->size_max);
    if (status) return status;
    job->rows = memory_resize(NULL, image->height, sizeof *job->rows);
    if (job->rows == NULL) return error_no_memory();
    size_t row_size = (size_t)image->width * image->channels * (image->wide ? 2 : 1);
    if (png_get_rowbytes(png, job->info) != row_size) png_error(png, "odd rows");
    for (uint32_t y = 0; y < image->height; y++) job->rows[y] = image->pixels + y * row_size;
    png_read_image(png, job->rows);
    png_read_end(png, NULL);
    return SNELL_OK;
}

/* Everything that changes lives in the job, not in this frame, because of setjmp. */
static void png_run(png_job *job) {
    if (setjmp(png_jmpbuf(job->png))) {
        job->status = error_set(SNELL_ERR_SYNTAX, NULL, "a broken PNG image: %s", job->text);
        return;
    }
    png_set_user_limits(job->png, SIDE_MAX, SIDE_MAX);
    png_set_chunk_cache_max(job->png, 128);
    png_set_chunk_malloc_max(job->png, 8 << 20);
    png_set_read_fn(job->png, job, png_take);
    job->status = png_read_pixels(job);
}

static uint32_t read_u32(const uint8_t *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

/* Of the size libpng only says that the header is invalid. */
static snell_status check_png_size(const uint8_t *data, size_t size) {
    enum { WIDTH_AT = 16, HEIGHT_AT = 20, HEADER_END = 24 };
    if (size < HEADER_END) return SNELL_OK;
    uint32_t width = read_u32(data + WIDTH_AT), height = read_u32(data + HEIGHT_AT);
    if (width - 1 < SIDE_MAX && height - 1 < SIDE_MAX) return SNELL_OK;
    return error_set(SNELL_ERR_SYNTAX, "1 to 65536 pixels each way",
                     "an image of %u x %u pixels cannot be read", width, height);
}

static snell_status decode_png(const uint8_t *data, size_t size, size_t size_max, bool keep_16,
                               decoded_image *out) {
    snell_status status = check_png_size(data, size);
    if (status) return status;
    png_job job = {.data = data, .size = size, .size_max = size_max, .keep_16 = keep_16};
    job.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &job, png_fail, png_ignore);
    if (job.png) job.info = png_create_info_struct(job.png);
    if (job.info)
        png_run(&job);
    else
        job.status = error_no_memory();
    if (job.png) png_destroy_read_struct(&job.png, &job.info, NULL);
    free(job.rows);
    if (job.status)
        image_free(&job.image);
    else
        *out = job.image;
    return job.status;
}

/* ---- JPEG ---- */

#if SNELL_HAS_JPEG

/* Adobe's CMYK JPEGs are stored inverted: 255 is no ink. */
static void cmyk_to_rgb(decoded_image *image) {
    size_t count = (size_t)image->width * image->height;
    for (size_t i = 0; i < count; i++) {
        const uint8_t *in = image->pixels + 4 * i;
        uint8_t *rgb = image->pixels + 3 * i;
        unsigned k = in[3];
        uint8_t r = (uint8_t)(in[0] * k / 255), g = (uint8_t)(in[1] * k / 255),
                b = (uint8_t)(in[2] * k / 255);
        rgb[0] = r, rgb[1] = g, rgb[2] = b;
    }
    image->channels = 3;
}

static snell_status jpeg_error(tjhandle jpeg) {
    return error_set(SNELL_ERR_SYNTAX, NULL, "a broken JPEG image: %s", tjGetErrorStr2(jpeg));
}

static snell_status jpeg_run(tjhandle jpeg, const uint8_t *data, size_t size, size_t size_max,
                             decoded_image *image) {
    int width, height, sampling, space;
    if (tjDecompressHeader3(jpeg, data, (unsigned long)size, &width, &height, &sampling, &space) !=
            0 &&
        tjGetErrorCode(jpeg) == TJERR_FATAL)
        return jpeg_error(jpeg);
    if (width < 1 || height < 1 || width > SIDE_MAX || height > SIDE_MAX)
        return error_set(SNELL_ERR_SYNTAX, NULL, "an image of %d x %d pixels cannot be read", width,
                         height);
    bool cmyk = space == TJCS_CMYK || space == TJCS_YCCK;
    image->width = (uint32_t)width, image->height = (uint32_t)height;
    image->channels = space == TJCS_GRAY ? 1 : cmyk ? 4 : 3;
    snell_status status = image_make_room(image, size_max);
    if (status) return status;
    memset(image->pixels, 128, (size_t)width * image->height * image->channels);
    /* The accurate DCT gives the same bits with and without SIMD; scans are limited against
     * progressive files that take for ever. */
    int format = space == TJCS_GRAY ? TJPF_GRAY : cmyk ? TJPF_CMYK : TJPF_RGB;
    if (tjDecompress2(jpeg, data, (unsigned long)size, image->pixels, width, 0, height, format,
                      TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS) != 0) {
        if (tjGetErrorCode(jpeg) == TJERR_FATAL) return jpeg_error(jpeg);
        image->damaged = true;
    }
    if (cmyk) cmyk_to_rgb(image);
    return SNELL_OK;
}

static snell_status decode_jpeg(const uint8_t *data, size_t size, size_t size_max,
                                decoded_image *out) {
    tjhandle jpeg = tjInitDecompress();
    if (jpeg == NULL) return error_no_memory();
    decoded_image image = {0};
    snell_status status = jpeg_run(jpeg, data, size, size_max, &image);
    tjDestroy(jpeg);
    if (status)
        image_free(&image);
    else
        *out = image;
    return status;
}

#else

static snell_status decode_jpeg(const uint8_t *data, size_t size, size_t size_max,
                                decoded_image *out) {
    (void)data, (void)size, (void)size_max, (void)out;
    return error_set(SNELL_ERR_UNSUPPORTED, "build with -DSNELL_JPEG=ON",
                     "this build cannot read JPEG images");
}

#endif

/* ---- WebP ---- */

#if SNELL_HAS_WEBP

static snell_status decode_webp(const uint8_t *data, size_t size, size_t size_max,
                                decoded_image *out) {
    WebPBitstreamFeatures seen;
    const char *broken = "a broken WebP image";
    if (WebPGetFeatures(data, size, &seen) != VP8_STATUS_OK)
        return error_set(SNELL_ERR_SYNTAX, NULL, "%s", broken);
    if (seen.has_animation)
        return error_set(SNELL_ERR_UNSUPPORTED, "convert it to PNG or JPEG",
                         "an animated WebP image cannot be read");
    decoded_image image = {.width = (uint32_t)seen.width,
                           .height = (uint32_t)seen.height,
                           .channels = seen.has_alpha ? 4 : 3};
    snell_status status = image_make_room(&image, size_max);
    if (status) return status;
    size_t row = (size_t)image.width * image.channels, room = row * image.height;
    uint8_t *made = seen.has_alpha ? WebPDecodeRGBAInto(data, size, image.pixels, room, (int)row)
                                   : WebPDecodeRGBInto(data, size, image.pixels, room, (int)row);
    if (made == NULL) {
        image_free(&image);
        return error_set(SNELL_ERR_SYNTAX, NULL, "%s", broken);
    }
    *out = image;
    return SNELL_OK;
}

#else

static snell_status decode_webp(const uint8_t *data, size_t size, size_t size_max,
                                decoded_image *out) {
    (void)data, (void)size, (void)size_max, (void)out;
    return error_set(SNELL_ERR_UNSUPPORTED, "build with -DSNELL_WEBP=ON",
                     "this build cannot read WebP images");
}

#endif

/* ---- all of them ---- */

static bool begins(const uint8_t *data, size_t size, size_t at, const char *magic, size_t length) {
    return size >= at + length && memcmp(data + at, magic, length) == 0;
}

enum { FORMAT_PNG, FORMAT_JPEG, FORMAT_WEBP, FORMAT_OTHER };

static int format_of(const uint8_t *bytes, size_t size) {
    if (begins(bytes, size, 0, "\x89PNG\r\n\x1a\n", 8)) return FORMAT_PNG;
    if (begins(bytes, size, 0, "\xff\xd8\xff", 3)) return FORMAT_JPEG;
    bool webp = begins(bytes, size, 0, "RIFF", 4) && begins(bytes, size, 8, "WEBP", 4);
    return webp ? FORMAT_WEBP : FORMAT_OTHER;
}

const char *image_media_type(const void *data, size_t size) {
    static const char *const types[] = {"image/png", "image/jpeg", "image/webp", NULL};
    return types[format_of(data, size)];
}

static snell_status decode(const void *data, size_t size, size_t size_max, bool keep_16,
                           decoded_image *out) {
    const uint8_t *bytes = data;
    const char *name = "an unknown kind of";
    *out = (decoded_image){0};
    switch (format_of(bytes, size)) {
    case FORMAT_PNG: return decode_png(bytes, size, size_max, keep_16, out);
    case FORMAT_JPEG: return decode_jpeg(bytes, size, size_max, out);
    case FORMAT_WEBP: return decode_webp(bytes, size, size_max, out);
    default: break;
    }
    if (size == 0) return error_set(SNELL_ERR_SYNTAX, NULL, "the image is empty");
    if (begins(bytes, size, 0, "\xabKTX 20", 7)) name = "a KTX2";
    if (begins(bytes, size, 0, "GIF8", 4)) name = "a GIF";
    if (begins(bytes, size, 0, "BM", 2)) name = "a BMP";
    if (begins(bytes, size, 0, "DDS ", 4)) name = "a DDS";
    if (begins(bytes, size, 0, "#?RADIANCE", 10)) name = "a Radiance HDR";
    if (begins(bytes, size, 0, "v/1\x01", 4)) name = "an OpenEXR";
    return error_set(SNELL_ERR_UNSUPPORTED, "convert it to PNG, JPEG or WebP",
                     "%s image cannot be read", name);
}

snell_status image_decode(const void *data, size_t size, size_t size_max, decoded_image *out) {
    return decode(data, size, size_max, false, out);
}

snell_status image_decode_wide(const void *data, size_t size, size_t size_max, decoded_image *out) {
    return decode(data, size, size_max, true, out);
}

static snell_status copy_channels(const decoded_image *image, uint32_t first, uint32_t channels,
                                  decoded_image *out) {
    size_t count = (size_t)image->width * image->height;
    *out = (decoded_image){.width = image->width, .height = image->height, .channels = channels};
    out->pixels = memory_resize(NULL, count, channels);
    if (out->pixels == NULL) return error_no_memory();
    for (size_t i = 0; i < count; i++)
        for (uint32_t c = 0; c < channels; c++)
            out->pixels[i * channels + c] =
                first + c < image->channels ? image->pixels[i * image->channels + first + c] : 255;
    return SNELL_OK;
}

snell_status image_copy_color(const decoded_image *image, decoded_image *out) {
    return copy_channels(image, 0, image->channels == 1 ? 1 : 3, out);
}

snell_status image_copy_alpha(const decoded_image *image, decoded_image *out) {
    return copy_channels(image, 3, 1, out);
}

snell_status image_copy_channel(const decoded_image *image, uint32_t channel, decoded_image *out) {
    return copy_channels(image, channel < image->channels ? channel : 0, 1, out);
}

bool image_has_alpha(const decoded_image *image) {
    size_t count = (size_t)image->width * image->height;
    for (size_t i = 0; image->channels == 4 && i < count; i++)
        if (image->pixels[4 * i + 3] != 255) return true;
    return false;
}
