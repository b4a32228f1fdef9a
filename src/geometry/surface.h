/* From a hit to the next ray: where it may start so that it cannot meet the surface it leaves. */
#ifndef SNELL_GEOMETRY_SURFACE_H
#define SNELL_GEOMETRY_SURFACE_H

#include "geometry/primitive.h"

/* Half the spacing of floats near 1, and of doubles: the largest relative error of one rounding. */
#define FLOAT_EPSILON 0x1p-24
#define DOUBLE_EPSILON 0x1p-53

/* The origin of a ray that leaves `s` (in the space that the ray is traced in) on the side that its
 * direction points to: side > 0 along n, otherwise against it. side is dot(n, d) or just its sign.
 *
 * The true point is p + side * error * n, in double. Rounding it to float would move it by up to
 * half an ulp per coordinate, back towards the surface at worst; so every coordinate is rounded in
 * the direction in which n (times side) points, and strictly beyond p. Then each coordinate adds a
 * non-negative amount to the distance along n: dot(o - p, n) * side >= error holds for the float
 * origin itself, without a second margin for its rounding. (After Waechter and Binder, A Fast and
 * Robust Method for Avoiding Self-Intersection, Ray Tracing Gems 2019, and Physically Based
 * Rendering 3.9.5.)
 *
 * The tangential shift s of that rounding does no harm outside of a convex shape: the half-space
 * above the tangent plane at p has nothing of it, and the ray stays there. Inside, where the surface
 * bends towards the origin, the shift takes s^2 curvature / 2 of the distance: with p = (10000, 0, 0)
 * and n = (0, 1, 0) that can be more than the step along n. A shape with a curvature has it in its
 * error (surface_shift_error). */
vec3 surface_offset_origin(const surface *s, double side);
/* The same from the parts of `s` that it looks at. */
vec3 surface_offset_point(dvec3 p, dvec3 n, double error, double side);

/* Brings a surface from the shape's own space to the world; all but dpdu, dpdv.
 *
 * Rays are brought to the shape by the float matrix to_local, which is not exactly the inverse of
 * to_world; what they see in the world is the shape under the inverse of to_local. So p is
 * corrected by one Newton step until to_local maps it to the local point (up to double rounding;
 * what is left is measured and added to the error). The kernel rounds the local origin to float:
 * half an ulp of every local coordinate, along the local normal sum |n_i| ulp(p_i) / 2. A distance
 * e along the local normal is e / |N| along the world normal, with N = transform_normal(to_local,
 * n). */
void surface_to_world(surface *s, const transform *to_world, const transform *to_local);
static inline void surface_tangents_to_world(surface *s, const transform *to_world) {
    s->dpdu = transform_vector(to_world, s->dpdu);
    s->dpdv = transform_vector(to_world, s->dpdv);
}

/* What shapes share: is t, rounded to float, inside the ray's range? Writes the float. */
static inline bool surface_accept(const local_ray *beam, double t, float *out) {
    float rounded = (float)t;
    *out = rounded;
    return rounded > beam->t_min && rounded < beam->t_max;
}

/* For `spans`: adds a stretch to the first `count` of `out`, unless it has no length or `count` is
 * beyond the capacity already. Returns the new count. */
static inline int surface_add_span(span *out, int count, int capacity, surface_crossing enter,
                                   surface_crossing leave) {
    if (!(enter.t < leave.t) || count > capacity) return count;
    if (count < capacity) out[count] = (span){enter, leave};
    return count + 1;
}

/* What the rounding of an origin near p (the directed one, up to an ulp per coordinate, and once more
 * for that of the same origin in another space) may take from the distance to a curved surface.
 * Lengths of p times the root of scale_squared are those of the curvature and of the result. */
static inline double surface_shift_error_scaled(dvec3 p, double curvature, double scale_squared) {
    double square = FLOAT_EPSILON * FLOAT_EPSILON * dvec3_dot(p, p), bend = 4 * square * curvature;
    double bent = scale_squared * bend, limit = 16 * square * scale_squared;
    /* At a tip the shift is longer than the radius: it cannot take more than its own length. */
    return bent * bent <= limit ? bent : sqrt(limit);
}
static inline double surface_shift_error(dvec3 p, double curvature) {
    return surface_shift_error_scaled(p, curvature, 1);
}

/* u, v, dpdu and dpdv of a globe of this radius at its unit normal n: longitude and latitude about
 * +Y, seen from outside: u grows to the right, 0.5 faces +Z, the seam faces -Z; v is 0 at the south
 * pole (-Y) and 1 at the north. */
void surface_globe(surface *s, dvec3 n, double radius);

/* A unit vector in two floats, which a hit may carry in u and v: it is projected onto an octahedron,
 * whose lower half is folded outwards (Cigolle et al., A Survey of Efficient Representations for
 * Independent Unit Vectors, JCGT 3(2), 2014). */
void surface_fold(dvec3 n, float *u, float *v);
dvec3 surface_unfold(float u, float v);
/* The first of two roots that is in the ray's range, with its folded unit vector. */
bool surface_accept_either(const local_ray *beam, const double t[2], const dvec3 at[2], hit *found);

/* The error of a box whose `min` is not below its `max`. */
snell_status surface_check_box(const char *type, vec3 min, vec3 max);

/* A surface with everything at its neutral value. One field after the other: a compound literal is
 * built on the stack and copied in wider pieces than it was written in, which stalls. */
static inline surface surface_make(dvec3 p, dvec3 n, double error) {
    surface s;
    s.p = p;
    s.error = error;
    s.curvature = 0;
    s.n = n;
    s.ns = n;
    s.u = s.v = 0;
    s.dpdu = (dvec3){0, 0, 0};
    s.dpdv = (dvec3){0, 0, 0};
    s.tint = (dvec3){1, 1, 1};
    s.alpha = 1;
    s.material_slot = 0;
    return s;
}

#endif
