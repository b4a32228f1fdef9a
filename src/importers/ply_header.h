/* The header of a PLY file: which elements follow, and of what properties (ply.c reads them). */
#ifndef SNELL_IMPORTERS_PLY_HEADER_H
#define SNELL_IMPORTERS_PLY_HEADER_H

#include "scene/description.h"

enum { PLY_WORD_MAX = 64, PLY_ELEMENTS_MAX = 64 };

typedef enum scalar { I8, U8, I16, U16, I32, U32, F32, F64, SCALARS } scalar;
extern const uint8_t ply_sizes[SCALARS]; /* bytes */

/* What snell makes of it. */
typedef enum role {
    POSITION, /* and the next two */
    NORMAL = POSITION + 3,
    COLOR = NORMAL + 3,
    UV = COLOR + 3,
    ALPHA = UV + 2,
    INDICES,
    TEXCOORD, /* of a face: u v for each corner */
    NO_ROLE
} role;

typedef struct property {
    char name[PLY_WORD_MAX];
    scalar type, count_type; /* the latter of a list */
    bool list;
    role role;
    float *to; /* the first row's value; NULL: not wanted */
    size_t step;
} property;

typedef struct element {
    char name[PLY_WORD_MAX];
    uint64_t count;
    property *properties;
    size_t property_count, property_capacity;
} element;

typedef struct ply_header {
    bool ascii, swapped; /* swapped: binary, in the other byte order */
    element elements[PLY_ELEMENTS_MAX];
    size_t element_count;
    char picture[256]; /* that a comment names, as MeshLab has it; "": none */
} ply_header;

/* Reads what stands at *at, from the file's beginning, before `end` (where a 0 is); then *at is behind it. *out begins
 * with zeros, and is to be freed after an error too. Errors have their place in the file of this path; what is not
 * understood and does no harm is a warning of d. */
snell_status ply_header_read(const char *path, const char **at, const char *end, description *d,
                             ply_header *out);
void ply_header_free(ply_header *h);
/* The property of this role, `wanted`, NULL: there is none. */
property *ply_find_property(const element *e, int wanted);

#endif
