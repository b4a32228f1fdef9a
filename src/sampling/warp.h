/* From the unit square to where samples are wanted. Every warp keeps what is near together, so that
 * stratified points stay stratified. Doubles; elementary functions of maths/functions.h only. */
#ifndef SNELL_SAMPLING_WARP_H
#define SNELL_SAMPLING_WARP_H

#include "maths/vec.h"
#include "sampling/sampling.h"

/* The unit disk, uniformly (pdf 1/pi): rings of the square become rings of the disk, (.5, .5) its
 * centre (Shirley and Chiu, A Low Distortion Map Between Disk and Square, JGT 2(3), 1997). */
sample2 warp_disk(sample2 s);
/* The same by its distance from the centre, 0..1, and the angle's cosine and sine: radius^2 is
 * uniform in [0,1), and rings take it from there. */
typedef struct warp_polar {
    double radius, cosine, sine;
} warp_polar;
warp_polar warp_disk_polar(sample2 s);
/* The regular polygon with 3 or more `sides` whose corners lie on the unit circle, the first of them
 * at `rotation` radians from the x axis; uniformly: pdf 2 / (sides sin(2 pi / sides)). */
sample2 warp_polygon(sample2 s, unsigned sides, double rotation);
/* The upper hemisphere about +z; pdf cos(theta) / pi per solid angle (Malley's method: the disk,
 * raised). */
dvec3 warp_cosine_hemisphere(sample2 s);
/* The cone about +z, uniformly, (.5, .5) its axis: pdf 1 / (2 pi (1 - cos)) per solid angle. Takes 1 - cos of its half
 * angle, in (0, 2], since for a small cone the cosine itself has lost its digits; 2 is the sphere. */
dvec3 warp_cone(sample2 s, double one_minus_cosine);
/* Barycentric weights of a triangle's second and third vertex, uniformly over its area (Heitz, A
 * Low-Distortion Map Between Triangle and Square, 2019). */
sample2 warp_triangle(sample2 s);
/* [-1, 1] with the density 1 - |x|: the inverse of its distribution. */
double warp_tent(double s);

/* A density over [0, 1) that is constant in each of `count` equal cells. */
typedef struct distribution1 {
    double *cdf; /* count + 1 values from 0 to 1; owned */
    uint32_t count;
} distribution1;

/* Weights >= 0 and finite, count >= 1; all 0 counts as all equal. false: no memory. */
bool distribution1_build(const double *weights, uint32_t count, distribution1 *out);
void distribution1_free(distribution1 *d);
/* The point for s in [0, 1): the inverse of the distribution. *cell: the cell it is in, whose weight
 * is never 0; *pdf: the density there. Both may be NULL. */
double distribution1_sample(const distribution1 *d, double s, uint32_t *cell, double *pdf);
/* The same in the caller's memory: fills cdf, of count + 1 values; false: all weights are 0 (or their
 * sum is infinite), and count as equal. */
bool distribution1_fill(const double *weights, uint32_t count, double *cdf);
/* The cell for s, and where in it, [0, 1]. */
uint32_t distribution1_find(const double *cdf, uint32_t count, double s, double *within);

#endif
