/* No leaks: no ray from inside a closed mesh gets out, aimed anywhere, at shared edges, or at
 * shared vertices; near the origin and far from it, where float vertices lie on a coarse grid and
 * many triangles are flat or have no area. */
#include "accel_test.h"

static const dvec3 centers[] = {{0, 0, 0}, {148376, 1234, -223423}};
typedef enum aim { AIM_ANYWHERE, AIM_EDGE_MIDDLE, AIM_EDGE, AIM_VERTEX, AIM_COUNT } aim;
static const char *const aim_names[] = {"random points", "middles of edges", "shared edges",
                                        "shared vertices"};

static vec3 choose_target(const mesh_desc *mesh, aim at, rng *r) {
    const uint32_t *index =
        mesh->indices + 3 * (size_t)rng_below(r, (uint32_t)mesh_triangle_count(mesh));
    uint32_t corner = rng_below(r, 3);
    dvec3 a = dvec3_from(mesh->positions[index[corner]]);
    dvec3 b = dvec3_from(mesh->positions[index[(corner + 1) % 3]]);
    dvec3 c = dvec3_from(mesh->positions[index[(corner + 2) % 3]]);
    double u = 0, v = 0;
    if (at == AIM_EDGE_MIDDLE) u = 0.5;
    if (at == AIM_EDGE) u = rng_unit(r);
    if (at == AIM_ANYWHERE) u = rng_unit(r), v = (1 - u) * rng_unit(r);
    dvec3 p = dvec3_add(dvec3_scale(a, 1 - u - v), dvec3_add(dvec3_scale(b, u), dvec3_scale(c, v)));
    return vec3_from(p);
}

static ray choose_ray(const mesh_desc *mesh, dvec3 center, aim at, rng *r) {
    vec3 target = choose_target(mesh, at, r), o;
    dvec3 offset;
    do {
        offset = dvec3_from(rng_vec3(r, 1.8));
    } while (dvec3_length(offset) > 1.8);
    o = vec3_from(dvec3_add(center, offset));
    return ray_make(o, vec3_sub(target, o), 0, INFINITY);
}

static size_t count_leaks(const accel *a, snell_isa isa, const mesh_desc *mesh, dvec3 center,
                          aim at, size_t count) {
    enum { BATCH = 1000 };
    static ray rays[BATCH];
    static hit hits[BATCH];
    static uint8_t blocked[BATCH];
    rng r = {(uint64_t)at * 1000 + 17};
    size_t leaks = 0;
    for (size_t done = 0; done < count; done += BATCH) {
        for (size_t i = 0; i < BATCH; i++) rays[i] = choose_ray(mesh, center, at, &r);
        accel_trace(a, isa, rays, hits, BATCH, NULL);
        accel_occluded(a, isa, rays, blocked, BATCH, NULL);
        for (size_t i = 0; i < BATCH; i++) leaks += hits[i].instance == NO_ID || !blocked[i];
    }
    return leaks;
}

/* The same mesh turned, sheared and mirrored: rays are brought to it by a rounded transform. Aimed at
 * what the transform makes of its edges and vertices. */
static void nothing_leaks_from_an_instance(void **state) {
    (void)state;
    size_t count = test_full() ? 10000000 : 100000, leaks = 0;
    const transform to_world = {
        {{1.3f, -0.4f, 0.2f, 51}, {0.7f, 0.9f, -0.1f, -7}, {0.3f, 0.2f, -1.1f, 1003}}};
    test_scene *s = scene_create();
    mesh_desc *mesh = scene_add_uv_sphere(s, 200, 200, 2, centers[0]);
    scene_add_instance(s, 0, &to_world);
    accel *a = scene_build(s, 0, 0, NULL);
    for (aim at = 0; at < AIM_COUNT; at++) {
        rng r = {at + 100u};
        size_t found = 0;
        for (size_t i = 0; i < count; i++) {
            ray local = choose_ray(mesh, centers[0], at, &r);
            dvec3 o = transform_point(&to_world, dvec3_from(local.o));
            dvec3 d = transform_vector(&to_world, dvec3_from(local.d));
            ray world = ray_make(vec3_from(o), vec3_from(d), 0, INFINITY);
            hit h;
            accel_trace(a, SNELL_ISA_AUTO, &world, &h, 1, NULL);
            found += h.instance == NO_ID;
        }
        printf("%zu rays at %s of an instance: %zu leaks\n", count, aim_names[at], found);
        leaks += found;
    }
    accel_destroy(a);
    scene_destroy(s);
    assert_int_equal(leaks, 0);
}

static void nothing_leaks(void **state) {
    (void)state;
    size_t count = test_full() ? 10000000 : 100000, leaks = 0;
    for (size_t i = 0; i < COUNT_OF(centers); i++) {
        test_scene *s = scene_create();
        mesh_desc *mesh = scene_add_uv_sphere(s, 200, 200, 2, centers[i]);
        scene_add_instance(s, 0, NULL);
        accel *a = scene_build(s, 0, 0, NULL);
        for (aim at = 0; at < AIM_COUNT; at++) {
            size_t found = count_leaks(a, SNELL_ISA_AUTO, mesh, centers[i], at, count);
            printf("%zu rays at %s, centre %g %g %g: %zu leaks\n", count, aim_names[at],
                   centers[i].x, centers[i].y, centers[i].z, found);
            leaks += found;
        }
        accel_destroy(a);
        scene_destroy(s);
    }
    assert_int_equal(leaks, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(nothing_leaks),
                                       cmocka_unit_test(nothing_leaks_from_an_instance)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
