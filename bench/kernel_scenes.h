/* Scenes for the kernel benchmark: one mesh, or many spheres. */
#ifndef SNELL_BENCH_KERNEL_SCENES_H
#define SNELL_BENCH_KERNEL_SCENES_H

#include "accel/accel.h"
#include "geometry/mesh.h"

typedef struct bench_sphere {
    vec3 center;
    float radius;
} bench_sphere;

typedef struct bench_scene {
    const char *name;
    vec3 *positions; /* a mesh, or */
    uint32_t *indices;
    size_t position_count, index_count;
    bench_sphere *spheres; /* spheres */
    size_t sphere_count;
} bench_scene;

/* false: no memory, or the file cannot be read (errno). Free with bench_scene_free, also then. */
bool bench_scene_blob(bench_scene *s, uint32_t columns, uint32_t rows); /* a noisy sphere */
bool bench_scene_balls(bench_scene *s, uint32_t depth);                 /* the sphereflake */
bool bench_scene_obj(bench_scene *s, const char *path); /* v and f lines only, polygons as fans */
void bench_scene_free(bench_scene *s);
bounds3 bench_scene_bounds(const bench_scene *s);

#endif
