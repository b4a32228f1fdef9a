#include "lights/light.h"

#define LIGHT(name) extern const light_type light_##name;
#include "lights/lights.def"
#undef LIGHT
const light_type *const light_types[] = {
#define LIGHT(name) &light_##name,
#include "lights/lights.def"
#undef LIGHT
};
const uint32_t light_type_count = sizeof light_types / sizeof light_types[0];

bool light_sample_point(dvec3 position, dvec3 intensity, dvec3 p, light_sample *out) {
    dvec3 to_light = dvec3_sub(position, p);
    double squared = dvec3_dot(to_light, to_light);
    if (!(squared > 0)) return false;
    *out = (light_sample){
        .to_light = to_light, .to_end = to_light, .light = dvec3_scale(intensity, 1 / squared)};
    return true;
}
