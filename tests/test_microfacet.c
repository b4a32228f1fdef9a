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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(beckmann_facets),
        cmocka_unit_test(shadowing),
        cmocka_unit_test(cook_torrance_values),
        cmocka_unit_test(cook_torrance_albedos),
        cmocka_unit_test(rough_glass_ends_in_smooth_glass),
        cmocka_unit_test(materials_by_themselves),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
