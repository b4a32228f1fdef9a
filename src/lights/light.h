/* Lights that no ray can hit. One file per light; one line in lights.def. */
#ifndef SNELL_LIGHTS_LIGHT_H
#define SNELL_LIGHTS_LIGHT_H

#include "base/field.h"
#include "maths/vec.h"

/* Light that would arrive at a point if nothing were in the way. */
typedef struct light_sample {
    dvec3 to_light;   /* from the point to the light, its length the distance; a unit vector for
                         directional light */
    bool directional; /* infinitely far */
    dvec3 irradiance; /* at the point, on a surface facing the light, W/m^2 */
} light_sample;

typedef struct light_type {
    type_info info;
    snell_status (*check)(const void *desc);
    /* false: no light arrives. eye: the camera's position. */
    bool (*sample)(const void *desc, dvec3 p, dvec3 eye, light_sample *out);
    bool casts_shadow; /* false: the headlight, which sees what the camera sees */
} light_type;

extern const light_type *const light_types[];
extern const uint32_t light_type_count;

typedef struct light {
    const light_type *type;
    const void *desc;
} light;

/* Point lights: I / r^2 (Cornell CS4620, "Irradiance from isotropic point source"). */
bool light_sample_point(dvec3 position, dvec3 intensity, dvec3 p, light_sample *out);

#endif
