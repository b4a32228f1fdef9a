/* The scene description: what importers write, what the C API edits, what `commit` freezes. Plain
 * data; no light is computed from it and no file is read by it.
 *
 * Objects of one category are numbered from 0 in the order of adding; a public id is {index + 1,
 * generation}. Everything is checked here, once: an importer may hand over whatever its file says.
 */
#ifndef SNELL_SCENE_DESCRIPTION_H
#define SNELL_SCENE_DESCRIPTION_H

#include "base/error.h"
#include "base/field.h"
#include "maths/motion.h"

typedef struct object {
    const type_info *type;
    void *desc; /* type->desc_size bytes, owned */
    char *name; /* owned; "" when unnamed; unique in its category otherwise (importers add ".2"
                   where a file repeats) */
    char *file; /* owned; "" when it came through the API */
    uint32_t line;
    uint32_t generation; /* of the id: 0, since objects are not removed; instances that are removed
                            keep their slot with the next generation */
} object;

typedef struct object_list {
    object *items;
    size_t count, capacity;
    uint32_t *name_slots; /* hash table of the named: index + 1, 0 where free */
    size_t name_slot_count, name_count;
} object_list;

typedef struct instance {
    uint32_t shape;    /* index into objects[CATEGORY_SHAPE] */
    uint32_t material; /* index into objects[CATEGORY_MATERIAL], or NO_MATERIAL: grey Lambert */
    uint32_t owner; /* the group whose part it is, an index greater than shape; NO_GROUP: drawn */
    bool fills;     /* of a group: its material is only for parts that have none */
    transform to_world;
    motion_key
        *keys; /* owned; key_count 0: it stands still at to_world, else to_world is its first */
    size_t key_count;
    char *name; /* owned; "" when unnamed */
    uint32_t line, generation;
    bool removed;
} instance;
#define NO_MATERIAL UINT32_MAX
#define NO_GROUP UINT32_MAX

/* A shape of this type is a group: the instances that it owns, in their order, as one shape. It is in
 * no registry, and no ray meets the group itself. */
struct primitive_type;
extern const struct primitive_type shape_group;
bool object_is_group(const object *o);

/* A param("name") of a scene program, for `snell info`; strings owned. */
typedef struct scene_param {
    char *name, *kind, *value, *default_value, *help;
} scene_param;

/* A warning or note of an importer, passed to the log of the context by the reader; strings owned.
 */
typedef struct import_message {
    snell_severity severity;
    char *text, *hint, *file;
    uint32_t line;
} import_message;

typedef struct description {
    object_list objects[CATEGORY_COUNT];
    instance *instances;
    size_t instance_count, instance_capacity;
    scene_param *params;
    size_t param_count, param_capacity;
    import_message *messages;
    size_t message_count, message_capacity;
    char format[16]; /* "gltf", "lua", ...; "" without a file */
    bool is_model;   /* a model file rather than a scene: its picture is toned with `neutral` */
    bool
        has_next_frame; /* what moves is known a frame beyond the shutter, as motion vectors need */
    bool is_settled;    /* directions are as they were kept once: not to be normalised again */
} description;

typedef struct object_source {
    const char *name; /* may be NULL */
    const char *file; /* may be NULL */
    uint32_t line;    /* 0 when unknown */
} object_source;

snell_status description_create(description **out);
void description_destroy(description *d);

/* Adds an object of the named type from generic parameters, each of which is one of the type's
 * fields. Errors: SNELL_ERR_ARGUMENT with a text such as "sphere: unknown field 'radus'" and a
 * hint; the caller adds the place with error_place. *index is the object's number. Settings
 * ("render", "background", "ambient") may be added once each. */
snell_status description_add(description *d, category category, const char *type,
                             const snell_param *params, size_t count, object_source source,
                             uint32_t *index);
/* The same from a filled description struct, which is copied. Its struct_size may be smaller than
 * the type's (an older caller): the fields that it lacks take their defaults; larger:
 * SNELL_ERR_VERSION. */
snell_status description_add_desc(description *d, const type_info *type, const void *desc,
                                  object_source source, uint32_t *index);
/* The same for a type without strings, but on success the arrays are the description's from then on, not
 * copied: each of its own allocation, for free(). */
snell_status description_take_desc(description *d, const type_info *type, const void *desc,
                                   object_source source, uint32_t *index);
snell_status description_add_instance(description *d, uint32_t shape, uint32_t material,
                                      const transform *to_world, object_source source,
                                      uint32_t *index);
/* A shape by the caller's functions, checked and copied. */
snell_status description_add_user(description *d, const snell_user_shape_desc *desc,
                                  object_source source, uint32_t *index);
/* Instances that are drawn become the parts of a new group, which is drawn where an instance of it
 * stands. Errors: a part that is not there or belongs to another group; nested too deep. */
snell_status description_add_group(description *d, const uint32_t *parts, size_t count,
                                   object_source source, uint32_t *index);
/* For readers of records: a group without parts, and an instance put into it. */
snell_status description_add_empty_group(description *d, object_source source, uint32_t *index);
snell_status description_set_owner(description *d, uint32_t instance, uint32_t owner);
/* The instance moves by these keys, which are checked and copied; count 0: it stands still again. */
snell_status description_set_motion(description *d, uint32_t instance, const motion_key *keys,
                                    size_t count);
snell_status description_add_param(description *d, const char *name, const char *kind,
                                   const char *value, const char *default_value, const char *help);
/* A warning or note about the file; at most 200 are kept, repeated texts once. */
snell_status description_add_message(description *d, snell_severity severity, const char *file,
                                     uint32_t line, const char *hint, const char *format, ...)
    PRINTF_LIKE(6, 7);

/* How much is in a description, so that what was added later can be taken out again. */
typedef struct description_mark {
    size_t objects[CATEGORY_COUNT], instances, params, messages;
} description_mark;
description_mark description_get_mark(const description *d);
void description_rewind(description *d, const description_mark *mark);

/* The instances of each group and of the world that are not removed, in their order: those of shape g
 * are parts[begin[g] .. begin[g + 1]); the world comes after the last shape. */
typedef struct part_lists {
    uint32_t *begin, *parts;
    uint32_t *depth; /* of each shape: groups in groups under it, with itself; 0: not a group */
} part_lists;
/* Errors: no memory; groups nested too deep. */
snell_status part_lists_make(const description *d, part_lists *out);
void part_lists_free(part_lists *lists);

/* NULL when there is none. */
object *description_find(const description *d, category category, const char *name);
const object *description_setting(const description *d, const char *type);
const type_info *type_find(category category, const char *name);
const char *category_name(category category); /* "texture", "material", ... */
/* "sphere:12" for the unnamed, the name otherwise; into out. */
void description_object_label(const description *d, category category, uint32_t index, char *out,
                              size_t size);

/* Every registered type of every category, for documentation and help. NULL at the end. */
const type_info *type_at(uint32_t index);

/* The size, in pixels and samples, that a picture has when neither scene nor caller says. */
enum { DEFAULT_WIDTH = 800, DEFAULT_HEIGHT = 600 };

#endif
