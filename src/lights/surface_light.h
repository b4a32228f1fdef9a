/* What the lights that are surfaces share. */
#ifndef SNELL_LIGHTS_SURFACE_LIGHT_H
#define SNELL_LIGHTS_SURFACE_LIGHT_H

#include "lights/light.h"

/* Fields that every such light has, last in its table. */
#define SURFACE_LIGHT_FIELDS(F, T)                                                                 \
    F(T, radiance, COLOR, DEFAULT(1, 1, 1), NOT_NEGATIVE, "W/(m^2 sr)", "that its outside sends")  \
    F(T, power, COLOR, DEFAULT(0, 0, 0), NOT_NEGATIVE, "W",                                        \
      "instead of radiance: L = P / (pi area)")                                                    \
    F(T, visible, BOOL, DEFAULT(1), ANY, "",                                                       \
      "to camera rays; an invisible one casts no shadow either")

/* The radiance of a surface of this area, W/(m^2 sr): a Lambertian emitter of one side sends
 * P = pi L A. */
dvec3 surface_light_radiance(vec3 radiance, vec3 power, double area);

/* What it sends out, W. */
dvec3 surface_light_power(vec3 radiance, vec3 power, double area);

/* Refuses a power that so small an area would have to send with more radiance than floats hold. */
snell_status surface_light_check(const char *name, vec3 power, double area);

/* A shape of the named type with these parameters. */
snell_status surface_light_shape(const char *type, const snell_param *params, size_t count,
                                 light_shape *out);

static inline snell_param vec3_param(const char *name, vec3 value) {
    return (snell_param){.name = name, .kind = SNELL_PARAM_VEC3, .value.v = value};
}
static inline snell_param float_param(const char *name, float value) {
    return (snell_param){.name = name, .kind = SNELL_PARAM_FLOAT, .value.f = (double)value};
}

#endif
