/* Glass and water: reflected and refracted rays by Snell and Fresnel, and Beer's law inside, exp(-a
 * d) with a per metre (Bikker, "Whitted"; the slide's exp(-ln(a) d) beside it is a slip). */
#include "materials/microfacet.h"
#include "materials/material.h"

#define DIELECTRIC_FIELDS(F, T)                                                                    \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, color, INPUT, DEFAULT(1, 1, 1), NOT_NEGATIVE, "",                                         \
      "multiplies light that passes the surface, each time it does")                               \
    F(T, ior, FLOAT, DEFAULT(1.5f), RANGE(1, 10), "", "index of refraction, relative to vacuum")   \
    F(T, roughness, SCALAR, DEFAULT(0), RANGE(0, 1), "",                                           \
      "0 is smooth; alpha of GGX is its square")                                                   \
    F(T, absorption, COLOR, DEFAULT(0, 0, 0), NOT_NEGATIVE, "1/m", "a of Beer's law, exp(-a d)")   \
    F(T, attenuation_color, COLOR, DEFAULT(1, 1, 1), RANGE(1e-6, 1), "",                           \
      "what is left of white light after attenuation_distance")                                    \
    F(T, attenuation_distance, FLOAT, DEFAULT(0), NOT_NEGATIVE, "m",                               \
      "0: attenuation_color is not used")                                                          \
    F(T, priority, INT, DEFAULT(0), RANGE(-1000, 1000), "",                                        \
      "where solids overlap the higher one is present")                                            \
    F(T, dispersion, FLOAT, DEFAULT(0), RANGE(0, 100), "",                                         \
      "20 / Abbe number: how far colours part; water .36, diamond .36, flint glass .55")
DESCRIBE(dielectric, DIELECTRIC_FIELDS)

static void fill(const void *desc, const material_point *point, bsdf *out) {
    const dielectric_desc *m = desc;
    out->ambient = (dvec3){0, 0, 0};
    *(point->outside ? &out->ior2 : &out->ior1) = (double)m->ior;
    bsdf_add_interface(out,
                       dvec3_mul(input_color(&m->color, point->textures, &point->at), point->tint),
                       clamp01(input_scalar(&m->roughness, point->textures, &point->at)));
}

static medium inside(const void *desc) {
    const dielectric_desc *m = desc;
    dvec3 more =
        medium_attenuation(dvec3_from(m->attenuation_color), (double)m->attenuation_distance);
    return medium_make((double)m->ior, (double)m->dispersion,
                       dvec3_add(dvec3_from(m->absorption), more), m->priority);
}

const material_type material_dielectric = {
    .info = TYPE_INFO_EITHER(CATEGORY_MATERIAL, dielectric, "dielectric",
                             "glass, water: reflects and refracts",
                             "absorption|attenuation_color attenuation_distance"),
    .fill = fill,
    .inside = inside,
};
