/* What is drawn. The reader numbers instances by the order of their calls, so each list of the description,
 * the world and each group, is written in its order. A shape that is used once is made where it is drawn; another
 * one before, as s[..], and placed by instance{}. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "exporters/lua_export.h"
#include "geometry/mesh.h"
#include "geometry/solid.h"

enum { NUMBERS_MAX = 2000000 }; /* written as text into the program */

static const object *shape_at(const lua_export *e, uint32_t shape) {
    return &e->d->objects[CATEGORY_SHAPE].items[shape];
}

static bool is_solid(const object *o) { return o->type == &primitive_solid.info; }

/* Is it made before, and called s[..]? Groups and solids in others are: nested calls have a limit. */
static bool is_named(const lua_export *e, uint32_t shape, bool nested) {
    const object *o = shape_at(e, shape);
    return e->uses[shape] > 1 || object_is_group(o) || (nested && is_solid(o));
}

/* A file of a mesh brings a material, so another must be said; where that comes from around it, none is. */
static void note_use(lua_export *e, uint32_t shape, bool has_material) {
    e->uses[shape]++;
    if (!has_material) e->filled[shape] = true;
}

static bool has_file(const lua_export *e, uint32_t shape) {
    const object *o = shape_at(e, shape);
    return o->type == &primitive_mesh.info && !e->filled[shape] && is_for_file(o);
}

/* From the last shape to the first: what uses a shape comes after it. */
static bool count_uses(lua_export *e) {
    size_t count = e->d->objects[CATEGORY_SHAPE].count;
    e->uses = memory_zeroed(count + 1, sizeof *e->uses);
    e->made = memory_zeroed(count + 1, sizeof *e->made);
    e->filled = memory_zeroed(count + 1, sizeof *e->filled);
    if (!e->uses || !e->made || !e->filled) return false;
    for (size_t list = count + 1; list-- > 0;) {
        if (list < count && e->uses[list] == 0) continue;
        for (uint32_t i = e->lists.begin[list]; i < e->lists.begin[list + 1]; i++)
            note_use(e, e->d->instances[e->lists.parts[i]].shape,
                     list == count || e->d->instances[e->lists.parts[i]].material != NO_MATERIAL);
        if (list == count || !is_solid(shape_at(e, (uint32_t)list))) continue;
        const solid_desc *solid = shape_at(e, (uint32_t)list)->desc;
        for (size_t i = 0; i < solid->shapes_count; i++)
            note_use(e, solid->shapes[i].index1 - 1,
                     solid->materials_count && solid->materials[i].index1);
    }
    return true;
}

/* How a shape stands somewhere. */
typedef struct placed {
    uint32_t shape, material; /* NO_MATERIAL: none is said */
    bool fills;
    const transform *at;
    const motion_key *keys;
    size_t key_count;
    const char *name;
} placed;

static placed placed_instance(const instance *i) {
    return (placed){i->shape, i->material, i->fills, &i->to_world, i->keys, i->key_count, i->name};
}

static placed placed_part(const solid_desc *solid, size_t i) {
    uint32_t material = solid->materials_count ? solid->materials[i].index1 : 0;
    return (placed){solid->shapes[i].index1 - 1,
                    material ? material - 1 : NO_MATERIAL,
                    false,
                    solid->transforms_count ? &solid->transforms[i] : NULL,
                    NULL,
                    0,
                    ""};
}

static void put_shape(lua_export *e, uint32_t shape, const placed *at);

/* The fields that every shape takes. grey: a file brings a material, which then must be said. */
static void put_common(lua_export *e, const placed *at, const char *name, bool grey) {
    const transform identity = transform_identity();
    if (at && at->material != NO_MATERIAL) {
        put(e, " material = ");
        put_name(e, "m", CATEGORY_MATERIAL, at->material);
        put(e, ",");
    } else if (grey) {
        put(e, " material = grey,");
    }
    if (at && at->key_count) {
        put(e, " motion = ");
        put_keys(e, at->keys, at->key_count);
        put(e, ",");
    } else if (at && at->at && memcmp(at->at, &identity, sizeof identity) != 0) {
        put(e, " transform = ");
        put_transform(e, at->at);
        put(e, ",");
    }
    if (name[0]) {
        put(e, " name = ");
        put_string(e, name);
        put(e, ",");
    }
}

/* An instance is called by the names of what it is in and its own, joined by '/': what must be added to the
 * shape's. */
static void own_name(const object *o, const char *whole, char *out, size_t size) {
    size_t length = strlen(whole), own = object_is_group(o) ? 0 : strlen(o->name);
    snprintf(out, size, "%s", whole);
    if (own == 0 || length < own || strcmp(whole + length - own, o->name) != 0) return;
    if (length == own)
        out[0] = '\0';
    else if (whole[length - own - 1] == '/' && length - own - 1 < size)
        out[length - own - 1] = '\0';
}

static void put_node(lua_export *e, const placed *at, bool nested) {
    const object *o = shape_at(e, at->shape);
    bool group = object_is_group(o);
    char name[512];
    own_name(o, at->name, name, sizeof name);
    if (!is_named(e, at->shape, nested) && name[0] == '\0') {
        put_shape(e, at->shape, at);
        return;
    }
    /* Of a group's instance the material may be for those parts alone that have none. */
    put(e, "%s { ", group && at->fills && at->material != NO_MATERIAL ? "group" : "instance");
    if (is_named(e, at->shape, nested))
        put_name(e, "s", CATEGORY_SHAPE, at->shape);
    else
        put_shape(e, at->shape, NULL);
    put(e, ",");
    put_common(e, at, name, has_file(e, at->shape) && at->material == NO_MATERIAL);
    put_end(e);
}

static void put_parts(lua_export *e, uint32_t shape) {
    for (uint32_t i = e->lists.begin[shape]; i < e->lists.begin[shape + 1]; i++) {
        placed part = placed_instance(&e->d->instances[e->lists.parts[i]]);
        put(e, "\n  ");
        put_node(e, &part, true);
        put(e, ",");
    }
}

static void put_solid(lua_export *e, uint32_t shape) {
    const solid_desc *solid = shape_at(e, shape)->desc;
    for (size_t i = 0; i < solid->shapes_count; i++) {
        placed part = placed_part(solid, i);
        put(e, "\n  ");
        put_node(e, &part, true);
        put(e, ",");
    }
}

/* The call that makes it. at: where it is drawn, if it is drawn there; NULL: it only is. */
static void put_shape(lua_export *e, uint32_t shape, const placed *at) {
    const object *o = shape_at(e, shape);
    if (object_is_group(o)) { /* a name would go to its parts */
        put(e, "group { shared = true,");
        put_parts(e, shape);
        put_end(e);
        return;
    }
    if (is_solid(o)) {
        const field *operation = type_find_field(o->type, "operation");
        char word[32];
        choice_word(operation->choices,
                    *(const int32_t *)(const void *)((const char *)o->desc + operation->offset),
                    word, sizeof word);
        put(e, "%s {", word);
        put_solid(e, shape);
        put_common(e, at, o->name, false);
        put_end(e);
        return;
    }
    bool mesh = o->type == &primitive_mesh.info, file = has_file(e, shape);
    put(e, "%s {", o->type->name);
    if (file) {
        char beside[512] = "";
        write_mesh(e, shape, beside, sizeof beside);
        put(e, " file = ");
        put_string(e, beside);
        put(e, "%s,", ((const mesh_desc *)o->desc)->normals_count ? "" : ", smooth = false");
    } else if (count_numbers(o) > NUMBERS_MAX) {
        fail_object(e, CATEGORY_SHAPE, shape, "a compiled scene (.snell) holds it",
                    "it has %zu numbers%s; a program can hold %d", count_numbers(o),
                    mesh ? ", some of which a .ply does not know" : "", NUMBERS_MAX);
    } else {
        put_fields(e, CATEGORY_SHAPE, shape, NULL);
    }
    put_common(e, at, o->name, file);
    put_end(e);
}

static void make_before(lua_export *e, uint32_t shape, bool nested);

static void make_parts_before(lua_export *e, uint32_t shape) {
    const object *o = shape_at(e, shape);
    for (uint32_t i = e->lists.begin[shape]; i < e->lists.begin[shape + 1]; i++)
        make_before(e, e->d->instances[e->lists.parts[i]].shape, true);
    const solid_desc *solid = is_solid(o) ? o->desc : NULL;
    for (size_t i = 0; solid && i < solid->shapes_count; i++)
        make_before(e, solid->shapes[i].index1 - 1, true);
}

/* Makes what has a name of its own in the shape, and the shape if it has. The recursion ends: depth is checked
 * where groups and solids are added. */
static void make_before(lua_export *e, uint32_t shape, bool nested) {
    if (e->status || e->made[shape]) return;
    make_parts_before(e, shape);
    if (!is_named(e, shape, nested)) return;
    e->made[shape] = true;
    put_name(e, "s", CATEGORY_SHAPE, shape);
    put(e, " = ");
    put_shape(e, shape, NULL);
    put(e, "\n");
}

/* A mesh of a file that is drawn without a material. */
static bool needs_grey(const lua_export *e) {
    for (size_t i = 0; i < e->d->instance_count; i++) {
        const instance *at = &e->d->instances[i];
        if (at->removed || at->material != NO_MATERIAL) continue;
        if (has_file(e, at->shape)) return true;
    }
    return false;
}

void put_shapes(lua_export *e) {
    size_t count = e->d->objects[CATEGORY_SHAPE].count;
    if (!e->status) e->status = part_lists_make(e->d, &e->lists);
    if (!e->status && !count_uses(e)) e->status = error_no_memory();
    if (e->status) return;
    if (needs_grey(e)) put(e, "local grey = material.lambert {}\n");
    put(e, "local s = {}\n");
    for (uint32_t i = e->lists.begin[count]; i < e->lists.begin[count + 1] && !e->status; i++) {
        placed at = placed_instance(&e->d->instances[e->lists.parts[i]]);
        make_before(e, at.shape, false);
        put_node(e, &at, false);
        put(e, "\n");
    }
    for (uint32_t k = 0; k < count; k++)
        if (e->uses[k] == 0) {
            char label[256];
            description_object_label(e->d, CATEGORY_SHAPE, k, label, sizeof label);
            for (char *c = label; *c; c++)
                if ((unsigned char)*c < ' ') *c = '?';
            put(e, "-- not drawn, so left out: %s %s\n", shape_at(e, k)->type->name, label);
        }
}
