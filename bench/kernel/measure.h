/* What the kernel benchmark measures of one scene: every kind of ray, on every number of threads,
 * by every tracer. */
#ifndef SNELL_BENCH_KERNEL_MEASURE_H
#define SNELL_BENCH_KERNEL_MEASURE_H

#include "../measure.h"
#include "cycles.h"
#include "embree.h"
#include "rays.h"

enum { SCALAR, AVX2, AVX512, SINGLE, PACKET, TRACERS }; /* snell's instruction sets; Embree's two */
extern const char *const tracer_names[TRACERS];
extern const snell_isa tracer_isas[SINGLE];

enum { THREAD_COUNTS_MAX = 8 };

typedef struct settings {
    uint32_t size, rounds, builds, leaf_size, batch;
    double detail;
    uint32_t threads[THREAD_COUNTS_MAX], threads_count;
    accel_quality own_quality;
    peer_quality quality;
    bool wanted[TRACERS];
    uint32_t own; /* snell's tracer that is held against Embree */
    bool json, embree, deforming;
    const char *picture; /* NULL: none */
} settings;

/* How a tracer's hits differ from snell's. Ulps: steps between floats. */
typedef struct agreement {
    size_t hit_or_miss; /* rays that hit by one and miss by the other */
    size_t both;        /* rays that hit by both; of these: */
    uint32_t ulp_max;   /* the greatest difference in t */
    size_t over_4_ulp;  /* with more than 4 */
    /* Of the rays counted in hit_or_miss and over_4_ulp, with whom double arithmetic sides: does the
     * ray meet the triangle that only one has hit, or whose t is nearer to the triangle's plane? Not
     * of spheres, nor where any hit will do. */
    size_t own_right, other_right;
    size_t bits; /* rays with any other bit: between snell's own */
} agreement;

/* One kind of ray on one number of threads. */
typedef struct cell {
    uint32_t kind, threads;
    size_t rays, spoiled;
    trace_counters counters;
    double mrays[TRACERS][ROUNDS_MAX]; /* of CPU time with one thread, by the clock with more */
    double cycles[ROUNDS_MAX];         /* of snell's, for a ray */
    agreement agree[TRACERS];
    double
        spoiled_time[ROUNDS_MAX]; /* with one thread: time of the spoiled rays over that of these */
    size_t spoiled_wrong; /* hits of spoiled rays, and others that hit otherwise beside them */
} cell;

typedef struct scene_results {
    const char *name;
    size_t triangles, spheres;
    double build[ROUNDS_MAX], peer_build[ROUNDS_MAX]; /* seconds */
    accel_memory memory;
    size_t peer_bytes;
    double ao_length;
    cell *cells; /* by kind, then by number of threads */
    uint32_t cell_count;
} scene_results;

/* p: NULL without Embree. */
void measure_scene(subject *s, peer *p, const settings *t, scene_results *out);

/* Embree's tracer with the higher median rate in this cell; TRACERS: none was measured. */
uint32_t cell_peer(const cell *c, const settings *t);
/* snell's rate over that of tracer i, in the same round. */
summary cell_ratio(const cell *c, const settings *t, uint32_t tracer);

#endif
