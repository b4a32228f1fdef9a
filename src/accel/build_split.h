/* Ranges of references, and how the build splits them in two: SAH in bins. */
#ifndef SNELL_ACCEL_BUILD_SPLIT_H
#define SNELL_ACCEL_BUILD_SPLIT_H

#include "accel/build.h"
#include "simd/float4.h"

/* Lane 3 holds anything. */
typedef struct box4 {
    f4 low, high;
} box4;

typedef struct build_range {
    size_t begin, count;
    box4 box, centers; /* centers: of twice the references' midpoints */
    uint32_t depth;    /* of binary splits */
    uint32_t side;     /* in which of the splitter's arrays it is */
    uint32_t node;     /* of a binary tree, where there is one */
} build_range;

typedef struct split_chunk split_chunk;

/* A range lies in one of two arrays; splitting it writes the halves, each in the order it had, to the
 * same places of the other. */
typedef struct splitter {
    const build_job *job;
    build_reference *sides[2]; /* the first is the job's */
    thread_pool *pool;         /* may be NULL */
    size_t serial_size;        /* longer ranges are looked at in chunks, by all threads */
    split_chunk *chunks;
    f4 leaf_inverse; /* of the leaf size, and a little more */
} splitter;

/* Takes the job's references. False: out of memory; to be freed all the same. */
bool splitter_init(splitter *s, const build_job *job, thread_pool *pool, size_t serial_size);
void splitter_free(splitter *s); /* may be called twice */

build_range split_whole(const splitter *s); /* all references */
/* *spare: how many leaves there may be besides those that halving would give; SAH splits as it likes while
 * some are left, and gives back where it fills them better. */
void split_range(const splitter *s, const build_range *r, size_t *spare, build_range *left,
                 build_range *right);
/* Leaves are half full in the mean, or fuller, so that the memory of a tree is known beforehand. */
size_t split_leaves_at_most(uint32_t leaf_size, size_t count);
size_t split_spare(const splitter *s); /* of all references */
/* What a task with so many of them gets of what the ranges above tasks have left. */
static inline size_t split_share(const splitter *s, size_t spare, size_t count) {
    return (size_t)((double)spare * ((double)count / (double)s->job->count));
}

/* Lowbias32 by Chris Wellons: a hash of 32 bits. */
uint32_t split_scramble(uint32_t x);

static inline box4 box4_empty(void) { return (box4){f4_set(INFINITY), f4_set(-INFINITY)}; }
static inline box4 box4_union(box4 a, box4 b) {
    return (box4){f4_min(a.low, b.low), f4_max(a.high, b.high)};
}
static inline bounds3 box4_bounds(box4 box) {
    float low[4], high[4];
    f4_store(low, box.low);
    f4_store(high, box.high);
    return (bounds3){{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
}
static inline box4 box4_of(const build_reference *r) {
    return (box4){f4_load(&r->min.x), f4_load(&r->max.x)};
}

#endif
