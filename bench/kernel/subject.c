#include "subject.h"

#include <stdlib.h>

#include "base/memory.h"
#include "maths/functions.h"
#include "parts.h"

static const float key_times[2] = {0, 1};

static void describe_deforming(subject *b) {
    const bench_scene *s = &b->scene;
    double height = (double)b->bounds.max.y - (double)b->bounds.min.y;
    b->keys = bench_need(memory_resize(NULL, 2 * s->position_count, sizeof *b->keys));
    for (size_t i = 0; i < s->position_count; i++) {
        dvec3 p = dvec3_from(s->positions[i]);
        double turn = (p.y - (double)b->bounds.min.y) / height, c = fn_cos(turn), n = fn_sin(turn);
        b->keys[i] = s->positions[i];
        b->keys[s->position_count + i] = (vec3){(float)(1.2 * (c * p.x - n * p.z)),
                                                s->positions[i].y, (float)(n * p.x + c * p.z)};
    }
    b->mesh.positions = b->keys;
    b->mesh.positions_count = 2 * s->position_count;
    b->mesh.key_times = key_times;
    b->mesh.key_times_count = 2;
    b->deforming = bench_need(deforming_create(&b->mesh, 0, 1));
    b->geometries[0] = (accel_geometry){.type = &primitive_deforming, .desc = b->deforming};
}

static void describe_mesh(subject *b, bool deforming) {
    const bench_scene *s = &b->scene;
    b->mesh = (mesh_desc){.positions = s->positions,
                          .positions_count = s->position_count,
                          .indices = s->indices,
                          .indices_count = s->index_count};
    b->geometries[0] = (accel_geometry){.type = primitive_find("mesh"), .desc = &b->mesh};
    if (deforming) describe_deforming(b);
}

static void describe_spheres(subject *b) {
    const bench_scene *s = &b->scene;
    const primitive_type *type = primitive_find("sphere");
    b->sphere_descs = bench_need(memory_zeroed(s->sphere_count, type->info.desc_size));
    for (size_t i = 0; i < s->sphere_count; i++) {
        char *desc = (char *)b->sphere_descs + i * type->info.desc_size;
        desc_init(&type->info, desc);
        snell_param center = {
            .name = "center", .kind = SNELL_PARAM_VEC3, .value.v = s->spheres[i].center};
        snell_param radius = {
            .name = "radius", .kind = SNELL_PARAM_FLOAT, .value.f = s->spheres[i].radius};
        if (desc_set(&type->info, desc, &center) || desc_set(&type->info, desc, &radius))
            bench_die(error_last()->text);
        b->geometries[i] = (accel_geometry){.type = type, .desc = desc};
    }
}

static size_t geometry_count(const subject *b) {
    return b->scene.sphere_count ? b->scene.sphere_count : 1;
}

void subject_make(subject *b, const char *name, double detail, bool deforming) {
    *b = (subject){0};
    bench_scene_make(&b->scene, name, detail);
    b->bounds = bench_scene_bounds(&b->scene);
    b->size = dvec3_length(dvec3_sub(dvec3_from(b->bounds.max), dvec3_from(b->bounds.min)));
    size_t count = geometry_count(b);
    b->geometries = bench_need(memory_zeroed(count, sizeof *b->geometries));
    b->instances = bench_need(memory_zeroed(count, sizeof *b->instances));
    for (size_t i = 0; i < count; i++)
        b->instances[i] = (accel_instance){(uint32_t)i,          ~0u, true, transform_identity(),
                                           transform_identity(), NULL};
    if (b->scene.sphere_count)
        describe_spheres(b);
    else
        describe_mesh(b, deforming);
}

double subject_build(subject *b, uint32_t leaf_size, accel_quality quality) {
    size_t count = geometry_count(b);
    accel_input input = {b->geometries, count, b->instances, count};
    accel_options options = {.leaf_size = leaf_size, .quality = quality};
    thread_pool *pool;
    if (thread_pool_create(0, &pool)) bench_die(error_last()->text);
    accel_destroy(b->accel);
    double start = time_seconds();
    if (accel_build(&input, &options, pool, &b->accel)) bench_die(error_last()->text);
    double seconds = time_seconds() - start;
    thread_pool_destroy(pool);
    return seconds;
}

void subject_free(subject *b) {
    accel_destroy(b->accel);
    free(b->sphere_descs);
    free(b->keys);
    free(b->deforming);
    free(b->geometries);
    free(b->instances);
    bench_scene_free(&b->scene);
}

size_t subject_count(const subject *b) {
    return b->scene.sphere_count ? b->scene.sphere_count : b->scene.index_count / 3;
}

const vec3 *subject_positions(const subject *b, uint32_t key) {
    return b->deforming ? b->keys + key * b->scene.position_count : b->scene.positions;
}

void subject_corners(const subject *b, uint32_t triangle, float time, dvec3 out[3]) {
    const uint32_t *index = b->scene.indices + 3 * (size_t)triangle;
    for (int i = 0; i < 3; i++) {
        out[i] = dvec3_from(subject_positions(b, 0)[index[i]]);
        if (b->deforming == NULL) continue;
        dvec3 to = dvec3_from(subject_positions(b, 1)[index[i]]);
        out[i] = dvec3_add(out[i], dvec3_scale(dvec3_sub(to, out[i]), (double)time));
    }
}

dvec3 subject_normal(const subject *b, const hit *h, dvec3 p, float time) {
    if (b->scene.sphere_count)
        return dvec3_normalize(dvec3_sub(p, dvec3_from(b->scene.spheres[h->instance].center)));
    dvec3 v[3];
    subject_corners(b, h->primitive, time, v);
    return dvec3_normalize(dvec3_cross(dvec3_sub(v[1], v[0]), dvec3_sub(v[2], v[0])));
}
