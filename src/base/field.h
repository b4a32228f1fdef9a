/* A type describes itself once: DESCRIBE turns one list of fields into the description struct and
 * the table that the scene language, the importers, the C API, help texts and documentation all
 * read.
 *
 *     #define SPHERE_FIELDS(F, T)                                          \
 *         F(T, center, VEC3, DEFAULT(0, 0, 0), ANY, "m", "the centre")     \
 *         F(T, radius, FLOAT, DEFAULT(1), POSITIVE, "m", "the radius")
 *     DESCRIBE(sphere, SPHERE_FIELDS)
 *
 * gives `typedef struct sphere_desc { size_t struct_size; vec3 center; float radius; }
 * sphere_desc;` and `static const field sphere_fields[]`. tools/gen_api prints the public struct
 * snell_sphere_desc from the table. */
#ifndef SNELL_BASE_FIELD_H
#define SNELL_BASE_FIELD_H

#include <math.h>

#include <snell/snell.h>

typedef enum field_kind {
    FIELD_BOOL = 1,   /* bool */
    FIELD_INT,        /* int32_t */
    FIELD_FLOAT,      /* float */
    FIELD_VEC2,       /* snell_vec2 */
    FIELD_VEC3,       /* snell_vec3, a point or vector */
    FIELD_COLOR,      /* snell_vec3, >= 0 unless the range says otherwise */
    FIELD_INPUT,      /* snell_input, colour */
    FIELD_SCALAR,     /* snell_input, value.x */
    FIELD_CHOICE,     /* int32_t: index into the words of `choices`, from 0 */
    FIELD_STRING,     /* const char *, owned copy; "" by default */
    FIELD_TEXTURE,    /* snell_texture_id */
    FIELD_MATERIAL,   /* snell_material_id */
    FIELD_TRANSFORM,  /* snell_transform, identity by default */
    FIELD_VEC3S,      /* const snell_vec3 *NAME; size_t NAME_count */
    FIELD_VEC2S,      /* const snell_vec2 *NAME; size_t NAME_count */
    FIELD_FLOATS,     /* const float *NAME; size_t NAME_count; each in the range */
    FIELD_UINTS,      /* const uint32_t *NAME; size_t NAME_count */
    FIELD_BYTES,      /* const void *NAME; size_t NAME_count */
    FIELD_MATERIALS,  /* const snell_material_id *NAME; size_t NAME_count */
    FIELD_SHAPES,     /* const snell_shape_id *NAME; size_t NAME_count */
    FIELD_TRANSFORMS, /* const snell_transform *NAME; size_t NAME_count */
    FIELD_KEYS        /* const snell_motion_key *NAME; size_t NAME_count */
} field_kind;

enum field_flags {
    FIELD_REQUIRED = 1,
    FIELD_OPEN_MIN = 2,    /* the minimum itself is not allowed */
    FIELD_UNIT_LENGTH = 4, /* a direction: any length but 0 is given, stored normalised */
    FIELD_SOME_NONE = 8,   /* a list of ids in which 0 stands for none */
    FIELD_OR_NUMBER = 16   /* a text that the scene language may give as a number */
};

typedef struct field {
    const char *name;
    field_kind kind;
    size_t offset; /* in the description struct */
    float initial[3];
    double min, max; /* of every component; -INFINITY, INFINITY: any finite value */
    unsigned flags;
    const char *choices; /* "clip|neutral", for FIELD_CHOICE */
    const char *unit, *help;
} field;

typedef enum category {
    CATEGORY_TEXTURE,
    CATEGORY_MATERIAL,
    CATEGORY_LIGHT,
    CATEGORY_SHAPE,
    CATEGORY_CAMERA,
    CATEGORY_SETTING,
    CATEGORY_COUNT
} category;

typedef struct type_info {
    category category;
    const char *name; /* as in the scene language */
    const char *help; /* one line */
    size_t desc_size;
    const field *fields;
    uint32_t field_count;
    /* Ways to say the same thing, of which an object is given one: "corner u v|center at width", one
     * such choice after another with ';' between. NULL: none. */
    const char *either;
} type_info;

/* ---- the macros ---- */
#define DEFAULT(...)                                                                               \
    { __VA_ARGS__ }
#define NO_DEFAULT                                                                                 \
    { 0 }
/* Ranges: minimum, maximum, flags, choices. */
#define ANY -INFINITY, INFINITY, 0, NULL
#define REQUIRED -INFINITY, INFINITY, FIELD_REQUIRED, NULL
#define POSITIVE 0, INFINITY, FIELD_OPEN_MIN, NULL
#define NOT_NEGATIVE 0, INFINITY, 0, NULL
#define RANGE(low, high) low, high, 0, NULL
#define REQUIRED_RANGE(low, high) low, high, FIELD_REQUIRED, NULL
#define DIRECTION -INFINITY, INFINITY, FIELD_UNIT_LENGTH, NULL
#define REQUIRED_DIRECTION -INFINITY, INFINITY, FIELD_UNIT_LENGTH | FIELD_REQUIRED, NULL
#define CHOICES(words) 0, 255, 0, words
#define OR_NUMBER -INFINITY, INFINITY, FIELD_OR_NUMBER, NULL
#define OR_NONE -INFINITY, INFINITY, FIELD_SOME_NONE, NULL

#define FIELD_MEMBER_BOOL(name) bool name;
#define FIELD_MEMBER_INT(name) int32_t name;
#define FIELD_MEMBER_FLOAT(name) float name;
#define FIELD_MEMBER_VEC2(name) snell_vec2 name;
#define FIELD_MEMBER_VEC3(name) snell_vec3 name;
#define FIELD_MEMBER_COLOR(name) snell_vec3 name;
#define FIELD_MEMBER_INPUT(name) snell_input name;
#define FIELD_MEMBER_SCALAR(name) snell_input name;
#define FIELD_MEMBER_CHOICE(name) int32_t name;
#define FIELD_MEMBER_STRING(name) const char *name;
#define FIELD_MEMBER_TEXTURE(name) snell_texture_id name;
#define FIELD_MEMBER_MATERIAL(name) snell_material_id name;
#define FIELD_MEMBER_TRANSFORM(name) snell_transform name;
#define FIELD_MEMBER_VEC3S(name)                                                                   \
    const snell_vec3 *name;                                                                        \
    size_t name##_count;
#define FIELD_MEMBER_VEC2S(name)                                                                   \
    const snell_vec2 *name;                                                                        \
    size_t name##_count;
#define FIELD_MEMBER_FLOATS(name)                                                                  \
    const float *name;                                                                             \
    size_t name##_count;
#define FIELD_MEMBER_UINTS(name)                                                                   \
    const uint32_t *name;                                                                          \
    size_t name##_count;
#define FIELD_MEMBER_BYTES(name)                                                                   \
    const void *name;                                                                              \
    size_t name##_count;
#define FIELD_MEMBER_MATERIALS(name)                                                               \
    const snell_material_id *name;                                                                 \
    size_t name##_count;
#define FIELD_MEMBER_SHAPES(name)                                                                  \
    const snell_shape_id *name;                                                                    \
    size_t name##_count;
#define FIELD_MEMBER_TRANSFORMS(name)                                                              \
    const snell_transform *name;                                                                   \
    size_t name##_count;

#define FIELD_MEMBER_KEYS(name)                                                                    \
    const snell_motion_key *name;                                                                  \
    size_t name##_count;

/* A list of fields is a macro of two arguments, passed on: what to do with each field, and the
 * struct's name. */
#define FIELD_MEMBER(type, name, kind, initial, range, unit, help) FIELD_MEMBER_##kind(name)
#define FIELD_ROW(type, name, kind, initial, range, unit, help)                                    \
    {#name, FIELD_##kind, offsetof(type, name), initial, range, unit, help},

#define DESCRIBE_STRUCT(type, FIELDS)                                                              \
    typedef struct type##_desc {                                                                   \
        size_t struct_size;                                                                        \
        FIELDS(FIELD_MEMBER, type##_desc)                                                          \
    } type##_desc;
#define DESCRIBE_TABLE(type, FIELDS)                                                               \
    static const field type##_fields[] = {FIELDS(FIELD_ROW, type##_desc)};
#define DESCRIBE(type, FIELDS)                                                                     \
    DESCRIBE_STRUCT(type, FIELDS)                                                                  \
    DESCRIBE_TABLE(type, FIELDS)

/* The type_info of a DESCRIBEd type; and of one with fields that stand for one another. */
#define TYPE_INFO(category_, type, name_, help_)                                                   \
    TYPE_INFO_EITHER(category_, type, name_, help_, NULL)
#define TYPE_INFO_EITHER(category_, type, name_, help_, either_)                                   \
    {                                                                                              \
        category_, name_, help_, sizeof(type##_desc), type##_fields,                               \
            (uint32_t)(sizeof type##_fields / sizeof type##_fields[0]), either_                    \
    }

/* ---- working with any description (field.c) ---- */

/* Fills desc (info->desc_size bytes) with the defaults; arrays are NULL, strings "". */
void desc_init(const type_info *info, void *desc);
const field *type_find_field(const type_info *info, const char *name);
/* Sets one field from a generic parameter. Kinds are converted where that loses nothing (int to
 * float, number to grey, vec3 to input). Unknown names and wrong kinds: SNELL_ERR_ARGUMENT "sphere:
 * unknown field 'radus'" with the hint "did you mean 'radius'?". Arrays and strings are borrowed
 * until desc_copy. */
snell_status desc_set(const type_info *info, void *desc, const snell_param *param);
/* Checks required fields and `either` (`given`: one bool per field, or NULL where nobody knows),
 * ranges, NaN and infinity, directions (normalised in place). Does not know about ids. */
snell_status desc_check(const type_info *info, void *desc, const bool *given);
/* Deep copy: strings and arrays are owned by the copy. NULL on lack of memory. */
void *desc_copy(const type_info *info, const void *desc);
void desc_free(const type_info *info, void *desc);
/* The size in bytes of a field's member in the struct (of an array: of its pointer and count). */
size_t field_size(field_kind kind);
/* The width in bytes of an array element of this kind, 0 if it is no array. */
size_t field_element_size(field_kind kind);
const char *field_kind_name(field_kind kind); /* "colour", "number", ... for help texts */
/* Index of `word` in "a|b|c", -1 if it is not there. choice_word copies the index-th word to out.
 */
int choice_find(const char *choices, const char *word);
void choice_word(const char *choices, int index, char *out, size_t size);

#endif
