#include "textures/texture.h"

#include "maths/functions.h"

#define TEXTURE(name) extern const texture_type texture_##name;
#include "textures/textures.def"
#undef TEXTURE
const texture_type *const texture_types[] = {
#define TEXTURE(name) &texture_##name,
#include "textures/textures.def"
#undef TEXTURE
};
const uint32_t texture_type_count = sizeof texture_types / sizeof texture_types[0];

texture texture_make(const texture_type *type, const void *desc) {
    const field *map = type_find_field(&type->info, "map");
    texture t = {.type = type, .desc = desc, .map = MAP_AUTO};
    if (map) t.map = *(const int32_t *)(const void *)((const char *)desc + map->offset);
    return t;
}

snell_status texture_prepare(texture *t) {
    return t->type->prepare ? t->type->prepare(t->desc, &t->state) : SNELL_OK;
}

void texture_destroy(texture *t) {
    if (t->state) t->type->destroy(t->state);
    t->state = NULL;
}

bool texture_filters(const texture *t) {
    return t->type->filters != NULL && t->type->filters(t->desc);
}

texel texture_look_up(snell_texture_id id, const texture *textures, const texture_point *point) {
    const texture *t = &textures[id.index1 - 1];
    return t->type->evaluate(t, point);
}

dvec3 input_color(const snell_input *input, const texture *textures, const texture_point *point) {
    dvec3 value = dvec3_from(input->value);
    if (input->texture.index1 == 0) return value;
    return dvec3_mul(value, texture_look_up(input->texture, textures, point).color);
}

double input_scalar(const snell_input *input, const texture *textures, const texture_point *point) {
    double value = (double)input->value.x;
    if (input->texture.index1 == 0) return value;
    return value * texture_look_up(input->texture, textures, point).color.x;
}

/* ---- maps ---- */

static int resolve(int map, const texture_point *point) {
    if (map == MAP_UV2) return point->has_uv2 ? MAP_UV2 : MAP_UV;
    if (map != MAP_AUTO) return map;
    return point->has_uv ? MAP_UV : MAP_OBJECT;
}

/* Coordinates are floats, because that is what meshes store. volatile: gcc 12 drops the two
 * conversions when it makes vectors of such pairs (its -ftree-slp-vectorize), which is another
 * picture. */
static double rounded(double x) {
    volatile float f = (float)x;
    return (double)f;
}

static map_point place(double u, double v, const texture_point *p, dvec3 along_u, dvec3 along_v) {
    return (map_point){rounded(u),
                       rounded(v),
                       dvec3_dot(along_u, p->dpdx),
                       dvec3_dot(along_v, p->dpdx),
                       dvec3_dot(along_u, p->dpdy),
                       dvec3_dot(along_v, p->dpdy)};
}

/* As on a sphere (geometry/sphere.c): u = 1/2 + atan2(x, z) / 2 pi, v = 1 - acos(y / r) / pi. The
 * gradients are those of the formulas; at a pole u turns at once, which its footprint says. */
static map_point map_spherical(const texture_point *point) {
    dvec3 p = point->local;
    double ring2 = p.x * p.x + p.z * p.z, square = ring2 + p.y * p.y, r = sqrt(square);
    double height = r > 0 ? p.y / r : 0;
    height = height < -1 ? -1 : height > 1 ? 1 : height;
    dvec3 du = {0, 0, 0}, dv = {0, 0, 0};
    if (ring2 > 0) {
        double ring = sqrt(ring2), slope = 1 / (PI * square * ring);
        du = (dvec3){p.z / (2 * PI * ring2), 0, -p.x / (2 * PI * ring2)};
        dv = (dvec3){-p.y * p.x * slope, ring2 * slope, -p.y * p.z * slope};
    }
    return place(0.5 + fn_atan2(p.x, p.z) / (2 * PI), 1 - fn_acos(height) / PI, point, du, dv);
}

static map_point map_second(const texture_point *point) {
    map_point at = {.u = rounded(point->u2), .v = rounded(point->v2)};
    texture_uv_change(point->dpdu2, point->dpdv2, point->dpdx, &at.dudx, &at.dvdx);
    texture_uv_change(point->dpdu2, point->dpdv2, point->dpdy, &at.dudy, &at.dvdy);
    return at;
}

static const dvec3 x_axis = {1, 0, 0}, y_axis = {0, 1, 0}, z_axis = {0, 0, 1};

map_point texture_map(int map, const texture_point *point) {
    dvec3 p = point->local;
    switch (resolve(map, point)) {
    case MAP_UV:
        return (map_point){rounded(point->u), rounded(point->v), point->dudx,
                           point->dvdx,       point->dudy,       point->dvdy};
    case MAP_UV2: return map_second(point);
    case MAP_XZ: return place(p.x, p.z, point, x_axis, z_axis);
    case MAP_SPHERICAL: return map_spherical(point);
    default: return place(p.x, p.y, point, x_axis, y_axis);
    }
}

/* The axes of a face of a box seen from outside, as in geometry/box.c: u to the right, v up. */
static void face_axes(int axis, bool upper, dvec3 *along_u, dvec3 *along_v) {
    double sign = upper ? 1 : -1;
    *along_u = axis == 0   ? dvec3_scale(z_axis, -sign)
               : axis == 1 ? x_axis
                           : dvec3_scale(x_axis, sign);
    *along_v = axis == 1 ? dvec3_scale(z_axis, -sign) : y_axis;
}

static double fourth(double x) { return x * x * (x * x); }

static texel triplanar(const texture *t, const texture_point *point,
                       texel (*flat)(const texture *t, const map_point *at)) {
    const double n[3] = {point->n.x, point->n.y, point->n.z};
    double sum = fourth(n[0]) + fourth(n[1]) + fourth(n[2]);
    texel out = {{0, 0, 0}, 0};
    for (int axis = 0; axis < 3; axis++) {
        double weight = sum > 0 ? fourth(n[axis]) / sum : axis == 2;
        if (!(weight > 0)) continue;
        dvec3 u, v;
        face_axes(axis, n[axis] > 0, &u, &v);
        map_point at = place(dvec3_dot(u, point->local), dvec3_dot(v, point->local), point, u, v);
        texel seen = flat(t, &at);
        out.color = dvec3_add(out.color, dvec3_scale(seen.color, weight));
        out.alpha += weight * seen.alpha;
    }
    return out;
}

texel texture_through_map(const texture *t, const texture_point *point,
                          texel (*flat)(const texture *t, const map_point *at)) {
    if (t->map == MAP_TRIPLANAR) return triplanar(t, point, flat);
    map_point at = texture_map(t->map, point);
    return flat(t, &at);
}

static double length2(double x, double y) { return sqrt(x * x + y * y); }

dvec3 texture_solid(int map, const texture_point *point, double *width) {
    int which = resolve(map, point);
    if (which == MAP_OBJECT || which == MAP_TRIPLANAR || which == MAP_XZ) {
        dvec3 p = point->local, dx = point->dpdx, dy = point->dpdy;
        if (which == MAP_XZ) p.y = dx.y = dy.y = 0;
        *width = double_max(dvec3_length(dx), dvec3_length(dy));
        return p;
    }
    map_point at = texture_map(which, point);
    *width = double_max(length2(at.dudx, at.dvdx), length2(at.dudy, at.dvdy));
    return (dvec3){at.u, at.v, 0};
}

void texture_axes(int map, const texture_point *point, dvec3 *along_u, dvec3 *along_v) {
    dvec3 p = point->local, n = point->n, size = {fabs(n.x), fabs(n.y), fabs(n.z)};
    *along_u = x_axis;
    *along_v = y_axis;
    switch (resolve(map, point)) {
    case MAP_UV:
        *along_u = point->dpdu;
        *along_v = point->dpdv;
        break;
    case MAP_UV2:
        *along_u = point->dpdu2;
        *along_v = point->dpdv2;
        break;
    case MAP_XZ: *along_v = z_axis; break;
    case MAP_SPHERICAL: /* east and north */
        *along_u = (dvec3){p.z, 0, -p.x};
        *along_v = dvec3_cross(p, *along_u);
        break;
    case MAP_TRIPLANAR: /* of the strongest projection */
        if (size.x >= size.y && size.x >= size.z)
            face_axes(0, n.x > 0, along_u, along_v);
        else if (size.y >= size.z)
            face_axes(1, n.y > 0, along_u, along_v);
        else
            face_axes(2, n.z > 0, along_u, along_v);
        break;
    default: break;
    }
}

void texture_uv_change(dvec3 dpdu, dvec3 dpdv, dvec3 dp, double *du, double *dv) {
    double a = dvec3_dot(dpdu, dpdu), b = dvec3_dot(dpdu, dpdv), c = dvec3_dot(dpdv, dpdv);
    double area = a * c - b * b, x = dvec3_dot(dpdu, dp), y = dvec3_dot(dpdv, dp);
    *du = *dv = 0;
    if (!(area > 0x1p-40 * a * c)) return;
    *du = (c * x - b * y) / area;
    *dv = (a * y - b * x) / area;
}
