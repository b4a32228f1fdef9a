/* Light is counted once: what a plane of any material sends back of any light is the same by every
 * integrator that claims it, and the same as what paths find that only follow the material: they
 * choose no lights and weigh nothing. The registries are gone through, so a new material, light or
 * shape that has no row in the tables here fails by name. */
#include <string.h>

#include "policy_test.h"

static rig bench;
static family agreement;

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

/* ---- the policy that everything is held against ---- */

static void follow_material(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    emit_radiance(w, r, b->emission);
    if (r->depth > 0) return;
    const scene *s = wave_scene(w);
    for (uint32_t i = 0; i < s->light_count; i++) { /* of one direction: nothing could meet it */
        light_sample from;
        sample2 middle = {0.5, 0.5};
        const light_type *type = s->lights[i].type;
        if (!scene_sample_light(s, i, p, wave_eye(w), 0, middle, &from) || from.pdf > 0) continue;
        emit_light(w, r, p, b, LOBES_LIT, &from, 1, type->casts_shadow);
    }
    bsdf_direction next;
    sample2 choice = wave_draw(w, r, SAMPLE_LOBE), u = wave_draw(w, r, SAMPLE_DIRECTION);
    if (!bsdf_sample(b, p->ns, p->wo, choice.x, u, &next)) return;
    emit_ray(w, r, p, next.wi, next.weight, next.transmitted ? wave_beyond(w) : &r->media, 0,
             next.transmitted ? RAY_REFRACTED : RAY_REFLECTED);
}

static const integrator only_material = {
    .name = "material", .one_branch = true, .hit = follow_material, .miss = emit_background};

/* The same for lights that can be met, as far as max_depth. */
static void follow_material_on(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    emit_radiance(w, r, b->emission);
    bsdf_direction next;
    sample2 choice = wave_draw(w, r, SAMPLE_LOBE), u = wave_draw(w, r, SAMPLE_DIRECTION);
    if (!bsdf_sample(b, p->ns, p->wo, choice.x, u, &next)) return;
    emit_ray(w, r, p, next.wi, next.weight, next.transmitted ? wave_beyond(w) : &r->media, 0,
             next.transmitted ? RAY_REFRACTED : RAY_REFLECTED);
}

static const integrator only_material_deep = {
    .name = "material", .one_branch = true, .hit = follow_material_on, .miss = emit_background};

/* Samples of lights alone, through whatever lets light pass; of what can be met at all. */
static void only_sample_lights(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    const scene *s = wave_scene(w);
    for (uint32_t i = 0; i < scene_light_count(s); i++) {
        light_sample from;
        sample2 u = wave_draw_child(w, r, i, SAMPLE_LIGHT);
        if (!scene_sample_light(s, i, p, wave_eye(w), 0, u, &from) || !(from.pdf > 0)) continue;
        emit_light(w, r, p, b, LOBES_LIT, &from, 1 / from.pdf, true);
    }
}

static const integrator only_lights = {
    .name = "lights", .one_branch = true, .hit = only_sample_lights, .miss = emit_background};

/* ---- parameters of everything ---- */

static snell_param number_of(const char *name, double x) {
    return (snell_param){.name = name, .kind = SNELL_PARAM_FLOAT, .value.f = x};
}
static snell_param vector_of(const char *name, double x, double y, double z) {
    return (snell_param){.name = name, .kind = SNELL_PARAM_VEC3, .value.v = v3(x, y, z)};
}
static snell_param word_of(const char *name, const char *x) {
    return (snell_param){.name = name, .kind = SNELL_PARAM_STRING, .value.s = x};
}
static snell_param array_of(const char *name, const float *x, size_t count) {
    return (snell_param){.name = name, .kind = SNELL_PARAM_ARRAY, .value.array = {x, count}};
}
static snell_param bool_of(const char *name, bool x) {
    return (snell_param){.name = name, .kind = SNELL_PARAM_BOOL, .value.b = x};
}

/* A row of a table: an object of a registered type. Several of one type have several rows. */
typedef struct sort {
    const char *type, *what;
    size_t count;
    snell_param params[6];
} sort;

enum { SORTS_MAX = 64 };
typedef struct sorts {
    size_t count;
    sort rows[SORTS_MAX];
} sorts;

static sort *add_sort(sorts *all, const char *type, const char *what) {
    assert_true(all->count < SORTS_MAX);
    all->rows[all->count] = (sort){.type = type, .what = what};
    return &all->rows[all->count++];
}
static void with(sort *s, snell_param p) {
    assert_true(s->count < 6);
    s->params[s->count++] = p;
}

static void must_be_known(const sorts *all, const type_info *info, const char *where) {
    for (size_t i = 0; i < all->count; i++)
        if (strcmp(all->rows[i].type, info->name) == 0) return;
    fprintf(stderr, "'%s' is not tested: add a row to %s in tests/test_light_once.c\n", info->name,
            where);
    fail();
}

static sorts materials, lights, shapes;
static snell_input no_input;

/* What a row cannot say: ids of other objects, which change with each scene. */
static snell_input add_map(bool nearest) {
    float pixels[8 * 4 * 4];
    uint64_t random = 3;
    for (size_t i = 0; i < 8 * 4 * 4; i++) {
        double x = uniform(&random);
        pixels[i] = (float)(x < 0.4 ? 0 : 4 * x * x);
    }
    snell_image_texture_desc desc = SNELL_INIT(image_texture_desc);
    snell_input input = {grey(1), {0, 0}};
    desc.width = 8;
    desc.height = 4;
    desc.format = SNELL_IMAGE_TEXTURE_FORMAT_RGBA32F;
    desc.pixels = pixels;
    desc.pixels_count = sizeof pixels;
    desc.filter = nearest ? SNELL_IMAGE_TEXTURE_FILTER_NEAREST : SNELL_IMAGE_TEXTURE_FILTER_LINEAR;
    MUST(snell_scene_add_image_texture(bench.scene, &desc, &input.texture));
    return input;
}

static void fill_materials(void) {
    add_sort(&materials, "lambert", "");
    with(add_sort(&materials, "phong", ""), number_of("exponent", 20));
    with(add_sort(&materials, "blinn_phong", ""), number_of("exponent", 40));
    add_sort(&materials, "mirror", "");
    add_sort(&materials, "partial_mirror", "");
    add_sort(&materials, "glazed", "with a constant mirror");
    with(add_sort(&materials, "glazed", "by Fresnel"), number_of("ior", 1.5));
    add_sort(&materials, "dielectric", "smooth");
    with(add_sort(&materials, "dielectric", "rough"), number_of("roughness", 0.5));
    add_sort(&materials, "conductor", "smooth");
    with(add_sort(&materials, "conductor", "brushed"), number_of("roughness", 0.5));
    with(add_sort(&materials, "cook_torrance", ""), number_of("m", 0.3));
    with(add_sort(&materials, "ggx", ""), number_of("roughness", 0.5));
    with(add_sort(&materials, "principled", ""), number_of("roughness", 0.5));
    add_sort(&materials, "mix", "");
    with(add_sort(&materials, "emissive", ""), number_of("radiance", 0.1));
}

/* Large in the plane's sky, so that paths that do not look for them find them. */
static void fill_lights(void) {
    sort *s = add_sort(&lights, "point", "");
    with(s, vector_of("position", 0.5, 1, 0.2));
    s = add_sort(&lights, "spot", "in its falling edge");
    with(s, vector_of("position", 0.5, 1, 0.2));
    with(s, vector_of("at", 0.3, 0, 0));
    with(s, number_of("cone", 0.4));
    with(s, number_of("blend", 0.3));
    with(add_sort(&lights, "directional", "parallel"), vector_of("direction", -0.3, -1, 0.2));
    s = add_sort(&lights, "directional", "a disk in the sky");
    with(s, vector_of("direction", -0.3, -1, 0.2));
    with(s, number_of("angle", 1.2));
    add_sort(&lights, "headlight", "");
    for (int visible = 0; visible < 2; visible++) {
        s = add_sort(&lights, "quad", visible ? "" : "hidden");
        with(s, vector_of("center", 0.2, visible ? 0.7 : 0.5, visible ? 0.1 : -0.4));
        with(s, vector_of("at", 0, 0, 0));
        with(s, number_of("width", 1.2));
        with(s, number_of("height", 0.8));
        with(s, bool_of("visible", visible));
    }
    s = add_sort(&lights, "quad", "a parallelogram through the horizon");
    with(s, vector_of("corner", 0.5, -0.5, -0.5));
    with(s, vector_of("u", 0.1, 0.4, 1));
    with(s, vector_of("v", -0.3, 1.2, -0.4));
    s = add_sort(&lights, "disk", "");
    with(s, vector_of("center", -0.3, 0.7, 0.2));
    with(s, vector_of("normal", 0.3, -1, 0));
    with(s, number_of("radius", 0.6));
    s = add_sort(&lights, "sphere", "");
    with(s, vector_of("center", -0.4, 0.8, -0.2));
    with(s, number_of("radius", 0.5));
    s = add_sort(&lights, "sphere", "through the horizon");
    with(s, vector_of("center", 0.8, 0.1, -0.3));
    with(s, number_of("radius", 0.6));
    add_sort(&lights, "environment", "constant");
    add_sort(&lights, "environment", "image");
    with(add_sort(&lights, "environment", "image, smooth"), number_of("rotate", 0.7));
    with(add_sort(&lights, "environment", "checker"), bool_of("visible", false));
    with(add_sort(&lights, "sky", ""), vector_of("sun", 0.4, 0.5, 0.3));
}

static void fill_shapes(void) {
    sort *s = add_sort(&shapes, "sphere", "");
    s = add_sort(&shapes, "box", "");
    with(s, vector_of("min", -1, -0.5, -0.7));
    with(s, vector_of("max", 1, 0.5, 0.7));
    with(add_sort(&shapes, "disk", "a ring"), number_of("inner_radius", 0.5));
    s = add_sort(&shapes, "quad", "");
    with(s, vector_of("corner", -1, 0, -1));
    with(s, vector_of("u", 2, 0, 0));
    with(s, vector_of("v", 0, 0.2, 2));
    add_sort(&shapes, "mesh", "");
    for (int capped = 0; capped < 2; capped++) {
        s = add_sort(&shapes, "cylinder", capped ? "capped" : "open");
        with(s, vector_of("from", -0.8, 0, 0));
        with(s, vector_of("to", 0.8, 0.1, 0));
        with(s, number_of("radius", 0.7));
        with(s, bool_of("capped", capped));
        s = add_sort(&shapes, "cone", capped ? "capped" : "open");
        with(s, vector_of("from", -0.8, 0, 0));
        with(s, vector_of("to", 0.8, 0.1, 0));
        with(s, number_of("radius_to", 0.3));
        with(s, bool_of("capped", capped));
    }
    with(add_sort(&shapes, "torus", ""), number_of("minor", 0.4));
    add_sort(&shapes, "lathe", "");
    s = add_sort(&shapes, "capsule", "");
    with(s, vector_of("from", -0.6, 0, 0));
    with(s, vector_of("to", 0.6, 0.1, 0));
    with(s, number_of("radius", 0.4));
    with(add_sort(&shapes, "ellipsoid", ""), vector_of("radii", 1, 0.5, 0.8));
    with(add_sort(&shapes, "superellipsoid", ""), vector_of("radii", 1, 0.5, 0.8));
    s = add_sort(&shapes, "quadric", "cut");
    with(s, vector_of("square", 1, 2, 1));
    with(s, number_of("constant", -0.8));
    with(s, vector_of("min", -1, -0.5, -1));
    with(s, vector_of("max", 1, 1, 1));
    static const float heights[] = {0, 0.3f, 0.1f, 0.2f, -0.2f, 0.3f};
    s = add_sort(&shapes, "heightfield", "");
    with(s, vector_of("min", -1, 0, -1));
    with(s, vector_of("max", 1, 1, 1));
    with(s,
         (snell_param){.name = "heights", .kind = SNELL_PARAM_ARRAY, .value.array = {heights, 6}});
    with(s, (snell_param){.name = "columns", .kind = SNELL_PARAM_INT, .value.i = 3});
    with(s, (snell_param){.name = "rows", .kind = SNELL_PARAM_INT, .value.i = 2});
    /* Those without an area, which are found by rays. */
    static const float arc[] = {-1.2f, -0.4f, 0,    -0.9f, 0.1f, 0.3f, -0.3f, 0.3f, -0.2f,
                                0.3f,  -0.1f, 0.2f, 0.9f,  0.2f, 0,    1.3f,  0.5f, 0};
    for (int ribbon = 0; ribbon < 2; ribbon++) {
        s = add_sort(&shapes, "curves", ribbon ? "ribbon" : "round");
        with(s, array_of("points", arc, 6));
        with(s, number_of("radius", 0.25));
        with(s, word_of("kind", ribbon ? "ribbon" : "round"));
    }
    static float net[48];
    for (int i = 0; i < 16; i++) {
        net[3 * i] = 0.6f * (float)(i % 4) - 0.9f;
        net[3 * i + 1] = 0.4f * (float)(i % 3) - 0.4f;
        net[3 * i + 2] = 0.6f * (float)(i / 4) - 0.9f;
    }
    with(add_sort(&shapes, "patch", ""), array_of("points", net, 16));
    static const float middles[] = {-0.4f, 0, 0, 0.4f, 0.1f, 0.1f};
    with(add_sort(&shapes, "blob", ""), array_of("points", middles, 2));
    s = add_sort(&shapes, "implicit", "");
    with(s, word_of("f", "x^2 + 2*y^2 + z^2 - 0.7 + 0.1*x*y*z"));
    with(s, vector_of("min", -1, -1, -1));
    with(s, vector_of("max", 1, 1, 1));
    s = add_sort(&shapes, "julia", "");
    with(s, (snell_param){.name = "iterations", .kind = SNELL_PARAM_INT, .value.i = 5});
}

/* ---- building ---- */

static snell_material_id build_material(const sort *m) {
    snell_material_id id;
    snell_param params[8];
    size_t count = m->count;
    memcpy(params, m->params, sizeof m->params);
    if (strcmp(m->type, "glazed") == 0)
        params[count++] = (snell_param){.name = "base",
                                        .kind = SNELL_PARAM_MATERIAL,
                                        .value.material = add_lambert(&bench, grey(0.6))};
    if (strcmp(m->type, "mix") == 0)
        for (int i = 0; i < 2; i++)
            params[count++] = (snell_param){.name = i ? "b" : "a",
                                            .kind = SNELL_PARAM_MATERIAL,
                                            .value.material = i ? add_mirror(&bench, grey(0.5))
                                                                : add_lambert(&bench, grey(0.6))};
    MUST(snell_scene_add_material(bench.scene, m->type, params, count, &id));
    return id;
}

static void build_light(const sort *l) {
    snell_param params[8];
    size_t count = l->count;
    memcpy(params, l->params, sizeof l->params);
    snell_input map = no_input;
    if (strncmp(l->what, "image", 5) == 0) map = add_map(strcmp(l->what, "image") == 0);
    if (strcmp(l->what, "checker") == 0) {
        snell_checker_texture_desc desc = SNELL_INIT(checker_texture_desc);
        MUST(snell_scene_add_checker_texture(bench.scene, &desc, &map.texture));
    }
    if (map.texture.index1)
        params[count++] = (snell_param){
            .name = "radiance", .kind = SNELL_PARAM_TEXTURE, .value.texture = map.texture};
    MUST(snell_scene_add_light(bench.scene, l->type, params, count, NULL));
}

static snell_shape_id add_gem(void) {
    static const uint32_t faces[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                     2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    const snell_vec3 corners[] = {v3(1, 0, 0),  v3(-1, 0, 0), v3(0, 1, 0),
                                  v3(0, -1, 0), v3(0, 0, 1),  v3(0, 0, -1)};
    return add_mesh(&bench, corners, 6, faces, 24);
}

static snell_shape_id build_shape(const sort *s) {
    static const snell_vec2 profile[3] = {{0.2f, -0.7f}, {0.9f, 0}, {0.3f, 0.8f}};
    snell_shape_id id;
    if (strcmp(s->type, "mesh") == 0) return add_gem();
    if (strcmp(s->type, "lathe") == 0) {
        snell_lathe_desc desc = SNELL_INIT(lathe_desc);
        desc.profile = profile;
        desc.profile_count = 3;
        MUST(snell_scene_add_lathe(bench.scene, &desc, &id));
        return id;
    }
    MUST(snell_scene_add_shape(bench.scene, s->type, s->params, s->count, &id));
    return id;
}

/* Squashed and turned over the plane. similar: only turned and made smaller. */
static void put_above(snell_shape_id shape, snell_material_id m, bool similar) {
    snell_transform at = {{{0.48f, -0.36f, 0, 0.2f}, {0.36f, 0.48f, 0, 0.8f}, {0, 0, 0.6f, 0.1f}}};
    if (!similar) at.m[0][0] = 0.7f, at.m[0][2] = 0.1f, at.m[2][2] = 0.4f;
    MUST(snell_scene_add_instance(bench.scene, shape, m, &at, NULL));
}

static snell_material_id add_shining(snell_input radiance, double alpha, bool two_sided) {
    snell_lambert_desc desc = SNELL_INIT(lambert_desc);
    snell_material_id id;
    desc.color = flat(grey(0));
    desc.emission = radiance;
    desc.emit_two_sided = two_sided;
    desc.alpha = flat(grey(alpha));
    MUST(snell_scene_add_lambert(bench.scene, &desc, &id));
    return id;
}

/* ---- comparing ---- */

static const snell_vec3 origin = {0, 0, 0}, eye = {0.01f, 0.015f, 0.004f};

static void check_claims(const char *name, const estimate *expected, bool whitted) {
    static const snell_integrator policies[] = {SNELL_PATH, SNELL_COOK, SNELL_WHITTED};
    static const char *const names[] = {"path", "cook", "whitted"};
    for (int i = 0; i < 2 + whitted; i++) {
        estimate got = estimate_light(&bench, policies[i], eye, origin, 1, 32);
        for (int k = 0; k < 3; k++) {
            char what[160];
            snprintf(what, sizeof what, "%s by %s [%d]", name, names[i], k);
            family_check_same(&agreement, what, &got.channel[k], &expected->channel[k]);
        }
    }
}

/* The scene is built, but for the plane. */
static void check_plane(const char *name, const sort *m, bool whitted) {
    char what[120];
    add_plane(&bench, origin, v3(0, 1, 0), build_material(m));
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    snprintf(what, sizeof what, "%s %s under %s", m->type, m->what, name);
    uint32_t samples = full_tests() ? 1024 : 128;
    estimate expected = estimate_policy(&bench, &only_material, eye, origin, 1, samples);
    /* To whitted, rough glass is smooth. */
    check_claims(what, &expected, whitted && strcmp(m->what, "rough") != 0);
}

static void every_light_on_every_material(void **state) {
    (void)state;
    for (size_t i = 0; i < lights.count; i++)
        for (size_t k = 0; k < materials.count; k++) {
            const sort *l = &lights.rows[i];
            char name[80];
            rig_clear(&bench);
            build_light(l);
            snprintf(name, sizeof name, "%s %s", l->type, l->what);
            bool point = !strcmp(l->type, "point") || !strcmp(l->type, "spot") ||
                         !strcmp(l->type, "headlight") || !strcmp(l->what, "parallel");
            check_plane(name, &materials.rows[k], point);
        }
}

/* Every shape may shine, moved by any transform, from outside, with a texture, or half there. */
static void every_shape_shines(void **state) {
    (void)state;
    static const char *const on[] = {"lambert", "ggx"};
    for (size_t i = 0; i < shapes.count; i++)
        for (int how = 0; how < 4; how++) {
            /* There in part and without an area: path alone finds it. */
            if (how == 3 && primitive_find(shapes.rows[i].type)->area == NULL) continue;
            rig_clear(&bench);
            snell_input radiance = how == 2 ? add_map(true) : flat(v3(2, 1, 0.5));
            char name[80];
            put_above(build_shape(&shapes.rows[i]),
                      add_shining(radiance, how == 3 ? 0.5 : 1, how != 1), how == 0);
            snprintf(name, sizeof name, "%s %s (%d)", shapes.rows[i].type, shapes.rows[i].what,
                     how);
            for (size_t k = 0; k < materials.count; k++)
                if (strcmp(materials.rows[k].type, on[how % 2]) == 0)
                    check_plane(name, &materials.rows[k], false);
        }
}

/* ---- shapes of the caller ---- */

/* Two balls in one shape. */
enum { BALLS = 2 };
typedef struct ball {
    dvec3 center;
    double radius;
} ball;

static void ball_bounds(void *user, uint32_t primitive, snell_bounds *out) {
    const ball *b = &((const ball *)user)[primitive];
    double r = b->radius * 1.00001;
    out->min = v3(b->center.x - r, b->center.y - r, b->center.z - r);
    out->max = v3(b->center.x + r, b->center.y + r, b->center.z + r);
}

/* Of a unit direction d; NAN: none. */
static double ball_root(const ball *b, dvec3 o, dvec3 d, int which) {
    dvec3 to = dvec3_sub(b->center, o);
    double middle = dvec3_dot(to, d);
    dvec3 across = dvec3_sub(to, dvec3_scale(d, middle));
    double half = sqrt(b->radius * b->radius - dvec3_dot(across, across));
    return which ? middle + half : middle - half;
}

static bool ball_intersect(void *user, uint32_t primitive, const snell_user_ray *beam,
                           snell_user_hit *out) {
    const ball *b = &((const ball *)user)[primitive];
    dvec3 o = dvec3_from(beam->origin), d = dvec3_from(beam->direction);
    double speed = dvec3_length(d);
    for (int i = 0; i < 2; i++) {
        out->t = (float)(ball_root(b, o, dvec3_scale(d, 1 / speed), i) / speed);
        if (out->t > beam->t_min && out->t < beam->t_max) return true;
    }
    return false;
}

static void ball_surface(void *user, uint32_t primitive, const snell_user_ray *beam,
                         const snell_user_hit *found, snell_user_surface *out) {
    (void)beam, (void)found;
    const ball *b = &((const ball *)user)[primitive];
    dvec3 p = {out->position[0], out->position[1], out->position[2]};
    dvec3 n = dvec3_normalize(dvec3_sub(p, b->center));
    p = dvec3_add(b->center, dvec3_scale(n, b->radius));
    *out = (snell_user_surface){{p.x, p.y, p.z}, {n.x, n.y, n.z}, 1e-14, 1 / b->radius, {0.5, 0.5}};
}

static void put_balls_above(ball *balls, bool own, bool similar) {
    snell_material_id m = add_shining(flat(v3(2, 1, 0.5)), 1, false);
    snell_shape_id shape;
    for (int i = 0; i < BALLS && !own; i++) {
        snell_sphere_desc desc = SNELL_INIT(sphere_desc);
        desc.center = vec3_from(balls[i].center);
        desc.radius = (float)balls[i].radius;
        MUST(snell_scene_add_sphere(bench.scene, &desc, &shape));
        put_above(shape, m, similar);
    }
    if (!own) return;
    snell_user_shape_desc desc = SNELL_INIT(user_shape_desc);
    desc.user = balls;
    desc.primitive_count = BALLS;
    desc.bounds = ball_bounds;
    desc.intersect = ball_intersect;
    desc.surface = ball_surface;
    MUST(snell_scene_add_user_shape(bench.scene, &desc, "balls", &shape));
    put_above(shape, m, similar);
}

/* As much, by paths, by cook and by samples of lights alone, as built-in balls in the same places. */
static void shapes_of_the_caller_shine(void **state) {
    (void)state;
    enum { WAYS = 3 };
    static const char *const names[WAYS] = {"path", "cook", "samples of lights"};
    ball balls[BALLS] = {{{-0.5, 0, 0.25}, 0.5}, {{0.5, 0.25, -0.25}, 0.375}};
    uint32_t samples = full_tests() ? 1024 : 256;
    for (int similar = 0; similar < 2; similar++) {
        estimate found[2][WAYS];
        double older[2];
        for (int own = 0; own < 2; own++) {
            rig_clear(&bench);
            put_balls_above(balls, own, similar);
            add_plane(&bench, origin, v3(0, 1, 0), add_lambert(&bench, grey(0.8)));
            MUST(snell_scene_commit(bench.scene, NULL, NULL));
            assert_int_equal(scene_light_count(bench.scene->frozen), own ? 1 : BALLS);
            estimate *by = found[own];
            by[0] = estimate_light(&bench, SNELL_PATH, eye, origin, 1, samples);
            by[1] = estimate_light(&bench, SNELL_COOK, eye, origin, 1, samples);
            by[2] = estimate_policy(&bench, &only_lights, eye, origin, 1, samples);
            older[own] = trace_ray(&bench, SNELL_WHITTED, eye, origin, 0).c[0];
        }
        ASSERT_CLOSE(older[1], older[0], 0.3, 0); /* of few points */
        for (int i = 0; i < WAYS; i++)
            for (int k = 0; k < 3; k++) {
                const moments *own = &found[1][i].channel[k], *built_in = &found[0][i].channel[k];
                char what[160];
                snprintf(what, sizeof what, "balls of the caller (%d) by %s [%d]", similar,
                         names[i], k);
                assert_true(own->mean > 0 && moments_error(own) < 0.01 * own->mean);
                family_check_same(&agreement, what, own, built_in);
            }
    }
}

/* Lights of every sort at once, which are chosen among, and which hide one another. */
static void all_lights_together(void **state) {
    (void)state;
    for (size_t k = 0; k < materials.count; k++) {
        rig_clear(&bench);
        for (size_t i = 0; i < lights.count; i++)
            if (strcmp(lights.rows[i].type, "headlight") != 0) build_light(&lights.rows[i]);
        put_above(add_gem(), add_shining(flat(grey(1)), 0.6, true), false);
        check_plane("everything", &materials.rows[k], false);
    }
}

/* ---- what stands between light and surface ---- */

static void add_card_between(double alpha, int32_t shadow) {
    snell_lambert_desc desc = SNELL_INIT(lambert_desc);
    snell_material_id id;
    desc.color = flat(grey(0));
    desc.alpha = flat(grey(alpha));
    desc.shadow = shadow;
    MUST(snell_scene_add_lambert(bench.scene, &desc, &id));
    add_quad(&bench, v3(-0.3, 0.3, -0.5), v3(1, 0, 0), v3(0, 0, 1), id);
}

/* Of the ior 1, glass as thin as air: nothing is refracted, so a light behind it can be met and
 * sampled. */
static void add_glass_between(double ior, double alpha, int32_t shadow) {
    snell_dielectric_desc desc = SNELL_INIT(dielectric_desc);
    snell_material_id id;
    desc.ior = (float)ior;
    desc.shadow = shadow;
    desc.absorption = v3(1, 0.5, 0);
    desc.color = flat(grey(0.9));
    desc.alpha = flat(grey(alpha));
    MUST(snell_scene_add_dielectric(bench.scene, &desc, &id));
    add_sphere(&bench, v3(0.1, 0.4, 0), 0.3, id);
}

/* A window pane, without an inside. */
static void add_pane_between(double roughness, int32_t shadow) {
    static const char *const words[] = {"filter", "opaque", "none"};
    snell_material_id id;
    const snell_param params[] = {
        number_of("transmission", 1),
        number_of("roughness", roughness),
        {.name = "shadow", .kind = SNELL_PARAM_STRING, .value.s = words[shadow]}};
    MUST(snell_scene_add_material(bench.scene, "principled", params, 3, &id));
    add_quad(&bench, v3(-0.8, 0.3, -0.8), v3(1.6, 0, 0), v3(0, 0, 1.6), id);
}

static void build_between(int what, int32_t shadow) {
    rig_clear(&bench);
    for (size_t i = 0; i < lights.count; i++)
        if (strcmp(lights.rows[i].type, "disk") == 0 ||
            strcmp(lights.rows[i].what, "constant") == 0)
            build_light(&lights.rows[i]);
    if (what == 0) add_card_between(0.5, shadow);
    if (what == 1) add_glass_between(1, 1, shadow);
    if (what == 2) add_glass_between(1, 0.4, shadow);
    if (what == 4) add_pane_between(0, shadow);
    if (what == 5) add_pane_between(0.5, shadow);
    if (what == 6) add_glass_between(1.5, 1, shadow);
    if (what == 3) { /* a ball that is half there: a quarter passes */
        add_sphere(&bench, v3(0.1, 0.4, 0), 0.3, add_card(&bench, grey(0), 0.5));
    }
}

static void light_passes_once(void **state) {
    (void)state;
    static const char *const names[] = {"a card", "gas",    "thin gas",
                                        "a ball", "a pane", "frosted glass"};
    for (int what = 0; what < 6; what++) {
        build_between(what, SNELL_LAMBERT_SHADOW_FILTER);
        add_plane(&bench, origin, v3(0, 1, 0), add_lambert(&bench, grey(0.8)));
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        enum { DEPTH = 12 }; /* where next to nothing is left of what goes to and fro */
        estimate expected = estimate_policy(&bench, &only_material_deep, eye, origin, DEPTH, 512);
        estimate got = estimate_light(&bench, SNELL_PATH, eye, origin, DEPTH, 128);
        char name[80];
        snprintf(name, sizeof name, "through %s by path", names[what]);
        for (int k = 0; k < 3; k++)
            family_check_same(&agreement, name, &got.channel[k], &expected.channel[k]);
        /* cook's shadow rays meet each face by itself, and know no other light through panes */
        if (what == 2 || what >= 4) continue;
        got = estimate_light(&bench, SNELL_COOK, eye, origin, DEPTH, 128);
        snprintf(name, sizeof name, "through %s by cook", names[what]);
        for (int k = 0; k < 3; k++)
            family_check_same(&agreement, name, &got.channel[k], &expected.channel[k]);
    }
}

/* A pane that a path goes straight through takes nothing of its depth: at the depth 1 light through
 * panes was lost, by as much as light sampling left to what the path meets. */
static void panes_cost_no_depth(void **state) {
    (void)state;
    for (int panes = 1; panes <= 3; panes++) {
        build_between(4, SNELL_LAMBERT_SHADOW_FILTER);
        for (int i = 1; i < panes; i++) add_pane_between(0, SNELL_LAMBERT_SHADOW_FILTER);
        add_plane(&bench, origin, v3(0, 1, 0), add_lambert(&bench, grey(0.8)));
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        estimate expected = estimate_policy(&bench, &only_lights, v3(0, 0.2, 0.1), origin, 0, 256);
        estimate got = estimate_light(&bench, SNELL_PATH, v3(0, 0.2, 0.1), origin, 1, 256);
        char name[80];
        snprintf(name, sizeof name, "through %d panes at depth 1", panes);
        for (int k = 0; k < 3; k++)
            family_check_same(&agreement, name, &got.channel[k], &expected.channel[k]);
    }
}

/* What shadow rays are told of a surface adds nothing to what paths meet, and takes nothing from it:
 * light through glass without a shadow was counted twice, through a card of full shadow in part. */
static void shadow_words_change_no_area_light(void **state) {
    (void)state;
    for (int32_t shadow = SNELL_LAMBERT_SHADOW_OPAQUE; shadow <= SNELL_LAMBERT_SHADOW_NONE;
         shadow++)
        for (int what = 0; what <= 6; what++) {
            if (what == 3) continue; /* its card is as the first */
            build_between(what, shadow);
            add_plane(&bench, origin, v3(0, 1, 0), add_lambert(&bench, grey(0.8)));
            MUST(snell_scene_commit(bench.scene, NULL, NULL));
            estimate expected = estimate_policy(&bench, &only_material_deep, eye, origin, 12, 512);
            estimate got = estimate_light(&bench, SNELL_PATH, eye, origin, 12, 256);
            char name[80];
            snprintf(name, sizeof name, "between %d, shadow %d", what, (int)shadow);
            for (int k = 0; k < 3; k++)
                family_check_same(&agreement, name, &got.channel[k], &expected.channel[k]);
        }
}

/* The older integrators ask each light of a mesh at so many points, which are one light together:
 * far off, as much as from its whole area. */
static void centers_are_one_light(void **state) {
    (void)state;
    for (int triangles = 1; triangles <= 64; triangles *= 2) {
        rig_clear(&bench);
        snell_vec3 corners[3 * 64];
        uint32_t indices[3 * 64];
        for (int i = 0; i < triangles; i++) {
            double at = (double)i / triangles;
            corners[3 * i] = v3(at, 9, 0);
            corners[3 * i + 1] = v3(at + 0.9 / triangles, 9, 0);
            corners[3 * i + 2] = v3(at, 9, 1 - at / 2); /* of different sizes */
            for (int k = 0; k < 3; k++) indices[3 * i + k] = (uint32_t)(3 * i + k);
        }
        place(&bench,
              add_mesh(&bench, corners, (size_t)(3 * triangles), indices, (size_t)(3 * triangles)),
              add_shining(flat(grey(50)), 1, true));
        add_plane(&bench, origin, v3(0, 1, 0), add_lambert(&bench, grey(0.8)));
        MUST(snell_scene_commit(bench.scene, NULL, NULL));
        double area = estimate_light(&bench, SNELL_COOK, eye, origin, 0, 256).channel[0].mean;
        for (snell_integrator policy = SNELL_APPEL; policy <= SNELL_WHITTED; policy++)
            ASSERT_CLOSE(trace_ray(&bench, policy, eye, origin, 0).c[0], area, 0.02, 0);
    }
}

static void everything_is_tested(void **state) {
    (void)state;
    for (uint32_t i = 0; i < material_type_count; i++)
        must_be_known(&materials, &material_types[i]->info, "fill_materials");
    for (uint32_t i = 0; i < light_type_count; i++)
        must_be_known(&lights, &light_types[i]->info, "fill_lights");
    for (uint32_t i = 0; i < primitive_type_count; i++)
        if (!primitive_types[i]->unbounded && primitive_types[i] != &primitive_solid)
            must_be_known(&shapes, &primitive_types[i]->info, "fill_shapes");
}

static void all_agree(void **state) {
    (void)state;
    family_judge(&agreement);
}

int main(void) {
    fill_materials();
    fill_lights();
    fill_shapes();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(everything_is_tested),
        cmocka_unit_test(every_light_on_every_material),
        cmocka_unit_test(every_shape_shines),
        cmocka_unit_test(shapes_of_the_caller_shine),
        cmocka_unit_test(all_lights_together),
        cmocka_unit_test(light_passes_once),
        cmocka_unit_test(panes_cost_no_depth),
        cmocka_unit_test(shadow_words_change_no_area_light),
        cmocka_unit_test(centers_are_one_light),
        cmocka_unit_test(all_agree),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
