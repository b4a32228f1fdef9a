#include "importers/surfaces.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "geometry/mesh.h"
#include "importers/triangulate.h"
#include "importers/up.h"

void surfaces_free(surfaces *s) {
    free(s->positions);
    free(s->normals);
    free(s->colors);
    free(s->uvs);
    free(s->indices);
    free(s->slots);
    free(s->materials);
    *s = (surfaces){0};
}

source_place text_place(const char *path, const char *text, const char *at) {
    source_place place = {path, 1, 0};
    const char *line = text;
    for (const char *c = text; c < at; c++)
        if (*c == '\n' || (*c == '\r' && c[1] != '\n')) {
            place.line++;
            line = c + 1;
        }
    place.column = (uint32_t)(at - line) + 1;
    return place;
}

/* ---- polygons ---- */

uint32_t *polygons_add(polygons *p, uint32_t corners) {
    size_t needed = 3 * ((size_t)corners - 2);
    if (needed > UINT32_MAX - p->index_count) return NULL;
    if (!ARRAY_GROW(p->indices, p->index_count, p->index_capacity, needed)) return NULL;
    if (corners > 3) {
        if (!ARRAY_GROW(p->list, p->count, p->capacity, 1)) return NULL;
        p->list[p->count++] = (polygon){p->index_count, corners};
    }
    uint32_t *out = p->indices + p->index_count;
    p->index_count += needed;
    return out;
}

typedef struct cutter {
    uint32_t *ring, *cut;
    vec3 *places;
    size_t ring_capacity, cut_capacity, place_capacity;
} cutter;

static bool cut_polygon(cutter *c, uint32_t *at, uint32_t corners, const snell_vec3 *positions) {
    if (!ARRAY_GROW(c->ring, 0, c->ring_capacity, corners) ||
        !ARRAY_GROW(c->places, 0, c->place_capacity, corners) ||
        !ARRAY_GROW(c->cut, 0, c->cut_capacity, 3 * ((size_t)corners - 2)))
        return false;
    memcpy(c->ring, at, corners * sizeof *at);
    for (uint32_t i = 0; i < corners; i++) c->places[i] = positions[at[i]];
    size_t made = triangulate(c->places, corners, c->cut);
    for (size_t i = 0; i < made; i++) at[i] = c->ring[c->cut[i]];
    return true;
}

bool polygons_cut(polygons *p, const snell_vec3 *positions) {
    cutter c = {0};
    bool done = true;
    for (size_t i = 0; i < p->count && done; i++)
        done = cut_polygon(&c, p->indices + p->list[i].first, p->list[i].corners, positions);
    free(c.ring);
    free(c.cut);
    free(c.places);
    free(p->list);
    p->list = NULL;
    p->count = p->capacity = 0;
    return done;
}

/* ---- vertices at one place are one point ---- */

static uint32_t hash_position(snell_vec3 p) {
    uint32_t word[3];
    p = (snell_vec3){p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; /* -0 is 0 */
    memcpy(word, &p, sizeof word);
    uint64_t h = (word[0] * 0x9e3779b97f4a7c15u) ^ (word[1] * 0xc2b2ae3d27d4eb4fu) ^
                 (word[2] * 0x165667b19e3779f9u);
    return (uint32_t)((h ^ (h >> 29)) * 0xbf58476d1ce4e5b9u >> 32);
}

static bool same_position(snell_vec3 a, snell_vec3 b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* point[v]: the first vertex where v is. Open addressing, at most half full. */
static bool weld(const surfaces *s, uint32_t *point) {
    size_t size = 16;
    while (size < 2 * s->vertex_count) size *= 2;
    uint32_t *slots = memory_zeroed(size, sizeof *slots);
    if (slots == NULL) return false;
    for (size_t v = 0; v < s->vertex_count; v++) {
        size_t at = hash_position(s->positions[v]) & (size - 1);
        while (slots[at] && !same_position(s->positions[slots[at] - 1], s->positions[v]))
            at = (at + 1) & (size - 1);
        if (slots[at] == 0) slots[at] = (uint32_t)v + 1;
        point[v] = slots[at] - 1;
    }
    free(slots);
    return true;
}

/* ---- normals ---- */

typedef struct smoother {
    surfaces *s;
    const uint8_t *lacks;
    const uint32_t *groups;
    uint32_t *point; /* of each vertex, until the corners are listed */
    uint32_t *begin; /* corners[begin[p] .. begin[p + 1]) lie at point p */
    uint32_t *corners;
    snell_vec3 *faces; /* unit normals, 0 of a triangle without area */
    uint8_t *done;     /* vertices that have their normal */
    uint32_t *source;  /* of each vertex that was added */
    snell_vec3 *added;
    size_t added_count, added_capacity, source_capacity;
} smoother;

/* Corners at one place; what has more is smooth by clusters. */
enum { CORNERS_COMPARED_MAX = 128, CLUSTERS_MAX = 128 };
static const float cos_30 = 0.8660254f, cos_60 = 0.5001f; /* a little less than 60 degrees */

static float dot(snell_vec3 a, snell_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static snell_vec3 plus(snell_vec3 a, snell_vec3 b) {
    return (snell_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static snell_vec3 unit(snell_vec3 v) {
    float length = sqrtf(dot(v, v));
    return length > 0 ? (snell_vec3){v.x / length, v.y / length, v.z / length} : v;
}

static snell_vec3 face_normal(const surfaces *s, size_t triangle) {
    const uint32_t *i = s->indices + 3 * triangle;
    dvec3 a = dvec3_from(s->positions[i[0]]);
    dvec3 n = dvec3_cross(dvec3_sub(dvec3_from(s->positions[i[1]]), a),
                          dvec3_sub(dvec3_from(s->positions[i[2]]), a));
    double square = dvec3_dot(n, n);
    if (!(square > 0)) return (snell_vec3){0, 0, 0};
    return vec3_from(dvec3_scale(n, 1 / sqrt(square)));
}

static uint32_t group_of(const smoother *m, uint32_t corner) {
    return m->groups ? m->groups[corner / 3] : SURFACES_BY_ANGLE;
}

static bool counts(const smoother *m, uint32_t corner) {
    return m->lacks == NULL || m->lacks[m->s->indices[corner]];
}

static bool list_corners(smoother *m) {
    surfaces *s = m->s;
    size_t count = s->vertex_count;
    m->begin = memory_zeroed(count + 1, sizeof *m->begin);
    m->corners = memory_resize(NULL, s->index_count, sizeof *m->corners);
    if (m->begin == NULL || m->corners == NULL) return false;
    for (uint32_t c = 0; c < s->index_count; c++)
        if (counts(m, c)) m->begin[m->point[s->indices[c]]]++;
    uint32_t sum = 0;
    for (size_t p = 0; p <= count; p++) {
        sum += m->begin[p];
        m->begin[p] = sum; /* its end: filled from there backwards */
    }
    for (uint32_t c = (uint32_t)s->index_count; c-- > 0;)
        if (counts(m, c)) m->corners[--m->begin[m->point[s->indices[c]]]] = c;
    return true;
}

/* Gives a corner's vertex its normal, or the corner another vertex where that has one already. `before`: the corners of
 * its point that were there before it. */
static bool set_normal(smoother *m, uint32_t corner, snell_vec3 normal, const uint32_t *before,
                       size_t before_count, uint32_t first) {
    surfaces *s = m->s;
    uint32_t vertex = first;
    if (!m->done[vertex]) {
        m->done[vertex] = 1;
        s->normals[vertex] = normal;
        return true;
    }
    if (memcmp(&s->normals[vertex], &normal, sizeof normal) == 0) return true;
    for (size_t k = before_count; k-- > 0;) {
        uint32_t other = s->indices[before[k]];
        if (other < s->vertex_count) continue;
        size_t extra = other - s->vertex_count;
        if (m->source[extra] == vertex && memcmp(&m->added[extra], &normal, sizeof normal) == 0) {
            s->indices[corner] = other;
            return true;
        }
    }
    if (s->vertex_count + m->added_count >= UINT32_MAX ||
        !ARRAY_GROW(m->added, m->added_count, m->added_capacity, 1) ||
        !ARRAY_GROW(m->source, m->added_count, m->source_capacity, 1))
        return false;
    m->added[m->added_count] = normal;
    m->source[m->added_count] = vertex;
    s->indices[corner] = (uint32_t)(s->vertex_count + m->added_count++);
    return true;
}

static bool all_are_smooth(const smoother *m, const uint32_t *list, size_t count,
                           snell_vec3 *normal) {
    snell_vec3 sum = {0, 0, 0};
    uint32_t group = group_of(m, list[0]);
    for (size_t i = 0; i < count; i++) {
        sum = plus(sum, m->faces[list[i] / 3]);
        if (group_of(m, list[i]) != group) return false;
    }
    *normal = unit(sum);
    if (count > 1 && group == SURFACES_FLAT) return false;
    for (size_t i = 0; i < count; i++) {
        snell_vec3 n = m->faces[list[i] / 3];
        if (dot(n, *normal) < cos_30 && dot(n, n) > 0) return false;
    }
    return true;
}

static snell_vec3 mean_beside(const smoother *m, const uint32_t *list, size_t count, size_t i) {
    uint32_t group = group_of(m, list[i]);
    snell_vec3 own = m->faces[list[i] / 3], sum = own;
    if (group == SURFACES_FLAT) return own;
    for (size_t k = 0; k < count; k++)
        if (k != i && group_of(m, list[k]) == group && dot(own, m->faces[list[k] / 3]) > cos_60)
            sum = plus(sum, m->faces[list[k] / 3]);
    return unit(sum);
}

/* So many faces meet here that to compare each with each would take too long. */
typedef struct cluster {
    snell_vec3 seed, sum;
    uint32_t group;
} cluster;

static size_t find_cluster(const smoother *m, cluster *list, size_t *count, uint32_t corner) {
    snell_vec3 n = m->faces[corner / 3];
    uint32_t group = group_of(m, corner);
    bool any = *count == CLUSTERS_MAX || !(dot(n, n) > 0); /* without area it is like all */
    for (size_t i = 0; i < *count; i++)
        if (list[i].group == group && (any || dot(list[i].seed, n) > cos_30)) return i;
    if (*count == CLUSTERS_MAX) return 0;
    list[*count] = (cluster){n, {0, 0, 0}, group};
    return (*count)++;
}

static bool smooth_crowd(smoother *m, const uint32_t *list, size_t count) {
    cluster clusters[CLUSTERS_MAX];
    size_t used = 0;
    for (size_t i = 0; i < count; i++) {
        size_t k = find_cluster(m, clusters, &used, list[i]);
        clusters[k].sum = plus(clusters[k].sum, m->faces[list[i] / 3]);
    }
    for (size_t i = 0; i < count; i++) {
        snell_vec3 own = m->faces[list[i] / 3];
        size_t k = find_cluster(m, clusters, &used, list[i]), near = i < 64 ? i : 64;
        if (!set_normal(m, list[i], clusters[k].group ? unit(clusters[k].sum) : own,
                        list + i - near, near, m->s->indices[list[i]]))
            return false;
    }
    return true;
}

static bool smooth_point(smoother *m, const uint32_t *list, size_t count) {
    snell_vec3 normal;
    if (all_are_smooth(m, list, count, &normal)) {
        for (size_t i = 0; i < count; i++) m->s->normals[m->s->indices[list[i]]] = normal;
        return true;
    }
    if (count > CORNERS_COMPARED_MAX) return smooth_crowd(m, list, count);
    for (size_t i = 0; i < count; i++)
        if (!set_normal(m, list[i], mean_beside(m, list, count, i), list, i,
                        m->s->indices[list[i]]))
            return false;
    return true;
}

static bool append_vertices(smoother *m) {
    surfaces *s = m->s;
    size_t old = s->vertex_count, count = old + m->added_count;
    if (m->added_count == 0) return true;
    void **arrays[] = {(void **)&s->positions, (void **)&s->normals, (void **)&s->colors,
                       (void **)&s->uvs};
    static const size_t sizes[] = {sizeof(snell_vec3), sizeof(snell_vec3), sizeof(snell_vec3),
                                   sizeof(snell_vec2)};
    for (int a = 0; a < 4; a++) {
        if (*arrays[a] == NULL) continue;
        char *grown = memory_resize(*arrays[a], count, sizes[a]);
        if (grown == NULL) return false;
        *arrays[a] = grown;
        for (size_t i = 0; i < m->added_count; i++)
            memcpy(grown + (old + i) * sizes[a], grown + m->source[i] * sizes[a], sizes[a]);
    }
    memcpy(s->normals + old, m->added, m->added_count * sizeof *m->added);
    s->vertex_count = count;
    return true;
}

static bool smooth_all(smoother *m) {
    surfaces *s = m->s;
    size_t triangles = s->index_count / 3;
    m->point = memory_resize(NULL, s->vertex_count, sizeof *m->point);
    if (!m->point || !weld(s, m->point) || !list_corners(m)) return false;
    free(m->point); /* what follows is the most that a load takes */
    m->point = NULL;
    m->faces = memory_resize(NULL, triangles, sizeof *m->faces);
    m->done = memory_zeroed(s->vertex_count, 1);
    if (s->normals == NULL) s->normals = memory_zeroed(s->vertex_count, sizeof *s->normals);
    if (!m->faces || !m->done || !s->normals) return false;
    for (size_t t = 0; t < triangles; t++) m->faces[t] = face_normal(s, t);
    for (size_t p = 0; p < s->vertex_count; p++) {
        size_t begin = m->begin[p], count = m->begin[p + 1] - begin;
        if (count > 0 && !smooth_point(m, m->corners + begin, count)) return false;
    }
    return append_vertices(m);
}

snell_status surfaces_smooth(surfaces *s, const uint8_t *lacks, const uint32_t *groups) {
    smoother m = {.s = s, .lacks = lacks, .groups = groups};
    bool done = smooth_all(&m);
    free(m.point);
    free(m.begin);
    free(m.corners);
    free(m.faces);
    free(m.done);
    free(m.source);
    free(m.added);
    return done ? SNELL_OK : error_no_memory();
}

/* ---- into the description ---- */

snell_status surfaces_plain(description *d, const char *path, float c, uint32_t *material) {
    if (*material != NO_MATERIAL) return SNELL_OK;
    const snell_param color = {"color", SNELL_PARAM_VEC3, {.v = {c, c, c}}};
    return description_add(d, CATEGORY_MATERIAL, "lambert", &color, 1,
                           (object_source){NULL, path, 0}, material);
}

static snell_status add_shape(surfaces *s, description *d, object_source source, uint32_t *shape) {
    size_t count = s->vertex_count;
    mesh_desc desc = {.struct_size = sizeof desc,
                      .positions = s->positions,
                      .positions_count = count,
                      .indices = s->indices,
                      .indices_count = s->index_count,
                      .normals = s->normals,
                      .normals_count = s->normals ? count : 0,
                      .uvs = s->uvs,
                      .uvs_count = s->uvs ? count : 0,
                      .colors = s->colors,
                      .colors_count = s->colors ? count : 0,
                      .material_slots = s->slots,
                      .material_slots_count = s->slots ? s->index_count / 3 : 0,
                      .materials = s->materials,
                      .materials_count = s->material_count};
    snell_status status =
        description_take_desc(d, type_find(CATEGORY_SHAPE, "mesh"), &desc, source, shape);
    if (status == SNELL_OK)
        *s = (surfaces){0};
    else
        surfaces_free(s);
    return status;
}

snell_status surfaces_add(surfaces *s, description *d, name_set *names, const char *name,
                          uint32_t material, const char *up, object_source where) {
    char shape_name[NAME_MAX_SIZE] = "", instance_name[NAME_MAX_SIZE] = "";
    snell_status status = names_make_unique(names, CATEGORY_SHAPE, name, shape_name);
    if (!status) status = names_make_unique(names, NAMES_INSTANCE, name, instance_name);
    if (status) {
        surfaces_free(s);
        return status;
    }
    uint32_t shape, unused;
    where.name = shape_name[0] ? shape_name : NULL;
    status = add_shape(s, d, where, &shape);
    if (status) return status == SNELL_ERR_ARGUMENT ? SNELL_ERR_SYNTAX : status;
    transform turned;
    import_up_rotation(up, &turned);
    where.name = instance_name[0] ? instance_name : NULL;
    return description_add_instance(d, shape, material, &turned, where, &unused);
}
