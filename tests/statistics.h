/* The statistics of tests by chance, with no state but what is given: moments of independent
 * estimates, a z-test against a known mean, chi-square, and Sidak's correction, which keeps the
 * chance that any test of a family fails by bad luck at the level asked for. Seeds are fixed, so a
 * test that passes once passes always. */
#ifndef SNELL_TESTS_STATISTICS_H
#define SNELL_TESTS_STATISTICS_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

/* ---- independent estimates ---- */

typedef struct moments { /* Welford, Technometrics 4(3), 1962 */
    double count, mean, squares;
} moments;

static inline void moments_add(moments *m, double x) {
    double before = x - m->mean;
    m->count++;
    m->mean += before / m->count;
    m->squares += before * (x - m->mean);
}

static inline double moments_variance(const moments *m) {
    return m->count > 1 ? m->squares / (m->count - 1) : INFINITY;
}
/* Of the mean. */
static inline double moments_error(const moments *m) {
    return sqrt(moments_variance(m) / m->count);
}

/* ---- distributions ---- */

/* The z that a standard normal number exceeds with the probability `tail`, 0 < tail <= 0.5. */
static inline double normal_quantile(double tail) {
    double low = 0, high = 40;
    for (int i = 0; i < 80; i++) {
        double middle = (low + high) / 2;
        if (erfc(middle / sqrt(2)) / 2 > tail)
            low = middle;
        else
            high = middle;
    }
    return high;
}

/* Student's t of so many degrees of freedom as a normal number of the same probability (Wallace,
 * Annals of Mathematical Statistics 30(4), 1959: within .2 of a percent from 5 degrees on). */
static inline double student_to_normal(double t, double freedom) {
    double z = (8 * freedom + 1) / (8 * freedom + 3) * sqrt(freedom * log1p(t * t / freedom));
    return t < 0 ? -z : z;
}

/* Q(a, x), the upper incomplete gamma function over gamma(a): a series, or a continued fraction
 * (Numerical Recipes 6.2). */
static inline double gamma_upper(double a, double x) {
    if (!(x > 0)) return 1;
    double front = exp(a * log(x) - x - lgamma(a));
    if (x < a + 1) {
        double term = 1 / a, sum = term;
        for (int i = 1; i < 100000 && term > sum * 1e-16; i++) sum += term *= x / (a + i);
        return 1 - front * sum;
    }
    double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
    for (int i = 1; i < 100000; i++) {
        double an = -i * (i - a);
        b += 2;
        d = 1 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (fabs(d * c - 1) < 1e-15) break;
    }
    return front * h;
}

/* The probability of a chi-square sum at least so large. */
static inline double chi_square_tail(double sum, double freedom) {
    return gamma_upper(freedom / 2, sum / 2);
}

/* ---- tests ---- */

/* The level of each of `count` independent tests of which none should fail with 1 - level. */
static inline double sidak(double level, double count) { return -expm1(log1p(-level) / count); }

/* Two-sided: how far is the mean of the estimates from `expected`, in standard errors? Without a
 * spread, infinitely far or not at all. */
static inline double z_score(const moments *m, double expected) {
    double off = m->mean - expected, error = moments_error(m);
    if (!(error > 0)) return off == 0 ? 0 : off > 0 ? INFINITY : -INFINITY;
    return student_to_normal(off / error, m->count - 1);
}

/* Of the means of two sets of estimates (Welch's degrees of freedom). */
static inline double z_score_pair(const moments *a, const moments *b) {
    double va = moments_variance(a) / a->count, vb = moments_variance(b) / b->count;
    double off = a->mean - b->mean, sum = va + vb;
    if (!(sum > 0)) return off == 0 ? 0 : off > 0 ? INFINITY : -INFINITY;
    double freedom = sum * sum / (va * va / (a->count - 1) + vb * vb / (b->count - 1));
    return student_to_normal(off / sqrt(sum), freedom);
}

/* Pearson's test: counts found and expected per cell, of the same sum. Cells in which fewer than 5
 * are expected are put together, in their order. Returns the probability of so bad a fit, and 0 at
 * once for a count where nothing may fall. */
static inline double chi_square_test(const double *found, const double *expected, size_t count) {
    double sum = 0, pooled_found = 0, pooled_expected = 0, freedom = -1;
    for (size_t i = 0; i < count; i++) {
        if (!(expected[i] > 0) && found[i] > 0) return 0;
        pooled_found += found[i];
        pooled_expected += expected[i];
        if (pooled_expected < 5) continue;
        double off = pooled_found - pooled_expected;
        sum += off * off / pooled_expected;
        freedom++;
        pooled_found = pooled_expected = 0;
    }
    if (pooled_expected > 0) { /* the rest; a cell that is too small only makes the test milder */
        double off = pooled_found - pooled_expected;
        sum += off * off / (pooled_expected > 5 ? pooled_expected : 5);
    }
    return freedom > 0 ? chi_square_tail(sum, freedom) : 1;
}

#endif
