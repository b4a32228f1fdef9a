/* A dim light at the camera, against black shadows (Cornell CS4620, "Multiple lights"). It casts no
 * shadow: what the camera sees, it sees. */
#include "lights/light.h"

#include "maths/functions.h"

#define HEADLIGHT_FIELDS(F, T)                                                                     \
    F(T, intensity, COLOR, DEFAULT(1, 1, 1), NOT_NEGATIVE, "W/sr",                                 \
      "power per solid angle, in every direction")
DESCRIBE(headlight, HEADLIGHT_FIELDS)

static bool sample(const light *l, dvec3 p, dvec3 eye, sample2 u, light_sample *out) {
    (void)u;
    const headlight_desc *desc = l->desc;
    return light_sample_point(eye, dvec3_from(desc->intensity), p, out);
}

static dvec3 power(const light *l, double scene_radius) {
    (void)scene_radius;
    return dvec3_scale(dvec3_from(((const headlight_desc *)l->desc)->intensity), 4 * PI);
}

const light_type light_headlight = {
    .info =
        TYPE_INFO(CATEGORY_LIGHT, headlight, "headlight", "a light at the camera, without shadows"),
    .sample = sample,
    .power = power,
    .casts_shadow = false,
};
