/* Files that scenes refer to: where they are looked for, and what is not read. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "importers/files.h"

static char folder[] = "/tmp/snell-test-files-XXXXXX";

static void write_file(const char *name, const char *text) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static void make_link(const char *target, const char *name) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_int_equal(symlink(target, path), 0);
}

static void make_folder(const char *name) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_int_equal(mkdir(path, 0700), 0);
}

static int set_up(void **state) {
    (void)state;
    if (mkdtemp(folder) == NULL) return -1;
    make_folder("scene");
    make_folder("scene/textures");
    make_folder("scene-other");
    make_folder("assets");
    write_file("secret", "secret");
    write_file("scene/a.gltf", "a scene");
    write_file("scene/textures/wood.png", "wood");
    write_file("scene-other/near.png", "near");
    write_file("assets/stone.png", "stone");
    make_link("../secret", "scene/leak");
    make_link("textures/wood.png", "scene/link.png");
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    char command[600];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static snell_status read_name(const char *name, const import_options *options, char *out) {
    char base[512];
    snprintf(base, sizeof base, "%s/scene/a.gltf", folder);
    uint8_t *data = NULL;
    size_t size = 0;
    snell_status status = import_read_beside(base, name, options, &data, &size);
    if (status == SNELL_OK) {
        assert_int_equal(strlen((char *)data), size);
        snprintf(out, 32, "%s", (char *)data);
    }
    free(data);
    return status;
}

static void the_scenes_folder_and_below_are_read(void **state) {
    (void)state;
    import_options options = {0};
    char text[32];
    const char *names[] = {"textures/wood.png", "./textures/wood.png", "link.png",
                           "textures/../textures/wood.png", "../scene/textures/wood.png"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        assert_int_equal(read_name(names[i], &options, text), SNELL_OK);
        assert_string_equal(text, "wood");
    }
    char absolute[512];
    snprintf(absolute, sizeof absolute, "%s/scene/textures/wood.png", folder);
    assert_int_equal(read_name(absolute, &options, text), SNELL_OK);
}

static void nothing_outside_is_read(void **state) {
    (void)state;
    import_options options = {0};
    char text[32];
    const char *names[] = {"../secret",   "leak",
                           "/etc/passwd", "textures/../../secret",
                           "../nothing",  "../scene-other/near.png",
                           "/nothing",    "textures/../../../../../../etc/passwd"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        assert_int_equal(read_name(names[i], &options, text), SNELL_ERR_IO);
        assert_non_null(strstr(error_last()->text, "Permission denied"));
        assert_non_null(strstr(error_last()->hint, "--allow DIR"));
    }
}

static void asset_folders_are_read(void **state) {
    (void)state;
    char assets[512], text[32];
    snprintf(assets, sizeof assets, "%s/assets", folder);
    const char *dirs[] = {assets};
    import_options options = {.asset_dirs = dirs, .asset_dir_count = 1};
    assert_int_equal(read_name("stone.png", &options, text), SNELL_OK);
    assert_string_equal(text, "stone");
    assert_int_equal(read_name("../assets/stone.png", &options, text), SNELL_OK);
    assert_int_equal(read_name("../secret", &options, text), SNELL_ERR_IO);
}

static void what_is_no_file_gives_an_error(void **state) {
    (void)state;
    import_options options = {0};
    char text[32];
    assert_int_equal(read_name("missing.png", &options, text), SNELL_ERR_IO);
    assert_string_equal(error_last()->text, "cannot open 'missing.png': No such file or directory");
    assert_int_equal(read_name("textures", &options, text), SNELL_ERR_IO);
    assert_int_equal(read_name("", &options, text), SNELL_ERR_IO);
    options.memory_max = 6;
    assert_int_equal(read_name("textures/wood.png", &options, text), SNELL_ERR_MEMORY);
    options.memory_max = 8;
    assert_int_equal(read_name("textures/wood.png", &options, text), SNELL_OK);
}

static void extensions_are_lower_case(void **state) {
    (void)state;
    char out[8];
    import_extension("a/b.c/Duck.GLB", out, sizeof out);
    assert_string_equal(out, ".glb");
    const char *without[] = {"a.b/duck", ".hidden", "x/.hidden", "a.muchtoolong", ""};
    for (size_t i = 0; i < sizeof without / sizeof without[0]; i++) {
        import_extension(without[i], out, sizeof out);
        assert_string_equal(out, "");
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_scenes_folder_and_below_are_read),
        cmocka_unit_test(nothing_outside_is_read),
        cmocka_unit_test(asset_folders_are_read),
        cmocka_unit_test(what_is_no_file_gives_an_error),
        cmocka_unit_test(extensions_are_lower_case),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
