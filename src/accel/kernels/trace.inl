/* The tracing kernel, compiled once per instruction set (kernel_*.c define TRACE_KERNEL). The hit
 * rule is in accel.h; these files are the rule written out for eight boxes or eight triangles at a time.
 *
 *     boxes.inl      a ray made ready; the slab test; a step down a tree
 *     triangles.inl  eight triangles: the watertight test
 *     walk.inl       one ray through everything: instances, groups, parts, meshes that deform
 *     tiles.inl      64 rays made ready side by side
 *     beams.inl      those of a tile that go the same way, together
 *     shared.inl     the way down that rays of a tile share
 *     spheres.inl    eight spheres and as many rays
 *     worlds.inl     beams in a world of many things
 *     turns.inl      the others in turn */
#include <float.h>
#include <math.h>
#include <string.h>

#include "accel/kernels/kernel.h"
#include "simd/double8.h"
#include "simd/float16.h"

/* Under the sanitizers, whose checks multiply, the compiler would need minutes for one function. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define INLINE static inline
#else
#define INLINE static inline __attribute__((always_inline))
#endif

#include "accel/kernels/boxes.inl"
#include "accel/kernels/triangles.inl"
#include "accel/kernels/walk.inl"

#include "accel/kernels/tiles.inl"
#include "accel/kernels/shared.inl"
#include "accel/kernels/beams.inl"

/* All rays of a call. */
typedef struct batch {
    const accel *a;
    const frozen_instance *instance;
    const ray *rays;
    hit *hits;        /* of `any`: NULL */
    uint8_t *blocked; /* else: NULL */
    size_t next, count;
    tile tile;           /* which ends at `next` .. */
    uint64_t left;       /* .. and its rays that are still to be traced */
    uint32_t beam_least; /* rays that a beam must have */
    shares *shared;      /* of one mesh: by that tile */
    beam *outside;       /* of a world of many things: that tile, and what it met that has no box */
    trace_counters counters;
} batch;

#include "accel/kernels/spheres.inl"
#include "accel/kernels/worlds.inl"
#include "accel/kernels/turns.inl"

/* Nothing but a mesh that stands as it was given. */
INLINE bool is_one_mesh(const accel *a) {
    const frozen_level *world = &a->world;
    return world->instance_count == 1 && world->instances[0].mesh != NULL &&
           world->instances[0].identity;
}

/* So few rays that making turns ready takes longer than they save. */
enum { FEW = 8 };

static __attribute__((noinline)) void trace_one_by_one(batch *b) {
    query q = {0};
    for (size_t i = 0; i < b->count; i++) {
        start_query(&q, &b->rays[i]);
        if (b->hits) {
            trace_world(&q, b->a, &b->rays[i], false);
            b->hits[i] = found_hit(&q);
        } else
            b->blocked[i] = trace_world(&q, b->a, &b->rays[i], true);
    }
    add_counters(&b->counters, &q.counters);
}

static void trace_batch(batch *b) {
    if (b->count < FEW)
        trace_one_by_one(b);
    else if (b->a->world.small)
        trace_small(b);
    else if (is_one_mesh(b->a))
        trace_turns(b);
    else
        trace_many(b);
}

static void trace_rays(const accel *a, const ray *rays, hit *hits, size_t count,
                       trace_counters *counters) {
    batch b = {.a = a, .instance = a->world.instances, .rays = rays, .hits = hits, .count = count};
    trace_batch(&b);
    if (counters) add_counters(counters, &b.counters);
}

static void occlude_rays(const accel *a, const ray *rays, uint8_t *blocked, size_t count,
                         trace_counters *counters) {
    batch b = {
        .a = a, .instance = a->world.instances, .rays = rays, .blocked = blocked, .count = count};
    trace_batch(&b);
    if (counters) add_counters(counters, &b.counters);
}

const trace_kernel TRACE_KERNEL = {trace_rays, occlude_rays};
