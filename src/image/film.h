/* The film adds in fixed point, so the order of adding is free: 128-bit integers with a least bit
 * of 2^-80.
 *
 * A block of 16x16 pixels is summed by one worker (film_block), and leaves means in floats behind
 * in the film. */
#ifndef SNELL_IMAGE_FILM_H
#define SNELL_IMAGE_FILM_H

#include "base/error.h"
#include "maths/vec.h"

__extension__ typedef __int128 fixed128;
#define FIXED128_MAX ((fixed128)(((fixed128)INT64_MAX << 64) | UINT64_MAX))

enum { FILM_BLOCK = 16 /* pixels on a side, aligned to the whole picture's corner */ };

typedef struct film_block {
    fixed128 sums[FILM_BLOCK * FILM_BLOCK][4]; /* red, green, blue, alpha */
    uint64_t overflows; /* contributions that were not finite or over 2^46: they are left out; and
                           sums beyond 2^47: they stay there */
} film_block;

/* value in units of 2^-80, or 0 with *overflows counted. */
fixed128 fixed_from(double value, uint64_t *overflows);
double fixed_to(fixed128 value);
/* A sum stays at the largest number, whatever the order of what is added, with *overflows counted. */
void fixed_add(fixed128 *sum, fixed128 value, uint64_t *overflows);

void film_block_clear(film_block *b);
void film_block_add(film_block *b, uint32_t pixel, dvec3 radiance);
void film_block_add_alpha(film_block *b, uint32_t pixel, double alpha);

/* What a picture has beside its light, such as depth: image/aov.h says what it is. */
typedef struct aov_info aov_info;
typedef struct film_layer {
    const aov_info *kind;
    char *name; /* owned; unique in its film */
    uint32_t width, height, channels;
    float *pixels;  /* interleaved, rows as the film's */
    char *manifest; /* owned; of a cryptomatte, JSON; NULL elsewhere */
} film_layer;
/* Adds `channels` sums; one that is too large stays at the largest number, as those of a block do. */
void film_add(fixed128 to[], const fixed128 from[], uint32_t channels, uint64_t *overflows);

/* The sums of a whole film, where a render comes back to a block: of each of `parts` sub-films. */
typedef struct film_sums {
    uint32_t width, channels, parts;
    size_t count;
    fixed128 *sums; /* by pixel, part, channel */
} film_sums;

snell_status film_sums_create(uint32_t width, uint32_t height, uint32_t channels, uint32_t parts,
                              film_sums *out);
void film_sums_free(film_sums *s);
void film_sums_clear(film_sums *s);
void film_sums_add(film_sums *s, uint32_t part, uint32_t x, uint32_t y, const fixed128 sum[4],
                   uint64_t *overflows);

typedef struct film {
    uint32_t width, height, channels; /* channels 3 or 4 (alpha, premultiplied) */
    float *pixels;                    /* rows, top first */
    float *variance;                  /* of the mean, 3 for each pixel; NULL: not known */
    uint32_t *samples;                /* of each pixel; NULL: all the same */
    uint32_t encoded_bits; /* of a file for screens (sRGB), decoded: 8 or 16; 0: linear light */
    film_layer *layers;    /* owned */
    size_t layer_count, layer_capacity;
} film;

snell_status film_resize(film *f, uint32_t width, uint32_t height,
                         uint32_t channels); /* and clears it; then it has no layers */
void film_free(film *f);
/* One more layer of the film's size, all 0; name and manifest (may be NULL) are copied. */
snell_status film_add_layer(film *f, const aov_info *kind, const char *name, uint32_t channels,
                            const char *manifest);
snell_status film_keep_variance(film *f); /* room for variance and samples, cleared */
/* The mean over `samples` goes to x, y of the film. */
void film_set(film *f, uint32_t x, uint32_t y, const fixed128 sum[4], uint32_t samples);
/* The same of the whole film's sums; with four parts, of samples / 4 each, the variance of that
 * mean too, into the film and *variance. The sum over red, green and blue of the mean: *light. */
void film_set_from(film *f, uint32_t x, uint32_t y, const film_sums *s, uint32_t samples,
                   double *light, double *variance);
/* The image hash: FNV-1a, 64 bits, of width, height, channels and the bytes of all floats (little
 * endian). */
uint64_t film_hash(const film *f);

#endif
