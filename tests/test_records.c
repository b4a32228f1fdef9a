/* The flat block: a description goes through it unchanged, and no block, however broken, does
 * harm. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "cameras/camera.h"
#include "geometry/mesh.h"
#include "scene/records.h"
#include "scene/settings.h"

typedef struct block {
    unsigned char *data;
    size_t size, capacity;
} block;

static bool append(void *user, const void *data, size_t size) {
    block *b = user;
    if (!array_grow((void **)&b->data, 1, b->size, &b->capacity, size)) return false;
    memcpy(b->data + b->size, data, size);
    b->size += size;
    return true;
}

static block to_block(const description *d) {
    block b = {0};
    assert_int_equal(records_write(d, append, &b), SNELL_OK);
    return b;
}

static void add(description *d, category which, const char *type, const char *name, uint32_t line,
                const snell_param *params, size_t count) {
    snell_status status = description_add(d, which, type, params, count,
                                          (object_source){name, "scene.lua", line}, NULL);
    if (status) print_error("%s: %s\n", type, error_last()->text);
    assert_int_equal(status, SNELL_OK);
}

static snell_param array(const char *name, const void *data, size_t count) {
    return (snell_param){.name = name, .kind = SNELL_PARAM_ARRAY, .value.array = {data, count}};
}

static snell_param integer(const char *name, int64_t value) {
    return (snell_param){.name = name, .kind = SNELL_PARAM_INT, .value.i = value};
}

static void add_mesh(description *d) {
    const snell_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3}, slots[] = {1, 0};
    const snell_vec2 uvs[] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    const uint8_t alphas[] = {255, 128, 3, 0};
    const snell_material_id materials[] = {{1, 0}, {3, 0}};
    snell_param params[] = {array("positions", positions, 4),
                            array("normals", positions, 4),
                            array("colors", positions, 4),
                            array("indices", indices, 6),
                            array("uvs", uvs, 4),
                            array("alphas", alphas, 4),
                            array("material_slots", slots, 2),
                            array("materials", materials, 2)};
    add(d, CATEGORY_SHAPE, "mesh", "a mesh", 12, params, 8);
}

static void add_image(description *d) {
    const uint8_t pixels[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18};
    snell_param params[] = {
        integer("width", 3),
        integer("height", 2),
        {.name = "format", .kind = SNELL_PARAM_STRING, .value.s = "rgb8"},
        {.name = "wrap_u", .kind = SNELL_PARAM_STRING, .value.s = "mirror"},
        array("pixels", pixels, 18),
    };
    add(d, CATEGORY_TEXTURE, "image", "wood.png", 3, params, 5);
}

/* One of every type that has no required fields, and more by hand. */
static description *everything(void) {
    description *d;
    assert_int_equal(description_create(&d), SNELL_OK);
    add_image(d);
    snell_param color = {.name = "color", .kind = SNELL_PARAM_TEXTURE, .value.texture = {1, 0}};
    snell_param two_sided = {.name = "emit_two_sided", .kind = SNELL_PARAM_BOOL, .value.b = true};
    snell_param base = {.name = "base", .kind = SNELL_PARAM_MATERIAL, .value.material = {1, 0}};
    add(d, CATEGORY_MATERIAL, "lambert", "wood", 5, &color, 1);
    add(d, CATEGORY_MATERIAL, "dielectric", "", 6, &two_sided, 1);
    add(d, CATEGORY_MATERIAL, "glazed", "varnish", 7, &base, 1);
    add_mesh(d);
    const type_info *type;
    for (uint32_t i = 0; (type = type_at(i)) != NULL; i++) {
        char name[32];
        snprintf(name, sizeof name, "any %u", i);
        description_add(d, type->category, type->name, NULL, 0,
                        (object_source){name, NULL, 100 + i}, NULL);
    }
    assert_true(d->objects[CATEGORY_SETTING].count == 4 && d->objects[CATEGORY_SHAPE].count >= 4);
    transform moved = transform_identity();
    moved.m[0][3] = 4;
    const motion_key keys[] = {{0.5f, transform_identity()}, {0.75f, moved}};
    const snell_param path = array("motion", keys, 2);
    add(d, CATEGORY_CAMERA, "fisheye", "moving", 10, &path, 1);
    assert_int_equal(
        description_add_instance(d, 0, 2, &moved, (object_source){"here", NULL, 8}, NULL),
        SNELL_OK);
    assert_int_equal(description_add_instance(d, 1, NO_MATERIAL, NULL, (object_source){0}, NULL),
                     SNELL_OK);
    assert_int_equal(description_set_motion(d, 1, keys, 2), SNELL_OK);
    description_add_param(d, "depth", "number", "5", "4", "levels of spheres");
    description_add_message(d, SNELL_WARNING, "scene.lua", 9, "do this", "something odd");
    strcpy(d->format, "lua");
    d->is_model = true;
    return d;
}

static void a_description_comes_through_unchanged(void **state) {
    (void)state;
    description *d = everything(), *copy;
    block first = to_block(d);
    assert_int_equal(description_create(&copy), SNELL_OK);
    snell_status status = records_read(first.data, first.size, copy);
    if (status) print_error("%s\n", error_last()->text);
    assert_int_equal(status, SNELL_OK);
    const mesh_desc *mesh = copy->objects[CATEGORY_SHAPE].items[0].desc;
    assert_true(mesh->positions[3].z == 1 && mesh->alphas_count == 4 &&
                ((const uint8_t *)mesh->alphas)[1] == 128 && mesh->materials[1].index1 == 3);
    assert_string_equal(copy->objects[CATEGORY_SHAPE].items[0].name, "a mesh");
    assert_int_equal(copy->objects[CATEGORY_SHAPE].items[0].line, 12);
    assert_true(copy->instances[0].to_world.m[0][3] == 4 && copy->instances[0].material == 2);
    const camera_common *camera = description_find(copy, CATEGORY_CAMERA, "moving")->desc;
    assert_true(camera->motion_count == 2 && camera->motion[1].time == 0.75f);
    assert_true(copy->instances[1].key_count == 2 && copy->instances[0].key_count == 0 &&
                copy->instances[1].keys[1].transform.m[0][3] == 4);
    assert_string_equal(copy->params[0].help, "levels of spheres");
    assert_string_equal(copy->messages[0].hint, "do this");
    assert_string_equal(copy->format, "lua");
    assert_true(copy->is_model);
    block second = to_block(copy);
    assert_int_equal(first.size, second.size);
    assert_memory_equal(first.data, second.data, first.size);
    free(first.data);
    free(second.data);
    description_destroy(d);
    description_destroy(copy);
}

static void a_second_block_is_added_behind_the_first(void **state) {
    (void)state;
    description *d = everything(), *both;
    block b = to_block(d);
    assert_int_equal(description_create(&both), SNELL_OK);
    assert_int_equal(records_read(b.data, b.size, both), SNELL_OK);
    assert_int_equal(records_read(b.data, b.size, both), SNELL_OK);
    size_t shapes = d->objects[CATEGORY_SHAPE].count,
           materials = d->objects[CATEGORY_MATERIAL].count,
           textures = d->objects[CATEGORY_TEXTURE].count;
    assert_int_equal(both->objects[CATEGORY_SHAPE].count, 2 * shapes);
    assert_int_equal(both->objects[CATEGORY_SETTING].count, 4);
    const object *mesh = &both->objects[CATEGORY_SHAPE].items[shapes];
    assert_string_equal(mesh->name, "a mesh.2");
    assert_int_equal(((const mesh_desc *)mesh->desc)->materials[1].index1, 3 + materials);
    assert_int_equal(both->instances[2].shape, shapes);
    assert_int_equal(both->instances[2].material, 2 + materials);
    const object *wood = description_find(both, CATEGORY_MATERIAL, "wood.2");
    assert_non_null(wood);
    snell_input color;
    memcpy(&color, (const char *)wood->desc + type_find_field(wood->type, "color")->offset,
           sizeof color);
    assert_int_equal(color.texture.index1, 1 + textures);
    free(b.data);
    description_destroy(d);
    description_destroy(both);
}

static uint64_t next_random(uint64_t *state) { /* splitmix64 (Vigna) */
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* Bytes, words, sizes and lengths are what a block consists of: change some of each. */
static size_t mutate(unsigned char *data, size_t size, uint64_t *seed) {
    static const uint64_t odd[] = {
        0,          1,          7,          UINT32_MAX, UINT64_MAX, UINT32_MAX - 1u,
        1ull << 63, 1ull << 32, 0x7fc00000, 0xff800000};
    uint64_t changes = 1 + next_random(seed) % 3;
    for (uint64_t i = 0; i < changes; i++) {
        uint64_t kind = next_random(seed) % 6, value = odd[next_random(seed) % 10];
        size_t at = (size_t)(next_random(seed) % size);
        if (kind == 0) data[at] = (unsigned char)next_random(seed);
        if (kind == 1) data[at] ^= (unsigned char)(1u << (next_random(seed) % 8));
        if (kind == 2) memcpy(data + (at & ~(size_t)7), &value, 8);
        if (kind == 3 && at + 4 <= size) memcpy(data + (at & ~(size_t)3), &value, 4);
        if (kind == 4) data[at & ~(size_t)3] = (unsigned char)(next_random(seed) % 9);
        if (kind == 5 && i == 0 && next_random(seed) % 4 == 0) {
            size = at & ~(size_t)7; /* cut, with a header that agrees */
            if (size < 56) return size;
            uint64_t told = size;
            memcpy(data + 16, &told, 8);
        }
    }
    return size;
}

static bool same_mark(const description *d, const description_mark *mark) {
    description_mark now = description_get_mark(d);
    return memcmp(&now, mark, sizeof now) == 0;
}

static void broken_blocks_do_no_harm(void **state) {
    (void)state;
    description *source = everything();
    block b = to_block(source);
    unsigned char *mutant = malloc(b.size);
    assert_non_null(mutant);
    size_t peak = memory_peak();
    uint64_t seed = 1;
    int accepted = 0, refused = 0;
    for (int i = 0; i < 50000; i++) {
        memcpy(mutant, b.data, b.size);
        size_t size = mutate(mutant, b.size, &seed);
        description *d;
        assert_int_equal(description_create(&d), SNELL_OK);
        if (i % 2) assert_int_equal(records_read(b.data, b.size, d), SNELL_OK);
        description_mark mark = description_get_mark(d);
        /* A heap copy of its exact size lets the address sanitizer see any byte read beyond. */
        unsigned char *exact = malloc(size ? size : 1);
        assert_non_null(exact);
        memcpy(exact, mutant, size);
        snell_status status = records_read(exact, size, d);
        free(exact);
        assert_true(status == SNELL_OK || status == SNELL_ERR_SYNTAX);
        if (status) {
            refused++;
            assert_true(same_mark(d, &mark));
            assert_true(error_last()->text[0] != '\0');
        } else {
            accepted++;
            block again = to_block(d); /* what was accepted is whole */
            free(again.data);
        }
        description_destroy(d);
    }
    print_message("%d accepted, %d refused\n", accepted, refused);
    assert_true(accepted > 100 && refused > 10000);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    assert_true(memory_peak() - peak < (size_t)64 << 20);
#else
    (void)peak; /* sanitizers keep freed memory aside */
#endif
    free(mutant);
    free(b.data);
    description_destroy(source);
}

static void every_cut_is_refused(void **state) {
    (void)state;
    description *source = everything(), *d;
    block b = to_block(source);
    assert_int_equal(description_create(&d), SNELL_OK);
    for (size_t size = 0; size < b.size; size++) {
        unsigned char *exact = malloc(size ? size : 1);
        assert_non_null(exact);
        memcpy(exact, b.data, size);
        assert_int_equal(records_read(exact, size, d), SNELL_ERR_SYNTAX);
        free(exact);
    }
    assert_int_equal(d->objects[CATEGORY_SHAPE].count, 0);
    free(b.data);
    description_destroy(source);
    description_destroy(d);
}

static bool refuse(void *user, const void *data, size_t size) {
    (void)data;
    size_t *room = user;
    if (size > *room) return false;
    *room -= size;
    return true;
}

static void a_full_target_is_an_error(void **state) {
    (void)state;
    description *d = everything();
    size_t room = 300;
    assert_int_equal(records_write(d, refuse, &room), SNELL_ERR_IO);
    description_destroy(d);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_description_comes_through_unchanged),
        cmocka_unit_test(a_second_block_is_added_behind_the_first),
        cmocka_unit_test(every_cut_is_refused),
        cmocka_unit_test(broken_blocks_do_no_harm),
        cmocka_unit_test(a_full_target_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
