/* A plain room with 15 lumpy animals: bodies of about 69,000 triangles, walls of two. */
#include "maths/functions.h"
#include "parts.h"

enum { BUNNIES = 15, KNOBS = 8 };

/* Pulls the surface out around a direction: by `size` at its middle, the less far the sharper. */
typedef struct knob {
    dvec3 toward;
    double size, sharpness;
} knob;

static const knob knobs[KNOBS] = {
    {{0.55, 0.60, 0}, 0.75, 9},                                        /* head */
    {{0.42, 0.90, 0.30}, 0.72, 55},                                    /* ears */
    {{0.42, 0.90, -0.30}, 0.72, 55}, {{0.95, 0.35, 0}, 0.28, 60},      /* nose */
    {{-0.95, -0.15, 0}, 0.30, 40},                                     /* tail */
    {{0.60, -0.75, 0.45}, 0.35, 30}, {{0.60, -0.75, -0.45}, 0.35, 30}, /* paws */
    {{-0.45, -0.55, 0}, 0.35, 5}};                                     /* haunches */

typedef struct bunny {
    dvec3 at;
    double size, cosine, sine; /* of its turn about +Y */
    dvec3 seed;                /* where its noise begins */
    knob knobs[KNOBS];
} bunny;

static dvec3 bunny_point(const void *user, dvec3 d) {
    const bunny *b = user;
    double radius = 0.62;
    for (int i = 0; i < KNOBS; i++)
        radius += b->knobs[i].size *
                  fn_exp(b->knobs[i].sharpness * (dvec3_dot(d, b->knobs[i].toward) - 1));
    dvec3 p = dvec3_add(dvec3_scale(d, 3), b->seed);
    radius *= 1 + 0.10 * bench_noise_sum(p, 3, 0.5, false);
    radius *= 1 + 0.012 * bench_noise_sum(dvec3_scale(p, 5), 2, 0.5, true); /* fur */
    p = dvec3_scale(d, radius * b->size);
    return dvec3_add(
        b->at, (dvec3){b->cosine * p.x + b->sine * p.z, p.y, b->cosine * p.z - b->sine * p.x});
}

static void add_bunny(bench_scene *s, rng *r, dvec3 feet, double size, uint32_t n) {
    double turn = 2 * PI * rng_unit(r);
    bunny b = {.at = {feet.x, feet.y + 0.74 * size, feet.z},
               .size = size,
               .cosine = fn_cos(turn),
               .sine = fn_sin(turn),
               .seed = dvec3_from(rng_vec3(r, 50))};
    for (int i = 0; i < KNOBS; i++) { /* no two alike */
        b.knobs[i] = knobs[i];
        b.knobs[i].toward = dvec3_normalize(
            dvec3_add(dvec3_normalize(knobs[i].toward), dvec3_from(rng_vec3(r, 0.08))));
        b.knobs[i].size *= 0.8 + 0.4 * rng_unit(r);
    }
    bench_add_body(s, n, bunny_point, &b);
}

void bench_scene_bunnies(bench_scene *s, double detail) {
    rng r = {2};
    uint32_t n = bench_steps(76, detail, 4);
    bench_add_box(s, (dvec3){-5, 0, -4}, (dvec3){5, 3.6, 4}); /* the room, 10 x 8 m */
    bench_add_box(s, (dvec3){-5, 0, -4}, (dvec3){5, 0.12, -3.94});
    for (int i = 0; i < 2; i++) /* shelves */
        bench_add_box(s, (dvec3){-3.6, 1 + i, -4}, (dvec3){3.6, 1.05 + i, -3.2});
    bench_add_box(s, (dvec3){-1.1, 0, -1.6}, (dvec3){1.1, 0.55, -0.4}); /* a bench */
    for (int i = 0; i < BUNNIES; i++) {
        double along = (i % 5) - 2 + 0.3 * (rng_unit(&r) - 0.5);
        dvec3 feet = i < 5    ? (dvec3){1.5 * along, 1.05 + i % 2, -3.6}
                     : i < 10 ? (dvec3){1.7 * along, i == 7 ? 0.55 : 0, -1}
                              : (dvec3){1.3 * along, 0, 0.9 + 0.5 * rng_unit(&r)};
        add_bunny(s, &r, feet, i < 5 ? 0.28 : 0.33 + 0.1 * rng_unit(&r), n);
    }
    s->camera = (bench_camera){{0.7, 1.65, 3.8}, {0, 0.85, -1}, 62};
    s->light = (dvec3){1.6, 3.3, 1.2};
}
