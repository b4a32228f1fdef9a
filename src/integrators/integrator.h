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
#include "sampling/sampling.h"
#include "scene/lights.h"

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
    uint32_t sample; /* number of the pixel's sample */
    uint32_t node;   /* in the record, where there is one (record.h) */
    uint64_t code;   /* path code: a hash of the way from the camera */
    media media;     /* what it travels in */
    uint16_t depth;  /* camera ray 0, each child one more */
    uint8_t kind;    /* ray_kind */
    uint8_t
        color; /* the one that it carries since a medium parted them: 1 red, 2, 3 blue; 0: all */
    uint8_t route; /* of the ray that the first surface sent on this way; RAY_CAMERA: none yet */
    bool primary;  /* a camera ray, or one walked on through transparent surfaces */
    bool has_differential;
    float coverage; /* of a primary ray: the share of the pixel that nothing has covered yet */
    ray_differential differential; /* to the next sample's ray, where has_differential */
    /* The density, per sr, with which the ray's direction was drawn (0: it had no choice, so that
     * nothing else could have found what it finds); and for `path`, if there is one, the normal
     * where that was (0: of no side), as scene_choose_source was or would have been asked, and where
     * that was, which a pane that lets the ray straight through does not change. */
    float drawn_pdf;
    vec3 drawn_n, drawn_from;
} path_ray;

typedef struct wave wave;

typedef struct integrator {
    const char *name, *help;
    uint32_t samples, max_depth; /* defaults */
    uint32_t max_depth_media;    /* default where the scene has dielectrics */
    /* One branch of every choice, drawn by chance, instead of all of them. Then rays are not dropped
     * by min_weight, and light does not go straight through glass but is refracted. */
    bool one_branch;
    void (*hit)(wave *w, const path_ray *r, const shade_point *p, const bsdf *b);
    void (*miss)(wave *w, const path_ray *r);
} integrator;

extern const integrator
    *const integrators[]; /* by snell_integrator - 1; NULL: not in this version */
enum { INTEGRATOR_COUNT = 4 };

/* ---- what policies ask (wave.c) ---- */
const scene *wave_scene(const wave *w);
uint32_t wave_max_depth(const wave *w);
dvec3 wave_eye(const wave *w); /* the camera's position */
/* What a ray is in once it has crossed the surface that was hit; during `hit` only. */
const media *wave_beyond(const wave *w);
/* A point of the unit square for one purpose of this ray, or of its child in a slot. */
sample2 wave_draw(const wave *w, const path_ray *r, sample_purpose purpose);
sample2 wave_draw_child(const wave *w, const path_ray *r, uint32_t slot, sample_purpose purpose);

/* ---- what policies emit (wave.c) ---- */
/* Radiance that the ray brings home from a surface: it is weighted and added to the film. */
void emit_radiance(wave *w, const path_ray *r, dvec3 radiance);
/* A child of r from p into direction d, carrying `weight` of what it finds, in `m`. slot: which
 * child (0, 1, ..). Deeper than max_depth it is black and not traced; below min_weight it is
 * dropped and counted: then NULL. What is returned may be changed until the next emission. */
path_ray *emit_ray(wave *w, const path_ray *r, const shade_point *p, dvec3 d, dvec3 weight,
                   const media *m, uint32_t slot, ray_kind kind);
/* r walks on through p as if it were not there, at the same depth. */
void emit_continued(wave *w, const path_ray *r, const hit *from, dvec3 weight, const media *m);
/* r goes straight on through the thin pane p that was hit, by chance: at the same depth, but with
 * random numbers of its own. As shadow rays go the same way, what it meets is what light sampling
 * could have found where r began. Hits come in order, so the walk ends. During `hit` only. */
void emit_through_pane(wave *w, const path_ray *r, const shade_point *p, dvec3 weight,
                       uint32_t slot);
/* Direct light of every light, one shadow ray for each, or one for each representative of a mesh:
 * f(wo, wi) E max(0, n.l) if nothing blocks it.
 * LIGHT_CENTERS: from the middle of each light; light from everywhere falls on matte lobes with
 * nothing in the way, and on no other.
 * LIGHT_AREAS: from a point drawn on each light; lobes that are traced meet such lights by
 * themselves and get only the light of points. */
typedef enum light_places { LIGHT_CENTERS, LIGHT_AREAS } light_places;
void emit_direct_light(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                       lobe_set lobes, light_places places);
/* The light of one sample, reflected by these lobes: f |cos| times it times `weight`, unless p is in
 * shadow; none where the geometric and the shading side disagree about where it comes from. */
void emit_light(wave *w, const path_ray *r, const shade_point *p, const bsdf *b, lobe_set lobes,
                const light_sample *sample, double weight, bool casts_shadow);
/* Which light, or in `path` which source, the next emit_light is about, and the chance with which it was chosen: for
 * the record. */
void wave_ask(wave *w, uint32_t number, double chance);
/* Emission and ambient light of a hit. */
void emit_own_light(wave *w, const path_ray *r, const bsdf *b);
/* What a ray that leaves sees: lights, each weighted by `weight` (NULL: 1), or the background. */
typedef double light_weight_fn(const wave *w, const path_ray *r, uint32_t light);
void emit_sky(wave *w, const path_ray *r, light_weight_fn *weight);
void emit_background(wave *w, const path_ray *r); /* emit_sky without weights */

/* ---- the loop ---- */
enum { WAVE_SIZE_MAX = 4096 };

typedef struct wave_settings {
    const scene *scene;
    const integrator *integrator;
    const camera_type *camera;
    camera_frame frame;
    media camera_media;
    const pixel_filter *filter;
    double shutter_open, shutter_close; /* seconds on the scene's clock; equal: nothing moves */
    uint32_t width, height;             /* of the whole picture */
    uint32_t max_depth;
    float min_weight;
    uint64_t seed;
    bool pixel_center, transparent;
    uint32_t wave_size; /* rays traced at once, at most */
    snell_isa isa;
    bool timed;                  /* the stats have seconds */
    struct record *record;       /* what one pixel's run is told to (record.h); NULL: nothing is */
    const struct aov_plan *aovs; /* layers beside the picture (aov.h); NULL: none */
} wave_settings;

typedef enum wave_phase {
    WAVE_CAMERA,
    WAVE_TRACE,
    WAVE_SHADE,
    WAVE_SHADOWS,
    WAVE_PHASE_COUNT
} wave_phase;

typedef struct wave_stats {
    uint64_t rays[RAY_KIND_COUNT], shadow_rays;
    trace_counters counters, shadow_counters; /* of nearest hits; of shadow rays */
    fixed128 dropped_weight;
    uint64_t media_mismatches, film_overflows, blocked_by_cap;
    uint64_t spent_solids;            /* rays that met more of a solid than it can hold */
    double seconds[WAVE_PHASE_COUNT]; /* CPU time of the worker */
} wave_stats;

/* Rays to work on; one per worker, used again for every block. */
snell_status wave_create(const wave_settings *settings, wave **out);
void wave_destroy(wave *w);
/* Numbers first..end (without) of one scramble of each pixel's sequence; sharing: how many samples, of
 * all scrambles, share a pixel's footprint. */
typedef struct wave_samples {
    uint32_t first, end, scramble, sharing;
} wave_samples;
/* These samples of the pixels x0..x1, y0..y1 (at most 16 x 16) into *block, which is cleared. Asks `go_on` now and
 * then; false ends with SNELL_CANCELLED and the block is to be thrown away. SNELL_ERR_UNSUPPORTED: a
 * shadow ray met more surfaces that let light through than the walk has steps (blocked_by_cap), or a ray
 * more stretches of what a solid is made of than it can hold (spent_solids). */
snell_status wave_render_block(wave *w, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1,
                               const wave_samples *samples, film_block *film,
                               bool (*go_on)(void *user, const wave_stats *stats), void *user);
const wave_stats *wave_get_stats(const wave *w);
size_t wave_memory(const wave *w); /* bytes that it holds */

#endif
