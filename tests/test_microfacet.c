/* Microfacets against tests/reference/cases.json, and a material by itself through the public API. */
#include <math.h>
#include <string.h>

#include "maths/functions.h"
#include "materials/microfacet.h"
#include "reference.h"
#include "render_test.h"

static double number(const json_t *scene, const char *name) {
    return json_number_value(json_object_get(scene, name));
}

static dvec3 vector(const json_t *scene, const char *name) {
    const json_t *v = json_object_get(scene, name);
    return (dvec3){reference_number(v, 0), reference_number(v, 1), reference_number(v, 2)};
}

/* ---- I.beckmann, I.smith ---- */

static double close_rows; /* how many rows were looked at */

static void beckmann(const reference_case *c) {
    double m = number(c->scene, "m");
    size_t index;
    json_t *row;
    json_array_foreach(json_object_get(c->expected, "rows"), index, row) {
        double cosine = cos(reference_number(row, 0) * PI / 180);
        assert_true(reference_agrees(c, beckmann_d(cosine, m), reference_number(row, 1)));
        close_rows++;
    }
    assert_true(beckmann_d(0, m) == 0 && beckmann_d(-0.5, m) == 0);
    /* int D cos dw in t = tan^2 / m^2, which its bulk is even in: cos dw = pi m^2 cos^4 dt. */
    double sum = 0;
    enum { STEPS = 200000 };
    for (int i = 0; i < STEPS; i++) {
        double t = 40 * (i + 0.5) / STEPS, cos2 = 1 / (1 + t * m * m);
        sum += beckmann_d(sqrt(cos2), m) * PI * m * m * cos2 * cos2 * 40 / STEPS;
    }
    assert_true(reference_agrees(c, sum, number(c->expected, "normalisation")));
}

static void beckmann_facets(void **state) {
    (void)state;
    assert_int_equal(reference_each("I.beckmann", beckmann), 4);
    assert_true(close_rows == 36);
}

static double exact_g1(double a) { return 2 / (1 + erf(a) + exp(-a * a) / (a * sqrt(PI))); }

/* Of the rational fit at a = 1 / (m tan): m = 1 makes a the cotangent. */
static double fit_at(double a) { return beckmann_g1(a / sqrt(1 + a * a), 1); }

static void fit_error(const reference_case *c) {
    double most = 0, least = 0;
    for (int i = 0; i < 400000; i++) {
        double a = 1e-4 + (4 - 1e-4) * i / 399999, e = fit_at(a) / exact_g1(a) - 1;
        most = e > most ? e : most;
        least = e < least ? e : least;
    }
    assert_true(reference_agrees(c, most, number(c->expected, "max_rel")));
    assert_true(reference_agrees(c, least, number(c->expected, "min_rel")));
    assert_true(reference_agrees(c, fit_at(1.6 - 1e-9), number(c->expected, "at_1_6")));
}

static void smith(const reference_case *c) {
    if (strcmp(c->name, "walter_G1_vs_exact") == 0) {
        fit_error(c);
        return;
    }
    size_t index;
    json_t *row;
    json_array_foreach(c->expected, index, row) {
        double cosine = cos(reference_number(row, 0) * PI / 180);
        double got = beckmann_g1(cosine, number(c->scene, "m"));
        assert_true(reference_agrees(c, got, reference_number(row, 2)));
    }
}

static void shadowing(void **state) {
    (void)state;
    assert_int_equal(reference_each("I.smith", smith), 5);
}

/* ---- I.cook_torrance, I.ct_albedo ---- */

static bsdf cook_torrance(double m, double ior) {
    bsdf b = {.ior1 = 1, .ior2 = 1};
    lobe *l = bsdf_add(&b, &lobe_cook_torrance, (dvec3){1, 1, 1}, m);
    if (ior > 0) l->fresnel = fresnel_of_ior(ior);
    return b;
}

static void brdf(const reference_case *c) {
    bsdf b = cook_torrance(number(c->scene, "m"), number(c->scene, "ior"));
    dvec3 n = vector(c->scene, "normal"), l = vector(c->scene, "to_light"),
          v = vector(c->scene, "to_eye");
    double f = number(c->expected, "f");
    assert_true(reference_agrees(c, bsdf_evaluate(&b, LOBES_LIT, n, v, l).x, f));
    assert_true(reference_agrees(c, bsdf_evaluate(&b, LOBES_LIT, n, l, v).x, f));
    dvec3 h = dvec3_normalize(dvec3_add(l, v));
    double m = number(c->scene, "m"),
           g = beckmann_g1(dvec3_dot(n, l), m) * beckmann_g1(dvec3_dot(n, v), m);
    assert_true(reference_agrees(c, beckmann_d(dvec3_dot(n, h), m), number(c->expected, "D")));
    assert_true(reference_agrees(c, g, number(c->expected, "G")));
    double reflected = fresnel_dielectric(dvec3_dot(v, h), 1, number(c->scene, "ior"));
    assert_true(reference_agrees(c, reflected, number(c->expected, "F")));
}

static int brdfs;
static void count_brdf(const reference_case *c) {
    brdf(c);
    brdfs++;
}

static void cook_torrance_values(void **state) {
    (void)state;
    assert_true(reference_each("I.cook_torrance", count_brdf) > 0);
    assert_true(brdfs >= 5);
}

/* The mean of f cos / pdf over a grid of u: the sample's own density is proved in test_materials. */
static double quadrature(const bsdf *b, double cosine) {
    enum { STEPS = 900 };
    dvec3 n = {0, 0, 1}, wo = {sqrt(1 - cosine * cosine), 0, cosine};
    double sum = 0;
    for (int i = 0; i < STEPS; i++)
        for (int j = 0; j < STEPS / 2; j++) { /* the other half mirrors it */
            sample2 u = {(i + 0.5) / STEPS, (j + 0.5) / STEPS};
            bsdf_direction d;
            if (bsdf_sample(b, n, wo, 0, u, &d)) sum += d.weight.x;
        }
    return sum / (STEPS * (STEPS / 2));
}

static void albedo(const reference_case *c) {
    double m = number(c->scene, "m");
    bsdf white = cook_torrance(m, 0), glass = cook_torrance(m, number(c->scene, "ior"));
    size_t index;
    json_t *row;
    json_array_foreach(c->expected, index, row) {
        double cosine = cos(reference_number(row, 0) * PI / 180);
        assert_true(reference_agrees(c, quadrature(&white, cosine), reference_number(row, 1)));
        assert_true(reference_agrees(c, quadrature(&glass, cosine), reference_number(row, 2)));
    }
}

static void cook_torrance_albedos(void **state) {
    (void)state;
    assert_int_equal(reference_each("I.ct_albedo", albedo), 5);
}

/* A rough boundary of little roughness passes and reflects as much as the smooth one, both ways:
 * neither scales radiance by the indices. */
static void rough_glass_ends_in_smooth_glass(void **state) {
    (void)state;
    static const double iors[][2] = {{1, 1.5}, {1.5, 1}, {1.33, 1.7}};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            bsdf b = {.ior1 = iors[i][0], .ior2 = iors[i][1]};
            bsdf_add_interface(&b, (dvec3){1, 1, 1}, 0.03);
            double cosine = 0.4 + 0.25 * k, passed = 0, back = 0;
            dvec3 wo = {sqrt(1 - cosine * cosine), 0, cosine};
            enum { SAMPLES = 200000 };
            uint64_t random = 1;
            for (int s = 0; s < SAMPLES; s++) {
                bsdf_direction d;
                sample2 u = {uniform(&random), uniform(&random)};
                if (!bsdf_sample(&b, (dvec3){0, 0, 1}, wo, 0, u, &d)) continue;
                *(d.transmitted ? &passed : &back) += d.weight.x / SAMPLES;
            }
            double reflected = fresnel_dielectric(cosine, b.ior1, b.ior2);
            assert_true(fabs(back - reflected) < 0.005);
            assert_true(fabs(passed - (1 - reflected)) < 0.005);
        }
}

/* ---- a material by itself, through the public API ---- */

static rig bench;

static void materials_by_themselves(void **state) {
    (void)state;
    rig_clear(&bench);
    snell_material_id matte = add_lambert(&bench, v3(0.2, 0.4, 0.8)), facets, glass;
    snell_cook_torrance_desc facets_desc = SNELL_INIT(cook_torrance_desc);
    facets_desc.color = flat(grey(0));
    facets_desc.m = flat(grey(0.1));
    MUST(snell_scene_add_cook_torrance(bench.scene, &facets_desc, &facets));
    snell_dielectric_desc glass_desc = SNELL_INIT(dielectric_desc);
    MUST(snell_scene_add_dielectric(bench.scene, &glass_desc, &glass));
    snell_vec3 up = v3(0, 0, 2), wi[2] = {v3(0, 3, 4), v3(0, 0, 1)}, f[2];
    float pdf[2];
    assert_int_equal(snell_material_eval(bench.scene, matte, NULL, up, wi, f, 2), SNELL_ERR_STATE);
    MUST(snell_scene_commit(bench.scene, NULL, NULL));
    MUST(snell_material_eval(bench.scene, matte, NULL, up, wi, f, 2));
    assert_true(fabs((double)f[0].y - 0.4 / PI) < 1e-6);
    MUST(snell_material_pdf(bench.scene, matte, NULL, up, wi, pdf, 2));
    assert_true(fabs((double)pdf[0] - 0.8 / PI) < 1e-6);
    MUST(snell_material_eval(bench.scene, facets, NULL, up, wi, f, 2));
    assert_true(fabs((double)f[1].x - 0.31830988618379075) < 1e-6); /* cook_torrance_01 */
    snell_scattering s[2];
    snell_vec3 u[2] = {v3(0, 0.01, 0.5), v3(0, 0.9, 0.5)};
    MUST(snell_material_sample(bench.scene, glass, NULL, v3(0, 0, -1), u, s, 2));
    assert_true(s[0].found && !s[0].transmitted && s[0].pdf == 0 && s[0].wi.z < 0);
    assert_true(s[1].found && s[1].transmitted && s[1].wi.z > 0.999f && s[1].weight.x == 1);
    /* what is refused */
    wi[1] = grey(0);
    assert_int_equal(snell_material_eval(bench.scene, matte, NULL, up, wi, f, 2),
                     SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_material_eval(bench.scene, matte, NULL, grey(NAN), wi, f, 1),
                     SNELL_ERR_ARGUMENT);
    assert_int_equal(
        snell_material_eval(bench.scene, (snell_material_id){9, 0}, NULL, up, wi, f, 1),
        SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_material_eval(bench.scene, matte, NULL, up, NULL, f, 1),
                     SNELL_ERR_ARGUMENT);
    u[0].y = 1;
    assert_int_equal(snell_material_sample(bench.scene, matte, NULL, up, u, s, 1),
                     SNELL_ERR_ARGUMENT);
}

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

/* ---- thin films ---- */

/* One side of a Gaussian of the CIE 1931 observer's fit (Wyman, Sloan, Shirley 2013, eq. 4). */
static double bump(double x, double middle, double left, double right) {
    double t = (x - middle) * (x < middle ? left : right);
    return exp(-0.5 * t * t);
}

static dvec3 observer(double nm) {
    double x = 0.362 * bump(nm, 442, 0.0624, 0.0374) + 1.056 * bump(nm, 599.8, 0.0264, 0.0323) -
               0.065 * bump(nm, 501.1, 0.0490, 0.0382),
           y = 0.821 * bump(nm, 568.8, 0.0213, 0.0247) + 0.286 * bump(nm, 530.9, 0.0613, 0.0322),
           z = 1.217 * bump(nm, 437, 0.0845, 0.0278) + 0.681 * bump(nm, 459, 0.0385, 0.0725);
    return (dvec3){3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                   -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                   0.0556434 * x - 0.2040259 * y + 1.0572252 * z};
}

/* Airy's sum of all the waves, wavelength by wavelength, at normal incidence on a base of index 1 + 2
 * sqrt(f0) / (1 - sqrt(f0)), and the colour of it under a light of equal energy. */
static dvec3 airy(double ior, double thickness, double f0) {
    double root = sqrt(f0), base = (1 + root) / (1 - root), r12 = (1 - ior) / (1 + ior),
           r23 = (ior - base) / (ior + base);
    dvec3 sum = {0, 0, 0}, white = {0, 0, 0};
    for (double nm = 380; nm <= 780; nm++) {
        double c = cos(4 * PI * ior * thickness / nm),
               r = (r12 * r12 + r23 * r23 + 2 * r12 * r23 * c) /
                   (1 + r12 * r12 * r23 * r23 + 2 * r12 * r23 * c);
        sum = dvec3_add(sum, dvec3_scale(observer(nm), r));
        white = dvec3_add(white, observer(nm));
    }
    return (dvec3){sum.x / white.x, sum.y / white.y, sum.z / white.z};
}

static void films_interfere(void **state) {
    (void)state;
    static const double bases[] = {0.04, 0.2, 0.8}, iors[] = {1.3, 1.8};
    double worst = 0, colourful = 0;
    for (int b = 0; b < 3; b++)
        for (int i = 0; i < 2; i++)
            for (double nm = 150; nm < 900; nm += 25) {
                double f0 = bases[b];
                dvec3 got = fresnel_film(1, iors[i], nm, (dvec3){f0, f0, f0}),
                      want = airy(iors[i], nm, f0), off = dvec3_sub(got, want);
                double most = dvec3_largest((dvec3){fabs(off.x), fabs(off.y), fabs(off.z)});
                worst = double_max(worst, most);
                colourful = double_max(colourful, fabs(want.x - want.z));
            }
    print_message("films: at most %.3f from Airy's sum, colours differ by up to %.3f\n", worst,
                  colourful);
    assert_true(colourful > 0.2);
    assert_true(worst < 0.08);
    /* No film: the base alone. */
    dvec3 bare = fresnel_film(1, 1.5, 0, (dvec3){0.04, 0.3, 0.9});
    ASSERT_CLOSE(bare.x, 0.04, 1e-3, 0);
    ASSERT_CLOSE(bare.y, 0.3, 1e-3, 0);
    ASSERT_CLOSE(bare.z, 0.9, 1e-3, 0);
    for (double cosine = 0.02; cosine < 1; cosine += 0.02) { /* the bound is one */
        double bound = fresnel_film_bound(1.8, 400, (dvec3){0.04, 0.04, 0.04});
        double most = dvec3_largest(fresnel_film(cosine, 1.8, 400, (dvec3){0.04, 0.04, 0.04}));
        double m = 1 - cosine, schlick = bound + (1 - bound) * m * m * m * m * m;
        if (!(most <= schlick + 0.02)) print_error("%g: %g > %g\n", cosine, most, schlick);
        assert_true(most <= schlick + 0.02);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(beckmann_facets),
        cmocka_unit_test(shadowing),
        cmocka_unit_test(cook_torrance_values),
        cmocka_unit_test(cook_torrance_albedos),
        cmocka_unit_test(rough_glass_ends_in_smooth_glass),
        cmocka_unit_test(films_interfere),
        cmocka_unit_test(materials_by_themselves),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
