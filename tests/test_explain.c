/* snell_explain: what it tells adds up to the pixel that snell_render makes, bit for bit; the factors
 * of each contribution are those that it came from; and no surface sends on more than it gets. */
#include <glob.h>
#include <unistd.h>

#include "reference_scene.h"

static rig bench;

static int start(void **state) {
    (void)state;
    bench = rig_make(0, SNELL_ISA_AUTO);
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

/* ---- an explanation, and what must be true of every one ---- */

typedef struct told {
    snell_explanation *whole;
    const snell_explained_ray *rays;
    const snell_explained_light *lights;
    const snell_explained_sample *samples;
    size_t ray_count, light_count;
    uint32_t sample_count, channels;
    const float *pixel;
    snell_integrator integrator;
    uint32_t max_depth;
    bool by_chance; /* path */
} told;

static told ask(const snell_render_desc *desc, uint32_t x, uint32_t y) {
    snell_explain_desc at = SNELL_INIT(explain_desc);
    told t = {.integrator = desc->integrator,
              .max_depth = desc->max_depth,
              .by_chance = desc->integrator == SNELL_PATH};
    at.x = x;
    at.y = y;
    MUST(snell_explain(bench.scene, desc, &at, &t.whole));
    t.rays = snell_explanation_rays(t.whole, &t.ray_count);
    t.lights = snell_explanation_lights(t.whole, &t.light_count);
    t.samples = snell_explanation_samples(t.whole, &t.sample_count);
    t.pixel = snell_explanation_pixel(t.whole, &t.channels);
    return t;
}

/* value * 2^80, towards 0: what the film adds. */
__extension__ typedef __int128 fixed;
static fixed to_fixed(double value) {
    int exponent;
    double mantissa = frexp(value, &exponent);
    fixed whole = (fixed)ldexp(mantissa, 53);
    int shift = exponent - 53 + 80;
    if (shift < -63) return 0;
    return shift >= 0 ? whole * ((fixed)1 << shift) : whole / ((fixed)1 << -shift);
}

static void check_total(const told *t, const float *pixel, uint32_t channels) {
    assert_int_equal(t->channels, channels);
    for (uint32_t c = 0; c < channels; c++) {
        fixed sum = 0;
        for (size_t i = 0; i < t->light_count; i++) sum += to_fixed(t->lights[i].contribution[c]);
        float mean = (float)((double)sum * 0x1p-80 / t->sample_count);
        assert_memory_equal(&mean, &pixel[c], sizeof mean);
        assert_memory_equal(&t->pixel[c], &pixel[c], sizeof mean);
    }
}

/* Trees stand one after the other, and each ray's sum is that of its own lights and its children. */
static void check_order(const told *t) {
    uint32_t rays = 0, lights = 0;
    for (uint32_t i = 0; i < t->sample_count; i++) {
        assert_int_equal(t->samples[i].first_ray, rays);
        rays += t->samples[i].ray_count;
    }
    assert_int_equal(rays, t->ray_count);
    for (uint32_t i = 0; i < t->ray_count; i++) {
        const snell_explained_ray *r = &t->rays[i];
        double sum[4] = {0, 0, 0, 0};
        assert_int_equal(r->first_light, lights);
        lights += r->light_count;
        for (uint32_t k = 0; k < r->light_count; k++) {
            assert_int_equal(t->lights[r->first_light + k].ray, i);
            for (int c = 0; c < 4; c++) sum[c] += t->lights[r->first_light + k].contribution[c];
        }
        for (uint32_t k = 1; k < r->ray_count; k += r[k].ray_count) {
            assert_int_equal(r[k].parent, i);
            assert_int_equal(r[k].sample, r->sample);
            assert_int_equal(r[k].depth, r->depth + (r[k].kind != SNELL_RAY_CONTINUED));
            for (int c = 0; c < 4; c++) sum[c] += r[k].radiance[c];
        }
        for (int c = 0; c < 4; c++) ASSERT_CLOSE(r->radiance[c], sum[c], 1e-12, 1e-20);
        if (r->parent == UINT32_MAX) assert_int_equal(t->samples[r->sample].first_ray, i);
    }
    assert_int_equal(lights, t->light_count);
}

static double component(snell_vec3 v, int c) { return (double)(c == 0 ? v.x : c == 1 ? v.y : v.z); }

/* Three roundings to float between two rays. */
static bool near(double a, double b) { return fabs(a - b) <= 4e-7 * fabs(b) + 1e-38; }

/* A ray's throughput is its parent's times what lies between; what walks on past a surface that is
 * there in part goes on from before that part was taken. */
static void check_throughput(const told *t, const snell_explained_ray *r) {
    double part = r->end == SNELL_RAY_HIT && !t->by_chance ? r->alpha : 1;
    for (int c = 0; c < 3; c++) {
        double before = 1, share = 1;
        if (r->parent != UINT32_MAX) {
            const snell_explained_ray *parent = &t->rays[r->parent];
            before = component(parent->throughput, c);
            if (r->kind == SNELL_RAY_CONTINUED && parent->alpha > 0 && !t->by_chance)
                share = 1 / parent->alpha;
        }
        double own = r->weight[c] * r->transmittance[c] * part;
        double got = component(r->throughput, c);
        if (near(got, before * own) || near(got, before * share * own)) continue;
        fprintf(stderr, "throughput %.9g, not %.9g * %.9g\n", got, before, own);
        fail();
    }
}

static void check_contribution(const told *t, const snell_explained_light *l) {
    for (int c = 0; c < 3 && l->source != SNELL_SOURCE_COVERAGE; c++) {
        double expected = component(t->rays[l->ray].throughput, c) * l->bsdf[c] * l->incoming[c] *
                          l->cosine * l->weight * l->visibility[c];
        ASSERT_CLOSE(l->contribution[c], expected, 1e-6, 1e-30);
        if (l->visibility[c] == 0) assert_true(l->contribution[c] == 0);
    }
}

typedef struct seen {
    size_t rays, lights, blocked, conserving, splits, lit, chosen, passed, hidden, named;
} seen;

static bool made_of(const snell_explained_ray *r, const char *material) {
    return strcmp(r->material.type, material) == 0;
}

/* From the fourth bounce on a path lives with the probability of its throughput, and makes up for it. */
static double survival(const told *t, const snell_explained_ray *r) {
    double largest = 0;
    for (int c = 0; c < 3; c++) largest = fmax(largest, component(r->throughput, c));
    return t->by_chance && r->depth >= 4 ? fmin(largest, 1) : 1;
}

/* What a hit's rays carry together is at most all. Of rays that were drawn by chance one may carry
 * more than the mean of them: those are left out where the material has several parts. */
static void check_energy(const told *t, const snell_explained_ray *r, seen *s) {
    bool one_part = made_of(r, "dielectric") || made_of(r, "mirror") || made_of(r, "lambert");
    double sum[3] = {0, 0, 0}, reflected = 0, refracted = 0;
    bool drawn = false, split = false;
    for (uint32_t k = 1; k < r->ray_count; k += r[k].ray_count) {
        if (r[k].kind == SNELL_RAY_CONTINUED) continue;
        /* Of what was not traced, cook does not tell whether it was drawn. */
        drawn |= r[k].pdf > 0 || (t->integrator == SNELL_COOK && r[k].end > SNELL_RAY_LEFT);
        split |= r[k].kind == SNELL_RAY_REFRACTED;
        for (int c = 0; c < 3; c++) sum[c] += r[k].weight[c] * survival(t, r);
        *(r[k].kind == SNELL_RAY_REFRACTED ? &refracted : &reflected) = r[k].weight[0];
    }
    if (r->end != SNELL_RAY_HIT || r->ray_count == 1) return;
    if ((drawn || t->by_chance) && !one_part) return;
    for (int c = 0; c < 3; c++)
        if (!(sum[c] <= 1 + 1e-6)) {
            fprintf(stderr, "%s (%s, line %u) sends on %.9g\n", r->shape.type, r->material.type,
                    r->material.line, sum[c]);
            for (uint32_t k = 1; k < r->ray_count; k += r[k].ray_count)
                fprintf(stderr, "  %d weight %.9g pdf %g depth %u\n", r[k].kind, r[k].weight[c],
                        r[k].pdf, r[k].depth);
            fail();
        }
    s->conserving++;
    if (t->by_chance || !made_of(r, "dielectric") || r->fresnel[0] == 0) return;
    /* By Snell and Fresnel: F goes back, at most 1 - F goes on. */
    assert_true(reflected <= r->fresnel[0] + 1e-12);
    assert_true(refracted <= 1 - r->fresnel[0] + 1e-12);
    if (r->fresnel[0] == 1) assert_true(!split);
    s->splits += split;
}

/* What was drawn with a density counts one over it; in path, that includes the choice of the light, and only a part
 * counts: by the power heuristic of what Lambert's directions are drawn with, cos / pi. */
static void check_density(const told *t, const snell_explained_light *l, seen *s) {
    const snell_explained_ray *r = &t->rays[l->ray];
    assert_true(l->choice > 0 && l->choice <= 1);
    if (!t->by_chance) assert_true(l->choice == 1);
    double part = l->weight * (l->pdf > 0 ? l->pdf : l->choice), expected = 1;
    if (l->pdf > 0 && t->by_chance && r->depth < t->max_depth) {
        assert_true(part > 0 && part <= 1 + 1e-12);
        if (!made_of(r, "lambert")) return;
        double ratio = l->cosine / 3.14159265358979 * survival(t, r) / l->pdf;
        expected = 1 / (1 + ratio * ratio);
    }
    if (l->contribution[0] == 0)
        return; /* of what is behind the surface the cosine is not that of a direction */
    if (l->pdf > 0 || t->by_chance) ASSERT_CLOSE(part, expected, 1e-6, 0);
    s->chosen += l->choice < 1;
}

/* What is sent on to lights is bounded too: R of Lambert's R / pi, together with what is traced, is at
 * most 1. */
static void check_lit(const told *t, const snell_explained_light *l, seen *s) {
    const snell_explained_ray *r = &t->rays[l->ray];
    if (l->source != SNELL_SOURCE_LIGHT) return;
    check_density(t, l, s);
    bool part = made_of(r, "partial_mirror") && !t->by_chance;
    if (!part && !made_of(r, "lambert")) return;
    for (int c = 0; c < 3; c++) {
        double sum = l->bsdf[c] * 3.14159265358979;
        for (uint32_t k = 1; k < r->ray_count && part; k += r[k].ray_count)
            if (r[k].kind != SNELL_RAY_CONTINUED) sum += r[k].weight[c];
        if (sum <= 1 + 1e-6) continue;
        fprintf(stderr, "%s (%s, line %u) sends on %.9g, of which %.9g is traced\n", r->shape.type,
                r->material.type, r->material.line, sum, sum - l->bsdf[c] * 3.14159265358979);
        fail();
    }
    s->lit++;
}

static void check(const told *t, seen *s) {
    check_order(t);
    for (size_t i = 0; i < t->ray_count; i++) {
        check_throughput(t, &t->rays[i]);
        check_energy(t, &t->rays[i], s);
        s->passed += t->rays[i].end == SNELL_RAY_PASSED;
        s->hidden += t->rays[i].end == SNELL_RAY_HIT && t->rays[i].hit.instance.index1 == 0;
        s->named += strcmp(t->rays[i].shape.name, "ball") == 0;
    }
    for (size_t i = 0; i < t->light_count; i++) {
        check_contribution(t, &t->lights[i]);
        check_lit(t, &t->lights[i], s);
        s->blocked += t->lights[i].blocker.type[0] != '\0';
    }
    s->rays += t->ray_count;
    s->lights += t->light_count;
}

/* ---- every showcase scene, by every integrator ---- */

static void explain_pixels(const snell_render_desc *desc, seen *s) {
    uint32_t width, height, channels;
    uint64_t random = desc->integrator;
    int count = full_tests() ? 1000 : 36;
    MUST(snell_render(bench.scene, desc, bench.film));
    const float *pixels = snell_film_pixels(bench.film, &width, &height, &channels);
    for (int i = 0; i < count; i++) {
        uint32_t x = (uint32_t)(uniform(&random) * width),
                 y = (uint32_t)(uniform(&random) * height);
        told t = ask(desc, x, y);
        check_total(&t, pixels + ((size_t)y * width + x) * channels, channels);
        check(&t, s);
        snell_explanation_destroy(t.whole);
    }
}

static void showcase(void **state) {
    (void)state;
    glob_t scenes;
    seen s = {0};
    assert_int_equal(glob(TEST_SOURCE_DIR "/scenes/*.lua", 0, NULL, &scenes), 0);
    assert_true(scenes.gl_pathc > 10);
    for (size_t k = 0; k < scenes.gl_pathc; k++) {
        rig_clear(&bench);
        MUST(snell_scene_load(bench.scene, scenes.gl_pathv[k], NULL));
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        for (int i = SNELL_APPEL; i <= SNELL_PATH; i++) {
            snell_render_desc desc = SNELL_INIT(render_desc);
            MUST(snell_scene_settings(bench.scene, (snell_integrator)i, &desc));
            desc.width = 80;
            desc.height = 60;
            desc.samples = 2;
            desc.transparent |= k % 2;
            explain_pixels(&desc, &s);
        }
    }
    globfree(&scenes);
    printf("%zu rays, %zu lights of which %zu blocked; %zu surfaces conserve, "
           "%zu split, %zu are lit, %zu by a light that was chosen\n",
           s.rays, s.lights, s.blocked, s.conserving, s.splits, s.lit, s.chosen);
    assert_true(s.blocked > 0 && s.conserving > 0 && s.splits > 0 && s.lit > 0 && s.chosen > 0);
}

enum { LEVELS = 6 };

/* One ray through the centre of a picture of one pixel. */
static told ask_along(snell_vec3 from, snell_vec3 at, uint32_t depth) {
    snell_render_desc desc = picture(SNELL_WHITTED, 1, 1, depth);
    snell_view view = look(from, at);
    desc.view = &view;
    return ask(&desc, 0, 0);
}

/* ---- what the showcase has little of ---- */

static snell_render_desc small(int integrator) {
    snell_render_desc desc = SNELL_INIT(render_desc);
    MUST(snell_scene_settings(bench.scene, (snell_integrator)integrator, &desc));
    desc.width = 16;
    desc.height = 12;
    desc.samples = 4;
    desc.transparent = integrator % 2;
    return desc;
}

/* All pixels by all integrators. */
static seen explain_all(const char *lua) {
    seen s = {0};
    char path[] = "/tmp/snell-test-XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0 && write(file, lua, strlen(lua)) == (ssize_t)strlen(lua));
    close(file);
    snell_load_desc load = SNELL_INIT(load_desc);
    load.format = "lua";
    snell_status status = snell_scene_load(bench.scene, path, &load);
    unlink(path);
    MUST(status);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    for (int i = SNELL_APPEL; i <= SNELL_PATH; i++) {
        snell_render_desc desc = small(i);
        uint32_t width, height, channels;
        MUST(snell_render(bench.scene, &desc, bench.film));
        const float *pixels = snell_film_pixels(bench.film, &width, &height, &channels);
        for (uint32_t at = 0; at < width * height; at++) {
            told t = ask(&desc, at % width, at / width);
            check_total(&t, pixels + (size_t)at * channels, channels);
            check(&t, &s);
            snell_explanation_destroy(t.whole);
        }
    }
    return s;
}

/* What is there in part, in front of and inside of glass; panes; a light that the camera does not see;
 * several lights far away. */
static void corners(void **state) {
    (void)state;
    seen s = explain_all(
        "camera { from = {0, 1, 6}, at = {0, 0.6, 0}, fov = 45 }\n"
        "background { color = {.3, .4, .5}, top = {.1, .2, .6} }\n"
        "ambient { color = 0.02 }\n"
        "light.directional { direction = {-1, -2, -1}, irradiance = 2, angle = 0.1 }\n"
        "light.quad { corner = {-1, 3, -1}, u = {2, 0, 0}, v = {0, 0, 2}, radiance = 4,"
        "  visible = false }\n"
        "light.point { position = {2, 2, 3}, intensity = 9 }\n"
        "local glass = material.dielectric { ior = 1.5, absorption = {.3, .1, .2} }\n"
        "local inner = material.dielectric { ior = 1.33, priority = 1 }\n"
        "local veil = material.lambert { color = .7, alpha = .5 }\n"
        "local shine = material.lambert { color = .2, emission = {1, .5, .2} }\n"
        "local pane = material.principled { transmission = 1, roughness = 0.1 }\n"
        "plane { point = {0, 0, 0}, material = material.lambert { color = .5 }, name = 'ground' }\n"
        "sphere { center = {-1, .8, 0}, radius = .8, material = glass, name = 'ball' }\n"
        "sphere { center = {-1, .8, .3}, radius = .5, material = inner }\n"
        "sphere { center = {1, .7, 0}, radius = .7, material = veil, name = 'veil' }\n"
        "sphere { center = {1, .7, 0}, radius = .3, material = shine }\n"
        "quad { corner = {-1, 0, 2}, u = {2, 0, 0}, v = {0, 1.2, 0}, material = pane }\n"
        "box { min = {-2.4, 0, -1}, max = {-2, 1, 0},"
        "  material = material.principled { metallic = .5, roughness = .3, clearcoat = 1 } }\n");
    assert_true(s.blocked > 0 && s.splits > 0 && s.passed > 0 && s.hidden > 0 && s.named > 0);
}

/* ---- names, choices, limits ---- */

static void names(void **state) {
    (void)state;
    snell_sphere_desc sphere = SNELL_INIT(sphere_desc);
    snell_shape_id shape;
    MUST(snell_scene_add_sphere(bench.scene, &sphere, &shape));
    snell_instance_id ball = place(&bench, shape, add_lambert(&bench, grey(0.5)));
    add_sphere(&bench, v3(0, 3, 0), 0.5, add_mirror(&bench, grey(1)));
    add_point(&bench, v3(0, 9, 0), grey(100));
    add_point(&bench, v3(0, 0, -9), grey(100));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    told t = ask_along(v3(0, 1.2, 5), v3(0, 0.9, 0), 4);
    const snell_explained_ray *r = &t.rays[0];
    assert_int_equal(t.ray_count, 1);
    assert_string_equal(r->shape.type, "sphere");
    assert_string_equal(r->material.type, "lambert");
    assert_int_equal(r->hit.instance.index1, ball.index1);
    assert_int_equal(r->light_count, 2);
    const snell_explained_light *above = &t.lights[r->first_light], *behind = above + 1;
    assert_true(above->tested && above->visibility[0] == 0);
    assert_string_equal(above->blocker.type, "sphere");
    assert_true(above->blocker_distance > 1 && above->blocker_distance < 3);
    assert_true(!behind->tested && behind->contribution[0] == 0);
    snell_explanation_destroy(t.whole);
}

static void one_sample(void **state) {
    (void)state;
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_mirror(&bench, grey(0.5)));
    MUST(snell_scene_set_background_gradient(bench.scene, grey(0), grey(1)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snell_render_desc desc = SNELL_INIT(render_desc);
    snell_view view = look(v3(0, 1, 3), v3(0, 0.5, 0));
    desc.view = &view;
    desc.width = desc.height = 9;
    desc.samples = 8;
    snell_explain_desc at = SNELL_INIT(explain_desc);
    snell_explanation *whole, *one;
    at.x = at.y = 4;
    MUST(snell_explain(bench.scene, &desc, &at, &whole));
    at.first_sample = 5;
    at.sample_count = 1;
    MUST(snell_explain(bench.scene, &desc, &at, &one));
    uint32_t count, channels;
    size_t rays;
    const snell_explained_sample *all = snell_explanation_samples(whole, &count),
                                 *kept = snell_explanation_samples(one, &count);
    assert_int_equal(count, 8);
    for (uint32_t i = 0; i < count; i++) {
        assert_memory_equal(kept[i].radiance, all[i].radiance, sizeof all[i].radiance);
        assert_int_equal(kept[i].ray_count, i == 5 ? all[i].ray_count : 0);
    }
    const snell_explained_ray *few = snell_explanation_rays(one, &rays),
                              *many = snell_explanation_rays(whole, NULL) + all[5].first_ray;
    assert_int_equal(rays, all[5].ray_count);
    for (size_t i = 0; i < rays; i++) {
        assert_int_equal(few[i].sample, 5);
        assert_memory_equal(&few[i].throughput, &many[i].throughput, sizeof few[i].throughput);
    }
    assert_memory_equal(snell_explanation_pixel(one, &channels),
                        snell_explanation_pixel(whole, NULL), sizeof(float) * 3);
    snell_explanation_destroy(whole);
    snell_explanation_destroy(one);
}

static bool never(void *user, const snell_progress *progress) {
    (void)user;
    (void)progress;
    return false;
}

static void mistakes(void **state) {
    (void)state;
    snell_render_desc desc = picture(SNELL_WHITTED, 8, 4, 3);
    snell_explain_desc at = SNELL_INIT(explain_desc);
    snell_view view = look(v3(0, 1, 3), v3(0, 0, 0));
    snell_explanation *e = NULL;
    desc.view = &view;
    assert_int_equal(snell_explain(bench.scene, &desc, &at, &e), SNELL_ERR_STATE);
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_mirror(&bench, grey(1)));
    add_plane(&bench, v3(0, 5, 0), v3(0, -1, 0), add_mirror(&bench, grey(1)));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    assert_int_equal(snell_explain(bench.scene, &desc, NULL, &e), SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_explain(bench.scene, NULL, &at, &e), SNELL_ERR_ARGUMENT);
    at.x = 8;
    assert_int_equal(snell_explain(bench.scene, &desc, &at, &e), SNELL_ERR_ARGUMENT);
    assert_non_null(strstr(snell_last_error()->text, "8,0 is outside the picture of 8 x 4"));
    desc.crop_x = 2, desc.crop_width = desc.crop_height = 2;
    at.x = 2; /* of the crop */
    assert_int_equal(snell_explain(bench.scene, &desc, &at, &e), SNELL_ERR_ARGUMENT);
    at.x = 0;
    at.first_sample = 0, at.sample_count = 2;
    assert_int_equal(snell_explain(bench.scene, &desc, &at, &e), SNELL_ERR_ARGUMENT);
    at.sample_count = 0;
    at.struct_size--;
    assert_int_equal(snell_explain(bench.scene, &desc, &at, &e), SNELL_ERR_VERSION);
    at.struct_size++;
    desc.max_depth = 100;
    at.rays_max = 20;
    assert_int_equal(snell_explain(bench.scene, &desc, &at, &e), SNELL_ERR_MEMORY);
    assert_non_null(strstr(snell_last_error()->text, "more than 20 rays"));
    at.rays_max = 0;
    desc.integrator = SNELL_PATH;
    desc.samples = 1 << 20;
    desc.progress = never;
    at.first_sample = 7, at.sample_count = 1;
    assert_int_equal(snell_explain(bench.scene, &desc, &at, &e), SNELL_CANCELLED);
    assert_null(e);
    snell_explanation_destroy(NULL);
    assert_null(snell_explanation_rays(NULL, NULL));
}

/* ---- the hash of a scene ---- */

static uint64_t hash(void) {
    uint64_t h;
    MUST(snell_scene_hash(bench.scene, &h));
    return h;
}

static void hashes(void **state) {
    (void)state;
    uint64_t empty = hash();
    snell_instance_id ball = add_sphere(&bench, v3(0, 0, 0), 1, add_lambert(&bench, grey(0.5)));
    uint64_t one = hash();
    assert_true(one != empty);
    snell_transform moved = {{{1, 0, 0, 1}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    MUST(snell_scene_set_instance_transform(bench.scene, ball, &moved));
    uint64_t two = hash();
    assert_true(two != one);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    assert_true(hash() == two);
    rig_clear(&bench);
    add_sphere(&bench, v3(0, 0, 0), 1, add_lambert(&bench, grey(0.5)));
    assert_true(hash() == one);
    rig_clear(&bench);
    add_sphere(&bench, v3(0, 0, 0), 1, add_lambert(&bench, grey(0.25)));
    assert_true(hash() != one);
    assert_int_equal(snell_scene_hash(bench.scene, NULL), SNELL_ERR_ARGUMENT);
}

/* ---- the reference cases, node by node ---- */

/* The only child of a kind. */
static const snell_explained_ray *child(const snell_explained_ray *r, snell_ray_kind kind) {
    const snell_explained_ray *found = NULL;
    for (uint32_t k = 1; k < r->ray_count; k += r[k].ray_count) {
        if (r[k].kind != kind) continue;
        assert_null(found);
        found = &r[k];
    }
    assert_non_null(found);
    return found;
}

/* Of one ray, whose place and direction are floats; near grazing that shows. */
#define FLOAT_RAY 3e-6
#define AGREES(c, got, expected) assert_true(reference_agrees((c), (got), (expected)))

/* What is found no deeper than N is the picture of that depth. */
static void check_levels(const reference_case *c, const told *t) {
    for (uint32_t n = 0; n <= LEVELS; n++) {
        double sum = 0;
        for (size_t i = 0; i < t->light_count; i++)
            if (t->rays[t->lights[i].ray].depth <= n) sum += t->lights[i].contribution[0];
        AGREES(c, sum, reference_number(get(c->expected, "by_N"), n));
    }
}

/* A ray comes into glass, where every face reflects R and every crossing has the same length, and
 * lets some of it out at each of them. */
static void check_glass(const reference_case *c, const told *t, double ior, double r, double length,
                        double crossing) {
    const snell_explained_ray *at = &t->rays[0];
    double carried = 1 - r, rounded = 1e-6; /* of a throughput, at each hit */
    ASSERT_CLOSE(at->fresnel[0], r, FLOAT_RAY, 0);
    ASSERT_CLOSE(at->ior_to, ior, FLOAT_RAY, 0);
    assert_true(at->ior_from == 1 && !at->inside);
    ASSERT_CLOSE(child(at, SNELL_RAY_REFLECTED)->weight[0], r, FLOAT_RAY, 0);
    ASSERT_CLOSE(component(child(at, SNELL_RAY_REFLECTED)->throughput, 0), r, FLOAT_RAY, 0);
    at = child(at, SNELL_RAY_REFRACTED);
    ASSERT_CLOSE(at->weight[0], 1 - r, FLOAT_RAY, 0);
    for (uint32_t depth = 1; depth <= LEVELS; depth++) {
        carried *= crossing;
        assert_int_equal(at->depth, depth);
        assert_true(at->end == SNELL_RAY_HIT && at->inside);
        ASSERT_CLOSE(at->distance, length, FLOAT_RAY, 0);
        ASSERT_CLOSE(at->transmittance[0], crossing, FLOAT_RAY, 0);
        ASSERT_CLOSE(at->ior_from, ior, FLOAT_RAY, 0);
        assert_true(at->ior_to == 1);
        ASSERT_CLOSE(at->fresnel[0], r, FLOAT_RAY, 0);
        ASSERT_CLOSE(component(at->throughput, 0), carried, rounded * depth, 0);
        const snell_explained_ray *out = child(at, SNELL_RAY_REFRACTED);
        ASSERT_CLOSE(out->weight[0], 1 - r, FLOAT_RAY, 0);
        ASSERT_CLOSE(component(out->throughput, 0), carried * (1 - r), rounded * (depth + 1), 0);
        at = child(at, SNELL_RAY_REFLECTED);
        ASSERT_CLOSE(at->weight[0], r, FLOAT_RAY, 0);
        carried *= r;
        bool deeper = depth < LEVELS;
        assert_int_equal(at->end == SNELL_RAY_TOO_DEEP, !deeper);
        assert_int_equal(out->end == SNELL_RAY_TOO_DEEP, !deeper);
    }
    check_levels(c, t);
}

static void check_told(told *t) {
    seen s = {0};
    check(t, &s);
    snell_explanation_destroy(t->whole);
}

static void slab(const reference_case *c) {
    const json_t *it = json_array_get(get(c->scene, "geometry"), 0), *z = get(it, "z");
    double degrees = number(c->scene, "incidence_deg"), ior = number(it, "ior");
    double sine = sin(degrees * PI_ / 180) / ior, thick = reference_number(z, 1);
    rig_clear(&bench);
    build_slab(&bench, it, grey(number(it, "sigma_a")), number(c->scene, "front_environment"),
               number(c->scene, "back_environment"));
    told t = ask_along(slab_eye(it, degrees), slab_hit(it), LEVELS);
    check_glass(c, &t, ior, number(c->expected, "R"), thick / sqrt(1 - sine * sine),
                number(c->expected, "crossing_transmittance"));
    check_told(&t);
}

static void slabs(void **state) {
    (void)state;
    assert_int_equal(reference_each("F.slab_tree", slab), 4);
}

static void ball(const reference_case *c) {
    const json_t *it = json_array_get(get(c->scene, "geometry"), 0), *ray = get(c->scene, "ray");
    double chord = number(c->expected, "chord");
    rig_clear(&bench);
    build_sphere_tree(&bench, c->scene);
    told t = ask_along(color_of(get(ray, "o")), along_record(ray, 1), LEVELS);
    check_glass(c, &t, number(it, "ior"), number(c->expected, "R"), chord,
                exp(-number(it, "sigma_a") * chord));
    check_told(&t);
}

static void balls(void **state) {
    (void)state;
    assert_int_equal(reference_each("F.sphere_tree", ball), 5);
}

/* One crossing, in colour. */
static void beer(const reference_case *c) {
    const json_t *it = json_array_get(get(c->scene, "geometry"), 0);
    double degrees = number(c->scene, "incidence_deg");
    rig_clear(&bench);
    build_slab(&bench, it, color_of(get(c->scene, "sigma_a")), 0, 1);
    told t = ask_along(slab_eye(it, degrees), slab_hit(it), 2);
    const snell_explained_ray *in = child(&t.rays[0], SNELL_RAY_REFRACTED);
    AGREES(c, in->distance, number(c->expected, "path"));
    for (size_t i = 0; i < 3; i++)
        AGREES(c, in->transmittance[i], reference_number(get(c->expected, "T"), i));
    check_told(&t);
}

static void beers(void **state) {
    (void)state;
    assert_int_equal(reference_each("F.beer", beer), 4);
}

/* Two glazed planes face each other: each adds its light and sends on its share. */
static void check_mirrors(const reference_case *c, const told *t) {
    const json_t *m = get(get(c->scene, "materials"), "a");
    double carried = 1;
    for (uint32_t depth = 0; depth <= LEVELS; depth++) {
        const snell_explained_ray *r = &t->rays[depth]; /* a chain */
        assert_int_equal(r->depth, depth);
        if (depth > 0) AGREES(c, r->weight[0], number(m, "mirror"));
        AGREES(c, component(r->throughput, 0), carried);
        assert_int_equal(r->light_count, 1);
        assert_int_equal(t->lights[r->first_light].source, SNELL_SOURCE_AMBIENT);
        AGREES(c, t->lights[r->first_light].incoming[0], number(m, "added_radiance"));
        carried *= number(m, "mirror");
    }
    check_levels(c, t);
}

/* A mirror, then a ceiling under a point light: the closed form's own factors. */
static void check_image(const reference_case *c, const told *t) {
    const snell_explained_ray *ceiling = child(&t->rays[0], SNELL_RAY_REFLECTED);
    const snell_explained_light *l = &t->lights[ceiling->first_light];
    assert_true(ceiling->weight[0] == 1);
    assert_int_equal(t->rays[0].light_count, 0); /* a mirror gets no direct light */
    assert_int_equal(ceiling->light_count, 1);
    assert_string_equal(l->light.type, "point");
    AGREES(c, l->distance, sqrt(17));
    AGREES(c, l->cosine, 1 / sqrt(17));
    AGREES(c, l->incoming[0], 10 / 17.0);
    AGREES(c, l->bsdf[0], 0.5 / PI_);
    assert_true(l->tested && l->visibility[0] == 1);
    AGREES(c, l->contribution[0], json_number_value(c->expected));
}

static void mirror(const reference_case *c) {
    const json_t *ray = get(c->scene, "ray");
    rig_clear(&bench);
    build(&bench, c->scene);
    told t = ask_along(color_of(get(ray, "o")), along_record(ray, 1024), LEVELS);
    if (json_is_object(c->expected))
        check_mirrors(c, &t);
    else
        check_image(c, &t);
    check_told(&t);
}

static void mirrors(void **state) {
    (void)state;
    assert_int_equal(reference_each("G.mirrors", mirror), 4);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(showcase, fresh), cmocka_unit_test_setup(slabs, fresh),
        cmocka_unit_test_setup(balls, fresh),    cmocka_unit_test_setup(beers, fresh),
        cmocka_unit_test_setup(mirrors, fresh),  cmocka_unit_test_setup(corners, fresh),
        cmocka_unit_test_setup(names, fresh),    cmocka_unit_test_setup(one_sample, fresh),
        cmocka_unit_test_setup(mistakes, fresh), cmocka_unit_test_setup(hashes, fresh),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
