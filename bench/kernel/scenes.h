/* Scenes of the kernel benchmark: one mesh, or many spheres, with a camera and a light. */
#ifndef SNELL_BENCH_KERNEL_SCENES_H
#define SNELL_BENCH_KERNEL_SCENES_H

#include "maths/vec.h"

typedef struct bench_sphere {
    vec3 center;
    float radius;
} bench_sphere;

/* Looks from eye to look, +Y up; fov: degrees, across the picture and down. */
typedef struct bench_camera {
    dvec3 eye, look;
    double fov;
} bench_camera;

typedef struct bench_scene {
    const char *name;
    vec3 *positions; /* a mesh, three indices to a triangle, or */
    uint32_t *indices;
    size_t position_count, position_capacity, index_count, index_capacity;
    bench_sphere *spheres; /* spheres */
    size_t sphere_count, sphere_capacity;
    bench_camera camera;
    dvec3 light; /* a point */
} bench_scene;

/* One of the scenes below by its name, or else the triangles of a file that snell reads, where they
 * stand at time 0. detail: 1 for the usual number of triangles, 2 for about twice as many. The same
 * name and detail give the same bits on every machine. Errors end the program. */
void bench_scene_make(bench_scene *s, const char *name, double detail);
void bench_scene_free(bench_scene *s);
bounds3 bench_scene_bounds(const bench_scene *s);
/* Name and description of scene i, NULL after the last. usual: it is measured without asking. */
const char *bench_scene_name(uint32_t i, const char **help, bool *usual);

/* The generators: s is zeroed but for its name. Where they leave the camera at 0, it and the light
 * are set to show everything from outside. */
void bench_scene_atrium(bench_scene *s, double detail);
void bench_scene_bunnies(bench_scene *s, double detail);
void bench_scene_asteroid(bench_scene *s, double detail);
void bench_scene_terrain(bench_scene *s, double detail);
void bench_scene_hair(bench_scene *s, double detail);
void bench_scene_file(bench_scene *s, const char *path);

#endif
