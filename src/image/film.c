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
