/* The acceleration structure: a BVH over instances of shapes and of groups of them, and the kernels
 * that trace it.
 *
 * Frozen after accel_build: any number of threads may trace. Same input, same picture: which hit
 * wins depends only on the hit rule, never on the tree's shape, the instruction set or the order of
 * visits:
 *   - accept a primitive if its own test says so and the ray passes its own box (and its instance's
 *     box, in the world or in its group, and those of the groups' instances around it) by the slab
 *     formula (b - o) * (1/d), where NaN (0 * infinity) counts as passing and the exit is widened by a
 *     few roundings, a triangle's own box by the error of place (layout.h says why);
 *     then t = max(t, entries of those boxes);
 *   - of a mesh, a ray that walks on (after_t) has not left the triangle's box, widened by the error of
 *     place, before after_t: what lies behind there is skipped, as nodes are;
 *   - nearest t wins; equal t goes to the lowest (instance, primitive);
 *   - a node is skipped only if its entry is beyond the best t.
 * A ray whose origin or direction is not finite, or whose direction is 0, hits nothing. */
#ifndef SNELL_ACCEL_ACCEL_H
#define SNELL_ACCEL_ACCEL_H

#include "base/thread.h"
#include "geometry/primitive.h"
#include "maths/motion.h"

typedef struct accel accel;

/* A ray goes down into groups in double, and is rounded to float for the boxes and shapes of each
 * level: dvec3 o, d; then o = to_local o for each instance on the way.
 *
 * Numbers of instances (hit.instance, ray.skip_instance ..) count shapes as if all groups were
 * flattened, depth first: a group's instance has as many as the group draws. */
struct accel_instance;

/* A shape, or a group of instances of geometries before it. */
typedef struct accel_geometry {
    const primitive_type *type;         /* NULL: a group */
    const void *desc;                   /* borrowed: must outlive the accel */
    const struct accel_instance *parts; /* of a group; copied */
    size_t part_count;
} accel_geometry;

typedef struct accel_instance {
    uint32_t geometry;
    uint32_t mask; /* a ray sees it if (ray.mask & mask) != 0 */
    bool identity; /* to_world is the identity: rays are not transformed; else local_ray_make */
    transform to_world, to_local; /* to_local as transform_inverse gives it */
    const motion
        *moves; /* by the ray's time, instead of to_world and to_local; borrowed; NULL: still */
} accel_instance;

typedef struct accel_input {
    const accel_geometry *geometries;
    size_t geometry_count;
    const accel_instance *instances; /* copied */
    size_t instance_count;
} accel_input;

/* How long the build takes and how well rays do. The same hits. */
typedef enum accel_quality {
    ACCEL_BALANCED,
    ACCEL_FAST,
    ACCEL_BEST,
    ACCEL_QUALITIES
} accel_quality;
extern const char *const accel_quality_names[ACCEL_QUALITIES];

typedef struct accel_options {
    accel_quality quality;
    uint32_t leaf_size; /* primitives in a leaf, at most; 0: chosen. Does not change a hit. */
    uint32_t seed;      /* != 0: children in a random order (tests of the hit rule) */
    /* Called now and then with a fraction in [0,1]; false stops the build with SNELL_CANCELLED. May
     * be NULL. */
    bool (*progress)(void *user, double fraction);
    void *user;
} accel_options;

snell_status accel_build(const accel_input *input, const accel_options *options, thread_pool *pool,
                         accel **out);
void accel_destroy(accel *a);
bounds3 accel_bounds(const accel *a); /* of the world, without unbounded shapes */

typedef struct accel_memory {
    uint64_t node_bytes, triangle_bytes, other_bytes, triangle_count;
} accel_memory;
accel_memory accel_get_memory(const accel *a);

/* boxes: eight to a node, also those of children that it lacks. Of rays that go through a mesh together, a
 * node counts once for all of them, a triangle for each. */
typedef struct trace_counters {
    uint64_t nodes, boxes, triangles, primitives;
} trace_counters;

/* The best instruction set that this CPU has (CPUID and XCR0), at most `max` (SNELL_ISA_AUTO: no
 * ceiling). */
snell_isa accel_best_isa(snell_isa max);
bool accel_has_isa(snell_isa isa); /* built in and usable here */

/* Closest hit of each ray. counters: may be NULL; added to. */
void accel_trace(const accel *a, snell_isa isa, const ray *rays, hit *hits, size_t count,
                 trace_counters *counters);
/* Is there any hit? blocked[i] = 1 or 0. */
void accel_occluded(const accel *a, snell_isa isa, const ray *rays, uint8_t *blocked, size_t count,
                    trace_counters *counters);

#endif
