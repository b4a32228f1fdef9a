#include "sampling/filter.h"

#include "base/memory.h"
#include "maths/functions.h"

#include <stdlib.h>

enum { CELLS = 1024 };

/* Each shape over [-1, 1], of its radius; any scale. NULL: has its own inverse. */

/* sigma = radius / 3, cut off there: sigma is 1/2 pixel where the radius is its own. */
static double gaussian(double x) { return fn_exp(-4.5 * x * x); }

/* The four-term window (Harris, On the Use of Windows for Harmonic Analysis, Proc. IEEE 66(1), 1978). */
static double blackman_harris(double x) {
    return 0.35875 + 0.48829 * fn_cos(PI * x) + 0.14128 * fn_cos(2 * PI * x) +
           0.01168 * fn_cos(3 * PI * x);
}

static const struct {
    double radius; /* pixels */
    double (*shape)(double x);
} filters[] = {{0.5, NULL}, {1, NULL}, {1.5, gaussian}, {1.5, blackman_harris}};

bool pixel_filter_create(int kind, double radius, pixel_filter *out) {
    *out = (pixel_filter){kind, radius > 0 ? radius : filters[kind].radius, {NULL, 0}};
    if (filters[kind].shape == NULL) return true;
    double *weights = memory_resize(NULL, CELLS, sizeof *weights);
    if (weights == NULL) return false;
    for (uint32_t i = 0; i < CELLS; i++) {
        weights[i] = filters[kind].shape((2 * i + 1.0) / CELLS - 1);
        if (!(weights[i] > 0)) weights[i] = 0;
    }
    bool built = distribution1_build(weights, CELLS, &out->table);
    free(weights);
    return built;
}

void pixel_filter_free(pixel_filter *f) { distribution1_free(&f->table); }

double pixel_filter_offset(const pixel_filter *f, double s) {
    double x = 2 * s - 1;
    if (f->table.cdf)
        x = 2 * distribution1_sample(&f->table, s, NULL, NULL) - 1;
    else if (f->kind == 1)
        x = warp_tent(s);
    return f->radius * x;
}
