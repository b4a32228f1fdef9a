/* Rendering until a stated error or a time limit: the bound is honest, and the picture is a function of
 * the bound and the most samples, whatever the threads and whenever time ran out. */
#include <string.h>

#include "../bench/noise.h"
#include "render_test.h"

enum { SIDE = 40 /* blocks at the right and the bottom are cut */ };

/* A lamp over a matt floor, with a ball in its light: soft shadow, edges, an empty sky. */
static rig make(uint32_t threads, snell_isa isa) {
    rig r = rig_make(threads, isa);
    add_quad(&r, v3(-0.5, 2, -0.5), v3(1, 0, 0), v3(0, 0, 1), add_glow(&r, grey(8)));
    add_plane(&r, v3(0, 0, 0), v3(0, 1, 0), add_lambert(&r, v3(0.7, 0.6, 0.5)));
    add_sphere(&r, v3(0.2, 0.5, 0), 0.5, add_lambert(&r, v3(0.2, 0.4, 0.7)));
    MUST(snell_scene_set_background(r.scene, v3(0.2, 0.3, 0.4), 1));
    MUST(snell_scene_commit(r.scene, NULL, NULL));
    return r;
}

static snell_view view;

static snell_render_desc with_noise(double noise, uint32_t samples) {
    snell_render_desc desc = picture(SNELL_PATH, SIDE, SIDE, 3);
    view = look(v3(0, 1.2, 4), v3(0, 0.8, 0));
    desc.view = &view;
    desc.pixel_center = false;
    desc.samples = samples;
    desc.noise = (float)noise;
    return desc;
}

static uint64_t render(rig *r, const snell_render_desc *desc) {
    MUST(snell_render(r->scene, desc, r->film));
    return snell_film_hash(r->film);
}

static void same_bits(void **state) {
    (void)state;
    static uint32_t samples[SIDE * SIDE];
    static float variance[SIDE * SIDE * 3];
    snell_render_desc desc = with_noise(0.05, 256);
    rig r = make(1, SNELL_ISA_SCALAR);
    uint64_t hash = render(&r, &desc);
    snell_render_stats one = stats_of(&r);
    memcpy(samples, snell_film_samples(r.film), sizeof samples);
    memcpy(variance, snell_film_variance(r.film), sizeof variance);
    rig_free(&r);
    assert_true(one.samples_min < one.samples_done);
    for (uint32_t threads = 2; threads <= 5; threads += 3) {
        r = make(threads, SNELL_ISA_AUTO);
        desc.wave_size = threads == 2 ? 7 : 0;
        assert_int_equal(render(&r, &desc), hash);
        assert_memory_equal(snell_film_samples(r.film), samples, sizeof samples);
        assert_memory_equal(snell_film_variance(r.film), variance, sizeof variance);
        snell_render_stats many = stats_of(&r);
        assert_true(many.noise_bound == one.noise_bound);
        assert_int_equal(many.noise_blocks_done, one.noise_blocks_done);
        rig_free(&r);
    }
}

/* Counts are decision points or the most; what was reached is what the film says. */
static void counts(void **state) {
    (void)state;
    rig r = make(2, SNELL_ISA_AUTO);
    snell_render_desc desc = with_noise(0.02, 203);
    uint64_t hash = render(&r, &desc);
    snell_render_stats s = stats_of(&r);
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        uint32_t n = snell_film_samples(r.film)[i];
        assert_true(n == 200 || (n >= 16 && noise_next_count(n - 1) == n));
        assert_true(n >= s.samples_min && n <= s.samples_done);
        assert_int_equal(
            n, snell_film_samples(r.film)[i / SIDE / 16 * 16 * SIDE + i % SIDE / 16 * 16]);
        sum += n;
    }
    ASSERT_CLOSE(s.samples_mean, sum / SIDE / SIDE, 1e-12, 0);
    assert_int_equal(s.samples_done, 200);
    assert_int_equal(s.pixels_done, SIDE * SIDE);
    assert_int_equal(s.noise_blocks, 9);
    assert_true(s.noise_blocks_done < 9 && s.noise_bound > 0.02 && s.noise_confidence == 0.95);
    desc.samples = 200;
    assert_int_equal(render(&r, &desc), hash);
    desc.noise = 0.2f; /* every block is under it: then the most samples do not matter */
    hash = render(&r, &desc);
    s = stats_of(&r);
    assert_int_equal(s.noise_blocks_done, 9);
    assert_true(s.noise_bound <= 0.2 && s.samples_done < 200);
    desc.samples = (uint32_t)s.samples_done;
    assert_int_equal(render(&r, &desc), hash);
    desc.samples = 100000;
    assert_int_equal(render(&r, &desc), hash);
    assert_int_equal(noise_next_count(0), 16);
    assert_int_equal(noise_next_count(16), 24);
    assert_int_equal(noise_next_count(24), 32);
    assert_int_equal(noise_next_count(33), 48);
    rig_free(&r);
}

/* Ended by time, with and without a noise, at whatever number of samples: -n makes it again. */
static void time_limit(void **state) {
    (void)state;
    rig r = make(2, SNELL_ISA_AUTO);
    for (int i = 0; i < 6; i++) {
        snell_render_desc desc = with_noise(i % 2 ? 0.001 : 0, 1 << 20);
        desc.time_limit = i < 2 ? 1e-6 : 0.03 * i;
        uint64_t hash = render(&r, &desc);
        snell_render_stats s = stats_of(&r);
        assert_in_range(s.samples_done, i % 2 ? 4 : 2, (1 << 20) - 1);
        assert_int_equal(s.pixels_done, SIDE * SIDE);
        if (i < 2) assert_int_equal(s.samples_done, i % 2 ? 4 : 2);
        desc.time_limit = 0;
        desc.samples = (uint32_t)s.samples_done;
        assert_int_equal(render(&r, &desc), hash);
        if (i % 2 == 0) continue;
        snell_render_stats again = stats_of(&r);
        assert_true(again.noise_bound == s.noise_bound);
    }
    snell_render_desc desc = with_noise(0, 3); /* the samples come first */
    desc.time_limit = 1000;
    uint64_t hash = render(&r, &desc);
    desc.time_limit = 0;
    assert_int_equal(render(&r, &desc), hash);
    rig_free(&r);
}

/* A filtered texture's footprint depends on the number of samples, which is not known at first. */
static void time_limit_of_textures(void **state) {
    (void)state;
    rig r = rig_make(2, SNELL_ISA_AUTO);
    MUST(snell_scene_load(r.scene, TEST_SOURCE_DIR "/scenes/motion-blur.lua", NULL));
    MUST(snell_scene_commit(r.scene, NULL, NULL));
    for (int i = 0; i < 2; i++) {
        snell_render_desc desc = SNELL_INIT(render_desc);
        MUST(snell_scene_settings(r.scene, 0, &desc));
        desc.width = 24;
        desc.height = 18;
        desc.samples = 1 << 20;
        desc.time_limit = i ? 0.2 : 1e-6;
        uint64_t hash = render(&r, &desc);
        desc.samples = (uint32_t)stats_of(&r).samples_done;
        if (i == 0) assert_int_equal(desc.samples, 2);
        desc.time_limit = 0;
        assert_int_equal(render(&r, &desc), hash);
    }
    rig_free(&r);
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Of (block, seed) pairs at least the stated share has its true error within the bound; and the bound
 * does not exaggerate. Where no block retires, the mean of the variances is that of the pictures. */
static float reference[SIDE * SIDE * 3];

static void make_reference(rig *r) {
    snell_render_desc desc = with_noise(1e-9, 8192);
    desc.seed = 4711;
    render(r, &desc);
    memcpy(reference, snell_film_pixels(r->film, NULL, NULL, NULL), sizeof reference);
}

static void honest(void **state) {
    (void)state;
    enum { SEEDS = 40, BLOCKS = 9 };
    static double ratios[SEEDS * BLOCKS];
    rig r = make(0, SNELL_ISA_AUTO);
    make_reference(&r);
    snell_render_desc desc = with_noise(0.05, 384);
    int within = 0, count = 0;
    for (uint32_t seed = 1; seed <= SEEDS; seed++) {
        desc.seed = seed;
        render(&r, &desc);
        const float *pixels = snell_film_pixels(r.film, NULL, NULL, NULL);
        double mean = noise_image_mean(pixels, SIDE, SIDE), bound, error;
        for (uint32_t i = 0; i < BLOCKS; i++) {
            noise_measure_block(r.film, reference, i % 3, i / 3, mean, &bound, &error);
            within += error <= bound + 1e-6;
            if (error > 1e-6) ratios[count++] = error / bound;
        }
    }
    qsort(ratios, (size_t)count, sizeof *ratios, ascending);
    print_message("within %d of %d, median of true / stated %.3f\n", within, SEEDS * BLOCKS,
                  ratios[count / 2]);
    assert_true(within >= 0.95 * SEEDS * BLOCKS);
    assert_true(ratios[count / 2] >= 1.0 / 3);
    rig_free(&r);
}

static void unbiased(void **state) {
    (void)state;
    rig r = make(0, SNELL_ISA_AUTO);
    make_reference(&r);
    snell_render_desc desc = with_noise(1e-9, 24);
    double stated = 0, found = 0;
    for (desc.seed = 1; desc.seed <= 60; desc.seed++) {
        render(&r, &desc);
        for (int i = 0; i < SIDE * SIDE * 3; i++) {
            double off =
                (double)snell_film_pixels(r.film, NULL, NULL, NULL)[i] - (double)reference[i];
            stated += (double)snell_film_variance(r.film)[i];
            found += off * off;
        }
    }
    print_message("variance stated / found %.4f\n", stated / found);
    ASSERT_CLOSE(stated / found, 1, 0.03, 0);
    rig_free(&r);
}

/* The probability that F with n and 3 n degrees of freedom is under q, by its density (n even). */
static double f_below(double q, double n) {
    double a = n / 2, b = 3 * n / 2, x = q / (q + 3), sum = 0;
    double scale = lgamma(a + b) - lgamma(a) - lgamma(b);
    enum { STEPS = 200000 };
    for (int i = 0; i < STEPS; i++) {
        double t = (i + 0.5) * x / STEPS;
        sum += exp(scale + (a - 1) * log(t) + (b - 1) * log1p(-t));
    }
    return sum * x / STEPS;
}

/* n pixels that share one variance: the bound is that variance times F's quantile, or a little more. */
static void quantiles(void **state) {
    (void)state;
    for (double n = 2; n <= 64; n += n < 8 ? 1 : n / 4) {
        noise_sums s = {.light = 3 * 256, .variance = 3 * 256, .pixels = 256};
        s.squares = 5.0 / 3 / 4 * s.variance * s.variance / n; /* a quarter counts */
        double factor = noise_bound(&s, 1 << 20, 0), below = f_below(factor * factor, n);
        if (below < 0.975 - 1e-4 || below > 0.985) print_error("n %g: %g\n", n, below);
        assert_true(below >= 0.975 - 1e-4 && below <= 0.985);
    }
    noise_sums none = {.light = 5, .pixels = 256},
               dark = {.variance = 1, .squares = 1, .pixels = 4};
    assert_true(noise_bound(&none, 16, 0) == 3.0 / (16 * 256));
    assert_true(isinf(noise_bound(&dark, 16, 0)));
}

/* The rays of a pixel add up to it, however many samples its block got. */
static void explained(void **state) {
    (void)state;
    rig r = make(2, SNELL_ISA_AUTO);
    snell_render_desc desc = with_noise(0.1, 64);
    desc.transparent = true;
    desc.crop_x = 5;
    desc.crop_y = 9;
    desc.crop_width = 30;
    desc.crop_height = 20;
    render(&r, &desc);
    const float *pixels = snell_film_pixels(r.film, NULL, NULL, NULL);
    for (uint32_t y = 0; y < 20; y += 6)
        for (uint32_t x = 0; x < 30; x += 7) {
            snell_explain_desc at = SNELL_INIT(explain_desc);
            snell_explanation *e;
            at.x = x;
            at.y = y;
            at.samples = snell_film_samples(r.film)[y * 30 + x];
            MUST(snell_explain(r.scene, &desc, &at, &e));
            uint32_t channels, count;
            const float *got = snell_explanation_pixel(e, &channels);
            snell_explanation_samples(e, &count);
            assert_int_equal(count, at.samples);
            assert_int_equal(channels, 4);
            assert_memory_equal(got, pixels + 4 * (y * 30 + x), 4 * sizeof(float));
            snell_explanation_destroy(e);
        }
    snell_explain_desc at = SNELL_INIT(explain_desc);
    snell_explanation *e;
    static const uint32_t wrong[] = {0, 2, 18, 68};
    for (int i = 0; i < 4; i++) {
        at.samples = wrong[i];
        assert_int_equal(snell_explain(r.scene, &desc, &at, &e), SNELL_ERR_ARGUMENT);
    }
    desc.noise = 0;
    at.samples = 32;
    assert_int_equal(snell_explain(r.scene, &desc, &at, &e), SNELL_ERR_ARGUMENT);
    rig_free(&r);
}

static bool until_known(void *user, const snell_progress *p) {
    (void)user;
    return !(p->noise > 0);
}

/* Stopped in the midst of a round: every block has a whole number of rounds. */
static void cancelled(void **state) {
    (void)state;
    rig r = make(2, SNELL_ISA_AUTO);
    snell_render_desc desc = with_noise(1e-6, 1 << 20);
    desc.progress = until_known;
    assert_int_equal(snell_render(r.scene, &desc, r.film), SNELL_CANCELLED);
    snell_render_stats s = stats_of(&r);
    assert_int_equal(s.pixels_done, SIDE * SIDE);
    assert_true(s.samples_min >= 4 && s.samples_done < 1 << 20);
    for (int i = 0; i < SIDE * SIDE; i++) {
        uint32_t n = snell_film_samples(r.film)[i];
        assert_true(n >= s.samples_min && n <= s.samples_done && noise_next_count(n - 1) == n);
    }
    rig_free(&r);
}

static void bad_values(void **state) {
    (void)state;
    static const double noises[] = {-0.01, 1.01, NAN, INFINITY}, limits[] = {-1, NAN};
    rig r = make(1, SNELL_ISA_AUTO);
    snell_render_desc desc;
    for (size_t i = 0; i < sizeof noises / sizeof noises[0]; i++) {
        desc = with_noise(noises[i], 64);
        assert_int_equal(snell_render(r.scene, &desc, r.film), SNELL_ERR_ARGUMENT);
    }
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        desc = with_noise(0, 64);
        desc.time_limit = limits[i];
        assert_int_equal(snell_render(r.scene, &desc, r.film), SNELL_ERR_ARGUMENT);
    }
    desc = with_noise(0.1, 3);
    assert_int_equal(snell_render(r.scene, &desc, r.film), SNELL_ERR_ARGUMENT);
    desc = with_noise(0, 3);
    render(&r, &desc);
    assert_null(snell_film_variance(r.film));
    assert_null(snell_film_samples(r.film));
    rig_free(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_bits),  cmocka_unit_test(counts),
        cmocka_unit_test(time_limit), cmocka_unit_test(time_limit_of_textures),
        cmocka_unit_test(honest),     cmocka_unit_test(unbiased),
        cmocka_unit_test(quantiles),  cmocka_unit_test(explained),
        cmocka_unit_test(cancelled),  cmocka_unit_test(bad_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
