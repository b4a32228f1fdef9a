/* The kernel benchmark measures what it says: its scenes and rays, and the JSON of the built program. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "../bench/kernel/rays.h"
#include "base/memory.h"
#include "geometry/closure.h"
#include "sampling/sampling.h"

static const char program[] = TEST_BINARY_DIR "/bench/bench-kernel";

/* ---- scenes ---- */

static uint64_t hash_of(const bench_scene *s) {
    uint64_t h = 1;
    for (size_t i = 0; i < s->position_count; i++) {
        uint32_t bits[3];
        memcpy(bits, &s->positions[i], sizeof bits);
        for (int k = 0; k < 3; k++) h = hash_mix(h ^ bits[k]);
    }
    for (size_t i = 0; i < s->index_count; i++) h = hash_mix(h ^ s->indices[i]);
    return h;
}

/* What is measured on two machines, or by two versions, is the same. Who changes a scene writes its new
 * number here; figures from before then are of another scene. */
static void test_same_everywhere(void **state) {
    (void)state;
    static const struct {
        const char *name;
        uint64_t hash;
    } expected[] = {{"atrium", 0xad447bf285a66de7},
                    {"bunnies", 0xdc093527280423c9},
                    {"asteroid", 0xf5f89ebddbfb4ecd},
                    {"terrain", 0x9b9a984a562674a9},
                    {"hair", 0x68bbdb1419d49fe}};
    size_t others = 0;
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        bench_scene s;
        bench_scene_make(&s, expected[i].name, 0.02);
        uint64_t hash = hash_of(&s);
        if (hash != expected[i].hash)
            print_error("%s: 0x%llx\n", expected[i].name, (unsigned long long)hash);
        others += hash != expected[i].hash;
        bench_scene_free(&s);
    }
    assert_int_equal(others, 0);
}

/* As many triangles as the help says, within 3 %; and detail scales them. */
static void test_counts(void **state) {
    (void)state;
    static const struct {
        const char *name;
        double detail, triangles;
    } expected[] = {{"atrium", 1, 275e3},     {"bunnies", 0.25, 260e3}, {"asteroid", 0.25, 262.5e3},
                    {"terrain", 0.25, 260e3}, {"hair", 0.25, 240e3},    {"blob", 1, 70688}};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        bench_scene s;
        bench_scene_make(&s, expected[i].name, expected[i].detail);
        double count = (double)s.index_count / 3;
        assert_true(fabs(count / expected[i].triangles - 1) < 0.03);
        for (size_t k = 0; k < s.index_count; k++) assert_true(s.indices[k] < s.position_count);
        for (size_t k = 0; k < s.position_count; k++)
            assert_true(isfinite(s.positions[k].x + s.positions[k].y + s.positions[k].z));
        bench_scene_free(&s);
    }
    bench_scene balls;
    bench_scene_make(&balls, "balls", 1);
    assert_int_equal(balls.sphere_count, 7381);
    bench_scene_free(&balls);
}

/* Bodies are closed to the last bit where the faces of their cubes meet, and face outwards. */
static void test_closed(void **state) {
    (void)state;
    static const char *const names[] = {"asteroid", "bunnies"};
    for (int i = 0; i < 2; i++) {
        subject s;
        subject_make(&s, names[i], 0.01, false);
        mesh_closure closure;
        vec3 edge[2];
        assert_int_equal(mesh_find_closure(&s.mesh, &closure, edge), SNELL_OK);
        assert_int_equal(closure, MESH_ORIENTED);
        double volume = 0;
        for (uint32_t k = 0; k < s.scene.index_count / 3; k++) {
            dvec3 v[3];
            subject_corners(&s, k, 0, v);
            volume += dvec3_dot(v[0], dvec3_cross(v[1], v[2])) / 6;
        }
        assert_true(volume > 0);
        subject_free(&s);
    }
}

/* The triangles of a file, also in groups and instances, where they stand; other shapes are left out. */
static void test_file(void **state) {
    (void)state;
    char path[] = "/tmp/snell-bench-XXXXXX.lua";
    int handle = mkstemps(path, 4);
    assert_true(handle >= 0);
    static const char text[] =
        "local quad = mesh { positions = {0,0,0, 1,0,0, 1,1,0, 0,1,0}, indices = {0,1,2, 0,2,3} }\n"
        "local pair = group { quad, sphere { radius = 9 } }\n"
        "instance { pair, transform = transform.translate {2, 3, 4} }\n"
        "instance { pair, transform = transform.translate {5, 0, 0} }\n";
    assert_int_equal(write(handle, text, sizeof text - 1), sizeof text - 1);
    close(handle);
    bench_scene s;
    bench_scene_make(&s, path, 1);
    assert_int_equal(s.index_count, 12);
    bounds3 b = bench_scene_bounds(&s);
    assert_true(b.min.x == 2 && b.min.y == 0 && b.min.z == 0);
    assert_true(b.max.x == 6 && b.max.y == 4 && b.max.z == 4);
    bench_scene_free(&s);
    unlink(path);
}

/* ---- rays ---- */

enum { SIZE = 48 };

/* Where the camera is, and that it looks at something; rays of each kind as rays.h says. */
static void check_rays(const char *name, double least) {
    subject s;
    subject_make(&s, name, 0.02, false);
    subject_build(&s, 0, ACCEL_BALANCED);
    ray_set primary, set;
    rays_make_primary(&s, SIZE, &primary);
    assert_int_equal(primary.count, SIZE * SIZE);
    static hit hits[SIZE * SIZE];
    accel_trace(s.accel, SNELL_ISA_AUTO, primary.rays, hits, primary.count, NULL);
    size_t found = 0;
    for (size_t i = 0; i < primary.count; i++) found += hits[i].instance != NO_ID;
    if ((double)found < least * SIZE * SIZE) print_error("%s: %zu hits\n", name, found);
    assert_true((double)found >= least * SIZE * SIZE);
    for (uint32_t kind = 1; kind < RAY_KINDS; kind++) {
        rays_make(&s, kind, &primary, hits, &set);
        assert_int_equal(set.count, found);
        for (size_t i = 0, k = 0; i < primary.count; i++) {
            if (hits[i].instance == NO_ID) continue;
            const ray *from = &primary.rays[i], *r = &set.rays[k++];
            dvec3 d = dvec3_from(r->d), before = dvec3_from(from->d);
            dvec3 p = dvec3_add(dvec3_from(from->o), dvec3_scale(before, hits[i].t));
            dvec3 n = subject_normal(&s, &hits[i], p, 0), o = dvec3_from(r->o);
            if (dvec3_dot(n, before) > 0) n = dvec3_negate(n);
            assert_true(fabs(dvec3_length(dvec3_sub(o, p)) / s.size - 1e-4) < 1e-5);
            if (kind == RAY_SHADOW) {
                dvec3 end = dvec3_sub(dvec3_add(o, d), s.scene.light);
                assert_true(r->t_max == 1 && dvec3_length(end) < 1e-5 * s.size);
                continue;
            }
            assert_true(fabs(dvec3_length(d) - 1) < 1e-5 && dvec3_dot(d, n) > -1e-5);
            assert_true(kind == RAY_AO ? r->t_max == (float)(RAY_AO_LENGTH * s.size)
                                       : r->t_max == INFINITY);
            if (kind == RAY_REFLECT)
                assert_true(fabs(dvec3_dot(d, n) + dvec3_dot(before, n)) < 1e-5);
        }
        rays_free(&set);
    }
    rays_free(&primary);
    subject_free(&s);
}

static void test_rays(void **state) {
    (void)state;
    check_rays("atrium", 0.999);
    check_rays("bunnies", 1);
    check_rays("asteroid", 0.3);
    check_rays("terrain", 0.3);
    check_rays("hair", 0.1);
}

/* The mean cosine of directions distributed as the cosine is 2/3. */
static void test_cosine(void **state) {
    (void)state;
    subject s;
    subject_make(&s, "bunnies", 0.01, false);
    subject_build(&s, 0, ACCEL_BALANCED);
    enum { COUNT = 128 * 128 };
    ray_set primary, set;
    rays_make_primary(&s, 128, &primary);
    static hit hits[COUNT];
    accel_trace(s.accel, SNELL_ISA_AUTO, primary.rays, hits, COUNT, NULL);
    rays_make(&s, RAY_DIFFUSE, &primary, hits, &set);
    double sum = 0;
    for (size_t i = 0; i < COUNT; i++) {
        dvec3 n = subject_normal(&s, &hits[i], (dvec3){0, 0, 0}, 0);
        sum += fabs(dvec3_dot(n, dvec3_from(set.rays[i].d)));
    }
    /* the deviation of one is sqrt(1/2 - 4/9) */
    assert_true(fabs(sum / COUNT - 2.0 / 3) < 5 * 0.2357 / sqrt(COUNT));
    rays_free(&set);
    rays_free(&primary);
    subject_free(&s);
}

static void test_spoiled(void **state) {
    (void)state;
    subject s;
    subject_make(&s, "bunnies", 0.01, false);
    subject_build(&s, 0, ACCEL_BALANCED);
    ray_set primary, spoiled;
    rays_make_primary(&s, SIZE, &primary);
    rays_spoil(&primary, &spoiled);
    static hit clean[SIZE * SIZE], now[SIZE * SIZE];
    accel_trace(s.accel, SNELL_ISA_AUTO, primary.rays, clean, primary.count, NULL);
    accel_trace(s.accel, SNELL_ISA_AUTO, spoiled.rays, now, primary.count, NULL);
    size_t bad = 0;
    for (size_t i = 0; i < primary.count; i++) {
        assert_false(ray_is_spoiled(&primary.rays[i]));
        if (ray_is_spoiled(&spoiled.rays[i])) {
            assert_true(now[i].instance == NO_ID);
            bad++;
            continue;
        }
        assert_memory_equal(&spoiled.rays[i], &primary.rays[i], sizeof(ray));
        assert_memory_equal(&now[i], &clean[i], sizeof(hit));
    }
    assert_true(bad > SIZE * SIZE / 10 && bad < SIZE * SIZE / 6);
    rays_free(&spoiled);
    rays_free(&primary);
    subject_free(&s);
}

/* ---- the program ---- */

static json_t *run(const char *arguments, int *code) {
    char command[512];
    snprintf(command, sizeof command, "'%s' %s 2>/dev/null </dev/null", program, arguments);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    json_t *root = json_loadf(pipe, JSON_REJECT_DUPLICATES, NULL);
    int status = pclose(pipe);
    assert_true(WIFEXITED(status));
    *code = WEXITSTATUS(status);
    return root;
}

static double number(json_t *object, const char *key) {
    json_t *value = json_object_get(object, key);
    if (!json_is_number(value)) print_error("no number %s\n", key);
    assert_true(json_is_number(value));
    return json_number_value(value);
}

/* Within a cell: the ratio is that of the rates, and every instruction set finds the same. */
static void check_cell(json_t *cell) {
    assert_true(number(cell, "rays") > 0 && number(cell, "snell_mrays_per_second") > 0);
    assert_true(number(cell, "nodes_per_ray") > 0 && number(cell, "triangles_per_ray") >= 0);
    if (number(cell, "threads") == 1) assert_true(number(cell, "bad_rays_wrong") == 0);
    json_t *tracer;
    size_t i;
    json_array_foreach(json_object_get(cell, "tracers"), i,
                       tracer) if (json_object_get(tracer, "other_bits"))
        assert_true(number(tracer, "other_bits") == 0);
    if (json_object_get(cell, "peer") == NULL) return;
    double ratio = number(cell, "snell_mrays_per_second") / number(cell, "peer_mrays_per_second");
    assert_true(fabs(number(cell, "ratio") / ratio - 1) < 1e-4); /* of one round */
    assert_true(number(cell, "ratio_low") <= number(cell, "ratio"));
    assert_true(number(cell, "agreeing_percent") >= 99.9); /* few rays here */
}

static void test_program(void **state) {
    (void)state;
    if (access(program, X_OK) != 0) {
        print_message("bench-kernel was not built (SNELL_BENCH): not tested\n");
        skip();
    }
    int code;
    json_t *root = run("--json --size 64 --rounds 1 --builds 1 --detail 0.01 --threads 1,2 "
                       "--isa all atrium hair balls",
                       &code);
    assert_int_equal(code, 0);
    assert_non_null(root);
    json_t *cells = json_object_get(root, "cells"), *cell;
    assert_int_equal(json_array_size(json_object_get(root, "scenes")), 3);
    assert_int_equal(json_array_size(cells), 3 * RAY_KINDS * 2);
    size_t i;
    json_array_foreach(cells, i, cell) check_cell(cell);
    bool has_embree = json_object_get(root, "embree") != NULL;
    assert_int_equal(json_array_size(json_object_get(root, "means")), has_embree ? 4 : 0);
    json_decref(root);
    root = run("--json --size 32 --rounds 1 --builds 1 --no-embree --deforming blob", &code);
    assert_int_equal(code, 0);
    assert_null(json_object_get(root, "embree"));
    json_decref(root);
    static const char *const wrong[] = {"--threads 0",  "--fov",   "--eye 1,2",
                                        "--isa best",   "--bogus", "--picture x.ppm",
                                        "no-such-scene"};
    for (i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_null(run(wrong[i], &code));
        assert_int_equal(code, 1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_everywhere),
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_closed),
        cmocka_unit_test(test_file),
        cmocka_unit_test(test_rays),
        cmocka_unit_test(test_cosine),
        cmocka_unit_test(test_spoiled),
        cmocka_unit_test(test_program),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
