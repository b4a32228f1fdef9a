/* Union, intersection and difference of closed shapes (constructive solid geometry). */
#include "geometry/solid.h"

#include "base/error.h"

DESCRIBE_TABLE(solid, SOLID_FIELDS)

static snell_status check_count(const char *name, size_t count, size_t shapes) {
    if (count == 0 || count == shapes) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "give one per shape, or none",
                     "solid: '%s' has %zu entries for %zu shapes", name, count, shapes);
}

static snell_status check(const void *desc) {
    const solid_desc *solid = desc;
    if (solid->shapes_count == 0)
        return error_set(SNELL_ERR_ARGUMENT, "give it closed shapes", "solid: it has no shapes");
    snell_status status = check_count("transforms", solid->transforms_count, solid->shapes_count);
    if (!status) status = check_count("materials", solid->materials_count, solid->shapes_count);
    transform inverse;
    for (size_t i = 0; !status && i < solid->transforms_count; i++)
        if (!transform_inverse(&solid->transforms[i], &inverse))
            status = error_set(SNELL_ERR_ARGUMENT, "a scale of 0 squashes the shape flat",
                               "solid: the transform of shape %zu cannot be inverted", i + 1);
    return status;
}

const primitive_type primitive_solid = {
    .info = TYPE_INFO(CATEGORY_SHAPE, solid, "solid", "closed shapes put together"),
    .check = check,
};
