/* What the tests of the acceleration structure share: random numbers, scenes, and the hit rule once
 * more in its plainest form, one primitive at a time without any tree. */
#ifndef SNELL_TESTS_ACCEL_TEST_H
#define SNELL_TESTS_ACCEL_TEST_H

#include <float.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "accel/accel.h"
#include "accel/layout.h" /* BOX_*, and nothing else */
#include "geometry/mesh.h"
#include "random_numbers.h"

#define COUNT_OF(array) (sizeof(array) / sizeof *(array))

/* Where the address sanitizer looks on, a few rays show as much. */
#if defined(__SANITIZE_ADDRESS__)
#define SANITIZED 1
#else
#define SANITIZED 0
#endif

/* More of everything where SNELL_FULL is set. */
static inline bool test_full(void) {
    const char *full = getenv("SNELL_FULL");
    return full != NULL && full[0] != '\0' && strcmp(full, "0") != 0;
}

/* ---- scenes ---- */

enum { SCENE_CAPACITY = 512 };

typedef struct test_scene {
    accel_geometry geometries[SCENE_CAPACITY];
    accel_instance instances[SCENE_CAPACITY];
    void *owned[4 * SCENE_CAPACITY];
    size_t geometry_count, instance_count, owned_count;
} test_scene;

static inline void *scene_own(test_scene *s, void *memory) {
    assert_non_null(memory);
    assert_true(s->owned_count < COUNT_OF(s->owned));
    s->owned[s->owned_count++] = memory;
    return memory;
}

static inline test_scene *scene_create(void) {
    test_scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    return s;
}

static inline void scene_destroy(test_scene *s) {
    for (size_t i = 0; i < s->owned_count; i++) free(s->owned[i]);
    free(s);
}

static inline uint32_t scene_add_geometry(test_scene *s, const primitive_type *type,
                                          const void *desc) {
    assert_non_null(type);
    assert_true(s->geometry_count < SCENE_CAPACITY);
    s->geometries[s->geometry_count] = (accel_geometry){.type = type, .desc = desc};
    return (uint32_t)s->geometry_count++;
}

/* to_world NULL: the identity. */
static inline uint32_t scene_add_instance(test_scene *s, uint32_t geometry,
                                          const transform *to_world) {
    assert_true(s->instance_count < SCENE_CAPACITY);
    accel_instance *instance = &s->instances[s->instance_count];
    *instance = (accel_instance){.geometry = geometry,
                                 .mask = ~0u,
                                 .identity = to_world == NULL,
                                 .to_world = transform_identity(),
                                 .to_local = transform_identity()};
    if (to_world) {
        instance->to_world = *to_world;
        assert_true(transform_inverse(to_world, &instance->to_local));
    }
    return (uint32_t)s->instance_count++;
}

/* Room for a mesh of this size, to be filled in by the caller. */
static inline mesh_desc *scene_add_mesh(test_scene *s, size_t vertex_count, size_t triangle_count) {
    mesh_desc *mesh = scene_own(s, calloc(1, sizeof *mesh));
    mesh->positions_count = vertex_count;
    mesh->indices_count = 3 * triangle_count;
    mesh->positions = scene_own(s, calloc(vertex_count + 1, sizeof(vec3)));
    mesh->indices = scene_own(s, calloc(3 * triangle_count + 1, sizeof(uint32_t)));
    scene_add_geometry(s, primitive_find("mesh"), mesh);
    return mesh;
}
static inline vec3 *mesh_positions(mesh_desc *mesh) { return (vec3 *)(uintptr_t)mesh->positions; }
static inline uint32_t *mesh_indices(mesh_desc *mesh) {
    return (uint32_t *)(uintptr_t)mesh->indices;
}

/* A shape with one vector and one number set. */
static inline uint32_t scene_add_shape(test_scene *s, const char *name, const char *vector_name,
                                       vec3 vector, const char *number_name, float number) {
    const primitive_type *type = primitive_find(name);
    assert_non_null(type);
    void *desc = scene_own(s, calloc(1, type->info.desc_size));
    desc_init(&type->info, desc);
    snell_param v = {.name = vector_name, .kind = SNELL_PARAM_VEC3, .value.v = vector};
    snell_param f = {.name = number_name, .kind = SNELL_PARAM_FLOAT, .value.f = number};
    if (vector_name) assert_int_equal(desc_set(&type->info, desc, &v), SNELL_OK);
    if (number_name) assert_int_equal(desc_set(&type->info, desc, &f), SNELL_OK);
    assert_int_equal(desc_check(&type->info, desc, NULL), SNELL_OK);
    return scene_add_geometry(s, type, desc);
}

static inline accel *scene_build_as(const test_scene *s, const accel_options *options,
                                    thread_pool *pool) {
    accel_input input = {s->geometries, s->geometry_count, s->instances, s->instance_count};
    accel *a = NULL;
    assert_int_equal(accel_build(&input, options, pool, &a), SNELL_OK);
    return a;
}

static inline accel *scene_build(const test_scene *s, uint32_t leaf_size, uint32_t seed,
                                 thread_pool *pool) {
    return scene_build_as(s, &(accel_options){.leaf_size = leaf_size, .seed = seed}, pool);
}

/* Longitude and latitude, closed at seam and poles. */
static inline mesh_desc *scene_add_uv_sphere(test_scene *s, uint32_t columns, uint32_t rows,
                                             double radius, dvec3 center) {
    size_t vertex_count = (size_t)columns * (rows - 1) + 2;
    mesh_desc *mesh = scene_add_mesh(s, vertex_count, 2 * (size_t)columns * (rows - 1));
    vec3 *p = mesh_positions(mesh);
    uint32_t *index = mesh_indices(mesh), south = (uint32_t)vertex_count - 2, north = south + 1;
    const double pi = 3.14159265358979323846;
    for (uint32_t i = 1; i < rows; i++)
        for (uint32_t j = 0; j < columns; j++) {
            double latitude = pi * i / rows, longitude = 2 * pi * j / columns;
            p[(i - 1) * columns + j] =
                (vec3){(float)(center.x + radius * sin(latitude) * cos(longitude)),
                       (float)(center.y - radius * cos(latitude)),
                       (float)(center.z + radius * sin(latitude) * sin(longitude))};
        }
    p[south] = (vec3){(float)center.x, (float)(center.y - radius), (float)center.z};
    p[north] = (vec3){(float)center.x, (float)(center.y + radius), (float)center.z};
    for (uint32_t j = 0; j < columns; j++) {
        uint32_t k = (j + 1) % columns, last = (rows - 2) * columns;
        uint32_t caps[6] = {south, j, k, last + k, last + j, north};
        memcpy(index, caps, sizeof caps);
        index += 6;
        for (uint32_t i = 0; i + 2 < rows; i++) {
            uint32_t a = i * columns + j, b = i * columns + k;
            uint32_t quad[6] = {a, a + columns, b, b, a + columns, b + columns};
            memcpy(index, quad, sizeof quad);
            index += 6;
        }
    }
    return mesh;
}

/* ---- the hit rule, plainly ---- */

typedef struct plain_ray {
    float o[3], d[3], inv[3], t_min, t_max;
} plain_ray;

static inline plain_ray plain_ray_make(vec3 o, vec3 d, float t_min, float t_max) {
    return (plain_ray){{o.x, o.y, o.z}, {d.x, d.y, d.z}, {1 / d.x, 1 / d.y, 1 / d.z}, t_min, t_max};
}

/* Where the ray enters and leaves a box that is wider by a margin on each axis. */
static inline void plain_slabs(const plain_ray *r, bounds3 box, const float margin[3],
                               float *entry_out, float *leave_out) {
    const float low[3] = {box.min.x, box.min.y, box.min.z};
    const float high[3] = {box.max.x, box.max.y, box.max.z};
    float entry = r->t_min, leave = INFINITY;
    for (int i = 0; i < 3; i++) {
        bool flip = signbit(r->inv[i]);
        float ahead = flip ? -margin[i] : margin[i];
        float t0 = ((flip ? high[i] : low[i]) - (r->o[i] + ahead)) * r->inv[i];
        float t1 = ((flip ? low[i] : high[i]) - (r->o[i] - ahead)) * r->inv[i];
        entry = t0 > entry ? t0 : entry;
        leave = t1 < leave ? t1 : leave;
    }
    *entry_out = entry;
    *leave_out = leave * BOX_EXIT_SCALE;
}

static inline bool plain_box(const plain_ray *r, bounds3 box, float *entry) {
    const float none[3] = {0, 0, 0};
    float leave;
    plain_slabs(r, box, none, entry, &leave);
    return *entry <= (r->t_max < leave ? r->t_max : leave);
}

/* The own box of a triangle: what the watertight test may be off by is added. A ray that walks on has not
 * left it before after_t. */
static inline bool plain_own_box(const plain_ray *r, bounds3 box, const float margin[3],
                                 float after_t, float *entry) {
    const float none[3] = {0, 0, 0};
    float leave, wide_entry, wide_leave;
    plain_slabs(r, box, none, entry, &leave);
    plain_slabs(r, box, margin, &wide_entry, &wide_leave);
    if (leave < *entry) *entry = leave;
    if (wide_entry > *entry) *entry = wide_entry;
    return r->t_min <= leave && after_t <= wide_leave &&
           wide_entry <= (r->t_max < wide_leave ? r->t_max : wide_leave);
}

/* Of a mesh with this box. */
static inline void plain_margin(const plain_ray *r, bounds3 mesh, float margin[3]) {
    const float low[3] = {mesh.min.x, mesh.min.y, mesh.min.z};
    const float high[3] = {mesh.max.x, mesh.max.y, mesh.max.z};
    float reach = 0;
    for (int i = 0; i < 3; i++) {
        reach = fmaxf(reach, fabsf(low[i] - r->o[i]));
        reach = fmaxf(reach, fabsf(high[i] - r->o[i]));
    }
    for (int i = 0; i < 3; i++)
        margin[i] = reach * BOX_REACH_MARGIN + fabsf(r->o[i]) * BOX_PLACE_MARGIN;
}

static inline bool plain_triangle(const plain_ray *r, const vec3 vertex[3], float *t, float *u,
                                  float *v) {
    int kz = 0;
    if (!(fabsf(r->d[0]) > fabsf(r->d[1]))) kz = 1;
    if (!(fabsf(r->d[kz]) > fabsf(r->d[2]))) kz = 2;
    int kx = (kz + 1) % 3, ky = (kz + 2) % 3;
    float sx = r->d[kx] / r->d[kz], sy = r->d[ky] / r->d[kz], sz = 1 / r->d[kz];
    float x[3], y[3], z[3];
    for (int i = 0; i < 3; i++) {
        const float p[3] = {vertex[i].x, vertex[i].y, vertex[i].z};
        float depth = p[kz] - r->o[kz];
        x[i] = (p[kx] - r->o[kx]) - sx * depth;
        y[i] = (p[ky] - r->o[ky]) - sy * depth;
        z[i] = sz * depth;
    }
    float a = x[2] * y[1] - y[2] * x[1], b = x[0] * y[2] - y[0] * x[2],
          c = x[1] * y[0] - y[1] * x[0];
    float det = (a + b) + c;
    if (a != 0 && b != 0 && c != 0 && fabsf(det) > 1e-30f && fabsf(det) < 1e30f) {
        if ((a < 0 || b < 0 || c < 0) && (a > 0 || b > 0 || c > 0)) return false;
        *t = ((a * z[0] + b * z[1]) + c * z[2]) / det;
        *u = b / det;
        *v = c / det;
        return true;
    }
    double e = (double)x[2] * y[1] - (double)y[2] * x[1];
    double f = (double)x[0] * y[2] - (double)y[0] * x[2];
    double g = (double)x[1] * y[0] - (double)y[1] * x[0];
    if ((e < 0 || f < 0 || g < 0) && (e > 0 || f > 0 || g > 0)) return false;
    double sum = (e + f) + g;
    if (!(sum != 0)) return false;
    *t = (float)(((e * z[0] + f * z[1]) + g * z[2]) / sum);
    *u = (float)(f / sum);
    *v = (float)(g / sum);
    return true;
}

static inline bool plain_before(float t, uint32_t instance, uint32_t primitive, float t2,
                                uint32_t instance2, uint32_t primitive2) {
    if (t != t2) return t < t2;
    return instance != instance2 ? instance < instance2 : primitive < primitive2;
}

static inline void plain_offer(const ray *r, hit *best, float t, float u, float v,
                               uint32_t instance, uint32_t primitive) {
    if (!(t > r->t_min && t < r->t_max)) return;
    if (!plain_before(r->after_t, r->after_instance, r->after_primitive, t, instance, primitive))
        return;
    if (plain_before(t, instance, primitive, best->t, best->instance, best->primitive))
        *best = (hit){t, u, v, primitive, instance};
}

static inline void plain_mesh(const mesh_desc *mesh, bounds3 bounds, const plain_ray *p,
                              const ray *r, uint32_t instance, float world_entry, hit *best) {
    float margin[3];
    plain_margin(p, bounds, margin);
    for (uint32_t i = 0; i < mesh_triangle_count(mesh); i++) {
        if (instance == r->skip_instance && i == r->skip_primitive) continue;
        const vec3 vertex[3] = {mesh->positions[mesh->indices[3 * i]],
                                mesh->positions[mesh->indices[3 * i + 1]],
                                mesh->positions[mesh->indices[3 * i + 2]]};
        float t, u, v, entry;
        if (!plain_triangle(p, vertex, &t, &u, &v) || !(fabsf(t) <= FLT_MAX)) continue;
        bounds3 box = {vec3_min(vec3_min(vertex[0], vertex[1]), vertex[2]),
                       vec3_max(vec3_max(vertex[0], vertex[1]), vertex[2])};
        if (!plain_own_box(p, box, margin, r->after_t, &entry)) continue;
        t = float_max(world_entry, float_max(entry, t));
        plain_offer(r, best, t, u, v, instance, i);
    }
}

static inline void plain_part(const accel_geometry *g, uint32_t part, const plain_ray *p,
                              const ray *r, uint32_t instance, float entry, hit *best) {
    if (g->type->flat && instance == r->skip_instance && r->skip_primitive == part) return;
    local_ray local = {
        {p->o[0], p->o[1], p->o[2]}, {p->d[0], p->d[1], p->d[2]}, r->t_min, r->t_max};
    hit found = {.primitive = part};
    while (g->type->intersect(g->desc, &local, &found)) {
        plain_offer(r, best, float_max(entry, found.t), found.u, found.v, instance, part);
        local.t_min = found.t;
    }
}

/* `entry` is that of the instance's box in the world; each part, or the shape as one, has its own. */
static inline void plain_shape(const accel_geometry *g, const plain_ray *p, const ray *r,
                               uint32_t instance, float entry, hit *best) {
    for (uint32_t i = 0; i < primitive_count_of(g->type, g->desc); i++) {
        float own_entry = r->t_min;
        if (!g->type->unbounded) {
            bounds3 box = primitive_bounds_of(g->type, g->desc, i);
            if (bounds3_is_empty(box) || !plain_box(p, box, &own_entry)) continue;
        }
        plain_part(g, i, p, r, instance, float_max(own_entry, entry), best);
    }
}

/* The hit of `r` by trying everything. */
static inline hit plain_trace(const test_scene *s, const ray *r) {
    hit best = {INFINITY, 0, 0, NO_ID, NO_ID};
    plain_ray world = plain_ray_make(r->o, r->d, r->t_min, r->t_max);
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const accel_instance *in = &s->instances[i];
        const accel_geometry *g = &s->geometries[in->geometry];
        if (!(in->mask & r->mask)) continue;
        plain_ray local = world;
        if (!in->identity)
            local = plain_ray_make(vec3_from(transform_point(&in->to_local, dvec3_from(r->o))),
                                   vec3_from(transform_vector(&in->to_local, dvec3_from(r->d))),
                                   r->t_min, r->t_max);
        bool mesh = g->type->intersect == NULL;
        float entry = r->t_min;
        bounds3 box = bounds3_empty();
        if (!g->type->unbounded) {
            const mesh_desc *m = g->desc;
            if (mesh)
                for (size_t k = 0; k < m->indices_count; k++)
                    box = bounds3_add_point(box, m->positions[m->indices[k]]);
            else
                for (uint32_t k = 0; k < primitive_count_of(g->type, g->desc); k++)
                    box = bounds3_union(box, primitive_bounds_of(g->type, g->desc, k));
            bounds3 in_world = in->identity ? box : transform_bounds(&in->to_world, box);
            if (!plain_box(&world, in_world, &entry)) continue;
        }
        if (mesh)
            plain_mesh(g->desc, box, &local, r, i, entry, &best);
        else
            plain_shape(g, &local, r, i, entry, &best);
    }
    return best;
}

static inline bool same_hit(const hit *a, const hit *b) {
    return memcmp(&a->t, &b->t, sizeof a->t) == 0 && a->instance == b->instance &&
           a->primitive == b->primitive && memcmp(&a->u, &b->u, sizeof a->u) == 0 &&
           memcmp(&a->v, &b->v, sizeof a->v) == 0;
}

#endif
