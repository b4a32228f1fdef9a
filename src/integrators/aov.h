/* AOVs as the wave loop takes them (image/aov.h says what they are). Where wave_settings.aovs is not
 * NULL, the loop tells what camera rays meet and every contribution to the film; nothing is traced for
 * them.
 *
 *     plan    which layers there are, and the names behind their numbers; read by all workers
 *     block   the sums of a block of pixels, in fixed point as the film's: the order is free. A wave adds
 *             to the one that wave_collect gave it, beside the film_block of wave_render_block
 *
 * Surface values are of the first surface that a camera ray does not merely pass: what is there in part
 * counts with the share of it that is there, glass and mirrors count as themselves. Light is sorted by
 * the depth of the ray that brought it: `depth` scatterings, one more for what a shadow ray brings. */
#ifndef SNELL_INTEGRATORS_AOV_H
#define SNELL_INTEGRATORS_AOV_H

#include "image/aov.h"
#include "integrators/integrator.h"

/* Lights that have layers of their own; the rest share light.other. */
enum { LIGHT_LAYERS_MAX = 64 };

typedef struct aov_plan aov_plan;
/* For the rays of these settings; borrows scene and description. */
snell_status aov_plan_create(aov_set wanted, const wave_settings *settings, const description *d,
                             aov_plan **out);
void aov_plan_destroy(aov_plan *plan);
/* Adds the layers to a film that has its size. */
snell_status aov_plan_add_layers(const aov_plan *plan, film *f);
/* How many lights share light.other for want of layers, and *names of them, the plan's; " .." at the end: and more. */
uint32_t aov_plan_joined(const aov_plan *plan, const char **names);

typedef struct aov_block aov_block;
snell_status aov_block_create(const aov_plan *plan, aov_block **out); /* cleared */
void aov_block_destroy(aov_block *b);
void aov_block_clear(aov_block *b);
/* To which the wave, whose settings have the same plan, adds what it renders from now on. */
void wave_collect(wave *w, aov_block *to);
/* What a pixel's mean is taken of, by channel, of an AOV that has one; lamp: which layer of `light`. Those
 * of emission, direct and indirect add up to the film's sums, as those of all lights do, to the last bit. */
const fixed128 *aov_block_sums(const aov_block *b, aov_id id, uint32_t lamp, uint32_t pixel);
/* One pixel of the block, of so many samples, to x, y of the film's layers. */
void aov_block_set(const aov_block *b, uint32_t pixel, uint32_t samples, film *f, uint32_t x,
                   uint32_t y);

/* How the light of a shadow ray that waits will come: its layers. */
typedef struct light_way {
    uint32_t depth; /* how often it was scattered */
    uint8_t route;  /* as of the ray */
    uint32_t layer; /* of light */
} light_way;

/* ---- what the wave loop tells; w->aovs is not NULL ---- */
#if defined(__GNUC__) /* apart from the loop's code, which mostly has none */
#define AOV_APART __attribute__((noinline))
#else
#define AOV_APART
#endif
/* `count` rays are traced; the waiting shadow rays are. */
AOV_APART void aov_traced(wave *w, const path_ray *rays, size_t count);
AOV_APART void aov_traced_shadows(wave *w);
/* A camera ray meets what stops it, or r->coverage of it. */
AOV_APART void aov_hit(wave *w, const path_ray *r, const hit *h, const shade_point *p,
                       const bsdf *b);
/* What is added to the film: by the surface w->at itself, of which `ambient` is no emission; by what a
 * ray sees that leaves, the shares of registry lights (NO_ID: of the background) first, of which `alpha` counts; by
 * the light w->asked, with no shadow ray. */
AOV_APART void aov_surface(wave *w, const path_ray *r, dvec3 radiance, dvec3 ambient);
AOV_APART void aov_sky_share(wave *w, uint32_t number, dvec3 radiance);
AOV_APART void aov_sky(wave *w, const path_ray *r, dvec3 radiance, double alpha);
AOV_APART void aov_asked(wave *w, const path_ray *r, dvec3 radiance);
/* The shadow ray towards w->asked that waits next is r's; number `index` of those that wait adds. */
AOV_APART void aov_waits(wave *w, const path_ray *r);
AOV_APART void aov_shadow(wave *w, size_t index, dvec3 contribution);

#endif
