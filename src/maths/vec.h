/* Vectors, transforms and bounds. vec3 (float) is what is stored and traced; dvec3 (double) is what
 * shading and surface data are computed in. Minima and maxima are spelt a < b ? a : b: on NaN the
 * second wins, in C and in SIMD alike. Nothing here calls libm except sqrt and fabs, which IEEE 754
 * defines exactly. */
#ifndef SNELL_MATHS_VEC_H
#define SNELL_MATHS_VEC_H

#include <math.h>

#include <snell/snell.h>

typedef snell_vec2 vec2;
typedef snell_vec3 vec3;
typedef snell_bounds bounds3;
typedef snell_transform transform;
typedef struct dvec3 {
    double x, y, z;
} dvec3;

static inline float float_min(float a, float b) { return a < b ? a : b; }
static inline float float_max(float a, float b) { return a > b ? a : b; }
static inline double double_min(double a, double b) { return a < b ? a : b; }
static inline double double_max(double a, double b) { return a > b ? a : b; }
static inline double clamp01(double x) { return x < 0 ? 0 : x < 1 ? x : 1; }

/* ---- float ---- */
static inline vec3 vec3_add(vec3 a, vec3 b) { return (vec3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline vec3 vec3_sub(vec3 a, vec3 b) { return (vec3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vec3 vec3_mul(vec3 a, vec3 b) { return (vec3){a.x * b.x, a.y * b.y, a.z * b.z}; }
static inline vec3 vec3_scale(vec3 a, float s) { return (vec3){a.x * s, a.y * s, a.z * s}; }
static inline vec3 vec3_min(vec3 a, vec3 b) {
    return (vec3){float_min(a.x, b.x), float_min(a.y, b.y), float_min(a.z, b.z)};
}
static inline vec3 vec3_max(vec3 a, vec3 b) {
    return (vec3){float_max(a.x, b.x), float_max(a.y, b.y), float_max(a.z, b.z)};
}
static inline float vec3_largest(vec3 a) { return float_max(float_max(a.x, a.y), a.z); }

/* ---- double ---- */
static inline dvec3 dvec3_from(vec3 a) { return (dvec3){a.x, a.y, a.z}; }
static inline vec3 vec3_from(dvec3 a) { return (vec3){(float)a.x, (float)a.y, (float)a.z}; }
static inline dvec3 dvec3_add(dvec3 a, dvec3 b) { return (dvec3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline dvec3 dvec3_sub(dvec3 a, dvec3 b) { return (dvec3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline dvec3 dvec3_mul(dvec3 a, dvec3 b) { return (dvec3){a.x * b.x, a.y * b.y, a.z * b.z}; }
static inline dvec3 dvec3_scale(dvec3 a, double s) { return (dvec3){a.x * s, a.y * s, a.z * s}; }
static inline dvec3 dvec3_negate(dvec3 a) { return (dvec3){-a.x, -a.y, -a.z}; }
static inline double dvec3_dot(dvec3 a, dvec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline dvec3 dvec3_cross(dvec3 a, dvec3 b) {
    return (dvec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline double dvec3_length(dvec3 a) { return sqrt(dvec3_dot(a, a)); }
/* The zero vector stays zero. */
static inline dvec3 dvec3_normalize(dvec3 a) {
    double length = dvec3_length(a);
    return length > 0 ? dvec3_scale(a, 1 / length) : a;
}
static inline double dvec3_largest(dvec3 a) { return double_max(double_max(a.x, a.y), a.z); }
/* Two unit vectors that make a right-handed orthonormal frame (t, b, n) with the unit vector n.
 * Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017. */
static inline void dvec3_frame(dvec3 n, dvec3 *t, dvec3 *b) {
    double sign = n.z < 0 ? -1 : 1, a = -1 / (sign + n.z), c = n.x * n.y * a;
    *t = (dvec3){1 + sign * n.x * n.x * a, sign * c, -sign * n.x};
    *b = (dvec3){c, sign + n.y * n.y * a, -n.y};
}

/* From the frame of the unit vector n, which is its z, to the space of n. */
static inline dvec3 dvec3_from_frame(dvec3 n, dvec3 local) {
    dvec3 t, b;
    dvec3_frame(n, &t, &b);
    return dvec3_add(dvec3_add(dvec3_scale(t, local.x), dvec3_scale(b, local.y)),
                     dvec3_scale(n, local.z));
}

/* The reverse: a vector's coordinates in the frame of n. */
static inline dvec3 dvec3_to_frame(dvec3 n, dvec3 v) {
    dvec3 t, b;
    dvec3_frame(n, &t, &b);
    return (dvec3){dvec3_dot(t, v), dvec3_dot(b, v), dvec3_dot(n, v)};
}

/* Rows of a linear map of colours or directions. */
typedef struct dmat3 {
    dvec3 x, y, z;
} dmat3;
static inline dvec3 dmat3_apply(const dmat3 *m, dvec3 v) {
    return (dvec3){dvec3_dot(m->x, v), dvec3_dot(m->y, v), dvec3_dot(m->z, v)};
}

/* ---- bounds ---- */
static inline bounds3 bounds3_empty(void) {
    return (bounds3){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}
static inline bool bounds3_is_empty(bounds3 b) {
    return !(b.min.x <= b.max.x && b.min.y <= b.max.y && b.min.z <= b.max.z);
}
static inline bounds3 bounds3_add_point(bounds3 b, vec3 p) {
    return (bounds3){vec3_min(b.min, p), vec3_max(b.max, p)};
}
static inline bounds3 bounds3_union(bounds3 a, bounds3 b) {
    return (bounds3){vec3_min(a.min, b.min), vec3_max(a.max, b.max)};
}
/* Half the surface area, in double so that a huge box does not overflow; 0 when empty. */
static inline double bounds3_half_area(bounds3 b) {
    if (bounds3_is_empty(b)) return 0;
    double x = (double)b.max.x - b.min.x, y = (double)b.max.y - b.min.y,
           z = (double)b.max.z - b.min.z;
    return x * y + y * z + z * x;
}
/* The smallest float box around a box in double: bounds round outwards. */
bounds3 bounds3_outward(dvec3 low, dvec3 high);

/* ---- transforms (float storage, double arithmetic) ---- */
static inline transform transform_identity(void) {
    return (transform){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}
bool transform_is_identity(const transform *m);
transform transform_multiply(const transform *a, const transform *b); /* b is applied first */
double transform_determinant(const transform *m);                     /* of the linear part */
bool transform_inverse(const transform *m, transform *out); /* false: singular or not finite */
static inline dvec3 transform_vector(const transform *m, dvec3 v) {
    double r[3];
    for (int i = 0; i < 3; i++)
        r[i] = (double)m->m[i][0] * v.x + (double)m->m[i][1] * v.y + (double)m->m[i][2] * v.z;
    return (dvec3){r[0], r[1], r[2]};
}
static inline dvec3 transform_point(const transform *m, dvec3 p) {
    dvec3 v = transform_vector(m, p);
    return (dvec3){v.x + (double)m->m[0][3], v.y + (double)m->m[1][3], v.z + (double)m->m[2][3]};
}
/* By the transpose of `inverse`'s linear part: with the inverse of m, a normal under m. Not
 * normalised. */
static inline dvec3 transform_normal(const transform *inverse, dvec3 n) {
    double r[3];
    for (int j = 0; j < 3; j++)
        r[j] = (double)inverse->m[0][j] * n.x + (double)inverse->m[1][j] * n.y +
               (double)inverse->m[2][j] * n.z;
    return (dvec3){r[0], r[1], r[2]};
}
/* The same in double, so that long products are rounded once, at the end. */
typedef struct dtransform {
    double m[3][4];
} dtransform;
static inline dtransform dtransform_identity(void) {
    return (dtransform){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}
dtransform dtransform_from(const transform *t);
dtransform dtransform_multiply(const dtransform *a, const dtransform *b); /* b is applied first */
transform dtransform_round(const dtransform *p);
bounds3 transform_bounds(const transform *m,
                         bounds3 b); /* of the eight corners, rounded outwards; empty stays empty */

/* The box of transform_bounds(to_world, b), widened so that it holds for rays too, which are rounded in
 * both spaces and come by to_local, the rounded inverse; empty stays empty. */
bounds3 transform_bounds_widened(const transform *to_world, const transform *to_local, bounds3 b);

/* The float before and after a finite x. */
float float_below(float x);
float float_above(float x);

#endif
