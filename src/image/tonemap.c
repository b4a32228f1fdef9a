#include "image/tonemap.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "image/srgb.h"
#include "maths/functions.h"

static dvec3 clip(dvec3 c) { return c; }

/* Reinhard et al., Photographic Tone Reproduction for Digital Images, SIGGRAPH 2002, equation 3:
 * the luminance L becomes L / (1 + L); hue and saturation stay. */
static dvec3 reinhard(dvec3 c) {
    double luminance = 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
    return dvec3_scale(c, 1 / (1 + luminance));
}

/* Khronos PBR Neutral Tone Mapper, version 1.0 (github.com/KhronosGroup/ToneMapping): true to base
 * colours up to 0.8, compresses highlights above and takes their saturation. */
static dvec3 neutral(dvec3 c) {
    const double start = 0.8 - 0.04, desaturation = 0.15;
    double low = double_min(double_min(c.x, c.y), c.z);
    double offset = low < 0.08 ? low - 6.25 * low * low : 0.04;
    c = dvec3_sub(c, (dvec3){offset, offset, offset});
    double peak = dvec3_largest(c);
    if (peak < start) return c;
    double d = 1 - start, new_peak = 1 - d * d / (peak + d - start);
    c = dvec3_scale(c, new_peak / peak);
    double g = 1 - 1 / (desaturation * (peak - new_peak) + 1);
    return (dvec3){c.x + (new_peak - c.x) * g, c.y + (new_peak - c.y) * g,
                   c.z + (new_peak - c.z) * g};
}

static const tonemap clip_map = {"clip", "values over 1 become 1", clip};
static const tonemap reinhard_map = {"reinhard", "luminance L becomes L / (1 + L)", reinhard};
static const tonemap neutral_map = {"neutral", "Khronos PBR Neutral: colours stay, highlights bend",
                                    neutral};
const tonemap *const tonemaps[] = {&clip_map, &reinhard_map, &neutral_map, NULL};

snell_status tonemap_find(const char *name, const tonemap **out) {
    const char *names[sizeof tonemaps / sizeof tonemaps[0]];
    size_t count = 0;
    for (; tonemaps[count]; count++) {
        names[count] = tonemaps[count]->name;
        if (name != NULL && strcmp(name, names[count]) != 0) continue;
        *out = tonemaps[count];
        return SNELL_OK;
    }
    char hint[64] = "clip, reinhard or neutral";
    const char *near = closest_word(name, names, count);
    if (near) snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    return error_set(SNELL_ERR_ARGUMENT, hint, "unknown tone map '%s'", name);
}

double tonemap_exposure(double stops) { return stops == 0 ? 1 : fn_pow(2, stops); }

static double sane(double x) { return x > 0 ? double_min(x, 1e30) : 0; }

dvec3 tonemap_apply(const tonemap *map, double scale, dvec3 color) {
    return map->map((dvec3){sane(color.x * scale), sane(color.y * scale), sane(color.z * scale)});
}

/* threshold[i]: the least linear value that rounds to i + 1. guess[k]: the answer for k / 4096,
 * from where at most a few steps remain: the curve is nowhere steeper than 12.92, which is less
 * than one 8-bit step in 1/4096. */
enum { GUESSES = 4096 };
static double threshold[256];
static uint8_t guess[GUESSES];
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void fill(void) {
    for (int i = 0; i < 255; i++) threshold[i] = srgb_decode((i + 0.5) / 255);
    threshold[255] = INFINITY;
    int value = 0;
    for (int k = 0; k < GUESSES; k++) {
        while ((double)k / GUESSES >= threshold[value]) value++;
        guess[k] = (uint8_t)value;
    }
}

uint8_t tonemap_quantize(double linear) {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 255;
    pthread_once(&once, fill);
    uint8_t value = guess[(int)(linear * GUESSES)];
    while (linear >= threshold[value]) value++;
    return value;
}
