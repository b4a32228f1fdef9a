/* What snell_explain keeps of a run of the wave loop over one pixel: each ray with the ray that sent
 * it, and each contribution to the film. Nothing is computed twice: the loop tells what it did, where
 * wave_settings.record is not NULL.
 *
 * A path_ray's `node` is its number here. Sums are kept of every sample, rays and lights of the wanted
 * ones: those of others have the node NO_ID. */
#ifndef SNELL_INTEGRATORS_RECORD_H
#define SNELL_INTEGRATORS_RECORD_H

#include "integrators/integrator.h"

typedef struct recorded_ray {
    snell_explained_ray said; /* without names, sums and what concerns the order */
    uint32_t material;        /* index into the scene's materials; NO_ID: met no surface */
    dvec3 emission;
} recorded_ray;

typedef struct recorded_light {
    snell_explained_light said;
    uint32_t light;   /* NO_ID: none; a registry light, or (instance) a shape that shines */
    bool is_instance; /* light is the number of a shape */
    uint32_t blocker; /* number of a shape; NO_ID: none */
} recorded_light;

#if defined(__GNUC__)
#define RECORD_COLD __attribute__((cold))
#else
#define RECORD_COLD
#endif

typedef fixed128 record_sum[4]; /* red, green, blue, alpha */

typedef struct record {
    uint32_t first_sample, end_sample; /* of which rays are kept */
    uint32_t scramble, scrambles;      /* the one that is rendered, of how many */
    uint32_t rays_max;
    recorded_ray *rays; /* parents before children */
    size_t ray_count, ray_capacity;
    recorded_light *lights;
    size_t light_count, light_capacity;
    record_sum *sums; /* of each sample */
    bool no_memory, full;
    /* Of the shadow rays that wait: their lights and samples. */
    struct record_waiting {
        uint32_t light, sample;
    } * waiting;
    bool filtered;  /* the shadow ray that is tested met what lets light through */
    hit stopped_by; /* and what lets none; instance NO_ID: nothing */
} record;

snell_status record_create(uint32_t samples, uint32_t wave_size, record **out);
void record_destroy(record *r);
void record_add(record_sum sum, const double contribution[4]); /* as the film adds */

/* ---- what the wave loop tells; w has a record ---- */
RECORD_COLD void record_camera_ray(const wave *w, path_ray *r);
/* `parent` sends `child`, or walks on as it. */
RECORD_COLD void record_child(const wave *w, const path_ray *parent, path_ray *child, dvec3 weight);
/* The same for one that is not traced; and for a ray that does not walk on, being too faint. */
RECORD_COLD void record_unborn(const wave *w, const path_ray *parent, const shade_point *p, dvec3 d,
                               dvec3 weight, ray_kind kind, snell_ray_end why);
RECORD_COLD void record_ended(const wave *w, const path_ray *parent, dvec3 weight);
RECORD_COLD void record_absorbed(const wave *w, const path_ray *r, dvec3 transmittance);
/* Of a path that goes on with one colour: 3 for that, 0 for the others. */
RECORD_COLD void record_color(const wave *w, const path_ray *r, dvec3 kept);
RECORD_COLD void record_hit(const wave *w, const path_ray *r, const hit *h, const shade_point *p,
                            const bsdf *b, snell_ray_end end);
RECORD_COLD void record_miss(const wave *w, const path_ray *r);

/* What is added: by the surface itself, by what a ray sees that leaves, of alpha. */
RECORD_COLD void record_surface(const wave *w, const path_ray *r, dvec3 radiance);
RECORD_COLD void record_sky(const wave *w, const path_ray *r, dvec3 radiance);
RECORD_COLD void record_coverage(const wave *w, const path_ray *r, double alpha);
/* What emit_light is about to send towards r: w->asked says from which light; and the light from
 * everywhere. */
RECORD_COLD void record_asked(wave *w, const path_ray *r, const shade_point *p,
                              const light_sample *sample, double weight, dvec3 radiance,
                              bool casts_shadow);
RECORD_COLD void record_irradiance(const wave *w, const path_ray *r, dvec3 f, dvec3 irradiance);
/* Of the shadow rays that wait it is known which are blocked; number `index` is filtered, by a surface
 * at last through which nothing comes; it adds. */
RECORD_COLD void record_blocked(const wave *w);
RECORD_COLD void record_stopped(const wave *w, const hit *by);
RECORD_COLD void record_filtered(const wave *w, size_t index, dvec3 through);
RECORD_COLD void record_shadow(const wave *w, size_t index, dvec3 contribution);

#endif
