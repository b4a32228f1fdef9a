/* White balance: which light looks white. */
#ifndef SNELL_IMAGE_WHITE_BALANCE_H
#define SNELL_IMAGE_WHITE_BALANCE_H

#include "base/error.h"
#include "maths/vec.h"

typedef struct white_balance {
    bool on; /* false: nothing changes */
    dmat3 m; /* linear Rec. 709 to linear Rec. 709 */
} white_balance;

enum { WHITE_BALANCE_TEXT_MAX = 128 /* more than any text that is understood */ };
/* What is to look white: a temperature in kelvin ("3200", 1000 to 25000; 6504 is D65 and changes
 * nothing) or a colour ("#ffd9b0" sRGB, "1,0.7,0.4" linear). NULL or "": nothing changes. Errors:
 * SNELL_ERR_ARGUMENT. */
snell_status white_balance_parse(const char *text, white_balance *out);
/* Colours may become negative. */
dvec3 white_balance_apply(const white_balance *balance, dvec3 color);
/* The chromaticity (CIE 1931 x, y) of that temperature, 1000 to 25000 K: see white_balance.c. */
void white_balance_locus(double kelvin, double *x, double *y);

#endif
