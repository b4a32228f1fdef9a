/* A line of points turned about +Y through the origin. Its normals point away from the enclosed side
 * whichever way the line runs. It is a solid if both ends lie on the axis, or if it ends where it
 * begins. Texture coordinates: u around as on a sphere, v by length along the line, 0 to 1. A point
 * given twice is a crease. */
#include "base/error.h"
#include "geometry/revolved.h"

#define LATHE_FIELDS(F, T)                                                                         \
    F(T, profile, VEC2S, NO_DEFAULT, REQUIRED, "m",                                                \
      "points {radius, height}, at least two, joined by straight lines")                           \
    F(T, smooth, BOOL, DEFAULT(1), ANY, "", "shade joints of less than 40 degrees as one curve")
DESCRIBE(lathe, LATHE_FIELDS)

#define POINTS_MAX 4096

static revolved revolved_of(const void *desc) {
    const lathe_desc *lathe = desc;
    vec2 first = lathe->profile[0], last = lathe->profile[lathe->profile_count - 1];
    double middle = ((double)first.y + (double)last.y) / 2;
    return (revolved){.origin = {0, middle, 0},
                      .base = middle,
                      .x = {1, 0, 0},
                      .y = {0, 1, 0},
                      .z = {0, 0, 1},
                      .profile = lathe->profile,
                      .count = lathe->profile_count,
                      .closed =
                          (first.x == 0 && last.x == 0) || (first.x == last.x && first.y == last.y),
                      .smooth = lathe->smooth};
}

static snell_status check(const void *desc) {
    const lathe_desc *lathe = desc;
    size_t count = lathe->profile_count;
    if (count < 2 || count > POINTS_MAX)
        return error_set(SNELL_ERR_ARGUMENT, "write profile = {{1, 0}, {0.5, 1}, ...}",
                         "lathe: 'profile' has %zu points; it must have 2 to %d", count,
                         POINTS_MAX);
    for (size_t i = 0; i < count; i++)
        if (lathe->profile[i].x < 0)
            return error_set(SNELL_ERR_ARGUMENT, "points are {radius, height}",
                             "lathe: the radius of point %zu of 'profile' is %g; it must be at "
                             "least 0",
                             i + 1, (double)lathe->profile[i].x);
    revolved shape = revolved_of(desc);
    if (revolved_area(&shape) > 0) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "points are {radius, height}; give some a radius",
                     "lathe: 'profile' sweeps no surface");
}

REVOLVED_FUNCTIONS(revolved_of)

extern const primitive_type primitive_lathe;
const primitive_type primitive_lathe = {
    .info = TYPE_INFO(CATEGORY_SHAPE, lathe, "lathe",
                      "a line turned about the Y axis: vases, glasses, chess pieces"),
    .check = check,
    REVOLVED_MEMBERS,
};
