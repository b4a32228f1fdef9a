#include "geometry/by_lines.h"

#include "sampling/sampling.h"

/* The box as arrays: all lines start below it and end above it. */
typedef struct frame {
    double low[3], size[3];
} frame;

static frame frame_of(const primitive_type *type, const void *desc) {
    bounds3 box = type->bounds(desc);
    double x = box.min.x, y = box.min.y, z = box.min.z;
    return (frame){{x, y, z},
                   {(double)box.max.x - x, (double)box.max.y - y, (double)box.max.z - z}};
}

/* The line along the axis through the place (a, b), both 0..1, of the box's face across it. */
static local_ray line_at(const frame *f, int axis, double a, double b) {
    int one = (axis + 1) % 3, other = (axis + 2) % 3;
    float o[3] = {0}, d[3] = {0};
    o[one] = (float)(f->low[one] + a * f->size[one]);
    o[other] = (float)(f->low[other] + b * f->size[other]);
    o[axis] = (float)(f->low[axis] - f->size[axis]);
    d[axis] = 1;
    return (local_ray){{o[0], o[1], o[2]}, {d[0], d[1], d[2]}, 0, INFINITY};
}

static double along_axis(dvec3 n, int axis) {
    const double parts[3] = {n.x, n.y, n.z};
    return fabs(parts[axis]);
}

double by_lines_area(const primitive_type *type, const void *desc, int per_side) {
    frame f = frame_of(type, desc);
    double total = 0;
    for (int axis = 0; axis < 3; axis++) {
        double sum = 0, face = f.size[(axis + 1) % 3] * f.size[(axis + 2) % 3];
        for (int i = 0; i < per_side; i++)
            for (int k = 0; k < per_side; k++) {
                local_ray line = line_at(&f, axis, (i + 0.5) / per_side, (k + 0.5) / per_side);
                hit found = {0};
                for (; type->intersect(desc, &line, &found); line.t_min = found.t) {
                    surface s;
                    type->surface(desc, &line, &found, &s);
                    sum += along_axis(s.n, axis);
                }
            }
        total += sum * face / ((double)per_side * per_side);
    }
    return total;
}

/* The crossing of that number, from 0, of a line. */
static bool crossing_at(const primitive_type *type, const void *desc, local_ray line, int number,
                        surface *out) {
    hit found = {0};
    for (int i = 0; type->intersect(desc, &line, &found); i++) {
        if (i == number) {
            type->surface(desc, &line, &found, out);
            return true;
        }
        line.t_min = found.t;
    }
    return false;
}

#define TRIES_MAX 4096

/* An axis by the size of the face across it, a place on that face, and the number of a crossing, each
 * as likely as any other, so that it may not exist; accepted with the chance |n_i|. */
void by_lines_sample(const primitive_type *type, const void *desc, int crossings, double u,
                     double v, surface *out) {
    frame f = frame_of(type, desc);
    const double faces[3] = {f.size[1] * f.size[2], f.size[2] * f.size[0], f.size[0] * f.size[1]};
    double a = u, b = v;
    *out = surface_make((dvec3){f.low[0], f.low[1], f.low[2]}, (dvec3){0, 1, 0}, 0);
    for (uint32_t i = 0; i < 3 * TRIES_MAX; i += 3) {
        double left = a * (faces[0] + faces[1] + faces[2]);
        int axis = 0;
        while (axis < 2 && left >= faces[axis]) left -= faces[axis++];
        int number = (int)(b * crossings);
        local_ray line = line_at(&f, axis, clamp01(left / faces[axis]), b * crossings - number);
        if (crossing_at(type, desc, line, number, out) &&
            sample_more(u, v, i) < along_axis(out->n, axis))
            return;
        a = sample_more(u, v, i + 1);
        b = sample_more(u, v, i + 2);
    }
    /* So little of its box does it fill: what was met last, if anything was. */
}
