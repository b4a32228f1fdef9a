/* Pieces that the scenes of the kernel benchmark are made of. They are added to a scene's mesh; no
 * memory ends the program. */
#ifndef SNELL_BENCH_KERNEL_PARTS_H
#define SNELL_BENCH_KERNEL_PARTS_H

#include "../../tests/random_numbers.h"
#include "scenes.h"

/* Never returns. */
_Noreturn void bench_die(const char *what);
void *bench_need(void *memory); /* or ends the program */

uint32_t bench_add_vertex(bench_scene *s, dvec3 p);
void bench_add_triangle(bench_scene *s, uint32_t a, uint32_t b, uint32_t c);
void bench_add_quad(bench_scene *s, dvec3 a, dvec3 b, dvec3 c, dvec3 d);
void bench_add_box(bench_scene *s, dvec3 low, dvec3 high);

/* Where the point (u, v) of the unit square lies. */
typedef dvec3 bench_sheet(const void *user, double u, double v);
/* 2 * columns * rows triangles. closed: u = 1 is u = 0 again. */
void bench_add_sheet(bench_scene *s, uint32_t columns, uint32_t rows, bool closed,
                     bench_sheet *place, const void *user);

/* Where a unit direction from the middle of a closed body leads. */
typedef dvec3 bench_body(const void *user, dvec3 direction);
/* A closed body of 12 * n * n triangles: the grid of a cube's faces. */
void bench_add_body(bench_scene *s, uint32_t n, bench_body *place, const void *user);

/* A tube along rings, `around` corners each: 2 * around * (count - 1) triangles, a tip (radius 0 at
 * the end) half as many in its last length. Its ends are open. */
typedef struct bench_ring {
    dvec3 center;
    double radius;
} bench_ring;
void bench_add_tube(bench_scene *s, const bench_ring *rings, uint32_t count, uint32_t around);

/* Turned about the vertical through `at`; at detail 1 straight from point to point of the profile,
 * with `around` corners; flutes: grooves around it, 0: none. */
typedef struct bench_profile {
    double radius, height;
} bench_profile;
void bench_add_lathe(bench_scene *s, dvec3 at, const bench_profile *profile, uint32_t count,
                     uint32_t around, uint32_t flutes, double detail);

/* `usual` at detail 1, at least `least`: the square of it grows with detail. */
uint32_t bench_steps(uint32_t usual, double detail, uint32_t least);

/* Gradient noise, that of the texture: -1..1, one feature per unit. */
double bench_noise(dvec3 p);
/* The sum of gain^i noise(2^i p); ridged: of gain^i (1 - 2 |noise|), which has sharp crests. */
double bench_noise_sum(dvec3 p, uint32_t octaves, double gain, bool ridged);

#endif
