/* The types' own tables, for help texts, documentation and bindings. */
#include <stdio.h>
#include <string.h>

#include "api/api.h"

uint32_t snell_type_count(void) {
    uint32_t count = 0;
    while (type_at(count)) count++;
    return count;
}

snell_status snell_type_get(uint32_t index, snell_type_info *out) {
    if (out == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "out is NULL");
    if (index >= snell_type_count())
        return error_set(SNELL_ERR_ARGUMENT, NULL, "there are %u types", snell_type_count());
    const type_info *t = type_at(index);
    *out = (snell_type_info){category_name(t->category), t->name, t->help, t->field_count};
    return SNELL_OK;
}

/* Angles are radians inside and degrees wherever a person reads or writes them. */
static double shown(const field *f, double value) {
    return strcmp(f->unit, "rad") == 0 ? value * (180 / 3.14159265358979323846) : value;
}

static void print_default(const field *f, char *out, size_t size) {
    double v[3];
    for (int i = 0; i < 3; i++) v[i] = shown(f, (double)f->initial[i]);
    out[0] = '\0';
    if (f->flags & FIELD_REQUIRED) return;
    switch (f->kind) {
    case FIELD_BOOL: snprintf(out, size, "%s", v[0] != 0 ? "true" : "false"); break;
    case FIELD_INT:
    case FIELD_FLOAT:
    case FIELD_SCALAR: snprintf(out, size, "%.6g", v[0]); break;
    case FIELD_VEC2: snprintf(out, size, "{%.6g, %.6g}", v[0], v[1]); break;
    case FIELD_VEC3:
    case FIELD_COLOR:
    case FIELD_INPUT:
        if (v[0] == v[1] && v[1] == v[2] && f->kind != FIELD_VEC3)
            snprintf(out, size, "%.6g", v[0]);
        else
            snprintf(out, size, "{%.6g, %.6g, %.6g}", v[0], v[1], v[2]);
        break;
    case FIELD_CHOICE: choice_word(f->choices, (int)f->initial[0], out, size); break;
    default: break;
    }
}

static void print_range(const field *f, char *out, size_t size) {
    double low = shown(f, f->min), high = shown(f, f->max);
    out[0] = '\0';
    if (f->kind == FIELD_CHOICE)
        snprintf(out, size, "%s", f->choices);
    else if (isinf(f->min))
        return;
    else if (isinf(f->max))
        snprintf(out, size, "%s %.6g", f->flags & FIELD_OPEN_MIN ? ">" : ">=", low);
    else
        snprintf(out, size, "%.10g to %.10g", low, high);
}

snell_status snell_type_get_field(uint32_t index, uint32_t number, snell_field_info *out) {
    static _Thread_local char initial[96], range[160];
    if (out == NULL) return error_set(SNELL_ERR_ARGUMENT, NULL, "out is NULL");
    if (index >= snell_type_count() || number >= type_at(index)->field_count)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "there is no field %u of type %u", number,
                         index);
    const field *f = &type_at(index)->fields[number];
    print_default(f, initial, sizeof initial);
    print_range(f, range, sizeof range);
    const char *unit = strcmp(f->unit, "rad") == 0 ? "degrees" : f->unit;
    *out = (snell_field_info){.name = f->name,
                              .kind = field_kind_name(f->kind),
                              .default_value = initial,
                              .range = range,
                              .unit = unit,
                              .help = f->help,
                              .required = (f->flags & FIELD_REQUIRED) != 0};
    return SNELL_OK;
}

const char *snell_formats(uint32_t index, const char **help) {
    static const struct {
        const char *extension, *text;
    } formats[] = {
        {".lua", "a scene program"},
        {".snell", "a compiled scene, written by 'snell convert'"},
        {".pbrt", "pbrt-v4, with what it includes"},
        {".nff", "NFF of the Standard Procedural Databases"},
        {".gltf", "glTF 2.0, with its buffers and images beside it"},
        {".glb", "glTF 2.0 in one file"},
        {".obj", "Wavefront, with its .mtl"},
        {".ply", "Stanford polygons"},
        {".stl", "stereolithography; z is up"},
#if SNELL_HAS_ASSIMP
        {".fbx", "Autodesk FBX"},
        {".dae", "COLLADA"},
        {".3ds", "3D Studio"},
        {".x3d", "X3D"},
        {".off", "Object File Format"},
#endif
    };
    if (index >= sizeof formats / sizeof formats[0]) return NULL;
    if (help) *help = formats[index].text;
    return formats[index].extension;
}
