/* What the specification asks of meshes, skins and extensions beyond the type of each property:
 * checked for the whole file, drawn or not. What would make a wrong picture is an error, what would
 * not is a warning. */
#include "importers/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "maths/functions.h"

typedef struct semantic {
    const char *name;     /* "TEXCOORD_": any number follows */
    const char *types[2]; /* of the accessor */
} semantic;

static const semantic semantics[] = {
    {"POSITION", {"VEC3", "VEC3"}},  {"NORMAL", {"VEC3", "VEC3"}}, {"TANGENT", {"VEC4", "VEC3"}},
    {"TEXCOORD_", {"VEC2", "VEC2"}}, {"COLOR_", {"VEC3", "VEC4"}}, {"JOINTS_", {"VEC4", "VEC4"}},
    {"WEIGHTS_", {"VEC4", "VEC4"}}};

static const semantic *find_semantic(const char *name) {
    for (size_t i = 0; i < sizeof semantics / sizeof semantics[0]; i++) {
        size_t length = strlen(semantics[i].name);
        bool numbered = semantics[i].name[length - 1] == '_';
        if (strncmp(name, semantics[i].name, length) != 0) continue;
        if (!numbered && name[length] == '\0') return &semantics[i];
        const char *digits = name + length;
        bool plain =
            digits[0] >= '0' && digits[0] <= '9' && digits[strspn(digits, "0123456789")] == 0;
        if (numbered && plain && (digits[0] != '0' || digits[1] == '\0')) return &semantics[i];
    }
    return NULL;
}

/* One map of attributes: of a primitive, or of a morph target. count SIZE_MAX: the first decides. */
static snell_status check_attributes(gltf *g, const json_t *map, const char *where, size_t *count) {
    const char *name;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)map, name, value) {
        size_t accessor = (size_t)json_number_value(value),
               elements = gltf_accessor_count(g, accessor);
        const semantic *s = find_semantic(name);
        const char *type = json_text(json_item(g, "accessors", accessor), "type");
        char path[JSON_PATH_SIZE];
        snprintf(path, sizeof path, "%.120s.%.60s", where, name);
        snell_status status = SNELL_OK;
        if (s == NULL && name[0] != '_')
            status = gltf_warn(g, "%s: is no attribute that glTF knows", path);
        else if (s && strcmp(type, s->types[0]) != 0 && strcmp(type, s->types[1]) != 0)
            status = gltf_error(g, SNELL_ERR_SYNTAX, path, "accessors[%zu] must not be %s",
                                accessor, type);
        if (!status &&
            json_index(json_item(g, "accessors", accessor), "componentType", 0) == GL_UINT)
            status =
                gltf_warn(g, "%s: accessors[%zu] has whole numbers of 32 bits", path, accessor);
        if (*count == SIZE_MAX) *count = elements;
        if (!status && elements != *count)
            status = gltf_error(g, SNELL_ERR_SYNTAX, path, "has %zu elements where others have %zu",
                                elements, *count);
        if (status) return status;
    }
    return SNELL_OK;
}

static snell_status check_indices(gltf *g, const json_t *primitive, const char *where) {
    size_t accessor = json_index(primitive, "indices", SIZE_MAX);
    if (accessor == SIZE_MAX) return SNELL_OK;
    const json_t *a = json_item(g, "accessors", accessor);
    size_t type = json_index(a, "componentType", 0);
    bool fits = strcmp(json_text(a, "type"), "SCALAR") == 0 &&
                (type == GL_UBYTE || type == GL_USHORT || type == GL_UINT) &&
                !json_flag(a, "normalized");
    if (fits) return SNELL_OK;
    return gltf_error(g, SNELL_ERR_SYNTAX, where, "indices: accessors[%zu] holds no indices",
                      accessor);
}

static snell_status check_draco(gltf *g, const json_t *primitive, const char *where) {
    const json_t *draco = json_extension(primitive, "KHR_draco_mesh_compression");
    size_t mode = json_index(primitive, "mode", 4);
    const char *name;
    json_t *value;
    if (draco == NULL) return SNELL_OK;
    if (mode != 4 && mode != 5)
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "Draco compresses triangles only");
    json_object_foreach(json_at(draco, "attributes"), name, value) {
        bool known = json_at(json_at(primitive, "attributes"), name) != NULL;
        if (!json_is_integer(value) || json_integer_value(value) < 0 || !known)
            return gltf_error(g, SNELL_ERR_SYNTAX, where,
                              "KHR_draco_mesh_compression: %.60s is not an attribute's number",
                              name);
    }
    return SNELL_OK;
}

static snell_status check_primitive(gltf *g, const json_t *primitive, const char *where) {
    size_t count = SIZE_MAX;
    char inner[JSON_PATH_SIZE];
    snprintf(inner, sizeof inner, "%.150s.attributes", where);
    snell_status status = check_attributes(g, json_at(primitive, "attributes"), inner, &count);
    if (!status) status = check_draco(g, primitive, where);
    if (!status) status = check_indices(g, primitive, where);
    const json_t *targets = json_at(primitive, "targets");
    for (size_t i = 0; i < json_array_size(targets) && !status; i++) {
        const json_t *target = json_array_get(targets, i);
        const char *name;
        json_t *value;
        snprintf(inner, sizeof inner, "%.150s.targets[%zu]", where, i);
        status = check_attributes(g, target, inner, &count);
        json_object_foreach((json_t *)(uintptr_t)target, name, value) {
            if (!status && !json_at(json_at(primitive, "attributes"), name))
                status = gltf_warn(g, "%s.%.60s: the primitive has no such attribute", inner, name);
        }
    }
    return status;
}

static snell_status check_mesh(gltf *g, size_t index) {
    const json_t *mesh = json_item(g, "meshes", index), *list = json_at(mesh, "primitives");
    size_t targets = json_array_size(json_at(json_array_get(list, 0), "targets"));
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < json_array_size(list) && !status; i++) {
        const json_t *primitive = json_array_get(list, i);
        char where[JSON_PATH_SIZE];
        snprintf(where, sizeof where, "meshes[%zu].primitives[%zu]", index, i);
        status = check_primitive(g, primitive, where);
        if (!status && json_array_size(json_at(primitive, "targets")) != targets)
            status =
                gltf_warn(g, "%s.targets: the mesh's primitives differ in their number", where);
    }
    const json_t *weights = json_at(mesh, "weights");
    if (!status && weights && json_array_size(weights) != targets)
        status = gltf_warn(g, "meshes[%zu].weights: %zu for %zu targets", index,
                           json_array_size(weights), targets);
    return status;
}

static snell_status check_node_skin(gltf *g, size_t index) {
    const json_t *node = json_item(g, "nodes", index);
    size_t mesh = json_index(node, "mesh", SIZE_MAX);
    if (json_at(node, "skin") == NULL || mesh == SIZE_MAX) return SNELL_OK;
    const json_t *list = json_at(json_item(g, "meshes", mesh), "primitives");
    for (size_t i = 0; i < json_array_size(list); i++)
        if (!json_at(json_at(json_array_get(list, i), "attributes"), "JOINTS_0"))
            return gltf_warn(g, "nodes[%zu].skin: meshes[%zu].primitives[%zu] has no JOINTS_0",
                             index, mesh, i);
    return SNELL_OK;
}

static snell_status check_node(gltf *g, size_t index) {
    const json_t *node = json_item(g, "nodes", index), *weights = json_at(node, "weights");
    snell_status status = check_node_skin(g, index);
    if (status || weights == NULL) return status;
    size_t mesh = json_index(node, "mesh", SIZE_MAX);
    if (mesh == SIZE_MAX) return gltf_warn(g, "nodes[%zu].weights: without a mesh", index);
    const json_t *first = json_array_get(json_at(json_item(g, "meshes", mesh), "primitives"), 0);
    size_t targets = json_array_size(json_at(first, "targets"));
    if (json_array_size(weights) == targets) return SNELL_OK;
    return gltf_warn(g, "nodes[%zu].weights: %zu for %zu targets", index, json_array_size(weights),
                     targets);
}

static snell_status check_skin(gltf *g, size_t index) {
    size_t accessor = json_index(json_item(g, "skins", index), "inverseBindMatrices", SIZE_MAX);
    if (accessor == SIZE_MAX || gltf_accessor_components(g, accessor) == 16) return SNELL_OK;
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "skins[%zu].inverseBindMatrices", index);
    return gltf_error(g, SNELL_ERR_SYNTAX, where, "accessors[%zu] must be MAT4", accessor);
}

static snell_status check_camera(gltf *g, size_t index) {
    const json_t *flat = json_at(json_item(g, "cameras", index), "orthographic");
    if (flat == NULL || (json_number(flat, "xmag", 1) != 0 && json_number(flat, "ymag", 1) != 0))
        return SNELL_OK;
    return gltf_warn(g, "cameras[%zu].orthographic: xmag and ymag must not be 0", index);
}

static snell_status check_light(gltf *g, const json_t *light, size_t index) {
    const json_t *spot = json_at(light, "spot");
    double outer = json_number(spot, "outerConeAngle", PI / 4),
           inner = json_number(spot, "innerConeAngle", 0);
    if (inner < outer) return SNELL_OK;
    return gltf_warn(g,
                     "extensions.KHR_lights_punctual.lights[%zu].spot: the inner angle %g must be "
                     "less than the outer angle %g",
                     index, inner, outer);
}

/* ---- extensions that are used, but not declared, or where they have no place ---- */

static bool is_listed(const gltf *g, const char *list, const char *name) {
    const json_t *used = json_at(g->root, list);
    for (size_t i = 0; i < json_array_size(used); i++)
        if (strcmp(json_string_value(json_array_get(used, i)), name) == 0) return true;
    return false;
}

/* There are fewer extensions than this; a longer list is somebody's attempt at our time. */
enum { LISTED_MAX = 200 };

static snell_status check_listed_once(gltf *g, const char *list) {
    const json_t *names = json_at(g->root, list);
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < json_array_size(names) && i < LISTED_MAX && !status; i++)
        for (size_t k = 0; k < i && !status; k++)
            if (strcmp(json_string_value(json_array_get(names, i)),
                       json_string_value(json_array_get(names, k))) == 0)
                status = gltf_warn(g, "%s[%zu]: %.100s is named twice", list, i,
                                   json_string_value(json_array_get(names, i)));
    return status;
}

/* Whether the extension may stand in an object that is the value, or in the list, of this key. */
static bool has_place(const char *extension, const char *owner) {
    static const struct {
        const char *begins, *owners; /* "*Texture": any key that ends so; "/": the file itself */
    } places[] = {
        {"KHR_materials_variants", "/ primitives"}, {"KHR_materials_", "materials"},
        {"KHR_lights_punctual", "/ nodes"},         {"KHR_texture_transform", "*Texture"},
        {"EXT_texture_webp", "textures"},           {"KHR_mesh_quantization", ""},
        {"EXT_mesh_gpu_instancing", "nodes"},       {"KHR_draco_mesh_compression", "primitives"}};
    size_t length = strlen(owner);
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        if (strncmp(extension, places[i].begins, strlen(places[i].begins)) != 0) continue;
        if (places[i].owners[0] == '*')
            return length >= 7 && strcmp(owner + length - 7, "Texture") == 0;
        return strstr(places[i].owners, owner) && places[i].owners[0];
    }
    return true;
}

/* path: of the object that has these extensions, "" for the file itself. */
static snell_status check_declared(gltf *g, const json_t *extensions, const char *path,
                                   const char *owner) {
    const char *name;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)extensions, name, value) {
        snell_status status = SNELL_OK;
        char where[JSON_PATH_SIZE];
        snprintf(where, sizeof where, "%.120s%sextensions.%.60s", path, *path ? "." : "", name);
        if (!json_is_object(value))
            return gltf_error(g, SNELL_ERR_SYNTAX, where, "must be an object");
        if (!is_listed(g, "extensionsUsed", name))
            status = gltf_warn(g, "%s: is not in extensionsUsed", where);
        if (!status && !has_place(name, owner))
            status = gltf_warn(g, "%s: has no place here: ignored", where);
        if (status) return status;
    }
    return SNELL_OK;
}

/* owner: the key whose value, or whose list's element, this is. The parser bounds the depth of the
 * JSON, and so the depth of this. */
static snell_status walk_extensions(gltf *g, const json_t *value, const char *path,
                                    const char *owner) {
    snell_status status = SNELL_OK;
    const char *key;
    json_t *inner;
    char below[JSON_PATH_SIZE];
    for (size_t i = 0; i < json_array_size(value) && !status; i++) {
        const json_t *item = json_array_get(value, i);
        if (!json_is_object(item) && !json_is_array(item)) continue;
        snprintf(below, sizeof below, "%.120s[%zu]", path, i);
        status = walk_extensions(g, item, below, owner);
    }
    json_object_foreach((json_t *)(uintptr_t)value, key, inner) {
        if (strcmp(key, "extras") == 0) continue;
        if (!status && strcmp(key, "extensions") == 0)
            status = check_declared(g, inner, path, owner);
        if (status || (!json_is_object(inner) && !json_is_array(inner))) continue;
        snprintf(below, sizeof below, "%.120s%s%.60s", path, *path ? "." : "", key);
        status = walk_extensions(g, inner, below, key);
    }
    return status;
}

static snell_status check_extensions(gltf *g) {
    const json_t *lights = json_at(json_extension(g->root, "KHR_lights_punctual"), "lights");
    snell_status status = check_listed_once(g, "extensionsUsed");
    if (!status) status = check_listed_once(g, "extensionsRequired");
    if (!status && is_listed(g, "extensionsUsed", "KHR_mesh_quantization") &&
        !is_listed(g, "extensionsRequired", "KHR_mesh_quantization"))
        status =
            gltf_warn(g, "extensionsUsed: KHR_mesh_quantization must be in extensionsRequired too");
    for (size_t i = 0; i < json_array_size(lights) && !status; i++)
        status = check_light(g, json_array_get(lights, i), i);
    return status ? status : walk_extensions(g, g->root, "", "/");
}

snell_status gltf_check_meaning(gltf *g) {
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < json_count(g, "meshes") && !status; i++) status = check_mesh(g, i);
    for (size_t i = 0; i < json_count(g, "nodes") && !status; i++) status = check_node(g, i);
    for (size_t i = 0; i < json_count(g, "skins") && !status; i++) status = check_skin(g, i);
    for (size_t i = 0; i < json_count(g, "animations") && !status; i++)
        status = gltf_check_animation(g, i);
    for (size_t i = 0; i < json_count(g, "cameras") && !status; i++) status = check_camera(g, i);
    return status ? status : check_extensions(g);
}

/* ---- skins and the tree; after gltf_read_scene, which finds parents ---- */

/* Numbers a node and all below it, each before its children, from `next`; returns the number after
 * the last. stack: room for all nodes. */
static size_t number_tree(const gltf *g, size_t top, size_t *stack, size_t *numbers, size_t next) {
    size_t used = 0;
    stack[used++] = top;
    while (used > 0) {
        size_t node = stack[--used];
        const json_t *children = json_at(json_item(g, "nodes", node), "children");
        numbers[node] = next++;
        for (size_t i = 0; i < json_array_size(children); i++)
            stack[used++] = (size_t)json_number_value(json_array_get(children, i));
    }
    return next;
}

static size_t joint_at(const json_t *joints, size_t i) {
    return (size_t)json_number_value(json_array_get(joints, i));
}

/* The joints are the skeleton's node or below it: it and those have numbers in a row. */
static snell_status check_skeleton(gltf *g, size_t index, const size_t *numbers,
                                   const size_t *sizes) {
    const json_t *skin = json_item(g, "skins", index), *joints = json_at(skin, "joints");
    size_t top = json_index(skin, "skeleton", SIZE_MAX);
    if (top == SIZE_MAX) return SNELL_OK;
    for (size_t i = 0; i < json_array_size(joints); i++)
        if (numbers[joint_at(joints, i)] - numbers[top] >= sizes[top])
            return gltf_warn(g, "skins[%zu].skeleton: node %zu is not above joints[%zu]", index,
                             top, i);
    return SNELL_OK;
}

static snell_status check_skeletons(gltf *g, size_t *stack, size_t *numbers, size_t *sizes) {
    size_t count = json_count(g, "nodes"), next = 0;
    for (size_t i = 0; i < count; i++)
        if (g->nodes[i].parent == SIZE_MAX) next = number_tree(g, i, stack, numbers, next);
    for (size_t i = 0; i < count; i++) stack[numbers[i]] = i;
    for (size_t i = count; i-- > 0;) { /* children first */
        size_t node = stack[i], parent = g->nodes[node].parent;
        sizes[node]++;
        if (parent != SIZE_MAX) sizes[parent] += sizes[node];
    }
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < json_count(g, "skins") && !status; i++)
        status = check_skeleton(g, i, numbers, sizes);
    return status;
}

/* A mesh with a skin is shown where its joints are, so they belong to the same scene. */
static snell_status check_shown_joints(gltf *g, size_t *stack, size_t *numbers) {
    const json_t *scene = json_item(g, "scenes", json_index(g->root, "scene", 0)),
                 *roots = json_at(scene, "nodes");
    size_t count = json_count(g, "nodes"), next = 1;
    if (scene == NULL) return SNELL_OK;
    memset(numbers, 0, count * sizeof *numbers);
    for (size_t i = 0; i < json_array_size(roots); i++)
        next = number_tree(g, joint_at(roots, i), stack, numbers, next);
    for (size_t i = 0; i < count; i++) {
        size_t skin = json_index(json_item(g, "nodes", i), "skin", SIZE_MAX);
        if (numbers[i] == 0 || skin == SIZE_MAX) continue;
        const json_t *joints = json_at(json_item(g, "skins", skin), "joints");
        if (json_array_size(joints) > 0 && numbers[joint_at(joints, 0)] == 0)
            return gltf_warn(g, "nodes[%zu].skin: its joints are not in the scene", i);
    }
    return SNELL_OK;
}

snell_status gltf_check_joints(gltf *g) {
    size_t count = json_count(g, "nodes");
    if (json_count(g, "skins") == 0 || count == 0) return SNELL_OK;
    size_t *room = memory_zeroed(count, 3 * sizeof *room);
    if (room == NULL) return error_no_memory();
    snell_status status = check_skeletons(g, room, room + count, room + 2 * count);
    if (!status) status = check_shown_joints(g, room, room + count);
    free(room);
    return status;
}
