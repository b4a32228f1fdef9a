/* Eight floats at once, for whichever instruction set the including file is compiled for. Every
 * operation is the IEEE one lane by lane, so that all three give the same bits:
 *   - f8_min(a, b) is a < b ? a : b and f8_max(a, b) is a > b ? a : b: on NaN, b (MINPS, MAXPS);
 *   - comparisons are false on NaN;
 *   - no fused or approximate operations.
 *   - f8_select takes a where the sign is +, b where it is - (also of 0);
 *   - f8_blend takes b in the given lanes, a in the others;
 *   - f8_least: which of the given lanes holds the least number from 0 up, by its upper 29 bits, the first of
 *     equals; without any: 7;
 *   - f8_compress writes the given lanes of both, closed up; eight are written, whatever is in the rest.
 * An m8 is a mask of eight lanes; m8_bits gives it as bits, lane 0 lowest. */
#ifndef SNELL_SIMD_FLOAT8_H
#define SNELL_SIMD_FLOAT8_H

#include <stddef.h>

#if defined(__AVX512VL__) && defined(__AVX512DQ__)
#define SIMD_AVX512 1
#include "simd/float8_avx512.h"
#elif defined(__AVX2__)
#define SIMD_AVX512 0
#include "simd/float8_avx2.h"
#else
#define SIMD_AVX512 0
#include "simd/float8_scalar.h"
#endif

/* Row i of eight floats stands at from + i * from_step; column i goes to to + i * to_step. */
static inline void f8_transpose(const float *from, size_t from_step, float *to, size_t to_step) {
#ifdef __AVX2__
    __m256 a[8], b[8];
    for (size_t i = 0; i < 4; i++) { /* halves of rows i and i + 4 side by side */
        __m256 low = _mm256_castps128_ps256(_mm_loadu_ps(from + i * from_step));
        __m256 high = _mm256_castps128_ps256(_mm_loadu_ps(from + i * from_step + 4));
        a[i] = _mm256_insertf128_ps(low, _mm_loadu_ps(from + (i + 4) * from_step), 1);
        a[i + 4] = _mm256_insertf128_ps(high, _mm_loadu_ps(from + (i + 4) * from_step + 4), 1);
    }
    for (size_t i = 0; i < 8; i += 4) { /* each a transposition of 4 by 4 */
        b[i] = _mm256_unpacklo_ps(a[i], a[i + 1]);
        b[i + 1] = _mm256_unpackhi_ps(a[i], a[i + 1]);
        b[i + 2] = _mm256_unpacklo_ps(a[i + 2], a[i + 3]);
        b[i + 3] = _mm256_unpackhi_ps(a[i + 2], a[i + 3]);
        _mm256_storeu_ps(to + i * to_step, _mm256_shuffle_ps(b[i], b[i + 2], 0x44));
        _mm256_storeu_ps(to + (i + 1) * to_step, _mm256_shuffle_ps(b[i], b[i + 2], 0xee));
        _mm256_storeu_ps(to + (i + 2) * to_step, _mm256_shuffle_ps(b[i + 1], b[i + 3], 0x44));
        _mm256_storeu_ps(to + (i + 3) * to_step, _mm256_shuffle_ps(b[i + 1], b[i + 3], 0xee));
    }
#else
    for (size_t i = 0; i < 8; i++)
        for (size_t k = 0; k < 8; k++) to[k * to_step + i] = from[i * from_step + k];
#endif
}

#endif
