/* glTF 2.0: container, versions, extensions, and the order of work. */
#include "importers/gltf.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/files.h"

/* ---- messages ---- */

static source_place place_of(const gltf *g) { return (source_place){g->path, 0, 0}; }

snell_status gltf_error(const gltf *g, snell_status status, const char *where, const char *format,
                        ...) {
    char text[800];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return error_set_at(status, place_of(g), NULL, "%s%s%s", where, *where ? ": " : "", text);
}

snell_status gltf_blame(const gltf *g, const char *where, snell_status status) {
    if (status == SNELL_OK || status == SNELL_ERR_MEMORY) return status;
    char text[800], hint[400];
    snprintf(text, sizeof text, "%s", error_last()->text);
    snprintf(hint, sizeof hint, "%s", error_last()->hint);
    return error_set_at(status == SNELL_ERR_ARGUMENT ? SNELL_ERR_SYNTAX : status, place_of(g),
                        hint[0] ? hint : NULL, "%s: %s", where, text);
}

snell_status gltf_warn(gltf *g, const char *format, ...) {
    char text[800];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return description_add_message(g->d, SNELL_WARNING, g->path, 0, NULL, "%s", text);
}

snell_status gltf_spend(gltf *g, const char *where, uint64_t size) {
    if (size > g->budget)
        return gltf_error(g, SNELL_ERR_MEMORY, where,
                          "the file asks for more memory than it may have");
    g->budget -= size;
    return SNELL_OK;
}

/* ---- JSON values ---- */

double json_number(const json_t *owner, const char *key, double otherwise) {
    const json_t *value = json_object_get(owner, key);
    return json_is_number(value) ? json_number_value(value) : otherwise;
}

size_t json_index(const json_t *owner, const char *key, size_t otherwise) {
    const json_t *value = json_object_get(owner, key);
    return json_is_number(value) ? (size_t)json_number_value(value) : otherwise;
}

const char *json_text(const json_t *owner, const char *key) {
    return json_string_value(json_object_get(owner, key));
}

bool json_flag(const json_t *owner, const char *key) {
    return json_is_true(json_object_get(owner, key));
}

void json_numbers(const json_t *owner, const char *key, double *out, size_t count) {
    const json_t *list = json_object_get(owner, key);
    for (size_t i = 0; i < count && i < json_array_size(list); i++)
        out[i] = json_number_value(json_array_get(list, i));
}

/* ---- GLB: a 12-byte header, then chunks {length, type, data}; little endian ---- */

enum { GLB_HEADER_SIZE = 12, GLB_CHUNK_HEADER_SIZE = 8 };
static const uint32_t glb_magic = 0x46546c67, glb_json = 0x4e4f534a, glb_bin = 0x004e4942;

static uint32_t read_u32(const uint8_t *p) {
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static snell_status glb_error(const gltf *g, const char *text) {
    return gltf_error(g, SNELL_ERR_SYNTAX, "", "broken GLB: %s", text);
}

/* One chunk after the header; *at moves on. */
static snell_status glb_take_chunk(gltf *g, const uint8_t *data, size_t length, size_t *at,
                                   int number, byte_block *json) {
    if (length - *at < GLB_CHUNK_HEADER_SIZE)
        return glb_error(g, "it ends inside a chunk's header");
    uint32_t size = read_u32(data + *at), type = read_u32(data + *at + 4);
    *at += GLB_CHUNK_HEADER_SIZE;
    if (size > length - *at) return glb_error(g, "a chunk is longer than the file");
    if (number == 0) {
        if (type != glb_json) return glb_error(g, "the first chunk is not JSON");
        if (size == 0) return glb_error(g, "the JSON chunk is empty");
        *json = (byte_block){.data = data + *at, .size = size};
    } else if (type == glb_json) {
        return glb_error(g, "it has two JSON chunks");
    } else if (type == glb_bin) {
        if (g->has_bin) return glb_error(g, "it has two BIN chunks");
        if (number != 1) return glb_error(g, "the BIN chunk is not the second");
        g->has_bin = true, g->bin = data + *at, g->bin_size = size;
    }
    *at += size;
    return SNELL_OK;
}

static snell_status glb_split(gltf *g, const uint8_t *data, size_t size, byte_block *json) {
    if (size < GLB_HEADER_SIZE) return glb_error(g, "it ends inside the header");
    uint32_t version = read_u32(data + 4);
    size_t length = read_u32(data + 8);
    if (version != 2)
        return gltf_error(g, SNELL_ERR_UNSUPPORTED, "", "GLB version %u cannot be read, only 2",
                          version);
    if (length > size) return glb_error(g, "the file is shorter than its header says");
    if (length < GLB_HEADER_SIZE + GLB_CHUNK_HEADER_SIZE)
        return glb_error(g, "there is no room for a chunk");
    snell_status status = SNELL_OK;
    if (length < size)
        status = gltf_warn(g, "%zu bytes after the end of the GLB are ignored", size - length);
    size_t at = GLB_HEADER_SIZE;
    for (int number = 0; !status && at < length; number++)
        status = glb_take_chunk(g, data, length, &at, number, json);
    return status;
}

static snell_status parse_json(gltf *g, const uint8_t *data, size_t size) {
    static const uint8_t bom[] = {0xef, 0xbb, 0xbf};
    if (size >= 3 && memcmp(data, bom, 3) == 0) {
        data += 3, size -= 3;
        snell_status status = gltf_warn(g, "the JSON begins with a byte order mark");
        if (status) return status;
    }
    json_error_t error;
    g->root = json_loadb((const char *)data, size, 0, &error);
    if (g->root) return SNELL_OK;
    if (json_error_code(&error) == json_error_out_of_memory) return error_no_memory();
    source_place place = {g->path, error.line > 0 ? (uint32_t)error.line : 0,
                          error.column > 0 ? (uint32_t)error.column : 0};
    return error_set_at(SNELL_ERR_SYNTAX, place, NULL, "broken JSON: %s", error.text);
}

/* ---- versions and extensions ---- */

static snell_status check_version(const gltf *g) {
    const json_t *asset = json_at(g->root, "asset");
    const char *version = json_text(asset, "version"), *least = json_text(asset, "minVersion");
    unsigned major, minor;
    char rest;
    if (sscanf(version, "%3u.%3u%c", &major, &minor, &rest) != 2)
        return gltf_error(g, SNELL_ERR_SYNTAX, "asset.version", "'%.40s' is no version", version);
    if (major != 2)
        return gltf_error(g, SNELL_ERR_UNSUPPORTED, "asset.version",
                          "glTF %u.%u cannot be read, only 2.x", major, minor);
    if (least == NULL) return SNELL_OK;
    if (sscanf(least, "%3u.%3u%c", &major, &minor, &rest) != 2)
        return gltf_error(g, SNELL_ERR_SYNTAX, "asset.minVersion", "'%.40s' is no version", least);
    if (major > 2 || minor > 0)
        return gltf_error(g, SNELL_ERR_UNSUPPORTED, "asset.minVersion",
                          "the file needs glTF %u.%u; this is a reader of 2.0", major, minor);
    return SNELL_OK;
}

/* Extensions that this reader obeys. */
static const char *const known_extensions[] = {
    "KHR_lights_punctual",
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
    "KHR_materials_transmission",
    "KHR_materials_ior",
    "KHR_materials_volume",
    "KHR_materials_dispersion",
    "KHR_materials_specular",
    "KHR_materials_clearcoat",
    "KHR_materials_sheen",
    "KHR_materials_anisotropy",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "EXT_mesh_gpu_instancing",
#if SNELL_HAS_WEBP
    "EXT_texture_webp",
#endif
#if SNELL_HAS_DRACO
    "KHR_draco_mesh_compression",
#endif
};

static bool is_known(const char *extension) {
    for (size_t i = 0; i < sizeof known_extensions / sizeof known_extensions[0]; i++)
        if (strcmp(known_extensions[i], extension) == 0) return true;
    return false;
}

static snell_status check_extensions(gltf *g) {
    json_t *required = json_at(g->root, "extensionsRequired");
    for (size_t i = 0; i < json_array_size(required); i++) {
        const char *name = json_string_value(json_array_get(required, i));
        bool optional = strcmp(name, "KHR_draco_mesh_compression") == 0 ||
                        strcmp(name, "EXT_texture_webp") == 0;
        if (!is_known(name))
            return error_set_at(
                SNELL_ERR_UNSUPPORTED, place_of(g),
                optional ? "build with -DSNELL_DRACO=ON and -DSNELL_WEBP=ON, or export "
                           "the file without this extension"
                         : "export the file without this extension",
                "extensionsRequired[%zu]: the file needs the extension %.100s, which cannot "
                "be read",
                i, name);
    }
    json_t *used = json_at(g->root, "extensionsUsed");
    for (size_t i = 0; i < json_array_size(used); i++) {
        const char *name = json_string_value(json_array_get(used, i));
        snell_status status = SNELL_OK;
        if (!is_known(name))
            status = gltf_warn(g, "the extension %.100s is not supported: ignored", name);
        if (status) return status;
    }
    return SNELL_OK;
}

/* The scene that is not shown, for those who look for it. */
static snell_status warn_of_scenes(gltf *g) {
    size_t count = json_count(g, "scenes"), shown = json_index(g->root, "scene", 0), used = 0;
    char list[300] = "";
    if (count < 2) return SNELL_OK;
    for (size_t i = 0; i < count && used + 80 < sizeof list; i++) {
        const char *name = json_text(json_item(g, "scenes", i), "name");
        if (i == shown) continue;
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%zu%s%.40s", used ? ", " : "",
                                 i, name ? " " : "", name ? name : "");
    }
    return gltf_warn(g, "scene %zu of %zu is shown; not shown: %s", shown, count, list);
}

/* ---- the importer ---- */

static snell_status prepare(gltf *g) {
    size_t buffers = json_count(g, "buffers"), images = json_count(g, "images"),
           meshes = json_count(g, "meshes"), materials = json_count(g, "materials"),
           nodes = json_count(g, "nodes");
    g->buffers = memory_zeroed(buffers + 1, sizeof *g->buffers);
    g->images = memory_zeroed(images + 1, sizeof *g->images);
    g->meshes = memory_zeroed(meshes + 1, sizeof *g->meshes);
    g->materials = memory_zeroed(materials + 1, sizeof *g->materials);
    g->nodes = memory_zeroed(nodes + 1, sizeof *g->nodes);
    g->uv_sets_of = memory_zeroed(materials + 1, sizeof *g->uv_sets_of);
    if (!g->uv_sets_of || !g->buffers || !g->images || !g->meshes || !g->materials || !g->nodes)
        return error_no_memory();
    for (size_t i = 0; i < materials; i++) g->materials[i] = NO_MATERIAL;
    g->default_material = NO_MATERIAL;
    return SNELL_OK;
}

static void clean_up(gltf *g) {
    for (size_t i = 0; g->buffers && i < json_count(g, "buffers"); i++) free(g->buffers[i].owned);
    for (size_t i = 0; g->images && i < json_count(g, "images"); i++)
        free(g->images[i].image.pixels);
    for (size_t i = 0; g->meshes && i < json_count(g, "meshes"); i++) free(g->meshes[i].shapes);
    gltf_free_animation(g);
    free(g->buffers);
    free(g->images);
    free(g->meshes);
    free(g->materials);
    free(g->uv_sets_of);
    free(g->nodes);
    free(g->textures);
    free(g->file);
    json_decref(g->root);
    names_deinit(&g->names);
}

static bool is_named_glb(const char *path) {
    char extension[16];
    import_extension(path, extension, sizeof extension);
    return strcmp(extension, ".glb") == 0;
}

/* Does an object begin here, after white space and a byte order mark? */
static bool is_json(const uint8_t *text, size_t size) {
    size_t i = size >= 3 && text[0] == 0xef ? 3 : 0;
    while (i < size && (text[i] == ' ' || text[i] == '\n' || text[i] == '\r' || text[i] == '\t'))
        i++;
    return i < size && text[i] == '{';
}

static snell_status run(gltf *g) {
    size_t size;
    snell_status status = import_read_file(g->path, NULL, g->options, &g->file, &size);
    byte_block json = {.data = g->file, .size = size};
    g->is_glb = !status && size >= 4 && read_u32(g->file) == glb_magic;
    if (!status && !g->is_glb && is_named_glb(g->path) && !is_json(g->file, size)) {
        return error_set_at(SNELL_ERR_SYNTAX, (source_place){g->path, 0, 0},
                            "if it is another kind of file, --input-format names it",
                            "this is no GLB file: it does not begin with 'glTF'");
    }
    if (g->is_glb) status = glb_split(g, g->file, size, &json);
    if (!status) status = parse_json(g, json.data, json.size);
    if (!status) status = gltf_check_schema(g);
    if (!status) status = check_version(g);
    if (!status) status = check_extensions(g);
    if (!status) status = gltf_check_views(g);
    if (!status) status = gltf_check_meaning(g);
    if (!status) status = gltf_check_uses(g);
    if (!status) status = prepare(g);
    if (!status) status = gltf_choose_animation(g);
    if (!status) status = gltf_read_scene(g);
    if (!status) status = warn_of_scenes(g);
    if (!status) status = gltf_check_joints(g);
    if (!status) status = gltf_read_all_buffers(g);
    if (!status) status = gltf_check_values(g);
    if (!status) status = gltf_check_unused_images(g);
    return status;
}

static snell_status gltf_read(const char *path, const import_options *options, description *d) {
    gltf g = {.path = path, .options = options, .d = d};
    /* Two thirds stay for the file itself and the description's copies. */
    g.budget = (options->memory_max ? options->memory_max : (uint64_t)4 << 30) / 3;
    snell_status status = run(&g);
    clean_up(&g);
    if (status) error_place((source_place){path, 0, 0});
    snprintf(d->format, sizeof d->format, "gltf");
    d->is_model = true;
    return status;
}

static bool gltf_recognise(const char *extension, const uint8_t *first, size_t size) {
    if (size >= 4 && read_u32(first) == glb_magic) return true;
    if (*extension == '.') extension++;
    if (strcmp(extension, "gltf") == 0 || strcmp(extension, "glb") == 0) return true;
    if (!is_json(first, size)) return false;
    for (size_t i = 0; i + 7 < size; i++)
        if (memcmp(first + i, "\"asset\"", 7) == 0) return true;
    return false;
}

const importer importer_gltf = {
    .name = "gltf",
    .extensions = ".gltf .glb",
    .help = "glTF 2.0",
    .recognise = gltf_recognise,
    .read = gltf_read,
};
