/* Solids as rays meet them: closed shapes under set operations, one flat list of parts and one of
 * the operations over them (Roth, Ray Casting for Modeling Solids, CGIP 18, 1982).
 *
 *     difference            nodes[0]: difference, of part 0 and node 1
 *      ├─ box               nodes[1]: union, of parts 1 and 2
 *      └─ union             parts:    box, sphere, mesh
 *          ├─ sphere
 *          └─ mesh
 *
 * A line is cut by every part into stretches inside of it; walking along all their ends, each node
 * counts how many of its children are inside, and where the whole changes there is a face. It is
 * always the whole line, from -infinity: so a ray that starts on a part's surface, or within
 * rounding of it, is on the right side of it all the same.
 *
 * Faces of two parts that coincide (that is, their planes do, within COINCIDE of their place) count
 * as crossed at once: nothing is left between touching boxes, and nothing is left of a box less
 * itself. The face then is that of the first of the parts that make it.
 *
 * A face has a number, hit.primitive: a part's faces count from its first_face. */
#ifndef SNELL_ACCEL_SOLID_H
#define SNELL_ACCEL_SOLID_H

#include "accel/solid_mesh.h"
#include "geometry/solid.h"

typedef struct solid_part {
    const primitive_type *type;
    const void *desc;       /* borrowed */
    const solid_mesh *mesh; /* of a mesh; borrowed; NULL: `spans` of the type */
    bool identity;          /* to_solid is */
    bool subtracted;        /* an odd number of times: its outside is the solid's inside */
    bool first;             /* of its node: what the others are subtracted from */
    bool has_uv;
    bool bounded;
    uint32_t node;       /* the operation that it is under */
    uint32_t first_face; /* of the solid's numbers */
    uint32_t first_slot; /* of the solid's slots: surface.material_slot counts from here */
    transform to_solid, to_local;
    bounds3 bounds; /* in the solid's space, where bounded */
} solid_part;

typedef struct solid_node {
    int operation;
    uint32_t parent;
    bool first; /* of its parent */
    uint32_t child_count;
} solid_node;

/* At most SOLID_PARTS_MAX parts, and no more nodes. */
typedef struct solid_shape {
    solid_part *parts;
    solid_node *nodes; /* the whole is nodes[0]; parents come before children */
    uint32_t *slots;   /* material of each, or NO_ID: that of the instance */
    uint32_t part_count, node_count, slot_count;
    bounds3 bounds; /* half-spaces: perhaps infinite; empty: there is nothing */
    bool textured;  /* texture coordinates are asked for */
} solid_shape;

/* Its desc is a solid_shape. The second has no box. */
extern const primitive_type solid_bounded, solid_boundless;

static inline bool solid_is(const primitive_type *type) {
    return type == &solid_bounded || type == &solid_boundless;
}
/* How many lines of this thread met more than a solid can hold, for which rays miss it, since the
 * last call: whoever traces asks before, to begin at 0, and afterwards. */
uint64_t solid_take_spent(void);
snell_status solid_error_spent(void); /* SNELL_ERR_UNSUPPORTED, and says so */
/* The part that a face belongs to. */
const solid_part *solid_find_part(const solid_shape *s, uint32_t face);
/* `bend` of a primitive_type, for a face with this curvature (as the surface has it). */
dvec3 solid_bend(const solid_shape *s, const hit *found, double curvature, dvec3 dp);
/* How many numbers the faces of a shape take. */
uint64_t solid_face_count(const primitive_type *type, const void *desc);

#endif
