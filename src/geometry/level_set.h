/* What shapes have in common whose surface is where a function f changes its sign: f < 0 inside. Each
 * gives its value, bounds of it along a stretch of a ray, and its gradient; the rest is here.
 *
 * level_isolate finds roots by halving with guaranteed bounds (Mitchell, Robust Ray Intersection with
 * Interval Arithmetic, Graphics Interface 1990; Galin et al., Segment Tracing Using Local Lipschitz
 * Bounds, Eurographics 2020): a stretch over which the bounds say that f keeps its sign has no root;
 * one over which f is monotone has one at most, which the signs at its ends decide; any other is
 * halved. So nothing is missed that is longer along the ray than the resolution, 2^-24 of the shape's
 * size, as long as a ray has not used up its LEVEL_LOOKS_MAX stretches: from then on nothing is missed
 * that is longer than a LEVEL_PARTS_MINth of its way through the shape. */
#ifndef SNELL_GEOMETRY_LEVEL_SET_H
#define SNELL_GEOMETRY_LEVEL_SET_H

#include "geometry/surface.h"
#include "maths/interval.h"

enum { LEVEL_LOOKS_MAX = 1 << 14, LEVEL_PARTS_MIN = 1 << 10 };

/* A ray for solving along it: p(s) = o + s d relative to the shape's middle, with d a unit vector and
 * p(0) the point nearest to the middle, so that a far origin costs no precision. s = t speed - shift. */
typedef struct level_line {
    dvec3 o, d;
    double shift, speed;
} level_line;

/* false: a ray without a direction, or not finite. */
bool level_line_make(const local_ray *beam, dvec3 middle, level_line *out);

/* The stretch of the line within a distance of the middle. */
bool level_line_clip(const level_line *line, double radius, double *low, double *high);

static inline dvec3 level_line_at(const level_line *line, double s) {
    return dvec3_add(line->o, dvec3_scale(line->d, s));
}

/* Told of each crossing in ascending order, entering and leaving in turns; part: what the shape's own
 * `surface` wants to know, 0 for the surface f = 0. false: that is enough. */
typedef bool level_visit(void *user, double s, bool enters, int part);

/* Bounds of f(p(s)) and of its derivative by s over a stretch. */
typedef struct level_range {
    interval value, slope;
    bool defined; /* everywhere; otherwise f may be NaN, which counts as outside */
} level_range;

typedef struct level_function {
    double (*value)(const void *shape, const level_line *line, double s, double *slope);
    void (*range)(const void *shape, const level_line *line, double low, double high,
                  level_range *out);
} level_function;

/* The stretch of the line in which a shape lies, and of that what is asked for. The former is always
 * halved in the same places, so that a root is the same number whoever asks. */
typedef struct level_stretch {
    double low, high, from, to;
} level_stretch;

/* Visits the sign changes of f between from and to; *inside is the side at the end. false: the
 * visitor had enough. */
bool level_isolate(const level_function *f, const void *shape, const level_line *line,
                   level_stretch where, double resolution, bool *inside, level_visit *visit,
                   void *user);

/* The root between low and high, of which one side is inside: Newton's method, or halving where that
 * would leave the bracket or not shrink it by half. */
double level_refine(double (*value)(const void *shape, const level_line *line, double s,
                                    double *slope),
                    const void *shape, const level_line *line, double low, double high,
                    bool low_is_inside);

/* A shape of this kind. */
typedef struct level_shape {
    dvec3 (*middle)(const void *shape);
    double (*size)(const void *shape); /* about its radius */
    /* Visits every crossing between from and to, which may be infinite. If the shape holds `from`,
     * the first one leaves it. */
    void (*walk)(const void *shape, const level_line *line, double from, double to,
                 level_visit *visit, void *user);
    /* f and its gradient at p, relative to the middle. */
    double (*gradient)(const void *shape, dvec3 p, dvec3 *gradient);
    /* How far the values that `walk` sees near p may be from the true ones. */
    double (*noise)(const void *shape, dvec3 p);
} level_shape;

/* The functions of primitive_type. In hit and surface_crossing u is what rounding t to float took away,
 * v the part. */
bool level_intersect(const level_shape *kind, const void *shape, const local_ray *beam, hit *found);
int level_spans(const level_shape *kind, const void *shape, const local_ray *beam, span *out,
                int capacity);
/* For part 0. */
void level_surface(const level_shape *kind, const void *shape, const local_ray *beam,
                   const hit *found, surface *out);
/* The point of the ray at the hit, relative to the middle, before it is brought to the surface. */
dvec3 level_hit_point(const level_line *line, const hit *found);
/* u, v as on a globe about the middle, without tangents: they are only a way to tell places apart. */
static inline void level_parametrise(dvec3 middle, surface *s) {
    surface_globe(s, dvec3_normalize(dvec3_sub(s->p, middle)), 0);
    s->dpdu = s->dpdv = (dvec3){0, 0, 0};
}

#endif
