/* The frozen scene: a description made ready for rays. It borrows the description's data, which
 * must outlive it and of which nothing that it refers to changes (instances may be edited: they are
 * copied). Read by any number of threads. */
#ifndef SNELL_SCENE_SCENE_H
#define SNELL_SCENE_SCENE_H

#include "accel/accel.h"
#include "cameras/camera.h"
#include "lights/light.h"
#include "materials/material.h"
#include "scene/description.h"

/* Bits of accel_instance.mask, by what a shadow ray makes of the instance. */
enum { MASK_OPAQUE = 1, MASK_FILTER = 2, MASK_NO_SHADOW = 4, MASK_ALL = 7 };

typedef struct scene_instance {
    const primitive_type *type; /* of the shape */
    const void *shape;          /* its desc */
    uint32_t shape_index;
    uint32_t material; /* index into materials; slots of a mesh choose others */
    bool identity;
    transform to_world, to_local; /* where it moves: at the first of its steps */
    const motion *moves;          /* NULL: it stands still */
    bool has_medium;
    medium inside;            /* of its dielectric: a mesh of several has the first one's */
    uint32_t medium_material; /* which that is */
} scene_instance;

typedef struct scene {
    texture *textures;
    material *materials; /* [material_count] is the grey Lambert of shapes without one */
    light *lights;
    void *default_material; /* the desc of materials[material_count] */
    uint32_t texture_count, material_count, light_count;
    scene_instance *instances;
    uint32_t *instance_ids; /* index in the description of each */
    uint32_t instance_count;
    motion *motions; /* of the instances that move, one after the other */
    uint32_t motion_count;
    /* What the motions were clipped to, seconds; -INFINITY, INFINITY without a camera. */
    double time_open, time_close;
    accel *accel;
    bounds3 bounds; /* without planes */
    dvec3 background, background_top, ambient;
    bool has_gradient;
    double background_alpha;
    double brightest_background; /* its largest component anywhere */
    bool has_filters;            /* some shadow rays pass through surfaces */
    bool has_media;
} scene;

typedef struct scene_options {
    accel_options accel;
} scene_options;

snell_status scene_freeze(const description *d, const scene_options *options, thread_pool *pool,
                          scene **out);
void scene_destroy(scene *s);
dvec3 scene_background(const scene *s, dvec3 direction); /* direction: unit */

/* When a camera's shutter opens and closes, in seconds on the scene's clock. */
void scene_shutter(const description *d, const camera_common *camera, double out[2]);
/* Where the instance is at the time. */
transform scene_instance_transform(const scene *s, uint32_t index, float time);

/* Everything about a hit that shading needs, in the world. */
typedef struct shade_point {
    dvec3 p;          /* on the surface */
    dvec3 wo;         /* unit, towards where the ray came from */
    dvec3 n, ns;      /* geometric and shading normal, unit, both on wo's side */
    bool outside;     /* wo is on the side of the outward normal */
    double clearance; /* a float origin this far from p, along n or -n, has certainly left the
                         surface */
    uint32_t instance, primitive;
    bool flat; /* a ray that leaves here cannot hit (instance, primitive) again */
    const material *material;
    material_point at; /* where the material is looked up */
} shade_point;

void scene_shade_point(const scene *s, const ray *r, const hit *h, shade_point *out);
/* A ray from the point into direction d (any length), on the side of n that d points to. */
ray scene_spawn_ray(const shade_point *point, dvec3 d, float t_max);

#endif
