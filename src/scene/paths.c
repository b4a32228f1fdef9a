/* From the number of a shape, counted as if all groups were flattened, to what it is and where. */
#include "scene/scene.h"

/* The last of `parts` whose first shape is not after `number`. */
static const scene_instance *find_in_level(const scene_instance *parts, uint32_t count,
                                           uint32_t number) {
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        uint32_t middle = low + (high - low + 1) / 2;
        if (parts[middle].first <= number)
            low = middle;
        else
            high = middle - 1;
    }
    return &parts[low];
}

/* The way down, with nothing posed; returns its length. */
static uint32_t find_levels(const scene *s, uint32_t number,
                            const scene_instance *levels[GROUP_DEPTH_MAX + 1]) {
    const scene_instance *parts = s->instances;
    uint32_t part_count = s->instance_count, depth = 0;
    for (;;) {
        const scene_instance *at = find_in_level(parts, part_count, number);
        levels[depth++] = at;
        if (at->group == NO_ID) return depth;
        const scene_group *group = &s->groups[at->group];
        number -= at->first;
        parts = s->instances + group->first_part;
        part_count = group->part_count;
    }
}

const scene_instance *scene_find_part(const scene *s, uint32_t number) {
    if (s->group_count == 0) return &s->instances[number];
    const scene_instance *levels[GROUP_DEPTH_MAX + 1];
    return levels[find_levels(s, number, levels) - 1];
}

void scene_find_path(const scene *s, uint32_t number, float time, shape_path *out) {
    out->count = find_levels(s, number, out->levels);
    for (uint32_t i = 0; i < out->count; i++) {
        const scene_instance *at = out->levels[i];
        out->to_world[i] = at->to_world;
        out->to_local[i] = at->to_local;
        if (at->moves) motion_at(at->moves, time, &out->to_world[i], &out->to_local[i]);
    }
}

local_ray shape_path_ray(const shape_path *path, const ray *r) {
    dvec3 o = dvec3_from(r->o), d = dvec3_from(r->d);
    for (uint32_t i = 0; i < path->count; i++) {
        if (path->levels[i]->identity) continue;
        o = transform_point(&path->to_local[i], o);
        d = transform_vector(&path->to_local[i], d);
    }
    return (local_ray){vec3_from(o), vec3_from(d), r->t_min, r->t_max};
}

/* Level by level. A shift in the parent's space is at most |to_local| (Frobenius) times as long here,
 * and what a curve then takes along n counts 1 / |N| there: so much more curved it is. */
void shape_path_surface(const shape_path *path, surface *on) {
    double own = on->curvature;
    for (uint32_t i = path->count; i-- > 0;) {
        if (path->levels[i]->identity) continue;
        const transform *to_local = &path->to_local[i];
        double norm_squared = 0, length = dvec3_length(transform_normal(to_local, on->n));
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++)
                norm_squared += (double)to_local->m[j][k] * (double)to_local->m[j][k];
        surface_to_world(on, &path->to_world[i], to_local);
        surface_tangents_to_world(on, &path->to_world[i]);
        if (length > 0) on->curvature *= norm_squared / length;
    }
    on->curvature = own;
}

bounds3 shape_path_bounds(const shape_path *path, bounds3 box) {
    for (uint32_t i = path->count; i-- > 0;) {
        const scene_instance *at = path->levels[i];
        if (at->moves)
            box = motion_bounds(at->moves, box);
        else if (!at->identity)
            box = transform_bounds(&at->to_world, box);
    }
    return box;
}

/* Matrices composed in double and rounded once: near enough for all but the rays themselves. */
static void compose(const shape_path *path, scene_instance *out) {
    dtransform to_world = dtransform_from(&path->to_world[0]),
               to_local = dtransform_from(&path->to_local[0]);
    *out = *path->levels[path->count - 1];
    out->similar = out->identity = true;
    out->moves = NULL;
    for (uint32_t i = 0; i < path->count; i++) {
        const scene_instance *at = path->levels[i];
        out->similar &= at->similar;
        out->identity &= at->identity;
        if (at->moves && !out->moves) out->moves = at->moves;
        if (i == 0) continue;
        dtransform down = dtransform_from(&path->to_local[i]),
                   up = dtransform_from(&path->to_world[i]);
        to_local = dtransform_multiply(&down, &to_local);
        to_world = dtransform_multiply(&to_world, &up);
    }
    out->to_world = dtransform_round(&to_world);
    out->to_local = dtransform_round(&to_local);
}

const scene_instance *scene_pose(const scene *s, uint32_t number, float time,
                                 posed_instance *room) {
    if (s->group_count) {
        shape_path path;
        scene_find_path(s, number, time, &path);
        const scene_instance *at = path.levels[0];
        if (path.count == 1 && !at->moves && at->type != &primitive_deforming) return at;
        compose(&path, &room->at);
    } else {
        const scene_instance *at = &s->instances[number];
        room->at = *at;
        if (at->moves) motion_at(at->moves, time, &room->at.to_world, &room->at.to_local);
    }
    room->at.shape = deforming_pose(room->at.type, room->at.shape, time, &room->shape);
    return &room->at;
}

transform scene_instance_transform(const scene *s, uint32_t number, float time) {
    posed_instance room;
    return scene_posed(s, number, time, &room)->to_world;
}

static snell_status each_part(const scene *s, uint32_t first, uint32_t count, uint32_t base,
                              bool (*is_wanted)(const scene_instance *part), scene_shape_fn *fn,
                              void *user) {
    snell_status status = SNELL_OK;
    for (uint32_t i = 0; i < count && !status; i++) {
        const scene_instance *at = &s->instances[first + i];
        if (!is_wanted(at)) continue;
        if (at->group == NO_ID) {
            status = fn(user, base + at->first, at);
        } else {
            const scene_group *group = &s->groups[at->group];
            status = each_part(s, group->first_part, group->part_count, base + at->first, is_wanted,
                               fn, user);
        }
    }
    return status;
}

snell_status scene_each_shape(const scene *s, bool (*is_wanted)(const scene_instance *part),
                              scene_shape_fn *fn, void *user) {
    return each_part(s, 0, s->instance_count, 0, is_wanted, fn, user);
}

/* The surface of a hit in the shape's own space, as it is at a time, whether or not a shutter is open: of what
 * deforms, the same place of the same triangle. */
static const scene_instance *local_surface(const scene *s, const ray *r, const hit *h, float time,
                                           surface *out) {
    shape_path path;
    deforming_mesh whole, room;
    scene_find_path(s, h->instance, r->time, &path);
    const scene_instance *at = path.levels[path.count - 1];
    local_ray beam = shape_path_ray(&path, r);
    const void *shape = at->shape;
    if (at->type == &primitive_deforming) {
        whole = deforming_whole(at->shape);
        shape = &whole;
    }
    at->type->surface(deforming_pose(at->type, shape, time, &room), &beam, h, out);
    return at;
}

void scene_hit_uv(const scene *s, const ray *r, const hit *h, double uv[2]) {
    surface on;
    const scene_instance *at = local_surface(s, r, h, r->time, &on);
    if (at->type->parametrise) at->type->parametrise(at->shape, &on);
    uv[0] = on.u;
    uv[1] = on.v;
}

dvec3 scene_hit_moved(const scene *s, const ray *r, const hit *h, float time) {
    surface on;
    shape_path path;
    local_surface(s, r, h, time, &on);
    scene_find_path(s, h->instance, time, &path);
    for (uint32_t i = path.count; i-- > 0;) {
        const motion *moves = path.levels[i]->motion;
        if (moves) path.to_world[i] = motion_by_keys(moves, time);
        if (moves || !path.levels[i]->identity) on.p = transform_point(&path.to_world[i], on.p);
    }
    return on.p;
}
