/* STL, text and binary (3D Systems, StereoLithography Interface Specification, 1989). Facets stay flat; the normals
 * that the file gives are those of the corners' order, or wrong. z is up. Colours in the attribute of binary
 * facets: bit 15 and 5 bits each of red, green and blue, as VisCAM has them; Magics, which writes COLOR=
 * into its header, counts them from the other end. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/memory.h"
#include "image/srgb.h"
#include "importers/files.h"
#include "importers/number.h"
#include "importers/surfaces.h"

enum { HEADER_SIZE = 80, FACET_SIZE = 50, SOLIDS_MAX = 1000000 };

typedef struct stl {
    const char *path, *text, *at, *end; /* *end is 0 */
    const char *said;                   /* how far one has been told */
    const import_options *options;
    description *d;
    name_set names;
    uint32_t material;
    size_t mesh_count;
    /* of the solid that is being read */
    char name[NAME_MAX_SIZE];
    snell_vec3 *positions;
    size_t position_count, position_capacity;
    polygons facets;
} stl;

static snell_status wrong(const stl *s, const char *at, const char *what) {
    return error_set_at(SNELL_ERR_SYNTAX, text_place(s->path, s->text, at), NULL, "STL: %s", what);
}

static void say_progress(stl *s) {
    if (s->at - s->said < 1 << 20) return;
    s->said = s->at;
    import_forget(s->text, (size_t)(s->end - s->text), s->at);
    if (s->options->progress)
        s->options->progress(s->options->progress_user,
                             (double)(s->at - s->text) / (double)(s->end - s->text));
}

static snell_status add_mesh(stl *s, surfaces *made) {
    s->mesh_count++;
    snell_status status = surfaces_plain(s->d, s->path, 1, &s->material);
    if (!status)
        status =
            surfaces_add(made, s->d, &s->names, s->name, s->material,
                         s->options->up ? s->options->up : "z", (object_source){NULL, s->path, 0});
    surfaces_free(made);
    return status;
}

/* ---- binary ---- */

static uint32_t little_endian(const char *at, int size) {
    uint32_t value = 0;
    for (int i = 0; i < size; i++) value |= (uint32_t)(uint8_t)at[i] << (8 * i);
    return value;
}

static snell_vec3 load_corner(const char *at) {
    uint32_t words[] = {little_endian(at, 4), little_endian(at + 4, 4), little_endian(at + 8, 4)};
    snell_vec3 p;
    memcpy(&p, words, sizeof p);
    return p;
}

static bool is_colored(const char *facet) {
    return little_endian(facet + FACET_SIZE - 2, 2) & 0x8000;
}

/* The colour of one that has none of its own: the header's, or white. */
static snell_vec3 usual_color(const stl *s, bool *reversed) {
    const char *mark = memmem(s->text, HEADER_SIZE - 8, "COLOR=", 6);
    *reversed = mark != NULL;
    if (mark == NULL) return (snell_vec3){1, 1, 1};
    const float *table = srgb_table();
    return (snell_vec3){table[(uint8_t)mark[6]], table[(uint8_t)mark[7]], table[(uint8_t)mark[8]]};
}

static snell_vec3 *read_colors(const stl *s, const char *facets, size_t count) {
    bool reversed;
    snell_vec3 usual = usual_color(s, &reversed);
    snell_vec3 *colors = memory_resize(NULL, 3 * count, sizeof *colors);
    float decoded[32];
    for (int i = 0; i < 32; i++) decoded[i] = srgb_to_linear(i / 31.0);
    for (size_t i = 0; colors && i < count; i++) {
        uint32_t bits = little_endian(facets + i * FACET_SIZE + FACET_SIZE - 2, 2);
        float low = decoded[bits & 31], high = decoded[(bits >> 10) & 31];
        snell_vec3 color = {reversed ? low : high, decoded[(bits >> 5) & 31],
                            reversed ? high : low};
        /* Magics sets bit 15 where the usual colour holds; 0 is no colour either. */
        bool own = reversed ? bits != 0 && !(bits & 0x8000) : (bits & 0x8000) != 0;
        for (size_t k = 0; k < 3; k++) colors[3 * i + k] = own ? color : usual;
    }
    return colors;
}

static snell_status read_binary(stl *s, size_t size) {
    size_t count = little_endian(s->text + HEADER_SIZE, 4), whole = (size - 84) / FACET_SIZE;
    const char *facets = s->text + HEADER_SIZE + 4;
    if (count > whole)
        return error_set_at(SNELL_ERR_SYNTAX, (source_place){s->path, 0, 0},
                            "the file may be cut off, or no STL file",
                            "STL: the file ends after %zu of %zu facets", whole, count);
    if (count == 0)
        return error_set_at(SNELL_ERR_SYNTAX, (source_place){s->path, 0, 0}, NULL,
                            "the file has no surfaces");
    surfaces made = {.vertex_count = 3 * count, .index_count = 3 * count};
    made.positions = memory_aligned(3 * count * sizeof *made.positions);
    made.indices = memory_aligned(3 * count * sizeof *made.indices);
    bool colored = false, failed = made.positions == NULL || made.indices == NULL;
    snell_status status = SNELL_OK;
    for (size_t i = 0; !failed && i < count; i++) {
        const char *facet = facets + i * FACET_SIZE;
        bool finite = true;
        for (size_t k = 0; k < 3; k++) {
            snell_vec3 p = load_corner(facet + 12 + 12 * k);
            finite &= isfinite(p.x) && isfinite(p.y) && isfinite(p.z);
            made.positions[3 * i + k] = p;
            made.indices[3 * i + k] = (uint32_t)(3 * i + k);
        }
        colored |= is_colored(facet);
        if (finite) continue;
        status = error_set_at(SNELL_ERR_SYNTAX, (source_place){s->path, 0, 0}, NULL,
                              "STL: facet %zu of %zu: a coordinate is not a finite number", i + 1,
                              count);
        break;
    }
    bool reversed;
    usual_color(s, &reversed);
    if (!failed && !status && (colored || reversed))
        failed = (made.colors = read_colors(s, facets, count)) == NULL;
    if (!failed && !status && size > 84 + count * FACET_SIZE)
        status = description_add_message(s->d, SNELL_WARNING, s->path, 0, NULL,
                                         "%zu bytes after the last facet are not read",
                                         size - 84 - count * FACET_SIZE);
    if (failed && !status) status = error_no_memory();
    if (!status) return add_mesh(s, &made);
    surfaces_free(&made);
    return status;
}

/* ---- text ---- */

static void skip_space(stl *s) {
    while (*s->at == ' ' || *s->at == '\n' || *s->at == '\r' || *s->at == '\t') s->at++;
}

static void skip_line(stl *s) { s->at += strcspn(s->at, "\r\n"); }

static void skip_word(stl *s) {
    skip_space(s);
    while ((unsigned char)*s->at > ' ') s->at++;
}

/* Is this the next word? Then it is stepped over. */
static bool take(stl *s, const char *word, size_t length) {
    skip_space(s);
    if (strncasecmp(s->at, word, length) != 0 || (unsigned char)s->at[length] > ' ') return false;
    s->at += length;
    return true;
}
#define TAKE(s, word) take(s, word, sizeof(word) - 1)

static snell_status unexpected(const stl *s, const char *wanted) {
    if (s->at >= s->end)
        return error_set_at(SNELL_ERR_SYNTAX, text_place(s->path, s->text, s->end),
                            "the file may be cut off", "STL: the file ends where '%s' should be",
                            wanted);
    int length = 0;
    while (length < 40 && (unsigned char)s->at[length] > ' ') length++;
    return error_set_at(SNELL_ERR_SYNTAX, text_place(s->path, s->text, s->at), NULL,
                        "STL: '%s' should be here, not '%.*s'", wanted, length, s->at);
}

static snell_status read_corner(stl *s) {
    float v[3];
    for (int i = 0; i < 3; i++) {
        skip_space(s);
        const char *rest = number_read(s->at, &v[i]);
        if (rest == NULL || (unsigned char)*rest > ' ') return unexpected(s, "a number");
        if (!isfinite(v[i])) return wrong(s, s->at, "the coordinate is not a finite number");
        s->at = rest;
    }
    if (s->position_count >= UINT32_MAX - 1) return wrong(s, s->at, "too many corners");
    if (!ARRAY_GROW(s->positions, s->position_count, s->position_capacity, 1))
        return error_no_memory();
    s->positions[s->position_count++] = (snell_vec3){v[0], v[1], v[2]};
    return SNELL_OK;
}

/* After "facet": normal x y z, outer loop, vertex x y z (three times), endloop, endfacet. */
static snell_status read_facet(stl *s) {
    size_t first = s->position_count;
    bool outer = TAKE(s, "outer");
    for (int i = 0; i < 4 && !outer; i++) { /* normal x y z, whatever they are */
        skip_word(s);
        outer = TAKE(s, "outer");
    }
    if (!outer) return unexpected(s, "outer loop");
    if (!TAKE(s, "loop")) return unexpected(s, "loop");
    const char *start = s->at;
    while (TAKE(s, "vertex")) {
        snell_status status = read_corner(s);
        if (status) return status;
    }
    size_t corners = s->position_count - first;
    if (corners < 3)
        return s->at < s->end ? wrong(s, start, "a facet has three corners")
                              : unexpected(s, "vertex");
    if (!TAKE(s, "endloop")) return unexpected(s, "endloop");
    if (!TAKE(s, "endfacet")) return unexpected(s, "endfacet");
    uint32_t *to = polygons_add(&s->facets, (uint32_t)corners);
    if (to == NULL) return error_no_memory();
    for (size_t i = 0; i < corners; i++) to[i] = (uint32_t)(first + i);
    return SNELL_OK;
}

static void read_name(stl *s) {
    while (*s->at == ' ' || *s->at == '\t') s->at++;
    const char *start = s->at;
    skip_line(s);
    const char *end = s->at;
    while (end > start && (unsigned char)end[-1] <= ' ') end--;
    snprintf(s->name, sizeof s->name, "%.*s", (int)(end - start < 200 ? end - start : 200), start);
}

static snell_status end_solid(stl *s) {
    if (s->facets.index_count == 0) return SNELL_OK;
    if (s->mesh_count >= SOLIDS_MAX) return wrong(s, s->at, "too many solids");
    if (!polygons_cut(&s->facets, s->positions)) return error_no_memory();
    surfaces made = {.positions = s->positions,
                     .vertex_count = s->position_count,
                     .indices = s->facets.indices,
                     .index_count = s->facets.index_count};
    s->positions = NULL;
    s->position_count = s->position_capacity = 0;
    s->facets = (polygons){0};
    return add_mesh(s, &made);
}

static snell_status read_text(stl *s) {
    snell_status status = SNELL_OK;
    while (!status && TAKE(s, "solid")) {
        read_name(s);
        for (size_t i = 0; !status && TAKE(s, "facet"); i++) {
            if (i % 1024 == 0) say_progress(s);
            status = read_facet(s);
        }
        if (status) return status;
        if (!TAKE(s, "endsolid")) return unexpected(s, "facet");
        skip_line(s);
        status = end_solid(s);
    }
    skip_space(s);
    if (!status && s->at < s->end) status = unexpected(s, "solid");
    if (!status && s->mesh_count == 0)
        status = error_set_at(SNELL_ERR_SYNTAX, (source_place){s->path, 0, 0}, NULL,
                              "the file has no surfaces");
    return status;
}

/* ---- which of the two ---- */

static bool begins_as_text(const char *text) {
    while (*text == ' ' || *text == '\n' || *text == '\r' || *text == '\t') text++;
    return strncasecmp(text, "solid", 5) == 0 && (unsigned char)text[5] <= ' ';
}

/* Binary files may begin with "solid" too: the size that they say tells, or, in those that are cut off or have more
 * after the facets, a 0 in the header or in the count, of which the last byte is one below 16 million. */
static snell_status read_either(stl *s, size_t size) {
    bool is_text = begins_as_text(s->text) && (size < 84 || !memchr(s->text, 0, 84));
    bool fits =
        size >= 84 && size == 84 + (uint64_t)FACET_SIZE * little_endian(s->text + HEADER_SIZE, 4);
    if (is_text && !fits) return read_text(s);
    if (size >= 84) return read_binary(s, size);
    return size ? unexpected(s, "solid") : error_set(SNELL_ERR_SYNTAX, NULL, "the file is empty");
}

static snell_status stl_read(const char *path, const import_options *options, description *d) {
    size_t size;
    const char *mapped;
    stl s = {.path = path, .options = options, .d = d, .material = NO_MATERIAL};
    snell_status status = import_map_file(path, options, &mapped, &size);
    if (!status) {
        size_t mark = import_mark_size(mapped, size);
        if (!begins_as_text(mapped + mark)) mark = 0;
        s.text = s.at = s.said = mapped + mark;
        s.end = mapped + size;
        status = read_either(&s, size - mark);
        import_unmap_file(mapped, size);
    }
    if (status) error_place((source_place){path, 0, 0});
    names_deinit(&s.names);
    free(s.positions);
    free(s.facets.indices);
    free(s.facets.list);
    snprintf(d->format, sizeof d->format, "stl");
    d->is_model = true;
    return status;
}

static bool stl_recognise(const char *extension, const uint8_t *first, size_t size) {
    bool begins = size >= 6 && memcmp(first, "solid ", 6) == 0;
    return strcmp(extension, ".stl") == 0 || (begins && strcmp(extension, ".lua") != 0);
}

const importer importer_stl = {
    .name = "stl",
    .extensions = ".stl",
    .help = "STL, stereolithography",
    .recognise = stl_recognise,
    .read = stl_read,
};
