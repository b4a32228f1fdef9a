/* glTF textures and materials, as well as they go with this version's models; docs/formats.md has
 * the table. */
#include "importers/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "maths/functions.h"

/* ---- images ---- */

/* The decoded image, or NULL when it cannot be read, which is a warning: the colour alone is used
 * then. */
static snell_status load_image(gltf *g, size_t index, const decoded_image **out) {
    image_entry *entry = &g->images[index];
    *out = entry->image.pixels ? &entry->image : NULL;
    if (entry->tried) return SNELL_OK;
    entry->tried = true;
    byte_block bytes = {0};
    snell_status status = gltf_image_bytes(g, index, &bytes);
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "images[%zu]", index);
    if (!status) {
        size_t size_max = g->budget < IMAGE_SIZE_MAX ? (size_t)g->budget : IMAGE_SIZE_MAX;
        status = image_decode(bytes.data, bytes.size, size_max, &entry->image);
        if (status) gltf_blame(g, where, status);
    }
    free(bytes.owned);
    if (status == SNELL_ERR_MEMORY) return status;
    if (status) return gltf_warn(g, "%s; the plain colour is used", error_last()->text);
    const decoded_image *image = &entry->image;
    *out = image;
    if (image->damaged) status = gltf_warn(g, "%s: the JPEG is damaged", where);
    if (status) return status;
    return gltf_spend(g, where, (uint64_t)image->width * image->height * image->channels);
}

/* ---- textures ---- */

enum { USE_COLOR, USE_ALPHA, USE_DATA };

enum {
    GL_NEAREST = 9728,
    GL_LINEAR = 9729,
    GL_CLAMP = 33071,
    GL_MIRROR = 33648,
    GL_REPEAT = 10497
};

static const char *wrap_word(size_t mode) {
    return mode == GL_CLAMP ? "clamp" : mode == GL_MIRROR ? "mirror" : "repeat";
}

/* offset u, v; rotation; scale u, v of KHR_texture_transform */
static void read_transform(const json_t *info, float out[5]) {
    const json_t *t = json_extension(info, "KHR_texture_transform");
    double offset[2] = {0, 0}, scale[2] = {1, 1};
    json_numbers(t, "offset", offset, 2);
    json_numbers(t, "scale", scale, 2);
    out[0] = (float)offset[0], out[1] = (float)offset[1];
    out[2] = (float)json_number(t, "rotation", 0);
    out[3] = (float)scale[0], out[4] = (float)scale[1];
}

/* glTF's v points down, ours up: v' = 1 - v in the mesh. With R turning counter-clockwise as one
 * sees it, offset + R S (u, v) in glTF becomes the same turn and scale with another offset here:
 * (ox + sin(r) sy, 1 - oy - cos(r) sy). */
static snell_vec3 turned_offset(const float t[5]) {
    double s = fn_sin((double)t[2]), c = fn_cos((double)t[2]), scale = (double)t[4];
    return (snell_vec3){(float)((double)t[0] + s * scale), (float)(1 - (double)t[1] - c * scale),
                        0};
}

static snell_status add_texture(gltf *g, const char *where, size_t sampler_index,
                                const float placing[5], const decoded_image *pixels, int use,
                                snell_texture_id *out) {
    const json_t *sampler =
        sampler_index == SIZE_MAX ? NULL : json_item(g, "samplers", sampler_index);
    size_t filter = json_index(sampler, "magFilter", GL_LINEAR);
    size_t size = (size_t)pixels->width * pixels->height * pixels->channels;
    snell_param params[] = {
        {"width", SNELL_PARAM_INT, {.i = pixels->width}},
        {"height", SNELL_PARAM_INT, {.i = pixels->height}},
        {"format", SNELL_PARAM_STRING, {.s = image_format_word(pixels)}},
        {"pixels", SNELL_PARAM_ARRAY, {.array = {pixels->pixels, size}}},
        {"encoding", SNELL_PARAM_STRING, {.s = use == USE_COLOR ? "srgb" : "linear"}},
        {"wrap_u", SNELL_PARAM_STRING, {.s = wrap_word(json_index(sampler, "wrapS", GL_REPEAT))}},
        {"wrap_v", SNELL_PARAM_STRING, {.s = wrap_word(json_index(sampler, "wrapT", GL_REPEAT))}},
        {"filter", SNELL_PARAM_STRING, {.s = filter == GL_NEAREST ? "nearest" : "linear"}},
        {"map", SNELL_PARAM_STRING, {.s = "uv"}},
        {"uv_offset", SNELL_PARAM_VEC3, {.v = turned_offset(placing)}},
        {"uv_scale", SNELL_PARAM_VEC3, {.v = {placing[3], placing[4], 0}}},
        {"uv_rotation", SNELL_PARAM_FLOAT, {.f = (double)placing[2]}},
    };
    uint32_t index;
    snell_status status = gltf_spend(g, where, size);
    if (!status)
        status = description_add(g->d, CATEGORY_TEXTURE, "image", params,
                                 sizeof params / sizeof params[0],
                                 (object_source){NULL, g->path, 0}, &index);
    if (status) return gltf_blame(g, where, status);
    *out = (snell_texture_id){index + 1, g->d->objects[CATEGORY_TEXTURE].items[index].generation};
    return SNELL_OK;
}

static texture_entry *find_texture(gltf *g, const texture_entry *key) {
    for (size_t i = 0; i < g->texture_count; i++) {
        texture_entry *t = &g->textures[i];
        if (t->texture == key->texture && t->use == key->use &&
            memcmp(t->transform, key->transform, sizeof key->transform) == 0)
            return t;
    }
    return NULL;
}

/* The image that a texture of the file shows; SIZE_MAX: none that can be read. */
static size_t texture_image(const gltf *g, size_t texture) {
    return json_index(json_item(g, "textures", texture), "source", SIZE_MAX);
}

/* The texture of a textureInfo, made once per use; id 0 when its image is missing, or when its
 * alpha is wanted and it is opaque everywhere. */
static snell_status gltf_texture(gltf *g, const json_t *info, int use, snell_texture_id *out) {
    *out = (snell_texture_id){0, 0};
    if (info == NULL) return SNELL_OK;
    texture_entry key = {.texture = (uint32_t)json_index(info, "index", 0), .use = use};
    read_transform(info, key.transform);
    const texture_entry *made = find_texture(g, &key);
    if (made) {
        *out = made->id;
        return SNELL_OK;
    }
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "textures[%u]", key.texture);
    size_t image_index = texture_image(g, key.texture);
    const decoded_image *image = NULL;
    if (image_index == SIZE_MAX)
        return gltf_warn(g, "%s: has no image; the plain colour is used", where);
    snell_status status = load_image(g, image_index, &image);
    if (status) return status;
    if (image && (use != USE_ALPHA || image_has_alpha(image))) {
        decoded_image part;
        status = use == USE_ALPHA ? image_copy_alpha(image, &part) : image_copy_color(image, &part);
        if (!status) {
            size_t sampler = json_index(json_item(g, "textures", key.texture), "sampler", SIZE_MAX);
            status = add_texture(g, where, sampler, key.transform, &part, use, &key.id);
            image_free(&part);
        }
        if (status) return status;
    }
    if (!ARRAY_GROW(g->textures, g->texture_count, g->texture_capacity, 1))
        return error_no_memory();
    g->textures[g->texture_count++] = key;
    *out = key.id;
    return SNELL_OK;
}

/* The mean of one channel, 0..1; 1 without a texture. */
static snell_status average(gltf *g, const json_t *info, uint32_t channel, double *out) {
    *out = 1;
    if (info == NULL) return SNELL_OK;
    size_t index = texture_image(g, json_index(info, "index", 0));
    const decoded_image *image = NULL;
    snell_status status = index == SIZE_MAX ? SNELL_OK : load_image(g, index, &image);
    if (status || image == NULL) return status;
    uint64_t sum = 0;
    size_t count = (size_t)image->width * image->height;
    if (channel >= image->channels) channel = 0;
    for (size_t i = 0; i < count; i++) sum += image->pixels[i * image->channels + channel];
    *out = (double)sum / (255.0 * (double)count);
    return SNELL_OK;
}

/* ---- materials ---- */

typedef struct surface {
    const char *where, *name;
    snell_input base, emission, alpha;
    snell_texture_id normal_map;
    double normal_scale;
    bool has_emission, has_alpha, two_sided;
    double cutoff, metallic, roughness, ior;
} surface;

enum { PARAMS_MAX = 12 };
typedef struct params {
    snell_param list[PARAMS_MAX];
    size_t count;
} params;

static void add_param(params *p, snell_param param) { p->list[p->count++] = param; }
static void add_input(params *p, const char *name, snell_input value) {
    add_param(p, (snell_param){name, SNELL_PARAM_INPUT, {.input = value}});
}
static void add_float(params *p, const char *name, double value) {
    add_param(p, (snell_param){name, SNELL_PARAM_FLOAT, {.f = value}});
}

static void add_common(params *p, const surface *s) {
    if (s->has_emission) {
        add_input(p, "emission", s->emission);
        add_param(p, (snell_param){"emit_two_sided", SNELL_PARAM_BOOL, {.b = s->two_sided}});
    }
    if (s->normal_map.index1) {
        add_param(p, (snell_param){"normal_map", SNELL_PARAM_TEXTURE, {.texture = s->normal_map}});
        add_float(p, "normal_scale", s->normal_scale);
    }
    if (s->has_alpha) {
        add_input(p, "alpha", s->alpha);
        if (s->cutoff > 0) add_float(p, "alpha_cutoff", s->cutoff);
    }
}

static snell_status add_material(gltf *g, const surface *s, const char *type, const params *p,
                                 const char *wanted, uint32_t *out) {
    char name[NAME_MAX_SIZE];
    snell_status status = names_make_unique(&g->names, CATEGORY_MATERIAL, wanted, name);
    if (status) return status;
    object_source source = {name[0] ? name : NULL, g->path, 0};
    status = description_add(g->d, CATEGORY_MATERIAL, type, p->list, p->count, source, out);
    return gltf_blame(g, s->where, status);
}

static snell_input grey(double value) {
    float v = (float)value;
    return (snell_input){{v, v, v}, {0, 0}};
}

/* The highlight of a dielectric of 4 % reflectance as a modified Blinn-Phong lobe: the exponent of
 * a Beckmann lobe of that width, p = 2 / alpha^2 - 2 with alpha = roughness^2 (Walter et al. 2007),
 * and k_s = 0.04 (p + 2) / (8 pi), which keeps the reflected energy about 4 % for any p. */
static void add_highlight(params *p, const surface *s) {
    double squared = s->roughness * s->roughness, exponent = 2 / (squared * squared + 1e-4) - 2;
    if (exponent < 0) exponent = 0;
    double f0 = (s->ior - 1) / (s->ior + 1);
    add_input(p, "specular", grey(f0 * f0 * (exponent + 2) / (8 * PI)));
    add_float(p, "exponent", exponent);
}

static snell_status add_glossy(gltf *g, const surface *s, const char *wanted, uint32_t *out) {
    params p = {.count = 0};
    add_input(&p, "color", s->base);
    add_highlight(&p, s);
    add_common(&p, s);
    return add_material(g, s, "blinn_phong", &p, wanted, out);
}

static snell_status add_glazed(gltf *g, const surface *s, uint32_t *out) {
    surface under = *s;
    under.has_emission = under.has_alpha = false;
    under.normal_map = (snell_texture_id){0, 0};
    uint32_t base;
    snell_status status = add_glossy(g, &under, NULL, &base);
    if (status) return status;
    params p = {.count = 0};
    snell_material_id id = {base + 1, g->d->objects[CATEGORY_MATERIAL].items[base].generation};
    add_param(&p, (snell_param){"base", SNELL_PARAM_MATERIAL, {.material = id}});
    add_float(&p, "ior", s->ior);
    add_common(&p, s);
    return add_material(g, s, "glazed", &p, s->name, out);
}

static snell_status add_metal(gltf *g, const surface *s, uint32_t *out) {
    params p = {.count = 0};
    double gloss = 1 - s->roughness;
    add_input(&p, "color", s->base);
    add_input(&p, "specularity", grey(gloss * gloss));
    add_common(&p, s);
    return add_material(g, s, "partial_mirror", &p, s->name, out);
}

static snell_status add_unlit(gltf *g, const surface *s, uint32_t *out) {
    surface shown = *s;
    shown.emission = s->base;
    shown.has_emission = shown.two_sided = true;
    params p = {.count = 0};
    add_input(&p, "color", grey(0));
    add_param(&p, (snell_param){"ambient", SNELL_PARAM_FLOAT, {.f = 0}});
    add_common(&p, &shown);
    return add_material(g, s, "lambert", &p, s->name, out);
}

static snell_status add_glass(gltf *g, const surface *s, const json_t *material, uint32_t *out) {
    const json_t *volume = json_extension(material, "KHR_materials_volume");
    double color[3] = {1, 1, 1}, distance = json_number(volume, "attenuationDistance", 0);
    json_numbers(volume, "attenuationColor", color, 3);
    params p = {.count = 0};
    add_input(&p, "color", s->base);
    add_float(&p, "ior", s->ior);
    if (distance > 0) {
        snell_vec3 c;
        float *parts[] = {&c.x, &c.y, &c.z};
        for (int i = 0; i < 3; i++) *parts[i] = (float)(color[i] < 1e-6 ? 1e-6 : color[i]);
        add_param(&p, (snell_param){"attenuation_color", SNELL_PARAM_VEC3, {.v = c}});
        add_float(&p, "attenuation_distance", distance);
    }
    add_common(&p, s);
    return add_material(g, s, "dielectric", &p, s->name, out);
}

static unsigned uv_set(const json_t *info) {
    const json_t *changed = json_extension(info, "KHR_texture_transform");
    return (unsigned)json_index(changed, "texCoord", json_index(info, "texCoord", 0)) & 0xff;
}

/* Whose texture coordinates the material's meshes have. */
static const json_t *main_texture(const json_t *material) {
    const json_t *base = json_at(json_at(material, "pbrMetallicRoughness"), "baseColorTexture"),
                 *emissive = json_at(material, "emissiveTexture");
    return base ? base : emissive ? emissive : json_at(material, "normalTexture");
}

/* A mesh keeps one set of texture coordinates, that of the base colour. */
static snell_status warn_of_uv_sets(gltf *g, const json_t *material) {
    unsigned used = uv_set(main_texture(material));
    const char *const others[] = {"emissiveTexture", "normalTexture"};
    bool differ = false;
    for (int i = 0; i < 2; i++) {
        const json_t *info = json_at(material, others[i]);
        differ |= info && uv_set(info) != used;
    }
    if (g->uv_sets_warned || !differ) return SNELL_OK;
    g->uv_sets_warned = true;
    return gltf_warn(g,
                     "a material's textures use several sets of texture coordinates: that of the "
                     "base colour is used for all");
}

/* One warning for everything that a material has and this version does not show. */
static snell_status warn_of_losses(gltf *g, const json_t *material) {
    const json_t *pbr = json_at(material, "pbrMetallicRoughness"),
                 *transmission = json_extension(material, "KHR_materials_transmission"),
                 *volume = json_extension(material, "KHR_materials_volume");
    snell_status status = SNELL_OK;
    if (json_at(material, "occlusionTexture"))
        status = gltf_warn(g, "occlusion maps are not supported: ignored");
    if (!status && json_at(pbr, "metallicRoughnessTexture"))
        status =
            gltf_warn(g, "metallic-roughness maps are not supported yet: their average is used");
    if (!status &&
        (json_at(transmission, "transmissionTexture") || json_at(volume, "thicknessTexture")))
        status = gltf_warn(g, "transmission and thickness maps are not supported yet: ignored");
    return status;
}

static snell_status read_base(gltf *g, const json_t *material, surface *s) {
    const json_t *pbr = json_at(material, "pbrMetallicRoughness"),
                 *info = json_at(pbr, "baseColorTexture"),
                 *maps = json_at(pbr, "metallicRoughnessTexture");
    double factor[4] = {1, 1, 1, 1}, metallic, roughness;
    json_numbers(pbr, "baseColorFactor", factor, 4);
    s->base.value = (snell_vec3){(float)factor[0], (float)factor[1], (float)factor[2]};
    snell_status status = gltf_texture(g, info, USE_COLOR, &s->base.texture);
    if (!status) status = average(g, maps, 2, &metallic);
    if (!status) status = average(g, maps, 1, &roughness);
    if (status) return status;
    s->metallic = metallic * json_number(pbr, "metallicFactor", 1);
    s->roughness = roughness * json_number(pbr, "roughnessFactor", 1);
    const char *mode = json_text(material, "alphaMode");
    if (mode == NULL || strcmp(mode, "OPAQUE") == 0) return SNELL_OK;
    s->cutoff = strcmp(mode, "MASK") == 0 ? json_number(material, "alphaCutoff", 0.5) : 0;
    if (strcmp(mode, "MASK") == 0 && !(s->cutoff > 0)) return SNELL_OK; /* nothing is cut */
    if (s->cutoff > 2) s->cutoff = 2;
    s->has_alpha = true;
    s->alpha = grey(factor[3]);
    return gltf_texture(g, info, USE_ALPHA, &s->alpha.texture);
}

static snell_status read_emission(gltf *g, const json_t *material, surface *s) {
    double factor[3] = {0, 0, 0},
           strength = json_number(json_extension(material, "KHR_materials_emissive_strength"),
                                  "emissiveStrength", 1);
    json_numbers(material, "emissiveFactor", factor, 3);
    s->two_sided = json_flag(material, "doubleSided");
    s->has_emission = (factor[0] > 0 || factor[1] > 0 || factor[2] > 0) && strength > 0;
    if (!s->has_emission) return SNELL_OK;
    s->emission.value = (snell_vec3){(float)(factor[0] * strength), (float)(factor[1] * strength),
                                     (float)(factor[2] * strength)};
    return gltf_texture(g, json_at(material, "emissiveTexture"), USE_COLOR, &s->emission.texture);
}

static snell_status read_normals(gltf *g, const json_t *material, surface *s) {
    const json_t *info = json_at(material, "normalTexture");
    s->normal_scale = json_number(info, "scale", 1);
    return gltf_texture(g, info, USE_DATA, &s->normal_map);
}

static snell_status make_material(gltf *g, const json_t *material, const char *where,
                                  uint32_t *out) {
    surface s = {.where = where, .name = json_text(material, "name"), .ior = 1.5};
    snell_status status = read_base(g, material, &s);
    if (!status) status = read_emission(g, material, &s);
    if (!status) status = warn_of_losses(g, material);
    if (!status) status = read_normals(g, material, &s);
    if (!status && (s.has_emission || s.normal_map.index1)) status = warn_of_uv_sets(g, material);
    if (status) return status;
    double ior = json_number(json_extension(material, "KHR_materials_ior"), "ior", 1.5);
    s.ior = ior < 1    ? 1
            : ior > 10 ? 10
                       : ior; /* 0, "infinite" by the extension, is for old models */
    if (json_extension(material, "KHR_materials_unlit")) return add_unlit(g, &s, out);
    const json_t *transmission = json_extension(material, "KHR_materials_transmission");
    if (json_number(transmission, "transmissionFactor", 0) >= 0.5 && s.metallic < 0.5)
        return add_glass(g, &s, material, out);
    if (s.metallic >= 0.5) return add_metal(g, &s, out);
    return s.roughness < 0.3 ? add_glazed(g, &s, out) : add_glossy(g, &s, s.name, out);
}

snell_status gltf_material(gltf *g, size_t index, uint32_t *out) {
    bool none = index == SIZE_MAX;
    uint32_t *made = none ? &g->default_material : &g->materials[index];
    snell_status status = SNELL_OK;
    char where[JSON_PATH_SIZE] = "the default material";
    if (!none) snprintf(where, sizeof where, "materials[%zu]", index);
    if (*made == NO_MATERIAL)
        status = make_material(g, none ? NULL : json_item(g, "materials", index), where, made);
    *out = *made;
    return status;
}

unsigned gltf_material_uv_set(const gltf *g, size_t index) {
    return uv_set(main_texture(index == SIZE_MAX ? NULL : json_item(g, "materials", index)));
}

bool gltf_material_has_alpha(const gltf *g, size_t index) {
    const json_t *material = index == SIZE_MAX ? NULL : json_item(g, "materials", index);
    const char *mode = json_text(material, "alphaMode");
    return mode && strcmp(mode, "OPAQUE") != 0;
}
