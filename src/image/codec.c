#include "image/codec.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "base/memory.h"
#include "image/srgb.h"

extern const image_codec image_codec_png, image_codec_exr, image_codec_jpeg, image_codec_webp,
    image_codec_pfm, image_codec_ppm;
const image_codec *const image_codecs[] = {&image_codec_png,
                                           &image_codec_exr,
                                           &image_codec_jpeg,
                                           &image_codec_webp,
                                           &image_codec_pfm,
                                           &image_codec_ppm,
                                           NULL};

bool image_buffer_add(image_buffer *b, const void *data, size_t size) {
    if (!ARRAY_GROW(b->data, b->size, b->capacity, size)) return false;
    if (size) memcpy(b->data + b->size, data, size);
    b->size += size;
    return true;
}

static const char known[] = "pictures are written as .png, .exr, .jpg, .webp, .pfm or .ppm";

snell_status image_codec_find(const char *name, const image_codec **out) {
    for (size_t i = 0; image_codecs[i]; i++)
        if (strcmp(image_codecs[i]->name, name) == 0) {
            *out = image_codecs[i];
            return SNELL_OK;
        }
    return error_set(SNELL_ERR_UNSUPPORTED, known, "unknown picture format '%s'", name);
}

snell_status image_codec_for_path(const char *path, const image_codec **out) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    source_place place = {.file = path};
    if (dot == NULL || dot == name)
        return error_set_at(SNELL_ERR_UNSUPPORTED, place, known,
                            "the name has no extension that says the format");
    for (size_t i = 0; image_codecs[i]; i++) {
        const char *too = image_codecs[i]->extension_too;
        if (strcasecmp(image_codecs[i]->extension, dot) != 0 &&
            (too == NULL || strcasecmp(too, dot) != 0))
            continue;
        *out = image_codecs[i];
        return SNELL_OK;
    }
    return error_set_at(SNELL_ERR_UNSUPPORTED, place, known, "cannot write '%s' files", dot);
}

snell_status image_options_check(const image_codec *codec, const char *extension,
                                 image_options *o) {
    if (o->map == NULL) o->map = tonemaps[0];
    if (o->tag == NULL) o->tag = "";
    if (strlen(o->tag) > IMAGE_TAG_MAX)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "the picture's tag is longer than %d bytes",
                         IMAGE_TAG_MAX);
    if (codec->encode == NULL)
        return error_set(SNELL_ERR_UNSUPPORTED, codec->missing,
                         "this snell was built without writing %s", extension);
    if (o->quality > 100)
        return error_set(SNELL_ERR_ARGUMENT, "1 to 100", "the quality is %u", o->quality);
    if (o->quality && !codec->has_quality)
        return error_set(SNELL_ERR_ARGUMENT, "it is for .jpg and .webp",
                         "%s files lose nothing: they have no quality", extension);
    if (o->bits && o->bits != codec->bits && o->bits != codec->bits_other) {
        char hint[48];
        snprintf(hint, sizeof hint, codec->bits_other ? "%u or %u" : "%u", codec->bits,
                 codec->bits_other);
        return error_set(SNELL_ERR_ARGUMENT, hint, "%s files have no channels of %u bits",
                         extension, o->bits);
    }
    if (o->quality == 0) o->quality = IMAGE_QUALITY;
    if (o->bits == 0) o->bits = codec->bits;
    return SNELL_OK;
}

snell_status image_encode(const image_codec *codec, const image_pixels *pixels,
                          const image_options *options, void **data, size_t *size) {
    image_options plain = options ? *options : (image_options){0};
    if (pixels->data == NULL || pixels->width == 0 || pixels->height == 0 ||
        (pixels->channels != 3 && pixels->channels != 4))
        return error_set(SNELL_ERR_STATE, "render first", "there is no picture to write");
    if (codec->side_max && (pixels->width > codec->side_max || pixels->height > codec->side_max))
        return error_set(SNELL_ERR_UNSUPPORTED, "write .png",
                         "a %s file has at most %u pixels a side", codec->extension,
                         codec->side_max);
    image_buffer buffer = {0};
    snell_status status = image_options_check(codec, codec->extension, &plain);
    if (!status) status = codec->encode(pixels, &plain, &buffer);
    if (status) {
        free(buffer.data);
        return status;
    }
    *data = buffer.data;
    *size = buffer.size;
    return SNELL_OK;
}

/* ---- rows for a screen ---- */

/* One pixel, from 0 to 1 but for what is beyond; alpha is not multiplied in where it is kept. */
static dvec3 shown(const image_pixels *pixels, const image_options *options, double exposure,
                   const float *from, bool keep_alpha, double *alpha) {
    dvec3 color = {(double)from[0], (double)from[1], (double)from[2]};
    *alpha = keep_alpha && pixels->channels == 4 ? clamp01((double)from[3]) : 1;
    if (*alpha > 0) exposure /= *alpha;
    color = white_balance_apply(&options->white, color);
    return tonemap_apply(options->map, exposure, color);
}

void image_row_8bit(const image_pixels *pixels, const image_options *options, uint32_t row,
                    uint32_t channels_out, uint8_t *to) {
    uint32_t channels = pixels->channels;
    const float *from = pixels->data + (size_t)row * pixels->width * channels;
    double exposure = tonemap_exposure(options->exposure), alpha;
    for (uint32_t x = 0; x < pixels->width; x++, from += channels, to += channels_out) {
        dvec3 color = shown(pixels, options, exposure, from, channels_out == 4, &alpha);
        if (channels_out == 4) to[3] = (uint8_t)(255 * alpha + 0.5);
        to[0] = tonemap_quantize(color.x);
        to[1] = tonemap_quantize(color.y);
        to[2] = tonemap_quantize(color.z);
    }
}

static void put_16bit(uint8_t *to, double value) {
    uint32_t whole = (uint32_t)(65535 * value + 0.5);
    to[0] = (uint8_t)(whole >> 8);
    to[1] = (uint8_t)whole;
}

void image_row_16bit(const image_pixels *pixels, const image_options *options, uint32_t row,
                     uint32_t channels_out, uint8_t *to) {
    uint32_t channels = pixels->channels;
    const float *from = pixels->data + (size_t)row * pixels->width * channels;
    double exposure = tonemap_exposure(options->exposure), alpha;
    for (uint32_t x = 0; x < pixels->width; x++, from += channels, to += 2 * channels_out) {
        dvec3 color = shown(pixels, options, exposure, from, channels_out == 4, &alpha);
        if (channels_out == 4) put_16bit(to + 6, alpha);
        put_16bit(to, srgb_encode(clamp01(color.x)));
        put_16bit(to + 2, srgb_encode(clamp01(color.y)));
        put_16bit(to + 4, srgb_encode(clamp01(color.z)));
    }
}

/* ---- what a file says about itself ---- */

bool image_info_set_tag(image_info *info, const uint8_t *text, size_t size) {
    char *copy = malloc(size + 1);
    if (copy == NULL) return false;
    if (size) memcpy(copy, text, size);
    copy[size] = '\0';
    free(info->tag);
    info->tag = copy;
    return true;
}

void image_info_free(image_info *info) {
    free(info->tag);
    free(info->layers);
    info->tag = info->layers = NULL;
}

snell_status image_parse_info(const uint8_t *data, size_t size, image_info *out) {
    for (size_t i = 0; image_codecs[i]; i++) {
        image_info info = {.tag = NULL};
        snell_status status = SNELL_OK;
        if (!image_codecs[i]->read_info(data, size, &info, &status)) continue;
        if (!status && info.tag == NULL && !image_info_set_tag(&info, NULL, 0))
            status = error_no_memory();
        if (!status && info.layers == NULL) info.layers = memory_copy_string("");
        if (!status && info.layers == NULL) status = error_no_memory();
        if (status) {
            image_info_free(&info);
            return status;
        }
        snprintf(info.format, sizeof info.format, "%s", image_codecs[i]->name);
        *out = info;
        return SNELL_OK;
    }
    return error_set(SNELL_ERR_UNSUPPORTED, NULL,
                     "this is no PNG, EXR, JPEG, WebP, PFM or PPM picture");
}

snell_status image_read_info(const char *path, image_info *out) {
    void *data;
    size_t size;
    snell_status status = file_read_start(path, IMAGE_HEAD_MAX, &data, &size);
    if (status) return status;
    status = image_parse_info(data, size, out);
    if (status) error_place((source_place){.file = path});
    free(data);
    return status;
}
