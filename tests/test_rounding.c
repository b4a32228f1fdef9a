/* What every picture relies on of the compiler: double to float and back rounds. gcc 12 forgets it at
 * -O2 where it does two at a time in straight-line code (-ftree-slp-vectorize); pictures through a
 * lens then differed between gcc and clang. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

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

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_float_is_rounded)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
