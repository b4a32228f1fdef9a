/* geometry: formulas and shapes that are fields, beyond what test_geometry asks of every shape: what a
 * formula means, that bounds enclose, what is refused and how, and that nothing takes for ever. */
#ifdef __linux__
#include <malloc.h>
#endif
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "geometry/expression.h"
#include "geometry/surface.h"
#include "shapes_fields.h"

static expression *formula_of(const char *text) {
    expression *made = NULL;
    if (expression_create("f", text, &made))
        fail_msg("'%s' is refused: %s", text, error_last()->text);
    return made;
}

static double value_of(const char *text, dvec3 p) {
    expression *e = formula_of(text);
    double value = expression_at(e, p, NULL, 0, NULL);
    expression_destroy(e);
    return value;
}

static void a_formula_means_what_it_says(void **state) {
    (void)state;
    const dvec3 p = {0.5, -2, 3};
    const struct {
        const char *text;
        double value;
    } cases[] = {
        {"x + y*z", 0.5 - 6},
        {"-y^2", -4},
        {"2^3^2", 512},
        {"(x - 1)^-2", 4},
        {"y^3 - -1", -7},
        {"12 / 3 / 2 - 1 - 1", 0},
        {"a = x*2; b = a + z; b - a", 3},
        {"x = 7; x", 7},
        {"1.5e2 + .5 + 2.", 152.5},
        {"123456789.125", 123456789.125},
        {"0.1", 0.1},
        {"1e-7", 1e-7},
        {"max(x, y, z) - min(x, y, z)", 5},
        {"length(z, 4)", 5},
        {"length(2, 3, 6)", 7},
        {"mod(-0.25, 1)", 0.75},
        {"clamp(z, 0, 1) + clamp(y, 0, 1)", 1},
        {"mix(2, 4, x)", 3},
        {"smooth_min(1, 1, 0.4)", 0.9},
        {"smooth_min(1, 2, 0.4)", 1},
        {"smooth_max(1, 1, 0.4)", 1.1},
        {"floor(y + x) + abs(y) + sqrt(z*3)", 3},
        {"cos(pi) + sin(0) + atan2(0, 1) + exp(0) + log(1) + tan(0)", 0},
        {"9^x", 3},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        double value = value_of(cases[i].text, p);
        if (!(fabs(value - cases[i].value) <= 4e-16 * fabs(cases[i].value)))
            fail_msg("%s = %.17g", cases[i].text, value);
    }
    const char *const undefined[] = {"sqrt(y)", "log(y)",      "asin(z)",  "min(log(y), 1)",
                                     "y^0.5",   "max(1, y^x)", "0*sqrt(y)"};
    for (size_t i = 0; i < sizeof undefined / sizeof undefined[0]; i++)
        assert_true(isnan(value_of(undefined[i], p)));
}

static void mistakes_are_shown_by_their_column(void **state) {
    (void)state;
    const struct {
        const char *text, *message;
    } cases[] = {
        {"", "f: column 1: a value is missing"},
        {"x +", "f: column 4: a value is missing"},
        {"x + foo(y)", "f: column 5: unknown name 'foo'"},
        {"2x", "f: column 2: an operator is missing"},
        {"(x + 1", "f: column 1: this '(' is not closed"},
        {"x)", "f: column 2: ')' is not expected here"},
        {"x ** 2", "f: column 4: a value is missing before '*'"},
        {"sin(x, y)", "f: column 1: 'sin' takes 1 value, not 2"},
        {"min(x)", "f: column 1: 'min' takes at least 2 values, not 1"},
        {"a = x", "f: column 6: a ';' is missing after a definition"},
        {"1.2.3", "f: column 1: not a number"},
        {"1e999", "f: column 1: this number is too large"},
        {"x + 1/0", "f: column 8: this number is not finite"},
        {"x\x80", "f: column 2: this is not expected here"},
        {"sqrt(0 - 1) * x", "f: column 12: this number is not finite"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        expression *made = NULL;
        assert_int_equal(expression_create("f", cases[i].text, &made), SNELL_ERR_ARGUMENT);
        assert_null(made);
        assert_string_equal(error_last()->text, cases[i].message);
    }
}

static void refuse_long(char of, size_t count, const char *message) {
    char *text = malloc(count + 1);
    assert_non_null(text);
    memset(text, of, count);
    text[count] = '\0';
    expression *made = NULL;
    assert_int_equal(expression_create("f", text, &made), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, message);
    free(text);
}

static void large_formulas_are_refused(void **state) {
    (void)state;
    refuse_long('x', 1 << 20, "f has 1048576 characters; it must have at most 4096");
    refuse_long('(', 4096, "f: column 65: nested too deep");
    refuse_long('-', 4096, "f: column 65: nested too deep");
    char text[4097] = "x";
    for (int i = 0; i < 700; i++) {
        char part[16];
        snprintf(part, sizeof part, "+%d", i + 2);
        strcat(text, part);
    }
    expression *made = NULL;
    assert_int_equal(expression_create("f", text, &made), SNELL_ERR_ARGUMENT);
    assert_non_null(strstr(error_last()->text, "more than 512 operations"));
}

/* Whatever the formula: values and slopes in a box lie within the bounds for it. */
static void bounds_enclose(void **state) {
    (void)state;
    static const char *const texts[] = {"x^2 + y^2 - z^3",
                                        "x*y/(z + 2.5)",
                                        "sin(5*x)*cos(3*y) + tan(z/4)",
                                        "sqrt(x + 1) - log(y + 2)",
                                        "asin(x/3) + acos(y/2)",
                                        "atan(3*x) * atan2(y, x)",
                                        "exp(x - y^2) - z",
                                        "floor(2*x) + mod(y, 0.7)",
                                        "min(x, y, z) * max(x, -y)",
                                        "clamp(x, -0.5, y)",
                                        "length(x, y, z) - 1",
                                        "smooth_min(x, y, 0.5) + abs(z)",
                                        "(x + 2)^1.7 + (y + 2)^-0.5",
                                        "(x - y)^7 - z^-2",
                                        "abs(x)^y"};
    random_state = 3;
    long tested = 0;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        expression *e = formula_of(texts[i]);
        for (int n = 0; n < 3000; n++) {
            dvec3 low = in_ball((dvec3){0, 0, 0}, 2), d = direction();
            double width = exp2(-between(0, 30)), slope;
            interval box[3] = {
                {low.x, low.x + width}, {low.y, low.y + width}, {low.z, low.z + width}};
            expression_range range;
            expression_over(e, box, &d, 1, &range);
            for (int k = 0; k < 8; k++) {
                double a = uniform(), b = uniform(), c = uniform();
                dvec3 p = {low.x + a * width, low.y + b * width, low.z + c * width};
                double value = expression_at(e, p, &d, 1, &slope);
                if (isnan(value)) {
                    assert_true(range.undefined_somewhere);
                    continue;
                }
                tested++;
                assert_false(range.undefined);
                if (!(value >= range.value.low && value <= range.value.high))
                    fail_msg("%s: %.17g is not in %.17g..%.17g", texts[i], value, range.value.low,
                             range.value.high);
                /* Slopes are not rounded outwards: a few ulps. */
                double slack = 1e-12 * (1 + fabs(slope));
                if (!isnan(slope) && !(slope >= range.derivatives[0].low - slack &&
                                       slope <= range.derivatives[0].high + slack))
                    fail_msg("%s: the slope %.17g is not in %.17g..%.17g", texts[i], slope,
                             range.derivatives[0].low, range.derivatives[0].high);
            }
        }
        expression_destroy(e);
    }
    assert_true(tested > 200000);
}

/* ---- shapes ---- */

static implicit_like solid(const char *f, float half) {
    return (implicit_like){sizeof(implicit_like), f,    {-half, -half, -half},
                           {half, half, half},    true, 0};
}

/* How many of the rays through the box hit. */
static int hits_of(const primitive_type *type, const void *desc, int rays) {
    if (type->check && type->check(desc)) fail_msg("%s", error_last()->text);
    void *shape = type->prepare ? type->prepare(desc) : (void *)(uintptr_t)desc;
    assert_non_null(shape);
    int hits = 0;
    random_state = 5;
    for (int n = 0; n < rays; n++) {
        dvec3 o = dvec3_scale(direction(), 5), to = in_ball((dvec3){0, 0, 0}, 1);
        local_ray beam = {vec3_from(o), vec3_from(dvec3_sub(to, o)), 0, INFINITY};
        hit found;
        if (!type->intersect(shape, &beam, &found)) continue;
        hits++;
        surface s;
        type->surface(shape, &beam, &found, &s);
        assert_true(isfinite(s.p.x + s.p.y + s.p.z + s.n.x + s.error + s.curvature));
    }
    if (type->release) type->release(shape);
    return hits;
}

static bool says(const char *text, const char *wanted) {
    return wanted ? text && strcmp(text, wanted) == 0 : text == NULL;
}

/* What a type says cannot be met is not; and it says so of what is plainly nothing. */
static void what_is_said_to_be_nothing_is_not_hit(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("implicit"), *quadric = primitive_find("quadric");
    static const char *const above = "is nowhere below 0 in its box",
                             *const below = "is below 0 in all of its box, which is not capped";
    const struct {
        const char *f;
        bool capped;
        const char *why;
    } cases[] = {{"x^2 + y^2 + z^2 + 1", true, above},
                 {"x^2 + y^2 + z^2 + 1", false, above},
                 {"x^2 + y^2 + z^2 - 9", false, below},
                 {"x^2 + y^2 + z^2 - 9", true, NULL}, /* the box */
                 {"sqrt(-1 - x^2)", true, above},
                 {"sqrt(x - 2) - 5", true, above}, /* not defined in the box */
                 {"sqrt(x) - 5", false, NULL},     /* is, and below 0, in half of it */
                 {"length(x - 3, y, z) - 1", true, above},
                 {"length(x, y, z) - 1", true, NULL},
                 {"length(x - 0.9, y - 0.9, z - 0.9) - 0.15", true, NULL},
                 {"1", true, above},
                 {"-1", true, NULL}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        implicit_like desc = solid(cases[i].f, 1);
        desc.capped = cases[i].capped;
        const char *why = type->nothing(&desc);
        int hits = hits_of(type, &desc, 200);
        if (!says(why, cases[i].why) || (why && hits))
            fail_msg("%s: %s, %d hits", cases[i].f, why ? why : "something", hits);
    }
    struct {
        size_t struct_size;
        vec3 square, mixed, linear;
        float constant;
        vec3 min, max;
    } ball = {.square = {1, 1, 1}, .min = {-1, -1, -1}, .max = {1, 1, 1}};
    ball.struct_size = quadric->info.desc_size;
    random_state = 11;
    int nothing[2] = {0, 0}, rounds = 400;
    for (int n = 0; n < rounds; n++) {
        char f[256];
        dvec3 c = in_ball((dvec3){0, 0, 0}, 4);
        double radius = between(0.1, 4);
        snprintf(f, sizeof f, "(x - %.9g)^2 + (y - %.9g)^2 + (z - %.9g)^2 - %.9g^2", c.x, c.y, c.z,
                 radius);
        implicit_like desc = solid(f, 1);
        desc.capped = false;
        ball.linear = vec3_from(dvec3_scale(c, -2));
        ball.constant = (float)(dvec3_dot(c, c) - radius * radius);
        uint64_t kept = random_state;
        const void *both[2] = {&desc, &ball};
        const primitive_type *types[2] = {type, quadric};
        for (int k = 0; k < 2; k++) {
            bool none = types[k]->nothing(both[k]) != NULL;
            nothing[k] += none;
            if (none) assert_int_equal(hits_of(types[k], both[k], 500), 0);
            /* The surface passes through the box's middle half. */
            if (fabs(dvec3_length(c) - radius) < 0.5) assert_false(none);
        }
        random_state = kept;
    }
    for (int k = 0; k < 2; k++) assert_in_range(nothing[k], rounds / 5, rounds * 4 / 5);
}

/* What never changes its sign, never has one, or has it everywhere in doubt. */
static void odd_formulas_take_bounded_time(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("implicit");
    const struct {
        const char *f;
        int least, most; /* hits of 200 rays */
    } cases[] = {
        {"1", 0, 0},
        {"-1", 200, 200},
        {"0", 0, 0},
        {"x - x", 0, 0},
        {"sqrt(0-1-x^2)", 0, 0},
        {"1/x", 150, 200},
        {"x*0", 0, 0},
        {"sin(1e6*x)", 150, 200},
        {"floor(4*x) + 0.5", 150, 200},
        {"log(x)", 60, 200},
        {"abs(x) - abs(x) + y", 150, 200},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        implicit_like desc = solid(cases[i].f, 1);
        int hits = hits_of(type, &desc, 200);
        if (hits < cases[i].least || hits > cases[i].most) fail_msg("%s: %d", cases[i].f, hits);
    }
}

/* Sheets down to the thickness that level_set.h promises to find. */
static void thin_sheets_are_found(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("implicit");
    for (int power = 4; power <= 20; power += 4) {
        char f[64];
        snprintf(f, sizeof f, "abs(x + 0.3*y + 0.1) - %.17g", exp2(-power));
        implicit_like desc = solid(f, 1);
        desc.capped = false;
        assert_int_equal(type->check(&desc), SNELL_OK);
        void *shape = type->prepare(&desc);
        for (int n = 0; n < 2000; n++) {
            dvec3 to = {0, between(-0.9, 0.9), between(-0.9, 0.9)};
            to.x = -0.3 * to.y - 0.1;
            local_ray beam = {{3, 0, 0}, vec3_from(dvec3_sub(to, (dvec3){3, 0, 0})), 0, INFINITY};
            hit found;
            assert_true(type->intersect(shape, &beam, &found));
            assert_true(fabs((double)found.t - 1) < exp2(-power) * 2 + 1e-6);
        }
        type->release(shape);
    }
}

static void refuse(const primitive_type *type, void *desc, const char *text) {
    snell_status status = desc_check(&type->info, desc, NULL);
    if (!status) status = type->check(desc);
    assert_int_equal(status, SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, text);
}

static void senseless_fields_are_refused(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("implicit");
    implicit_like cube = solid("x +", 1);
    refuse(type, &cube, "implicit: 'f': column 4: a value is missing");
    cube = solid("2*x", 1);
    cube.lipschitz = 1;
    assert_int_equal(type->check(&cube), SNELL_ERR_ARGUMENT);
    assert_non_null(strstr(error_last()->text, "'lipschitz' is 1, but f changes by 2 per metre"));
    cube.lipschitz = 2;
    assert_int_equal(type->check(&cube), SNELL_OK);
    cube.max.y = -1;
    refuse(type, &cube, "implicit: 'min' y is -1 and 'max' y is -1");

    type = primitive_find("blob");
    vec3 points[2] = {{0, 0, 0}, {1, 0, 0}};
    vec2 sizes[2] = {{1, 1}, {0, 1}};
    blob_like blob = {sizeof blob, points, 0, 1, 1, NULL, 0, 0.5f};
    refuse(type, &blob, "blob: 'points' has 0 points; it must have 1 to 1048576");
    blob.points_count = 2;
    blob.sizes = sizes;
    blob.sizes_count = 1;
    refuse(type, &blob, "blob: 'sizes' has 1 entries for 2 points");
    blob.sizes_count = 2;
    refuse(type, &blob, "blob: the radius of point 2 is 0; it must be greater than 0");
    sizes[1].x = NAN;
    refuse(type, &blob, "blob: 'sizes' 1 is not a finite number");

    type = primitive_find("julia");
    julia_like julia = {sizeof julia, {-0.2f, 0.6f, 0.2f}, 0.2f, 0, 9, 1};
    refuse(type, &julia,
           "julia: 'escape' is 1; with this constant it must be greater than 1.47099");
}

static void blobs_of_any_number(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("blob");
    enum { MANY = 5000 };
    static vec3 points[MANY];
    blob_like blob = {sizeof blob, points, 1, 1, 1, NULL, 0, 2};
    assert_int_equal(hits_of(type, &blob, 200), 0); /* a threshold that nothing reaches */
    blob.strength = -1;
    blob.threshold = 0.1f;
    assert_int_equal(hits_of(type, &blob, 200), 0);
    assert_true(bounds3_is_empty(type->bounds(&blob)));
    blob.strength = 1;
    blob.points_count = 1000; /* all in one place, more rims than a stretch takes */
    blob.threshold = 999.0f / 2;
    assert_true(hits_of(type, &blob, 200) > 20);
    random_state = 9; /* and a cloud, of which every ray meets few */
    for (int i = 0; i < MANY; i++) points[i] = vec3_from(in_ball((dvec3){0, 0, 0}, 1));
    blob.points_count = MANY;
    blob.radius = 0.05f;
    blob.threshold = 0.5f;
    assert_true(hits_of(type, &blob, 20000) > 2000);
}

/* What a commit is said to take counts these. */
static void prepared_shapes_take_what_they_say(void **state) {
    (void)state;
    enum { MANY = 5000 };
    static vec3 points[MANY];
    random_state = 4;
    for (int i = 0; i < MANY; i++) points[i] = vec3_from(in_ball((dvec3){0, 0, 0}, 1));
    const implicit_like bowl = solid("x*x + y*y - z", 1);
    const blob_like blob = {sizeof blob, points, MANY, 0.05f, 1, NULL, 0, 0.5f};
    const julia_like julia = {sizeof julia, {-0.2f, 0.6f, 0.2f}, 0.2f, 0, 9, 4};
    const void *const descs[] = {&bowl, &blob, &julia};
    const char *const names[] = {"implicit", "blob", "julia"};
    uint32_t known = 0;
    for (int i = 0; i < 3; i++) {
        const primitive_type *type = primitive_find(names[i]);
        size_t said = type->prepared_size(descs[i]);
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
        struct mallinfo2 before = mallinfo2();
        void *made = type->prepare(descs[i]);
        struct mallinfo2 after = mallinfo2();
        size_t taken = after.uordblks + after.hblkhd - before.uordblks - before.hblkhd;
        assert_non_null(made);
        assert_true(taken > 0 && taken <= said + 256 && said <= 8 * taken);
        type->release(made);
#endif
        assert_true(said > 0);
    }
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        const primitive_type *type = primitive_types[i];
        assert_true((type->prepare == NULL) == (type->prepared_size == NULL));
        known += type->prepare != NULL;
    }
    assert_int_equal(known, 3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_formula_means_what_it_says),
        cmocka_unit_test(mistakes_are_shown_by_their_column),
        cmocka_unit_test(large_formulas_are_refused),
        cmocka_unit_test(bounds_enclose),
        cmocka_unit_test(what_is_said_to_be_nothing_is_not_hit),
        cmocka_unit_test(odd_formulas_take_bounded_time),
        cmocka_unit_test(thin_sheets_are_found),
        cmocka_unit_test(senseless_fields_are_refused),
        cmocka_unit_test(blobs_of_any_number),
        cmocka_unit_test(prepared_shapes_take_what_they_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
