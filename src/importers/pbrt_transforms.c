/* pbrt's transforms: matrices, and the directives that change the current one. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "importers/pbrt.h"
#include "maths/functions.h"

/* ---- matrices ---- */

double pbrt_determinant(const dtransform *m) {
    const double(*a)[4] = m->m;
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
           a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
}

bool pbrt_inverse(const dtransform *m, dtransform *out) {
    double det = pbrt_determinant(m);
    if (!(fabs(det) > 1e-60 && fabs(det) < 1e60)) return false;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            out->m[c][r] = (m->m[r1][c1] * m->m[r2][c2] - m->m[r1][c2] * m->m[r2][c1]) / det;
        }
    for (int r = 0; r < 3; r++)
        out->m[r][3] =
            -(out->m[r][0] * m->m[0][3] + out->m[r][1] * m->m[1][3] + out->m[r][2] * m->m[2][3]);
    return true;
}

dvec3 pbrt_vector(const dtransform *m, dvec3 v) {
    return (dvec3){m->m[0][0] * v.x + m->m[0][1] * v.y + m->m[0][2] * v.z,
                   m->m[1][0] * v.x + m->m[1][1] * v.y + m->m[1][2] * v.z,
                   m->m[2][0] * v.x + m->m[2][1] * v.y + m->m[2][2] * v.z};
}

dvec3 pbrt_point(const dtransform *m, dvec3 v) {
    return dvec3_add(pbrt_vector(m, v), (dvec3){m->m[0][3], m->m[1][3], m->m[2][3]});
}

dtransform pbrt_to_world(const pbrt *p, int which) {
    dtransform out = p->state.ctm[which];
    for (int c = 0; c < 4; c++) out.m[0][c] *= p->flip;
    return out;
}

bool pbrt_is_animated(const pbrt *p) {
    return memcmp(&p->state.ctm[0], &p->state.ctm[1], sizeof p->state.ctm[0]) != 0;
}

static snell_status check_finite(pbrt *p, const dtransform *m) {
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            if (!(fabs(m->m[r][c]) < 1e30))
                return pbrt_fail(p, p->place, NULL, "the transform has become too large");
    return SNELL_OK;
}

/* `replaces`: instead of what there is, else after it, as seen from the world. */
static snell_status apply(pbrt *p, const dtransform *m, bool replaces) {
    for (int i = 0; i < 2; i++)
        if (p->state.active >> i & 1) {
            dtransform *ctm = &p->state.ctm[i];
            *ctm = replaces ? *m : dtransform_multiply(ctm, m);
            if (check_finite(p, ctm)) break;
        }
    return p->status;
}

snell_status pbrt_do_identity(pbrt *p) {
    dtransform m = dtransform_identity();
    return apply(p, &m, true);
}

snell_status pbrt_do_translate(pbrt *p) {
    double v[3];
    if (pbrt_need_numbers(p, "Translate", v, 3)) return p->status;
    dtransform m = dtransform_identity();
    for (int i = 0; i < 3; i++) m.m[i][3] = v[i];
    return apply(p, &m, false);
}

snell_status pbrt_do_scale(pbrt *p) {
    double v[3];
    source_place place = p->place;
    if (pbrt_need_numbers(p, "Scale", v, 3)) return p->status;
    if (v[0] == 0 || v[1] == 0 || v[2] == 0)
        return pbrt_fail(p, place, NULL, "'Scale' by 0 leaves nothing");
    dtransform m = {{{v[0], 0, 0, 0}, {0, v[1], 0, 0}, {0, 0, v[2], 0}}};
    return apply(p, &m, false);
}

/* Rodrigues' formula. */
snell_status pbrt_do_rotate(pbrt *p) {
    double v[4];
    source_place place = p->place;
    if (pbrt_need_numbers(p, "Rotate", v, 4)) return p->status;
    dvec3 axis = {v[1], v[2], v[3]};
    double length = dvec3_length(axis);
    if (!(length > 0)) return pbrt_fail(p, place, NULL, "'Rotate' needs an axis that is not 0");
    axis = dvec3_scale(axis, 1 / length);
    double c = fn_cos(v[0] * (PI / 180)), s = fn_sin(v[0] * (PI / 180));
    double a[3] = {axis.x, axis.y, axis.z};
    double across[3][3] = {{0, -a[2], a[1]}, {a[2], 0, -a[0]}, {-a[1], a[0], 0}};
    dtransform m = dtransform_identity();
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            m.m[i][j] = (i == j ? c : 0) + (1 - c) * a[i] * a[j] + s * across[i][j];
    return apply(p, &m, false);
}

/* From the world to a camera at `eye`: x to its right, y up, z forward, a left-handed frame. */
snell_status pbrt_do_look_at(pbrt *p) {
    double v[9];
    source_place place = p->place;
    if (pbrt_need_numbers(p, "LookAt", v, 9)) return p->status;
    dvec3 eye = {v[0], v[1], v[2]}, forward = dvec3_sub((dvec3){v[3], v[4], v[5]}, eye),
          up = {v[6], v[7], v[8]};
    double distance = dvec3_length(forward);
    if (!(distance > 0))
        return pbrt_fail(p, place, "move one of them", "'LookAt' looks at where it stands");
    forward = dvec3_scale(forward, 1 / distance);
    dvec3 right = dvec3_cross(up, forward);
    if (!(dvec3_length(right) > 1e-9 * dvec3_length(up)))
        return pbrt_fail(p, place, "give another 'up'", "'LookAt' looks along its own up");
    right = dvec3_normalize(right);
    up = dvec3_cross(forward, right);
    dtransform to_world = {{{right.x, up.x, forward.x, eye.x},
                            {right.y, up.y, forward.y, eye.y},
                            {right.z, up.z, forward.z, eye.z}}},
               m;
    if (!pbrt_inverse(&to_world, &m)) return pbrt_fail(p, place, NULL, "'LookAt' is too far away");
    return apply(p, &m, false);
}

/* Sixteen numbers, column after column. */
static snell_status read_matrix(pbrt *p, const char *directive, dtransform *out) {
    double v[16];
    source_place place = p->place;
    if (pbrt_need_matrix(p, directive, v)) return p->status;
    if (v[3] != 0 || v[7] != 0 || v[11] != 0 || v[15] == 0)
        return pbrt_fail(p, place, "the 4th, 8th and 12th numbers are 0",
                         "'%s' is no affine matrix", directive);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++) out->m[r][c] = v[4 * c + r] / v[15];
    return SNELL_OK;
}

snell_status pbrt_do_transform(pbrt *p) {
    dtransform m;
    return read_matrix(p, "Transform", &m) ? p->status : apply(p, &m, true);
}

snell_status pbrt_do_concat_transform(pbrt *p) {
    dtransform m;
    return read_matrix(p, "ConcatTransform", &m) ? p->status : apply(p, &m, false);
}

snell_status pbrt_name_system(pbrt *p, const char *name, const dtransform system[2]) {
    if (!ARRAY_GROW(p->system_list, p->system_count, p->system_capacity, 1) ||
        json_object_set_new_nocheck(p->systems, name, json_integer((json_int_t)p->system_count)))
        return pbrt_blame(p, p->place, error_no_memory());
    memcpy(p->system_list[p->system_count++], system, sizeof *p->system_list);
    return SNELL_OK;
}

snell_status pbrt_do_coordinate_system(pbrt *p) {
    if (pbrt_need_string(p, "CoordinateSystem")) return p->status;
    return pbrt_name_system(p, p->word, p->state.ctm);
}

snell_status pbrt_do_coord_sys_transform(pbrt *p) {
    if (pbrt_need_string(p, "CoordSysTransform")) return p->status;
    json_t *found = json_object_get(p->systems, p->word);
    if (found == NULL)
        return pbrt_warn(p, p->place, "no coordinate system is called '%.60s': ignored", p->word);
    memcpy(p->state.ctm, p->system_list[json_integer_value(found)], sizeof p->state.ctm);
    return SNELL_OK;
}

snell_status pbrt_do_active_transform(pbrt *p) {
    static const char *const words[] = {"StartTime", "EndTime", "All"};
    if (pbrt_next(p)) return p->status;
    for (unsigned i = 0; i < 3; i++)
        if (p->kind == PBRT_WORD && strcmp(p->word, words[i]) == 0) {
            p->state.active = i + 1;
            return SNELL_OK;
        }
    return pbrt_fail(p, p->place, NULL,
                     "'ActiveTransform' needs All, StartTime or EndTime, not '%.40s'", p->word);
}

snell_status pbrt_do_transform_times(pbrt *p) {
    source_place place = p->place;
    if (pbrt_need_numbers(p, "TransformTimes", p->times, 2)) return p->status;
    if (!(fabs(p->times[0]) <= 1000 && fabs(p->times[1]) <= 1000))
        return pbrt_fail(p, place, NULL, "'TransformTimes' are within -1000 to 1000 seconds");
    return SNELL_OK;
}
