/* Does a mesh enclose something? */
#ifndef SNELL_GEOMETRY_CLOSURE_H
#define SNELL_GEOMETRY_CLOSURE_H

#include "base/error.h"
#include "geometry/mesh.h"

typedef enum mesh_closure {
    MESH_OPEN,
    /* At every edge as many triangles run one way along it as the other: a line enters as often as
     * it leaves, so inside is where it has entered more often than left, or the reverse. */
    MESH_ORIENTED,
    /* At every edge an even number of triangles meets, some wound the wrong way: inside is what an
     * odd number of crossings leads to. */
    MESH_PAIRED
} mesh_closure;

/* Vertices at one place count as one. Of an open mesh, edge[0] and edge[1] are the ends of an edge
 * with an odd number of triangles. Fails only for lack of memory. */
snell_status mesh_find_closure(const mesh_desc *mesh, mesh_closure *out, vec3 edge[2]);

#endif
