/* Choosing one of many lights in proportion to what it may bring to a point: a binary tree over
 * lights, each node of which knows where its lights are, whither they shine and how much (Conty
 * Estevez and Kulla, Importance Sampling of Many Lights with Adaptive Tree Splitting, HPG 2018; the
 * importance is that of Physically Based Rendering, 4th edition, 12.6.3). */
#ifndef SNELL_LIGHTS_TREE_H
#define SNELL_LIGHTS_TREE_H

#include "base/error.h"
#include "maths/vec.h"

/* What bounds one light or a node's. All its light leaves within `spread + emission` of the axis:
 * normals lie within `spread`, light within `emission` of a normal; as cosines. */
typedef struct light_bounds {
    dvec3 low, high;
    dvec3 axis;                      /* unit */
    double cos_spread, cos_emission; /* -1: in every direction */
    double power;                    /* any unit, the same for all; 0: never chosen */
    bool two_sided;
} light_bounds;

typedef struct light_tree light_tree;

/* count may be 0. The bounds are copied. */
snell_status light_tree_build(const light_bounds *lights, uint32_t count, light_tree **out);
void light_tree_destroy(light_tree *tree);

/* A light for a point p of unit normal n, or of any orientation where n is 0; u in [0,1). false: none
 * reaches it. *chance: with which it was chosen. */
bool light_tree_sample(const light_tree *tree, dvec3 p, dvec3 n, double u, uint32_t *index,
                       double *chance);
/* The chance with which light_tree_sample chooses this light. */
double light_tree_chance(const light_tree *tree, dvec3 p, dvec3 n, uint32_t index);

#endif
