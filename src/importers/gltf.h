/* The glTF 2.0 reader's own parts (specification: registry.khronos.org/glTF/specs/2.0).
 *
 *     gltf.c            container (.gltf, .glb), JSON, versions, extensions, the order of work
 *     gltf_schema.c     every property's type, range and reference, checked once, from tables
 *     gltf_check.c      what holds between properties: attributes, targets, extensions
 *     gltf_values.c     what holds for the numbers in buffers: bounds, lengths, order
 *     gltf_buffers.c    buffers, views, accessors, images' bytes
 *     gltf_materials.c  textures and materials
 *     gltf_meshes.c     primitives, morph targets, skins
 *     gltf_animation.c  the animation that was asked for, its clock and its tracks
 *     gltf_nodes.c      the node tree: instances, cameras, lights
 *
 * After gltf_check_schema the JSON's types can be relied on, so that the rest reads values without
 * asking again. What a file holds is counted against a budget, since a short file can ask for a lot
 * (an accessor without data, one accessor used a thousand times). */
#ifndef SNELL_IMPORTERS_GLTF_H
#define SNELL_IMPORTERS_GLTF_H

#include <jansson.h>

#include "importers/image_decode.h"
#include "importers/importer.h"
#include "importers/names.h"

enum { JSON_PATH_SIZE = 200 };
/* OpenGL's numbers: component types of accessors; targets of buffer views. */
enum {
    GL_BYTE = 5120,
    GL_UBYTE,
    GL_SHORT,
    GL_USHORT,
    GL_UINT = 5125,
    GL_FLOAT,
    GL_VERTICES = 34962,
    GL_INDICES
};

typedef struct byte_block {
    const uint8_t *data;
    size_t size;
    uint8_t *owned; /* NULL when data points into the GLB */
    bool loaded;
} byte_block;

typedef struct image_entry {
    decoded_image image;
    bool tried; /* pixels NULL afterwards: it could not be read, which was said */
} image_entry;

typedef struct texture_entry { /* made before: see gltf_texture */
    uint32_t texture;
    int use;
    bool second; /* looked up by the mesh's second set of texture coordinates */
    float ramp[2], transform[5];
    snell_texture_id id;
} texture_entry;

typedef struct mesh_entry { /* shapes of a mesh that is neither skinned nor morphed by its node */
    uint32_t *shapes;       /* one per primitive; NO_SHAPE where nothing is drawn */
    size_t count;
} mesh_entry;
#define NO_SHAPE UINT32_MAX

typedef struct dmat { /* 3x4, row-major, acts on column vectors */
    double m[3][4];
} dmat;

/* What an animation does to one property of a node. */
enum { TRACK_TRANSLATION, TRACK_ROTATION, TRACK_SCALE, TRACK_WEIGHTS, TRACK_KINDS };
enum { INTERPOLATE_STEP, INTERPOLATE_LINEAR, INTERPOLATE_CUBIC };
typedef struct gltf_track {
    int interpolation;
    float *times, *values; /* owned; count keys; values: as the accessor has them */
    size_t count, width;   /* at least one; numbers of a value */
} gltf_track;

/* The moments at which what moves is written down, from a frame before the frame's own time, which is
 * number CLOCK_NOW, to a frame after. Meshes that deform have every CLOCK_STRIDE-th. */
enum { CLOCK_NOW = 16, CLOCK_TIMES = 2 * CLOCK_NOW + 1, CLOCK_STRIDE = 4 };

typedef struct gltf_node {
    size_t parent;                   /* SIZE_MAX: a root */
    dmat world;                      /* at rest, or at the frame's own time */
    gltf_track *tracks[TRACK_KINDS]; /* owned; NULL: as the node says */
    dmat *worlds; /* owned; at each of the clock's times; NULL: it stands still */
} gltf_node;

typedef struct gltf {
    const char *path; /* as it was typed */
    const import_options *options;
    description *d;
    json_t *root;
    uint8_t *file; /* of a GLB, for bin */
    const uint8_t *bin;
    size_t bin_size;
    bool has_bin, is_glb;
    uint64_t budget; /* bytes that may still be made */
    byte_block *buffers;
    image_entry *images;
    texture_entry *textures;
    size_t texture_count, texture_capacity;
    uint32_t *materials;       /* index in the description; NO_MATERIAL: not made yet */
    unsigned (*uv_sets_of)[2]; /* of each material, plus 1; 0: not looked for yet */
    uint32_t default_material;
    mesh_entry *meshes;
    gltf_node *nodes;
    size_t instance_count;
    bool posed; /* an animation moves it: tracks and times are set */
    float times[CLOCK_TIMES];
    double duration;     /* of the animation, seconds */
    double size;         /* see gltf_scene_size; 0: not known yet */
    unsigned uv_sets[2]; /* of the material that is being read */
    name_set names;
} gltf;

/* ---- errors and warnings (gltf.c): where is a JSON path such as "accessors[3].bufferView" ---- */
snell_status gltf_error(const gltf *g, snell_status status, const char *where, const char *format,
                        ...) PRINTF_LIKE(4, 5);
/* Puts file and JSON path in front of the last error. */
snell_status gltf_blame(const gltf *g, const char *where, snell_status status);
snell_status gltf_warn(gltf *g, const char *format, ...) PRINTF_LIKE(2, 3);
/* Takes bytes from the budget. */
snell_status gltf_spend(gltf *g, const char *where, uint64_t size);

/* ---- reading JSON that was checked ---- */
static inline json_t *json_at(const json_t *owner, const char *key) {
    return json_object_get(owner, key);
}
static inline json_t *json_item(const gltf *g, const char *list, size_t index) {
    return json_array_get(json_object_get(g->root, list), index);
}
static inline size_t json_count(const gltf *g, const char *list) {
    return json_array_size(json_object_get(g->root, list));
}
static inline json_t *json_extension(const json_t *owner, const char *name) {
    return json_object_get(json_object_get(owner, "extensions"), name);
}
double json_number(const json_t *owner, const char *key, double otherwise);
/* Whole numbers from 0; otherwise when there is none. */
size_t json_index(const json_t *owner, const char *key, size_t otherwise);
const char *json_text(const json_t *owner, const char *key); /* NULL: none */
bool json_flag(const json_t *owner, const char *key);
/* Fills out[0..count) from an array where there is one. */
void json_numbers(const json_t *owner, const char *key, double *out, size_t count);

snell_status gltf_check_schema(gltf *g);
snell_status gltf_check_meaning(gltf *g);
snell_status gltf_check_joints(gltf *g); /* after gltf_read_scene */
snell_status gltf_check_values(gltf *g); /* after gltf_read_all_buffers */

/* ---- buffers ---- */
snell_status gltf_check_views(gltf *g); /* views lie in buffers, accessors in views */
snell_status gltf_check_uses(gltf *g);  /* what a view is used for fits; after gltf_check_meaning */
snell_status gltf_read_all_buffers(gltf *g); /* those that nothing needed, too */
size_t gltf_accessor_count(const gltf *g, size_t index);
unsigned gltf_accessor_components(const gltf *g, size_t index);
/* All elements as floats (normalised integers become -1..1), `components` per element as the
 * accessor must have. The caller frees. */
snell_status gltf_accessor_floats(gltf *g, size_t index, unsigned components, const char *where,
                                  float **out);
/* The same for whole numbers: unsigned component types only. */
snell_status gltf_accessor_uints(gltf *g, size_t index, unsigned components, const char *where,
                                 uint32_t **out);
/* All numbers as they lie in the buffer, whole ones not normalised. The caller frees. */
snell_status gltf_accessor_stored(gltf *g, size_t index, float **out);
/* Whether it has bytes: else its elements are zero, or an extension brings them. */
bool gltf_accessor_has_data(const gltf *g, size_t index);
/* The bytes of a view, not owned. */
snell_status gltf_view_bytes(gltf *g, size_t index, const uint8_t **data, size_t *size);
/* The bytes of an image: from a view (not owned) or a URI (owned). */
snell_status gltf_image_bytes(gltf *g, size_t index, byte_block *out);

/* ---- materials ---- */
/* index SIZE_MAX: the default material. */
snell_status gltf_material(gltf *g, size_t index, uint32_t *out);
/* The set of texture coordinates that the material's base colour (or else emission, ...) uses, and the
 * next one that another texture does. */
#define NO_UV_SET 0x100u
void gltf_material_uv_sets(const gltf *g, size_t index, unsigned sets[2]);
bool gltf_material_has_grain(const gltf *g, size_t index); /* looks along tangents */
bool gltf_material_has_alpha(const gltf *g, size_t index);
/* An image that no texture names and that cannot be read: a warning. */
snell_status gltf_check_unused_images(gltf *g);

/* ---- meshes ---- */
/* Makes the shape of every primitive for this node; *shapes: one per primitive, owned by g (a
 * cache) unless *own, when the caller frees them. in_world: the vertices are in world space (a
 * skin). */
snell_status gltf_mesh_shapes(gltf *g, size_t node, const uint32_t **shapes, bool *own,
                              bool *in_world);

/* ---- animation ---- */
snell_status gltf_check_animation(gltf *g, size_t index);
/* Reads the tracks of the animation that the options ask for, if they ask for any, and adds the clock
 * to the description; times that it shows are g->times. */
snell_status gltf_choose_animation(gltf *g);
/* The track's value, t->width numbers, at a time in seconds. */
void gltf_track_at(const gltf_track *t, int kind, double time, double *out);
void gltf_free_animation(gltf *g);

/* ---- nodes ---- */
snell_status gltf_read_scene(gltf *g);
/* How much longer things become, in the mean of all directions; 1 where that is 0. */
double gltf_scale(const dmat *a);
/* The diagonal of the box about all meshes that nodes draw, by what their accessors say, metres. */
double gltf_scene_size(gltf *g);
/* At the clock's time number i. */
static inline const dmat *gltf_world_at(const gltf_node *node, int i) {
    return node->worlds ? &node->worlds[i] : &node->world;
}
dmat dmat_multiply(const dmat *a, const dmat *b);
dvec3 dmat_point(const dmat *a, dvec3 p);
dvec3 dmat_vector(const dmat *a, dvec3 v);
dmat dmat_from_columns(const double *m); /* 16 numbers, column-major */

#endif
