/* The scene description: types by name, defaults, checks, references, names, settings. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <string.h>

#include "geometry/mesh.h"
#include "image/tonemap.h"
#include "scene/description.h"
#include "scene/settings.h"

static const object_source nowhere = {NULL, NULL, 0};

static int set_up(void **state) {
    description *d;
    if (description_create(&d)) return -1;
    *state = d;
    return 0;
}

static int tear_down(void **state) {
    description_destroy(*state);
    return 0;
}

static uint32_t add_ok(description *d, category which, const char *type, const snell_param *params,
                       size_t count, const char *name) {
    uint32_t index = 77;
    snell_status status = description_add(d, which, type, params, count,
                                          (object_source){name, "test.lua", 3}, &index);
    if (status) print_error("%s: %s\n", type, error_last()->text);
    assert_int_equal(status, SNELL_OK);
    return index;
}

static void types_are_found_by_name(void **state) {
    description *d = *state;
    assert_non_null(type_find(CATEGORY_SHAPE, "sphere"));
    assert_non_null(type_find(CATEGORY_SETTING, "render"));
    assert_null(type_find(CATEGORY_SHAPE, "lambert"));
    assert_int_equal(description_add(d, CATEGORY_MATERIAL, "lambret", NULL, 0, nowhere, NULL),
                     SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "unknown material 'lambret'");
    assert_string_equal(error_last()->hint, "did you mean 'lambert'?");
    uint32_t count = 0;
    int seen[CATEGORY_COUNT] = {0};
    for (; type_at(count); count++) {
        assert_ptr_equal(type_find(type_at(count)->category, type_at(count)->name), type_at(count));
        seen[type_at(count)->category]++;
    }
    for (int c = 0; c < CATEGORY_COUNT; c++) assert_true(seen[c] > 0);
}

static void objects_are_numbered_and_keep_their_source(void **state) {
    description *d = *state;
    snell_param radius = {.name = "radius", .kind = SNELL_PARAM_FLOAT, .value.f = 2};
    assert_int_equal(add_ok(d, CATEGORY_SHAPE, "sphere", &radius, 1, NULL), 0);
    assert_int_equal(add_ok(d, CATEGORY_SHAPE, "sphere", NULL, 0, "ball"), 1);
    assert_int_equal(d->objects[CATEGORY_SHAPE].count, 2);
    char label[64];
    description_object_label(d, CATEGORY_SHAPE, 0, label, sizeof label);
    assert_string_equal(label, "sphere:3");
    description_object_label(d, CATEGORY_SHAPE, 1, label, sizeof label);
    assert_string_equal(label, "ball");
    assert_string_equal(d->objects[CATEGORY_SHAPE].items[1].file, "test.lua");
    assert_ptr_equal(description_find(d, CATEGORY_SHAPE, "ball"),
                     &d->objects[CATEGORY_SHAPE].items[1]);
    assert_null(description_find(d, CATEGORY_MATERIAL, "ball"));
}

static void names_are_unique_in_a_category(void **state) {
    description *d = *state;
    char name[32];
    for (int i = 0; i < 1000; i++) {
        snprintf(name, sizeof name, "ball %d", i);
        add_ok(d, CATEGORY_SHAPE, "sphere", NULL, 0, name);
    }
    for (int i = 0; i < 1000; i++) {
        snprintf(name, sizeof name, "ball %d", i);
        assert_ptr_equal(description_find(d, CATEGORY_SHAPE, name),
                         &d->objects[CATEGORY_SHAPE].items[i]);
    }
    assert_int_equal(description_add(d, CATEGORY_SHAPE, "plane", NULL, 0,
                                     (object_source){"ball 7", NULL, 0}, NULL),
                     SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "there is already a shape named 'ball 7'");
    add_ok(d, CATEGORY_MATERIAL, "lambert", NULL, 0, "ball 7");
}

static void faults_are_refused_and_leave_nothing(void **state) {
    description *d = *state;
    snell_param params[] = {{.name = "radius", .kind = SNELL_PARAM_FLOAT, .value.f = -1},
                            {.name = "radus", .kind = SNELL_PARAM_FLOAT, .value.f = 1},
                            {.name = "radius", .kind = SNELL_PARAM_FLOAT, .value.f = (double)NAN}};
    for (int i = 0; i < 3; i++)
        assert_int_equal(description_add(d, CATEGORY_SHAPE, "sphere", &params[i], 1, nowhere, NULL),
                         SNELL_ERR_ARGUMENT);
    snell_param twice[] = {{.name = "radius", .kind = SNELL_PARAM_FLOAT, .value.f = 1},
                           {.name = "radius", .kind = SNELL_PARAM_FLOAT, .value.f = 2}};
    assert_int_equal(description_add(d, CATEGORY_SHAPE, "sphere", twice, 2, nowhere, NULL),
                     SNELL_ERR_ARGUMENT);
    assert_int_equal(description_add(d, CATEGORY_SHAPE, "mesh", NULL, 0, nowhere, NULL),
                     SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "mesh: 'positions' is missing");
    assert_int_equal(d->objects[CATEGORY_SHAPE].count, 0);
}

static bool name_in(const char *side, size_t length, const char *name) {
    for (size_t at = 0; at < length; at += strcspn(side + at, " |;") + 1)
        if (strcspn(side + at, " |;") == strlen(name) &&
            strncmp(side + at, name, strlen(name)) == 0)
            return true;
    return false;
}

/* Which side of which choice a field is on: 10 times the choice, and the side; -1 none. */
static int side_of(const char *either, const char *name) {
    int choice = 0, side = 0;
    for (const char *at = either;;) {
        size_t length = strcspn(at, "|;");
        if (name_in(at, length, name)) return 10 * choice + side;
        if (at[length] == '\0') return -1;
        if (at[length] == ';') choice++, side = 0;
        if (at[length] == '|') side++;
        at += length + 1;
    }
}

/* Two ways to say one thing were taken silently, and one of them did nothing. */
static void only_one_of_two_ways(void **state) {
    (void)state;
    int refused = 0, taken = 0;
    const type_info *info;
    for (uint32_t t = 0; (info = type_at(t)) != NULL; t++) {
        uint32_t known = 0;
        for (uint32_t i = 0; i < info->field_count; i++) {
            const field *f = &info->fields[i];
            if (strncmp(f->help, "instead of ", 11) == 0 &&
                (!info->either || side_of(info->either, f->name) < 0))
                fail_msg("%s.%s: TYPE_INFO_EITHER does not know what it stands for", info->name,
                         f->name);
            if (info->either) known += side_of(info->either, f->name) >= 0;
        }
        if (!info->either) continue;
        uint32_t words = 1;
        for (const char *c = info->either; *c; c++) words += strchr(" |;", *c) != NULL;
        assert_int_equal(known, words); /* each is a field */
        for (uint32_t i = 0; i < info->field_count; i++)
            for (uint32_t k = i + 1; k < info->field_count; k++) {
                int one = side_of(info->either, info->fields[i].name),
                    other = side_of(info->either, info->fields[k].name);
                _Alignas(16) unsigned char desc[1024];
                bool given[64] = {false};
                assert_true(info->desc_size <= sizeof desc && info->field_count <= 64);
                desc_init(info, desc);
                for (uint32_t m = 0; m < info->field_count; m++)
                    given[m] = m == i || m == k || info->fields[m].flags & FIELD_REQUIRED;
                bool clash = one >= 0 && other >= 0 && one / 10 == other / 10 && one != other;
                assert_int_equal(desc_check(info, desc, given),
                                 clash ? SNELL_ERR_ARGUMENT : SNELL_OK);
                (clash ? refused++ : taken++);
                if (!clash) continue;
                assert_non_null(strstr(error_last()->text, info->fields[i].name));
                assert_non_null(strstr(error_last()->text, info->fields[k].name));
            }
    }
    assert_true(refused >= 20 && taken > refused);
}

static void references_must_exist(void **state) {
    description *d = *state;
    snell_param color = {.name = "color", .kind = SNELL_PARAM_TEXTURE, .value.texture = {1, 0}};
    assert_int_equal(description_add(d, CATEGORY_MATERIAL, "lambert", &color, 1, nowhere, NULL),
                     SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "lambert: 'color' names a texture that does not exist");
    add_ok(d, CATEGORY_TEXTURE, "checker", NULL, 0, NULL);
    add_ok(d, CATEGORY_MATERIAL, "lambert", &color, 1, NULL);
    color.value.texture.generation = 1;
    assert_int_equal(description_add(d, CATEGORY_MATERIAL, "lambert", &color, 1, nowhere, NULL),
                     SNELL_ERR_ARGUMENT);
    color.value.texture = (snell_texture_id){2, 0};
    assert_int_equal(description_add(d, CATEGORY_MATERIAL, "lambert", &color, 1, nowhere, NULL),
                     SNELL_ERR_ARGUMENT);
}

static void a_glaze_lies_on_a_plain_material(void **state) {
    description *d = *state;
    add_ok(d, CATEGORY_MATERIAL, "lambert", NULL, 0, NULL);
    add_ok(d, CATEGORY_MATERIAL, "dielectric", NULL, 0, NULL);
    snell_param base = {.name = "base", .kind = SNELL_PARAM_MATERIAL, .value.material = {1, 0}};
    assert_int_equal(add_ok(d, CATEGORY_MATERIAL, "glazed", &base, 1, NULL), 2);
    uint32_t refused[] = {0, 2, 3, 4, UINT32_MAX}; /* none, glass, a glaze, itself, nothing */
    for (size_t i = 0; i < 5; i++) {
        base.value.material.index1 = refused[i];
        assert_int_equal(description_add(d, CATEGORY_MATERIAL, "glazed", &base, 1, nowhere, NULL),
                         SNELL_ERR_ARGUMENT);
    }
    assert_int_equal(description_add(d, CATEGORY_MATERIAL, "glazed", NULL, 0, nowhere, NULL),
                     SNELL_ERR_ARGUMENT);
}

static void settings_come_once(void **state) {
    description *d = *state;
    assert_null(description_setting(d, "render"));
    snell_param width = {.name = "width", .kind = SNELL_PARAM_INT, .value.i = 320};
    add_ok(d, CATEGORY_SETTING, "render", &width, 1, NULL);
    const render_desc *render = description_setting(d, "render")->desc;
    assert_int_equal(render->width, 320);
    assert_int_equal(render->max_depth, -1);
    assert_int_equal(description_add(d, CATEGORY_SETTING, "render", NULL, 0, nowhere, NULL),
                     SNELL_ERR_ARGUMENT);
    add_ok(d, CATEGORY_SETTING, "ambient", NULL, 0, NULL);
}

static void structs_of_older_callers_take_defaults(void **state) {
    description *d = *state;
    render_desc render;
    desc_init(&setting_render, &render);
    render.width = 100;
    render.samples = 5;
    render.struct_size = offsetof(render_desc, samples) + 2; /* half a field is no field */
    assert_int_equal(description_add_desc(d, &setting_render, &render, nowhere, NULL), SNELL_OK);
    const render_desc *kept = description_setting(d, "render")->desc;
    assert_int_equal(kept->struct_size, sizeof *kept);
    assert_int_equal(kept->width, 100);
    assert_int_equal(kept->samples, 0);
    assert_int_equal(kept->max_depth, -1);
    background_desc background;
    desc_init(&setting_background, &background);
    background.struct_size = sizeof background + 8;
    assert_int_equal(description_add_desc(d, &setting_background, &background, nowhere, NULL),
                     SNELL_ERR_VERSION);
    background.struct_size = 0;
    assert_int_equal(description_add_desc(d, &setting_background, &background, nowhere, NULL),
                     SNELL_ERR_ARGUMENT);
}

static uint32_t add_triangle(description *d, const snell_material_id *materials, size_t count) {
    const type_info *type = type_find(CATEGORY_SHAPE, "mesh");
    const snell_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const uint32_t indices[] = {0, 1, 2};
    mesh_desc mesh;
    desc_init(type, &mesh);
    mesh.positions = positions;
    mesh.positions_count = 3;
    mesh.indices = indices;
    mesh.indices_count = 3;
    mesh.materials = materials;
    mesh.materials_count = count;
    uint32_t index = UINT32_MAX;
    if (description_add_desc(d, type, &mesh, nowhere, &index)) return UINT32_MAX;
    return index;
}

static void arrays_are_copied_and_checked(void **state) {
    description *d = *state;
    snell_material_id materials[] = {{1, 0}, {2, 0}};
    assert_int_equal(add_triangle(d, NULL, 0), 0);
    assert_int_equal(add_triangle(d, materials, 1), UINT32_MAX);
    assert_int_equal(add_triangle(d, NULL, 1), UINT32_MAX); /* a count without an array */
    add_ok(d, CATEGORY_MATERIAL, "lambert", NULL, 0, NULL);
    assert_int_equal(add_triangle(d, materials, 1), 1);
    assert_int_equal(add_triangle(d, materials, 2), UINT32_MAX);
    const mesh_desc *kept = d->objects[CATEGORY_SHAPE].items[1].desc;
    assert_true(kept->materials != materials && kept->materials[0].index1 == 1);
    assert_true(kept->positions[1].x == 1 && kept->indices[2] == 2);
}

static void instances_stand_on_what_exists(void **state) {
    description *d = *state;
    uint32_t index;
    assert_int_equal(description_add_instance(d, 0, NO_MATERIAL, NULL, nowhere, &index),
                     SNELL_ERR_ARGUMENT);
    add_ok(d, CATEGORY_SHAPE, "sphere", NULL, 0, NULL);
    assert_int_equal(description_add_instance(d, 0, NO_MATERIAL, NULL, nowhere, &index), SNELL_OK);
    assert_int_equal(index, 0);
    assert_int_equal(description_add_instance(d, 0, 0, NULL, nowhere, &index), SNELL_ERR_ARGUMENT);
    transform flat = transform_identity();
    flat.m[1][1] = 0;
    assert_int_equal(description_add_instance(d, 0, NO_MATERIAL, &flat, nowhere, &index),
                     SNELL_ERR_ARGUMENT);
    flat.m[1][1] = NAN;
    assert_int_equal(description_add_instance(d, 0, NO_MATERIAL, &flat, nowhere, &index),
                     SNELL_ERR_ARGUMENT);
    assert_int_equal(d->instance_count, 1);
}

static void messages_are_kept_once_and_capped(void **state) {
    description *d = *state;
    for (int i = 0; i < 1000; i++)
        assert_int_equal(
            description_add_message(d, SNELL_WARNING, "a.gltf", 0, NULL, "number %d", i / 2),
            SNELL_OK);
    assert_int_equal(d->message_count, 200);
    assert_string_equal(d->messages[199].text, "number 199");
}

static void rewinding_takes_out_what_came_later(void **state) {
    description *d = *state;
    add_ok(d, CATEGORY_SHAPE, "sphere", NULL, 0, "first");
    description_mark mark = description_get_mark(d);
    add_ok(d, CATEGORY_SHAPE, "sphere", NULL, 0, "second");
    add_ok(d, CATEGORY_SETTING, "ambient", NULL, 0, NULL);
    assert_int_equal(description_add_instance(d, 1, NO_MATERIAL, NULL, nowhere, NULL), SNELL_OK);
    assert_int_equal(description_add_param(d, "depth", "number", "4", "4", NULL), SNELL_OK);
    description_add_message(d, SNELL_INFO, NULL, 0, NULL, "a note");
    description_rewind(d, &mark);
    description_mark after = description_get_mark(d);
    assert_memory_equal(&mark, &after, sizeof mark);
    assert_non_null(description_find(d, CATEGORY_SHAPE, "first"));
    assert_null(description_find(d, CATEGORY_SHAPE, "second"));
    assert_null(description_setting(d, "ambient"));
    add_ok(d, CATEGORY_SHAPE, "sphere", NULL, 0, "second");
}

#define FRESH(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

/* The scene language's words for tone maps are those of the registry. */
static void tone_maps_have_one_list_of_names(void **state) {
    (void)state;
    size_t count = 0;
    for (; tonemaps[count]; count++)
        assert_true(choice_find(TONEMAP_CHOICES, tonemaps[count]->name) == (int)count + 1);
    char word[32];
    choice_word(TONEMAP_CHOICES, (int)count + 1, word, sizeof word);
    assert_string_equal(word, ""); /* and no more */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        FRESH(types_are_found_by_name),
        FRESH(tone_maps_have_one_list_of_names),
        FRESH(objects_are_numbered_and_keep_their_source),
        FRESH(names_are_unique_in_a_category),
        FRESH(faults_are_refused_and_leave_nothing),
        FRESH(only_one_of_two_ways),
        FRESH(references_must_exist),
        FRESH(a_glaze_lies_on_a_plain_material),
        FRESH(settings_come_once),
        FRESH(structs_of_older_callers_take_defaults),
        FRESH(arrays_are_copied_and_checked),
        FRESH(instances_stand_on_what_exists),
        FRESH(messages_are_kept_once_and_capped),
        FRESH(rewinding_takes_out_what_came_later),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
