/* Random numbers that depend on what they are for, never on when they are drawn: a pure function of
 * (seed, pixel, path code, purpose) and the sample's number. */
#ifndef SNELL_SAMPLING_SAMPLING_H
#define SNELL_SAMPLING_SAMPLING_H

#include <stdint.h>

/* What a number is drawn for: streams of different purposes are independent. */
typedef enum sample_purpose {
    SAMPLE_PIXEL = 1,
    SAMPLE_LENS,
    SAMPLE_TIME,
    SAMPLE_LIGHT_CHOICE,
    SAMPLE_LIGHT,
    SAMPLE_LOBE,
    SAMPLE_DIRECTION,
    SAMPLE_ROULETTE,
    SAMPLE_ALPHA
} sample_purpose;

/* A bijective mix of 64 bits (the finaliser of SplitMix64: Steele, Lea, Flood, OOPSLA 2014). */
uint64_t hash_mix(uint64_t x);

/* A ray's path code: of the camera ray, and of the child in the given slot. */
#define PATH_CODE_CAMERA 1
uint64_t path_code_child(uint64_t parent, uint32_t slot);

/* One stream of sample points: for a path and a purpose, of a pixel. */
uint64_t sample_pixel_stream(uint64_t seed, uint32_t pixel_x, uint32_t pixel_y);
uint64_t sample_stream(uint64_t pixel_stream, uint64_t path_code, sample_purpose purpose);

typedef struct sample2 {
    double x, y; /* [0, 1) */
} sample2;
/* Point `index` of the stream: two dimensions of an Owen-scrambled Sobol sequence in shuffled
 * order, by hashing (Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020). Any 2^k first
 * points are a (0, k, 2)-net. */
sample2 sample_point(uint64_t stream, uint32_t index);

#endif
