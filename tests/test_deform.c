/* Meshes that deform, as rays meet them: against trying every triangle where it is at the ray's time,
 * to the bit; no leaks at any time; boxes that hold what is in them and are tight. */
#include "accel_test.h"

#include "geometry/deforming.h"
#include "geometry/surface.h"

static const snell_isa isas[] = {SNELL_ISA_SCALAR, SNELL_ISA_AVX2, SNELL_ISA_AVX512};

/* ---- meshes at keys ---- */

enum { KEYS_MAX = 7 };

/* Also what the description of such a mesh is. */
typedef struct keyed {
    mesh_desc desc; /* positions at all keys */
    size_t vertices;
    float times[KEYS_MAX];
    deforming_mesh *all; /* every key in use */
} keyed;

static keyed *keyed_create(size_t vertices, size_t triangles, size_t keys) {
    keyed *k = calloc(1, sizeof *k);
    assert_non_null(k);
    k->vertices = vertices;
    k->desc = (mesh_desc){.struct_size = sizeof k->desc,
                          .positions = calloc(vertices * keys + 1, sizeof(vec3)),
                          .positions_count = vertices * keys,
                          .indices = calloc(3 * triangles + 1, sizeof(uint32_t)),
                          .indices_count = 3 * triangles,
                          .key_times = k->times,
                          .key_times_count = keys};
    assert_true(k->desc.positions && k->desc.indices && keys <= KEYS_MAX);
    return k;
}

static void keyed_free(keyed *k) {
    free(k->all);
    free((void *)(uintptr_t)k->desc.positions);
    free((void *)(uintptr_t)k->desc.indices);
    free(k);
}

static vec3 *keyed_positions(keyed *k, size_t key) {
    return mesh_positions(&k->desc) + key * k->vertices;
}

/* To be called when the positions are there. */
static void keyed_prepare(keyed *k, double open, double close) {
    free(k->all);
    assert_int_equal(primitive_mesh.check(&k->desc), SNELL_OK);
    k->all = deforming_create(&k->desc, open, close);
    assert_non_null(k->all);
}

/* Unlike the code under test: from the first key on, until one is later. */
static size_t interval_of(const keyed *k, float time, float weight[2]) {
    size_t at = 0, last = k->desc.key_times_count - 1;
    while (at < last && k->times[at + 1] <= time) at++;
    weight[0] = 1, weight[1] = 0;
    if (at == last || !(time > k->times[at])) return at;
    double from = (double)k->times[at],
           s = ((double)time - from) / ((double)k->times[at + 1] - from);
    weight[0] = (float)(1 - s), weight[1] = (float)s;
    return at;
}

/* The mesh as it stands at a time, into a still one of as many vertices. */
static void keyed_at(keyed *k, float time, mesh_desc *still) {
    float w[2];
    size_t at = interval_of(k, time, w), next = w[1] != 0 ? at + 1 : at;
    const vec3 *a = keyed_positions(k, at), *b = keyed_positions(k, next);
    for (size_t i = 0; i < k->vertices; i++)
        mesh_positions(still)[i] =
            (vec3){w[0] * a[i].x + w[1] * b[i].x, w[0] * a[i].y + w[1] * b[i].y,
                   w[0] * a[i].z + w[1] * b[i].z};
}

/* Triangles of no order, each going its own way; some have no area, some stand still. */
static keyed *make_soup(rng *r) {
    enum { COUNT = 120, KEYS = 5 };
    keyed *k = keyed_create(3 * COUNT, COUNT, KEYS);
    for (uint32_t i = 0; i < 3 * COUNT; i++) mesh_indices(&k->desc)[i] = i % 13 == 5 ? i - 1 : i;
    for (size_t key = 0; key < KEYS; key++) {
        k->times[key] = key ? k->times[key - 1] + rng_float(r, 0.05, 1) : -0.3f;
        for (uint32_t i = 0; i < COUNT; i++) {
            vec3 center = rng_vec3(r, 3);
            for (uint32_t v = 0; v < 3; v++) {
                vec3 p = vec3_add(center, rng_vec3(r, 0.7));
                if (key && i % 7 == 0) p = keyed_positions(k, 0)[3 * i + v];
                keyed_positions(k, key)[3 * i + v] = p;
            }
        }
    }
    return k;
}

/* A closed sphere that bulges, twists and goes away; far: from the origin. */
static keyed *make_ball(uint32_t columns, uint32_t rows, dvec3 center, double travel) {
    enum { KEYS = 4 };
    test_scene *s = scene_create();
    const mesh_desc *sphere = scene_add_uv_sphere(s, columns, rows, 1, (dvec3){0, 0, 0});
    keyed *k = keyed_create(sphere->positions_count, mesh_triangle_count(sphere), KEYS);
    memcpy(mesh_indices(&k->desc), sphere->indices, sphere->indices_count * sizeof(uint32_t));
    for (size_t key = 0; key < KEYS; key++) {
        k->times[key] = 0.25f * (float)key;
        for (size_t i = 0; i < k->vertices; i++) {
            dvec3 p = dvec3_from(sphere->positions[i]);
            double twist = 0.5 * (double)key * p.y, c = cos(twist), n = sin(twist),
                   wide = 2 + 0.4 * sin(5 * p.y + 2 * (double)key);
            keyed_positions(k, key)[i] =
                (vec3){(float)(center.x + wide * (c * p.x - n * p.z) + travel * (double)key),
                       (float)(center.y + 2 * p.y), (float)(center.z + wide * (n * p.x + c * p.z))};
        }
    }
    scene_destroy(s);
    return k;
}

/* A grid on whole numbers that is lifted by whole numbers: rays meet edges and vertices. */
static keyed *make_grid(void) {
    enum { SIDE = 5, COUNT = SIDE * SIDE, CELLS = (SIDE - 1) * (SIDE - 1), KEYS = 3 };
    keyed *k = keyed_create(COUNT, 2 * CELLS, KEYS);
    for (uint32_t i = 0; i < CELLS; i++) {
        uint32_t a = i / (SIDE - 1) * SIDE + i % (SIDE - 1);
        const uint32_t corners[6] = {a, a + SIDE, a + 1, a + 1, a + SIDE, a + SIDE + 1};
        memcpy(mesh_indices(&k->desc) + (size_t)6 * i, corners, sizeof corners);
    }
    for (size_t key = 0; key < KEYS; key++) {
        k->times[key] = (float)key;
        for (size_t i = 0; i < COUNT; i++)
            keyed_positions(k, key)[i] =
                (vec3){(float)(i % SIDE) - 2, key == 1 ? (float)(i % 3) : (float)key,
                       (float)(i / SIDE) - 2};
    }
    return k;
}

/* ---- the hit rule, plainly ---- */

typedef struct arena { /* keyed meshes and where they stand */
    keyed *meshes[4];
    test_scene *scene; /* geometry i is meshes[i] */
    mesh_desc *still[4];
    test_scene *still_owner;
    size_t mesh_count;
} arena;

static void arena_add(arena *a, keyed *k) {
    keyed_prepare(k, -INFINITY, INFINITY);
    scene_add_geometry(a->scene, &primitive_deforming, k->all);
    mesh_desc *still = scene_add_mesh(a->still_owner, k->vertices, mesh_triangle_count(&k->desc));
    memcpy(mesh_indices(still), k->desc.indices, k->desc.indices_count * sizeof(uint32_t));
    a->still[a->mesh_count] = still;
    a->meshes[a->mesh_count++] = k;
}

static arena arena_create(uint64_t seed) {
    static const transform sheared = {
        {{1.3f, -0.4f, 0.2f, 1}, {0.7f, 0.9f, -0.1f, -2}, {0.3f, 0.2f, -1.1f, 0.5f}}};
    rng r = {seed};
    arena a = {.scene = scene_create(), .still_owner = scene_create()};
    arena_add(&a, make_soup(&r));
    arena_add(&a, make_ball(24, 12, (dvec3){0.5, 0, 0}, 1.5));
    arena_add(&a, make_grid());
    for (uint32_t i = 0; i < 3; i++) scene_add_instance(a.scene, i, NULL);
    scene_add_instance(a.scene, 1, &sheared);
    scene_add_instance(a.scene, 2, &sheared);
    return a;
}

static void arena_destroy(arena *a) {
    for (size_t i = 0; i < a->mesh_count; i++) keyed_free(a->meshes[i]);
    scene_destroy(a->scene);
    scene_destroy(a->still_owner);
}

static bounds3 box_at_all_times(const keyed *k) {
    bounds3 box = bounds3_empty();
    for (size_t key = 0; key < k->desc.key_times_count; key++)
        for (size_t i = 0; i < k->desc.indices_count; i++)
            box = bounds3_add_point(box, k->desc.positions[key * k->vertices + k->desc.indices[i]]);
    return box;
}

/* The hit by trying every triangle at the ray's time. */
static hit try_everything(arena *a, const ray *r) {
    hit best = {INFINITY, 0, 0, NO_ID, NO_ID};
    plain_ray world = plain_ray_make(r->o, r->d, r->t_min, r->t_max);
    for (size_t i = 0; i < a->mesh_count; i++) keyed_at(a->meshes[i], r->time, a->still[i]);
    for (uint32_t i = 0; i < a->scene->instance_count; i++) {
        const accel_instance *in = &a->scene->instances[i];
        const bounds3 own = box_at_all_times(a->meshes[in->geometry]);
        bounds3 box = own;
        plain_ray local = world;
        float entry;
        if (!in->identity) {
            box = transform_bounds(&in->to_world, own);
            local = plain_ray_make(vec3_from(transform_point(&in->to_local, dvec3_from(r->o))),
                                   vec3_from(transform_vector(&in->to_local, dvec3_from(r->d))),
                                   r->t_min, r->t_max);
        }
        if (!plain_box(&world, box, &entry)) continue;
        plain_mesh(a->still[in->geometry], own, &local, r, i, entry, &best);
    }
    return best;
}

/* Before, after, at and just beside keys, and anywhere between. */
static float choose_time(const keyed *k, rng *r) {
    float key = k->times[rng_below(r, (uint32_t)k->desc.key_times_count)];
    switch (rng_below(r, 6)) {
    case 0: return key;
    case 1: return nextafterf(key, rng_below(r, 2) ? 99.0f : -99.0f);
    case 2: return rng_float(r, -3, 5);
    default: return rng_float(r, k->times[0], k->times[k->desc.key_times_count - 1]);
    }
}

/* From anywhere, or from a vertex, towards a vertex, a point of an edge or of a triangle as they are
 * at the time. */
static ray choose_ray(arena *a, rng *r) {
    const accel_instance *in =
        &a->scene->instances[rng_below(r, (uint32_t)a->scene->instance_count)];
    keyed *k = a->meshes[in->geometry];
    float time = choose_time(k, r);
    mesh_desc *still = a->still[in->geometry];
    keyed_at(k, time, still);
    const uint32_t *index =
        still->indices + 3 * (size_t)rng_below(r, (uint32_t)mesh_triangle_count(still));
    uint32_t kind = rng_below(r, 4);
    double u = kind == 0 ? 0 : kind == 1 ? 0.5 : rng_unit(r);
    double v = kind == 3 ? (1 - u) * rng_unit(r) : 0;
    dvec3 p = dvec3_scale(dvec3_from(still->positions[index[0]]), 1 - u - v);
    p = dvec3_add(p, dvec3_scale(dvec3_from(still->positions[index[1]]), u));
    p = dvec3_add(p, dvec3_scale(dvec3_from(still->positions[index[2]]), v));
    if (!in->identity) p = transform_point(&in->to_world, p);
    vec3 target = vec3_from(p), o = rng_vec3(r, 8);
    if (rng_below(r, 4) == 0) o = vec3_sub(target, (vec3){0, (float)rng_below(r, 5), 0});
    vec3 d = vec3_sub(target, o);
    if (d.x == 0 && d.y == 0 && d.z == 0) d.z = 1;
    ray out = ray_make(o, d, 0, INFINITY);
    out.time = time;
    if (rng_below(r, 4) == 0) out.t_max = rng_below(r, 2) ? 1 : rng_float(r, 0.5, 1.5);
    if (rng_below(r, 8) == 0) {
        out.skip_instance = rng_below(r, (uint32_t)a->scene->instance_count);
        out.skip_primitive = rng_below(r, 30);
    }
    return out;
}

static void every_hit_is_that_of_trying_every_triangle(void **state) {
    (void)state;
    enum { BATCH = 400, LEAVES = 3 };
    static const uint32_t leaf_sizes[LEAVES] = {0, 1, 3};
    static ray rays[BATCH];
    static hit truth[BATCH], hits[BATCH];
    static uint8_t blocked[BATCH];
    size_t batches = SANITIZED ? 2 : test_full() ? 500 : 20, wrong = 0, found = 0;
    arena a = arena_create(3);
    accel *trees[LEAVES];
    for (uint32_t i = 0; i < LEAVES; i++) trees[i] = scene_build(a.scene, leaf_sizes[i], i, NULL);
    rng r = {7};
    for (size_t isa = 0; isa < COUNT_OF(isas); isa++)
        if (!accel_has_isa(isas[isa])) printf("%s: NOT TESTED\n", snell_isa_name(isas[isa]));
    for (size_t batch = 0; batch < batches; batch++) {
        for (size_t i = 0; i < BATCH; i++) {
            rays[i] = choose_ray(&a, &r);
            truth[i] = try_everything(&a, &rays[i]);
            if (truth[i].instance != NO_ID && rng_below(&r, 3) == 0) { /* walks on */
                rays[i].after_t = truth[i].t;
                rays[i].after_instance = truth[i].instance;
                rays[i].after_primitive = truth[i].primitive;
                truth[i] = try_everything(&a, &rays[i]);
            }
            found += truth[i].instance != NO_ID;
        }
        for (size_t isa = 0; isa < COUNT_OF(isas); isa++)
            for (size_t tree = 0; tree < LEAVES && accel_has_isa(isas[isa]); tree++) {
                accel_trace(trees[tree], isas[isa], rays, hits, BATCH, NULL);
                accel_occluded(trees[tree], isas[isa], rays, blocked, BATCH, NULL);
                for (size_t i = 0; i < BATCH; i++) {
                    bool any = truth[i].instance != NO_ID;
                    if (same_hit(&hits[i], &truth[i]) && blocked[i] == any) continue;
                    if (wrong++ == 0)
                        print_error("isa %d, tree %zu, time %a: got %a %u/%u, wanted %a %u/%u\n",
                                    (int)isas[isa], tree, (double)rays[i].time, (double)hits[i].t,
                                    hits[i].instance, hits[i].primitive, (double)truth[i].t,
                                    truth[i].instance, truth[i].primitive);
                }
            }
    }
    printf("%zu rays, %zu hits, %zu differences\n", batches * BATCH, found, wrong);
    for (uint32_t i = 0; i < LEAVES; i++) accel_destroy(trees[i]);
    arena_destroy(&a);
    assert_int_equal(wrong, 0);
    assert_true(found > batches * BATCH / 3);
}

static void counters_are_equal_between_instruction_sets(void **state) {
    (void)state;
    enum { RAYS = 3000 };
    static ray rays[RAYS];
    static hit hits[RAYS];
    arena a = arena_create(4);
    accel *tree = scene_build(a.scene, 0, 0, NULL);
    rng r = {8};
    for (size_t i = 0; i < RAYS; i++) rays[i] = choose_ray(&a, &r);
    trace_counters first = {0};
    for (size_t isa = 0; isa < COUNT_OF(isas); isa++) {
        if (!accel_has_isa(isas[isa])) continue;
        trace_counters c = {0};
        accel_trace(tree, isas[isa], rays, hits, RAYS, &c);
        if (isa == 0) first = c;
        assert_memory_equal(&c, &first, sizeof c);
        assert_true(c.nodes > RAYS && c.triangles > RAYS);
    }
    accel_destroy(tree);
    arena_destroy(&a);
}

/* The tree does not depend on threads. */
static void threads_build_the_same_tree(void **state) {
    (void)state;
    test_scene *s = scene_create();
    keyed *k = make_ball(200, 100, (dvec3){0, 0, 0}, 1);
    keyed_prepare(k, -INFINITY, INFINITY);
    scene_add_geometry(s, &primitive_deforming, k->all);
    scene_add_instance(s, 0, NULL);
    thread_pool *pool = NULL;
    assert_int_equal(thread_pool_create(3, &pool), SNELL_OK);
    accel *one = scene_build(s, 0, 0, NULL), *many = scene_build(s, 0, 0, pool);
    const bvh_tree *a = &one->geometries[0].tree, *b = &many->geometries[0].tree;
    assert_int_equal(a->node_count, b->node_count);
    assert_int_equal(a->block_count, b->block_count);
    assert_memory_equal(a->nodes, b->nodes, 4 * a->node_count * sizeof *a->nodes);
    assert_memory_equal(a->blocks, b->blocks, 4 * a->block_count * sizeof *a->blocks);
    accel_destroy(one);
    accel_destroy(many);
    thread_pool_destroy(pool);
    keyed_free(k);
    scene_destroy(s);
}

/* ---- boxes ---- */

/* Of the nodes at the ends of an interval, mixed as the kernels do; returns how many triangles it
 * went through. */
static size_t check_node(const bvh_tree *tree, const keyed *k, const mesh_desc *still,
                         uint32_t index, size_t key, size_t next, const float w[2],
                         bounds3 *around) {
    const bvh_node *a = &tree->nodes[key * tree->node_count + index],
                   *b = &tree->nodes[next * tree->node_count + index];
    size_t seen = 0;
    *around = bounds3_empty();
    for (uint32_t i = 0; i < BVH_WIDTH; i++) {
        if (!(a->valid >> i & 1)) continue;
        bounds3 box, inside = bounds3_empty();
        float *sides[2] = {&box.min.x, &box.max.x};
        for (int side = 0; side < 2; side++)
            for (int axis = 0; axis < 3; axis++)
                sides[side][axis] =
                    w[0] * a->bounds[side][axis][i] + w[1] * b->bounds[side][axis][i];
        assert_int_equal(a->child[i], b->child[i]);
        if (a->child[i] & BVH_LEAF) {
            const triangle_block *block = &tree->blocks[a->child[i] & BVH_INDEX_MASK];
            for (uint32_t t = 0; t <= (a->child[i] >> BVH_COUNT_SHIFT & 7); t++, seen++)
                inside = bounds3_union(inside, mesh_triangle_bounds(still, block->primitive[t]));
        } else {
            seen += check_node(tree, k, still, a->child[i], key, next, w, &inside);
        }
        bounds3 joined = bounds3_union(box, inside);
        assert_memory_equal(&joined, &box, sizeof box);
        /* Tight: at a key it is the box itself, but for the margin of boxes in meshes. */
        const float *in[2] = {&inside.min.x, &inside.max.x};
        for (int side = 0; side < 2 && w[1] == 0; side++)
            for (int axis = 0; axis < 3; axis++)
                assert_true(fabsf(sides[side][axis] - in[side][axis]) <= 1.1f * tree->margin);
        *around = bounds3_union(*around, box);
    }
    return seen;
}

static void boxes_hold_their_triangles_at_all_times(void **state) {
    (void)state;
    arena a = arena_create(5);
    accel *built = scene_build(a.scene, 3, 0, NULL);
    rng r = {9};
    for (size_t i = 0; i < a.mesh_count; i++)
        for (int n = 0; n < 200; n++) {
            keyed *k = a.meshes[i];
            float w[2], time = choose_time(k, &r);
            size_t key = interval_of(k, time, w), next = w[1] != 0 ? key + 1 : key;
            bounds3 all;
            keyed_at(k, time, a.still[i]);
            size_t seen =
                check_node(&built->geometries[i].tree, k, a.still[i], 0, key, next, w, &all);
            assert_int_equal(seen, mesh_triangle_count(&k->desc));
            const bvh_tree *tree = &built->geometries[i].tree;
            float m = 1.1f * tree->margin; /* and no wider than boxes are to be */
            bounds3 wide = {vec3_sub(tree->bounds.min, (vec3){m, m, m}),
                            vec3_add(tree->bounds.max, (vec3){m, m, m})};
            bounds3 whole = bounds3_union(all, wide);
            assert_memory_equal(&whole, &wide, sizeof whole);
        }
    accel_destroy(built);
    arena_destroy(&a);
}

/* What a tree over the boxes of all times would be: parts that test themselves. One thread, one time. */
typedef struct swept {
    keyed *k;
    mesh_desc *still;
} swept;

static uint32_t swept_count(const void *desc) {
    return (uint32_t)mesh_triangle_count(&((const swept *)desc)->k->desc);
}
static bounds3 swept_bounds(const void *desc, uint32_t triangle) {
    return mesh_triangle_bounds(&((const swept *)desc)->k->desc, triangle);
}
static bounds3 swept_all(const void *desc) { return box_at_all_times(((const swept *)desc)->k); }
static bool swept_intersect(const void *desc, const local_ray *beam, hit *found) {
    const mesh_desc *m = ((const swept *)desc)->still;
    const uint32_t *index = m->indices + 3 * (size_t)found->primitive;
    const vec3 vertex[3] = {m->positions[index[0]], m->positions[index[1]], m->positions[index[2]]};
    plain_ray p = plain_ray_make(beam->o, beam->d, beam->t_min, beam->t_max);
    return plain_triangle(&p, vertex, &found->t, &found->u, &found->v) && found->t > beam->t_min &&
           found->t < beam->t_max;
}
static const primitive_type swept_type = {.bounds = swept_all,
                                          .primitive_count = swept_count,
                                          .primitive_bounds = swept_bounds,
                                          .intersect = swept_intersect};

/* Work per ray: of the mesh that deforms, of a tree over the boxes of all times, and of a mesh that
 * stands still as it is at the ray's time, which nothing can be better than. */
static void compare_work(const char *name, keyed *k, double most_over_still, double least_saved) {
    enum { TIMES = 16, RAYS = 400 };
    static ray rays[RAYS];
    static hit hits[3][RAYS];
    trace_counters c[3] = {{0}};
    test_scene *s[3] = {scene_create(), scene_create(), scene_create()};
    keyed_prepare(k, -INFINITY, INFINITY);
    scene_add_geometry(s[0], &primitive_deforming, k->all);
    mesh_desc *still = scene_add_mesh(s[2], k->vertices, mesh_triangle_count(&k->desc));
    memcpy(mesh_indices(still), k->desc.indices, k->desc.indices_count * sizeof(uint32_t));
    swept loose = {k, still};
    scene_add_geometry(s[1], &swept_type, &loose);
    for (int i = 0; i < 3; i++) scene_add_instance(s[i], 0, NULL);
    accel *tight = scene_build(s[0], 0, 0, NULL), *wide = scene_build(s[1], 0, 0, NULL);
    rng r = {11};
    for (int t = 0; t < TIMES; t++) {
        float time = k->times[0] + (k->times[k->desc.key_times_count - 1] - k->times[0]) *
                                       ((float)t + 0.5f) / TIMES;
        keyed_at(k, time, still);
        accel *ideal = scene_build(s[2], 0, 0, NULL);
        bounds3 box = box_at_all_times(k);
        for (size_t i = 0; i < RAYS; i++) {
            dvec3 at[2];
            for (int end = 0; end < 2; end++)
                at[end] = (dvec3){rng_float(&r, box.min.x, box.max.x),
                                  rng_float(&r, box.min.y, box.max.y),
                                  rng_float(&r, box.min.z, box.max.z)};
            dvec3 d = dvec3_sub(at[1], at[0]);
            vec3 o = vec3_from(dvec3_sub(at[0], dvec3_scale(d, 5)));
            rays[i] = ray_make(o, vec3_from(d), 0, INFINITY);
            rays[i].time = time;
        }
        accel *trees[3] = {tight, wide, ideal};
        for (int i = 0; i < 3; i++)
            accel_trace(trees[i], SNELL_ISA_AUTO, rays, hits[i], RAYS, &c[i]);
        for (size_t i = 0; i < RAYS; i++) {
            assert_true(same_hit(&hits[0][i], &hits[2][i]));
            assert_int_equal(hits[0][i].instance, hits[1][i].instance);
        }
        accel_destroy(ideal);
    }
    double nodes[3], tests[3];
    for (int i = 0; i < 3; i++) {
        nodes[i] = (double)c[i].nodes / (TIMES * RAYS);
        tests[i] = (double)(c[i].triangles + c[i].primitives) / (TIMES * RAYS);
    }
    printf(
        "%s, nodes and triangles a ray: %.2f and %.2f; boxes of all times %.2f and %.2f; standing "
        "still %.2f and %.2f\n",
        name, nodes[0], tests[0], nodes[1], tests[1], nodes[2], tests[2]);
    assert_true(nodes[0] < most_over_still * nodes[2] && tests[0] < most_over_still * tests[2]);
    assert_true(nodes[1] > least_saved * nodes[0] && tests[1] > least_saved * tests[0]);
    accel_destroy(tight);
    accel_destroy(wide);
    for (int i = 0; i < 3; i++) scene_destroy(s[i]);
}

/* Two balls that pass through one another, and come back if asked to. */
static keyed *make_crossing(bool back) {
    test_scene *s = scene_create();
    const mesh_desc *sphere = scene_add_uv_sphere(s, 70, 35, 1, (dvec3){0, 0, 0});
    size_t vertices = sphere->positions_count, indices = sphere->indices_count, keys = back ? 3 : 2;
    keyed *k = keyed_create(2 * vertices, 2 * indices / 3, keys);
    for (size_t i = 0; i < 2 * indices; i++)
        mesh_indices(&k->desc)[i] =
            sphere->indices[i % indices] + (i < indices ? 0 : (uint32_t)vertices);
    for (size_t key = 0; key < keys; key++) {
        k->times[key] = (float)key;
        for (size_t i = 0; i < 2 * vertices; i++) {
            float side = (i < vertices) == (key == 1) ? -3.0f : 3.0f;
            vec3 p = sphere->positions[i % vertices];
            keyed_positions(k, key)[i] = (vec3){p.x + side, p.y, p.z};
        }
    }
    scene_destroy(s);
    return k;
}

static void boxes_are_tight_in_time(void **state) {
    (void)state;
    for (int back = 0; back < 2; back++) {
        keyed *crossing = make_crossing(back);
        compare_work(back ? "two balls that cross and come back" : "two balls that cross", crossing,
                     1.5, 5);
        keyed_free(crossing);
    }
    keyed *ball = make_ball(100, 50, (dvec3){0, 0, 0}, 1);
    compare_work("a ball that twists and goes", ball, 1.5, 1.5);
    keyed_free(ball);
    ball = make_ball(100, 50, (dvec3){0, 0, 0}, 6);
    compare_work("the same, faster", ball, 1.5, 3);
    keyed_free(ball);
}

/* ---- leaks ---- */

static void nothing_leaks_at_any_time(void **state) {
    (void)state;
    static const dvec3 centers[] = {{0, 0, 0}, {14837, 1234, -22342}};
    enum { BATCH = 500 };
    static ray rays[BATCH];
    static hit hits[BATCH];
    static uint8_t blocked[BATCH];
    size_t batches = SANITIZED ? 4 : test_full() ? 20000 : 400;
    for (size_t c = 0; c < COUNT_OF(centers); c++) {
        test_scene *s = scene_create(), *other = scene_create();
        keyed *k = make_ball(120, 60, centers[c], 0.3);
        keyed_prepare(k, -INFINITY, INFINITY);
        scene_add_geometry(s, &primitive_deforming, k->all);
        scene_add_instance(s, 0, NULL);
        mesh_desc *still = scene_add_mesh(other, k->vertices, mesh_triangle_count(&k->desc));
        memcpy(mesh_indices(still), k->desc.indices, k->desc.indices_count * sizeof(uint32_t));
        accel *a = scene_build(s, 0, 0, NULL);
        rng r = {c + 21};
        size_t leaks = 0;
        for (size_t batch = 0; batch < batches; batch++) {
            float time = choose_time(k, &r);
            keyed_at(k, time, still);
            double gone = 0.3 * double_min(double_max(4 * (double)time, 0), 3);
            for (size_t i = 0; i < BATCH; i++) {
                const uint32_t *index =
                    still->indices +
                    3 * (size_t)rng_below(&r, (uint32_t)mesh_triangle_count(still));
                double u = i % 4 == 0   ? 0
                           : i % 4 == 1 ? 0.5
                                        : rng_unit(&r),
                       v = i % 4 == 3 ? (1 - u) * rng_unit(&r) : 0;
                dvec3 p = dvec3_scale(dvec3_from(still->positions[index[0]]), 1 - u - v);
                p = dvec3_add(p, dvec3_scale(dvec3_from(still->positions[index[1]]), u));
                p = dvec3_add(p, dvec3_scale(dvec3_from(still->positions[index[2]]), v));
                dvec3 o = {centers[c].x + gone + rng_float(&r, -0.5, 0.5),
                           centers[c].y + rng_float(&r, -0.5, 0.5),
                           centers[c].z + rng_float(&r, -0.5, 0.5)};
                vec3 from = vec3_from(o);
                rays[i] = ray_make(from, vec3_sub(vec3_from(p), from), 0, INFINITY);
                rays[i].time = time;
            }
            accel_trace(a, SNELL_ISA_AUTO, rays, hits, BATCH, NULL);
            accel_occluded(a, SNELL_ISA_AUTO, rays, blocked, BATCH, NULL);
            for (size_t i = 0; i < BATCH; i++) leaks += hits[i].instance == NO_ID || !blocked[i];
        }
        printf("%zu rays from inside, %zu leaks\n", batches * BATCH, leaks);
        assert_int_equal(leaks, 0);
        accel_destroy(a);
        keyed_free(k);
        scene_destroy(s);
        scene_destroy(other);
    }
}

/* ---- keys in use ---- */

static void only_the_keys_about_the_shutter_are_used(void **state) {
    (void)state;
    rng r = {12};
    keyed *k = make_soup(&r);
    const float *t = k->times;
    const struct {
        double open, close;
        uint32_t keys, first;
    } cases[] = {
        {-INFINITY, INFINITY, 5, 0},
        {(double)t[1], (double)t[2], 2, 1},
        {(double)t[1] + 1e-4, (double)t[1] + 2e-4, 2, 1},
        {(double)t[2] - 1e-4, (double)t[2] + 1e-4, 3, 1},
        {(double)t[2], (double)t[2], 1, 2},
        {-9, -8, 1, 0},
        {90, 91, 1, 4},
        {-9, (double)t[0] + 1e-4, 2, 0},
        {(double)t[4] - 1e-4, 91, 2, 3},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        keyed_prepare(k, cases[i].open, cases[i].close);
        assert_int_equal(k->all->key_count, cases[i].keys);
        assert_int_equal(deforming_count_keys(&k->desc, cases[i].open, cases[i].close),
                         cases[i].keys);
        assert_ptr_equal(k->all->times, t + cases[i].first);
        assert_ptr_equal(k->all->mesh.positions, keyed_positions(k, cases[i].first));
        if (isinf(cases[i].open)) continue;
        /* What is seen in that time is what it is with all keys. */
        test_scene *some = scene_create(), *all = scene_create();
        deforming_mesh *whole = deforming_create(&k->desc, -INFINITY, INFINITY);
        assert_non_null(whole);
        scene_add_geometry(some, &primitive_deforming, k->all);
        scene_add_geometry(all, &primitive_deforming, whole);
        scene_add_instance(some, 0, NULL);
        scene_add_instance(all, 0, NULL);
        accel *a = scene_build(some, 0, 0, NULL), *b = scene_build(all, 0, 0, NULL);
        size_t found = 0;
        for (int n = 0; n < 500; n++) {
            vec3 o = rng_vec3(&r, 6);
            ray beam = ray_make(o, vec3_sub(rng_vec3(&r, 3), o), 0, INFINITY);
            beam.time = (float)(cases[i].open + (cases[i].close - cases[i].open) * rng_unit(&r));
            hit got, wanted;
            accel_trace(a, SNELL_ISA_AUTO, &beam, &got, 1, NULL);
            accel_trace(b, SNELL_ISA_AUTO, &beam, &wanted, 1, NULL);
            assert_true(same_hit(&got, &wanted));
            found += got.instance != NO_ID;
        }
        assert_true(found > 50);
        accel_destroy(a);
        accel_destroy(b);
        free(whole);
        scene_destroy(some);
        scene_destroy(all);
    }
    keyed_free(k);
}

/* ---- surfaces ---- */

/* The same as those of a mesh that stands still as it is at the time: point, normals, error, area. */
static void surfaces_are_those_of_the_mesh_at_the_time(void **state) {
    (void)state;
    rng r = {13};
    keyed *k = make_soup(&r);
    size_t keys = k->desc.key_times_count;
    vec3 *normals = calloc(k->vertices * keys, sizeof *normals),
         *now = calloc(k->vertices, sizeof *now);
    assert_true(normals && now);
    for (size_t i = 0; i < k->vertices * keys; i++) normals[i] = rng_vec3(&r, 1);
    k->desc.normals = normals;
    k->desc.normals_count = k->vertices * keys;
    keyed_prepare(k, -INFINITY, INFINITY);
    test_scene *s = scene_create();
    mesh_desc *still = scene_add_mesh(s, k->vertices, mesh_triangle_count(&k->desc));
    memcpy(mesh_indices(still), k->desc.indices, k->desc.indices_count * sizeof(uint32_t));
    still->normals = now;
    still->normals_count = k->vertices;
    for (int n = 0; n < 5000; n++) {
        float w[2], time = choose_time(k, &r);
        size_t key = interval_of(k, time, w), next = w[1] != 0 ? key + 1 : key;
        keyed_at(k, time, still);
        for (size_t i = 0; i < k->vertices; i++) { /* between unit vectors */
            dvec3 a = dvec3_normalize(dvec3_from(normals[key * k->vertices + i])),
                  b = dvec3_normalize(dvec3_from(normals[next * k->vertices + i]));
            now[i] =
                vec3_from(dvec3_add(dvec3_scale(a, (double)w[0]), dvec3_scale(b, (double)w[1])));
        }
        deforming_mesh room;
        const void *posed = deforming_pose(&primitive_deforming, k->all, time, &room);
        float u = rng_float(&r, 0, 1), v = rng_float(&r, 0, 1 - (double)u);
        hit h = {.u = u, .v = v, .primitive = rng_below(&r, swept_count(&(swept){k, still}))};
        local_ray beam = {{0, 9, 0}, {0, -1, 0}, 0, INFINITY};
        surface got, wanted;
        primitive_deforming.surface(posed, &beam, &h, &got);
        primitive_mesh.surface(still, &beam, &h, &wanted);
        assert_memory_equal(&got.p, &wanted.p, sizeof got.p);
        assert_memory_equal(&got.n, &wanted.n, sizeof got.n);
        assert_true(got.error == wanted.error);
        assert_true(dvec3_length(dvec3_sub(got.ns, wanted.ns)) < 1e-4);
        double area = primitive_mesh.area(still, h.primitive);
        assert_true(primitive_deforming.area(posed, h.primitive) == area);
        bounds3 a = primitive_deforming.primitive_bounds(posed, h.primitive),
                b = primitive_mesh.primitive_bounds(still, h.primitive);
        assert_memory_equal(&a, &b, sizeof a);
        primitive_deforming.sample_area(posed, h.primitive, (double)u, (double)v, &got);
        primitive_mesh.sample_area(still, h.primitive, (double)u, (double)v, &wanted);
        assert_memory_equal(&got.p, &wanted.p, sizeof got.p);
        dvec3 dp = {1e-3, 2e-3, -1e-3}, bent = primitive_deforming.bend(posed, &h, dp),
              straight = primitive_mesh.bend(still, &h, dp);
        double size = dvec3_length(straight);
        if (area > 0.01)
            assert_true(dvec3_length(dvec3_sub(bent, straight)) < 1e-3 * (size + 0.01));
        /* Of all times: it holds every key, and the area is the largest of the keys. */
        bounds3 whole = primitive_deforming.primitive_bounds(k->all, h.primitive),
                joined = bounds3_union(whole, mesh_triangle_bounds(&k->desc, h.primitive));
        assert_memory_equal(&joined, &whole, sizeof whole);
        if (w[1] == 0) assert_true(primitive_deforming.area(k->all, h.primitive) >= area);
    }
    free(normals);
    free(now);
    keyed_free(k);
    scene_destroy(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_hit_is_that_of_trying_every_triangle),
        cmocka_unit_test(counters_are_equal_between_instruction_sets),
        cmocka_unit_test(threads_build_the_same_tree),
        cmocka_unit_test(boxes_hold_their_triangles_at_all_times),
        cmocka_unit_test(boxes_are_tight_in_time),
        cmocka_unit_test(nothing_leaks_at_any_time),
        cmocka_unit_test(only_the_keys_about_the_shutter_are_used),
        cmocka_unit_test(surfaces_are_those_of_the_mesh_at_the_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
