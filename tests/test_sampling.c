/* Warps: the densities that they promise, measured in cells of equal measure. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "maths/functions.h"
#include "sampling/warp.h"

enum { N = 4096, CELLS = 16 };

static sample2 point(uint32_t i) { return sample_point(0x1234567, i); }

/* Every count within `slack` of N / CELLS: the points are a net, so that is far less than chance. */
static void check_even(const uint32_t *counts, uint32_t slack) {
    for (int i = 0; i < CELLS; i++) {
        assert_in_range(counts[i], N / CELLS - slack, N / CELLS + slack);
    }
}

static unsigned cell_of(double x) {
    assert_true(x >= 0 && x <= 1);
    return x < 1 ? (unsigned)(x * CELLS) : CELLS - 1;
}

static void disk_is_uniform(void **state) {
    (void)state;
    uint32_t by_radius[CELLS] = {0}, by_angle[CELLS] = {0};
    for (uint32_t i = 0; i < N; i++) {
        sample2 d = warp_disk(point(i));
        by_radius[cell_of(d.x * d.x + d.y * d.y)]++;
        by_angle[cell_of((fn_atan2(d.y, d.x) + PI) / (2 * PI))]++;
    }
    check_even(by_radius, 24);
    check_even(by_angle, 24);
    sample2 centre = warp_disk((sample2){0.5, 0.5}), right = warp_disk((sample2){1, 0.5});
    assert_true(centre.x == 0 && centre.y == 0 && right.x == 1 && right.y == 0);
}

static void hemisphere_and_cone(void **state) {
    (void)state;
    uint32_t by_sine[CELLS] = {0}, by_height[CELLS] = {0};
    const double angle = 0.001, gap = 2 * fn_sin(angle / 2) * fn_sin(angle / 2); /* 1 - cos */
    for (uint32_t i = 0; i < N; i++) {
        dvec3 h = warp_cosine_hemisphere(point(i));
        assert_true(h.z >= 0 && fabs(dvec3_length(h) - 1) < 1e-12);
        by_sine[cell_of(1 - h.z * h.z)]++; /* sin^2 is uniform under cos / pi */
        dvec3 c = warp_cone(point(i), gap);
        assert_true(fabs(dvec3_length(c) - 1) < 1e-12);
        by_height[cell_of((c.x * c.x + c.y * c.y) / (gap * (2 - gap)))]++;
    }
    check_even(by_sine, 24);
    check_even(by_height, 24);
    dvec3 down = warp_cone((sample2){1, 0}, 2);
    assert_true(down.z == -1 && down.x == 0);
}

static void triangle_and_polygon(void **state) {
    (void)state;
    uint32_t side[5] = {0}, by_height[CELLS] = {0};
    double inner = 0;
    for (uint32_t i = 0; i < N; i++) {
        sample2 b = warp_triangle(point(i));
        assert_true(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1);
        by_height[cell_of((b.x + b.y) * (b.x + b.y))]++;
        sample2 p = warp_polygon(point(i), 5, 0.3);
        double turn = (fn_atan2(p.y, p.x) - 0.3) / (2 * PI);
        side[(unsigned)(5 * (turn - floor(turn))) % 5]++;
        inner += p.x * p.x + p.y * p.y < 0.25 ? 1 : 0;
    }
    check_even(by_height, 24);
    for (int i = 0; i < 5; i++) assert_in_range(side[i], N / 5 - 20, N / 5 + 20);
    /* A disk of radius 1/2 lies within the pentagon: its share of the area. */
    assert_true(fabs(inner / N - 0.25 * PI / (2.5 * fn_sin(2 * PI / 5))) < 0.01);
    sample2 corner = warp_polygon((sample2){0, 0}, 6, PI / 2);
    assert_true(fabs(corner.x) < 1e-12 && fabs(corner.y) < 1e-12);
}

static void tent_inverts_its_distribution(void **state) {
    (void)state;
    for (int i = 0; i <= 100; i++) {
        double x = warp_tent(i / 100.0);
        double cdf = x < 0 ? (1 + x) * (1 + x) / 2 : 1 - (1 - x) * (1 - x) / 2;
        assert_true(fabs(cdf - i / 100.0) < 1e-12);
    }
}

static void distributions(void **state) {
    (void)state;
    const double weights[] = {0, 1, 0, 2, 5, 0};
    distribution1 d;
    assert_true(distribution1_build(weights, 6, &d));
    double counts[6] = {0};
    for (uint32_t i = 0; i < N; i++) {
        uint32_t cell;
        double pdf, x = distribution1_sample(&d, (i + 0.5) / N, &cell, &pdf);
        assert_true(weights[cell] > 0 && x >= cell / 6.0 - 1e-12 && x <= (cell + 1) / 6.0 + 1e-12);
        assert_true(fabs(pdf - weights[cell] / 8 * 6) < 1e-12);
        counts[cell]++;
    }
    for (int i = 0; i < 6; i++) assert_true(fabs(counts[i] / N - weights[i] / 8) < 1.0 / N);
    uint32_t cell;
    distribution1_sample(&d, 0, &cell, NULL);
    assert_int_equal(cell, 1);
    distribution1_sample(&d, 1 - 0x1p-53, &cell, NULL);
    assert_int_equal(cell, 4);
    distribution1_free(&d);
    const double nothing[] = {0, 0};
    assert_true(distribution1_build(nothing, 2, &d));
    assert_true(distribution1_sample(&d, 0.75, &cell, NULL) == 0.75 && cell == 1);
    distribution1_free(&d);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(disk_is_uniform), cmocka_unit_test(hemisphere_and_cone),
        cmocka_unit_test(triangle_and_polygon), cmocka_unit_test(tent_inverts_its_distribution),
        cmocka_unit_test(distributions)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
