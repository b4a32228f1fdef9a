/* The scene language: what programs make, what their errors say and where, and that the sandbox is
 * the same in every run and always ends. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/error.h"
#include "cameras/camera.h"
#include "geometry/mesh.h"
#include "importers/importer.h"
#include "maths/functions.h"
#include "scene/records.h"
#include "geometry/solid.h"
#include "scene/settings.h"

extern const importer importer_lua;

static char folder[] = "/tmp/snell_test_lua_XXXXXX";

static int enter_folder(void **state) {
    (void)state;
    return mkdtemp(folder) == NULL || chdir(folder) != 0;
}

static int leave_folder(void **state) {
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return chdir("/") != 0 || system(command) != 0;
}

static void write_file(const char *name, const void *data, size_t size) {
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static import_options options_with(const char *const *params, size_t count) {
    return (import_options){
        .params = params, .param_count = count, .allow_programs = true, .memory_max = 1u << 29};
}

/* Runs a program of `size` bytes; NULL when it fails. */
static description *run_bytes(const char *text, size_t size, const char *const *params,
                              size_t count) {
    description *d;
    import_options options = options_with(params, count);
    write_file("scene.lua", text, size);
    assert_int_equal(description_create(&d), SNELL_OK);
    if (importer_lua.read("scene.lua", &options, d) == SNELL_OK) return d;
    description_destroy(d);
    return NULL;
}

static description *run(const char *text) { return run_bytes(text, strlen(text), NULL, 0); }

/* Runs a program that must succeed. */
static description *run_good(const char *text) {
    description *d = run(text);
    if (d == NULL)
        fail_msg("%s:%u: %s (%s)\n%s", error_last()->file, error_last()->line, error_last()->text,
                 error_last()->hint, text);
    return d;
}

static const void *desc_of(const description *d, category which, size_t index) {
    assert_true(index < d->objects[which].count);
    return d->objects[which].items[index].desc;
}

/* ---- bad programs ---- */

typedef struct bad {
    const char *program;
    snell_status status;
    uint32_t line;
    const char *text, *hint; /* hint NULL: any */
} bad;

static const bad bads[] = {
#include "lua_bad.inc"
};

static void bad_programs_get_their_exact_error(void **state) {
    (void)state;
    size_t wrong = 0;
    for (size_t i = 0; i < sizeof bads / sizeof bads[0]; i++) {
        const bad *b = &bads[i];
        description *d = run(b->program);
        const snell_message *m = error_last();
        bool right = d == NULL && m->status == b->status && m->line == b->line &&
                     strcmp(m->text, b->text) == 0 && strcmp(m->file, "scene.lua") == 0 &&
                     (b->hint == NULL || strcmp(m->hint, b->hint) == 0);
        if (!right) {
            wrong++;
            print_error("%s\n  wanted %d line %u: %s\n  got    %d line %u: %s [%s]\n", b->program,
                        b->status, b->line, b->text, d ? 0 : (int)m->status, m->line,
                        d ? "success" : m->text, m->hint);
        }
        description_destroy(d);
    }
    assert_int_equal(wrong, 0);
}

static void deep_nesting_is_a_clean_error(void **state) {
    (void)state;
    static const char *const pairs[] = {"()", "{}"};
    enum { DEPTH = 100000, LINE = 100 };
    char *text = malloc(4 * DEPTH);
    assert_non_null(text);
    for (size_t k = 0; k < 2; k++) {
        size_t size = (size_t)sprintf(text, "-- a first line\nx = ");
        for (size_t i = 0; i < DEPTH; i++) {
            text[size++] = pairs[k][0];
            if (i % LINE == LINE - 1) text[size++] = '\n';
        }
        if (k == 0) text[size++] = '1';
        for (size_t i = 0; i < DEPTH; i++) text[size++] = pairs[k][1];
        assert_null(run_bytes(text, size, NULL, 0));
        assert_int_equal(error_last()->status, SNELL_ERR_SYNTAX);
        assert_string_equal(error_last()->text, "too deeply nested: Lua reads at most 200 levels");
        assert_int_equal(error_last()->line, 3);
    }
    free(text);
}

static void bytecode_and_zero_bytes_are_refused(void **state) {
    (void)state;
    static const char compiled[] = "\x1bLua\x54\x00\x19\x93";
    assert_null(run_bytes(compiled, sizeof compiled, NULL, 0));
    assert_int_equal(error_last()->status, SNELL_ERR_SYNTAX);
    static const char zero[] = "local x = 1 \0 y";
    assert_null(run_bytes(zero, sizeof zero, NULL, 0));
    assert_int_equal(error_last()->status, SNELL_ERR_SYNTAX);
    static const char named[] = "sphere { name = 'a\\0b' }";
    assert_null(run_bytes(named, sizeof named - 1, NULL, 0));
    assert_string_equal(error_last()->text, "sphere: 'name' is empty or holds a zero byte");
    assert_non_null(memchr(named, 'a', sizeof named));
}

static double seconds_now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* Work that C functions do counts too. Generous limits: sanitizers and small machines are slow. */
static void everything_ends_soon(void **state) {
    (void)state;
    static const char *const endless[] = {
        "while true do pcall(function() while true do pcall(error) end end) end",
        "local t = {} for i = 1, 1000000 do t[i] = i end while true do table.sort(t) end",
        "local t = {} for i = 1, 100000 do t[i] = i end while true do next(t, 5) end",
        "local t = {} for i = 1, 100000 do t[i] = i end while true do table.insert(t, 1, 1) end",
        ("local g = sphere {} local t = {} "
         "for i = 1, 8 do for k = 1, 20 do t[k] = g end g = group(t) end")};
    for (size_t i = 0; i < sizeof endless / sizeof endless[0]; i++) {
        double begin = seconds_now();
        assert_null(run(endless[i]));
        assert_int_equal(error_last()->line, 1);
        assert_true(seconds_now() - begin < 30);
    }
}

static void memory_is_capped(void **state) {
    (void)state;
    assert_null(run("local t = {}\nfor i = 1, 1e9 do t[i] = i end"));
    assert_int_equal(error_last()->status, SNELL_ERR_MEMORY);
    assert_string_equal(error_last()->text, "the program needs more than 256 MiB of memory");
    assert_int_equal(error_last()->line, 2);
}

/* ---- good programs ---- */

static void shapes_are_drawn_where_they_are_made(void **state) {
    (void)state;
    description *d =
        run_good("local m = material.lambert { color = '#ff8000', name = 'orange' }\n"
                 "\n"
                 "sphere { center = {1,2,3}, radius = 0.5, material = m, name = 'ball',\n"
                 "         transform = transform.translate {0, 1, 0} }\n"
                 "plane {}\n");
    assert_int_equal(d->instance_count, 2);
    assert_string_equal(d->instances[0].name, "ball");
    assert_int_equal(d->instances[0].line, 3);
    assert_int_equal(d->instances[0].material, 0);
    assert_true(d->instances[0].to_world.m[1][3] == 1);
    assert_int_equal(d->instances[1].material, NO_MATERIAL);
    const object *ball = &d->objects[CATEGORY_SHAPE].items[d->instances[0].shape];
    assert_string_equal(ball->type->name, "sphere");
    const field *radius = type_find_field(ball->type, "radius");
    assert_true(*(const float *)((const char *)ball->desc + radius->offset) == 0.5f);
    const object *m = &d->objects[CATEGORY_MATERIAL].items[0];
    const snell_input *color =
        (const snell_input *)(const void *)((const char *)m->desc +
                                            type_find_field(m->type, "color")->offset);
    assert_true(color->value.x == 1 && color->value.z == 0);
    assert_true(fabs((double)color->value.y - 0.2158605) < 1e-6);
    assert_string_equal(d->format, "lua");
    assert_false(d->is_model);
    description_destroy(d);
}

static void every_registered_type_is_in_the_language(void **state) {
    (void)state;
    const type_info *type;
    for (uint32_t i = 0; (type = type_at(i)) != NULL; i++) {
        if (strcmp(type->name, "solid") == 0) continue; /* solids_are_shapes */
        static const char *const forms[] = {[CATEGORY_TEXTURE] = "texture.%s { xyzzy = 1 }",
                                            [CATEGORY_MATERIAL] = "material.%s { xyzzy = 1 }",
                                            [CATEGORY_LIGHT] = "light.%s { xyzzy = 1 }",
                                            [CATEGORY_SHAPE] = "%s { xyzzy = 1 }",
                                            [CATEGORY_CAMERA] = "camera { kind = '%s', xyzzy = 1 }",
                                            [CATEGORY_SETTING] = "%s { xyzzy = 1 }"};
        const char *form = forms[type->category];
        size_t before = strcspn(form, "%");
        char program[128];
        snprintf(program, sizeof program, "%.*s%s%s", (int)before, form, type->name,
                 form + before + 2);
        assert_null(run(program));
        assert_non_null(strstr(error_last()->text, "unknown field 'xyzzy'"));
    }
}

static void angles_are_degrees(void **state) {
    (void)state;
    description *d = run_good("camera { fov = 90 }");
    const perspective_desc *camera = desc_of(d, CATEGORY_CAMERA, 0);
    assert_true(camera->fov == (float)(PI / 2));
    description_destroy(d);
}

static void textures_stand_where_colours_do(void **state) {
    (void)state;
    description *d = run_good("local t = texture.checker { '#fff', {1, 0.5, 0}, size = 0.5 }\n"
                              "sphere { material = material.lambert { color = t } }");
    const object *m = &d->objects[CATEGORY_MATERIAL].items[0],
                 *t = &d->objects[CATEGORY_TEXTURE].items[0];
    const snell_input *color =
        (const snell_input *)(const void *)((const char *)m->desc +
                                            type_find_field(m->type, "color")->offset);
    assert_int_equal(color->texture.index1, 1);
    const snell_vec3 *b =
        (const snell_vec3 *)(const void *)((const char *)t->desc +
                                           type_find_field(t->type, "color_b")->offset);
    assert_true(b->x == 1 && b->y == 0.5f && b->z == 0);
    description_destroy(d);
}

static void groups_and_instances_are_flattened(void **state) {
    (void)state;
    description *d =
        run_good("local red, blue = material.lambert { color = {1,0,0} }, material.lambert { color "
                 "= {0,0,1} }\n"
                 "local a = sphere { name = 'a' }\n"
                 "local pair = group { a, sphere { material = red, name = 'b' }, material = blue, "
                 "name = 'pair',\n"
                 "  transform = transform.translate {1, 0, 0} }\n"
                 "instance { pair, transform = transform.scale(2), name = 'big' }\n"
                 "instance { pair, transform = transform.translate {0, 0, 5}, material = red }\n");
    assert_int_equal(d->instance_count, 4);
    assert_string_equal(d->instances[0].name, "big/pair/a");
    assert_string_equal(d->instances[3].name, "pair/b");
    assert_int_equal(d->instances[0].material, 1); /* the group's, since it has none */
    assert_int_equal(d->instances[1].material, 0); /* its own */
    assert_int_equal(d->instances[2].material, 0); /* the instance's beats all */
    assert_true(d->instances[0].to_world.m[0][3] == 2 && d->instances[0].to_world.m[0][0] == 2);
    assert_true(d->instances[2].to_world.m[0][3] == 1 && d->instances[2].to_world.m[2][3] == 5);
    assert_int_equal(d->objects[CATEGORY_SHAPE].count, 2);
    description_destroy(d);
    d = run_good("local g = sphere {} for i = 1, 8 do g = group { g } end");
    assert_int_equal(d->instance_count, 1);
    description_destroy(d);
}

static const solid_desc *solid_of(const description *d, uint32_t shape) {
    const object *o = &d->objects[CATEGORY_SHAPE].items[shape];
    assert_ptr_equal(o->type, &primitive_solid.info);
    return o->desc;
}

static void solids_are_shapes(void **state) {
    (void)state;
    description *d =
        run_good("local red, blue = material.lambert { color = {1,0,0} }, material.lambert { color "
                 "= {0,0,1} }\n"
                 "local pair = group { sphere {}, sphere { material = red }, material = blue,\n"
                 "  transform = transform.translate {1, 0, 0} }\n"
                 "local ball = sphere { radius = 3, transform = transform.scale(2) }\n"
                 "local cut = difference { ball, pair, plane { material = red }, name = 'cut' }\n"
                 "intersection { cut, box { min = {0,0,0}, max = {1,2,3} }, material = blue,\n"
                 "  transform = transform.translate {0, 0, 5} }\n"
                 "local b = union { ball }.bounds\n"
                 "assert(b.min[1] == -6 and b.size[2] == 12)\n"
                 "b = intersection { ball, plane { point = {0, 1, 0} } }.bounds\n"
                 "assert(b.max[2] == 1 and b.min[2] == -6)\n");
    /* sphere, sphere, ball, plane, pair's union, cut, box, the intersection; two more with a plane */
    assert_int_equal(d->objects[CATEGORY_SHAPE].count, 11);
    const solid_desc *pair = solid_of(d, 4), *cut = solid_of(d, 5), *last = solid_of(d, 7);
    assert_int_equal(pair->operation, SOLID_UNION);
    assert_int_equal(pair->materials[0].index1, 2);
    assert_int_equal(pair->materials[1].index1, 1);
    assert_true(pair->transforms[1].m[0][3] == 1);
    assert_int_equal(cut->operation, SOLID_DIFFERENCE);
    assert_int_equal(cut->shapes_count, 3);
    assert_int_equal(cut->shapes[0].index1, 3);
    assert_int_equal(cut->shapes[1].index1, 5);
    assert_int_equal(cut->shapes[2].index1, 4);
    assert_int_equal(cut->materials[0].index1, 0);
    assert_int_equal(cut->materials[2].index1, 1);
    assert_true(cut->transforms[0].m[0][0] == 2);
    assert_non_null(description_find(d, CATEGORY_SHAPE, "cut"));
    assert_int_equal(last->operation, SOLID_INTERSECTION);
    assert_int_equal(last->shapes[0].index1, 6);
    /* What was taken is not drawn: the intersection is, and the two that were asked for bounds. */
    assert_int_equal(d->instance_count, 3);
    assert_int_equal(d->instances[0].shape, 7);
    assert_int_equal(d->instances[0].material, 1);
    assert_true(d->instances[0].to_world.m[2][3] == 5);
    description_destroy(d);
    d = run_good("difference { sphere {}, box { min = {0,0,0}, max = {2,2,2} },\n"
                 "  motion = function(t) return transform.translate {t, 0, 0} end }\n"
                 "animation { fps = 10, first = 1, last = 5 }\ncamera {}");
    assert_true(d->instance_count == 1 && d->instances[0].key_count >= 2);
    description_destroy(d);
}

static void transforms_compose_right_to_left(void **state) {
    (void)state;
    description *d = run_good(
        "sphere { transform = transform.translate {1,2,3} * transform.rotate { axis = {0,1,0}, "
        "angle = 90 }\n"
        "                     * transform.scale {2, 1, 1} }\n"
        "sphere { transform = transform.rotate { axis = {0,0,2}, angle = -90, about = {1,1,0} } }\n"
        "sphere { transform = transform.look_at { from = {0,0,5}, at = {5,0,5} } }");
    /* scale x by 2, then a quarter turn brings x to -z, exactly; then the translation */
    static const float expected[3][3][4] = {{{0, 0, 1, 1}, {0, 1, 0, 2}, {-2, 0, 0, 3}},
                                            {{0, 1, 0, 0}, {-1, 0, 0, 2}, {0, 0, 1, 0}},
                                            {{0, 0, -1, 0}, {0, 1, 0, 0}, {1, 0, 0, 5}}};
    for (size_t k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 4; j++)
                assert_true(d->instances[k].to_world.m[i][j] == expected[k][i][j]);
    description_destroy(d);
}

static void a_matrix_is_given_by_rows(void **state) {
    (void)state;
    description *d = run_good(
        "local t = transform\n"
        "sphere { transform = t.matrix { {1, 0.5, 0, 2}, {0, 1, 0, 3}, {0.25, 0, 1, 4} } }\n"
        "sphere { transform = t.matrix { 1, 0.5, 0, 2, 0, 1, 0, 3, 0.25, 0, 1, 4 } }\n"
        "sphere { transform = t.matrix { 1, 0.5, 0, 2, 0, 1, 0, 3, 0.25, 0, 1, 4, 0, 0, 0, 1 } }\n"
        "sphere { transform = t.translate {2, 3, 4} *\n"
        "         t.matrix { {1, 0.5, 0, 0}, {0, 1, 0, 0}, {0.25, 0, 1, 0}, {0, 0, 0, 1} } }");
    static const float expected[3][4] = {{1, 0.5f, 0, 2}, {0, 1, 0, 3}, {0.25f, 0, 1, 4}};
    assert_int_equal(d->instance_count, 4);
    for (size_t k = 0; k < 4; k++)
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 4; j++)
                assert_true(d->instances[k].to_world.m[i][j] == expected[i][j]);
    description_destroy(d);
}

static void triangles_and_meshes_are_meshes(void **state) {
    (void)state;
    description *d =
        run_good("triangle { {0,0,0}, {1,0,0}, {0,1,0} }\n"
                 "mesh { positions = {0,0,0, 1,0,0, 0,1,0, 1,1,0}, indices = {{0,1,2}, {1,3,2}},\n"
                 "       uvs = {{0,0}, {1,0}, {0,1}, {1,1}} }");
    const mesh_desc *one = desc_of(d, CATEGORY_SHAPE, 0), *two = desc_of(d, CATEGORY_SHAPE, 1);
    assert_int_equal(mesh_triangle_count(one), 1);
    assert_int_equal(mesh_triangle_count(two), 2);
    assert_int_equal(two->positions_count, 4);
    assert_true(two->positions[3].x == 1 && two->positions[3].y == 1 && two->indices[4] == 3);
    assert_true(two->uvs_count == 4 && two->uvs[2].y == 1);
    description_destroy(d);
}

typedef struct heightfield_view { /* begins as heightfield_desc does */
    size_t struct_size;
    const float *heights;
    size_t heights_count;
    int32_t columns, rows;
} heightfield_view;

static void heights_may_be_rows(void **state) {
    (void)state;
    description *d = run_good("local rows = { {0, 1, 2}, {3, 4, 5} }\n"
                              "heightfield { heights = rows }\n"
                              "heightfield { heights = rows, columns = 3, rows = 2 }\n"
                              "print(#rows, #rows[1])");
    heightfield_view both[2];
    for (uint32_t k = 0; k < 2; k++) {
        memcpy(&both[k], desc_of(d, CATEGORY_SHAPE, k), sizeof both[k]);
        assert_int_equal(both[k].heights_count, 6);
        assert_true(both[k].columns == 3 && both[k].rows == 2);
        for (int i = 0; i < 6; i++) assert_true(both[k].heights[i] == (float)i);
    }
    assert_string_equal(d->messages[0].text, "2\t3"); /* the program's own table is as it was */
    description_destroy(d);
}

static void a_profile_is_a_list_of_pairs(void **state) {
    (void)state;
    description *d = run_good("lathe { profile = {{0,0}, {1,0.5}, {0,2}}, smooth = false }\n"
                              "lathe { profile = {0,0, 1,0.5, 0,2} }\n"
                              "print(cone { from = {0,0,0}, to = {0,3,0} }.bounds.max[2] >= 3)");
    typedef struct lathe_like {
        size_t struct_size;
        const vec2 *profile;
        size_t profile_count;
        bool smooth;
    } lathe_like;
    for (uint32_t i = 0; i < 2; i++) {
        const lathe_like *lathe = desc_of(d, CATEGORY_SHAPE, i);
        assert_int_equal(lathe->profile_count, 3);
        assert_true(lathe->profile[1].x == 1 && lathe->profile[1].y == 0.5f);
        assert_true(lathe->profile[2].x == 0 && lathe->profile[2].y == 2);
        assert_int_equal(lathe->smooth, i == 1);
    }
    assert_string_equal(d->messages[0].text, "true");
    description_destroy(d);
}

static void bounds_can_be_read(void **state) {
    (void)state;
    description *d = run_good(
        "local s = sphere { center = {1,2,3}, radius = 1, transform = transform.scale(2) }\n"
        "local b = s.bounds\n"
        "print(b.min[1], b.min[2], b.min[3], b.max[1], b.center[3], b.size[1])\n"
        "local g = group { s, box { min = {-9,0,0}, max = {-8,1,1} }, plane {} }\n"
        "print(g.bounds.min[1], g.bounds.max[3])");
    assert_string_equal(d->messages[0].text, "0.0\t2.0\t4.0\t4.0\t6.0\t4.0");
    assert_string_equal(d->messages[1].text, "-9.0\t8.0");
    description_destroy(d);
}

static void a_camera_can_frame_an_object(void **state) {
    (void)state;
    description *d = run_good("local s = box { min = {-1,-1,-1}, max = {1,1,1}, transform = "
                              "transform.translate {5,0,0} }\n"
                              "camera { view = {90, 0}, of = s, fov = 60 }\n"
                              "render { width = 400, height = 300 }");
    const perspective_desc *camera = desc_of(d, CATEGORY_CAMERA, 0);
    /* the sphere of radius sqrt(3) at sin(30) = 1/2, from +x */
    assert_true(camera->at.x == 5 && camera->at.y == 0 && camera->at.z == 0);
    assert_true(fabs((double)camera->from.x - (5 + 2 * sqrt(3))) < 1e-5);
    assert_true(fabs((double)camera->from.y) < 1e-6 && fabs((double)camera->from.z) < 1e-6);
    description_destroy(d);
}

static dvec3 place_at(const instance *at, double time, dvec3 p) {
    double m[3][4];
    motion_interpolate(at->keys, at->key_count, time, m);
    return (dvec3){m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3],
                   m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
                   m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]};
}

#define AT(p, X, Y)                                                                                \
    assert_true(fabs((p).x - (X)) < 2e-4 && fabs((p).y - (Y)) < 2e-4 && fabs((p).z) < 2e-4)

/* A whole turn between two keys is none: the wheel would stand still without a word. */
static void keys_that_turn_too_far_get_a_warning(void **state) {
    (void)state;
    static const struct {
        const char *from, *to;
        int degrees; /* 0: no warning */
    } cases[] = {{"r(0)", "r(360)", 360},
                 {"s(2)", "r(180)", 180},
                 {"t{1,0,0}", "t{0,1,0} * r(200) * s(2)", 200},
                 {"r(100) * r(100)", "r(0)", 200},
                 {"r(90)", "transform.rotate { axis = {0,0,-2}, angle = 100 }", 190},
                 {"r(0)", "r(179)", 0},
                 {"r(300)", "r(400)", 0},
                 {"r(0)", "transform.scale {-1, 1, 1} * r(300)", 0}, /* not known */
                 {"r(10)", "transform.rotate { axis = {0,1,0}, angle = 300 }", 0},
                 {"s(1)", "transform.matrix {-1,0,0,0, 0,-1,0,0, 0,0,1,0}", 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char program[512], text[256];
        snprintf(program, sizeof program,
                 "local s, t = transform.scale, transform.translate\n"
                 "local function r(a) return transform.rotate { axis = {0,0,1}, angle = a } end\n"
                 "sphere { motion = { {time = 0, transform = %s},\n{time = 1, transform = %s} } }",
                 cases[i].from, cases[i].to);
        description *d = run_good(program);
        assert_int_equal(d->message_count, cases[i].degrees != 0);
        snprintf(text, sizeof text,
                 "sphere: 'motion' [2] turns by %d degrees from the key before: between keys it "
                 "turns the shorter way, by less than 180",
                 cases[i].degrees);
        if (d->message_count) {
            assert_int_equal(d->messages[0].severity, SNELL_WARNING);
            assert_int_equal(d->messages[0].line, 3);
            assert_string_equal(d->messages[0].text, text);
        }
        description_destroy(d);
    }
}

/* Keys stay as they are written; functions, and motions in motions, are sampled. */
static void motion_arrives(void **state) {
    (void)state;
    description *d = run_good(
        "animation { fps = 10, first = 3 }\n"
        "local move, turn = transform.translate, transform.rotate\n"
        "local function spin(t) return turn { axis = {0,0,1}, angle = 900 * (t - 0.2) } end\n"
        "sphere { motion = { {time = 0, transform = move {0,0,0}}, {time = 9, transform = move "
        "{9,0,0}} } }\n"
        "sphere { transform = move {2,0,0}, motion = spin }\n"
        "group { sphere { transform = move {1,0,0}, motion = spin }, transform = move {0,5,0},\n"
        "  motion = { {time = 0, transform = move {0,0,0}}, {time = 1, transform = move {10,0,0}} "
        "} }\n"
        "sphere { radius = 0.5 }\n"
        "camera { shutter = {0, 1} }");
    assert_int_equal(d->instance_count, 4);
    assert_int_equal(((const animation_desc *)description_setting(d, "animation")->desc)->frame, 3);
    const instance *at = d->instances;
    assert_true(at[0].key_count == 2 && at[0].keys[1].time == 9 && at[3].key_count == 0);
    assert_int_equal(at[1].key_count, MOTION_STEPS + 1); /* from 0.2 to 0.3 s: a quarter */
    assert_true(at[1].keys[0].time == 0.2f && at[1].keys[MOTION_STEPS].time == 0.3f);
    dvec3 here = {0, 0, 0};
    AT(place_at(&at[1], 0.2, here), 2, 0);
    AT(place_at(&at[1], 0.25, here), 2 * sqrt(0.5), 2 * sqrt(0.5));
    AT(place_at(&at[1], 0.3, here), 0, 2);
    AT(place_at(&at[2], 0.2, here), 2 + 1, 5);
    AT(place_at(&at[2], 0.25, here), 2.5 + sqrt(0.5), 5 + sqrt(0.5));
    AT(place_at(&at[2], 0.3, here), 3, 5 + 1);
    description_destroy(d);
}

/* A camera's function is asked over its own shutter; time and frame follow --frame. */
static void cameras_and_the_clock(void **state) {
    (void)state;
    import_options options = options_with(NULL, 0);
    static const char program[] =
        "animation { fps = 4, last = 8 }\n"
        "sphere { center = {time, frame, 0}, motion = { {time = 0, transform = transform.translate "
        "{0, 0, 0}},\n"
        "  {time = 2, transform = transform.translate {0, 0, 8}} } }\n"
        "local b = sphere { motion = function(t) return transform.translate {t, 0, 0} end "
        "}.bounds\n"
        "print(b.center[1])\n"
        "camera { kind = 'fisheye', shutter = {-1, 1},\n"
        "  motion = function(t) return transform.translate {t, 0, 0} end }";
    options.frame = 6;
    write_file("scene.lua", program, sizeof program - 1);
    description *d;
    assert_int_equal(description_create(&d), SNELL_OK);
    snell_status status = importer_lua.read("scene.lua", &options, d);
    if (status) print_error("%s\n", error_last()->text);
    assert_int_equal(status, SNELL_OK);
    const snell_sphere_desc *s = desc_of(d, CATEGORY_SHAPE, 0);
    assert_true(s->center.x == 1.25f && s->center.y == 6);
    assert_string_equal(d->messages[0].text, "1.25");
    const camera_common *c = desc_of(d, CATEGORY_CAMERA, 0);
    assert_int_equal(c->motion_count, MOTION_STEPS + 1);
    assert_true(c->motion[0].time == 1 && c->motion[MOTION_STEPS].time == 1.5f);
    assert_true(c->motion[0].transform.m[0][3] == 1);
    /* the sphere's function: over the camera's shutter, which is longer than the usual */
    assert_true(d->instances[1].keys[0].time == 1 && d->instances[1].keys[16].time == 1.5f);
    description_destroy(d);
    options.frame = 9;
    assert_int_equal(description_create(&d), SNELL_OK);
    assert_int_equal(importer_lua.read("scene.lua", &options, d), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "frame 9: the animation has frames 1 to 8");
    description_destroy(d);
}

/* An included program has its includer's clock, and what it moves still moves. */
static void included_things_move(void **state) {
    (void)state;
    static const char part[] =
        "sphere { center = {time, 0, 0}, motion = function(t) return transform.translate {t, 0, 0} "
        "end }\n"
        "camera { motion = { {time = 0, transform = transform.translate {0, 0, 0}},\n"
        "  {time = 1, transform = transform.translate {0, 0, 1}} } }";
    write_file("part.lua", part, sizeof part - 1);
    description *d = run_good("animation { fps = 10, first = 5 }\n"
                              "model { file = 'part.lua', camera = true,\n"
                              "  transform = transform.rotate { axis = {0, 1, 0}, angle = 90 } }");
    const snell_sphere_desc *s = desc_of(d, CATEGORY_SHAPE, 0);
    assert_true(fabsf(s->center.x - 0.4f) < 1e-6f);
    double m[3][4];
    motion_interpolate(d->instances[0].keys, d->instances[0].key_count, 0.44, m);
    assert_true(fabs(m[2][3] + 0.44) < 1e-5 && fabs(m[0][3]) < 1e-5); /* x turned to -z */
    const camera_common *c = desc_of(d, CATEGORY_CAMERA, 0);
    assert_true(c->motion_count == 2 && fabsf(c->motion[1].transform.m[0][3] - 1) < 1e-6f);
    assert_true(fabsf(c->motion[1].transform.m[0][0] - 1) < 1e-6f);
    description_destroy(d);
}

static void settings_and_lights_arrive(void **state) {
    (void)state;
    description *d =
        run_good("render { integrator = 'appel', width = 320, height = 240.0, samples = 4 }\n"
                 "background { color = {0.1, 0.2, 0.3}, top = 0.5 }\n"
                 "ambient { color = 0.05 }\n"
                 "light.point { position = {0, 5, 0}, power = 100 }\n"
                 "light.directional { direction = {0, -2, 0}, irradiance = 3 }");
    const render_desc *render = description_setting(d, "render")->desc;
    assert_true(render->width == 320 && render->height == 240 && render->samples == 4);
    assert_int_equal(render->integrator, 1);
    const background_desc *sky = description_setting(d, "background")->desc;
    assert_true(sky->top.x == 0.5f && sky->color.y == 0.2f);
    assert_int_equal(d->objects[CATEGORY_LIGHT].count, 2);
    description_destroy(d);
}

/* ---- parameters ---- */

static description *run_with(const char *program, const char *param) {
    return run_bytes(program, strlen(program), &param, 1);
}

static void parameters_are_typed_by_their_default(void **state) {
    (void)state;
    const char *program = "local n = param('n', 4, 'how many')\n"
                          "local r = param('r', 0.5, 'radius')\n"
                          "local on = param('on', false, 'draw')\n"
                          "local word = param('word', 'wood', 'what')\n"
                          "local f = param.file('f', 'a.ply', 'model')\n"
                          "print(n, r, on, word, f)";
    static const struct {
        const char *param, *printed;
    } good[] = {{"n=7", "7\t0.5\tfalse\twood\ta.ply"},
                {"r=2", "4\t2.0\tfalse\twood\ta.ply"},
                {"on=true", "4\t0.5\ttrue\twood\ta.ply"},
                {"word=x=y", "4\t0.5\tfalse\tx=y\ta.ply"},
                {"f=b.obj", "4\t0.5\tfalse\twood\tb.obj"}};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        description *d = run_with(program, good[i].param);
        assert_non_null(d);
        assert_string_equal(d->messages[0].text, good[i].printed);
        assert_int_equal(d->param_count, 5);
        assert_string_equal(d->params[0].kind, "integer");
        assert_string_equal(d->params[0].default_value, "4");
        assert_string_equal(d->params[4].kind, "file");
        description_destroy(d);
    }
    static const struct {
        const char *param, *text, *hint;
        uint32_t line;
    } wrong[] = {
        {"n=7.5", "param 'n': '7.5' is not an integer",
         "such as -D n=4; the scene's default 4 is an integer, 4.0 would take fractions", 1},
        {"n=", "param 'n': '' is not an integer", "such as -D n=4", 1},
        {"r=nan", "param 'r': 'nan' is not a number", "such as -D r=0.5", 2},
        {"r=1e999", "param 'r': '1e999' is not a finite number", "such as -D r=0.5", 2},
        {"on=1", "param 'on': '1' is not true or false", "such as -D on=false", 3},
        {"wrod=1", "-D wrod: the scene has no parameter of that name", "did you mean 'word'?", 0},
        {"colour=1", "-D colour: the scene has no parameter of that name",
         "the scene has n, r, on, word, f", 0},
        {"n", "-D n: has no value", "such as -D depth=5", 0}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_null(run_with(program, wrong[i].param));
        assert_int_equal(error_last()->status, SNELL_ERR_ARGUMENT);
        assert_string_equal(error_last()->text, wrong[i].text);
        assert_string_equal(error_last()->hint, wrong[i].hint);
        assert_int_equal(error_last()->line, wrong[i].line);
    }
}

/* ---- the same in every run ---- */

typedef struct buffer {
    unsigned char *data;
    size_t size, capacity;
} buffer;

static bool append_bytes(void *user, const void *data, size_t size) {
    buffer *b = user;
    if (b->size + size > b->capacity) {
        b->capacity = 2 * (b->size + size);
        b->data = realloc(b->data, b->capacity);
        assert_non_null(b->data);
    }
    memcpy(b->data + b->size, data, size);
    b->size += size;
    return true;
}

static const char varied[] =
    "local t = {}\n"
    "for i = 1, 200 do t['k' .. math.random(1000)] = i; t[math.random(50) / 4] = -i end\n"
    "local order = ''\n"
    "for k, v in pairs(t) do order = order .. tostring(k) .. '=' .. v .. ' ' end\n"
    "print(order, tostring(t), tostring(print), sphere, material.mirror {}, string.format('%s', "
    "t))\n"
    "local lengths = 0\n" /* of tables with holes, which depend on how keys collide */
    "for n = 1, 2000 do\n"
    "  local h = {}\n"
    "  for i = 1, math.random(3, 40) do\n"
    "    local r = math.random(6)\n"
    "    if r <= 2 then h['k' .. math.random(30)] = i elseif r == 3 then h['k' .. math.random(30)] "
    "= nil\n"
    "    elseif r == 4 then h[math.random(30)] = nil else h[math.random(30)] = i end\n"
    "  end\n"
    "  lengths = (lengths * 31 + #h) % 1000000007\n"
    "end\n"
    "print(lengths)\n"
    "local names = {}\n"
    "for i = 1, 300 do names[i] = { key = math.random(7), at = i } end\n"
    "table.sort(names, function(a, b) return a.key < b.key end)\n"
    "for i, n in ipairs(names) do\n"
    "  sphere { center = {math.sin(n.at), n.at ^ 0.37, math.exp(-n.at / 50)}, radius = 1 + n.key ^ "
    "1.5 }\n"
    "end\n"
    "local k = nil\n"
    "repeat k = next(t, k) if k then box { min = {0,0,0}, max = {1, 1, 1 + #tostring(k)} } end "
    "until not k\n";

static void two_runs_give_the_same_records(void **state) {
    (void)state;
    buffer runs[2] = {{0}, {0}};
    for (size_t i = 0; i < 2; i++) {
        char *elsewhere =
            malloc(100000 * (i + 1)); /* other addresses, another seed of Lua's hash */
        description *d = run_good(varied);
        assert_int_equal(records_write(d, append_bytes, &runs[i]), SNELL_OK);
        assert_null(strstr(d->messages[0].text, "0x"));
        description_destroy(d);
        free(elsewhere);
    }
    assert_int_equal(runs[0].size, runs[1].size);
    assert_memory_equal(runs[0].data, runs[1].data, runs[0].size);
    free(runs[0].data);
    free(runs[1].data);
}

static void prints(const char *program, const char *expected) {
    description *d = run_good(program);
    assert_int_equal(d->message_count, 1);
    assert_int_equal(d->messages[0].severity, SNELL_INFO);
    assert_string_equal(d->messages[0].text, expected);
    description_destroy(d);
}

static void tables_are_walked_in_order(void **state) {
    (void)state;
    prints(
        "local t = {b = 1, a = 2, [3] = 3, [1] = 1, [2.5] = 4, [-1] = 0, ['10'] = 5, [2^53] = 6}\n"
        "local s = '' for k, v in pairs(t) do s = s .. k .. ':' .. v .. ' ' end\n"
        "local k = next(t) while k ~= nil do s = s .. k .. ' ' k = next(t, k) end print(s)",
        "-1:0 1:1 2.5:4 3:3 9007199254740992:6 10:5 a:2 b:1 "
        "-1 1 2.5 3 9007199254740992 10 a b ");
    prints("local t = {1, 2, 3, 4} local s = ''\n"
           "for k in pairs(t) do s = s .. k t[k + 1] = nil end print(s)",
           "13");
    prints("local t = {[math.maxinteger] = 1, [2^63] = 2, [math.mininteger] = 3, [-2^70] = 4, "
           "[1/0] = 5}\n"
           "local s = '' for k, v in pairs(t) do s = s .. v end print(s)",
           "43125");
    prints("local t = {} for i = 1, 20 do t[i] = {i % 3, i} end\n"
           "table.sort(t, function(a, b) return a[1] < b[1] end)\n"
           "local s = '' for i, p in ipairs(t) do s = s .. p[2] .. ' ' end print(s)",
           "3 6 9 12 15 18 1 4 7 10 13 16 19 2 5 8 11 14 17 20 ");
    prints("local t = {5, 2, 8, 1, 9, 3, 7} table.sort(t) print(table.concat(t, ' '))",
           "1 2 3 5 7 8 9");
}

static void values_are_shown_without_addresses(void **state) {
    (void)state;
    prints("print({}, print, sphere {}, material.mirror {}, transform.scale(1), nil, 1, 1.0, 'x')",
           "table\tfunction\tshape\tmaterial\ttransform\tnil\t1\t1.0\tx");
    prints("print(string.format('%s|%s|%5.2f|%d|%%|%q', {}, setmetatable({}, {__tostring = "
           "function() return 'own' end}), 2.5, 3, 'a'))",
           "table|own| 2.50|3|%|\"a\"");
    prints("print(pcall(error, {}))", "false\ttable");
    prints("print(select(2, pcall(function() sphere { radus = 1 } end)))",
           "scene.lua:1: sphere: unknown field 'radus'");
}

/* x^y, and elementary functions, are those of maths/functions.h, in folded constants too. */
static void maths_is_our_own(void **state) {
    (void)state;
    description *d = run_good("local x = 2.7 mesh { positions = {x ^ 1.3, 2.7 ^ 1.3, math.sin(x),\n"
                              "math.exp(x), math.log(x), math.atan(1, x),\n"
                              "math.log(x, 10), math.cos(x), math.tan(x)}, indices = {0, 1, 2} }");
    const float *p = &((const mesh_desc *)desc_of(d, CATEGORY_SHAPE, 0))->positions[0].x;
    double x = 2.7;
    const double expected[] = {
        fn_pow(x, 1.3), fn_pow(x, 1.3),         fn_sin(x), fn_exp(x), fn_log(x),
        fn_atan2(1, x), fn_log(x) / fn_log(10), fn_cos(x), fn_tan(x)};
    for (int i = 0; i < 9; i++) assert_true(p[i] == (float)expected[i]);
    description_destroy(d);
    prints("local bad = 0 for i = 0, 60 do if 2 ^ i ~= 1 << i then bad = bad + 1 end end\n"
           "print(bad, 10 ^ 2, 0.5 ^ 2, (-2) ^ 3, 4 ^ 0.5, 0 ^ 0)",
           "0\t100.0\t0.25\t-8.0\t2.0\t1.0");
}

static void random_numbers_are_fixed(void **state) {
    (void)state;
    prints("local a = math.random() math.randomseed(1) local b = math.random() math.randomseed(2)\n"
           "print(a == b, a == math.random(), a >= 0 and a < 1)",
           "true\tfalse\ttrue");
    prints("local seen = {} for i = 1, 1000 do seen[math.random(-2, 2)] = true end\n"
           "local s = '' for k in pairs(seen) do s = s .. k .. ' ' end print(s)",
           "-2 -1 0 1 2 ");
    /* SplitMix64 from 1234567 begins with 6457827717110365317 and 3203168211198807973 */
    prints("math.randomseed(1234567) print(math.random(), math.random())",
           "0.35007954202141\t0.17364409667091");
}

static void pcall_catches_what_is_not_final(void **state) {
    (void)state;
    description *d = run_good("local ok, why = pcall(sphere, { radius = -1 })\n"
                              "if ok then error('made') end\n"
                              "sphere { radius = 1 }");
    assert_int_equal(d->instance_count, 1);
    description_destroy(d);
}

/* ---- other files ---- */

static void what_reflects_more_than_it_gets_is_warned_of(void **state) {
    (void)state;
    description *d = run_good("material.lambert { color = 1 } material.mirror { color = {1,1,0} }\n"
                              "material.lambert { color = 2 }\n"
                              "material.lambert { color = {0, 3, 0}, emission = 9 }\n"
                              "material.glazed { base = material.blinn_phong { specular = 5 },\n"
                              "                  reflectance = 1.5 }");
    assert_int_equal(d->message_count, 2);
    assert_string_equal(d->messages[0].text,
                        "material.lambert: 'color' is above 1: more light leaves than arrives");
    assert_int_equal(d->messages[0].line, 2);
    assert_int_equal(d->messages[0].severity, SNELL_WARNING);
    assert_non_null(strstr(d->messages[1].text, "material.glazed: 'reflectance'"));
    description_destroy(d);
}

static void included_scenes_add_everything(void **state) {
    (void)state;
    static const char part[] =
        "local m = material.lambert { name = 'wood', color = 0.5 }\n"
        "sphere { material = m, name = 'ball' }\n"
        "light.point { position = {1, 0, 0}, intensity = 2, name = 'lamp' }\n"
        "camera { from = {0,0,9}, name = 'front' }\n"
        "param('n', 3, 'a number')\n"
        "print('hello')";
    write_file("part.lua", part, sizeof part - 1);
    description *d =
        run_with("material.lambert { name = 'wood' }\n"
                 "local a = include 'part.lua'\n"
                 "local b = model { file = 'part.lua', transform = transform.translate {0, 1, 0},\n"
                 "  name = 'copy', material = material.mirror {}, lights = true }\n"
                 "print(a.bounds.max[2], b.bounds.max[2])",
                 "n=5");
    assert_non_null(d);
    assert_int_equal(d->instance_count, 2);
    assert_int_equal(d->objects[CATEGORY_CAMERA].count, 1);
    assert_int_equal(d->objects[CATEGORY_LIGHT].count, 2);
    assert_string_equal(d->objects[CATEGORY_MATERIAL].items[1].name, "wood.2");
    assert_int_equal(d->instances[0].material, 1);
    assert_string_equal(d->instances[1].name, "copy/ball");
    assert_string_equal(d->objects[CATEGORY_MATERIAL].items[d->instances[1].material].type->name,
                        "mirror");
    assert_true(d->instances[1].to_world.m[1][3] == 1);
    const object *lamp = &d->objects[CATEGORY_LIGHT].items[1];
    const snell_vec3 *at =
        (const snell_vec3 *)(const void *)((const char *)lamp->desc +
                                           type_find_field(lamp->type, "position")->offset);
    assert_true(at->x == 1 && at->y == 1);
    assert_string_equal(d->messages[d->message_count - 1].text, "1.0\t2.0");
    assert_string_equal(d->params[0].value, "5");
    description_destroy(d);
}

static void errors_in_other_files_name_them(void **state) {
    (void)state;
    static const char part[] = "\n\nsphere { radus = 1 }";
    write_file("broken.lua", part, sizeof part - 1);
    assert_null(run("include 'broken.lua'"));
    assert_non_null(strstr(error_last()->file, "broken.lua"));
    assert_int_equal(error_last()->line, 3);
    static const char self[] = "include 'self.lua'";
    write_file("self.lua", self, sizeof self - 1);
    assert_null(run("include 'self.lua'"));
    assert_string_equal(error_last()->text, "scenes in scenes, more than 8 deep");
    /* a loop over an endless include spends one budget */
    static const char slow[] = "while true do end";
    write_file("slow.lua", slow, sizeof slow - 1);
    assert_null(run("while true do pcall(include, 'slow.lua') end"));
    assert_string_equal(error_last()->text,
                        "the program runs for too long: more than 200 million steps");
    write_file("twice.lua", "render {}", 9);
    assert_null(run("render {}\ninclude 'twice.lua'"));
    assert_string_equal(error_last()->text, "render: given a second time");
}

/* 1 x 1 and red: the smallest PNG that shows that images arrive. */
static const unsigned char red_png[] = {
    0x89, 'P',  'N',  'G',  0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 'I',  'H',
    'D',  'R',  0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x02, 0x00, 0x00,
    0x00, 0x90, 0x77, 0x53, 0xde, 0x00, 0x00, 0x00, 0x0c, 'I',  'D',  'A',  'T',  0x78,
    0x9c, 0x63, 0xf8, 0xcf, 0xc0, 0x00, 0x00, 0x03, 0x01, 0x01, 0x00, 0xc9, 0xfe, 0x92,
    0xef, 0x00, 0x00, 0x00, 0x00, 'I',  'E',  'N',  'D',  0xae, 0x42, 0x60, 0x82};

static void images_are_read(void **state) {
    (void)state;
    write_file("red.png", red_png, sizeof red_png);
    description *d =
        run_good("local t = texture.image { file = 'red.png', wrap_u = 'clamp', name = 'red' }\n"
                 "sphere { material = material.lambert { color = t } }");
    assert_int_equal(d->objects[CATEGORY_TEXTURE].count, 1);
    assert_string_equal(d->objects[CATEGORY_TEXTURE].items[0].name, "red");
    description_destroy(d);
    write_file("cut.png", red_png, 40);
    assert_null(run("local t = texture.image { file = 'cut.png' }"));
    assert_int_equal(error_last()->line, 1);
    assert_string_equal(error_last()->file, "scene.lua");
}

/* Of the surface and of its coat; data that is said to be linear is in order. */
static void normals_that_are_colors_are_warned_of(void **state) {
    (void)state;
    write_file("red.png", red_png, sizeof red_png);
    description *d = run_good(
        "local m = texture.image { file = 'red.png' }\n"
        "local n = texture.image { file = 'red.png', encoding = 'linear' }\n"
        "sphere { material = material.lambert { normal_map = m } }\n"
        "sphere { material = material.principled { clearcoat = 1, clearcoat_normal_map = m } }\n"
        "sphere { material = material.principled { normal_map = n, clearcoat_normal_map = n } }");
    assert_int_equal(d->message_count, 2);
    assert_non_null(strstr(d->messages[0].text, "'normal_map' is read as sRGB"));
    assert_non_null(strstr(d->messages[1].text, "'clearcoat_normal_map' is read as sRGB"));
    description_destroy(d);
}

static const float *heights_of(const description *d, size_t index) {
    const object *o = &d->objects[CATEGORY_SHAPE].items[index];
    const field *f = type_find_field(o->type, "heights");
    const float *const *at = (const void *)((const char *)o->desc + f->offset);
    return *at;
}

static void heights_are_a_list_a_function_or_a_picture(void **state) {
    (void)state;
    /* PFM: rows bottom first; its first row of posts is the picture's top. */
    const float values[] = {0.25f, 0.5f, 3, 1000};
    const size_t head = strlen("Pf\n2 2\n-1.0\n");
    unsigned char file[64];
    memcpy(file, "Pf\n2 2\n-1.0\n", head);
    memcpy(file + head, values, sizeof values);
    write_file("hills.pfm", file, head + sizeof values);
    description *d = run_good(
        "local t = { heights = function(x, z) return x + 10 * z end, columns = 3, rows = 2,\n"
        "  min = {-1, 0, 5}, max = {1, 1, 6} }\n"
        "heightfield(t)\n"
        "assert(type(t.heights) == 'function')\n"
        "heightfield { heights = {1, 2, 3, 4}, columns = 2, rows = 2 }\n"
        "heightfield { file = 'hills.pfm' }\n"
        "curves { points = {{0,0,0}, {0,1,0}, {1,0,0}, {1,1,0}}, starts = {0, 2}, radius = 0.1,\n"
        "  basis = 'linear', kind = 'ribbon' }");
    const float computed[] = {49, 50, 51, 59, 60, 61}, listed[] = {1, 2, 3, 4},
                read[] = {3, 1000, 0.25f, 0.5f};
    assert_memory_equal(heights_of(d, 0), computed, sizeof computed);
    assert_memory_equal(heights_of(d, 1), listed, sizeof listed);
    assert_memory_equal(heights_of(d, 2), read, sizeof read);
    assert_int_equal(d->objects[CATEGORY_SHAPE].count, 4);
    description_destroy(d);
}

/* The table of a program stays as it is: keys become one list. */
static void keys_of_meshes_arrive(void **state) {
    (void)state;
    description *d = run_good(
        "local flat = {{0,0,0}, {1,0,0}, {0,0,1}}\n"
        "local up = {{0,0,-1}, {0,1,0}, {0,1,0}}\n"
        "local t = { indices = {{0, 2, 1}}, uvs = {{0,0}, {1,0}, {0,1}}, keys = {\n"
        "  {time = 0.5, positions = flat, normals = up},\n"
        "  {time = 0.75, positions = {{0,1,0}, {2,0,0}, {0,0,3}}, normals = up} } }\n"
        "local m = mesh(t)\n"
        "assert(m.bounds.max[1] == 2 and m.bounds.size[3] == 3 and #t.keys == 2)\n"
        "mesh { indices = {0, 1, 2}, keys = { {time = 0, positions = {0,0,0, 1,0,0, 0,0,1}},\n"
        "  {time = 1, positions = {0,0,0, 1,0,0, 0,5,1}} } }\n"
        "mesh { indices = {0, 1, 2}, positions = {0,0,0, 1,0,0, 0,0,1, 0,0,0, 1,0,0, 0,5,1},\n"
        "  key_times = {0, 1} }");
    const mesh_desc *m = desc_of(d, CATEGORY_SHAPE, 0);
    assert_int_equal(m->key_times_count, 2);
    assert_true(m->key_times[0] == 0.5f && m->key_times[1] == 0.75f);
    assert_int_equal(m->positions_count, 6);
    assert_int_equal(m->normals_count, 6);
    assert_int_equal(m->uvs_count, 3);
    assert_true(m->positions[1].x == 1 && m->positions[3].y == 1 && m->positions[5].z == 3);
    assert_true(m->normals[0].z == -1 && m->normals[3].z == -1);
    const mesh_desc *a = desc_of(d, CATEGORY_SHAPE, 1), *b = desc_of(d, CATEGORY_SHAPE, 2);
    assert_int_equal(a->positions_count, 6);
    assert_int_equal(b->positions_count, 6);
    assert_memory_equal(a->positions, b->positions, 6 * sizeof *a->positions);
    assert_true(a->normals_count == 0 && a->key_times[1] == b->key_times[1]);
    description_destroy(d);
}

static void programs_can_be_forbidden(void **state) {
    (void)state;
    description *d;
    import_options options = options_with(NULL, 0);
    options.allow_programs = false;
    write_file("scene.lua", "sphere {}", 9);
    assert_int_equal(description_create(&d), SNELL_OK);
    assert_int_equal(importer_lua.read("scene.lua", &options, d), SNELL_ERR_UNSUPPORTED);
    assert_int_equal(d->objects[CATEGORY_SHAPE].count, 0);
    description_destroy(d);
}

/* Whatever allocation fails, the answer is an error and nothing leaks (the sanitizers watch). */
static void too_little_memory_is_an_error(void **state) {
    (void)state;
    for (uint64_t max = 2; max < 400000; max += 2 + max / 16) {
        description *d;
        import_options options = options_with(NULL, 0);
        options.memory_max = max;
        write_file("scene.lua", "sphere {}", 9);
        assert_int_equal(description_create(&d), SNELL_OK);
        snell_status status = importer_lua.read("scene.lua", &options, d);
        if (status) assert_int_equal(status, SNELL_ERR_MEMORY);
        assert_int_equal(d->instance_count, status ? 0 : 1);
        description_destroy(d);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_programs_get_their_exact_error),
        cmocka_unit_test(deep_nesting_is_a_clean_error),
        cmocka_unit_test(bytecode_and_zero_bytes_are_refused),
        cmocka_unit_test(everything_ends_soon),
        cmocka_unit_test(memory_is_capped),
        cmocka_unit_test(shapes_are_drawn_where_they_are_made),
        cmocka_unit_test(every_registered_type_is_in_the_language),
        cmocka_unit_test(angles_are_degrees),
        cmocka_unit_test(textures_stand_where_colours_do),
        cmocka_unit_test(groups_and_instances_are_flattened),
        cmocka_unit_test(solids_are_shapes),
        cmocka_unit_test(transforms_compose_right_to_left),
        cmocka_unit_test(a_matrix_is_given_by_rows),
        cmocka_unit_test(triangles_and_meshes_are_meshes),
        cmocka_unit_test(heights_may_be_rows),
        cmocka_unit_test(a_profile_is_a_list_of_pairs),
        cmocka_unit_test(bounds_can_be_read),
        cmocka_unit_test(a_camera_can_frame_an_object),
        cmocka_unit_test(keys_that_turn_too_far_get_a_warning),
        cmocka_unit_test(motion_arrives),
        cmocka_unit_test(cameras_and_the_clock),
        cmocka_unit_test(included_things_move),
        cmocka_unit_test(settings_and_lights_arrive),
        cmocka_unit_test(parameters_are_typed_by_their_default),
        cmocka_unit_test(two_runs_give_the_same_records),
        cmocka_unit_test(tables_are_walked_in_order),
        cmocka_unit_test(values_are_shown_without_addresses),
        cmocka_unit_test(maths_is_our_own),
        cmocka_unit_test(random_numbers_are_fixed),
        cmocka_unit_test(pcall_catches_what_is_not_final),
        cmocka_unit_test(what_reflects_more_than_it_gets_is_warned_of),
        cmocka_unit_test(included_scenes_add_everything),
        cmocka_unit_test(errors_in_other_files_name_them),
        cmocka_unit_test(images_are_read),
        cmocka_unit_test(normals_that_are_colors_are_warned_of),
        cmocka_unit_test(heights_are_a_list_a_function_or_a_picture),
        cmocka_unit_test(keys_of_meshes_arrive),
        cmocka_unit_test(programs_can_be_forbidden),
        cmocka_unit_test(too_little_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
