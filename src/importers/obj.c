/* OBJ (Wavefront, Advanced Visualizer, appendix B1, 1995): vertices, polygons, objects, groups, smoothing groups,
 * materials. An object (o), or where there is none a group (g), is a mesh of that name; materials choose
 * by triangle, but for those that fill a body or shine, which get meshes of their own. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/memory.h"
#include "image/srgb.h"
#include "importers/files.h"
#include "importers/mtl.h"
#include "importers/number.h"
#include "importers/obj_text.h"
#include "importers/surfaces.h"

enum { NAME_SIZE = 256, CHAIN_MAX = 64, LINE_NAME_MAX = 1024 };

/* One of a mesh: a position with what it was named together with. 0: without; else from 1. */
typedef struct corner {
    uint32_t v, vt, vn;
    uint32_t next; /* another of the same position, from 1 */
} corner;

/* Triangles that follow each other and are alike. */
typedef struct run {
    size_t first, end; /* indices */
    uint32_t object, material, smoothing;
    uint32_t apart; /* 0: with others of its object; else its material, from 1 */
} run;

typedef struct obj {
    const char *path, *text, *at, *end; /* *end is 0 */
    bool mapped;                        /* text is: it was not copied */
    const char *lines;                  /* the same before its lines were joined, for places */
    const import_options *options;
    description *d;
    name_set names;
    mtl *materials;
    snell_vec3 *v, *vn,
        *colors;        /* colors: as the file has them, x NAN: none of its own; NULL: none yet */
    float brightest;    /* of them */
    bool has_fractions; /* some are no whole numbers */
    snell_vec2 *vt;
    uint32_t *newest; /* of each v: a corner, from 1 */
    size_t v_count, vt_count, vn_count, v_total, vt_total, vn_total;
    corner *corners;
    size_t corner_count, corner_capacity;
    uint32_t *face; /* the one that is being read */
    size_t face_capacity;
    polygons faces;
    run *runs;
    size_t run_count, run_capacity;
    run now; /* of the next face */
    bool changed, by_object, has_smoothing, has_lines, names_nothing, library_missing;
    char **objects; /* their names, owned */
    size_t object_count, object_capacity;
    json_t *object_numbers, *material_numbers; /* by name; hash tables */
    const char *short_face;                    /* the first of fewer than three corners */
    char lost[300];
} obj;

/* ---- errors ---- */

static source_place place_of(const obj *o, const char *at) {
    return text_place(o->path, o->lines, o->lines + (at - o->text));
}

static snell_status wrong(const obj *o, const char *at, const char *what) {
    return error_set_at(SNELL_ERR_SYNTAX, place_of(o, at), NULL, "OBJ: %s", what);
}

static uint32_t line_of(const obj *o, const char *at) { return place_of(o, at).line; }

static snell_status wrong_word(const obj *o, const char *at, const char *what) {
    int length = 0;
    while (length < 40 && (unsigned char)at[length] > ' ') length++;
    if (length == 0) return wrong(o, at, "the line ends where a number should be");
    return error_set_at(SNELL_ERR_SYNTAX, place_of(o, at), NULL, "OBJ: '%.*s' is no %s", length, at,
                        what);
}

/* ---- lines and words ---- */

static inline void skip_blanks(obj *o) {
    while (*o->at == ' ' || *o->at == '\t') o->at++;
}

static inline void skip_line(obj *o) {
    const char *stop = memchr(o->at, '\n', (size_t)(o->end - o->at));
    o->at = stop ? stop + 1 : o->end;
}

/* What is left of the line, without blanks around it. */
static void rest_of_line(obj *o, char *out, size_t size) {
    skip_blanks(o);
    const char *end = memchr(o->at, '\n', (size_t)(o->end - o->at));
    if (end == NULL) end = o->end;
    while (end > o->at && (unsigned char)end[-1] <= ' ') end--;
    size_t length = (size_t)(end - o->at);
    if (length >= size) length = size - 1;
    memcpy(out, o->at, length);
    out[length] = 0;
}

static inline bool ends_word(char c) { return (unsigned char)c <= ' '; }

/* 3.1+e2, which some write for 3.1e+2; the rest of the word, or NULL. */
static const char *odd_exponent(const char *rest, float *value) {
    int64_t power;
    if ((*rest != '+' && *rest != '-') || (rest[1] | 32) != 'e') return NULL;
    const char *end = number_read_integer(rest + 2, &power);
    if (end == NULL || !ends_word(*end) || power < 0 || power > 99) return NULL;
    char text[64];
    snprintf(text, sizeof text, "%.9ge%c%d", (double)*value, *rest, (int)power);
    return number_read(text, value) ? end : NULL;
}

/* A finite number. */
static inline snell_status read_number(obj *o, float *out) {
    skip_blanks(o);
    const char *rest = number_read(o->at, out);
    if (rest && !ends_word(*rest)) rest = odd_exponent(rest, out);
    if (rest == NULL || !isfinite(*out)) return wrong_word(o, o->at, "finite number");
    o->at = rest;
    return SNELL_OK;
}

/* Is there one more number on this line? */
static inline bool more_numbers(obj *o) {
    skip_blanks(o);
    return number_is_digit(*o->at) || *o->at == '-' || *o->at == '+' || *o->at == '.';
}

/* Of normals and texture coordinates, what is not finite is 0: exporters write it where there is nothing. */
static snell_status read_loose(obj *o, float *out) {
    skip_blanks(o);
    const char *rest = number_read(o->at, out);
    if (rest == NULL || !isfinite(*out)) *out = 0;
    if (rest == NULL && ends_word(*o->at)) return wrong_word(o, o->at, "number");
    if (rest == NULL) {
        const char *word = o->at + (*o->at == '-' || *o->at == '+');
        if (strncasecmp(word, "nan", 3) != 0 && strncasecmp(word, "inf", 3) != 0)
            return wrong_word(o, o->at, "number");
    }
    while (!ends_word(*o->at)) o->at++;
    return SNELL_OK;
}

/* ---- vertices ---- */

static snell_status set_color(obj *o, const float rgb[3]) {
    if (o->colors == NULL) {
        o->colors = memory_resize(NULL, o->v_total, sizeof *o->colors);
        if (o->colors == NULL) return error_no_memory();
        for (size_t i = 0; i < o->v_total; i++) o->colors[i] = (snell_vec3){NAN, 0, 0};
    }
    o->colors[o->v_count] = (snell_vec3){rgb[0], rgb[1], rgb[2]};
    for (int i = 0; i < 3; i++) {
        if (rgb[i] > o->brightest) o->brightest = rgb[i];
        o->has_fractions |= (double)rgb[i] != floor((double)rgb[i]);
    }
    return SNELL_OK;
}

/* To linear colours. Those that reach beyond 1 are bytes if all are whole numbers. */
static snell_status convert_colors(obj *o) {
    bool beyond = o->brightest > 1, bytes = beyond && o->brightest <= 255 && !o->has_fractions;
    double scale = bytes ? 1 / 255.0 : 1;
    for (size_t i = 0; o->colors && i < o->v_total; i++) {
        const snell_vec3 c = o->colors[i];
        o->colors[i] = isnan(c.x) ? (snell_vec3){1, 1, 1}
                                  : (snell_vec3){srgb_to_linear((double)c.x * scale),
                                                 srgb_to_linear((double)c.y * scale),
                                                 srgb_to_linear((double)c.z * scale)};
    }
    if (bytes)
        return description_add_message(o->d, SNELL_INFO, o->path, 0, NULL,
                                       "colours of vertices are taken as bytes, 0 to 255");
    return beyond ? description_add_message(
                        o->d, SNELL_WARNING, o->path, 0, NULL,
                        "colours of vertices reach %g: what is beyond 1 counts as 1",
                        (double)o->brightest)
                  : SNELL_OK;
}

/* v x y z, then w, or r g b, or w r g b. w is for rational curves. */
static snell_status read_position(obj *o) {
    float p[3], more[4];
    int count = 0;
    for (int i = 0; i < 3; i++) {
        snell_status status = read_number(o, &p[i]);
        if (status) return status;
    }
    while (count < 4 && more_numbers(o)) {
        snell_status status = read_number(o, &more[count++]);
        if (status) return status;
    }
    snell_status status = count >= 3 ? set_color(o, more + count - 3) : SNELL_OK;
    o->v[o->v_count++] = (snell_vec3){p[0], p[1], p[2]};
    return status;
}

static snell_status read_coordinates(obj *o) {
    float p[2] = {0, 0};
    snell_status status = read_loose(o, &p[0]);
    if (!status && more_numbers(o)) status = read_loose(o, &p[1]);
    o->vt[o->vt_count++] = (snell_vec2){p[0], p[1]};
    return status;
}

static snell_status read_normal(obj *o) {
    float p[3];
    for (int i = 0; i < 3; i++) {
        snell_status status = read_loose(o, &p[i]);
        if (status) return status;
    }
    o->vn[o->vn_count++] = (snell_vec3){p[0], p[1], p[2]};
    return SNELL_OK;
}

/* ---- faces ---- */

static uint32_t find_corner(obj *o, uint32_t v, uint32_t vt, uint32_t vn) {
    int steps = 0; /* with too many a vertex is made twice, which does no harm */
    for (uint32_t i = o->newest[v]; i && steps < CHAIN_MAX; i = o->corners[i - 1].next, steps++)
        if (o->corners[i - 1].vt == vt && o->corners[i - 1].vn == vn) return i - 1;
    if (o->corner_count >= UINT32_MAX - 1 ||
        !ARRAY_GROW(o->corners, o->corner_count, o->corner_capacity, 1))
        return UINT32_MAX;
    o->corners[o->corner_count++] = (corner){v, vt, vn, o->newest[v]};
    o->newest[v] = (uint32_t)o->corner_count;
    return (uint32_t)o->corner_count - 1;
}

/* From 1; -1 is the last one before this line. `total`: with those that are still to come. */
static inline snell_status read_index(obj *o, const char *what, size_t count, size_t total,
                                      uint32_t *out) {
    int64_t index;
    const char *rest = number_read_integer(o->at, &index);
    if (rest == NULL || (*rest != '/' && !ends_word(*rest)))
        return wrong_word(o, o->at, "corner of a face");
    int64_t found = index > 0 ? index : (int64_t)count + index + 1;
    if (index == 0 || found < 1 || found > (int64_t)total) {
        char text[128];
        if (index == 0)
            snprintf(text, sizeof text, "%s 0: they count from 1", what);
        else
            snprintf(text, sizeof text, "%s %lld: there are %zu", what, (long long)index,
                     index > 0 ? total : count);
        return wrong(o, o->at, text);
    }
    o->at = rest;
    *out = (uint32_t)found;
    return SNELL_OK;
}

/* A file without any: some exporters name them all the same. */
static snell_status read_named(obj *o, const char *what, size_t count, size_t total,
                               uint32_t *out) {
    if (total > 0) return read_index(o, what, count, total, out);
    while (*o->at != '/' && !ends_word(*o->at)) o->at++;
    o->names_nothing = true;
    return SNELL_OK;
}

/* v, v/vt, v//vn, v/vt/vn */
static snell_status read_corner(obj *o, uint32_t *out) {
    uint32_t v = 0, vt = 0, vn = 0;
    snell_status status = read_index(o, "vertex", o->v_count, o->v_total, &v);
    if (!status && *o->at == '/') {
        o->at++;
        if (*o->at != '/' && !ends_word(*o->at))
            status = read_named(o, "texture coordinate", o->vt_count, o->vt_total, &vt);
        if (!status && *o->at == '/') {
            o->at++;
            if (!ends_word(*o->at)) status = read_named(o, "normal", o->vn_count, o->vn_total, &vn);
        }
    }
    if (status) return status;
    if (!ends_word(*o->at)) return wrong_word(o, o->at, "corner of a face");
    *out = find_corner(o, v - 1, vt, vn);
    return *out == UINT32_MAX ? error_no_memory() : SNELL_OK;
}

static bool note_run(obj *o) {
    o->changed = false;
    if (o->run_count > 0) {
        const run *last = &o->runs[o->run_count - 1];
        if (last->object == o->now.object && last->material == o->now.material &&
            last->smoothing == o->now.smoothing)
            return true;
    }
    if (!ARRAY_GROW(o->runs, o->run_count, o->run_capacity, 1)) return false;
    o->now.first = o->faces.index_count;
    o->runs[o->run_count++] = o->now;
    return true;
}

static snell_status read_face(obj *o) {
    const char *start = o->at;
    size_t count = 0;
    for (;;) {
        skip_blanks(o);
        if (*o->at == '\n' || *o->at == '\r' || *o->at == '#' || o->at == o->end) break;
        if (!ARRAY_GROW(o->face, count, o->face_capacity, 1)) return error_no_memory();
        snell_status status = read_corner(o, &o->face[count++]);
        if (status) return status;
    }
    if (count < 3) {
        if (o->short_face == NULL) o->short_face = start;
        return SNELL_OK;
    }
    if (count > UINT32_MAX / 4) return wrong(o, start, "a face of too many corners");
    if (o->changed && !note_run(o)) return error_no_memory();
    uint32_t *to = polygons_add(&o->faces, (uint32_t)count);
    if (to == NULL) return error_no_memory();
    memcpy(to, o->face, count * sizeof *to);
    return SNELL_OK;
}

/* ---- objects, materials, smoothing ---- */

/* The number that a name has in a table, `otherwise` where it has none. Names that are no UTF-8 may meet. */
static bool number_of(json_t *table, const char *name, uint32_t otherwise, uint32_t *out) {
    char key[NAME_SIZE];
    snprintf(key, sizeof key, "%.*s", NAME_SIZE - 1, name);
    json_t *probe = json_string(key);
    for (char *c = key; probe == NULL && *c; c++)
        if ((unsigned char)*c >= 128) *c = '?';
    json_decref(probe);
    const json_t *known = json_object_get(table, key);
    *out = known ? (uint32_t)json_integer_value(known) : otherwise;
    return known || json_object_set_new(table, key, json_integer(otherwise)) == 0;
}

/* Objects of one name are one, also where others stand between. */
static snell_status add_object(obj *o, const char *name) {
    uint32_t number;
    if (!number_of(o->object_numbers, name, (uint32_t)o->object_count, &number))
        return error_no_memory();
    if (number == o->object_count) {
        if (!ARRAY_GROW(o->objects, o->object_count, o->object_capacity, 1))
            return error_no_memory();
        char *copy = memory_copy_string(name);
        if (copy == NULL) return error_no_memory();
        o->objects[o->object_count++] = copy;
    }
    o->now.object = number;
    o->changed = true;
    return SNELL_OK;
}

static snell_status begin_object(obj *o) {
    char name[NAME_SIZE];
    rest_of_line(o, name, sizeof name);
    return add_object(o, name);
}

/* Without a comment after it, or the quotes around it: for names that are not found, as they may have both of
 * their own. false: it has neither. */
static bool unwrap(char *name) {
    char *comment = strstr(name, " #"), *end = comment ? comment : name + strlen(name);
    while (end > name && end[-1] == ' ') end--;
    bool quoted = end - name > 2 && name[0] == '"' && end[-1] == '"';
    if (quoted) memmove(name, name + 1, (size_t)(end - name) - 2), end -= 2;
    *end = 0;
    return comment || quoted;
}

static snell_status use_material(obj *o) {
    char name[NAME_SIZE];
    const char *at = o->at;
    rest_of_line(o, name, sizeof name);
    uint32_t found = mtl_find(o->materials, name);
    if (found == MTL_NONE && unwrap(name)) found = mtl_find(o->materials, name);
    o->changed = true;
    o->now.material = found;
    if (found != MTL_NONE || o->library_missing || name[0] == 0) return SNELL_OK;
    uint32_t times;
    if (!number_of(o->material_numbers, name, 0, &times)) return error_no_memory();
    if (json_object_size(o->material_numbers) > 8) return SNELL_OK;
    return description_add_message(o->d, SNELL_WARNING, o->path, line_of(o, at), NULL,
                                   "material '%.100s' is in no library: it is grey", name);
}

/* The line is one name with blanks in it, or several names. */
static snell_status use_libraries(obj *o) {
    char line[LINE_NAME_MAX], missing[LINE_NAME_MAX] = "";
    const char *at = o->at;
    rest_of_line(o, line, sizeof line);
    snell_status status = mtl_read(o->materials, line);
    if (status == SNELL_ERR_IO && unwrap(line)) status = mtl_read(o->materials, line);
    if (status != SNELL_ERR_IO) return status;
    char first[300], *rest = line;
    snprintf(first, sizeof first, "%s", error_last()->text);
    bool several = strpbrk(line, " \t") != NULL;
    for (char *word; several && (word = strtok_r(rest, " \t", &rest)) != NULL;) {
        status = mtl_read(o->materials, word);
        if (status && status != SNELL_ERR_IO) return status;
        if (status && !missing[0]) snprintf(missing, sizeof missing, "%.290s", error_last()->text);
    }
    if (several && !missing[0]) return SNELL_OK;
    bool said = o->library_missing;
    o->library_missing = true;
    if (said) return SNELL_OK;
    return description_add_message(o->d, SNELL_WARNING, o->path, line_of(o, at), NULL,
                                   "%s; its materials are grey", several ? missing : first);
}

/* s off, s 0, s N */
static snell_status set_smoothing(obj *o) {
    int64_t group;
    skip_blanks(o);
    o->has_smoothing = o->changed = true;
    if (number_read_integer(o->at, &group) == NULL) group = strncasecmp(o->at, "on", 2) == 0;
    o->now.smoothing = group > 0 ? (uint32_t)(group % 0x7fffffff) + 2 : SURFACES_FLAT;
    return SNELL_OK;
}

/* ---- statements ---- */

static void note_lost(obj *o, const char *word) {
    char item[48];
    int length = 0;
    while (length < 24 && (unsigned char)word[length] > ' ' && (unsigned char)word[length] < 127)
        length++;
    snprintf(item, sizeof item, ", %.*s", length ? length : 1, length ? word : "?");
    if (strstr(o->lost, item)) return;
    size_t used = strlen(o->lost);
    if (used + strlen(item) < sizeof o->lost) memcpy(o->lost + used, item, strlen(item) + 1);
}

static bool take_word(obj *o, const char *word) {
    size_t length = strlen(word);
    if (strncmp(o->at, word, length) != 0 || !ends_word(o->at[length])) return false;
    o->at += length;
    return true;
}

static snell_status read_other(obj *o) {
    if (take_word(o, "usemtl")) return use_material(o);
    if (take_word(o, "s")) return set_smoothing(o);
    if (take_word(o, "mtllib")) return SNELL_OK; /* read before */
    if ((*o->at == 'o' || *o->at == 'g') && ends_word(o->at[1])) {
        bool is_object = *o->at++ == 'o';
        return is_object == o->by_object ? begin_object(o) : SNELL_OK;
    }
    if ((*o->at == 'p' || *o->at == 'l') && ends_word(o->at[1]))
        o->has_lines = true;
    else
        note_lost(o, o->at);
    return SNELL_OK;
}

static snell_status read_statement(obj *o) {
    skip_blanks(o);
    const char *at = o->at;
    if (*at == 'v') {
        bool other = !ends_word(at[1]);
        if (!other || ends_word(at[2])) {
            o->at += 1 + other;
            if (!other) return read_position(o);
            if (at[1] == 't') return read_coordinates(o);
            if (at[1] == 'n') return read_normal(o);
            o->at = at;
        }
    } else if (*at == 'f' && ends_word(at[1])) {
        o->at++;
        return read_face(o);
    }
    if (*at == '#' || *at == '\n' || *at == '\r' || *at == 0) return SNELL_OK;
    return read_other(o);
}

static void forget(const obj *o, const char *upto) {
    if (o->mapped) import_forget(o->text, (size_t)(o->end - o->text), upto);
}

static snell_status read_text(obj *o) {
    for (size_t line = 0; o->at < o->end; line++) {
        if (line % 65536 == 0) {
            forget(o, o->at);
            if (o->options->progress)
                o->options->progress(o->options->progress_user,
                                     (double)(o->at - o->text) / (double)(o->end - o->text));
        }
        snell_status status = read_statement(o);
        if (status) return status;
        skip_line(o);
    }
    return SNELL_OK;
}

/* How many there will be of each, so that arrays are made once, whether there are objects, and the libraries: so
 * that faces may name what comes later. */
static snell_status look_ahead(obj *o) {
    for (size_t line = 0; o->at < o->end; line++) {
        if (line % 65536 == 0) forget(o, o->at);
        skip_blanks(o);
        const char *at = o->at;
        if (*at == 'v') {
            o->v_total += ends_word(at[1]);
            o->vt_total += at[1] == 't' && ends_word(at[2]);
            o->vn_total += at[1] == 'n' && ends_word(at[2]);
        } else if (*at == 'o' && ends_word(at[1])) {
            o->by_object = true;
        } else if (*at == 'm' && take_word(o, "mtllib")) {
            snell_status status = use_libraries(o);
            if (status) return status;
        }
        skip_line(o);
    }
    forget(o, o->at);
    o->at = o->text;
    return SNELL_OK;
}

static bool make_arrays(obj *o) {
    o->v = memory_aligned(o->v_total * sizeof *o->v);
    o->vt = memory_aligned(o->vt_total * sizeof *o->vt);
    o->vn = memory_aligned(o->vn_total * sizeof *o->vn);
    o->newest = memory_zeroed(o->v_total, sizeof *o->newest);
    return o->v_total < UINT32_MAX && o->vt_total < UINT32_MAX && o->vn_total < UINT32_MAX &&
           o->v && o->vt && o->vn && o->newest;
}

/* ---- meshes ---- */

/* Runs of one mesh together, in their order. */
static int compare_runs(const void *a, const void *b) {
    const run *x = a, *y = b;
    if (x->object != y->object) return x->object < y->object ? -1 : 1;
    if (x->apart != y->apart) return x->apart < y->apart ? -1 : 1;
    return x->first < y->first ? -1 : x->first > y->first;
}

/* The corners of one mesh become its vertices. local: of each corner its vertex, from 1; all 0, and so again
 * afterwards. */
typedef struct builder {
    obj *o;
    uint32_t *local, *used; /* used: corners, in the order of their vertices */
    size_t used_capacity;
    surfaces out;
    uint8_t *lacks;
    uint32_t *groups;
    uint32_t *slot_of, grey;
    double size;
    bool single; /* one mesh is all: what was read is freed or taken while it is made */
} builder;

static bool gather_indices(builder *b, const run *runs, size_t count) {
    uint32_t *from = b->o->faces.indices;
    size_t total = 0;
    for (size_t i = 0; i < count; i++) total += runs[i].end - runs[i].first;
    b->single = total == b->o->faces.index_count;
    b->out.indices = b->single ? from : memory_aligned(total * sizeof *b->out.indices);
    if (b->single) b->o->faces.indices = NULL;
    if (b->out.indices == NULL) return false;
    for (size_t i = 0; i < count; i++)
        for (size_t k = runs[i].first; k < runs[i].end; k++) {
            uint32_t *vertex = &b->local[from[k]];
            if (*vertex == 0) {
                if (!ARRAY_GROW(b->used, b->out.vertex_count, b->used_capacity, 1)) return false;
                b->used[b->out.vertex_count++] = from[k];
                *vertex = (uint32_t)b->out.vertex_count;
            }
            b->out.indices[b->out.index_count++] = *vertex - 1;
        }
    for (size_t i = 0; i < b->out.vertex_count; i++) b->local[b->used[i]] = 0;
    return true;
}

static void release(snell_vec3 **array) {
    free(*array);
    *array = NULL;
}

static bool gather_vertices(builder *b, bool *has_lacking) {
    obj *o = b->o;
    size_t count = b->out.vertex_count, with_vt = 0, with_vn = 0;
    for (size_t i = 0; i < count; i++) {
        with_vt += o->corners[b->used[i]].vt != 0;
        with_vn += o->corners[b->used[i]].vn != 0;
    }
    *has_lacking = with_vn < count;
    const corner *corners = o->corners;
    const uint32_t *used = b->used;
    if ((b->out.positions = memory_aligned(count * sizeof(snell_vec3))) == NULL) return false;
    for (size_t i = 0; i < count; i++) b->out.positions[i] = o->v[corners[used[i]].v];
    if (b->single) release(&o->v);
    if (with_vn) {
        b->out.normals = memory_aligned(count * sizeof(snell_vec3));
        if (*has_lacking) b->lacks = memory_resize(NULL, count, 1);
        if (b->out.normals == NULL || (*has_lacking && b->lacks == NULL)) return false;
        for (size_t i = 0; i < count; i++) {
            uint32_t vn = corners[used[i]].vn;
            b->out.normals[i] = vn ? o->vn[vn - 1] : (snell_vec3){0, 0, 0};
            if (b->lacks) b->lacks[i] = vn == 0;
        }
    }
    if (b->single) release(&o->vn);
    if (with_vt) {
        if ((b->out.uvs = memory_aligned(count * sizeof(snell_vec2))) == NULL) return false;
        for (size_t i = 0; i < count; i++) {
            uint32_t vt = corners[used[i]].vt;
            b->out.uvs[i] = vt ? o->vt[vt - 1] : (snell_vec2){0, 0};
        }
    }
    if (o->colors) {
        if ((b->out.colors = memory_aligned(count * sizeof(snell_vec3))) == NULL) return false;
        for (size_t i = 0; i < count; i++) b->out.colors[i] = o->colors[corners[used[i]].v];
    }
    return true;
}

/* Of the only mesh, all that its vertices were gathered from. */
static void release_read(builder *b) {
    obj *o = b->o;
    free(o->vt), free(o->corners), free(o->colors), free(b->local), free(b->used);
    o->vt = NULL, o->corners = NULL, o->colors = NULL, b->local = b->used = NULL;
}

static bool gather_groups(builder *b, const run *runs, size_t count) {
    if (!b->o->has_smoothing) return true;
    b->groups = memory_resize(NULL, b->out.index_count / 3, sizeof *b->groups);
    size_t used = 0;
    for (size_t i = 0; b->groups && i < count; i++)
        for (size_t k = runs[i].first; k < runs[i].end; k += 3)
            b->groups[used++] = runs[i].smoothing;
    return b->groups != NULL;
}

/* Grey, for what has none: made when first needed. */
static snell_status make_material(builder *b, uint32_t material, uint32_t *out) {
    if (material != MTL_NONE) return mtl_make(b->o->materials, material, b->size, out);
    snell_status status = surfaces_plain(b->o->d, b->o->path, 0.6f, &b->grey);
    *out = b->grey;
    return status;
}

/* One material for all, or a slot for each triangle. slot_of: of each material of the libraries, and of none, last, its
 * slot, from 1; all 0, and so again afterwards. */
static snell_status gather_materials(builder *b, const run *runs, size_t count,
                                     uint32_t *material) {
    obj *o = b->o;
    bool alike = true;
    for (size_t i = 1; i < count; i++) alike &= runs[i].material == runs[0].material;
    *material = NO_MATERIAL;
    if (alike) return make_material(b, runs[0].material, material);
    surfaces *out = &b->out;
    size_t capacity = 0, used = 0;
    snell_status status = SNELL_OK;
    out->slots = memory_aligned(out->index_count / 3 * sizeof *out->slots);
    if (out->slots == NULL) return error_no_memory();
    for (size_t i = 0; i < count && !status; i++) {
        uint32_t of = runs[i].material, index;
        uint32_t *slot = &b->slot_of[of == MTL_NONE ? mtl_count(o->materials) : of];
        if (*slot == 0) {
            status = make_material(b, of, &index);
            if (status) break;
            if (!ARRAY_GROW(out->materials, out->material_count, capacity, 1)) {
                status = error_no_memory();
                break;
            }
            out->materials[out->material_count++] = (snell_material_id){index + 1, 0};
            *slot = (uint32_t)out->material_count;
        }
        for (size_t k = runs[i].first; k < runs[i].end; k += 3) out->slots[used++] = *slot - 1;
    }
    for (size_t i = 0; i < count; i++)
        b->slot_of[runs[i].material == MTL_NONE ? mtl_count(o->materials) : runs[i].material] = 0;
    return status;
}

static snell_status build_mesh(builder *b, const run *runs, size_t count) {
    obj *o = b->o;
    bool lacking = false;
    uint32_t material;
    snell_status status = SNELL_OK;
    if (!gather_indices(b, runs, count) || !gather_vertices(b, &lacking) ||
        (lacking && !gather_groups(b, runs, count)))
        status = error_no_memory();
    if (b->single) release_read(b);
    if (!status) status = gather_materials(b, runs, count, &material);
    if (!status && lacking && (b->out.normals || !o->options->flat))
        status = surfaces_smooth(&b->out, b->lacks, b->groups);
    if (!status)
        status = surfaces_add(&b->out, o->d, &o->names, o->objects[runs[0].object], material,
                              o->options->up, (object_source){NULL, o->path, 0});
    surfaces_free(&b->out);
    free(b->lacks);
    free(b->groups);
    b->lacks = NULL;
    b->groups = NULL;
    return status;
}

static snell_status build_meshes(builder *b) {
    obj *o = b->o;
    snell_status status = SNELL_OK;
    b->local = memory_zeroed(o->corner_count, sizeof *b->local);
    b->slot_of = memory_zeroed(mtl_count(o->materials) + 1, sizeof *b->slot_of);
    if (b->local == NULL || b->slot_of == NULL) return error_no_memory();
    for (size_t i = 0; i < o->run_count; i++) {
        run *r = &o->runs[i];
        r->end = i + 1 < o->run_count ? o->runs[i + 1].first : o->faces.index_count;
        r->apart = r->material != MTL_NONE && mtl_is_apart(o->materials, r->material)
                       ? r->material + 1
                       : 0;
    }
    qsort(o->runs, o->run_count, sizeof *o->runs, compare_runs);
    for (size_t i = 0, next; i < o->run_count && !status; i = next) {
        for (next = i + 1; next < o->run_count && o->runs[next].object == o->runs[i].object &&
                           o->runs[next].apart == o->runs[i].apart;)
            next++;
        status = build_mesh(b, o->runs + i, next - i);
    }
    return status;
}

static bool cut_polygons(obj *o) {
    if (o->faces.count == 0) return true;
    snell_vec3 *places = memory_aligned(o->corner_count * sizeof *places);
    if (places == NULL) return false;
    for (size_t i = 0; i < o->corner_count; i++) places[i] = o->v[o->corners[i].v];
    bool done = polygons_cut(&o->faces, places);
    free(places);
    return done;
}

static snell_status warn(const obj *o, uint32_t line, const char *text) {
    return description_add_message(o->d, SNELL_WARNING, o->path, line, NULL, "%s", text);
}

static snell_status warn_of_losses(obj *o) {
    snell_status status = mtl_warn_of_losses(o->materials);
    if (!status && o->short_face)
        status =
            warn(o, line_of(o, o->short_face), "faces with fewer than three corners are not drawn");
    if (!status && o->names_nothing)
        status =
            warn(o, 0, "faces name normals or texture coordinates, of which the file has none");
    if (!status && o->has_lines) status = warn(o, 0, "points and lines are not drawn");
    if (!status && o->lost[0])
        status = description_add_message(o->d, SNELL_WARNING, o->path, 0, NULL, "not used: %s",
                                         o->lost + 2);
    return status;
}

static snell_status build(obj *o) {
    if (o->faces.index_count == 0)
        return error_set_at(SNELL_ERR_SYNTAX, (source_place){o->path, 0, 0},
                            o->has_lines      ? NULL
                            : o->v_count != 0 ? "the file may be cut off"
                                              : "it may be no OBJ file",
                            "the file has no surfaces%s",
                            o->has_lines      ? ", only points or lines"
                            : o->v_count != 0 ? ", only vertices"
                                              : "");
    if (!cut_polygons(o)) return error_no_memory();
    builder b = {.o = o, .grey = NO_MATERIAL};
    bounds3 box = bounds3_empty();
    for (size_t i = 0; i < o->v_count; i++) box = bounds3_add_point(box, o->v[i]);
    b.size = dvec3_length(dvec3_sub(dvec3_from(box.max), dvec3_from(box.min)));
    snell_status status = build_meshes(&b);
    free(b.local);
    free(b.used);
    free(b.slot_of);
    return status ? status : warn_of_losses(o);
}

/* ---- the whole ---- */

static snell_status read_prepared(obj *o, const obj_text *text, const char *mapped) {
    o->text = o->at = text->begin;
    o->end = text->begin + text->size;
    o->lines = text->lines;
    o->mapped = text->begin == mapped;
    o->object_numbers = json_object();
    o->material_numbers = json_object();
    if (o->object_numbers == NULL || o->material_numbers == NULL) return error_no_memory();
    o->now = (run){.material = MTL_NONE, .smoothing = SURFACES_BY_ANGLE};
    snell_status status = mtl_create(o->path, o->options, o->d, &o->names, &o->materials);
    if (!status) status = add_object(o, "");
    if (!status) status = look_ahead(o);
    if (!status && !make_arrays(o)) status = error_no_memory();
    if (!status) status = read_text(o);
    free(o->newest);
    o->newest = NULL;
    if (!status) status = convert_colors(o);
    return status ? status : build(o);
}

static void obj_deinit(obj *o) {
    free(o->v);
    free(o->vn);
    free(o->vt);
    free(o->colors);
    free(o->newest);
    free(o->corners);
    free(o->face);
    free(o->faces.indices);
    free(o->faces.list);
    free(o->runs);
    for (size_t i = 0; i < o->object_count; i++) free(o->objects[i]);
    free(o->objects);
    json_decref(o->object_numbers);
    json_decref(o->material_numbers);
    mtl_destroy(o->materials);
    names_deinit(&o->names);
}

static snell_status obj_read(const char *path, const import_options *options, description *d) {
    size_t mapped_size;
    const char *mapped;
    obj_text text = {0};
    obj o = {.path = path, .options = options, .d = d};
    snell_status status = import_map_file(path, options, &mapped, &mapped_size);
    if (!status) {
        if (mapped_size == 0)
            status = error_set(SNELL_ERR_SYNTAX, NULL, "the file is empty");
        else
            status = obj_text_prepare(mapped, mapped_size, &text) ? read_prepared(&o, &text, mapped)
                                                                  : error_no_memory();
        import_unmap_file(mapped, mapped_size);
    }
    if (status) error_place((source_place){path, 0, 0});
    obj_deinit(&o);
    free(text.copy);
    snprintf(d->format, sizeof d->format, "obj");
    d->is_model = true;
    return status;
}

static bool obj_recognise(const char *extension, const uint8_t *first, size_t size) {
    if (strcmp(extension, ".obj") == 0) return true;
    /* NFF has lines that begin with f and v, too; what nff.c leaves is libassimp's. */
    bool another = strcmp(extension, ".lua") == 0 || strcmp(extension, ".nff") == 0;
    return !another && obj_text_is_likely(first, size);
}

const importer importer_obj = {
    .name = "obj",
    .extensions = ".obj",
    .help = "OBJ, with its MTL",
    .recognise = obj_recognise,
    .read = obj_read,
};
