/* The way down that rays of a tile share, whatever way they go, if any hit will do: those that start near one another
 * pass the same nodes about where they start. Such a node is tested for all of them at once, by the operations that
 * one ray alone goes through. What is left of the tree then waits for each ray's turn. (Where the nearest hit is
 * asked for, it does not pay: a ray alone meets it before most of what would wait.) */

enum {
    SHARE_RAYS = 24,  /* fewer in a tile are not worth it */
    SHARE_LEAST = 24, /* with fewer rays a node waits */
    SHARE_NODES = 16,
    SHARE_MOST = SHARE_NODES * (BVH_WIDTH - 1) + 1
};
/* Relative to origin and segment: more than slab tests are off by, and BOX_EXIT_SCALE. */
#define SEGMENT_MARGIN 0x1p-16f

/* Of each ray, what waits. Lists have room for what is copied beyond. */
typedef struct shares {
    uint64_t rays; /* that share */
    uint32_t node_count;
    uint32_t count[TILE];
    uint32_t references[TILE][SHARE_MOST + BVH_WIDTH];
} shares;

/* Boxes around where those rays start, at t_min, and around all their segments; and some more. */
typedef struct segments {
    float start[2][3], all[2][3]; /* low and high */
} segments;

INLINE void bound_segments(segments *s, const tile *t, uint64_t rays) {
    const f16 margin = f16_set(SEGMENT_MARGIN);
    for (int i = 0; i < 3; i++) {
        f16 low[2], high[2];
        for (int end = 0; end < 2; end++) {
            low[end] = f16_set(INFINITY), high[end] = f16_set(-INFINITY);
            for (uint32_t at = 0; at < TILE; at += GROUP) {
                uint32_t lanes = LANES(rays, at);
                f16 o = f16_load(t->o[i] + at), d = f16_load(t->d[i] + at);
                f16 way = f16_mul(f16_load((end ? t->t_max : t->t_min) + at), d);
                f16 off = f16_mul(f16_add(f16_abs(o), f16_abs(way)), margin), p = f16_add(o, way);
                low[end] = f16_min(f16_blend(lanes, low[end], f16_sub(p, off)), low[end]);
                high[end] = f16_max(f16_blend(lanes, high[end], f16_add(p, off)), high[end]);
            }
        }
        s->start[0][i] = f16_least(low[0]), s->start[1][i] = f16_most(high[0]);
        s->all[0][i] = f16_least(f16_min(low[0], low[1]));
        s->all[1][i] = f16_most(f16_max(high[0], high[1]));
    }
}

/* Children whose boxes some segment may meet; and those in which all rays start. */
INLINE unsigned find_children(const segments *s, const bvh_node *node, unsigned *around) {
    unsigned met = node->valid;
    *around = node->valid;
    for (int i = 0; i < 3; i++) {
        f8 low = f8_load(node->bounds[0][i]), high = f8_load(node->bounds[1][i]);
        met &= m8_bits(m8_and(f8_less_equal(low, f8_set(s->all[1][i])),
                              f8_less_equal(f8_set(s->all[0][i]), high)));
        *around &= m8_bits(m8_and(f8_less_equal(low, f8_set(s->start[0][i])),
                                  f8_less_equal(f8_set(s->start[1][i]), high)));
    }
    return met;
}

/* Those of the rays that pass the box of a child. */
INLINE uint64_t share_child(const tile *t, const bvh_node *node, unsigned child, uint64_t rays) {
    uint64_t passed = 0;
    for (uint32_t at = 0; at < TILE; at += GROUP) {
        if (LANES(rays, at) == 0) continue;
        f16 low = f16_load(t->t_min + at), high = f16_set(INFINITY);
        for (int i = 0; i < 3; i++) {
            f16 o = f16_load(t->o[i] + at), inv = f16_load(t->inv[i] + at);
            f16 a = f16_mul(f16_sub(f16_set(node->bounds[0][i][child]), o), inv);
            f16 b = f16_mul(f16_sub(f16_set(node->bounds[1][i][child]), o), inv);
            low = f16_max(f16_min(a, b), low);
            high = f16_min(f16_max(a, b), high);
        }
        passed |= (uint64_t)f16_less_equal(
                      low, f16_min(f16_load(t->t_max + at), f16_mul(high, f16_set(BOX_EXIT_SCALE))))
                  << at;
    }
    return passed & rays;
}

/* Those rays of a tile, all plain, into a tree whose root is a node. */
static __attribute__((noinline)) void share_nodes(shares *s, const tile *t, const bvh_tree *tree,
                                                  uint64_t rays) {
    uint32_t nodes[SHARE_NODES], count = 1;
    uint64_t through[SHARE_NODES];
    segments ways;
    s->rays = rays;
    memset(s->count, 0, sizeof s->count);
    bound_segments(&ways, t, rays);
    nodes[0] = tree->root;
    through[0] = rays;
    for (s->node_count = 0; s->node_count < count; s->node_count++) {
        const bvh_node *node = &tree->nodes[nodes[s->node_count]];
        unsigned around, met = find_children(&ways, node, &around);
        for (; met != 0; met &= met - 1) {
            unsigned child = (unsigned)__builtin_ctz(met);
            uint32_t reference = node->child[child];
            uint64_t passed = through[s->node_count];
            if (!(around >> child & 1)) passed = share_child(t, node, child, passed);
            if (!(reference & BVH_LEAF) && count_bits(passed) >= SHARE_LEAST &&
                count < SHARE_NODES) {
                nodes[count] = reference;
                through[count++] = passed;
                continue;
            }
            for (; passed != 0; passed &= passed - 1) {
                uint32_t i = (uint32_t)__builtin_ctzll(passed);
                s->references[i][s->count[i]++] = reference;
            }
        }
    }
}

/* What waits for ray i, onto its stack. */
INLINE void take_share(const shares *s, uint32_t i, walk_stack *stack) {
    for (uint32_t k = 0; k < s->count[i]; k += BVH_WIDTH)
        memcpy(stack->references + 1 + k, s->references[i] + k, BVH_WIDTH * sizeof(uint32_t));
    stack->count += s->count[i];
}
