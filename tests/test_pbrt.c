/* The pbrt reader: what each directive does, numbers worked out by hand, what is wrong and where; and
 * files that were damaged. test_pbrt_pictures.c looks at what is rendered. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "described.h"
#include "geometry/mesh.h"
#include "importers/importer.h"
#include "maths/functions.h"

static const import_options plain = {.memory_max = (uint64_t)256 << 20};
static char folder[256], scene_path[300];

static void write_file(const char *name, const char *text, size_t size) {
    char path[400];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static snell_status read_bytes(const char *text, size_t size, description **out) {
    write_file("scene.pbrt", text, size);
    assert_int_equal(description_create(out), SNELL_OK);
    error_clear();
    return import_file(scene_path, NULL, &plain, *out);
}

/* `text` is what stands after WorldBegin. */
static description *read_world(const char *before, const char *text) {
    char all[8192];
    snprintf(all, sizeof all, "%s\nWorldBegin\n%s", before, text);
    description *d;
    snell_status status = read_bytes(all, strlen(all), &d);
    if (status)
        print_error("%u:%u: %s\n%s\n", error_last()->line, error_last()->column, error_last()->text,
                    all);
    assert_int_equal(status, SNELL_OK);
    return d;
}

static void near_to(double a, double b, double tolerance) {
    if (!(fabs(a - b) <= tolerance * (1 + fabs(b)))) print_error("%.9g is not %.9g\n", a, b);
    assert_true(fabs(a - b) <= tolerance * (1 + fabs(b)));
}
static void near(double a, double b) { near_to(a, b, 1e-5); }

static void number_is(const object *o, const char *name, double value) {
    near((double)*(const float *)field_of(o, name), value);
}
static void near3(vec3 v, double x, double y, double z) {
    near((double)v.x, x);
    near((double)v.y, y);
    near((double)v.z, z);
}
static void vector_is(const object *o, const char *name, double x, double y, double z) {
    near3(*(const vec3 *)field_of(o, name), x, y, z);
}
static void input_is(const object *o, const char *name, double x, double y, double z) {
    near3(input_of(o, name).value, x, y, z);
}
static bool has_message(const description *d, const char *part) {
    for (size_t i = 0; i < d->message_count; i++)
        if (strstr(d->messages[i].text, part)) return true;
    return false;
}
static void warns(const description *d, const char *part) {
    if (!has_message(d, part)) print_error("nothing says: %s\n", part);
    assert_true(has_message(d, part));
}
static void is_silent(const description *d) {
    for (size_t i = 0; i < d->message_count; i++) print_error("%s\n", d->messages[i].text);
    assert_int_equal(d->message_count, 0);
}

/* ---- transforms ---- */

/* Where the unit of an instance's x axis, and its origin, are. */
static void stands(const description *d, size_t index, double x, double y, double z) {
    assert_true(index < d->instance_count);
    const transform *m = &d->instances[index].to_world;
    near3((vec3){m->m[0][3], m->m[1][3], m->m[2][3]}, x, y, z);
}

/* A sphere at pbrt's (x, y, z) is at (-x, y, z). */
static void transforms_are_those_of_the_book(void **state) {
    (void)state;
    description *d = read_world(
        "",
        "AttributeBegin Translate 1 2 3 Shape \"sphere\" AttributeEnd\n"
        "AttributeBegin Scale 2 3 4 Translate 1 1 1 Shape \"sphere\" AttributeEnd\n"
        "AttributeBegin Rotate 90 0 0 1 Translate 1 0 0 Shape \"sphere\" AttributeEnd\n"
        "AttributeBegin Translate 9 9 9 Identity Translate 5 0 0 Shape \"sphere\" AttributeEnd\n"
        "AttributeBegin Translate 1 0 0 ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 7 8 9 1]\n"
        "  Shape \"sphere\" AttributeEnd\n"
        "AttributeBegin Translate 1 0 0 Transform [1 0 0 0 0 1 0 0 0 0 1 0 7 8 9 1]\n"
        "  Shape \"sphere\" AttributeEnd\n"
        "AttributeBegin Translate 4 5 6 CoordinateSystem \"here\" AttributeEnd\n"
        "AttributeBegin CoordSysTransform \"here\" Translate 0 0 1 Shape \"sphere\" AttributeEnd\n"
        "AttributeBegin LookAt 1 2 3  1 2 9  0 1 0 Shape \"sphere\" AttributeEnd\n"
        "AttributeBegin CoordSysTransform \"camera\" Translate 0 0 2 Shape \"sphere\" "
        "AttributeEnd\n"
        "CoordSysTransform \"nowhere\"\n");
    stands(d, 0, -1, 2, 3);
    stands(d, 1, -2, 3, 4);
    stands(d, 2, 0, 1, 0); /* x turns to y */
    stands(d, 3, -5, 0, 0);
    stands(d, 4, -8, 8, 9);
    stands(d, 5, -7, 8, 9);
    stands(d, 6, -4, 5, 7);
    stands(d, 7, 1, -2, -3); /* the world's origin as a camera there sees it, flipped */
    stands(d, 8, 0, 0, 2);
    warns(d, "nowhere");
    description_destroy(d);
}

static void what_mirrors_keeps_its_outside(void **state) {
    (void)state;
    static const char triangle[] =
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]\n";
    char text[1000];
    snprintf(text, sizeof text,
             "%s AttributeBegin Scale 1 1 -1 %s AttributeEnd ReverseOrientation %s", triangle,
             triangle, triangle);
    description *d = read_world("", text);
    /* pbrt's normal is +z of the shape's space, taken to the world. */
    static const double side[] = {1, -1, -1};
    for (size_t i = 0; i < 3; i++) {
        const mesh_desc *m = object_at(d, CATEGORY_SHAPE, i, "mesh")->desc;
        dvec3 a = dvec3_from(m->positions[m->indices[0]]),
              b = dvec3_from(m->positions[m->indices[1]]),
              c = dvec3_from(m->positions[m->indices[2]]);
        near(dvec3_cross(dvec3_sub(b, a), dvec3_sub(c, a)).z, side[i]);
    }
    description_destroy(d);
    /* Normals win: these look along -z. */
    d = read_world("", "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]\n"
                       "\"normal N\" [0 0 -2 0 0 -2 0 0 -2] \"integer indices\" [0 1 2]\n");
    const mesh_desc *m = object_at(d, CATEGORY_SHAPE, 0, "mesh")->desc;
    near3(m->normals[0], 0, 0, -1);
    dvec3 a = dvec3_from(m->positions[m->indices[0]]), b = dvec3_from(m->positions[m->indices[1]]),
          c = dvec3_from(m->positions[m->indices[2]]);
    near(dvec3_cross(dvec3_sub(b, a), dvec3_sub(c, a)).z, -1);
    description_destroy(d);
}

static void what_moves_has_two_keys(void **state) {
    (void)state;
    description *d = read_world(
        "TransformTimes 0.25 0.75\nCamera \"perspective\" \"float shutteropen\" 0 \"float "
        "shutterclose\" 2",
        "ActiveTransform StartTime Translate 1 0 0 ActiveTransform EndTime Translate 3 0 0\n"
        "ActiveTransform All Translate 0 1 0 Shape \"sphere\"\n"
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]\n");
    for (size_t i = 0; i < 2; i++) {
        assert_int_equal(d->instances[i].key_count, 2);
        near((double)d->instances[i].keys[0].time, 0.25);
        near((double)d->instances[i].keys[1].time, 0.75);
        near((double)d->instances[i].keys[0].transform.m[0][3], -1);
        near((double)d->instances[i].keys[1].transform.m[0][3], -3);
        near((double)d->instances[i].keys[1].transform.m[1][3], 1);
    }
    const object *clock = description_setting(d, "animation");
    assert_non_null(clock);
    number_is(clock, "fps", 1); /* a frame is a second */
    const float *shutter = field_of(object_at(d, CATEGORY_CAMERA, 0, "perspective"), "shutter");
    near((double)shutter[0], 0);
    near((double)shutter[1], 2);
    is_silent(d);
    description_destroy(d);
}

/* ---- cameras and settings ---- */

static void cameras_see_what_pbrt_sees(void **state) {
    (void)state;
    description *d =
        read_world("LookAt 1 2 3  1 2 8  0 1 0\n"
                   "Camera \"perspective\" \"float fov\" 60 \"float lensradius\" 0.5\n"
                   "\"float focaldistance\" 7\n"
                   "Film \"rgb\" \"integer xresolution\" 400 \"integer yresolution\" 300",
                   "");
    const object *camera = object_at(d, CATEGORY_CAMERA, 0, "perspective");
    vector_is(camera, "from", -1, 2, 3);
    vector_is(camera, "at", -1, 2, 4);
    vector_is(camera, "up", 0, 1, 0);
    number_is(camera, "fov", PI / 3); /* the height is the shorter side */
    number_is(camera, "lens_radius", 0.5);
    number_is(camera, "focus", 7);
    is_silent(d);
    description_destroy(d);
    /* The width is the shorter side: tan(fov / 2) counts for it. */
    d = read_world("Camera \"perspective\" \"float fov\" 60\n"
                   "Film \"rgb\" \"integer xresolution\" 300 \"integer yresolution\" 400",
                   "");
    number_is(object_at(d, CATEGORY_CAMERA, 0, "perspective"), "fov",
              2 * atan(tan(PI / 6) * 4 / 3));
    description_destroy(d);
    d = read_world("Camera \"orthographic\" \"float screenwindow\" [-4 4 -3 3]\n"
                   "Film \"rgb\" \"integer xresolution\" 400 \"integer yresolution\" 300",
                   "");
    number_is(object_at(d, CATEGORY_CAMERA, 0, "orthographic"), "height", 6);
    is_silent(d);
    description_destroy(d);
    /* A right-handed program's file: the world stays as it is. */
    d = read_world("Scale -1 1 1 LookAt 1 2 3  1 2 8  0 1 0 Camera \"perspective\"",
                   "Translate 5 0 0 Shape \"sphere\"");
    vector_is(object_at(d, CATEGORY_CAMERA, 0, "perspective"), "from", 1, 2, 3);
    stands(d, 0, 5, 0, 0);
    description_destroy(d);
    d = read_world("Camera \"spherical\" \"string mapping\" \"equirectangular\"", "");
    vector_is(object_at(d, CATEGORY_CAMERA, 0, "panorama"), "at", -1, 0, 0);
    is_silent(d);
    description_destroy(d);
    d = read_world("Camera \"realistic\" \"string lensfile\" \"wide.dat\"", "");
    warns(d, "realistic");
    description_destroy(d);
}

static void settings_are_read(void **state) {
    (void)state;
    description *d = read_world("", "");
    const object *render = description_setting(d, "render");
    assert_int_equal(int_of(render, "width"), 1280);
    assert_int_equal(int_of(render, "height"), 720);
    assert_int_equal(int_of(render, "samples"), 16);
    assert_int_equal(int_of(render, "max_depth"), 4);
    assert_int_equal(int_of(render, "filter"), 2);
    number_is(render, "filter_radius", 1.5);
    is_silent(d);
    description_destroy(d);
    d = read_world(
        "Film \"rgb\" \"integer xresolution\" [64] \"integer yresolution\" [48] \"string "
        "filename\" \"x.exr\"\n"
        "Sampler \"stratified\" \"integer xsamples\" 3 \"integer ysamples\" 5\n"
        "Integrator \"path\" \"integer maxdepth\" 9 \"bool regularize\" true\n"
        "PixelFilter \"triangle\" \"float xradius\" 1 \"float yradius\" 1\n"
        "Accelerator \"bvh\" Option \"seed\" 3 Option \"string x\" [\"y\"]\n"
        "ColorSpace \"rec2020\"",
        "");
    render = description_setting(d, "render");
    assert_int_equal(int_of(render, "width"), 64);
    assert_int_equal(int_of(render, "samples"), 15);
    assert_int_equal(int_of(render, "max_depth"), 8);
    assert_int_equal(int_of(render, "filter"), 1);
    is_silent(d);
    description_destroy(d);
    d = read_world("Integrator \"ambientocclusion\" PixelFilter \"mitchell\"\n"
                   "Film \"rgb\" \"float cropwindow\" [0 .5 0 1]",
                   "");
    warns(d, "ambientocclusion");
    warns(d, "negative parts");
    warns(d, "--crop 640x720+0+0"); /* of 1280 x 720 */
    description_destroy(d);
}

/* ---- shapes ---- */

static void shapes_become_what_they_are(void **state) {
    (void)state;
    description *d = read_world(
        "", "Shape \"sphere\" \"float radius\" 2\n"
            "Shape \"cylinder\" \"float radius\" .5 \"float zmin\" -2 \"float zmax\" 3\n"
            "Shape \"disk\" \"float radius\" 4 \"float innerradius\" 1 \"float height\" 6\n"
            "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 3 0 2 3 0]\n"
            "Shape \"curve\" \"point3 P\" [0 0 0 0 1 0 0 2 0 0 3 0] \"float width0\" 2 \"float "
            "width1\" 1 \"string type\" \"cylinder\"\n"
            "Shape \"curve\" \"integer degree\" 2 \"point3 P\" [0 0 0 3 0 0 3 3 0]\n"
            "Shape \"sphere\" \"float zmax\" .5 \"float phimax\" 180\n");
    number_is(object_at(d, CATEGORY_SHAPE, 0, "sphere"), "radius", 2);
    const object *tube = object_at(d, CATEGORY_SHAPE, 1, "cylinder");
    assert_false(*(const bool *)field_of(tube, "capped"));
    const transform *m = &d->instances[1].to_world;
    near3(vec3_from(transform_point(m, dvec3_from(*(const vec3 *)field_of(tube, "to")))), 0, 0, 3);
    const object *disk = object_at(d, CATEGORY_SHAPE, 2, "disk");
    number_is(disk, "inner_radius", 1);
    vector_is(disk, "center", 0, 0, 6);
    const object *quad = object_at(d, CATEGORY_SHAPE, 3, "quad");
    vector_is(quad, "u", 2, 0, 0);
    vector_is(quad, "v", 0, 3, 0);
    const object *curve = object_at(d, CATEGORY_SHAPE, 4, "curves");
    const float *radii = *(const float *const *)field_of(curve, "radii");
    near((double)radii[0], 1);
    near((double)radii[3], 0.5);
    assert_int_equal(int_of(curve, "kind"), 0);
    /* The cubic of a parabola: its second point is two thirds of the way. */
    const vec3 *points =
        *(const vec3 *const *)field_of(object_at(d, CATEGORY_SHAPE, 6, "curves"), "points");
    near3(points[1], -2, 0, 0);
    near3(points[2], -3, 1, 0);
    const mesh_desc *part = object_at(d, CATEGORY_SHAPE, 5, "mesh")->desc;
    for (size_t i = 0; i < part->positions_count; i++) {
        vec3 p = part->positions[i];
        near(sqrt((double)(p.x * p.x + p.y * p.y + p.z * p.z)), 1);
        assert_true(p.z < 0.50001f && p.y > -0.00001f); /* half of it, and flipped in x alone */
    }
    is_silent(d);
    description_destroy(d);
}

static void strands_are_gathered(void **state) {
    (void)state;
    static const char hair[] =
        "Scale 2 2 2\n"
        "Shape \"curve\" \"point3 P\" [0 0 0 0 1 0 0 2 0 0 3 0]\n"
        "Shape \"curve\" \"point3 P\" [1 0 0 1 1 0 1 2 0 1 3 0]\n"
        "Material \"conductor\"\n"
        "Shape \"curve\" \"string basis\" \"bspline\" \"point3 P\" [0 0 0 0 1 "
        "0 0 2 0 0 3 0 0 4 0] \"float width0\" 1 \"float width1\" 3\n";
    char text[1000];
    snprintf(text, sizeof text, "ObjectBegin \"o\" %s ObjectEnd ObjectInstance \"o\" %s", hair,
             hair);
    description *d = read_world("", text);
    assert_int_equal(d->objects[CATEGORY_SHAPE].count, 5); /* two, the object, and two */
    const object *two = object_at(d, CATEGORY_SHAPE, 0, "curves");
    const char *at = field_of(two, "starts");
    const uint32_t *starts = *(const uint32_t *const *)(const void *)at;
    assert_int_equal(*(const size_t *)(const void *)(at + sizeof starts), 2);
    assert_int_equal(starts[1], 4);
    near3((*(const vec3 *const *)field_of(two, "points"))[5], -2, 2, 0);
    assert_true(d->instances[0].owner != NO_GROUP && d->instances[1].owner != NO_GROUP);
    assert_int_equal(d->instances[3].owner, NO_GROUP);
    /* Two pieces of a spline: its second point is where it begins, its fourth where it ends. */
    const float *radii =
        *(const float *const *)field_of(object_at(d, CATEGORY_SHAPE, 1, "curves"), "radii");
    near((double)radii[1], 1);
    near((double)radii[2], 2);
    near((double)radii[3], 3);
    is_silent(d);
    description_destroy(d);
}

/* One level: a closed tetrahedron's vertices have three neighbours, of weight 3/16. */
static void subdivision_follows_loop(void **state) {
    (void)state;
    static const char tetrahedron[] =
        "Shape \"loopsubdiv\" \"integer levels\" %d \"point3 P\" [1 1 1 1 -1 -1 -1 1 -1 -1 -1 1]\n"
        "\"integer indices\" [0 2 1 0 1 3 0 3 2 1 2 3]\n";
    char text[400];
    for (int levels = 0; levels < 4; levels++) {
        snprintf(text, sizeof text, tetrahedron, levels);
        description *d = read_world("", text);
        const mesh_desc *m = object_at(d, CATEGORY_SHAPE, 0, "mesh")->desc;
        assert_int_equal(mesh_triangle_count(m), 4 << 2 * levels);
        assert_int_equal(m->positions_count, 2 + (2 << 2 * levels)); /* Euler's formula */
        /* The first vertex goes to the limit at once: 1 / (3 + 3 / (8 * 3/16)) = 1/5 for each
         * neighbour, whose sum is -(1, 1, 1): 2/5 - 1/5. Each level has the same limit. */
        near3(m->positions[0], -0.2, 0.2, 0.2);
        description_destroy(d);
    }
    /* A lone triangle: its corners have two boundary edges, 1/5 each. */
    description *d = read_world("", "Shape \"loopsubdiv\" \"integer levels\" 0 \"point3 P\" "
                                    "[0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]");
    const mesh_desc *m = object_at(d, CATEGORY_SHAPE, 0, "mesh")->desc;
    near3(m->positions[0], -0.2, 0.2, 0);
    near3(m->positions[1], -0.6, 0.2, 0);
    description_destroy(d);
}

static void meshes_are_read_from_files(void **state) {
    (void)state;
    static const char ply[] = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                              "property float y\nproperty float z\nelement face 2\n"
                              "property list uchar int vertex_indices\nend_header\n"
                              "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
    write_file("card.ply", ply, sizeof ply - 1);
    static const char text[] =
        "WorldBegin Translate 1 2 3 Shape \"plymesh\" \"string filename\" \"card.ply\"";
    description *d;
    snell_status status = read_bytes(text, sizeof text - 1, &d);
    if (status == SNELL_ERR_UNSUPPORTED) { /* a build without a reader of PLY */
        description_destroy(d);
        skip();
    }
    assert_int_equal(status, SNELL_OK);
    const mesh_desc *m = object_at(d, CATEGORY_SHAPE, 0, "mesh")->desc;
    assert_int_equal(mesh_triangle_count(m), 2);
    assert_int_equal(m->normals_count, 0); /* pbrt makes none */
    bounds3 box = bounds3_empty();
    for (size_t i = 0; i < m->positions_count; i++) box = bounds3_add_point(box, m->positions[i]);
    near3(box.min, -2, 2, 3);
    near3(box.max, -1, 3, 3);
    description_destroy(d);
}

static void objects_are_groups(void **state) {
    (void)state;
    description *d = read_world(
        "", "ObjectBegin \"pair\" Translate 1 0 0 Shape \"sphere\" Translate 2 0 0\n"
            "Shape \"sphere\" ObjectEnd\n"
            "ObjectBegin \"none\" ObjectEnd ObjectInstance \"none\"\n"
            "Rotate 90 0 0 1 ObjectInstance \"pair\" Scale 2 2 2 ObjectInstance \"pair\"");
    assert_int_equal(d->instance_count, 4);
    assert_true(object_is_group(description_find(d, CATEGORY_SHAPE, "pair")));
    /* pbrt's (3, 0, 0) of the object turns to (0, 3, 0), twice as large (0, 6, 0). */
    static const double up[] = {3, 6};
    for (size_t i = 0; i < 2; i++) {
        const instance *part = &d->instances[1], *whole = &d->instances[2 + i];
        dvec3 p = transform_point(&part->to_world, (dvec3){0, 0, 0});
        near3(vec3_from(transform_point(&whole->to_world, p)), 0, up[i], 0);
        assert_int_equal(whole->owner, NO_GROUP);
        assert_true(part->owner != NO_GROUP);
    }
    is_silent(d);
    description_destroy(d);
}

/* ---- materials and textures ---- */

static void materials_become_the_nearest_model(void **state) {
    (void)state;
    description *d = read_world(
        "",
        "Shape \"sphere\"\n"
        "Material \"diffuse\" \"rgb reflectance\" [.1 .2 .3] Shape \"sphere\"\n"
        "Material \"dielectric\" \"spectrum eta\" \"glass-BK7\" \"float roughness\" .0625 Shape "
        "\"sphere\"\n"
        "Material \"conductor\" \"spectrum eta\" \"metal-Ag-eta\" \"spectrum k\" \"metal-Ag-k\"\n"
        "\"float roughness\" .25 \"bool remaproughness\" false Shape \"sphere\"\n"
        "Material \"coateddiffuse\" \"float thickness\" 0 \"float eta\" 1.3 Shape \"sphere\"\n"
        "Material \"conductor\" \"rgb reflectance\" [.9 .5 .1] Shape \"sphere\"\n"
        "MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\n"
        "MakeNamedMaterial \"b\" \"string type\" \"conductor\"\n"
        "Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .25 Shape "
        "\"sphere\"\n"
        "NamedMaterial \"a\" Shape \"sphere\"\n"
        "Material \"interface\" Shape \"sphere\"\n");
    const object *m = object_at(d, CATEGORY_MATERIAL, 0, "lambert");
    input_is(m, "color", 0.5, 0.5, 0.5);
    input_is(object_at(d, CATEGORY_MATERIAL, 1, "lambert"), "color", 0.1, 0.2, 0.3);
    m = object_at(d, CATEGORY_MATERIAL, 2, "dielectric");
    number_is(m, "ior", 1.5168);
    near((double)input_of(m, "roughness").value.x, 0.5); /* alpha is 1/4 = 0.5^2 */
    m = object_at(d, CATEGORY_MATERIAL, 3, "conductor");
    vector_is(m, "eta", 0.127, 0.121, 0.149);
    near((double)input_of(m, "roughness").value.x, 0.5);
    m = object_at(d, CATEGORY_MATERIAL, 4, "ggx");
    number_is(m, "ior", 1.3);
    input_is(m, "color", 0.5, 0.5, 0.5);
    m = object_at(d, CATEGORY_MATERIAL, 5, "principled");
    input_is(m, "base_color", 0.9, 0.5, 0.1);
    near((double)input_of(m, "metallic").value.x, 1);
    m = object_at(d, CATEGORY_MATERIAL, 8, "mix");
    near((double)input_of(m, "weight").value.x, 0.25);
    assert_int_equal(((const snell_material_id *)field_of(m, "b"))->index1, 8);
    assert_int_equal(d->instance_count, 8); /* nothing is where the interface is */
    assert_string_equal(d->objects[CATEGORY_MATERIAL].items[6].name, "a");
    assert_int_equal(d->instances[7].material, 6);
    is_silent(d);
    description_destroy(d);
}

static void what_is_not_supported_is_said(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {"Material \"hair\"", "hair"},
        {"Material \"measured\" \"string filename\" \"x.bsdf\"", "measured"},
        {"Material \"diffusetransmission\"", "diffuse transmission"},
        {"Material \"subsurface\" \"string name\" \"Skin1\"", "subsurface"},
        {"Material \"subsurface\" \"rgb sigma_a\" [1 1 1] \"rgb sigma_s\" [1 1 1]", "subsurface"},
        {"Material \"coatedconductor\"", "varnish"},
        {"Material \"conductor\" \"float uroughness\" .1 \"float vroughness\" .2", "anisotropic"},
        {"Texture \"t\" \"float\" \"dots\"", "dots"},
        {"Texture \"t\" \"spectrum\" \"ptex\" \"string filename\" \"x\"", "Ptex"},
        {"Texture \"t\" \"float\" \"wrinkled\"", "noise"},
        {"Texture \"t\" \"float\" \"directionmix\"", "directionmix"},
        {"Texture \"t\" \"float\" \"checkerboard\" \"string mapping\" \"planar\"", "planar"},
        {"Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"none.png\"", "none.png"},
        {"LightSource \"projection\"", "projection"},
        {"LightSource \"infinite\" \"point3 portal\" [0 0 0 1 0 0 1 1 0 0 1 0]", "portal"},
        {"MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [1 1 1]", "media"},
        {"Shape \"curve\" \"string type\" \"ribbon\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0]\n"
         "\"normal N\" [0 0 1 0 0 1]",
         "ribbons"},
        {"Shape \"sphere\" \"float radios\" 3", "'radios'"},
        {"ObjectBegin \"o\" AreaLightSource \"diffuse\" Shape \"sphere\" ObjectEnd", "objects"},
        {"WorldEnd", "WorldEnd"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        description *d = read_world("", cases[i].text);
        warns(d, cases[i].says);
        assert_int_equal(d->message_count, 1);
        assert_true(d->messages[0].line >= 3);
        assert_string_equal(d->messages[0].file, scene_path);
        description_destroy(d);
    }
}

/* A PFM picture of w x h pixels, the bottom row first. */
static void write_picture(const char *name, int w, int h, const float *pixels) {
    char bytes[4096];
    int head = snprintf(bytes, sizeof bytes, "PF\n%d %d\n-1.0\n", w, h);
    memcpy(bytes + head, pixels, (size_t)(w * h) * 12);
    write_file(name, bytes, (size_t)head + (size_t)(w * h) * 12);
}

static void textures_are_folded_placed_and_baked(void **state) {
    (void)state;
    static const float two[6] = {0.25f, 0.5f, 1, 0.5f, 0.25f, 0.125f};
    write_picture("two.pfm", 2, 1, two);
    description *d = read_world(
        "",
        "Texture \"c\" \"spectrum\" \"constant\" \"rgb value\" [.2 .4 .8]\n"
        "Texture \"h\" \"float\" \"constant\" \"float value\" .5\n"
        "Texture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"c\" \"texture scale\" \"h\"\n"
        "Texture \"m\" \"spectrum\" \"mix\" \"texture tex1\" \"c\" \"rgb tex2\" [1 1 1] \"float "
        "amount\" .25\n"
        "Texture \"i\" \"spectrum\" \"imagemap\" \"string filename\" \"two.pfm\" \"float uscale\" "
        "3\n"
        "\"float vdelta\" .5 \"string wrap\" \"clamp\" \"string filter\" \"point\" \"float scale\" "
        "2\n"
        "Texture \"k\" \"spectrum\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 4 \"rgb "
        "tex1\" [1 0 0]\n"
        "Texture \"n\" \"float\" \"imagemap\" \"string filename\" \"two.pfm\" \"bool invert\" "
        "true\n"
        "Texture \"b\" \"spectrum\" \"scale\" \"texture tex\" \"k\" \"texture scale\" \"n\"\n"
        "Material \"diffuse\" \"texture reflectance\" \"s\" Shape \"sphere\"\n"
        "Material \"diffuse\" \"texture reflectance\" \"m\" Shape \"sphere\"\n"
        "Material \"diffuse\" \"texture reflectance\" \"i\" Shape \"sphere\"\n"
        "Material \"diffuse\" \"texture reflectance\" \"k\" Shape \"sphere\"\n"
        "Material \"diffuse\" \"texture reflectance\" \"b\" Shape \"sphere\"\n"
        "Material \"conductor\" \"texture roughness\" \"n\" Shape \"sphere\"\n"
        "Material \"diffuse\" \"texture displacement\" \"n\" \"string normalmap\" \"two.pfm\"\n"
        "Shape \"sphere\"\n");
    input_is(object_at(d, CATEGORY_MATERIAL, 0, "lambert"), "color", 0.1, 0.2, 0.4);
    input_is(object_at(d, CATEGORY_MATERIAL, 1, "lambert"), "color", 0.4, 0.55, 0.85);
    /* Twice as bright, but not brighter than white: (.25 .5 1) and (.5 .25 .125). */
    snell_input i = input_of(object_at(d, CATEGORY_MATERIAL, 2, "lambert"), "color");
    near3(i.value, 1, 1, 1);
    const object *image = object_at(d, CATEGORY_TEXTURE, i.texture.index1 - 1, "image");
    near((double)((const float *)field_of(image, "uv_scale"))[0], 3);
    near((double)((const float *)field_of(image, "uv_offset"))[1], 0.5);
    assert_int_equal(int_of(image, "wrap_u"), 1);
    const float *twice = *(const float *const *)field_of(image, "pixels");
    near((double)twice[0], 0.5);
    near((double)twice[2], 1);
    near((double)twice[6], 0.25);
    assert_int_equal(int_of(image, "filter"), 1);
    i = input_of(object_at(d, CATEGORY_MATERIAL, 3, "lambert"), "color");
    const object *checker = object_at(d, CATEGORY_TEXTURE, i.texture.index1 - 1, "checker");
    number_is(checker, "size", 0.25);
    vector_is(checker, "color_a", 1, 0, 0);
    /* Baked: the first checker square is red, and of the left pixel 1 - mean(.25, .5, 1) is left. */
    i = input_of(object_at(d, CATEGORY_MATERIAL, 4, "lambert"), "color");
    image = object_at(d, CATEGORY_TEXTURE, i.texture.index1 - 1, "image");
    const float *pixels = *(const float *const *)field_of(image, "pixels");
    int width = int_of(image, "width"), height = int_of(image, "height");
    const float *low = pixels + 4 * ((size_t)(height - 1) * (size_t)width + (size_t)width / 4 - 1);
    near_to((double)low[0], 1 - 1.75 / 3, 0.02);
    near((double)low[1], 0);
    /* alpha is the root of the roughness, and snell's roughness the root of that. */
    i = input_of(object_at(d, CATEGORY_MATERIAL, 5, "conductor"), "roughness");
    image = object_at(d, CATEGORY_TEXTURE, i.texture.index1 - 1, "image");
    assert_int_equal(int_of(image, "width"), 2);
    pixels = *(const float *const *)field_of(image, "pixels");
    near((double)pixels[0], pow(1 - 1.75 / 3, 0.25));
    const object *relief = object_at(d, CATEGORY_MATERIAL, 6, "lambert");
    assert_true(((const snell_texture_id *)field_of(relief, "normal_map"))->index1 > 0);
    i = input_of(relief, "bump");
    image = object_at(d, CATEGORY_TEXTURE, i.texture.index1 - 1, "image");
    pixels = *(const float *const *)field_of(image, "pixels");
    near((double)pixels[4], 1 - 0.875 / 3);
    is_silent(d);
    description_destroy(d);
}

static void alpha_and_absorption_are_of_the_shape(void **state) {
    (void)state;
    description *d = read_world(
        "", "MakeNamedMedium \"ink\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 2 3] "
            "\"float scale\" 2 \"rgb sigma_s\" [0 0 0]\n"
            "Material \"dielectric\" MediumInterface \"ink\" \"\" Shape \"sphere\"\n"
            "Attribute \"shape\" \"float alpha\" .5 Attribute \"material\" \"rgb reflectance\" "
            "[1 0 0]\n"
            "Material \"diffuse\" Shape \"sphere\" Shape \"sphere\" \"float alpha\" .25\n"
            "Shape \"sphere\"\n");
    vector_is(object_at(d, CATEGORY_MATERIAL, 0, "dielectric"), "absorption", 2, 4, 6);
    const object *half = object_at(d, CATEGORY_MATERIAL, 1, "lambert");
    near((double)input_of(half, "alpha").value.x, 0.5);
    input_is(half, "color", 1, 0, 0);
    near((double)input_of(object_at(d, CATEGORY_MATERIAL, 2, "lambert"), "alpha").value.x, 0.25);
    assert_int_equal(d->instances[3].material, d->instances[1].material); /* the same again */
    is_silent(d);
    description_destroy(d);
}

/* ---- light ---- */

static double luminance(vec3 c) {
    return 0.2126 * (double)c.x + 0.7152 * (double)c.y + 0.0722 * (double)c.z;
}

static void lights_have_pbrts_photometry(void **state) {
    (void)state;
    /* Half a second at ISO 400: twice the radiance. */
    description *d = read_world(
        "Camera \"perspective\" \"float shutterclose\" .5 Film \"rgb\" \"float iso\" 400",
        "Translate 1 0 0\n"
        "LightSource \"point\" \"rgb I\" [1 2 3] \"float scale\" 5 \"point3 from\" [1 2 3]\n"
        "LightSource \"point\" \"float power\" 100\n"
        "LightSource \"spot\" \"float power\" 10 \"float coneangle\" 40 \"float conedeltaangle\" "
        "10\n"
        "LightSource \"distant\" \"float illuminance\" 7 \"point3 from\" [0 9 0] \"point3 to\" [0 "
        "0 "
        "0]\n"
        "LightSource \"infinite\" \"float illuminance\" 3\n"
        "LightSource \"infinite\" \"blackbody L\" 3000\n"
        "LightSource \"goniometric\" \"rgb I\" [4 4 4]\n"
        "AreaLightSource \"diffuse\" \"float power\" 6 \"bool twosided\" true Shape \"disk\"\n"
        "AreaLightSource \"diffuse\" \"spectrum L\" \"stdillum-D65\" Shape \"sphere\"\n"
        "AreaLightSource \"diffuse\" \"spectrum L\" [300 1 900 1] Shape \"sphere\"\n");
    const object *point = object_at(d, CATEGORY_LIGHT, 0, "point");
    vector_is(point, "intensity", 10, 20, 30);
    vector_is(point, "position", -2, 2, 3);
    double i = 2 * 100 / (4 * PI);
    vector_is(object_at(d, CATEGORY_LIGHT, 1, "point"), "intensity", i, i, i);
    i = 2 * 10 / (2 * PI * (1 - cos(PI / 6) + (cos(PI / 6) - cos(2 * PI / 9)) / 2));
    const object *spot = object_at(d, CATEGORY_LIGHT, 2, "spot");
    vector_is(spot, "intensity", i, i, i);
    number_is(spot, "cone", 2 * PI / 9);
    const object *sun = object_at(d, CATEGORY_LIGHT, 3, "directional");
    vector_is(sun, "direction", 0, -1, 0);
    vector_is(sun, "irradiance", 14, 14, 14);
    input_is(object_at(d, CATEGORY_LIGHT, 4, "environment"), "radiance", 6 / PI, 6 / PI, 6 / PI);
    vec3 warm = input_of(object_at(d, CATEGORY_LIGHT, 5, "environment"), "radiance").value;
    near_to(luminance(warm), 2, 1e-3);
    /* Planck's 3000 K is at x = 0.43693, y = 0.40407 (CIE 15). */
    near_to((double)(warm.x / warm.y), 1.7708 / 0.8443, 0.02);
    near_to((double)(warm.z / warm.y), 0.2722 / 0.8443, 0.01);
    vector_is(object_at(d, CATEGORY_LIGHT, 6, "point"), "intensity", 8, 8, 8);
    const object *lamp = object_at(d, CATEGORY_MATERIAL, 0, "lambert");
    i = 2 * 6 / (2 * PI * PI); /* over both sides of pi m^2, and pi of a diffuse emitter */
    input_is(lamp, "emission", i, i, i);
    assert_true(*(const bool *)field_of(lamp, "emit_two_sided"));
    vec3 white = input_of(object_at(d, CATEGORY_MATERIAL, 1, "lambert"), "emission").value;
    near_to((double)white.x, 2, 2e-3);
    near_to((double)white.z, 2, 2e-3);
    near_to(luminance(input_of(object_at(d, CATEGORY_MATERIAL, 2, "lambert"), "emission").value), 2,
            1e-3);
    is_silent(d);
    description_destroy(d);
}

static void lights_of_alpha_0_are_not_seen(void **state) {
    (void)state;
    description *d = read_world(
        "", "AreaLightSource \"diffuse\" \"rgb L\" [3 2 1] Attribute \"shape\" \"float alpha\" 0\n"
            "Translate 1 0 0 Shape \"sphere\" \"float radius\" 2\n"
            "Rotate 90 1 0 0 Shape \"disk\" \"float height\" 2\n"
            "Identity Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"integer "
            "indices\" [0 1 2 0 2 3]\n");
    assert_int_equal(d->instance_count, 0);
    const object *ball = object_at(d, CATEGORY_LIGHT, 0, "sphere");
    vector_is(ball, "radiance", 3, 2, 1);
    vector_is(ball, "center", -1, 0, 0);
    number_is(ball, "radius", 2);
    assert_false(*(const bool *)field_of(ball, "visible"));
    const object *plate = object_at(d, CATEGORY_LIGHT, 1, "disk");
    vector_is(plate, "center", -1, -2, 0); /* z turns to -y */
    vector_is(plate, "normal", 0, -1, 0);
    const object *quad = object_at(d, CATEGORY_LIGHT, 2, "quad");
    vec3 u = *(const vec3 *)field_of(quad, "u"), v = *(const vec3 *)field_of(quad, "v");
    near3(vec3_from(dvec3_cross(dvec3_from(u), dvec3_from(v))), 0, 0, 1);
    is_silent(d);
    description_destroy(d);
}

static void spectra_become_colours(void **state) {
    (void)state;
    write_file("half.spd", "# a comment\n300 .5\n900 .5\n", 27);
    description *d = read_world(
        "",
        "Material \"diffuse\" \"spectrum reflectance\" [300 .25 900 .25] Shape \"sphere\"\n"
        "Material \"diffuse\" \"spectrum reflectance\" [620 1 900 1] Shape \"sphere\"\n"
        "Material \"diffuse\" \"spectrum reflectance\" \"half.spd\" Shape \"sphere\"\n"
        "ColorSpace \"rec2020\" Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5] Shape "
        "\"sphere\"\n"
        "ColorSpace \"srgb\"\n"
        "Material \"conductor\" \"spectrum eta\" [300 1.5 900 1.5] \"spectrum k\" [300 2 900 2] "
        "Shape \"sphere\"\n");
    vec3 c = input_of(object_at(d, CATEGORY_MATERIAL, 0, "lambert"), "color").value;
    for (int i = 0; i < 3; i++) near_to((double)((const float *)&c)[i], 0.25, 1e-3);
    c = input_of(object_at(d, CATEGORY_MATERIAL, 1, "lambert"), "color").value;
    assert_true(c.x > 0.4f && c.y < 0.1f && c.z < 0.1f); /* red */
    c = input_of(object_at(d, CATEGORY_MATERIAL, 2, "lambert"), "color").value;
    near_to((double)c.y, 0.5, 1e-3);
    c = input_of(object_at(d, CATEGORY_MATERIAL, 3, "lambert"), "color").value;
    near_to((double)c.x, 0.5, 1e-4);
    near_to((double)c.z, 0.5, 1e-4);
    vec3 k = *(const vec3 *)field_of(object_at(d, CATEGORY_MATERIAL, 4, "conductor"), "k");
    near_to((double)k.x, 2, 2e-3);
    is_silent(d);
    description_destroy(d);
}

/* ---- text ---- */

static void text_is_free_in_its_form(void **state) {
    (void)state;
    write_file("part.pbrt", "Translate 1 0 0 Shape \"sphere\" # no end of line", 48);
    description *d = read_world(
        "Film\"rgb\"\"integer xresolution\"[ 10 ]\"integer yresolution\"20#comment",
        "Attribute \"shape\" \"float radius\" [ 3 ]\n"
        "Shape \"sphere\" \"float radius\" 1 # the later counts\n \"float radius\" 2\n"
        "Shape\"sphere\"\n"
        "Import \"part.pbrt\" Shape \"sphere\"\n" /* which leaves the transform as it was */
        "Include \"part.pbrt\" Shape \"sphere\"\n"
        "MakeNamedMaterial \"a \\\"b\\\\\" \"string type\" \"diffuse\" NamedMaterial \"a "
        "\\\"b\\\\\" "
        "Shape \"sphere\"");
    assert_int_equal(int_of(description_setting(d, "render"), "width"), 10);
    assert_int_equal(int_of(description_setting(d, "render"), "height"), 20);
    number_is(object_at(d, CATEGORY_SHAPE, 0, "sphere"), "radius", 2);
    number_is(object_at(d, CATEGORY_SHAPE, 1, "sphere"), "radius", 3);
    static const double x[] = {0, 0, -1, 0, -1, -1, -1};
    for (size_t i = 0; i < 7; i++) stands(d, i, x[i], 0, 0);
    is_silent(d);
    description_destroy(d);
}

static void what_is_wrong_is_said_with_its_place(void **state) {
    (void)state;
    static const struct {
        const char *text;
        unsigned line, column;
        const char *says;
    } cases[] = {
        {"", 1, 1, "no WorldBegin"},
        {"WorldBegin\n Shap \"sphere\"", 2, 2, "unknown directive 'Shap'"},
        {"WorldBegin\nShape \"spere\"", 2, 1, "unknown shape 'spere'"},
        {"WorldBegin\nShape \"sphere\" \"float radius\" [1", 2, 33, "does not end"},
        {"WorldBegin\nShape \"sphere\" \"float radius\" [1 \"x\"]", 2, 34, "needs numbers"},
        {"WorldBegin\nShape \"sphere\" \"float radius\" [1 2]", 2, 16, "needs 1 value, not 2"},
        {"WorldBegin\nShape \"sphere\" \"string radius\" \"x\"", 2, 16, "is a float"},
        {"WorldBegin\nShape \"sphere\" \"flat radius\" 1", 2, 16, "unknown type 'flat'"},
        {"WorldBegin\nShape \"sphere\" \"point P\" [1 2 3]", 2, 16, "older pbrt"},
        {"WorldBegin\nShape \"sphere\" \"radius\" 1", 2, 16, "needs a type and a name"},
        {"WorldBegin\nMakeNamedMaterial \"m\" \"type\" \"x\"", 2, 23, "needs a type and a name"},
        {"WorldBegin\nShape \"sphere\n", 2, 7, "does not end on its line"},
        {"WorldBegin\nShape \"a\\q\"", 2, 10, "no character"},
        {"WorldBegin\nTranslate 1 2 x", 2, 15, "needs a number here"},
        {"WorldBegin\nTranslate 1 2", 2, 14, "the file ends"},
        {"WorldBegin\nScale 1 0 1", 2, 1, "by 0"},
        {"WorldBegin\nTransform [1 2 3]", 2, 17, "needs a number"},
        {"WorldBegin\nTransform [1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1]", 2, 1, "affine"},
        {"WorldBegin\nAttributeEnd", 2, 1, "without a 'AttributeBegin'"},
        {"WorldBegin\n\nAttributeBegin", 3, 1, "does not end"},
        {"WorldBegin\nObjectBegin \"a\"\nAttributeEnd", 3, 1, "ObjectBegin"},
        {"WorldBegin\nObjectInstance \"a\"", 2, 16, "no object is called"},
        {"WorldBegin\nNamedMaterial \"a\"", 2, 15, "no material is called"},
        {"WorldBegin\nMaterial \"difuse\"", 2, 1, "unknown material"},
        {"WorldBegin\nMaterial \"diffuse\" \"texture reflectance\" \"t\"", 2, 20,
         "no spectrum texture"},
        {"WorldBegin\nMaterial \"diffuse\" \"rgb reflectance\" [1 2 3]", 2, 20, "a fraction"},
        {"WorldBegin\nMaterial \"diffuse\" \"spectrum reflectance\" [2 1 1 1]", 2, 20, "ascend"},
        {"WorldBegin\nMaterial \"diffuse\" \"spectrum reflectance\" \"none.spd\"", 2, 20,
         "cannot open"},
        {"WorldBegin\nCamera \"perspective\"", 2, 1, "before WorldBegin"},
        {"Shape \"sphere\"\nWorldBegin", 1, 1, "after WorldBegin"},
        {"Camera \"perspective\" \"float fov\" 180\nWorldBegin", 1, 1, "'fov'"},
        {"Camera \"perspective\" \"float shutterclose\" 0\nWorldBegin", 1, 1, "shutter"},
        {"Film \"rgb\" \"integer xresolution\" 0\nWorldBegin", 1, 1, "pixels"},
        {"Film \"rgb\" \"integer xresolution\" 1.5\nWorldBegin", 1, 34, "whole number"},
        {"WorldBegin\nShape \"trianglemesh\" \"point3 P\" [0 0 0] \"integer indices\" [0 0 1]", 2,
         1, "index 1 of 1"},
        {"WorldBegin\nInclude \"none.pbrt\"", 2, 9, "cannot open"},
        {"WorldBegin\nInclude \"scene.pbrt\"", 1, 1, "before WorldBegin"},
        {"Include \"scene.pbrt\"", 1, 9, "too many files"},
        {"WorldBegin\nShape \"plymesh\" \"string filename\" \"a.ply.gz\"", 2, 17, "compressed"},
        {"WorldBegin\nTexture \"t\" \"float\" \"woven\"", 2, 1, "unknown texture"},
        {"WorldBegin\nTexture \"t\" \"colour\" \"constant\"", 2, 13, "\"float\" or \"spectrum\""},
        {"WorldBegin\nLightSource \"sky\"", 2, 1, "unknown light"},
        {"WorldBegin\n[", 2, 1, "a directive"},
        {"\x1f\x8b\x08", 0, 0, "compressed"},
        {"\xff\xfe", 0, 0, "UTF-16"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        description *d;
        assert_int_equal(read_bytes(cases[i].text, strlen(cases[i].text), &d) == SNELL_OK, false);
        const snell_message *e = error_last();
        if (e->line != cases[i].line || e->column != cases[i].column ||
            !strstr(e->text, cases[i].says))
            print_error("%s\n  gives %u:%u: %s\n", cases[i].text, e->line, e->column, e->text);
        assert_int_equal(e->line, cases[i].line);
        assert_int_equal(e->column, cases[i].column);
        assert_non_null(strstr(e->text, cases[i].says));
        assert_string_equal(e->file, scene_path);
        description_destroy(d);
    }
    /* Of an included file the error is in that. */
    write_file("bad.pbrt", "\nShape \"none\"", 13);
    description *d;
    static const char text[] = "WorldBegin\n\n\nInclude \"bad.pbrt\"";
    assert_int_equal(read_bytes(text, sizeof text - 1, &d), SNELL_ERR_SYNTAX);
    assert_int_equal(error_last()->line, 2);
    assert_non_null(strstr(error_last()->file, "bad.pbrt"));
    description_destroy(d);
}

/* Bytes changed, words put in, the end cut off: an error or a scene. */
static void damaged_files_do_no_harm(void **state) {
    (void)state;
    static const char seed[] =
        "LookAt 0 1 -5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 40\n"
        "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\nWorldBegin\n"
        "LightSource \"infinite\" \"blackbody L\" 5000\nLightSource \"spot\" \"float power\" 5\n"
        "Texture \"c\" \"float\" \"checkerboard\" \"float tex1\" .5\n"
        "Texture \"r\" \"float\" \"bilerp\" \"float v00\" .5\n"
        "Texture \"m\" \"spectrum\" \"mix\" \"rgb tex2\" [.1 .2 .3] \"texture amount\" \"r\"\n"
        "AttributeBegin Rotate 30 1 2 3 Scale 1 2 1 AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n"
        "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 3 0 2 3 0] AttributeEnd\n"
        "Material \"diffuse\" \"texture reflectance\" \"m\" Shape \"disk\" \"float phimax\" 90\n"
        "Material \"dielectric\" \"float roughness\" .1 ReverseOrientation\n"
        "Shape \"loopsubdiv\" \"integer levels\" 2 \"point3 P\" [1 1 1 1 -1 -1 -1 1 -1 -1 -1 1]\n"
        "\"integer indices\" [0 2 1 0 1 3 0 3 2 1 2 3]\n"
        "ObjectBegin \"o\" Shape \"curve\" \"point3 P\" [0 0 0 0 1 0 0 2 0 0 3 0] ObjectEnd\n"
        "ActiveTransform EndTime Translate 1 0 0 ObjectInstance \"o\" Shape \"sphere\"\n";
    static const char *const words[] = {"-1", "0 ", "1e38", "99999999999",
                                        "\"", "[",  "]",    "WorldBegin"};
    size_t total = getenv("SNELL_FULL") ? 100000 : 10000;
    uint64_t random = 11;
    size_t good = 0;
    int file = memfd_create("pbrt", 0);
    char path[64];
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    for (size_t i = 0; i < total; i++) {
        char text[sizeof seed];
        memcpy(text, seed, sizeof seed);
        size_t size = sizeof seed - 1;
        for (size_t k = 0; k < 1 + i % 4; k++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            size_t at = (size_t)(random >> 33) % size;
            const char *word = words[(random >> 20) % 8];
            if (random >> 60 == 0) {
                text[at] = (char)(random >> 24);
            } else if (random >> 62) { /* most change a number */
                while (at + 1 < size && !(text[at] >= '0' && text[at] <= '9')) at++;
                text[at] = (char)('0' + (random >> 24) % 10);
            } else if (at + strlen(word) <= size) {
                memcpy(text + at, word, strlen(word));
            }
        }
        if (i % 8 == 0) size = (size_t)(random >> 40) % size;
        description *d;
        assert_int_equal(ftruncate(file, 0), 0);
        assert_true(pwrite(file, text, size, 0) == (ssize_t)size);
        assert_int_equal(description_create(&d), SNELL_OK);
        error_clear();
        snell_status status = import_file(path, "pbrt", &plain, d);
        assert_true(status != SNELL_ERR_INTERNAL);
        if (status) assert_true(error_last()->text[0] && error_last()->file[0]);
        good += status == SNELL_OK;
        description_destroy(d);
    }
    close(file);
    print_message("%zu of %zu mutants still load\n", good, total);
    assert_in_range(good, total / 50, total - total / 50);
}

int main(void) {
    snprintf(folder, sizeof folder, "%s/snell_test_pbrt_%d",
             getenv("TMPDIR") ? getenv("TMPDIR") : "/tmp", (int)getpid());
    if (mkdir(folder, 0700)) return 1;
    snprintf(scene_path, sizeof scene_path, "%s/scene.pbrt", folder);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(transforms_are_those_of_the_book),
        cmocka_unit_test(what_mirrors_keeps_its_outside),
        cmocka_unit_test(what_moves_has_two_keys),
        cmocka_unit_test(cameras_see_what_pbrt_sees),
        cmocka_unit_test(settings_are_read),
        cmocka_unit_test(shapes_become_what_they_are),
        cmocka_unit_test(strands_are_gathered),
        cmocka_unit_test(subdivision_follows_loop),
        cmocka_unit_test(meshes_are_read_from_files),
        cmocka_unit_test(objects_are_groups),
        cmocka_unit_test(materials_become_the_nearest_model),
        cmocka_unit_test(what_is_not_supported_is_said),
        cmocka_unit_test(textures_are_folded_placed_and_baked),
        cmocka_unit_test(alpha_and_absorption_are_of_the_shape),
        cmocka_unit_test(lights_have_pbrts_photometry),
        cmocka_unit_test(lights_of_alpha_0_are_not_seen),
        cmocka_unit_test(spectra_become_colours),
        cmocka_unit_test(text_is_free_in_its_form),
        cmocka_unit_test(what_is_wrong_is_said_with_its_place),
        cmocka_unit_test(damaged_files_do_no_harm),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    static const char *const names[] = {"scene.pbrt", "part.pbrt", "bad.pbrt",
                                        "card.ply",   "two.pfm",   "half.spd"};
    char path[400];
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        unlink(path);
    }
    rmdir(folder);
    return failed;
}
