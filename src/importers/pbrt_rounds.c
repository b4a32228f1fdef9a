/* pbrt's spheres, cylinders and disks, and parts of them. */
#include <math.h>

#include "importers/pbrt.h"
#include "maths/functions.h"

enum { ROUND_COLUMNS = 128, ROUND_ROWS = 64 };

typedef struct round_part { /* of a sphere, cylinder or disk about z */
    enum { BALL, TUBE, PLATE } kind;
    double radius, inner, z0, z1, turn; /* radians */
} round_part;

static void round_at(const void *user, double u, double v, dvec3 *position, dvec3 *normal) {
    const round_part *r = user;
    double c = fn_cos(u * r->turn), s = fn_sin(u * r->turn);
    if (r->kind == BALL) {
        double low = fn_acos(double_min(double_max(r->z0 / r->radius, -1), 1)),
               high = fn_acos(double_min(double_max(r->z1 / r->radius, -1), 1)),
               polar = low + v * (high - low), out = fn_sin(polar);
        *normal = (dvec3){c * out, s * out, fn_cos(polar)};
        *position = dvec3_scale(*normal, r->radius);
    } else if (r->kind == TUBE) {
        *normal = (dvec3){c, s, 0};
        *position = (dvec3){c * r->radius, s * r->radius, r->z0 + v * (r->z1 - r->z0)};
    } else {
        double out = r->radius + v * (r->inner - r->radius);
        *normal = (dvec3){0, 0, 1};
        *position = (dvec3){c * out, s * out, r->z0};
    }
}

static snell_status add_part(pbrt *p, const pbrt_drawn *s, const round_part *r) {
    pbrt_mesh mesh;
    if (pbrt_tessellate(p, s->params->place, ROUND_COLUMNS, r->kind == BALL ? ROUND_ROWS : 1,
                        round_at, r, &mesh))
        return p->status;
    return pbrt_add_mesh(p, s, &mesh);
}

/* Of the sphere and cylinder of snell, which stand on +Y: pbrt's u begins at +x, about z. */
static const dtransform upright = {{{0, 0, -1, 0}, {-1, 0, 0, 0}, {0, 1, 0, 0}}};

static bool read_round(pbrt *p, const pbrt_drawn *s, round_part *r) {
    r->turn = pbrt_float(p, s->params, "phimax", 360) * (PI / 180);
    if (!p->status && !(r->radius > 0 && r->radius < 1e30))
        pbrt_fail(p, s->params->place, NULL, "%s needs a 'radius' above 0", s->params->what);
    r->turn = r->turn < 0 ? 0 : r->turn > 2 * PI ? 2 * PI : r->turn;
    return !p->status && r->turn > 0;
}

snell_status pbrt_sphere(pbrt *p, const pbrt_drawn *s) {
    round_part r = {.kind = BALL, .radius = pbrt_float(p, s->params, "radius", 1)};
    double a = pbrt_float(p, s->params, "zmin", -r.radius),
           b = pbrt_float(p, s->params, "zmax", r.radius);
    if (!read_round(p, s, &r)) return p->status;
    r.z0 = double_max(double_min(a, b), -r.radius);
    r.z1 = double_min(double_max(a, b), r.radius);
    if (!(r.z0 < r.z1)) return SNELL_OK;
    bool whole = r.z0 == -r.radius && r.z1 == r.radius && r.turn > 2 * PI - 1e-9;
    if (!whole || (p->state.reverse && s->exact)) return add_part(p, s, &r);
    if (pbrt_is_hidden_light(p, s)) {
        dtransform to_world = pbrt_to_world(p, 0);
        vec3 center = vec3_from(pbrt_point(&to_world, (dvec3){0, 0, 0}));
        double radius = r.radius * fn_cbrt(fabs(pbrt_determinant(&to_world)));
        const snell_param where[] = {{"center", SNELL_PARAM_VEC3, {.v = center}},
                                     {"radius", SNELL_PARAM_FLOAT, {.f = radius}}};
        return pbrt_add_hidden_light(p, s, "sphere", 4 * PI * r.radius * r.radius, where, 2);
    }
    const snell_param params[] = {{"radius", SNELL_PARAM_FLOAT, {.f = r.radius}}};
    return pbrt_add_shape(p, s, "sphere", params, 1, 4 * PI * r.radius * r.radius, &upright);
}

snell_status pbrt_cylinder(pbrt *p, const pbrt_drawn *s) {
    round_part r = {.kind = TUBE, .radius = pbrt_float(p, s->params, "radius", 1)};
    double a = pbrt_float(p, s->params, "zmin", -1), b = pbrt_float(p, s->params, "zmax", 1);
    if (!read_round(p, s, &r)) return p->status;
    r.z0 = double_min(a, b), r.z1 = double_max(a, b);
    if (!(r.z0 < r.z1)) return SNELL_OK;
    if (r.turn < 2 * PI - 1e-9 || (p->state.reverse && s->exact)) return add_part(p, s, &r);
    const snell_param params[] = {{"from", SNELL_PARAM_VEC3, {.v = {0, (float)r.z0, 0}}},
                                  {"to", SNELL_PARAM_VEC3, {.v = {0, (float)r.z1, 0}}},
                                  {"radius", SNELL_PARAM_FLOAT, {.f = r.radius}},
                                  {"capped", SNELL_PARAM_BOOL, {.b = false}}};
    return pbrt_add_shape(p, s, "cylinder", params, 4, 2 * PI * r.radius * (r.z1 - r.z0), &upright);
}

/* v of pbrt's disk is 0 at its edge, of snell's in the middle: with textures it is a mesh. */
snell_status pbrt_disk(pbrt *p, const pbrt_drawn *s) {
    static const dtransform still = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    round_part r = {.kind = PLATE, .radius = pbrt_float(p, s->params, "radius", 1)};
    r.z0 = pbrt_float(p, s->params, "height", 0);
    r.inner = pbrt_float(p, s->params, "innerradius", 0);
    if (!read_round(p, s, &r)) return p->status;
    if (!(r.inner >= 0 && r.inner < r.radius))
        return pbrt_fail(p, s->params->place, NULL, "the hole of a disk is smaller than the disk");
    if (r.turn < 2 * PI - 1e-9 || pbrt_needs_uvs(p, s)) return add_part(p, s, &r);
    float side = p->state.reverse ? -1 : 1;
    double disk_area = PI * (r.radius - r.inner) * (r.radius + r.inner);
    if (pbrt_is_hidden_light(p, s) && r.inner == 0) {
        dtransform to_world = pbrt_to_world(p, 0);
        dvec3 x = pbrt_vector(&to_world, (dvec3){1, 0, 0}),
              y = pbrt_vector(&to_world, (dvec3){0, 1, 0});
        double way = pbrt_determinant(&to_world) < 0 ? -side : side;
        vec3 center = vec3_from(pbrt_point(&to_world, (dvec3){0, 0, r.z0})),
             normal = vec3_from(dvec3_scale(dvec3_normalize(dvec3_cross(x, y)), way));
        const snell_param where[] = {
            {"center", SNELL_PARAM_VEC3, {.v = center}},
            {"normal", SNELL_PARAM_VEC3, {.v = normal}},
            {"radius", SNELL_PARAM_FLOAT, {.f = r.radius * dvec3_length(x)}}};
        return pbrt_add_hidden_light(p, s, "disk", disk_area, where, 3);
    }
    const snell_param params[] = {{"center", SNELL_PARAM_VEC3, {.v = {0, 0, (float)r.z0}}},
                                  {"normal", SNELL_PARAM_VEC3, {.v = {0, 0, side}}},
                                  {"radius", SNELL_PARAM_FLOAT, {.f = r.radius}},
                                  {"inner_radius", SNELL_PARAM_FLOAT, {.f = r.inner}}};
    return pbrt_add_shape(p, s, "disk", params, 4, disk_area, &still);
}
