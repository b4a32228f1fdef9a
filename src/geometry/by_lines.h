/* Area and points drawn by area for shapes that have no formula for them, by lines along the three
 * axes. Through a piece dA of a surface with the normal n go lines along axis i with the density |n_i|
 * dA; and n_x^2 + n_y^2 + n_z^2 = 1. So with a weight |n_i| for every crossing the lines of the three
 * axes together find every dA as often as any other. */
#ifndef SNELL_GEOMETRY_BY_LINES_H
#define SNELL_GEOMETRY_BY_LINES_H

#include "geometry/surface.h"

/* The sum of |n_i| over the crossings of a grid of 3 * per_side^2 lines, good to about per_side^-1.5:
 * 1e-4 with 256. */
double by_lines_area(const primitive_type *type, const void *desc, int per_side);

/* For sample_area. A line along an axis crosses the shape `crossings` times at most. The first try
 * is made with u and v themselves, and near (u, v) give near points where it succeeds. */
void by_lines_sample(const primitive_type *type, const void *desc, int crossings, double u,
                     double v, surface *out);

#endif
