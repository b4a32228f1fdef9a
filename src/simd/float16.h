/* Sixteen floats at once, by the rules of float8.h. A mask is sixteen bits, lane 0 lowest. */
#ifndef SNELL_SIMD_FLOAT16_H
#define SNELL_SIMD_FLOAT16_H

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "simd/float8.h"

#if SIMD_AVX512

typedef __m512 f16;

static inline f16 f16_load(const float *p) { return _mm512_loadu_ps(p); }
static inline f16 f16_set(float x) { return _mm512_set1_ps(x); }
/* Eight lanes of the one, then eight of the other. From memory: two times eight. */
static inline f16 f16_pair(float a, float b) {
    return _mm512_mask_broadcastss_ps(_mm512_set1_ps(a), 0xff00, _mm_set_ss(b));
}
static inline f16 f16_twice(const float a[8]) { return _mm512_broadcast_f32x8(_mm256_loadu_ps(a)); }
/* b in the given lanes, a in the others. */
static inline f16 f16_blend(uint32_t lanes, f16 a, f16 b) {
    return _mm512_mask_blend_ps((__mmask16)lanes, a, b);
}
static inline f16 f16_add(f16 a, f16 b) { return _mm512_add_ps(a, b); }
static inline f16 f16_sub(f16 a, f16 b) { return _mm512_sub_ps(a, b); }
static inline f16 f16_mul(f16 a, f16 b) { return _mm512_mul_ps(a, b); }
static inline f16 f16_div(f16 a, f16 b) { return _mm512_div_ps(a, b); }
static inline f16 f16_min(f16 a, f16 b) { return _mm512_min_ps(a, b); }
static inline f16 f16_max(f16 a, f16 b) { return _mm512_max_ps(a, b); }
static inline f16 f16_abs(f16 a) { return _mm512_abs_ps(a); }
static inline uint32_t f16_signs(f16 a) { return _mm512_movepi32_mask(_mm512_castps_si512(a)); }
static inline uint32_t f16_less(f16 a, f16 b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
static inline uint32_t f16_less_equal(f16 a, f16 b) { return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ); }
static inline uint32_t f16_equal(f16 a, f16 b) { return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ); }
static inline void f16_store(float *p, f16 a) { _mm512_storeu_ps(p, a); }
/* In the given lanes only; the memory of the others stays. */
static inline void f16_store_lanes(float *p, f16 a, uint32_t lanes) {
    f16_store(p, _mm512_mask_blend_ps((__mmask16)lanes, f16_load(p), a)); /* can be read soon */
}
static inline void u16_store_lanes(uint32_t *p, uint32_t value, uint32_t lanes) {
    __m512i was = _mm512_loadu_si512(p), now = _mm512_set1_epi32((int)value);
    _mm512_storeu_si512(p, _mm512_mask_blend_epi32((__mmask16)lanes, was, now));
}
static inline uint32_t u16_equal(const uint32_t *p, uint32_t value) {
    return _mm512_cmpeq_epi32_mask(_mm512_loadu_si512(p), _mm512_set1_epi32((int)value));
}
static inline float f16_least(f16 a) { return _mm512_reduce_min_ps(a); }
static inline float f16_most(f16 a) { return _mm512_reduce_max_ps(a); }

#else

typedef struct f16 {
    f8 half[2];
} f16;

static inline f16 f16_load(const float *p) { return (f16){{f8_load(p), f8_load(p + 8)}}; }
static inline f16 f16_set(float x) { return (f16){{f8_set(x), f8_set(x)}}; }
/* Eight lanes of the one, then eight of the other. From memory: two times eight. */
static inline f16 f16_pair(float a, float b) { return (f16){{f8_set(a), f8_set(b)}}; }
static inline f16 f16_twice(const float a[8]) { return (f16){{f8_load(a), f8_load(a)}}; }
/* b in the given lanes, a in the others. */
static inline f16 f16_blend(uint32_t lanes, f16 a, f16 b) {
    return (f16){{f8_blend(lanes & 0xff, a.half[0], b.half[0]),
                  f8_blend(lanes >> 8 & 0xff, a.half[1], b.half[1])}};
}
#define FLOAT16_BINARY(name)                                                                       \
    static inline f16 f16_##name(f16 a, f16 b) {                                                   \
        return (f16){{f8_##name(a.half[0], b.half[0]), f8_##name(a.half[1], b.half[1])}};          \
    }
FLOAT16_BINARY(add)
FLOAT16_BINARY(sub)
FLOAT16_BINARY(mul)
FLOAT16_BINARY(div)
FLOAT16_BINARY(min)
FLOAT16_BINARY(max)
#undef FLOAT16_BINARY
static inline f16 f16_abs(f16 a) { return (f16){{f8_abs(a.half[0]), f8_abs(a.half[1])}}; }
static inline uint32_t f16_signs(f16 a) { return f8_signs(a.half[0]) | f8_signs(a.half[1]) << 8; }
#define FLOAT16_COMPARE(name)                                                                      \
    static inline uint32_t f16_##name(f16 a, f16 b) {                                              \
        return m8_bits(f8_##name(a.half[0], b.half[0])) | m8_bits(f8_##name(a.half[1], b.half[1])) \
                                                              << 8;                                \
    }
FLOAT16_COMPARE(less)
FLOAT16_COMPARE(less_equal)
FLOAT16_COMPARE(equal)
#undef FLOAT16_COMPARE
static inline void f16_store(float *p, f16 a) {
    f8_store(p, a.half[0]);
    f8_store(p + 8, a.half[1]);
}
/* In the given lanes only; the memory of the others stays. */
static inline void f16_store_lanes(float *p, f16 a, uint32_t lanes) {
    float values[16];
    f16_store(values, a);
    for (; lanes != 0; lanes &= lanes - 1) p[__builtin_ctz(lanes)] = values[__builtin_ctz(lanes)];
}
static inline void u16_store_lanes(uint32_t *p, uint32_t value, uint32_t lanes) {
    for (; lanes != 0; lanes &= lanes - 1) p[__builtin_ctz(lanes)] = value;
}
static inline uint32_t u16_equal(const uint32_t *p, uint32_t value) {
    uint32_t lanes = 0;
    for (uint32_t i = 0; i < 16; i++) lanes |= (uint32_t)(p[i] == value) << i;
    return lanes;
}
static inline float f16_least(f16 a) {
    float v[8], least;
    f8_store(v, f8_min(a.half[0], a.half[1]));
    least = v[0];
    for (int i = 1; i < 8; i++) least = v[i] < least ? v[i] : least;
    return least;
}
static inline float f16_most(f16 a) {
    float v[8], most;
    f8_store(v, f8_max(a.half[0], a.half[1]));
    most = v[0];
    for (int i = 1; i < 8; i++) most = v[i] > most ? v[i] : most;
    return most;
}

#endif

/* Bit i of columns[k] is bit k of rows[i]. */
static inline void transpose_bits(const uint8_t rows[16], uint32_t columns[8]) {
#ifdef __SSE2__
    __m128i bits = _mm_loadu_si128((const __m128i *)(const void *)rows);
    for (int k = 7; k >= 0; k--) {
        columns[k] = (uint32_t)_mm_movemask_epi8(bits);
        bits = _mm_add_epi8(bits, bits);
    }
#else
    for (uint32_t k = 0; k < 8; k++) {
        columns[k] = 0;
        for (uint32_t i = 0; i < 16; i++) columns[k] |= (uint32_t)(rows[i] >> k & 1) << i;
    }
#endif
}
#endif
