/* No leaks: no ray from inside a closed mesh gets out, aimed anywhere, at shared edges, or at
 * shared vertices; near the origin and far from it, turned and mirrored; of meshes with even, uneven,
 * thin and long triangles. bench/leaks.c asks the same of many more rays. */
#include "accel_test.h"
#include "leaks.h"

static size_t ray_count(void) {
    if (SANITIZED) return 2000;
    return test_full() ? 3000000 : 20000;
}

static size_t count_all(const leak_case *c, size_t count) {
    size_t leaks = 0;
    for (leak_aim at = 0; at < LEAK_AIMS; at++) {
        size_t found = leak_count(c, SNELL_ISA_AUTO, at, 17 + 1000 * (uint64_t)at, count, NULL);
        printf("%zu rays at %s of the %s %s: %zu leaks\n", count, leak_aim_names[at], c->type->name,
               leak_place_names[c->place], found);
        leaks += found;
    }
    return leaks;
}

static void nothing_leaks(void **state) {
    (void)state;
    size_t leaks = 0;
    for (size_t i = 0; i < LEAK_MESHES; i++)
        for (leak_place place = 0; place < LEAK_PLACES; place++) {
            leak_case c;
            assert_true(leak_case_make(&c, &leak_mesh_types[i], place, NULL));
            leaks += count_all(&c, ray_count());
            leak_case_clear(&c);
        }
    assert_int_equal(leaks, 0);
}

/* Two that once did, in 6e7: vertices 100 m off, sheared for a hit 1 m away. */
static void what_leaked_once_does_not(void **state) {
    (void)state;
    static const snell_isa isas[] = {SNELL_ISA_SCALAR, SNELL_ISA_AVX2, SNELL_ISA_AVX512};
    const ray rays[2] = {
        ray_make((vec3){-0x1.00d90ep+4f, 0x1.1f3fbep+5f, 0x1.ea669ap+2f},
                 (vec3){-0x1.7f0ff6p-2f, 0x1.d1b598p-1f, -0x1.232658p-1f}, 0, INFINITY),
        ray_make((vec3){-0x1.975cd6p+1f, 0x1.ff5b6p+2f, 0x1.106628p+1f},
                 (vec3){0x1.385c36p-1f, 0x1.66e25cp+0f, -0x1.434702p-3f}, 0, INFINITY)};
    size_t needle = 0;
    while (strcmp(leak_mesh_types[needle].name, "needle") != 0) needle++;
    leak_case c;
    assert_true(leak_case_make(&c, &leak_mesh_types[needle], LEAK_INSTANCE, NULL));
    for (size_t i = 0; i < 3; i++) {
        hit hits[2];
        uint8_t blocked[2];
        accel_trace(c.accel, isas[i], rays, hits, 2, NULL);
        accel_occluded(c.accel, isas[i], rays, blocked, 2, NULL);
        for (int k = 0; k < 2; k++) {
            assert_true(hits[k].instance == 0 && blocked[k]);
            assert_true(fabsf(hits[k].t - 1) < 1e-4f);
        }
    }
    leak_case_clear(&c);
}

static int compare_edges(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Each edge of a triangle is that of just one other one, the other way round. */
static bool is_closed(const mesh_desc *mesh) {
    size_t count = mesh->indices_count;
    uint64_t *edges = calloc(2 * count, sizeof *edges), *back = edges + count;
    assert_non_null(edges);
    for (size_t i = 0; i < count; i++) {
        uint64_t a = mesh->indices[i], b = mesh->indices[i % 3 == 2 ? i - 2 : i + 1];
        edges[i] = a << 32 | b;
        back[i] = b << 32 | a;
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    qsort(back, count, sizeof *back, compare_edges);
    bool closed = memcmp(edges, back, count * sizeof *edges) == 0;
    for (size_t i = 1; i < count; i++) closed = closed && edges[i] != edges[i - 1];
    free(edges);
    return closed;
}

/* What the other test rests on: the meshes are closed, and a hole in the tree's mesh is a leak. */
static void a_hole_would_be_seen(void **state) {
    (void)state;
    for (size_t i = 0; i < LEAK_MESHES; i++) {
        leak_case c;
        assert_true(leak_case_make(&c, &leak_mesh_types[i], LEAK_NEAR, NULL));
        assert_true(is_closed(&c.mesh));
        mesh_desc holed = c.mesh;
        holed.indices_count -= 3 * 1500;
        assert_false(is_closed(&holed));
        accel_destroy(c.accel);
        c.accel = NULL;
        accel_geometry geometry = {.type = &primitive_mesh, .desc = &holed};
        accel_instance instance = {0, ~0u, true, transform_identity(), transform_identity(), NULL};
        accel_input input = {&geometry, 1, &instance, 1};
        accel_options options = {0};
        assert_int_equal(accel_build(&input, &options, NULL, &c.accel), SNELL_OK);
        for (leak_aim at = 0; at < LEAK_AIMS; at++)
            assert_true(leak_count(&c, SNELL_ISA_AUTO, at, 3, 20000, NULL) > 0);
        leak_case_clear(&c);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_hole_would_be_seen),
                                       cmocka_unit_test(nothing_leaks),
                                       cmocka_unit_test(what_leaked_once_does_not)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
