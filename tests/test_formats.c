/* The importers of model files, in this process: glTF in all its dialects, OBJ, PLY, STL, images;
 * what is wrong in a file is said with its place; nothing that a file says crashes. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <ftw.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"
#include "described.h"
#include "geometry/mesh.h"
#include "importers/files.h"
#include "importers/image_decode.h"
#include "mutants.h"

#define DATA TEST_SOURCE_DIR "/tests/data/models/"

static const import_options plain = {.memory_max = (uint64_t)256 << 20};

/* ---- importing and looking ---- */

static snell_status import_path(const char *path, const import_options *options,
                                description **out) {
    assert_int_equal(description_create(out), SNELL_OK);
    error_clear();
    snell_status status = import_file(path, NULL, options, *out);
    if (status) {
        assert_true(error_last()->text[0] != '\0');
        assert_true(error_last()->file[0] != '\0');
    }
    return status;
}

static description *load(const char *name) {
    char path[1024];
    snprintf(path, sizeof path, "%s%s", DATA, name);
    description *d;
    snell_status status = import_path(path, &plain, &d);
    if (status) print_error("%s: %s\n", name, error_last()->text);
    assert_int_equal(status, SNELL_OK);
    return d;
}

static const mesh_desc *mesh_at(const description *d, size_t index) {
    assert_true(index < d->objects[CATEGORY_SHAPE].count);
    return d->objects[CATEGORY_SHAPE].items[index].desc;
}

static const uint8_t *bytes_of(const object *o, const char *name) {
    return *(const uint8_t *const *)field_of(o, name);
}

static void near(double a, double b) {
    if (!(fabs(a - b) <= 1e-5 * (1 + fabs(b)))) print_error("%.9g is not %.9g\n", a, b);
    assert_true(fabs(a - b) <= 1e-5 * (1 + fabs(b)));
}

static void near3(snell_vec3 v, double x, double y, double z) {
    near((double)v.x, x);
    near((double)v.y, y);
    near((double)v.z, z);
}

static bool has_message(const description *d, const char *part) {
    for (size_t i = 0; i < d->message_count; i++)
        if (strstr(d->messages[i].text, part)) return true;
    return false;
}

/* ---- glTF: one box, told in many ways ---- */

static void every_way_to_say_box_gives_the_same_box(void **state) {
    (void)state;
    static const char *const names[] = {
        "box_u8.gltf",          "box_u16.glb",     "box_u32.gltf",       "box_unindexed.gltf",
        "box_interleaved.gltf", "box_sparse.gltf", "box_normalized.gltf"};
    for (size_t n = 0; n < sizeof names / sizeof names[0]; n++) {
        description *d = load(names[n]);
        const mesh_desc *m = mesh_at(d, 0);
        assert_int_equal(mesh_triangle_count(m), 12);
        assert_int_equal(d->instance_count, 1);
        bounds3 box = bounds3_empty();
        double area = 0, volume = 0;
        for (size_t t = 0; t < 12; t++) {
            bounds3 one = mesh_triangle_bounds(m, t);
            box = bounds3_union(box, one);
            dvec3 a = dvec3_from(m->positions[m->indices[3 * t]]),
                  b = dvec3_from(m->positions[m->indices[3 * t + 1]]),
                  c = dvec3_from(m->positions[m->indices[3 * t + 2]]);
            dvec3 across = dvec3_cross(dvec3_sub(b, a), dvec3_sub(c, a));
            area += dvec3_length(across) / 2;
            volume += dvec3_dot(a, dvec3_cross(b, c)) / 6;
        }
        near3(box.min, 0, 0, 0);
        near3(box.max, 1, 1, 1);
        near(area, 6);
        near(volume, 1);
        assert_true(d->is_model);
        assert_string_equal(d->format, "gltf");
        description_destroy(d);
    }
}

static void attributes_arrive(void **state) {
    (void)state;
    description *d = load("box_interleaved.gltf");
    const mesh_desc *m = mesh_at(d, 0);
    assert_int_equal(m->normals_count, 8);
    for (int i = 0; i < 8; i++) near3(m->normals[i], 0, 0, 1);
    description_destroy(d);
    d = load("box_normalized.gltf");
    m = mesh_at(d, 0);
    assert_int_equal(m->colors_count, 8);
    near3(m->colors[5], 1, 0.2, 1);
    assert_int_equal(m->alphas_count, 8);
    assert_int_equal(((const uint8_t *)m->alphas)[3], 102);
    near((double)m->uvs[1].x, 1);
    near((double)m->uvs[1].y, 1); /* glTF's v = 0 is the image's upper edge */
    near((double)m->uvs[2].y, 0);
    description_destroy(d);
}

static void strips_and_fans(void **state) {
    (void)state;
    static const uint32_t strip[] = {0, 1, 2, 1, 3, 2, 2, 3, 4},
                          fan[] = {1, 2, 0, 2, 3, 0, 3, 4, 0};
    description *d = load("strip.gltf");
    assert_int_equal(mesh_at(d, 0)->indices_count, 9);
    assert_memory_equal(mesh_at(d, 0)->indices, strip, sizeof strip);
    description_destroy(d);
    d = load("fan.gltf");
    assert_int_equal(mesh_at(d, 0)->indices_count, 9);
    assert_memory_equal(mesh_at(d, 0)->indices, fan, sizeof fan);
    description_destroy(d);
    d = load("points.gltf");
    assert_int_equal(mesh_triangle_count(mesh_at(d, 0)), 5 * 8); /* octahedra */
    description_destroy(d);
}

static void alpha_modes(void **state) {
    (void)state;
    static const uint8_t alphas[] = {255, 0, 51, 255};
    description *d = load("alpha.gltf");
    const object *opaque = &d->objects[CATEGORY_MATERIAL].items[0], *mask = opaque + 1,
                 *blend = opaque + 2;
    assert_int_equal(input_of(opaque, "alpha").texture.index1, 0);
    near((double)input_of(opaque, "alpha").value.x, 1);
    near3(input_of(opaque, "base_color").value, 0.5, 1, 1);
    near(float_of(mask, "alpha_cutoff"), 0.25);
    near(float_of(blend, "alpha_cutoff"), 0);
    near((double)input_of(blend, "alpha").value.x, 0.75);
    uint32_t twin = input_of(blend, "alpha").texture.index1,
             color = input_of(blend, "base_color").texture.index1;
    assert_int_equal(twin, input_of(mask, "alpha").texture.index1);
    assert_int_equal(color, input_of(opaque, "base_color").texture.index1);
    assert_int_equal(d->objects[CATEGORY_TEXTURE].count, 2);
    const object *t = &d->objects[CATEGORY_TEXTURE].items[twin - 1],
                 *c = &d->objects[CATEGORY_TEXTURE].items[color - 1];
    assert_memory_equal(bytes_of(t, "pixels"), alphas, 4);
    assert_int_equal(int_of(t, "encoding"), 1);
    assert_int_equal(int_of(c, "encoding"), 0);
    assert_int_equal(int_of(c, "wrap_u"), 1);
    assert_int_equal(int_of(c, "wrap_v"), 2);
    assert_int_equal(int_of(c, "filter"), 1);
    assert_int_equal(bytes_of(c, "pixels")[4], 255); /* green of the second pixel */
    description_destroy(d);
}

static void materials_become_the_models_of_this_version(void **state) {
    (void)state;
    description *d = load("materials.gltf");
    const object *metal = named(d, CATEGORY_MATERIAL, "metal"),
                 *smooth = named(d, CATEGORY_MATERIAL, "smooth"),
                 *rough = named(d, CATEGORY_MATERIAL, "rough"),
                 *glass = named(d, CATEGORY_MATERIAL, "glass"),
                 *unlit = named(d, CATEGORY_MATERIAL, "flat"),
                 *lamp = named(d, CATEGORY_MATERIAL, "lamp"),
                 *layers = named(d, CATEGORY_MATERIAL, "layers");
    assert_string_equal(metal->type->name, "principled");
    near((double)input_of(metal, "metallic").value.x, 1);
    near((double)input_of(metal, "roughness").value.x, 0.5);
    near((double)input_of(smooth, "roughness").value.x, 0.1);
    near((double)input_of(smooth, "metallic").value.x, 0);
    near(float_of(smooth, "ior"), 1.5);
    near((double)input_of(rough, "roughness").value.x, 1);
    near(float_of(glass, "ior"), 1.25);
    near(float_of(glass, "thickness"), 1);
    near((double)input_of(glass, "transmission").value.x, 1);
    near3(input_of(glass, "base_color").value, 0.5, 0.25, 1);
    near(float_of(glass, "attenuation_distance"), 2);
    near3(*(const snell_vec3 *)field_of(glass, "attenuation_color"), 0.5, 1, 0.25);
    near((double)input_of(layers, "specular").value.x, 0.5);
    near3(input_of(layers, "specular_color").value, 2, 1, 0);
    near((double)input_of(layers, "clearcoat").value.x, 0.75);
    near((double)input_of(layers, "clearcoat_roughness").value.x, 0.25);
    near3(input_of(layers, "sheen_color").value, 0, 0.5, 1);
    near((double)input_of(layers, "sheen_roughness").value.x, 0.5);
    near((double)input_of(layers, "transmission").value.x, 0.25);
    near(float_of(layers, "thickness"), 0);
    near3(input_of(unlit, "emission").value, 1, 1, 1);
    near3(input_of(unlit, "color").value, 0, 0, 0);
    near3(input_of(lamp, "emission").value, 4, 2, 0);
    assert_true(has_message(d, "KHR_materials_pearl"));
    assert_int_equal(d->message_count, 1);
    description_destroy(d);
}

static void the_node_tree_places_things(void **state) {
    (void)state;
    /* root: T(1,2,3) R(y, 90 degrees) S(2): (x, y, z) -> (1 + 2z, 2 + 2y, 3 - 2x) */
    description *d = load("nodes.gltf");
    assert_int_equal(d->instance_count, 2); /* scene 1, not scene 0 */
    assert_string_equal(d->instances[0].name, "leaf");
    assert_string_equal(d->instances[1].name, "leaf.2");
    assert_int_equal(d->instances[0].shape, d->instances[1].shape);
    dvec3 a = transform_point(&d->instances[0].to_world, (dvec3){1, 0, 0}),
          b = transform_point(&d->instances[1].to_world, (dvec3){1, 0, 0});
    near3(vec3_from(a), -1, 2, 1);
    near3(vec3_from(b), 1, 4, 1);
    assert_int_equal(d->objects[CATEGORY_CAMERA].count, 2);
    const object *flat_eye = &d->objects[CATEGORY_CAMERA].items[1];
    assert_string_equal(flat_eye->type->name, "orthographic");
    near(float_of(flat_eye, "height"), 4); /* 2 ymag, twice as large by the root */
    const object *eye = named(d, CATEGORY_CAMERA, "eye");
    near3(*(const snell_vec3 *)field_of(eye, "from"), 1, 2, 3);
    snell_vec3 at = *(const snell_vec3 *)field_of(eye, "at");
    assert_true(at.x < 0.9f); /* it looks along -x */
    near((double)at.y, 2);
    near((double)at.z, 3);
    near(float_of(eye, "fov"), 0.5);
    assert_int_equal(d->objects[CATEGORY_LIGHT].count, 3);
    const object *sun = &d->objects[CATEGORY_LIGHT].items[0], *lamp = sun + 1;
    near3(*(const snell_vec3 *)field_of(sun, "direction"), -1, 0, 0);
    near3(*(const snell_vec3 *)field_of(sun, "irradiance"), 1, 0.5, 0.25);
    near3(*(const snell_vec3 *)field_of(lamp, "position"), 1, 4, 3);
    near3(*(const snell_vec3 *)field_of(lamp, "intensity"), 2, 2, 2);
    const object *spot = lamp + 1;
    near(float_of(spot, "cone"), 3.14159265 / 4);
    near(float_of(spot, "blend"), 3.14159265 / 4);
    assert_true((*(const snell_vec3 *)field_of(spot, "at")).x < 0.9f); /* along -x, as the eye */
    description_destroy(d);
}

static void up_turns_the_whole_scene(void **state) {
    (void)state;
    import_options options = plain;
    options.up = "z";
    description *d;
    assert_int_equal(import_path(DATA "nodes.gltf", &options, &d), SNELL_OK);
    near3(*(const snell_vec3 *)field_of(named(d, CATEGORY_CAMERA, "eye"), "from"), 1, 3, -2);
    description_destroy(d);
}

static void skins_rest_and_morphs_follow_their_weights(void **state) {
    (void)state;
    description *d = load("skin.gltf");
    const mesh_desc *m = mesh_at(d, 0);
    /* joint 0: T(0,0,2); joint 1 below it: T(0,3,0) after T(0,-1,0); the mesh's node counts not */
    near3(m->positions[0], 0, 0, 2);
    near3(m->positions[1], 1, 1, 2);
    near3(m->positions[2], 0, 3, 2);
    near3(vec3_from(transform_point(&d->instances[0].to_world, (dvec3){0, 0, 0})), 0, 0, 0);
    description_destroy(d);
    d = load("morph.gltf");
    near((double)mesh_at(d, 0)->positions[0].z, 2);
    near((double)mesh_at(d, 1)->positions[0].z, 1);
    description_destroy(d);
}

/* ---- glTF: what is wrong is said with its place ---- */

#define ASSET "{\"asset\":{\"version\":\"2.0\"}"
static const struct {
    const char *json;
    snell_status status;
    const char *says;
} wrong[] = {
    {"{\"asset\":{\"version\":\"2.0\"},\n  \"nodes\": [}", SNELL_ERR_SYNTAX, "broken JSON"},
    {"[]", SNELL_ERR_SYNTAX, "must be an object"},
    {"{}", SNELL_ERR_SYNTAX, "asset: is missing"},
    {"{\"asset\":{\"version\":\"1.0\"}}", SNELL_ERR_UNSUPPORTED, "glTF 1.0 cannot be read"},
    {ASSET ",\"extensionsRequired\":[\"EXT_meshopt_compression\"]}", SNELL_ERR_UNSUPPORTED,
     "EXT_meshopt_compression"},
    {ASSET ",\"nodes\":[{\"mesh\":4}]}", SNELL_ERR_SYNTAX, "nodes[0].mesh: 4: there is no"},
    {ASSET ",\"nodes\":[{\"mesh\":-1}]}", SNELL_ERR_SYNTAX, "nodes[0].mesh"},
    {ASSET ",\"nodes\":[{\"mesh\":0.5}]}", SNELL_ERR_SYNTAX, "nodes[0].mesh: must be a whole"},
    {ASSET ",\"nodes\":[{\"children\":[1]},{\"children\":[0]}]}", SNELL_ERR_SYNTAX,
     "own descendants"},
    {ASSET ",\"nodes\":[{\"children\":[0]}]}", SNELL_ERR_SYNTAX, "its own child"},
    {ASSET ",\"nodes\":[{\"children\":[2]},{\"children\":[2]},{}]}", SNELL_ERR_SYNTAX,
     "nodes[1].children[0]"},
    {ASSET ",\"nodes\":[{\"scale\":[1,1]}]}", SNELL_ERR_SYNTAX, "nodes[0].scale: must have 3"},
    {ASSET ",\"nodes\":[{\"translation\":[1e300,0,0]}]}", SNELL_ERR_SYNTAX, "out of range"},
    {ASSET ",\"materials\":[{\"alphaMode\":\"GLASS\"}]}", SNELL_ERR_SYNTAX,
     "materials[0].alphaMode"},
    {ASSET ",\"buffers\":[{\"byteLength\":8}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":9}]}",
     SNELL_ERR_SYNTAX, "bufferViews[0]"},
    {ASSET ",\"buffers\":[{\"byteLength\":8}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":8,"
           "\"byteOffset\":9007199254740991}]}",
     SNELL_ERR_SYNTAX, "bufferViews[0]"},
    {ASSET
     ",\"buffers\":[{\"byteLength\":8}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":8}],"
     "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}]}",
     SNELL_ERR_SYNTAX, "accessors[0]"},
    {ASSET ",\"accessors\":[{\"componentType\":5126,\"count\":4000000000,\"type\":\"VEC3\"}],"
           "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
           "\"nodes\":[{\"mesh\":0}]}",
     SNELL_ERR_MEMORY, "more memory"},
    {ASSET ",\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}],"
           "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
           "\"nodes\":[{\"mesh\":0}]}",
     SNELL_ERR_SYNTAX, "meshes[0].primitives[0].attributes.POSITION"},
    {ASSET
     ",\"buffers\":[{\"byteLength\":4,\"uri\":\"data:;base64,AQEB/w==\"}],"
     "\"bufferViews\":[{\"buffer\":0,\"byteLength\":4}],\"accessors\":[{\"componentType\":5126,"
     "\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":0,\"componentType\":5121,\"count\":3,"
     "\"type\":\"SCALAR\",\"byteOffset\":1}],\"meshes\":[{\"primitives\":[{\"attributes\":"
     "{\"POSITION\":0},\"indices\":1}]}],\"nodes\":[{\"mesh\":0}]}",
     SNELL_ERR_SYNTAX, "index 255"},
    {ASSET ",\"buffers\":[{\"byteLength\":36,\"uri\":\"missing.bin\"}],"
           "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
           "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
           "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
           "\"nodes\":[{\"mesh\":0}]}",
     SNELL_ERR_IO, "buffers[0]: cannot open 'missing.bin'"},
    {ASSET ",\"buffers\":[{\"byteLength\":36,\"uri\":\"../../../../../../etc/hostname\"}],"
           "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
           "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
           "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
           "\"nodes\":[{\"mesh\":0}]}",
     SNELL_ERR_IO, "ermission"},
    {ASSET ",\"buffers\":[{\"byteLength\":36,\"uri\":\"https://example.org/a.bin\"}],"
           "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
           "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
           "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
           "\"nodes\":[{\"mesh\":0}]}",
     SNELL_ERR_UNSUPPORTED, "nothing is fetched"},
};

static char scratch[600];

static const char *write_scratch(const char *extension, const void *data, size_t size) {
    const char *folder = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : TEST_BINARY_DIR;
    snprintf(scratch, sizeof scratch, "%s/snell_test_formats_%d%s", folder, (int)getpid(),
             extension);
    FILE *f = fopen(scratch, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
    return scratch;
}

static void errors_name_the_place(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        const char *path = write_scratch(".gltf", wrong[i].json, strlen(wrong[i].json));
        description *d;
        snell_status status = import_path(path, &plain, &d);
        if (status != wrong[i].status || !strstr(error_last()->text, wrong[i].says))
            print_error("%zu: status %d, '%s' for '%s'\n", i, status, error_last()->text,
                        wrong[i].says);
        assert_int_equal(status, wrong[i].status);
        assert_non_null(strstr(error_last()->text, wrong[i].says));
        assert_string_equal(error_last()->file, path);
        if (i == 0) assert_int_equal(error_last()->line, 2);
        description_destroy(d);
    }
    unlink(scratch);
}

/* What is not shown is said, once. */
static void losses_are_said(void **state) {
    (void)state;
    static const char text[] =
        ASSET ",\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
              "{\"componentType\":5126,\"count\":1,\"type\":\"SCALAR\",\"min\":[0],\"max\":[0]},"
              "{\"componentType\":5126,\"count\":1,\"type\":\"VEC3\"}],"
              "\"textures\":[{},{}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":"
              "{\"index\":0,\"texCoord\":1}},\"normalTexture\":{\"index\":1,\"texCoord\":2},"
              "\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":1}},{"
              "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},"
              "\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":1,\"texCoord\":1}}],"
              "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0},"
              "{\"attributes\":{\"POSITION\":0},\"material\":1}]}],\"nodes\":[{\"mesh\":0}],"
              "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
              "\"translation\"}}],\"samplers\":[{\"input\":1,\"output\":2}]}]}";
    description *d;
    snell_status status = import_path(write_scratch(".gltf", text, sizeof text - 1), &plain, &d);
    if (status) print_error("%s\n", error_last()->text);
    assert_int_equal(status, SNELL_OK);
    assert_true(
        has_message(d, "the model is shown at rest; it has animations: 1 (0 s, frames 1 to 1)"));
    size_t said = 0;
    for (size_t i = 0; i < d->message_count; i++)
        said += strstr(d->messages[i].text, "three sets of texture coordinates") != NULL;
    assert_int_equal(said, 1);
    description_destroy(d);
    unlink(scratch);
}

/* ---- images ---- */

static void decode(const char *name, decoded_image *out, snell_status expected) {
    uint8_t *data;
    size_t size;
    assert_int_equal(import_read_beside(DATA "quad.obj", name, &plain, &data, &size), SNELL_OK);
    snell_status status = image_decode(data, size, IMAGE_SIZE_MAX, out);
    if (status) print_error("%s: %s\n", name, error_last()->text);
    free(data);
    assert_int_equal(status, expected);
}

static void images_are_decoded(void **state) {
    (void)state;
    decoded_image image;
    decode("textures/grey.png", &image, SNELL_OK);
    assert_true(image.width == 2 && image.height == 1 && image.channels == 1);
    assert_true(image.pixels[0] == 64 && image.pixels[1] == 192);
    assert_false(image_has_alpha(&image));
    image_free(&image);
    decode("textures/deep.png", &image, SNELL_OK);
    assert_int_equal(image.channels, 3);
    assert_true(image.pixels[0] == 255 && image.pixels[1] == 128 && image.pixels[2] == 0);
    image_free(&image);
    decode("textures/grey_alpha.png", &image, SNELL_OK);
    assert_int_equal(image.channels, 4);
    assert_true(image.pixels[0] == 100 && image.pixels[2] == 100 && image.pixels[3] == 200);
    assert_true(image_has_alpha(&image));
    image_free(&image);
#if SNELL_HAS_JPEG
    decode("textures/brown.jpg", &image, SNELL_OK);
    assert_true(image.width == 8 && image.height == 8 && image.channels == 3);
    assert_true(abs(image.pixels[0] - 200) < 4 && abs(image.pixels[1] - 100) < 4);
    image_free(&image);
    decode("textures/orange_cmyk.jpg", &image, SNELL_OK);
    assert_true(image.width == 16 && image.height == 16 && image.channels == 3);
    assert_true(image.pixels[0] > 250 && abs(image.pixels[1] - 128) < 4 && image.pixels[2] < 4);
    image_free(&image);
#else
    decode("textures/brown.jpg", &image, SNELL_ERR_UNSUPPORTED);
#endif
    assert_int_equal(image_decode("hello", 5, IMAGE_SIZE_MAX, &image), SNELL_ERR_UNSUPPORTED);
    assert_int_equal(image_decode("", 0, IMAGE_SIZE_MAX, &image), SNELL_ERR_SYNTAX);
}

/* A good PNG of 65536 x 65536 pixels but for its data: more memory would not help. */
static void sizes_of_images_are_limited(void **state) {
    (void)state;
    static const uint8_t huge[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0,    0,    0,
                                   0x0d, 'I', 'H', 'D', 'R',  0,    1,    0,    0,    0,    1,
                                   0,    0,   8,   2,   0,    0,    0,    0xe3, 0xe6, 0xa7, 0xb4,
                                   0,    0,   0,   8,   'I',  'D',  'A',  'T',  0x78, 0x9c, 0x03,
                                   0,    0,   0,   0,   1,    0x48, 0x06, 0x89, 0xd2, 0,    0,
                                   0,    0,   'I', 'E', 'N',  'D',  0xae, 0x42, 0x60, 0x82};
    decoded_image image;
    assert_int_equal(image_decode(huge, sizeof huge, IMAGE_SIZE_MAX, &image),
                     SNELL_ERR_UNSUPPORTED);
    assert_non_null(strstr(error_last()->text, "65536 x 65536 pixels is too large"));
    uint8_t copy[sizeof huge];
    memcpy(copy, huge, sizeof huge);
    copy[17] = 0; /* no columns */
    assert_int_equal(image_decode(copy, sizeof copy, IMAGE_SIZE_MAX, &image), SNELL_ERR_SYNTAX);
    assert_non_null(strstr(error_last()->text, "0 x 65536 pixels"));
    copy[17] = 1, copy[19] = 1;
    assert_int_equal(image_decode(copy, sizeof copy, IMAGE_SIZE_MAX, &image), SNELL_ERR_SYNTAX);
    assert_non_null(strstr(error_last()->text, "65537 x 65536 pixels"));
}

/* ---- OBJ, PLY, STL: more in tests/test_surfaces.c ---- */

static void obj_and_mtl(void **state) {
    (void)state;
    description *d = load("quad.obj");
    assert_string_equal(d->format, "obj");
    assert_int_equal(d->instance_count, 4);
    assert_int_equal(mesh_triangle_count(mesh_at(d, 0)), 2);
    assert_int_equal(mesh_triangle_count(mesh_at(d, 1)), 2); /* the dart, cut without overlap */
    const mesh_desc *dart = mesh_at(d, 1);
    double area = 0;
    for (size_t t = 0; t < 2; t++) {
        const uint32_t *i = dart->indices + 3 * t;
        dvec3 a = dvec3_from(dart->positions[i[0]]);
        area += dvec3_cross(dvec3_sub(dvec3_from(dart->positions[i[1]]), a),
                            dvec3_sub(dvec3_from(dart->positions[i[2]]), a))
                    .z /
                2;
    }
    near(area, 0.375);
    const object *painted = named(d, CATEGORY_MATERIAL, "painted"),
                 *shiny = named(d, CATEGORY_MATERIAL, "shiny"),
                 *clear = named(d, CATEGORY_MATERIAL, "clear");
    assert_string_equal(painted->type->name, "lambert");
    uint32_t texture = input_of(painted, "color").texture.index1;
    assert_int_equal(texture, 1);
    assert_int_equal(bytes_of(&d->objects[CATEGORY_TEXTURE].items[0], "pixels")[1], 192);
    assert_string_equal(shiny->type->name, "blinn_phong");
    near(float_of(shiny, "exponent"), 40);
    near3(input_of(shiny, "color").value, 0.2, 0.4, 0.6);
    near((double)input_of(shiny, "specular").value.x, 0.5 / 3.14159265358979);
    near((double)input_of(shiny, "alpha").value.x, 0.5);
    assert_string_equal(clear->type->name, "dielectric");
    near(float_of(clear, "ior"), 1.4);
    const object *facets = named(d, CATEGORY_MATERIAL, "facets");
    assert_string_equal(facets->type->name, "principled");
    near3(input_of(facets, "base_color").value, 0.5, 0.25, 0);
    near((double)input_of(facets, "metallic").value.x, 1);
    near((double)input_of(facets, "roughness").value.x, 0.25);
    description_destroy(d);
}

static void ply_and_stl(void **state) {
    (void)state;
    description *d = load("triangle.ply");
    const mesh_desc *m = mesh_at(d, 0);
    assert_int_equal(m->colors_count, 3);
    near3(m->colors[0], 1, 0, 0);
    assert_true(m->colors[1].y > 0.5f && m->colors[1].y < 0.51f); /* sRGB 188 */
    description_destroy(d);
    static const char *const names[] = {"triangle.stl", "binary.stl"};
    for (int i = 0; i < 2; i++) {
        d = load(names[i]);
        assert_int_equal(mesh_at(d, 0)->normals_count, 0);
        /* z is up in STL: what was at height 5 is at y = 5 */
        dvec3 p =
            transform_point(&d->instances[0].to_world, dvec3_from(mesh_at(d, 0)->positions[2]));
        near3(vec3_from(p), 0, 5, -1);
        description_destroy(d);
    }
    assert_int_equal(import_path(DATA "points.obj", &plain, &d), SNELL_ERR_SYNTAX);
    assert_non_null(strstr(error_last()->text, "no surfaces"));
    description_destroy(d);
    assert_int_equal(import_path(write_scratch(".obj", "", 0), &plain, &d), SNELL_ERR_SYNTAX);
    assert_non_null(strstr(error_last()->text, "empty"));
    description_destroy(d);
    unlink(scratch);
}

/* ---- hostile bytes ---- */

static uint8_t *read_data(const char *name, size_t *size) {
    uint8_t *data;
    assert_int_equal(import_read_beside(DATA "quad.obj", name, &plain, &data, size), SNELL_OK);
    return data;
}

/* Returns whether it loaded. */
static bool try_bytes(const char *extension, const uint8_t *data, size_t size) {
    description *d;
    snell_status status = import_path(write_scratch(extension, data, size), &plain, &d);
    assert_true(status != SNELL_ERR_INTERNAL);
    description_destroy(d);
    return status == SNELL_OK;
}

static void truncated_files_give_errors(void **state) {
    (void)state;
    static const char *const names[] = {"box_u16.glb", "alpha.gltf", "skin.gltf"};
    for (int n = 0; n < 3; n++) {
        size_t size;
        uint8_t *data = read_data(names[n], &size);
        const char *extension = strchr(names[n], '.');
        for (size_t cut = 0; cut < size - 4; cut += n == 0 ? 1 : 16)
            assert_false(try_bytes(extension, data, cut));
        assert_true(try_bytes(extension, data, size));
        free(data);
    }
    unlink(scratch);
}

static size_t mutant_count(void) { return getenv("SNELL_FULL") ? 100000 : 5000; }

static void mutants_of_gltf_do_no_harm(void **state) {
    (void)state;
    static const char *const names[] = {"box_u16.glb",    "alpha.gltf",         "skin.gltf",
                                        "nodes.gltf",     "box_sparse.gltf",    "morph.gltf",
                                        "materials.gltf", "box_normalized.gltf"};
    uint64_t seed = 88172645463325252u;
    size_t loaded = 0, total = mutant_count();
    uint8_t *data[8], *copy;
    size_t sizes[8];
    for (int i = 0; i < 8; i++) data[i] = read_data(names[i], &sizes[i]);
    for (size_t n = 0; n < total; n++) {
        size_t which = n % 8;
        copy = memory_resize(NULL, sizes[which], 1);
        assert_non_null(copy);
        memcpy(copy, data[which], sizes[which]);
        mutate(copy, sizes[which], &seed);
        loaded += try_bytes(strchr(names[which], '.'), copy, sizes[which]);
        free(copy);
    }
    for (int i = 0; i < 8; i++) free(data[i]);
    unlink(scratch);
    print_message("glTF: %zu of %zu mutants still load\n", loaded, total);
    assert_true(loaded > 0 && loaded < total);
}

static void mutants_of_images_do_no_harm(void **state) {
    (void)state;
    static const char *const names[] = {"textures/grey.png", "textures/deep.png",
                                        "textures/grey_alpha.png", "textures/brown.jpg"};
    uint64_t seed = 362436069521288629u;
    for (int n = 0; n < 4; n++) {
        size_t size;
        uint8_t *data = read_data(names[n], &size), *copy = memory_resize(NULL, size, 1);
        assert_non_null(copy);
        for (size_t i = 0; i < mutant_count(); i++) {
            decoded_image image;
            memcpy(copy, data, size);
            mutate(copy, size, &seed);
            size_t length = random_next(&seed) % 4 ? size : random_next(&seed) % size;
            if (image_decode(copy, length, 1 << 24, &image) == SNELL_OK) image_free(&image);
        }
        free(copy);
        free(data);
    }
}

/* ---- other people's files ---- */

static const char *models(void) {
    const char *folder = getenv("SNELL_MODELS");
    if (folder == NULL) folder = TEST_SOURCE_DIR "/../shared/models";
    return access(folder, R_OK) == 0 ? folder : NULL;
}

static struct {
    size_t files, loaded, refused;
    size_t good_loaded, good_refused, bad_refused, bad_warned, bad_silent, bad_unnamed;
} seen;

/* Whether a text names what a JSON pointer does, or what that is in: of /meshes/0/primitives/1/indices
 * "meshes[0].primitives[1]" is enough, and "meshes[0]". An extension is enough by its name. */
static bool names_place(const char *text, const char *pointer) {
    char path[400] = "", *parts[40], copy[400];
    size_t count = 0;
    snprintf(copy, sizeof copy, "%s", pointer);
    for (char *part = strtok(copy, "/"); part && count < 40; part = strtok(NULL, "/"))
        parts[count++] = part;
    for (size_t i = 0; i < count && strlen(path) < 300; i++) {
        bool is_index = parts[i][strspn(parts[i], "0123456789")] == '\0';
        char *end = path + strlen(path);
        snprintf(end, 100, is_index ? "[%.90s]" : i > 0 ? ".%.90s" : "%.90s", parts[i]);
        bool extension = strncmp(parts[i], "KHR_", 4) == 0 || strncmp(parts[i], "EXT_", 4) == 0;
        if (extension && strstr(text, parts[i])) return true;
        bool in_list = is_index && i > 0; /* "meshes" alone is not enough where there is a number */
        bool short_list = strcmp(parts[0], "asset") == 0 || strcmp(parts[0], "extensionsUsed") == 0;
        if ((in_list || count == 1 || short_list) && strstr(text, path)) return true;
    }
    return count == 0 || strstr(text, "broken JSON"); /* which has a line instead */
}

/* -1: no report beside the file; else how many errors the official validator finds in it. *named:
 * whether the message or the warnings of the description name the place of one of them. */
static int validator_errors(const char *path, const char *message, const description *d,
                            bool *named) {
    char report[1200];
    snprintf(report, sizeof report, "%s.report.json", path);
    json_t *root = json_load_file(report, JSON_ALLOW_NUL, NULL);
    if (root == NULL) return -1;
    const json_t *issues = json_object_get(root, "issues"),
                 *list = json_object_get(issues, "messages");
    *named = false;
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *issue = json_array_get(list, i);
        const char *pointer = json_string_value(json_object_get(issue, "pointer"));
        if (json_integer_value(json_object_get(issue, "severity")) != 0) continue;
        if (pointer == NULL) pointer = ""; /* it is about the bytes of the file */
        if (message) *named |= names_place(message, pointer);
        for (size_t k = 0; message == NULL && k < d->message_count; k++)
            *named |= names_place(d->messages[k].text, pointer);
    }
    int errors = (int)json_integer_value(json_object_get(issues, "numErrors"));
    json_decref(root);
    return errors;
}

/* The validator knows no missing errors here, and neither should we refuse: but these say that they
 * need a later glTF. */
static bool may_be_refused(const char *path) { return strstr(path, "min_version_valid") != NULL; }

static int visit(const char *path, const struct stat *st, int flag, struct FTW *ftw) {
    (void)st, (void)ftw;
    const char *dot = strrchr(path, '.');
    if (flag != FTW_F || dot == NULL || (strcmp(dot, ".gltf") != 0 && strcmp(dot, ".glb") != 0))
        return 0;
    description *d;
    snell_status status = import_path(path, &plain, &d);
    assert_true(status != SNELL_ERR_INTERNAL);
    seen.files++;
    status ? seen.refused++ : seen.loaded++;
    bool named = false;
    int errors = validator_errors(path, status ? error_last()->text : NULL, d, &named);
    if (errors == 0) {
        status ? seen.good_refused++ : seen.good_loaded++;
        if (status) print_message("refused, but valid: %s: %s\n", path, error_last()->text);
        assert_true(status == SNELL_OK || may_be_refused(path));
    }
    if (errors > 0)
        status ? seen.bad_refused++ : d->message_count ? seen.bad_warned++ : seen.bad_silent++;
    if (errors > 0 && !named) {
        print_error("%s: nothing names what the validator does: %s\n", path,
                    status             ? error_last()->text
                    : d->message_count ? d->messages[0].text
                                       : "");
        seen.bad_unnamed++;
    }
    description_destroy(d);
    return 0;
}

static void every_gltf_file_that_we_have_loads_or_says_why_not(void **state) {
    (void)state;
    const char *folder = models();
    if (folder == NULL) {
        print_message("SKIPPED: no model files (set SNELL_MODELS)\n");
        skip();
    }
    assert_int_equal(nftw(folder, visit, 16, FTW_PHYS), 0);
    print_message(
        "glTF files: %zu, loaded %zu, refused %zu\n"
        "valid by the validator: %zu load, %zu are refused; invalid: %zu are refused, %zu "
        "warned of, %zu load silently\n",
        seen.files, seen.loaded, seen.refused, seen.good_loaded, seen.good_refused,
        seen.bad_refused, seen.bad_warned, seen.bad_silent);
    assert_true(seen.files > 100);
    assert_int_equal(seen.bad_silent, 0);
    assert_int_equal(seen.bad_unnamed, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_way_to_say_box_gives_the_same_box),
        cmocka_unit_test(attributes_arrive),
        cmocka_unit_test(strips_and_fans),
        cmocka_unit_test(alpha_modes),
        cmocka_unit_test(materials_become_the_models_of_this_version),
        cmocka_unit_test(the_node_tree_places_things),
        cmocka_unit_test(up_turns_the_whole_scene),
        cmocka_unit_test(skins_rest_and_morphs_follow_their_weights),
        cmocka_unit_test(errors_name_the_place),
        cmocka_unit_test(losses_are_said),
        cmocka_unit_test(images_are_decoded),
        cmocka_unit_test(sizes_of_images_are_limited),
        cmocka_unit_test(obj_and_mtl),
        cmocka_unit_test(ply_and_stl),
        cmocka_unit_test(truncated_files_give_errors),
        cmocka_unit_test(mutants_of_gltf_do_no_harm),
        cmocka_unit_test(mutants_of_images_do_no_harm),
        cmocka_unit_test(every_gltf_file_that_we_have_loads_or_says_why_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
