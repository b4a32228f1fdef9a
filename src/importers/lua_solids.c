/* union { a, b, .. }, intersection { .. }, difference { .. }: shapes put together to one, which they
 * are then drawn as. A group among them counts as the union of its shapes. */
#include "importers/lua_scene.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "scene/solids.h"

/* The fields of a solid's description while they are collected; Lua owns it. */
typedef struct solid_parts {
    snell_shape_id *shapes;
    transform *transforms;
    snell_material_id *materials;
    uint32_t *lines; /* where each was made */
    size_t line_capacity;
    size_t count, shape_capacity, transform_capacity, material_capacity;
    const char *label; /* "union" and so on */
} solid_parts;

static void free_parts(void *held) {
    solid_parts *p = held;
    free(p->shapes);
    free(p->transforms);
    free(p->materials);
    free(p->lines);
    free(p);
}

static solid_parts *push_parts(lua_State *L, const char *label) {
    box *holder = box_push(L, free_parts);
    solid_parts *p = memory_zeroed(1, sizeof *p);
    if (p == NULL) scene_fail(L, SNELL_ERR_MEMORY, NULL, "out of memory");
    holder->held = p;
    p->label = label;
    return p;
}

static void append(lua_State *L, solid_parts *p, uint32_t shape, transform placed,
                   uint32_t material, uint32_t line) {
    if (p->count >= SOLID_PARTS_MAX)
        scene_fail(L, SNELL_ERR_SYNTAX, "make it of several, or of a mesh",
                   "%s: more than %d shapes", p->label, SOLID_PARTS_MAX);
    if (!ARRAY_GROW(p->shapes, p->count, p->shape_capacity, 1) ||
        !ARRAY_GROW(p->transforms, p->count, p->transform_capacity, 1) ||
        !ARRAY_GROW(p->materials, p->count, p->material_capacity, 1) ||
        !ARRAY_GROW(p->lines, p->count, p->line_capacity, 1))
        scene_fail(L, SNELL_ERR_MEMORY, NULL, "out of memory");
    p->shapes[p->count] = (snell_shape_id){shape + 1, 0};
    p->transforms[p->count] = placed;
    p->lines[p->count] = line;
    p->materials[p->count++] = (snell_material_id){material == NO_MATERIAL ? 0 : material + 1, 0};
}

static void append_leaf(lua_State *L, void *user, const node *leaf, bool moves) {
    solid_parts *p = user;
    if (moves)
        scene_fail(L, SNELL_ERR_SYNTAX, "give the solid the motion",
                   "%s: the shape of line %u moves: a part of a solid cannot move by itself",
                   p->label, leaf->line);
    append(L, p, leaf->shape, dtransform_round(&leaf->placed), leaf->material, leaf->line);
}

/* Checks of meshes take a while. */
static void charge(lua_State *L, const solid_parts *p) {
    const object_list *shapes = &scene_of(L)->d->objects[CATEGORY_SHAPE];
    for (size_t i = 0; i < p->count; i++) {
        const object *o = &shapes->items[p->shapes[i].index1 - 1];
        uint64_t work =
            20 + (o->type == &primitive_mesh.info ? 4 * (uint64_t)mesh_triangle_count(o->desc) : 0);
        sandbox_charge(L, work);
    }
}

/* What is wrong with one of the shapes is said of the line that made it. */
_Noreturn static void fail_parts(lua_State *L, const solid_parts *p) {
    const lua_scene *s = scene_of(L);
    bool of_whole = strncmp(error_last()->text, "solid:", 6) == 0;
    for (size_t i = 0; i < p->count && !of_whole; i++)
        if (solid_check_parts(s->d, &p->shapes[i], 1)) { /* the same error again */
            error_place((source_place){s->path, p->lines[i], 0});
            break;
        }
    scene_fail_last(L, "solid", p->label);
}

static uint32_t add_solid(lua_State *L, const solid_parts *p, const char *operation,
                          const char *name) {
    const snell_param params[] = {
        {.name = "operation", .kind = SNELL_PARAM_STRING, .value.s = operation},
        {.name = "shapes", .kind = SNELL_PARAM_ARRAY, .value.array = {p->shapes, p->count}},
        {.name = "transforms", .kind = SNELL_PARAM_ARRAY, .value.array = {p->transforms, p->count}},
        {.name = "materials", .kind = SNELL_PARAM_ARRAY, .value.array = {p->materials, p->count}}};
    uint32_t index;
    object_source source = {.name = name};
    source.line = scene_line(L, &source.file);
    charge(L, p);
    if (description_add(scene_of(L)->d, CATEGORY_SHAPE, "solid", params, 4, source, &index))
        fail_parts(L, p);
    return index;
}

/* One shape, as it is; several of a group, as their union. */
static void append_node(lua_State *L, solid_parts *p, uint32_t index) {
    if (scene_of(L)->nodes[index].leaf_count == 1) {
        nodes_each_leaf(L, index, append_leaf, p);
        return;
    }
    if (scene_of(L)->nodes[index].leaf_count == 0)
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: one of its groups has no shapes", p->label);
    solid_parts *group = push_parts(L, p->label);
    nodes_each_leaf(L, index, append_leaf, group);
    append(L, p, add_solid(L, group, "union", NULL), transform_identity(), NO_MATERIAL,
           scene_of(L)->nodes[index].line);
    lua_pop(L, 1);
}

static void check_parts(lua_State *L, const char *label, const uint32_t *parts, size_t count) {
    if (count == 0)
        scene_fail(L, SNELL_ERR_SYNTAX, "such as difference { box { .. }, sphere { .. } }",
                   "%s: it has no shapes", label);
    if (count > SOLID_PARTS_MAX)
        scene_fail(L, SNELL_ERR_SYNTAX, "make it of several, or of a mesh",
                   "%s: more than %d shapes", label, SOLID_PARTS_MAX);
    sandbox_charge(L, (uint64_t)count * count / 8);
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < i; k++)
            if (parts[i] == parts[k])
                scene_fail(L, SNELL_ERR_SYNTAX, "instance { .. } makes another of it",
                           "%s: values %d and %d are the same shape", label, (int)k + 1,
                           (int)i + 1);
}

static int make_solid(lua_State *L) {
    static const char *const common[] = {"material", "transform", "name", "motion"};
    const char *label = lua_tostring(L, lua_upvalueindex(1)), *name;
    values_need_table(L, label);
    size_t count = (size_t)lua_rawlen(L, 1);
    sandbox_charge(L, 4 * (uint64_t)count);
    values_check_keys(L, label, common, 4, (lua_Integer)count);
    node made = objects_read_common(L, label, &name);
    const uint32_t *nodes = nodes_read_parts(L, label, count);
    check_parts(L, label, nodes, count);
    solid_parts *p = push_parts(L, label);
    for (size_t i = 0; i < count; i++) append_node(L, p, nodes[i]);
    made.shape = add_solid(L, p, label, name);
    for (size_t i = 0; i < count; i++) scene_of(L)->nodes[nodes[i]].taken = true;
    nodes_add_shape(L, &made);
    return 1;
}

void solids_open(lua_State *L) {
    static const char *const names[] = {"union", "intersection", "difference"};
    for (int i = 0; i < 3; i++) {
        lua_pushstring(L, names[i]);
        lua_pushcclosure(L, make_solid, 1);
        lua_setglobal(L, names[i]);
    }
}
