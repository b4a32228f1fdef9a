/* What rays meet on their way, against closed forms: media, filtered shadows, alpha, mirrors,
 * energy. Every scene goes through the public API. */
#include "materials/bsdf.h"
#include "render_test.h"

static const double PI_ = 3.14159265358979323846;
static const double TOLERANCE = 2e-6;
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

static double pass(double cosine, double ior1, double ior2) {
    return 1 - fresnel_dielectric(cosine, ior1, ior2);
}

static double cos_in(double sine, double ior) { return sqrt(1 - sine * sine / (ior * ior)); }

/* ---- media ---- */

/* Glass, water, glass, each 1 m thick. The water reaches 0.1 mm into both panes, which have
 * priority, so that no air lies between: the faces of water inside the glass are not there. */
static void build_filled_glass(double absorption) {
    rig_clear(&bench);
    snell_material_id glass = add_glass(&bench, 1.5, grey(0.25), 1);
    snell_material_id water = add_glass(&bench, 1.25, grey(absorption), 0);
    add_box(&bench, v3(-999, -999, 0), v3(999, 999, 1), glass);
    add_box(&bench, v3(-999, -999, 0.9999), v3(999, 999, 2.0001), water);
    add_box(&bench, v3(-999, -999, 2), v3(999, 999, 3), glass);
    MUST(snell_scene_set_background_gradient(bench.scene, grey(0), grey(2))); /* 1 + d.y */
    commit();
}

static void water_in_a_glass_touches_it(void **state) {
    (void)state;
    build_filled_glass(0.5);
    snell_vec3 from = v3(0, -3, 7), at = v3(0, 0, 3);
    double sine = 0.6, outside = 0.8, glass = cos_in(sine, 1.5), water = cos_in(sine, 1.25);
    double expected = pass(outside, 1, 1.5) * pass(glass, 1.5, 1.25) *
                      exp(-0.5 / water - 0.25 * 2 / glass) * pass(water, 1.25, 1.5) *
                      pass(glass, 1.5, 1) * (1 + sine);
    /* Looking along (0, 0.6, -0.8); four crossings, the last ray has depth 4. */
    double none = trace_ray(&bench, SNELL_WHITTED, from, at, 3).c[0];
    double four = trace_ray(&bench, SNELL_WHITTED, from, at, 4).c[0];
    snell_render_stats stats = stats_of(&bench);
    assert_int_equal(stats.media_mismatches, 0);
    assert_true(stats.rays_continued > 0); /* the hidden faces */
    /* What the first faces reflect comes back by the front, 1 + 0.6 of the sky too: the difference
     * of depths 3 and 4 is what four crossings bring, with nothing else of depth 4. */
    ASSERT_CLOSE(four - none, expected, 1e-5, 0);
}

static void the_eye_may_be_in_glass(void **state) {
    (void)state;
    double a = 0.25;
    MUST(snell_scene_set_background(bench.scene, grey(1), 1));
    add_sphere(&bench, v3(0, 0, 0), 2, add_glass(&bench, 1.5, grey(a), 0));
    commit();
    rgb got = trace_ray(&bench, SNELL_WHITTED, v3(0, 0, 0), v3(0, 0, -1), 1);
    ASSERT_CLOSE(got.c[0], 0.96 * exp(-2 * a), TOLERANCE, 0);
    assert_int_equal(stats_of(&bench).media_mismatches, 0);
    got = trace_ray(&bench, SNELL_WHITTED, v3(0, 0, 1), v3(0, 0, -1), 1);
    ASSERT_CLOSE(got.c[0], 0.96 * exp(-3 * a), TOLERANCE, 0);
}

/* Snell's window: from 2 m under water the sky is a disk, around it the water mirrors the ground. */
static void the_eye_may_be_under_water(void **state) {
    (void)state;
    double a = 0.125, ior = 1.25;
    MUST(snell_scene_set_background(bench.scene, grey(1), 1));
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_glass(&bench, ior, grey(a), 0));
    add_plane(&bench, v3(0, -4, 0), v3(0, 1, 0), add_glow(&bench, grey(0.5)));
    commit();
    for (int degrees = 0; degrees < 80; degrees += 5) {
        double angle = degrees * PI_ / 180, c = cos(angle), s = sin(angle);
        rgb got = trace_direction(&bench, SNELL_WHITTED, v3(0, -2, 0), s, c, 0, 1);
        double f = fresnel_dielectric(c, ior, 1);
        double expected = exp(-a * 2 / c) * ((1 - f) + f * 0.5 * exp(-a * 4 / c));
        ASSERT_CLOSE(got.c[0], expected, 1e-5, 0);
        assert_int_equal(f == 1, s * ior > 1);
    }
}

static void leaving_what_was_never_entered_is_counted(void **state) {
    (void)state;
    MUST(snell_scene_set_background(bench.scene, grey(0.75), 1));
    add_quad(&bench, v3(-1, -1, 0), v3(2, 0, 0), v3(0, 2, 0), add_glass(&bench, 1.5, grey(1), 0));
    commit();
    rgb got = trace_ray(&bench, SNELL_WHITTED, v3(0.1, 0.2, -3), v3(0.1, 0.2, 0), 5);
    assert_true(got.c[0] == 0.75); /* as if nothing were there */
    assert_int_equal(stats_of(&bench).media_mismatches, 1);
}

/* Nested balls, each of higher priority than the one around it. */
static double through_balls(int count, uint64_t *mismatches) {
    rig_clear(&bench);
    MUST(snell_scene_set_background(bench.scene, grey(1), 1));
    for (int i = 0; i < count; i++)
        add_sphere(&bench, v3(0, 0, 0), count - i,
                   add_glass(&bench, 1 + 0.125 * (i + 1), grey(0), i));
    commit();
    uint32_t depth = count < 8 ? (uint32_t)(2 * count) : 16; /* deeper takes long */
    double got = trace_ray(&bench, SNELL_WHITTED, v3(0, 0, 99), v3(0, 0, 0), depth).c[0];
    *mismatches = stats_of(&bench).media_mismatches;
    return got;
}

static void eight_media_at_once_are_enough(void **state) {
    (void)state;
    uint64_t mismatches;
    double expected = 1, previous = 1;
    for (int i = 0; i < 8; i++) {
        double ior = 1 + 0.125 * (i + 1);
        expected *= pass(1, previous, ior) * pass(1, previous, ior);
        previous = ior;
    }
    double got = through_balls(8, &mismatches);
    assert_int_equal(mismatches, 0);
    assert_true(got >= expected * (1 - TOLERANCE) && got <= 1); /* and what is reflected twice */
    got = through_balls(12, &mismatches);
    assert_true(mismatches > 0);
    assert_true(got > 0 && got <= 1);
}

/* A mesh whose dielectric is chosen by slots has the same inside as one whose instance has it. */
static void a_mesh_of_slots_has_a_medium(void **state) {
    (void)state;
    static const uint32_t faces[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    static const uint32_t slots[] = {1, 1, 1, 1};
    const snell_vec3 corners[] = {v3(-4, -1, 3), v3(4, -1, 3), v3(0, -1, -5), v3(0, 4, 0)};
    double got[2];
    for (int by_slot = 0; by_slot < 2; by_slot++) {
        rig_clear(&bench);
        snell_material_id plain = add_lambert(&bench, grey(0.5));
        snell_material_id glass = add_glass(&bench, 1.5, grey(0.25), 0);
        snell_material_id both[2] = {plain, glass};
        snell_mesh_desc desc = SNELL_INIT(mesh_desc);
        snell_shape_id shape;
        desc.positions = corners;
        desc.positions_count = 4;
        desc.indices = faces;
        desc.indices_count = 12;
        desc.material_slots = by_slot ? slots : NULL;
        desc.material_slots_count = by_slot ? 4 : 0;
        desc.materials = both;
        desc.materials_count = by_slot ? 2 : 0;
        MUST(snell_scene_add_mesh(bench.scene, &desc, &shape));
        place(&bench, shape, by_slot ? plain : glass);
        MUST(snell_scene_set_background(bench.scene, grey(1), 1));
        commit();
        got[by_slot] = trace_ray(&bench, SNELL_WHITTED, v3(0, 0.5, 0), v3(1, 1, 7), 6).c[0];
        assert_int_equal(stats_of(&bench).media_mismatches, 0);
        assert_int_equal(stats_of(&bench).film_overflows, 0);
        assert_true(got[by_slot] > 0 && got[by_slot] < 1);
    }
    assert_true(got[0] == got[1]);
}

/* ---- coloured glass ---- */

static snell_material_id add_stained(snell_vec3 color, double ior, double absorption,
                                     double alpha) {
    snell_dielectric_desc desc = SNELL_INIT(dielectric_desc);
    snell_material_id id;
    desc.color = flat(color);
    desc.ior = (float)ior;
    desc.absorption = grey(absorption);
    desc.alpha = flat(grey(alpha));
    MUST(snell_scene_add_dielectric(bench.scene, &desc, &id));
    return id;
}

static double channel(snell_vec3 v, int i) { return (double)(i == 0 ? v.x : i == 1 ? v.y : v.z); }

/* Two crossings: colour squared. What is reflected has no colour, even by black glass. */
static void a_stained_pane_colours_what_passes(void **state) {
    (void)state;
    const snell_vec3 colors[] = {{0.5f, 0.25f, 1}, {0, 0, 0}};
    double f = fresnel_dielectric(1, 1, 1.5);
    for (int k = 0; k < 2; k++) {
        rig_clear(&bench);
        MUST(snell_scene_set_background(bench.scene, grey(1), 1));
        add_box(&bench, v3(-9, -9, 0), v3(9, 9, 0.5), add_stained(colors[k], 1.5, 0, 1));
        commit();
        rgb got = trace_ray(&bench, SNELL_WHITTED, v3(0, 0, 3), v3(0, 0, 0), 2);
        for (int i = 0; i < 3; i++) {
            double c = channel(colors[k], i), expected = f + (1 - f) * c * (1 - f) * c;
            ASSERT_CLOSE(got.c[i], expected, TOLERANCE, 0);
        }
        assert_int_equal(stats_of(&bench).media_mismatches, 0);
    }
}

/* Light, and Appel, which shades glass as Lambert. */
static void a_stained_pane_colours_light(void **state) {
    (void)state;
    snell_vec3 color = v3(0.5, 0.25, 0);
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_lambert(&bench, grey(0.5)));
    add_box(&bench, v3(-99, 1, -99), v3(99, 1.5, 99), add_stained(color, 1.5, 0.75, 1));
    add_sun(&bench, v3(0, -1, 0), grey(4));
    commit();
    double pane = pass(1, 1, 1.5) * pass(1, 1, 1.5) * exp(-0.75 * 0.5);
    rgb below = trace_ray(&bench, SNELL_WHITTED, v3(0, 0.5, 3), v3(0, 0, 0), 0);
    rgb above = trace_ray(&bench, SNELL_APPEL, v3(0, 3, 3), v3(0, 1.5, 0), 0);
    for (int i = 0; i < 3; i++) {
        double c = channel(color, i);
        ASSERT_CLOSE(below.c[i], 0.5 / PI_ * 4 * pane * c * c, TOLERANCE, 0);
        ASSERT_CLOSE(above.c[i], c / PI_ * 4, TOLERANCE, 0);
    }
}

/* The faces of stained water inside a pane of higher priority are not there: they colour neither
 * what is seen nor light. */
static void hidden_faces_have_no_colour(void **state) {
    (void)state;
    snell_material_id glass = add_glass(&bench, 1.5, grey(0), 1);
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_lambert(&bench, grey(0.5)));
    add_box(&bench, v3(-99, 1, -99), v3(99, 2, 99), glass);
    add_box(&bench, v3(-99, 1.25, -99), v3(99, 1.75, 99), add_stained(grey(0.25), 1.25, 0, 1));
    add_sun(&bench, v3(0, -1, 0), grey(4));
    commit();
    double pane = pass(1, 1, 1.5) * pass(1, 1, 1.5), lit = 0.5 / PI_ * 4 * pane;
    rgb below = trace_ray(&bench, SNELL_WHITTED, v3(0, 0.5, 3), v3(0, 0, 0), 0);
    ASSERT_CLOSE(below.c[0], lit, TOLERANCE, 0);
    rgb above = trace_ray(&bench, SNELL_WHITTED, v3(0, 3, 0), v3(0, 0, 0), 2);
    ASSERT_CLOSE(above.c[0], lit * pane, TOLERANCE, 0);
    assert_int_equal(stats_of(&bench).rays_continued, 4); /* what is reflected meets them too */
}

/* Glass that is there in part: a ray either meets the whole of it or nothing. Rays that had passed
 * its front were said to leave what they had never entered, and some never left it. */
static void glass_may_be_there_in_part(void **state) {
    (void)state;
    for (int i = 0; i <= 4; i++) {
        rig_clear(&bench);
        double alpha = i / 4.0, f = fresnel_dielectric(1, 1, 1.5), inside = exp(-0.5 * 2);
        MUST(snell_scene_set_background(bench.scene, grey(1), 1));
        add_box(&bench, v3(-9, -9, 0), v3(9, 9, 2), add_stained(grey(0.5), 1.5, 0.5, alpha));
        commit();
        rgb got = trace_ray(&bench, SNELL_WHITTED, v3(0, 0, 5), v3(0, 0, 0), 2);
        double whole = f + (1 - f) * (1 - f) * 0.25 * inside;
        ASSERT_CLOSE(got.c[0], alpha * whole + (1 - alpha), TOLERANCE, 0);
        assert_int_equal(stats_of(&bench).media_mismatches, 0);
    }
}

/* ---- shadows ---- */

enum { FILTER, OPAQUE, NONE };

/* A floor seen from the side, the light through a pane of glass 0.5 m thick, 1 m above. */
static double floor_under_pane(double degrees, double absorption, int shadow) {
    rig_clear(&bench);
    snell_dielectric_desc desc = SNELL_INIT(dielectric_desc);
    snell_material_id glass;
    desc.absorption = grey(absorption);
    desc.shadow = shadow;
    MUST(snell_scene_add_dielectric(bench.scene, &desc, &glass));
    double angle = degrees * PI_ / 180;
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_lambert(&bench, grey(0.5)));
    add_box(&bench, v3(-99, 1, -99), v3(99, 1.5, 99), glass);
    add_sun(&bench, v3(-sin(angle), -cos(angle), 0), grey(4));
    commit();
    return trace_ray(&bench, SNELL_WHITTED, v3(0, 0.5, 3), v3(0, 0, 0), 5).c[0];
}

static void light_goes_through_a_pane(void **state) {
    (void)state;
    for (int degrees = 0; degrees < 85; degrees += 10) {
        double c = cos(degrees * PI_ / 180), lit = 0.5 / PI_ * 4 * c, f = pass(c, 1, 1.5);
        double expected = lit * f * f * exp(-0.75 * 0.5 / c);
        ASSERT_CLOSE(floor_under_pane(degrees, 0.75, FILTER), expected, TOLERANCE, 0);
        ASSERT_CLOSE(floor_under_pane(degrees, 0, FILTER), lit * f * f, TOLERANCE, 0);
        assert_true(floor_under_pane(degrees, 0.75, OPAQUE) == 0);
        ASSERT_CLOSE(floor_under_pane(degrees, 0.75, NONE), lit, TOLERANCE, 0);
    }
}

/* A floor under water that casts no shadow is lit as if there were none; a card far away that lets
 * light through does not change that. */
static void water_without_shadow_takes_no_light(void **state) {
    (void)state;
    double got[2];
    for (int card = 0; card < 2; card++) {
        rig_clear(&bench);
        snell_dielectric_desc desc = SNELL_INIT(dielectric_desc);
        snell_material_id water;
        desc.ior = 1;
        desc.absorption = grey(0.5);
        desc.shadow = NONE;
        MUST(snell_scene_add_dielectric(bench.scene, &desc, &water));
        add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), water);
        add_plane(&bench, v3(0, -2, 0), v3(0, 1, 0), add_lambert(&bench, grey(0.5)));
        add_point(&bench, v3(0, 4, 0), grey(90));
        if (card)
            add_quad(&bench, v3(50, 50, 50), v3(1, 0, 0), v3(0, 1, 0),
                     add_card(&bench, grey(0), 0.5));
        commit();
        got[card] = trace_ray(&bench, SNELL_WHITTED, v3(0, -1, 0), v3(0, -2, 0), 0).c[0];
        ASSERT_CLOSE(got[card], exp(-0.5) * 0.5 / PI_ * 90 / 36, TOLERANCE, 0);
    }
    assert_true(got[0] == got[1]);
}

/* The light hangs in the water: only the way to it absorbs, and no surface is crossed. */
static void a_light_under_water_is_absorbed(void **state) {
    (void)state;
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_glass(&bench, 1.25, v3(0.5, 0.25, 0), 0));
    add_plane(&bench, v3(0, -4, 0), v3(0, 1, 0), add_lambert(&bench, grey(0.5)));
    add_point(&bench, v3(0, -2, 0), grey(8));
    commit();
    rgb got = trace_ray(&bench, SNELL_WHITTED, v3(0, -3, 0), v3(0, -4, 0), 0);
    double lit = 0.5 / PI_ * 8 / 4;
    ASSERT_CLOSE(got.c[0], lit * exp(-0.5 * 3), TOLERANCE, 0);
    ASSERT_CLOSE(got.c[1], lit * exp(-0.25 * 3), TOLERANCE, 0);
    ASSERT_CLOSE(got.c[2], lit, TOLERANCE, 0);
}

/* Two cards that are 0.3 there, apart or in the same place: 0.7 twice, each counted once. Cards
 * that glow light a black floor in vain. */
static void alpha_is_counted_once_each(void **state) {
    (void)state;
    for (int apart = 0; apart < 2; apart++)
        for (int variant = 0; variant < 4; variant++) {
            bool same_shape = variant & 1, glows = variant & 2;
            rig_clear(&bench);
            snell_lambert_desc desc = SNELL_INIT(lambert_desc);
            snell_material_id card;
            desc.color = flat(grey(0));
            desc.alpha = flat(grey(0.3));
            desc.emission = flat(grey(glows));
            desc.emit_two_sided = true;
            MUST(snell_scene_add_lambert(bench.scene, &desc, &card));
            snell_material_id matte = add_lambert(&bench, grey(glows ? 0 : 0.5));
            add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), matte);
            snell_vec3 low = v3(-9, 1, -9), high = v3(-9, apart ? 2 : 1, -9);
            add_quad(&bench, low, v3(0, 0, 18), v3(18, 0, 0), card);
            if (same_shape)
                add_quad(&bench, high, v3(0, 0, 18), v3(18, 0, 0), card);
            else
                add_quad(&bench, high, v3(18, 0, 0), v3(0, 0, 18), card);
            add_point(&bench, v3(0, 4, 0), grey(16));
            commit();
            double lit = glows ? 0 : 0.5 / PI_ * 0.7 * 0.7, glow = glows ? 0.3 + 0.7 * 0.3 : 0;
            rgb below = trace_ray(&bench, SNELL_WHITTED, v3(0.5, 0.5, 0), v3(0, 0, 0), 0);
            ASSERT_CLOSE(below.c[0], lit, TOLERANCE, 0);
            rgb above = trace_ray(&bench, SNELL_WHITTED, v3(0.5, 8, 0), v3(0, 0, 0), 0);
            ASSERT_CLOSE(above.c[0], glow + 0.49 * lit, TOLERANCE, 0);
            assert_int_equal(stats_of(&bench).rays_continued, 2);
        }
}

/* To the eye glass of alpha 0 was not there, but light was absorbed in it. */
static void clear_glass_absorbs_nothing(void **state) {
    (void)state;
    snell_dielectric_desc desc = SNELL_INIT(dielectric_desc);
    snell_material_id nothing;
    desc.absorption = grey(1);
    desc.alpha = flat(grey(0));
    MUST(snell_scene_add_dielectric(bench.scene, &desc, &nothing));
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_lambert(&bench, grey(0.5)));
    add_box(&bench, v3(-1, 1, -1), v3(1, 3, 1), nothing);
    add_sun(&bench, v3(0, -1, 0), grey(1));
    commit();
    for (int y = 0; y < 3; y++) { /* below it, in it, above it */
        rgb seen = trace_ray(&bench, SNELL_WHITTED, v3(0.5, 0.5 + 2 * y, 0), v3(0, 0, 0), 4);
        ASSERT_CLOSE(seen.c[0], 0.5 / PI_, TOLERANCE, 0);
    }
}

/* Vertex alpha let no light through where the mesh chose its materials by slots. */
static void vertex_alpha_lets_light_through(void **state) {
    (void)state;
    for (int slots = 0; slots < 2; slots++) {
        rig_clear(&bench);
        snell_material_id matte = add_lambert(&bench, grey(0.5));
        add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), matte);
        const snell_vec3 positions[] = {{-9, 1, -9}, {-9, 1, 9}, {9, 1, 0}};
        const uint32_t indices[] = {0, 1, 2}, slot = 0;
        const uint8_t alphas[] = {51, 51, 51}; /* 0.2 */
        snell_mesh_desc desc = SNELL_INIT(mesh_desc);
        snell_shape_id id;
        desc.positions = positions, desc.positions_count = 3;
        desc.indices = indices, desc.indices_count = 3;
        desc.alphas = alphas, desc.alphas_count = 3;
        if (slots) {
            desc.material_slots = &slot, desc.material_slots_count = 1;
            desc.materials = &matte, desc.materials_count = 1;
        }
        MUST(snell_scene_add_mesh(bench.scene, &desc, &id));
        place(&bench, id, matte);
        add_sun(&bench, v3(0, -1, 0), grey(1));
        commit();
        rgb below = trace_ray(&bench, SNELL_WHITTED, v3(-1, 0.5, 0), v3(-1, 0, 0), 0);
        ASSERT_CLOSE(below.c[0], 0.5 / PI_ * 0.8, TOLERANCE, 0);
    }
}

/* Past a thousand of them light was silently lost; what is too much is an error. */
static void light_passes_many_cards(void **state) {
    (void)state;
    static const int counts[] = {1100, 10050};
    for (int i = 0; i < 2; i++) {
        rig_clear(&bench);
        add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_lambert(&bench, grey(0.5)));
        snell_material_id clear = add_card(&bench, grey(0.5), 0);
        snell_quad_desc desc = SNELL_INIT(quad_desc);
        snell_shape_id card;
        desc.corner = v3(-9, 0, -9), desc.u = v3(0, 0, 18), desc.v = v3(18, 0, 0);
        MUST(snell_scene_add_quad(bench.scene, &desc, &card));
        for (int j = 0; j < counts[i]; j++) {
            snell_transform up = {{{1, 0, 0, 0}, {0, 1, 0, 1 + 0.01f * (float)j}, {0, 0, 1, 0}}};
            MUST(snell_scene_add_instance(bench.scene, card, clear, &up, NULL));
        }
        add_sun(&bench, v3(0, -1, 0), grey(1));
        commit();
        if (i == 0) {
            rgb below = trace_ray(&bench, SNELL_WHITTED, v3(0.5, 0.5, 0), v3(0, 0, 0), 0);
            ASSERT_CLOSE(below.c[0], 0.5 / PI_, TOLERANCE, 0);
            continue;
        }
        snell_render_desc d = picture(SNELL_WHITTED, 1, 1, 0);
        snell_view view = look(v3(0.5, 0.5, 0), v3(0, 0, 0));
        d.view = &view;
        assert_int_equal(snell_render(bench.scene, &d, bench.film), SNELL_ERR_UNSUPPORTED);
        assert_true(snell_last_error()->text[0] != '\0');
    }
}

/* More shadow rays than a wave holds. */
static void many_lights_add_up(void **state) {
    (void)state;
    enum { LIGHTS = 6000 };
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_lambert(&bench, grey(1)));
    add_sphere(&bench, v3(0, 1, 0), 0.5, add_lambert(&bench, grey(1)));
    for (int i = 0; i < LIGHTS; i++) add_point(&bench, v3(i % 2 ? 5 : 0, 4, 0), grey(1));
    commit();
    double expected = LIGHTS / 2 / PI_ * 4 / pow(41, 1.5); /* half of them are behind the ball */
    for (uint32_t wave = 0; wave < 3; wave++) {
        snell_render_desc desc = picture(SNELL_WHITTED, 1, 1, 0);
        snell_view view = look(v3(0, 0.4, 2), v3(0, 0, 0));
        desc.view = &view;
        desc.wave_size = wave * wave * 500;
        MUST(snell_render(bench.scene, &desc, bench.film));
        ASSERT_CLOSE(pixel_at(&bench, 0, 0).c[0], expected, TOLERANCE, 0);
        assert_int_equal(stats_of(&bench).rays_shadow, LIGHTS);
    }
}

/* ---- mirrors and coats ---- */

static double seen_on_floor(snell_material_id m, uint64_t *reflected) {
    MUST(snell_scene_set_background(bench.scene, grey(0.5), 1));
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), m);
    add_sun(&bench, v3(0, -1, 0), grey(2));
    commit();
    double got = trace_ray(&bench, SNELL_WHITTED, v3(0, 3, 4), v3(0, 0, 0), 8).c[0];
    *reflected = stats_of(&bench).rays_reflected;
    return got;
}

static void a_partial_mirror_is_both(void **state) {
    (void)state;
    for (int i = 0; i <= 4; i++) {
        rig_clear(&bench);
        double s = i / 4.0;
        uint64_t reflected;
        snell_partial_mirror_desc desc = SNELL_INIT(partial_mirror_desc);
        snell_material_id m;
        desc.color = flat(grey(0.75));
        desc.specularity = flat(grey(s));
        MUST(snell_scene_add_partial_mirror(bench.scene, &desc, &m));
        double expected = 0.75 * (s * 0.5 + (1 - s) * 2 / PI_);
        ASSERT_CLOSE(seen_on_floor(m, &reflected), expected, TOLERANCE, 0);
        assert_int_equal(reflected, s > 0);
    }
}

static snell_material_id add_glaze(snell_material_id base, double reflectance, double ior) {
    snell_glazed_desc desc = SNELL_INIT(glazed_desc);
    snell_material_id m;
    desc.base = base;
    desc.reflectance = flat(grey(reflectance));
    desc.ior = (float)ior;
    MUST(snell_scene_add_glazed(bench.scene, &desc, &m));
    return m;
}

static void a_glaze_never_traces_its_base(void **state) {
    (void)state;
    uint64_t reflected;
    double got = seen_on_floor(add_glaze(add_mirror(&bench, grey(1)), 0.25, 0), &reflected);
    ASSERT_CLOSE(got, 0.25 * 0.5, TOLERANCE, 0);
    assert_int_equal(reflected, 1);
    rig_clear(&bench);
    snell_partial_mirror_desc desc = SNELL_INIT(partial_mirror_desc);
    snell_material_id base;
    desc.color = flat(grey(1));
    MUST(snell_scene_add_partial_mirror(bench.scene, &desc, &base));
    got = seen_on_floor(add_glaze(base, 0.25, 0), &reflected);
    ASSERT_CLOSE(got, 0.25 * 0.5 + 0.5 * 2 / PI_, TOLERANCE, 0);
    assert_int_equal(reflected, 1);
    rig_clear(&bench); /* with an ior, the coat reflects what Fresnel says */
    got = seen_on_floor(add_glaze(add_lambert(&bench, grey(0.5)), 0, 1.5), &reflected);
    ASSERT_CLOSE(got, fresnel_dielectric(0.6, 1, 1.5) * 0.5 + 0.5 * 2 / PI_, TOLERANCE, 0);
    rig_clear(&bench); /* Appel shades the coat as Lambert, as strong as it reflects */
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_glaze(add_lambert(&bench, grey(0.5)), 0, 1.5));
    add_sun(&bench, v3(0, -1, 0), grey(2));
    commit();
    got = trace_ray(&bench, SNELL_APPEL, v3(0, 3, 4), v3(0, 0, 0), 0).c[0];
    ASSERT_CLOSE(got, (0.5 + fresnel_dielectric(0.6, 1, 1.5)) * 2 / PI_, TOLERANCE, 0);
    assert_int_equal(stats_of(&bench).rays_reflected, 0);
}

static void parts_of_a_glaze_are_checked(void **state) {
    (void)state;
    snell_glazed_desc desc = SNELL_INIT(glazed_desc);
    snell_material_id m;
    assert_int_equal(snell_scene_add_glazed(bench.scene, &desc, &m), SNELL_ERR_ARGUMENT);
    desc.base = add_glaze(add_lambert(&bench, grey(1)), 0.5, 0);
    assert_int_equal(snell_scene_add_glazed(bench.scene, &desc, &m), SNELL_ERR_ARGUMENT);
    desc.base = add_glass(&bench, 1.5, grey(0), 0);
    assert_int_equal(snell_scene_add_glazed(bench.scene, &desc, &m), SNELL_ERR_ARGUMENT);
    desc.base.index1 = 99;
    assert_int_equal(snell_scene_add_glazed(bench.scene, &desc, &m), SNELL_ERR_ARGUMENT);
}

/* What shines or is cut out under a glaze was as if it did not and were not. */
static void a_glaze_shows_what_its_base_sends(void **state) {
    (void)state;
    snell_lambert_desc base = SNELL_INIT(lambert_desc);
    snell_glazed_desc glaze = SNELL_INIT(glazed_desc);
    snell_material_id m;
    base.color = flat(grey(0));
    base.ambient = grey(0);
    base.emission = flat(v3(3, 2, 1));
    base.alpha = flat(grey(0.5));
    MUST(snell_scene_add_lambert(bench.scene, &base, &glaze.base));
    glaze.reflectance = flat(grey(0));
    glaze.emission = flat(grey(1)); /* its own is added, its own alpha multiplied */
    glaze.alpha = flat(grey(0.5));
    MUST(snell_scene_add_glazed(bench.scene, &glaze, &m));
    add_quad(&bench, v3(-1, 4, -1), v3(2, 0, 0), v3(0, 0, 2), m);
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_lambert(&bench, grey(0.5)));
    add_plane(&bench, v3(0, 9, 0), v3(0, -1, 0), add_glow(&bench, grey(8)));
    commit();
    const double shows[3] = {0.25 * 4 + 0.75 * 8, 0.25 * 3 + 0.75 * 8, 0.25 * 2 + 0.75 * 8};
    rgb seen = trace_ray(&bench, SNELL_WHITTED, v3(0, 1, 0), v3(0, 4, 0), 1);
    for (int k = 0; k < 3; k++) ASSERT_CLOSE(seen.c[k], shows[k], TOLERANCE, 0);
    /* It lights the floor as a light does: from its middle, for the solid angle of the square. */
    rgb lit = trace_ray(&bench, SNELL_WHITTED, v3(2, 3, 0), v3(0, 0, 0), 1);
    double middle = 0.5 / PI_ * 4 * atan(1 / (4 * sqrt(18)));
    for (int k = 0; k < 3; k++) ASSERT_CLOSE(lit.c[k], middle * 0.25 * (4 - k), TOLERANCE, 0);
}

/* ---- dispersion ---- */

static snell_material_id add_prism_glass(double ior, double dispersion, double roughness) {
    snell_dielectric_desc desc = SNELL_INIT(dielectric_desc);
    snell_material_id id;
    desc.ior = (float)ior;
    desc.dispersion = (float)dispersion;
    desc.roughness = flat(grey(roughness));
    MUST(snell_scene_add_dielectric(bench.scene, &desc, &id));
    return id;
}

/* n = n_d + (n_d - 1) / V (523655 / wavelength^2 - 1.5168), as the extension's text has it. */
static double ior_of_color(double ior, double dispersion, int color) {
    static const double wavelengths_nm[3] = {611.4, 549.1, 464.2};
    double w = wavelengths_nm[color];
    return ior + (ior - 1) * dispersion / 20 * (523655 / (w * w) - 1.5168);
}

static void build_ball(double ior, double dispersion, double roughness) {
    rig_clear(&bench);
    MUST(snell_scene_set_background_gradient(bench.scene, grey(0), grey(2)));
    add_sphere(&bench, v3(0, 0, 0), 1, add_prism_glass(ior, dispersion, roughness));
    commit();
}

/* One pixel from many samples through its centre. */
static rgb many(snell_integrator policy, snell_vec3 from, snell_vec3 at, uint32_t depth,
                uint32_t samples) {
    snell_render_desc desc = picture(policy, 1, 1, depth);
    snell_view view = look(from, at);
    view.fov = 2e-4f;
    desc.view = &view;
    desc.samples = samples;
    desc.pixel_center = false;
    MUST(snell_render(bench.scene, &desc, bench.film));
    return pixel_at(&bench, 0, 0);
}

/* Each colour sees what glass of its own index shows. Fraunhofer's lines F and C are as far apart as
 * the Abbe number says. */
static void colours_part_in_glass(void **state) {
    (void)state;
    const double ior = 1.6, dispersion = 2, n_f = 523655 / (486.1 * 486.1),
                 n_c = 523655 / (656.3 * 656.3);
    ASSERT_CLOSE(n_f - n_c, 1, 1e-3, 0);
    const snell_vec3 from = v3(0, 0.9, 5), at = v3(0, 0.9, 0); /* off the ball's middle */
    rgb apart[3], together;
    for (int color = 0; color < 3; color++) {
        build_ball(ior_of_color(ior, dispersion, color), 0, 0);
        apart[color] = trace_ray(&bench, SNELL_WHITTED, from, at, 8);
    }
    build_ball(ior, dispersion, 0);
    together = trace_ray(&bench, SNELL_WHITTED, from, at, 8);
    for (int color = 0; color < 3; color++)
        ASSERT_CLOSE(together.c[color], apart[color].c[color], 1e-6, 0);
    assert_true(fabs(together.c[0] - together.c[2]) > 0.01);
    rgb drawn = many(SNELL_PATH, from, at, 8, 1 << 15), tree = many(SNELL_COOK, from, at, 8, 16);
    for (int color = 0; color < 3; color++) {
        ASSERT_CLOSE(drawn.c[color], together.c[color], 0.03, 0);
        ASSERT_CLOSE(tree.c[color], together.c[color], 1e-3, 0);
    }
    build_ball(ior, 0, 0); /* without, they stay together */
    together = trace_ray(&bench, SNELL_WHITTED, from, at, 8);
    assert_true(together.c[0] == together.c[1] && together.c[1] == together.c[2]);
}

/* Through two faces alone: longer ways make rare bright samples. */
static void colours_part_in_rough_glass(void **state) {
    (void)state;
    const double ior = 1.6, dispersion = 10;
    const snell_vec3 from = v3(0, 0.85, 5), at = v3(0, 0.85, 0);
    rgb apart[3];
    for (int color = 0; color < 3; color++) {
        build_ball(ior_of_color(ior, dispersion, color), 0, 0.2);
        apart[color] = many(SNELL_COOK, from, at, 2, 1 << 13);
    }
    build_ball(ior, dispersion, 0.2);
    rgb drawn = many(SNELL_PATH, from, at, 2, 1 << 15),
        tree = many(SNELL_COOK, from, at, 2, 1 << 13);
    for (int color = 0; color < 3; color++) {
        ASSERT_CLOSE(tree.c[color], apart[color].c[color], 0.01, 0);
        ASSERT_CLOSE(drawn.c[color], apart[color].c[color], 0.03, 0);
    }
    assert_true(apart[0].c[0] > 1.02 * apart[2].c[2]);
}

/* ---- energy ---- */

/* Inside a ball that shines with 1 everywhere, clear glass and a perfect mirror cannot be seen. */
static void a_white_furnace_is_white(void **state) {
    (void)state;
    MUST(snell_scene_set_ambient(bench.scene, grey(1)));
    add_sphere(&bench, v3(0, 0, 0), 50, add_lambert(&bench, grey(0.8))); /* k_a is 1 */
    add_sphere(&bench, v3(-1.5, 0, 0), 1, add_glass(&bench, 1.5, grey(0), 0));
    add_sphere(&bench, v3(-1.5, 0, 0), 0.5, add_glass(&bench, 1.25, grey(0), 1));
    add_box(&bench, v3(1, -1, -1), v3(2, 1, 1), add_glass(&bench, 1.75, grey(0), 0));
    add_sphere(&bench, v3(0, 2, 0), 0.75, add_mirror(&bench, grey(1)));
    commit();
    snell_render_desc desc = picture(SNELL_WHITTED, 12, 12, 200);
    snell_view view = look(v3(0, 1, 7), v3(0, 0.3, 0));
    view.fov = 0.9f;
    desc.view = &view;
    /* Some light goes round in the box for ever: what is dropped is what is missing. */
    desc.min_weight = 1e-4f;
    MUST(snell_render(bench.scene, &desc, bench.film));
    double sum = 0;
    for (uint32_t i = 0; i < 12 * 12; i++) {
        double got = pixel_at(&bench, i % 12, i / 12).c[0];
        assert_true(got <= 1 + 1e-5);
        sum += got;
    }
    double mean = sum / (12 * 12), dropped = stats_of(&bench).dropped_weight;
    ASSERT_CLOSE(mean + dropped, 1, 1e-5, 0);
    assert_true(mean > 0.99);
    assert_int_equal(stats_of(&bench).media_mismatches, 0);
}

/* Vertex normals that lie in the surface, point below it, or are 0, under every material. */
static void senseless_normals_give_no_nan(void **state) {
    (void)state;
    uint64_t random = 3;
    enum { SIDE = 12, COUNT = SIDE * SIDE };
    snell_vec3 positions[COUNT], normals[COUNT];
    uint32_t indices[(SIDE - 1) * (SIDE - 1) * 6], count = 0;
    for (uint32_t i = 0; i < COUNT; i++) {
        positions[i] = v3(i % SIDE, 0.3 * uniform(&random), i / SIDE);
        double down = i % 3 == 0 ? -1 : 0;
        normals[i] =
            v3(uniform(&random) - 0.5, i % 4 ? down : uniform(&random), uniform(&random) - 0.5);
        if (i % 5 == 0) normals[i] = v3(0, 0, 0);
        if (i % 7 == 0) normals[i] = v3(0, -1e-30, 1e-38);
    }
    for (uint32_t z = 0; z + 1 < SIDE; z++)
        for (uint32_t x = 0; x + 1 < SIDE; x++) {
            uint32_t a = z * SIDE + x;
            const uint32_t quad[6] = {a, a + SIDE, a + 1, a + 1, a + SIDE, a + SIDE + 1};
            memcpy(indices + count, quad, sizeof quad);
            count += 6;
        }
    for (int kind = 0; kind < 5; kind++) {
        rig_clear(&bench);
        snell_mesh_desc desc = SNELL_INIT(mesh_desc);
        snell_shape_id mesh;
        desc.positions = positions;
        desc.normals = normals;
        desc.indices = indices;
        desc.positions_count = desc.normals_count = COUNT;
        desc.indices_count = count;
        MUST(snell_scene_add_mesh(bench.scene, &desc, &mesh));
        snell_blinn_phong_desc shiny = SNELL_INIT(blinn_phong_desc);
        snell_material_id phong;
        MUST(snell_scene_add_blinn_phong(bench.scene, &shiny, &phong));
        snell_material_id kinds[5] = {add_lambert(&bench, grey(1)), phong,
                                      add_mirror(&bench, grey(1)),
                                      add_glass(&bench, 1.5, grey(1), 0), add_glaze(phong, 0, 1.5)};
        place(&bench, mesh, kinds[kind]);
        MUST(snell_scene_set_background(bench.scene, grey(1), 1));
        add_point(&bench, v3(4, 3, 4), grey(9));
        commit();
        for (int below = 0; below < 2; below++) {
            snell_render_desc render = picture(SNELL_WHITTED, 64, 48, 12);
            snell_view view = look(v3(5, below ? -2 : 2, 16), v3(5.5, 0, 5.5));
            render.view = &view;
            MUST(snell_render(bench.scene, &render, bench.film));
            assert_int_equal(stats_of(&bench).film_overflows, 0);
            for (uint32_t i = 0; i < 64 * 48; i++) {
                double got = pixel_at(&bench, i % 64, i / 64).c[0];
                assert_true(got >= 0 && got < 1e4);
            }
        }
    }
}

/* Coverage is not colour: seen through red-absorbing water, what is there is there. */
static void coverage_is_not_absorbed(void **state) {
    (void)state;
    add_plane(&bench, v3(0, 0, 0), v3(0, 1, 0), add_glass(&bench, 1.25, v3(2, 0, 0), 0));
    add_quad(&bench, v3(-1, -4, -1), v3(0, 0, 2), v3(2, 0, 0), add_card(&bench, grey(0.5), 0.25));
    commit();
    snell_render_desc desc = picture(SNELL_WHITTED, 1, 1, 2);
    snell_view view = look(v3(0.1, -1, 0.1), v3(0.1, -4, 0.1));
    desc.view = &view;
    desc.transparent = true;
    MUST(snell_render(bench.scene, &desc, bench.film));
    uint32_t channels;
    const float *p = snell_film_pixels(bench.film, NULL, NULL, &channels);
    assert_int_equal(channels, 4);
    assert_true(p[3] == 0.25f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(water_in_a_glass_touches_it, fresh),
        cmocka_unit_test_setup(the_eye_may_be_in_glass, fresh),
        cmocka_unit_test_setup(the_eye_may_be_under_water, fresh),
        cmocka_unit_test_setup(leaving_what_was_never_entered_is_counted, fresh),
        cmocka_unit_test_setup(eight_media_at_once_are_enough, fresh),
        cmocka_unit_test_setup(a_mesh_of_slots_has_a_medium, fresh),
        cmocka_unit_test_setup(a_stained_pane_colours_what_passes, fresh),
        cmocka_unit_test_setup(a_stained_pane_colours_light, fresh),
        cmocka_unit_test_setup(hidden_faces_have_no_colour, fresh),
        cmocka_unit_test_setup(glass_may_be_there_in_part, fresh),
        cmocka_unit_test_setup(light_goes_through_a_pane, fresh),
        cmocka_unit_test_setup(water_without_shadow_takes_no_light, fresh),
        cmocka_unit_test_setup(a_light_under_water_is_absorbed, fresh),
        cmocka_unit_test_setup(alpha_is_counted_once_each, fresh),
        cmocka_unit_test_setup(clear_glass_absorbs_nothing, fresh),
        cmocka_unit_test_setup(vertex_alpha_lets_light_through, fresh),
        cmocka_unit_test_setup(light_passes_many_cards, fresh),
        cmocka_unit_test_setup(many_lights_add_up, fresh),
        cmocka_unit_test_setup(a_partial_mirror_is_both, fresh),
        cmocka_unit_test_setup(a_glaze_never_traces_its_base, fresh),
        cmocka_unit_test_setup(parts_of_a_glaze_are_checked, fresh),
        cmocka_unit_test_setup(a_glaze_shows_what_its_base_sends, fresh),
        cmocka_unit_test_setup(colours_part_in_glass, fresh),
        cmocka_unit_test_setup(colours_part_in_rough_glass, fresh),
        cmocka_unit_test_setup(a_white_furnace_is_white, fresh),
        cmocka_unit_test_setup(senseless_normals_give_no_nan, fresh),
        cmocka_unit_test_setup(coverage_is_not_absorbed, fresh),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
