/* Scenes with groups: the hits and the pictures of the same scene taken apart, in memory that is stated
 * beforehand. */
#include "api/api.h"
#include "cpu_time.h"
#include "render_test.h"

#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

static rig bench;

static int open_bench(void **state) {
    (void)state;
    bench = rig_make(2, SNELL_ISA_AUTO);
    return 0;
}

static int close_bench(void **state) {
    (void)state;
    rig_free(&bench);
    return 0;
}

enum { LEVELS = 3, PARTS = 3 };

/* Exact: turns by quarters, mirrors, whole shifts. */
static transform exact(uint64_t *random) {
    transform m = {{{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}}};
    int shift = (int)(3 * uniform(random)), turn = uniform(random) < 0.5 ? 1 : 2;
    for (int i = 0; i < 3; i++) {
        m.m[i][(shift + turn * i) % 3] = uniform(random) < 0.5 ? -1 : 1;
        m.m[i][3] = (float)(int)(3 * uniform(random) - 1.5);
    }
    return m;
}

static transform sheared(uint64_t *random) {
    transform m = exact(random);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) m.m[i][j] += (float)(0.3 * uniform(random) - 0.15);
    return m;
}

typedef struct plan {
    snell_shape_id shapes[3];
    snell_material_id materials[3];
    transform at[LEVELS][PARTS];
    bool has_material[LEVELS][PARTS];
    motion_key keys[2]; /* of the last part of each level; times 0: none */
} plan;

static plan make_plan(transform (*any)(uint64_t *), bool shining) {
    plan p = {.keys = {{0, transform_identity()}, {0, transform_identity()}}};
    uint64_t random = 5;
    snell_sphere_desc ball = SNELL_INIT(sphere_desc);
    snell_box_desc box = SNELL_INIT(box_desc);
    const snell_vec3 corners[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const uint32_t faces[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    ball.radius = 0.75f;
    box.min = v3(-0.5, -0.5, -0.25);
    box.max = v3(0.5, 0.25, 0.75);
    MUST(snell_scene_add_sphere(bench.scene, &ball, &p.shapes[0]));
    MUST(snell_scene_add_box(bench.scene, &box, &p.shapes[1]));
    p.shapes[2] = add_mesh(&bench, corners, 4, faces, 12);
    p.materials[0] = add_lambert(&bench, v3(0.8, 0.3, 0.2));
    p.materials[1] = shining ? add_glow(&bench, v3(2, 3, 4)) : add_mirror(&bench, grey(0.8));
    p.materials[2] = add_glass(&bench, 1.5, v3(0.1, 0.2, 0.3), 0);
    for (int l = 0; l < LEVELS; l++)
        for (int i = 0; i < PARTS; i++) {
            p.at[l][i] = any(&random);
            p.has_material[l][i] = l == 1 && i == 1;
        }
    return p;
}

static transform moved(const plan *p, int key, int level, int part) {
    if (level == 0 || part != PARTS - 1) return p->at[level][part];
    return transform_multiply(&p->keys[key].transform, &p->at[level][part]);
}

static void give_motion(const plan *p, int level, int part, snell_instance_id id) {
    if (p->keys[1].time == 0 || level == 0 || part != PARTS - 1) return;
    motion_key keys[2];
    for (int k = 0; k < 2; k++) keys[k] = (motion_key){p->keys[k].time, moved(p, k, level, part)};
    MUST(snell_scene_set_instance_motion(bench.scene, id, keys, 2));
}

static const snell_material_id none = {0, 0};

static void build_nested(const plan *p) {
    snell_shape_id group = {0, 0};
    for (int l = 0; l < LEVELS; l++) {
        snell_instance_id parts[PARTS];
        for (int i = 0; i < PARTS; i++) {
            snell_shape_id shape = l == 0 ? p->shapes[i] : group;
            snell_material_id m = l == 0                  ? p->materials[i]
                                  : p->has_material[l][i] ? p->materials[0]
                                                          : none;
            MUST(snell_scene_add_instance(bench.scene, shape, m, &p->at[l][i], &parts[i]));
            give_motion(p, l, i, parts[i]);
        }
        MUST(snell_scene_add_group(bench.scene, parts, PARTS, NULL, &group));
    }
    MUST(snell_scene_add_instance(bench.scene, group, none, NULL, NULL));
}

static transform whole(const plan *p, int key, int a, int b, int c) {
    transform each[LEVELS] = {moved(p, key, 2, a), moved(p, key, 1, b), moved(p, key, 0, c)};
    dtransform product = dtransform_from(&each[0]);
    for (int i = 1; i < LEVELS; i++) {
        dtransform next = dtransform_from(&each[i]);
        product = dtransform_multiply(&product, &next);
    }
    return dtransform_round(&product);
}

static void build_flat(const plan *p) {
    for (int a = 0; a < PARTS; a++)
        for (int b = 0; b < PARTS; b++)
            for (int c = 0; c < PARTS; c++) {
                snell_instance_id id;
                motion_key keys[2];
                for (int k = 0; k < 2; k++)
                    keys[k] = (motion_key){p->keys[k].time, whole(p, k, a, b, c)};
                snell_material_id m = p->materials[p->has_material[1][b] ? 0 : c];
                MUST(snell_scene_add_instance(bench.scene, p->shapes[c], m, &keys[0].transform,
                                              &id));
                if (p->keys[1].time > 0)
                    MUST(snell_scene_set_instance_motion(bench.scene, id, keys, 2));
            }
}

enum { QUERIES = 4000 };

static void query(snell_hit *hits, float time) {
    static snell_ray rays[QUERIES];
    uint64_t random = 9;
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    for (int i = 0; i < QUERIES; i++) {
        double x = uniform(&random), y = uniform(&random), z = uniform(&random);
        snell_vec3 from = v3(16 * x - 8, 16 * y - 8, 16 * z - 8);
        double u = uniform(&random), v = uniform(&random), w = uniform(&random);
        rays[i] = (snell_ray){from,     0,    vec3_sub(v3(6 * u - 3, 6 * v - 3, 6 * w - 3), from),
                              INFINITY, time, 1};
    }
    MUST(snell_scene_intersect(bench.scene, rays, hits, QUERIES));
}

static void compare(transform (*any)(uint64_t *), float time, double tolerance,
                    int misses_allowed) {
    static snell_hit hits[2][QUERIES];
    const snell_hit *nested = hits[0], *taken_apart = hits[1];
    for (int k = 0; k < 2; k++) {
        rig_clear(&bench);
        plan p = make_plan(any, false);
        if (time > 0) {
            p.keys[1].time = 1;
            p.keys[1].transform.m[0][3] = 2;
            p.keys[1].transform.m[2][3] = -1;
        }
        if (k)
            build_flat(&p);
        else
            build_nested(&p);
        query(hits[k], time);
    }
    int found = 0, different = 0, equal = 0;
    for (int i = 0; i < QUERIES; i++) {
        const snell_hit *a = &nested[i], *b = &taken_apart[i];
        bool hit_a = a->instance.index1 != 0, hit_b = b->instance.index1 != 0;
        found += hit_b;
        if (hit_a != hit_b || (hit_a && (a->number != b->number || a->primitive != b->primitive))) {
            different++;
            continue;
        }
        if (!hit_a) continue;
        equal += memcmp(&a->t, &b->t, sizeof a->t) == 0;
        assert_true(fabs((double)a->t - (double)b->t) <= tolerance * (double)b->t);
        dvec3 off = dvec3_sub(dvec3_from(a->normal), dvec3_from(b->normal));
        assert_true(dvec3_length(off) < 100 * tolerance);
    }
    printf("%d of %d rays hit, %d of them with the same bits, %d something else\n", found, QUERIES,
           equal, different);
    assert_true(found > QUERIES / 10 && different <= misses_allowed);
}

static void groups_are_what_they_are_taken_apart(void **state) {
    (void)state;
    compare(exact, 0, 1e-6, 0);
    compare(sheared, 0, 2e-5, 4);
    compare(exact, 0.5f, 1e-6, 4); /* edges move through the rays' grid */
    compare(sheared, 0.3f, 2e-5, 4);
}

/* The two pictures' mean difference, relative to the mean of both. */
static double difference(snell_integrator policy, transform (*any)(uint64_t *), bool shining) {
    static rgb pixels[2][32 * 32];
    for (int k = 0; k < 2; k++) {
        rig_clear(&bench);
        plan p = make_plan(any, shining);
        if (k)
            build_flat(&p);
        else
            build_nested(&p);
        add_point(&bench, v3(4, 6, 8), v3(300, 300, 300));
        MUST(snell_scene_set_ambient(bench.scene, grey(0.2)));
        MUST(snell_scene_set_background(bench.scene, v3(0.2, 0.3, 0.4), 1));
        snell_render_desc desc = picture(policy, 32, 32, 6);
        snell_view view = look(v3(3, 4, 9), v3(0, 0, 0));
        desc.samples = 4;
        desc.view = &view;
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        MUST(snell_render(bench.scene, &desc, bench.film));
        for (uint32_t i = 0; i < 32 * 32; i++) pixels[k][i] = pixel_at(&bench, i % 32, i / 32);
    }
    double sum = 0, off = 0;
    for (int i = 0; i < 32 * 32; i++) {
        sum += pixels[0][i].c[0] + pixels[1][i].c[0];
        off += fabs(pixels[0][i].c[0] - pixels[1][i].c[0]);
    }
    return 2 * off / sum;
}

static void pictures_are_those_taken_apart(void **state) {
    (void)state;
    static const snell_integrator policies[] = {SNELL_WHITTED, SNELL_COOK, SNELL_PATH};
    for (int k = 0; k < 6; k++) {
        double whole = difference(policies[k / 2], exact, k % 2),
               turned = difference(policies[k / 2], sheared, k % 2);
        printf("policy %d, %s: %.2g of the light differs, sheared %.2g\n", k / 2,
               k % 2 ? "shining" : "mirrors", whole, turned);
        /* The same random numbers: only roundings differ, and which way a few rays go. */
        assert_true(whole < 0.01 && turned < 0.05);
    }
}

/* A ball in a group in a group that lies in the world twice. */
static void a_hit_has_a_path(void **state) {
    (void)state;
    rig_clear(&bench);
    snell_instance_id ball = add_sphere(&bench, v3(0, 0, 0), 1, none), inner, outer[2], path[9];
    snell_shape_id group;
    snell_material_id red = add_lambert(&bench, v3(1, 0, 0));
    uint32_t count;
    MUST(snell_scene_add_group(bench.scene, &ball, 1, "inner", &group));
    MUST(snell_scene_add_instance(bench.scene, group, none, NULL, &inner));
    MUST(snell_scene_add_group(bench.scene, &inner, 1, "outer", &group));
    for (int i = 0; i < 2; i++) {
        transform at = transform_identity();
        at.m[0][3] = (float)(10 * i);
        MUST(snell_scene_add_instance(bench.scene, group, i ? red : none, &at, &outer[i]));
    }
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    assert_int_equal(bench.scene->frozen->group_count, 4); /* once in red */
    snell_ray rays[3] = {{v3(10, 0, 5), 0, v3(0, 0, -1), INFINITY, 0, 1},
                         {v3(0, 0, 5), 0, v3(0, 0, -1), INFINITY, 0, 1},
                         {v3(5, 0, 5), 0, v3(0, 0, -1), INFINITY, 0, 1}};
    snell_hit hits[3];
    MUST(snell_scene_intersect(bench.scene, rays, hits, 3));
    for (uint32_t i = 0; i < 2; i++) {
        MUST(snell_scene_get_path(bench.scene, &hits[i], path, &count));
        assert_int_equal(count, 3);
        assert_int_equal(hits[i].number, 1 - i);
        assert_int_equal(path[0].index1, outer[1 - i].index1);
        assert_int_equal(hits[i].instance.index1, outer[1 - i].index1);
        assert_int_equal(path[1].index1, inner.index1);
        assert_int_equal(path[2].index1, ball.index1);
    }
    assert_int_equal(snell_scene_get_path(bench.scene, &hits[2], path, &count), SNELL_ERR_ARGUMENT);
    snell_bounds box;
    MUST(snell_scene_bounds(bench.scene, &box));
    assert_true(box.min.x >= -1.001f && box.max.x <= 11.001f && box.max.x >= 11);

    /* A part moves, and every copy with it; then it is gone. */
    transform up = transform_identity();
    up.m[1][3] = 4;
    MUST(snell_scene_set_instance_transform(bench.scene, ball, &up));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    MUST(snell_scene_intersect(bench.scene, rays, hits, 3));
    assert_true(hits[0].instance.index1 == 0 && hits[1].instance.index1 == 0);
    MUST(snell_scene_remove_instance(bench.scene, ball));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    rays[0].origin.y = 4;
    MUST(snell_scene_intersect(bench.scene, rays, hits, 3));
    assert_int_equal(hits[0].instance.index1, 0);
}

static void refused(snell_status status, const char *text) {
    assert_int_equal(status, SNELL_ERR_ARGUMENT);
    assert_string_equal(snell_last_error()->text, text);
}

static void wrong_groups_are_errors(void **state) {
    (void)state;
    rig_clear(&bench);
    snell_instance_id part = add_sphere(&bench, v3(0, 0, 0), 1, none), twice[2] = {part, part},
                      nothing = {77, 0}, stale = {1, 5};
    snell_shape_id group;
    refused(snell_scene_add_group(bench.scene, twice, 2, NULL, &group),
            "group: part 2 is given twice");
    refused(snell_scene_add_group(bench.scene, &nothing, 1, NULL, &group),
            "group: part 1 does not exist");
    refused(snell_scene_add_group(bench.scene, &stale, 1, NULL, &group),
            "group: part 1 does not exist");
    size_t shapes = bench.scene->description->objects[CATEGORY_SHAPE].count;
    for (int depth = 1; depth <= 8; depth++) {
        MUST(snell_scene_add_group(bench.scene, &part, 1, NULL, &group));
        refused(snell_scene_add_group(bench.scene, &part, 1, NULL, NULL),
                "group: part 1 is in a group already");
        MUST(snell_scene_add_instance(bench.scene, group, none, NULL, &part));
    }
    refused(snell_scene_add_group(bench.scene, &part, 1, NULL, &group),
            "groups are nested more than 8 deep");
    assert_int_equal(bench.scene->description->objects[CATEGORY_SHAPE].count, shapes + 8);
    transform flat = {{{1, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 1, 0}}};
    assert_int_equal(snell_scene_set_instance_transform(bench.scene, part, &flat),
                     SNELL_ERR_ARGUMENT);
    MUST(snell_scene_commit(bench.scene, NULL, NULL)); /* depth 8 is fine */
}

/* Boxes that shine, in groups: every copy is a light, and a cap is a cap. */
static void copies_of_what_shines_are_lights(void **state) {
    (void)state;
    rig_clear(&bench);
    snell_material_id glow = add_glow(&bench, grey(1));
    snell_shape_id group;
    snell_instance_id parts[3];
    for (int i = 0; i < 3; i++) parts[i] = add_sphere(&bench, v3(3 * i, 0, 0), 1, i ? glow : none);
    for (int level = 0; level < 3; level++) {
        MUST(snell_scene_add_group(bench.scene, parts, 3, NULL, &group));
        for (int i = 0; i < 3; i++) {
            transform at = transform_identity();
            at.m[1 + level % 2][3] = (float)(10 * i);
            MUST(snell_scene_add_instance(bench.scene, group, none, &at, &parts[i]));
        }
    }
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    assert_int_equal(bench.scene->frozen->shape_count, 81);
    assert_int_equal(bench.scene->frozen->surface_light_count, 54);
}

/* ---- much of little ---- */

/* Groups to depth 8: 64 of a ball, 8 of that, and so on: 16,777,216 balls. */
static void build_many(void) {
    snell_instance_id parts[64];
    snell_shape_id group;
    add_sphere(&bench, v3(0, 0, 0), 1, none);
    parts[0] = (snell_instance_id){1, 0};
    MUST(snell_scene_add_group(bench.scene, parts, 1, "balls 1", &group));
    for (int level = 2; level <= 8; level++) {
        int count = level == 2 ? 64 : 8;
        for (int i = 0; i < count; i++) {
            transform at = transform_identity();
            for (int k = 0; k < 3; k++) {
                at.m[k][k] = level == 2 ? 0.24f : 0.48f;
                int steps = level == 2 ? 4 : 2, step = (k == 0   ? i
                                                        : k == 1 ? i / steps
                                                                 : i / steps / steps) %
                                                       steps;
                at.m[k][3] = (float)(step * 2 - (steps - 1)) / (float)(steps / 2);
            }
            MUST(snell_scene_add_instance(bench.scene, group, none, &at, &parts[i]));
        }
        MUST(snell_scene_add_group(bench.scene, parts, (size_t)count, NULL, &group));
    }
    MUST(snell_scene_add_instance(bench.scene, group, none, NULL, NULL));
}

static size_t resident(void) {
    FILE *f = fopen("/proc/self/statm", "r");
    unsigned long all = 0, pages = 0;
    if (f) {
        if (fscanf(f, "%lu %lu", &all, &pages) != 2) pages = 0;
        fclose(f);
    }
    return pages * 4096;
}

static void ten_million_shapes_in_the_stated_memory(void **state) {
    (void)state;
    rig_clear(&bench);
    build_many();
    snell_scene_stats stats = {.struct_size = sizeof stats};
    MUST(snell_scene_get_stats(bench.scene, &stats));
    assert_int_equal(stats.memory_accel, 0); /* stated before anything is built */
    size_t before = resident();
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_render_desc desc = picture(SNELL_WHITTED, 64, 48, 2);
    snell_view view = look(v3(3, 2, 5), v3(0, 0, 0));
    desc.view = &view;
    add_sun(&bench, v3(-1, -2, -3), grey(3));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    size_t committed = resident();
    MUST(snell_render(bench.scene, &desc, bench.film));
    int lit = 0;
    for (uint32_t i = 0; i < 64 * 48; i++) lit += pixel_at(&bench, i % 64, i / 64).c[0] > 0;
    uint64_t planned = stats.memory_planned;
    MUST(snell_scene_get_stats(bench.scene, &stats));
    printf("%llu shapes: %llu bytes stated, %llu in the tree; %zu more resident after the commit\n",
           (unsigned long long)stats.instance_count, (unsigned long long)planned,
           (unsigned long long)stats.memory_accel, committed > before ? committed - before : 0);
    assert_true(stats.instance_count >= 10000000);
    assert_true(stats.memory_accel > 0 && stats.memory_accel < planned && planned < 1 << 20);
    assert_true(lit > 500);
#ifndef __SANITIZE_ADDRESS__
    assert_true(committed <= before + planned + (1 << 20)); /* and what the allocator keeps */
#endif
}

static void more_than_is_allowed_is_refused(void **state) {
    (void)state;
    snell_context_desc desc = SNELL_INIT(context_desc);
    rig r = {0};
    desc.thread_count = 1;
    desc.memory_max = 1 << 20;
    MUST(snell_context_create(&desc, &r.context));
    MUST(snell_scene_create(r.context, &r.scene));
    snell_instance_id ball = add_sphere(&r, v3(0, 0, 0), 1, none);
    snell_shape_id shape = {1, 0};
    MUST(snell_scene_commit(r.scene, NULL, NULL));
    for (int i = 0; i < 5000; i++)
        MUST(snell_scene_add_instance(r.scene, shape, none, NULL, &ball));
    assert_int_equal(snell_scene_commit(r.scene, NULL, NULL), SNELL_ERR_MEMORY);
    assert_non_null(strstr(snell_last_error()->text, "1.0 MiB are allowed"));
    rig_free(&r);
}

/* ---- nothing is taken that is not allowed ---- */

enum { ALLOWED = 64 << 20 };

/* One group under many materials: it is frozen once for each. */
static void build_many_materials(rig *r) {
    enum { PARTS_OF_GROUP = 2000, MATERIALS = 600 };
    static snell_instance_id parts[PARTS_OF_GROUP];
    snell_sphere_desc ball = SNELL_INIT(sphere_desc);
    snell_shape_id sphere, group;
    MUST(snell_scene_add_sphere(r->scene, &ball, &sphere));
    for (int i = 0; i < PARTS_OF_GROUP; i++)
        MUST(snell_scene_add_instance(r->scene, sphere, none, NULL, &parts[i]));
    MUST(snell_scene_add_group(r->scene, parts, PARTS_OF_GROUP, NULL, &group));
    for (int i = 0; i < MATERIALS; i++) {
        snell_material_id paint = add_lambert(r, grey(0.5));
        MUST(snell_scene_add_instance(r->scene, group, paint, NULL, NULL));
    }
}

/* Formulas are read into what is larger than they are. */
static void build_formulas(rig *r) {
    enum { FORMULAS = 12000 };
    snell_implicit_desc ball = SNELL_INIT(implicit_desc);
    ball.f = "x";
    ball.min = v3(-1, -1, -1);
    ball.max = v3(1, 1, 1);
    for (int i = 0; i < FORMULAS; i++) {
        snell_shape_id shape;
        MUST(snell_scene_add_implicit(r->scene, &ball, &shape));
        MUST(snell_scene_add_instance(r->scene, shape, none, NULL, NULL));
    }
}

static snell_shape_id add_ball_mesh(rig *r, uint32_t n, bool many_materials) {
    enum { MOST = 400, SLOTS = 100000 };
    static snell_vec3 positions[MOST * MOST];
    static uint32_t indices[6 * MOST * MOST], slots[2 * MOST * MOST];
    static snell_material_id materials[SLOTS];
    uint32_t *to = indices;
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < n; j++) {
            const double turn = 6.283185307179586;
            double a = turn * i / n, b = turn * j / n, far = 2 + cos(b);
            positions[i * n + j] = v3(far * cos(a), sin(b), far * sin(a));
            uint32_t right = (i + 1) % n * n, up = (j + 1) % n;
            const uint32_t faces[6] = {i * n + j, i * n + up, right + j,
                                       right + j, i * n + up, right + up};
            for (int k = 0; k < 6; k++) *to++ = faces[k];
        }
    snell_mesh_desc mesh = SNELL_INIT(mesh_desc);
    snell_shape_id shape;
    mesh.positions = positions;
    mesh.positions_count = (size_t)n * n;
    mesh.indices = indices;
    mesh.indices_count = 6 * (size_t)n * n;
    if (many_materials) {
        snell_material_id paint = add_lambert(r, grey(0.5));
        for (int i = 0; i < SLOTS; i++) materials[i] = paint;
        mesh.materials = materials;
        mesh.materials_count = SLOTS;
        mesh.material_slots = slots;
        mesh.material_slots_count = 2 * (size_t)n * n;
    }
    MUST(snell_scene_add_mesh(r->scene, &mesh, &shape));
    return shape;
}

static void add_solid_of(rig *r, snell_shape_id shape, int times) {
    snell_shape_id shapes[SOLID_PARTS_MAX], solid;
    for (int i = 0; i < times; i++) shapes[i] = shape;
    snell_solid_desc desc = SNELL_INIT(solid_desc);
    desc.shapes = shapes;
    desc.shapes_count = (size_t)times;
    MUST(snell_scene_add_solid(r->scene, &desc, &solid));
    MUST(snell_scene_add_instance(r->scene, solid, none, NULL, NULL));
}

/* A tree for a solid, besides the mesh's. */
static void build_large_solid(rig *r) { add_solid_of(r, add_ball_mesh(r, 400, false), 2); }
static void build_slots(rig *r) { add_solid_of(r, add_ball_mesh(r, 4, true), SOLID_PARTS_MAX); }
static void build_often_named(rig *r) { add_solid_of(r, add_ball_mesh(r, 100, false), 256); }

/* Clusters of nine, which fill leaves least. */
static void build_nines(rig *r) {
    enum { COUNT = 180000 };
    static snell_vec3 positions[3 * COUNT];
    static uint32_t indices[3 * COUNT];
    uint64_t random = 5;
    snell_vec3 center = v3(0, 0, 0);
    for (uint32_t i = 0; i < 3 * COUNT; i++) {
        if (i % 27 == 0) center = v3(uniform(&random), uniform(&random), uniform(&random));
        positions[i] = v3((double)center.x + 1e-4 * uniform(&random),
                          (double)center.y + 1e-4 * uniform(&random),
                          (double)center.z + 1e-4 * uniform(&random));
        indices[i] = i;
    }
    snell_mesh_desc mesh = SNELL_INIT(mesh_desc);
    snell_shape_id shape;
    mesh.positions = positions;
    mesh.positions_count = mesh.indices_count = 3 * COUNT;
    mesh.indices = indices;
    MUST(snell_scene_add_mesh(r->scene, &mesh, &shape));
    MUST(snell_scene_add_instance(r->scene, shape, none, NULL, NULL));
}

static void build_torus(rig *r) {
    MUST(snell_scene_add_instance(r->scene, add_ball_mesh(r, 400, false), none, NULL, NULL));
}

static void add_copies(rig *r, snell_shape_id shape, int count) {
    for (int i = 0; i < count; i++) {
        snell_transform at = {
            {{1, 0, 0, (float)(i % 97)}, {0, 1, 0, (float)(i % 89)}, {0, 0, 1, (float)i}}};
        MUST(snell_scene_add_instance(r->scene, shape, none, &at, NULL));
    }
}

static void build_copies(rig *r) { add_copies(r, add_ball_mesh(r, 100, false), 20000); }

/* Of different shapes, which are built side by side. */
static void build_small_meshes(rig *r) {
    for (int i = 0; i < 64; i++) add_copies(r, add_ball_mesh(r, 60, false), 2);
}

/* In a process of its own, whose memory nobody else has used: how much more it had at its most, and
 * what the commit said. */
typedef struct taken {
    snell_status status;
    size_t more;
    uint64_t planned;
} taken;

static taken commit_alone(void (*build)(rig *r), snell_build quality, uint32_t threads,
                          uint64_t memory_max) {
    int ends[2];
    taken result;
    assert_int_equal(pipe(ends), 0);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        snell_context_desc desc = SNELL_INIT(context_desc);
        rig r = {0};
        struct rusage before, after;
        snell_scene_stats stats = {.struct_size = sizeof stats};
        desc.thread_count = threads;
        desc.memory_max = memory_max;
        desc.build = quality;
        MUST(snell_context_create(&desc, &r.context));
        MUST(snell_scene_create(r.context, &r.scene));
        build(&r);
        MUST(snell_scene_get_stats(r.scene, &stats));
        getrusage(RUSAGE_SELF, &before);
        result.status = snell_scene_commit(r.scene, NULL, NULL);
        getrusage(RUSAGE_SELF, &after);
        result.more = (size_t)(after.ru_maxrss - before.ru_maxrss) << 10;
        result.planned = stats.memory_planned;
        _exit(write(ends[1], &result, sizeof result) != sizeof result);
    }
    close(ends[1]);
    assert_int_equal(read(ends[0], &result, sizeof result), sizeof result);
    close(ends[0]);
    waitpid(child, NULL, 0);
    return result;
}

static void memory_is_stated_before_it_is_taken(void **state) {
    (void)state;
    static const struct {
        const char *name;
        void (*build)(rig *r);
        bool refused;
    } rows[] = {{"many materials", build_many_materials, true},
                {"formulas", build_formulas, true},
                {"a large solid", build_large_solid, true},
                {"slots", build_slots, false},
                {"a mesh named often", build_often_named, false}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        taken got = commit_alone(rows[i].build, SNELL_BUILD_BALANCED, 1, ALLOWED);
        printf("%s: %.1f MiB planned, %.1f MiB more at the most: status %d\n", rows[i].name,
               (double)got.planned * 0x1p-20, (double)got.more * 0x1p-20, got.status);
        assert_int_equal(got.status, rows[i].refused ? SNELL_ERR_MEMORY : SNELL_OK);
#ifndef __SANITIZE_ADDRESS__
        assert_true(got.more <= ALLOWED + (1 << 20));
        if (!rows[i].refused) assert_true(got.more <= got.planned + (1 << 20));
#endif
    }
}

/* Bytes for each triangle in the statement, as docs/library.md has them; and that peaks keep to it. */
static void each_build_keeps_to_the_statement(void **state) {
    (void)state;
    static const struct {
        const char *name;
        void (*build)(rig *r);
        double triangles;
    } rows[] = {{"nines", build_nines, 180000},
                {"a torus", build_torus, 320000},
                {"copies", build_copies, 0},
                {"small meshes", build_small_meshes, 0}};
    static const char *const qualities[] = {"balanced", "fast", "best"};
    for (int i = 0; i < 4 * 3; i++) {
        snell_build quality = (snell_build)(i % 3);
        taken got = commit_alone(rows[i / 3].build, quality, 1 + (uint32_t)i % 2, 0);
        printf("%s, %s: %.1f MiB planned, %.1f MiB more at the most\n", rows[i / 3].name,
               qualities[quality], (double)got.planned * 0x1p-20, (double)got.more * 0x1p-20);
        assert_int_equal(got.status, SNELL_OK);
        if (rows[i / 3].triangles > 0)
            assert_true((double)got.planned <= 178 * rows[i / 3].triangles + 0x1p18);
#ifndef __SANITIZE_ADDRESS__
        assert_true(got.more <= got.planned + (1 << 20));
#endif
    }
}

static double time_of_bounds(int copies) {
    enum { STRANDS = 4000, POINTS = 8 };
    static snell_vec3 points[STRANDS * POINTS];
    static uint32_t starts[STRANDS];
    for (int i = 0; i < STRANDS * POINTS; i++) points[i] = v3(i % POINTS, i % 97, i % 89);
    for (int i = 0; i < STRANDS; i++) starts[i] = (uint32_t)(i * POINTS);
    snell_curves_desc desc = SNELL_INIT(curves_desc);
    snell_shape_id shape;
    snell_bounds b;
    desc.points = points;
    desc.points_count = STRANDS * POINTS;
    desc.starts = starts;
    desc.starts_count = STRANDS;
    desc.radius = 0.125f;
    rig_clear(&bench);
    MUST(snell_scene_add_curves(bench.scene, &desc, &shape));
    for (int i = 0; i < copies; i++)
        MUST(snell_scene_add_instance(bench.scene, shape, none, NULL, NULL));
    double before = cpu_seconds();
    MUST(snell_scene_bounds(bench.scene, &b));
    return cpu_seconds() - before;
}

/* A shape's bounds may take a look at each of its parts: not once more for every copy. */
static void copies_share_their_bounds(void **state) {
    (void)state;
    double one = time_of_bounds(1), many = time_of_bounds(500);
    printf("bounds of 1 copy: %.4f s, of 500: %.4f s\n", one, many);
    assert_true(many < 20 * one + 0.01);
}

/* A material for what has none makes no copy of a group in which everything has its own. */
static void materials_that_nothing_takes_make_no_copies(void **state) {
    (void)state;
    enum { COPIES = 5 };
    for (int lacking = 0; lacking < 2; lacking++) {
        rig_clear(&bench);
        snell_material_id red = add_lambert(&bench, v3(1, 0, 0));
        snell_instance_id parts[2] = {add_sphere(&bench, v3(0, 0, 0), 1, red),
                                      add_sphere(&bench, v3(3, 0, 0), 1, lacking ? none : red)};
        snell_shape_id inner, outer;
        MUST(snell_scene_add_group(bench.scene, parts, 2, NULL, &inner));
        MUST(snell_scene_add_instance(bench.scene, inner, none, NULL, &parts[0]));
        MUST(snell_scene_add_group(bench.scene, parts, 1, NULL, &outer));
        for (int i = 0; i < COPIES; i++) {
            snell_material_id paint = add_lambert(&bench, v3(0, 0, 1));
            const transform up = {{{1, 0, 0, 0}, {0, 1, 0, (float)(3 * i)}, {0, 0, 1, 0}}};
            snell_instance_id id;
            MUST(snell_scene_add_instance(bench.scene, outer, paint, &up, &id));
            bench.scene->description->instances[id.index1 - 1].fills = true;
        }
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        const scene *s = bench.scene->frozen;
        assert_int_equal(s->group_count, lacking ? 2 * COPIES : 2);
        for (uint32_t i = 0; i < 2 * COPIES; i++)
            assert_int_equal(scene_part(s, i)->material,
                             lacking && i % 2 ? 1 + i / 2 : red.index1 - 1);
    }
}

static void assert_bounds(snell_vec3 min, snell_vec3 max) {
    snell_bounds b;
    MUST(snell_scene_bounds(bench.scene, &b));
    const float got[6] = {b.min.x, b.min.y, b.min.z, b.max.x, b.max.y, b.max.z},
                want[6] = {min.x, min.y, min.z, max.x, max.y, max.z};
    for (int i = 0; i < 6; i++) assert_true(fabsf(got[i] - want[i]) < 1e-4f);
}

/* A plane has no bounds; the ball beside it, in the same group and in groups of groups, keeps its own,
 * and rays meet both. */
static void bounds_hold_what_stands_beside_a_plane(void **state) {
    (void)state;
    snell_plane_desc plane = SNELL_INIT(plane_desc);
    snell_sphere_desc ball = SNELL_INIT(sphere_desc);
    snell_shape_id floor, sphere, inner, outer;
    snell_instance_id parts[3];
    for (int alone = 0; alone < 2; alone++) {
        rig_clear(&bench);
        MUST(snell_scene_add_plane(bench.scene, &plane, &floor));
        MUST(snell_scene_add_sphere(bench.scene, &ball, &sphere));
        MUST(snell_scene_add_instance(bench.scene, floor, none, NULL, &parts[0]));
        MUST(snell_scene_add_instance(bench.scene, sphere, none, NULL, &parts[1]));
        MUST(snell_scene_add_group(bench.scene, parts, 2, NULL, &inner));
        const transform up = {{{1, 0, 0, 0}, {0, 1, 0, 3}, {0, 0, 1, 0}}},
                        right = {{{1, 0, 0, 5}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
        MUST(snell_scene_add_instance(bench.scene, inner, none, &up, &parts[0]));
        MUST(snell_scene_add_instance(bench.scene, sphere, none, &right, &parts[1]));
        MUST(snell_scene_add_group(bench.scene, parts, alone ? 1 : 2, NULL, &outer));
        if (alone) MUST(snell_scene_remove_instance(bench.scene, parts[1]));
        MUST(snell_scene_add_instance(bench.scene, outer, none, &right, NULL));
        for (int committed = 0; committed < 2; committed++) {
            assert_bounds(v3(4, alone ? 2 : -1, -1), v3(alone ? 6 : 11, 4, 1));
            MUST(snell_scene_commit(bench.scene, NULL, NULL));
        }
        snell_hit hits[2];
        snell_ray rays[2] = {{.origin = v3(5, 9, 0), .direction = v3(0, -1, 0), .mask = 1},
                             {.origin = v3(50, 9, 0), .direction = v3(0, -1, 0), .mask = 1}};
        for (int i = 0; i < 2; i++) rays[i].t_max = INFINITY;
        MUST(snell_scene_intersect(bench.scene, rays, hits, 2));
        assert_float_equal(hits[0].t, 5, 1e-4);
        assert_float_equal(hits[1].t, 6, 1e-4);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(groups_are_what_they_are_taken_apart),
        cmocka_unit_test(pictures_are_those_taken_apart),
        cmocka_unit_test(a_hit_has_a_path),
        cmocka_unit_test(wrong_groups_are_errors),
        cmocka_unit_test(copies_of_what_shines_are_lights),
        cmocka_unit_test(ten_million_shapes_in_the_stated_memory),
        cmocka_unit_test(bounds_hold_what_stands_beside_a_plane),
        cmocka_unit_test(copies_share_their_bounds),
        cmocka_unit_test(materials_that_nothing_takes_make_no_copies),
        cmocka_unit_test(memory_is_stated_before_it_is_taken),
        cmocka_unit_test(each_build_keeps_to_the_statement),
        cmocka_unit_test(more_than_is_allowed_is_refused),
    };
    return cmocka_run_group_tests(tests, open_bench, close_bench);
}
