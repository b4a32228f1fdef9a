/* Textures: their values at known points, maps, mip maps, footprints and ray differentials, normal
 * maps and bump. */
#include <string.h>

#include "api/api.h"
#include "image/codec.h"
#include "image/srgb.h"
#include "importers/image_float.h"
#include "integrators/differential.h"
#include "maths/functions.h"
#include "render_test.h"
#include "textures/mipmap.h"

extern const texture_type texture_image, texture_checker, texture_gradient, texture_noise;

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
static int fresh(void **state) {
    (void)state;
    rig_clear(&bench);
    return 0;
}
static void commit(void) { MUST(snell_scene_commit(bench.scene, NULL, NULL)); }

static texel look_at(const texture_type *type, const void *desc, const texture_point *point) {
    texture t = texture_make(type, desc);
    if (type->check) MUST(type->check(desc));
    MUST(texture_prepare(&t));
    texel seen = type->evaluate(&t, point);
    texture_destroy(&t);
    return seen;
}
static double red_at(const texture_type *type, const void *desc, const texture_point *point) {
    return look_at(type, desc, point).color.x;
}
static texture_point at_uv(double u, double v) {
    return (texture_point){.u = u, .v = v, .has_uv = true, .n = {0, 0, 1}};
}
static texture_point at_point(double x, double y, double z, dvec3 n) {
    return (texture_point){.local = {x, y, z}, .n = dvec3_normalize(n)};
}

/* ---- images ---- */

/* 2 x 2 floats whose red is 1 2 / 3 4, top row first. */
static const float four[16] = {1, 0, 0, 1, 2, 0, 0, 1, 3, 0, 0, 1, 4, 0, 0, 1};
static snell_image_texture_desc image_of(const void *pixels, int width, int height, int format,
                                         size_t size) {
    snell_image_texture_desc desc = SNELL_INIT(image_texture_desc);
    desc.width = width;
    desc.height = height;
    desc.format = format;
    desc.pixels = pixels;
    desc.pixels_count = size;
    return desc;
}
enum { RGBA8, RGB8, GRAY8, RGBA32F };
enum { AUTO, UV, OBJECT, XZ, TRIPLANAR, SPHERICAL };

static void an_image_lies_as_documented(void **state) {
    (void)state;
    snell_image_texture_desc desc = image_of(four, 2, 2, RGBA32F, sizeof four);
    static const struct {
        double u, v, red;
    } known[] = {{.25, .75, 1}, {.75, .75, 2},  {.25, .25, 3}, {.75, .25, 4},
                 {.5, .5, 2.5}, {.5, .75, 1.5}, {0, .75, 1.5}, {1.25, -.25, 1}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        texture_point at = at_uv(known[i].u, known[i].v);
        ASSERT_CLOSE(red_at(&texture_image, &desc, &at), known[i].red, 1e-15, 0);
    }
    texture_point corner = at_uv(0, 1);
    desc.wrap_u = desc.wrap_v = 1; /* clamp */
    ASSERT_CLOSE(red_at(&texture_image, &desc, &corner), 1, 0, 0);
    desc.filter = 1; /* nearest */
    texture_point near = at_uv(.49, .51);
    ASSERT_CLOSE(red_at(&texture_image, &desc, &near), 1, 0, 0);
}

/* The same image along each map, at a point where all have known coordinates. */
static void maps_lie_as_documented(void **state) {
    (void)state;
    texture_point at = at_point(.25, .75, .5, (dvec3){0, 0, 1});
    at.u = .75, at.v = .25, at.has_uv = true;
    map_point uv = texture_map(MAP_UV, &at), automatic = texture_map(MAP_AUTO, &at),
              local = texture_map(MAP_OBJECT, &at), xz = texture_map(MAP_XZ, &at);
    assert_true(uv.u == .75 && uv.v == .25 && automatic.u == .75 && automatic.v == .25);
    assert_true(local.u == .25 && local.v == .75 && xz.u == .25 && xz.v == .5);
    at.has_uv = false;
    automatic = texture_map(MAP_AUTO, &at);
    assert_true(automatic.u == .25 && automatic.v == .75);
    static const struct {
        dvec3 p;
        double u, v;
    } known[] = {{{0, 0, 2}, .5, .5}, {{3, 0, 0}, .75, .5}, {{-3, 0, 0}, .25, .5},
                 {{0, 5, 0}, .5, 1},  {{0, -5, 0}, .5, 0},  {{0, 1, 1}, .5, .75},
                 {{0, 0, 0}, .5, .5}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        texture_point there = at_point(known[i].p.x, known[i].p.y, known[i].p.z, (dvec3){0, 1, 0});
        map_point got = texture_map(MAP_SPHERICAL, &there);
        ASSERT_CLOSE(got.u, known[i].u, 0, 1e-7);
        ASSERT_CLOSE(got.v, known[i].v, 0, 1e-7);
    }
}

/* Along +Z it is the projection along z, and halfway to +X the mean of the two. */
static void triplanar_blends_by_the_normal(void **state) {
    (void)state;
    snell_image_texture_desc desc = image_of(four, 2, 2, RGBA32F, sizeof four);
    desc.map = TRIPLANAR;
    texture_point front = at_point(.25, .75, .75, (dvec3){0, 0, 1}), side = front, both = front,
                  top = front, back = front;
    side.n = (dvec3){1, 0, 0};  /* u = -z = .25 when repeated */
    top.n = (dvec3){0, 1, 0};   /* u = x, v = -z */
    back.n = (dvec3){0, 0, -1}; /* u = -x */
    both.n = dvec3_normalize((dvec3){1, 0, 1});
    ASSERT_CLOSE(red_at(&texture_image, &desc, &front), 1, 1e-15, 0);
    ASSERT_CLOSE(red_at(&texture_image, &desc, &side), 1, 1e-15, 0);
    ASSERT_CLOSE(red_at(&texture_image, &desc, &top), 3, 1e-15, 0);
    ASSERT_CLOSE(red_at(&texture_image, &desc, &back), 2, 1e-15, 0);
    both.local.z = .25; /* the side shows u = -.25 = .75: 2 */
    ASSERT_CLOSE(red_at(&texture_image, &desc, &both), 1.5, 1e-15, 0);
}

/* The footprint of a map is the difference of its coordinates. */
static void footprints_of_maps_are_their_gradients(void **state) {
    (void)state;
    static const dvec3 places[] = {{.3, .2, .9}, {-1, .1, .4}, {2, -3, 1}};
    for (size_t i = 0; i < 3; i++)
        for (int map = MAP_OBJECT; map <= MAP_SPHERICAL; map++) {
            const dvec3 step = {1e-3, -2e-3, .5e-3};
            texture_point a = at_point(places[i].x, places[i].y, places[i].z, (dvec3){0, 1, 0}),
                          b = a;
            a.dpdx = step;
            b.local = dvec3_add(a.local, step);
            map_point from = texture_map(map, &a), to = texture_map(map, &b);
            ASSERT_CLOSE(from.dudx, to.u - from.u, 5e-3, 1e-6);
            ASSERT_CLOSE(from.dvdx, to.v - from.v, 5e-3, 1e-6);
            assert_true(from.dudy == 0 && from.dvdy == 0);
        }
}

/* ---- mip maps ---- */

static double channel_mean(const mip_level *l, const mip_format *f, uint32_t channel) {
    double sum = 0;
    for (size_t i = 0; i < (size_t)l->width * l->height; i++) {
        size_t at = i * f->channels + channel;
        if (f->floats)
            sum += (double)((const float *)l->pixels)[at];
        else
            sum +=
                (double)(f->srgb && channel < 3 ? srgb_table()
                                                : unorm_table())[((const uint8_t *)l->pixels)[at]];
    }
    return sum / ((double)l->width * l->height);
}

/* Of any size, also odd ones and single rows. */
static void every_mip_level_keeps_the_mean(void **state) {
    (void)state;
    static const uint32_t sizes[][2] = {{64, 64}, {37, 23}, {1, 9}, {100, 1}, {5, 3}, {1, 1}};
    static float floats[64 * 64 * 4];
    static uint8_t bytes[64 * 64 * 4];
    uint64_t random = 4;
    for (size_t i = 0; i < sizeof bytes; i++) {
        floats[i] = (float)(100 * uniform(&random));
        bytes[i] = (uint8_t)(256 * uniform(&random));
    }
    const mip_format formats[] = {
        {4, true, false}, {4, false, true}, {3, false, false}, {1, false, true}};
    for (size_t s = 0; s < 6; s++)
        for (size_t f = 0; f < 4; f++) {
            mipmap *m;
            const void *pixels = formats[f].floats ? (const void *)floats : bytes;
            MUST(mipmap_create(pixels, sizes[s][0], sizes[s][1], formats[f], &m));
            size_t whole = (size_t)sizes[s][0] * sizes[s][1] * formats[f].channels;
            if (formats[f].floats) whole *= sizeof(float);
            if (sizes[s][0] > 5 && sizes[s][1] > 5)
                assert_true((double)m->bytes < .34 * (double)whole);
            assert_int_equal(m->levels[m->count - 1].width, 1);
            assert_int_equal(m->levels[m->count - 1].height, 1);
            for (uint32_t c = 0; c < formats[f].channels; c++) {
                double mean = channel_mean(&m->levels[0], &formats[f], c);
                for (uint32_t l = 1; l < m->count; l++)
                    ASSERT_CLOSE(channel_mean(&m->levels[l], &formats[f], c), mean,
                                 formats[f].floats ? 1e-6 : 0, formats[f].floats ? 0 : .006);
            }
            mipmap_destroy(m);
        }
}

static void a_plain_image_has_plain_levels(void **state) {
    (void)state;
    for (int value = 0; value < 256; value++) {
        uint8_t bytes[5 * 7 * 3];
        memset(bytes, value, sizeof bytes);
        for (int srgb = 0; srgb < 2; srgb++) {
            mipmap *m;
            MUST(mipmap_create(bytes, 5, 7, (mip_format){3, false, srgb != 0}, &m));
            for (uint32_t l = 1; l < m->count; l++)
                assert_memory_equal(m->levels[l].pixels, bytes,
                                    (size_t)m->levels[l].width * m->levels[l].height * 3);
            mipmap_destroy(m);
        }
    }
}

/* A chessboard of pixels: 1/2 in linear light, whose nearest sRGB byte is 188. */
static void levels_are_made_in_linear_light(void **state) {
    (void)state;
    const uint8_t board[4] = {0, 255, 255, 0};
    snell_image_texture_desc desc = image_of(board, 2, 2, GRAY8, 4);
    texture_point at = at_uv(.3, .8);
    at.dudx = 1;
    ASSERT_CLOSE(red_at(&texture_image, &desc, &at), srgb_decode(188 / 255.), 1e-6, 0);
    at.dudx = INFINITY; /* and no level beyond the last */
    ASSERT_CLOSE(red_at(&texture_image, &desc, &at), srgb_decode(188 / 255.), 1e-6, 0);
    at.dudx = .5; /* a pixel: the image itself */
    texture_point point = at_uv(.3, .8);
    assert_true(red_at(&texture_image, &desc, &at) == red_at(&texture_image, &desc, &point));
    at.dudx = .5 * sqrt(2); /* halfway to the next level */
    ASSERT_CLOSE(red_at(&texture_image, &desc, &at),
                 (red_at(&texture_image, &desc, &point) + srgb_decode(188 / 255.)) / 2, 1e-6, 0);
    at.dudx = 1;
    desc.filter = 1; /* nearest has no mip maps */
    ASSERT_CLOSE(red_at(&texture_image, &desc, &at), 0, 0, 0);
}

static void an_image_of_one_pixel_is_a_colour(void **state) {
    (void)state;
    const uint8_t pixel[4] = {255, 0, 128, 51};
    snell_image_texture_desc desc = image_of(pixel, 1, 1, RGBA8, 4);
    texture_point at = at_uv(17.3, -1e30);
    at.dudx = 1e9;
    texel seen = look_at(&texture_image, &desc, &at);
    assert_true(seen.color.x == 1 && seen.color.y == 0);
    ASSERT_CLOSE(seen.alpha, .2, 1e-7, 0);
}

/* ---- checker, gradient, noise ---- */

static void a_filtered_checker_is_its_mean(void **state) {
    (void)state;
    snell_checker_texture_desc desc = SNELL_INIT(checker_texture_desc);
    desc.color_a = grey(1);
    desc.color_b = grey(0);
    texture_point at = at_uv(.5, .5);
    ASSERT_CLOSE(red_at(&texture_checker, &desc, &at), 1, 0, 0);
    desc.filter = true;
    ASSERT_CLOSE(red_at(&texture_checker, &desc, &at), 1, 1e-9, 0);
    at.dudx = at.dvdy = 2; /* two squares each way */
    ASSERT_CLOSE(red_at(&texture_checker, &desc, &at), .5, 1e-12, 0);
    at = at_uv(1, .5); /* on an edge */
    at.dudx = .5;
    ASSERT_CLOSE(red_at(&texture_checker, &desc, &at), .5, 1e-6, 0);
    at = at_uv(.9, .5); /* from .7 to 1.1: three quarters are white */
    at.dudx = .4;
    ASSERT_CLOSE(red_at(&texture_checker, &desc, &at), .75, 1e-5, 0);
}

static void a_gradient_is_linear(void **state) {
    (void)state;
    snell_gradient_texture_desc desc = SNELL_INIT(gradient_texture_desc);
    texture_point at = at_uv(.9, .25), solid = at_point(7, .75, 3, (dvec3){0, 1, 0});
    ASSERT_CLOSE(red_at(&texture_gradient, &desc, &at), .25, 1e-7, 0);
    ASSERT_CLOSE(red_at(&texture_gradient, &desc, &solid), .75, 1e-15, 0);
    desc.from = v3(1, 0, 0);
    desc.to = v3(3, 2, 0); /* (7, .75, 3) - from along it: 1.6875 */
    ASSERT_CLOSE(red_at(&texture_gradient, &desc, &solid), 1, 0, 0);
    desc.wrap = 1;
    ASSERT_CLOSE(red_at(&texture_gradient, &desc, &solid), .6875, 1e-15, 0);
    desc.wrap = 2;
    ASSERT_CLOSE(red_at(&texture_gradient, &desc, &solid), .3125, 1e-15, 0);
    desc.to = desc.from;
    assert_int_equal(texture_gradient.check(&desc), SNELL_ERR_ARGUMENT);
}

static snell_noise_texture_desc plain_noise(int kind) {
    snell_noise_texture_desc desc = SNELL_INIT(noise_texture_desc);
    desc.octaves = 1;
    desc.kind = kind;
    return desc;
}

/* The mean of what is drawn, and of its absolute value, which turbulence fades to. */
static void noise_has_the_stated_mean(void **state) {
    (void)state;
    enum { COUNT = 400000 };
    snell_noise_texture_desc clouds = plain_noise(0), smoke = plain_noise(1);
    texture a = texture_make(&texture_noise, &clouds), b = texture_make(&texture_noise, &smoke);
    uint64_t random = 3;
    double sum = 0, absolute = 0, least = 1, most = 0;
    for (int i = 0; i < COUNT; i++) {
        double x = 1000 * uniform(&random), y = 1000 * uniform(&random);
        texture_point at = at_point(x, y, 1000 * uniform(&random), (dvec3){0, 1, 0});
        double value = texture_noise.evaluate(&a, &at).color.x;
        sum += value;
        absolute += texture_noise.evaluate(&b, &at).color.x;
        least = double_min(least, value);
        most = double_max(most, value);
    }
    ASSERT_CLOSE(sum / COUNT, .5, 0, 1e-3);
    assert_true(least < .1 && least >= 0 && most > .9 && most <= 1);
    texture_point far = at_point(1.3, 2.4, 3.1, (dvec3){0, 1, 0});
    far.dpdy = (dvec3){0, 0, 2}; /* over the whole octave */
    ASSERT_CLOSE(red_at(&texture_noise, &smoke, &far), absolute / COUNT, 0, 1e-3);
    ASSERT_CLOSE(red_at(&texture_noise, &clouds, &far), .5, 0, 0);
}

/* 1/2 at every corner of a cell; continuous; another seed, another pattern; the same bits for ever. */
static void noise_is_a_function_of_the_place(void **state) {
    (void)state;
    snell_noise_texture_desc desc = plain_noise(0);
    texture_point corner = at_point(3, -2, 5, (dvec3){0, 1, 0});
    ASSERT_CLOSE(red_at(&texture_noise, &desc, &corner), .5, 0, 0);
    texture_point before = at_point(.3, .6, 1 - 1e-9, (dvec3){0, 1, 0}), after = before;
    after.local.z = 1;
    double a = red_at(&texture_noise, &desc, &before), b = red_at(&texture_noise, &desc, &after);
    ASSERT_CLOSE(a, b, 0, 1e-8);
    desc.seed = 1;
    assert_true(fabs(red_at(&texture_noise, &desc, &after) - b) > 1e-3);
    texture_point lost = at_point(1e30, -1e300, 4, (dvec3){0, 1, 0});
    for (desc.kind = 0; desc.kind < 3; desc.kind++) {
        double value = red_at(&texture_noise, &desc, &lost);
        assert_true(value >= 0 && value <= 1);
    }
    desc = SNELL_INIT(noise_texture_desc);
    texture_point known = at_point(.37, -1.91, 12.25, (dvec3){0, 1, 0});
    static const double values[3] = {0x1.b22f9f0ae149ap-3, 0x1.4e8fbe16ea7b3p-1,
                                     0x1.259151302464bp-1};
    for (desc.kind = 0; desc.kind < 3; desc.kind++) {
        double value = red_at(&texture_noise, &desc, &known);
        if (value != values[desc.kind]) printf("kind %d: %a\n", desc.kind, value);
        assert_true(value == values[desc.kind]);
    }
}

/* Stripes of marble without distortion: a sine along x. */
static void marble_is_a_sine(void **state) {
    (void)state;
    snell_noise_texture_desc desc = plain_noise(2);
    desc.distortion = 0;
    desc.size = 2;
    texture_point at = at_point(.5, 9, 9, (dvec3){0, 1, 0});
    ASSERT_CLOSE(red_at(&texture_noise, &desc, &at), 1, 1e-12, 0);
    at.local.x = 1.5;
    ASSERT_CLOSE(red_at(&texture_noise, &desc, &at), 0, 0, 1e-12);
}

/* ---- footprints on shapes ---- */

static shade_point hit_of(const scene *s, const ray *r, const ray_differential *d, hit *h) {
    accel_trace(s->accel, SNELL_ISA_SCALAR, r, h, 1, NULL);
    assert_true(h->instance != NO_ID);
    shade_point p;
    scene_shade_point(s, r, h, &p);
    if (d) scene_set_footprint(s, r, d, h, &p);
    return p;
}

static ray towards(dvec3 from, dvec3 at) {
    return ray_make(vec3_from(from), vec3_from(dvec3_normalize(dvec3_sub(at, from))), 0, INFINITY);
}

static ray_differential difference(const ray *r, const ray *x, const ray *y) {
    return (ray_differential){vec3_sub(x->o, r->o), vec3_sub(x->d, r->d), vec3_sub(y->o, r->o),
                              vec3_sub(y->d, r->d)};
}

static void assert_near(dvec3 got, dvec3 expected, double size, double part, const char *what) {
    double off = dvec3_length(dvec3_sub(got, expected));
    if (off <= part * size) return;
    fprintf(stderr, "%s: (%g %g %g), not (%g %g %g)\n", what, got.x, got.y, got.z, expected.x,
            expected.y, expected.z);
    fail();
}

/* A picture of everything with uvs, turned and stretched, to compare differentials with differences.
 */
static snell_material_id painted(double exponent) {
    static const uint8_t board[4] = {0, 255, 255, 0};
    snell_image_texture_desc image = image_of(board, 2, 2, GRAY8, 4);
    snell_blinn_phong_desc desc = SNELL_INIT(blinn_phong_desc);
    snell_material_id id;
    desc.exponent = (float)exponent;
    MUST(snell_scene_add_image_texture(bench.scene, &image, &desc.color.texture));
    MUST(snell_scene_add_blinn_phong(bench.scene, &desc, &id));
    return id;
}

static snell_shape_id smooth_triangle(void) {
    const snell_vec3 positions[3] = {v3(-1, -1, 0), v3(1, -1, 0.1), v3(0, 1, -0.1)},
                     normals[3] = {v3(-0.4, -0.3, 1), v3(0.5, -0.3, 1), v3(0, 0.6, 1)};
    const snell_vec2 uvs[3] = {{0, 0}, {1, .2f}, {.3f, 1}};
    const uint32_t indices[3] = {0, 1, 2};
    snell_mesh_desc desc = SNELL_INIT(mesh_desc);
    snell_shape_id id;
    desc.positions = positions, desc.positions_count = 3;
    desc.normals = normals, desc.normals_count = 3;
    desc.uvs = uvs, desc.uvs_count = 3;
    desc.indices = indices, desc.indices_count = 3;
    MUST(snell_scene_add_mesh(bench.scene, &desc, &id));
    return id;
}

enum { BODIES = 6 };
static void add_body(int which, snell_material_id m, const snell_transform *at) {
    snell_shape_id id;
    snell_sphere_desc sphere = SNELL_INIT(sphere_desc);
    snell_disk_desc disk = SNELL_INIT(disk_desc);
    snell_quad_desc quad = SNELL_INIT(quad_desc);
    snell_box_desc box = SNELL_INIT(box_desc);
    snell_plane_desc plane = SNELL_INIT(plane_desc);
    disk.normal = v3(0.1, 0.2, 1);
    disk.inner_radius = 0.1f;
    quad.corner = v3(-1, -1, 0), quad.u = v3(2, 0.5, 0), quad.v = v3(0, 2, 0.3);
    box.min = v3(-1, -1, -1), box.max = v3(1, 1, .2);
    plane.normal = v3(0.2, 0.1, 1);
    switch (which) {
    case 0: MUST(snell_scene_add_sphere(bench.scene, &sphere, &id)); break;
    case 1: MUST(snell_scene_add_disk(bench.scene, &disk, &id)); break;
    case 2: MUST(snell_scene_add_quad(bench.scene, &quad, &id)); break;
    case 3: MUST(snell_scene_add_box(bench.scene, &box, &id)); break;
    case 4: MUST(snell_scene_add_plane(bench.scene, &plane, &id)); break;
    default: id = smooth_triangle(); break;
    }
    MUST(snell_scene_add_instance(bench.scene, id, m, at, NULL));
}

static const snell_transform askew = {
    {{1.2f, 0.1f, 0, 0.3f}, {-0.2f, 0.9f, 0.3f, 0}, {0, 0.2f, 1, -1}}};

/* dp, du, dv and dn of neighbours are what their rays find. */
static void footprints_are_what_neighbours_hit(void **state) {
    (void)state;
    for (int which = 0; which < BODIES; which++) {
        rig_clear(&bench);
        add_body(which, painted(10), &askew);
        commit();
        const scene *s = bench.scene->frozen;
        assert_true(s->needs_footprint);
        const double step = 2e-3;
        dvec3 from = {0.5, 0.4, 4}, at = {0.45, 0.2, -1};
        ray r = towards(from, at), x = towards(from, dvec3_add(at, (dvec3){step, 0, 0})),
            y = towards(from, dvec3_add(at, (dvec3){0, step, 0}));
        ray_differential d = difference(&r, &x, &y);
        hit h;
        shade_point p = hit_of(s, &r, &d, &h), px = hit_of(s, &x, NULL, &h),
                    py = hit_of(s, &y, NULL, &h);
        assert_true(p.has_footprint);
        double size = dvec3_length(p.dpdx);
        assert_near(p.dpdx, dvec3_sub(px.p, p.p), size, 5e-3, "dp/dx");
        assert_near(p.dpdy, dvec3_sub(py.p, p.p), size, 5e-3, "dp/dy");
        assert_near(p.dndx, dvec3_sub(px.ns, p.ns), size, 1e-2, "dn/dx");
        assert_near(p.dndy, dvec3_sub(py.ns, p.ns), size, 1e-2, "dn/dy");
        const texture_point *a = &p.at.at;
        double unit = fabs(a->dudx) + fabs(a->dvdx) + fabs(a->dudy) + fabs(a->dvdy);
        assert_true(unit > 0);
        ASSERT_CLOSE(a->dudx, px.at.at.u - a->u, 0, 1e-2 * unit);
        ASSERT_CLOSE(a->dvdx, px.at.at.v - a->v, 0, 1e-2 * unit);
        ASSERT_CLOSE(a->dudy, py.at.at.u - a->u, 0, 1e-2 * unit);
        ASSERT_CLOSE(a->dvdy, py.at.at.v - a->v, 0, 1e-2 * unit);
        /* dpdu and dpdv carry the coordinates' change to the world. */
        dvec3 moved = dvec3_add(dvec3_scale(p.dpdu, a->dudx), dvec3_scale(p.dpdv, a->dvdx));
        assert_near(moved, p.dpdx, size, 1e-6, "dp/du du + dp/dv dv");
    }
}

/* ---- ray differentials ---- */

static dvec3 bounced(const shade_point *p, double eta) {
    dvec3 d = reflect_direction(p->wo, p->ns);
    if (eta > 0) assert_true(refract_direction(p->wo, p->ns, eta, &d));
    return d;
}

/* The child's differential is the difference of the neighbours' children, off flat, round, stretched
 * and smooth-shaded surfaces, by reflection and by refraction. */
static void differentials_follow_the_neighbours(void **state) {
    (void)state;
    static const double etas[] = {0, 1 / 1.5, 1.5};
    for (int i = 0; i < BODIES * 3; i++) {
        double eta = etas[i / BODIES];
        rig_clear(&bench);
        add_body(i % BODIES, painted(10), &askew);
        commit();
        const scene *s = bench.scene->frozen;
        const double step = 1e-3;
        dvec3 from = {0.5, 0.4, 4}, at = {0.45, 0.2, -1};
        ray r = towards(from, at), x = towards(from, dvec3_add(at, (dvec3){step, 0, 0})),
            y = towards(from, dvec3_add(at, (dvec3){0, step, 0}));
        path_ray parent = {
            .ray = r, .differential = difference(&r, &x, &y), .has_differential = true};
        hit h;
        shade_point p = hit_of(s, &r, &parent.differential, &h), px = hit_of(s, &x, NULL, &h),
                    py = hit_of(s, &y, NULL, &h);
        path_ray child = {.depth = 0};
        scene_spawn_ray(&p, bounced(&p, eta), INFINITY, &child.ray);
        if (eta > 0)
            differential_of_interface(&parent, &p, eta, &child);
        else
            differential_of_mirror(&parent, &p, p.ns, &child);
        assert_true(child.has_differential);
        dvec3 dx = dvec3_sub(bounced(&px, eta), bounced(&p, eta)),
              dy = dvec3_sub(bounced(&py, eta), bounced(&p, eta));
        assert_near(dvec3_from(child.differential.ddx), dx, dvec3_length(dx) + 1e-4, 1e-2, "dd/dx");
        assert_near(dvec3_from(child.differential.ddy), dy, dvec3_length(dy) + 1e-4, 1e-2, "dd/dy");
    }
}

/* In a flat mirror the footprint is that of the eye behind it. */
static void a_flat_mirror_changes_no_footprint(void **state) {
    (void)state;
    snell_material_id paint = painted(10);
    add_quad(&bench, v3(-5, -1, -5), v3(10, 0, 0), v3(0, 0, 10), add_mirror(&bench, grey(1)));
    add_quad(&bench, v3(3, -9, -5), v3(0, 0, 10), v3(0, 18, 0), paint);
    commit();
    const scene *s = bench.scene->frozen;
    dvec3 eye = {-2, 2, 0}, behind = {-2, -4, 0};
    ray r = towards(eye, (dvec3){0, -1, .3}), x = towards(eye, (dvec3){.01, -1, .3}),
        y = towards(eye, (dvec3){0, -1, .31});
    path_ray parent = {.ray = r, .differential = difference(&r, &x, &y), .has_differential = true};
    hit h;
    shade_point p = hit_of(s, &r, &parent.differential, &h);
    path_ray child = {.depth = 0};
    scene_spawn_ray(&p, bounced(&p, 0), INFINITY, &child.ray);
    differential_of_mirror(&parent, &p, p.ns, &child);
    shade_point seen = hit_of(s, &child.ray, &child.differential, &h);
    ray direct = towards(behind, (dvec3){0, -1, .3});
    ray dx = towards(behind, (dvec3){.01, -1, .3}), dy = towards(behind, (dvec3){0, -1, .31});
    ray_differential d = difference(&direct, &dx, &dy);
    direct.t_min = 4; /* past the mirror */
    shade_point expected = hit_of(s, &direct, &d, &h);
    assert_near(seen.p, expected.p, 1, 1e-5, "place");
    double size = dvec3_length(expected.dpdx);
    assert_near(seen.dpdx, expected.dpdx, size, 1e-4, "dp/dx");
    assert_near(seen.dpdy, expected.dpdy, size, 1e-4, "dp/dy");
    ASSERT_CLOSE(seen.at.at.dudx, expected.at.at.dudx, 1e-3, 1e-7);
    ASSERT_CLOSE(seen.at.at.dvdy, expected.at.at.dvdy, 1e-3, 1e-7);
}

/* ---- pictures ---- */

/* A glowing floor of black and white squares towards the horizon. */
static void build_board(int filter) {
    enum { SIDE = 64 };
    static uint8_t pixels[SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE; i++) pixels[i] = (i % SIDE / 8 + i / SIDE / 8) % 2 ? 255 : 0;
    snell_image_texture_desc image = image_of(pixels, SIDE, SIDE, GRAY8, sizeof pixels);
    snell_lambert_desc desc = SNELL_INIT(lambert_desc);
    snell_material_id id;
    image.map = XZ;
    image.filter = filter;
    desc.color = flat(grey(0));
    MUST(snell_scene_add_image_texture(bench.scene, &image, &desc.emission.texture));
    desc.emission.value = grey(1);
    MUST(snell_scene_add_lambert(bench.scene, &desc, &id));
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), id);
    commit();
}

static double spread_near_horizon(void) {
    snell_render_desc desc = picture(SNELL_WHITTED, 64, 64, 1);
    snell_view view = look(v3(0.3, 1, 0), v3(0.37, 0.5, -10)); /* every pixel meets the floor */
    view.fov = 0.05f;
    desc.view = &view;
    desc.pixel_center = false;
    MUST(snell_render(bench.scene, &desc, bench.film));
    double sum = 0, squares = 0;
    for (uint32_t y = 0; y < 64; y++)
        for (uint32_t x = 0; x < 64; x++) {
            double value = pixel_at(&bench, x, y).c[0];
            sum += value;
            squares += value * value;
        }
    double mean = sum / 4096;
    ASSERT_CLOSE(mean, 0.5, 0, 0.04);
    return squares / 4096 - mean * mean;
}

static void a_far_board_does_not_alias(void **state) {
    (void)state;
    build_board(1); /* nearest: the variance of black and white */
    double aliased = spread_near_horizon();
    assert_true(aliased > 0.2);
    rig_clear(&bench);
    build_board(0);
    double filtered = spread_near_horizon();
    if (!(filtered < 0.01)) printf("variance %g\n", filtered);
    assert_true(filtered < 0.01);
}

/* ---- normal maps and bump ---- */

static snell_texture_id add_normals(int x, int y, int z) {
    uint8_t pixels[2 * 2 * 3];
    for (int i = 0; i < 4; i++) {
        pixels[3 * i] = (uint8_t)x;
        pixels[3 * i + 1] = (uint8_t)y;
        pixels[3 * i + 2] = (uint8_t)z;
    }
    snell_image_texture_desc image = image_of(pixels, 2, 2, RGB8, sizeof pixels);
    snell_texture_id id;
    image.encoding = 1; /* linear */
    MUST(snell_scene_add_image_texture(bench.scene, &image, &id));
    return id;
}

static uint64_t hash_of_bodies(bool mapped, int x) {
    snell_blinn_phong_desc desc = SNELL_INIT(blinn_phong_desc);
    snell_material_id id;
    rig_clear(&bench);
    snell_texture_id map = add_normals(x, x, 255);
    if (mapped) desc.normal_map = map;
    MUST(snell_scene_add_blinn_phong(bench.scene, &desc, &id));
    add_body(0, id, &askew);
    add_body(5, id, NULL);
    add_body(4, id, &askew);
    add_sun(&bench, v3(-1, -1, -1), grey(1));
    commit();
    snell_render_desc render = picture(SNELL_WHITTED, 40, 30, 1);
    snell_view view = look(v3(0, 0.5, 5), v3(0, 0, 0));
    render.view = &view;
    MUST(snell_render(bench.scene, &render, bench.film));
    return snell_film_hash(bench.film);
}

static void a_flat_normal_map_changes_nothing(void **state) {
    (void)state;
    uint64_t plain = hash_of_bodies(false, 128);
    assert_true(hash_of_bodies(true, 128) == plain);
    assert_true(hash_of_bodies(true, 127) == plain);
    assert_true(hash_of_bodies(true, 140) != plain);
}

/* The shading normal of the front of a quad in z = 0 (or of its back), whose u is x and v is y. */
static dvec3 bent_normal(const snell_lambert_desc *desc, bool back) {
    snell_material_id id;
    MUST(snell_scene_add_lambert(bench.scene, desc, &id));
    add_quad(&bench, v3(-1, -1, 0), v3(2, 0, 0), v3(0, 2, 0), id);
    commit();
    dvec3 eye = {0.1, 0.2, back ? -3 : 3};
    ray r = towards(eye, (dvec3){0.1, 0.2, 0});
    hit h;
    shade_point p = hit_of(bench.scene->frozen, &r, NULL, &h);
    assert_true(p.material->bends);
    scene_bend_normal(bench.scene->frozen, &p);
    ASSERT_CLOSE(dvec3_length(p.ns), 1, 1e-12, 0);
    assert_true(dvec3_dot(p.ns, p.n) > 0 && dvec3_dot(p.ns, p.wo) > 0);
    return p.ns;
}

/* Red leans along u, green along v; the back is the same surface seen from behind. */
static void a_normal_map_leans_as_it_says(void **state) {
    (void)state;
    for (int back = 0; back < 2; back++) {
        snell_lambert_desc desc = SNELL_INIT(lambert_desc);
        rig_clear(&bench);
        desc.normal_map = add_normals(128 + 64, 128, 128 + 64);
        dvec3 n = bent_normal(&desc, back);
        double sign = back ? -1 : 1;
        ASSERT_CLOSE(n.x / n.z, 1, 2e-2, 0);
        ASSERT_CLOSE(n.y, 0, 0, 1e-12);
        assert_true(n.z * sign > 0);
        rig_clear(&bench);
        desc.normal_map = add_normals(128, 128 - 64, 128 + 64);
        desc.normal_scale = flat(grey(0.5));
        n = bent_normal(&desc, back);
        ASSERT_CLOSE(n.y / n.z, -0.5, 2e-2, 0);
        ASSERT_CLOSE(n.x, 0, 0, 1e-12);
    }
    /* Below the surface: kept above it. */
    snell_lambert_desc desc = SNELL_INIT(lambert_desc);
    rig_clear(&bench);
    desc.normal_map = add_normals(255, 128, 0);
    dvec3 n = bent_normal(&desc, false);
    assert_true(n.z > 0 && n.x > 0.9);
}

/* ---- a coat over them ---- */

static shade_point bent_point(const snell_principled_desc *desc, bool back) {
    snell_material_id id;
    MUST(snell_scene_add_principled(bench.scene, desc, &id));
    add_quad(&bench, v3(-1, -1, 0), v3(2, 0, 0), v3(0, 2, 0), id);
    commit();
    ray r = towards((dvec3){0.1, 0.2, back ? -3 : 3}, (dvec3){0.1, 0.2, 0});
    hit h;
    shade_point p = hit_of(bench.scene->frozen, &r, NULL, &h);
    assert_true(p.material->bends);
    scene_bend_normal(bench.scene->frozen, &p);
    return p;
}

/* What bends the base leaves the coat as it is, and the other way about; bump is the base's. */
static void a_coat_has_its_own_normal(void **state) {
    (void)state;
    for (int back = 0; back < 2; back++) {
        snell_principled_desc desc = SNELL_INIT(principled_desc);
        double sign = back ? -1 : 1;
        rig_clear(&bench);
        desc.normal_map = add_normals(128 + 64, 128, 128 + 64);
        shade_point p = bent_point(&desc, back);
        assert_false(p.at.coat.own); /* no coat */
        desc.clearcoat = flat(grey(1));
        rig_clear(&bench);
        desc.normal_map = add_normals(128 + 64, 128, 128 + 64);
        p = bent_point(&desc, back);
        assert_true(p.at.coat.own);
        ASSERT_CLOSE(p.ns.x / p.ns.z, 1, 2e-2, 0);
        ASSERT_CLOSE(p.at.coat.n.z, sign, 1e-12, 0);
        ASSERT_CLOSE(p.at.coat.side.z, sign, 1e-12, 0);
        rig_clear(&bench);
        desc.normal_map = (snell_texture_id){0, 0};
        desc.clearcoat_normal_map = add_normals(128, 128 + 64, 128 + 64);
        desc.clearcoat_normal_scale = flat(grey(0.5));
        p = bent_point(&desc, back);
        ASSERT_CLOSE(p.ns.z, sign, 1e-12, 0);
        ASSERT_CLOSE(p.at.coat.n.y / p.at.coat.n.z, 0.5, 2e-2, 0);
        ASSERT_CLOSE(p.at.coat.n.x, 0, 0, 1e-12);
        rig_clear(&bench); /* below the surface: kept above it */
        desc.clearcoat_normal_map = add_normals(255, 128, 0);
        desc.clearcoat_normal_scale = flat(grey(1));
        p = bent_point(&desc, back);
        assert_true(p.at.coat.n.z * sign > 0 && fabs(p.at.coat.n.x) > 0.9);
    }
}

/* One part of a mix is coated: its coat does not bend with the mix. */
static void a_coat_in_a_mix_stays_smooth(void **state) {
    (void)state;
    snell_principled_desc coated = SNELL_INIT(principled_desc);
    snell_mix_desc mix = SNELL_INIT(mix_desc);
    snell_material_id id;
    coated.clearcoat = flat(grey(1));
    MUST(snell_scene_add_principled(bench.scene, &coated, &mix.a));
    mix.b = add_lambert(&bench, grey(0.5));
    mix.normal_map = add_normals(128 + 64, 128, 128 + 64);
    MUST(snell_scene_add_mix(bench.scene, &mix, &id));
    add_quad(&bench, v3(-1, -1, 0), v3(2, 0, 0), v3(0, 2, 0), id);
    commit();
    ray r = towards((dvec3){0.1, 0.2, 3}, (dvec3){0.1, 0.2, 0});
    hit h;
    shade_point p = hit_of(bench.scene->frozen, &r, NULL, &h);
    scene_bend_normal(bench.scene->frozen, &p);
    assert_true(p.at.coat.own);
    ASSERT_CLOSE(p.at.coat.n.z, 1, 1e-12, 0);
    ASSERT_CLOSE(p.ns.x / p.ns.z, 1, 2e-2, 0);
}

/* A smooth coat over black that leans shows the lamp that a flat one would, where every mirror image is
 * Fresnel's part of 1; one that leans by its own map does not. */
static void a_coat_mirrors_by_its_own_normal(void **state) {
    (void)state;
    static const snell_integrator all[] = {SNELL_WHITTED, SNELL_COOK, SNELL_PATH};
    const double seen = 0.04 + 0.96 * pow(1 - sqrt(0.5), 5);
    for (int own = 0; own < 2; own++)
        for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
            snell_principled_desc desc = SNELL_INIT(principled_desc);
            snell_material_id id;
            rig_clear(&bench);
            desc.base_color = flat(grey(0));
            desc.specular = flat(grey(0));
            desc.clearcoat = flat(grey(1));
            snell_texture_id lean = add_normals(128, 128 + 96, 128 + 64);
            *(own ? &desc.clearcoat_normal_map : &desc.normal_map) = lean;
            MUST(snell_scene_add_principled(bench.scene, &desc, &id));
            add_quad(&bench, v3(-1, -1, 0), v3(2, 0, 0), v3(0, 2, 0), id);
            /* At the end of the flat mirror's ray, across it. */
            add_quad(&bench, v3(1.9, -0.2, 1.5), v3(0, 0.4, 0), v3(0, 0, 0.8),
                     add_glow(&bench, grey(1)));
            commit();
            snell_render_desc render = picture(all[i], 1, 1, 4);
            snell_view view = look(v3(-2, 0, 2), v3(0, 0, 0));
            render.view = &view;
            render.samples = 4096;
            MUST(snell_render(bench.scene, &render, bench.film));
            ASSERT_CLOSE(pixel_at(&bench, 0, 0).c[0], own ? 0 : seen, 0.03, 1e-6);
        }
}

/* ---- what a mesh brings: a second set of texture coordinates, tangents ---- */

enum { UV2 = 6 };
static const snell_vec3 board[] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0},
                                   {-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
static const uint32_t board_indices[] = {0, 1, 2, 0, 2, 3};

static snell_mesh_desc board_of(bool deforming) {
    static const float times[] = {0, 1};
    snell_mesh_desc desc = SNELL_INIT(mesh_desc);
    desc.positions = board;
    desc.positions_count = deforming ? 8 : 4;
    desc.indices = board_indices;
    desc.indices_count = 6;
    desc.key_times = times;
    desc.key_times_count = deforming ? 2 : 0;
    return desc;
}

/* Red on the left, green on the right by the second set; by the first all red. */
static void a_second_set_is_looked_up(void **state) {
    (void)state;
    static const uint8_t pixels[] = {255, 0, 0, 0, 255, 0};
    static const snell_vec2 first[] = {{0.25f, 0.5f}, {0.25f, 0.5f}, {0.25f, 0.5f}, {0.25f, 0.5f}},
                            second[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int way = 0; way < 3; way++) { /* the last has no second set */
        rig_clear(&bench);
        snell_image_texture_desc image = image_of(pixels, 2, 1, RGB8, sizeof pixels);
        snell_lambert_desc glow = SNELL_INIT(lambert_desc);
        snell_mesh_desc mesh = board_of(way == 1);
        snell_material_id id;
        snell_shape_id shape;
        image.map = UV2;
        image.filter = 1; /* nearest */
        MUST(snell_scene_add_image_texture(bench.scene, &image, &glow.emission.texture));
        glow.emission.value = grey(1);
        MUST(snell_scene_add_lambert(bench.scene, &glow, &id));
        mesh.uvs = first;
        mesh.uvs_count = 4;
        mesh.uvs2 = second;
        mesh.uvs2_count = way < 2 ? 4 : 0;
        MUST(snell_scene_add_mesh(bench.scene, &mesh, &shape));
        place(&bench, shape, id);
        commit();
        rgb left = trace_ray(&bench, SNELL_WHITTED, v3(-0.5, 0.1, 3), v3(-0.5, 0.1, 0), 0),
            right = trace_ray(&bench, SNELL_WHITTED, v3(0.5, 0.1, 3), v3(0.5, 0.1, 0), 0);
        ASSERT_CLOSE(left.c[0], 1, 1e-3, 0);
        ASSERT_CLOSE(right.c[0], way < 2 ? 0 : 1, 0, 1e-3);
        ASSERT_CLOSE(right.c[1], way < 2 ? 1 : 0, 0, 1e-3);
    }
}

/* t = +y, and green along -1 times n x t = +x, whatever the texture coordinates say; and the grain. */
static void tangents_of_a_mesh_count(void **state) {
    (void)state;
    static const float tangents[] = {0, 2, 0, -1, 0, 2, 0, -1, 0, 2, 0, -1, 0, 2, 0, -1};
    static const snell_vec2 uvs[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int green = 0; green < 2; green++) {
        rig_clear(&bench);
        snell_principled_desc desc = SNELL_INIT(principled_desc);
        snell_mesh_desc mesh = board_of(false);
        snell_material_id id;
        snell_shape_id shape;
        desc.normal_map =
            green ? add_normals(128, 128 + 64, 128 + 64) : add_normals(128 + 64, 128, 128 + 64);
        desc.anisotropy = flat(grey(0.5));
        MUST(snell_scene_add_principled(bench.scene, &desc, &id));
        mesh.uvs = uvs;
        mesh.uvs_count = 4;
        mesh.tangents = tangents;
        mesh.tangents_count = 16;
        MUST(snell_scene_add_mesh(bench.scene, &mesh, &shape));
        place(&bench, shape, id);
        commit();
        ray r = towards((dvec3){0.1, 0.2, 3}, (dvec3){0.1, 0.2, 0});
        hit h;
        shade_point p = hit_of(bench.scene->frozen, &r, NULL, &h);
        scene_bend_normal(bench.scene->frozen, &p);
        ASSERT_CLOSE(p.ns.y / p.ns.z, green ? 0 : 1, 2e-2, 1e-12);
        ASSERT_CLOSE(p.ns.x / p.ns.z, green ? 1 : 0, 2e-2, 1e-12);
        ASSERT_CLOSE(dvec3_length(p.at.tangent), 1, 1e-6, 0);
        ASSERT_CLOSE(dvec3_dot(p.at.tangent, p.ns), 0, 0, 1e-6);
        assert_true(p.at.tangent.y > 0.6 && p.at.bitangent.x > 0.6);
    }
}

/* A ramp of s metres per metre tilts by atan(s): by the gradient texture in object space, by an
 * image over u, v, and in a stretched instance. */
static void a_ramp_tilts_by_its_slope(void **state) {
    (void)state;
    static const double slopes[] = {0.25, 1, -3};
    for (int i = 0; i < 3; i++) {
        snell_gradient_texture_desc ramp = SNELL_INIT(gradient_texture_desc);
        snell_lambert_desc desc = SNELL_INIT(lambert_desc);
        rig_clear(&bench);
        ramp.map = OBJECT;
        ramp.from = v3(-8, 0, 0);
        ramp.to = v3(8, 0, 0);
        ramp.color_b = grey(16);
        MUST(snell_scene_add_gradient_texture(bench.scene, &ramp, &desc.bump.texture));
        desc.bump.value = grey(1);
        desc.bump_scale = (float)slopes[i];
        dvec3 n = bent_normal(&desc, false);
        ASSERT_CLOSE(fn_atan2(-n.x, n.z), fn_atan(slopes[i]), 1e-9, 0);
        ASSERT_CLOSE(n.y, 0, 0, 1e-9);
        rig_clear(&bench);
        MUST(snell_scene_add_gradient_texture(bench.scene, &ramp, &desc.bump.texture));
        n = bent_normal(&desc, true); /* a hill is a hollow from behind */
        ASSERT_CLOSE(fn_atan2(n.x, -n.z), fn_atan(slopes[i]), 1e-9, 0);
    }
    /* Two pixels of 0 and 1, clamped: between their centres, 1 m apart, the height is linear in u. */
    const uint8_t pixels[2] = {0, 255};
    snell_image_texture_desc image = image_of(pixels, 2, 1, GRAY8, 2);
    snell_lambert_desc desc = SNELL_INIT(lambert_desc);
    rig_clear(&bench);
    image.encoding = 1;
    image.wrap_u = 1;
    MUST(snell_scene_add_image_texture(bench.scene, &image, &desc.bump.texture));
    desc.bump.value = grey(0.5);
    dvec3 n = bent_normal(&desc, false);
    ASSERT_CLOSE(-n.x / n.z, 0.5, 2e-3, 0);
}

/* ---- pictures of floats ---- */

/* What the codecs write is read bit for bit; what is cut off anywhere is an error, never a crash. */
static void float_pictures_come_back(void **state) {
    (void)state;
    enum { WIDTH = 13, HEIGHT = 21 };
    static float pixels[WIDTH * HEIGHT * 3];
    uint64_t random = 8;
    for (size_t i = 0; i < WIDTH * HEIGHT * 3; i++) pixels[i] = (float)(1e3 * uniform(&random));
    static const char *const names[] = {"pfm", "exr"};
    for (int f = 0; f < (SNELL_HAS_OPENEXR ? 2 : 1); f++) {
        const image_codec *codec;
        void *data;
        size_t size;
        decoded_image image;
        MUST(image_codec_find(names[f], &codec));
        MUST(image_encode(codec, &(image_pixels){pixels, WIDTH, HEIGHT, 3}, &(image_options){0},
                          &data, &size));
        assert_true(image_is_float(data, size));
        MUST(image_decode_float(data, size, IMAGE_SIZE_MAX, &image));
        assert_true(image.width == WIDTH && image.height == HEIGHT && image.channels == 4);
        const float *got = (const float *)(const void *)image.pixels;
        for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
            assert_memory_equal(got + 4 * i, pixels + 3 * i, 3 * sizeof(float));
            assert_true(got[4 * i + 3] == 1);
        }
        image_free(&image);
        assert_int_equal(image_decode_float(data, size, 100, &image), SNELL_ERR_MEMORY);
        for (size_t cut = 4; cut < size; cut++)
            assert_true(image_decode_float(data, cut, IMAGE_SIZE_MAX, &image) != SNELL_OK);
        free(data);
    }
}

#define HDR_HEAD "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"

static void radiance_pictures_are_read(void **state) {
    (void)state;
    /* Eight pixels: a run of red 128, literal greens, no blue, the exponent of 1/256. */
    static const char coded[] = HDR_HEAD "-Y 1 +X 8\n\2\2\0\10\210\200"
                                         "\10\1\2\3\4\5\6\7\10\210\0\210\210";
    static const char plain[] = HDR_HEAD "-Y 2 +X 2\n\200\100\0\201\1\1\1\1"
                                         "\0\0\0\0\20\20\20\210";
    decoded_image image;
    MUST(image_decode_float(coded, sizeof coded - 1, IMAGE_SIZE_MAX, &image));
    const float *p = (const float *)(const void *)image.pixels;
    for (int x = 0; x < 8; x++)
        assert_true(p[4 * x] == 128 && p[4 * x + 1] == (float)(x + 1) && p[4 * x + 2] == 0);
    image_free(&image);
    MUST(image_decode_float(plain, sizeof plain - 1, IMAGE_SIZE_MAX, &image));
    p = (const float *)(const void *)image.pixels;
    assert_true(p[0] == 1 && p[1] == .5f && p[4] == 1 && p[8] == 0 && p[12] == 16);
    image_free(&image);
    for (size_t cut = 3; cut < sizeof coded - 1; cut++)
        assert_true(image_decode_float(coded, cut, IMAGE_SIZE_MAX, &image) != SNELL_OK);
    static const char *const bad[] = {HDR_HEAD "-Y 0 +X 8\n", HDR_HEAD "+X 8 -Y 8\n",
                                      HDR_HEAD "-Y 16384 +X 8192\n",
                                      "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n...."};
    for (size_t i = 0; i < 4; i++)
        assert_true(image_decode_float(bad[i], strlen(bad[i]), IMAGE_SIZE_MAX, &image) != SNELL_OK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_image_lies_as_documented),
        cmocka_unit_test(maps_lie_as_documented),
        cmocka_unit_test(triplanar_blends_by_the_normal),
        cmocka_unit_test(footprints_of_maps_are_their_gradients),
        cmocka_unit_test(every_mip_level_keeps_the_mean),
        cmocka_unit_test(a_plain_image_has_plain_levels),
        cmocka_unit_test(levels_are_made_in_linear_light),
        cmocka_unit_test(an_image_of_one_pixel_is_a_colour),
        cmocka_unit_test(float_pictures_come_back),
        cmocka_unit_test(radiance_pictures_are_read),
        cmocka_unit_test(a_filtered_checker_is_its_mean),
        cmocka_unit_test(a_gradient_is_linear),
        cmocka_unit_test(noise_has_the_stated_mean),
        cmocka_unit_test(noise_is_a_function_of_the_place),
        cmocka_unit_test(marble_is_a_sine),
        cmocka_unit_test_setup(footprints_are_what_neighbours_hit, fresh),
        cmocka_unit_test_setup(differentials_follow_the_neighbours, fresh),
        cmocka_unit_test_setup(a_flat_mirror_changes_no_footprint, fresh),
        cmocka_unit_test_setup(a_far_board_does_not_alias, fresh),
        cmocka_unit_test_setup(a_flat_normal_map_changes_nothing, fresh),
        cmocka_unit_test_setup(a_normal_map_leans_as_it_says, fresh),
        cmocka_unit_test_setup(a_coat_has_its_own_normal, fresh),
        cmocka_unit_test_setup(a_coat_in_a_mix_stays_smooth, fresh),
        cmocka_unit_test_setup(a_coat_mirrors_by_its_own_normal, fresh),
        cmocka_unit_test_setup(a_second_set_is_looked_up, fresh),
        cmocka_unit_test_setup(tangents_of_a_mesh_count, fresh),
        cmocka_unit_test_setup(a_ramp_tilts_by_its_slope, fresh),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
