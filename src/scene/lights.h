/* Everything in a frozen scene that shines, in one numbering, and how to sample it.
 *
 *     sources:  0 .. light_count - 1        the registry's lights that are not surfaces
 *               light_count ..              emitters: each shape that shines, each triangle of a mesh
 *     lights:   the same first ones, then surface lights: an emitter, or all of a mesh together
 *
 * `cook` and the older integrators ask every light; `path` chooses one source for each point, by
 * the light tree (lights/tree.h), or one of those that are nowhere, each with the same chance. */
#ifndef SNELL_SCENE_LIGHTS_H
#define SNELL_SCENE_LIGHTS_H

#include "scene/scene.h"

/* After instances and materials are frozen. */
snell_status scene_freeze_lights(scene *s, const accel_options *options); /* its progress */
void scene_free_lights(scene *s);

uint32_t scene_light_count(const scene *s);

/* Light number `index` at the point `from` (its p, and how rays leave it). u in [0,1)^2: where on the
 * light; (.5, .5) is its middle. false: no light arrives. A direction's density holds for the whole
 * light. eye: the camera's position; time: the ray's. */
bool scene_sample_light(const scene *s, uint32_t index, const shade_point *from, dvec3 eye,
                        float time, sample2 u, light_sample *out);
/* Of a surface light, the k-th of `count` representatives: its middle, or points spread over it where
 * no one point stands for it. Each stands for its part; their sum is the light. */
bool scene_sample_light_center(const scene *s, uint32_t index, uint32_t k, const shade_point *from,
                               dvec3 eye, float time, light_sample *out);
uint32_t scene_light_center_count(const scene *s, uint32_t index);
const light_type *scene_light_type(const scene *s, uint32_t index); /* NULL: a surface light */
/* What of s->surface_lights a shape is, by its number; NULL: none. */
const surface_light *scene_surface_light(const scene *s, uint32_t shape);

/* One source for the point p of normal n (0: any orientation). */
bool scene_choose_source(const scene *s, dvec3 p, dvec3 n, double u, uint32_t *source,
                         double *chance);
bool scene_sample_source(const scene *s, uint32_t source, const shade_point *from, dvec3 eye,
                         float time, sample2 u, light_sample *out);

bool scene_source_casts_shadow(const scene *s, uint32_t source);

/* The density, per sr, with which scene_choose_source and scene_sample_source together would have
 * drawn the direction d (unit) from `from`, of normal n: towards the point `on` an emitter, or out
 * of the scene to registry light `index`. */
double scene_hit_pdf(const scene *s, dvec3 from, dvec3 n, const shade_point *on, float time);
double scene_miss_pdf(const scene *s, uint32_t index, dvec3 d);

/* Does a ray that leaves the scene see this registry light? Where it sees none, it sees the
 * background. */
bool scene_light_is_seen(const scene *s, uint32_t index, bool camera_ray);

#endif
