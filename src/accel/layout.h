/* What a built acceleration structure looks like in memory: read by the kernels, written by the
 * build.
 *
 *     the world: nodes over instances ──▶ instance ──▶ analytic shape: its `intersect`
 *                                            ├───────▶ mesh: nodes over triangles ──▶ blocks of 8
 *                                            ├───────▶ parts: nodes over them ──▶ `intersect` of each
 *                                            ├───────▶ mesh that deforms: as a mesh, once for each key
 *                                            └───────▶ group: again nodes over instances
 *
 * All have the same nodes. A reference to a child is a node's index, or has BVH_LEAF set: then it is
 * an instance's or a part's index (always one, so that the child's box is its box) or a block's index
 * and its number of triangles less one. */
#ifndef SNELL_ACCEL_LAYOUT_H
#define SNELL_ACCEL_LAYOUT_H

#include "accel/accel.h"
#include "geometry/deforming.h"

enum {
    BVH_WIDTH = 8,
    /* Levels of wide nodes. The build splits by SAH down to BVH_SAH_DEPTH and halves from there. */
    BVH_DEPTH_MAX = 80,
    BVH_SAH_DEPTH = 44,
    /* Each level leaves at most seven children behind; eight are written before one is taken. */
    BVH_STACK_SIZE = BVH_DEPTH_MAX * (BVH_WIDTH - 1) + BVH_WIDTH
};
#define BVH_LEAF 0x80000000u
#define BVH_COUNT_SHIFT 28
#define BVH_INDEX_MASK 0x0fffffffu /* of a block; no tree may have more nodes or blocks */

typedef struct bvh_node {
    float bounds[2][3][BVH_WIDTH]; /* minimum and maximum, axis, child */
    uint32_t child[BVH_WIDTH];
    uint32_t valid; /* a bit per child; the others have bounds that no ray passes */
    uint32_t unused[7];
} bvh_node;
_Static_assert(sizeof(bvh_node) == 256, "a node is four cache lines");

typedef struct triangle_block {
    float vertex[3][3][BVH_WIDTH]; /* vertex, axis, triangle; unused triangles repeat the last */
    uint32_t primitive[BVH_WIDTH];
} triangle_block;
_Static_assert(sizeof(triangle_block) == 320, "a block is five cache lines");

/* The slab test's exit is multiplied by this: 1 + 2^-18. A monotone change, so nodes still enclose
 * what their children accept. Without it the box of a triangle on a grid may refuse, by its own
 * rounding, the very hit at a shared edge that the watertight test gave to this triangle alone: a
 * leak. Three roundings in each plane's t are relative to t (Ize, Robust BVH Ray Traversal, JCGT 2(2),
 * 2013). */
#define BOX_EXIT_SCALE (1.0f + 0x1p-18f)

/* In meshes each box is also wider by an error of place: a sheared vertex is off by at most six units
 * in the last place (2^-24) of the largest coordinate of any vertex as seen from the origin, however
 * near the hit is. 16 cover it; and 2 of the origin's own coordinate, which the margin is added to and
 * rounded. That is a constant of a ray and a mesh, so it is monotone too. */
#define BOX_REACH_MARGIN 0x1p-20f
#define BOX_PLACE_MARGIN 0x1p-23f
/* The nodes of a mesh are built wider by the margin of rays from as far as this many extents off
 * (bvh_tree.margin), which then cost nothing; for those from farther off it is added as they go. */
#define BOX_REACH_BUILT 8

/* Of a mesh that deforms: one tree in shape, whose nodes and blocks stand in memory for the first key,
 * then for the second, and so on; counts and references are those of one key. */
typedef struct bvh_tree {
    bvh_node *nodes;        /* aligned to 64 */
    triangle_block *blocks; /* aligned to 64; NULL but in a mesh */
    size_t node_count, block_count;
    uint32_t root; /* in a mesh it may be a leaf; elsewhere it is a node */
    bounds3 bounds;
    float margin; /* of a mesh: by which the boxes in its nodes are wider than what they hold */
} bvh_tree;

struct frozen_level;

typedef struct frozen_instance {
    const primitive_type *type; /* NULL: a group */
    const void *desc;
    const bvh_tree *mesh,
        *parts; /* NULL, both: a shape of one part, which tests itself; or a group. parts: also of a
                   mesh that deforms */
    const struct frozen_level *group; /* NULL: a shape */
    uint32_t mask;
    uint32_t first; /* number of the first shape in here, counted in its level */
    bool identity, flat;
    /* One part, in the space of its level: nothing stands between a ray and `intersect`. */
    bool plain;
    bounds3 bounds;      /* the shape's, in its own space */
    const motion *moves; /* NULL: to_local holds at all times */
    transform to_local;
} frozen_instance;

/* What rays ask of each instance first; all that they need of a sphere in the space of its level. */
typedef struct frozen_outline {
    float center[3], radius;
    uint32_t sphere_mask; /* as `mask` of the instance; 0: it is no such sphere */
    uint32_t first;
    uint32_t unused[2];
} frozen_outline;

/* Instances under one tree: the world, or a group. */
typedef struct frozen_level {
    frozen_instance *instances;
    frozen_outline *outlines; /* of each instance; aligned to 64 */
    size_t instance_count;
    uint32_t *unbounded; /* instances without a box, ascending */
    size_t unbounded_count;
    bvh_tree top;   /* node_count 0: no bounded instance */
    bool small;     /* at most one node, and no mesh under it */
    bounds3 bounds; /* of all that has a box, also of what stands beside the boundless in a group */
} frozen_level;

typedef struct frozen_geometry {
    const primitive_type *type; /* NULL: a group */
    const void *desc;
    bounds3 bounds;
    bvh_tree tree; /* of a mesh, also one that deforms, or over parts */
    frozen_level level;
    uint64_t shape_count; /* how many shapes it draws: 1, or those of a group and of its groups */
    uint32_t depth;       /* of groups in groups: 0 for a shape */
    bool used;
} frozen_geometry;

struct accel {
    frozen_geometry *geometries;
    size_t geometry_count;
    frozen_level world;
};

#endif
