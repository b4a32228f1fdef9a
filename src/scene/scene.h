/* The frozen scene: a description made ready for rays. It borrows the description's data, which
 * must outlive it and of which nothing that it refers to changes (instances may be edited: they are
 * copied). Read by any number of threads. */
#ifndef SNELL_SCENE_SCENE_H
#define SNELL_SCENE_SCENE_H

#include "accel/accel.h"
#include "cameras/camera.h"
#include "geometry/deforming.h"
#include "lights/light.h"
#include "lights/tree.h"
#include "materials/material.h"
#include "geometry/surface.h"
#include "scene/description.h"
#include "scene/solids.h"

/* Bits of accel_instance.mask: by what a shadow ray makes of the instance; and the shapes of lights,
 * which the caller's own rays pass: those that the camera sees, which cast shadows too, and those
 * that it does not. */
enum {
    MASK_OPAQUE = 1,
    MASK_FILTER = 2,
    MASK_NO_SHADOW = 4,
    MASK_ALL = 7,
    MASK_LIGHT = 8,
    MASK_LIGHT_HIDDEN = 16
};

typedef struct scene_instance {
    const primitive_type *type; /* of the shape */
    const void *shape;          /* its desc, or what was prepared from it */
    uint32_t shape_index;
    uint32_t material; /* index into materials; slots of a mesh or a solid choose others */
    bool identity;
    transform to_world, to_local; /* where it moves: at the first of its steps */
    const motion *moves;          /* NULL: it stands still while a shutter is open */
    const motion *motion;         /* NULL: it never moves */
    bool has_medium;
    medium inside;            /* of its dielectric: what has several, the first one's */
    uint32_t medium_material; /* which that is */
    bool similar;      /* to_world keeps angles, so solid angles are the same in both spaces */
    bool hidden_light; /* the shape of a light that the camera does not see */
    bool shines;       /* it, or something in it, can be sampled as a light */
    bool bounds_half;  /* it, or something in it, has no end and a medium */
    uint32_t group;    /* index into groups; NO_ID: a shape */
    uint32_t first;    /* number of its first shape in the world, or in the group it is part of */
} scene_instance;

/* Room for an instance as it is at a time: where it stands, and its shape if that deforms. */
typedef struct posed_instance {
    scene_instance at;
    deforming_mesh shape;
} posed_instance;

/* What is drawn together, wherever an instance of it stands. A group of the description is one of
 * these for each way in which materials reach its parts from outside. */
typedef struct scene_group {
    uint32_t shape_index;
    uint32_t forced, usual; /* materials from outside: over all, and for what has none; or NO_ID */
    uint32_t first_part, part_count; /* in instances */
    uint32_t shape_count;            /* as if what is in it were flattened */
    uint32_t mask;                   /* of all that is in it */
    bool shines, bounds_half;
    uint32_t next; /* of the same shape, in groups; NO_ID: the last */
} scene_group;

/* A shape, or a triangle, that shines. */
typedef struct emitter {
    uint32_t instance, primitive;
    double area; /* in the shape's own space, m^2; where it deforms, the largest at a key */
    double sum;  /* of the weights of its light's emitters up to this one, 1 at the last */
} emitter;

/* The emitters of one instance. Of a shape without an area it is one, found by a ray (scene/seen.h):
 * in the ball about `middle`, in the shape's own space. */
typedef struct surface_light {
    uint32_t instance, first_emitter, emitter_count;
    bool seen;
    double radius;
    dvec3 middle;
} surface_light;

/* The shape of a registry light, which stands behind the description's. */
typedef struct light_body {
    light_shape shape;
    void *material_desc;
} light_body;

typedef struct scene {
    texture *textures;
    material *materials;    /* [material_count] is the grey Lambert of shapes without one */
    light *lights;          /* that are not surfaces */
    light_body *bodies;     /* of those that are; materials[material_count + 1 + i] is body i's */
    void *default_material; /* the desc of materials[material_count] */
    uint32_t texture_count, material_count, light_count, body_count;
    emitter *emitters;             /* by instance, then by primitive */
    surface_light *surface_lights; /* by instance */
    uint32_t emitter_count, surface_light_count;
    light_tree *tree; /* over the lights that are somewhere (`placed`), then the emitters */
    uint32_t *placed, *nowhere; /* registry lights */
    uint32_t placed_count, nowhere_count;
    prepared_shape *prepared; /* of the description's shapes */
    size_t prepared_count;
    /* Those of the world, then the parts of groups. What a hit calls its instance is the number of a
     * shape, counted as if all groups were flattened: without groups it is an index. */
    scene_instance *instances;
    uint32_t *instance_ids; /* index in the description of each; NO_ID: the shape of a light */
    uint32_t instance_count, part_count; /* of the world, and of all */
    scene_group *groups;
    uint32_t group_count, shape_count; /* drawn shapes */
    solid_set *solids;
    motion *motions; /* of the instances that move, one after the other */
    uint32_t motion_count;
    bool changes; /* something moves or deforms */
    /* What the motions were clipped to, seconds; -INFINITY, INFINITY without a camera. */
    double time_open, time_close;
    double frame_length; /* of the animation, seconds */
    accel *accel;
    bounds3 bounds; /* without planes */
    dvec3 background, background_top, ambient;
    bool has_gradient;
    double background_alpha;
    double brightest_background; /* its largest component anywhere, or that of an
                                    environment */
    bool has_filters;            /* some shadow rays pass through surfaces */
    bool has_unshadowing;        /* something casts no shadow */
    bool has_media;
    bool needs_footprint; /* some texture is filtered: rays carry differentials */
} scene;

typedef struct scene_options {
    accel_options accel;
    uint64_t memory_max; /* bytes that freezing the geometry may take; 0: not limited */
} scene_options;

/* What freezing the geometry takes at most, with what is left of it, in bytes; without the description
 * and without lights and motions. Each group is counted once, though it is frozen for each way in which
 * materials reach it from outside. */
uint64_t scene_plan_memory(const description *d, uint32_t threads);

snell_status scene_freeze(const description *d, const scene_options *options, thread_pool *pool,
                          scene **out);
void scene_destroy(scene *s);
size_t scene_texture_memory(const scene *s);             /* bytes, beyond the description's */
dvec3 scene_background(const scene *s, dvec3 direction); /* direction: unit */

/* When a camera's shutter opens and closes, in seconds on the scene's clock. */
void scene_shutter(const description *d, const camera_common *camera, double out[2]);
/* All that the cameras may see, and a camera by value with the usual shutter; -INFINITY to INFINITY
 * without a camera. */
void scene_visible_time(const description *d, double out[2]);
/* The instances on the way down to a shape, the world's first, as they stand at a time. */
typedef struct shape_path {
    uint32_t count;
    const scene_instance *levels[GROUP_DEPTH_MAX + 1];
    transform to_world[GROUP_DEPTH_MAX + 1], to_local[GROUP_DEPTH_MAX + 1]; /* one level up, down */
} shape_path;
void scene_find_path(const scene *s, uint32_t number, float time, shape_path *out);
/* The ray in the shape's own space, as the kernels see it; a surface of the shape in the world. */
local_ray shape_path_ray(const shape_path *path, const ray *r);
void shape_path_surface(const shape_path *path, surface *on);
/* The box that holds a box of the shape's own space wherever it moves. */
bounds3 shape_path_bounds(const shape_path *path, bounds3 own);
/* What shape `number` is, without its place: the last of its path. */
const scene_instance *scene_find_part(const scene *s, uint32_t number);
static inline const scene_instance *scene_part(const scene *s, uint32_t number) {
    return s->group_count ? scene_find_part(s, number) : &s->instances[number];
}
/* Shape `number` as it stands at a time in the world: itself, or where it moves, deforms or is in a
 * group *room, made from it. (A group's rays go down level by level: shape_path.) */
const scene_instance *scene_pose(const scene *s, uint32_t number, float time, posed_instance *room);
static inline const scene_instance *scene_posed(const scene *s, uint32_t number, float time,
                                                posed_instance *room) {
    if (s->group_count) return scene_pose(s, number, time, room);
    const scene_instance *at = &s->instances[number];
    bool stands = at->moves == NULL && at->type != &primitive_deforming;
    return stands ? at : scene_pose(s, number, time, room);
}
/* Where the shape is at the time. */
transform scene_instance_transform(const scene *s, uint32_t number, float time);
/* Calls back for each shape of which is_wanted holds, as it does for the groups around it. */
typedef snell_status scene_shape_fn(void *user, uint32_t number, const scene_instance *part);
snell_status scene_each_shape(const scene *s, bool (*is_wanted)(const scene_instance *part),
                              scene_shape_fn *fn, void *user);

/* Everything about a hit that shading needs, in the world. */
typedef struct shade_point {
    dvec3 p;          /* on the surface */
    dvec3 wo;         /* unit, towards where the ray came from */
    dvec3 n, ns;      /* geometric and shading normal, unit, both on wo's side */
    bool outside;     /* wo is on the side of the outward normal */
    double clearance; /* a float origin this far from p, along n or -n, has certainly left the
                         surface */
    uint32_t instance, primitive;
    float time;
    bool flat; /* a ray that leaves here cannot hit (instance, primitive) again */
    const material *material;
    material_point at; /* where the material is looked up; at.at: if material->textured */
    /* If material->textured: of p by u, v; 0 where the shape has no smooth coordinates. */
    dvec3 dpdu, dpdv;
    double curvature; /* of the shape, in its own space (geometry/primitive.h) */
    /* Once scene_set_footprint was called: from this sample to the next to the right (x) and down (y), p
     * and ns; 0 where has_footprint is false. */
    dvec3 dpdx, dpdy, dndx, dndy;
    bool has_footprint;
} shade_point;

/* The materials of an instance, as surface.material_slot numbers them: indices into materials. */
uint32_t instance_slot_count(const scene_instance *at);
uint32_t instance_slot(const scene_instance *at, uint32_t slot);

void scene_shade_point(const scene *s, const ray *r, const hit *h, shade_point *out);
/* The same for a point `on` an instance's surface, in its own space, seen from direction wo (unit);
 * afterwards `on` is in the world. */
void scene_surface_point(const scene *s, uint32_t id, uint32_t primitive, float time, surface *on,
                         dvec3 wo, shade_point *out);
/* A triangle of an instance of a mesh, in its own space. */
mesh_corners scene_mesh_corners(const scene_instance *at, float time, uint32_t triangle);
/* shading.c: where rays carry differentials, the footprint of the hit, in *point and for its
 * textures. */
void scene_set_footprint(const scene *s, const ray *r, const ray_differential *d, const hit *h,
                         shade_point *point);
/* Bends ns of a point whose material has normal maps or bump, finding the normal of its coat, and finds
 * the tangents of one that is grained; after the footprint. */
void scene_bend_normal(const scene *s, shade_point *point);
/* Of a hit: its texture coordinates; and where its point of the surface is at another time, in the
 * world, whether or not a shutter is open then. Slower than what rays need. */
void scene_hit_uv(const scene *s, const ray *r, const hit *h, double uv[2]);
dvec3 scene_hit_moved(const scene *s, const ray *r, const hit *h, float time);
/* A ray from the point into direction d (any length), on the side of n that d points to. */
void scene_spawn_ray(const shade_point *point, dvec3 d, float t_max, ray *out);
/* Its parts: where all rays start that leave on one side of n, and such a ray. */
static inline vec3 scene_origin(const shade_point *point, bool above) {
    return surface_offset_point(point->p, point->n, point->clearance, above ? 1 : -1);
}
static inline void scene_start_ray(const shade_point *point, vec3 o, vec3 d, float t_max,
                                   ray *out) {
    *out = ray_make(o, d, 0, t_max);
    out->time = point->time;
    if (!point->flat) return;
    out->skip_instance = point->instance;
    out->skip_primitive = point->primitive;
}

#endif
