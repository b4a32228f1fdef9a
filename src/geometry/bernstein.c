#include "geometry/bernstein.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "maths/vec.h"

enum { COUNT_MAX = BERNSTEIN_DEGREE_MAX + 1, DEPTH_MAX = 40, STEPS_MAX = 80 };

static const double choose[COUNT_MAX][COUNT_MAX] = {
    {1},
    {1, 1},
    {1, 2, 1},
    {1, 3, 3, 1},
    {1, 4, 6, 4, 1},
    {1, 5, 10, 10, 5, 1},
    {1, 6, 15, 20, 15, 6, 1},
    {1, 7, 21, 35, 35, 21, 7, 1},
    {1, 8, 28, 56, 70, 56, 28, 8, 1},
    {1, 9, 36, 84, 126, 126, 84, 36, 9, 1},
    {1, 10, 45, 120, 210, 252, 210, 120, 45, 10, 1},
};

/* Horner's rule in s / (1 - s), or its reciprocal where that is not above 1: the sum has the terms of
 * the Bernstein form, so nothing cancels that does not cancel there, in n steps instead of de
 * Casteljau's n^2 / 2 (Schumaker and Volk, Efficient evaluation of multivariate polynomials, 1986). */
static double sum(const double *c, const double *weight, int n, double s) {
    bool mirrored = s > 0.5;
    double other = 1 - s, ratio = mirrored ? other / s : s / other, base = mirrored ? s : other;
    double value = mirrored ? c[0] * weight[0] : c[n] * weight[n], power = 1;
    for (int i = 1; i <= n; i++) {
        int at = mirrored ? i : n - i;
        value = value * ratio + c[at] * weight[at];
        power *= base;
    }
    return value * power;
}

double bernstein_value(const double *c, int n, double s, double *slope) {
    if (slope) {
        double change[COUNT_MAX];
        bernstein_derivative(c, n, change);
        *slope = n > 0 ? sum(change, choose[n - 1], n - 1, s) : 0;
    }
    return sum(c, choose[n], n, s);
}

void bernstein_multiply(const double *a, int n, const double *b, int m, double *out) {
    for (int k = 0; k <= n + m; k++) out[k] = 0;
    for (int i = 0; i <= n; i++)
        for (int j = 0; j <= m; j++) out[i + j] += choose[n][i] * choose[m][j] * (a[i] * b[j]);
    for (int k = 0; k <= n + m; k++) out[k] /= choose[n + m][k];
}

void bernstein_derivative(const double *c, int n, double *out) {
    for (int i = 0; i < n; i++) out[i] = n * (c[i + 1] - c[i]);
}

/* The coefficients over [0, s] and over [s, 1]. */
static void split(const double *c, int n, double s, double *left, double *right) {
    double a[COUNT_MAX], other = 1 - s;
    memcpy(a, c, (size_t)(n + 1) * sizeof *a);
    for (int k = n; k >= 0; k--) {
        left[n - k] = a[0];
        right[k] = a[k];
        for (int i = 0; i < k; i++) a[i] = other * a[i] + s * a[i + 1];
    }
}

void bernstein_restrict(double *c, int n, double low, double high) {
    double unused[COUNT_MAX], part[COUNT_MAX];
    if (high < 1) {
        split(c, n, high, part, unused);
        memcpy(c, part, (size_t)(n + 1) * sizeof *c);
        low /= high;
    }
    if (low > 0) {
        split(c, n, low, unused, part);
        memcpy(c, part, (size_t)(n + 1) * sizeof *c);
    }
}

typedef struct search {
    int degree;
    double noise; /* what is not larger is 0 */
    double *roots;
    int count, capacity;
} search;

static void add_root(search *s, double root) {
    if (s->count < s->capacity) s->roots[s->count++] = root;
}

/* The only root of c: Newton's method, or halving where that would leave the bracket or not shrink it
 * by half. A short step of Newton's leaves about its square. */
static double refine(const double *c, int n, bool rises) {
    double low = 0, high = 1, t = c[0] / (c[0] - c[n]), before = 1;
    if (!(t > 0x1p-10 && t < 1 - 0x1p-10)) t = 0.5;
    for (int i = 0; i < STEPS_MAX; i++) {
        double slope, y = bernstein_value(c, n, t, &slope);
        if (y == 0) return t;
        if ((y > 0) == rises)
            high = t;
        else
            low = t;
        double step = y / slope, next = t - step;
        if (next > low && next < high && fabs(step) < 0x1p-20) return next;
        if (!(next > low && next < high) || !(2 * fabs(step) < before)) {
            next = (low + high) / 2;
            step = (high - low) / 2;
        }
        if (next == t || fabs(step) < 0x1p-54) return next;
        before = fabs(step);
        t = next;
    }
    return t;
}

/* How often the sign changes; *rises: the last one is positive. */
static int sign_changes(const search *s, const double *c, bool *rises) {
    int changes = 0, sign = 0;
    for (int i = 0; i <= s->degree; i++) {
        if (fabs(c[i]) <= s->noise) continue;
        int here = c[i] > 0 ? 1 : -1;
        changes += sign != 0 && here != sign;
        sign = here;
    }
    *rises = sign > 0;
    return changes;
}

/* The recursion ends: depth is bounded, and where roots are too close to be told apart there is one. */
static void find(search *s, const double *c, double low, double width, int depth) {
    bool rises;
    int changes = sign_changes(s, c, &rises);
    if (changes == 0) return;
    if (changes == 1) {
        add_root(s, low + width * refine(c, s->degree, rises));
        return;
    }
    if (depth == DEPTH_MAX) {
        add_root(s, low + width / 2);
        return;
    }
    double left[COUNT_MAX], right[COUNT_MAX];
    split(c, s->degree, 0.5, left, right);
    find(s, left, low, width / 2, depth + 1);
    if (fabs(right[0]) <= s->noise) add_root(s, low + width / 2);
    find(s, right, low + width / 2, width / 2, depth + 1);
}

int bernstein_roots(const double *c, int n, double *roots, int capacity) {
    search s = {.degree = n, .roots = roots, .capacity = capacity};
    double largest = 0;
    for (int i = 0; i <= n; i++) largest = double_max(largest, fabs(c[i]));
    s.noise = 0x1p-48 * largest;
    if (!(largest <= 0x1p1000)) return 0; /* not finite */
    find(&s, c, 0, 1, 0);
    return s.count;
}
