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

static double aces_curve(double x) {
    double y = x * (x + 0.0245786) - 0.000090537;
    return clamp01(y / (x * (0.983729 * x + 0.4329510) + 0.238081));
}

/* The ACES 1.0 reference rendering and its sRGB output transform as Stephen Hill fits them
 * (github.com/TheRealMJP/BakingLab, ACES.hlsl): to ACEScg with RRT_SAT, one curve for both, and back
 * from there with ODT_SAT. As published: 18 % grey becomes 10.6 %. */
static dvec3 aces(dvec3 c) {
    static const dmat3 in = {
        {0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}};
    static const dmat3 out = {{1.60475, -0.53108, -0.07367},
                              {-0.10208, 1.10813, -0.00605},
                              {-0.00327, -0.07276, 1.07602}};
    c = dmat3_apply(&in, c);
    return dmat3_apply(&out, (dvec3){aces_curve(c.x), aces_curve(c.y), aces_curve(c.z)});
}

/* Stops around 18 % grey from -10 to 6.5 as 0 to 1, then a polynomial through AgX's curve, whose
 * values are for a display of gamma 2.2. */
static double agx_curve(double linear) {
    const double darkest = -12.47393, brightest = 4.026069, ln2 = 0.69314718055994531;
    double stops = linear > 0 ? fn_log(linear) / ln2 : darkest;
    double x = clamp01((stops - darkest) / (brightest - darkest)), x2 = x * x, x4 = x2 * x2;
    return 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 +
           0.1191 * x - 0.00232;
}

static double display(double y) { return y > 0 ? fn_pow(y, 2.2) : 0; }

/* AgX by Troy Sobotka, its base look, in the minimal form that Benjamin Wrensch published
 * (iolite-engine.com/blog_posts/minimal_agx_implementation): colours move towards white as they get
 * brighter, however saturated they are. */
static dvec3 agx(dvec3 c) {
    static const dmat3 in = {{0.842479062253094, 0.0784335999999992, 0.0792237451477643},
                             {0.0423282422610123, 0.878468636469772, 0.0791661274605434},
                             {0.0423756549057051, 0.0784336, 0.879142973793104}};
    static const dmat3 out = {{1.19687900512017, -0.0980208811401368, -0.0990297440797205},
                              {-0.0528968517574562, 1.15190312990417, -0.0989611768448433},
                              {-0.0529716355144438, -0.0980434501171241, 1.15107367264116}};
    c = dmat3_apply(&in, c);
    c = dmat3_apply(&out, (dvec3){agx_curve(c.x), agx_curve(c.y), agx_curve(c.z)});
    return (dvec3){display(c.x), display(c.y), display(c.z)};
}

static const tonemap clip_map = {"clip", "values over 1 become 1", clip};
static const tonemap reinhard_map = {"reinhard", "luminance L becomes L / (1 + L)", reinhard};
static const tonemap neutral_map = {"neutral", "Khronos PBR Neutral: colours stay, highlights bend",
                                    neutral};
static const tonemap aces_map = {"aces", "ACES 1.0 as Hill fits it: film-like, dark, contrasty",
                                 aces};
static const tonemap agx_map = {"agx", "AgX: soft contrast, bright colours turn white", agx};
const tonemap *const tonemaps[] = {&clip_map, &reinhard_map, &neutral_map,
                                   &aces_map, &agx_map,      NULL};

snell_status tonemap_find(const char *name, const tonemap **out) {
    const char *names[sizeof tonemaps / sizeof tonemaps[0]];
    size_t count = 0;
    for (; tonemaps[count]; count++) {
        names[count] = tonemaps[count]->name;
        if (name != NULL && strcmp(name, names[count]) != 0) continue;
        *out = tonemaps[count];
        return SNELL_OK;
    }
    char hint[64] = "clip, reinhard, neutral, aces or agx";
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
