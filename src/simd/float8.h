/* Eight floats at once, for whichever instruction set the including file is compiled for. Every
 * operation is the IEEE one lane by lane, so that all three give the same bits:
 *   - f8_min(a, b) is a < b ? a : b and f8_max(a, b) is a > b ? a : b: on NaN, b (MINPS, MAXPS);
 *   - comparisons are false on NaN;
 *   - no fused or approximate operations.
 *   - f8_select takes a where the sign is +, b where it is - (also of 0);
 *   - f8_least: which of the given lanes holds the least number from 0 up, by its upper 29 bits, the first of
 *     equals; without any: 7;
 *   - f8_compress writes the given lanes of both, closed up; eight are written, whatever is in the rest.
 * An m8 is a mask of eight lanes; m8_bits gives it as bits, lane 0 lowest. */
#ifndef SNELL_SIMD_FLOAT8_H
#define SNELL_SIMD_FLOAT8_H

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

#endif
