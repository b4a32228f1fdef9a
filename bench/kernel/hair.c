/* A ball with wavy hair: every strand a prism of three sides that runs out into a tip. */
#include "maths/functions.h"
#include "parts.h"

enum { STRANDS = 21200, RINGS = 9 }; /* 45 triangles each */

static dvec3 scalp_point(const void *user, dvec3 d) {
    (void)user;
    return d;
}

static void add_strand(bench_scene *s, rng *r, dvec3 root) {
    dvec3 x, y;
    dvec3_frame(root, &x, &y);
    double length = 0.7 + 0.5 * rng_unit(r), width = 0.0022 * (0.7 + 0.6 * rng_unit(r));
    double phase = 2 * PI * rng_unit(r), pitch = 5 + 4 * rng_unit(r);
    double lean_x = 0.5 * (rng_unit(r) - 0.5), lean_y = 0.5 * (rng_unit(r) - 0.5);
    bench_ring rings[RINGS];
    for (int i = 0; i < RINGS; i++) {
        double v = (double)i / (RINGS - 1), wave = 0.05 * v;
        double along_x = lean_x * v + wave * fn_cos(pitch * v + phase);
        double along_y = lean_y * v + wave * fn_sin(pitch * v + phase);
        dvec3 p = dvec3_scale(root, 0.99 + length * v);
        p = dvec3_add(p, dvec3_add(dvec3_scale(x, along_x), dvec3_scale(y, along_y)));
        p.y -= 0.45 * length * v * v;
        rings[i] = (bench_ring){p, i + 1 < RINGS ? width * (1 - 0.6 * v) : 0};
    }
    bench_add_tube(s, rings, RINGS, 3);
}

void bench_scene_hair(bench_scene *s, double detail) {
    rng r = {4};
    uint32_t strands = (uint32_t)(STRANDS * detail + 0.5);
    for (uint32_t i = 0; i < strands; i++) { /* evenly: Fibonacci's spiral */
        double z = 1 - 2 * (i + 0.5) / strands, flat = sqrt(1 - z * z);
        double turn = i * PI * 0.76393202250021030; /* 3 - sqrt 5 */
        add_strand(s, &r, (dvec3){flat * fn_cos(turn), z, flat * fn_sin(turn)});
    }
    bench_add_body(s, bench_steps(20, detail, 4), scalp_point, NULL);
    s->camera = (bench_camera){{1.9, 1.5, 4.6}, {0, -0.15, 0}, 48};
    s->light = (dvec3){4, 6, 3};
}
