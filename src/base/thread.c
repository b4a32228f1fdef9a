#include "base/thread.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

struct thread_pool {
    uint32_t size; /* workers, the caller included */
    pthread_t *threads;
    pthread_mutex_t caller; /* held by the thread whose loop runs */
    pthread_mutex_t lock;   /* guards what follows, but `next` */
    pthread_cond_t start, finished;
    uint64_t generation; /* counts loops; a worker runs each once */
    uint32_t busy;
    bool stopping;
    size_t count;
    thread_task *task;
    void *data;
    atomic_size_t next;
};

typedef struct worker_start {
    thread_pool *pool;
    uint32_t index;
} worker_start;

static void work(thread_pool *pool, uint32_t worker) {
    size_t count = pool->count;
    for (;;) {
        size_t index = atomic_fetch_add_explicit(&pool->next, 1, memory_order_relaxed);
        if (index >= count) return;
        pool->task(pool->data, index, worker);
    }
}

static void *worker_main(void *argument) {
    worker_start start = *(worker_start *)argument;
    free(argument);
    thread_pool *pool = start.pool;
    floatenv_enter();
    uint64_t seen = 0;
    pthread_mutex_lock(&pool->lock);
    for (;;) {
        while (!pool->stopping && pool->generation == seen)
            pthread_cond_wait(&pool->start, &pool->lock);
        if (pool->stopping) break;
        seen = pool->generation;
        pthread_mutex_unlock(&pool->lock);
        work(pool, start.index);
        pthread_mutex_lock(&pool->lock);
        if (--pool->busy == 0) pthread_cond_signal(&pool->finished);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

snell_status thread_pool_create(uint32_t thread_count, thread_pool **out) {
    if (thread_count == 0) thread_count = thread_usable_cpus();
    thread_pool *pool = calloc(1, sizeof *pool);
    if (pool == NULL) return error_no_memory();
    pool->threads = calloc(thread_count, sizeof *pool->threads);
    if (pool->threads == NULL) {
        free(pool);
        return error_no_memory();
    }
    pthread_mutex_init(&pool->caller, NULL);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->start, NULL);
    pthread_cond_init(&pool->finished, NULL);
    pool->size = 1;
    for (uint32_t i = 1; i < thread_count; i++) {
        worker_start *start = malloc(sizeof *start);
        if (start) *start = (worker_start){pool, i};
        if (start == NULL || pthread_create(&pool->threads[i], NULL, worker_main, start) != 0) {
            free(start);
            thread_pool_destroy(pool);
            return error_set(SNELL_ERR_MEMORY, "ask for fewer threads",
                             "cannot start thread %u of %u", i + 1, thread_count);
        }
        pool->size = i + 1;
    }
    *out = pool;
    return SNELL_OK;
}

void thread_pool_destroy(thread_pool *pool) {
    if (pool == NULL) return;
    pthread_mutex_lock(&pool->lock);
    pool->stopping = true;
    pthread_cond_broadcast(&pool->start);
    pthread_mutex_unlock(&pool->lock);
    for (uint32_t i = 1; i < pool->size; i++) pthread_join(pool->threads[i], NULL);
    pthread_cond_destroy(&pool->start);
    pthread_cond_destroy(&pool->finished);
    pthread_mutex_destroy(&pool->lock);
    pthread_mutex_destroy(&pool->caller);
    free(pool->threads);
    free(pool);
}

uint32_t thread_pool_size(const thread_pool *pool) { return pool->size; }

void thread_pool_run(thread_pool *pool, size_t count, thread_task *task, void *data) {
    pthread_mutex_lock(&pool->caller);
    pthread_mutex_lock(&pool->lock);
    pool->count = count;
    pool->task = task;
    pool->data = data;
    atomic_store_explicit(&pool->next, 0, memory_order_relaxed);
    pool->busy = pool->size - 1;
    pool->generation++;
    pthread_cond_broadcast(&pool->start);
    pthread_mutex_unlock(&pool->lock);
    work(pool, 0);
    pthread_mutex_lock(&pool->lock);
    while (pool->busy > 0) pthread_cond_wait(&pool->finished, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
    pthread_mutex_unlock(&pool->caller);
}

/* cgroup v2: "max 100000" or "200000 100000" (quota and period in microseconds). */
static uint32_t cgroup_cpus(void) {
    char path[512] = "/sys/fs/cgroup/cpu.max", line[256];
    FILE *file = fopen("/proc/self/cgroup", "r");
    if (file != NULL) {
        while (fgets(line, sizeof line, file) != NULL) {
            if (strncmp(line, "0::", 3) != 0) continue;
            line[strcspn(line, "\n")] = '\0';
            snprintf(path, sizeof path, "/sys/fs/cgroup%s/cpu.max", line + 3);
        }
        fclose(file);
    }
    file = fopen(path, "r");
    if (file == NULL) file = fopen("/sys/fs/cgroup/cpu.max", "r");
    if (file == NULL) return UINT32_MAX;
    double quota = 0, period = 0;
    int read = fscanf(file, "%lf %lf", &quota, &period); /* "max" is no number: no limit */
    fclose(file);
    if (read != 2 || quota <= 0 || period <= 0) return UINT32_MAX;
    double cpus = quota / period;
    uint32_t whole = (uint32_t)cpus;
    return whole < cpus ? whole + 1 : whole;
}

uint32_t thread_usable_cpus(void) {
    cpu_set_t set;
    uint32_t count = 1;
    if (sched_getaffinity(0, sizeof set, &set) == 0) count = (uint32_t)CPU_COUNT(&set);
    uint32_t limit = cgroup_cpus();
    if (limit < count) count = limit;
    return count ? count : 1;
}

static double clock_seconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double time_seconds(void) { return clock_seconds(CLOCK_MONOTONIC); }
double time_cpu_seconds(void) { return clock_seconds(CLOCK_THREAD_CPUTIME_ID); }

unsigned floatenv_enter(void) {
#if defined(__x86_64__)
    unsigned saved = _mm_getcsr();
    _mm_setcsr(0x1f80); /* all exceptions masked, round to nearest, FTZ and DAZ off */
    return saved;
#else
    return 0;
#endif
}

void floatenv_leave(unsigned saved) {
#if defined(__x86_64__)
    _mm_setcsr(saved);
#else
    (void)saved;
#endif
}
