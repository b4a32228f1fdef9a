/* The files beside an exported program: a PLY for a large mesh, a PNG or PFM for an image. */
#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/memory.h"
#include "exporters/lua_export.h"
#include "geometry/mesh.h"
#include "image/codec.h"
#include "image/png.h"
#include "sampling/sampling.h"

enum { INLINE_NUMBERS = 96 };

/* ---- names: NAME.files/OBJECT-HASH.EXT ---- */

/* The last name of the program's path without its extension. */
static const char *stem_of(const lua_export *e, int *length) {
    const char *slash = strrchr(e->path, '/'), *stem = slash ? slash + 1 : e->path;
    const char *dot = strrchr(stem, '.');
    *length = dot ? (int)(dot - stem) : (int)strlen(stem);
    return stem;
}

/* Letters, digits, '-' and '_' of the object's name, or its type. */
static void plain_name(const object *o, char *out, size_t size) {
    size_t used = 0;
    for (const char *c = o->name[0] ? o->name : o->type->name; *c && used + 1 < size && used < 60;
         c++)
        out[used++] = isalnum((unsigned char)*c) || *c == '-' ? *c : '_';
    out[used] = '\0';
}

static uint64_t hash_of(const void *data, size_t size) {
    const char *bytes = data;
    uint64_t hash = size;
    for (size_t at = 0; at < size; at += 8) {
        uint64_t word = 0;
        memcpy(&word, bytes + at, size - at < 8 ? size - at : 8);
        hash = hash_mix(hash ^ word);
    }
    return hash;
}

static void write_beside(lua_export *e, const object *o, const char *extension, const void *data,
                         size_t size, char *out, size_t out_size) {
    int length, folder = (int)(strrchr(e->path, '/') ? strrchr(e->path, '/') + 1 - e->path : 0);
    const char *stem = stem_of(e, &length);
    char name[64], path[PATH_MAX];
    plain_name(o, name, sizeof name);
    int written = snprintf(path, sizeof path, "%.*s%.*s.files", folder, e->path, length, stem);
    bool fits = written > 0 && written < (int)sizeof path;
    if (fits && !e->has_folder && mkdir(path, 0777) != 0 && errno != EEXIST) {
        e->status = error_set_at(SNELL_ERR_IO, (source_place){path, 0, 0}, NULL,
                                 "cannot make the folder: %s", strerror(errno));
        return;
    }
    e->has_folder = true;
    written = snprintf(out, out_size, "%.*s.files/%s-%08x%s", length, stem, name,
                       (unsigned)hash_of(data, size), extension);
    fits &= written > 0 && (size_t)written < out_size;
    written = snprintf(path, sizeof path, "%.*s%s", folder, e->path, out);
    fits &= written > 0 && written < (int)sizeof path;
    e->status = fits ? file_write_atomic(path, data, size)
                     : error_set_at(SNELL_ERR_IO, (source_place){e->path, 0, 0},
                                    "write to a shorter path", "the name is too long");
}

/* ---- meshes ---- */

static bool fits_ply(const mesh_desc *m) {
    return m->colors_count == 0 && m->alphas_count == 0 && m->material_slots_count == 0 &&
           m->materials_count == 0 && m->key_times_count == 0 && m->uvs2_count == 0 &&
           m->tangents_count == 0 && m->indices_count > 0;
}

bool is_for_file(const object *mesh) {
    return fits_ply(mesh->desc) && count_numbers(mesh) > INLINE_NUMBERS;
}

typedef struct bytes {
    char *data;
    size_t size, capacity;
} bytes;

static void add(lua_export *e, bytes *b, const void *data, size_t size) {
    if (e->status) return;
    if (!ARRAY_GROW(b->data, b->size, b->capacity, size)) {
        e->status = error_no_memory();
        return;
    }
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static void add_header(lua_export *e, bytes *b, const mesh_desc *m) {
    const uint16_t one = 1;
    char text[512];
    int length = snprintf(
        text, sizeof text,
        "ply\nformat binary_%s_endian 1.0\ncomment written by snell\nelement vertex %zu\n"
        "property float x\nproperty float y\nproperty float z\n%s%selement face %zu\n"
        "property list uchar uint vertex_indices\nend_header\n",
        *(const uint8_t *)&one ? "little" : "big", m->positions_count,
        m->normals_count ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
        m->uvs_count ? "property float s\nproperty float t\n" : "", mesh_triangle_count(m));
    add(e, b, text, (size_t)length);
}

void write_mesh(lua_export *e, uint32_t shape, char *out, size_t size) {
    const object *o = &e->d->objects[CATEGORY_SHAPE].items[shape];
    const mesh_desc *m = o->desc;
    const uint8_t corners = 3;
    bytes b = {NULL, 0, 0};
    add_header(e, &b, m);
    for (size_t i = 0; i < m->positions_count; i++) {
        add(e, &b, &m->positions[i], sizeof *m->positions);
        if (m->normals_count) add(e, &b, &m->normals[i], sizeof *m->normals);
        if (m->uvs_count) add(e, &b, &m->uvs[i], sizeof *m->uvs);
    }
    for (size_t i = 0; i + 2 < m->indices_count; i += 3) {
        add(e, &b, &corners, 1);
        add(e, &b, &m->indices[i], 3 * sizeof *m->indices);
    }
    if (!e->status) write_beside(e, o, ".ply", b.data, b.size, out, size);
    free(b.data);
}

/* ---- images ---- */

/* A field of texture.image. */
static const void *member_of(const object *o, const char *name) {
    return (const char *)o->desc + type_find_field(o->type, name)->offset;
}

/* Linear floats: a PFM has no alpha. */
static void write_floats(lua_export *e, uint32_t texture, const float *rgba, uint32_t width,
                         uint32_t height, char *out, size_t size) {
    const image_codec *codec;
    image_options options = {.bits = 32};
    image_pixels pixels = {rgba, width, height, 4};
    void *data = NULL;
    size_t length = 0;
    for (size_t i = 0; i < (size_t)width * height; i++)
        if (rgba[4 * i + 3] != 1) {
            fail_object(e, CATEGORY_TEXTURE, texture, "a compiled scene (.snell) holds it",
                        "an image of floats that is transparent in part cannot be written");
            return;
        }
    e->status = image_codec_find("pfm", &codec);
    if (!e->status) e->status = codec->encode ? SNELL_OK : SNELL_ERR_UNSUPPORTED;
    if (!e->status) e->status = image_encode(codec, &pixels, &options, &data, &length);
    if (!e->status)
        write_beside(e, &e->d->objects[CATEGORY_TEXTURE].items[texture], ".pfm", data, length, out,
                     size);
    free(data);
}

void write_image(lua_export *e, uint32_t texture, char *out, size_t size) {
    const object *o = &e->d->objects[CATEGORY_TEXTURE].items[texture];
    uint32_t width = (uint32_t) * (const int32_t *)member_of(o, "width"),
             height = (uint32_t) * (const int32_t *)member_of(o, "height");
    const field *format = type_find_field(o->type, "format");
    char word[16];
    choice_word(format->choices, *(const int32_t *)member_of(o, "format"), word, sizeof word);
    const void *pixels;
    memcpy(&pixels, member_of(o, "pixels"), sizeof pixels);
    if (strcmp(word, "rgba32f") == 0) {
        write_floats(e, texture, pixels, width, height, out, size);
        return;
    }
    uint32_t channels = strcmp(word, "gray8") == 0 ? 1 : strcmp(word, "rgb8") == 0 ? 3 : 4;
    image_buffer b = {NULL, 0, 0};
    e->status = png_encode_bytes(pixels, width, height, channels, &b);
    if (!e->status) write_beside(e, o, ".png", b.data, b.size, out, size);
    free(b.data);
}
