/* One ray through everything there is. */

/* What a trace of one ray carries about. best_t starts as t_max, with no ids. */
typedef struct query {
    const ray *ray;
    dvec3 o, d;    /* the ray in the space of the level that is traced: the world, or a group */
    uint32_t base; /* number of that level's first shape */
    float best_t, best_u, best_v;
    uint32_t best_instance, best_primitive;
    trace_counters counters;
} query;

INLINE void start_query(query *q, const ray *r) {
    q->ray = r;
    q->best_t = r->t_max, q->best_u = 0, q->best_v = 0;
    q->best_instance = NO_ID, q->best_primitive = NO_ID;
}

INLINE hit found_hit(const query *q) {
    return (hit){q->best_instance == NO_ID ? INFINITY : q->best_t, q->best_u, q->best_v,
                 q->best_primitive, q->best_instance};
}

static void add_counters(trace_counters *to, const trace_counters *from) {
    to->nodes += from->nodes;
    to->boxes += BVH_WIDTH * from->nodes;
    to->triangles += from->triangles;
    to->primitives += from->primitives;
}

/* ---- accepting a hit ---- */

/* (t, instance, primitive) lexicographically after the hit that the ray walks on from. */
INLINE bool comes_after(const ray *r, float t, uint32_t instance, uint32_t primitive) {
    if (t != r->after_t) return t > r->after_t;
    if (instance != r->after_instance) return instance > r->after_instance;
    return primitive > r->after_primitive;
}

/* In a mesh, what the ray has left before this is behind it. */
INLINE float start_of(const query *q, const prepared *p) {
    return float_max(p->t_min, q->ray->after_t);
}

INLINE bool beats_best(const query *q, float t, uint32_t instance, uint32_t primitive) {
    if (t != q->best_t) return t < q->best_t;
    if (instance != q->best_instance) return instance < q->best_instance;
    return primitive < q->best_primitive;
}

INLINE void take(query *q, float t, float u, float v, uint32_t instance, uint32_t primitive) {
    q->best_t = t, q->best_u = u, q->best_v = v;
    q->best_instance = instance, q->best_primitive = primitive;
}

/* ---- meshes ---- */

/* Takes the nearest of the candidates in `lanes` that the hit rule accepts. True: `any` was asked and one was
 * found. floor_t: the entry of the instance's box. */
INLINE bool accept_triangles(query *q, const prepared *p, const bvh_tree *mesh, const shear *s,
                             const triangle_block *b, candidates *c, unsigned lanes,
                             uint32_t instance, float floor_t, const bool any) {
    float t[BVH_WIDTH], weight[2][BVH_WIDTH], det[BVH_WIDTH];
    f8_store(t, c->t);
    f8_store(weight[0], c->weight[0]);
    f8_store(weight[1], c->weight[1]);
    f8_store(det, c->det);
    unsigned in_double = lanes & c->in_double;
    if (in_double != 0) {
        for (; in_double != 0; in_double &= in_double - 1) {
            unsigned lane = (unsigned)__builtin_ctz(in_double);
            float solved[2];
            if (!solve_in_double(s, b, lane, &t[lane], solved)) lanes &= ~(1u << lane);
            weight[0][lane] = solved[0], weight[1][lane] = solved[1], det[lane] = 1;
        }
        c->t = f8_load(t);
    }
    f8 entry;
    lanes = test_own_boxes(p, mesh, b, start_of(q, p), lanes, &entry);
    f8 clamped = f8_max(f8_set(floor_t), f8_max(entry, c->t));
    m8 finite = f8_less_equal(f8_abs(c->t), f8_set(FLT_MAX));
    m8 inside = m8_and(f8_less(f8_set(p->t_min), clamped), f8_less(clamped, f8_set(p->t_max)));
    m8 nearer = f8_less_equal(clamped, f8_set(q->best_t));
    lanes &= m8_bits(m8_and(m8_and(finite, inside), nearer));
    if (lanes == 0) return false;
    f8_store(t, clamped);
    for (; lanes != 0; lanes &= lanes - 1) {
        int lane = __builtin_ctz(lanes);
        uint32_t primitive = b->primitive[lane];
        const ray *r = q->ray;
        if (instance == r->skip_instance && primitive == r->skip_primitive) continue;
        if (!comes_after(r, t[lane], instance, primitive)) continue;
        if (any) return true;
        if (!beats_best(q, t[lane], instance, primitive)) continue;
        take(q, t[lane], weight[0][lane] / det[lane], weight[1][lane] / det[lane], instance,
             primitive);
    }
    return false;
}

/* Lanes of the triangles in a block that may be met, nearer than what is. */
INLINE unsigned test_block(query *q, const shear *s, const triangle_block *b, uint32_t reference,
                           candidates *c) {
    uint32_t count = (reference >> BVH_COUNT_SHIFT & 7) + 1;
    q->counters.triangles += count;
    return test_triangles(s, b, q->best_t, c) & ((1u << count) - 1);
}

/* A mesh that deforms, at the ray's time: boxes and vertices are mixed from those of two keys, by the
 * formula of deforming_mix, which is monotone: the mixed boxes hold the mixed triangles. */
typedef struct moment {
    const bvh_node *nodes[2]; /* of the two keys */
    const triangle_block *blocks[2];
    f8 weight[2];
} moment;

INLINE moment find_moment(const bvh_tree *tree, const deforming_mesh *m, float time) {
    deforming_time at = deforming_find(m, time);
    const uint32_t keys[2] = {at.key, at.next};
    moment now;
    for (int i = 0; i < 2; i++) {
        now.nodes[i] = tree->nodes + keys[i] * tree->node_count;
        now.blocks[i] = tree->blocks + keys[i] * tree->block_count;
        now.weight[i] = f8_set(at.weight[i]);
    }
    return now;
}

INLINE f8 mix8(const moment *now, const float *a, const float *b) {
    return f8_add(f8_mul(now->weight[0], f8_load(a)), f8_mul(now->weight[1], f8_load(b)));
}

INLINE void mix_bounds(const moment *now, uint32_t index, float out[2][3][BVH_WIDTH]) {
    const bvh_node *a = &now->nodes[0][index], *b = &now->nodes[1][index];
    for (int side = 0; side < 2; side++)
        for (int axis = 0; axis < 3; axis++)
            f8_store(out[side][axis], mix8(now, a->bounds[side][axis], b->bounds[side][axis]));
}

INLINE void mix_block(const moment *now, uint32_t index, triangle_block *out) {
    const triangle_block *a = &now->blocks[0][index], *b = &now->blocks[1][index];
    for (int v = 0; v < 3; v++)
        for (int axis = 0; axis < 3; axis++)
            f8_store(out->vertex[v][axis], mix8(now, a->vertex[v][axis], b->vertex[v][axis]));
    memcpy(out->primitive, a->primitive, sizeof out->primitive);
}

/* now: NULL in a mesh that stays as it is. */
INLINE bool walk_mesh(query *q, const prepared *p, const bvh_tree *mesh, const moment *now,
                      uint32_t instance, float floor_t, const bool any) {
    float margin[3], start = start_of(q, p);
    bool wide = !is_near(p, mesh);
    if (wide) find_margin(p, mesh, margin);
    shear sheared;
    make_shear(&sheared, p);
    walk_stack stack;
    start_stack(&stack);
    uint32_t reference = mesh->root;
    do {
        if (reference & BVH_LEAF) {
            const triangle_block *block = &mesh->blocks[reference & BVH_INDEX_MASK];
            _Alignas(64) triangle_block mixed;
            if (now) {
                mix_block(now, reference & BVH_INDEX_MASK, &mixed);
                block = &mixed;
            }
            candidates found;
            unsigned lanes = test_block(q, &sheared, block, reference, &found);
            if (lanes != 0) {
                float before = q->best_t;
                if (accept_triangles(q, p, mesh, &sheared, block, &found, lanes, instance, floor_t,
                                     any))
                    return true;
                if (q->best_t < before) prune(&stack, q->best_t);
            }
            reference = pop(&stack);
        } else {
            const bvh_node *node = &mesh->nodes[reference];
            const float(*bounds)[3][BVH_WIDTH] = node->bounds;
            float mixed[2][3][BVH_WIDTH];
            if (now) {
                mix_bounds(now, reference, mixed);
                bounds = (const float(*)[3][BVH_WIDTH])mixed;
            }
            f8 entry;
            m8 passed = wide ? test_children(p, bounds, margin, start, q->best_t, &entry)
                             : test_children(p, bounds, NULL, start, q->best_t, &entry);
            q->counters.nodes++;
            reference =
                push_children(&stack, node, entry, m8_bits(passed), f8_least(entry, passed));
        }
    } while (reference != STACK_END);
    return false;
}

INLINE bool trace_deforming(query *q, const prepared *p, const frozen_instance *in, uint32_t number,
                            float floor_t, const bool any) {
    if (in->parts->block_count == 0) return false;
    const moment now = find_moment(in->parts, in->desc, q->ray->time);
    return walk_mesh(q, p, in->parts, &now, number, floor_t, any);
}

static __attribute__((noinline)) bool deforming_closest(query *q, const prepared *p,
                                                        const frozen_instance *in, uint32_t number,
                                                        float floor_t) {
    return trace_deforming(q, p, in, number, floor_t, false);
}

static __attribute__((noinline)) bool deforming_any(query *q, const prepared *p,
                                                    const frozen_instance *in, uint32_t number,
                                                    float floor_t) {
    return trace_deforming(q, p, in, number, floor_t, true);
}

/* ---- instances ---- */

/* A shape that tests itself, or a part of it. Its roots are asked for in turn until one comes after
 * the hit that the ray walks on from; without walking on that is the first. */
INLINE bool trace_analytic(query *q, const prepared *p, const frozen_instance *in, uint32_t index,
                           uint32_t part, float floor_t, const bool any) {
    const ray *r = q->ray;
    if (in->flat && index == r->skip_instance && part == r->skip_primitive) return false;
    q->counters.primitives++;
    local_ray local = {
        {p->o[0], p->o[1], p->o[2]}, {p->d[0], p->d[1], p->d[2]}, r->t_min, r->t_max};
    for (;;) {
        hit found = {.primitive = part};
        if (!in->type->intersect(in->desc, &local, &found)) return false;
        float t = float_max(floor_t, found.t);
        if (!(t > r->t_min && t < r->t_max)) return false;
        if (comes_after(r, t, index, found.primitive)) {
            if (any) return true;
            if (beats_best(q, t, index, found.primitive))
                take(q, t, found.u, found.v, index, found.primitive);
            return false;
        }
        if (!(found.t > local.t_min)) return false; /* a shape that broke its contract */
        local.t_min = found.t;
    }
}

/* Out of line: the mesh traversal exists once for each kind of question. */
static bool trace_closest(query *q, const prepared *outer, const frozen_instance *in, float floor_t,
                          bool bounded);
static bool trace_any(query *q, const prepared *outer, const frozen_instance *in, float floor_t,
                      bool bounded);

/* outer: the ray in the space of the level. floor_t: the largest entry of the boxes of this instance
 * and of the groups around it (t_min without one). */
INLINE bool visit_instance(query *q, const prepared *outer, const frozen_level *level,
                           uint32_t index, float floor_t, bool bounded, const bool any) {
    const frozen_instance *in = &level->instances[index];
    if (!(in->mask & q->ray->mask)) return false;
    if (in->plain) return trace_analytic(q, outer, in, q->base + in->first, 0, floor_t, any);
    return any ? trace_any(q, outer, in, floor_t, bounded)
               : trace_closest(q, outer, in, floor_t, bounded);
}

/* Through a tree with one thing in each leaf: an instance of the level; or, where `in` is not NULL, a
 * part of it, which has the number `number`. */
INLINE bool walk_tree(query *q, const prepared *p, const bvh_tree *tree, const frozen_level *level,
                      const frozen_instance *in, uint32_t number, float floor_t, const bool any) {
    if (tree->node_count == 0) return false;
    walk_stack stack;
    start_stack(&stack);
    uint32_t reference = tree->root;
    float entered = p->t_min, before = q->best_t;
    do {
        if (reference & BVH_LEAF) {
            uint32_t leaf = reference & ~BVH_LEAF;
            float low = float_max(entered, floor_t);
            if (in ? trace_analytic(q, p, in, number, leaf, low, any)
                   : visit_instance(q, p, level, leaf, low, true, any))
                return true;
            if (q->best_t < before) prune(&stack, before = q->best_t);
            reference = pop(&stack);
            entered = stack.entries[stack.count];
        } else {
            const bvh_node *node = &tree->nodes[reference];
            f8 entry;
            m8 passed = test_children(p, node->bounds, NULL, p->t_min, q->best_t, &entry);
            q->counters.nodes++;
            unsigned lanes = m8_bits(passed), nearest = f8_least(entry, passed);
            float entries[BVH_WIDTH];
            f8_store(entries, entry);
            reference = push_children(&stack, node, entry, lanes, nearest);
            entered = lanes != 0 ? entries[nearest] : stack.entries[stack.count];
        }
    } while (reference != STACK_END);
    return false;
}

static __attribute__((noinline)) bool trace_parts(query *q, const prepared *p,
                                                  const frozen_instance *in, uint32_t number,
                                                  float floor_t, const bool any) {
    if (in->type->intersect == NULL)
        return any ? deforming_any(q, p, in, number, floor_t)
                   : deforming_closest(q, p, in, number, floor_t);
    return walk_tree(q, p, in->parts, NULL, in, number, floor_t, any);
}

/* Groups nest GROUP_DEPTH_MAX deep, so this recurses no deeper. */
INLINE bool trace_level(query *q, const prepared *p, const frozen_level *level, float floor_t,
                        const bool any) {
    for (size_t i = 0; i < level->unbounded_count; i++)
        if (visit_instance(q, p, level, level->unbounded[i], floor_t, false, any)) return true;
    return walk_tree(q, p, &level->top, level, NULL, 0, floor_t, any);
}

static __attribute__((noinline)) bool group_closest(query *q, const prepared *p,
                                                    const frozen_level *group, float floor_t) {
    return trace_level(q, p, group, floor_t, false);
}

static __attribute__((noinline)) bool group_any(query *q, const prepared *p,
                                                const frozen_level *group, float floor_t) {
    return trace_level(q, p, group, floor_t, true);
}

/* p: the ray in the group's space, as o and d are, but in float. */
static bool trace_group(query *q, const prepared *p, const frozen_instance *in, dvec3 o, dvec3 d,
                        float floor_t, const bool any) {
    dvec3 outer_o = q->o, outer_d = q->d;
    uint32_t outer_base = q->base;
    q->o = o, q->d = d, q->base += in->first;
    bool found =
        any ? group_any(q, p, in->group, floor_t) : group_closest(q, p, in->group, floor_t);
    q->o = outer_o, q->d = outer_d, q->base = outer_base;
    return found;
}

/* The ray in the instance's own space, made ready in `local` unless it is the same as outside: o and d, too, become those
 * of that space. NULL: it hits nothing in there. */
INLINE const prepared *place_ray(const query *q, const prepared *outer, const frozen_instance *in,
                                 prepared *local, dvec3 *o, dvec3 *d) {
    *o = q->o, *d = q->d;
    if (in->identity) return outer;
    const transform *to_local = &in->to_local;
    transform moved, moved_inverse;
    if (in->moves) {
        if (!motion_at(in->moves, q->ray->time, &moved, &moved_inverse)) return NULL;
        to_local = &moved_inverse;
    }
    *o = transform_point(to_local, *o);
    *d = transform_vector(to_local, *d);
    bool sound = prepare_local(local, vec3_from(*o), vec3_from(*d), outer->t_min, outer->t_max);
    return sound ? local : NULL;
}

INLINE bool trace_instance(query *q, const prepared *outer, const frozen_instance *in,
                           float floor_t, bool bounded, const bool any) {
    prepared local;
    dvec3 o, d;
    const prepared *p = place_ray(q, outer, in, &local, &o, &d);
    if (p == NULL) return false;
    uint32_t number = q->base + in->first;
    if (in->mesh) return walk_mesh(q, p, in->mesh, NULL, number, floor_t, any);
    if (in->parts) return trace_parts(q, p, in, number, floor_t, any);
    if (in->group) return trace_group(q, p, in, o, d, floor_t, any);
    if (bounded && !in->identity) {
        float entry;
        if (!test_box(p, &in->bounds, &entry)) return false;
        floor_t = float_max(entry, floor_t);
    }
    return trace_analytic(q, p, in, number, 0, floor_t, any);
}

static __attribute__((noinline)) bool trace_closest(query *q, const prepared *outer,
                                                    const frozen_instance *in, float floor_t,
                                                    bool bounded) {
    return trace_instance(q, outer, in, floor_t, bounded, false);
}

static __attribute__((noinline)) bool
trace_any(query *q, const prepared *outer, const frozen_instance *in, float floor_t, bool bounded) {
    return trace_instance(q, outer, in, floor_t, bounded, true);
}

/* False: the ray hits nothing by definition; or, if `any` was asked, none was found. */
INLINE bool trace_world(query *q, const accel *a, const ray *r, const bool any) {
    prepared world;
    q->o = dvec3_from(r->o), q->d = dvec3_from(r->d);
    return prepare(&world, f8_load((const float *)r)) &&
           trace_level(q, &world, &a->world, r->t_min, any);
}
