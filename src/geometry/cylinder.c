/* A cylinder between two points. Texture coordinates of the wall: u around as on a sphere, seen from
 * outside with `to` above, v from 0 at `from` to 1 at `to`; of the caps: u the same, v from 0 in the
 * middle to 1 at the rim. For the axis +Y, u = 0.5 faces +Z. */
#include "base/error.h"
#include "geometry/revolved.h"

#define CYLINDER_FIELDS(F, T)                                                                      \
    F(T, from, VEC3, NO_DEFAULT, REQUIRED, "m", "the middle of one end")                           \
    F(T, to, VEC3, NO_DEFAULT, REQUIRED, "m", "the middle of the other end")                       \
    F(T, radius, FLOAT, DEFAULT(1), POSITIVE, "m", "the radius")                                   \
    F(T, capped, BOOL, DEFAULT(1), ANY, "", "closed by a disk at both ends")
DESCRIBE(cylinder, CYLINDER_FIELDS)

static snell_status check(const void *desc) {
    const cylinder_desc *cylinder = desc;
    vec3 a = cylinder->from, b = cylinder->to;
    if (a.x != b.x || a.y != b.y || a.z != b.z) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "give two different points, or a 'disk'",
                     "cylinder: 'from' and 'to' are the same point");
}

static revolved revolved_of(const void *desc) {
    const cylinder_desc *cylinder = desc;
    double r = cylinder->radius;
    return revolved_frustum(cylinder->from, cylinder->to, r, r, cylinder->capped);
}

REVOLVED_FUNCTIONS(revolved_of)

extern const primitive_type primitive_cylinder;
const primitive_type primitive_cylinder = {
    .info = TYPE_INFO(CATEGORY_SHAPE, cylinder, "cylinder", "a cylinder, closed or a tube"),
    .check = check,
    REVOLVED_MEMBERS,
};
