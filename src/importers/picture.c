#include "importers/picture.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/pnm.h"
#include "image/srgb.h"
#include "importers/files.h"

enum { PIXELS_MAX = IMAGE_SIZE_MAX / (4 * sizeof(float)) }; /* of every format */

static bool begins(const uint8_t *data, size_t size, const char *magic, size_t length) {
    return size >= length && memcmp(data, magic, length) == 0;
}

/* ---- PPM and PGM: whole numbers up to a largest one, in two bytes where it is over 255 ---- */

static bool is_pnm(const uint8_t *data, size_t size) {
    return size > 2 && data[0] == 'P' && (data[1] == '5' || data[1] == '6') &&
           (data[2] <= ' ' || data[2] == '#');
}

static snell_status read_pnm_head(const uint8_t *data, size_t size, size_t *at, uint32_t *largest,
                                  decoded_image *out) {
    *at = 2;
    if (!pnm_read_number(data, size, at, &out->width) ||
        !pnm_read_number(data, size, at, &out->height) ||
        !pnm_read_number(data, size, at, largest) || *largest > 65535)
        return error_set(SNELL_ERR_SYNTAX, NULL, "the head of the PPM or PGM file is broken");
    ++*at; /* the one space after it */
    out->channels = data[1] == '6' ? 3 : 1;
    out->wide = *largest > 255;
    return SNELL_OK;
}

/* As other formats are decoded: stretched to all of 8 or 16 bits. */
static snell_status decode_pnm(const uint8_t *data, size_t size, size_t size_max,
                               decoded_image *out) {
    size_t at;
    uint32_t largest;
    snell_status status = read_pnm_head(data, size, &at, &largest, out);
    if (!status) status = image_make_room(out, size_max);
    if (status) return status;
    size_t bytes = (size_t)out->width * out->height * out->channels * (out->wide ? 2 : 1);
    if (size - at < bytes) return error_set(SNELL_ERR_SYNTAX, NULL, "the file ends early");
    for (size_t i = 0; i < bytes; i += out->wide ? 2 : 1) {
        uint32_t value = data[at + i];
        if (out->wide) value = value << 8 | data[at + i + 1];
        if (value > largest) value = largest;
        value = (value * (out->wide ? 65535 : 255) + largest / 2) / largest;
        if (out->wide)
            out->pixels[i] = (uint8_t)(value >> 8), out->pixels[i + 1] = (uint8_t)value;
        else
            out->pixels[i] = (uint8_t)value;
    }
    return SNELL_OK;
}

/* ---- to floats ---- */

/* The channel as a number from 0 to 1. */
static double unorm_at(const decoded_image *image, size_t index) {
    if (!image->wide) return image->pixels[index] / 255.0;
    const uint8_t *p = image->pixels + 2 * index;
    return (p[0] << 8 | p[1]) / 65535.0;
}

static float linear_at(const decoded_image *image, size_t index) {
    return image->wide ? srgb_to_linear(unorm_at(image, index))
                       : srgb_table()[image->pixels[index]];
}

static void convert_encoded(const decoded_image *image, picture *out) {
    size_t count = (size_t)image->width * image->height, channels = image->channels;
    float *to = out->pixels;
    for (size_t i = 0; i < count; i++) {
        double alpha = channels == 4 ? unorm_at(image, i * 4 + 3) : 1;
        for (size_t c = 0; c < 3; c++) {
            float linear = linear_at(image, i * channels + (channels == 1 ? 0 : c));
            *to++ = channels == 4 ? (float)((double)linear * alpha) : linear;
        }
        if (channels == 4) *to++ = (float)alpha;
    }
}

static void convert_floats(const decoded_image *image, picture *out) {
    size_t count = (size_t)image->width * image->height, channels = out->header.channels;
    const float *from = (const float *)(const void *)image->pixels;
    for (size_t i = 0; i < count; i++)
        memcpy(out->pixels + i * channels, from + i * 4, channels * sizeof(float));
}

static snell_status convert(const decoded_image *image, picture *out) {
    if ((uint64_t)image->width * image->height > PIXELS_MAX)
        return error_set(SNELL_ERR_UNSUPPORTED, "make the image smaller",
                         "an image of %u x %u pixels is too large", image->width, image->height);
    bool alpha = image->channels == 4 && !image->opaque;
    out->header = (picture_header){.magic = PICTURE_MAGIC,
                                   .width = image->width,
                                   .height = image->height,
                                   .channels = alpha ? 4 : 3,
                                   .encoded_bits = image->floats ? 0
                                                   : image->wide ? 16
                                                                 : 8,
                                   .damaged = image->damaged,
                                   .names_size = out->layers.size};
    out->pixels = memory_resize(NULL, (size_t)image->width * image->height,
                                out->header.channels * sizeof(float));
    if (out->pixels == NULL) return error_no_memory();
    if (image->floats)
        convert_floats(image, out);
    else
        convert_encoded(image, out);
    return SNELL_OK;
}

/* ---- all of it ---- */

static snell_status decode(const uint8_t *data, size_t size, size_t size_max, const char *layer,
                           image_names *layers, decoded_image *out) {
    if (image_is_float(data, size))
        return image_decode_layer(data, size, size_max, layer, layers, out);
    bool webp = begins(data, size, "RIFF", 4) && size >= 12 && memcmp(data + 8, "WEBP", 4) == 0;
    bool known =
        webp || begins(data, size, "\x89PNG\r\n\x1a\n", 8) || begins(data, size, "\xff\xd8\xff", 3);
    if (!known && !is_pnm(data, size))
        return error_set(SNELL_ERR_UNSUPPORTED,
                         "PNG, JPEG, WebP, PPM, OpenEXR, PFM and Radiance HDR are read; 'snell "
                         "render' makes a picture of a scene",
                         "this is no picture that snell reads");
    if (layer[0]) return error_set(SNELL_ERR_ARGUMENT, "only OpenEXR files do", "it has no layers");
    return known ? image_decode_wide(data, size, size_max, out)
                 : decode_pnm(data, size, size_max, out);
}

snell_status picture_import(const char *path, const import_options *options, picture *out) {
    uint8_t *data;
    size_t size, most = IMAGE_SIZE_MAX;
    decoded_image image = {0};
    *out = (picture){.pixels = NULL};
    /* The decoded image, the floats, the block that is sent. */
    if (options->memory_max && options->memory_max / 3 < most)
        most = (size_t)options->memory_max / 3;
    snell_status status = import_read_file(path, NULL, options, &data, &size);
    if (status) return status;
    status = decode(data, size, most, options->layer, &out->layers, &image);
    free(data);
    if (!status) status = convert(&image, out);
    image_free(&image);
    if (!status) return SNELL_OK;
    picture_free(out);
    error_place((source_place){.file = path});
    return status;
}

snell_status picture_write(const picture *p, record_write_fn *write, void *user) {
    static const char zeros[8] = {0};
    const picture_header *h = &p->header;
    size_t names = p->layers.size, padding = (size_t)(-names & 7);
    bool done = write(user, h, sizeof *h) && (names == 0 || write(user, p->layers.text, names)) &&
                (padding == 0 || write(user, zeros, padding)) &&
                write(user, p->pixels, (size_t)h->width * h->height * h->channels * sizeof(float));
    return done ? SNELL_OK : SNELL_ERR_IO;
}

void picture_free(picture *p) {
    free(p->layers.text);
    free(p->pixels);
    *p = (picture){.pixels = NULL};
}
