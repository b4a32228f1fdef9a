/* snell_explain: what it tells adds up to the pixel that snell_render makes, bit for bit; the factors
 * of each contribution are those that it came from; and no surface sends on more than it gets. */
#include <glob.h>

#include "reference.h"
#include "render_test.h"

static const double PI_ = 3.14159265358979323846;
static rig bench;

static int start(void **state) {
    (void)state;
    bench = rig_make(0, SNELL_ISA_AUTO);
    return 0;
}

static int stop(void **state) {
    (void)state;
    rig_free(&bench);
    reference_free();
    return 0;
}

static int fresh(void **state) {
    (void)state;
    rig_clear(&bench);
    return 0;
}

/* ---- an explanation, and what must be true of every one ---- */

typedef struct told {
    snell_explanation *whole;
    const snell_explained_ray *rays;
    const snell_explained_light *lights;
    const snell_explained_sample *samples;
    size_t ray_count, light_count;
    uint32_t sample_count, channels;
    const float *pixel;
    snell_integrator integrator;
    bool by_chance; /* path */
} told;

static told ask(const snell_render_desc *desc, uint32_t x, uint32_t y) {
    snell_explain_desc at = SNELL_INIT(explain_desc);
    told t = {.integrator = desc->integrator, .by_chance = desc->integrator == SNELL_PATH};
    at.x = x;
    at.y = y;
    MUST(snell_explain(bench.scene, desc, &at, &t.whole));
    t.rays = snell_explanation_rays(t.whole, &t.ray_count);
    t.lights = snell_explanation_lights(t.whole, &t.light_count);
    t.samples = snell_explanation_samples(t.whole, &t.sample_count);
    t.pixel = snell_explanation_pixel(t.whole, &t.channels);
    return t;
}

/* value * 2^80, towards 0: what the film adds. */
__extension__ typedef __int128 fixed;
static fixed to_fixed(double value) {
    int exponent;
    double mantissa = frexp(value, &exponent);
    fixed whole = (fixed)ldexp(mantissa, 53);
    int shift = exponent - 53 + 80;
    if (shift < -63) return 0;
    return shift >= 0 ? whole * ((fixed)1 << shift) : whole / ((fixed)1 << -shift);
}

static void check_total(const told *t, const float *pixel, uint32_t channels) {
    assert_int_equal(t->channels, channels);
    for (uint32_t c = 0; c < channels; c++) {
        fixed sum = 0;
        for (size_t i = 0; i < t->light_count; i++) sum += to_fixed(t->lights[i].contribution[c]);
        float mean = (float)((double)sum * 0x1p-80 / t->sample_count);
        assert_memory_equal(&mean, &pixel[c], sizeof mean);
        assert_memory_equal(&t->pixel[c], &pixel[c], sizeof mean);
    }
}

/* Trees stand one after the other, and each ray's sum is that of its own lights and its children. */
static void check_order(const told *t) {
    uint32_t rays = 0, lights = 0;
    for (uint32_t i = 0; i < t->sample_count; i++) {
        assert_int_equal(t->samples[i].first_ray, rays);
        rays += t->samples[i].ray_count;
    }
    assert_int_equal(rays, t->ray_count);
    for (uint32_t i = 0; i < t->ray_count; i++) {
        const snell_explained_ray *r = &t->rays[i];
        double sum[4] = {0, 0, 0, 0};
        assert_int_equal(r->first_light, lights);
        lights += r->light_count;
        for (uint32_t k = 0; k < r->light_count; k++) {
            assert_int_equal(t->lights[r->first_light + k].ray, i);
            for (int c = 0; c < 4; c++) sum[c] += t->lights[r->first_light + k].contribution[c];
        }
        for (uint32_t k = 1; k < r->ray_count; k += r[k].ray_count) {
            assert_int_equal(r[k].parent, i);
            assert_int_equal(r[k].sample, r->sample);
            assert_int_equal(r[k].depth, r->depth + (r[k].kind != SNELL_RAY_CONTINUED));
            for (int c = 0; c < 4; c++) sum[c] += r[k].radiance[c];
        }
        for (int c = 0; c < 4; c++) ASSERT_CLOSE(r->radiance[c], sum[c], 1e-12, 1e-20);
        if (r->parent == UINT32_MAX) assert_int_equal(t->samples[r->sample].first_ray, i);
    }
    assert_int_equal(lights, t->light_count);
}

static double component(snell_vec3 v, int c) {
    return (double)(c == 0 ? v.x : c == 1 ? v.y : v.z);
}

/* Three roundings to float between two rays. */
static bool near(double a, double b) { return fabs(a - b) <= 4e-7 * fabs(b) + 1e-38; }

/* A ray's throughput is its parent's times what lies between; what walks on past a surface that is
 * there in part goes on from before that part was taken. */
static void check_throughput(const told *t, const snell_explained_ray *r) {
    double part = r->end == SNELL_RAY_HIT && !t->by_chance ? r->alpha : 1;
    for (int c = 0; c < 3; c++) {
        double before = 1, share = 1;
        if (r->parent != UINT32_MAX) {
            const snell_explained_ray *parent = &t->rays[r->parent];
            before = component(parent->throughput, c);
            if (r->kind == SNELL_RAY_CONTINUED && parent->alpha > 0 && !t->by_chance)
                share = 1 / parent->alpha;
        }
        double own = r->weight[c] * r->transmittance[c] * part;
        double got = component(r->throughput, c);
        if (near(got, before * own) || near(got, before * share * own)) continue;
        fprintf(stderr, "throughput %.9g, not %.9g * %.9g\n", got, before, own);
        fail();
    }
}

static void check_contribution(const told *t, const snell_explained_light *l) {
    for (int c = 0; c < 3 && l->source != SNELL_SOURCE_COVERAGE; c++) {
        double expected = component(t->rays[l->ray].throughput, c) * l->bsdf[c] * l->incoming[c] *
                          l->cosine * l->weight * l->visibility[c];
        ASSERT_CLOSE(l->contribution[c], expected, 1e-6, 1e-30);
        if (l->visibility[c] == 0) assert_true(l->contribution[c] == 0);
    }
}

typedef struct seen {
    size_t rays, lights, blocked, conserving, splits;
} seen;

static bool is(const snell_explained_ray *r, const char *material) {
    return strcmp(r->material.type, material) == 0;
}

/* From the fourth bounce on a path lives with the probability of its throughput, and makes up for it. */
static double survival(const told *t, const snell_explained_ray *r) {
    double largest = 0;
    for (int c = 0; c < 3; c++) largest = fmax(largest, component(r->throughput, c));
    return t->by_chance && r->depth >= 4 ? fmin(largest, 1) : 1;
}

/* What a hit's rays carry together is at most all. Of rays that were drawn by chance one may carry
 * more than the mean of them: those are left out where the material has several parts. */
static void check_energy(const told *t, const snell_explained_ray *r, seen *s) {
    bool one_part = is(r, "dielectric") || is(r, "mirror") || is(r, "lambert");
    double sum[3] = {0, 0, 0}, reflected = 0, refracted = 0;
    bool drawn = false, split = false;
    for (uint32_t k = 1; k < r->ray_count; k += r[k].ray_count) {
        if (r[k].kind == SNELL_RAY_CONTINUED) continue;
        /* Of what was not traced, cook does not tell whether it was drawn. */
        drawn |= r[k].pdf > 0 || (t->integrator == SNELL_COOK && r[k].end > SNELL_RAY_LEFT);
        split |= r[k].kind == SNELL_RAY_REFRACTED;
        for (int c = 0; c < 3; c++) sum[c] += r[k].weight[c] * survival(t, r);
        *(r[k].kind == SNELL_RAY_REFRACTED ? &refracted : &reflected) = r[k].weight[0];
    }
    if (r->end != SNELL_RAY_HIT || r->ray_count == 1) return;
    if ((drawn || t->by_chance) && !one_part) return;
    for (int c = 0; c < 3; c++)
        if (!(sum[c] <= 1 + 1e-6)) {
            fprintf(stderr, "%s (%s, line %u) sends on %.9g\n", r->shape.type, r->material.type,
                    r->material.line, sum[c]);
            for (uint32_t k = 1; k < r->ray_count; k += r[k].ray_count)
                fprintf(stderr, "  %d weight %.9g pdf %g depth %u\n", r[k].kind, r[k].weight[c],
                        r[k].pdf, r[k].depth);
            fail();
        }
    s->conserving++;
    if (t->by_chance || !is(r, "dielectric") || r->fresnel[0] == 0) return;
    /* By Snell and Fresnel: F goes back, at most 1 - F goes on. */
    assert_true(reflected <= r->fresnel[0] + 1e-12);
    assert_true(refracted <= 1 - r->fresnel[0] + 1e-12);
    if (r->fresnel[0] == 1) assert_true(!split);
    s->splits += split;
}

static void check(const told *t, seen *s) {
    check_order(t);
    for (size_t i = 0; i < t->ray_count; i++) {
        check_throughput(t, &t->rays[i]);
        check_energy(t, &t->rays[i], s);
    }
    for (size_t i = 0; i < t->light_count; i++) {
        check_contribution(t, &t->lights[i]);
        s->blocked += t->lights[i].blocker.type[0] != '\0';
    }
    s->rays += t->ray_count;
    s->lights += t->light_count;
}

/* ---- every showcase scene, by every integrator ---- */

static void explain_pixels(const snell_render_desc *desc, seen *s) {
    uint32_t width, height, channels;
    uint64_t random = desc->integrator;
    int count = full_tests() ? 1000 : 12;
    MUST(snell_render(bench.scene, desc, bench.film));
    const float *pixels = snell_film_pixels(bench.film, &width, &height, &channels);
    for (int i = 0; i < count; i++) {
        uint32_t x = (uint32_t)(uniform(&random) * width), y = (uint32_t)(uniform(&random) * height);
        told t = ask(desc, x, y);
        check_total(&t, pixels + ((size_t)y * width + x) * channels, channels);
        check(&t, s);
        snell_explanation_destroy(t.whole);
    }
}

static void showcase(void **state) {
    (void)state;
    glob_t scenes;
    seen s = {0};
    assert_int_equal(glob(TEST_SOURCE_DIR "/scenes/*.lua", 0, NULL, &scenes), 0);
    assert_true(scenes.gl_pathc > 10);
    for (size_t k = 0; k < scenes.gl_pathc; k++) {
        rig_clear(&bench);
        MUST(snell_scene_load(bench.scene, scenes.gl_pathv[k], NULL));
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        for (int i = SNELL_APPEL; i <= SNELL_PATH; i++) {
            snell_render_desc desc = SNELL_INIT(render_desc);
            MUST(snell_scene_settings(bench.scene, (snell_integrator)i, &desc));
            desc.width = 80;
            desc.height = 60;
            desc.samples = 2;
            desc.transparent |= k % 2;
            explain_pixels(&desc, &s);
        }
    }
    globfree(&scenes);
    printf("%zu rays, %zu lights of which %zu blocked; %zu surfaces conserve, %zu split\n", s.rays,
           s.lights, s.blocked, s.conserving, s.splits);
    assert_true(s.blocked > 0 && s.conserving > 0 && s.splits > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test_setup(showcase, fresh)};
    return cmocka_run_group_tests(tests, start, stop);
}
