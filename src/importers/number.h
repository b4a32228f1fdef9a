/* Decimal numbers of text files: correctly rounded, and not by the locale. A text must end with a byte
 * that belongs to no number, such as 0. */
#ifndef SNELL_IMPORTERS_NUMBER_H
#define SNELL_IMPORTERS_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Where number_read's shortcut does not do. */
const char *number_read_slowly(const char *start, float *out);
extern const double number_powers[]; /* 10^0 .. 10^NUMBER_POWER_MAX, each correctly rounded */
enum { NUMBER_POWER_MAX = 55, NUMBER_DIGITS_MAX = 18 };

static inline bool number_is_digit(char c) { return (unsigned char)(c - '0') < 10; }

/* The text after [+-] digits [. digits] [e [+-] digits], NULL where there is none (no "nan", no "inf"); what is too
 * large becomes infinite.
 *
 * The shortcut is Clinger's (How to Read Floating Point Numbers Accurately, PLDI 1990), loosened: at most 18
 * digits as an integer, times or over a power of ten, in double. Integer, power and result are each within
 * 2^-53 of what they stand for, so the double is within 4 of its last places. A float is 29 bits shorter: it is
 * rounded right unless a tie between two floats may lie in those 4. */
static inline const char *number_read(const char *start, float *out) {
    const char *at = start + (*start == '-' || *start == '+'), *first = at;
    uint64_t digits = 0;
    for (; number_is_digit(*at); at++) digits = 10 * digits + (uint64_t)(*at - '0');
    ptrdiff_t count = at - first, exponent = 0;
    if (*at == '.') {
        const char *point = ++at;
        for (; number_is_digit(*at); at++) digits = 10 * digits + (uint64_t)(*at - '0');
        exponent = point - at;
        count -= exponent;
    }
    if (count == 0) return NULL;
    if (count > NUMBER_DIGITS_MAX) return number_read_slowly(start, out);
    if ((*at | 32) == 'e') {
        const char *power = at + 1;
        bool down = *power == '-';
        if (*power == '-' || *power == '+') power++;
        if (number_is_digit(*power)) {
            ptrdiff_t value = 0;
            for (; number_is_digit(*power); power++)
                if (value < 100000) value = 10 * value + (*power - '0');
            exponent += down ? -value : value;
            at = power;
        }
    }
    if (exponent < -NUMBER_POWER_MAX || exponent > NUMBER_POWER_MAX)
        return number_read_slowly(start, out);
    double value = (double)(int64_t)digits;
    if (exponent < 0)
        value /= number_powers[-exponent];
    else
        value *= number_powers[exponent];
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    bool tie = (bits & 0x1fffffff) - 0x0ffffffc <= 8;
    if (digits != 0 && (tie || !(value > 1.2e-38 && value < 3.4e38)))
        return number_read_slowly(start, out);
    *out = *start == '-' ? -(float)value : (float)value;
    return at;
}

/* [+-] digits, cut to +-10^18; NULL where there is none. */
static inline const char *number_read_integer(const char *at, int64_t *out) {
    bool negative = *at == '-';
    if (*at == '-' || *at == '+') at++;
    const char *first = at;
    int64_t value = 0;
    for (; number_is_digit(*at); at++)
        value = value < 100000000000000000 ? 10 * value + (*at - '0') : 1000000000000000000;
    *out = negative ? -value : value;
    return at > first ? at : NULL;
}

#endif
