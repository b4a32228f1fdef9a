#include "image/film.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

/* (fixed128)(value * 2^80), truncated towards 0, by shifting the mantissa: several times as fast as the compiler's
 * conversion. */
fixed128 fixed_from(double value, uint64_t *overflows) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    int exponent = (int)(bits >> 52 & 0x7ff) - 1023; /* |value| = 1.mantissa * 2^exponent */
    if (exponent >= 46) {                            /* infinity and NaN too */
        (*overflows)++;
        return 0;
    }
    int shift = exponent + 80 - 52;
    if (shift <= -53) return 0; /* under 2^-80, denormal numbers too */
    fixed128 mantissa = (fixed128)((bits & 0xfffffffffffffu) | 1ull << 52);
    fixed128 magnitude = shift >= 0 ? mantissa << shift : mantissa >> -shift;
    return bits >> 63 ? -magnitude : magnitude;
}

double fixed_to(fixed128 value) { return (double)value * 0x1p-80; }

void film_block_clear(film_block *b) { memset(b, 0, sizeof *b); }

/* A sum stays at the largest number whatever the order of what is added: light is not negative. */
static void add(fixed128 *sum, double value, uint64_t *overflows) {
    if (!__builtin_add_overflow(*sum, fixed_from(value, overflows), sum)) return;
    *sum = value < 0 ? -FIXED128_MAX : FIXED128_MAX;
    (*overflows)++;
}

void film_block_add(film_block *b, uint32_t pixel, dvec3 radiance) {
    fixed128 *sum = b->sums[pixel];
    add(&sum[0], radiance.x, &b->overflows);
    add(&sum[1], radiance.y, &b->overflows);
    add(&sum[2], radiance.z, &b->overflows);
}

void film_block_add_alpha(film_block *b, uint32_t pixel, double alpha) {
    add(&b->sums[pixel][3], alpha, &b->overflows);
}

snell_status film_resize(film *f, uint32_t width, uint32_t height, uint32_t channels) {
    float *pixels = memory_zeroed((size_t)width * height, channels * sizeof *pixels);
    if (pixels == NULL)
        return error_set(SNELL_ERR_MEMORY, "make a smaller picture",
                         "no memory for a picture of %u x %u pixels", width, height);
    free(f->pixels);
    *f = (film){.width = width, .height = height, .channels = channels, .pixels = pixels};
    return SNELL_OK;
}

void film_free(film *f) {
    free(f->pixels);
    *f = (film){0};
}

void film_set(film *f, uint32_t x, uint32_t y, const film_block *b, uint32_t pixel,
              uint32_t samples) {
    float *out = f->pixels + ((size_t)y * f->width + x) * f->channels;
    for (uint32_t c = 0; c < f->channels; c++)
        out[c] = (float)(fixed_to(b->sums[pixel][c]) / samples);
}

uint64_t film_hash(const film *f) {
    uint64_t hash = 0xcbf29ce484222325u;
    uint32_t head[3] = {f->width, f->height, f->channels};
    const uint8_t *parts[2] = {(const uint8_t *)head, (const uint8_t *)f->pixels};
    size_t sizes[2] = {sizeof head, (size_t)f->width * f->height * f->channels * sizeof(float)};
    for (int part = 0; part < 2; part++)
        for (size_t i = 0; i < sizes[part]; i++) hash = (hash ^ parts[part][i]) * 0x100000001b3u;
    return hash;
}
