/* What a file that brings none gets: a camera, a rig of lights, a sky to reflect, a floor. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/api.h"
#include "base/memory.h"
#include "maths/functions.h"
#include "scene/settings.h"

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

/* A shape of many parts looks at all of them: once, however often it is placed. */
bounds3 description_bounds(const description *d) {
    const object_list *shapes = &d->objects[CATEGORY_SHAPE];
    const transform identity = transform_identity();
    bounds3 all = bounds3_empty();
    part_lists lists;
    snell_status status = part_lists_make(d, &lists);
    bounds3 *own = memory_zeroed(shapes->count, sizeof *own);
    for (size_t i = 0; i < shapes->count && own && !status; i++)
        own[i] = object_is_group(&shapes->items[i]) ? list_bounds(d, &lists, i, own)
                                                    : shape_bounds(d, (uint32_t)i, &identity);
    if (own && !status) all = list_bounds(d, &lists, shapes->count, own);
    free(own);
    part_lists_free(&lists);
    return all;
}

/* No float holds the rig's numbers: what is wrong is the size, not a camera or a light that nobody
 * wrote. */
static snell_status too_large(bounds3 b) {
    double across = dvec3_length(dvec3_sub(dvec3_from(b.max), dvec3_from(b.min)));
    return error_set(SNELL_ERR_UNSUPPORTED, "make it smaller, or give it a camera and lights",
                     "the scene is %.3g m across, too large to be framed and lit", across);
}

static snell_status frame_view(snell_view *view, const snell_bounds *bounds, float azimuth,
                               float elevation, float aspect) {
    if (view == NULL || bounds == NULL || !(aspect > 0) || !isfinite(azimuth) ||
        !isfinite(elevation) || !(view->fov > 0 && (double)view->fov < PI))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_view_frame: an argument is out of range");
    dvec3 low = dvec3_from(bounds->min), high = dvec3_from(bounds->max);
    if (bounds3_is_empty(*bounds)) low = (dvec3){-1, -1, -1}, high = (dvec3){1, 1, 1};
    dvec3 center = dvec3_scale(dvec3_add(low, high), 0.5);
    double radius = dvec3_length(dvec3_sub(high, low)) / 2;
    if (!(radius > 0)) radius = 1;
    /* The sphere touches the edges of the narrower side of the field of view. */
    double half = fn_tan((double)view->fov / 2);
    if (aspect < 1) half *= (double)aspect;
    double distance = radius / fn_sin(fn_atan(half));
    double flat = fn_cos((double)elevation);
    dvec3 to_eye = {flat * fn_sin((double)azimuth), fn_sin((double)elevation),
                    flat * fn_cos((double)azimuth)};
    vec3 from = vec3_from(dvec3_add(center, dvec3_scale(to_eye, distance)));
    if (!isfinite(from.x) || !isfinite(from.y) || !isfinite(from.z)) return too_large(*bounds);
    view->from = from;
    view->at = vec3_from(center);
    /* Straight up or down: the picture's top is away from, or towards, the front. */
    if (fabs(flat) < 1e-3) view->up = (vec3){0, 0, elevation > 0 ? -1 : 1};
    return SNELL_OK;
}

snell_status snell_view_frame(snell_view *view, const snell_bounds *bounds, float azimuth,
                              float elevation, float aspect) {
    unsigned saved = floatenv_enter();
    snell_status status = frame_view(view, bounds, azimuth, elevation, aspect);
    floatenv_leave(saved);
    return status;
}

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

/* The view from a direction. */
static snell_status studio_eye(const description *d, const bounds3 *bounds, float azimuth,
                               float elevation, snell_view *view) {
    const object *render = description_setting(d, "render");
    float aspect = (float)DEFAULT_WIDTH / DEFAULT_HEIGHT;
    if (render) {
        const render_desc *r = render->desc;
        if (r->width > 0 && r->height > 0) aspect = (float)r->width / (float)r->height;
    }
    *view = SNELL_INIT(view);
    return snell_view_frame(view, bounds, azimuth, elevation, aspect);
}

/* Whom the rig lights for: the first camera, a new one, or who looks from the direction. */
static snell_status studio_camera(snell_scene *s, const float direction[2], bool *added,
                                  studio *out) {
    description *d = s->description;
    bool has_camera = d->objects[CATEGORY_CAMERA].count > 0;
    if (has_camera && direction == NULL) {
        const object *camera = &d->objects[CATEGORY_CAMERA].items[0];
        out->eye = SNELL_INIT(view);
        if (camera->type == &camera_perspective.info) {
            out->eye = view_from_perspective(camera->desc);
        } else { /* every camera has these */
            const camera_common *c = camera->desc;
            out->eye.from = c->from, out->eye.at = c->at, out->eye.up = c->up;
        }
        return SNELL_OK;
    }
    /* From (1, .6, 1.4). */
    out->direction[0] = direction ? direction[0] : 0.6202495f;
    out->direction[1] = direction ? direction[1] : 0.3355545f;
    out->from_direction = true;
    out->bounds = description_bounds(d);
    snell_status status =
        studio_eye(d, &out->bounds, out->direction[0], out->direction[1], &out->eye);
    if (status || has_camera) return status;
    perspective_desc desc = view_to_perspective(&out->eye);
    uint32_t index1;
    *added = true;
    return scene_add_typed(s, CATEGORY_CAMERA, "perspective", &desc, &index1);
}

typedef struct rig {
    snell_param key[2], fill; /* of a directional light and a headlight */
} rig;

/* A key over the camera's left shoulder, and a fill at the camera that casts no shadow. On a white
 * surface that faces the key they add up to a radiance of about 1. */
static snell_status studio_rig(const snell_scene *s, const snell_view *view, rig *out) {
    dvec3 back = dvec3_normalize(dvec3_sub(dvec3_from(view->from), dvec3_from(view->at)));
    dvec3 right = dvec3_normalize(dvec3_cross(dvec3_from(view->up), back)),
          up = dvec3_cross(back, right);
    dvec3 key = dvec3_add(dvec3_add(dvec3_scale(back, 0.9), dvec3_scale(up, 1.0)),
                          dvec3_scale(right, -0.75));
    vec3 direction = vec3_from(dvec3_negate(dvec3_normalize(key)));
    dvec3 offset = dvec3_sub(dvec3_from(view->from), dvec3_from(view->at));
    double intensity = 0.8 * dvec3_dot(offset, offset);
    *out = (rig){{{.name = "direction", .kind = SNELL_PARAM_VEC3, .value.v = direction},
                  {.name = "irradiance", .kind = SNELL_PARAM_FLOAT, .value.f = (double)2.9f}},
                 {.name = "intensity", .kind = SNELL_PARAM_FLOAT, .value.f = intensity}};
    return isfinite((float)intensity) ? SNELL_OK : too_large(description_bounds(s->description));
}

static snell_status studio_lights(snell_scene *s, studio *at) {
    rig lights;
    snell_light_id key, fill;
    snell_status status = studio_rig(s, &at->eye, &lights);
    if (!status) status = snell_scene_add_light(s, "directional", lights.key, 2, &key);
    if (!status) status = snell_scene_add_light(s, "headlight", &lights.fill, 1, &fill);
    if (status) return status;
    at->lit = true;
    at->key = key.index1 - 1, at->fill = fill.index1 - 1;
    return SNELL_OK;
}

static snell_status add_studio(snell_scene *s, const float view[2], const char **added) {
    static const char *const texts[] = {"",
                                        "camera",
                                        "lights",
                                        "camera, lights",
                                        "background",
                                        "camera, background",
                                        "lights, background",
                                        "camera, lights, background"};
    const description *d = s->description;
    bool has_background = description_setting(d, "background") != NULL;
    /* What glows in a model lights nothing else in appel and whitted: a label must not leave the
     * rest of the model in the dark. */
    bool has_light = d->objects[CATEGORY_LIGHT].count > 0 ||
                     (!d->is_model && description_has_emission(d)) ||
                     description_setting(d, "ambient");
    /* A scene program that says anything about light means it; a model's parts are filled in one by
     * one. */
    bool wants_light = !has_light && (d->is_model || !has_background);
    bool wants_background = !has_background && (d->is_model || wants_light);
    bool camera_added = false;
    studio made = {.lit = false};
    snell_status status = studio_camera(s, view, &camera_added, &made);
    if (!status && wants_light) status = studio_lights(s, &made);
    if (!status && wants_light) s->studio = made;
    if (!status && wants_background)
        status = snell_scene_set_background_gradient(s, STUDIO_BOTTOM, STUDIO_TOP);
    if (!status && added) *added = texts[camera_added + 2 * wants_light + 4 * wants_background];
    return status;
}

snell_status snell_scene_add_studio(snell_scene *s, const float view[2], const char **added) {
    if (s == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "scene is NULL");
    unsigned saved = floatenv_enter();
    snell_status status = add_studio(s, view, added);
    floatenv_leave(saved);
    return status;
}

/* In place: a frozen light reads its description, and of these kinds nothing else is made from it. */
static snell_status set_light(description *d, uint32_t index, const snell_param *params,
                              size_t count) {
    object *at = &d->objects[CATEGORY_LIGHT].items[index];
    void *desc = desc_copy(at->type, at->desc);
    snell_status status = desc ? SNELL_OK : error_no_memory();
    for (size_t i = 0; i < count && !status; i++) status = desc_set(at->type, desc, &params[i]);
    if (!status) status = desc_check(at->type, desc, NULL);
    if (!status) memcpy(at->desc, desc, at->type->desc_size);
    desc_free(at->type, desc);
    return status;
}

static snell_status turn_studio(snell_scene *s, double angle) {
    description *d = s->description;
    const studio *at = &s->studio;
    snell_view eye = at->eye;
    rig lights;
    snell_status status = SNELL_OK;
    if (at->from_direction)
        status = studio_eye(d, &at->bounds, (float)((double)at->direction[0] + angle),
                            at->direction[1], &eye);
    else if (angle != 0) /* lights know no place: any axis will do */
        status = snell_view_turn(&eye, (vec3){0, 0, 0}, (float)angle);
    if (!status) status = studio_rig(s, &eye, &lights);
    if (!status) status = set_light(d, at->key, lights.key, 2);
    return status ? status : set_light(d, at->fill, &lights.fill, 1);
}

snell_status snell_scene_turn_studio(snell_scene *s, double angle) {
    if (!isfinite(angle))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_scene_turn_studio: angle is not finite");
    snell_status status = scene_begin_edit(s);
    if (status) return status;
    if (s->studio.lit) status = turn_studio(s, angle);
    scene_end_edit(s);
    return status;
}

/* What lies flat would share its plane with the ground, and neither would be before the other: the
 * ground is then a ten-thousandth of the size lower. */
static float ground_height(bounds3 b, dvec3 size) {
    double length = dvec3_length(size);
    if (size.y > 1e-6 * length || !(length > 0)) return b.min.y;
    return (float)((double)b.min.y - 1e-4 * length);
}

static snell_status add_ground(snell_scene *s, snell_vec3 color, snell_instance_id *out) {
    bounds3 b = description_bounds(s->description);
    if (bounds3_is_empty(b)) b = (bounds3){{-1, 0, -1}, {1, 1, 1}};
    dvec3 size = dvec3_sub(dvec3_from(b.max), dvec3_from(b.min));
    double reach = 100 * dvec3_length(size); /* round, so that the horizon is one line */
    if (!(reach > 0)) reach = 100;
    vec3 center = {(float)((double)b.min.x + size.x / 2), ground_height(b, size),
                   (float)((double)b.min.z + size.z / 2)};
    const snell_param floor_params[] = {
        {.name = "center", .kind = SNELL_PARAM_VEC3, .value.v = center},
        {.name = "normal", .kind = SNELL_PARAM_VEC3, .value.v = {0, 1, 0}},
        {.name = "radius", .kind = SNELL_PARAM_FLOAT, .value.f = reach}};
    const snell_param paint = {.name = "color", .kind = SNELL_PARAM_VEC3, .value.v = color};
    snell_shape_id shape;
    snell_material_id matte;
    snell_status status = snell_scene_add_shape(s, "disk", floor_params, 3, &shape);
    if (!status) status = snell_scene_add_material(s, "lambert", &paint, 1, &matte);
    return status ? status : snell_scene_add_instance(s, shape, matte, NULL, out);
}

snell_status snell_scene_add_ground(snell_scene *s, snell_vec3 color, snell_instance_id *out) {
    if (s == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "scene is NULL");
    unsigned saved = floatenv_enter();
    snell_status status = add_ground(s, color, out);
    floatenv_leave(saved);
    return status;
}
