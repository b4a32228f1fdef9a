/* A closed box along the axes. A ray from outside meets the face where it enters, one from inside
 * the face where it leaves. Texture coordinates are 0..1 on every face, seen from outside: u to the
 * right, v up; on the top v points to -Z, on the bottom to +Z. hit.u carries the face: twice the
 * axis, plus one for the side of max. */
#include "geometry/surface.h"

#define BOX_FIELDS(F, T)                                                                           \
    F(T, min, VEC3, NO_DEFAULT, REQUIRED, "m", "the corner with the smallest coordinates")         \
    F(T, max, VEC3, NO_DEFAULT, REQUIRED, "m", "the corner with the largest coordinates")
DESCRIBE(box, BOX_FIELDS)

static snell_status check(const void *desc) {
    const box_desc *box = desc;
    return surface_check_box("box", box->min, box->max);
}

static bounds3 bounds(const void *desc) {
    const box_desc *box = desc;
    return (bounds3){box->min, box->max};
}

typedef struct crossing {
    double t;
    int face;
} crossing;

/* Where the ray enters and leaves the box, by the slabs of the three axes. */
static bool solve(const box_desc *box, const local_ray *beam, crossing *in, crossing *out) {
    const double low[3] = {box->min.x, box->min.y, box->min.z};
    const double high[3] = {box->max.x, box->max.y, box->max.z};
    const double o[3] = {beam->o.x, beam->o.y, beam->o.z}, d[3] = {beam->d.x, beam->d.y, beam->d.z};
    *in = (crossing){-INFINITY, -1};
    *out = (crossing){INFINITY, -1};
    for (int axis = 0; axis < 3; axis++) {
        if (d[axis] == 0) {
            if (!(o[axis] >= low[axis] && o[axis] <= high[axis])) return false;
            continue;
        }
        bool forward = d[axis] > 0;
        double near = ((forward ? low[axis] : high[axis]) - o[axis]) / d[axis];
        double far = ((forward ? high[axis] : low[axis]) - o[axis]) / d[axis];
        if (near > in->t) *in = (crossing){near, 2 * axis + !forward};
        if (far < out->t) *out = (crossing){far, 2 * axis + forward};
    }
    return in->face >= 0 && in->t <= out->t;
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    crossing in, out;
    if (!solve(desc, beam, &in, &out)) return false;
    found->u = (float)in.face;
    found->v = 0;
    if (surface_accept(beam, in.t, &found->t)) return true;
    found->u = (float)out.face;
    return surface_accept(beam, out.t, &found->t);
}

/* The point of a face that is nearest to `near`. */
static surface surface_at(const box_desc *box, int face, const double near[3]) {
    const double low[3] = {box->min.x, box->min.y, box->min.z};
    const double high[3] = {box->max.x, box->max.y, box->max.z};
    int axis = face / 2;
    bool upper = face & 1;
    double p[3], n[3] = {0}, part[3];
    for (int i = 0; i < 3; i++) {
        p[i] = double_min(double_max(near[i], low[i]), high[i]);
        part[i] = clamp01((p[i] - low[i]) / (high[i] - low[i]));
    }
    p[axis] = upper ? high[axis] : low[axis];
    n[axis] = upper ? 1 : -1;
    /* The planes lie on floats and the sign of plane - o is exact: no error at all. */
    surface made = surface_make((dvec3){p[0], p[1], p[2]}, (dvec3){n[0], n[1], n[2]}, 0);
    double x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    switch (axis) {
    case 0:
        made.u = upper ? 1 - part[2] : part[2];
        made.v = part[1];
        made.dpdu = (dvec3){0, 0, upper ? -z : z};
        made.dpdv = (dvec3){0, y, 0};
        break;
    case 1:
        made.u = part[0];
        made.v = upper ? 1 - part[2] : part[2];
        made.dpdu = (dvec3){x, 0, 0};
        made.dpdv = (dvec3){0, 0, upper ? -z : z};
        break;
    default:
        made.u = upper ? part[0] : 1 - part[0];
        made.v = part[1];
        made.dpdu = (dvec3){upper ? x : -x, 0, 0};
        made.dpdv = (dvec3){0, y, 0};
        break;
    }
    return made;
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    const box_desc *box = desc;
    const double low[3] = {box->min.x, box->min.y, box->min.z};
    const double high[3] = {box->max.x, box->max.y, box->max.z};
    const double o[3] = {beam->o.x, beam->o.y, beam->o.z}, d[3] = {beam->d.x, beam->d.y, beam->d.z};
    int face = found->u >= 0 && found->u < 6 ? (int)found->u : 0, axis = face / 2;
    double plane = face & 1 ? high[axis] : low[axis];
    double t = d[axis] != 0 ? (plane - o[axis]) / d[axis] : found->t;
    double p[3];
    for (int i = 0; i < 3; i++) p[i] = o[i] + t * d[i];
    *out = surface_at(box, face, p);
}

static int side(const void *desc, dvec3 p) {
    const box_desc *box = desc;
    dvec3 low = dvec3_from(box->min), high = dvec3_from(box->max);
    bool inside =
        p.x > low.x && p.x < high.x && p.y > low.y && p.y < high.y && p.z > low.z && p.z < high.z;
    return inside ? 1 : -1;
}

static int spans(const void *desc, const local_ray *beam, span *out, int capacity) {
    crossing enter, leave;
    if (!solve(desc, beam, &enter, &leave)) return 0;
    return surface_add_span(out, 0, capacity,
                            (surface_crossing){.t = enter.t, .u = (float)enter.face},
                            (surface_crossing){.t = leave.t, .u = (float)leave.face});
}

/* Of the two faces across each axis. */
static void pair_areas(const box_desc *box, double pair[3]) {
    double x = (double)box->max.x - box->min.x, y = (double)box->max.y - box->min.y,
           z = (double)box->max.z - box->min.z;
    pair[0] = 2 * y * z;
    pair[1] = 2 * z * x;
    pair[2] = 2 * x * y;
}

static double area(const void *desc, uint32_t primitive) {
    (void)primitive;
    double pair[3];
    pair_areas(desc, pair);
    return pair[0] + pair[1] + pair[2];
}

/* u chooses the face, and its place within the face's share of [0,1) is a coordinate on it. */
static void sample_area(const void *desc, uint32_t primitive, double u, double v, surface *out) {
    const box_desc *box = desc;
    double pair[3], left = u * area(desc, primitive);
    pair_areas(box, pair);
    int axis = 0;
    while (axis < 2 && left >= pair[axis]) left -= pair[axis++];
    double place = 2 * left / pair[axis];
    bool upper = place >= 1;
    place = clamp01(upper ? place - 1 : place);
    const double low[3] = {box->min.x, box->min.y, box->min.z};
    const double high[3] = {box->max.x, box->max.y, box->max.z};
    int one = (axis + 1) % 3, other = (axis + 2) % 3;
    double p[3] = {0};
    p[one] = low[one] + place * (high[one] - low[one]);
    p[other] = low[other] + v * (high[other] - low[other]);
    *out = surface_at(box, 2 * axis + upper, p);
}

extern const primitive_type primitive_box;
const primitive_type primitive_box = {
    .info = TYPE_INFO(CATEGORY_SHAPE, box, "box", "a box along the axes"),
    .check = check,
    .bounds = bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .side = side,
    .spans = spans,
    .area = area,
    .sample_area = sample_area,
};
