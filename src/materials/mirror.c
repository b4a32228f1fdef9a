/* The perfect mirror: color * Trace(reflect) (Bikker, "Whitted"). No n.l and no direct light. */
#include "materials/material.h"

#define MIRROR_FIELDS(F, T)                                                                        \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, color, INPUT, DEFAULT(0.9f, 0.9f, 0.9f), NOT_NEGATIVE, "",                                \
      "the fraction of light that it reflects")
DESCRIBE(mirror, MIRROR_FIELDS)

static void fill(const void *desc, const material_point *point, bsdf *out) {
    const mirror_desc *m = desc;
    out->ambient = (dvec3){0, 0, 0}; /* it shows what it mirrors, nothing else */
    bsdf_add(out, &lobe_mirror,
             dvec3_mul(input_color(&m->color, point->textures, &point->at), point->tint), 0);
}

const material_type material_mirror = {
    .info = TYPE_INFO(CATEGORY_MATERIAL, mirror, "mirror", "a perfect mirror"),
    .fill = fill,
};
