/* Phong: (R/pi + k_s (r.v)^p) max(0, n.l), r being l mirrored at n (Cornell CS4620, "Specular
 * shading"). Not normalised: it may reflect more than it receives. */
#include "materials/material.h"

#define PHONG_FIELDS(F, T)                                                                         \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, color, INPUT, DEFAULT(0.8f, 0.8f, 0.8f), NOT_NEGATIVE, "", "R: the diffuse reflectance")  \
    F(T, specular, INPUT, DEFAULT(0.3f, 0.3f, 0.3f), NOT_NEGATIVE, "1/sr",                         \
      "k_s: the strength of the highlight")                                                        \
    F(T, exponent, FLOAT, DEFAULT(50), RANGE(0, 1e6), "", "p: higher is sharper")
DESCRIBE(phong, PHONG_FIELDS)

static void fill(const void *desc, const material_point *point, bsdf *out) {
    const phong_desc *m = desc;
    dvec3 color = dvec3_mul(input_color(&m->color, point->textures, &point->at), point->tint);
    bsdf_add(out, &lobe_lambert, color, 0);
    bsdf_add(out, &lobe_phong, input_color(&m->specular, point->textures, &point->at),
             (double)m->exponent);
}

const material_type material_phong = {
    .info = TYPE_INFO(CATEGORY_MATERIAL, phong, "phong", "matte with a highlight about r"),
    .fill = fill,
    .may_gain = true,
};
