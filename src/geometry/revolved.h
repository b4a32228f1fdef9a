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

/* The same for a description that `revolved_of(desc)` makes a revolved of: the functions, and the
 * members of its primitive_type that name them. */
#define REVOLVED_FUNCTIONS(revolved_of)                                                            \
    static bounds3 bounds(const void *desc) {                                                      \
        revolved shape = revolved_of(desc);                                                        \
        return revolved_bounds(&shape);                                                            \
    }                                                                                              \
    static bool intersect(const void *desc, const local_ray *beam, hit *found) {                   \
        revolved shape = revolved_of(desc);                                                        \
        return revolved_intersect(&shape, beam, found);                                            \
    }                                                                                              \
    static void fill_surface(const void *desc, const local_ray *beam, const hit *found,            \
                             surface *out) {                                                       \
        revolved shape = revolved_of(desc);                                                        \
        revolved_surface(&shape, beam, found, out);                                                \
    }                                                                                              \
    static void parametrise(const void *desc, surface *s) {                                        \
        revolved shape = revolved_of(desc);                                                        \
        revolved_parametrise(&shape, s);                                                           \
    }                                                                                              \
    static int side(const void *desc, dvec3 p) {                                                   \
        revolved shape = revolved_of(desc);                                                        \
        return revolved_side(&shape, p);                                                           \
    }                                                                                              \
    static int spans(const void *desc, const local_ray *beam, span *out, int capacity) {           \
        revolved shape = revolved_of(desc);                                                        \
        return revolved_spans(&shape, beam, out, capacity);                                        \
    }                                                                                              \
    static double area(const void *desc, uint32_t primitive) {                                     \
        (void)primitive;                                                                           \
        revolved shape = revolved_of(desc);                                                        \
        return revolved_area(&shape);                                                              \
    }                                                                                              \
    static void sample_area(const void *desc, uint32_t primitive, double u, double v,              \
                            surface *out) {                                                        \
        (void)primitive;                                                                           \
        revolved shape = revolved_of(desc);                                                        \
        revolved_sample_area(&shape, u, v, out);                                                   \
    }
#define REVOLVED_MEMBERS                                                                           \
    .bounds = bounds, .intersect = intersect, .surface = fill_surface, .parametrise = parametrise, \
    .side = side, .spans = spans, .area = area, .sample_area = sample_area

#endif
