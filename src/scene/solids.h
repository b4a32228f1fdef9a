/* From the description of a solid to what rays meet (accel/solid.h). */
#ifndef SNELL_SCENE_SOLIDS_H
#define SNELL_SCENE_SOLIDS_H

#include "accel/solid.h"
#include "scene/description.h"

/* Can a solid be made of these shapes of the description? */
snell_status solid_check_parts(const description *d, const snell_shape_id *shapes, size_t count);

/* Of any shape after the transform: infinite where it goes on for ever, empty where there is nothing.
 * Contains every point of it. */
bounds3 shape_bounds(const description *d, uint32_t shape, const transform *placed);
bool bounds_are_finite(bounds3 b); /* false also when empty */

/* Shapes that a shape consists of: 1, or those of a solid. */
uint32_t shape_part_count(const description *d, uint32_t shape);

/* The solids of a scene, by the number of their shape, and the meshes that they are made of. */
typedef struct solid_set {
    solid_shape **solids; /* [shape_count]; NULL: not one that is used */
    size_t shape_count;
    solid_mesh **meshes;
    size_t mesh_count, mesh_capacity;
    const struct material *materials; /* of the scene; borrowed */
    const prepared_shape *prepared;   /* of the description's shapes; borrowed */
    bool textured;                    /* one of them looks at texture coordinates */
} solid_set;

snell_status solid_set_create(size_t shape_count, solid_set **out);
void solid_set_destroy(solid_set *set);
/* Compiles shape number `shape`, a solid, unless that is done. */
snell_status solid_set_compile(solid_set *set, const description *d, uint32_t shape,
                               thread_pool *pool, const solid_shape **out);
size_t solid_set_memory(const solid_set *set); /* bytes */

#endif
