/* What the rounds of snell bench took: a table, or JSON. */
#include <inttypes.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "report.h"
#include "text.h"

static const char *const phase_names[BENCH_PHASE_COUNT] = {"load", "build", "render", "write"};

/* CPU time of the render by what was done; the rest is the film, and starting the threads. */
typedef struct part {
    const char *name, *key;
    size_t offset;
} part;

static const part parts[] = {
    {"camera rays", "camera", offsetof(bench_round, stats.seconds_camera)},
    {"trace", "trace", offsetof(bench_round, stats.seconds_trace)},
    {"shade", "shade", offsetof(bench_round, stats.seconds_shade)},
    {"shadows", "shadows", offsetof(bench_round, stats.seconds_shadows)},
};
enum { PART_COUNT = sizeof parts / sizeof parts[0] };

typedef struct kind {
    const char *name;
    size_t offset;
} kind;

static const kind kinds[] = {
    {"camera", offsetof(snell_render_stats, rays_camera)},
    {"reflected", offsetof(snell_render_stats, rays_reflected)},
    {"refracted", offsetof(snell_render_stats, rays_refracted)},
    {"continued", offsetof(snell_render_stats, rays_continued)},
    {"shadow", offsetof(snell_render_stats, rays_shadow)},
};
enum { KIND_COUNT = sizeof kinds / sizeof kinds[0] };

static uint64_t count_at(const snell_render_stats *s, size_t offset) {
    uint64_t count;
    memcpy(&count, (const char *)s + offset, sizeof count);
    return count;
}

uint64_t bench_nearest_rays(const snell_render_stats *s) {
    return s->rays_camera + s->rays_reflected + s->rays_refracted + s->rays_continued;
}

/* ---- medians ---- */

static int compare_doubles(const void *a, const void *b) {
    double x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return (x > y) - (x < y);
}

static summary summarise(double *values, uint32_t count) {
    qsort(values, count, sizeof *values, compare_doubles);
    double middle = (values[(count - 1) / 2] + values[count / 2]) / 2;
    return (summary){middle, values[0], values[count - 1]};
}

summary bench_summary(const bench *b, size_t offset) {
    double values[ROUNDS_MAX];
    for (uint32_t i = 0; i < b->round_count; i++)
        memcpy(&values[i], (const char *)&b->rounds[i] + offset, sizeof values[i]);
    return summarise(values, b->round_count);
}

static double sum_of(const double seconds[BENCH_PHASE_COUNT]) {
    double sum = 0;
    for (int i = 0; i < BENCH_PHASE_COUNT; i++) sum += seconds[i];
    return sum;
}

static summary total(const bench *b, bool cpu) {
    double values[ROUNDS_MAX];
    for (uint32_t i = 0; i < b->round_count; i++)
        values[i] = sum_of(cpu ? b->rounds[i].cpu : b->rounds[i].wall);
    return summarise(values, b->round_count);
}

summary bench_seconds(const bench *b) { return total(b, false); }

static summary rate_by(const bench *b, bool cpu) {
    double values[ROUNDS_MAX];
    for (uint32_t i = 0; i < b->round_count; i++) {
        const bench_round *r = &b->rounds[i];
        double rays = (double)(bench_nearest_rays(&r->stats) + r->stats.rays_shadow);
        values[i] = 1e-6 * rays / (cpu ? r->cpu : r->wall)[BENCH_RENDER];
    }
    return summarise(values, b->round_count);
}

summary bench_rate(const bench *b) { return rate_by(b, false); }
summary bench_rate_cpu(const bench *b) { return rate_by(b, true); }

/* ---- the groups of rays that the counters tell apart ---- */

typedef struct group {
    uint64_t rays;
    double seconds; /* of the CPU, median */
    double nodes, boxes, triangles, primitives;
} group;

static group make_group(uint64_t rays, double seconds, const uint64_t tests[4]) {
    double n = rays > 0 ? (double)rays : 1;
    return (group){rays,
                   seconds,
                   (double)tests[0] / n,
                   (double)tests[1] / n,
                   (double)tests[2] / n,
                   (double)tests[3] / n};
}

static group nearest_group(const bench *b) {
    const snell_render_stats *s = &b->rounds[0].stats;
    uint64_t tests[4] = {s->nodes - s->shadow_nodes, s->boxes - s->shadow_boxes,
                         s->triangles - s->shadow_triangles, s->primitives - s->shadow_primitives};
    return make_group(bench_nearest_rays(s), BENCH_SUMMARY(b, stats.seconds_trace).median, tests);
}

static group shadow_group(const bench *b) {
    const snell_render_stats *s = &b->rounds[0].stats;
    uint64_t tests[4] = {s->shadow_nodes, s->shadow_boxes, s->shadow_triangles,
                         s->shadow_primitives};
    return make_group(s->rays_shadow, BENCH_SUMMARY(b, stats.seconds_shadows).median, tests);
}

static double rate_of(const group *g) {
    return g->seconds > 0 ? 1e-6 * (double)g->rays / g->seconds : 0;
}

/* ---- the table ---- */

static void print_seconds(const char *name, const summary *wall, double cpu, double all_cpu) {
    char range[48] = "";
    if (wall != NULL) snprintf(range, sizeof range, "%.3f..%.3f", wall->least, wall->most);
    printf("%-16s", name);
    if (wall != NULL)
        printf("%9.3f  %-18s", wall->median, range);
    else
        printf("%9s  %-18s", "", "");
    printf("%9.3f  %5.1f %%\n", cpu, all_cpu > 0 ? 100 * cpu / all_cpu : 0);
}

static void print_phases(const bench *b) {
    summary wall = total(b, false);
    double all = total(b, true).median, render = 0, rest;
    printf("\n%-16s%9s  %-18s%9s  %7s\n", "seconds", "wall", "least..most", "CPU", "of all");
    for (int i = 0; i < BENCH_PHASE_COUNT; i++) {
        summary w = bench_summary(b, offsetof(bench_round, wall) + (size_t)i * sizeof(double)),
                c = bench_summary(b, offsetof(bench_round, cpu) + (size_t)i * sizeof(double));
        print_seconds(phase_names[i], &w, c.median, all);
        if (i != BENCH_RENDER) continue;
        rest = render = c.median;
        for (int k = 0; k < PART_COUNT; k++) {
            char name[32];
            double seconds = bench_summary(b, parts[k].offset).median;
            snprintf(name, sizeof name, "  %s", parts[k].name);
            print_seconds(name, NULL, seconds, all);
            rest -= seconds;
        }
        print_seconds("  film and rest", NULL, rest > 0 ? rest : 0, all);
    }
    print_seconds("all", &wall, all, all);
}

static void print_group(const char *name, const group *g) {
    printf("%-16s%14.1f%9.1f%9.1f%11.1f%9.1f\n", name, rate_of(g), g->nodes, g->boxes, g->triangles,
           g->primitives);
}

static void print_rays(const bench *b) {
    const snell_render_stats *s = &b->rounds[0].stats;
    double seconds = BENCH_SUMMARY(b, wall[BENCH_RENDER]).median, all;
    char count[32];
    all = (double)(bench_nearest_rays(s) + s->rays_shadow);
    printf("\n%-16s%16s  %7s  %9s\n", "rays", "number", "of all", "Mrays/s");
    for (int i = 0; i <= KIND_COUNT; i++) {
        uint64_t rays = i < KIND_COUNT ? count_at(s, kinds[i].offset) : (uint64_t)all;
        if (rays == 0) continue;
        text_format_count(rays, count);
        printf("%-16s%16s  %5.1f %%  %9.2f\n", i < KIND_COUNT ? kinds[i].name : "all", count,
               100 * (double)rays / all, 1e-6 * (double)rays / seconds);
    }
    group nearest = nearest_group(b), shadow = shadow_group(b);
    printf("\n%-16s%14s%9s%9s%11s%9s\n", "tests a ray", "Mrays/CPU s", "nodes", "boxes",
           "triangles", "shapes");
    print_group("nearest hits", &nearest);
    if (shadow.rays > 0) print_group("shadows", &shadow);
}

static void print_memory(const bench *b) {
    const struct {
        const char *name;
        uint64_t bytes;
    } rows[] = {
        {"geometry", b->scene.memory_geometry},           {"tree (BVH)", b->scene.memory_accel},
        {"textures", b->scene.memory_textures},           {"film", b->rounds[0].stats.memory_film},
        {"waiting rays", b->rounds[0].stats.memory_rays}, {"snell, at most", b->memory_peak},
        {"import helper", b->memory_peak_import}};
    char bytes[32];
    puts("\nmemory");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        text_format_bytes(rows[i].bytes, bytes);
        printf("%-16s%12s\n", rows[i].name, bytes);
    }
}

void bench_print_advice(const bench *b) {
    char lines[ADVICE_MAX][ADVICE_TEXT];
    size_t count = bench_advice(b, lines);
    for (size_t i = 0; i < count; i++) {
        fputs(i == 0 ? "\n- " : "- ", stdout);
        text_print_wrapped(stdout, lines[i], 2, 2, 79);
        putchar('\n');
    }
}

void bench_text(const bench *b) {
    text_print_safe(stdout, session_label(b->label));
    printf(": %" PRIu32 "x%" PRIu32 ", %s, %s%" PRIu32 " sample%s, %" PRIu32
           " thread%s, %s; %" PRIu32 " round%s\n",
           b->desc.width, b->desc.height, integrator_name(b->desc.integrator),
           b->desc.noise > 0 ? "up to " : "", b->desc.samples, b->desc.samples == 1 ? "" : "s",
           b->threads, b->threads == 1 ? "" : "s", snell_isa_name(b->isa), b->round_count,
           b->round_count == 1 ? "" : "s, medians");
    print_phases(b);
    print_rays(b);
    print_memory(b);
    bench_print_advice(b);
}

/* ---- JSON ---- */

static void set_count(json_t *object, const char *key, uint64_t value) {
    json_object_set_new(object, key, json_integer((json_int_t)value));
}

static json_t *json_summary(summary s) {
    return json_pack("{s:f,s:f,s:f}", "median", s.median, "min", s.least, "max", s.most);
}

static json_t *json_rate(summary million) {
    return json_summary((summary){1e6 * million.median, 1e6 * million.least, 1e6 * million.most});
}

static json_t *json_phases(const bench *b, bool cpu) {
    json_t *object = json_object();
    size_t first = cpu ? offsetof(bench_round, cpu) : offsetof(bench_round, wall);
    for (int i = 0; i < BENCH_PHASE_COUNT; i++)
        json_object_set_new(object, phase_names[i],
                            json_summary(bench_summary(b, first + (size_t)i * sizeof(double))));
    json_object_set_new(object, "total", json_summary(total(b, cpu)));
    return object;
}

static json_t *json_group(const group *g) {
    return json_pack("{s:I,s:f,s:f,s:f,s:f,s:f,s:f}", "rays", (json_int_t)g->rays, "cpu_seconds",
                     g->seconds, "rays_per_cpu_second", 1e6 * rate_of(g), "nodes", g->nodes,
                     "boxes", g->boxes, "triangles", g->triangles, "primitives", g->primitives);
}

static json_t *json_memory(const bench *b) {
    json_t *object = json_object();
    set_count(object, "geometry", b->scene.memory_geometry);
    set_count(object, "accel", b->scene.memory_accel);
    set_count(object, "textures", b->scene.memory_textures);
    set_count(object, "film", b->rounds[0].stats.memory_film);
    set_count(object, "rays", b->rounds[0].stats.memory_rays);
    set_count(object, "peak", b->memory_peak);
    set_count(object, "peak_import", b->memory_peak_import);
    return object;
}

json_t *bench_json(const bench *b) {
    const snell_render_stats *s = &b->rounds[0].stats;
    json_t *root = json_object(), *rays = json_object(), *cpu = json_object(),
           *advice = json_array();
    char lines[ADVICE_MAX][ADVICE_TEXT];
    json_object_set_new(root, "file", report_text(b->label));
    set_count(root, "width", b->desc.width);
    set_count(root, "height", b->desc.height);
    json_object_set_new(root, "integrator", json_string(integrator_name(b->desc.integrator)));
    set_count(root, "samples", b->desc.samples);
    set_count(root, "max_depth", b->desc.max_depth);
    set_count(root, "threads", b->threads);
    json_object_set_new(root, "isa", json_string(snell_isa_name(b->isa)));
    set_count(root, "rounds", b->round_count);
    json_object_set_new(root, "seconds", json_phases(b, false));
    json_object_set_new(root, "cpu_seconds", json_phases(b, true));
    for (int i = 0; i < PART_COUNT; i++)
        json_object_set_new(cpu, parts[i].key, json_summary(bench_summary(b, parts[i].offset)));
    json_object_set_new(root, "render_cpu_seconds", cpu);
    for (int i = 0; i < KIND_COUNT; i++)
        set_count(rays, kinds[i].name, count_at(s, kinds[i].offset));
    set_count(rays, "total", bench_nearest_rays(s) + s->rays_shadow);
    json_object_set_new(root, "rays", rays);
    json_object_set_new(root, "rays_per_second", json_rate(bench_rate(b)));
    json_object_set_new(root, "rays_per_cpu_second", json_rate(bench_rate_cpu(b)));
    group nearest = nearest_group(b), shadow = shadow_group(b);
    json_object_set_new(root, "nearest", json_group(&nearest));
    json_object_set_new(root, "shadow", json_group(&shadow));
    json_object_set_new(root, "memory", json_memory(b));
    size_t count = bench_advice(b, lines);
    for (size_t i = 0; i < count; i++) json_array_append_new(advice, report_text(lines[i]));
    json_object_set_new(root, "advice", advice);
    return root;
}
