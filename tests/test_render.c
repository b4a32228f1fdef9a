/* The film, the sample points, and what snell_render promises: dropped weight, depth, progress,
 * cancelling, no edits meanwhile, errors for bad arguments, no surface that shadows itself. */
#include <fenv.h>
#include <pthread.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>

#include "image/film.h"
#include "render_test.h"
#include "sampling/sampling.h"

static const double PI_ = 3.14159265358979323846;
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

/* ---- the film ---- */

static void fixed_point_is_exact(void **state) {
    (void)state;
    uint64_t random = 1, overflows = 0;
    for (int i = 0; i < 100000; i++) {
        double value = (uniform(&random) - 0.5) * exp2(120 * uniform(&random) - 80);
        if (fabs(value) >= 0x1p46) continue;
        /* The product with 2^80 is exact, the conversion truncates. */
        assert_true(fixed_from(value, &overflows) == (fixed128)(value * 0x1p80));
    }
    static const double small[] = {0,         -0.0,    0x1p-80,   -0x1p-80,
                                   0x1.8p-80, 0x1p-81, 0x1p-1074, 0x1.fffffffffffffp45};
    for (size_t i = 0; i < sizeof small / sizeof small[0]; i++)
        assert_true(fixed_from(small[i], &overflows) == (fixed128)(small[i] * 0x1p80));
    assert_int_equal(overflows, 0);
    static const double refused[] = {NAN, INFINITY, -INFINITY, 0x1p46, -0x1p46, 1e300};
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        assert_true(fixed_from(refused[i], &overflows) == 0);
        assert_int_equal(overflows, i + 1);
    }
}

static void sums_do_not_depend_on_order(void **state) {
    (void)state;
    enum { COUNT = 4096 };
    static double values[COUNT];
    static film_block block;
    uint64_t random = 9;
    for (int i = 0; i < COUNT; i++) values[i] = uniform(&random) * exp2(60 * uniform(&random) - 40);
    fixed128 expected = 0;
    double in_order = 0, shuffled = 0;
    for (int round = 0; round < 20; round++) {
        film_block_clear(&block);
        shuffled = 0;
        for (int i = 0; i < COUNT; i++) {
            film_block_add(&block, 3, (dvec3){values[i], 0, 1});
            shuffled += values[i];
        }
        if (round == 0) {
            expected = block.sums[3][0];
            in_order = shuffled;
        }
        assert_true(block.sums[3][0] == expected);
        assert_true(block.sums[3][2] == (fixed128)COUNT << 80);
        for (int i = COUNT - 1; i > 0; i--) {
            int j = (int)(uniform(&random) * (i + 1));
            double swap = values[i];
            values[i] = values[j];
            values[j] = swap;
        }
    }
    assert_true(shuffled != in_order); /* which doubles would not have managed */
}

static void a_full_sum_stays_full(void **state) {
    (void)state;
    static film_block block;
    film_block_clear(&block);
    for (int i = 0; i < 1000; i++) film_block_add(&block, 0, (dvec3){0x1.8p45, 1, -0x1.8p45});
    assert_true(fixed_to(block.sums[0][0]) == 0x1p47);
    assert_true(fixed_to(block.sums[0][1]) == 1000);
    assert_true(fixed_to(block.sums[0][2]) == -0x1p47);
    assert_true(block.overflows > 0);
}

static void no_nan_reaches_the_film(void **state) {
    (void)state;
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_glow(&bench, grey(3e38)));
    add_point(&bench, v3(0, 1e-30, 0), grey(3e38)); /* too near: infinite */
    commit();
    rgb got = trace_ray(&bench, SNELL_WHITTED, v3(0, 1, 0), v3(0, 0, 0), 1);
    assert_true(got.c[0] == 0);
    assert_true(stats_of(&bench).film_overflows > 0);
}

/* ---- sample points ---- */

/* A (0, k, 2)-net in base 2: each of the 2^k boxes of every shape 2^-a x 2^-(k-a) holds one point. */
static bool is_net(uint64_t stream, unsigned k) {
    static unsigned char found[1 << 10];
    for (unsigned a = 0; a <= k; a++) {
        memset(found, 0, sizeof found);
        for (uint32_t i = 0; i < 1u << k; i++) {
            sample2 s = sample_point(stream, i);
            uint32_t column = (uint32_t)(s.x * (1u << a)), row = (uint32_t)(s.y * (1u << (k - a)));
            if (found[column << (k - a) | row]++) return false;
        }
    }
    return true;
}

static void prefixes_are_nets(void **state) {
    (void)state;
    for (uint32_t pixel = 0; pixel < 50; pixel++) {
        uint64_t stream = sample_stream(sample_pixel_stream(pixel / 10, pixel, 7 * pixel),
                                        PATH_CODE_CAMERA, SAMPLE_PIXEL);
        for (unsigned k = 0; k <= 10; k++) assert_true(is_net(stream, k));
    }
}

static void streams_differ_and_are_uniform(void **state) {
    (void)state;
    enum { STREAMS = 20000 };
    sample2 first = sample_point(
        sample_stream(sample_pixel_stream(1, 2, 3), PATH_CODE_CAMERA, SAMPLE_PIXEL), 0);
    const uint64_t others[] = {
        sample_stream(sample_pixel_stream(2, 2, 3), PATH_CODE_CAMERA, SAMPLE_PIXEL),
        sample_stream(sample_pixel_stream(1, 3, 2), PATH_CODE_CAMERA, SAMPLE_PIXEL),
        sample_stream(sample_pixel_stream(1, 2, 4), PATH_CODE_CAMERA, SAMPLE_PIXEL),
        sample_stream(sample_pixel_stream(1, 2, 3), path_code_child(PATH_CODE_CAMERA, 0),
                      SAMPLE_PIXEL),
        sample_stream(sample_pixel_stream(1, 2, 3), path_code_child(PATH_CODE_CAMERA, 1),
                      SAMPLE_PIXEL),
        sample_stream(sample_pixel_stream(1, 2, 3), PATH_CODE_CAMERA, (sample_purpose)2)};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        assert_true(sample_point(others[i], 0).x != first.x);
        assert_true(sample_point(others[i], 0).y != first.y);
        for (size_t j = 0; j < i; j++) assert_true(others[i] != others[j]);
    }
    /* The same sample of many pixels: mean, variance and correlation of independent numbers, each
     * within five standard deviations. */
    double x = 0, y = 0, xx = 0, xy = 0, neighbours = 0, last = 0.5;
    for (uint32_t i = 0; i < STREAMS; i++) {
        sample2 s = sample_point(
            sample_stream(sample_pixel_stream(0, i % 200, i / 200), PATH_CODE_CAMERA, SAMPLE_PIXEL),
            5);
        assert_true(s.x >= 0 && s.x < 1 && s.y >= 0 && s.y < 1);
        x += s.x - 0.5;
        y += s.y - 0.5;
        xx += (s.x - 0.5) * (s.x - 0.5);
        xy += (s.x - 0.5) * (s.y - 0.5);
        neighbours += (s.x - 0.5) * (last - 0.5);
        last = s.x;
    }
    double n = STREAMS, root = sqrt(n);
    assert_true(fabs(x) < 5 * root / sqrt(12) && fabs(y) < 5 * root / sqrt(12));
    assert_true(fabs(xx - n / 12) < 5 * root / sqrt(180));
    assert_true(fabs(xy) < 5 * root / 12 && fabs(neighbours) < 5 * root / 12);
}

/* What the header says without the library is what the library says. */
static void a_render_begins_with_the_defaults(void **state) {
    (void)state;
    rig_clear(&bench);
    snell_render_desc said = SNELL_INIT(render_desc), found;
    MUST(snell_scene_settings(bench.scene, 0, &found));
    assert_int_equal(said.struct_size, sizeof said);
    assert_true(said.integrator == found.integrator && said.samples == found.samples);
    assert_true(said.width == found.width && said.height == found.height);
    assert_true(said.max_depth == found.max_depth && said.min_weight == found.min_weight);
    assert_true(said.filter == found.filter && said.filter_radius == found.filter_radius);
    assert_true(!said.pixel_center && !said.transparent && said.seed == found.seed);
}

/* ---- dropped weight and depth ---- */

static void mirrors_facing_each_other(double reflectance, double sky) {
    rig_clear(&bench);
    snell_glazed_desc desc = SNELL_INIT(glazed_desc);
    snell_material_id m;
    desc.base = add_lambert(&bench, grey(0));
    desc.reflectance = flat(grey(reflectance));
    MUST(snell_scene_add_glazed(bench.scene, &desc, &m));
    MUST(snell_scene_set_ambient(bench.scene, grey(1)));
    MUST(snell_scene_set_background(bench.scene, grey(sky), 1));
    add_plane(&bench, v3(0, 0, 0), v3(0, 0, 1), m);
    add_plane(&bench, v3(0, 0, 4), v3(0, 0, -1), m);
    commit();
}

static void what_is_dropped_is_reported(void **state) {
    (void)state;
    mirrors_facing_each_other(0.5, 0);
    snell_render_desc desc = picture(SNELL_WHITTED, 3, 2, 100);
    snell_view view = look(v3(0, 0, 2), v3(0, 0.1, 0));
    desc.view = &view;
    desc.samples = 2;
    desc.min_weight = 0.1f; /* 1/2, 1/4, 1/8 are followed, 1/16 is dropped */
    MUST(snell_render(bench.scene, &desc, bench.film));
    snell_render_stats stats = stats_of(&bench);
    assert_true(stats.dropped_weight == 1.0 / 16);
    assert_true(pixel_at(&bench, 1, 1).c[0] == 1.875);
    assert_int_equal(stats.rays_camera, 12);
    assert_int_equal(stats.rays_reflected, 36);
    assert_int_equal(stats.samples_done, 2);
    assert_int_equal(stats.pixels_done, 6);
    mirrors_facing_each_other(0.5, 8); /* a brighter sky could make them matter: 1/128 is dropped */
    MUST(snell_render(bench.scene, &desc, bench.film));
    assert_true(stats_of(&bench).dropped_weight == 1.0 / 128);
    desc.min_weight = 0;
    MUST(snell_render(bench.scene, &desc, bench.film));
    assert_true(stats_of(&bench).dropped_weight == 0);
    for (uint32_t depth = 0; depth < 5; depth++) {
        desc.max_depth = depth;
        MUST(snell_render(bench.scene, &desc, bench.film));
        assert_int_equal(stats_of(&bench).rays_reflected, 12 * depth);
    }
}

/* A reflection of a thousandth of a sun of 1e4 was dropped: it is ten times white. */
/* The clocks change no picture, and run only where they are asked for. */
static void phases_are_timed_on_demand(void **state) {
    (void)state;
    add_box(&bench, v3(-1, -1, -1), v3(1, 1, 1), add_lambert(&bench, grey(0.5)));
    add_point(&bench, v3(0, 3, 3), grey(10));
    commit();
    snell_view view = look(v3(0, 0, 4), v3(0, 0, 0));
    snell_render_desc desc = picture(SNELL_WHITTED, 64, 48, 2);
    desc.view = &view;
    MUST(snell_render(bench.scene, &desc, bench.film));
    snell_render_stats plain = stats_of(&bench);
    uint64_t hash = snell_film_hash(bench.film);
    assert_true(plain.seconds_camera == 0 && plain.seconds_trace == 0 && plain.seconds_shade == 0 &&
                plain.seconds_shadows == 0);
    desc.timed = true;
    MUST(snell_render(bench.scene, &desc, bench.film));
    snell_render_stats timed = stats_of(&bench);
    assert_true(snell_film_hash(bench.film) == hash);
    assert_true(timed.seconds_camera > 0 && timed.seconds_trace > 0 && timed.seconds_shade > 0 &&
                timed.seconds_shadows > 0);
    assert_int_equal(timed.nodes, plain.nodes);
    assert_int_equal(timed.shadow_nodes, plain.shadow_nodes);
    assert_true(0 < timed.shadow_nodes && timed.shadow_nodes < timed.nodes);
    assert_int_equal(timed.memory_film, 64 * 48 * 3 * sizeof(float));
    assert_true(timed.memory_rays > 0);
}

static void bright_surroundings_are_not_dropped(void **state) {
    (void)state;
    static const float sun[8] = {0, 0, 0, 1, 1e4f, 1e4f, 1e4f, 1};
    for (int kind = 0; kind < 3; kind++) {
        rig_clear(&bench);
        snell_environment_light_desc sky = SNELL_INIT(environment_light_desc);
        sky.radiance = flat(grey(1e4));
        if (kind == 1) {
            snell_image_texture_desc map = SNELL_INIT(image_texture_desc);
            map.width = 2;
            map.height = 1;
            map.format = SNELL_IMAGE_TEXTURE_FORMAT_RGBA32F;
            map.pixels = sun;
            map.pixels_count = sizeof sun;
            sky.radiance.value = grey(1);
            MUST(snell_scene_add_image_texture(bench.scene, &map, &sky.radiance.texture));
        }
        snell_sky_light_desc day = SNELL_INIT(sky_light_desc);
        day.scale = 1e4f;
        if (kind == 2)
            MUST(snell_scene_add_sky_light(bench.scene, &day, NULL));
        else
            MUST(snell_scene_add_environment_light(bench.scene, &sky, NULL));
        add_plane(&bench, v3(0, 0, 0), v3(0, 0, 1), add_mirror(&bench, grey(1e-3)));
        commit();
        snell_render_desc desc = picture(SNELL_WHITTED, 1, 1, 4);
        snell_view view = look(v3(-1, 0.5, 1), v3(0, 0, 0));
        desc.view = &view;
        MUST(snell_render(bench.scene, &desc, bench.film));
        double all = pixel_at(&bench, 0, 0).c[0];
        assert_true(all > 0.1);
        if (kind == 0) ASSERT_CLOSE(all, 10, 1e-4, 0);
        desc.min_weight = 0.002f;
        MUST(snell_render(bench.scene, &desc, bench.film));
        assert_true(pixel_at(&bench, 0, 0).c[0] == all);
    }
}

/* ---- progress and cancelling ---- */

/* Slow: mirror balls between mirrors under many lights, so that a wave casts shadow rays by the
 * hundred thousand. Cards filter some of them. */
static void build_slow(int lights) {
    snell_material_id mirror = add_mirror(&bench, grey(0.99));
    snell_partial_mirror_desc desc = SNELL_INIT(partial_mirror_desc);
    snell_material_id half;
    MUST(snell_scene_add_partial_mirror(bench.scene, &desc, &half));
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), half);
    add_plane(&bench, v3(0, 9, 0), v3(0, -1, 0), half);
    for (int i = 0; i < 300; i++)
        add_sphere(&bench, v3(i % 20 - 10, 0.5 + i % 3, -i / 20), 0.4, i % 2 ? mirror : half);
    for (int i = 0; i < lights; i++) add_point(&bench, v3(i % 20 - 10, 8, -i / 20), grey(0.1));
    add_quad(&bench, v3(-9, 7, -9), v3(0, 0, 9), v3(9, 0, 0), add_card(&bench, grey(0.2), 0.5));
    commit();
}

static snell_render_desc slow_picture(const snell_view *view) {
    snell_render_desc desc = picture(SNELL_WHITTED, 256, 256, 30);
    desc.samples = 1 << 12;
    desc.wave_size = 1 << 20;
    desc.view = view;
    return desc;
}

/* Of one thread, in time that it had the processor: another program that is busy does not count. */
static double processor_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

typedef struct watch {
    double last, longest, fraction;
    int calls, calls_max;
    atomic_int inside;
    bool together, wrong;
} watch;

static bool on_progress(void *user, const snell_progress *p) {
    watch *w = user;
    if (atomic_fetch_add(&w->inside, 1) != 0) w->together = true;
    double now = processor_seconds();
    if (now - w->last > w->longest) w->longest = now - w->last;
    if (p->struct_size != sizeof *p || strcmp(p->phase, "render") != 0) w->wrong = true;
    if (!(p->fraction >= w->fraction && p->fraction <= 1)) w->wrong = true;
    w->fraction = p->fraction;
    bool go_on = ++w->calls < w->calls_max;
    w->last = processor_seconds();
    atomic_fetch_sub(&w->inside, 1);
    return go_on;
}

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
enum { SLOWNESS = 10 };
#else
enum { SLOWNESS = 1 };
#endif

static void progress_comes_often_and_stops_at_once(void **state) {
    (void)state;
    build_slow(400);
    snell_view view = look(v3(0, 2, 3), v3(0, 1, -5));
    snell_render_desc desc = slow_picture(&view);
    watch w = {.last = processor_seconds(), .calls_max = full_tests() ? 200 : 15};
    desc.progress = on_progress;
    desc.user = &w;
    assert_int_equal(snell_render(bench.scene, &desc, bench.film), SNELL_CANCELLED);
    double after = processor_seconds() - w.last;
    assert_int_equal(w.calls, w.calls_max); /* none after the one that said stop */
    assert_false(w.wrong);
    if (w.longest > 0.1 * SLOWNESS || after > 0.2 * SLOWNESS)
        fprintf(stderr, "longest silence %.3f s, stopped after %.3f s\n", w.longest, after);
    assert_true(w.longest <= 0.1 * SLOWNESS);
    assert_true(after <= 0.2 * SLOWNESS);
}

/* Several threads: one call at a time, and what is in the film is whole blocks or nothing. */
static void a_cancelled_film_has_whole_blocks(void **state) {
    (void)state;
    enum { SIDE = 96 };
    rig r = rig_make(3, SNELL_ISA_AUTO), first = bench;
    static float whole[SIDE * SIDE * 4];
    bench = r;
    build_slow(20);
    MUST(snell_scene_set_background(bench.scene, grey(1), 1));
    snell_view view = look(v3(0, 2, 3), v3(0, 1, -5));
    snell_render_desc desc = picture(SNELL_WHITTED, SIDE, SIDE, 2);
    desc.view = &view;
    desc.samples = 4;
    desc.transparent = true;
    MUST(snell_render(bench.scene, &desc, bench.film));
    memcpy(whole, snell_film_pixels(bench.film, NULL, NULL, NULL), sizeof whole);
    watch w = {.calls_max = 2};
    desc.progress = on_progress;
    desc.user = &w;
    snell_status status = snell_render(bench.scene, &desc, bench.film);
    assert_int_equal(status, SNELL_CANCELLED);
    assert_false(w.together || w.wrong);
    const float *part = snell_film_pixels(bench.film, NULL, NULL, NULL);
    int done = 0, empty = 0;
    for (int by = 0; by < SIDE / 16; by++)
        for (int bx = 0; bx < SIDE / 16; bx++) {
            bool same = true, zero = true;
            for (int i = 0; i < 16 * 16 * 4; i++) {
                int at = ((by * 16 + i / 64) * SIDE + bx * 16) * 4 + i % 64;
                same &= part[at] == whole[at];
                zero &= part[at] == 0;
            }
            assert_true(same || zero);
            done += same && !zero;
            empty += zero;
        }
    assert_true(empty > 0);
    assert_int_equal(stats_of(&bench).pixels_done, 256 * done);
    /* The film can be used again, and the scene edited. */
    desc.progress = NULL;
    MUST(snell_render(bench.scene, &desc, bench.film));
    assert_memory_equal(snell_film_pixels(bench.film, NULL, NULL, NULL), whole, sizeof whole);
    add_point(&bench, v3(0, 0, 0), grey(1));
    rig_free(&bench);
    bench = first;
}

/* ---- a scene that is being rendered ---- */

typedef struct meddler {
    rig *rig;
    atomic_bool rendering, done;
    int refused;
    bool wrong;
} meddler;

static bool say_rendering(void *user, const snell_progress *p) {
    (void)p;
    meddler *m = user;
    atomic_store(&m->rendering, true);
    return !atomic_load(&m->done);
}

/* Edits are refused, questions are answered. */
static void *meddle(void *user) {
    meddler *m = user;
    snell_scene *s = m->rig->scene;
    snell_sphere_desc sphere = SNELL_INIT(sphere_desc);
    snell_shape_id shape;
    snell_bounds bounds;
    snell_ray ray = {
        .origin = v3(0, 2, 3), .direction = v3(0, -1, 0), .t_max = INFINITY, .mask = ~0u};
    snell_hit hit;
    while (!atomic_load(&m->rendering)) continue;
    for (int i = 0; i < 20; i++) {
        m->refused += snell_scene_add_sphere(s, &sphere, &shape) == SNELL_ERR_STATE;
        m->refused += snell_scene_commit(s, NULL, NULL) == SNELL_ERR_STATE;
        m->refused += snell_scene_set_ambient(s, grey(1)) == SNELL_ERR_STATE;
        m->refused += snell_scene_add_instance(s, (snell_shape_id){1, 0}, (snell_material_id){0, 0},
                                               NULL, NULL) == SNELL_ERR_STATE;
        m->refused += snell_scene_load(s, "nothing.lua", NULL) == SNELL_ERR_STATE;
        if (snell_scene_intersect(s, &ray, &hit, 1) || !(hit.t > 0 && hit.t < 3)) m->wrong = true;
        if (snell_scene_bounds(s, &bounds)) m->wrong = true;
    }
    atomic_store(&m->done, true);
    return NULL;
}

static void edits_meanwhile_are_refused(void **state) {
    (void)state;
    build_slow(20);
    snell_view view = look(v3(0, 2, 3), v3(0, 1, -5));
    snell_render_desc desc = slow_picture(&view);
    meddler m = {.rig = &bench};
    pthread_t thread;
    desc.progress = say_rendering;
    desc.user = &m;
    assert_int_equal(pthread_create(&thread, NULL, meddle, &m), 0);
    assert_int_equal(snell_render(bench.scene, &desc, bench.film), SNELL_CANCELLED);
    pthread_join(thread, NULL);
    assert_int_equal(m.refused, 100);
    assert_false(m.wrong);
}

typedef struct second_render {
    rig *rig;
    uint64_t hash;
    snell_status status;
} second_render;

static void *render_again(void *user) {
    second_render *s = user;
    snell_film *own = NULL;
    snell_view view = look(v3(0, 2, 3), v3(0, 1, -5));
    snell_render_desc desc = picture(SNELL_WHITTED, 40, 40, 4);
    desc.view = &view;
    s->status = snell_film_create(s->rig->context, &own);
    if (!s->status) s->status = snell_render(s->rig->scene, &desc, own);
    s->hash = snell_film_hash(own);
    snell_film_destroy(own);
    return NULL;
}

static void two_renders_share_a_scene(void **state) {
    (void)state;
    build_slow(20);
    second_render renders[3] = {{.rig = &bench}, {.rig = &bench}, {.rig = &bench}};
    pthread_t threads[3];
    for (int i = 0; i < 3; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, render_again, &renders[i]), 0);
    for (int i = 0; i < 3; i++) pthread_join(threads[i], NULL);
    for (int i = 0; i < 3; i++) {
        MUST(renders[i].status);
        assert_true(renders[i].hash == renders[0].hash);
    }
}

static bool ask_meanwhile(void *user, const snell_progress *p) {
    (void)p;
    snell_scene_stats stats = {.struct_size = sizeof stats};
    snell_object_info info;
    snell_render_desc desc;
    snell_bounds bounds;
    int *refused = user;
    *refused += snell_scene_get_stats(bench.scene, &stats) == SNELL_ERR_STATE;
    *refused += snell_scene_get_light(bench.scene, 0, &info) == SNELL_ERR_STATE;
    *refused += snell_scene_settings(bench.scene, SNELL_WHITTED, &desc) == SNELL_ERR_STATE;
    *refused += snell_scene_bounds(bench.scene, &bounds) == SNELL_ERR_STATE;
    return false;
}

/* Questions about a scene once looked at it while it was being edited. */
static void questions_during_an_edit_are_refused(void **state) {
    (void)state;
    int refused = 0;
    add_point(&bench, v3(0, 0, 0), grey(1));
    assert_int_equal(snell_scene_commit(bench.scene, ask_meanwhile, &refused), SNELL_CANCELLED);
    assert_int_equal(refused, 4);
    snell_object_info info;
    MUST(snell_scene_get_light(bench.scene, 0, &info));
}

static atomic_bool enough;

static void *commit_again_and_again(void *argument) {
    const rig *r = argument;
    while (!atomic_load(&enough)) MUST(snell_scene_commit(r->scene, NULL, NULL));
    return NULL;
}

/* The grey of shapes without a material was once shared by all scenes, and each commit cleared it. */
static void a_commit_elsewhere_changes_no_picture(void **state) {
    (void)state;
    snell_view view = look(v3(0, 0, 5), v3(0, 0, 0));
    snell_render_desc d = picture(SNELL_WHITTED, 64, 64, 0);
    d.view = &view;
    add_sphere(&bench, v3(0, 0, 0), 1, (snell_material_id){0, 0});
    add_point(&bench, v3(3, 3, 5), grey(30));
    commit();
    MUST(snell_render(bench.scene, &d, bench.film));
    uint64_t hash = snell_film_hash(bench.film);
    rig other = rig_make(1, SNELL_ISA_AUTO);
    pthread_t thread;
    atomic_store(&enough, false);
    assert_int_equal(pthread_create(&thread, NULL, commit_again_and_again, &other), 0);
    int changed = 0;
    for (int i = 0; i < 100; i++) {
        MUST(snell_render(bench.scene, &d, bench.film));
        changed += snell_film_hash(bench.film) != hash;
    }
    atomic_store(&enough, true);
    pthread_join(thread, NULL);
    rig_free(&other);
    assert_int_equal(changed, 0);
}

/* Directions were once made unit length by whatever rounding the caller had set. */
static void the_callers_rounding_changes_no_picture(void **state) {
    (void)state;
    for (int i = 0; i < 20; i++) {
        uint64_t hash[2];
        for (int upward = 0; upward < 2; upward++) {
            rig_clear(&bench);
            snell_disk_desc disk = SNELL_INIT(disk_desc);
            snell_shape_id id;
            disk.normal = v3(1, 0.3 + 0.17 * i, 3);
            if (upward) fesetround(FE_UPWARD);
            MUST(snell_scene_add_disk(bench.scene, &disk, &id));
            place(&bench, id, (snell_material_id){0, 0});
            add_sun(&bench, (snell_vec3){-1, -3, -disk.normal.y}, grey(1));
            MUST(snell_scene_add_studio(bench.scene, NULL, NULL));
            commit();
            snell_render_desc d = picture(SNELL_WHITTED, 32, 32, 0);
            MUST(snell_render(bench.scene, &d, bench.film));
            assert_int_equal(fegetround(), upward ? FE_UPWARD : FE_TONEAREST);
            fesetround(FE_TONEAREST);
            hash[upward] = snell_film_hash(bench.film);
        }
        assert_true(hash[0] == hash[1]);
    }
}

/* The error named a headlight, which nobody had written. */
static void what_is_too_large_for_the_studio_says_so(void **state) {
    (void)state;
    static const double radii[] = {1e30, 3e38};
    for (int i = 0; i < 2; i++) {
        rig_clear(&bench);
        add_sphere(&bench, v3(0, 0, 0), radii[i], (snell_material_id){0, 0});
        assert_int_equal(snell_scene_add_studio(bench.scene, NULL, NULL), SNELL_ERR_UNSUPPORTED);
        assert_non_null(strstr(snell_last_error()->text, "m across"));
    }
}

static uint64_t hash_from(double azimuth) {
    snell_bounds bounds = {{-1, -1, -1}, {1, 1, 1}};
    snell_view view = SNELL_INIT(view);
    MUST(snell_view_frame(&view, &bounds, (float)azimuth, 0.4f, 1));
    snell_render_desc d = picture(SNELL_WHITTED, 32, 32, 1);
    d.view = &view;
    MUST(snell_render(bench.scene, &d, bench.film));
    return snell_film_hash(bench.film);
}

/* As if it had been put up there, though nothing is committed again. */
static void the_studio_turns_without_a_commit(void **state) {
    (void)state;
    uint64_t hash[3];
    for (int i = 0; i < 3; i++) {
        const snell_bounds bounds = {{-1, -1, -1}, {1, 1, 1}};
        snell_view view = SNELL_INIT(view);
        MUST(snell_view_frame(&view, &bounds, 0.25f, 0.4f, 1));
        if (i == 1) MUST(snell_view_turn(&view, v3(0, 0, 0), 1.5f));
        rig_clear(&bench);
        add_sphere(&bench, v3(0, 0, 0), 1, (snell_material_id){0, 0});
        MUST(snell_scene_add_studio(bench.scene, &view, NULL));
        commit();
        if (i == 2) MUST(snell_scene_turn_studio(bench.scene, 1.5));
        hash[i] = hash_from(0.25 + 1.5);
    }
    assert_true(hash[0] != hash[1]);
    assert_true(hash[1] == hash[2]);
    MUST(snell_scene_turn_studio(bench.scene, 0));
    assert_true(hash_from(0.25 + 1.5) == hash[0]);
    assert_int_equal(snell_scene_turn_studio(bench.scene, (double)NAN), SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_scene_turn_studio(NULL, 1), SNELL_ERR_ARGUMENT);
    rig_clear(&bench);
    MUST(snell_scene_turn_studio(bench.scene, 1)); /* there is none */
}

/* How much of the picture's half width or half height a point lies from its middle; its depth. */
static double off_center(const snell_view *v, snell_vec3 p, double aspect, double *depth) {
    double back[3] = {(double)(v->from.x - v->at.x), (double)(v->from.y - v->at.y),
                      (double)(v->from.z - v->at.z)};
    double up[3] = {(double)v->up.x, (double)v->up.y, (double)v->up.z}, right[3], top[3];
    double to[3] = {(double)(p.x - v->from.x), (double)(p.y - v->from.y),
                    (double)(p.z - v->from.z)};
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        right[i] = up[j] * back[k] - up[k] * back[j];
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        top[i] = back[j] * right[k] - back[k] * right[j];
    }
    double x = 0, y = 0, z = 0, lengths[3] = {0};
    for (int i = 0; i < 3; i++) {
        x += right[i] * to[i], y += top[i] * to[i], z -= back[i] * to[i];
        lengths[0] += right[i] * right[i], lengths[1] += top[i] * top[i];
        lengths[2] += back[i] * back[i];
    }
    *depth = z / sqrt(lengths[2]);
    double half = tan((double)v->fov / 2) * *depth;
    return fmax(fabs(x / sqrt(lengths[0])) / (half * aspect), fabs(y / sqrt(lengths[1])) / half);
}

/* A cow once filled half the width: the sphere around its box was what had to fit. */
static void a_framed_model_fills_the_picture(void **state) {
    (void)state;
    const snell_vec3 corners[5] = {v3(0, 0, 0), v3(9, 0, 0.5), v3(8, 1, 2), v3(1, 2, 1),
                                   v3(99, 99, 99)}; /* the last unused */
    const uint32_t faces[12] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2};
    const double away[2][2] = {{0, 0}, {1000, 2}}; /* the mesh is twice as large there */
    for (int i = 0; i < 160; i++) {
        double scale = i & 1 ? away[1][1] : 1, shift = i & 1 ? away[1][0] : 0, most = 0, depth;
        float azimuth = 0.7f * (float)i,
              elevation = i % 5 == 4 ? 1.5707964f : 0.3f * (float)(i % 5),
              aspect = i % 3 == 0 ? 0.5f : (float)(i % 3);
        bool turning = i >= 120;
        rig_clear(&bench);
        snell_transform to = {
            {{(float)scale, 0, 0, (float)shift}, {0, (float)scale, 0, 0}, {0, 0, (float)scale, 0}}};
        snell_instance_id id;
        MUST(snell_scene_add_instance(bench.scene, add_mesh(&bench, corners, 5, faces, 12),
                                      (snell_material_id){0, 0}, &to, &id));
        snell_view view = SNELL_INIT(view);
        view.fov = i % 7 == 6 ? 2.0f : 0.7f;
        MUST(snell_view_frame_scene(&view, bench.scene, azimuth, elevation, aspect, turning));
        snell_bounds b;
        MUST(snell_scene_bounds(bench.scene, &b));
        snell_vec3 center = {(b.min.x + b.max.x) / 2, (b.min.y + b.max.y) / 2,
                             (b.min.z + b.max.z) / 2};
        for (int turn = 0; turn < (turning ? 720 : 1); turn++) {
            for (int k = 0; k < 4; k++) {
                snell_vec3 p = v3(scale * (double)corners[k].x + shift,
                                  scale * (double)corners[k].y, scale * (double)corners[k].z);
                most = fmax(most, off_center(&view, p, (double)aspect, &depth));
                assert_true(depth > 0);
            }
            if (turning) MUST(snell_view_turn(&view, center, 6.2831853f / 720));
        }
        assert_true(most < (turning ? 0.901 : 0.9001)); /* 720 turns are rounded as often */
        if (view.fov < 1) assert_true(most > 0.899); /* a wide one may have to stay before it all */
    }
    /* What is near looks larger: a floor once lay in the upper half of the picture. */
    const snell_vec3 floor_corners[4] = {v3(-1, 0, -1), v3(1, 0, -1), v3(1, 0, 1), v3(-1, 0, 1)};
    const uint32_t floor_faces[6] = {0, 2, 1, 0, 3, 2};
    snell_view view = SNELL_INIT(view);
    double depth;
    rig_clear(&bench);
    place(&bench, add_mesh(&bench, floor_corners, 4, floor_faces, 6), (snell_material_id){0, 0});
    MUST(snell_view_frame_scene(&view, bench.scene, 0, 0.3f, 1.33f, false));
    assert_true(fabs(off_center(&view, floor_corners[0], 1e9, &depth) -
                     off_center(&view, floor_corners[2], 1e9, &depth)) < 1e-3);
    assert_int_equal(snell_view_frame_scene(&view, bench.scene, 0, 0, 0, false),
                     SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_view_frame_scene(&view, bench.scene, 0, 0, INFINITY, false),
                     SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_view_frame_scene(NULL, bench.scene, 0, 0, 1, false), SNELL_ERR_ARGUMENT);
    snell_view sideways = view;
    const snell_vec3 wrong_ups[] = {v3(0, 0, 0), v3(0, 0, 1), v3(NAN, 1, 0)};
    for (size_t i = 0; i < sizeof wrong_ups / sizeof wrong_ups[0]; i++) {
        sideways.up = wrong_ups[i];
        assert_int_equal(snell_view_frame_scene(&sideways, bench.scene, 0, 0, 1, false),
                         SNELL_ERR_ARGUMENT);
    }
    assert_int_equal(snell_view_frame_scene(&view, NULL, 0, 0, 1, false), SNELL_ERR_ARGUMENT);
    rig_clear(&bench); /* what is not there fits */
    MUST(snell_view_frame_scene(&view, bench.scene, 0, 0, 1, false));
}

/* ---- bad arguments ---- */

static bool never(void *user, const snell_progress *progress) {
    (void)user, (void)progress;
    return false;
}

#define REFUSED(expected, call)                                                                    \
    do {                                                                                           \
        assert_int_equal((call), (expected));                                                      \
        assert_true(snell_last_error()->text[0] != '\0');                                          \
        assert_int_equal(snell_last_error()->status, (expected));                                  \
    } while (0)

static void bad_renders_are_refused(void **state) {
    (void)state;
    snell_view view = look(v3(0, 0, 5), v3(0, 0, 0)), bad_view;
    snell_render_desc good = picture(SNELL_WHITTED, 4, 4, 1), d;
    good.view = &view;
    REFUSED(SNELL_ERR_STATE, snell_render(bench.scene, &good, bench.film)); /* no commit */
    add_sphere(&bench, v3(0, 0, 0), 1, (snell_material_id){0, 0});
    commit();
    MUST(snell_render(bench.scene, &good, bench.film));
    REFUSED(SNELL_ERR_ARGUMENT, snell_render(NULL, &good, bench.film));
    REFUSED(SNELL_ERR_ARGUMENT, snell_render(bench.scene, NULL, bench.film));
    REFUSED(SNELL_ERR_ARGUMENT, snell_render(bench.scene, &good, NULL));
#define BAD(status, change)                                                                        \
    d = good;                                                                                      \
    bad_view = view;                                                                               \
    d.change;                                                                                      \
    REFUSED(status, snell_render(bench.scene, &d, bench.film))
    BAD(SNELL_ERR_VERSION, struct_size = 8);
    BAD(SNELL_ERR_VERSION, struct_size = sizeof d + 8);
    BAD(SNELL_ERR_ARGUMENT, width = 0);
    BAD(SNELL_ERR_ARGUMENT, height = 65537);
    BAD(SNELL_ERR_ARGUMENT, width = d.height = 65536);
    BAD(SNELL_ERR_ARGUMENT, samples = 0);
    BAD(SNELL_ERR_ARGUMENT, samples = (1u << 20) + 1);
    BAD(SNELL_ERR_ARGUMENT, max_depth = 1001);
    BAD(SNELL_ERR_ARGUMENT, min_weight = -1);
    BAD(SNELL_ERR_ARGUMENT, min_weight = NAN);
    BAD(SNELL_ERR_ARGUMENT, crop_width = 5);
    BAD(SNELL_ERR_ARGUMENT, crop_width = 1); /* and no height */
    BAD(SNELL_ERR_ARGUMENT, crop_x = UINT32_MAX - (d.crop_width = d.crop_height = 3) + 2);
    BAD(SNELL_ERR_ARGUMENT, wave_size = UINT32_MAX);
    BAD(SNELL_ERR_ARGUMENT, integrator = (snell_integrator)0);
    BAD(SNELL_ERR_ARGUMENT, integrator = (snell_integrator)5);
    BAD(SNELL_ERR_ARGUMENT, view = NULL); /* and the scene has no camera */
    BAD(SNELL_ERR_VERSION, view = (bad_view.struct_size = 3, &bad_view));
    BAD(SNELL_ERR_ARGUMENT, view = (bad_view.fov = 0, &bad_view));
    BAD(SNELL_ERR_ARGUMENT, view = (bad_view.fov = NAN, &bad_view));
    BAD(SNELL_ERR_ARGUMENT, view = (bad_view.at = bad_view.from, &bad_view));
    BAD(SNELL_ERR_ARGUMENT, view = (bad_view.up = v3(0, 0, 0), &bad_view));
    BAD(SNELL_ERR_ARGUMENT, view = (bad_view.up = v3(0, 0, 1), &bad_view));
    BAD(SNELL_ERR_ARGUMENT, view = (bad_view.from.x = INFINITY, &bad_view));
    BAD(SNELL_ERR_ARGUMENT, view = (d.camera.index1 = 7, NULL));
#undef BAD
    MUST(snell_render(bench.scene, &good, bench.film)); /* nothing was left locked */
}

static void bad_queries_are_refused(void **state) {
    (void)state;
    snell_ray ray = {.direction = v3(0, 0, 1), .t_max = 1, .mask = 1};
    snell_hit hit;
    uint8_t blocked;
    snell_bounds bounds;
    snell_render_desc settings;
    snell_scene_stats scene_stats = {.struct_size = 1};
    snell_render_stats render_stats = {.struct_size = 1};
    snell_object_info info;
    snell_camera_id camera;
    snell_scene_param param;
    snell_view view = SNELL_INIT(view);
    REFUSED(SNELL_ERR_STATE, snell_scene_intersect(bench.scene, &ray, &hit, 1));
    MUST(snell_scene_bounds(bench.scene, &bounds)); /* of what was added: nothing */
    assert_true(bounds.min.x > bounds.max.x);
    commit(); /* an empty scene is a scene */
    MUST(snell_scene_intersect(bench.scene, NULL, NULL, 0));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_intersect(bench.scene, NULL, &hit, 1));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_intersect_all(bench.scene, &ray, NULL, 1));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_occluded(NULL, &ray, &blocked, 1));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_bounds(bench.scene, NULL));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_settings(NULL, SNELL_WHITTED, &settings));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_settings(bench.scene, SNELL_WHITTED, NULL));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_settings(bench.scene, (snell_integrator)5, &settings));
    REFUSED(SNELL_ERR_VERSION, snell_scene_get_stats(bench.scene, &scene_stats));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_get_stats(bench.scene, NULL));
    REFUSED(SNELL_ERR_VERSION, snell_film_get_stats(bench.film, &render_stats));
    REFUSED(SNELL_ERR_ARGUMENT, snell_film_get_stats(NULL, &render_stats));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_get_camera(bench.scene, 0, &info, &camera));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_get_light(bench.scene, 0, NULL));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_get_material(NULL, 0, &info));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_get_param(bench.scene, 0, &param));
    REFUSED(SNELL_ERR_ARGUMENT, snell_view_frame(NULL, &bounds, 0, 0, 1));
    REFUSED(SNELL_ERR_ARGUMENT, snell_view_frame(&view, NULL, 0, 0, 1));
    assert_null(snell_film_pixels(NULL, NULL, NULL, NULL));
    assert_int_equal(snell_film_hash(NULL), 0);
    uint32_t types = snell_type_count();
    snell_type_info type;
    snell_field_info field;
    REFUSED(SNELL_ERR_ARGUMENT, snell_type_get(types, &type));
    REFUSED(SNELL_ERR_ARGUMENT, snell_type_get(0, NULL));
    MUST(snell_type_get(0, &type));
    REFUSED(SNELL_ERR_ARGUMENT, snell_type_get_field(0, type.field_count, &field));
    REFUSED(SNELL_ERR_ARGUMENT, snell_type_get_field(types, 0, &field));
}

static void bad_contexts_and_films_are_refused(void **state) {
    (void)state;
    snell_context_desc desc = SNELL_INIT(context_desc);
    snell_context *context;
    snell_scene *scene;
    snell_film *other, *empty = NULL;
    void *data;
    size_t size;
    snell_picture_info picture_info = {.struct_size = 2};
    REFUSED(SNELL_ERR_ARGUMENT, snell_context_create(&desc, NULL));
    desc.struct_size++;
    REFUSED(SNELL_ERR_VERSION, snell_context_create(&desc, &context));
    desc.struct_size--;
    desc.isa_max = (snell_isa)9;
    REFUSED(SNELL_ERR_ARGUMENT, snell_context_create(&desc, &context));
    desc.isa_max = SNELL_ISA_AUTO;
    desc.build = (snell_build)3;
    REFUSED(SNELL_ERR_ARGUMENT, snell_context_create(&desc, &context));
    desc.build = SNELL_BUILD_BALANCED;
    desc.thread_count = 1u << 30;
    REFUSED(SNELL_ERR_ARGUMENT, snell_context_create(&desc, &context));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_create(NULL, &scene));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_create(bench.context, NULL));
    REFUSED(SNELL_ERR_ARGUMENT, snell_film_create(NULL, &other));
    REFUSED(SNELL_ERR_ARGUMENT, snell_film_create(bench.context, NULL));
    MUST(snell_film_create(bench.context, &empty));
    REFUSED(SNELL_ERR_STATE, snell_film_write(empty, "never.png", NULL));
    REFUSED(SNELL_ERR_STATE, snell_film_encode(empty, "png", NULL, &data, &size));
    REFUSED(SNELL_ERR_ARGUMENT, snell_film_write(NULL, "never.png", NULL));
    REFUSED(SNELL_ERR_ARGUMENT, snell_film_write(empty, NULL, NULL));
    REFUSED(SNELL_ERR_ARGUMENT, snell_film_encode(empty, NULL, NULL, &data, &size));
    REFUSED(SNELL_ERR_ARGUMENT, snell_film_encode(empty, "png", NULL, NULL, &size));
    REFUSED(SNELL_ERR_ARGUMENT, snell_picture_read_info(NULL, &picture_info));
    REFUSED(SNELL_ERR_VERSION, snell_picture_read_info("never.png", &picture_info));
    snell_film_destroy(empty);
    snell_film_destroy(NULL);
    snell_scene_destroy(NULL);
    snell_context_destroy(NULL);
    snell_free(NULL);
}

static void a_picture_without_exposure_is_refused(void **state) {
    (void)state;
    add_sphere(&bench, v3(0, 0, 0), 1, (snell_material_id){0, 0});
    commit();
    trace_ray(&bench, SNELL_APPEL, v3(0, 0, 5), v3(0, 0, 0), 0);
    snell_image_desc desc = SNELL_INIT(image_desc);
    void *data = NULL;
    size_t size = 0;
    desc.exposure_set = true;
    desc.exposure = NAN;
    REFUSED(SNELL_ERR_ARGUMENT, snell_film_encode(bench.film, "ppm", &desc, &data, &size));
    assert_null(data);
}

static void a_cancelled_commit_says_so(void **state) {
    (void)state;
    add_sphere(&bench, v3(0, 0, 0), 1, (snell_material_id){0, 0});
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_shape(bench.scene, "spher", NULL, 0, NULL));
    REFUSED(SNELL_CANCELLED, snell_scene_commit(bench.scene, never, NULL));
    commit();
}

static void bad_objects_are_refused(void **state) {
    (void)state;
    snell_sphere_desc sphere = SNELL_INIT(sphere_desc);
    snell_lambert_desc lambert = SNELL_INIT(lambert_desc);
    snell_load_desc load = SNELL_INIT(load_desc);
    snell_shape_id shape;
    snell_material_id material;
    snell_instance_id instance;
    snell_scene *s = bench.scene;
    snell_transform squashed = {{{1, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 1, 0}}};
    snell_transform lost = {{{1, 0, 0, NAN}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_sphere(NULL, &sphere, &shape));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_sphere(s, NULL, &shape));
    sphere.struct_size = 1;
    assert_true(snell_scene_add_sphere(s, &sphere, &shape) != SNELL_OK);
    sphere.struct_size = sizeof sphere;
    static const float radii[] = {0, -1, NAN, INFINITY};
    for (int i = 0; i < 4; i++) {
        sphere.radius = radii[i];
        REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_sphere(s, &sphere, &shape));
    }
    snell_dielectric_desc glass = SNELL_INIT(dielectric_desc);
    glass.attenuation_color = grey(1e-6); /* the least, which as a float is a little less */
    MUST(snell_scene_add_dielectric(s, &glass, &material));
    glass.attenuation_color = grey(0.9e-6);
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_dielectric(s, &glass, &material));
    snell_view flat_view = SNELL_INIT(view);
    snell_bounds bounds = {{-1, -1, -1}, {1, 1, 1}};
    MUST(snell_view_frame(&flat_view, &bounds, 0, 0, 1));
    flat_view.fov = 0; /* gave a camera at infinity */
    REFUSED(SNELL_ERR_ARGUMENT, snell_view_frame(&flat_view, &bounds, 0, 0, 1));
    const char *const no_texts[] = {NULL};
    snell_load_desc lists = SNELL_INIT(load_desc);
    lists.param_count = 1;
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_load(s, "a.lua", &lists));
    lists.params = no_texts;
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_load(s, "a.lua", &lists));
    lambert.color.value.y = -1;
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_lambert(s, &lambert, &material));
    lambert.color = (snell_input){grey(1), {5, 0}};
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_lambert(s, &lambert, &material));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_shape(s, "doughnut", NULL, 0, &shape));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_shape(s, NULL, NULL, 0, &shape));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_material(s, "lambert", NULL, 1, &material));
    snell_param params[] = {{.name = "radius", .kind = SNELL_PARAM_STRING, .value.s = "one"}};
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_shape(s, "sphere", params, 1, &shape));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_light(s, "point", NULL, 0, NULL)); /* no position */
    MUST(snell_scene_add_shape(s, "sphere", NULL, 0, &shape));
    material = (snell_material_id){0, 0};
    snell_shape_id stale = {shape.index1, 1};
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_instance(s, stale, material, NULL, &instance));
    REFUSED(SNELL_ERR_ARGUMENT,
            snell_scene_add_instance(s, (snell_shape_id){0, 0}, material, NULL, NULL));
    REFUSED(SNELL_ERR_ARGUMENT,
            snell_scene_add_instance(s, (snell_shape_id){9, 0}, material, NULL, NULL));
    material.index1 = 4;
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_add_instance(s, shape, material, NULL, NULL));
    material.index1 = 0;
    assert_true(snell_scene_add_instance(s, shape, material, &lost, NULL) == SNELL_ERR_ARGUMENT ||
                snell_scene_commit(s, NULL, NULL) == SNELL_ERR_ARGUMENT);
    rig_clear(&bench);
    s = bench.scene;
    MUST(snell_scene_add_shape(s, "sphere", NULL, 0, &shape));
    MUST(snell_scene_add_instance(s, shape, material, NULL, &instance));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_set_instance_transform(s, instance, &squashed));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_set_instance_transform(s, instance, &lost));
    MUST(snell_scene_remove_instance(s, instance));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_remove_instance(s, instance));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_set_instance_transform(s, instance, NULL));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_set_background(s, v3(0, -1, 0), 1));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_set_background(s, grey(1), 2));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_set_background_gradient(s, grey(1), grey(-1)));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_set_ambient(s, grey(NAN)));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_commit(NULL, NULL, NULL));
    REFUSED(SNELL_ERR_ARGUMENT, snell_scene_load(s, NULL, NULL));
    load.struct_size = 4;
    REFUSED(SNELL_ERR_VERSION, snell_scene_load(s, "x.lua", &load));
    load = SNELL_INIT(load_desc);
    load.allow_helper = false;
    REFUSED(SNELL_ERR_UNSUPPORTED, snell_scene_load(s, "x.lua", &load));
    MUST(snell_scene_commit(s, NULL, NULL));
}

/* ---- no surface shadows itself ---- */

typedef struct face {
    double n[3], d; /* n.p <= d inside */
} face;

/* A convex body around the origin: as faces, or a ball (no faces); a disk is a face with a rim. */
typedef struct body {
    int face_count;
    face faces[8];
    double rim;
} body;

typedef struct meeting {
    double t, n[3];
} meeting;

static double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Where the ray enters; false: nowhere. */
static bool enter_body(const body *b, const double o[3], const double d[3], meeting *out) {
    if (b->face_count == 0) {
        double half = dot3(o, d), c = dot3(o, o) - 1, k = half * half - c * dot3(d, d);
        if (k < 0) return false;
        out->t = (-half - sqrt(k)) / dot3(d, d);
        for (int i = 0; i < 3; i++) out->n[i] = o[i] + out->t * d[i];
        return out->t > 0;
    }
    double low = 0, high = INFINITY;
    for (int i = 0; i < b->face_count; i++) {
        const face *f = &b->faces[i];
        double slope = dot3(f->n, d), t = (f->d - dot3(f->n, o)) / slope;
        if (slope < 0 && t > low) {
            low = t;
            memcpy(out->n, f->n, sizeof out->n);
        }
        if (slope > 0 && t < high && b->rim == 0) high = t;
    }
    out->t = low;
    double p[3] = {o[0] + low * d[0], o[1] + low * d[1], o[2] + low * d[2]};
    return low > 0 && low < high && (b->rim == 0 || dot3(p, p) < b->rim * b->rim);
}

static const double EYE[3] = {3, 2.5, 4}, LAMP[3] = {2, 5, 3};

/* What a pixel of the picture of the unit body must show; < 0: too near an edge to say. */
static double expected_pixel(const body *b, double x, double y) {
    double forward[3], right[3], up[3], d[3], length = sqrt(dot3(EYE, EYE));
    for (int i = 0; i < 3; i++) forward[i] = -EYE[i] / length;
    double flat_length = hypot(forward[0], forward[2]);
    right[0] = -forward[2] / flat_length;
    right[1] = 0;
    right[2] = forward[0] / flat_length;
    up[0] = right[1] * forward[2] - right[2] * forward[1];
    up[1] = right[2] * forward[0] - right[0] * forward[2];
    up[2] = right[0] * forward[1] - right[1] * forward[0];
    double values[5];
    for (int k = 0; k < 5; k++) { /* the pixel's centre, and beside it */
        static const double aside[5][2] = {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}};
        double u = x + 1e-4 * aside[k][0], v = y + 1e-4 * aside[k][1], squared = 0, cosine = 0;
        meeting m = {0, {0, 0, 0}};
        for (int i = 0; i < 3; i++) d[i] = forward[i] + u * right[i] + v * up[i];
        values[k] = 0;
        if (!enter_body(b, EYE, d, &m)) continue;
        for (int i = 0; i < 3; i++) {
            double to_lamp = LAMP[i] - (EYE[i] + m.t * d[i]);
            squared += to_lamp * to_lamp;
            cosine += to_lamp * m.n[i];
        }
        values[k] = cosine > 0 ? 0.5 / PI_ * 100 * cosine / (squared * sqrt(squared)) : 0;
    }
    for (int k = 1; k < 5; k++)
        if (fabs(values[k] - values[0]) > 0.01 * values[0]) return -1;
    return values[0];
}

static void check_no_acne(const body *b, const char *what, double scale, double moved) {
    enum { SIDE = 40 };
    snell_render_desc desc = picture(SNELL_WHITTED, SIDE, SIDE, 0);
    double c = scale * moved, half = tan((double)(float)0.5 / 2);
    snell_view view =
        look(v3(c + scale * EYE[0], c + scale * EYE[1], c + scale * EYE[2]), v3(c, c, c));
    view.up = v3(0, 1, 0);
    view.fov = 0.5f;
    desc.view = &view;
    add_point(&bench, v3(c + scale * LAMP[0], c + scale * LAMP[1], c + scale * LAMP[2]),
              grey(100 * scale * scale));
    commit();
    MUST(snell_render(bench.scene, &desc, bench.film));
    int compared = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        double x = (2 * (i % SIDE + 0.5) / SIDE - 1) * half,
               y = (1 - 2 * (i / SIDE + 0.5) / SIDE) * half;
        double expected = expected_pixel(b, x, y), got = pixel_at(&bench, i % SIDE, i / SIDE).c[0];
        if (expected < 0) continue;
        compared++;
        if (fabs(got - expected) <= 1e-3 * expected) continue;
        fprintf(stderr, "%s, scale %g, moved by %g sizes: pixel %u, %u is %g, not %g\n", what,
                scale, moved, i % SIDE, i / SIDE, got, expected);
        fail();
    }
    assert_true(compared > SIDE * SIDE / 2);
}

static body make_body(int kind) {
    body b = {0};
    if (kind == 1) { /* a box */
        b.face_count = 6;
        for (int i = 0; i < 6; i++) {
            b.faces[i].n[i / 2] = i % 2 ? 1 : -1;
            b.faces[i].d = i / 2 == 1 ? 0.5 : 0.75;
        }
    } else if (kind == 2) { /* a disk that faces up */
        b = (body){.face_count = 1, .faces = {{{0, 1, 0}, 0}}, .rim = 1};
    } else if (kind == 3) { /* an octahedron */
        b.face_count = 8;
        for (int i = 0; i < 8; i++) {
            double s = sqrt(1.0 / 3);
            b.faces[i] = (face){{i & 1 ? s : -s, i & 2 ? s : -s, i & 4 ? s : -s}, s};
        }
    }
    return b;
}

static snell_shape_id make_shape(int kind, double s, double c) {
    snell_sphere_desc sphere = SNELL_INIT(sphere_desc);
    snell_box_desc box = SNELL_INIT(box_desc);
    snell_disk_desc disk = SNELL_INIT(disk_desc);
    snell_shape_id id;
    static const uint32_t faces[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                     2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    const snell_vec3 corners[] = {v3(c + s, c, c), v3(c - s, c, c), v3(c, c + s, c),
                                  v3(c, c - s, c), v3(c, c, c + s), v3(c, c, c - s)};
    switch (kind) {
    case 0:
        sphere.center = v3(c, c, c);
        sphere.radius = (float)s;
        MUST(snell_scene_add_sphere(bench.scene, &sphere, &id));
        return id;
    case 1:
        box.min = v3(c - 0.75 * s, c - 0.5 * s, c - 0.75 * s);
        box.max = v3(c + 0.75 * s, c + 0.5 * s, c + 0.75 * s);
        MUST(snell_scene_add_box(bench.scene, &box, &id));
        return id;
    case 2:
        disk.center = v3(c, c, c);
        disk.radius = (float)s;
        MUST(snell_scene_add_disk(bench.scene, &disk, &id));
        return id;
    default: return add_mesh(&bench, corners, 6, faces, 24);
    }
}

/* Sizes from 1e-3 to 1e6 (powers of two, so that every number is a float), up to 2^14 sizes away
 * from 0, described there or brought there by an instance. */
static void nothing_shadows_itself(void **state) {
    (void)state;
    static const char *const names[] = {"sphere", "box", "disk", "mesh"};
    static const double scales[] = {0x1p-10, 1, 0x1p10, 0x1p20}, places[] = {0, 0x1p7, 0x1p14};
    for (int kind = 0; kind < 4; kind++)
        for (int i = 0; i < 12; i++)
            for (int instanced = 0; instanced < 3; instanced++) {
                rig_clear(&bench);
                double s = scales[i / 3], c = s * places[i % 3];
                double local = instanced == 2 ? 1.0 / 7 : 1; /* then no product is exact */
                float fs = (float)(s / local), fc = (float)c;
                snell_transform at = {{{fs, 0, 0, fc}, {0, fs, 0, fc}, {0, 0, fs, fc}}};
                snell_shape_id shape =
                    instanced ? make_shape(kind, local, 0) : make_shape(kind, s, c);
                MUST(snell_scene_add_instance(bench.scene, shape, add_lambert(&bench, grey(0.5)),
                                              instanced ? &at : NULL, NULL));
                body b = make_body(kind);
                check_no_acne(&b, names[kind], s, places[i % 3]);
            }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(fixed_point_is_exact, fresh),
        cmocka_unit_test_setup(sums_do_not_depend_on_order, fresh),
        cmocka_unit_test_setup(a_full_sum_stays_full, fresh),
        cmocka_unit_test_setup(no_nan_reaches_the_film, fresh),
        cmocka_unit_test_setup(prefixes_are_nets, fresh),
        cmocka_unit_test_setup(streams_differ_and_are_uniform, fresh),
        cmocka_unit_test_setup(a_render_begins_with_the_defaults, fresh),
        cmocka_unit_test_setup(what_is_dropped_is_reported, fresh),
        cmocka_unit_test_setup(phases_are_timed_on_demand, fresh),
        cmocka_unit_test_setup(bright_surroundings_are_not_dropped, fresh),
        cmocka_unit_test_setup(progress_comes_often_and_stops_at_once, fresh),
        cmocka_unit_test_setup(a_cancelled_film_has_whole_blocks, fresh),
        cmocka_unit_test_setup(edits_meanwhile_are_refused, fresh),
        cmocka_unit_test_setup(questions_during_an_edit_are_refused, fresh),
        cmocka_unit_test_setup(two_renders_share_a_scene, fresh),
        cmocka_unit_test_setup(a_commit_elsewhere_changes_no_picture, fresh),
        cmocka_unit_test_setup(the_callers_rounding_changes_no_picture, fresh),
        cmocka_unit_test_setup(bad_renders_are_refused, fresh),
        cmocka_unit_test_setup(bad_queries_are_refused, fresh),
        cmocka_unit_test_setup(bad_contexts_and_films_are_refused, fresh),
        cmocka_unit_test_setup(a_picture_without_exposure_is_refused, fresh),
        cmocka_unit_test_setup(a_cancelled_commit_says_so, fresh),
        cmocka_unit_test_setup(what_is_too_large_for_the_studio_says_so, fresh),
        cmocka_unit_test_setup(the_studio_turns_without_a_commit, fresh),
        cmocka_unit_test_setup(a_framed_model_fills_the_picture, fresh),
        cmocka_unit_test_setup(bad_objects_are_refused, fresh),
        cmocka_unit_test_setup(nothing_shadows_itself, fresh),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
