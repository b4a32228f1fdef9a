/* Model files through the import helper, as users read them: libassimp, of which some formats are, does crash on
 * hostile files, and then the helper dies, not we. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "importers/files.h"
#include "mutants.h"

#define DATA TEST_SOURCE_DIR "/tests/data/models/"

static const helper_options options = {.import = {.memory_max = (uint64_t)1 << 30}, .time_max = 2};

static snell_status import_path(const char *path) {
    description *d;
    assert_int_equal(description_create(&d), SNELL_OK);
    error_clear();
    snell_status status = helper_import(path, &options, d);
    if (status) {
        assert_true(error_last()->text[0] != '\0');
        assert_int_equal(d->instance_count, 0);
    } else {
        assert_true(d->instance_count > 0);
    }
    description_destroy(d);
    return status;
}

static void write_file(const char *path, const uint8_t *data, size_t size) {
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
}

static void mutants_do_no_harm(void **state) {
    (void)state;
    static const char *const names[] = {"quad.obj", "triangle.ply", "triangle.stl", "binary.stl",
                                        "tetrahedron.off"};
    size_t total = getenv("SNELL_FULL") ? 5000 : 20;
    uint64_t seed = 88172645463325252u;
    for (int n = 0; n < (SNELL_HAS_ASSIMP ? 5 : 4); n++) {
        char path[600];
        snprintf(path, sizeof path, "%s/snell_test_mutant_%d%s",
                 access("/dev/shm", W_OK) == 0 ? "/dev/shm" : TEST_BINARY_DIR, (int)getpid(),
                 strchr(names[n], '.'));
        uint8_t *data;
        size_t size, loaded = 0;
        assert_int_equal(
            import_read_beside(DATA "quad.obj", names[n], &options.import, &data, &size), SNELL_OK);
        for (size_t i = 0; i < total; i++) {
            uint8_t saved[4];
            size_t at[4];
            for (int k = 0; k < 4; k++) {
                at[k] = random_next(&seed) % size;
                saved[k] = data[at[k]];
                data[at[k]] = (uint8_t)(random_next(&seed) % (i % 2 ? 256 : 64));
            }
            write_file(path, data, i % 5 ? size : random_next(&seed) % size);
            loaded += import_path(path) == SNELL_OK;
            for (int k = 3; k >= 0; k--) data[at[k]] = saved[k];
        }
        print_message("%s: %zu of %zu mutants still load\n", names[n], loaded, total);
        free(data);
        unlink(path);
    }
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifndef SANITIZED
#define SANITIZED 0
#endif

/* libassimp's own texts were shown. */
static void failures_are_explained(void **state) {
    (void)state;
    enum { FACES = 100000 };
    char path[600];
#if SNELL_HAS_ASSIMP
    snprintf(path, sizeof path, "%s/snell_test_broken_%d.off",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : TEST_BINARY_DIR, (int)getpid());
    write_file(path, (const uint8_t *)"OFF\n9 9 9\n", 10);
    assert_int_equal(import_path(path), SNELL_ERR_SYNTAX);
    assert_non_null(strstr(error_last()->text, "cannot read the OFF file: "));
    assert_true(error_last()->hint[0] != '\0');
    unlink(path);
#endif
    snprintf(path, sizeof path, "%s/snell_test_large_%d.obj",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : TEST_BINARY_DIR, (int)getpid());
    if (SANITIZED) {
        print_message("NOT TESTED: sanitizers need the address space\n");
        return;
    }
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    for (int i = 0; i < FACES; i++) fprintf(f, "v %d 0 0\nv %d 1 0\nv %d 0 1\n", i, i, i);
    for (int i = 0; i < FACES; i++) fprintf(f, "f %d %d %d\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    assert_int_equal(fclose(f), 0);
    helper_options little = options;
    little.import.memory_max = (uint64_t)16 << 20;
    description *d;
    assert_int_equal(description_create(&d), SNELL_OK);
    assert_int_equal(helper_import(path, &little, d), SNELL_ERR_MEMORY);
    assert_non_null(strstr(error_last()->hint, "16 MiB of memory: --memory allows more"));
    description_destroy(d);
    unlink(path);
}

/* Those with nothing to draw, and those that are wrong. */
static bool is_bad(const char *name) {
    static const char *const names[] = {"points.ply",       "point_cloud.obj",    "testline.obj",
                                        "line-prim.obj",    "circle.obj",         "issue-356",
                                        "test-nan.obj",     "invalid-relative",   "malformed.obj",
                                        "crash-30d6d0f7c5", "payload_JVN42386607"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (strstr(name, names[i])) return true;
    return false;
}

static size_t files, loaded_files;

static int visit(const char *path, const struct stat *st, int flag, struct FTW *ftw) {
    (void)st, (void)ftw;
    static const char *const extensions[] = {".obj", ".ply", ".stl"};
    const char *name = strrchr(path, '/'), *dot = strrchr(path, '.');
    bool wanted = name && (strstr(name, "payload") || strstr(name, "formatDetection"));
    for (int i = 0; i < 3 && dot; i++) wanted |= strcmp(dot, extensions[i]) == 0;
    if (flag != FTW_F || !wanted) return 0;
    files++;
    snell_status status = import_path(path);
    loaded_files += status == SNELL_OK;
    if (status) print_message("%s: %s\n", path, error_last()->text);
    assert_int_equal(status, is_bad(name) ? SNELL_ERR_SYNTAX : SNELL_OK);
    if (status) assert_true(error_last()->line > 0 || strstr(error_last()->text, "no surfaces"));
    return 0;
}

static void every_file_that_we_have_loads_or_says_why_not(void **state) {
    (void)state;
    const char *folder = getenv("SNELL_MODELS");
    if (folder == NULL) folder = TEST_SOURCE_DIR "/../shared/models";
    if (access(folder, R_OK) != 0) {
        print_message("SKIPPED: no model files (set SNELL_MODELS)\n");
        skip();
    }
    assert_int_equal(nftw(folder, visit, 16, FTW_PHYS), 0);
    print_message("OBJ, PLY and STL files: %zu, loaded %zu\n", files, loaded_files);
    assert_true(files > 50);
}

static void gltf_comes_through_the_helper(void **state) {
    (void)state;
    assert_int_equal(import_path(DATA "box_u16.glb"), SNELL_OK);
    assert_int_equal(import_path(DATA "box_u32.gltf"), SNELL_OK); /* a buffer beside it */
    assert_int_equal(import_path(DATA "alpha.gltf"), SNELL_OK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gltf_comes_through_the_helper),
        cmocka_unit_test(mutants_do_no_harm),
        cmocka_unit_test(failures_are_explained),
        cmocka_unit_test(every_file_that_we_have_loads_or_says_why_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
