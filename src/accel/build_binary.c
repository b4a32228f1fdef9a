/* Insertion-based optimisation: Bittner, Hapala, Havran, Fast Insertion-Based Optimization of Bounding
 * Volume Hierarchies, 2013; the search for a better place goes up from the node and down into the
 * subtrees on the way, as in Meister, Bittner, Parallel Reinsertion for Bounding Volume Hierarchy
 * Optimization, 2018. In each round all threads search places for the largest nodes in the tree as it
 * is; then those that still gain are moved in order, so that the tree does not depend on threads. */
#include "accel/build_binary.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum {
    ROUNDS = 6,
    MOVED_SHARE = 128, /* of so many nodes one is looked at in a round */
    SEARCH_SIZE = 64   /* nodes that a thread looks at in one go */
};

/* ---- building: the upper part, then subtrees as tasks, which are put in their places ---- */

typedef struct subtree {
    build_range range;
    uint32_t node; /* what it is to replace */
    binary_tree tree;
    bool ok;
} subtree;

typedef struct growth {
    const splitter *splitter;
    binary_tree *tree;
    subtree *subtrees;
    size_t count, capacity;
    size_t spare; /* when the upper part is done */
} growth;

static bool is_leaf(const binary_node *n) { return n->child[0] == BINARY_NONE; }

static void set_height(const binary_tree *t, binary_node *n) {
    uint32_t a = t->nodes[n->child[0]].height, b = t->nodes[n->child[1]].height;
    n->height = 1 + (a > b ? a : b);
}

/* g: NULL below the upper part. spare: as of split_range. */
static uint32_t add_node(const splitter *s, growth *g, const build_range *r, uint32_t parent,
                         size_t *spare, binary_tree *t) {
    if (!ARRAY_GROW(t->nodes, t->count, t->capacity, 1)) return BINARY_NONE;
    uint32_t index = (uint32_t)t->count++;
    t->nodes[index] = (binary_node){.box = r->box,
                                    .parent = parent,
                                    .child = {BINARY_NONE, BINARY_NONE},
                                    .count = (uint32_t)r->count,
                                    .begin = (uint32_t)r->begin,
                                    .side = r->side};
    if (g && r->count <= s->serial_size) {
        if (!ARRAY_GROW(g->subtrees, g->count, g->capacity, 1)) return BINARY_NONE;
        g->subtrees[g->count++] = (subtree){.range = *r, .node = index};
        return index;
    }
    if (r->count <= s->job->leaf_size) return index;
    build_range halves[2];
    split_range(s, r, spare, &halves[0], &halves[1]);
    for (int i = 0; i < 2; i++) {
        uint32_t child = add_node(s, g, &halves[i], index, spare, t);
        if (child == BINARY_NONE) return BINARY_NONE;
        t->nodes[index].child[i] = child;
    }
    return index;
}

static void grow_subtree(void *data, size_t index, uint32_t worker) {
    (void)worker;
    const growth *g = data;
    subtree *sub = &g->subtrees[index];
    size_t spare = split_share(g->splitter, g->spare, sub->range.count);
    sub->ok =
        !atomic_load(&g->splitter->job->progress->stop) &&
        add_node(g->splitter, NULL, &sub->range, BINARY_NONE, &spare, &sub->tree) != BINARY_NONE;
}

/* There is room. Its root takes the place of the node that stood for it. */
static bool graft(binary_tree *t, const subtree *sub) {
    size_t more = sub->tree.count - 1;
    if (!sub->ok) return false;
    uint32_t shift = (uint32_t)t->count - 1; /* its node 1 becomes the next */
    for (size_t i = 0; i <= more; i++) {
        binary_node n = sub->tree.nodes[i];
        n.parent = i == 0 ? t->nodes[sub->node].parent : n.parent ? n.parent + shift : sub->node;
        for (int k = 0; k < 2; k++)
            if (n.child[k] != BINARY_NONE) n.child[k] += shift;
        t->nodes[i == 0 ? sub->node : shift + i] = n;
    }
    t->count += more;
    return true;
}

static void run(const splitter *s, size_t count, thread_task *work, void *data) {
    if (s->pool) thread_pool_run(s->pool, count, work, data);
    for (size_t i = 0; i < count && !s->pool; i++) work(data, i, 0);
}

static bool grow(const splitter *s, const build_range *r, binary_tree *out) {
    growth g = {.splitter = s, .tree = out, .spare = split_spare(s)};
    bool ok = add_node(s, &g, r, BINARY_NONE, &g.spare, out) != BINARY_NONE;
    if (ok) run(s, g.count, grow_subtree, &g);
    size_t more = 0;
    for (size_t i = 0; i < g.count; i++) more += g.subtrees[i].tree.count;
    ok = ok && ARRAY_GROW(out->nodes, out->count, out->capacity, more);
    for (size_t i = 0; i < g.count; i++) {
        ok = ok && graft(out, &g.subtrees[i]);
        binary_free(&g.subtrees[i].tree);
    }
    free(g.subtrees);
    /* Children come after their parents. */
    for (size_t i = ok ? out->count : 0; i-- > 0;)
        if (!is_leaf(&out->nodes[i])) set_height(out, &out->nodes[i]);
    return ok;
}

build_range binary_range(const binary_tree *t, uint32_t node, uint32_t depth) {
    const binary_node *n = &t->nodes[node];
    return (build_range){.begin = n->begin,
                         .count = n->count,
                         .box = n->box,
                         .depth = depth,
                         .side = n->side,
                         .node = node};
}

void binary_free(binary_tree *t) {
    free(t->nodes);
    *t = (binary_tree){0};
}

/* ---- reinsertion ---- */

typedef struct candidate {
    uint32_t node;
    float inherited; /* by how much the nodes above it would grow */
} candidate;

typedef struct place {
    uint32_t node; /* to become the sibling of */
    float gain;    /* of area, over all nodes */
} place;

typedef struct sized {
    float area;
    uint32_t node;
} sized;

typedef struct optimiser {
    const splitter *splitter;
    binary_tree *tree;
    float scale;   /* keeps areas from overflowing */
    sized *chosen; /* in a round */
    size_t chosen_count;
    uint32_t *targets; /* of the chosen: BINARY_NONE, or where to */
} optimiser;

/* No path is longer; a search leaves one node behind for each level. */
enum { PATH_MAX_LENGTH = BVH_DEPTH_MAX + 1, STACK_SIZE = BVH_DEPTH_MAX + 2 };

static float area_of(const optimiser *o, box4 box) {
    float size[4];
    f4_store(size, f4_mul(f4_sub(box.high, box.low), f4_set(o->scale)));
    return size[0] * (size[1] + size[2]) + size[1] * size[2];
}

static uint32_t sibling_of(const binary_tree *t, uint32_t node) {
    const binary_node *parent = &t->nodes[t->nodes[node].parent];
    return parent->child[parent->child[0] == node];
}

/* Is there a better place for a box in the subtree of `root`? won: what its removal gives. */
static void search_subtree(const optimiser *o, box4 box, float least, uint32_t root, float won,
                           place *best) {
    candidate stack[STACK_SIZE];
    size_t count = 0;
    stack[count++] = (candidate){root, 0};
    while (count) {
        candidate c = stack[--count];
        if (!(won - c.inherited - least > best->gain)) continue;
        const binary_node *n = &o->tree->nodes[c.node];
        float joined = area_of(o, box4_union(n->box, box)), gain = won - c.inherited - joined;
        if (gain > best->gain) *best = (place){c.node, gain};
        float inherited = c.inherited + joined - area_of(o, n->box);
        if (is_leaf(n) || !(won - inherited - least > best->gain)) continue;
        for (int i = 0; i < 2; i++) stack[count++] = (candidate){n->child[i], inherited};
    }
}

/* The nodes at and above the pivot hold the same before and after, so that only those below count. */
static place find_place(const optimiser *o, uint32_t node) {
    const binary_node *nodes = o->tree->nodes;
    box4 box = nodes[node].box;
    float least = area_of(o, box);
    uint32_t pivot = nodes[node].parent, below = node;
    float won = area_of(o, nodes[pivot].box);
    place best = {BINARY_NONE, 1e-6f * won}; /* not for less than roundings */
    box4 rest = box4_empty();                /* of what is below, without the node */
    for (;;) {
        uint32_t other = sibling_of(o->tree, below);
        search_subtree(o, box, least, other, won, &best);
        rest = box4_union(rest, nodes[other].box);
        if (pivot != nodes[node].parent) won += area_of(o, nodes[pivot].box) - area_of(o, rest);
        below = pivot;
        pivot = nodes[pivot].parent;
        if (pivot == BINARY_NONE) return best;
    }
}

static void refit_above(binary_tree *t, uint32_t node) {
    for (; node != BINARY_NONE; node = t->nodes[node].parent) {
        binary_node *n = &t->nodes[node];
        const binary_node *a = &t->nodes[n->child[0]], *b = &t->nodes[n->child[1]];
        n->box = box4_union(a->box, b->box);
        n->count = a->count + b->count;
        set_height(t, n);
    }
}

static void replace_child(binary_tree *t, uint32_t parent, uint32_t old, uint32_t new) {
    binary_node *n = &t->nodes[parent];
    n->child[n->child[1] == old] = new;
    t->nodes[new].parent = parent;
}

/* Its parent, which is not the root, moves along and becomes that of both. */
static void move(binary_tree *t, uint32_t node, uint32_t target) {
    uint32_t parent = t->nodes[node].parent, grandparent = t->nodes[parent].parent,
             sibling = sibling_of(t, node);
    replace_child(t, grandparent, parent, sibling);
    replace_child(t, t->nodes[target].parent, target, parent);
    replace_child(t, parent, sibling, target);
    refit_above(t, grandparent);
    refit_above(t, parent);
}

/* What moving gives, as find_place has it, in the tree as it is now; -1 where it cannot be. */
static float gain_now(const optimiser *o, uint32_t node, uint32_t target) {
    const binary_node *nodes = o->tree->nodes;
    uint32_t parent = nodes[node].parent, path[PATH_MAX_LENGTH], length = 0;
    if (parent == 0 || target == parent || target == sibling_of(o->tree, node)) return -1;
    /* Up from the target: to the root, which does not lead through the node. */
    for (uint32_t n = target; n != BINARY_NONE; n = nodes[n].parent) {
        if (n == node) return -1;
        path[length++] = n;
    }
    uint32_t deeper =
        nodes[node].height > nodes[target].height ? nodes[node].height : nodes[target].height;
    if (length + deeper > BVH_DEPTH_MAX) return -1;
    uint32_t above[PATH_MAX_LENGTH], height = 0;
    for (uint32_t n = parent; n != BINARY_NONE; n = nodes[n].parent) above[height++] = n;
    while (length && height && path[length - 1] == above[height - 1]) length--, height--;
    /* What is left of both paths is below the pivot. */
    if (length == 0) return -1; /* the target is above: this would gain nothing */
    float won = area_of(o, nodes[parent].box);
    box4 box = nodes[node].box, rest = nodes[sibling_of(o->tree, node)].box;
    for (uint32_t i = 1; i < height; i++) {
        rest = box4_union(rest, nodes[sibling_of(o->tree, above[i - 1])].box);
        won += area_of(o, nodes[above[i]].box) - area_of(o, rest);
    }
    won -= area_of(o, box4_union(nodes[target].box, box));
    for (uint32_t i = 1; i < length; i++)
        won -= area_of(o, box4_union(nodes[path[i]].box, box)) - area_of(o, nodes[path[i]].box);
    return won;
}

static int by_area(const void *a, const void *b) {
    const sized *x = a, *y = b;
    if (x->area != y->area) return x->area > y->area ? -1 : 1;
    return x->node < y->node ? -1 : x->node > y->node;
}

/* The largest nodes, by the leading bits of their areas: about a share of all. */
static void choose_largest(optimiser *o) {
    enum { KEYS = 1 << 15, SHIFT = 16 };
    const binary_tree *t = o->tree;
    size_t wanted = t->count / MOVED_SHARE + 1, found = 0;
    uint32_t *counts = memory_zeroed(KEYS, sizeof *counts);
    o->chosen_count = 0;
    if (counts == NULL) return;
    for (size_t i = 0; i < t->count; i++) {
        float area = area_of(o, t->nodes[i].box);
        uint32_t bits;
        memcpy(&bits, &area, sizeof bits);
        counts[bits >> SHIFT & (KEYS - 1)]++;
    }
    uint32_t least = KEYS - 1;
    while (least > 0 && (found += counts[least]) < wanted) least--;
    free(counts);
    for (size_t i = 1; i < t->count && o->chosen_count < 2 * wanted; i++) {
        float area = area_of(o, t->nodes[i].box);
        uint32_t bits;
        memcpy(&bits, &area, sizeof bits);
        if (bits >> SHIFT < least || t->nodes[i].parent == 0) continue;
        o->chosen[o->chosen_count++] = (sized){area, (uint32_t)i};
    }
    qsort(o->chosen, o->chosen_count, sizeof *o->chosen, by_area);
}

static void search_some(void *data, size_t index, uint32_t worker) {
    (void)worker;
    const optimiser *o = data;
    size_t begin = index * SEARCH_SIZE, end = begin + SEARCH_SIZE;
    for (size_t i = begin; i < end && i < o->chosen_count; i++)
        o->targets[i] = find_place(o, o->chosen[i].node).node;
}

static void optimise(optimiser *o) {
    choose_largest(o);
    for (int round = 0; round < ROUNDS; round++) {
        run(o->splitter, (o->chosen_count + SEARCH_SIZE - 1) / SEARCH_SIZE, search_some, o);
        for (size_t i = 0; i < o->chosen_count; i++) {
            uint32_t node = o->chosen[i].node, target = o->targets[i];
            if (target != BINARY_NONE && gain_now(o, node, target) > 0) move(o->tree, node, target);
        }
    }
}

bool binary_build(const splitter *s, const build_range *r, binary_tree *out) {
    *out = (binary_tree){0};
    if (!grow(s, r, out)) return false;
    bounds3 whole = box4_bounds(r->box);
    float scale = 1 / vec3_largest(vec3_sub(whole.max, whole.min));
    if (!(scale > 0 && scale < INFINITY)) return true; /* nothing to tell by */
    size_t room = 2 * (out->count / MOVED_SHARE + 1);
    optimiser o = {.splitter = s,
                   .tree = out,
                   .scale = scale,
                   .chosen = memory_resize(NULL, room, sizeof *o.chosen),
                   .targets = memory_resize(NULL, room, sizeof *o.targets)};
    bool ok = o.chosen && o.targets;
    if (ok) optimise(&o);
    free(o.chosen);
    free(o.targets);
    return ok;
}
