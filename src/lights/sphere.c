/* A sphere that shines outwards. */
#include "lights/surface_light.h"
#include "maths/functions.h"

#define SPHERE_LIGHT_FIELDS(F, T)                                                                  \
    F(T, center, VEC3, DEFAULT(0, 0, 0), REQUIRED, "m", "the centre")                              \
    F(T, radius, FLOAT, DEFAULT(0.5f), POSITIVE, "m", "the radius")                                \
    SURFACE_LIGHT_FIELDS(F, T)
DESCRIBE(sphere_light, SPHERE_LIGHT_FIELDS)

static double area(const sphere_light_desc *l) {
    return 4 * PI * (double)l->radius * (double)l->radius;
}

static snell_status check(const void *desc) {
    const sphere_light_desc *l = desc;
    return surface_light_check("sphere", l->power, area(l));
}

static snell_status shape(const void *desc, light_shape *out) {
    const sphere_light_desc *l = desc;
    const snell_param params[] = {vec3_param("center", l->center),
                                  float_param("radius", l->radius)};
    out->radiance = surface_light_radiance(l->radiance, l->power, area(l));
    out->visible = l->visible;
    return surface_light_shape("sphere", params, 2, out);
}

static dvec3 power(const light *l, double scene_radius) {
    (void)scene_radius;
    const sphere_light_desc *desc = l->desc;
    return surface_light_power(desc->radiance, desc->power, area(desc));
}

const light_type light_sphere = {
    .info = TYPE_INFO_EITHER(CATEGORY_LIGHT, sphere_light, "sphere", "a sphere that shines",
                             "radiance|power"),
    .check = check,
    .shape = shape,
    .power = power,
    .casts_shadow = true,
};
