/* snell_explain: the rays behind a pixel add up to it, and say how. */
#include "render_test.h"

static rig bench;

static int start(void **state) {
    (void)state;
    bench = rig_make(0, SNELL_ISA_AUTO);
    return 0;
}

static int stop(void **state) {
    (void)state;
    rig_free(&bench);
    return 0;
}

/* As the film adds: each contribution cut off below 2^-80. */
__extension__ typedef __int128 fixed;
static fixed to_fixed(double value) {
    int exponent;
    double mantissa = frexp(value, &exponent);
    fixed whole = (fixed)ldexp(mantissa, 53);
    int shift = exponent - 53 + 80;
    if (shift < -63) return 0;
    return shift >= 0 ? whole * ((fixed)1 << shift) : whole / ((fixed)1 << -shift);
}

static void check_total(const snell_explanation *e, const float *pixel, uint32_t channels) {
    size_t light_count;
    uint32_t own_channels, samples;
    const snell_explained_light *lights = snell_explanation_lights(e, &light_count);
    const float *own = snell_explanation_pixel(e, &own_channels);
    snell_explanation_samples(e, &samples);
    assert_int_equal(own_channels, channels);
    for (uint32_t c = 0; c < channels; c++) {
        fixed sum = 0;
        for (size_t i = 0; i < light_count; i++) sum += to_fixed(lights[i].contribution[c]);
        float mean = (float)((double)sum * 0x1p-80 / samples);
        assert_memory_equal(&mean, &pixel[c], sizeof mean);
        assert_memory_equal(&own[c], &pixel[c], sizeof mean);
    }
}

static void showcase(void **state) {
    (void)state;
    static const char *const scenes[] = {"balls", "whitted-1980", "cornell-box", "coloured-water", "solids", "hello"};
    for (size_t k = 0; k < sizeof scenes / sizeof scenes[0]; k++)
        for (int i = SNELL_APPEL; i <= SNELL_PATH; i++) {
            rig_clear(&bench);
            char path[256];
            snprintf(path, sizeof path, "%s/scenes/%s.lua", TEST_SOURCE_DIR, scenes[k]);
            MUST(snell_scene_load(bench.scene, path, NULL));
            MUST(snell_scene_commit(bench.scene, NULL, NULL));
            snell_render_desc desc = SNELL_INIT(render_desc);
            MUST(snell_scene_settings(bench.scene, (snell_integrator)i, &desc));
            desc.width = 40; desc.height = 30; desc.samples = 2;
            MUST(snell_render(bench.scene, &desc, bench.film));
            uint32_t w, h, channels; size_t rays = 0, n;
            const float *p = snell_film_pixels(bench.film, &w, &h, &channels);
            for (uint32_t y = 0; y < h; y++)
                for (uint32_t x = 0; x < w; x++) {
                    snell_explain_desc what = SNELL_INIT(explain_desc);
                    what.x = x; what.y = y;
                    snell_explanation *e;
                    MUST(snell_explain(bench.scene, &desc, &what, &e));
                    check_total(e, p + (y * w + x) * channels, channels);
                    snell_explanation_rays(e, &n);
                    rays += n;
                    snell_explanation_destroy(e);
                }
            printf("%s %d: %zu rays\n", scenes[k], i, rays);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(showcase)};
    return cmocka_run_group_tests(tests, start, stop);
}
