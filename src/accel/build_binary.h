/* A binary tree over a range of references, made better by reinsertion before nodes of eight are made
 * of it. */
#ifndef SNELL_ACCEL_BUILD_BINARY_H
#define SNELL_ACCEL_BUILD_BINARY_H

#include "accel/build_split.h"

#define BINARY_NONE UINT32_MAX

typedef struct binary_node {
    box4 box;
    uint32_t parent, child[2]; /* BINARY_NONE: the root; a leaf */
    uint32_t count;            /* references below */
    uint32_t height;           /* 0: a leaf */
    uint32_t begin, side;      /* of a leaf: where its references are, as in a build_range */
} binary_node;

/* nodes[0] is the root. */
typedef struct binary_tree {
    binary_node *nodes;
    size_t count, capacity;
} binary_tree;

/* Splits the range down to leaves, and reinserts what is better off elsewhere. At most BVH_DEPTH_MAX
 * deep. False: out of memory, or cancelled; to be freed all the same. */
bool binary_build(const splitter *s, const build_range *r, binary_tree *out);
/* The range of a node; of one that is no leaf only box and count mean something. */
build_range binary_range(const binary_tree *t, uint32_t node, uint32_t depth);
void binary_free(binary_tree *t);

#endif
