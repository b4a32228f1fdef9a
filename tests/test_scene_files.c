/* What scenes are saved as: compiled scenes, which come back as they were and of which no broken one does harm, and
 * programs in Lua, in which every number is kept. */
#include <string.h>
#include <unistd.h>

#include "render_test.h"

#include "api/api.h"
#include "base/memory.h"
#include "compiled_fix.h"
#include "cpu_time.h"
#include "mutants.h"
#include "scene/records.h"

static rig bench;
static char path[3][300]; /* a program, a compiled scene, another */

static int start(void **state) {
    (void)state;
    static const char *const ends[] = {"lua", "snell", "other.snell"};
    const char *folder = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : TEST_BINARY_DIR;
    for (int i = 0; i < 3; i++)
        snprintf(path[i], sizeof path[i], "%s/snell_test_scene_%d.%s", folder, (int)getpid(),
                 ends[i]);
    bench = rig_make(1, SNELL_ISA_AUTO);
    return 0;
}

static int stop(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++) unlink(path[i]);
    rig_free(&bench);
    return 0;
}

static void put_file(const char *to, const void *data, size_t size) {
    FILE *file = fopen(to, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static uint8_t *get_file(const char *from, size_t *size) {
    static uint8_t buffer[1 << 20];
    FILE *file = fopen(from, "rb");
    assert_non_null(file);
    *size = fread(buffer, 1, sizeof buffer, file);
    fclose(file);
    assert_true(*size > 0 && *size < sizeof buffer);
    return buffer;
}

static const char program[] =
    "render { width = 16, height = 12, samples = 1 }\n"
    "animation { fps = 10, first = 3, last = 9 }\n"
    "camera { name = 'main', from = {0, 1, 5}, at = {0, 0, 0}, motion = function(t) return "
    "transform.translate{t, 0, 0} end }\n"
    "camera { name = 'other', kind = 'fisheye', from = {0, 1, 5}, at = {0, 0, 0} }\n"
    "background { color = 0.2 } ambient { color = 0.1 }\n"
    "local wood = texture.checker { {1, .5, .2}, 0.3, size = 0.3, name = 'wood' }\n"
    "local matte = material.lambert { color = wood * 0.5, name = 'matte' }\n"
    "local glass = material.dielectric { ior = 1.5, absorption = {1, 2, 3} }\n"
    "local coat = material.glazed { base = matte, ior = 1.4 }\n"
    "local a, b = sphere { radius = 0.5, material = glass, name = 'ball' }, box { min = {0,0,0}, "
    "max = {1,1,1} }\n"
    "local pair = group { shared = true, a, instance { b, transform = transform.scale(0.3), "
    "material = coat } }\n"
    "instance { pair } instance { pair, transform = transform.translate{1, 0, 0} * "
    "transform.rotate{axis = {1,2,3}, "
    "angle = 20}, motion = function(t) return transform.translate{0, t, 0} end }\n"
    "difference { sphere { radius = 0.4 }, cylinder { from = {0,-1,0}, to = {0,1,0}, radius = 0.2 "
    "}, material = matte, "
    "transform = transform.translate{-1, 0, 0} }\n"
    "mesh { positions = {{0,0,0},{1,0,0},{0,1,0},{0,0,1}}, indices = {0,1,2, 0,2,3}, "
    "material_slots = {0,1}, "
    "materials = {matte, glass}, alphas = {255, 128, 3, 0}, uvs = {{0,0},{1,0},{0,1},{1,1}} }\n"
    "plane { point = {0, -1, 0}, normal = {0.1, 1, 0.3}, material = matte }\n"
    "light.spot { position = {1, 3, 2}, at = {0, 0, 0}, intensity = 40, cone = 33.3, blend = 7 }\n"
    "light.directional { direction = {-1, -2.3, -0.7}, irradiance = {1, 2, 3} }\n"
    "local depth = param('depth', 4, 'levels')\n";

static snell_load_desc with_next_frame(void) {
    snell_load_desc desc = SNELL_INIT(load_desc);
    desc.next_frame = true;
    return desc;
}

static uint64_t hash(void) {
    uint64_t value;
    MUST(snell_scene_hash(bench.scene, &value));
    return value;
}

/* Loads the program and compiles it; the program's hash. */
static uint64_t compile(void) {
    snell_load_desc desc = with_next_frame();
    put_file(path[0], program, sizeof program - 1);
    rig_clear(&bench);
    MUST(snell_scene_load(bench.scene, path[0], &desc));
    MUST(snell_scene_save(bench.scene, path[1]));
    return hash();
}

static void render(float *out) {
    snell_render_desc desc = {.struct_size = sizeof desc};
    uint32_t width, height, channels;
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    MUST(snell_scene_settings(bench.scene, 0, &desc));
    MUST(snell_render(bench.scene, &desc, bench.film));
    const float *pixels = snell_film_pixels(bench.film, &width, &height, &channels);
    assert_int_equal(width * height * channels, 16 * 12 * 3);
    memcpy(out, pixels, 16 * 12 * 3 * sizeof *out);
}

/* Those that are not of the machine. */
static size_t count_messages(const description *d) {
    size_t count = 0;
    for (size_t i = 0; i < d->message_count; i++) count += d->messages[i].file[0] != '\0';
    return count;
}

static void a_compiled_scene_is_what_it_was(void **state) {
    (void)state;
    static float before[16 * 12 * 3], after[16 * 12 * 3];
    uint64_t of_program = compile();
    render(before);
    const description *d = bench.scene->description;
    size_t names = d->objects[CATEGORY_SHAPE].name_count, messages = count_messages(d);
    rig_clear(&bench);
    MUST(snell_scene_load(bench.scene, path[1], NULL));
    d = bench.scene->description;
    assert_true(hash() == of_program);
    assert_string_equal(d->format, "snell");
    assert_true(d->objects[CATEGORY_SHAPE].name_count == names && count_messages(d) == messages);
    assert_int_equal(d->param_count, 0);
    assert_int_equal(d->objects[CATEGORY_SHAPE].items[0].line, 10);
    render(after);
    assert_memory_equal(before, after, sizeof before);
    /* It holds the next frame, compiles to the same bytes, and needs no helper. */
    snell_load_desc desc = with_next_frame();
    desc.allow_helper = false;
    rig_clear(&bench);
    MUST(snell_scene_load(bench.scene, path[1], &desc));
    MUST(snell_scene_save(bench.scene, path[2]));
    size_t first, second;
    uint8_t *data = get_file(path[1], &first), *copy = malloc(first);
    assert_non_null(copy);
    memcpy(copy, data, first);
    data = get_file(path[2], &second);
    assert_true(first == second && memcmp(copy, data, first) == 0);
    free(copy);
}

static void refuses(snell_status status, const char *text, const char *hint,
                    const snell_load_desc *desc) {
    rig_clear(&bench);
    snell_status got = snell_scene_load(bench.scene, path[1], desc);
    const snell_message *e = snell_last_error();
    if (got != status || !strstr(e->text, text) || !strstr(e->hint, hint))
        print_error("got %d: %s (%s)\n", got, e->text, e->hint);
    assert_int_equal(got, status);
    assert_non_null(strstr(e->text, text));
    assert_non_null(strstr(e->hint, hint));
    assert_non_null(strstr(e->file, path[1]));
    assert_int_equal(bench.scene->description->instance_count, 0);
}

static void what_was_settled_is_not_asked_again(void **state) {
    (void)state;
    compile();
    const char *params[] = {"depth=5"};
    snell_load_desc desc = SNELL_INIT(load_desc);
    desc.params = params;
    desc.param_count = 1;
    refuses(SNELL_ERR_ARGUMENT, "takes no values", "snell convert", &desc);
    desc = SNELL_INIT(load_desc);
    desc.frame = 4;
    refuses(SNELL_ERR_ARGUMENT, "is of frame 3 alone", "snell convert", &desc);
    desc.frame = 3;
    rig_clear(&bench);
    MUST(snell_scene_load(bench.scene, path[1], &desc));
    desc = SNELL_INIT(load_desc);
    desc.up = "z";
    refuses(SNELL_ERR_ARGUMENT, "--up", "snell convert", &desc);
    /* Without the next frame it has no motion vectors. */
    rig_clear(&bench);
    MUST(snell_scene_load(bench.scene, path[0], NULL));
    MUST(snell_scene_save(bench.scene, path[1]));
    desc = with_next_frame();
    refuses(SNELL_ERR_UNSUPPORTED, "motion vectors", "render the file", &desc);
}

enum { TYPES = COMPILED_HEADER_SIZE + 24 }; /* the types' hash, in the records' own header */

static void another_version_says_what_to_do(void **state) {
    (void)state;
    static const char again[] = "write it again: snell convert snell_test_scene_";
    size_t size;
    compile();
    uint8_t *file = get_file(path[1], &size), *copy = malloc(size);
    assert_non_null(copy);
    memcpy(copy, file, size);
    file[COMPILED_VERSION] = 7;
    memcpy(file + COMPILED_WRITER, "9.8.7", 6);
    put_file(path[1], file, size);
    refuses(SNELL_ERR_UNSUPPORTED, "made by snell 9.8.7; this is " SNELL_VERSION_STRING, again,
            NULL);
    memcpy(file, copy, size);
    file[TYPES] ^= 1; /* another build's types */
    compiled_fix(file, size);
    put_file(path[1], file, size);
    refuses(SNELL_ERR_UNSUPPORTED, "of another build", again, NULL);
    memcpy(file, copy, size);
    for (int i = 0; i < 4; i++) file[COMPILED_ORDER + i] = copy[COMPILED_ORDER + 3 - i];
    put_file(path[1], file, size);
    refuses(SNELL_ERR_UNSUPPORTED, "another byte order", again, NULL);
    memcpy(file, copy, size);
    file[size - 20] ^= 4;
    put_file(path[1], file, size);
    refuses(SNELL_ERR_SYNTAX, "damaged", again, NULL);
    put_file(path[1], copy, size - 8);
    refuses(SNELL_ERR_SYNTAX, "cut short", again, NULL);
    put_file(path[1], copy, 60);
    refuses(SNELL_ERR_SYNTAX, "cut short", "write it again", NULL);
    memcpy(file, copy, size);
    memset(file + size, 0, 8);
    put_file(path[1], file, size + 8);
    refuses(SNELL_ERR_SYNTAX, "too long", again, NULL);
    snell_load_desc desc = SNELL_INIT(load_desc);
    desc.format = "snell";
    put_file(path[1], program, 100);
    refuses(SNELL_ERR_SYNTAX, "does not begin as one", "snell convert", &desc);
    free(copy);
}

/* A direction that is not of length 1 cannot come from here. */
static void directions_are_held_to_their_length(void **state) {
    (void)state;
    description *d;
    assert_int_equal(description_create(&d), SNELL_OK);
    const snell_param normal = {"normal", SNELL_PARAM_VEC3, {.v = {0, 0, 1}}};
    assert_int_equal(
        description_add(d, CATEGORY_SHAPE, "plane", &normal, 1, (object_source){0}, NULL),
        SNELL_OK);
    assert_int_equal(compiled_write(d, path[1]), SNELL_OK);
    description_destroy(d);
    size_t size, at = COMPILED_HEADER_SIZE;
    uint8_t *file = get_file(path[1], &size);
    const float direction[3] = {0, 0, 1}, two = 2;
    while (at + 12 <= size && memcmp(file + at, direction, 12) != 0) at += 4;
    assert_true(at + 12 <= size);
    memcpy(file + at + 8, &two, sizeof two);
    compiled_fix(file, size);
    put_file(path[1], file, size);
    refuses(SNELL_ERR_SYNTAX, "a direction's length", "", NULL);
}

/* Half of them get a checksum that fits, so that the records are looked at. */
static void broken_files_do_no_harm(void **state) {
    (void)state;
    size_t size, peak = memory_peak();
    compile();
    uint8_t *file = get_file(path[1], &size), *copy = malloc(size);
    assert_non_null(copy);
    memcpy(copy, file, size);
    uint64_t seed = 1;
    int accepted = 0, refused = 0;
    for (int i = 0; i < 10000; i++) {
        memcpy(file, copy, size);
        mutate(file, size, &seed);
        size_t kept = size;
        if (i % 16 == 15) kept = 1 + random_next(&seed) % size;
        if (i % 2 && kept > COMPILED_HEADER_SIZE) compiled_fix(file, kept);
        put_file(path[1], file, kept);
        rig_clear(&bench);
        double begin = cpu_seconds();
        snell_load_desc desc = SNELL_INIT(load_desc);
        desc.format = "snell";
        snell_status status = snell_scene_load(bench.scene, path[1], &desc);
        if (status == SNELL_OK) {
            accepted++;
            status = snell_scene_commit(bench.scene, NULL, NULL);
        } else {
            refused++;
            assert_int_equal(bench.scene->description->instance_count, 0);
        }
        if (status)
            assert_true(snell_last_error()->text[0] != '\0' && status != SNELL_ERR_INTERNAL);
        assert_true(cpu_seconds() - begin < 1);
    }
    print_message("%d accepted, %d refused\n", accepted, refused);
    assert_true(accepted > 200 && refused > 5000);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    assert_true(memory_peak() - peak < (size_t)512 << 20);
#else
    (void)peak;
#endif
    free(copy);
}

/* ---- Lua ---- */

static void a_scene_becomes_a_program_and_comes_back(void **state) {
    (void)state;
    compile();
    static float before[16 * 12 * 3], after[16 * 12 * 3];
    render(before);
    MUST(snell_scene_save(bench.scene, path[0]));
    rig_clear(&bench);
    snell_load_desc desc = with_next_frame();
    MUST(snell_scene_load(bench.scene, path[0], &desc));
    render(after);
    assert_memory_equal(before, after, sizeof before);
}

static double chance(uint64_t *seed) { return (double)(random_next(seed) >> 11) * 0x1p-53; }

/* Any float in a range that it prefers to be about 1. */
static float some_float(const field *f, uint64_t *seed) {
    double low = f->min > -1e30 ? f->min : -1000, high = f->max < 1e30 ? f->max : 1000;
    if (high > low + 1000) high = low + 1000;
    double x = low + (high - low) * chance(seed);
    if (random_next(seed) % 4 == 0) x *= 1e-6;
    if (random_next(seed) % 8 == 0) x = floor(x);
    if (x < low) x = low;
    if ((f->flags & FIELD_OPEN_MIN) && !((double)(float)x > low)) x = high;
    return (float)x;
}

static snell_vec3 some_vec3(const field *f, uint64_t *seed) {
    snell_vec3 v = {some_float(f, seed), some_float(f, seed), some_float(f, seed)};
    if (random_next(seed) % 4 == 0) v.y = v.z = v.x;
    return v;
}

/* Is the field on the second side of a choice? Only the first is given. */
static bool is_alternative(const type_info *type, const char *name) {
    const char *side = type->either ? strchr(type->either, '|') : NULL;
    for (; side; side = strchr(side + 1, '|')) {
        const char *end = side + strcspn(side, ";");
        for (const char *at = side + 1; at < end; at += strcspn(at, " |;") + 1)
            if (strncmp(at, name, strlen(name)) == 0 && strcspn(at, " |;") == strlen(name))
                return true;
    }
    return false;
}

static void set_some(const description *d, const type_info *type, char *desc, uint64_t *seed) {
    for (uint32_t i = 0; i < type->field_count; i++) {
        const field *f = &type->fields[i];
        void *at = desc + f->offset;
        int words = 1;
        bool required = f->flags & FIELD_REQUIRED;
        if (is_alternative(type, f->name) || (!required && random_next(seed) % 2)) continue;
        switch (f->kind) {
        case FIELD_BOOL: *(bool *)at = random_next(seed) % 2; break;
        case FIELD_INT: *(int32_t *)at = (int32_t)some_float(f, seed); break;
        case FIELD_FLOAT: *(float *)at = some_float(f, seed); break;
        case FIELD_VEC2:
            *(snell_vec2 *)at = (snell_vec2){some_float(f, seed), some_float(f, seed)};
            break;
        case FIELD_VEC3:
        case FIELD_COLOR: *(snell_vec3 *)at = some_vec3(f, seed); break;
        case FIELD_SCALAR:
        case FIELD_INPUT: {
            snell_input *input = at;
            input->value = some_vec3(f, seed);
            if (f->kind == FIELD_SCALAR) input->value.y = input->value.z = input->value.x;
            if (random_next(seed) % 4 == 0) input->texture = (snell_texture_id){1, 0};
            break;
        }
        case FIELD_CHOICE:
            for (const char *c = f->choices; *c; c++) words += *c == '|';
            *(int32_t *)at = (int32_t)(random_next(seed) % (uint64_t)words);
            break;
        case FIELD_MATERIAL:
            if (d->objects[CATEGORY_MATERIAL].count)
                *(snell_material_id *)at = (snell_material_id){1, 0};
            break;
        default: break;
        }
    }
}

/* One of each type with random fields, in so far as a check of the type's own lets them be. */
static size_t add_some_of_all(description *d, uint64_t *seed, bool *had) {
    const snell_param black = {"color", SNELL_PARAM_FLOAT, {.f = 0}};
    size_t added = 0;
    description_add(d, CATEGORY_TEXTURE, "checker", NULL, 0, (object_source){"a b", NULL, 0}, NULL);
    description_add(d, CATEGORY_MATERIAL, "lambert", &black, 1, (object_source){"end", NULL, 0},
                    NULL);
    const type_info *type;
    for (uint32_t i = 0; (type = type_at(i)) != NULL; i++) {
        if (strcmp(type->name, "animation") == 0) continue;
        char *desc = memory_zeroed(1, type->desc_size);
        assert_non_null(desc);
        desc_init(type, desc);
        set_some(d, type, desc, seed);
        uint32_t index;
        snell_status status = description_add_desc(d, type, desc, (object_source){0}, &index);
        free(desc);
        if (status) continue;
        had[i] = true;
        added++;
        if (type->category != CATEGORY_SHAPE) continue;
        transform t;
        for (int k = 0; k < 12; k++) (&t.m[0][0])[k] = (float)(chance(seed) * 8 - 4);
        description_add_instance(d, index, (uint32_t)(random_next(seed) % 2), &t,
                                 (object_source){0}, NULL);
    }
    return added;
}

/* Types without lists and texts; of every number the reader must make the same float again. The hash of a scene is of
 * every field. What was normalised once, as here, is now and then no direction that a reader, who normalises twice,
 * can make of any numbers: an error says so. */
static void programs_keep_every_number(void **state) {
    (void)state;
    uint64_t seed = 5;
    bool had[256] = {false};
    size_t refused = 0;
    for (int round = 0; round < 40; round++) {
        uint64_t there, back;
        rig_clear(&bench);
        size_t added = add_some_of_all(bench.scene->description, &seed, had);
        assert_true(added > 15);
        there = hash();
        snell_status status = snell_scene_save(bench.scene, path[0]);
        if (status) print_message("%s\n", snell_last_error()->text);
        if (status == SNELL_ERR_UNSUPPORTED && strstr(snell_last_error()->text, "this direction")) {
            refused++;
            continue;
        }
        assert_int_equal(status, SNELL_OK);
        rig_clear(&bench);
        MUST(snell_scene_load(bench.scene, path[0], NULL));
        back = hash();
        if (there != back) print_error("round %d: see %s\n", round, path[0]);
        assert_true(there == back);
    }
    assert_true(refused <= 4);
    size_t kinds = 0;
    for (int i = 0; i < 256; i++) kinds += had[i];
    print_message("%zu types\n", kinds);
    assert_true(kinds >= 30);
}

static void user_bounds(void *user, uint32_t primitive, snell_bounds *out) {
    (void)user, (void)primitive;
    *out = (snell_bounds){{0, 0, 0}, {1, 1, 1}};
}
static bool user_hit(void *user, uint32_t primitive, const snell_user_ray *from,
                     snell_user_hit *out) {
    (void)user, (void)primitive, (void)from, (void)out;
    return false;
}
static void user_surface(void *user, uint32_t primitive, const snell_user_ray *from,
                         const snell_user_hit *found, snell_user_surface *out) {
    (void)user, (void)primitive, (void)from, (void)found, (void)out;
}

static void what_cannot_be_kept_is_named(void **state) {
    (void)state;
    rig_clear(&bench);
    assert_int_equal(snell_scene_save(bench.scene, "scene.txt"), SNELL_ERR_ARGUMENT);
    assert_non_null(strstr(snell_last_error()->text, "scene.txt"));
    assert_int_equal(snell_scene_save(bench.scene, NULL), SNELL_ERR_ARGUMENT);
    /* A model that shines is lit by the studio; a program that shines is not. */
    const snell_param glow = {"emission", SNELL_PARAM_FLOAT, {.f = 2}};
    description *d = bench.scene->description;
    description_add(d, CATEGORY_MATERIAL, "lambert", &glow, 1, (object_source){0}, NULL);
    d->is_model = true;
    assert_int_equal(snell_scene_save(bench.scene, path[0]), SNELL_ERR_UNSUPPORTED);
    assert_non_null(strstr(snell_last_error()->text, "shines"));
    MUST(snell_scene_save(bench.scene, path[1]));
    snell_user_shape_desc mine = SNELL_INIT(user_shape_desc);
    mine.bounds = user_bounds;
    mine.intersect = user_hit;
    mine.surface = user_surface;
    MUST(snell_scene_add_user_shape(bench.scene, &mine, NULL, NULL));
    for (int i = 0; i < 2; i++) {
        assert_int_equal(snell_scene_save(bench.scene, path[i]), SNELL_ERR_UNSUPPORTED);
        assert_non_null(strstr(snell_last_error()->text, "functions of the caller"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_compiled_scene_is_what_it_was),
        cmocka_unit_test(what_was_settled_is_not_asked_again),
        cmocka_unit_test(another_version_says_what_to_do),
        cmocka_unit_test(directions_are_held_to_their_length),
        cmocka_unit_test(broken_files_do_no_harm),
        cmocka_unit_test(a_scene_becomes_a_program_and_comes_back),
        cmocka_unit_test(programs_keep_every_number),
        cmocka_unit_test(what_cannot_be_kept_is_named),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
