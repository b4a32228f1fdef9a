/* A tile: up to 64 rays, as they stand one after the other in a batch, made ready side by side for a mesh, or for a
 * world; or those of another tile in the space of an instance. */

enum { TILE = 64, GROUP = 16 };

/* Ray i is bit i of the masks. Arrays hold an entry per ray. */
typedef struct tile {
    union {
        float row[8][TILE]; /* as in struct ray */
        struct {
            float o[3][TILE], t_min[TILE], d[3][TILE], t_max[TILE];
        };
    };
    float inv[3][TILE], shear[3][TILE], floor_t[TILE], after_t[TILE];
    uint8_t axes[TILE][3]; /* shear.k */
    const ray *rays;
    uint64_t all;
    uint64_t back[3], dominated[3]; /* d is negative, -0 too; is largest along this axis */
    uint64_t enter; /* may hit something: sound, and for a mesh not masked, and pass its box */
    uint64_t far;   /* for these the nodes are too narrow as they are */
    uint64_t plain; /* no zero in d, no NaN in t; and does not walk on */
    uint64_t walks;
    uint32_t masks, common_mask; /* bits that any ray has, and that all have */
} tile;

INLINE uint32_t count_bits(uint64_t mask) { return (uint32_t)__builtin_popcountll(mask); }
#define LANES(mask, at) ((uint32_t)((mask) >> (at)) & 0xffff)

/* Lanes for which is_near is not so. */
INLINE uint64_t find_far(const tile *t, const bvh_tree *mesh, uint32_t at) {
    const float low[3] = {mesh->bounds.min.x, mesh->bounds.min.y, mesh->bounds.min.z};
    const float high[3] = {mesh->bounds.max.x, mesh->bounds.max.y, mesh->bounds.max.z};
    f16 reach = f16_set(0), place = f16_set(0);
    uint32_t inside = 0xffff;
    for (int i = 0; i < 3; i++) {
        f16 o = f16_load(t->o[i] + at);
        f16 below = f16_sub(f16_set(low[i]), o), above = f16_sub(f16_set(high[i]), o);
        reach = f16_max(reach, f16_max(f16_abs(below), f16_abs(above)));
        place = f16_max(place, f16_abs(o));
        inside &= f16_less_equal(f16_set(low[i]), o) & f16_less_equal(o, f16_set(high[i]));
    }
    f16 margin = f16_add(f16_mul(reach, f16_set(BOX_REACH_MARGIN)),
                         f16_mul(place, f16_set(BOX_PLACE_MARGIN)));
    uint32_t near = inside | f16_less_equal(margin, f16_set(mesh->margin));
    return (uint64_t)(~near & 0xffff) << at;
}

/* Lanes of the group that pass a box before their limits, whichever way they go, and where they enter it; as
 * test_box. */
INLINE uint32_t pass_box(const tile *t, uint32_t at, const float low[3], const float high[3],
                         const float limits[TILE], f16 *entry) {
    f16 enter = f16_load(t->t_min + at), leave = f16_set(INFINITY);
    for (int i = 0; i < 3; i++) {
        uint32_t back = LANES(t->back[i], at);
        f16 o = f16_load(t->o[i] + at), inv = f16_load(t->inv[i] + at);
        f16 near = f16_blend(back, f16_set(low[i]), f16_set(high[i]));
        f16 far = f16_blend(back, f16_set(high[i]), f16_set(low[i]));
        enter = f16_max(f16_mul(f16_sub(near, o), inv), enter);
        leave = f16_min(f16_mul(f16_sub(far, o), inv), leave);
    }
    *entry = enter;
    return f16_less_equal(enter,
                          f16_min(f16_load(limits + at), f16_mul(leave, f16_set(BOX_EXIT_SCALE))));
}

INLINE void enter_box(tile *t, const bounds3 *box, uint32_t at) {
    const float low[3] = {box->min.x, box->min.y, box->min.z};
    const float high[3] = {box->max.x, box->max.y, box->max.z};
    f16 enter;
    uint64_t passed = pass_box(t, at, low, high, t->t_max, &enter);
    f16_store(t->floor_t + at, f16_max(enter, f16_load(t->t_min + at)));
    t->enter &= passed << at | ~((uint64_t)0xffff << at);
}

/* As make_shear. */
INLINE void shear_group(tile *t, uint32_t at) {
    f16 d[3], inv[3];
    for (int i = 0; i < 3; i++) d[i] = f16_load(t->d[i] + at), inv[i] = f16_load(t->inv[i] + at);
    uint32_t is_x = LANES(t->dominated[0], at), is_y = LANES(t->dominated[1], at);
    f16 z = f16_blend(is_x, f16_blend(is_y, d[2], d[1]), d[0]);
    f16 x = f16_blend(is_x, f16_blend(is_y, d[0], d[2]), d[1]);
    f16 y = f16_blend(is_x, f16_blend(is_y, d[1], d[0]), d[2]);
    f16_store(t->shear[0] + at, f16_div(x, z));
    f16_store(t->shear[1] + at, f16_div(y, z));
    f16_store(t->shear[2] + at, f16_blend(is_x, f16_blend(is_y, inv[2], inv[1]), inv[0]));
    for (uint32_t i = 0; i < GROUP; i++) {
        uint32_t axis = (is_y >> i & 1) + 2 * (~(is_x | is_y) >> i & 1);
        memcpy(t->axes[at + i], shear_axes[axis], sizeof t->axes[0]);
    }
}

/* o, d, t_min and t_max of the rays at `at` stand. */
INLINE void ready_group(tile *t, uint32_t at) {
    const f16 most = f16_set(FLT_MAX), zero = f16_set(0);
    f16 t_min = f16_load(t->t_min + at), t_max = f16_load(t->t_max + at), size[3];
    uint32_t sound = 0xffff, nothing = 0xffff;
    uint32_t plain = f16_equal(t_min, t_min) & f16_equal(t_max, t_max);
    for (int i = 0; i < 3; i++) {
        f16 d = f16_load(t->d[i] + at), inv = f16_div(f16_set(1), d);
        f16_store(t->inv[i] + at, inv);
        size[i] = f16_abs(d);
        sound &=
            f16_less_equal(f16_abs(f16_load(t->o[i] + at)), most) & f16_less_equal(size[i], most);
        nothing &= f16_equal(d, zero);
        plain &= f16_less_equal(f16_abs(inv), most);
        t->back[i] |= (uint64_t)f16_signs(d) << at;
    }
    uint32_t xy = f16_less(size[1], size[0]), xz = f16_less(size[2], size[0]);
    uint32_t yz = f16_less(size[2], size[1]), x = xy & xz, y = ~xy & yz;
    t->dominated[0] |= (uint64_t)x << at;
    t->dominated[1] |= (uint64_t)y << at;
    t->dominated[2] |= (uint64_t)(~(x | y) & 0xffff) << at;
    t->enter &= (uint64_t)(sound & ~nothing) << at | ~((uint64_t)0xffff << at);
    t->plain &= (uint64_t)plain << at | ~((uint64_t)0xffff << at);
    shear_group(t, at);
}

INLINE void empty_tile(tile *t, const ray *rays, uint64_t all) {
    t->all = t->enter = t->plain = all;
    t->rays = rays;
    t->far = t->walks = 0;
    for (int i = 0; i < 3; i++) t->back[i] = t->dominated[i] = 0;
}

/* in: a mesh that stands as it was given; NULL: the world. */
INLINE void load_tile(tile *t, const frozen_instance *in, const ray *rays, size_t count) {
    empty_tile(t, rays, count < TILE ? ((uint64_t)1 << count) - 1 : ~(uint64_t)0);
    t->masks = 0, t->common_mask = ~0u;
    for (uint32_t i = 0; i < TILE && i < count; i++) {
        t->masks |= rays[i].mask, t->common_mask &= rays[i].mask;
        if (in) t->enter &= ~((uint64_t)((rays[i].mask & in->mask) == 0) << i);
        t->walks |= (uint64_t)(rays[i].after_t != -INFINITY) << i;
        t->after_t[i] = rays[i].after_t;
    }
    t->plain &= ~t->walks;
    for (uint32_t at = 0; at < TILE; at += GROUP) {
        for (uint32_t i = at; i < at + GROUP; i += 8) {
            ray few[8]; /* at the end of the batch and beyond it, some ray */
            const ray *from = rays + i;
            if (i + 8 > count) {
                for (uint32_t k = 0; k < 8; k++) few[k] = rays[i + k < count ? i + k : 0];
                from = few;
            }
            f8_transpose((const float *)from, sizeof(ray) / sizeof(float), t->row[0] + i, TILE);
        }
        ready_group(t, at);
        if (in) {
            enter_box(t, &in->bounds, at);
            t->far |= find_far(t, in->mesh, at);
        }
    }
}

/* Those rays of `from`, a tile of the world, in the space of an instance with a mesh. As place_ray. */
static __attribute__((noinline)) void place_tile(tile *t, const tile *from,
                                                 const frozen_instance *in, uint64_t rays) {
    empty_tile(t, from->rays, rays);
    for (uint32_t at = 0; at < TILE; at += GROUP) {
        if (LANES(rays, at) == 0) continue;
        double o[3][GROUP], d[3][GROUP];
        for (int i = 0; i < 3; i++)
            for (uint32_t k = 0; k < GROUP; k++)
                o[i][k] = (double)from->o[i][at + k], d[i][k] = (double)from->d[i][at + k];
        for (uint32_t k = 0; k < GROUP; k++) {
            dvec3 p = transform_point(&in->to_local, (dvec3){o[0][k], o[1][k], o[2][k]});
            dvec3 v = transform_vector(&in->to_local, (dvec3){d[0][k], d[1][k], d[2][k]});
            t->o[0][at + k] = (float)p.x, t->o[1][at + k] = (float)p.y;
            t->o[2][at + k] = (float)p.z;
            t->d[0][at + k] = (float)v.x, t->d[1][at + k] = (float)v.y;
            t->d[2][at + k] = (float)v.z;
        }
        f16_store(t->t_min + at, f16_load(from->t_min + at));
        f16_store(t->t_max + at, f16_load(from->t_max + at));
        ready_group(t, at);
        t->far |= find_far(t, in->mesh, at);
    }
}
