/* A disk that shines to the side that its normal points to. */
#include "lights/surface_light.h"
#include "maths/functions.h"

#define DISK_LIGHT_FIELDS(F, T)                                                                    \
    F(T, center, VEC3, DEFAULT(0, 0, 0), REQUIRED, "m", "the centre")                              \
    F(T, normal, VEC3, DEFAULT(0, -1, 0), REQUIRED_DIRECTION, "", "the direction that it faces")   \
    F(T, radius, FLOAT, DEFAULT(0.5f), POSITIVE, "m", "the radius")                                \
    SURFACE_LIGHT_FIELDS(F, T)
DESCRIBE(disk_light, DISK_LIGHT_FIELDS)

static double area(const disk_light_desc *l) { return PI * (double)l->radius * (double)l->radius; }

static snell_status check(const void *desc) {
    const disk_light_desc *l = desc;
    return surface_light_check("disk", l->power, area(l));
}

static snell_status shape(const void *desc, light_shape *out) {
    const disk_light_desc *l = desc;
    const snell_param params[] = {vec3_param("center", l->center), vec3_param("normal", l->normal),
                                  float_param("radius", l->radius)};
    out->radiance = surface_light_radiance(l->radiance, l->power, area(l));
    out->visible = l->visible;
    return surface_light_shape("disk", params, 3, out);
}

static dvec3 power(const light *l, double scene_radius) {
    (void)scene_radius;
    const disk_light_desc *desc = l->desc;
    return surface_light_power(desc->radiance, desc->power, area(desc));
}

const light_type light_disk = {
    .info = TYPE_INFO_EITHER(CATEGORY_LIGHT, disk_light, "disk", "a disk that shines to one side",
                             "radiance|power"),
    .check = check,
    .shape = shape,
    .power = power,
    .casts_shadow = true,
};
