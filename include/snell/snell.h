/* snell: a ray tracer. This is the only public header; it is C17 and valid C++17.
 *
 * Conventions, stated once: right-handed, +Y up, a camera looks along its -Z, metres, seconds,
 * radians. Matrices are 3x4, row-major, and act on column vectors. Colours are scene-linear with
 * Rec. 709 primaries. Ownership: each create has one destroy; ids are values owned by their scene,
 * {0} means none. Arrays and strings passed in are copied before the call returns. Outputs are
 * written only on SNELL_OK, except where a function says otherwise. The library never prints, exits
 * or forks; what it may start is named at snell_load_desc.allow_helper. Threads: a scene is read by
 * many threads OR edited by one. An edit during a render or a commit gives SNELL_ERR_STATE.
 * Contexts are independent. Callbacks must not call the same scene, nor render, commit or
 * intersect_all in the same context: its workers are busy. Not promised: pictures equal
 * across minor versions; the layout of opaque objects; which of two unrelated errors is reported
 * first. */
#ifndef SNELL_SNELL_H
#define SNELL_SNELL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* C linkage and, while the library itself is built, default visibility. */
#if defined(snell_EXPORTS) && defined(__GNUC__)
#define SNELL_VISIBLE __attribute__((visibility("default")))
#else
#define SNELL_VISIBLE
#endif
#ifdef __cplusplus
#define SNELL_API extern "C" SNELL_VISIBLE
#else
#define SNELL_API SNELL_VISIBLE
#endif

#define SNELL_VERSION_MAJOR 0
#define SNELL_VERSION_MINOR 1
#define SNELL_VERSION_PATCH 0

/* ---- errors and messages --------------------------------------------------------------------- */

typedef enum snell_status {
    SNELL_OK = 0,
    SNELL_CANCELLED,    /* a progress callback said stop */
    SNELL_ERR_ARGUMENT, /* a value passed to the call is out of its range */
    SNELL_ERR_STATE,  /* the call does not fit the object's state (edit during render, no commit) */
    SNELL_ERR_MEMORY, /* out of memory, or over a limit that was set */
    SNELL_ERR_IO,     /* a file could not be read or written */
    SNELL_ERR_SYNTAX, /* a file's content is wrong */
    SNELL_ERR_UNSUPPORTED, /* understood, but this build or version cannot do it */
    SNELL_ERR_VERSION,     /* header and library do not fit */
    SNELL_ERR_INTERNAL     /* a fault in snell itself: please report */
} snell_status;

typedef enum snell_severity {
    SNELL_DEBUG = 1,
    SNELL_INFO,
    SNELL_WARNING,
    SNELL_ERROR
} snell_severity;

/* Strings live until this thread's next snell call (in a log callback: until it returns). */
typedef struct snell_message {
    snell_status status;
    snell_severity severity;
    const char *text, *hint, *file; /* never NULL, "" when there is none; hint: what to do next */
    uint32_t line, column;          /* from 1; 0 when unknown */
} snell_message;

SNELL_API const snell_message *snell_last_error(void); /* of the calling thread; never NULL */
typedef void snell_log_fn(void *user, const snell_message *message);

/* ---- values ---------------------------------------------------------------------------------- */

typedef struct snell_context snell_context;
typedef struct snell_scene snell_scene;
typedef struct snell_film snell_film;

typedef struct snell_shape_id {
    uint32_t index1, generation;
} snell_shape_id;
typedef struct snell_material_id {
    uint32_t index1, generation;
} snell_material_id;
typedef struct snell_texture_id {
    uint32_t index1, generation;
} snell_texture_id;
typedef struct snell_light_id {
    uint32_t index1, generation;
} snell_light_id;
typedef struct snell_camera_id {
    uint32_t index1, generation;
} snell_camera_id;
typedef struct snell_instance_id {
    uint32_t index1, generation;
} snell_instance_id;

typedef struct snell_vec2 {
    float x, y;
} snell_vec2;
typedef struct snell_vec3 {
    float x, y, z;
} snell_vec3;
typedef struct snell_bounds {
    snell_vec3 min, max;
} snell_bounds; /* empty: min > max */
typedef struct snell_transform {
    float m[3][4];
} snell_transform;
/* Where something that moves is at a time, in seconds on the scene's clock. Between keys translations
 * and scales go straight, rotations along the shorter arc; before the first and after the last key it
 * stands still. */
typedef struct snell_motion_key {
    float time;
    snell_transform transform;
} snell_motion_key;
/* What varies over a surface: value times texture (texture {0}: the value alone). Scalars read
 * value.x. */
typedef struct snell_input {
    snell_vec3 value;
    snell_texture_id texture;
} snell_input;

/* Every description begins with its size and is made by SNELL_INIT: then it has its defaults, and
 * structs may grow without breaking anyone. */
#define SNELL_INIT(type) snell_##type##_init(sizeof(snell_##type))

/* ---- context: threads, instruction set, log -------------------------------------------------- */

typedef enum snell_isa {
    SNELL_ISA_AUTO = 0,
    SNELL_ISA_SCALAR,
    SNELL_ISA_AVX2,
    SNELL_ISA_AVX512
} snell_isa;

/* How long a commit builds, and how fast rays are then. The picture does not depend on it. */
typedef enum snell_build {
    SNELL_BUILD_BALANCED = 0,
    SNELL_BUILD_FAST, /* for pictures of few rays */
    SNELL_BUILD_BEST  /* for pictures of many */
} snell_build;

typedef struct snell_context_desc {
    size_t struct_size;
    snell_log_fn *log; /* NULL: silent; may be called from any thread, one call at a time */
    void *user;
    uint32_t thread_count; /* 0: the CPUs this process may use, cgroup limit included */
    snell_isa isa_max;     /* the picture does not depend on it */
    /* Bytes that a commit may take for the geometry of a scene, stated before it is taken (stats'
     * memory_planned): more is SNELL_ERR_MEMORY. 0: not limited. */
    uint64_t memory_max;
    snell_build build;
} snell_context_desc;

static inline snell_context_desc snell_context_desc_init(size_t struct_size) {
    snell_context_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    return desc;
}
SNELL_API snell_status snell_context_create(const snell_context_desc *desc,
                                            snell_context **out); /* desc may be NULL */
SNELL_API void snell_context_destroy(snell_context *context);     /* NULL is fine, here and below */
SNELL_API uint32_t snell_context_thread_count(const snell_context *context);
SNELL_API snell_isa snell_context_isa(const snell_context *context); /* what is used, never AUTO */
SNELL_API const char *snell_isa_name(snell_isa isa); /* "scalar", "avx2", "avx512", "auto" */
SNELL_API const char *snell_version(void);           /* "0.1.0" */
/* Optional parts built in, such as "assimp openexr avx2 avx512", and what is missing: "" when
 * nothing. */
SNELL_API const char *snell_features(const char **missing);

/* ---- scene: load, edit, commit --------------------------------------------------------------- */

typedef struct snell_progress {
    size_t struct_size;
    const char *phase;             /* "read", "build", "render" */
    double fraction, seconds_left; /* fraction in [0,1]; seconds negative while unknown */
    uint64_t rays_traced;
    uint32_t pass, x0, y0, x1, y1; /* the pixels that are worked on, half-open */
    double noise; /* of a render to a stated error: the largest bound of any block; 0: not known */
} snell_progress;
/* Called at least every 100 ms, never two at once, from the thread that made the call or from a
 * worker; false cancels. Calls that need all workers of one context take turns: while one waits for
 * another's render to end, its own progress is silent. */
typedef bool snell_progress_fn(void *user, const snell_progress *progress);

typedef struct snell_load_desc {
    size_t struct_size;
    const char *const *params; /* "name=value", for param() in a scene program; of a glTF file with
                                  animations "animation=NAME" and "fps=24" */
    size_t param_count;
    const char *const *asset_dirs; /* readable besides the file's own folder */
    size_t asset_dir_count;
    const char *format;  /* such as "gltf"; NULL: by the file's content and extension */
    const char *up;      /* "x" "y" "z" "-x" "-y" "-z"; NULL: as the format says */
    uint64_t memory_max; /* bytes the import may use; 0: a share of the machine's memory */
    double time_max;     /* CPU seconds the import may use; 0: 300 */
    uint32_t frame;      /* which frame of an animation, 1 to 1000000; 0: a scene's first, a model
                            file at rest */
    bool allow_programs; /* run .lua; default true */
    /* Files are read by the sandboxed program snell-import, started with posix_spawn; default true.
     * false: only snell_scene_add_* and compiled scenes. */
    bool allow_helper;
    snell_progress_fn *progress;
    void *user;
    bool next_frame; /* functions of time are asked about the next frame too, for the AOV motion, as
                            they are where render{} asks for that; default false */
} snell_load_desc;

static inline snell_load_desc snell_load_desc_init(size_t struct_size) {
    snell_load_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.allow_programs = true;
    desc.allow_helper = true;
    return desc;
}
SNELL_API snell_status snell_scene_create(snell_context *context, snell_scene **out);
SNELL_API void snell_scene_destroy(snell_scene *scene);
/* Adds the file's objects to the scene; on failure the scene is as before. */
SNELL_API snell_status snell_scene_load(snell_scene *scene, const char *path,
                                        const snell_load_desc *desc);
/* Writes what was added, committed or not, by the path's extension; the path has the old file or the whole
 * new one.
 *   .snell  a compiled scene, of this version of the library: snell_scene_load reads it in no time, and its
 *           pictures are the same to the bit. One frame of an animation; params have their values.
 *   .lua    a program in the scene language, with the same pictures to the bit; its large meshes and images
 *           go to files in the folder NAME.files beside NAME.lua
 * SNELL_ERR_UNSUPPORTED: the format cannot say something that is in the scene, such as a shape by the
 * caller's own functions; the error names it. */
SNELL_API snell_status snell_scene_save(const snell_scene *scene, const char *path);

/* The studio rig: a camera that frames everything, a key light over its shoulder, a fill and a
 * gradient that metals can reflect; only what the scene lacks. `view`, when not NULL, is what a
 * missing camera sees, and over whose shoulder the light comes even if there is a camera. `added`
 * (may be NULL) receives a static string such as "camera, lights", "" when nothing was added. */
struct snell_view;
SNELL_API snell_status snell_scene_add_studio(snell_scene *scene, const struct snell_view *view,
                                              const char **added);
/* The same under a clear sky by day, with the sun over the view's left shoulder, 40 degrees high; on a
 * white surface that faces the sun they add up to a radiance of about 1. `visible`: the camera sees the
 * sky, otherwise the background. snell_scene_turn_studio leaves it where it is. */
SNELL_API snell_status snell_scene_add_daylight(snell_scene *scene, const struct snell_view *view,
                                                bool visible, const char **added);
/* Turns the studio's lights about the vertical axis, as snell_view_turn turns a view: by `angle` radians from where
 * snell_scene_add_studio put them. Nothing happens where it added none. What is rendered next is lit so, without another
 * commit. */
SNELL_API snell_status snell_scene_turn_studio(snell_scene *scene, double angle);
/* A large horizontal disk under everything that was added so far; +Y is up. It touches what it is
 * under, but lies 1e-4 of the size below what has no height. */
SNELL_API snell_status snell_scene_add_ground(snell_scene *scene, snell_vec3 color,
                                              snell_instance_id *out);

/* Generic form of adding, for language bindings and importers: `type` and the names of `params` are
 * those of the scene language. Unknown names, wrong kinds and values out of range give
 * SNELL_ERR_ARGUMENT with a hint. */
typedef enum snell_param_kind {
    SNELL_PARAM_BOOL = 1,  /* b */
    SNELL_PARAM_INT,       /* i; accepted for floats too */
    SNELL_PARAM_FLOAT,     /* f; accepted for colours (grey) and inputs too */
    SNELL_PARAM_VEC3,      /* v: point, vector, colour */
    SNELL_PARAM_STRING,    /* s: string or choice */
    SNELL_PARAM_TEXTURE,   /* texture */
    SNELL_PARAM_INPUT,     /* input: value and texture */
    SNELL_PARAM_MATERIAL,  /* material */
    SNELL_PARAM_TRANSFORM, /* transform */
    SNELL_PARAM_ARRAY      /* array of what the field says; count in elements (vec3s, vec2s, uints,
                              bytes) */
} snell_param_kind;

typedef struct snell_param {
    const char *name;
    snell_param_kind kind;
    union {
        bool b;
        int64_t i;
        double f;
        snell_vec3 v;
        const char *s;
        snell_texture_id texture;
        snell_input input;
        snell_material_id material;
        snell_transform transform;
        struct {
            const void *data;
            size_t count;
        } array;
    } value;
} snell_param;

SNELL_API snell_status snell_scene_add_texture(snell_scene *scene, const char *type,
                                               const snell_param *params, size_t count,
                                               snell_texture_id *out);
SNELL_API snell_status snell_scene_add_material(snell_scene *scene, const char *type,
                                                const snell_param *params, size_t count,
                                                snell_material_id *out);
SNELL_API snell_status snell_scene_add_light(snell_scene *scene, const char *type,
                                             const snell_param *params, size_t count,
                                             snell_light_id *out);
SNELL_API snell_status snell_scene_add_shape(snell_scene *scene, const char *type,
                                             const snell_param *params, size_t count,
                                             snell_shape_id *out);
/* A shape of your own, by functions: docs/add-a-shape.md makes one. It has primitive_count parts, each
 * with a box by which rays find it. All is in the shape's own space, metres; an instance places it.
 *
 * The functions are called from many threads at once, while others read the same data: they change
 * nothing, call nothing of this library that takes the same scene, and give the same result for the
 * same arguments, on every machine if the picture shall be the same there. They run with rounding to
 * nearest. `user` and what it points to stay as they are until the scene is destroyed.
 *
 * bounds: a box around every point that intersect may find; min > max: there is nothing.
 * intersect: the nearest hit with t_min < t < t_max, where t is compared after it is rounded to float;
 * false: none. A ray that leaves the surface starts beyond `error`, and must not find it again.
 * surface: of a hit that intersect gave for the same ray. `position` is on the surface as exactly as
 * you can: not the ray's point, but that brought back to the surface; `error` bounds the distance along
 * the normal between it and the surface that intersect sees from there, roundings of double excepted. */
typedef struct snell_user_ray {
    snell_vec3 origin;
    float t_min;
    snell_vec3 direction; /* of any length; t counts in lengths of it */
    float t_max;
} snell_user_ray;
typedef struct snell_user_hit {
    float t, u, v; /* u, v: your own, for surface */
} snell_user_hit;
typedef struct snell_user_surface {
    double position[3]; /* as the function is called: the ray's point at t */
    double normal[3];   /* of any length, outward */
    double error;       /* metres, >= 0 */
    double curvature;   /* 1/m, the largest where the surface bends away from the normal; flat: 0 */
    double uv[2];       /* texture coordinates */
} snell_user_surface;
typedef struct snell_user_shape_desc {
    size_t struct_size;
    void *user;
    uint32_t primitive_count; /* from 1 to 2^28 - 2 */
    void (*bounds)(void *user, uint32_t primitive, snell_bounds *out);
    bool (*intersect)(void *user, uint32_t primitive, const snell_user_ray *ray,
                      snell_user_hit *out);
    void (*surface)(void *user, uint32_t primitive, const snell_user_ray *ray,
                    const snell_user_hit *hit, snell_user_surface *out);
} snell_user_shape_desc;
static inline snell_user_shape_desc snell_user_shape_desc_init(size_t struct_size) {
    snell_user_shape_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.primitive_count = 1;
    return desc;
}
/* desc is copied; bounds is called before this returns, and again at commit. It casts shadows, is seen
 * in mirrors and lights others if its material shines, as every shape; it cannot bound glass. */
SNELL_API snell_status snell_scene_add_user_shape(snell_scene *scene,
                                                  const snell_user_shape_desc *desc,
                                                  const char *name, snell_shape_id *out);
SNELL_API snell_status snell_scene_add_camera(snell_scene *scene, const char *type,
                                              const snell_param *params, size_t count,
                                              snell_camera_id *out);
/* A shape is drawn where an instance of it stands; to_world NULL is the identity. material {0}: a
 * grey Lambert. */
SNELL_API snell_status snell_scene_add_instance(snell_scene *scene, snell_shape_id shape,
                                                snell_material_id material,
                                                const snell_transform *to_world,
                                                snell_instance_id *out);
/* Instances that are drawn become the parts of a group, one shape that is drawn where an instance of
 * it stands, as often as you like: its parts are kept once. Groups are parts of groups up to 8 deep.
 * The parts keep their ids and can be moved and removed: that changes every copy. An instance of a
 * group with a material replaces those of the parts, but for a mesh's own slots. name may be NULL. */
SNELL_API snell_status snell_scene_add_group(snell_scene *scene, const snell_instance_id *parts,
                                             size_t count, const char *name, snell_shape_id *out);
SNELL_API snell_status snell_scene_set_instance_transform(snell_scene *scene, snell_instance_id id,
                                                          const snell_transform *to_world);
/* It moves by these keys (checked, copied); rays see it at their own time. What no camera's shutter
 * sees is left out at commit. Ended by snell_scene_set_instance_transform. */
SNELL_API snell_status snell_scene_set_instance_motion(snell_scene *scene, snell_instance_id id,
                                                       const snell_motion_key *keys, size_t count);
SNELL_API snell_status snell_scene_remove_instance(snell_scene *scene, snell_instance_id id);

/* Settings exist once: a call replaces what the file said. Radiances, >= 0; alpha in [0,1]: 0 makes
 * a transparent picture's background clear. The gradient runs from straight down to straight up. */
SNELL_API snell_status snell_scene_set_background(snell_scene *scene, snell_vec3 color,
                                                  float alpha);
SNELL_API snell_status snell_scene_set_background_gradient(snell_scene *scene, snell_vec3 bottom,
                                                           snell_vec3 top);
SNELL_API snell_status snell_scene_set_ambient(snell_scene *scene,
                                               snell_vec3 color); /* the lecture's L_a */

/* The clock of what moves: frame f is at (f - 1) / fps seconds, and a camera's shutter counts in frames
 * from there. */
typedef struct snell_animation {
    size_t struct_size;
    float fps;
    int32_t first, last, frame; /* from 1; frame: which one the scene is of */
    uint32_t frame_count;       /* written by get only: 0 when the scene has no animation */
} snell_animation;
static inline snell_animation snell_animation_init(size_t struct_size) {
    snell_animation clock;
    memset(&clock, 0, sizeof clock);
    clock.struct_size = struct_size;
    clock.fps = 24;
    clock.first = 1;
    clock.last = 120;
    clock.frame = 1;
    return clock;
}
SNELL_API snell_status snell_scene_set_animation(snell_scene *scene, const snell_animation *clock);
SNELL_API snell_status snell_scene_get_animation(
    const snell_scene *scene, snell_animation *out); /* out->struct_size set by the caller */

/* Freezes what was added: checks, builds the acceleration structures. Queries and renders see the
 * last commit. */
SNELL_API snell_status snell_scene_commit(snell_scene *scene, snell_progress_fn *progress,
                                          void *user);
/* Of the last commit, before the first one of what was added; without planes. */
SNELL_API snell_status snell_scene_bounds(const snell_scene *scene, snell_bounds *out);

/* What is in a scene; strings are owned by the scene and live until its next edit. */
typedef struct snell_scene_stats {
    size_t struct_size;
    const char *format; /* of the last file loaded, "" for none */
    uint64_t instance_count, primitive_count,
        triangle_count; /* primitives and triangles as instanced */
    uint64_t unique_triangle_count;
    uint32_t shape_count, material_count, texture_count, light_count, camera_count, param_count;
    uint64_t memory_geometry, memory_accel, memory_textures; /* bytes; accel: 0 before a commit */
    /* Bytes that a commit takes for geometry at most, besides memory_geometry, at any quality and this
     * number of threads, if no group is drawn with several materials of its instances; without motions
     * and lights. */
    uint64_t memory_planned;
    bool has_emission, has_background, has_ambient, has_dielectric;
} snell_scene_stats;
SNELL_API snell_status snell_scene_get_stats(
    const snell_scene *scene, snell_scene_stats *out); /* out->struct_size set by the caller */

/* Of everything that was added and decides a picture, committed or not: not of names, nor of files and
 * lines that it came from. The same on every machine; another version's may differ.
 * SNELL_ERR_UNSUPPORTED: a shape by the caller's own functions is among it. */
SNELL_API snell_status snell_scene_hash(const snell_scene *scene, uint64_t *out);

typedef struct snell_object_info {
    const char *type, *name;
    uint32_t line;
} snell_object_info; /* name "" when unnamed */
SNELL_API snell_status snell_scene_get_camera(const snell_scene *scene, uint32_t index,
                                              snell_object_info *out, snell_camera_id *id);
SNELL_API snell_status snell_scene_get_light(const snell_scene *scene, uint32_t index,
                                             snell_object_info *out);
SNELL_API snell_status snell_scene_get_material(const snell_scene *scene, uint32_t index,
                                                snell_object_info *out);
/* A value that a scene program takes from outside. */
typedef struct snell_scene_param {
    const char *name, *kind, *value, *default_value, *help;
} snell_scene_param;
SNELL_API snell_status snell_scene_get_param(const snell_scene *scene, uint32_t index,
                                             snell_scene_param *out);

/* ---- ray queries: the scene is checked once per batch, rays are trusted ---------------------- */

/* Hits lie in t_min < t < t_max, measured in lengths of direction, which need not be 1. */
typedef struct snell_ray {
    snell_vec3 origin;
    float t_min;
    snell_vec3 direction;
    float t_max;
    float time;
    uint32_t mask; /* 0: the ray hits nothing */
} snell_ray;
typedef struct snell_hit {
    float t, u, v;
    uint32_t primitive;
    snell_instance_id instance; /* in the world; in a group more follow (snell_scene_get_path) */
    snell_vec3 normal;
    uint32_t number; /* of the shape, counted as if all groups were taken apart */
} snell_hit; /* miss: t = INFINITY; primitive: of a mesh, the triangle; of a solid, a number of the
                face's shape (a mesh's faces have one each); of curves, patches, heightfields and
                the caller's shapes, the part; else 0; u, v: of a triangle, the
                weights of its second and third vertex (of other shapes: not promised); normal:
                geometric, unit, outward */
/* Rays of the caller's own, held against the last commit; many threads may ask at once.
 * SNELL_ERR_UNSUPPORTED: a ray meets more than 1024 stretches of what a solid is made of, and the
 * results lack that solid on that ray; all others are written as they should be. */
SNELL_API snell_status snell_scene_intersect(const snell_scene *scene, const snell_ray *rays,
                                             snell_hit *hits, size_t count); /* on this thread */
SNELL_API snell_status snell_scene_intersect_all(const snell_scene *scene, const snell_ray *rays,
                                                 snell_hit *hits,
                                                 size_t count); /* on all workers */
/* The instances on the way to what was hit, that in the world first, then parts of groups: path has room
 * for 9, *count receives how many. */
SNELL_API snell_status snell_scene_get_path(const snell_scene *scene, const snell_hit *hit,
                                            snell_instance_id *path, uint32_t *count);
SNELL_API snell_status snell_scene_occluded(const snell_scene *scene, const snell_ray *rays,
                                            uint8_t *blocked,
                                            size_t count); /* 1 if anything is hit */

/* ---- materials by themselves: of the last commit ------------------------------------------------ */

/* Directions are of any length, point away from the surface, and are in the surface's own frame: z is
 * the outward normal. wo is where light goes to (wo.z < 0: it leaves from the inside), wi where it comes
 * from. uv may be NULL: (0, 0). Arrays have `count` elements. What is outside is vacuum. Many threads may
 * call these at once. SNELL_ERR_STATE: no commit, or an edit under way; SNELL_ERR_ARGUMENT: a material
 * that the commit does not know, a zero direction, NaN; then nothing is written. */

/* The BSDF f(wo, wi), 1/sr, without the cosine. Mirrors and smooth glass are deltas: they are left out. */
SNELL_API snell_status snell_material_eval(const snell_scene *scene, snell_material_id material,
                                           const snell_vec2 *uv, snell_vec3 wo,
                                           const snell_vec3 *wi, snell_vec3 *f, size_t count);
/* The density with which snell_material_sample draws wi, per solid angle; deltas are left out. */
SNELL_API snell_status snell_material_pdf(const snell_scene *scene, snell_material_id material,
                                          const snell_vec2 *uv, snell_vec3 wo, const snell_vec3 *wi,
                                          float *pdf, size_t count);
typedef struct snell_scattering {
    snell_vec3 wi;     /* unit */
    snell_vec3 weight; /* f |wi.z| / pdf: what light from wi counts */
    float pdf;         /* per solid angle; 0: a mirror's or smooth glass's only direction */
    bool found;        /* false: nothing comes back for these numbers; counts as a sample of 0 */
    bool transmitted;  /* wi is on the other side than wo */
} snell_scattering;
/* One direction for each u in [0, 1)^3: x chooses among the material's parts, y and z draw from it. */
SNELL_API snell_status snell_material_sample(const snell_scene *scene, snell_material_id material,
                                             const snell_vec2 *uv, snell_vec3 wo,
                                             const snell_vec3 *u, snell_scattering *out,
                                             size_t count);

/* ---- render: blocking, the same bits for the same settings ----------------------------------- */

typedef enum snell_integrator {
    SNELL_APPEL = 1,
    SNELL_WHITTED,
    SNELL_COOK,
    SNELL_PATH
} snell_integrator;

/* A perspective camera by value: moving it needs no commit. Fields as in
 * snell_perspective_camera_desc. */
typedef struct snell_view {
    size_t struct_size;
    snell_vec3 from, at, up;
    float fov;                /* vertical, radians, in (0, pi) */
    float lens_radius, focus; /* metres; 0: a pinhole, and the distance of `at` */
    int32_t blades;           /* 0: round */
    float blade_rotation;     /* radians */
    snell_vec2 shutter;       /* open and close, in frames from the scene's frame */
    const snell_motion_key
        *motion; /* borrowed; of snell_scene_get_view until the scene's next edit */
    size_t motion_count;
} snell_view;
static inline snell_view snell_view_init(size_t struct_size) {
    snell_view view;
    memset(&view, 0, sizeof view);
    view.struct_size = struct_size;
    view.from.z = 5;
    view.up.y = 1;
    view.fov = 0.6981317f; /* 40 degrees */
    view.shutter.y = 0.5f;
    return view;
}
/* Looks at the bounds' centre from {azimuth, elevation} (radians; 0,0 is +Z, azimuth turns towards
 * +X) so that the bounding sphere fits the smaller side of an image with the given width / height.
 * Keeps fov and up. */
SNELL_API snell_status snell_view_frame(snell_view *view, const snell_bounds *bounds, float azimuth,
                                        float elevation, float aspect);
/* From the same direction as near as all that was added to the scene fits into a picture of that shape,
 * with a margin of a twentieth of its width and height on each side: all corners of triangles, the boxes
 * of other shapes, of groups, and of meshes beyond the first 16 million corners of triangles. With
 * `turning` it still fits when snell_view_turn turns the view around the bounds' center by any angle. */
SNELL_API snell_status snell_view_frame_scene(snell_view *view, const snell_scene *scene,
                                              float azimuth, float elevation, float aspect,
                                              bool turning);
/* Turns the camera around the vertical axis through `center` by an angle in radians, the way azimuth
 * grows. */
SNELL_API snell_status snell_view_turn(snell_view *view, snell_vec3 center, float angle);
/* The view of a perspective camera of the scene ({0}: the first), to start from. */
SNELL_API snell_status snell_scene_get_view(const snell_scene *scene, snell_camera_id camera,
                                            snell_view *out);

typedef enum snell_filter {
    SNELL_FILTER_BOX = 0,
    SNELL_FILTER_TENT,
    SNELL_FILTER_GAUSSIAN,
    SNELL_FILTER_BLACKMAN_HARRIS
} snell_filter;

/* A sensible snell_render_desc.samples where a noise is to be reached. */
#define SNELL_NOISE_SAMPLES 16384

typedef struct snell_render_desc {
    size_t struct_size;
    snell_camera_id camera; /* {0}: the scene's first */
    const snell_view *view; /* if not NULL, instead of camera */
    snell_integrator integrator;
    uint32_t width, height; /* pixels, 1..65536, at most 2^30 in all */
    uint32_t crop_x, crop_y, crop_width,
        crop_height;  /* crop_width 0: all; the film has the crop's size */
    uint32_t samples; /* per pixel, 1..2^20; with noise or time_limit, at most */
    /* Over 0, up to 1: each block of 16 x 16 pixels gets samples until its relative error is under this:
     * the root of the mean of (pixel - truth)^2, over the block's mean and 1 % of the picture's. It is a
     * bound at 95 % confidence, from four independent scrambles, of what samples have met: docs/noise.md
     * has the formula. A block's number of samples is 16, 24, 32, 48, 64, .. or `samples`, which is
     * rounded down to a multiple of 4 and is at least 4. 0: no bound. */
    float noise;
    /* Seconds after which no round of samples is begun that would not end in time; one always ends.
     * samples_done then says which `samples` give the same bits without. 0: no limit. */
    double time_limit;
    uint32_t max_depth; /* camera ray 0, each child one more; deeper returns black; at most 1000 */
    float min_weight;   /* rays whose largest weight falls below are dropped; the sum is reported */
    snell_filter filter;
    float filter_radius; /* pixels, 0..16; 0: the filter's own (box 0.5, tent 1, others 1.5) */
    bool pixel_center;   /* all samples through the pixel's centre: no filter */
    bool transparent; /* the background does not count as light seen by the camera; alpha = coverage
                       */
    uint64_t seed;
    uint32_t
        wave_size; /* rays traced at once per worker, over 4096 as 4096; 0: chosen; the picture does
                      not depend on it */
    /* AOVs (snell_aov_name lists them), as in "depth,normal"; NULL or "": none. They change nothing
     * in the picture. Of snell_scene_settings: the scene's, until its next edit. */
    const char *aov;
    snell_progress_fn *progress;
    void *user;
    bool timed; /* the stats tell the seconds by phase, for a few looks at the clock each wave */
} snell_render_desc;
/* whitted at 800 x 600, as snell_scene_settings of an empty scene gives it. */
static inline snell_render_desc snell_render_desc_init(size_t struct_size) {
    snell_render_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.integrator = SNELL_WHITTED;
    desc.width = 800;
    desc.height = 600;
    desc.samples = 16;
    desc.max_depth = 10;
    desc.min_weight = 0.002f;
    return desc;
}

typedef struct snell_render_stats {
    size_t struct_size;
    uint64_t rays_camera, rays_reflected, rays_refracted, rays_shadow,
        rays_continued; /* continued: walked on through transparent surfaces */
    uint64_t nodes, boxes, triangles, primitives; /* tests done by the kernel, summed over rays;
                                                     boxes: eight to a node */
    uint64_t samples_done, pixels_done; /* of any pixel the most; pixels that have theirs */
    uint64_t samples_min;
    double samples_mean;
    /* With a noise: the largest bound of any block and at which confidence each holds; how many blocks
     * there are, and how many are under the noise. Without: 0. */
    double noise_bound, noise_confidence;
    uint64_t noise_blocks, noise_blocks_done;
    double dropped_weight; /* mean over samples of the weight that min_weight dropped */
    uint64_t media_mismatches, film_overflows;
    double seconds;
    uint64_t shadow_nodes, shadow_boxes, shadow_triangles,
        shadow_primitives; /* of the tests above, those of shadow rays */
    /* CPU seconds, summed over workers; 0 where the render was not `timed`. What is left of the
     * process's is the film and the waiting. */
    double seconds_camera,             /* camera rays are made */
        seconds_trace,                 /* nearest hits are looked for */
        seconds_shade,                 /* textures, materials, lights; next rays are made */
        seconds_shadows;               /* shadow rays are tested */
    uint64_t memory_film, memory_rays; /* bytes; memory_rays: of the rays that wait, at most */
} snell_render_stats;

/* What the scene asks for, else the defaults of the integrator (0: the scene's, else whitted). */
SNELL_API snell_status snell_scene_settings(const snell_scene *scene, snell_integrator integrator,
                                            snell_render_desc *out);
/* Where points of the world are in the picture that `desc` makes, from the top left corner of its film,
 * when the shutter opens and from the middle of the lens; whether or not something is in the way, and
 * also beside the picture. {NaN, NaN}: the camera does not see there. desc: its camera, view, width,
 * height and crop count. */
SNELL_API snell_status snell_scene_project(const snell_scene *scene, const snell_render_desc *desc,
                                           const snell_vec3 *points, snell_vec2 *pixels,
                                           size_t count);

/* ---- films, and pictures to files -------------------------------------------------------------- */

typedef struct snell_image_desc {
    size_t struct_size;
    const char *tonemap; /* "clip", "neutral", ...; NULL: the film's default from its scene */
    float exposure;      /* stops, -50 to 50 */
    bool exposure_set;   /* false: the film's default from its scene */
    /* The light that is to look white, before exposure and tone map: kelvin from 1000 to 25000, such
     * as "3200", or a colour, "#rrggbb" or linear "r,g,b". "6504", which is D65, and "" change nothing;
     * NULL: the film's default from its scene. */
    const char *white_balance;
    uint32_t bits;    /* of a channel: PNG 8 or 16, OpenEXR 32 or 16 (colours only); 0: the first */
    uint32_t quality; /* of JPEG and WebP: 1 to 100, which in WebP loses nothing; 0: 90 */
    const char *tag;  /* text stored in the file (PNG "snell" chunk, EXR attribute); NULL: none */
    /* The AOV of this name instead of the picture: for a screen as it is best seen (light as the
     * picture is, depth from near to far, normals as colours), in linear files its numbers, of up to
     * three channels. NULL: the picture; then .exr has all AOVs too, each a part of its own. */
    const char *aov;
} snell_image_desc;
static inline snell_image_desc snell_image_desc_init(size_t struct_size) {
    snell_image_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    return desc;
}

SNELL_API snell_status snell_film_create(snell_context *context, snell_film **out);
SNELL_API void snell_film_destroy(snell_film *film);
/* Sizes and clears the film, then renders. On SNELL_CANCELLED the blocks that were done are in the
 * film, the rest is transparent black. */
SNELL_API snell_status snell_render(const snell_scene *scene, const snell_render_desc *desc,
                                    snell_film *film);
SNELL_API snell_status snell_film_get_stats(
    const snell_film *film, snell_render_stats *out); /* out->struct_size set by the caller */
/* Linear radiance, interleaved RGB (channels 3) or RGBA premultiplied (4, when transparent), rows,
 * top first; borrowed until the next render or destroy. */
SNELL_API const float *snell_film_pixels(const snell_film *film, uint32_t *width, uint32_t *height,
                                         uint32_t *channels);
/* The tone map, and into *exposure (may be NULL) the exposure in stops, that a film is written with
 * when nobody says otherwise: what its scene asks for. A static string. */
SNELL_API const char *snell_film_look(const snell_film *film, float *exposure);
/* The same of snell_image_desc.white_balance; "" for none. Lives as long as the film. */
SNELL_API const char *snell_film_white_balance(const snell_film *film);
/* Of a film that was rendered with a noise, else NULL, in the pixels' order: the variance of each mean of
 * red, green and blue (3 floats for each pixel; estimated from 4 values), and the number of samples. */
SNELL_API const float *snell_film_variance(const snell_film *film);
SNELL_API const uint32_t *snell_film_samples(const snell_film *film);
SNELL_API uint64_t snell_film_hash(const snell_film *film); /* the image hash: of size, channels and
                                                               every bit of the linear film */

/* An AOV (arbitrary output variable) is what a pixel is told beside its light, such as depth. By
 * index: the name, NULL at the end; the channels' names in an OpenEXR file, with blanks between, and a
 * line of help go to *channels and *help (may be NULL). Static; *channels is the thread's, until it asks
 * again. */
SNELL_API const char *snell_aov_name(uint32_t index, const char **channels, const char **help);

/* An AOV of a film. `light` becomes one for each light, "light.lamp". */
typedef struct snell_aov {
    const char *name;
    uint32_t channel_count;
    const float *pixels;  /* interleaved, rows as of snell_film_pixels */
    const char *manifest; /* of a Cryptomatte: JSON, names to ids in hexadecimal; else "" */
} snell_aov;
/* The film's AOVs by index, in the order of snell_aov_name; false: there are no more. Borrowed until
 * the next render or destroy; after SNELL_CANCELLED those of the blocks that were done. The film can be
 * read by many threads while none changes it. */
SNELL_API bool snell_film_aov(const snell_film *film, uint32_t index, snell_aov *out);
/* The name in an OpenEXR file of one of its channels, such as "N.X"; written to `out`, with its 0 cut
 * off at `size`. SNELL_ERR_ARGUMENT: there is none of these numbers. */
SNELL_API snell_status snell_film_aov_channel(const snell_film *film, uint32_t index,
                                              uint32_t channel, char *out, size_t size);

/* By extension, as snell_picture_format lists them. The file is the old one or the complete new one,
 * never half written. SNELL_ERR_UNSUPPORTED: an unknown format, one that is not built in, or too many
 * pixels for it. */
SNELL_API snell_status snell_film_write(const snell_film *film, const char *path,
                                        const snell_image_desc *desc); /* desc may be NULL */
/* The same encoding in memory, format "png", ...; *data is freed with snell_free. */
SNELL_API snell_status snell_film_encode(const snell_film *film, const char *format,
                                         const snell_image_desc *desc, void **data, size_t *size);
SNELL_API void snell_free(void *data);

/* The formats that pictures and animations are written in, by index; false: there are no more. */
typedef struct snell_picture_format_info {
    size_t struct_size;                           /* set by the caller */
    const char *name, *extension, *extension_too; /* "jpg", ".jpg", ".jpeg" or "" */
    const char *help;
    bool picture;      /* of one picture */
    bool animation;    /* of several, for snell_movie_create */
    bool stream;       /* the animation's bytes come in order, as for a pipe */
    bool built;        /* this library writes it */
    bool linear;       /* floats: neither white balance, exposure nor tone map */
    bool layers;       /* AOVs go into the same file */
    bool tag;          /* has a place for the tag */
    bool quality;      /* has a quality */
    uint32_t side_max; /* pixels each way; 0: what a film can have */
    uint32_t bits[2];  /* of a channel: usually, and by choice, else 0 */
    bool chroma;       /* the animation has a choice of it */
    bool alpha;        /* can be transparent; else what is lies over black */
} snell_picture_format_info;
SNELL_API bool snell_picture_format(uint32_t index, snell_picture_format_info *out);

/* An animation in one file, which grows with each frame and is not seen until it is finished. It
 * belongs to one thread at a time. */
typedef struct snell_movie snell_movie;
typedef struct snell_movie_desc {
    size_t struct_size;
    const char *format; /* "apng", "webp", "y4m"; NULL: by the path's extension */
    double fps;         /* frames in a second, 0.001 to 100000; default 24 */
    const snell_image_desc
        *image; /* its tag, bits and quality are the file's; NULL: the defaults */
    /* Takes the bytes in order where no path is given (formats that are a stream); false: it failed. */
    bool (*write)(void *user, const void *data, size_t size);
    void *user;
    uint32_t chroma; /* of y4m: 420, one for four pixels, or 444, of each; 0: 420 */
} snell_movie_desc;
static inline snell_movie_desc snell_movie_desc_init(size_t struct_size) {
    snell_movie_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.fps = 24;
    return desc;
}
SNELL_API snell_status snell_movie_create(const char *path, const snell_movie_desc *desc,
                                          snell_movie **out);
/* One more frame, of the first one's size and channels. image: its white balance, exposure and tone
 * map are the frame's, NULL: the film's. The film is borrowed for the call. After an error the movie
 * holds the frames before. */
SNELL_API snell_status snell_movie_add(snell_movie *movie, const snell_film *film,
                                       const snell_image_desc *image);
/* The file is there, complete: at `path`, which is in the folder of the one it was created with, or
 * where that says (NULL). Frees the movie, also on failure, when no file is there. */
SNELL_API snell_status snell_movie_finish(snell_movie *movie, const char *path);
SNELL_API void snell_movie_destroy(snell_movie *movie); /* without a file; NULL is fine */

/* ---- explain: the rays behind one pixel -------------------------------------------------------- */

/* snell_explain renders one pixel exactly as snell_render does, and keeps what happened: every ray
 * with the ray that sent it, and all the light that reached the pixel.
 *
 *     pixel = the mean over samples of the sum of all contributions
 *     contribution = throughput of its ray * bsdf * incoming * cosine * weight * visibility
 *     throughput of a ray = of its parent * weight * transmittance (* alpha)
 *
 * Contributions are what is added, in double; the film cuts each off below 2^-80 and adds exactly, so
 * their sum is the pixel's bits in any order. The factors are doubles that the renderer rounds to
 * float between rays: their product is a contribution to about 1e-6 of it. */
typedef struct snell_explanation snell_explanation;

typedef struct snell_explain_desc {
    size_t struct_size;
    uint32_t x, y; /* the pixel, from the top left of the film that snell_render would make */
    uint32_t first_sample, sample_count; /* whose rays and lights are kept; count 0: of all */
    uint32_t rays_max; /* kept at most, more is SNELL_ERR_MEMORY; 0: 2^20, of about 500 bytes */
    /* How many samples the pixel has, where the render has a noise: snell_film_samples says so. 0: as
     * many as the render. */
    uint32_t samples;
} snell_explain_desc;
static inline snell_explain_desc snell_explain_desc_init(size_t struct_size) {
    snell_explain_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    return desc;
}

typedef enum snell_ray_kind {
    SNELL_RAY_CAMERA = 1,
    SNELL_RAY_REFLECTED,
    SNELL_RAY_REFRACTED, /* or let through without bending */
    SNELL_RAY_CONTINUED  /* its parent, walking on: same direction, same depth */
} snell_ray_kind;

typedef enum snell_ray_end {
    SNELL_RAY_HIT = 1,  /* met a surface, which sent on what the integrator makes of it */
    SNELL_RAY_PASSED,   /* met a surface that is not there for it: transparent, or inside a solid of
                           higher priority */
    SNELL_RAY_LEFT,     /* met nothing */
    SNELL_RAY_TOO_DEEP, /* was not traced: deeper than max_depth, so black */
    SNELL_RAY_TOO_FAINT /* was not traced: its throughput is under min_weight, or 0 */
} snell_ray_end;

/* Colours are {red, green, blue}. */
typedef struct snell_explained_ray {
    uint32_t parent;    /* index of the ray that sent it; UINT32_MAX: none, a camera ray */
    uint32_t ray_count; /* of the tree that begins with it: this ray and the next ray_count - 1 */
    uint32_t first_light, light_count; /* found at its own end, in the explanation's lights */
    uint32_t sample, depth;            /* both from 0 */
    snell_ray_kind kind;
    snell_ray_end end;
    snell_vec3 origin, direction; /* direction: unit */
    float time;                   /* seconds on the scene's clock */
    double pdf;       /* density that its direction was drawn with, 1/sr; 0: there was no choice */
    double weight[3]; /* how much of what it finds its parent's surface sends on; a camera ray: 1 */
    double distance;  /* to its end, metres; INFINITY: it left; 0: it was not traced */
    double
        transmittance[3];  /* Beer's law over that distance; where `path` drew a color at the hit's
                                dispersion, times 3 for it and 0 for the others */
    snell_vec3 throughput; /* how much of what is found at its end reaches the sample */
    double radiance[4];    /* what its tree adds to the sample: the sum of the contributions, and of
                              coverage in [3] */
    /* Of HIT and PASSED: the surface. Material of type "": the grey of shapes without one. */
    snell_object_info shape, material;
    snell_vec3 position;
    snell_hit hit;     /* instance {0}: the shape of a light */
    snell_vec3 normal; /* the shading normal, unit, on the side that the ray came from */
    bool inside;       /* it came from inside */
    double alpha;  /* how much of the surface is there; in path it is all there or not at all, by
                      this chance, and throughput has no part of it */
    double cosine; /* of the angle between the ray and the shading normal, >= 0 */
    double ior_from, ior_to; /* on the ray's side and beyond; of what bounds no medium 1, 1 */
    double fresnel[3];       /* what a smooth surface reflects at this angle; 0: there is none */
} snell_explained_ray;

typedef enum snell_light_source {
    SNELL_SOURCE_EMISSION = 1, /* of the surface; with the ambient light on it, if there is both */
    SNELL_SOURCE_AMBIENT,      /* the ambient light on the surface */
    SNELL_SOURCE_SKY,          /* what a ray that leaves sees: lights far away, the background */
    SNELL_SOURCE_LIGHT,        /* a light that the surface was asked about */
    SNELL_SOURCE_COVERAGE      /* of a transparent picture: alpha */
} snell_light_source;

typedef struct snell_explained_light {
    uint32_t ray; /* the index of the ray at whose end it is */
    snell_light_source source;
    /* A shape that shines is a shape; of type "": the background, or several at once. */
    snell_object_info light;
    bool tested;          /* a shadow ray was sent */
    snell_vec3 direction; /* of LIGHT: unit, to the light; 0: from everywhere */
    double distance;      /* metres, INFINITY: infinitely far */
    double incoming[3];   /* of LIGHT irradiance where pdf is 0, W/m^2; else radiance, W/(m^2 sr) */
    double pdf;     /* density of the direction, 1/sr, times choice; 0: the light is a point, a
                             direction, or everywhere */
    double cosine;  /* of the light's angle to the shading normal; of what is not LIGHT 1 */
    double bsdf[3]; /* of the parts that lights light, 1/sr; of what is not LIGHT 1 */
    double weight;  /* for the pdf, and of path what of it counts: multiple importance sampling */
    double visibility[3];      /* what comes through; 0: blocked */
    snell_object_info blocker; /* of what is blocked: by what; type "": nothing */
    double blocker_distance;   /* metres */
    double contribution[4];    /* what was added: colour, or in [3] coverage */
    double choice;             /* the chance with which path chose this light; 1: all were asked */
} snell_explained_light;

typedef struct snell_explained_sample {
    double radiance[4];
    uint32_t first_ray, ray_count; /* kept of it */
} snell_explained_sample;

/* On this thread; desc->progress is called, and may cancel. The rays are in the order of their trees:
 * sample by sample, parents before children, children as they were sent. SNELL_ERR_ARGUMENT: a pixel
 * outside the film, and as snell_render; SNELL_ERR_INTERNAL: the sum is not the pixel that was rendered. */
SNELL_API snell_status snell_explain(const snell_scene *scene, const snell_render_desc *desc,
                                     const snell_explain_desc *pixel, snell_explanation **out);
SNELL_API void snell_explanation_destroy(snell_explanation *explanation);
/* Arrays are borrowed until destroy; names in them are the scene's, until its next edit. The pixel is as
 * it is in the film: *channels floats. */
SNELL_API const float *snell_explanation_pixel(const snell_explanation *explanation,
                                               uint32_t *channels);
SNELL_API const snell_explained_sample *
snell_explanation_samples(const snell_explanation *explanation, uint32_t *count); /* all of them */
SNELL_API const snell_explained_ray *snell_explanation_rays(const snell_explanation *explanation,
                                                            size_t *count);
SNELL_API const snell_explained_light *
snell_explanation_lights(const snell_explanation *explanation,
                         size_t *count); /* in the order of their rays */

typedef struct snell_picture_info {
    size_t struct_size;
    char format[8]; /* "png", "exr", ...: snell_picture_format */
    uint32_t width, height, channels, bits;
    uint32_t frames; /* of an animation; 0: it is one picture */
    char *tag;       /* how snell made it; "" when snell did not; freed with snell_free */
    /* What an OpenEXR file has beside its colours: a line each, "depth: Z", the part's name and its
     * channels, or the channels alone; "" when nothing; freed with snell_free. */
    char *layers;
} snell_picture_info;
SNELL_API snell_status snell_picture_read_info(
    const char *path, snell_picture_info *out); /* out->struct_size set by the caller */

/* ---- pictures from files, and how far two are apart ------------------------------------------- */

typedef struct snell_film_read_desc {
    size_t struct_size;
    /* Of an OpenEXR file: the layer, such as "variance", or one channel, such as "normal.X"; NULL:
     * its colours (R G B A, or Y). A layer's name is what stands before the last dot of its
     * channels' names, or that of their part. A layer of one channel is grey,
     * X Y Z and U V become red, green and blue. */
    const char *layer;
    uint64_t memory_max; /* bytes that reading may use; 0: a share of the machine's memory */
    bool allow_helper;   /* as of snell_load_desc: false reads nothing; default true */
    snell_progress_fn *progress; /* phase "read" */
    void *user;
} snell_film_read_desc;
static inline snell_film_read_desc snell_film_read_desc_init(size_t struct_size) {
    snell_film_read_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.allow_helper = true;
    return desc;
}
/* A picture from a file, by its content: PNG, JPEG, WebP, PPM and PGM (8 or 16 bits, taken as
 * sRGB), OpenEXR, PFM, Radiance HDR (linear). Sides to 65536, at most 2^26 pixels. The
 * pixels are as snell_film_pixels says, alpha premultiplied; of linear files as they are, also
 * negative, infinite and NaN. Of a file for screens, exposure 0 and tone map "clip" give the file's
 * values again. The film's context must still be there, and hears warnings. On failure the film is
 * as before. */
SNELL_API snell_status snell_film_read(snell_film *film, const char *path,
                                       const snell_film_read_desc *desc); /* desc may be NULL */
/* The bits of a channel in a file for screens, 8 or 16, that was decoded to linear light; 0: the
 * light is the file's own, or rendered. */
SNELL_API uint32_t snell_film_encoded_bits(const snell_film *film);
/* What snell_film_read_desc.layer could have been: names of the file that was read; NULL at the
 * end. Lives until the film changes. */
SNELL_API const char *snell_film_layer(const snell_film *film, uint32_t index);

typedef enum snell_error_map {
    SNELL_ERROR_FLIP = 0,  /* FLIP, in the colours of magma on a screen */
    SNELL_ERROR_DIFFERENCE /* the absolute difference of the values, channel by channel */
} snell_error_map;

typedef struct snell_compare_desc {
    size_t struct_size;
    /* Two linear pictures are compared in linear light. If one is for screens, or with as_shown,
     * both are compared as a screen shows them: sRGB values from 0 to 1, transparent pixels over
     * black. A linear one goes there by exposure and tone map, and to 8 bits where the other has 8.
     */
    bool as_shown;
    const char *tonemap;       /* of linear pictures as shown; NULL: "clip" */
    float exposure;            /* the same; stops, -50 to 50 */
    const char *white_balance; /* the same, as snell_image_desc's; NULL: none */
    /* FLIP's viewer, 1 to 1000; default 67.02: 3840 pixels in 0.7 m, seen from 0.7 m. */
    float pixels_per_degree;
    /* The variance of each value of the reference and of the picture, that is of a pixel's mean;
     * NULL: its values are exact. With either, and in linear light, differences are held against
     * chance. */
    const snell_film *reference_variance, *picture_variance;
    /* Of how many values each variance is an estimate, 2 or more; 0: very many. */
    uint32_t variance_count;
    snell_film *error; /* gets a picture of the errors; NULL: none */
    snell_error_map error_map;
    /* The errors as numbers, as for OpenEXR; false: such that an 8-bit file shows them. */
    bool error_values;
    snell_progress_fn *progress; /* phase "compare" */
    void *user;
} snell_compare_desc;
static inline snell_compare_desc snell_compare_desc_init(size_t struct_size) {
    snell_compare_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.pixels_per_degree = 67.020643f;
    return desc;
}

typedef struct snell_comparison {
    size_t struct_size;
    uint32_t width, height;
    bool linear;           /* in linear light; false: as shown */
    uint64_t differing;    /* pixels with any channel, alpha too, that is not the same number */
    uint64_t not_finite;   /* pixels with NaN or infinity in either: what follows leaves them out */
    double difference_max; /* absolute, of a value, alpha too; and the first pixel that has it */
    uint32_t difference_x, difference_y;
    /* Over the colours of all pixels, and alpha where any is not 1. rel_mse: the mean of (picture -
     * reference)^2 / (reference^2 + 0.01) (Rousselle, Knaus, Zwicker, SIGGRAPH Asia 2011). psnr:
     * decibels against 1; infinite without a difference. */
    double rmse, rel_mse, psnr;
    /* Mean over the pixels; HDR-FLIP in linear light; transparent pixels over black (Andersson et
     * al., High Performance Graphics 2020, Eurographics 2021). */
    double flip;
    /* z-test: the difference of each colour value over its standard deviation, where there is
     * either. By chance alone about 5 % of the values are beyond the 5 % level, and in 99 of 100
     * comparisons no pixel is rejected (Sidak's level). */
    uint64_t z_values; /* tested; 0: no variance was given, or not in linear light */
    uint64_t z_beyond; /* of these, beyond the 5 % level */
    uint64_t z_rejected;
    double z_max; /* and the first pixel that has it; can be infinite */
    uint32_t z_x, z_y;
} snell_comparison;
/* Two pictures of one size (else SNELL_ERR_ARGUMENT), which may be the same film. Bits do not
 * depend on the threads, which are the reference's context's; the film `error` must be another one.
 */
SNELL_API snell_status
snell_film_compare(const snell_film *reference, const snell_film *picture,
                   const snell_compare_desc *desc, /* may be NULL */
                   snell_comparison *out);         /* out->struct_size set by the caller */

/* ---- what there is: the types' own tables, for help texts, documentation and bindings -------- */

typedef struct snell_field_info {
    const char *name, *kind, *default_value, *range, *unit, *help;
    bool required; /* there is no default */
} snell_field_info;
typedef struct snell_type_info {
    const char *category, *name, *help;
    uint32_t field_count;
} snell_type_info;
SNELL_API uint32_t snell_type_count(void);
SNELL_API snell_status snell_type_get(uint32_t type, snell_type_info *out);
SNELL_API snell_status snell_type_get_field(uint32_t type, uint32_t field, snell_field_info *out);
SNELL_API const char *
snell_formats(uint32_t index,
              const char **description); /* file formats read: extension; NULL at the end */

/* ---- one description per registered type ----------------------------------------------------- */
/* BEGIN GENERATED by tools/gen_api from the types' own tables; do not edit */
/* clang-format off */

enum { SNELL_IMAGE_TEXTURE_FORMAT_RGBA8, SNELL_IMAGE_TEXTURE_FORMAT_RGB8, SNELL_IMAGE_TEXTURE_FORMAT_GRAY8, SNELL_IMAGE_TEXTURE_FORMAT_RGBA32F };
enum { SNELL_IMAGE_TEXTURE_ENCODING_SRGB, SNELL_IMAGE_TEXTURE_ENCODING_LINEAR };
enum { SNELL_IMAGE_TEXTURE_CHANNEL_RGB, SNELL_IMAGE_TEXTURE_CHANNEL_R, SNELL_IMAGE_TEXTURE_CHANNEL_G, SNELL_IMAGE_TEXTURE_CHANNEL_B, SNELL_IMAGE_TEXTURE_CHANNEL_A };
enum { SNELL_IMAGE_TEXTURE_WRAP_U_REPEAT, SNELL_IMAGE_TEXTURE_WRAP_U_CLAMP, SNELL_IMAGE_TEXTURE_WRAP_U_MIRROR };
enum { SNELL_IMAGE_TEXTURE_WRAP_V_REPEAT, SNELL_IMAGE_TEXTURE_WRAP_V_CLAMP, SNELL_IMAGE_TEXTURE_WRAP_V_MIRROR };
enum { SNELL_IMAGE_TEXTURE_FILTER_LINEAR, SNELL_IMAGE_TEXTURE_FILTER_NEAREST };
enum { SNELL_IMAGE_TEXTURE_MAP_AUTO, SNELL_IMAGE_TEXTURE_MAP_UV, SNELL_IMAGE_TEXTURE_MAP_OBJECT, SNELL_IMAGE_TEXTURE_MAP_XZ, SNELL_IMAGE_TEXTURE_MAP_TRIPLANAR, SNELL_IMAGE_TEXTURE_MAP_SPHERICAL, SNELL_IMAGE_TEXTURE_MAP_UV2 };
typedef struct snell_image_texture_desc { /* an image over the surface */
    size_t struct_size;
    int32_t width; /* columns; pixels; required; 1 to 65536 */
    int32_t height; /* rows; pixels; required; 1 to 65536 */
    int32_t format; /* of pixels, rows top first */
    const void *pixels; /* the image's bytes; required */
    size_t pixels_count;
    int32_t encoding; /* of 8-bit colours; floats are linear */
    int32_t channel; /* one channel as grey, or the colour */
    int32_t wrap_u; /* beyond 0..1 along u */
    int32_t wrap_v; /* beyond 0..1 along v */
    int32_t filter; /* between pixels; linear: by mip maps from afar, too */
    int32_t map; /* what u and v are; auto: the shape's, else object */
    snell_vec2 uv_offset; /* added to u, v after scale and rotation */
    snell_vec2 uv_scale; /* u, v are multiplied by this first */
    float uv_rotation; /* then turned by this angle, counter-clockwise; radians */
} snell_image_texture_desc;
static inline snell_image_texture_desc snell_image_texture_desc_init(size_t struct_size) {
    snell_image_texture_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.uv_scale.x = (float)1;
    desc.uv_scale.y = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_image_texture(snell_scene *scene, const snell_image_texture_desc *desc, snell_texture_id *out);

enum { SNELL_CHECKER_TEXTURE_MAP_AUTO, SNELL_CHECKER_TEXTURE_MAP_UV, SNELL_CHECKER_TEXTURE_MAP_OBJECT, SNELL_CHECKER_TEXTURE_MAP_XZ, SNELL_CHECKER_TEXTURE_MAP_TRIPLANAR, SNELL_CHECKER_TEXTURE_MAP_SPHERICAL, SNELL_CHECKER_TEXTURE_MAP_UV2 };
typedef struct snell_checker_texture_desc { /* a chessboard of two colours */
    size_t struct_size;
    snell_vec3 color_a; /* of the square at the origin; >= 0 */
    snell_vec3 color_b; /* of its neighbours; >= 0 */
    float size; /* of a square; in u, v where map says so; m; > 0 */
    int32_t map; /* auto: the shape's own u, v, else the point in object space */
    bool filter; /* average the squares that a sample covers */
} snell_checker_texture_desc;
static inline snell_checker_texture_desc snell_checker_texture_desc_init(size_t struct_size) {
    snell_checker_texture_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.color_a.x = (float)0.800000012;
    desc.color_a.y = (float)0.800000012;
    desc.color_a.z = (float)0.800000012;
    desc.color_b.x = (float)0.100000001;
    desc.color_b.y = (float)0.100000001;
    desc.color_b.z = (float)0.100000001;
    desc.size = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_checker_texture(snell_scene *scene, const snell_checker_texture_desc *desc, snell_texture_id *out);

enum { SNELL_GRADIENT_TEXTURE_WRAP_CLAMP, SNELL_GRADIENT_TEXTURE_WRAP_REPEAT, SNELL_GRADIENT_TEXTURE_WRAP_MIRROR };
enum { SNELL_GRADIENT_TEXTURE_MAP_AUTO, SNELL_GRADIENT_TEXTURE_MAP_UV, SNELL_GRADIENT_TEXTURE_MAP_OBJECT, SNELL_GRADIENT_TEXTURE_MAP_XZ, SNELL_GRADIENT_TEXTURE_MAP_TRIPLANAR, SNELL_GRADIENT_TEXTURE_MAP_SPHERICAL, SNELL_GRADIENT_TEXTURE_MAP_UV2 };
typedef struct snell_gradient_texture_desc { /* from one colour to another */
    size_t struct_size;
    snell_vec3 color_a; /* at 'from' and before it; >= 0 */
    snell_vec3 color_b; /* at 'to' and beyond it; >= 0 */
    snell_vec3 from; /* in u, v, 0 where map says so; m */
    snell_vec3 to; /* by default along v, or up; m */
    int32_t wrap; /* beyond 'from' and 'to' */
    int32_t map; /* auto: the shape's own u, v, else the point in object space */
} snell_gradient_texture_desc;
static inline snell_gradient_texture_desc snell_gradient_texture_desc_init(size_t struct_size) {
    snell_gradient_texture_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.color_b.x = (float)1;
    desc.color_b.y = (float)1;
    desc.color_b.z = (float)1;
    desc.to.y = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_gradient_texture(snell_scene *scene, const snell_gradient_texture_desc *desc, snell_texture_id *out);

enum { SNELL_NOISE_TEXTURE_KIND_FBM, SNELL_NOISE_TEXTURE_KIND_TURBULENCE, SNELL_NOISE_TEXTURE_KIND_MARBLE };
enum { SNELL_NOISE_TEXTURE_MAP_AUTO, SNELL_NOISE_TEXTURE_MAP_UV, SNELL_NOISE_TEXTURE_MAP_OBJECT, SNELL_NOISE_TEXTURE_MAP_XZ, SNELL_NOISE_TEXTURE_MAP_TRIPLANAR, SNELL_NOISE_TEXTURE_MAP_SPHERICAL, SNELL_NOISE_TEXTURE_MAP_UV2 };
typedef struct snell_noise_texture_desc { /* clouds, smoke or marble */
    size_t struct_size;
    snell_vec3 color_a; /* where the noise is 0; >= 0 */
    snell_vec3 color_b; /* where it is 1; >= 0 */
    int32_t kind; /* clouds, smoke, veins */
    float size; /* of the largest features; of a stripe of marble; m; > 0 */
    int32_t octaves; /* layers of ever finer noise; 1 to 16 */
    float lacunarity; /* how much finer each layer is; 1 to 8 */
    float gain; /* how much weaker each layer is; 0 to 1 */
    float distortion; /* of marble: in stripes; >= 0 */
    int32_t seed; /* another number, another pattern; 0 to 1e+09 */
    int32_t map; /* object and triplanar: fills space; otherwise flat */
} snell_noise_texture_desc;
static inline snell_noise_texture_desc snell_noise_texture_desc_init(size_t struct_size) {
    snell_noise_texture_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.color_b.x = (float)1;
    desc.color_b.y = (float)1;
    desc.color_b.z = (float)1;
    desc.size = (float)1;
    desc.octaves = 6;
    desc.lacunarity = (float)2;
    desc.gain = (float)0.5;
    desc.distortion = (float)1;
    desc.map = 2;
    return desc;
}
SNELL_API snell_status snell_scene_add_noise_texture(snell_scene *scene, const snell_noise_texture_desc *desc, snell_texture_id *out);

enum { SNELL_LAMBERT_SHADOW_FILTER, SNELL_LAMBERT_SHADOW_OPAQUE, SNELL_LAMBERT_SHADOW_NONE };
typedef struct snell_lambert_desc { /* matte: R / pi */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_input color; /* R: the fraction of light that it reflects; >= 0 */
} snell_lambert_desc;
static inline snell_lambert_desc snell_lambert_desc_init(size_t struct_size) {
    snell_lambert_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.color.value.x = (float)0.800000012;
    desc.color.value.y = (float)0.800000012;
    desc.color.value.z = (float)0.800000012;
    return desc;
}
SNELL_API snell_status snell_scene_add_lambert(snell_scene *scene, const snell_lambert_desc *desc, snell_material_id *out);

enum { SNELL_PHONG_SHADOW_FILTER, SNELL_PHONG_SHADOW_OPAQUE, SNELL_PHONG_SHADOW_NONE };
typedef struct snell_phong_desc { /* matte with a highlight about r */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_input color; /* R: the diffuse reflectance; >= 0 */
    snell_input specular; /* k_s: the strength of the highlight; 1/sr; >= 0 */
    float exponent; /* p: higher is sharper; 0 to 1e+06 */
} snell_phong_desc;
static inline snell_phong_desc snell_phong_desc_init(size_t struct_size) {
    snell_phong_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.color.value.x = (float)0.800000012;
    desc.color.value.y = (float)0.800000012;
    desc.color.value.z = (float)0.800000012;
    desc.specular.value.x = (float)0.300000012;
    desc.specular.value.y = (float)0.300000012;
    desc.specular.value.z = (float)0.300000012;
    desc.exponent = (float)50;
    return desc;
}
SNELL_API snell_status snell_scene_add_phong(snell_scene *scene, const snell_phong_desc *desc, snell_material_id *out);

enum { SNELL_BLINN_PHONG_SHADOW_FILTER, SNELL_BLINN_PHONG_SHADOW_OPAQUE, SNELL_BLINN_PHONG_SHADOW_NONE };
typedef struct snell_blinn_phong_desc { /* matte with a highlight, the modified form */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_input color; /* R: the diffuse reflectance; >= 0 */
    snell_input specular; /* k_s: the strength of the highlight; 1/sr; >= 0 */
    float exponent; /* p: higher is sharper; 0 to 1e+06 */
} snell_blinn_phong_desc;
static inline snell_blinn_phong_desc snell_blinn_phong_desc_init(size_t struct_size) {
    snell_blinn_phong_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.color.value.x = (float)0.800000012;
    desc.color.value.y = (float)0.800000012;
    desc.color.value.z = (float)0.800000012;
    desc.specular.value.x = (float)0.300000012;
    desc.specular.value.y = (float)0.300000012;
    desc.specular.value.z = (float)0.300000012;
    desc.exponent = (float)50;
    return desc;
}
SNELL_API snell_status snell_scene_add_blinn_phong(snell_scene *scene, const snell_blinn_phong_desc *desc, snell_material_id *out);

enum { SNELL_MIRROR_SHADOW_FILTER, SNELL_MIRROR_SHADOW_OPAQUE, SNELL_MIRROR_SHADOW_NONE };
typedef struct snell_mirror_desc { /* a perfect mirror */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_input color; /* the fraction of light that it reflects; >= 0 */
} snell_mirror_desc;
static inline snell_mirror_desc snell_mirror_desc_init(size_t struct_size) {
    snell_mirror_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.color.value.x = (float)0.899999976;
    desc.color.value.y = (float)0.899999976;
    desc.color.value.z = (float)0.899999976;
    return desc;
}
SNELL_API snell_status snell_scene_add_mirror(snell_scene *scene, const snell_mirror_desc *desc, snell_material_id *out);

enum { SNELL_PARTIAL_MIRROR_SHADOW_FILTER, SNELL_PARTIAL_MIRROR_SHADOW_OPAQUE, SNELL_PARTIAL_MIRROR_SHADOW_NONE };
typedef struct snell_partial_mirror_desc { /* between matte and mirror */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_input color; /* of both parts; >= 0 */
    snell_input specularity; /* s: 0 is matte, 1 a mirror; 0 to 1 */
} snell_partial_mirror_desc;
static inline snell_partial_mirror_desc snell_partial_mirror_desc_init(size_t struct_size) {
    snell_partial_mirror_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.color.value.x = (float)0.899999976;
    desc.color.value.y = (float)0.899999976;
    desc.color.value.z = (float)0.899999976;
    desc.specularity.value.x = (float)0.5;
    desc.specularity.value.y = (float)0.5;
    desc.specularity.value.z = (float)0.5;
    return desc;
}
SNELL_API snell_status snell_scene_add_partial_mirror(snell_scene *scene, const snell_partial_mirror_desc *desc, snell_material_id *out);

enum { SNELL_GLAZED_SHADOW_FILTER, SNELL_GLAZED_SHADOW_OPAQUE, SNELL_GLAZED_SHADOW_NONE };
typedef struct snell_glazed_desc { /* a mirror coat over another material */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_material_id base; /* what is under the glaze; it traces no rays of its own; required */
    snell_input reflectance; /* the mirrored fraction; >= 0 */
    float ior; /* 1 or more: the mirrored fraction is Fresnel's instead; 0 to 10 */
} snell_glazed_desc;
static inline snell_glazed_desc snell_glazed_desc_init(size_t struct_size) {
    snell_glazed_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.reflectance.value.x = (float)0.100000001;
    desc.reflectance.value.y = (float)0.100000001;
    desc.reflectance.value.z = (float)0.100000001;
    return desc;
}
SNELL_API snell_status snell_scene_add_glazed(snell_scene *scene, const snell_glazed_desc *desc, snell_material_id *out);

enum { SNELL_DIELECTRIC_SHADOW_FILTER, SNELL_DIELECTRIC_SHADOW_OPAQUE, SNELL_DIELECTRIC_SHADOW_NONE };
typedef struct snell_dielectric_desc { /* glass, water: reflects and refracts */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_input color; /* multiplies light that passes the surface, each time it does; >= 0 */
    float ior; /* index of refraction, relative to vacuum; 1 to 10 */
    snell_input roughness; /* 0 is smooth; alpha of GGX is its square; 0 to 1 */
    snell_vec3 absorption; /* a of Beer's law, exp(-a d); 1/m; >= 0 */
    snell_vec3 attenuation_color; /* what is left of white light after attenuation_distance; 1e-06 to 1 */
    float attenuation_distance; /* 0: attenuation_color is not used; m; >= 0 */
    int32_t priority; /* where solids overlap the higher one is present; -1000 to 1000 */
    float dispersion; /* 20 / Abbe number: how far colours part; water .36, diamond .36, flint glass .55; 0 to 100 */
} snell_dielectric_desc;
static inline snell_dielectric_desc snell_dielectric_desc_init(size_t struct_size) {
    snell_dielectric_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.color.value.x = (float)1;
    desc.color.value.y = (float)1;
    desc.color.value.z = (float)1;
    desc.ior = (float)1.5;
    desc.attenuation_color.x = (float)1;
    desc.attenuation_color.y = (float)1;
    desc.attenuation_color.z = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_dielectric(snell_scene *scene, const snell_dielectric_desc *desc, snell_material_id *out);

enum { SNELL_CONDUCTOR_SHADOW_FILTER, SNELL_CONDUCTOR_SHADOW_OPAQUE, SNELL_CONDUCTOR_SHADOW_NONE };
enum { SNELL_CONDUCTOR_METAL_ALUMINIUM, SNELL_CONDUCTOR_METAL_CHROMIUM, SNELL_CONDUCTOR_METAL_COBALT, SNELL_CONDUCTOR_METAL_COPPER, SNELL_CONDUCTOR_METAL_GOLD, SNELL_CONDUCTOR_METAL_IRON, SNELL_CONDUCTOR_METAL_MERCURY, SNELL_CONDUCTOR_METAL_NICKEL, SNELL_CONDUCTOR_METAL_PALLADIUM, SNELL_CONDUCTOR_METAL_PLATINUM, SNELL_CONDUCTOR_METAL_SILVER, SNELL_CONDUCTOR_METAL_TITANIUM, SNELL_CONDUCTOR_METAL_TUNGSTEN, SNELL_CONDUCTOR_METAL_VANADIUM };
typedef struct snell_conductor_desc { /* metal, smooth or rough */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    int32_t metal; /* whose measured eta and k it has */
    snell_vec3 eta; /* index of refraction for red, green, blue; 0: that of the metal; 0 to 100 */
    snell_vec3 k; /* extinction coefficient, where eta is given; 0 to 100 */
    snell_input color; /* multiplies what it reflects; >= 0 */
    snell_input roughness; /* 0 is a mirror; alpha of GGX is its square; 0 to 1 */
} snell_conductor_desc;
static inline snell_conductor_desc snell_conductor_desc_init(size_t struct_size) {
    snell_conductor_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.color.value.x = (float)1;
    desc.color.value.y = (float)1;
    desc.color.value.z = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_conductor(snell_scene *scene, const snell_conductor_desc *desc, snell_material_id *out);

enum { SNELL_COOK_TORRANCE_SHADOW_FILTER, SNELL_COOK_TORRANCE_SHADOW_OPAQUE, SNELL_COOK_TORRANCE_SHADOW_NONE };
typedef struct snell_cook_torrance_desc { /* matte under Beckmann facets, as in the lecture */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_input color; /* R: the diffuse reflectance; >= 0 */
    snell_input m; /* the mean slope of the facets; 0 is a mirror; 0 to 1 */
    float ior; /* index of refraction, of Fresnel's formulas; 1 to 10 */
    snell_input specular; /* multiplies the facets' reflection; >= 0 */
} snell_cook_torrance_desc;
static inline snell_cook_torrance_desc snell_cook_torrance_desc_init(size_t struct_size) {
    snell_cook_torrance_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.color.value.x = (float)0.5;
    desc.color.value.y = (float)0.5;
    desc.color.value.z = (float)0.5;
    desc.m.value.x = (float)0.300000012;
    desc.m.value.y = (float)0.300000012;
    desc.m.value.z = (float)0.300000012;
    desc.ior = (float)1.5;
    desc.specular.value.x = (float)1;
    desc.specular.value.y = (float)1;
    desc.specular.value.z = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_cook_torrance(snell_scene *scene, const snell_cook_torrance_desc *desc, snell_material_id *out);

enum { SNELL_GGX_SHADOW_FILTER, SNELL_GGX_SHADOW_OPAQUE, SNELL_GGX_SHADOW_NONE };
typedef struct snell_ggx_desc { /* matte under a rough clear coat */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_input color; /* the base's diffuse reflectance; >= 0 */
    snell_input roughness; /* of the coat: 0 is a mirror; alpha of GGX is its square; 0 to 1 */
    float ior; /* index of refraction of the coat; 1 to 10 */
} snell_ggx_desc;
static inline snell_ggx_desc snell_ggx_desc_init(size_t struct_size) {
    snell_ggx_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.color.value.x = (float)0.5;
    desc.color.value.y = (float)0.5;
    desc.color.value.z = (float)0.5;
    desc.roughness.value.x = (float)0.300000012;
    desc.roughness.value.y = (float)0.300000012;
    desc.roughness.value.z = (float)0.300000012;
    desc.ior = (float)1.5;
    return desc;
}
SNELL_API snell_status snell_scene_add_ggx(snell_scene *scene, const snell_ggx_desc *desc, snell_material_id *out);

enum { SNELL_PRINCIPLED_SHADOW_FILTER, SNELL_PRINCIPLED_SHADOW_OPAQUE, SNELL_PRINCIPLED_SHADOW_NONE };
typedef struct snell_principled_desc { /* the glTF 2.0 model: metal, plastic, glass, varnish, velvet */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_input base_color; /* of the diffuse part, of a metal, of what passes; >= 0 */
    snell_input metallic; /* 0 is a dielectric, 1 a metal; 0 to 1 */
    snell_input roughness; /* 0 is a mirror; alpha of GGX is its square; 0 to 1 */
    float ior; /* index of refraction of the dielectric; 1 to 10 */
    snell_input specular; /* strength of the dielectric's reflection; 0 to 1 */
    snell_input specular_color; /* multiplies the dielectric's reflection at normal incidence; >= 0 */
    snell_input transmission; /* how much of what enters the dielectric passes; 0 to 1 */
    float thickness; /* 0: thin walls that light crosses straight; above: a closed shape is full of it; m; >= 0 */
    snell_vec3 attenuation_color; /* what is left of white light after attenuation_distance; 1e-06 to 1 */
    float attenuation_distance; /* 0: attenuation_color is not used; m; >= 0 */
    int32_t priority; /* where solids overlap the higher one is present; -1000 to 1000 */
    snell_input clearcoat; /* strength of a coat of varnish; 0 to 1 */
    snell_input clearcoat_roughness; /* of the coat; 0 to 1 */
    snell_texture_id clearcoat_normal_map; /* as normal_map, of the coat; without it the coat is smooth: normal_map and bump are beneath */
    snell_input clearcoat_normal_scale; /* multiplies the slope of clearcoat_normal_map */
    snell_input sheen_color; /* of velvet's fibres; 0: none; >= 0 */
    snell_input sheen_roughness; /* of the fibres; below 0.26 it counts as that; 0 to 1 */
    snell_input anisotropy; /* how much rougher it is along its grain: 1 is brushed metal; 0 to 1 */
    float anisotropy_rotation; /* of the grain, counter-clockwise from where u grows; radians */
    snell_texture_id anisotropy_map; /* the grain's direction as a colour, linear: red along u, green along v, as in a normal map */
    snell_input iridescence; /* strength of a thin film's colours; 0 to 1 */
    float iridescence_ior; /* of the film; 1 to 10 */
    snell_input iridescence_thickness; /* of the film; nm; >= 0 */
    float dispersion; /* 20 / Abbe number of what transmits with a thickness: how far colours part; 0 to 100 */
} snell_principled_desc;
static inline snell_principled_desc snell_principled_desc_init(size_t struct_size) {
    snell_principled_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.base_color.value.x = (float)0.800000012;
    desc.base_color.value.y = (float)0.800000012;
    desc.base_color.value.z = (float)0.800000012;
    desc.roughness.value.x = (float)0.5;
    desc.roughness.value.y = (float)0.5;
    desc.roughness.value.z = (float)0.5;
    desc.ior = (float)1.5;
    desc.specular.value.x = (float)1;
    desc.specular.value.y = (float)1;
    desc.specular.value.z = (float)1;
    desc.specular_color.value.x = (float)1;
    desc.specular_color.value.y = (float)1;
    desc.specular_color.value.z = (float)1;
    desc.attenuation_color.x = (float)1;
    desc.attenuation_color.y = (float)1;
    desc.attenuation_color.z = (float)1;
    desc.clearcoat_normal_scale.value.x = (float)1;
    desc.clearcoat_normal_scale.value.y = (float)1;
    desc.clearcoat_normal_scale.value.z = (float)1;
    desc.iridescence_ior = (float)1.29999995;
    desc.iridescence_thickness.value.x = (float)400;
    desc.iridescence_thickness.value.y = (float)400;
    desc.iridescence_thickness.value.z = (float)400;
    return desc;
}
SNELL_API snell_status snell_scene_add_principled(snell_scene *scene, const snell_principled_desc *desc, snell_material_id *out);

enum { SNELL_EMISSIVE_SHADOW_FILTER, SNELL_EMISSIVE_SHADOW_OPAQUE, SNELL_EMISSIVE_SHADOW_NONE };
typedef struct snell_emissive_desc { /* a lamp: black, and it shines */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_input radiance; /* what it sends out, beside emission; W/(m^2 sr); >= 0 */
} snell_emissive_desc;
static inline snell_emissive_desc snell_emissive_desc_init(size_t struct_size) {
    snell_emissive_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.radiance.value.x = (float)5;
    desc.radiance.value.y = (float)5;
    desc.radiance.value.z = (float)5;
    return desc;
}
SNELL_API snell_status snell_scene_add_emissive(snell_scene *scene, const snell_emissive_desc *desc, snell_material_id *out);

enum { SNELL_MIX_SHADOW_FILTER, SNELL_MIX_SHADOW_OPAQUE, SNELL_MIX_SHADOW_NONE };
typedef struct snell_mix_desc { /* a blend of two materials */
    size_t struct_size;
    snell_input emission; /* radiance that it sends out; W/(m^2 sr); >= 0 */
    bool emit_two_sided; /* emit from the inside too */
    snell_vec3 ambient; /* k_a: how much of the scene's ambient light it shows; >= 0 */
    snell_input alpha; /* opacity: 0 lets rays pass as if nothing were there; 0 to 1 */
    float alpha_cutoff; /* above 0: alpha below it is 0, else 1; 0 to 2 */
    int32_t shadow; /* filter: glass and alpha let light through; in path for points and directions alone */
    snell_texture_id normal_map; /* tangent-space normals as colours, linear: red along u, green along v, blue out */
    snell_input normal_scale; /* multiplies the slope of normal_map */
    snell_input bump; /* a height whose slopes bend the shading normal; m */
    float bump_scale; /* multiplies bump */
    snell_material_id a; /* one material; neither may be made of others; required */
    snell_material_id b; /* the other; neither may bound a medium; required */
    snell_input weight; /* how much of it is b; 0 to 1 */
} snell_mix_desc;
static inline snell_mix_desc snell_mix_desc_init(size_t struct_size) {
    snell_mix_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.ambient.x = (float)1;
    desc.ambient.y = (float)1;
    desc.ambient.z = (float)1;
    desc.alpha.value.x = (float)1;
    desc.alpha.value.y = (float)1;
    desc.alpha.value.z = (float)1;
    desc.normal_scale.value.x = (float)1;
    desc.normal_scale.value.y = (float)1;
    desc.normal_scale.value.z = (float)1;
    desc.bump_scale = (float)1;
    desc.weight.value.x = (float)0.5;
    desc.weight.value.y = (float)0.5;
    desc.weight.value.z = (float)0.5;
    return desc;
}
SNELL_API snell_status snell_scene_add_mix(snell_scene *scene, const snell_mix_desc *desc, snell_material_id *out);

typedef struct snell_point_light_desc { /* shines from one point in every direction */
    size_t struct_size;
    snell_vec3 position; /* where it is; m; required */
    snell_vec3 intensity; /* power per solid angle, in every direction; W/sr; >= 0 */
    snell_vec3 power; /* instead of intensity: I = P / (4 pi); W; >= 0 */
} snell_point_light_desc;
static inline snell_point_light_desc snell_point_light_desc_init(size_t struct_size) {
    snell_point_light_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.intensity.x = (float)1;
    desc.intensity.y = (float)1;
    desc.intensity.z = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_point_light(snell_scene *scene, const snell_point_light_desc *desc, snell_light_id *out);

typedef struct snell_spot_light_desc { /* shines from one point into a cone */
    size_t struct_size;
    snell_vec3 position; /* where it is; m; required */
    snell_vec3 at; /* a point that it shines at; m; required */
    snell_vec3 intensity; /* power per solid angle, on the axis; W/sr; >= 0 */
    snell_vec3 power; /* instead of intensity: all the light that leaves the cone; W; >= 0 */
    float cone; /* the half-angle from the axis to the edge, where it is dark; radians; 0.0001 to 3.14159 */
    float blend; /* over this angle inside the edge it fades; 0: a hard edge; radians; 0 to 3.14159 */
} snell_spot_light_desc;
static inline snell_spot_light_desc snell_spot_light_desc_init(size_t struct_size) {
    snell_spot_light_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.intensity.x = (float)1;
    desc.intensity.y = (float)1;
    desc.intensity.z = (float)1;
    desc.cone = (float)0.52359879;
    desc.blend = (float)0.0872664973;
    return desc;
}
SNELL_API snell_status snell_scene_add_spot_light(snell_scene *scene, const snell_spot_light_desc *desc, snell_light_id *out);

typedef struct snell_directional_light_desc { /* parallel light from far away */
    size_t struct_size;
    snell_vec3 direction; /* the way the light travels; required */
    snell_vec3 irradiance; /* on a surface that faces it; W/m^2; >= 0 */
    float angle; /* across the disk that it comes from: the sun's is 0.53 degrees; 0: one direction; radians; 0 to 3.14159 */
    bool visible; /* camera rays see the disk */
} snell_directional_light_desc;
static inline snell_directional_light_desc snell_directional_light_desc_init(size_t struct_size) {
    snell_directional_light_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.direction.y = (float)-1;
    desc.irradiance.x = (float)1;
    desc.irradiance.y = (float)1;
    desc.irradiance.z = (float)1;
    desc.visible = true;
    return desc;
}
SNELL_API snell_status snell_scene_add_directional_light(snell_scene *scene, const snell_directional_light_desc *desc, snell_light_id *out);

typedef struct snell_headlight_light_desc { /* a light at the camera, without shadows */
    size_t struct_size;
    snell_vec3 intensity; /* power per solid angle, in every direction; W/sr; >= 0 */
} snell_headlight_light_desc;
static inline snell_headlight_light_desc snell_headlight_light_desc_init(size_t struct_size) {
    snell_headlight_light_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.intensity.x = (float)1;
    desc.intensity.y = (float)1;
    desc.intensity.z = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_headlight_light(snell_scene *scene, const snell_headlight_light_desc *desc, snell_light_id *out);

typedef struct snell_quad_light_desc { /* a rectangle that shines to one side */
    size_t struct_size;
    snell_vec3 corner; /* one corner; m */
    snell_vec3 u; /* from the corner along one side; m */
    snell_vec3 v; /* along the other; it shines towards cross(u, v); m */
    snell_vec3 center; /* instead of corner: the centre; m */
    snell_vec3 at; /* a point that it faces; m */
    float width; /* of the level side; 0: corner, u and v; m; >= 0 */
    float height; /* of the other; 0: as wide; m; >= 0 */
    snell_vec3 radiance; /* that its outside sends; W/(m^2 sr); >= 0 */
    snell_vec3 power; /* instead of radiance: L = P / (pi area); W; >= 0 */
    bool visible; /* to camera rays; an invisible one casts no shadow either */
} snell_quad_light_desc;
static inline snell_quad_light_desc snell_quad_light_desc_init(size_t struct_size) {
    snell_quad_light_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.radiance.x = (float)1;
    desc.radiance.y = (float)1;
    desc.radiance.z = (float)1;
    desc.visible = true;
    return desc;
}
SNELL_API snell_status snell_scene_add_quad_light(snell_scene *scene, const snell_quad_light_desc *desc, snell_light_id *out);

typedef struct snell_disk_light_desc { /* a disk that shines to one side */
    size_t struct_size;
    snell_vec3 center; /* the centre; m; required */
    snell_vec3 normal; /* the direction that it faces; required */
    float radius; /* the radius; m; > 0 */
    snell_vec3 radiance; /* that its outside sends; W/(m^2 sr); >= 0 */
    snell_vec3 power; /* instead of radiance: L = P / (pi area); W; >= 0 */
    bool visible; /* to camera rays; an invisible one casts no shadow either */
} snell_disk_light_desc;
static inline snell_disk_light_desc snell_disk_light_desc_init(size_t struct_size) {
    snell_disk_light_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.normal.y = (float)-1;
    desc.radius = (float)0.5;
    desc.radiance.x = (float)1;
    desc.radiance.y = (float)1;
    desc.radiance.z = (float)1;
    desc.visible = true;
    return desc;
}
SNELL_API snell_status snell_scene_add_disk_light(snell_scene *scene, const snell_disk_light_desc *desc, snell_light_id *out);

typedef struct snell_sphere_light_desc { /* a sphere that shines */
    size_t struct_size;
    snell_vec3 center; /* the centre; m; required */
    float radius; /* the radius; m; > 0 */
    snell_vec3 radiance; /* that its outside sends; W/(m^2 sr); >= 0 */
    snell_vec3 power; /* instead of radiance: L = P / (pi area); W; >= 0 */
    bool visible; /* to camera rays; an invisible one casts no shadow either */
} snell_sphere_light_desc;
static inline snell_sphere_light_desc snell_sphere_light_desc_init(size_t struct_size) {
    snell_sphere_light_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.radius = (float)0.5;
    desc.radiance.x = (float)1;
    desc.radiance.y = (float)1;
    desc.radiance.z = (float)1;
    desc.visible = true;
    return desc;
}
SNELL_API snell_status snell_scene_add_sphere_light(snell_scene *scene, const snell_sphere_light_desc *desc, snell_light_id *out);

typedef struct snell_environment_light_desc { /* light from everywhere: a colour or an image of the surroundings */
    size_t struct_size;
    snell_input radiance; /* what comes from each direction; a texture is looked up by longitude and latitude; W/(m^2 sr); >= 0 */
    float rotate; /* turns it about +Y, counter-clockwise seen from above; radians */
    bool visible; /* camera rays see it; otherwise the background */
} snell_environment_light_desc;
static inline snell_environment_light_desc snell_environment_light_desc_init(size_t struct_size) {
    snell_environment_light_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.radiance.value.x = (float)1;
    desc.radiance.value.y = (float)1;
    desc.radiance.value.z = (float)1;
    desc.visible = true;
    return desc;
}
SNELL_API snell_status snell_scene_add_environment_light(snell_scene *scene, const snell_environment_light_desc *desc, snell_light_id *out);

typedef struct snell_sky_light_desc { /* a clear sky by day, without the sun itself */
    size_t struct_size;
    snell_vec3 sun; /* the direction towards the sun, at or over the horizon (+Y is up); required */
    float turbidity; /* haze: 2 very clear, 3 clear, 6 hazy; 1.8 to 10 */
    float scale; /* multiplies the sky's radiance; >= 0 */
    snell_vec3 ground; /* the fraction that the ground below the horizon reflects; 0 to 1 */
    bool visible; /* camera rays see it; otherwise the background */
} snell_sky_light_desc;
static inline snell_sky_light_desc snell_sky_light_desc_init(size_t struct_size) {
    snell_sky_light_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.sun.x = (float)0.400000006;
    desc.sun.y = (float)0.5;
    desc.sun.z = (float)0.300000012;
    desc.turbidity = (float)3;
    desc.scale = (float)1;
    desc.ground.x = (float)0.200000003;
    desc.ground.y = (float)0.200000003;
    desc.ground.z = (float)0.200000003;
    desc.visible = true;
    return desc;
}
SNELL_API snell_status snell_scene_add_sky_light(snell_scene *scene, const snell_sky_light_desc *desc, snell_light_id *out);

typedef struct snell_sphere_desc { /* a sphere */
    size_t struct_size;
    snell_vec3 center; /* the centre; m */
    float radius; /* the radius; m; > 0 */
} snell_sphere_desc;
static inline snell_sphere_desc snell_sphere_desc_init(size_t struct_size) {
    snell_sphere_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.radius = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_sphere(snell_scene *scene, const snell_sphere_desc *desc, snell_shape_id *out);

typedef struct snell_plane_desc { /* an infinite plane */
    size_t struct_size;
    snell_vec3 point; /* a point on the plane; m */
    snell_vec3 normal; /* the direction it faces */
} snell_plane_desc;
static inline snell_plane_desc snell_plane_desc_init(size_t struct_size) {
    snell_plane_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.normal.y = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_plane(snell_scene *scene, const snell_plane_desc *desc, snell_shape_id *out);

typedef struct snell_box_desc { /* a box along the axes */
    size_t struct_size;
    snell_vec3 min; /* the corner with the smallest coordinates; m; required */
    snell_vec3 max; /* the corner with the largest coordinates; m; required */
} snell_box_desc;
static inline snell_box_desc snell_box_desc_init(size_t struct_size) {
    snell_box_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    return desc;
}
SNELL_API snell_status snell_scene_add_box(snell_scene *scene, const snell_box_desc *desc, snell_shape_id *out);

typedef struct snell_disk_desc { /* a flat disk, or a ring */
    size_t struct_size;
    snell_vec3 center; /* the centre; m */
    snell_vec3 normal; /* the direction it faces */
    float radius; /* the outer radius; m; > 0 */
    float inner_radius; /* the radius of the hole, 0 for none; m; >= 0 */
} snell_disk_desc;
static inline snell_disk_desc snell_disk_desc_init(size_t struct_size) {
    snell_disk_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.normal.y = (float)1;
    desc.radius = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_disk(snell_scene *scene, const snell_disk_desc *desc, snell_shape_id *out);

typedef struct snell_quad_desc { /* a parallelogram, such as a rectangle */
    size_t struct_size;
    snell_vec3 corner; /* one corner; m; required */
    snell_vec3 u; /* from the corner along one side; m; required */
    snell_vec3 v; /* from the corner along the other side; the quad faces cross(u, v); m; required */
} snell_quad_desc;
static inline snell_quad_desc snell_quad_desc_init(size_t struct_size) {
    snell_quad_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    return desc;
}
SNELL_API snell_status snell_scene_add_quad(snell_scene *scene, const snell_quad_desc *desc, snell_shape_id *out);

typedef struct snell_mesh_desc { /* triangles */
    size_t struct_size;
    const snell_vec3 *positions; /* the vertices; m; required */
    size_t positions_count;
    const uint32_t *indices; /* three vertex numbers, from 0, per triangle, counter-clockwise; required */
    size_t indices_count;
    const snell_vec3 *normals; /* one per vertex, for smooth shading; any length */
    size_t normals_count;
    const snell_vec2 *uvs; /* texture coordinates, one per vertex */
    size_t uvs_count;
    const snell_vec3 *colors; /* linear colours, one per vertex, that multiply the material's colour */
    size_t colors_count;
    const void *alphas; /* one byte per vertex, 255 opaque, that multiplies the material's alpha */
    size_t alphas_count;
    const uint32_t *material_slots; /* one per triangle: an index into materials */
    size_t material_slots_count;
    const snell_material_id *materials; /* the materials that material_slots choose from */
    size_t materials_count;
    const float *key_times; /* of a mesh that deforms: ascending times; positions and normals are lists for each, one after the other, and linear in between; s */
    size_t key_times_count;
    const snell_vec2 *uvs2; /* a second set of texture coordinates, one per vertex, for textures whose map is uv2 */
    size_t uvs2_count;
    const float *tangents; /* four per vertex, for normal maps and anisotropy: where red points, and 1 or -1, by which green is that times the normal's cross product with it; none: from uvs */
    size_t tangents_count;
} snell_mesh_desc;
static inline snell_mesh_desc snell_mesh_desc_init(size_t struct_size) {
    snell_mesh_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    return desc;
}
SNELL_API snell_status snell_scene_add_mesh(snell_scene *scene, const snell_mesh_desc *desc, snell_shape_id *out);

typedef struct snell_cylinder_desc { /* a cylinder, closed or a tube */
    size_t struct_size;
    snell_vec3 from; /* the middle of one end; m; required */
    snell_vec3 to; /* the middle of the other end; m; required */
    float radius; /* the radius; m; > 0 */
    bool capped; /* closed by a disk at both ends */
} snell_cylinder_desc;
static inline snell_cylinder_desc snell_cylinder_desc_init(size_t struct_size) {
    snell_cylinder_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.radius = (float)1;
    desc.capped = true;
    return desc;
}
SNELL_API snell_status snell_scene_add_cylinder(snell_scene *scene, const snell_cylinder_desc *desc, snell_shape_id *out);

typedef struct snell_cone_desc { /* a cone, whole or cut off */
    size_t struct_size;
    snell_vec3 from; /* the middle of the base; m; required */
    snell_vec3 to; /* the tip, or the middle of the other end; m; required */
    float radius; /* the radius at 'from'; m; >= 0 */
    float radius_to; /* the radius at 'to', 0 for a tip; m; >= 0 */
    bool capped; /* closed by a disk at both ends */
} snell_cone_desc;
static inline snell_cone_desc snell_cone_desc_init(size_t struct_size) {
    snell_cone_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.radius = (float)1;
    desc.capped = true;
    return desc;
}
SNELL_API snell_status snell_scene_add_cone(snell_scene *scene, const snell_cone_desc *desc, snell_shape_id *out);

typedef struct snell_torus_desc { /* a ring with a round tube */
    size_t struct_size;
    snell_vec3 center; /* the centre; m */
    snell_vec3 axis; /* the direction that the ring lies around */
    float major; /* from the centre to the middle of the tube; m; > 0 */
    float minor; /* the tube's radius, less than 'major'; m; > 0 */
} snell_torus_desc;
static inline snell_torus_desc snell_torus_desc_init(size_t struct_size) {
    snell_torus_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.axis.y = (float)1;
    desc.major = (float)1;
    desc.minor = (float)0.25;
    return desc;
}
SNELL_API snell_status snell_scene_add_torus(snell_scene *scene, const snell_torus_desc *desc, snell_shape_id *out);

typedef struct snell_lathe_desc { /* a line turned about the Y axis: vases, glasses, chess pieces */
    size_t struct_size;
    const snell_vec2 *profile; /* points {radius, height}, at least two, joined by straight lines; m; required */
    size_t profile_count;
    bool smooth; /* shade joints of less than 40 degrees as one curve */
} snell_lathe_desc;
static inline snell_lathe_desc snell_lathe_desc_init(size_t struct_size) {
    snell_lathe_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.smooth = true;
    return desc;
}
SNELL_API snell_status snell_scene_add_lathe(snell_scene *scene, const snell_lathe_desc *desc, snell_shape_id *out);

typedef struct snell_capsule_desc { /* a cylinder with rounded ends */
    size_t struct_size;
    snell_vec3 from; /* the centre of the ball at one end; m; required */
    snell_vec3 to; /* the centre of the ball at the other end; m; required */
    float radius; /* the radius; m; > 0 */
} snell_capsule_desc;
static inline snell_capsule_desc snell_capsule_desc_init(size_t struct_size) {
    snell_capsule_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.radius = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_capsule(snell_scene *scene, const snell_capsule_desc *desc, snell_shape_id *out);

typedef struct snell_ellipsoid_desc { /* a stretched sphere */
    size_t struct_size;
    snell_vec3 center; /* the centre; m */
    snell_vec3 radii; /* half the size along x, y and z; m; > 0 */
} snell_ellipsoid_desc;
static inline snell_ellipsoid_desc snell_ellipsoid_desc_init(size_t struct_size) {
    snell_ellipsoid_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.radii.x = (float)1;
    desc.radii.y = (float)1;
    desc.radii.z = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_ellipsoid(snell_scene *scene, const snell_ellipsoid_desc *desc, snell_shape_id *out);

typedef struct snell_quadric_desc { /* a surface of the second degree within a box: hyperboloids, bowls, saddles */
    size_t struct_size;
    snell_vec3 square; /* the factors of x^2, y^2 and z^2 */
    snell_vec3 mixed; /* the factors of xy, xz and yz */
    snell_vec3 linear; /* the factors of x, y and z */
    float constant; /* what is added: the sum is 0 on the surface */
    snell_vec3 min; /* the box's smallest coordinates; m */
    snell_vec3 max; /* the box's largest coordinates; m */
} snell_quadric_desc;
static inline snell_quadric_desc snell_quadric_desc_init(size_t struct_size) {
    snell_quadric_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.min.x = (float)-1;
    desc.min.y = (float)-1;
    desc.min.z = (float)-1;
    desc.max.x = (float)1;
    desc.max.y = (float)1;
    desc.max.z = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_quadric(snell_scene *scene, const snell_quadric_desc *desc, snell_shape_id *out);

typedef struct snell_superellipsoid_desc { /* between a sphere, a box, a cylinder and an octahedron */
    size_t struct_size;
    snell_vec3 center; /* the centre; m */
    snell_vec3 radii; /* half the size along x, y and z; m; > 0 */
    float e1; /* seen from above: 0 a square, 1 round, 2 a diamond; 0.015625 to 2 */
    float e2; /* seen from the side: 0 a square, 1 round, 2 a diamond; 0.015625 to 2 */
} snell_superellipsoid_desc;
static inline snell_superellipsoid_desc snell_superellipsoid_desc_init(size_t struct_size) {
    snell_superellipsoid_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.radii.x = (float)1;
    desc.radii.y = (float)1;
    desc.radii.z = (float)1;
    desc.e1 = (float)1;
    desc.e2 = (float)1;
    return desc;
}
SNELL_API snell_status snell_scene_add_superellipsoid(snell_scene *scene, const snell_superellipsoid_desc *desc, snell_shape_id *out);

enum { SNELL_CURVES_BASIS_CATMULL_ROM, SNELL_CURVES_BASIS_BSPLINE, SNELL_CURVES_BASIS_BEZIER, SNELL_CURVES_BASIS_LINEAR };
enum { SNELL_CURVES_KIND_ROUND, SNELL_CURVES_KIND_RIBBON };
typedef struct snell_curves_desc { /* strands: hair, fur, grass, wire */
    size_t struct_size;
    const snell_vec3 *points; /* of all strands, one after the other; m; required */
    size_t points_count;
    const float *radii; /* one per point, instead of 'radius'; m; >= 0 */
    size_t radii_count;
    float radius; /* half the thickness of all strands; m; > 0 */
    const uint32_t *starts; /* number, from 0, of the first point of each strand; none: one strand */
    size_t starts_count;
    int32_t basis; /* through the points, smoothly near them, by control points, straight */
    int32_t kind; /* a round thread, or a flat one that faces each sight */
} snell_curves_desc;
static inline snell_curves_desc snell_curves_desc_init(size_t struct_size) {
    snell_curves_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.radius = (float)0.00999999978;
    return desc;
}
SNELL_API snell_status snell_scene_add_curves(snell_scene *scene, const snell_curves_desc *desc, snell_shape_id *out);

typedef struct snell_heightfield_desc { /* a terrain over a grid of posts */
    size_t struct_size;
    const float *heights; /* rows of posts, from the least z on; 0 is min's y, 1 is max's; required */
    size_t heights_count;
    int32_t columns; /* posts in a row, along x; required; 2 to 65536 */
    int32_t rows; /* rows, along z; required; 2 to 65536 */
    snell_vec3 min; /* the corner of the first post; m */
    snell_vec3 max; /* the corner of the last post; m */
    bool smooth; /* blend the shading normals over the cells */
} snell_heightfield_desc;
static inline snell_heightfield_desc snell_heightfield_desc_init(size_t struct_size) {
    snell_heightfield_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.max.x = (float)1;
    desc.max.y = (float)1;
    desc.max.z = (float)1;
    desc.smooth = true;
    return desc;
}
SNELL_API snell_status snell_scene_add_heightfield(snell_scene *scene, const snell_heightfield_desc *desc, snell_shape_id *out);

typedef struct snell_patch_desc { /* bicubic Bezier patches */
    size_t struct_size;
    const snell_vec3 *points; /* the controls, 16 per patch, or for 'indices'; m; required */
    size_t points_count;
    const uint32_t *indices; /* 16 numbers of points, from 0, per patch */
    size_t indices_count;
} snell_patch_desc;
static inline snell_patch_desc snell_patch_desc_init(size_t struct_size) {
    snell_patch_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    return desc;
}
SNELL_API snell_status snell_scene_add_patch(snell_scene *scene, const snell_patch_desc *desc, snell_shape_id *out);

enum { SNELL_SOLID_OPERATION_UNION, SNELL_SOLID_OPERATION_INTERSECTION, SNELL_SOLID_OPERATION_DIFFERENCE };
typedef struct snell_solid_desc { /* closed shapes put together */
    size_t struct_size;
    int32_t operation; /* all that any has, what all have, or the first less all others */
    const snell_shape_id *shapes; /* closed shapes, planes as half-spaces, solids; required */
    size_t shapes_count;
    const snell_transform *transforms; /* one per shape, to the solid's space; or none */
    size_t transforms_count;
    const snell_material_id *materials; /* one per shape, or none; a shape without has the solid's own */
    size_t materials_count;
} snell_solid_desc;
static inline snell_solid_desc snell_solid_desc_init(size_t struct_size) {
    snell_solid_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    return desc;
}
SNELL_API snell_status snell_scene_add_solid(snell_scene *scene, const snell_solid_desc *desc, snell_shape_id *out);

typedef struct snell_implicit_desc { /* where a formula in x, y, z is below 0; distance fields too */
    size_t struct_size;
    const char *f; /* formula in x, y, z: "x^2 + y^2 + z^2 - 1"; solid where below 0; required */
    snell_vec3 min; /* the lowest corner of the box it lies in; m; required */
    snell_vec3 max; /* the highest corner; m; required */
    bool capped; /* closed by the faces of the box where that cuts it */
    float lipschitz; /* f changes by at most this per metre: 1 for distances; 0: not known; >= 0 */
} snell_implicit_desc;
static inline snell_implicit_desc snell_implicit_desc_init(size_t struct_size) {
    snell_implicit_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.f = "";
    desc.capped = true;
    return desc;
}
SNELL_API snell_status snell_scene_add_implicit(snell_scene *scene, const snell_implicit_desc *desc, snell_shape_id *out);

typedef struct snell_blob_desc { /* balls that melt together (metaballs) */
    size_t struct_size;
    const snell_vec3 *points; /* the middles of the balls that melt together; m; required */
    size_t points_count;
    float radius; /* how far each point reaches; m; > 0 */
    float strength; /* of each point, at its middle; less than 0: a dent */
    const snell_vec2 *sizes; /* {radius, strength} of each point, instead */
    size_t sizes_count;
    float threshold; /* solid where the sum is above this; > 0 */
} snell_blob_desc;
static inline snell_blob_desc snell_blob_desc_init(size_t struct_size) {
    snell_blob_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.radius = (float)1;
    desc.strength = (float)1;
    desc.threshold = (float)0.5;
    return desc;
}
SNELL_API snell_status snell_scene_add_blob(snell_scene *scene, const snell_blob_desc *desc, snell_shape_id *out);

typedef struct snell_julia_desc { /* a quaternion Julia set */
    size_t struct_size;
    snell_vec3 c; /* the constant: real part, i, j; -100 to 100 */
    float c_k; /* its fourth part, k; -100 to 100 */
    float slice; /* the fourth coordinate of the cut; m; -100 to 100 */
    int32_t iterations; /* steps of q -> q^2 + c: the detail; 1 to 60 */
    float escape; /* how far a point may go; 0: as far as is sure never to come back; m; >= 0 */
} snell_julia_desc;
static inline snell_julia_desc snell_julia_desc_init(size_t struct_size) {
    snell_julia_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.c.x = (float)-0.200000003;
    desc.c.y = (float)0.600000024;
    desc.c.z = (float)0.200000003;
    desc.c_k = (float)0.200000003;
    desc.iterations = 9;
    return desc;
}
SNELL_API snell_status snell_scene_add_julia(snell_scene *scene, const snell_julia_desc *desc, snell_shape_id *out);

typedef struct snell_perspective_camera_desc { /* a pinhole camera, or a thin lens with depth of field */
    size_t struct_size;
    snell_vec3 from; /* where the eye is; m */
    snell_vec3 at; /* what it looks at; m */
    snell_vec3 up; /* what is up in the picture */
    snell_vec2 shutter; /* when it opens and closes, from the frame's own time; seen where something moves; frames; -1000 to 1000 */
    const snell_motion_key *motion; /* moves the camera from where 'from' and 'at' put it */
    size_t motion_count;
    float fov; /* vertical field of view; radians; 0.0001 to 3.1415 */
    float lens_radius; /* 0: a pinhole, everything sharp; larger: more blur out of focus; m; >= 0 */
    float focus; /* distance of the sharp plane along the view; 0: that of 'at'; m; >= 0 */
    int32_t blades; /* sides of the aperture, 3 to 16; 0: round; 0 to 16 */
    float blade_rotation; /* turns the aperture, whose first corner is on the right; radians */
} snell_perspective_camera_desc;
static inline snell_perspective_camera_desc snell_perspective_camera_desc_init(size_t struct_size) {
    snell_perspective_camera_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.from.z = (float)5;
    desc.up.y = (float)1;
    desc.shutter.y = (float)0.5;
    desc.fov = (float)0.69813168;
    return desc;
}
SNELL_API snell_status snell_scene_add_perspective_camera(snell_scene *scene, const snell_perspective_camera_desc *desc, snell_camera_id *out);

typedef struct snell_orthographic_camera_desc { /* parallel rays: the same size near and far */
    size_t struct_size;
    snell_vec3 from; /* where the eye is; m */
    snell_vec3 at; /* what it looks at; m */
    snell_vec3 up; /* what is up in the picture */
    snell_vec2 shutter; /* when it opens and closes, from the frame's own time; seen where something moves; frames; -1000 to 1000 */
    const snell_motion_key *motion; /* moves the camera from where 'from' and 'at' put it */
    size_t motion_count;
    float height; /* what the picture is high, around 'at'; m; > 0 */
} snell_orthographic_camera_desc;
static inline snell_orthographic_camera_desc snell_orthographic_camera_desc_init(size_t struct_size) {
    snell_orthographic_camera_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.from.z = (float)5;
    desc.up.y = (float)1;
    desc.shutter.y = (float)0.5;
    desc.height = (float)2;
    return desc;
}
SNELL_API snell_status snell_scene_add_orthographic_camera(snell_scene *scene, const snell_orthographic_camera_desc *desc, snell_camera_id *out);

typedef struct snell_panorama_camera_desc { /* everything around, longitude by latitude; twice as wide as high */
    size_t struct_size;
    snell_vec3 from; /* where the eye is; m */
    snell_vec3 at; /* what it looks at; m */
    snell_vec3 up; /* what is up in the picture */
    snell_vec2 shutter; /* when it opens and closes, from the frame's own time; seen where something moves; frames; -1000 to 1000 */
    const snell_motion_key *motion; /* moves the camera from where 'from' and 'at' put it */
    size_t motion_count;
} snell_panorama_camera_desc;
static inline snell_panorama_camera_desc snell_panorama_camera_desc_init(size_t struct_size) {
    snell_panorama_camera_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.from.z = (float)5;
    desc.up.y = (float)1;
    desc.shutter.y = (float)0.5;
    return desc;
}
SNELL_API snell_status snell_scene_add_panorama_camera(snell_scene *scene, const snell_panorama_camera_desc *desc, snell_camera_id *out);

typedef struct snell_fisheye_camera_desc { /* a wide circle: angles from the view are distances from its middle */
    size_t struct_size;
    snell_vec3 from; /* where the eye is; m */
    snell_vec3 at; /* what it looks at; m */
    snell_vec3 up; /* what is up in the picture */
    snell_vec2 shutter; /* when it opens and closes, from the frame's own time; seen where something moves; frames; -1000 to 1000 */
    const snell_motion_key *motion; /* moves the camera from where 'from' and 'at' put it */
    size_t motion_count;
    float fov; /* across the circle; radians; 0.0001 to 6.28319 */
} snell_fisheye_camera_desc;
static inline snell_fisheye_camera_desc snell_fisheye_camera_desc_init(size_t struct_size) {
    snell_fisheye_camera_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.struct_size = struct_size;
    desc.from.z = (float)5;
    desc.up.y = (float)1;
    desc.shutter.y = (float)0.5;
    desc.fov = (float)3.14159274;
    return desc;
}
SNELL_API snell_status snell_scene_add_fisheye_camera(snell_scene *scene, const snell_fisheye_camera_desc *desc, snell_camera_id *out);
/* clang-format on */
/* END GENERATED */

#endif
