/* Rays in turn through a mesh. A ray waits most of its time: each step hangs on the one before, and on
 * what memory gives. So TURNS rays are under way at once, and what several of them wait for is done side by
 * side, in straight code without a branch: first the tests of all, then what follows from them. */

enum {
    TURNS = 16, /* more do not fit into the first-level cache together with what they visit */
    NODES = 4,  /* steps down, or blocks of triangles, side by side */
    BLOCKS = 4
};

typedef struct turn {
    prepared p;
    query q;
    shear sheared;
    float floor_t;
    uint32_t next; /* a reference */
    size_t index;  /* of the ray */
    walk_stack stack;
} turn;

/* Turns by what they do next; and how many. The lists have room for what is written beyond. */
typedef struct queue {
    turn *nodes[TURNS + NODES], *blocks[TURNS + BLOCKS], *ends[TURNS + 1];
} queue;

typedef struct queue_counts {
    uint32_t nodes, blocks, ends;
} queue_counts;

/* All rays of a call. */
typedef struct batch {
    const accel *a;
    const frozen_instance *instance;
    const ray *rays;
    hit *hits;        /* of `any`: NULL */
    uint8_t *blocked; /* else: NULL */
    size_t next, count;
    trace_counters counters;
} batch;

INLINE void enqueue(queue *to, queue_counts *n, turn *t, uint32_t next) {
    uint32_t leaf = next >> 31, end = next == STACK_END;
    t->next = next;
    to->nodes[n->nodes] = to->blocks[n->blocks] = to->ends[n->ends] = t;
    n->nodes += 1 - leaf;
    n->blocks += leaf - end;
    n->ends += end;
}

INLINE void step_nodes(turn *const *turns, const bvh_tree *mesh, const uint32_t count, queue *to,
                       queue_counts *n) {
    const bvh_node *node[NODES];
    f8 entry[NODES];
    m8 passed[NODES];
    unsigned nearest[NODES];
#pragma GCC unroll 4
    for (uint32_t i = 0; i < count; i++) {
        node[i] = &mesh->nodes[turns[i]->next];
        passed[i] =
            test_children(&turns[i]->p, node[i]->bounds, NULL, turns[i]->q.best_t, &entry[i]);
    }
#pragma GCC unroll 4
    for (uint32_t i = 0; i < count; i++) nearest[i] = f8_least(entry[i], passed[i]);
#pragma GCC unroll 4
    for (uint32_t i = 0; i < count; i++)
        enqueue(to, n, turns[i],
                push_children(&turns[i]->stack, node[i], entry[i], m8_bits(passed[i]), nearest[i]));
}

INLINE void step_blocks(turn *const *turns, const bvh_tree *mesh, const uint32_t count,
                        const bool any, queue *to, queue_counts *n) {
    const triangle_block *block[BLOCKS];
    candidates found[BLOCKS];
    unsigned lanes[BLOCKS];
#pragma GCC unroll 4
    for (uint32_t i = 0; i < count; i++) {
        turn *t = turns[i];
        block[i] = &mesh->blocks[t->next & BVH_INDEX_MASK];
        lanes[i] = test_block(&t->q, &t->sheared, block[i], t->next, &found[i]);
    }
    for (uint32_t i = 0; i < count; i++) {
        turn *t = turns[i];
        float before = t->q.best_t;
        if (lanes[i] != 0) {
            if (accept_triangles(&t->q, &t->p, mesh, &t->sheared, block[i], &found[i], lanes[i], 0,
                                 t->floor_t, any)) {
                t->q.best_instance = 0;
                start_stack(&t->stack);
            } else if (t->q.best_t < before)
                prune(&t->stack, t->q.best_t);
        }
        enqueue(to, n, t, pop(&t->stack));
    }
}

INLINE void end_turn(batch *b, const query *q, size_t index, const bool any) {
    if (any)
        b->blocked[index] = q->best_instance != NO_ID;
    else
        b->hits[index] = found_hit(q);
}

/* Gives the turn the next ray that may meet the mesh. False: there is none. */
INLINE bool start_turn(batch *b, turn *t, const bool any) {
    const frozen_instance *in = b->instance;
    while (b->next < b->count) {
        size_t index = b->next++;
        const ray *r = &b->rays[index];
        float entry;
        start_query(&t->q, r);
        if ((in->mask & r->mask) && prepare(&t->p, f8_load((const float *)r)) &&
            test_box(&t->p, &in->bounds, &entry)) {
            if (is_near(&t->p, in->mesh)) {
                t->index = index;
                t->floor_t = float_max(entry, r->t_min);
                t->next = in->mesh->root;
                make_shear(&t->sheared, &t->p);
                start_stack(&t->stack);
                return true;
            }
            if (trace_world(&t->q, b->a, r, any)) t->q.best_instance = 0;
        }
        end_turn(b, &t->q, index, any);
    }
    return false;
}

INLINE void take_turns(batch *b, turn turns[TURNS], const bool any) {
    const bvh_tree *mesh = b->instance->mesh;
    queue queues[2], *now = &queues[0], *then = &queues[1];
    queue_counts n = {0, 0, 0};
    for (uint32_t i = 0; i < TURNS; i++) {
        turns[i].q = (query){0};
        if (start_turn(b, &turns[i], any)) enqueue(now, &n, &turns[i], turns[i].next);
    }
    while (n.nodes + n.blocks + n.ends > 0) {
        /* What is left over from the last four waits; unless there is nothing else. */
        bool last = n.nodes < NODES && n.blocks < BLOCKS && n.ends == 0;
        uint32_t nodes = last ? 0 : n.nodes % NODES, blocks = last ? 0 : n.blocks % BLOCKS;
        queue_counts left = {nodes, blocks, 0};
        memcpy(then->nodes, now->nodes + (n.nodes - nodes), NODES * sizeof(turn *));
        memcpy(then->blocks, now->blocks + (n.blocks - blocks), BLOCKS * sizeof(turn *));
        b->counters.nodes += n.nodes - nodes;
        uint32_t i;
        for (i = 0; i + NODES <= n.nodes; i += NODES)
            step_nodes(now->nodes + i, mesh, NODES, then, &left);
        for (; i < n.nodes - nodes; i++) step_nodes(now->nodes + i, mesh, 1, then, &left);
        for (i = 0; i + BLOCKS <= n.blocks; i += BLOCKS)
            step_blocks(now->blocks + i, mesh, BLOCKS, any, then, &left);
        for (; i < n.blocks - blocks; i++) step_blocks(now->blocks + i, mesh, 1, any, then, &left);
        for (i = 0; i < n.ends; i++) {
            turn *t = now->ends[i];
            end_turn(b, &t->q, t->index, any);
            if (start_turn(b, t, any)) enqueue(then, &left, t, t->next);
        }
        queue *swap = now;
        now = then, then = swap;
        n = left;
    }
    for (uint32_t i = 0; i < TURNS; i++) add_counters(&b->counters, &turns[i].q.counters);
}

/* Nothing but a mesh that stands as it was given. */
INLINE bool is_one_mesh(const accel *a) {
    const frozen_level *world = &a->world;
    return world->instance_count == 1 && world->instances[0].mesh != NULL &&
           world->instances[0].identity;
}

static __attribute__((noinline)) void trace_turns(batch *b) {
    turn turns[TURNS];
    if (b->hits != NULL)
        take_turns(b, turns, false);
    else
        take_turns(b, turns, true);
}
