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
