/* Ray differentials (Igehy, Tracing Ray Differentials, SIGGRAPH 1999): how a ray differs from that
 * of the picture's next sample. They start at the camera and go through mirrors and glass; a ray
 * without them sees textures as points.
 *
 * Approximated: the next sample's ray meets the same surface, hits the tangent plane, and sees the
 * normal turn as the shape's does (on shapes that bend differently in two directions as in the one
 * that bends most; what normal maps and bump add is left out). */
#ifndef SNELL_INTEGRATORS_DIFFERENTIAL_H
#define SNELL_INTEGRATORS_DIFFERENTIAL_H

#include "integrators/integrator.h"

/* By finite differences, so that any camera has them: the same sample of lens and time, one pixel
 * over the root of the samples that share the pixel further. */
void differential_of_camera(const wave_settings *s, uint32_t sharing, const camera_sample *at,
                            path_ray *r);
/* child: the ray that r sends from p by reflection about n, or by refraction from a medium of ior eta
 * times that beyond; NULL: nothing to do. */
void differential_of_mirror(const path_ray *r, const shade_point *p, dvec3 n, path_ray *child);
void differential_of_interface(const path_ray *r, const shade_point *p, double eta,
                               path_ray *child);

#endif
