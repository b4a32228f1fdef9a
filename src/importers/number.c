#include "importers/number.h"

#include <stdlib.h>

const double number_powers[] = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11, 1e12, 1e13,
    1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22, 1e23, 1e24, 1e25, 1e26, 1e27,
    1e28, 1e29, 1e30, 1e31, 1e32, 1e33, 1e34, 1e35, 1e36, 1e37, 1e38, 1e39, 1e40, 1e41,
    1e42, 1e43, 1e44, 1e45, 1e46, 1e47, 1e48, 1e49, 1e50, 1e51, 1e52, 1e53, 1e54, 1e55,
};
_Static_assert(sizeof number_powers / sizeof number_powers[0] == NUMBER_POWER_MAX + 1, "one each");

/* snell-import runs in the C locale. Only what began as a decimal number with many digits or a large
 * exponent comes here, so strtof's other notations cannot. */
const char *number_read_slowly(const char *start, float *out) {
    char *end;
    *out = strtof(start, &end);
    return end;
}
