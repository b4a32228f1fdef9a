#include "base/field.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"

size_t field_element_size(field_kind kind) {
    switch (kind) {
    case FIELD_VEC3S: return sizeof(snell_vec3);
    case FIELD_VEC2S: return sizeof(snell_vec2);
    case FIELD_FLOATS: return sizeof(float);
    case FIELD_UINTS: return sizeof(uint32_t);
    case FIELD_BYTES: return 1;
    case FIELD_MATERIALS: return sizeof(snell_material_id);
    case FIELD_SHAPES: return sizeof(snell_shape_id);
    case FIELD_TRANSFORMS: return sizeof(snell_transform);
    case FIELD_KEYS: return sizeof(snell_motion_key);
    default: return 0;
    }
}

size_t field_size(field_kind kind) {
    switch (kind) {
    case FIELD_BOOL: return sizeof(bool);
    case FIELD_INT:
    case FIELD_CHOICE: return sizeof(int32_t);
    case FIELD_FLOAT: return sizeof(float);
    case FIELD_VEC2: return sizeof(snell_vec2);
    case FIELD_VEC3:
    case FIELD_COLOR: return sizeof(snell_vec3);
    case FIELD_INPUT:
    case FIELD_SCALAR: return sizeof(snell_input);
    case FIELD_STRING: return sizeof(const char *);
    case FIELD_TEXTURE: return sizeof(snell_texture_id);
    case FIELD_MATERIAL: return sizeof(snell_material_id);
    case FIELD_TRANSFORM: return sizeof(snell_transform);
    default: return sizeof(const void *) + sizeof(size_t);
    }
}

const char *field_kind_name(field_kind kind) {
    static const char *const names[] = {[FIELD_BOOL] = "true or false",
                                        [FIELD_INT] = "integer",
                                        [FIELD_FLOAT] = "number",
                                        [FIELD_VEC2] = "{x, y}",
                                        [FIELD_VEC3] = "{x, y, z}",
                                        [FIELD_COLOR] = "colour",
                                        [FIELD_INPUT] = "colour or texture",
                                        [FIELD_SCALAR] = "number or texture",
                                        [FIELD_CHOICE] = "word",
                                        [FIELD_STRING] = "text",
                                        [FIELD_TEXTURE] = "texture",
                                        [FIELD_MATERIAL] = "material",
                                        [FIELD_TRANSFORM] = "transform",
                                        [FIELD_VEC3S] = "list of {x, y, z}",
                                        [FIELD_VEC2S] = "list of pairs",
                                        [FIELD_FLOATS] = "list of numbers",
                                        [FIELD_UINTS] = "list of integers",
                                        [FIELD_BYTES] = "bytes",
                                        [FIELD_MATERIALS] = "list of materials",
                                        [FIELD_SHAPES] = "list of shapes",
                                        [FIELD_TRANSFORMS] = "list of transforms",
                                        [FIELD_KEYS] = "list of keys, or function"};
    return names[kind];
}

int choice_find(const char *choices, const char *word) {
    size_t length = strlen(word);
    int index = 0;
    for (const char *at = choices;; index++) {
        size_t here = strcspn(at, "|");
        if (here == length && strncmp(at, word, here) == 0) return index;
        if (at[here] == '\0') return -1;
        at += here + 1;
    }
}

void choice_word(const char *choices, int index, char *out, size_t size) {
    const char *at = choices;
    for (; index > 0 && *at; index--) {
        at += strcspn(at, "|");
        if (*at) at++;
    }
    snprintf(out, size, "%.*s", (int)strcspn(at, "|"), at);
}

static void *member(void *desc, const field *f) { return (char *)desc + f->offset; }

/* Array members are a pointer followed by a size_t, whatever the element type. */
typedef struct array_member {
    const void *data;
    size_t count;
} array_member;

void desc_init(const type_info *info, void *desc) {
    memset(desc, 0, info->desc_size);
    memcpy(desc, &info->desc_size, sizeof info->desc_size);
    for (uint32_t i = 0; i < info->field_count; i++) {
        const field *f = &info->fields[i];
        void *at = member(desc, f);
        snell_vec3 v = {f->initial[0], f->initial[1], f->initial[2]};
        switch (f->kind) {
        case FIELD_BOOL: *(bool *)at = f->initial[0] != 0; break;
        case FIELD_INT:
        case FIELD_CHOICE: *(int32_t *)at = (int32_t)f->initial[0]; break;
        case FIELD_FLOAT: *(float *)at = f->initial[0]; break;
        case FIELD_VEC2: *(snell_vec2 *)at = (snell_vec2){v.x, v.y}; break;
        case FIELD_VEC3:
        case FIELD_COLOR: *(snell_vec3 *)at = v; break;
        case FIELD_INPUT: ((snell_input *)at)->value = v; break;
        case FIELD_SCALAR: ((snell_input *)at)->value = (snell_vec3){v.x, v.x, v.x}; break;
        case FIELD_STRING: *(const char **)at = ""; break;
        case FIELD_TRANSFORM:
            *(snell_transform *)at = (snell_transform){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
            break;
        default: break; /* ids and arrays: none */
        }
    }
}

const field *type_find_field(const type_info *info, const char *name) {
    for (uint32_t i = 0; i < info->field_count; i++)
        if (strcmp(info->fields[i].name, name) == 0) return &info->fields[i];
    return NULL;
}

static snell_status unknown_field(const type_info *info, const char *name) {
    const char *names[64];
    size_t count = 0;
    char hint[512] = "it has ";
    for (uint32_t i = 0; i < info->field_count && count < 64; i++) {
        names[count++] = info->fields[i].name;
        size_t used = strlen(hint);
        snprintf(hint + used, sizeof hint - used, "%s%s", i ? ", " : "", info->fields[i].name);
    }
    const char *near = closest_word(name, names, count);
    if (near) snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    return error_set(SNELL_ERR_ARGUMENT, hint, "%s: unknown field '%s'", info->name, name);
}

static bool set_number(const field *f, void *at, double number, bool is_integer) {
    float value = (float)number;
    switch (f->kind) {
    case FIELD_INT:
        if (!is_integer && number != floor(number)) return false;
        if (!(number >= INT32_MIN && number <= INT32_MAX)) return false;
        *(int32_t *)at = (int32_t)number;
        return true;
    case FIELD_FLOAT: *(float *)at = value; return true;
    case FIELD_COLOR: *(snell_vec3 *)at = (snell_vec3){value, value, value}; return true;
    case FIELD_INPUT:
    case FIELD_SCALAR:
        *(snell_input *)at = (snell_input){{value, value, value}, {0, 0}};
        return true;
    default: return false;
    }
}

static bool set_value(const field *f, void *at, const snell_param *param) {
    bool array = field_element_size(f->kind) != 0;
    switch (param->kind) {
    case SNELL_PARAM_BOOL:
        if (f->kind == FIELD_BOOL) *(bool *)at = param->value.b;
        return f->kind == FIELD_BOOL;
    case SNELL_PARAM_INT: return set_number(f, at, (double)param->value.i, true);
    case SNELL_PARAM_FLOAT: return set_number(f, at, param->value.f, false);
    case SNELL_PARAM_VEC3:
        if (f->kind == FIELD_VEC3 || f->kind == FIELD_COLOR)
            *(snell_vec3 *)at = param->value.v;
        else if (f->kind == FIELD_VEC2)
            *(snell_vec2 *)at = (snell_vec2){param->value.v.x, param->value.v.y};
        else if (f->kind == FIELD_INPUT)
            *(snell_input *)at = (snell_input){param->value.v, {0, 0}};
        else
            return false;
        return true;
    case SNELL_PARAM_STRING:
        if (param->value.s == NULL) return false;
        if (f->kind == FIELD_STRING) {
            *(const char **)at = param->value.s;
            return true;
        }
        if (f->kind == FIELD_CHOICE) {
            int index = choice_find(f->choices, param->value.s);
            if (index >= 0) *(int32_t *)at = index;
            return index >= 0;
        }
        return false;
    case SNELL_PARAM_TEXTURE:
        if (f->kind == FIELD_TEXTURE)
            *(snell_texture_id *)at = param->value.texture;
        else if (f->kind == FIELD_INPUT || f->kind == FIELD_SCALAR)
            *(snell_input *)at = (snell_input){{1, 1, 1}, param->value.texture};
        else
            return false;
        return true;
    case SNELL_PARAM_INPUT:
        if (f->kind != FIELD_INPUT && f->kind != FIELD_SCALAR) return false;
        *(snell_input *)at = param->value.input;
        return true;
    case SNELL_PARAM_MATERIAL:
        if (f->kind == FIELD_MATERIAL) *(snell_material_id *)at = param->value.material;
        return f->kind == FIELD_MATERIAL;
    case SNELL_PARAM_TRANSFORM:
        if (f->kind == FIELD_TRANSFORM) *(snell_transform *)at = param->value.transform;
        return f->kind == FIELD_TRANSFORM;
    case SNELL_PARAM_ARRAY:
        if (!array || (param->value.array.data == NULL && param->value.array.count != 0))
            return false;
        *(array_member *)at = (array_member){param->value.array.data, param->value.array.count};
        return true;
    }
    return false;
}

snell_status desc_set(const type_info *info, void *desc, const snell_param *param) {
    if (param->name == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: a parameter without a name", info->name);
    const field *f = type_find_field(info, param->name);
    if (f == NULL) return unknown_field(info, param->name);
    if (set_value(f, member(desc, f), param)) return SNELL_OK;
    if (f->kind == FIELD_CHOICE)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' must be one of %s", info->name,
                         f->name, f->choices);
    return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' must be a %s", info->name, f->name,
                     field_kind_name(f->kind));
}

static snell_status check_number(const type_info *info, const field *f, double value) {
    if (!isfinite(value))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' is not a finite number", info->name,
                         f->name);
    /* Values are floats: a limit that is none means the float nearest to it. */
    double min = f->kind == FIELD_INT ? f->min : (double)(float)f->min,
           max = f->kind == FIELD_INT ? f->max : (double)(float)f->max;
    bool low = f->flags & FIELD_OPEN_MIN ? !(value > min) : value < min;
    if (!low && value <= max) return SNELL_OK;
    char bounds[96];
    if (isinf(f->max))
        snprintf(bounds, sizeof bounds, "%s %g",
                 f->flags & FIELD_OPEN_MIN ? "greater than" : "at least", f->min);
    else
        snprintf(bounds, sizeof bounds, "%s %g and at most %g",
                 f->flags & FIELD_OPEN_MIN ? "greater than" : "at least", f->min, f->max);
    return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' is %g; it must be %s", info->name, f->name,
                     value, bounds);
}

static snell_status check_vec3(const type_info *info, const field *f, snell_vec3 *v) {
    snell_status status = check_number(info, f, v->x);
    if (!status) status = check_number(info, f, v->y);
    if (!status) status = check_number(info, f, v->z);
    if (status || !(f->flags & FIELD_UNIT_LENGTH)) return status;
    double x = v->x, y = v->y, z = v->z, length = sqrt(x * x + y * y + z * z);
    if (!(length > 0))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' has no length", info->name, f->name);
    *v = (snell_vec3){(float)(x / length), (float)(y / length), (float)(z / length)};
    return SNELL_OK;
}

static snell_status check_array(const type_info *info, const field *f, const array_member *array) {
    size_t floats = f->kind == FIELD_VEC3S        ? 3
                    : f->kind == FIELD_VEC2S      ? 2
                    : f->kind == FIELD_FLOATS     ? 1
                    : f->kind == FIELD_TRANSFORMS ? 12
                                                  : 0;
    if (array->count > SIZE_MAX / 64)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' is too long", info->name, f->name);
    const float *numbers = array->data;
    size_t count = array->count * floats, known = 0; /* to be finite, from the first on */
    enum { BLOCK = 1024 };
    for (bool finite = true; finite && count - known >= BLOCK;) {
        /* Nothing ends the inner loop early, so that compilers make wide instructions of it. */
        uint32_t bad = 0, bits;
        for (size_t i = known; i < known + BLOCK; i++) {
            memcpy(&bits, &numbers[i], sizeof bits);
            bad |= (bits & 0x7f800000) == 0x7f800000;
        }
        finite = bad == 0;
        if (finite) known += BLOCK;
    }
    for (size_t i = known; i < count; i++)
        if (!isfinite(numbers[i]))
            return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' %zu is not a finite number",
                             info->name, f->name, i / floats);
    for (size_t i = 0; f->kind == FIELD_FLOATS && i < array->count; i++)
        if ((double)numbers[i] < f->min || (double)numbers[i] > f->max)
            return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' %zu is %g; it must be %s %g",
                             info->name, f->name, i, (double)numbers[i],
                             (double)numbers[i] < f->min ? "at least" : "at most",
                             (double)numbers[i] < f->min ? f->min : f->max);
    return SNELL_OK;
}

static snell_status check_field(const type_info *info, const field *f, void *at) {
    switch (f->kind) {
    case FIELD_INT: return check_number(info, f, *(int32_t *)at);
    case FIELD_CHOICE: {
        int words = 1;
        for (const char *c = f->choices; *c; c++) words += *c == '|';
        if (*(int32_t *)at >= 0 && *(int32_t *)at < words) return SNELL_OK;
        return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' must be one of %s", info->name,
                         f->name, f->choices);
    }
    case FIELD_FLOAT: return check_number(info, f, *(float *)at);
    case FIELD_VEC2: {
        snell_vec2 *v = at;
        snell_status status = check_number(info, f, v->x);
        return status ? status : check_number(info, f, v->y);
    }
    case FIELD_VEC3:
    case FIELD_COLOR: return check_vec3(info, f, at);
    case FIELD_INPUT: return check_vec3(info, f, &((snell_input *)at)->value);
    case FIELD_SCALAR: return check_number(info, f, ((snell_input *)at)->value.x);
    case FIELD_TRANSFORM: {
        const float *numbers = at;
        for (int i = 0; i < 12; i++)
            if (!isfinite(numbers[i]))
                return error_set(SNELL_ERR_ARGUMENT, NULL, "%s: '%s' is not finite", info->name,
                                 f->name);
        return SNELL_OK;
    }
    case FIELD_STRING:
        if (*(const char **)at == NULL) *(const char **)at = "";
        return SNELL_OK;
    default: break;
    }
    return field_element_size(f->kind) ? check_array(info, f, at) : SNELL_OK;
}

static bool any_is_given(const type_info *info, const bool *given, const char *names, size_t length,
                         const char **which) {
    for (uint32_t i = 0; i < info->field_count; i++) {
        if (!given[i]) continue;
        size_t own = strlen(info->fields[i].name);
        for (size_t at = 0; at < length; at += strcspn(names + at, " |;") + 1)
            if (strcspn(names + at, " |;") == own &&
                strncmp(names + at, info->fields[i].name, own) == 0) {
                *which = info->fields[i].name;
                return true;
            }
    }
    return false;
}

/* Of fields that stand for one another, those of one side only. */
static snell_status check_either(const type_info *info, const bool *given) {
    const char *first = NULL, *second = NULL, *side = info->either;
    while (side) {
        size_t length = strcspn(side, "|;");
        const char **found = first ? &second : &first;
        if (any_is_given(info, given, side, length, found) && second)
            return error_set(SNELL_ERR_ARGUMENT,
                             "leave one of them out: the one stands for the other",
                             "%s: both '%s' and '%s' are given", info->name, first, second);
        if (side[length] != '|') first = NULL; /* the next choice */
        side = side[length] ? side + length + 1 : NULL;
    }
    return SNELL_OK;
}

snell_status desc_check(const type_info *info, void *desc, const bool *given) {
    for (uint32_t i = 0; i < info->field_count; i++) {
        const field *f = &info->fields[i];
        if ((f->flags & FIELD_REQUIRED) && given && !given[i])
            return error_set(SNELL_ERR_ARGUMENT, f->help, "%s: '%s' is missing", info->name,
                             f->name);
        snell_status status = check_field(info, f, member(desc, f));
        if (status) return status;
    }
    return info->either && given ? check_either(info, given) : SNELL_OK;
}

void *desc_copy(const type_info *info, const void *desc) {
    char *copy = malloc(info->desc_size);
    if (copy == NULL) return NULL;
    memcpy(copy, desc, info->desc_size);
    for (uint32_t i = 0; i < info->field_count; i++) {
        const field *f = &info->fields[i];
        void *at = copy + f->offset;
        size_t size = field_element_size(f->kind);
        bool failed = false;
        if (f->kind == FIELD_STRING) {
            const char **text = at;
            *text = memory_copy_string(*text ? *text : "");
            failed = *text == NULL;
        } else if (size) {
            array_member *array = at;
            void *data = array->count && array->count <= SIZE_MAX / size
                             ? memory_aligned(array->count * size)
                             : NULL;
            failed = array->count && data == NULL;
            if (data) memcpy(data, array->data, array->count * size);
            array->data = data;
        }
        if (failed) { /* free only what was copied so far */
            type_info done = *info;
            done.field_count = i;
            desc_free(&done, copy);
            return NULL;
        }
    }
    return copy;
}

void desc_free(const type_info *info, void *desc) {
    if (desc == NULL) return;
    for (uint32_t i = 0; i < info->field_count; i++) {
        const field *f = &info->fields[i];
        void *at = member(desc, f);
        if (f->kind == FIELD_STRING)
            free(*(void **)at);
        else if (field_element_size(f->kind))
            free((void *)(uintptr_t)((array_member *)at)->data);
    }
    free(desc);
}
