/* Processor cycles of this process's threads: counted by the system (perf) where that is allowed,
 * else from their CPU time and the rate of the time stamp counter, which is not the processor's own
 * where that varies. */
#ifndef SNELL_BENCH_KERNEL_CYCLES_H
#define SNELL_BENCH_KERNEL_CYCLES_H

void cycles_open(void);          /* before threads are started */
double cycles_now(void);         /* 0 where there is neither */
const char *cycles_source(void); /* "perf", "tsc" or "none" */

#endif
