/* Small scenes through the public API: what the tests of the renderer share. A call that fails ends
 * the test with the library's own message. */
#ifndef SNELL_TESTS_RENDER_TEST_H
#define SNELL_TESTS_RENDER_TEST_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include <snell/snell.h>

#define MUST(call) must((call), #call, __FILE__, __LINE__)

static inline void must(snell_status status, const char *call, const char *file, int line) {
    if (status == SNELL_OK) return;
    fprintf(stderr, "%s: %s (%d)\n", call, snell_last_error()->text, (int)status);
    _fail(file, line);
}

typedef struct rig {
    snell_context *context;
    snell_scene *scene;
    snell_film *film;
} rig;

static inline rig rig_make(uint32_t threads, snell_isa isa) {
    rig r = {0};
    snell_context_desc desc = SNELL_INIT(context_desc);
    desc.thread_count = threads;
    desc.isa_max = isa;
    MUST(snell_context_create(&desc, &r.context));
    MUST(snell_scene_create(r.context, &r.scene));
    MUST(snell_film_create(r.context, &r.film));
    return r;
}

static inline void rig_free(rig *r) {
    snell_film_destroy(r->film);
    snell_scene_destroy(r->scene);
    snell_context_destroy(r->context);
}

/* A context of its own is dear in threads; a new scene in the old context is not. */
static inline void rig_clear(rig *r) {
    snell_scene_destroy(r->scene);
    MUST(snell_scene_create(r->context, &r->scene));
}

static inline snell_vec3 v3(double x, double y, double z) {
    return (snell_vec3){(float)x, (float)y, (float)z};
}
static inline snell_vec3 grey(double x) { return v3(x, x, x); }
static inline snell_input flat(snell_vec3 color) {
    return (snell_input){color, (snell_texture_id){0, 0}};
}

/* ---- materials ---- */

static inline snell_material_id add_lambert(rig *r, snell_vec3 color) {
    snell_lambert_desc desc = SNELL_INIT(lambert_desc);
    snell_material_id id;
    desc.color = flat(color);
    MUST(snell_scene_add_lambert(r->scene, &desc, &id));
    return id;
}

/* A black surface that shines with the given radiance from both sides. */
static inline snell_material_id add_glow(rig *r, snell_vec3 radiance) {
    snell_lambert_desc desc = SNELL_INIT(lambert_desc);
    snell_material_id id;
    desc.color = flat(grey(0));
    desc.ambient = grey(0);
    desc.emission = flat(radiance);
    desc.emit_two_sided = true;
    MUST(snell_scene_add_lambert(r->scene, &desc, &id));
    return id;
}

static inline snell_material_id add_card(rig *r, snell_vec3 color, double alpha) {
    snell_lambert_desc desc = SNELL_INIT(lambert_desc);
    snell_material_id id;
    desc.color = flat(color);
    desc.alpha = flat(grey(alpha));
    MUST(snell_scene_add_lambert(r->scene, &desc, &id));
    return id;
}

static inline snell_material_id add_mirror(rig *r, snell_vec3 color) {
    snell_mirror_desc desc = SNELL_INIT(mirror_desc);
    snell_material_id id;
    desc.color = flat(color);
    MUST(snell_scene_add_mirror(r->scene, &desc, &id));
    return id;
}

static inline snell_material_id add_glass(rig *r, double ior, snell_vec3 absorption, int priority) {
    snell_dielectric_desc desc = SNELL_INIT(dielectric_desc);
    snell_material_id id;
    desc.ior = (float)ior;
    desc.absorption = absorption;
    desc.priority = priority;
    MUST(snell_scene_add_dielectric(r->scene, &desc, &id));
    return id;
}

/* ---- shapes: made and placed once ---- */

static inline snell_instance_id place(rig *r, snell_shape_id shape, snell_material_id m) {
    snell_instance_id id;
    MUST(snell_scene_add_instance(r->scene, shape, m, NULL, &id));
    return id;
}

static inline snell_instance_id add_sphere(rig *r, snell_vec3 center, double radius,
                                           snell_material_id m) {
    snell_sphere_desc desc = SNELL_INIT(sphere_desc);
    snell_shape_id id;
    desc.center = center;
    desc.radius = (float)radius;
    MUST(snell_scene_add_sphere(r->scene, &desc, &id));
    return place(r, id, m);
}

static inline snell_instance_id add_plane(rig *r, snell_vec3 point, snell_vec3 normal,
                                          snell_material_id m) {
    snell_plane_desc desc = SNELL_INIT(plane_desc);
    snell_shape_id id;
    desc.point = point;
    desc.normal = normal;
    MUST(snell_scene_add_plane(r->scene, &desc, &id));
    return place(r, id, m);
}

static inline snell_instance_id add_box(rig *r, snell_vec3 min, snell_vec3 max,
                                        snell_material_id m) {
    snell_box_desc desc = SNELL_INIT(box_desc);
    snell_shape_id id;
    desc.min = min;
    desc.max = max;
    MUST(snell_scene_add_box(r->scene, &desc, &id));
    return place(r, id, m);
}

static inline snell_instance_id add_quad(rig *r, snell_vec3 corner, snell_vec3 u, snell_vec3 v,
                                         snell_material_id m) {
    snell_quad_desc desc = SNELL_INIT(quad_desc);
    snell_shape_id id;
    desc.corner = corner;
    desc.u = u;
    desc.v = v;
    MUST(snell_scene_add_quad(r->scene, &desc, &id));
    return place(r, id, m);
}

/* ---- lights ---- */

static inline void add_point(rig *r, snell_vec3 position, snell_vec3 intensity) {
    snell_point_light_desc desc = SNELL_INIT(point_light_desc);
    desc.position = position;
    desc.intensity = intensity;
    MUST(snell_scene_add_point_light(r->scene, &desc, NULL));
}

static inline void add_sun(rig *r, snell_vec3 direction, snell_vec3 irradiance) {
    snell_directional_light_desc desc = SNELL_INIT(directional_light_desc);
    desc.direction = direction;
    desc.irradiance = irradiance;
    MUST(snell_scene_add_directional_light(r->scene, &desc, NULL));
}

/* ---- meshes ---- */

static inline snell_shape_id add_mesh(rig *r, const snell_vec3 *positions, size_t position_count,
                                      const uint32_t *indices, size_t index_count) {
    snell_mesh_desc desc = SNELL_INIT(mesh_desc);
    snell_shape_id id;
    desc.positions = positions;
    desc.positions_count = position_count;
    desc.indices = indices;
    desc.indices_count = index_count;
    MUST(snell_scene_add_mesh(r->scene, &desc, &id));
    return id;
}

/* ---- pictures ---- */

/* A render that decides everything: one sample through the centre, nothing dropped. */
static inline snell_render_desc picture(snell_integrator policy, uint32_t width, uint32_t height,
                                        uint32_t depth) {
    return (snell_render_desc){.struct_size = sizeof(snell_render_desc),
                               .integrator = policy,
                               .width = width,
                               .height = height,
                               .samples = 1,
                               .max_depth = depth,
                               .pixel_center = true};
}

static inline snell_view look(snell_vec3 from, snell_vec3 at) {
    snell_view view = SNELL_INIT(view);
    view.from = from;
    view.at = at;
    float x = fabsf(at.x - from.x), y = fabsf(at.y - from.y), z = fabsf(at.z - from.z);
    view.up = y <= x && y <= z ? v3(0, 1, 0) : z <= x ? v3(0, 0, 1) : v3(1, 0, 0);
    return view;
}

typedef struct rgb {
    double c[3];
} rgb;

static inline rgb pixel_at(const rig *r, uint32_t x, uint32_t y) {
    uint32_t width, height, channels;
    const float *p = snell_film_pixels(r->film, &width, &height, &channels);
    assert_non_null(p);
    assert_true(x < width && y < height);
    p += ((size_t)y * width + x) * channels;
    return (rgb){{p[0], p[1], p[2]}};
}

/* What one ray brings home, by a picture of one pixel. The scene is committed already. */
static inline rgb trace_ray(rig *r, snell_integrator policy, snell_vec3 from, snell_vec3 at,
                            uint32_t depth) {
    snell_render_desc desc = picture(policy, 1, 1, depth);
    snell_view view = look(from, at);
    desc.view = &view;
    MUST(snell_render(r->scene, &desc, r->film));
    return pixel_at(r, 0, 0);
}

/* The same along a direction: `at` lies so far that rounding it does not turn the ray. */
static inline rgb trace_direction(rig *r, snell_integrator policy, snell_vec3 from, double dx,
                                  double dy, double dz, uint32_t depth) {
    double far = 0x1p20;
    return trace_ray(
        r, policy, from,
        v3((double)from.x + far * dx, (double)from.y + far * dy, (double)from.z + far * dz), depth);
}

static inline snell_render_stats stats_of(const rig *r) {
    snell_render_stats stats = {.struct_size = sizeof stats};
    MUST(snell_film_get_stats(r->film, &stats));
    return stats;
}

#define ASSERT_CLOSE(got, expected, rel, abs)                                                      \
    assert_close((got), (expected), (rel), (abs), #got, __FILE__, __LINE__)
static inline void assert_close(double got, double expected, double rel, double abs,
                                const char *what, const char *file, int line) {
    if (fabs(got - expected) <= abs + rel * fabs(expected)) return;
    fprintf(stderr, "%s is %.9g, not %.9g (off by %.3g of it)\n", what, got, expected,
            fabs(got - expected) / fabs(expected));
    _fail(file, line);
}

/* Numbers for the tests themselves: SplitMix64. */
static inline double uniform(uint64_t *state) {
    uint64_t x = *state += 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return (double)((x ^ x >> 31) >> 11) * 0x1p-53;
}

static inline bool full_tests(void) {
    const char *full = getenv("SNELL_FULL");
    return full && full[0] == '1';
}

#endif
