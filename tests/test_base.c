/* base: errors, spelling suggestions, descriptions from tables, the thread pool. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <string.h>

#include "base/error.h"
#include "base/field.h"
#include "base/thread.h"

#define BALL_FIELDS(F, T)                                                                          \
    F(T, center, VEC3, DEFAULT(0, 1, 0), ANY, "m", "the centre")                                   \
    F(T, radius, FLOAT, DEFAULT(1), POSITIVE, "m", "the radius")                                   \
    F(T, axis, VEC3, DEFAULT(0, 1, 0), DIRECTION, "", "the axis")                                  \
    F(T, wrap, CHOICE, DEFAULT(0), CHOICES("repeat|clamp"), "", "how")                             \
    F(T, indices, UINTS, NO_DEFAULT, REQUIRED, "", "numbers")
DESCRIBE(ball, BALL_FIELDS)
static const type_info ball_type = TYPE_INFO(CATEGORY_SHAPE, ball, "ball", "a ball for this test");

static void defaults_come_from_the_table(void **state) {
    (void)state;
    ball_desc ball;
    desc_init(&ball_type, &ball);
    assert_int_equal(ball.struct_size, sizeof ball);
    assert_true(ball.center.y == 1 && ball.radius == 1 && ball.indices == NULL);
}

static void a_misspelt_field_gets_a_suggestion(void **state) {
    (void)state;
    ball_desc ball;
    desc_init(&ball_type, &ball);
    snell_param param = {.name = "radus", .kind = SNELL_PARAM_FLOAT, .value.f = 2};
    assert_int_equal(desc_set(&ball_type, &ball, &param), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "ball: unknown field 'radus'");
    assert_string_equal(error_last()->hint, "did you mean 'radius'?");
}

/* A suggestion is near: one error in three letters, two swapped neighbours being one. */
static void only_near_words_are_suggested(void **state) {
    (void)state;
    const char *const words[] = {"from", "last", "cos", "radius", "at", "x"};
    const size_t count = sizeof words / sizeof words[0];
    assert_null(closest_word("fov", words, count));
    assert_null(closest_word("glass", words, count));
    assert_null(closest_word("foo", words, count));
    assert_null(closest_word("y", words, count));
    assert_null(closest_word("rod", words, count));
    assert_string_equal(closest_word("form", words, count), "from");
    assert_string_equal(closest_word("ta", words, count), "at");
    assert_string_equal(closest_word("raduss", words, count), "radius");
    assert_string_equal(closest_word("cosh", words, count), "cos");
    assert_null(closest_word("", words, count));
}

static void ranges_and_directions_are_checked(void **state) {
    (void)state;
    ball_desc ball;
    desc_init(&ball_type, &ball);
    bool given[5] = {false};
    assert_int_equal(desc_check(&ball_type, &ball, given),
                     SNELL_ERR_ARGUMENT); /* indices are missing */
    ball.radius = 0;
    assert_int_equal(desc_check(&ball_type, &ball, NULL), SNELL_ERR_ARGUMENT);
    ball.radius = NAN;
    assert_int_equal(desc_check(&ball_type, &ball, NULL), SNELL_ERR_ARGUMENT);
    ball.radius = 1;
    ball.axis = (snell_vec3){0, 3, 4};
    assert_int_equal(desc_check(&ball_type, &ball, NULL), SNELL_OK);
    assert_true(ball.axis.y == 0.6f && ball.axis.z == 0.8f);
    ball.axis = (snell_vec3){0, 0, 0};
    assert_int_equal(desc_check(&ball_type, &ball, NULL), SNELL_ERR_ARGUMENT);
    ball.axis = (snell_vec3){0, 1, 0};
    ball.wrap = 2;
    assert_int_equal(desc_check(&ball_type, &ball, NULL), SNELL_ERR_ARGUMENT);
}

static void copies_own_their_arrays(void **state) {
    (void)state;
    uint32_t numbers[] = {3, 1, 2};
    ball_desc ball;
    desc_init(&ball_type, &ball);
    ball.indices = numbers;
    ball.indices_count = 3;
    ball_desc *copy = desc_copy(&ball_type, &ball);
    assert_non_null(copy);
    numbers[0] = 9;
    assert_int_equal(copy->indices[0], 3);
    desc_free(&ball_type, copy);
}

static void count_index(void *data, size_t index, uint32_t worker) {
    (void)worker;
    ((uint8_t *)data)[index]++;
}

static void the_pool_runs_each_index_once(void **state) {
    (void)state;
    for (uint32_t threads = 1; threads <= 8; threads *= 2) {
        thread_pool *pool;
        assert_int_equal(thread_pool_create(threads, &pool), SNELL_OK);
        for (int round = 0; round < 50; round++) {
            uint8_t counts[1000] = {0};
            thread_pool_run(pool, 1000, count_index, counts);
            for (int i = 0; i < 1000; i++) assert_int_equal(counts[i], 1);
        }
        thread_pool_destroy(pool);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_come_from_the_table),
        cmocka_unit_test(a_misspelt_field_gets_a_suggestion),
        cmocka_unit_test(only_near_words_are_suggested),
        cmocka_unit_test(ranges_and_directions_are_checked),
        cmocka_unit_test(copies_own_their_arrays),
        cmocka_unit_test(the_pool_runs_each_index_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
