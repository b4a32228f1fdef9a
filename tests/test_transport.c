/* Reference values of lights, environments and closed rooms, through the public API, by path tracing
 * and, where only direct light is asked for, by distributed ray tracing too. */
#include "reference.h"
#include "transport_test.h"

static rig bench;
static family records;

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

/* ---- from a record to a scene ---- */

static json_t *get(const json_t *object, const char *name) { return json_object_get(object, name); }
static double number(const json_t *object, const char *name) {
    return json_number_value(get(object, name));
}
static bool is(const json_t *object, const char *name, const char *word) {
    const char *found = json_string_value(get(object, name));
    return found && strcmp(found, word) == 0;
}
static snell_vec3 vector(const json_t *value) {
    return v3(reference_number(value, 0), reference_number(value, 1), reference_number(value, 2));
}
static double along(snell_vec3 a, snell_vec3 b) {
    return (double)a.x * (double)b.x + (double)a.y * (double)b.y + (double)a.z * (double)b.z;
}

/* Records have +z up, environments here +y. */
static snell_vec3 y_up(snell_vec3 v) { return v3((double)v.x, (double)v.z, -(double)v.y); }

static snell_material_id lambert_of(const json_t *scene) {
    return add_lambert(&bench, grey(number(get(get(scene, "materials"), "m"), "R")));
}

/* The first shape is the plane that is looked at. */
static void add_floor(const json_t *scene) {
    const json_t *plane = json_array_get(get(scene, "geometry"), 0);
    add_plane(&bench, vector(get(plane, "point")), vector(get(plane, "normal")), lambert_of(scene));
}

/* From a centimetre off, which is under every light, unless another distance is asked for. */
static snell_vec3 eye_at(snell_vec3 hit, snell_vec3 toward, double distance) {
    return v3((double)hit.x + distance * (double)toward.x,
              (double)hit.y + distance * (double)toward.y,
              (double)hit.z + distance * (double)toward.z);
}

/* Takes four times the samples until the estimate is good enough to prove something. */
static void check_point(const reference_case *c, snell_integrator policy, snell_vec3 eye,
                        snell_vec3 hit, uint32_t depth, double expected) {
    char name[120];
    snprintf(name, sizeof name, "%s by %s to depth %u", c->name,
             policy == SNELL_COOK ? "cook" : "path", depth);
    estimate e = {0};
    for (uint32_t samples = 16; samples <= 4096; samples *= 4) {
        e = estimate_light(&bench, policy, eye, hit, depth, samples);
        if (moments_error(&e.channel[0]) < 0.004 * expected) break;
        if (expected == 0) break;
    }
    family_check_mean(&records, name, &e.channel[0], expected);
}

static double expected_radiance(const reference_case *c) {
    const json_t *r = json_is_object(c->expected) ? get(c->expected, "radiance") : c->expected;
    assert_true(json_is_number(r));
    return json_number_value(r);
}

/* Light sampling alone, both ways together, and all that a path can find: the lights are black. */
static void check_direct(const reference_case *c, snell_vec3 toward) {
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_vec3 hit = vector(get(get(c->scene, "ray"), "hit")), eye = eye_at(hit, toward, 0.01);
    double expected = expected_radiance(c);
    check_point(c, SNELL_COOK, eye, hit, 1, expected);
    check_point(c, SNELL_PATH, eye, hit, 0, expected);
    check_point(c, SNELL_PATH, eye, hit, 1, expected);
    check_point(c, SNELL_PATH, eye, hit, 64, expected);
}

/* ---- A: the spot's falloff is pbrt's ---- */

static void spot(const reference_case *c) {
    rig_clear(&bench);
    const json_t *light = json_array_get(get(c->scene, "lights"), 0);
    snell_spot_light_desc desc = SNELL_INIT(spot_light_desc);
    double outer = number(light, "outer_half_angle_deg"),
           inner = number(light, "inner_half_angle_deg");
    desc.position = vector(get(light, "position"));
    desc.at = eye_at(desc.position, vector(get(light, "axis")), 1);
    desc.intensity = grey(number(light, "intensity_on_axis"));
    desc.cone = (float)(outer * PI_ / 180);
    desc.blend = (float)((outer - inner) * PI_ / 180);
    add_floor(c->scene);
    MUST(snell_scene_add_spot_light(bench.scene, &desc, NULL));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    double expected = number(c->expected, "pbrt_smoothstep_in_cos");
    snell_vec3 hit = vector(get(get(c->scene, "ray"), "hit")), eye = eye_at(hit, v3(0, 0, 1), 0.5);
    for (snell_integrator policy = SNELL_APPEL; policy <= SNELL_PATH; policy++)
        assert_true(reference_agrees(c, trace_ray(&bench, policy, eye, hit, 1).c[0], expected));
}

static void spots(void **state) {
    (void)state;
    assert_int_equal(reference_each("A.spot", spot), 3);
}

/* ---- B, C: lights with an area ---- */

static void sphere_light(const reference_case *c) {
    rig_clear(&bench);
    const json_t *light = json_array_get(get(c->scene, "lights"), 0);
    snell_sphere_light_desc desc = SNELL_INIT(sphere_light_desc);
    desc.center = vector(get(light, "center"));
    desc.radius = (float)number(light, "radius");
    desc.radiance = grey(number(light, "radiance"));
    add_floor(c->scene);
    MUST(snell_scene_add_sphere_light(bench.scene, &desc, NULL));
    check_direct(c, vector(get(get(c->scene, "ray"), "toward_eye")));
}

/* Turned so that it faces the point that is looked at. */
static void add_rect(const json_t *light, snell_vec3 hit) {
    snell_quad_light_desc desc = SNELL_INIT(quad_light_desc);
    snell_vec3 u = vector(get(light, "edge_u")), v = vector(get(light, "edge_v"));
    desc.corner = vector(get(light, "corner"));
    snell_vec3 n = v3((double)u.y * (double)v.z - (double)u.z * (double)v.y,
                      (double)u.z * (double)v.x - (double)u.x * (double)v.z,
                      (double)u.x * (double)v.y - (double)u.y * (double)v.x);
    bool faces = along(n, hit) > along(n, desc.corner);
    desc.u = faces ? u : v;
    desc.v = faces ? v : u;
    desc.radiance = grey(number(light, "radiance"));
    MUST(snell_scene_add_quad_light(bench.scene, &desc, NULL));
}

static void rect_light(const reference_case *c) {
    rig_clear(&bench);
    const json_t *ray = get(c->scene, "ray");
    add_floor(c->scene);
    add_rect(json_array_get(get(c->scene, "lights"), 0), vector(get(ray, "hit")));
    check_direct(c, vector(get(ray, "toward_eye")));
}

static void disk_light(const reference_case *c) {
    rig_clear(&bench);
    const json_t *light = json_array_get(get(c->scene, "lights"), 0);
    snell_disk_light_desc desc = SNELL_INIT(disk_light_desc);
    desc.center = vector(get(light, "center"));
    desc.normal = vector(get(light, "normal"));
    desc.radius = (float)number(light, "radius");
    desc.radiance = grey(number(light, "radiance"));
    add_floor(c->scene);
    MUST(snell_scene_add_disk_light(bench.scene, &desc, NULL));
    check_direct(c, vector(get(get(c->scene, "ray"), "toward_eye")));
}

static void triangle_light(const reference_case *c) {
    static const uint32_t corners[3] = {0, 1, 2};
    rig_clear(&bench);
    const json_t *light = json_array_get(get(c->scene, "lights"), 0);
    snell_vec3 positions[3];
    for (size_t i = 0; i < 3; i++) positions[i] = vector(json_array_get(get(light, "verts"), i));
    add_floor(c->scene);
    place(&bench, add_mesh(&bench, positions, 3, corners, 3),
          add_glow(&bench, grey(number(light, "radiance"))));
    check_direct(c, vector(get(get(c->scene, "ray"), "toward_eye")));
}

static void soft_shadow(const reference_case *c) {
    rig_clear(&bench);
    add_floor(c->scene);
    add_rect(json_array_get(get(c->scene, "lights"), 0), v3(0, 0, 0));
    add_quad(&bench, v3(-100, -100, 1), v3(100, 0, 0), v3(0, 200, 0), add_lambert(&bench, grey(0)));
    check_direct(c, vector(get(get(c->scene, "ray"), "toward_eye")));
}

static void area_lights(void **state) {
    (void)state;
    assert_int_equal(reference_each("B.sphere_light", sphere_light), 7);
    assert_int_equal(reference_each("C.rect_light", rect_light), 7);
    assert_int_equal(reference_each("C.disk_light", disk_light), 4);
    assert_int_equal(reference_each("C.tri_light", triangle_light), 1);
    assert_int_equal(reference_each("C.soft_shadow", soft_shadow), 6);
}

/* ---- D: environments ---- */

/* An image of width x height in longitude and latitude; red, green and blue are the same. */
static snell_input image_of(uint32_t width, uint32_t height, const float *values, bool nearest) {
    snell_image_texture_desc desc = SNELL_INIT(image_texture_desc);
    snell_input input = {grey(1), {0, 0}};
    float *pixels = calloc((size_t)width * height * 4, sizeof *pixels);
    assert_non_null(pixels);
    for (size_t i = 0; i < (size_t)width * height * 4; i++)
        pixels[i] = i % 4 < 3 ? values[i / 4] : 1;
    desc.width = (int32_t)width;
    desc.height = (int32_t)height;
    desc.format = SNELL_IMAGE_TEXTURE_FORMAT_RGBA32F;
    desc.pixels = pixels;
    desc.pixels_count = (size_t)width * height * 4 * sizeof *pixels;
    desc.wrap_v = SNELL_IMAGE_TEXTURE_WRAP_V_CLAMP;
    if (nearest) desc.filter = SNELL_IMAGE_TEXTURE_FILTER_NEAREST;
    MUST(snell_scene_add_image_texture(bench.scene, &desc, &input.texture));
    free(pixels);
    return input;
}

/* L = max(0, cos) from the zenith, by rows whose edges are no further than 2e-5 from it. */
static snell_input cosine_sky(void) {
    enum { ROWS = 512 };
    float rows[ROWS];
    for (int i = 0; i < ROWS; i++) rows[i] = (float)fmax(0, cos(PI_ * (i + 0.5) / ROWS));
    return image_of(1, ROWS, rows, false);
}

static snell_input one_texel(const json_t *light) {
    float texels[64 * 32] = {0};
    const json_t *texel = get(light, "texel"), *size = get(light, "size");
    assert_true(reference_number(size, 0) == 64 && reference_number(size, 1) == 32);
    size_t x = (size_t)reference_number(texel, 0), y = (size_t)reference_number(texel, 1);
    texels[64 * y + x] = (float)number(light, "texel_radiance");
    return image_of(64, 32, texels, true);
}

static snell_input radiance_of(const json_t *light) {
    static const float halves[2] = {0, 4}; /* the right half of the map is where x > 0 */
    if (is(light, "type", "environment_latlong")) return one_texel(light);
    if (is(light, "radiance", "L(w)=max(0,w.z)")) return cosine_sky();
    if (is(light, "radiance", "4 where w.x>0 else 0")) return image_of(2, 1, halves, true);
    assert_true(json_is_number(get(light, "radiance")));
    return flat(grey(number(light, "radiance")));
}

static void add_surroundings(const json_t *scene) {
    snell_environment_light_desc desc = SNELL_INIT(environment_light_desc);
    desc.radiance = radiance_of(json_array_get(get(scene, "lights"), 0));
    MUST(snell_scene_add_environment_light(bench.scene, &desc, NULL));
}

static void furnace_sphere(const reference_case *c) {
    add_sphere(&bench, v3(0, 0, 0), 1, lambert_of(c->scene));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    double expected = expected_radiance(c);
    for (int i = 0; i < 4; i++) { /* the middle, near the edge, beside it */
        snell_vec3 at = v3(0.36 * i, 0, 0), eye = v3(0.36 * i, 0, 5);
        check_point(c, SNELL_PATH, eye, at, 1, expected);
        check_point(c, SNELL_COOK, eye, at, 1, expected);
    }
}

static void environment(const reference_case *c) {
    rig_clear(&bench);
    add_surroundings(c->scene);
    const json_t *wall = json_array_get(get(c->scene, "geometry"), 1);
    if (is(json_array_get(get(c->scene, "geometry"), 0), "type", "sphere")) {
        furnace_sphere(c);
        return;
    }
    if (wall)
        add_quad(&bench, v3(1, 0, 1e4), v3(0, 0, -2e4), v3(0, number(wall, "height"), 0),
                 add_lambert(&bench, grey(0)));
    add_plane(&bench, y_up(v3(0, 0, 0)), y_up(v3(0, 0, 1)), lambert_of(c->scene));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_vec3 hit = v3(0, 0, 0), eye = v3(-0.003, 0.01, 0.002);
    double expected = expected_radiance(c);
    check_point(c, SNELL_COOK, eye, hit, 1, expected);
    check_point(c, SNELL_PATH, eye, hit, 0, expected);
    check_point(c, SNELL_PATH, eye, hit, 1, expected);
}

static void environments(void **state) {
    (void)state;
    assert_int_equal(reference_each("D.environment", environment), 10);
}

/* ---- F: light that only a path finds, through a pane ---- */

static void pane(const reference_case *c) {
    rig_clear(&bench);
    const json_t *slab = json_array_get(get(c->scene, "geometry"), 0), *z = get(slab, "z");
    add_box(&bench, v3(-1e4, -1e4, reference_number(z, 0)), v3(1e4, 1e4, reference_number(z, 1)),
            add_glass(&bench, number(slab, "ior"), grey(0), 0));
    add_plane(&bench, v3(0, 0, 0), v3(0, 0, 1), lambert_of(c->scene));
    add_surroundings(c->scene);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    check_point(c, SNELL_PATH, v3(0.3, 0, 0.5), v3(0, 0, 0), 1000, expected_radiance(c));
}

static void panes(void **state) {
    (void)state;
    assert_int_equal(reference_each("F.pane", pane), 1);
}

/* ---- K: closed rooms ---- */

static snell_material_id add_shining(double reflectance, snell_input radiance) {
    snell_lambert_desc desc = SNELL_INIT(lambert_desc);
    snell_material_id id;
    desc.color = flat(grey(reflectance));
    desc.emission = radiance;
    desc.emit_two_sided = true;
    MUST(snell_scene_add_lambert(bench.scene, &desc, &id));
    return id;
}

/* The eye is anywhere in there. What a path meets last is still lit by sampling lights: there is one
 * bounce more than the depth. */
static void closed_sphere(const reference_case *c, double r) {
    rig_clear(&bench);
    add_sphere(&bench, v3(0.3, 0.1, 0.2), 1.1, add_shining(r, flat(grey(1))));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_vec3 eye = v3(0.1, 0.2, 0.3), at = v3(0.7, -0.5, 0.9);
    const json_t *by_bounces = get(c->expected, "by_bounces");
    for (uint32_t bounces = 1; bounces < json_array_size(by_bounces); bounces++)
        check_point(c, SNELL_PATH, eye, at, bounces - 1, reference_number(by_bounces, bounces));
    check_point(c, SNELL_PATH, eye, at, 1000, number(c->expected, "limit"));
    check_point(c, SNELL_COOK, eye, at, 0, 1 + r); /* cook: what shines, and its direct light */
}

/* Near a corner a sample of the other wall has no bound, so only both ways together have an error
 * that can be estimated: no path may end by its depth. */
static void closed_box(const reference_case *c, double r) {
    rig_clear(&bench);
    add_box(&bench, v3(-1, -2, -1), v3(1, 1, 3), add_shining(r, flat(grey(1))));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    check_point(c, SNELL_PATH, v3(0.1, 0.2, 0.3), v3(0.7, -0.5, 0.9), 1000,
                number(c->expected, "limit"));
}

static void closed(const reference_case *c) {
    double r = number(get(get(c->scene, "materials"), "m"), "R");
    closed_sphere(c, r);
    closed_box(c, r);
}

static void lit_from_its_center(const reference_case *c) {
    rig_clear(&bench);
    const json_t *light = json_array_get(get(c->scene, "lights"), 0);
    add_sphere(&bench, v3(0, 0, 0), number(json_array_get(get(c->scene, "geometry"), 0), "radius"),
               lambert_of(c->scene));
    add_point(&bench, vector(get(light, "position")), grey(number(light, "intensity")));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_vec3 eye = v3(0.1, 0.2, 0.3), at = v3(0.7, -0.5, 0.9);
    check_point(c, SNELL_COOK, eye, at, 0, number(c->expected, "direct_only"));
    check_point(c, SNELL_PATH, eye, at, 0, number(c->expected, "direct_only"));
    check_point(c, SNELL_PATH, eye, at, 1000, number(c->expected, "limit"));
}

/* The cap shines by a texture: v, the latitude, is 2/3 at the cap's edge, 60 degrees from the pole
 * (+y here). */
static void integrating_sphere(const reference_case *c) {
    static const float rows[3] = {4, 0, 0};
    rig_clear(&bench);
    snell_material_id m = add_shining(0.7, image_of(1, 3, rows, true));
    add_sphere(&bench, v3(0, 0, 0), 1, m);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    double reflected = expected_radiance(c);
    snell_vec3 eye = v3(0.1, 0.2, 0.3);
    check_point(c, SNELL_PATH, eye, v3(0.1, -0.5, 0.6), 1000, reflected);
    check_point(c, SNELL_PATH, eye, v3(0.9, 0.1, 0.3), 1000, reflected);
    check_point(c, SNELL_PATH, eye, v3(0.1, 0.9, 0.2), 1000, reflected + 4);
}

/* Infinite planes cannot be chosen by light sampling: paths meet them. */
static void parallel_planes(const reference_case *c) {
    rig_clear(&bench);
    for (size_t i = 0; i < 2; i++) {
        const json_t *plane = json_array_get(get(c->scene, "geometry"), i);
        snell_material_id m =
            add_shining(number(plane, "R"), flat(grey(number(plane, "emission"))));
        add_plane(&bench, v3(0, 0, number(plane, "z")), v3(0, 0, i ? -1 : 1), m);
    }
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_vec3 eye = v3(0, 0, 0.4);
    check_point(c, SNELL_PATH, eye, v3(0.3, 0, 0), 1000, reference_number(c->expected, 0));
    check_point(c, SNELL_PATH, eye, v3(0.3, 0, 1), 1000, reference_number(c->expected, 1));
}

static void glass_in_furnace(const reference_case *c) {
    rig_clear(&bench);
    add_box(&bench, v3(-2, -2, -2), v3(2, 2, 2), add_shining(0.5, flat(grey(1))));
    add_sphere(&bench, v3(0, 0, 0), 1, add_glass(&bench, 1.5, grey(0), 0));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    double expected = expected_radiance(c);
    snell_vec3 eye = v3(0.2, 0.3, 1.7);
    check_point(c, SNELL_PATH, eye, v3(0.2, 0.1, 0), 1000, expected);  /* through the glass */
    check_point(c, SNELL_PATH, eye, v3(0.98, 0.1, 0), 1000, expected); /* at its edge */
    check_point(c, SNELL_PATH, eye, v3(1.9, 0.1, 1), 1000, expected);  /* past it */
    check_point(c, SNELL_PATH, v3(0.1, 0.2, 0.3), v3(0.9, 0.1, 0), 1000, expected); /* inside */
}

/* Every record of the group goes to the test that its name begins with. */
static void closed_room(const reference_case *c) {
    static const struct {
        const char *name;
        void (*test)(const reference_case *c);
    } tests[] = {{"furnace_closed", closed},
                 {"furnace_point_light_sphere", lit_from_its_center},
                 {"integrating_sphere", integrating_sphere},
                 {"parallel_planes", parallel_planes},
                 {"glass_in_furnace", glass_in_furnace}};
    size_t i = 0;
    while (i < sizeof tests / sizeof tests[0] &&
           strncmp(c->name, tests[i].name, strlen(tests[i].name)) != 0)
        i++;
    assert_true(i < sizeof tests / sizeof tests[0]); /* a record that no test knows */
    tests[i].test(c);
}

static void closed_rooms(void **state) {
    (void)state;
    assert_int_equal(reference_each("K.furnace", closed_room), 10);
}

static void all_agree(void **state) {
    (void)state;
    family_judge(&records);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spots), cmocka_unit_test(area_lights),  cmocka_unit_test(environments),
        cmocka_unit_test(panes), cmocka_unit_test(closed_rooms), cmocka_unit_test(all_agree),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
