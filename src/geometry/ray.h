/* What is traced and what comes back. */
#ifndef SNELL_GEOMETRY_RAY_H
#define SNELL_GEOMETRY_RAY_H

#include "maths/vec.h"

#define NO_ID UINT32_MAX
enum { GROUP_DEPTH_MAX = 8 }; /* groups in groups of shapes */

/* Hits lie in t_min < t < t_max, in lengths of d, which need not be 1. */
typedef struct ray {
    vec3 o;
    float t_min;
    vec3 d;
    float t_max;
    float time;
    uint32_t mask;
    /* The surface the ray leaves, if that is flat: it cannot be hit again. NO_ID: none. */
    uint32_t skip_instance, skip_primitive;
    /* Walking on: only hits with (t, instance, primitive) lexicographically greater than this,
     * and in a mesh nothing that lies behind there (accel/accel.h). after_t = -INFINITY: every hit. */
    float after_t;
    uint32_t after_instance, after_primitive;
    uint32_t unused;
} ray;
_Static_assert(sizeof(ray) == 64, "a ray fills a cache line");

static inline ray ray_make(vec3 o, vec3 d, float t_min, float t_max) {
    return (ray){o, t_min, d, t_max, 0, ~0u, NO_ID, NO_ID, -INFINITY, 0, 0, 0};
}

/* How a ray's origin and direction differ from those of the picture's next sample to the right (x)
 * and down (y). */
typedef struct ray_differential {
    vec3 dox, ddx, doy, ddy;
} ray_differential;

/* miss: t = INFINITY and instance = NO_ID. u, v: barycentrics of vertices 1 and 2 of a triangle;
 * free for the primitive's own use otherwise (they come back to its surface function). */
typedef struct hit {
    float t, u, v;
    uint32_t primitive; /* within the shape: the number of the triangle or part, or 0 */
    uint32_t instance;
} hit;

#endif
