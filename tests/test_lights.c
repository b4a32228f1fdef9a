/* Every light of the registry by itself: its power, its directions against their density, its middle.
 * And the tree that chooses among many. */
#include <string.h>

#include "cpu_time.h"
#include "lights/sphere_map.h"
#include "lights/tree.h"
#include "policy_test.h"

static rig bench;

static int start(void **state) {
    (void)state;
    bench = rig_make(1, SNELL_ISA_AUTO);
    return 0;
}

static int stop(void **state) {
    (void)state;
    rig_free(&bench);
    return 0;
}

static const dvec3 nobody = {1e3, 1e3, 1e3}; /* an eye */

/* ---- one of every registered light, with what is known of it ---- */

/* Adds it to the empty scene. power: what it sends out, W; the infinitely far are asked about a disk
 * of radius 1. false: no light of that name is known here. */
static bool add_known(const char *name, double *power) {
    snell_scene *s = bench.scene;
    if (strcmp(name, "point") == 0) {
        add_point(&bench, v3(0.2, 0.1, -0.3), grey(3));
        *power = 4 * PI_ * 3;
    } else if (strcmp(name, "spot") == 0) {
        snell_spot_light_desc desc = SNELL_INIT(spot_light_desc);
        desc.position = v3(0.2, 0.1, -0.3);
        desc.at = v3(1, 2, 3);
        desc.intensity = grey(3);
        desc.cone = 1.2f;
        desc.blend = 0.7f;
        MUST(snell_scene_add_spot_light(s, &desc, NULL));
        *power =
            2 * PI_ * 3 * (1 - (cos(0.5) + cos(1.2)) / 2); /* the smoothstep's mean is a half */
    } else if (strcmp(name, "directional") == 0) {
        snell_directional_light_desc desc = SNELL_INIT(directional_light_desc);
        desc.direction = v3(0.3, -1, 0.5);
        desc.irradiance = grey(2);
        desc.angle = 0.9f;
        MUST(snell_scene_add_directional_light(s, &desc, NULL));
        *power = 2 * PI_;
    } else if (strcmp(name, "headlight") == 0) {
        snell_headlight_light_desc desc = SNELL_INIT(headlight_light_desc);
        desc.intensity = grey(3);
        MUST(snell_scene_add_headlight_light(s, &desc, NULL));
        *power = 4 * PI_ * 3;
    } else if (strcmp(name, "quad") == 0) {
        snell_quad_light_desc desc = SNELL_INIT(quad_light_desc);
        desc.center = v3(0, 1, 0);
        desc.at = v3(0.5, 0, 0.1);
        desc.width = 1.5f;
        desc.height = 0.7f;
        MUST(snell_scene_add_quad_light(s, &desc, NULL));
        *power = PI_ * 1.5 * 0.7;
    } else if (strcmp(name, "disk") == 0) {
        snell_disk_light_desc desc = SNELL_INIT(disk_light_desc);
        desc.center = v3(0, 1, 0);
        desc.normal = v3(0.5, -1, 0.1);
        desc.radius = 0.8f;
        MUST(snell_scene_add_disk_light(s, &desc, NULL));
        *power = PI_ * PI_ * 0.64;
    } else if (strcmp(name, "sphere") == 0) {
        snell_sphere_light_desc desc = SNELL_INIT(sphere_light_desc);
        desc.center = v3(0, 1, 0);
        desc.radius = 0.8f;
        MUST(snell_scene_add_sphere_light(s, &desc, NULL));
        *power = PI_ * 4 * PI_ * 0.64;
    } else if (strcmp(name, "environment") == 0) {
        snell_environment_light_desc desc = SNELL_INIT(environment_light_desc);
        desc.radiance = flat(grey(2));
        MUST(snell_scene_add_environment_light(s, &desc, NULL));
        *power = 2 * 4 * PI_ * PI_;
    } else if (strcmp(name, "sky") == 0) {
        snell_sky_light_desc desc = SNELL_INIT(sky_light_desc);
        MUST(snell_scene_add_sky_light(s, &desc, NULL));
        *power = NAN; /* only the integral of its own radiance */
    } else {
        return false;
    }
    return true;
}

static bool is_surface(const light_type *type) { return type->shape != NULL; }

static const scene *commit_known(const light_type *type, double *power) {
    rig_clear(&bench);
    if (!add_known(type->info.name, power)) {
        fprintf(stderr, "'%s' is not tested: add it to add_known in tests/test_lights.c\n",
                type->info.name);
        fail();
    }
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    return bench.scene->frozen;
}

/* ---- power ---- */

static dvec3 on_sphere(uint64_t *random) {
    double y = 1 - 2 * uniform(random), turn = 2 * PI_ * uniform(random), ring = sqrt(1 - y * y);
    return (dvec3){ring * cos(turn), y, ring * sin(turn)};
}

/* The mean irradiance on the inside of a large sphere about what is at a place, times its area, by
 * the light's samples. */
static double power_received(const scene *s, dvec3 eye) {
    enum { POINTS = 200000 };
    const double radius = 50;
    uint64_t random = 5;
    double sum = 0;
    for (int i = 0; i < POINTS; i++) {
        dvec3 n = on_sphere(&random), p = dvec3_scale(n, radius);
        light_sample found;
        sample2 u = {uniform(&random), uniform(&random)};
        if (!scene_sample_light(s, 0, &(shade_point){.p = p}, eye, 0, u, &found)) continue;
        double cosine = -dvec3_dot(dvec3_normalize(found.to_light), n);
        sum += found.light.y * cosine / (found.pdf > 0 ? found.pdf : 1);
    }
    return sum / POINTS * 4 * PI_ * radius * radius;
}

/* Radiance over all directions: through a disk of radius 1 that faces each. */
static double power_from_afar(const light *l) {
    enum { DIRECTIONS = 400000 };
    uint64_t random = 6;
    double sum = 0;
    for (int i = 0; i < DIRECTIONS; i++) sum += l->type->radiance(l, on_sphere(&random)).y;
    return sum / DIRECTIONS * 4 * PI_ * PI_;
}

static void power_is_what_arrives(void **state) {
    (void)state;
    for (uint32_t i = 0; i < light_type_count; i++) {
        const light_type *type = light_types[i];
        double expected, received;
        const scene *s = commit_known(type, &expected);
        const light *l = &s->lights[0];
        if (type->radiance)
            received = power_from_afar(l);
        else
            received = power_received(s, (dvec3){0.1, 0, 0});
        if (!is_surface(type)) {
            double said = type->power(l, 1).y;
            if (isnan(expected)) expected = said;
            ASSERT_CLOSE(said, expected, strcmp(type->info.name, "directional") ? 1e-6 : 0.06, 0);
        }
        /* A disk in the sky sends its irradiance straight down, and a little more in all. */
        ASSERT_CLOSE(received, expected, strcmp(type->info.name, "directional") ? 0.01 : 0.06, 0);
    }
}

/* `power` instead of radiance or intensity gives that power. */
static void power_can_be_given(void **state) {
    (void)state;
    int tested = 0;
    for (uint32_t i = 0; i < light_type_count; i++) {
        const light_type *type = light_types[i];
        if (type_find_field(&type->info, "power") == NULL) continue;
        double unused;
        rig_clear(&bench);
        assert_true(add_known(type->info.name, &unused));
        object *o = &bench.scene->description->objects[CATEGORY_LIGHT].items[0];
        snell_param power = {.name = "power", .kind = SNELL_PARAM_FLOAT, .value.f = 7};
        MUST(desc_set(&type->info, o->desc, &power));
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        ASSERT_CLOSE(power_received(bench.scene->frozen, nobody), 7, 0.01, 0);
        tested++;
    }
    assert_true(tested >= 5);
}

/* ---- directions against densities ---- */

enum { COLUMNS = 24, ROWS = 12, CELLS = COLUMNS * ROWS };

static dvec3 cell_direction(double u, double v) { /* equal areas */
    double y = 1 - 2 * v, ring = sqrt(fmax(0, 1 - y * y));
    return (dvec3){ring * cos(2 * PI_ * u), y, ring * sin(2 * PI_ * u)};
}

static size_t cell_of(dvec3 d) {
    double turn = atan2(d.z, d.x) / (2 * PI_), height = (1 - d.y) / 2;
    size_t column = (size_t)((turn < 0 ? turn + 1 : turn) * COLUMNS), row = (size_t)(height * ROWS);
    return (row < ROWS ? row : ROWS - 1) * COLUMNS + (column < COLUMNS ? column : COLUMNS - 1);
}

/* What the density of light 0 is in a direction, as a hit or a miss would be asked. */
static double density(const scene *s, dvec3 p, dvec3 d) {
    if (s->light_count) return s->lights[0].type->pdf(&s->lights[0], d);
    ray r = ray_make(vec3_from(p), vec3_from(d), 0, INFINITY);
    hit h;
    accel_trace(s->accel, bench.context->isa, &r, &h, 1, NULL);
    if (h.instance == NO_ID) return 0;
    shade_point on;
    scene_shade_point(s, &r, &h, &on);
    return scene_hit_pdf(s, p, (dvec3){0, 0, 0}, &on, 0);
}

typedef struct fit {
    double found[CELLS + 1], expected[CELLS + 1], drawn, mass;
} fit;

/* Draws directions and counts them per cell; each sample's own density must be the one that a hit is
 * told, and its radiance what a hit sees. */
static void draw_directions(const scene *s, dvec3 p, int count, fit *f) {
    uint64_t random = 9;
    for (int i = 0; i < count; i++) {
        light_sample found;
        sample2 u = {uniform(&random), uniform(&random)};
        if (!scene_sample_light(s, 0, &(shade_point){.p = p}, nobody, 0, u, &found)) continue;
        dvec3 d = dvec3_normalize(found.to_light);
        f->found[1 + cell_of(d)]++;
        f->drawn++;
        assert_true(found.pdf > 0 && isfinite(found.pdf));
        if (i % 16) continue;
        double pdf = density(s, p, d);
        if (pdf == 0) continue; /* past an edge by rounding; too many would spoil the fit */
        ASSERT_CLOSE(found.pdf, pdf, 1e-3, 0);
    }
}

/* The integral of the density over each cell, by midpoints. Cells that a light's edge cuts, and
 * those beside it, go into the first one together: midpoints know them badly, but their sum well. */
static void integrate_density(const scene *s, dvec3 p, int side, fit *f) {
    for (size_t c = 0; c < CELLS; c++) {
        double sum = 0, dark = 0;
        for (int k = 0; k < side * side; k++) {
            double u = ((double)(c % COLUMNS) + (k % side + 0.5) / side) / COLUMNS,
                   v = ((double)(c / COLUMNS) + (k / side + 0.5) / side) / ROWS;
            double here = density(s, p, cell_direction(u, v));
            sum += here;
            dark += here == 0;
        }
        double share = sum / (side * side) * 4 * PI_ / CELLS;
        f->mass += share;
        if (dark == 0) {
            f->expected[c + 1] = share;
            continue;
        }
        f->expected[0] += share;
        f->found[0] += f->found[c + 1];
        f->found[c + 1] = 0;
    }
}

/* reach: the share of all samples that give light. From where all of a light is seen, all do. */
static void check_directions(const char *name, dvec3 p, double reach, double level) {
    enum { COUNT = 40000 };
    static fit f;
    const scene *s = bench.scene->frozen;
    memset(&f, 0, sizeof f);
    draw_directions(s, p, COUNT, &f);
    integrate_density(s, p, full_tests() ? 64 : 24, &f);
    if (fabs(f.mass - reach) > 0.02 || fabs(f.drawn / COUNT - reach) > 0.02) {
        fprintf(stderr, "%s: the density's integral is %g, %g of the samples shine, not %g\n", name,
                f.mass, f.drawn / COUNT, reach);
        fail();
    }
    for (size_t c = 0; c <= CELLS; c++) f.expected[c] *= f.drawn / f.mass;
    double chance = chi_square_test(f.found, f.expected, CELLS + 1);
    printf("%s: %.3g\n", name, chance);
    if (chance > level) return;
    fprintf(stderr, "%s: directions do not fit their density: %g\n", name, chance);
    fail();
}

static void check_light(const char *name, dvec3 p, double reach) {
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    check_directions(name, p, reach, sidak(0.01, 32));
}

static snell_input make_map(uint32_t width, uint32_t height, bool noise, bool nearest) {
    snell_image_texture_desc desc = SNELL_INIT(image_texture_desc);
    snell_input input = {grey(1), {0, 0}};
    float *pixels = calloc((size_t)width * height * 4, sizeof *pixels);
    assert_non_null(pixels);
    uint64_t random = 3;
    for (size_t i = 0; i < (size_t)width * height * 4; i++) {
        double x = uniform(&random);
        pixels[i] = (float)(!noise ? 1 : x < 0.3 ? 0 : 10 * x * x * x);
    }
    desc.width = (int32_t)width;
    desc.height = (int32_t)height;
    desc.format = SNELL_IMAGE_TEXTURE_FORMAT_RGBA32F;
    desc.pixels = pixels;
    desc.pixels_count = (size_t)width * height * 4 * sizeof *pixels;
    if (nearest) desc.filter = SNELL_IMAGE_TEXTURE_FILTER_NEAREST;
    MUST(snell_scene_add_image_texture(bench.scene, &desc, &input.texture));
    free(pixels);
    return input;
}

static void directions_fit_their_density(void **state) {
    (void)state;
    double unused;
    const dvec3 near = {0.1, 0.05, 0.2};
    rig_clear(&bench);
    add_known("directional", &unused);
    check_light("directional", near, 1);
    rig_clear(&bench);
    add_known("environment", &unused);
    check_light("environment", near, 1);
    rig_clear(&bench);
    add_known("sky", &unused);
    check_light("sky", near, 1);
    static const uint32_t sizes[][2] = {{1, 1}, {2, 1}, {7, 5}, {96, 48}, {24, 12}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        char name[64];
        snell_environment_light_desc desc = SNELL_INIT(environment_light_desc);
        rig_clear(&bench);
        desc.radiance = make_map(sizes[i][0], sizes[i][1], true, i % 2);
        desc.rotate = (float)i;
        MUST(snell_scene_add_environment_light(bench.scene, &desc, NULL));
        snprintf(name, sizeof name, "environment of %u x %u", sizes[i][0], sizes[i][1]);
        check_light(name, near, 1);
    }
}

static void surfaces_fit_their_density(void **state) {
    (void)state;
    double unused;
    rig_clear(&bench);
    add_known("sphere", &unused);
    check_light("sphere", (dvec3){0.5, -0.5, 0.3}, 1);
    check_light("sphere, very near", (dvec3){0, 0.1999, 0}, 1);
    rig_clear(&bench);
    add_known("quad", &unused);
    check_light("quad", (dvec3){0.5, -0.5, 0.3}, 1);
    check_light("quad, very near", (dvec3){0.02, 0.98, 0.1}, 1);
    rig_clear(&bench);
    add_known("disk", &unused);
    check_light("disk", (dvec3){0.5, -0.5, 0.3}, 1);
    check_light("disk, near", (dvec3){0.05, 0.9, 0.1}, 1);
    rig_clear(&bench); /* inside, where both sides shine */
    add_sphere(&bench, v3(0, 1, 0), 0.8, add_glow(&bench, grey(1)));
    check_light("sphere from inside", (dvec3){0.1, 1.4, 0.2}, 1);
    rig_clear(&bench);
    snell_transform squashed = {{{0.5f, -0.6f, 0, 0}, {0.3f, 0.5f, 0.2f, 1}, {0, 0, 0.9f, 0.1f}}};
    snell_quad_desc quad = SNELL_INIT(quad_desc);
    snell_shape_id id;
    quad.corner = v3(-1, 0, -1);
    quad.u = v3(2, 0, 0.5);
    quad.v = v3(0, 0.2, 2);
    MUST(snell_scene_add_quad(bench.scene, &quad, &id));
    MUST(snell_scene_add_instance(bench.scene, id, add_glow(&bench, grey(1)), &squashed, NULL));
    check_light("squashed parallelogram", (dvec3){0.2, -0.4, 0.3}, 1);
}

/* (.5, .5) is the middle of every light. */
static void the_middle_is_the_middle(void **state) {
    (void)state;
    for (uint32_t i = 0; i < light_type_count; i++) {
        double unused;
        const scene *s = commit_known(light_types[i], &unused);
        dvec3 p = {0.3, -0.6, 0.2}, middle;
        light_sample found;
        if (!is_surface(light_types[i])) continue;
        shade_point from = {.p = p};
        assert_true(scene_sample_light_center(s, 0, 0, &from, nobody, 0, &found));
        middle = dvec3_sub((dvec3){0, 1, 0}, p); /* where all of them are */
        double cosine = dvec3_dot(dvec3_normalize(found.to_light), dvec3_normalize(middle));
        ASSERT_CLOSE(cosine, 1, 0.01, 0);
    }
    double unused;
    rig_clear(&bench);
    add_known("directional", &unused);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    light_sample found;
    sample2 half = {0.5, 0.5};
    shade_point from = {.p = nobody};
    assert_true(scene_sample_light(bench.scene->frozen, 0, &from, nobody, 0, half, &found));
    ASSERT_CLOSE(dvec3_dot(found.to_light, dvec3_normalize((dvec3){-0.3, 1, -0.5})), 1, 1e-6, 0);
}

/* ---- the tree ---- */

enum { LIGHTS_MAX = 1000 };

static light_bounds random_light(uint64_t *random) {
    double size = uniform(random) < 0.3 ? 0 : 0.5 * uniform(random);
    dvec3 at = {10 * uniform(random) - 5, 10 * uniform(random) - 5, 10 * uniform(random) - 5};
    light_bounds b = {.low = at,
                      .high = dvec3_add(at, (dvec3){size, size * uniform(random), size / 3}),
                      .axis = on_sphere(random),
                      .power = pow(10, 4 * uniform(random) - 2)};
    double sort = uniform(random);
    b.cos_spread = sort < 0.4 ? 1 : sort < 0.6 ? -1 : cos(PI_ * uniform(random));
    b.cos_emission = sort < 0.2 ? -1 : 0;
    b.two_sided = sort > 0.8;
    return b;
}

/* Does light leave within the bounds towards p: is some direction in the cone, from some point of
 * the box, above some normal within the spread? By brute force, from points of the box. */
static double brings(const light_bounds *b, dvec3 p, dvec3 n, uint64_t *random) {
    double best = 0;
    for (int i = 0; i < 20; i++) {
        dvec3 t = {uniform(random), uniform(random), uniform(random)};
        dvec3 from = dvec3_add(b->low, dvec3_mul(t, dvec3_sub(b->high, b->low)));
        dvec3 d = dvec3_sub(p, from);
        double squared = dvec3_dot(d, d);
        d = dvec3_normalize(d);
        if (dvec3_dot(n, n) > 0 && dvec3_dot(d, n) >= 0) continue;
        double cosine = dvec3_dot(d, b->axis);
        if (b->two_sided) cosine = fabs(cosine);
        double beyond = acos(fmin(fmax(cosine, -1), 1)) - acos(b->cos_spread);
        if (beyond < acos(b->cos_emission)) best = fmax(best, b->power / squared);
    }
    return best;
}

static void check_tree(uint32_t count, uint64_t *random) {
    static light_bounds lights[LIGHTS_MAX];
    light_tree *tree;
    for (uint32_t i = 0; i < count; i++) lights[i] = random_light(random);
    if (count > 3) lights[3].power = 0;
    if (count > 5) lights[5] = lights[4]; /* in one place */
    MUST(light_tree_build(lights, count, &tree));
    for (int point = 0; point < (count > 100 ? 30 : 300); point++) {
        dvec3 p = dvec3_scale(on_sphere(random), 9 * uniform(random));
        dvec3 n = point % 3 ? on_sphere(random) : (dvec3){0, 0, 0};
        double sum = 0;
        for (uint32_t i = 0; i < count; i++) {
            double chance = light_tree_chance(tree, p, n, i);
            assert_true(chance >= 0 && chance <= 1);
            if (brings(&lights[i], p, n, random) > 0) assert_true(chance > 0);
            sum += chance;
        }
        if (sum > 0 || count > 1) ASSERT_CLOSE(sum, 1, 1e-9, 0);
        for (int i = 0; i < 200; i++) {
            uint32_t index;
            double chance, u = i == 0 ? 0 : i == 1 ? 0x1.fffffffffffffp-1 : uniform(random);
            if (!light_tree_sample(tree, p, n, u, &index, &chance)) continue;
            assert_true(index < count && lights[index].power > 0 && chance > 0);
            ASSERT_CLOSE(chance, light_tree_chance(tree, p, n, index), 1e-9, 0);
        }
    }
    light_tree_destroy(tree);
}

static void chances_of_the_tree(void **state) {
    (void)state;
    uint64_t random = 31;
    for (int i = 0; i < 50; i++) check_tree(1, &random);
    for (int i = 0; i < 50; i++) check_tree(2, &random);
    for (int i = 0; i < 20; i++) check_tree(10, &random);
    for (int i = 0; i < 2; i++) check_tree(LIGHTS_MAX, &random);
    light_tree *none;
    uint32_t index;
    double chance;
    MUST(light_tree_build(NULL, 0, &none));
    assert_false(light_tree_sample(none, nobody, (dvec3){0, 1, 0}, 0.5, &index, &chance));
    light_tree_destroy(none);
}

/* Chances are frequencies: by chi-square over the lights. */
static void the_tree_draws_by_its_chances(void **state) {
    (void)state;
    enum { COUNT = 100, DRAWS = 100000 };
    light_bounds lights[COUNT];
    uint64_t random = 7;
    light_tree *tree;
    for (int i = 0; i < COUNT; i++) lights[i] = random_light(&random);
    MUST(light_tree_build(lights, COUNT, &tree));
    for (int point = 0; point < 10; point++) {
        dvec3 p = dvec3_scale(on_sphere(&random), 6), n = on_sphere(&random);
        double found[COUNT] = {0}, expected[COUNT], missing = DRAWS;
        for (uint32_t i = 0; i < COUNT; i++) expected[i] = DRAWS * light_tree_chance(tree, p, n, i);
        for (int i = 0; i < DRAWS; i++) {
            uint32_t index;
            double chance;
            if (!light_tree_sample(tree, p, n, uniform(&random), &index, &chance)) continue;
            found[index]++;
            missing--;
        }
        assert_true(missing == 0);
        assert_true(chi_square_test(found, expected, COUNT) > sidak(0.01, 10));
    }
    light_tree_destroy(tree);
}

/* ---- noise: one light of a thousand, by the tree and by mere chance ---- */

static void sample_any_light(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    const scene *s = wave_scene(w);
    uint32_t count = s->light_count + s->emitter_count;
    uint32_t source = (uint32_t)(wave_draw(w, r, SAMPLE_LIGHT_CHOICE).x * count);
    light_sample found;
    if (!scene_sample_source(s, source, p, wave_eye(w), 0, wave_draw(w, r, SAMPLE_LIGHT), &found))
        return;
    double weight = found.pdf > 0 ? count / found.pdf : count;
    emit_light(w, r, p, b, LOBES_LIT, &found, weight, true);
}

static const integrator any_light = {
    .name = "any", .one_branch = true, .hit = sample_any_light, .miss = emit_background};

static void a_thousand_lights(void **state) {
    (void)state;
    rig_clear(&bench);
    uint64_t random = 13;
    for (int i = 0; i < 500; i++) {
        double x = 20 * uniform(&random) - 10, z = 20 * uniform(&random) - 10,
               y = 0.3 + uniform(&random);
        add_point(&bench, v3(x, y, z), grey(0.1 + uniform(&random)));
        snell_quad_desc quad = SNELL_INIT(quad_desc);
        snell_shape_id id;
        quad.corner = v3(z, y, x);
        quad.u = v3(0.1, 0, 0);
        quad.v = v3(0, 0.05, 0.1);
        MUST(snell_scene_add_quad(bench.scene, &quad, &id));
        place(&bench, id, add_glow(&bench, grey(50 * uniform(&random))));
    }
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_lambert(&bench, grey(0.5)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_vec3 from = v3(0.05, 0.1, 0.02), at = v3(0, 0, 0);
    estimate tree = estimate_light(&bench, SNELL_PATH, from, at, 0, 64);
    estimate chance = estimate_policy(&bench, &any_light, from, at, 0, 1024);
    double ratio = 16 * moments_variance(&chance.channel[0]) / moments_variance(&tree.channel[0]);
    printf("1000 lights: the tree has 1/%.0f of the variance of any light alike\n", ratio);
    assert_true(fabs(z_score_pair(&tree.channel[0], &chance.channel[0])) < 4);
    assert_true(ratio > 3);
}

/* ---- noise: a path's samples of lights, and without them ---- */

static void only_met(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    emit_radiance(w, r, b->emission);
    bsdf_direction next;
    double survive = r->depth < 4 ? 1 : fmin((double)vec3_largest(r->weight), 1);
    sample2 luck = wave_draw(w, r, SAMPLE_LOBE);
    if (!(luck.y < survive)) return;
    if (!bsdf_sample(b, p->ns, p->wo, luck.x, wave_draw(w, r, SAMPLE_DIRECTION), &next)) return;
    emit_ray(w, r, p, next.wi, dvec3_scale(next.weight, 1 / survive), &r->media, 0, RAY_REFLECTED);
}

static const integrator met_by_chance = {
    .name = "met", .one_branch = true, .hit = only_met, .miss = emit_background};

static void only_met_always(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    emit_radiance(w, r, b->emission);
    bsdf_direction next;
    sample2 luck = wave_draw(w, r, SAMPLE_LOBE);
    if (!bsdf_sample(b, p->ns, p->wo, luck.x, wave_draw(w, r, SAMPLE_DIRECTION), &next)) return;
    emit_ray(w, r, p, next.wi, next.weight, &r->media, 0, RAY_REFLECTED);
}

static const integrator without_roulette = {
    .name = "met", .one_branch = true, .hit = only_met_always, .miss = emit_background};

/* A room of 2 m with a lamp of half a metre under its ceiling. */
static void a_room(void **state) {
    (void)state;
    rig_clear(&bench);
    snell_material_id white = add_lambert(&bench, grey(0.75));
    add_box(&bench, v3(-1, -1, -1), v3(1, 1, 1), white);
    add_box(&bench, v3(-0.6, -1, -0.6), v3(-0.1, 0.2, -0.1), white);
    add_sphere(&bench, v3(0.4, -0.6, 0.2), 0.4, white);
    snell_quad_light_desc lamp = SNELL_INIT(quad_light_desc);
    lamp.center = v3(0, 0.98, 0);
    lamp.at = v3(0, 0, 0);
    lamp.width = 0.5f;
    lamp.radiance = grey(10);
    MUST(snell_scene_add_quad_light(bench.scene, &lamp, NULL));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_vec3 from = v3(0, 0, 0.9), at = v3(0.1, -1, 0.6);
    estimate path = estimate_light(&bench, SNELL_PATH, from, at, 30, 64);
    estimate met = estimate_policy(&bench, &met_by_chance, from, at, 31, 256);
    estimate all = estimate_policy(&bench, &without_roulette, from, at, 31, 128);
    double ratio = 4 * moments_variance(&met.channel[0]) / moments_variance(&path.channel[0]);
    printf(
        "a room: %.5f +- %.5f; a path has 1/%.0f of the variance of one that samples no lights\n",
        path.channel[0].mean, moments_error(&path.channel[0]), ratio);
    family f = {0};
    family_check_same(&f, "path and met", &path.channel[0], &met.channel[0]);
    family_check_same(&f, "path and without roulette", &path.channel[0], &all.channel[0]);
    family_judge(&f);
    assert_true(ratio > 10);
}

/* ---- surveys of the surroundings ---- */

static dvec3 patchy(const void *user, dvec3 d) {
    (void)user;
    return (dvec3){fabs(d.x) + 3 * (d.y > 0.9), d.y * d.y, d.z > 0 ? d.z : 0.1};
}

/* The rows are looked at by several threads; sums are made in one order. */
static void surveys_do_not_depend_on_threads(void **state) {
    (void)state;
    const sphere_grid grids[] = {{64, 32, 2, true}, {700, 900, 3, false}, {1, 1, 4, true}};
    for (int g = 0; g < 3; g++) {
        sphere_map maps[2];
        for (int k = 0; k < 2; k++) {
            thread_pool *pool;
            MUST(thread_pool_create(k ? 3 : 1, &pool));
            MUST(sphere_map_build(&grids[g], pool, patchy, NULL, &maps[k]));
            thread_pool_destroy(pool);
        }
        size_t w = grids[g].width, h = grids[g].height;
        assert_memory_equal(maps[0].rows, maps[1].rows, (h + 1) * sizeof(double));
        assert_memory_equal(maps[0].cells, maps[1].cells, h * (w + 1) * sizeof(double));
        assert_memory_equal(maps[0].harmonics, maps[1].harmonics, sizeof maps[0].harmonics);
        assert_true(maps[0].brightest == maps[1].brightest && maps[0].mean.x == maps[1].mean.x);
        assert_true(g == 2 || maps[0].brightest > 3);
        sphere_map_free(&maps[0]);
        sphere_map_free(&maps[1]);
    }
}

/* The irradiance that `whitted` lights with, of pictures of few pixels that are white everywhere: pi. */
static void a_white_picture_lights_evenly(void **state) {
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {4, 2}, {3, 9}, {40, 20}};
    static const dvec3 normals[] = {
        {0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {0.6, 0, -0.8}, {0.6, 0.8, 0}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        snell_environment_light_desc desc = SNELL_INIT(environment_light_desc);
        rig_clear(&bench);
        desc.radiance = make_map(sizes[i][0], sizes[i][1], false, false);
        MUST(snell_scene_add_environment_light(bench.scene, &desc, NULL));
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        const light *l = &bench.scene->frozen->lights[0];
        for (size_t k = 0; k < sizeof normals / sizeof normals[0]; k++)
            ASSERT_CLOSE(l->type->irradiance(l, normals[k]).y, PI_, 0.005, 0);
    }
}

/* ---- copies ---- */

static double shining_commit(int copies, bool grouped) {
    rig_clear(&bench);
    snell_superellipsoid_desc desc = SNELL_INIT(superellipsoid_desc);
    snell_material_id glow = add_glow(&bench, grey(1));
    snell_shape_id shape, group;
    snell_instance_id part;
    MUST(snell_scene_add_superellipsoid(bench.scene, &desc, &shape));
    if (grouped) {
        MUST(snell_scene_add_instance(bench.scene, shape, glow, NULL, &part));
        MUST(snell_scene_add_group(bench.scene, &part, 1, NULL, &group));
    }
    for (int i = 0; i < copies; i++) {
        const snell_transform at = {{{1, 0, 0, (float)(3 * i)}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
        MUST(snell_scene_add_instance(bench.scene, grouped ? group : shape,
                                      grouped ? (snell_material_id){0, 0} : glow, &at, NULL));
    }
    double before = cpu_seconds();
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    double took = cpu_seconds() - before;
    assert_int_equal(bench.scene->frozen->emitter_count, copies);
    for (int i = 0; i < copies; i++)
        assert_true(bench.scene->frozen->emitters[i].area == bench.scene->frozen->emitters[0].area);
    assert_true(bench.scene->frozen->emitters[0].area > 1);
    return took;
}

/* The area of such a shape is a sum over many points: once, not for each copy. */
static void copies_share_their_area(void **state) {
    (void)state;
    double one = shining_commit(1, false), many = shining_commit(400, false),
           grouped = shining_commit(400, true);
    printf("1 copy %.3f s, 400 copies %.3f s, in groups %.3f s\n", one, many, grouped);
    assert_true(many < 20 * one + 0.02 && grouped < 20 * one + 0.02);
}

/* Every light is work, also the shapes that shine: a wave looks up in between. */
static void many_shining_shapes_do_not_keep_waiting(void **state) {
    (void)state;
    enum { BALLS = 2000, SAMPLES = 4 };
    rig_clear(&bench);
    snell_material_id glow = add_glow(&bench, grey(1)), white = add_lambert(&bench, grey(0.5));
    for (int i = 0; i < BALLS; i++) add_sphere(&bench, v3(i % 50, 9, i / 50), 0.1, glow);
    add_quad(&bench, v3(-9, 0, -9), v3(90, 0, 0), v3(0, 0, 90), white);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    looks = 0;
    estimate_policy(&bench, integrators[SNELL_COOK - 1], v3(20, 5, 20), v3(20, 0, 20.1), 1,
                    SAMPLES);
    double lights = (double)BALLS * ESTIMATE_SIDE * ESTIMATE_SIDE * SAMPLES;
    printf("%.0f lights were looked at, with %d looks up\n", lights, looks);
    assert_true(looks > lights / 50000);
}

static int calls_left;
static bool count_down(void *user, const snell_progress *progress) {
    (void)user;
    assert_true(progress->fraction >= 0 && progress->fraction <= 1);
    return --calls_left >= 0;
}

/* What a scene without shining shapes may call is not enough here. */
static void areas_can_be_cancelled(void **state) {
    (void)state;
    enum { PLENTY = 1000 };
    for (int shining = 0; shining < 2; shining++) {
        int used = PLENTY - calls_left;
        rig_clear(&bench);
        snell_quadric_desc desc = SNELL_INIT(quadric_desc);
        desc.square = v3(1, 1, 1);
        desc.constant = -0.5f;
        snell_shape_id shape;
        MUST(snell_scene_add_quadric(bench.scene, &desc, &shape));
        snell_material_id paint =
            shining ? add_glow(&bench, grey(1)) : add_lambert(&bench, grey(1));
        MUST(snell_scene_add_instance(bench.scene, shape, paint, NULL, NULL));
        if (shining) {
            calls_left = used;
            assert_int_equal(snell_scene_commit(bench.scene, count_down, NULL), SNELL_CANCELLED);
        }
        calls_left = PLENTY;
        MUST(snell_scene_commit(bench.scene, count_down, NULL));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(copies_share_their_area),
        cmocka_unit_test(areas_can_be_cancelled),
        cmocka_unit_test(many_shining_shapes_do_not_keep_waiting),
        cmocka_unit_test(power_is_what_arrives),
        cmocka_unit_test(power_can_be_given),
        cmocka_unit_test(directions_fit_their_density),
        cmocka_unit_test(surfaces_fit_their_density),
        cmocka_unit_test(the_middle_is_the_middle),
        cmocka_unit_test(chances_of_the_tree),
        cmocka_unit_test(the_tree_draws_by_its_chances),
        cmocka_unit_test(a_thousand_lights),
        cmocka_unit_test(a_room),
        cmocka_unit_test(surveys_do_not_depend_on_threads),
        cmocka_unit_test(a_white_picture_lights_evenly),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
