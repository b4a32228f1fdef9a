/* What a picture of everything has to hold: its bounds, and views that see all of it. */
#include <stdlib.h>

#include "api/api.h"
#include "base/memory.h"
#include "geometry/mesh.h"
#include "maths/functions.h"

/* shapes: bounds of each, of groups those before this list. */
static bounds3 list_bounds(const description *d, const part_lists *lists, size_t list,
                           const bounds3 *shapes) {
    bounds3 all = bounds3_empty();
    for (uint32_t i = lists->begin[list]; i < lists->begin[list + 1]; i++) {
        const instance *at = &d->instances[lists->parts[i]];
        bounds3 own = shapes[at->shape];
        if (!bounds_are_finite(own)) continue;
        all = bounds3_union(all, transform_bounds(&at->to_world, own));
        for (size_t k = 1; k < at->key_count; k++)
            all = bounds3_union(all, transform_bounds(&at->keys[k].transform, own));
    }
    return all;
}

/* Of each shape: one of many parts looks at all of them once, however often it is placed. NULL: no
 * memory (a scene whose groups nest too deep is refused where it is made); otherwise both are the caller's. */
static bounds3 *shape_boxes(const description *d, part_lists *lists) {
    const object_list *shapes = &d->objects[CATEGORY_SHAPE];
    const transform identity = transform_identity();
    if (part_lists_make(d, lists)) {
        part_lists_free(lists);
        return NULL;
    }
    bounds3 *own = memory_zeroed(shapes->count + 1, sizeof *own);
    for (size_t i = 0; i < shapes->count && own; i++)
        own[i] = object_is_group(&shapes->items[i]) ? list_bounds(d, lists, i, own)
                                                    : shape_bounds(d, (uint32_t)i, &identity);
    if (own == NULL) part_lists_free(lists);
    return own;
}

bounds3 description_bounds(const description *d) {
    part_lists lists;
    bounds3 *own = shape_boxes(d, &lists);
    if (own == NULL) return bounds3_empty();
    bounds3 all = list_bounds(d, &lists, d->objects[CATEGORY_SHAPE].count, own);
    free(own);
    part_lists_free(&lists);
    return all;
}

/* No float holds the numbers of a camera or a light: what is wrong is the size, not one that nobody
 * wrote. */
snell_status framing_too_large(bounds3 b) {
    double across = dvec3_length(dvec3_sub(dvec3_from(b.max), dvec3_from(b.min)));
    return error_set(SNELL_ERR_UNSUPPORTED, "make it smaller, or give it a camera and lights",
                     "the scene is %.3g m across, too large to be framed and lit", across);
}

/* ---- by a sphere ---- */

static bool can_frame(const snell_view *view, float azimuth, float elevation, float aspect) {
    return view != NULL && aspect > 0 && isfinite(aspect) && isfinite(azimuth) &&
           isfinite(elevation) && view->fov > 0 && (double)view->fov < PI;
}

/* The unit vector to the eye. Straight up or down: the picture's top is away from, or towards, the
 * front. */
static dvec3 direction_of(snell_view *view, float azimuth, float elevation) {
    double flat = fn_cos((double)elevation);
    if (fabs(flat) < 1e-3) view->up = (vec3){0, 0, elevation > 0 ? -1 : 1};
    return (dvec3){flat * fn_sin((double)azimuth), fn_sin((double)elevation),
                   flat * fn_cos((double)azimuth)};
}

static snell_status look_at(snell_view *view, dvec3 at, dvec3 from, const bounds3 *b) {
    vec3 eye = vec3_from(from);
    if (!isfinite(eye.x) || !isfinite(eye.y) || !isfinite(eye.z)) return framing_too_large(*b);
    view->from = eye;
    view->at = vec3_from(at);
    return SNELL_OK;
}

/* Never without a size. */
static double half_diagonal(bounds3 b, dvec3 *center) {
    dvec3 low = dvec3_from(b.min), high = dvec3_from(b.max);
    *center = dvec3_scale(dvec3_add(low, high), 0.5);
    double radius = dvec3_length(dvec3_sub(high, low)) / 2;
    return radius > 0 ? radius : 1;
}

static bounds3 box_to_see(bounds3 b) {
    return bounds3_is_empty(b) ? (bounds3){{-1, -1, -1}, {1, 1, 1}} : b;
}

static snell_status frame_view(snell_view *view, const snell_bounds *bounds, float azimuth,
                               float elevation, float aspect) {
    if (bounds == NULL || !can_frame(view, azimuth, elevation, aspect))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_view_frame: an argument is out of range");
    dvec3 center;
    double radius = half_diagonal(box_to_see(*bounds), &center);
    /* The sphere touches the edges of the narrower side of the field of view. */
    double half = fn_tan((double)view->fov / 2);
    if (aspect < 1) half *= (double)aspect;
    dvec3 back =
        dvec3_scale(direction_of(view, azimuth, elevation), radius / fn_sin(fn_atan(half)));
    return look_at(view, center, dvec3_add(center, back), bounds);
}

snell_status snell_view_frame(snell_view *view, const snell_bounds *bounds, float azimuth,
                              float elevation, float aspect) {
    unsigned saved = floatenv_enter();
    snell_status status = frame_view(view, bounds, azimuth, elevation, aspect);
    floatenv_leave(saved);
    return status;
}

/* ---- by what there is ---- */

/* Of the picture's width or height: the rest is the margin, half of it on each side. */
static const double FRAME_FILLED = 0.9;
/* A scene of more corners is seen by its boxes: to look at all of them twice would take half a second. */
enum { CORNERS_MAX = 1 << 24 };

/* How far things reach from a center in the directions of which a view's edges are made, and towards
 * the eye. */
enum { TO_RIGHT, TO_LEFT, TO_TOP, TO_BOTTOM, TO_EYE, REACHES };
typedef struct reach {
    dvec3 center, right, up, back;
    double half[2], distance; /* width and height to be filled, at distance 1; of the eye */
    dvec3 direction[REACHES], farthest[REACHES]; /* which point is it, from the center */
    double far[REACHES];
    bool turning; /* the farthest while turned once around the vertical axis through the center */
    size_t corners_left;
} reach;

static void reach_point(reach *r, dvec3 p) {
    dvec3 v = dvec3_sub(p, r->center);
    double around = r->turning ? sqrt(v.x * v.x + v.z * v.z) : 0;
    for (int i = 0; i < REACHES; i++) {
        dvec3 d = r->direction[i], at = v;
        double flat = r->turning ? sqrt(d.x * d.x + d.z * d.z) : 0;
        if (flat > 0) at = (dvec3){d.x / flat * around, v.y, d.z / flat * around};
        double far = dvec3_dot(d, at);
        if (!(far > r->far[i])) continue;
        r->far[i] = far;
        r->farthest[i] = at;
    }
}

static void reach_box(reach *r, const transform *placed, bounds3 b) {
    for (int i = 0; i < 8; i++) {
        dvec3 corner = {i & 1 ? b.max.x : b.min.x, i & 2 ? b.max.y : b.min.y,
                        i & 4 ? b.max.z : b.min.z};
        reach_point(r, transform_point(placed, corner));
    }
}

/* Those of its triangles: vertices that none has are not seen. */
static void reach_mesh(reach *r, const transform *placed, const mesh_desc *mesh) {
    size_t vertices = mesh_vertex_count(mesh);
    for (size_t k = 0; k < mesh_key_count(mesh); k++)
        for (size_t i = 0; i < mesh->indices_count; i++) {
            vec3 p = mesh->positions[k * vertices + mesh->indices[i]];
            reach_point(r, transform_point(placed, dvec3_from(p)));
        }
}

static void reach_shape(reach *r, const object *shape, bounds3 own, const transform *placed) {
    if (shape->type == &primitive_mesh.info) {
        const mesh_desc *mesh = shape->desc;
        size_t corners = mesh->indices_count * mesh_key_count(mesh);
        if (corners <= r->corners_left) {
            r->corners_left -= corners;
            reach_mesh(r, placed, mesh);
            return;
        }
    }
    reach_box(r, placed, own);
}

static void reach_world(reach *r, const description *d, const part_lists *lists,
                        const bounds3 *boxes) {
    const object_list *shapes = &d->objects[CATEGORY_SHAPE];
    for (uint32_t i = lists->begin[shapes->count]; i < lists->begin[shapes->count + 1]; i++) {
        const instance *at = &d->instances[lists->parts[i]];
        const object *shape = &shapes->items[at->shape];
        if (!bounds_are_finite(boxes[at->shape])) continue;
        reach_shape(r, shape, boxes[at->shape], &at->to_world);
        for (size_t k = 1; k < at->key_count; k++)
            reach_shape(r, shape, boxes[at->shape], &at->keys[k].transform);
    }
}

/* With x to the right and z towards the eye, a point is left of the right edge where
 * x - eye.x <= half (eye.z - z): eye.x + half eye.z is at least its reach in the direction x + half z. */
static void reach_all(reach *r, const description *d, const part_lists *lists,
                      const bounds3 *boxes) {
    dvec3 wide = dvec3_scale(r->back, r->half[0]), high = dvec3_scale(r->back, r->half[1]);
    r->direction[TO_RIGHT] = dvec3_add(wide, r->right);
    r->direction[TO_LEFT] = dvec3_sub(wide, r->right);
    r->direction[TO_TOP] = dvec3_add(high, r->up);
    r->direction[TO_BOTTOM] = dvec3_sub(high, r->up);
    r->direction[TO_EYE] = r->back;
    r->corners_left = CORNERS_MAX;
    for (int i = 0; i < REACHES; i++) r->far[i] = -INFINITY;
    reach_world(r, d, lists, boxes);
    const transform here = transform_identity();
    if (r->far[TO_EYE] == -INFINITY) reach_box(r, &here, box_to_see(bounds3_empty()));
}

/* Where the eye stands across an axis of the picture: what is farthest on both sides is then equally far
 * from the middle, as far as all of `outer` stays in. `inner`: what fits more closely on that axis. */
static double reach_middle(const reach *inner, const reach *outer, int side, dvec3 axis,
                           double room) {
    dvec3 p = inner->farthest[side], q = inner->farthest[side + 1];
    double large = 1 / (outer->distance - dvec3_dot(outer->back, p)),
           small = 1 / (outer->distance - dvec3_dot(outer->back, q));
    double middle = (dvec3_dot(axis, p) * large + dvec3_dot(axis, q) * small) / (large + small);
    middle = double_min(middle, room - outer->far[side + 1]);
    return double_max(middle, outer->far[side] - room);
}

static snell_status frame_scene(const description *d, const part_lists *lists, const bounds3 *boxes,
                                reach *r, snell_view *view) {
    bounds3 all = list_bounds(d, lists, d->objects[CATEGORY_SHAPE].count, boxes);
    double radius = half_diagonal(box_to_see(all), &r->center);
    const double *far = r->far;
    reach_all(r, d, lists, boxes);
    /* The nearest eye that sees all, before everything. */
    r->distance = double_max(far[TO_EYE], 0) + 0.05 * radius;
    for (int k = 0; k < 2; k++)
        r->distance = double_max(r->distance, (far[2 * k] + far[2 * k + 1]) / (2 * r->half[k]));
    reach inner = *r;
    for (int k = 0; k < 2; k++) inner.half[k] = (far[2 * k] + far[2 * k + 1]) / (2 * r->distance);
    reach_all(&inner, d, lists, boxes);
    double x = reach_middle(&inner, r, TO_RIGHT, r->right, r->half[0] * r->distance),
           y = reach_middle(&inner, r, TO_TOP, r->up, r->half[1] * r->distance);
    dvec3 aside = dvec3_add(dvec3_scale(r->right, x), dvec3_scale(r->up, y)),
          at = dvec3_add(r->center, aside), from = dvec3_add(at, dvec3_scale(r->back, r->distance));
    return look_at(view, at, from, &all);
}

snell_status framing_of(const description *d, float azimuth, float elevation, float aspect,
                        bool turning, snell_view *view) {
    if (!can_frame(view, azimuth, elevation, aspect))
        return error_set(SNELL_ERR_ARGUMENT, NULL,
                         "snell_view_frame_scene: an argument is out of range");
    reach r = {.back = direction_of(view, azimuth, elevation), .turning = turning};
    dvec3 up = dvec3_from(view->up), right = dvec3_cross(up, r.back);
    if (!(dvec3_length(right) > 1e-6 * dvec3_length(up)) || !isfinite(dvec3_length(right)))
        return error_set(SNELL_ERR_ARGUMENT, NULL,
                         "snell_view_frame_scene: the view's up lies along the direction of sight");
    part_lists lists;
    bounds3 *boxes = shape_boxes(d, &lists);
    if (boxes == NULL) return error_no_memory();
    r.right = dvec3_normalize(right);
    r.up = dvec3_cross(r.back, r.right);
    r.half[1] = fn_tan((double)view->fov / 2) * FRAME_FILLED;
    r.half[0] = r.half[1] * (double)aspect;
    snell_status status = frame_scene(d, &lists, boxes, &r, view);
    free(boxes);
    part_lists_free(&lists);
    return status;
}

snell_status snell_view_frame_scene(snell_view *view, const snell_scene *s, float azimuth,
                                    float elevation, float aspect, bool turning) {
    snell_status status = scene_begin_look(s);
    if (status) return status;
    unsigned saved = floatenv_enter();
    status = framing_of(s->description, azimuth, elevation, aspect, turning, view);
    floatenv_leave(saved);
    scene_end_read(s);
    return status;
}

/* ---- turning ---- */

snell_status snell_view_turn(snell_view *view, vec3 center, float angle) {
    if (view == NULL || !isfinite(angle))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_view_turn: an argument is out of range");
    unsigned saved = floatenv_enter();
    double c = fn_cos((double)angle), s = fn_sin((double)angle);
    dvec3 around = dvec3_from(center);
    const dmat3 turn = {{c, 0, s}, {0, 1, 0}, {-s, 0, c}};
    vec3 *points[2] = {&view->from, &view->at};
    for (int i = 0; i < 2; i++) {
        dvec3 arm = dvec3_sub(dvec3_from(*points[i]), around);
        *points[i] = vec3_from(dvec3_add(around, dmat3_apply(&turn, arm)));
    }
    view->up = vec3_from(dmat3_apply(&turn, dvec3_from(view->up)));
    floatenv_leave(saved);
    return SNELL_OK;
}
