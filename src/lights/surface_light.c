#include "lights/surface_light.h"

#include <float.h>

#include "base/error.h"
#include "base/memory.h"
#include "maths/functions.h"

dvec3 surface_light_radiance(vec3 radiance, vec3 power, double area) {
    dvec3 p = dvec3_from(power);
    return dvec3_largest(p) > 0 ? dvec3_scale(p, 1 / (PI * area)) : dvec3_from(radiance);
}

dvec3 surface_light_power(vec3 radiance, vec3 power, double area) {
    return dvec3_scale(surface_light_radiance(radiance, power, area), PI * area);
}

snell_status surface_light_check(const char *name, vec3 power, double area) {
    if (dvec3_largest(surface_light_radiance((vec3){0, 0, 0}, power, area)) <= (double)FLT_MAX)
        return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "a larger light, or less power",
                     "light.%s: 'power' is too much for so small an area", name);
}

snell_status surface_light_shape(const char *type, const snell_param *params, size_t count,
                                 light_shape *out) {
    out->type = primitive_find(type);
    const type_info *info = &out->type->info;
    void *desc = memory_zeroed(1, info->desc_size);
    if (desc == NULL) return error_no_memory();
    desc_init(info, desc);
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < count && !status; i++) status = desc_set(info, desc, &params[i]);
    if (!status) status = desc_check(info, desc, NULL);
    if (!status && out->type->check) status = out->type->check(desc);
    out->desc = desc;
    if (status) desc_free(info, desc);
    return status;
}
