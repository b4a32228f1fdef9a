/* A cone between two points, with a radius at each: a frustum, or whole with one of them 0. Texture
 * coordinates are those of a cylinder. */
#include "base/error.h"
#include "geometry/revolved.h"

#define CONE_FIELDS(F, T)                                                                          \
    F(T, from, VEC3, NO_DEFAULT, REQUIRED, "m", "the middle of the base")                          \
    F(T, to, VEC3, NO_DEFAULT, REQUIRED, "m", "the tip, or the middle of the other end")           \
    F(T, radius, FLOAT, DEFAULT(1), NOT_NEGATIVE, "m", "the radius at 'from'")                     \
    F(T, radius_to, FLOAT, DEFAULT(0), NOT_NEGATIVE, "m", "the radius at 'to', 0 for a tip")       \
    F(T, capped, BOOL, DEFAULT(1), ANY, "", "closed by a disk at both ends")
DESCRIBE(cone, CONE_FIELDS)

static snell_status check(const void *desc) {
    const cone_desc *cone = desc;
    vec3 a = cone->from, b = cone->to;
    if (!(cone->radius > 0 || cone->radius_to > 0))
        return error_set(SNELL_ERR_ARGUMENT, "one of them is greater than 0",
                         "cone: 'radius' and 'radius_to' are both 0");
    if (a.x != b.x || a.y != b.y || a.z != b.z) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "give two different points, or a 'disk'",
                     "cone: 'from' and 'to' are the same point");
}

static revolved revolved_of(const void *desc) {
    const cone_desc *cone = desc;
    return revolved_frustum(cone->from, cone->to, cone->radius, cone->radius_to, cone->capped);
}

REVOLVED_FUNCTIONS(revolved_of)

extern const primitive_type primitive_cone;
const primitive_type primitive_cone = {
    .info = TYPE_INFO(CATEGORY_SHAPE, cone, "cone", "a cone, whole or cut off"),
    .check = check,
    REVOLVED_MEMBERS,
};
