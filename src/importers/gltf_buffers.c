/* glTF buffers, views, accessors, and the bytes of images. Files are read and bytes decoded when
 * something first uses them. */
#include "importers/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/memory.h"
#include "importers/files.h"

/* ---- what the JSON says about an accessor ---- */

static unsigned component_size(size_t type) {
    switch (type) {
    case GL_BYTE:
    case GL_UBYTE: return 1;
    case GL_SHORT:
    case GL_USHORT: return 2;
    case GL_UINT:
    case GL_FLOAT: return 4;
    default: return 0;
    }
}

typedef struct shape_of_element {
    unsigned components, columns, size; /* size in bytes, with the padding of matrix columns */
} shape_of_element;

static shape_of_element element_shape(const char *type, unsigned size) {
    static const struct {
        const char *name;
        unsigned rows, columns;
    } types[] = {{"SCALAR", 1, 1}, {"VEC2", 2, 1}, {"VEC3", 3, 1}, {"VEC4", 4, 1},
                 {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (strcmp(types[i].name, type) != 0) continue;
        unsigned rows = types[i].rows, columns = types[i].columns, bytes = rows * size;
        if (columns > 1) bytes = (bytes + 3) / 4 * 4; /* columns start at multiples of four */
        return (shape_of_element){rows * columns, columns, bytes * columns};
    }
    return (shape_of_element){0};
}

static shape_of_element accessor_shape(const json_t *accessor) {
    return element_shape(json_text(accessor, "type"),
                         component_size(json_index(accessor, "componentType", 0)));
}

size_t gltf_accessor_count(const gltf *g, size_t index) {
    return json_index(json_item(g, "accessors", index), "count", 0);
}

unsigned gltf_accessor_components(const gltf *g, size_t index) {
    return accessor_shape(json_item(g, "accessors", index)).components;
}

/* ---- everything fits into what it lies in; all numbers are below 2^53, so sums do not overflow
 * ---- */

static snell_status check_view(gltf *g, size_t index) {
    const json_t *view = json_item(g, "bufferViews", index);
    uint64_t offset = json_index(view, "byteOffset", 0), size = json_index(view, "byteLength", 0),
             whole = json_index(json_item(g, "buffers", json_index(view, "buffer", 0)),
                                "byteLength", 0);
    char path[JSON_PATH_SIZE];
    snprintf(path, sizeof path, "bufferViews[%zu]", index);
    if (offset + size > whole)
        return gltf_error(g, SNELL_ERR_SYNTAX, path,
                          "%llu bytes at %llu do not fit into buffer %zu", (unsigned long long)size,
                          (unsigned long long)offset, json_index(view, "buffer", 0));
    if (json_index(view, "byteStride", 0) > size)
        return gltf_error(g, SNELL_ERR_SYNTAX, path, "its stride is longer than the view");
    if (json_at(view, "byteStride") && json_index(view, "target", 0) == GL_INDICES)
        return gltf_warn(g, "%s.byteStride: indices have none", path);
    return SNELL_OK;
}

/* count elements of `size` bytes at `offset`, `stride` apart (0: tightly), in a view? */
static snell_status check_fit(gltf *g, const char *path, size_t view_index, uint64_t offset,
                              uint64_t count, uint64_t size, uint64_t alignment) {
    const json_t *view = json_item(g, "bufferViews", view_index);
    uint64_t stride = json_index(view, "byteStride", 0), length = json_index(view, "byteLength", 0);
    if (stride == 0) stride = size;
    if (count > length + 1 || (count - 1) * stride + size + offset > length)
        return gltf_error(g, SNELL_ERR_SYNTAX, path,
                          "%llu elements of %llu bytes do not fit into bufferViews[%zu]",
                          (unsigned long long)count, (unsigned long long)size, view_index);
    if ((offset + json_index(view, "byteOffset", 0)) % alignment != 0 || stride % alignment != 0)
        return gltf_warn(g, "%s: its data is not aligned", path);
    return SNELL_OK;
}

static snell_status check_sparse(gltf *g, const json_t *accessor, const char *path, unsigned size,
                                 unsigned component) {
    const json_t *sparse = json_at(accessor, "sparse");
    if (sparse == NULL) return SNELL_OK;
    const json_t *indices = json_at(sparse, "indices"), *values = json_at(sparse, "values");
    uint64_t count = json_index(sparse, "count", 0);
    size_t type = json_index(indices, "componentType", 0);
    char inner[JSON_PATH_SIZE];
    snprintf(inner, sizeof inner, "%.150s.sparse", path);
    if (count > json_index(accessor, "count", 0))
        return gltf_error(g, SNELL_ERR_SYNTAX, inner, "has more elements than the accessor");
    if (type != GL_UBYTE && type != GL_USHORT && type != GL_UINT)
        return gltf_error(g, SNELL_ERR_SYNTAX, inner, "componentType %zu is no kind of index",
                          type);
    snell_status status = check_fit(g, inner, json_index(indices, "bufferView", 0),
                                    json_index(indices, "byteOffset", 0), count,
                                    component_size(type), component_size(type));
    if (status) return status;
    return check_fit(g, inner, json_index(values, "bufferView", 0),
                     json_index(values, "byteOffset", 0), count, size, component);
}

static snell_status check_accessor(gltf *g, size_t index) {
    const json_t *accessor = json_item(g, "accessors", index);
    char path[JSON_PATH_SIZE];
    snprintf(path, sizeof path, "accessors[%zu]", index);
    size_t type = json_index(accessor, "componentType", 0);
    unsigned component = component_size(type);
    if (component == 0)
        return gltf_error(g, SNELL_ERR_SYNTAX, path, "there is no componentType %zu", type);
    shape_of_element shape = accessor_shape(accessor);
    if (json_index(accessor, "count", 0) >= UINT32_MAX)
        return gltf_error(g, SNELL_ERR_SYNTAX, path, "has too many elements");
    if (json_flag(accessor, "normalized") && (type == GL_FLOAT || type == GL_UINT))
        return gltf_error(g, SNELL_ERR_SYNTAX, path, "componentType %zu cannot be normalized",
                          type);
    const char *bounds[] = {"min", "max"};
    for (int i = 0; i < 2; i++) {
        const json_t *bound = json_at(accessor, bounds[i]);
        if (bound && json_array_size(bound) != shape.components)
            return gltf_error(g, SNELL_ERR_SYNTAX, path, "%s must have %u numbers", bounds[i],
                              shape.components);
    }
    snell_status status = check_sparse(g, accessor, path, shape.size, component);
    size_t view = json_index(accessor, "bufferView", SIZE_MAX);
    if (status) return status;
    if (view == SIZE_MAX && json_at(accessor, "byteOffset"))
        return gltf_warn(g, "%s: byteOffset without bufferView: ignored", path);
    if (view == SIZE_MAX) return SNELL_OK;
    return check_fit(g, path, view, json_index(accessor, "byteOffset", 0),
                     json_index(accessor, "count", 0), shape.size, component);
}

/* What a view is for, so far; 0: nothing. */
typedef struct view_use {
    size_t target;
    size_t accessor; /* the first of vertices, plus 1 */
    bool is_blamed;  /* one warning is enough */
} view_use;

/* An accessor of vertices or of indices at this JSON path: its view must be for the same, vertices lie
 * at multiples of four bytes, and two accessors of vertices in one view need a stride. */
static snell_status use_view(gltf *g, view_use *uses, size_t accessor, size_t target,
                             const char *where) {
    const json_t *a = json_item(g, "accessors", accessor);
    size_t index = json_index(a, "bufferView", SIZE_MAX);
    if (index == SIZE_MAX) return SNELL_OK;
    const json_t *view = json_item(g, "bufferViews", index);
    view_use *use = &uses[index];
    const char *wrong = NULL;
    size_t stride = json_index(view, "byteStride", 0),
           bytes = stride ? stride : accessor_shape(a).size,
           start = json_index(a, "byteOffset", 0) + json_index(view, "byteOffset", 0);
    if (use->target == 0) use->target = json_index(view, "target", target);
    if (use->target != target)
        wrong = " is used for vertices and for other things";
    else if (target == GL_VERTICES && (start % 4 != 0 || bytes % 4 != 0))
        wrong = ": its vertices are not at multiples of four bytes";
    else if (target == GL_VERTICES && use->accessor && use->accessor != accessor + 1 && !stride)
        wrong = " has no byteStride, but two accessors";
    use->accessor = accessor + 1;
    if (wrong == NULL || use->is_blamed) return SNELL_OK;
    use->is_blamed = true;
    return gltf_warn(g, "%s: bufferViews[%zu]%s", where, index, wrong);
}

static snell_status use_attributes(gltf *g, view_use *uses, const json_t *map, const char *where) {
    const char *name;
    json_t *value;
    snell_status status = SNELL_OK;
    json_object_foreach((json_t *)(uintptr_t)map, name, value) {
        char path[JSON_PATH_SIZE];
        snprintf(path, sizeof path, "%.120s.%.60s", where, name);
        if (!status)
            status = use_view(g, uses, (size_t)json_number_value(value), GL_VERTICES, path);
    }
    return status;
}

static snell_status use_primitive(gltf *g, view_use *uses, const json_t *primitive,
                                  const char *where) {
    const json_t *targets = json_at(primitive, "targets");
    size_t indices = json_index(primitive, "indices", SIZE_MAX);
    char path[JSON_PATH_SIZE];
    snprintf(path, sizeof path, "%.150s.attributes", where);
    snell_status status = use_attributes(g, uses, json_at(primitive, "attributes"), path);
    snprintf(path, sizeof path, "%.150s.indices", where);
    if (!status && indices != SIZE_MAX) status = use_view(g, uses, indices, GL_INDICES, path);
    for (size_t i = 0; i < json_array_size(targets) && !status; i++) {
        snprintf(path, sizeof path, "%.150s.targets[%zu]", where, i);
        status = use_attributes(g, uses, json_array_get(targets, i), path);
    }
    return status;
}

snell_status gltf_check_uses(gltf *g) {
    view_use *uses = memory_zeroed(json_count(g, "bufferViews") + 1, sizeof *uses);
    snell_status status = uses ? SNELL_OK : error_no_memory();
    for (size_t i = 0; i < json_count(g, "meshes") && !status; i++) {
        const json_t *list = json_at(json_item(g, "meshes", i), "primitives");
        for (size_t k = 0; k < json_array_size(list) && !status; k++) {
            char where[JSON_PATH_SIZE];
            snprintf(where, sizeof where, "meshes[%zu].primitives[%zu]", i, k);
            status = use_primitive(g, uses, json_array_get(list, k), where);
        }
    }
    free(uses);
    for (size_t i = 0; i < json_count(g, "images") && !status; i++) {
        size_t view = json_index(json_item(g, "images", i), "bufferView", SIZE_MAX);
        if (view != SIZE_MAX && json_at(json_item(g, "bufferViews", view), "byteStride"))
            status = gltf_warn(g, "images[%zu].bufferView: has a byteStride", i);
    }
    return status;
}

snell_status gltf_check_views(gltf *g) {
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < json_count(g, "bufferViews") && !status; i++) status = check_view(g, i);
    for (size_t i = 0; i < json_count(g, "accessors") && !status; i++)
        status = check_accessor(g, i);
    return status;
}

/* ---- URIs ---- */

static int base64_digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62; /* - and _: the URL alphabet, which some exporters use */
    if (c == '/' || c == '_') return 63;
    return -1;
}

/* RFC 4648, section 4; the padding may be missing. */
static snell_status decode_base64(gltf *g, const char *text, const char *where, byte_block *out) {
    size_t length = strlen(text), size = 0;
    while (length > 0 && text[length - 1] == '=') length--;
    snell_status status = gltf_spend(g, where, length);
    if (status) return status;
    uint8_t *bytes = memory_resize(NULL, length / 4 * 3 + 4, 1);
    if (bytes == NULL) return error_no_memory();
    uint32_t bits = 0, count = 0;
    for (size_t i = 0; i < length; i++) {
        int digit = base64_digit(text[i]);
        if (digit < 0) {
            free(bytes);
            return gltf_error(g, SNELL_ERR_SYNTAX, where, "its base64 is broken at character %zu",
                              i + 1);
        }
        bits = bits << 6 | (uint32_t)digit;
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes[size++] = (uint8_t)(bits >> count);
    }
    *out = (byte_block){bytes, size, bytes, true};
    return SNELL_OK;
}

static int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/* %20 and the like; a lone % stays. NULL: no memory. */
static char *decode_percent(const char *uri) {
    char *name = memory_copy_string(uri);
    if (name == NULL) return NULL;
    size_t out = 0;
    for (size_t i = 0; uri[i]; i++) {
        int high = uri[i] == '%' ? hex_digit(uri[i + 1]) : -1;
        int low = high >= 0 ? hex_digit(uri[i + 2]) : -1;
        if (low >= 0 && high + low > 0) {
            name[out++] = (char)(high * 16 + low);
            i += 2;
        } else {
            name[out++] = uri[i];
        }
    }
    name[out] = '\0';
    return name;
}

static bool has_scheme(const char *uri) {
    size_t i = 0;
    while ((uri[i] >= 'a' && uri[i] <= 'z') || (uri[i] >= 'A' && uri[i] <= 'Z') ||
           (i > 0 && ((uri[i] >= '0' && uri[i] <= '9') || strchr("+-.", uri[i]) != NULL) && uri[i]))
        i++;
    return uri[i] == ':';
}

static snell_status read_uri(gltf *g, const char *uri, const char *where, byte_block *out) {
    if (strncmp(uri, "data:", 5) == 0) {
        const char *comma = strchr(uri, ',');
        if (comma == NULL || comma - uri < 12 || strncmp(comma - 7, ";base64", 7) != 0)
            return gltf_error(g, SNELL_ERR_SYNTAX, where, "a data URI that is not base64");
        return decode_base64(g, comma + 1, where, out);
    }
    if (has_scheme(uri))
        return gltf_error(g, SNELL_ERR_UNSUPPORTED, where,
                          "'%.100s' is not a file beside this one; nothing is fetched", uri);
    char *name = decode_percent(uri);
    if (name == NULL) return error_no_memory();
    uint8_t *data = NULL;
    size_t size = 0;
    snell_status status = import_read_beside(g->path, name, g->options, &data, &size);
    free(name);
    if (status) return gltf_blame(g, where, status);
    *out = (byte_block){data, size, data, true};
    status = gltf_spend(g, where, size);
    return status;
}

/* ---- buffers ---- */

/* A wrong word does no harm: bytes are bytes. */
static snell_status check_media_type(gltf *g, const char *uri, const char *where) {
    static const char *const types[] = {"data:application/octet-stream;base64,",
                                        "data:application/gltf-buffer;base64,"};
    if (strncmp(uri, "data:", 5) != 0) return SNELL_OK;
    for (int i = 0; i < 2; i++)
        if (strncasecmp(uri, types[i], strlen(types[i])) == 0) return SNELL_OK;
    return gltf_warn(g, "%s.uri: should begin with %s", where, types[0]);
}

/* Neither URI nor chunk: the format allows that, for extensions that bring the bytes. */
static snell_status zero_buffer(gltf *g, const char *where, size_t length, byte_block *out) {
    snell_status status = gltf_spend(g, where, length);
    if (!status) status = gltf_warn(g, "%s: has no data: all zero", where);
    if (status) return status;
    uint8_t *zeros = memory_zeroed(length, 1);
    if (zeros == NULL) return error_no_memory();
    *out = (byte_block){.data = zeros, .size = length, .owned = zeros};
    return SNELL_OK;
}

static snell_status load_buffer(gltf *g, size_t index) {
    byte_block *block = &g->buffers[index];
    if (block->loaded) return SNELL_OK;
    const json_t *buffer = json_item(g, "buffers", index);
    const char *uri = json_text(buffer, "uri");
    size_t length = json_index(buffer, "byteLength", 0);
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "buffers[%zu]", index);
    if (uri) {
        snell_status status = read_uri(g, uri, where, block);
        if (!status) status = check_media_type(g, uri, where);
        if (status) return status;
    } else if (index == 0 && g->has_bin) {
        *block = (byte_block){.data = g->bin, .size = g->bin_size};
    } else if (g->is_glb && index == 0) {
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "has no uri and there is no BIN chunk");
    } else {
        snell_status status = zero_buffer(g, where, length, block);
        if (status) return status;
    }
    if (block->size < length)
        return gltf_error(g, SNELL_ERR_SYNTAX, where, "has %zu bytes where %zu are promised",
                          block->size, length);
    block->loaded = true;
    return SNELL_OK;
}

snell_status gltf_read_all_buffers(gltf *g) {
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < json_count(g, "buffers") && !status; i++) status = load_buffer(g, i);
    return status;
}

/* The first byte at `offset` in a view; that it fits was checked. */
static snell_status view_bytes(gltf *g, size_t index, size_t offset, const uint8_t **out) {
    const json_t *view = json_item(g, "bufferViews", index);
    size_t buffer = json_index(view, "buffer", 0);
    snell_status status = load_buffer(g, buffer);
    if (!status) *out = g->buffers[buffer].data + json_index(view, "byteOffset", 0) + offset;
    return status;
}

snell_status gltf_view_bytes(gltf *g, size_t index, const uint8_t **data, size_t *size) {
    *size = json_index(json_item(g, "bufferViews", index), "byteLength", 0);
    return view_bytes(g, index, 0, data);
}

snell_status gltf_image_bytes(gltf *g, size_t index, byte_block *out) {
    const json_t *image = json_item(g, "images", index);
    const char *uri = json_text(image, "uri");
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "images[%zu]", index);
    if (uri) return read_uri(g, uri, where, out);
    size_t view = json_index(image, "bufferView", 0);
    *out = (byte_block){.size = json_index(json_item(g, "bufferViews", view), "byteLength", 0)};
    return view_bytes(g, view, 0, &out->data);
}

/* ---- accessors ---- */

static uint32_t read_uint(const uint8_t *p) {
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static float read_float(const uint8_t *p) {
    uint32_t bits = read_uint(p);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double read_component(const uint8_t *p, size_t type, bool normalized) {
    switch (type) {
    case GL_UBYTE: return normalized ? p[0] / 255.0 : p[0];
    case GL_BYTE: {
        double value = (int8_t)p[0];
        return !normalized ? value : value < -127 ? -1 : value / 127;
    }
    case GL_USHORT: {
        double value = p[0] | p[1] << 8;
        return normalized ? value / 65535 : value;
    }
    case GL_SHORT: {
        double value = (int16_t)(p[0] | p[1] << 8);
        return !normalized ? value : value < -32767 ? -1 : value / 32767;
    }
    default: break;
    }
    return type == GL_UINT ? read_uint(p) : (double)read_float(p);
}

/* Where element `i`'s components go: floats or whole numbers. */
typedef struct element_sink {
    float *floats;
    uint32_t *uints;
    unsigned components;
    bool stored; /* whole numbers stay what they are, normalised or not */
} element_sink;

typedef struct element_source {
    const uint8_t *data;
    size_t stride, type;
    shape_of_element shape;
    bool normalized;
} element_source;

static bool copy_element(const element_source *s, size_t from, const element_sink *sink,
                         size_t to) {
    const uint8_t *at = s->data + from * s->stride;
    if (s->type == GL_FLOAT && sink->floats) { /* most of what there is */
        float *out = sink->floats + to * sink->components, sum = 0;
        for (unsigned c = 0; c < sink->components; c++) {
            out[c] = read_float(at + 4 * (size_t)c);
            sum += out[c] - out[c]; /* 0, or no number */
        }
        return sum == 0;
    }
    unsigned size = component_size(s->type), rows = s->shape.components / s->shape.columns,
             column_size = s->shape.size / s->shape.columns;
    for (unsigned c = 0; c < sink->components; c++) {
        double value =
            read_component(at + c / rows * column_size + c % rows * size, s->type, s->normalized);
        if (!isfinite(value)) return false;
        if (sink->uints)
            sink->uints[to * sink->components + c] = (uint32_t)value;
        else
            sink->floats[to * sink->components + c] = (float)value;
    }
    return true;
}

static snell_status not_finite(const gltf *g, size_t index, size_t element) {
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "accessors[%zu]", index);
    return gltf_error(g, SNELL_ERR_SYNTAX, where, "element %zu is not a finite number", element);
}

static snell_status read_sparse(gltf *g, size_t index, const json_t *sparse, element_source source,
                                const element_sink *sink) {
    const json_t *indices = json_at(sparse, "indices"), *values = json_at(sparse, "values");
    size_t index_view = json_index(indices, "bufferView", 0),
           value_view = json_index(values, "bufferView", 0),
           type = json_index(indices, "componentType", 0), count = json_index(sparse, "count", 0),
           total = gltf_accessor_count(g, index);
    const uint8_t *at;
    snell_status status = view_bytes(g, index_view, json_index(indices, "byteOffset", 0), &at);
    if (!status)
        status = view_bytes(g, value_view, json_index(values, "byteOffset", 0), &source.data);
    if (status) return status;
    size_t stride =
        json_index(json_item(g, "bufferViews", index_view), "byteStride", component_size(type));
    source.stride =
        json_index(json_item(g, "bufferViews", value_view), "byteStride", source.shape.size);
    for (size_t i = 0, last = 0; i < count; i++) {
        size_t to = (size_t)read_component(at + i * stride, type, false);
        char where[JSON_PATH_SIZE];
        snprintf(where, sizeof where, "accessors[%zu].sparse.indices", index);
        if (to >= total)
            return gltf_error(g, SNELL_ERR_SYNTAX, where, "%zu is beyond the last element", to);
        if (i > 0 && to <= last)
            return gltf_error(g, SNELL_ERR_SYNTAX, where, "they are not in rising order");
        last = to;
        if (!copy_element(&source, i, sink, to)) return not_finite(g, index, to);
    }
    return SNELL_OK;
}

static snell_status read_elements(gltf *g, size_t index, const element_sink *sink) {
    const json_t *accessor = json_item(g, "accessors", index);
    element_source source = {.type = json_index(accessor, "componentType", 0),
                             .shape = accessor_shape(accessor),
                             .normalized = !sink->uints && !sink->stored &&
                                           json_flag(accessor, "normalized")};
    size_t view = json_index(accessor, "bufferView", SIZE_MAX),
           count = gltf_accessor_count(g, index);
    if (view != SIZE_MAX) {
        snell_status status =
            view_bytes(g, view, json_index(accessor, "byteOffset", 0), &source.data);
        if (status) return status;
        source.stride =
            json_index(json_item(g, "bufferViews", view), "byteStride", source.shape.size);
        for (size_t i = 0; i < count; i++)
            if (!copy_element(&source, i, sink, i)) return not_finite(g, index, i);
    }
    const json_t *sparse = json_at(accessor, "sparse");
    return sparse ? read_sparse(g, index, sparse, source, sink) : SNELL_OK;
}

/* Checks the type and makes zeroed room, which an accessor without data needs. */
static snell_status begin_read(gltf *g, size_t index, unsigned components, const char *where,
                               void **out) {
    if (gltf_accessor_components(g, index) != components)
        return gltf_error(g, SNELL_ERR_SYNTAX, where,
                          "accessors[%zu] is %s, which does not fit here", index,
                          json_text(json_item(g, "accessors", index), "type"));
    size_t count = gltf_accessor_count(g, index);
    snell_status status = gltf_spend(g, where, (uint64_t)count * components * 4);
    if (status) return status;
    *out = memory_zeroed(count * components, 4);
    return *out ? SNELL_OK : error_no_memory();
}

static snell_status read_floats(gltf *g, size_t index, unsigned components, const char *where,
                                bool stored, float **out) {
    void *room = NULL;
    snell_status status = begin_read(g, index, components, where, &room);
    element_sink sink = {.floats = room, .components = components, .stored = stored};
    if (!status) status = read_elements(g, index, &sink);
    if (status)
        free(room);
    else
        *out = room;
    return status;
}

snell_status gltf_accessor_floats(gltf *g, size_t index, unsigned components, const char *where,
                                  float **out) {
    return read_floats(g, index, components, where, false, out);
}

snell_status gltf_accessor_stored(gltf *g, size_t index, float **out) {
    return read_floats(g, index, gltf_accessor_components(g, index), "", true, out);
}

bool gltf_accessor_has_data(const gltf *g, size_t index) {
    const json_t *accessor = json_item(g, "accessors", index);
    return json_at(accessor, "bufferView") || json_at(accessor, "sparse");
}

snell_status gltf_accessor_uints(gltf *g, size_t index, unsigned components, const char *where,
                                 uint32_t **out) {
    size_t type = json_index(json_item(g, "accessors", index), "componentType", 0);
    if (type != GL_UBYTE && type != GL_USHORT && type != GL_UINT)
        return gltf_error(g, SNELL_ERR_SYNTAX, where,
                          "accessors[%zu] has componentType %zu; here whole numbers are needed",
                          index, type);
    void *room = NULL;
    snell_status status = begin_read(g, index, components, where, &room);
    element_sink sink = {.uints = room, .components = components};
    if (!status) status = read_elements(g, index, &sink);
    if (status)
        free(room);
    else
        *out = room;
    return status;
}
