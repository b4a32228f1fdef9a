/* Beams: rays of a tile that go nearly the same way, together through a tree. A node is tested for all of them
 * at once, by intervals: the least that any ray's entry may be, and the greatest that any exit may be. What
 * passes is then tested ray by ray, by the operations that one ray alone goes through: so the hits are the
 * same. */

enum {
    BEAM_LEAST = 6,   /* fewer rays are faster in turn */
    FILTER_MOST = 10, /* more rays of a group are tested at once, triangle by triangle */
    /* A beam pays if at a node at least BEAM_FULL of its rays are left, in the mean, and a quarter. If it did not,
     * the next must have LEAST_MORE rays more than it had; from tile to tile LEAST_LESS fewer will do. A
     * beam that has not two thirds of that after THIN_AFTER nodes is given up. */
    BEAM_FULL = 5,
    THIN_AFTER = 32,
    LEAST_MORE = 28,
    LEAST_LESS = 4
};
/* How much rays may differ: in direction, over the largest component; in origin, over the mesh's size. */
#define BEAM_TURN 0.2f
#define BEAM_SHIFT 0.1f

typedef struct bests {
    float best_t[TILE], best_u[TILE], best_v[TILE];
    uint32_t instance[TILE], primitive[TILE];
} bests;

typedef struct beam {
    const tile *tile;
    union {
        bests bests;
        struct {
            float best_t[TILE], best_u[TILE], best_v[TILE];
            uint32_t instance[TILE], primitive[TILE];
        };
    };
    /* Of the mesh that they go through: its number, where each ray enters it, and the triangle that it leaves. */
    uint32_t number;
    const float *floor_t;
    uint32_t skip[TILE];
    uint64_t alive; /* rays that may still meet something; of `any`: that have met nothing */
    uint64_t met;   /* of `any` */
    uint32_t near[3], far[3], axes[3];
    float limit; /* the greatest best_t */
    /* Which origin makes the entry the least and the exit the greatest, .. */
    float least_t, entry_o[3], exit_o[3], inv_low[3], inv_high[3];
    trace_counters counters, alone; /* alone: of rays that asked something one by one */
    uint64_t visits;                /* of nodes, by each ray */
} beam;

/* Of all groups, lanes in which |a - a[first]| <= most. */
INLINE uint64_t find_near(const float a[TILE], uint32_t first, float most) {
    uint64_t near = 0;
    for (uint32_t at = 0; at < TILE; at += GROUP)
        near |= (uint64_t)f16_less_equal(f16_abs(f16_sub(f16_load(a + at), f16_set(a[first]))),
                                         f16_set(most))
                << at;
    return near;
}

/* The least and the greatest of those rays. */
INLINE void find_range(const float a[TILE], uint64_t rays, float *least, float *most) {
    f16 low = f16_set(INFINITY), high = f16_set(-INFINITY);
    for (uint32_t at = 0; at < TILE; at += GROUP) {
        f16 value = f16_load(a + at);
        low = f16_min(low, f16_blend(LANES(rays, at), f16_set(INFINITY), value));
        high = f16_max(high, f16_blend(LANES(rays, at), f16_set(-INFINITY), value));
    }
    *least = f16_least(low);
    *most = f16_most(high);
}

INLINE void find_limit(beam *k) {
    f16 most = f16_set(-INFINITY);
    for (uint32_t at = 0; at < TILE; at += GROUP)
        most = f16_max(
            most, f16_blend(LANES(k->alive, at), f16_set(-INFINITY), f16_load(k->best_t + at)));
    k->limit = f16_most(most);
}

/* Those that go as the first of `rays` does. */
INLINE uint64_t find_beam(const tile *t, uint64_t rays, float size) {
    uint32_t first = (uint32_t)__builtin_ctzll(rays);
    for (int i = 0; i < 3; i++) {
        rays &= t->back[i] >> first & 1 ? t->back[i] : ~t->back[i];
        if (t->dominated[i] >> first & 1) rays &= t->dominated[i];
    }
    if (count_bits(rays) < BEAM_LEAST) return rays;
    for (int i = 0; i < 3; i++) rays &= find_near(t->o[i], first, BEAM_SHIFT * size);
    for (int i = 0; i < 2; i++) rays &= find_near(t->shear[i], first, BEAM_TURN);
    return rays;
}

/* The intervals of those rays, all of the same signs and with the same largest component. */
INLINE void aim_beam(beam *k, const tile *t, uint64_t rays) {
    uint32_t first = (uint32_t)__builtin_ctzll(rays), octant = 0;
    for (uint32_t i = 0; i < 3; i++) octant |= (uint32_t)(t->back[i] >> first & 1) << i;
    k->tile = t;
    k->alive = rays;
    k->met = k->visits = 0;
    k->counters = k->alone = (trace_counters){0};
    memcpy(k->near, plane_offsets[octant], sizeof k->near);
    memcpy(k->far, plane_offsets[octant] + 4, sizeof k->far);
    float unused;
    find_range(t->t_min, rays, &k->least_t, &unused);
    for (int i = 0; i < 3; i++) {
        float low, high;
        k->axes[i] = t->axes[first][i];
        find_range(t->o[i], rays, &low, &high);
        find_range(t->inv[i], rays, &k->inv_low[i], &k->inv_high[i]);
        bool back = octant >> i & 1;
        k->entry_o[i] = back ? low : high;
        k->exit_o[i] = back ? high : low;
    }
}

INLINE void start_bests(beam *k) {
    for (uint32_t at = 0; at < TILE; at += GROUP) {
        f16_store(k->best_t + at, f16_load(k->tile->t_max + at));
        f16_store(k->best_u + at, f16_set(0));
        f16_store(k->best_v + at, f16_set(0));
    }
    memset(k->instance, 0xff, sizeof k->instance); /* NO_ID */
    memset(k->primitive, 0xff, sizeof k->primitive);
    find_limit(k);
}

/* The mesh that rays go through from now on. */
INLINE void choose_mesh(beam *k, const frozen_instance *in, uint64_t rays, const float *floor_t) {
    k->number = in->first;
    k->floor_t = floor_t;
    memset(k->skip, 0xff, sizeof k->skip);
    for (; rays != 0; rays &= rays - 1) {
        uint32_t i = (uint32_t)__builtin_ctzll(rays);
        const ray *r = &k->tile->rays[i];
        if (r->skip_instance == in->first) k->skip[i] = r->skip_primitive;
    }
}

/* ---- boxes ---- */

/* Lanes of the group that pass the box of a child, nearer than what they have, and where; its planes stand from
 * `planes` on as in a node. */
INLINE uint32_t cross_box(const beam *k, uint32_t at, const char *planes, f16 *entry) {
    const tile *t = k->tile;
    f16 low = f16_load(t->t_min + at), high = f16_set(INFINITY);
    for (int i = 0; i < 3; i++) {
        float near, far;
        memcpy(&near, planes + k->near[i], sizeof near);
        memcpy(&far, planes + k->far[i], sizeof far);
        f16 o = f16_load(t->o[i] + at), inv = f16_load(t->inv[i] + at);
        low = f16_max(f16_mul(f16_sub(f16_set(near), o), inv), low);
        high = f16_min(f16_mul(f16_sub(f16_set(far), o), inv), high);
    }
    *entry = low;
    return f16_less_equal(
        low, f16_min(f16_load(k->best_t + at), f16_mul(high, f16_set(BOX_EXIT_SCALE))));
}

INLINE uint64_t cross_child(const beam *k, const bvh_node *node, unsigned child, uint64_t rays) {
    const char *planes = (const char *)&node->bounds[0][0][child];
    uint64_t passed = 0;
    f16 entry;
    for (uint32_t at = 0; at < TILE; at += GROUP)
        if (LANES(rays, at)) passed |= (uint64_t)cross_box(k, at, planes, &entry) << at;
    return passed & rays;
}

/* Boxes that any ray may pass, and where none enters them before. */
INLINE m8 test_boxes(const beam *k, const f8 low[3], const f8 high[3], f8 *entry) {
    f8 enter = f8_set(k->least_t), leave = f8_set(INFINITY);
    for (int i = 0; i < 3; i++) {
        f8 inv_low = f8_set(k->inv_low[i]), inv_high = f8_set(k->inv_high[i]);
        f8 in = f8_sub(f8_select(inv_low, low[i], high[i]), f8_set(k->entry_o[i]));
        f8 out = f8_sub(f8_select(inv_low, high[i], low[i]), f8_set(k->exit_o[i]));
        enter = f8_max(f8_min(f8_mul(in, inv_low), f8_mul(in, inv_high)), enter);
        leave = f8_min(f8_max(f8_mul(out, inv_low), f8_mul(out, inv_high)), leave);
    }
    *entry = enter;
    return f8_less_equal(enter, f8_min(f8_mul(leave, f8_set(BOX_EXIT_SCALE)), f8_set(k->limit)));
}

INLINE m8 test_node(const beam *k, const bvh_node *node, f8 *entry) {
    f8 low[3], high[3];
    for (int i = 0; i < 3; i++)
        low[i] = f8_load(node->bounds[0][i]), high[i] = f8_load(node->bounds[1][i]);
    return test_boxes(k, low, high, entry);
}

/* Triangles whose boxes, made wider than by any ray's margin, some ray may pass. */
INLINE unsigned test_block_boxes(const beam *k, const bvh_tree *mesh, const triangle_block *b) {
    f8 low[3], high[3], entry, margin = f8_set(2 * mesh->margin);
    for (int i = 0; i < 3; i++) {
        f8 v0 = f8_load(b->vertex[0][i]), v1 = f8_load(b->vertex[1][i]),
           v2 = f8_load(b->vertex[2][i]);
        low[i] = f8_sub(f8_min(f8_min(v0, v1), v2), margin);
        high[i] = f8_add(f8_max(f8_max(v0, v1), v2), margin);
    }
    return m8_bits(test_boxes(k, low, high, &entry));
}

/* ---- triangles ---- */

/* Sheared vertices and edge functions of sixteen pairs of a triangle and a ray, as in test_triangles.
 * Returns the pairs whose lines pass beside. */
typedef struct edges {
    f16 z[3], u, v, w;
} edges;

INLINE uint32_t find_edges(f16 vertex[3][3], f16 o[3], f16 shear_x, f16 shear_y, edges *e) {
    f16 x[3], y[3];
    for (int i = 0; i < 3; i++) {
        e->z[i] = f16_sub(vertex[i][2], o[2]);
        x[i] = f16_sub(f16_sub(vertex[i][0], o[0]), f16_mul(shear_x, e->z[i]));
        y[i] = f16_sub(f16_sub(vertex[i][1], o[1]), f16_mul(shear_y, e->z[i]));
    }
    e->u = f16_sub(f16_mul(x[2], y[1]), f16_mul(y[2], x[1]));
    e->v = f16_sub(f16_mul(x[0], y[2]), f16_mul(y[0], x[2]));
    e->w = f16_sub(f16_mul(x[1], y[0]), f16_mul(y[1], x[0]));
    const f16 zero = f16_set(0);
    return f16_less(f16_min(f16_min(e->u, e->v), e->w), zero) &
           f16_less(zero, f16_max(f16_max(e->u, e->v), e->w));
}

/* Of each triangle, the lanes of the group that do not pass beside, by two rays at a time. */
INLINE void filter_rays(const beam *k, const triangle_block *b, uint32_t at, uint32_t lanes,
                        uint32_t masks[BVH_WIDTH]) {
    const tile *t = k->tile;
    uint8_t triangles[GROUP] = {0};
    f16 vertex[3][3];
    for (int a = 0; a < 3; a++)
        for (int v = 0; v < 3; v++) vertex[v][a] = f16_twice(b->vertex[v][k->axes[a]]);
    while (lanes != 0) {
        uint32_t rest = lanes & (lanes - 1), i = (uint32_t)__builtin_ctz(lanes);
        uint32_t j = rest ? (uint32_t)__builtin_ctz(rest) : i, one = at + i, two = at + j;
        f16 o[3];
        for (int a = 0; a < 3; a++) o[a] = f16_pair(t->o[k->axes[a]][one], t->o[k->axes[a]][two]);
        edges e;
        uint32_t apart = find_edges(vertex, o, f16_pair(t->shear[0][one], t->shear[0][two]),
                                    f16_pair(t->shear[1][one], t->shear[1][two]), &e);
        triangles[i] = (uint8_t)~apart;
        triangles[j] = (uint8_t)(~apart >> 8);
        lanes = rest & (rest - 1);
    }
    transpose_bits(triangles, masks);
}

INLINE void load_bests(query *q, const beam *k, uint32_t lane) {
    start_query(q, &k->tile->rays[lane]);
    q->best_t = k->best_t[lane], q->best_u = k->best_u[lane], q->best_v = k->best_v[lane];
    q->best_instance = k->instance[lane], q->best_primitive = k->primitive[lane];
}

INLINE void store_bests(beam *k, const query *q, uint32_t lane) {
    k->best_t[lane] = q->best_t, k->best_u[lane] = q->best_u, k->best_v[lane] = q->best_v;
    k->instance[lane] = q->best_instance, k->primitive[lane] = q->best_primitive;
}

INLINE bool prepare_lane(prepared *p, const tile *t, uint32_t i) {
    return prepare(p, f8_make(t->o[0][i], t->o[1][i], t->o[2][i], t->t_min[i], t->d[0][i],
                              t->d[1][i], t->d[2][i], t->t_max[i]));
}

/* What is not plain: solved in double, or with a box that only its margin lets pass. */
static __attribute__((noinline)) bool meet_alone(beam *k, const bvh_tree *mesh,
                                                 const triangle_block *b, uint32_t triangle,
                                                 uint32_t lane, const bool any) {
    query q = {0};
    prepared p;
    shear s;
    candidates found;
    load_bests(&q, k, lane);
    prepare_lane(&p, k->tile, lane);
    make_shear(&s, &p);
    unsigned lanes = test_triangles(&s, b, q.best_t, &found) & (1u << triangle);
    if (lanes == 0) return false;
    if (accept_triangles(&q, &p, mesh, &s, b, &found, lanes, k->number, k->floor_t[lane], any))
        return true;
    store_bests(k, &q, lane);
    return false;
}

/* The triangle's own box, as it is: lanes that pass it, and those for which it does not lie behind. */
INLINE uint32_t cross_own_box(const beam *k, const triangle_block *b, uint32_t triangle,
                              uint32_t at, f16 *enter, uint32_t *ahead_of) {
    const tile *t = k->tile;
    f16 leave = f16_set(INFINITY);
    *enter = f16_load(t->t_min + at);
    for (int i = 0; i < 3; i++) {
        float v0 = b->vertex[0][i][triangle], v1 = b->vertex[1][i][triangle],
              v2 = b->vertex[2][i][triangle];
        float low = float_min(float_min(v0, v1), v2), high = float_max(float_max(v0, v1), v2);
        bool back = k->near[i] > k->far[i];
        f16 o = f16_load(t->o[i] + at), inv = f16_load(t->inv[i] + at);
        *enter = f16_max(f16_mul(f16_sub(f16_set(back ? high : low), o), inv), *enter);
        leave = f16_min(f16_mul(f16_sub(f16_set(back ? low : high), o), inv), leave);
    }
    leave = f16_mul(leave, f16_set(BOX_EXIT_SCALE));
    *ahead_of = f16_less_equal(f16_load(t->t_min + at), leave);
    return f16_less_equal(*enter, f16_min(f16_load(t->t_max + at), leave));
}

/* Does it win over what the ray has at the same t? */
INLINE bool is_lower(uint32_t instance, uint32_t primitive, const beam *k, uint32_t lane) {
    return instance != k->instance[lane] ? instance < k->instance[lane]
                                         : primitive < k->primitive[lane];
}

/* One triangle and the rays in `lanes` of a group, by test_triangles and accept_triangles. What was met: of `any`, lanes; else whether there may be a nearer hit. */
INLINE uint32_t meet_triangle(beam *k, const bvh_tree *mesh, const triangle_block *b,
                              uint32_t triangle, uint32_t at, uint32_t lanes, const bool any) {
    const tile *t = k->tile;
    const f16 zero = f16_set(0), iz = f16_load(t->shear[2] + at);
    f16 o[3], vertex[3][3];
    for (int a = 0; a < 3; a++) {
        o[a] = f16_load(t->o[k->axes[a]] + at);
        for (int v = 0; v < 3; v++) vertex[v][a] = f16_set(b->vertex[v][k->axes[a]][triangle]);
    }
    edges e;
    lanes &= ~find_edges(vertex, o, f16_load(t->shear[0] + at), f16_load(t->shear[1] + at), &e);
    if (lanes == 0) return 0;
    f16 det = f16_add(f16_add(e.u, e.v), e.w), size = f16_abs(det);
    uint32_t edge = f16_equal(e.u, zero) | f16_equal(e.v, zero) | f16_equal(e.w, zero);
    uint32_t sound = f16_less(f16_set(1e-30f), size) & f16_less(size, f16_set(1e30f));
    f16 sum = f16_add(f16_add(f16_mul(e.u, f16_mul(iz, e.z[0])), f16_mul(e.v, f16_mul(iz, e.z[1]))),
                      f16_mul(e.w, f16_mul(iz, e.z[2])));
    f16 met = f16_div(sum, det), best = f16_load(k->best_t + at), enter;
    uint32_t hard = lanes & (edge | ~sound);
    lanes &= f16_less_equal(met, best) & ~hard;
    if ((lanes | hard) == 0) return 0;

    uint32_t ahead_of, passed = cross_own_box(k, b, triangle, at, &enter, &ahead_of);
    hard |= lanes & ~passed & ahead_of;
    f16 clamped = f16_max(f16_load(k->floor_t + at), f16_max(enter, met));
    lanes &= passed & f16_less_equal(f16_abs(met), f16_set(FLT_MAX)) &
             f16_less(f16_load(t->t_min + at), clamped) &
             f16_less(clamped, f16_load(t->t_max + at)) & f16_less_equal(clamped, best);
    uint32_t number = b->primitive[triangle];
    lanes &= ~u16_equal(k->skip + at, number); /* the flat surface that it leaves */
    if (!any && lanes != 0) {
        for (uint32_t i = lanes & f16_equal(clamped, best); i != 0; i &= i - 1)
            if (!is_lower(k->number, number, k, at + (uint32_t)__builtin_ctz(i)))
                lanes &= ~(i & -i);
        f16_store(k->best_t + at, f16_blend(lanes, best, clamped));
        f16_store_lanes(k->best_u + at, f16_div(e.v, det), lanes);
        f16_store_lanes(k->best_v + at, f16_div(e.w, det), lanes);
        u16_store_lanes(k->instance + at, k->number, lanes);
        u16_store_lanes(k->primitive + at, number, lanes);
    }
    for (; __builtin_expect(hard != 0, 0); hard &= hard - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(hard);
        if (meet_alone(k, mesh, b, triangle, at + lane, any) || !any) lanes |= 1u << lane;
    }
    return lanes;
}

/* The rays that meet a triangle of the block, or may. */
INLINE uint64_t meet_block(beam *k, const bvh_tree *mesh, const triangle_block *b,
                           unsigned triangles, uint64_t rays, const bool any) {
    uint64_t met = 0;
    for (uint32_t at = 0; at < TILE; at += GROUP) {
        uint32_t lanes = LANES(rays, at), count = (uint32_t)__builtin_popcount(lanes);
        if (lanes == 0) continue;
        k->counters.triangles += count * (uint32_t)__builtin_popcount(triangles);
        uint32_t wanted[BVH_WIDTH];
        bool filtered = count <= FILTER_MOST;
        if (filtered) filter_rays(k, b, at, lanes, wanted);
        for (unsigned i = triangles; i != 0; i &= i - 1) {
            unsigned triangle = (unsigned)__builtin_ctz(i);
            uint32_t asked = filtered ? wanted[triangle] & lanes : lanes;
            if (asked == 0) continue;
            uint32_t found = meet_triangle(k, mesh, b, triangle, at, asked, any);
            if (any) lanes &= ~found;
            met |= (uint64_t)found << at;
        }
    }
    return met;
}

/* ---- the walk ---- */

typedef struct beam_stack {
    walk_stack walk;
    uint64_t rays[BVH_STACK_SIZE + BVH_WIDTH + 1];      /* that pass it, or may */
    const char *planes[BVH_STACK_SIZE + BVH_WIDTH + 1]; /* of its box */
} beam_stack;

/* What will be read soon, by many rays. */
INLINE void fetch(const bvh_tree *tree, uint32_t reference, const bool of_world) {
    if (of_world && reference & BVH_LEAF) return;
    const char *at = reference & BVH_LEAF ? (const char *)&tree->blocks[reference & BVH_INDEX_MASK]
                                          : (const char *)&tree->nodes[reference];
    for (int i = 0; i < 5; i++) __builtin_prefetch(at + 64 * i);
}

INLINE void push(beam_stack *s, float entry, const bvh_node *node, unsigned child, uint64_t rays,
                 const bool of_world) {
    uint32_t i = s->walk.count++;
    s->walk.entries[i] = entry;
    s->walk.references[i] = node->child[child];
    s->rays[i] = rays;
    if (of_world) s->planes[i] = (const char *)&node->bounds[0][0][child];
}

/* The children that rays pass go onto the stack, the nearest last. */
INLINE void step_beam(const beam *k, const bvh_tree *tree, const bvh_node *node, uint64_t rays,
                      beam_stack *s, const bool of_world) {
    f8 entry;
    float entries[BVH_WIDTH];
    m8 passed = test_node(k, node, &entry);
    unsigned lanes = m8_bits(passed), nearest = f8_least(entry, passed);
    if (lanes == 0) return;
    for (unsigned i = lanes; i != 0; i &= i - 1)
        fetch(tree, node->child[__builtin_ctz(i)], of_world);
    f8_store(entries, entry);
    for (unsigned i = lanes & ~(1u << nearest); i != 0; i &= i - 1) {
        unsigned child = (unsigned)__builtin_ctz(i);
        uint64_t through = cross_child(k, node, child, rays);
        if (through != 0) push(s, entries[child], node, child, through, of_world);
    }
    uint64_t through = cross_child(k, node, nearest, rays);
    if (through != 0) push(s, entries[nearest], node, nearest, through, of_world);
}

/* How many rays should be left at a node. */
INLINE uint32_t full_of(uint32_t rays) { return rays > 4 * BEAM_FULL ? rays / 4 : BEAM_FULL; }

INLINE void note_met(beam *k, uint64_t met, const bool any) {
    if (met == 0) return;
    if (any) {
        k->met |= met;
        k->alive &= ~met;
    } else
        find_limit(k);
}

/* What stands in a leaf of the world, for those rays that pass its box. Returns the rays that meet it, or may. floor_t:
 * where each enters the box; of what is not bounded, t_min. */
static uint64_t meet_closest(beam *k, const frozen_level *world, uint32_t index,
                             const float floor_t[TILE], bool bounded, uint64_t rays);
static uint64_t meet_any(beam *k, const frozen_level *world, uint32_t index,
                         const float floor_t[TILE], bool bounded, uint64_t rays);

INLINE void meet(beam *k, const frozen_level *world, uint32_t index, const float floor_t[TILE],
                 bool bounded, uint64_t rays, const bool any) {
    if (rays == 0) return;
    note_met(k,
             any ? meet_any(k, world, index, floor_t, bounded, rays)
                 : meet_closest(k, world, index, floor_t, bounded, rays),
             any);
}

INLINE void meet_leaf(beam *k, const frozen_level *world, uint32_t index, const char *planes,
                      uint64_t rays, const bool any) {
    float floor_t[TILE];
    uint64_t passed = 0;
    for (uint32_t at = 0; at < TILE; at += GROUP) {
        f16 entry;
        if (LANES(rays, at) == 0) continue;
        passed |= (uint64_t)cross_box(k, at, planes, &entry) << at;
        f16_store(floor_t + at, entry);
    }
    meet(k, world, index, floor_t, true, rays & passed, any);
}

/* Those rays of a beam. world: whose tree it is; NULL: of a mesh. False: given up. */
INLINE bool walk_beam(beam *k, const bvh_tree *tree, uint64_t rays, const frozen_level *world,
                      const bool any) {
    beam_stack s;
    uint64_t full = full_of(count_bits(rays)), visits = 0, nodes = 0;
    bool thin = false;
    s.walk.count = 1;
    s.walk.entries[0] = k->least_t;
    s.walk.references[0] = tree->root;
    s.rays[0] = rays;
    while (s.walk.count > 0 && k->alive != 0) {
        uint32_t reference = pop(&s.walk);
        rays = s.rays[s.walk.count] & k->alive;
        if (rays == 0 || s.walk.entries[s.walk.count] > k->limit) continue;
        if (!(reference & BVH_LEAF)) {
            nodes++;
            visits += count_bits(rays);
            thin = nodes > THIN_AFTER && 3 * visits < 2 * full * nodes;
            if (thin) break;
            step_beam(k, tree, &tree->nodes[reference], rays, &s, world != NULL);
            continue;
        }
        if (world) {
            meet_leaf(k, world, reference & ~BVH_LEAF, s.planes[s.walk.count], rays, any);
            continue;
        }
        const triangle_block *block = &tree->blocks[reference & BVH_INDEX_MASK];
        uint32_t count = (reference >> BVH_COUNT_SHIFT & 7) + 1;
        unsigned triangles = test_block_boxes(k, tree, block) & ((1u << count) - 1);
        if (triangles == 0) continue;
        note_met(k, meet_block(k, tree, block, triangles, rays, any), any);
    }
    k->counters.nodes += nodes;
    k->visits += visits;
    return !thin;
}
