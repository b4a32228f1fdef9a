#include "materials/bsdf.h"

#include <assert.h>

#include "materials/albedo.h"
#include "maths/functions.h"
#include "sampling/warp.h"

/* Under this share of a bsdf a lobe is hardly ever chosen, and its rare samples are bright. */
static const double SHARE_MIN = 0.02;

lobe *bsdf_add(bsdf *b, const lobe_type *type, dvec3 weight, double parameter) {
    /* A lobe that does nothing costs time; but what lets nothing pass still reflects. */
    if (!(dvec3_largest(weight) > 0) && !type->transmits) return NULL;
    assert(b->lobe_count < LOBES_MAX);
    const dvec3 none = {0, 0, 0};
    lobe *l = &b->lobes[b->lobe_count++];
    l->type = type;
    l->weight = weight;
    l->exponent = parameter;
    l->fresnel.kind = FRESNEL_NONE;
    l->fresnel.a = none;
    l->fresnel.b = none;
    l->mirror_share = 0;
    l->share = -1;
    l->reflected = (dvec3){1, 1, 1};
    l->coats = 0;
    l->tilted = false;
    return l;
}

static bool counts(const lobe *l, lobe_set set) {
    const lobe_type *type = l->type;
    if (!(LOBE_BIT(type->class) & set) || type->evaluate == NULL) return false;
    return !(set & LOBES_NOT_MIRRORED) || !(l->mirror_share >= 1 || type->transmits);
}

static dvec3 evaluate_tilted(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    const double least = 1e-9; /* for wi in the surface: what is divided by it stays finite */
    const coat_normal *c = &b->coat;
    double cosine = dvec3_dot(c->n, wi);
    if (!(cosine > 0) || !(dvec3_dot(c->side, wi) > 0)) return (dvec3){0, 0, 0};
    return dvec3_scale(l->type->evaluate(l, b, c->n, wo, wi),
                       cosine / double_max(fabs(dvec3_dot(n, wi)), least));
}

dvec3 bsdf_evaluate(const bsdf *b, lobe_set set, dvec3 n, dvec3 wo, dvec3 wi) {
    dvec3 sum = {0, 0, 0};
    bool beyond = dvec3_dot(n, wi) < 0,
         disagree = b->coat.own && beyond != (dvec3_dot(b->coat.side, wi) < 0);
    for (const lobe *l = b->lobes, *end = l + b->lobe_count; l < end; l++) {
        if (!counts(l, set)) continue;
        if (l->tilted) sum = dvec3_add(sum, evaluate_tilted(l, b, n, wo, wi));
        if (l->tilted || disagree || (beyond && !l->type->transmits)) continue;
        dvec3 f = l->type->evaluate(l, b, n, wo, wi);
        if (l->coats)
            f = dvec3_scale(f, lobe_passing(l, b, wo, wi, dvec3_dot(n, wo), dvec3_dot(n, wi)));
        sum = dvec3_add(sum, f);
    }
    return sum;
}

bool bsdf_is_lit(const bsdf *b, lobe_set set) {
    for (const lobe *l = b->lobes, *end = l + b->lobe_count; l < end; l++)
        if (counts(l, set)) return true;
    return false;
}

/* Lambert's f, the same for all directions. */
static dvec3 lambert(const lobe *l) { return dvec3_scale(l->weight, 1 / PI); }

bool bsdf_is_even(const bsdf *b, lobe_set set, dvec3 *f) {
    *f = (dvec3){0, 0, 0};
    for (const lobe *l = b->lobes, *end = l + b->lobe_count; l < end; l++) {
        if (!counts(l, set)) continue;
        if (l->type != &lobe_lambert || l->coats || l->tilted) return false;
        *f = dvec3_add(*f, lambert(l));
    }
    return true;
}

dvec3 bsdf_passing(const bsdf *b) {
    for (int i = 0; i < b->lobe_count; i++)
        if (b->lobes[i].type->transmits) return b->lobes[i].weight;
    return (dvec3){1, 1, 1};
}

dvec3 bsdf_straight(const bsdf *b, dvec3 n, dvec3 wo, bool smooth) {
    dvec3 sum = {0, 0, 0}, wi = dvec3_negate(wo);
    double cosine = dvec3_dot(n, wo);
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *l = &b->lobes[i];
        if (!l->type->thin || (smooth && l->type->class != LOBE_INTERFACE)) continue;
        double passed = 1 - fresnel_evaluate(&l->fresnel, cosine).x,
               passing = lobe_passing(l, b, wo, wi, cosine, -cosine);
        sum = dvec3_add(sum, dvec3_scale(l->weight, passed * passing));
    }
    return sum;
}

static double coat_passing(const coating *c, double cosine) {
    double kept =
        c->sheen ? albedo_sheen(c->alpha, cosine) : albedo_ggx(c->alpha, cosine, c->f0, 1);
    return clamp01(1 - c->amount * kept);
}

static double cosine_with(const coating *c, const bsdf *b, dvec3 w, double cosine) {
    return b->coat.own && !c->sheen ? double_max(dvec3_dot(b->coat.n, w), 0) : cosine;
}

double lobe_passing(const lobe *l, const bsdf *b, dvec3 wo, dvec3 wi, double cos_o, double cos_i) {
    double passing = 1;
    for (int i = 0; i < b->coat_count; i++) {
        const coating *c = &b->coats[i];
        if (!(l->coats >> i & 1)) continue;
        double from = coat_passing(c, cosine_with(c, b, wo, cos_o));
        /* What is beyond has the coats on the other side only once. */
        passing *=
            cos_i > 0 ? double_min(from, coat_passing(c, cosine_with(c, b, wi, cos_i))) : from;
    }
    return passing;
}

dvec3 lobe_mirrored(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo) {
    dvec3 m = lobe_normal(l, b, n);
    double cosine = dvec3_dot(m, wo);
    dvec3 reflected = dvec3_mul(l->weight, fresnel_evaluate(&l->fresnel, cosine));
    return dvec3_scale(reflected, lobe_passing(l, b, wo, reflect_direction(wo, m), cosine, cosine));
}

/* Phong: 2 pi k_s / (p + 2), exact along the normal; Blinn's lobe is four times as wide. */
static dvec3 lobe_albedo(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo) {
    double largest = dvec3_largest(l->weight);
    if (l->share >= 0) return dvec3_scale(l->weight, largest > 0 ? l->share / largest : 0);
    if (l->type == &lobe_phong) return dvec3_scale(l->weight, 2 * PI / (l->exponent + 2));
    if (l->type == &lobe_blinn_phong) return dvec3_scale(l->weight, 8 * PI / (l->exponent + 8));
    if (!l->type->transmits) return lobe_mirrored(l, b, n, wo);
    double cosine = dvec3_dot(n, wo), reflected = interface_reflected(l, b, cosine),
           passing = lobe_passing(l, b, wo, dvec3_negate(wo), cosine, -cosine);
    return dvec3_scale(
        dvec3_add(dvec3_scale(l->reflected, reflected), dvec3_scale(l->weight, 1 - reflected)),
        passing);
}

dvec3 bsdf_albedo(const bsdf *b, dvec3 n, dvec3 wo) {
    dvec3 sum = {0, 0, 0};
    for (int i = 0; i < b->lobe_count; i++)
        sum = dvec3_add(sum, lobe_albedo(&b->lobes[i], b, n, wo));
    return (dvec3){clamp01(sum.x), clamp01(sum.y), clamp01(sum.z)};
}

/* ---- drawing one direction for all lobes ---- */

static double share_of(const lobe *l, double cosine) {
    if (l->share >= 0) return double_max(l->share, SHARE_MIN);
    if (l->type->transmits) return 1;
    dvec3 reflected = dvec3_mul(l->weight, fresnel_evaluate(&l->fresnel, cosine));
    return double_max(clamp01(dvec3_largest(reflected)), SHARE_MIN);
}

/* The shares of all lobes, made to sum to 1. */
static void find_shares(const bsdf *b, dvec3 n, dvec3 wo, double shares[LOBES_MAX]) {
    double sum = 0, cosine = dvec3_dot(n, wo);
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *l = &b->lobes[i];
        sum += shares[i] = share_of(l, l->tilted ? dvec3_dot(b->coat.n, wo) : cosine);
    }
    for (int i = 0; i < b->lobe_count; i++) shares[i] /= sum;
}

static double mixed_pdf(const bsdf *b, const double shares[LOBES_MAX], dvec3 n, dvec3 wo,
                        dvec3 wi) {
    double pdf = 0;
    bool beyond = dvec3_dot(n, wi) < 0;
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *l = &b->lobes[i];
        bool reached = l->tilted ? dvec3_dot(b->coat.n, wi) >= 0 : !beyond || l->type->transmits;
        if (l->type->pdf && reached)
            pdf += shares[i] * l->type->pdf(l, b, lobe_normal(l, b, n), wo, wi);
    }
    return pdf;
}

double bsdf_pdf(const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    double shares[LOBES_MAX];
    find_shares(b, n, wo, shares);
    return mixed_pdf(b, shares, n, wo, wi);
}

/* A smooth interface reflects with the probability F, so the weight of the reflected ray is 1. */
static bool sample_interface(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, double u,
                             bsdf_direction *out) {
    double cosine = dvec3_dot(n, wo);
    double reflected = interface_reflected(l, b, cosine);
    out->transmitted = u >= reflected;
    out->weight = out->transmitted ? l->weight : l->reflected;
    out->wi = out->transmitted ? dvec3_negate(wo) : reflect_direction(wo, n);
    if (!out->transmitted || l->type->thin) return true;
    return refract_direction(wo, n, b->ior1 / b->ior2, &out->wi);
}

static bool sample_delta(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, double share, double u,
                         bsdf_direction *out) {
    *out = (bsdf_direction){.pdf = 0};
    double cosine = dvec3_dot(n, wo);
    if (l->type->class == LOBE_INTERFACE) {
        if (!sample_interface(l, b, n, wo, u, out)) return false;
        double passing =
            lobe_passing(l, b, wo, out->wi, cosine, out->transmitted ? -cosine : cosine);
        out->weight = dvec3_scale(out->weight, passing);
    } else {
        out->wi = reflect_direction(wo, lobe_normal(l, b, n));
        out->weight = lobe_mirrored(l, b, n, wo);
    }
    out->weight = dvec3_scale(out->weight, 1 / share);
    return true;
}

bool bsdf_sample(const bsdf *b, dvec3 n, dvec3 wo, double choice, sample2 u, bsdf_direction *out) {
    if (b->lobe_count == 0) return false;
    double shares[LOBES_MAX];
    find_shares(b, n, wo, shares);
    int chosen = 0;
    for (; chosen < b->lobe_count - 1 && choice >= shares[chosen]; chosen++)
        choice -= shares[chosen];
    const lobe *l = &b->lobes[chosen];
    if (l->type->sample == NULL) return sample_delta(l, b, n, wo, shares[chosen], u.x, out);
    *out = (bsdf_direction){{0, 0, 0}, {0, 0, 0}, 0, false};
    if (!l->type->sample(l, b, lobe_normal(l, b, n), wo, u, &out->wi)) return false;
    double cosine = dvec3_dot(n, out->wi);
    out->transmitted = (b->coat.own ? dvec3_dot(b->coat.side, out->wi) : cosine) < 0;
    out->pdf = mixed_pdf(b, shares, n, wo, out->wi);
    if (!(out->pdf > 0)) return false;
    dvec3 f = bsdf_evaluate(b, LOBES_LIT, n, wo, out->wi);
    out->weight = dvec3_scale(f, fabs(cosine) / out->pdf);
    return true;
}

/* ---- Lambert ---- */

static dvec3 evaluate_lambert(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)b, (void)n, (void)wo, (void)wi;
    return lambert(l);
}

static double pdf_lambert(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)l, (void)b, (void)wo;
    return double_max(dvec3_dot(n, wi), 0) / PI;
}

static bool sample_lambert(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, sample2 u, dvec3 *wi) {
    (void)l, (void)b, (void)wo;
    *wi = dvec3_from_frame(n, warp_cosine_hemisphere(u));
    return dvec3_dot(n, *wi) > 0;
}

/* ---- the Phong family: a power of the cosine about an axis ---- */

/* A direction about +Z with the density (p + 1) / (2 pi) cos^p. */
static dvec3 warp_power(sample2 u, double exponent) {
    double cosine = fn_pow(1 - u.x, 1 / (exponent + 1));
    double sine = sqrt(double_max(0, 1 - cosine * cosine)), angle = 2 * PI * u.y;
    return (dvec3){sine * fn_cos(angle), sine * fn_sin(angle), cosine};
}

static double power_pdf(double cosine, double exponent) {
    return cosine > 0 ? (exponent + 1) / (2 * PI) * fn_pow(cosine, exponent) : 0;
}

static dvec3 evaluate_phong(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)b;
    double cosine = dvec3_dot(reflect_direction(wo, n), wi);
    return cosine > 0 ? dvec3_scale(l->weight, fn_pow(cosine, l->exponent)) : (dvec3){0, 0, 0};
}

static double pdf_phong(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)b;
    return power_pdf(dvec3_dot(reflect_direction(wo, n), wi), l->exponent);
}

static bool sample_phong(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, sample2 u, dvec3 *wi) {
    (void)b;
    *wi = dvec3_from_frame(reflect_direction(wo, n), warp_power(u, l->exponent));
    return dvec3_dot(n, *wi) > 0;
}

static dvec3 evaluate_blinn_phong(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)b;
    dvec3 h = dvec3_normalize(dvec3_add(wo, wi)); /* h = bisector(v, l) */
    double cosine = dvec3_dot(n, h);
    return cosine > 0 ? dvec3_scale(l->weight, fn_pow(cosine, l->exponent)) : (dvec3){0, 0, 0};
}

static double pdf_blinn_phong(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)b;
    dvec3 h = dvec3_normalize(dvec3_add(wo, wi));
    double facing = dvec3_dot(wo, h);
    return facing > 0 ? power_pdf(dvec3_dot(n, h), l->exponent) / (4 * facing) : 0;
}

static bool sample_blinn_phong(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, sample2 u,
                               dvec3 *wi) {
    (void)b;
    dvec3 h = dvec3_from_frame(n, warp_power(u, l->exponent));
    if (!(dvec3_dot(wo, h) > 0)) return false;
    *wi = reflect_direction(wo, h);
    return dvec3_dot(n, *wi) > 0;
}

const lobe_type lobe_lambert = {.class = LOBE_DIFFUSE,
                                .matte = true,
                                .evaluate = evaluate_lambert,
                                .pdf = pdf_lambert,
                                .sample = sample_lambert};
const lobe_type lobe_phong = {
    .class = LOBE_DIFFUSE, .evaluate = evaluate_phong, .pdf = pdf_phong, .sample = sample_phong};
const lobe_type lobe_blinn_phong = {.class = LOBE_DIFFUSE,
                                    .evaluate = evaluate_blinn_phong,
                                    .pdf = pdf_blinn_phong,
                                    .sample = sample_blinn_phong};
const lobe_type lobe_mirror = {.class = LOBE_MIRROR};
const lobe_type lobe_interface = {.class = LOBE_INTERFACE, .transmits = true};
const lobe_type lobe_thin = {.class = LOBE_INTERFACE, .transmits = true, .thin = true};

/* ---- directions ---- */

dvec3 reflect_direction(dvec3 wo, dvec3 n) {
    return dvec3_sub(dvec3_scale(n, 2 * dvec3_dot(n, wo)), wo);
}

bool refract_direction(dvec3 wo, dvec3 n, double eta, dvec3 *wi) {
    double cos1 = dvec3_dot(n, wo), k = 1 - eta * eta * (1 - cos1 * cos1);
    if (!(k > 0)) return false;
    *wi = dvec3_sub(dvec3_scale(n, eta * cos1 - sqrt(k)), dvec3_scale(wo, eta));
    return true;
}
