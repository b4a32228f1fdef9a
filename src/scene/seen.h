/* Shapes that shine but have no area to draw points from: curves, patches, fields, solids, shapes of the
 * caller. A direction is drawn from the cone that holds a ball around the shape, uniformly, and a ray finds
 * the point that is seen that way, if any: the density is the cone's, wherever the shape is in it. */
#ifndef SNELL_SCENE_SEEN_H
#define SNELL_SCENE_SEEN_H

#include "scene/lights.h"

/* The ball, in the shape's own space. */
void seen_measure(surface_light *l, const scene_instance *at);
/* May such a shape be sampled so? Not one that a path could go on through at random. */
bool seen_can_be_sampled(const scene *s, const scene_instance *at);

/* The light of `l`, an instance posed as `at`, that one ray from a point meets. false: none. */
bool seen_sample(const scene *s, const surface_light *l, const scene_instance *at,
                 const shade_point *from, float time, sample2 u, shade_point *found, double *pdf);
/* The density, per sr, of every direction in which it can be seen from `from`. */
double seen_pdf(const surface_light *l, const scene_instance *at, dvec3 from);

#endif
