/* FLIP against the authors' own implementation: tests/flip_values.py made the numbers. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "image/flip.h"
#include "image/srgb.h"

enum pattern { GRADIENT, CHECKER, NOISE, DISC, STRIPES };
enum change { BRIGHTER, NOISY, SHIFTED, COARSE, SWAPPED, DARK_SPOT };

static const struct pair {
    enum pattern pattern;
    enum change change;
    uint32_t seed, width, height;
    bool hdr;
    double pixels_per_degree, mean, at[3];
} pairs[] = {
#include "flip_values.inc"
};
enum { PAIRS = sizeof pairs / sizeof pairs[0] };

/* ---- the pictures, as in flip_values.py ---- */

static uint32_t mixed(uint32_t x, uint32_t y, uint32_t c, uint32_t seed) {
    uint32_t h = x * 73856093u ^ y * 19349663u ^ c * 83492791u ^ seed * 2654435761u;
    h ^= h >> 13;
    h *= 0x5bd1e995u;
    return h ^ h >> 15;
}

static int pattern_at(const struct pair *p, uint32_t x, uint32_t y, uint32_t c) {
    static const int inside[] = {230, 120, 40}, outside[] = {20, 60, 110};
    uint32_t w = p->width, h = p->height;
    int64_t dx = 2 * (int64_t)x - w, dy = 2 * (int64_t)y - h;
    switch (p->pattern) {
    case GRADIENT: return (int)((x * 255 / w + y * 255 / h * (c + 1) / 3) % 256);
    case CHECKER: return (x / 6 + y / 6) % 2 ? 210 - 30 * (int)c : 25 + 20 * (int)c;
    case NOISE: return (int)(mixed(x, y, c, p->seed) % 256);
    case DISC: return dx * dx + dy * dy < (int64_t)w * h / 2 ? inside[c] : outside[c];
    default: return (x + 2 * y + c) % (3 + p->seed % 5) == 0 ? 255 : 40;
    }
}

static int clamped(int value) { return value < 0 ? 0 : value > 255 ? 255 : value; }

static int changed_at(const struct pair *p, uint32_t x, uint32_t y, uint32_t c) {
    uint32_t w = p->width, h = p->height;
    int value = pattern_at(p, x, y, c);
    switch (p->change) {
    case SHIFTED: return pattern_at(p, x < 2 ? 0 : x - 2, y, c);
    case SWAPPED: return pattern_at(p, x, y, (c + 1) % 3);
    case BRIGHTER: return clamped(value + 24);
    case NOISY: return clamped(value + (int)(mixed(x, y, c, p->seed + 99) % 41) - 20);
    case COARSE: return value / 64 * 64;
    default: return x >= w / 3 && x < w / 2 && y >= h / 3 && y < (h + 1) / 2 ? value / 4 : value;
    }
}

typedef struct source {
    const struct pair *pair;
    bool changed;
} source;

static void read_source(const void *user, uint32_t x, uint32_t y, uint32_t count, float *rgb) {
    const source *s = user;
    for (uint32_t i = 0; i < count; i++) {
        int stops = (int)(mixed((x + i) / 8, y / 8, 7, s->pair->seed) % 8);
        for (uint32_t c = 0; c < 3; c++) {
            int value =
                s->changed ? changed_at(s->pair, x + i, y, c) : pattern_at(s->pair, x + i, y, c);
            rgb[3 * i + c] = s->pair->hdr ? (float)ldexp(value / 64.0, stops) : srgb_table()[value];
        }
    }
}

static thread_pool *pool;

static int set_up(void **state) {
    (void)state;
    return thread_pool_create(3, &pool) == SNELL_OK ? 0 : -1;
}

static int tear_down(void **state) {
    (void)state;
    thread_pool_destroy(pool);
    return 0;
}

static snell_status compare(const source *a, const source *b, flip_options options,
                            thread_pool *workers, float **map) {
    *map = malloc(sizeof(float) * options.width * options.height);
    assert_non_null(*map);
    flip_picture left = {read_source, a}, right = {read_source, b};
    return flip_map(&left, &right, &options, workers, *map);
}

static double mean_of(const float *map, const struct pair *p) {
    double sum = 0;
    for (size_t i = 0; i < (size_t)p->width * p->height; i++) sum += (double)map[i];
    return sum / ((double)p->width * p->height);
}

/* Four digits: the published implementation computes with floats. */
static bool agrees(double got, double wanted) { return fabs(got - wanted) <= 5e-5 * wanted; }

static void agrees_with_the_published_flip(void **state) {
    (void)state;
    int eight_bit = 0, bad = 0;
    double worst = 0;
    for (int i = 0; i < PAIRS; i++) {
        const struct pair *p = &pairs[i];
        source a = {p, false}, b = {p, true};
        flip_options options = {.width = p->width,
                                .height = p->height,
                                .hdr = p->hdr,
                                .pixels_per_degree = p->pixels_per_degree};
        float *map;
        assert_int_equal(compare(&a, &b, options, pool, &map), SNELL_OK);
        double mean = mean_of(map, p);
        double at[3] = {(double)map[p->height / 2 * p->width + p->width / 2],
                        (double)map[p->height / 3 * p->width + p->width / 3],
                        (double)map[p->height / 5 * p->width + p->width - 1]};
        bool good = agrees(mean, p->mean);
        for (int k = 0; k < 3; k++) good &= fabs(at[k] - p->at[k]) < 2e-4;
        if (!good) {
            bad++;
            print_error("pair %d: mean %.7f, not %.7f; %.6f %.6f %.6f, not %.6f %.6f %.6f\n", i,
                        mean, p->mean, at[0], at[1], at[2], p->at[0], p->at[1], p->at[2]);
        }
        if (p->mean > 0 && fabs(mean / p->mean - 1) > worst) worst = fabs(mean / p->mean - 1);
        eight_bit += !p->hdr;
        free(map);
    }
    print_message("%d pairs, the means within %.1e\n", PAIRS, worst);
    assert_true(eight_bit >= 20);
    assert_int_equal(bad, 0);
}

static void bits_do_not_depend_on_threads(void **state) {
    (void)state;
    thread_pool *one;
    assert_int_equal(thread_pool_create(1, &one), SNELL_OK);
    for (int hdr = 0; hdr < 2; hdr++) {
        struct pair p = {NOISE, SHIFTED, 3, 300, 150, hdr, 67, 0, {0}};
        source a = {&p, false}, b = {&p, true};
        flip_options options = {
            .width = p.width, .height = p.height, .hdr = hdr, .pixels_per_degree = 67};
        float *many, *single;
        assert_int_equal(compare(&a, &b, options, pool, &many), SNELL_OK);
        assert_int_equal(compare(&a, &b, options, one, &single), SNELL_OK);
        assert_memory_equal(many, single, sizeof(float) * p.width * p.height);
        free(many);
        free(single);
        assert_int_equal(compare(&a, &a, options, pool, &many), SNELL_OK);
        for (size_t i = 0; i < (size_t)p.width * p.height; i++) assert_true(many[i] == 0);
        free(many);
    }
    thread_pool_destroy(one);
}

/* One colour, but for the pixel 3,0. */
static void read_spot(const void *user, uint32_t x, uint32_t y, uint32_t count, float *rgb) {
    const float *value = user;
    for (uint32_t i = 0; i < 3 * count; i++) rgb[i] = value[y == 0 && x + i / 3 == 3];
}

/* Every range of brightness gives numbers: black, black but for a spot, the brightest floats. */
static void hdr_takes_any_range(void **state) {
    (void)state;
    static const float values[][2] = {{0, 0},           {0, 1},         {0, 3e38f}, {1e-30f, 3e38f},
                                      {1e-45f, 1e-45f}, {3e38f, 3e38f}, {5, 5}};
    enum { COUNT = sizeof values / sizeof values[0] };
    flip_options options = {.width = 9, .height = 5, .hdr = true, .pixels_per_degree = 67};
    float map[9 * 5];
    for (int i = 0; i < COUNT; i++)
        for (int k = 0; k < COUNT; k++) {
            flip_picture a = {read_spot, values[i]}, b = {read_spot, values[k]};
            assert_int_equal(flip_map(&a, &b, &options, pool, map), SNELL_OK);
            double sum = 0;
            for (int at = 0; at < 45; at++) {
                assert_true(map[at] >= 0 && map[at] <= 1);
                sum += (double)map[at];
            }
            if (i == k) assert_true(sum == 0);
        }
    flip_picture a = {read_spot, values[0]}, b = {read_spot, values[1]};
    assert_int_equal(flip_map(&a, &b, &options, pool, map), SNELL_OK);
    assert_true(map[3] > 0.5f && map[0] < map[3]); /* the spot is seen, also on a black reference */
}

static int calls;
static bool stop_at_third(void *user, double fraction) {
    (void)user;
    assert_true(fraction >= 0 && fraction <= 1);
    return ++calls < 3;
}

static void can_be_stopped(void **state) {
    (void)state;
    struct pair p = {CHECKER, NOISY, 1, 700, 700, false, 67, 0, {0}};
    source a = {&p, false}, b = {&p, true};
    flip_options options = {
        .width = p.width, .height = p.height, .pixels_per_degree = 67, .progress = stop_at_third};
    float *map;
    assert_int_equal(compare(&a, &b, options, pool, &map), SNELL_CANCELLED);
    assert_int_equal(calls, 3);
    free(map);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_the_published_flip),
        cmocka_unit_test(bits_do_not_depend_on_threads),
        cmocka_unit_test(hdr_takes_any_range),
        cmocka_unit_test(can_be_stopped),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
