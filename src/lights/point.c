/* The isotropic point source. */
#include "lights/light.h"

#include "maths/functions.h"

#define POINT_FIELDS(F, T)                                                                         \
    F(T, position, VEC3, DEFAULT(0, 0, 0), REQUIRED, "m", "where it is")                           \
    F(T, intensity, COLOR, DEFAULT(1, 1, 1), NOT_NEGATIVE, "W/sr",                                 \
      "power per solid angle, in every direction")                                                 \
    F(T, power, COLOR, DEFAULT(0, 0, 0), NOT_NEGATIVE, "W", "instead of intensity: I = P / (4 pi)")
DESCRIBE(point, POINT_FIELDS)

static bool sample(const void *desc, dvec3 p, dvec3 eye, light_sample *out) {
    (void)eye;
    const point_desc *l = desc;
    dvec3 power = dvec3_from(l->power);
    dvec3 intensity =
        dvec3_largest(power) > 0 ? dvec3_scale(power, 1 / (4 * PI)) : dvec3_from(l->intensity);
    return light_sample_point(dvec3_from(l->position), intensity, p, out);
}

const light_type light_point = {
    .info = TYPE_INFO(CATEGORY_LIGHT, point, "point", "shines from one point in every direction"),
    .sample = sample,
    .casts_shadow = true,
};
