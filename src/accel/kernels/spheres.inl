/* Spheres, eight pairs of one and a ray at once: by the operations of `solve` and `intersect` in geometry/sphere.c, in
 * double, and of trace_analytic. */

enum { PAIRS = 8 };

typedef struct sphere_pairs {
    float o[3][PAIRS], d[3][PAIRS], t_min[PAIRS], t_max[PAIRS], floor_t[PAIRS], after_t[PAIRS];
    float center[3][PAIRS], radius[PAIRS];
    float t[PAIRS]; /* of the hit */
    void *of[PAIRS];
    unsigned behind; /* pairs whose sphere has a higher number than what the ray walks on from */
    uint32_t count;
} sphere_pairs;

INLINE void start_pairs(sphere_pairs *s) { s->count = s->behind = 0; }

/* floor_t: where the ray enters the sphere's box. */
INLINE void add_pair(sphere_pairs *s, const frozen_outline *sphere, const ray *r, float floor_t) {
    const float o[3] = {r->o.x, r->o.y, r->o.z}, d[3] = {r->d.x, r->d.y, r->d.z};
    uint32_t to = s->count++;
    for (int axis = 0; axis < 3; axis++) {
        s->o[axis][to] = o[axis], s->d[axis][to] = d[axis];
        s->center[axis][to] = sphere->center[axis];
    }
    s->radius[to] = sphere->radius;
    s->t_min[to] = r->t_min, s->t_max[to] = r->t_max;
    s->floor_t[to] = floor_t, s->after_t[to] = r->after_t;
    s->behind |= (unsigned)(sphere->first > r->after_instance) << to;
}

/* What a hit depends on beside the two roots. */
typedef struct sphere_ranges {
    f8 t_min, t_max, floor_t, after_t;
    unsigned behind;
} sphere_ranges;

INLINE m8 is_inside(const sphere_ranges *range, f8 t) {
    return m8_and(f8_less(range->t_min, t), f8_less(t, range->t_max));
}

/* As comes_after. */
INLINE unsigned is_after(const sphere_ranges *range, f8 t) {
    return m8_bits(f8_less(range->after_t, t)) |
           (m8_bits(f8_equal(range->after_t, t)) & range->behind);
}

/* d: the rays' directions; f: from their origins to the centres; r: the radii. Returns the pairs in `lanes` that meet
 * within the ray's range; t is where. */
INLINE unsigned solve_spheres(const d8 d[3], const d8 f[3], d8 r, const sphere_ranges *range,
                              unsigned lanes, float t[PAIRS]) {
    d8 n[3], zero = d8_set(0), rr = d8_mul(r, r);
    d8 a = d8_add(d8_add(d8_mul(d[0], d[0]), d8_mul(d[1], d[1])), d8_mul(d[2], d[2]));
    d8 b = d8_add(d8_add(d8_mul(f[0], d[0]), d8_mul(f[1], d[1])), d8_mul(f[2], d[2]));
    d8 closest = d8_div(b, a);
    for (int i = 0; i < 3; i++) n[i] = d8_sub(f[i], d8_mul(d[i], closest));
    d8 apart = d8_add(d8_add(d8_mul(n[0], n[0]), d8_mul(n[1], n[1])), d8_mul(n[2], n[2]));
    d8 discriminant = d8_sub(rr, apart);
    lanes &= d8_less(zero, a) & d8_less_equal(zero, discriminant);
    if (lanes == 0) return 0;
    d8 c = d8_add(d8_add(d8_mul(f[0], f[0]), d8_mul(f[1], f[1])), d8_mul(f[2], f[2]));
    c = d8_sub(c, rr);
    d8 root = d8_sqrt(d8_mul(a, discriminant));
    d8 q = d8_blend(d8_less(zero, b), d8_sub(b, root), d8_add(b, root));
    d8 one = d8_div(q, a), other = d8_blend(d8_equal(q, zero), d8_div(c, q), one);
    float roots[2][PAIRS];
    d8_store_floats(roots[0], d8_min(one, other));
    d8_store_floats(roots[1], d8_max(one, other));
    f8 near = f8_load(roots[0]), far = f8_load(roots[1]);
    f8 first = f8_max(range->floor_t, near), second = f8_max(range->floor_t, far);
    unsigned has_first = m8_bits(is_inside(range, near)),
             has_second = m8_bits(is_inside(range, far));
    unsigned left = m8_bits(is_inside(range, first)) & ~is_after(range, first); /* behind the ray */
    unsigned takes = m8_bits(is_inside(range, first)) & is_after(range, first) & has_first;
    unsigned goes_on = ~has_first | (left & m8_bits(f8_less(near, far)));
    unsigned takes_second =
        goes_on & has_second & m8_bits(is_inside(range, second)) & is_after(range, second);
    f8_store(t, f8_blend(takes, second, first));
    return lanes & (takes | takes_second);
}

INLINE unsigned meet_spheres(sphere_pairs *s) {
    d8 d[3], f[3];
    for (uint32_t i = s->count; i < PAIRS; i++) s->radius[i] = -1, s->d[0][i] = 0;
    for (int i = 0; i < 3; i++) {
        d[i] = d8_from_floats(s->d[i]);
        f[i] = d8_sub(d8_from_floats(s->center[i]), d8_from_floats(s->o[i]));
    }
    const sphere_ranges range = {f8_load(s->t_min), f8_load(s->t_max), f8_load(s->floor_t),
                                 f8_load(s->after_t), s->behind};
    return solve_spheres(d, f, d8_from_floats(s->radius), &range, (1u << s->count) - 1, s->t);
}

/* Eight rays of a tile, from `at` on, and one sphere. */
INLINE unsigned meet_one_sphere(const tile *t, uint32_t at, const frozen_outline *sphere,
                                const float floor_t[TILE], unsigned lanes, float met[PAIRS]) {
    d8 d[3], f[3];
    for (int i = 0; i < 3; i++) {
        d[i] = d8_from_floats(t->d[i] + at);
        f[i] = d8_sub(d8_set((double)sphere->center[i]), d8_from_floats(t->o[i] + at));
    }
    sphere_ranges range = {f8_load(t->t_min + at), f8_load(t->t_max + at), f8_load(floor_t + at),
                           f8_load(t->after_t + at), 0};
    for (unsigned i = lanes & (unsigned)(t->walks >> at); i != 0; i &= i - 1)
        if (sphere->first > t->rays[at + (uint32_t)__builtin_ctz(i)].after_instance)
            range.behind |= i & -i;
    return solve_spheres(d, f, d8_set((double)sphere->radius), &range, lanes, met);
}
