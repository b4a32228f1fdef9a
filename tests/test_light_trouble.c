/* Lights where they should not be, and numbers that no light should have: an error that says so, or a
 * picture of finite numbers. */
#include <string.h>

#include "policy_test.h"

static rig bench;

static int start(void **state) {
    (void)state;
    bench = rig_make(1, SNELL_ISA_AUTO);
    return 0;
}

static int stop(void **state) {
    (void)state;
    rig_free(&bench);
    return 0;
}

static const snell_vec3 up = {0, 1, 0}, nowhere = {0, 0, 0};

/* Renders by every integrator: nothing that is not a number, and nothing left out. */
static void check_sane(const char *name, snell_vec3 from, snell_vec3 at, bool overflows) {
    enum { SIDE = 8 };
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    for (snell_integrator policy = SNELL_APPEL; policy <= SNELL_PATH; policy++) {
        snell_render_desc desc = picture(policy, SIDE, SIDE, 6);
        snell_view view = look(from, at);
        desc.view = &view;
        desc.samples = 16;
        MUST(snell_render(bench.scene, &desc, bench.film));
        for (uint32_t i = 0; i < SIDE * SIDE; i++)
            for (int k = 0; k < 3; k++) {
                double c = pixel_at(&bench, i % SIDE, i / SIDE).c[k];
                if (isfinite(c) && c >= 0) continue;
                fprintf(stderr, "%s by integrator %d: a pixel is %g\n", name, (int)policy, c);
                fail();
            }
        bool left_out = stats_of(&bench).film_overflows > 0;
        if (!overflows && left_out) {
            fprintf(stderr, "%s by integrator %d: something was left out\n", name, (int)policy);
            fail();
        }
    }
}

/* ---- numbers that are refused ---- */

static void must_refuse(const type_info *info, const field *f, double x) {
    size_t size = info->desc_size;
    unsigned char desc[512];
    assert_true(size <= sizeof desc);
    desc_init(info, desc);
    snell_param p = {.name = f->name, .kind = SNELL_PARAM_FLOAT, .value.f = x};
    snell_status status = desc_set(info, desc, &p);
    if (!status) status = desc_check(info, desc, NULL);
    if (status != SNELL_ERR_ARGUMENT || strstr(snell_last_error()->text, f->name) == NULL) {
        fprintf(stderr, "%s.%s = %g: %s\n", info->name, f->name, x,
                status ? snell_last_error()->text : "accepted");
        fail();
    }
}

static void senseless_light_is_refused(void **state) {
    (void)state;
    int tested = 0;
    for (uint32_t i = 0; i < light_type_count; i++) {
        const type_info *info = &light_types[i]->info;
        for (uint32_t k = 0; k < info->field_count; k++) {
            const field *f = &info->fields[k];
            if (f->kind != FIELD_COLOR && f->kind != FIELD_INPUT) continue;
            must_refuse(info, f, -1);
            must_refuse(info, f, NAN);
            must_refuse(info, f, INFINITY);
            must_refuse(info, f, 1e300); /* no float */
            tested++;
        }
    }
    assert_true(tested >= 12);
}

static void refused(snell_status status, const char *word) {
    assert_int_equal(status, SNELL_ERR_ARGUMENT);
    if (strstr(snell_last_error()->text, word)) return;
    fprintf(stderr, "'%s' does not say '%s'\n", snell_last_error()->text, word);
    fail();
}

static void senseless_shapes_of_lights_are_refused(void **state) {
    (void)state;
    rig_clear(&bench);
    snell_spot_light_desc spot = SNELL_INIT(spot_light_desc);
    spot.position = spot.at = v3(1, 2, 3);
    refused(snell_scene_add_spot_light(bench.scene, &spot, NULL), "position");
    spot.at = nowhere;
    spot.cone = 0;
    refused(snell_scene_add_spot_light(bench.scene, &spot, NULL), "cone");
    spot.cone = 0.2f;
    spot.blend = 0.3f;
    refused(snell_scene_add_spot_light(bench.scene, &spot, NULL), "blend");
    snell_quad_light_desc quad = SNELL_INIT(quad_light_desc);
    refused(snell_scene_add_quad_light(bench.scene, &quad, NULL), "area");
    quad.u = quad.v = v3(1, 1, 0);
    refused(snell_scene_add_quad_light(bench.scene, &quad, NULL), "area");
    quad.height = 1;
    refused(snell_scene_add_quad_light(bench.scene, &quad, NULL), "width");
    quad.width = 1;
    refused(snell_scene_add_quad_light(bench.scene, &quad, NULL), "same point");
    snell_disk_light_desc disk = SNELL_INIT(disk_light_desc);
    disk.radius = 0;
    refused(snell_scene_add_disk_light(bench.scene, &disk, NULL), "radius");
    disk.radius = 1;
    disk.normal = nowhere;
    refused(snell_scene_add_disk_light(bench.scene, &disk, NULL), "normal");
    snell_sky_light_desc sky = SNELL_INIT(sky_light_desc);
    sky.sun = v3(1, -0.1, 0);
    refused(snell_scene_add_sky_light(bench.scene, &sky, NULL), "horizon");
}

/* A power that so small an area cannot send with a radiance that is a number. */
static void power_without_area_is_refused(void **state) {
    (void)state;
    rig_clear(&bench);
    snell_sphere_light_desc sphere = SNELL_INIT(sphere_light_desc);
    sphere.radius = 1e-25f;
    sphere.power = grey(1);
    refused(snell_scene_add_sphere_light(bench.scene, &sphere, NULL), "power");
    snell_disk_light_desc disk = SNELL_INIT(disk_light_desc);
    disk.radius = 1e-25f;
    disk.power = grey(1);
    refused(snell_scene_add_disk_light(bench.scene, &disk, NULL), "power");
    snell_quad_light_desc quad = SNELL_INIT(quad_light_desc);
    quad.u = v3(1e-20, 0, 0);
    quad.v = v3(0, 1e-20, 0);
    quad.power = grey(1);
    refused(snell_scene_add_quad_light(bench.scene, &quad, NULL), "power");
}

/* ---- places that are allowed ---- */

static void add_ball_light(snell_vec3 center, double radius, snell_vec3 radiance) {
    snell_sphere_light_desc desc = SNELL_INIT(sphere_light_desc);
    desc.center = center;
    desc.radius = (float)radius;
    desc.radiance = radiance;
    MUST(snell_scene_add_sphere_light(bench.scene, &desc, NULL));
}

static void fresh_floor(void) {
    rig_clear(&bench);
    add_plane(&bench, nowhere, up, add_lambert(&bench, grey(0.8)));
}

static void lights_in_odd_places(void **state) {
    (void)state;
    const snell_vec3 from = v3(0, 0.5, 2);
    fresh_floor();
    add_point(&bench, nowhere, grey(1)); /* on the floor, where the centre ray hits */
    add_ball_light(v3(0, -0.2, 0), 0.2, grey(3));
    check_sane("on the floor", from, nowhere, false);
    fresh_floor();
    add_sphere(&bench, nowhere, 0.5, add_lambert(&bench, grey(0.8)));
    add_point(&bench, nowhere, grey(1));
    add_ball_light(v3(0.1, 0, 0), 0.2, grey(3));
    check_sane("in a ball", from, nowhere, false);
    check_sane("the eye in the ball, and in the light", v3(0.1, 0.01, 0), v3(0.4, 0, 0), false);
    fresh_floor();
    add_sphere(&bench, v3(0, 1, 0), 2, add_glow(&bench, grey(1)));
    check_sane("the eye in what shines", from, nowhere, false);
    fresh_floor();
    add_quad(&bench, v3(-1, 0, -1), v3(2, 0, 0), v3(0, 0, 2), add_glow(&bench, grey(1)));
    check_sane("in the plane of the floor", from, nowhere, false);
    fresh_floor();
    snell_headlight_light_desc head = SNELL_INIT(headlight_light_desc);
    MUST(snell_scene_add_headlight_light(bench.scene, &head, NULL));
    check_sane("the eye on the floor", v3(0, 0, 1), nowhere, false);
    fresh_floor();
    snell_spot_light_desc spot = SNELL_INIT(spot_light_desc);
    spot.position = up;
    spot.cone = spot.blend = 3.1415925f;
    MUST(snell_scene_add_spot_light(bench.scene, &spot, NULL));
    spot.cone = spot.blend = 1e-4f;
    MUST(snell_scene_add_spot_light(bench.scene, &spot, NULL));
    check_sane("spots of all and of nothing", from, nowhere, false);
}

static void lights_of_odd_strength(void **state) {
    (void)state;
    const snell_vec3 from = v3(0, 0.5, 2);
    fresh_floor();
    add_point(&bench, up, grey(0));
    add_sun(&bench, v3(0, -1, 0), grey(0));
    add_ball_light(v3(1, 1, 0), 0.2, grey(0));
    snell_environment_light_desc dark = SNELL_INIT(environment_light_desc);
    static const float black[4] = {0, 0, 0, 1};
    snell_image_texture_desc map = SNELL_INIT(image_texture_desc);
    map.width = map.height = 1;
    map.format = SNELL_IMAGE_TEXTURE_FORMAT_RGBA32F;
    map.pixels = black;
    map.pixels_count = sizeof black;
    MUST(snell_scene_add_image_texture(bench.scene, &map, &dark.radiance.texture));
    MUST(snell_scene_add_environment_light(bench.scene, &dark, NULL));
    check_sane("all black", from, nowhere, false);
    assert_true(pixel_at(&bench, 4, 4).c[0] == 0);
    fresh_floor();
    add_ball_light(v3(1, 1, 0), 0.2, grey(1e30));
    check_sane("1e30", from, nowhere, true);
    assert_true(stats_of(&bench).film_overflows > 0); /* left out, and said */
    fresh_floor();
    add_ball_light(v3(1, 1, 0), 0.2, grey(1e-30));
    add_ball_light(v3(1, 1, 1), 1e-18, grey(1));
    add_ball_light(v3(1, 1e6, 1), 1e5, grey(1));
    check_sane("faint, tiny, huge", from, nowhere, false);
}

/* Every haze and height of the sun. */
static void skies_are_finite(void **state) {
    (void)state;
    for (int haze = 0; haze <= 4; haze++)
        for (int height = 0; height <= 4; height++) {
            rig_clear(&bench);
            snell_sky_light_desc sky = SNELL_INIT(sky_light_desc);
            sky.turbidity = (float)(1.8 + haze * 2.05);
            sky.sun = v3(1, 0.3 * height * height, 0);
            MUST(snell_scene_add_sky_light(bench.scene, &sky, NULL));
            MUST(snell_scene_commit(bench.scene, NULL, NULL));
            const light *l = &bench.scene->frozen->lights[0];
            uint64_t random = 4;
            for (int i = 0; i < 500; i++) {
                dvec3 d = {uniform(&random) - 0.5, uniform(&random) - 0.5, uniform(&random) - 0.5};
                if (i == 0) d = (dvec3){0, 1, 0};
                if (i == 1) d = (dvec3){1, 0, 0};
                if (i == 2) d = dvec3_from(sky.sun);
                dvec3 c = l->type->radiance(l, dvec3_normalize(d));
                assert_true(c.x >= 0 && c.y >= 0 && c.z >= 0 && dvec3_largest(c) < 1e6);
            }
        }
}

/* An infinite plane has no area to sample: it shines where a ray meets it, in path on all that paths
 * can meet it from, in cook and whitted on mirrors alone. */
static void a_plane_shines_where_it_is_met(void **state) {
    (void)state;
    fresh_floor();
    add_plane(&bench, v3(0, 2, 0), v3(0, -1, 0), add_glow(&bench, grey(1)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    const snell_vec3 eye = v3(0, 1, 0.5);
    estimate path = estimate_light(&bench, SNELL_PATH, eye, nowhere, 1, 16);
    ASSERT_CLOSE(path.channel[0].mean, 0.8, 1e-5, 0);
    assert_true(trace_ray(&bench, SNELL_COOK, eye, nowhere, 1).c[0] == 0);
    assert_true(trace_ray(&bench, SNELL_WHITTED, eye, nowhere, 1).c[0] == 0);
    for (snell_integrator policy = SNELL_APPEL; policy <= SNELL_PATH; policy++)
        ASSERT_CLOSE(trace_ray(&bench, policy, eye, v3(0, 2, 0), 1).c[0], 1, 1e-6, 0);
}

/* ---- surroundings finer than the grid that samples them ---- */

/* One bright pixel in a map that the grid must shrink, by cook, which has no other way to find it. */
static void a_small_sun_is_found(void **state) {
    (void)state;
    static const uint32_t widths[] = {2048, 2049, 4096, 5001};
    for (size_t i = 0; i < 4; i++)
        for (int nearest = 0; nearest < 2; nearest++) {
            fresh_floor();
            uint32_t width = widths[i], height = 64, x = width / 2, y = 12;
            float *pixels = calloc((size_t)width * height * 4, sizeof *pixels);
            assert_non_null(pixels);
            for (int k = 0; k < 3; k++) pixels[4 * ((size_t)width * y + x) + (size_t)k] = 1e5f;
            snell_image_texture_desc map = SNELL_INIT(image_texture_desc);
            snell_environment_light_desc sky = SNELL_INIT(environment_light_desc);
            map.width = (int32_t)width;
            map.height = (int32_t)height;
            map.format = SNELL_IMAGE_TEXTURE_FORMAT_RGBA32F;
            map.pixels = pixels;
            map.pixels_count = (size_t)width * height * 4 * sizeof *pixels;
            map.filter =
                nearest ? SNELL_IMAGE_TEXTURE_FILTER_NEAREST : SNELL_IMAGE_TEXTURE_FILTER_LINEAR;
            MUST(snell_scene_add_image_texture(bench.scene, &map, &sky.radiance.texture));
            free(pixels);
            MUST(snell_scene_add_environment_light(bench.scene, &sky, NULL));
            MUST(snell_scene_commit(bench.scene, NULL, NULL));
            estimate got = estimate_light(&bench, SNELL_COOK, v3(0, 0.01, 0.01), nowhere, 0, 256);
            double top = PI_ * y / height, bottom = PI_ * (y + 1) / height; /* of the pixel's row */
            double expected = 0.8 * 1e5 * (2 / (double)width) *
                              (sin(bottom) * sin(bottom) - sin(top) * sin(top)) / 2;
            /* Nearest: exactly the pixel. Linear: a tent of the same volume, but for the cosines. */
            char name[64];
            snprintf(name, sizeof name, "%u pixels wide, %s", width,
                     nearest ? "nearest" : "linear");
            double off = fabs(got.channel[0].mean - expected),
                   error = moments_error(&got.channel[0]);
            if (off > 4 * error + 1e-3 * expected || error > 0.03 * expected) {
                fprintf(stderr, "%s: %g +- %g, not %g\n", name, got.channel[0].mean, error,
                        expected);
                fail();
            }
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(senseless_light_is_refused),
        cmocka_unit_test(senseless_shapes_of_lights_are_refused),
        cmocka_unit_test(power_without_area_is_refused),
        cmocka_unit_test(lights_in_odd_places),
        cmocka_unit_test(lights_of_odd_strength),
        cmocka_unit_test(skies_are_finite),
        cmocka_unit_test(a_plane_shines_where_it_is_met),
        cmocka_unit_test(a_small_sun_is_found),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
