/* AOVs: each against values by hand on a small scene; light that adds up to the picture to the last bit
 * of the film's sums; the same bits for any threads and instruction set; files that give them back. */
#include <string.h>
#include <unistd.h>

#include "api/api.h"
#include "base/memory.h"
#include "image/aov.h"
#include "integrators/aov.h"
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

static int fresh(void **state) {
    (void)state;
    rig_clear(&bench);
    return 0;
}

static const snell_integrator policies[] = {SNELL_APPEL, SNELL_WHITTED, SNELL_COOK, SNELL_PATH};
#define EVERY                                                                                      \
    "depth,position,normal,geometric_normal,albedo,uv,motion,object_id,material_id,primitive_id,"  \
    "crypto_object,crypto_material,emission,direct,indirect,reflection,refraction,light,rays"

/* ---- looking ---- */

static const char *file_path(const char *name) {
    static char path[256];
    snprintf(path, sizeof path, "aovs.%d.%s", (int)getpid(), name);
    return path;
}

static const float *find(const snell_film *f, const char *name, uint32_t *channels) {
    snell_aov aov;
    for (uint32_t i = 0; snell_film_aov(f, i, &aov); i++) {
        if (strcmp(aov.name, name) != 0) continue;
        if (channels) *channels = aov.channel_count;
        return aov.pixels;
    }
    fprintf(stderr, "the film has no AOV %s\n", name);
    fail();
    return NULL;
}

static double value(const char *name, uint32_t x, uint32_t y, uint32_t c) {
    uint32_t width, channels = 0;
    snell_film_pixels(bench.film, &width, NULL, NULL);
    const float *p = find(bench.film, name, &channels);
    return (double)p[((size_t)y * width + x) * channels + c];
}

static void is_vector(const char *name, uint32_t x, uint32_t y, double a, double b, double c) {
    ASSERT_CLOSE(value(name, x, y, 0), a, 1e-6, 1e-6);
    ASSERT_CLOSE(value(name, x, y, 1), b, 1e-6, 1e-6);
    ASSERT_CLOSE(value(name, x, y, 2), c, 1e-6, 1e-6);
}

static void render_from(snell_render_desc *desc, snell_vec3 from, snell_vec3 at, const char *aov) {
    snell_view view = look(from, at);
    desc->view = &view;
    desc->aov = aov;
    MUST(snell_render(bench.scene, desc, bench.film));
    desc->view = NULL;
}

/* ---- surfaces ---- */

/* An odd picture, one sample through the middle of each pixel. The ball's radius is 1, the wall's z is
 * -1, and it is wider than what is seen; above it there is nothing. */
static void build_ball_and_wall(void) {
    snell_material_id red = add_lambert(&bench, v3(0.8, 0.4, 0.2)),
                      blue = add_lambert(&bench, v3(0.1, 0.2, 0.6));
    add_sphere(&bench, v3(0, 0, 0), 1, red);
    add_quad(&bench, v3(-50, -50, -1), v3(100, 0, 0), v3(0, 52, 0), blue);
    add_point(&bench, v3(0, 5, 5), grey(100));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
}

static void test_surfaces(void **state) {
    (void)state;
    build_ball_and_wall();
    for (int i = 0; i < 4; i++) {
        snell_render_desc desc = picture(policies[i], 41, 41, 3);
        render_from(&desc, v3(0, 0, 5), v3(0, 0, 0), EVERY);
        ASSERT_CLOSE(value("depth", 20, 20, 0), 4, 1e-6, 0);
        is_vector("position", 20, 20, 0, 0, 1);
        is_vector("normal", 20, 20, 0, 0, 1);
        is_vector("geometric_normal", 20, 20, 0, 0, 1);
        is_vector("albedo", 20, 20, 0.8, 0.4, 0.2);
        /* Beside the ball the wall: its depth is the distance of its plane, whatever the pixel. */
        ASSERT_CLOSE(value("depth", 1, 35, 0), 6, 1e-6, 0);
        ASSERT_CLOSE(value("depth", 38, 22, 0), 6, 1e-6, 0);
        double step = 2 * tan(0.6981317 / 2) / 41, x = 6 * step * (38 - 20),
               y = -6 * step * (22 - 20);
        is_vector("position", 38, 22, x, y, -1);
        is_vector("albedo", 38, 22, 0.1, 0.2, 0.6);
        is_vector("normal", 38, 22, 0, 0, 1);
        ASSERT_CLOSE(value("uv", 38, 22, 0), (x + 50) / 100, 1e-6, 0);
        ASSERT_CLOSE(value("uv", 38, 22, 1), (y + 50) / 52, 1e-6, 0);
        assert_true(value("object_id", 20, 20, 0) == 1 && value("object_id", 38, 22, 0) == 2);
        assert_true(value("material_id", 20, 20, 0) == 1 && value("material_id", 38, 22, 0) == 2);
        assert_true(value("primitive_id", 20, 20, 0) == 1);
        assert_true(value("motion", 20, 20, 0) == 0 && value("motion", 20, 20, 1) == 0);
        /* Nothing. */
        assert_true(value("depth", 1, 0, 0) == (double)1e10f);
        is_vector("position", 1, 0, 0, 0, 0);
        is_vector("albedo", 1, 0, 0, 0, 0);
        assert_true(value("object_id", 1, 0, 0) == 0 && value("crypto_object", 1, 0, 1) == 0);
    }
}

/* At the ball's lower edge a pixel has some of it and some of the wall: values are means over what was
 * met, not mixed with nothing; at the wall's upper edge they are the wall's. */
static void test_edges(void **state) {
    (void)state;
    build_ball_and_wall();
    snell_render_desc desc = picture(SNELL_WHITTED, 40, 40, 1);
    desc.pixel_center = false;
    desc.samples = 64;
    render_from(&desc, v3(0, 0, 5), v3(0, 0, 0), "depth,albedo,crypto_object,object_id");
    bool seen = false;
    for (uint32_t y = 0; y < 40; y++) {
        double covered = value("crypto_object", 0, y, 1);
        if (covered > 0) ASSERT_CLOSE(value("depth", 0, y, 0), 6, 1e-6, 0);
        ASSERT_CLOSE(value("albedo", 0, y, 2), 0.6 * covered, 1e-6, 1e-6);
        seen |= covered > 0 && covered < 1;
    }
    assert_true(seen);
    seen = false;
    for (uint32_t x = 0; x < 40; x++) {
        double first = value("crypto_object", x, 20, 1), second = value("crypto_object", x, 20, 3);
        assert_true(first >= second && first + second == 1);
        if (second == 0) continue;
        seen = true;
        float ids[2] = {(float)value("crypto_object", x, 20, 0),
                        (float)value("crypto_object", x, 20, 2)};
        float ball = crypto_float(crypto_id("sphere #1"));
        double of_ball = ids[0] == ball ? first : second;
        assert_true(ids[0] == ball || ids[1] == ball);
        ASSERT_CLOSE(value("albedo", x, 20, 0), 0.8 * of_ball + 0.1 * (1 - of_ball), 1e-6, 0);
    }
    assert_true(seen);
}

/* A card of which a quarter is there, before one that is all there. */
static void test_coverage(void **state) {
    (void)state;
    add_quad(&bench, v3(-9, -9, 0), v3(18, 0, 0), v3(0, 18, 0),
             add_card(&bench, v3(1, 0, 0), 0.25));
    add_quad(&bench, v3(-9, -9, -4), v3(18, 0, 0), v3(0, 18, 0), add_lambert(&bench, v3(0, 1, 0)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    for (int i = 0; i < 4; i++) {
        bool by_chance = policies[i] == SNELL_PATH;
        double room = by_chance ? 0.02 : 1e-6;
        snell_render_desc desc = picture(policies[i], 1, 1, 3);
        desc.samples = by_chance ? 4096 : 1;
        desc.pixel_center = !by_chance;
        render_from(&desc, v3(0, 0, 5), v3(0, 0, 0), EVERY);
        ASSERT_CLOSE(value("depth", 0, 0, 0), 0.25 * 5 + 0.75 * 9, 0, 4 * room);
        ASSERT_CLOSE(value("albedo", 0, 0, 0), 0.25, 0, room);
        ASSERT_CLOSE(value("albedo", 0, 0, 1), 0.75, 0, room);
        ASSERT_CLOSE(value("crypto_material", 0, 0, 1), 0.75, 0, room); /* ranked */
        ASSERT_CLOSE(value("crypto_material", 0, 0, 3), 0.25, 0, room);
        if (!by_chance) assert_true(value("material_id", 0, 0, 0) == 1);
    }
}

/* ---- motion ---- */

static snell_transform shift(double x, double y, double z) {
    return (snell_transform){{{1, 0, 0, (float)x}, {0, 1, 0, (float)y}, {0, 0, 1, (float)z}}};
}

/* A pixel of the plane z = 0, seen from 5 m, is so wide. */
static double pixels_per_metre(uint32_t height) { return height / (2 * 5 * tan(0.6981317 / 2)); }

static void film_moving(float close) {
    snell_render_desc desc = picture(SNELL_COOK, 33, 33, 1);
    snell_view view = look(v3(0, 0, 5), v3(0, 0, 0));
    view.shutter = (snell_vec2){0, close}; /* frames of 24 a second */
    desc.view = &view;
    desc.aov = "motion";
    MUST(snell_render(bench.scene, &desc, bench.film));
}

static void add_camera(void) { /* what rays see of motions is what cameras see: half a frame */
    snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
    MUST(snell_scene_add_perspective_camera(bench.scene, &camera, NULL));
}

/* Metres until the next frame, however long the shutter is open; within so many, since what turns or stretches moves
 * differently where the pixel's sample is. */
static void check_motion(double x, double y, double within) {
    for (int i = 0; i < 3; i++) {
        film_moving(0.25f * (float)i);
        ASSERT_CLOSE(value("motion", 16, 16, 0) / pixels_per_metre(33), x, 0, within);
        ASSERT_CLOSE(value("motion", 16, 16, 1) / pixels_per_metre(33), -y, 0, within);
    }
}

static void test_motion_of_instances(void **state) {
    (void)state;
    add_camera();
    snell_instance_id card =
        add_quad(&bench, v3(-4, -4, 0), v3(8, 0, 0), v3(0, 8, 0), add_lambert(&bench, grey(0.5)));
    const snell_motion_key keys[] = {{0, shift(0, 0, 0)}, {1.0f / 24, shift(0.5, 0.25, 0)}};
    MUST(snell_scene_set_instance_motion(bench.scene, card, keys, 2));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    check_motion(0.5, 0.25, 1e-5);
}

/* In a group that moves too: both add up. */
static void test_motion_of_groups(void **state) {
    (void)state;
    add_camera();
    snell_shape_id group;
    snell_instance_id card = add_quad(&bench, v3(-4, -4, 0), v3(8, 0, 0), v3(0, 8, 0),
                                      add_lambert(&bench, grey(0.5))),
                      whole;
    const snell_motion_key inner[] = {{0, shift(0, 0, 0)}, {1.0f / 24, shift(0.5, 0, 0)}},
                           outer[] = {{0, shift(0, 0, 0)}, {1.0f / 24, shift(0.25, 0.5, 0)}};
    MUST(snell_scene_set_instance_motion(bench.scene, card, inner, 2));
    MUST(snell_scene_add_group(bench.scene, &card, 1, NULL, &group));
    MUST(snell_scene_add_instance(bench.scene, group, (snell_material_id){0, 0}, NULL, &whole));
    MUST(snell_scene_set_instance_motion(bench.scene, whole, outer, 2));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    check_motion(0.75, 0.5, 1e-5);
}

/* A mesh whose right edge alone moves: its middle goes half as far. The key at the next frame is none that the
 * shutter needs. */
static void test_motion_of_vertices(void **state) {
    (void)state;
    add_camera();
    static const snell_vec3 positions[] = {{-4, -4, 0}, {4, -4, 0},    {4, 4, 0},    {-4, 4, 0},
                                           {-4, -4, 0}, {4.5f, -4, 0}, {4.5f, 4, 0}, {-4, 4, 0},
                                           {-4, -4, 0}, {5, -4, 0},    {5, 4, 0},    {-4, 4, 0}};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    static const float times[] = {0, 0.5f / 24, 1.0f / 24};
    snell_mesh_desc desc = SNELL_INIT(mesh_desc);
    desc.positions = positions, desc.positions_count = 12;
    desc.indices = indices, desc.indices_count = 6;
    desc.key_times = times, desc.key_times_count = 3;
    snell_shape_id mesh;
    MUST(snell_scene_add_mesh(bench.scene, &desc, &mesh));
    place(&bench, mesh, add_lambert(&bench, grey(0.5)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    check_motion(0.5, 0, 0.04);
}

/* A camera that goes right sees all go left. */
static void test_motion_of_cameras(void **state) {
    (void)state;
    const snell_motion_key keys[] = {{0, shift(0, 0, 0)}, {1.0f / 24, shift(0.5, 0, 0)}};
    snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
    snell_render_desc desc = picture(SNELL_COOK, 33, 33, 1);
    camera.from = v3(0, 0, 5);
    camera.shutter = (snell_vec2){0, 0};
    camera.motion = keys, camera.motion_count = 2;
    desc.aov = "motion";
    MUST(snell_scene_add_perspective_camera(bench.scene, &camera, NULL));
    add_quad(&bench, v3(-4, -4, 0), v3(8, 0, 0), v3(0, 8, 0), add_lambert(&bench, grey(0.5)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    MUST(snell_render(bench.scene, &desc, bench.film));
    double wide = 33 / (2 * 5 * tan((double)camera.fov / 2));
    ASSERT_CLOSE(value("motion", 16, 16, 0), -0.5 * wide, 1e-4, 0);
    ASSERT_CLOSE(value("motion", 16, 16, 1), 0, 0, 1e-5);
}

/* Functions of time, in one another: asked about the next frame only where somebody wants to know, and no ray sees
 * that they were. */
static void test_motion_of_functions(void **state) {
    (void)state;
    static const char program[] =
        "animation { fps = 24 }\n"
        "camera { from = {0, 0, 5}, at = {0, 0, 0} }\n"
        "ambient { color = 1 }\n"
        "local function right(t) return transform.translate {12 * t, 0, 0} end\n"
        "local function turn(t) return transform.rotate { axis = {0, 0, 1}, angle = 240 * t } end\n"
        "group { motion = right, group { motion = turn,\n"
        "  quad { corner = {-4, -4, 0}, u = {8, 0, 0}, v = {0, 8, 0},\n"
        "         material = material.lambert { color = .5 } } } }\n";
    static float seen[33 * 33 * 3];
    char path[] = "/tmp/snell-test-XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(write(file, program, sizeof program - 1), sizeof program - 1);
    close(file);
    for (int asked = 0; asked < 2; asked++) {
        rig_clear(&bench);
        snell_load_desc desc = SNELL_INIT(load_desc);
        desc.format = "lua";
        desc.next_frame = asked;
        MUST(snell_scene_load(bench.scene, path, &desc));
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        if (asked) check_motion(0.5, 0, 0.04);
        film_moving(0.5f);
        uint32_t width, height, channels;
        const float *pixels = snell_film_pixels(bench.film, &width, &height, &channels);
        assert_int_equal(width * height * channels, 33 * 33 * 3);
        if (asked) assert_memory_equal(pixels, seen, sizeof seen);
        memcpy(seen, pixels, sizeof seen);
    }
    unlink(path);
}

/* ---- light ---- */

/* All kinds of it: a lamp that is seen, a point, a sky of two, ambient light, a mirror, glass, gloss, a
 * card that is there in part, and a plane that shines but is no light. */
static void build_lights(void) {
    snell_material_id matte = add_lambert(&bench, v3(0.7, 0.5, 0.3)), glow = {0, 0};
    snell_ggx_desc gloss = SNELL_INIT(ggx_desc);
    snell_material_id glossy;
    snell_lambert_desc warm = SNELL_INIT(lambert_desc);
    snell_quad_light_desc lamp = SNELL_INIT(quad_light_desc);
    snell_environment_light_desc sky = SNELL_INIT(environment_light_desc);
    gloss.color = flat(v3(0.2, 0.4, 0.6));
    gloss.roughness = flat(grey(0.3));
    MUST(snell_scene_add_ggx(bench.scene, &gloss, &glossy));
    warm.color = flat(grey(0.2));
    warm.emission = flat(v3(0.3, 0.1, 0.05));
    MUST(snell_scene_add_lambert(bench.scene, &warm, &glow));
    add_plane(&bench, v3(0, -1, 0), v3(0, 1, 0), glow);
    add_sphere(&bench, v3(-1.5, 0, 0), 0.9, matte);
    add_sphere(&bench, v3(0.4, 0, 0), 0.9, add_glass(&bench, 1.5, v3(0.1, 0.2, 0.3), 0));
    add_sphere(&bench, v3(2.2, 0, -0.5), 0.8, add_mirror(&bench, grey(0.9)));
    add_sphere(&bench, v3(0, 1.6, -1), 0.6, glossy);
    add_quad(&bench, v3(-3, -1, 1.2), v3(2, 0, 0), v3(0, 1, 0), add_card(&bench, v3(1, 1, 0), 0.5));
    lamp.corner = v3(-1, 3, -1);
    lamp.u = v3(2, 0, 0);
    lamp.v = v3(0, 0, 2);
    lamp.radiance = grey(4);
    MUST(snell_scene_add_quad_light(bench.scene, &lamp, NULL));
    add_point(&bench, v3(3, 4, 5), v3(30, 20, 10));
    sky.radiance = flat(v3(0.2, 0.3, 0.5));
    MUST(snell_scene_add_environment_light(bench.scene, &sky, NULL));
    sky.radiance = flat(v3(0.1, 0.05, 0.02));
    MUST(snell_scene_add_environment_light(bench.scene, &sky, NULL));
    MUST(snell_scene_set_ambient(bench.scene, v3(0.05, 0.04, 0.03)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
}

/* One block through the loop itself, whose sums are integers: what adds up does so to the last bit. */
static void adds_up_exactly(const snell_render_desc *desc) {
    prepared_render prepared;
    aov_set wanted;
    aov_plan *plan;
    wave *w;
    film layers = {.pixels = NULL};
    film_block *sums = memory_aligned(sizeof *sums);
    MUST(prepare_render(bench.scene, desc, &prepared));
    MUST(aov_parse(desc->aov, &wanted));
    MUST(aov_plan_create(wanted, &prepared.options.wave, bench.scene->description, &plan));
    prepared.options.wave.aovs = plan;
    MUST(film_resize(&layers, 1, 1, 3));
    MUST(aov_plan_add_layers(plan, &layers));
    uint32_t lamps = 0;
    for (size_t i = 0; i < layers.layer_count; i++)
        lamps += layers.layers[i].kind == &aov_table[AOV_light];
    assert_true(lamps >= 5);
    aov_block *b;
    MUST(wave_create(&prepared.options.wave, &w));
    MUST(aov_block_create(plan, &b));
    wave_collect(w, b);
    const wave_samples samples = {0, desc->samples, 0, desc->samples};
    for (uint32_t block = 0; block < 4; block++) {
        uint32_t x = block % 2 * 16, y = block / 2 * 16;
        aov_block_clear(b);
        MUST(wave_render_block(w, x, y, x + 16, y + 16, &samples, sums, NULL, NULL));
        for (uint32_t i = 0; i < 256; i++)
            for (int c = 0; c < 3; c++) {
                fixed128 by_depth = aov_block_sums(b, AOV_emission, 0, i)[c] +
                                    aov_block_sums(b, AOV_direct, 0, i)[c] +
                                    aov_block_sums(b, AOV_indirect, 0, i)[c],
                         by_light = 0;
                for (uint32_t k = 0; k < lamps; k++)
                    by_light += aov_block_sums(b, AOV_light, k, i)[c];
                assert_true(by_depth == sums->sums[i][c]);
                assert_true(by_light == sums->sums[i][c]);
                fixed128 bounced = aov_block_sums(b, AOV_reflection, 0, i)[c] +
                                   aov_block_sums(b, AOV_refraction, 0, i)[c];
                assert_true(bounced <= sums->sums[i][c]);
            }
    }
    wave_destroy(w);
    aov_block_destroy(b);
    aov_plan_destroy(plan);
    film_free(&layers);
    prepared_render_free(&prepared);
    memory_free_aligned(sums);
}

static void test_light_adds_up(void **state) {
    (void)state;
    build_lights();
    for (int i = 0; i < 4; i++)
        for (int transparent = 0; transparent < 2; transparent++) {
            snell_render_desc desc = picture(policies[i], 32, 32, 5);
            snell_view view = look(v3(0, 1, 8), v3(0, 0.5, 0));
            desc.samples = 4;
            desc.pixel_center = false;
            desc.transparent = transparent != 0;
            desc.view = &view;
            desc.aov = EVERY;
            adds_up_exactly(&desc);
        }
}

static char warning[512];

static void keep_warning(void *user, const snell_message *message) {
    (void)user;
    if (message->severity == SNELL_WARNING) snprintf(warning, sizeof warning, "%s", message->text);
}

/* More lights than layers: nothing is lost, and a warning names those that share one. */
static void test_many_lights(void **state) {
    (void)state;
    build_ball_and_wall();
    for (int i = 0; i < 70; i++) add_point(&bench, v3(i - 35, 5, 5), grey(1 + i));
    MUST(snell_scene_set_background(bench.scene, grey(0.5), 1));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_render_desc desc = picture(SNELL_WHITTED, 32, 32, 3);
    snell_view view = look(v3(0, 0, 5), v3(0, 0, 0));
    desc.view = &view;
    desc.aov = "emission,direct,indirect,light,reflection,refraction";
    adds_up_exactly(&desc);
    log_sink usual = bench.context->log;
    bench.context->log = (log_sink){keep_warning, NULL};
    warning[0] = '\0';
    MUST(snell_render(bench.scene, &desc, bench.film));
    bench.context->log = usual;
    assert_string_equal(warning, "64 lights have layers of their own, 8 more share light.other: "
                                 "point #65, point #66, point #67, point #68, point #69, "
                                 "point #70, point #71, background");
    snell_aov aov;
    uint32_t count = 0;
    while (snell_film_aov(bench.film, count, &aov)) count++;
    assert_int_equal(count, 5 + 64 + 1);
    assert_true(value("light.other", 0, 0, 0) > 0);
    assert_true(value("light.point #64", 16, 20, 0) > 0);
}

/* The floats of the API, over all pixels. */
static void adds_up(size_t pixel_count) {
    static const char *const parts[] = {"emission", "direct", "indirect"};
    const float *whole = snell_film_pixels(bench.film, NULL, NULL, NULL);
    double largest[3] = {0, 0, 0};
    for (size_t k = 0; k < pixel_count * 3; k++) {
        double sum = 0;
        for (int p = 0; p < 3; p++) {
            double part = (double)find(bench.film, parts[p], NULL)[k];
            sum += part;
            if (part > largest[p]) largest[p] = part;
        }
        ASSERT_CLOSE(sum, (double)whole[k], 3e-7, 0);
    }
    for (int p = 0; p < 3; p++) assert_true(largest[p] > 0.01);
}

static void test_layers_add_up(void **state) {
    (void)state;
    build_lights();
    for (int i = 0; i < 4; i++) {
        snell_render_desc desc = picture(policies[i], 37, 21, 5);
        desc.samples = 3;
        desc.pixel_center = false;
        render_from(&desc, v3(0, 1, 8), v3(0, 0.5, 0), "emission,direct,indirect");
        adds_up(37 * 21);
    }
}

static void write_scene(const char *text) {
    FILE *f = fopen(file_path("scene.lua"), "w");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
}

static void load(const char *text) {
    const char *path = file_path("scene.lua");
    write_scene(text);
    snell_load_desc desc = SNELL_INIT(load_desc);
    MUST(snell_scene_load(bench.scene, path, &desc));
    unlink(path);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
}

#define TWO_THINGS                                                                                 \
    "camera { from = {0, 1, 6}, at = {0, 0, 0} }\n"                                                \
    "sphere { radius = 1, name = 'ball', material = material.mirror { color = 0.5 } }\n"           \
    "plane { point = {0, -1, 0}, name = 'floor', material = material.lambert { color = 0.5, "      \
    "name = 'grey' } }\n"

/* With one lamp of the two taken away, the picture is the other's layer: to the bit, where no chance is
 * in it (a lamp's number chooses its points in cook). */
static void test_lights_by_name(void **state) {
    (void)state;
    static const char *const lamps[2] = {
        "light.point { position = {3, 4, 3}, intensity = 70, name = 'key' }\n",
        "light.sphere { center = {-2, 3, 1}, radius = 0.5, radiance = {3, 2, 1}, name = 'fill' "
        "}\n"};
    enum { SIZE = 40 * 30 * 3 };
    static float layers[2][SIZE];
    for (int i = 0; i < 2; i++)
        for (int which = -1; which < 2; which++) {
            char text[1024];
            rig_clear(&bench);
            snprintf(text, sizeof text, "%s%s%s", TWO_THINGS, which != 1 ? lamps[0] : "",
                     which != 0 ? lamps[1] : "");
            load(text);
            snell_render_desc desc = picture(policies[i], 40, 30, 4);
            desc.samples = 2;
            desc.pixel_center = false;
            desc.aov = which < 0 ? "light" : NULL;
            MUST(snell_render(bench.scene, &desc, bench.film));
            if (which < 0) {
                memcpy(layers[0], find(bench.film, "light.key", NULL), sizeof layers[0]);
                memcpy(layers[1], find(bench.film, "light.fill", NULL), sizeof layers[1]);
            } else {
                const float *alone = snell_film_pixels(bench.film, NULL, NULL, NULL);
                assert_memory_equal(layers[which], alone, sizeof layers[which]);
            }
        }
}

/* By hand: a lamp that is seen, what it lights, and that again in a mirror. */
static void test_light_by_kind(void **state) {
    (void)state;
    add_quad(&bench, v3(-9, -9, -2), v3(18, 0, 0), v3(0, 18, 0), add_mirror(&bench, grey(0.5)));
    add_sphere(&bench, v3(0, 0, 20), 1, add_glow(&bench, v3(3, 2, 1)));
    MUST(snell_scene_set_background(bench.scene, v3(0.25, 0.5, 1), 1));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_render_desc desc = picture(SNELL_WHITTED, 1, 1, 3);
    /* Straight at the glow: emission. */
    render_from(&desc, v3(0, 0, 10), v3(0, 0, 20), EVERY);
    is_vector("emission", 0, 0, 3, 2, 1);
    is_vector("direct", 0, 0, 0, 0, 0);
    is_vector("light.sphere #2", 0, 0, 3, 2, 1);
    /* Into the mirror: the glow once scattered, all of it reflected. */
    render_from(&desc, v3(0, 0, 10), v3(0, 0, -2), EVERY);
    is_vector("direct", 0, 0, 1.5, 1, 0.5);
    is_vector("reflection", 0, 0, 1.5, 1, 0.5);
    is_vector("emission", 0, 0, 0, 0, 0);
    is_vector("indirect", 0, 0, 0, 0, 0);
    is_vector("refraction", 0, 0, 0, 0, 0);
    /* The sky. */
    render_from(&desc, v3(0, 0, 10), v3(0, 20, 10), EVERY);
    is_vector("emission", 0, 0, 0.25, 0.5, 1);
    is_vector("light.background", 0, 0, 0.25, 0.5, 1);
    is_vector("light.sphere #2", 0, 0, 0, 0, 0);
}

static void test_glass(void **state) {
    (void)state;
    add_box(&bench, v3(-9, -9, -1), v3(9, 9, 0), add_glass(&bench, 1.5, grey(0), 0));
    MUST(snell_scene_set_background(bench.scene, grey(1), 1));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_render_desc desc =
        picture(SNELL_WHITTED, 1, 1, 1); /* one bounce: the front face's two rays */
    render_from(&desc, v3(0, 0, 5), v3(0, 0, 0), EVERY);
    double f = 0.04; /* ((1.5 - 1) / (1.5 + 1))^2 */
    ASSERT_CLOSE(value("reflection", 0, 0, 0), f, 1e-6, 0);
    ASSERT_CLOSE(value("refraction", 0, 0, 0), 0, 0, 1e-9); /* it ends inside */
    desc.max_depth = 2;
    render_from(&desc, v3(0, 0, 5), v3(0, 0, 0), EVERY);
    ASSERT_CLOSE(value("reflection", 0, 0, 0), f, 1e-6, 0);
    ASSERT_CLOSE(value("refraction", 0, 0, 0), (1 - f) * (1 - f), 1e-6, 0);
    is_vector("albedo", 0, 0, 1, 1, 1);
}

static void test_rays(void **state) {
    (void)state;
    build_ball_and_wall();
    snell_render_desc desc = picture(SNELL_APPEL, 41, 41, 0);
    desc.samples = 3;
    render_from(&desc, v3(0, 0, 5), v3(0, 0, 0), "rays");
    assert_true(value("rays", 20, 20, 0) == 6); /* three, each with a shadow ray */
    assert_true(value("rays", 1, 0, 0) == 3);
    double sum = 0;
    for (uint32_t i = 0; i < 41 * 41; i++) sum += (double)find(bench.film, "rays", NULL)[i];
    snell_render_stats stats = stats_of(&bench);
    assert_true(sum == (double)(stats.rays_camera + stats.rays_shadow));
}

/* ---- cryptomatte ---- */

static void test_crypto_ids(void **state) {
    (void)state;
    /* The specification's manifests, and its authors' table of floats. */
    assert_int_equal(crypto_id("bunny"), 0x13851a76);
    assert_int_equal(crypto_id("default"), 0x42c9679f);
    assert_int_equal(crypto_id("bunny_porcelain_mat"), 0xb24b26d4);
    static const struct {
        const char *name;
        double value;
    } rows[] = {
        {"hello", 6.0705627102400005616e-17},
        {"cube", -4.08461912519e+15},
        {"sphere", 2.79018604383e+15},
        {"plane", 3.66557617593e-11},
        {"\xd1\x80\xd0\xb0\xd0\xb2\xd0\xbd\xd0\xb8\xd0\xbd\xd0\xb0", -1.3192631212399999468e-25},
        {"m\xc3\xa4"
         "dchen",
         6.2361298211599995797e+25}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        ASSERT_CLOSE((double)crypto_float(crypto_id(rows[i].name)), rows[i].value, 1e-7, 0);
    assert_int_equal(crypto_hash(""), 0);
    /* Exponents 0 and 255 are no numbers: search a name for each. */
    bool low = false, high = false;
    for (uint32_t i = 0; !(low && high) && i < 100000; i++) {
        char name[16];
        snprintf(name, sizeof name, "x%u", i);
        uint32_t exponent = crypto_hash(name) >> 23 & 255, kept = crypto_id(name) >> 23 & 255;
        low |= exponent == 0, high |= exponent == 255;
        assert_int_equal(kept, exponent == 0 ? 1 : exponent == 255 ? 254 : exponent);
    }
    assert_true(low && high);
}

static void test_manifest(void **state) {
    (void)state;
    load(TWO_THINGS "sphere { center = {0, 3, 0}, radius = 0.1, name = 'a \"b\"' }\n"
                    "sphere { center = {0, 4, 0}, radius = 0.1 }\n");
    snell_render_desc desc = picture(SNELL_WHITTED, 8, 8, 1);
    desc.aov = "crypto_object,crypto_material";
    MUST(snell_render(bench.scene, &desc, bench.film));
    snell_aov aov;
    assert_true(snell_film_aov(bench.film, 0, &aov));
    char expected[256];
    snprintf(expected, sizeof expected,
             "{\"a \\u0022b\\u0022\":\"%08x\",\"ball\":\"%08x\",\"floor\":\"%08x\","
             "\"sphere:5\":\"%08x\"}",
             crypto_id("a \"b\""), crypto_id("ball"), crypto_id("floor"), crypto_id("sphere:5"));
    assert_string_equal(aov.manifest, expected);
    assert_true(snell_film_aov(bench.film, 1, &aov));
    assert_non_null(strstr(aov.manifest, "\"grey\":"));
    assert_non_null(strstr(aov.manifest, "\"default\":\"42c9679f\""));
    assert_false(snell_film_aov(bench.film, 2, &aov));
}

/* ---- the same everywhere ---- */

static uint64_t hash_of_layers(const snell_film *f, uint32_t width, uint32_t height) {
    uint64_t hash = snell_film_hash(f);
    snell_aov aov;
    for (uint32_t i = 0; snell_film_aov(f, i, &aov); i++) {
        const uint8_t *bytes = (const uint8_t *)aov.pixels;
        size_t size = (size_t)width * height * aov.channel_count * sizeof(float);
        for (size_t k = 0; k < size; k++) hash = (hash ^ bytes[k]) * 0x100000001b3u;
    }
    return hash;
}

static void test_same_bits(void **state) {
    (void)state;
    rig usual = bench;
    for (int i = 0; i < 4; i++) {
        uint64_t first = 0, plain = 0;
        for (int way = 0; way < 4; way++) {
            bench = rig_make(way == 1 ? 1 : 3, way == 2 ? SNELL_ISA_SCALAR : SNELL_ISA_AUTO);
            build_lights();
            snell_render_desc desc = picture(policies[i], 50, 40, 5);
            desc.samples = 5;
            desc.pixel_center = false;
            desc.wave_size = way == 3 ? 7 : 0;
            render_from(&desc, v3(0, 1, 8), v3(0, 0.5, 0), EVERY);
            uint64_t hash = hash_of_layers(bench.film, 50, 40),
                     picture_hash = snell_film_hash(bench.film);
            if (way == 0) first = hash, plain = picture_hash;
            assert_true(hash == first);
            render_from(&desc, v3(0, 1, 8), v3(0, 0.5, 0), NULL); /* AOVs change no picture */
            assert_true(snell_film_hash(bench.film) == plain && picture_hash == plain);
            assert_false(snell_film_aov(bench.film, 0, &(snell_aov){0}));
            rig_free(&bench);
        }
    }
    bench = usual;
}

/* Of a picture that ends before it is done: what is there is what it would have been. */
static bool two_blocks(void *user, const snell_progress *p) {
    (void)user;
    return !(p->fraction > 0.3);
}

static void test_cancelled(void **state) {
    (void)state;
    rig usual = bench;
    bench = rig_make(1, SNELL_ISA_AUTO);
    build_lights();
    enum { SIDE = 96 };
    snell_render_desc desc = picture(SNELL_WHITTED, SIDE, SIDE, 5);
    desc.samples = 64;
    desc.pixel_center = false;
    render_from(&desc, v3(0, 1, 8), v3(0, 0.5, 0), "depth,direct");
    float *whole = malloc(SIDE * SIDE * sizeof *whole);
    memcpy(whole, find(bench.film, "depth", NULL), SIDE * SIDE * sizeof *whole);
    snell_view view = look(v3(0, 1, 8), v3(0, 0.5, 0));
    desc.view = &view;
    desc.progress = two_blocks;
    if (snell_render(bench.scene, &desc, bench.film) ==
        SNELL_CANCELLED) { /* unless it was too quick */
        size_t same = 0, none = 0;
        const float *part = find(bench.film, "depth", NULL);
        for (size_t i = 0; i < SIDE * SIDE; i++) same += part[i] == whole[i], none += part[i] == 0;
        assert_true(same > 0 && none > 0 && same + none == SIDE * SIDE);
    } else {
        print_message("NOT TESTED: the render was done before it could be stopped\n");
    }
    free(whole);
    rig_free(&bench);
    bench = usual;
}

/* ---- rounds of --noise and --time-limit ---- */

/* Six rounds are the same as one. */
static void test_rounds(void **state) {
    (void)state;
    build_lights();
    for (int i = 0; i < 4; i++) {
        snell_render_desc desc = picture(policies[i], 50, 40, 5);
        desc.samples = 40;
        desc.pixel_center = false;
        render_from(&desc, v3(0, 1, 8), v3(0, 0.5, 0), EVERY);
        uint64_t hash = hash_of_layers(bench.film, 50, 40);
        desc.time_limit = 1000;
        render_from(&desc, v3(0, 1, 8), v3(0, 0.5, 0), EVERY);
        assert_true(hash_of_layers(bench.film, 50, 40) == hash);
    }
}

/* Where textures are filtered a first round is thrown away. */
static void test_starting_over(void **state) {
    (void)state;
    uint64_t hash = 0;
    MUST(snell_scene_load(bench.scene, TEST_SOURCE_DIR "/scenes/motion-blur.lua", NULL));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    for (int limited = 0; limited < 2; limited++) {
        snell_render_desc desc = SNELL_INIT(render_desc);
        MUST(snell_scene_settings(bench.scene, 0, &desc));
        desc.width = 24;
        desc.height = 18;
        desc.samples = 5;
        desc.time_limit = limited ? 1000 : 0;
        desc.aov = EVERY;
        MUST(snell_render(bench.scene, &desc, bench.film));
        if (!limited) hash = hash_of_layers(bench.film, 24, 18);
    }
    assert_true(hash_of_layers(bench.film, 24, 18) == hash);
}

static snell_render_desc with_noise(void) {
    snell_render_desc desc = picture(SNELL_PATH, 50, 40, 5);
    desc.samples = 96;
    desc.pixel_center = false;
    desc.noise = 0.1f;
    return desc;
}

/* Each block has its own number of samples, and a pixel four first ones: ids are those of the first. */
static void test_noise(void **state) {
    (void)state;
    rig usual = bench;
    uint64_t first = 0;
    for (int way = 0; way < 4; way++) {
        bench = rig_make(way == 1 ? 1 : 3, way == 2 ? SNELL_ISA_SCALAR : SNELL_ISA_AUTO);
        build_lights();
        snell_render_desc desc = with_noise();
        desc.wave_size = way == 3 ? 7 : 0;
        render_from(&desc, v3(0, 1, 8), v3(0, 0.5, 0), EVERY);
        if (way == 0) first = hash_of_layers(bench.film, 50, 40);
        assert_true(hash_of_layers(bench.film, 50, 40) == first);
        if (way < 3) rig_free(&bench);
    }
    snell_render_stats s = stats_of(&bench);
    assert_true(s.samples_min < s.samples_done);
    adds_up(50 * 40);
    double rays = 0, coverage = 0;
    float ids[50 * 40];
    for (uint32_t i = 0; i < 50 * 40; i++) {
        rays += value("rays", i % 50, i / 50, 0);
        ids[i] = (float)value("object_id", i % 50, i / 50, 0);
        for (uint32_t rank = 0; rank < 6; rank++)
            coverage = fmax(coverage, value("crypto_object", i % 50, i / 50, 2 * rank + 1));
    }
    assert_true(coverage == 1);
    assert_true(rays == (double)(s.rays_camera + s.rays_reflected + s.rays_refracted +
                                 s.rays_continued + s.rays_shadow));
    snell_render_desc desc = with_noise();
    desc.noise = 0;
    desc.samples = 1;
    render_from(&desc, v3(0, 1, 8), v3(0, 0.5, 0), "object_id");
    bool nothing = false;
    for (uint32_t i = 0; i < 50 * 40; i++) {
        assert_true(ids[i] == (float)value("object_id", i % 50, i / 50, 0));
        nothing |= ids[i] == 0;
    }
    assert_true(nothing);
    rig_free(&bench);
    bench = usual;
}

static bool until_known(void *user, const snell_progress *p) {
    (void)user;
    return !(p->noise > 0);
}

/* Stopped in the midst of a round: that round is in no layer, as it is not in the picture. */
static void test_noise_cancelled(void **state) {
    (void)state;
    build_lights();
    snell_render_desc desc = with_noise();
    snell_view view = look(v3(0, 1, 8), v3(0, 0.5, 0));
    desc.view = &view;
    desc.aov = "emission,direct,indirect";
    desc.noise = 1e-6f;
    desc.samples = 1 << 20;
    desc.progress = until_known;
    assert_int_equal(snell_render(bench.scene, &desc, bench.film), SNELL_CANCELLED);
    adds_up(50 * 40);
}

/* ---- names ---- */

static void test_names(void **state) {
    (void)state;
    const char *name, *channels, *help;
    uint32_t count = 0;
    char all[1024] = "";
    for (; (name = snell_aov_name(count, &channels, &help)) != NULL; count++) {
        assert_true(channels[0] && help[0]);
        snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", count ? "," : "", name);
    }
    assert_string_equal(all, EVERY);
    snell_aov_name(0, &channels, NULL);
    assert_string_equal(channels, "Z");
    snell_aov_name(2, &channels, NULL);
    assert_string_equal(channels, "N.X N.Y N.Z");
    build_ball_and_wall();
    snell_render_desc desc = picture(SNELL_WHITTED, 4, 4, 1);
    snell_view view = look(v3(0, 0, 5), v3(0, 0, 0));
    desc.view = &view;
    static const struct {
        const char *list, *message, *hint;
    } bad[] = {{"depht", "there is no AOV 'depht'", "did you mean 'depth'?"},
               {"depth,", NULL, NULL},
               {"depth,,normal", "there is no AOV ''", ""},
               {"depth;normal", "there is no AOV 'depth;normal'", ""},
               {"DEPTH", "there is no AOV 'DEPTH'", ""}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        desc.aov = bad[i].list;
        snell_status status = snell_render(bench.scene, &desc, bench.film);
        assert_int_equal(status, bad[i].message ? SNELL_ERR_ARGUMENT : SNELL_OK);
        if (bad[i].message == NULL) continue;
        assert_string_equal(snell_last_error()->text, bad[i].message);
        if (bad[i].hint[0]) assert_string_equal(snell_last_error()->hint, bad[i].hint);
    }
    desc.aov = " depth , normal ";
    MUST(snell_render(bench.scene, &desc, bench.film));
    find(bench.film, "normal", NULL);
    char text[16];
    MUST(snell_film_aov_channel(bench.film, 1, 2, text, sizeof text));
    assert_string_equal(text, "N.Z");
    MUST(snell_film_aov_channel(bench.film, 1, 2, text, 2));
    assert_string_equal(text, "N");
    assert_int_equal(snell_film_aov_channel(bench.film, 1, 3, text, 16), SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_film_aov_channel(bench.film, 2, 0, text, 16), SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_film_aov_channel(NULL, 0, 0, text, 16), SNELL_ERR_ARGUMENT);
    assert_false(snell_film_aov(NULL, 0, &(snell_aov){0}) || snell_film_aov(bench.film, 0, NULL));
    snell_image_desc image = SNELL_INIT(image_desc);
    void *data;
    size_t size;
    image.aov = "normol";
    assert_int_equal(snell_film_encode(bench.film, "png", &image, &data, &size),
                     SNELL_ERR_ARGUMENT);
    assert_string_equal(snell_last_error()->hint, "did you mean 'normal'?");
}

static void test_settings(void **state) {
    (void)state;
    load("render { aov = 'depth,light' }\n" TWO_THINGS);
    snell_render_desc desc = {.struct_size = sizeof desc};
    MUST(snell_scene_settings(bench.scene, 0, &desc));
    assert_string_equal(desc.aov, "depth,light");
    rig_clear(&bench);
    load(TWO_THINGS);
    MUST(snell_scene_settings(bench.scene, 0, &desc));
    assert_null(desc.aov);
    snell_load_desc how = SNELL_INIT(load_desc);
    write_scene("sphere { radius = 1 }\nrender { aov = 'depth,nromal' }\n");
    assert_int_equal(snell_scene_load(bench.scene, file_path("scene.lua"), &how), SNELL_ERR_SYNTAX);
    assert_non_null(strstr(snell_last_error()->text, "there is no AOV 'nromal'"));
    assert_string_equal(snell_last_error()->hint, "did you mean 'normal'?");
    assert_int_equal(snell_last_error()->line, 2);
    unlink(file_path("scene.lua"));
}

/* ---- files ---- */

static void compare_layer(snell_film *back, const char *path, const char *layer,
                          const float *values, uint32_t channels, const int places[3],
                          size_t count) {
    snell_film_read_desc desc = SNELL_INIT(film_read_desc);
    desc.layer = layer;
    MUST(snell_film_read(back, path, &desc));
    uint32_t read;
    const float *p = snell_film_pixels(back, NULL, NULL, &read);
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++) {
            float expected = places[c] < 0 ? 0 : values[i * channels + (size_t)places[c]];
            assert_true(p[i * read + (size_t)c] == expected);
        }
}

static void test_exr(void **state) {
    (void)state;
    const char *missing;
    snell_features(&missing);
    if (strstr(missing, "openexr")) {
        print_message("NOT TESTED: this build has no OpenEXR\n");
        skip();
    }
    load(TWO_THINGS "light.point { position = {3, 4, 3}, intensity = 70, name = 'key' }\n");
    snell_render_desc desc = picture(SNELL_WHITTED, 45, 37, 3);
    desc.aov = EVERY;
    MUST(snell_render(bench.scene, &desc, bench.film));
    const char *path = file_path("exr");
    snell_image_desc image = SNELL_INIT(image_desc);
    image.tag = "how";
    MUST(snell_film_write(bench.film, path, &image));
    snell_film *back;
    MUST(snell_film_create(bench.context, &back));
    const size_t count = 45 * 37;
    MUST(snell_film_read(back, path, NULL));
    assert_true(snell_film_hash(back) == snell_film_hash(bench.film));
    assert_string_equal(snell_film_layer(back, 0), "picture");
    assert_string_equal(snell_film_layer(back, 1), "depth");
    static const struct {
        const char *layer, *aov;
        int places[3];
    } rows[] = {{"depth", "depth", {0, 0, 0}},
                {"Z", "depth", {0, 0, 0}},
                {"N", "normal", {0, 1, 2}},
                {"normal", "normal", {0, 1, 2}},
                {"N.Y", "normal", {1, 1, 1}},
                {"P", "position", {0, 1, 2}},
                {"albedo", "albedo", {0, 1, 2}},
                {"uv", "uv", {0, 1, -1}},
                {"motion", "motion", {0, 1, -1}},
                {"object_id", "object_id", {0, 0, 0}},
                {"direct", "direct", {0, 1, 2}},
                {"light.key", "light.key", {0, 1, 2}},
                {"rays", "rays", {0, 0, 0}},
                {"CryptoObject00", "crypto_object", {0, 1, 2}},
                {"CryptoMaterial02.A", "crypto_material", {11, 11, 11}}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint32_t channels = 0;
        const float *values = find(bench.film, rows[i].aov, &channels);
        compare_layer(back, path, rows[i].layer, values, channels, rows[i].places, count);
    }
    snell_picture_info info = {.struct_size = sizeof info};
    MUST(snell_picture_read_info(path, &info));
    assert_true(info.channels == 3 && info.width == 45 && info.height == 37);
    assert_string_equal(info.tag, "how");
    static const char *const lines[] = {"depth: Z\n", "normal: N.X N.Y N.Z\n", "rays: rays\n",
                                        "light.key: light.key.B light.key.G light.key.R\n",
                                        "object_id: objectId\n"};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        assert_non_null(strstr(info.layers, lines[i]));
    snell_free(info.tag);
    snell_free(info.layers);
    snell_film_destroy(back);
    unlink(path);
}

/* The numbers of one AOV in a linear file; and for the eye, by hand where it is simple. */
static void test_pictures(void **state) {
    (void)state;
    build_ball_and_wall();
    snell_render_desc desc = picture(SNELL_WHITTED, 41, 41, 1);
    render_from(&desc, v3(0, 0, 5), v3(0, 0, 0), EVERY);
    snell_image_desc image = SNELL_INIT(image_desc);
    snell_film *back;
    MUST(snell_film_create(bench.context, &back));
    const char *path = file_path("pfm");
    image.aov = "normal";
    MUST(snell_film_write(bench.film, path, &image));
    MUST(snell_film_read(back, path, NULL));
    assert_memory_equal(snell_film_pixels(back, NULL, NULL, NULL), find(bench.film, "normal", NULL),
                        41 * 41 * 3 * sizeof(float));
    image.aov = "crypto_object";
    assert_int_equal(snell_film_write(bench.film, path, &image), SNELL_ERR_UNSUPPORTED);
    unlink(path);
    image.aov = "depth";
    image.exposure_set = true;
    image.exposure = 3; /* is for light */
    void *data;
    size_t size;
    MUST(snell_film_encode(bench.film, "ppm", &image, &data, &size));
    const uint8_t *p = (const uint8_t *)data + (size - 41 * 41 * 3);
    assert_int_equal(p[(20 * 41 + 20) * 3], 255);  /* the nearest */
    assert_in_range(p[(35 * 41 + 1) * 3], 25, 26); /* the farthest, a tenth */
    assert_int_equal(p[1 * 3], 0);                 /* nothing */
    snell_free(data);
    image.aov = "normal";
    MUST(snell_film_encode(bench.film, "ppm", &image, &data, &size));
    p = (const uint8_t *)data + (size - 41 * 41 * 3) + (20 * 41 + 20) * 3;
    assert_true(p[0] == 128 && p[1] == 128 && p[2] == 255);
    snell_free(data);
    /* All of them can be looked at. */
    snell_aov aov;
    for (uint32_t i = 0; snell_film_aov(bench.film, i, &aov); i++) {
        image.aov = aov.name;
        MUST(snell_film_encode(bench.film, "png", &image, &data, &size));
        snell_free(data);
    }
    snell_film_destroy(back);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_surfaces, fresh),
        cmocka_unit_test_setup(test_edges, fresh),
        cmocka_unit_test_setup(test_coverage, fresh),
        cmocka_unit_test_setup(test_motion_of_instances, fresh),
        cmocka_unit_test_setup(test_motion_of_groups, fresh),
        cmocka_unit_test_setup(test_motion_of_vertices, fresh),
        cmocka_unit_test_setup(test_motion_of_cameras, fresh),
        cmocka_unit_test_setup(test_motion_of_functions, fresh),
        cmocka_unit_test_setup(test_light_adds_up, fresh),
        cmocka_unit_test_setup(test_many_lights, fresh),
        cmocka_unit_test_setup(test_layers_add_up, fresh),
        cmocka_unit_test_setup(test_lights_by_name, fresh),
        cmocka_unit_test_setup(test_light_by_kind, fresh),
        cmocka_unit_test_setup(test_glass, fresh),
        cmocka_unit_test_setup(test_rays, fresh),
        cmocka_unit_test_setup(test_crypto_ids, fresh),
        cmocka_unit_test_setup(test_manifest, fresh),
        cmocka_unit_test_setup(test_same_bits, fresh),
        cmocka_unit_test_setup(test_cancelled, fresh),
        cmocka_unit_test_setup(test_rounds, fresh),
        cmocka_unit_test_setup(test_starting_over, fresh),
        cmocka_unit_test_setup(test_noise, fresh),
        cmocka_unit_test_setup(test_noise_cancelled, fresh),
        cmocka_unit_test_setup(test_names, fresh),
        cmocka_unit_test_setup(test_settings, fresh),
        cmocka_unit_test_setup(test_exr, fresh),
        cmocka_unit_test_setup(test_pictures, fresh),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
