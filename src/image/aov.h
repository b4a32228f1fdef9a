/* Arbitrary output variables: layers beside a picture's light, such as depth. aovs.def lists them;
 * integrators/aov.c fills those that are taken from rays. */
#ifndef SNELL_IMAGE_AOV_H
#define SNELL_IMAGE_AOV_H

#include "image/film.h"

/* How a pixel is made of its samples. */
typedef enum aov_mean {
    AOV_MEAN,    /* the mean of all of them, as the picture is */
    AOV_COVERED, /* the mean over what its camera rays met, each by how much of it is there */
    AOV_FIRST,   /* what the first sample met first: numbers have no mean */
    AOV_RANKED,  /* ids, the one that covers most first */
    AOV_SUM
} aov_mean;

/* How it becomes a picture for the eye (aov_show). */
typedef enum aov_shown {
    AOV_LIGHT_SHOWN, /* as the picture is: exposed and tone-mapped */
    AOV_COLOR_SHOWN,
    AOV_DEPTH_SHOWN,  /* near is bright */
    AOV_PLACE_SHOWN,  /* each axis from its least to its greatest value */
    AOV_NORMAL_SHOWN, /* -1 .. 1 as 0 .. 1 */
    AOV_UNIT_SHOWN,   /* the part after the point */
    AOV_VECTOR_SHOWN, /* 0 is grey; the longest is red, green or dark */
    AOV_ID_SHOWN,     /* a colour by hash */
    AOV_MATTE_SHOWN,  /* the same, mixed by coverage */
    AOV_HEAT_SHOWN    /* magma of the square root, up to the largest value */
} aov_shown;

#define CRYPTO_CHANNELS "00.R|00.G|00.B|00.A|01.R|01.G|01.B|01.A|02.R|02.G|02.B|02.A"
enum { AOV_CHANNELS_MAX = 12, CRYPTO_RANKS = 6 };

typedef enum aov_id {
#define AOV(id, layer, channels, count, mean, shown, help) AOV_##id,
#include "image/aovs.def"
#undef AOV
    AOV_COUNT
} aov_id;

struct aov_info {
    const char *name, *layer, *channels; /* channels: "a|b|c" */
    uint32_t channel_count;
    aov_mean mean;
    aov_shown shown;
    const char *help;
};

extern const aov_info aov_table[AOV_COUNT];

/* Bit i: aov_table[i]. A list such as "depth,normal"; NULL or "": none. An unknown name:
 * SNELL_ERR_ARGUMENT with the nearest one. */
typedef uint32_t aov_set;
snell_status aov_parse(const char *list, aov_set *out);
static inline bool aov_has(aov_set set, aov_id id) { return set >> id & 1; }

/* The full name of a layer's channel, such as "N.X": without a dot, of the layer "depth". */
enum { AOV_NAME_MAX = 192 };
void aov_channel_name(const film_layer *layer, uint32_t channel, char out[AOV_NAME_MAX]);

/* The layer as a picture of linear RGB; *is_light: to be exposed and tone-mapped as the picture is,
 * else with exposure 0 and `clip`. */
snell_status aov_show(const film_layer *layer, film *out, bool *is_light);
/* Its numbers as RGB, one channel being grey; SNELL_ERR_UNSUPPORTED of more than three channels. */
snell_status aov_values(const film_layer *layer, film *out);

/* Cryptomatte's ids of names (Psyop, Cryptomatte Specification 1.2.0): MurmurHash3_x86_32 with the seed 0,
 * its exponent kept within 1 .. 254, so that the bits are a finite float's. */
uint32_t crypto_hash(const char *name); /* MurmurHash3 alone */
uint32_t crypto_id(const char *name);
float crypto_float(uint32_t id);

#endif
