/* A dim light at the camera, against black shadows (Cornell CS4620, "Multiple lights"). It casts no
 * shadow: what the camera sees, it sees. */
#include "lights/light.h"

#define HEADLIGHT_FIELDS(F, T)                                                                     \
    F(T, intensity, COLOR, DEFAULT(1, 1, 1), NOT_NEGATIVE, "W/sr",                                 \
      "power per solid angle, in every direction")
DESCRIBE(headlight, HEADLIGHT_FIELDS)

static bool sample(const void *desc, dvec3 p, dvec3 eye, light_sample *out) {
    const headlight_desc *l = desc;
    return light_sample_point(eye, dvec3_from(l->intensity), p, out);
}

const light_type light_headlight = {
    .info =
        TYPE_INFO(CATEGORY_LIGHT, headlight, "headlight", "a light at the camera, without shadows"),
    .sample = sample,
    .casts_shadow = false,
};
