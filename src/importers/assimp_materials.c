/* Materials of what libassimp reads; docs/formats.md has the table. */
#include <assimp/cimport.h>
#include <assimp/material.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/assimp_reader.h"
#include "importers/params.h"
#include "maths/functions.h"

/* ---- textures ---- */

/* "*3": a texture inside the file. Only compressed ones (height 0) are images as we know them. */
static snell_status embedded_image(reader *r, const char *path, decoded_image *out) {
    unsigned long index = strtoul(path + 1, NULL, 10);
    const struct aiTexture *t = index < r->scene->mNumTextures ? r->scene->mTextures[index] : NULL;
    if (t == NULL || t->mHeight != 0 || t->pcData == NULL)
        return error_set(SNELL_ERR_UNSUPPORTED, NULL, "an embedded texture that cannot be read");
    return image_decode(t->pcData, t->mWidth, IMAGE_SIZE_MAX, out);
}

static snell_status load_image(reader *r, const char *path, decoded_image *out) {
    return path[0] == '*' ? embedded_image(r, path, out) : map_load(r->path, path, r->options, out);
}

static const char *wrap_word(enum aiTextureMapMode mode) {
    return mode == aiTextureMapMode_Clamp || mode == aiTextureMapMode_Decal ? "clamp"
           : mode == aiTextureMapMode_Mirror                                ? "mirror"
                                                                            : "repeat";
}

/* One texture for a path and a use; an image that cannot be read is a warning and id 0. An opacity
 * map with alpha is meant by its alpha, others by their grey. */
static snell_status make_texture(reader *r, const char *path, map_use use,
                                 const enum aiTextureMapMode modes[2], snell_texture_id *out) {
    decoded_image image;
    snell_status status = load_image(r, path, &image);
    if (status == SNELL_ERR_MEMORY) return status;
    if (status) {
        char text[400];
        snprintf(text, sizeof text, "%s", error_last()->text);
        return reader_warn(r, "texture '%.200s': %s; the plain colour is used", path, text);
    }
    map_look look = {.use = use, .wrap = {wrap_word(modes[0]), wrap_word(modes[1])}};
    if (use == MAP_LINEAR && image_has_alpha(&image)) look.use = MAP_ALPHA;
    status = map_add(r->d, r->path, &image, &look, out);
    image_free(&image);
    return status;
}

static snell_status find_texture(reader *r, const struct aiMaterial *m, enum aiTextureType type,
                                 map_use use, snell_texture_id *out) {
    struct aiString path;
    enum aiTextureMapMode modes[2] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
    *out = (snell_texture_id){0, 0};
    if (aiGetMaterialTexture(m, type, 0, &path, NULL, NULL, NULL, NULL, modes, NULL) !=
            aiReturn_SUCCESS ||
        path.length == 0)
        return SNELL_OK;
    for (size_t i = 0; i < r->map_count; i++)
        if (r->maps[i].use == use && strcmp(r->maps[i].path, path.data) == 0) {
            *out = r->maps[i].id;
            return SNELL_OK;
        }
    snell_status status = make_texture(r, path.data, use, modes, out);
    if (status) return status;
    char *copy = memory_copy_string(path.data);
    if (copy == NULL || !ARRAY_GROW(r->maps, r->map_count, r->map_capacity, 1)) {
        free(copy);
        return error_no_memory();
    }
    r->maps[r->map_count++] = (map_entry){copy, use, *out};
    return SNELL_OK;
}

/* ---- numbers ---- */

static double limited(double value, double low, double high) {
    return value >= low ? value < high ? value : high : low; /* NaN becomes low */
}

static snell_vec3 get_color(const struct aiMaterial *m, const char *key, double otherwise) {
    struct aiColor4D c;
    float v = (float)otherwise;
    if (aiGetMaterialColor(m, key, 0, 0, &c) != aiReturn_SUCCESS) return (snell_vec3){v, v, v};
    return (snell_vec3){(float)limited((double)c.r, 0, 1e6), (float)limited((double)c.g, 0, 1e6),
                        (float)limited((double)c.b, 0, 1e6)};
}

static double get_float(const struct aiMaterial *m, const char *key, double otherwise) {
    float value;
    if (aiGetMaterialFloatArray(m, key, 0, 0, &value, NULL) != aiReturn_SUCCESS) return otherwise;
    return (double)value;
}

/* ---- materials ---- */

typedef struct look {
    const char *name;
    snell_input color, specular, alpha, emission;
    bool has_alpha;
    double exponent, ior;
    bool has_facets; /* a roughness or metalness */
    double roughness, metallic, clearcoat, clearcoat_roughness;
} look;

static snell_status add(reader *r, const look *k, const char *type, params *p, uint32_t *out) {
    if (vec3_largest(k->emission.value) > 0) add_input(p, "emission", k->emission);
    if (k->has_alpha) add_input(p, "alpha", k->alpha);
    char name[NAME_MAX_SIZE];
    snell_status status = names_make_unique(&r->names, CATEGORY_MATERIAL, k->name, name);
    if (status) return status;
    object_source source = {name[0] ? name : NULL, r->path, 0};
    status = description_add(r->d, CATEGORY_MATERIAL, type, p->list, p->count, source, out);
    return reader_blame(r, "material", status);
}

static snell_status add_lambert(reader *r, const look *k, uint32_t *out) {
    params p = {.count = 0};
    add_input(&p, "color", k->color);
    return add(r, k, "lambert", &p, out);
}

/* These formats add Kd (n.l) and Ks (n.h)^Ns under the same light; our diffuse term is Kd / pi, so k_s = Ks
 * / pi keeps their proportion. */
static snell_status add_glossy(reader *r, const look *k, uint32_t *out) {
    params p = {.count = 0};
    snell_input specular = k->specular;
    specular.value = vec3_scale(specular.value, (float)(1 / PI));
    add_input(&p, "color", k->color);
    add_input(&p, "specular", specular);
    add_float(&p, "exponent", k->exponent);
    return add(r, k, "blinn_phong", &p, out);
}

static snell_status add_principled(reader *r, const look *k, uint32_t *out) {
    params p = {.count = 0};
    add_input(&p, "base_color", k->color);
    add_float(&p, "metallic", k->metallic);
    add_float(&p, "roughness", k->roughness);
    add_float(&p, "ior", k->ior);
    add_float(&p, "clearcoat", k->clearcoat);
    add_float(&p, "clearcoat_roughness", k->clearcoat_roughness);
    return add(r, k, "principled", &p, out);
}

static bool has_float(const struct aiMaterial *m, const char *key) {
    float value;
    return aiGetMaterialFloatArray(m, key, 0, 0, &value, NULL) == aiReturn_SUCCESS;
}

static void read_facets(const struct aiMaterial *m, look *k) {
    k->has_facets = has_float(m, "$mat.roughnessFactor") || has_float(m, "$mat.metallicFactor");
    k->roughness = limited(get_float(m, "$mat.roughnessFactor", 0.5), 0, 1);
    k->metallic = limited(get_float(m, "$mat.metallicFactor", 0), 0, 1);
    k->clearcoat = limited(get_float(m, "$mat.clearcoat.factor", 0), 0, 1);
    k->clearcoat_roughness = limited(get_float(m, "$mat.clearcoat.roughnessFactor", 0), 0, 1);
}

static snell_status add_by_look(reader *r, const look *k, uint32_t *out) {
    bool shiny = vec3_largest(k->specular.value) > 0 && k->exponent > 0;
    if (k->has_facets) return add_principled(r, k, out);
    return shiny ? add_glossy(r, k, out) : add_lambert(r, k, out);
}

static snell_status read_alpha(reader *r, const struct aiMaterial *m, look *k) {
    double opacity = get_float(m, "$mat.opacity", 1);
    snell_status status = find_texture(r, m, aiTextureType_OPACITY, MAP_LINEAR, &k->alpha.texture);
    if (status) return status;
    if (!(opacity > 0)) { /* exporters that mean the opposite */
        status = reader_warn(r, "material '%.100s' is wholly transparent: drawn opaque", k->name);
        opacity = 1;
    }
    float value = (float)limited(opacity, 0, 1);
    k->alpha.value = (snell_vec3){value, value, value};
    k->has_alpha = value < 1 || k->alpha.texture.index1;
    return status;
}

static snell_status warn_of_losses(reader *r, const struct aiMaterial *m) {
    static const enum aiTextureType types[] = {
        aiTextureType_SPECULAR, aiTextureType_NORMALS,      aiTextureType_HEIGHT,
        aiTextureType_EMISSIVE, aiTextureType_DISPLACEMENT, aiTextureType_REFLECTION};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++)
        if (aiGetMaterialTextureCount(m, types[i]) > 0)
            return reader_warn(r, "maps other than of colour and opacity are not supported yet");
    return SNELL_OK;
}

static snell_status read_material(reader *r, const struct aiMaterial *m, uint32_t *out) {
    struct aiString name = {0};
    look k = {0};
    if (aiGetMaterialString(m, AI_MATKEY_NAME, &name) == aiReturn_SUCCESS) k.name = name.data;
    if (k.name == NULL) k.name = "";
    snell_status status = find_texture(r, m, aiTextureType_DIFFUSE, MAP_COLOR, &k.color.texture);
    if (!status && !k.color.texture.index1)
        status = find_texture(r, m, aiTextureType_BASE_COLOR, MAP_COLOR, &k.color.texture);
    if (!status) status = read_alpha(r, m, &k);
    if (!status) status = warn_of_losses(r, m);
    if (status) return status;
    k.color.value = get_color(m, "$clr.diffuse", 0.8);
    /* A black Kd under a map: exporters that leave the colour to the map. */
    if (k.color.texture.index1 && !(vec3_largest(k.color.value) > 0))
        k.color.value = (snell_vec3){1, 1, 1};
    k.specular.value = get_color(m, "$clr.specular", 0);
    k.emission.value = get_color(m, "$clr.emissive", 0);
    k.exponent = limited(get_float(m, "$mat.shininess", 0), 0, 1e5);
    double ior = get_float(m, "$mat.refracti", 1.5);
    k.ior = ior > 1 && ior <= 10 ? ior : 1.5;
    read_facets(m, &k);
    return add_by_look(r, &k, out);
}

snell_status reader_read_materials(reader *r) {
    snell_status status = SNELL_OK;
    for (unsigned i = 0; i < r->scene->mNumMaterials && !status; i++)
        status = read_material(r, r->scene->mMaterials[i], &r->materials[i]);
    return status;
}
