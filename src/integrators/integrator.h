/* An integrator is a policy of the wave loop: what a hit and a miss emit. It reads like the
 * lectures' Trace(), with emit where the lecture recurses.
 *
 *     trace the wave ─▶ ask the policy about each hit and miss ─▶ it emits radiance,
 *           ▲                                                      shadow rays, next rays
 *           │                                                         │
 *           └── next rays ◀── test the shadow rays, add to the film ◀─┘
 *
 * One file per integrator; one line in integrators.def. */
#ifndef SNELL_INTEGRATORS_INTEGRATOR_H
#define SNELL_INTEGRATORS_INTEGRATOR_H

#include "image/film.h"
#include "integrators/media.h"
#include "sampling/filter.h"

typedef enum ray_kind {
    RAY_CAMERA,
    RAY_REFLECTED,
    RAY_REFRACTED,
    RAY_CONTINUED,
    RAY_KIND_COUNT
} ray_kind;

/* A ray with all that a recursion would have kept on its stack. */
typedef struct path_ray {
    ray ray;
    vec3 weight;     /* how much of what it finds reaches the pixel */
    uint32_t pixel;  /* of the block */
    uint32_t sample; /* of the pixel: the index in its streams */
    uint64_t code;   /* path code: a hash of the way from the camera */
    media media;     /* what it travels in */
    uint16_t depth;  /* camera ray 0, each child one more */
    uint8_t kind;    /* ray_kind */
    bool primary;    /* a camera ray, or one walked on through transparent surfaces */
    float coverage;  /* of a primary ray: the share of the pixel that nothing has covered yet */
} path_ray;

typedef struct wave wave;

typedef struct integrator {
    const char *name, *help;
    uint32_t samples, max_depth; /* defaults */
    uint32_t max_depth_media;    /* default where the scene has dielectrics */
    void (*hit)(wave *w, const path_ray *r, const shade_point *p, const bsdf *b);
    void (*miss)(wave *w, const path_ray *r);
} integrator;

extern const integrator
    *const integrators[]; /* by snell_integrator - 1; NULL: not in this version */
enum { INTEGRATOR_COUNT = 4 };

/* ---- what policies emit (wave.c) ---- */
const scene *wave_scene(const wave *w);
/* Radiance that the ray brings home: it is weighted and added to the film. */
void emit_radiance(wave *w, const path_ray *r, dvec3 radiance);
/* A child of r from p into direction d, carrying `weight` of what it finds, in `m`. slot: which
 * child (0, 1, ..). Deeper than max_depth it is black and not traced; below min_weight it is
 * dropped and counted. */
void emit_ray(wave *w, const path_ray *r, const shade_point *p, dvec3 d, dvec3 weight,
              const media *m, uint32_t slot, ray_kind kind);
/* r walks on through p as if it were not there, at the same depth. */
void emit_continued(wave *w, const path_ray *r, const hit *from, dvec3 weight, const media *m);
/* Direct light: for every light a shadow ray that brings f(wo, wi) E max(0, n.l) if nothing blocks
 * it. */
void emit_direct_light(wave *w, const path_ray *r, const shade_point *p, const bsdf *b);
/* Emission and ambient light of a hit. */
void emit_own_light(wave *w, const path_ray *r, const bsdf *b);
void emit_background(wave *w, const path_ray *r);

/* ---- the loop ---- */
typedef struct wave_settings {
    const scene *scene;
    const integrator *integrator;
    const camera_type *camera;
    camera_frame frame;
    media camera_media;
    const pixel_filter *filter;
    double shutter_open, shutter_close; /* seconds on the scene's clock; equal: nothing moves */
    uint32_t width, height;             /* of the whole picture */
    uint32_t samples, max_depth;
    float min_weight;
    uint64_t seed;
    bool pixel_center, transparent;
    uint32_t wave_size; /* rays traced at once, at most */
    snell_isa isa;
} wave_settings;

typedef struct wave_stats {
    uint64_t rays[RAY_KIND_COUNT], shadow_rays;
    trace_counters counters;
    fixed128 dropped_weight;
    uint64_t media_mismatches, film_overflows, blocked_by_cap;
} wave_stats;

/* Rays to work on; one per worker, used again for every block. */
snell_status wave_create(const wave_settings *settings, wave **out);
void wave_destroy(wave *w);
/* All samples of the pixels x0..x1, y0..y1 (at most 16 x 16) into *block. Asks `go_on` now and
 * then; false ends with SNELL_CANCELLED and the block is to be thrown away. SNELL_ERR_UNSUPPORTED: a
 * shadow ray met more surfaces that let light through than the walk has steps. */
snell_status wave_render_block(wave *w, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1,
                               film_block *film, bool (*go_on)(void *user, const wave_stats *stats),
                               void *user);
const wave_stats *wave_get_stats(const wave *w);

#endif
