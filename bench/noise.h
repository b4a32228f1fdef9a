/* The bound of a block as a render stated it, and the block's true error, in the same measure: shared
 * by bench-noise and tests/test_noise.c. */
#ifndef SNELL_BENCH_NOISE_H
#define SNELL_BENCH_NOISE_H

#include <math.h>

#include <snell/snell.h>

#include "image/film.h"
#include "render/adaptive.h"

static inline double noise_image_mean(const float *pixels, uint32_t width, uint32_t height) {
    double sum = 0;
    size_t count = (size_t)width * height * 3;
    for (size_t i = 0; i < count; i++) sum += (double)pixels[i];
    return sum / (double)count;
}

/* Of a film of three channels rendered with a noise; reference: as its pixels; mean: the picture's. */
static inline void noise_measure_block(const snell_film *made, const float *reference,
                                       uint32_t block_x, uint32_t block_y, double mean,
                                       double *bound, double *error) {
    uint32_t width, height, x0 = block_x * FILM_BLOCK, y0 = block_y * FILM_BLOCK;
    const float *pixels = snell_film_pixels(made, &width, &height, NULL),
                *variance = snell_film_variance(made);
    noise_sums sums = {.pixels = 0};
    double square = 0;
    for (uint32_t y = y0; y < y0 + FILM_BLOCK && y < height; y++)
        for (uint32_t x = x0; x < x0 + FILM_BLOCK && x < width; x++) {
            double light = 0, of_mean = 0;
            for (int c = 0; c < 3; c++) {
                size_t i = 3 * ((size_t)y * width + x) + (size_t)c;
                double off = (double)pixels[i] - (double)reference[i];
                square += off * off;
                light += (double)pixels[i];
                of_mean += (double)variance[i];
            }
            noise_add(&sums, light, of_mean);
        }
    double values = 3.0 * sums.pixels;
    *bound = noise_bound(&sums, snell_film_samples(made)[(size_t)y0 * width + x0], mean);
    *error = sqrt(square / values) / (sums.light / values + 0.01 * mean);
}

#endif
