/* A closed mesh as a part of solids: all crossings of a line with it. */
#ifndef SNELL_ACCEL_SOLID_MESH_H
#define SNELL_ACCEL_SOLID_MESH_H

#include "accel/layout.h"
#include "geometry/closure.h"

/* A line may meet so many stretches of one mesh, and of one solid. */
enum { SOLID_SPANS_MAX = 1024 };
enum { SOLID_MESH_LEAF = 4 }; /* triangles */

typedef struct solid_mesh {
    const mesh_desc *mesh; /* borrowed */
    mesh_closure closure;  /* not MESH_OPEN */
    bvh_tree tree;
    double reach; /* the largest coordinate's size */
} solid_mesh;

/* Of a mesh that is closed. */
snell_status solid_mesh_create(const mesh_desc *mesh, thread_pool *pool, solid_mesh **out);
void solid_mesh_destroy(solid_mesh *m);

/* The stretches of the line o + t d inside, as `spans` of a primitive_type gives them; `primitive`
 * is the triangle's number. */
int solid_mesh_spans(const solid_mesh *m, dvec3 o, dvec3 d, span *out, int capacity);

#endif
