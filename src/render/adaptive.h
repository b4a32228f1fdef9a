/* When a render that comes back to its blocks ends: at a stated error, at a time limit, or at a number
 * of samples, whichever comes first. All decisions about samples are here.
 *
 *     a round of samples over the active blocks ─▶ how far off may each be? ─▶ which go on, to how many?
 *            ▲                                                                        │
 *            └────────────────────────────────────────────────────────────────────────┘
 *
 * Blocks retire at fixed sample counts (noise_next_count), by what all blocks hold after that round: the
 * picture is a function of the bound and the largest number of samples. A time limit only chooses
 * that number.
 *
 * The error. A block's samples are four independent scrambles of a low-discrepancy sequence, so each pixel
 * has four independent values, whose scatter tells the variance v of their mean without bias. The block's
 * error is the root of the mean of (pixel - truth)^2 over its pixels and colours, relative to the block's
 * mean and 1 % of the picture's. Its square over the mean of v is distributed as Fisher's F with n and 3 n
 * degrees of freedom, n being how many pixels have a share in it: (sum v)^2 / sum v^2, made right for the
 * scatter of the v themselves (Satterthwaite 1946), and taken four times smaller. The bound is the estimate
 * times the root of that F's quantile, and what none of the block's samples may have met. */
#ifndef SNELL_RENDER_ADAPTIVE_H
#define SNELL_RENDER_ADAPTIVE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { NOISE_SCRAMBLES = 4, NOISE_FIRST = 16 /* samples per pixel before any block retires */ };
static const double NOISE_CONFIDENCE = 0.95;

/* What the bound is made of: sums over pixels of the mean's red + green + blue (light), of its variance
 * in the same three, and of the square of that. */
typedef struct noise_sums {
    double light, variance, squares;
    uint32_t pixels;
} noise_sums;

void noise_add(noise_sums *sums, double light, double variance);
/* The relative error that a block with so many samples per pixel is under; image_mean: of all pixels and
 * colours. */
double noise_bound(const noise_sums *block, uint32_t samples, double image_mean);
/* The share of a block that none of so many samples has met, at most, with 95 % probability: 3 over their
 * number. It is taken to be as bright as the block. */
double noise_unseen(uint64_t samples);
/* The first count over `samples` at which blocks may retire: 16, 24, 32, 48, 64, 96, ... */
uint32_t noise_next_count(uint32_t samples);

typedef struct adaptive_block {
    noise_sums sums;  /* as of `samples` */
    uint32_t samples; /* per pixel */
    double bound;
} adaptive_block;

typedef struct adaptive {
    double noise, time_limit; /* 0: none; seconds since `started` */
    uint32_t scrambles;       /* 1, or NOISE_SCRAMBLES: of an error */
    uint32_t samples_max;     /* a multiple of scrambles */
    uint32_t samples;         /* of the active blocks, per pixel */
    double started;
    double seconds_each; /* of the last round, for one sample of the pixels of one block */
    adaptive_block *blocks;
    size_t block_count, active_count;
    uint32_t *active; /* blocks that go on */
    double bound_max; /* of all blocks */
    size_t under;     /* blocks whose bound is under the noise */
} adaptive;

/* false: no memory. The rest is set by the caller before. */
bool adaptive_begin(adaptive *a, size_t block_count);
void adaptive_free(adaptive *a);
/* The samples per pixel that the next round ends with; 0: it is over. */
uint32_t adaptive_next(const adaptive *a, double now);
/* The active blocks have `samples`, after a round of `seconds`: their bounds, and which go on. */
void adaptive_decide(adaptive *a, uint32_t samples, double seconds);
/* Samples of a pixel times blocks that are still to come, roughly: noise falls with the root. */
double adaptive_work_left(const adaptive *a);
/* For a picture that depends on the number of its samples beyond their sum, as filtered textures do: after
 * a first round the samples that surely fit, to be rendered from the first; 0: no more than there are. */
uint32_t adaptive_start_over(adaptive *a, double now);

#endif
