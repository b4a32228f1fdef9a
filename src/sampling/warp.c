#include "sampling/warp.h"

#include <stdlib.h>

#include "base/memory.h"
#include "maths/functions.h"

warp_polar warp_disk_polar(sample2 s) {
    double a = 2 * s.x - 1, b = 2 * s.y - 1;
    if (a == 0 && b == 0) return (warp_polar){0, 1, 0};
    if (fabs(a) > fabs(b)) {
        double angle = PI / 4 * (b / a), sign = a < 0 ? -1 : 1;
        return (warp_polar){fabs(a), sign * fn_cos(angle), sign * fn_sin(angle)};
    }
    double angle = PI / 4 * (a / b), sign = b < 0 ? -1 : 1;
    return (warp_polar){fabs(b), sign * fn_sin(angle), sign * fn_cos(angle)};
}

sample2 warp_disk(sample2 s) {
    warp_polar p = warp_disk_polar(s);
    return (sample2){p.radius * p.cosine, p.radius * p.sine};
}

sample2 warp_triangle(sample2 s) {
    /* Each half of the square, cut by its diagonal, becomes a half of the triangle. */
    if (s.y > s.x) return (sample2){s.x / 2, s.y - s.x / 2};
    return (sample2){s.x - s.y / 2, s.y / 2};
}

sample2 warp_polygon(sample2 s, unsigned sides, double rotation) {
    double scaled = s.x * sides, side = floor(scaled);
    if (side > sides - 1) side = sides - 1;
    sample2 weights = warp_triangle((sample2){scaled - side, s.y});
    double step = 2 * PI / sides, a0 = rotation + step * side, a1 = rotation + step * (side + 1);
    return (sample2){weights.x * fn_cos(a0) + weights.y * fn_cos(a1),
                     weights.x * fn_sin(a0) + weights.y * fn_sin(a1)};
}

dvec3 warp_cosine_hemisphere(sample2 s) {
    sample2 d = warp_disk(s);
    double rest = 1 - d.x * d.x - d.y * d.y;
    return (dvec3){d.x, d.y, sqrt(rest > 0 ? rest : 0)};
}

/* Equal heights of a cap are equal areas (Archimedes), as equal squared radii of a disk are. */
dvec3 warp_cone(sample2 s, double one_minus_cosine) {
    sample2 d = warp_disk(s);
    double down = (d.x * d.x + d.y * d.y) * one_minus_cosine; /* 1 - z */
    double out = sqrt(one_minus_cosine * double_max(2 - down, 0));
    return (dvec3){d.x * out, d.y * out, 1 - down};
}

double warp_tent(double s) { return s < 0.5 ? sqrt(2 * s) - 1 : 1 - sqrt(2 - 2 * s); }

bool distribution1_fill(const double *weights, uint32_t count, double *cdf) {
    double sum = 0;
    cdf[0] = 0;
    for (uint32_t i = 0; i < count; i++) cdf[i + 1] = sum += weights[i];
    bool useful = sum > 0 && sum < INFINITY;
    for (uint32_t i = 1; i <= count; i++) cdf[i] = useful ? cdf[i] / sum : (double)i / count;
    cdf[count] = 1; /* sum / sum is 1 already; said for the reader */
    return useful;
}

uint32_t distribution1_find(const double *cdf, uint32_t count, double s, double *within) {
    /* The first cell whose end lies beyond s: it begins at or before s, so it is not empty. */
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (cdf[middle + 1] > s)
            high = middle;
        else
            low = middle + 1;
    }
    *within = (s - cdf[low]) / (cdf[low + 1] - cdf[low]);
    return low;
}

bool distribution1_build(const double *weights, uint32_t count, distribution1 *out) {
    double *cdf = memory_resize(NULL, (size_t)count + 1, sizeof *cdf);
    if (cdf == NULL) return false;
    distribution1_fill(weights, count, cdf);
    *out = (distribution1){cdf, count};
    return true;
}

void distribution1_free(distribution1 *d) {
    free(d->cdf);
    *d = (distribution1){NULL, 0};
}

double distribution1_sample(const distribution1 *d, double s, uint32_t *cell, double *pdf) {
    double within;
    uint32_t low = distribution1_find(d->cdf, d->count, s, &within);
    if (cell) *cell = low;
    if (pdf) *pdf = (d->cdf[low + 1] - d->cdf[low]) * d->count;
    double x = (low + within) / d->count;
    return x < 1 ? x : 1 - 0x1p-53;
}
