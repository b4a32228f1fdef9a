/* A diffuse base under a rough dielectric coat:
 *
 *     f = F D G2 / (4 n.l n.v) + color / pi (1 - E(wo)) (1 - E(wi)) / (1 - E_avg)
 *
 * GGX with Schlick's F from ((ior - 1) / (ior + 1))^2 to 1; E is the coat's own directional albedo,
 * so that the base gets what the coat leaves. Reciprocal, and in white it sends on all that it
 * receives (Kelemen and Szirmay-Kalos 2001, A Microfacet Based Coupled Specular-Matte BRDF Model). */
#include "materials/microfacet.h"
#include "materials/material.h"

#define GGX_FIELDS(F, T)                                                                           \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, color, INPUT, DEFAULT(0.5f, 0.5f, 0.5f), NOT_NEGATIVE, "",                                \
      "the base's diffuse reflectance")                                                            \
    F(T, roughness, SCALAR, DEFAULT(0.3f), RANGE(0, 1), "",                                        \
      "of the coat: 0 is a mirror; alpha of GGX is its square")                                    \
    F(T, ior, FLOAT, DEFAULT(1.5f), RANGE(1, 10), "", "index of refraction of the coat")
DESCRIBE(ggx, GGX_FIELDS)

static void fill(const void *desc, const material_point *point, bsdf *out) {
    const ggx_desc *m = desc;
    dvec3 color = dvec3_mul(input_color(&m->color, point->textures, &point->at), point->tint);
    double roughness = clamp01(input_scalar(&m->roughness, point->textures, &point->at));
    double f0 = fresnel_f0((double)m->ior);
    bsdf_add_under(out, color, roughness, f0, 1);
    bsdf_add_ggx(out, (dvec3){1, 1, 1}, roughness,
                 (fresnel){FRESNEL_SCHLICK, {f0, f0, f0}, {1, 1, 1}}, 0);
}

const material_type material_ggx = {
    .info = TYPE_INFO(CATEGORY_MATERIAL, ggx, "ggx", "matte under a rough clear coat"),
    .fill = fill,
};
