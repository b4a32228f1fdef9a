#include "maths/interval.h"

#include "maths/functions.h"

double integer_power(double x, int power) {
    double result = 1;
    for (unsigned left = (unsigned)power; left; left >>= 1) {
        if (left & 1) result *= x;
        x *= x;
    }
    return result;
}

/* Each of at most 2 log2(power) roundings is multiplied by what follows: less than 2 power ulps. */
interval interval_integer_power(interval a, int power) {
    if (power % 2 == 0) a = interval_abs(a);
    interval made =
        interval_wider(integer_power(a.low, power), integer_power(a.high, power), 2.0 * power);
    if (power % 2 == 0) made.low = double_max(made.low, 0);
    return made;
}

/* Does [low, high], both in turns, hold a whole number plus `part`? Rounding may only say yes. */
static bool holds_turn(double low, double high, double part) {
    double slack = 0x1p-50 * (1 + double_max(fabs(low), fabs(high)));
    return floor(high - part + slack) >= ceil(low - part - slack);
}

/* Beyond this a turn is not known well enough. */
#define TURNS_MAX 0x1p30

static interval wave(interval a, double top, double (*function)(double x)) {
    double low = a.low / (2 * PI), high = a.high / (2 * PI);
    if (!(high - low < 1 && fabs(low) < TURNS_MAX && fabs(high) < TURNS_MAX))
        return (interval){-1, 1};
    double one = function(a.low), other = function(a.high);
    interval made = interval_wider(double_min(one, other), double_max(one, other), 2);
    if (holds_turn(low, high, top)) made.high = 1;
    if (holds_turn(low, high, top + 0.5)) made.low = -1;
    return (interval){double_max(made.low, -1), double_min(made.high, 1)};
}

interval interval_sin(interval a) { return wave(a, 0.25, fn_sin); }
interval interval_cos(interval a) { return wave(a, 0, fn_cos); }

/* Over a box that has neither the origin nor the cut in it the angle is extreme at corners. */
interval interval_atan2(interval y, interval x) {
    if (x.low <= 0 && interval_contains(y, 0)) return interval_outward(-PI, PI);
    const double corners[4] = {fn_atan2(y.low, x.low), fn_atan2(y.low, x.high),
                               fn_atan2(y.high, x.low), fn_atan2(y.high, x.high)};
    interval made = interval_point(corners[0]);
    for (int i = 1; i < 4; i++) made = interval_hull(made, interval_point(corners[i]));
    return interval_wider(made.low, made.high, 2);
}
