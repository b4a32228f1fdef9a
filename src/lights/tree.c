#include "lights/tree.h"

#include <stdlib.h>

#include "base/memory.h"
#include "maths/functions.h"

typedef struct tree_node {
    light_bounds bounds;
    uint32_t right;  /* the left child follows its parent; 0: a leaf */
    uint32_t light;  /* of a leaf */
    uint32_t parent; /* of the root: itself */
} tree_node;

struct light_tree {
    tree_node *nodes;
    uint32_t node_count;
    uint32_t *leaf_of; /* light to node; NO_LEAF: it has no power */
    uint32_t light_count;
};
#define NO_LEAF UINT32_MAX

/* ---- bounds ---- */

static double angle_of(double cosine) {
    return fn_acos(cosine < -1 ? -1 : cosine > 1 ? 1 : cosine);
}

/* The smallest cone around two cones of normals (Conty Estevez and Kulla, appendix). */
static void unite_cones(const light_bounds *a, const light_bounds *b, light_bounds *out) {
    if (a->cos_spread < b->cos_spread) { /* a is the wider */
        const light_bounds *swap = a;
        a = b;
        b = swap;
    }
    double wide = angle_of(b->cos_spread), narrow = angle_of(a->cos_spread);
    double apart = angle_of(dvec3_dot(a->axis, b->axis));
    out->axis = b->axis;
    out->cos_spread = b->cos_spread;
    if (double_min(apart + narrow, PI) <= wide) return;
    double spread = (wide + apart + narrow) / 2;
    dvec3 about = dvec3_cross(b->axis, a->axis);
    if (spread >= PI || !(dvec3_length(about) > 1e-9)) {
        out->cos_spread = -1;
        return;
    }
    /* The wider one's axis, turned towards the narrower. */
    double by = spread - wide;
    dvec3 across = dvec3_cross(dvec3_normalize(about), b->axis);
    out->axis = dvec3_normalize(
        dvec3_add(dvec3_scale(b->axis, fn_cos(by)), dvec3_scale(across, fn_sin(by))));
    out->cos_spread = fn_cos(spread);
}

static dvec3 lower(dvec3 a, dvec3 b) {
    return (dvec3){double_min(a.x, b.x), double_min(a.y, b.y), double_min(a.z, b.z)};
}
static dvec3 higher(dvec3 a, dvec3 b) {
    return (dvec3){double_max(a.x, b.x), double_max(a.y, b.y), double_max(a.z, b.z)};
}

static light_bounds unite(const light_bounds *a, const light_bounds *b) {
    if (!(a->power > 0)) return *b;
    if (!(b->power > 0)) return *a;
    light_bounds out = {.low = lower(a->low, b->low),
                        .high = higher(a->high, b->high),
                        .cos_emission = double_min(a->cos_emission, b->cos_emission),
                        .power = a->power + b->power,
                        .two_sided = a->two_sided || b->two_sided};
    unite_cones(a, b, &out);
    return out;
}

/* cos(max(0, a - b)) and sin of it, from cosines and sines of both. */
static double cos_less(double sin_a, double cos_a, double sin_b, double cos_b) {
    return cos_a > cos_b ? 1 : cos_a * cos_b + sin_a * sin_b;
}
static double sin_less(double sin_a, double cos_a, double sin_b, double cos_b) {
    return cos_a > cos_b ? 0 : sin_a * cos_b - cos_a * sin_b;
}
static double sine_of(double cosine) { return sqrt(double_max(0, 1 - cosine * cosine)); }

/* What the lights may bring to p: power by squared distance, times the largest cosine at the light,
 * times the largest at the receiver. Never 0 where a light could reach p. */
static double importance(const light_bounds *b, dvec3 p, dvec3 n) {
    dvec3 center = dvec3_scale(dvec3_add(b->low, b->high), 0.5);
    dvec3 half = dvec3_scale(dvec3_sub(b->high, b->low), 0.5), offset = dvec3_sub(p, center);
    double radius2 = dvec3_dot(half, half), distance2 = dvec3_dot(offset, offset);
    double near2 = double_max(distance2, radius2); /* inside, do not grow without bound */
    if (!(near2 > 0)) return b->power;
    dvec3 wi = dvec3_normalize(offset);
    double cosine = dvec3_dot(b->axis, wi);
    if (b->two_sided) cosine = fabs(cosine);
    double sine = sine_of(cosine);
    /* The half-angle under which the lights are seen from p. */
    double cos_b = distance2 <= radius2 ? -1 : sqrt(1 - radius2 / distance2),
           sin_b = sine_of(cos_b);
    double sin_o = sine_of(b->cos_spread);
    double cos_x = cos_less(sine, cosine, sin_o, b->cos_spread),
           sin_x = sin_less(sine, cosine, sin_o, b->cos_spread);
    double cos_light = cos_less(sin_x, cos_x, sin_b, cos_b);
    if (cos_light <= b->cos_emission) return 0;
    if (b->cos_emission < 0) cos_light = 1; /* it shines beyond a hemisphere, so not by a cosine */
    double value = b->power * cos_light / near2;
    if (dvec3_dot(n, n) > 0) {
        double cos_i = -dvec3_dot(wi, n);
        value *= cos_less(sine_of(cos_i), cos_i, sin_b, cos_b);
    }
    return double_max(value, 0);
}

/* ---- building ---- */

enum { BINS = 12, DEPTH_MAX = 60 };

typedef struct builder {
    const light_bounds *lights;
    uint32_t *order;
    light_tree *tree;
} builder;

static double component(dvec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
static double center_of(const light_bounds *b, int axis) {
    return (component(b->low, axis) + component(b->high, axis)) / 2;
}

/* The surface area orientation heuristic: power times area times the measure of directions. */
static double cost(const light_bounds *b) {
    if (!(b->power > 0)) return 0;
    double spread = angle_of(b->cos_spread), emission = angle_of(b->cos_emission);
    double reach = double_min(spread + emission, PI), sine = sine_of(b->cos_spread);
    double directions =
        2 * PI * (1 - b->cos_spread) +
        PI / 2 *
            (2 * reach * sine - fn_cos(spread - 2 * reach) - 2 * spread * sine + b->cos_spread);
    dvec3 d = dvec3_sub(b->high, b->low);
    return b->power * directions * (d.x * d.y + d.y * d.z + d.z * d.x + 1e-12 * dvec3_dot(d, d));
}

typedef struct split {
    int axis; /* -1: none found */
    double at, cost;
} split;

static void try_axis(const builder *b, uint32_t first, uint32_t count, const light_bounds *all,
                     int axis, split *best) {
    double low = INFINITY, high = -INFINITY;
    for (uint32_t i = first; i < first + count; i++) {
        double c = center_of(&b->lights[b->order[i]], axis);
        low = double_min(low, c);
        high = double_max(high, c);
    }
    if (!(high > low)) return;
    light_bounds bins[BINS] = {0};
    for (uint32_t i = first; i < first + count; i++) {
        const light_bounds *l = &b->lights[b->order[i]];
        int bin = (int)((center_of(l, axis) - low) / (high - low) * BINS);
        bin = bin < 0 ? 0 : bin >= BINS ? BINS - 1 : bin;
        bins[bin] = unite(&bins[bin], l);
    }
    dvec3 d = dvec3_sub(all->high, all->low);
    double longest = dvec3_largest(d), side = component(d, axis);
    double thin = side > 0 ? longest / side : INFINITY; /* do not cut along the short sides */
    for (int k = 1; k < BINS; k++) {
        light_bounds left = {0}, right = {0};
        for (int i = 0; i < k; i++) left = unite(&left, &bins[i]);
        for (int i = k; i < BINS; i++) right = unite(&right, &bins[i]);
        if (!(left.power > 0) || !(right.power > 0)) continue;
        double c = thin * (cost(&left) + cost(&right));
        if (c >= best->cost) continue;
        *best = (split){axis, low + (high - low) * k / BINS, c};
    }
}

static uint32_t partition(const builder *b, uint32_t first, uint32_t count, const split *s) {
    uint32_t middle = first;
    for (uint32_t i = first; i < first + count; i++) {
        if (!(center_of(&b->lights[b->order[i]], s->axis) < s->at)) continue;
        uint32_t swap = b->order[i];
        b->order[i] = b->order[middle];
        b->order[middle++] = swap;
    }
    return middle - first;
}

/* Returns the node's index. Too deep, and where no cut helps, the lights are halved as they come. */
static uint32_t build_node(builder *b, uint32_t first, uint32_t count, uint32_t parent, int depth) {
    light_tree *t = b->tree;
    uint32_t index = t->node_count++;
    tree_node *node = &t->nodes[index];
    *node = (tree_node){.parent = parent};
    for (uint32_t i = first; i < first + count; i++)
        node->bounds = unite(&node->bounds, &b->lights[b->order[i]]);
    if (count == 1) {
        node->light = b->order[first];
        t->leaf_of[node->light] = index;
        return index;
    }
    split best = {-1, 0, INFINITY};
    for (int axis = 0; axis < 3 && depth < DEPTH_MAX / 2; axis++)
        try_axis(b, first, count, &node->bounds, axis, &best);
    uint32_t left = best.axis >= 0 ? partition(b, first, count, &best) : 0;
    if (left == 0 || left == count) left = count / 2;
    build_node(b, first, left, index, depth + 1);
    uint32_t right = build_node(b, first + left, count - left, index, depth + 1);
    t->nodes[index].right = right;
    return index;
}

snell_status light_tree_build(const light_bounds *lights, uint32_t count, light_tree **out) {
    light_tree *t = memory_zeroed(1, sizeof *t);
    uint32_t *order = memory_resize(NULL, count, sizeof *order), used = 0;
    if (t) {
        t->light_count = count;
        t->leaf_of = memory_resize(NULL, count, sizeof *t->leaf_of);
        t->nodes = memory_resize(NULL, count ? 2 * (size_t)count : 1, sizeof *t->nodes);
    }
    if (!t || !order || !t->leaf_of || !t->nodes) {
        light_tree_destroy(t);
        free(order);
        return error_no_memory();
    }
    for (uint32_t i = 0; i < count; i++) {
        t->leaf_of[i] = NO_LEAF;
        if (lights[i].power > 0) order[used++] = i;
    }
    builder b = {lights, order, t};
    if (used > 0) build_node(&b, 0, used, 0, 0);
    free(order);
    *out = t;
    return SNELL_OK;
}

void light_tree_destroy(light_tree *tree) {
    if (tree == NULL) return;
    free(tree->nodes);
    free(tree->leaf_of);
    free(tree);
}

/* ---- choosing ---- */

/* The chance of the left child. Where neither seems to matter, both do alike: an importance of 0 is
 * exact only for a leaf. */
static double chance_left(const light_tree *t, uint32_t left, dvec3 p, dvec3 n) {
    uint32_t right = t->nodes[t->nodes[left].parent].right;
    double a = importance(&t->nodes[left].bounds, p, n),
           b = importance(&t->nodes[right].bounds, p, n);
    return a + b > 0 ? a / (a + b) : 0.5;
}

bool light_tree_sample(const light_tree *t, dvec3 p, dvec3 n, double u, uint32_t *index,
                       double *chance) {
    if (t->node_count == 0) return false;
    uint32_t at = 0;
    double product = 1;
    while (t->nodes[at].right != 0) {
        double left = chance_left(t, at + 1, p, n);
        bool go_left = u < left;
        product *= go_left ? left : 1 - left;
        u = go_left ? u / left : (u - left) / (1 - left);
        if (!(u < 1)) u = 0x1.fffffffffffffp-1;
        at = go_left ? at + 1 : t->nodes[at].right;
    }
    *index = t->nodes[at].light;
    *chance = product;
    return product > 0;
}

double light_tree_chance(const light_tree *t, dvec3 p, dvec3 n, uint32_t index) {
    uint32_t at = t->leaf_of[index];
    if (at == NO_LEAF) return 0;
    double product = 1;
    while (at != 0) {
        uint32_t parent = t->nodes[at].parent;
        double left = chance_left(t, parent + 1, p, n);
        product *= at == parent + 1 ? left : 1 - left;
        at = parent;
    }
    return product;
}
