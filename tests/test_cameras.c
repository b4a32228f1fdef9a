/* Cameras, lenses, filters and motion: corner rays, closed forms and the reference cases of group J. */
#include <malloc.h>

#include "api/api.h"
#include "maths/functions.h"
#include "reference.h"
#include "render_test.h"
#include "sampling/filter.h"

static rig bench;

static int start(void **state) {
    (void)state;
    bench = rig_make(2, SNELL_ISA_AUTO);
    return 0;
}

static int stop(void **state) {
    (void)state;
    rig_free(&bench);
    reference_free();
    return 0;
}

static int fresh(void **state) {
    (void)state;
    rig_clear(&bench);
    return 0;
}

/* ---- rays ---- */

static bool ray_of(const camera_type *type, void *desc, double x, double y, dvec3 *o, dvec3 *d) {
    camera_frame frame;
    vec3 origin, direction;
    assert_int_equal(type->check(desc), SNELL_OK);
    camera_prepare(type, desc, 400, 200, NULL, &frame);
    if (!camera_ray(type, &frame, &(camera_sample){.x = x, .y = y}, &origin, &direction))
        return false;
    *o = dvec3_from(origin);
    *d = dvec3_from(direction);
    assert_true(fabs(dvec3_length(*d) - 1) < 1e-6);
    return true;
}

#define NEAR(v, X, Y, Z)                                                                           \
    assert_true(fabs((v).x - (X)) < 1e-6 && fabs((v).y - (Y)) < 1e-6 && fabs((v).z - (Z)) < 1e-6)

static const camera_type *find(const char *name) {
    const camera_type *found = (const camera_type *)type_find(CATEGORY_CAMERA, name);
    assert_non_null(found);
    return found;
}

/* What a ray meets is seen where the ray came from. */
static void projections(void **state) {
    (void)state;
    uint64_t random = 5;
    for (uint32_t k = 0; k < camera_type_count; k++) {
        const camera_type *type = camera_types[k];
        char desc[512];
        desc_init(&type->info, desc);
        ((camera_common *)(void *)desc)->at = v3(0.4, -0.3, 1);
        for (int i = 0; i < 200; i++) {
            double x = 400 * uniform(&random), y = 200 * uniform(&random), px, py;
            dvec3 o, d;
            if (!ray_of(type, desc, x, y, &o, &d)) continue;
            camera_frame frame;
            camera_prepare(type, desc, 400, 200, NULL, &frame);
            dvec3 p = dvec3_add(o, dvec3_scale(d, 0.1 + 9 * uniform(&random)));
            assert_true(camera_project(type, &frame, 0, p, &px, &py));
            assert_true(fabs(px - x) < 1e-3 && fabs(py - y) < 1e-3);
        }
    }
}

/* The middle of what is looked at, in a crop; and what is behind. */
static void projection_of_a_crop(void **state) {
    (void)state;
    snell_render_desc desc = picture(SNELL_APPEL, 400, 200, 0);
    snell_view view = look(v3(0, 0, 5), v3(0, 0, 0));
    const snell_vec3 points[2] = {v3(0, 0, 1), v3(0, 0, 6)};
    snell_vec2 pixels[2];
    desc.view = &view;
    desc.crop_x = 30, desc.crop_y = 40, desc.crop_width = desc.crop_height = 10;
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    MUST(snell_scene_project(bench.scene, &desc, points, pixels, 2));
    ASSERT_CLOSE((double)pixels[0].x, 170, 1e-6, 0);
    ASSERT_CLOSE((double)pixels[0].y, 60, 1e-6, 0);
    assert_true(isnan(pixels[1].x) && isnan(pixels[1].y));
    assert_int_equal(snell_scene_project(bench.scene, NULL, points, pixels, 2), SNELL_ERR_ARGUMENT);
}

/* From (0, 0, 5) to the origin, as every camera looks by default. */
static void corner_rays(void **state) {
    (void)state;
    dvec3 o, d;
    char desc[512];
    const camera_type *type = find("orthographic"); /* 2 m high, so 4 m wide */
    desc_init(&type->info, desc);
    assert_true(ray_of(type, desc, 0, 0, &o, &d));
    NEAR(o, -2, 1, 5);
    NEAR(d, 0, 0, -1);
    assert_true(ray_of(type, desc, 400, 200, &o, &d));
    NEAR(o, 2, -1, 5);

    type = find("panorama");
    desc_init(&type->info, desc);
    assert_true(ray_of(type, desc, 200, 100, &o, &d));
    NEAR(d, 0, 0, -1);
    assert_true(ray_of(type, desc, 300, 100, &o, &d)); /* a quarter to the right */
    NEAR(d, 1, 0, 0);
    assert_true(ray_of(type, desc, 0, 100, &o, &d)); /* both edges look back */
    NEAR(d, 0, 0, 1);
    assert_true(ray_of(type, desc, 400, 100, &o, &d));
    NEAR(d, 0, 0, 1);
    for (int corner = 0; corner < 4; corner++) {
        assert_true(ray_of(type, desc, corner % 2 * 400, corner / 2 * 200, &o, &d));
        NEAR(d, 0, corner < 2 ? 1 : -1, 0);
        NEAR(o, 0, 0, 5);
    }

    type = find("fisheye"); /* half a sphere in a circle of 200 pixels */
    desc_init(&type->info, desc);
    assert_true(ray_of(type, desc, 200, 100, &o, &d));
    NEAR(d, 0, 0, -1);
    assert_true(ray_of(type, desc, 300, 100, &o, &d));
    NEAR(d, 1, 0, 0);
    assert_true(ray_of(type, desc, 200, 50, &o, &d)); /* half way up: 45 degrees */
    NEAR(d, 0, sqrt(0.5), -sqrt(0.5));
    assert_false(ray_of(type, desc, 0, 0, &o, &d));
    assert_false(ray_of(type, desc, 400, 200, &o, &d));
    assert_false(ray_of(type, desc, 300.1, 100, &o, &d));
    assert_false(ray_of(type, desc, 272, 172, &o, &d));
    assert_true(ray_of(type, desc, 270, 170, &o, &d));
}

/* All rays of a pixel meet in the plane of focus, whatever place on the lens. */
static void lens_is_sharp_in_focus(void **state) {
    (void)state;
    perspective_desc desc;
    desc_init(&camera_perspective.info, &desc);
    desc.lens_radius = 0.3f;
    desc.focus = 7;
    uint64_t random = 1;
    for (int blades = 0; blades <= 7; blades++) {
        if (blades == 1 || blades == 2) continue;
        desc.blades = blades;
        camera_frame frame;
        camera_prepare(&camera_perspective, &desc, 400, 200, NULL, &frame);
        double reach = 0;
        for (int i = 0; i < 200; i++) {
            vec3 o, d;
            camera_sample at = {.x = 31, .y = 170, .lens = {uniform(&random), uniform(&random)}};
            assert_true(camera_ray(&camera_perspective, &frame, &at, &o, &d));
            double t = ((double)o.z - (5 - 7)) / -(double)d.z, pixel = 2 * tan(0.6981317 / 2) / 200;
            assert_true(fabs((double)o.z - 5) < 1e-6);
            assert_true(fabs((double)o.x + t * (double)d.x - (31 - 200) * pixel * 7) < 1e-5);
            assert_true(fabs((double)o.y + t * (double)d.y - (100 - 170) * pixel * 7) < 1e-5);
            double r = sqrt((double)o.x * (double)o.x + (double)o.y * (double)o.y);
            assert_true(r < 0.3 + 1e-6);
            reach = r > reach ? r : reach;
        }
        assert_true(reach > 0.2);
    }
    desc.blades = 2;
    assert_int_equal(camera_perspective.check(&desc), SNELL_ERR_ARGUMENT);
}

/* Rays through one point of the blurred plane come from all over its circle of confusion: the
 * diameter is measured where the lens's edge projects the point into the plane of focus. */
static void circle_of_confusion(const reference_case *c) {
    double focus = json_number_value(json_object_get(c->scene, "focus_distance"));
    double distance = json_number_value(json_object_get(c->scene, "object_distance"));
    double aperture = json_number_value(json_object_get(c->scene, "aperture_diameter"));
    double fov = json_number_value(json_object_get(c->scene, "vfov_deg")) * PI / 180;
    double height = json_number_value(json_object_get(c->scene, "image_height_px"));
    perspective_desc desc;
    desc_init(&camera_perspective.info, &desc);
    desc.from = v3(0, 0, 0);
    desc.at = v3(0, 0, -1);
    desc.fov = (float)fov;
    desc.lens_radius = (float)(aperture / 2);
    desc.focus = (float)focus;
    camera_frame frame;
    camera_prepare(&camera_perspective, &desc, (uint32_t)height, (uint32_t)height, NULL, &frame);
    /* From the lens's left and right edge, the columns whose rays meet (0, 0, -distance): bisect. */
    double column[2];
    for (int side = 0; side < 2; side++) {
        double low = -height, high = 2 * height;
        for (int step = 0; step < 60; step++) {
            vec3 o, d;
            camera_sample at = {(low + high) / 2, height / 2, {side ? 1 : 0, 0.5}, 0};
            assert_true(camera_ray(&camera_perspective, &frame, &at, &o, &d));
            double t = (-distance - (double)o.z) / (double)d.z;
            if ((double)o.x + t * (double)d.x < 0)
                low = at.x;
            else
                high = at.x;
        }
        column[side] = (low + high) / 2;
    }
    double pixels = fabs(column[1] - column[0]);
    double on_plane = pixels * 2 * focus * tan(fov / 2) / height;
    assert_true(
        reference_agrees(c, pixels, json_number_value(json_object_get(c->expected, "pixels"))));
    assert_true(reference_agrees(
        c, on_plane, json_number_value(json_object_get(c->expected, "on_focus_plane"))));
}

static void circles_of_confusion(void **state) {
    (void)state;
    assert_int_equal(reference_each("J.thin_lens", circle_of_confusion), 4);
}

/* ---- filters ---- */

static snell_camera_id add_camera(const char *type, const snell_param *params, size_t count) {
    snell_camera_id id;
    MUST(snell_scene_add_camera(bench.scene, type, params, count, &id));
    return id;
}

/* A picture of one pixel, looking down -z from (x, y, 5), `side` metres high. */
static double look_straight(double x, double y, double side, uint32_t samples, snell_filter filter,
                            float radius) {
    const snell_param params[] = {
        {.name = "from", .kind = SNELL_PARAM_VEC3, .value.v = v3(x, y, 5)},
        {.name = "at", .kind = SNELL_PARAM_VEC3, .value.v = v3(x, y, 0)},
        {.name = "shutter", .kind = SNELL_PARAM_VEC3, .value.v = v3(0, 24, 0)}, /* 0 to 1 s */
        {.name = "height", .kind = SNELL_PARAM_FLOAT, .value.f = side}};
    snell_render_desc desc = picture(SNELL_APPEL, 1, 1, 0);
    desc.camera = add_camera("orthographic", params, 4);
    desc.samples = samples;
    desc.pixel_center = false;
    desc.filter = filter;
    desc.filter_radius = radius;
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    MUST(snell_render(bench.scene, &desc, bench.film));
    return pixel_at(&bench, 0, 0).c[0];
}

static void edge_profile(const reference_case *c) {
    static const struct {
        const char *name;
        snell_filter filter;
    } filters[] = {{"box_width1", SNELL_FILTER_BOX},
                   {"tent_radius1", SNELL_FILTER_TENT},
                   {"gauss_s0_5_r1_5_truncated", SNELL_FILTER_GAUSSIAN}};
    add_quad(&bench, v3(0, -50, 0), v3(50, 0, 0), v3(0, 100, 0), add_glow(&bench, grey(1)));
    const json_t *x = json_object_get(c->expected, "x");
    for (size_t f = 0; f < 3; f++) {
        const json_t *expected = json_object_get(c->expected, filters[f].name);
        for (size_t i = 0; i < json_array_size(x); i++) {
            double got = look_straight(reference_number(x, i), 0, 1, 1 << 14, filters[f].filter, 0);
            ASSERT_CLOSE(got, reference_number(expected, i), 1e-3, 3e-4);
        }
    }
}

static void edge_profiles(void **state) {
    (void)state;
    assert_int_equal(reference_each("J.filters", edge_profile) >= 1, true);
}

/* The shape of every filter by its moments and its support; and of another radius. */
static void filters_have_their_shape(void **state) {
    (void)state;
    enum { N = 100000 };
    static const double variances[] = {0.25 / 3, 1.0 / 6, 0.243345, 0.172659};
    static const double radii[] = {0.5, 1, 1.5, 1.5};
    for (int kind = 0; kind < 4; kind++)
        for (int wide = 0; wide < 2; wide++) {
            pixel_filter f;
            double sum = 0, squares = 0, scale = wide ? 2 : 1;
            assert_true(pixel_filter_create(kind, wide ? 2 * radii[kind] : 0, &f));
            for (int i = 0; i < N; i++) {
                double x = pixel_filter_offset(&f, (i + 0.5) / N) / scale;
                assert_true(fabs(x) <= radii[kind]);
                sum += x;
                squares += x * x;
            }
            assert_true(fabs(sum / N) < 1e-6);
            ASSERT_CLOSE(squares / N, variances[kind], 1e-3, 0);
            pixel_filter_free(&f);
        }
    pixel_filter box; /* no bit of older pictures changes */
    assert_true(pixel_filter_create(0, 0, &box));
    uint64_t random = 3;
    for (int i = 0; i < 1000; i++) {
        double s = floor(uniform(&random) * 0x1p32) * 0x1p-32;
        assert_true(0.5 + pixel_filter_offset(&box, s) == s);
    }
    snell_render_desc desc = picture(SNELL_APPEL, 1, 1, 0);
    add_camera("perspective", NULL, 0);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    desc.filter_radius = 17;
    assert_int_equal(snell_render(bench.scene, &desc, bench.film), SNELL_ERR_ARGUMENT);
    desc.filter_radius = NAN;
    assert_int_equal(snell_render(bench.scene, &desc, bench.film), SNELL_ERR_ARGUMENT);
    desc.filter_radius = 0;
    desc.filter = (snell_filter)4;
    assert_int_equal(snell_render(bench.scene, &desc, bench.film), SNELL_ERR_ARGUMENT);
}

/* ---- motion ---- */

static snell_motion_key key(double time, double x, double y, double z) {
    return (snell_motion_key){(float)time,
                              {{{1, 0, 0, (float)x}, {0, 1, 0, (float)y}, {0, 0, 1, (float)z}}}};
}

static snell_motion_key turned(double time, double degrees) {
    float c = (float)fn_cos(degrees * PI / 180), s = (float)fn_sin(degrees * PI / 180);
    return (snell_motion_key){(float)time, {{{c, -s, 0, 0}, {s, c, 0, 0}, {0, 0, 1, 0}}}};
}

static void motion_coverage(const reference_case *c) {
    const json_t *shape = json_array_get(json_object_get(c->scene, "geometry"), 0);
    double speed = reference_number(json_object_get(shape, "velocity"), 0);
    double radius = json_number_value(json_object_get(shape, "radius"));
    snell_motion_key keys[2] = {key(0, 0, 0, 0), key(1, speed, 0, 0)};
    for (int sphere = 0; sphere < 2; sphere++)
        for (size_t i = 0; i < json_array_size(c->expected); i++) {
            const json_t *row = json_array_get(c->expected, i);
            rig_clear(&bench);
            snell_material_id glow = add_glow(&bench, grey(1));
            snell_instance_id id;
            if (sphere) {
                id = add_sphere(&bench, v3(0, 0, 0), radius, glow);
            } else {
                snell_disk_desc disk = SNELL_INIT(disk_desc);
                snell_shape_id shape_id;
                disk.normal = v3(0, 0, 1);
                disk.radius = (float)radius;
                MUST(snell_scene_add_disk(bench.scene, &disk, &shape_id));
                id = place(&bench, shape_id, glow);
            }
            MUST(snell_scene_set_instance_motion(bench.scene, id, keys, 2));
            double got = look_straight(reference_number(row, 0), reference_number(row, 1), 1e-6,
                                       1 << 14, SNELL_FILTER_BOX, 0);
            ASSERT_CLOSE(got, reference_number(row, 2), c->rel, 2e-4);
        }
}

static void motion_coverages(void **state) {
    (void)state;
    assert_int_equal(reference_each("J.motion_blur", motion_coverage), 2);
}

static float hit_distance(double x, double y, double time) {
    snell_ray r = {.origin = v3(x, y, 10),
                   .direction = v3(0, 0, -1),
                   .t_max = INFINITY,
                   .time = (float)time,
                   .mask = ~0u};
    snell_hit found;
    MUST(snell_scene_intersect(bench.scene, &r, &found, 1));
    uint8_t blocked;
    MUST(snell_scene_occluded(bench.scene, &r, &blocked, 1));
    assert_int_equal(blocked, !isinf(found.t));
    return found.t;
}

/* A small ball on an arm of length 2 goes along the arc, not along the chord; without a camera every
 * key counts. */
static void turns_follow_the_arc(void **state) {
    (void)state;
    snell_instance_id id = add_sphere(&bench, v3(2, 0, 0), 0.05, (snell_material_id){0, 0});
    const snell_motion_key keys[] = {turned(1, 0), turned(2, 90), turned(4, 200)};
    MUST(snell_scene_set_instance_motion(bench.scene, id, keys, 3));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    for (int i = 0; i <= 60; i++) {
        double time = 0.5 + 4 * i / 60.0;
        double degrees = time < 1   ? 0
                         : time < 2 ? 90 * (time - 1)
                         : time < 4 ? 90 + 55 * (time - 2)
                                    : 200;
        double x = 2 * cos(degrees * PI / 180), y = 2 * sin(degrees * PI / 180);
        ASSERT_CLOSE((double)hit_distance(x, y, time), 9.95, 1e-3, 0);
        assert_true(isinf(hit_distance(-x, -y, time)));
    }
    transform at = scene_instance_transform(bench.scene->frozen, 0, 1.5f);
    ASSERT_CLOSE((double)at.m[0][0], sqrt(0.5), 2e-3, 0);
    snell_bounds b;
    MUST(snell_scene_bounds(bench.scene, &b));
    assert_true((double)b.max.y > 2 && (double)b.min.x < -1.9);
    /* Standing still again. */
    MUST(snell_scene_set_instance_transform(bench.scene, id, NULL));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    ASSERT_CLOSE((double)hit_distance(2, 0, 2), 9.95, 1e-6, 0);
}

/* Scale, mirror and a mesh: hits lie on the shape where it is at that time, and normals fit. */
static void moving_meshes_are_where_they_are(void **state) {
    (void)state;
    const snell_vec3 corners[] = {v3(-1, -1, 0), v3(1, -1, 0), v3(0, 1, 0)};
    const uint32_t indices[] = {0, 1, 2};
    snell_instance_id id =
        place(&bench, add_mesh(&bench, corners, 3, indices, 3), (snell_material_id){0, 0});
    snell_motion_key keys[2] = {key(0, 0, 0, 0), key(1, 0, 0, 4)};
    for (size_t k = 0; k < 2; k++) keys[k].transform.m[0][0] = -1; /* mirrored throughout */
    keys[1].transform.m[1][1] = 3;
    MUST(snell_scene_set_instance_motion(bench.scene, id, keys, 2));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    for (int i = 0; i <= 10; i++) {
        double time = i / 10.0;
        ASSERT_CLOSE((double)hit_distance(0, 0, time), 10 - 4 * time, 1e-6, 0);
        double tip = 1 + 2 * time;
        assert_true(!isinf(hit_distance(0, tip * 0.99, time)));
        assert_true(isinf(hit_distance(0, tip * 1.01, time)));
    }
    snell_ray r = {.origin = v3(0, 0, 10),
                   .direction = v3(0, 0, -1),
                   .t_max = INFINITY,
                   .time = 0.5f,
                   .mask = ~0u};
    snell_hit found;
    MUST(snell_scene_intersect(bench.scene, &r, &found, 1));
    ASSERT_CLOSE((double)found.normal.z, 1, 1e-6, 0);
}

/* Rays that leave a convex thing on its outside, at the moment at which they met it, do not meet it
 * again: far from the origin, turning, small and large. */
static void moving_things_do_not_hit_themselves(void **state) {
    (void)state;
    enum { RAYS = 20000 };
    static const double places[] = {0, 1000}, sizes[] = {0.01, 1, 50};
    uint64_t random = 4;
    int hits = 0;
    for (int which = 0; which < 12; which++) {
        double place_x = places[which % 2], size = sizes[which / 2 % 3];
        rig_clear(&bench);
        snell_instance_id id =
            which < 6 ? add_sphere(&bench, v3(0, 0, 0), 1, (snell_material_id){0, 0})
                      : add_box(&bench, v3(-1, -1, -1), v3(1, 1, 1), (snell_material_id){0, 0});
        snell_motion_key keys[2] = {turned(0, 10), turned(1, 120)};
        for (int k = 0; k < 2; k++)
            for (int i = 0; i < 3; i++) {
                for (int j = 0; j < 3; j++)
                    keys[k].transform.m[i][j] *= (float)(size * (1 + 0.1 * i));
                keys[k].transform.m[i][3] = (float)(place_x + k * size);
            }
        MUST(snell_scene_set_instance_motion(bench.scene, id, keys, 2));
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        const scene *s = bench.scene->frozen;
        for (int n = 0; n < RAYS; n++) {
            double time = uniform(&random), at = place_x + time * size;
            vec3 o = v3(at + 4 * size * (uniform(&random) - 0.5),
                        at + 4 * size * (uniform(&random) - 0.5), at + 4 * size);
            vec3 d = v3(at - (double)o.x + size * (uniform(&random) - 0.5),
                        at - (double)o.y + size * (uniform(&random) - 0.5), at - (double)o.z);
            ray r = ray_make(o, d, 0, INFINITY);
            r.time = (float)time;
            hit found, again;
            accel_trace(s->accel, SNELL_ISA_AUTO, &r, &found, 1, NULL);
            if (found.instance == NO_ID) continue;
            shade_point p;
            scene_shade_point(s, &r, &found, &p);
            dvec3 out = {uniform(&random) - 0.5, uniform(&random) - 0.5, uniform(&random) - 0.5};
            if (dvec3_dot(out, p.n) < 0) out = dvec3_negate(out);
            ray next;
            scene_spawn_ray(&p, out, INFINITY, &next);
            next.time = r.time;
            accel_trace(s->accel, SNELL_ISA_AUTO, &next, &again, 1, NULL);
            assert_int_equal(again.instance, NO_ID);
            hits++;
        }
    }
    assert_true(hits > RAYS * 6);
}

/* What no shutter sees is left out, and only a camera that was committed for may look. */
static void motions_are_clipped_to_the_shutters(void **state) {
    (void)state;
    snell_instance_id id = add_sphere(&bench, v3(0, 0, 0), 1, add_glow(&bench, grey(1)));
    const snell_motion_key keys[] = {key(0, 0, 0, 0), key(100, 1000, 0, 0)};
    MUST(snell_scene_set_instance_motion(bench.scene, id, keys, 2));
    snell_animation clock = SNELL_INIT(animation);
    clock.fps = 10;
    clock.frame = 11; /* 1 s: at x = 10 */
    MUST(snell_scene_set_animation(bench.scene, &clock));
    add_camera("perspective", NULL, 0);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_bounds b;
    MUST(snell_scene_bounds(bench.scene, &b));
    ASSERT_CLOSE((double)b.min.x, 9, 1e-4, 0);
    ASSERT_CLOSE((double)b.max.x, 11.5, 1e-4, 0);
    snell_render_desc desc = picture(SNELL_APPEL, 1, 1, 0);
    snell_view view = look(v3(10, 0, 5), v3(10, 0, 0));
    desc.view = &view;
    MUST(snell_render(bench.scene, &desc, bench.film));
    assert_true(pixel_at(&bench, 0, 0).c[0] == 1);
    view.shutter = (snell_vec2){0, 3};
    assert_int_equal(snell_render(bench.scene, &desc, bench.film), SNELL_ERR_STATE);
    clock.frame = 0;
    assert_int_equal(snell_scene_set_animation(bench.scene, &clock), SNELL_ERR_ARGUMENT);
    clock.struct_size = 1;
    assert_int_equal(snell_scene_set_animation(bench.scene, &clock), SNELL_ERR_VERSION);
}

/* A camera that travels sees what still things a still camera would see travelling. */
static void cameras_move(void **state) {
    (void)state;
    add_sphere(&bench, v3(0, 0, 0), 1, add_glow(&bench, grey(1)));
    const snell_motion_key keys[] = {key(0, 0, 0, 0), key(1, -4, 0, 0)};
    const snell_param params[] = {
        {.name = "shutter", .kind = SNELL_PARAM_VEC3, .value.v = v3(0, 24, 0)},
        {.name = "height", .kind = SNELL_PARAM_FLOAT, .value.f = 1e-6},
        {.name = "from", .kind = SNELL_PARAM_VEC3, .value.v = v3(1, 0, 5)},
        {.name = "at", .kind = SNELL_PARAM_VEC3, .value.v = v3(1, 0, 0)},
        {.name = "motion", .kind = SNELL_PARAM_ARRAY, .value.array = {keys, 2}}};
    snell_render_desc desc = picture(SNELL_APPEL, 1, 1, 0);
    desc.camera = add_camera("orthographic", params, 5);
    desc.samples = 1 << 12;
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    MUST(snell_render(bench.scene, &desc, bench.film));
    ASSERT_CLOSE(pixel_at(&bench, 0, 0).c[0], 0.5, 1e-3, 0); /* within the ball from 1 to -1 */
}

static void refused(const snell_motion_key *keys, size_t count, const char *text) {
    snell_instance_id id = add_sphere(&bench, v3(0, 0, 0), 1, (snell_material_id){0, 0});
    assert_int_equal(snell_scene_set_instance_motion(bench.scene, id, keys, count),
                     SNELL_ERR_ARGUMENT);
    if (strstr(snell_last_error()->text, text) == NULL) {
        fprintf(stderr, "'%s' lacks '%s'\n", snell_last_error()->text, text);
        fail();
    }
}

static void bad_motions_are_refused(void **state) {
    (void)state;
    snell_motion_key good = key(0, 0, 0, 0), late = key(1, 1, 0, 0), bad = key(NAN, 0, 0, 0);
    refused(NULL, 0, "needs a key");
    refused((snell_motion_key[]){late, good}, 2, "not later than the one before");
    refused((snell_motion_key[]){good, good}, 2, "not later than the one before");
    refused(&bad, 1, "time of key 1 is not finite");
    bad = key(0, INFINITY, 0, 0);
    refused(&bad, 1, "cannot be inverted");
    bad = key(0, 0, 0, 0);
    bad.transform.m[1][1] = 0;
    refused(&bad, 1, "cannot be inverted");
    snell_instance_id id = add_sphere(&bench, v3(0, 0, 0), 1, (snell_material_id){0, 0});
    late.transform.m[0][0] = -1; /* through flat */
    MUST(snell_scene_set_instance_motion(bench.scene, id, (snell_motion_key[]){good, late}, 2));
    assert_int_equal(snell_scene_commit(bench.scene, NULL, NULL), SNELL_ERR_ARGUMENT);
    assert_non_null(strstr(snell_last_error()->text, "flattens what it moves"));
    assert_int_equal(
        snell_scene_set_instance_motion(bench.scene, (snell_instance_id){99, 0}, &good, 1),
        SNELL_ERR_ARGUMENT);
    const snell_param shutter = {
        .name = "shutter", .kind = SNELL_PARAM_VEC3, .value.v = v3(1, 0, 0)};
    assert_int_equal(snell_scene_add_camera(bench.scene, "panorama", &shutter, 1, NULL),
                     SNELL_ERR_ARGUMENT);
}

/* Room for 16 steps was taken for every key, and for keys that no shutter sees. */
static void motions_take_what_they_need(void **state) {
    (void)state;
    enum { KEYS = 1 << 20 };
    snell_motion_key *keys = calloc(KEYS, sizeof *keys);
    assert_non_null(keys);
    for (int i = 0; i < KEYS; i++) keys[i] = key(i, i % 7, 0, 0);
    motion m;
    MUST(motion_prepare(keys, KEYS, 5.5, 7.5, &m));
    assert_int_equal(m.count, 4);
    assert_true(malloc_usable_size(m.steps) < 1024);
    motion_free(&m);
    MUST(motion_prepare(keys, KEYS, -INFINITY, INFINITY, &m));
    assert_int_equal(m.count, KEYS);
    assert_true(malloc_usable_size(m.steps) < KEYS * sizeof *keys + (1 << 20));
    motion_free(&m);
    enum { TURNS = MOTION_STEPS_MAX / MOTION_STEPS + 2 };
    for (int i = 0; i < TURNS; i += 2) { /* a quarter to and fro */
        keys[i].transform.m[0][0] = keys[i].transform.m[2][2] = 0;
        keys[i].transform.m[0][2] = 1;
        keys[i].transform.m[2][0] = -1;
    }
    assert_int_equal(motion_prepare(keys, TURNS, -INFINITY, INFINITY, &m), SNELL_ERR_ARGUMENT);
    assert_non_null(strstr(snell_last_error()->text, "more than 1048576 linear steps"));
    assert_null(m.steps);
    MUST(motion_prepare(keys, TURNS, 0, 1000, &m));
    assert_int_equal(m.count, 16001);
    motion_free(&m);
    free(keys);
}

/* Black corners, a clear film there, and no endless loop where a block has no ray at all. */
static void fisheye_pictures(void **state) {
    (void)state;
    const snell_param narrow = {.name = "fov", .kind = SNELL_PARAM_FLOAT, .value.f = 1};
    MUST(snell_scene_set_background(bench.scene, grey(1), 1));
    add_sphere(&bench, v3(0, 0, 100), 1, (snell_material_id){0, 0});
    snell_render_desc desc = picture(SNELL_APPEL, 200, 64, 0);
    desc.camera = add_camera("fisheye", &narrow, 1);
    desc.samples = 9;
    desc.pixel_center = false;
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    MUST(snell_render(bench.scene, &desc, bench.film));
    assert_true(pixel_at(&bench, 0, 0).c[0] == 0 && pixel_at(&bench, 60, 32).c[0] == 0);
    assert_true(pixel_at(&bench, 100, 32).c[0] == 1 && pixel_at(&bench, 131, 32).c[0] > 0);
    snell_view view;
    assert_int_equal(snell_scene_get_view(bench.scene, desc.camera, &view), SNELL_ERR_UNSUPPORTED);
}

/* A view that was taken from a camera gives the camera's picture: lens, shutter, motion and all. */
static void views_keep_everything(void **state) {
    (void)state;
    snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
    const snell_motion_key keys[] = {key(0, 0, 0, 0), key(0.1, 1, 0, 0)};
    camera.from = v3(0, 1, 6);
    camera.lens_radius = 0.2f;
    camera.focus = 4;
    camera.blades = 5;
    camera.blade_rotation = 0.2f;
    camera.shutter = (snell_vec2){0, 1};
    camera.motion = keys;
    camera.motion_count = 2;
    MUST(snell_scene_add_perspective_camera(bench.scene, &camera, NULL));
    add_sphere(&bench, v3(0, 0, 0), 1, add_glow(&bench, grey(1)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_render_desc desc = picture(SNELL_APPEL, 32, 24, 0);
    desc.samples = 8;
    MUST(snell_render(bench.scene, &desc, bench.film));
    uint64_t hash = snell_film_hash(bench.film);
    snell_view view;
    MUST(snell_scene_get_view(bench.scene, (snell_camera_id){0, 0}, &view));
    desc.view = &view;
    MUST(snell_render(bench.scene, &desc, bench.film));
    assert_true(snell_film_hash(bench.film) == hash);
    view.lens_radius = 0;
    MUST(snell_render(bench.scene, &desc, bench.film));
    assert_true(snell_film_hash(bench.film) != hash);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(corner_rays, fresh),
        cmocka_unit_test_setup(projections, fresh),
        cmocka_unit_test_setup(projection_of_a_crop, fresh),
        cmocka_unit_test_setup(lens_is_sharp_in_focus, fresh),
        cmocka_unit_test_setup(circles_of_confusion, fresh),
        cmocka_unit_test_setup(edge_profiles, fresh),
        cmocka_unit_test_setup(filters_have_their_shape, fresh),
        cmocka_unit_test_setup(motion_coverages, fresh),
        cmocka_unit_test_setup(turns_follow_the_arc, fresh),
        cmocka_unit_test_setup(moving_meshes_are_where_they_are, fresh),
        cmocka_unit_test_setup(moving_things_do_not_hit_themselves, fresh),
        cmocka_unit_test_setup(motions_are_clipped_to_the_shutters, fresh),
        cmocka_unit_test_setup(cameras_move, fresh),
        cmocka_unit_test_setup(bad_motions_are_refused, fresh),
        cmocka_unit_test_setup(motions_take_what_they_need, fresh),
        cmocka_unit_test_setup(fisheye_pictures, fresh),
        cmocka_unit_test_setup(views_keep_everything, fresh),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
