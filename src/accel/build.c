/* Binned SAH, top down, straight to nodes of eight: a node's children are made by splitting the
 * child of largest area until there are eight (Wald, On fast Construction of SAH-based Bounding
 * Volume Hierarchies, 2007, for the bins; Wald, Benthin, Boulos, Getting Rid of Packets, 2008, for
 * wide nodes). Every choice depends only on the references in their order, never on threads: the
 * upper part is built node by node, all threads looking at its references in chunks of fixed size,
 * until ranges are small; each small range is one task with arrays of its own, and these are joined
 * in order. */
#include "accel/build.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum {
    BIN_COUNT = 16,
    TASKS_WANTED = 64,
    TASK_SIZE_MIN = 2048,
    CHUNK_SIZE = 65536,        /* references that one thread looks at when all sweep a range */
    TASK_SIZE_MAX = CHUNK_SIZE /* so that tasks, which run on one thread, never sweep together */
};

typedef struct range {
    size_t begin, count;
    bounds3 box, centers; /* centers: of the references' midpoints */
    uint32_t depth;       /* of binary splits */
} range;

/* A growing tree, or part of one. */
typedef struct part {
    bvh_node *nodes;
    size_t node_count, node_capacity;
    triangle_block *blocks;
    size_t block_count, block_capacity;
    uint32_t root, depth; /* depth: the deepest level of wide nodes */
    bool failed;
} part;

/* A range left for a task, and the child that will refer to it. */
typedef struct task {
    range range;
    uint32_t node, child, level;
    part part;
} task;

typedef struct binning {
    double low[3], scale[3]; /* scale 0: the axis cannot be split */
} binning;

typedef struct split {
    int axis;     /* -1: none */
    uint32_t bin; /* the first bin of the right side */
} split;

typedef struct bin {
    bounds3 box;
    size_t count;
} bin;

/* What one chunk of a range holds. */
typedef struct chunk {
    bin bins[3][BIN_COUNT];
    bounds3 box, centers;
} chunk;

typedef struct builder {
    const build_job *job;
    size_t task_size; /* ranges of at most this many become tasks */
    task *tasks;
    size_t task_count, task_capacity;
    bool reports;      /* worker 0 is the caller of accel_build */
    thread_pool *pool; /* may be NULL */
    chunk *chunks;     /* for sweeps over ranges of more than CHUNK_SIZE */
} builder;

/* ---- geometry of references ---- */

static float midpoint(float low, float high) {
    float m = 0.5f * low + 0.5f * high;
    return fabsf(m) <= FLT_MAX ? m : 0; /* boxes of instances may be infinite */
}

static vec3 center_of(const build_reference *r) {
    return (vec3){midpoint(r->min.x, r->max.x), midpoint(r->min.y, r->max.y),
                  midpoint(r->min.z, r->max.z)};
}

static float axis_of(vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static void measure_serially(const builder *b, range *r) {
    r->box = bounds3_empty();
    r->centers = bounds3_empty();
    const build_reference *references = b->job->references + r->begin;
    for (size_t i = 0; i < r->count; i++) {
        r->box = bounds3_union(r->box, (bounds3){references[i].min, references[i].max});
        r->centers = bounds3_add_point(r->centers, center_of(&references[i]));
    }
}

build_reference *build_mesh_references(const mesh_desc *mesh, size_t *count, bounds3 *bounds) {
    *count = mesh_triangle_count(mesh);
    build_reference *references = memory_resize(NULL, *count, sizeof *references);
    if (references == NULL) return NULL;
    *bounds = bounds3_empty();
    for (size_t i = 0; i < *count; i++) {
        const uint32_t *index = mesh->indices + 3 * i;
        vec3 a = mesh->positions[index[0]], b = mesh->positions[index[1]],
             c = mesh->positions[index[2]];
        vec3 low = vec3_min(vec3_min(a, b), c), high = vec3_max(vec3_max(a, b), c);
        references[i] = (build_reference){low, (uint32_t)i, high, 0};
        *bounds = bounds3_union(*bounds, (bounds3){low, high});
    }
    return references;
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
    build_reference *references = memory_resize(NULL, *count, sizeof *references);
    *ways = memory_resize(NULL, *count, sizeof **ways);
    if (references == NULL || *ways == NULL) {
        free(references);
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
    build_reference *references = memory_resize(NULL, parts, sizeof *references);
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

/* ---- choosing a split ---- */

static binning make_binning(const bounds3 *centers) {
    binning g;
    for (int axis = 0; axis < 3; axis++) {
        double low = axis_of(centers->min, axis), high = axis_of(centers->max, axis);
        g.low[axis] = low;
        g.scale[axis] = high > low ? BIN_COUNT * (1 - 1e-6) / (high - low) : 0;
    }
    return g;
}

static uint32_t bin_of(const binning *g, int axis, vec3 center) {
    uint32_t index = (uint32_t)(((double)axis_of(center, axis) - g->low[axis]) * g->scale[axis]);
    return index < BIN_COUNT ? index : BIN_COUNT - 1;
}

static void clear_bins(bin bins[3][BIN_COUNT]) {
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < BIN_COUNT; i++) bins[axis][i] = (bin){bounds3_empty(), 0};
}

static void fill_bins_serially(const builder *b, const range *r, const binning *g,
                               bin bins[3][BIN_COUNT]) {
    clear_bins(bins);
    for (size_t i = 0; i < r->count; i++) {
        const build_reference *reference = &b->job->references[r->begin + i];
        vec3 center = center_of(reference);
        for (int axis = 0; axis < 3; axis++) {
            bin *to = &bins[axis][bin_of(g, axis, center)];
            to->box = bounds3_union(to->box, (bounds3){reference->min, reference->max});
            to->count++;
        }
    }
}

/* ---- sweeps: a long range is looked at in chunks, by all threads ---- */

typedef struct sweep {
    const builder *builder;
    const range *range;
    const binning *binning; /* NULL: measure */
} sweep;

static void sweep_chunk(void *data, size_t index, uint32_t worker) {
    (void)worker;
    const sweep *s = data;
    chunk *c = &s->builder->chunks[index];
    size_t skipped = index * CHUNK_SIZE, left = s->range->count - skipped;
    range r = {.begin = s->range->begin + skipped, .count = left < CHUNK_SIZE ? left : CHUNK_SIZE};
    if (s->binning) {
        fill_bins_serially(s->builder, &r, s->binning, c->bins);
        return;
    }
    measure_serially(s->builder, &r);
    c->box = r.box;
    c->centers = r.centers;
}

/* Returns the number of chunks, whose results are to be merged in order. */
static size_t run_sweep(sweep *s) {
    size_t count = (s->range->count + CHUNK_SIZE - 1) / CHUNK_SIZE;
    if (s->builder->pool) thread_pool_run(s->builder->pool, count, sweep_chunk, s);
    for (size_t i = 0; i < count && !s->builder->pool; i++) sweep_chunk(s, i, 0);
    return count;
}

static void measure(const builder *b, range *r) {
    if (r->count <= CHUNK_SIZE) {
        measure_serially(b, r);
        return;
    }
    size_t count = run_sweep(&(sweep){b, r, NULL});
    r->box = bounds3_empty();
    r->centers = bounds3_empty();
    for (size_t i = 0; i < count; i++) {
        r->box = bounds3_union(r->box, b->chunks[i].box);
        r->centers = bounds3_union(r->centers, b->chunks[i].centers);
    }
}

static void fill_bins(const builder *b, const range *r, const binning *g, bin bins[3][BIN_COUNT]) {
    if (r->count <= CHUNK_SIZE) {
        fill_bins_serially(b, r, g, bins);
        return;
    }
    size_t count = run_sweep(&(sweep){b, r, g});
    clear_bins(bins);
    for (size_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++)
            for (int j = 0; j < BIN_COUNT; j++) {
                const bin *from = &b->chunks[i].bins[axis][j];
                bins[axis][j].box = bounds3_union(bins[axis][j].box, from->box);
                bins[axis][j].count += from->count;
            }
}

/* What a side costs: its area times the leaves it needs. */
static double side_cost(const builder *b, const bounds3 *box, size_t count) {
    size_t leaf = b->job->leaf_size;
    return bounds3_half_area(*box) * (double)((count + leaf - 1) / leaf);
}

static split best_split(const builder *b, const range *r, const binning *g) {
    bin bins[3][BIN_COUNT];
    fill_bins(b, r, g, bins);
    split best = {-1, 0};
    double best_cost = INFINITY;
    for (int axis = 0; axis < 3; axis++) {
        if (g->scale[axis] == 0) continue;
        double right_cost[BIN_COUNT];
        bounds3 box = bounds3_empty();
        size_t count = 0;
        for (uint32_t i = BIN_COUNT - 1; i > 0; i--) {
            box = bounds3_union(box, bins[axis][i].box);
            count += bins[axis][i].count;
            right_cost[i] = side_cost(b, &box, count);
        }
        box = bounds3_empty(), count = 0;
        for (uint32_t i = 1; i < BIN_COUNT; i++) {
            box = bounds3_union(box, bins[axis][i - 1].box);
            count += bins[axis][i - 1].count;
            if (count == 0 || count == r->count) continue;
            double cost = side_cost(b, &box, count) + right_cost[i];
            if (cost < best_cost) {
                best_cost = cost;
                best = (split){axis, i};
            }
        }
    }
    return best;
}

/* Lowbias32 by Chris Wellons: a hash of 32 bits. */
static uint32_t scramble(uint32_t x) {
    x ^= x >> 16, x *= 0x7feb352du;
    x ^= x >> 15, x *= 0x846ca68bu;
    return x ^ x >> 16;
}

/* For tests of the hit rule: any tree at all. */
static split random_split(const builder *b, const range *r, const binning *g) {
    uint32_t h =
        scramble(b->job->seed ^ scramble((uint32_t)r->begin ^ scramble((uint32_t)r->count)));
    int axis = (int)(h % 3);
    if (g->scale[axis] == 0 || (h >> 2 & 1)) return best_split(b, r, g);
    return (split){axis, 1 + (h >> 8) % (BIN_COUNT - 1)};
}

/* Reorders the range; returns how many went left. */
static size_t partition(const builder *b, const range *r, const binning *g, split s) {
    build_reference *low = b->job->references + r->begin, *high = low + r->count;
    const build_reference *begin = low;
    for (;;) {
        while (low < high && bin_of(g, s.axis, center_of(low)) < s.bin) low++;
        while (low < high && bin_of(g, s.axis, center_of(high - 1)) >= s.bin) high--;
        if (low == high) return (size_t)(low - begin);
        build_reference swap = *low;
        *low++ = *--high;
        *high = swap;
    }
}

/* ---- splitting ways: SAH with the sum of the areas at each moment, in bins along each axis at
 * each moment, so that what goes together stays together ---- */

typedef struct way_bin {
    build_way box;
    size_t count;
} way_bin;

typedef struct way_bins {
    binning grid[BUILD_MOMENTS];
    way_bin bins[BUILD_MOMENTS][3][BIN_COUNT];
} way_bins;

static bounds3 way_box(const build_way *way, int moment) {
    const float *s = way->sides[moment];
    return (bounds3){{-s[0], -s[1], -s[2]}, {s[3], s[4], s[5]}};
}

static vec3 way_center(const build_way *way, int moment) {
    bounds3 box = way_box(way, moment);
    return (vec3){midpoint(box.min.x, box.max.x), midpoint(box.min.y, box.max.y),
                  midpoint(box.min.z, box.max.z)};
}

static void clear_way_bin(way_bin *out) {
    out->count = 0;
    for (int j = 0; j < BUILD_MOMENTS; j++)
        for (int i = 0; i < 6; i++) out->box.sides[j][i] = -INFINITY;
}

static void join_way(way_bin *to, const build_way *box, size_t count) {
    float *own = to->box.sides[0];
    const float *more = box->sides[0];
    to->count += count;
    for (int i = 0; i < 6 * BUILD_MOMENTS; i++) own[i] = more[i] > own[i] ? more[i] : own[i];
}

static void fill_way_bins(const builder *b, const range *r, way_bins *w) {
    const build_reference *references = b->job->references + r->begin;
    bounds3 centers[BUILD_MOMENTS];
    for (int j = 0; j < BUILD_MOMENTS; j++) centers[j] = bounds3_empty();
    for (size_t i = 0; i < r->count; i++) {
        const build_way *way = &b->job->ways[references[i].id];
        for (int j = 0; j < BUILD_MOMENTS; j++)
            centers[j] = bounds3_add_point(centers[j], way_center(way, j));
    }
    for (int j = 0; j < BUILD_MOMENTS; j++) {
        w->grid[j] = make_binning(&centers[j]);
        for (int axis = 0; axis < 3; axis++)
            for (int i = 0; i < BIN_COUNT; i++) clear_way_bin(&w->bins[j][axis][i]);
    }
    for (size_t i = 0; i < r->count; i++) {
        const build_way *way = &b->job->ways[references[i].id];
        for (int j = 0; j < BUILD_MOMENTS; j++) {
            vec3 center = way_center(way, j);
            for (int axis = 0; axis < 3; axis++)
                join_way(&w->bins[j][axis][bin_of(&w->grid[j], axis, center)], way, 1);
        }
    }
}

static double way_cost(const builder *b, const way_bin *side) {
    double cost = 0;
    for (int j = 0; j < BUILD_MOMENTS; j++) {
        bounds3 box = way_box(&side->box, j);
        cost += side_cost(b, &box, side->count);
    }
    return cost;
}

static split best_way_split(const builder *b, const range *r, const way_bins *w, int *moment) {
    split best = {-1, 0};
    double best_cost = INFINITY;
    for (int j = 0; j < BUILD_MOMENTS; j++)
        for (int axis = 0; axis < 3; axis++) {
            if (w->grid[j].scale[axis] == 0) continue;
            const way_bin *bins = w->bins[j][axis];
            double right_cost[BIN_COUNT];
            way_bin side;
            clear_way_bin(&side);
            for (uint32_t i = BIN_COUNT - 1; i > 0; i--) {
                join_way(&side, &bins[i].box, bins[i].count);
                right_cost[i] = way_cost(b, &side);
            }
            clear_way_bin(&side);
            for (uint32_t i = 1; i < BIN_COUNT; i++) {
                join_way(&side, &bins[i - 1].box, bins[i - 1].count);
                if (side.count == 0 || side.count == r->count) continue;
                double cost = way_cost(b, &side) + right_cost[i];
                if (!(cost < best_cost)) continue;
                best_cost = cost;
                best = (split){axis, i};
                *moment = j;
            }
        }
    return best;
}

/* Reorders the range; returns how many went left, 0 where nothing can be split. */
static size_t split_ways(const builder *b, const range *r) {
    way_bins w;
    fill_way_bins(b, r, &w);
    int moment = 0;
    split s = best_way_split(b, r, &w, &moment);
    if (s.axis < 0) return 0;
    build_reference *low = b->job->references + r->begin, *high = low + r->count;
    const build_reference *begin = low;
    while (low < high) {
        vec3 center = way_center(&b->job->ways[low->id], moment);
        if (bin_of(&w.grid[moment], s.axis, center) < s.bin) {
            low++;
            continue;
        }
        build_reference swap = *low;
        *low = *--high;
        *high = swap;
    }
    return (size_t)(low - begin);
}

static void split_range(const builder *b, const range *r, range *left, range *right) {
    size_t count = 0;
    if (r->depth < BVH_SAH_DEPTH && b->job->ways && !b->job->seed) {
        count = split_ways(b, r);
    } else if (r->depth < BVH_SAH_DEPTH) {
        binning g = make_binning(&r->centers);
        split s = b->job->seed ? random_split(b, r, &g) : best_split(b, r, &g);
        if (s.axis >= 0) count = partition(b, r, &g, s);
    }
    if (count == 0 || count == r->count) count = r->count / 2;
    *left = (range){.begin = r->begin, .count = count, .depth = r->depth + 1};
    *right = (range){.begin = r->begin + count, .count = r->count - count, .depth = r->depth + 1};
    measure(b, left);
    measure(b, right);
}

/* ---- nodes and leaves ---- */

static void set_child_box(bvh_node *node, uint32_t child, const bounds3 *box) {
    for (int axis = 0; axis < 3; axis++) {
        node->bounds[0][axis][child] = axis_of(box->min, axis);
        node->bounds[1][axis][child] = axis_of(box->max, axis);
    }
}

static uint32_t add_leaf(const builder *b, part *p, const range *r) {
    const build_reference *references = b->job->references + r->begin;
    const mesh_desc *mesh = b->job->mesh;
    if (mesh == NULL) return BVH_LEAF | references[0].id;
    if (p->block_count >= BVH_INDEX_MASK ||
        !ARRAY_GROW(p->blocks, p->block_count, p->block_capacity, 1)) {
        p->failed = true;
        return BVH_LEAF;
    }
    triangle_block *block = &p->blocks[p->block_count];
    for (size_t i = 0; i < BVH_WIDTH; i++) {
        uint32_t id = references[i < r->count ? i : r->count - 1].id;
        block->primitive[i] = id;
        for (size_t v = 0; v < 3; v++) {
            vec3 position = mesh->positions[mesh->indices[3 * (size_t)id + v]];
            for (int axis = 0; axis < 3; axis++)
                block->vertex[v][axis][i] = axis_of(position, axis);
        }
    }
    return BVH_LEAF | (uint32_t)(r->count - 1) << BVH_COUNT_SHIFT | (uint32_t)p->block_count++;
}

/* Splits until there are eight children or nothing is left to split. */
static uint32_t make_children(const builder *b, const range *r, range children[BVH_WIDTH]) {
    uint32_t count = 1;
    children[0] = *r;
    while (count < BVH_WIDTH) {
        double largest = -1;
        uint32_t chosen = 0;
        for (uint32_t i = 0; i < count; i++) {
            if (children[i].count <= b->job->leaf_size) continue;
            double area = bounds3_half_area(children[i].box);
            if (!(area <= DBL_MAX)) area = DBL_MAX;
            if (area > largest) largest = area, chosen = i;
        }
        if (largest < 0) break;
        range parent = children[chosen];
        split_range(b, &parent, &children[chosen], &children[count++]);
        /* Long ranges are split on the caller's thread: a cancel shall not wait for the node. */
        if (b->reports && parent.count > CHUNK_SIZE && !build_progress_report(b->job->progress))
            break;
    }
    for (uint32_t i = count; b->job->seed && i > 1; i--) { /* Fisher and Yates */
        uint32_t h = scramble(b->job->seed + scramble((uint32_t)r->begin * 31 + i));
        range swap = children[i - 1];
        children[i - 1] = children[h % i];
        children[h % i] = swap;
    }
    return count;
}

static bool add_task(builder *b, const range *r, uint32_t node, uint32_t child, uint32_t level) {
    if (!ARRAY_GROW(b->tasks, b->task_count, b->task_capacity, 1)) return false;
    b->tasks[b->task_count++] = (task){.range = *r, .node = node, .child = child, .level = level};
    return true;
}

/* Builds the node of a range at this level of wide nodes, and what is below it; in the upper part
 * (upper: true) small ranges are put off as tasks. The depth of recursion is at most
 * BVH_DEPTH_MAX: by then binary splits have halved every range to one reference. */
static uint32_t add_node(builder *b, part *p, const range *r, uint32_t level, bool upper) {
    if (p->failed || level >= BVH_DEPTH_MAX || p->node_count >= BVH_INDEX_MASK ||
        !ARRAY_GROW(p->nodes, p->node_count, p->node_capacity, 1)) {
        p->failed = true;
        return 0;
    }
    if (level + 1 > p->depth) p->depth = level + 1;
    uint32_t index = (uint32_t)p->node_count++;
    range children[BVH_WIDTH];
    uint32_t count = make_children(b, r, children);
    if (upper && atomic_load(&b->job->progress->stop)) p->failed = true;
    bvh_node node = {0};
    /* A box that no ray passes, and finite: mixed with weight 0 it stays such. */
    const bounds3 nothing = {{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
    for (uint32_t i = 0; i < BVH_WIDTH; i++) {
        set_child_box(&node, i, i < count ? &children[i].box : &nothing);
        if (i < count) node.valid |= 1u << i;
    }
    for (uint32_t i = 0; i < count && !p->failed; i++) {
        const range *child = &children[i];
        if (upper && child->count <= b->task_size)
            p->failed |= !add_task(b, child, index, i, level + 1);
        else if (child->count <= b->job->leaf_size)
            node.child[i] = add_leaf(b, p, child);
        else
            node.child[i] = add_node(b, p, child, level + 1, upper);
    }
    p->nodes[index] = node;
    if (upper && b->reports && !build_progress_report(b->job->progress)) p->failed = true;
    return index;
}

/* ---- tasks, and joining them ---- */

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
    if (t->range.count <= b->job->leaf_size)
        t->part.root = add_leaf(b, &t->part, &t->range);
    else
        t->part.root = add_node(b, &t->part, &t->range, t->level, false);
    atomic_fetch_add(&progress->done, t->range.count);
    if (worker == 0 && b->reports && !build_progress_report(progress)) t->part.failed = true;
}

static uint32_t relocate(uint32_t reference, size_t node_base, size_t block_base, bool single) {
    if (!(reference & BVH_LEAF)) return reference + (uint32_t)node_base;
    return single ? reference : reference + (uint32_t)block_base;
}

static void append_part(const builder *b, bvh_tree *out, const part *p) {
    bool single = b->job->mesh == NULL;
    for (size_t i = 0; i < p->node_count; i++) {
        bvh_node *node = &out->nodes[out->node_count + i];
        *node = p->nodes[i];
        for (uint32_t j = 0; j < BVH_WIDTH; j++)
            if (node->valid >> j & 1)
                node->child[j] =
                    relocate(node->child[j], out->node_count, out->block_count, single);
    }
    if (p->block_count)
        memcpy(out->blocks + out->block_count, p->blocks, p->block_count * sizeof *p->blocks);
    out->node_count += p->node_count;
    out->block_count += p->block_count;
}

/* The upper part first, then the tasks in their order. */
static bool join(const builder *b, const part *upper, bvh_tree *out) {
    size_t nodes = upper->node_count, blocks = upper->block_count;
    for (size_t i = 0; i < b->task_count; i++) {
        nodes += b->tasks[i].part.node_count;
        blocks += b->tasks[i].part.block_count;
    }
    if (nodes > BVH_INDEX_MASK || blocks > BVH_INDEX_MASK) return false;
    out->nodes = memory_aligned(nodes * sizeof *out->nodes);
    out->blocks = b->job->mesh ? memory_aligned(blocks * sizeof *out->blocks) : NULL;
    if (out->nodes == NULL || (b->job->mesh && out->blocks == NULL)) return false;
    append_part(b, out, upper);
    out->root = upper->root;
    for (size_t i = 0; i < b->task_count; i++) {
        const task *t = &b->tasks[i];
        uint32_t root =
            relocate(t->part.root, out->node_count, out->block_count, b->job->mesh == NULL);
        out->nodes[t->node].child[t->child] = root;
        append_part(b, out, &t->part);
    }
    return true;
}

static void free_part(part *p) {
    free(p->nodes);
    free(p->blocks);
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

void build_widen(bvh_tree *tree, uint32_t keys) {
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
    for (size_t i = 0; i < keys * tree->node_count; i++) {
        bvh_node *node = &tree->nodes[i];
        for (uint32_t j = 0; j < BVH_WIDTH; j++) {
            if (!(node->valid >> j & 1)) continue;
            double low[3], high[3];
            for (int axis = 0; axis < 3; axis++) {
                low[axis] = (double)node->bounds[0][axis][j] - margin;
                high[axis] = (double)node->bounds[1][axis][j] + margin;
            }
            bounds3 box = bounds3_outward((dvec3){low[0], low[1], low[2]},
                                          (dvec3){high[0], high[1], high[2]});
            set_child_box(node, j, &box);
        }
    }
    tree->margin = (float)margin;
}

void build_tree_free(bvh_tree *tree) {
    memory_free_aligned(tree->nodes);
    memory_free_aligned(tree->blocks);
    *tree = (bvh_tree){0};
}

/* Serially, then the tasks; false on failure. */
static bool build_parts(builder *b, part *upper, const range *all) {
    thread_pool *pool = b->pool;
    bool single = b->job->mesh == NULL;
    if (!single && all->count <= b->job->leaf_size) {
        upper->root = add_leaf(b, upper, all);
        return !upper->failed;
    }
    upper->root = add_node(b, upper, all, 0, all->count > b->task_size);
    if (upper->failed) return false;
    if (pool && b->task_count) thread_pool_run(pool, b->task_count, run_task, b);
    for (size_t i = 0; i < b->task_count && !pool; i++) run_task(b, i, 0);
    for (size_t i = 0; i < b->task_count; i++)
        if (b->tasks[i].part.failed) return false;
    return true;
}

static bool build_whole(builder *b, bvh_tree *out) {
    range all = {.begin = 0, .count = b->job->count};
    if (all.count > CHUNK_SIZE) {
        b->chunks = memory_resize(NULL, all.count / CHUNK_SIZE + 1, sizeof *b->chunks);
        if (b->chunks == NULL) return false;
    }
    measure(b, &all);
    part upper = {0};
    bool ok = build_parts(b, &upper, &all) && join(b, &upper, out);
    out->bounds = all.box;
    free_part(&upper);
    for (size_t i = 0; i < b->task_count; i++) free_part(&b->tasks[i].part);
    free(b->tasks);
    free(b->chunks);
    return ok;
}

snell_status build_tree(const build_job *job, thread_pool *pool, bool reports, bvh_tree *out) {
    *out = (bvh_tree){0};
    builder b = {
        .job = job, .task_size = job->count / TASKS_WANTED, .reports = reports, .pool = pool};
    if (b.task_size < TASK_SIZE_MIN) b.task_size = TASK_SIZE_MIN;
    if (b.task_size > TASK_SIZE_MAX) b.task_size = TASK_SIZE_MAX;
    bool ok = build_whole(&b, out);
    if (b.task_count == 0) {
        atomic_fetch_add(&job->progress->done, job->count);
        if (reports) build_progress_report(job->progress);
    }
    bool stopped = atomic_load(&job->progress->stop);
    if (stopped || !ok) build_tree_free(out);
    return stopped ? SNELL_CANCELLED : ok ? SNELL_OK : SNELL_ERR_MEMORY;
}
