/* Building one level: references to boxes in, wide nodes out. */
#ifndef SNELL_ACCEL_BUILD_H
#define SNELL_ACCEL_BUILD_H

#include <stdatomic.h>

#include "accel/layout.h"

/* Triangles in a leaf of a mesh, unless options say otherwise; and shapes of fewer parts or triangles are
 * built several at a time, each by one thread. */
enum { BUILD_LEAF_SIZE = 8, BUILD_SMALL = 16384 };

typedef struct build_reference {
    vec3 min;
    uint32_t id; /* triangle, part, or instance */
    vec3 max;
    uint32_t unused;
} build_reference;

/* A triangle of a mesh that deforms at moments of its way: the first key, the middle, the last. */
enum { BUILD_MOMENTS = 3 };
typedef struct build_way {
    float sides[BUILD_MOMENTS]
               [6]; /* of its box: -minimum, maximum; so that boxes join by the largest */
} build_way;

/* Shared by all levels of one accel_build; workers add to `done`, the caller's thread reports. */
typedef struct build_progress {
    const accel_options *options;
    uint64_t total;
    atomic_uint_least64_t done;
    atomic_bool stop;
} build_progress;

typedef struct build_job {
    build_reference *references; /* build_tree frees them, as soon as it can */
    size_t count;                /* at least 1 */
    const mesh_desc *mesh;       /* whose triangles; NULL: instances, or parts */
    const build_way *ways; /* by id: split so that boxes are small all the way; NULL: by the boxes
                                    of the references */
    uint32_t leaf_size;    /* 1 but for triangles */
    uint32_t seed;
    accel_quality quality;
    build_progress *progress;
} build_job;

/* Bytes that a tree takes at most (with the leaf size of meshes, or 1): which stay, and besides while it
 * is built, with its references. */
typedef struct build_bytes {
    uint64_t stays, building;
} build_bytes;
build_bytes build_plan(bool of_mesh, uint32_t leaf_size, uint64_t count);

/* Room for so many; as all references, to be freed with memory_free_aligned. NULL: out of memory. */
build_reference *build_references(size_t count);
/* The triangles of a mesh, or the parts of another shape that are not empty; NULL without memory.
 * *bounds is their box. The pool may be NULL. */
build_reference *build_mesh_references(const mesh_desc *mesh, thread_pool *pool, size_t *count,
                                       bounds3 *bounds);
/* Of a mesh that deforms: the mean of each triangle's way; *bounds holds the mesh at all keys. The ways
 * are to be freed too. */
build_reference *build_deforming_references(const deforming_mesh *m, size_t *count, bounds3 *bounds,
                                            build_way **ways);
build_reference *build_part_references(const primitive_type *type, const void *desc, size_t *count,
                                       bounds3 *bounds);

/* The tree does not depend on the pool, which may be NULL (then the calling thread does it all and
 * reports only if `reports`). SNELL_OK, SNELL_CANCELLED or SNELL_ERR_MEMORY; no message is set. On
 * failure *out is zero. */
snell_status build_tree(const build_job *job, thread_pool *pool, bool reports, bvh_tree *out);
/* A tree that was built from those mean boxes becomes one for each key, with the boxes and vertices of
 * that key. False: out of memory. */
bool build_tree_at_keys(const deforming_mesh *m, thread_pool *pool, bvh_tree *tree);
/* Widens the boxes in all nodes of a mesh's tree, of `keys` keys, and sets its margin (layout.h). */
void build_widen(bvh_tree *tree, uint32_t keys, thread_pool *pool);
void build_tree_free(bvh_tree *tree);

/* False: stop. */
bool build_progress_report(build_progress *progress);

#endif
