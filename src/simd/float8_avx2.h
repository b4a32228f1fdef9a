/* float8.h for AVX2: a mask is a register whose lanes are all ones or all zeros. */
#ifndef SNELL_SIMD_FLOAT8_AVX2_H
#define SNELL_SIMD_FLOAT8_AVX2_H

#include <immintrin.h>

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

#endif
