/* What textures need to know of a hit beyond the point, and what they do to its normal. */
#include "scene/scene.h"

/* ---- the footprint ---- */

/* Where the neighbour's ray meets the tangent plane (Igehy 1999, equations 10 to 12). */
static dvec3 transferred(const ray *r, vec3 origin, vec3 direction, double t, dvec3 n) {
    dvec3 d = dvec3_from(r->d),
          moved = dvec3_add(dvec3_from(origin), dvec3_scale(dvec3_from(direction), t));
    return dvec3_sub(moved, dvec3_scale(d, dvec3_dot(moved, n) / dvec3_dot(d, n)));
}

/* The shading normal's change for a step on the surface, given in local space. It is N / |N| with
 * N = to_local^T n of the local normal n; 1 / |N| is the length of to_world^T ns. */
static dvec3 normal_change(const scene_instance *at, const hit *h, const shade_point *p,
                           dvec3 step) {
    dvec3 change = dvec3_scale(step, p->curvature);
    if (solid_is(at->type))
        change = solid_bend(at->shape, h, p->curvature, step);
    else if (at->type->bend)
        change = at->type->bend(at->shape, h, step);
    if (!at->identity)
        change = dvec3_scale(transform_normal(&at->to_local, change),
                             dvec3_length(transform_normal(&at->to_world, p->ns)));
    change = dvec3_sub(change, dvec3_scale(p->ns, dvec3_dot(p->ns, change)));
    return p->outside ? change : dvec3_negate(change);
}

static bool is_tame(dvec3 v) { return dvec3_dot(v, v) < 1e30; } /* false for NaN too */

void scene_set_footprint(const scene *s, const ray *r, const ray_differential *d, const hit *h,
                         shade_point *p) {
    posed_instance moved;
    const scene_instance *at = scene_posed(s, h->instance, r->time, &moved);
    double t = h->t;
    const dvec3 none = {0, 0, 0};
    p->dpdx = none;
    p->dpdy = none;
    p->dndx = none;
    p->dndy = none;
    dvec3 dx = transferred(r, d->dox, d->ddx, t, p->n),
          dy = transferred(r, d->doy, d->ddy, t, p->n);
    /* A ray along the surface meets its tangent plane nowhere. */
    if (!is_tame(dx) || !is_tame(dy)) return;
    dvec3 local_x = at->identity ? dx : transform_vector(&at->to_local, dx),
          local_y = at->identity ? dy : transform_vector(&at->to_local, dy);
    if (!is_tame(local_x) || !is_tame(local_y)) return;
    if (p->material->textured) {
        texture_point *place = &p->at.at;
        place->dpdx = local_x;
        place->dpdy = local_y;
        texture_uv_change(place->dpdu, place->dpdv, local_x, &place->dudx, &place->dvdx);
        texture_uv_change(place->dpdu, place->dpdv, local_y, &place->dudy, &place->dvdy);
    }
    p->dpdx = dx;
    p->dpdy = dy;
    p->dndx = normal_change(at, h, p, local_x);
    p->dndy = normal_change(at, h, p, local_y);
    p->has_footprint = true;
}

/* ---- normal maps and bump ---- */

/* A component of a normal from a colour: 2 c - 1, but the bytes 127 and 128 both mean 0, since
 * neither is the middle; else every flat map would tilt by 0.2 degrees. */
static double signed_component(double c) {
    const double dead = 0.00393; /* a little over 1/255 */
    double value = 2 * c - 1, size = fabs(value);
    if (!(size > dead)) return 0;
    return (value < 0 ? dead - size : size - dead) / (1 - dead);
}

/* A mesh that brings tangents. false: there are none, or none here. */
static bool given_frame(const scene_instance *at, const shade_point *p, dvec3 n, dvec3 *t,
                        dvec3 *b) {
    const mesh_desc *mesh = at->shape;
    double weight[3], sign;
    if (!mesh_is(at->type) || mesh->tangents_count == 0) return false;
    mesh_corners corners = scene_mesh_corners(at, p->time, p->primitive);
    if (!mesh_point_weights(&corners, p->at.at.local, weight)) return false;
    dvec3 given = transform_vector(&at->to_world, mesh_tangent(mesh, p->primitive, weight, &sign));
    dvec3 along = dvec3_sub(given, dvec3_scale(n, dvec3_dot(n, given)));
    if (!(dvec3_length(along) > 1e-6 * dvec3_length(given))) return false;
    *t = dvec3_normalize(along);
    *b = dvec3_scale(dvec3_cross(n, *t), transform_determinant(&at->to_world) < 0 ? -sign : sign);
    return true;
}

/* Right-handed or not as u and v are, so that green is up on mirrored uvs too. false: u has no
 * direction. */
static bool tangent_frame(const scene_instance *at, int map, const shade_point *p, dvec3 n,
                          dvec3 *t, dvec3 *b) {
    dvec3 u, v;
    if ((map == MAP_UV || map == MAP_AUTO) && given_frame(at, p, n, t, b)) return true;
    texture_axes(map, &p->at.at, &u, &v);
    u = transform_vector(&at->to_world, u);
    v = transform_vector(&at->to_world, v);
    dvec3 along = dvec3_sub(u, dvec3_scale(n, dvec3_dot(n, u)));
    if (!(dvec3_length(along) > 1e-6 * dvec3_length(u))) return false;
    *t = dvec3_normalize(along);
    *b = dvec3_cross(n, *t);
    if (dvec3_dot(*b, v) < 0) *b = dvec3_negate(*b);
    return true;
}

static dvec3 mapped_normal(const scene_instance *at, const normal_detail *m, const shade_point *p,
                           dvec3 n) {
    const texture *textures = p->at.textures;
    dvec3 color = texture_look_up(m->map, textures, &p->at.at).color;
    double scale = input_scalar(&m->scale, textures, &p->at.at);
    double x = scale * signed_component(color.x), y = scale * signed_component(color.y),
           z = 2 * color.z - 1;
    const texture *map = &textures[m->map.index1 - 1];
    dvec3 t, b;
    if ((x == 0 && y == 0) || !tangent_frame(at, map->map, p, n, &t, &b)) return n;
    return dvec3_normalize(
        dvec3_add(dvec3_scale(n, z), dvec3_add(dvec3_scale(t, x), dvec3_scale(b, y))));
}

/* Half the distance of the two heights that a slope is taken from, metres: half the footprint, and
 * not so little that rounded coordinates show. */
static double bump_step(const texture *t, const shade_point *p) {
    bool by_uv = t->map == MAP_UV || t->map == MAP_UV2 || (t->map == MAP_AUTO && p->at.at.has_uv);
    double unit = double_min(dvec3_length(p->dpdu), dvec3_length(p->dpdv));
    double least = 0x1p-15 * (by_uv && unit > 0 ? unit : 1);
    if (!p->has_footprint) return least;
    double footprint = double_max(dvec3_length(p->dpdx), dvec3_length(p->dpdy)) / 2;
    return double_max(least, footprint);
}

static double height_at(const material_common *m, const shade_point *p, dvec3 step_local) {
    texture_point place = p->at.at;
    double du, dv;
    texture_uv_change(place.dpdu, place.dpdv, step_local, &du, &dv);
    place.u += du;
    place.v += dv;
    if (place.has_uv2) {
        texture_uv_change(place.dpdu2, place.dpdv2, step_local, &du, &dv);
        place.u2 += du;
        place.v2 += dv;
    }
    place.local = dvec3_add(place.local, step_local);
    return input_scalar(&m->bump, p->at.textures, &place);
}

/* A surface raised by h along n has the normal n - grad h (Blinn, Simulation of Wrinkled Surfaces,
 * 1978, for h small against the radius of curvature). grad h: by central differences. */
static dvec3 bumped_normal(const scene_instance *at, const material_common *m, const shade_point *p,
                           dvec3 n) {
    double step = bump_step(&p->at.textures[m->bump.texture.index1 - 1], p);
    dvec3 axes[2], bent = n;
    dvec3_frame(p->n, &axes[0], &axes[1]);
    for (int i = 0; i < 2; i++) {
        dvec3 local = transform_vector(&at->to_local, dvec3_scale(axes[i], step));
        double rise = height_at(m, p, local) - height_at(m, p, dvec3_negate(local));
        double slope = (double)m->bump_scale * rise / (2 * step);
        bent = dvec3_sub(bent, dvec3_scale(axes[i], slope));
    }
    return dvec3_normalize(bent);
}

/* From `good`, which is on w's side, towards `wanted`, but not over the edge. */
static dvec3 kept_above(dvec3 good, dvec3 wanted, dvec3 w) {
    double a = dvec3_dot(good, w), b = dvec3_dot(wanted, w);
    if (b > 0 || !(a > 0)) return b > 0 ? wanted : good;
    double part = 0.99 * a / (a - b);
    return dvec3_normalize(dvec3_add(dvec3_scale(good, 1 - part), dvec3_scale(wanted, part)));
}

/* Of a grained material; nothing where u has no direction. */
static void find_tangents(const scene_instance *at, shade_point *p) {
    dvec3 n = p->outside ? p->ns : dvec3_negate(p->ns), t, b;
    if (!tangent_frame(at, MAP_AUTO, p, n, &t, &b)) return;
    p->at.tangent = t;
    p->at.bitangent = b;
}

/* ns, bent by a normal map and by the bump of a material; NULL: by none. */
static dvec3 bent_normal(const scene_instance *at, const normal_detail *normals,
                         const material_common *bumped, const shade_point *p) {
    dvec3 n = p->outside ? p->ns : dvec3_negate(p->ns);
    if (normals->map.index1) n = mapped_normal(at, normals, p, n);
    if (bumped && bumped->bump.texture.index1) n = bumped_normal(at, bumped, p, n);
    if (!p->outside) n = dvec3_negate(n);
    if (!is_tame(n)) return p->ns;
    return kept_above(p->ns, kept_above(p->ns, n, p->n), p->wo);
}

static void bend(const scene_instance *at, shade_point *p) {
    const material_common *m = p->material->desc;
    const material_type *type = p->material->type;
    const normal_detail normals = {m->normal_map, m->normal_scale};
    normal_detail of_coat = {.map = {0, 0}};
    if (type->coat) type->coat(m, &of_coat);
    if (p->material->coated)
        p->at.coat = (coat_normal){true, bent_normal(at, &of_coat, NULL, p), p->n};
    p->ns = bent_normal(at, &normals, m, p);
}

void scene_bend_normal(const scene *s, shade_point *p) {
    posed_instance moved;
    const scene_instance *at = scene_posed(s, p->instance, p->time, &moved);
    if (p->material->bends) bend(at, p);
    if (p->material->grained) find_tangents(at, p);
}
