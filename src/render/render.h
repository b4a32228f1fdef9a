/* From a frozen scene to a film: blocks of 16x16 pixels, aligned to the whole picture's corner,
 * shared out to the workers. Any order of blocks and any number of workers gives the same film. */
#ifndef SNELL_RENDER_RENDER_H
#define SNELL_RENDER_RENDER_H

#include "integrators/integrator.h"

enum { PROGRESS_MS = 50 /* between two reports, at least */ };

typedef struct render_options {
    wave_settings wave;
    uint32_t crop_x, crop_y, crop_width, crop_height; /* the part to render: the film's size */
    uint32_t samples; /* per pixel; with a noise or a time limit, at most */
    uint32_t sharing; /* as of wave_samples; of a time limit without noise it is its outcome */
    double noise, time_limit; /* 0: none (adaptive.h); seconds */
    snell_progress_fn
        *progress; /* at least every 100 ms, never two at once; false cancels; may be NULL */
    void *user;
} render_options;

/* Sizes, clears and fills the film. SNELL_CANCELLED: the blocks that were done are in it, each with the
 * samples it had. With a noise the film keeps variance and samples. */
snell_status render_film(const render_options *options, thread_pool *pool, film *out,
                         snell_render_stats *stats);
/* What a wave ended with, as an error with its text; spent: a ray met more of a solid than it can hold. */
snell_status render_status(snell_status of_wave, bool spent);

#endif
