/* The hit rule under attack: whatever the tree, the order of visits and the instruction set, the
 * winner is the one that trying every primitive gives, bit for bit. */
#include "accel_test.h"

static const snell_isa isas[] = {SNELL_ISA_SCALAR, SNELL_ISA_AVX2, SNELL_ISA_AVX512};
static const char *const isa_names[] = {"scalar", "avx2", "avx512"};

/* ---- scenes ---- */

static transform random_transform(rng *r, bool mirrored) {
    transform m;
    do {
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 4; j++) m.m[i][j] = rng_float(r, j == 3 ? -3 : -1, j == 3 ? 3 : 1);
    } while (fabs(transform_determinant(&m)) < 0.1 || (transform_determinant(&m) < 0) != mirrored);
    return m;
}

static void fill_grid(mesh_desc *mesh, uint32_t n) {
    vec3 *p = mesh_positions(mesh);
    uint32_t *index = mesh_indices(mesh);
    for (uint32_t i = 0; i <= n; i++)
        for (uint32_t j = 0; j <= n; j++) *p++ = (vec3){(float)i, 0, (float)j};
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < n; j++) {
            uint32_t a = i * (n + 1) + j;
            uint32_t quad[6] = {a, a + 1, a + n + 1, a + n + 1, a + 1, a + n + 2};
            memcpy(index, quad, sizeof quad);
            index += 6;
        }
}

/* A flat grid on whole numbers, again as a second mesh and moved by whole numbers as instances:
 * everything coincides. */
static void make_flat_grid(test_scene *s, rng *r) {
    (void)r;
    fill_grid(scene_add_mesh(s, 25, 32), 4);
    fill_grid(scene_add_mesh(s, 9, 8), 2);
    transform shift = transform_identity();
    shift.m[0][3] = 1;
    scene_add_instance(s, 1, NULL);
    scene_add_instance(s, 0, NULL);
    scene_add_instance(s, 0, &shift);
    scene_add_instance(s, 1, &shift);
    scene_add_instance(s, 0, NULL);
}

/* Long thin triangles that share their long edges, and some without area. */
static void make_slivers(test_scene *s, rng *r) {
    enum { FANS = 16, BLADES = 5 };
    mesh_desc *mesh = scene_add_mesh(s, FANS * (BLADES + 2), FANS * BLADES);
    vec3 *p = mesh_positions(mesh);
    uint32_t *index = mesh_indices(mesh);
    for (uint32_t i = 0; i < FANS; i++) {
        uint32_t base = i * (BLADES + 2);
        vec3 far_end = rng_vec3(r, 10), step = rng_vec3(r, i % 2 ? 1e-5 : 1e-3);
        p[base] = rng_vec3(r, 10);
        for (uint32_t j = 0; j <= BLADES; j++)
            p[base + 1 + j] = vec3_add(far_end, vec3_scale(step, (float)(j / (1 + i % 2))));
        for (uint32_t j = 0; j < BLADES; j++) {
            uint32_t blade[3] = {base, base + 1 + j, base + 2 + j};
            memcpy(index, blade, sizeof blade);
            index += 3;
        }
    }
    scene_add_instance(s, 0, NULL);
}

static void make_far_sphere_mesh(test_scene *s, rng *r) {
    (void)r;
    scene_add_uv_sphere(s, 8, 8, 2, (dvec3){148376, 1234, -223423});
    scene_add_uv_sphere(s, 6, 6, 1, (dvec3){148376, 1234, -223423});
    scene_add_instance(s, 0, NULL);
    scene_add_instance(s, 1, NULL);
}

/* One mesh, whose every triangle is there twice: a flat grid and others any way. */
static void make_double_faces(test_scene *s, rng *r) {
    enum { OTHERS = 40, ALL = 32 + OTHERS };
    mesh_desc *mesh = scene_add_mesh(s, 25 + 3 * OTHERS, 2 * ALL);
    fill_grid(mesh, 4);
    vec3 *p = mesh_positions(mesh);
    uint32_t *index = mesh_indices(mesh);
    for (uint32_t i = 0; i < OTHERS; i++) {
        vec3 middle = vec3_add((vec3){2, 0, 2}, rng_vec3(r, 2));
        for (uint32_t k = 0; k < 3; k++) {
            p[25 + 3 * i + k] = vec3_add(middle, rng_vec3(r, 0.7));
            index[96 + 3 * i + k] = 25 + 3 * i + k;
        }
    }
    memcpy(index + 3 * ALL, index, 3 * ALL * sizeof *index);
    scene_add_instance(s, 0, NULL);
}

/* Far off: what boxes are wider by, and what t is rounded to, is as much as a triangle. */
static void make_far_mesh(test_scene *s, rng *r) {
    (void)r;
    scene_add_uv_sphere(s, 24, 24, 0.4, (dvec3){148376, 1234, -223423});
    scene_add_instance(s, 0, NULL);
}

/* Cubes of triangles under any transforms: turned, sheared, mirrored, twice in the same place. */
static void make_instances(test_scene *s, rng *r) {
    mesh_desc *mesh = scene_add_mesh(s, 8, 12);
    for (uint32_t i = 0; i < 8; i++)
        mesh_positions(mesh)[i] = (vec3){(float)(i & 1), (float)(i >> 1 & 1), (float)(i >> 2)};
    static const uint32_t faces[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    memcpy(mesh_indices(mesh), faces, sizeof faces);
    scene_add_instance(s, 0, NULL);
    for (int i = 0; i < 4; i++) {
        transform m = random_transform(r, i % 2);
        scene_add_instance(s, 0, &m);
        if (i == 2) scene_add_instance(s, 0, &m);
    }
}

/* Small and large spheres far away: their surfaces leave their boxes by rounding. */
static void make_far_spheres(test_scene *s, rng *r) {
    for (int i = 0; i < 24; i++) {
        float distance = (float)pow(10, rng_float(r, 1, 6));
        vec3 center = vec3_scale(rng_vec3(r, 1), distance);
        uint32_t g = scene_add_shape(s, "sphere", "center", center, "radius",
                                     distance * (float)pow(10, rng_float(r, -4, -1)));
        scene_add_instance(s, g, NULL);
        if (i % 4 == 0) scene_add_instance(s, g, NULL);
        transform m = random_transform(r, i % 2);
        if (i % 3 == 0) scene_add_instance(s, g, &m);
    }
}

/* One of each analytic shape, among them flat ones that coincide with triangles. */
static void make_mixture(test_scene *s, rng *r) {
    fill_grid(scene_add_mesh(s, 9, 8), 2);
    uint32_t plane = scene_add_shape(s, "plane", "point", (vec3){0, 0, 0}, NULL, 0);
    uint32_t quad = scene_add_shape(s, "quad", NULL, (vec3){0, 0, 0}, NULL, 0);
    uint32_t disk = scene_add_shape(s, "disk", "center", (vec3){0, 0, 0}, "radius", 2);
    uint32_t box = scene_add_shape(s, "box", NULL, (vec3){0, 0, 0}, NULL, 0);
    uint32_t ball = scene_add_shape(s, "sphere", "center", (vec3){1, 0, 1}, "radius", 1);
    const uint32_t all[] = {plane, quad, disk, box, ball, 0};
    for (size_t i = 0; i < COUNT_OF(all); i++) {
        scene_add_instance(s, all[i], NULL);
        transform m = random_transform(r, i % 2), shift = transform_identity();
        shift.m[1][3] = 1;
        scene_add_instance(s, all[i], i % 2 ? &m : &shift);
        scene_add_instance(s, all[i], NULL);
    }
}

/* So few shapes that one node holds them all. */
static void make_few(test_scene *s, rng *r) {
    uint32_t plane = scene_add_shape(s, "plane", "point", (vec3){0, 0, 0}, NULL, 0);
    uint32_t quad = scene_add_shape(s, "quad", NULL, (vec3){0, 0, 0}, NULL, 0);
    uint32_t disk = scene_add_shape(s, "disk", "center", (vec3){0, 0, 0}, "radius", 2);
    uint32_t box = scene_add_shape(s, "box", NULL, (vec3){0, 0, 0}, NULL, 0);
    uint32_t ball = scene_add_shape(s, "sphere", "center", (vec3){1, 0, 1}, "radius", 1);
    const uint32_t all[] = {ball, plane, quad, disk, box, ball, ball, quad};
    transform m = random_transform(r, true);
    for (size_t i = 0; i < COUNT_OF(all); i++)
        scene_add_instance(s, all[i], i == 4 || i == 5 ? &m : NULL);
}

/* Triangles anywhere, of any size, some of them points or lines. */
static void make_soup(test_scene *s, rng *r) {
    enum { COUNT = 60 };
    mesh_desc *mesh = scene_add_mesh(s, 3 * COUNT, COUNT);
    for (uint32_t i = 0; i < 3 * COUNT; i++) {
        mesh_indices(mesh)[i] = i % 3 && i % 11 == 0 ? i - 1 : i;
        mesh_positions(mesh)[i] = rng_vec3(r, pow(10, rng_float(r, -3, 1)));
    }
    scene_add_instance(s, 0, NULL);
    transform m = random_transform(r, true);
    scene_add_instance(s, 0, &m);
}

static void set_array(const primitive_type *type, void *desc, const char *name, const void *data,
                      size_t count) {
    snell_param p = {.name = name, .kind = SNELL_PARAM_ARRAY, .value.array = {data, count}};
    assert_int_equal(desc_set(&type->info, desc, &p), SNELL_OK);
}

/* Shapes of many parts, which have trees of their own: strands, a terrain, patches. */
static void make_parts(test_scene *s, rng *r) {
    enum { POINTS = 32 };
    static const char *const names[] = {"curves", "heightfield", "patch"};
    vec3 *points = scene_own(s, calloc(POINTS, sizeof *points));
    float *heights = scene_own(s, calloc(POINTS, sizeof *heights));
    for (uint32_t i = 0; i < POINTS; i++) {
        points[i] = (vec3){(float)(i % 4), rng_float(r, -0.5, 0.5), (float)(i / 4) / 2};
        heights[i] = rng_float(r, -0.5, 0.5);
    }
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        const primitive_type *type = primitive_find(names[i]);
        void *desc = scene_own(s, calloc(1, type->info.desc_size));
        snell_param columns = {.name = "columns", .kind = SNELL_PARAM_INT, .value.i = 4};
        snell_param rows = {.name = "rows", .kind = SNELL_PARAM_INT, .value.i = POINTS / 4};
        snell_param radius = {.name = "radius", .kind = SNELL_PARAM_FLOAT, .value.f = 0.2};
        desc_init(&type->info, desc);
        if (i == 1) {
            set_array(type, desc, "heights", heights, POINTS);
            assert_int_equal(desc_set(&type->info, desc, &columns), SNELL_OK);
            assert_int_equal(desc_set(&type->info, desc, &rows), SNELL_OK);
        } else {
            set_array(type, desc, "points", points, POINTS);
        }
        if (i == 0) assert_int_equal(desc_set(&type->info, desc, &radius), SNELL_OK);
        assert_int_equal(desc_check(&type->info, desc, NULL), SNELL_OK);
        assert_int_equal(type->check(desc), SNELL_OK);
        uint32_t g = scene_add_geometry(s, type, desc);
        scene_add_instance(s, g, NULL);
        transform m = random_transform(r, i % 2);
        scene_add_instance(s, g, &m);
        scene_add_instance(s, g, NULL);
    }
}

static const struct {
    const char *name;
    void (*make)(test_scene *s, rng *r);
} scenes[] = {{"flat grid", make_flat_grid},
              {"slivers", make_slivers},
              {"double faces", make_double_faces},
              {"far mesh", make_far_mesh},
              {"far sphere mesh", make_far_sphere_mesh},
              {"instances", make_instances},
              {"far spheres", make_far_spheres},
              {"mixture", make_mixture},
              {"few", make_few},
              {"soup", make_soup},
              {"parts", make_parts}};

/* ---- rays that are hard for the scene ---- */

static bounds3 shape_box(const accel_geometry *g) {
    if (g->type->unbounded) return (bounds3){{-1, -1, -1}, {1, 1, 1}};
    return g->type->bounds(g->desc);
}

/* A vertex, a point on an edge or anywhere in a triangle, a corner or the edge of a box; in the
 * world. */
static vec3 choose_point(const test_scene *s, rng *r) {
    const accel_instance *in = &s->instances[rng_below(r, (uint32_t)s->instance_count)];
    const accel_geometry *g = &s->geometries[in->geometry];
    dvec3 p;
    if (g->type->intersect == NULL && rng_below(r, 8)) {
        const mesh_desc *m = g->desc;
        const uint32_t *index =
            m->indices + 3 * (size_t)rng_below(r, (uint32_t)mesh_triangle_count(m));
        uint32_t kind = rng_below(r, 4);
        double u = kind == 0 ? 0 : kind == 1 ? 0.5 : rng_unit(r);
        double v = kind == 3 ? (1 - u) * rng_unit(r) : 0;
        uint32_t k = rng_below(r, 3);
        p = dvec3_scale(dvec3_from(m->positions[index[k]]), 1 - u - v);
        p = dvec3_add(p, dvec3_scale(dvec3_from(m->positions[index[(k + 1) % 3]]), u));
        p = dvec3_add(p, dvec3_scale(dvec3_from(m->positions[index[(k + 2) % 3]]), v));
    } else {
        bounds3 box = shape_box(g);
        double u[3];
        for (int i = 0; i < 3; i++) {
            uint32_t kind = rng_below(r, 4);
            u[i] = kind == 0 ? 0 : kind == 1 ? 1 : kind == 2 ? 0.5 : rng_unit(r);
        }
        p = (dvec3){box.min.x + u[0] * ((double)box.max.x - box.min.x),
                    box.min.y + u[1] * ((double)box.max.y - box.min.y),
                    box.min.z + u[2] * ((double)box.max.z - box.min.z)};
    }
    return vec3_from(in->identity ? p : transform_point(&in->to_world, p));
}

/* Between two points of the scene, along an axis, or from anywhere towards a point. */
static ray choose_ray(const test_scene *s, rng *r) {
    vec3 target = choose_point(s, r), o = choose_point(s, r), d;
    static const float signs[3] = {0.0f, -0.0f, 1};
    switch (rng_below(r, 4)) {
    case 0: d = vec3_sub(target, o); break;
    case 1:
        d = (vec3){signs[rng_below(r, 3)], signs[rng_below(r, 3)], signs[rng_below(r, 3)]};
        if (rng_below(r, 2)) d = vec3_scale(d, -1);
        o = vec3_sub(target, vec3_scale(d, (float)rng_below(r, 5)));
        break;
    case 2: /* in a coordinate plane */
        d = rng_vec3(r, 1);
        if (rng_below(r, 2))
            d.x = 0;
        else
            d.y = -0.0f;
        o = vec3_sub(target, d);
        break;
    default:
        d = rng_vec3(r, 1);
        o = vec3_sub(target, vec3_scale(d, rng_float(r, 0, 20)));
        d = vec3_sub(target, o);
    }
    if (d.x == 0 && d.y == 0 && d.z == 0) d.z = 1;
    ray out = ray_make(o, d, 0, INFINITY);
    if (rng_below(r, 4) == 0) out.t_min = rng_float(r, 0, 1);
    if (rng_below(r, 4) == 0) out.t_max = rng_below(r, 2) ? 1 : rng_float(r, 0.5, 1.5);
    if (rng_below(r, 8) == 0) {
        out.skip_instance = rng_below(r, (uint32_t)s->instance_count);
        out.skip_primitive = rng_below(r, 8);
    }
    return out;
}

/* Nearly as the leader goes, or just so; now and then not at all. */
static ray follow(const test_scene *s, const ray *leader, rng *r) {
    ray out = choose_ray(s, r);
    if (rng_below(r, 8) == 0) return out;
    vec3 d = leader->d;
    float size = float_max(fabsf(d.x), float_max(fabsf(d.y), fabsf(d.z)));
    out.o = leader->o;
    out.d = rng_below(r, 4) ? vec3_add(d, rng_vec3(r, 0.03 * (double)size)) : d;
    if (rng_below(r, 4) == 0) out.o = vec3_add(out.o, rng_vec3(r, 0.01));
    return out;
}

/* Some rays walk on from their own hit. With followers, rays in a row go nearly the same way. */
static void choose_rays(const test_scene *s, rng *r, ray *rays, hit *truth, size_t count,
                        bool followers) {
    for (size_t i = 0; i < count; i++) {
        rays[i] = followers && i % 50 ? follow(s, &rays[i - i % 50], r) : choose_ray(s, r);
        truth[i] = plain_trace(s, &rays[i]);
        if (truth[i].instance == NO_ID || rng_below(r, 3)) continue;
        rays[i].after_t = truth[i].t;
        rays[i].after_instance = truth[i].instance;
        rays[i].after_primitive = truth[i].primitive;
        truth[i] = plain_trace(s, &rays[i]);
    }
}

/* ---- the comparison ---- */

/* Trees by a random order of children, and by the other qualities of builds. */
enum { BATCH = 500, LEAF_SIZES = 4, SEEDS = 3, KINDS = SEEDS + ACCEL_QUALITIES - 1 };
typedef struct trees {
    accel *tree[LEAF_SIZES][KINDS];
} trees;

static void print_ray(const char *scene, const char *isa, const ray *r, hit got, hit wanted) {
    print_error("%s, %s: o %a %a %a d %a %a %a t %a..%a after %a %u %u: got %a %u/%u u %a v %a, "
                "wanted %a %u/%u u %a v %a\n",
                scene, isa, (double)r->o.x, (double)r->o.y, (double)r->o.z, (double)r->d.x,
                (double)r->d.y, (double)r->d.z, (double)r->t_min, (double)r->t_max,
                (double)r->after_t, r->after_instance, r->after_primitive, (double)got.t,
                got.instance, got.primitive, (double)got.u, (double)got.v, (double)wanted.t,
                wanted.instance, wanted.primitive, (double)wanted.u, (double)wanted.v);
}

static size_t compare(const char *scene, const accel *a, size_t isa, const ray *rays,
                      const hit *truth) {
    static hit hits[BATCH];
    static uint8_t blocked[BATCH];
    size_t wrong = 0;
    accel_trace(a, isas[isa], rays, hits, BATCH, NULL);
    accel_occluded(a, isas[isa], rays, blocked, BATCH, NULL);
    for (size_t i = 0; i < BATCH; i++) {
        bool any = truth[i].instance != NO_ID;
        if (same_hit(&hits[i], &truth[i]) && blocked[i] == any) continue;
        if (wrong++ == 0) print_ray(scene, isa_names[isa], &rays[i], hits[i], truth[i]);
    }
    return wrong;
}

static void attack(size_t scene, size_t batches) {
    static ray rays[BATCH];
    static hit truth[BATCH];
    rng r = {scene + 1};
    test_scene *s = scene_create();
    scenes[scene].make(s, &r);
    trees t;
    for (uint32_t i = 0; i < LEAF_SIZES; i++)
        for (uint32_t j = 0; j < KINDS; j++) {
            accel_options options = {.leaf_size = 1u << i};
            if (j < SEEDS)
                options.seed = j;
            else
                options.quality = (accel_quality)(1 + j - SEEDS);
            t.tree[i][j] = scene_build_as(s, &options, NULL);
        }
    size_t wrong = 0, found = 0;
    for (size_t batch = 0; batch < batches; batch++) {
        choose_rays(s, &r, rays, truth, BATCH, batch % 2);
        for (size_t i = 0; i < BATCH; i++) found += truth[i].instance != NO_ID;
        for (size_t isa = 0; isa < COUNT_OF(isas); isa++) {
            if (!accel_has_isa(isas[isa])) continue;
            for (uint32_t i = 0; i < LEAF_SIZES; i++)
                for (uint32_t j = 0; j < KINDS; j++)
                    wrong += compare(scenes[scene].name, t.tree[i][j], isa, rays, truth);
        }
    }
    printf("%s: %zu rays, %zu hits, %d trees, %zu differences\n", scenes[scene].name,
           batches * BATCH, found, LEAF_SIZES * KINDS, wrong);
    for (uint32_t i = 0; i < LEAF_SIZES; i++)
        for (uint32_t j = 0; j < KINDS; j++) accel_destroy(t.tree[i][j]);
    scene_destroy(s);
    assert_int_equal(wrong, 0);
    assert_true(found > batches * BATCH / 10);
}

static void the_winner_never_changes(void **state) {
    (void)state;
    for (size_t isa = 0; isa < COUNT_OF(isas); isa++)
        if (!accel_has_isa(isas[isa])) printf("%s: NOT TESTED\n", isa_names[isa]);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    size_t batches = 3;
#else
    size_t batches = test_full() ? 2000 : 40;
#endif
    for (size_t scene = 0; scene < COUNT_OF(scenes); scene++) attack(scene, batches);
}

/* ---- walking on ---- */

/* Seven equal squares in one place: every ray through them finds each once, in order. */
static void walking_on_finds_every_coincident_face_once(void **state) {
    (void)state;
    enum { SHEETS = 7 };
    test_scene *s = scene_create();
    fill_grid(scene_add_mesh(s, 4, 2), 1);
    for (int i = 0; i < SHEETS; i++) scene_add_instance(s, 0, NULL);
    rng r = {5};
    for (uint32_t seed = 0; seed < 3; seed++) {
        accel *a = scene_build(s, 0, seed, NULL);
        for (int n = 0; n < 2000; n++) {
            float x = rng_float(&r, 0.01, 0.49), z = rng_float(&r, 0.01, 0.49);
            ray walker = ray_make((vec3){x, 1, z}, (vec3){0, -1, 0.001f}, 0, INFINITY);
            for (uint32_t i = 0; i <= SHEETS; i++) {
                hit h;
                accel_trace(a, SNELL_ISA_AUTO, &walker, &h, 1, NULL);
                assert_int_equal(h.instance, i < SHEETS ? i : NO_ID);
                walker.after_t = h.t;
                walker.after_instance = h.instance;
                walker.after_primitive = h.primitive;
            }
        }
        accel_destroy(a);
    }
    scene_destroy(s);
}

/* Both sides of a sphere, then the next sphere of the same shape. */
static void walking_on_finds_both_sides_of_a_sphere(void **state) {
    (void)state;
    test_scene *s = scene_create();
    uint32_t ball = scene_add_shape(s, "sphere", "center", (vec3){0, 0, 0}, "radius", 1);
    transform shift = transform_identity();
    shift.m[2][3] = -2; /* touches the first */
    scene_add_instance(s, ball, &shift);
    scene_add_instance(s, ball, NULL);
    accel *a = scene_build(s, 0, 0, NULL);
    ray walker = ray_make((vec3){0, 0, 5}, (vec3){0, 0, -1}, 0, INFINITY);
    const float t[] = {4, 6, 6, 8, INFINITY};
    const uint32_t instance[] = {1, 0, 1, 0, NO_ID};
    for (size_t i = 0; i < COUNT_OF(t); i++) {
        hit h;
        accel_trace(a, SNELL_ISA_AUTO, &walker, &h, 1, NULL);
        assert_true(h.t == t[i]);
        assert_int_equal(h.instance, instance[i]);
        walker.after_t = h.t;
        walker.after_instance = h.instance;
        walker.after_primitive = h.primitive;
    }
    accel_destroy(a);
    scene_destroy(s);
}

/* ---- masks, skips, bad rays, counters ---- */

static void masks_hide_instances_and_skips_hide_flat_primitives(void **state) {
    (void)state;
    test_scene *s = scene_create();
    fill_grid(scene_add_mesh(s, 4, 2), 1);
    uint32_t ball = scene_add_shape(s, "sphere", "center", (vec3){0, -5, 0}, "radius", 1);
    uint32_t plane = scene_add_shape(s, "plane", "point", (vec3){0, -9, 0}, NULL, 0);
    scene_add_instance(s, 0, NULL);
    scene_add_instance(s, ball, NULL);
    scene_add_instance(s, plane, NULL);
    s->instances[0].mask = 1;
    s->instances[1].mask = 2;
    s->instances[2].mask = 4;
    accel *a = scene_build(s, 0, 0, NULL);
    for (size_t isa = 0; isa < COUNT_OF(isas); isa++) {
        if (!accel_has_isa(isas[isa])) continue;
        ray r = ray_make((vec3){0.125f, 1, 0.25f}, (vec3){0, -1, 0}, 0, INFINITY);
        const uint32_t masks[] = {7, 6, 4, 8}, winners[] = {0, 1, 2, NO_ID};
        for (size_t i = 0; i < COUNT_OF(masks); i++) {
            hit h;
            uint8_t blocked;
            r.mask = masks[i];
            accel_trace(a, isas[isa], &r, &h, 1, NULL);
            accel_occluded(a, isas[isa], &r, &blocked, 1, NULL);
            assert_int_equal(h.instance, winners[i]);
            assert_int_equal(blocked, winners[i] != NO_ID);
        }
        /* The triangle and the plane are flat and are skipped, the sphere is not. */
        const uint32_t skips[] = {0, 1, 2}, expected[] = {1, 1, NO_ID}, seen[] = {7, 6, 4};
        for (size_t i = 0; i < COUNT_OF(skips); i++) {
            hit h;
            r.mask = seen[i];
            r.skip_instance = skips[i];
            r.skip_primitive = 0;
            accel_trace(a, isas[isa], &r, &h, 1, NULL);
            assert_int_equal(h.instance, expected[i]);
        }
    }
    accel_destroy(a);
    scene_destroy(s);
}

static void rays_that_are_no_rays_hit_nothing(void **state) {
    (void)state;
    test_scene *s = scene_create();
    rng random = {3};
    make_mixture(s, &random);
    accel *a = scene_build(s, 0, 0, NULL);
    const vec3 bad[][2] = {{{NAN, 0, 0}, {0, 0, 1}},       {{0, 0, 0}, {0, NAN, 1}},
                           {{INFINITY, 0, 0}, {-1, 0, 0}}, {{0, 0, 0}, {-INFINITY, 1, 0}},
                           {{1, 1, 1}, {0, 0, 0}},         {{1, 0, 1}, {-0.0f, 0, 0}}};
    for (size_t isa = 0; isa < COUNT_OF(isas); isa++)
        for (size_t i = 0; accel_has_isa(isas[isa]) && i < COUNT_OF(bad); i++) {
            ray r = ray_make(bad[i][0], bad[i][1], 0, INFINITY);
            hit h;
            uint8_t blocked;
            accel_trace(a, isas[isa], &r, &h, 1, NULL);
            accel_occluded(a, isas[isa], &r, &blocked, 1, NULL);
            assert_int_equal(h.instance, NO_ID);
            assert_true(h.t == INFINITY);
            assert_int_equal(blocked, 0);
        }
    accel_destroy(a);
    scene_destroy(s);
}

static void counters_are_equal_between_runs_and_instruction_sets(void **state) {
    (void)state;
    enum { COUNT = 20000 };
    test_scene *s = scene_create();
    rng random = {9};
    scene_add_uv_sphere(s, 60, 60, 2, (dvec3){0, 0, 0});
    scene_add_instance(s, 0, NULL);
    make_far_spheres(s, &random);
    accel *a = scene_build(s, 0, 0, NULL);
    ray *rays = calloc(COUNT, sizeof *rays);
    hit *hits = calloc(COUNT, sizeof *hits);
    assert_true(rays && hits);
    for (int i = 0; i < COUNT; i++)
        rays[i] = ray_make(rng_vec3(&random, 3), rng_vec3(&random, 1), 0, INFINITY);
    trace_counters first = {0};
    accel_trace(a, SNELL_ISA_SCALAR, rays, hits, COUNT, &first);
    assert_true(first.nodes > COUNT && first.boxes > first.nodes && first.triangles > COUNT &&
                first.primitives > 0);
    for (size_t isa = 0; isa < COUNT_OF(isas); isa++)
        for (int run = 0; accel_has_isa(isas[isa]) && run < 2; run++) {
            trace_counters again = {0};
            accel_trace(a, isas[isa], rays, hits, COUNT, &again);
            assert_memory_equal(&again, &first, sizeof first);
        }
    free(rays);
    free(hits);
    accel_destroy(a);
    scene_destroy(s);
}

static void go_together(test_scene *s, uint64_t fewer) {
    enum { COUNT = 64 * 64 };
    static ray rays[COUNT];
    static hit hits[COUNT];
    static uint8_t blocked[COUNT];
    accel *a = scene_build(s, 0, 0, NULL);
    for (int i = 0; i < COUNT; i++) { /* tiles of 8 by 8 */
        int x = i / 64 % 8 * 8 + i % 8, y = i / 512 * 8 + i % 64 / 8;
        vec3 d = {0.02f * ((float)x - 31.5f), 0.02f * ((float)y - 31.5f), -1};
        rays[i] = ray_make((vec3){0, 0, 5}, d, 0, INFINITY);
        if (i % 3 == 0) rays[i].mask = 1;
    }
    trace_counters alone = {0}, first = {0};
    for (int i = 0; i < COUNT; i++) {
        accel_trace(a, SNELL_ISA_SCALAR, &rays[i], &hits[i], 1, &alone);
        blocked[i] = hits[i].instance != NO_ID;
    }
    for (size_t isa = 0; isa < COUNT_OF(isas); isa++) {
        if (!accel_has_isa(isas[isa])) continue;
        static hit together[COUNT];
        static uint8_t any[COUNT];
        trace_counters counters = {0};
        accel_trace(a, isas[isa], rays, together, COUNT, &counters);
        accel_occluded(a, isas[isa], rays, any, COUNT, NULL);
        assert_memory_equal(together, hits, sizeof hits);
        assert_memory_equal(any, blocked, sizeof blocked);
        assert_true(counters.nodes < alone.nodes / fewer);
        if (isa == 0) first = counters;
        assert_memory_equal(&counters, &first, sizeof first);
    }
    accel_destroy(a);
    scene_destroy(s);
}

/* What goes the same way goes together: a node counts once. Through a mesh; and through a world of meshes as they
 * were given and in other places, of spheres and a plane, some of them twice and some hidden by masks. */
static void rays_that_go_the_same_way_go_together(void **state) {
    (void)state;
    test_scene *s = scene_create();
    scene_add_uv_sphere(s, 60, 60, 2, (dvec3){0, 0, 0});
    scene_add_instance(s, 0, NULL);
    go_together(s, 8);

    s = scene_create();
    scene_add_uv_sphere(s, 60, 60, 2, (dvec3){-1, 0, 0});
    scene_add_uv_sphere(s, 60, 60, 1, (dvec3){1, 1, 0});
    uint32_t ball = scene_add_shape(s, "sphere", "center", (vec3){1, -1, 0.5}, "radius", 1);
    uint32_t plane = scene_add_shape(s, "plane", "point", (vec3){0, -2, 0}, NULL, 0);
    rng r = {5};
    for (int twice = 0; twice < 2; twice++)
        for (uint32_t g = 0; g < 2; g++) scene_add_instance(s, g, NULL);
    for (int i = 0; i < 6; i++) {
        transform m = random_transform(&r, i % 2);
        scene_add_instance(s, i % 2 ? 1 : 0, &m);
        if (i < 2) scene_add_instance(s, i % 2 ? 1 : 0, &m);
    }
    scene_add_instance(s, plane, NULL);
    for (int i = 0; i < 3; i++) scene_add_instance(s, ball, NULL);
    for (int i = 0; i < 40; i++) {
        ball = scene_add_shape(s, "sphere", "center", rng_vec3(&r, 3), "radius", 0.3f);
        scene_add_instance(s, ball, NULL);
        if (i % 4 == 0) s->instances[s->instance_count - 1].mask = 2;
    }
    s->instances[1].mask = 2;
    go_together(s, 3);
}

static void the_ceiling_on_instruction_sets_holds(void **state) {
    (void)state;
    assert_true(accel_has_isa(SNELL_ISA_SCALAR));
    assert_false(accel_has_isa(SNELL_ISA_AUTO));
    assert_int_equal(accel_best_isa(SNELL_ISA_SCALAR), SNELL_ISA_SCALAR);
    assert_true(accel_best_isa(SNELL_ISA_AVX2) <= SNELL_ISA_AVX2);
    assert_true(accel_has_isa(accel_best_isa(SNELL_ISA_AUTO)));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_winner_never_changes),
        cmocka_unit_test(walking_on_finds_every_coincident_face_once),
        cmocka_unit_test(walking_on_finds_both_sides_of_a_sphere),
        cmocka_unit_test(masks_hide_instances_and_skips_hide_flat_primitives),
        cmocka_unit_test(rays_that_are_no_rays_hit_nothing),
        cmocka_unit_test(counters_are_equal_between_runs_and_instruction_sets),
        cmocka_unit_test(rays_that_go_the_same_way_go_together),
        cmocka_unit_test(the_ceiling_on_instruction_sets_holds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
