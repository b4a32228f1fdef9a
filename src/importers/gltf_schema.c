/* The types, ranges and references of glTF's properties, as tables, checked once for the whole file
 * whether or not a property is used: a file that breaks its own format gets an error that names the
 * place. Empty arrays, which the format forbids and which do no harm, are warnings. Properties that
 * no table names are ignored, as the specification asks. */
#include "importers/gltf.h"

#include <stdio.h>
#include <string.h>

typedef enum rule_kind {
    RULE_INT,    /* whole number in min..max (max 0: 2^53) */
    RULE_NUMBER, /* finite number in min..max (both 0: any) */
    RULE_BOOL,
    RULE_STRING,
    RULE_OBJECT,  /* as `object` says */
    RULE_REF,     /* index into the file's array `list` */
    RULE_NUMBERS, /* `length` numbers (0: any), each in min..max */
    RULE_STRINGS,
    RULE_REFS,
    RULE_OBJECTS,
    RULE_ATTRIBUTES, /* an object whose values are all indices into `list` */
    RULE_TARGETS     /* an array of those */
} rule_kind;

typedef struct rule {
    const char *name;
    rule_kind kind;
    bool required;
    double min, max;
    const char *list;
    const struct rule *object;
    size_t length;
} rule;

#define UNIT .min = 0, .max = 1
#define FROM_ZERO .min = 0, .max = INFINITY

static const rule texture_transform[] = {{.name = "offset", RULE_NUMBERS, .length = 2},
                                         {.name = "rotation", RULE_NUMBER},
                                         {.name = "scale", RULE_NUMBERS, .length = 2},
                                         {.name = "texCoord", RULE_INT},
                                         {0}};
static const rule texture_info_extensions[] = {
    {.name = "KHR_texture_transform", RULE_OBJECT, .object = texture_transform}, {0}};
static const rule texture_info[] = {
    {.name = "index", RULE_REF, true, .list = "textures"},
    {.name = "texCoord", RULE_INT},
    {.name = "scale", RULE_NUMBER},
    {.name = "strength", RULE_NUMBER, UNIT},
    {.name = "extensions", RULE_OBJECT, .object = texture_info_extensions},
    {0}};
static const rule metallic_roughness[] = {
    {.name = "baseColorFactor", RULE_NUMBERS, .length = 4, UNIT},
    {.name = "baseColorTexture", RULE_OBJECT, .object = texture_info},
    {.name = "metallicFactor", RULE_NUMBER, UNIT},
    {.name = "roughnessFactor", RULE_NUMBER, UNIT},
    {.name = "metallicRoughnessTexture", RULE_OBJECT, .object = texture_info},
    {0}};
static const rule emissive_strength[] = {{.name = "emissiveStrength", RULE_NUMBER, FROM_ZERO}, {0}};
static const rule transmission[] = {
    {.name = "transmissionFactor", RULE_NUMBER, UNIT},
    {.name = "transmissionTexture", RULE_OBJECT, .object = texture_info},
    {0}};
static const rule ior[] = {{.name = "ior", RULE_NUMBER, FROM_ZERO}, {0}};
static const rule volume[] = {{.name = "thicknessFactor", RULE_NUMBER, FROM_ZERO},
                              {.name = "thicknessTexture", RULE_OBJECT, .object = texture_info},
                              {.name = "attenuationDistance", RULE_NUMBER, FROM_ZERO},
                              {.name = "attenuationColor", RULE_NUMBERS, .length = 3, UNIT},
                              {0}};
static const rule specular[] = {
    {.name = "specularFactor", RULE_NUMBER, UNIT},
    {.name = "specularTexture", RULE_OBJECT, .object = texture_info},
    {.name = "specularColorFactor", RULE_NUMBERS, .length = 3, FROM_ZERO},
    {.name = "specularColorTexture", RULE_OBJECT, .object = texture_info},
    {0}};
static const rule clearcoat[] = {
    {.name = "clearcoatFactor", RULE_NUMBER, UNIT},
    {.name = "clearcoatTexture", RULE_OBJECT, .object = texture_info},
    {.name = "clearcoatRoughnessFactor", RULE_NUMBER, UNIT},
    {.name = "clearcoatRoughnessTexture", RULE_OBJECT, .object = texture_info},
    {.name = "clearcoatNormalTexture", RULE_OBJECT, .object = texture_info},
    {0}};
static const rule sheen[] = {{.name = "sheenColorFactor", RULE_NUMBERS, .length = 3, UNIT},
                             {.name = "sheenColorTexture", RULE_OBJECT, .object = texture_info},
                             {.name = "sheenRoughnessFactor", RULE_NUMBER, UNIT},
                             {.name = "sheenRoughnessTexture", RULE_OBJECT, .object = texture_info},
                             {0}};
static const rule anisotropy[] = {
    {.name = "anisotropyStrength", RULE_NUMBER, UNIT},
    {.name = "anisotropyRotation", RULE_NUMBER},
    {.name = "anisotropyTexture", RULE_OBJECT, .object = texture_info},
    {0}};
static const rule iridescence[] = {
    {.name = "iridescenceFactor", RULE_NUMBER, UNIT},
    {.name = "iridescenceTexture", RULE_OBJECT, .object = texture_info},
    {.name = "iridescenceIor", RULE_NUMBER, .min = 1, .max = INFINITY},
    {.name = "iridescenceThicknessMinimum", RULE_NUMBER, FROM_ZERO},
    {.name = "iridescenceThicknessMaximum", RULE_NUMBER, FROM_ZERO},
    {.name = "iridescenceThicknessTexture", RULE_OBJECT, .object = texture_info},
    {0}};
static const rule dispersion[] = {{.name = "dispersion", RULE_NUMBER, FROM_ZERO}, {0}};
static const rule specular_glossiness[] = {
    {.name = "diffuseFactor", RULE_NUMBERS, .length = 4, UNIT},
    {.name = "diffuseTexture", RULE_OBJECT, .object = texture_info},
    {.name = "specularFactor", RULE_NUMBERS, .length = 3, UNIT},
    {.name = "glossinessFactor", RULE_NUMBER, UNIT},
    {.name = "specularGlossinessTexture", RULE_OBJECT, .object = texture_info},
    {0}};
static const rule no_properties[] = {{0}};
static const rule material_extensions[] = {
    {.name = "KHR_materials_emissive_strength", RULE_OBJECT, .object = emissive_strength},
    {.name = "KHR_materials_transmission", RULE_OBJECT, .object = transmission},
    {.name = "KHR_materials_ior", RULE_OBJECT, .object = ior},
    {.name = "KHR_materials_volume", RULE_OBJECT, .object = volume},
    {.name = "KHR_materials_specular", RULE_OBJECT, .object = specular},
    {.name = "KHR_materials_clearcoat", RULE_OBJECT, .object = clearcoat},
    {.name = "KHR_materials_sheen", RULE_OBJECT, .object = sheen},
    {.name = "KHR_materials_anisotropy", RULE_OBJECT, .object = anisotropy},
    {.name = "KHR_materials_iridescence", RULE_OBJECT, .object = iridescence},
    {.name = "KHR_materials_dispersion", RULE_OBJECT, .object = dispersion},
    {.name = "KHR_materials_pbrSpecularGlossiness", RULE_OBJECT, .object = specular_glossiness},
    {.name = "KHR_materials_unlit", RULE_OBJECT, .object = no_properties},
    {0}};
static const rule material[] = {
    {.name = "name", RULE_STRING},
    {.name = "pbrMetallicRoughness", RULE_OBJECT, .object = metallic_roughness},
    {.name = "normalTexture", RULE_OBJECT, .object = texture_info},
    {.name = "occlusionTexture", RULE_OBJECT, .object = texture_info},
    {.name = "emissiveTexture", RULE_OBJECT, .object = texture_info},
    {.name = "emissiveFactor", RULE_NUMBERS, .length = 3, UNIT},
    {.name = "alphaMode", RULE_STRING},
    {.name = "alphaCutoff", RULE_NUMBER, FROM_ZERO},
    {.name = "doubleSided", RULE_BOOL},
    {.name = "extensions", RULE_OBJECT, .object = material_extensions},
    {0}};

static const rule sparse_indices[] = {{.name = "bufferView", RULE_REF, true, .list = "bufferViews"},
                                      {.name = "byteOffset", RULE_INT},
                                      {.name = "componentType", RULE_INT, true},
                                      {0}};
static const rule sparse_values[] = {{.name = "bufferView", RULE_REF, true, .list = "bufferViews"},
                                     {.name = "byteOffset", RULE_INT},
                                     {0}};
static const rule sparse[] = {{.name = "count", RULE_INT, true, .min = 1},
                              {.name = "indices", RULE_OBJECT, true, .object = sparse_indices},
                              {.name = "values", RULE_OBJECT, true, .object = sparse_values},
                              {0}};
static const rule accessor[] = {{.name = "bufferView", RULE_REF, .list = "bufferViews"},
                                {.name = "byteOffset", RULE_INT},
                                {.name = "componentType", RULE_INT, true},
                                {.name = "normalized", RULE_BOOL},
                                {.name = "count", RULE_INT, true, .min = 1},
                                {.name = "type", RULE_STRING, true},
                                {.name = "min", RULE_NUMBERS},
                                {.name = "max", RULE_NUMBERS},
                                {.name = "sparse", RULE_OBJECT, .object = sparse},
                                {0}};
static const rule buffer[] = {
    {.name = "uri", RULE_STRING}, {.name = "byteLength", RULE_INT, true, .min = 1}, {0}};
static const rule buffer_view[] = {{.name = "buffer", RULE_REF, true, .list = "buffers"},
                                   {.name = "byteOffset", RULE_INT},
                                   {.name = "byteLength", RULE_INT, true, .min = 1},
                                   {.name = "byteStride", RULE_INT, .min = 4, .max = 252},
                                   {.name = "target", RULE_INT},
                                   {0}};

static const rule perspective[] = {{.name = "aspectRatio", RULE_NUMBER, FROM_ZERO},
                                   {.name = "yfov", RULE_NUMBER, true, FROM_ZERO},
                                   {.name = "zfar", RULE_NUMBER, FROM_ZERO},
                                   {.name = "znear", RULE_NUMBER, true, FROM_ZERO},
                                   {0}};
static const rule orthographic[] = {{.name = "xmag", RULE_NUMBER, true},
                                    {.name = "ymag", RULE_NUMBER, true},
                                    {.name = "zfar", RULE_NUMBER, true, FROM_ZERO},
                                    {.name = "znear", RULE_NUMBER, true, FROM_ZERO},
                                    {0}};
static const rule camera[] = {{.name = "name", RULE_STRING},
                              {.name = "type", RULE_STRING, true},
                              {.name = "perspective", RULE_OBJECT, .object = perspective},
                              {.name = "orthographic", RULE_OBJECT, .object = orthographic},
                              {0}};

static const rule image[] = {{.name = "uri", RULE_STRING},
                             {.name = "mimeType", RULE_STRING},
                             {.name = "bufferView", RULE_REF, .list = "bufferViews"},
                             {0}};
static const rule sampler[] = {{.name = "magFilter", RULE_INT},
                               {.name = "minFilter", RULE_INT},
                               {.name = "wrapS", RULE_INT},
                               {.name = "wrapT", RULE_INT},
                               {0}};
static const rule texture_webp[] = {{.name = "source", RULE_REF, .list = "images"}, {0}};
static const rule texture_extensions[] = {
    {.name = "EXT_texture_webp", RULE_OBJECT, .object = texture_webp}, {0}};
static const rule texture[] = {{.name = "sampler", RULE_REF, .list = "samplers"},
                               {.name = "source", RULE_REF, .list = "images"},
                               {.name = "extensions", RULE_OBJECT, .object = texture_extensions},
                               {0}};

static const rule draco[] = {
    {.name = "bufferView", RULE_REF, true, .list = "bufferViews"},
    {.name = "attributes", RULE_OBJECT, true, .object = no_properties}, /* gltf_check.c */
    {0}};
static const rule primitive_extensions[] = {
    {.name = "KHR_draco_mesh_compression", RULE_OBJECT, .object = draco}, {0}};
static const rule primitive[] = {
    {.name = "attributes", RULE_ATTRIBUTES, true, .list = "accessors"},
    {.name = "indices", RULE_REF, .list = "accessors"},
    {.name = "material", RULE_REF, .list = "materials"},
    {.name = "mode", RULE_INT, .max = 6},
    {.name = "targets", RULE_TARGETS, .list = "accessors"},
    {.name = "extensions", RULE_OBJECT, .object = primitive_extensions},
    {0}};
static const rule mesh[] = {{.name = "name", RULE_STRING},
                            {.name = "primitives", RULE_OBJECTS, true, .object = primitive},
                            {.name = "weights", RULE_NUMBERS},
                            {0}};

static const rule node_light[] = {{.name = "light", RULE_INT, true}, {0}};
static const rule gpu_instancing[] = {
    {.name = "attributes", RULE_ATTRIBUTES, true, .list = "accessors"}, {0}};
static const rule node_extensions[] = {
    {.name = "KHR_lights_punctual", RULE_OBJECT, .object = node_light},
    {.name = "EXT_mesh_gpu_instancing", RULE_OBJECT, .object = gpu_instancing},
    {0}};
static const rule node[] = {{.name = "name", RULE_STRING},
                            {.name = "camera", RULE_REF, .list = "cameras"},
                            {.name = "children", RULE_REFS, .list = "nodes"},
                            {.name = "skin", RULE_REF, .list = "skins"},
                            {.name = "mesh", RULE_REF, .list = "meshes"},
                            {.name = "matrix", RULE_NUMBERS, .length = 16},
                            {.name = "translation", RULE_NUMBERS, .length = 3},
                            {.name = "rotation", RULE_NUMBERS, .length = 4, .min = -1, .max = 1},
                            {.name = "scale", RULE_NUMBERS, .length = 3},
                            {.name = "weights", RULE_NUMBERS},
                            {.name = "extensions", RULE_OBJECT, .object = node_extensions},
                            {0}};
static const rule scene[] = {
    {.name = "name", RULE_STRING}, {.name = "nodes", RULE_REFS, .list = "nodes"}, {0}};
static const rule skin[] = {{.name = "inverseBindMatrices", RULE_REF, .list = "accessors"},
                            {.name = "skeleton", RULE_REF, .list = "nodes"},
                            {.name = "joints", RULE_REFS, true, .list = "nodes"},
                            {0}};

static const rule channel_target[] = {
    {.name = "node", RULE_REF, .list = "nodes"}, {.name = "path", RULE_STRING, true}, {0}};
static const rule channel[] = {{.name = "sampler", RULE_INT, true},
                               {.name = "target", RULE_OBJECT, true, .object = channel_target},
                               {0}};
static const rule animation_sampler[] = {{.name = "input", RULE_REF, true, .list = "accessors"},
                                         {.name = "interpolation", RULE_STRING},
                                         {.name = "output", RULE_REF, true, .list = "accessors"},
                                         {0}};
static const rule animation[] = {
    {.name = "name", RULE_STRING},
    {.name = "channels", RULE_OBJECTS, true, .object = channel},
    {.name = "samplers", RULE_OBJECTS, true, .object = animation_sampler},
    {0}};

static const rule light_spot[] = {{.name = "innerConeAngle", RULE_NUMBER, FROM_ZERO},
                                  {.name = "outerConeAngle", RULE_NUMBER, FROM_ZERO},
                                  {0}};
static const rule light[] = {{.name = "name", RULE_STRING},
                             {.name = "type", RULE_STRING, true},
                             {.name = "color", RULE_NUMBERS, .length = 3, FROM_ZERO},
                             {.name = "intensity", RULE_NUMBER, FROM_ZERO},
                             {.name = "range", RULE_NUMBER, FROM_ZERO},
                             {.name = "spot", RULE_OBJECT, .object = light_spot},
                             {0}};
static const rule lights_punctual[] = {{.name = "lights", RULE_OBJECTS, true, .object = light},
                                       {0}};
static const rule root_extensions[] = {
    {.name = "KHR_lights_punctual", RULE_OBJECT, .object = lights_punctual}, {0}};

static const rule asset[] = {
    {.name = "version", RULE_STRING, true}, {.name = "minVersion", RULE_STRING}, {0}};
static const rule root[] = {{.name = "asset", RULE_OBJECT, true, .object = asset},
                            {.name = "extensionsUsed", RULE_STRINGS},
                            {.name = "extensionsRequired", RULE_STRINGS},
                            {.name = "accessors", RULE_OBJECTS, .object = accessor},
                            {.name = "animations", RULE_OBJECTS, .object = animation},
                            {.name = "buffers", RULE_OBJECTS, .object = buffer},
                            {.name = "bufferViews", RULE_OBJECTS, .object = buffer_view},
                            {.name = "cameras", RULE_OBJECTS, .object = camera},
                            {.name = "images", RULE_OBJECTS, .object = image},
                            {.name = "materials", RULE_OBJECTS, .object = material},
                            {.name = "meshes", RULE_OBJECTS, .object = mesh},
                            {.name = "nodes", RULE_OBJECTS, .object = node},
                            {.name = "samplers", RULE_OBJECTS, .object = sampler},
                            {.name = "scene", RULE_REF, .list = "scenes"},
                            {.name = "scenes", RULE_OBJECTS, .object = scene},
                            {.name = "skins", RULE_OBJECTS, .object = skin},
                            {.name = "textures", RULE_OBJECTS, .object = texture},
                            {.name = "extensions", RULE_OBJECT, .object = root_extensions},
                            {0}};

/* ---- the check ---- */

typedef struct checker {
    gltf *g;
    char path[JSON_PATH_SIZE];
    size_t length;
} checker;

/* Appends to the path; returns the old length, which path_pop takes. A path that is too long is
 * cut. */
static size_t path_push(checker *c, const char *key, size_t index, bool is_index) {
    size_t old = c->length, room = sizeof c->path - old;
    int written = is_index ? snprintf(c->path + old, room, "[%zu]", index)
                           : snprintf(c->path + old, room, "%s%.60s", old ? "." : "", key);
    c->length = (size_t)written < room ? old + (size_t)written : sizeof c->path - 1;
    return old;
}

static void path_pop(checker *c, size_t old) {
    c->length = old;
    c->path[old] = '\0';
}

static snell_status wrong(const checker *c, const char *expected) {
    return gltf_error(c->g, SNELL_ERR_SYNTAX, c->path, "must be %s", expected);
}

static snell_status check_object(checker *c, const json_t *owner, const rule *rules);

static bool is_whole(const json_t *value) {
    double number = json_number_value(value);
    return json_is_number(value) && number == floor(number) && fabs(number) <= 0x1p53;
}

static snell_status check_int(const checker *c, const json_t *value, const rule *r) {
    double number = json_number_value(value), max = r->max > 0 ? r->max : 0x1p53;
    if (!is_whole(value)) return wrong(c, "a whole number");
    if (number < r->min || number > max)
        return gltf_error(c->g, SNELL_ERR_SYNTAX, c->path, "%.17g is out of range", number);
    return SNELL_OK;
}

static snell_status check_number(const checker *c, const json_t *value, const rule *r) {
    double number = json_number_value(value);
    bool any = !(r->min < r->max);
    if (!json_is_number(value)) return wrong(c, "a number");
    if (!isfinite(number) || (!any && (number < r->min || number > r->max)))
        return gltf_error(c->g, SNELL_ERR_SYNTAX, c->path, "%g is out of range", number);
    return SNELL_OK;
}

static snell_status check_ref(const checker *c, const json_t *value, const rule *r) {
    double number = json_number_value(value);
    if (!is_whole(value)) return wrong(c, "a whole number");
    if (number < 0 || number >= (double)json_count(c->g, r->list))
        return gltf_error(c->g, SNELL_ERR_SYNTAX, c->path, "%g: there is no %s[%g]", number,
                          r->list, number);
    return SNELL_OK;
}

static snell_status check_map(checker *c, const json_t *map, const rule *r) {
    if (!json_is_object(map)) return wrong(c, "an object");
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)map, key, value) {
        size_t old = path_push(c, key, 0, false);
        snell_status status = check_ref(c, value, r);
        if (status) return status;
        path_pop(c, old);
    }
    return SNELL_OK;
}

static snell_status check_element(checker *c, const json_t *value, const rule *r) {
    switch (r->kind) {
    case RULE_NUMBERS: return check_number(c, value, r);
    case RULE_STRINGS: return json_is_string(value) ? SNELL_OK : wrong(c, "a string");
    case RULE_REFS: return check_ref(c, value, r);
    case RULE_TARGETS: return check_map(c, value, r);
    default: return check_object(c, value, r->object);
    }
}

static snell_status check_array(checker *c, const json_t *array, const rule *r) {
    size_t size = json_array_size(array);
    if (!json_is_array(array)) return wrong(c, "an array");
    if (r->length && size != r->length)
        return gltf_error(c->g, SNELL_ERR_SYNTAX, c->path, "must have %zu numbers, not %zu",
                          r->length, size);
    if (size == 0) return gltf_warn(c->g, "%s: must not be empty", c->path);
    for (size_t i = 0; i < size; i++) {
        size_t old = path_push(c, NULL, i, true);
        snell_status status = check_element(c, json_array_get(array, i), r);
        if (status) return status;
        path_pop(c, old);
    }
    return SNELL_OK;
}

static snell_status check_property(checker *c, const json_t *value, const rule *r) {
    switch (r->kind) {
    case RULE_INT: return check_int(c, value, r);
    case RULE_NUMBER: return check_number(c, value, r);
    case RULE_BOOL: return json_is_boolean(value) ? SNELL_OK : wrong(c, "true or false");
    case RULE_STRING: return json_is_string(value) ? SNELL_OK : wrong(c, "a string");
    case RULE_OBJECT: return check_object(c, value, r->object);
    case RULE_REF: return check_ref(c, value, r);
    case RULE_ATTRIBUTES: return check_map(c, value, r);
    default: return check_array(c, value, r);
    }
}

static snell_status check_object(checker *c, const json_t *owner, const rule *rules) {
    if (!json_is_object(owner)) return wrong(c, "an object");
    for (const rule *r = rules; r->name; r++) {
        const json_t *value = json_object_get(owner, r->name);
        if (value == NULL && !r->required) continue;
        size_t old = path_push(c, r->name, 0, false);
        if (value == NULL) return gltf_error(c->g, SNELL_ERR_SYNTAX, c->path, "is missing");
        snell_status status = check_property(c, value, r);
        if (status) return status;
        path_pop(c, old);
    }
    return SNELL_OK;
}

/* Words of which one must be chosen. */
static snell_status check_word(gltf *g, const char *list, const char *key, const char *words) {
    for (size_t i = 0; i < json_count(g, list); i++) {
        const char *word = json_text(json_item(g, list, i), key);
        if (word && choice_find(words, word) < 0) {
            char path[JSON_PATH_SIZE];
            snprintf(path, sizeof path, "%s[%zu].%s", list, i, key);
            return gltf_error(g, SNELL_ERR_SYNTAX, path, "'%.40s' is not one of %s", word, words);
        }
    }
    return SNELL_OK;
}

/* What tables of single properties cannot say. */
static snell_status check_pairs(gltf *g) {
    char path[JSON_PATH_SIZE];
    for (size_t i = 0; i < json_count(g, "images"); i++) {
        const json_t *item = json_item(g, "images", i);
        snprintf(path, sizeof path, "images[%zu]", i);
        if (!json_at(item, "uri") == !json_at(item, "bufferView"))
            return gltf_error(g, SNELL_ERR_SYNTAX, path, "must have either uri or bufferView");
        if (json_at(item, "bufferView") && !json_at(item, "mimeType"))
            return gltf_error(g, SNELL_ERR_SYNTAX, path, "mimeType is missing");
    }
    for (size_t i = 0; i < json_count(g, "cameras"); i++) {
        const json_t *item = json_item(g, "cameras", i);
        const char *type = json_text(item, "type");
        snprintf(path, sizeof path, "cameras[%zu]", i);
        if (json_at(item, type) == NULL)
            return gltf_error(g, SNELL_ERR_SYNTAX, path, "%s is missing", type);
    }
    for (size_t i = 0; i < json_count(g, "nodes"); i++) {
        const json_t *item = json_item(g, "nodes", i);
        snprintf(path, sizeof path, "nodes[%zu]", i);
        if (json_at(item, "skin") && !json_at(item, "mesh"))
            return gltf_error(g, SNELL_ERR_SYNTAX, path, "a skin needs a mesh");
        if (json_at(item, "matrix") &&
            (json_at(item, "translation") || json_at(item, "rotation") || json_at(item, "scale")))
            return gltf_error(g, SNELL_ERR_SYNTAX, path,
                              "has both a matrix and a translation, rotation or scale");
    }
    return SNELL_OK;
}

snell_status gltf_check_schema(gltf *g) {
    checker c = {.g = g};
    snell_status status = check_object(&c, g->root, root);
    if (!status) status = check_word(g, "materials", "alphaMode", "OPAQUE|MASK|BLEND");
    if (!status) status = check_word(g, "cameras", "type", "perspective|orthographic");
    if (!status)
        status = check_word(g, "accessors", "type", "SCALAR|VEC2|VEC3|VEC4|MAT2|MAT3|MAT4");
    return status ? status : check_pairs(g);
}
