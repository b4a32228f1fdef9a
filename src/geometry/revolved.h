/* A polyline turned about an axis: what cylinder, cone and lathe share. Every piece of the line sweeps
 * a frustum, a tube, or a flat ring. */
#ifndef SNELL_GEOMETRY_REVOLVED_H
#define SNELL_GEOMETRY_REVOLVED_H

#include "geometry/surface.h"

/* A point of the line: its distance from the axis, >= 0, and its height along it, in metres. */
typedef struct profile_point {
    double r, y;
} profile_point;

/* Normals point away from the enclosed side if the line runs up the axis at its outer parts
 * (the area it sweeps about the axis, the integral of r dy, is positive), else they are turned. */
typedef struct revolved {
    dvec3 origin, x, y, z;     /* an orthonormal right-handed frame; the axis is y */
    const snell_vec2 *profile; /* the line; NULL: it is `own`, with caps of their own coordinates */
    double base; /* the origin's height in `profile`: what lies far up the axis loses no digits */
    profile_point own[4];
    size_t count; /* points, at least 2 */
    bool capped;  /* of `own`: its first and last piece are caps */
    bool closed;  /* it encloses a volume */
    bool smooth;  /* shading normals are blended over joints of less than 40 degrees */
} revolved;

/* A frustum between two points with a radius at each. */
revolved revolved_frustum(vec3 from, vec3 to, double radius, double radius_to, bool capped);

/* The members of a primitive_type. Between `surface` (or sample_area) and `parametrise`, the
 * surface's u is the number of the piece and v the place along it, 0..1. */
bounds3 revolved_bounds(const revolved *shape);
bool revolved_intersect(const revolved *shape, const local_ray *beam, hit *found);
void revolved_surface(const revolved *shape, const local_ray *beam, const hit *found, surface *out);
void revolved_parametrise(const revolved *shape, surface *s);
int revolved_side(const revolved *shape, dvec3 p);
int revolved_spans(const revolved *shape, const local_ray *beam, span *out, int capacity);
double revolved_area(const revolved *shape);
void revolved_sample_area(const revolved *shape, double u, double v, surface *out);

#endif
