/* Every registered material, so that a new one is tested as soon as it is in materials.def: with its
 * defaults, at both ends of what makes it rough, and in the further settings listed below.
 *
 * Chi-square of the directions drawn against their density; the density's integral; energy;
 * reciprocity; white furnaces; numbers that are finite whatever the angle; coats with normals of their
 * own. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "maths/functions.h"
#include "materials/albedo.h"
#include "materials/microfacet.h"
#include "materials/material.h"
#include "render_test.h"

enum { PARTS = 3, VARIANTS_MAX = 200, PARAMS = 6 };
static const dvec3 UP = {0, 0, 1};

typedef struct variant {
    material m;
    void *desc;
    double tilt, lean; /* rad: of the coat's normal from UP, of the geometric one; both 0: UP */
    char label[160];
} variant;

/* The parts that materials made of others get: earlier ones, as in a scene. */
static material parts[PARTS];
static variant variants[VARIANTS_MAX];
static int variant_count;

/* ---- all settings ---- */

static const material_type *find_type(const char *name) {
    for (uint32_t i = 0; i < material_type_count; i++)
        if (strcmp(material_types[i]->info.name, name) == 0) return material_types[i];
    fail_msg("no material %s", name);
    return NULL;
}

static void set(const type_info *info, void *desc, snell_param p) {
    if (desc_set(info, desc, &p) != SNELL_OK) fail_msg("%s.%s", info->name, p.name);
}

static material make(const material_type *type, const snell_param *params, size_t count) {
    void *desc = memory_zeroed(1, type->info.desc_size);
    assert_non_null(desc);
    desc_init(&type->info, desc);
    uint32_t next = 1;
    for (uint32_t i = 0; i < type->info.field_count; i++)
        if (type->info.fields[i].kind == FIELD_MATERIAL)
            *(snell_material_id *)(void *)((char *)desc + type->info.fields[i].offset) =
                (snell_material_id){next++, 0};
    for (size_t i = 0; i < count; i++) set(&type->info, desc, params[i]);
    assert_int_equal(desc_check(&type->info, desc, NULL), SNELL_OK);
    if (type->check) assert_int_equal(type->check(desc), SNELL_OK);
    return (material){.type = type, .desc = desc};
}

static void add_variant(const material_type *type, const snell_param *params, size_t count) {
    assert_true(variant_count < VARIANTS_MAX);
    variant *v = &variants[variant_count++];
    v->m = make(type, params, count);
    int used = snprintf(v->label, sizeof v->label, "%s", type->info.name);
    for (size_t i = 0; i < count && used > 0 && used < (int)sizeof v->label; i++)
        used += snprintf(v->label + used, sizeof v->label - (size_t)used, " %s=%g", params[i].name,
                         params[i].value.f);
}

#define NUMBER(name_, value_)                                                                      \
    { .name = name_, .kind = SNELL_PARAM_FLOAT, .value.f = value_ }

/* Whatever a material calls its roughness, its ends and what is between are tried. */
static void add_sweeps(const material_type *type) {
    static const struct {
        const char *name;
        double values[6];
    } sweeps[] = {{"roughness", {0, 0.005, 0.04, 0.2, 0.5, 1}},
                  {"m", {0, 1e-4, 0.01, 0.1, 0.5, 1}},
                  {"exponent", {0, 1, 5, 50, 1000, 1e6}},
                  {"weight", {0, 0.1, 0.3, 0.7, 0.9, 1}}};
    for (size_t i = 0; i < sizeof sweeps / sizeof sweeps[0]; i++)
        for (int k = 0; k < 6; k++) {
            snell_param p = NUMBER(sweeps[i].name, sweeps[i].values[k]);
            if (type_find_field(&type->info, sweeps[i].name)) add_variant(type, &p, 1);
        }
}

typedef struct setting {
    const char *type;
    snell_param params[PARAMS];
} setting;

static const setting settings[] = {
    {"lambert", {NUMBER("color", 1)}},
    {"dielectric", {NUMBER("roughness", 0.3), NUMBER("ior", 1)}},
    {"dielectric", {NUMBER("roughness", 0.3), NUMBER("ior", 2.4)}},
    {"dielectric", {NUMBER("roughness", 0.7), NUMBER("color", 0.5)}},
    {"conductor", {NUMBER("eta", 1.5), NUMBER("roughness", 0.4)}},
    {"conductor", {NUMBER("eta", 0.2), NUMBER("k", 3), NUMBER("roughness", 0.8)}},
    {"ggx", {NUMBER("color", 1), NUMBER("roughness", 0.5)}},
    {"ggx", {NUMBER("color", 1), NUMBER("ior", 1)}},
    {"ggx", {NUMBER("color", 0), NUMBER("ior", 10), NUMBER("roughness", 1)}},
    {"glazed", {NUMBER("ior", 1.5)}},
    {"principled", {NUMBER("metallic", 1), NUMBER("roughness", 0.3)}},
    {"principled", {NUMBER("metallic", 1), NUMBER("roughness", 0), NUMBER("base_color", 1)}},
    {"principled", {NUMBER("metallic", 0.5), NUMBER("roughness", 1), NUMBER("base_color", 1)}},
    {"principled", {NUMBER("specular", 0), NUMBER("base_color", 1)}},
    {"principled", {NUMBER("specular_color", 8), NUMBER("base_color", 1)}},
    {"principled", {NUMBER("transmission", 1), NUMBER("roughness", 0.3)}},
    {"principled", {NUMBER("transmission", 1), NUMBER("roughness", 0)}},
    {"principled",
     {NUMBER("transmission", 0.5), NUMBER("roughness", 0.4), NUMBER("metallic", 0.5)}},
    {"principled", {NUMBER("transmission", 1), NUMBER("roughness", 0.3), NUMBER("thickness", 1)}},
    {"principled",
     {NUMBER("transmission", 0.7), NUMBER("roughness", 0.5), NUMBER("thickness", 1),
      NUMBER("clearcoat", 1), NUMBER("base_color", 1)}},
    {"principled", {NUMBER("clearcoat", 1), NUMBER("clearcoat_roughness", 0.3)}},
    {"principled", {NUMBER("clearcoat", 1), NUMBER("base_color", 1), NUMBER("roughness", 0)}},
    {"principled",
     {NUMBER("sheen_color", 1), NUMBER("sheen_roughness", 0.3), NUMBER("base_color", 1)}},
    {"principled",
     {NUMBER("sheen_color", 1), NUMBER("sheen_roughness", 0), NUMBER("base_color", 1)}},
    {"principled",
     {NUMBER("sheen_color", 1), NUMBER("sheen_roughness", 1), NUMBER("clearcoat", 0.5),
      NUMBER("clearcoat_roughness", 1), NUMBER("base_color", 1), NUMBER("metallic", 0.5)}},
    {"principled",
     {NUMBER("anisotropy", 1), NUMBER("roughness", 0.3), NUMBER("metallic", 1),
      NUMBER("base_color", 1)}},
    {"principled",
     {NUMBER("anisotropy", 0.6), NUMBER("roughness", 0.2), NUMBER("base_color", 1),
      NUMBER("anisotropy_rotation", 1)}},
    {"principled", {NUMBER("anisotropy", 1), NUMBER("roughness", 0.15), NUMBER("base_color", 1)}},
    {"principled",
     {NUMBER("anisotropy", 0.8), NUMBER("roughness", 0.6), NUMBER("base_color", 1),
      NUMBER("metallic", 0.5), NUMBER("clearcoat", 0.5)}},
    {"principled",
     {NUMBER("iridescence", 1), NUMBER("roughness", 0.3), NUMBER("base_color", 1),
      NUMBER("iridescence_thickness", 300)}},
    {"principled",
     {NUMBER("iridescence", 1), NUMBER("roughness", 0), NUMBER("base_color", 1),
      NUMBER("iridescence_thickness", 700), NUMBER("iridescence_ior", 2.2)}},
    {"principled",
     {NUMBER("iridescence", 0.7), NUMBER("roughness", 0.5), NUMBER("base_color", 1),
      NUMBER("metallic", 0.5), NUMBER("anisotropy", 0.7)}},
    {"principled",
     {NUMBER("iridescence", 1), NUMBER("roughness", 0.5), NUMBER("base_color", 1),
      NUMBER("metallic", 1), NUMBER("iridescence_thickness", 500)}},
    {"cook_torrance", {NUMBER("color", 0), NUMBER("m", 0.5), NUMBER("specular", 1)}},
};

/* Coats over a surface that is bent (tilt = lean), that are bent themselves, or both are. */
static const struct {
    setting as;
    double tilt, lean;
} coated[] = {
    {{"principled",
      {NUMBER("clearcoat", 1), NUMBER("clearcoat_roughness", 0.5), NUMBER("base_color", 1)}},
     0.6,
     0.6},
    {{"principled",
      {NUMBER("clearcoat", 1), NUMBER("clearcoat_roughness", 0.7), NUMBER("base_color", 1),
       NUMBER("metallic", 1), NUMBER("roughness", 0.6)}},
     0.9,
     0},
    {{"principled",
      {NUMBER("clearcoat", 0.5), NUMBER("clearcoat_roughness", 0), NUMBER("base_color", 1),
       NUMBER("sheen_color", 1), NUMBER("sheen_roughness", 0.5)}},
     0.4,
     0.2},
    {{"principled",
      {NUMBER("clearcoat", 1), NUMBER("clearcoat_roughness", 0.5), NUMBER("base_color", 1),
       NUMBER("transmission", 0.7), NUMBER("roughness", 0.5), NUMBER("thickness", 1)}},
     0.5,
     0.5},
};

static variant *add_setting(const setting *s) {
    size_t count = 0;
    while (count < PARAMS && s->params[count].name) count++;
    add_variant(find_type(s->type), s->params, count);
    return &variants[variant_count - 1];
}

static int start(void **state) {
    (void)state;
    parts[0] = make(find_type("lambert"), NULL, 0);
    parts[1] = make(find_type("ggx"), NULL, 0);
    parts[2] = make(find_type("mirror"), NULL, 0);
    for (uint32_t i = 0; i < material_type_count; i++) {
        add_variant(material_types[i], NULL, 0);
        add_sweeps(material_types[i]);
    }
    for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++) add_setting(&settings[i]);
    for (size_t i = 0; i < sizeof coated / sizeof coated[0]; i++) {
        variant *v = add_setting(&coated[i].as);
        v->tilt = coated[i].tilt, v->lean = coated[i].lean;
        snprintf(v->label, sizeof v->label, "coat %zu", i);
    }
    return 0;
}

static int stop(void **state) {
    (void)state;
    for (int i = 0; i < PARTS; i++) desc_free(&parts[i].type->info, (void *)parts[i].desc);
    for (int i = 0; i < variant_count; i++)
        desc_free(&variants[i].m.type->info, (void *)variants[i].m.desc);
    return 0;
}

/* ---- looking at one ---- */

static dvec3 direction(double cosine, double angle) {
    double sine = sqrt(double_max(0, 1 - cosine * cosine));
    return (dvec3){sine * cos(angle), sine * sin(angle), cosine};
}

static bsdf look_at(const variant *v, bool outside) {
    bsdf b;
    material_point point = {.tint = {1, 1, 1}, .alpha = 1, .outside = outside, .materials = parts};
    /* Less than a right angle from every wo of the tests below. */
    if (v->tilt > 0)
        point.coat =
            (coat_normal){true, direction(cos(v->tilt), 1.2), direction(cos(v->lean), 1.2)};
    material_evaluate(&v->m, &point, &b);
    return b;
}

static bool draw(const bsdf *b, dvec3 wo, uint64_t *state, bsdf_direction *out) {
    double choice = uniform(state);
    sample2 u = {uniform(state), uniform(state)};
    return bsdf_sample(b, UP, wo, choice, u, out);
}

static bool is_sane(dvec3 v) {
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z) && v.x >= 0 && v.y >= 0 && v.z >= 0;
}

/* ---- directions drawn against their density ---- */

enum { ROWS = 24, COLUMNS = 32, CELLS = ROWS * COLUMNS, SIDES = 2 };
static const double WO_COSINES[] = {1, 0.8, 0.5, 0.15};
enum { WO_COUNT = 4 };

/* The cells of one side of the surface: rings about the direction in which narrow lobes peak, the
 * inner ones as narrow as those, cut into sectors. A ring is between two values of
 * log(1 + theta / width). */
typedef struct rings {
    dvec3 peak;
    double width, scale; /* rad; log(1 + pi / width) / ROWS */
    bool beyond;
} rings;

/* About how wide it is, rad. */
static double lobe_width(const lobe *l) {
    if (l->type == &lobe_phong || l->type == &lobe_blinn_phong) return sqrt(1 / (l->exponent + 1));
    return l->type->class == LOBE_GLOSSY ? l->alpha : 1;
}

static rings make_rings(const bsdf *b, dvec3 wo, bool beyond) {
    rings r = {.beyond = beyond, .width = 1};
    bool thin = true;
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *l = &b->lobes[i];
        if (beyond && !l->type->transmits && !l->tilted) continue;
        r.width = double_min(r.width, lobe_width(l));
        thin &= l->type->thin || l->tilted;
    }
    r.peak = beyond ? dvec3_negate(wo) : reflect_direction(wo, UP);
    if (beyond && !thin) { /* the nearer the indices, the nearer to a delta: they are kept apart */
        double eta = b->ior1 / b->ior2;
        if (fabs(1 / eta - 1) < 1e-3) eta = 1 / 1.001;
        refract_direction(wo, UP, eta, &r.peak);
        r.width *= double_min(1, fabs(1 - eta));
    }
    r.width *= double_max(wo.z, 0.1) / 2;
    r.scale = log1p(PI / r.width) / ROWS;
    return r;
}

static int cell_of(const rings *r, dvec3 wi) {
    dvec3 local = dvec3_to_frame(r->peak, wi), off = dvec3_sub(wi, r->peak);
    double theta = 2 * asin(double_min(dvec3_length(off) / 2, 1)), angle = atan2(local.y, local.x);
    if (angle < 0) angle += 2 * PI;
    int row = (int)(log1p(theta / r->width) / r->scale), column = (int)(angle / (2 * PI) * COLUMNS);
    if (row > ROWS - 1) row = ROWS - 1;
    if (column > COLUMNS - 1) column = COLUMNS - 1;
    return row * COLUMNS + column;
}

static void expected_counts(const bsdf *b, const rings *r, dvec3 wo, double samples,
                            double expected[CELLS]) {
    int sub = full_tests() ? 40 : 16; /* what the sums miss counts as lost */
    uint64_t random = 5;              /* jittered: a density may end at an edge */
    for (int cell = 0; cell < CELLS; cell++) {
        double sum = 0;
        for (int k = 0; k < sub * sub; k++) {
            double row = cell / COLUMNS + (k / sub + uniform(&random)) / sub,
                   column = cell % COLUMNS + (k % sub + uniform(&random)) / sub,
                   theta = r->width * expm1(row * r->scale), ring = (theta + r->width) * r->scale;
            dvec3 wi = dvec3_from_frame(r->peak, direction(cos(theta), 2 * PI * column / COLUMNS));
            wi = dvec3_normalize(wi);
            if ((wi.z < 0) == r->beyond) sum += bsdf_pdf(b, UP, wo, wi) * sin(theta) * ring;
        }
        expected[cell] = samples * sum / (sub * sub) * 2 * PI / COLUMNS;
    }
}

/* P(chi^2 >= x) with k degrees of freedom (Wilson and Hilferty 1931). */
static double chi_square_tail(double x, double k) {
    double z = (cbrt(x / k) - (1 - 2 / (9 * k))) / sqrt(2 / (9 * k));
    return erfc(z / sqrt(2)) / 2;
}

static bool any_transmits(const bsdf *b) {
    for (int i = 0; i < b->lobe_count; i++)
        if (b->lobes[i].type->transmits) return true;
    return false;
}

/* Whether a wi may be below UP. */
static bool any_below(const bsdf *b) { return any_transmits(b) || b->coat.own; }

/* Draws; what is lost are deltas and samples that find nothing. */
static double count_directions(const variant *v, const bsdf *b, const rings *sides, dvec3 wo,
                               int samples, double *counted) {
    double lost = 0;
    uint64_t state = 99;
    for (int i = 0; i < samples; i++) {
        bsdf_direction d;
        if (!draw(b, wo, &state, &d) || !(d.pdf > 0)) {
            lost++;
            continue;
        }
        if (!(bsdf_pdf(b, UP, wo, d.wi) > 0)) fail_msg("%s: drawn against all odds", v->label);
        assert_true(d.wi.z > 0 || any_below(b));
        counted[(d.wi.z < 0) * CELLS + cell_of(&sides[d.wi.z < 0], d.wi)]++;
    }
    return lost;
}

static void check_distribution(const variant *v, bool outside, double cos_o, double level) {
    bsdf b = look_at(v, outside);
    if (b.lobe_count == 0) return;
    int samples = full_tests() ? 1000000 : 60000;
    dvec3 wo = direction(cos_o, 0.7);
    static double expected[SIDES * CELLS], counted[SIDES * CELLS];
    memset(counted, 0, sizeof counted);
    memset(expected, 0, sizeof expected);
    const rings sides[SIDES] = {make_rings(&b, wo, false), make_rings(&b, wo, true)};
    double lost = count_directions(v, &b, sides, wo, samples, counted);
    if (lost == samples) return; /* nothing but deltas */
    for (int i = 0; i < 1 + any_below(&b); i++)
        expected_counts(&b, &sides[i], wo, samples, expected + i * CELLS);
    double total = 0, statistic = 0, few_expected = 0, few_counted = lost;
    int degrees = 0;
    for (int i = 0; i < SIDES * CELLS; i++) {
        total += expected[i];
        if (expected[i] < 5) {
            few_expected += expected[i];
            few_counted += counted[i];
            continue;
        }
        double difference = counted[i] - expected[i];
        statistic += difference * difference / expected[i];
        degrees++;
    }
    if (total > samples * 1.002)
        fail_msg("%s at %g: the density integrates to %g", v->label, cos_o, total / samples);
    few_expected += double_max(0, samples - total);
    if (few_expected >= 5) {
        double difference = few_counted - few_expected;
        statistic += difference * difference / few_expected;
    } else {
        degrees--;
        assert_true(few_counted <= 30);
    }
    if (degrees < 1) return;
    double p = chi_square_tail(statistic, degrees);
    if (!(p >= level))
        fail_msg("%s at %g, %s: chi^2 %g of %d degrees, p = %g (lost %g, expected lost %g)",
                 v->label, cos_o, outside ? "outside" : "inside", statistic, degrees, p,
                 few_counted, few_expected);
}

static void directions_follow_their_density(void **state) {
    (void)state;
    double level = 1 - pow(1 - 0.01, 1.0 / (2 * variant_count * WO_COUNT)); /* Sidak */
    for (int i = 0; i < variant_count; i++)
        for (int k = 0; k < WO_COUNT; k++) {
            const material *m = &variants[i].m;
            check_distribution(&variants[i], true, WO_COSINES[k], level);
            if (material_bounds_medium(m->type, m->desc))
                check_distribution(&variants[i], false, WO_COSINES[k], level);
        }
}

/* ---- energy ---- */

/* The mean weight of what is drawn, per colour; *error: three standard deviations of the largest. */
static dvec3 albedo(const bsdf *b, dvec3 wo, int samples, double *error) {
    dvec3 sum = {0, 0, 0}, squares = {0, 0, 0};
    uint64_t state = 7;
    for (int i = 0; i < samples; i++) {
        bsdf_direction d;
        if (!draw(b, wo, &state, &d)) continue;
        assert_true(is_sane(d.weight));
        sum = dvec3_add(sum, d.weight);
        squares = dvec3_add(squares, dvec3_mul(d.weight, d.weight));
    }
    dvec3 mean = dvec3_scale(sum, 1.0 / samples);
    dvec3 variance = dvec3_sub(dvec3_scale(squares, 1.0 / samples), dvec3_mul(mean, mean));
    *error = 3 * sqrt(double_max(0, dvec3_largest(variance)) / samples);
    return mean;
}

static void nothing_gains(void **state) {
    (void)state;
    static const double cosines[] = {1, 0.7, 0.3, 0.05, 0.001};
    for (int i = 0; i < variant_count; i++) {
        const variant *v = &variants[i];
        if (v->m.type->may_gain) continue;
        for (int k = 0; k < 10; k++) {
            bsdf b = look_at(v, k < 5);
            double error, cosine = cosines[k % 5];
            double most = dvec3_largest(albedo(&b, direction(cosine, 0.3), 20000, &error));
            if (most > 1.01 + error) fail_msg("%s at %g: albedo %g", v->label, cosine, most);
        }
    }
}

/* White materials that send on all that they receive, at any roughness. */
static void furnaces_stay_white(void **state) {
    (void)state;
    static const double cosines[] = {1, 0.7, 0.3, 0.1};
    static const double roughnesses[] = {0, 0.1, 0.3, 0.6, 1};
    static const setting white[] = {
        {"lambert", {NUMBER("color", 1)}},
        {"mirror", {NUMBER("color", 1)}},
        {"conductor", {NUMBER("eta", 0.01), NUMBER("k", 100)}},
        {"ggx", {NUMBER("color", 1)}},
        {"dielectric", {NUMBER("color", 1)}},
        {"principled", {NUMBER("base_color", 1)}},
        {"principled", {NUMBER("base_color", 1), NUMBER("metallic", 1)}},
        {"principled", {NUMBER("base_color", 1), NUMBER("metallic", 0.5)}},
    };
    for (size_t i = 0; i < sizeof white / sizeof white[0]; i++)
        for (int k = 0; k < 20; k++) {
            snell_param params[PARAMS] = {{0}};
            memcpy(params, white[i].params, sizeof params);
            const material_type *type = find_type(white[i].type);
            size_t count = 0;
            while (params[count].name) count++;
            double roughness = roughnesses[k / 4], cosine = cosines[k % 4];
            if (type_find_field(&type->info, "roughness"))
                params[count++] = (snell_param)NUMBER("roughness", roughness);
            /* Rough glass has single scattering only. */
            if (type->inside && strcmp(type->info.name, "dielectric") == 0 && roughness > 0.1)
                continue;
            variant made = {.m = make(type, params, count)};
            bsdf b = look_at(&made, true);
            double error;
            dvec3 sum = albedo(&b, direction(cosine, 1), 100000, &error);
            desc_free(&type->info, (void *)made.m.desc);
            if (fabs(sum.x - 1) > 0.012 + error)
                fail_msg("%s %zu, roughness %g at %g: %g", type->info.name, i, roughness, cosine,
                         sum.x);
        }
}

/* ---- reciprocity ---- */

/* bsdf_evaluate, but the coat's part with the cosine that belongs to it left out. */
static dvec3 evaluate_by_lobe(const bsdf *b, dvec3 wo, dvec3 wi) {
    bsdf coat = *b, base = *b;
    coat.lobe_count = base.lobe_count = 0;
    for (int i = 0; i < b->lobe_count; i++) {
        bsdf *part = b->lobes[i].tilted ? &coat : &base;
        part->lobes[part->lobe_count++] = b->lobes[i];
    }
    dvec3 f = bsdf_evaluate(&base, LOBES_LIT, UP, wo, wi);
    if (coat.lobe_count == 0) return f;
    return dvec3_add(f, dvec3_scale(bsdf_evaluate(&coat, LOBES_LIT, UP, wo, wi),
                                    fabs(wi.z) / dvec3_dot(b->coat.n, wi)));
}

static bool is_over_coat(const bsdf *b, dvec3 d) {
    return !b->coat.own || (dvec3_dot(b->coat.n, d) > 0 && dvec3_dot(b->coat.side, d) > 0);
}

/* f(wo, wi) / ior_i^2 = f(wi, wo) / ior_o^2: through a surface no radiance is scaled (see
 * rough_interface.c). */
static void both_ways_are_the_same(void **state) {
    (void)state;
    uint64_t random = 3;
    for (int i = 0; i < variant_count; i++) {
        const variant *v = &variants[i];
        bsdf out = look_at(v, true), in = look_at(v, false);
        /* Varnish is on the outside only. */
        bool through = out.coat_count == 0;
        for (int k = 0; k < 300; k++) {
            dvec3 a = direction(uniform(&random), 6.3 * uniform(&random)),
                  b = direction(2 * uniform(&random) - 1, 6.3 * uniform(&random));
            if (b.z < 0 && !through) continue;
            if (!is_over_coat(&out, a) || !is_over_coat(&out, b)) continue;
            dvec3 there = evaluate_by_lobe(&out, a, b), back;
            if (b.z > 0)
                back = evaluate_by_lobe(&out, b, a);
            else
                back = dvec3_scale(bsdf_evaluate(&in, LOBES_LIT, dvec3_negate(UP), b, a),
                                   out.ior2 * out.ior2 / (out.ior1 * out.ior1));
            double scale = 1e-9 + dvec3_largest(there);
            if (fabs(there.x - back.x) > 1e-6 * scale)
                fail_msg("%s: %.12g there, %.12g back", v->label, there.x, back.x);
        }
    }
}

/* ---- what is even ---- */

/* What bsdf_is_even says of all directions is what bsdf_evaluate says of each. */
static void even_is_even(void **state) {
    (void)state;
    uint64_t random = 5;
    int even = 0;
    for (int i = 0; i < variant_count; i++) {
        bsdf b = look_at(&variants[i], true);
        dvec3 f, at;
        if (!bsdf_is_even(&b, LOBES_LIT, &f)) continue;
        even++;
        for (int k = 0; k < 100; k++) {
            dvec3 wo = direction(uniform(&random), 6.3 * uniform(&random));
            dvec3 wi = direction(2 * uniform(&random) - 1, 6.3 * uniform(&random));
            at = bsdf_evaluate(&b, LOBES_LIT, UP, wo, wi);
            dvec3 said = wi.z > 0 ? f : (dvec3){0, 0, 0};
            if (at.x != said.x || at.y != said.y || at.z != said.z)
                fail_msg("%s: %g, not %g at %g", variants[i].label, at.x, said.x, wi.z);
        }
    }
    assert_true(even > 1 && even < variant_count);
}

/* ---- coats with normals of their own ---- */

/* Light that comes from under the geometric surface finds nothing. The coat is lit by what is under its
 * base, and its base by nothing that is under its own normal. */
static void each_layer_has_its_own_side(void **state) {
    (void)state;
    uint64_t random = 11;
    int coat_alone = 0;
    for (int i = 0; i < variant_count; i++) {
        bsdf b = look_at(&variants[i], true);
        if (!b.coat.own || any_transmits(&b)) continue;
        bool rough = false;
        for (int k = 0; k < b.lobe_count; k++)
            rough |= b.lobes[k].tilted && b.lobes[k].type->evaluate;
        for (int k = 0; k < 4000; k++) {
            dvec3 wo = direction(uniform(&random), 1.2);
            dvec3 wi = direction(2 * uniform(&random) - 1, 6.3 * uniform(&random));
            double f = dvec3_largest(bsdf_evaluate(&b, LOBES_LIT, UP, wo, wi));
            bool above = dvec3_dot(b.coat.side, wi) > 0, over_coat = dvec3_dot(b.coat.n, wi) > 0;
            bool on_coat = rough && above && over_coat, on_base = above && wi.z > 0;
            if ((on_coat || (on_base && over_coat)) && !(f > 0))
                fail_msg("%s: dark at (%g %g %g)", variants[i].label, wi.x, wi.y, wi.z);
            if (!on_coat && !on_base && f != 0)
                fail_msg("%s: %g at (%g %g %g)", variants[i].label, f, wi.x, wi.y, wi.z);
            coat_alone += on_coat && !on_base;
        }
    }
    assert_true(coat_alone > 100);
}

/* ---- edges ---- */

static void numbers_stay_finite(void **state) {
    (void)state;
    static const double cosines[] = {1, 1 - 1e-16, 0.5, 1e-3, 1e-9, 1e-300, 0};
    static const double us[] = {0, 1e-300, 0.5, 1 - 0x1p-53};
    for (int i = 0; i < variant_count; i++)
        for (int o = 0; o < 14; o++) {
            bsdf b = look_at(&variants[i], o < 7);
            dvec3 wo = direction(cosines[o % 7], 0);
            for (int k = 0; k < 56; k++) {
                dvec3 wi = direction(cosines[k % 7] * (k % 2 ? -1 : 1), k / 14 * PI / 3);
                dvec3 f = bsdf_evaluate(&b, LOBES_LIT, UP, wo, wi);
                double pdf = b.lobe_count ? bsdf_pdf(&b, UP, wo, wi) : 0;
                if (!is_sane(f) || !isfinite(pdf) || pdf < 0)
                    fail_msg("%s: f %g, pdf %g at %g and %g", variants[i].label, f.x, pdf, wo.z,
                             wi.z);
            }
            for (int k = 0; k < 64; k++) {
                bsdf_direction d;
                sample2 u = {us[k % 4], us[k / 4 % 4]};
                if (!bsdf_sample(&b, UP, wo, us[k / 16], u, &d)) continue;
                if (!is_sane(d.weight) || !isfinite(d.pdf) ||
                    !(fabs(dvec3_length(d.wi) - 1) < 1e-6))
                    fail_msg("%s: weight %g, pdf %g at %g", variants[i].label, d.weight.x, d.pdf,
                             wo.z);
            }
        }
}

/* The committed tables are the integrals of the lobes. */
static void tables_are_the_integrals(void **state) {
    (void)state;
    for (int i = 3; i < ALBEDO_SIZE; i += 7)
        for (int j = 4; j < ALBEDO_SIZE; j += 9) {
            double x = (double)i / (ALBEDO_SIZE - 1), y = (double)j / (ALBEDO_SIZE - 1), error;
            bsdf b = {.ior1 = 1, .ior2 = 1};
            lobe *l = bsdf_add(&b, &lobe_ggx, (dvec3){1, 1, 1}, x * x);
            l->fresnel = (fresnel){FRESNEL_SCHLICK, {0.3, 0, 1}, {1, 1, 1}};
            dvec3 sum = albedo(&b, direction(y * y, 0), 200000, &error);
            assert_true(fabs(albedo_ggx(x * x, y * y, 0.3, 1) - sum.x) < 1e-3 + error);
            assert_true(fabs(albedo_ggx(x * x, y * y, 0, 1) - sum.y) < 1e-3 + error);
            assert_true(fabs(albedo_ggx(x * x, y * y, 1, 1) - sum.z) < 1e-3 + error);
            b.lobe_count = 0;
            bsdf_add(&b, &lobe_sheen, (dvec3){1, 1, 1}, double_max(x * x, SHEEN_ALPHA_MIN));
            sum = albedo(&b, direction(y * y, 0), 200000, &error);
            if (!(fabs(albedo_sheen(x * x, y * y) - sum.x) < 2e-3 + error))
                fail_msg("sheen %d, %d: %g in the table, %g +- %g", i, j,
                         albedo_sheen(x * x, y * y), sum.x, error);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_stay_finite),
        cmocka_unit_test(both_ways_are_the_same),
        cmocka_unit_test(even_is_even),
        cmocka_unit_test(each_layer_has_its_own_side),
        cmocka_unit_test(nothing_gains),
        cmocka_unit_test(furnaces_stay_white),
        cmocka_unit_test(tables_are_the_integrals),
        cmocka_unit_test(directions_follow_their_density),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
