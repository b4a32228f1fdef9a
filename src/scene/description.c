#include "scene/description.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "cameras/camera.h"
#include "geometry/primitive.h"
#include "geometry/user.h"
#include "image/aov.h"
#include "image/white_balance.h"
#include "lights/light.h"
#include "materials/material.h"
#include "scene/settings.h"
#include "scene/solids.h"
#include "textures/texture.h"

enum { MESSAGES_MAX = 200 };

/* ---- the registries as one ---- */

typedef snell_status check_fn(const void *desc);

static const type_info *const settings[] = {&setting_render, &setting_background, &setting_ambient,
                                            &setting_animation};

static snell_status check_render(const void *desc) {
    const render_desc *render = desc;
    aov_set aovs;
    white_balance white;
    snell_status status = aov_parse(render->aov, &aovs);
    return status ? status : white_balance_parse(render->white_balance, &white);
}

/* The index-th type of a category, NULL at the end; its own check (may be NULL) in *check. */
static const type_info *registered(category which, uint32_t index, check_fn **check) {
    *check = NULL;
    switch (which) {
    case CATEGORY_TEXTURE:
        if (index >= texture_type_count) return NULL;
        *check = texture_types[index]->check;
        return &texture_types[index]->info;
    case CATEGORY_MATERIAL:
        if (index >= material_type_count) return NULL;
        *check = material_types[index]->check;
        return &material_types[index]->info;
    case CATEGORY_LIGHT:
        if (index >= light_type_count) return NULL;
        *check = light_types[index]->check;
        return &light_types[index]->info;
    case CATEGORY_SHAPE:
        if (index >= primitive_type_count) return NULL;
        *check = primitive_types[index]->check;
        return &primitive_types[index]->info;
    case CATEGORY_CAMERA:
        if (index >= camera_type_count) return NULL;
        *check = camera_types[index]->check;
        return &camera_types[index]->info;
    case CATEGORY_SETTING:
        if (index >= sizeof settings / sizeof settings[0]) return NULL;
        if (settings[index] == &setting_render) *check = check_render;
        return settings[index];
    default: return NULL;
    }
}

const char *category_name(category which) {
    static const char *const names[CATEGORY_COUNT] = {
        [CATEGORY_TEXTURE] = "texture", [CATEGORY_MATERIAL] = "material",
        [CATEGORY_LIGHT] = "light",     [CATEGORY_SHAPE] = "shape",
        [CATEGORY_CAMERA] = "camera",   [CATEGORY_SETTING] = "setting"};
    return names[which];
}

const type_info *type_at(uint32_t index) {
    for (int c = 0; c < CATEGORY_COUNT; c++) {
        check_fn *check;
        const type_info *info;
        for (uint32_t i = 0; (info = registered((category)c, i, &check)) != NULL; i++)
            if (index-- == 0) return info;
    }
    return NULL;
}

const type_info *type_find(category which, const char *name) {
    check_fn *check;
    const type_info *info;
    for (uint32_t i = 0; (info = registered(which, i, &check)) != NULL; i++)
        if (strcmp(info->name, name) == 0) return info;
    return NULL;
}

static bool find_check(const type_info *type, check_fn **check) {
    const type_info *info;
    for (uint32_t i = 0; (info = registered(type->category, i, check)) != NULL; i++)
        if (info == type) return true;
    return false;
}

static snell_status unknown_type(category which, const char *name) {
    const char *names[64];
    size_t count = 0;
    char hint[512] = "there are ";
    check_fn *check;
    const type_info *info;
    for (uint32_t i = 0; count < 64 && (info = registered(which, i, &check)) != NULL; i++) {
        names[count++] = info->name;
        size_t used = strlen(hint);
        snprintf(hint + used, sizeof hint - used, "%s%s", i ? ", " : "", info->name);
    }
    const char *near = closest_word(name, names, count);
    if (near) snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    return error_set(SNELL_ERR_ARGUMENT, hint, "unknown %s '%s'", category_name(which), name);
}

/* ---- names: a hash table per category, open addressing, at most half full ---- */

static uint64_t hash_name(const char *name) { /* FNV-1a, 64 bit */
    uint64_t hash = 14695981039346656037u;
    for (; *name; name++) hash = (hash ^ (unsigned char)*name) * 1099511628211u;
    return hash;
}

static void insert_name(object_list *list, uint32_t index) {
    size_t mask = list->name_slot_count - 1;
    size_t at = (size_t)hash_name(list->items[index].name) & mask;
    while (list->name_slots[at]) at = (at + 1) & mask;
    list->name_slots[at] = index + 1;
    list->name_count++;
}

static void rebuild_names(object_list *list) {
    if (list->name_slot_count == 0) return;
    memset(list->name_slots, 0, list->name_slot_count * sizeof *list->name_slots);
    list->name_count = 0;
    for (size_t i = 0; i < list->count; i++)
        if (list->items[i].name[0]) insert_name(list, (uint32_t)i);
}

/* Makes room for one more name. */
static bool reserve_name(object_list *list) {
    if (2 * (list->name_count + 1) <= list->name_slot_count) return true;
    size_t wanted = list->name_slot_count ? 2 * list->name_slot_count : 16;
    uint32_t *slots = memory_resize(list->name_slots, wanted, sizeof *slots);
    if (slots == NULL) return false;
    list->name_slots = slots;
    list->name_slot_count = wanted;
    rebuild_names(list);
    return true;
}

object *description_find(const description *d, category which, const char *name) {
    const object_list *list = &d->objects[which];
    if (name[0] == '\0' || list->name_slot_count == 0) return NULL;
    size_t mask = list->name_slot_count - 1;
    for (size_t at = (size_t)hash_name(name) & mask; list->name_slots[at]; at = (at + 1) & mask) {
        object *found = &list->items[list->name_slots[at] - 1];
        if (strcmp(found->name, name) == 0) return found;
    }
    return NULL;
}

/* ---- life ---- */

snell_status description_create(description **out) {
    description *d = memory_zeroed(1, sizeof *d);
    if (d == NULL) return error_no_memory();
    *out = d;
    return SNELL_OK;
}

static void free_object(object *o) {
    desc_free(o->type, o->desc);
    free(o->name);
    free(o->file);
}

static void free_param(scene_param *p) {
    free(p->name);
    free(p->kind);
    free(p->value);
    free(p->default_value);
    free(p->help);
}

static void free_message(import_message *m) {
    free(m->text);
    free(m->hint);
    free(m->file);
}

description_mark description_get_mark(const description *d) {
    description_mark mark = {
        .instances = d->instance_count, .params = d->param_count, .messages = d->message_count};
    for (int c = 0; c < CATEGORY_COUNT; c++) mark.objects[c] = d->objects[c].count;
    return mark;
}

void description_rewind(description *d, const description_mark *mark) {
    for (int c = 0; c < CATEGORY_COUNT; c++) {
        object_list *list = &d->objects[c];
        if (list->count == mark->objects[c]) continue;
        while (list->count > mark->objects[c]) free_object(&list->items[--list->count]);
        rebuild_names(list);
    }
    while (d->instance_count > mark->instances) {
        instance *last = &d->instances[--d->instance_count];
        free(last->name);
        free(last->keys);
    }
    for (size_t i = 0; i < d->instance_count; i++)
        if (d->instances[i].owner >= mark->objects[CATEGORY_SHAPE])
            d->instances[i].owner = NO_GROUP;
    while (d->param_count > mark->params) free_param(&d->params[--d->param_count]);
    while (d->message_count > mark->messages) free_message(&d->messages[--d->message_count]);
}

void description_destroy(description *d) {
    if (d == NULL) return;
    description_mark nothing = {0};
    description_rewind(d, &nothing);
    for (int c = 0; c < CATEGORY_COUNT; c++) {
        free(d->objects[c].items);
        free(d->objects[c].name_slots);
    }
    free(d->instances);
    free(d->params);
    free(d->messages);
    free(d);
}

/* ---- references ---- */

static snell_status check_id(const description *d, category which, const type_info *type,
                             const field *f, uint32_t index1, uint32_t generation) {
    const object_list *list = &d->objects[which];
    if (index1 >= 1 && index1 <= list->count && list->items[index1 - 1].generation == generation)
        return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "make it first, in the same scene",
                     "%s: '%s' names a %s that does not exist", type->name, f->name,
                     category_name(which));
}

/* A material that is made of others evaluates them in turn, so none of those may be made of others
 * itself (the depth would have no bound), and a medium belongs to the whole, not to a part. */
static snell_status check_part(const description *d, const type_info *type, const field *f,
                               uint32_t index) {
    const object *named = &d->objects[CATEGORY_MATERIAL].items[index];
    const type_info *part = named->type;
    for (uint32_t i = 0; i < part->field_count; i++)
        if (part->fields[i].kind == FIELD_MATERIAL)
            return error_set(SNELL_ERR_ARGUMENT, "use a material such as lambert",
                             "%s: '%s' cannot be %s, which is made of others itself", type->name,
                             f->name, part->name);
    if (material_bounds_medium((const material_type *)part, named->desc))
        return error_set(SNELL_ERR_ARGUMENT,
                         "a pane without an inside: material.principled { transmission = 1 }",
                         "%s: '%s' cannot be %s with an inside, which belongs to a whole shape",
                         type->name, f->name, part->name);
    return SNELL_OK;
}

static snell_status check_materials(const description *d, const type_info *type, const field *f,
                                    const snell_material_id *ids, size_t count) {
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < count && !status; i++)
        if (ids[i].index1 || !(f->flags & FIELD_SOME_NONE))
            status = check_id(d, CATEGORY_MATERIAL, type, f, ids[i].index1, ids[i].generation);
    return status;
}

/* What a solid is made of: closed shapes that were there before, so that none is part of itself. */
static snell_status check_shapes(const description *d, const type_info *type, const field *f,
                                 const snell_shape_id *ids, size_t count) {
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < count && !status; i++)
        status = check_id(d, CATEGORY_SHAPE, type, f, ids[i].index1, ids[i].generation);
    return status ? status : solid_check_parts(d, ids, count);
}

static snell_status check_reference(const description *d, const type_info *type, const field *f,
                                    const void *at) {
    bool required = f->flags & FIELD_REQUIRED;
    switch (f->kind) {
    case FIELD_INPUT:
    case FIELD_SCALAR: {
        snell_texture_id id = ((const snell_input *)at)->texture;
        if (id.index1 == 0) return SNELL_OK;
        return check_id(d, CATEGORY_TEXTURE, type, f, id.index1, id.generation);
    }
    case FIELD_TEXTURE: {
        const snell_texture_id *id = at;
        if (id->index1 == 0 && !required) return SNELL_OK;
        return check_id(d, CATEGORY_TEXTURE, type, f, id->index1, id->generation);
    }
    case FIELD_MATERIAL: {
        const snell_material_id *id = at;
        if (id->index1 == 0 && !required) return SNELL_OK;
        snell_status status = check_id(d, CATEGORY_MATERIAL, type, f, id->index1, id->generation);
        if (status || type->category != CATEGORY_MATERIAL) return status;
        return check_part(d, type, f, id->index1 - 1);
    }
    case FIELD_MATERIALS: {
        const snell_material_id *const *ids = at;
        size_t count;
        memcpy(&count, (const char *)at + sizeof *ids, sizeof count);
        return check_materials(d, type, f, *ids, count);
    }
    case FIELD_SHAPES: {
        const snell_shape_id *const *ids = at;
        size_t count;
        memcpy(&count, (const char *)at + sizeof *ids, sizeof count);
        return check_shapes(d, type, f, *ids, count);
    }
    default: return SNELL_OK;
    }
}

static snell_status check_references(const description *d, const type_info *type,
                                     const void *desc) {
    snell_status status = SNELL_OK;
    for (uint32_t i = 0; i < type->field_count && !status; i++) {
        const field *f = &type->fields[i];
        status = check_reference(d, type, f, (const char *)desc + f->offset);
    }
    return status;
}

/* ---- adding ---- */

static snell_status check_place(const description *d, const type_info *type, const char *name) {
    if (name && description_find(d, type->category, name))
        return error_set(SNELL_ERR_ARGUMENT, "give it another name",
                         "there is already a %s named '%s'", category_name(type->category), name);
    if (type->category == CATEGORY_SETTING && description_setting(d, type->name))
        return error_set(SNELL_ERR_ARGUMENT, "put everything into the first one",
                         "%s: given a second time", type->name);
    if (d->objects[type->category].count >= UINT32_MAX - 1)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "too many objects");
    return SNELL_OK;
}

/* Everything that can be checked before a deep copy is made; may normalise directions in desc. */
static snell_status check_desc(const description *d, const type_info *type, void *desc,
                               const bool *given) {
    check_fn *check = NULL;
    if (!find_check(type, &check))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "a type that is not registered");
    snell_status status = desc_check(type, desc, given);
    if (!status) status = check_references(d, type, desc);
    if (!status && check) status = check(desc);
    return status;
}

static void *shallow_copy(const void *data, size_t size) {
    void *copy = malloc(size);
    if (copy) memcpy(copy, data, size);
    return copy;
}

/* Takes a checked desc: a deep copy of it, or, `owned`, what it points to itself. */
static snell_status append_object(description *d, const type_info *type, const void *desc,
                                  bool owned, object_source source, uint32_t *index) {
    object_list *list = &d->objects[type->category];
    const char *name = source.name ? source.name : "";
    object made = {.type = type,
                   .desc = owned ? shallow_copy(desc, type->desc_size) : desc_copy(type, desc),
                   .name = memory_copy_string(name),
                   .file = memory_copy_string(source.file ? source.file : ""),
                   .line = source.line};
    if (!made.desc || !made.name || !made.file ||
        !ARRAY_GROW(list->items, list->count, list->capacity, 1) ||
        (name[0] && !reserve_name(list))) {
        if (owned) { /* the caller keeps what it points to */
            free(made.desc);
            made.desc = NULL;
        }
        free_object(&made);
        return error_no_memory();
    }
    list->items[list->count] = made;
    if (name[0]) insert_name(list, (uint32_t)list->count);
    if (index) *index = (uint32_t)list->count;
    list->count++;
    return SNELL_OK;
}

static snell_status set_params(const type_info *type, void *desc, const snell_param *params,
                               size_t count, bool *given) {
    for (size_t i = 0; i < count; i++) {
        snell_status status = desc_set(type, desc, &params[i]);
        if (status) return status;
        size_t f = (size_t)(type_find_field(type, params[i].name) - type->fields);
        if (given[f])
            return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' is given twice", type->name,
                             params[i].name);
        given[f] = true;
    }
    return SNELL_OK;
}

snell_status description_add(description *d, category which, const char *type,
                             const snell_param *params, size_t count, object_source source,
                             uint32_t *index) {
    const type_info *info = type_find(which, type);
    if (info == NULL) return unknown_type(which, type);
    snell_status status = check_place(d, info, source.name);
    if (status) return status;
    void *desc = memory_zeroed(1, info->desc_size);
    bool *given = memory_zeroed(info->field_count, sizeof *given);
    if (desc && given) {
        desc_init(info, desc);
        status = set_params(info, desc, params, count, given);
        if (!status) status = check_desc(d, info, desc, given);
        if (!status) status = append_object(d, info, desc, false, source, index);
    } else {
        status = error_no_memory();
    }
    free(desc);
    free(given);
    return status;
}

/* Fills `whole` from a desc whose struct_size may be an older, smaller one. A field that only half
 * fits was not in that older struct. */
static snell_status take_desc(const type_info *type, const void *desc, void *whole) {
    size_t size;
    memcpy(&size, desc, sizeof size);
    if (size > type->desc_size)
        return error_set(SNELL_ERR_VERSION, "use the header that belongs to the library",
                         "%s: the description has %zu bytes; this library knows %zu", type->name,
                         size, type->desc_size);
    if (size < sizeof size)
        return error_set(SNELL_ERR_ARGUMENT, "make it with SNELL_INIT",
                         "%s: the description's struct_size is not set", type->name);
    desc_init(type, whole);
    for (uint32_t i = 0; i < type->field_count; i++) {
        const field *f = &type->fields[i];
        size_t end = f->offset + field_size(f->kind);
        if (end > size) continue;
        memcpy((char *)whole + f->offset, (const char *)desc + f->offset, field_size(f->kind));
        if (field_element_size(f->kind) == 0) continue;
        const void *data;
        size_t count;
        memcpy(&data, (const char *)whole + f->offset, sizeof data);
        memcpy(&count, (const char *)whole + f->offset + sizeof data, sizeof count);
        if (data == NULL && count != 0)
            return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' is NULL but has a count",
                             type->name, f->name);
    }
    return SNELL_OK;
}

static snell_status add_whole(description *d, const type_info *type, const void *desc, bool owned,
                              object_source source, uint32_t *index) {
    snell_status status = check_place(d, type, source.name);
    if (status) return status;
    void *whole = memory_zeroed(1, type->desc_size);
    if (whole == NULL) return error_no_memory();
    status = take_desc(type, desc, whole);
    if (!status) status = check_desc(d, type, whole, NULL);
    if (!status) status = append_object(d, type, whole, owned, source, index);
    free(whole);
    return status;
}

snell_status description_add_desc(description *d, const type_info *type, const void *desc,
                                  object_source source, uint32_t *index) {
    return add_whole(d, type, desc, false, source, index);
}

snell_status description_take_desc(description *d, const type_info *type, const void *desc,
                                   object_source source, uint32_t *index) {
    return add_whole(d, type, desc, true, source, index);
}

snell_status description_add_instance(description *d, uint32_t shape, uint32_t material_index,
                                      const transform *to_world, object_source source,
                                      uint32_t *index) {
    if (shape >= d->objects[CATEGORY_SHAPE].count)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "an instance of a shape that does not exist");
    if (material_index != NO_MATERIAL && material_index >= d->objects[CATEGORY_MATERIAL].count)
        return error_set(SNELL_ERR_ARGUMENT, NULL,
                         "an instance with a material that does not exist");
    transform inverse, placed = to_world ? *to_world : transform_identity();
    if (!transform_inverse(&placed, &inverse))
        return error_set(SNELL_ERR_ARGUMENT, "scales must not be 0",
                         "a transform that flattens what it moves, or is not finite");
    if (d->instance_count >= UINT32_MAX - 1)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "too many instances");
    instance made = {.shape = shape,
                     .material = material_index,
                     .owner = NO_GROUP,
                     .to_world = placed,
                     .name = memory_copy_string(source.name ? source.name : ""),
                     .line = source.line};
    if (!made.name || !ARRAY_GROW(d->instances, d->instance_count, d->instance_capacity, 1)) {
        free(made.name);
        return error_no_memory();
    }
    if (index) *index = (uint32_t)d->instance_count;
    d->instances[d->instance_count++] = made;
    return SNELL_OK;
}

/* ---- groups ---- */

static bool meets_nothing(const void *desc, const local_ray *beam, hit *found) {
    (void)desc, (void)beam, (void)found;
    return false;
}

static bounds3 no_bounds(const void *desc) {
    (void)desc;
    return bounds3_empty();
}

typedef struct group_desc {
    size_t struct_size;
    uint32_t depth; /* of groups in it, with itself; of parts that were removed too */
} group_desc;

const primitive_type shape_group = {
    .info = {.name = "group", .category = CATEGORY_SHAPE, .desc_size = sizeof(group_desc)},
    .bounds = no_bounds,
    .intersect = meets_nothing};

bool object_is_group(const object *o) { return o->type == &shape_group.info; }

static snell_status too_deep(void) {
    return error_set(SNELL_ERR_ARGUMENT, "put parts into one group instead of groups in groups",
                     "groups are nested more than %d deep", GROUP_DEPTH_MAX);
}

snell_status description_add_user(description *d, const snell_user_shape_desc *desc,
                                  object_source source, uint32_t *index) {
    user_desc made;
    snell_status status = check_place(d, &shape_user.info, source.name);
    if (!status) status = user_desc_make(desc, &made);
    return status ? status : append_object(d, &shape_user.info, &made, false, source, index);
}

snell_status description_add_empty_group(description *d, object_source source, uint32_t *index) {
    const group_desc desc = {sizeof desc, 1};
    snell_status status = check_place(d, &shape_group.info, source.name);
    return status ? status : append_object(d, &shape_group.info, &desc, false, source, index);
}

snell_status description_set_owner(description *d, uint32_t index, uint32_t owner) {
    const object_list *shapes = &d->objects[CATEGORY_SHAPE];
    instance *at = &d->instances[index];
    if (owner >= shapes->count || !object_is_group(&shapes->items[owner]) || at->shape >= owner)
        return error_set(SNELL_ERR_ARGUMENT, NULL,
                         "an instance in a group that does not exist or was made before its part");
    const object *part = &shapes->items[at->shape];
    group_desc *group = shapes->items[owner].desc;
    if (object_is_group(part)) {
        uint32_t below = ((const group_desc *)part->desc)->depth;
        if (below >= GROUP_DEPTH_MAX) return too_deep();
        if (below >= group->depth) group->depth = below + 1;
    }
    at->owner = owner;
    return SNELL_OK;
}

static snell_status check_parts(const description *d, const uint32_t *parts, size_t count) {
    for (size_t i = 0; i < count; i++) {
        if (parts[i] >= d->instance_count || d->instances[parts[i]].removed)
            return error_set(SNELL_ERR_ARGUMENT, NULL, "group: part %zu does not exist", i + 1);
        if (d->instances[parts[i]].owner != NO_GROUP)
            return error_set(SNELL_ERR_ARGUMENT, "make another instance of its shape",
                             "group: part %zu is in a group already", i + 1);
    }
    return SNELL_OK;
}

snell_status description_add_group(description *d, const uint32_t *parts, size_t count,
                                   object_source source, uint32_t *index) {
    uint32_t made;
    snell_status status = check_parts(d, parts, count);
    if (!status) status = description_add_empty_group(d, source, &made);
    if (status) return status;
    for (size_t i = 0; i < count && !status; i++) {
        if (d->instances[parts[i]].owner != NO_GROUP)
            status = error_set(SNELL_ERR_ARGUMENT, NULL, "group: part %zu is given twice", i + 1);
        else
            status = description_set_owner(d, parts[i], made);
    }
    if (!status) {
        *index = made;
        return SNELL_OK;
    }
    for (size_t i = 0; i < count; i++) d->instances[parts[i]].owner = NO_GROUP;
    description_mark mark = description_get_mark(d);
    mark.objects[CATEGORY_SHAPE] = made;
    description_rewind(d, &mark);
    return status;
}

snell_status part_lists_make(const description *d, part_lists *out) {
    size_t shapes = d->objects[CATEGORY_SHAPE].count;
    *out = (part_lists){memory_zeroed(shapes + 3, sizeof *out->begin),
                        memory_resize(NULL, d->instance_count, sizeof *out->parts),
                        memory_zeroed(shapes, sizeof *out->depth)};
    if (!out->begin || !out->parts || !out->depth) return error_no_memory();
    for (size_t i = 0; i < d->instance_count; i++) {
        const instance *at = &d->instances[i];
        if (!at->removed) out->begin[(at->owner == NO_GROUP ? shapes : at->owner) + 2]++;
    }
    for (size_t g = 0; g <= shapes; g++) out->begin[g + 2] += out->begin[g + 1];
    for (size_t i = 0; i < d->instance_count; i++) {
        const instance *at = &d->instances[i];
        if (at->removed) continue;
        out->parts[out->begin[(at->owner == NO_GROUP ? shapes : at->owner) + 1]++] = (uint32_t)i;
    }
    for (size_t g = 0; g < shapes; g++) { /* parts come before their group */
        if (!object_is_group(&d->objects[CATEGORY_SHAPE].items[g])) continue;
        out->depth[g] = 1;
        for (uint32_t k = out->begin[g]; k < out->begin[g + 1]; k++) {
            uint32_t below = out->depth[d->instances[out->parts[k]].shape];
            if (below >= out->depth[g]) out->depth[g] = below + 1;
        }
        if (out->depth[g] > GROUP_DEPTH_MAX) return too_deep();
    }
    return SNELL_OK;
}

void part_lists_free(part_lists *lists) {
    free(lists->begin);
    free(lists->parts);
    free(lists->depth);
    *lists = (part_lists){NULL, NULL, NULL};
}

snell_status description_set_motion(description *d, uint32_t index, const motion_key *keys,
                                    size_t count) {
    instance *at = &d->instances[index];
    motion_key *copy = NULL;
    if (count) {
        snell_status status = motion_check(keys, count, "motion");
        if (status) return status;
        copy = memory_resize(NULL, count, sizeof *copy);
        if (copy == NULL) return error_no_memory();
        memcpy(copy, keys, count * sizeof *copy);
        at->to_world = copy[0].transform;
    }
    free(at->keys);
    at->keys = copy;
    at->key_count = count;
    return SNELL_OK;
}

snell_status description_add_param(description *d, const char *name, const char *kind,
                                   const char *value, const char *default_value, const char *help) {
    scene_param made = {memory_copy_string(name), memory_copy_string(kind),
                        memory_copy_string(value), memory_copy_string(default_value),
                        memory_copy_string(help ? help : "")};
    if (!made.name || !made.kind || !made.value || !made.default_value || !made.help ||
        !ARRAY_GROW(d->params, d->param_count, d->param_capacity, 1)) {
        free_param(&made);
        return error_no_memory();
    }
    d->params[d->param_count++] = made;
    return SNELL_OK;
}

snell_status description_add_message(description *d, snell_severity severity, const char *file,
                                     uint32_t line, const char *hint, const char *format, ...) {
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (d->message_count >= MESSAGES_MAX) return SNELL_OK;
    for (size_t i = 0; i < d->message_count; i++)
        if (strcmp(d->messages[i].text, text) == 0) return SNELL_OK;
    import_message made = {severity, memory_copy_string(text), memory_copy_string(hint ? hint : ""),
                           memory_copy_string(file ? file : ""), line};
    if (!made.text || !made.hint || !made.file ||
        !ARRAY_GROW(d->messages, d->message_count, d->message_capacity, 1)) {
        free_message(&made);
        return error_no_memory();
    }
    d->messages[d->message_count++] = made;
    return SNELL_OK;
}

/* ---- looking ---- */

const object *description_setting(const description *d, const char *type) {
    const object_list *list = &d->objects[CATEGORY_SETTING];
    for (size_t i = 0; i < list->count; i++)
        if (strcmp(list->items[i].type->name, type) == 0) return &list->items[i];
    return NULL;
}

void description_object_label(const description *d, category which, uint32_t index, char *out,
                              size_t size) {
    const object *o = &d->objects[which].items[index];
    if (o->name[0])
        snprintf(out, size, "%s", o->name);
    else if (o->line)
        snprintf(out, size, "%s:%u", o->type->name, o->line);
    else
        snprintf(out, size, "%s #%u", o->type->name, index + 1);
}
