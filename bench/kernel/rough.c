/* The two rough ones: a rock in space and a landscape. */
#include "maths/functions.h"
#include "parts.h"

/* ---- asteroid ---- */

enum { CRATERS = 90 };
typedef struct crater {
    dvec3 middle;          /* a direction */
    double radius, cosine; /* radians, and of 1.6 radii: as far as it reaches */
} crater;

/* Depth by the distance from the middle in radii: a bowl with a raised rim. */
static double crater_shape(double x) {
    if (x > 1.6) return 0;
    double bowl = 0.9 * (x * x - 1), rim = 0.25 * fn_exp(-20 * (x - 1) * (x - 1));
    return (x < 1 ? bowl : 0) + rim;
}

static dvec3 asteroid_point(const void *user, dvec3 d) {
    const crater *craters = user;
    double shape = bench_noise_sum(dvec3_scale(d, 0.9), 3, 0.5, false);
    double rough = bench_noise_sum(dvec3_scale(d, 3.1), 7, 0.62, true);
    double radius = 1 + 0.45 * shape + 0.075 * rough;
    for (int i = 0; i < CRATERS; i++) {
        double cosine = dvec3_dot(d, craters[i].middle);
        if (cosine > craters[i].cosine)
            radius += 0.35 * craters[i].radius *
                      crater_shape(fn_acos(double_min(cosine, 1)) / craters[i].radius);
    }
    return dvec3_scale((dvec3){1.25 * d.x, 0.9 * d.y, d.z}, radius);
}

void bench_scene_asteroid(bench_scene *s, double detail) {
    crater craters[CRATERS];
    rng r = {3};
    for (int i = 0; i < CRATERS; i++) {
        double z = 2 * rng_unit(&r) - 1, turn = 2 * PI * rng_unit(&r), flat = sqrt(1 - z * z);
        double radius = 0.02 + 0.3 * fn_pow(rng_unit(&r), 5);
        craters[i] =
            (crater){{flat * fn_cos(turn), flat * fn_sin(turn), z}, radius, fn_cos(1.6 * radius)};
    }
    bench_add_body(s, bench_steps(296, detail, 4), asteroid_point, craters);
    s->camera = (bench_camera){{1.3, 1.1, 3.2}, {0, -0.08, 0}, 42};
    s->light = (dvec3){-6, 5, 5};
}

/* ---- terrain ---- */

/* Ridges that get rougher with height, as in Musgrave's multifractals (Ebert et al., Texturing and
 * Modeling, chapter 16). */
static double terrain_height(double x, double z) {
    double height = 0, weight = 1, frequency = 0.28, size = 1;
    for (int i = 0; i < 10; i++) {
        dvec3 p = {frequency * x + 0.31 * i, 0.5 + 0.17 * i, frequency * z + 0.73 * i};
        double ridge = 1 - fabs(bench_noise(p));
        ridge *= ridge * weight;
        height += size * ridge;
        weight = clamp01(1.8 * ridge);
        frequency *= 2.03;
        size *= 0.56;
    }
    return 0.75 * height;
}

static dvec3 terrain_point(const void *user, double u, double v) {
    (void)user;
    double x = 10 * (u - 0.5), z = 10 * (v - 0.5);
    return (dvec3){x, terrain_height(x, z), z};
}

void bench_scene_terrain(bench_scene *s, double detail) {
    uint32_t n = bench_steps(721, detail, 4);
    bench_add_sheet(s, n, n, false, terrain_point, NULL);
    dvec3 eye = {-4.2, terrain_height(-4.2, 4.2) + 0.9, 4.2};
    s->camera = (bench_camera){eye, {0.4, 0.5, -0.4}, 55};
    s->light = (dvec3){-9, 9, -4};
}
