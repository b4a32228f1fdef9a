/* The tracing kernel, compiled once per instruction set (kernel_*.c define TRACE_KERNEL). The hit
 * rule is in accel.h; this is the rule written out for eight boxes or eight triangles at a time. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "accel/kernels/kernel.h"
#include "simd/float8.h"

/* Under the sanitizers, whose checks multiply, the compiler would need minutes for one function. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define INLINE static inline
#else
#define INLINE static inline __attribute__((always_inline))
#endif

/* A ray in one space, made ready for the slab test. */
typedef struct prepared {
    float o[3], d[3], inv[3];
    uint32_t sign[3]; /* of inv, so that -0 is told from 0: which plane of a slab is nearer */
    float t_min, t_max;
} prepared;

/* What a trace of one ray carries about. best_t starts as t_max, with no ids. */
typedef struct query {
    const ray *ray;
    dvec3 o, d;    /* the ray in the space of the level that is traced: the world, or a group */
    uint32_t base; /* number of that level's first shape */
    uint32_t unused;
    float best_t, best_u, best_v;
    uint32_t best_instance, best_primitive;
    trace_counters counters;
} query;

INLINE uint32_t float_bits(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

INLINE float bits_float(uint32_t bits) {
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* False for a ray that hits nothing by definition: not finite, or of no direction. */
INLINE bool prepare(prepared *p, vec3 o, vec3 d, float t_min, float t_max) {
    p->o[0] = o.x, p->o[1] = o.y, p->o[2] = o.z;
    p->d[0] = d.x, p->d[1] = d.y, p->d[2] = d.z;
    p->t_min = t_min, p->t_max = t_max;
    for (int i = 0; i < 3; i++) {
        p->inv[i] = 1 / p->d[i];
        p->sign[i] = float_bits(p->inv[i]) >> 31;
        if (!(fabsf(p->o[i]) <= FLT_MAX && fabsf(p->d[i]) <= FLT_MAX)) return false;
    }
    return d.x != 0 || d.y != 0 || d.z != 0;
}

/* ---- the slab test: one box, then eight ---- */

INLINE bool test_box(const prepared *p, const bounds3 *box, float *entry) {
    const float bounds[2][3] = {{box->min.x, box->min.y, box->min.z},
                                {box->max.x, box->max.y, box->max.z}};
    float low = p->t_min, high = INFINITY;
    for (int i = 0; i < 3; i++) {
        low = float_max((bounds[p->sign[i]][i] - p->o[i]) * p->inv[i], low);
        high = float_min((bounds[p->sign[i] ^ 1][i] - p->o[i]) * p->inv[i], high);
    }
    *entry = low;
    return low <= float_min(p->t_max, high * BOX_EXIT_SCALE);
}

typedef struct slabs8 {
    /* The origin, as the nearer and the farther plane are reckoned from. */
    f8 to_near[3], to_far[3];
    f8 inv[3], t_min;
    uint32_t sign[3];
} slabs8;

INLINE slabs8 widen_slabs(const prepared *p) {
    slabs8 s;
    for (int i = 0; i < 3; i++) {
        s.to_near[i] = s.to_far[i] = f8_set(p->o[i]);
        s.inv[i] = f8_set(p->inv[i]);
        s.sign[i] = p->sign[i];
    }
    s.t_min = f8_set(p->t_min);
    return s;
}

/* All boxes are wider by the margin, on each side of each axis. */
INLINE slabs8 widen_slabs_by(const prepared *p, const float margin[3]) {
    slabs8 s = widen_slabs(p);
    for (int i = 0; i < 3; i++) {
        float ahead = p->sign[i] ? -margin[i] : margin[i];
        s.to_near[i] = f8_set(p->o[i] + ahead);
        s.to_far[i] = f8_set(p->o[i] - ahead);
    }
    return s;
}

/* What the watertight test may be off by in a mesh, which is relative to how far off the vertices are
 * (layout.h). True: the nodes are built wider by as much. */
INLINE bool find_margin(const prepared *p, const bvh_tree *mesh, float margin[3]) {
    const float low[3] = {mesh->bounds.min.x, mesh->bounds.min.y, mesh->bounds.min.z};
    const float high[3] = {mesh->bounds.max.x, mesh->bounds.max.y, mesh->bounds.max.z};
    float reach = 0, most = 0;
    for (int i = 0; i < 3; i++)
        reach = float_max(reach, float_max(fabsf(low[i] - p->o[i]), fabsf(high[i] - p->o[i])));
    for (int i = 0; i < 3; i++) {
        margin[i] = reach * BOX_REACH_MARGIN + fabsf(p->o[i]) * BOX_PLACE_MARGIN;
        most = float_max(most, margin[i]);
    }
    return most <= mesh->margin;
}

/* Bits of the children whose boxes the ray passes before `limit`. */
INLINE unsigned test_children(const slabs8 *s, const bvh_node *node, float limit, f8 *entry) {
    f8 low = s->t_min, high = f8_set(INFINITY);
    for (int i = 0; i < 3; i++) {
        f8 near_plane = f8_load(node->bounds[s->sign[i]][i]);
        f8 far_plane = f8_load(node->bounds[s->sign[i] ^ 1][i]);
        low = f8_max(f8_mul(f8_sub(near_plane, s->to_near[i]), s->inv[i]), low);
        high = f8_min(f8_mul(f8_sub(far_plane, s->to_far[i]), s->inv[i]), high);
    }
    high = f8_min(f8_set(limit), f8_mul(high, f8_set(BOX_EXIT_SCALE)));
    *entry = low;
    return m8_bits(f8_less_equal(low, high)) & node->valid;
}

/* ---- the stack: entry distance above, reference below, so that integers sort by distance ---- */

INLINE uint64_t stack_item(float entry, uint32_t reference) {
    return (uint64_t)float_bits(entry) << 32 | reference;
}

INLINE float item_entry(uint64_t item) { return bits_float((uint32_t)(item >> 32)); }

/* Puts the children in `mask` (not empty) on the stack, the nearest last, but for the nearest
 * itself, which is returned. Only speed depends on the order; it is the same everywhere, so that
 * counters are. */
INLINE uint64_t push_children(uint64_t **top, const bvh_node *node, f8 entry, unsigned mask) {
    float entries[BVH_WIDTH];
    f8_store(entries, entry);
    int first = __builtin_ctz(mask);
    uint64_t nearest = stack_item(entries[first], node->child[first]);
    uint64_t *begin = *top, *end = begin;
    while ((mask &= mask - 1) != 0) {
        int child = __builtin_ctz(mask);
        uint64_t item = stack_item(entries[child], node->child[child]);
        uint64_t farther = item > nearest ? item : nearest;
        nearest = item > nearest ? nearest : item;
        uint64_t *slot = end++;
        for (; slot > begin && slot[-1] < farther; slot--) *slot = slot[-1];
        *slot = farther;
    }
    *top = end;
    return nearest;
}

/* ---- accepting a hit ---- */

/* (t, instance, primitive) lexicographically after the hit that the ray walks on from. */
INLINE bool comes_after(const ray *r, float t, uint32_t instance, uint32_t primitive) {
    if (t != r->after_t) return t > r->after_t;
    if (instance != r->after_instance) return instance > r->after_instance;
    return primitive > r->after_primitive;
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

/* ---- triangles: Woop, Benthin, Wald, Watertight Ray/Triangle Intersection, JCGT 2(1), 2013.
 * Deviations: where the float determinant could have lost its precision to under- or overflow, and
 * where an edge function is 0, everything from the edge functions on is done in double, whose
 * products of floats are exact; and the sign decides before it is rounded back. ---- */

typedef struct shear8 {
    f8 o[3], x, y, z; /* o in the order of k */
    uint32_t k[3];    /* k[2] is the axis of the largest |d| */
} shear8;

INLINE shear8 make_shear(const prepared *p) {
    float ax = fabsf(p->d[0]), ay = fabsf(p->d[1]), az = fabsf(p->d[2]);
    uint32_t kz = ax > ay ? (ax > az ? 0 : 2) : (ay > az ? 1 : 2);
    uint32_t kx = kz == 2 ? 0 : kz + 1, ky = kx == 2 ? 0 : kx + 1;
    shear8 s = {.k = {kx, ky, kz}};
    for (int i = 0; i < 3; i++) s.o[i] = f8_set(p->o[s.k[i]]);
    s.x = f8_set(p->d[kx] / p->d[kz]);
    s.y = f8_set(p->d[ky] / p->d[kz]);
    s.z = f8_set(1 / p->d[kz]);
    return s;
}

typedef struct candidates {
    f8 x[3], y[3], z[3]; /* of each vertex, sheared: the ray is the z axis */
    float t[BVH_WIDTH], weight[2][BVH_WIDTH], det[BVH_WIDTH];
} candidates;

/* One triangle in double. False: missed. */
static bool solve_in_double(candidates *c, unsigned lane) {
    float x[3][BVH_WIDTH], y[3][BVH_WIDTH], z[3][BVH_WIDTH];
    for (int i = 0; i < 3; i++) {
        f8_store(x[i], c->x[i]);
        f8_store(y[i], c->y[i]);
        f8_store(z[i], c->z[i]);
    }
    double w[3];
    for (int i = 0; i < 3; i++) { /* the edge opposite to vertex i */
        int b = (i + 1) % 3, e = (i + 2) % 3;
        w[i] = (double)x[e][lane] * y[b][lane] - (double)y[e][lane] * x[b][lane];
    }
    if ((w[0] < 0 || w[1] < 0 || w[2] < 0) && (w[0] > 0 || w[1] > 0 || w[2] > 0)) return false;
    double det = (w[0] + w[1]) + w[2];
    if (!(det != 0)) return false;
    double t = (w[0] * z[0][lane] + w[1] * z[1][lane]) + w[2] * z[2][lane];
    c->t[lane] = (float)(t / det);
    c->weight[0][lane] = (float)(w[1] / det);
    c->weight[1][lane] = (float)(w[2] / det);
    c->det[lane] = 1;
    return true;
}

/* Where the ray enters and leaves the triangles' own boxes. */
INLINE void cross_own_boxes(const slabs8 *s, const triangle_block *b, f8 *enter, f8 *leave) {
    f8 low = s->t_min, high = f8_set(INFINITY);
    for (int i = 0; i < 3; i++) {
        f8 v0 = f8_load(b->vertex[0][i]), v1 = f8_load(b->vertex[1][i]),
           v2 = f8_load(b->vertex[2][i]);
        f8 least = f8_min(f8_min(v0, v1), v2), most = f8_max(f8_max(v0, v1), v2);
        f8 near_plane = s->sign[i] ? most : least, far_plane = s->sign[i] ? least : most;
        low = f8_max(f8_mul(f8_sub(near_plane, s->to_near[i]), s->inv[i]), low);
        high = f8_min(f8_mul(f8_sub(far_plane, s->to_far[i]), s->inv[i]), high);
    }
    *enter = low;
    *leave = f8_mul(high, f8_set(BOX_EXIT_SCALE));
}

/* Lanes whose own box, widened, the ray passes, and whose box as it is does not lie behind t_min; and
 * the entries that t is raised to: those of the boxes as they are, so that faces of one plane are met at
 * one t. Where only the wider box is passed, that is where the box as it is would be left. */
INLINE unsigned test_own_boxes(const prepared *p, const float margin[3], const triangle_block *b,
                               f8 *entry) {
    f8 enter, leave, enter_wide, leave_wide;
    const slabs8 plain = widen_slabs(p), wide = widen_slabs_by(p, margin);
    cross_own_boxes(&plain, b, &enter, &leave);
    cross_own_boxes(&wide, b, &enter_wide, &leave_wide);
    *entry = f8_max(f8_min(enter, leave), enter_wide);
    m8 passed = f8_less_equal(enter_wide, f8_min(f8_set(p->t_max), leave_wide));
    return m8_bits(m8_and(passed, f8_less_equal(plain.t_min, leave)));
}

/* Lanes whose triangles the ray's line meets, with t in c->t: the watertight test. */
INLINE unsigned test_triangles(const shear8 *s, const triangle_block *b, unsigned lanes,
                               float limit, candidates *c) {
    for (int i = 0; i < 3; i++) {
        c->z[i] = f8_sub(f8_load(b->vertex[i][s->k[2]]), s->o[2]);
        c->x[i] = f8_sub(f8_sub(f8_load(b->vertex[i][s->k[0]]), s->o[0]), f8_mul(s->x, c->z[i]));
        c->y[i] = f8_sub(f8_sub(f8_load(b->vertex[i][s->k[1]]), s->o[1]), f8_mul(s->y, c->z[i]));
    }
    f8 u = f8_sub(f8_mul(c->x[2], c->y[1]), f8_mul(c->y[2], c->x[1]));
    f8 v = f8_sub(f8_mul(c->x[0], c->y[2]), f8_mul(c->y[0], c->x[2]));
    f8 w = f8_sub(f8_mul(c->x[1], c->y[0]), f8_mul(c->y[1], c->x[0]));
    f8 zero = f8_set(0);
    m8 negative = m8_or(m8_or(f8_less(u, zero), f8_less(v, zero)), f8_less(w, zero));
    m8 positive = m8_or(m8_or(f8_less(zero, u), f8_less(zero, v)), f8_less(zero, w));
    lanes &= ~m8_bits(m8_and(negative, positive));
    if (lanes == 0) return 0;

    f8 det = f8_add(f8_add(u, v), w), size = f8_abs(det);
    m8 edge = m8_or(m8_or(f8_equal(u, zero), f8_equal(v, zero)), f8_equal(w, zero));
    m8 sound = m8_and(f8_less(f8_set(1e-30f), size), f8_less(size, f8_set(1e30f)));
    unsigned in_double = lanes & (m8_bits(edge) | ~m8_bits(sound));
    for (int i = 0; i < 3; i++) c->z[i] = f8_mul(s->z, c->z[i]);
    f8 sum = f8_add(f8_add(f8_mul(u, c->z[0]), f8_mul(v, c->z[1])), f8_mul(w, c->z[2]));
    f8 t = f8_div(sum, det);
    unsigned nearer = m8_bits(f8_less_equal(t, f8_set(limit)));
    lanes &= nearer | in_double;
    if (lanes == 0) return 0;
    f8_store(c->t, t);
    f8_store(c->weight[0], v);
    f8_store(c->weight[1], w);
    f8_store(c->det, det);
    for (; in_double != 0; in_double &= in_double - 1) {
        unsigned lane = (unsigned)__builtin_ctz(in_double);
        if (!solve_in_double(c, lane)) lanes &= ~(1u << lane);
    }
    return lanes;
}

/* True: `any` was asked and one was found. floor_t: the entry of the instance's box. */
INLINE bool visit_block(query *q, const prepared *p, const float margin[3], const shear8 *shear,
                        const triangle_block *b, uint32_t reference, uint32_t instance,
                        float floor_t, const bool any) {
    uint32_t count = (reference >> BVH_COUNT_SHIFT & 7) + 1;
    q->counters.triangles += count;
    candidates c;
    unsigned lanes = test_triangles(shear, b, (1u << count) - 1, q->best_t, &c);
    if (lanes == 0) return false;
    f8 entry, t = f8_load(c.t);
    lanes &= test_own_boxes(p, margin, b, &entry);
    f8 clamped = f8_max(f8_set(floor_t), f8_max(entry, t));
    m8 finite = f8_less_equal(f8_abs(t), f8_set(FLT_MAX));
    m8 inside = m8_and(f8_less(f8_set(p->t_min), clamped), f8_less(clamped, f8_set(p->t_max)));
    m8 nearer = f8_less_equal(clamped, f8_set(q->best_t));
    lanes &= m8_bits(m8_and(m8_and(finite, inside), nearer));
    if (lanes == 0) return false;
    f8_store(c.t, clamped);
    for (; lanes != 0; lanes &= lanes - 1) {
        int lane = __builtin_ctz(lanes);
        uint32_t primitive = b->primitive[lane];
        const ray *r = q->ray;
        if (instance == r->skip_instance && primitive == r->skip_primitive) continue;
        if (!comes_after(r, c.t[lane], instance, primitive)) continue;
        if (any) return true;
        if (!beats_best(q, c.t[lane], instance, primitive)) continue;
        take(q, c.t[lane], c.weight[0][lane] / c.det[lane], c.weight[1][lane] / c.det[lane],
             instance, primitive);
    }
    return false;
}

INLINE bool walk_mesh(query *q, const prepared *p, const bvh_tree *mesh, const float margin[3],
                      const bool wide, uint32_t instance, float floor_t, const bool any) {
    uint64_t stack[BVH_STACK_SIZE], *top = stack;
    const slabs8 slabs = wide ? widen_slabs_by(p, margin) : widen_slabs(p);
    const shear8 shear = make_shear(p);
    uint64_t item = stack_item(p->t_min, mesh->root);
    for (;;) {
        uint32_t reference = (uint32_t)item;
        unsigned mask = 1;
        while (!(reference & BVH_LEAF)) {
            const bvh_node *node = &mesh->nodes[reference];
            f8 entry;
            mask = test_children(&slabs, node, q->best_t, &entry);
            q->counters.nodes++;
            q->counters.boxes += (unsigned)__builtin_popcount(node->valid);
            if (mask == 0) break;
            reference = (uint32_t)push_children(&top, node, entry, mask);
        }
        if (mask != 0 &&
            visit_block(q, p, margin, &shear, &mesh->blocks[reference & BVH_INDEX_MASK], reference,
                        instance, floor_t, any))
            return true;
        do {
            if (top == stack) return false;
            item = *--top;
        } while (item_entry(item) > q->best_t);
    }
}

/* From far off. */
static __attribute__((noinline)) bool walk_mesh_wide(query *q, const prepared *p,
                                                     const bvh_tree *mesh, const float margin[3],
                                                     uint32_t instance, float floor_t,
                                                     const bool any) {
    return walk_mesh(q, p, mesh, margin, true, instance, floor_t, any);
}

INLINE bool trace_mesh(query *q, const prepared *p, const bvh_tree *mesh, uint32_t instance,
                       float floor_t, const bool any) {
    float margin[3];
    if (!find_margin(p, mesh, margin))
        return walk_mesh_wide(q, p, mesh, margin, instance, floor_t, any);
    return walk_mesh(q, p, mesh, margin, false, instance, floor_t, any);
}

/* ---- meshes that deform: boxes and vertices are mixed from those of two keys, by the formula of
 * deforming_mix, which is monotone: the mixed boxes hold the mixed triangles ---- */

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

/* test_children of the mixed node. */
INLINE unsigned test_mixed_children(const slabs8 *s, const moment *now, uint32_t index, float limit,
                                    f8 *entry) {
    const bvh_node *a = &now->nodes[0][index], *b = &now->nodes[1][index];
    f8 low = s->t_min, high = f8_set(INFINITY);
    for (int i = 0; i < 3; i++) {
        uint32_t near = s->sign[i], far = near ^ 1;
        f8 near_plane = mix8(now, a->bounds[near][i], b->bounds[near][i]);
        f8 far_plane = mix8(now, a->bounds[far][i], b->bounds[far][i]);
        low = f8_max(f8_mul(f8_sub(near_plane, s->to_near[i]), s->inv[i]), low);
        high = f8_min(f8_mul(f8_sub(far_plane, s->to_far[i]), s->inv[i]), high);
    }
    high = f8_min(f8_set(limit), f8_mul(high, f8_set(BOX_EXIT_SCALE)));
    *entry = low;
    return m8_bits(f8_less_equal(low, high)) & a->valid;
}

INLINE void mix_block(const moment *now, uint32_t index, triangle_block *out) {
    const triangle_block *a = &now->blocks[0][index], *b = &now->blocks[1][index];
    for (int v = 0; v < 3; v++)
        for (int axis = 0; axis < 3; axis++)
            f8_store(out->vertex[v][axis], mix8(now, a->vertex[v][axis], b->vertex[v][axis]));
    memcpy(out->primitive, a->primitive, sizeof out->primitive);
}

/* trace_mesh at the ray's time. */
INLINE bool trace_deforming(query *q, const prepared *p, const bvh_tree *tree,
                            const deforming_mesh *m, uint32_t instance, float floor_t,
                            const bool any) {
    if (tree->block_count == 0) return false;
    uint64_t stack[BVH_STACK_SIZE], *top = stack;
    float margin[3];
    bool built = find_margin(p, tree, margin);
    const slabs8 slabs = built ? widen_slabs(p) : widen_slabs_by(p, margin);
    const shear8 shear = make_shear(p);
    const moment now = find_moment(tree, m, q->ray->time);
    uint64_t item = stack_item(p->t_min, tree->root);
    for (;;) {
        uint32_t reference = (uint32_t)item;
        unsigned mask = 1;
        while (!(reference & BVH_LEAF)) {
            const bvh_node *node = &now.nodes[0][reference];
            f8 entry;
            mask = test_mixed_children(&slabs, &now, reference, q->best_t, &entry);
            q->counters.nodes++;
            q->counters.boxes += (unsigned)__builtin_popcount(node->valid);
            if (mask == 0) break;
            reference = (uint32_t)push_children(&top, node, entry, mask);
        }
        if (mask != 0) {
            _Alignas(64) triangle_block block;
            mix_block(&now, reference & BVH_INDEX_MASK, &block);
            if (visit_block(q, p, margin, &shear, &block, reference, instance, floor_t, any))
                return true;
        }
        do {
            if (top == stack) return false;
            item = *--top;
        } while (item_entry(item) > q->best_t);
    }
}

static __attribute__((noinline)) bool deforming_closest(query *q, const prepared *p,
                                                        const frozen_instance *in, uint32_t number,
                                                        float floor_t) {
    return trace_deforming(q, p, in->parts, in->desc, number, floor_t, false);
}

static __attribute__((noinline)) bool deforming_any(query *q, const prepared *p,
                                                    const frozen_instance *in, uint32_t number,
                                                    float floor_t) {
    return trace_deforming(q, p, in->parts, in->desc, number, floor_t, true);
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
    uint64_t stack[BVH_STACK_SIZE], *top = stack;
    const slabs8 slabs = widen_slabs(p);
    uint64_t item = stack_item(p->t_min, tree->root);
    for (;;) {
        uint32_t reference = (uint32_t)item, leaf = reference & ~BVH_LEAF;
        if (reference & BVH_LEAF) {
            float low = float_max(item_entry(item), floor_t);
            if (in ? trace_analytic(q, p, in, number, leaf, low, any)
                   : visit_instance(q, p, level, leaf, low, true, any))
                return true;
        } else {
            const bvh_node *node = &tree->nodes[reference];
            f8 entry;
            unsigned mask = test_children(&slabs, node, q->best_t, &entry);
            q->counters.nodes++;
            q->counters.boxes += (unsigned)__builtin_popcount(node->valid);
            if (mask != 0) {
                item = push_children(&top, node, entry, mask);
                continue;
            }
        }
        do {
            if (top == stack) return false;
            item = *--top;
        } while (item_entry(item) > q->best_t);
    }
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

INLINE bool trace_instance(query *q, const prepared *outer, const frozen_instance *in,
                           float floor_t, bool bounded, const bool any) {
    prepared local;
    const prepared *p = outer;
    dvec3 o = q->o, d = q->d;
    if (!in->identity) {
        const transform *to_local = &in->to_local;
        transform moved, moved_inverse;
        if (in->moves) {
            if (!motion_at(in->moves, q->ray->time, &moved, &moved_inverse)) return false;
            to_local = &moved_inverse;
        }
        o = transform_point(to_local, o);
        d = transform_vector(to_local, d);
        if (!prepare(&local, vec3_from(o), vec3_from(d), outer->t_min, outer->t_max)) return false;
        p = &local;
    }
    uint32_t number = q->base + in->first;
    if (in->mesh) return trace_mesh(q, p, in->mesh, number, floor_t, any);
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
    q->ray = r;
    q->o = dvec3_from(r->o), q->d = dvec3_from(r->d);
    return prepare(&world, r->o, r->d, r->t_min, r->t_max) &&
           trace_level(q, &world, &a->world, r->t_min, any);
}

static void add_counters(trace_counters *to, const trace_counters *from) {
    to->nodes += from->nodes;
    to->boxes += from->boxes;
    to->triangles += from->triangles;
    to->primitives += from->primitives;
}

static void trace_rays(const accel *a, const ray *rays, hit *hits, size_t count,
                       trace_counters *counters) {
    query q = {0};
    for (size_t i = 0; i < count; i++) {
        const ray *r = &rays[i];
        q.best_t = r->t_max, q.best_u = 0, q.best_v = 0;
        q.best_instance = NO_ID, q.best_primitive = NO_ID;
        trace_world(&q, a, r, false);
        float t = q.best_instance == NO_ID ? INFINITY : q.best_t;
        hits[i] = (hit){t, q.best_u, q.best_v, q.best_primitive, q.best_instance};
    }
    if (counters) add_counters(counters, &q.counters);
}

static void occlude_rays(const accel *a, const ray *rays, uint8_t *blocked, size_t count,
                         trace_counters *counters) {
    query q = {0};
    q.best_instance = NO_ID, q.best_primitive = NO_ID;
    for (size_t i = 0; i < count; i++) {
        q.best_t = rays[i].t_max;
        blocked[i] = trace_world(&q, a, &rays[i], true);
    }
    if (counters) add_counters(counters, &q.counters);
}

const trace_kernel TRACE_KERNEL = {trace_rays, occlude_rays};
