/* What the numbers in buffers must be beyond their types: finite, within their accessor's min and max,
 * of unit length, rising, below the number of vertices. Looked at once for the whole file, drawn or
 * not. What would make a wrong picture is an error; what would not is one warning for each kind. */
#include "importers/gltf.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "maths/functions.h"

enum { BOUNDS, COLORS, NORMALS, TANGENTS, SIGNS, ROTATIONS, MATRICES, FAULT_KINDS };

typedef struct values {
    gltf *g;
    uint64_t allowance; /* numbers that may still be looked at: accessors can share bytes */
    uint8_t *asked;     /* of each accessor: bit 1 << kind: this was asked of it already */
    uint32_t *largest;  /* of accessors that are indices */
    size_t counts[FAULT_KINDS];
    char first[FAULT_KINDS][JSON_PATH_SIZE + 100];
} values;

static void note(values *v, int kind, const char *format, ...) PRINTF_LIKE(3, 4);
static void note(values *v, int kind, const char *format, ...) {
    if (v->counts[kind]++ > 0) return;
    va_list list;
    va_start(list, format);
    vsnprintf(v->first[kind], sizeof v->first[kind], format, list);
    va_end(list);
}

static snell_status warn_of_faults(values *v) {
    snell_status status = SNELL_OK;
    for (int i = 0; i < FAULT_KINDS && !status; i++) {
        if (v->counts[i] == 1) status = gltf_warn(v->g, "%s", v->first[i]);
        if (v->counts[i] > 1)
            status = gltf_warn(v->g, "%s; %zu more like this", v->first[i], v->counts[i] - 1);
    }
    return status;
}

/* Whether to look at an accessor's numbers, for the first time with this question. */
static bool wants(values *v, size_t accessor, int question) {
    uint64_t size =
        (uint64_t)gltf_accessor_count(v->g, accessor) * gltf_accessor_components(v->g, accessor);
    if (v->asked[accessor] >> question & 1) return false;
    v->asked[accessor] |= (uint8_t)(1 << question);
    if (!gltf_accessor_has_data(v->g, accessor) || size > v->allowance) return false;
    v->allowance -= size;
    return true;
}

/* ---- accessors by themselves ---- */

/* The least (of a bound "min") or the largest number of each component, against what is said. */
static void check_bound(values *v, size_t index, const char *bound, const float *found) {
    const json_t *said = json_at(json_item(v->g, "accessors", index), bound);
    for (size_t c = 0; c < json_array_size(said); c++) {
        float told = (float)json_number_value(json_array_get(said, c));
        if (found[c] == told) continue;
        note(v, BOUNDS, "accessors[%zu].%s[%zu]: says %g where it is %g", index, bound, c,
             (double)told, (double)found[c]);
        return;
    }
}

static snell_status check_accessor(values *v, size_t index) {
    enum { COMPONENTS_MAX = 16 };
    const json_t *accessor = json_item(v->g, "accessors", index);
    bool is_float = json_index(accessor, "componentType", 0) == GL_FLOAT;
    float *numbers = NULL, least[COMPONENTS_MAX], most[COMPONENTS_MAX];
    if (!is_float && !json_at(accessor, "min") && !json_at(accessor, "max")) return SNELL_OK;
    if (!wants(v, index, BOUNDS)) return SNELL_OK;
    snell_status status = gltf_accessor_stored(v->g, index, &numbers);
    if (status) return status;
    size_t width = gltf_accessor_components(v->g, index), count = gltf_accessor_count(v->g, index);
    for (size_t c = 0; c < width; c++) least[c] = most[c] = numbers[c];
    for (size_t i = 1; i < count; i++) {
        for (size_t c = 0; c < width; c++) {
            float number = numbers[i * width + c];
            least[c] = number < least[c] ? number : least[c];
            most[c] = number > most[c] ? number : most[c];
        }
    }
    check_bound(v, index, "min", least);
    check_bound(v, index, "max", most);
    free(numbers);
    return SNELL_OK;
}

/* ---- attributes ---- */

/* Farther from a length of 1 than bytes make it. */
static bool is_unit(const float *v, size_t width) {
    double squared = 0;
    for (size_t i = 0; i < width; i++) squared += (double)v[i] * (double)v[i];
    return fabs(sqrt(squared) - 1) <= 0.008;
}

static void check_vector(values *v, int kind, const char *where, const float *at, size_t width) {
    switch (kind) {
    case COLORS:
        for (size_t c = 0; c < width; c++)
            if (!(at[c] >= 0 && at[c] <= 1))
                note(v, COLORS, "%s: a colour is %g, not within 0 and 1", where, (double)at[c]);
        break;
    case NORMALS:
        if (!is_unit(at, 3)) note(v, NORMALS, "%s: a normal has not the length 1", where);
        break;
    default:
        if (!is_unit(at, 3)) note(v, TANGENTS, "%s: a tangent has not the length 1", where);
        if (at[3] != 1 && at[3] != -1)
            note(v, SIGNS, "%s: a tangent's sign is %g, not 1 or -1", where, (double)at[3]);
    }
}

static snell_status check_attribute(values *v, const char *name, size_t accessor,
                                    const char *where) {
    int kind = strncmp(name, "COLOR_", 6) == 0 ? COLORS
               : strcmp(name, "NORMAL") == 0   ? NORMALS
               : strcmp(name, "TANGENT") == 0  ? TANGENTS
                                               : FAULT_KINDS;
    float *numbers = NULL;
    if (kind == FAULT_KINDS || !wants(v, accessor, kind)) return SNELL_OK;
    size_t count = gltf_accessor_count(v->g, accessor);
    bool four =
        kind == TANGENTS || (kind == COLORS && gltf_accessor_components(v->g, accessor) == 4);
    unsigned width = four ? 4 : 3; /* an accessor of another is an error */
    snell_status status = gltf_accessor_floats(v->g, accessor, width, where, &numbers);
    for (size_t i = 0; !status && i < count; i++)
        check_vector(v, kind, where, numbers + i * width, width);
    free(numbers);
    return status;
}

static snell_status find_largest(values *v, size_t accessor, const char *where) {
    uint32_t *numbers = NULL;
    if (!wants(v, accessor, FAULT_KINDS)) return SNELL_OK;
    size_t count = gltf_accessor_count(v->g, accessor);
    snell_status status = gltf_accessor_uints(v->g, accessor, 1, where, &numbers);
    for (size_t i = 0; !status && i < count; i++)
        if (numbers[i] > v->largest[accessor]) v->largest[accessor] = numbers[i];
    free(numbers);
    return status;
}

/* The largest number of its type would begin a new primitive, in other formats. */
static snell_status check_indices(values *v, const json_t *primitive, const char *where) {
    size_t accessor = json_index(primitive, "indices", SIZE_MAX),
           position = json_index(json_at(primitive, "attributes"), "POSITION", SIZE_MAX);
    if (accessor == SIZE_MAX || position == SIZE_MAX) return SNELL_OK;
    char path[JSON_PATH_SIZE];
    snprintf(path, sizeof path, "%.150s.indices", where);
    snell_status status = find_largest(v, accessor, path);
    if (status) return status;
    size_t type = json_index(json_item(v->g, "accessors", accessor), "componentType", 0),
           vertices = gltf_accessor_count(v->g, position);
    uint32_t largest = v->largest[accessor], restart = type == GL_UBYTE    ? UINT8_MAX
                                                       : type == GL_USHORT ? UINT16_MAX
                                                                           : UINT32_MAX;
    if (largest == restart)
        return gltf_error(v->g, SNELL_ERR_SYNTAX, path,
                          "%u would restart a primitive, which glTF has not", largest);
    if (largest >= vertices && gltf_accessor_has_data(v->g, accessor))
        return gltf_error(v->g, SNELL_ERR_SYNTAX, path, "%u is beyond the last of %zu vertices",
                          largest, vertices);
    return SNELL_OK;
}

static snell_status check_mesh(values *v, size_t index) {
    const json_t *list = json_at(json_item(v->g, "meshes", index), "primitives");
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < json_array_size(list) && !status; i++) {
        const json_t *primitive = json_array_get(list, i);
        const char *name;
        json_t *value;
        char where[JSON_PATH_SIZE], path[JSON_PATH_SIZE];
        snprintf(where, sizeof where, "meshes[%zu].primitives[%zu]", index, i);
        status = check_indices(v, primitive, where);
        json_object_foreach(json_at(primitive, "attributes"), name, value) {
            snprintf(path, sizeof path, "%.100s.attributes.%.60s", where, name);
            if (!status) status = check_attribute(v, name, (size_t)json_number_value(value), path);
        }
    }
    return status;
}

/* ---- skins and animations ---- */

/* Columns first, so that the last row is every fourth number. */
static snell_status check_skin(values *v, size_t index) {
    size_t accessor = json_index(json_item(v->g, "skins", index), "inverseBindMatrices", SIZE_MAX);
    float *numbers = NULL;
    if (accessor == SIZE_MAX || !wants(v, accessor, MATRICES)) return SNELL_OK;
    char where[JSON_PATH_SIZE];
    snprintf(where, sizeof where, "skins[%zu].inverseBindMatrices", index);
    size_t count = gltf_accessor_count(v->g, accessor);
    snell_status status = gltf_accessor_floats(v->g, accessor, 16, where, &numbers);
    for (size_t i = 0; !status && i < count; i++) {
        const float *m = numbers + 16 * i;
        if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
            note(v, MATRICES, "%s: the last row of matrix %zu is not 0 0 0 1", where, i);
    }
    free(numbers);
    return status;
}

static snell_status check_times(values *v, size_t accessor, const char *where) {
    float *times = NULL;
    if (!wants(v, accessor, ROTATIONS)) return SNELL_OK; /* no times are rotations too */
    size_t count = gltf_accessor_count(v->g, accessor);
    snell_status status = gltf_accessor_floats(v->g, accessor, 1, where, &times);
    for (size_t i = 0; !status && i < count; i++)
        if (times[i] < 0 || (i > 0 && !(times[i] > times[i - 1])))
            status = gltf_error(v->g, SNELL_ERR_SYNTAX, where,
                                "the time %g of key %zu is negative or not ascending",
                                (double)times[i], i);
    free(times);
    return status;
}

static snell_status check_rotations(values *v, const json_t *sampler, const char *where) {
    size_t accessor = json_index(sampler, "output", 0);
    const char *word = json_text(sampler, "interpolation");
    bool cubic = word && strcmp(word, "CUBICSPLINE") == 0; /* the middle one of three is a value */
    float *numbers = NULL;
    if (!wants(v, accessor, ROTATIONS)) return SNELL_OK;
    size_t count = gltf_accessor_count(v->g, accessor);
    snell_status status = gltf_accessor_floats(v->g, accessor, 4, where, &numbers);
    size_t step = cubic ? 3 : 1;
    for (size_t i = cubic; !status && i < count; i += step)
        if (!is_unit(numbers + 4 * i, 4))
            note(v, ROTATIONS, "%s: the rotation of key %zu is no unit quaternion", where,
                 i / step);
    free(numbers);
    return status;
}

static snell_status check_animation(values *v, size_t index) {
    const json_t *animation = json_item(v->g, "animations", index);
    const json_t *samplers = json_at(animation, "samplers"),
                 *channels = json_at(animation, "channels");
    snell_status status = SNELL_OK;
    char where[JSON_PATH_SIZE];
    for (size_t i = 0; i < json_array_size(samplers) && !status; i++) {
        snprintf(where, sizeof where, "animations[%zu].samplers[%zu].input", index, i);
        status = check_times(v, json_index(json_array_get(samplers, i), "input", 0), where);
    }
    for (size_t i = 0; i < json_array_size(channels) && !status; i++) {
        const json_t *channel = json_array_get(channels, i), *target = json_at(channel, "target");
        snprintf(where, sizeof where, "animations[%zu].channels[%zu].sampler", index, i);
        if (strcmp(json_text(target, "path"), "rotation") == 0 && json_at(target, "node"))
            status = check_rotations(v, json_array_get(samplers, json_index(channel, "sampler", 0)),
                                     where);
    }
    return status;
}

snell_status gltf_check_values(gltf *g) {
    size_t count = json_count(g, "accessors");
    values v = {.g = g, .allowance = (uint64_t)1 << 20};
    uint64_t budget = g->budget; /* what is read here is freed here */
    v.asked = memory_zeroed(count + 1, sizeof *v.asked);
    v.largest = memory_zeroed(count + 1, sizeof *v.largest);
    snell_status status = v.asked && v.largest ? SNELL_OK : error_no_memory();
    for (size_t i = 0; i < json_count(g, "buffers"); i++) v.allowance += 4 * g->buffers[i].size;
    for (size_t i = 0; i < count && !status; i++, g->budget = budget)
        status = check_accessor(&v, i);
    for (size_t i = 0; i < json_count(g, "meshes") && !status; i++, g->budget = budget)
        status = check_mesh(&v, i);
    for (size_t i = 0; i < json_count(g, "skins") && !status; i++, g->budget = budget)
        status = check_skin(&v, i);
    for (size_t i = 0; i < json_count(g, "animations") && !status; i++, g->budget = budget)
        status = check_animation(&v, i);
    if (!status) status = warn_of_faults(&v);
    free(v.asked);
    free(v.largest);
    return status;
}
