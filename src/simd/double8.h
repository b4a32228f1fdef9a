/* Eight doubles at once, by the rules of float8.h. A mask is eight bits, lane 0 lowest. */
#ifndef SNELL_SIMD_DOUBLE8_H
#define SNELL_SIMD_DOUBLE8_H

#include <math.h>

#include "simd/float8.h"

#if SIMD_AVX512

typedef __m512d d8;

static inline d8 d8_set(double x) { return _mm512_set1_pd(x); }
static inline d8 d8_from_floats(const float *p) { return _mm512_cvtps_pd(_mm256_loadu_ps(p)); }
static inline void d8_store_floats(float *p, d8 a) { _mm256_storeu_ps(p, _mm512_cvtpd_ps(a)); }
static inline d8 d8_add(d8 a, d8 b) { return _mm512_add_pd(a, b); }
static inline d8 d8_sub(d8 a, d8 b) { return _mm512_sub_pd(a, b); }
static inline d8 d8_mul(d8 a, d8 b) { return _mm512_mul_pd(a, b); }
static inline d8 d8_div(d8 a, d8 b) { return _mm512_div_pd(a, b); }
static inline d8 d8_min(d8 a, d8 b) { return _mm512_min_pd(a, b); }
static inline d8 d8_max(d8 a, d8 b) { return _mm512_max_pd(a, b); }
static inline d8 d8_sqrt(d8 a) { return _mm512_sqrt_pd(a); }
static inline unsigned d8_less(d8 a, d8 b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ); }
static inline unsigned d8_less_equal(d8 a, d8 b) { return _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ); }
static inline unsigned d8_equal(d8 a, d8 b) { return _mm512_cmp_pd_mask(a, b, _CMP_EQ_OQ); }
/* b in the given lanes, a in the others. */
static inline d8 d8_blend(unsigned lanes, d8 a, d8 b) {
    return _mm512_mask_blend_pd((__mmask8)lanes, a, b);
}

#elif defined(__AVX2__)

typedef struct d8 {
    __m256d half[2];
} d8;

static inline d8 d8_set(double x) { return (d8){{_mm256_set1_pd(x), _mm256_set1_pd(x)}}; }
static inline d8 d8_from_floats(const float *p) {
    return (d8){{_mm256_cvtps_pd(_mm_loadu_ps(p)), _mm256_cvtps_pd(_mm_loadu_ps(p + 4))}};
}
static inline void d8_store_floats(float *p, d8 a) {
    for (int i = 0; i < 2; i++) _mm_storeu_ps(p + 4 * i, _mm256_cvtpd_ps(a.half[i]));
}
#define DOUBLE8_BINARY(name)                                                                       \
    static inline d8 d8_##name(d8 a, d8 b) {                                                       \
        return (d8){                                                                               \
            {_mm256_##name##_pd(a.half[0], b.half[0]), _mm256_##name##_pd(a.half[1], b.half[1])}}; \
    }
DOUBLE8_BINARY(add)
DOUBLE8_BINARY(sub)
DOUBLE8_BINARY(mul)
DOUBLE8_BINARY(div)
DOUBLE8_BINARY(min)
DOUBLE8_BINARY(max)
#undef DOUBLE8_BINARY
static inline d8 d8_sqrt(d8 a) {
    return (d8){{_mm256_sqrt_pd(a.half[0]), _mm256_sqrt_pd(a.half[1])}};
}
#define DOUBLE8_COMPARE(name, how)                                                                 \
    static inline unsigned d8_##name(d8 a, d8 b) {                                                 \
        int low = _mm256_movemask_pd(_mm256_cmp_pd(a.half[0], b.half[0], how));                    \
        int high = _mm256_movemask_pd(_mm256_cmp_pd(a.half[1], b.half[1], how));                   \
        return (unsigned)(low | high << 4);                                                        \
    }
DOUBLE8_COMPARE(less, _CMP_LT_OQ)
DOUBLE8_COMPARE(less_equal, _CMP_LE_OQ)
DOUBLE8_COMPARE(equal, _CMP_EQ_OQ)
#undef DOUBLE8_COMPARE
/* b in the given lanes, a in the others. */
static inline d8 d8_blend(unsigned lanes, d8 a, d8 b) {
    const __m256i bits = _mm256_setr_epi64x(1, 2, 4, 8);
    d8 out;
    for (int i = 0; i < 2; i++) {
        __m256i all = _mm256_set1_epi64x((long long)(lanes >> 4 * i));
        __m256i on = _mm256_cmpeq_epi64(_mm256_and_si256(all, bits), bits);
        out.half[i] = _mm256_blendv_pd(a.half[i], b.half[i], _mm256_castsi256_pd(on));
    }
    return out;
}

#else

typedef struct d8 {
    double v[8];
} d8;

#define DOUBLE8_EACH(expression)                                                                   \
    d8 out;                                                                                        \
    for (int i = 0; i < 8; i++) out.v[i] = (expression);                                           \
    return out
static inline d8 d8_set(double x) { DOUBLE8_EACH(x); }
static inline d8 d8_from_floats(const float *p) { DOUBLE8_EACH((double)p[i]); }
static inline void d8_store_floats(float *p, d8 a) {
    for (int i = 0; i < 8; i++) p[i] = (float)a.v[i];
}
static inline d8 d8_add(d8 a, d8 b) { DOUBLE8_EACH(a.v[i] + b.v[i]); }
static inline d8 d8_sub(d8 a, d8 b) { DOUBLE8_EACH(a.v[i] - b.v[i]); }
static inline d8 d8_mul(d8 a, d8 b) { DOUBLE8_EACH(a.v[i] * b.v[i]); }
static inline d8 d8_div(d8 a, d8 b) { DOUBLE8_EACH(a.v[i] / b.v[i]); }
static inline d8 d8_min(d8 a, d8 b) { DOUBLE8_EACH(a.v[i] < b.v[i] ? a.v[i] : b.v[i]); }
static inline d8 d8_max(d8 a, d8 b) { DOUBLE8_EACH(a.v[i] > b.v[i] ? a.v[i] : b.v[i]); }
static inline d8 d8_sqrt(d8 a) { DOUBLE8_EACH(sqrt(a.v[i])); }
#undef DOUBLE8_EACH
#define DOUBLE8_COMPARE(name, operator)                                                            \
    static inline unsigned d8_##name(d8 a, d8 b) {                                                 \
        unsigned lanes = 0;                                                                        \
        for (int i = 0; i < 8; i++) lanes |= (unsigned)(a.v[i] operator b.v[i]) << i;              \
        return lanes;                                                                              \
    }
DOUBLE8_COMPARE(less, <)
DOUBLE8_COMPARE(less_equal, <=)
DOUBLE8_COMPARE(equal, ==)
#undef DOUBLE8_COMPARE
/* b in the given lanes, a in the others. */
static inline d8 d8_blend(unsigned lanes, d8 a, d8 b) {
    for (int i = 0; i < 8; i++) a.v[i] = lanes >> i & 1 ? b.v[i] : a.v[i];
    return a;
}

#endif
#endif
