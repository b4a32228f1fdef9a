#include "geometry/surface.h"

#include "base/error.h"
#include "maths/functions.h"

#include <string.h>

/* The next float if `up` is 1, f itself if it is 0. To floats as integers, that of -0 is -1. */
static float raised(float f, int up) {
    int32_t bits;
    memcpy(&bits, &f, sizeof bits);
    bits ^= bits >> 31 & INT32_MAX;
    bits += up;
    bits ^= bits >> 31 & INT32_MAX;
    memcpy(&f, &bits, sizeof bits);
    return f;
}

/* x, which is not before `from`, rounded to float, strictly beyond `from` in the direction of `step`; to nearest if
 * step is 0. Twice at most: from the nearest float to one that is not before x, and on from -0 or from `from`. Without
 * branches, which nothing could predict. */
static float round_beyond(double x, double from, double step) {
    double side = step < 0 ? -1 : 1, goal = side * x, start = side * from;
    int moves = fabs(step) > 0;
    float f = (float)goal;
    f = raised(f, moves & (((double)f < goal) | ((double)f <= start)));
    f = raised(f, moves & ((double)f <= start));
    return (float)side * f;
}

vec3 surface_offset_origin(const surface *s, double side) {
    return surface_offset_point(s->p, s->n, s->error, side);
}

vec3 surface_offset_point(dvec3 p, dvec3 n, double error, double side) {
    double reach = side > 0 ? error : -error;
    double sign = side > 0 ? 1 : -1;
    return (vec3){round_beyond(p.x + reach * n.x, p.x, sign * n.x),
                  round_beyond(p.y + reach * n.y, p.y, sign * n.y),
                  round_beyond(p.z + reach * n.z, p.z, sign * n.z)};
}

static double abs_dot(dvec3 a, dvec3 b) {
    return fabs(a.x * b.x) + fabs(a.y * b.y) + fabs(a.z * b.z);
}

void surface_to_world(surface *s, const transform *to_world, const transform *to_local) {
    dvec3 local = s->p, p = transform_point(to_world, local);
    dvec3 off = dvec3_sub(transform_point(to_local, p), local);
    p = dvec3_sub(p, transform_vector(to_world, off));
    off = dvec3_sub(transform_point(to_local, p), local);

    /* One ulp instead of a half: the origin lies beyond p, where floats may be twice as far apart.
     * The second term is the double arithmetic of transforming the origin. */
    dvec3 origin_terms = {fabs(local.x), fabs(local.y), fabs(local.z)};
    double rounding = 2 * FLOAT_EPSILON * abs_dot(s->n, origin_terms) + 0x1p-149;
    dvec3 shift = {to_local->m[0][3], to_local->m[1][3], to_local->m[2][3]};
    rounding += 8 * DOUBLE_EPSILON * (abs_dot(s->n, shift) + abs_dot(s->n, origin_terms));
    /* The origin is rounded in the world too; seen from the shape that is a shift of at most the
     * Frobenius norm of to_local times as much, for its bend and for its own length. */
    double norm_squared = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            norm_squared += (double)to_local->m[i][j] * (double)to_local->m[i][j];
    rounding += surface_shift_error_scaled(p, s->curvature, norm_squared);
    double local_error = s->error + abs_dot(s->n, off) + rounding;

    dvec3 n = transform_normal(to_local, s->n);
    double length = dvec3_length(n);
    s->error = length > 0 ? local_error / length : local_error;
    s->p = p;
    s->n = dvec3_normalize(n);
    s->ns = dvec3_normalize(transform_normal(to_local, s->ns));
    double cosine = dvec3_dot(s->ns, s->n);
    if (!(cosine > 0)) s->ns = s->n;
}

void surface_globe(surface *s, dvec3 n, double radius) {
    double height = n.y < -1 ? -1 : n.y > 1 ? 1 : n.y;
    s->u = 0.5 + fn_atan2(n.x, n.z) / (2 * PI);
    s->v = 1 - fn_acos(height) / PI;
    double r = radius, ring = sqrt(n.x * n.x + n.z * n.z);
    if (!(ring > 0)) return; /* a pole: u has no direction */
    s->dpdu = (dvec3){2 * PI * r * n.z, 0, -2 * PI * r * n.x};
    s->dpdv = dvec3_scale((dvec3){-height * n.x / ring, ring, -height * n.z / ring}, PI * r);
}

void surface_fold(dvec3 n, float *u, float *v) {
    double sum = fabs(n.x) + fabs(n.y) + fabs(n.z), x = n.x / sum, y = n.y / sum;
    if (n.z < 0) {
        double over = (1 - fabs(y)) * (x < 0 ? -1 : 1);
        y = (1 - fabs(x)) * (y < 0 ? -1 : 1);
        x = over;
    }
    *u = (float)x;
    *v = (float)y;
}

dvec3 surface_unfold(float u, float v) {
    dvec3 n = {u, v, 1 - fabs((double)u) - fabs((double)v)};
    if (n.z < 0) {
        double over = (1 - fabs(n.y)) * (n.x < 0 ? -1 : 1);
        n.y = (1 - fabs(n.x)) * (n.y < 0 ? -1 : 1);
        n.x = over;
    }
    return dvec3_normalize(n);
}

snell_status surface_check_box(const char *type, vec3 min, vec3 max) {
    const float low[3] = {min.x, min.y, min.z}, high[3] = {max.x, max.y, max.z};
    for (int i = 0; i < 3; i++)
        if (!(low[i] < high[i]))
            return error_set(SNELL_ERR_ARGUMENT,
                             "every coordinate of 'min' must be the smaller one",
                             "%s: 'min' %c is %g and 'max' %c is %g", type, "xyz"[i],
                             (double)low[i], "xyz"[i], (double)high[i]);
    return SNELL_OK;
}

bool surface_accept_either(const local_ray *beam, const double t[2], const dvec3 at[2],
                           hit *found) {
    for (int i = 0; i < 2; i++) {
        if (!surface_accept(beam, t[i], &found->t)) continue;
        surface_fold(at[i], &found->u, &found->v);
        return true;
    }
    return false;
}
