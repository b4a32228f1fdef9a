/* Scenes of Mitsuba 3's render tests, path-traced and compared with its references pixel by pixel, as
 * its own src/render/tests/test_renders.py does: a z-test of the mean, with the variance per sample of
 * the reference (at least 1e-4), in XYZ, at the level .01 by Sidak over all pixels. A pixel passes when
 * its three numbers do; 99.75 % must. What is left out and why: docs/evidence/mitsuba.md.
 *
 * References and meshes are read from SNELL_MODELS/mitsuba-scenes. SNELL_FULL=1: sixteen times the
 * samples, so a quarter of the tolerance; and pictures are written. */
#include <sys/stat.h>
#include <unistd.h>

#include "render_test.h"

enum { SIZE = 48, PIXELS = SIZE * SIZE, BUDGET = 2000000, REFERENCE_SAMPLES = 32000 };

typedef struct picture_rgb {
    double p[PIXELS][3]; /* rows, top first */
} picture_rgb;

static const char *const integrator_names[] = {"", "appel", "whitted", "cook", "path"};

static rig bench;
static char folder[512];

static int start(void **state) {
    (void)state;
    bench = rig_make(0, SNELL_ISA_AUTO);
    const char *models = getenv("SNELL_MODELS");
    if (models) snprintf(folder, sizeof folder, "%s/mitsuba-scenes", models);
    return 0;
}

static int stop(void **state) {
    (void)state;
    rig_free(&bench);
    return 0;
}

static uint32_t sample_count(void) { return (full_tests() ? 16 : 1) * (uint32_t)(BUDGET / PIXELS); }

/* ---- pictures ---- */

/* Little-endian PFM, rows bottom first. */
static void read_pfm(const char *name, picture_rgb *out) {
    char path[700];
    int width = 0, height = 0;
    double scale = 0;
    snprintf(path, sizeof path, "%s/scenes/%s.pfm", folder, name);
    FILE *file = fopen(path, "rb");
    if (file == NULL) fail_msg("cannot read %s", path);
    assert_int_equal(fscanf(file, "PF %d %d %lf", &width, &height, &scale), 3);
    assert_true(fgetc(file) == '\n' && width == SIZE && height == SIZE && scale == -1);
    for (int y = SIZE - 1; y >= 0; y--)
        for (int i = 0; i < SIZE * 3; i++) {
            float value;
            assert_int_equal(fread(&value, sizeof value, 1, file), 1);
            out->p[y * SIZE + i / 3][i % 3] = (double)value;
        }
    fclose(file);
}

/* For eyes: after a failure, and in the long form. */
static void write_pfm(const char *scene, const char *what, const picture_rgb *picture) {
    char path[700];
    mkdir(TEST_BINARY_DIR "/evidence", 0777);
    snprintf(path, sizeof path, TEST_BINARY_DIR "/evidence/mitsuba_%s_%s.pfm", scene, what);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fprintf(file, "PF\n%d %d\n-1.0\n", SIZE, SIZE);
    for (int y = SIZE - 1; y >= 0; y--)
        for (int i = 0; i < SIZE * 3; i++) {
            float value = (float)picture->p[y * SIZE + i / 3][i % 3];
            fwrite(&value, sizeof value, 1, file);
        }
    fclose(file);
    print_message("wrote %s\n", path);
}

typedef struct box2 {
    uint32_t x, y, width, height;
} box2;
static const box2 ALL = {0, 0, SIZE, SIZE};

static bool inside(const box2 *box, uint32_t x, uint32_t y) {
    return x - box->x < box->width && y - box->y < box->height;
}

/* ---- rendering ---- */

static void load(const char *scene, const char *const *params, size_t count) {
    char path[512];
    snprintf(path, sizeof path, TEST_SOURCE_DIR "/tests/data/mitsuba/%s.lua", scene);
    const char *const folders[] = {folder};
    snell_load_desc desc = SNELL_INIT(load_desc);
    desc.params = params;
    desc.param_count = count;
    desc.asset_dirs = folders;
    desc.asset_dir_count = 1;
    rig_clear(&bench);
    snell_status status = snell_scene_load(bench.scene, path, &desc);
    if (status == SNELL_ERR_UNSUPPORTED) {
        print_message("SKIPPED: %s\n", snell_last_error()->text);
        skip();
    }
    must(status, path, __FILE__, __LINE__);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
}

/* A part of the picture, into its place. */
static void render_part(snell_integrator integrator, const box2 *part, picture_rgb *out) {
    snell_render_desc desc = {.struct_size = sizeof desc};
    MUST(snell_scene_settings(bench.scene, SNELL_PATH, &desc));
    assert_true(desc.width == SIZE && desc.height == SIZE && desc.max_depth <= 1);
    desc.integrator = integrator; /* with the depth that the scene asks for */
    desc.samples = sample_count();
    desc.crop_x = part->x, desc.crop_y = part->y;
    desc.crop_width = part->width, desc.crop_height = part->height;
    MUST(snell_render(bench.scene, &desc, bench.film));
    for (uint32_t y = 0; y < part->height; y++)
        for (uint32_t x = 0; x < part->width; x++) {
            rgb got = pixel_at(&bench, x, y);
            double *to = out->p[(part->y + y) * SIZE + part->x + x];
            for (int c = 0; c < 3; c++) to[c] = got.c[c];
        }
}

/* ---- the z-test ---- */

/* Of linear Rec. 709; the references' means and variances are those of X, Y and Z, stored as RGB. */
static void to_xyz(const double color[3], double xyz[3]) {
    static const double m[3][3] = {{0.412453, 0.357580, 0.180423},
                                   {0.212671, 0.715160, 0.072169},
                                   {0.019334, 0.119193, 0.950227}};
    for (int i = 0; i < 3; i++)
        xyz[i] = m[i][0] * color[0] + m[i][1] * color[1] + m[i][2] * color[2];
}

/* The largest z of a pixel. The reference counts as exact, as in Mitsuba's test, until we have as many
 * samples as it has. */
static double pixel_z(const double got[3], const double mean[3], const double variance[3]) {
    double a[3], b[3], v[3], z = 0, n = (double)sample_count();
    if (full_tests()) n = 1 / (1 / n + 1.0 / REFERENCE_SAMPLES);
    to_xyz(got, a);
    to_xyz(mean, b);
    to_xyz(variance, v);
    for (int c = 0; c < 3; c++) z = fmax(z, fabs(a[c] - b[c]) * sqrt(n / fmax(v[c], 1e-4)));
    return z;
}

static bool passes(double z) {
    double alpha = 1 - pow(1 - 0.01, 1.0 / PIXELS);
    return erfc(z / sqrt(2)) > alpha;
}

typedef struct comparison {
    picture_rgb got, mean, variance, z;
} comparison;

static void compare(comparison *c, const char *reference) {
    char name[200];
    read_pfm(reference, &c->mean);
    snprintf(name, sizeof name, "%s_var", reference);
    read_pfm(name, &c->variance);
    for (int i = 0; i < PIXELS; i++)
        for (int k = 0; k < 3; k++)
            c->z.p[i][k] = pixel_z(c->got.p[i], c->mean.p[i], c->variance.p[i]);
}

/* The share of the pixels of a part, without those of `left_out`, that pass; prints it. */
static double share(const comparison *c, const char *what, const box2 *part, const box2 *left_out,
                    size_t left_out_count) {
    int count = 0, passed = 0;
    double largest = 0;
    for (uint32_t y = 0; y < SIZE; y++)
        for (uint32_t x = 0; x < SIZE; x++) {
            bool counts = inside(part, x, y);
            for (size_t i = 0; i < left_out_count; i++) counts &= !inside(&left_out[i], x, y);
            if (!counts) continue;
            double z = c->z.p[y * SIZE + x][0];
            largest = fmax(largest, z);
            count++;
            passed += passes(z);
        }
    print_message("%-24s %4d of %4d pixels pass, %6.2f %%; largest z %.1f\n", what, passed, count,
                  100.0 * passed / count, largest);
    return (double)passed / count;
}

static void need_share(const comparison *c, const char *scene, const box2 *left_out, size_t count) {
    double passed = share(c, scene, &ALL, left_out, count);
    if (passed >= 0.9975 && !full_tests()) return;
    write_pfm(scene, "result", &c->got);
    write_pfm(scene, "reference", &c->mean);
    write_pfm(scene, "z", &c->z);
    if (passed >= 0.9975) return;
    fail_msg("%s: only %.2f %% of the pixels pass", scene, 100 * passed);
}

static void need_models(void) {
    if (folder[0] && access(folder, R_OK) == 0) return;
    print_message("SKIPPED: no Mitsuba scenes (set SNELL_MODELS)\n");
    skip();
}

/* ---- bsdf_spheres ---- */

/* The balls' pixels, rows from above, in each from the left; name and material are in spheres.lua. */
static const struct {
    const char *name;
    box2 box;
    bool same; /* else only close: no material of ours is that */
} balls[] = {
    {"glass_ggx", {0, 10, 9, 8}, true},
    {"plastic_beckmann", {10, 10, 8, 8}, true},
    {"plastic_diffuse", {20, 10, 8, 8}, false},
    {"conductor", {30, 10, 8, 8}, true},
    {"conductor_beckmann", {39, 10, 9, 8}, false},
    {"glass_beckmann", {0, 20, 9, 8}, true},
    {"plastic", {10, 20, 8, 8}, false},
    {"diamond", {20, 20, 8, 8}, true},
    {"textured", {30, 20, 8, 8}, true},
    {"diffuse", {39, 20, 9, 8}, true},
};
enum { BALLS = sizeof balls / sizeof balls[0] };

/* Most of the picture is background, which always passes; of a ball one pixel may fail. */
static const double BALL_SHARE = 0.98;

/* Two leaves cut out of squares by a texture that is not among the files. */
static const box2 leaves[] = {{30, 30, 8, 8}, {40, 30, 8, 8}};
enum { LEAVES = 2 };

static void render_ball(snell_integrator integrator, const char *light, const char *name,
                        const box2 *part, picture_rgb *out) {
    char params[3][600];
    snprintf(params[0], sizeof params[0], "models=%s", folder);
    snprintf(params[1], sizeof params[1], "light=%s", light);
    snprintf(params[2], sizeof params[2], "lit=%s", name);
    const char *const list[] = {params[0], params[1], params[2]};
    load("spheres", list, 3);
    render_part(integrator, part, out);
}

/* What is only close is for the table in the documentation. */
static bool is_rendered(size_t ball) { return balls[ball].same || full_tests(); }

static void spheres(snell_integrator integrator, const char *light, const char *reference) {
    static comparison c;
    box2 left_out[LEAVES + BALLS];
    size_t count = 0;
    need_models();
    for (; count < LEAVES; count++) left_out[count] = leaves[count];
    render_ball(integrator, light, "none", &ALL, &c.got);
    for (size_t i = 0; i < BALLS; i++) {
        if (!balls[i].same) left_out[count++] = balls[i].box;
        if (is_rendered(i)) render_ball(integrator, light, balls[i].name, &balls[i].box, &c.got);
    }
    compare(&c, reference);
    bool all = true;
    for (size_t i = 0; i < BALLS; i++) {
        char what[100];
        if (!is_rendered(i)) continue;
        snprintf(what, sizeof what, "  %s%s", balls[i].name, balls[i].same ? "" : " (close)");
        double passed = share(&c, what, &balls[i].box, NULL, 0);
        all &= passed >= BALL_SHARE || !balls[i].same;
    }
    char name[100];
    snprintf(name, sizeof name, "%s_%s", light, integrator_names[integrator]);
    need_share(&c, name, left_out, count);
    assert_true(all);
}

static void spheres_under_a_constant_sky(void **state) {
    (void)state;
    spheres(SNELL_PATH, "constant", "bsdf_spheres/refs/test_constant_ref_rgb");
}

static void spheres_under_an_area_light(void **state) {
    (void)state;
    spheres(SNELL_PATH, "area", "bsdf_spheres/refs/test_arealight_ref_rgb");
}

static void spheres_under_a_point_light(void **state) {
    (void)state;
    spheres(SNELL_PATH, "point", "bsdf_spheres/refs/test_pointlight_ref_rgb");
}

/* Not under the area light: where rough glass reflects, cook finds it by chance only, and needs many
 * more samples than the reference's variance grants. */
static void spheres_under_a_point_light_by_cook(void **state) {
    (void)state;
    spheres(SNELL_COOK, "point", "bsdf_spheres/refs/test_pointlight_ref_rgb");
}

/* ---- whole pictures, by every integrator ---- */

static void whole(const char *scene, const char *reference) {
    static comparison c;
    char param[600];
    need_models();
    snprintf(param, sizeof param, "models=%s", folder);
    const char *const list[] = {param};
    load(scene, list, 1);
    for (int i = SNELL_APPEL; i <= SNELL_PATH; i++) {
        char name[100];
        snprintf(name, sizeof name, "%s_%s", scene, integrator_names[i]);
        render_part((snell_integrator)i, &ALL, &c.got);
        compare(&c, reference);
        need_share(&c, name, NULL, 0);
    }
}

static void directional_light(void **state) {
    (void)state;
    whole("directional", "floating_sphere/refs/test_directional_ref_rgb");
}

static void spot_light_with_a_picture(void **state) {
    (void)state;
    whole("spot", "spot_light/refs/test_spot_ref_rgb");
}

/* ---- the test itself ---- */

/* A picture that is a little too bright must fail. */
static void the_test_can_fail(void **state) {
    (void)state;
    static comparison c;
    need_models();
    read_pfm("bsdf_spheres/refs/test_constant_ref_rgb", &c.got);
    compare(&c, "bsdf_spheres/refs/test_constant_ref_rgb");
    assert_true(share(&c, "the reference itself", &ALL, NULL, 0) == 1);
    for (int i = 0; i < PIXELS; i++)
        for (int k = 0; k < 3; k++) c.got.p[i][k] *= 1.01;
    compare(&c, "bsdf_spheres/refs/test_constant_ref_rgb");
    assert_true(share(&c, "one per cent brighter", &ALL, NULL, 0) < 0.5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_test_can_fail),
        cmocka_unit_test(spheres_under_a_constant_sky),
        cmocka_unit_test(spheres_under_an_area_light),
        cmocka_unit_test(spheres_under_a_point_light),
        cmocka_unit_test(spheres_under_a_point_light_by_cook),
        cmocka_unit_test(directional_light),
        cmocka_unit_test(spot_light_with_a_picture),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
