/* A mirror coat over another material: L = L_a + L_r + L_m (Cornell CS4620, "Mirror reflection").
 * L_a and L_r are the base's, as are what it sends out and where it is there; L_m = reflectance *
 * Trace(reflect), or Fresnel's reflectance where an ior is given. */
#include "materials/material.h"

#include "base/error.h"

#define GLAZED_FIELDS(F, T)                                                                        \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, base, MATERIAL, NO_DEFAULT, REQUIRED, "",                                                 \
      "what is under the glaze; it traces no rays of its own")                                     \
    F(T, reflectance, INPUT, DEFAULT(0.1f, 0.1f, 0.1f), NOT_NEGATIVE, "", "the mirrored fraction") \
    F(T, ior, FLOAT, DEFAULT(0), RANGE(0, 10), "",                                                 \
      "1 or more: the mirrored fraction is Fresnel's instead")
DESCRIBE(glazed, GLAZED_FIELDS)

static snell_status check(const void *desc) {
    const glazed_desc *m = desc;
    if (m->ior != 0 && m->ior < 1)
        return error_set(SNELL_ERR_ARGUMENT, "leave it out for a constant reflectance",
                         "glazed: 'ior' must be at least 1");
    return SNELL_OK;
}

static void fill(const void *desc, const material_point *point, bsdf *out) {
    const glazed_desc *m = desc;
    const material *base = &point->materials[m->base.index1 - 1];
    out->ambient =
        dvec3_mul(out->ambient, dvec3_from(((const material_common *)base->desc)->ambient));
    base->type->fill(base->desc, point, out);
    int kept = 0; /* the base's own traced lobes are left out */
    for (int i = 0; i < out->lobe_count; i++)
        if (out->lobes[i].type->evaluate) out->lobes[kept++] = out->lobes[i];
    out->lobe_count = kept;
    dvec3 weight =
        m->ior > 0 ? (dvec3){1, 1, 1} : input_color(&m->reflectance, point->textures, &point->at);
    lobe *coat = bsdf_add(out, &lobe_mirror, weight, 0);
    if (coat && m->ior > 0) coat->fresnel = fresnel_of_ior((double)m->ior);
}

static dvec3 emission(const void *desc, const material_point *point) {
    return material_emission(&point->materials[((const glazed_desc *)desc)->base.index1 - 1],
                             point);
}

static bool shines(const void *desc, const material *materials) {
    if (materials == NULL) return false;
    const material *base = &materials[((const glazed_desc *)desc)->base.index1 - 1];
    return material_emits(base->type, base->desc);
}

static double opacity(const void *desc, const material_point *point) {
    material_point own = *point;
    own.alpha = 1; /* the vertices' counts once, for the whole */
    return material_alpha(&point->materials[((const glazed_desc *)desc)->base.index1 - 1], &own);
}

const material_type material_glazed = {
    .info = TYPE_INFO_EITHER(CATEGORY_MATERIAL, glazed, "glazed",
                             "a mirror coat over another material", "reflectance|ior"),
    .check = check,
    .fill = fill,
    .emission = emission,
    .shines = shines,
    .opacity = opacity,
    .may_gain = true, /* the base does not know of the coat */
};
