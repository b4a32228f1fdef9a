/* Groups of instances in groups: one tree for each, whatever is drawn of it. The kernels give what
 * trying everything gives, bit for bit. test_groups_scene.c looks at scenes. */
#include "accel_test.h"

static const snell_isa isas[] = {SNELL_ISA_SCALAR, SNELL_ISA_AVX2, SNELL_ISA_AVX512};
static const char *const isa_names[] = {"scalar", "avx2", "avx512"};

/* ---- trees of groups, and the hit rule written out for them ---- */

typedef struct forest {
    test_scene *s;
    rng random;
    motion motions[64];
    size_t motion_count;
} forest;

/* Turned, sheared, stretched; every other one mirrored. */
static transform affine(rng *r, double shift) {
    transform m;
    double size;
    do {
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 4; j++)
                m.m[i][j] = rng_float(r, j == 3 ? -shift : -1, j == 3 ? shift : 1);
        size = transform_determinant(&m);
    } while (fabs(size) < 0.2);
    return m;
}

static accel_instance instance_of(forest *f, uint32_t geometry, bool moving) {
    accel_instance in = {.geometry = geometry,
                         .mask = rng_below(&f->random, 8) ? ~0u : 2,
                         .identity = rng_below(&f->random, 5) == 0,
                         .to_world = transform_identity(),
                         .to_local = transform_identity()};
    if (in.identity) return in;
    in.to_world = affine(&f->random, 3);
    assert_true(transform_inverse(&in.to_world, &in.to_local));
    if (moving && f->motion_count < COUNT_OF(f->motions) && rng_below(&f->random, 3) == 0) {
        motion_key keys[2] = {{0, in.to_world}, {1, in.to_world}};
        keys[1].transform.m[0][3] += 1;
        keys[1].transform.m[1][1] *= 1.1f;
        motion *m = &f->motions[f->motion_count];
        if (motion_prepare(keys, 2, 0, 1, m) == SNELL_OK) {
            f->motion_count++;
            in.moves = m;
        }
    }
    return in;
}

static uint32_t add_group(forest *f, const uint32_t *geometries, size_t count, size_t parts,
                          bool moving) {
    accel_instance *p = scene_own(f->s, calloc(parts, sizeof *p));
    for (size_t i = 0; i < parts; i++)
        p[i] = instance_of(
            f, geometries[i ? rng_below(&f->random, (uint32_t)count) : (uint32_t)count - 1],
            moving);
    f->s->geometries[f->s->geometry_count] = (accel_geometry){.parts = p, .part_count = parts};
    return (uint32_t)f->s->geometry_count++;
}

/* `depth` groups in one another, each of the one below it and others; four instances of it, and of a
 * shape, in the world. */
static forest *make_forest(uint64_t seed, uint32_t depth, bool moving) {
    forest *f = calloc(1, sizeof *f);
    assert_non_null(f);
    f->random.state = seed;
    f->s = scene_create();
    uint32_t all[16];
    size_t count = 0;
    all[count++] = scene_add_shape(f->s, "sphere", NULL, (vec3){0, 0, 0}, "radius", 0.7f);
    all[count++] = scene_add_shape(f->s, "box", "max", (vec3){1, 0.5f, 0.8f}, NULL, 0);
    scene_add_uv_sphere(f->s, 8, 6, 0.8, (dvec3){0.1, 0, 0});
    all[count++] = (uint32_t)f->s->geometry_count - 1;
    all[count++] = scene_add_shape(f->s, "disk", NULL, (vec3){0, 0, 0}, "radius", 0.9f);
    uint32_t plane = scene_add_shape(f->s, "plane", NULL, (vec3){0, 0, 0}, NULL, 0);
    for (uint32_t level = 0; level < depth; level++) {
        if (level == 2) all[3] = plane; /* a group of it has no box */
        uint32_t made = add_group(f, all, count, 3, moving);
        all[count++] = made;
    }
    for (int i = 0; i < 6; i++)
        f->s->instances[f->s->instance_count++] =
            instance_of(f, i < 4 ? all[count - 1] : all[0], moving);
    return f;
}

static void free_forest(forest *f) {
    for (size_t i = 0; i < f->motion_count; i++) motion_free(&f->motions[i]);
    scene_destroy(f->s);
    free(f);
}

static uint32_t shapes_in(const forest *f, uint32_t geometry) {
    const accel_geometry *g = &f->s->geometries[geometry];
    uint32_t sum = g->type ? 1 : 0;
    for (size_t i = 0; i < g->part_count && !g->type; i++)
        sum += shapes_in(f, g->parts[i].geometry);
    return sum;
}

/* false: it has none. */
static bool box_of(const forest *f, uint32_t geometry, bounds3 *out);

static bool instance_box(const forest *f, const accel_instance *in, bool in_group, bounds3 *out) {
    bounds3 own;
    if (!box_of(f, in->geometry, &own)) return false;
    bool widened = in_group || f->s->geometries[in->geometry].type == NULL;
    if (in->moves) {
        *out = motion_bounds(in->moves, own);
        for (uint32_t i = 0; i < in->moves->count && widened; i++) {
            const transform *at = &in->moves->steps[i].transform;
            transform inverse;
            assert_true(transform_inverse(at, &inverse));
            *out = bounds3_union(*out, transform_bounds_widened(at, &inverse, own));
        }
    } else if (in->identity) {
        *out = own;
    } else {
        *out = widened ? transform_bounds_widened(&in->to_world, &in->to_local, own)
                       : transform_bounds(&in->to_world, own);
    }
    return true;
}

static bool box_of(const forest *f, uint32_t geometry, bounds3 *out) {
    const accel_geometry *g = &f->s->geometries[geometry];
    *out = bounds3_empty();
    if (g->type == NULL) {
        for (size_t i = 0; i < g->part_count; i++) {
            bounds3 part;
            if (!instance_box(f, &g->parts[i], true, &part)) return false;
            *out = bounds3_union(*out, part);
        }
    } else if (g->type->intersect == NULL) {
        const mesh_desc *m = g->desc;
        for (size_t k = 0; k < m->indices_count; k++)
            *out = bounds3_add_point(*out, m->positions[m->indices[k]]);
    } else {
        if (g->type->unbounded) return false;
        *out = g->type->bounds(g->desc);
    }
    return true;
}

/* The ray in a level's space, in double, and what is behind it. */
typedef struct descent {
    const forest *f;
    const ray *r;
    hit *best;
} descent;

static void try_level(const descent *q, const accel_instance *in, size_t count, bool in_group,
                      dvec3 o, dvec3 d, float floor_t, uint32_t base) {
    const ray *r = q->r;
    plain_ray outer = plain_ray_make(vec3_from(o), vec3_from(d), r->t_min, r->t_max);
    for (size_t i = 0; i < count; base += shapes_in(q->f, in[i].geometry), i++) {
        const accel_geometry *g = &q->f->s->geometries[in[i].geometry];
        if (!(in[i].mask & r->mask)) continue;
        bounds3 box, own;
        float entry = floor_t, own_entry = r->t_min;
        bool bounded = instance_box(q->f, &in[i], in_group, &box);
        if (bounded && !plain_box(&outer, box, &entry)) continue;
        entry = float_max(entry, floor_t);
        dvec3 local_o = o, local_d = d;
        if (!in[i].identity) {
            transform to_local = in[i].to_local, to_world;
            if (in[i].moves) assert_true(motion_at(in[i].moves, r->time, &to_world, &to_local));
            local_o = transform_point(&to_local, o);
            local_d = transform_vector(&to_local, d);
        }
        plain_ray local =
            plain_ray_make(vec3_from(local_o), vec3_from(local_d), r->t_min, r->t_max);
        if (g->type == NULL) {
            try_level(q, g->parts, g->part_count, true, local_o, local_d, entry, base);
        } else if (g->type->intersect == NULL) {
            assert_true(box_of(q->f, in[i].geometry, &own));
            plain_mesh(g->desc, own, &local, r, base, entry, q->best);
        } else {
            if (bounded && box_of(q->f, in[i].geometry, &own) && !in[i].identity &&
                !plain_box(&local, own, &own_entry))
                continue;
            plain_shape(g, &local, r, base, float_max(own_entry, entry), q->best);
        }
    }
}

static hit try_everything(const forest *f, const ray *r) {
    hit best = {INFINITY, 0, 0, NO_ID, NO_ID};
    descent q = {f, r, &best};
    try_level(&q, f->s->instances, f->s->instance_count, false, dvec3_from(r->o), dvec3_from(r->d),
              r->t_min, 0);
    return best;
}

static void compare_with_everything(uint32_t depth, bool moving, size_t *hits, uint32_t *deepest) {
    enum { RAYS = 800 };
    static ray rays[RAYS];
    static hit expected[RAYS], found[RAYS];
    static uint8_t blocked[RAYS];
    forest *f = make_forest(100 * depth + moving, depth, moving);
    for (size_t i = 0; i < RAYS; i++) {
        vec3 from = rng_vec3(&f->random, 12), at = rng_vec3(&f->random, 4);
        rays[i] = ray_make(from, vec3_sub(at, from), 0, i % 4 ? INFINITY : 0.9f);
        rays[i].mask = i % 3 ? ~0u : 1;
        rays[i].time = moving ? rng_float(&f->random, 0, 1) : 0;
        if (i % 5 == 4 && expected[i - 1].instance != NO_ID) { /* walk on */
            rays[i] = rays[i - 1];
            rays[i].after_t = expected[i - 1].t;
            rays[i].after_instance = expected[i - 1].instance;
            rays[i].after_primitive = expected[i - 1].primitive;
        }
        expected[i] = try_everything(f, &rays[i]);
        *hits += expected[i].instance != NO_ID;
    }
    for (uint32_t build = 0; build < 3; build++) {
        accel *a = scene_build(f->s, build == 2 ? 1 : 8, build ? 7 * build : 0, NULL);
        for (size_t k = 0; k < COUNT_OF(isas); k++) {
            if (!accel_has_isa(isas[k])) {
                printf("%s: NOT TESTED\n", isa_names[k]);
                continue;
            }
            accel_trace(a, isas[k], rays, found, RAYS, NULL);
            accel_occluded(a, isas[k], rays, blocked, RAYS, NULL);
            for (size_t i = 0; i < RAYS; i++) {
                if (!same_hit(&found[i], &expected[i]))
                    printf("depth %u ray %zu: t %.9g of %u, not %.9g of %u\n", depth, i,
                           (double)found[i].t, found[i].instance, (double)expected[i].t,
                           expected[i].instance);
                assert_true(same_hit(&found[i], &expected[i]));
                assert_int_equal(blocked[i], expected[i].instance != NO_ID);
            }
        }
        for (size_t i = 0; i < a->geometry_count; i++)
            if (a->geometries[i].used && a->geometries[i].depth > *deepest)
                *deepest = a->geometries[i].depth;
        accel_destroy(a);
    }
    free_forest(f);
}

static void hits_are_those_of_trying_everything(void **state) {
    (void)state;
    size_t hits = 0;
    uint32_t deepest = 0;
    for (uint32_t depth = 1; depth <= GROUP_DEPTH_MAX; depth++)
        for (int moving = 0; moving < 2; moving++)
            compare_with_everything(depth, moving, &hits, &deepest);
    printf("%zu hits, groups in groups to depth %u\n", hits, deepest);
    assert_int_equal(deepest, GROUP_DEPTH_MAX);
    assert_true(hits > 4000);
}

static void too_deep_or_too_many_is_an_error(void **state) {
    (void)state;
    forest *f = make_forest(1, GROUP_DEPTH_MAX, false);
    uint32_t top = (uint32_t)f->s->geometry_count - 1;
    uint32_t outer = add_group(f, &top, 1, 2, false);
    f->s->instances[f->s->instance_count++] = (accel_instance){.geometry = outer};
    accel *a;
    accel_input input = {f->s->geometries, f->s->geometry_count, f->s->instances,
                         f->s->instance_count};
    assert_int_equal(accel_build(&input, NULL, NULL, &a), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "groups are nested more than 8 deep");
    accel_instance own = {.geometry = outer}; /* a group in itself */
    f->s->geometries[outer].parts = &own;
    f->s->geometries[outer].part_count = 1;
    assert_int_equal(accel_build(&input, NULL, NULL, &a), SNELL_ERR_ARGUMENT);
    free_forest(f);

    f = make_forest(2, 0, false);
    uint32_t at = 0;
    for (int level = 0; level < 4; level++) at = add_group(f, &at, 1, 300, false);
    input = (accel_input){f->s->geometries, f->s->geometry_count, f->s->instances,
                          f->s->instance_count};
    assert_int_equal(accel_build(&input, NULL, NULL, &a), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "groups of groups draw more than 4294967294 shapes");
    free_forest(f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_those_of_trying_everything),
        cmocka_unit_test(too_deep_or_too_many_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
