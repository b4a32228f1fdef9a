/* Cook-Torrance 1982 as the lecture has it: color / pi + specular F D G / (4 n.l n.v), with Fresnel's
 * formulas for a dielectric, Beckmann's D of slope m and Smith's G by Walter's rational fit (Cornell
 * CS4620, "Cook-Torrance"). The two parts are simply added: with color + specular above 1 it may
 * reflect more than it receives near grazing. Facets hide light from one another for good, so that it
 * darkens with m. */
#include "materials/microfacet.h"
#include "materials/material.h"

#define COOK_TORRANCE_FIELDS(F, T)                                                                 \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, color, INPUT, DEFAULT(0.5f, 0.5f, 0.5f), NOT_NEGATIVE, "", "R: the diffuse reflectance")  \
    F(T, m, SCALAR, DEFAULT(0.3f), RANGE(0, 1), "", "the mean slope of the facets; 0 is a mirror") \
    F(T, ior, FLOAT, DEFAULT(1.5f), RANGE(1, 10), "",                                              \
      "index of refraction, of Fresnel's formulas")                                                \
    F(T, specular, INPUT, DEFAULT(1, 1, 1), NOT_NEGATIVE, "", "multiplies the facets' reflection")
DESCRIBE(cook_torrance, COOK_TORRANCE_FIELDS)

static void fill(const void *desc, const material_point *point, bsdf *out) {
    const cook_torrance_desc *m = desc;
    dvec3 color = dvec3_mul(input_color(&m->color, point->textures, &point->at), point->tint);
    bsdf_add(out, &lobe_lambert, color, 0);
    double slope = clamp01(input_scalar(&m->m, point->textures, &point->at));
    lobe *l = bsdf_add(out, slope < ALPHA_MIN ? &lobe_mirror : &lobe_cook_torrance,
                       input_color(&m->specular, point->textures, &point->at), slope);
    if (l == NULL) return;
    l->fresnel = fresnel_of_ior((double)m->ior);
    if (slope < WHITTED_MIRROR_ROUGHNESS * WHITTED_MIRROR_ROUGHNESS) l->mirror_share = 1;
}

const material_type material_cook_torrance = {
    .info = TYPE_INFO(CATEGORY_MATERIAL, cook_torrance, "cook_torrance",
                      "matte under Beckmann facets, as in the lecture"),
    .fill = fill,
    .may_gain = true,
};
