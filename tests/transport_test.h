/* Estimates of light and their tests: what the tests of lights and integrators share.
 *
 * The samples of one pixel are a scrambled net, not independent, so a picture of 16 x 16 pixels that
 * all look at one point is 256 independent estimates: each pixel scrambles for itself. */
#ifndef SNELL_TESTS_TRANSPORT_TEST_H
#define SNELL_TESTS_TRANSPORT_TEST_H

#include "render_test.h"
#include "statistics.h"

#define PI_ 3.14159265358979323846
enum { ESTIMATE_SIDE = 16, ESTIMATES = ESTIMATE_SIDE * ESTIMATE_SIDE };

typedef struct estimate {
    moments channel[3];
} estimate;

/* Every pixel sees the same point, but for a 20000th of its distance. */
static inline snell_view estimate_view(snell_vec3 from, snell_vec3 at) {
    snell_view view = look(from, at);
    view.fov = 1e-4f;
    return view;
}

/* Through the public API. */
static inline estimate estimate_light(rig *r, snell_integrator policy, snell_vec3 from,
                                      snell_vec3 at, uint32_t depth, uint32_t samples) {
    snell_render_desc desc = picture(policy, ESTIMATE_SIDE, ESTIMATE_SIDE, depth);
    snell_view view = estimate_view(from, at);
    estimate e = {0};
    desc.view = &view;
    desc.samples = samples;
    MUST(snell_render(r->scene, &desc, r->film));
    assert_int_equal(stats_of(r).film_overflows, 0);
    for (uint32_t i = 0; i < ESTIMATES; i++) {
        rgb c = pixel_at(r, i % ESTIMATE_SIDE, i / ESTIMATE_SIDE);
        for (int k = 0; k < 3; k++) moments_add(&e.channel[k], c.c[k]);
    }
    return e;
}

/* ---- families of z-tests: judged together, at the end ---- */

enum { FAMILY_MAX = 4096 };

typedef struct family {
    size_t count;
    struct {
        char name[160];
        double z, got, expected, error;
    } tests[FAMILY_MAX];
} family;

static inline void family_add(family *f, const char *name, double z, double got, double expected,
                              double error) {
    assert_true(f->count < FAMILY_MAX);
    snprintf(f->tests[f->count].name, sizeof f->tests[0].name, "%s", name);
    f->tests[f->count].z = z;
    f->tests[f->count].got = got;
    f->tests[f->count].expected = expected;
    f->tests[f->count++].error = error;
}

/* What may be off where there is no chance, or so little of it that this shows: floats in the film,
 * in positions and in descriptions, and paths so rare that none of them was drawn. */
static inline bool nearly(double got, double expected) {
    return fabs(got - expected) <= 1e-9 + 2e-5 * fabs(expected);
}

/* Is the mean what is expected? An estimate that knows it no better than by 0.5 % proves little. */
static inline void family_check_mean(family *f, const char *name, const moments *m,
                                     double expected) {
    double error = moments_error(m);
    if (error > 0.005 * fabs(expected) + 1e-9) {
        fprintf(stderr, "%s: %g +- %g is too vague for %g\n", name, m->mean, error, expected);
        fail();
    }
    family_add(f, name, nearly(m->mean, expected) ? 0 : z_score(m, expected), m->mean, expected,
               error);
}

static inline void family_check_same(family *f, const char *name, const moments *a,
                                     const moments *b) {
    double error = sqrt(moments_variance(a) / a->count + moments_variance(b) / b->count);
    family_add(f, name, nearly(a->mean, b->mean) ? 0 : z_score_pair(a, b), a->mean, b->mean, error);
}

static inline void family_judge(const family *f) {
    double limit = normal_quantile(sidak(0.01, (double)f->count) / 2), largest = 0;
    int failed = 0;
    for (size_t i = 0; i < f->count; i++) {
        largest = fmax(largest, fabs(f->tests[i].z));
        if (fabs(f->tests[i].z) <= limit) continue;
        fprintf(stderr, "%s: got %.7g +- %.2g, expected %.7g: z = %.2f, limit %.2f\n",
                f->tests[i].name, f->tests[i].got, f->tests[i].error, f->tests[i].expected,
                f->tests[i].z, limit);
        failed++;
    }
    printf("%zu z-tests, the largest |z| %.2f of %.2f\n", f->count, largest, limit);
    assert_int_equal(failed, 0);
}

#endif
