/* pbrt's shapes, and where they stand. Meshes are brought to the world as they are read, as pbrt does;
 * whole spheres, cylinders, disks and curves stay what they are. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "geometry/mesh.h"
#include "importers/pbrt.h"
#include "maths/functions.h"

enum { LEVELS_MAX = 8 };

typedef pbrt_drawn drawn;

/* ---- placing ---- */

static object_source source_of(const drawn *s) {
    return (object_source){NULL, s->params->place.file, s->params->place.line};
}

snell_status pbrt_material_of(pbrt *p, const drawn *s, double area, uint32_t *out) {
    pbrt_variant v = {.absorption = p->state.absorption};
    v.alpha = s->alpha;
    const pbrt_area_light *light = &p->state.area;
    if (light->lit && p->in_object) {
        pbrt_warn(p, s->params->place, "area lights in objects do not shine, as in pbrt");
    } else if (light->lit) {
        v.emission = light->radiance;
        if (light->has_power)
            v.emission = vec3_scale(light->power, (float)(area > 0 ? 1 / (PI * area) : 0));
        v.two_sided = light->two_sided;
    }
    return p->status ? p->status : pbrt_material_use(p, p->state.material, &v, out);
}

snell_status pbrt_add_part(pbrt *p, source_place place, uint32_t made) {
    if (!p->in_object) return SNELL_OK;
    if (!ARRAY_GROW(p->parts, p->part_count, p->part_capacity, 1))
        return pbrt_blame(p, place, error_no_memory());
    p->parts[p->part_count++] = made;
    return SNELL_OK;
}

/* local: from the shape's space to pbrt's. in_world: there is no more to do. */
static snell_status place_shape(pbrt *p, const drawn *s, uint32_t shape, double area,
                                const dtransform *local, bool in_world) {
    uint32_t material, made;
    source_place place = s->params->place;
    if (pbrt_material_of(p, s, area, &material)) return p->status;
    dtransform both[2] = {pbrt_to_world(p, 0), pbrt_to_world(p, 1)};
    transform at[2];
    for (int i = 0; i < 2; i++) {
        dtransform m = in_world ? dtransform_identity() : dtransform_multiply(&both[i], local);
        at[i] = dtransform_round(&m);
    }
    snell_status status =
        description_add_instance(p->d, shape, material, &at[0], source_of(s), &made);
    if (!status && !in_world && pbrt_is_animated(p) && p->times[0] < p->times[1]) {
        motion_key keys[2] = {{(float)p->times[0], at[0]}, {(float)p->times[1], at[1]}};
        p->moving = true;
        status = description_set_motion(p->d, made, keys, 2);
    }
    return status ? pbrt_blame(p, place, status) : pbrt_add_part(p, place, made);
}

snell_status pbrt_add_shape(pbrt *p, const drawn *s, const char *type, const snell_param *params,
                            size_t count, double area, const dtransform *local) {
    uint32_t shape;
    snell_status status =
        description_add(p->d, CATEGORY_SHAPE, type, params, count, source_of(s), &shape);
    if (status) return pbrt_blame(p, s->params->place, status);
    return place_shape(p, s, shape, area, local, false);
}

bool pbrt_is_hidden_light(const pbrt *p, const drawn *s) {
    return p->state.area.lit && !p->in_object && s->alpha.texture.index1 == 0 &&
           s->alpha.value.x == 0;
}

snell_status pbrt_add_hidden_light(pbrt *p, const drawn *s, const char *type, double area,
                                   const snell_param *where, size_t count) {
    const pbrt_area_light *light = &p->state.area;
    vec3 radiance = light->has_power
                        ? vec3_scale(light->power, (float)(area > 0 ? 1 / (PI * area) : 0))
                        : light->radiance;
    snell_param params[8] = {{"radiance", SNELL_PARAM_VEC3, {.v = radiance}},
                             {"visible", SNELL_PARAM_BOOL, {.b = false}}};
    uint32_t made;
    memcpy(params + 2, where, count * sizeof *where);
    if (light->two_sided)
        pbrt_warn(p, s->params->place, "a light that is not seen shines from its outside alone");
    return pbrt_blame(
        p, s->params->place,
        description_add(p->d, CATEGORY_LIGHT, type, params, 2 + count, source_of(s), &made));
}

/* ---- meshes ---- */

static void turn_over(uint32_t *triangle) {
    uint32_t second = triangle[1];
    triangle[1] = triangle[2];
    triangle[2] = second;
}

/* Faces look where their normals do, if there are any; else counter-clockwise in the shape's space. */
static void orient(pbrt_mesh *mesh, bool reversed) {
    for (size_t i = 0; i < mesh->index_count; i += 3) {
        uint32_t *t = mesh->indices + i;
        bool over = reversed;
        if (mesh->normals) {
            dvec3 a = mesh->positions[t[0]],
                  n = dvec3_cross(dvec3_sub(mesh->positions[t[1]], a),
                                  dvec3_sub(mesh->positions[t[2]], a)),
                  mean = dvec3_add(mesh->normals[t[0]],
                                   dvec3_add(mesh->normals[t[1]], mesh->normals[t[2]]));
            double side = dvec3_dot(n, mean);
            if (side != 0) over = side < 0;
        }
        if (over) turn_over(t);
    }
}

/* By the transform, and the inverse transpose of it. */
static snell_status move_mesh(pbrt *p, const drawn *s, const dtransform *m, bool reversed,
                              pbrt_mesh *mesh) {
    dtransform inverse;
    if (!pbrt_inverse(m, &inverse))
        return pbrt_fail(p, s->params->place, NULL, "the transform of this shape cannot be undone");
    bool mirrors = pbrt_determinant(m) < 0;
    for (size_t i = 0; i < mesh->count; i++) {
        mesh->positions[i] = pbrt_point(m, mesh->positions[i]);
        if (mesh->normals == NULL) continue;
        dvec3 n = mesh->normals[i];
        double(*a)[4] = inverse.m;
        mesh->normals[i] = (dvec3){a[0][0] * n.x + a[1][0] * n.y + a[2][0] * n.z,
                                   a[0][1] * n.x + a[1][1] * n.y + a[2][1] * n.z,
                                   a[0][2] * n.x + a[1][2] * n.y + a[2][2] * n.z};
        if (reversed) mesh->normals[i] = dvec3_negate(mesh->normals[i]);
    }
    orient(mesh, reversed != mirrors);
    return SNELL_OK;
}

typedef struct arrays { /* as snell has them */
    vec3 *positions, *normals;
    snell_vec2 *uvs;
} arrays;

static bool make_arrays(const pbrt_mesh *mesh, arrays *out) {
    out->positions = memory_resize(NULL, mesh->count + 1, sizeof *out->positions);
    out->normals = memory_resize(NULL, mesh->count + 1, sizeof *out->normals);
    out->uvs = memory_resize(NULL, mesh->count + 1, sizeof *out->uvs);
    if (!out->positions || !out->normals || !out->uvs) return false;
    for (size_t i = 0; i < mesh->count; i++) {
        out->positions[i] = vec3_from(mesh->positions[i]);
        if (mesh->normals) {
            /* Unit, or 0: what the transform has made of them may be beyond a float. */
            double length = dvec3_length(mesh->normals[i]);
            out->normals[i] = length > 0 && length < INFINITY
                                  ? vec3_from(dvec3_scale(mesh->normals[i], 1 / length))
                                  : (vec3){0, 0, 0};
        }
        if (mesh->uvs) out->uvs[i] = (snell_vec2){(float)mesh->uvs[i][0], (float)mesh->uvs[i][1]};
    }
    return true;
}

/* What stands still is in the world then. */
snell_status pbrt_add_mesh(pbrt *p, const drawn *s, pbrt_mesh *mesh) {
    if (pbrt_is_hidden_light(p, s)) {
        pbrt_mesh_free(mesh);
        return pbrt_warn(p, s->params->place,
                         "of lights with alpha 0 only spheres, disks and parallelograms are "
                         "supported: left out");
    }
    bool still = !pbrt_is_animated(p);
    dtransform to_world = still ? pbrt_to_world(p, 0) : dtransform_identity();
    arrays made = {NULL, NULL, NULL};
    if (mesh->index_count && !move_mesh(p, s, &to_world, p->state.reverse, mesh) &&
        !pbrt_spend(p, s->params->place, (uint64_t)mesh->count * 32)) {
        size_t triangles = mesh->index_count / 3, n = mesh->count;
        if (!make_arrays(mesh, &made)) {
            pbrt_blame(p, s->params->place, error_no_memory());
        } else {
            mesh_desc desc = {.struct_size = sizeof desc,
                              .positions = made.positions,
                              .positions_count = n,
                              .indices = mesh->indices,
                              .indices_count = mesh->index_count,
                              .normals = mesh->normals ? made.normals : NULL,
                              .normals_count = mesh->normals ? n : 0,
                              .uvs = mesh->uvs ? made.uvs : NULL,
                              .uvs_count = mesh->uvs ? n : 0};
            uint32_t shape;
            dtransform local = dtransform_identity();
            snell_status status = description_add_desc(p->d, type_find(CATEGORY_SHAPE, "mesh"),
                                                       &desc, source_of(s), &shape);
            if (!pbrt_blame(p, s->params->place, status))
                place_shape(p, s, shape, pbrt_mesh_area(mesh) / (double)triangles, &local, still);
        }
    }
    free(made.positions);
    free(made.normals);
    free(made.uvs);
    pbrt_mesh_free(mesh);
    return p->status;
}

/* P, N, uv, indices in groups of `per`; without indices `per` corners are one group. */
static snell_status read_mesh(pbrt *p, const drawn *s, size_t per, size_t triangles_per,
                              pbrt_mesh *out, const double **indices, size_t *groups) {
    static const double one[4] = {0, 1, 2, 3};
    size_t count, normals, uvs, index_count;
    const double *position = pbrt_numbers(p, s->params, "P", 3, &count),
                 *normal = pbrt_numbers(p, s->params, "N", 3, &normals),
                 *uv =
                     pbrt_numbers(p, s->params, pbrt_find(s->params, "st") ? "st" : "uv", 2, &uvs);
    *indices = pbrt_numbers(p, s->params, "indices", 1, &index_count);
    pbrt_ignore(s->params, "S faceIndices");
    source_place place = s->params->place;
    if (p->status) return p->status;
    if (*indices == NULL && count == per) *indices = one, index_count = per;
    if (position == NULL || *indices == NULL)
        return pbrt_fail(p, place, NULL, "%s needs '%s'", s->params->what,
                         position ? "indices" : "P");
    if (index_count % per)
        return pbrt_fail(p, place, NULL, "%s: %zu indices are no multiple of %zu", s->params->what,
                         index_count, per);
    if ((normals && normals != count) || (uvs && uvs != count))
        return pbrt_fail(p, place, NULL, "%s has %zu points, but %zu %s", s->params->what, count,
                         normals && normals != count ? normals : uvs,
                         normals && normals != count ? "normals" : "texture coordinates");
    for (size_t i = 0; i < index_count; i++)
        if (!((*indices)[i] >= 0 && (*indices)[i] < (double)count))
            return pbrt_fail(p, place, NULL, "%s: index %.0f of %zu points", s->params->what,
                             (*indices)[i], count);
    *groups = index_count / per;
    if (pbrt_mesh_make(p, place, count, *groups * triangles_per, normals > 0, uvs > 0, out))
        return p->status;
    for (size_t i = 0; i < count; i++) {
        out->positions[i] = (dvec3){position[3 * i], position[3 * i + 1], position[3 * i + 2]};
        if (normals) out->normals[i] = (dvec3){normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]};
        if (uvs) memcpy(out->uvs[i], uv + 2 * i, sizeof out->uvs[i]);
    }
    return SNELL_OK;
}

/* pbrt's texture coordinates of a triangle that has none: (0, 0), (1, 0), (1, 1). */
static snell_status corner_uvs(pbrt *p, const drawn *s, pbrt_mesh *mesh) {
    static const double uvs[3][2] = {{0, 0}, {1, 0}, {1, 1}};
    pbrt_mesh out;
    if (pbrt_mesh_make(p, s->params->place, mesh->index_count, mesh->index_count / 3,
                       mesh->normals != NULL, true, &out))
        return p->status;
    for (size_t i = 0; i < mesh->index_count; i++) {
        out.positions[i] = mesh->positions[mesh->indices[i]];
        if (mesh->normals) out.normals[i] = mesh->normals[mesh->indices[i]];
        memcpy(out.uvs[i], uvs[i % 3], sizeof out.uvs[i]);
        out.indices[i] = (uint32_t)i;
    }
    pbrt_mesh_free(mesh);
    *mesh = out;
    return SNELL_OK;
}

bool pbrt_needs_uvs(const pbrt *p, const drawn *s) {
    return p->materials[p->state.material].textured || s->alpha.texture.index1;
}

static snell_status add_quad(pbrt *p, const drawn *s, dvec3 corner, dvec3 u, dvec3 v);

/* Two triangles that are a parallelogram, as the light that they are. */
static bool as_hidden_quad(pbrt *p, const drawn *s, const pbrt_mesh *mesh) {
    if (!pbrt_is_hidden_light(p, s) || mesh->index_count != 6 || p->state.area.has_power)
        return false;
    const uint32_t *t = mesh->indices;
    for (int k = 0; k < 3; k++) { /* the diagonal is opposite to k */
        dvec3 corner = mesh->positions[t[k]], a = mesh->positions[t[(k + 1) % 3]],
              b = mesh->positions[t[(k + 2) % 3]], sum = dvec3_sub(dvec3_add(a, b), corner);
        for (int i = 3; i < 6; i++)
            if (dvec3_length(dvec3_sub(mesh->positions[t[i]], sum)) <
                1e-5 * dvec3_length(dvec3_sub(a, b))) {
                add_quad(p, s, corner, dvec3_sub(a, corner), dvec3_sub(b, corner));
                return true;
            }
    }
    return false;
}

static snell_status triangle_mesh(pbrt *p, const drawn *s) {
    pbrt_mesh mesh = {.count = 0};
    const double *indices;
    size_t groups;
    if (!read_mesh(p, s, 3, 1, &mesh, &indices, &groups)) {
        for (size_t i = 0; i < mesh.index_count; i++) mesh.indices[i] = (uint32_t)indices[i];
        if (mesh.uvs == NULL && pbrt_needs_uvs(p, s)) corner_uvs(p, s, &mesh);
    }
    if (!p->status && !as_hidden_quad(p, s, &mesh)) return pbrt_add_mesh(p, s, &mesh);
    pbrt_mesh_free(&mesh);
    return p->status;
}

static snell_status loop_subdivision(pbrt *p, const drawn *s) {
    pbrt_mesh mesh = {.count = 0};
    const double *indices;
    size_t groups;
    int levels = pbrt_int(p, s->params, "levels", 3);
    pbrt_ignore(s->params, "scheme");
    if (!p->status && (levels < 0 || levels > LEVELS_MAX)) {
        pbrt_warn(p, s->params->place, "'levels' of subdivision are 0 to %d", LEVELS_MAX);
        levels = levels < 0 ? 0 : LEVELS_MAX;
    }
    if (!read_mesh(p, s, 3, 1, &mesh, &indices, &groups)) {
        for (size_t i = 0; i < mesh.index_count; i++) mesh.indices[i] = (uint32_t)indices[i];
        free(mesh.normals);
        free(mesh.uvs);
        mesh.normals = NULL;
        mesh.uvs = NULL;
        pbrt_subdivide(p, s->params->place, levels, &mesh);
    }
    if (!p->status) return pbrt_add_mesh(p, s, &mesh);
    pbrt_mesh_free(&mesh);
    return p->status;
}

static snell_status ply_mesh(pbrt *p, const drawn *s) {
    pbrt_mesh mesh = {.count = 0};
    const pbrt_param *file = pbrt_find(s->params, "filename");
    const char *name = pbrt_string(p, s->params, "filename", NULL);
    pbrt_lacks(p, s->params, "displacement");
    pbrt_ignore(s->params, "edgelength");
    if (!p->status && name == NULL)
        return pbrt_fail(p, s->params->place, "such as \"string filename\" \"bunny.ply\"",
                         "%s needs a 'filename'", s->params->what);
    if (!p->status) pbrt_read_ply(p, name, file->place, &mesh);
    if (!p->status && mesh.uvs == NULL && pbrt_needs_uvs(p, s)) corner_uvs(p, s, &mesh);
    if (!p->status) return pbrt_add_mesh(p, s, &mesh);
    pbrt_mesh_free(&mesh);
    return p->status;
}

/* ---- bilinear patches ---- */

typedef struct patch { /* corners in the order 00 10 01 11 */
    dvec3 p[4], n[4];
    double uv[4][2];
    bool has_normals, has_uvs;
} patch;

static dvec3 blend(const dvec3 c[4], double u, double v) {
    return dvec3_add(
        dvec3_add(dvec3_scale(c[0], (1 - u) * (1 - v)), dvec3_scale(c[1], u * (1 - v))),
        dvec3_add(dvec3_scale(c[2], (1 - u) * v), dvec3_scale(c[3], u * v)));
}

static void patch_at(const void *user, double u, double v, dvec3 *position, dvec3 *normal) {
    const patch *q = user;
    dvec3 along = dvec3_sub(blend(q->p, 1, v), blend(q->p, 0, v)),
          across = dvec3_sub(blend(q->p, u, 1), blend(q->p, u, 0));
    *position = blend(q->p, u, v);
    *normal = q->has_normals ? blend(q->n, u, v) : dvec3_cross(along, across);
}

/* How far the fourth corner is from where a parallelogram has it, as a part of its size. */
static double bend_of(const patch *q) {
    dvec3 u = dvec3_sub(q->p[1], q->p[0]), v = dvec3_sub(q->p[2], q->p[0]),
          off = dvec3_sub(q->p[3], dvec3_add(q->p[0], dvec3_add(u, v)));
    return dvec3_length(off) / (dvec3_length(u) + dvec3_length(v) + 1e-30);
}

static snell_status add_quad(pbrt *p, const drawn *s, dvec3 corner, dvec3 u, dvec3 v) {
    if (p->state.reverse && s->exact) {
        corner = dvec3_add(corner, u);
        u = dvec3_negate(u);
    }
    const snell_param params[] = {{"corner", SNELL_PARAM_VEC3, {.v = vec3_from(corner)}},
                                  {"u", SNELL_PARAM_VEC3, {.v = vec3_from(u)}},
                                  {"v", SNELL_PARAM_VEC3, {.v = vec3_from(v)}}};
    dtransform local = dtransform_identity(), to_world = pbrt_to_world(p, 0);
    dvec3 wu = pbrt_vector(&to_world, u), wv = pbrt_vector(&to_world, v);
    double area = dvec3_length(dvec3_cross(wu, wv));
    if (pbrt_is_hidden_light(p, s)) {
        bool mirrors = pbrt_determinant(&to_world) < 0;
        const snell_param where[] = {
            {"corner", SNELL_PARAM_VEC3, {.v = vec3_from(pbrt_point(&to_world, corner))}},
            {"u", SNELL_PARAM_VEC3, {.v = vec3_from(mirrors ? wv : wu)}},
            {"v", SNELL_PARAM_VEC3, {.v = vec3_from(mirrors ? wu : wv)}}};
        return pbrt_add_hidden_light(p, s, "quad", area, where, 3);
    }
    return pbrt_add_shape(p, s, "quad", params, 3, area, &local);
}

static snell_status add_patch(pbrt *p, const drawn *s, const patch *q) {
    dvec3 n = dvec3_cross(dvec3_sub(q->p[1], q->p[0]), dvec3_sub(q->p[2], q->p[0]));
    double bend = bend_of(q);
    pbrt_mesh mesh;
    if (bend < 1e-6 && !q->has_normals && !q->has_uvs && dvec3_length(n) > 1e-12 &&
        dvec3_largest((dvec3){fabs(q->p[3].x), fabs(q->p[3].y), fabs(q->p[3].z)}) < 1e15)
        return add_quad(p, s, q->p[0], dvec3_sub(q->p[1], q->p[0]), dvec3_sub(q->p[2], q->p[0]));
    uint32_t cells = bend < 1e-6 && !q->has_normals ? 1 : 16;
    if (pbrt_tessellate(p, s->params->place, cells, cells, patch_at, q, &mesh)) return p->status;
    for (size_t i = 0; q->has_uvs && i < mesh.count; i++) {
        double u = mesh.uvs[i][0], v = mesh.uvs[i][1];
        for (int k = 0; k < 2; k++)
            mesh.uvs[i][k] = (1 - u) * (1 - v) * q->uv[0][k] + u * (1 - v) * q->uv[1][k] +
                             (1 - u) * v * q->uv[2][k] + u * v * q->uv[3][k];
    }
    return pbrt_add_mesh(p, s, &mesh);
}

static snell_status bilinear_mesh(pbrt *p, const drawn *s) {
    pbrt_mesh corners = {.count = 0};
    const double *indices;
    size_t groups = 0;
    pbrt_lacks(p, s->params, "emissionfilename");
    read_mesh(p, s, 4, 0, &corners, &indices, &groups);
    for (size_t g = 0; g < groups && !p->status; g++) {
        patch q = {.has_normals = corners.normals != NULL, .has_uvs = corners.uvs != NULL};
        for (size_t k = 0; k < 4; k++) {
            size_t i = (size_t)indices[4 * g + k];
            q.p[k] = corners.positions[i];
            if (q.has_normals) q.n[k] = corners.normals[i];
            if (q.has_uvs) memcpy(q.uv[k], corners.uvs[i], sizeof q.uv[k]);
        }
        add_patch(p, s, &q);
    }
    pbrt_mesh_free(&corners);
    return p->status;
}

/* ---- any ---- */

snell_status pbrt_shape(pbrt *p, const pbrt_params *params) {
    static const struct {
        const char *name;
        snell_status (*read)(pbrt *p, const drawn *s);
    } kinds[] = {{"sphere", pbrt_sphere},
                 {"cylinder", pbrt_cylinder},
                 {"disk", pbrt_disk},
                 {"trianglemesh", triangle_mesh},
                 {"plymesh", ply_mesh},
                 {"bilinearmesh", bilinear_mesh},
                 {"loopsubdiv", loop_subdivision},
                 {"curve", pbrt_curve}};
    static const double opaque[3] = {1, 1, 1};
    const char *names[8];
    size_t i = 0;
    for (size_t k = 0; k < 8; k++) names[k] = kinds[k].name;
    while (i < 8 && strcmp(kinds[i].name, params->type) != 0) i++;
    if (i == 8) {
        char hint[80];
        const char *like = closest_word(params->type, names, 8);
        snprintf(hint, sizeof hint, "did you mean '%s'?", like ? like : "");
        return pbrt_fail(p, params->place, like ? hint : NULL, "unknown shape '%s'", params->type);
    }
    const pbrt_material *material = &p->materials[p->state.material];
    if (material->type == NULL) { /* an interface */
        for (pbrt_param *param = params->own; param; param = param->next) param->used = true;
        return p->state.area.lit
                   ? pbrt_warn(p, params->place, "an area light of 'interface' does not shine")
                   : SNELL_OK;
    }
    drawn s = {.params = params, .exact = p->state.area.lit || material->is_glass};
    if (pbrt_input(p, params, "alpha", true, opaque, &s.alpha, NULL)) return p->status;
    s.alpha.value.x = s.alpha.value.y = s.alpha.value.z = float_min(s.alpha.value.x, 1);
    return kinds[i].read(p, &s);
}
