/* What every picture relies on of the compiler: double to float and back rounds. gcc 12 forgets it at
 * -O2 where it does two at a time in straight-line code (-ftree-slp-vectorize); pictures through a
 * lens then differed between gcc and clang. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "maths/functions.h"
#include "maths/vec.h"

/* As the thin lens: the direction from an origin that was rounded. */
__attribute__((noinline)) static void aim(const dvec3 *from, const dvec3 *at, vec3 *o, dvec3 *d) {
    *o = vec3_from(*from);
    *d = dvec3_sub(*at, dvec3_from(*o));
}

static void a_float_is_rounded(void **state) {
    (void)state;
    volatile double tenth = 0.1; /* so that the compiler does not know it */
    volatile float rounded = 0.1f;
    dvec3 from = {tenth, 2 * tenth, 4 * tenth}, at = {tenth, 0, 0}, d;
    vec3 o;
    aim(&from, &at, &o, &d);
    assert_true(d.x == tenth - (double)rounded);
    assert_true(d.y == -2 * (double)rounded);
    assert_true(d.z == -4 * (double)rounded);
}

/* Two at a time and one at a time: every exponent of either sign, and what has a special answer. */
static void three_exponentials_are_as_one(void **state) {
    (void)state;
    const double special[] = {0,      -0.0,      INFINITY, -INFINITY, 1e308,
                              -1e308, 0x1p-1074, 709.8,    -745.2};
    uint64_t random = 1;
    for (int i = 0; i < 300000; i++) {
        double x[3], three[3];
        for (int k = 0; k < 3; k++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            double size = ldexp(1 + (double)(random >> 40) * 0x1p-24, (int)(random >> 58) - 52);
            x[k] = random >> 32 & 1 ? size : -size;
        }
        if (i < 9) x[i % 3] = special[i];
        fn_exp3(x, three);
        for (int k = 0; k < 3; k++) {
            double one = fn_exp(x[k]);
            assert_memory_equal(&one, &three[k], sizeof one);
        }
    }
    assert_true(fn_exp(0) == 1 && fn_exp(-0.0) == 1 && fn_exp(-INFINITY) == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_float_is_rounded),
                                       cmocka_unit_test(three_exponentials_are_as_one)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
