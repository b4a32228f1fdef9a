/* glTF textures and materials; docs/formats.md has the table. */
#include "importers/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/params.h"
#include "maths/functions.h"

/* ---- images ---- */

/* A wrong word does no harm: the bytes say what they are. */
static snell_status check_media_type(gltf *g, size_t index, const byte_block *bytes) {
    const json_t *image = json_item(g, "images", index);
    const char *uri = json_text(image, "uri"), *said = json_text(image, "mimeType"),
               *held = image_media_type(bytes->data, bytes->size);
    snell_status status = SNELL_OK;
    if (said && held && strcmp(said, held) != 0)
        status = gltf_warn(g, "images[%zu].mimeType: says %.40s, but it is %s", index, said, held);
    if (status || held == NULL || uri == NULL || strncmp(uri, "data:", 5) != 0) return status;
    size_t length = strcspn(uri + 5, ";,");
    if (length == strlen(held) && strncmp(uri + 5, held, length) == 0) return SNELL_OK;
    return gltf_warn(g, "images[%zu].uri: says %.*s, but it is %s", index,
                     length < 40 ? (int)length : 40, uri + 5, held);
}

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
        if (!status) status = check_media_type(g, index, &bytes);
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

/* Images that no texture names are looked at too; those of textures that this reader does not show
 * need not be decoded. */
snell_status gltf_check_unused_images(gltf *g) {
    size_t count = json_count(g, "images");
    bool *named = memory_zeroed(count + 1, sizeof *named);
    if (named == NULL) return error_no_memory();
    for (size_t i = 0; i < json_count(g, "textures"); i++) {
        const json_t *texture = json_item(g, "textures", i);
        named[json_index(texture, "source", count)] = true;
        named[json_index(json_extension(texture, "EXT_texture_webp"), "source", count)] = true;
    }
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < count && !status; i++) {
        const decoded_image *image;
        if (g->images[i].tried || named[i]) continue;
        uint64_t budget = g->budget;
        status = load_image(g, i, &image);
        image_free(&g->images[i].image);
        g->budget = budget;
    }
    free(named);
    return status;
}

/* ---- textures ---- */

/* USE_RED and so on: one channel as data. */
enum { USE_COLOR, USE_ALPHA, USE_DATA, USE_RED, USE_GREEN, USE_BLUE };

/* What becomes of a channel, 0..1: at + slope times it. */
typedef struct ramp {
    float at, slope;
} ramp;
static const ramp as_it_is = {0, 1};

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
                                const texture_entry *key, const decoded_image *pixels,
                                snell_texture_id *out) {
    const float *placing = key->transform;
    const json_t *sampler =
        sampler_index == SIZE_MAX ? NULL : json_item(g, "samplers", sampler_index);
    size_t filter = json_index(sampler, "magFilter", GL_LINEAR);
    size_t size = (size_t)pixels->width * pixels->height * pixels->channels;
    snell_param list[] = {
        {"width", SNELL_PARAM_INT, {.i = pixels->width}},
        {"height", SNELL_PARAM_INT, {.i = pixels->height}},
        {"format", SNELL_PARAM_STRING, {.s = image_format_word(pixels)}},
        {"pixels", SNELL_PARAM_ARRAY, {.array = {pixels->pixels, size}}},
        {"encoding", SNELL_PARAM_STRING, {.s = key->use == USE_COLOR ? "srgb" : "linear"}},
        {"wrap_u", SNELL_PARAM_STRING, {.s = wrap_word(json_index(sampler, "wrapS", GL_REPEAT))}},
        {"wrap_v", SNELL_PARAM_STRING, {.s = wrap_word(json_index(sampler, "wrapT", GL_REPEAT))}},
        {"filter", SNELL_PARAM_STRING, {.s = filter == GL_NEAREST ? "nearest" : "linear"}},
        {"map", SNELL_PARAM_STRING, {.s = key->second ? "uv2" : "uv"}},
        {"uv_offset", SNELL_PARAM_VEC3, {.v = turned_offset(placing)}},
        {"uv_scale", SNELL_PARAM_VEC3, {.v = {placing[3], placing[4], 0}}},
        {"uv_rotation", SNELL_PARAM_FLOAT, {.f = (double)placing[2]}},
    };
    uint32_t index;
    snell_status status = gltf_spend(g, where, size);
    if (!status)
        status =
            description_add(g->d, CATEGORY_TEXTURE, "image", list, sizeof list / sizeof list[0],
                            (object_source){NULL, g->path, 0}, &index);
    if (status) return gltf_blame(g, where, status);
    *out = (snell_texture_id){index + 1, g->d->objects[CATEGORY_TEXTURE].items[index].generation};
    return SNELL_OK;
}

static texture_entry *find_texture(gltf *g, const texture_entry *key) {
    for (size_t i = 0; i < g->texture_count; i++) {
        texture_entry *t = &g->textures[i];
        if (t->texture == key->texture && t->use == key->use && t->second == key->second &&
            memcmp(t->ramp, key->ramp, sizeof key->ramp) == 0 &&
            memcmp(t->transform, key->transform, sizeof key->transform) == 0)
            return t;
    }
    return NULL;
}

/* The image that a texture of the file shows; SIZE_MAX: none that can be read. */
static size_t texture_image(const gltf *g, size_t texture) {
    const json_t *item = json_item(g, "textures", texture);
    size_t plain = json_index(item, "source", SIZE_MAX);
    if (!SNELL_HAS_WEBP && plain != SIZE_MAX) return plain;
    return json_index(json_extension(item, "EXT_texture_webp"), "source", plain);
}

static snell_status copy_part(const decoded_image *image, const texture_entry *key,
                              decoded_image *out) {
    int use = key->use;
    float at = key->ramp[0], slope = key->ramp[1];
    snell_status status = use == USE_ALPHA ? image_copy_alpha(image, out)
                          : use >= USE_RED
                              ? image_copy_channel(image, (uint32_t)(use - USE_RED), out)
                              : image_copy_color(image, out);
    if (status || (at == 0 && slope == 1)) return status;
    size_t size = (size_t)out->width * out->height * out->channels;
    for (size_t i = 0; i < size; i++)
        out->pixels[i] =
            (uint8_t)(clamp01((double)at + (double)slope * out->pixels[i] / 255) * 255 + 0.5);
    return status;
}

/* ---- sets of texture coordinates: a mesh keeps two, chosen by its material ---- */

static unsigned uv_set(const json_t *info) {
    const json_t *changed = json_extension(info, "KHR_texture_transform");
    return (unsigned)json_index(changed, "texCoord", json_index(info, "texCoord", 0)) & 0xff;
}

/* Whose texture coordinates come first. */
static const json_t *main_texture(const json_t *material) {
    const json_t *base = json_at(json_at(material, "pbrMetallicRoughness"), "baseColorTexture"),
                 *glossy = json_extension(material, "KHR_materials_pbrSpecularGlossiness"),
                 *emissive = json_at(material, "emissiveTexture");
    const json_t *normal = json_at(material, "normalTexture");
    if (json_at(glossy, "diffuseTexture")) base = json_at(glossy, "diffuseTexture");
    if (base || emissive || normal) return base ? base : emissive ? emissive : normal;
    return json_at(json_at(material, "pbrMetallicRoughness"), "metallicRoughnessTexture");
}

/* Is it a texture that this reader shows? */
static bool is_texture(const char *key) {
    static const char *const lost[] = {"occlusionTexture", "thicknessTexture"};
    size_t length = strlen(key);
    for (size_t i = 0; i < sizeof lost / sizeof lost[0]; i++)
        if (strcmp(key, lost[i]) == 0) return false;
    return length > 7 && strcmp(key + length - 7, "Texture") == 0;
}

/* The lowest set besides the first that textures in `value` use; the depth of the JSON is bounded. */
static unsigned second_set(const json_t *value, unsigned first) {
    unsigned found = NO_UV_SET;
    const char *key;
    json_t *inner;
    json_object_foreach((json_t *)(uintptr_t)value, key, inner) {
        if (!json_is_object(inner)) continue;
        unsigned set = is_texture(key) ? uv_set(inner) : second_set(inner, first);
        if (set != first && set < found) found = set;
    }
    return found;
}

void gltf_material_uv_sets(const gltf *g, size_t index, unsigned sets[2]) {
    sets[0] = 0;
    sets[1] = NO_UV_SET;
    if (index == SIZE_MAX) return;
    unsigned *known = g->uv_sets_of[index];
    if (known[0] == 0) {
        const json_t *material = json_item(g, "materials", index);
        unsigned first = uv_set(main_texture(material));
        known[0] = first + 1;
        known[1] = second_set(material, first) + 1;
    }
    sets[0] = known[0] - 1;
    sets[1] = known[1] - 1;
}

/* Which of the material's two sets a texture uses. */
static snell_status choose_set(gltf *g, const json_t *info, bool *second) {
    unsigned set = uv_set(info);
    *second = set != g->uv_sets[0];
    if (!*second || set == g->uv_sets[1]) return SNELL_OK;
    *second = false;
    return gltf_warn(g,
                     "a material's textures use three sets of texture coordinates: two are kept, "
                     "and the third looks up as the base colour does");
}

/* The texture of a textureInfo, made once per use; id 0 when its image is missing, or when its
 * alpha is wanted and it is opaque everywhere. */
static snell_status gltf_texture(gltf *g, const json_t *info, int use, ramp change,
                                 snell_texture_id *out) {
    *out = (snell_texture_id){0, 0};
    if (info == NULL) return SNELL_OK;
    texture_entry key = {.texture = (uint32_t)json_index(info, "index", 0),
                         .use = use,
                         .ramp = {change.at, change.slope}};
    read_transform(info, key.transform);
    snell_status status = choose_set(g, info, &key.second);
    if (status) return status;
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
    status = load_image(g, image_index, &image);
    if (status) return status;
    if (image && (use != USE_ALPHA || image_has_alpha(image))) {
        decoded_image part;
        status = copy_part(image, &key, &part);
        if (!status) {
            size_t sampler = json_index(json_item(g, "textures", key.texture), "sampler", SIZE_MAX);
            status = add_texture(g, where, sampler, &key, &part, &key.id);
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

/* ---- materials ---- */

/* The extensions' part of `principled`. */
typedef struct layers {
    snell_input specular, specular_color, transmission, clearcoat, clearcoat_roughness, sheen_color,
        sheen_roughness;
    double thickness, attenuation_distance, dispersion;
    snell_vec3 attenuation_color;
    snell_input anisotropy, iridescence, film_thickness;
    snell_texture_id grain, coat_normals;
    double grain_rotation, film_ior, coat_normal_scale;
    bool has_specular, has_clearcoat, has_sheen, has_grain, has_film;
} layers;

typedef struct surface {
    const char *where, *name;
    snell_input base, emission, alpha;
    snell_texture_id normal_map;
    double normal_scale;
    bool has_emission, has_alpha, two_sided;
    snell_input metallic, roughness;
    double cutoff, ior, opacity;
    layers layers;
} surface;

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

static void add_layers(params *p, const layers *k) {
    if (k->has_specular) {
        add_input(p, "specular", k->specular);
        add_input(p, "specular_color", k->specular_color);
    }
    if (vec3_largest(k->transmission.value) > 0) {
        add_input(p, "transmission", k->transmission);
        add_float(p, "thickness", k->thickness);
        if (k->dispersion > 0) add_float(p, "dispersion", k->dispersion);
    }
    if (k->attenuation_distance > 0) {
        add_param(
            p, (snell_param){"attenuation_color", SNELL_PARAM_VEC3, {.v = k->attenuation_color}});
        add_float(p, "attenuation_distance", k->attenuation_distance);
    }
    if (k->has_clearcoat) {
        add_input(p, "clearcoat", k->clearcoat);
        add_input(p, "clearcoat_roughness", k->clearcoat_roughness);
    }
    if (k->coat_normals.index1) {
        add_param(p, (snell_param){"clearcoat_normal_map",
                                   SNELL_PARAM_TEXTURE,
                                   {.texture = k->coat_normals}});
        add_float(p, "clearcoat_normal_scale", k->coat_normal_scale);
    }
    if (k->has_sheen) {
        add_input(p, "sheen_color", k->sheen_color);
        add_input(p, "sheen_roughness", k->sheen_roughness);
    }
    if (k->has_grain) {
        add_input(p, "anisotropy", k->anisotropy);
        add_float(p, "anisotropy_rotation", k->grain_rotation);
        add_param(p, (snell_param){"anisotropy_map", SNELL_PARAM_TEXTURE, {.texture = k->grain}});
    }
    if (k->has_film) {
        add_input(p, "iridescence", k->iridescence);
        add_float(p, "iridescence_ior", k->film_ior);
        add_input(p, "iridescence_thickness", k->film_thickness);
    }
}

static snell_status add_principled(gltf *g, const surface *s, uint32_t *out) {
    params p = {.count = 0};
    add_input(&p, "base_color", s->base);
    add_input(&p, "metallic", s->metallic);
    add_input(&p, "roughness", s->roughness);
    add_float(&p, "ior", s->ior);
    add_layers(&p, &s->layers);
    add_common(&p, s);
    return add_material(g, s, "principled", &p, s->name, out);
}

/* One warning for everything that a material has and this version does not show. */
static snell_status warn_of_losses(gltf *g, const json_t *material) {
    snell_status status = SNELL_OK;
    if (json_at(material, "occlusionTexture"))
        status = gltf_warn(g, "occlusion maps are ignored: what hides light is computed");
    bool passes = json_number(json_extension(material, "KHR_materials_transmission"),
                              "transmissionFactor", 0) > 0;
    const json_t *thin = json_extension(material, "KHR_materials_iridescence"),
                 *grain = json_extension(material, "KHR_materials_anisotropy");
    if (!status && passes && json_number(thin, "iridescenceFactor", 0) > 0)
        status = gltf_warn(g, "the iridescence of what transmits is not supported: ignored");
    if (!status && passes && json_number(grain, "anisotropyStrength", 0) > 0)
        status = gltf_warn(g, "the anisotropy of what transmits is not supported: ignored");
    return status;
}

/* ---- reading ---- */

static snell_status read_normals(gltf *g, const json_t *info, snell_texture_id *map,
                                 double *scale) {
    *scale = json_number(info, "scale", 1);
    return gltf_texture(g, info, USE_DATA, as_it_is, map);
}

/* A factor times one channel of a texture. */
static snell_status read_scalar(gltf *g, const json_t *from, const char *factor, double otherwise,
                                const char *texture, int use, snell_input *out) {
    *out = grey(json_number(from, factor, otherwise));
    return gltf_texture(g, json_at(from, texture), use, as_it_is, &out->texture);
}

static snell_status read_color(gltf *g, const json_t *from, const char *factor, double otherwise,
                               const char *texture, snell_input *out) {
    double c[3] = {otherwise, otherwise, otherwise};
    json_numbers(from, factor, c, 3);
    out->value = (snell_vec3){(float)c[0], (float)c[1], (float)c[2]};
    return gltf_texture(g, json_at(from, texture), USE_COLOR, as_it_is, &out->texture);
}

static void read_volume(const json_t *volume, layers *k) {
    double color[3] = {1, 1, 1};
    json_numbers(volume, "attenuationColor", color, 3);
    float *parts[] = {&k->attenuation_color.x, &k->attenuation_color.y, &k->attenuation_color.z};
    for (int i = 0; i < 3; i++) *parts[i] = (float)(color[i] < 1e-6 ? 1e-6 : color[i]);
    k->thickness = json_number(volume, "thicknessFactor", 0);
    k->attenuation_distance = json_number(volume, "attenuationDistance", 0);
}

static snell_status read_layers(gltf *g, const json_t *material, layers *k) {
    const json_t *specular = json_extension(material, "KHR_materials_specular"),
                 *clearcoat = json_extension(material, "KHR_materials_clearcoat"),
                 *sheen = json_extension(material, "KHR_materials_sheen"),
                 *transmission = json_extension(material, "KHR_materials_transmission");
    read_volume(json_extension(material, "KHR_materials_volume"), k);
    k->dispersion = double_min(
        json_number(json_extension(material, "KHR_materials_dispersion"), "dispersion", 0), 100);
    bool glossy = k->has_specular; /* read already */
    k->has_specular |= specular != NULL;
    k->has_clearcoat = json_number(clearcoat, "clearcoatFactor", 0) > 0;
    k->has_sheen = sheen != NULL;
    snell_status status = read_scalar(g, transmission, "transmissionFactor", 0,
                                      "transmissionTexture", USE_RED, &k->transmission);
    if (!status && !glossy)
        status = read_scalar(g, specular, "specularFactor", 1, "specularTexture", USE_ALPHA,
                             &k->specular);
    if (!status && !glossy)
        status = read_color(g, specular, "specularColorFactor", 1, "specularColorTexture",
                            &k->specular_color);
    if (!status)
        status = read_scalar(g, clearcoat, "clearcoatFactor", 0, "clearcoatTexture", USE_RED,
                             &k->clearcoat);
    if (!status)
        status = read_scalar(g, clearcoat, "clearcoatRoughnessFactor", 0,
                             "clearcoatRoughnessTexture", USE_GREEN, &k->clearcoat_roughness);
    if (!status && k->has_clearcoat)
        status = read_normals(g, json_at(clearcoat, "clearcoatNormalTexture"), &k->coat_normals,
                              &k->coat_normal_scale);
    if (!status)
        status = read_color(g, sheen, "sheenColorFactor", 0, "sheenColorTexture", &k->sheen_color);
    if (!status)
        status = read_scalar(g, sheen, "sheenRoughnessFactor", 0, "sheenRoughnessTexture",
                             USE_ALPHA, &k->sheen_roughness);
    return status;
}

/* KHR_materials_anisotropy: red and green are a direction, blue the strength. */
static snell_status read_grain(gltf *g, const json_t *material, layers *k) {
    const json_t *grain = json_extension(material, "KHR_materials_anisotropy");
    k->has_grain = json_number(grain, "anisotropyStrength", 0) > 0;
    if (!k->has_grain) return SNELL_OK;
    k->grain_rotation = json_number(grain, "anisotropyRotation", 0);
    snell_status status = read_scalar(g, grain, "anisotropyStrength", 0, "anisotropyTexture",
                                      USE_BLUE, &k->anisotropy);
    if (status) return status;
    return gltf_texture(g, json_at(grain, "anisotropyTexture"), USE_DATA, as_it_is, &k->grain);
}

/* KHR_materials_iridescence: the thickness goes from the minimum to the maximum with the texture's
 * green; without one it is the maximum. */
static snell_status read_film(gltf *g, const json_t *material, layers *k) {
    const json_t *about = json_extension(material, "KHR_materials_iridescence");
    k->has_film = json_number(about, "iridescenceFactor", 0) > 0;
    if (!k->has_film) return SNELL_OK;
    double ior = json_number(about, "iridescenceIor", 1.3),
           least = json_number(about, "iridescenceThicknessMinimum", 100),
           most = json_number(about, "iridescenceThicknessMaximum", 400),
           largest = double_max(double_max(least, most), 1e-3);
    k->film_ior = double_min(ior, 10);
    snell_status status = read_scalar(g, about, "iridescenceFactor", 0, "iridescenceTexture",
                                      USE_RED, &k->iridescence);
    ramp change = {(float)(least / largest), (float)((most - least) / largest)};
    k->film_thickness = grey(most);
    if (!status)
        status = gltf_texture(g, json_at(about, "iridescenceThicknessTexture"), USE_GREEN, change,
                              &k->film_thickness.texture);
    if (k->film_thickness.texture.index1) k->film_thickness.value = grey(largest).value;
    return status;
}

/* KHR_materials_pbrSpecularGlossiness: a dielectric whose reflectance at normal incidence is given.
 * principled has it as a factor of that of its ior. */
static snell_status read_glossy(gltf *g, const json_t *glossy, surface *s) {
    const double f0 = 0.04; /* of ior 1.5 */
    const json_t *map = json_at(glossy, "specularGlossinessTexture");
    double factor[4] = {1, 1, 1, 1}, gloss = json_number(glossy, "glossinessFactor", 1);
    json_numbers(glossy, "diffuseFactor", factor, 4);
    s->base.value = (snell_vec3){(float)factor[0], (float)factor[1], (float)factor[2]};
    s->opacity = factor[3];
    s->metallic = grey(0);
    s->roughness = grey(1 - gloss);
    s->layers.specular = grey(1);
    s->layers.has_specular = true;
    snell_status status =
        gltf_texture(g, json_at(glossy, "diffuseTexture"), USE_COLOR, as_it_is, &s->base.texture);
    ramp change = {1, (float)-gloss};
    if (!status) status = gltf_texture(g, map, USE_ALPHA, change, &s->roughness.texture);
    if (s->roughness.texture.index1) s->roughness.value = grey(1).value;
    snell_input *color = &s->layers.specular_color;
    if (!status)
        status = read_color(g, glossy, "specularFactor", 1, "specularGlossinessTexture", color);
    color->value.x = (float)((double)color->value.x / f0);
    color->value.y = (float)((double)color->value.y / f0);
    color->value.z = (float)((double)color->value.z / f0);
    return status;
}

static snell_status read_metallic(gltf *g, const json_t *pbr, surface *s) {
    const char *maps = "metallicRoughnessTexture";
    double factor[4] = {1, 1, 1, 1};
    json_numbers(pbr, "baseColorFactor", factor, 4);
    s->base.value = (snell_vec3){(float)factor[0], (float)factor[1], (float)factor[2]};
    s->opacity = factor[3];
    snell_status status =
        gltf_texture(g, json_at(pbr, "baseColorTexture"), USE_COLOR, as_it_is, &s->base.texture);
    if (!status) status = read_scalar(g, pbr, "metallicFactor", 1, maps, USE_BLUE, &s->metallic);
    if (!status) status = read_scalar(g, pbr, "roughnessFactor", 1, maps, USE_GREEN, &s->roughness);
    return status;
}

static snell_status read_base(gltf *g, const json_t *material, surface *s) {
    const json_t *pbr = json_at(material, "pbrMetallicRoughness"),
                 *glossy = json_extension(material, "KHR_materials_pbrSpecularGlossiness"),
                 *info =
                     glossy ? json_at(glossy, "diffuseTexture") : json_at(pbr, "baseColorTexture");
    snell_status status = glossy ? read_glossy(g, glossy, s) : read_metallic(g, pbr, s);
    if (status) return status;
    const char *mode = json_text(material, "alphaMode");
    if (mode == NULL || strcmp(mode, "OPAQUE") == 0) return SNELL_OK;
    s->cutoff = strcmp(mode, "MASK") == 0 ? json_number(material, "alphaCutoff", 0.5) : 0;
    if (strcmp(mode, "MASK") == 0 && !(s->cutoff > 0)) return SNELL_OK; /* nothing is cut */
    if (s->cutoff > 2) s->cutoff = 2;
    s->has_alpha = true;
    s->alpha = grey(s->opacity);
    return gltf_texture(g, info, USE_ALPHA, as_it_is, &s->alpha.texture);
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
    return gltf_texture(g, json_at(material, "emissiveTexture"), USE_COLOR, as_it_is,
                        &s->emission.texture);
}

static snell_status make_material(gltf *g, size_t index, const char *where, uint32_t *out) {
    const json_t *material = index == SIZE_MAX ? NULL : json_item(g, "materials", index);
    surface s = {.where = where, .name = json_text(material, "name"), .ior = 1.5};
    gltf_material_uv_sets(g, index, g->uv_sets);
    snell_status status = read_base(g, material, &s);
    if (!status) status = read_emission(g, material, &s);
    if (!status) status = warn_of_losses(g, material);
    if (!status)
        status =
            read_normals(g, json_at(material, "normalTexture"), &s.normal_map, &s.normal_scale);
    if (status) return status;
    double ior = json_number(json_extension(material, "KHR_materials_ior"), "ior", 1.5);
    s.ior = ior < 1    ? 1
            : ior > 10 ? 10
                       : ior; /* 0, "infinite" by the extension, is for old models */
    if (json_extension(material, "KHR_materials_unlit")) return add_unlit(g, &s, out);
    status = read_layers(g, material, &s.layers);
    if (!status) status = read_grain(g, material, &s.layers);
    if (!status) status = read_film(g, material, &s.layers);
    return status ? status : add_principled(g, &s, out);
}

snell_status gltf_material(gltf *g, size_t index, uint32_t *out) {
    bool none = index == SIZE_MAX;
    uint32_t *made = none ? &g->default_material : &g->materials[index];
    snell_status status = SNELL_OK;
    char where[JSON_PATH_SIZE] = "the default material";
    if (!none) snprintf(where, sizeof where, "materials[%zu]", index);
    if (*made == NO_MATERIAL) status = make_material(g, index, where, made);
    *out = *made;
    return status;
}

bool gltf_material_has_grain(const gltf *g, size_t index) {
    const json_t *material = index == SIZE_MAX ? NULL : json_item(g, "materials", index);
    return json_at(material, "normalTexture") ||
           json_at(json_extension(material, "KHR_materials_clearcoat"), "clearcoatNormalTexture") ||
           json_number(json_extension(material, "KHR_materials_anisotropy"), "anisotropyStrength",
                       0) > 0;
}

bool gltf_material_has_alpha(const gltf *g, size_t index) {
    const json_t *material = index == SIZE_MAX ? NULL : json_item(g, "materials", index);
    const char *mode = json_text(material, "alphaMode");
    return mode && strcmp(mode, "OPAQUE") != 0;
}
