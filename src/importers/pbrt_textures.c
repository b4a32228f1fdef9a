/* pbrt's textures. A definition becomes a node; what uses it asks for a value and a texture of snell's.
 * Constants are folded as they are read, so that most trees are one node. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/pbrt.h"
#include "maths/functions.h"

enum { PATTERN_PIXELS = 512, RAMP_PIXELS = 64 };

void pbrt_texture_free(pbrt_texture *texture) { image_free(&texture->image); }

static snell_status add_node(pbrt *p, source_place place, const pbrt_texture *node, size_t *out) {
    if (!ARRAY_GROW(p->textures, p->texture_count, p->texture_capacity, 1))
        return pbrt_blame(p, place, error_no_memory());
    *out = p->texture_count;
    p->textures[p->texture_count++] = *node;
    return SNELL_OK;
}

static bool is_constant(const pbrt *p, size_t index) {
    return p->textures[index].kind == PBRT_CONSTANT;
}

/* ---- parameters ---- */

size_t pbrt_texture_find(pbrt *p, const pbrt_param *param, bool is_float) {
    json_t *found = NULL;
    if (!p->status && param->count == 1)
        found =
            json_object_get(is_float ? p->float_textures : p->color_textures, param->strings[0]);
    if (found) return (size_t)json_integer_value(found);
    pbrt_fail(p, param->place, "it is made by Texture, before it is used",
              "no %s texture is called '%.60s'", is_float ? "float" : "spectrum",
              param->count ? param->strings[0] : "");
    return SIZE_MAX;
}

/* The parameter's own value; false: it is a texture, or there is none. */
static bool read_value(pbrt *p, const pbrt_params *params, const char *name, bool is_float,
                       double out[3]) {
    pbrt_param *param = pbrt_find(params, name);
    if (param == NULL || strcmp(param->type, "texture") == 0) return false;
    if (is_float)
        out[0] = out[1] = out[2] = pbrt_float(p, params, name, 0);
    else
        pbrt_spectrum(p, param, PBRT_REFLECTANCE, out);
    return true;
}

static pbrt_texture constant_node(double value) {
    return (pbrt_texture){
        .kind = PBRT_CONSTANT, .value = {value, value, value}, .nodes = 1, .pixels = 1};
}

/* A part of a node: a texture, or a constant. */
static size_t read_part(pbrt *p, const pbrt_params *params, const char *name, bool is_float,
                        double otherwise) {
    pbrt_param *param = pbrt_find(params, name);
    pbrt_texture node = constant_node(otherwise);
    size_t out = 0;
    if (param && strcmp(param->type, "texture") == 0) {
        param->used = true;
        out = pbrt_texture_find(p, param, is_float);
        return p->status ? 0 : out;
    }
    read_value(p, params, name, is_float, node.value);
    if (!p->status) add_node(p, params->place, &node, &out);
    return p->status ? 0 : out;
}

/* ---- how they lie ---- */

static void read_mapping(pbrt *p, const pbrt_params *params, pbrt_texture *t) {
    const char *mapping = pbrt_string(p, params, "mapping", "uv");
    t->scale[0] = pbrt_float(p, params, "uscale", 1);
    t->scale[1] = pbrt_float(p, params, "vscale", 1);
    t->offset[0] = pbrt_float(p, params, "udelta", 0);
    t->offset[1] = pbrt_float(p, params, "vdelta", 0);
    pbrt_ignore(params, "v1 v2");
    for (int i = 0; i < 2; i++)
        if (!p->status && !(fabs(t->scale[i]) < 1e6 && fabs(t->offset[i]) < 1e6))
            pbrt_fail(p, params->place, NULL, "%s: the scale of u, v is too large", params->what);
    if (!p->status && strcmp(mapping, "uv") != 0)
        pbrt_warn(p, params->place,
                  "the '%s' mapping of textures is not supported: u, v of the shape are used",
                  mapping);
}

/* Patterns in space lie in the space of the directive: of that its size is kept. */
static void read_space(pbrt *p, const pbrt_params *params, pbrt_texture *t) {
    t->kind = PBRT_NOISE;
    t->octaves = pbrt_int(p, params, "octaves", 8);
    t->gain = clamp01(pbrt_float(p, params, "roughness", 0.5));
    t->octaves = t->octaves < 1 ? 1 : t->octaves > 16 ? 16 : t->octaves;
    t->size = fn_cbrt(fabs(pbrt_determinant(&p->state.ctm[0])));
    t->pixels = 0;
    t->corners[1][0] = t->corners[1][1] = t->corners[1][2] = 1;
    pbrt_warn(p, params->place,
              "the texture '%s' is made of snell's own noise: alike, but not the same",
              params->type);
}

/* ---- kinds ---- */

static void constant(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    t->value[0] = t->value[1] = t->value[2] = 1;
    read_value(p, params, "value", is_float, t->value);
}

static void count_parts(const pbrt *p, pbrt_texture *t, int parts) {
    for (int i = 0; i < parts && !p->status; i++) {
        const pbrt_texture *part = &p->textures[t->parts[i]];
        t->nodes = t->nodes + part->nodes > 1u << 20 ? 1u << 20 : t->nodes + part->nodes;
        if (part->pixels == 0) t->pixels = 0;
        if (t->pixels && part->pixels > t->pixels) t->pixels = part->pixels;
    }
}

static void scaled(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    t->kind = PBRT_SCALE;
    t->parts[0] = read_part(p, params, "tex", is_float, 1);
    t->parts[1] = read_part(p, params, "scale", true, 1);
    count_parts(p, t, 2);
    if (p->status || !is_constant(p, t->parts[0]) || !is_constant(p, t->parts[1])) return;
    t->kind = PBRT_CONSTANT;
    for (int i = 0; i < 3; i++)
        t->value[i] = p->textures[t->parts[0]].value[i] * p->textures[t->parts[1]].value[i];
}

static void fold_mix(pbrt *p, pbrt_texture *t, double amount) {
    t->kind = PBRT_CONSTANT;
    for (int i = 0; i < 3; i++)
        t->value[i] = (1 - amount) * p->textures[t->parts[0]].value[i] +
                      amount * p->textures[t->parts[1]].value[i];
}

static void mixed(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    t->kind = PBRT_MIX;
    t->parts[0] = read_part(p, params, "tex1", is_float, 0);
    t->parts[1] = read_part(p, params, "tex2", is_float, 1);
    t->parts[2] = read_part(p, params, "amount", true, 0.5);
    count_parts(p, t, 3);
    if (!p->status && is_constant(p, t->parts[0]) && is_constant(p, t->parts[1]) &&
        is_constant(p, t->parts[2]))
        fold_mix(p, t, p->textures[t->parts[2]].value[0]);
}

static void direction_mixed(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    pbrt_warn(p, params->place,
              "the texture 'directionmix' is not supported: half of each of its parts");
    pbrt_ignore(params, "dir");
    mixed(p, params, is_float, t);
}

static void bilerp(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    static const char *const names[] = {"v00", "v01", "v10", "v11"};
    t->kind = PBRT_BILERP;
    t->pixels = RAMP_PIXELS;
    read_mapping(p, params, t);
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++) t->corners[i][k] = i % 2;
        read_value(p, params, names[i], is_float, t->corners[i]);
    }
}

static void checkerboard(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    t->kind = PBRT_CHECKER;
    t->pixels = PATTERN_PIXELS;
    if (pbrt_int(p, params, "dimension", 2) == 3)
        pbrt_warn(p, params->place,
                  "a checkerboard in space is not supported: it is flat, in u and v");
    read_mapping(p, params, t);
    t->parts[0] = read_part(p, params, "tex1", is_float, 1);
    t->parts[1] = read_part(p, params, "tex2", is_float, 0);
    count_parts(p, t, 2);
}

/* The dots lie where pbrt's own noise says. */
static void dots(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    pbrt_warn(p, params->place, "the texture 'dots' is not supported: it is what is outside");
    pbrt_ignore(params, "inside mapping uscale vscale udelta vdelta v1 v2");
    pbrt_texture one = constant_node(1);
    t->kind = PBRT_SCALE;
    t->parts[0] = read_part(p, params, "outside", is_float, 0);
    if (!p->status) add_node(p, params->place, &one, &t->parts[1]);
    count_parts(p, t, 2);
}

static void fbm(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    (void)is_float;
    t->noise = "fbm";
    read_space(p, params, t);
}

static void wrinkled(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    (void)is_float;
    t->noise = "turbulence";
    read_space(p, params, t);
}

static void marble(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    (void)is_float;
    static const double dark[3] = {0.17, 0.17, 0.29}, light[3] = {0.58, 0.58, 0.6};
    t->noise = "marble";
    read_space(p, params, t);
    double scale = pbrt_float(p, params, "scale", 1);
    t->size /= scale > 1e-6 ? scale : 1;
    pbrt_ignore(params, "variation");
    memcpy(t->corners[0], light, sizeof light);
    memcpy(t->corners[1], dark, sizeof dark);
}

static void ptex(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    (void)is_float;
    pbrt_warn(p, params->place, "Ptex is not supported: half of white is used");
    pbrt_ignore(params, "filename encoding scale");
    for (int i = 0; i < 3; i++) t->value[i] = 0.5;
}

static void read_encoding(pbrt *p, const pbrt_params *params, pbrt_texture *t) {
    const char *encoding = pbrt_string(p, params, "encoding", "sRGB");
    if (p->status || strcmp(encoding, "sRGB") == 0) return;
    if (strcmp(encoding, "linear") == 0)
        t->gamma = 1;
    else if (strncmp(encoding, "gamma ", 6) != 0 || !pbrt_to_number(encoding + 6, &t->gamma) ||
             !(t->gamma > 0.01 && t->gamma < 100))
        pbrt_fail(p, params->place, "it is sRGB, linear, or such as \"gamma 2.2\"",
                  "unknown encoding '%.40s'", encoding);
}

static void read_filtering(pbrt *p, const pbrt_params *params, pbrt_texture *t) {
    const char *wrap = pbrt_string(p, params, "wrap", "repeat"),
               *filter = pbrt_string(p, params, "filter", "bilinear");
    pbrt_ignore(params, "maxanisotropy");
    if (p->status) return;
    t->wrap = strcmp(wrap, "repeat") != 0;
    t->nearest = strcmp(filter, "point") == 0;
    if (strcmp(wrap, "black") == 0 || strcmp(wrap, "octahedralsphere") == 0)
        pbrt_warn(p, params->place, "the wrap '%s' of textures is not supported: clamp is used",
                  wrap);
    else if (strcmp(wrap, "repeat") != 0 && strcmp(wrap, "clamp") != 0)
        pbrt_fail(p, params->place, "it is repeat, black, clamp or octahedralsphere",
                  "unknown wrap '%.40s'", wrap);
}

static void imagemap(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t) {
    (void)is_float;
    const pbrt_param *file = pbrt_find(params, "filename");
    const char *name = pbrt_string(p, params, "filename", NULL);
    if (!p->status && name == NULL)
        pbrt_fail(p, params->place, "such as \"string filename\" \"wood.png\"",
                  "%s needs a 'filename'", params->what);
    read_mapping(p, params, t);
    read_encoding(p, params, t);
    read_filtering(p, params, t);
    t->factor = pbrt_float(p, params, "scale", 1);
    t->invert = pbrt_bool(p, params, "invert", false);
    bool found;
    if (p->status || pbrt_read_image(p, name, file->place, &t->image, &found)) return;
    if (found) {
        t->kind = PBRT_IMAGE;
        t->pixels = t->image.width > t->image.height ? t->image.width : t->image.height;
    } else {
        for (int i = 0; i < 3; i++) t->value[i] = 0.5;
    }
}

snell_status pbrt_texture_add(pbrt *p, const char *name, bool is_float, const pbrt_params *params) {
    static const struct {
        const char *name;
        void (*read)(pbrt *p, const pbrt_params *params, bool is_float, pbrt_texture *t);
    } kinds[] = {{"constant", constant}, {"scale", scaled},
                 {"mix", mixed},         {"directionmix", direction_mixed},
                 {"bilerp", bilerp},     {"imagemap", imagemap},
                 {"dots", dots},         {"checkerboard", checkerboard},
                 {"fbm", fbm},           {"wrinkled", wrinkled},
                 {"windy", fbm},         {"marble", marble},
                 {"ptex", ptex}};
    json_t *names = is_float ? p->float_textures : p->color_textures;
    if (json_object_get(names, name))
        return pbrt_fail(p, params->place, "give it another name", "a second texture '%.60s'",
                         name);
    size_t i = 0, count = sizeof kinds / sizeof kinds[0], index = 0;
    while (i < count && strcmp(kinds[i].name, params->type) != 0) i++;
    if (i == count)
        return pbrt_fail(p, params->place, "such as imagemap, checkerboard, scale or mix",
                         "unknown texture '%s'", params->type);
    pbrt_texture node = {.kind = PBRT_CONSTANT, .scale = {1, 1}, .factor = 1, .is_float = is_float};
    node.nodes = node.pixels = 1;
    kinds[i].read(p, params, is_float, &node);
    if (p->status || add_node(p, params->place, &node, &index)) {
        pbrt_texture_free(&node);
        return p->status;
    }
    if (json_object_set_new_nocheck(names, name, json_integer((json_int_t)index)))
        return pbrt_blame(p, params->place, error_no_memory());
    return SNELL_OK;
}

/* ---- what becomes of them ---- */

static snell_status add_texture(pbrt *p, source_place place, const char *type,
                                const snell_param *params, size_t count, snell_input *out) {
    uint32_t index;
    object_source source = {NULL, place.file, place.line};
    if (pbrt_blame(p, place,
                   description_add(p->d, CATEGORY_TEXTURE, type, params, count, source, &index)))
        return p->status;
    out->texture = (snell_texture_id){index + 1, 0};
    return SNELL_OK;
}

static snell_vec3 color_of(const double c[3]) {
    return (snell_vec3){(float)double_max(c[0], 0), (float)double_max(c[1], 0),
                        (float)double_max(c[2], 0)};
}

static snell_status add_checker(pbrt *p, const pbrt_texture *t, source_place place,
                                snell_input *out) {
    const snell_param params[] = {
        {"color_a", SNELL_PARAM_VEC3, {.v = color_of(p->textures[t->parts[0]].value)}},
        {"color_b", SNELL_PARAM_VEC3, {.v = color_of(p->textures[t->parts[1]].value)}},
        {"size", SNELL_PARAM_FLOAT, {.f = 1 / t->scale[0]}},
        {"map", SNELL_PARAM_STRING, {.s = "uv"}},
        {"filter", SNELL_PARAM_BOOL, {.b = true}}};
    return add_texture(p, place, "checker", params, 5, out);
}

static snell_status add_noise(pbrt *p, const pbrt_texture *t, source_place place,
                              snell_input *out) {
    const snell_param params[] = {{"kind", SNELL_PARAM_STRING, {.s = t->noise}},
                                  {"color_a", SNELL_PARAM_VEC3, {.v = color_of(t->corners[0])}},
                                  {"color_b", SNELL_PARAM_VEC3, {.v = color_of(t->corners[1])}},
                                  {"size", SNELL_PARAM_FLOAT, {.f = double_max(t->size, 1e-6)}},
                                  {"octaves", SNELL_PARAM_INT, {.i = t->octaves}},
                                  {"gain", SNELL_PARAM_FLOAT, {.f = t->gain}}};
    return add_texture(p, place, "noise", params, 6, out);
}

static bool is_plain_checker(const pbrt *p, const pbrt_texture *t) {
    return t->kind == PBRT_CHECKER && is_constant(p, t->parts[0]) && is_constant(p, t->parts[1]) &&
           t->scale[0] == t->scale[1] && t->scale[0] > 0 && t->offset[0] == 0 && t->offset[1] == 0;
}

/* An image whose pixels are what the texture shows, but for a factor. */
static bool is_plain_image(const pbrt_texture *t, bool is_float) {
    if (t->kind != PBRT_IMAGE || t->invert || !(t->factor >= 0)) return false;
    if (t->factor > 1 && !is_float) return false; /* colours are cut at 1 */
    return t->image.floats ? !is_float
                           : (t->gamma == 0 || t->gamma == 1) && t->image.channels != 2 &&
                                 (!is_float || t->image.channels == 1);
}

static void scale_input(snell_input *input, const double factor[3]) {
    input->value =
        (snell_vec3){(float)(input->value.x * factor[0]), (float)(input->value.y * factor[1]),
                     (float)(input->value.z * factor[2])};
}

static snell_status make_input(pbrt *p, size_t index, bool is_float, double power,
                               source_place place, snell_input *out) {
    static const double one[3] = {1, 1, 1};
    const pbrt_texture *t = &p->textures[index];
    *out = (snell_input){.value = {1, 1, 1}};
    if (power == 1 && is_plain_image(t, is_float)) {
        out->value = color_of((const double[3]){t->factor, t->factor, t->factor});
        return pbrt_add_image(p, place, &t->image, t->gamma == 0, t, &out->texture);
    }
    if (power == 1 && is_plain_checker(p, t)) return add_checker(p, t, place, out);
    if (t->kind == PBRT_NOISE) return add_noise(p, t, place, out);
    if (pbrt_can_bake(p, index))
        return pbrt_bake(p, index, is_float, power, one, place, &out->texture);
    out->value = (snell_vec3){0.5f, 0.5f, 0.5f};
    return pbrt_warn(p, place,
                     "textures that blend patterns in space are not supported: grey is used");
}

/* Constant factors go into the value. */
static snell_status input_of(pbrt *p, size_t index, bool is_float, double power, source_place place,
                             snell_input *out) {
    double factor[3] = {1, 1, 1};
    while (p->textures[index].kind == PBRT_SCALE) {
        const pbrt_texture *t = &p->textures[index];
        int constant = is_constant(p, t->parts[1]) ? 1 : is_constant(p, t->parts[0]) ? 0 : -1;
        if (constant < 0) break;
        for (int i = 0; i < 3; i++)
            factor[i] *= double_max(p->textures[t->parts[constant]].value[i], 0);
        index = t->parts[1 - constant];
    }
    for (int i = 0; i < 3 && power != 1; i++) factor[i] = fn_pow(factor[i], power);
    pbrt_texture *t = &p->textures[index];
    if (t->kind == PBRT_CONSTANT) {
        double v[3];
        for (int i = 0; i < 3; i++)
            v[i] = power == 1 ? t->value[i] : fn_pow(double_max(t->value[i], 0), power);
        *out = (snell_input){.value = color_of(v)};
    } else if (!is_float && double_max(factor[0], double_max(factor[1], factor[2])) > 1 &&
               pbrt_can_bake(p, index)) {
        *out = (snell_input){.value = {1, 1, 1}};
        return pbrt_bake(p, index, is_float, power, factor, place, &out->texture);
    } else if (power == 1 && t->made[is_float]) {
        *out = t->input[is_float];
    } else {
        if (make_input(p, index, is_float, power, place, out)) return p->status;
        t = &p->textures[index];
        if (power == 1) t->made[is_float] = true, t->input[is_float] = *out;
    }
    scale_input(out, factor);
    return SNELL_OK;
}

static snell_status read_input(pbrt *p, const pbrt_params *params, const char *name, bool is_float,
                               double power, const double otherwise[3], snell_input *out,
                               bool *found) {
    pbrt_param *param = pbrt_find(params, name);
    if (found) *found = param != NULL;
    double value[3] = {otherwise[0], otherwise[1], otherwise[2]};
    if (param && strcmp(param->type, "texture") == 0) {
        param->used = true;
        size_t index = pbrt_texture_find(p, param, is_float);
        return p->status ? p->status : input_of(p, index, is_float, power, param->place, out);
    }
    read_value(p, params, name, is_float, value);
    for (int i = 0; i < 3 && power != 1; i++) value[i] = fn_pow(double_max(value[i], 0), power);
    *out = (snell_input){.value = color_of(value)};
    return p->status;
}

snell_status pbrt_input(pbrt *p, const pbrt_params *params, const char *name, bool is_float,
                        const double otherwise[3], snell_input *out, bool *found) {
    return read_input(p, params, name, is_float, 1, otherwise, out, found);
}

snell_status pbrt_roughness_input(pbrt *p, const pbrt_params *params, const char *name,
                                  double otherwise, double power, snell_input *out, bool *found) {
    const double value[3] = {otherwise, otherwise, otherwise};
    return read_input(p, params, name, true, power, value, out, found);
}
