/* The tracing kernel, compiled once per instruction set (kernel_*.c define TRACE_KERNEL). The hit
 * rule is in accel.h; these files are the rule written out for eight boxes or eight triangles at a time.
 *
 *     boxes.inl      a ray made ready; the slab test; a step down a tree
 *     triangles.inl  eight triangles: the watertight test
 *     walk.inl       one ray through everything: instances, groups, parts, meshes that deform
 *     turns.inl      many rays in turn through a mesh */
#include <float.h>
#include <math.h>
#include <string.h>

#include "accel/kernels/kernel.h"
#include "simd/float8.h"

/* Under the sanitizers, whose checks multiply, the compiler would need minutes for one function. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define INLINE static inline
#else
#define INLINE static inline __attribute__((always_inline))
#endif

#include "accel/kernels/boxes.inl"
#include "accel/kernels/triangles.inl"
#include "accel/kernels/walk.inl"
#include "accel/kernels/turns.inl"

static void trace_rays(const accel *a, const ray *rays, hit *hits, size_t count,
                       trace_counters *counters) {
    batch b = {.a = a, .instance = a->world.instances, .rays = rays, .hits = hits, .count = count};
    if (is_one_mesh(a)) {
        trace_turns(&b);
    } else {
        query q = {0};
        for (size_t i = 0; i < count; i++) {
            start_query(&q, &rays[i]);
            trace_world(&q, a, &rays[i], false);
            hits[i] = found_hit(&q);
        }
        add_counters(&b.counters, &q.counters);
    }
    if (counters) add_counters(counters, &b.counters);
}

static void occlude_rays(const accel *a, const ray *rays, uint8_t *blocked, size_t count,
                         trace_counters *counters) {
    batch b = {
        .a = a, .instance = a->world.instances, .rays = rays, .blocked = blocked, .count = count};
    if (is_one_mesh(a)) {
        trace_turns(&b);
    } else {
        query q = {0};
        for (size_t i = 0; i < count; i++) {
            start_query(&q, &rays[i]);
            blocked[i] = trace_world(&q, a, &rays[i], true);
        }
        add_counters(&b.counters, &q.counters);
    }
    if (counters) add_counters(counters, &b.counters);
}

const trace_kernel TRACE_KERNEL = {trace_rays, occlude_rays};
