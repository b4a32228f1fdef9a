/* A pool of worker threads that runs one parallel loop at a time.
 *
 *     caller ── thread_pool_run(pool, count, task) ──▶ workers 0..n-1 take indices 0..count-1 in
 *            ◀── returns when all are done ──────────┘ order (an atomic counter; the caller is
 *                                                      worker 0)
 *
 * Which worker gets which index is not promised, so a task may only write what belongs to its index
 * or worker. A pool may be used by several threads: their loops run one after the other. A task
 * must not start a loop on its own pool. Workers run with the floating-point environment of
 * floatenv_enter. */
#ifndef SNELL_BASE_THREAD_H
#define SNELL_BASE_THREAD_H

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

typedef struct thread_pool thread_pool;
typedef void thread_task(void *data, size_t index, uint32_t worker);

uint32_t thread_usable_cpus(void); /* affinity, then the cgroup's cpu.max rounded up; at least 1 */
snell_status thread_pool_create(uint32_t thread_count,
                                thread_pool **out); /* 0: thread_usable_cpus() */
void thread_pool_destroy(thread_pool *pool);
uint32_t thread_pool_size(const thread_pool *pool);
void thread_pool_run(thread_pool *pool, size_t count, thread_task *task, void *data);

double time_seconds(void);     /* monotonic */
double time_cpu_seconds(void); /* that this thread has used */

/* MXCSR as the pictures need it: round to nearest, no flush to zero, no denormals are zero,
 * exceptions masked. Set at every API entry that computes and in every worker; returns what was,
 * for floatenv_leave. */
unsigned floatenv_enter(void);
void floatenv_leave(unsigned saved);

#endif
