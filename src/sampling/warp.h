/* From the unit square to other domains, keeping equal areas equal. */
#ifndef SNELL_SAMPLING_WARP_H
#define SNELL_SAMPLING_WARP_H

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

#endif
