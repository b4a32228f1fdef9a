/* Rays per second of the tracing kernels, beside Embree fed the same rays in the same run. See
 * bench/README.md. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "parts.h"
#include "picture.h"
#include "report.h"

enum { SCENES_MAX = 16 };

static const char usage[] =
    "usage: bench-kernel [option]... [SCENE|FILE]...\n"
    "Rays per second of snell's kernels and of Embree's, on the same rays in turn.\n"
    "  --detail X         times as many triangles (1)\n"
    "  --size N           primary rays across and down (1024)\n"
    "  --rounds N         how often each is measured (9)\n"
    "  --builds N         how often each builds (3)\n"
    "  --threads N,N      on one thread, then on N (1)\n"
    "  --isa NAME|all     the instruction set (the best); all: every one of this machine\n"
    "  --batch N          rays in a call (1024)\n"
    "  --leaf-size N      triangles in a leaf at most (chosen)\n"
    "  --snell-quality NAME   of snell's: fast, balanced or best (balanced)\n"
    "  --quality NAME     of Embree's build: low, medium or high (medium)\n"
    "  --no-embree        without\n"
    "  --deforming        the mesh moves between two keys, every ray at a time of its own\n"
    "  --eye X,Y,Z --look X,Y,Z --fov DEGREES   another camera than the scene's\n"
    "  --picture FILE     draw the scene, and measure nothing\n"
    "  --json             results as JSON\n"
    "FILE is any that snell reads; its triangles are traced. Scenes:\n";

static void print_usage(void) {
    const char *name, *help;
    bool usual;
    fputs(usage, stdout);
    for (uint32_t i = 0; (name = bench_scene_name(i, &help, &usual)); i++)
        printf("  %-9s %s%s\n", name, help, usual ? "" : " (when asked for)");
}

/* ---- options ---- */

static uint32_t number(const char *text, uint32_t low, uint32_t high) {
    uint64_t value;
    if (!read_number(text, low, high, &value)) bench_die("a number is missing or wrong (--help)");
    return (uint32_t)value;
}

/* `count` numbers between commas. */
static void reals(const char *text, double *out, int count) {
    for (int i = 0; i < count; i++) {
        char *end = NULL;
        if (text) out[i] = strtod(text, &end);
        if (text == NULL || end == text || !isfinite(out[i]) ||
            *end != (i + 1 < count ? ',' : '\0'))
            bench_die("a number is missing or wrong (--help)");
        text = end + 1;
    }
}

static dvec3 point(const char *text) {
    double p[3];
    reals(text, p, 3);
    return (dvec3){p[0], p[1], p[2]};
}

static double real(const char *text, double low, double high) {
    double x;
    reals(text, &x, 1);
    if (!(x >= low && x <= high)) bench_die("a number is too small or too large (--help)");
    return x;
}

static void read_threads(settings *t, char *text) {
    char *rest = NULL;
    t->threads_count = 0;
    for (char *word = text ? strtok_r(text, ",", &rest) : NULL; word;
         word = strtok_r(NULL, ",", &rest)) {
        if (t->threads_count == THREAD_COUNTS_MAX) bench_die("--threads: too many numbers");
        t->threads[t->threads_count++] = number(word, 1, 1024);
    }
    if (t->threads_count == 0) bench_die("--threads takes numbers, as in 1,2");
}

static void read_isa(settings *t, const char *text) {
    bool all = text && strcmp(text, "all") == 0, found = false;
    for (uint32_t i = 0; i < SINGLE; i++) {
        t->wanted[i] = text && (all || strcmp(text, tracer_names[i]) == 0);
        if (t->wanted[i] && !accel_has_isa(tracer_isas[i])) {
            if (!all) bench_die("--isa: not on this machine");
            t->wanted[i] = false;
        }
        if (t->wanted[i]) t->own = i, found = true;
    }
    if (!found) bench_die("--isa takes scalar, avx2, avx512 or all");
}

static accel_quality read_own_quality(const char *text) {
    for (int i = 0; text && i < ACCEL_QUALITIES; i++)
        if (strcmp(text, accel_quality_names[i]) == 0) return (accel_quality)i;
    bench_die("--snell-quality takes fast, balanced or best");
}

static peer_quality read_quality(const char *text) {
    static const char *const names[] = {"low", "medium", "high"};
    for (int i = 0; text && i < 3; i++)
        if (strcmp(text, names[i]) == 0) return (peer_quality)i;
    bench_die("--quality takes low, medium or high");
}

typedef struct command {
    settings settings;
    bool has_eye, has_look;
    bench_camera camera; /* what is given of it; fov 0: not given */
    const char *scenes[SCENES_MAX];
    size_t scene_count;
} command;

/* Options that take a value; false: no such. */
static bool read_value(command *c, const char *name, char *value) {
    settings *t = &c->settings;
    if (strcmp(name, "--detail") == 0)
        t->detail = real(value, 1e-4, 1000);
    else if (strcmp(name, "--size") == 0)
        t->size = number(value, 8, 8192) / 8 * 8;
    else if (strcmp(name, "--rounds") == 0)
        t->rounds = number(value, 1, ROUNDS_MAX);
    else if (strcmp(name, "--builds") == 0)
        t->builds = number(value, 1, ROUNDS_MAX);
    else if (strcmp(name, "--threads") == 0)
        read_threads(t, value);
    else if (strcmp(name, "--isa") == 0)
        read_isa(t, value);
    else if (strcmp(name, "--batch") == 0)
        t->batch = number(value, 1, 1 << 20);
    else if (strcmp(name, "--leaf-size") == 0)
        t->leaf_size = number(value, 1, 8);
    else if (strcmp(name, "--snell-quality") == 0)
        t->own_quality = read_own_quality(value);
    else if (strcmp(name, "--quality") == 0)
        t->quality = read_quality(value);
    else if (strcmp(name, "--eye") == 0)
        c->camera.eye = point(value), c->has_eye = true;
    else if (strcmp(name, "--look") == 0)
        c->camera.look = point(value), c->has_look = true;
    else if (strcmp(name, "--fov") == 0)
        c->camera.fov = real(value, 0.1, 170);
    else if (strcmp(name, "--picture") == 0)
        t->picture = value;
    else
        return false;
    if (value == NULL) bench_die("an option lacks its value (--help)");
    return true;
}

static void add_usual_scenes(command *c) {
    const char *name, *help;
    bool usual;
    for (uint32_t i = 0; (name = bench_scene_name(i, &help, &usual)); i++)
        if (usual) c->scenes[c->scene_count++] = name;
}

static void read_command(command *c, int argc, char **argv) {
    settings *t = &c->settings;
    for (int i = 1; i < argc; i++) {
        const char *word = argv[i];
        if (strcmp(word, "--json") == 0)
            t->json = true;
        else if (strcmp(word, "--no-embree") == 0)
            t->embree = false;
        else if (strcmp(word, "--deforming") == 0)
            t->deforming = true;
        else if (strcmp(word, "--help") == 0) {
            print_usage();
            exit(0);
        } else if (word[0] == '-') {
            if (!read_value(c, word, argv[i + 1])) bench_die("no such option (--help)");
            i++;
        } else if (c->scene_count == SCENES_MAX)
            bench_die("too many scenes");
        else
            c->scenes[c->scene_count++] = word;
    }
    if (c->scene_count == 0) add_usual_scenes(c);
    if (t->picture && c->scene_count != 1) bench_die("--picture takes one scene");
}

/* ---- all ---- */

static void set_camera(bench_camera *to, const command *c) {
    if (c->has_eye) to->eye = c->camera.eye;
    if (c->has_look) to->look = c->camera.look;
    if (c->camera.fov > 0) to->fov = c->camera.fov;
}

static void draw(const command *c) {
    subject s;
    subject_make(&s, c->scenes[0], c->settings.detail, c->settings.deforming);
    set_camera(&s.scene.camera, c);
    subject_build(&s, c->settings.leaf_size, c->settings.own_quality);
    picture_write(&s, c->settings.size, c->settings.picture);
    subject_free(&s);
}

static void measure(const command *c, const char *name, char *version, size_t size,
                    scene_results *out) {
    subject s;
    peer *p = NULL;
    subject_make(&s, name, c->settings.detail, c->settings.deforming);
    set_camera(&s.scene.camera, c);
#if BENCH_HAS_EMBREE
    if (c->settings.embree) p = peer_create(&s);
    if (p) peer_version(p, version, size);
#else
    (void)version;
    (void)size;
#endif
    measure_scene(&s, p, &c->settings, out);
    out->name = name;
#if BENCH_HAS_EMBREE
    peer_destroy(p);
#endif
    subject_free(&s);
}

/* snell's own hits do not depend on instruction set, threads or what else is traced. */
static bool is_sound(const scene_results *r) {
    for (uint32_t i = 0; i < r->cell_count; i++) {
        if (r->cells[i].spoiled_wrong) return false;
        for (uint32_t k = 0; k < SINGLE; k++)
            if (r->cells[i].agree[k].bits) return false;
    }
    return true;
}

int main(int argc, char **argv) {
    static command c = {.settings = {.size = 1024,
                                     .rounds = 9,
                                     .builds = 3,
                                     .detail = 1,
                                     .threads = {1},
                                     .threads_count = 1,
                                     .batch = 1024,
                                     .quality = PEER_MEDIUM,
                                     .embree = BENCH_HAS_EMBREE}};
    static scene_results results[SCENES_MAX];
    settings *t = &c.settings;
    read_isa(t, snell_isa_name(accel_best_isa(SNELL_ISA_AUTO)));
    read_command(&c, argc, argv);
    t->wanted[SINGLE] = t->wanted[PACKET] = t->embree;
    floatenv_enter();
    if (t->picture) {
        draw(&c);
        return 0;
    }
    cycles_open();
    char version[32] = "";
    bool sound = true;
    for (size_t i = 0; i < c.scene_count; i++) {
        measure(&c, c.scenes[i], version, sizeof version, &results[i]);
        if (!t->json && i == 0) report_head(t, t->embree ? version : NULL);
        if (!t->json) report_scene(&results[i], t);
        sound &= is_sound(&results[i]);
    }
    if (t->json)
        report_json(results, c.scene_count, t, t->embree ? version : NULL);
    else
        report_means(results, c.scene_count, t);
    for (size_t i = 0; i < c.scene_count; i++) free(results[i].cells);
    if (!sound) bench_die("snell's own hits differ");
    return 0;
}
