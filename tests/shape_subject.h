/* For tests over every registered shape: a slow solver in long double for each, which knows nothing of
 * the library's own. A family of shapes is one header of solvers with a table of subjects, listed in
 * shape_subjects.h; a shape without a subject fails the tests. */
#ifndef SNELL_TESTS_SHAPE_SUBJECT_H
#define SNELL_TESTS_SHAPE_SUBJECT_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "maths/functions.h"
#include "maths/vec.h"

typedef long double real;
typedef struct vec {
    real x, y, z;
} vec;

static vec wide(vec3 a) { return (vec){a.x, a.y, a.z}; }
static vec wide_d(dvec3 a) { return (vec){a.x, a.y, a.z}; }
static vec plus(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
static vec minus(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
static vec times(vec a, real s) { return (vec){a.x * s, a.y * s, a.z * s}; }
static real dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline vec cross(vec a, vec b) {
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static real length(vec a) { return sqrtl(dot(a, a)); }

/* ---- random numbers: splitmix64 ---- */
static uint64_t random_state;
static uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}
static double uniform(void) { return (double)(random_bits() >> 11) * 0x1p-53; }
static double between(double low, double high) { return low + (high - low) * uniform(); }
static dvec3 direction(void) {
    for (;;) {
        dvec3 v;
        v.x = between(-1, 1);
        v.y = between(-1, 1);
        v.z = between(-1, 1);
        double square = dvec3_dot(v, v);
        if (square > 0.01 && square <= 1) return dvec3_normalize(v);
    }
}
static dvec3 in_ball(dvec3 center, double radius) {
    double distance = radius * uniform(); /* one draw per statement: compilers agree on the order */
    return dvec3_add(center, dvec3_scale(direction(), distance));
}

/* ---- the slow solvers ---- */

/* A place where the ray's line meets the shape's surface. margin: how far, relative to the shape,
 * from its edge or from being tangent; negative when it is outside. slack: the error allowed in t
 * besides the rounding to float. */
typedef struct root {
    real t, margin, slack;
} root;

#define ROOTS 16

/* A shape under test; sizes are about `size`, the middle about `at`. */
typedef struct subject {
    const char *name;
    void (*make)(void *desc, dvec3 at, double size);
    int (*solve)(const void *desc, vec o, vec d, root roots[ROOTS]);
    real (*distance)(const void *desc, vec p); /* signed, to the whole surface's plane if flat */
    real (*edge)(const void *desc, vec p);     /* how far from a corner; NULL: see at_edge */
    real (*blur)(const void *desc, vec p);     /* what rounding its numbers moves the surface by */
    bool winding;                              /* a ray that leaves it outwards may meet it again */
    bool upright;                              /* its axis is the Y axis */
    bool centered;                             /* it lies about the origin: a transform moves it */
    double own_offset; /* as far as this, in sizes, it can be moved itself */
    double fixed_size; /* its size, which a transform changes; 0: any */
} subject;

#endif
