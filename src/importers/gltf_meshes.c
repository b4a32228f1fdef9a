/* glTF primitives become shapes of type "mesh": one per primitive, shared by all nodes that draw
 * the glTF mesh, except where a skin or a node's own morph weights make it another one. Points become
 * small octahedra and lines six-sided rods, with the normals of balls and round rods. */
#include "importers/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "geometry/mesh.h"
#include "importers/draco.h"

enum {
    MODE_POINTS,
    MODE_LINES,
    MODE_LOOP,
    MODE_STRIP_OF_LINES,
    MODE_TRIANGLES,
    MODE_STRIP,
    MODE_FAN
};

/* What one node adds to the mesh it draws, at one time after the other. */
typedef struct pose {
    double *weights; /* of the morph targets, weight_count for each time */
    size_t weight_count;
    dmat *joints; /* joint_count matrices from the mesh to the world for each time; NULL: no skin */
    size_t joint_count;
    float times[CLOCK_TIMES];
    size_t time_count; /* 1: it does not deform */
    double scale;      /* from the mesh to the world */
} pose;

/* A primitive while it is built; every array is owned. positions and normals have `count` entries for
 * each of the pose's times, the others `count`. */
typedef struct builder {
    gltf *g;
    const json_t *primitive;
    const pose *pose;
    char where[96]; /* "meshes[1].primitives[0]" */
    size_t count, index_count, time_count;
    float *positions, *normals, *uvs, *uvs2, *tangents;
    snell_vec3 *colors;
    uint8_t *alphas;
    uint32_t *indices;
    uint32_t *segments; /* of points and lines: two vertices each, of a point the same */
    size_t segment_count;
    draco_mesh *draco; /* NULL: the accessors have data */
} builder;

static void builder_deinit(builder *b) {
    free(b->positions);
    free(b->normals);
    free(b->uvs);
    free(b->uvs2);
    free(b->tangents);
    free(b->segments);
    if (b->draco) draco_close(b->draco);
    free(b->colors);
    free(b->alphas);
    free(b->indices);
}

/* ---- attributes ---- */

/* SIZE_MAX: the primitive has none of this name. */
static size_t attribute(const json_t *map, const char *name) {
    return json_index(map, name, SIZE_MAX);
}

static snell_status check_count(const builder *b, size_t accessor, const char *where) {
    if (gltf_accessor_count(b->g, accessor) == b->count) return SNELL_OK;
    return gltf_error(b->g, SNELL_ERR_SYNTAX, where, "has %zu elements where POSITION has %zu",
                      gltf_accessor_count(b->g, accessor), b->count);
}

/* The number of an attribute in compressed data. false: it is not there. */
static bool draco_id(const builder *b, const char *name, uint32_t *id) {
    const json_t *ids =
        json_at(json_extension(b->primitive, "KHR_draco_mesh_compression"), "attributes");
    size_t found = json_index(ids, name, SIZE_MAX);
    *id = (uint32_t)found;
    return b->draco && found < UINT32_MAX;
}

static snell_status wrong_draco(const builder *b, const char *where) {
    return gltf_error(b->g, SNELL_ERR_SYNTAX, where,
                      "the data that Draco has compressed does not hold it");
}

static snell_status read_draco_floats(builder *b, uint32_t id, size_t accessor, unsigned components,
                                      const char *where, float **out) {
    bool normalized = json_flag(json_item(b->g, "accessors", accessor), "normalized");
    if (gltf_accessor_components(b->g, accessor) != components) return wrong_draco(b, where);
    snell_status status = gltf_spend(b->g, where, (uint64_t)b->count * components * 4);
    if (status) return status;
    *out = memory_zeroed(b->count * components, sizeof **out);
    if (*out == NULL) return error_no_memory();
    if (draco_read_floats(b->draco, id, components, normalized, *out)) return SNELL_OK;
    return wrong_draco(b, where);
}

/* An attribute's floats, or NULL when there is none. */
static snell_status read_attribute(builder *b, const json_t *map, const char *where_map,
                                   const char *name, unsigned components, float **out) {
    size_t accessor = attribute(map, name);
    if (accessor == SIZE_MAX) return SNELL_OK;
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "%s.%s.%s", b->where, where_map, name);
    snell_status status = check_count(b, accessor, where);
    uint32_t id;
    if (status) return status;
    if (strcmp(where_map, "attributes") == 0 && draco_id(b, name, &id))
        return read_draco_floats(b, id, accessor, components, where, out);
    return gltf_accessor_floats(b->g, accessor, components, where, out);
}

static snell_status read_colors(builder *b, const json_t *map, bool want_alpha) {
    size_t accessor = attribute(map, "COLOR_0");
    if (accessor == SIZE_MAX) return SNELL_OK;
    unsigned components = gltf_accessor_components(b->g, accessor) == 4 ? 4 : 3;
    float *values = NULL;
    snell_status status = read_attribute(b, map, "attributes", "COLOR_0", components, &values);
    if (status) return status;
    b->colors = memory_resize(NULL, b->count, sizeof *b->colors);
    if (want_alpha && components == 4) b->alphas = memory_resize(NULL, b->count, 1);
    if (b->colors == NULL || (want_alpha && components == 4 && b->alphas == NULL)) {
        free(values);
        return error_no_memory();
    }
    for (size_t i = 0; i < b->count; i++) {
        const float *c = values + i * components;
        b->colors[i] = (snell_vec3){c[0] > 0 ? c[0] : 0, c[1] > 0 ? c[1] : 0, c[2] > 0 ? c[2] : 0};
        if (b->alphas) b->alphas[i] = (uint8_t)(clamp01((double)c[3]) * 255 + 0.5);
    }
    free(values);
    return SNELL_OK;
}

static snell_status read_uvs(builder *b, const json_t *map, unsigned set, float **out) {
    char name[24];
    snprintf(name, sizeof name, "TEXCOORD_%u", set);
    if (set == NO_UV_SET) return SNELL_OK;
    snell_status status = read_attribute(b, map, "attributes", name, 2, out);
    for (size_t i = 0; *out && i < b->count; i++) (*out)[2 * i + 1] = 1 - (*out)[2 * i + 1];
    return status;
}

/* ---- morph targets: base + sum of weight * displacement ---- */

static double weight_at(const builder *b, size_t time, size_t target) {
    return b->pose->weights[time * b->pose->weight_count + target];
}

static snell_status add_target(builder *b, size_t target, const char *name, float *base) {
    const json_t *map = json_array_get(json_at(b->primitive, "targets"), target);
    char list[32];
    snprintf(list, sizeof list, "targets[%zu]", target);
    float *moves = NULL;
    snell_status status = read_attribute(b, map, list, name, 3, &moves);
    for (size_t k = 0; moves && k < b->time_count; k++) {
        double weight = weight_at(b, k, target);
        float *at = base + 3 * b->count * k;
        for (size_t i = 0; weight != 0 && i < 3 * b->count; i++)
            at[i] = (float)((double)at[i] + weight * (double)moves[i]);
    }
    free(moves);
    return status;
}

static bool is_used(const builder *b, size_t target) {
    for (size_t k = 0; k < b->time_count; k++)
        if (weight_at(b, k, target) != 0) return true;
    return false;
}

static snell_status morph(builder *b) {
    size_t targets = json_array_size(json_at(b->primitive, "targets"));
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < targets && i < b->pose->weight_count && !status; i++) {
        if (!is_used(b, i)) continue;
        status = add_target(b, i, "POSITION", b->positions);
        if (!status && b->normals) status = add_target(b, i, "NORMAL", b->normals);
    }
    return status;
}

/* ---- skins: every vertex moves by the weighted mean of its joints' matrices ---- */

/* Normals turn by the cofactor matrix, which is the inverse transpose but for its length. */
static dvec3 turn_normal(const dmat *a, dvec3 n) {
    dvec3 x = {a->m[0][0], a->m[1][0], a->m[2][0]}, y = {a->m[0][1], a->m[1][1], a->m[2][1]},
          z = {a->m[0][2], a->m[1][2], a->m[2][2]};
    dvec3 yz = dvec3_cross(y, z), zx = dvec3_cross(z, x), xy = dvec3_cross(x, y);
    return dvec3_normalize(
        dvec3_add(dvec3_scale(yz, n.x), dvec3_add(dvec3_scale(zx, n.y), dvec3_scale(xy, n.z))));
}

static dvec3 load3(const float *p) { return (dvec3){(double)p[0], (double)p[1], (double)p[2]}; }

static void store3(float *p, dvec3 v) { p[0] = (float)v.x, p[1] = (float)v.y, p[2] = (float)v.z; }

typedef struct influence {
    uint32_t *joints;
    float *weights;
} influence;

enum { INFLUENCE_SETS_MAX = 4 };

static void skin_vertex(builder *b, const influence *sets, int set_count, size_t time, size_t i) {
    const dmat *joints = b->pose->joints + time * b->pose->joint_count;
    size_t at = time * b->count + i;
    dmat sum = {{{0}}};
    double total = 0;
    for (int s = 0; s < set_count; s++)
        for (int k = 0; k < 4; k++) {
            double w = (double)sets[s].weights[4 * i + (size_t)k];
            const dmat *joint = &joints[sets[s].joints[4 * i + (size_t)k]];
            total += w;
            for (int e = 0; w != 0 && e < 12; e++) (&sum.m[0][0])[e] += w * (&joint->m[0][0])[e];
        }
    if (!(total > 0)) return;
    for (int e = 0; e < 12; e++) (&sum.m[0][0])[e] /= total;
    store3(b->positions + 3 * at, dmat_point(&sum, load3(b->positions + 3 * at)));
    if (b->normals) store3(b->normals + 3 * at, turn_normal(&sum, load3(b->normals + 3 * at)));
    float *tangent = b->tangents && b->time_count == 1 ? b->tangents + 4 * i : NULL;
    if (tangent) store3(tangent, dmat_vector(&sum, load3(tangent)));
}

static snell_status read_joint_numbers(builder *b, size_t accessor, const char *name,
                                       const char *where, uint32_t **out) {
    uint32_t id;
    if (!draco_id(b, name, &id)) return gltf_accessor_uints(b->g, accessor, 4, where, out);
    snell_status status = gltf_spend(b->g, where, (uint64_t)b->count * 16);
    if (status) return status;
    *out = memory_zeroed(b->count * 4, sizeof **out);
    if (*out == NULL) return error_no_memory();
    return draco_read_uints(b->draco, id, 4, *out) ? SNELL_OK : wrong_draco(b, where);
}

static snell_status read_influence(builder *b, const json_t *map, int set, influence *out) {
    char joints[24], weights[24], where[JSON_PATH_SIZE];
    snprintf(joints, sizeof joints, "JOINTS_%d", set);
    snprintf(weights, sizeof weights, "WEIGHTS_%d", set);
    snprintf(where, sizeof where, "%s.attributes.%s", b->where, joints);
    size_t accessor = attribute(map, joints);
    if (attribute(map, weights) == SIZE_MAX)
        return gltf_error(b->g, SNELL_ERR_SYNTAX, where, "%s is missing", weights);
    snell_status status = check_count(b, accessor, where);
    if (!status) status = read_joint_numbers(b, accessor, joints, where, &out->joints);
    if (!status) status = read_attribute(b, map, "attributes", weights, 4, &out->weights);
    for (size_t i = 0; !status && i < 4 * b->count; i++) {
        if (out->joints[i] >= b->pose->joint_count) {
            if (out->weights[i] != 0)
                return gltf_error(b->g, SNELL_ERR_SYNTAX, where,
                                  "joint %u of vertex %zu: the skin has %zu", out->joints[i], i / 4,
                                  b->pose->joint_count);
            out->joints[i] = 0;
        }
    }
    return status;
}

static snell_status apply_skin(builder *b, const json_t *map) {
    influence sets[INFLUENCE_SETS_MAX] = {{0}};
    int count = 0;
    snell_status status = SNELL_OK;
    char name[24] = "JOINTS_0";
    while (!status && count < INFLUENCE_SETS_MAX && attribute(map, name) != SIZE_MAX) {
        status = read_influence(b, map, count, &sets[count]);
        count++;
        snprintf(name, sizeof name, "JOINTS_%d", count);
    }
    for (size_t k = 0; !status && count > 0 && k < b->time_count; k++)
        for (size_t i = 0; i < b->count; i++) skin_vertex(b, sets, count, k, i);
    for (int s = 0; s < count; s++) {
        free(sets[s].joints);
        free(sets[s].weights);
    }
    return status; /* without any, gltf_check.c has said so */
}

/* ---- triangles ---- */

static void put_triangle(uint32_t *out, const uint32_t *in, size_t a, size_t b, size_t c) {
    out[0] = in ? in[a] : (uint32_t)a;
    out[1] = in ? in[b] : (uint32_t)b;
    out[2] = in ? in[c] : (uint32_t)c;
}

/* Strips and fans by the formulas of the specification, section 3.7.2.1. in NULL: 0, 1, 2, ... */
static snell_status make_triangles(builder *b, const uint32_t *in, size_t count, size_t mode) {
    size_t triangles = mode == MODE_TRIANGLES ? count / 3 : count < 3 ? 0 : count - 2;
    snell_status status = gltf_spend(b->g, b->where, (uint64_t)triangles * 12);
    if (status || triangles == 0) return status;
    b->indices = memory_resize(NULL, 3 * triangles, sizeof *b->indices);
    if (b->indices == NULL) return error_no_memory();
    b->index_count = 3 * triangles;
    for (size_t i = 0; i < triangles; i++) {
        uint32_t *out = b->indices + 3 * i;
        if (mode == MODE_TRIANGLES)
            put_triangle(out, in, 3 * i, 3 * i + 1, 3 * i + 2);
        else if (mode == MODE_STRIP)
            put_triangle(out, in, i, i + (1 + i % 2), i + (2 - i % 2));
        else
            put_triangle(out, in, i + 1, i + 2, 0);
    }
    return SNELL_OK;
}

/* ---- points and lines ---- */

static snell_status make_segments(builder *b, const uint32_t *in, size_t count, size_t mode) {
    size_t made = mode == MODE_LINES                     ? count / 2
                  : mode == MODE_STRIP_OF_LINES && count ? count - 1
                                                         : count;
    snell_status status = gltf_spend(b->g, b->where, (uint64_t)made * 8);
    if (status || made == 0) return status;
    b->segments = memory_resize(NULL, 2 * made, sizeof *b->segments);
    if (b->segments == NULL) return error_no_memory();
    b->segment_count = made;
    for (size_t i = 0; i < made; i++) {
        size_t from = mode == MODE_LINES ? 2 * i : i, to = mode == MODE_POINTS ? i : from + 1;
        if (to == count) to = 0; /* a loop */
        b->segments[2 * i] = in ? in[from] : (uint32_t)from;
        b->segments[2 * i + 1] = in ? in[to] : (uint32_t)to;
    }
    return SNELL_OK;
}

enum { ROD_SIDES = 6, ROD_VERTICES = 2 * ROD_SIDES, BALL_VERTICES = 6 };
/* Of the box about all that is drawn: about two pixels, and three, of a usual picture. */
static const double rod_radius = 0.0025, ball_radius = 0.004;

static void put_rod(const float *positions, const uint32_t *ends, double radius, float *out,
                    float *normals) {
    static const double hexagon[ROD_SIDES][2] = {{1, 0},  {0.5, 0.8660254},   {-0.5, 0.8660254},
                                                 {-1, 0}, {-0.5, -0.8660254}, {0.5, -0.8660254}};
    dvec3 from = load3(positions + 3 * (size_t)ends[0]),
          to = load3(positions + 3 * (size_t)ends[1]), along = dvec3_normalize(dvec3_sub(to, from)),
          x = {1, 0, 0}, y = {0, 1, 0};
    if (dvec3_dot(along, along) > 0) dvec3_frame(along, &x, &y);
    for (int i = 0; i < ROD_SIDES; i++) {
        dvec3 n = dvec3_add(dvec3_scale(x, hexagon[i][0]), dvec3_scale(y, hexagon[i][1]));
        for (int end = 0; end < 2; end++) {
            dvec3 p = dvec3_add(end ? to : from, dvec3_scale(n, radius));
            store3(out + 3 * (2 * i + end), p);
            store3(normals + 3 * (2 * i + end), n);
        }
    }
}

static void put_ball(const float *positions, const uint32_t *ends, double radius, float *out,
                     float *normals) {
    dvec3 at = load3(positions + 3 * (size_t)ends[0]);
    for (int i = 0; i < BALL_VERTICES; i++) {
        double sign = i % 2 ? -1 : 1;
        dvec3 n = {i / 2 == 0 ? sign : 0, i / 2 == 1 ? sign : 0, i / 2 == 2 ? sign : 0};
        store3(out + 3 * i, dvec3_add(at, dvec3_scale(n, radius)));
        store3(normals + 3 * i, n);
    }
}

/* Copies what `size` bytes each of the old vertices have to the new ones. */
static snell_status spread(const builder *b, size_t each, void *member, size_t size) {
    uint8_t *old;
    memcpy(&old, member, sizeof old);
    if (old == NULL) return SNELL_OK;
    uint8_t *made = memory_resize(NULL, b->segment_count * each, size);
    if (made == NULL) return error_no_memory();
    for (size_t i = 0; i < b->segment_count * each; i++) {
        size_t end = each == ROD_VERTICES ? i % 2 : 0;
        memcpy(made + i * size, old + b->segments[2 * (i / each) + end] * size, size);
    }
    free(old);
    memcpy(member, &made, sizeof made);
    return SNELL_OK;
}

static void put_indices(builder *b, bool balls, size_t each) {
    static const uint8_t octahedron[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                         2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    uint32_t *out = b->indices;
    for (size_t i = 0; i < b->segment_count; i++) {
        uint32_t first = (uint32_t)(i * each);
        for (size_t k = 0; balls && k < sizeof octahedron; k++) *out++ = first + octahedron[k];
        for (uint32_t k = 0; !balls && k < ROD_SIDES; k++) {
            uint32_t at = first + 2 * k, next = first + 2 * ((k + 1) % ROD_SIDES);
            const uint32_t two[] = {at, next, next + 1, at, next + 1, at + 1};
            memcpy(out, two, sizeof two);
            out += 6;
        }
    }
}

/* Points become balls, lines rods of this radius. */
static snell_status thicken(builder *b, bool balls, double size) {
    size_t each = balls ? BALL_VERTICES : ROD_VERTICES, triangles = balls ? 8 : 2 * ROD_SIDES,
           count = b->segment_count * each;
    double radius = size * (balls ? ball_radius : rod_radius);
    snell_status status =
        gltf_spend(b->g, b->where, (uint64_t)count * (24 * b->time_count + 40) + triangles * 12);
    if (!status && count > UINT32_MAX)
        status = gltf_error(b->g, SNELL_ERR_UNSUPPORTED, b->where, "has too many points or lines");
    if (status) return status;
    float *positions = memory_resize(NULL, count * b->time_count, 12),
          *normals = memory_resize(NULL, count * b->time_count, 12);
    b->indices = memory_resize(NULL, b->segment_count * triangles, 12);
    b->index_count = b->segment_count * triangles * 3;
    bool made = positions && normals && b->indices;
    for (size_t k = 0; made && k < b->time_count; k++)
        for (size_t i = 0; i < b->segment_count; i++) {
            size_t to = 3 * (k * count + i * each);
            (balls ? put_ball : put_rod)(b->positions + 3 * k * b->count, b->segments + 2 * i,
                                         radius, positions + to, normals + to);
        }
    free(b->positions);
    free(b->normals);
    free(b->tangents);
    b->positions = positions, b->normals = normals, b->tangents = NULL;
    if (!made) return error_no_memory();
    put_indices(b, balls, each);
    status = spread(b, each, &b->uvs, 8);
    if (!status) status = spread(b, each, &b->uvs2, 8);
    if (!status) status = spread(b, each, &b->colors, sizeof *b->colors);
    if (!status) status = spread(b, each, &b->alphas, 1);
    b->count = count;
    return status;
}

/* ---- indices ---- */

static snell_status read_indices(builder *b, size_t accessor, const char *where, uint32_t **in,
                                 size_t *count) {
    if (b->draco == NULL) {
        *count = gltf_accessor_count(b->g, accessor);
        return gltf_accessor_uints(b->g, accessor, 1, where, in);
    }
    *count = draco_index_count(b->draco);
    snell_status status = gltf_spend(b->g, where, (uint64_t)*count * 4);
    if (status) return status;
    *in = memory_resize(NULL, *count + 1, sizeof **in);
    if (*in == NULL) return error_no_memory();
    draco_read_indices(b->draco, *in);
    return SNELL_OK;
}

static snell_status read_topology(builder *b, size_t mode) {
    size_t accessor = json_index(b->primitive, "indices", SIZE_MAX), count = b->count;
    uint32_t *in = NULL;
    snell_status status = SNELL_OK;
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "%s.indices", b->where);
    if (b->draco) mode = MODE_TRIANGLES; /* a strip is compressed as its triangles */
    if (accessor != SIZE_MAX || b->draco) status = read_indices(b, accessor, where, &in, &count);
    for (size_t i = 0; in && i < count && !status; i++)
        if (in[i] >= b->count)
            status = gltf_error(b->g, SNELL_ERR_SYNTAX, where, "index %u: there are %zu vertices",
                                in[i], b->count);
    bool whole = mode == MODE_TRIANGLES  ? count >= 3 && count % 3 == 0
                 : mode > MODE_TRIANGLES ? count >= 3
                 : mode == MODE_POINTS   ? count >= 1
                                         : count >= 2 && (mode != MODE_LINES || count % 2 == 0);
    if (!status && !whole)
        status = gltf_warn(b->g, "%s: %zu vertices do not make whole %s", b->where, count,
                           mode < MODE_TRIANGLES ? "lines" : "triangles");
    if (!status && mode < MODE_TRIANGLES && count > (mode == MODE_POINTS ? 0 : 1))
        status = make_segments(b, in, count, mode);
    if (!status && mode >= MODE_TRIANGLES) status = make_triangles(b, in, count, mode);
    free(in);
    return status;
}

/* ---- one primitive ---- */

/* The same three floats per vertex again for every other time. */
static snell_status repeat(builder *b, float **values) {
    size_t size = 3 * b->count;
    if (*values == NULL || b->time_count == 1) return SNELL_OK;
    snell_status status = gltf_spend(b->g, b->where, (uint64_t)size * b->time_count * 4);
    if (status) return status;
    float *all = memory_resize(*values, size * b->time_count, sizeof *all);
    if (all == NULL) return error_no_memory();
    for (size_t k = 1; k < b->time_count; k++) memcpy(all + k * size, all, size * sizeof *all);
    *values = all;
    return SNELL_OK;
}

/* A mesh that is the same at all times need not be kept for each. */
static void drop_still_times(builder *b) {
    size_t size = 3 * b->count * sizeof(float);
    for (size_t k = 1; k < b->time_count; k++) {
        const float *p = b->positions, *n = b->normals;
        if (memcmp(p, p + 3 * b->count * k, size) != 0) return;
        if (n && memcmp(n, n + 3 * b->count * k, size) != 0) return;
    }
    b->time_count = 1;
}

static snell_status read_vertices(builder *b) {
    const json_t *map = json_at(b->primitive, "attributes");
    size_t material = json_index(b->primitive, "material", SIZE_MAX);
    snell_status status = read_attribute(b, map, "attributes", "POSITION", 3, &b->positions);
    if (!status) status = read_attribute(b, map, "attributes", "NORMAL", 3, &b->normals);
    unsigned sets[2];
    gltf_material_uv_sets(b->g, material, sets);
    if (!status) status = read_uvs(b, map, sets[0], &b->uvs);
    if (!status) status = read_uvs(b, map, sets[1], &b->uvs2);
    if (!status && b->normals && gltf_material_has_grain(b->g, material))
        status = read_attribute(b, map, "attributes", "TANGENT", 4, &b->tangents);
    if (!status) status = read_colors(b, map, gltf_material_has_alpha(b->g, material));
    if (!status) status = repeat(b, &b->positions);
    if (!status) status = repeat(b, &b->normals);
    if (!status) status = morph(b);
    if (!status && b->pose->joints) status = apply_skin(b, map);
    if (!status) drop_still_times(b);
    if (b->time_count > 1)
        free(b->tangents), b->tangents = NULL; /* texture coordinates have them */
    return status;
}

static snell_status add_shape(builder *b, const char *wanted, uint32_t *shape) {
    char name[NAME_MAX_SIZE];
    snell_status status = names_make_unique(&b->g->names, CATEGORY_SHAPE, wanted, name);
    if (status) return status;
    float *times = NULL; /* the description keeps what it gets */
    if (b->time_count > 1) {
        times = memory_resize(NULL, b->time_count, sizeof *times);
        if (times == NULL) return error_no_memory();
        memcpy(times, b->pose->times, b->time_count * sizeof *times);
    }
    mesh_desc desc = {.struct_size = sizeof desc,
                      .positions = (const snell_vec3 *)b->positions,
                      .positions_count = b->count * b->time_count,
                      .indices = b->indices,
                      .indices_count = b->index_count,
                      .normals = (const snell_vec3 *)b->normals,
                      .normals_count = b->normals ? b->count * b->time_count : 0,
                      .key_times = times,
                      .key_times_count = times ? b->time_count : 0,
                      .uvs = (const snell_vec2 *)b->uvs,
                      .uvs_count = b->uvs ? b->count : 0,
                      .uvs2 = (const snell_vec2 *)b->uvs2,
                      .uvs2_count = b->uvs2 ? b->count : 0,
                      .tangents = b->tangents,
                      .tangents_count = b->tangents ? 4 * b->count : 0,
                      .colors = b->colors,
                      .colors_count = b->colors ? b->count : 0,
                      .alphas = b->alphas,
                      .alphas_count = b->alphas ? b->count : 0};
    object_source source = {name[0] ? name : NULL, b->g->path, 0};
    status =
        description_take_desc(b->g->d, type_find(CATEGORY_SHAPE, "mesh"), &desc, source, shape);
    if (!status) { /* the description's now */
        b->positions = b->normals = b->uvs = b->uvs2 = b->tangents = times = NULL;
        b->colors = NULL;
        b->alphas = NULL;
        b->indices = NULL;
    }
    free(times);
    return gltf_blame(b->g, b->where, status);
}

static snell_status open_draco(builder *b) {
    const json_t *compressed = json_extension(b->primitive, "KHR_draco_mesh_compression");
    const uint8_t *data;
    size_t size;
    if (!SNELL_HAS_DRACO || compressed == NULL) return SNELL_OK;
    snell_status status =
        gltf_view_bytes(b->g, json_index(compressed, "bufferView", 0), &data, &size);
    if (status) return status;
    const char *wrong = draco_open(data, size, &b->draco);
    if (wrong) return gltf_error(b->g, SNELL_ERR_SYNTAX, b->where, "broken Draco data: %s", wrong);
    if (draco_point_count(b->draco) == b->count) return SNELL_OK;
    return gltf_error(b->g, SNELL_ERR_SYNTAX, b->where,
                      "the data that Draco has compressed has %zu vertices, the accessors have %zu",
                      draco_point_count(b->draco), b->count);
}

/* *shape stays NO_SHAPE when there is nothing to draw. */
static snell_status build_primitive(gltf *g, size_t mesh, size_t index, const pose *p,
                                    uint32_t *shape) {
    const json_t *mesh_json = json_item(g, "meshes", mesh);
    builder b = {.g = g,
                 .primitive = json_array_get(json_at(mesh_json, "primitives"), index),
                 .pose = p,
                 .time_count = p->time_count};
    size_t mode = json_index(b.primitive, "mode", MODE_TRIANGLES);
    snprintf(b.where, sizeof b.where, "meshes[%zu].primitives[%zu]", mesh, index);
    size_t position = attribute(json_at(b.primitive, "attributes"), "POSITION");
    if (position == SIZE_MAX) return gltf_warn(g, "%s: has no POSITION: not drawn", b.where);
    b.count = gltf_accessor_count(g, position);
    snell_status status = open_draco(&b);
    if (!status) status = read_topology(&b, mode);
    if (!status && (b.index_count > 0 || b.segment_count > 0)) {
        status = read_vertices(&b);
        if (!status && b.segment_count > 0)
            status = thicken(&b, mode == MODE_POINTS, gltf_scene_size(g) / p->scale);
        if (!status) status = add_shape(&b, json_text(mesh_json, "name"), shape);
    }
    builder_deinit(&b);
    return status;
}

/* ---- what a node draws ---- */

/* The bind matrices, or NULL where the skin has none. */
static snell_status read_bind_matrices(gltf *g, size_t skin, size_t count, float **out) {
    size_t accessor = json_index(json_item(g, "skins", skin), "inverseBindMatrices", SIZE_MAX);
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "skins[%zu].inverseBindMatrices", skin);
    if (accessor == SIZE_MAX) return SNELL_OK;
    if (gltf_accessor_count(g, accessor) < count)
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "has fewer matrices than joints");
    return gltf_accessor_floats(g, accessor, 16, where, out);
}

/* The clock's time that the pose's time number k is; of a still one the frame's own. */
static int clock_index(const pose *p, size_t k) {
    return p->time_count > 1 ? (int)k * CLOCK_STRIDE : CLOCK_NOW;
}

static snell_status read_joints(gltf *g, size_t skin, pose *p) {
    const json_t *joints = json_at(json_item(g, "skins", skin), "joints");
    size_t count = json_array_size(joints);
    float *inverse = NULL;
    snell_status status = read_bind_matrices(g, skin, count, &inverse);
    if (!status) status = gltf_spend(g, "skins", count * p->time_count * sizeof *p->joints);
    if (!status) p->joints = memory_zeroed(count * p->time_count + 1, sizeof *p->joints);
    if (!status && p->joints == NULL) status = error_no_memory();
    p->joint_count = count;
    for (size_t i = 0; !status && i < count; i++) {
        const gltf_node *node = &g->nodes[(size_t)json_number_value(json_array_get(joints, i))];
        dmat bind = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
        double columns[16];
        for (size_t k = 0; inverse && k < 16; k++) columns[k] = (double)inverse[16 * i + k];
        if (inverse) bind = dmat_from_columns(columns);
        for (size_t k = 0; k < p->time_count; k++) {
            dmat *joint = &p->joints[k * count + i];
            *joint = *gltf_world_at(node, clock_index(p, k));
            if (inverse) *joint = dmat_multiply(joint, &bind);
        }
    }
    free(inverse);
    return status;
}

/* Of the node, else of the mesh; an animation's at each of its times. */
static snell_status read_weights(gltf *g, const gltf_node *node, const json_t *list, pose *p) {
    const gltf_track *t = node->tracks[TRACK_WEIGHTS];
    size_t count = t ? t->width : json_array_size(list);
    snell_status status = gltf_spend(g, "weights", count * p->time_count * sizeof *p->weights);
    if (status) return status;
    p->weights = memory_zeroed(count * p->time_count + 1, sizeof *p->weights);
    if (p->weights == NULL) return error_no_memory();
    p->weight_count = count;
    for (size_t k = 0; k < p->time_count; k++) {
        double *at = p->weights + k * count;
        if (t) gltf_track_at(t, TRACK_WEIGHTS, (double)g->times[clock_index(p, k)], at);
        for (size_t i = 0; t == NULL && i < count; i++)
            at[i] = json_number_value(json_array_get(list, i));
    }
    return SNELL_OK;
}

static bool skin_moves(const gltf *g, size_t skin) {
    const json_t *joints = json_at(json_item(g, "skins", skin), "joints");
    for (size_t i = 0; i < json_array_size(joints); i++)
        if (g->nodes[(size_t)json_number_value(json_array_get(joints, i))].worlds) return true;
    return false;
}

static snell_status build_all(gltf *g, size_t mesh, const pose *p, size_t count, uint32_t **out) {
    uint32_t *shapes = memory_resize(NULL, count + 1, sizeof *shapes);
    if (shapes == NULL) return error_no_memory();
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < count; i++) shapes[i] = NO_SHAPE;
    for (size_t i = 0; i < count && !status; i++)
        status = build_primitive(g, mesh, i, p, &shapes[i]);
    if (status)
        free(shapes);
    else
        *out = shapes;
    return status;
}

snell_status gltf_mesh_shapes(gltf *g, size_t index, const uint32_t **shapes, bool *own,
                              bool *in_world) {
    const json_t *node_json = json_item(g, "nodes", index);
    const gltf_node *node = &g->nodes[index];
    size_t mesh = json_index(node_json, "mesh", 0), skin = json_index(node_json, "skin", SIZE_MAX);
    const json_t *mesh_json = json_item(g, "meshes", mesh),
                 *weights = json_at(node_json, "weights");
    mesh_entry *entry = &g->meshes[mesh];
    *in_world = skin != SIZE_MAX;
    *own = *in_world || weights != NULL || node->tracks[TRACK_WEIGHTS] != NULL;
    *shapes = entry->shapes;
    if (!*own && entry->shapes) return SNELL_OK;
    pose p = {.time_count = 1, .scale = *in_world ? 1 : gltf_scale(&node->world)};
    if (node->tracks[TRACK_WEIGHTS] || (*in_world && skin_moves(g, skin)))
        p.time_count = (CLOCK_TIMES - 1) / CLOCK_STRIDE + 1;
    for (size_t k = 0; k < p.time_count; k++) p.times[k] = g->times[clock_index(&p, k)];
    snell_status status =
        read_weights(g, node, weights ? weights : json_at(mesh_json, "weights"), &p);
    if (!status && *in_world) status = read_joints(g, skin, &p);
    uint32_t *made = NULL;
    size_t count = json_array_size(json_at(mesh_json, "primitives"));
    if (!status) status = build_all(g, mesh, &p, count, &made);
    if (!status && !*own) entry->shapes = made, entry->count = count;
    *shapes = made;
    free(p.joints);
    free(p.weights);
    return status;
}
