/* The readers of PLY, STL and OBJ: dialects, what becomes of materials, what is wrong and where, mutants. */
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
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"
#include "cpu_time.h"
#include "described.h"
#include "image/srgb.h"
#include "geometry/mesh.h"
#include "importers/files.h"
#include "importers/number.h"
#include "importers/surfaces.h"
#include "mutants.h"

static const import_options plain = {.memory_max = (uint64_t)512 << 20};

/* ---- a folder of its own, for models and what they name ---- */

static char folder[500];

static int set_up(void **state) {
    (void)state;
    snprintf(folder, sizeof folder, "%s/snell_test_surfaces_%d",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : TEST_BINARY_DIR, (int)getpid());
    return mkdir(folder, 0700);
}

static int remove_one(const char *path, const struct stat *st, int flag, struct FTW *ftw) {
    (void)st, (void)flag, (void)ftw;
    return remove(path);
}

static int tear_down(void **state) {
    (void)state;
    return nftw(folder, remove_one, 8, FTW_DEPTH | FTW_PHYS);
}

static const char *path_of(const char *name) {
    static char path[600];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static void put_bytes(const char *name, const void *data, size_t size) {
    FILE *f = fopen(path_of(name), "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
}

static void put(const char *name, const char *text) { put_bytes(name, text, strlen(text)); }

static snell_status read_model(const char *name, description **d) {
    assert_int_equal(description_create(d), SNELL_OK);
    error_clear();
    snell_status status = import_file(path_of(name), NULL, &plain, *d);
    assert_true(status != SNELL_ERR_INTERNAL);
    if (status) assert_true(error_last()->text[0] && error_last()->file[0]);
    if (!status) assert_true((*d)->instance_count > 0);
    return status;
}

static description *load(const char *name) {
    description *d;
    snell_status status = read_model(name, &d);
    if (status) print_error("%s: %s\n", name, error_last()->text);
    assert_int_equal(status, SNELL_OK);
    return d;
}

static description *load_text(const char *name, const char *text) {
    put(name, text);
    return load(name);
}

static void refused(const char *name, const char *text, uint32_t line, uint32_t column,
                    const char *says) {
    description *d;
    put(name, text);
    snell_status status = read_model(name, &d);
    if (status != SNELL_ERR_SYNTAX || strstr(error_last()->text, says) == NULL ||
        error_last()->line != line || error_last()->column != column)
        print_error("%s: status %d, %u:%u '%s' for %u:%u '%s'\n", text, status, error_last()->line,
                    error_last()->column, error_last()->text, line, column, says);
    assert_int_equal(status, SNELL_ERR_SYNTAX);
    assert_non_null(strstr(error_last()->text, says));
    assert_int_equal(error_last()->line, line);
    assert_int_equal(error_last()->column, column);
    description_destroy(d);
}

/* ---- looking ---- */

static const mesh_desc *mesh_at(const description *d, size_t index) {
    assert_true(index < d->objects[CATEGORY_SHAPE].count);
    return d->objects[CATEGORY_SHAPE].items[index].desc;
}

static const object *material_of(const description *d, const char *name) {
    const object *o = description_find(d, CATEGORY_MATERIAL, name);
    if (o == NULL) print_error("no material is called %s\n", name);
    assert_non_null(o);
    return o;
}

static const object *texture_of(const description *d, uint32_t index1) {
    assert_true(index1 >= 1 && index1 <= d->objects[CATEGORY_TEXTURE].count);
    return &d->objects[CATEGORY_TEXTURE].items[index1 - 1];
}

static bool has_message(const description *d, const char *part) {
    for (size_t i = 0; i < d->message_count; i++)
        if (strstr(d->messages[i].text, part)) return true;
    for (size_t i = 0; i < d->message_count; i++) print_error("said: %s\n", d->messages[i].text);
    return false;
}

static void near(double a, double b) {
    if (!(fabs(a - b) <= 1e-6 * (1 + fabs(b)))) print_error("%.9g is not %.9g\n", a, b);
    assert_true(fabs(a - b) <= 1e-6 * (1 + fabs(b)));
}

static void near3(snell_vec3 v, double x, double y, double z) {
    near((double)v.x, x);
    near((double)v.y, y);
    near((double)v.z, z);
}

static double area_of(const mesh_desc *m) {
    double sum = 0;
    for (size_t t = 0; t < mesh_triangle_count(m); t++) {
        const uint32_t *i = m->indices + 3 * t;
        dvec3 a = dvec3_from(m->positions[i[0]]);
        dvec3 n = dvec3_cross(dvec3_sub(dvec3_from(m->positions[i[1]]), a),
                              dvec3_sub(dvec3_from(m->positions[i[2]]), a));
        sum += dvec3_length(n) / 2;
    }
    return sum;
}

static void copy_texture(const char *name, const char *as) {
    uint8_t *data;
    size_t size;
    assert_int_equal(import_read_beside(TEST_SOURCE_DIR "/tests/data/models/quad.obj", name, &plain,
                                        &data, &size),
                     SNELL_OK);
    put_bytes(as, data, size);
    free(data);
}

/* ---- numbers ---- */

static void check_number(const char *text) {
    float ours = 0;
    char *end;
    float theirs = strtof(text, &end);
    const char *rest = number_read(text, &ours);
    if (rest != end || memcmp(&ours, &theirs, sizeof ours) != 0)
        print_error("'%s': %a, not %a\n", text, (double)ours, (double)theirs);
    assert_ptr_equal(rest, end);
    assert_memory_equal(&ours, &theirs, sizeof ours);
}

static float random_float(uint64_t *seed) {
    uint32_t bits = (uint32_t)(random_next(seed) >> 32);
    float f;
    memcpy(&f, &bits, sizeof f);
    return isfinite(f) ? f : 1;
}

/* Printed floats, ties between two floats and near them, many digits, large exponents. */
static void numbers_are_correctly_rounded(void **state) {
    (void)state;
    uint64_t seed = 88172645463325252u;
    size_t total = getenv("SNELL_FULL") ? 50000000 : 2000000;
    char text[80];
    for (size_t i = 0; i < total; i++) {
        float f = random_float(&seed), g = nextafterf(f, 1e30f);
        double middle = ((double)f + (double)g) / 2;
        switch (i % 5) {
        case 0:
            snprintf(text, sizeof text, "%.*e", (int)(random_next(&seed) % 12), (double)f);
            break;
        case 1:
            snprintf(text, sizeof text, "%.*f", (int)(random_next(&seed) % 9),
                     (double)(int64_t)random_next(&seed) * 0x1p-60);
            break;
        case 2:
            snprintf(text, sizeof text, "%llu.%llue%d",
                     (unsigned long long)(random_next(&seed) >> (random_next(&seed) % 64)),
                     (unsigned long long)(random_next(&seed) >> (random_next(&seed) % 64)),
                     (int)(random_next(&seed) % 90) - 50);
            break;
        case 3:
            snprintf(text, sizeof text, "%.*g", (int)(8 + random_next(&seed) % 20), middle);
            break;
        default:
            f = (float)(random_next(&seed) >> 40) * 0x1p-20f;
            snprintf(text, sizeof text, "%.17g", ((double)f + (double)nextafterf(f, 1e30f)) / 2);
        }
        check_number(text);
    }
    static const char *const odd[] = {"0",
                                      "-0",
                                      "+1",
                                      ".5",
                                      "-.5",
                                      "5.",
                                      "1e5",
                                      "1E+05",
                                      "1e",
                                      "1e+",
                                      "000000000000000000000000000000001.5",
                                      "1e400",
                                      "-1e400",
                                      "1e-400",
                                      "16777217",
                                      "3.4028235677973366e38",
                                      "7.1e-46"};
    for (size_t i = 0; i < sizeof odd / sizeof odd[0]; i++) check_number(odd[i]);
    static const char *const none[] = {"", "-", ".", "nan", "inf", "e5", "-.", "+e1"};
    float unused;
    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++)
        assert_null(number_read(none[i], &unused));
}

/* ---- PLY ---- */

#define PLY(format, vertices, faces) "ply\nformat " format " 1.0\n" vertices faces "end_header\n"
#define XYZ(n) "element vertex " #n "\nproperty float x\nproperty float y\nproperty float z\n"
#define FACES(n) "element face " #n "\nproperty list uchar int vertex_indices\n"

/* A square and what else a vertex may have, in each encoding and every type. */
static size_t write_square(char *out, int type, int format) {
    static const char *const types[] = {"char", "uint8",  "int16", "ushort",
                                        "int",  "uint32", "float", "float64"};
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    static const int sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    size_t used = (size_t)sprintf(
        out,
        "ply\r\nformat %s 1.0\r\ncomment a square\r\nelement strange 2\r\nproperty list uchar %s "
        "things\r\nelement vertex 4\r\nproperty %s nx\r\nproperty %s ny\r\nproperty %s z\r\n"
        "property %s y\r\nproperty %s nz\r\nproperty %s x\r\nproperty %s t\r\nproperty %s s\r\n"
        "element face 1\r\nproperty %s quality\r\nproperty list %s %s vertex_index\r\n"
        "end_header\r\n",
        formats[format], types[type], types[type], types[type], types[type], types[type],
        types[type], types[type], types[type], types[type], types[type], types[type < 6 ? type : 4],
        types[type < 6 ? type : 4]);
    static const double rows[] = {/* strange: */ 2,
                                  7,
                                  8,
                                  0,
                                  /* nx ny z y nz x t s */ 0,
                                  0,
                                  5,
                                  0,
                                  1,
                                  0,
                                  0,
                                  0,
                                  0,
                                  0,
                                  5,
                                  0,
                                  1,
                                  2,
                                  0,
                                  1,
                                  0,
                                  0,
                                  5,
                                  3,
                                  1,
                                  2,
                                  1,
                                  1,
                                  0,
                                  0,
                                  5,
                                  3,
                                  1,
                                  0,
                                  1,
                                  0,
                                  /* face: */ 9,
                                  4,
                                  0,
                                  1,
                                  2,
                                  3};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        bool is_count = i == 0 || i == 3;
        int kind = is_count ? 1 : i >= 37 && type >= 6 ? 4 : type, size = sizes[kind];
        union {
            int8_t a;
            uint8_t b;
            int16_t c;
            uint16_t d;
            int32_t e;
            uint32_t f;
            float g;
            double h;
            char bytes[8];
        } v;
        switch (kind) {
        case 0: v.a = (int8_t)rows[i]; break;
        case 1: v.b = (uint8_t)rows[i]; break;
        case 2: v.c = (int16_t)rows[i]; break;
        case 3: v.d = (uint16_t)rows[i]; break;
        case 4: v.e = (int32_t)rows[i]; break;
        case 5: v.f = (uint32_t)rows[i]; break;
        case 6: v.g = (float)rows[i]; break;
        default: v.h = rows[i];
        }
        if (format == 0)
            used += (size_t)sprintf(out + used, "%g%c", rows[i], i % 7 ? ' ' : '\n');
        else
            for (int k = 0; k < size; k++) out[used++] = v.bytes[format == 1 ? k : size - 1 - k];
    }
    return used;
}

static void ply_has_every_type_and_encoding(void **state) {
    (void)state;
    for (int type = 0; type < 8; type++)
        for (int format = 0; format < 3; format++) {
            char file[2000];
            put_bytes("square.ply", file, write_square(file, type, format));
            description *d = load("square.ply");
            const mesh_desc *m = mesh_at(d, 0);
            assert_int_equal(m->positions_count, 4);
            assert_int_equal(m->indices_count, 6);
            near(area_of(m), 6);
            near3(m->positions[2], 2, 3, 5);
            near3(m->normals[1], 0, 0, 1);
            near((double)m->uvs[2].x, 1);
            near((double)m->uvs[3].y, 1);
            near((double)m->uvs[3].x, 0);
            assert_true(has_message(d, "not used: element strange, quality of face"));
            description_destroy(d);
        }
}

static void ply_strips_colors_and_smoothness(void **state) {
    (void)state;
    description *d =
        load_text("strip.ply", PLY("ascii", XYZ(5),
                                   "element tristrips 1\nproperty list int int "
                                   "vertex_indices\n") "0 0 0 1 0 0 0 1 0 1 1 0 0 2 0\n"
                                                       "8 0 1 2 3 -1 2 3 4\n");
    static const uint32_t strip[] = {0, 1, 2, 2, 1, 3, 2, 3, 4};
    assert_int_equal(mesh_at(d, 0)->indices_count, 9);
    assert_memory_equal(mesh_at(d, 0)->indices, strip, sizeof strip);
    for (int i = 0; i < 5; i++) near3(mesh_at(d, 0)->normals[i], 0, 0, 1);
    description_destroy(d);
    d = load_text("colors.ply",
                  PLY("ascii",
                      XYZ(3) "property float red\nproperty float green\nproperty float blue\n"
                             "property uchar alpha\n",
                      FACES(2)) "0 0 0 1 0 0 255 1 0 0 0 0.5 0 9 0 1 0 0 0 0.25 255 3 0 1 2 2 0 1");
    near3(mesh_at(d, 0)->colors[0], 1, 0, 0);
    near((double)mesh_at(d, 0)->colors[1].y, 0.2140411);
    assert_true(has_message(d, "alpha"));
    assert_true(has_message(d, "fewer than three corners"));
    assert_int_equal(mesh_at(d, 0)->indices_count, 3);
    description_destroy(d);
}

/* As MeshLab writes textured scans: coordinates by corner, and the picture in a comment. */
static void ply_seams_and_pictures(void **state) {
    (void)state;
    copy_texture("textures/grey.png", "my grey.png");
    description *d = load_text(
        "scan.ply",
        "ply\nformat ascii 1.0\ncomment TextureFile my grey.png\n" XYZ(4) FACES(
            3) "property list uchar float texcoord\nend_header\n0 0 0 1 0 0 1 1 0 0 1 0\n"
               "3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 0 0 1 1 0 1\n4 0 1 2 3 8 .5 0 1 0 1 1 0 1\n");
    const mesh_desc *m = mesh_at(d, 0);
    assert_int_equal(m->indices_count, 12);
    assert_int_equal(m->positions_count, 5); /* 0 lies on a seam */
    near((double)m->uvs[m->indices[3]].x, 0);
    near((double)m->uvs[m->indices[6]].x, 0.5);
    near3(m->positions[m->indices[6]], 0, 0, 0);
    near((double)m->uvs[2].y, 1);
    assert_int_equal(d->message_count, 0);
    snell_input color = input_of(&d->objects[CATEGORY_MATERIAL].items[0], "color");
    assert_int_equal(int_of(texture_of(d, color.texture.index1), "width"), 2);
    description_destroy(d);
    d = load_text("bare.ply", "ply\nformat ascii 1.0\ncomment TextureFile my grey.png\n" XYZ(3)
                                  FACES(1) "end_header\n0 0 0 1 0 0 0 1 0 3 0 1 2\n");
    assert_true(has_message(d, "texture 'my grey.png': there are no coordinates"));
    assert_int_equal(d->objects[CATEGORY_TEXTURE].count, 0);
    description_destroy(d);
}

/* A roof of two slopes: its ridge is sharp, and smooth where it is flatter. */
static void faces_that_meet_under_60_degrees_are_smooth(void **state) {
    (void)state;
    static const double angles[] = {20, 59, 61, 120};
    for (int i = 0; i < 4; i++) {
        char text[1000];
        double half = angles[i] / 2 * 3.14159265358979 / 180;
        sprintf(text,
                PLY("ascii", XYZ(6), FACES(2)) "-1 %.9g 0\n-1 %.9g 1\n0 0 0\n0 0 1\n1 %.9g 0\n"
                                               "1 %.9g 1\n4 0 1 3 2\n4 2 3 5 4\n",
                -tan(half), -tan(half), -tan(half), -tan(half));
        description *d = load_text("roof.ply", text);
        const mesh_desc *m = mesh_at(d, 0);
        assert_int_equal(m->normals_count, m->positions_count);
        if (angles[i] < 60) {
            assert_int_equal(m->positions_count, 6);
            assert_true(fabs((double)m->normals[2].x) < 0.3);
        } else {
            assert_int_equal(m->positions_count, 8);
            near(fabs((double)m->normals[2].x), sin(half));
        }
        near((double)m->normals[0].x, -sin(half));
        near((double)m->normals[0].y, cos(half));
        description_destroy(d);
    }
}

/* A hundred and more triangles without area at a corner of a cube do not blur it. */
static void a_crowd_without_area_is_harmless(void **state) {
    (void)state;
    char text[8000];
    int used = snprintf(text, sizeof text,
                        PLY("ascii", XYZ(5), FACES(203)) "0 0 0 1 0 0 0 1 0 0 0 1 2 0 0\n");
    for (int i = 0; i < 200; i++) used += sprintf(text + used, "3 0 1 4\n");
    sprintf(text + used, "3 0 1 2\n3 0 2 3\n3 0 3 1\n");
    description *d = load_text("crowd.ply", text);
    const mesh_desc *m = mesh_at(d, 0);
    for (size_t i = 0; i < 9; i++) {
        snell_vec3 n = m->normals[m->indices[600 + i]];
        near3(n, i / 3 == 1, i / 3 == 2, i / 3 == 0);
    }
    description_destroy(d);
}

static void indices_of_polygons_fit_32_bits(void **state) {
    (void)state;
    uint32_t room[3];
    polygons p = {.indices = room, .index_count = UINT32_MAX - 5, .index_capacity = SIZE_MAX};
    assert_null(polygons_add(&p, 4));
    assert_int_equal(p.index_count, UINT32_MAX - 5);
}

static void what_is_wrong_in_ply_has_a_place(void **state) {
    (void)state;
    refused("a.ply", "ply\nformat ascii 2.0\n", 2, 14, "unknown version '2.0'");
    refused("a.ply", "ply\nformat ascii 1.0\nelement vertex -3\n", 3, 16, "count of an element");
    refused("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty real x\n", 4, 10,
            "unknown type 'real'");
    refused("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", 4, 1, "no end");
    refused("a.ply", PLY("ascii", XYZ(3), FACES(1)) "0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n", 11, 5,
            "vertex 2 of 3: 'zero' is no number");
    refused("a.ply", PLY("ascii", XYZ(3), FACES(1)) "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", 11, 5,
            "not a finite number");
    refused("a.ply", PLY("ascii", XYZ(3), FACES(1)) "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", 13, 7,
            "face 1 of 1: vertex 3: there are 3");
    refused("a.ply", PLY("ascii", XYZ(3), FACES(1)) "0 0 0\n1 0 0\n0 1 0\n3 0 1", 13, 6,
            "ends before face 1 of 1");
    refused("a.ply", PLY("ascii", XYZ(3), FACES(0)) "0 0 0\n1 0 0\n0 1 0\n", 0, 0, "only points");
    refused("a.ply",
            PLY("ascii", FACES(1) "property list uchar float texcoord\n",
                XYZ(4000000000)) "3 0 1 2 6 0 0 0 0 0 0\n0 0 0\n",
            13, 1, "of 4000000000 is whole");
    refused("a.ply",
            PLY("ascii", FACES(1) "property list uchar float texcoord\n",
                "element vertex 4000000000\n" XYZ(3)) "3 0 1 2 6 0 0 0 0 0 0\n0 0 0\n",
            12, 1, "it has no x, y and z");
    refused("a.ply", PLY("binary_little_endian", XYZ(4000000000), FACES(1)) "0123456789ab", 0, 0,
            "the file ends before vertex 2 of 4000000000");
    refused("a.ply", PLY("ascii", "element vertex 1\nproperty float x\n", FACES(1)) "0 3 0 0 0\n",
            8, 1, "no x, y and z");
}

/* ---- STL ---- */

#define FACET(z)                                                                                   \
    "facet normal 0 0 1\nouter loop\nvertex 0 0 " #z "\nvertex 1 0 " #z "\nvertex 0 1 " #z         \
    "\nendloop\nendfacet\n"

static size_t write_stl(char *out, const char *header, uint32_t count, const uint16_t *attributes) {
    memset(out, ' ', 80);
    memcpy(out, header, strlen(header));
    memcpy(out + 80, &count, 4);
    for (uint32_t i = 0; i < count; i++) {
        const float v[12] = {0, 0, 1, 0, 0, (float)i, 1, 0, (float)i, 0, 1, (float)i};
        memcpy(out + 84 + 50 * i, v, 48);
        memcpy(out + 84 + 50 * i + 48, &attributes[i], 2);
    }
    return 84 + 50 * (size_t)count;
}

static void stl_dialects(void **state) {
    (void)state;
    description *d =
        load_text("two.stl", "solid a thing\n" FACET(0) "endsolid a thing\r\nsolid none\n"
                                                        "endsolid none\nSOLID b\n" FACET(1)
                                                            FACET(2) "ENDSOLID");
    assert_int_equal(d->instance_count, 2);
    assert_string_equal(d->instances[0].name, "a thing");
    assert_string_equal(d->instances[1].name, "b");
    assert_int_equal(mesh_at(d, 1)->indices_count, 6);
    assert_int_equal(mesh_at(d, 1)->normals_count, 0);
    description_destroy(d);
    char file[400];
    static const uint16_t colors[] = {0x8000 | 31 << 10, 0x8000 | 31, 0, 0};
    size_t size = write_stl(file, "solid by its first word only", 3, colors);
    put_bytes("binary.stl", file, size);
    d = load("binary.stl");
    assert_int_equal(mesh_at(d, 0)->indices_count, 9);
    near3(mesh_at(d, 0)->colors[0], 1, 0, 0);
    near3(mesh_at(d, 0)->colors[4], 0, 0, 1);
    near3(mesh_at(d, 0)->colors[8], 1, 1, 1);
    description_destroy(d);
    static const uint16_t magics[] = {31, 0x8000, 31 << 5};
    put_bytes("binary.stl", file, write_stl(file, "COLOR=\xff\x01\x01\xff", 3, magics));
    d = load("binary.stl");
    near3(mesh_at(d, 0)->colors[0], 1, 0, 0);
    near((double)mesh_at(d, 0)->colors[3].x, 1);
    assert_true(mesh_at(d, 0)->colors[3].y > 0 && mesh_at(d, 0)->colors[3].y < 0.001f);
    near3(mesh_at(d, 0)->colors[6], 0, 1, 0);
    description_destroy(d);
    put_bytes("binary.stl", file, size - 1);
    assert_int_equal(read_model("binary.stl", &d), SNELL_ERR_SYNTAX);
    assert_non_null(strstr(error_last()->text, "after 2 of 3 facets"));
    description_destroy(d);
    d = load_text("a.stl", "solid cr\rfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0\r"
                           "vertex 0 1 0 endloop endfacet\rendsolid cr\r");
    assert_int_equal(mesh_at(d, 0)->indices_count, 3);
    assert_string_equal(d->instances[0].name, "cr");
    description_destroy(d);
    size = write_stl(file, "solid with spaces, and more after the facets", 3, colors);
    put_bytes("binary.stl", file, size + 7);
    d = load("binary.stl");
    assert_int_equal(mesh_at(d, 0)->indices_count, 9);
    assert_true(has_message(d, "7 bytes after the last facet"));
    description_destroy(d);
    put("a.lua", "solid = 1\nreturn\n");
    assert_int_not_equal(read_model("a.lua", &d), SNELL_OK);
    assert_null(strstr(error_last()->text, "STL"));
    description_destroy(d);
    refused("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n", 4, 12,
            "'a number' should be here, not 'x'");
    refused("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendloop\n", 3, 11,
            "a facet has three corners");
    refused("a.stl", "solid\nfacet normal 0 0 1\nvertex 0 0 0\n", 3, 1,
            "'outer loop' should be here, not 'vertex'");
    refused("a.stl", "solid\n" FACET(0), 9, 1, "ends where 'facet'");
    refused("a.stl", "solid\nendsolid\n", 0, 0, "no surfaces");
}

/* ---- OBJ ---- */

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

static void obj_dialects(void **state) {
    (void)state;
    static const char *const same[] = {
        SQUARE "f 1 2 3 4\n",
        SQUARE "f -4 -3 -2 -1",
        "f 1 2 3 4 # before its vertices\n" SQUARE,
        "v 0 0 0\r\nv 1 0 0\r\nv 1 1 \\\r\n 0\r\nv 0 1 0\r\nf 1 2 \\\r\n3 4\r\n",
        "v 0 0 0\rv 1 0 0\rv 1 1 0\rv 0 1 0\rf 1 2 3 4\r",
        "\xef\xbb\xbf" SQUARE "f 1// 2// 3// 4//\n",
        SQUARE "f 1/1/1 2/1/1 3/1/1 4/1/1\n",
        "\tv\t0 0 0 1\n  v 1 +0 -0 1\nv 1.0e0 .1e1 0.\nv 0 1 0 1.0\n g\nf 1 2 3\nf 1 3 4\n",
    };
    for (size_t i = 0; i < sizeof same / sizeof same[0]; i++) {
        description *d = load_text("square.obj", same[i]);
        const mesh_desc *m = mesh_at(d, 0);
        assert_int_equal(d->instance_count, 1);
        assert_int_equal(m->positions_count, 4);
        assert_int_equal(m->indices_count, 6);
        near(area_of(m), 1);
        for (int k = 0; k < 4; k++) near3(m->normals[k], 0, 0, 1);
        assert_int_equal(m->uvs_count, 0);
        description_destroy(d);
    }
    char wide[400];
    size_t size = 2;
    memcpy(wide, "\xff\xfe", 2);
    for (const char *c = same[0]; *c; c++) wide[size++] = *c, wide[size++] = 0;
    put_bytes("square.obj", wide, size);
    description *d = load("square.obj");
    near(area_of(mesh_at(d, 0)), 1);
    description_destroy(d);
    /* Files that end with their last page, and a byte before and after, which are not read alike. */
    for (size_t length = 4095; length <= 4097; length++) {
        char page[4100];
        memset(page, ' ', sizeof page);
        memcpy(page, SQUARE, strlen(SQUARE));
        memcpy(page + length - 9, "f 1 2 3 4", 9);
        page[length - 10] = '\n';
        put_bytes("square.obj", page, length);
        d = load("square.obj");
        near(area_of(mesh_at(d, 0)), 1);
        description_destroy(d);
    }
    d = load_text("colors.obj", "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 1 0 0.5 0\nvt 0.5 0.25\nvt 1\n"
                                "f 1/1 2/2 3/1\np 1\nl 1 2\nvw 1 2\nf 1 2\n");
    near3(mesh_at(d, 0)->colors[0], 1, 0, 0);
    near3(mesh_at(d, 0)->colors[1], 1, 1, 1);
    near((double)mesh_at(d, 0)->colors[2].y, 0.2140411);
    near((double)mesh_at(d, 0)->uvs[0].y, 0.25);
    near((double)mesh_at(d, 0)->uvs[1].x, 1);
    assert_true(has_message(d, "points and lines are not drawn"));
    assert_true(has_message(d, "not used: vw"));
    assert_true(has_message(d, "fewer than three corners"));
    description_destroy(d);
}

static void colors_beyond_1(void **state) {
    (void)state;
    description *d = load_text("c.obj", "v 0 0 0 255 128 0\nv 1 0 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
    const snell_vec3 *colors = mesh_at(d, 0)->colors;
    near3(colors[0], 1, (double)srgb_table()[128], 0);
    near3(colors[1], 1, 1, 1); /* it has none */
    near3(colors[2], 0, 0, (double)srgb_table()[1]);
    assert_true(has_message(d, "colours of vertices are taken as bytes"));
    assert_int_equal(d->messages[0].severity, SNELL_INFO);
    description_destroy(d);
    static const char *const clamped[] = {"2.5 0.5 0", "256 128 0"};
    for (int i = 0; i < 2; i++) {
        char text[200];
        snprintf(text, sizeof text, "v 0 0 0 %s\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", clamped[i]);
        d = load_text("c.obj", text);
        near((double)mesh_at(d, 0)->colors[0].x, 1);
        near((double)mesh_at(d, 0)->colors[0].y, i ? 1 : 0.2140411);
        assert_true(has_message(d, i ? "reach 256" : "reach 2.5"));
        assert_int_equal(d->messages[0].severity, SNELL_WARNING);
        description_destroy(d);
    }
}

#define MARK "\xef\xbb\xbf"
static void texts_may_begin_with_a_mark(void **state) {
    (void)state;
    static const char *const texts[] = {
        MARK SQUARE "f 1 2 3 4\n",
        MARK "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 1 0\n"
             "endloop\nendfacet\nendsolid a\n",
        MARK
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n2 "
        "0 0\n0 1 0\n3 0 1 2\n"};
    for (int i = 0; i < 3; i++) {
        description *d = load_text("marked", texts[i]); /* known by what it holds */
        near(area_of(mesh_at(d, 0)), 1);
        description_destroy(d);
    }
    refused("marked.obj", MARK "v 0 x 0\n", 1, 5, "'x' is no finite number");
    refused("marked.stl", MARK "solid\nfacett\n", 2, 1, "'facet' should be here");
    refused("marked.ply", MARK "ply x\nformat text 1.0\n", 2, 8, "unknown format 'text'");
}

static void obj_smoothing(void **state) {
    (void)state;
    static const char roof[] = "v -1 0 0\nv -1 0 1\nv 0 .2 0\nv 0 .2 1\nv 1 0 0\nv 1 0 1\n";
    static const struct {
        const char *faces;
        size_t vertices;
    } cases[] = {{"f 1 2 4 3\nf 3 4 6 5\n", 6},
                 {"s 1\nf 1 2 4 3\nf 3 4 6 5\n", 6},
                 {"s off\nf 1 2 4 3\nf 3 4 6 5\n", 8},
                 {"s 1\nf 1 2 4 3\ns 2\nf 3 4 6 5\n", 8},
                 {"vn 0 1 0\nf 1//1 2//1 4//1 3//1\nf 3 4 6 5\n", 8}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[300];
        snprintf(text, sizeof text, "%s%s", roof, cases[i].faces);
        description *d = load_text("roof.obj", text);
        size_t count = mesh_at(d, 0)->positions_count;
        assert_int_equal(mesh_at(d, 0)->normals_count, count);
        assert_true(cases[i].vertices == 6 ? count == 6 : count >= 8);
        if (cases[i].vertices == 6) assert_true(mesh_at(d, 0)->normals[2].y > 0.99f);
        if (i == 4) near3(mesh_at(d, 0)->normals[2], 0, 1, 0);
        description_destroy(d);
    }
}

/* One mesh with a slot a triangle; glass and lamps apart; objects by their names, groups where there are none. */
static void obj_objects_and_materials(void **state) {
    (void)state;
    put("m.mtl",
        "newmtl red\nKd 1 0 0\nnewmtl with blanks\nKd 0 1 0\nnewmtl glass\nillum 7\nNi 1.3\n"
        "Tf 0.25 1 1\nnewmtl lamp\nKe 5 5 5\nnewmtl unused\nmap_Kd none.png\n");
    description *d =
        load_text("o.obj", "mtllib m.mtl\n" SQUARE "g ignored\nf 1 2 3\nusemtl red\nf 1 2 3\n"
                           "usemtl with blanks\nf 1 2 3 4\nusemtl glass\nf 1 2 3\nusemtl "
                           "red\nf 2 3 4\nusemtl lamp\nf 1 2 3\nusemtl nowhere\nf 1 2 4\n");
    assert_int_equal(d->instance_count, 3);
    const mesh_desc *m = mesh_at(d, 0);
    static const uint32_t slots[] = {0, 1, 2, 2, 1, 0};
    assert_int_equal(m->material_slots_count, 6);
    assert_memory_equal(m->material_slots, slots, sizeof slots);
    assert_int_equal(m->materials_count, 3);
    const object *red = material_of(d, "red"), *glass = material_of(d, "glass");
    assert_ptr_equal(&d->objects[CATEGORY_MATERIAL].items[m->materials[1].index1 - 1], red);
    near3(input_of(material_of(d, "with blanks"), "color").value, 0, 1, 0);
    assert_string_equal(glass->type->name, "dielectric");
    near(float_of(glass, "ior"), 1.3);
    near3(input_of(glass, "color").value, 0.5, 1, 1);
    near3(input_of(material_of(d, "lamp"), "emission").value, 5, 5, 5);
    assert_null(description_find(d, CATEGORY_MATERIAL, "unused"));
    assert_true(has_message(d, "material 'nowhere' is in no library"));
    assert_int_equal(d->message_count, 1);
    description_destroy(d);
    d = load_text("o.obj", SQUARE "g left one\nf 1 2 3\ng b\nf 1 2 4\ng left one\nf 2 3 4\n");
    assert_int_equal(d->instance_count, 2);
    assert_string_equal(d->instances[0].name, "left one");
    assert_int_equal(mesh_at(d, 0)->indices_count, 6);
    description_destroy(d);
    d = load_text("o.obj", SQUARE "o a\ng x\nf 1 2 3\ng y\nf 1 2 4\no b\nf 2 3 4\n");
    assert_int_equal(d->instance_count, 2);
    assert_string_equal(d->instances[1].name, "b");
    assert_int_equal(mesh_at(d, 0)->indices_count, 6);
    description_destroy(d);
    put("two words.mtl", "newmtl a\nKd 1 1 1\n");
    d = load_text("o.obj",
                  "mtllib two words.mtl\nmtllib gone.mtl m.mtl\n" SQUARE "usemtl a\nf 1 2 3\n"
                  "usemtl red\nf 1 2 4\n");
    material_of(d, "a");
    material_of(d, "red");
    assert_true(has_message(d, "cannot open 'gone.mtl'"));
    description_destroy(d);
}

static description *load_material(const char *text) {
    put("one.mtl", text);
    return load_text("one.obj", "mtllib one.mtl\n" SQUARE "vt 0 0\nusemtl m\nf 1/1 2/1 3/1 4/1\n");
}

static void every_illumination_model(void **state) {
    (void)state;
    static const struct {
        const char *text, *type;
    } cases[] = {
        {"illum 0\nKd .2 .4 .6", "lambert"},
        {"illum 1\nKs 1 1 1\nNs 9", "lambert"},
        {"illum 2\nKs 1 1 1\nNs 9", "blinn_phong"},
        {"illum 2\nNs 9", "lambert"},
        {"Ks 1 1 1\nNs 9", "blinn_phong"},
        {"illum 3\nKd 0 0 0\nKs .8 .8 .8", "mirror"},
        {"illum 3\nKd 1 0 0\nKs .8 .8 .8", "glazed"},
        {"illum 4\nNi 1.5", "dielectric"},
        {"illum 5\nKd 1 0 0\nNi 1.5", "glazed"},
        {"illum 6\nNi 1.5", "dielectric"},
        {"illum 7\nNi 1.5\nd 0", "dielectric"},
        {"illum 8\nKs 1 1 1\nNs 9", "blinn_phong"},
        {"illum 9\nNi 1.5", "dielectric"},
        {"illum 10\nKs 1 1 1\nNs 9", "lambert"},
        {"Pr .25\nPm 1\nPc .5\nPcr .1\nPs .75", "principled"},
        {"illum 7\nPr .25", "dielectric"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[200];
        snprintf(text, sizeof text, "newmtl m\n%s\n", cases[i].text);
        description *d = load_material(text);
        const object *m = material_of(d, "m");
        if (strcmp(m->type->name, cases[i].type) != 0)
            print_error("'%s' is %s\n", cases[i].text, m->type->name);
        assert_string_equal(m->type->name, cases[i].type);
        assert_int_equal(d->message_count, 0);
        if (i == 0) near3(input_of(m, "emission").value, 0.2, 0.4, 0.6);
        if (i == 0) near3(input_of(m, "color").value, 0, 0, 0);
        if (i == 2) near((double)input_of(m, "specular").value.x, 1 / 3.14159265358979);
        if (i == 5) near((double)input_of(m, "color").value.x, 0.8);
        if (i == 6) near((double)input_of(m, "reflectance").value.x, 0.8);
        if (i == 8) near(float_of(m, "ior"), 1.5);
        if (i == 14) near((double)input_of(m, "sheen_color").value.y, 0.75);
        if (i == 14) near((double)input_of(m, "clearcoat").value.x, 0.5);
        if (i == 15) near((double)input_of(m, "roughness").value.x, 0.25);
        description_destroy(d);
    }
    description *d =
        load_material("newmtl m\nKd .5\nd 0.75\nTr 0.5\nKt 1 1 1\nKa 9 9 9\nsharpness 60\n");
    near((double)input_of(material_of(d, "m"), "alpha").value.x, 0.75);
    near3(input_of(material_of(d, "m"), "color").value, 0.5, 0.5, 0.5);
    assert_true(has_message(d, "of materials is not used: Kt, sharpness"));
    description_destroy(d);
    d = load_material("newmtl m\nTr 0.25\n");
    near((double)input_of(material_of(d, "m"), "alpha").value.x, 0.75);
    description_destroy(d);
    put("one.mtl", "newmtl m\n  Ns lots\n");
    assert_int_equal(read_model("one.obj", &d), SNELL_ERR_SYNTAX);
    assert_non_null(strstr(error_last()->file, "one.mtl"));
    assert_int_equal(error_last()->line, 2);
    assert_int_equal(error_last()->column, 6);
    description_destroy(d);
}

static void maps_and_their_options(void **state) {
    (void)state;
    copy_texture("textures/grey.png", "grey.png");
    copy_texture("textures/grey_alpha.png", "with blank.png");
    description *d = load_material(
        "newmtl m\nillum 2\nNs 20\nKd 0 0 0\nmap_Kd -s 2 3 1 -o 0.5 0.25 -clamp on "
        "C:\\art\\grey.png\n"
        "map_Ks -blendu off grey.png\nmap_Ke grey.png\nmap_d with blank.png\nbump -bm 2 grey.png\n"
        "map_Ns grey.png\ndisp grey.png\n");
    const object *m = material_of(d, "m");
    snell_input color = input_of(m, "color"), specular = input_of(m, "specular"),
                alpha = input_of(m, "alpha");
    near3(color.value, 1, 1, 1);
    const object *t = texture_of(d, color.texture.index1);
    near((double)((const snell_vec2 *)field_of(t, "uv_scale"))->y, 3);
    near((double)((const snell_vec2 *)field_of(t, "uv_offset"))->x, 0.5);
    assert_int_equal(int_of(t, "wrap_u"), 1);
    assert_int_equal(int_of(t, "encoding"), 0);
    assert_int_equal(specular.texture.index1, input_of(m, "emission").texture.index1);
    assert_int_not_equal(specular.texture.index1, color.texture.index1);
    near((double)specular.value.x, 1 / 3.14159265358979);
    assert_int_equal(int_of(texture_of(d, alpha.texture.index1), "encoding"), 1);
    assert_int_equal(((const uint8_t *)*(const void *const *)field_of(
                         texture_of(d, alpha.texture.index1), "pixels"))[0],
                     200);
    assert_true(input_of(m, "bump").texture.index1 != 0);
    near(float_of(m, "bump_scale"), 0.02 * sqrt(2));
    assert_true(has_message(d, "of materials is not used: map_Ns, disp"));
    assert_int_equal(d->message_count, 1);
    description_destroy(d);
    d = load_material("newmtl m\nPr 1\nmap_Pr -imfchan g -s -2 -o .5 grey.png\nmap_Pm "
                      "grey.png\nnorm -bm 3 grey.png\n"
                      "map_Kd gone.png\nmap_Ps -mm 0 1 grey.png\n");
    m = material_of(d, "m");
    assert_true(input_of(m, "roughness").texture.index1 && input_of(m, "metallic").texture.index1);
    t = texture_of(d, input_of(m, "roughness").texture.index1);
    const snell_vec2 *scale = field_of(t, "uv_scale"), *offset = field_of(t, "uv_offset");
    assert_true(scale->x == -2 && scale->y == 1 && offset->x == 0.5f && offset->y == 0);
    near((double)input_of(m, "metallic").value.x, 1);
    assert_true(((const snell_texture_id *)field_of(m, "normal_map"))->index1 != 0);
    near((double)input_of(m, "normal_scale").value.x, 3);
    assert_true(has_message(d, "texture 'gone.png': cannot open"));
    assert_true(has_message(d, "not used: -mm"));
    description_destroy(d);
    d = load_material("newmtl m\nmap_Kd ../secret.png\n");
    assert_true(has_message(d, "Permission denied") || has_message(d, "No such file"));
    description_destroy(d);
}

/* The whole model was refused. */
static void numbers_that_are_none_lose_their_statement(void **state) {
    (void)state;
    description *d = load_material("newmtl m\nKd 0.5 0.25 1\nKd 1 nan 1\nKs 1\nNs nan\nd -inf\nPr "
                                   "-nan(ind)\nNi 1e999\nillum inf\n");
    const object *m = material_of(d, "m");
    assert_string_equal(m->type->name, "lambert");
    near3(input_of(m, "color").value, 0.5, 0.25, 1);
    near((double)input_of(m, "alpha").value.x, 1);
    assert_int_equal(d->message_count, 1);
    assert_true(has_message(d, "of materials is not used: Kd 1 nan, Ns nan, d -inf"));
    assert_true(has_message(d, "Pr -nan(ind), Ni 1e999, illum inf"));
    description_destroy(d);
    put("bad.mtl", "newmtl m\nNs x\n");
    refused("one.obj", "mtllib bad.mtl\n" SQUARE "f 1 2 3\n", 2, 4, "this is not a number");
}

/* What some exporters write, and some people. */
static void materials_are_found(void **state) {
    (void)state;
    put("m.mtl", "newmtl red\nKd 1 0 0\nmap_Kd\nmap_Ks  \nnewmtl a #1\n");
    static const char *const same[] = {
        "mtllib m.mtl\n" SQUARE "usemtl red\nf 1 2 3\n",
        "usemtl red\n" SQUARE "f 1 2 3\nmtllib m.mtl\n",
        "mtllib m.mtl # the library\n" SQUARE "usemtl red  # the colour\nf 1 2 3\n",
        "mtllib \"m.mtl\" # the library\n" SQUARE "usemtl \"red\"\nf 1 2 3\n",
    };
    for (size_t i = 0; i < sizeof same / sizeof same[0]; i++) {
        description *d = load_text("found.obj", same[i]);
        near3(input_of(material_of(d, "red"), "color").value, 1, 0, 0);
        assert_int_equal(d->message_count, 1);
        assert_true(has_message(d, "of materials is not used: map_Kd, map_Ks"));
        description_destroy(d);
    }
    description *d = load_text("found.obj", "mtllib m.mtl\n" SQUARE "usemtl a #1\nf 1 2 3\n");
    material_of(d, "a #1");
    description_destroy(d);

    /* Pictures lie beside the library, or else beside the model. */
    assert_int_equal(mkdir(path_of("lib"), 0700), 0);
    copy_texture("textures/grey.png", "lib/there.png");
    copy_texture("textures/grey_alpha.png", "there.png");
    copy_texture("textures/grey.png", "here.png");
    put("lib/m.mtl", "newmtl b\nmap_Kd there.png\nmap_Ks here.png\nNs 1\nmap_d ../there.png\n");
    d = load_text("found.obj", "mtllib lib/m.mtl\n" SQUARE "usemtl b\nf 1 2 3\n");
    assert_int_equal(d->message_count, 0);
    const object *b = material_of(d, "b");
    assert_true(input_of(b, "color").texture.index1 && input_of(b, "specular").texture.index1);
    uint32_t alpha = input_of(b, "alpha").texture.index1;
    assert_int_equal(
        ((const uint8_t *)*(const void *const *)field_of(texture_of(d, alpha), "pixels"))[0], 200);
    description_destroy(d);
}

static void what_is_wrong_in_obj_has_a_place(void **state) {
    (void)state;
    refused("a.obj", SQUARE "f 0 1 2\n", 5, 3, "vertex 0: they count from 1");
    refused("a.obj", SQUARE "f 1 2 5\n", 5, 7, "vertex 5: there are 4");
    refused("a.obj", SQUARE "f 1 2 -5\n", 5, 7, "vertex -5: there are 4");
    refused("a.obj", SQUARE "vt 0 0\n  f 1/1 2/2 3/1\n", 6, 11,
            "texture coordinate 2: there are 1");
    refused("a.obj", SQUARE "vn 0 0 1\nf 1//1 2//0 3//1\n", 6, 11, "normal 0");
    refused("a.obj", SQUARE "f 1 2 x\n", 5, 7, "'x' is no corner of a face");
    refused("a.obj", SQUARE "f 1 2 3/1/1/1\n", 5, 12, "'/1' is no corner of a face");
    refused("a.obj", "v 0 0 nan\nf 1 1 1\n", 1, 7, "'nan' is no finite number");
    refused("a.obj", "v 0 0 1e99\nf 1 1 1\n", 1, 7, "no finite number");
    refused("a.obj", "v 0 0\nf 1 1 1\n", 1, 6, "the line ends where a number should be");
    refused("a.obj", "\n\\\nv 0 0 1x\nf 1 1 1\n", 3, 7, "'1x' is no finite number");
    refused("a.obj", SQUARE, 0, 0, "no surfaces, only vertices");
    assert_string_equal(error_last()->hint, "the file may be cut off");
    refused("a.obj", SQUARE "l 1 2\n", 0, 0, "only points or lines");
}

/* ---- hostile bytes ---- */

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

enum { ROOM = 8192 };

static size_t make_seed(int which, uint8_t *out, const char **name) {
    static const char text[] = "mtllib seed.mtl\no one\nv 0 0 0\nv 1 0 0 1 0.5 0\nv 1 1 0\nv 0 "
                               "1.5e0 0\nv .5 .25 0\nvt 0 0\nvt "
                               "1 1\nvn 0 0 1\nusemtl a\ns 1\nf 1/1/1 2/2/1 3/1/1 4/2/1\no "
                               "two\nusemtl b\ns off\nf 1 2 3 5\nf "
                               "-1 -2 \\\n-3\ng x y\nl 1 2\nf 1//1 2//1 3//1\n";
    static const char library[] = "newmtl a\nKd .5 .5 .5\nKs 1 1 1\nNs 40\nillum 2\nmap_Kd -s 2 2 "
                                  "-o .1 -clamp on grey.png\nbump "
                                  "-bm 0.5 grey.png\nd 0.5\nnewmtl b\nillum 7\nNi 1.4\nTf 1 .5 "
                                  "1\nPr 0.2\nPm .1\nnorm grey.png\n";
    static const char scan[] = "ply\nformat ascii 1.0\ncomment TextureFile grey.png\n" XYZ(4)
        FACES(3) "property list uchar float texcoord\nend_header\n0 0 0 1 0 0 1 1 0 0 1 0\n"
                 "3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 0 0 1 1 0 1\n4 0 1 2 3 8 .5 0 1 0 1 1 0 1\n";
    static const uint16_t colors[] = {0x8000 | 31 << 10, 0x8000 | 31, 0, 0};
    static const char solid[] =
        "solid one\n" FACET(0) FACET(1) "endsolid one\nsolid two\n" FACET(2) "endsolid two\n";
    static const char *const names[] = {"seed.ply", "seed.ply", "seed.stl", "seed.stl",
                                        "seed.obj", "seed.mtl", "seed.ply"};
    *name = names[which];
    switch (which) {
    case 0:
    case 1: return write_square((char *)out, 6, which);
    case 2: return write_stl((char *)out, "COLOR=abcd", 4, colors);
    case 3: memcpy(out, solid, sizeof solid - 1); return sizeof solid - 1;
    case 4: memcpy(out, text, sizeof text - 1); return sizeof text - 1;
    case 6: memcpy(out, scan, sizeof scan - 1); return sizeof scan - 1;
    default: memcpy(out, library, sizeof library - 1); return sizeof library - 1;
    }
}

/* Address space beyond what the process has now. */
static void limit_memory(bool on) {
    static struct rlimit before;
    struct rlimit now;
    unsigned long long pages = 0;
    if (SANITIZED) return;
    if (!on) {
        setrlimit(RLIMIT_AS, &before);
        return;
    }
    FILE *file = fopen("/proc/self/statm", "re");
    assert_true(file && fscanf(file, "%llu", &pages) == 1);
    fclose(file);
    getrlimit(RLIMIT_AS, &before);
    now = before;
    now.rlim_cur = pages * (uint64_t)sysconf(_SC_PAGESIZE) + ((uint64_t)512 << 20);
    assert_int_equal(setrlimit(RLIMIT_AS, &now), 0);
}

static void mutants_do_no_harm(void **state) {
    (void)state;
    size_t total = SANITIZED ? 1000 : 10000;
    uint64_t seed = 88172645463325252u;
    copy_texture("textures/grey.png", "grey.png");
    limit_memory(true);
    for (int which = 0; which < 7; which++) {
        uint8_t original[ROOM], copy[ROOM];
        const char *name, *model;
        double slowest = 0;
        size_t loaded = 0, size;
        for (int k = 4; k < 6; k++) { /* whole, both that belong together */
            size = make_seed(k, original, &name);
            put_bytes(name, original, size);
        }
        size = make_seed(which, original, &name);
        model = which == 5 ? "seed.obj" : name;
        for (size_t i = 0; i < total; i++) {
            memcpy(copy, original, size);
            size_t now = mutate_text(copy, size, ROOM, &seed);
            if (random_next(&seed) % 8 == 0) now = 1 + random_next(&seed) % now;
            put_bytes(name, copy, now);
            description *d;
            double begin = cpu_seconds();
            snell_status status = read_model(model, &d);
            double seconds = cpu_seconds() - begin;
            if (seconds > slowest) slowest = seconds;
            assert_true(status != SNELL_ERR_MEMORY);
            loaded += status == SNELL_OK;
            description_destroy(d);
        }
        print_message("%s %d: %zu of %zu mutants still load, the slowest in %.4f s\n", name, which,
                      loaded, total, slowest);
        assert_true(slowest < 1);
        assert_true(loaded > 0 && loaded < total);
    }
    limit_memory(false);
}

/* Small files that would take long: many corners at one place, one vertex under many names, a polygon of very many
 * corners, many objects. */
static void no_file_takes_the_square_of_its_size(void **state) {
    (void)state;
    enum { COUNT = 60000 };
    char *text = memory_resize(NULL, COUNT, 64);
    assert_non_null(text);
    for (int kind = 0; kind < 4; kind++) {
        size_t used = (size_t)sprintf(text, "v 0 0 0\n");
        for (int i = 0; i < COUNT; i++)
            used += (size_t)sprintf(text + used, kind == 1 ? "vt %d 0\n" : "v 1 %d 1\n", i);
        if (kind == 1) used += (size_t)sprintf(text + used, "v 1 0 0\nv 0 1 0\n");
        if (kind == 2) used += (size_t)sprintf(text + used, "f");
        for (int i = 1; i < COUNT; i++) {
            if (kind == 0)
                used += (size_t)sprintf(text + used, "f 1 %d %d\n", i + 1, (i * 7919) % COUNT + 2);
            if (kind == 1) used += (size_t)sprintf(text + used, "f 1/%d 2/1 3/1\n", i);
            if (kind == 2) used += (size_t)sprintf(text + used, " %d", i);
            if (kind == 3) used += (size_t)sprintf(text + used, "o %d\nf 1 %d 2\n", i, i + 1);
        }
        put_bytes("long.obj", text, used);
        double begin = cpu_seconds();
        description *d = load("long.obj");
        double seconds = cpu_seconds() - begin;
        print_message("%d: %.3f s\n", kind, seconds);
        assert_true(seconds < (SANITIZED ? 20 : 2));
        description_destroy(d);
    }
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_correctly_rounded),
        cmocka_unit_test(ply_has_every_type_and_encoding),
        cmocka_unit_test(ply_strips_colors_and_smoothness),
        cmocka_unit_test(ply_seams_and_pictures),
        cmocka_unit_test(faces_that_meet_under_60_degrees_are_smooth),
        cmocka_unit_test(a_crowd_without_area_is_harmless),
        cmocka_unit_test(indices_of_polygons_fit_32_bits),
        cmocka_unit_test(what_is_wrong_in_ply_has_a_place),
        cmocka_unit_test(stl_dialects),
        cmocka_unit_test(obj_dialects),
        cmocka_unit_test(colors_beyond_1),
        cmocka_unit_test(texts_may_begin_with_a_mark),
        cmocka_unit_test(obj_smoothing),
        cmocka_unit_test(obj_objects_and_materials),
        cmocka_unit_test(every_illumination_model),
        cmocka_unit_test(maps_and_their_options),
        cmocka_unit_test(numbers_that_are_none_lose_their_statement),
        cmocka_unit_test(materials_are_found),
        cmocka_unit_test(what_is_wrong_in_obj_has_a_place),
        cmocka_unit_test(mutants_do_no_harm),
        cmocka_unit_test(no_file_takes_the_square_of_its_size),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
