/* Elementary functions whose bits do not depend on the machine: SLEEF's reproducible set without
 * FMA, at most 1 ulp off. libm must not be used for these anywhere that can reach a pixel. */
#ifndef SNELL_MATHS_FUNCTIONS_H
#define SNELL_MATHS_FUNCTIONS_H

double fn_sin(double x);
double fn_cos(double x);
double fn_tan(double x);
double fn_asin(double x);
double fn_acos(double x);
double fn_atan(double x);
double fn_atan2(double y, double x);
double fn_exp(double x);
void fn_exp3(const double x[3], double out[3]); /* the same bits as three fn_exp, sooner */
double fn_log(double x);
double fn_pow(double x, double y);
double fn_cbrt(double x);
double fn_erfc(double x); /* at most 1.5 ulp */

#define PI 3.14159265358979323846

#endif
