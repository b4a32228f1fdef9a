#include "maths/functions.h"

#include <sleef.h>

double fn_sin(double x) { return Sleef_cinz_sind1_u10purec(x); }
double fn_cos(double x) { return Sleef_cinz_cosd1_u10purec(x); }
double fn_tan(double x) { return Sleef_cinz_tand1_u10purec(x); }
double fn_asin(double x) { return Sleef_cinz_asind1_u10purec(x); }
double fn_acos(double x) { return Sleef_cinz_acosd1_u10purec(x); }
double fn_atan(double x) { return Sleef_cinz_atand1_u10purec(x); }
double fn_atan2(double y, double x) { return Sleef_cinz_atan2d1_u10purec(y, x); }
double fn_exp(double x) { return Sleef_cinz_expd1_u10purec(x); }
void fn_exp3(const double x[3], double out[3]) {
#ifdef __SSE2__
    _mm_storeu_pd(out, Sleef_cinz_expd2_u10sse2(_mm_loadu_pd(x)));
#else
    out[0] = fn_exp(x[0]);
    out[1] = fn_exp(x[1]);
#endif
    out[2] = fn_exp(x[2]);
}
double fn_log(double x) { return Sleef_cinz_logd1_u10purec(x); }
double fn_pow(double x, double y) { return Sleef_cinz_powd1_u10purec(x, y); }
double fn_cbrt(double x) { return Sleef_cinz_cbrtd1_u10purec(x); }
double fn_erfc(double x) { return Sleef_cinz_erfcd1_u15purec(x); }
