/* What a scene program takes from outside: other files (model, include, mesh, image) and values
 * from the command line (param). */
#include "importers/lua_scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/files.h"
#include "importers/image_float.h"

/* ---- another file's description into this one ---- */

/* Where the numbers of the other description's objects begin in this one. */
typedef struct merge {
    lua_State *L;
    description *from, *to;
    uint32_t texture, material;
    /* Of each shape of the other's its number here, of a group its node; on the stack. */
    uint32_t *shapes;
} merge;

static void destroy_description(void *held) { description_destroy(held); }

/* A name that is free in this description: "wood", "wood.2", ... */
static const char *free_name(const merge *m, category which, const char *name, char *out,
                             size_t size) {
    if (name[0] == '\0') return NULL;
    snprintf(out, size, "%s", name);
    for (unsigned i = 2; description_find(m->to, which, out); i++)
        snprintf(out, size, "%.*s.%u", (int)size - 12, name, i);
    return out;
}

/* Makes the ids in a description struct those of this description. */
static void renumber(const merge *m, const type_info *type, void *desc) {
    for (uint32_t i = 0; i < type->field_count; i++) {
        void *at = (char *)desc + type->fields[i].offset;
        switch (type->fields[i].kind) {
        case FIELD_INPUT:
        case FIELD_SCALAR: at = &((snell_input *)at)->texture; /* fall through */
        case FIELD_TEXTURE:
            if (((snell_texture_id *)at)->index1) ((snell_texture_id *)at)->index1 += m->texture;
            break;
        case FIELD_MATERIAL:
            if (((snell_material_id *)at)->index1) ((snell_material_id *)at)->index1 += m->material;
            break;
        case FIELD_MATERIALS: {
            struct {
                snell_material_id *data; /* owned by the other description, which is ours */
                size_t count;
            } list;
            memcpy(&list, at, sizeof list);
            for (size_t k = 0; k < list.count; k++)
                if (list.data[k].index1) list.data[k].index1 += m->material;
            break;
        }
        case FIELD_SHAPES: {
            struct {
                snell_shape_id *data;
                size_t count;
            } list;
            memcpy(&list, at, sizeof list);
            for (size_t k = 0; k < list.count; k++) /* earlier ones, of which none is a group */
                list.data[k].index1 = 1 + m->shapes[list.data[k].index1 - 1];
            break;
        }
        default: break;
        }
    }
}

/* Keys that move what t has moved: t k t^-1. */
static void move_keys(void *member, const transform *t) {
    struct {
        motion_key *data; /* owned by the other description, which is ours */
        size_t count;
    } list;
    transform inverse;
    memcpy(&list, member, sizeof list);
    if (!transform_inverse(t, &inverse)) return;
    placement there = dtransform_from(t), back = dtransform_from(&inverse);
    for (size_t i = 0; i < list.count; i++) {
        placement key = dtransform_from(&list.data[i].transform);
        key = dtransform_multiply(&there, &key);
        key = dtransform_multiply(&key, &back);
        list.data[i].transform = dtransform_round(&key);
    }
}

/* Lights and cameras have no transform: their points and directions are moved. */
static void move(const type_info *type, void *desc, const transform *t) {
    for (uint32_t i = 0; i < type->field_count; i++) {
        const field *f = &type->fields[i];
        if (f->kind == FIELD_KEYS) move_keys((char *)desc + f->offset, t);
        if (f->kind != FIELD_VEC3) continue;
        snell_vec3 *v = (snell_vec3 *)(void *)((char *)desc + f->offset);
        if (f->flags & FIELD_UNIT_LENGTH)
            *v = vec3_from(dvec3_normalize(transform_vector(t, dvec3_from(*v))));
        else if (strcmp(f->unit, "m") == 0)
            *v = vec3_from(transform_point(t, dvec3_from(*v)));
    }
}

static void merge_category(merge *m, category which, const transform *moved) {
    object_list *list = &m->from->objects[which];
    sandbox_charge(m->L, 20 * (uint64_t)list->count);
    for (size_t i = 0; i < list->count; i++) {
        object *o = &list->items[i];
        char name[512];
        if (object_is_group(o)) continue; /* it becomes nodes */
        if (which == CATEGORY_SHAPE) m->shapes[i] = (uint32_t)m->to->objects[which].count;
        renumber(m, o->type, o->desc);
        if (moved) move(o->type, o->desc, moved);
        object_source source = {free_name(m, which, o->name, name, sizeof name), o->file, o->line};
        if (description_add_desc(m->to, o->type, o->desc, source, NULL))
            scene_fail_last(m->L, NULL, NULL);
    }
}

/* A parameter may be asked for in several places, but has one default: the command line and 'snell
 * info' know one. */
static void add_param(lua_State *L, const scene_param *p) {
    description *d = scene_of(L)->d;
    for (size_t i = 0; i < d->param_count; i++) {
        const scene_param *made = &d->params[i];
        if (strcmp(made->name, p->name) != 0) continue;
        if (strcmp(made->default_value, p->default_value) == 0 && strcmp(made->kind, p->kind) == 0)
            return;
        scene_fail(L, SNELL_ERR_SYNTAX, "give both the same, or keep the value in a variable",
                   "param '%s': the default was %s before, and is %s here", p->name,
                   made->default_value, p->default_value);
    }
    if (description_add_param(d, p->name, p->kind, p->value, p->default_value, p->help))
        scene_fail_last(L, NULL, NULL);
}

static void merge_notes(const merge *m) {
    for (size_t i = 0; i < m->from->param_count; i++) add_param(m->L, &m->from->params[i]);
    for (size_t i = 0; i < m->from->message_count; i++) {
        const import_message *n = &m->from->messages[i];
        if (description_add_message(m->to, n->severity, n->file, n->line, n->hint, "%s", n->text))
            scene_fail_last(m->L, NULL, NULL);
    }
}

/* Meshes with materials of their own per triangle lose them: the model's material is for all. */
static void drop_slots(description *from) {
    object_list *list = &from->objects[CATEGORY_SHAPE];
    for (size_t i = 0; i < list->count; i++)
        for (uint32_t k = 0; k < list->items[i].type->field_count; k++) {
            const field *f = &list->items[i].type->fields[k];
            if (f->kind != FIELD_MATERIALS && strcmp(f->name, "material_slots") != 0) continue;
            size_t none = 0; /* the array itself stays the owner's */
            memcpy((char *)list->items[i].desc + f->offset + sizeof(void *), &none, sizeof none);
        }
}

static void destroy_lists(void *held) {
    part_lists_free(held);
    free(held);
}

/* An instance becomes a node; returns its number. */
static uint32_t merge_instance(const merge *m, const instance *one) {
    lua_State *L = m->L;
    node made = {.shape = m->shapes[one->shape],
                 .material =
                     one->material == NO_MATERIAL ? NO_MATERIAL : one->material + m->material,
                 .line = one->line,
                 .placed = one->key_count ? dtransform_identity() : dtransform_from(&one->to_world),
                 .motion = one->key_count ? motion_add(L, one->keys, one->key_count) : 0,
                 .name = one->name[0] ? one->name : NULL};
    if (object_is_group(&m->from->objects[CATEGORY_SHAPE].items[one->shape])) {
        made.overrides = !one->fills;
        nodes_add_group(L, &made, "group", &m->shapes[one->shape], 1);
    } else {
        nodes_add_shape(L, &made);
    }
    lua_pop(L, 1);
    return (uint32_t)(scene_of(L)->node_count - 1);
}

/* The instances become nodes, groups those of their parts; pushes the group of them all. */
static void merge_instances(const merge *m, const node *like, const char *label) {
    lua_State *L = m->L;
    size_t shapes = m->from->objects[CATEGORY_SHAPE].count;
    uint32_t *parts = lua_newuserdatauv(L, (m->from->instance_count + 1) * sizeof *parts, 0);
    box *holder = box_push(L, destroy_lists);
    part_lists *lists = holder->held = memory_zeroed(1, sizeof *lists);
    if (lists == NULL) scene_fail(L, SNELL_ERR_MEMORY, NULL, "out of memory");
    if (part_lists_make(m->from, lists)) scene_fail_last(L, NULL, NULL);
    sandbox_charge(L, 20 * (uint64_t)m->from->instance_count);
    for (size_t k = 0; k <= shapes; k++) { /* the world comes last */
        const object *o = k < shapes ? &m->from->objects[CATEGORY_SHAPE].items[k] : NULL;
        if (o && !object_is_group(o)) continue;
        size_t count = 0;
        for (uint32_t i = lists->begin[k]; i < lists->begin[k + 1]; i++)
            parts[count++] = merge_instance(m, &m->from->instances[lists->parts[i]]);
        node group = {.shape = NO_SHAPE,
                      .material = NO_MATERIAL,
                      .shared = true,
                      .placed = dtransform_identity(),
                      .line = o ? o->line : 0};
        if (o == NULL) {
            group = *like;
            group.overrides = true;
        }
        nodes_add_group(L, &group, label, parts, count);
        if (o == NULL) return;
        m->shapes[k] = (uint32_t)(scene_of(L)->node_count - 1);
        lua_pop(L, 1);
    }
}

const char *files_resolve(lua_State *L, const char *name) {
    lua_scene *s = scene_of(L);
    box *path = box_push(L, free);
    char *found = NULL;
    if (import_resolve(s->path, name, s->options, &found)) scene_fail_last(L, NULL, NULL);
    path->held = found;
    return found;
}

typedef struct wanted {
    bool camera, lights, settings, flat;
    const char *animation; /* NULL: the model's first, if the scene has a clock */
} wanted;

/* Reads the file and adds what is wanted of it; pushes a node. */
static void import_other(lua_State *L, const char *label, const char *name, const node *like,
                         wanted want) {
    lua_scene *s = scene_of(L);
    import_options options = *s->options;
    options.within = true;
    options.animation = want.animation;
    options.flat = want.flat;
    motion_give_clock(L, &options);
    const char *path = files_resolve(L, name);
    box *holder = box_push(L, destroy_description);
    description *from = NULL;
    if (description_create(&from)) scene_fail_last(L, NULL, NULL);
    holder->held = from;
    double before = sandbox_cpu_seconds();
    snell_status status = import_file(path, NULL, &options, from);
    s->cpu_excluded += sandbox_cpu_seconds() - before;
    if (status) scene_fail_last(L, NULL, NULL);
    if (want.animation && strcmp(from->format, "gltf") != 0)
        scene_fail(L, SNELL_ERR_SYNTAX, "glTF files have", "%s: '%s' has no animations", label,
                   name);
    merge m = {L, from, s->d, 0, 0, NULL};
    m.shapes =
        lua_newuserdatauv(L, (from->objects[CATEGORY_SHAPE].count + 1) * sizeof *m.shapes, 0);
    m.texture = (uint32_t)s->d->objects[CATEGORY_TEXTURE].count;
    m.material = (uint32_t)s->d->objects[CATEGORY_MATERIAL].count;
    if (like->material != NO_MATERIAL) drop_slots(from);
    transform moved = dtransform_round(&like->placed);
    merge_category(&m, CATEGORY_TEXTURE, NULL);
    merge_category(&m, CATEGORY_MATERIAL, NULL);
    merge_category(&m, CATEGORY_SHAPE, NULL);
    if (want.lights) merge_category(&m, CATEGORY_LIGHT, &moved);
    if (want.camera) merge_category(&m, CATEGORY_CAMERA, &moved);
    if (want.settings) merge_category(&m, CATEGORY_SETTING, NULL);
    motion_set_clock(L);
    merge_notes(&m);
    merge_instances(&m, like, label);
}

static const char *need_file(lua_State *L, const char *label) {
    const char *file = values_get_string(L, label, "file");
    if (file == NULL)
        scene_fail(L, SNELL_ERR_SYNTAX, "what to read", "%s: 'file' is missing", label);
    return file;
}

/* model { file, transform, material, name, camera = false, lights = false, animation } */
static int make_model(lua_State *L) {
    static const char *const names[] = {"file",   "transform", "material", "name",
                                        "camera", "lights",    "motion",   "animation"};
    values_need_table(L, "model");
    values_check_keys(L, "model", names, 8, 0);
    const char *name, *file = need_file(L, "model");
    node like = objects_read_common(L, "model", &name);
    import_other(L, "model", file, &like,
                 (wanted){values_get_bool(L, "model", "camera", false),
                          values_get_bool(L, "model", "lights", false), false, false,
                          values_get_string(L, "model", "animation")});
    return 1;
}

/* include "file": everything that is in it. */
static int include(lua_State *L) {
    if (lua_type(L, 1) != LUA_TSTRING || lua_rawlen(L, 1) == 0)
        scene_fail(L, SNELL_ERR_SYNTAX, "such as include \"table.lua\"",
                   "include: needs the name of a file");
    node like = {.shape = NO_SHAPE,
                 .material = NO_MATERIAL,
                 .line = scene_line(L, NULL),
                 .placed = dtransform_identity()};
    import_other(L, "include", lua_tostring(L, 1), &like, (wanted){true, true, true, false, NULL});
    return 1;
}

int files_mesh(lua_State *L) {
    static const char *const names[] = {"file", "transform", "material",
                                        "name", "motion",    "smooth"};
    values_refuse_both(L, "mesh", "file", "positions");
    values_refuse_both(L, "mesh", "file", "keys");
    values_check_keys(L, "mesh", names, 6, 0);
    const char *name, *file = need_file(L, "mesh");
    node like = objects_read_common(L, "mesh", &name);
    bool flat = !values_get_bool(L, "mesh", "smooth", true);
    import_other(L, "mesh", file, &like, (wanted){false, false, false, flat, NULL});
    return 1;
}

/* ---- texture.image { file = } ---- */

static void destroy_image(void *held) {
    image_free(held);
    free(held);
}

const decoded_image *files_read_image(lua_State *L, const char *name) {
    lua_scene *s = scene_of(L);
    box *bytes = box_push(L, free), *pixels = box_push(L, destroy_image);
    uint8_t *data = NULL;
    size_t size, most = IMAGE_SIZE_MAX;
    if (s->options->memory_max && s->options->memory_max / 4 < most)
        most = (size_t)s->options->memory_max / 4;
    if (import_read_beside(s->path, name, s->options, &data, &size)) scene_fail_last(L, NULL, NULL);
    bytes->held = data;
    decoded_image *image = memory_zeroed(1, sizeof *image);
    if (image == NULL) scene_fail(L, SNELL_ERR_MEMORY, NULL, "out of memory");
    pixels->held = image;
    bool floats = image_is_float(data, size);
    if (floats ? image_decode_float(data, size, most, image)
               : image_decode(data, size, most, image)) {
        char why[512];
        snprintf(why, sizeof why, "%s", error_last()->text);
        scene_fail(L, error_last()->status, NULL, "'%s': %s", name, why);
    }
    const char *file;
    uint32_t line = scene_line(L, &file);
    if (image->damaged && description_add_message(s->d, SNELL_WARNING, file, line, NULL,
                                                  "'%s' is damaged: part of it is grey", name))
        scene_fail_last(L, NULL, NULL);
    return image;
}

/* What the file says is not for the program to say. */
static bool is_of_the_file(const char *name) {
    return choice_find("pixels|width|height|format", name) >= 0;
}

/* The image of the field `file` of table 1, with the parameters in `params`, which has room for four
 * more; the number of the texture. */
static uint32_t add_image(lua_State *L, const char *label, snell_param *params, size_t count,
                          const char *name) {
    const decoded_image *image = files_read_image(L, need_file(L, label));
    params[count++] = (snell_param){"width", SNELL_PARAM_INT, {.i = image->width}};
    params[count++] = (snell_param){"height", SNELL_PARAM_INT, {.i = image->height}};
    params[count++] = (snell_param){"format", SNELL_PARAM_STRING, {.s = image_format_word(image)}};
    size_t size = (size_t)image->width * image->height * image->channels;
    if (image->floats) size *= sizeof(float);
    params[count++] = (snell_param){
        .name = "pixels", .kind = SNELL_PARAM_ARRAY, .value.array = {image->pixels, size}};
    object_source source = {.name = name};
    source.line = scene_line(L, &source.file);
    uint32_t index;
    if (description_add(scene_of(L)->d, CATEGORY_TEXTURE, "image", params, count, source, &index))
        scene_fail_last(L, "image", label);
    return index;
}

int files_image(lua_State *L, const type_info *type) {
    const char *label = "texture.image", *names[64];
    snell_param params[64];
    size_t name_count = 0, count = 0;
    names[name_count++] = "file";
    names[name_count++] = "name";
    for (uint32_t i = 0; i < type->field_count && i < 60; i++)
        if (!is_of_the_file(type->fields[i].name)) names[name_count++] = type->fields[i].name;
    values_check_keys(L, label, names, name_count, 0);
    for (uint32_t i = 0; i < type->field_count && i < 60; i++) {
        lua_pushstring(L, type->fields[i].name);
        if (lua_rawget(L, 1) != LUA_TNIL)
            values_read_field(L, type, &type->fields[i], label, &params[count++]);
    }
    handle_push(L, HANDLE_TEXTURE,
                add_image(L, label, params, count, values_get_string(L, label, "name")));
    return 1;
}

/* Above and below the poles there is nothing to repeat. */
uint32_t files_environment(lua_State *L) {
    const char *label = "light.environment";
    snell_param params[8] = {
        {.name = "wrap_v", .kind = SNELL_PARAM_STRING, .value.s = "clamp"},
        {.name = "map", .kind = SNELL_PARAM_STRING, .value.s = "uv"},
    };
    return 1 + add_image(L, label, params, 2, NULL);
}

/* ---- values from the command line ---- */

static const char *find_value(const lua_scene *s, const char *name) {
    size_t length = strlen(name);
    const char *value = NULL; /* the last one given counts */
    for (size_t i = 0; i < s->options->param_count; i++) {
        const char *given = s->options->params[i];
        if (strncmp(given, name, length) == 0 && given[length] == '=') value = given + length + 1;
    }
    return value;
}

static void record_param(lua_State *L, const char *kind) {
    const char *value = sandbox_tostring(L, -1), *initial = sandbox_tostring(L, 2);
    const char *texts[] = {lua_tostring(L, 1), kind, value, initial, luaL_optstring(L, 3, "")};
    char *p[5];
    for (int i = 0; i < 5; i++) p[i] = (char *)(uintptr_t)texts[i]; /* only read */
    add_param(L, &(scene_param){p[0], p[1], p[2], p[3], p[4]});
    lua_pop(L, 2);
}

/* -D NAME=VALUE must be able to say it. */
static void check_param_name(lua_State *L, const char *name) {
    for (const char *c = name; *c; c++)
        if ((unsigned char)*c <= ' ' || *c == 0x7f || *c == '=')
            scene_fail(L, SNELL_ERR_SYNTAX, "such as \"max_depth\"",
                       "param: a name has no spaces and no '=': '%s'", name);
}

_Noreturn static void fail_param(lua_State *L, const char *text, const char *kind) {
    const char *name = lua_tostring(L, 1);
    const char *initial = sandbox_tostring(L, 2);
    char hint[256];
    snprintf(hint, sizeof hint, "such as -D %.100s=%.40s", name, initial);
    if (lua_isinteger(L, 2) && lua_stringtonumber(L, text) != 0) {
        size_t used = strlen(hint);
        snprintf(hint + used, sizeof hint - used,
                 "; the scene's default %.20s is an integer, %.20s.0 would take fractions", initial,
                 initial);
    }
    scene_fail(L, SNELL_ERR_ARGUMENT, hint, "param '%s': '%s' is not %s", name, text, kind);
}

/* Pushes the text as the kind of value that the default is. */
static const char *push_value(lua_State *L, const char *text) {
    switch (lua_type(L, 2)) {
    case LUA_TBOOLEAN:
        if (text && strcmp(text, "true") != 0 && strcmp(text, "false") != 0)
            fail_param(L, text, "true or false");
        lua_pushboolean(L, text ? strcmp(text, "true") == 0 : lua_toboolean(L, 2));
        return "boolean";
    case LUA_TNUMBER: {
        bool whole = lua_isinteger(L, 2);
        const char *kind = whole ? "integer" : "number";
        if (text == NULL) {
            lua_pushvalue(L, 2);
        } else if (lua_stringtonumber(L, text) == 0 || (whole && !lua_isinteger(L, -1))) {
            fail_param(L, text, whole ? "an integer" : "a number");
        } else if (!whole) {
            double number = lua_tonumber(L, -1);
            if (!isfinite(number)) fail_param(L, text, "a finite number");
            lua_pushnumber(L, number);
        }
        return kind;
    }
    case LUA_TSTRING:
        if (text)
            lua_pushstring(L, text);
        else
            lua_pushvalue(L, 2);
        return "string";
    default:
        scene_fail(L, SNELL_ERR_SYNTAX, "such as param(\"depth\", 4, \"levels of spheres\")",
                   "param: the default must be a number, a text, true or false");
    }
}

static int read_param(lua_State *L, bool file) {
    if (lua_type(L, 1) != LUA_TSTRING || lua_rawlen(L, 1) == 0)
        scene_fail(L, SNELL_ERR_SYNTAX, "such as param(\"depth\", 4, \"levels of spheres\")",
                   "param: needs a name, a default and a line of help");
    check_param_name(L, lua_tostring(L, 1));
    if (file && lua_type(L, 2) != LUA_TSTRING)
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "param.file: the default must be a file's name");
    lua_settop(L, 3);
    const char *kind = push_value(L, find_value(scene_of(L), lua_tostring(L, 1)));
    record_param(L, file ? "file" : kind);
    return 1;
}

static int param_call(lua_State *L) {
    lua_remove(L, 1); /* the table param itself */
    return read_param(L, false);
}

static int param_file(lua_State *L) { return read_param(L, true); }

void files_check_params(lua_State *L) {
    lua_scene *s = scene_of(L);
    if (s->parent) return; /* the whole scene's are known at the end of the outermost */
    for (size_t i = 0; i < s->options->param_count; i++) {
        const char *given = s->options->params[i];
        size_t length = strcspn(given, "=");
        const char *names[64];
        char word[64], hint[512] = "the scene has ";
        size_t count = 0;
        bool found = false;
        for (size_t k = 0; k < s->d->param_count; k++) {
            const char *name = s->d->params[k].name;
            if (strlen(name) == length && strncmp(name, given, length) == 0) found = true;
            size_t used = strlen(hint);
            snprintf(hint + used, sizeof hint - used, "%s%s", k ? ", " : "", name);
            if (count < 64) names[count++] = name;
        }
        snprintf(word, sizeof word, "%.*s", (int)(length < 63 ? length : 63), given);
        if (given[length] == '\0')
            scene_fail(L, SNELL_ERR_ARGUMENT, "such as -D depth=5", "-D %s: has no value", word);
        if (found) continue;
        if (count == 0) snprintf(hint, sizeof hint, "the scene has no parameters");
        const char *near = closest_word(word, names, count);
        if (near) snprintf(hint, sizeof hint, "did you mean '%s'?", near);
        scene_fail(L, SNELL_ERR_ARGUMENT, hint, "-D %s: the scene has no parameter of that name",
                   word);
    }
}

void files_open(lua_State *L) {
    lua_pushcfunction(L, make_model);
    lua_setglobal(L, "model");
    lua_pushcfunction(L, include);
    lua_setglobal(L, "include");
    lua_newtable(L);
    lua_pushcfunction(L, param_file);
    lua_setfield(L, -2, "file");
    sandbox_guard(L, "param");
    lua_getmetatable(L, -1);
    lua_pushcfunction(L, param_call);
    lua_setfield(L, -2, "__call");
    lua_pop(L, 1);
    lua_setglobal(L, "param");
}
