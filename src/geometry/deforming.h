/* A mesh that deforms, made ready for rays: its vertices go straight from key to key, all at once.
 *
 * Where a vertex is at a time is one float vector, whoever asks (deforming_mix): the kernels, shading
 * and sampling. The formula is monotone in what it mixes, so boxes at two keys that hold a triangle
 * there hold it at every time between them, mixed by the same formula, without room for roundings. */
#ifndef SNELL_GEOMETRY_DEFORMING_H
#define SNELL_GEOMETRY_DEFORMING_H

#include "geometry/mesh.h"

/* Between two keys of those in use, or at one. */
typedef struct deforming_time {
    uint32_t key, next; /* equal at one alone */
    float weight[2];    /* of key and next, of sum 1 but for a rounding */
} deforming_time;

typedef struct deforming_mesh {
    mesh_desc mesh;     /* borrows the description's arrays; positions: of the first key in use */
    const float *times; /* of the keys in use; borrowed */
    uint32_t key_count; /* of those, at least 1 */
    bool posed;         /* `now` counts; else whatever is asked is of all times */
    deforming_time now;
} deforming_mesh;

/* Meshes with key_times; no description has this type, a frozen scene puts it in primitive_mesh's
 * place. Its shape is a deforming_mesh. `surface` and `bend` need a posed one, sample_area takes the
 * first key of one that is not, area the largest of the keys. */
extern const primitive_type primitive_deforming;

/* Of a checked description, of which the keys about the times from open to close are used: no ray of
 * another time may follow. -INFINITY, INFINITY: all keys. NULL: out of memory; to be freed. */
deforming_mesh *deforming_create(const mesh_desc *mesh, double open, double close);
uint32_t deforming_count_keys(const mesh_desc *mesh, double open, double close);
/* The same with all its keys in use. */
deforming_mesh deforming_whole(const deforming_mesh *m);
deforming_time deforming_find(const deforming_mesh *m, float time);
/* Positions at a key, of those in use. */
static inline const vec3 *deforming_positions(const deforming_mesh *m, uint32_t key) {
    return m->mesh.positions + (size_t)key * m->mesh.positions_count;
}

/* No fused multiply-add: the kernels compute it so, eight at a time. */
static inline float deforming_mix(float a, float b, const float weight[2]) {
    return weight[0] * a + weight[1] * b;
}

static inline bool mesh_is(const primitive_type *type) {
    return type == &primitive_mesh || type == &primitive_deforming;
}

/* A triangle of one that is posed. */
mesh_corners deforming_corners(const deforming_mesh *m, uint32_t triangle);

/* The shape as it is at a time: itself, or *room, made from it. */
static inline const void *deforming_pose(const primitive_type *type, const void *shape, float time,
                                         deforming_mesh *room) {
    if (type != &primitive_deforming) return shape;
    *room = *(const deforming_mesh *)shape;
    room->posed = true;
    room->now = deforming_find(room, time);
    return room;
}

#endif
