/* Scenes: loading, adding, committing, and what is in them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "api/api.h"
#include "base/memory.h"
#include "geometry/mesh.h"
#include "exporters/exporter.h"
#include "importers/importer.h"
#include "scene/compiled.h"
#include "scene/records.h"
#include "scene/settings.h"

/* ---- readers and the editor ---- */

snell_status scene_begin_edit(snell_scene *s) {
    if (s == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "scene is NULL");
    pthread_mutex_lock(&s->lock);
    bool busy = s->readers > 0 || s->editing;
    if (!busy) s->editing = true;
    pthread_mutex_unlock(&s->lock);
    if (busy)
        return error_set(SNELL_ERR_STATE, "wait for the render or query to return, or cancel it",
                         "the scene is in use and cannot be edited");
    s->float_saved = floatenv_enter();
    return SNELL_OK;
}

void scene_end_edit(snell_scene *s) {
    floatenv_leave(s->float_saved);
    pthread_mutex_lock(&s->lock);
    s->editing = false;
    pthread_mutex_unlock(&s->lock);
}

static snell_status begin_read(const snell_scene *shared, bool committed) {
    if (shared == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "scene is NULL");
    snell_scene *s = (snell_scene *)(uintptr_t)shared;
    pthread_mutex_lock(&s->lock);
    bool editing = s->editing, ready = !editing && (s->frozen != NULL || !committed);
    if (ready) s->readers++;
    pthread_mutex_unlock(&s->lock);
    if (editing) return error_set(SNELL_ERR_STATE, NULL, "the scene is being edited");
    if (!ready)
        return error_set(SNELL_ERR_STATE, "call snell_scene_commit first",
                         "the scene was not committed");
    return SNELL_OK;
}

snell_status scene_begin_look(const snell_scene *s) { return begin_read(s, false); }
snell_status scene_begin_read(const snell_scene *s) { return begin_read(s, true); }

void scene_end_read(const snell_scene *shared) {
    snell_scene *s = (snell_scene *)(uintptr_t)shared;
    pthread_mutex_lock(&s->lock);
    s->readers--;
    pthread_mutex_unlock(&s->lock);
}

snell_status snell_scene_create(snell_context *context, snell_scene **out) {
    if (context == NULL || out == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_scene_create: an argument is NULL");
    snell_scene *s = memory_zeroed(1, sizeof *s);
    if (s == NULL) return error_no_memory();
    snell_status status = description_create(&s->description);
    if (status) {
        free(s);
        return status;
    }
    s->context = context;
    pthread_mutex_init(&s->lock, NULL);
    *out = s;
    return SNELL_OK;
}

void snell_scene_destroy(snell_scene *s) {
    if (s == NULL) return;
    scene_destroy(s->frozen);
    description_destroy(s->description);
    pthread_mutex_destroy(&s->lock);
    free(s);
}

/* ---- loading ---- */

typedef struct load_progress {
    const snell_load_desc *desc;
} load_progress;

static bool report_read(void *user, double fraction) {
    const load_progress *p = user;
    snell_progress progress = {
        .struct_size = sizeof progress, .phase = "read", .fraction = fraction, .seconds_left = -1};
    return p->desc->progress(p->desc->user, &progress);
}

static void forward_messages(const snell_scene *s, size_t first) {
    for (size_t i = first; i < s->description->message_count; i++) {
        const import_message *m = &s->description->messages[i];
        log_write(&s->context->log, m->severity, (source_place){m->file, m->line, 0}, m->hint, "%s",
                  m->text);
    }
}

static snell_status check_load(const char *path, const snell_load_desc *desc) {
    if (path == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_scene_load: path is NULL");
    if (desc->struct_size != sizeof *desc)
        return error_set(SNELL_ERR_VERSION, "compile against the library's own header",
                         "snell_scene_load: the description has another version's size");
    if ((desc->params == NULL && desc->param_count > 0) ||
        (desc->asset_dirs == NULL && desc->asset_dir_count > 0))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_scene_load: a list is NULL");
    for (size_t i = 0; i < desc->param_count; i++)
        if (desc->params[i] == NULL)
            return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_scene_load: a parameter is NULL");
    for (size_t i = 0; i < desc->asset_dir_count; i++)
        if (desc->asset_dirs[i] == NULL)
            return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_scene_load: a folder is NULL");
    if (desc->frame > FRAME_MAX)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_scene_load: frame %u; at most %d",
                         desc->frame, FRAME_MAX);
    return SNELL_OK;
}

static snell_status read_file(const char *path, const snell_load_desc *desc,
                              const helper_options *options, description *d) {
    bool compiled =
        options->format ? strcmp(options->format, "snell") == 0 : compiled_is_file(path);
    if (compiled) return compiled_import(path, &options->import, d);
    if (!desc->allow_helper)
        return error_set(SNELL_ERR_UNSUPPORTED, "set allow_helper",
                         "files are read by snell-import, which was not allowed");
    return helper_import(path, options, d);
}

snell_status snell_scene_load(snell_scene *s, const char *path, const snell_load_desc *desc) {
    snell_load_desc defaults = SNELL_INIT(load_desc);
    if (desc == NULL) desc = &defaults;
    snell_status status = check_load(path, desc);
    if (!status) status = scene_begin_edit(s);
    if (status) return status;
    load_progress progress = {desc};
    helper_options options = {.import = {.params = desc->params,
                                         .param_count = desc->param_count,
                                         .asset_dirs = desc->asset_dirs,
                                         .asset_dir_count = desc->asset_dir_count,
                                         .up = desc->up,
                                         .allow_programs = desc->allow_programs,
                                         .frame = desc->frame,
                                         .next_frame = desc->next_frame,
                                         .memory_max = desc->memory_max},
                              .format = desc->format,
                              .time_max = desc->time_max,
                              .progress = desc->progress ? report_read : NULL,
                              .user = &progress};
    size_t first = s->description->message_count;
    status = read_file(path, desc, &options, s->description);
    forward_messages(s, first);
    scene_end_edit(s);
    return status;
}

/* ---- saving ---- */

static const struct {
    const char *extension;
    snell_status (*write)(const description *d, const char *path);
} saved_formats[] = {{".snell", compiled_write}, {".lua", lua_write}};

/* Shapes by the caller's functions are no data. */
static snell_status check_types(const description *d) {
    const object_list *shapes = &d->objects[CATEGORY_SHAPE];
    for (size_t i = 0; i < shapes->count; i++) {
        const object *o = &shapes->items[i];
        if (!object_is_group(o) && type_find(CATEGORY_SHAPE, o->type->name) != o->type)
            return error_set(SNELL_ERR_UNSUPPORTED, "make it of shapes that snell has",
                             "shape %zu is by functions of the caller, which no file can hold",
                             i + 1);
    }
    return SNELL_OK;
}

snell_status snell_scene_save(const snell_scene *s, const char *path) {
    if (path == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_scene_save: path is NULL");
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    size_t count = sizeof saved_formats / sizeof saved_formats[0], i = 0;
    while (i < count && (dot == NULL || strcasecmp(dot, saved_formats[i].extension) != 0)) i++;
    if (i == count)
        return error_set(SNELL_ERR_ARGUMENT, "the extension says how it is written: .snell or .lua",
                         "'%s' is no kind of scene that snell writes", path);
    snell_status status = scene_begin_look(s);
    if (status) return status;
    unsigned saved = floatenv_enter();
    status = check_types(s->description);
    if (!status) status = saved_formats[i].write(s->description, path);
    floatenv_leave(saved);
    scene_end_read(s);
    return status;
}

/* ---- adding ---- */

static snell_status add_generic(snell_scene *s, category what, const char *type,
                                const snell_param *params, size_t count, uint32_t *index1) {
    if (type == NULL || (params == NULL && count > 0))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    snell_status status = scene_begin_edit(s);
    if (status) return status;
    uint32_t index = 0;
    status = description_add(s->description, what, type, params, count, (object_source){0}, &index);
    scene_end_edit(s);
    if (!status) *index1 = index + 1;
    return status;
}

snell_status scene_add_typed(snell_scene *s, category what, const char *type, const void *desc,
                             uint32_t *index1) {
    if (desc == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: desc is NULL", type);
    snell_status status = scene_begin_edit(s);
    if (status) return status;
    uint32_t index = 0;
    status = description_add_desc(s->description, type_find(what, type), desc, (object_source){0},
                                  &index);
    scene_end_edit(s);
    if (!status) *index1 = index + 1;
    return status;
}

/* The five public forms differ only in the id's type. */
#define DEFINE_ADD(noun, CATEGORY)                                                                 \
    snell_status snell_scene_add_##noun(snell_scene *s, const char *type,                          \
                                        const snell_param *params, size_t count,                   \
                                        snell_##noun##_id *out) {                                  \
        uint32_t index1 = 0;                                                                       \
        snell_status status = add_generic(s, CATEGORY, type, params, count, &index1);              \
        if (!status && out) *out = (snell_##noun##_id){index1, 0};                                 \
        return status;                                                                             \
    }
DEFINE_ADD(texture, CATEGORY_TEXTURE)
DEFINE_ADD(material, CATEGORY_MATERIAL)
DEFINE_ADD(light, CATEGORY_LIGHT)
DEFINE_ADD(shape, CATEGORY_SHAPE)
DEFINE_ADD(camera, CATEGORY_CAMERA)

snell_status snell_scene_add_instance(snell_scene *s, snell_shape_id shape,
                                      snell_material_id material_id,
                                      const snell_transform *to_world, snell_instance_id *out) {
    snell_status status = scene_begin_edit(s);
    if (status) return status;
    uint32_t index = 0;
    if (shape.index1 == 0)
        status = error_set(SNELL_ERR_ARGUMENT, NULL, "an instance needs a shape");
    if (!status && (shape.generation != 0 || material_id.generation != 0)) /* none is removed */
        status = error_set(SNELL_ERR_ARGUMENT, "ids come from the calls that add things",
                           "an instance of what was never added");
    uint32_t m = material_id.index1 ? material_id.index1 - 1 : NO_MATERIAL;
    transform identity = transform_identity();
    if (!status)
        status =
            description_add_instance(s->description, shape.index1 - 1, m,
                                     to_world ? to_world : &identity, (object_source){0}, &index);
    if (!status && out)
        *out = (snell_instance_id){index + 1, s->description->instances[index].generation};
    scene_end_edit(s);
    return status;
}

snell_status snell_scene_add_user_shape(snell_scene *s, const snell_user_shape_desc *desc,
                                        const char *name, snell_shape_id *out) {
    if (desc == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "user shape: desc is NULL");
    snell_status status = scene_begin_edit(s);
    if (status) return status;
    uint32_t index = 0;
    status = description_add_user(s->description, desc, (object_source){.name = name}, &index);
    if (!status && out) *out = (snell_shape_id){index + 1, 0};
    scene_end_edit(s);
    return status;
}

snell_status snell_scene_add_group(snell_scene *s, const snell_instance_id *parts, size_t count,
                                   const char *name, snell_shape_id *out) {
    if (parts == NULL && count > 0) return error_set(SNELL_ERR_ARGUMENT, NULL, "parts is NULL");
    snell_status status = scene_begin_edit(s);
    if (status) return status;
    const description *d = s->description;
    uint32_t *indices = memory_resize(NULL, count, sizeof *indices), index = 0;
    if (indices == NULL) status = error_no_memory();
    for (size_t i = 0; i < count && !status; i++) {
        uint32_t at = parts[i].index1 - 1; /* 0 becomes too large */
        if (at >= d->instance_count || d->instances[at].generation != parts[i].generation)
            status = error_set(SNELL_ERR_ARGUMENT, "instances of this scene",
                               "group: part %zu does not exist", i + 1);
        else
            indices[i] = at;
    }
    if (!status)
        status = description_add_group(s->description, indices, count,
                                       (object_source){.name = name}, &index);
    free(indices);
    if (!status && out) *out = (snell_shape_id){index + 1, 0};
    scene_end_edit(s);
    return status;
}

static snell_status find_instance(snell_scene *s, snell_instance_id id, instance **out) {
    description *d = s->description;
    if (id.index1 == 0 || id.index1 > d->instance_count || d->instances[id.index1 - 1].removed ||
        d->instances[id.index1 - 1].generation != id.generation)
        return error_set(SNELL_ERR_ARGUMENT, "it may have been removed",
                         "there is no such instance");
    *out = &d->instances[id.index1 - 1];
    return SNELL_OK;
}

snell_status snell_scene_set_instance_transform(snell_scene *s, snell_instance_id id,
                                                const snell_transform *to_world) {
    snell_status status = scene_begin_edit(s);
    if (status) return status;
    instance *at = NULL;
    transform identity = transform_identity(), inverse;
    if (to_world == NULL) to_world = &identity;
    status = find_instance(s, id, &at);
    if (!status && !transform_inverse(to_world, &inverse))
        status = error_set(SNELL_ERR_ARGUMENT, "a scale of 0 squashes the shape flat",
                           "the transform cannot be inverted");
    if (!status) status = description_set_motion(s->description, id.index1 - 1, NULL, 0);
    if (!status) at->to_world = *to_world;
    scene_end_edit(s);
    return status;
}

snell_status snell_scene_set_instance_motion(snell_scene *s, snell_instance_id id,
                                             const snell_motion_key *keys, size_t count) {
    if (keys == NULL || count == 0)
        return error_set(SNELL_ERR_ARGUMENT, "snell_scene_set_instance_transform ends a motion",
                         "a motion needs a key");
    snell_status status = scene_begin_edit(s);
    if (status) return status;
    instance *at = NULL;
    status = find_instance(s, id, &at);
    if (!status) status = description_set_motion(s->description, id.index1 - 1, keys, count);
    scene_end_edit(s);
    return status;
}

snell_status snell_scene_remove_instance(snell_scene *s, snell_instance_id id) {
    snell_status status = scene_begin_edit(s);
    if (status) return status;
    instance *at = NULL;
    status = find_instance(s, id, &at);
    if (!status) {
        at->removed = true;
        at->generation++;
    }
    scene_end_edit(s);
    return status;
}

/* Settings exist once: a later call replaces what an earlier one, or the file, said. */
static snell_status set_setting(snell_scene *s, const type_info *type, const void *desc) {
    snell_status status = scene_begin_edit(s);
    if (status) return status;
    object *old = (object *)(uintptr_t)description_setting(s->description, type->name);
    void *copy = desc_copy(type, desc);
    if (copy == NULL) status = error_no_memory();
    if (!status) status = desc_check(type, copy, NULL);
    if (!status && old) {
        desc_free(type, old->desc);
        old->desc = copy;
        copy = NULL;
    } else if (!status) {
        uint32_t index;
        status = description_add_desc(s->description, type, desc, (object_source){0}, &index);
    }
    desc_free(type, copy);
    scene_end_edit(s);
    return status;
}

snell_status snell_scene_set_background(snell_scene *s, snell_vec3 color, float alpha) {
    background_desc desc;
    desc_init(&setting_background, &desc);
    desc.color = color;
    desc.alpha = alpha;
    return set_setting(s, &setting_background, &desc);
}

snell_status snell_scene_set_background_gradient(snell_scene *s, snell_vec3 bottom,
                                                 snell_vec3 top) {
    background_desc desc;
    desc_init(&setting_background, &desc);
    if (!(top.x >= 0 && top.y >= 0 && top.z >= 0)) /* in the table, -1 stands for no gradient */
        return error_set(SNELL_ERR_ARGUMENT, NULL, "background: 'top' cannot be negative");
    desc.color = bottom;
    desc.top = top;
    return set_setting(s, &setting_background, &desc);
}

snell_status snell_scene_set_ambient(snell_scene *s, snell_vec3 color) {
    ambient_desc desc;
    desc_init(&setting_ambient, &desc);
    desc.color = color;
    return set_setting(s, &setting_ambient, &desc);
}

snell_status snell_scene_set_animation(snell_scene *s, const snell_animation *clock) {
    if (clock == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    if (clock->struct_size != sizeof *clock)
        return error_set(SNELL_ERR_VERSION, NULL, "struct_size is another version's");
    animation_desc desc;
    desc_init(&setting_animation, &desc);
    desc.fps = clock->fps;
    desc.first = clock->first;
    desc.last = clock->last;
    desc.frame = clock->frame;
    return set_setting(s, &setting_animation, &desc);
}

snell_status snell_scene_get_animation(const snell_scene *s, snell_animation *out) {
    if (out == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    if (out->struct_size != sizeof *out)
        return error_set(SNELL_ERR_VERSION, NULL, "struct_size is another version's");
    snell_status status = scene_begin_look(s);
    if (status) return status;
    const object *said = description_setting(s->description, "animation");
    *out = SNELL_INIT(animation);
    out->frame_count = 0;
    if (said) {
        const animation_desc *clock = said->desc;
        out->fps = clock->fps;
        out->first = clock->first;
        out->last = clock->last;
        out->frame = clock->frame;
        out->frame_count = (uint32_t)(clock->last - clock->first + 1);
    }
    scene_end_read(s);
    return SNELL_OK;
}

/* ---- commit ---- */

typedef struct commit_progress {
    snell_progress_fn *progress;
    void *user;
} commit_progress;

static bool report_build(void *user, double fraction) {
    const commit_progress *p = user;
    snell_progress progress = {
        .struct_size = sizeof progress, .phase = "build", .fraction = fraction, .seconds_left = -1};
    return p->progress(p->user, &progress);
}

/* What cannot be seen is most likely a mistake: a solid without a point, a mesh without area, a
 * surface outside of its box. A file may have very many: the first are named, the rest are counted. */
static void warn_of_empty(const snell_scene *s) {
    enum { NAMED_MAX = 8 };
    const solid_set *set = s->frozen->solids;
    const object_list *shapes = &s->description->objects[CATEGORY_SHAPE];
    size_t found = 0;
    for (size_t i = 0; i < shapes->count; i++) {
        const object *o = &shapes->items[i];
        const primitive_type *type = (const primitive_type *)o->type;
        const char *why = type->nothing ? type->nothing(o->desc) : NULL;
        bool solid =
            i < set->shape_count && set->solids[i] && bounds3_is_empty(set->solids[i]->bounds);
        if (solid) why = "is empty";
        if (why == NULL || ++found > NAMED_MAX) continue;
        char label[128];
        description_object_label(s->description, CATEGORY_SHAPE, (uint32_t)i, label, sizeof label);
        log_write(&s->context->log, SNELL_WARNING, (source_place){o->file, o->line, 0},
                  solid ? "its shapes have nothing in common" : NULL,
                  "%s %s: nothing of it is drawn", label, why);
    }
    if (found > NAMED_MAX)
        log_write(&s->context->log, SNELL_WARNING, (source_place){0}, NULL,
                  "nothing is drawn of %zu more shapes", found - NAMED_MAX);
}

static accel_quality quality_of(snell_build build) {
    return build == SNELL_BUILD_FAST   ? ACCEL_FAST
           : build == SNELL_BUILD_BEST ? ACCEL_BEST
                                       : ACCEL_BALANCED;
}

snell_status snell_scene_commit(snell_scene *s, snell_progress_fn *progress, void *user) {
    snell_status status = scene_begin_edit(s);
    if (status) return status;
    commit_progress forward = {progress, user};
    scene_options options = {.accel = {.quality = quality_of(s->context->build),
                                       .progress = progress ? report_build : NULL,
                                       .user = &forward},
                             .memory_max = s->context->memory_max};
    scene *frozen;
    status = scene_freeze(s->description, &options, s->context->pool, &frozen);
    if (!status) {
        scene_destroy(s->frozen);
        s->frozen = frozen;
        warn_of_empty(s);
    }
    scene_end_edit(s);
    return status;
}

snell_status snell_scene_bounds(const snell_scene *s, snell_bounds *out) {
    if (out == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    snell_status status = scene_begin_look(s);
    if (status) return status;
    unsigned saved = floatenv_enter();
    *out = s->frozen ? s->frozen->bounds : description_bounds(s->description);
    floatenv_leave(saved);
    scene_end_read(s);
    return SNELL_OK;
}

/* ---- what is in a scene ---- */

snell_status snell_scene_hash(const snell_scene *s, uint64_t *out) {
    if (out == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    snell_status status = scene_begin_look(s);
    if (status) return status;
    status = records_hash(s->description, out);
    scene_end_read(s);
    return status;
}

static uint64_t array_bytes(const object *o) {
    uint64_t sum = 0;
    for (uint32_t i = 0; i < o->type->field_count; i++) {
        const field *f = &o->type->fields[i];
        size_t size = field_element_size(f->kind), count;
        if (size == 0) continue;
        memcpy(&count, (const char *)o->desc + f->offset + sizeof(void *), sizeof count);
        sum += size * count;
    }
    return sum;
}

typedef struct drawn {
    uint64_t shapes, primitives, triangles;
} drawn;

/* What a list draws; groups: what those of earlier shapes draw. Counts end at 2^60. */
static drawn count_list(const description *d, const part_lists *lists, size_t list,
                        const drawn *groups) {
    const uint64_t most = 1ull << 60;
    drawn all = {0, 0, 0};
    for (uint32_t i = lists->begin[list]; i < lists->begin[list + 1]; i++) {
        uint32_t index = d->instances[lists->parts[i]].shape;
        const object *shape = &d->objects[CATEGORY_SHAPE].items[index];
        const primitive_type *type = (const primitive_type *)shape->type;
        uint64_t count = type == &primitive_solid ? shape_part_count(d, index)
                                                  : primitive_count_of(type, shape->desc);
        drawn one = {1, count, type == &primitive_mesh ? count : 0};
        if (object_is_group(shape)) one = groups[index];
        all.shapes = all.shapes + one.shapes < most ? all.shapes + one.shapes : most;
        all.primitives =
            all.primitives + one.primitives < most ? all.primitives + one.primitives : most;
        all.triangles = all.triangles + one.triangles < most ? all.triangles + one.triangles : most;
    }
    return all;
}

static snell_status count_instances(const description *d, snell_scene_stats *out) {
    const object_list *shapes = &d->objects[CATEGORY_SHAPE];
    part_lists lists;
    snell_status status = part_lists_make(d, &lists);
    drawn *groups = memory_zeroed(shapes->count, sizeof *groups);
    if (!status && !groups) status = error_no_memory();
    if (!status) {
        for (size_t g = 0; g < shapes->count; g++)
            if (object_is_group(&shapes->items[g])) groups[g] = count_list(d, &lists, g, groups);
        drawn all = count_list(d, &lists, shapes->count, groups);
        out->instance_count = all.shapes;
        out->primitive_count = all.primitives;
        out->triangle_count = all.triangles;
    }
    free(groups);
    part_lists_free(&lists);
    for (size_t i = 0; i < shapes->count && !status; i++) {
        if (shapes->items[i].type == &primitive_mesh.info)
            out->unique_triangle_count += mesh_triangle_count(shapes->items[i].desc);
        out->memory_geometry += array_bytes(&shapes->items[i]);
    }
    return status;
}

bool description_has_dielectric(const description *d) {
    const object_list *materials = &d->objects[CATEGORY_MATERIAL];
    for (size_t i = 0; i < materials->count; i++)
        if (material_bounds_medium((const material_type *)materials->items[i].type,
                                   materials->items[i].desc))
            return true;
    return false;
}

bool description_has_emission(const description *d) {
    const object_list *materials = &d->objects[CATEGORY_MATERIAL];
    for (size_t i = 0; i < materials->count; i++)
        if (material_emits((const material_type *)materials->items[i].type,
                           materials->items[i].desc))
            return true;
    return false;
}

snell_status snell_scene_get_stats(const snell_scene *s, snell_scene_stats *out) {
    if (s == NULL || out == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    if (out->struct_size != sizeof *out)
        return error_set(SNELL_ERR_VERSION, NULL, "struct_size is another version's");
    snell_status status = scene_begin_look(s);
    if (status) return status;
    const description *d = s->description;
    *out = (snell_scene_stats){.struct_size = sizeof *out,
                               .format = d->format,
                               .shape_count = (uint32_t)d->objects[CATEGORY_SHAPE].count,
                               .material_count = (uint32_t)d->objects[CATEGORY_MATERIAL].count,
                               .texture_count = (uint32_t)d->objects[CATEGORY_TEXTURE].count,
                               .light_count = (uint32_t)d->objects[CATEGORY_LIGHT].count,
                               .camera_count = (uint32_t)d->objects[CATEGORY_CAMERA].count,
                               .param_count = (uint32_t)d->param_count,
                               .has_emission = description_has_emission(d),
                               .has_dielectric = description_has_dielectric(d),
                               .has_background = description_setting(d, "background") != NULL,
                               .has_ambient = description_setting(d, "ambient") != NULL};
    status = count_instances(d, out);
    out->memory_planned = scene_plan_memory(d, thread_pool_size(s->context->pool));
    for (size_t i = 0; i < d->objects[CATEGORY_TEXTURE].count; i++)
        out->memory_textures += array_bytes(&d->objects[CATEGORY_TEXTURE].items[i]);
    if (s->frozen) {
        accel_memory memory = accel_get_memory(s->frozen->accel);
        out->memory_textures += scene_texture_memory(s->frozen);
        out->memory_accel = memory.node_bytes + memory.triangle_bytes + memory.other_bytes +
                            solid_set_memory(s->frozen->solids);
    }
    scene_end_read(s);
    return status;
}

static snell_status get_object(const snell_scene *s, category what, uint32_t index,
                               snell_object_info *out) {
    if (out == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    snell_status status = scene_begin_look(s);
    if (status) return status;
    const object_list *list = &s->description->objects[what];
    if (index < list->count) {
        const object *o = &list->items[index];
        *out = (snell_object_info){o->type->name, o->name, o->line};
    } else {
        status = error_set(SNELL_ERR_ARGUMENT, NULL, "there are %zu %ss, counted from 0",
                           list->count, category_name(what));
    }
    scene_end_read(s);
    return status;
}

snell_status snell_scene_get_camera(const snell_scene *s, uint32_t index, snell_object_info *out,
                                    snell_camera_id *id) {
    snell_status status = get_object(s, CATEGORY_CAMERA, index, out);
    if (!status && id) *id = (snell_camera_id){index + 1, 0};
    return status;
}

snell_view view_from_perspective(const perspective_desc *c) {
    snell_view v = SNELL_INIT(view);
    v.from = c->from, v.at = c->at, v.up = c->up, v.fov = c->fov;
    v.lens_radius = c->lens_radius, v.focus = c->focus;
    v.blades = c->blades, v.blade_rotation = c->blade_rotation;
    v.shutter = c->shutter;
    v.motion = c->motion, v.motion_count = c->motion_count;
    return v;
}

perspective_desc view_to_perspective(const snell_view *v) {
    perspective_desc c;
    desc_init(&camera_perspective.info, &c);
    c.from = v->from, c.at = v->at, c.up = v->up, c.fov = v->fov;
    c.lens_radius = v->lens_radius, c.focus = v->focus;
    c.blades = v->blades, c.blade_rotation = v->blade_rotation;
    c.shutter = v->shutter;
    c.motion = v->motion, c.motion_count = v->motion ? v->motion_count : 0;
    return c;
}

static snell_status get_view(const description *d, snell_camera_id camera, snell_view *out) {
    const object_list *list = &d->objects[CATEGORY_CAMERA];
    uint32_t index = camera.index1 ? camera.index1 - 1 : 0;
    if (index >= list->count || camera.generation != 0)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "there is no camera %u", index + 1);
    const object *o = &list->items[index];
    if (o->type != &camera_perspective.info)
        return error_set(SNELL_ERR_UNSUPPORTED, NULL, "a camera of type %s has no view",
                         o->type->name);
    *out = view_from_perspective(o->desc);
    return SNELL_OK;
}

snell_status snell_scene_get_view(const snell_scene *s, snell_camera_id camera, snell_view *out) {
    if (out == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    snell_status status = scene_begin_look(s);
    if (status) return status;
    status = get_view(s->description, camera, out);
    scene_end_read(s);
    return status;
}

snell_status snell_scene_get_light(const snell_scene *s, uint32_t index, snell_object_info *out) {
    return get_object(s, CATEGORY_LIGHT, index, out);
}

snell_status snell_scene_get_material(const snell_scene *s, uint32_t index,
                                      snell_object_info *out) {
    return get_object(s, CATEGORY_MATERIAL, index, out);
}

snell_status snell_scene_get_param(const snell_scene *s, uint32_t index, snell_scene_param *out) {
    if (out == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    snell_status status = scene_begin_look(s);
    if (status) return status;
    const description *d = s->description;
    if (index < d->param_count) {
        const scene_param *p = &d->params[index];
        *out = (snell_scene_param){p->name, p->kind, p->value, p->default_value, p->help};
    } else {
        status = error_set(SNELL_ERR_ARGUMENT, NULL, "there are %zu parameters, counted from 0",
                           d->param_count);
    }
    scene_end_read(s);
    return status;
}
