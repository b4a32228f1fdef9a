/* CPU time of this thread, for tests of what must not be done over and over: other programs on the
 * machine do not disturb it. */
#ifndef SNELL_TESTS_CPU_TIME_H
#define SNELL_TESTS_CPU_TIME_H

#include <time.h>

static inline double cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#endif
