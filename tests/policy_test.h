/* Estimates of light by any policy of the wave loop, such as a test's own. */
#ifndef SNELL_TESTS_POLICY_TEST_H
#define SNELL_TESTS_POLICY_TEST_H

#include "api/api.h"
#include "transport_test.h"

static int looks; /* since somebody set it to 0 */
static inline bool always_on(void *user, const wave_stats *stats) {
    (void)user, (void)stats;
    looks++;
    return true;
}

/* As estimate_light, of a committed scene. */
static inline estimate estimate_policy(rig *r, const integrator *policy, snell_vec3 from,
                                       snell_vec3 at, uint32_t depth, uint32_t samples) {
    perspective_desc camera = {.struct_size = sizeof camera,
                               .from = from,
                               .at = at,
                               .up = estimate_view(from, at).up,
                               .fov = 1e-4f};
    pixel_filter box;
    assert_true(pixel_filter_create(0, 0, &box));
    wave_settings settings = {.scene = r->scene->frozen,
                              .integrator = policy,
                              .camera = &camera_perspective,
                              .filter = &box,
                              .width = ESTIMATE_SIDE,
                              .height = ESTIMATE_SIDE,
                              .max_depth = depth,
                              .seed = 77,
                              .pixel_center = true,
                              .isa = r->context->isa};
    camera_prepare(&camera_perspective, &camera, ESTIMATE_SIDE, ESTIMATE_SIDE, NULL,
                   &settings.frame);
    settings.camera_media = media_around(settings.scene, settings.isa, settings.frame.position, 0);
    wave *w;
    MUST(wave_create(&settings, &w));
    static film_block block;
    const wave_samples all = {0, samples, 0, samples};
    MUST(wave_render_block(w, 0, 0, ESTIMATE_SIDE, ESTIMATE_SIDE, &all, &block, always_on, NULL));
    assert_int_equal(wave_get_stats(w)->film_overflows, 0);
    wave_destroy(w);
    pixel_filter_free(&box);
    estimate e = {0};
    for (int i = 0; i < ESTIMATES; i++)
        for (int k = 0; k < 3; k++)
            moments_add(&e.channel[k], fixed_to(block.sums[i][k]) / samples);
    return e;
}

#endif
