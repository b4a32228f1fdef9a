/* A black surface that shines. Every material may: this one is for lamps. */
#include "materials/material.h"

#define EMISSIVE_FIELDS(F, T)                                                                      \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, radiance, INPUT, DEFAULT(5, 5, 5), NOT_NEGATIVE, "W/(m^2 sr)",                            \
      "what it sends out, beside emission")
DESCRIBE(emissive, EMISSIVE_FIELDS)

static void fill(const void *desc, const material_point *point, bsdf *out) {
    (void)desc, (void)point;
    out->ambient = (dvec3){0, 0, 0};
}

static dvec3 emission(const void *desc, const material_point *point) {
    return input_color(&((const emissive_desc *)desc)->radiance, point->textures, &point->at);
}

static bool shines(const void *desc, const material *materials) {
    (void)materials;
    return vec3_largest(((const emissive_desc *)desc)->radiance.value) > 0;
}

const material_type material_emissive = {
    .info = TYPE_INFO(CATEGORY_MATERIAL, emissive, "emissive", "a lamp: black, and it shines"),
    .fill = fill,
    .emission = emission,
    .shines = shines,
};
