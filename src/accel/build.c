/* Top down, straight to nodes of eight: a node's children are made by splitting the child that gains
 * most by it, by area as a rule, until there are eight (Wald, Benthin, Boulos, Getting Rid of Packets, 2008). Every choice
 * depends only on the references in their order, never on threads: the upper part is built node by
 * node, all threads looking at its references (build_split.c), until ranges are small; each small
 * range is one task with arrays of its own. Then the size of the whole is known, and each part is
 * copied to its place, in order, and its leaves filled there. */
#include "accel/build.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "accel/build_binary.h"
#include "base/memory.h"

enum { TASKS_WANTED = 64, TASK_SIZE_MIN = 2048, TASK_SIZE_MAX = 65536 };

/* A growing tree, or part of one. */
typedef struct part {
    bvh_node *nodes; /* which refer to leaves by their number in this part */
    size_t node_count, node_capacity;
    uint32_t *leaves; /* of triangles: where their numbers begin in the builder's ids */
    size_t leaf_count, leaf_capacity;
    uint32_t root;
    size_t spare;                  /* leaves, as of split_range */
    size_t first_node, first_leaf; /* in the tree */
    bool failed;
} part;

/* A range left for a task, and the child that will refer to it. */
typedef struct task {
    build_range range;
    uint32_t node, child, level;
    part part;
} task;

typedef struct builder {
    const build_job *job;
    splitter splitter;
    binary_tree binary; /* whose nodes ranges are, at the best quality; empty: none */
    size_t task_size;   /* ranges of at most this many become tasks */
    part upper;
    task *tasks;
    size_t task_count, task_capacity;
    uint32_t *ids;     /* of triangles, in the order of leaves */
    bool reports;      /* worker 0 is the caller of accel_build */
    thread_pool *pool; /* may be NULL */
    bvh_tree *out;
} builder;

static float axis_of(vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/* ---- memory ---- */

/* Of nodes, those with fewer than eight children have leaves only, two or more: that is half as many of
 * them as there are leaves at most, and a seventh of it above them. Nodes and leaves of parts grow by half. */
build_bytes build_plan(bool of_mesh, uint32_t leaf_size, uint64_t count) {
    enum { BESIDES = 2 }; /* bytes, of chunks and tasks */
    uint64_t leaves = split_leaves_at_most(leaf_size, count), nodes = leaves * 4 / 7 + 1;
    uint64_t stays =
        nodes * sizeof(bvh_node) + 64 + (of_mesh ? leaves * sizeof(triangle_block) + 64 : 0);
    uint64_t binary = 2 * leaves * sizeof(binary_node), ids = of_mesh ? count * 4 : 0,
             parts = (nodes * sizeof(bvh_node) + (of_mesh ? leaves * 4 : 0)) * 3 / 2;
    uint64_t growing = parts + binary > binary * 5 / 2 ? parts + binary : binary * 5 / 2,
             splitting = count * (2 * sizeof(build_reference) + BESIDES) + ids + growing,
             joining = stays + ids + parts;
    return (build_bytes){stays, (splitting > joining ? splitting : joining) - stays};
}

/* ---- references ---- */

build_reference *build_references(size_t count) {
    if (count > SIZE_MAX / sizeof(build_reference)) return NULL;
    return memory_aligned(count * sizeof(build_reference));
}

static void run(thread_pool *pool, size_t count, thread_task *work, void *data) {
    if (pool) thread_pool_run(pool, count, work, data);
    for (size_t i = 0; i < count && !pool; i++) work(data, i, 0);
}

enum { CHUNK_SIZE = 65536 }; /* triangles that a thread looks at in one go */

typedef struct mesh_references {
    const mesh_desc *mesh;
    build_reference *references;
    size_t count;
    box4 *boxes; /* of the chunks */
} mesh_references;

static void make_references(void *data, size_t chunk, uint32_t worker) {
    (void)worker;
    const mesh_references *m = data;
    size_t begin = chunk * CHUNK_SIZE, end = begin + CHUNK_SIZE;
    box4 all = box4_empty();
    for (size_t i = begin; i < end && i < m->count; i++) {
        const uint32_t *index = m->mesh->indices + 3 * i;
        f4 a = f4_load3(&m->mesh->positions[index[0]].x),
           b = f4_load3(&m->mesh->positions[index[1]].x),
           c = f4_load3(&m->mesh->positions[index[2]].x);
        build_reference *r = &m->references[i];
        box4 box = {f4_min(f4_min(a, b), c), f4_max(f4_max(a, b), c)};
        f4_store(&r->min.x, box.low);
        f4_store(&r->max.x, box.high); /* lane 3 is 0 */
        r->id = (uint32_t)i;
        all = box4_union(all, box);
    }
    m->boxes[chunk] = all;
}

build_reference *build_mesh_references(const mesh_desc *mesh, thread_pool *pool, size_t *count,
                                       bounds3 *bounds) {
    *count = mesh_triangle_count(mesh);
    size_t chunks = (*count + CHUNK_SIZE - 1) / CHUNK_SIZE;
    mesh_references m = {mesh, build_references(*count), *count,
                         memory_aligned(chunks * sizeof *m.boxes)};
    if (m.references && m.boxes) {
        run(pool, chunks, make_references, &m);
        box4 all = box4_empty();
        for (size_t i = 0; i < chunks; i++) all = box4_union(all, m.boxes[i]);
        *bounds = box4_bounds(all);
    } else {
        memory_free_aligned(m.references);
        m.references = NULL;
    }
    memory_free_aligned(m.boxes);
    return m.references;
}

static bounds3 mean_box(bounds3 a, bounds3 b) {
    return (bounds3){vec3_scale(vec3_add(a.min, b.min), 0.5f),
                     vec3_scale(vec3_add(a.max, b.max), 0.5f)};
}

static bounds3 box_at_key(const deforming_mesh *m, uint32_t key, size_t triangle) {
    const uint32_t *index = m->mesh.indices + 3 * triangle;
    const vec3 *at = deforming_positions(m, key);
    vec3 a = at[index[0]], b = at[index[1]], c = at[index[2]];
    return (bounds3){vec3_min(vec3_min(a, b), c), vec3_max(vec3_max(a, b), c)};
}

static void set_way_box(build_way *way, int moment, bounds3 box) {
    const float sides[] = {-box.min.x, -box.min.y, -box.min.z, box.max.x, box.max.y, box.max.z};
    memcpy(way->sides[moment], sides, sizeof sides);
}

build_reference *build_deforming_references(const deforming_mesh *m, size_t *count, bounds3 *bounds,
                                            build_way **ways) {
    /* Of an even number of keys the middle is between two. */
    const uint32_t last = m->key_count - 1,
                   moments[BUILD_MOMENTS][2] = {{0, 0}, {last / 2, (last + 1) / 2}, {last, last}};
    *count = mesh_triangle_count(&m->mesh);
    build_reference *references = build_references(*count);
    *ways = memory_resize(NULL, *count, sizeof **ways);
    if (references == NULL || *ways == NULL) {
        memory_free_aligned(references);
        return NULL;
    }
    *bounds = bounds3_empty();
    for (size_t i = 0; i < *count; i++) {
        dvec3 low = {0, 0, 0}, high = {0, 0, 0};
        for (uint32_t k = 0; k < m->key_count; k++)
            *bounds = bounds3_union(*bounds, box_at_key(m, k, i));
        for (int j = 0; j < BUILD_MOMENTS; j++) {
            bounds3 box =
                mean_box(box_at_key(m, moments[j][0], i), box_at_key(m, moments[j][1], i));
            set_way_box(&(*ways)[i], j, box);
            low = dvec3_add(low, dvec3_from(box.min));
            high = dvec3_add(high, dvec3_from(box.max));
        }
        references[i] =
            (build_reference){vec3_from(dvec3_scale(low, 1.0 / BUILD_MOMENTS)), (uint32_t)i,
                              vec3_from(dvec3_scale(high, 1.0 / BUILD_MOMENTS)), 0};
    }
    return references;
}

build_reference *build_part_references(const primitive_type *type, const void *desc, size_t *count,
                                       bounds3 *bounds) {
    uint32_t parts = primitive_count_of(type, desc);
    build_reference *references = build_references(parts);
    if (references == NULL) return NULL;
    *count = 0;
    *bounds = bounds3_empty();
    for (uint32_t i = 0; i < parts; i++) {
        bounds3 box = primitive_bounds_of(type, desc, i);
        if (bounds3_is_empty(box)) continue;
        references[(*count)++] = (build_reference){box.min, i, box.max, 0};
        *bounds = bounds3_union(*bounds, box);
    }
    return references;
}

/* ---- nodes and leaves ---- */

static void set_child_box(bvh_node *node, uint32_t child, const bounds3 *box) {
    for (int axis = 0; axis < 3; axis++) {
        node->bounds[0][axis][child] = axis_of(box->min, axis);
        node->bounds[1][axis][child] = axis_of(box->max, axis);
    }
}

static uint32_t add_leaf(const builder *b, part *p, const build_range *r) {
    const build_reference *references = b->splitter.sides[r->side] + r->begin;
    if (b->job->mesh == NULL) return BVH_LEAF | references[0].id;
    if (p->leaf_count >= BVH_INDEX_MASK ||
        !ARRAY_GROW(p->leaves, p->leaf_count, p->leaf_capacity, 1)) {
        p->failed = true;
        return BVH_LEAF;
    }
    for (size_t i = 0; i < r->count; i++) b->ids[r->begin + i] = references[i].id;
    p->leaves[p->leaf_count] = (uint32_t)r->begin;
    return BVH_LEAF | (uint32_t)(r->count - 1) << BVH_COUNT_SHIFT | (uint32_t)p->leaf_count++;
}

static bool is_leaf(const builder *b, const build_range *r) {
    return b->binary.count ? b->binary.nodes[r->node].child[0] == BINARY_NONE
                           : r->count <= b->job->leaf_size;
}

/* How much is won by splitting a range rather than giving it a node of its own: the area of that node.
 * Where two or three leaves would do it counts more, as no nodes are needed below: so nodes are
 * fuller. -1: a leaf. */
static double opening_gain(const builder *b, const build_range *r) {
    const size_t leaf = b->job->leaf_size;
    if (is_leaf(b, r)) return -1;
    double area = bounds3_half_area(box4_bounds(r->box));
    area *= r->count <= 2 * leaf ? 4 : r->count <= 3 * leaf ? 2 : 1;
    return area <= DBL_MAX ? area : DBL_MAX;
}

static void split_any(const builder *b, part *p, const build_range *r, build_range *left,
                      build_range *right) {
    if (b->binary.count == 0) {
        split_range(&b->splitter, r, &p->spare, left, right);
        return;
    }
    const binary_node *n = &b->binary.nodes[r->node];
    *left = binary_range(&b->binary, n->child[0], r->depth + 1);
    *right = binary_range(&b->binary, n->child[1], r->depth + 1);
}

/* Splits until there are eight children or nothing is left to split. */
static uint32_t make_children(const builder *b, part *p, const build_range *r,
                              build_range children[BVH_WIDTH]) {
    double gains[BVH_WIDTH];
    uint32_t count = 1;
    children[0] = *r;
    gains[0] = opening_gain(b, r);
    while (count < BVH_WIDTH) {
        uint32_t chosen = 0;
        for (uint32_t i = 1; i < count; i++)
            if (gains[i] > gains[chosen]) chosen = i;
        if (gains[chosen] < 0) break;
        build_range parent = children[chosen];
        split_any(b, p, &parent, &children[chosen], &children[count]);
        gains[chosen] = opening_gain(b, &children[chosen]);
        gains[count] = opening_gain(b, &children[count]);
        count++;
        /* Long ranges are split on the caller's thread: a cancel shall not wait for the node. */
        if (b->reports && parent.count > b->task_size && !build_progress_report(b->job->progress))
            break;
    }
    for (uint32_t i = count; b->job->seed && i > 1; i--) { /* Fisher and Yates */
        uint32_t h = split_scramble(b->job->seed + split_scramble((uint32_t)r->begin * 31 + i));
        build_range swap = children[i - 1];
        children[i - 1] = children[h % i];
        children[h % i] = swap;
    }
    return count;
}

static bool add_task(builder *b, const build_range *r, uint32_t node, uint32_t child,
                     uint32_t level) {
    if (!ARRAY_GROW(b->tasks, b->task_count, b->task_capacity, 1)) return false;
    b->tasks[b->task_count++] = (task){.range = *r, .node = node, .child = child, .level = level};
    return true;
}

/* Builds the node of a range at this level of wide nodes, and what is below it; in the upper part
 * (upper: true) small ranges are put off as tasks. The depth of recursion is at most
 * BVH_DEPTH_MAX: by then binary splits have halved every range to one reference. */
static uint32_t add_node(builder *b, part *p, const build_range *r, uint32_t level, bool upper) {
    if (p->failed || level >= BVH_DEPTH_MAX || p->node_count >= BVH_INDEX_MASK ||
        !ARRAY_GROW(p->nodes, p->node_count, p->node_capacity, 1)) {
        p->failed = true;
        return 0;
    }
    uint32_t index = (uint32_t)p->node_count++;
    build_range children[BVH_WIDTH];
    uint32_t count = make_children(b, p, r, children);
    if (upper && atomic_load(&b->job->progress->stop)) p->failed = true;
    bvh_node node = {0};
    /* A box that no ray passes, and finite: mixed with weight 0 it stays such. */
    const bounds3 nothing = {{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
    for (uint32_t i = 0; i < BVH_WIDTH; i++) {
        bounds3 box = i < count ? box4_bounds(children[i].box) : nothing;
        set_child_box(&node, i, &box);
        if (i < count) node.valid |= 1u << i;
    }
    for (uint32_t i = 0; i < count && !p->failed; i++) {
        const build_range *child = &children[i];
        if (upper && child->count <= b->task_size)
            p->failed |= !add_task(b, child, index, i, level + 1);
        else if (is_leaf(b, child))
            node.child[i] = add_leaf(b, p, child);
        else
            node.child[i] = add_node(b, p, child, level + 1, upper);
    }
    p->nodes[index] = node;
    if (upper && b->reports && !build_progress_report(b->job->progress)) p->failed = true;
    return index;
}

/* ---- tasks ---- */

bool build_progress_report(build_progress *progress) {
    const accel_options *options = progress->options;
    if (options && options->progress) {
        double fraction =
            (double)atomic_load(&progress->done) / (double)(progress->total ? progress->total : 1);
        if (!options->progress(options->user, fraction < 1 ? fraction : 1))
            atomic_store(&progress->stop, true);
    }
    return !atomic_load(&progress->stop);
}

static void run_task(void *data, size_t index, uint32_t worker) {
    builder *b = data;
    task *t = &b->tasks[index];
    build_progress *progress = b->job->progress;
    if (atomic_load(&progress->stop)) {
        t->part.failed = true;
        return;
    }
    t->part.spare = split_share(&b->splitter, b->upper.spare, t->range.count);
    if (is_leaf(b, &t->range))
        t->part.root = add_leaf(b, &t->part, &t->range);
    else
        t->part.root = add_node(b, &t->part, &t->range, t->level, false);
    atomic_fetch_add(&progress->done, t->range.count);
    if (worker == 0 && b->reports && !build_progress_report(progress)) t->part.failed = true;
}

/* The upper part, then the tasks. */
static bool build_parts(builder *b) {
    build_range all = split_whole(&b->splitter);
    b->out->bounds = box4_bounds(all.box);
    b->upper.spare = split_spare(&b->splitter);
    if (b->job->quality == ACCEL_BEST && b->job->ways == NULL && b->job->seed == 0) {
        if (!binary_build(&b->splitter, &all, &b->binary)) return false;
        all = binary_range(&b->binary, 0, 0);
    }
    if (b->job->mesh && is_leaf(b, &all))
        b->upper.root = add_leaf(b, &b->upper, &all);
    else
        b->upper.root = add_node(b, &b->upper, &all, 0, all.count > b->task_size);
    if (b->upper.failed) return false;
    run(b->pool, b->task_count, run_task, b);
    for (size_t i = 0; i < b->task_count; i++)
        if (b->tasks[i].part.failed) return false;
    return true;
}

/* ---- joining: the upper part first, then the tasks in their order ---- */

static part *part_of(builder *b, size_t index) {
    return index ? &b->tasks[index - 1].part : &b->upper;
}

static uint32_t relocate(const builder *b, uint32_t reference, const part *p) {
    if (!(reference & BVH_LEAF)) return reference + (uint32_t)p->first_node;
    return b->job->mesh ? reference + (uint32_t)p->first_leaf : reference;
}

static void fill_block(const mesh_desc *mesh, const uint32_t *ids, size_t count,
                       triangle_block *block) {
    for (size_t i = 0; i < BVH_WIDTH; i++) block->primitive[i] = ids[i < count ? i : count - 1];
    for (size_t v = 0; v < 3; v++)
        for (size_t half = 0; half < BVH_WIDTH; half += 4) {
            f4 rows[4];
            for (size_t i = 0; i < 4; i++) {
                const uint32_t *index = mesh->indices + 3 * (size_t)block->primitive[half + i];
                rows[i] = f4_load3(&mesh->positions[index[v]].x);
            }
            f4_transpose(&rows[0], &rows[1], &rows[2], &rows[3]);
            for (int axis = 0; axis < 3; axis++)
                f4_store(block->vertex[v][axis] + half, rows[axis]);
        }
}

static void fill_leaf(const builder *b, const part *p, uint32_t child) {
    uint32_t index = child & BVH_INDEX_MASK, count = (child >> BVH_COUNT_SHIFT & 7) + 1;
    fill_block(b->job->mesh, b->ids + p->leaves[index], count,
               &b->out->blocks[p->first_leaf + index]);
}

static void place_part(void *data, size_t index, uint32_t worker) {
    (void)worker;
    builder *b = data;
    const part *p = part_of(b, index);
    for (size_t i = 0; i < p->node_count; i++) {
        bvh_node *node = &b->out->nodes[p->first_node + i];
        *node = p->nodes[i];
        for (uint32_t j = 0; j < BVH_WIDTH; j++) {
            if (!(node->valid >> j & 1)) continue;
            if (b->job->mesh && node->child[j] & BVH_LEAF) fill_leaf(b, p, node->child[j]);
            node->child[j] = relocate(b, node->child[j], p);
        }
    }
    if (p->node_count == 0 && p->leaf_count) fill_leaf(b, p, p->root);
}

static bool join(builder *b) {
    bvh_tree *out = b->out;
    for (size_t i = 0; i <= b->task_count; i++) {
        part *p = part_of(b, i);
        p->first_node = out->node_count;
        p->first_leaf = out->block_count;
        out->node_count += p->node_count;
        out->block_count += p->leaf_count;
    }
    if (out->node_count > BVH_INDEX_MASK || out->block_count > BVH_INDEX_MASK) return false;
    out->nodes = memory_aligned(out->node_count * sizeof *out->nodes);
    out->blocks = b->job->mesh ? memory_aligned(out->block_count * sizeof *out->blocks) : NULL;
    if (out->nodes == NULL || (b->job->mesh && out->blocks == NULL)) return false;
    run(b->pool, b->task_count + 1, place_part, b);
    out->root = relocate(b, b->upper.root, &b->upper);
    for (size_t i = 0; i < b->task_count; i++) {
        const task *t = &b->tasks[i];
        out->nodes[t->node].child[t->child] = relocate(b, t->part.root, &t->part);
    }
    return true;
}

static void free_part(part *p) {
    free(p->nodes);
    free(p->leaves);
}

/* ---- meshes that deform ---- */

typedef struct key_fit {
    const deforming_mesh *m;
    const bvh_tree *tree; /* whose nodes and blocks of the first key are there */
} key_fit;

static void set_vertices(const deforming_mesh *m, uint32_t key, triangle_block *block) {
    const vec3 *positions = deforming_positions(m, key);
    for (size_t i = 0; i < BVH_WIDTH; i++)
        for (size_t v = 0; v < 3; v++) {
            vec3 position = positions[m->mesh.indices[3 * (size_t)block->primitive[i] + v]];
            for (int axis = 0; axis < 3; axis++)
                block->vertex[v][axis][i] = axis_of(position, axis);
        }
}

/* Unused triangles repeat the last. */
static bounds3 block_bounds(const triangle_block *block) {
    bounds3 box = bounds3_empty();
    for (int i = 0; i < BVH_WIDTH; i++)
        for (int v = 0; v < 3; v++)
            box = bounds3_add_point(box, (vec3){block->vertex[v][0][i], block->vertex[v][1][i],
                                                block->vertex[v][2][i]});
    return box;
}

static bounds3 node_bounds(const bvh_node *node) {
    bounds3 box = bounds3_empty();
    for (int i = 0; i < BVH_WIDTH; i++) {
        if (!(node->valid >> i & 1)) continue;
        box = bounds3_union(
            box, (bounds3){{node->bounds[0][0][i], node->bounds[0][1][i], node->bounds[0][2][i]},
                           {node->bounds[1][0][i], node->bounds[1][1][i], node->bounds[1][2][i]}});
    }
    return box;
}

/* Nodes come before their children. */
static void fit_key(void *data, size_t key, uint32_t worker) {
    (void)worker;
    const key_fit *fit = data;
    const bvh_tree *tree = fit->tree;
    bvh_node *nodes = tree->nodes + key * tree->node_count;
    triangle_block *blocks = tree->blocks + key * tree->block_count;
    for (size_t i = 0; i < tree->block_count; i++) set_vertices(fit->m, (uint32_t)key, &blocks[i]);
    for (size_t i = tree->node_count; i-- > 0;)
        for (uint32_t j = 0; j < BVH_WIDTH; j++) {
            uint32_t child = nodes[i].child[j];
            if (!(nodes[i].valid >> j & 1)) continue;
            bounds3 box = child & BVH_LEAF ? block_bounds(&blocks[child & BVH_INDEX_MASK])
                                           : node_bounds(&nodes[child]);
            set_child_box(&nodes[i], j, &box);
        }
}

bool build_tree_at_keys(const deforming_mesh *m, thread_pool *pool, bvh_tree *tree) {
    size_t node_bytes = tree->node_count * sizeof *tree->nodes,
           block_bytes = tree->block_count * sizeof *tree->blocks;
    if (m->key_count > (SIZE_MAX - 64) / (node_bytes + block_bytes)) return false;
    bvh_tree all = *tree;
    all.nodes = memory_aligned(m->key_count * node_bytes);
    all.blocks = memory_aligned(m->key_count * block_bytes);
    if (all.nodes == NULL || all.blocks == NULL) {
        build_tree_free(&all);
        return false;
    }
    for (uint32_t k = 0; k < m->key_count; k++) {
        if (node_bytes) memcpy(all.nodes + k * all.node_count, tree->nodes, node_bytes);
        memcpy(all.blocks + k * all.block_count, tree->blocks, block_bytes);
    }
    build_tree_free(tree);
    *tree = all;
    key_fit fit = {m, tree};
    if (pool) thread_pool_run(pool, m->key_count, fit_key, &fit);
    for (uint32_t k = 0; k < m->key_count && !pool; k++) fit_key(&fit, k, 0);
    return true;
}

typedef struct widening {
    bvh_tree *tree;
    size_t nodes; /* of all keys */
    double margin;
} widening;

enum { NODES_AT_ONCE = 1024 };

static void widen_nodes(void *data, size_t index, uint32_t worker) {
    (void)worker;
    const widening *w = data;
    size_t begin = index * NODES_AT_ONCE, end = begin + NODES_AT_ONCE;
    for (size_t i = begin; i < end && i < w->nodes; i++) {
        bvh_node *node = &w->tree->nodes[i];
        for (uint32_t j = 0; j < BVH_WIDTH; j++) {
            if (!(node->valid >> j & 1)) continue;
            double low[3], high[3];
            for (int axis = 0; axis < 3; axis++) {
                low[axis] = (double)node->bounds[0][axis][j] - w->margin;
                high[axis] = (double)node->bounds[1][axis][j] + w->margin;
            }
            bounds3 box = bounds3_outward((dvec3){low[0], low[1], low[2]},
                                          (dvec3){high[0], high[1], high[2]});
            set_child_box(node, j, &box);
        }
    }
}

void build_widen(bvh_tree *tree, uint32_t keys, thread_pool *pool) {
    const float *bounds[2] = {&tree->bounds.min.x, &tree->bounds.max.x};
    double extent = 0, place = 0;
    for (int i = 0; i < 3; i++) {
        extent = double_max(extent, (double)bounds[1][i] - (double)bounds[0][i]);
        for (int side = 0; side < 2; side++)
            place = double_max(place, fabs((double)bounds[side][i]));
    }
    if (!(extent >= 0)) return; /* without triangles */
    double reach = BOX_REACH_BUILT * extent;
    /* A little more: the keys of a mesh that deforms are mixed with weights that are rounded. */
    double margin = (1 + 0x1p-10) *
                    (reach * (double)BOX_REACH_MARGIN + (place + reach) * (double)BOX_PLACE_MARGIN);
    widening w = {tree, keys * tree->node_count, margin};
    run(pool, (w.nodes + NODES_AT_ONCE - 1) / NODES_AT_ONCE, widen_nodes, &w);
    tree->margin = (float)margin;
}

void build_tree_free(bvh_tree *tree) {
    memory_free_aligned(tree->nodes);
    memory_free_aligned(tree->blocks);
    *tree = (bvh_tree){0};
}

/* What splits does not stay for joining: then there is the tree twice, nearly. */
static bool build_whole(builder *b, size_t serial_size) {
    b->ids = b->job->mesh ? memory_resize(NULL, b->job->count, sizeof *b->ids) : NULL;
    bool ok = splitter_init(&b->splitter, b->job, b->pool, serial_size) &&
              (b->ids || !b->job->mesh) && build_parts(b);
    binary_free(&b->binary);
    splitter_free(&b->splitter);
    ok = ok && join(b);
    free_part(&b->upper);
    for (size_t i = 0; i < b->task_count; i++) free_part(&b->tasks[i].part);
    free(b->tasks);
    free(b->ids);
    return ok;
}

snell_status build_tree(const build_job *job, thread_pool *pool, bool reports, bvh_tree *out) {
    *out = (bvh_tree){0};
    builder b = {.job = job,
                 .task_size = job->count / TASKS_WANTED,
                 .reports = reports,
                 .pool = pool,
                 .out = out};
    if (b.task_size < TASK_SIZE_MIN) b.task_size = TASK_SIZE_MIN;
    if (b.task_size > TASK_SIZE_MAX) b.task_size = TASK_SIZE_MAX;
    bool ok = build_whole(&b, b.task_size);
    if (b.task_count == 0) {
        atomic_fetch_add(&job->progress->done, job->count);
        if (reports) build_progress_report(job->progress);
    }
    bool stopped = atomic_load(&job->progress->stop);
    if (stopped || !ok) build_tree_free(out);
    return stopped ? SNELL_CANCELLED : ok ? SNELL_OK : SNELL_ERR_MEMORY;
}
