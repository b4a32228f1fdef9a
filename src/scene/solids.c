#include "scene/solids.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "materials/material.h"

static const object *shape_at(const description *d, uint32_t shape) {
    return &d->objects[CATEGORY_SHAPE].items[shape];
}

static const solid_desc *as_solid(const object *o) {
    return o->type == &primitive_solid.info ? o->desc : NULL;
}

static transform part_transform(const solid_desc *solid, size_t i) {
    return solid->transforms_count ? solid->transforms[i] : transform_identity();
}

/* ---- what can be part of a solid ---- */

/* Recursions over solids end: a solid names shapes that were there before it, and is refused if it
 * nests deeper than SOLID_DEPTH_MAX. Counting stops at a limit, since shapes may be named often. */
static void measure(const description *d, uint32_t shape, uint32_t *parts, uint32_t *depth) {
    const solid_desc *solid = as_solid(shape_at(d, shape));
    uint32_t deepest = 0;
    *depth = 0;
    if (solid == NULL) {
        ++*parts;
        return;
    }
    for (size_t i = 0; i < solid->shapes_count && *parts <= SOLID_PARTS_MAX; i++) {
        uint32_t below;
        measure(d, solid->shapes[i].index1 - 1, parts, &below);
        if (below > deepest) deepest = below;
    }
    *depth = deepest + 1;
}

uint32_t shape_part_count(const description *d, uint32_t shape) {
    uint32_t parts = 0, depth;
    measure(d, shape, &parts, &depth);
    return parts;
}

static snell_status check_mesh(const object *o) {
    const mesh_desc *mesh = o->desc;
    if (mesh->key_times_count)
        return error_set(SNELL_ERR_ARGUMENT, "give the solid the mesh at one time; solids can move",
                         "mesh: a mesh that deforms cannot be part of a solid");
    mesh_closure closure;
    vec3 edge[2];
    snell_status status = mesh_find_closure(o->desc, &closure, edge);
    if (status || closure != MESH_OPEN) return status;
    return error_set(SNELL_ERR_ARGUMENT, "a solid needs meshes without holes",
                     "mesh: an open mesh cannot be part of a solid: the edge from %g, %g, %g to "
                     "%g, %g, %g has nothing on one side",
                     (double)edge[0].x, (double)edge[0].y, (double)edge[0].z, (double)edge[1].x,
                     (double)edge[1].y, (double)edge[1].z);
}

static snell_status check_part(const description *d, uint32_t shape) {
    const object *o = shape_at(d, shape);
    const primitive_type *type = (const primitive_type *)o->type;
    if (as_solid(o)) return SNELL_OK;
    if (object_is_group(o))
        return error_set(SNELL_ERR_ARGUMENT, "give the solid the shapes that are in it",
                         "solid: a group cannot be part of a solid");
    if (type == &primitive_mesh) return check_mesh(o);
    if (type->spans == NULL)
        return error_set(SNELL_ERR_ARGUMENT, "closed shapes can, and planes as half-spaces",
                         "%s: it encloses nothing and cannot be part of a solid", o->type->name);
    const local_ray any = {{0, 0, 0}, {0.6f, 0.64f, 0.48f}, 0, INFINITY};
    span unused[1];
    void *made = type->prepare ? type->prepare(o->desc) : NULL;
    if (type->prepare && made == NULL) return error_no_memory();
    bool closed = type->spans(made ? made : o->desc, &any, unused, 0) >= 0;
    if (made) type->release(made);
    if (closed) return SNELL_OK;
    bool caps = type_find_field(o->type, "capped") != NULL;
    return error_set(SNELL_ERR_ARGUMENT,
                     caps ? "set capped = true" : "begin and end its line on the axis",
                     "%s: an open %s cannot be part of a solid", o->type->name, o->type->name);
}

/* A row of one shape, under as many transforms, is most of what names shapes often. */
static bool is_named_before(const snell_shape_id *shapes, size_t i) {
    for (size_t k = i; k-- > 0;)
        if (shapes[k].index1 == shapes[i].index1) return true;
    return false;
}

snell_status solid_check_parts(const description *d, const snell_shape_id *shapes, size_t count) {
    uint32_t parts = 0, deepest = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t depth;
        snell_status status =
            is_named_before(shapes, i) ? SNELL_OK : check_part(d, shapes[i].index1 - 1);
        if (status) return status;
        measure(d, shapes[i].index1 - 1, &parts, &depth);
        if (depth > deepest) deepest = depth;
        if (parts > SOLID_PARTS_MAX)
            return error_set(SNELL_ERR_ARGUMENT, "make it of several, or of a mesh",
                             "solid: it is made of more than %d shapes", SOLID_PARTS_MAX);
    }
    if (deepest + 1 <= SOLID_DEPTH_MAX) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "put more shapes into one",
                     "solid: solids in solids, more than %d deep", SOLID_DEPTH_MAX);
}

/* ---- bounds ---- */

static bounds3 everywhere(void) {
    return (bounds3){{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
}

bool bounds_are_finite(bounds3 b) {
    return isfinite(b.min.x) && isfinite(b.min.y) && isfinite(b.min.z) && isfinite(b.max.x) &&
           isfinite(b.max.y) && isfinite(b.max.z);
}

static bounds3 common_bounds(bounds3 a, bounds3 b) {
    bounds3 both = {vec3_max(a.min, b.min), vec3_min(a.max, b.max)};
    return bounds3_is_empty(both) ? bounds3_empty() : both;
}

static dvec3 vec3_field(const object *o, const char *name) {
    const field *f = type_find_field(o->type, name);
    return dvec3_from(*(const vec3 *)(const void *)((const char *)o->desc + f->offset));
}

/* A half-space across an axis has a bound on it. */
static bounds3 plane_bounds(const object *o, const transform *placed) {
    transform inverse;
    bounds3 all = everywhere();
    if (!transform_inverse(placed, &inverse)) return all;
    dvec3 n = transform_normal(&inverse, vec3_field(o, "normal")),
          p = transform_point(placed, vec3_field(o, "point"));
    if ((n.x != 0) + (n.y != 0) + (n.z != 0) != 1) return all;
    bounds3 at = bounds3_outward(p, p);
    if (n.x > 0) all.max.x = at.max.x;
    if (n.x < 0) all.min.x = at.min.x;
    if (n.y > 0) all.max.y = at.max.y;
    if (n.y < 0) all.min.y = at.min.y;
    if (n.z > 0) all.max.z = at.max.z;
    if (n.z < 0) all.min.z = at.min.z;
    return all;
}

bounds3 shape_bounds(const description *d, uint32_t shape, const transform *placed) {
    const object *o = shape_at(d, shape);
    const primitive_type *type = (const primitive_type *)o->type;
    const solid_desc *solid = as_solid(o);
    if (solid == NULL) {
        if (type == primitive_find("plane")) return plane_bounds(o, placed);
        if (type->unbounded) return everywhere();
        bounds3 own = type->bounds(o->desc);
        return transform_is_identity(placed) ? own : transform_bounds(placed, own);
    }
    bounds3 all = bounds3_empty();
    for (size_t i = 0; i < solid->shapes_count; i++) {
        transform own = part_transform(solid, i), there = transform_multiply(placed, &own);
        if (i > 0 && solid->operation == SOLID_DIFFERENCE) break;
        bounds3 part = shape_bounds(d, solid->shapes[i].index1 - 1, &there);
        if (i == 0)
            all = part;
        else if (solid->operation == SOLID_UNION)
            all = bounds3_union(all, part);
        else
            all = common_bounds(all, part);
    }
    return all;
}

/* ---- compiling ---- */

snell_status solid_set_create(size_t shape_count, solid_set **out) {
    solid_set *set = memory_zeroed(1, sizeof *set);
    if (set) set->solids = memory_zeroed(shape_count, sizeof *set->solids);
    if (set == NULL || set->solids == NULL) {
        free(set);
        return error_no_memory();
    }
    set->shape_count = shape_count;
    *out = set;
    return SNELL_OK;
}

static void destroy_solid(solid_shape *s) {
    if (s == NULL) return;
    free(s->parts);
    free(s->nodes);
    free(s->slots);
    free(s);
}

void solid_set_destroy(solid_set *set) {
    if (set == NULL) return;
    for (size_t i = 0; i < set->shape_count; i++) destroy_solid(set->solids[i]);
    for (size_t i = 0; i < set->mesh_count; i++) solid_mesh_destroy(set->meshes[i]);
    free(set->solids);
    free(set->meshes);
    free(set);
}

static snell_status find_mesh(solid_set *set, const mesh_desc *mesh, thread_pool *pool,
                              const solid_mesh **out) {
    for (size_t i = 0; i < set->mesh_count; i++)
        if (set->meshes[i]->mesh == mesh) {
            *out = set->meshes[i];
            return SNELL_OK;
        }
    if (!ARRAY_GROW(set->meshes, set->mesh_count, set->mesh_capacity, 1)) return error_no_memory();
    snell_status status = solid_mesh_create(mesh, pool, &set->meshes[set->mesh_count]);
    if (!status) *out = set->meshes[set->mesh_count++];
    return status;
}

typedef struct compiler {
    solid_set *set;
    const description *d;
    thread_pool *pool;
    solid_shape *made;
    size_t part_capacity, node_capacity, slot_capacity;
    size_t part_count, node_count, slot_count; /* of `made`, as array_grow takes them */
    uint64_t face_count;
} compiler;

/* What a shape inherits from the solids that it is in. */
typedef struct place {
    transform to_solid;
    uint32_t material; /* NO_ID: the instance's */
    uint32_t node;
    bool first, subtracted;
} place;

static snell_status add_slot(compiler *c, uint32_t index) {
    if (!ARRAY_GROW(c->made->slots, c->slot_count, c->slot_capacity, 1)) return error_no_memory();
    c->made->slots[c->slot_count++] = index;
    return SNELL_OK;
}

/* Slots of a mesh that has materials of its own, which are the same wherever it is named; else one. */
static snell_status add_slots(compiler *c, solid_part *part, uint32_t index) {
    const mesh_desc *mesh = part->mesh ? part->mesh->mesh : NULL;
    if (mesh == NULL || mesh->material_slots_count == 0) return add_slot(c, index);
    for (size_t i = 0; i < c->part_count; i++)
        if (c->made->parts[i].mesh == part->mesh) {
            part->first_slot = c->made->parts[i].first_slot;
            return SNELL_OK;
        }
    if (mesh->materials_count >= NO_ID - SOLID_PARTS_MAX - c->slot_count)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "a solid of too many materials");
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < mesh->materials_count && !status; i++)
        status = add_slot(c, mesh->materials[i].index1 - 1);
    return status;
}

static snell_status add_part(compiler *c, uint32_t shape, const place *at) {
    const object *o = shape_at(c->d, shape);
    const primitive_type *type = (const primitive_type *)o->type;
    const mesh_desc *mesh = type == &primitive_mesh ? o->desc : NULL;
    const void *made = c->set->prepared[shape].made;
    solid_part part = {.type = type,
                       .desc = made ? made : o->desc,
                       .identity = transform_is_identity(&at->to_solid),
                       .subtracted = at->subtracted,
                       .first = at->first,
                       .has_uv = mesh ? mesh->uvs_count != 0 : !type->unbounded,
                       .node = at->node,
                       .first_face = (uint32_t)c->face_count,
                       .first_slot = (uint32_t)c->slot_count,
                       .to_solid = at->to_solid,
                       .bounds = shape_bounds(c->d, shape, &at->to_solid)};
    part.bounded = bounds_are_finite(part.bounds);
    c->face_count += solid_face_count(type, o->desc);
    if (c->face_count >= NO_ID)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "a solid of too many triangles");
    if (!transform_inverse(&part.to_solid, &part.to_local))
        return error_set(SNELL_ERR_ARGUMENT, "scales must not be 0, nor nearly",
                         "the transforms of a solid's %s cannot be inverted", type->info.name);
    snell_status status = mesh ? find_mesh(c->set, mesh, c->pool, &part.mesh) : SNELL_OK;
    if (!status) status = add_slots(c, &part, at->material);
    if (status) return status;
    if (!ARRAY_GROW(c->made->parts, c->part_count, c->part_capacity, 1)) return error_no_memory();
    c->made->parts[c->part_count++] = part;
    return SNELL_OK;
}

static snell_status add_shapes(compiler *c, const solid_desc *from, uint32_t node, const place *at);

/* A solid of one shape is that shape; another is a node, under `at`. */
static snell_status add_shape(compiler *c, uint32_t shape, const place *at) {
    const solid_desc *from = as_solid(shape_at(c->d, shape));
    if (from == NULL) return add_part(c, shape, at);
    if (from->shapes_count == 1) {
        place only = *at;
        transform own = part_transform(from, 0);
        only.to_solid = transform_multiply(&at->to_solid, &own);
        if (from->materials_count && from->materials[0].index1)
            only.material = from->materials[0].index1 - 1;
        return add_shape(c, from->shapes[0].index1 - 1, &only);
    }
    if (!ARRAY_GROW(c->made->nodes, c->node_count, c->node_capacity, 1)) return error_no_memory();
    uint32_t node = (uint32_t)c->node_count++;
    c->made->nodes[node] = (solid_node){.operation = from->operation,
                                        .parent = at->node,
                                        .first = at->first,
                                        .child_count = (uint32_t)from->shapes_count};
    return add_shapes(c, from, node, at);
}

static snell_status add_shapes(compiler *c, const solid_desc *from, uint32_t node,
                               const place *at) {
    for (size_t i = 0; i < from->shapes_count; i++) {
        bool taken_off = from->operation == SOLID_DIFFERENCE && i > 0;
        transform own = part_transform(from, i);
        uint32_t own_material = from->materials_count ? from->materials[i].index1 : 0;
        place here = {.to_solid = transform_multiply(&at->to_solid, &own),
                      .material = own_material ? own_material - 1 : at->material,
                      .node = node,
                      .first = i == 0,
                      .subtracted = at->subtracted != taken_off};
        snell_status status = add_shape(c, from->shapes[i].index1 - 1, &here);
        if (status) return status;
    }
    return SNELL_OK;
}

/* Rays see a shape under the inverse of to_local, which is rounded: a little more room. */
static bounds3 widened(bounds3 b) {
    const double scale = 0x1p-20;
    if (bounds3_is_empty(b) || !bounds_are_finite(b)) return b;
    dvec3 low = dvec3_from(b.min), high = dvec3_from(b.max);
    double size =
        fabs(low.x) + fabs(low.y) + fabs(low.z) + fabs(high.x) + fabs(high.y) + fabs(high.z);
    dvec3 more = {scale * size, scale * size, scale * size};
    return bounds3_outward(dvec3_sub(low, more), dvec3_add(high, more));
}

/* The root is a node even of one shape. */
static snell_status compile(compiler *c, uint32_t shape) {
    const object *o = shape_at(c->d, shape);
    const solid_desc *from = o->desc;
    place top = {.to_solid = transform_identity(), .material = NO_ID, .first = true};
    if (!ARRAY_GROW(c->made->nodes, c->node_count, c->node_capacity, 1)) return error_no_memory();
    c->made->nodes[c->node_count++] =
        (solid_node){.operation = from->operation, .child_count = (uint32_t)from->shapes_count};
    snell_status status = add_shapes(c, from, 0, &top);
    if (status) error_place((source_place){o->file, o->line, 0});
    c->made->part_count = (uint32_t)c->part_count;
    c->made->node_count = (uint32_t)c->node_count;
    c->made->slot_count = (uint32_t)c->slot_count;
    for (size_t i = 0; i < c->slot_count; i++) {
        uint32_t index = c->made->slots[i];
        c->made->textured |= index == NO_ID ? c->set->textured : c->set->materials[index].textured;
    }
    c->made->bounds = widened(shape_bounds(c->d, shape, &top.to_solid));
    return status;
}

snell_status solid_set_compile(solid_set *set, const description *d, uint32_t shape,
                               thread_pool *pool, const solid_shape **out) {
    snell_status status = SNELL_OK;
    if (set->solids[shape] == NULL) {
        compiler c = {.set = set, .d = d, .pool = pool, .made = memory_zeroed(1, sizeof *c.made)};
        if (c.made == NULL) return error_no_memory();
        status = compile(&c, shape);
        if (status)
            destroy_solid(c.made);
        else
            set->solids[shape] = c.made;
    }
    *out = set->solids[shape];
    return status;
}

size_t solid_set_memory(const solid_set *set) {
    size_t bytes = 0;
    for (size_t i = 0; i < set->mesh_count; i++)
        bytes += set->meshes[i]->tree.node_count * sizeof(bvh_node) +
                 set->meshes[i]->tree.block_count * sizeof(triangle_block);
    for (size_t i = 0; i < set->shape_count; i++)
        if (set->solids[i])
            bytes += set->solids[i]->part_count * sizeof(solid_part) +
                     set->solids[i]->node_count * sizeof(solid_node) +
                     set->solids[i]->slot_count * sizeof(uint32_t);
    return bytes;
}
