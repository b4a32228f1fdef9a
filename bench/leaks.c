/* Very many rays from inside closed meshes, none of which may get out.
 *
 *     bench-leaks [--rays N] [--threads N] [--seed N] [--isa NAME] [--place N] [MESH]
 *
 * N rays (100,000,000) of each kind at each mesh, shared out evenly among the places where the mesh
 * stands; meshes, places and kinds are those of tests/leaks.h. --place 1 to 5 traces that place's share
 * alone. Which rays are traced depends on N, the seed, the meshes and the places alone. Exit code 1 if any leaks. */
#include <stdio.h>
#include <unistd.h>

#include "../tests/leaks.h"
#include "measure.h"

enum { CHUNK = 50000, STEP = 64 }; /* rays of a task; tasks until the next sign of progress */

typedef struct settings {
    uint64_t rays, seed;
    uint32_t threads, place; /* place: 1 to LEAK_PLACES; 0: all */
    snell_isa isa;
    const char *mesh;
} settings;

typedef struct progress {
    double start, said;
    uint64_t done, all;
} progress;

typedef struct job {
    const leak_case *c;
    const settings *settings;
    leak_aim aim;
    uint64_t rays, number; /* of this step; the number of its first task, apart from all others */
    size_t leaks[STEP];
    ray examples[STEP];
} job;

static void die(const char *what) {
    fprintf(stderr, "bench-leaks: %s\n", what);
    exit(2);
}

static void show(progress *p) {
    double now = time_seconds(), spent = now - p->start;
    bool terminal = isatty(STDERR_FILENO);
    if (now - p->said < (terminal ? 0.5 : 60)) return;
    p->said = now;
    double minutes = spent * (double)(p->all - p->done) / (double)p->done / 60;
    fprintf(stderr, "%s%5.1f %%, %.2f million rays/s, %.1f minutes left%s", terminal ? "\r" : "",
            100.0 * (double)p->done / (double)p->all, (double)p->done * 1e-6 / spent, minutes,
            terminal ? "   \r" : "\n");
}

static void trace_chunk(void *data, size_t index, uint32_t worker) {
    (void)worker;
    job *j = data;
    uint64_t first = (uint64_t)index * CHUNK;
    size_t count = j->rays - first < CHUNK ? (size_t)(j->rays - first) : CHUNK;
    rng seeds = {j->settings->seed * 0xd1342543de82ef95u + j->number + index};
    j->leaks[index] =
        leak_count(j->c, j->settings->isa, j->aim, rng_bits(&seeds), count, &j->examples[index]);
}

static void print_example(const job *j, size_t index) {
    const ray *r = &j->examples[index];
    printf("    leaks at %s: from {%a, %a, %a} along {%a, %a, %a}\n", leak_aim_names[j->aim],
           (double)r->o.x, (double)r->o.y, (double)r->o.z, (double)r->d.x, (double)r->d.y,
           (double)r->d.z);
}

/* The leaks of `rays` rays; of each step that has some, one ray is printed. */
static uint64_t run(job *j, uint64_t rays, thread_pool *pool, progress *p) {
    uint64_t leaks = 0;
    for (uint64_t done = 0; done < rays; done += j->rays) {
        uint64_t most = (uint64_t)STEP * CHUNK;
        j->rays = rays - done < most ? rays - done : most;
        size_t tasks = (size_t)((j->rays + CHUNK - 1) / CHUNK), example = STEP;
        thread_pool_run(pool, tasks, trace_chunk, j);
        for (size_t i = 0; i < tasks; i++) {
            leaks += j->leaks[i];
            if (j->leaks[i]) example = i;
        }
        if (example < STEP) print_example(j, example);
        j->number += tasks;
        p->done += j->rays;
        show(p);
    }
    return leaks;
}

static uint64_t run_case(job *j, const leak_case *c, thread_pool *pool, progress *p) {
    uint64_t share = (j->settings->rays + LEAK_PLACES - 1) / LEAK_PLACES, sum = 0;
    uint64_t leaks[LEAK_AIMS];
    double start = time_seconds();
    j->c = c;
    for (leak_aim at = 0; at < LEAK_AIMS; at++) {
        j->aim = at;
        leaks[at] = run(j, share, pool, p);
        sum += leaks[at];
    }
    printf("%-8s %-20s %14llu", c->type->name, leak_place_names[c->place],
           (unsigned long long)share);
    for (leak_aim at = 0; at < LEAK_AIMS; at++) printf(" %11llu", (unsigned long long)leaks[at]);
    printf(" %12.2f\n", (double)share * LEAK_AIMS * 1e-6 / (time_seconds() - start));
    fflush(stdout);
    return sum;
}

static bool is_wanted(const settings *s, size_t i, leak_place place) {
    return (s->mesh == NULL || strcmp(s->mesh, leak_mesh_types[i].name) == 0) &&
           (s->place == 0 || s->place == (uint32_t)place + 1);
}

static uint64_t run_all(const settings *s, thread_pool *pool) {
    uint64_t share = (s->rays + LEAK_PLACES - 1) / LEAK_PLACES, leaks = 0;
    progress p = {.start = time_seconds(), .said = time_seconds()};
    for (size_t i = 0; i < LEAK_MESHES; i++)
        for (leak_place place = 0; place < LEAK_PLACES; place++)
            if (is_wanted(s, i, place)) p.all += share * LEAK_AIMS;
    if (p.all == 0) die("no such mesh: globe, rock, needle or knot");
    printf("%u threads, %s; leaks of rays at:\n", thread_pool_size(pool),
           snell_isa_name(accel_best_isa(s->isa)));
    printf("%-8s %-20s %14s %11s %11s %11s %11s %12s\n", "mesh", "place", "rays each", "points",
           "edge middle", "edges", "vertices", "Mrays/s");
    job j = {.settings = s};
    for (size_t i = 0; i < LEAK_MESHES; i++)
        for (leak_place place = 0; place < LEAK_PLACES; place++) {
            leak_case c;
            if (!is_wanted(s, i, place)) continue;
            if (!leak_case_make(&c, &leak_mesh_types[i], place, pool)) die("out of memory");
            leaks += run_case(&j, &c, pool, &p);
            leak_case_clear(&c);
        }
    printf("%llu rays, %llu leaks, %.1f minutes\n", (unsigned long long)p.done,
           (unsigned long long)leaks, (time_seconds() - p.start) / 60);
    return leaks;
}

static uint64_t number(const char *text, uint64_t low, uint64_t high) {
    uint64_t value;
    if (!read_number(text, low, high, &value)) die("a number is missing or wrong");
    return value;
}

static snell_isa isa_of(const char *text) {
    for (int i = SNELL_ISA_AUTO; text && i <= SNELL_ISA_AVX512; i++) {
        if (strcmp(text, snell_isa_name((snell_isa)i)) != 0) continue;
        if (i != SNELL_ISA_AUTO && !accel_has_isa((snell_isa)i))
            die("this machine has no such ISA");
        return (snell_isa)i;
    }
    die("--isa takes auto, scalar, avx2 or avx512");
    return SNELL_ISA_AUTO;
}

static const char usage[] = "usage: bench-leaks [--rays N] [--threads N] [--seed N] [--isa NAME] "
                            "[--place 1..5] [globe|rock|needle|knot]";

int main(int argc, char **argv) {
    settings s = {.rays = 100000000};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--rays") == 0)
            s.rays = number(argv[++i], 1, UINT64_C(1) << 50);
        else if (strcmp(argv[i], "--threads") == 0)
            s.threads = (uint32_t)number(argv[++i], 0, 4096);
        else if (strcmp(argv[i], "--seed") == 0)
            s.seed = number(argv[++i], 0, UINT64_MAX);
        else if (strcmp(argv[i], "--place") == 0)
            s.place = (uint32_t)number(argv[++i], 1, LEAK_PLACES);
        else if (strcmp(argv[i], "--isa") == 0)
            s.isa = isa_of(argv[++i]);
        else if (strcmp(argv[i], "--help") == 0) {
            printf("%s\n", usage);
            return 0;
        } else if (argv[i][0] != '-' && s.mesh == NULL)
            s.mesh = argv[i];
        else
            die(usage);
    }
    thread_pool *pool;
    if (thread_pool_create(s.threads, &pool)) die(error_last()->text);
    uint64_t leaks = run_all(&s, pool);
    thread_pool_destroy(pool);
    return leaks > 0;
}
