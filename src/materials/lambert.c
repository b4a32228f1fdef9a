/* Diffuse reflection: R / pi, the same in every direction (Cornell CS4620, "Lambertian shading").
 */
#include "materials/material.h"

#define LAMBERT_FIELDS(F, T)                                                                       \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, color, INPUT, DEFAULT(0.8f, 0.8f, 0.8f), NOT_NEGATIVE, "",                                \
      "R: the fraction of light that it reflects")
DESCRIBE(lambert, LAMBERT_FIELDS)

static void fill(const void *desc, const material_point *point, bsdf *out) {
    const lambert_desc *m = desc;
    dvec3 color = dvec3_mul(input_color(&m->color, point->textures, &point->at), point->tint);
    bsdf_add(out, &lobe_lambert, color, 0);
}

const material_type material_lambert = {
    .info = TYPE_INFO(CATEGORY_MATERIAL, lambert, "lambert", "matte: R / pi"),
    .fill = fill,
};
