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
#include "importers/ply_header.h"
#include "importers/seams.h"

typedef struct ply {
    const char *path, *text, *at, *end; /* *end is 0 */
    const import_options *options;
    description *d;
    ply_header head;
    surfaces out;
    polygons faces;
    seams seams;
    float *row_uvs; /* of the face that is being read */
    size_t row_uv_count, row_uv_capacity;
    bool see_through, lacks_corners;
} ply;

/* ---- errors ---- */

/* Binary rows have no lines. */
static source_place place_of(const ply *p, const char *at) {
    return p->head.ascii ? text_place(p->path, p->text, at) : (source_place){p->path, 0, 0};
}

static snell_status bad_row(const ply *p, const char *at, const element *e, uint64_t row,
                            const char *what) {
    return error_set_at(SNELL_ERR_SYNTAX, place_of(p, at), NULL, "PLY: %s %llu of %llu: %s",
                        e->name, (unsigned long long)row + 1, (unsigned long long)e->count, what);
}

static snell_status ends_early(const ply *p, const element *e, uint64_t row) {
    return error_set_at(SNELL_ERR_SYNTAX, place_of(p, p->end), "the file may be cut off",
                        "PLY: the file ends before %s %llu of %llu is whole", e->name,
                        (unsigned long long)row + 1, (unsigned long long)e->count);
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
    size_t size = ply_sizes[type];
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

/* Rows of one property of an element without lists, from the first-th on. */
static void read_column(ply *p, const property *q, const char *at, size_t stride, uint64_t first,
                        uint64_t count) {
    size_t step = q->step;
    float *to = q->to ? q->to + first * step : NULL;
    if (q->type == F32 && !p->head.swapped && to && q->role < COLOR) {
        for (uint64_t i = 0; i < count; i++, at += stride, to += step) memcpy(to, at, sizeof *to);
    } else if (q->type == U8 && to && q->role >= COLOR && q->role < UV) {
        const float *table = srgb_table();
        for (uint64_t i = 0; i < count; i++, at += stride, to += step) *to = table[(uint8_t)*at];
    } else if (to) {
        for (uint64_t i = 0; i < count; i++, at += stride, to += step)
            *to = convert(q, load(at, q->type, p->head.swapped));
    } else if (q->role == ALPHA) {
        for (uint64_t i = 0; i < count; i++, at += stride)
            note_alpha(p, q, load(at, q->type, p->head.swapped));
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
    char what[PLY_WORD_MAX + 32];
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
    if (p->head.ascii) return read_text_integer(p, e, row, out);
    if ((size_t)(p->end - p->at) < ply_sizes[type]) return ends_early(p, e, row);
    *out = (int64_t)load(p->at, type, p->head.swapped);
    p->at += ply_sizes[type];
    return SNELL_OK;
}

static snell_status skip_list(ply *p, const element *e, uint64_t row, const property *q) {
    int64_t count = 0;
    float unused;
    snell_status status = read_integer(p, e, row, q->count_type, &count);
    if (status) return status;
    if (count < 0) return bad_row(p, p->at, e, row, "a list of negative length");
    if (!p->head.ascii) {
        if ((uint64_t)count > (uint64_t)(p->end - p->at) / ply_sizes[q->type])
            return ends_early(p, e, row);
        p->at += (size_t)count * ply_sizes[q->type];
    }
    for (int64_t i = 0; p->head.ascii && i < count && !status; i++)
        status = read_text_number(p, e, row, &unused);
    return status;
}

static snell_status read_single(ply *p, const element *e, uint64_t row, const property *q) {
    float value = 0;
    if (p->head.ascii) {
        snell_status status = read_text_number(p, e, row, &value);
        if (status) return status;
        if (!isfinite(value) && q->role < NORMAL)
            return bad_row(p, word_start(p, p->at), e, row, "a coordinate is not a finite number");
        note_alpha(p, q, (double)value);
        if (q->to) q->to[row * q->step] = convert(q, (double)value);
        return SNELL_OK;
    }
    if ((size_t)(p->end - p->at) < ply_sizes[q->type]) return ends_early(p, e, row);
    double exact = load(p->at, q->type, p->head.swapped);
    p->at += ply_sizes[q->type];
    note_alpha(p, q, exact);
    if (q->to) q->to[row * q->step] = convert(q, exact);
    return SNELL_OK;
}

enum { ROWS_AT_ONCE = 65536 };
static void say_progress(const ply *p, uint64_t row) {
    if (row % ROWS_AT_ONCE != 0) return;
    import_forget(p->text, (size_t)(p->end - p->text), p->at);
    if (p->options->progress)
        p->options->progress(p->options->progress_user,
                             (double)(p->at - p->text) / (double)(p->end - p->text));
}

/* ---- elements ---- */

static size_t row_size(const element *e) { /* bytes; of a list, without its values */
    size_t sum = 0;
    for (size_t i = 0; i < e->property_count; i++)
        sum +=
            ply_sizes[e->properties[i].list ? e->properties[i].count_type : e->properties[i].type];
    return sum;
}

/* So that no count makes us take more memory than the file has bytes, a few times over. */
static snell_status check_size(const ply *p, const element *e) {
    size_t least = p->head.ascii ? 2 * e->property_count : row_size(e);
    uint64_t left = (uint64_t)(p->end - p->at) + p->head.ascii; /* the last may lack its line end */
    return least && e->count > left / least ? ends_early(p, e, left / least) : SNELL_OK;
}

static snell_status read_rows(ply *p, element *e) {
    bool lists = false;
    for (size_t i = 0; i < e->property_count; i++) lists |= e->properties[i].list;
    if (e->property_count == 0) return SNELL_OK;
    if (!lists && !p->head.ascii) {
        const size_t stride = row_size(e);
        for (uint64_t row = 0; row < e->count; row += ROWS_AT_ONCE) {
            uint64_t count = e->count - row < ROWS_AT_ONCE ? e->count - row : ROWS_AT_ONCE;
            say_progress(p, row);
            for (size_t i = 0, offset = 0; i < e->property_count; i++) {
                read_column(p, &e->properties[i], p->at + offset, stride, row, count);
                offset += ply_sizes[e->properties[i].type];
            }
            p->at += count * stride;
        }
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
        if (ply_find_property(e, (int)(first + i)) == NULL) return;
    *array = memory_aligned(e->count * parts * sizeof **array);
    *failed |= *array == NULL;
    for (size_t i = 0; i < parts && *array; i++) {
        property *q = ply_find_property(e, (int)(first + i));
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
    for (size_t i = 0; i < p->head.element_count; i++)
        if (strcmp(p->head.elements[i].name, "vertex") == 0) return p->head.elements[i].count;
    return 0;
}

static snell_status bad_index(const ply *p, const element *e, uint64_t row, int64_t index) {
    char what[128];
    snprintf(what, sizeof what, "vertex %lld: there are %llu, counted from 0", (long long)index,
             (unsigned long long)vertex_total(p));
    return bad_row(p, p->head.ascii ? word_start(p, p->at) : p->at, e, row, what);
}

static snell_status read_polygon(ply *p, const element *e, uint64_t row, const property *q,
                                 uint64_t total) {
    int64_t count = 0, index = 0;
    snell_status status = read_integer(p, e, row, q->count_type, &count);
    if (status) return status;
    uint64_t least = p->head.ascii ? 2 : ply_sizes[q->type];
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
    if (p->head.ascii || p->head.swapped || e->property_count != 1 ||
        ply_sizes[q->count_type] != 1 || ply_sizes[q->type] != 4 ||
        e->count > (uint64_t)(p->end - p->at) / 13 || p->faces.indices)
        return 0;
    p->faces.indices = memory_aligned(3 * e->count * sizeof *p->faces.indices);
    if (p->faces.indices == NULL) return 0;
    p->faces.index_capacity = 3 * e->count;
    const char *at = p->at;
    uint32_t *to = p->faces.indices + p->faces.index_count;
    uint64_t row = 0;
    for (; row < e->count && *at == 3; row++, at += 13, to += 3) {
        if (row % ROWS_AT_ONCE == 0) p->at = at, say_progress(p, row);
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
    uint64_t least = p->head.ascii ? 2 : ply_sizes[q->type];
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
    const property *indices = ply_find_property(e, INDICES), *uvs = ply_find_property(e, TEXCOORD);
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
    if (p->head.picture[0] && p->out.uvs == NULL)
        status = description_add_message(p->d, SNELL_WARNING, p->path, 0, NULL,
                                         "texture '%.200s': there are no coordinates for it",
                                         p->head.picture);
    if (status) return status;
    if (p->head.picture[0] == 0 || p->out.uvs == NULL)
        return surfaces_plain(p->d, p->path, 1, material);
    decoded_image image;
    snell_texture_id texture;
    status = map_load(p->path, p->head.picture, p->options, &image);
    if (status == SNELL_ERR_MEMORY) return status;
    if (status) {
        char text[400];
        snprintf(text, sizeof text, "%s", error_last()->text);
        status =
            description_add_message(p->d, SNELL_WARNING, p->path, 0, NULL,
                                    "texture '%.200s': %s; white is used", p->head.picture, text);
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
    for (size_t i = 0; i < p->head.element_count; i++) {
        const element *e = &p->head.elements[i];
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
    snell_status status =
        p->out.normals || p->options->flat ? SNELL_OK : surfaces_smooth(&p->out, NULL, NULL);
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
    for (size_t i = 0; i < p->head.element_count && !status; i++) {
        const element *e = &p->head.elements[i];
        if (strcmp(e->name, "vertex") == 0)
            for (int k = 0; k < 3; k++)
                if (ply_find_property(e, POSITION + k) == NULL)
                    return bad_row(p, p->at, e, 0, "it has no x, y and z");
        status = check_size(p, e);
    }
    return status;
}

static snell_status read_elements(ply *p) {
    snell_status status = check_elements(p);
    for (size_t i = 0; i < p->head.element_count && !status; i++) {
        element *e = &p->head.elements[i];
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
    const char *mapped;
    ply *p = memory_zeroed(1, sizeof *p);
    if (p == NULL) return error_no_memory();
    *p = (ply){.path = path, .options = options, .d = d};
    snell_status status = import_map_file(path, options, &mapped, &size);
    if (!status) {
        p->text = p->at = mapped + import_mark_size(mapped, size);
        p->end = mapped + size;
        status = size ? ply_header_read(path, &p->at, p->end, d, &p->head)
                      : error_set(SNELL_ERR_SYNTAX, NULL, "the file is empty");
        if (!status) status = read_elements(p);
        if (!status) status = finish(p);
        import_unmap_file(mapped, size);
    }
    if (status) error_place((source_place){path, 0, 0});
    ply_header_free(&p->head);
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
