/* The pbrt-v4 reader's own parts (format: pbrt.org/fileformat-v4).
 *
 *     pbrt.c            the importer, and what each directive does to the graphics state
 *     pbrt_text.c       words, strings, parameter lists, included files
 *     pbrt_params.c     values out of parameter lists
 *     pbrt_transforms.c matrices, and the directives that change the current one
 *     pbrt_spectrum.c   spectra to linear Rec. 709
 *     pbrt_view.c       what stands before WorldBegin: camera, film, sampler, integrator, filter
 *     pbrt_lights.c     light sources
 *     pbrt_textures.c   textures, as trees that are read once and used often
 *     pbrt_bake.c       textures that have no counterpart, as images
 *     pbrt_materials.c  materials
 *     pbrt_shapes.c     shapes and where they stand
 *     pbrt_rounds.c     spheres, cylinders, disks
 *     pbrt_curves.c     curves
 *     pbrt_meshes.c     triangles: meshes of files, Loop's subdivision, parts of quadrics
 *
 * pbrt is left-handed, snell right-handed: the world is flipped in x as it is read (pbrt.flip), unless
 * the camera mirrors it already, as files of right-handed programs do by "Scale -1 1 1". */
#ifndef SNELL_IMPORTERS_PBRT_H
#define SNELL_IMPORTERS_PBRT_H

#include <jansson.h>

#include "importers/image_decode.h"
#include "importers/importer.h"
#include "importers/names.h"

/* ---- text ---- */

typedef enum pbrt_token_kind {
    PBRT_END,
    PBRT_WORD,
    PBRT_STRING,
    PBRT_OPEN,
    PBRT_CLOSE
} pbrt_token_kind;

typedef struct pbrt_text { /* a file that is being read */
    const char *path;
    char *data;           /* owned; data[size] is 0 */
    const char *at, *end; /* what is left of it */
    const char *line_start;
    uint32_t line;
} pbrt_text;

/* ---- parameter lists ---- */

typedef enum pbrt_value_kind { PBRT_NUMBERS, PBRT_STRINGS, PBRT_BOOLS } pbrt_value_kind;
typedef enum pbrt_color_space { PBRT_SRGB, PBRT_P3, PBRT_REC2020, PBRT_ACES } pbrt_color_space;

typedef struct pbrt_param {
    char *type, *name; /* owned, in one block */
    pbrt_value_kind kind;
    double *numbers; /* also bools */
    char **strings;
    size_t count, capacity;
    pbrt_color_space space;
    bool used;
    bool is_attribute;       /* of an Attribute directive: it need not be used */
    struct pbrt_param *next; /* of its list; lists of attributes have a common end */
    struct pbrt_param *kept; /* of all attributes, for freeing them */
    source_place place;
} pbrt_param;

typedef struct pbrt_params {
    char what[64]; /* 'Shape "sphere"', for messages */
    char type[40]; /* "sphere" */
    source_place place;
    pbrt_param *own;        /* owned list, last one first, as later ones count */
    pbrt_param *attributes; /* not owned */
    pbrt_color_space space;
} pbrt_params;

/* ---- textures ---- */

typedef enum pbrt_texture_kind {
    PBRT_CONSTANT,
    PBRT_IMAGE,
    PBRT_CHECKER,
    PBRT_BILERP,
    PBRT_SCALE,
    PBRT_MIX,
    PBRT_NOISE
} pbrt_texture_kind;

/* A node; parts are nodes made before. Values are linear Rec. 709; of float textures all three are
 * the same. */
typedef struct pbrt_texture {
    pbrt_texture_kind kind;
    double value[3];
    double corners[4][3];       /* bilerp: v00 v01 v10 v11 */
    size_t parts[3];            /* mix: tex1 tex2 amount; scale: tex scale; checker: tex1 tex2 */
    double scale[2], offset[2]; /* of u, v */
    int wrap;                   /* index into pbrt_wrap_words */
    bool nearest;
    decoded_image image;   /* 8 bits as they are, or floats */
    double gamma;          /* of 8 bits; 0: sRGB */
    bool invert, is_float; /* is_float: an image counts by its mean */
    double factor;         /* of an image */
    const char *noise;     /* snell's kind */
    double size, gain;
    int octaves;
    uint32_t nodes;  /* of the tree, with itself */
    uint32_t pixels; /* that an image of the tree needs across; 0: it has patterns in space */
    /* Made before: for colours, and for numbers. */
    bool made[2];
    snell_input input[2];
} pbrt_texture;

/* ---- materials, lights, state ---- */

enum { PBRT_PARAMS_MAX = 24 };
typedef struct pbrt_material {
    char *name;       /* owned; NULL: unnamed */
    const char *type; /* snell's; NULL: "interface", there is nothing */
    snell_param list[PBRT_PARAMS_MAX];
    size_t count;
    bool textured, is_glass;
    source_place place;
    size_t first_variant; /* into pbrt.variants, chained; SIZE_MAX: none */
} pbrt_material;

typedef struct pbrt_area_light {
    bool lit, two_sided;
    vec3 radiance; /* where there is no power */
    vec3 power;    /* of one side */
    bool has_power;
} pbrt_area_light;

typedef struct pbrt_variant { /* a material with what shapes add to it */
    snell_input alpha;
    vec3 emission, absorption;
    bool two_sided;
    uint32_t index; /* in the description */
    size_t next;
} pbrt_variant;

/* Curves of one material that follow each other are one shape: hair has a million. In the world. */
typedef struct pbrt_strands {
    vec3 *points;
    float *radii;
    uint32_t *starts;
    size_t point_count, point_capacity, radius_capacity, start_count, start_capacity;
    uint32_t material;
    const char *basis, *kind;
    source_place place; /* of the first */
} pbrt_strands;

enum { ATTRIBUTE_SHAPE, ATTRIBUTE_LIGHT, ATTRIBUTE_MATERIAL, ATTRIBUTE_MEDIUM, ATTRIBUTE_TEXTURE };
enum { ATTRIBUTE_KINDS = 5 };

typedef struct pbrt_state {
    dtransform ctm[2]; /* at the start and at the end of the transform times */
    unsigned active;   /* bit 0: the first, bit 1: the second */
    bool reverse;
    pbrt_color_space space;
    pbrt_param *attributes[ATTRIBUTE_KINDS];
    size_t material;
    pbrt_area_light area;
    vec3 absorption; /* of the medium inside, 1/m */
} pbrt_state;

typedef struct pbrt_pushed {
    pbrt_state state;
    bool is_object;
    source_place place;
} pbrt_pushed;

typedef struct pbrt {
    const char *path; /* as it was typed */
    const import_options *options;
    description *d;
    snell_status status; /* the first error; then nothing is read any more */
    uint64_t budget;     /* bytes that may still be made */
    pbrt_text *text;     /* what is being read; includes nest */
    uint32_t depth, file_count;
    char **paths; /* owned: messages and objects point to them */
    size_t path_count, path_capacity;
    /* The last token. */
    pbrt_token_kind kind;
    char *word; /* owned, grows */
    size_t word_size, word_capacity;
    source_place place;
    bool held; /* it is to be read again */

    pbrt_state state;
    pbrt_pushed *pushed;
    size_t pushed_count, pushed_capacity;
    pbrt_param *kept; /* all attributes, owned */
    bool in_world;
    double times[2]; /* of the two transforms, seconds */
    json_t *systems; /* name -> number of a coordinate system */
    dtransform (*system_list)[2];
    size_t system_count, system_capacity;

    /* Before WorldBegin: the last of each. */
    pbrt_params camera, film, sampler, integrator, filter;
    dtransform from_camera[2];
    double flip;         /* of x: -1 or 1 */
    double light_factor; /* radiance on the film for radiance in the scene: the imaging ratio */
    double white[3];     /* and by colour: the white balance */
    bool moving;
    uint32_t camera_index;
    double shutter[2];

    json_t *float_textures, *color_textures; /* name -> index */
    pbrt_texture *textures;
    size_t texture_count, texture_capacity;
    json_t *named_materials, *media;
    pbrt_material *materials; /* the first is the default */
    size_t material_count, material_capacity;
    pbrt_variant *variants;
    size_t variant_count, variant_capacity;
    vec3 *medium_list; /* absorption of each */
    size_t medium_count, medium_capacity;
    json_t *objects; /* name -> the group's shape + 1; 0: empty */
    bool in_object;
    char *object_name; /* owned */
    uint32_t *parts;   /* instances of the object that is open */
    size_t part_count, part_capacity;
    pbrt_strands strands;
    name_set names;
} pbrt;

/* ---- errors: all record the first one in p->status and return it ---- */
snell_status pbrt_fail(pbrt *p, source_place place, const char *hint, const char *format, ...)
    PRINTF_LIKE(4, 5);
/* Another function's error, given its place; SNELL_OK is no error. */
snell_status pbrt_blame(pbrt *p, source_place place, snell_status status);
/* Once for each text. */
snell_status pbrt_warn(pbrt *p, source_place place, const char *format, ...) PRINTF_LIKE(3, 4);
snell_status pbrt_spend(pbrt *p, source_place place, uint64_t size);

/* ---- pbrt_text.c ---- */
/* The next token is in p->kind, p->word, p->place. */
snell_status pbrt_next(pbrt *p);
snell_status pbrt_need_string(pbrt *p, const char *directive);
snell_status pbrt_need_numbers(pbrt *p, const char *directive, double *out, size_t count);
/* With brackets around them or without. */
snell_status pbrt_need_matrix(pbrt *p, const char *directive, double out[16]);
/* A string, which is the type, and what follows it. */
snell_status pbrt_need_params(pbrt *p, const char *directive, pbrt_params *out);
/* Only the parameters. */
snell_status pbrt_read_params(pbrt *p, pbrt_params *out);
void pbrt_params_free(pbrt_params *params);
void pbrt_param_free(pbrt_param *param);
/* Calls `read` with the file as p->text. `place`: of its name. */
snell_status pbrt_with_file(pbrt *p, const char *name, source_place place,
                            snell_status (*read)(pbrt *p));
/* Digits, signs, dots and exponents only. */
bool pbrt_to_number(const char *word, double *out);

/* ---- pbrt_params.c: a parameter of another type or size is an error ---- */
pbrt_param *pbrt_find(const pbrt_params *params,
                      const char *name); /* NULL: none; does not use it */
double pbrt_float(pbrt *p, const pbrt_params *params, const char *name, double otherwise);
int pbrt_int(pbrt *p, const pbrt_params *params, const char *name, int otherwise);
bool pbrt_bool(pbrt *p, const pbrt_params *params, const char *name, bool otherwise);
/* Lives as long as the parameters. */
const char *pbrt_string(pbrt *p, const pbrt_params *params, const char *name,
                        const char *otherwise);
dvec3 pbrt_vec3(pbrt *p, const pbrt_params *params, const char *name, dvec3 otherwise);
/* All numbers, `per` for each item; NULL and 0: there are none. *count in items. */
const double *pbrt_numbers(pbrt *p, const pbrt_params *params, const char *name, size_t per,
                           size_t *count);
/* Known, and not needed: no warning. Names with blanks between. */
void pbrt_ignore(const pbrt_params *params, const char *names);
/* Known, but snell lacks it: a warning where it is given. */
void pbrt_lacks(pbrt *p, const pbrt_params *params, const char *names);
/* A warning for each that nobody asked for. */
snell_status pbrt_check_unused(pbrt *p, const pbrt_params *params);

/* ---- pbrt_spectrum.c ---- */
typedef enum pbrt_spectrum_use {
    PBRT_REFLECTANCE,
    PBRT_COEFFICIENT, /* an index, absorption */
    PBRT_LIGHT        /* a spectrum's luminance counts 1, as pbrt's photometric lights have it */
} pbrt_spectrum_use;
/* A parameter of a spectrum's types to linear Rec. 709, never negative. */
snell_status pbrt_spectrum(pbrt *p, pbrt_param *param, pbrt_spectrum_use use, double out[3]);
/* By name; *found says whether there is one. */
snell_status pbrt_color(pbrt *p, const pbrt_params *params, const char *name, pbrt_spectrum_use use,
                        const double otherwise[3], double out[3], bool *found);
/* The index of refraction, a float or a spectrum, at the sodium line. */
double pbrt_index(pbrt *p, const pbrt_params *params, const char *name, double otherwise);
/* By which a colour is multiplied that this daylight (K) is to make white. */
void pbrt_white_balance(double temperature, double out[3]);

/* ---- pbrt_transforms.c ---- */
bool pbrt_inverse(const dtransform *m, dtransform *out); /* false: singular or not finite */
/* From pbrt's coordinates at the current transform to snell's world. */
dtransform pbrt_to_world(const pbrt *p, int which);
double pbrt_determinant(const dtransform *m);
dvec3 pbrt_point(const dtransform *m, dvec3 v);
dvec3 pbrt_vector(const dtransform *m, dvec3 v);
bool pbrt_is_animated(const pbrt *p);
snell_status pbrt_name_system(pbrt *p, const char *name, const dtransform system[2]);
/* The directives: the word was read, what follows it was not. */
snell_status pbrt_do_identity(pbrt *p);
snell_status pbrt_do_translate(pbrt *p);
snell_status pbrt_do_scale(pbrt *p);
snell_status pbrt_do_rotate(pbrt *p);
snell_status pbrt_do_look_at(pbrt *p);
snell_status pbrt_do_transform(pbrt *p);
snell_status pbrt_do_concat_transform(pbrt *p);
snell_status pbrt_do_coordinate_system(pbrt *p);
snell_status pbrt_do_coord_sys_transform(pbrt *p);
snell_status pbrt_do_active_transform(pbrt *p);
snell_status pbrt_do_transform_times(pbrt *p);

/* ---- the objects ---- */
snell_status pbrt_begin_world(pbrt *p); /* pbrt_view.c */
snell_status pbrt_finish_view(pbrt *p); /* when everything was read */
snell_status pbrt_light(pbrt *p, const pbrt_params *params);
snell_status pbrt_area_light_of(pbrt *p, const pbrt_params *params, pbrt_area_light *out);
snell_status pbrt_texture_add(pbrt *p, const char *name, bool is_float, const pbrt_params *params);
void pbrt_texture_free(pbrt_texture *texture);
snell_status pbrt_material_add(pbrt *p, const char *name, const pbrt_params *params, size_t *index);
/* The material as a shape has it; *out is its index in the description. */
snell_status pbrt_material_use(pbrt *p, size_t index, const pbrt_variant *with, uint32_t *out);
snell_status pbrt_shape(pbrt *p, const pbrt_params *params);
/* What was gathered becomes a shape, before an object begins or ends, and at the end. */
snell_status pbrt_flush_strands(pbrt *p);
void pbrt_strands_free(pbrt_strands *strands);

/* A named texture, or the parameter's own value; numbers of float textures. `otherwise` where there
 * is no parameter; *found may be NULL. */
snell_status pbrt_input(pbrt *p, const pbrt_params *params, const char *name, bool is_float,
                        const double otherwise[3], snell_input *out, bool *found);
/* The same, of a float that becomes snell's roughness: `power` of it. */
snell_status pbrt_roughness_input(pbrt *p, const pbrt_params *params, const char *name,
                                  double otherwise, double power, snell_input *out, bool *found);
size_t pbrt_texture_find(pbrt *p, const pbrt_param *param, bool is_float); /* SIZE_MAX: an error */
/* An image file; *out's pixels are freed by image_free. A missing or broken one is a warning, and
 * *found false. */
snell_status pbrt_read_image(pbrt *p, const char *name, source_place place, decoded_image *out,
                             bool *found);
/* Linear red, green and blue of a pixel; gamma: of 8 bits, 0: sRGB. */
void pbrt_pixel(const decoded_image *image, double gamma, uint32_t x, uint32_t y, double out[3]);
/* pbrt_bake.c: a tree as an image over u, v from 0 to 1, or one image as it lies; each value to the
 * power, times factor; colours, being fractions of light, are cut at 1. false: it has a pattern in space, which has no u and v, or is too large. */
bool pbrt_can_bake(const pbrt *p, size_t texture);
snell_status pbrt_bake(pbrt *p, size_t texture, bool is_float, double power, const double factor[3],
                       source_place place, snell_texture_id *out);
/* `placing`: its scale, offset, wrap and filter; NULL: once around, as the sky. */
snell_status pbrt_add_image(pbrt *p, source_place place, const decoded_image *image, bool srgb,
                            const pbrt_texture *placing, snell_texture_id *out);
extern const char *const pbrt_wrap_words[];

/* ---- pbrt_meshes.c ---- */
typedef struct pbrt_mesh {
    dvec3 *positions, *normals; /* normals: NULL, or one for each position */
    double (*uvs)[2];           /* NULL, or one for each position */
    uint32_t *indices;
    size_t count, index_count;
} pbrt_mesh;
void pbrt_mesh_free(pbrt_mesh *mesh);
/* Room for these; the counts are set. */
snell_status pbrt_mesh_make(pbrt *p, source_place place, size_t count, size_t triangles,
                            bool normals, bool uvs, pbrt_mesh *out);
snell_status pbrt_read_ply(pbrt *p, const char *name, source_place place, pbrt_mesh *out);
snell_status pbrt_subdivide(pbrt *p, source_place place, int levels, pbrt_mesh *mesh);
/* A grid of columns x rows cells; `at` gives the point, and its normal. */
typedef void pbrt_surface_fn(const void *user, double u, double v, dvec3 *position, dvec3 *normal);
/* What all shapes have. */
typedef struct pbrt_drawn {
    const pbrt_params *params;
    snell_input alpha;
    bool exact; /* its sides matter: it shines, or is glass */
} pbrt_drawn;
/* The material with alpha and emission. area: of the piece of which a light's power is, m^2. */
snell_status pbrt_material_of(pbrt *p, const pbrt_drawn *s, double area, uint32_t *out);
snell_status pbrt_add_shape(pbrt *p, const pbrt_drawn *s, const char *type,
                            const snell_param *params, size_t count, double area,
                            const dtransform *local);
/* An instance that was made is a part of the object that is open, if there is one. */
snell_status pbrt_add_part(pbrt *p, source_place place, uint32_t made);
/* The mesh, in the shape's own space, is freed. */
snell_status pbrt_add_mesh(pbrt *p, const pbrt_drawn *s, pbrt_mesh *mesh);
bool pbrt_needs_uvs(const pbrt *p, const pbrt_drawn *s);
/* pbrt's way to make a light that is not seen: alpha 0, which it shines through. */
bool pbrt_is_hidden_light(const pbrt *p, const pbrt_drawn *s);
/* where: count fields of the light of that type, at most 6. */
snell_status pbrt_add_hidden_light(pbrt *p, const pbrt_drawn *s, const char *type, double area,
                                   const snell_param *where, size_t count);
snell_status pbrt_curve(pbrt *p, const pbrt_drawn *s);
snell_status pbrt_sphere(pbrt *p, const pbrt_drawn *s);
snell_status pbrt_cylinder(pbrt *p, const pbrt_drawn *s);
snell_status pbrt_disk(pbrt *p, const pbrt_drawn *s);

snell_status pbrt_tessellate(pbrt *p, source_place place, uint32_t columns, uint32_t rows,
                             pbrt_surface_fn *at, const void *user, pbrt_mesh *out);
double pbrt_mesh_area(const pbrt_mesh *mesh);

#endif
