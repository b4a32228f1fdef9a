/* Every record of the groups of reference values that concern this version, through the public API:
 * a scene is built, a picture of one pixel is rendered along the record's ray, and its one colour is
 * compared. */
#include "materials/bsdf.h"
#include "reference_scene.h"

static rig bench;

static int start(void **state) {
    (void)state;
    bench = rig_make(1, SNELL_ISA_AUTO);
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

/* ---- colours ---- */

/* Seen from 4 m off the point where the record's ray hits. */
static rgb seen_at_hit(const json_t *ray, snell_integrator integrator) {
    snell_vec3 hit = color_of(get(ray, "hit"));
    const json_t *eye = get(ray, "toward_eye");
    snell_vec3 from = v3((double)hit.x + 4 * reference_number(eye, 0),
                         (double)hit.y + 4 * reference_number(eye, 1),
                         (double)hit.z + 4 * reference_number(eye, 2));
    return trace_ray(&bench, integrator, from, hit, 0);
}

static void check_color(const reference_case *c, rgb got) {
    for (size_t i = 0; i < 3; i++) {
        bool one = !json_is_array(c->expected);
        double expected = one ? json_number_value(c->expected) : reference_number(c->expected, i);
        assert_true(reference_agrees(c, got.c[i], expected));
    }
}

/* ---- A: direct light ---- */

static void direct_light(const reference_case *c) {
    rig_clear(&bench);
    build(&bench, c->scene);
    check_color(c, seen_at_hit(get(c->scene, "ray"), SNELL_APPEL));
    check_color(c, seen_at_hit(get(c->scene, "ray"), SNELL_WHITTED));
}

static void point_lights(void **state) {
    (void)state;
    assert_int_equal(reference_each("A.point_lambert", direct_light), 8);
}

static void directional_lights(void **state) {
    (void)state;
    assert_int_equal(reference_each("A.directional", direct_light), 3);
}

/* ---- E: interfaces ---- */

/* The half-space z < 0 is glass under a glowing ceiling, or the eye is in it above a glowing floor:
 * one ray and its reflection give R of a surface that is otherwise black. */
static void check_rendered_row(const reference_case *c, double degrees, bool inside, double ior,
                               double expected) {
    double angle = degrees * PI_ / 180, side = inside ? -1 : 1;
    snell_vec3 eye = v3(-4 * sin(angle), 0, 4 * side * cos(angle));
    rgb got = trace_ray(&bench, SNELL_WHITTED, eye, v3(0, 0, 0), 1);
    double cosine = fabs((double)eye.z) / hypot((double)eye.x, (double)eye.z);
    double same = inside ? fresnel_dielectric(cosine, ior, 1) : fresnel_dielectric(cosine, 1, ior);
    assert_true(reference_agrees(c, got.c[0], same));
    /* Near grazing and critical angles the record's own angle, rounded to float, matters. */
    if (ior == 1.5 && degrees != 41.8) assert_true(reference_agrees(c, got.c[0], expected));
}

static void build_interface(double ior, bool inside) {
    rig_clear(&bench);
    add_plane(&bench, v3(0, 0, 0), v3(0, 0, 1), add_glass(&bench, ior, grey(0), 0));
    add_plane(&bench, v3(0, 0, inside ? -8 : 8), v3(0, 0, inside ? 1 : -1),
              add_glow(&bench, grey(1)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
}

static void fresnel_rows(const reference_case *c, bool inside) {
    double ior = number(c->scene, "n_inside"), stored = (double)(float)ior;
    size_t index;
    json_t *row;
    build_interface(ior, inside);
    json_array_foreach(get(c->expected, inside ? "from_inside" : "from_outside"), index, row) {
        double degrees = reference_number(row, 0), cosine = cos(degrees * PI_ / 180);
        double r = inside ? fresnel_dielectric(cosine, ior, 1) : fresnel_dielectric(cosine, 1, ior);
        assert_true(reference_agrees(c, r, reference_number(row, 3)));
        assert_true(reference_agrees(c, 1 - r, reference_number(row, 4)));
        dvec3 wo = {-sin(degrees * PI_ / 180), 0, cosine}, wi;
        bool through = refract_direction(wo, (dvec3){0, 0, 1}, inside ? ior : 1 / ior, &wi);
        assert_int_equal(through, !json_is_null(json_array_get(row, 5)));
        if (through)
            assert_true(
                reference_agrees(c, atan2(wi.x, -wi.z) * 180 / PI_, reference_number(row, 5)));
        if (degrees < 89) check_rendered_row(c, degrees, inside, stored, reference_number(row, 3));
    }
}

static void fresnel_table(const reference_case *c) {
    fresnel_rows(c, false);
    fresnel_rows(c, true);
}

static void fresnel_tables(void **state) {
    (void)state;
    assert_int_equal(reference_each("E.fresnel", fresnel_table), 6);
}

/* Below z = 0 is n_to, above it n_from. Where both are glass, the upper one reaches down to z = 0
 * and has priority over the lower one, which begins a little higher: nested dielectrics with no gap.
 * Sky: 1 + d.x once the scene is turned so that x is up; a black ceiling takes what is reflected, so
 * the picture is (1 - R) (1 + t.x). Along y: x of the record is y here. */
static rgb seen_through(double n_from, double n_to, const json_t *incident) {
    rig_clear(&bench);
    MUST(snell_scene_set_background_gradient(bench.scene, grey(0), grey(2)));
    add_plane(&bench, v3(0, 0, 9), v3(0, 0, -1), add_lambert(&bench, grey(0)));
    if (n_from > 1)
        add_plane(&bench, v3(0, 0, 0), v3(0, 0, -1), add_glass(&bench, n_from, grey(0), 2));
    if (n_to > 1)
        add_plane(&bench, v3(0, 0, n_from > 1 ? 0.01 : 0), v3(0, 0, 1),
                  add_glass(&bench, n_to, grey(0), 1));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    double x = reference_number(incident, 0), z = reference_number(incident, 2);
    return trace_ray(&bench, SNELL_WHITTED, v3(0, -4 * x, -4 * z), v3(0, 0, 0), 1);
}

static void check_direction(const reference_case *c, dvec3 got, const json_t *expected) {
    assert_true(reference_agrees(c, got.x, reference_number(expected, 0)));
    assert_true(reference_agrees(c, got.y, reference_number(expected, 1)));
    assert_true(reference_agrees(c, got.z, reference_number(expected, 2)));
}

static void snell_law(const reference_case *c) {
    const json_t *incident = get(c->scene, "incident"), *refracted = get(c->expected, "refracted");
    double n_from = number(c->scene, "n_from"), n_to = number(c->scene, "n_to");
    dvec3 n = {0, 0, 1}, t;
    dvec3 wo = {-reference_number(incident, 0), -reference_number(incident, 1),
                -reference_number(incident, 2)};
    double r = number(c->expected, "R");
    check_direction(c, reflect_direction(wo, n), get(c->expected, "reflected"));
    bool through = refract_direction(wo, n, n_from / n_to, &t);
    assert_int_equal(through, !json_is_null(refracted));
    if (through) check_direction(c, t, refracted);
    assert_true(reference_agrees(c, fresnel_dielectric(wo.z, n_from, n_to), r));
    double expected = through ? (1 - r) * (1 + reference_number(refracted, 0)) : 0;
    assert_true(reference_agrees(c, seen_through(n_from, n_to, incident).c[0], expected));
}

static void snells_law(void **state) {
    (void)state;
    assert_int_equal(reference_each("E.snell", snell_law), 6);
}

static void conductor(const reference_case *c) {
    double eta = number(c->scene, "eta"), k = number(c->scene, "k");
    size_t index;
    json_t *row;
    json_array_foreach(c->expected, index, row) {
        double cosine = cos(reference_number(row, 0) * PI_ / 180), r = reference_number(row, 3);
        assert_true(reference_agrees(c, fresnel_conductor(cosine, eta, k), r));
        if (k == 0) assert_true(reference_agrees(c, fresnel_dielectric(cosine, 1, eta), r));
    }
}

static void conductors(void **state) {
    (void)state;
    assert_int_equal(reference_each("E.fresnel_conductor", conductor), 3);
}

/* ---- F: trees of rays ---- */

static void check_by_depth(const reference_case *c, snell_vec3 from, snell_vec3 at) {
    size_t depth;
    json_t *expected;
    json_array_foreach(get(c->expected, "by_N"), depth, expected) {
        rgb got = trace_ray(&bench, SNELL_WHITTED, from, at, (uint32_t)depth);
        assert_true(reference_agrees(c, got.c[0], json_number_value(expected)));
    }
    assert_true(depth >= 11);
    const json_t *limit = get(c->expected, "limit");
    if (limit && !json_is_null(limit)) {
        rgb got = trace_ray(&bench, SNELL_WHITTED, from, at, 300);
        assert_true(reference_agrees(c, got.c[0], json_number_value(limit)));
    }
}

static void sphere_tree(const reference_case *c) {
    rig_clear(&bench);
    build_sphere_tree(&bench, c->scene);
    const json_t *ray = get(c->scene, "ray");
    check_by_depth(c, color_of(get(ray, "o")), along_record(ray, 1));
}

static void sphere_trees(void **state) {
    (void)state;
    assert_int_equal(reference_each("F.sphere_tree", sphere_tree), 5);
}

/* One crossing: what Beer's law takes is the ratio of the picture with and without absorption. */
static void beer(const reference_case *c) {
    const json_t *slab = json_array_get(get(c->scene, "geometry"), 0);
    const json_t *absorption = get(c->scene, "sigma_a");
    double degrees = number(c->scene, "incidence_deg");
    rig_clear(&bench);
    build_slab(&bench, slab, color_of(absorption), 0, 1);
    rgb with = trace_ray(&bench, SNELL_WHITTED, slab_eye(slab, degrees), slab_hit(slab), 2);
    rig_clear(&bench);
    build_slab(&bench, slab, grey(0), 0, 1);
    rgb without = trace_ray(&bench, SNELL_WHITTED, slab_eye(slab, degrees), slab_hit(slab), 2);
    for (size_t i = 0; i < 3; i++) {
        double t = with.c[i] / without.c[i];
        assert_true(reference_agrees(c, t, reference_number(get(c->expected, "T"), i)));
    }
    double path = -log(with.c[0] / without.c[0]) / reference_number(absorption, 0);
    assert_true(reference_agrees(c, path, number(c->expected, "path")));
}

static void beers_law(void **state) {
    (void)state;
    assert_int_equal(reference_each("F.beer", beer), 4);
}

static void slab_tree(const reference_case *c) {
    const json_t *slab = json_array_get(get(c->scene, "geometry"), 0);
    rig_clear(&bench);
    build_slab(&bench, slab, grey(number(slab, "sigma_a")), number(c->scene, "front_environment"),
               number(c->scene, "back_environment"));
    check_by_depth(c, slab_eye(slab, number(c->scene, "incidence_deg")), slab_hit(slab));
}

static void slab_trees(void **state) {
    (void)state;
    assert_int_equal(reference_each("F.slab_tree", slab_tree), 4);
}

/* The record is a path tracer's: its floor is lit by light that the pane sends back to it. Here the
 * pane's T(theta) is measured ray by ray, looking up through it at a sky of 1 from a black floor;
 * then T_d = integral of T 2 mu dmu (Simpson's rule) and the record's own formula
 * E = pi T_d / (1 - rho (1 - T_d)) give the floor's radiance rho E / pi. */
static void pane(const reference_case *c) {
    const json_t *slab = json_array_get(get(c->scene, "geometry"), 0), *z = get(slab, "z");
    double rho = number(get(get(c->scene, "materials"), "m"), "R"), sum = 0;
    rig_clear(&bench);
    MUST(snell_scene_set_background(bench.scene, grey(1), 1));
    add_box(&bench, v3(-1e6, -1e6, reference_number(z, 0)), v3(1e6, 1e6, reference_number(z, 1)),
            add_glass(&bench, number(slab, "ior"), grey(0), 0));
    add_plane(&bench, v3(0, 0, 0), v3(0, 0, 1), add_lambert(&bench, grey(0)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    enum { STEPS = 200 };
    for (int i = 1; i <= STEPS; i++) { /* at mu = 0 nothing passes */
        double mu = (double)i / STEPS, weight = i == STEPS ? 1 : i % 2 ? 4 : 2;
        rgb t = trace_ray(&bench, SNELL_WHITTED, v3(0, 0, 0.5),
                          v3(64 * sqrt(1 - mu * mu), 0, 0.5 + 64 * mu), 1000);
        double r = fresnel_dielectric(mu, 1, number(slab, "ior"));
        ASSERT_CLOSE(t.c[0], (1 - r) / (1 + r), 1e-4, 1e-6);
        sum += weight * t.c[0] * 2 * mu;
    }
    double t_d = sum / (3 * STEPS);
    ASSERT_CLOSE(t_d, 0.844555940, 1e-4, 0);
    double floor_radiance = rho * t_d / (1 - rho * (1 - t_d));
    assert_true(reference_agrees(c, floor_radiance, json_number_value(c->expected)));
}

static void panes(void **state) {
    (void)state;
    assert_int_equal(reference_each("F.pane", pane), 1);
}

/* ---- G: mirrors ---- */

static void mirror(const reference_case *c) {
    rig_clear(&bench);
    build(&bench, c->scene);
    const json_t *ray = get(c->scene, "ray");
    snell_vec3 o = color_of(get(ray, "o")), at = along_record(ray, 1024);
    if (json_is_object(c->expected))
        check_by_depth(c, o, at);
    else
        check_color(c, trace_ray(&bench, SNELL_WHITTED, o, at, 1));
}

static void mirrors(void **state) {
    (void)state;
    assert_int_equal(reference_each("G.mirrors", mirror), 4);
}

/* ---- H: the modified Blinn-Phong ---- */

static void build_blinn_phong(const json_t *scene) {
    snell_blinn_phong_desc desc = SNELL_INIT(blinn_phong_desc);
    snell_material_id id;
    rig_clear(&bench);
    desc.color = flat(grey(number(scene, "R")));
    desc.specular = flat(grey(number(scene, "ks")));
    desc.exponent = (float)number(scene, "p");
    MUST(snell_scene_add_blinn_phong(bench.scene, &desc, &id));
    add_plane(&bench, v3(0, 0, 0), v3(0, 0, 1), id);
}

static snell_vec3 along(const json_t *direction, double distance) {
    return v3(distance * reference_number(direction, 0), distance * reference_number(direction, 1),
              distance * reference_number(direction, 2));
}

/* The eye looks along the normal. One directional light for each step of Simpson's rule over theta,
 * as strong as the step's weight 2 pi sin(theta): one ray sums the integral of f cos dw. */
static void blinn_phong_albedo(const reference_case *c) {
    enum { STEPS = 1200 };
    build_blinn_phong(c->scene);
    for (int i = 1; i < STEPS; i++) {
        double theta = PI_ / 2 * i / STEPS, weight = (i % 2 ? 4.0 : 2.0) * PI_ / 2 / (3 * STEPS);
        add_sun(&bench, v3(-sin(theta), 0, -cos(theta)), grey(weight * 2 * PI_ * sin(theta)));
    }
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    check_color(c, trace_ray(&bench, SNELL_WHITTED, v3(0, 0, 4), v3(0, 0, 0), 0));
}

static void blinn_phong(const reference_case *c) {
    if (get(c->scene, "view")) {
        blinn_phong_albedo(c);
        return;
    }
    build_blinn_phong(c->scene);
    double distance = number(c->scene, "light_distance");
    add_point(&bench, along(get(c->scene, "to_light"), distance),
              grey(number(c->scene, "intensity")));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_vec3 eye = along(get(c->scene, "to_eye"), 4);
    check_color(c, trace_ray(&bench, SNELL_APPEL, eye, v3(0, 0, 0), 0));
    check_color(c, trace_ray(&bench, SNELL_WHITTED, eye, v3(0, 0, 0), 0));
}

static void highlights(void **state) {
    (void)state;
    assert_int_equal(reference_each("H.blinn_phong", blinn_phong), 10);
}

/* ---- L: which pixels, which hits, which shadows ---- */

/* Every shape glows with 1 and is half there: a pixel that two of them cover would be 0.75. */
static void pixel_set(const reference_case *c) {
    const json_t *s = c->scene, *rows = get(c->expected, "rows");
    snell_lambert_desc glow = SNELL_INIT(lambert_desc);
    snell_material_id m;
    rig_clear(&bench);
    glow.color = flat(grey(0));
    glow.emission = flat(grey(1));
    glow.emit_two_sided = true;
    glow.alpha = flat(grey(0.5));
    MUST(snell_scene_add_lambert(bench.scene, &glow, &m));
    size_t index;
    json_t *shape;
    json_array_foreach(get(s, "geometry"), index, shape) assert_true(add_shape(&bench, shape, m));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    uint32_t width = (uint32_t)number(s, "width"), height = (uint32_t)number(s, "height"),
             count = 0;
    snell_render_desc desc = picture(SNELL_APPEL, width, height, 0);
    snell_view view = look(v3(0, 0, 0), v3(0, 0, -1));
    bool is_sphere = is(json_array_get(get(s, "geometry"), 0), "type", "sphere");
    view.fov = (float)(2 * atan(number(s, "tan_half_vfov")));
    desc.view = &view;
    MUST(snell_render(bench.scene, &desc, bench.film));
    for (uint32_t y = 0; y < height; y++) {
        char name[16];
        snprintf(name, sizeof name, "%u", y);
        const json_t *row = get(rows, name);
        for (uint32_t x = 0; x < width; x++) {
            bool inside = row && x >= reference_number(row, 0) && x <= reference_number(row, 1);
            /* A sphere is met twice: on the way in and on the way out. */
            double expected = !inside ? 0 : is_sphere ? 0.75 : 0.5;
            if (pixel_at(&bench, x, y).c[0] != expected) {
                fprintf(stderr, "%s: pixel %u, %u is %g\n", c->name, x, y,
                        pixel_at(&bench, x, y).c[0]);
                fail();
            }
            count += inside;
        }
    }
    assert_int_equal(count, (uint32_t)number(c->expected, "count"));
}

static void pixel_sets(void **state) {
    (void)state;
    assert_int_equal(reference_each("L.pixel_sets", pixel_set), 6);
}

static int intersections_tested;

static void intersection(const reference_case *c) {
    const json_t *shape = json_array_get(get(c->scene, "geometry"), 0), *ray = get(c->scene, "ray");
    rig_clear(&bench);
    if (!add_shape(&bench, shape, (snell_material_id){0, 0})) {
        printf("%s: not in this version (%s)\n", c->name, json_string_value(get(shape, "type")));
        return;
    }
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    bool triangle = is(shape, "type", "triangle");
    snell_ray r = {.origin = color_of(get(ray, "o")),
                   .direction = color_of(get(ray, "d")),
                   .t_max = INFINITY,
                   .mask = ~0u};
    size_t roots = triangle ? 1 : json_array_size(c->expected);
    snell_hit hit;
    for (size_t i = 0; i < roots; i++) {
        MUST(snell_scene_intersect(bench.scene, &r, &hit, 1));
        assert_true(reference_agrees(c, (double)hit.t, reference_number(c->expected, i)));
        if (i + 1 < roots)
            r.t_min =
                (float)((reference_number(c->expected, i) + reference_number(c->expected, i + 1)) /
                        2);
    }
    if (triangle) {
        assert_true(reference_agrees(c, (double)hit.u, reference_number(c->expected, 1)));
        assert_true(reference_agrees(c, (double)hit.v, reference_number(c->expected, 2)));
    } else {
        r.t_min = hit.t * 1.001f; /* beyond the last root there is nothing */
        MUST(snell_scene_intersect(bench.scene, &r, &hit, 1));
        assert_true(isinf(hit.t));
    }
    intersections_tested++;
}

static void intersections(void **state) {
    (void)state;
    assert_int_equal(reference_each("L.intersections", intersection), 8);
    assert_int_equal(intersections_tested, 5);
}

/* The whole grid in one picture, seen from half the light's height; every pixel has its closed form,
 * so a falsely shadowed one cannot hide. */
static void acne_plane(const reference_case *c, double scale, double moved) {
    enum { GRID = 100 };
    rig_clear(&bench);
    const json_t *light = json_array_get(get(c->scene, "lights"), 0);
    double height = reference_number(get(light, "position"), 2) * scale, false_shadows = 0;
    double r = number(get(get(c->scene, "materials"), "m"), "R");
    double intensity = number(light, "intensity") * scale * scale;
    add_plane(&bench, v3(moved, moved, 0), v3(0, 0, 1), add_lambert(&bench, grey(r)));
    add_point(&bench, v3(moved, moved, height), grey(intensity));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_render_desc desc = picture(SNELL_WHITTED, GRID, GRID, 0);
    snell_view view = look(v3(moved, moved, height / 2), v3(moved, moved, 0));
    view.fov = (float)(2 * atan(2)); /* the height is half the grid's half width */
    desc.view = &view;
    MUST(snell_render(bench.scene, &desc, bench.film));
    for (uint32_t y = 0; y < GRID; y++)
        for (uint32_t x = 0; x < GRID; x++) {
            double across = (x + 0.5 - GRID / 2.0) / (GRID / 2.0) * height,
                   up = (y + 0.5 - GRID / 2.0) / (GRID / 2.0) * height;
            double squared = across * across + up * up + height * height;
            double expected = r / PI_ * intensity * height / (squared * sqrt(squared));
            double got = pixel_at(&bench, x, y).c[0];
            false_shadows += got == 0;
            /* Of a scene that is moved, the float origin is 1e4 + height away from 0. */
            ASSERT_CLOSE(got, expected, 1e-5 + 1e-6 * moved / height, 0);
        }
    assert_true(reference_agrees(c, false_shadows, json_number_value(c->expected)));
}

/* The mesh's vertices, and random and aimed rays from inside: none may leave. */
static void watertight(const reference_case *c) {
    enum { SEGMENTS = 200, COLUMNS = SEGMENTS + 1, RAYS = 50000 };
    const json_t *mesh = json_array_get(get(c->scene, "geometry"), 0);
    snell_vec3 center = color_of(get(mesh, "center"));
    size_t vertices = (size_t)COLUMNS * COLUMNS, triangles = 0;
    snell_vec3 *positions = calloc(vertices, sizeof *positions);
    uint32_t *indices = calloc((size_t)SEGMENTS * SEGMENTS * 6, sizeof *indices);
    snell_ray *rays = calloc(RAYS, sizeof *rays);
    snell_hit *hits = calloc(RAYS, sizeof *hits);
    assert_true(positions && indices && rays && hits);
    for (uint32_t i = 0; i < vertices; i++) {
        double theta = PI_ * (i / COLUMNS) / SEGMENTS,
               phi = 2 * PI_ * (i % COLUMNS % SEGMENTS) / SEGMENTS; /* the seam closes exactly */
        double ring = i / COLUMNS % SEGMENTS ? sin(theta) : 0;      /* and so do the poles */
        double radius = number(mesh, "radius");
        positions[i] =
            v3((double)center.x + radius * ring * cos(phi), (double)center.y + radius * cos(theta),
               (double)center.z + radius * ring * sin(phi));
    }
    for (uint32_t row = 0; row < SEGMENTS; row++)
        for (uint32_t column = 0; column < SEGMENTS; column++) {
            uint32_t a = row * COLUMNS + column, b = a + COLUMNS;
            const uint32_t corners[6] = {a, a + 1, b, a + 1, b + 1, b};
            memcpy(indices + 3 * triangles, corners, sizeof corners);
            triangles += 2;
        }
    rig_clear(&bench);
    place(&bench, add_mesh(&bench, positions, vertices, indices, 3 * triangles),
          (snell_material_id){0, 0});
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    uint64_t state = 7;
    int misses = 0, batches = full_tests() ? 40 : 4;
    for (int batch = 0; batch < batches; batch++) {
        for (size_t i = 0; i < RAYS; i++) {
            snell_vec3 o = v3((double)center.x + uniform(&state) - 0.5,
                              (double)center.y + uniform(&state) - 0.5,
                              (double)center.z + uniform(&state) - 0.5);
            snell_vec3 d = v3(uniform(&state) - 0.5, uniform(&state) - 0.5, uniform(&state) - 0.5);
            const uint32_t *corner = indices + 3 * (size_t)(uniform(&state) * (double)triangles);
            snell_vec3 a = positions[corner[0]], b = positions[corner[1]];
            if (batch % 2 && i % 2) b = a; /* aimed at vertices, and at the middle of edges */
            if (batch % 2)
                d = v3(((double)a.x + (double)b.x) / 2 - (double)o.x,
                       ((double)a.y + (double)b.y) / 2 - (double)o.y,
                       ((double)a.z + (double)b.z) / 2 - (double)o.z);
            rays[i] = (snell_ray){.origin = o, .direction = d, .t_max = INFINITY, .mask = ~0u};
        }
        MUST(snell_scene_intersect(bench.scene, rays, hits, RAYS));
        for (size_t i = 0; i < RAYS; i++) misses += isinf(hits[i].t);
    }
    free(positions);
    free(indices);
    free(rays);
    free(hits);
    assert_true(reference_agrees(c, misses, json_number_value(c->expected)));
}

static void precision(const reference_case *c) {
    if (strcmp(c->name, "watertight_sphere_mesh") == 0) {
        watertight(c);
        return;
    }
    assert_string_equal(c->name, "shadow_acne_plane");
    acne_plane(c, 1e-3, 0);
    acne_plane(c, 1, 0);
    acne_plane(c, 1e4, 0);
    acne_plane(c, 1, 1e4);
}

static void precise(void **state) {
    (void)state;
    assert_int_equal(reference_each("L.precision", precision), 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(point_lights, fresh),
        cmocka_unit_test_setup(directional_lights, fresh),
        cmocka_unit_test_setup(fresnel_tables, fresh),
        cmocka_unit_test_setup(snells_law, fresh),
        cmocka_unit_test_setup(conductors, fresh),
        cmocka_unit_test_setup(sphere_trees, fresh),
        cmocka_unit_test_setup(beers_law, fresh),
        cmocka_unit_test_setup(slab_trees, fresh),
        cmocka_unit_test_setup(panes, fresh),
        cmocka_unit_test_setup(mirrors, fresh),
        cmocka_unit_test_setup(highlights, fresh),
        cmocka_unit_test_setup(pixel_sets, fresh),
        cmocka_unit_test_setup(intersections, fresh),
        cmocka_unit_test_setup(precise, fresh),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
