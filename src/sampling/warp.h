/* From the unit square to other domains, keeping equal areas equal. */
#ifndef SNELL_SAMPLING_WARP_H
#define SNELL_SAMPLING_WARP_H

#include "maths/vec.h"
#include "sampling/sampling.h"

/* A point of the unit disk: its distance from the centre, 0..1, and the angle's cosine and sine. */
typedef struct warp_polar {
    double radius, cosine, sine;
} warp_polar;

/* The square to the disk, concentric squares to concentric circles: (.5, .5) to the centre, and
 * neighbours stay neighbours (Shirley and Chiu, A Low Distortion Map Between Disk and Square, 1997).
 * radius^2 is uniform in [0,1): rings and caps take it from there. */
warp_polar warp_disk(double u, double v);

/* Barycentric weights, uniform by area (Turk, Generating Random Points in Triangles, 1990). */
void warp_triangle(double u, double v, double weight[3]);

/* A direction about +Z with the density cos / pi: the disk, lifted to the hemisphere (Malley). */
dvec3 warp_cosine_hemisphere(sample2 u);
/* A direction about +Z, uniform over the cap of this height (1 - cos of its half-angle, 0..2); the
 * density is 1 / (2 pi height), and (.5, .5) is the axis. */
dvec3 warp_uniform_cone(sample2 u, double height);

#endif
