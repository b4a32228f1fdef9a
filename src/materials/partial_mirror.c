/* color * (s * Trace(reflect) + (1 - s) * Direct) (Bikker, "Whitted"), where Direct is Lambert's R
 * / pi. */
#include "materials/material.h"

#define PARTIAL_MIRROR_FIELDS(F, T)                                                                \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, color, INPUT, DEFAULT(0.9f, 0.9f, 0.9f), NOT_NEGATIVE, "", "of both parts")               \
    F(T, specularity, SCALAR, DEFAULT(0.5f), RANGE(0, 1), "", "s: 0 is matte, 1 a mirror")
DESCRIBE(partial_mirror, PARTIAL_MIRROR_FIELDS)

static void fill(const void *desc, const material_point *point, bsdf *out) {
    const partial_mirror_desc *m = desc;
    dvec3 color = dvec3_mul(input_color(&m->color, point->textures, &point->at), point->tint);
    double s = clamp01(input_scalar(&m->specularity, point->textures, &point->at));
    out->ambient = dvec3_scale(out->ambient, 1 - s); /* a part of Direct */
    bsdf_add(out, &lobe_mirror, dvec3_scale(color, s), 0);
    bsdf_add(out, &lobe_lambert, dvec3_scale(color, 1 - s), 0);
}

const material_type material_partial_mirror = {
    .info =
        TYPE_INFO(CATEGORY_MATERIAL, partial_mirror, "partial_mirror", "between matte and mirror"),
    .fill = fill,
};
