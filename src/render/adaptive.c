#include "render/adaptive.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"

/* ---- the bound ---- */

/* F(n, 3 n) at n = 1, 2, 4, .. 64, at 97.5 %: half of what the confidence leaves for being wrong is for
 * looking more than once, since a block's bound is near the limit at two or so of the counts. */
static const double quantiles[] = {17.4434, 7.2599, 4.1212, 2.7791, 2.0931, 1.7031, 1.4658};

/* F wants normal values. Where light is rare and bright, four that missed some are too small and too near to
 * each other at once, and what is looked at until it is small is small by chance too: a pixel counts as a
 * quarter of one. bench-noise measures whether that suffices. */
static const double SHARE_OF_PIXEL = 0.25;

static double quantile(double n) {
    double low = 1;
    size_t i = 0, last = sizeof quantiles / sizeof quantiles[0] - 1;
    while (i + 1 < last && n >= 2 * low) {
        low *= 2;
        i++;
    }
    double part = (n - low) / low; /* the quantile is convex: on the chord it is too large */
    if (part > 1) part = 1;
    return quantiles[i] + (quantiles[i + 1] - quantiles[i]) * part;
}

void noise_add(noise_sums *sums, double light, double variance) {
    sums->light += light;
    sums->variance += variance;
    sums->squares += variance * variance;
    sums->pixels++;
}

double noise_unseen(uint64_t samples) { return 3 / (double)samples; }

double noise_bound(const noise_sums *block, uint32_t samples, double image_mean) {
    double unseen = noise_unseen((uint64_t)samples * block->pixels);
    if (!(block->variance > 0)) return unseen;
    /* The expectation of v^2 is 1 + 2/3 times the squared variance, v having 3 degrees of freedom. */
    double n = 5.0 / 3 * block->variance * block->variance / block->squares;
    if (!(n < block->pixels)) n = block->pixels;
    n *= SHARE_OF_PIXEL;
    if (!(n > 1)) n = 1; /* squares may be infinite */
    double values = 3.0 * block->pixels;
    double error = sqrt(block->variance / values * quantile(n));
    return error / (fabs(block->light) / values + 0.01 * fabs(image_mean)) + unseen;
}

/* ---- rounds ---- */

uint32_t noise_next_count(uint32_t samples) {
    uint32_t power = NOISE_FIRST;
    while (power <= samples / 2) power *= 2;
    if (samples < power) return power;
    return samples < power + power / 2 ? power + power / 2 : 2 * power;
}

static bool is_decision(uint32_t samples) {
    return samples > 0 && noise_next_count(samples - 1) == samples;
}

/* A block does not retire before what it has not met would not matter even if so many times as bright. */
static const double UNSEEN = 50;

static bool is_under(const adaptive *a, const adaptive_block *b) {
    double unseen = noise_unseen((uint64_t)b->samples * b->sums.pixels);
    return b->bound <= a->noise && unseen * UNSEEN <= a->noise;
}

bool adaptive_begin(adaptive *a, size_t block_count) {
    a->block_count = a->active_count = block_count;
    a->blocks = memory_zeroed(block_count, sizeof *a->blocks);
    a->active = memory_zeroed(block_count, sizeof *a->active);
    if (a->blocks == NULL || a->active == NULL) {
        a->block_count = 0;
        return false;
    }
    for (size_t i = 0; i < block_count; i++) a->active[i] = (uint32_t)i;
    return true;
}

void adaptive_free(adaptive *a) {
    free(a->blocks);
    free(a->active);
}

/* How many samples fit into the time left. */
static uint32_t fitting(const adaptive *a, double now) {
    double fits = (a->started + a->time_limit - now) / (a->seconds_each * (double)a->active_count);
    if (!(fits > 0)) return 0;
    return fits < 1 << 20 ? (uint32_t)fits : 1 << 20;
}

/* As many samples as should end in time, and no more than there are: a rate that changes is seen. The
 * first round must end: two samples, since `-n 1` is the pixel's centre. */
static uint32_t step_in_time(const adaptive *a, double now) {
    if (a->samples == 0) return a->scrambles < 2 ? 2 : a->scrambles;
    uint32_t step = fitting(a, now);
    if (step > a->samples) step = a->samples;
    return step / a->scrambles * a->scrambles;
}

uint32_t adaptive_start_over(adaptive *a, double now) {
    uint32_t fits = (uint32_t)(0.9 * fitting(a, now));
    if (fits > a->samples_max) fits = a->samples_max;
    if (fits <= a->samples) return 0;
    a->samples = 0;
    a->time_limit = 0;
    return a->samples_max = fits;
}

uint32_t adaptive_next(const adaptive *a, double now) {
    if (a->active_count == 0 || a->samples >= a->samples_max) return 0;
    uint32_t next = a->noise > 0 ? noise_next_count(a->samples) : a->samples_max;
    if (a->time_limit > 0) {
        uint32_t step = step_in_time(a, now);
        if (step == 0) return 0;
        if (next > a->samples + step) next = a->samples + step;
    }
    return next < a->samples_max ? next : a->samples_max;
}

static double mean_of(const adaptive *a) {
    double light = 0, values = 0;
    for (size_t i = 0; i < a->block_count; i++) {
        light += a->blocks[i].sums.light;
        values += 3.0 * a->blocks[i].sums.pixels;
    }
    return light / values;
}

void adaptive_decide(adaptive *a, uint32_t samples, double seconds) {
    a->seconds_each = seconds / ((double)(samples - a->samples) * (double)a->active_count);
    a->samples = samples;
    if (!(a->noise > 0)) return;
    double image_mean = mean_of(a);
    size_t active = 0;
    for (size_t i = 0; i < a->active_count; i++) {
        adaptive_block *b = &a->blocks[a->active[i]];
        b->bound = noise_bound(&b->sums, b->samples, image_mean);
        if (is_under(a, b) && is_decision(samples)) continue;
        a->active[active++] = a->active[i];
    }
    a->active_count = active;
    a->bound_max = 0;
    a->under = 0;
    for (size_t i = 0; i < a->block_count; i++) {
        const adaptive_block *b = &a->blocks[i];
        a->under += is_under(a, b);
        if (b->bound > a->bound_max) a->bound_max = b->bound;
    }
}

double adaptive_work_left(const adaptive *a) {
    double work = 0;
    for (size_t i = 0; i < a->active_count; i++) {
        double ratio = a->noise > 0 && a->samples >= NOISE_FIRST
                           ? a->blocks[a->active[i]].bound / a->noise
                           : INFINITY;
        double samples = a->samples * ratio * ratio;
        if (!(samples < a->samples_max)) samples = a->samples_max;
        if (samples > a->samples) work += samples - a->samples;
    }
    return work;
}
