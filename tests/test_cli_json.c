/* --json of the built command: one object that parses, with the keys that scripts rely on. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

static char folder[] = "/tmp/snell-test-XXXXXX";
static const char snell[] = TEST_BINARY_DIR "/snell";

/* Runs snell in the folder; the object on its standard output and the exit code. */
static json_t *run(const char *arguments, int *code) {
    char command[1024];
    snprintf(command, sizeof command, "cd %s && '%s' %s 2>messages </dev/null", folder, snell,
             arguments);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    json_error_t error;
    /* Nothing may follow the object. */
    json_t *root = json_loadf(pipe, JSON_REJECT_DUPLICATES, &error);
    if (root == NULL) print_error("snell %s: line %d: %s\n", arguments, error.line, error.text);
    int status = pclose(pipe);
    assert_non_null(root);
    assert_true(WIFEXITED(status));
    *code = WEXITSTATUS(status);
    return root;
}

static json_t *get(json_t *object, const char *key, json_type type) {
    json_t *value = json_object_get(object, key);
    if (value == NULL || json_typeof(value) != type) print_error("key %s\n", key);
    assert_non_null(value);
    assert_int_equal(json_typeof(value), type);
    return value;
}

static const char *text(json_t *object, const char *key) {
    return json_string_value(get(object, key, JSON_STRING));
}

static json_int_t whole(json_t *object, const char *key) {
    return json_integer_value(get(object, key, JSON_INTEGER));
}

static void write_file(const char *name, const char *content) {
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(content, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static int make_folder(void **state) {
    (void)state;
    if (mkdtemp(folder) == NULL) return -1;
    /* SNELL_MODELS and the like would be warned of. */
    unsetenv("SNELL_MODELS");
    unsetenv("SNELL_THREADS");
    unsetenv("SNELL_ISA");
    return 0;
}

static int remove_folder(void **state) {
    (void)state;
    char command[64];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command);
}

static void test_render(void **state) {
    (void)state;
    int code;
    write_file("ball.lua", "sphere { radius = 1 }\n");
    json_t *root = run("ball.lua -s 40x30 -n 2 -t 2 --seed 9 --json", &code);
    assert_int_equal(code, 0);
    assert_int_equal(whole(root, "schema"), 1);
    assert_string_equal(text(root, "file"), "ball.lua");
    assert_string_equal(text(root, "output"), "ball.png");
    assert_int_equal(whole(root, "width"), 40);
    assert_int_equal(whole(root, "height"), 30);
    assert_string_equal(text(root, "integrator"), "whitted");
    assert_int_equal(whole(root, "samples"), 2);
    assert_int_equal(whole(root, "max_depth"), 10);
    assert_int_equal(whole(root, "seed"), 9);
    assert_int_equal(whole(root, "threads"), 2);
    assert_true(whole(root, "memory_peak") > 100000);
    assert_int_equal(strlen(text(root, "image_hash")), 16);
    assert_int_equal(strspn(text(root, "image_hash"), "0123456789abcdef"), 16);
    assert_true(strlen(text(root, "isa")) > 3);
    assert_true(strlen(text(root, "added")) > 0);
    get(root, "dropped_weight", JSON_REAL);
    get(root, "counters", JSON_OBJECT);
    assert_int_equal(json_array_size(get(root, "warnings", JSON_ARRAY)), 0);

    static const char *const times[] = {"load", "build", "render", "write", "total"};
    json_t *seconds = get(root, "seconds", JSON_OBJECT);
    double sum = 0, total = json_real_value(get(seconds, "total", JSON_REAL));
    for (size_t i = 0; i < 4; i++) sum += json_real_value(get(seconds, times[i], JSON_REAL));
    assert_true(sum > 0 && sum <= total * 1.001);

    static const char *const kinds[] = {"camera", "reflected", "refracted", "shadow", "continued"};
    json_t *rays = get(root, "rays", JSON_OBJECT);
    json_int_t count = 0;
    for (size_t i = 0; i < 5; i++) count += whole(rays, kinds[i]);
    assert_int_equal(whole(rays, "camera"), 40 * 30 * 2);
    assert_int_equal(whole(rays, "total"), count);
    get(rays, "per_second", JSON_REAL);
    json_decref(root);
}

static double real_at(json_t *array, size_t index) {
    json_t *value = json_array_get(array, index);
    assert_true(json_is_real(value));
    return json_real_value(value);
}

/* With all their digits: the contributions add up to the float of the picture. */
static void test_explain(void **state) {
    (void)state;
    int code;
    write_file("ball.lua",
               "sphere { radius = 1, name = 'ball', material = material.dielectric {} }\n");
    json_t *root = run("explain ball.lua 20 15 -s 40x30 -n 2 --json", &code);
    assert_int_equal(code, 0);
    assert_int_equal(whole(root, "schema"), 1);
    assert_int_equal(whole(root, "x"), 20);
    assert_int_equal(whole(root, "samples"), 2);
    assert_true(strlen(text(root, "added")) > 0);
    json_t *rays = get(root, "rays", JSON_ARRAY), *pixel = get(root, "pixel", JSON_ARRAY);
    json_t *samples = get(root, "sample_list", JSON_ARRAY);
    assert_int_equal(json_array_size(samples), 2);
    double sum[3] = {0, 0, 0};
    for (size_t i = 0; i < json_array_size(rays); i++) {
        json_t *ray = json_array_get(rays, i), *lights = get(ray, "lights", JSON_ARRAY);
        json_t *parent = json_object_get(ray, "parent");
        assert_int_equal(whole(ray, "index"), i);
        assert_true(json_is_null(parent) || json_integer_value(parent) < (json_int_t)i);
        assert_int_equal(json_is_null(parent), strcmp(text(ray, "kind"), "camera") == 0);
        for (size_t k = 0; k < json_array_size(lights); k++)
            for (size_t c = 0; c < 3; c++)
                sum[c] += real_at(get(json_array_get(lights, k), "contribution", JSON_ARRAY), c);
    }
    for (size_t c = 0; c < 3; c++) {
        double got = real_at(pixel, c), mean = sum[c] / 2;
        assert_true((double)(float)got == got); /* a float, whole */
        assert_true(mean > 0 && (float)mean == (float)got);
    }
    json_t *hit = get(json_array_get(rays, 0), "hit", JSON_OBJECT);
    assert_string_equal(text(get(hit, "shape", JSON_OBJECT), "name"), "ball");
    assert_true(json_real_value(get(hit, "ior_to", JSON_REAL)) == 1.5);
    json_decref(root);
}

static void check_error(const char *arguments, int want, const char *status) {
    int code;
    json_t *root = run(arguments, &code), *error = get(root, "error", JSON_OBJECT);
    assert_int_equal(code, want);
    assert_int_equal(whole(root, "schema"), 1);
    assert_string_equal(text(error, "status"), status);
    assert_true(strlen(text(error, "message")) > 0);
    text(error, "hint");
    text(error, "file");
    whole(error, "line");
    whole(error, "column");
    assert_int_equal(whole(error, "exit"), want);
    json_decref(root);
}

static void test_errors(void **state) {
    (void)state;
    write_file("bad.lua", "-- a mistake\nsphere { radus = 1 }\n");
    check_error("bad.lua --json --sise 3", 2, "usage");
    check_error("--json", 2, "usage");
    check_error("--json rendr", 2, "usage");
    check_error("explain bad.lua 1 --json", 2, "usage");
    check_error("explain bad.lua 1 1 --json", 3, "syntax");
    check_error("help --json dielectrc", 2, "usage");
    check_error("info --json", 2, "usage");
    check_error("nothing.lua --json", 5, "io");
    check_error("info nothing.png --json", 5, "io");
    int code;
    json_t *root = run("bad.lua --json", &code), *error = get(root, "error", JSON_OBJECT);
    assert_int_equal(code, 3);
    assert_string_equal(text(error, "file"), "bad.lua");
    assert_int_equal(whole(error, "line"), 2);
    assert_non_null(strstr(text(error, "message"), "radus"));
    assert_non_null(strstr(text(error, "hint"), "radius"));
    json_decref(root);
}

static void test_several(void **state) {
    (void)state;
    int code;
    json_t *root = run("ball.lua bad.lua -s 8x6 -n 1 --json", &code);
    assert_int_equal(code, 1);
    assert_int_equal(whole(root, "failed"), 1);
    json_t *files = get(root, "files", JSON_ARRAY);
    assert_int_equal(json_array_size(files), 2);
    assert_null(json_object_get(json_array_get(files, 0), "error"));
    assert_non_null(json_object_get(json_array_get(files, 1), "error"));
    json_decref(root);
}

static void test_info(void **state) {
    (void)state;
    int code;
    json_t *root = run("info ball.lua --json", &code);
    assert_int_equal(code, 0);
    assert_string_equal(text(root, "kind"), "scene");
    assert_int_equal(whole(get(root, "counts", JSON_OBJECT), "instances"), 1);
    assert_int_equal(json_array_size(get(root, "cameras", JSON_ARRAY)), 0);
    assert_int_equal(json_array_size(get(get(root, "bounds", JSON_OBJECT), "min", JSON_ARRAY)), 3);
    json_decref(root);
    root = run("info ball.png --json", &code);
    assert_int_equal(code, 0);
    assert_string_equal(text(root, "kind"), "picture");
    assert_string_equal(text(root, "format"), "png");
    json_t *made = get(root, "made", JSON_OBJECT);
    assert_string_equal(text(made, "file"), "ball.lua");
    get(made, "options", JSON_ARRAY);
    json_decref(root);
    json_decref(run("--version --json", &code));
    assert_int_equal(code, 0);
    json_decref(run("example --json", &code));
    assert_int_equal(code, 0);
}

static double number(json_t *object, const char *key) {
    return json_real_value(get(object, key, JSON_REAL));
}

static void test_compare(void **state) {
    (void)state;
    int code;
    write_file("a.pgm", "P5 4 1 200\n\x64\x64\x64\x64");
    write_file("b.pgm", "P5 4 1 200\n\x64\x64\x5a\x64"); /* 90 of 200, not 100 */
    json_t *root = run("compare a.pgm b.pgm --json --max-rmse 0.001 --error e.pfm", &code);
    assert_int_equal(code, 1);
    assert_int_equal(whole(root, "schema"), 1);
    assert_string_equal(text(root, "reference"), "a.pgm");
    assert_string_equal(text(root, "file"), "b.pgm");
    assert_true(whole(root, "width") == 4 && whole(root, "height") == 1);
    assert_true(whole(root, "differing") == 1 && whole(root, "not_finite") == 0);
    double d = 13 / 255.0; /* 128 - 115 */
    assert_true(fabs(number(root, "difference_max") - d) < 1e-8);
    json_t *at = get(root, "difference_at", JSON_ARRAY);
    assert_int_equal(json_integer_value(json_array_get(at, 0)), 2);
    assert_int_equal(json_integer_value(json_array_get(at, 1)), 0);
    assert_true(fabs(number(root, "rmse") - d / 2) < 1e-8);
    assert_true(number(root, "rel_mse") > 0 && number(root, "flip") > 0);
    assert_true(fabs(number(root, "psnr") + 20 * log10(d / 2)) < 1e-5);
    get(root, "linear", JSON_FALSE);
    get(root, "passed", JSON_FALSE);
    json_t *over = get(root, "over", JSON_ARRAY);
    assert_int_equal(json_array_size(over), 1);
    assert_string_equal(json_string_value(json_array_get(over, 0)), "max-rmse");
    assert_string_equal(text(root, "error_map"), "e.pfm");
    assert_null(json_object_get(root, "z_test"));
    assert_int_equal(json_array_size(get(root, "warnings", JSON_ARRAY)), 0);
    json_decref(root);
    root = run("compare a.pgm a.pgm --json", &code);
    assert_int_equal(code, 0);
    get(root, "psnr", JSON_NULL); /* infinite */
    get(root, "passed", JSON_TRUE);
    json_decref(root);
    check_error("compare a.pgm none.pgm --json", 5, "io");
    check_error("compare a.pgm ball.png --json", 3, "argument");
    root = run("convert a.pgm c.png --json", &code);
    assert_int_equal(code, 0);
    assert_string_equal(text(root, "output"), "c.png");
    assert_int_equal(whole(root, "width"), 4);
    json_decref(root);
}

/* A median between the least and the most. */
static double median(json_t *object, const char *key) {
    json_t *of = get(object, key, JSON_OBJECT);
    double middle = number(of, "median");
    assert_true(0 <= number(of, "min") && number(of, "min") <= middle &&
                middle <= number(of, "max"));
    return middle;
}

/* What a benchmark tells agrees with itself, and with a render of the same picture. */
static void check_bench(json_t *root, json_t *render) {
    static const char *const tests[] = {"nodes", "boxes", "triangles", "primitives"};
    static const char *const phases[] = {"load", "build", "render", "write", "total"};
    static const char *const parts[] = {"camera", "trace", "shade", "shadows"};
    static const char *const kinds[] = {"camera",    "reflected", "refracted",
                                        "continued", "shadow",    "total"};
    json_t *rays = get(root, "rays", JSON_OBJECT), *nearest = get(root, "nearest", JSON_OBJECT),
           *shadow = get(root, "shadow", JSON_OBJECT), *memory = get(root, "memory", JSON_OBJECT),
           *drawn = get(render, "rays", JSON_OBJECT), *done = get(render, "counters", JSON_OBJECT);
    for (size_t i = 0; i < 6; i++) assert_int_equal(whole(rays, kinds[i]), whole(drawn, kinds[i]));
    double near_count = (double)whole(nearest, "rays"),
           shadow_count = (double)whole(shadow, "rays");
    assert_true(near_count + shadow_count == (double)whole(rays, "total"));
    for (size_t i = 0; i < 4; i++) {
        double sum =
            near_count * number(nearest, tests[i]) + shadow_count * number(shadow, tests[i]);
        assert_true(fabs(sum - (double)whole(done, tests[i])) <= 1e-6 * sum);
    }
    double wall = 0, cpu = 0;
    for (size_t i = 0; i < 5; i++) {
        wall = median(get(root, "seconds", JSON_OBJECT), phases[i]);
        cpu = median(get(root, "cpu_seconds", JSON_OBJECT), phases[i]);
        assert_true(wall > 0 && cpu > 0);
    }
    /* Most of the render is in one of its parts; medians do not add up exactly. */
    double sum = 0, all = median(get(root, "cpu_seconds", JSON_OBJECT), "render");
    for (size_t i = 0; i < 4; i++)
        sum += median(get(root, "render_cpu_seconds", JSON_OBJECT), parts[i]);
    assert_true(sum > 0.5 * all && sum < 1.2 * all);
    assert_true(median(root, "rays_per_second") > 0 && median(root, "rays_per_cpu_second") > 0);
    assert_true(whole(memory, "accel") > 0 && whole(memory, "rays") > 0);
    assert_int_equal(whole(memory, "film"), 96 * 72 * 3 * 4);
    assert_true(whole(memory, "peak") > 100000 && whole(memory, "peak_import") > 100000);
    get(root, "advice", JSON_ARRAY);
}

static void test_bench(void **state) {
    (void)state;
    static const char *const integrators[] = {"appel", "whitted", "cook", "path"};
    int code;
    write_file(
        "many.lua",
        "camera { from = {0, 1, 4}, at = {0, 0, 0} } light.point { position = {3, 3, 3}, "
        "intensity = 30 }\n"
        "plane { point = {0, -1, 0}, material = material.lambert { color = .5 } }\n"
        "for i = 0, 99 do sphere { center = {math.sin(i), math.cos(i) / 2, i / 50 - 1}, radius = "
        ".1, material = material[({'mirror', 'dielectric', 'lambert'})[i % 3 + 1]] {} } end\n"
        "mesh { positions = {{-1,-1,-1},{1,-1,-1},{0,1,-1}}, indices = {0,1,2} }\n"
        "mesh { positions = {{0,0,0},{0,0,0},{0,0,0}}, indices = {0,1,2} } -- a warning\n");
    for (size_t i = 0; i < 4; i++) {
        char arguments[256];
        snprintf(arguments, sizeof arguments,
                 "render many.lua -i %s -s 96x72 -n 8 -t 1 -o many.pfm --json", integrators[i]);
        json_t *render = run(arguments, &code);
        assert_int_equal(code, 0);
        snprintf(arguments, sizeof arguments,
                 "bench many.lua -i %s -s 96x72 -n 8 -t 1 --rounds 3 --json", integrators[i]);
        json_t *root = run(arguments, &code);
        assert_int_equal(code, 0);
        assert_int_equal(whole(root, "schema"), 1);
        assert_string_equal(text(root, "integrator"), integrators[i]);
        assert_int_equal(whole(root, "rounds"), 3);
        assert_int_equal(whole(root, "threads"), 1);
        assert_int_equal(json_array_size(get(root, "warnings", JSON_ARRAY)), 1); /* not 3 */
        check_bench(root, render);
        json_decref(render);
        json_decref(root);
    }
    json_t *root = run("bench --rounds 1 -t 2 --json", &code);
    assert_int_equal(code, 0);
    json_t *runs = get(root, "runs", JSON_ARRAY);
    assert_int_equal(json_array_size(runs), 2);
    assert_int_equal(whole(json_array_get(runs, 0), "threads"), 1);
    assert_int_equal(whole(json_array_get(runs, 1), "threads"), 2);
    assert_true(median(json_array_get(runs, 1), "rays_per_second") > 0);
    json_decref(root);
    check_error("bench none.lua --json", 5, "io");
    check_error("bench -s 4x4 --json", 2, "usage");
}

int main(void) {
    unsetenv("SNELL_FULL"); /* for tests; the command would warn of them */
    unsetenv("SNELL_MODELS");
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_render),  cmocka_unit_test(test_errors),
        cmocka_unit_test(test_several), cmocka_unit_test(test_info),
        cmocka_unit_test(test_compare), cmocka_unit_test(test_explain),
        cmocka_unit_test(test_bench),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
