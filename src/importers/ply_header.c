#include "importers/ply_header.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/memory.h"
#include "importers/number.h"
#include "importers/surfaces.h"

enum { PROPERTIES_MAX = 1024 };
const uint8_t ply_sizes[SCALARS] = {1, 1, 2, 2, 4, 4, 4, 8};

typedef struct reading {
    const char *path, *text, *at, *end;
    description *d;
    ply_header *out;
} reading;

static snell_status bad_header(const reading *r, const char *at, const char *what,
                               const char *word) {
    return error_set_at(SNELL_ERR_SYNTAX, text_place(r->path, r->text, at), NULL,
                        "PLY header: %s%s%.60s%s", what, word ? " '" : "", word ? word : "",
                        word ? "'" : "");
}

typedef struct header_line {
    const char *at, *end;
} header_line;

/* Lines end with \n, \r\n or \r. false: there is none. */
static bool next_line(reading *r, header_line *line) {
    if (r->at == r->end) return false;
    line->at = r->at;
    while (r->at < r->end && *r->at != '\n' && *r->at != '\r') r->at++;
    line->end = r->at;
    if (r->at < r->end && *r->at == '\r' && r->at[1] == '\n') r->at++;
    if (r->at < r->end) r->at++;
    return true;
}

/* The next word of the line, cut where it is too long for one that means something; "" at its end. */
static const char *next_word(header_line *line, char word[PLY_WORD_MAX]) {
    size_t used = 0;
    while (line->at < line->end && (*line->at == ' ' || *line->at == '\t')) line->at++;
    const char *start = line->at;
    for (; line->at < line->end && *line->at != ' ' && *line->at != '\t'; line->at++)
        if (used + 1 < PLY_WORD_MAX) word[used++] = *line->at;
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

property *ply_find_property(const element *e, int wanted) {
    for (size_t i = 0; i < e->property_count; i++)
        if (e->properties[i].role == (role)wanted) return &e->properties[i];
    return NULL;
}

static snell_status read_property(reading *r, header_line *line) {
    char word[PLY_WORD_MAX];
    if (r->out->element_count == 0)
        return bad_header(r, line->at, "a property before the first element", NULL);
    element *e = &r->out->elements[r->out->element_count - 1];
    property made = {.role = NO_ROLE};
    const char *at = next_word(line, word);
    made.list = strcmp(word, "list") == 0;
    if (made.list) {
        at = next_word(line, word);
        if (!read_type(word, &made.count_type) || made.count_type >= F32)
            return bad_header(r, at, "the length of a list cannot be of type", word);
        at = next_word(line, word);
    }
    if (!read_type(word, &made.type)) return bad_header(r, at, "unknown type", word);
    at = next_word(line, made.name);
    if (made.name[0] == 0) return bad_header(r, at, "a property without a name", NULL);
    made.role = find_role(e->name, &made);
    if (made.role != NO_ROLE && ply_find_property(e, (int)made.role)) made.role = NO_ROLE;
    if (e->property_count >= PROPERTIES_MAX)
        return bad_header(r, at, "too many properties in element", e->name);
    if (!ARRAY_GROW(e->properties, e->property_count, e->property_capacity, 1))
        return error_no_memory();
    e->properties[e->property_count++] = made;
    return SNELL_OK;
}

static snell_status read_element(reading *r, header_line *line) {
    char word[PLY_WORD_MAX];
    if (r->out->element_count == PLY_ELEMENTS_MAX)
        return bad_header(r, line->at, "too many elements", NULL);
    element *e = &r->out->elements[r->out->element_count++];
    const char *at = next_word(line, e->name);
    if (e->name[0] == 0) return bad_header(r, at, "an element without a name", NULL);
    at = next_word(line, word);
    int64_t count;
    const char *rest = number_read_integer(word, &count);
    if (rest == NULL || *rest || count < 0)
        return bad_header(r, at, "the count of an element cannot be", word);
    if (count >= UINT32_MAX) return bad_header(r, at, "too many rows:", word);
    e->count = (uint64_t)count;
    return SNELL_OK;
}

static snell_status read_format(reading *r, header_line *line) {
    char word[PLY_WORD_MAX];
    const char *at = next_word(line, word);
    const uint16_t one = 1;
    bool little = *(const uint8_t *)&one == 1;
    r->out->ascii = strcmp(word, "ascii") == 0;
    if (strcmp(word, "binary_little_endian") == 0)
        r->out->swapped = !little;
    else if (strcmp(word, "binary_big_endian") == 0)
        r->out->swapped = little;
    else if (!r->out->ascii)
        return bad_header(r, at, "unknown format", word);
    at = next_word(line, word);
    return strcmp(word, "1.0") == 0 ? SNELL_OK : bad_header(r, at, "unknown version", word);
}

/* comment TextureFile NAME */
static void read_comment(reading *r, header_line *line) {
    char word[PLY_WORD_MAX];
    next_word(line, word);
    if (strcasecmp(word, "TextureFile") != 0 || r->out->picture[0]) return;
    const char *at = line->at, *end = line->end;
    while (at < end && (*at == ' ' || *at == '\t')) at++;
    while (end > at && (end[-1] == ' ' || end[-1] == '\t')) end--;
    if ((size_t)(end - at) < sizeof r->out->picture)
        memcpy(r->out->picture, at, (size_t)(end - at));
}

static snell_status read_lines(reading *r) {
    header_line line = {r->at, r->at};
    char word[PLY_WORD_MAX];
    bool has_format = false;
    next_line(r, &line);
    next_word(&line, word);
    if (strcmp(word, "ply") != 0)
        return bad_header(r, r->text, "a PLY file begins with the line 'ply', not with", word);
    while (next_line(r, &line)) {
        const char *at = next_word(&line, word);
        snell_status status = SNELL_OK;
        if (strcmp(word, "end_header") == 0)
            return has_format ? SNELL_OK : bad_header(r, at, "it names no format", NULL);
        if (strcmp(word, "format") == 0)
            status = read_format(r, &line), has_format = true;
        else if (strcmp(word, "element") == 0)
            status = read_element(r, &line);
        else if (strcmp(word, "property") == 0)
            status = read_property(r, &line);
        else if (strcmp(word, "comment") == 0)
            read_comment(r, &line);
        else if (word[0] && strcmp(word, "obj_info") != 0)
            status = description_add_message(
                r->d, SNELL_WARNING, r->path, text_place(r->path, r->text, at).line, NULL,
                "PLY header: a line that begins with '%s' is not read", word);
        if (status) return status;
    }
    return bad_header(r, r->end, "it has no end", NULL);
}

snell_status ply_header_read(const char *path, const char **at, const char *end, description *d,
                             ply_header *out) {
    reading r = {path, *at, *at, end, d, out};
    snell_status status = read_lines(&r);
    *at = r.at;
    return status;
}

void ply_header_free(ply_header *h) {
    for (size_t i = 0; i < h->element_count; i++) free(h->elements[i].properties);
}
