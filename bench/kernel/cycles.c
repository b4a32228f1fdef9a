#include "cycles.h"

#include <linux/perf_event.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
#if defined(__x86_64__)
#include <x86intrin.h>
#endif

static int counter = -1;
static double tsc_rate; /* ticks a second; 0: there is none */

static double seconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void measure_tsc(void) {
#if defined(__x86_64__)
    double start = seconds(CLOCK_MONOTONIC), end;
    uint64_t first = __rdtsc();
    do end = seconds(CLOCK_MONOTONIC);
    while (end - start < 0.05);
    tsc_rate = (double)(__rdtsc() - first) / (end - start);
#endif
}

void cycles_open(void) {
    struct perf_event_attr what = {.type = PERF_TYPE_HARDWARE,
                                   .size = sizeof what,
                                   .config = PERF_COUNT_HW_CPU_CYCLES,
                                   .inherit = 1,
                                   .exclude_kernel = 1,
                                   .exclude_hv = 1};
    counter = (int)syscall(SYS_perf_event_open, &what, 0, -1, -1, 0);
    if (counter < 0) measure_tsc();
}

double cycles_now(void) {
    uint64_t count;
    if (counter >= 0)
        return read(counter, &count, sizeof count) == sizeof count ? (double)count : 0;
    return seconds(CLOCK_PROCESS_CPUTIME_ID) * tsc_rate;
}

const char *cycles_source(void) { return counter >= 0 ? "perf" : tsc_rate > 0 ? "tsc" : "none"; }
