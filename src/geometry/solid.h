/* A solid's description: closed shapes put together by set operations. What rays meet is compiled
 * from it (scene/solids.h, accel/solid.h). */
#ifndef SNELL_GEOMETRY_SOLID_H
#define SNELL_GEOMETRY_SOLID_H

#include "geometry/primitive.h"

#define SOLID_FIELDS(F, T)                                                                         \
    F(T, operation, CHOICE, DEFAULT(0), CHOICES("union|intersection|difference"), "",              \
      "all that any has, what all have, or the first less all others")                             \
    F(T, shapes, SHAPES, NO_DEFAULT, REQUIRED, "", "closed shapes, planes as half-spaces, solids") \
    F(T, transforms, TRANSFORMS, NO_DEFAULT, ANY, "",                                              \
      "one per shape, to the solid's space; or none")                                              \
    F(T, materials, MATERIALS, NO_DEFAULT, OR_NONE, "",                                            \
      "one per shape, or none; a shape without has the solid's own")
DESCRIBE_STRUCT(solid, SOLID_FIELDS)

enum { SOLID_UNION, SOLID_INTERSECTION, SOLID_DIFFERENCE };

/* Limits: shapes in one solid, counted through the solids in it, and how deep those nest. */
enum { SOLID_PARTS_MAX = 1024, SOLID_DEPTH_MAX = 256 };

/* Only a description: it has no functions for rays. */
extern const primitive_type primitive_solid;

#endif
