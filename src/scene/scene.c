#include "scene/scene.h"

#include <stdlib.h>

#include "base/memory.h"
#include "geometry/mesh.h"
#include "geometry/surface.h"
#include "scene/lights.h"
#include "scene/settings.h"

/* The grey Lambert of shapes without a material: its desc with every default. */
extern const material_type material_lambert;

/* Does it, or the material that it refers to (an earlier one), use a texture? */
static bool is_textured(const scene *s, const object *o) {
    for (uint32_t i = 0; i < o->type->field_count; i++) {
        const field *f = &o->type->fields[i];
        const void *at = (const char *)o->desc + f->offset;
        if ((f->kind == FIELD_INPUT || f->kind == FIELD_SCALAR) &&
            ((const snell_input *)at)->texture.index1)
            return true;
        if (f->kind == FIELD_TEXTURE && ((const snell_texture_id *)at)->index1) return true;
        if (f->kind == FIELD_MATERIAL) {
            uint32_t base = ((const snell_material_id *)at)->index1;
            if (base && s->materials[base - 1].textured) return true;
        }
    }
    return false;
}

static bool is_thin(const scene *s, const object *o) {
    const material_type *type = (const material_type *)o->type;
    if (type->is_thin) return type->is_thin(o->desc);
    for (uint32_t i = 0; i < o->type->field_count; i++) {
        if (o->type->fields[i].kind != FIELD_MATERIAL) continue;
        const char *at = (const char *)o->desc + o->type->fields[i].offset;
        uint32_t part = ((const snell_material_id *)(const void *)at)->index1;
        if (part && s->materials[part - 1].thin) return true;
    }
    return false;
}

/* Some materials are as opaque as those that they are made of (earlier ones). */
static bool has_opaque_parts(const scene *s, const object *o) {
    if (((const material_type *)o->type)->opacity == NULL) return true;
    for (uint32_t i = 0; i < o->type->field_count; i++) {
        if (o->type->fields[i].kind != FIELD_MATERIAL) continue;
        const char *at = (const char *)o->desc + o->type->fields[i].offset;
        uint32_t part = ((const snell_material_id *)(const void *)at)->index1;
        if (part && !s->materials[part - 1].opaque_alpha) return false;
    }
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
static snell_status freeze_light_objects(scene *s, const object_list *lights) {
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
            *l = (light){type, o->desc, NULL, s->textures};
            if (type->prepare) status = type->prepare(o->desc, s->textures, &l->state);
        }
        if (status) return status;
    }
    return SNELL_OK;
}

/* Without a texture the height is the same everywhere. */
static bool bends(const material_common *m) {
    return m->normal_map.index1 || m->bump.texture.index1;
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
                                     .textured = is_textured(s, o),
                                     .thin = is_thin(s, o),
                                     .bends = bends(common)};
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
}

/* What shadow rays make of a material: MASK_OPAQUE, MASK_FILTER or MASK_NO_SHADOW. */
static uint32_t shadow_mask(const material *m) {
    const material_common *common = m->desc;
    if (common->shadow == SHADOW_NONE) return MASK_NO_SHADOW;
    if (common->shadow == SHADOW_OPAQUE) return MASK_OPAQUE;
    bool filters = material_bounds_medium(m->type, m->desc) || m->thin || !m->opaque_alpha;
    return filters ? MASK_FILTER : MASK_OPAQUE;
}

/* A mesh of several materials is a filter as soon as one of them is: the walk looks at each
 * triangle. */
static uint32_t instance_mask(const scene *s, const scene_instance *at) {
    uint32_t mask = shadow_mask(&s->materials[at->material]);
    if (at->type->intersect != NULL) return mask;
    const mesh_desc *mesh = at->shape;
    if (mesh->alphas_count) return MASK_FILTER;
    if (mesh->material_slots_count == 0) return mask;
    mask = shadow_mask(&s->materials[mesh->materials[0].index1 - 1]);
    for (size_t i = 0; i < mesh->materials_count; i++)
        if (shadow_mask(&s->materials[mesh->materials[i].index1 - 1]) != mask) return MASK_FILTER;
    return mask;
}

static bool bounds_medium(const scene *s, uint32_t index) {
    return material_bounds_medium(s->materials[index].type, s->materials[index].desc);
}

/* What is inside an instance: its material's medium, or that of the first slot that has one. */
static void find_medium(const scene *s, scene_instance *at) {
    uint32_t index = at->material;
    const mesh_desc *mesh = at->type->intersect == NULL ? at->shape : NULL;
    if (mesh && mesh->material_slots_count) {
        index = mesh->materials[0].index1 - 1;
        for (size_t i = 1; i < mesh->materials_count && !bounds_medium(s, index); i++)
            index = mesh->materials[i].index1 - 1;
    }
    const material *m = &s->materials[index];
    at->has_medium = bounds_medium(s, index);
    at->medium_material = index;
    if (at->has_medium) at->inside = m->type->inside(m->desc);
}

/* There is room for a motion per instance. */
static snell_status freeze_motion(scene *s, const instance *from, scene_instance *at) {
    motion *m = &s->motions[s->motion_count];
    snell_status status =
        motion_prepare(from->keys, from->key_count, s->time_open, s->time_close, m);
    if (status) return status;
    s->motion_count++;
    at->to_world = m->steps[0].transform;
    if (m->count == 1) { /* it stands still while anyone looks */
        at->identity = transform_is_identity(&at->to_world);
        return SNELL_OK;
    }
    at->moves = m;
    at->identity = false;
    return SNELL_OK;
}

/* What rays are traced against. */
static const void *shape_of(const scene *s, const object_list *shapes, size_t index) {
    void *prepared = s->shapes[index].prepared;
    return prepared ? prepared : shapes->items[index].desc;
}

static snell_status prepare_shapes(scene *s, const description *d) {
    const object_list *shapes = &d->objects[CATEGORY_SHAPE];
    s->shapes = memory_zeroed(shapes->count, sizeof *s->shapes);
    if (s->shapes == NULL) return error_no_memory();
    s->shape_count = shapes->count;
    for (size_t i = 0; i < d->instance_count; i++) {
        if (d->instances[i].removed) continue;
        uint32_t index = d->instances[i].shape;
        const primitive_type *type = (const primitive_type *)shapes->items[index].type;
        prepared_shape *to = &s->shapes[index];
        if (type->prepare == NULL || to->prepared) continue;
        *to = (prepared_shape){type, type->prepare(shapes->items[index].desc)};
        if (to->prepared == NULL) return error_no_memory();
    }
    return SNELL_OK;
}

static snell_status freeze_instances(scene *s, const description *d, accel_instance *out) {
    uint32_t count = 0;
    for (size_t i = 0; i < d->instance_count; i++) {
        const instance *from = &d->instances[i];
        if (from->removed) continue;
        const object *shape = &d->objects[CATEGORY_SHAPE].items[from->shape];
        scene_instance *at = &s->instances[count];
        *at = (scene_instance){.type = (const primitive_type *)shape->type,
                               .shape = shape_of(s, &d->objects[CATEGORY_SHAPE], from->shape),
                               .shape_index = from->shape,
                               .material = from->material == NO_MATERIAL ? s->material_count
                                                                         : from->material,
                               .identity = transform_is_identity(&from->to_world),
                               .to_world = from->to_world};
        if (from->key_count) {
            snell_status status = freeze_motion(s, from, at);
            if (status) {
                error_place((source_place){shape->file, from->line, 0});
                return status;
            }
        }
        if (!transform_inverse(&at->to_world, &at->to_local))
            return error_set_at(SNELL_ERR_ARGUMENT, (source_place){shape->file, from->line, 0},
                                "a scale of 0 squashes the shape flat",
                                "%s: the transform cannot be inverted", shape->type->name);
        find_medium(s, at);
        out[count] = (accel_instance){.geometry = from->shape,
                                      .mask = instance_mask(s, at),
                                      .identity = at->identity,
                                      .to_world = at->to_world,
                                      .to_local = at->to_local,
                                      .moves = at->moves};
        s->has_filters |= out[count].mask == MASK_FILTER || at->has_medium;
        s->has_unshadowing |= out[count].mask == MASK_NO_SHADOW;
        s->has_media |= at->has_medium;
        s->instance_ids[count++] = (uint32_t)i;
    }
    s->instance_count = count;
    return SNELL_OK;
}

/* The shapes of lights stand behind all others. */
static void freeze_bodies(scene *s, uint32_t shape_count, accel_geometry *geometries,
                          accel_instance *instances) {
    for (uint32_t i = 0; i < s->body_count; i++) {
        const light_shape *shape = &s->bodies[i].shape;
        uint32_t index = s->instance_count++;
        geometries[shape_count + i] = (accel_geometry){shape->type, shape->desc};
        s->instances[index] = (scene_instance){.type = shape->type,
                                               .shape = shape->desc,
                                               .shape_index = NO_ID,
                                               .material = s->material_count + 1 + i,
                                               .hidden_light = !shape->visible,
                                               .identity = true,
                                               .to_world = transform_identity(),
                                               .to_local = transform_identity()};
        s->instance_ids[index] = NO_ID;
        instances[index] = (accel_instance){.geometry = shape_count + i,
                                            .mask = shape->visible ? MASK_LIGHT : MASK_LIGHT_HIDDEN,
                                            .identity = true,
                                            .to_world = transform_identity(),
                                            .to_local = transform_identity()};
    }
}

static snell_status freeze_geometry(scene *s, const description *d, const scene_options *options,
                                    thread_pool *pool) {
    const object_list *shapes = &d->objects[CATEGORY_SHAPE];
    size_t most = d->instance_count + s->body_count;
    accel_geometry *geometries = memory_zeroed(shapes->count + s->body_count, sizeof *geometries);
    accel_instance *instances = memory_zeroed(most, sizeof *instances);
    s->instances = memory_zeroed(most, sizeof *s->instances);
    s->instance_ids = memory_zeroed(most, sizeof *s->instance_ids);
    size_t moving = 0;
    for (size_t i = 0; i < d->instance_count; i++) moving += d->instances[i].key_count != 0;
    s->motions = memory_zeroed(moving, sizeof *s->motions);
    snell_status status = SNELL_OK;
    if (!geometries || !instances || !s->instances || !s->instance_ids || !s->motions)
        status = error_no_memory();
    if (!status) status = prepare_shapes(s, d);
    if (!status) status = freeze_instances(s, d, instances);
    if (!status) {
        for (size_t i = 0; i < shapes->count; i++)
            geometries[i] = (accel_geometry){(const primitive_type *)shapes->items[i].type,
                                             shape_of(s, shapes, i)};
        freeze_bodies(s, (uint32_t)shapes->count, geometries, instances);
        accel_input input = {geometries, shapes->count + s->body_count, instances,
                             s->instance_count};
        status = accel_build(&input, &options->accel, pool, &s->accel);
    }
    if (!status) s->bounds = accel_bounds(s->accel);
    if (!status) status = scene_freeze_lights(s);
    free(geometries);
    free(instances);
    return status;
}

void scene_shutter(const description *d, const camera_common *camera, double out[2]) {
    animation_desc clock;
    desc_init(&setting_animation, &clock);
    const object *said = description_setting(d, "animation");
    if (said) clock = *(const animation_desc *)said->desc;
    double start = clock.frame - 1, fps = (double)clock.fps;
    out[0] = (start + (double)camera->shutter.x) / fps;
    out[1] = (start + (double)camera->shutter.y) / fps;
}

/* The time that the cameras may see, with that of a camera by value with the usual shutter; and
 * whether they can move as they are told. */
static snell_status freeze_clock(scene *s, const description *d) {
    const object_list *cameras = &d->objects[CATEGORY_CAMERA];
    s->time_open = -INFINITY;
    s->time_close = INFINITY;
    if (cameras->count == 0) return SNELL_OK;
    double times[2];
    perspective_desc usual;
    desc_init(&camera_perspective.info, &usual);
    scene_shutter(d, (const camera_common *)&usual, times);
    s->time_open = times[0];
    s->time_close = times[1];
    for (size_t i = 0; i < cameras->count; i++) {
        const camera_common *camera = cameras->items[i].desc;
        scene_shutter(d, camera, times);
        s->time_open = double_min(s->time_open, times[0]);
        s->time_close = double_max(s->time_close, times[1]);
        motion unused;
        if (camera->motion_count == 0) continue;
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
    if (!status) status = freeze_light_objects(s, &d->objects[CATEGORY_LIGHT]);
    if (!status) freeze_settings(s, d);
    if (!status) status = freeze_clock(s, d);
    if (!status) status = freeze_geometry(s, d, options, pool);
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
    for (size_t i = 0; s->shapes && i < s->shape_count; i++)
        if (s->shapes[i].prepared) s->shapes[i].type->release(s->shapes[i].prepared);
    free(s->shapes);
    free(s->instances);
    free(s->instance_ids);
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

transform scene_instance_transform(const scene *s, uint32_t index, float time) {
    const scene_instance *at = &s->instances[index];
    return at->moves ? motion_transform(at->moves, time) : at->to_world;
}

dvec3 scene_background(const scene *s, dvec3 direction) {
    if (!s->has_gradient) return s->background;
    double t = clamp01((1 + direction.y) / 2);
    return dvec3_add(dvec3_scale(s->background, 1 - t), dvec3_scale(s->background_top, t));
}

const scene_instance *scene_posed(const scene_instance *at, float time, scene_instance *moved) {
    if (at->moves == NULL) return at;
    *moved = *at;
    motion_at(at->moves, time, &moved->to_world, &moved->to_local);
    return moved;
}

void scene_shade_point(const scene *s, const ray *r, const hit *h, shade_point *out) {
    scene_instance moved;
    const scene_instance *at = scene_posed(&s->instances[h->instance], r->time, &moved);
    local_ray beam = local_ray_make(r, &at->to_local, at->identity);
    surface here;
    at->type->surface(at->shape, &beam, h, &here);
    dvec3 wo = dvec3_normalize(dvec3_negate(dvec3_from(r->d)));
    scene_surface_point(s, h->instance, h->primitive, r->time, &here, wo, out);
}

void scene_surface_point(const scene *s, uint32_t id, uint32_t primitive, float time, surface *on,
                         dvec3 wo, shade_point *out) {
    scene_instance moved;
    const scene_instance *at = scene_posed(&s->instances[id], time, &moved);
    if (at->type->parametrise && s->materials[at->material].textured)
        at->type->parametrise(at->shape, on);
    dvec3 local = on->p, local_n = on->n, local_u = on->dpdu, local_v = on->dpdv;
    if (!at->identity) surface_to_world(on, &at->to_world, &at->to_local);
    uint32_t index = at->material;
    bool has_uv = true;
    if (at->type->intersect == NULL) {
        const mesh_desc *mesh = at->shape;
        if (mesh->material_slots_count) index = mesh->materials[on->material_slot].index1 - 1;
        has_uv = mesh->uvs_count != 0;
    }
    bool outside = dvec3_dot(on->n, wo) >= 0;
    *out = (shade_point){.p = on->p,
                         .wo = wo,
                         .n = outside ? on->n : dvec3_negate(on->n),
                         .ns = outside ? on->ns : dvec3_negate(on->ns),
                         .outside = outside,
                         .clearance = on->error,
                         .instance = id,
                         .primitive = primitive,
                         .time = time,
                         .flat = at->type->flat,
                         .material = &s->materials[index],
                         .dpdu = on->dpdu,
                         .dpdv = on->dpdv,
                         .curvature = on->curvature,
                         .at = {.at = {.u = on->u,
                                       .v = on->v,
                                       .has_uv = has_uv && !at->type->unbounded,
                                       .local = local,
                                       .n = local_n,
                                       .dpdu = local_u,
                                       .dpdv = local_v},
                                .tint = on->tint,
                                .alpha = on->alpha,
                                .outside = outside,
                                .textures = s->textures,
                                .materials = s->materials}};
    /* A shading normal that faces away from the eye would reflect through the surface. */
    if (!(dvec3_dot(out->ns, wo) > 0)) out->ns = out->n;
}

ray scene_spawn_ray(const shade_point *point, dvec3 d, float t_max) {
    surface here = surface_make(point->p, point->n, point->clearance);
    vec3 o = surface_offset_origin(&here, dvec3_dot(point->n, d));
    ray r = ray_make(o, vec3_from(d), 0, t_max);
    if (point->flat) {
        r.skip_instance = point->instance;
        r.skip_primitive = point->primitive;
    }
    return r;
}
