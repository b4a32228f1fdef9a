/* What the benchmarks share: CPU time, medians with their spread, numbers of the command line. */
#ifndef SNELL_BENCH_MEASURE_H
#define SNELL_BENCH_MEASURE_H

#include <errno.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { ROUNDS_MAX = 101 };

/* CPU time of this thread: other programs on the machine disturb it less than the clock. */
static inline double cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

typedef struct summary {
    double median, low, high;
} summary;

static inline int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* count: 1 to ROUNDS_MAX */
static inline summary summarise(const double *values, uint32_t count) {
    double sorted[ROUNDS_MAX];
    memcpy(sorted, values, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare_doubles);
    return (summary){sorted[count / 2], sorted[0], sorted[count - 1]};
}

/* false: no whole number from low to high. text: may be NULL. */
static inline bool read_number(const char *text, uint64_t low, uint64_t high, uint64_t *out) {
    char *end = NULL;
    if (text == NULL || *text < '0' || *text > '9') return false;
    errno = 0;
    *out = strtoull(text, &end, 10);
    return *end == '\0' && errno == 0 && *out >= low && *out <= high;
}

#endif
