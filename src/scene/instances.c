#include "scene/instances.h"

#include "scene/seen.h"

#include <stdlib.h>

#include "accel/build.h"

#include "base/memory.h"
#include "geometry/mesh.h"
#include "scene/lights.h"

/* ---- what an instance is made of ---- */

/* What shadow rays make of a material: MASK_OPAQUE, MASK_FILTER or MASK_NO_SHADOW. */
static uint32_t shadow_mask(const material *m) {
    const material_common *common = m->desc;
    if (common->shadow == SHADOW_NONE) return MASK_NO_SHADOW;
    if (common->shadow == SHADOW_OPAQUE) return MASK_OPAQUE;
    bool filters = material_bounds_medium(m->type, m->desc) || m->thin || !m->opaque_alpha;
    return filters ? MASK_FILTER : MASK_OPAQUE;
}

static bool has_vertex_alphas(const scene_instance *at) {
    if (mesh_is(at->type)) return ((const mesh_desc *)at->shape)->alphas_count != 0;
    if (!solid_is(at->type)) return false;
    const solid_shape *whole = at->shape;
    for (uint32_t i = 0; i < whole->part_count; i++)
        if (whole->parts[i].mesh && whole->parts[i].mesh->mesh->alphas_count) return true;
    return false;
}

/* What has several materials is a filter as soon as one of them is: the walk looks at each
 * triangle or face. */
uint32_t instance_mask(const scene *s, const scene_instance *at) {
    if (has_vertex_alphas(at)) return MASK_FILTER;
    uint32_t mask = shadow_mask(&s->materials[instance_slot(at, 0)]);
    for (uint32_t i = 1; i < instance_slot_count(at); i++)
        if (shadow_mask(&s->materials[instance_slot(at, i)]) != mask) return MASK_FILTER;
    return mask;
}

static bool bounds_medium(const scene *s, uint32_t index) {
    return material_bounds_medium(s->materials[index].type, s->materials[index].desc);
}

/* What is inside an instance: the medium of its first material that has one. */
static void find_medium(const scene *s, scene_instance *at) {
    uint32_t index = instance_slot(at, 0);
    for (uint32_t i = 1; i < instance_slot_count(at) && !bounds_medium(s, index); i++)
        index = instance_slot(at, i);
    const material *m = &s->materials[index];
    at->has_medium = bounds_medium(s, index);
    at->medium_material = index;
    if (at->has_medium) at->inside = m->type->inside(m->desc);
}

/* May some of it be sampled as a light? */
static bool can_be_sampled(const scene *s, const scene_instance *at) {
    if (at->type->area == NULL && !seen_can_be_sampled(s, at)) return false;
    for (uint32_t i = 0; i < instance_slot_count(at); i++)
        if (s->materials[instance_slot(at, i)].shines) return true;
    return false;
}

/* ---- motions ---- */

typedef struct freezing {
    scene *s;
    const description *d;
    thread_pool *pool;
    part_lists lists;
    uint32_t *motion_of;    /* of each of the description's instances, in s->motions; or NO_ID */
    uint32_t *first_group;  /* of each shape, in s->groups; or NO_ID */
    bool *takes_usual;      /* of each group: something in it has no material of its own */
    accel_instance *placed; /* beside s->instances */
    size_t instance_capacity, id_capacity, placed_capacity, group_capacity;
    uint64_t memory_max, planned_shapes; /* bytes: allowed, 0: any; and what all but parts take */
    uint32_t largest, open_groups;       /* parts of one level; groups that are being made */
} freezing;

/* Each once, however many groups it is in. */
static snell_status freeze_motions(freezing *f) {
    const description *d = f->d;
    scene *s = f->s;
    size_t moving = 0;
    for (size_t i = 0; i < d->instance_count; i++) moving += d->instances[i].key_count != 0;
    s->motions = memory_zeroed(moving, sizeof *s->motions);
    f->motion_of = memory_resize(NULL, d->instance_count, sizeof *f->motion_of);
    if (!s->motions || !f->motion_of) return error_no_memory();
    for (size_t i = 0; i < d->instance_count; i++) {
        const instance *from = &d->instances[i];
        f->motion_of[i] = NO_ID;
        if (from->removed || from->key_count == 0) continue;
        snell_status status = motion_prepare(from->keys, from->key_count, s->time_open,
                                             s->time_close, &s->motions[s->motion_count]);
        if (status) {
            const object *shape = &d->objects[CATEGORY_SHAPE].items[from->shape];
            error_place((source_place){shape->file, from->line, 0});
            return status;
        }
        f->motion_of[i] = s->motion_count++;
    }
    s->changes = s->motion_count != 0;
    return SNELL_OK;
}

/* Where it stands, or how it moves. */
static snell_status place(const freezing *f, uint32_t id, scene_instance *at) {
    const instance *from = &f->d->instances[id];
    at->to_world = from->to_world;
    if (f->motion_of[id] != NO_ID) {
        const motion *m = &f->s->motions[f->motion_of[id]];
        at->to_world = m->steps[0].transform;
        at->motion = m;
        if (m->count > 1) at->moves = m; /* else it stands still while anyone looks */
    }
    at->identity = at->moves == NULL && transform_is_identity(&at->to_world);
    if (transform_inverse(&at->to_world, &at->to_local)) return SNELL_OK;
    const object *shape = &f->d->objects[CATEGORY_SHAPE].items[from->shape];
    return error_set_at(SNELL_ERR_ARGUMENT, (source_place){shape->file, from->line, 0},
                        "a scale of 0 squashes the shape flat",
                        "%s: the transform cannot be inverted", shape->type->name);
}

static bool deforms(const object *o) {
    return o->type == &primitive_mesh.info && ((const mesh_desc *)o->desc)->key_times_count != 0;
}

/* ---- memory, stated before it is taken ---- */

/* Of a mesh in a solid, the tables in which edges and vertices are counted. */
enum { TRIANGLE_CLOSURE_BYTES = 3 * 4 * 16, VERTEX_CLOSURE_BYTES = 4 + 4 * 4 };
enum {
    /* Arrays that grow are up to twice as long, and are copied while they do. */
    PART_BYTES = 3 * (sizeof(scene_instance) + sizeof(uint32_t) + sizeof(accel_instance)) +
                 sizeof(frozen_instance) + sizeof(frozen_outline) + sizeof(uint32_t),
    GROUP_BYTES = 3 * sizeof(scene_group) + sizeof(frozen_geometry) + sizeof(accel_geometry),
    SHAPE_BYTES = sizeof(frozen_geometry) + sizeof(accel_geometry) + sizeof(prepared_shape) +
                  sizeof(solid_shape *) + 2 * sizeof(uint32_t) + sizeof(bool)
};

/* Bytes that stay, and the most that something needs while it is made. */
typedef struct shape_plan {
    const description *d;
    uint32_t *seen_in; /* of each shape: the last solid that was found to name it, from 1; or 0 */
    uint64_t stays, building;
    uint64_t small, small_count; /* of those that are built side by side: the most of one */
} shape_plan;

static uint64_t larger(uint64_t a, uint64_t b) { return a > b ? a : b; }

/* A mesh in a solid: a tree of its own, once for all solids; its materials once for each. */
static void plan_solid_mesh(shape_plan *p, uint32_t solid, uint32_t shape) {
    const mesh_desc *mesh = p->d->objects[CATEGORY_SHAPE].items[shape].desc;
    uint64_t count = mesh_triangle_count(mesh);
    if (p->seen_in[shape] == solid + 1) return;
    if (p->seen_in[shape] == 0) {
        build_bytes tree = build_plan(true, SOLID_MESH_LEAF, count);
        uint64_t closure = TRIANGLE_CLOSURE_BYTES * count +
                           VERTEX_CLOSURE_BYTES * (uint64_t)mesh->positions_count +
                           sizeof(build_reference) * count;
        p->stays += sizeof(solid_mesh) + tree.stays;
        p->building = larger(p->building, larger(tree.building, closure));
    }
    p->seen_in[shape] = solid + 1;
    if (mesh->material_slots_count) p->stays += 3 * sizeof(uint32_t) * mesh->materials_count;
}

static void plan_named(shape_plan *p, uint32_t solid, uint32_t shape) {
    const object *o = &p->d->objects[CATEGORY_SHAPE].items[shape];
    if (o->type == &primitive_mesh.info) plan_solid_mesh(p, solid, shape);
    if (o->type != &primitive_solid.info) return;
    const solid_desc *from = o->desc;
    for (size_t i = 0; i < from->shapes_count; i++)
        plan_named(p, solid, from->shapes[i].index1 - 1);
}

static void plan_solid(shape_plan *p, uint32_t shape) {
    p->stays +=
        sizeof(solid_shape) + 3 * (uint64_t)shape_part_count(p->d, shape) *
                                  (sizeof(solid_part) + sizeof(solid_node) + sizeof(uint32_t));
    plan_named(p, shape, shape);
}

static void plan_tree(shape_plan *p, const object *o, const double times[2]) {
    const primitive_type *type = (const primitive_type *)o->type;
    uint64_t count = type->primitive_count(o->desc);
    build_bytes tree =
        type->intersect ? build_plan(false, 1, count) : build_plan(true, BUILD_LEAF_SIZE, count);
    if (deforms(o)) { /* the tree once for each key that counts, and before that once */
        tree.building += tree.stays + count * sizeof(build_way);
        tree.stays *= (uint64_t)deforming_count_keys(o->desc, times[0], times[1]);
        tree.stays += sizeof(deforming_mesh);
    }
    p->stays += tree.stays;
    if (count < BUILD_SMALL) {
        p->small = larger(p->small, tree.building);
        p->small_count++;
    } else {
        p->building = larger(p->building, tree.building);
    }
}

/* What all takes but parts and groups. False: out of memory. */
static bool plan_shapes(const description *d, uint32_t threads, uint64_t *bytes) {
    const object_list *shapes = &d->objects[CATEGORY_SHAPE];
    shape_plan p = {.d = d, .seen_in = memory_zeroed(shapes->count, sizeof *p.seen_in)};
    double times[2];
    if (p.seen_in == NULL) return false;
    scene_visible_time(d, times);
    for (size_t i = 0; i < shapes->count; i++) {
        const object *o = &shapes->items[i];
        const primitive_type *type = (const primitive_type *)o->type;
        if (type->prepared_size) p.stays += type->prepared_size(o->desc) + sizeof(uint64_t);
        if (type == &primitive_solid) plan_solid(&p, (uint32_t)i);
        if (type->primitive_count) plan_tree(&p, o, times);
    }
    free(p.seen_in);
    uint64_t together = p.small_count < threads ? p.small_count : threads;
    *bytes =
        (1u << 16) + shapes->count * SHAPE_BYTES + p.stays + larger(p.building, together * p.small);
    return true;
}

/* parts: instances of the world and of groups; largest: of those the most in one. */
static uint64_t plan_parts(uint64_t parts, uint64_t largest, uint64_t groups) {
    build_bytes none = build_plan(false, 1, 0);
    return parts * PART_BYTES + groups * (GROUP_BYTES + none.stays) +
           build_plan(false, 1, parts).stays + build_plan(false, 1, largest).building;
}

uint64_t scene_plan_memory(const description *d, uint32_t threads) {
    uint64_t parts = 0, largest = 0, groups = 0, bytes = 0;
    part_lists lists;
    plan_shapes(d, threads, &bytes);
    if (part_lists_make(d, &lists) == SNELL_OK)
        for (size_t g = 0; g <= d->objects[CATEGORY_SHAPE].count; g++) {
            uint32_t count = lists.begin[g + 1] - lists.begin[g];
            parts += count;
            groups += g < d->objects[CATEGORY_SHAPE].count && count > 0;
            if (count > largest) largest = count;
        }
    part_lists_free(&lists);
    return bytes + plan_parts(parts, largest, groups);
}

/* Before `count` more parts are made of one group, or of the world: with those that there are. */
static snell_status check_plan(freezing *f, uint32_t count) {
    const scene *s = f->s;
    if (count > f->largest) f->largest = count;
    uint64_t planned = f->planned_shapes + plan_parts((uint64_t)s->part_count + count, f->largest,
                                                      (uint64_t)s->group_count + f->open_groups);
    if (f->memory_max == 0 || planned <= f->memory_max) return SNELL_OK;
    return error_set(SNELL_ERR_MEMORY, "allow more, or draw one group often",
                     "the scene's geometry needs %.1f MiB or more, %.1f MiB are allowed",
                     (double)planned * 0x1p-20, (double)f->memory_max * 0x1p-20);
}

/* ---- levels: the world and groups ---- */

/* Materials that reach the parts of a group from outside; NO_MATERIAL: none. */
typedef struct outside {
    uint32_t forced, usual;
} outside;

static snell_status reserve_parts(freezing *f, uint32_t count) {
    scene *s = f->s;
    snell_status status = check_plan(f, count);
    if (status) return status;
    bool room = s->part_count <= UINT32_MAX - 1 - count &&
                ARRAY_GROW(s->instances, s->part_count, f->instance_capacity, count) &&
                ARRAY_GROW(s->instance_ids, s->part_count, f->id_capacity, count) &&
                ARRAY_GROW(f->placed, s->part_count, f->placed_capacity, count);
    return room ? SNELL_OK : error_no_memory();
}

static snell_status freeze_group(freezing *f, uint32_t shape, outside from, uint32_t *out);

/* What a shape's type made of its description, or that. */
static const void *shape_of(const freezing *f, size_t index) {
    void *made = f->s->prepared[index].made;
    return made ? made : f->d->objects[CATEGORY_SHAPE].items[index].desc;
}

static const primitive_type *type_of(const freezing *f, size_t index) {
    const prepared_shape *prepared = &f->s->prepared[index];
    if (prepared->made) return prepared->type;
    return (const primitive_type *)f->d->objects[CATEGORY_SHAPE].items[index].type;
}

/* Of a mesh that deforms, the keys about what the shutters see. */
static snell_status prepare_deforming(const freezing *f, size_t shape) {
    scene *s = f->s;
    deforming_mesh *made = deforming_create(f->d->objects[CATEGORY_SHAPE].items[shape].desc,
                                            s->time_open, s->time_close);
    if (made == NULL) return error_no_memory();
    s->prepared[shape] = (prepared_shape){&primitive_deforming, made};
    s->changes |= made->key_count > 1;
    return SNELL_OK;
}

static snell_status prepare_shapes(const freezing *f) {
    scene *s = f->s;
    const object_list *shapes = &f->d->objects[CATEGORY_SHAPE];
    s->prepared = memory_zeroed(shapes->count, sizeof *s->prepared);
    if (s->prepared == NULL) return error_no_memory();
    s->prepared_count = shapes->count;
    s->solids->prepared = s->prepared;
    for (size_t i = 0; i < shapes->count; i++) {
        const primitive_type *type = (const primitive_type *)shapes->items[i].type;
        if (deforms(&shapes->items[i])) {
            snell_status status = prepare_deforming(f, i);
            if (status) return status;
            continue;
        }
        if (type->prepare == NULL) continue;
        s->prepared[i] = (prepared_shape){type, type->prepare(shapes->items[i].desc)};
        if (s->prepared[i].made == NULL) return error_no_memory();
    }
    return SNELL_OK;
}

/* The shape that rays meet: a solid is compiled, any other is as it is described or prepared. */
static snell_status shape_for_rays(const freezing *f, uint32_t index, accel_geometry *out) {
    *out = (accel_geometry){.type = type_of(f, index), .desc = shape_of(f, index)};
    if (out->type != &primitive_solid) return SNELL_OK;
    const solid_shape *compiled;
    snell_status status = solid_set_compile(f->s->solids, f->d, index, f->pool, &compiled);
    if (status) return status;
    bool boxed = bounds_are_finite(compiled->bounds) || bounds3_is_empty(compiled->bounds);
    out->type = boxed ? &solid_bounded : &solid_boundless;
    out->desc = compiled;
    return SNELL_OK;
}

static snell_status freeze_shape(const freezing *f, const instance *from, outside above,
                                 scene_instance *at) {
    uint32_t chosen = above.forced;
    if (chosen == NO_MATERIAL) chosen = from->material;
    if (chosen == NO_MATERIAL) chosen = above.usual;
    if (chosen == NO_MATERIAL) chosen = f->s->material_count;
    accel_geometry shape;
    snell_status status = shape_for_rays(f, from->shape, &shape);
    if (status) return status;
    *at = (scene_instance){.type = shape.type,
                           .shape = shape.desc,
                           .shape_index = from->shape,
                           .material = chosen,
                           .group = NO_ID};
    find_medium(f->s, at);
    at->shines = can_be_sampled(f->s, at);
    at->bounds_half = at->has_medium && at->type->unbounded && at->type->side;
    return SNELL_OK;
}

static snell_status freeze_group_part(freezing *f, const instance *from, outside above,
                                      scene_instance *at) {
    if (above.forced == NO_MATERIAL && from->material != NO_MATERIAL) {
        if (from->fills)
            above.usual = from->material;
        else
            above = (outside){from->material, NO_MATERIAL};
    }
    uint32_t group;
    snell_status status = freeze_group(f, from->shape, above, &group);
    if (status) return status;
    *at = (scene_instance){.type = &shape_group,
                           .shape = f->d->objects[CATEGORY_SHAPE].items[from->shape].desc,
                           .shape_index = from->shape,
                           .material = f->s->material_count,
                           .shines = f->s->groups[group].shines,
                           .bounds_half = f->s->groups[group].bounds_half,
                           .group = group};
    return SNELL_OK;
}

/* Instance `id` of the description at place `index`; *count: how many shapes come before it, and with
 * it. */
static snell_status freeze_part(freezing *f, uint32_t id, outside above, uint32_t index,
                                uint64_t *count, uint32_t *masks) {
    scene *s = f->s;
    const instance *from = &f->d->instances[id];
    bool is_group = object_is_group(&f->d->objects[CATEGORY_SHAPE].items[from->shape]);
    scene_instance at;
    snell_status status = SNELL_OK;
    if (is_group)
        status = freeze_group_part(f, from, above, &at);
    else
        status = freeze_shape(f, from, above, &at);
    if (!status) status = place(f, id, &at);
    if (status) return status;
    at.first = (uint32_t)*count;
    *count += is_group ? s->groups[at.group].shape_count : 1;
    if (*count >= NO_ID)
        return error_set(SNELL_ERR_ARGUMENT, "draw fewer copies",
                         "groups of groups draw more than %u shapes", NO_ID - 1);
    uint32_t mask = is_group ? s->groups[at.group].mask : instance_mask(s, &at);
    *masks |= mask;
    s->instances[index] = at;
    s->instance_ids[index] = id;
    f->placed[index] =
        (accel_instance){.geometry = is_group ? (uint32_t)f->d->objects[CATEGORY_SHAPE].count +
                                                    s->body_count + at.group
                                              : from->shape,
                         .mask = mask,
                         .identity = at.identity,
                         .to_world = at.to_world,
                         .to_local = at.to_local,
                         .moves = at.moves};
    if (is_group) return SNELL_OK;
    s->has_filters |= mask == MASK_FILTER || at.has_medium;
    s->has_unshadowing |= mask == MASK_NO_SHADOW;
    s->has_media |= at.has_medium;
    return SNELL_OK;
}

/* The one that was asked for last comes first: rows of the same are found at once. */
static uint32_t find_group(freezing *f, uint32_t shape, outside above) {
    scene_group *groups = f->s->groups;
    uint32_t *link = &f->first_group[shape];
    for (uint32_t i = *link; i != NO_ID; link = &groups[i].next, i = *link)
        if (groups[i].forced == above.forced && groups[i].usual == above.usual) {
            *link = groups[i].next;
            groups[i].next = f->first_group[shape];
            f->first_group[shape] = i;
            return i;
        }
    return NO_ID;
}

/* Groups come after those in them. Recursion: part_lists_make has checked the depth. */
static snell_status freeze_group(freezing *f, uint32_t shape, outside above, uint32_t *out) {
    scene *s = f->s;
    if (!f->takes_usual[shape]) above.usual = NO_MATERIAL;
    *out = find_group(f, shape, above);
    if (*out != NO_ID) return SNELL_OK;
    uint32_t begin = f->lists.begin[shape], count = f->lists.begin[shape + 1] - begin;
    f->open_groups++;
    snell_status status = reserve_parts(f, count);
    if (status) return status;
    scene_group made = {.shape_index = shape,
                        .forced = above.forced,
                        .usual = above.usual,
                        .first_part = s->part_count,
                        .part_count = count};
    s->part_count += count;
    uint64_t shapes = 0;
    for (uint32_t i = 0; i < count && !status; i++)
        status = freeze_part(f, f->lists.parts[begin + i], above, made.first_part + i, &shapes,
                             &made.mask);
    if (status) return status;
    for (uint32_t i = 0; i < count; i++) {
        made.shines |= s->instances[made.first_part + i].shines;
        made.bounds_half |= s->instances[made.first_part + i].bounds_half;
    }
    made.shape_count = (uint32_t)shapes;
    made.next = f->first_group[shape];
    if (!ARRAY_GROW(s->groups, s->group_count, f->group_capacity, 1)) return error_no_memory();
    *out = f->first_group[shape] = s->group_count;
    s->groups[s->group_count++] = made;
    f->open_groups--;
    return SNELL_OK;
}

/* The shapes of lights stand behind all others of the world. */
static void freeze_bodies(freezing *f, uint32_t index, uint64_t *count) {
    scene *s = f->s;
    for (uint32_t i = 0; i < s->body_count; i++, index++) {
        const light_shape *shape = &s->bodies[i].shape;
        s->instances[index] = (scene_instance){.type = shape->type,
                                               .shape = shape->desc,
                                               .shape_index = NO_ID,
                                               .material = s->material_count + 1 + i,
                                               .hidden_light = !shape->visible,
                                               .identity = true,
                                               .to_world = transform_identity(),
                                               .to_local = transform_identity(),
                                               .group = NO_ID,
                                               .first = (uint32_t)(*count)++};
        s->instances[index].shines = can_be_sampled(s, &s->instances[index]);
        s->instance_ids[index] = NO_ID;
        f->placed[index] =
            (accel_instance){.geometry = (uint32_t)f->d->objects[CATEGORY_SHAPE].count + i,
                             .mask = shape->visible ? MASK_LIGHT : MASK_LIGHT_HIDDEN,
                             .identity = true,
                             .to_world = transform_identity(),
                             .to_local = transform_identity()};
    }
}

/* Groups come after those in them. */
static bool find_takers(freezing *f) {
    const object_list *shapes = &f->d->objects[CATEGORY_SHAPE];
    f->takes_usual = memory_zeroed(shapes->count, sizeof *f->takes_usual);
    if (f->takes_usual == NULL) return false;
    for (size_t g = 0; g < shapes->count; g++)
        for (uint32_t i = f->lists.begin[g]; i < f->lists.begin[g + 1]; i++) {
            const instance *part = &f->d->instances[f->lists.parts[i]];
            if (part->material != NO_MATERIAL) continue;
            bool is_group = object_is_group(&shapes->items[part->shape]);
            f->takes_usual[g] |= !is_group || f->takes_usual[part->shape];
        }
    return true;
}

static snell_status freeze_world(freezing *f) {
    scene *s = f->s;
    const object_list *shapes = &f->d->objects[CATEGORY_SHAPE];
    f->first_group = memory_resize(NULL, shapes->count, sizeof *f->first_group);
    snell_status status = f->first_group ? part_lists_make(f->d, &f->lists) : error_no_memory();
    if (status) return status;
    uint32_t begin = f->lists.begin[shapes->count],
             count = f->lists.begin[shapes->count + 1] - begin;
    status = check_plan(f, count + s->body_count);
    if (!status && !find_takers(f)) status = error_no_memory();
    if (!status) status = freeze_motions(f);
    if (!status) status = prepare_shapes(f);
    if (!status) status = reserve_parts(f, count + s->body_count);
    if (status) return status;
    for (size_t i = 0; i < shapes->count; i++) f->first_group[i] = NO_ID;
    s->instance_count = s->part_count = count + s->body_count;
    uint64_t drawn = 0;
    uint32_t masks = 0;
    for (uint32_t i = 0; i < count && !status; i++)
        status = freeze_part(f, f->lists.parts[begin + i], (outside){NO_MATERIAL, NO_MATERIAL}, i,
                             &drawn, &masks);
    if (status) return status;
    if (drawn + s->body_count >= NO_ID)
        return error_set(SNELL_ERR_ARGUMENT, "draw fewer copies",
                         "the scene draws too many shapes");
    freeze_bodies(f, count, &drawn);
    s->shape_count = (uint32_t)drawn;
    return SNELL_OK;
}

static snell_status build_accel(const freezing *f, const accel_options *options,
                                thread_pool *pool) {
    scene *s = f->s;
    const object_list *shapes = &f->d->objects[CATEGORY_SHAPE];
    size_t groups = shapes->count + s->body_count;
    accel_geometry *geometries = memory_zeroed(groups + s->group_count, sizeof *geometries);
    if (geometries == NULL) return error_no_memory();
    snell_status status = SNELL_OK;
    for (uint32_t i = 0; i < shapes->count; i++) {
        geometries[i] = (accel_geometry){.type = type_of(f, i), .desc = shape_of(f, i)};
        if (s->solids->solids[i]) status = shape_for_rays(f, i, &geometries[i]); /* made before */
    }
    for (uint32_t i = 0; i < s->body_count; i++)
        geometries[shapes->count + i] =
            (accel_geometry){.type = s->bodies[i].shape.type, .desc = s->bodies[i].shape.desc};
    for (uint32_t i = 0; i < s->group_count; i++)
        geometries[groups + i] = (accel_geometry){.parts = f->placed + s->groups[i].first_part,
                                                  .part_count = s->groups[i].part_count};
    accel_input input = {geometries, groups + s->group_count, f->placed, s->instance_count};
    if (!status) status = accel_build(&input, options, pool, &s->accel);
    free(geometries);
    return status;
}

static snell_status prepare_solids(const freezing *f) {
    scene *s = f->s;
    snell_status status = solid_set_create(f->d->objects[CATEGORY_SHAPE].count, &s->solids);
    if (status) return status;
    s->solids->materials = s->materials;
    for (uint32_t i = 0; i < s->material_count; i++)
        s->solids->textured |= s->materials[i].textured;
    return SNELL_OK;
}

snell_status scene_freeze_geometry(scene *s, const description *d, const scene_options *options,
                                   thread_pool *pool) {
    freezing f = {.s = s, .d = d, .pool = pool, .memory_max = options->memory_max};
    snell_status status = plan_shapes(d, pool ? thread_pool_size(pool) : 1, &f.planned_shapes)
                              ? prepare_solids(&f)
                              : error_no_memory();
    if (!status) status = freeze_world(&f);
    if (!status) status = build_accel(&f, &options->accel, pool);
    if (!status) s->bounds = accel_bounds(s->accel);
    free(f.placed);
    free(f.motion_of);
    free(f.first_group);
    free(f.takes_usual);
    part_lists_free(&f.lists);
    return status ? status : scene_freeze_lights(s, &options->accel);
}
