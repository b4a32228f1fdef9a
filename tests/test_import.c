/* snell-import as it is built, on real files: whole, cut, broken on purpose, reaching outside. The
 * models are found through SNELL_MODELS. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/thread.h"
#include "importers/importer.h"

static char folder[] = "/tmp/snell-test-import-XXXXXX";
static const char *models;

static int set_up(void **state) {
    (void)state;
    models = getenv("SNELL_MODELS");
    if (models == NULL) models = TEST_SOURCE_DIR "/../shared/models";
    return mkdtemp(folder) ? 0 : -1;
}

static int tear_down(void **state) {
    (void)state;
    char command[300];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static snell_status import(const char *path, size_t *instances, double *seconds) {
    description *d;
    assert_int_equal(description_create(&d), SNELL_OK);
    helper_options options = {.time_max = 20};
    double begin = time_seconds();
    snell_status status = helper_import(path, &options, d);
    if (seconds) *seconds = time_seconds() - begin;
    if (instances) *instances = d->instance_count;
    description_destroy(d);
    return status;
}

/* models/NAME, or a skipped test. */
static void model_path(const char *name, char out[512]) {
    snprintf(out, 512, "%s/%s", models, name);
    if (access(out, R_OK) == 0) return;
    print_message("NOT TESTED: no %s (set SNELL_MODELS)\n", out);
    skip();
}

static void write_file(const char *name, const void *data, size_t size, char path[512]) {
    snprintf(path, 512, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static const char box[] = "gltf-khronos-samples/Box/glTF-Binary/Box.glb";

static void starting_costs_little(void **state) {
    (void)state;
    char path[512];
    model_path(box, path);
    double best = 1e9;
    for (int i = 0; i < 20; i++) {
        size_t instances = 0;
        double seconds = 0;
        assert_int_equal(import(path, &instances, &seconds), SNELL_OK);
        assert_int_equal(instances, 1);
        if (seconds < best) best = seconds;
    }
    print_message("importing a box takes %.2f ms\n", best * 1e3);
    assert_true(best < 1);
}

static void cut_files_are_errors(void **state) {
    (void)state;
    static char data[1 << 16];
    char path[512];
    model_path(box, path);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t size = fread(data, 1, sizeof data, file);
    fclose(file);
    for (size_t cut = 1; cut < size; cut += 1 + size / 40) {
        write_file("cut.glb", data, cut, path);
        assert_in_set(
            import(path, NULL, NULL),
            ((const LargestIntegralType[]){SNELL_ERR_SYNTAX, SNELL_ERR_UNSUPPORTED, SNELL_ERR_IO}),
            3);
        assert_string_equal(error_last()->file, path);
        assert_true(error_last()->text[0] != '\0');
    }
}

static void what_is_outside_is_not_read(void **state) {
    (void)state;
    static const char *const uris[] = {"../../../../../../../../etc/passwd", "/etc/passwd",
                                       "file:///etc/passwd", "%2e%2e/%2e%2e/etc/passwd"};
    for (size_t i = 0; i < sizeof uris / sizeof uris[0]; i++) {
        char text[1024], path[512];
        int size = snprintf(
            text, sizeof text,
            "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"%s\",\"byteLength\":36}],"
            "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
            "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],"
            "\"max\":[1,1,1]}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
            "\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0}",
            uris[i]);
        write_file("outside.gltf", text, (size_t)size, path);
        snell_status status = import(path, NULL, NULL);
        print_message("%s: %s\n", uris[i], error_last()->text);
        assert_true(status != SNELL_OK);
        if (i < 2) {
            assert_int_equal(status, SNELL_ERR_IO);
            assert_non_null(strstr(error_last()->text, "Permission denied"));
            assert_non_null(strstr(error_last()->hint, "--allow DIR"));
        }
    }
}

static int visited, crashed;

static int visit(const char *path, const struct stat *status, int kind) {
    if (kind != FTW_F || status->st_size == 0) return 0;
    double seconds;
    snell_status result = import(path, NULL, &seconds);
    visited++;
    if (result && strstr(error_last()->text, "crash")) {
        crashed++;
        print_message("held: %s: %s\n", strrchr(path, '/') + 1, error_last()->text);
    }
    if (result == SNELL_ERR_INTERNAL || seconds > 30) {
        print_error("%s: %s, %.1f s\n", path, error_last()->text, seconds);
        return 1;
    }
    return 0;
}

static void bad_files_do_no_harm(void **state) {
    (void)state;
    char path[512];
    model_path("assimp-bad", path);
    assert_int_equal(ftw(path, visit, 16), 0);
    print_message("%d files, %d made the helper crash\n", visited, crashed);
    assert_true(visited > 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(starting_costs_little),
        cmocka_unit_test(cut_files_are_errors),
        cmocka_unit_test(what_is_outside_is_not_read),
        cmocka_unit_test(bad_files_do_no_harm),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
