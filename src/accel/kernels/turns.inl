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

/* Makes the next rays of the batch ready, and traces those that need no turn. */
static __attribute__((noinline)) void next_tile(batch *b, const bool any) {
    tile *t = &b->tile;
    size_t first = b->next, count = b->count - first < TILE ? b->count - first : TILE;
    b->next += count;
    load_tile(t, b->instance, b->rays + first, count);
    query q = {0};
    for (uint64_t rest = t->all & (~t->enter | t->far); rest != 0; rest &= rest - 1) {
        size_t index = first + (size_t)__builtin_ctzll(rest);
        start_query(&q, &b->rays[index]);
        if (t->enter & rest & -rest && trace_world(&q, b->a, &b->rays[index], any))
            q.best_instance = 0;
        end_turn(b, &q, index, any);
    }
    add_counters(&b->counters, &q.counters);
    b->left = trace_beams(b, t, t->enter & ~t->far, any);
}

/* Gives the turn the next ray that may meet the mesh. False: there is none. */
INLINE bool start_turn(batch *b, turn *t, const bool any) {
    while (b->left == 0) {
        if (b->next == b->count) return false;
        next_tile(b, any);
    }
    const tile *from = &b->tile;
    uint32_t i = (uint32_t)__builtin_ctzll(b->left);
    b->left &= b->left - 1;
    start_query(&t->q, &from->rays[i]);
    t->index = (size_t)(&from->rays[i] - b->rays);
    t->next = b->instance->mesh->root;
    t->floor_t = from->floor_t[i];
    f8_store(t->p.row, f8_load((const float *)&from->rays[i]));
    uint32_t octant = 0;
    for (uint32_t axis = 0; axis < 3; axis++) {
        octant |= (uint32_t)(from->back[axis] >> i & 1) << axis;
        t->p.inv[axis] = from->inv[axis][i];
        t->sheared.k[axis] = from->axes[i][axis];
        t->sheared.o[axis] = from->o[from->axes[i][axis]][i];
    }
    t->sheared.x = from->shear[0][i], t->sheared.y = from->shear[1][i];
    t->sheared.z = from->shear[2][i];
    memcpy(t->p.offsets, plane_offsets[octant], sizeof plane_offsets[0]);
    start_stack(&t->stack);
    return true;
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

static __attribute__((noinline)) void trace_turns(batch *b) {
    turn turns[TURNS];
    if (b->hits != NULL)
        take_turns(b, turns, false);
    else
        take_turns(b, turns, true);
}
