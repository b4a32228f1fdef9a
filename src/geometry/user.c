#include "geometry/user.h"

#include <float.h>

#include "base/error.h"
#include "geometry/surface.h"

static bool is_finite(vec3 v) {
    return fabsf(v.x) <= FLT_MAX && fabsf(v.y) <= FLT_MAX && fabsf(v.z) <= FLT_MAX;
}

static bounds3 part_bounds(const void *desc, uint32_t primitive) {
    const snell_user_shape_desc *given = &((const user_desc *)desc)->given;
    bounds3 box = bounds3_empty();
    given->bounds(given->user, primitive, &box);
    return box;
}

snell_status user_desc_make(const snell_user_shape_desc *given, user_desc *out) {
    if (given->struct_size != sizeof *given)
        return error_set(SNELL_ERR_VERSION, "compile against the library's own header",
                         "user shape: the description has another version's size");
    if (!given->bounds || !given->intersect || !given->surface)
        return error_set(SNELL_ERR_ARGUMENT, NULL,
                         "user shape: bounds, intersect and surface are needed");
    if (given->primitive_count == 0 || given->primitive_count >= 0x0fffffffu)
        return error_set(SNELL_ERR_ARGUMENT, "at least 1, less than 2^28",
                         "user shape: %u primitives", given->primitive_count);
    *out = (user_desc){sizeof *out, *given, bounds3_empty()};
    for (uint32_t i = 0; i < given->primitive_count; i++) {
        bounds3 box = part_bounds(out, i);
        if (bounds3_is_empty(box)) continue;
        if (!is_finite(box.min) || !is_finite(box.max))
            return error_set(SNELL_ERR_ARGUMENT, "min > max where there is nothing",
                             "user shape: the box of primitive %u is not finite", i);
        out->all = bounds3_union(out->all, box);
    }
    return SNELL_OK;
}

static uint32_t part_count(const void *desc) {
    return ((const user_desc *)desc)->given.primitive_count;
}

static bounds3 bounds(const void *desc) { return ((const user_desc *)desc)->all; }

static snell_user_ray user_ray(const local_ray *beam) {
    return (snell_user_ray){beam->o, beam->t_min, beam->d, beam->t_max};
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    const snell_user_shape_desc *given = &((const user_desc *)desc)->given;
    snell_user_ray own = user_ray(beam);
    snell_user_hit answer = {0, 0, 0};
    if (!given->intersect(given->user, found->primitive, &own, &answer)) return false;
    found->t = answer.t, found->u = answer.u, found->v = answer.v;
    return answer.t > beam->t_min && answer.t < beam->t_max;
}

/* What is not a point or not a direction is replaced by what the ray alone says. */
static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    const snell_user_shape_desc *given = &((const user_desc *)desc)->given;
    dvec3 d = dvec3_from(beam->d),
          straight = dvec3_add(dvec3_from(beam->o), dvec3_scale(d, found->t));
    snell_user_ray own = user_ray(beam);
    snell_user_hit at = {found->t, found->u, found->v};
    snell_user_surface s = {.position = {straight.x, straight.y, straight.z}};
    given->surface(given->user, found->primitive, &own, &at, &s);
    dvec3 p = {s.position[0], s.position[1], s.position[2]},
          n = dvec3_normalize((dvec3){s.normal[0], s.normal[1], s.normal[2]});
    if (!isfinite(p.x + p.y + p.z)) p = straight;
    if (!(dvec3_dot(n, n) > 0.5)) n = dvec3_normalize(dvec3_negate(d));
    double size = fabs(p.x) + fabs(p.y) + fabs(p.z);
    double bend = s.curvature > 0 && isfinite(s.curvature) ? s.curvature : 0;
    double error = s.error > 0 && isfinite(s.error) ? s.error : 0;
    *out = surface_make(p, n, error + 16 * DOUBLE_EPSILON * size + surface_shift_error(p, bend));
    out->curvature = bend;
    if (isfinite(s.uv[0]) && isfinite(s.uv[1])) out->u = s.uv[0], out->v = s.uv[1];
}

const primitive_type shape_user = {
    .info = {.name = "user", .category = CATEGORY_SHAPE, .desc_size = sizeof(user_desc)},
    .bounds = bounds,
    .primitive_count = part_count,
    .primitive_bounds = part_bounds,
    .intersect = intersect,
    .surface = fill_surface};
