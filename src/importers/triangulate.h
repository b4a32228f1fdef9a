/* Polygons of files into triangles. */
#ifndef SNELL_IMPORTERS_TRIANGULATE_H
#define SNELL_IMPORTERS_TRIANGULATE_H

#include "maths/vec.h"

/* Cuts a plane, simple polygon of count >= 3 corners into count - 2 triangles, oriented as it is: a
 * fan where it is convex, else by cutting off ears. indices has room for 3 (count - 2), which are all
 * written; returns how many. What is not simple gives some triangles over its corners. */
size_t triangulate(const vec3 *corners, uint32_t count, uint32_t *indices);

#endif
