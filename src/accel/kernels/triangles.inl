/* Eight triangles: Woop, Benthin, Wald, Watertight Ray/Triangle Intersection, JCGT 2(1), 2013.
 * Deviations: where the float determinant could have lost its precision to under- or overflow, and
 * where an edge function is 0, everything from the edge functions on is done in double, whose
 * products of floats are exact; and the sign decides before it is rounded back. */

typedef struct shear {
    float o[3], x, y, z; /* o in the order of k */
    uint32_t k[3];       /* k[2] is the axis of the largest |d| */
} shear;

/* By the axis of the largest |d|. */
static const uint8_t shear_axes[3][3] = {{1, 2, 0}, {2, 0, 1}, {0, 1, 2}};

INLINE void make_shear(shear *s, const prepared *p) {
    float ax = fabsf(p->d[0]), ay = fabsf(p->d[1]), az = fabsf(p->d[2]);
    uint32_t kz = ax > ay ? (ax > az ? 0 : 2) : (ay > az ? 1 : 2);
    uint32_t kx = shear_axes[kz][0], ky = shear_axes[kz][1];
    for (int i = 0; i < 3; i++) {
        s->k[i] = shear_axes[kz][i];
        s->o[i] = p->o[s->k[i]];
    }
    s->x = p->d[kx] / p->d[kz];
    s->y = p->d[ky] / p->d[kz];
    s->z = p->inv[kz];
}

/* t; the weights of vertices 1 and 2, times det; lanes that are to be solved in double. */
typedef struct candidates {
    f8 t, weight[2], det;
    unsigned in_double;
} candidates;

/* Lanes whose triangles the ray's line meets no farther off than `limit`, as far as floats tell. */
INLINE unsigned test_triangles(const shear *s, const triangle_block *b, float limit,
                               candidates *c) {
    f8 x[3], y[3], z[3]; /* of each vertex, sheared: the ray is the z axis */
    for (int i = 0; i < 3; i++) {
        z[i] = f8_sub(f8_load(b->vertex[i][s->k[2]]), f8_set(s->o[2]));
        x[i] = f8_sub(f8_sub(f8_load(b->vertex[i][s->k[0]]), f8_set(s->o[0])),
                      f8_mul(f8_set(s->x), z[i]));
        y[i] = f8_sub(f8_sub(f8_load(b->vertex[i][s->k[1]]), f8_set(s->o[1])),
                      f8_mul(f8_set(s->y), z[i]));
    }
    f8 u = f8_sub(f8_mul(x[2], y[1]), f8_mul(y[2], x[1]));
    f8 v = f8_sub(f8_mul(x[0], y[2]), f8_mul(y[0], x[2]));
    f8 w = f8_sub(f8_mul(x[1], y[0]), f8_mul(y[1], x[0]));
    f8 zero = f8_set(0), det = f8_add(f8_add(u, v), w), size = f8_abs(det);
    m8 apart =
        m8_and(f8_less(f8_min(f8_min(u, v), w), zero), f8_less(zero, f8_max(f8_max(u, v), w)));
    m8 edge = m8_or(m8_or(f8_equal(u, zero), f8_equal(v, zero)), f8_equal(w, zero));
    m8 sound = m8_and(f8_less(f8_set(1e-30f), size), f8_less(size, f8_set(1e30f)));
    for (int i = 0; i < 3; i++) z[i] = f8_mul(f8_set(s->z), z[i]);
    f8 sum = f8_add(f8_add(f8_mul(u, z[0]), f8_mul(v, z[1])), f8_mul(w, z[2]));
    c->t = f8_div(sum, det);
    c->weight[0] = v, c->weight[1] = w, c->det = det;
    c->in_double = (m8_bits(edge) | ~m8_bits(sound)) & 0xff;
    return ~m8_bits(apart) & (m8_bits(f8_less_equal(c->t, f8_set(limit))) | c->in_double);
}

/* One triangle in double: t, and the weights of vertices 1 and 2. False: missed, and nothing of use is written. */
static __attribute__((noinline)) bool solve_in_double(const shear *s, const triangle_block *b,
                                                      unsigned lane, float *t, float weight[2]) {
    double x[3], y[3], z[3];
    for (int i = 0; i < 3; i++) { /* in float, as above */
        float depth = b->vertex[i][s->k[2]][lane] - s->o[2];
        x[i] = (double)((b->vertex[i][s->k[0]][lane] - s->o[0]) - s->x * depth);
        y[i] = (double)((b->vertex[i][s->k[1]][lane] - s->o[1]) - s->y * depth);
        z[i] = (double)(s->z * depth);
    }
    double w[3];
    weight[0] = weight[1] = 0;
    for (int i = 0; i < 3; i++) { /* the edge opposite to vertex i */
        int from = (i + 1) % 3, to = (i + 2) % 3;
        w[i] = x[to] * y[from] - y[to] * x[from];
    }
    if ((w[0] < 0 || w[1] < 0 || w[2] < 0) && (w[0] > 0 || w[1] > 0 || w[2] > 0)) return false;
    double det = (w[0] + w[1]) + w[2];
    if (!(det != 0)) return false;
    *t = (float)(((w[0] * z[0] + w[1] * z[1]) + w[2] * z[2]) / det);
    weight[0] = (float)(w[1] / det);
    weight[1] = (float)(w[2] / det);
    return true;
}

/* Where the ray enters and leaves the triangles' own boxes, wider by the margin unless that is NULL. */
INLINE void cross_own_boxes(const prepared *p, const float *margin, const triangle_block *b,
                            f8 *enter, f8 *leave) {
    f8 low = f8_set(p->t_min), high = f8_set(INFINITY);
    for (int i = 0; i < 3; i++) {
        f8 v0 = f8_load(b->vertex[0][i]), v1 = f8_load(b->vertex[1][i]),
           v2 = f8_load(b->vertex[2][i]);
        f8 least = f8_min(f8_min(v0, v1), v2), most = f8_max(f8_max(v0, v1), v2);
        f8 inv = f8_set(p->inv[i]), near_o = f8_set(p->o[i]), far_o = near_o;
        if (margin) {
            near_o = f8_set(p->o[i] + ahead(p, margin, i));
            far_o = f8_set(p->o[i] - ahead(p, margin, i));
        }
        low = f8_max(f8_mul(f8_sub(f8_select(inv, least, most), near_o), inv), low);
        high = f8_min(f8_mul(f8_sub(f8_select(inv, most, least), far_o), inv), high);
    }
    *enter = low;
    *leave = f8_mul(high, f8_set(BOX_EXIT_SCALE));
}

/* Lanes whose own box, widened, the ray passes, and whose box as it is does not lie behind t_min; and
 * the entries that t is raised to: those of the boxes as they are, so that faces of one plane are met at
 * one t. Where only the wider box is passed, that is where the box as it is would be left. Nearly always
 * the box as it is is passed, and then so is the wider one; or it lies behind, as that of the triangle that
 * the ray starts from. start: the ray has not left the wider box before it. */
INLINE unsigned test_own_boxes(const prepared *p, const bvh_tree *mesh, const triangle_block *b,
                               float start, unsigned lanes, f8 *entry) {
    f8 enter, leave, t_max = f8_set(p->t_max);
    cross_own_boxes(p, NULL, b, &enter, &leave);
    *entry = enter;
    lanes &= m8_bits(f8_less_equal(f8_set(p->t_min), leave));
    unsigned passed = m8_bits(f8_less_equal(f8_max(enter, f8_set(start)), f8_min(t_max, leave)));
    if (__builtin_expect((lanes & ~passed) == 0, 1)) return lanes;
    float margin[3];
    f8 enter_wide, leave_wide;
    find_margin(p, mesh, margin);
    cross_own_boxes(p, margin, b, &enter_wide, &leave_wide);
    *entry = f8_max(f8_min(enter, leave), enter_wide);
    enter_wide = f8_max(enter_wide, f8_set(start));
    return lanes & m8_bits(f8_less_equal(enter_wide, f8_min(t_max, leave_wide)));
}
