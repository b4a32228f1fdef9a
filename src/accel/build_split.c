/* Binned SAH: Wald, On fast Construction of SAH-based Bounding Volume Hierarchies, 2007. All three
 * axes at once, in lanes. Every choice depends only on the references in their order, never on
 * threads: chunks have sizes of their own, and are joined in order. */
#include "accel/build_split.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "accel/build_ways.h"
#include "base/memory.h"

enum { BIN_COUNT = 16, CHUNKS_MAX = 256, CHUNK_SIZE_MIN = 4096 };

typedef struct binning {
    f4 low, scale;       /* scale 0: the axis cannot be split */
    uint32_t axis, axes; /* the first that is looked at, and how many */
} binning;

typedef struct split {
    int axis;     /* -1: none */
    uint32_t bin; /* the first bin of the right side */
} split;

typedef struct bins {
    box4 box[3][BIN_COUNT];
    uint32_t count[BIN_COUNT][4]; /* of each axis, and 0 */
} bins;

/* What one chunk of a range holds. */
struct split_chunk {
    bins bins;
    size_t left, right; /* where its halves go, and their boxes */
    build_range halves[2];
};

/* ---- geometry of references ---- */

/* Twice the midpoint; large where boxes of instances are infinite. */
static f4 center_of(box4 box) {
    return f4_max(f4_min(f4_add(box.low, box.high), f4_set(FLT_MAX)), f4_set(-FLT_MAX));
}

/* Long ranges come from memory faster if they are asked for in time. */
static void fetch_ahead(const build_reference *r) {
    __builtin_prefetch((const void *)((uintptr_t)r + 64 * sizeof *r));
}

static void measure_centers(const splitter *s, build_range *r) {
    const build_reference *references = s->sides[r->side] + r->begin;
    box4 centers[2] = {box4_empty(), box4_empty()};
    for (size_t i = 0; i < r->count; i++) { /* in turn, so that no minimum waits for the last */
        f4 center = center_of(box4_of(&references[i]));
        centers[i & 1] = box4_union(centers[i & 1], (box4){center, center});
    }
    r->centers = box4_union(centers[0], centers[1]);
}

static void measure(const splitter *s, build_range *r) {
    const build_reference *references = s->sides[r->side] + r->begin;
    r->box = box4_empty();
    for (size_t i = 0; i < r->count; i++) r->box = box4_union(r->box, box4_of(&references[i]));
    measure_centers(s, r);
}

/* ---- bins ---- */

static binning make_binning(const splitter *s, const box4 *centers) {
    float low[4], high[4], scale[4];
    f4_store(low, centers->low);
    f4_store(high, centers->high);
    for (int axis = 0; axis < 3; axis++) {
        double extent = (double)high[axis] - (double)low[axis],
               per_unit = extent > 0 ? BIN_COUNT * (1 - 1e-6) / extent : 0;
        scale[axis] = per_unit < (double)FLT_MAX ? (float)per_unit : FLT_MAX;
    }
    /* Lane 3 of a reference is its number: as a float denormal, which is slow to multiply. */
    low[3] = -1, scale[3] = 0;
    binning g = {f4_load(low), f4_load(scale), 0, 3};
    if (s->job->quality != ACCEL_FAST || s->job->seed) return g;
    g.axes = 1; /* the longest */
    for (uint32_t axis = 0; axis < 3; axis++)
        if (scale[axis] > 0 && (scale[axis] < scale[g.axis] || scale[g.axis] == 0)) g.axis = axis;
    return g;
}

static void clear_bins(bins *b) {
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < BIN_COUNT; i++) b->box[axis][i] = box4_empty();
    memset(b->count, 0, sizeof b->count);
}

/* Truncated, and at most the last: the bin on each axis. */
static f4 bin_place(box4 box, const binning *g) {
    return f4_mul(f4_sub(center_of(box), g->low), g->scale);
}

static void fill_bins(const build_reference *references, size_t count, const binning *g,
                      bins *out) {
    clear_bins(out);
    for (size_t i = 0; i < count; i++) {
        box4 box = box4_of(&references[i]);
        fetch_ahead(&references[i]);
        uint32_t bin[3];
        f4_indices(f4_min(bin_place(box, g), f4_set(BIN_COUNT - 1)), bin);
        for (uint32_t axis = g->axis; axis < g->axis + g->axes; axis++) {
            box4 *to = &out->box[axis][bin[axis]];
            *to = box4_union(*to, box);
            out->count[bin[axis]][axis]++;
        }
    }
}

static void join_bins(bins *to, const bins *from) {
    for (int i = 0; i < BIN_COUNT; i++)
        for (int axis = 0; axis < 3; axis++) {
            to->box[axis][i] = box4_union(to->box[axis][i], from->box[axis][i]);
            to->count[i][axis] += from->count[i][axis];
        }
}

/* ---- choosing a split ---- */

/* Of one side, for each axis in its lane: the half area of its box times the leaves it needs. NaN
 * where the side is empty. `scale` keeps areas from overflowing. */
static f4 side_cost(const splitter *s, const box4 side[3], f4 counts, f4 scale) {
    f4 x = f4_sub(side[0].high, side[0].low), y = f4_sub(side[1].high, side[1].low),
       z = f4_sub(side[2].high, side[2].low), rest = f4_set(0);
    f4_transpose(&x, &y, &z, &rest);
    x = f4_mul(x, scale), y = f4_mul(y, scale), z = f4_mul(z, scale);
    f4 area = f4_add(f4_mul(x, f4_add(y, z)), f4_mul(y, z));
    f4 full = f4_add(counts, f4_set((float)(s->job->leaf_size - 1)));
    return f4_mul(area, f4_truncate(f4_mul(full, s->leaf_inverse)));
}

static void join_bin(box4 side[3], f4 *counts, const bins *b, uint32_t i) {
    for (int axis = 0; axis < 3; axis++) side[axis] = box4_union(side[axis], b->box[axis][i]);
    *counts = f4_add(*counts, f4_from_counts(b->count[i]));
}

static split best_split(const splitter *s, const build_range *r, const bins *b) {
    bounds3 whole = box4_bounds(r->box);
    f4 scale = f4_set(1 / vec3_largest(vec3_sub(whole.max, whole.min)));
    f4 right_cost[BIN_COUNT], best_cost = f4_set(INFINITY), best_bin = f4_set(0);
    box4 side[3] = {box4_empty(), box4_empty(), box4_empty()};
    f4 counts = f4_set(0);
    for (uint32_t i = BIN_COUNT - 1; i > 0; i--) {
        join_bin(side, &counts, b, i);
        right_cost[i] = side_cost(s, side, counts, scale);
    }
    for (int axis = 0; axis < 3; axis++) side[axis] = box4_empty();
    counts = f4_set(0);
    for (uint32_t i = 1; i < BIN_COUNT; i++) {
        join_bin(side, &counts, b, i - 1);
        f4 cost = f4_add(side_cost(s, side, counts, scale), right_cost[i]);
        best_bin = f4_select_less(cost, best_cost, f4_set((float)i), best_bin);
        best_cost = f4_min(cost, best_cost); /* NaN: what was */
    }
    float costs[4], at[4], least = INFINITY;
    f4_store(costs, best_cost);
    f4_store(at, best_bin);
    split best = {-1, 0};
    for (int axis = 0; axis < 3; axis++)
        if (costs[axis] < least) {
            least = costs[axis];
            best = (split){axis, (uint32_t)at[axis]};
        }
    return best;
}

uint32_t split_scramble(uint32_t x) {
    x ^= x >> 16, x *= 0x7feb352du;
    x ^= x >> 15, x *= 0x846ca68bu;
    return x ^ x >> 16;
}

/* For tests of the hit rule: any tree at all. */
static split random_split(const splitter *s, const build_range *r, const bins *b) {
    uint32_t h = split_scramble(
        s->job->seed ^ split_scramble((uint32_t)r->begin ^ split_scramble((uint32_t)r->count)));
    if (h >> 2 & 1) return best_split(s, r, b);
    return (split){(int)(h % 3), 1 + (h >> 8) % (BIN_COUNT - 1)};
}

static split choose_split(const splitter *s, const build_range *r, const bins *b) {
    return s->job->seed ? random_split(s, r, b) : best_split(s, r, b);
}

static box4 half_box(const bins *b, split s, uint32_t half) {
    box4 box = box4_empty();
    uint32_t end = half ? BIN_COUNT : s.bin;
    for (uint32_t i = half ? s.bin : 0; i < end; i++) box = box4_union(box, b->box[s.axis][i]);
    return box;
}

static size_t count_left(const bins *b, split s) {
    size_t count = 0;
    for (uint32_t i = 0; i < s.bin; i++) count += b->count[i][s.axis];
    return count;
}

/* Copies references in order, those of the left half to one place and the others to another. */
static void scatter(const build_reference *from, size_t count, const binning *g, split s,
                    build_reference *to, size_t left, size_t right) {
    f4 first = f4_set((float)s.bin);
    for (size_t i = 0; i < count; i++) { /* without a branch, which would be a coin's toss */
        box4 box = box4_of(&from[i]);
        unsigned less = f4_less_bits(bin_place(box, g), first);
        size_t goes_left = less >> s.axis & 1, at = right + (left - right) * goes_left;
        f4_store(&to[at].min.x, box.low);
        f4_store(&to[at].max.x, box.high);
        left += goes_left;
        right += 1 - goes_left;
    }
}

/* ---- how many leaves there may be ---- */

size_t split_leaves_at_most(uint32_t leaf_size, size_t count) {
    return count / (leaf_size > 1 ? leaf_size / 2 : 1) + 1;
}

/* That a range gets by being halved again and again. */
static size_t leaves_by_halving(const splitter *s, size_t count) {
    size_t leaf = s->job->leaf_size, pieces = 1;
    if (count <= leaf) return 1;
    while (count > 2 * leaf * pieces) pieces *= 2;
    size_t over = count - leaf * pieces; /* pieces that have one too many; or all have */
    return pieces + (over < pieces ? over : pieces);
}

/* Into so many and the rest? *spare: what is left of it then. */
static bool may_split(const splitter *s, const build_range *r, size_t count, size_t *spare) {
    if (count == 0 || count == r->count) return false;
    size_t have = *spare + leaves_by_halving(s, r->count),
           need = leaves_by_halving(s, count) + leaves_by_halving(s, r->count - count);
    if (need > have) return false;
    *spare = have - need;
    return true;
}

/* ---- long ranges: in chunks, by all threads ---- */

typedef struct sweep {
    const splitter *splitter;
    const build_range *range;
    size_t chunk_size;
    binning binning;
    split split;
} sweep;

static size_t chunk_size_of(size_t count) {
    size_t size = (count + CHUNKS_MAX - 1) / CHUNKS_MAX;
    return size < CHUNK_SIZE_MIN ? CHUNK_SIZE_MIN : size;
}

static build_range chunk_range(const sweep *w, size_t index) {
    size_t skipped = index * w->chunk_size, left = w->range->count - skipped;
    return (build_range){.begin = w->range->begin + skipped,
                         .count = left < w->chunk_size ? left : w->chunk_size,
                         .side = w->range->side};
}

static void measure_chunk(void *data, size_t index, uint32_t worker) {
    (void)worker;
    const sweep *w = data;
    build_range *part = &w->splitter->chunks[index].halves[0];
    *part = chunk_range(w, index);
    measure(w->splitter, part);
}

static void bin_chunk(void *data, size_t index, uint32_t worker) {
    (void)worker;
    const sweep *w = data;
    build_range part = chunk_range(w, index);
    fill_bins(w->splitter->sides[part.side] + part.begin, part.count, &w->binning,
              &w->splitter->chunks[index].bins);
}

static void scatter_chunk(void *data, size_t index, uint32_t worker) {
    (void)worker;
    const sweep *w = data;
    split_chunk *c = &w->splitter->chunks[index];
    build_range part = chunk_range(w, index);
    build_reference *const *sides = w->splitter->sides;
    scatter(sides[part.side] + part.begin, part.count, &w->binning, w->split, sides[!part.side],
            c->left, c->right);
    size_t left_count = count_left(&c->bins, w->split);
    c->halves[0] = (build_range){.begin = c->left, .count = left_count, .side = !part.side};
    c->halves[1] =
        (build_range){.begin = c->right, .count = part.count - left_count, .side = !part.side};
    for (int i = 0; i < 2; i++) measure_centers(w->splitter, &c->halves[i]);
}

static size_t run_sweep(sweep *w, thread_task *task) {
    size_t count = (w->range->count + w->chunk_size - 1) / w->chunk_size;
    thread_pool *pool = w->splitter->pool;
    if (pool) thread_pool_run(pool, count, task, w);
    for (size_t i = 0; i < count && !pool; i++) task(w, i, 0);
    return count;
}

static box4 join_centers(const splitter *s, size_t chunks, uint32_t half) {
    box4 centers = box4_empty();
    for (size_t i = 0; i < chunks; i++)
        centers = box4_union(centers, s->chunks[i].halves[half].centers);
    return centers;
}

static void measure_any(const splitter *s, build_range *r) {
    if (r->count <= s->serial_size) {
        measure(s, r);
        return;
    }
    sweep w = {.splitter = s, .range = r, .chunk_size = chunk_size_of(r->count)};
    size_t chunks = run_sweep(&w, measure_chunk);
    r->box = box4_empty();
    for (size_t i = 0; i < chunks; i++) r->box = box4_union(r->box, s->chunks[i].halves[0].box);
    r->centers = join_centers(s, chunks, 0);
}

/* Both: false where the SAH finds nothing to split. The halves come with their boxes. */
static bool split_long(const splitter *s, const build_range *r, const binning *g,
                       build_range halves[2], size_t *spare) {
    sweep w = {.splitter = s, .range = r, .chunk_size = chunk_size_of(r->count), .binning = *g};
    size_t chunks = run_sweep(&w, bin_chunk);
    bins all;
    clear_bins(&all);
    for (size_t i = 0; i < chunks; i++) join_bins(&all, &s->chunks[i].bins);
    w.split = choose_split(s, r, &all);
    if (w.split.axis < 0) return false;
    size_t count = count_left(&all, w.split), left = r->begin, right = r->begin + count;
    if (!may_split(s, r, count, spare)) return false;
    for (size_t i = 0; i < chunks; i++) {
        s->chunks[i].left = left, s->chunks[i].right = right;
        size_t skipped = i * w.chunk_size, own = r->count - skipped;
        if (own > w.chunk_size) own = w.chunk_size;
        size_t own_left = count_left(&s->chunks[i].bins, w.split);
        left += own_left, right += own - own_left;
    }
    run_sweep(&w, scatter_chunk);
    halves[0].count = count;
    for (uint32_t i = 0; i < 2; i++) {
        halves[i].box = half_box(&all, w.split, i);
        halves[i].centers = join_centers(s, chunks, i);
    }
    return true;
}

static bool split_short(const splitter *s, const build_range *r, const binning *g,
                        build_range halves[2], size_t *spare) {
    bins b;
    const build_reference *from = s->sides[r->side] + r->begin;
    fill_bins(from, r->count, g, &b);
    split chosen = choose_split(s, r, &b);
    if (chosen.axis < 0) return false;
    size_t count = count_left(&b, chosen);
    if (!may_split(s, r, count, spare)) return false;
    scatter(from, r->count, g, chosen, s->sides[!r->side], r->begin, r->begin + count);
    halves[0] = (build_range){.begin = r->begin, .count = count, .side = !r->side};
    halves[1] = (build_range){r->begin + count, r->count - count, .side = !r->side};
    for (uint32_t i = 0; i < 2; i++) {
        halves[i].box = half_box(&b, chosen, i);
        if (halves[i].count > s->job->leaf_size) measure_centers(s, &halves[i]);
    }
    return true;
}

void split_range(const splitter *s, const build_range *r, size_t *spare, build_range *left,
                 build_range *right) {
    build_range halves[2] = {{.count = 0}, {.count = 0}};
    bool by_boxes = s->job->ways == NULL || s->job->seed, is_long = r->count > s->serial_size,
         done = false, measured = false;
    uint32_t side = r->side;
    if (r->depth < BVH_SAH_DEPTH && by_boxes) {
        binning g = make_binning(s, &r->centers);
        done = is_long ? split_long(s, r, &g, halves, spare) : split_short(s, r, &g, halves, spare);
        measured = done;
        side = done ? !r->side : r->side;
    } else if (r->depth < BVH_SAH_DEPTH) {
        halves[0].count = build_split_ways(s->job, s->sides[side] + r->begin, r->count);
        done = may_split(s, r, halves[0].count, spare);
    }
    if (!done) halves[0].count = r->count / 2;
    halves[1].count = r->count - halves[0].count;
    halves[0].begin = r->begin;
    halves[1].begin = r->begin + halves[0].count;
    for (int i = 0; i < 2; i++) {
        halves[i].depth = r->depth + 1;
        halves[i].side = side;
        if (!measured) measure_any(s, &halves[i]);
    }
    *left = halves[0];
    *right = halves[1];
}

size_t split_spare(const splitter *s) {
    size_t count = s->job->count;
    if (s->job->seed) return count; /* whatever there may be */
    return split_leaves_at_most(s->job->leaf_size, count) - leaves_by_halving(s, count);
}

build_range split_whole(const splitter *s) {
    build_range all = {.begin = 0, .count = s->job->count};
    measure_any(s, &all);
    return all;
}

bool splitter_init(splitter *s, const build_job *job, thread_pool *pool, size_t serial_size) {
    *s = (splitter){.job = job,
                    .sides = {job->references, NULL},
                    .pool = pool,
                    .serial_size = serial_size,
                    .leaf_inverse = f4_set((1 + 0x1p-22f) / (float)job->leaf_size)};
    if (job->count < SIZE_MAX / sizeof *s->sides[1])
        s->sides[1] = memory_aligned(job->count * sizeof *s->sides[1]);
    if (s->sides[1] && job->count > serial_size) {
        size_t size = chunk_size_of(job->count);
        s->chunks = memory_aligned((job->count + size - 1) / size * sizeof *s->chunks);
        if (s->chunks == NULL) return false;
    }
    return s->sides[1] != NULL;
}

void splitter_free(splitter *s) {
    memory_free_aligned(s->sides[0]);
    memory_free_aligned(s->sides[1]);
    memory_free_aligned(s->chunks);
    s->sides[0] = s->sides[1] = NULL;
    s->chunks = NULL;
}
