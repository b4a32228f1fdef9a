/* Random numbers for tests and benchmarks: splitmix64. */
#ifndef SNELL_TESTS_RANDOM_NUMBERS_H
#define SNELL_TESTS_RANDOM_NUMBERS_H

#include <stdint.h>

#include "maths/vec.h"

typedef struct rng {
    uint64_t state;
} rng;

static inline uint64_t rng_bits(rng *r) {
    uint64_t z = (r->state += 0x9e3779b97f4a7c15u);
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}
static inline uint32_t rng_below(rng *r, uint32_t n) { return (uint32_t)(rng_bits(r) >> 33) % n; }
static inline double rng_unit(rng *r) { return (double)(rng_bits(r) >> 11) * 0x1p-53; }
static inline float rng_float(rng *r, double low, double high) {
    return (float)(low + (high - low) * rng_unit(r));
}
static inline vec3 rng_vec3(rng *r, double size) {
    return (vec3){rng_float(r, -size, size), rng_float(r, -size, size), rng_float(r, -size, size)};
}

#endif
