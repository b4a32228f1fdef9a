/* Microfacets: how many of a rough surface's facets face each way, and how they hide one another.
 *
 * cos_h is the cosine of the facet's normal h with the surface's n, cos_v that of a direction with
 * n. alpha is Beckmann's m and GGX's alpha = roughness^2, at least ALPHA_MIN: below it a lobe is
 * better a mirror, and its peak would drown in rounding. */
#ifndef SNELL_MATERIALS_MICROFACET_H
#define SNELL_MATERIALS_MICROFACET_H

#include "materials/bsdf.h"

#define ALPHA_MIN 1e-4
#define COS_MIN 1e-9 /* for directions in the surface itself: what is divided by it stays finite */
#define WHITTED_MIRROR_ROUGHNESS 0.05 /* whitted takes smoother ones for mirrors */
#define SHEEN_ALPHA_MIN 0.07          /* of sheen: below it the fit of Lambda gains energy */

/* The density of facets: D cos_h integrates to 1. 1/sr. */
double beckmann_d(double cos_h, double m);
double ggx_d(double cos_h, double alpha);
/* The fraction of the facets that is seen from v. Walter et al. 2007's rational fit for Beckmann:
 * it exceeds 1 by 5.7e-5 just below a = 1.6. Both 0 for cos_v <= 0. */
double beckmann_g1(double cos_v, double m);
double ggx_g1(double cos_v, double alpha);
/* Smith's G2 / (4 cos_o cos_i), facets hiding one another correlated by their height: no division
 * by a cosine is left (Heitz 2014, Understanding the Masking-Shadowing Function, equation 99). */
double ggx_visibility(double cos_o, double cos_i, double alpha);
/* Facet normals about +Z with the density D cos_h. */
dvec3 beckmann_sample(double m, sample2 u);
/* Facet normals with the density of those seen from `wo` (about +Z, wo.z >= 0), which is
 * ggx_visible_pdf: G1 D max(0, wo.h) / wo.z. */
dvec3 ggx_sample_visible(dvec3 wo, double alpha, sample2 u);
double ggx_visible_pdf(dvec3 wo, dvec3 h, double alpha);
/* Another fibre-like density, of sheen, and its visibility G / (4 cos_o cos_i) (Estevez and Kulla
 * 2017, Production Friendly Microfacet Sheen BRDF). */
double sheen_d(double cos_h, double alpha);
double sheen_visibility(double cos_o, double cos_i, double alpha);

/* F D G / (4 cos_o cos_i), Beckmann, G = G1 G1 (Cornell CS4620, "Cook-Torrance"). Loses energy
 * where it is rough, by design. */
extern const lobe_type lobe_cook_torrance;
/* The same of GGX with G2, single scattering: bsdf_add_under makes up for the rest. */
extern const lobe_type lobe_ggx;
/* The same where facets are rougher along the bsdf's tangent than across it: alpha_along, alpha. */
extern const lobe_type lobe_grained;
/* w (1 - E(wo)) (1 - E(wi)) / (pi (1 - E_avg)): what is under a GGX lobe of albedo E gets and
 * sends exactly what that lobe leaves (Kelemen and Szirmay-Kalos 2001), be it a diffuse base or the
 * light that facets scatter more than once (Kulla and Conty 2017). E is that of Schlick's lobe from
 * fresnel.a.x to fresnel.b.x. */
extern const lobe_type lobe_under;
/* A rough boundary between the bsdf's ior1 and ior2: GGX reflection and refraction (Walter et al.
 * 2007). Like the smooth one it does not scale radiance by the square of the indices. */
extern const lobe_type lobe_rough_interface;
/* A rough pane without thickness: what passes is what would be reflected, seen from behind. */
extern const lobe_type lobe_rough_thin;
/* weight * D V of fibres. */
extern const lobe_type lobe_sheen;

/* GGX of a roughness 0..1; a mirror where that is smoother than the lobe can be. In whitted,
 * mirror_share of it is a mirror, and all of it below roughness 0.05. NULL: it would do nothing. */
lobe *bsdf_add_ggx(bsdf *b, dvec3 weight, double roughness, fresnel f, double mirror_share);
/* The same, rougher along the bsdf's tangent the stronger the grain, 0..1: alpha there is mixed
 * with 1 by its square (KHR_materials_anisotropy). */
lobe *bsdf_add_grained(bsdf *b, dvec3 weight, double roughness, double grain, fresnel f,
                       double mirror_share);
/* What is under a GGX lobe of that roughness and of reflectance f0 .. f90. */
lobe *bsdf_add_under(bsdf *b, dvec3 weight, double roughness, double f0, double f90);
/* What the facets of a metal scatter more than once, r being its reflectance at normal incidence
 * and 1 that at grazing. */
lobe *bsdf_add_multiple(bsdf *b, dvec3 weight, double roughness, dvec3 r);
/* An interface of that roughness, smooth or rough. */
lobe *bsdf_add_interface(bsdf *b, dvec3 weight, double roughness);
lobe *bsdf_add_thin(bsdf *b, dvec3 weight, double roughness, double ior);

#endif
