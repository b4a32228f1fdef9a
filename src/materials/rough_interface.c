/* Rough boundaries that light passes: Walter et al. 2007, Microfacet Models for Refraction through
 * Rough Surfaces, with GGX.
 *
 * Radiance that crosses a boundary grows by the square of the indices' ratio, and shrinks by it on
 * the way out. The lectures' smooth interface leaves that out (its weights are F and 1 - F), so this
 * one does too: of equation 21 it has ior_i^2 where the paper has ior_o^2. In the smooth limit it
 * is lobe_interface. So reciprocity reads f(wo, wi) / ior_i^2 = f(wi, wo) / ior_o^2. */
#include "materials/microfacet.h"

#include "maths/functions.h"

/* One boundary as seen from wo. */
typedef struct boundary {
    double ior1, ior2; /* on wo's side and beyond */
    double reflecting; /* the probability that `sample` reflects */
} boundary;

/* Where both sides are all but the same, every facet passes light straight on, a delta that this
 * lobe cannot be: they are kept apart by a thousandth. */
static boundary find_boundary(const lobe *l, const bsdf *b, double cos_o) {
    boundary at = {b->ior1, b->ior2, 0};
    if (l->type->thin) at.ior1 = 1, at.ior2 = l->fresnel.a.x;
    if (fabs(at.ior2 - at.ior1) < 1e-3 * at.ior1) at.ior2 = 1.001 * at.ior1;
    double reflected = fresnel_dielectric(cos_o, at.ior1, at.ior2);
    at.reflecting = double_min(double_max(reflected, 0.05), 0.95);
    return at;
}

/* The facet that refracts wo into wi, on n's side; both directions on opposite sides of it. */
typedef struct crossing {
    dvec3 h;
    double o_h, i_h; /* wo.h > 0, wi.h < 0 */
    double spread;   /* (ior_i wi.h + ior_o wo.h)^2 */
} crossing;

static bool find_crossing(const boundary *at, dvec3 n, dvec3 wo, dvec3 wi, crossing *out) {
    dvec3 sum = dvec3_add(dvec3_scale(wo, at->ior1), dvec3_scale(wi, at->ior2));
    out->h = dvec3_normalize(sum);
    if (dvec3_dot(out->h, n) < 0) out->h = dvec3_negate(out->h);
    out->o_h = dvec3_dot(wo, out->h);
    out->i_h = dvec3_dot(wi, out->h);
    double root = at->ior2 * out->i_h + at->ior1 * out->o_h;
    out->spread = root * root;
    return out->o_h > 0 && out->i_h < 0 && out->spread > 0;
}

static dvec3 evaluate_transmission(const lobe *l, const boundary *at, dvec3 n, dvec3 wo, dvec3 wi) {
    crossing c;
    double cos_o = double_max(dvec3_dot(n, wo), COS_MIN),
           cos_i = double_max(-dvec3_dot(n, wi), COS_MIN);
    if (!find_crossing(at, n, wo, wi, &c)) return (dvec3){0, 0, 0};
    double passed = 1 - fresnel_dielectric(c.o_h, at->ior1, at->ior2);
    double g = ggx_g1(cos_o, l->alpha) * ggx_g1(cos_i, l->alpha);
    double d = ggx_d(dvec3_dot(n, c.h), l->alpha);
    double value =
        c.o_h * -c.i_h * at->ior2 * at->ior2 * passed * d * g / (cos_o * cos_i * c.spread);
    return dvec3_scale(l->weight, value);
}

/* The reflection of wi in the surface. */
static dvec3 to_this_side(dvec3 n, dvec3 wi) {
    return dvec3_sub(wi, dvec3_scale(n, 2 * dvec3_dot(n, wi)));
}

/* GGX reflection without its Fresnel factor; *facing is the cosine for that. */
static double evaluate_facets(double alpha, dvec3 n, dvec3 wo, dvec3 wi, double *facing) {
    double cos_o = double_max(dvec3_dot(n, wo), COS_MIN), cos_i = dvec3_dot(n, wi);
    if (!(cos_i > 0)) return 0;
    cos_i = double_max(cos_i, COS_MIN);
    dvec3 h = dvec3_normalize(dvec3_add(wo, wi));
    *facing = clamp01(dvec3_dot(wo, h));
    return ggx_d(dvec3_dot(n, h), alpha) * ggx_visibility(cos_o, cos_i, alpha);
}

static dvec3 evaluate(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    boundary at = find_boundary(l, b, dvec3_dot(n, wo));
    bool beyond = dvec3_dot(n, wi) < 0;
    if (beyond && !l->type->thin) return evaluate_transmission(l, &at, n, wo, wi);
    double facing = 0;
    double value = evaluate_facets(l->alpha, n, wo, beyond ? to_this_side(n, wi) : wi, &facing);
    double reflected = fresnel_dielectric(facing, at.ior1, at.ior2);
    return beyond ? dvec3_scale(l->weight, value * (1 - reflected))
                  : dvec3_scale(l->reflected, value * reflected);
}

static double pdf_mirrored(double alpha, dvec3 n, dvec3 wo, dvec3 wi) {
    if (!(dvec3_dot(n, wi) > 0)) return 0;
    dvec3 h = dvec3_normalize(dvec3_add(wo, wi));
    double facing = dvec3_dot(wo, h);
    if (!(facing > 0)) return 0;
    return ggx_visible_pdf(dvec3_to_frame(n, wo), dvec3_to_frame(n, h), alpha) / (4 * facing);
}

/* Walter et al. 2007, equation 17. */
static double pdf_refracted(const lobe *l, const boundary *at, dvec3 n, dvec3 wo, dvec3 wi) {
    crossing c;
    if (!find_crossing(at, n, wo, wi, &c)) return 0;
    double facets = ggx_visible_pdf(dvec3_to_frame(n, wo), dvec3_to_frame(n, c.h), l->alpha);
    return facets * at->ior2 * at->ior2 * -c.i_h / c.spread;
}

static double pdf(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    boundary at = find_boundary(l, b, dvec3_dot(n, wo));
    bool beyond = dvec3_dot(n, wi) < 0;
    if (!beyond) return at.reflecting * pdf_mirrored(l->alpha, n, wo, wi);
    if (l->type->thin)
        return (1 - at.reflecting) * pdf_mirrored(l->alpha, n, wo, to_this_side(n, wi));
    return (1 - at.reflecting) * pdf_refracted(l, &at, n, wo, wi);
}

static bool sample(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, sample2 u, dvec3 *wi) {
    boundary at = find_boundary(l, b, dvec3_dot(n, wo));
    bool reflects = u.x < at.reflecting; /* u.x is then as good as new */
    u.x = reflects ? u.x / at.reflecting : (u.x - at.reflecting) / (1 - at.reflecting);
    dvec3 local = dvec3_to_frame(n, wo);
    dvec3 h = dvec3_from_frame(n, ggx_sample_visible(local, l->alpha, u));
    if (reflects || l->type->thin) {
        *wi = reflect_direction(wo, h);
        if (!(dvec3_dot(n, *wi) > 0)) return false;
        if (!reflects) *wi = to_this_side(n, *wi);
        return true;
    }
    return refract_direction(wo, h, at.ior1 / at.ior2, wi) && dvec3_dot(n, *wi) < 0;
}

const lobe_type lobe_rough_interface = {
    .class = LOBE_GLOSSY, .transmits = true, .evaluate = evaluate, .pdf = pdf, .sample = sample};
const lobe_type lobe_rough_thin = {.class = LOBE_GLOSSY,
                                   .transmits = true,
                                   .thin = true,
                                   .evaluate = evaluate,
                                   .pdf = pdf,
                                   .sample = sample};

lobe *bsdf_add_interface(bsdf *b, dvec3 weight, double roughness) {
    double alpha = roughness * roughness;
    return bsdf_add(b, alpha < ALPHA_MIN ? &lobe_interface : &lobe_rough_interface, weight, alpha);
}

lobe *bsdf_add_thin(bsdf *b, dvec3 weight, double roughness, double ior) {
    double alpha = roughness * roughness;
    lobe *l = bsdf_add(b, alpha < ALPHA_MIN ? &lobe_thin : &lobe_rough_thin, weight, alpha);
    if (l) l->fresnel = fresnel_of_ior(ior);
    return l;
}
