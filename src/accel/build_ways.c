/* Splitting the ways of a mesh that deforms: SAH with the sum of the areas at each moment, in bins
 * along each axis at each moment, so that what goes together stays together. */
#include "accel/build_ways.h"

enum { BIN_COUNT = 16 };

typedef struct binning {
    double low[3], scale[3]; /* scale 0: the axis cannot be split */
} binning;

typedef struct split {
    int axis;     /* -1: none */
    uint32_t bin; /* the first bin of the right side */
} split;

static float axis_of(vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

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

/* What a side costs: its area times the leaves it needs. */
static double side_cost(const build_job *job, const bounds3 *box, size_t count) {
    size_t leaf = job->leaf_size;
    return bounds3_half_area(*box) * (double)((count + leaf - 1) / leaf);
}

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
    return vec3_add(vec3_scale(box.min, 0.5f), vec3_scale(box.max, 0.5f));
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

static void fill_way_bins(const build_job *job, const build_reference *references, size_t count,
                          way_bins *w) {
    bounds3 centers[BUILD_MOMENTS];
    for (int j = 0; j < BUILD_MOMENTS; j++) centers[j] = bounds3_empty();
    for (size_t i = 0; i < count; i++) {
        const build_way *way = &job->ways[references[i].id];
        for (int j = 0; j < BUILD_MOMENTS; j++)
            centers[j] = bounds3_add_point(centers[j], way_center(way, j));
    }
    for (int j = 0; j < BUILD_MOMENTS; j++) {
        w->grid[j] = make_binning(&centers[j]);
        for (int axis = 0; axis < 3; axis++)
            for (int i = 0; i < BIN_COUNT; i++) clear_way_bin(&w->bins[j][axis][i]);
    }
    for (size_t i = 0; i < count; i++) {
        const build_way *way = &job->ways[references[i].id];
        for (int j = 0; j < BUILD_MOMENTS; j++) {
            vec3 center = way_center(way, j);
            for (int axis = 0; axis < 3; axis++)
                join_way(&w->bins[j][axis][bin_of(&w->grid[j], axis, center)], way, 1);
        }
    }
}

static double way_cost(const build_job *job, const way_bin *side) {
    double cost = 0;
    for (int j = 0; j < BUILD_MOMENTS; j++) {
        bounds3 box = way_box(&side->box, j);
        cost += side_cost(job, &box, side->count);
    }
    return cost;
}

static split best_way_split(const build_job *job, size_t count, const way_bins *w, int *moment) {
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
                right_cost[i] = way_cost(job, &side);
            }
            clear_way_bin(&side);
            for (uint32_t i = 1; i < BIN_COUNT; i++) {
                join_way(&side, &bins[i - 1].box, bins[i - 1].count);
                if (side.count == 0 || side.count == count) continue;
                double cost = way_cost(job, &side) + right_cost[i];
                if (!(cost < best_cost)) continue;
                best_cost = cost;
                best = (split){axis, i};
                *moment = j;
            }
        }
    return best;
}

size_t build_split_ways(const build_job *job, build_reference *references, size_t count) {
    way_bins w;
    fill_way_bins(job, references, count, &w);
    int moment = 0;
    split s = best_way_split(job, count, &w, &moment);
    if (s.axis < 0) return 0;
    build_reference *low = references, *high = low + count;
    while (low < high) {
        vec3 center = way_center(&job->ways[low->id], moment);
        if (bin_of(&w.grid[moment], s.axis, center) < s.bin) {
            low++;
            continue;
        }
        build_reference swap = *low;
        *low = *--high;
        *high = swap;
    }
    return (size_t)(low - references);
}
