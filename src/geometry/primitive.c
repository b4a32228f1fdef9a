#include "geometry/primitive.h"

#include <string.h>

#define SHAPE(name) extern const primitive_type primitive_##name;
#include "geometry/shapes.def"
#undef SHAPE

#define SHAPE(name) &primitive_##name,
const primitive_type *const primitive_types[] = {
#include "geometry/shapes.def"
};
#undef SHAPE
const uint32_t primitive_type_count = sizeof primitive_types / sizeof primitive_types[0];

const primitive_type *primitive_find(const char *name) {
    for (uint32_t i = 0; i < primitive_type_count; i++)
        if (strcmp(primitive_types[i]->info.name, name) == 0) return primitive_types[i];
    return NULL;
}
