/* Radiance over the sphere of directions, as a grid of longitude and latitude that can be sampled
 * and whose irradiance is known.
 *
 * u in [0,1) is the longitude and v in [0,1] the latitude: v = 1 is +Y, the middle (.5, .5) is -Z,
 * where a default camera looks, and u grows to the right as seen from inside. */
#ifndef SNELL_LIGHTS_SPHERE_MAP_H
#define SNELL_LIGHTS_SPHERE_MAP_H

#include "base/error.h"
#include "base/thread.h"
#include "maths/vec.h"
#include "sampling/sampling.h"

typedef dvec3 sphere_radiance_fn(const void *user, dvec3 d);

typedef struct sphere_map {
    uint32_t width, height;
    double *rows;       /* height + 1: the distribution function over rows, from the top (+Y) */
    double *cells;      /* height x (width + 1): the distribution function within each row */
    bool black;         /* nowhere is anything: then both mean nothing */
    double brightest;   /* the largest component of what was looked at */
    dvec3 mean;         /* radiance, over the sphere */
    dvec3 harmonics[9]; /* of radiance, the real spherical harmonics up to the second order */
} sphere_map;

void sphere_map_coordinates(dvec3 d, double *u, double *v);

/* A grid of width x height cells; in each, detail x detail directions are looked at. spills: cells
 * beside bright ones are drawn too, where those directions may miss something. */
typedef struct sphere_grid {
    uint32_t width, height, detail;
    bool spills;
} sphere_grid;
/* `radiance` is called by the pool's workers at once; the same bits for any number of them. */
snell_status sphere_map_build(const sphere_grid *grid, thread_pool *pool,
                              sphere_radiance_fn *radiance, const void *user, sphere_map *out);
void sphere_map_free(sphere_map *map);

/* A direction by luminance; false where the map is black. pdf: per sr. */
bool sphere_map_sample(const sphere_map *map, sample2 u, dvec3 *d, double *pdf);
double sphere_map_pdf(const sphere_map *map, dvec3 d);
/* Of a surface of unit normal n with nothing in the way, W/m^2, from the harmonics (Ramamoorthi and
 * Hanrahan, An Efficient Representation for Irradiance Environment Maps, SIGGRAPH 2001): within 1 %
 * for smooth skies; never negative. */
dvec3 sphere_map_irradiance(const sphere_map *map, dvec3 n);

#endif
