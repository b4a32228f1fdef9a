/* Inside the Lua importer: the state of one running scene program, and what its parts share.
 *
 * lua.c runs a file; lua_sandbox.c makes Lua deterministic and bounded; lua_values.c turns Lua
 * values into parameters by the types' own tables; lua_objects.c is the vocabulary made from the
 * registries; lua_nodes.c keeps what is drawn; lua_solids.c puts shapes together; lua_transform.c and lua_files.c are the rest of the
 * language. Everything runs inside one lua_pcall: errors are raised with scene_fail, and all memory
 * belongs to the Lua state or to `scene`, so that nothing leaks when one is raised. */
#ifndef SNELL_IMPORTERS_LUA_SCENE_H
#define SNELL_IMPORTERS_LUA_SCENE_H

#include <lauxlib.h>
#include <lua.h>
#include <lualib.h>

#include "importers/importer.h"

/* Long products are rounded once, at the end. */
typedef dtransform placement;

/* Something that can be drawn: a shape, or a group of nodes. */
typedef struct node {
    uint32_t shape;      /* NO_SHAPE: a group */
    uint32_t material;   /* NO_MATERIAL: none given */
    bool overrides;      /* its material beats those of its parts */
    bool taken;          /* by a group or an instance: not drawn by itself */
    bool shared;         /* a group that is to be kept, however few they are */
    bool kept;           /* as a group of the description, since it is drawn more than once */
    bool has_box;        /* box is known */
    uint32_t group;      /* where kept: which shape of the description */
    uint32_t uses;       /* by groups and instances */
    uint32_t kept_depth; /* of kept groups in it, with itself */
    bounds3 box;         /* of a large group in its own space */
    uint32_t line;
    uint32_t depth; /* of groups in groups; a shape has 0 */
    size_t first_child, child_count;
    uint64_t leaf_count;
    placement placed;
    uint32_t motion; /* 0: none; 1 + index in motions: moves what `placed` puts in its place */
    char *name;      /* NULL: none; owned */
} node;
#define NO_SHAPE UINT32_MAX

/* The field motion: keys, or until the end a function. */
typedef struct lua_motion {
    motion_key *keys; /* owned */
    size_t count;
    int function;  /* a reference; LUA_NOREF: none */
    uint32_t line; /* where it is said */
    placement now; /* at the frame's own time */
} lua_motion;

/* A camera{ view, of }: its place is known when the picture's size is, at the end. */
typedef struct framing {
    uint32_t camera;
    bounds3 bounds;
    double azimuth, elevation; /* radians */
} framing;

/* The last error that this program raised through scene_fail. */
typedef struct failure {
    snell_status status;
    uint32_t line;
    char text[1024], hint[1024], file[512];
    bool final;        /* of a spent budget: nothing comes after it */
    char raised[1600]; /* the Lua error value: a different one is a later error */
} failure;

typedef struct lua_scene {
    lua_State *L;
    description *d;
    const import_options *options;
    const char *path;
    struct lua_scene *parent; /* the program that includes this one */
    uint32_t depth;

    uint64_t work, work_max; /* steps */
    double cpu_start, cpu_excluded;
    bool spent; /* the budget is used up; every further step fails */
    size_t memory, memory_max;
    uint32_t memory_line; /* where memory was last refused */
    bool string_refused;
    uint64_t random;
    uint64_t allocations;
    void *first_block; /* Lua's state */
    size_t first_size;

    node *nodes;
    size_t node_count, node_capacity;
    uint32_t *children;
    size_t child_count, child_capacity;
    lua_motion *motions;
    size_t motion_count, motion_capacity;
    framing *framings;
    size_t framing_count, framing_capacity;
    failure failure;
} lua_scene;

static inline lua_scene *scene_of(lua_State *L) { return *(lua_scene **)lua_getextraspace(L); }

/* ---- errors ---- */
/* Raises an error at the line that the program is at. Statuses of wrong values become
 * SNELL_ERR_SYNTAX: the file is wrong, not the call. */
_Noreturn void scene_fail(lua_State *L, snell_status status, const char *hint, const char *format,
                          ...) PRINTF_LIKE(4, 5);
/* Raises the thread's last error; its prefix "type:" becomes `label` unless that is NULL. */
_Noreturn void scene_fail_last(lua_State *L, const char *type, const char *label);
/* The line of the innermost Lua function, and its file; 0 and the program's path when there is
 * none. */
uint32_t scene_line(lua_State *L, const char **file);
/* A word that is not there: "SUBJECT 'word'", with a suggestion; or "not in this version" for words
 * that the language has. label: the table it was looked for in, NULL for the globals. Sorts
 * names. */
_Noreturn void scene_fail_unknown(lua_State *L, const char *label, const char *subject,
                                  const char *word, const char **names, size_t count);
/* Of the language, but not of this version. label as above, or "word" for choices. */
bool scene_is_later(const char *label, const char *word);

/* ---- lua_sandbox.c ---- */
void *sandbox_allocate(void *user, void *old, size_t old_size, size_t new_size);
/* Opens the libraries that remain and sets the limits. */
void sandbox_open(lua_State *L);
/* True when strings are hashed with our seed. */
bool sandbox_is_seeded(lua_State *L);
/* Counts work that happens in C, where no instruction is counted. */
void sandbox_charge(lua_State *L, uint64_t steps);
/* Pushes the value as text without addresses. */
const char *sandbox_tostring(lua_State *L, int index);
/* Makes reading an unknown member of the table on the top an error: `label`: unknown NAME. */
void sandbox_guard(lua_State *L, const char *label);
double sandbox_cpu_seconds(void);

/* ---- lua_pow.c ---- */
/* True when the Lua library computes x^y by our pow. */
bool pow_is_ours(lua_State *L);

/* ---- lua_values.c ---- */
/* The table at index 1 may have these names and positional values 1..positional only. */
void values_check_keys(lua_State *L, const char *label, const char *const *names, size_t count,
                       lua_Integer positional);
/* The table at index 1, or an error that shows the form "label { ... }". */
void values_need_table(lua_State *L, const char *label);
/* The value on the top as a field of `type`; what the parameter points to stays on the stack. */
void values_read_field(lua_State *L, const type_info *type, const field *f, const char *label,
                       snell_param *out);
/* The value at `index`: three finite numbers. `name` is for messages. */
void values_read_vec3(lua_State *L, int index, const char *label, const char *name, double out[3]);
double values_read_number(lua_State *L, int index, const char *label, const char *name);
/* The number on the top, an entry of the list `name`: number `row` from 1, or number `column` from 1
 * of it (0: the list is not nested). An error names it. */
double values_read_entry(lua_State *L, const char *label, const char *name, size_t row,
                         size_t column);
/* Two names of the table at index 1 that stand for one another. */
void values_refuse_both(lua_State *L, const char *label, const char *one, const char *other);
/* Fields of the table at index 1, NULL or false when absent. */
const char *values_get_string(lua_State *L, const char *label, const char *name);
bool values_get_bool(lua_State *L, const char *label, const char *name, bool absent);
uint32_t values_get_material(lua_State *L, const char *label); /* NO_MATERIAL when absent */

/* ---- handles: userdata for what the program holds ---- */
#define HANDLE_MATERIAL "material"
#define HANDLE_TEXTURE "texture"
#define HANDLE_SHAPE "shape"
#define HANDLE_TRANSFORM "transform"
#define HANDLE_BOX "box"
/* Memory that is not Lua's, freed with the box: an error may be raised while it is held. */
typedef struct box {
    void *held;
    void (*destroy)(void *held);
} box;
box *box_push(lua_State *L, void (*destroy)(void *held));
void handle_push(lua_State *L, const char *kind, uint32_t index);
int texture_multiply(lua_State *L); /* __mul of HANDLE_TEXTURE */
bool handle_get(lua_State *L, int index, const char *kind, uint32_t *out);

/* ---- lua_transform.c ---- */
placement values_get_placement(lua_State *L, const char *label); /* field transform of table 1 */
/* By how many degrees two transforms of the program differ, as their angles were given: 360 between
 * none and a whole turn. NaN where it is not known. Both point into userdata. */
double transform_turn_between(const placement *from, const placement *to);
void transform_open(lua_State *L);

/* ---- lua_motion.c ---- */
void motion_open(lua_State *L); /* animation */
void motion_free_all(lua_scene *s);
/* Sets the globals time and frame once the clock is known. */
void motion_set_clock(lua_State *L);
/* What it reads with these options is seen at the scene's own frame, if it has a clock. */
void motion_give_clock(lua_State *L, import_options *to);
/* Field motion of table 1: a node's motion, 0 when absent. */
uint32_t motion_read(lua_State *L, const char *label);
uint32_t motion_add(lua_State *L, const motion_key *keys, size_t count); /* checked keys, copied */
/* The value on the top as the keys of a camera, which stay on the stack. */
void motion_read_keys(lua_State *L, const char *label, const field *f, snell_param *out);
/* At the end, when cameras are known: functions become keys. */
void motion_sample_functions(lua_State *L);
/* The keys of a leaf under these nodes, one of which moves; pushes what holds them. */
const motion_key *motion_of_chain(lua_State *L, const uint32_t *path, size_t depth, size_t *count);

/* ---- lua_nodes.c ---- */
/* Adds a node and pushes its handle. `like` gives everything but children; its name is copied. */
void nodes_add_shape(lua_State *L, const node *like);
/* The children are the node indices in `indices`. They are taken. */
void nodes_add_group(lua_State *L, const node *like, const char *label, const uint32_t *indices,
                     size_t count);
bounds3 nodes_bounds(lua_State *L, uint32_t index);
/* Reads the shapes at 1..count of the table at index 1 into a userdata on the stack. */
uint32_t *nodes_read_parts(lua_State *L, const char *label, size_t count);
/* Every shape under a node, with the material and the place that it has by the groups around it;
 * moves: it or one of them has a motion. */
typedef void node_leaf_fn(lua_State *L, void *user, const node *leaf, bool moves);
void nodes_each_leaf(lua_State *L, uint32_t index, node_leaf_fn *visit, void *user);
/* Gives every node that no other took its instances. */
void nodes_draw(lua_State *L);
void nodes_free(lua_scene *s);
void nodes_open(lua_State *L); /* group, instance */

/* ---- lua_solids.c ---- */
void solids_open(lua_State *L); /* union, intersection, difference */

/* ---- lua_objects.c ---- */
/* The material, transform and name of the table at index 1. */
node objects_read_common(lua_State *L, const char *label, const char **name);
void objects_open(lua_State *L);
void objects_frame_cameras(lua_State *L);

/* ---- lua_files.c ---- */
void files_open(lua_State *L); /* model, include, param */
/* A mesh from a file: mesh { file = }. Pushes the node. */
int files_mesh(lua_State *L);
int files_image(lua_State *L, const type_info *type); /* texture.image { file = } */
/* The picture of the surroundings of light.environment { file = }: the number of its texture, from 1.
 */
uint32_t files_environment(lua_State *L);
/* Pushes a box with the decoded image. */
const struct decoded_image *files_read_image(lua_State *L, const char *name);
/* lua_heights.c: turns the other forms of heightfield { } at index 1 into the plain one. */
void heights_expand(lua_State *L);
/* lua_keys.c: the same for mesh { keys = .. }. */
void mesh_keys_expand(lua_State *L);
/* The file that the program calls `name`, by its path, on the stack. */
const char *files_resolve(lua_State *L, const char *name);
void files_check_params(lua_State *L);

#endif
