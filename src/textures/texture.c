#include "textures/texture.h"

#define TEXTURE(name) extern const texture_type texture_##name;
#include "textures/textures.def"
#undef TEXTURE
const texture_type *const texture_types[] = {
#define TEXTURE(name) &texture_##name,
#include "textures/textures.def"
#undef TEXTURE
};
const uint32_t texture_type_count = sizeof texture_types / sizeof texture_types[0];

static texel look_up(const snell_input *input, const texture *textures,
                     const texture_point *point) {
    const texture *t = &textures[input->texture.index1 - 1];
    return t->type->evaluate(t->desc, point);
}

dvec3 input_color(const snell_input *input, const texture *textures, const texture_point *point) {
    dvec3 value = dvec3_from(input->value);
    return input->texture.index1 ? dvec3_mul(value, look_up(input, textures, point).color) : value;
}

double input_scalar(const snell_input *input, const texture *textures, const texture_point *point) {
    double value = (double)input->value.x;
    return input->texture.index1 ? value * look_up(input, textures, point).color.x : value;
}

vec2 texture_map(int map, const texture_point *point) {
    if (map == MAP_UV || (map == MAP_AUTO && point->has_uv))
        return (vec2){(float)point->u, (float)point->v};
    if (map == MAP_XZ) return (vec2){(float)point->local.x, (float)point->local.z};
    return (vec2){(float)point->local.x, (float)point->local.y};
}
