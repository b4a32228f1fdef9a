/* Meshes that deform, in scenes: a mesh whose vertices go where a moving transform takes them is that
 * mesh in motion, in every integrator, as a light too; what is refused; memory; the shutter. */
#include "api/api.h"
#include "geometry/deforming.h"
#include "render_test.h"
#include "scene/instances.h"

#include <string.h>

static rig bench;

static int begin(void **state) {
    (void)state;
    bench = rig_make(2, SNELL_ISA_AUTO);
    return 0;
}

static int clear(void **state) {
    (void)state;
    rig_clear(&bench);
    return 0;
}

static int end(void **state) {
    (void)state;
    rig_free(&bench);
    return 0;
}

/* ---- the same motion, said in two ways ---- */

enum { SIDE = 9, VERTICES = 6 * SIDE * SIDE, TRIANGLES = 12 * (SIDE - 1) * (SIDE - 1), KEYS = 3 };

/* A ball of six sides with smooth normals and uvs, closed: edges have the same vertices twice. */
typedef struct ball {
    snell_vec3 positions[KEYS * VERTICES], normals[KEYS * VERTICES];
    snell_vec2 uvs[VERTICES];
    uint32_t indices[3 * TRIANGLES];
    float times[KEYS];
    snell_motion_key keys[KEYS];
} ball;

static void make_ball(ball *b) {
    uint32_t *index = b->indices;
    for (uint32_t face = 0; face < 6; face++)
        for (uint32_t i = 0; i < SIDE * SIDE; i++) {
            double u = 2.0 * (i % SIDE) / (SIDE - 1) - 1, v = 2.0 * (i / SIDE) / (SIDE - 1) - 1,
                   sign = face % 2 ? -1 : 1;
            double p[3], length = sqrt(1 + (u * u + v * v));
            p[face / 2] = sign / length;
            p[(face / 2 + 1) % 3] = sign * u / length;
            p[(face / 2 + 2) % 3] = v / length;
            uint32_t at = face * SIDE * SIDE + i;
            b->positions[at] = b->normals[at] = v3(p[0], p[1], p[2]);
            b->uvs[at] = (snell_vec2){(float)(u + 1) / 2, (float)(v + 1) / 2};
            if (i % SIDE == SIDE - 1 || i / SIDE == SIDE - 1) continue;
            const uint32_t corners[6] = {at, at + 1, at + SIDE, at + 1, at + SIDE + 1, at + SIDE};
            memcpy(index, corners, sizeof corners);
            index += 6;
        }
}

/* Stretching and sliding, which is linear between keys; `scale`: seconds between keys. */
static void make_keys(ball *b, double scale) {
    for (int k = 0; k < KEYS; k++) {
        b->times[k] = (float)(scale * k);
        b->keys[k] = (snell_motion_key){.time = b->times[k],
                                        .transform = {{{1 + 0.3f * (float)k, 0, 0, 0.4f * (float)k},
                                                       {0, 1, 0, k == 1 ? 0.25f : 0},
                                                       {0, 0, 1 - 0.2f * (float)k, 0}}}};
        const transform *m = &b->keys[k].transform;
        transform inverse;
        assert_true(transform_inverse(m, &inverse));
        for (size_t i = 0; i < VERTICES; i++) {
            dvec3 p = transform_point(m, dvec3_from(b->positions[i])),
                  n = transform_normal(&inverse, dvec3_from(b->normals[i]));
            b->positions[(size_t)k * VERTICES + i] = vec3_from(p);
            b->normals[(size_t)k * VERTICES + i] = vec3_from(n);
        }
    }
}

static snell_shape_id add_ball(const ball *b, bool deforms) {
    snell_mesh_desc desc = SNELL_INIT(mesh_desc);
    snell_shape_id id;
    desc.positions = b->positions;
    desc.normals = b->normals;
    desc.positions_count = desc.normals_count = deforms ? KEYS * VERTICES : VERTICES;
    desc.uvs = b->uvs;
    desc.uvs_count = VERTICES;
    desc.indices = b->indices;
    desc.indices_count = (size_t)3 * TRIANGLES;
    if (deforms) {
        desc.key_times = b->times;
        desc.key_times_count = KEYS;
    }
    MUST(snell_scene_add_mesh(bench.scene, &desc, &id));
    return id;
}

/* In the world: the mesh that deforms; or the still one, moving. */
static snell_instance_id place_ball(const ball *b, bool deforms, snell_material_id m) {
    snell_instance_id id = place(&bench, add_ball(b, deforms), m);
    if (!deforms) MUST(snell_scene_set_instance_motion(bench.scene, id, b->keys, KEYS));
    return id;
}

static snell_instance_id group_of(snell_instance_id part, snell_material_id m) {
    snell_shape_id group;
    MUST(snell_scene_add_group(bench.scene, &part, 1, NULL, &group));
    return place(&bench, group, m);
}

/* The k-th way in which a ball may stand in the world. */
static void build_way(const ball *b, bool deforms, int way, snell_material_id m) {
    snell_instance_id id = place_ball(b, deforms, way == 0 ? m : (snell_material_id){0, 0});
    if (way == 0) return;
    id = group_of(id, m);
    snell_motion_key keys[2] = {
        {.time = b->times[0], .transform = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}},
        {.time = b->times[2], .transform = {{{1, 0, 0, 0.2f}, {0, 1, 0, 0.1f}, {0, 0.3f, -1, 0}}}}};
    keys[0].transform.m[2][2] = -1; /* mirrored throughout */
    if (way == 1)
        MUST(snell_scene_set_instance_transform(bench.scene, id, &keys[1].transform));
    else /* a motion on top of that of the mesh */
        MUST(snell_scene_set_instance_motion(bench.scene, id, keys, 2));
}

static void hits_are_those_of_a_moving_transform(void **state) {
    (void)state;
    enum { RAYS = 20000 };
    static ball b;
    static snell_ray rays[RAYS];
    static snell_hit hits[2][RAYS];
    for (int way = 0; way < 3; way++) {
        for (int deforms = 0; deforms < 2; deforms++) {
            rig_clear(&bench);
            make_ball(&b);
            make_keys(&b, 0.5);
            build_way(&b, deforms, way, (snell_material_id){0, 0});
            MUST(snell_scene_commit(bench.scene, NULL, NULL));
            uint64_t random = 3;
            for (int i = 0; i < RAYS; i++) {
                double c[7];
                for (int j = 0; j < 7; j++) c[j] = uniform(&random);
                snell_vec3 from = v3(8 * c[0] - 4, 8 * c[1] - 4, 8 * c[2] - 4);
                rays[i] = (snell_ray){.origin = from,
                                      .direction = v3(3 * c[3] - 1 - (double)from.x,
                                                      2 * c[4] - 1 - (double)from.y,
                                                      2 * c[5] - 1 - (double)from.z),
                                      .t_max = INFINITY,
                                      .time = (float)(1.4 * c[6] - 0.2),
                                      .mask = ~0u};
            }
            MUST(snell_scene_intersect_all(bench.scene, rays, hits[deforms], RAYS));
        }
        int found = 0, others = 0;
        for (int i = 0; i < RAYS; i++) {
            const snell_hit *a = &hits[0][i], *c = &hits[1][i];
            found += !isinf(a->t);
            if (a->primitive != c->primitive || isinf(a->t) != isinf(c->t)) {
                others++; /* at an edge */
                continue;
            }
            if (isinf(a->t)) continue;
            ASSERT_CLOSE((double)c->t, (double)a->t, 1e-5, 1e-5);
            ASSERT_CLOSE((double)c->normal.x, (double)a->normal.x, 0, 2e-5);
            ASSERT_CLOSE((double)c->normal.y, (double)a->normal.y, 0, 2e-5);
            ASSERT_CLOSE((double)c->normal.z, (double)a->normal.z, 0, 2e-5);
        }
        assert_true(found > RAYS / 4 && others < RAYS / 2000);
    }
}

/* ---- pictures ---- */

static snell_material_id make_material(int which) {
    snell_lambert_desc desc = SNELL_INIT(lambert_desc);
    snell_checker_texture_desc checker = SNELL_INIT(checker_texture_desc);
    snell_material_id id;
    switch (which) {
    case 0: /* a texture on its uvs */
        checker.size = 0.25f;
        desc.color.value = grey(0.8);
        MUST(snell_scene_add_checker_texture(bench.scene, &checker, &desc.color.texture));
        MUST(snell_scene_add_lambert(bench.scene, &desc, &id));
        return id;
    case 1: return add_glow(&bench, v3(3, 2, 1));
    case 2: return add_mirror(&bench, grey(0.9));
    default: return add_glass(&bench, 1.5, v3(0.2, 0.5, 0.1), 0);
    }
}

static void render_way(const ball *b, bool deforms, int way, int which, snell_integrator policy) {
    rig_clear(&bench);
    snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
    camera.from = v3(0.3, 1.5, 6);
    camera.at = v3(0.3, 0, 0);
    camera.fov = 0.6f;
    MUST(snell_scene_add_perspective_camera(bench.scene, &camera, NULL));
    add_plane(&bench, v3(0, -1.2, 0), v3(0, 1, 0), add_lambert(&bench, grey(0.6)));
    if (which != 1) add_point(&bench, v3(3, 5, 4), grey(60));
    MUST(snell_scene_set_ambient(bench.scene, grey(0.02)));
    build_way(b, deforms, way, make_material(which));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_render_desc desc;
    MUST(snell_scene_settings(bench.scene, policy, &desc));
    desc.width = 48;
    desc.height = 36;
    desc.samples = 16;
    desc.max_depth = 6;
    desc.seed = 2;
    MUST(snell_render(bench.scene, &desc, bench.film));
}

/* Samples of both pictures are drawn alike: they differ by roundings, and at edges. Which triangles of
 * a light are chosen differs too: then the sums are as good as the samples are. */
static void pictures_are_those_of_a_moving_transform(void **state) {
    (void)state;
    enum { COUNT = 48 * 36 * 3 };
    static ball b;
    static float moving[COUNT];
    make_ball(&b);
    make_keys(&b, 0.25 / 24);
    for (int which = 0; which < 4; which++)
        for (snell_integrator policy = SNELL_APPEL; policy <= SNELL_PATH; policy++) {
            int way = (which + (int)policy) % 3;
            render_way(&b, false, way, which, policy);
            memcpy(moving, snell_film_pixels(bench.film, NULL, NULL, NULL), sizeof moving);
            render_way(&b, true, way, which, policy);
            const float *deforming = snell_film_pixels(bench.film, NULL, NULL, NULL);
            double sum = 0, differ = 0, excess = 0;
            for (int i = 0; i < COUNT; i++) {
                sum += (double)moving[i];
                differ += fabs((double)deforming[i] - (double)moving[i]);
                excess += (double)deforming[i] - (double)moving[i];
            }
            double most =
                policy < SNELL_COOK ? 0.03 : 0.01; /* of a light, by a dozen points or by many */
            bool alike = which == 1 ? fabs(excess) < most * sum : differ < 4e-3 * sum;
            if (alike && sum > 10) continue;
            print_error("material %d, integrator %d: %g more, %g apart, of %g\n", which,
                        (int)policy, excess, differ, sum);
            fail();
        }
}

/* A mesh that grows is a brighter light later, by its area, to those who draw lights: the same as rays
 * that only find it would see. */
static void a_growing_light_is_as_bright_as_it_is_large(void **state) {
    (void)state;
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    static const float times[] = {0, 1};
    snell_vec3 positions[8];
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 4; i++)
            positions[4 * k + i] = v3((k ? 2 : 0.5) * (i == 1 || i == 2 ? 1 : -1), 3,
                                      (k ? 1.5 : 0.5) * (i > 1 ? 1 : -1));
    snell_mesh_desc desc = SNELL_INIT(mesh_desc);
    snell_shape_id id;
    desc.positions = positions;
    desc.positions_count = 8;
    desc.indices = indices;
    desc.indices_count = 6;
    desc.key_times = times;
    desc.key_times_count = 2;
    MUST(snell_scene_add_mesh(bench.scene, &desc, &id));
    place(&bench, id, add_glow(&bench, grey(1)));
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_lambert(&bench, grey(1)));
    snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
    camera.from = v3(0.01, 2, 0);
    camera.at = v3(0, 0, 0);
    camera.fov = 0.01f;
    camera.shutter = (snell_vec2){0, 24}; /* a second */
    MUST(snell_scene_add_perspective_camera(bench.scene, &camera, NULL));
    for (int i = 0; i <= 4; i++) { /* and at moments */
        camera.shutter = (snell_vec2){6 * (float)i, 6 * (float)i};
        MUST(snell_scene_add_perspective_camera(bench.scene, &camera, NULL));
    }
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    double mean = 0;
    for (uint32_t c = 2; c <= 6; c++) {
        snell_render_desc settings = picture(SNELL_PATH, 1, 1, 1);
        settings.camera = (snell_camera_id){c, 0};
        settings.samples = 1 << 14;
        settings.pixel_center = false;
        MUST(snell_render(bench.scene, &settings, bench.film));
        /* The form factor from a point below the middle of a rectangle, four corners of a x b at height
         * 3 (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-3). */
        double s = (c - 2) / 4.0, x = (0.5 + 1.5 * s) / 3, y = (0.5 + s) / 3, p = sqrt(1 + x * x),
               q = sqrt(1 + y * y);
        double factor = 4 / (2 * 3.14159265358979) * (x / p * atan(y / p) + y / q * atan(x / q));
        ASSERT_CLOSE(pixel_at(&bench, 0, 0).c[0], factor, 0.01, 0);
        mean += factor * (c == 2 || c == 6 ? 0.5 : 1) / 4;
    }
    snell_render_desc settings = picture(SNELL_COOK, 1, 1, 1);
    settings.camera = (snell_camera_id){1, 0};
    settings.samples = 1 << 14;
    settings.pixel_center = false;
    MUST(snell_render(bench.scene, &settings, bench.film));
    ASSERT_CLOSE(pixel_at(&bench, 0, 0).c[0], mean, 0.02, 0);
}

/* ---- leaving ---- */

static void what_leaves_does_not_come_back(void **state) {
    (void)state;
    enum { RAYS = 20000 };
    static ball b;
    uint64_t random = 6;
    for (int way = 0; way < 3; way++) {
        rig_clear(&bench);
        make_ball(&b);
        make_keys(&b, 0.5);
        build_way(&b, true, way, (snell_material_id){0, 0});
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        const scene *s = bench.scene->frozen;
        int found = 0, stopped = 0;
        for (int i = 0; i < RAYS; i++) {
            double c[7];
            for (int j = 0; j < 7; j++) c[j] = 2 * uniform(&random) - 1;
            vec3 o = v3(20 * c[0], 20 * c[1], 20 * c[2]);
            ray r = ray_make(o, vec3_sub(v3(1 + c[3], c[4], c[5]), o), 0, INFINITY);
            r.time = (float)(0.5 + 0.5 * c[6]);
            hit h;
            accel_trace(s->accel, SNELL_ISA_AUTO, &r, &h, 1, NULL);
            if (h.instance == NO_ID) continue;
            shade_point p;
            scene_shade_point(s, &r, &h, &p);
            if (!p.outside) continue; /* it began inside */
            found++;
            ray out, in;
            /* The middle of the ball at that time is farther in than the normal leans. */
            scene_spawn_ray(&p, p.n, INFINITY, &out);
            scene_spawn_ray(&p, dvec3_negate(p.n), INFINITY, &in);
            out.time = in.time = r.time;
            accel_trace(s->accel, SNELL_ISA_AUTO, &out, &h, 1, NULL);
            stopped += h.instance != NO_ID;
            accel_trace(s->accel, SNELL_ISA_AUTO, &in, &h, 1, NULL);
            assert_true(h.instance != NO_ID);
        }
        assert_true(found > RAYS / 20);
        assert_int_equal(stopped, 0);
    }
}

/* ---- the shutter, memory ---- */

static void a_mesh_that_deforms_is_blurred(void **state) {
    (void)state;
    static ball b;
    uint64_t hashes[3];
    make_ball(&b);
    for (int i = 0; i < 3; i++) {
        rig_clear(&bench);
        make_keys(&b, i == 2 ? 100 : 0.01); /* later: all but still */
        snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
        camera.from = v3(0.3, 1.5, 6);
        camera.at = v3(0.3, 0, 0);
        if (i == 1) camera.shutter = (snell_vec2){0, 0};
        MUST(snell_scene_add_perspective_camera(bench.scene, &camera, NULL));
        place(&bench, add_ball(&b, true), (snell_material_id){0, 0});
        add_point(&bench, v3(3, 5, 4), grey(60));
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        snell_render_desc desc;
        MUST(snell_scene_settings(bench.scene, SNELL_WHITTED, &desc));
        desc.width = 48;
        desc.height = 36;
        MUST(snell_render(bench.scene, &desc, bench.film));
        hashes[i] = snell_film_hash(bench.film);
        /* A view whose shutter no camera has would see keys that were left out. */
        snell_view view = look(v3(0, 0, 5), v3(0, 0, 0));
        view.shutter = (snell_vec2){0, 48};
        desc.view = &view;
        assert_int_equal(snell_render(bench.scene, &desc, bench.film), SNELL_ERR_STATE);
    }
    assert_true(hashes[0] != hashes[1] && hashes[1] != hashes[2] && hashes[0] != hashes[2]);
}

static void memory_counts_the_keys_in_use(void **state) {
    (void)state;
    static ball b;
    uint64_t taken[2], planned[2];
    make_ball(&b);
    for (int i = 0; i < 2; i++) {
        rig_clear(&bench);
        make_keys(&b, i == 0 ? 0.5 : 0.005); /* two keys, or three, while the shutter is open */
        snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
        MUST(snell_scene_add_perspective_camera(bench.scene, &camera, NULL));
        place(&bench, add_ball(&b, true), (snell_material_id){0, 0});
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        accel_memory m = accel_get_memory(bench.scene->frozen->accel);
        taken[i] = m.node_bytes + m.triangle_bytes;
        planned[i] = scene_plan_memory(bench.scene->description, 1);
        assert_true(planned[i] >= taken[i] + m.other_bytes);
        assert_int_equal(m.triangle_count, TRIANGLES);
    }
    ASSERT_CLOSE((double)taken[1], 1.5 * (double)taken[0], 0.02, 0);
    assert_true(planned[1] - planned[0] >= (uint64_t)TRIANGLES * 40);

    /* One byte less than planned is refused. */
    for (int enough = 0; enough < 2; enough++) {
        rig small = {0};
        snell_context_desc desc = SNELL_INIT(context_desc);
        desc.thread_count = 1;
        desc.memory_max = planned[1] - !enough;
        MUST(snell_context_create(&desc, &small.context));
        MUST(snell_scene_create(small.context, &small.scene));
        snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
        MUST(snell_scene_add_perspective_camera(small.scene, &camera, NULL));
        snell_scene *kept = bench.scene;
        bench.scene = small.scene;
        place(&bench, add_ball(&b, true), (snell_material_id){0, 0});
        bench.scene = kept;
        assert_int_equal(snell_scene_commit(small.scene, NULL, NULL),
                         enough ? SNELL_OK : SNELL_ERR_MEMORY);
        snell_scene_destroy(small.scene);
        snell_context_destroy(small.context);
    }
}

static void bounds_are_of_all_keys(void **state) {
    (void)state;
    static ball b;
    make_ball(&b);
    make_keys(&b, 1);
    place(&bench, add_ball(&b, true), (snell_material_id){0, 0});
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_bounds box;
    MUST(snell_scene_bounds(bench.scene, &box));
    ASSERT_CLOSE((double)box.max.x, 1.6 + 0.8, 1e-6, 0);
    ASSERT_CLOSE((double)box.min.x, -1, 1e-6, 0);
    ASSERT_CLOSE((double)box.max.y, 1.25, 1e-6, 0);
}

/* ---- what is refused ---- */

static void bad_keys_are_refused(void **state) {
    (void)state;
    static const uint32_t indices[] = {0, 1, 2}, far[] = {0, 1, 3};
    snell_vec3 positions[9] = {{0}}, broken[9] = {{0}};
    const float good[] = {0, 1, 2}, same[] = {0, 1, 1}, back[] = {0, 2, 1}, bad[] = {0, NAN, 2};
    for (int i = 0; i < 9; i++) broken[i] = positions[i] = v3(i % 3, i / 3, i % 2);
    broken[7].y = NAN;
    const struct {
        const snell_vec3 *positions;
        size_t count;
        const float *times;
        size_t keys, normals;
        const uint32_t *indices;
        const char *text;
    } cases[] = {
        {positions, 9, good, 1, 0, indices,
         "mesh: it deforms between two keys or more, not at one"},
        {positions, 9, same, 3, 0, indices,
         "mesh: key 3, at 1 s, is not later than the one before"},
        {positions, 9, back, 3, 0, indices,
         "mesh: key 3, at 1 s, is not later than the one before"},
        {positions, 9, bad, 3, 0, indices, "mesh: 'key_times' 1 is not a finite number"},
        {positions, 8, good, 3, 0, indices, "mesh: 8 positions are not as many at each of 3 keys"},
        {positions, 9, good, 3, 3, indices, "mesh: 3 normals for 9 positions"},
        {positions, 9, good, 3, 0, far,
         "mesh: index 3 of triangle 0 is out of range: there are 3 positions"},
        {broken, 9, good, 3, 0, indices, "mesh: 'positions' 7 is not a finite number"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        snell_mesh_desc desc = SNELL_INIT(mesh_desc);
        desc.positions = cases[i].positions;
        desc.positions_count = cases[i].count;
        desc.indices = cases[i].indices;
        desc.indices_count = 3;
        desc.key_times = cases[i].times;
        desc.key_times_count = cases[i].keys;
        desc.normals = positions;
        desc.normals_count = cases[i].normals;
        snell_shape_id id;
        assert_int_equal(snell_scene_add_mesh(bench.scene, &desc, &id), SNELL_ERR_ARGUMENT);
        assert_string_equal(snell_last_error()->text, cases[i].text);
    }
    static ball b;
    make_ball(&b);
    make_keys(&b, 1);
    snell_solid_desc solid = SNELL_INIT(solid_desc);
    snell_shape_id part = add_ball(&b, true), made;
    solid.shapes = &part;
    solid.shapes_count = 1;
    assert_int_equal(snell_scene_add_solid(bench.scene, &solid, &made), SNELL_ERR_ARGUMENT);
    assert_string_equal(snell_last_error()->text,
                        "mesh: a mesh that deforms cannot be part of a solid");
}

static void a_mesh_of_nothing_deforms_too(void **state) {
    (void)state;
    static const float times[] = {0, 1};
    snell_mesh_desc desc = SNELL_INIT(mesh_desc);
    snell_shape_id id;
    desc.key_times = times;
    desc.key_times_count = 2;
    MUST(snell_scene_add_mesh(bench.scene, &desc, &id));
    place(&bench, id, (snell_material_id){0, 0});
    place(&bench, id, add_glow(&bench, grey(1)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_ray r = {.origin = v3(0, 0, 0), .direction = v3(0, 0, 1), .t_max = INFINITY, .mask = ~0u};
    snell_hit found;
    MUST(snell_scene_intersect(bench.scene, &r, &found, 1));
    assert_true(isinf(found.t));
}

/* A program that was compiled when meshes did not deform. */
static void an_older_description_stands_still(void **state) {
    (void)state;
    static ball b;
    make_ball(&b);
    snell_mesh_desc desc = SNELL_INIT(mesh_desc);
    snell_shape_id id;
    desc.positions = b.positions;
    desc.positions_count = VERTICES;
    desc.indices = b.indices;
    desc.indices_count = 3;
    desc.key_times = (const float *)(uintptr_t)8;
    desc.key_times_count = 77;
    desc.struct_size = offsetof(snell_mesh_desc, key_times);
    MUST(snell_scene_add_mesh(bench.scene, &desc, &id));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(hits_are_those_of_a_moving_transform, clear),
        cmocka_unit_test_setup(pictures_are_those_of_a_moving_transform, clear),
        cmocka_unit_test_setup(a_growing_light_is_as_bright_as_it_is_large, clear),
        cmocka_unit_test_setup(what_leaves_does_not_come_back, clear),
        cmocka_unit_test_setup(a_mesh_that_deforms_is_blurred, clear),
        cmocka_unit_test_setup(memory_counts_the_keys_in_use, clear),
        cmocka_unit_test_setup(bounds_are_of_all_keys, clear),
        cmocka_unit_test_setup(bad_keys_are_refused, clear),
        cmocka_unit_test_setup(a_mesh_of_nothing_deforms_too, clear),
        cmocka_unit_test_setup(an_older_description_stands_still, clear),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
