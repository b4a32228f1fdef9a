/* NFF, the Neutral File Format of the Standard Procedural Databases (Haines, A Proposal for Standard
 * Graphics Environments, IEEE CG&A 7(11), 1987; format of 4 December 1996). Spheres, cylinders and
 * cones stay what they are.
 *
 * NFF says little of light and material. Its colours and weights are those that a screen shows: they
 * are decoded as sRGB. Each of n lights of colour c gives the irradiance c pi / sqrt(n) in the middle
 * of what is drawn and falls off with the distance, as light does. A surface with Ks sends out a mirror ray of that
 * weight; one with T is glass of that colour. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "geometry/mesh.h"
#include "image/srgb.h"
#include "importers/files.h"
#include "importers/triangulate.h"
#include "maths/functions.h"

enum { WORD_MAX = 64, CORNERS_MAX = 4096 };

typedef struct nff_light {
    vec3 position, color;
    uint32_t line;
} nff_light;

typedef struct nff {
    const char *path;
    description *d;
    const char *at, *end; /* the text that is left; *end is 0 */
    uint32_t line;
    const char *line_start, *word_start; /* of the line that `at` is in; of `word` */
    char word[WORD_MAX];
    snell_material_id material; /* of what follows; {0}: grey */
    nff_light *lights;
    size_t light_count, light_capacity;
    bool has_view;
    bounds3 bounds; /* of all corners, centres and ends */
    /* Polygons of one material that follow each other are one mesh. */
    vec3 *positions, *normals;
    uint32_t *indices;
    size_t position_count, position_capacity, normal_count, normal_capacity;
    size_t index_count, index_capacity;
    uint32_t mesh_line;
} nff;

/* ---- words and numbers ---- */

static source_place here(const nff *n) { return (source_place){n->path, n->line, 0}; }

/* The column, from 1, at which the last word begins, or the text ends. */
static source_place at_word(const nff *n) {
    return (source_place){n->path, n->line, (uint32_t)(n->word_start - n->line_start) + 1};
}

static void skip_line(nff *n) {
    while (n->at < n->end && *n->at != '\n') n->at++;
}

/* To the next word, over comments; `same_line`: but not over the end of the line. */
static bool skip_space(nff *n, bool same_line) {
    for (; n->at < n->end; n->at++) {
        if (*n->at == '#') skip_line(n);
        if (n->at == n->end) return false;
        if (*n->at == '\n') {
            if (same_line) return false;
            n->line++;
            n->line_start = n->at + 1;
        } else if (*n->at != ' ' && *n->at != '\t' && *n->at != '\r') {
            return true;
        }
    }
    return false;
}

/* The next word, cut where it is too long for any that means something; false at the end. */
static bool next_word(nff *n, bool same_line) {
    bool found = skip_space(n, same_line);
    n->word_start = n->at;
    if (!found) return false;
    size_t used = 0;
    for (; n->at < n->end && !strchr(" \t\r\n#", *n->at); n->at++)
        if (used + 1 < WORD_MAX) n->word[used++] = *n->at;
    n->word[used] = 0;
    return true;
}

/* Digits, signs, dots and exponents only: no "nan", no "0x1". */
static bool word_is_number(const nff *n, float *out) {
    if (n->word[strspn(n->word, "+-.0123456789eE")] != 0 || !strpbrk(n->word, "0123456789"))
        return false;
    char *rest;
    double value = strtod(n->word, &rest);
    *out = (float)value;
    return *rest == 0 && isfinite(*out);
}

static snell_status read_numbers(nff *n, const char *entity, float *out, int count) {
    for (int i = 0; i < count; i++) {
        if (!next_word(n, false))
            return error_set_at(SNELL_ERR_SYNTAX, at_word(n), "the file may be cut off",
                                "the file ends in the middle of '%s'", entity);
        if (!word_is_number(n, &out[i]))
            return error_set_at(SNELL_ERR_SYNTAX, at_word(n), NULL,
                                "'%s' needs a number here, not '%.40s'", entity, n->word);
    }
    return SNELL_OK;
}

/* What the line has beyond, up to `count` numbers; returns how many. */
static int read_optional(nff *n, float *out, int count) {
    int used = 0;
    while (used < count) {
        const char *before = n->at;
        if (!next_word(n, true)) return used;
        if (!word_is_number(n, &out[used])) {
            n->at = before;
            return used;
        }
        used++;
    }
    return used;
}

/* ---- adding ---- */

static object_source source_at(const nff *n, uint32_t line) {
    return (object_source){NULL, n->path, line};
}

static snell_status blame(const nff *n, uint32_t line, snell_status status) {
    if (status) error_place((source_place){n->path, line, 0});
    return status;
}

static snell_status add_drawn(nff *n, uint32_t shape, uint32_t line) {
    transform still = transform_identity();
    uint32_t unused, material = n->material.index1 ? n->material.index1 - 1 : NO_MATERIAL;
    return blame(
        n, line,
        description_add_instance(n->d, shape, material, &still, source_at(n, line), &unused));
}

static snell_status add_shape(nff *n, const char *type, const snell_param *params, size_t count,
                              uint32_t line) {
    uint32_t shape;
    snell_status status =
        description_add(n->d, CATEGORY_SHAPE, type, params, count, source_at(n, line), &shape);
    return status ? blame(n, line, status) : add_drawn(n, shape, line);
}

/* The polygons that were gathered, as a mesh. */
static snell_status flush_mesh(nff *n) {
    if (n->index_count == 0) return SNELL_OK;
    mesh_desc desc = {.struct_size = sizeof desc,
                      .positions = n->positions,
                      .positions_count = n->position_count,
                      .indices = n->indices,
                      .indices_count = n->index_count,
                      .normals = n->normal_count ? n->normals : NULL,
                      .normals_count = n->normal_count};
    uint32_t shape;
    snell_status status = description_add_desc(n->d, type_find(CATEGORY_SHAPE, "mesh"), &desc,
                                               source_at(n, n->mesh_line), &shape);
    n->position_count = n->normal_count = n->index_count = 0;
    return status ? blame(n, n->mesh_line, status) : add_drawn(n, shape, n->mesh_line);
}

/* ---- entities ---- */

static snell_status read_background(nff *n) {
    float c[3];
    snell_status status = read_numbers(n, "b", c, 3);
    if (status) return status;
    if (description_setting(n->d, "background"))
        return error_set_at(SNELL_ERR_SYNTAX, here(n), NULL, "a second background ('b')");
    const snell_param params[] = {
        {"color",
         SNELL_PARAM_VEC3,
         {.v = {srgb_to_linear((double)c[0]), srgb_to_linear((double)c[1]),
                srgb_to_linear((double)c[2])}}}};
    uint32_t made;
    return blame(n, n->line,
                 description_add(n->d, CATEGORY_SETTING, "background", params, 1,
                                 source_at(n, n->line), &made));
}

static snell_status add_view(nff *n, const float from[3], const float at[3], const float up[3],
                             float angle, const float resolution[2], uint32_t line) {
    const snell_param camera[] = {{"from", SNELL_PARAM_VEC3, {.v = {from[0], from[1], from[2]}}},
                                  {"at", SNELL_PARAM_VEC3, {.v = {at[0], at[1], at[2]}}},
                                  {"up", SNELL_PARAM_VEC3, {.v = {up[0], up[1], up[2]}}},
                                  {"fov", SNELL_PARAM_FLOAT, {.f = (double)angle * (PI / 180)}}};
    uint32_t made;
    snell_status status =
        description_add(n->d, CATEGORY_CAMERA, "perspective", camera, 4, source_at(n, line), &made);
    if (!status && resolution[0] > 0 && !description_setting(n->d, "render")) {
        /* What is far too large is for the check of `render` to refuse. */
        int64_t width = (int64_t)float_min(resolution[0], 1e9f);
        int64_t height = (int64_t)float_min(float_max(resolution[1], -1), 1e9f);
        const snell_param size[] = {{"width", SNELL_PARAM_INT, {.i = width}},
                                    {"height", SNELL_PARAM_INT, {.i = height}}};
        status =
            description_add(n->d, CATEGORY_SETTING, "render", size, 2, source_at(n, line), &made);
    }
    n->has_view = true;
    return blame(n, line, status);
}

/* The lines of a view may come in any order; it ends with the first that is none of them. */
static snell_status read_view(nff *n) {
    enum { FROM, AT, UP, ANGLE, HITHER, RESOLUTION, PARTS };
    static const struct {
        const char *name;
        int count;
    } parts[PARTS] = {{"from", 3},  {"at", 3},     {"up", 3},
                      {"angle", 1}, {"hither", 1}, {"resolution", 2}};
    float values[PARTS][3] = {[FROM] = {0, 0, 1}, [UP] = {0, 1, 0}, [ANGLE] = {45}};
    uint32_t line = n->line;
    for (;;) {
        const char *before = n->at, *start_before = n->line_start;
        uint32_t line_before = n->line;
        int i = 0;
        if (next_word(n, false))
            while (i < PARTS && strcmp(n->word, parts[i].name) != 0) i++;
        else
            i = PARTS;
        if (i == PARTS) {
            n->at = before;
            n->line = line_before;
            n->line_start = start_before;
            return add_view(n, values[FROM], values[AT], values[UP], values[ANGLE][0],
                            values[RESOLUTION], line);
        }
        snell_status status = read_numbers(n, parts[i].name, values[i], parts[i].count);
        if (status) return status;
    }
}

static snell_status read_light(nff *n) {
    float p[3], c[3] = {1, 1, 1};
    snell_status status = read_numbers(n, "l", p, 3);
    if (status) return status;
    read_optional(n, c, 3);
    if (!ARRAY_GROW(n->lights, n->light_count, n->light_capacity, 1)) return error_no_memory();
    n->lights[n->light_count++] = (nff_light){{p[0], p[1], p[2]}, {c[0], c[1], c[2]}, n->line};
    return SNELL_OK;
}

/* After the file, when it is known where the middle is. */
static snell_status add_lights(nff *n) {
    dvec3 center = {0, 0, 0};
    if (!bounds3_is_empty(n->bounds))
        center = dvec3_scale(dvec3_add(dvec3_from(n->bounds.min), dvec3_from(n->bounds.max)), 0.5);
    for (size_t i = 0; i < n->light_count; i++) {
        const nff_light *l = &n->lights[i];
        dvec3 away = dvec3_sub(dvec3_from(l->position), center);
        double square = dvec3_dot(away, away);
        double scale = PI * (square > 0 ? square : 1) / sqrt((double)n->light_count);
        vec3 intensity = vec3_from(dvec3_scale(dvec3_from(l->color), scale));
        const snell_param params[] = {{"position", SNELL_PARAM_VEC3, {.v = l->position}},
                                      {"intensity", SNELL_PARAM_VEC3, {.v = intensity}}};
        uint32_t made;
        snell_status status =
            description_add(n->d, CATEGORY_LIGHT, "point", params, 2, source_at(n, l->line), &made);
        if (status) return blame(n, l->line, status);
    }
    return SNELL_OK;
}

static snell_status add_material(nff *n, const char *type, const snell_param *params, size_t count,
                                 uint32_t line) {
    uint32_t made;
    snell_status status =
        description_add(n->d, CATEGORY_MATERIAL, type, params, count, source_at(n, line), &made);
    if (!status) n->material = (snell_material_id){made + 1, 0};
    return blame(n, line, status);
}

/* f r g b Kd Ks Shine T index_of_refraction: missing ones are those of a matte surface. The highlight
 * of a light counts Ks where the diffuse part counts Kd, so it lacks Lambert's 1 / pi as that does. */
static snell_status read_fill(nff *n) {
    enum { KD = 3, KS, SHINE, T, IOR };
    float f[8] = {[KD] = 1, [IOR] = 1};
    uint32_t line = n->line;
    snell_status status = read_numbers(n, "f", f, 3);
    if (status) return status;
    read_optional(n, f + 3, 5);
    if (next_word(n, true)) {
        description_add_message(n->d, SNELL_WARNING, n->path, line, NULL,
                                "'%.40s' after a material's numbers is not read", n->word);
        skip_line(n);
    }
    for (int i = 0; i < 8; i++)
        if (f[i] < 0)
            return error_set_at(SNELL_ERR_SYNTAX, (source_place){n->path, line, 0}, NULL,
                                "'f' has a number below 0");
    if (f[T] > 0) {
        float ior = f[IOR] >= 1 ? f[IOR] : 1, t = srgb_to_linear((double)f[T]);
        const snell_param glass[] = {{"ior", SNELL_PARAM_FLOAT, {.f = (double)ior}},
                                     {"color", SNELL_PARAM_VEC3, {.v = {t, t, t}}}};
        return add_material(n, "dielectric", glass, 2, line);
    }
    vec3 color = {srgb_to_linear((double)(f[0] * f[KD])), srgb_to_linear((double)(f[1] * f[KD])),
                  srgb_to_linear((double)(f[2] * f[KD]))};
    double ks = (double)srgb_to_linear((double)f[KS]);
    const snell_param matte[] = {{"color", SNELL_PARAM_VEC3, {.v = color}},
                                 {"specular", SNELL_PARAM_FLOAT, {.f = ks / PI}},
                                 {"exponent", SNELL_PARAM_FLOAT, {.f = (double)f[SHINE]}}};
    if (!(f[KS] > 0)) return add_material(n, "lambert", matte, 1, line);
    status = add_material(n, "phong", matte, 3, line);
    if (status) return status;
    const snell_param coat[] = {{"base", SNELL_PARAM_MATERIAL, {.material = n->material}},
                                {"reflectance", SNELL_PARAM_FLOAT, {.f = ks}}};
    return add_material(n, "glazed", coat, 2, line);
}

static snell_status read_sphere(nff *n) {
    float s[4];
    uint32_t line = n->line;
    snell_status status = read_numbers(n, "s", s, 4);
    if (status) return status;
    n->bounds = bounds3_add_point(n->bounds, (vec3){s[0], s[1], s[2]});
    const snell_param params[] = {{"center", SNELL_PARAM_VEC3, {.v = {s[0], s[1], s[2]}}},
                                  {"radius", SNELL_PARAM_FLOAT, {.f = fabs((double)s[3])}}};
    return add_shape(n, "sphere", params, 2, line);
}

/* Without its ends. */
static snell_status read_cone(nff *n) {
    float c[8];
    uint32_t line = n->line;
    snell_status status = read_numbers(n, "c", c, 8);
    if (status) return status;
    n->bounds = bounds3_add_point(n->bounds, (vec3){c[0], c[1], c[2]});
    n->bounds = bounds3_add_point(n->bounds, (vec3){c[4], c[5], c[6]});
    double radius = fabs((double)c[3]), radius_to = fabs((double)c[7]);
    const snell_param params[] = {{"from", SNELL_PARAM_VEC3, {.v = {c[0], c[1], c[2]}}},
                                  {"to", SNELL_PARAM_VEC3, {.v = {c[4], c[5], c[6]}}},
                                  {"capped", SNELL_PARAM_BOOL, {.b = false}},
                                  {"radius", SNELL_PARAM_FLOAT, {.f = radius}},
                                  {"radius_to", SNELL_PARAM_FLOAT, {.f = radius_to}}};
    bool straight = radius == radius_to;
    return add_shape(n, straight ? "cylinder" : "cone", params, straight ? 4 : 5, line);
}

static bool grow_mesh(nff *n, size_t corners, bool smooth) {
    return ARRAY_GROW(n->positions, n->position_count, n->position_capacity, corners) &&
           ARRAY_GROW(n->indices, n->index_count, n->index_capacity, 3 * corners) &&
           (!smooth || ARRAY_GROW(n->normals, n->normal_count, n->normal_capacity, corners));
}

static snell_status read_polygon(nff *n, bool smooth) {
    const char *entity = smooth ? "pp" : "p";
    float count = 0, values[6];
    uint32_t line = n->line;
    snell_status status = read_numbers(n, entity, &count, 1);
    if (status) return status;
    if (!(count >= 3 && count <= CORNERS_MAX) || count != floorf(count))
        return error_set_at(SNELL_ERR_SYNTAX, here(n), NULL, "'%s' has %g corners, not 3 to %d",
                            entity, (double)count, CORNERS_MAX);
    uint32_t corners = (uint32_t)count, first;
    if (n->index_count && (n->normal_count != 0) != smooth) status = flush_mesh(n);
    if (status) return status;
    if (!grow_mesh(n, corners, smooth)) return error_no_memory();
    if (n->index_count == 0) n->mesh_line = line;
    first = (uint32_t)n->position_count;
    for (uint32_t i = 0; i < corners; i++) {
        status = read_numbers(n, entity, values, smooth ? 6 : 3);
        if (status) return status;
        vec3 corner = {values[0], values[1], values[2]};
        n->bounds = bounds3_add_point(n->bounds, corner);
        n->positions[n->position_count++] = corner;
        if (smooth) n->normals[n->normal_count++] = (vec3){values[3], values[4], values[5]};
    }
    size_t made = triangulate(n->positions + first, corners, n->indices + n->index_count);
    for (size_t i = 0; i < made; i++) n->indices[n->index_count++] += first;
    return SNELL_OK;
}

static snell_status read_entity(nff *n) {
    const char *word = n->word;
    if (strcmp(word, "p") == 0) return read_polygon(n, false);
    if (strcmp(word, "pp") == 0) return read_polygon(n, true);
    snell_status status = flush_mesh(n);
    if (status) return status;
    if (strcmp(word, "s") == 0) return read_sphere(n);
    if (strcmp(word, "c") == 0) return read_cone(n);
    if (strcmp(word, "f") == 0) return read_fill(n);
    if (strcmp(word, "l") == 0) return read_light(n);
    if (strcmp(word, "b") == 0) return read_background(n);
    if (strcmp(word, "v") == 0 && n->has_view)
        return error_set_at(SNELL_ERR_SYNTAX, here(n), NULL, "a second view ('v')");
    if (strcmp(word, "v") == 0) return read_view(n);
    if (strcmp(word, "tess") == 0) { /* how finely others cut spheres */
        skip_line(n);
        return SNELL_OK;
    }
    return error_set_at(SNELL_ERR_SYNTAX, at_word(n),
                        "a line of NFF begins with v, b, l, f, s, c, p or pp",
                        "unknown entity '%.40s'", word);
}

static snell_status read_text(nff *n, const import_options *options, size_t size) {
    const char *start = n->at;
    snell_status status = SNELL_OK;
    for (size_t count = 0; !status && next_word(n, false); count++) {
        status = read_entity(n);
        if (count % 4096 == 0 && options->progress)
            options->progress(options->progress_user, (double)(n->at - start) / (double)size);
    }
    if (!status) status = flush_mesh(n);
    return status ? status : add_lights(n);
}

static snell_status nff_read(const char *path, const import_options *options, description *d) {
    uint8_t *data;
    size_t size;
    snell_status status = import_read_file(path, NULL, options, &data, &size);
    if (status) return status;
    nff n = {.path = path, .d = d, .at = (const char *)data, .line = 1, .bounds = bounds3_empty()};
    n.end = n.at + size;
    n.line_start = n.word_start = n.at;
    if (options->up)
        description_add_message(d, SNELL_WARNING, path, 0, NULL,
                                "an NFF file says by its camera which way is up: --up is ignored");
    status = read_text(&n, options, size + 1);
    snprintf(d->format, sizeof d->format, "nff");
    d->is_model = false;
    free(n.lights);
    free(n.positions);
    free(n.normals);
    free(n.indices);
    free(data);
    return status;
}

/* Other formats have the same extension: this one if the first line is one of its own, an entity and
 * a number or nothing, and none has an entity of its extended kin (platonic solids, polygons with
 * texture coordinates). Whatever else comes later, even if it is wrong, is read as it began. */
static bool nff_recognise(const char *extension, const uint8_t *first, size_t size) {
    static const char *const known = " v b l f s c p pp tess from at up angle hither resolution ";
    static const char *const kin = " tet hex oct dod tpp ";
    if (strcmp(extension, ".nff") != 0) return false;
    nff n = {.at = (const char *)first, .end = (const char *)first + size};
    n.line_start = n.word_start = n.at;
    bool any = false;
    for (; next_word(&n, false); any = true) {
        char word[WORD_MAX + 2];
        float unused;
        snprintf(word, sizeof word, " %.60s ", n.word);
        if (strstr(kin, word)) return false;
        if (!any && !strstr(known, word) && !word_is_number(&n, &unused)) return false;
        if (!any && next_word(&n, true) && !word_is_number(&n, &unused)) return false;
        skip_line(&n);
    }
    return any;
}

const importer importer_nff = {
    .name = "nff",
    .extensions = ".nff",
    .help = "NFF of the Standard Procedural Databases",
    .recognise = nff_recognise,
    .read = nff_read,
};
