/* Is --noise honest, and what does it save?
 *
 *     bench-noise [--size N] [--seeds N] [--noise P] [--samples N] [--reference N] [--threads N]
 *                 [--cache FOLDER] [--json] [SCENE]...
 *
 * Honest: each scene is rendered with many seeds until the bound, or --samples. Of every block the true
 * error, from a reference of very many samples, is held against the bound stated for that block. The share
 * of (block, seed) pairs that are within it should be the confidence or more; the median of true / stated
 * says how much the bound exaggerates. The noise of the reference itself counts against the bound.
 *
 * Saved: what plain rendering costs that has the same number of samples everywhere, as many as the hardest
 * block took; in CPU time of the process, in turns. The scene `corner` is for that: easy but for one corner. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include <snell/snell.h>

#include "noise.h"

typedef struct subject {
    const char *name, *file, *param;
    snell_integrator integrator;
} subject;

static const subject subjects[] = {
    {"cornell-box", "scenes/cornell-box.lua", NULL, SNELL_PATH},
    {"balls", "scenes/balls.lua", "depth=3", SNELL_PATH},
    {"caustic", "bench/noise/caustic.lua", NULL, SNELL_PATH},
    {"dark", "bench/noise/dark.lua", NULL, SNELL_PATH},
    {"gloss", "scenes/gloss.lua", NULL, SNELL_COOK},
    {"moving", "bench/noise/moving.lua", NULL, SNELL_COOK},
    {"corner", "bench/noise/corner.lua", NULL, SNELL_PATH},
};
enum { SUBJECTS = sizeof subjects / sizeof subjects[0] };

typedef struct settings {
    uint32_t size, seeds, samples, reference, threads, rounds;
    double noise;
    const char *cache;
    bool json;
} settings;

typedef struct result {
    uint32_t pairs, within, done, done_within; /* (block, seed); done: under the noise asked for */
    uint32_t rated;                            /* pairs that are not exact */
    double median, worst;                      /* of true / stated */
    double samples_mean, bound_max, reference_noise;
    uint32_t samples_max;
    double adaptive_seconds, uniform_seconds; /* CPU */
} result;

static void must(snell_status status) {
    if (status == SNELL_OK) return;
    fprintf(stderr, "bench-noise: %s\n", snell_last_error()->text);
    exit(1);
}

static double cpu_seconds(void) {
    struct rusage u;
    getrusage(RUSAGE_SELF, &u);
    return (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
           1e-6 * (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

/* ---- a scene and its reference ---- */

static snell_scene *load(snell_context *context, const subject *s, const settings *set,
                         snell_render_desc *desc) {
    char path[512];
    snell_scene *scene = NULL;
    snell_load_desc how = SNELL_INIT(load_desc);
    how.params = &s->param;
    how.param_count = s->param != NULL;
    snprintf(path, sizeof path, "%s/%s", BENCH_SOURCE_DIR, s->file);
    must(snell_scene_create(context, &scene));
    must(snell_scene_load(scene, path, &how));
    must(snell_scene_commit(scene, NULL, NULL));
    *desc = SNELL_INIT(render_desc);
    must(snell_scene_settings(scene, s->integrator, desc));
    desc->width = desc->height = set->size;
    desc->samples = set->samples;
    desc->noise = (float)set->noise;
    return scene;
}

/* Of the same footprints as what is measured: with a noise that is never reached. */
static float *make_reference(const snell_scene *scene, const settings *set, snell_render_desc desc,
                             snell_film *made) {
    size_t bytes = (size_t)set->size * set->size * 3 * sizeof(float);
    float *pixels = malloc(bytes);
    desc.samples = set->reference;
    desc.noise = 1e-9f;
    desc.seed = 1000003;
    must(snell_render(scene, &desc, made));
    memcpy(pixels, snell_film_pixels(made, NULL, NULL, NULL), bytes);
    return pixels;
}

static float *reference_of(const snell_scene *scene, const subject *s, const settings *set,
                           const snell_render_desc *desc, snell_film *made) {
    char path[600];
    uint64_t hash;
    size_t count = (size_t)set->size * set->size * 3;
    must(snell_scene_hash(scene, &hash));
    snprintf(path, sizeof path, "%s/%s-%ux%u-%u-%016llx.floats", set->cache, s->name, set->size,
             set->size, set->reference, (unsigned long long)hash);
    FILE *file = fopen(path, "rb");
    float *pixels = malloc(count * sizeof *pixels);
    bool read = file && fread(pixels, sizeof *pixels, count, file) == count;
    if (file) fclose(file);
    if (read) return pixels;
    free(pixels);
    pixels = make_reference(scene, set, *desc, made);
    file = fopen(path, "wb");
    if (file == NULL || fwrite(pixels, sizeof *pixels, count, file) != count || fclose(file) != 0)
        fprintf(stderr, "bench-noise: cannot keep %s\n", path);
    return pixels;
}

/* ---- errors of blocks ---- */

typedef struct ratios {
    double *of; /* true / stated */
    size_t count;
} ratios;

static void measure_seed(const snell_film *made, const float *reference, const settings *set,
                         result *r, ratios *to) {
    uint32_t blocks = (set->size + FILM_BLOCK - 1) / FILM_BLOCK;
    double mean = noise_image_mean(snell_film_pixels(made, NULL, NULL, NULL), set->size, set->size);
    for (uint32_t i = 0; i < blocks * blocks; i++) {
        double bound, error;
        noise_measure_block(made, reference, i % blocks, i / blocks, mean, &bound, &error);
        /* Floats end somewhere: of the reference, too. */
        bool within = error <= bound + 1e-6, done = bound <= set->noise;
        r->pairs++;
        r->within += within;
        r->done += done;
        r->done_within += done && error <= set->noise;
        if (!within && getenv("BENCH_NOISE_VERBOSE")) {
            const uint32_t *n = snell_film_samples(made);
            fprintf(stderr, "  block %u,%u: true %.4f stated %.4f at %u\n", i % blocks, i / blocks,
                    error, bound,
                    n[(size_t)(i / blocks) * FILM_BLOCK * set->size + i % blocks * FILM_BLOCK]);
        }
        if (error > 1e-6) to->of[to->count++] = error / bound;
    }
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void measure(snell_context *context, const subject *s, const settings *set, result *r) {
    snell_render_desc desc;
    snell_scene *scene = load(context, s, set, &desc);
    snell_film *made;
    must(snell_film_create(context, &made));
    float *reference = reference_of(scene, s, set, &desc, made);
    uint32_t blocks = (set->size + FILM_BLOCK - 1) / FILM_BLOCK;
    ratios all = {malloc((size_t)blocks * blocks * set->seeds * sizeof *all.of), 0};
    *r = (result){.pairs = 0};
    for (uint32_t seed = 1; seed <= set->seeds; seed++) {
        snell_render_stats stats = {.struct_size = sizeof stats};
        desc.seed = seed;
        double start = cpu_seconds();
        must(snell_render(scene, &desc, made));
        if (seed <= set->rounds) r->adaptive_seconds += (cpu_seconds() - start) / set->rounds;
        must(snell_film_get_stats(made, &stats));
        measure_seed(made, reference, set, r, &all);
        r->samples_mean += stats.samples_mean / set->seeds;
        if (stats.noise_bound > r->bound_max) r->bound_max = stats.noise_bound;
        if (stats.samples_done > r->samples_max) r->samples_max = (uint32_t)stats.samples_done;
        if (seed > set->rounds) continue;
        snell_render_desc plain = desc;
        plain.noise = 0;
        plain.samples = (uint32_t)stats.samples_done;
        start = cpu_seconds();
        must(snell_render(scene, &plain, made));
        r->uniform_seconds += (cpu_seconds() - start) / set->rounds;
    }
    r->rated = (uint32_t)all.count;
    if (all.count > 0) {
        qsort(all.of, all.count, sizeof *all.of, ascending);
        r->median = all.of[all.count / 2];
        r->worst = all.of[all.count - 1];
    }
    free(all.of);
    free(reference);
    snell_film_destroy(made);
    snell_scene_destroy(scene);
}

/* ---- output ---- */

static double share(uint32_t part, uint32_t of) { return of ? (double)part / of : 1; }

static void print(const subject *s, const result *r, const settings *set, bool first) {
    if (set->json) {
        printf("%s{\"scene\": \"%s\", \"pairs\": %u, \"within\": %.5f, \"done\": %.5f, "
               "\"done_within\": %.5f, \"median\": %.4f, \"worst\": %.3f, \"bound_max\": %.5f, "
               "\"samples_mean\": %.1f, \"samples_max\": %u, \"adaptive_seconds\": %.3f, "
               "\"uniform_seconds\": %.3f}",
               first ? "[" : ",\n ", s->name, r->pairs, share(r->within, r->pairs),
               share(r->done, r->pairs), share(r->done_within, r->done), r->median, r->worst,
               r->bound_max, r->samples_mean, r->samples_max, r->adaptive_seconds,
               r->uniform_seconds);
    } else {
        printf("%-12s %6u %7.2f%% %7.2f%% %7.2f%% %7.3f %6.2f %8.1f %7u %9.2f %9.2f", s->name,
               r->pairs, 100 * share(r->within, r->pairs), 100 * share(r->done, r->pairs),
               100 * share(r->done_within, r->done), r->median, r->worst, r->samples_mean,
               r->samples_max, r->adaptive_seconds, r->uniform_seconds);
        if (r->adaptive_seconds > 0) printf(" %6.2f", r->uniform_seconds / r->adaptive_seconds);
        putchar('\n');
    }
    fflush(stdout);
}

static bool number(const char *text, double min, double max, double *out) {
    char *end;
    *out = strtod(text, &end);
    return *text && *end == '\0' && *out >= min && *out <= max;
}

static int usage(void) {
    fprintf(stderr,
            "usage: bench-noise [--size N] [--seeds N] [--noise P] [--samples N] [--reference N]\n"
            "                   [--rounds N] [--threads N] [--cache FOLDER] [--json] [SCENE]...\n"
            "scenes:");
    for (int i = 0; i < SUBJECTS; i++) fprintf(stderr, " %s", subjects[i].name);
    fputc('\n', stderr);
    return 2;
}

static bool read_option(char **at, settings *set) {
    static const char *const names[] = {"--size",      "--seeds",  "--noise",  "--samples",
                                        "--reference", "--rounds", "--threads"};
    uint32_t *const whole[] = {&set->size,      &set->seeds,  NULL,         &set->samples,
                               &set->reference, &set->rounds, &set->threads};
    double value;
    if (at[1] == NULL) return false;
    if (strcmp(at[0], "--cache") == 0) {
        set->cache = at[1];
        return true;
    }
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (strcmp(at[0], names[i]) != 0) continue;
        bool fine = number(at[1], whole[i] ? 0 : 1e-6, whole[i] ? 1 << 20 : 1, &value);
        if (whole[i])
            *whole[i] = (uint32_t)value;
        else
            set->noise = value;
        return fine;
    }
    return false;
}

int main(int argc, char **argv) {
    settings set = {.size = 128,
                    .seeds = 50,
                    .samples = 16384,
                    .reference = 65536,
                    .rounds = 3,
                    .noise = 0.01,
                    .cache = "."};
    bool wanted[SUBJECTS] = {false}, some = false, first = true;
    for (int i = 1; i < argc; i++) {
        int k = 0;
        while (k < SUBJECTS && strcmp(subjects[k].name, argv[i]) != 0) k++;
        if (k < SUBJECTS) {
            wanted[k] = some = true;
        } else if (strcmp(argv[i], "--json") == 0) {
            set.json = true;
        } else if (read_option(argv + i, &set)) {
            i++;
        } else {
            return usage();
        }
    }
    if (set.size < 1 || set.seeds < 1 || set.samples < 16 || set.reference < 16) return usage();
    snell_context_desc machine = SNELL_INIT(context_desc);
    machine.thread_count = set.threads;
    snell_context *context;
    must(snell_context_create(&machine, &context));
    if (!set.json)
        printf("%ux%u, noise %g, at most %u samples, %u seeds, reference of %u samples\n"
               "%-12s %6s %8s %8s %8s %7s %6s %8s %7s %9s %9s %6s\n",
               set.size, set.size, set.noise, set.samples, set.seeds, set.reference, "scene",
               "pairs", "within", "done", "truly", "median", "worst", "samples", "most", "adaptive",
               "uniform", "times");
    for (int i = 0; i < SUBJECTS; i++) {
        if (some && !wanted[i]) continue;
        result r;
        measure(context, &subjects[i], &set, &r);
        print(&subjects[i], &r, &set, first);
        first = false;
    }
    if (set.json) puts(first ? "[]" : "]");
    snell_context_destroy(context);
    return 0;
}
