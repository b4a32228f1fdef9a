/* What a sphere is, for the kernels, which test many rays at once. */
#ifndef SNELL_GEOMETRY_SPHERE_H
#define SNELL_GEOMETRY_SPHERE_H

#include "geometry/primitive.h"

#define SPHERE_FIELDS(F, T)                                                                        \
    F(T, center, VEC3, DEFAULT(0, 0, 0), ANY, "m", "the centre")                                   \
    F(T, radius, FLOAT, DEFAULT(1), POSITIVE, "m", "the radius")
DESCRIBE_STRUCT(sphere, SPHERE_FIELDS)

extern const primitive_type primitive_sphere;

#endif
