#include "sampling/warp.h"

#include <math.h>

#include "maths/functions.h"

warp_polar warp_disk(double u, double v) {
    double a = 2 * u - 1, b = 2 * v - 1;
    if (a == 0 && b == 0) return (warp_polar){0, 1, 0};
    if (fabs(a) > fabs(b)) {
        double angle = PI / 4 * (b / a), sign = a < 0 ? -1 : 1;
        return (warp_polar){fabs(a), sign * fn_cos(angle), sign * fn_sin(angle)};
    }
    double angle = PI / 4 * (a / b), sign = b < 0 ? -1 : 1;
    return (warp_polar){fabs(b), sign * fn_sin(angle), sign * fn_cos(angle)};
}

void warp_triangle(double u, double v, double weight[3]) {
    double root = sqrt(u);
    weight[0] = 1 - root;
    weight[1] = root * (1 - v);
    weight[2] = root * v;
}

dvec3 warp_cosine_hemisphere(sample2 u) {
    warp_polar disk = warp_disk(u.x, u.y);
    return (dvec3){disk.radius * disk.cosine, disk.radius * disk.sine,
                   sqrt(double_max(0, 1 - disk.radius * disk.radius))};
}

dvec3 warp_uniform_cone(sample2 u, double height) {
    warp_polar disk = warp_disk(u.x, u.y);
    double below = disk.radius * disk.radius * height; /* 1 - cos */
    double sine = sqrt(double_max(0, below * (2 - below)));
    return (dvec3){sine * disk.cosine, sine * disk.sine, 1 - below};
}
