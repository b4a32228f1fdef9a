/* The frozen scene: a description made ready for rays. It borrows the description's data, which
 * must outlive it and of which nothing that it refers to changes (instances may be edited: they are
 * copied). Read by any number of threads. */
#ifndef SNELL_SCENE_SCENE_H
#define SNELL_SCENE_SCENE_H

#include "accel/accel.h"
#include "cameras/camera.h"
#include "lights/light.h"
#include "lights/tree.h"
#include "materials/material.h"
#include "geometry/surface.h"
#include "scene/description.h"

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
    uint32_t material; /* index into materials; slots of a mesh choose others */
    bool identity;
    transform to_world, to_local; /* where it moves: at the first of its steps */
    const motion *moves;          /* NULL: it stands still */
    bool has_medium;
    medium inside;            /* of its dielectric: a mesh of several has the first one's */
    uint32_t medium_material; /* which that is */
    bool similar;      /* to_world keeps angles, so solid angles are the same in both spaces */
    bool hidden_light; /* the shape of a light that the camera does not see */
    uint32_t first_emitter, emitter_count;
} scene_instance;

/* A shape, or a triangle, that shines. */
typedef struct emitter {
    uint32_t instance, primitive;
    double area; /* in the shape's own space, m^2 */
    double sum;  /* of the weights of its light's emitters up to this one, 1 at the last */
} emitter;

/* The shape of a registry light, which stands behind the description's. */
typedef struct light_body {
    light_shape shape;
    void *material_desc;
} light_body;

/* What a shape's type made of its description (primitive_type.prepare). */
typedef struct prepared_shape {
    const primitive_type *type;
    void *prepared; /* NULL: nothing, the description serves */
} prepared_shape;

typedef struct scene {
    texture *textures;
    material *materials;    /* [material_count] is the grey Lambert of shapes without one */
    light *lights;          /* that are not surfaces */
    light_body *bodies;     /* of those that are; materials[material_count + 1 + i] is body i's */
    void *default_material; /* the desc of materials[material_count] */
    uint32_t texture_count, material_count, light_count, body_count;
    emitter *emitters;        /* by instance, then by primitive */
    uint32_t *surface_lights; /* the instances that have emitters */
    uint32_t emitter_count, surface_light_count;
    light_tree *tree; /* over the lights that are somewhere (`placed`), then the emitters */
    uint32_t *placed, *nowhere; /* registry lights */
    uint32_t placed_count, nowhere_count;
    prepared_shape *shapes; /* of the description */
    size_t shape_count;
    scene_instance *instances;
    uint32_t *instance_ids; /* index in the description of each; NO_ID: the shape of a light */
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
    bool has_unshadowing;        /* something casts no shadow */
    bool has_media;
    bool needs_footprint; /* some texture is filtered: rays carry differentials */
} scene;

typedef struct scene_options {
    accel_options accel;
} scene_options;

snell_status scene_freeze(const description *d, const scene_options *options, thread_pool *pool,
                          scene **out);
void scene_destroy(scene *s);
size_t scene_texture_memory(const scene *s);             /* bytes, beyond the description's */
dvec3 scene_background(const scene *s, dvec3 direction); /* direction: unit */

/* When a camera's shutter opens and closes, in seconds on the scene's clock. */
void scene_shutter(const description *d, const camera_common *camera, double out[2]);
/* The instance as it stands at a time: itself, or where it moves *moved, made from it. */
const scene_instance *scene_posed(const scene_instance *at, float time, scene_instance *moved);
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
    float time;
    bool flat; /* a ray that leaves here cannot hit (instance, primitive) again */
    const material *material;
    material_point at; /* where the material is looked up */
    dvec3 dpdu, dpdv;  /* of p by u, v; 0 where the shape has no smooth coordinates */
    double curvature;  /* of the shape, in its own space (geometry/primitive.h) */
    /* From this sample to the next to the right (x) and down (y): p and ns. 0 without a footprint. */
    dvec3 dpdx, dpdy, dndx, dndy;
    bool has_footprint;
} shade_point;

void scene_shade_point(const scene *s, const ray *r, const hit *h, shade_point *out);
/* The same for a point `on` an instance's surface, in its own space, seen from direction wo (unit);
 * afterwards `on` is in the world. */
void scene_surface_point(const scene *s, uint32_t id, uint32_t primitive, float time, surface *on,
                         dvec3 wo, shade_point *out);
/* shading.c: where rays carry differentials, the footprint of the hit, in *point and for its
 * textures. */
void scene_set_footprint(const scene *s, const ray *r, const ray_differential *d, const hit *h,
                         shade_point *point);
/* Bends ns of a point whose material has a normal map or bump; after the footprint. */
void scene_bend_normal(const scene *s, shade_point *point);
/* A ray from the point into direction d (any length), on the side of n that d points to. */
ray scene_spawn_ray(const shade_point *point, dvec3 d, float t_max);

#endif
