/* The node tree of glTF: where everything stands. */
#include "importers/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "cameras/camera.h"
#include "importers/up.h"
#include "maths/functions.h"

/* A cap on what few bytes can ask for by instancing. */
enum { INSTANCES_MAX = 10000000 };

/* ---- matrices in double, until the whole chain is multiplied ---- */

dmat dmat_multiply(const dmat *a, const dmat *b) {
    dmat out;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            out.m[r][c] = a->m[r][0] * b->m[0][c] + a->m[r][1] * b->m[1][c] +
                          a->m[r][2] * b->m[2][c] + (c == 3 ? a->m[r][3] : 0);
    return out;
}

dvec3 dmat_vector(const dmat *a, dvec3 v) {
    return (dvec3){a->m[0][0] * v.x + a->m[0][1] * v.y + a->m[0][2] * v.z,
                   a->m[1][0] * v.x + a->m[1][1] * v.y + a->m[1][2] * v.z,
                   a->m[2][0] * v.x + a->m[2][1] * v.y + a->m[2][2] * v.z};
}

dvec3 dmat_point(const dmat *a, dvec3 p) {
    return dvec3_add(dmat_vector(a, p), (dvec3){a->m[0][3], a->m[1][3], a->m[2][3]});
}

dmat dmat_from_columns(const double *m) {
    dmat out;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++) out.m[r][c] = m[4 * c + r];
    return out;
}

static bool is_finite(const dmat *a) {
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            if (!(fabs(a->m[r][c]) < 1e30)) return false; /* a float holds it with room to spare */
    return true;
}

static transform to_transform(const dmat *a) {
    transform out;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++) out.m[r][c] = (float)a->m[r][c];
    return out;
}

/* The rotation that brings the user's idea of up to +Y; the identity without one. */
static dmat rotation_to_up(const char *axis) {
    transform up;
    dmat out;
    import_up_rotation(axis, &up);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++) out.m[r][c] = (double)up.m[r][c];
    return out;
}

/* T R S; q = (x, y, z, w), brought to unit length. */
static dmat from_trs(const double *t, const double *q, const double *s) {
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    double f = length > 0 ? 1 / length : 0, x = q[0] * f, y = q[1] * f, z = q[2] * f,
           w = length > 0 ? q[3] * f : 1;
    return (dmat){{{(1 - 2 * (y * y + z * z)) * s[0], 2 * (x * y - z * w) * s[1],
                    2 * (x * z + y * w) * s[2], t[0]},
                   {2 * (x * y + z * w) * s[0], (1 - 2 * (x * x + z * z)) * s[1],
                    2 * (y * z - x * w) * s[2], t[1]},
                   {2 * (x * z - y * w) * s[0], 2 * (y * z + x * w) * s[1],
                    (1 - 2 * (x * x + y * y)) * s[2], t[2]}}};
}

static snell_status check_rotation(gltf *g, size_t index) {
    double q[4] = {0, 0, 0, 1};
    json_numbers(json_item(g, "nodes", index), "rotation", q, 4);
    double squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (fabs(squared - 1) > 0.01)
        return gltf_warn(g, "nodes[%zu].rotation: is no unit quaternion", index);
    return SNELL_OK;
}

/* As the node says, but for what an animation says of this time. */
static dmat node_local(const gltf *g, size_t index, double time) {
    const json_t *node = json_item(g, "nodes", index);
    gltf_track *const *tracks = g->nodes[index].tracks;
    double t[3] = {0, 0, 0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1}, m[16];
    if (json_at(node, "matrix")) {
        json_numbers(node, "matrix", m, 16);
        return dmat_from_columns(m);
    }
    json_numbers(node, "translation", t, 3);
    json_numbers(node, "rotation", q, 4);
    json_numbers(node, "scale", s, 3);
    double *parts[] = {t, q, s};
    for (int k = TRACK_TRANSLATION; k <= TRACK_SCALE; k++)
        if (tracks[k]) gltf_track_at(tracks[k], k, time, parts[k]);
    return from_trs(t, q, s);
}

/* ---- sizes ---- */

static double determinant(const dmat *a) {
    return a->m[0][0] * (a->m[1][1] * a->m[2][2] - a->m[1][2] * a->m[2][1]) -
           a->m[0][1] * (a->m[1][0] * a->m[2][2] - a->m[1][2] * a->m[2][0]) +
           a->m[0][2] * (a->m[1][0] * a->m[2][1] - a->m[1][1] * a->m[2][0]);
}

double gltf_scale(const dmat *a) {
    double volume = fabs(determinant(a));
    return volume > 0 ? fn_pow(volume, 1.0 / 3) : 1;
}

static void add_corners(const gltf *g, const dmat *world, size_t accessor, dvec3 *low,
                        dvec3 *high) {
    const json_t *a = json_item(g, "accessors", accessor);
    double ends[2][3] = {{0, 0, 0}, {0, 0, 0}};
    json_numbers(a, "min", ends[0], 3);
    json_numbers(a, "max", ends[1], 3);
    for (int corner = 0; corner < 8; corner++) {
        dvec3 p = dmat_point(
            world, (dvec3){ends[corner & 1][0], ends[corner >> 1 & 1][1], ends[corner >> 2][2]});
        *low = (dvec3){double_min(low->x, p.x), double_min(low->y, p.y), double_min(low->z, p.z)};
        *high =
            (dvec3){double_max(high->x, p.x), double_max(high->y, p.y), double_max(high->z, p.z)};
    }
}

double gltf_scene_size(gltf *g) {
    dvec3 low = {1e30, 1e30, 1e30}, high = {-1e30, -1e30, -1e30};
    size_t looked_at = 0;
    if (g->size > 0) return g->size;
    for (size_t i = 0; i < json_count(g, "nodes"); i++) {
        size_t mesh = json_index(json_item(g, "nodes", i), "mesh", SIZE_MAX);
        const json_t *list =
            mesh == SIZE_MAX ? NULL : json_at(json_item(g, "meshes", mesh), "primitives");
        for (size_t k = 0; k < json_array_size(list) && ++looked_at < INSTANCES_MAX; k++) {
            size_t at =
                json_index(json_at(json_array_get(list, k), "attributes"), "POSITION", SIZE_MAX);
            if (at != SIZE_MAX) add_corners(g, &g->nodes[i].world, at, &low, &high);
        }
    }
    double size = dvec3_length(dvec3_sub(high, low));
    g->size = size > 1e-12 && size < 1e30 ? size : 1;
    return g->size;
}

/* ---- parents, loops, world matrices ---- */

static size_t child_at(const json_t *children, size_t i) {
    return (size_t)json_number_value(json_array_get(children, i));
}

static snell_status find_parents(gltf *g) {
    size_t count = json_count(g, "nodes");
    for (size_t i = 0; i < count; i++) g->nodes[i].parent = SIZE_MAX;
    for (size_t i = 0; i < count; i++) {
        const json_t *children = json_at(json_item(g, "nodes", i), "children");
        for (size_t k = 0; k < json_array_size(children); k++) {
            size_t child = child_at(children, k);
            char where[JSON_PATH_SIZE];
            snprintf(where, sizeof where, "nodes[%zu].children[%zu]", i, k);
            if (child == i)
                return gltf_error(g, SNELL_ERR_SYNTAX, where, "the node is its own child");
            if (g->nodes[child].parent != SIZE_MAX)
                return gltf_error(g, SNELL_ERR_SYNTAX, where,
                                  "node %zu is a child of node %zu already", child,
                                  g->nodes[child].parent);
            g->nodes[child].parent = i;
        }
    }
    return SNELL_OK;
}

static dmat world_at(const gltf *g, size_t index, const dmat *root, int time) {
    const gltf_node *node = &g->nodes[index];
    const dmat *parent =
        node->parent == SIZE_MAX ? root : gltf_world_at(&g->nodes[node->parent], time);
    dmat local = node_local(g, index, (double)g->times[time]);
    return dmat_multiply(parent, &local);
}

static bool moves(const gltf *g, const gltf_node *node) {
    for (int k = TRACK_TRANSLATION; k <= TRACK_SCALE; k++)
        if (node->tracks[k]) return true;
    return node->parent != SIZE_MAX && g->nodes[node->parent].worlds;
}

/* Where a node is all through the clock's times; nothing if that is one place. */
static snell_status place_moving(gltf *g, size_t index, const dmat *root, const char *where) {
    gltf_node *node = &g->nodes[index];
    snell_status status = gltf_spend(g, where, CLOCK_TIMES * sizeof *node->worlds);
    if (status) return status;
    dmat *worlds = memory_zeroed(CLOCK_TIMES, sizeof *worlds);
    if (worlds == NULL) return error_no_memory();
    bool same = true;
    for (int i = 0; i < CLOCK_TIMES; i++) {
        worlds[i] = world_at(g, index, root, i);
        same &= memcmp(&worlds[i], &node->world, sizeof *worlds) == 0;
        if (!is_finite(&worlds[i]))
            status = gltf_error(g, SNELL_ERR_SYNTAX, where, "its transform is out of range");
    }
    if (same || status)
        free(worlds);
    else
        node->worlds = worlds;
    return status;
}

static snell_status place_node(gltf *g, size_t index) {
    gltf_node *node = &g->nodes[index];
    dmat up = rotation_to_up(g->options->up);
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "nodes[%zu]", index);
    snell_status status = check_rotation(g, index);
    if (status) return status;
    node->world = world_at(g, index, &up, CLOCK_NOW);
    if (!is_finite(&node->world))
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "its transform is out of range");
    return g->posed && moves(g, node) ? place_moving(g, index, &up, where) : SNELL_OK;
}

/* Parents first. With one parent each, a node that is not reached from a root is in a loop. */
static snell_status place_nodes(gltf *g, size_t *stack) {
    size_t count = json_count(g, "nodes"), used = 0, reached = 0;
    for (size_t i = count; i-- > 0;)
        if (g->nodes[i].parent == SIZE_MAX) stack[used++] = i;
    bool *seen = memory_zeroed(count + 1, sizeof *seen);
    if (seen == NULL) return error_no_memory();
    snell_status status = SNELL_OK;
    while (used > 0 && !status) {
        size_t index = stack[--used];
        const json_t *children = json_at(json_item(g, "nodes", index), "children");
        status = place_node(g, index);
        seen[index] = true;
        reached++;
        for (size_t k = 0; k < json_array_size(children); k++)
            stack[used++] = child_at(children, k);
    }
    for (size_t i = 0; reached < count && i < count && !status; i++) {
        char where[JSON_PATH_SIZE];
        snprintf(where, sizeof where, "nodes[%zu]", i);
        if (!seen[i])
            status =
                gltf_error(g, SNELL_ERR_SYNTAX, where, "the node is among its own descendants");
    }
    free(seen);
    return status;
}

/* ---- motion ---- */

/* Keys of node's world times `local`. Moments when there is nothing (a scale of 0) or when it is
 * mirrored, from which there is no way, are left out. Returns how many keys there are. */
static size_t motion_keys(const gltf *g, const gltf_node *node, const dmat *local,
                          motion_key keys[CLOCK_TIMES]) {
    size_t count = 0;
    dmat now = dmat_multiply(&node->world, local);
    for (int i = 0; i < CLOCK_TIMES; i++) {
        dmat placed = dmat_multiply(&node->worlds[i], local);
        transform rounded = to_transform(&placed), inverse;
        bool there = determinant(&placed) * determinant(&now) > 0 && is_finite(&placed) &&
                     transform_inverse(&rounded, &inverse);
        if (there) keys[count++] = (motion_key){g->times[i], rounded};
    }
    return count;
}

static const dmat identity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

/* ---- what a node holds ---- */

/* `node` NULL: the shapes are in world space. local: from a mesh to the node. */
static snell_status add_instances(gltf *g, size_t index, const gltf_node *node,
                                  const uint32_t *shapes, const dmat *local, const char *wanted) {
    const json_t *mesh =
        json_item(g, "meshes", json_index(json_item(g, "nodes", index), "mesh", 0));
    const json_t *primitives = json_at(mesh, "primitives");
    dmat world = node ? dmat_multiply(&node->world, local) : *local;
    transform placed = to_transform(&world), inverse;
    motion_key keys[CLOCK_TIMES];
    size_t key_count = node && node->worlds ? motion_keys(g, node, local, keys) : 0;
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "nodes[%zu]", index);
    if (!is_finite(&world))
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "its transform is out of range");
    if (!transform_inverse(&placed, &inverse))
        return gltf_warn(g, "%s: its scale is 0: not drawn", where);
    for (size_t i = 0; i < json_array_size(primitives); i++) {
        if (shapes[i] == NO_SHAPE) continue;
        if (++g->instance_count > INSTANCES_MAX)
            return gltf_error(g, SNELL_ERR_UNSUPPORTED, where, "there are more than %d instances",
                              INSTANCES_MAX);
        char name[NAME_MAX_SIZE];
        uint32_t material, made;
        snell_status status = gltf_material(
            g, json_index(json_array_get(primitives, i), "material", SIZE_MAX), &material);
        if (!status) status = names_make_unique(&g->names, NAMES_INSTANCE, wanted, name);
        if (status) return status;
        object_source source = {name[0] ? name : NULL, g->path, 0};
        status = description_add_instance(g->d, shapes[i], material, &placed, source, &made);
        if (!status && key_count > 1) status = description_set_motion(g->d, made, keys, key_count);
        if (status) return gltf_blame(g, where, status);
    }
    return SNELL_OK;
}

/* EXT_mesh_gpu_instancing: the mesh once per element of its attributes, under the node. */
typedef struct crowd {
    float *translation, *rotation, *scale;
    size_t count;
} crowd;

static snell_status read_crowd_attribute(gltf *g, const json_t *map, const char *where,
                                         const char *name, unsigned components, crowd *c,
                                         float **out) {
    size_t accessor = json_index(map, name, SIZE_MAX);
    if (accessor == SIZE_MAX) return SNELL_OK;
    size_t count = gltf_accessor_count(g, accessor);
    if (c->count && c->count != count)
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "the instances' attributes differ in count");
    c->count = count;
    return gltf_accessor_floats(g, accessor, components, where, out);
}

static dmat crowd_matrix(const crowd *c, size_t i) {
    double t[3] = {0, 0, 0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    for (size_t k = 0; k < 3 && c->translation; k++) t[k] = (double)c->translation[3 * i + k];
    for (size_t k = 0; k < 4 && c->rotation; k++) q[k] = (double)c->rotation[4 * i + k];
    for (size_t k = 0; k < 3 && c->scale; k++) s[k] = (double)c->scale[3 * i + k];
    return from_trs(t, q, s);
}

static snell_status add_crowd(gltf *g, size_t index, const gltf_node *node,
                              const json_t *instancing, const uint32_t *shapes, const char *name) {
    const json_t *map = json_at(instancing, "attributes");
    crowd c = {0};
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "nodes[%zu].extensions.EXT_mesh_gpu_instancing", index);
    snell_status status = read_crowd_attribute(g, map, where, "TRANSLATION", 3, &c, &c.translation);
    if (!status) status = read_crowd_attribute(g, map, where, "ROTATION", 4, &c, &c.rotation);
    if (!status) status = read_crowd_attribute(g, map, where, "SCALE", 3, &c, &c.scale);
    for (size_t i = 0; i < c.count && !status; i++) {
        dmat local = crowd_matrix(&c, i);
        status = add_instances(g, index, node, shapes, &local, name);
    }
    free(c.translation);
    free(c.rotation);
    free(c.scale);
    return status;
}

static snell_status add_mesh(gltf *g, size_t index) {
    const json_t *node = json_item(g, "nodes", index),
                 *mesh = json_item(g, "meshes", json_index(node, "mesh", 0)),
                 *instancing = json_extension(node, "EXT_mesh_gpu_instancing");
    const uint32_t *shapes = NULL;
    bool own = false, in_world = false;
    const char *name = json_text(node, "name");
    if (name == NULL) name = json_text(mesh, "name");
    snell_status status = gltf_mesh_shapes(g, index, &shapes, &own, &in_world);
    const gltf_node *placed = in_world ? NULL : &g->nodes[index];
    if (!status)
        status = instancing ? add_crowd(g, index, placed, instancing, shapes, name)
                            : add_instances(g, index, placed, shapes, &identity, name);
    if (own) free((void *)(uintptr_t)shapes);
    return status;
}

/* A camera's place and axes, without the scale of its node. false: its transform is flat. */
static bool camera_axes(const dmat *world, dmat *out) {
    dvec3 forward = dvec3_normalize(dmat_vector(world, (dvec3){0, 0, -1})),
          up = dvec3_normalize(dmat_vector(world, (dvec3){0, 1, 0})),
          across = dvec3_cross(forward, up);
    if (!(dvec3_length(across) > 1e-3)) return false;
    dvec3 x = dvec3_normalize(across), y = dvec3_cross(x, forward), z = dvec3_negate(forward);
    *out = (dmat){{{x.x, y.x, z.x, world->m[0][3]},
                   {x.y, y.y, z.y, world->m[1][3]},
                   {x.z, y.z, z.z, world->m[2][3]}}};
    return true;
}

static dmat inverse_of_axes(const dmat *a) {
    dmat out = {{{0}}};
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            out.m[r][c] = a->m[c][r];
            out.m[r][3] -= a->m[c][r] * a->m[c][3];
        }
    return out;
}

/* From where the camera is at the frame's own time to where it is at others. */
static size_t camera_keys(const gltf *g, const gltf_node *node, motion_key keys[CLOCK_TIMES]) {
    dmat now, then;
    size_t count = 0;
    if (node->worlds == NULL || !camera_axes(&node->world, &now)) return 0;
    dmat back = inverse_of_axes(&now);
    for (int i = 0; i < CLOCK_TIMES; i++) {
        if (!camera_axes(&node->worlds[i], &then)) continue;
        dmat moved = dmat_multiply(&then, &back);
        keys[count++] = (motion_key){g->times[i], to_transform(&moved)};
    }
    return count;
}

static snell_status add_camera(gltf *g, size_t index) {
    const json_t *node = json_item(g, "nodes", index);
    size_t number = json_index(node, "camera", 0);
    const json_t *camera = json_item(g, "cameras", number),
                 *perspective = json_at(camera, "perspective");
    const dmat *world = &g->nodes[index].world;
    const char *wanted = json_text(camera, "name");
    bool parallel = strcmp(json_text(camera, "type"), "orthographic") == 0;
    /* The picture's width follows from its own shape, not from xmag. */
    double height = 2 * fabs(json_number(json_at(camera, "orthographic"), "ymag", 0)) *
                    dvec3_length(dmat_vector(world, (dvec3){0, 1, 0}));
    double fov = json_number(perspective, "yfov", 0);
    dvec3 from = dmat_point(world, (dvec3){0, 0, 0}),
          forward = dvec3_normalize(dmat_vector(world, (dvec3){0, 0, -1})),
          up = dvec3_normalize(dmat_vector(world, (dvec3){0, 1, 0}));
    double size = parallel ? height : fov;
    bool fits = parallel ? (float)size > 0 && (float)size < INFINITY : fov >= 1e-4 && fov <= 3.1415;
    if (!fits || !(dvec3_length(dvec3_cross(forward, up)) > 1e-3))
        return gltf_warn(g, "cameras[%zu]: a %s of %g or a flat transform: ignored", number,
                         parallel ? "height" : "field of view", size);
    char name[NAME_MAX_SIZE];
    snell_status status = names_make_unique(&g->names, CATEGORY_CAMERA,
                                            wanted ? wanted : json_text(node, "name"), name);
    if (status) return status;
    /* `at` scales with the distance from the origin, so that rounding cannot join it with `from`.
     */
    double distance = 1 + dvec3_length(from);
    motion_key keys[CLOCK_TIMES];
    size_t key_count = camera_keys(g, &g->nodes[index], keys);
    snell_param params[] = {
        {"from", SNELL_PARAM_VEC3, {.v = vec3_from(from)}},
        {"at", SNELL_PARAM_VEC3, {.v = vec3_from(dvec3_add(from, dvec3_scale(forward, distance)))}},
        {"up", SNELL_PARAM_VEC3, {.v = vec3_from(up)}},
        {parallel ? "height" : "fov", SNELL_PARAM_FLOAT, {.f = size}},
        {"motion", SNELL_PARAM_ARRAY, {.array = {keys, key_count}}}};
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "nodes[%zu].camera", index);
    uint32_t made;
    status = description_add(g->d, CATEGORY_CAMERA, parallel ? "orthographic" : "perspective",
                             params, key_count > 1 ? 5 : 4,
                             (object_source){name[0] ? name : NULL, g->path, 0}, &made);
    return gltf_blame(g, where, status);
}

/* KHR_lights_punctual. Its lux and candela are photometric; 683 lm/W makes them radiometric, as
 * every renderer that takes them literally does. */
static snell_status add_light(gltf *g, size_t index, size_t number) {
    const json_t *node = json_item(g, "nodes", index),
                 *list = json_at(json_extension(g->root, "KHR_lights_punctual"), "lights"),
                 *light = json_array_get(list, number);
    const dmat *world = &g->nodes[index].world;
    char where[JSON_PATH_SIZE], name[NAME_MAX_SIZE];
    snprintf(where, sizeof where, "nodes[%zu].extensions.KHR_lights_punctual", index);
    if (light == NULL)
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "there is no light %zu", number);
    const char *type = json_text(light, "type"), *wanted = json_text(light, "name");
    bool directional = strcmp(type, "directional") == 0, spot = strcmp(type, "spot") == 0;
    if (!directional && !spot && strcmp(type, "point") != 0)
        return gltf_warn(g, "%.40s lights are not known: ignored", type);
    double color[3] = {1, 1, 1}, scale = json_number(light, "intensity", 1) / 683;
    json_numbers(light, "color", color, 3);
    snell_vec3 strength = {(float)(color[0] * scale), (float)(color[1] * scale),
                           (float)(color[2] * scale)};
    dvec3 forward = dvec3_normalize(dmat_vector(world, (dvec3){0, 0, -1}));
    if ((directional || spot) && !(dvec3_length(forward) > 0))
        return gltf_warn(g, "%s: a flat transform gives no direction: ignored", where);
    snell_status status = names_make_unique(&g->names, CATEGORY_LIGHT,
                                            wanted ? wanted : json_text(node, "name"), name);
    if (status) return status;
    dvec3 position = dmat_point(world, (dvec3){0, 0, 0});
    const json_t *cone = json_at(light, "spot");
    double outer = json_number(cone, "outerConeAngle", PI / 4),
           inner = json_number(cone, "innerConeAngle", 0);
    if (spot && !(outer >= 1e-4 && outer <= PI / 2 && inner < outer))
        return gltf_error(g, SNELL_ERR_SYNTAX, where,
                          "a spot's inner angle %g must be less than its outer angle %g", inner,
                          outer);
    snell_param params[] = {
        {directional ? "direction" : "position",
         SNELL_PARAM_VEC3,
         {.v = vec3_from(directional ? forward : position)}},
        {directional ? "irradiance" : "intensity", SNELL_PARAM_VEC3, {.v = strength}},
        {"at",
         SNELL_PARAM_VEC3,
         {.v = vec3_from(dvec3_add(position, dvec3_scale(forward, 1 + dvec3_length(position))))}},
        {"cone", SNELL_PARAM_FLOAT, {.f = outer}},
        {"blend", SNELL_PARAM_FLOAT, {.f = outer - inner}}};
    uint32_t made;
    status = description_add(g->d, CATEGORY_LIGHT, type, params, spot ? 5 : 2,
                             (object_source){name[0] ? name : NULL, g->path, 0}, &made);
    return gltf_blame(g, where, status);
}

static snell_status add_node(gltf *g, size_t index) {
    const json_t *node = json_item(g, "nodes", index);
    size_t light = json_index(json_extension(node, "KHR_lights_punctual"), "light", SIZE_MAX);
    snell_status status = SNELL_OK;
    if (json_at(node, "mesh")) status = add_mesh(g, index);
    if (!status && json_at(node, "camera")) status = add_camera(g, index);
    if (!status && light != SIZE_MAX) status = add_light(g, index, light);
    return status;
}

/* ---- the scene ---- */

/* The scene's roots on the stack, the first on top: those of `scene`, else of scene 0; a file
 * without scenes shows all roots. */
static snell_status push_roots(gltf *g, size_t *stack, size_t *used) {
    size_t number = json_index(g->root, "scene", 0), count = json_count(g, "nodes");
    const json_t *roots = json_at(json_item(g, "scenes", number), "nodes");
    bool *listed = memory_zeroed(count + 1, sizeof *listed);
    if (listed == NULL) return error_no_memory();
    snell_status status = SNELL_OK;
    for (size_t i = json_array_size(roots); i-- > 0 && !status;) {
        size_t node = child_at(roots, i);
        char where[JSON_PATH_SIZE];
        snprintf(where, sizeof where, "scenes[%zu].nodes[%zu]", number, i);
        if (g->nodes[node].parent != SIZE_MAX)
            status = gltf_error(g, SNELL_ERR_SYNTAX, where, "node %zu is no root", node);
        else if (listed[node])
            status = gltf_error(g, SNELL_ERR_SYNTAX, where, "node %zu is listed twice", node);
        else
            stack[(*used)++] = node;
        listed[node] = true;
    }
    if (json_count(g, "scenes") == 0)
        for (size_t i = count; i-- > 0;)
            if (g->nodes[i].parent == SIZE_MAX) stack[(*used)++] = i;
    free(listed);
    return status;
}

static snell_status draw_scene(gltf *g, size_t *stack) {
    size_t used = 0;
    snell_status status = push_roots(g, stack, &used);
    while (used > 0 && !status) {
        size_t index = stack[--used];
        const json_t *children = json_at(json_item(g, "nodes", index), "children");
        for (size_t k = json_array_size(children); k-- > 0;) stack[used++] = child_at(children, k);
        status = add_node(g, index);
    }
    return status;
}

snell_status gltf_read_scene(gltf *g) {
    /* Each node has one parent, so a stack as long as there are nodes is enough. */
    size_t *stack = memory_zeroed(json_count(g, "nodes") + 1, sizeof *stack);
    if (stack == NULL) return error_no_memory();
    snell_status status = find_parents(g);
    if (!status) status = place_nodes(g, stack);
    if (!status) status = draw_scene(g, stack);
    free(stack);
    return status;
}
