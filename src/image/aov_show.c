/* AOVs for the eye. What is not light is meant for a screen as it is: the values below are sRGB's,
 * decoded, so that writing encodes them again. */
#include <math.h>
#include <string.h>

#include "image/aov.h"
#include "image/magma.h"
#include "image/srgb.h"

static const float NOWHERE = 1e9f; /* depth beyond this is of nothing */

typedef struct view {
    const film_layer *layer;
    float low[3], high[3]; /* of each channel, of what is somewhere */
    float largest;         /* magnitude of any */
} view;

static bool is_somewhere(const film_layer *layer, const float *p) {
    if (layer->kind->shown == AOV_DEPTH_SHOWN) return p[0] < NOWHERE;
    for (uint32_t c = 0; c < layer->channels; c++)
        if (p[c] != 0) return true;
    return false;
}

static view measure(const film_layer *layer, size_t count) {
    view v = {.layer = layer};
    for (int c = 0; c < 3; c++) v.low[c] = INFINITY, v.high[c] = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        const float *p = layer->pixels + i * layer->channels;
        if (!is_somewhere(layer, p)) continue;
        for (uint32_t c = 0; c < layer->channels && c < 3; c++) {
            if (p[c] < v.low[c]) v.low[c] = p[c];
            if (p[c] > v.high[c]) v.high[c] = p[c];
            if (fabsf(p[c]) > v.largest) v.largest = fabsf(p[c]);
        }
    }
    return v;
}

/* Where a value lies between the least and the greatest, 0 .. 1. */
static double place_between(const view *v, uint32_t c, float value) {
    double range = (double)v->high[c] - (double)v->low[c];
    return range > 0 ? ((double)value - (double)v->low[c]) / range : 1;
}

/* A hue, more or less of it, and how light: from the bits of a scrambled number, none of them dark. */
static dvec3 color_of(uint32_t id) {
    uint32_t h = id * 0x9e3779b1u;
    h = (h ^ h >> 15) * 0x85ebca6bu;
    h ^= h >> 13;
    double hue = 6 * (h & 0xffff) / 65536.0, strength = 0.5 + 0.3 * (h >> 16 & 255) / 255,
           value = 0.7 + 0.3 * (h >> 24) / 255;
    double part[3];
    for (int i = 0; i < 3; i++) { /* red, green and blue rise and fall along the hue */
        double place = hue + 6 - 2 * i;
        double from_peak = fabs(place - 6 * floor(place / 6) - 3); /* 3 at its own hue */
        part[i] = value * (1 - strength * (1 - clamp01(from_peak - 1)));
    }
    return (dvec3){part[0], part[1], part[2]};
}

static dvec3 mixed_matte(const float *p) {
    dvec3 sum = {0, 0, 0};
    for (int i = 0; i < CRYPTO_RANKS; i++) {
        uint32_t id;
        memcpy(&id, &p[2 * i], sizeof id);
        sum = dvec3_add(sum, dvec3_scale(color_of(id), (double)p[2 * i + 1]));
    }
    return sum;
}

static double fraction(float x) { return (double)x - floor((double)x); }

/* The value for a screen, before decoding. */
static dvec3 screen_value(const view *v, const float *p) {
    dvec3 out = {0, 0, 0};
    if (!is_somewhere(v->layer, p) && v->layer->kind->shown != AOV_VECTOR_SHOWN) return out;
    switch (v->layer->kind->shown) {
    case AOV_DEPTH_SHOWN: out.x = out.y = out.z = 1 - 0.9 * place_between(v, 0, p[0]); break;
    case AOV_PLACE_SHOWN:
        return (dvec3){place_between(v, 0, p[0]), place_between(v, 1, p[1]),
                       place_between(v, 2, p[2])};
    case AOV_NORMAL_SHOWN:
        return (dvec3){((double)p[0] + 1) / 2, ((double)p[1] + 1) / 2, ((double)p[2] + 1) / 2};
    case AOV_UNIT_SHOWN: return (dvec3){fraction(p[0]), fraction(p[1]), 0};
    case AOV_VECTOR_SHOWN: {
        double scale = v->largest > 0 ? 0.5 / (double)v->largest : 0;
        return (dvec3){0.5 + scale * (double)p[0], 0.5 + scale * (double)p[1], 0.5};
    }
    case AOV_ID_SHOWN: return color_of((uint32_t)p[0]);
    case AOV_MATTE_SHOWN: return mixed_matte(p);
    case AOV_HEAT_SHOWN: {
        uint8_t srgb[3];
        magma_color(sqrt((double)(p[0] / v->largest)), srgb);
        return (dvec3){srgb[0] / 255.0, srgb[1] / 255.0, srgb[2] / 255.0};
    }
    default: break;
    }
    return out;
}

snell_status aov_show(const film_layer *layer, film *out, bool *is_light) {
    bool as_it_is = layer->kind->shown == AOV_LIGHT_SHOWN || layer->kind->shown == AOV_COLOR_SHOWN;
    *is_light = layer->kind->shown == AOV_LIGHT_SHOWN;
    if (as_it_is) return aov_values(layer, out);
    snell_status status = film_resize(out, layer->width, layer->height, 3);
    if (status) return status;
    size_t count = (size_t)layer->width * layer->height;
    view v = measure(layer, count);
    for (size_t i = 0; i < count; i++) {
        dvec3 shown = screen_value(&v, layer->pixels + i * layer->channels);
        float *to = out->pixels + 3 * i;
        to[0] = srgb_to_linear(shown.x), to[1] = srgb_to_linear(shown.y);
        to[2] = srgb_to_linear(shown.z);
    }
    return SNELL_OK;
}

snell_status aov_values(const film_layer *layer, film *out) {
    if (layer->channels > 3)
        return error_set(SNELL_ERR_UNSUPPORTED, "write .exr, or .png to look at it",
                         "the AOV '%s' has %u channels", layer->name, layer->channels);
    snell_status status = film_resize(out, layer->width, layer->height, 3);
    if (status) return status;
    size_t count = (size_t)layer->width * layer->height;
    for (size_t i = 0; i < count; i++)
        for (uint32_t c = 0; c < 3; c++) {
            const float *p = layer->pixels + i * layer->channels;
            out->pixels[3 * i + c] = layer->channels == 1 ? p[0] : c < layer->channels ? p[c] : 0;
        }
    return SNELL_OK;
}
