#include "scene/scene.h"

#include <stdlib.h>

#include "base/memory.h"
#include "geometry/mesh.h"
#include "geometry/surface.h"
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

static snell_status freeze_objects(scene *s, const description *d) {
    const object_list *textures = &d->objects[CATEGORY_TEXTURE];
    const object_list *materials = &d->objects[CATEGORY_MATERIAL];
    const object_list *lights = &d->objects[CATEGORY_LIGHT];
    s->textures = memory_zeroed(textures->count, sizeof *s->textures);
    s->materials = memory_zeroed(materials->count + 1, sizeof *s->materials);
    s->lights = memory_zeroed(lights->count, sizeof *s->lights);
    s->default_material = memory_zeroed(1, material_lambert.info.desc_size);
    if (!s->textures || !s->materials || !s->lights || !s->default_material)
        return error_no_memory();
    s->texture_count = (uint32_t)textures->count;
    s->material_count = (uint32_t)materials->count;
    s->light_count = (uint32_t)lights->count;
    for (size_t i = 0; i < textures->count; i++) {
        const object *o = &textures->items[i];
        s->textures[i] = (texture){(const texture_type *)o->type, o->desc};
    }
    for (size_t i = 0; i < materials->count; i++) {
        const object *o = &materials->items[i];
        const material_common *common = o->desc;
        bool opaque = common->alpha.texture.index1 == 0 && common->alpha.value.x >= 1 &&
                      has_opaque_parts(s, o);
        s->materials[i] = (material){(const material_type *)o->type, o->desc, opaque,
                                     is_textured(s, o), is_thin(s, o)};
    }
    for (size_t i = 0; i < lights->count; i++) {
        const object *o = &lights->items[i];
        s->lights[i] = (light){(const light_type *)o->type, o->desc};
    }
    desc_init(&material_lambert.info, s->default_material);
    s->materials[materials->count] =
        (material){&material_lambert, s->default_material, true, false, false};
    return SNELL_OK;
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

static snell_status freeze_instances(scene *s, const description *d, accel_instance *out) {
    uint32_t count = 0;
    for (size_t i = 0; i < d->instance_count; i++) {
        const instance *from = &d->instances[i];
        if (from->removed) continue;
        const object *shape = &d->objects[CATEGORY_SHAPE].items[from->shape];
        scene_instance *at = &s->instances[count];
        *at = (scene_instance){.type = (const primitive_type *)shape->type,
                               .shape = shape->desc,
                               .shape_index = from->shape,
                               .material = from->material == NO_MATERIAL ? s->material_count
                                                                         : from->material,
                               .identity = transform_is_identity(&from->to_world),
                               .to_world = from->to_world};
        if (!transform_inverse(&at->to_world, &at->to_local))
            return error_set_at(SNELL_ERR_ARGUMENT, (source_place){shape->file, from->line, 0},
                                "a scale of 0 squashes the shape flat",
                                "%s: the transform cannot be inverted", shape->type->name);
        find_medium(s, at);
        out[count] = (accel_instance){.geometry = from->shape,
                                      .mask = instance_mask(s, at),
                                      .identity = at->identity,
                                      .to_world = at->to_world,
                                      .to_local = at->to_local};
        s->has_filters |= out[count].mask == MASK_FILTER || at->has_medium;
        s->has_media |= at->has_medium;
        s->instance_ids[count++] = (uint32_t)i;
    }
    s->instance_count = count;
    return SNELL_OK;
}

static snell_status freeze_geometry(scene *s, const description *d, const scene_options *options,
                                    thread_pool *pool) {
    const object_list *shapes = &d->objects[CATEGORY_SHAPE];
    accel_geometry *geometries = memory_zeroed(shapes->count, sizeof *geometries);
    accel_instance *instances = memory_zeroed(d->instance_count, sizeof *instances);
    s->instances = memory_zeroed(d->instance_count, sizeof *s->instances);
    s->instance_ids = memory_zeroed(d->instance_count, sizeof *s->instance_ids);
    snell_status status = SNELL_OK;
    if (!geometries || !instances || !s->instances || !s->instance_ids) status = error_no_memory();
    if (!status) status = freeze_instances(s, d, instances);
    if (!status) {
        for (size_t i = 0; i < shapes->count; i++)
            geometries[i] = (accel_geometry){(const primitive_type *)shapes->items[i].type,
                                             shapes->items[i].desc};
        accel_input input = {geometries, shapes->count, instances, s->instance_count};
        status = accel_build(&input, &options->accel, pool, &s->accel);
    }
    if (!status) s->bounds = accel_bounds(s->accel);
    free(geometries);
    free(instances);
    return status;
}

snell_status scene_freeze(const description *d, const scene_options *options, thread_pool *pool,
                          scene **out) {
    scene *s = memory_zeroed(1, sizeof *s);
    if (s == NULL) return error_no_memory();
    snell_status status = freeze_objects(s, d);
    if (!status) freeze_settings(s, d);
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
    free(s->textures);
    free(s->materials);
    free(s->default_material);
    free(s->lights);
    free(s->instances);
    free(s->instance_ids);
    free(s);
}

dvec3 scene_background(const scene *s, dvec3 direction) {
    if (!s->has_gradient) return s->background;
    double t = clamp01((1 + direction.y) / 2);
    return dvec3_add(dvec3_scale(s->background, 1 - t), dvec3_scale(s->background_top, t));
}

void scene_shade_point(const scene *s, const ray *r, const hit *h, shade_point *out) {
    const scene_instance *at = &s->instances[h->instance];
    local_ray beam = local_ray_make(r, &at->to_local, at->identity);
    surface here;
    at->type->surface(at->shape, &beam, h, &here);
    if (at->type->parametrise && s->materials[at->material].textured)
        at->type->parametrise(at->shape, &here);
    dvec3 local = here.p, local_n = here.n;
    if (!at->identity) surface_to_world(&here, &at->to_world, &at->to_local);
    uint32_t index = at->material;
    bool has_uv = true;
    if (at->type->intersect == NULL) {
        const mesh_desc *mesh = at->shape;
        if (mesh->material_slots_count) index = mesh->materials[here.material_slot].index1 - 1;
        has_uv = mesh->uvs_count != 0;
    }
    dvec3 wo = dvec3_normalize(dvec3_negate(dvec3_from(r->d)));
    bool outside = dvec3_dot(here.n, wo) >= 0;
    *out =
        (shade_point){.p = here.p,
                      .wo = wo,
                      .n = outside ? here.n : dvec3_negate(here.n),
                      .ns = outside ? here.ns : dvec3_negate(here.ns),
                      .outside = outside,
                      .clearance = here.error,
                      .instance = h->instance,
                      .primitive = h->primitive,
                      .flat = at->type->flat,
                      .material = &s->materials[index],
                      .at = {.at = {here.u, here.v, has_uv && !at->type->unbounded, local, local_n},
                             .tint = here.tint,
                             .alpha = here.alpha,
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
