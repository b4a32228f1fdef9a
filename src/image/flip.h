/* FLIP: how different two pictures look to somebody who flips between them on a screen, from 0 to 1
 * at each pixel. Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild, FLIP: A
 * Difference Evaluator for Alternating Images, High Performance Graphics 2020. HDR-FLIP, for
 * pictures brighter than a screen, is the largest FLIP over the exposures that matter: Andersson,
 * Nilsson, Shirley, Akenine-Moller, Visualizing Errors in Rendered High Dynamic Range Images,
 * Eurographics 2021. */
#ifndef SNELL_IMAGE_FLIP_H
#define SNELL_IMAGE_FLIP_H

#include "base/thread.h"

/* `count` pixels of row y from x on, as linear Rec. 709, three floats each: finite, not negative
 * and, but for HDR-FLIP, at most 1. Called by several threads. */
typedef void flip_read_fn(const void *user, uint32_t x, uint32_t y, uint32_t count, float *rgb);
typedef struct flip_picture {
    flip_read_fn *read;
    const void *user;
} flip_picture;

/* A screen of 3840 pixels in 0.7 m, seen from 0.7 m: the paper's. */
#define FLIP_PIXELS_PER_DEGREE 67.020643276582255

typedef struct flip_options {
    uint32_t width, height;
    double pixels_per_degree; /* 1 to 1000 */
    bool hdr;
    /* Called by the calling thread at least each 100 ms; false: SNELL_CANCELLED; may be NULL. */
    bool (*progress)(void *user, double fraction);
    void *user;
} flip_options;

/* `map` gets one float a pixel, rows top first. The same bits for any pool. */
snell_status flip_map(const flip_picture *reference, const flip_picture *test,
                      const flip_options *options, thread_pool *pool, float *map);

#endif
