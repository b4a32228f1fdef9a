/* Building: the same tree for any number of threads, bounded depth, progress and cancelling, and
 * inputs without anything in them. */
#include "accel_test.h"

#include "accel/build.h"

static bool same_tree(const bvh_tree *a, const bvh_tree *b) {
    return a->node_count == b->node_count && a->block_count == b->block_count &&
           a->root == b->root &&
           memcmp(a->nodes, b->nodes, a->node_count * sizeof *a->nodes) == 0 &&
           (a->block_count == 0 ||
            memcmp(a->blocks, b->blocks, a->block_count * sizeof *a->blocks) == 0);
}

static void the_tree_does_not_depend_on_threads(void **state) {
    (void)state;
    test_scene *s = scene_create();
    scene_add_uv_sphere(s, 300, 300, 2, (dvec3){0, 0, 0}); /* large: swept and split among tasks */
    scene_add_uv_sphere(s, 50, 60, 1, (dvec3){1, 0, 0});   /* small: one of several */
    scene_add_uv_sphere(s, 5, 4, 1, (dvec3){1, 0, 0});
    for (uint32_t i = 0; i < 300; i++) {
        transform m = transform_identity();
        m.m[0][3] = (float)(i % 17);
        m.m[1][3] = (float)(i % 23);
        scene_add_instance(s, i % 3, i ? &m : NULL);
    }
    accel *first = NULL;
    for (uint32_t quality = ACCEL_QUALITIES; quality-- > 0;) { /* balanced last */
        accel_options options = {.quality = (accel_quality)quality};
        if (first) accel_destroy(first);
        first = scene_build_as(s, &options, NULL);
        const uint32_t threads[] = {1, 2, 3, 8};
        for (size_t i = 0; i < COUNT_OF(threads); i++) {
            thread_pool *pool = NULL;
            assert_int_equal(thread_pool_create(threads[i], &pool), SNELL_OK);
            accel *a = scene_build_as(s, &options, pool);
            assert_true(same_tree(&a->world.top, &first->world.top));
            for (size_t g = 0; g < a->geometry_count; g++)
                assert_true(same_tree(&a->geometries[g].tree, &first->geometries[g].tree));
            accel_memory m = accel_get_memory(a), m0 = accel_get_memory(first);
            assert_memory_equal(&m, &m0, sizeof m);
            accel_destroy(a);
            thread_pool_destroy(pool);
        }
    }
    accel_memory m = accel_get_memory(first);
    assert_int_equal(m.triangle_count, 2 * 300 * 299 + 2 * 50 * 59 + 2 * 5 * 3);
    printf("%.1f bytes a triangle: %.1f in nodes, %.1f in triangles\n",
           (double)(m.node_bytes + m.triangle_bytes) / (double)m.triangle_count,
           (double)m.node_bytes / (double)m.triangle_count,
           (double)m.triangle_bytes / (double)m.triangle_count);
    accel_destroy(first);
    scene_destroy(s);
}

/* Every triangle is in the tree exactly once; returns the depth. */
static uint32_t count_triangles(const bvh_tree *tree, uint32_t reference, uint8_t *seen) {
    if (reference & BVH_LEAF) {
        const triangle_block *b = &tree->blocks[reference & BVH_INDEX_MASK];
        for (uint32_t i = 0; i <= (reference >> BVH_COUNT_SHIFT & 7); i++) seen[b->primitive[i]]++;
        return 0;
    }
    uint32_t depth = 0;
    const bvh_node *node = &tree->nodes[reference];
    for (uint32_t i = 0; i < BVH_WIDTH; i++) {
        if (!(node->valid >> i & 1)) continue;
        uint32_t below = count_triangles(tree, node->child[i], seen);
        if (below > depth) depth = below;
    }
    return depth + 1;
}

static void check_tree(test_scene *s, accel_options options) {
    accel *a = scene_build_as(s, &options, NULL);
    size_t count = mesh_triangle_count(s->geometries[0].desc);
    uint8_t *seen = calloc(count, 1);
    assert_non_null(seen);
    uint32_t depth = count_triangles(&a->geometries[0].tree, a->geometries[0].tree.root, seen);
    for (size_t i = 0; i < count; i++) assert_int_equal(seen[i], 1);
    assert_true(depth <= BVH_DEPTH_MAX);
    free(seen);
    accel_destroy(a);
}

/* Sizes and places over the whole range of floats, so that SAH cuts off a few at a time; and
 * thousands in one place, which nothing can tell apart. */
static void hostile_meshes_keep_the_depth_bounded(void **state) {
    (void)state;
    enum { COUNT = 20000 };
    test_scene *shrinking = scene_create(), *equal = scene_create();
    mesh_desc *a = scene_add_mesh(shrinking, 3 * COUNT, COUNT);
    mesh_desc *b = scene_add_mesh(equal, 3, COUNT);
    for (uint32_t i = 0; i < 3 * COUNT; i++) {
        float x = (float)pow(2, 120 - 240.0 * (i / 3) / COUNT);
        mesh_indices(a)[i] = i;
        mesh_positions(a)[i] = (vec3){x, i % 3 == 1 ? x : 0, i % 3 == 2 ? x : 0};
        mesh_indices(b)[i] = i % 3;
        mesh_positions(b)[i % 3] = (vec3){(float)(i % 2), 1, (float)(i % 3)};
    }
    scene_add_instance(shrinking, 0, NULL);
    scene_add_instance(equal, 0, NULL);
    for (uint32_t seed = 0; seed < 4; seed++)
        for (uint32_t leaf = 1; leaf <= 8; leaf *= 2) {
            check_tree(shrinking, (accel_options){.leaf_size = leaf, .seed = seed});
            check_tree(equal, (accel_options){.leaf_size = leaf, .seed = seed});
        }
    const accel_quality others[] = {ACCEL_FAST, ACCEL_BEST};
    for (size_t i = 0; i < COUNT_OF(others); i++)
        for (uint32_t leaf = 1; leaf <= 8; leaf *= 2) {
            check_tree(shrinking, (accel_options){.leaf_size = leaf, .quality = others[i]});
            check_tree(equal, (accel_options){.leaf_size = leaf, .quality = others[i]});
        }
    scene_destroy(shrinking);
    scene_destroy(equal);
}

/* The area of all nodes but the root, and of leaves. */
static double area_below(const bvh_tree *tree) {
    double area = 0;
    for (size_t n = 0; n < tree->node_count; n++)
        for (uint32_t i = 0; i < BVH_WIDTH; i++) {
            const bvh_node *node = &tree->nodes[n];
            bounds3 box;
            for (int axis = 0; axis < 3; axis++) {
                (&box.min.x)[axis] = node->bounds[0][axis][i];
                (&box.max.x)[axis] = node->bounds[1][axis][i];
            }
            if (node->valid >> i & 1) area += bounds3_half_area(box);
        }
    return area;
}

/* Clusters of small triangles, and walls through them, which the splits from the top down carry along
 * among the small. */
static void reinsertion_makes_a_tree_of_less_area(void **state) {
    (void)state;
    enum { COUNT = 30000, CLUSTER = 1000 };
    test_scene *s = scene_create();
    mesh_desc *mesh = scene_add_mesh(s, 3 * COUNT, COUNT);
    rng r = {7};
    vec3 center = {0, 0, 0};
    for (uint32_t i = 0; i < COUNT; i++) {
        bool wall = i % CLUSTER < 4;
        if (i % CLUSTER == 0)
            center = (vec3){rng_float(&r, 0, 10), rng_float(&r, 0, 10), rng_float(&r, 0, 10)};
        double size = wall ? 5 : 0.02, spread = wall ? 0 : 0.5;
        for (uint32_t v = 0; v < 3; v++) mesh_indices(mesh)[3 * i + v] = 3 * i + v;
        vec3 p = {rng_float(&r, -spread, spread), rng_float(&r, -spread, spread),
                  rng_float(&r, -spread, spread)};
        for (uint32_t v = 0; v < 3; v++)
            mesh_positions(mesh)[3 * i + v] = vec3_add(
                vec3_add(center, p), (vec3){rng_float(&r, -size, size), rng_float(&r, -size, size),
                                            wall ? 0 : rng_float(&r, -size, size)});
    }
    scene_add_instance(s, 0, NULL);
    double area[ACCEL_QUALITIES];
    for (int quality = 0; quality < ACCEL_QUALITIES; quality++) {
        accel *a = scene_build_as(s, &(accel_options){.quality = (accel_quality)quality}, NULL);
        area[quality] = area_below(&a->geometries[0].tree);
        printf("%s: %.2f\n", accel_quality_names[quality], area[quality]);
        accel_destroy(a);
    }
    assert_true(area[ACCEL_BEST] < 0.98 * area[ACCEL_BALANCED]);
    assert_true(area[ACCEL_BALANCED] < area[ACCEL_FAST]);
    scene_destroy(s);
}

/* Clusters far apart of so many small triangles, all but eight of them ever nearer to a point, so that
 * SAH would give each of those a leaf of its own. */
static void fill_clusters(mesh_desc *mesh, uint32_t count, uint32_t of) {
    rng r = {11};
    dvec3 center = {0, 0, 0};
    for (uint32_t i = 0; i < count; i++) {
        double away = i % of + 8 >= of ? 1e-6 : 1e-3 * pow(0.2, i % of);
        if (i % of == 0)
            center = (dvec3){rng_float(&r, 0, 1), rng_float(&r, 0, 1), rng_float(&r, 0, 1)};
        for (uint32_t v = 0; v < 3; v++) {
            mesh_indices(mesh)[3 * i + v] = 3 * i + v;
            mesh_positions(mesh)[3 * i + v] =
                (vec3){(float)(center.x + away + (double)rng_float(&r, -1e-7, 1e-7)),
                       (float)(center.y + away), (float)(center.z + away + (v == 1 ? 1e-7 : 0))};
        }
    }
}

/* However small they are, and whatever SAH would like best; in as many leaves as are stated, too. */
static void trees_are_not_larger_than_planned(void **state) {
    (void)state;
    const uint32_t clusters[] = {1, 2, 9, 14, 19}, counts[] = {1, 8, 9, 17, 1000, 60000};
    double most = 0;
    for (size_t i = 0; i < COUNT_OF(clusters) * COUNT_OF(counts); i++) {
        uint32_t count = counts[i % COUNT_OF(counts)];
        test_scene *s = scene_create();
        fill_clusters(scene_add_mesh(s, 3 * count, count), count, clusters[i / COUNT_OF(counts)]);
        scene_add_instance(s, 0, NULL);
        build_bytes plan = build_plan(true, BUILD_LEAF_SIZE, count);
        for (int quality = 0; quality < ACCEL_QUALITIES; quality++) {
            accel *a = scene_build_as(s, &(accel_options){.quality = (accel_quality)quality}, NULL);
            const bvh_tree *t = &a->geometries[0].tree;
            uint64_t bytes = t->node_count * sizeof *t->nodes + t->block_count * sizeof *t->blocks;
            assert_true(t->block_count <= count / 4 + 1);
            assert_true(bytes <= plan.stays);
            most = fmax(most, (double)bytes / (double)plan.stays);
            accel_destroy(a);
        }
        scene_destroy(s);
    }
    printf("at most %.2f of what is planned\n", most);
}

static void nothing_can_be_built_and_traced(void **state) {
    (void)state;
    test_scene *s = scene_create();
    ray r = ray_make((vec3){0, 0, 0}, (vec3){0, 0, 1}, 0, INFINITY);
    for (int i = 0; i < 2; i++) { /* no instance; then one of an empty mesh */
        accel *a = scene_build(s, 0, 0, NULL);
        hit h;
        uint8_t blocked;
        accel_trace(a, SNELL_ISA_AUTO, &r, &h, 1, NULL);
        accel_occluded(a, SNELL_ISA_AUTO, &r, &blocked, 1, NULL);
        assert_int_equal(h.instance, NO_ID);
        assert_int_equal(blocked, 0);
        assert_true(bounds3_is_empty(accel_bounds(a)));
        accel_destroy(a);
        scene_add_mesh(s, 0, 0);
        scene_add_instance(s, 0, NULL);
    }
    scene_destroy(s);
}

static void bounds_are_of_the_world_without_planes(void **state) {
    (void)state;
    test_scene *s = scene_create();
    uint32_t ball = scene_add_shape(s, "sphere", "center", (vec3){0, 0, 0}, "radius", 1);
    uint32_t plane = scene_add_shape(s, "plane", "point", (vec3){0, -9, 0}, NULL, 0);
    transform m = transform_identity();
    m.m[1][1] = -3;
    m.m[0][3] = 10;
    scene_add_instance(s, plane, NULL);
    scene_add_instance(s, ball, NULL);
    scene_add_instance(s, ball, &m);
    accel *a = scene_build(s, 0, 0, NULL);
    bounds3 box = accel_bounds(a);
    assert_true(box.min.x == -1 && box.min.y == -3 && box.min.z == -1);
    assert_true(box.max.x == 11 && box.max.y == 3 && box.max.z == 1);
    accel_destroy(a);
    scene_destroy(s);
}

typedef struct watcher {
    int calls, allowed;
    double last;
    bool ordered;
} watcher;

static bool watch(void *user, double fraction) {
    watcher *w = user;
    w->ordered = w->ordered && fraction >= w->last && fraction <= 1;
    w->last = fraction;
    return w->calls++ < w->allowed;
}

static void progress_is_told_and_stops_the_build(void **state) {
    (void)state;
    test_scene *s = scene_create();
    scene_add_uv_sphere(s, 150, 150, 2, (dvec3){0, 0, 0});
    scene_add_uv_sphere(s, 40, 40, 2, (dvec3){0, 0, 0});
    scene_add_instance(s, 0, NULL);
    scene_add_instance(s, 1, NULL);
    accel_input input = {s->geometries, s->geometry_count, s->instances, s->instance_count};
    thread_pool *pool = NULL;
    assert_int_equal(thread_pool_create(3, &pool), SNELL_OK);
    for (int allowed = 0; allowed < 20; allowed++) {
        watcher w = {.allowed = allowed, .ordered = true};
        accel_options options = {.progress = watch, .user = &w};
        accel *a = NULL;
        snell_status status = accel_build(&input, &options, pool, &a);
        assert_true(w.ordered);
        assert_true(w.calls > 0);
        assert_int_equal(status, w.calls > allowed ? SNELL_CANCELLED : SNELL_OK);
        if (status == SNELL_OK)
            accel_destroy(a);
        else
            assert_null(a);
    }
    watcher w = {.allowed = 1 << 20, .ordered = true};
    accel_options options = {.progress = watch, .user = &w};
    accel *a = NULL;
    assert_int_equal(accel_build(&input, &options, pool, &a), SNELL_OK);
    assert_true(w.last == 1);
    accel_destroy(a);
    thread_pool_destroy(pool);
    scene_destroy(s);
}

static void an_instance_of_nothing_is_an_error(void **state) {
    (void)state;
    accel_instance instance = {.geometry = 1};
    accel_input input = {.instances = &instance, .instance_count = 1};
    accel *a = NULL;
    assert_int_equal(accel_build(&input, NULL, NULL, &a), SNELL_ERR_ARGUMENT);
    assert_null(a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_tree_does_not_depend_on_threads),
        cmocka_unit_test(hostile_meshes_keep_the_depth_bounded),
        cmocka_unit_test(reinsertion_makes_a_tree_of_less_area),
        cmocka_unit_test(trees_are_not_larger_than_planned),
        cmocka_unit_test(nothing_can_be_built_and_traced),
        cmocka_unit_test(bounds_are_of_the_world_without_planes),
        cmocka_unit_test(progress_is_told_and_stops_the_build),
        cmocka_unit_test(an_instance_of_nothing_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
