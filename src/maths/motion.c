#include "maths/motion.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "maths/functions.h"

typedef struct matrix3 {
    double m[3][3];
} matrix3;

static matrix3 linear_part(const transform *t) {
    matrix3 a;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) a.m[i][j] = (double)t->m[i][j];
    return a;
}

static double determinant(const matrix3 *a) {
    const double(*m)[3] = a->m;
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* The inverse's transpose. */
static matrix3 inverse_transpose(const matrix3 *a) {
    double d = determinant(a);
    matrix3 out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int r0 = (i + 1) % 3, r1 = (i + 2) % 3, c0 = (j + 1) % 3, c1 = (j + 2) % 3;
            out.m[i][j] = (a->m[r0][c0] * a->m[r1][c1] - a->m[r0][c1] * a->m[r1][c0]) / d;
        }
    return out;
}

static matrix3 multiply(const matrix3 *a, const matrix3 *b) {
    matrix3 out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out.m[i][j] =
                a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] + a->m[i][2] * b->m[2][j];
    return out;
}

/* ---- a linear part as a turn after a stretch ---- */

typedef struct quaternion {
    double x, y, z, w;
} quaternion;

typedef struct decomposed {
    quaternion turn;
    matrix3 stretch; /* symmetric; negative where the transform mirrors */
} decomposed;

/* Shepperd's method: from the largest of the four, so that nothing is divided by a small number. */
static quaternion quaternion_from(const matrix3 *r) {
    const double(*m)[3] = r->m;
    double trace = m[0][0] + m[1][1] + m[2][2];
    if (trace > 0) {
        double s = 2 * sqrt(trace + 1);
        return (quaternion){(m[2][1] - m[1][2]) / s, (m[0][2] - m[2][0]) / s,
                            (m[1][0] - m[0][1]) / s, s / 4};
    }
    int i = m[0][0] > m[1][1] ? (m[0][0] > m[2][2] ? 0 : 2) : (m[1][1] > m[2][2] ? 1 : 2);
    int j = (i + 1) % 3, k = (i + 2) % 3;
    double s = 2 * sqrt(1 + m[i][i] - m[j][j] - m[k][k]), v[3];
    v[i] = s / 4;
    v[j] = (m[j][i] + m[i][j]) / s;
    v[k] = (m[k][i] + m[i][k]) / s;
    return (quaternion){v[0], v[1], v[2], (m[k][j] - m[j][k]) / s};
}

static matrix3 matrix_from(quaternion q) {
    double x = q.x, y = q.y, z = q.z, w = q.w;
    return (matrix3){{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                      {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                      {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

/* Polar decomposition: the nearest rotation is the limit of R' = (R + R^-T) / 2 (Shoemake and Duff,
 * Matrix Animation and Polar Decomposition, Graphics Interface 1992). */
static decomposed decompose(const matrix3 *a) {
    matrix3 r = *a;
    for (int step = 0; step < 200; step++) {
        matrix3 other = inverse_transpose(&r);
        double change = 0;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                double next = (r.m[i][j] + other.m[i][j]) / 2, by = fabs(next - r.m[i][j]);
                change = double_max(change, by);
                r.m[i][j] = next;
            }
        if (change < 1e-15) break;
    }
    if (determinant(&r) < 0)
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) r.m[i][j] = -r.m[i][j];
    matrix3 back;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) back.m[i][j] = r.m[j][i];
    return (decomposed){quaternion_from(&r), multiply(&back, a)};
}

static double quaternion_dot(quaternion a, quaternion b) {
    return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}

/* Shoemake, Animating Rotation with Quaternion Curves, SIGGRAPH 1985. */
static quaternion slerp(quaternion a, quaternion b, double s) {
    double cosine = quaternion_dot(a, b), sign = cosine < 0 ? -1 : 1;
    cosine *= sign;
    double p = 1 - s, q = s;
    if (cosine < 0.99999) {
        double angle = fn_acos(cosine), sine = fn_sin(angle);
        p = fn_sin((1 - s) * angle) / sine;
        q = fn_sin(s * angle) / sine;
    }
    q *= sign;
    quaternion c = {p * a.x + q * b.x, p * a.y + q * b.y, p * a.z + q * b.z, p * a.w + q * b.w};
    double length = sqrt(quaternion_dot(c, c));
    return (quaternion){c.x / length, c.y / length, c.z / length, c.w / length};
}

/* ---- keys ---- */

snell_status motion_check(const motion_key *keys, size_t count, const char *what) {
    if (count == 0 || keys == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: a motion needs a key", what);
    if (count > 1u << 20)
        return error_set(SNELL_ERR_ARGUMENT, "at most 1048576", "%s: a motion of %zu keys", what,
                         count);
    for (size_t i = 0; i < count; i++) {
        transform inverse;
        if (!isfinite(keys[i].time))
            return error_set(SNELL_ERR_ARGUMENT, "seconds", "%s: the time of key %zu is not finite",
                             what, i + 1);
        if (i > 0 && !(keys[i].time > keys[i - 1].time))
            return error_set(SNELL_ERR_ARGUMENT, "put the keys in the order of their times",
                             "%s: key %zu is not later than the one before", what, i + 1);
        if (!transform_inverse(&keys[i].transform, &inverse))
            return error_set(SNELL_ERR_ARGUMENT, "scales must not be 0",
                             "%s: the transform of key %zu cannot be inverted", what, i + 1);
    }
    return SNELL_OK;
}

static bool same_linear(const transform *a, const transform *b) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (a->m[i][j] != b->m[i][j]) return false;
    return true;
}

static void take(const transform *t, double out[3][4]) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) out[i][j] = (double)t->m[i][j];
}

static double mix(double a, double b, double s) { return a + (b - a) * s; }

static void between(const transform *from, const transform *to, double s, double out[3][4]) {
    take(from, out);
    for (int i = 0; i < 3; i++) out[i][3] = mix(out[i][3], (double)to->m[i][3], s);
    if (same_linear(from, to)) return;
    matrix3 a = linear_part(from), b = linear_part(to);
    decomposed p = decompose(&a), q = decompose(&b);
    matrix3 turn = matrix_from(slerp(p.turn, q.turn, s)), stretch;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) stretch.m[i][j] = mix(p.stretch.m[i][j], q.stretch.m[i][j], s);
    matrix3 whole = multiply(&turn, &stretch);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) out[i][j] = whole.m[i][j];
}

/* The last key that is not after the time, 0 where all are. */
static size_t find_key(const motion_key *keys, size_t count, double time) {
    size_t low = 0, high = count - 1;
    while (low < high) {
        size_t middle = low + (high - low + 1) / 2;
        if ((double)keys[middle].time <= time)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

void motion_interpolate(const motion_key *keys, size_t count, double time, double out[3][4]) {
    size_t at = find_key(keys, count, time);
    double from = (double)keys[at].time;
    if (at + 1 == count || time <= from) {
        take(&keys[at].transform, out);
        return;
    }
    double s = (time - from) / ((double)keys[at + 1].time - from);
    between(&keys[at].transform, &keys[at + 1].transform, s, out);
}

/* ---- steps ---- */

static transform transform_between(const motion_key *a, const motion_key *b, double s) {
    transform t;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            t.m[i][j] = (float)mix((double)a->transform.m[i][j], (double)b->transform.m[i][j], s);
    return t;
}

/* Whether a cubic keeps clear of 0 on [0, 1]: as soon as its Bernstein coefficients have one sign it
 * does; else each half is asked. */
static bool keeps_sign(double a, double b, double c, double d, int depth) {
    if (a > 0 && b > 0 && c > 0 && d > 0) return true;
    if (a < 0 && b < 0 && c < 0 && d < 0) return true;
    if (depth == 0 || !(a * d > 0)) return false;
    double ab = (a + b) / 2, bc = (b + c) / 2, cd = (c + d) / 2, abc = (ab + bc) / 2,
           bcd = (bc + cd) / 2, middle = (abc + bcd) / 2;
    return keeps_sign(a, ab, abc, middle, depth - 1) && keeps_sign(middle, bcd, cd, d, depth - 1);
}

/* The determinant between two steps is a cubic; its Bernstein coefficients from four of its values. */
static bool stays_regular(const transform *from, const transform *to) {
    matrix3 a = linear_part(from), b = linear_part(to);
    double f[4];
    for (int k = 0; k < 4; k++) {
        matrix3 at;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) at.m[i][j] = mix(a.m[i][j], b.m[i][j], k / 3.0);
        f[k] = determinant(&at);
    }
    double second = (-5 * f[0] + 18 * f[1] - 9 * f[2] + 2 * f[3]) / 6;
    double third = (2 * f[0] - 9 * f[1] + 18 * f[2] - 5 * f[3]) / 6;
    return keeps_sign(f[0], second, third, f[3], 24);
}

/* A stretch between two equal turns is linear as it is. */
static bool turns(const transform *from, const transform *to) {
    if (same_linear(from, to)) return false;
    matrix3 a = linear_part(from), b = linear_part(to);
    return fabs(quaternion_dot(decompose(&a).turn, decompose(&b).turn)) < 1 - 1e-14;
}

static snell_status append_step(const motion_key *keys, size_t count, double time, motion *out,
                                size_t *capacity) {
    double m[3][4];
    if (out->count == MOTION_STEPS_MAX)
        return error_set(SNELL_ERR_ARGUMENT,
                         "fewer keys, or a camera whose shutter sees few of them",
                         "a motion of more than %d linear steps", MOTION_STEPS_MAX);
    if (!ARRAY_GROW(out->steps, out->count, *capacity, 1)) return error_no_memory();
    motion_interpolate(keys, count, time, m);
    motion_key *step = &out->steps[out->count];
    step->time = (float)time;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) step->transform.m[i][j] = (float)m[i][j];
    if (out->count == 0 || step->time > out->steps[out->count - 1].time) out->count++;
    return SNELL_OK;
}

/* The steps of one motion: of each turn MOTION_STEPS, of what is linear the keys alone. */
static snell_status append_steps(const motion_key *keys, size_t count, double low, double high,
                                 motion *out) {
    size_t capacity = 0;
    snell_status status = append_step(keys, count, low, out, &capacity);
    for (double at = low; at < high && !status;) {
        size_t key = find_key(keys, count, at);
        double end = double_min(high, (double)keys[key + 1].time);
        int pieces = turns(&keys[key].transform, &keys[key + 1].transform) ? MOTION_STEPS : 1;
        for (int i = 1; i <= pieces && !status; i++)
            status = append_step(keys, count, i == pieces ? end : mix(at, end, (double)i / pieces),
                                 out, &capacity);
        at = end;
    }
    if (status) return status;
    motion_key *fitting = memory_resize(out->steps, out->count, sizeof *out->steps);
    if (fitting) out->steps = fitting;
    return SNELL_OK;
}

snell_status motion_prepare(const motion_key *keys, size_t count, double open, double close,
                            motion *out) {
    double first = (double)keys[0].time, last = (double)keys[count - 1].time;
    double low = double_min(double_max(open, first), last),
           high = double_max(double_min(close, last), first);
    *out = (motion){.keys = keys, .key_count = count};
    snell_status status = append_steps(keys, count, low, high, out);
    if (status) {
        motion_free(out);
        return status;
    }
    for (uint32_t i = 0; i + 1 < out->count; i++) {
        if (stays_regular(&out->steps[i].transform, &out->steps[i + 1].transform)) continue;
        double when = (double)out->steps[i].time;
        motion_free(out);
        return error_set(SNELL_ERR_ARGUMENT, "a mirrored key cannot follow one that is not",
                         "a motion flattens what it moves, at about %.4g s", when);
    }
    return SNELL_OK;
}

void motion_free(motion *m) {
    free(m->steps);
    *m = (motion){0};
}

transform motion_transform(const motion *m, float time) {
    size_t at = find_key(m->steps, m->count, (double)time);
    const motion_key *from = &m->steps[at];
    if (at + 1 == m->count || !(time > from->time)) return from->transform;
    double s = ((double)time - (double)from->time) / ((double)from[1].time - (double)from->time);
    return transform_between(from, from + 1, s);
}

transform motion_by_keys(const motion *m, float time) {
    double at[3][4];
    transform t;
    motion_interpolate(m->keys, m->key_count, (double)time, at);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) t.m[i][j] = (float)at[i][j];
    return t;
}

bool motion_at(const motion *m, float time, transform *to_world, transform *to_local) {
    *to_world = motion_transform(m, time);
    return transform_inverse(to_world, to_local);
}

bounds3 motion_bounds(const motion *m, bounds3 b) {
    bounds3 all = bounds3_empty();
    if (bounds3_is_empty(b)) return b;
    for (uint32_t i = 0; i < m->count; i++)
        all = bounds3_union(all, transform_bounds(&m->steps[i].transform, b));
    double reach = 0; /* the largest coordinate that a rounding is relative to */
    const float sides[] = {all.min.x, all.min.y, all.min.z, all.max.x, all.max.y, all.max.z};
    for (int i = 0; i < 6; i++) reach = double_max(reach, fabs((double)sides[i]));
    double by = reach * 0x1p-21;
    dvec3 more = {by, by, by};
    return bounds3_outward(dvec3_sub(dvec3_from(all.min), more),
                           dvec3_add(dvec3_from(all.max), more));
}
