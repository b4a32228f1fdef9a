/* A ray made ready for the slab test, and a step down a tree of boxes. */

/* A ray in one space. Rows of eight: as it stands in struct ray, and 1 over that. */
typedef struct prepared {
    union {
        float row[8];
        struct {
            float o[3], t_min, d[3], t_max;
        };
    };
    union {
        float inverse[8];
        struct {
            float unused[4], inv[3]; /* 1/d */
        };
    };
    /* Where in a node the planes of an axis stand which the ray meets first and last, in bytes. */
    union {
        uint32_t offsets[8];
        struct {
            uint32_t near[3], unused_too, far[3];
        };
    };
} prepared;

/* By the signs of d, so that -0 is told from 0. */
static const uint32_t plane_offsets[8][8] = {
#define LOW(axis) (axis) * 4 * BVH_WIDTH
#define HIGH(axis) (3 + (axis)) * 4 * BVH_WIDTH
#define OFFSETS(x, y, z)                                                                           \
    {                                                                                              \
        x ? HIGH(0) : LOW(0), y ? HIGH(1) : LOW(1), z ? HIGH(2) : LOW(2), 0, x ? LOW(0) : HIGH(0), \
            y ? LOW(1) : HIGH(1), z ? LOW(2) : HIGH(2), 0                                          \
    }
    OFFSETS(0, 0, 0), OFFSETS(1, 0, 0), OFFSETS(0, 1, 0), OFFSETS(1, 1, 0), OFFSETS(0, 0, 1),
    OFFSETS(1, 0, 1), OFFSETS(0, 1, 1), OFFSETS(1, 1, 1)
#undef OFFSETS
#undef HIGH
#undef LOW
};

/* o, t_min, d, t_max. False for a ray that hits nothing by definition: not finite, or of no direction. */
INLINE bool prepare(prepared *p, f8 row) {
    f8_store(p->row, row);
    f8_store(p->inverse, f8_div(f8_set(1), row));
    memcpy(p->offsets, plane_offsets[f8_signs(row) >> 4 & 7], sizeof plane_offsets[0]);
    unsigned finite = m8_bits(f8_less_equal(f8_abs(row), f8_set(FLT_MAX)));
    unsigned zero = m8_bits(f8_equal(row, f8_set(0)));
    return (finite & 0x77) == 0x77 && (zero & 0x70) != 0x70;
}

INLINE bool prepare_local(prepared *p, vec3 o, vec3 d, float t_min, float t_max) {
    return prepare(p, f8_make(o.x, o.y, o.z, t_min, d.x, d.y, d.z, t_max));
}

/* ---- the slab test: one box, then eight ---- */

INLINE bool test_box(const prepared *p, const bounds3 *box, float *entry) {
    float low = p->t_min, high = INFINITY;
    for (int i = 0; i < 3; i++) { /* the planes stand as in a node of one child */
        const char *planes = (const char *)box;
        float near_plane, far_plane;
        memcpy(&near_plane, planes + p->near[i] / BVH_WIDTH, sizeof(float));
        memcpy(&far_plane, planes + p->far[i] / BVH_WIDTH, sizeof(float));
        low = float_max((near_plane - p->o[i]) * p->inv[i], low);
        high = float_min((far_plane - p->o[i]) * p->inv[i], high);
    }
    *entry = low;
    return low <= float_min(p->t_max, high * BOX_EXIT_SCALE);
}

/* What the watertight test may be off by in a mesh, which is relative to how far off the vertices are
 * (layout.h). */
INLINE void find_margin(const prepared *p, const bvh_tree *mesh, float margin[3]) {
    const float low[3] = {mesh->bounds.min.x, mesh->bounds.min.y, mesh->bounds.min.z};
    const float high[3] = {mesh->bounds.max.x, mesh->bounds.max.y, mesh->bounds.max.z};
    float reach = 0;
    for (int i = 0; i < 3; i++)
        reach = float_max(reach, float_max(fabsf(low[i] - p->o[i]), fabsf(high[i] - p->o[i])));
    for (int i = 0; i < 3; i++)
        margin[i] = reach * BOX_REACH_MARGIN + fabsf(p->o[i]) * BOX_PLACE_MARGIN;
}

/* Are the nodes of the mesh, as they are built, wide enough for this ray? */
INLINE bool is_near(const prepared *p, const bvh_tree *mesh) {
    float margin[3];
    bool inside = p->o[0] >= mesh->bounds.min.x && p->o[0] <= mesh->bounds.max.x &&
                  p->o[1] >= mesh->bounds.min.y && p->o[1] <= mesh->bounds.max.y &&
                  p->o[2] >= mesh->bounds.min.z && p->o[2] <= mesh->bounds.max.z;
    if (inside) return true;
    find_margin(p, mesh, margin);
    return float_max(float_max(margin[0], margin[1]), margin[2]) <= mesh->margin;
}

/* By how much a box is wider, along the ray: the margin with the sign of d. */
INLINE float ahead(const prepared *p, const float margin[3], int axis) {
    return p->near[axis] > p->far[axis] ? -margin[axis] : margin[axis];
}

/* The children whose boxes the ray passes between `start` and `limit`, and where it enters them. bounds: as
 * in bvh_node. margin: NULL, or by how much each box is wider. */
INLINE m8 test_children(const prepared *p, const float bounds[2][3][BVH_WIDTH], const float *margin,
                        float start, float limit, f8 *entry) {
    const char *planes = (const char *)bounds;
    f8 low = f8_set(start), high = f8_set(INFINITY);
    for (int i = 0; i < 3; i++) {
        f8 inv = f8_set(p->inv[i]);
        f8 near_o = f8_set(margin ? p->o[i] + ahead(p, margin, i) : p->o[i]);
        f8 far_o = margin ? f8_set(p->o[i] - ahead(p, margin, i)) : near_o;
        f8 near_plane = f8_load((const float *)(planes + p->near[i]));
        f8 far_plane = f8_load((const float *)(planes + p->far[i]));
        low = f8_max(f8_mul(f8_sub(near_plane, near_o), inv), low);
        high = f8_min(f8_mul(f8_sub(far_plane, far_o), inv), high);
    }
    *entry = low;
    return f8_less_equal(low, f8_min(f8_mul(high, f8_set(BOX_EXIT_SCALE)), f8_set(limit)));
}

/* ---- the stack ---- */

/* Of each item: where the ray enters it, and what it is. The first is no item and never taken off. */
typedef struct walk_stack {
    uint32_t count;
    float entries[BVH_STACK_SIZE + BVH_WIDTH + 1];
    uint32_t references[BVH_STACK_SIZE + BVH_WIDTH + 1];
} walk_stack;
#define STACK_END 0xffffffffu

INLINE void start_stack(walk_stack *s) {
    s->entries[0] = -INFINITY;
    s->references[0] = STACK_END;
    s->count = 1;
}

INLINE uint32_t pop(walk_stack *s) { return s->references[--s->count]; }

/* The children in `lanes` go onto the stack, the nearest last; then the last item is taken off, which is the
 * nearest, or without any what was there before. No branch: which way it goes is hard to foretell. */
INLINE uint32_t push_children(walk_stack *s, const bvh_node *node, f8 entry, unsigned lanes,
                              unsigned nearest) {
    unsigned others = lanes & ~(1u << nearest);
    uint32_t count = s->count, child = node->child[nearest];
    f8_compress(s->entries + count, entry, s->references + count, node->child, others);
    s->references[count + (uint32_t)__builtin_popcount(others)] = child;
    s->count = count += (uint32_t)__builtin_popcount(lanes) - 1;
    return s->references[count];
}

/* What is entered beyond t is taken off. */
static __attribute__((noinline)) void prune(walk_stack *s, float t) {
    uint32_t kept = 1;
    for (uint32_t i = 1; i < s->count; i++) {
        s->entries[kept] = s->entries[i];
        s->references[kept] = s->references[i];
        kept += !(s->entries[i] > t);
    }
    s->count = kept;
}
