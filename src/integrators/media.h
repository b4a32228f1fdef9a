/* What a ray is inside of: a small stack of dielectrics. Where solids overlap, the one of the
 * highest priority is present; of equal ones, the one entered last (Schmidt and Budge, Simple
 * Nested Dielectrics in Ray Traced Images, JGT 7(2), 2002). Outside everything is vacuum, ior 1. */
#ifndef SNELL_INTEGRATORS_MEDIA_H
#define SNELL_INTEGRATORS_MEDIA_H

#include "scene/scene.h"

enum { MEDIA_MAX = 8 };

typedef struct media {
    uint32_t count;
    uint32_t instances[MEDIA_MAX]; /* in the order of entering */
} media;

/* The medium that is present; vacuum has ior 1 and absorbs nothing. */
const medium *media_current(const media *m, const scene *s);
/* Crosses the surface of an instance; false: left what was never entered, or entered too many at
 * once (ignored). */
bool media_enter(media *m, uint32_t id); /* id: the instance's number in the scene */
bool media_leave(media *m, uint32_t id);
/* exp(-a d) of the medium that is present, d in metres. */
dvec3 media_transmittance(const media *m, const scene *s, double distance);
/* The media around a point that lies on no surface: one walk along a ray through all hits, and a
 * look at which side of each plane it is on. */
media media_around(const scene *s, snell_isa isa, vec3 p, float time);

#endif
