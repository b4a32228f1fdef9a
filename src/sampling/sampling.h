/* Random numbers that depend on what they are for, never on when they are drawn: a pure function of
 * (seed, pixel, path code, purpose) and the sample's number. */
#ifndef SNELL_SAMPLING_SAMPLING_H
#define SNELL_SAMPLING_SAMPLING_H

#include <stdint.h>

/* What a number is drawn for: streams of different purposes are independent. */
typedef enum sample_purpose {
    SAMPLE_PIXEL = 1,    /* the place in the pixel */
    SAMPLE_LENS,         /* the place on the lens */
    SAMPLE_TIME,         /* the moment between shutter open and close */
    SAMPLE_LIGHT_CHOICE, /* which light */
    SAMPLE_LIGHT,        /* the place on it */
    SAMPLE_LOBE,         /* which part of a material; does the path go on? */
    SAMPLE_DIRECTION,    /* where it scatters to */
    SAMPLE_COLOR = 8,    /* which colour's way, where they part */
    SAMPLE_ALPHA = 9     /* is there a surface, where it is there in part? */
} sample_purpose;

/* A bijective mix of 64 bits (the finaliser of SplitMix64: Steele, Lea, Flood, OOPSLA 2014). */
uint64_t hash_mix(uint64_t x);

/* More numbers in [0, 1) where two of them do not suffice, as for trying until a point is accepted:
 * number `index` of what (u, v) stands for, independent of all others. */
double sample_more(double u, double v, uint32_t index);

/* A ray's path code: of the camera ray, and of the child in the given slot. The sample's number is
 * not in it: it is the index in the stream, so that what is drawn deep in a path is stratified over
 * the samples of its pixel too. */
#define PATH_CODE_CAMERA 1
uint64_t path_code_child(uint64_t parent, uint32_t slot);

/* What all streams of one pixel share, computed once; and one stream of sample points. */
uint64_t sample_pixel_stream(uint64_t seed, uint32_t pixel_x, uint32_t pixel_y);
/* One of several independent scrambles of a pixel's streams: each is a low-discrepancy sequence by
 * itself. Number 0 is the pixel's own. */
uint64_t sample_scramble(uint64_t pixel_stream, uint32_t scramble);
uint64_t sample_stream(uint64_t pixel_stream, uint64_t path_code, sample_purpose purpose);

typedef struct sample2 {
    double x, y; /* [0, 1) */
} sample2;
/* Point `index` of the stream: two dimensions of an Owen-scrambled Sobol sequence in shuffled
 * order, by hashing (Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020). Any 2^k first
 * points are a (0, k, 2)-net. */
sample2 sample_point(uint64_t stream, uint32_t index);

#endif
