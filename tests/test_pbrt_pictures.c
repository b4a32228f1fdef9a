/* Pictures of pbrt scenes: numbers worked out by hand, and which side is left. */
#include <string.h>
#include <unistd.h>

#include "render_test.h"

#define PI 3.14159265358979323846

static rig bench;
static char path[300];

static int start(void **state) {
    (void)state;
    bench = rig_make(0, SNELL_ISA_AUTO);
    snprintf(path, sizeof path, "%s/snell_test_pbrt_picture_%d.pbrt",
             getenv("TMPDIR") ? getenv("TMPDIR") : "/tmp", (int)getpid());
    return 0;
}

static int stop(void **state) {
    (void)state;
    rig_free(&bench);
    unlink(path);
    return 0;
}

/* Renders 16 x 8 pixels. */
static void render(const char *before, const char *world) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fprintf(file,
            "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 8\n%s\n"
            "PixelFilter \"box\"\nWorldBegin\n%s\n",
            before, world);
    assert_int_equal(fclose(file), 0);
    rig_clear(&bench);
    snell_status status = snell_scene_load(bench.scene, path, NULL);
    if (status == SNELL_ERR_UNSUPPORTED) {
        print_message("SKIPPED: %s\n", snell_last_error()->text);
        skip();
    }
    must(status, path, __FILE__, __LINE__);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_render_desc desc = {.struct_size = sizeof desc};
    MUST(snell_scene_settings(bench.scene, 0, &desc));
    MUST(snell_render(bench.scene, &desc, bench.film));
}

static void shows(uint32_t x, uint32_t y, double r, double g, double b, double tolerance) {
    rgb got = pixel_at(&bench, x, y);
    const double want[3] = {r, g, b};
    for (int i = 0; i < 3; i++) {
        if (!(fabs(got.c[i] - want[i]) <= tolerance * (want[i] + 1e-3)))
            print_error("(%u, %u) is %g %g %g, not %g %g %g\n", x, y, got.c[0], got.c[1], got.c[2],
                        r, g, b);
        assert_true(fabs(got.c[i] - want[i]) <= tolerance * (want[i] + 1e-3));
    }
}

/* Straight down on a plane of reflectance 1/2, a millimetre wide. */
static const char above[] =
    "LookAt 0 5 0 0 0 0 0 0 1 Camera \"orthographic\" \"float screenwindow\" "
    "[-.002 .002 -.001 .001] \"float shutterclose\" 2\n"
    "Sampler \"zsobol\" \"integer pixelsamples\" 16";
static const char floor_below[] =
    "Shape \"bilinearmesh\" \"point3 P\" [-9 0 -9 9 0 -9 -9 0 9 9 0 9]\n";

static void lit_by(const char *lights, double irradiance, double tolerance) {
    char world[1000];
    snprintf(world, sizeof world, "%s%s", floor_below, lights);
    render(above, world);
    double seen = 0.5 / PI * irradiance;
    shows(8, 4, seen, seen, seen, tolerance);
    shows(3, 2, seen, seen, seen, tolerance);
}

/* Lambert's law, and 2: the shutter is open for two seconds. */
static void a_plane_has_the_light_that_it_should(void **state) {
    (void)state;
    lit_by("LightSource \"point\" \"rgb I\" [10 10 10] \"point3 from\" [0 2 0]", 2 * 10 / 4.0,
           1e-4);
    lit_by("LightSource \"point\" \"float power\" 100 \"point3 from\" [3 4 0]",
           2 * 100 / (4 * PI) / 25 * 0.8, 1e-3);
    lit_by("LightSource \"spot\" \"rgb I\" [1 1 1] \"point3 from\" [0 2 0] \"point3 to\" [0 0 0]",
           2 * 1 / 4.0, 1e-4);
    lit_by("LightSource \"distant\" \"float illuminance\" 4 \"point3 from\" [0 1 1] "
           "\"point3 to\" [0 0 0]",
           2 * 4 / sqrt(2), 1e-4);
    lit_by("LightSource \"infinite\" \"rgb L\" [.5 .5 .5]", 2 * PI / 2, 0.03);
    lit_by("LightSource \"infinite\" \"float illuminance\" 3", 2 * 3, 0.03);
    /* A small disk, from above: L A / r^2. It looks down after half a turn. */
    lit_by("AttributeBegin Translate 0 10 0 Rotate 90 1 0 0 AreaLightSource \"diffuse\" \"rgb L\" "
           "[100 100 100] Shape \"disk\" \"float radius\" .01 AttributeEnd",
           2 * 100 * PI * 1e-4 / 100, 2e-3);
    /* The other way round it shines away. */
    lit_by("AttributeBegin Translate 0 10 0 Rotate -90 1 0 0 AreaLightSource \"diffuse\" \"rgb L\" "
           "[100 100 100] Shape \"disk\" \"float radius\" .01 AttributeEnd",
           0, 1e-6);
    lit_by("AttributeBegin Translate 0 10 0 Rotate -90 1 0 0 ReverseOrientation AreaLightSource "
           "\"diffuse\" \"float power\" 10 Shape \"disk\" \"float radius\" .01 AttributeEnd",
           2 * 10 / PI / 100, 2e-3);
    /* Two triangles of 2e-4 m^2 each have all of the power each. */
    lit_by("AttributeBegin Translate 0 10 0 AreaLightSource \"diffuse\" \"float power\" 10 Shape "
           "\"trianglemesh\" \"point3 P\" [-.01 0 -.01 .01 0 -.01 .01 0 .01 -.01 0 .01] \"integer "
           "indices\" [0 1 2 0 2 3] AttributeEnd",
           2 * 20 / PI / 100, 2e-3);
}

/* +x is on the right, +y up, as in pbrt; what is named is a lamp of 30 degrees at distance 5. */
static void left_is_left(void **state) {
    (void)state;
    static const char world[] =
        "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n"
        "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 0 0] \"float scale\" 1\n"
        "Translate 3 1 5 Shape \"sphere\" \"float radius\" .9 AttributeEnd\n"
        "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [0 1 0]\n"
        "Translate -3 -1 5 Shape \"sphere\" \"float radius\" .9 AttributeEnd\n";
    render("Camera \"perspective\" \"float fov\" 45", world);
    /* 45 degrees high: 8 pixels are 2 * 5 * tan(22.5 degrees) = 4.142 at that distance. */
    shows(13, 2, 1, 0, 0, 1e-6);
    shows(2, 5, 0, 1, 0, 1e-6);
    shows(2, 2, 0, 0, 0, 1e-6);
    /* From behind. */
    render("LookAt 0 0 10 0 0 5 0 1 0 Camera \"perspective\" \"float fov\" 45", world);
    shows(2, 2, 1, 0, 0, 1e-6);
    shows(13, 5, 0, 1, 0, 1e-6);
    /* As programs with right-handed coordinates write it: they see -x on the right from +z. */
    render("Scale -1 1 1 Camera \"perspective\" \"float fov\" 45", world);
    shows(2, 2, 1, 0, 0, 1e-6);
    shows(13, 5, 0, 1, 0, 1e-6);
    render("Camera \"orthographic\" \"float screenwindow\" [-4 4 -2 2]", world);
    shows(13, 2, 1, 0, 0, 1e-6);
    shows(2, 5, 0, 1, 0, 1e-6);
}

/* pbrt's longitude begins at +x and goes by +z, which is a quarter from the left. */
static void the_panorama_lies_as_in_pbrt(void **state) {
    (void)state;
    render("Camera \"spherical\" \"string mapping\" \"equirectangular\"",
           "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n"
           "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 0 0]\n"
           "Translate 0 0 5 Shape \"sphere\" \"float radius\" 3 AttributeEnd\n"
           "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [0 1 0]\n"
           "Translate -5 0 0 Shape \"sphere\" \"float radius\" 3 AttributeEnd\n"
           "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [0 0 1]\n"
           "Translate 0 5 0 Shape \"sphere\" \"float radius\" 4 AttributeEnd\n");
    shows(4, 4, 1, 0, 0, 1e-6);
    shows(8, 4, 0, 1, 0, 1e-6);
    shows(12, 4, 0, 0, 0, 1e-6);
    shows(1, 0, 0, 0, 1, 1e-6);
}

/* A picture of the surroundings, 2 x 2: pbrt's square of equal areas. Its quadrants are those of x and
 * y, the first pixel that of -x and -y; the poles are z. */
static void the_surroundings_lie_as_in_pbrt(void **state) {
    (void)state;
    static const float rows[4][3] = {{0, 0, 1},
                                     {1, 1, 0}, /* the bottom row: y > 0 */
                                     {1, 0, 0},
                                     {0, 1, 0}};
    char sky[340], world[1000];
    snprintf(sky, sizeof sky, "%s.pfm", path);
    FILE *file = fopen(sky, "wb");
    assert_non_null(file);
    fprintf(file, "PF\n2 2\n-1.0\n");
    fwrite(rows, sizeof rows, 1, file);
    assert_int_equal(fclose(file), 0);
    snprintf(world, sizeof world, "LightSource \"infinite\" \"string filename\" \"%s\"", sky);
    /* Far from the edges, where four pixels meet: the middle of a quadrant at the equator. */
    static const struct {
        const char *view;
        double seen[3];
    } views[] = {{"LookAt 0 0 0 -1 -1 0 0 0 1", {1, 0, 0}},
                 {"LookAt 0 0 0 1 -1 0 0 0 1", {0, 1, 0}},
                 {"LookAt 0 0 0 -1 1 0 0 0 1", {0, 0, 1}},
                 {"LookAt 0 0 0 1 1 0 0 0 1", {1, 1, 0}}};
    char before[200];
    for (int i = 0; i < 4; i++) {
        snprintf(before, sizeof before, "%s Camera \"perspective\" \"float fov\" 1", views[i].view);
        render(before, world);
        const double *c = views[i].seen;
        rgb got = pixel_at(&bench, 8, 4);
        for (int k = 0; k < 3; k++) {
            if (fabs(got.c[k] - c[k]) > 0.3) print_error("%d: %g\n", i, got.c[k]);
            assert_true(fabs(got.c[k] - c[k]) <= 0.3);
        }
    }
    unlink(sky);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plane_has_the_light_that_it_should),
        cmocka_unit_test(left_is_left),
        cmocka_unit_test(the_panorama_lies_as_in_pbrt),
        cmocka_unit_test(the_surroundings_lie_as_in_pbrt),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
