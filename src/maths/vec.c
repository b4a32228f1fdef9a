#include "maths/vec.h"

#include <float.h>
#include <string.h>

float float_above(float x) {
    if (!(x < INFINITY)) return x;
    if (x == 0) return 0x1p-149f;
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = x > 0 ? bits + 1 : bits - 1;
    memcpy(&x, &bits, sizeof bits);
    return x;
}

float float_below(float x) { return -float_above(-x); }

/* The largest float <= x. */
static float round_down(double x) {
    float f = (float)x;
    return (double)f > x ? float_below(f) : f;
}

bounds3 bounds3_outward(dvec3 low, dvec3 high) {
    return (bounds3){{round_down(low.x), round_down(low.y), round_down(low.z)},
                     {-round_down(-high.x), -round_down(-high.y), -round_down(-high.z)}};
}

bool transform_is_identity(const transform *m) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            if (m->m[i][j] != (i == j ? 1.0f : 0.0f)) return false;
    return true;
}

transform transform_multiply(const transform *a, const transform *b) {
    transform out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            double sum = j == 3 ? (double)a->m[i][3] : 0;
            for (int k = 0; k < 3; k++) sum += (double)a->m[i][k] * (double)b->m[k][j];
            out.m[i][j] = (float)sum;
        }
    return out;
}

dtransform dtransform_from(const transform *t) {
    dtransform p;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) p.m[i][j] = (double)t->m[i][j];
    return p;
}

dtransform dtransform_multiply(const dtransform *a, const dtransform *b) {
    dtransform out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            double sum = j == 3 ? a->m[i][3] : 0;
            for (int k = 0; k < 3; k++) sum += a->m[i][k] * b->m[k][j];
            out.m[i][j] = sum;
        }
    return out;
}

transform dtransform_round(const dtransform *p) {
    transform t;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) t.m[i][j] = (float)p->m[i][j];
    return t;
}

double transform_determinant(const transform *t) {
    double m[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) m[i][j] = t->m[i][j];
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

bool transform_inverse(const transform *t, transform *out) {
    double determinant = transform_determinant(t);
    if (!isfinite(determinant) || determinant == 0) return false;
    double m[3][4], inverse[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) m[i][j] = t->m[i][j];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) { /* cofactor of (j, i): cyclic indices carry the sign */
            int r0 = (j + 1) % 3, r1 = (j + 2) % 3, c0 = (i + 1) % 3, c1 = (i + 2) % 3;
            inverse[i][j] = (m[r0][c0] * m[r1][c1] - m[r0][c1] * m[r1][c0]) / determinant;
        }
    for (int i = 0; i < 3; i++) {
        double shift = 0;
        for (int j = 0; j < 3; j++) {
            out->m[i][j] = (float)inverse[i][j];
            shift -= inverse[i][j] * m[j][3];
        }
        out->m[i][3] = (float)shift;
        for (int j = 0; j < 4; j++)
            if (!isfinite(out->m[i][j])) return false;
    }
    return true;
}

bounds3 transform_bounds(const transform *m, bounds3 b) {
    if (bounds3_is_empty(b)) return b;
    dvec3 low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < 8; i++) {
        dvec3 corner = {i & 1 ? b.max.x : b.min.x, i & 2 ? b.max.y : b.min.y,
                        i & 4 ? b.max.z : b.min.z};
        dvec3 p = transform_point(m, corner);
        low = (dvec3){double_min(low.x, p.x), double_min(low.y, p.y), double_min(low.z, p.z)};
        high = (dvec3){double_max(high.x, p.x), double_max(high.y, p.y), double_max(high.z, p.z)};
    }
    return bounds3_outward(low, high);
}

/* Outside, a coordinate of at most P is off by an ulp of P, and inside by one of each of the terms that
 * to_local sums up; four of each cover also what to_local's own entries lost. */
bounds3 transform_bounds_widened(const transform *to_world, const transform *to_local, bounds3 b) {
    bounds3 box = transform_bounds(to_world, b);
    if (bounds3_is_empty(box)) return box;
    const float sides[2][3] = {{box.min.x, box.min.y, box.min.z},
                               {box.max.x, box.max.y, box.max.z}};
    double most[3], inside[3], by[3];
    for (int i = 0; i < 3; i++)
        most[i] = double_max(fabs((double)sides[0][i]), fabs((double)sides[1][i]));
    for (int i = 0; i < 3; i++) {
        inside[i] = fabs((double)to_local->m[i][3]);
        for (int j = 0; j < 3; j++) inside[i] += fabs((double)to_local->m[i][j]) * most[j];
    }
    for (int i = 0; i < 3; i++) {
        by[i] = most[i];
        for (int j = 0; j < 3; j++) by[i] += fabs((double)to_world->m[i][j]) * inside[j];
        by[i] *= 0x1p-22;
    }
    dvec3 more = {by[0], by[1], by[2]};
    return bounds3_outward(dvec3_sub(dvec3_from(box.min), more),
                           dvec3_add(dvec3_from(box.max), more));
}
