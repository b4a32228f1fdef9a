/* glTF beyond single pictures: animations against positions worked out by hand and by another program,
 * sets of texture coordinates, tangents, and what the extensions become. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "described.h"
#include "geometry/mesh.h"
#include "importers/importer.h"
#include "maths/motion.h"
#include "scene/settings.h"

#define DATA TEST_SOURCE_DIR "/tests/data/gltf/"

static const import_options plain = {.memory_max = (uint64_t)256 << 20};

/* ---- importing and looking ---- */

static snell_status import_path(const char *path, const import_options *options,
                                description **out) {
    assert_int_equal(description_create(out), SNELL_OK);
    error_clear();
    return import_file(path, NULL, options, *out);
}

static description *load_path(const char *path, uint32_t frame, const char *animation, double fps) {
    char words[2][64];
    const char *params[2] = {words[0], words[1]};
    import_options options = plain;
    options.frame = frame;
    options.params = params;
    if (animation)
        snprintf(words[options.param_count++], sizeof words[0], "animation=%s", animation);
    if (fps > 0) snprintf(words[options.param_count++], sizeof words[0], "fps=%g", fps);
    description *d;
    snell_status status = import_path(path, &options, &d);
    if (status) print_error("%s: %s\n", path, error_last()->text);
    assert_int_equal(status, SNELL_OK);
    return d;
}

static description *load(const char *name, uint32_t frame, const char *animation, double fps) {
    char path[1024];
    snprintf(path, sizeof path, "%s%s", DATA, name);
    return load_path(path, frame, animation, fps);
}

static bool is_near(double a, double b, double tolerance) {
    if (fabs(a - b) <= tolerance * (1 + fabs(b))) return true;
    print_error("%.9g is not %.9g\n", a, b);
    return false;
}
#define near(a, b) assert_true(is_near((double)(a), b, 1e-5))

static void near3(snell_vec3 v, double x, double y, double z) {
    near(v.x, x);
    near(v.y, y);
    near(v.z, z);
}

static const char *map_of(const description *d, snell_texture_id id) {
    static char word[32];
    const object *o = &d->objects[CATEGORY_TEXTURE].items[id.index1 - 1];
    const field *f = type_find_field(o->type, "map");
    choice_word(f->choices, *(const int32_t *)field_of(o, "map"), word, sizeof word);
    return word;
}
static uint8_t first_byte(const description *d, snell_texture_id id) {
    const object *o = &d->objects[CATEGORY_TEXTURE].items[id.index1 - 1];
    return (*(const uint8_t *const *)field_of(o, "pixels"))[0];
}

static const instance *instance_named(const description *d, const char *name) {
    for (size_t i = 0; i < d->instance_count; i++)
        if (strcmp(d->instances[i].name, name) == 0) return &d->instances[i];
    fail_msg("no instance %s", name);
    return NULL;
}

static const mesh_desc *mesh_at(const description *d, size_t index) {
    assert_true(index < d->objects[CATEGORY_SHAPE].count);
    return d->objects[CATEGORY_SHAPE].items[index].desc;
}

static bool has_message(const description *d, const char *part) {
    for (size_t i = 0; i < d->message_count; i++)
        if (strstr(d->messages[i].text, part)) return true;
    return false;
}

/* Where an instance puts a point of its shape at a time. */
static snell_vec3 seen_at(const instance *i, double time, double x, double y, double z) {
    double m[3][4];
    if (i->key_count == 0) return vec3_from(transform_point(&i->to_world, (dvec3){x, y, z}));
    motion_interpolate(i->keys, i->key_count, time, m);
    return (snell_vec3){(float)(m[0][0] * x + m[0][1] * y + m[0][2] * z + m[0][3]),
                        (float)(m[1][0] * x + m[1][1] * y + m[1][2] * z + m[1][3]),
                        (float)(m[2][0] * x + m[2][1] * y + m[2][2] * z + m[2][3])};
}

static const animation_desc *clock_of(const description *d) {
    return description_setting(d, "animation")->desc;
}

/* ---- animations ---- */

static const double DEGREE = 3.14159265358979323846 / 180;

static void without_a_frame_a_model_rests(void **state) {
    (void)state;
    description *d = load("animated.gltf", 0, NULL, 0);
    near3(seen_at(instance_named(d, "mover"), 0, 0, 0, 0), 0, 0, 0);
    near3(seen_at(instance_named(d, "cubic"), 0, 0, 0, 0), 0, 0, 0);
    near3(seen_at(instance_named(d, "still"), 0, 0, 0, 0), 5, 0, 0);
    for (size_t i = 0; i < d->instance_count; i++) assert_int_equal(d->instances[i].key_count, 0);
    assert_int_equal(clock_of(d)->last, 49); /* 2 s at 24 */
    assert_true(has_message(d, "at rest"));
    assert_true(has_message(d, "1 first (2 s, frames 1 to 49), 2 second (0.25 s, frames 1 to 7)"));
    assert_int_equal(d->param_count, 2);
    assert_string_equal(d->params[0].value, "first");
    description_destroy(d);
}

/* Frame 13 is at half a second. */
static void nodes_move_as_their_tracks_say(void **state) {
    (void)state;
    description *d = load("animated.gltf", 13, NULL, 0);
    const instance *mover = instance_named(d, "mover"), *child = instance_named(d, "child"),
                   *cubic = instance_named(d, "cubic");
    near3(seen_at(mover, 0.5, 0, 0, 0), 12, 0, 0);
    near3(seen_at(mover, 0.5 + 0.5 / 24, 0, 0, 0), 12.5, 0, 0); /* the shutter closes */
    near3(seen_at(mover, 0.5 - 1.0 / 24, 0, 0, 0), 11, 0, 0);
    /* a quarter of the way to 90 degrees about z, along the arc */
    double angle = 22.5 * DEGREE;
    near3(seen_at(mover, 0.5, 1, 0, 0), 12 + cos(angle), sin(angle), 0);
    near3(seen_at(child, 0.5, 0, 0, 0), 12 - sin(angle), cos(angle), 0);
    near3(seen_at(child, 0.5, 1, 0, 0), 12 - sin(angle) + 2 * cos(angle),
          cos(angle) + 2 * sin(angle), 0);
    /* Hermite: 1/2 v0 + 1/8 b0 + 1/2 v1 - 1/8 a1 with b0 = (4, 0, 0), v1 = (1, 0, 0), a1 = (0, 2, 0) */
    near3(seen_at(cubic, 0.5, 0, 0, 0), 1, -0.25, 0);
    assert_int_equal(instance_named(d, "still")->key_count, 0);
    assert_int_equal(clock_of(d)->frame, 13);
    description_destroy(d);
    d = load("animated.gltf", 49, NULL, 0); /* the last keys hold */
    near3(seen_at(instance_named(d, "cubic"), 2, 0, 0, 0), 1, 0, 0);
    assert_int_equal(instance_named(d, "cubic")->key_count, 0);
    description_destroy(d);
}

static void steps_hold_until_the_next_key(void **state) {
    (void)state;
    description *d = load("animated.gltf", 3, NULL, 5); /* at 0.4 s: the key itself */
    near3(seen_at(instance_named(d, "child"), 0.4, 1, 0, 0),
          24 * 0.4 - sin(18 * DEGREE) + 2 * cos(18 * DEGREE),
          cos(18 * DEGREE) + 2 * sin(18 * DEGREE), 0);
    near(clock_of(d)->fps, 5);
    assert_int_equal(clock_of(d)->last, 11);
    description_destroy(d);
    d = load("animated.gltf", 2, NULL, 5); /* at 0.2 s */
    near3(seen_at(instance_named(d, "child"), 0.2, 1, 0, 0),
          24 * 0.2 - sin(9 * DEGREE) + cos(9 * DEGREE), cos(9 * DEGREE) + sin(9 * DEGREE), 0);
    description_destroy(d);
}

static void cameras_move(void **state) {
    (void)state;
    description *d = load("animated.gltf", 13, NULL, 0);
    const object *eye = named(d, CATEGORY_CAMERA, "eye");
    struct {
        const motion_key *data;
        size_t count;
    } keys;
    memcpy(&keys, field_of(eye, "motion"), sizeof keys);
    assert_true(keys.count > 16);
    /* The track's end is -q of 90 degrees: the shorter arc is 90, not 270. Looking along -Z turned by
     * 22.5 degrees about y. */
    double angle = 22.5 * DEGREE;
    snell_vec3 from = *(const snell_vec3 *)field_of(eye, "from"),
               at = *(const snell_vec3 *)field_of(eye, "at");
    near3(from, 1, 0, 0);
    dvec3 forward = dvec3_normalize(dvec3_sub(dvec3_from(at), dvec3_from(from)));
    near3(vec3_from(forward), -sin(angle), 0, -cos(angle));
    /* The keys turn about the camera's place, relative to the frame's own time. */
    double m[3][4], turned = 90 * DEGREE * (1.0 / 24) / 2;
    motion_interpolate(keys.data, keys.count, 0.5 + 1.0 / 24, m);
    near(m[0][0], cos(turned));
    near(m[0][2], sin(turned));
    near(m[0][0] + m[0][3], 1); /* (1, 0, 0) stays */
    motion_interpolate(keys.data, keys.count, 0.5, m);
    near(m[0][0], 1);
    description_destroy(d);
}

static void animations_are_chosen(void **state) {
    (void)state;
    static const char *const words[] = {"second", "2"};
    for (int i = 0; i < 2; i++) {
        description *d = load("animated.gltf", 7, words[i], 0); /* 0.25 s */
        near3(seen_at(instance_named(d, "still"), 0.25, 0, 0, 0), 5, 7, 0);
        near3(seen_at(instance_named(d, "mover"), 0.25, 0, 0, 0), 0, 0, 0);
        assert_int_equal(clock_of(d)->last, 7);
        description_destroy(d);
    }
    description *d = load("animated.gltf", 7, "all", 0);
    near3(seen_at(instance_named(d, "still"), 0.25, 0, 0, 0), 5, 7, 0);
    near3(seen_at(instance_named(d, "mover"), 0.25, 0, 0, 0), 6, 0, 0);
    description_destroy(d);
    d = load("animated.gltf", 0, "second", 0); /* naming one is asking for its first frame */
    assert_int_equal(clock_of(d)->frame, 1);
    assert_false(has_message(d, "at rest"));
    description_destroy(d);
}

static void refuse(uint32_t frame, const char *param, const char *says, const char *hint) {
    import_options options = plain;
    options.frame = frame;
    options.params = &param;
    options.param_count = param != NULL;
    description *d;
    assert_int_equal(import_path(DATA "animated.gltf", &options, &d), SNELL_ERR_ARGUMENT);
    if (!strstr(error_last()->text, says)) print_error("'%s'\n", error_last()->text);
    assert_non_null(strstr(error_last()->text, says));
    assert_non_null(strstr(error_last()->hint, hint));
    description_destroy(d);
}

static void wrong_requests_are_explained(void **state) {
    (void)state;
    refuse(50, NULL, "frame 50: the animation has frames 1 to 49", "");
    refuse(8, "animation=second", "frame 8: the animation has frames 1 to 7", "");
    refuse(0, "animation=jump", "no animation 'jump'", "2 second");
    refuse(0, "animation=0", "no animation '0'", "1 first");
    refuse(0, "fps=0", "fps: '0'", "fps=30");
    refuse(0, "fps=fast", "fps: 'fast'", "fps=30");
    refuse(0, "speed=2", "-D speed=2", "fps=30");
}

static void meshes_deform(void **state) {
    (void)state;
    description *d = load("deforming.gltf", 13, NULL, 0); /* half a second */
    const mesh_desc *skin = mesh_at(d, 0), *morph = mesh_at(d, 1);
    size_t now = skin->key_times_count / 2;
    assert_int_equal(skin->key_times_count, 9);
    assert_int_equal(skin->positions_count, 27);
    near(skin->key_times[now], 0.5);
    near(skin->key_times[now + 2], 0.5 + 0.5 / 24); /* the shutter closes at a key */
    double angle = 45 * DEGREE, later = 90 * DEGREE * (0.5 + 0.5 / 24);
    near3(skin->positions[3 * now + 1], cos(angle), sin(angle), 0);
    near3(skin->positions[3 * now + 7], cos(later), sin(later), 0);
    near3(skin->normals[3 * now + 1], cos(angle), sin(angle), 0);
    near3(skin->normals[3 * now], 0, 0, 1);
    near3(morph->positions[3 * now], 0, 0, 2);
    near3(morph->positions[3 * now + 3], 0, 0, 4 * (0.5 + 0.25 / 24));
    near3(morph->positions[3 * now + 1], 1, 0, 0);
    description_destroy(d);
    d = load("deforming.gltf", 0, NULL, 0);
    assert_int_equal(mesh_at(d, 0)->key_times_count, 0);
    near3(mesh_at(d, 0)->positions[1], 1, 0, 0);
    near3(mesh_at(d, 1)->positions[0], 0, 0, 0);
    description_destroy(d);
}

/* What another program, tests/data/gltf/reference.py, works out for Khronos' samples. */
static const char *sample(const char *name, char out[1024]) {
    const char *folder = getenv("SNELL_MODELS");
    if (folder == NULL) folder = TEST_SOURCE_DIR "/../shared/models";
    snprintf(out, 1024, "%s/gltf-khronos-samples/%s/glTF-Binary/%s.glb", folder, name, name);
    if (access(out, R_OK) == 0) return out;
    print_message("SKIPPED: no model files (set SNELL_MODELS)\n");
    return NULL;
}

static void khronos_box_opens(void **state) {
    (void)state;
    char room[1024];
    const char *path = sample("BoxAnimated", room);
    if (path == NULL) skip();
    description *d = load_path(path, 30, NULL, 0);
    double lid = -1;
    for (size_t i = 0; i < d->instance_count; i++) {
        snell_vec3 p = seen_at(&d->instances[i], 29.0 / 24, 0, 0, 0);
        lid = (double)p.y > lid ? (double)p.y : lid;
    }
    near(lid, 2.436);
    description_destroy(d);
    d = load_path(path, 60, NULL, 0);
    bool found = false;
    for (size_t i = 0; i < d->instance_count; i++) {
        snell_vec3 p = seen_at(&d->instances[i], 59.0 / 24, 0, 1, 0);
        if (d->instances[i].key_count == 0) continue;
        near3(p, 0, 2.52 - 0.994522, 0.104528);
        found = true;
    }
    assert_true(found);
    description_destroy(d);
}

static void khronos_fox_runs(void **state) {
    (void)state;
    static const struct {
        size_t vertex;
        double x, y, z;
    } expected[] = {{0, 2.78478, 26.37532, -22.93053},
                    {100, 0, 23.84774, -6.39694},
                    {500, 9.61861, 19.35918, -43.44838},
                    {1500, -7.69950, 27.93179, 55.36160}};
    char room[1024];
    const char *path = sample("Fox", room);
    if (path == NULL) skip();
    description *d = load_path(path, 6, "Run", 0);
    const mesh_desc *fox = mesh_at(d, 0);
    size_t vertices = mesh_vertex_count(fox), now = fox->key_times_count / 2;
    assert_int_equal(fox->key_times_count, 9);
    for (size_t i = 0; i < 4; i++)
        near3(fox->positions[now * vertices + expected[i].vertex], expected[i].x, expected[i].y,
              expected[i].z);
    assert_int_equal(clock_of(d)->last, 28);
    description_destroy(d);
}

/* ---- broken animations ---- */

#define HEAD                                                                                       \
    "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{},{\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,"   \
    "1]}],\"buffers\":[{\"byteLength\":24,\"uri\":\"data:;base64,AAAAAAAAAAAAAIA/"                 \
    "AAAAAAAAAAAAAIC/\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":24}],\"accessors\":["      \
    "{\"bufferView\":0,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\",\"min\":[0],"        \
    "\"max\":[0]},{\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"},{\"componentType\":5126," \
    "\"count\":2,\"type\":\"VEC4\"},{\"bufferView\":0,\"byteOffset\":16,\"componentType\":5126,"   \
    "\"count\":2,\"type\":\"SCALAR\",\"min\":[0],\"max\":[0]}],\"animations\":[{"
#define TO(node, path) "{\"sampler\":0,\"target\":{\"node\":" node ",\"path\":\"" path "\"}}"
#define FROM(in, out, more) "\"samplers\":[{\"input\":" in ",\"output\":" out more "}]}]}"

static void broken_animations_are_errors(void **state) {
    (void)state;
    static const struct {
        const char *json, *says;
    } wrong[] = {
        {HEAD "\"channels\":[" TO("0", "translation") "]," FROM("0", "1", ""), "not ascending"},
        {HEAD "\"channels\":[" TO("0", "translation") "]," FROM("3", "1", ""), "negative"},
        {HEAD "\"channels\":[" TO("0", "translation") "]," FROM("1", "1", ""), "one float per key"},
        {HEAD "\"channels\":[" TO("0", "rotation") "]," FROM("0", "1", ""),
         "does not hold a rotation"},
        {HEAD "\"channels\":[" TO("0", "scale") "]," FROM("0", "2", ""), "does not hold a scale"},
        {HEAD "\"channels\":[" TO("0", "weights") "]," FROM("0", "0", ""), "no morph targets"},
        {HEAD "\"channels\":[" TO("1", "scale") "]," FROM("0", "1", ""), "has a matrix"},
        {HEAD "\"channels\":[" TO("0", "scale") "]," FROM("0", "1",
                                                          ",\"interpolation\":\"CUBICSPLINE\""),
         "2 keys need 3 each"},
        {HEAD
         "\"channels\":[" TO("0", "scale") "]," FROM("0", "1", ",\"interpolation\":\"BEZIER\""),
         "'BEZIER' is not one of STEP|LINEAR|CUBICSPLINE"},
        {HEAD "\"channels\":[" TO("0", "scale") "," TO("0", "scale") "]," FROM("0", "1", ""),
         "two move nodes[0].scale"},
        {HEAD "\"channels\":[{\"sampler\":3,\"target\":{\"node\":0,\"path\":\"scale\"}}]," FROM(
             "0", "1", ""),
         "no sampler 3"},
    };
    char path[600];
    snprintf(path, sizeof path, "%s/snell_test_gltf_%d.gltf",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : TEST_BINARY_DIR, (int)getpid());
    import_options options = plain;
    options.frame = 1;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        FILE *f = fopen(path, "w");
        assert_non_null(f);
        fputs(wrong[i].json, f);
        assert_int_equal(fclose(f), 0);
        description *d;
        snell_status status = import_path(path, &options, &d);
        if (status != SNELL_ERR_SYNTAX || !strstr(error_last()->text, wrong[i].says))
            print_error("%zu: status %d, '%s' for '%s'\n", i, status, error_last()->text,
                        wrong[i].says);
        assert_int_equal(status, SNELL_ERR_SYNTAX);
        assert_non_null(strstr(error_last()->text, wrong[i].says));
        description_destroy(d);
    }
    unlink(path);
}

/* ---- what Khronos' validator finds in data: own inputs, the validator's files are in test_formats.c ---- */

#define START "{\"asset\":{\"version\":\"2.0\"}"

typedef struct faulty {
    const char *json, *says;
} faulty;

static const faulty refused[] = {
    {START
     ",\"buffers\":[{\"byteLength\":12,\"uri\":\"data:application/"
     "octet-stream;base64,AAAAAAAAwH8AAAAA\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":12}],"
     "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":1,\"type\":\"VEC3\"}]}",
     "accessors[0]: element 0 is not a finite number"},
    {START ",\"buffers\":[{\"byteLength\":4,\"uri\":\"data:application/octet-stream;base64,AAH/"
           "AA==\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":4}],\"accessors\":[{"
           "\"bufferView\":0,\"componentType\":5121,\"count\":3,\"type\":\"SCALAR\"},{"
           "\"componentType\":5126,\"count\":256,\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":[{"
           "\"attributes\":{\"POSITION\":1},\"indices\":0}]}]}",
     "meshes[0].primitives[0].indices: 255 would restart a primitive"},
    {START ",\"buffers\":[{\"byteLength\":4,\"uri\":\"data:application/"
           "octet-stream;base64,AAEHAA==\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":4}],"
           "\"accessors\":[{\"bufferView\":0,\"componentType\":5121,\"count\":3,\"type\":"
           "\"SCALAR\"},{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"meshes\":[{"
           "\"primitives\":[{\"attributes\":{\"POSITION\":1},\"indices\":0}]}]}",
     "meshes[0].primitives[0].indices: 7 is beyond the last of 3 vertices"},
    {START ",\"buffers\":[{\"byteLength\":12,\"uri\":\"data:application/"
           "octet-stream;base64,AAAAAAAAgD8AAIA/"
           "\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":12}],\"accessors\":[{\"bufferView\":"
           "0,\"componentType\":5126,\"count\":3,\"type\":\"SCALAR\",\"min\":[0],\"max\":[1]},{"
           "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"nodes\":[{}],\"animations\":[{"
           "\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}],\"samplers\":"
           "[{\"input\":0,\"output\":1}]}]}",
     "animations[0].samplers[0].input: the time 1 of key 2"},
    {START ",\"buffers\":[{\"byteLength\":12,\"uri\":\"data:application/"
           "octet-stream;base64,AACAvwAAgD8AAABA\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":"
           "12}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":"
           "\"SCALAR\",\"min\":[-1],\"max\":[2]},{\"componentType\":5126,\"count\":3,\"type\":"
           "\"VEC3\"}],\"nodes\":[{}],\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{"
           "\"node\":0,\"path\":\"scale\"}}],\"samplers\":[{\"input\":0,\"output\":1}]}]}",
     "animations[0].samplers[0].input: the time -1 of key 0"},
    {START ",\"buffers\":[{\"byteLength\":4,\"uri\":\"missing.bin\"}]}", "buffers[0]: cannot open"},
    {START ",\"extensionsUsed\":[\"KHR_x\"],\"extensions\":{\"KHR_x\":3}}",
     "extensions.KHR_x: must be an object"},
};

static const faulty warned_of[] = {
    {START ",\"buffers\":[{\"byteLength\":24,\"uri\":\"data:application/"
           "octet-stream;base64,AAAAAAAAAEAAAAAAAACAPwAAQMAAAAAA\"}],\"bufferViews\":[{\"buffer\":"
           "0,\"byteLength\":24}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
           "\"count\":2,\"type\":\"VEC3\",\"min\":[0,-3,0],\"max\":[1,1,0]}]}",
     "accessors[0].max[1]: says 1 where it is 2"},
    {START ",\"buffers\":[{\"byteLength\":4,\"uri\":\"data:application/"
           "octet-stream;base64,AQIDBA==\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":4}],"
           "\"accessors\":[{\"bufferView\":0,\"componentType\":5121,\"count\":4,\"type\":"
           "\"SCALAR\",\"normalized\":true,\"min\":[0],\"max\":[4]}]}",
     "accessors[0].min[0]: says 0 where it is 1"},
    {START ",\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/"
           "octet-stream;base64,AAAAAAAAAAAAAIA/"
           "AAAAAAAAAEAAAAAAAACAPwAAgD8AAAAA\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}]"
           ",\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":"
           "0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":[{"
           "\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]}",
     "meshes[0].primitives[0].attributes.NORMAL: a normal has not the length 1; 1 more like this"},
    {START ",\"buffers\":[{\"byteLength\":48,\"uri\":\"data:application/"
           "octet-stream;base64,AAAAAAAAAAAAAIA/AACAPwAAAAAAAABAAAAAAAAAgL8AAIA/"
           "AAAAAAAAAAAAAAAA\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":48}],\"accessors\":["
           "{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":0,"
           "\"componentType\":5126,\"count\":3,\"type\":\"VEC4\"}],\"meshes\":[{\"primitives\":[{"
           "\"attributes\":{\"POSITION\":0,\"TANGENT\":1}}]}]}",
     "attributes.TANGENT: a tangent has not the length 1"},
    {START ",\"buffers\":[{\"byteLength\":48,\"uri\":\"data:application/"
           "octet-stream;base64,AAAAAAAAAAAAAIA/AACAPwAAAAAAAIA/AAAAAAAAgL8AAIA/"
           "AAAAAAAAAAAAAAAA\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":48}],\"accessors\":["
           "{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":0,"
           "\"componentType\":5126,\"count\":3,\"type\":\"VEC4\"}],\"meshes\":[{\"primitives\":[{"
           "\"attributes\":{\"POSITION\":0,\"TANGENT\":1}}]}]}",
     "attributes.TANGENT: a tangent's sign is 0, not 1 or -1"},
    {START ",\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/"
           "octet-stream;base64,AAAAAAAAAAAAAIA/"
           "AAAAAAAAwD8AAAAAAACAPwAAgD8AAAAA\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}]"
           ",\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":"
           "0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":[{"
           "\"attributes\":{\"POSITION\":0,\"COLOR_0\":1}}]}]}",
     "attributes.COLOR_0: a colour is 1.5, not within 0 and 1"},
    {START
     ",\"buffers\":[{\"byteLength\":32,\"uri\":\"data:application/"
     "octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAD8=\"}],\"bufferViews\":[{"
     "\"buffer\":0,\"byteLength\":32}],\"accessors\":[{\"componentType\":5126,\"count\":2,\"type\":"
     "\"SCALAR\",\"min\":[0],\"max\":[0]},{\"bufferView\":0,\"componentType\":5126,\"count\":2,"
     "\"type\":\"VEC4\"}],\"nodes\":[{}],\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{"
     "\"node\":0,\"path\":\"rotation\"}}],\"samplers\":[{\"input\":0,\"output\":1}]}]}",
     "animations[0].channels[0].sampler: the rotation of key 1 is no unit quaternion"},
    {START
     ",\"buffers\":[{\"byteLength\":64,\"uri\":\"data:application/"
     "octet-stream;base64,AACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/"
     "AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAAAAAAAAQA==\"}],\"bufferViews\":[{\"buffer\":0,"
     "\"byteLength\":64}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":1,"
     "\"type\":\"MAT4\"}],\"nodes\":[{}],\"skins\":[{\"joints\":[0],\"inverseBindMatrices\":0}]}",
     "skins[0].inverseBindMatrices: the last row of matrix 0"},
    {START ",\"nodes\":[{\"children\":[1]},{},{}],\"skins\":[{\"joints\":[1],\"skeleton\":0},{"
           "\"joints\":[1,2],\"skeleton\":0}]}",
     "skins[1].skeleton: node 0 is not above joints[1]"},
    {START ",\"nodes\":[{},{\"mesh\":0,\"skin\":0}],\"scenes\":[{\"nodes\":[1]}],\"skins\":[{"
           "\"joints\":[0]}],\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
           "{\"componentType\":5121,\"count\":3,\"type\":\"VEC4\"},{\"componentType\":5126,"
           "\"count\":3,\"type\":\"VEC4\"}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
           "\"POSITION\":0,\"JOINTS_0\":1,\"WEIGHTS_0\":2}}]}]}",
     "nodes[1].skin: its joints are not in the scene"},
    {START ",\"nodes\":[{\"mesh\":0,\"skin\":0}],\"skins\":[{\"joints\":[0]}],\"accessors\":[{"
           "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":[{"
           "\"attributes\":{\"POSITION\":0}}]}]}",
     "nodes[0].skin: meshes[0].primitives[0] has no JOINTS_0"},
    {START ",\"buffers\":[{\"byteLength\":64}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":64,"
           "\"byteStride\":4,\"target\":34963}],\"accessors\":[{\"componentType\":5126,\"count\":3,"
           "\"type\":\"VEC3\"}]}",
     "bufferViews[0].byteStride: indices have none"},
    {START ",\"buffers\":[{\"byteLength\":64}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":64}],"
           "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
           "{\"bufferView\":0,\"componentType\":5125,\"count\":3,\"type\":\"SCALAR\"}],\"meshes\":["
           "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]}",
     "meshes[0].primitives[0].indices: bufferViews[0] is used for vertices and for other things"},
    {START ",\"buffers\":[{\"byteLength\":64}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":64}],"
           "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
           "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"meshes\":[{"
           "\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]}",
     "attributes.NORMAL: bufferViews[0] has no byteStride, but two accessors"},
    {START ",\"buffers\":[{\"byteLength\":64}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":64}],"
           "\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":"
           "0,\"componentType\":5121,\"count\":3,\"type\":\"VEC3\",\"normalized\":true}],"
           "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":1}}]}]}",
     "attributes.COLOR_0: bufferViews[0]: its vertices are not at multiples of four bytes"},
    {START ",\"buffers\":[{\"byteLength\":64}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":64,"
           "\"byteStride\":4}],\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":"
           "\"VEC3\"}],\"images\":[{\"bufferView\":0,\"mimeType\":\"image/png\"}]}",
     "images[0].bufferView: has a byteStride"},
    {START ",\"images\":[{\"uri\":\"data:image/"
           "gif;base64,"
           "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNgYGAAAAAEAAH2FzhVAAAAAElFTkS"
           "uQmCC\"}]}",
     "images[0].uri: says image/gif, but it is image/png"},
    {START ",\"images\":[{\"mimeType\":\"image/jpeg\",\"uri\":\"data:image/"
           "png;base64,"
           "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNgYGAAAAAEAAH2FzhVAAAAAElFTkS"
           "uQmCC\"}]}",
     "images[0].mimeType: says image/jpeg, but it is image/png"},
    {START ",\"images\":[{\"uri\":\"missing.png\"}]}", "images[0]: cannot open 'missing.png'"},
    {START ",\"buffers\":[{\"byteLength\":1,\"uri\":\"data:text/plain;base64,AA==\"}]}",
     "buffers[0].uri: should begin with data:application/octet-stream;base64,"},
    {START ",\"extensionsUsed\":[\"KHR_materials_unlit\"],\"samplers\":[{\"extensions\":{\"KHR_"
           "materials_unlit\":{}}}]}",
     "samplers[0].extensions.KHR_materials_unlit: has no place here"},
};

static const char *write_file(const char *text) {
    static char path[600];
    snprintf(path, sizeof path, "%s/snell_test_gltf_%d.gltf",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : TEST_BINARY_DIR, (int)getpid());
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fputs(text, f);
    assert_int_equal(fclose(f), 0);
    return path;
}

static void wrong_data_is_named(void **state) {
    (void)state;
    description *d;
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        snell_status status = import_path(write_file(refused[i].json), &plain, &d);
        if (!status || !strstr(error_last()->text, refused[i].says))
            print_error("%zu: '%s' for '%s'\n", i, status ? error_last()->text : "no error",
                        refused[i].says);
        assert_true(status && strstr(error_last()->text, refused[i].says));
        description_destroy(d);
    }
    for (size_t i = 0; i < sizeof warned_of / sizeof warned_of[0]; i++) {
        snell_status status = import_path(write_file(warned_of[i].json), &plain, &d);
        if (status || !has_message(d, warned_of[i].says))
            print_error("%zu: '%s' for '%s'\n", i,
                        status             ? error_last()->text
                        : d->message_count ? d->messages[0].text
                                           : "no warning",
                        warned_of[i].says);
        assert_int_equal(status, SNELL_OK);
        assert_true(has_message(d, warned_of[i].says));
        description_destroy(d);
    }
    unlink(write_file(""));
}

/* ---- texture coordinates and tangents ---- */

static void each_texture_has_its_own_set(void **state) {
    (void)state;
    description *d = load("uvs.gltf", 0, NULL, 0);
    const mesh_desc *m = mesh_at(d, 0);
    const object *both = named(d, CATEGORY_MATERIAL, "both");
    assert_int_equal(m->uvs_count, 4);
    assert_int_equal(m->uvs2_count, 4);
    near(m->uvs[2].x, 0.25);
    near(m->uvs2[2].x, 1);
    near(m->uvs2[2].y, 1); /* glTF's v = 0 is the image's upper edge */
    assert_string_equal(map_of(d, input_of(both, "base_color").texture), "uv");
    assert_string_equal(map_of(d, input_of(both, "emission").texture), "uv2");
    assert_string_equal(map_of(d, *(const snell_texture_id *)field_of(both, "normal_map")), "uv2");
    assert_int_equal(m->tangents_count, 16);
    near(m->tangents[1], 1);
    near(m->tangents[3], -1);
    assert_false(has_message(d, "sets of texture coordinates"));
    const object *coat = named(d, CATEGORY_MATERIAL, "varnished");
    snell_texture_id normals = *(const snell_texture_id *)field_of(coat, "clearcoat_normal_map");
    assert_string_equal(map_of(d, normals), "uv2");
    const object *map = &d->objects[CATEGORY_TEXTURE].items[normals.index1 - 1];
    near3(*(const snell_vec3 *)field_of(map, "uv_scale"), 2, 4, 0);
    near(input_of(coat, "clearcoat_normal_scale").value.x, 0.5);
    assert_int_equal(((const snell_texture_id *)field_of(coat, "normal_map"))->index1, 0);
    assert_int_equal(mesh_at(d, 1)->tangents_count, 16);
    assert_false(has_message(d, "clearcoat"));
    description_destroy(d);
}

/* ---- extensions ---- */

static void extensions_become_fields(void **state) {
    (void)state;
    description *d = load("extensions.gltf", 0, NULL, 0);
    const object *glossy = named(d, CATEGORY_MATERIAL, "glossy"),
                 *map = named(d, CATEGORY_MATERIAL, "map"),
                 *brushed = named(d, CATEGORY_MATERIAL, "brushed"),
                 *soap = named(d, CATEGORY_MATERIAL, "film"),
                 *films = named(d, CATEGORY_MATERIAL, "films");
    near3(input_of(glossy, "base_color").value, 0.5, 0.25, 1);
    near(input_of(glossy, "metallic").value.x, 0);
    near(input_of(glossy, "roughness").value.x, 0.25);
    near(input_of(glossy, "alpha").value.x, 0.5);
    /* times the 0.04 of ior 1.5 */
    near3(input_of(glossy, "specular_color").value, 5, 1, 25);
    snell_input rough = input_of(map, "roughness");
    near(rough.value.x, 1); /* 1 - 0.5 (102 / 255) = 0.8 */
    assert_int_equal(first_byte(d, rough.texture), 204);
    assert_int_equal(first_byte(d, input_of(map, "specular_color").texture), 255);
    near(input_of(brushed, "anisotropy").value.x, 0.5);
    assert_int_equal(first_byte(d, input_of(brushed, "anisotropy").texture), 204); /* blue */
    near(float_of(brushed, "anisotropy_rotation"), 1.25);
    assert_true(((const snell_texture_id *)field_of(brushed, "anisotropy_map"))->index1 > 0);
    near(input_of(soap, "iridescence").value.x, 0.75);
    near(float_of(soap, "iridescence_ior"), 1.6);
    near(input_of(soap, "iridescence_thickness").value.x, 500);
    snell_input thickness = input_of(films, "iridescence_thickness");
    near(thickness.value.x, 400); /* 200 + 200 (51 / 255) = 240 = 400 (153 / 255) */
    assert_int_equal(first_byte(d, thickness.texture), 153);
    near(float_of(named(d, CATEGORY_MATERIAL, "prism"), "dispersion"), 0.5);
    assert_int_equal(d->message_count, 0);
    description_destroy(d);
}

static void webp_is_a_texture(void **state) {
    (void)state;
    description *d;
    snell_status status = import_path(DATA "webp.gltf", &plain, &d);
#if SNELL_HAS_WEBP
    assert_int_equal(status, SNELL_OK);
    snell_input painted = input_of(named(d, CATEGORY_MATERIAL, "painted"), "base_color");
    const object *t = &d->objects[CATEGORY_TEXTURE].items[painted.texture.index1 - 1];
    static const uint8_t pixels[] = {64, 192, 16, 255, 0, 128};
    assert_memory_equal(*(const uint8_t *const *)field_of(t, "pixels"), pixels, sizeof pixels);
#else
    assert_int_equal(status, SNELL_ERR_UNSUPPORTED);
    assert_non_null(strstr(error_last()->text, "EXT_texture_webp"));
#endif
    description_destroy(d);
}

static void draco_is_decoded(void **state) {
    (void)state;
    description *d;
    snell_status status = import_path(DATA "draco.gltf", &plain, &d);
#if SNELL_HAS_DRACO
    if (status) print_error("%s\n", error_last()->text);
    assert_int_equal(status, SNELL_OK);
    const mesh_desc *m = mesh_at(d, 0);
    assert_int_equal(mesh_triangle_count(m), 2);
    double area = 0;
    for (size_t t = 0; t < 2; t++) {
        dvec3 p[3];
        for (int k = 0; k < 3; k++) {
            uint32_t v = m->indices[3 * t + (size_t)k];
            p[k] = dvec3_from(m->positions[v]);
            near3(m->normals[v], 0, 0, 1);
            near(m->uvs[v].x, p[k].x / 2);
            near(m->uvs[v].y, 1 - p[k].y); /* the file's v is the model's */
        }
        area += dvec3_cross(dvec3_sub(p[1], p[0]), dvec3_sub(p[2], p[0])).z / 2;
    }
    near(area, 2);
#else
    assert_int_equal(status, SNELL_ERR_UNSUPPORTED);
    assert_non_null(strstr(error_last()->text, "KHR_draco_mesh_compression"));
#endif
    description_destroy(d);
}

/* ---- points and lines: the diagonal of what is drawn is 5 ---- */

static void points_and_lines_have_a_thickness(void **state) {
    (void)state;
    static const size_t triangles[] = {4 * 8, 2 * 12, 4 * 12, 3 * 12};
    description *d = load("lines.gltf", 0, NULL, 0);
    assert_int_equal(d->instance_count, 4);
    for (size_t i = 0; i < 4; i++) {
        const mesh_desc *m = mesh_at(d, i);
        assert_int_equal(mesh_triangle_count(m), triangles[i]);
        bounds3 box = bounds3_empty();
        for (size_t t = 0; t < triangles[i]; t++)
            box = bounds3_union(box, mesh_triangle_bounds(m, t));
        double radius = 5 * (i == 0 ? 0.004 : 0.0025);
        /* A rod's six edges are on its radius, its sides nearer. */
        double reach = i == 0 ? 1 : sqrt(0.75);
        assert_true((double)box.max.y >= 4 + radius * reach - 1e-6);
        assert_true((double)box.max.y <= 4 + radius + 1e-6);
        near3(m->colors[0], 1, 0, 0); /* the first vertex, and the last: white or, in a loop, red */
        near3(m->colors[m->colors_count - 1], 1, i != 2, i != 2);
    }
    /* Every rod's normals are across it, and its triangles face out. */
    const mesh_desc *rods = mesh_at(d, 1);
    for (size_t t = 0; t < mesh_triangle_count(rods); t++) {
        const uint32_t *i = rods->indices + 3 * t;
        dvec3 a = dvec3_from(rods->positions[i[0]]), b = dvec3_from(rods->positions[i[1]]),
              c = dvec3_from(rods->positions[i[2]]);
        dvec3 out = dvec3_cross(dvec3_sub(b, a), dvec3_sub(c, a));
        assert_true(dvec3_dot(out, dvec3_from(rods->normals[i[0]])) > 0);
        near(rods->normals[i[0]].x, 0);
    }
    description_destroy(d);
}

/* ---- hostile bytes ---- */

static uint64_t random_next(uint64_t *state) { /* xorshift64* */
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 2685821657736338717u;
}

static void mutate(char *data, size_t size, uint64_t *seed) {
    static const char *const words[] = {"-1", "0", "7", "1e308", "null", "[]", "5121", "255"};
    for (uint64_t n = 1 + random_next(seed) % 3; n > 0; n--) {
        size_t at = random_next(seed) % size;
        const char *word = words[random_next(seed) % 8];
        size_t length = strlen(word);
        if (random_next(seed) % 2)
            data[at] = (char)('0' + random_next(seed) % 10);
        else if (at + length <= size)
            memcpy(data + at, word, length);
    }
}

static void mutants_do_no_harm(void **state) {
    (void)state;
    static const char *const names[] = {"animated", "deforming", "uvs",  "extensions",
                                        "webp",     "draco",     "lines"};
    size_t total = getenv("SNELL_FULL") ? 50000 : 1500, loaded = 0;
    uint64_t seed = 88172645463325252u;
    char path[600];
    snprintf(path, sizeof path, "%s/snell_test_gltf_%d.gltf",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : TEST_BINARY_DIR, (int)getpid());
    for (size_t n = 0; n < total; n++) {
        static char text[16384];
        char from[1024];
        snprintf(from, sizeof from, "%s%s.gltf", DATA, names[n % 7]);
        FILE *f = fopen(from, "rb");
        assert_non_null(f);
        size_t size = fread(text, 1, sizeof text, f);
        fclose(f);
        mutate(text, size, &seed);
        f = fopen(path, "wb");
        assert_non_null(f);
        assert_int_equal(fwrite(text, 1, size, f), size);
        assert_int_equal(fclose(f), 0);
        import_options options = plain;
        options.frame = 2 * (uint32_t)(n % 3);
        description *d;
        snell_status status = import_path(path, &options, &d);
        assert_true(status != SNELL_ERR_INTERNAL);
        loaded += status == SNELL_OK;
        description_destroy(d);
    }
    unlink(path);
    print_message("%zu of %zu mutants still load\n", loaded, total);
    assert_true(loaded > 0 && loaded < total);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_a_frame_a_model_rests),
        cmocka_unit_test(nodes_move_as_their_tracks_say),
        cmocka_unit_test(steps_hold_until_the_next_key),
        cmocka_unit_test(cameras_move),
        cmocka_unit_test(animations_are_chosen),
        cmocka_unit_test(wrong_requests_are_explained),
        cmocka_unit_test(meshes_deform),
        cmocka_unit_test(khronos_box_opens),
        cmocka_unit_test(khronos_fox_runs),
        cmocka_unit_test(broken_animations_are_errors),
        cmocka_unit_test(wrong_data_is_named),
        cmocka_unit_test(each_texture_has_its_own_set),
        cmocka_unit_test(extensions_become_fields),
        cmocka_unit_test(webp_is_a_texture),
        cmocka_unit_test(draco_is_decoded),
        cmocka_unit_test(points_and_lines_have_a_thickness),
        cmocka_unit_test(mutants_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
