#include "measure.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "parts.h"

const char *const tracer_names[TRACERS] = {"scalar", "avx2", "avx512", "embree-single",
                                           "embree-packet16"};
const snell_isa tracer_isas[SINGLE] = {SNELL_ISA_SCALAR, SNELL_ISA_AVX2, SNELL_ISA_AVX512};

/* Of one ray each; which of the two depends on the kind. */
typedef struct outcomes {
    hit *hits;
    uint8_t *blocked;
} outcomes;

static outcomes allocate(size_t count) {
    return (outcomes){bench_need(memory_zeroed(count, sizeof(hit))),
                      bench_need(memory_zeroed(count, 1))};
}

static void release(outcomes *o) {
    free(o->hits);
    free(o->blocked);
}

/* ---- tracing ---- */

typedef struct bench {
    const subject *subject;
    const peer *peer;
    const settings *settings;
    thread_pool *pools[THREAD_COUNTS_MAX]; /* NULL: one thread, the caller's */
    outcomes reference, now;               /* snell's, and of the tracer that is measured */
} bench;

typedef struct job {
    const bench *bench;
    uint32_t tracer, kind;
    const ray_set *set;
    const outcomes *out;
    trace_counters *counters;
} job;

static void trace_batch(void *data, size_t index, uint32_t worker) {
    (void)worker;
    const job *j = data;
    size_t first = index * j->bench->settings->batch, count = j->set->count - first;
    if (count > j->bench->settings->batch) count = j->bench->settings->batch;
    const ray *rays = j->set->rays + first;
    hit *hits = j->out->hits + first;
    uint8_t *blocked = j->out->blocked + first;
    const accel *a = j->bench->subject->accel;
    bool any = ray_kind_any(j->kind);
    if (j->tracer < SINGLE && any)
        accel_occluded(a, tracer_isas[j->tracer], rays, blocked, count, j->counters);
    else if (j->tracer < SINGLE)
        accel_trace(a, tracer_isas[j->tracer], rays, hits, count, j->counters);
#if BENCH_HAS_EMBREE
    else
        peer_trace(j->bench->peer, (peer_mode){j->tracer == PACKET, ray_kind_coherent(j->kind)},
                   rays, count, any ? NULL : hits, any ? blocked : NULL);
#endif
}

/* Seconds: of the thread's CPU time without a pool, else by the clock. */
static double trace(const job *j, thread_pool *pool) {
    job copy = *j;
    size_t batch = j->bench->settings->batch, batches = (j->set->count + batch - 1) / batch;
    if (pool) {
        double start = time_seconds();
        thread_pool_run(pool, batches, trace_batch, &copy);
        return time_seconds() - start;
    }
    double start = cpu_seconds();
    for (size_t i = 0; i < batches; i++) trace_batch(&copy, i, 0);
    return cpu_seconds() - start;
}

/* ---- comparing ---- */

static uint32_t float_bits(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* t is not negative here, so that the bits are in order. */
static uint32_t ulps(float a, float b) {
    uint32_t x = float_bits(a), y = float_bits(b);
    return x > y ? x - y : y - x;
}

/* In double: where the ray meets the plane of a triangle, and whether inside of it. */
typedef struct meeting {
    double t;
    bool inside;
} meeting;

static meeting meet(const subject *s, const ray *r, uint32_t triangle) {
    dvec3 v[3], d = dvec3_from(r->d);
    subject_corners(s, triangle, r->time, v);
    for (int i = 0; i < 3; i++) v[i] = dvec3_sub(v[i], dvec3_from(r->o));
    dvec3 n = dvec3_cross(dvec3_sub(v[1], v[0]), dvec3_sub(v[2], v[0]));
    double a = dvec3_dot(d, dvec3_cross(v[0], v[1])), b = dvec3_dot(d, dvec3_cross(v[1], v[2])),
           c = dvec3_dot(d, dvec3_cross(v[2], v[0]));
    bool inside = (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
    return (meeting){dvec3_dot(n, v[0]) / dvec3_dot(n, d), inside};
}

/* Which of two hits that differ is right: 1 or -1 for snell's or the other, 0: not told. */
static int judge(const subject *s, const ray *r, const hit *own, const hit *other) {
    if (s->scene.sphere_count) return 0;
    bool own_first = other->instance == NO_ID || (own->instance != NO_ID && own->t < other->t);
    const hit *first = own_first ? own : other, *second = own_first ? other : own;
    int side = own_first ? 1 : -1;
    meeting m = meet(s, r, first->primitive);
    if (second->instance == NO_ID || first->primitive != second->primitive)
        return m.inside ? side : -side; /* the second has missed what the first has hit */
    double off = fabs((double)first->t - m.t), second_off = fabs((double)second->t - m.t);
    return off < second_off ? side : off > second_off ? -side : 0;
}

static void compare_hit(const subject *s, const ray *r, const hit *own, const hit *other,
                        agreement *a) {
    bool hits = own->instance != NO_ID, also = other->instance != NO_ID, differ = hits != also;
    a->bits += memcmp(own, other, sizeof *own) != 0;
    a->hit_or_miss += differ;
    if (hits && also) {
        uint32_t off = ulps(own->t, other->t);
        a->both++;
        if (off > a->ulp_max) a->ulp_max = off;
        a->over_4_ulp += off > 4;
        differ = off > 4;
    }
    if (!differ) return;
    int side = judge(s, r, own, other);
    a->own_right += side > 0;
    a->other_right += side < 0;
}

static agreement compare(const bench *b, uint32_t kind, const ray_set *set) {
    agreement a = {0};
    for (size_t i = 0; i < set->count; i++)
        if (!ray_kind_any(kind))
            compare_hit(b->subject, &set->rays[i], &b->reference.hits[i], &b->now.hits[i], &a);
        else if (b->reference.blocked[i] != b->now.blocked[i])
            a.hit_or_miss++, a.bits++;
    return a;
}

/* Spoiled rays that hit, and others whose outcome is not that of the clean set. */
static size_t count_wrong(const bench *b, uint32_t kind, const ray_set *spoiled, size_t *count) {
    size_t wrong = 0;
    *count = 0;
    for (size_t i = 0; i < spoiled->count; i++) {
        const hit *own = &b->reference.hits[i], *now = &b->now.hits[i];
        bool any = ray_kind_any(kind);
        if (ray_is_spoiled(&spoiled->rays[i])) {
            wrong += any ? b->now.blocked[i] : now->instance != NO_ID;
            ++*count;
        } else {
            wrong += any ? b->now.blocked[i] != b->reference.blocked[i]
                         : memcmp(own, now, sizeof *now) != 0;
        }
    }
    return wrong;
}

/* ---- one kind of ray ---- */

static void measure_cell(const bench *b, const ray_set *set, const ray_set *spoiled,
                         thread_pool *pool, uint32_t round, cell *c) {
    const settings *t = b->settings;
    job j = {.bench = b, .kind = c->kind, .set = set, .out = &b->now};
    double rays = (double)set->count, own_seconds = 0;
    for (uint32_t i = 0; i < TRACERS; i++) {
        j.tracer =
            round % 2 ? TRACERS - 1 - i : i; /* in turn, the other way in every other round */
        if (!t->wanted[j.tracer]) continue;
        double cycles = cycles_now(), seconds = trace(&j, pool);
        c->mrays[j.tracer][round] = 1e-6 * rays / seconds;
        if (j.tracer == t->own) {
            c->cycles[round] = (cycles_now() - cycles) / rays;
            own_seconds = seconds;
        }
        if (round + 1 == t->rounds) c->agree[j.tracer] = compare(b, c->kind, set);
    }
    if (spoiled == NULL) return;
    j.tracer = t->own;
    j.set = spoiled;
    c->spoiled_time[round] = trace(&j, pool) / own_seconds;
    c->spoiled_wrong = count_wrong(b, c->kind, spoiled, &c->spoiled);
}

static void measure_kind(bench *b, uint32_t kind, const ray_set *set, cell *cells) {
    const settings *t = b->settings;
    ray_set spoiled;
    rays_spoil(set, &spoiled);
    trace_counters counters = {0};
    job j = {b, t->own, kind, set, &b->reference, &counters};
    trace(&j, NULL);
    for (uint32_t i = 0; i < t->threads_count; i++)
        cells[i] = (cell){
            .kind = kind, .threads = t->threads[i], .rays = set->count, .counters = counters};
    for (uint32_t round = 0; round < t->rounds; round++)
        for (uint32_t i = 0; i < t->threads_count; i++)
            measure_cell(b, set, i == 0 ? &spoiled : NULL, b->pools[i], round, &cells[i]);
    rays_free(&spoiled);
}

/* ---- one scene ---- */

static void build(subject *s, peer *p, const settings *t, scene_results *out) {
    for (uint32_t i = 0; i < t->builds; i++) {
        out->build[i] = subject_build(s, t->leaf_size, t->own_quality);
#if BENCH_HAS_EMBREE
        if (p) out->peer_build[i] = peer_build(p, t->quality);
        if (p) out->peer_bytes = peer_bytes(p);
#endif
    }
    (void)p;
    out->memory = accel_get_memory(s->accel);
}

void measure_scene(subject *s, peer *p, const settings *t, scene_results *out) {
    *out = (scene_results){.name = s->scene.name,
                           .triangles = s->scene.index_count / 3,
                           .spheres = s->scene.sphere_count,
                           .ao_length = RAY_AO_LENGTH * s->size,
                           .cell_count = RAY_KINDS * t->threads_count};
    build(s, p, t, out);
    out->cells = bench_need(memory_zeroed(out->cell_count, sizeof *out->cells));
    ray_set primary;
    rays_make_primary(s, t->size, &primary);
    bench b = {s, p, t, {NULL}, allocate(primary.count), allocate(primary.count)};
    for (uint32_t i = 0; i < t->threads_count; i++)
        if (t->threads[i] > 1 && thread_pool_create(t->threads[i], &b.pools[i]))
            bench_die(error_last()->text);
    measure_kind(&b, RAY_PRIMARY, &primary, out->cells);
    hit *hits = b.reference.hits;
    b.reference.hits = bench_need(memory_zeroed(primary.count, sizeof *hits));
    for (uint32_t kind = 1; kind < RAY_KINDS; kind++) {
        ray_set set;
        rays_make(s, kind, &primary, hits, &set);
        if (set.count == 0) bench_die("the camera sees nothing: --eye and --look move it");
        measure_kind(&b, kind, &set, out->cells + kind * t->threads_count);
        rays_free(&set);
    }
    for (uint32_t i = 0; i < t->threads_count; i++) thread_pool_destroy(b.pools[i]);
    free(hits);
    release(&b.reference);
    release(&b.now);
    rays_free(&primary);
}

uint32_t cell_peer(const cell *c, const settings *t) {
    if (!t->wanted[SINGLE]) return TRACERS;
    double single = summarise(c->mrays[SINGLE], t->rounds).median;
    return summarise(c->mrays[PACKET], t->rounds).median > single ? PACKET : SINGLE;
}

summary cell_ratio(const cell *c, const settings *t, uint32_t tracer) {
    double ratios[ROUNDS_MAX];
    for (uint32_t i = 0; i < t->rounds; i++) ratios[i] = c->mrays[t->own][i] / c->mrays[tracer][i];
    return summarise(ratios, t->rounds);
}
