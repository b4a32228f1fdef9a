/* Light from infinitely far away, such as the sun: no falloff. */
#include "lights/light.h"

#define DIRECTIONAL_FIELDS(F, T)                                                                   \
    F(T, direction, VEC3, DEFAULT(0, -1, 0), REQUIRED_DIRECTION, "", "the way the light travels")  \
    F(T, irradiance, COLOR, DEFAULT(1, 1, 1), NOT_NEGATIVE, "W/m^2", "on a surface that faces it")
DESCRIBE(directional, DIRECTIONAL_FIELDS)

static bool sample(const void *desc, dvec3 p, dvec3 eye, light_sample *out) {
    (void)p, (void)eye;
    const directional_desc *l = desc;
    *out = (light_sample){dvec3_normalize(dvec3_negate(dvec3_from(l->direction))), true,
                          dvec3_from(l->irradiance)};
    return true;
}

const light_type light_directional = {
    .info = TYPE_INFO(CATEGORY_LIGHT, directional, "directional", "parallel light from far away"),
    .sample = sample,
    .casts_shadow = true,
};
