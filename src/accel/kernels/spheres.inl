/* Spheres, eight pairs of one and a ray at once: by the operations of `solve` and `intersect` in geometry/sphere.c,
 * in double. */

enum { PAIRS = 8 };

typedef struct sphere_pairs {
    float o[3][PAIRS], d[3][PAIRS], t_min[PAIRS], t_max[PAIRS], floor_t[PAIRS];
    float center[3][PAIRS], radius[PAIRS];
    float t[PAIRS]; /* of the hit */
    void *of[PAIRS];
    uint32_t count;
} sphere_pairs;

INLINE void add_sphere(sphere_pairs *s, const frozen_outline *sphere) {
    for (int axis = 0; axis < 3; axis++) s->center[axis][s->count] = sphere->center[axis];
    s->radius[s->count++] = sphere->radius;
}

/* The pairs that meet within the ray's range; t is where. */
INLINE unsigned meet_spheres(sphere_pairs *s) {
    d8 d[3], f[3], n[3], zero = d8_set(0);
    for (uint32_t i = s->count; i < PAIRS; i++) s->radius[i] = -1, s->d[0][i] = 0;
    for (int i = 0; i < 3; i++) {
        d[i] = d8_from_floats(s->d[i]);
        f[i] = d8_sub(d8_from_floats(s->center[i]), d8_from_floats(s->o[i]));
    }
    d8 r = d8_from_floats(s->radius), rr = d8_mul(r, r);
    d8 a = d8_add(d8_add(d8_mul(d[0], d[0]), d8_mul(d[1], d[1])), d8_mul(d[2], d[2]));
    d8 b = d8_add(d8_add(d8_mul(f[0], d[0]), d8_mul(f[1], d[1])), d8_mul(f[2], d[2]));
    d8 closest = d8_div(b, a);
    for (int i = 0; i < 3; i++) n[i] = d8_sub(f[i], d8_mul(d[i], closest));
    d8 apart = d8_add(d8_add(d8_mul(n[0], n[0]), d8_mul(n[1], n[1])), d8_mul(n[2], n[2]));
    d8 discriminant = d8_sub(rr, apart);
    unsigned lanes = d8_less(zero, a) & d8_less_equal(zero, discriminant) & ((1u << s->count) - 1);
    if (lanes == 0) return 0;
    d8 c = d8_add(d8_add(d8_mul(f[0], f[0]), d8_mul(f[1], f[1])), d8_mul(f[2], f[2]));
    c = d8_sub(c, rr);
    d8 root = d8_sqrt(d8_mul(a, discriminant));
    d8 q = d8_blend(d8_less(zero, b), d8_sub(b, root), d8_add(b, root));
    d8 one = d8_div(q, a), other = d8_blend(d8_equal(q, zero), d8_div(c, q), one);
    float roots[2][PAIRS];
    d8_store_floats(roots[0], d8_min(one, other));
    d8_store_floats(roots[1], d8_max(one, other));
    f8 t_min = f8_load(s->t_min), t_max = f8_load(s->t_max);
    f8 near = f8_load(roots[0]), far = f8_load(roots[1]);
    m8 first = m8_and(f8_less(t_min, near), f8_less(near, t_max));
    m8 second = m8_and(f8_less(t_min, far), f8_less(far, t_max));
    f8 met = f8_max(f8_load(s->floor_t), f8_blend(m8_bits(first), far, near));
    f8_store(s->t, met);
    m8 inside = m8_and(f8_less(t_min, met), f8_less(met, t_max));
    return lanes & m8_bits(m8_and(inside, m8_or(first, second)));
}
