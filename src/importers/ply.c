/* PLY, the Polygon File Format (Turk, The PLY Polygon File Format, Stanford 1994): text, and binary of either
 * byte order; properties of any type in any order; elements that we do not know are stepped over. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/memory.h"
#include "image/srgb.h"
#include "importers/maps.h"
#include "importers/number.h"
#include "importers/seams.h"

enum { WORD_MAX = 64, ELEMENTS_MAX = 64, PROPERTIES_MAX = 1024 };

typedef enum scalar { I8, U8, I16, U16, I32, U32, F32, F64, SCALARS } scalar;
static const uint8_t sizes[SCALARS] = {1, 1, 2, 2, 4, 4, 4, 8};

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
    char name[WORD_MAX];
    scalar type, count_type; /* the latter of a list */
    bool list;
    role role;
    float *to; /* the first row's value; NULL: not wanted */
    size_t step;
} property;

typedef struct element {
    char name[WORD_MAX];
    uint64_t count;
    property *properties;
    size_t property_count, property_capacity;
} element;

typedef struct ply {
    const char *path, *text, *at, *end; /* *end is 0 */
    const import_options *options;
    description *d;
    bool ascii, swapped;
    element elements[ELEMENTS_MAX];
    size_t element_count;
    surfaces out;
    polygons faces;
    seams seams;
    float *row_uvs; /* of the face that is being read */
    size_t row_uv_count, row_uv_capacity;
    char picture[256]; /* that a comment names, as MeshLab has it */
    bool see_through, lacks_corners;
} ply;

/* ---- errors ---- */

/* In a text, of the place `at`; binary rows have no lines. */
static source_place place_of(const ply *p, const char *at, bool is_text) {
    return is_text ? text_place(p->path, p->text, at) : (source_place){p->path, 0, 0};
}

static snell_status bad_header(const ply *p, const char *at, const char *what, const char *word) {
    return error_set_at(SNELL_ERR_SYNTAX, place_of(p, at, true), NULL, "PLY header: %s%s%.60s%s",
                        what, word ? " '" : "", word ? word : "", word ? "'" : "");
}

static snell_status bad_row(const ply *p, const char *at, const element *e, uint64_t row,
                            const char *what) {
    return error_set_at(SNELL_ERR_SYNTAX, place_of(p, at, p->ascii), NULL,
                        "PLY: %s %llu of %llu: %s", e->name, (unsigned long long)row + 1,
                        (unsigned long long)e->count, what);
}

static snell_status ends_early(const ply *p, const element *e, uint64_t row) {
    return error_set_at(SNELL_ERR_SYNTAX, place_of(p, p->end, p->ascii), "the file may be cut off",
                        "PLY: the file ends before %s %llu of %llu is whole", e->name,
                        (unsigned long long)row + 1, (unsigned long long)e->count);
}

/* ---- the header ---- */

typedef struct header_line {
    const char *at, *end;
} header_line;

/* Lines end with \n, \r\n or \r. false: there is none. */
static bool next_line(ply *p, header_line *line) {
    if (p->at == p->end) return false;
    line->at = p->at;
    while (p->at < p->end && *p->at != '\n' && *p->at != '\r') p->at++;
    line->end = p->at;
    if (p->at < p->end && *p->at == '\r' && p->at[1] == '\n') p->at++;
    if (p->at < p->end) p->at++;
    return true;
}

/* The next word of the line, cut where it is too long for one that means something; "" at its end. */
static const char *next_word(header_line *line, char word[WORD_MAX]) {
    size_t used = 0;
    while (line->at < line->end && (*line->at == ' ' || *line->at == '\t')) line->at++;
    const char *start = line->at;
    for (; line->at < line->end && *line->at != ' ' && *line->at != '\t'; line->at++)
        if (used + 1 < WORD_MAX) word[used++] = *line->at;
    word[used] = 0;
    return start;
}

static bool read_type(const char *word, scalar *out) {
    static const char *const names[SCALARS][2] = {
        {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
        {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
    for (int i = 0; i < SCALARS; i++)
        if (strcmp(word, names[i][0]) == 0 || strcmp(word, names[i][1]) == 0) {
            *out = (scalar)i;
            return true;
        }
    return false;
}

static role find_role(const char *element_name, const property *q) {
    static const struct {
        const char *name;
        role role;
    } names[] = {{"x", POSITION},
                 {"y", POSITION + 1},
                 {"z", POSITION + 2},
                 {"nx", NORMAL},
                 {"ny", NORMAL + 1},
                 {"nz", NORMAL + 2},
                 {"red", COLOR},
                 {"green", COLOR + 1},
                 {"blue", COLOR + 2},
                 {"r", COLOR},
                 {"g", COLOR + 1},
                 {"b", COLOR + 2},
                 {"diffuse_red", COLOR},
                 {"diffuse_green", COLOR + 1},
                 {"diffuse_blue", COLOR + 2},
                 {"s", UV},
                 {"t", UV + 1},
                 {"u", UV},
                 {"v", UV + 1},
                 {"texture_u", UV},
                 {"texture_v", UV + 1},
                 {"texture_s", UV},
                 {"texture_t", UV + 1},
                 {"alpha", ALPHA},
                 {"a", ALPHA},
                 {"diffuse_alpha", ALPHA}};
    if (q->list) {
        bool is_face = strcmp(element_name, "face") == 0 || strcmp(element_name, "tristrips") == 0;
        bool indices =
            strcmp(q->name, "vertex_indices") == 0 || strcmp(q->name, "vertex_index") == 0;
        if (is_face && indices && q->type < F32) return INDICES;
        bool uvs = strcmp(element_name, "face") == 0 && strcmp(q->name, "texcoord") == 0;
        return uvs && q->type >= F32 ? TEXCOORD : NO_ROLE;
    }
    if (strcmp(element_name, "vertex") != 0) return NO_ROLE;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (strcmp(q->name, names[i].name) == 0) return names[i].role;
    return NO_ROLE;
}

static property *find_property(const element *e, int wanted) {
    for (size_t i = 0; i < e->property_count; i++)
        if (e->properties[i].role == (role)wanted) return &e->properties[i];
    return NULL;
}

static snell_status read_property(ply *p, header_line *line) {
    char word[WORD_MAX];
    if (p->element_count == 0)
        return bad_header(p, line->at, "a property before the first element", NULL);
    element *e = &p->elements[p->element_count - 1];
    property made = {.role = NO_ROLE};
    const char *at = next_word(line, word);
    made.list = strcmp(word, "list") == 0;
    if (made.list) {
        at = next_word(line, word);
        if (!read_type(word, &made.count_type) || made.count_type >= F32)
            return bad_header(p, at, "the length of a list cannot be of type", word);
        at = next_word(line, word);
    }
    if (!read_type(word, &made.type)) return bad_header(p, at, "unknown type", word);
    at = next_word(line, made.name);
    if (made.name[0] == 0) return bad_header(p, at, "a property without a name", NULL);
    made.role = find_role(e->name, &made);
    if (made.role != NO_ROLE && find_property(e, (int)made.role)) made.role = NO_ROLE;
    if (e->property_count >= PROPERTIES_MAX)
        return bad_header(p, at, "too many properties in element", e->name);
    if (!ARRAY_GROW(e->properties, e->property_count, e->property_capacity, 1))
        return error_no_memory();
    e->properties[e->property_count++] = made;
    return SNELL_OK;
}

static snell_status read_element(ply *p, header_line *line) {
    char word[WORD_MAX];
    if (p->element_count == ELEMENTS_MAX) return bad_header(p, line->at, "too many elements", NULL);
    element *e = &p->elements[p->element_count++];
    const char *at = next_word(line, e->name);
    if (e->name[0] == 0) return bad_header(p, at, "an element without a name", NULL);
    at = next_word(line, word);
    int64_t count;
    const char *rest = number_read_integer(word, &count);
    if (rest == NULL || *rest || count < 0)
        return bad_header(p, at, "the count of an element cannot be", word);
    if (count >= UINT32_MAX) return bad_header(p, at, "too many rows:", word);
    e->count = (uint64_t)count;
    return SNELL_OK;
}

static snell_status read_format(ply *p, header_line *line) {
    char word[WORD_MAX];
    const char *at = next_word(line, word);
    const uint16_t one = 1;
    bool little = *(const uint8_t *)&one == 1;
    p->ascii = strcmp(word, "ascii") == 0;
    if (strcmp(word, "binary_little_endian") == 0)
        p->swapped = !little;
    else if (strcmp(word, "binary_big_endian") == 0)
        p->swapped = little;
    else if (!p->ascii)
        return bad_header(p, at, "unknown format", word);
    at = next_word(line, word);
    return strcmp(word, "1.0") == 0 ? SNELL_OK : bad_header(p, at, "unknown version", word);
}

/* comment TextureFile NAME */
static void read_comment(ply *p, header_line *line) {
    char word[WORD_MAX];
    next_word(line, word);
    if (strcasecmp(word, "TextureFile") != 0 || p->picture[0]) return;
    const char *at = line->at, *end = line->end;
    while (at < end && (*at == ' ' || *at == '\t')) at++;
    while (end > at && (end[-1] == ' ' || end[-1] == '\t')) end--;
    if ((size_t)(end - at) < sizeof p->picture) memcpy(p->picture, at, (size_t)(end - at));
}

static snell_status read_header(ply *p) {
    header_line line = {p->at, p->at};
    char word[WORD_MAX];
    bool has_format = false;
    next_line(p, &line);
    next_word(&line, word);
    if (strcmp(word, "ply") != 0)
        return bad_header(p, p->text, "a PLY file begins with the line 'ply', not with", word);
    while (next_line(p, &line)) {
        const char *at = next_word(&line, word);
        snell_status status = SNELL_OK;
        if (strcmp(word, "end_header") == 0)
            return has_format ? SNELL_OK : bad_header(p, at, "it names no format", NULL);
        if (strcmp(word, "format") == 0)
            status = read_format(p, &line), has_format = true;
        else if (strcmp(word, "element") == 0)
            status = read_element(p, &line);
        else if (strcmp(word, "property") == 0)
            status = read_property(p, &line);
        else if (strcmp(word, "comment") == 0)
            read_comment(p, &line);
        else if (word[0] && strcmp(word, "obj_info") != 0)
            status = description_add_message(
                p->d, SNELL_WARNING, p->path, place_of(p, at, true).line, NULL,
                "PLY header: a line that begins with '%s' is not read", word);
        if (status) return status;
    }
    return bad_header(p, p->end, "it has no end", NULL);
}

/* ---- values ---- */

static inline double load(const char *at, scalar type, bool swapped) {
    union {
        char bytes[8];
        int8_t i8;
        uint8_t u8;
        int16_t i16;
        uint16_t u16;
        int32_t i32;
        uint32_t u32;
        float f32;
        double f64;
    } v;
    size_t size = sizes[type];
    if (swapped)
        for (size_t i = 0; i < size; i++) v.bytes[i] = at[size - 1 - i];
    else
        memcpy(v.bytes, at, size);
    switch (type) {
    case I8: return v.i8;
    case U8: return v.u8;
    case I16: return v.i16;
    case U16: return v.u16;
    case I32: return v.i32;
    case U32: return v.u32;
    case F32: return (double)v.f32;
    default: return v.f64;
    }
}

/* Bytes and words are fractions of their largest value; wider integers are bytes in disguise. */
static float color_of(double value, scalar type) {
    if (type == U8) return srgb_table()[(int)(value >= 0 && value <= 255 ? value : 255)];
    static const double largest[SCALARS] = {127, 255, 32767, 65535, 255, 255, 1, 1};
    return srgb_to_linear(value / largest[type]);
}

static float convert(const property *q, double value) {
    if (q->role >= COLOR && q->role < UV) return color_of(value, q->type);
    return (float)value;
}

static void note_alpha(ply *p, const property *q, double value) {
    static const double opaque[SCALARS] = {127, 255, 32767, 65535, 255, 255, 1, 1};
    if (q->role == ALPHA && value < opaque[q->type]) p->see_through = true;
}

/* Every row of one property of an element without lists. */
static void read_column(ply *p, const property *q, const char *at, size_t stride, uint64_t count) {
    float *to = q->to;
    size_t step = q->step;
    if (q->type == F32 && !p->swapped && to && q->role < COLOR) {
        for (uint64_t i = 0; i < count; i++, at += stride, to += step) memcpy(to, at, sizeof *to);
    } else if (q->type == U8 && to && q->role >= COLOR && q->role < UV) {
        const float *table = srgb_table();
        for (uint64_t i = 0; i < count; i++, at += stride, to += step) *to = table[(uint8_t)*at];
    } else if (to) {
        for (uint64_t i = 0; i < count; i++, at += stride, to += step)
            *to = convert(q, load(at, q->type, p->swapped));
    } else if (q->role == ALPHA) {
        for (uint64_t i = 0; i < count; i++, at += stride)
            note_alpha(p, q, load(at, q->type, p->swapped));
    }
}

static inline bool is_space(char c) {
    return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\f' || c == '\v';
}

static inline void skip_space(ply *p) {
    while (is_space(*p->at)) p->at++;
}

static const char *word_start(const ply *p, const char *end) {
    while (end > p->text && !is_space(end[-1])) end--;
    return end;
}

static snell_status bad_word(const ply *p, const element *e, uint64_t row) {
    if (p->at >= p->end) return ends_early(p, e, row);
    char what[WORD_MAX + 32];
    int length = 0;
    while (length < 40 && p->at[length] && !is_space(p->at[length])) length++;
    snprintf(what, sizeof what, "'%.*s' is no number", length, p->at);
    return bad_row(p, p->at, e, row, what);
}

static inline snell_status read_text_integer(ply *p, const element *e, uint64_t row, int64_t *out) {
    skip_space(p);
    const char *rest = number_read_integer(p->at, out);
    if (rest == NULL || (*rest && !is_space(*rest))) return bad_word(p, e, row);
    p->at = rest;
    return SNELL_OK;
}

/* What some write for normals of nothing: nan, -nan, inf, nan(ind) */
static const char *skip_not_finite(const char *at) {
    if (*at == '-' || *at == '+') at++;
    if (strncasecmp(at, "nan", 3) != 0 && strncasecmp(at, "inf", 3) != 0) return NULL;
    while (*at && !is_space(*at)) at++;
    return at;
}

static inline snell_status read_text_number(ply *p, const element *e, uint64_t row, float *out) {
    skip_space(p);
    const char *rest = number_read(p->at, out);
    if (rest == NULL) *out = NAN, rest = skip_not_finite(p->at);
    if (rest == NULL || (*rest && !is_space(*rest))) return bad_word(p, e, row);
    p->at = rest;
    return SNELL_OK;
}

/* The next value of a row, whatever the encoding. */
static inline snell_status read_integer(ply *p, const element *e, uint64_t row, scalar type,
                                        int64_t *out) {
    if (p->ascii) return read_text_integer(p, e, row, out);
    if ((size_t)(p->end - p->at) < sizes[type]) return ends_early(p, e, row);
    *out = (int64_t)load(p->at, type, p->swapped);
    p->at += sizes[type];
    return SNELL_OK;
}

static snell_status skip_list(ply *p, const element *e, uint64_t row, const property *q) {
    int64_t count = 0;
    float unused;
    snell_status status = read_integer(p, e, row, q->count_type, &count);
    if (status) return status;
    if (count < 0) return bad_row(p, p->at, e, row, "a list of negative length");
    if (!p->ascii) {
        if ((uint64_t)count > (uint64_t)(p->end - p->at) / sizes[q->type])
            return ends_early(p, e, row);
        p->at += (size_t)count * sizes[q->type];
    }
    for (int64_t i = 0; p->ascii && i < count && !status; i++)
        status = read_text_number(p, e, row, &unused);
    return status;
}

static snell_status read_single(ply *p, const element *e, uint64_t row, const property *q) {
    float value = 0;
    if (p->ascii) {
        snell_status status = read_text_number(p, e, row, &value);
        if (status) return status;
        if (!isfinite(value) && q->role < NORMAL)
            return bad_row(p, word_start(p, p->at), e, row, "a coordinate is not a finite number");
        note_alpha(p, q, (double)value);
        if (q->to) q->to[row * q->step] = convert(q, (double)value);
        return SNELL_OK;
    }
    if ((size_t)(p->end - p->at) < sizes[q->type]) return ends_early(p, e, row);
    double exact = load(p->at, q->type, p->swapped);
    p->at += sizes[q->type];
    note_alpha(p, q, exact);
    if (q->to) q->to[row * q->step] = convert(q, exact);
    return SNELL_OK;
}

static void say_progress(const ply *p, uint64_t row) {
    if (row % 65536 != 0) return;
    import_forget(p->text, (size_t)(p->end - p->text), p->at);
    if (p->options->progress)
        p->options->progress(p->options->progress_user,
                             (double)(p->at - p->text) / (double)(p->end - p->text));
}

/* ---- elements ---- */

static size_t row_size(const element *e) { /* bytes; of a list, without its values */
    size_t sum = 0;
    for (size_t i = 0; i < e->property_count; i++)
        sum += sizes[e->properties[i].list ? e->properties[i].count_type : e->properties[i].type];
    return sum;
}

/* So that no count makes us take more memory than the file has bytes, a few times over. */
static snell_status check_size(const ply *p, const element *e) {
    size_t least = p->ascii ? 2 * e->property_count : row_size(e);
    uint64_t left = (uint64_t)(p->end - p->at) + p->ascii; /* the last may lack its line end */
    return least && e->count > left / least ? ends_early(p, e, left / least) : SNELL_OK;
}

static snell_status read_rows(ply *p, element *e) {
    bool lists = false;
    for (size_t i = 0; i < e->property_count; i++) lists |= e->properties[i].list;
    if (e->property_count == 0) return SNELL_OK;
    if (!lists && !p->ascii) {
        size_t stride = row_size(e), offset = 0;
        for (size_t i = 0; i < e->property_count; i++) {
            read_column(p, &e->properties[i], p->at + offset, stride, e->count);
            offset += sizes[e->properties[i].type];
        }
        p->at += e->count * stride;
        return SNELL_OK;
    }
    for (uint64_t row = 0; row < e->count; row++) {
        say_progress(p, row);
        for (size_t i = 0; i < e->property_count; i++) {
            const property *q = &e->properties[i];
            snell_status status = q->list ? skip_list(p, e, row, q) : read_single(p, e, row, q);
            if (status) return status;
        }
    }
    return SNELL_OK;
}

/* Gives an array to the `parts` properties of a role, if all are there. */
static void want(element *e, role first, size_t parts, float **array, bool *failed) {
    for (size_t i = 0; i < parts; i++)
        if (find_property(e, (int)(first + i)) == NULL) return;
    *array = memory_aligned(e->count * parts * sizeof **array);
    *failed |= *array == NULL;
    for (size_t i = 0; i < parts && *array; i++) {
        property *q = find_property(e, (int)(first + i));
        q->to = *array + i;
        q->step = parts;
    }
}

static snell_status check_vertices(const ply *p, const element *e) {
    const float *numbers = &p->out.positions[0].x;
    for (size_t i = 0; i < 3 * p->out.vertex_count; i++)
        if (!isfinite(numbers[i]))
            return bad_row(p, p->at, e, i / 3, "a coordinate is not a finite number");
    float *loose[] = {(float *)p->out.normals, (float *)p->out.colors, (float *)p->out.uvs};
    static const size_t parts[] = {3, 3, 2};
    for (int k = 0; k < 3; k++) /* these may be garbage where nobody looks */
        for (size_t i = 0; loose[k] && i < parts[k] * p->out.vertex_count; i++)
            if (!isfinite(loose[k][i])) loose[k][i] = 0;
    return SNELL_OK;
}

static snell_status read_vertices(ply *p, element *e) {
    float *positions = NULL, *normals = NULL, *colors = NULL, *uvs = NULL;
    bool failed = false;
    if (p->out.positions) return bad_row(p, p->at, e, 0, "a second element of this name");
    snell_status status = check_size(p, e);
    if (status) return status;
    want(e, POSITION, 3, &positions, &failed);
    want(e, NORMAL, 3, &normals, &failed);
    want(e, COLOR, 3, &colors, &failed);
    want(e, UV, 2, &uvs, &failed);
    p->out.vertex_count = e->count;
    p->out.positions = (snell_vec3 *)positions;
    p->out.normals = (snell_vec3 *)normals;
    p->out.colors = (snell_vec3 *)colors;
    p->out.uvs = (snell_vec2 *)uvs;
    if (failed) return error_no_memory();
    status = read_rows(p, e);
    return status ? status : check_vertices(p, e);
}

static uint64_t vertex_total(const ply *p) {
    for (size_t i = 0; i < p->element_count; i++)
        if (strcmp(p->elements[i].name, "vertex") == 0) return p->elements[i].count;
    return 0;
}

static snell_status bad_index(const ply *p, const element *e, uint64_t row, int64_t index) {
    char what[128];
    snprintf(what, sizeof what, "vertex %lld: there are %llu, counted from 0", (long long)index,
             (unsigned long long)vertex_total(p));
    return bad_row(p, p->ascii ? word_start(p, p->at) : p->at, e, row, what);
}

static snell_status read_polygon(ply *p, const element *e, uint64_t row, const property *q,
                                 uint64_t total) {
    int64_t count = 0, index = 0;
    snell_status status = read_integer(p, e, row, q->count_type, &count);
    if (status) return status;
    uint64_t least = p->ascii ? 2 : sizes[q->type];
    if (count < 0 || (uint64_t)count > (uint64_t)(p->end - p->at + 1) / least)
        return count < 0 ? bad_row(p, p->at, e, row, "a face with a negative number of corners")
                         : ends_early(p, e, row);
    if (count < 3) p->lacks_corners = true;
    uint32_t *to = count >= 3 ? polygons_add(&p->faces, (uint32_t)count) : NULL;
    if (count >= 3 && to == NULL) return error_no_memory();
    for (int64_t i = 0; i < count; i++) {
        status = read_integer(p, e, row, q->type, &index);
        if (status) return status;
        if ((uint64_t)index >= total) return bad_index(p, e, row, index);
        if (to) to[i] = (uint32_t)index;
    }
    return SNELL_OK;
}

/* Corners of one strip after the other, -1 between them. */
static snell_status read_strips(ply *p, const element *e, uint64_t row, const property *q,
                                uint64_t total) {
    int64_t count = 0, index = 0;
    uint32_t last[2] = {0, 0}, length = 0;
    snell_status status = read_integer(p, e, row, q->count_type, &count);
    for (int64_t i = 0; i < count && !status; i++) {
        status = read_integer(p, e, row, q->type, &index);
        if (status) return status;
        if (index < 0) {
            length = 0;
            continue;
        }
        if ((uint64_t)index >= total) return bad_index(p, e, row, index);
        if (length >= 2) {
            uint32_t *to = polygons_add(&p->faces, 3);
            if (to == NULL) return error_no_memory();
            to[0] = last[0], to[1] = last[1], to[2] = (uint32_t)index; /* so it faces one way */
        }
        last[length++ % 2] = (uint32_t)index;
    }
    return status;
}

/* Most files have nothing else: three integers of 32 bits after a byte that says so, row after row. */
static uint64_t read_plain_triangles(ply *p, const element *e, uint64_t total) {
    const property *q = e->properties;
    if (p->ascii || p->swapped || e->property_count != 1 || sizes[q->count_type] != 1 ||
        sizes[q->type] != 4 || e->count > (uint64_t)(p->end - p->at) / 13 || p->faces.indices)
        return 0;
    p->faces.indices = memory_aligned(3 * e->count * sizeof *p->faces.indices);
    if (p->faces.indices == NULL) return 0;
    p->faces.index_capacity = 3 * e->count;
    const char *at = p->at;
    uint32_t *to = p->faces.indices + p->faces.index_count;
    uint64_t row = 0;
    for (; row < e->count && *at == 3; row++, at += 13, to += 3) {
        memcpy(to, at + 1, 12);
        if (to[0] >= total || to[1] >= total || to[2] >= total) break;
    }
    p->at = at;
    p->faces.index_count += 3 * row;
    return row;
}

static snell_status read_row_uvs(ply *p, const element *e, uint64_t row, const property *q) {
    int64_t count = 0;
    snell_status status = read_integer(p, e, row, q->count_type, &count);
    if (status) return status;
    uint64_t least = p->ascii ? 2 : sizes[q->type];
    if (count < 0 || (uint64_t)count > (uint64_t)(p->end - p->at + 1) / least)
        return ends_early(p, e, row);
    if (!ARRAY_GROW(p->row_uvs, 0, p->row_uv_capacity, (size_t)count)) return error_no_memory();
    property one = {.type = q->type, .role = NO_ROLE, .to = p->row_uvs, .step = 0};
    for (p->row_uv_count = 0; p->row_uv_count < (size_t)count; p->row_uv_count++, one.to++) {
        status = read_single(p, e, row, &one);
        if (status) return status;
        if (!isfinite(*one.to)) *one.to = 0;
    }
    return SNELL_OK;
}

/* The corners of the last polygon, if it is of this row, get the vertices that have their coordinates. */
static snell_status place_row_uvs(ply *p, size_t first, uint64_t total) {
    size_t needed = p->faces.index_count - first, corners = p->row_uv_count / 2;
    if (needed == 0 || corners < 3 || needed != 3 * (corners - 2)) return SNELL_OK;
    for (size_t i = 0; i < corners; i++) {
        uint32_t *index = &p->faces.indices[first + i];
        *index = seams_find(&p->seams, (size_t)total, *index,
                            (snell_vec2){p->row_uvs[2 * i], p->row_uvs[2 * i + 1]});
        if (*index == UINT32_MAX) return error_no_memory();
    }
    return SNELL_OK;
}

static snell_status read_faces(ply *p, element *e) {
    bool strips = strcmp(e->name, "tristrips") == 0;
    const property *indices = find_property(e, INDICES), *uvs = find_property(e, TEXCOORD);
    uint64_t total = vertex_total(p);
    snell_status status = check_size(p, e);
    if (status) return status;
    if (indices == NULL && e->count)
        return bad_row(p, p->at, e, 0, "it has no list of integers 'vertex_indices'");
    uint64_t row = indices && !strips ? read_plain_triangles(p, e, total) : 0;
    for (; row < e->count; row++) {
        size_t first = p->faces.index_count;
        say_progress(p, row);
        p->row_uv_count = 0;
        for (size_t i = 0; i < e->property_count; i++) {
            const property *q = &e->properties[i];
            if (q == uvs)
                status = read_row_uvs(p, e, row, q);
            else if (q == indices)
                status =
                    strips ? read_strips(p, e, row, q, total) : read_polygon(p, e, row, q, total);
            else
                status = q->list ? skip_list(p, e, row, q) : read_single(p, e, row, q);
            if (status) return status;
        }
        if (uvs && (status = place_row_uvs(p, first, total)) != SNELL_OK) return status;
    }
    return SNELL_OK;
}

/* ---- the whole ---- */

/* White, or, where there are coordinates, in the colours of the picture. */
static snell_status make_material(const ply *p, uint32_t *material) {
    *material = NO_MATERIAL;
    snell_status status = SNELL_OK;
    if (p->picture[0] && p->out.uvs == NULL)
        status = description_add_message(p->d, SNELL_WARNING, p->path, 0, NULL,
                                         "texture '%.200s': there are no coordinates for it",
                                         p->picture);
    if (status) return status;
    if (p->picture[0] == 0 || p->out.uvs == NULL) return surfaces_plain(p->d, p->path, 1, material);
    decoded_image image;
    snell_texture_id texture;
    status = map_load(p->path, p->picture, p->options, &image);
    if (status == SNELL_ERR_MEMORY) return status;
    if (status) {
        char text[400];
        snprintf(text, sizeof text, "%s", error_last()->text);
        status = description_add_message(p->d, SNELL_WARNING, p->path, 0, NULL,
                                         "texture '%.200s': %s; white is used", p->picture, text);
        return status ? status : surfaces_plain(p->d, p->path, 1, material);
    }
    status = map_add(p->d, p->path, &image, &(map_look){.use = MAP_COLOR}, &texture);
    image_free(&image);
    if (status) return status;
    const snell_param color = {"color", SNELL_PARAM_TEXTURE, {.texture = texture}};
    return description_add(p->d, CATEGORY_MATERIAL, "lambert", &color, 1,
                           (object_source){NULL, p->path, 0}, material);
}

/* What has a value beside those that are looked at, in one message. */
static snell_status warn_of_losses(const ply *p) {
    char list[400] = "";
    for (size_t i = 0; i < p->element_count; i++) {
        const element *e = &p->elements[i];
        bool known = strcmp(e->name, "vertex") == 0 || strcmp(e->name, "face") == 0 ||
                     strcmp(e->name, "tristrips") == 0;
        if (e->count == 0) continue;
        size_t used = strlen(list);
        if (!known) snprintf(list + used, sizeof list - used, ", element %s", e->name);
        for (size_t k = 0; k < e->property_count && known; k++) {
            const property *q = &e->properties[k];
            used = strlen(list);
            if (q->role == NO_ROLE || (q->to == NULL && q->role < ALPHA))
                snprintf(list + used, sizeof list - used, ", %s of %s", q->name, e->name);
        }
    }
    snell_status status = SNELL_OK;
    if (list[0])
        status = description_add_message(p->d, SNELL_WARNING, p->path, 0, NULL, "not used: %s",
                                         list + 2);
    if (!status && p->see_through)
        status = description_add_message(p->d, SNELL_WARNING, p->path, 0, NULL,
                                         "alpha of vertices is not used: they are opaque");
    if (!status && p->lacks_corners)
        status = description_add_message(p->d, SNELL_WARNING, p->path, 0, NULL,
                                         "faces with fewer than three corners are not drawn");
    return status;
}

static snell_status finish(ply *p) {
    if (p->faces.index_count == 0)
        return error_set_at(SNELL_ERR_SYNTAX, (source_place){p->path, 0, 0}, NULL,
                            p->out.vertex_count ? "the file has no surfaces, only points"
                                                : "the file has no surfaces");
    if (!seams_apply(&p->seams, &p->out) || !polygons_cut(&p->faces, p->out.positions))
        return error_no_memory();
    p->out.indices = p->faces.indices;
    p->out.index_count = p->faces.index_count;
    p->faces.indices = NULL;
    snell_status status = p->out.normals ? SNELL_OK : surfaces_smooth(&p->out, NULL, NULL);
    uint32_t material = NO_MATERIAL;
    name_set names = {0};
    if (!status) status = make_material(p, &material);
    if (!status)
        status = surfaces_add(&p->out, p->d, &names, NULL, material, p->options->up,
                              (object_source){NULL, p->path, 0});
    names_deinit(&names);
    return status ? status : warn_of_losses(p);
}

/* Before anything is read: vertices may come after the faces that name them. */
static snell_status check_elements(const ply *p) {
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < p->element_count && !status; i++) {
        const element *e = &p->elements[i];
        if (strcmp(e->name, "vertex") == 0)
            for (int k = 0; k < 3; k++)
                if (find_property(e, POSITION + k) == NULL)
                    return bad_row(p, p->at, e, 0, "it has no x, y and z");
        status = check_size(p, e);
    }
    return status;
}

static snell_status read_elements(ply *p) {
    snell_status status = check_elements(p);
    for (size_t i = 0; i < p->element_count && !status; i++) {
        element *e = &p->elements[i];
        if (strcmp(e->name, "vertex") == 0)
            status = read_vertices(p, e);
        else if (strcmp(e->name, "face") == 0 || strcmp(e->name, "tristrips") == 0)
            status = read_faces(p, e);
        else if ((status = check_size(p, e)) == SNELL_OK)
            status = read_rows(p, e);
    }
    return status;
}

static snell_status ply_read(const char *path, const import_options *options, description *d) {
    size_t size;
    ply *p = memory_zeroed(1, sizeof *p);
    if (p == NULL) return error_no_memory();
    *p = (ply){.path = path, .options = options, .d = d};
    snell_status status = import_map_file(path, options, &p->text, &size);
    if (!status) {
        p->at = p->text;
        p->end = p->text + size;
        status = size ? read_header(p) : error_set(SNELL_ERR_SYNTAX, NULL, "the file is empty");
        if (!status) status = read_elements(p);
        if (!status) status = finish(p);
        import_unmap_file(p->text, size);
    }
    if (status) error_place((source_place){path, 0, 0});
    for (size_t i = 0; i < p->element_count; i++) free(p->elements[i].properties);
    surfaces_free(&p->out);
    seams_free(&p->seams);
    free(p->row_uvs);
    free(p->faces.indices);
    free(p->faces.list);
    free(p);
    snprintf(d->format, sizeof d->format, "ply");
    d->is_model = true;
    return status;
}

static bool ply_recognise(const char *extension, const uint8_t *first, size_t size) {
    if (size >= 4 && memcmp(first, "ply", 3) == 0 && (first[3] == '\n' || first[3] == '\r'))
        return true;
    return strcmp(extension, ".ply") == 0;
}

const importer importer_ply = {
    .name = "ply",
    .extensions = ".ply",
    .help = "PLY, the Polygon File Format",
    .recognise = ply_recognise,
    .read = ply_read,
};
