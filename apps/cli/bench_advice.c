/* What is unusual about a picture's time and memory. Usual is what the scenes of scenes/ and the models
 * that the tests render need; docs/bench.md has the figures. */
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "bench.h"
#include "report.h"
#include "text.h"

typedef struct advice {
    char (*lines)[ADVICE_TEXT];
    size_t count;
} advice;

static void PRINTF_LIKE(2, 3) say(advice *a, const char *format, ...) {
    va_list args;
    if (a->count == ADVICE_MAX) return;
    va_start(args, format);
    vsnprintf(a->lines[a->count++], ADVICE_TEXT, format, args);
    va_end(args);
}

static double per(uint64_t count, uint64_t of) { return of > 0 ? (double)count / (double)of : 0; }

/* More tests a ray than any scene of scenes/ and any usual model needs (docs/bench.md). */
static const struct {
    const char *name, *why;
    double nearest_max,
        shadow_max;     /* shadow rays cross the scene, and walk through glass and leaves */
    size_t all, shadow; /* in the stats */
} tests[] = {
    {"triangles",
     "long thin or overlapping ones share their boxes; split them, or try --build best", 15, 30,
     offsetof(snell_render_stats, triangles), offsetof(snell_render_stats, shadow_triangles)},
    {"shapes", "their boxes overlap", 8, 12, offsetof(snell_render_stats, primitives),
     offsetof(snell_render_stats, shadow_primitives)},
    {"nodes of the tree", "much of the scene overlaps, or rays pass close by it", 25, 30,
     offsetof(snell_render_stats, nodes), offsetof(snell_render_stats, shadow_nodes)},
};

static uint64_t count_at(const snell_render_stats *s, size_t offset) {
    uint64_t count;
    memcpy(&count, (const char *)s + offset, sizeof count);
    return count;
}

static void advise_of_tests(const bench *b, advice *a) {
    const snell_render_stats *s = &b->rounds[0].stats;
    for (size_t i = 0; i < sizeof tests / sizeof tests[0]; i++) {
        uint64_t shadow = count_at(s, tests[i].shadow),
                 nearest = count_at(s, tests[i].all) - shadow;
        double each = per(nearest, bench_nearest_rays(s)),
               each_shadow = per(shadow, s->rays_shadow);
        if (each > tests[i].nearest_max)
            say(a, "%.0f %s tested a ray, where over %.0f is much: %s", each, tests[i].name,
                tests[i].nearest_max, tests[i].why);
        else if (each_shadow > tests[i].shadow_max)
            say(a, "%.0f %s tested a shadow ray, where over %.0f is much: %s", each_shadow,
                tests[i].name, tests[i].shadow_max,
                b->scene.has_dielectric ? "each walks through all the glass in its way"
                                        : tests[i].why);
    }
}

static void advise_of_rays(const bench *b, advice *a) {
    const snell_render_stats *s = &b->rounds[0].stats;
    uint64_t nearest = bench_nearest_rays(s);
    if (per(nearest, s->rays_camera) > 25)
        say(a,
            "%.0f rays followed for each camera ray: --max-depth and --min-weight bound the tree, "
            "-i path follows one ray at a time",
            per(nearest, s->rays_camera));
    if (per(s->rays_continued, nearest) > 0.3)
        say(a,
            "%.0f %% of the rays walk on through surfaces that are transparent: cut them out of "
            "the "
            "mesh where they are empty",
            100 * per(s->rays_continued, nearest));
    double shadows = per(s->rays_shadow, nearest);
    summary render = BENCH_SUMMARY(b, cpu[BENCH_RENDER]);
    if (shadows > 8 || (shadows > 4 && s->seconds_shadows > 0.5 * render.median))
        say(a,
            "%.0f shadow rays for each ray that looks for a hit: there are many lights%s; -i path "
            "asks one of them at a time",
            shadows, b->scene.has_emission ? ", and whatever shines by itself is one or more" : "");
    if (per(s->media_mismatches, nearest) > 0.01)
        say(a, "%.0f %% of the rays leave glass that they never entered: its surface is not closed",
            100 * per(s->media_mismatches, nearest));
}

static void advise_of_phases(const bench *b, advice *a) {
    double all = bench_seconds(b).median, load = BENCH_SUMMARY(b, wall[BENCH_LOAD]).median,
           build = BENCH_SUMMARY(b, wall[BENCH_BUILD]).median;
    summary wall = BENCH_SUMMARY(b, wall[BENCH_RENDER]), cpu = BENCH_SUMMARY(b, cpu[BENCH_RENDER]);
    bool long_enough = all > 0.5; /* what starts a process is no news */
    if (long_enough && load > 0.5 * all)
        say(a, "%.0f %% of the time goes into reading the file", 100 * load / all);
    if (long_enough && build > 0.4 * all)
        say(a, "%.0f %% of the time goes into building the tree: --build fast takes less",
            100 * build / all);
    double busy = cpu.median / (wall.median * b->threads);
    uint64_t blocks =
        (uint64_t)((b->desc.width + 15) / 16) * (uint64_t)((b->desc.height + 15) / 16);
    if (b->threads > 1 && long_enough && busy < 0.8)
        say(a, "the threads worked %.0f %% of the render: %s", 100 * busy,
            blocks < 8u * b->threads ? "the picture has few blocks of 16x16 pixels"
                                     : "other programs run too, or a few blocks take very long");
    else if (b->round_count > 1 && wall.most > 1.3 * wall.least && cpu.most < 1.15 * cpu.least)
        say(a, "rounds differ by the clock, not in CPU time: other programs run too");
}

static void advise_of_memory(const bench *b, advice *a) {
    const snell_scene_stats *s = &b->scene;
    char bytes[32];
    double machine = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    text_format_bytes(b->memory_peak, bytes);
    if (machine > 0 && (double)b->memory_peak > 0.6 * machine)
        say(a, "%s is most of this machine's memory: --memory keeps snell from taking all of it",
            bytes);
    text_format_bytes(s->memory_textures, bytes);
    if (s->memory_textures > (256u << 20) &&
        s->memory_textures > s->memory_geometry + s->memory_accel)
        say(a, "%s of textures, more than of all else: smaller pictures would do for this size",
            bytes);
}

size_t bench_advice(const bench *b, char lines[ADVICE_MAX][ADVICE_TEXT]) {
    advice a = {lines, 0};
    if (strcmp(SNELL_BUILD_TYPE, "Release") != 0)
        say(&a, "this is a %s build of snell: what it takes says little", SNELL_BUILD_TYPE);
    if (b->isa == SNELL_ISA_SCALAR)
        say(&a, "rays are traced without SIMD: 'snell --version' says what the CPU has");
    advise_of_tests(b, &a);
    advise_of_rays(b, &a);
    advise_of_phases(b, &a);
    advise_of_memory(b, &a);
    return a.count;
}
