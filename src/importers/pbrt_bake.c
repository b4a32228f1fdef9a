/* Images of pbrt files, and textures of pbrt that snell has no counterpart of, as images. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/srgb.h"
#include "importers/files.h"
#include "importers/image_float.h"
#include "importers/pbrt.h"
#include "maths/functions.h"

enum { NODES_MAX = 256, SIDE_MAX = 2048 };

/* ---- images ---- */

snell_status pbrt_read_image(pbrt *p, const char *name, source_place place, decoded_image *out,
                             bool *found) {
    *found = false;
    if (p->status) return p->status;
    uint8_t *data = NULL;
    size_t size, most = p->budget < IMAGE_SIZE_MAX ? (size_t)p->budget : IMAGE_SIZE_MAX;
    snell_status status = import_read_beside(p->path, name, p->options, &data, &size);
    if (!status)
        status = image_is_float(data, size) ? image_decode_float(data, size, most, out)
                                            : image_decode(data, size, most, out);
    free(data);
    if (status == SNELL_ERR_MEMORY) return pbrt_blame(p, place, status);
    if (status)
        return status == SNELL_ERR_IO /* which names it */
                   ? pbrt_warn(p, place, "%s: it is left out", error_last()->text)
                   : pbrt_warn(p, place, "'%.100s': %s; it is left out", name, error_last()->text);
    *found = true;
    if (out->damaged) pbrt_warn(p, place, "'%.60s' is damaged: part of it is grey", name);
    return pbrt_spend(p, place,
                      (uint64_t)out->width * out->height * out->channels * (out->floats ? 4 : 1));
}

void pbrt_pixel(const decoded_image *image, double gamma, uint32_t x, uint32_t y, double out[3]) {
    size_t at = ((size_t)y * image->width + x) * image->channels;
    for (uint32_t c = 0; c < 3; c++) {
        size_t i = at + (image->channels < 3 ? 0 : c);
        if (image->floats) {
            out[c] = (double)((const float *)(const void *)image->pixels)[i];
            continue;
        }
        double v = image->pixels[i] / 255.0;
        out[c] = gamma == 0 ? (double)srgb_to_linear(v) : gamma == 1 ? v : fn_pow(v, gamma);
    }
}

const char *const pbrt_wrap_words[] = {"repeat", "clamp", "mirror"};

snell_status pbrt_add_image(pbrt *p, source_place place, const decoded_image *image, bool srgb,
                            const pbrt_texture *placing, snell_texture_id *out) {
    static const pbrt_texture once = {.scale = {1, 1}, .wrap = 0};
    const pbrt_texture *t = placing ? placing : &once;
    size_t size = (size_t)image->width * image->height * image->channels * (image->floats ? 4 : 1);
    if (pbrt_spend(p, place, size)) return p->status;
    snell_param params[] = {
        {"width", SNELL_PARAM_INT, {.i = image->width}},
        {"height", SNELL_PARAM_INT, {.i = image->height}},
        {"format", SNELL_PARAM_STRING, {.s = image_format_word(image)}},
        {"pixels", SNELL_PARAM_ARRAY, {.array = {image->pixels, size}}},
        {"encoding", SNELL_PARAM_STRING, {.s = srgb ? "srgb" : "linear"}},
        {"wrap_u", SNELL_PARAM_STRING, {.s = pbrt_wrap_words[t->wrap]}},
        {"wrap_v", SNELL_PARAM_STRING, {.s = placing ? pbrt_wrap_words[t->wrap] : "clamp"}},
        {"filter", SNELL_PARAM_STRING, {.s = t->nearest ? "nearest" : "linear"}},
        {"map", SNELL_PARAM_STRING, {.s = "uv"}},
        {"uv_scale", SNELL_PARAM_VEC3, {.v = {(float)t->scale[0], (float)t->scale[1], 0}}},
        {"uv_offset", SNELL_PARAM_VEC3, {.v = {(float)t->offset[0], (float)t->offset[1], 0}}},
    };
    uint32_t index;
    object_source source = {NULL, place.file, place.line};
    if (pbrt_blame(p, place,
                   description_add(p->d, CATEGORY_TEXTURE, "image", params,
                                   sizeof params / sizeof params[0], source, &index)))
        return p->status;
    *out = (snell_texture_id){index + 1, 0};
    return SNELL_OK;
}

/* ---- trees ---- */

static double wrapped(double x, int wrap) {
    if (wrap == 1) return clamp01(x);
    x -= floor(x);
    return x;
}

static double shown(const pbrt_texture *t, double value) {
    value *= t->factor;
    return t->invert ? double_max(0, 1 - value) : value;
}

/* Bilinear, or the nearest pixel. */
static void image_at(const pbrt_texture *t, double u, double v, double out[3]) {
    const decoded_image *image = &t->image;
    double x = wrapped(u, t->wrap) * image->width - 0.5,
           y = (1 - wrapped(v, t->wrap)) * image->height - 0.5, c[3];
    if (t->nearest) x = floor(x + 0.5), y = floor(y + 0.5);
    long x0 = (long)floor(x), y0 = (long)floor(y), w = image->width, h = image->height;
    double fx = x - (double)x0, fy = y - (double)y0;
    out[0] = out[1] = out[2] = 0;
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++) {
            double weight = (i ? fx : 1 - fx) * (j ? fy : 1 - fy);
            if (weight == 0) continue;
            long px = x0 + i, py = y0 + j;
            px = t->wrap == 1 ? (px < 0 ? 0 : px >= w ? w - 1 : px) : (px + w) % w;
            py = t->wrap == 1 ? (py < 0 ? 0 : py >= h ? h - 1 : py) : (py + h) % h;
            pbrt_pixel(image, t->gamma, (uint32_t)px, (uint32_t)py, c);
            for (int k = 0; k < 3; k++) out[k] += weight * c[k];
        }
    if (t->is_float) out[0] = out[1] = out[2] = (out[0] + out[1] + out[2]) / 3;
    for (int k = 0; k < 3; k++) out[k] = shown(t, out[k]);
}

static void value_of(const pbrt *p, size_t index, double u, double v, double out[3]) {
    const pbrt_texture *t = &p->textures[index];
    double s = u * t->scale[0] + t->offset[0], r = v * t->scale[1] + t->offset[1], a[3], b[3], w[3];
    memcpy(out, t->value, sizeof t->value);
    switch (t->kind) {
    case PBRT_CONSTANT:
    case PBRT_NOISE: return;
    case PBRT_IMAGE: image_at(t, s, r, out); return;
    case PBRT_CHECKER: {
        bool even = fabs(fmod(floor(s) + floor(r), 2)) < 0.5;
        value_of(p, t->parts[even ? 0 : 1], u, v, out);
        return;
    }
    case PBRT_BILERP:
        for (int k = 0; k < 3; k++)
            out[k] = (1 - s) * ((1 - r) * t->corners[0][k] + r * t->corners[1][k]) +
                     s * ((1 - r) * t->corners[2][k] + r * t->corners[3][k]);
        return;
    case PBRT_SCALE:
        value_of(p, t->parts[0], u, v, a);
        value_of(p, t->parts[1], u, v, b);
        for (int k = 0; k < 3; k++) out[k] = a[k] * b[k];
        return;
    case PBRT_MIX:
        value_of(p, t->parts[0], u, v, a);
        value_of(p, t->parts[1], u, v, b);
        value_of(p, t->parts[2], u, v, w);
        for (int k = 0; k < 3; k++) out[k] = (1 - w[0]) * a[k] + w[0] * b[k];
        return;
    }
}

bool pbrt_can_bake(const pbrt *p, size_t texture) {
    return p->textures[texture].pixels > 0 && p->textures[texture].nodes <= NODES_MAX;
}

static void put_value(double c[3], bool is_float, double power, const double factor[3],
                      float out[4]) {
    if (is_float) c[0] = c[1] = c[2] = (c[0] + c[1] + c[2]) / 3;
    for (int k = 0; k < 3; k++) {
        double v = double_max(c[k], 0);
        v = factor[k] * (power == 1 ? v : fn_pow(v, power));
        out[k] = (float)double_min(v, is_float ? 1e30 : 1);
    }
    out[3] = 1;
}

snell_status pbrt_bake(pbrt *p, size_t texture, bool is_float, double power, const double factor[3],
                       source_place place, snell_texture_id *out) {
    const pbrt_texture *t = &p->textures[texture];
    bool alone = t->kind == PBRT_IMAGE; /* pixel by pixel, and placed as it is */
    uint32_t side = t->pixels < SIDE_MAX ? t->pixels : SIDE_MAX;
    decoded_image made = {.width = alone ? t->image.width : side,
                          .height = alone ? t->image.height : side,
                          .channels = 4,
                          .floats = true};
    size_t count = (size_t)made.width * made.height;
    if (pbrt_spend(p, place, 16 * (uint64_t)count)) return p->status;
    made.pixels = memory_resize(NULL, count, 16);
    if (made.pixels == NULL) return pbrt_blame(p, place, error_no_memory());
    float *at = (float *)(void *)made.pixels;
    for (uint32_t y = 0; y < made.height; y++)
        for (uint32_t x = 0; x < made.width; x++, at += 4) {
            double c[3];
            if (alone) {
                pbrt_pixel(&t->image, t->gamma, x, y, c);
                for (int k = 0; k < 3; k++) c[k] = shown(t, c[k]);
            } else {
                value_of(p, texture, (x + 0.5) / made.width, 1 - (y + 0.5) / made.height, c);
            }
            put_value(c, is_float, power, factor, at);
        }
    pbrt_texture plain = {.scale = {1, 1}};
    pbrt_add_image(p, place, &made, false, alone ? t : &plain, out);
    free(made.pixels);
    return p->status;
}
