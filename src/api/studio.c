/* What a file that brings none gets: a camera, a rig of lights, a sky to reflect, a floor. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/api.h"
#include "base/memory.h"
#include "lights/light.h"
#include "lights/sky.h"
#include "maths/functions.h"
#include "scene/settings.h"

/* From (1, .6, 1.4), in the shape of the picture that the scene asks for. */
static snell_status usual_view(const description *d, snell_view *view) {
    const object *render = description_setting(d, "render");
    float aspect = (float)DEFAULT_WIDTH / DEFAULT_HEIGHT;
    if (render) {
        const render_desc *r = render->desc;
        if (r->width > 0 && r->height > 0) aspect = (float)r->width / (float)r->height;
    }
    *view = SNELL_INIT(view);
    return framing_of(d, 0.6202495f, 0.3355545f, aspect, false, view);
}

/* Whom the rig lights for: the caller's view, the first camera, or a new one. */
static snell_status studio_camera(snell_scene *s, const snell_view *view, bool *added,
                                  snell_view *eye) {
    const description *d = s->description;
    bool has_camera = d->objects[CATEGORY_CAMERA].count > 0;
    snell_status status = SNELL_OK;
    if (view) {
        *eye = *view; /* its motion is borrowed, for the camera alone */
    } else if (!has_camera) {
        status = usual_view(d, eye);
    } else {
        const object *camera = &d->objects[CATEGORY_CAMERA].items[0];
        *eye = SNELL_INIT(view);
        if (camera->type == &camera_perspective.info) {
            *eye = view_from_perspective(camera->desc);
        } else { /* every camera has these */
            const camera_common *c = camera->desc;
            eye->from = c->from, eye->at = c->at, eye->up = c->up;
        }
    }
    perspective_desc desc = view_to_perspective(eye);
    eye->motion = NULL, eye->motion_count = 0;
    if (status || has_camera) return status;
    uint32_t index1;
    *added = true;
    return scene_add_typed(s, CATEGORY_CAMERA, "perspective", &desc, &index1);
}

typedef struct rig {
    snell_param key[2], fill; /* of a directional light and a headlight */
} rig;

/* To the light over the camera's left shoulder. */
static dvec3 to_key(const snell_view *view) {
    dvec3 back = dvec3_normalize(dvec3_sub(dvec3_from(view->from), dvec3_from(view->at)));
    dvec3 right = dvec3_normalize(dvec3_cross(dvec3_from(view->up), back)),
          up = dvec3_cross(back, right);
    return dvec3_normalize(dvec3_add(dvec3_add(dvec3_scale(back, 0.9), dvec3_scale(up, 1.0)),
                                     dvec3_scale(right, -0.75)));
}

/* The key, and a fill at the camera that casts no shadow. On a white surface that faces the key they
 * add up to a radiance of about 1. */
static snell_status studio_rig(const snell_scene *s, const snell_view *view, rig *out) {
    vec3 direction = vec3_from(dvec3_negate(to_key(view)));
    dvec3 offset = dvec3_sub(dvec3_from(view->from), dvec3_from(view->at));
    double intensity = 0.8 * dvec3_dot(offset, offset);
    *out = (rig){{{.name = "direction", .kind = SNELL_PARAM_VEC3, .value.v = direction},
                  {.name = "irradiance", .kind = SNELL_PARAM_FLOAT, .value.f = (double)2.9f}},
                 {.name = "intensity", .kind = SNELL_PARAM_FLOAT, .value.f = intensity}};
    return isfinite((float)intensity) ? SNELL_OK
                                      : framing_too_large(description_bounds(s->description));
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

/* The sun where the key would be, but never low, and the sky around it; of their colours as they are,
 * and so bright that the sun alone makes white 0.8. */
static snell_status daylight_lights(snell_scene *s, const snell_view *view, bool visible) {
    const double turbidity = 3, height = 40 * PI / 180;
    dvec3 key = to_key(view), sun = {key.x, 0, key.z};
    if (!(dvec3_length(sun) > 1e-3)) sun = (dvec3){0, 0, 1};
    sun = dvec3_scale(dvec3_normalize(sun), fn_cos(height));
    sun.y = fn_sin(height);
    dvec3 sunlight = sky_sun_irradiance(sun.y, turbidity);
    double scale = 0.8 * PI / LUMINANCE(sunlight);
    const snell_param sky[] = {
        {.name = "sun", .kind = SNELL_PARAM_VEC3, .value.v = vec3_from(sun)},
        {.name = "turbidity", .kind = SNELL_PARAM_FLOAT, .value.f = turbidity},
        {.name = "scale", .kind = SNELL_PARAM_FLOAT, .value.f = scale},
        {.name = "visible", .kind = SNELL_PARAM_BOOL, .value.b = visible}};
    const snell_param disk[] = {
        {.name = "direction", .kind = SNELL_PARAM_VEC3, .value.v = vec3_from(dvec3_negate(sun))},
        {.name = "irradiance",
         .kind = SNELL_PARAM_VEC3,
         .value.v = vec3_from(dvec3_scale(sunlight, scale))},
        {.name = "angle", .kind = SNELL_PARAM_FLOAT, .value.f = SUN_ANGLE},
        {.name = "visible", .kind = SNELL_PARAM_BOOL, .value.b = visible}};
    snell_light_id id;
    snell_status status = snell_scene_add_light(s, "sky", sky, 4, &id);
    return status ? status : snell_scene_add_light(s, "directional", disk, 4, &id);
}

enum rig_kind { RIG_STUDIO, RIG_DAYLIGHT, RIG_DAYLIGHT_HIDDEN };

static snell_status add_studio(snell_scene *s, const snell_view *view, enum rig_kind kind,
                               const char **added) {
    static const char *const texts[] = {"",
                                        "camera",
                                        "lights",
                                        "camera, lights",
                                        "background",
                                        "camera, background",
                                        "lights, background",
                                        "camera, lights, background",
                                        [8 + 2] = "sun and sky",
                                        "camera, sun and sky"};
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
    bool by_day = wants_light && kind != RIG_STUDIO;
    bool wants_background = !has_background && !by_day && (d->is_model || wants_light);
    bool camera_added = false;
    studio made = {.lit = false};
    snell_status status = studio_camera(s, view, &camera_added, &made.eye);
    if (!status && by_day) status = daylight_lights(s, &made.eye, kind == RIG_DAYLIGHT);
    if (!status && wants_light && !by_day) status = studio_lights(s, &made);
    if (!status && wants_light) s->studio = made;
    if (!status && wants_background)
        status = snell_scene_set_background_gradient(s, STUDIO_BOTTOM, STUDIO_TOP);
    if (!status && added)
        *added = texts[camera_added + 2 * wants_light + 4 * wants_background + 8 * by_day];
    return status;
}

snell_status snell_scene_add_studio(snell_scene *s, const snell_view *view, const char **added) {
    if (s == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "scene is NULL");
    unsigned saved = floatenv_enter();
    snell_status status = add_studio(s, view, RIG_STUDIO, added);
    floatenv_leave(saved);
    return status;
}

snell_status snell_scene_add_daylight(snell_scene *s, const snell_view *view, bool visible,
                                      const char **added) {
    if (s == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "scene is NULL");
    unsigned saved = floatenv_enter();
    snell_status status = add_studio(s, view, visible ? RIG_DAYLIGHT : RIG_DAYLIGHT_HIDDEN, added);
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
    if (angle != 0) /* lights know no place: any axis will do */
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
