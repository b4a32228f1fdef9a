/* Triangles of pbrt's shapes: meshes from files, Loop's subdivision, surfaces in parts. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "geometry/mesh.h"
#include "importers/files.h"
#include "importers/pbrt.h"

void pbrt_mesh_free(pbrt_mesh *mesh) {
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->uvs);
    free(mesh->indices);
    *mesh = (pbrt_mesh){.count = 0};
}

snell_status pbrt_mesh_make(pbrt *p, source_place place, size_t count, size_t triangles,
                            bool normals, bool uvs, pbrt_mesh *out) {
    *out = (pbrt_mesh){.count = count, .index_count = 3 * triangles};
    if (pbrt_spend(p, place, (uint64_t)count * 64 + (uint64_t)triangles * 12)) return p->status;
    out->positions = memory_zeroed(count + 1, sizeof *out->positions);
    out->indices = memory_zeroed(3 * triangles + 1, sizeof *out->indices);
    if (normals) out->normals = memory_zeroed(count + 1, sizeof *out->normals);
    if (uvs) out->uvs = memory_zeroed(count + 1, sizeof *out->uvs);
    if (out->positions && out->indices && (out->normals || !normals) && (out->uvs || !uvs))
        return SNELL_OK;
    pbrt_mesh_free(out);
    return pbrt_blame(p, place, error_no_memory());
}

double pbrt_mesh_area(const pbrt_mesh *mesh) {
    double area = 0;
    for (size_t i = 0; i < mesh->index_count; i += 3) {
        const uint32_t *t = mesh->indices + i;
        dvec3 a = mesh->positions[t[0]];
        area += dvec3_length(dvec3_cross(dvec3_sub(mesh->positions[t[1]], a),
                                         dvec3_sub(mesh->positions[t[2]], a))) /
                2;
    }
    return area;
}

/* ---- meshes of files ---- */

/* Does the header of a PLY file name its normals? Other readers make some where there are none; pbrt
 * takes such meshes as flat. */
static bool has_normals(const char *path) {
    char header[4097];
    FILE *file = fopen(path, "rb");
    if (file == NULL) return false;
    size_t size = fread(header, 1, sizeof header - 1, file);
    fclose(file);
    for (size_t i = 0; i < size; i++)
        if (header[i] == 0) header[i] = '\n';
    header[size] = 0;
    char *end = strstr(header, "end_header"), *found = strstr(header, " nx");
    return found && (end == NULL || found < end);
}

/* All meshes of a description as one. */
static snell_status gather(pbrt *p, source_place place, const description *from, bool normals,
                           pbrt_mesh *out) {
    const object_list *shapes = &from->objects[CATEGORY_SHAPE];
    size_t count = 0, triangles = 0;
    bool uvs = false;
    for (size_t i = 0; i < shapes->count; i++) {
        const mesh_desc *m = shapes->items[i].desc;
        if (strcmp(shapes->items[i].type->name, "mesh") != 0) continue;
        count += m->positions_count;
        triangles += m->indices_count / 3;
        normals = normals && m->normals_count == m->positions_count;
        uvs |= m->uvs_count > 0;
    }
    if (pbrt_mesh_make(p, place, count, triangles, normals, uvs, out)) return p->status;
    count = triangles = 0;
    for (size_t i = 0; i < shapes->count; i++) {
        const mesh_desc *m = shapes->items[i].desc;
        if (strcmp(shapes->items[i].type->name, "mesh") != 0) continue;
        for (size_t k = 0; k < m->indices_count / 3 * 3; k++)
            out->indices[3 * triangles + k] = m->indices[k] + (uint32_t)count;
        triangles += m->indices_count / 3;
        for (size_t k = 0; k < m->positions_count; k++, count++) {
            out->positions[count] = dvec3_from(m->positions[k]);
            if (normals) out->normals[count] = dvec3_from(m->normals[k]);
            if (m->uvs_count == m->positions_count) {
                out->uvs[count][0] = (double)m->uvs[k].x;
                out->uvs[count][1] = (double)m->uvs[k].y;
            }
        }
    }
    return SNELL_OK;
}

snell_status pbrt_read_ply(pbrt *p, const char *name, source_place place, pbrt_mesh *out) {
    *out = (pbrt_mesh){.count = 0};
    char *path = NULL;
    size_t length = strlen(name);
    if (length > 3 && strcmp(name + length - 3, ".gz") == 0)
        return pbrt_fail(p, place, "unpack it with gunzip, and name the unpacked file",
                         "'%.200s' is compressed", name);
    snell_status status = import_resolve(p->path, name, p->options, &path);
    if (status) return pbrt_blame(p, place, status);
    import_options options = *p->options;
    options.up = NULL;
    options.progress = NULL;
    description *from = NULL;
    status = description_create(&from);
    if (!status) status = import_file(path, "ply", &options, from);
    if (status)
        pbrt_blame(p, place, status);
    else
        gather(p, place, from, has_normals(path), out);
    description_destroy(from);
    free(path);
    return p->status;
}

/* ---- Loop's subdivision ---- */

/* Loop, Smooth Subdivision Surfaces Based on Triangles, master's thesis, University of Utah 1987, with
 * Warren's weights for the vertices, as pbrt has them. */
typedef struct half_edge {
    uint32_t low, high;   /* its ends */
    uint32_t face_corner; /* the corner that it begins at: 3 * triangle + 0..2 */
} half_edge;

typedef struct ring {    /* what is around a vertex */
    dvec3 sum, edge_sum; /* of all neighbours; of those along the boundary */
    uint32_t count, edge_count;
} ring;

static int compare_edges(const void *a, const void *b) {
    const half_edge *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    return x->face_corner < y->face_corner ? -1 : x->face_corner > y->face_corner;
}

static half_edge edge_at(const pbrt_mesh *mesh, size_t i) {
    uint32_t a = mesh->indices[i], b = mesh->indices[i % 3 == 2 ? i - 2 : i + 1];
    return (half_edge){a < b ? a : b, a < b ? b : a, (uint32_t)i};
}

/* Sorted, so that the halves of an edge are neighbours: counted by their lower ends, of which each has
 * few. */
static half_edge *make_edges(const pbrt_mesh *mesh) {
    half_edge *edges = memory_resize(NULL, mesh->index_count + 1, sizeof *edges);
    size_t *ends = memory_zeroed(mesh->count + 1, sizeof *ends);
    if (edges && ends) {
        for (size_t i = 0; i < mesh->index_count; i++) ends[edge_at(mesh, i).low]++;
        for (size_t v = 1; v < mesh->count; v++) ends[v] += ends[v - 1];
        for (size_t i = mesh->index_count; i-- > 0;) {
            half_edge edge = edge_at(mesh, i);
            edges[--ends[edge.low]] = edge; /* in the end, where those of the vertex begin */
        }
        for (size_t v = 0; v < mesh->count; v++) {
            size_t end = v + 1 < mesh->count ? ends[v + 1] : mesh->index_count;
            qsort(edges + ends[v], end - ends[v], sizeof *edges, compare_edges);
        }
    } else {
        free(edges);
        edges = NULL;
    }
    free(ends);
    return edges;
}

static size_t same_edge(const half_edge *edges, size_t at, size_t count) {
    size_t end = at + 1;
    while (end < count && edges[end].low == edges[at].low && edges[end].high == edges[at].high)
        end++;
    return end - at;
}

static void meet(ring *r, dvec3 neighbour, bool on_edge) {
    r->sum = dvec3_add(r->sum, neighbour);
    r->count++;
    if (!on_edge) return;
    r->edge_sum = dvec3_add(r->edge_sum, neighbour);
    r->edge_count++;
}

static ring *make_rings(const pbrt_mesh *mesh, const half_edge *edges, size_t *edge_count) {
    ring *rings = memory_zeroed(mesh->count + 1, sizeof *rings);
    *edge_count = 0;
    for (size_t i = 0, step; rings && i < mesh->index_count; i += step) {
        step = same_edge(edges, i, mesh->index_count);
        meet(&rings[edges[i].low], mesh->positions[edges[i].high], step != 2);
        meet(&rings[edges[i].high], mesh->positions[edges[i].low], step != 2);
        ++*edge_count;
    }
    return rings;
}

/* (1 - n w) p + w times the sum of the n neighbours. */
static dvec3 weighted(dvec3 p, dvec3 sum, uint32_t n, double w) {
    return dvec3_add(dvec3_scale(p, 1 - n * w), dvec3_scale(sum, w));
}

static double inner_weight(uint32_t n) { return n == 3 ? 3.0 / 16 : 3 / (8.0 * n); }

/* inner, edge: the weights of neighbours. */
static dvec3 smooth(dvec3 p, const ring *r, double inner, double edge) {
    if (r->edge_count == 2) return weighted(p, r->edge_sum, 2, edge);
    if (r->edge_count || r->count == 0) return p; /* a corner, or nothing is around it */
    return weighted(p, r->sum, r->count, inner);
}

/* The vertex in the middle of an edge of one, two or more triangles. */
static dvec3 middle_of(const pbrt_mesh *mesh, const half_edge *edge, size_t halves) {
    dvec3 ends = dvec3_add(mesh->positions[edge->low], mesh->positions[edge->high]);
    if (halves != 2) return dvec3_scale(ends, 0.5);
    dvec3 across = {0, 0, 0};
    for (int i = 0; i < 2; i++) {
        uint32_t corner = edge[i].face_corner, opposite = corner - corner % 3 + (corner + 2) % 3;
        across = dvec3_add(across, mesh->positions[mesh->indices[opposite]]);
    }
    return dvec3_add(dvec3_scale(ends, 3.0 / 8), dvec3_scale(across, 1.0 / 8));
}

static void split(const pbrt_mesh *mesh, const half_edge *edges, const ring *rings,
                  uint32_t *middles, pbrt_mesh *out) {
    for (size_t i = 0; i < mesh->count; i++)
        out->positions[i] = smooth(mesh->positions[i], &rings[i],
                                   rings[i].count ? inner_weight(rings[i].count) : 0, 1.0 / 8);
    uint32_t next = (uint32_t)mesh->count;
    for (size_t i = 0, step; i < mesh->index_count; i += step, next++) {
        step = same_edge(edges, i, mesh->index_count);
        out->positions[next] = middle_of(mesh, &edges[i], step);
        for (size_t k = 0; k < step; k++) middles[edges[i + k].face_corner] = next;
    }
    for (size_t i = 0; i < mesh->index_count; i += 3) {
        const uint32_t *v = mesh->indices + i, *m = middles + i;
        const uint32_t four[12] = {v[0], m[0], m[2], m[0], v[1], m[1],
                                   m[2], m[1], v[2], m[0], m[1], m[2]};
        memcpy(out->indices + 4 * i, four, sizeof four);
    }
}

static snell_status split_once(pbrt *p, source_place place, pbrt_mesh *mesh) {
    if (pbrt_spend(p, place, (uint64_t)mesh->index_count * 20 + (uint64_t)mesh->count * 64))
        return p->status;
    size_t edge_count = 0;
    half_edge *edges = make_edges(mesh);
    ring *rings = edges ? make_rings(mesh, edges, &edge_count) : NULL;
    uint32_t *middles = memory_zeroed(mesh->index_count + 1, sizeof *middles);
    pbrt_mesh out = {.count = 0};
    if (edges == NULL || rings == NULL || middles == NULL)
        pbrt_blame(p, place, error_no_memory());
    else if (!pbrt_mesh_make(p, place, mesh->count + edge_count, mesh->index_count / 3 * 4, false,
                             false, &out))
        split(mesh, edges, rings, middles, &out);
    free(edges);
    free(rings);
    free(middles);
    if (p->status) return p->status;
    pbrt_mesh_free(mesh);
    *mesh = out;
    return SNELL_OK;
}

/* Of the faces around each vertex, by their area. */
static snell_status add_normals(pbrt *p, source_place place, pbrt_mesh *mesh) {
    mesh->normals = memory_zeroed(mesh->count + 1, sizeof *mesh->normals);
    if (mesh->normals == NULL) return pbrt_blame(p, place, error_no_memory());
    for (size_t i = 0; i < mesh->index_count; i += 3) {
        const uint32_t *t = mesh->indices + i;
        dvec3 a = mesh->positions[t[0]], n = dvec3_cross(dvec3_sub(mesh->positions[t[1]], a),
                                                         dvec3_sub(mesh->positions[t[2]], a));
        for (int k = 0; k < 3; k++) mesh->normals[t[k]] = dvec3_add(mesh->normals[t[k]], n);
    }
    return SNELL_OK;
}

snell_status pbrt_subdivide(pbrt *p, source_place place, int levels, pbrt_mesh *mesh) {
    for (int i = 0; i < levels; i++)
        if (split_once(p, place, mesh)) return p->status;
    /* To where subdividing for ever would take them. */
    size_t unused;
    half_edge *edges = make_edges(mesh);
    ring *rings = edges ? make_rings(mesh, edges, &unused) : NULL;
    for (size_t i = 0; rings && i < mesh->count; i++) {
        uint32_t n = rings[i].count;
        double inner = n ? 1 / (n + 3 / (8 * inner_weight(n))) : 0;
        mesh->positions[i] = smooth(mesh->positions[i], &rings[i], inner, 1.0 / 5);
    }
    bool failed = rings == NULL;
    free(edges);
    free(rings);
    return failed ? pbrt_blame(p, place, error_no_memory()) : add_normals(p, place, mesh);
}

/* ---- surfaces of u and v ---- */

snell_status pbrt_tessellate(pbrt *p, source_place place, uint32_t columns, uint32_t rows,
                             pbrt_surface_fn *at, const void *user, pbrt_mesh *out) {
    if (pbrt_mesh_make(p, place, (size_t)(columns + 1) * (rows + 1), (size_t)columns * rows * 2,
                       true, true, out))
        return p->status;
    uint32_t *index = out->indices;
    for (uint32_t j = 0, i = 0; j <= rows; j++)
        for (uint32_t k = 0; k <= columns; k++, i++) {
            out->uvs[i][0] = (double)k / columns;
            out->uvs[i][1] = (double)j / rows;
            at(user, out->uvs[i][0], out->uvs[i][1], &out->positions[i], &out->normals[i]);
            if (j == rows || k == columns) continue;
            uint32_t above = i + columns + 1;
            const uint32_t two[6] = {i, i + 1, above + 1, i, above + 1, above};
            memcpy(index, two, sizeof two);
            index += 6;
        }
    return SNELL_OK;
}
