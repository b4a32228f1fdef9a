#include "materials/microfacet.h"

#include "materials/albedo.h"
#include "maths/functions.h"

/* ---- Beckmann ---- */

/* exp(-tan^2 / m^2) / (pi m^2 cos^4) (Cornell CS4620, "Cook-Torrance"). */
double beckmann_d(double cos_h, double m) {
    if (!(cos_h > 0)) return 0;
    double cos2 = cos_h * cos_h, tan2 = double_max(0, 1 - cos2) / cos2;
    double fall = fn_exp(-tan2 / (m * m));
    return fall > 0 ? fall / (PI * m * m * cos2 * cos2) : 0;
}

/* Walter et al. 2007, below equation 27; a = 1 / (m tan), which the slide leaves out. */
double beckmann_g1(double cos_v, double m) {
    if (!(cos_v > 0)) return 0;
    double sin2 = 1 - cos_v * cos_v;
    if (!(sin2 > 0)) return 1;
    double a = cos_v / (m * sqrt(sin2));
    return a < 1.6 ? (3.535 * a + 2.181 * a * a) / (1 + 2.276 * a + 2.577 * a * a) : 1;
}

/* tan^2 = -m^2 ln(1 - u) (Walter et al. 2007, equation 28). */
dvec3 beckmann_sample(double m, sample2 u) {
    double tan2 = -m * m * fn_log(1 - u.x);
    double cosine = 1 / sqrt(1 + tan2), sine = sqrt(tan2) * cosine, angle = 2 * PI * u.y;
    return (dvec3){sine * fn_cos(angle), sine * fn_sin(angle), cosine};
}

/* ---- GGX ---- */

/* alpha^2 / (pi (1 + cos^2 (alpha^2 - 1))^2) (Walter et al. 2007, equation 33). */
double ggx_d(double cos_h, double alpha) {
    if (!(cos_h > 0)) return 0;
    double a2 = alpha * alpha, cos2 = cos_h * cos_h;
    double spread = cos2 * a2 + double_max(0, 1 - cos2);
    return a2 / (PI * spread * spread);
}

static double ggx_root(double cos_v, double alpha) {
    double a2 = alpha * alpha;
    return sqrt(a2 + (1 - a2) * cos_v * cos_v);
}

double ggx_g1(double cos_v, double alpha) {
    return cos_v > 0 ? 2 * cos_v / (cos_v + ggx_root(cos_v, alpha)) : 0;
}

double ggx_visibility(double cos_o, double cos_i, double alpha) {
    return 0.5 / (cos_o * ggx_root(cos_i, alpha) + cos_i * ggx_root(cos_o, alpha));
}

/* Dupuy and Benyoub 2023, Sampling Visible GGX Normals with Spherical Caps. */
static dvec3 sample_visible(dvec3 wo, double along, double across, sample2 u) {
    dvec3 stretched = dvec3_normalize((dvec3){wo.x * along, wo.y * across, wo.z});
    double angle = 2 * PI * u.x, z = (1 - u.y) * (1 + stretched.z) - stretched.z;
    double sine = sqrt(double_max(0, 1 - z * z));
    dvec3 h = dvec3_add((dvec3){sine * fn_cos(angle), sine * fn_sin(angle), z}, stretched);
    return dvec3_normalize((dvec3){h.x * along, h.y * across, double_max(h.z, 1e-12)});
}

dvec3 ggx_sample_visible(dvec3 wo, double alpha, sample2 u) {
    return sample_visible(wo, alpha, alpha, u);
}

double ggx_visible_pdf(dvec3 wo, dvec3 h, double alpha) {
    double facing = dvec3_dot(wo, h);
    if (!(facing > 0)) return 0;
    return 2 * ggx_d(h.z, alpha) * facing / (wo.z + ggx_root(wo.z, alpha));
}

/* ---- sheen ---- */

double sheen_d(double cos_h, double alpha) {
    double sin2 = double_max(0, 1 - cos_h * cos_h);
    return (2 + 1 / alpha) * fn_pow(sin2, 0.5 / alpha) / (2 * PI);
}

/* The paper's fit of Lambda, between alpha 0 and 1. */
static double sheen_fit(double x, double alpha) {
    double part = (1 - alpha) * (1 - alpha), rest = 1 - part;
    double a = part * 25.3245 + rest * 21.5473, b = part * 3.32435 + rest * 3.82987,
           c = part * 0.16801 + rest * 0.19823, d = part * -1.27393 + rest * -1.97760,
           e = part * -4.85967 + rest * -4.32054;
    return a / (1 + b * fn_pow(x, c)) + d * x + e;
}

static double sheen_lambda(double cosine, double alpha) {
    if (cosine < 0.5) return fn_exp(sheen_fit(cosine, alpha));
    return fn_exp(2 * sheen_fit(0.5, alpha) - sheen_fit(1 - cosine, alpha));
}

double sheen_visibility(double cos_o, double cos_i, double alpha) {
    return 1 / ((1 + sheen_lambda(cos_o, alpha) + sheen_lambda(cos_i, alpha)) * 4 * cos_o * cos_i);
}

/* ---- reflection by facets ---- */

/* Both directions on n's side, and the facet between them. */
typedef struct facet {
    dvec3 h;
    double cos_o, cos_i, cos_h, facing; /* facing = wo.h = wi.h */
} facet;

static bool find_facet(dvec3 n, dvec3 wo, dvec3 wi, facet *out) {
    out->cos_i = dvec3_dot(n, wi);
    if (!(out->cos_i > 0)) return false;
    out->cos_o = double_max(dvec3_dot(n, wo), COS_MIN);
    out->cos_i = double_max(out->cos_i, COS_MIN);
    out->h = dvec3_normalize(dvec3_add(wo, wi));
    out->cos_h = dvec3_dot(n, out->h);
    out->facing = dvec3_dot(wo, out->h);
    return out->facing > 0 && out->cos_h > 0;
}

static dvec3 tinted(const lobe *l, const facet *f, double value) {
    return dvec3_scale(dvec3_mul(l->weight, fresnel_evaluate(&l->fresnel, clamp01(f->facing))),
                       value);
}

static dvec3 evaluate_cook_torrance(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)b;
    facet f;
    if (!find_facet(n, wo, wi, &f)) return (dvec3){0, 0, 0};
    double m = l->alpha, g = beckmann_g1(f.cos_o, m) * beckmann_g1(f.cos_i, m);
    return tinted(l, &f, beckmann_d(f.cos_h, m) * g / (4 * f.cos_o * f.cos_i));
}

static double pdf_cook_torrance(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)b;
    facet f;
    if (!find_facet(n, wo, wi, &f)) return 0;
    return beckmann_d(f.cos_h, l->alpha) * f.cos_h / (4 * f.facing);
}

static bool sample_cook_torrance(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, sample2 u,
                                 dvec3 *wi) {
    (void)b;
    dvec3 h = dvec3_from_frame(n, beckmann_sample(l->alpha, u));
    if (!(dvec3_dot(wo, h) > 0)) return false;
    *wi = reflect_direction(wo, h);
    return dvec3_dot(n, *wi) > 0;
}

static dvec3 evaluate_ggx(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)b;
    facet f;
    if (!find_facet(n, wo, wi, &f)) return (dvec3){0, 0, 0};
    return tinted(l, &f, ggx_d(f.cos_h, l->alpha) * ggx_visibility(f.cos_o, f.cos_i, l->alpha));
}

static double pdf_ggx(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)b;
    facet f;
    if (!find_facet(n, wo, wi, &f)) return 0;
    return ggx_d(f.cos_h, l->alpha) / (2 * (f.cos_o + ggx_root(f.cos_o, l->alpha)));
}

static bool sample_ggx(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, sample2 u, dvec3 *wi) {
    (void)b;
    dvec3 local = dvec3_to_frame(n, wo);
    *wi = dvec3_from_frame(n, reflect_direction(local, ggx_sample_visible(local, l->alpha, u)));
    return dvec3_dot(n, *wi) > 0;
}

const lobe_type lobe_cook_torrance = {.class = LOBE_GLOSSY,
                                      .evaluate = evaluate_cook_torrance,
                                      .pdf = pdf_cook_torrance,
                                      .sample = sample_cook_torrance};
const lobe_type lobe_ggx = {
    .class = LOBE_GLOSSY, .evaluate = evaluate_ggx, .pdf = pdf_ggx, .sample = sample_ggx};

/* ---- facets that are longer one way (Heitz 2014, section 5.4) ---- */

/* Directions to a frame whose x is the grain. */
typedef struct grain_frame {
    dvec3 x, y, n;
} grain_frame;

static grain_frame find_grain(const bsdf *b, dvec3 n) {
    grain_frame g = {.n = n};
    dvec3 along = dvec3_sub(b->tangent, dvec3_scale(n, dvec3_dot(n, b->tangent)));
    if (dvec3_length(along) > 1e-6 * dvec3_length(b->tangent)) {
        g.x = dvec3_normalize(along);
        g.y = dvec3_cross(n, g.x);
    } else {
        dvec3_frame(n, &g.x, &g.y);
    }
    return g;
}

static dvec3 to_grain(const grain_frame *g, dvec3 v) {
    return (dvec3){dvec3_dot(g->x, v), dvec3_dot(g->y, v), dvec3_dot(g->n, v)};
}

/* The length of a direction in the space where the facets are those of alpha 1: in place of
 * ggx_root. */
static double grained_root(dvec3 v, double along, double across) {
    return dvec3_length((dvec3){v.x * along, v.y * across, v.z});
}

static double grained_d(dvec3 h, double along, double across) {
    if (!(h.z > 0)) return 0;
    double x = h.x / along, y = h.y / across, spread = x * x + y * y + h.z * h.z;
    return 1 / (PI * along * across * spread * spread);
}

static dvec3 evaluate_grained(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    facet f;
    if (!find_facet(n, wo, wi, &f)) return (dvec3){0, 0, 0};
    grain_frame g = find_grain(b, n);
    double along = l->alpha_along, across = l->alpha;
    double shadow = f.cos_o * grained_root(to_grain(&g, wi), along, across) +
                    f.cos_i * grained_root(to_grain(&g, wo), along, across);
    return tinted(l, &f, grained_d(to_grain(&g, f.h), along, across) * 0.5 / shadow);
}

static double pdf_grained(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    facet f;
    if (!find_facet(n, wo, wi, &f)) return 0;
    grain_frame g = find_grain(b, n);
    double along = l->alpha_along, across = l->alpha;
    return grained_d(to_grain(&g, f.h), along, across) /
           (2 * (f.cos_o + grained_root(to_grain(&g, wo), along, across)));
}

static bool sample_grained(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, sample2 u, dvec3 *wi) {
    grain_frame g = find_grain(b, n);
    dvec3 local = to_grain(&g, wo);
    dvec3 out = reflect_direction(local, sample_visible(local, l->alpha_along, l->alpha, u));
    *wi = dvec3_add(dvec3_scale(g.x, out.x),
                    dvec3_add(dvec3_scale(g.y, out.y), dvec3_scale(g.n, out.z)));
    return dvec3_dot(n, *wi) > 0;
}

const lobe_type lobe_grained = {.class = LOBE_GLOSSY,
                                .evaluate = evaluate_grained,
                                .pdf = pdf_grained,
                                .sample = sample_grained};

static dvec3 evaluate_sheen(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)b;
    facet f;
    if (!find_facet(n, wo, wi, &f)) return (dvec3){0, 0, 0};
    double value = sheen_d(f.cos_h, l->alpha) * sheen_visibility(f.cos_o, f.cos_i, l->alpha);
    return dvec3_scale(l->weight, value);
}

static double pdf_sheen(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)l, (void)b, (void)wo;
    return dvec3_dot(n, wi) > 0 ? 1 / (2 * PI) : 0;
}

/* So broad, and so bright near grazing, that a uniform direction serves it best. */
static bool sample_sheen(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, sample2 u, dvec3 *wi) {
    (void)l, (void)b, (void)wo;
    double sine = sqrt(double_max(0, 1 - u.x * u.x)), angle = 2 * PI * u.y;
    *wi = dvec3_from_frame(n, (dvec3){sine * fn_cos(angle), sine * fn_sin(angle), u.x});
    return dvec3_dot(n, *wi) > 0;
}

const lobe_type lobe_sheen = {
    .class = LOBE_DIFFUSE, .evaluate = evaluate_sheen, .pdf = pdf_sheen, .sample = sample_sheen};

/* ---- what is under a GGX lobe ---- */

static dvec3 evaluate_under(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)b;
    double f0 = l->fresnel.a.x, f90 = l->fresnel.b.x;
    double left = 1 - albedo_ggx_mean(l->alpha, f0, f90);
    if (!(left > 1e-6)) return (dvec3){0, 0, 0};
    double from = 1 - albedo_ggx(l->alpha, dvec3_dot(n, wo), f0, f90),
           to = 1 - albedo_ggx(l->alpha, dvec3_dot(n, wi), f0, f90);
    return dvec3_scale(l->weight, from * to / (PI * left));
}

static double pdf_cosine(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    return lobe_lambert.pdf(l, b, n, wo, wi);
}
static bool sample_cosine(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, sample2 u, dvec3 *wi) {
    return lobe_lambert.sample(l, b, n, wo, u, wi);
}

const lobe_type lobe_under = {.class = LOBE_DIFFUSE,
                              .matte = true,
                              .evaluate = evaluate_under,
                              .pdf = pdf_cosine,
                              .sample = sample_cosine};

/* ---- adding them to a bsdf ---- */

lobe *bsdf_add_ggx(bsdf *b, dvec3 weight, double roughness, fresnel f, double mirror_share) {
    double alpha = roughness * roughness;
    lobe *l = bsdf_add(b, alpha < ALPHA_MIN ? &lobe_mirror : &lobe_ggx, weight, alpha);
    if (l == NULL) return NULL;
    l->fresnel = f;
    l->mirror_share = roughness < WHITTED_MIRROR_ROUGHNESS ? 1 : mirror_share;
    return l;
}

lobe *bsdf_add_grained(bsdf *b, dvec3 weight, double roughness, double grain, fresnel f,
                       double mirror_share) {
    double alpha = roughness * roughness, along = alpha + (1 - alpha) * grain * grain;
    if (along < ALPHA_MIN) return bsdf_add_ggx(b, weight, roughness, f, mirror_share);
    lobe *l = bsdf_add(b, &lobe_grained, weight, double_max(alpha, ALPHA_MIN));
    if (l == NULL) return NULL;
    l->alpha_along = along;
    l->fresnel = f;
    l->mirror_share = mirror_share * (1 - grain) * (1 - grain);
    return l;
}

lobe *bsdf_add_under(bsdf *b, dvec3 weight, double roughness, double f0, double f90) {
    double alpha = roughness * roughness;
    lobe *l = bsdf_add(b, &lobe_under, weight, alpha);
    if (l == NULL) return NULL;
    l->fresnel = (fresnel){FRESNEL_SCHLICK, {f0, f0, f0}, {f90, f90, f90}};
    l->share = clamp01(dvec3_largest(weight) * (1 - albedo_ggx_mean(alpha, f0, f90)));
    return l;
}

/* Kulla and Conty 2017 with Hill's F_avg^2 E_avg / (1 - F_avg (1 - E_avg)), where F_avg is the mean
 * of Schlick's reflectance, r + (1 - r) / 21. */
static double multiple_tint(double r, double mean) {
    double f = r + (1 - r) / 21;
    return f * f * mean / (1 - f * (1 - mean));
}

lobe *bsdf_add_multiple(bsdf *b, dvec3 weight, double roughness, dvec3 r) {
    double alpha = roughness * roughness, mean = albedo_ggx_mean(alpha, 1, 1);
    if (alpha < ALPHA_MIN) return NULL;
    dvec3 tint = {multiple_tint(r.x, mean), multiple_tint(r.y, mean), multiple_tint(r.z, mean)};
    return bsdf_add_under(b, dvec3_mul(weight, tint), roughness, 1, 1);
}
