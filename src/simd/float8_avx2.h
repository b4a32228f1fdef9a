/* float8.h for AVX2: a mask is a register whose lanes are all ones or all zeros. */
#ifndef SNELL_SIMD_FLOAT8_AVX2_H
#define SNELL_SIMD_FLOAT8_AVX2_H

#include <immintrin.h>
#include <stdint.h>

typedef __m256 f8;
typedef __m256 m8;

static inline f8 f8_load(const float *p) { return _mm256_loadu_ps(p); }
static inline void f8_store(float *p, f8 a) { _mm256_storeu_ps(p, a); }
static inline f8 f8_set(float x) { return _mm256_set1_ps(x); }
static inline f8 f8_add(f8 a, f8 b) { return _mm256_add_ps(a, b); }
static inline f8 f8_sub(f8 a, f8 b) { return _mm256_sub_ps(a, b); }
static inline f8 f8_mul(f8 a, f8 b) { return _mm256_mul_ps(a, b); }
static inline f8 f8_div(f8 a, f8 b) { return _mm256_div_ps(a, b); }
static inline f8 f8_min(f8 a, f8 b) { return _mm256_min_ps(a, b); }
static inline f8 f8_max(f8 a, f8 b) { return _mm256_max_ps(a, b); }
static inline f8 f8_abs(f8 a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a); }
static inline m8 f8_less(f8 a, f8 b) { return _mm256_cmp_ps(a, b, _CMP_LT_OQ); }
static inline m8 f8_less_equal(f8 a, f8 b) { return _mm256_cmp_ps(a, b, _CMP_LE_OQ); }
static inline m8 f8_equal(f8 a, f8 b) { return _mm256_cmp_ps(a, b, _CMP_EQ_OQ); }
static inline m8 m8_and(m8 a, m8 b) { return _mm256_and_ps(a, b); }
static inline m8 m8_or(m8 a, m8 b) { return _mm256_or_ps(a, b); }
static inline unsigned m8_bits(m8 a) { return (unsigned)_mm256_movemask_ps(a); }

static inline f8 f8_make(float a, float b, float c, float d, float e, float f, float g, float h) {
    return _mm256_setr_ps(a, b, c, d, e, f, g, h);
}
static inline unsigned f8_signs(f8 a) { return (unsigned)_mm256_movemask_ps(a); }
static inline f8 f8_select(f8 sign, f8 a, f8 b) { return _mm256_blendv_ps(a, b, sign); }

static inline f8 f8_blend(unsigned lanes, f8 a, f8 b) {
    __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    __m256i has = _mm256_and_si256(_mm256_set1_epi32((int)lanes), bit);
    return _mm256_blendv_ps(a, b, _mm256_castsi256_ps(_mm256_cmpeq_epi32(has, bit)));
}

static inline unsigned f8_least(f8 a, m8 lanes) {
    __m256i key = _mm256_or_si256(_mm256_and_si256(_mm256_castps_si256(a), _mm256_set1_epi32(~7)),
                                  _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    __m256i others = _mm256_xor_si256(_mm256_castps_si256(lanes), _mm256_set1_epi32(-1));
    key = _mm256_or_si256(key, others);
    __m128i least = _mm_min_epu32(_mm256_castsi256_si128(key), _mm256_extracti128_si256(key, 1));
    least = _mm_min_epu32(least, _mm_shuffle_epi32(least, 0x4e));
    least = _mm_min_epu32(least, _mm_shuffle_epi32(least, 0xb1));
    return (unsigned)_mm_cvtsi128_si32(least) & 7;
}

static inline void f8_compress(float *to_floats, f8 floats, uint32_t *to_numbers,
                               const uint32_t *numbers, unsigned lanes) {
    uint64_t bytes = _pdep_u64(lanes, 0x0101010101010101u) * 0xff;
    uint64_t order = _pext_u64(0x0706050403020100u, bytes);
    __m256i index = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)order));
    _mm256_storeu_ps(to_floats, _mm256_permutevar8x32_ps(floats, index));
    __m256i from = _mm256_loadu_si256((const __m256i *)(const void *)numbers);
    _mm256_storeu_si256((__m256i *)(void *)to_numbers, _mm256_permutevar8x32_epi32(from, index));
}

#endif
