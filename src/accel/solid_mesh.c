/* All crossings of a line with a closed mesh, none missed and none met twice.
 *
 * As in the watertight test of the kernels the mesh is sheared so that the line is the z axis, and a
 * triangle is crossed if the origin lies on one side of its three edges. Here all is in double, the
 * signs are exact for the sheared vertices, and where the origin lies on an edge it counts as moved
 * by (e, e^2), e infinitely small (Edelsbrunner, Muecke, Simulation of Simplicity, ACM TOG 9(1),
 * 1990). A vertex is sheared to one point, whichever triangle asks; so the sheared mesh is closed
 * too, and the line is inside as often as not. */
#include "accel/solid_mesh.h"

#include <stdlib.h>

#include "accel/build.h"
#include "base/memory.h"
#include "geometry/surface.h"

enum { CROSSINGS_MAX = 2 * SOLID_SPANS_MAX };

/* ---- building ---- */

void solid_mesh_destroy(solid_mesh *m) {
    if (m == NULL) return;
    build_tree_free(&m->tree);
    free(m);
}

static double reach_of(bounds3 b) {
    const float *values[2] = {&b.min.x, &b.max.x};
    double reach = 0;
    for (int i = 0; i < 6; i++) reach = double_max(reach, fabs((double)values[i / 3][i % 3]));
    return reach;
}

snell_status solid_mesh_create(const mesh_desc *mesh, thread_pool *pool, solid_mesh **out) {
    vec3 edge[2];
    bounds3 bounds;
    size_t count = 0;
    solid_mesh *m = memory_zeroed(1, sizeof *m);
    build_reference *references = m ? build_mesh_references(mesh, pool, &count, &bounds) : NULL;
    snell_status status = references ? SNELL_OK : error_no_memory();
    if (m) m->mesh = mesh;
    if (!status) status = mesh_find_closure(mesh, &m->closure, edge);
    if (!status && count) {
        build_progress progress = {.total = count};
        build_job job = {.references = references,
                         .count = count,
                         .mesh = mesh,
                         .leaf_size = SOLID_MESH_LEAF,
                         .progress = &progress};
        m->reach = reach_of(bounds);
        status = build_tree(&job, pool, false, &m->tree);
        if (status) error_no_memory();
    } else {
        memory_free_aligned(references);
    }
    if (status)
        solid_mesh_destroy(m);
    else
        *out = m;
    return status;
}

/* ---- one triangle ---- */

typedef struct sheared_line {
    double o[3], d[3], shear[2];
    int k[3];      /* k[2]: the axis along which the line runs most */
    double inv[3]; /* 1/d */
    double margin; /* boxes are widened by it, far more than anything is rounded */
} sheared_line;

/* False: no direction. */
static bool make_line(const solid_mesh *m, dvec3 o, dvec3 d, sheared_line *out) {
    *out = (sheared_line){.o = {o.x, o.y, o.z}, .d = {d.x, d.y, d.z}};
    double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
    int along = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    out->k[0] = (along + 1) % 3;
    out->k[1] = (along + 2) % 3;
    out->k[2] = along;
    for (int i = 0; i < 2; i++) out->shear[i] = out->d[out->k[i]] / out->d[along];
    for (int i = 0; i < 3; i++) out->inv[i] = 1 / out->d[i];
    out->margin = 0x1p-40 * (m->reach + fabs(o.x) + fabs(o.y) + fabs(o.z));
    return out->d[along] != 0 && isfinite(out->margin);
}

/* x = high + low exactly, each of at most 27 bits (Veltkamp); then a b - product, exactly (Dekker, A
 * Floating-Point Technique for Extending the Available Precision, Numerische Mathematik 18, 1971). */
static double split_high(double x) {
    double scaled = x * 134217729.0;
    return scaled - (scaled - x);
}

static double product_rest(double a, double b, double product) {
    double a_high = split_high(a), a_low = a - a_high, b_high = split_high(b), b_low = b - b_high;
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
}

typedef struct sheared_point {
    double x, y, z;
} sheared_point;

/* On which side of the edge from a to b the origin lies: -1 or 1; 0 for an edge that is a point. */
static int edge_side(sheared_point a, sheared_point b) {
    double p = a.x * b.y, q = a.y * b.x;
    if (p != q) return p > q ? 1 : -1; /* rounding keeps order */
    double p_rest = product_rest(a.x, b.y, p), q_rest = product_rest(a.y, b.x, q);
    if (p_rest != q_rest) return p_rest > q_rest ? 1 : -1;
    if (a.y != b.y) return a.y > b.y ? 1 : -1;
    if (a.x != b.x) return b.x > a.x ? 1 : -1;
    return 0;
}

typedef struct mesh_crossing {
    double t;
    float u, v;
    uint32_t triangle;
    int turn; /* +1 where it enters a triangle wound counter-clockwise from outside, else -1 */
} mesh_crossing;

/* Of the vertices of a triangle seen edge-on, which is a stretch of a line through the origin: the
 * middle of what the line meets of it, between two of its edges. */
static void find_weights_edge_on(const sheared_point p[3], double w[3]) {
    double x = 0, y = 0, total = 0;
    for (int i = 0; i < 3; i++) {
        x = double_max(x, fabs(p[i].x));
        y = double_max(y, fabs(p[i].y));
        w[i] = 0;
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        double a = x >= y ? p[i].x : p[i].y, b = x >= y ? p[j].x : p[j].y;
        if ((a > 0 && b > 0) || (a < 0 && b < 0) || a == b) continue;
        w[i] += b / (b - a);
        w[j] += -a / (b - a);
        total++;
    }
    for (int i = 0; i < 3; i++) w[i] = total > 0 ? w[i] / total : 1.0 / 3;
}

/* Barycentric coordinates of the origin, whose side of the three edges is known exactly. */
static void find_weights(const sheared_point p[3], int side, double w[3]) {
    double sum = 0, largest = 0;
    for (int i = 0; i < 3; i++) { /* the edge opposite to vertex i */
        sheared_point a = p[(i + 1) % 3], b = p[(i + 2) % 3];
        double left = a.x * b.y, right = a.y * b.x;
        w[i] = double_max(side * (left - right), 0);
        sum += w[i];
        largest = double_max(largest, double_max(fabs(left), fabs(right)));
    }
    if (sum > 0x1p-30 * largest)
        for (int i = 0; i < 3; i++) w[i] /= sum;
    else
        find_weights_edge_on(p, w);
}

static bool cross_triangle(const sheared_line *line, const triangle_block *block, uint32_t lane,
                           mesh_crossing *out) {
    sheared_point p[3];
    for (int i = 0; i < 3; i++) {
        const float(*axes)[BVH_WIDTH] = block->vertex[i];
        p[i].z = (double)axes[line->k[2]][lane] - line->o[line->k[2]];
        p[i].x = ((double)axes[line->k[0]][lane] - line->o[line->k[0]]) - line->shear[0] * p[i].z;
        p[i].y = ((double)axes[line->k[1]][lane] - line->o[line->k[1]]) - line->shear[1] * p[i].z;
    }
    int side = edge_side(p[0], p[1]);
    if (side == 0 || edge_side(p[1], p[2]) != side || edge_side(p[2], p[0]) != side) return false;
    double w[3], z = 0;
    find_weights(p, side, w);
    for (int i = 0; i < 3; i++) z += w[i] * p[i].z;
    out->t = z / line->d[line->k[2]];
    out->u = (float)w[1];
    out->v = (float)w[2];
    out->triangle = block->primitive[lane];
    /* Counter-clockwise about +z faces +z: a line that runs along +z leaves there. */
    out->turn = (side > 0) == (line->d[line->k[2]] > 0) ? -1 : 1;
    return true;
}

/* ---- all of them ---- */

/* Does the line pass the child's box, widened? */
static bool meets_child(const sheared_line *line, const bvh_node *node, int child) {
    double near = -INFINITY, far = INFINITY;
    for (int i = 0; i < 3; i++) {
        double low = (double)node->bounds[0][i][child] - line->margin - line->o[i],
               high = (double)node->bounds[1][i][child] + line->margin - line->o[i];
        if (line->d[i] == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        double a = low * line->inv[i], b = high * line->inv[i];
        near = double_max(double_min(a, b), near);
        far = double_min(double_max(a, b), far);
    }
    return near <= far;
}

static int add_leaf(const solid_mesh *m, const sheared_line *line, uint32_t reference,
                    mesh_crossing *found, int count) {
    const triangle_block *block = &m->tree.blocks[reference & BVH_INDEX_MASK];
    uint32_t triangles = (reference >> BVH_COUNT_SHIFT & 7) + 1;
    for (uint32_t i = 0; i < triangles && count <= CROSSINGS_MAX; i++) {
        mesh_crossing one;
        if (!cross_triangle(line, block, i, &one)) continue;
        if (count < CROSSINGS_MAX) found[count] = one;
        count++;
    }
    return count;
}

/* Returns how many; more than CROSSINGS_MAX: one more than that. */
static int find_crossings(const solid_mesh *m, const sheared_line *line, mesh_crossing *found) {
    uint32_t stack[BVH_STACK_SIZE], depth = 0;
    int count = 0;
    stack[depth++] = m->tree.root;
    while (depth > 0 && count <= CROSSINGS_MAX) {
        uint32_t reference = stack[--depth];
        if (reference & BVH_LEAF) {
            count = add_leaf(m, line, reference, found, count);
            continue;
        }
        const bvh_node *node = &m->tree.nodes[reference];
        for (int i = 0; i < BVH_WIDTH; i++)
            if (node->valid >> i & 1 && meets_child(line, node, i)) stack[depth++] = node->child[i];
    }
    return count;
}

/* By t, then by triangle, whatever the tree. */
static int compare_crossings(const void *a, const void *b) {
    const mesh_crossing *x = a, *y = b;
    if (x->t != y->t) return x->t < y->t ? -1 : 1;
    return x->triangle < y->triangle ? -1 : x->triangle > y->triangle;
}

/* Lists are short; the order is total, so it does not matter how it is found. */
static void sort_crossings(mesh_crossing *found, int count) {
    if (count > 32) {
        qsort(found, (size_t)count, sizeof *found, compare_crossings);
        return;
    }
    for (int i = 1; i < count; i++) {
        mesh_crossing one = found[i];
        int place = i;
        for (; place > 0 && compare_crossings(&one, &found[place - 1]) < 0; place--)
            found[place] = found[place - 1];
        found[place] = one;
    }
}

static surface_crossing surface_crossing_of(const mesh_crossing *c) {
    return (surface_crossing){c->t, c->u, c->v, c->triangle};
}

int solid_mesh_spans(const solid_mesh *m, dvec3 o, dvec3 d, span *out, int capacity) {
    mesh_crossing found[CROSSINGS_MAX];
    sheared_line line;
    if (m->tree.block_count == 0 || !make_line(m, o, d, &line)) return 0;
    int count = find_crossings(m, &line, found), spans = 0, winding = 0;
    if (count > CROSSINGS_MAX) return capacity + 1;
    sort_crossings(found, count);
    surface_crossing enter = {0};
    for (int i = 0; i < count && spans <= capacity; i++) {
        bool before = winding != 0;
        winding = m->closure == MESH_ORIENTED ? winding + found[i].turn : !winding;
        surface_crossing here = surface_crossing_of(&found[i]);
        if (before == (winding != 0)) continue;
        if (before) {
            spans = surface_add_span(out, spans, capacity, enter, here);
        } else if (spans > 0 && spans <= capacity && !(out[spans - 1].leave.t < here.t)) {
            enter = out[--spans].enter; /* it left and enters at once: it has not left */
        } else {
            enter = here;
        }
    }
    return spans;
}
