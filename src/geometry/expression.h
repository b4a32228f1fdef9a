/* A formula in x, y, z as text: read once into a list of operations, evaluated in double with its
 * derivatives (forward mode), and in interval arithmetic with bounds of its derivatives.
 *
 *     names      x y z, pi, and what a `name = formula;` before the last formula defines
 *     operators  + - * / ^ (from right to left, before the sign: -x^2 is -(x^2)), ( )
 *     functions  sqrt abs sin cos tan asin acos atan atan2(y, x) exp log floor mod(a, b) min(..) max(..)
 *                clamp(a, low, high) mix(a, b, part) length(..) smooth_min(a, b, width)
 *                smooth_max(a, b, width)
 *
 * a ^ b is a product where b is a whole number; otherwise it is defined for a >= 0 only. mod has the
 * sign of b. What is not defined is NaN, and so is all that is made of it, by min and max too.
 * smooth_min is the quadratic one: min(a, b) - h^2 width / 4, h = max(1 - |a - b| / width, 0). */
#ifndef SNELL_GEOMETRY_EXPRESSION_H
#define SNELL_GEOMETRY_EXPRESSION_H

#include "maths/interval.h"

enum {
    EXPRESSION_TEXT_MAX = 4096, /* characters */
    EXPRESSION_STEPS_MAX = 512, /* operations, equal ones counted once */
    EXPRESSION_DEPTH_MAX = 64,  /* parentheses in parentheses */
    EXPRESSION_NAMES_MAX = 64   /* definitions */
};

typedef struct expression expression;

/* Errors begin with `label` ("implicit: 'f'") and say the column. expression_destroy(NULL) does
 * nothing. */
snell_status expression_create(const char *label, const char *text, expression **out);
void expression_destroy(expression *e);
extern const size_t expression_size; /* bytes of each */

/* The value at p, and its derivatives along each of `count` (at most 3) directions. */
double expression_at(const expression *e, dvec3 p, const dvec3 *along, int count,
                     double *derivatives);

/* What the formula may be somewhere in a box. */
typedef struct expression_range {
    interval value;
    interval derivatives[3];
    bool undefined_somewhere; /* maybe: value bounds only where it is defined */
    bool undefined;           /* nowhere defined */
} expression_range;

/* Bounds of the value, and of the derivatives along each of `count` directions, over the box p. Where
 * the value may jump, its derivatives have no bounds; where it only bends, they have both sides'. */
void expression_over(const expression *e, const interval p[3], const dvec3 *along, int count,
                     expression_range *out);

#endif
