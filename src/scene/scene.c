#include "scene/scene.h"

#include <stdlib.h>

#include "base/memory.h"
#include "geometry/mesh.h"
#include "geometry/surface.h"
#include "scene/instances.h"
#include "scene/lights.h"
#include "scene/settings.h"

/* The grey Lambert of shapes without a material: its desc with every default. */
extern const material_type material_lambert;

/* The next field from *index on that names a material, an earlier one; NULL: none. */
static const material *next_part(const scene *s, const object *o, uint32_t *index) {
    while (*index < o->type->field_count) {
        const field *f = &o->type->fields[(*index)++];
        if (f->kind != FIELD_MATERIAL) continue;
        const void *at = (const char *)o->desc + f->offset;
        uint32_t part = ((const snell_material_id *)at)->index1;
        if (part) return &s->materials[part - 1];
    }
    return NULL;
}

/* Does it, or a material that it is made of, use a texture? */
static bool is_textured(const scene *s, const object *o) {
    for (uint32_t i = 0; i < o->type->field_count; i++) {
        const field *f = &o->type->fields[i];
        const void *at = (const char *)o->desc + f->offset;
        if ((f->kind == FIELD_INPUT || f->kind == FIELD_SCALAR) &&
            ((const snell_input *)at)->texture.index1)
            return true;
        if (f->kind == FIELD_TEXTURE && ((const snell_texture_id *)at)->index1) return true;
    }
    const material *part;
    for (uint32_t i = 0; (part = next_part(s, o, &i)) != NULL;)
        if (part->textured) return true;
    return false;
}

static bool is_thin(const scene *s, const object *o) {
    const material_type *type = (const material_type *)o->type;
    if (type->is_thin) return type->is_thin(o->desc);
    const material *part;
    for (uint32_t i = 0; (part = next_part(s, o, &i)) != NULL;)
        if (part->thin) return true;
    return false;
}

static bool is_grained(const scene *s, const object *o) {
    const material_type *type = (const material_type *)o->type;
    if (type->is_grained && type->is_grained(o->desc)) return true;
    const material *part;
    for (uint32_t i = 0; (part = next_part(s, o, &i)) != NULL;)
        if (part->grained) return true;
    return false;
}

static bool is_coated(const scene *s, const object *o) {
    const material_type *type = (const material_type *)o->type;
    normal_detail normals;
    if (type->coat && type->coat(o->desc, &normals)) return true;
    const material *part;
    for (uint32_t i = 0; (part = next_part(s, o, &i)) != NULL;)
        if (part->coated) return true;
    return false;
}

/* Some materials are as opaque as those that they are made of. */
static bool has_opaque_parts(const scene *s, const object *o) {
    if (((const material_type *)o->type)->opacity == NULL) return true;
    const material *part;
    for (uint32_t i = 0; (part = next_part(s, o, &i)) != NULL;)
        if (!part->opaque_alpha) return false;
    return true;
}

static bool can_shine(const scene *s, const material *m) {
    const material_common *common = m->desc;
    return vec3_largest(common->emission.value) > 0 ||
           (m->type->shines && m->type->shines(m->desc, s->materials));
}

/* The black material of a light's shape, which only shines. */
static snell_status make_body_material(scene *s, light_body *body) {
    const type_info *info = &material_lambert.info;
    const snell_param black = {.name = "color", .kind = SNELL_PARAM_FLOAT, .value.f = 0};
    body->material_desc = memory_zeroed(1, info->desc_size);
    if (body->material_desc == NULL) return error_no_memory();
    desc_init(info, body->material_desc);
    snell_status status = desc_set(info, body->material_desc, &black);
    material_common *common = body->material_desc;
    common->ambient = (vec3){0, 0, 0};
    common->emission.value = vec3_from(body->shape.radiance);
    s->materials[s->material_count + s->body_count] =
        (material){.type = &material_lambert,
                   .desc = body->material_desc,
                   .opaque_alpha = true,
                   .shines = vec3_largest(common->emission.value) > 0};
    return status;
}

/* Lights that are surfaces become shapes with a material; the others are made ready to be sampled. */
static snell_status freeze_light_objects(scene *s, const object_list *lights, thread_pool *pool) {
    for (size_t i = 0; i < lights->count; i++) {
        const object *o = &lights->items[i];
        const light_type *type = (const light_type *)o->type;
        snell_status status = SNELL_OK;
        if (type->shape) {
            light_body *body = &s->bodies[s->body_count];
            status = type->shape(o->desc, &body->shape);
            if (status) return status;
            s->body_count++; /* from here on it is freed with the scene */
            status = make_body_material(s, body);
        } else {
            light *l = &s->lights[s->light_count++];
            *l = (light){.type = type, .desc = o->desc, .textures = s->textures};
            if (type->point) type->point(o->desc, &l->position, &l->intensity);
            if (type->prepare) status = type->prepare(o->desc, s->textures, pool, &l->state);
        }
        if (status) return status;
    }
    return SNELL_OK;
}

/* Without a texture the height is the same everywhere. */
static bool bends(const object *o) {
    const material_common *m = o->desc;
    const material_type *type = (const material_type *)o->type;
    normal_detail normals;
    return m->normal_map.index1 || m->bump.texture.index1 ||
           (type->coat && type->coat(o->desc, &normals) && normals.map.index1);
}

static snell_status freeze_objects(scene *s, const description *d) {
    const object_list *textures = &d->objects[CATEGORY_TEXTURE];
    const object_list *materials = &d->objects[CATEGORY_MATERIAL];
    const object_list *lights = &d->objects[CATEGORY_LIGHT];
    s->textures = memory_zeroed(textures->count, sizeof *s->textures);
    s->materials = memory_zeroed(materials->count + 1 + lights->count, sizeof *s->materials);
    s->lights = memory_zeroed(lights->count, sizeof *s->lights);
    s->bodies = memory_zeroed(lights->count, sizeof *s->bodies);
    s->default_material = memory_zeroed(1, material_lambert.info.desc_size);
    if (!s->textures || !s->materials || !s->lights || !s->bodies || !s->default_material)
        return error_no_memory();
    s->texture_count = (uint32_t)textures->count;
    s->material_count = (uint32_t)materials->count;
    for (size_t i = 0; i < textures->count; i++) {
        const object *o = &textures->items[i];
        s->textures[i] = texture_make((const texture_type *)o->type, o->desc);
        s->needs_footprint |= texture_filters(&s->textures[i]);
    }
    for (size_t i = 0; i < materials->count; i++) {
        const object *o = &materials->items[i];
        const material_common *common = o->desc;
        bool opaque = common->alpha.texture.index1 == 0 && common->alpha.value.x >= 1 &&
                      has_opaque_parts(s, o);
        s->materials[i] = (material){.type = (const material_type *)o->type,
                                     .desc = o->desc,
                                     .opaque_alpha = opaque,
                                     .textured = is_textured(s, o) || is_grained(s, o),
                                     .thin = is_thin(s, o),
                                     .bends = bends(o),
                                     .coated = is_coated(s, o),
                                     .grained = is_grained(s, o)};
        s->materials[i].shines = can_shine(s, &s->materials[i]);
        s->needs_footprint |= common->bump.texture.index1 != 0;
    }
    desc_init(&material_lambert.info, s->default_material);
    s->materials[materials->count] =
        (material){.type = &material_lambert, .desc = s->default_material, .opaque_alpha = true};
    return SNELL_OK;
}

typedef struct texture_job {
    texture *textures;
    _Atomic bool failed;
} texture_job;

static void prepare_texture(void *data, size_t index, uint32_t worker) {
    texture_job *job = data;
    (void)worker;
    if (texture_prepare(&job->textures[index])) job->failed = true;
}

static snell_status prepare_textures(scene *s, thread_pool *pool) {
    texture_job job = {.textures = s->textures};
    thread_pool_run(pool, s->texture_count, prepare_texture, &job);
    return job.failed ? error_no_memory() : SNELL_OK;
}

static void freeze_settings(scene *s, const description *d) {
    const object *background = description_setting(d, "background");
    const object *ambient = description_setting(d, "ambient");
    s->background_alpha = 1;
    if (background) {
        const background_desc *b = background->desc;
        s->background = s->background_top = dvec3_from(b->color);
        s->has_gradient = b->top.x >= 0 && b->top.y >= 0 && b->top.z >= 0;
        if (s->has_gradient) s->background_top = dvec3_from(b->top);
        s->background_alpha = (double)b->alpha;
    }
    if (ambient) s->ambient = dvec3_from(((const ambient_desc *)ambient->desc)->color);
    s->brightest_background =
        double_max(dvec3_largest(s->background), dvec3_largest(s->background_top));
    for (uint32_t i = 0; i < s->light_count; i++) { /* all around; not the small disk of a sun */
        const light *l = &s->lights[i];
        if (l->type->brightest)
            s->brightest_background = double_max(s->brightest_background, l->type->brightest(l));
    }
}

uint32_t instance_slot_count(const scene_instance *at) {
    if (solid_is(at->type)) return ((const solid_shape *)at->shape)->slot_count;
    if (!mesh_is(at->type)) return 1;
    const mesh_desc *mesh = at->shape;
    return mesh->material_slots_count ? (uint32_t)mesh->materials_count : 1;
}

uint32_t instance_slot(const scene_instance *at, uint32_t slot) {
    if (solid_is(at->type)) {
        uint32_t index = ((const solid_shape *)at->shape)->slots[slot];
        return index == NO_ID ? at->material : index;
    }
    if (!mesh_is(at->type)) return at->material;
    const mesh_desc *mesh = at->shape;
    return mesh->material_slots_count ? mesh->materials[slot].index1 - 1 : at->material;
}

static animation_desc clock_of(const description *d) {
    animation_desc clock;
    desc_init(&setting_animation, &clock);
    const object *said = description_setting(d, "animation");
    return said ? *(const animation_desc *)said->desc : clock;
}

void scene_shutter(const description *d, const camera_common *camera, double out[2]) {
    animation_desc clock = clock_of(d);
    double start = clock.frame - 1, fps = (double)clock.fps;
    out[0] = (start + (double)camera->shutter.x) / fps;
    out[1] = (start + (double)camera->shutter.y) / fps;
}

void scene_visible_time(const description *d, double out[2]) {
    const object_list *cameras = &d->objects[CATEGORY_CAMERA];
    out[0] = -INFINITY;
    out[1] = INFINITY;
    if (cameras->count == 0) return;
    perspective_desc usual;
    desc_init(&camera_perspective.info, &usual);
    scene_shutter(d, (const camera_common *)&usual, out);
    for (size_t i = 0; i < cameras->count; i++) {
        double times[2];
        scene_shutter(d, cameras->items[i].desc, times);
        out[0] = double_min(out[0], times[0]);
        out[1] = double_max(out[1], times[1]);
    }
}

/* The time that the cameras may see, and whether they can move as they are told. */
static snell_status freeze_clock(scene *s, const description *d) {
    const object_list *cameras = &d->objects[CATEGORY_CAMERA];
    double times[2];
    scene_visible_time(d, times);
    s->time_open = times[0];
    s->time_close = times[1];
    s->frame_length = 1 / (double)clock_of(d).fps;
    for (size_t i = 0; i < cameras->count; i++) {
        const camera_common *camera = cameras->items[i].desc;
        motion unused;
        if (camera->motion_count == 0) continue;
        scene_shutter(d, camera, times);
        snell_status status =
            motion_prepare(camera->motion, camera->motion_count, times[0], times[1], &unused);
        if (status) {
            error_place((source_place){cameras->items[i].file, cameras->items[i].line, 0});
            return status;
        }
        motion_free(&unused);
    }
    return SNELL_OK;
}

snell_status scene_freeze(const description *d, const scene_options *options, thread_pool *pool,
                          scene **out) {
    scene *s = memory_zeroed(1, sizeof *s);
    if (s == NULL) return error_no_memory();
    snell_status status = freeze_objects(s, d);
    if (!status) status = prepare_textures(s, pool);
    if (!status) status = freeze_light_objects(s, &d->objects[CATEGORY_LIGHT], pool);
    if (!status) freeze_settings(s, d);
    if (!status) status = freeze_clock(s, d);
    if (!status) status = scene_freeze_geometry(s, d, options, pool);
    if (status)
        scene_destroy(s);
    else
        *out = s;
    return status;
}

void scene_destroy(scene *s) {
    if (s == NULL) return;
    accel_destroy(s->accel);
    scene_free_lights(s);
    for (uint32_t i = 0; i < s->light_count; i++)
        if (s->lights[i].type->release) s->lights[i].type->release(s->lights[i].state);
    for (uint32_t i = 0; i < s->body_count; i++) {
        desc_free(&s->bodies[i].shape.type->info, s->bodies[i].shape.desc);
        desc_free(&material_lambert.info, s->bodies[i].material_desc);
    }
    free(s->bodies);
    for (uint32_t i = 0; s->textures && i < s->texture_count; i++) texture_destroy(&s->textures[i]);
    free(s->textures);
    free(s->materials);
    free(s->default_material);
    free(s->lights);
    for (size_t i = 0; s->prepared && i < s->prepared_count; i++)
        if (s->prepared[i].made) s->prepared[i].type->release(s->prepared[i].made);
    free(s->prepared);
    free(s->instances);
    free(s->instance_ids);
    solid_set_destroy(s->solids);
    free(s->groups);
    for (uint32_t i = 0; i < s->motion_count; i++) motion_free(&s->motions[i]);
    free(s->motions);
    free(s);
}

size_t scene_texture_memory(const scene *s) {
    size_t bytes = 0;
    for (uint32_t i = 0; i < s->texture_count; i++) {
        const texture *t = &s->textures[i];
        if (t->state) bytes += t->type->state_size(t->state);
    }
    return bytes;
}

dvec3 scene_background(const scene *s, dvec3 direction) {
    if (!s->has_gradient) return s->background;
    double t = clamp01((1 + direction.y) / 2);
    return dvec3_add(dvec3_scale(s->background, 1 - t), dvec3_scale(s->background_top, t));
}

void scene_shade_point(const scene *s, const ray *r, const hit *h, shade_point *out) {
    posed_instance room;
    const scene_instance *at;
    const void *shape;
    local_ray beam;
    if (s->group_count) {
        shape_path path;
        scene_find_path(s, h->instance, r->time, &path);
        beam = shape_path_ray(&path, r);
        at = path.levels[path.count - 1];
        shape = deforming_pose(at->type, at->shape, r->time, &room.shape);
    } else {
        at = scene_posed(s, h->instance, r->time, &room);
        shape = at->shape;
        beam = local_ray_make(r, &at->to_local, at->identity);
    }
    surface here;
    at->type->surface(shape, &beam, h, &here);
    dvec3 wo = dvec3_normalize(dvec3_negate(dvec3_from(r->d)));
    scene_surface_point(s, h->instance, h->primitive, r->time, &here, wo, out);
}

static bool has_uv(const scene_instance *at, uint32_t primitive) {
    if (solid_is(at->type)) return solid_find_part(at->shape, primitive)->has_uv;
    if (mesh_is(at->type)) return ((const mesh_desc *)at->shape)->uvs_count != 0;
    return !at->type->unbounded;
}

/* What only textures and bump look at: most materials have none, and this is most of a point. */
static void set_place(const surface *local, const surface *world, bool has_coordinates,
                      shade_point *out) {
    const dvec3 none = {0, 0, 0};
    texture_point *place = &out->at.at;
    place->u = local->u;
    place->v = local->v;
    place->has_uv = has_coordinates;
    place->local = local->p;
    place->n = local->n;
    place->dpdu = local->dpdu;
    place->dpdv = local->dpdv;
    place->dpdx = none;
    place->dpdy = none;
    place->dudx = place->dvdx = place->dudy = place->dvdy = 0;
    out->at.tangent = out->at.bitangent = none;
    out->dpdu = world->dpdu;
    out->dpdv = world->dpdv;
}

mesh_corners scene_mesh_corners(const scene_instance *at, float time, uint32_t triangle) {
    deforming_mesh room;
    if (at->type != &primitive_deforming) return mesh_corners_of(at->shape, triangle);
    return deforming_corners(deforming_pose(at->type, at->shape, time, &room), triangle);
}

static void set_second_uv(const scene_instance *at, float time, uint32_t triangle,
                          texture_point *place) {
    const mesh_desc *mesh = at->shape;
    mesh_corners corners;
    double weight[3], uv[2];
    place->has_uv2 = false;
    if (!mesh_is(at->type) || mesh->uvs2_count == 0) return;
    corners = scene_mesh_corners(at, time, triangle);
    if (!mesh_point_weights(&corners, place->local, weight)) return;
    mesh_second_uv(mesh, triangle, &corners, weight, uv, &place->dpdu2, &place->dpdv2);
    place->has_uv2 = true;
    place->u2 = uv[0];
    place->v2 = uv[1];
}

/* Through every level of groups; dpdu and dpdv only for those who look at them. */
static void bring_to_world(const scene_instance *at, const shape_path *path, bool tangents,
                           surface *on) {
    if (path->count) {
        shape_path_surface(path, on);
    } else if (!at->identity) {
        surface_to_world(on, &at->to_world, &at->to_local);
        if (tangents) surface_tangents_to_world(on, &at->to_world);
    }
}

void scene_surface_point(const scene *s, uint32_t id, uint32_t primitive, float time, surface *on,
                         dvec3 wo, shade_point *out) {
    posed_instance room;
    const scene_instance *at;
    shape_path path;
    path.count = 0;
    if (s->group_count) {
        scene_find_path(s, id, time, &path);
        at = path.levels[path.count - 1];
    } else {
        at = scene_posed(s, id, time, &room);
    }
    const material *made_of = &s->materials[instance_slot(at, on->material_slot)];
    if (made_of->textured) {
        if (at->type->parametrise) at->type->parametrise(at->shape, on);
        surface local = *on;
        bring_to_world(at, &path, true, on);
        set_place(&local, on, has_uv(at, primitive), out);
        set_second_uv(at, time, primitive, &out->at.at);
    } else {
        bring_to_world(at, &path, false, on);
    }
    bool outside = dvec3_dot(on->n, wo) >= 0;
    /* One field after the other, as in surface_make. */
    out->p = on->p;
    out->wo = wo;
    out->n = outside ? on->n : dvec3_negate(on->n);
    out->ns = outside ? on->ns : dvec3_negate(on->ns);
    out->outside = outside;
    out->clearance = on->error;
    out->instance = id;
    out->primitive = primitive;
    out->time = time;
    out->flat = at->type->flat;
    out->material = made_of;
    out->curvature = on->curvature;
    out->has_footprint = false;
    out->at.tint = on->tint;
    out->at.alpha = on->alpha;
    out->at.outside = outside;
    out->at.coat.own = false;
    out->at.textures = s->textures;
    out->at.materials = s->materials;
    /* A shading normal that faces away from the eye would reflect through the surface. */
    if (!(dvec3_dot(out->ns, wo) > 0)) out->ns = out->n;
}

void scene_spawn_ray(const shade_point *point, dvec3 d, float t_max, ray *out) {
    scene_start_ray(point, scene_origin(point, dvec3_dot(point->n, d) > 0), vec3_from(d), t_max,
                    out);
}
