/* Four floats at once, as every processor has them: for boxes, whose three axes are lanes 0 to 2.
 * The rules are those of float8.h, so that SSE2 and plain C give the same bits. */
#ifndef SNELL_SIMD_FLOAT4_H
#define SNELL_SIMD_FLOAT4_H

#include <stdint.h>

#if SNELL_HAS_SIMD && defined(__SSE2__)
#include <emmintrin.h>

typedef __m128 f4;

static inline f4 f4_load(const float *p) { return _mm_loadu_ps(p); }
static inline void f4_store(float *p, f4 a) { _mm_storeu_ps(p, a); }
/* p[0], p[1], p[2] and 0; no more is read. */
static inline f4 f4_load3(const float *p) {
    __m128i low = _mm_loadl_epi64((const void *)p);
    return _mm_movelh_ps(_mm_castsi128_ps(low), _mm_load_ss(p + 2));
}
static inline f4 f4_set(float x) { return _mm_set1_ps(x); }
static inline f4 f4_add(f4 a, f4 b) { return _mm_add_ps(a, b); }
static inline f4 f4_sub(f4 a, f4 b) { return _mm_sub_ps(a, b); }
static inline f4 f4_mul(f4 a, f4 b) { return _mm_mul_ps(a, b); }
static inline f4 f4_min(f4 a, f4 b) { return _mm_min_ps(a, b); }
static inline f4 f4_max(f4 a, f4 b) { return _mm_max_ps(a, b); }
/* a < b ? c : d */
static inline f4 f4_select_less(f4 a, f4 b, f4 c, f4 d) {
    __m128 less = _mm_cmplt_ps(a, b);
    return _mm_or_ps(_mm_and_ps(less, c), _mm_andnot_ps(less, d));
}
/* A bit for each lane where a < b, lane 0 lowest. */
static inline unsigned f4_less_bits(f4 a, f4 b) {
    return (unsigned)_mm_movemask_ps(_mm_cmplt_ps(a, b));
}
/* Towards 0; defined where |a| < 2^31. */
static inline f4 f4_truncate(f4 a) { return _mm_cvtepi32_ps(_mm_cvttps_epi32(a)); }
/* Lanes 0 to 2 as whole numbers, towards 0; defined where 0 <= a < 2^31. */
static inline void f4_indices(f4 a, uint32_t out[3]) {
    __m128i i = _mm_cvttps_epi32(a);
    out[0] = (uint32_t)_mm_cvtsi128_si32(i);
    out[1] = (uint32_t)_mm_cvtsi128_si32(_mm_shuffle_epi32(i, 1));
    out[2] = (uint32_t)_mm_cvtsi128_si32(_mm_shuffle_epi32(i, 2));
}
static inline f4 f4_from_counts(const uint32_t *p) { /* each < 2^31 */
    return _mm_cvtepi32_ps(_mm_loadu_si128((const __m128i *)(const void *)p));
}
static inline void f4_transpose(f4 *a, f4 *b, f4 *c, f4 *d) { _MM_TRANSPOSE4_PS(*a, *b, *c, *d); }

#else
#include <string.h>

typedef struct f4 {
    float v[4];
} f4;

static inline f4 f4_load(const float *p) {
    f4 r;
    memcpy(&r, p, sizeof r);
    return r;
}
static inline void f4_store(float *p, f4 a) { memcpy(p, &a, sizeof a); }
static inline f4 f4_load3(const float *p) { return (f4){{p[0], p[1], p[2], 0}}; }
static inline f4 f4_set(float x) { return (f4){{x, x, x, x}}; }

#define FLOAT4_BINARY(name, expression)                                                            \
    static inline f4 name(f4 a, f4 b) {                                                            \
        f4 r;                                                                                      \
        for (int i = 0; i < 4; i++) r.v[i] = (expression);                                         \
        return r;                                                                                  \
    }
FLOAT4_BINARY(f4_add, a.v[i] + b.v[i])
FLOAT4_BINARY(f4_sub, a.v[i] - b.v[i])
FLOAT4_BINARY(f4_mul, a.v[i] * b.v[i])
FLOAT4_BINARY(f4_min, a.v[i] < b.v[i] ? a.v[i] : b.v[i])
FLOAT4_BINARY(f4_max, a.v[i] > b.v[i] ? a.v[i] : b.v[i])
#undef FLOAT4_BINARY

static inline f4 f4_select_less(f4 a, f4 b, f4 c, f4 d) {
    for (int i = 0; i < 4; i++) c.v[i] = a.v[i] < b.v[i] ? c.v[i] : d.v[i];
    return c;
}
static inline unsigned f4_less_bits(f4 a, f4 b) {
    unsigned bits = 0;
    for (unsigned i = 0; i < 4; i++) bits |= (unsigned)(a.v[i] < b.v[i]) << i;
    return bits;
}
static inline f4 f4_truncate(f4 a) {
    for (int i = 0; i < 4; i++) a.v[i] = (float)(int32_t)a.v[i];
    return a;
}
static inline void f4_indices(f4 a, uint32_t out[3]) {
    for (int i = 0; i < 3; i++) out[i] = (uint32_t)a.v[i];
}
static inline f4 f4_from_counts(const uint32_t *p) {
    f4 r;
    for (int i = 0; i < 4; i++) r.v[i] = (float)(int32_t)p[i];
    return r;
}
static inline void f4_transpose(f4 *a, f4 *b, f4 *c, f4 *d) {
    f4 rows[4] = {*a, *b, *c, *d}, columns[4];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) columns[j].v[i] = rows[i].v[j];
    *a = columns[0], *b = columns[1], *c = columns[2], *d = columns[3];
}

#endif
#endif
