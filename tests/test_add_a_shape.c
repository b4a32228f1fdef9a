/* The code of docs/add-a-shape.md, as it stands there: the two ways to one shape give the same hits and
 * the same pictures, whatever the number of threads and the instruction set. */
#include "guide/dish.c"
#include "guide/dish_user.c"

#include "accel/accel.h"
#include "render_test.h"

enum { RAYS = 4000 };

static ray random_ray(uint64_t *random) {
    double x = uniform(random), y = uniform(random), z = uniform(random);
    vec3 from = v3(6 * x - 3, 6 * y - 3, 6 * z - 3);
    double u = uniform(random), v = uniform(random), w = uniform(random);
    return ray_make(from, vec3_sub(v3(2 * u - 1, v, 2 * w - 1), from), 0, INFINITY);
}

static void both_ways_give_the_same_hits(void **state) {
    (void)state;
    dish_desc desc;
    desc_init(&primitive_dish.info, &desc);
    desc.bend = 1.5f;
    dish mine = {1.5, 1};
    rig r = rig_make(2, SNELL_ISA_AUTO);
    snell_shape_id shape;
    MUST(add_dish(r.scene, &mine, &shape));
    place(&r, shape, (snell_material_id){0, 0});
    MUST(snell_scene_commit(r.scene, NULL, NULL));
    accel_geometry geometry = {.type = &primitive_dish, .desc = &desc};
    accel_instance at = {.mask = ~0u,
                         .identity = true,
                         .to_world = transform_identity(),
                         .to_local = transform_identity()};
    accel *a;
    MUST(accel_build(&(accel_input){&geometry, 1, &at, 1}, NULL, NULL, &a));
    uint64_t random = 3;
    int hits = 0, again = 0;
    for (int i = 0; i < RAYS; i++) {
        ray one = random_ray(&random);
        hit found;
        snell_ray same = {one.o, 0, one.d, INFINITY, 0, 1};
        snell_hit user;
        accel_trace(a, SNELL_ISA_AUTO, &one, &found, 1, NULL);
        MUST(snell_scene_intersect(r.scene, &same, &user, 1));
        assert_int_equal(found.instance != NO_ID, user.instance.index1 != 0);
        if (found.instance == NO_ID) continue;
        hits++;
        assert_true(fabsf(found.t - user.t) <= 1e-6f * found.t);
        local_ray beam = {one.o, one.d, 0, INFINITY};
        surface s;
        primitive_dish.surface(&desc, &beam, &found, &s);
        assert_true(fabs(s.p.y - 1.5 * (s.p.x * s.p.x + s.p.z * s.p.z)) < 1e-12);
        assert_true(dvec3_length(dvec3_sub(s.n, dvec3_from(user.normal))) < 1e-6);
        /* A ray that leaves on the outside meets nothing at once. */
        ray out = ray_make(surface_offset_origin(&s, 1), vec3_from(s.n), 0, 1e-3f);
        accel_trace(a, SNELL_ISA_AUTO, &out, &found, 1, NULL);
        again += found.instance != NO_ID;
    }
    printf("%d of %d rays hit, %d again\n", hits, RAYS, again);
    assert_true(hits > RAYS / 4 && again == 0);
    accel_destroy(a);
    rig_free(&r);
}

static dish many_dishes = {2, 0.5};

static void build(rig *r) {
    snell_shape_id shape, group;
    snell_instance_id parts[2];
    snell_transform at = {{{0.5f, 0, 0, 1.2f}, {0, -0.7f, 0.2f, 1}, {0, 0.1f, 0.6f, 0}}};
    MUST(add_dish(r->scene, &many_dishes, &shape));
    parts[0] = place(r, shape, add_lambert(r, v3(0.8, 0.4, 0.2)));
    MUST(snell_scene_add_instance(r->scene, shape, add_mirror(r, grey(0.9)), &at, &parts[1]));
    MUST(snell_scene_add_group(r->scene, parts, 2, NULL, &group));
    place(r, group, (snell_material_id){0, 0});
    at.m[0][3] = -1.2f;
    MUST(snell_scene_add_instance(r->scene, group, (snell_material_id){0, 0}, &at, NULL));
    add_point(r, v3(3, 4, 5), grey(100));
    MUST(snell_scene_set_background(r->scene, v3(0.2, 0.3, 0.5), 1));
    MUST(snell_scene_commit(r->scene, NULL, NULL));
}

static void one_picture(void **state) {
    (void)state;
    static const snell_isa isas[] = {SNELL_ISA_SCALAR, SNELL_ISA_AVX2, SNELL_ISA_AVX512};
    uint64_t expected = 0;
    for (int i = 0; i < 4; i++) {
        if (i < 3 && !accel_has_isa(isas[i])) {
            printf("instruction set %d: NOT TESTED\n", i);
            continue;
        }
        rig r = rig_make(i == 3 ? 3 : 1, i == 3 ? SNELL_ISA_AUTO : isas[i]);
        build(&r);
        snell_render_desc desc = picture(SNELL_WHITTED, 48, 32, 5);
        snell_view view = look(v3(0.5, 2, 4), v3(0, 0.4, 0));
        desc.view = &view;
        MUST(snell_render(r.scene, &desc, r.film));
        uint64_t hash = snell_film_hash(r.film);
        if (i == 0) expected = hash;
        assert_int_equal(hash, expected);
        rgb middle = pixel_at(&r, 24, 18);
        assert_true(middle.c[0] > 0 && middle.c[0] != (double)0.2f);
        rig_free(&r);
    }
}

static bool nothing(void *user, uint32_t primitive, const snell_user_ray *beam,
                    snell_user_hit *out) {
    (void)user, (void)primitive, (void)beam;
    out->t = NAN;
    return true; /* and breaks its word: that is no hit */
}

static void endless(void *user, uint32_t primitive, snell_bounds *out) {
    (void)user, (void)primitive;
    *out = (snell_bounds){{-INFINITY, 0, 0}, {1, 1, 1}};
}

static void what_is_wrong_is_an_error(void **state) {
    (void)state;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    snell_user_shape_desc desc = SNELL_INIT(user_shape_desc);
    snell_shape_id shape;
    assert_int_equal(snell_scene_add_user_shape(r.scene, NULL, NULL, &shape), SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_scene_add_user_shape(r.scene, &desc, NULL, &shape), SNELL_ERR_ARGUMENT);
    desc.user = &many_dishes;
    desc.bounds = endless;
    desc.intersect = nothing;
    desc.surface = dish_surface;
    assert_int_equal(snell_scene_add_user_shape(r.scene, &desc, NULL, &shape), SNELL_ERR_ARGUMENT);
    assert_string_equal(snell_last_error()->text,
                        "user shape: the box of primitive 0 is not finite");
    desc.bounds = dish_bounds;
    desc.primitive_count = 0;
    assert_int_equal(snell_scene_add_user_shape(r.scene, &desc, NULL, &shape), SNELL_ERR_ARGUMENT);
    desc.primitive_count = 3;
    MUST(snell_scene_add_user_shape(r.scene, &desc, NULL, &shape));
    place(&r, shape, (snell_material_id){0, 0});
    MUST(snell_scene_commit(r.scene, NULL, NULL));
    snell_ray down = {v3(0, 5, 0), 0, v3(0, -1, 0), INFINITY, 0, 1};
    snell_hit found;
    MUST(snell_scene_intersect(r.scene, &down, &found, 1));
    assert_int_equal(found.instance.index1, 0);
    rig_free(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_ways_give_the_same_hits),
        cmocka_unit_test(one_picture),
        cmocka_unit_test(what_is_wrong_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
