#include "kernel_scenes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "maths/functions.h"

static bool allocate(bench_scene *s, size_t positions, size_t indices, size_t spheres) {
    s->positions = memory_resize(NULL, positions, sizeof *s->positions);
    s->indices = memory_resize(NULL, indices, sizeof *s->indices);
    s->spheres = memory_resize(NULL, spheres, sizeof *s->spheres);
    s->position_count = positions, s->index_count = indices;
    return s->positions && s->indices && s->spheres;
}

/* ---- the blob ---- */

static vec3 blob_point(double latitude, double longitude) {
    dvec3 n = {fn_sin(latitude) * fn_cos(longitude), -fn_cos(latitude),
               fn_sin(latitude) * fn_sin(longitude)};
    double radius = 1;
    for (int octave = 0; octave < 5; octave++) {
        double f = 3.0 * (1 << octave), size = 0.15 / (1 << octave);
        radius += size * fn_sin(f * n.x + octave) * fn_sin(f * n.y + 2) * fn_sin(f * n.z + 1);
    }
    return vec3_from(dvec3_scale(n, radius));
}

bool bench_scene_blob(bench_scene *s, uint32_t columns, uint32_t rows) {
    *s = (bench_scene){.name = "blob"};
    if (!allocate(s, (size_t)columns * (rows + 1), (size_t)columns * rows * 6, 0)) return false;
    vec3 *p = s->positions;
    uint32_t *index = s->indices;
    for (uint32_t i = 0; i <= rows; i++)
        for (uint32_t j = 0; j < columns; j++)
            *p++ = blob_point(PI * i / rows, 2 * PI * j / columns);
    for (uint32_t i = 0; i < rows; i++)
        for (uint32_t j = 0; j < columns; j++) {
            uint32_t a = i * columns + j, b = i * columns + (j + 1) % columns;
            const uint32_t quad[6] = {a, a + columns, b, b, a + columns, b + columns};
            memcpy(index, quad, sizeof quad);
            index += 6;
        }
    return true;
}

/* ---- the sphereflake: every ball carries nine of a third of its radius, six around its equator and
 * three above (after Eric Haines's Standard Procedural Databases, 1987) ---- */

static void add_balls(bench_scene *s, dvec3 center, double radius, dvec3 axis, uint32_t depth) {
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

bool bench_scene_balls(bench_scene *s, uint32_t depth) {
    *s = (bench_scene){.name = "balls"};
    size_t count = 1, level = 1;
    for (uint32_t i = 0; i < depth; i++) count += level *= 9;
    if (!allocate(s, 0, 0, count)) return false;
    add_balls(s, (dvec3){0, 0, 0}, 1, (dvec3){0, 1, 0}, depth);
    return true;
}

/* ---- OBJ ---- */

typedef struct obj_reader {
    bench_scene *scene;
    size_t position_capacity, index_capacity;
} obj_reader;

static bool add_position(obj_reader *r, const char *text) {
    bench_scene *s = r->scene;
    vec3 p;
    if (sscanf(text, "%f %f %f", &p.x, &p.y, &p.z) != 3) return false;
    if (!ARRAY_GROW(s->positions, s->position_count, r->position_capacity, 1)) return false;
    s->positions[s->position_count++] = p;
    return true;
}

static bool add_face(obj_reader *r, char *text) {
    bench_scene *s = r->scene;
    uint32_t corners[3], count = 0;
    char *rest = NULL;
    for (char *word = strtok_r(text, " \t\r\n", &rest); word;
         word = strtok_r(NULL, " \t\r\n", &rest)) {
        long number = strtol(word, NULL, 10), size = (long)s->position_count;
        long index = number < 0 ? size + number : number - 1;
        if (index < 0 || index >= size) return false;
        corners[count < 2 ? count : 2] = (uint32_t)index;
        if (++count < 3) continue;
        if (!ARRAY_GROW(s->indices, s->index_count, r->index_capacity, 3)) return false;
        memcpy(s->indices + s->index_count, corners, sizeof corners);
        s->index_count += 3;
        corners[1] = corners[2];
    }
    return true;
}

bool bench_scene_obj(bench_scene *s, const char *path) {
    *s = (bench_scene){.name = path};
    FILE *file = fopen(path, "r");
    if (file == NULL) return false;
    obj_reader r = {.scene = s};
    char line[4096];
    bool ok = true;
    while (ok && fgets(line, sizeof line, file)) {
        if (strncmp(line, "v ", 2) == 0) ok = add_position(&r, line + 2);
        if (strncmp(line, "f ", 2) == 0) ok = add_face(&r, line + 2);
    }
    fclose(file);
    if (!ok || s->index_count == 0) errno = EINVAL;
    return ok && s->index_count > 0;
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
