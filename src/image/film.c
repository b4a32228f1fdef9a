#include "image/film.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

/* (fixed128)(value * 2^80), truncated towards 0, in two halves that a register holds: several times as fast as the
 * compiler's conversion. Every step but the last is exact. */
fixed128 fixed_from(double value, uint64_t *overflows) {
    if (!(fabs(value) < 0x1p46)) { /* infinity and NaN too */
        (*overflows)++;
        return 0;
    }
    double scaled = value * 0x1p17;
    int64_t high = (int64_t)scaled;
    int64_t low = (int64_t)((scaled - (double)high) * 0x1p63);
    return (fixed128)high * ((fixed128)1 << 63) + low;
}

double fixed_to(fixed128 value) { return (double)value * 0x1p-80; }

void film_block_clear(film_block *b) { memset(b, 0, sizeof *b); }

/* Whatever the order: light is not negative. */
void fixed_add(fixed128 *sum, fixed128 value, uint64_t *overflows) {
    if (!__builtin_add_overflow(*sum, value, sum)) return;
    *sum = value < 0 ? -FIXED128_MAX : FIXED128_MAX;
    (*overflows)++;
}

static void add(fixed128 *sum, double value, uint64_t *overflows) {
    fixed_add(sum, fixed_from(value, overflows), overflows);
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
    film_free(f);
    *f = (film){.width = width, .height = height, .channels = channels, .pixels = pixels};
    return SNELL_OK;
}

static void free_layer(film_layer *l) {
    free(l->name);
    free(l->pixels);
    free(l->manifest);
}

void film_free(film *f) {
    for (size_t i = 0; i < f->layer_count; i++) free_layer(&f->layers[i]);
    free(f->layers);
    free(f->pixels);
    free(f->variance);
    free(f->samples);
    *f = (film){0};
}

snell_status film_add_layer(film *f, const aov_info *kind, const char *name, uint32_t channels,
                            const char *manifest) {
    film_layer made = {
        .kind = kind,
        .name = memory_copy_string(name),
        .width = f->width,
        .height = f->height,
        .channels = channels,
        .pixels = memory_zeroed((size_t)f->width * f->height, channels * sizeof *made.pixels),
        .manifest = manifest ? memory_copy_string(manifest) : NULL};
    bool room = made.name && made.pixels && (made.manifest || !manifest);
    if (!room || !ARRAY_GROW(f->layers, f->layer_count, f->layer_capacity, 1)) {
        free_layer(&made);
        return error_set(SNELL_ERR_MEMORY, "ask for fewer AOVs, or a smaller picture",
                         "no memory for the AOV '%s' of %u x %u pixels", name, f->width, f->height);
    }
    f->layers[f->layer_count++] = made;
    return SNELL_OK;
}

snell_status film_keep_variance(film *f) {
    size_t count = (size_t)f->width * f->height;
    f->variance = memory_zeroed(count, 3 * sizeof *f->variance);
    f->samples = memory_zeroed(count, sizeof *f->samples);
    return f->variance && f->samples ? SNELL_OK : error_no_memory();
}

void film_set(film *f, uint32_t x, uint32_t y, const fixed128 sum[4], uint32_t samples) {
    float *out = f->pixels + ((size_t)y * f->width + x) * f->channels;
    for (uint32_t c = 0; c < f->channels; c++) out[c] = (float)(fixed_to(sum[c]) / samples);
}

/* ---- a whole film's sums ---- */

snell_status film_sums_create(uint32_t width, uint32_t height, uint32_t channels, uint32_t parts,
                              film_sums *out) {
    *out = (film_sums){width, channels, parts, (size_t)width * height * channels * parts, NULL};
    out->sums = memory_zeroed(out->count, sizeof *out->sums);
    if (out->sums) return SNELL_OK;
    return error_set(SNELL_ERR_MEMORY,
                     "make a smaller picture, or without --noise and --time-limit",
                     "no memory for the sums of %u x %u pixels", width, height);
}

void film_sums_free(film_sums *s) {
    free(s->sums);
    s->sums = NULL;
}

void film_sums_clear(film_sums *s) { memset(s->sums, 0, s->count * sizeof *s->sums); }

static fixed128 *sums_of(const film_sums *s, uint32_t x, uint32_t y) {
    return s->sums + ((size_t)y * s->width + x) * s->parts * s->channels;
}

void film_add(fixed128 to[], const fixed128 from[], uint32_t channels, uint64_t *overflows) {
    for (uint32_t c = 0; c < channels; c++) fixed_add(&to[c], from[c], overflows);
}

void film_sums_add(film_sums *s, uint32_t part, uint32_t x, uint32_t y, const fixed128 sum[4],
                   uint64_t *overflows) {
    film_add(sums_of(s, x, y) + (size_t)part * s->channels, sum, s->channels, overflows);
}

/* The variance of the mean of four: that of the four, over 4. */
static double variance_of_mean(const fixed128 *first, uint32_t stride, double samples) {
    double value[4], mean = 0, squares = 0;
    for (int part = 0; part < 4; part++) {
        value[part] = fixed_to(first[(size_t)part * stride]) / samples;
        mean += value[part] / 4;
    }
    for (int part = 0; part < 4; part++) squares += (value[part] - mean) * (value[part] - mean);
    return squares / 3 / 4;
}

void film_set_from(film *f, uint32_t x, uint32_t y, const film_sums *s, uint32_t samples,
                   double *light, double *variance) {
    const fixed128 *from = sums_of(s, x, y);
    fixed128 sum[4] = {0, 0, 0, 0};
    uint64_t overflows = 0; /* each part has counted its own */
    for (uint32_t part = 0; part < s->parts; part++)
        film_add(sum, from + (size_t)part * s->channels, s->channels, &overflows);
    film_set(f, x, y, sum, samples);
    *light = *variance = 0;
    if (f->samples) f->samples[(size_t)y * f->width + x] = samples;
    for (uint32_t c = 0; c < 3; c++) *light += fixed_to(sum[c]) / samples;
    for (uint32_t c = 0; c < 3 && s->parts == 4; c++) {
        double of_mean = variance_of_mean(from + c, s->channels, samples / 4);
        f->variance[3 * ((size_t)y * f->width + x) + c] = (float)of_mean;
        *variance += of_mean;
    }
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
