/* Polynomials over [0,1] in Bernstein form: c[0..n] of degree n stand for the sum of c[i] C(n,i) s^i
 * (1-s)^(n-i). Where a polynomial is, and how many roots it has, can be read off the coefficients:
 * its values lie between the least and the largest of them, and it has at most as many roots inside
 * as they change sign (Farouki, The Bernstein polynomial basis: a centennial retrospective, 2012). */
#ifndef SNELL_GEOMETRY_BERNSTEIN_H
#define SNELL_GEOMETRY_BERNSTEIN_H

enum { BERNSTEIN_DEGREE_MAX = 10 };

/* The value at any s, also outside [0,1]; *slope, which may be NULL: its derivative there. */
double bernstein_value(const double *c, int n, double s, double *slope);
/* out[0..n+m] = a b, out[0..n-1] = c'. `out` is another array. */
void bernstein_multiply(const double *a, int n, const double *b, int m, double *out);
void bernstein_derivative(const double *c, int n, double *out);
/* The same polynomial over [low, high] as one over [0,1]; in place. */
void bernstein_restrict(double *c, int n, double low, double high);
/* The roots inside (0,1), in ascending order, at most `capacity`. Several within 2^-40 of one another
 * may be given as one, or some more; one at an end, or of a polynomial that is 0 but for rounding, is
 * left out. */
int bernstein_roots(const double *c, int n, double *roots, int capacity);

#endif
