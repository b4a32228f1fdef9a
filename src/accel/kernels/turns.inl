/* Rays in turn: through one mesh; or, in `many`, through a world of many things, the tree over them and the meshes
 * among them. A ray waits most of its time: each step hangs on the one before, and on what memory gives. So TURNS
 * rays are under way at once, and what several of them wait for is done side by side, in straight code without a
 * branch: first the tests of all, then what follows from them. */

enum {
    TURNS = 32, /* 48 gain nothing more; with what they visit they fill a first-level cache */
    NODES = 4,  /* steps down, or blocks of triangles, side by side */
    BLOCKS = 4
};

typedef struct turn {
    _Alignas(64) prepared p;
    query q;
    shear sheared;
    float floor_t, start_t; /* start_t: of nodes, as in test_children */
    uint32_t next;          /* a reference */
    size_t index;           /* of the ray */
    walk_stack stack;
    /* Of `many`: the tree that it is in, whose ray is p; of which instance, NULL: the world; and the ray outside. */
    const bvh_tree *tree;
    const frozen_instance *in;
    prepared outer;
} turn;

/* On the stack between what is in a mesh and what is outside. */
#define STACK_RETURN 0xfffffffeu

/* Turns by what they do next; and how many. The lists have room for what is written beyond. Leaves: of
 * the world; and where a mesh is left. */
typedef struct queue {
    turn *nodes[TURNS + NODES], *blocks[TURNS + BLOCKS], *leaves[TURNS + 1], *ends[TURNS + 1];
} queue;

typedef struct queue_counts {
    uint32_t nodes, blocks, leaves, ends;
} queue_counts;

INLINE void enqueue(queue *to, queue_counts *n, turn *t, uint32_t next, const bool many) {
    uint32_t leaf = next >> 31, end = next == STACK_END;
    uint32_t outside = many ? (leaf - end) & (uint32_t)(t->in == NULL || next == STACK_RETURN) : 0;
    t->next = next;
    to->nodes[n->nodes] = to->blocks[n->blocks] = to->ends[n->ends] = t;
    n->nodes += 1 - leaf;
    n->blocks += leaf - end - outside;
    n->ends += end;
    if (many) {
        to->leaves[n->leaves] = t;
        n->leaves += outside;
    }
}

/* mesh: the one that there is, unless there are many things. */
INLINE void step_nodes(const bvh_tree *mesh, turn *const *turns, const uint32_t count, queue *to,
                       queue_counts *n, const bool many) {
    const bvh_node *node[NODES];
    f8 entry[NODES];
    m8 passed[NODES];
    unsigned nearest[NODES];
#pragma GCC unroll 4
    for (uint32_t i = 0; i < count; i++) {
        node[i] = &(many ? turns[i]->tree : mesh)->nodes[turns[i]->next];
        passed[i] = test_children(&turns[i]->p, node[i]->bounds, NULL, turns[i]->start_t,
                                  turns[i]->q.best_t, &entry[i]);
    }
#pragma GCC unroll 4
    for (uint32_t i = 0; i < count; i++) nearest[i] = f8_least(entry[i], passed[i]);
#pragma GCC unroll 4
    for (uint32_t i = 0; i < count; i++) {
        turn *t = turns[i];
        uint32_t next = push_children(&t->stack, node[i], entry[i], m8_bits(passed[i]), nearest[i]);
        if (many && m8_bits(passed[i]) != 0) { /* where it is entered, for what is in it */
            float entries[BVH_WIDTH];
            f8_store(entries, entry[i]);
            t->stack.entries[t->stack.count] = entries[nearest[i]];
        }
        enqueue(to, n, t, next, many);
    }
}

INLINE void step_blocks(const bvh_tree *mesh, turn *const *turns, const uint32_t count,
                        const bool any, queue *to, queue_counts *n, const bool many) {
    const triangle_block *block[BLOCKS];
    candidates found[BLOCKS];
    unsigned lanes[BLOCKS];
#pragma GCC unroll 4
    for (uint32_t i = 0; i < count; i++) {
        turn *t = turns[i];
        block[i] = &(many ? t->tree : mesh)->blocks[t->next & BVH_INDEX_MASK];
        lanes[i] = test_block(&t->q, &t->sheared, block[i], t->next, &found[i]);
    }
    for (uint32_t i = 0; i < count; i++) {
        turn *t = turns[i];
        float before = t->q.best_t;
        if (lanes[i] != 0) {
            if (accept_triangles(&t->q, &t->p, many ? t->tree : mesh, &t->sheared, block[i],
                                 &found[i], lanes[i], many ? t->in->first : 0, t->floor_t, any)) {
                t->q.best_instance = 0;
                start_stack(&t->stack);
            } else if (t->q.best_t < before)
                prune(&t->stack, t->q.best_t);
        }
        enqueue(to, n, t, pop(&t->stack), many);
    }
}

/* ---- a world of many things ---- */

/* Goes into the mesh, if that can be done in turn. */
INLINE bool enter_instance(turn *t, const frozen_instance *in, float floor_t) {
    if (in->mesh == NULL || !(in->mask & t->q.ray->mask)) return false;
    prepared local;
    dvec3 o, d;
    const prepared *p = place_ray(&t->q, &t->p, in, &local, &o, &d);
    if (p == NULL || !is_near(p, in->mesh)) return false;
    t->outer = t->p;
    if (p == &local) t->p = local;
    t->in = in;
    t->tree = in->mesh;
    t->floor_t = floor_t;
    t->start_t = start_of(&t->q, &t->p);
    make_shear(&t->sheared, &t->p);
    uint32_t i = t->stack.count++;
    t->stack.entries[i] = -INFINITY;
    t->stack.references[i] = STACK_RETURN;
    return true;
}

/* A sphere's turn comes together with others. */
INLINE bool is_sphere(const turn *t, const frozen_outline *of) {
    return of->sphere_mask & t->q.ray->mask;
}

/* What stands in a leaf of the world, and in those that follow; or a mesh is left. Returns what the ray does next; a
 * leaf of the world is a sphere. */
static __attribute__((noinline)) uint32_t visit_leaves(const batch *b, turn *t, const bool any) {
    const frozen_level *world = &b->a->world;
    uint32_t next = t->next;
    if (next == STACK_RETURN) {
        t->p = t->outer;
        t->start_t = t->p.t_min;
        t->in = NULL;
        t->tree = &world->top;
        next = pop(&t->stack);
    }
    for (; next & BVH_LEAF && next != STACK_END; next = pop(&t->stack)) {
        uint32_t index = next & ~BVH_LEAF;
        if (is_sphere(t, &world->outlines[index])) return next;
        float before = t->q.best_t;
        float floor_t = float_max(t->stack.entries[t->stack.count], t->p.t_min);
        if (enter_instance(t, &world->instances[index], floor_t)) return t->tree->root;
        if (visit_instance(&t->q, &t->p, world, index, floor_t, true, any)) {
            t->q.best_instance = 0;
            start_stack(&t->stack);
        } else if (t->q.best_t < before)
            prune(&t->stack, t->q.best_t);
    }
    return next;
}

/* In the world's own space, as all of these. */
INLINE void add_turn(sphere_pairs *s, turn *t, const frozen_outline *sphere) {
    s->of[s->count] = t;
    add_pair(s, sphere, t->q.ray, float_max(t->stack.entries[t->stack.count], t->p.t_min));
    t->q.counters.primitives++;
}

static __attribute__((noinline)) void step_spheres(const batch *b, sphere_pairs *s, const bool any,
                                                   queue *to, queue_counts *n) {
    unsigned lanes = meet_spheres(s);
    for (uint32_t i = 0; i < s->count; i++) {
        turn *t = s->of[i];
        uint32_t number = b->a->world.outlines[t->next & ~BVH_LEAF].first;
        if (lanes >> i & 1) {
            if (any) {
                t->q.best_instance = 0;
                start_stack(&t->stack);
            } else if (beats_best(&t->q, s->t[i], number, 0)) {
                take(&t->q, s->t[i], 0, 0, number, 0);
                prune(&t->stack, s->t[i]);
            }
        }
        enqueue(to, n, t, pop(&t->stack), true);
    }
    start_pairs(s);
}

INLINE void step_leaves(const batch *b, turn *const *turns, uint32_t count, const bool any,
                        queue *to, queue_counts *n) {
    sphere_pairs spheres;
    start_pairs(&spheres);
    for (uint32_t i = 0; i < count; i++) {
        turn *t = turns[i];
        uint32_t next = visit_leaves(b, t, any);
        if (next < STACK_RETURN && next & BVH_LEAF && t->in == NULL) {
            t->next = next;
            add_turn(&spheres, t, &b->a->world.outlines[next & ~BVH_LEAF]);
            if (spheres.count == PAIRS) step_spheres(b, &spheres, any, to, n);
        } else
            enqueue(to, n, t, next, true);
    }
    if (spheres.count > 0) step_spheres(b, &spheres, any, to, n);
}

/* ---- from ray to ray ---- */

INLINE void end_turn(batch *b, const query *q, size_t index, const bool any) {
    if (any)
        b->blocked[index] = q->best_instance != NO_ID;
    else
        b->hits[index] = found_hit(q);
}

/* Those that no beam took. */
INLINE void share_way(batch *b, const tile *t) {
    const bvh_tree *mesh = b->instance->mesh;
    uint64_t rays = b->left & t->plain;
    if (count_bits(rays) < SHARE_RAYS || mesh->root & BVH_LEAF) return;
    share_nodes(b->shared, t, mesh, rays);
    b->counters.nodes += b->shared->node_count;
}

/* Makes the next rays of the batch ready. */
INLINE void load_next(batch *b, const bool many) {
    size_t first = b->next, count = b->count - first < TILE ? b->count - first : TILE;
    b->next += count;
    load_tile(&b->tile, many ? NULL : b->instance, b->rays + first, count);
}

/* Those rays of the tile one by one; and the others of `done`, which meet nothing. */
INLINE void trace_alone(batch *b, uint64_t done, uint64_t rays, const bool any) {
    size_t first = (size_t)(b->tile.rays - b->rays);
    query q = {0};
    for (uint64_t rest = done | rays; rest != 0; rest &= rest - 1) {
        size_t index = first + (size_t)__builtin_ctzll(rest);
        start_query(&q, &b->rays[index]);
        if (rays & rest & -rest && trace_world(&q, b->a, &b->rays[index], any)) q.best_instance = 0;
        end_turn(b, &q, index, any);
    }
    add_counters(&b->counters, &q.counters);
}

/* The next tile, but for what turns are for. */
static __attribute__((noinline)) void next_tile(batch *b, const bool any, const bool many) {
    tile *t = &b->tile;
    load_next(b, many);
    trace_alone(b, t->all & ~t->enter, t->enter & t->far, any);
    uint64_t rays = many ? enter_world(b, any) : t->enter & ~t->far;
    b->left = trace_beams(b, t, rays, any, many);
    if (many) return;
    b->shared->rays = 0;
    if (any) share_way(b, t);
}

INLINE void make_sheared(shear *s, const tile *from, uint32_t i) {
    for (uint32_t axis = 0; axis < 3; axis++) {
        s->k[axis] = from->axes[i][axis];
        s->o[axis] = from->o[from->axes[i][axis]][i];
    }
    s->x = from->shear[0][i], s->y = from->shear[1][i], s->z = from->shear[2][i];
}

/* Gives the turn the next ray that may meet something. False: there is none. */
INLINE bool start_turn(batch *b, turn *t, const bool any, const bool many) {
    const tile *from = &b->tile;
    while (b->left == 0) {
        if (b->next == b->count) return false;
        next_tile(b, any, many);
    }
    uint32_t i = (uint32_t)__builtin_ctzll(b->left), octant = 0;
    b->left &= b->left - 1;
    t->index = (size_t)(&from->rays[i] - b->rays);
    f8_store(t->p.row, f8_load((const float *)&from->rays[i]));
    for (uint32_t axis = 0; axis < 3; axis++) {
        octant |= (uint32_t)(from->back[axis] >> i & 1) << axis;
        t->p.inv[axis] = from->inv[axis][i];
    }
    memcpy(t->p.offsets, plane_offsets[octant], sizeof plane_offsets[0]);
    start_stack(&t->stack);
    if (many) {
        load_bests(&t->q, b->outside, i);
        t->q.o = dvec3_from(from->rays[i].o), t->q.d = dvec3_from(from->rays[i].d);
        t->start_t = t->p.t_min;
        t->in = NULL;
        t->tree = &b->a->world.top;
        t->next = t->tree->root;
        return true;
    }
    start_query(&t->q, &from->rays[i]);
    t->next = b->instance->mesh->root;
    t->floor_t = from->floor_t[i];
    t->start_t = start_of(&t->q, &t->p);
    make_sheared(&t->sheared, from, i);
    if (b->shared->rays >> i & 1) {
        take_share(b->shared, i, &t->stack);
        t->next = pop(&t->stack);
    }
    return true;
}

INLINE void take_turns(batch *b, turn turns[TURNS], const bool any, const bool many) {
    const bvh_tree *mesh = many ? NULL : b->instance->mesh;
    queue queues[2], *now = &queues[0], *then = &queues[1];
    queue_counts n = {0};
    for (uint32_t i = 0; i < TURNS; i++) {
        turns[i].q = (query){0};
        if (start_turn(b, &turns[i], any, many)) enqueue(now, &n, &turns[i], turns[i].next, many);
    }
    while (n.nodes + n.blocks + n.leaves + n.ends > 0) {
        /* What is left over from the last four waits; unless there is nothing else. */
        bool last = n.nodes < NODES && n.blocks < BLOCKS && n.leaves == 0 && n.ends == 0;
        uint32_t nodes = last ? 0 : n.nodes % NODES, blocks = last ? 0 : n.blocks % BLOCKS;
        queue_counts left = {.nodes = nodes, .blocks = blocks};
        memcpy(then->nodes, now->nodes + (n.nodes - nodes), NODES * sizeof(turn *));
        memcpy(then->blocks, now->blocks + (n.blocks - blocks), BLOCKS * sizeof(turn *));
        b->counters.nodes += n.nodes - nodes;
        uint32_t i;
        for (i = 0; i < n.blocks - blocks; i++) /* while nodes are tested */
            fetch(many ? now->blocks[i]->tree : mesh, now->blocks[i]->next, false);
        for (i = 0; i + NODES <= n.nodes; i += NODES)
            step_nodes(mesh, now->nodes + i, NODES, then, &left, many);
        for (; i < n.nodes - nodes; i++) step_nodes(mesh, now->nodes + i, 1, then, &left, many);
        for (i = 0; i + BLOCKS <= n.blocks; i += BLOCKS)
            step_blocks(mesh, now->blocks + i, BLOCKS, any, then, &left, many);
        for (; i < n.blocks - blocks; i++)
            step_blocks(mesh, now->blocks + i, 1, any, then, &left, many);
        if (many) step_leaves(b, now->leaves, n.leaves, any, then, &left);
        for (i = 0; i < n.ends; i++) {
            turn *t = now->ends[i];
            end_turn(b, &t->q, t->index, any);
            if (start_turn(b, t, any, many)) enqueue(then, &left, t, t->next, many);
        }
        queue *swap = now;
        now = then, then = swap;
        n = left;
    }
    for (uint32_t i = 0; i < TURNS; i++) add_counters(&b->counters, &turns[i].q.counters);
}

static __attribute__((noinline)) void trace_turns(batch *b) {
    turn turns[TURNS];
    shares shared;
    b->shared = &shared;
    if (b->hits != NULL)
        take_turns(b, turns, false, false);
    else
        take_turns(b, turns, true, false);
}

static __attribute__((noinline)) void trace_many(batch *b) {
    turn turns[TURNS];
    beam outside;
    b->outside = &outside;
    if (b->hits != NULL)
        take_turns(b, turns, false, true);
    else
        take_turns(b, turns, true, true);
}

/* ---- a world of few things ---- */

INLINE void trace_tiles(batch *b, const bool any) {
    const tile *t = &b->tile;
    while (b->next < b->count) {
        load_next(b, true);
        trace_alone(b, t->all & ~t->enter, 0, any);
        beam k;
        take_tile(&k, t);
        meet_all(&k, &b->a->world, any);
        count_beam(b, &k);
        end_beam(b, &k, t->enter, any);
    }
}

static __attribute__((noinline)) void trace_small(batch *b) {
    if (b->hits != NULL)
        trace_tiles(b, false);
    else
        trace_tiles(b, true);
}
