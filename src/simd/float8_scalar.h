/* float8.h in plain C: what the other instruction sets must equal. */
#ifndef SNELL_SIMD_FLOAT8_SCALAR_H
#define SNELL_SIMD_FLOAT8_SCALAR_H

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct f8 {
    float v[8];
} f8;
typedef unsigned m8;

static inline f8 f8_load(const float *p) {
    f8 r;
    for (int i = 0; i < 8; i++) r.v[i] = p[i];
    return r;
}
static inline void f8_store(float *p, f8 a) {
    for (int i = 0; i < 8; i++) p[i] = a.v[i];
}
static inline f8 f8_set(float x) {
    f8 r;
    for (int i = 0; i < 8; i++) r.v[i] = x;
    return r;
}

#define FLOAT8_BINARY(name, expression)                                                            \
    static inline f8 name(f8 a, f8 b) {                                                            \
        f8 r;                                                                                      \
        for (int i = 0; i < 8; i++) r.v[i] = (expression);                                         \
        return r;                                                                                  \
    }
FLOAT8_BINARY(f8_add, a.v[i] + b.v[i])
FLOAT8_BINARY(f8_sub, a.v[i] - b.v[i])
FLOAT8_BINARY(f8_mul, a.v[i] * b.v[i])
FLOAT8_BINARY(f8_div, a.v[i] / b.v[i])
FLOAT8_BINARY(f8_min, a.v[i] < b.v[i] ? a.v[i] : b.v[i])
FLOAT8_BINARY(f8_max, a.v[i] > b.v[i] ? a.v[i] : b.v[i])
#undef FLOAT8_BINARY

static inline f8 f8_abs(f8 a) {
    for (int i = 0; i < 8; i++) a.v[i] = fabsf(a.v[i]);
    return a;
}

#define FLOAT8_COMPARE(name, relation)                                                             \
    static inline m8 name(f8 a, f8 b) {                                                            \
        m8 r = 0;                                                                                  \
        for (unsigned i = 0; i < 8; i++) r |= (unsigned)(a.v[i] relation b.v[i]) << i;             \
        return r;                                                                                  \
    }
FLOAT8_COMPARE(f8_less, <)
FLOAT8_COMPARE(f8_less_equal, <=)
FLOAT8_COMPARE(f8_equal, ==)
#undef FLOAT8_COMPARE

static inline m8 m8_and(m8 a, m8 b) { return a & b; }
static inline m8 m8_or(m8 a, m8 b) { return a | b; }
static inline unsigned m8_bits(m8 a) { return a; }

static inline f8 f8_make(float a, float b, float c, float d, float e, float f, float g, float h) {
    return (f8){{a, b, c, d, e, f, g, h}};
}
static inline unsigned f8_signs(f8 a) {
    unsigned r = 0;
    for (unsigned i = 0; i < 8; i++) r |= (unsigned)(signbit(a.v[i]) != 0) << i;
    return r;
}
static inline f8 f8_select(f8 sign, f8 a, f8 b) {
    for (int i = 0; i < 8; i++) a.v[i] = signbit(sign.v[i]) ? b.v[i] : a.v[i];
    return a;
}

static inline f8 f8_blend(unsigned lanes, f8 a, f8 b) {
    for (int i = 0; i < 8; i++) a.v[i] = lanes >> i & 1 ? b.v[i] : a.v[i];
    return a;
}

static inline unsigned f8_least(f8 a, m8 lanes) {
    uint32_t least = ~0u;
    for (unsigned i = 0; i < 8; i++) {
        uint32_t key;
        memcpy(&key, &a.v[i], sizeof key);
        key = (key & ~7u) | i;
        if (lanes >> i & 1 && key < least) least = key;
    }
    return least & 7;
}

static inline void f8_compress(float *to_floats, f8 floats, uint32_t *to_numbers,
                               const uint32_t *numbers, unsigned lanes) {
    for (unsigned i = 0, n = 0; i < 8; i++) {
        to_floats[n] = floats.v[i];
        to_numbers[n] = numbers[i];
        n += lanes >> i & 1;
    }
}

#endif
