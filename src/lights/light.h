/* What shines. One file per light; one line in lights.def.
 *
 * Three sorts of light:
 *   - from one point or direction (point, spot, directional, headlight): no ray can hit it;
 *   - from far away, over many directions (environment, sky, directional with an angle): a ray that
 *     leaves the scene meets it;
 *   - from a surface (quad, disk, sphere): the light only says which shape shines, and the scene
 *     makes that shape (scene/scene.c), as it does for every shape of a material that shines. */
#ifndef SNELL_LIGHTS_LIGHT_H
#define SNELL_LIGHTS_LIGHT_H

#include "base/thread.h"
#include "geometry/primitive.h"
#include "sampling/sampling.h"
#include "textures/texture.h"

/* Light that would arrive at a point if nothing were in the way. */
typedef struct light_sample {
    dvec3 to_light; /* from the point to the light, its length the distance; a unit vector where
                         the light is infinitely far */
    dvec3 to_end;   /* where the test for shadows ends: short of the light's own surface */
    bool infinite;  /* infinitely far */
    dvec3 light;    /* pdf == 0: the irradiance on a surface that faces the light, W/m^2;
                         otherwise the radiance that arrives, W/(m^2 sr) */
    double pdf;     /* density of the direction, per sr; 0: there is only this one direction */
} light_sample;

/* A shape that shines, for lights that are surfaces. */
typedef struct light_shape {
    const primitive_type *type;
    void *desc;     /* owned by whoever asked: desc_free */
    dvec3 radiance; /* of its outside */
    bool visible;   /* to camera rays */
} light_shape;

typedef struct light light;

typedef struct light_type {
    type_info info;
    snell_status (*check)(const void *desc);

    /* A light that is a surface has this and `power` alone. */
    snell_status (*shape)(const void *desc, light_shape *out);

    /* One direction in which light arrives at p; u in [0,1)^2, and (.5, .5) is the middle of the
     * light. false: none does. eye: the camera's position. */
    bool (*sample)(const light *l, dvec3 p, dvec3 eye, sample2 u, light_sample *out);
    /* The same from the middle alone, standing for the whole light; NULL: `sample` at (.5, .5). */
    bool (*middle)(const light *l, light_sample *out);
    /* Lights that shine alike in all directions from one point: what `sample` makes light_sample_point
     * of. NULL: others. */
    void (*point)(const void *desc, dvec3 *position, dvec3 *intensity);
    /* Lights that a leaving ray meets: the radiance that comes from direction d (unit), and the
     * density with which `sample` draws d. NULL: no ray meets it. */
    dvec3 (*radiance)(const light *l, dvec3 d);
    double (*pdf)(const light *l, dvec3 d);
    /* The irradiance of a surface of normal n when nothing is in the way, W/m^2, where light comes
     * from everywhere: appel and whitted light diffuse surfaces with it. NULL: they sample it. */
    dvec3 (*irradiance)(const light *l, dvec3 n);
    /* The largest component of its radiance anywhere, about; of those with `irradiance`. */
    double (*brightest)(const light *l);
    /* The power that it sends out, W, for choosing among many. The infinitely far are asked about a
     * disk of the radius of the scene. */
    dvec3 (*power)(const light *l, double scene_radius);
    /* Where it is and whither it shines, for lights at a place: position, unit axis, and the cosine
     * of the half-angle that holds all its light (-1: everywhere). NULL: it is nowhere. */
    void (*place)(const light *l, dvec3 *position, dvec3 *axis, double *cos_spread);

    /* What sampling needs beside the description. `textures` is the frozen scene's array. */
    snell_status (*prepare)(const void *desc, const texture *textures, thread_pool *pool,
                            void **state);
    void (*release)(void *state);

    bool casts_shadow; /* false: the headlight, which sees what the camera sees */
    bool (*is_visible)(const void *desc); /* to camera rays; NULL: yes */
} light_type;

extern const light_type *const light_types[];
extern const uint32_t light_type_count;

/* A frozen light. */
struct light {
    const light_type *type;
    const void *desc;
    void *state; /* of prepare; owned */
    const texture *textures;
    dvec3 position, intensity; /* of type->point, if it has that */
};

/* Point lights: I / r^2 (Cornell CS4620, "Irradiance from isotropic point source"). */
static inline bool light_sample_point(dvec3 position, dvec3 intensity, dvec3 p, light_sample *out) {
    dvec3 to_light = dvec3_sub(position, p);
    double squared = dvec3_dot(to_light, to_light);
    if (!(squared > 0)) return false;
    out->to_light = to_light;
    out->to_end = to_light;
    out->infinite = false;
    out->light = dvec3_scale(intensity, 1 / squared);
    out->pdf = 0;
    return true;
}

/* From its middle alone: what stands for the whole light where one ray goes to each. */
static inline bool light_sample_middle(const light *l, dvec3 p, dvec3 eye, light_sample *out) {
    const sample2 half = {0.5, 0.5};
    if (l->type->point) return light_sample_point(l->position, l->intensity, p, out);
    return l->type->middle ? l->type->middle(l, out) : l->type->sample(l, p, eye, half, out);
}

#define LUMINANCE(c) (0.2126 * (c).x + 0.7152 * (c).y + 0.0722 * (c).z) /* Rec. 709 */

#endif
