#include "scenes.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "maths/functions.h"
#include "parts.h"

/* ---- a noisy sphere, finely divided towards its poles ---- */

static dvec3 blob_point(const void *user, double u, double v) {
    (void)user;
    double latitude = PI * v, longitude = 2 * PI * u;
    dvec3 n = {fn_sin(latitude) * fn_cos(longitude), -fn_cos(latitude),
               fn_sin(latitude) * fn_sin(longitude)};
    double radius = 1;
    for (int octave = 0; octave < 5; octave++) {
        double f = 3.0 * (1 << octave), size = 0.15 / (1 << octave);
        radius += size * fn_sin(f * n.x + octave) * fn_sin(f * n.y + 2) * fn_sin(f * n.z + 1);
    }
    return dvec3_scale(n, radius);
}

static void make_blob(bench_scene *s, double detail) {
    uint32_t n = bench_steps(188, detail, 4);
    bench_add_sheet(s, n, n, true, blob_point, NULL);
}

/* ---- the sphereflake: every ball carries nine of a third of its radius, six around its equator
 * and three above (after Eric Haines's Standard Procedural Databases, 1987) ---- */

static void add_balls(bench_scene *s, dvec3 center, double radius, dvec3 axis, uint32_t depth) {
    if (!ARRAY_GROW(s->spheres, s->sphere_count, s->sphere_capacity, 1)) bench_die("out of memory");
    s->spheres[s->sphere_count++] = (bench_sphere){vec3_from(center), (float)radius};
    if (depth == 0) return;
    dvec3 x, y;
    dvec3_frame(axis, &x, &y);
    for (int i = 0; i < 9; i++) {
        double around = i < 6 ? i * PI / 3 : (i - 6) * 2 * PI / 3 + PI / 6;
        double up = i < 6 ? 0 : 0.95531661812450927; /* atan(sqrt 2) */
        dvec3 n = dvec3_add(
            dvec3_scale(axis, fn_sin(up)),
            dvec3_scale(dvec3_add(dvec3_scale(x, fn_cos(around)), dvec3_scale(y, fn_sin(around))),
                        fn_cos(up)));
        add_balls(s, dvec3_add(center, dvec3_scale(n, radius * 4 / 3)), radius / 3, n, depth - 1);
    }
}

static void make_balls(bench_scene *s, double detail) {
    uint32_t depth = 4;
    for (; detail >= 9 && depth < 8; detail /= 9) depth++;
    for (; detail <= 1.0 / 9 && depth > 0; detail *= 9) depth--;
    add_balls(s, (dvec3){0, 0, 0}, 1, (dvec3){0, 1, 0}, depth);
}

/* ---- all ---- */

static const struct {
    const char *name, *help;
    void (*make)(bench_scene *s, double detail);
    bool usual;
} generators[] = {
    {"atrium", "a hall of columns and ornaments, 275,000 uneven triangles", bench_scene_atrium,
     true},
    {"bunnies", "15 lumpy bodies in a plain room, 1,040,000", bench_scene_bunnies, true},
    {"asteroid", "a rough rock, 1,050,000", bench_scene_asteroid, true},
    {"terrain", "a landscape, 1,040,000", bench_scene_terrain, true},
    {"hair", "strands on a ball, 960,000 long and thin", bench_scene_hair, true},
    {"blob", "a noisy sphere, 70,688", make_blob, false},
    {"balls", "the sphereflake of 7,381 spheres", make_balls, false},
};
enum { GENERATORS = sizeof generators / sizeof *generators };

const char *bench_scene_name(uint32_t i, const char **help, bool *usual) {
    if (i >= GENERATORS) return NULL;
    *help = generators[i].help;
    *usual = generators[i].usual;
    return generators[i].name;
}

/* All of it, from a corner above; the light behind the camera's shoulder. */
static void look_from_outside(bench_scene *s) {
    bounds3 b = bench_scene_bounds(s);
    dvec3 low = dvec3_from(b.min), high = dvec3_from(b.max);
    dvec3 center = dvec3_scale(dvec3_add(low, high), 0.5);
    double size = dvec3_length(dvec3_sub(high, low));
    dvec3 back = dvec3_normalize((dvec3){1, 0.6, 1.4});
    s->camera = (bench_camera){dvec3_add(center, dvec3_scale(back, 1.2 * size)), center, 38.6};
    s->light = dvec3_add(high, dvec3_scale((dvec3){-0.3, 1, 0.2}, size));
}

void bench_scene_make(bench_scene *s, const char *name, double detail) {
    *s = (bench_scene){.name = name};
    uint32_t i = 0;
    while (i < GENERATORS && strcmp(generators[i].name, name) != 0) i++;
    if (i < GENERATORS)
        generators[i].make(s, detail);
    else
        bench_scene_file(s, name);
    if (s->camera.fov == 0) look_from_outside(s);
}

void bench_scene_free(bench_scene *s) {
    free(s->positions);
    free(s->indices);
    free(s->spheres);
    *s = (bench_scene){0};
}

bounds3 bench_scene_bounds(const bench_scene *s) {
    bounds3 b = bounds3_empty();
    for (size_t i = 0; i < s->index_count; i++)
        b = bounds3_add_point(b, s->positions[s->indices[i]]);
    for (size_t i = 0; i < s->sphere_count; i++) {
        vec3 c = s->spheres[i].center,
             r = {s->spheres[i].radius, s->spheres[i].radius, s->spheres[i].radius};
        b = bounds3_union(b, (bounds3){vec3_sub(c, r), vec3_add(c, r)});
    }
    return b;
}
