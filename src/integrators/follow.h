/* The rays that `whitted` and `cook` both follow: delta lobes, and the directions that shading
 * normals would send to the wrong side. */
#ifndef SNELL_INTEGRATORS_FOLLOW_H
#define SNELL_INTEGRATORS_FOLLOW_H

#include "integrators/integrator.h"

/* A reflection about a shading normal that would go below the surface is bent back above it. */
dvec3 bent_back(const shade_point *p, dvec3 d);
/* share: the fraction of weight * Fresnel that the mirror ray carries. */
void follow_mirror(wave *w, const path_ray *r, const shade_point *p, const bsdf *b, const lobe *l,
                   double share, uint32_t slot);
/* The slot of a lobe's ray of one colour alone, beyond those of all lobes. */
static inline uint32_t color_slot(uint32_t slot, int color) {
    return slot + 2 * LOBES_MAX * (uint32_t)(1 + color);
}
/* Both branches of the tree, by Snell and Fresnel; they take the slots `slot` and slot + 1. Where
 * colours part, three are refracted. */
void follow_interface(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                      const lobe *l, uint32_t slot);

#endif
