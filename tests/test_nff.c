/* The NFF reader: what each entity becomes, polygons that are not convex, what is wrong and where; the
 * Standard Procedural Databases, where SNELL_MODELS has them; and files that were damaged. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "cpu_time.h"
#include "described.h"
#include "geometry/mesh.h"
#include "image/srgb.h"
#include "importers/importer.h"
#include "importers/triangulate.h"
#include "maths/functions.h"

static const import_options plain = {.memory_max = (uint64_t)256 << 20};
static int file; /* in memory */

static snell_status read_bytes(const char *text, size_t size, description **out) {
    char path[64];
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    assert_int_equal(ftruncate(file, 0), 0);
    assert_true(pwrite(file, text, size, 0) == (ssize_t)size);
    assert_int_equal(description_create(out), SNELL_OK);
    error_clear();
    return import_file(path, "nff", &plain, *out);
}

static description *read_good(const char *text) {
    description *d;
    snell_status status = read_bytes(text, strlen(text), &d);
    if (status) print_error("%u: %s\n", error_last()->line, error_last()->text);
    assert_int_equal(status, SNELL_OK);
    return d;
}

static void near(double a, double b) {
    if (!(fabs(a - b) <= 1e-5 * (1 + fabs(b)))) print_error("%.9g is not %.9g\n", a, b);
    assert_true(fabs(a - b) <= 1e-5 * (1 + fabs(b)));
}

static void number_is(const object *o, const char *name, double value) {
    near((double)*(const float *)field_of(o, name), value);
}

static void vector_is(const object *o, const char *name, double x, double y, double z) {
    const vec3 *v = field_of(o, name);
    near((double)v->x, x);
    near((double)v->y, y);
    near((double)v->z, z);
}

static void every_entity_becomes_what_it_is(void **state) {
    (void)state;
    description *d = read_good("# a comment\n"
                               "b 0.1 0.5 1\n"
                               "v\nfrom 1 2 3\nat 4 5 6\nup 0 0 1\nangle 60\nhither 1\n"
                               "resolution 320 240\n"
                               "l 2 0 0 # a light\n"
                               "l -4 0 0 0.5 1 2\n"
                               "s 9 9 9 1\n" /* no material yet */
                               "f 1 0.5 0.25 0.5 0 10 0 1\n"
                               "s -9 -9 -9 -2\n"
                               "f 1 1 1 0.5 0.4 20 0 0\n"
                               "c 0 0 0 1\n 0 1 0 1\n"
                               "c 0 0 0 1 0 1 0 0.5\n"
                               "f 1 1 1 0.1 0.1 100 0.9 1.5\n"
                               "p 3\n0 0 0\n1 0 0\n0 1 0\n"
                               "p 4 0 0 0 1 0 0 1 1 0 0 1 0\n"
                               "pp 3\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1");
    assert_string_equal(d->format, "nff");
    const object *background = description_setting(d, "background");
    assert_non_null(background);
    vector_is(background, "color", srgb_decode(0.1), srgb_decode(0.5), 1);
    const object *render = description_setting(d, "render");
    assert_int_equal(*(const int32_t *)field_of(render, "width"), 320);
    assert_int_equal(*(const int32_t *)field_of(render, "height"), 240);
    const object *camera = object_at(d, CATEGORY_CAMERA, 0, "perspective");
    vector_is(camera, "from", 1, 2, 3);
    vector_is(camera, "at", 4, 5, 6);
    vector_is(camera, "up", 0, 0, 1);
    number_is(camera, "fov", PI / 3);
    /* The middle of (-9, -9, -9) and (9, 9, 9) is 2 and 4 metres from the lights. */
    vector_is(object_at(d, CATEGORY_LIGHT, 0, "point"), "intensity", 4 * PI / sqrt(2),
              4 * PI / sqrt(2), 4 * PI / sqrt(2));
    vector_is(object_at(d, CATEGORY_LIGHT, 1, "point"), "intensity", 8 * PI / sqrt(2),
              16 * PI / sqrt(2), 32 * PI / sqrt(2));
    object_at(d, CATEGORY_MATERIAL, 0, "lambert");
    object_at(d, CATEGORY_MATERIAL, 1, "phong");
    object_at(d, CATEGORY_MATERIAL, 2, "glazed");
    number_is(object_at(d, CATEGORY_MATERIAL, 3, "dielectric"), "ior", 1.5);
    number_is(object_at(d, CATEGORY_SHAPE, 0, "sphere"), "radius", 1);
    number_is(object_at(d, CATEGORY_SHAPE, 1, "sphere"), "radius", 2);
    assert_false(*(const bool *)field_of(object_at(d, CATEGORY_SHAPE, 2, "cylinder"), "capped"));
    number_is(object_at(d, CATEGORY_SHAPE, 3, "cone"), "radius_to", 0.5);
    const mesh_desc *flat = object_at(d, CATEGORY_SHAPE, 4, "mesh")->desc;
    assert_int_equal(flat->indices_count, 9);
    assert_int_equal(flat->normals_count, 0);
    const mesh_desc *smooth = object_at(d, CATEGORY_SHAPE, 5, "mesh")->desc;
    assert_int_equal(smooth->normals_count, 3);
    assert_int_equal(d->instance_count, 6);
    const uint32_t materials[] = {NO_MATERIAL, 0, 2, 2, 3, 3};
    for (size_t i = 0; i < 6; i++) assert_int_equal(d->instances[i].material, materials[i]);
    assert_int_equal(d->instances[1].line, 14);
    description_destroy(d);
}

/* Twice the area, along z. */
static double area_of(const vec3 *p, const uint32_t *indices, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; i += 3) {
        dvec3 a = dvec3_from(p[indices[i]]), b = dvec3_from(p[indices[i + 1]]),
              c = dvec3_from(p[indices[i + 2]]);
        double area = dvec3_cross(dvec3_sub(b, a), dvec3_sub(c, a)).z;
        assert_true(area >= 0); /* none is turned over */
        sum += area;
    }
    return sum;
}

static void polygons_are_cut_without_overlap(void **state) {
    (void)state;
    /* A comb, a spiral, and a star of many corners. */
    const vec3 comb[] = {{0, 0, 1}, {7, 0, 1}, {7, 5, 1}, {6, 5, 1}, {6, 1, 1}, {4, 1, 1},
                         {4, 5, 1}, {3, 5, 1}, {3, 1, 1}, {1, 1, 1}, {1, 5, 1}, {0, 5, 1}};
    uint32_t indices[3 * 1000];
    size_t count = triangulate(comb, 12, indices);
    assert_int_equal(count, 30);
    near(area_of(comb, indices, count), 2 * (7 + 3 * 4));
    vec3 star[1000];
    double area = 0;
    for (int i = 0; i < 1000; i++) {
        double r = i % 2 ? 1 : 3 + fn_sin(i * 0.7), angle = 2 * PI * i / 1000;
        star[i] = (vec3){(float)(r * fn_cos(angle)), (float)(r * fn_sin(angle)), 2};
    }
    for (int i = 0; i < 1000; i++) {
        dvec3 a = dvec3_from(star[i]), b = dvec3_from(star[(i + 1) % 1000]);
        area += a.x * b.y - a.y * b.x;
    }
    count = triangulate(star, 1000, indices);
    assert_int_equal(count, 3 * 998);
    near(area_of(star, indices, count), area);
}

/* The square of so many corners would take a minute; those of what is no polygon are cut somehow. */
static void very_many_corners_end(void **state) {
    (void)state;
    enum { MANY = 100000 };
    static vec3 star[MANY], places[MANY];
    static uint32_t indices[3 * MANY];
    double area = 0, begin = cpu_seconds();
    for (int i = 0; i < MANY; i++) {
        double r = i % 2 ? 1 : 3 + fn_sin(i * 0.7), angle = 2 * PI * i / MANY;
        star[i] = (vec3){(float)(r * fn_cos(angle)), (float)(r * fn_sin(angle)), 2};
        places[i] = (vec3){(float)(i % 3), (float)(i / 3 % 2), 0};
    }
    for (int i = 0; i < MANY; i++) {
        dvec3 a = dvec3_from(star[i]), b = dvec3_from(star[(i + 1) % MANY]);
        area += a.x * b.y - a.y * b.x;
    }
    assert_int_equal(triangulate(star, MANY, indices), 3 * (MANY - 2));
    near(area_of(star, indices, 3 * (MANY - 2)), area);
    assert_int_equal(triangulate(places, MANY, indices), 3 * (MANY - 2));
    assert_true(cpu_seconds() - begin < 60); /* about 2 s; the sanitizers take their time */
}

static void holes_stay_open(void **state) {
    (void)state;
    /* A square with a square hole, joined by an edge there and back. */
    const vec3 frame[] = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                          {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
    uint32_t indices[24];
    size_t count = triangulate(frame, 10, indices);
    assert_int_equal(count, 24);
    near(area_of(frame, indices, count), 2 * (16 - 4));
    /* All corners of a pentagram turn left, and yet it is not convex: nothing may be lost. */
    vec3 pentagram[5];
    for (int i = 0; i < 5; i++) {
        double angle = 4 * PI * i / 5;
        pentagram[i] = (vec3){(float)fn_cos(angle), (float)fn_sin(angle), 0};
    }
    assert_int_equal(triangulate(pentagram, 5, indices), 9);
}

static void what_is_wrong_is_said_with_its_line(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
        uint32_t line, column; /* column 0: not asked */
    } cases[] = {
        {"s 0 0 0 1\nq 1 2\n", "unknown entity 'q'", 2, 1},
        {"v\nfrom 0 0 1\n# zz\n  zz 3\n", "unknown entity 'zz'", 4, 3},
        {"s 0 0\n\nx 1\n", "'s' needs a number here, not 'x'", 3, 1},
        {"s 0 0 nan 1\n", "'s' needs a number here, not 'nan'", 1, 7},
        {"s 0 0", "the file ends in the middle of 's'", 1, 6},
        {"s 0 0 0x1 1\n", "needs a number", 1, 0},
        {"s 0 0 1e999 1\n", "needs a number", 1, 0},
        {"p 2\n0 0 0\n1 0 0\n", "'p' has 2 corners", 1, 0},
        {"p 3.5\n", "'p' has 3.5 corners", 1, 0},
        {"p 4000000000\n", "corners", 1, 0},
        {"p 3\n0 0 0\n1 0 0\n", "the file ends in the middle of 'p'", 4, 0},
        {"f 1 1 -1 0 0 0 0 0\n", "below 0", 1, 0},
        {"b 0 0 0\nb 1 1 1\n", "a second background", 2, 0},
        {"v\nfrom 0 0 1\nat 0 0 0\nv\n", "a second view", 4, 0},
        {"s 0 0 0 0\n", "radius", 1, 0},
        {"c 0 0 0 1 0 0 0 1\n", "the same point", 1, 0},
        {"v\nfrom 0 0 0\nat 0 0 0\n", "perspective", 1, 0},
        {"v\nangle 400\n", "fov", 1, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        description *d;
        snell_status status = read_bytes(cases[i].text, strlen(cases[i].text), &d);
        if (!status || !strstr(error_last()->text, cases[i].says) ||
            error_last()->line != cases[i].line)
            print_error("%s: said '%s' at %u\n", cases[i].text, status ? error_last()->text : "",
                        status ? error_last()->line : 0);
        assert_int_not_equal(status, SNELL_OK);
        assert_non_null(strstr(error_last()->text, cases[i].says));
        assert_int_equal(error_last()->line, cases[i].line);
        if (cases[i].column) assert_int_equal(error_last()->column, cases[i].column);
        description_destroy(d);
    }
}

/* A file is read as it began; other formats that have the extension begin otherwise. */
static void the_first_line_says_whose_it_is(void **state) {
    (void)state;
    extern const importer importer_nff;
    static const struct {
        const char *text;
        bool ours;
    } cases[] = {
        {"s 0 0 0 1\nzz 3\n", true},    {"# comment\n\nv\nfrom 0 0 1\nwhat is this\n", true},
        {"b 0.1 0.2 0.3", true},        {"tess 4\nzz\n", true},
        {"nff\nversion 2.00\n", false}, /* Sense8's */
        {"nff\nv 1 2 3\n", false},      {"s is for something else\n", false},
        {"zz 3\ns 0 0 0 1\n", false},   {"", false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const uint8_t *text = (const uint8_t *)cases[i].text;
        assert_int_equal(importer_nff.recognise(".nff", text, strlen(cases[i].text)),
                         cases[i].ours);
        assert_false(importer_nff.recognise(".obj", text, strlen(cases[i].text)));
    }
    /* libassimp's dialect; its colour looked like a triangle of OBJ. */
    extern const importer importer_obj;
    static const char hex[] = "f 1 0 0\nhex 0 0 0 5 10 20\n";
    assert_false(importer_nff.recognise(".nff", (const uint8_t *)hex, sizeof hex - 1));
    assert_false(importer_obj.recognise(".nff", (const uint8_t *)hex, sizeof hex - 1));
}

/* Spheres stay spheres: these are the numbers of the files' own lines. */
static void standard_databases_are_read(void **state) {
    (void)state;
    static const struct {
        const char *name;
        size_t spheres, cones, polygons, lights;
    } files[] = {{"balls_s3", 820, 0, 1, 3}, {"tree_s7", 255, 255, 1, 7}};
    const char *models = getenv("SNELL_MODELS");
    if (models == NULL) skip();
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        char name[4096];
        snprintf(name, sizeof name, "%s/spd-nff/%s.nff", models, files[i].name);
        if (access(name, R_OK) != 0) skip();
        description *d;
        assert_int_equal(description_create(&d), SNELL_OK);
        assert_int_equal(import_file(name, NULL, &plain, d), SNELL_OK);
        size_t spheres = 0, cones = 0, meshes = 0;
        for (size_t k = 0; k < d->objects[CATEGORY_SHAPE].count; k++) {
            const char *type = d->objects[CATEGORY_SHAPE].items[k].type->name;
            spheres += strcmp(type, "sphere") == 0;
            cones += strcmp(type, "cone") == 0 || strcmp(type, "cylinder") == 0;
            meshes += strcmp(type, "mesh") == 0;
        }
        if (spheres != files[i].spheres || cones != files[i].cones)
            print_error("%s: %zu spheres, %zu cones\n", files[i].name, spheres, cones);
        assert_int_equal(spheres, files[i].spheres);
        assert_int_equal(cones, files[i].cones);
        assert_int_equal(meshes, files[i].polygons);
        assert_int_equal(d->objects[CATEGORY_LIGHT].count, files[i].lights);
        description_destroy(d);
    }
}

/* Bytes changed, cut and doubled at random: an error or a scene. */
static void damaged_files_do_no_harm(void **state) {
    (void)state;
    static const char seed[] = "b .1 .2 .3\nv\nfrom 1 2 3\nat 0 0 0\nup 0 1 0\nangle 45\n"
                               "resolution 64 64\nl 4 3 2\nf 1 .5 .2 .8 .1 3 0 1\np 5\n0 0 0\n"
                               "4 0 0\n4 4 0\n2 1 0\n0 4 0\ns 0 0 0 .5\nc 0 0 0 1 1 1 1 .5\n"
                               "pp 3 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1\n";
    static const char bytes[] = "0123456789.-+eE \n#bvlfscp\0\xff";
    uint64_t random = 7;
    int good = 0;
    for (int i = 0; i < 10000; i++) {
        char text[sizeof seed];
        memcpy(text, seed, sizeof seed);
        size_t size = sizeof seed - 1;
        for (int k = 0; k < 1 + i % 8; k++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            text[(random >> 33) % size] = bytes[(random >> 20) % (sizeof bytes - 1)];
        }
        if (i % 5 == 0) size = (size_t)(random >> 40) % size;
        description *d;
        good += read_bytes(text, size, &d) == SNELL_OK;
        description_destroy(d);
    }
    assert_in_range(good, 500, 9500);
}

int main(void) {
    file = memfd_create("nff", 0);
    if (file < 0) return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_entity_becomes_what_it_is),
        cmocka_unit_test(polygons_are_cut_without_overlap),
        cmocka_unit_test(very_many_corners_end),
        cmocka_unit_test(holes_stay_open),
        cmocka_unit_test(what_is_wrong_is_said_with_its_line),
        cmocka_unit_test(the_first_line_says_whose_it_is),
        cmocka_unit_test(standard_databases_are_read),
        cmocka_unit_test(damaged_files_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
