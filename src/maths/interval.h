/* Intervals that enclose what real arithmetic would give: every bound is moved outwards by at least
 * half an ulp, which costs less than switching the rounding mode and is the same on every machine.
 * An operation that is not defined everywhere gives the bounds of where it is; expression.c keeps
 * account of that. Moore, Interval Analysis, 1966. */
#ifndef SNELL_MATHS_INTERVAL_H
#define SNELL_MATHS_INTERVAL_H

#include <math.h>

#include "maths/vec.h"

typedef struct interval {
    double low, high; /* low <= high; may be infinite, never NaN */
} interval;

static inline interval interval_entire(void) { return (interval){-INFINITY, INFINITY}; }
static inline interval interval_point(double x) { return (interval){x, x}; }

/* At least an ulp away, so beyond the true result of one correctly rounded operation. */
static inline double interval_down(double x) { return x - (fabs(x) * 0x1p-52 + 0x1p-1022); }
static inline double interval_up(double x) { return x + (fabs(x) * 0x1p-52 + 0x1p-1022); }

/* An overflow or inf - inf is a bound that says nothing. */
static inline interval interval_outward(double low, double high) {
    low = interval_down(low);
    high = interval_up(high);
    return (interval){low < INFINITY ? low : -INFINITY, high > -INFINITY ? high : INFINITY};
}
/* For functions that are right to `ulps` ulps. */
static inline interval interval_wider(double low, double high, double ulps) {
    return interval_outward(low - ulps * 0x1p-52 * fabs(low), high + ulps * 0x1p-52 * fabs(high));
}

static inline bool interval_contains(interval a, double x) { return a.low <= x && x <= a.high; }
static inline interval interval_hull(interval a, interval b) {
    return (interval){double_min(a.low, b.low), double_max(a.high, b.high)};
}
/* Of two that enclose the same. */
static inline interval interval_both(interval a, interval b) {
    interval both = {double_max(a.low, b.low), double_min(a.high, b.high)};
    return both.low <= both.high ? both : a;
}
static inline double interval_magnitude(interval a) {
    return double_max(fabs(a.low), fabs(a.high));
}

static inline interval interval_negate(interval a) { return (interval){-a.high, -a.low}; }
static inline interval interval_add(interval a, interval b) {
    return interval_outward(a.low + b.low, a.high + b.high);
}
static inline interval interval_sub(interval a, interval b) {
    return interval_outward(a.low - b.high, a.high - b.low);
}
/* A bound of 0 times an infinite one is 0: the infinite one is never reached. */
static inline double interval_product(double a, double b) { return a == 0 || b == 0 ? 0 : a * b; }
static inline interval interval_mul(interval a, interval b) {
    double w = interval_product(a.low, b.low), x = interval_product(a.low, b.high),
           y = interval_product(a.high, b.low), z = interval_product(a.high, b.high);
    return interval_outward(double_min(double_min(w, x), double_min(y, z)),
                            double_max(double_max(w, x), double_max(y, z)));
}
static inline interval interval_scale(interval a, double s) {
    return interval_mul(a, interval_point(s));
}
/* Everything where b may be 0. */
static inline interval interval_div(interval a, interval b) {
    if (!(b.low > 0 || b.high < 0)) return interval_entire();
    return interval_mul(a, interval_outward(1 / b.high, 1 / b.low));
}
static inline interval interval_abs(interval a) {
    if (a.low >= 0) return a;
    if (a.high <= 0) return interval_negate(a);
    return (interval){0, interval_magnitude(a)};
}
static inline interval interval_square(interval a) {
    a = interval_abs(a);
    interval square = interval_outward(a.low * a.low, a.high * a.high);
    return (interval){double_max(square.low, 0), square.high};
}
/* Of what is not negative in a; 0 if nothing is. */
static inline interval interval_sqrt(interval a) {
    interval root = interval_outward(sqrt(double_max(a.low, 0)), sqrt(double_max(a.high, 0)));
    return (interval){double_max(root.low, 0), root.high};
}
double integer_power(double x, int power);              /* by squaring; power >= 0 */
interval interval_integer_power(interval a, int power); /* power >= 1 */
interval interval_sin(interval a);
interval interval_cos(interval a);
interval interval_atan2(interval y, interval x);

#endif
