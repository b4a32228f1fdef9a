/* The isotropic point source. */
#include "lights/light.h"

#include "maths/functions.h"

#define POINT_FIELDS(F, T)                                                                         \
    F(T, position, VEC3, DEFAULT(0, 0, 0), REQUIRED, "m", "where it is")                           \
    F(T, intensity, COLOR, DEFAULT(1, 1, 1), NOT_NEGATIVE, "W/sr",                                 \
      "power per solid angle, in every direction")                                                 \
    F(T, power, COLOR, DEFAULT(0, 0, 0), NOT_NEGATIVE, "W", "instead of intensity: I = P / (4 pi)")
DESCRIBE(point, POINT_FIELDS)

static dvec3 intensity_of(const point_desc *l) {
    dvec3 power = dvec3_from(l->power);
    return dvec3_largest(power) > 0 ? dvec3_scale(power, 1 / (4 * PI)) : dvec3_from(l->intensity);
}

static void point(const void *desc, dvec3 *position, dvec3 *intensity) {
    *position = dvec3_from(((const point_desc *)desc)->position);
    *intensity = intensity_of(desc);
}

static bool sample(const light *l, dvec3 p, dvec3 eye, sample2 u, light_sample *out) {
    (void)eye, (void)u;
    dvec3 position, intensity;
    point(l->desc, &position, &intensity);
    return light_sample_point(position, intensity, p, out);
}

static dvec3 power(const light *l, double scene_radius) {
    (void)scene_radius;
    return dvec3_scale(intensity_of(l->desc), 4 * PI);
}

static void place(const light *l, dvec3 *position, dvec3 *axis, double *cos_spread) {
    *position = dvec3_from(((const point_desc *)l->desc)->position);
    *axis = (dvec3){0, 1, 0};
    *cos_spread = -1;
}

const light_type light_point = {
    .info = TYPE_INFO_EITHER(CATEGORY_LIGHT, point, "point",
                             "shines from one point in every direction", "intensity|power"),
    .sample = sample,
    .point = point,
    .power = power,
    .place = place,
    .casts_shadow = true,
};
