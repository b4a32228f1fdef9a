/* Worlds of many things: what stands in the leaves of their trees, met by the rays of a beam or of a whole tile. */

/* Those that the mask lets see it. */
INLINE uint64_t seen_by(const tile *t, uint64_t rays, uint32_t mask) {
    if (mask & t->common_mask) return rays;
    if (!(mask & t->masks)) return 0;
    uint64_t seen = 0;
    for (uint64_t i = rays; i != 0; i &= i - 1)
        if (t->rays[__builtin_ctzll(i)].mask & mask) seen |= i & -i;
    return seen;
}

/* One ray after the other. floor_t: where each enters the box, if it is bounded. */
INLINE uint64_t meet_in_turn(beam *k, const frozen_level *world, uint32_t index,
                             const float floor_t[TILE], bool bounded, uint64_t rays,
                             const bool any) {
    uint64_t met = 0;
    query q = {0};
    for (; rays != 0; rays &= rays - 1) {
        uint32_t i = (uint32_t)__builtin_ctzll(rays);
        prepared p;
        load_bests(&q, k, i);
        q.o = dvec3_from(q.ray->o), q.d = dvec3_from(q.ray->d);
        if (!prepare_lane(&p, k->tile, i)) continue;
        bool found = visit_instance(&q, &p, world, index, floor_t[i], bounded, any);
        if (found || q.best_t < k->best_t[i]) met |= rays & -rays;
        if (!any) store_bests(k, &q, i);
    }
    add_counters(&k->alone, &q.counters);
    return met;
}

/* The ray has met something at t. Is it the nearest? Then it is noted. */
INLINE bool take_nearer(beam *k, uint32_t i, float t, float u, float v, uint32_t instance,
                        uint32_t primitive) {
    if (t > k->best_t[i]) return false;
    if (t == k->best_t[i] && !is_lower(instance, primitive, k, i)) return false;
    k->best_t[i] = t, k->best_u[i] = u, k->best_v[i] = v;
    k->instance[i] = instance, k->primitive[i] = primitive;
    return true;
}

/* A plain shape, as trace_analytic, and rays that do not walk on. */
INLINE uint64_t meet_plain(beam *k, const frozen_instance *in, const float floor_t[TILE],
                           uint64_t rays, const bool any) {
    const tile *t = k->tile;
    uint64_t met = 0;
    for (; rays != 0; rays &= rays - 1) {
        uint32_t i = (uint32_t)__builtin_ctzll(rays);
        const ray *r = &t->rays[i];
        if (in->flat && r->skip_instance == in->first && r->skip_primitive == 0) continue;
        local_ray local = {r->o, r->d, r->t_min, r->t_max};
        hit found = {.primitive = 0};
        k->counters.primitives++;
        if (!in->type->intersect(in->desc, &local, &found)) continue;
        float at = float_max(floor_t[i], found.t);
        if (!(at > r->t_min && at < r->t_max)) continue;
        if (any || take_nearer(k, i, at, found.u, found.v, in->first, found.primitive))
            met |= (uint64_t)1 << i;
    }
    return met;
}

/* Of a mesh in a place of its own: the rays that go the same way there, too, which have gone through it. */
INLINE uint64_t meet_placed_mesh(beam *k, const frozen_instance *in, const float floor_t[TILE],
                                 uint64_t rays, uint64_t *met, const bool any) {
    tile placed;
    place_tile(&placed, k->tile, in, rays);
    rays &= placed.enter & placed.plain & ~placed.far;
    if (rays == 0) return 0;
    uint32_t first = (uint32_t)__builtin_ctzll(rays);
    for (int i = 0; i < 3; i++) {
        rays &= placed.back[i] >> first & 1 ? placed.back[i] : ~placed.back[i];
        if (placed.dominated[i] >> first & 1) rays &= placed.dominated[i];
    }
    if (count_bits(rays) < BEAM_LEAST) return 0;
    beam inner;
    aim_beam(&inner, &placed, rays);
    inner.bests = k->bests;
    find_limit(&inner);
    choose_mesh(&inner, in, rays, floor_t);
    bool done = walk_beam(&inner, in->mesh, rays, NULL, any);
    for (uint64_t i = any ? 0 : rays; i != 0; i &= i - 1)
        if (inner.best_t[__builtin_ctzll(i)] < k->best_t[__builtin_ctzll(i)]) *met |= i & -i;
    *met |= inner.met;
    k->bests = inner.bests;
    k->counters.nodes += inner.counters.nodes;
    k->counters.triangles += inner.counters.triangles;
    k->visits += inner.visits;
    return done ? rays : inner.met;
}

/* Of a mesh that stands as it was given. */
INLINE uint64_t meet_mesh(beam *k, const frozen_instance *in, const float floor_t[TILE],
                          uint64_t rays, uint64_t *met, const bool any) {
    for (uint32_t at = 0; at < TILE; at += GROUP)
        if (LANES(rays, at) != 0) rays &= ~find_far(k->tile, in->mesh, at);
    if (count_bits(rays) < BEAM_LEAST) return 0;
    float before[TILE];
    memcpy(before, k->best_t, sizeof before);
    uint64_t met_before = k->met;
    choose_mesh(k, in, rays, floor_t);
    bool done = walk_beam(k, in->mesh, rays, NULL, any);
    for (uint64_t i = any ? 0 : rays; i != 0; i &= i - 1)
        if (k->best_t[__builtin_ctzll(i)] < before[__builtin_ctzll(i)]) *met |= i & -i;
    *met |= k->met & ~met_before;
    return done ? rays : k->met & ~met_before;
}

/* From so many rays of eight on, they are tested where they stand. */
enum { SPHERE_LEAST = 3 };

INLINE uint64_t take_spheres(beam *k, const frozen_outline *sphere, const uint8_t ray_of[PAIRS],
                             unsigned lanes, const float t[PAIRS], const bool any) {
    uint64_t met = 0;
    for (; lanes != 0; lanes &= lanes - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(lanes), i = ray_of[lane];
        if (any || take_nearer(k, i, t[lane], 0, 0, sphere->first, 0)) met |= (uint64_t)1 << i;
    }
    return met;
}

INLINE uint64_t meet_sphere(beam *k, const frozen_outline *sphere, const float floor_t[TILE],
                            uint64_t rays, const bool any) {
    const tile *t = k->tile;
    uint64_t met = 0;
    k->counters.primitives += count_bits(rays);
    for (uint32_t at = 0; at < TILE; at += PAIRS) {
        unsigned lanes = (unsigned)(rays >> at) & 0xff;
        if (count_bits(lanes) < SPHERE_LEAST) continue;
        float found[PAIRS];
        uint8_t ray_of[PAIRS];
        for (uint32_t i = 0; i < PAIRS; i++) ray_of[i] = (uint8_t)(at + i);
        unsigned hits = meet_one_sphere(t, at, sphere, floor_t, lanes, found);
        met |= take_spheres(k, sphere, ray_of, hits, found, any);
        rays &= ~((uint64_t)0xff << at);
    }
    while (rays != 0) {
        sphere_pairs s;
        uint8_t ray_of[PAIRS];
        start_pairs(&s);
        for (; rays != 0 && s.count < PAIRS; rays &= rays - 1) {
            uint32_t i = (uint32_t)__builtin_ctzll(rays);
            ray_of[s.count] = (uint8_t)i;
            add_pair(&s, sphere, &t->rays[i], floor_t[i]);
        }
        unsigned hits = meet_spheres(&s);
        met |= take_spheres(k, sphere, ray_of, hits, s.t, any);
    }
    return met;
}

INLINE uint64_t meet_instance(beam *k, const frozen_level *world, uint32_t index,
                              const float floor_t[TILE], bool bounded, uint64_t rays,
                              const bool any) {
    const frozen_instance *in = &world->instances[index];
    rays = seen_by(k->tile, rays, in->mask);
    if (world->outlines[index].sphere_mask)
        return meet_sphere(k, &world->outlines[index], floor_t, rays, any);
    uint64_t met = 0;
    if (in->plain) {
        met = meet_plain(k, in, floor_t, rays & ~k->tile->walks, any);
        rays &= k->tile->walks;
    }
    if (in->mesh && !in->moves && count_bits(rays) >= BEAM_LEAST)
        rays &= ~(in->identity ? meet_mesh(k, in, floor_t, rays, &met, any)
                               : meet_placed_mesh(k, in, floor_t, rays, &met, any));
    if (any) rays &= ~met;
    return met | meet_in_turn(k, world, index, floor_t, bounded, rays, any);
}

static __attribute__((noinline)) uint64_t meet_closest(beam *k, const frozen_level *world,
                                                       uint32_t index, const float floor_t[TILE],
                                                       bool bounded, uint64_t rays) {
    return meet_instance(k, world, index, floor_t, bounded, rays, false);
}

static __attribute__((noinline)) uint64_t meet_any(beam *k, const frozen_level *world,
                                                   uint32_t index, const float floor_t[TILE],
                                                   bool bounded, uint64_t rays) {
    return meet_instance(k, world, index, floor_t, bounded, rays, true);
}

INLINE void meet_unbounded(beam *k, const frozen_level *world, const bool any) {
    for (size_t i = 0; i < world->unbounded_count; i++)
        meet(k, world, world->unbounded[i], k->tile->t_min, false, k->alive, any);
}

/* All rays of a tile, whichever way they go. walk_beam cannot take them: aim_beam has not found what they share. */
INLINE void take_tile(beam *k, const tile *t) {
    k->tile = t;
    k->alive = t->enter;
    k->met = k->visits = 0;
    k->counters = k->alone = (trace_counters){0};
    start_bests(k);
}

INLINE uint64_t pass_bounds(const beam *k, const float low[3], const float high[3],
                            float entry[TILE]) {
    uint64_t passed = 0;
    for (uint32_t at = 0; at < TILE; at += GROUP) {
        f16 enter;
        passed |= (uint64_t)pass_box(k->tile, at, low, high, k->best_t, &enter) << at;
        f16_store(entry + at, enter);
    }
    return passed & k->alive;
}

/* Where the first of those rays enters. */
INLINE float first_entry(const float entry[TILE], uint64_t rays) {
    float least, unused;
    find_range(entry, rays, &least, &unused);
    return least;
}

/* Through a world that has at most one node: what is in it is asked in the order in which the first ray enters. */
INLINE void meet_all(beam *k, const frozen_level *world, const bool any) {
    meet_unbounded(k, world, any);
    if (world->top.node_count == 0) return;
    const bvh_node *node = &world->top.nodes[world->top.root];
    float entries[BVH_WIDTH][TILE], first[BVH_WIDTH];
    uint64_t passed[BVH_WIDTH];
    uint32_t order[BVH_WIDTH], count = 0;
    k->counters.nodes += count_bits(k->alive);
    for (uint32_t i = node->valid; i != 0; i &= i - 1) {
        uint32_t child = (uint32_t)__builtin_ctz(i), at;
        float low[3], high[3];
        for (int axis = 0; axis < 3; axis++)
            low[axis] = node->bounds[0][axis][child], high[axis] = node->bounds[1][axis][child];
        passed[child] = pass_bounds(k, low, high, entries[child]);
        if (passed[child] == 0) continue;
        first[child] = first_entry(entries[child], passed[child]);
        for (at = count++; at > 0 && first[order[at - 1]] > first[child]; at--)
            order[at] = order[at - 1];
        order[at] = child;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t child = order[i];
        uint64_t rays = passed[child] & k->alive;
        for (uint32_t at = 0; at < TILE && !any; at += GROUP) /* what they met is nearer */
            rays &= ~((uint64_t)f16_less(f16_load(k->best_t + at), f16_load(entries[child] + at))
                      << at);
        meet(k, world, node->child[child] & ~BVH_LEAF, entries[child], true, rays, any);
    }
}

INLINE void count_beam(batch *b, const beam *k) {
    add_counters(&b->counters, &k->counters);
    add_counters(&b->counters, &k->alone);
}

/* What those rays of it have met. */
INLINE void end_beam(batch *b, const beam *k, uint64_t rays, const bool any) {
    size_t first = (size_t)(k->tile->rays - b->rays);
    for (; rays != 0; rays &= rays - 1) {
        uint32_t i = (uint32_t)__builtin_ctzll(rays);
        if (any)
            b->blocked[first + i] = k->met >> i & 1;
        else
            b->hits[first + i] = k->instance[i] == NO_ID
                                     ? (hit){INFINITY, 0, 0, NO_ID, NO_ID}
                                     : (hit){k->best_t[i], k->best_u[i], k->best_v[i],
                                             k->primitive[i], k->instance[i]};
    }
}

/* What all rays of a tile ask first in a world of many things: what has no box, and the box about the others. Returns
 * those that are still to be traced. */
static __attribute__((noinline)) uint64_t enter_world(batch *b, const bool any) {
    const frozen_level *world = &b->a->world;
    const bounds3 *box = &world->top.bounds;
    const float low[3] = {box->min.x, box->min.y, box->min.z};
    const float high[3] = {box->max.x, box->max.y, box->max.z};
    float unused[TILE];
    beam *k = b->outside;
    take_tile(k, &b->tile);
    meet_unbounded(k, world, any);
    uint64_t left = world->top.node_count > 0 ? pass_bounds(k, low, high, unused) : 0;
    count_beam(b, k);
    end_beam(b, k, b->tile.enter & ~left, any);
    return left;
}

/* Traces the beams among `rays`: through the mesh, or of `many` through the world. Returns those that are still to be
 * traced. */
static __attribute__((noinline)) uint64_t trace_beams(batch *b, const tile *t, uint64_t rays,
                                                      const bool any, const bool many) {
    const frozen_level *world = &b->a->world;
    const bounds3 *box = many ? &world->top.bounds : &b->instance->mesh->bounds;
    float size = float_max(float_max(box->max.x - box->min.x, box->max.y - box->min.y),
                           box->max.z - box->min.z);
    uint64_t tried = rays & t->plain;
    b->beam_least =
        b->beam_least > BEAM_LEAST + LEAST_LESS ? b->beam_least - LEAST_LESS : BEAM_LEAST;
    for (int tries = 0; tries < 4 && count_bits(tried) >= b->beam_least; tries++) {
        uint64_t alike = find_beam(t, tried, size);
        uint32_t count = count_bits(alike);
        tried &= ~alike;
        if (count < b->beam_least) continue;
        beam k;
        aim_beam(&k, t, alike);
        bool done;
        if (many) {
            k.bests = b->outside->bests;
            find_limit(&k);
            done = walk_beam(&k, &world->top, alike, world, any);
        } else {
            start_bests(&k);
            choose_mesh(&k, b->instance, alike, t->floor_t);
            done = walk_beam(&k, b->instance->mesh, alike, NULL, any);
        }
        count_beam(b, &k);
        if (k.visits < full_of(count) * k.counters.nodes) b->beam_least = count + LEAST_MORE;
        if (!done) return rays;
        end_beam(b, &k, alike, any);
        rays &= ~alike;
    }
    return rays;
}
