/* Samples per second, and the noise that is left after a set time, of each integrator on each scene.
 *
 *     bench-integrators [--seconds T] [--size WxH] [--threads N] [--json] SCENE...
 *
 * A scene is rendered twice with two seeds and as many samples as fit into T seconds each. Two
 * pictures a and b that share nothing but the scene differ by twice the variance of one, so the noise
 * of one is sqrt(mean((a - b)^2) / 2), here over the mean of both. It needs no reference, and says
 * nothing of what an integrator leaves out: that is the same in both. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <snell/snell.h>

typedef struct settings {
    double seconds;
    uint32_t width, height, threads;
    bool json;
} settings;

typedef struct result {
    uint32_t samples;
    double seconds; /* of one picture */
    uint64_t rays;  /* of one picture */
    double mean, noise;
} result;

static const char *const names[] = {"", "appel", "whitted", "cook", "path"};

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void must(snell_status status) {
    if (status == SNELL_OK) return;
    fprintf(stderr, "bench-integrators: %s\n", snell_last_error()->text);
    exit(1);
}

static double render(const snell_scene *scene, snell_film *film, snell_render_desc *desc,
                     uint64_t seed) {
    desc->seed = seed;
    double start = now();
    must(snell_render(scene, desc, film));
    return now() - start;
}

static uint64_t all_rays(const snell_film *film) {
    snell_render_stats s = {.struct_size = sizeof s};
    must(snell_film_get_stats(film, &s));
    return s.rays_camera + s.rays_reflected + s.rays_refracted + s.rays_shadow + s.rays_continued;
}

/* The noise of one picture over the mean of both, all three colours together. */
static void compare(const snell_film *a, const snell_film *b, result *out) {
    uint32_t width, height, channels;
    const float *p = snell_film_pixels(a, &width, &height, &channels),
                *q = snell_film_pixels(b, NULL, NULL, NULL);
    double square = 0, sum = 0;
    size_t count = (size_t)width * height;
    for (size_t i = 0; i < count; i++)
        for (uint32_t c = 0; c < 3; c++) {
            double x = (double)p[i * channels + c], y = (double)q[i * channels + c];
            square += (x - y) * (x - y);
            sum += x + y;
        }
    out->mean = sum / (6 * (double)count);
    out->noise = out->mean > 0 ? sqrt(square / (6 * (double)count)) / out->mean : 0;
}

static result measure(const snell_scene *scene, snell_film *films[2], snell_integrator which,
                      const settings *s) {
    snell_render_desc desc = {.struct_size = sizeof desc};
    must(snell_scene_settings(scene, which, &desc));
    desc.width = s->width;
    desc.height = s->height;
    desc.pixel_center = false;
    desc.samples = 1;
    double once = render(scene, films[0], &desc, 1);
    double fit = s->seconds / (once > 1e-4 ? once : 1e-4);
    desc.samples = fit < 1 ? 1 : fit > 1 << 16 ? 1 << 16 : (uint32_t)fit;
    result r = {.samples = desc.samples};
    r.seconds = (render(scene, films[0], &desc, 2) + render(scene, films[1], &desc, 3)) / 2;
    r.rays = (all_rays(films[0]) + all_rays(films[1])) / 2;
    compare(films[0], films[1], &r);
    return r;
}

static void print(const char *file, snell_integrator which, const result *r, const settings *s,
                  bool first) {
    double camera_rays = (double)r->samples * s->width * s->height;
    if (s->json) {
        printf("%s{\"scene\":\"%s\",\"integrator\":\"%s\",\"width\":%u,\"height\":%u,"
               "\"samples\":%u,\"seconds\":%.4f,\"samples_per_second\":%.0f,"
               "\"rays_per_second\":%.0f,\"rays_per_sample\":%.2f,\"noise\":%.6f}",
               first ? "[" : ",\n ", file, names[which], s->width, s->height, r->samples,
               r->seconds, camera_rays / r->seconds, (double)r->rays / r->seconds,
               (double)r->rays / camera_rays, r->noise);
        return;
    }
    printf("%-24s %-8s %7u %8.2f %10.3f %10.3f %8.2f %9.4f\n", file, names[which], r->samples,
           r->seconds, camera_rays / r->seconds / 1e6, (double)r->rays / r->seconds / 1e6,
           (double)r->rays / camera_rays, r->noise);
}

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static int usage(void) {
    fprintf(stderr, "usage: bench-integrators [--seconds T] [--size WxH] [--threads N] [--json] "
                    "SCENE...\n");
    return 2;
}

int main(int argc, char **argv) {
    settings s = {.seconds = 2, .width = 320, .height = 240};
    int at = 1;
    for (; at < argc && strncmp(argv[at], "--", 2) == 0; at++) {
        const char *value = at + 1 < argc ? argv[at + 1] : NULL;
        if (strcmp(argv[at], "--json") == 0) {
            s.json = true;
            continue;
        }
        if (value == NULL) return usage();
        if (strcmp(argv[at], "--seconds") == 0)
            s.seconds = atof(value);
        else if (strcmp(argv[at], "--threads") == 0)
            s.threads = (uint32_t)atoi(value);
        else if (strcmp(argv[at], "--size") != 0 ||
                 sscanf(value, "%ux%u", &s.width, &s.height) != 2)
            return usage();
        at++;
    }
    if (at >= argc || !(s.seconds > 0)) return usage();
    snell_context_desc desc = SNELL_INIT(context_desc);
    desc.thread_count = s.threads;
    snell_context *context;
    must(snell_context_create(&desc, &context));
    snell_film *films[2];
    for (int i = 0; i < 2; i++) must(snell_film_create(context, &films[i]));
    if (!s.json)
        printf(
            "%ux%u, %.3g s a picture; millions per second\n%-24s %-8s %7s %8s %10s %10s %8s %9s\n",
            s.width, s.height, s.seconds, "scene", "", "samples", "seconds", "samples/s", "rays/s",
            "rays/smp", "noise");
    for (int i = at; i < argc; i++) {
        snell_scene *scene;
        must(snell_scene_create(context, &scene));
        must(snell_scene_load(scene, argv[i], NULL));
        must(snell_scene_add_studio(scene, NULL, NULL));
        must(snell_scene_commit(scene, NULL, NULL));
        for (snell_integrator which = SNELL_APPEL; which <= SNELL_PATH; which++) {
            result r = measure(scene, films, which, &s);
            print(base_name(argv[i]), which, &r, &s, i == at && which == SNELL_APPEL);
            fflush(stdout);
        }
        snell_scene_destroy(scene);
    }
    if (s.json) printf("]\n");
    for (int i = 0; i < 2; i++) snell_film_destroy(films[i]);
    snell_context_destroy(context);
    return 0;
}
