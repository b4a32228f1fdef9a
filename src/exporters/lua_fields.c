/* Objects by their types' own tables, as lua_values.c reads them. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "exporters/lua_export.h"

typedef struct list {
    const void *data;
    size_t count;
} list;

static list list_of(const void *member) {
    list l;
    memcpy(&l, member, sizeof l);
    return l;
}

size_t count_numbers(const object *o) {
    size_t sum = 0;
    for (uint32_t i = 0; i < o->type->field_count; i++) {
        const field *f = &o->type->fields[i];
        size_t element = field_element_size(f->kind), width = element < 4 ? 1 : element / 4;
        if (element) sum += list_of((const char *)o->desc + f->offset).count * width;
    }
    return sum;
}

static void put_ids(lua_export *e, category which, uint32_t index, const field *f, list l) {
    const snell_material_id *ids = l.data;
    put(e, "{");
    for (size_t i = 0; i < l.count; i++) {
        if (i) put(e, ", ");
        if (ids[i].index1)
            put_name(e, "m", CATEGORY_MATERIAL, ids[i].index1 - 1);
        else
            fail_object(e, which, index, NULL, "'%s' has a gap", f->name);
    }
    put(e, "}");
}

static void put_whole(lua_export *e, const void *data, size_t count, bool bytes) {
    put(e, "{");
    for (size_t i = 0; i < count; i++) {
        if (i) put(e, i % 24 ? ", " : ",\n    ");
        put(e, "%u", bytes ? ((const uint8_t *)data)[i] : ((const uint32_t *)data)[i]);
    }
    put(e, "}");
}

static void put_list(lua_export *e, category which, uint32_t index, const field *f, list l) {
    size_t width = f->kind == FIELD_VEC3S ? 3 : f->kind == FIELD_VEC2S ? 2 : 1;
    switch (f->kind) {
    case FIELD_VEC3S:
    case FIELD_VEC2S:
    case FIELD_FLOATS: put_rows(e, l.data, l.count, width); break;
    case FIELD_UINTS: put_whole(e, l.data, l.count, false); break;
    case FIELD_BYTES: put_whole(e, l.data, l.count, true); break;
    case FIELD_MATERIALS: put_ids(e, which, index, f, l); break;
    case FIELD_KEYS: put_keys(e, l.data, l.count); break;
    default: fail_object(e, which, index, NULL, "'%s' cannot be said", f->name); break;
    }
}

static void put_color(lua_export *e, snell_vec3 v) {
    if (memcmp(&v.x, &v.y, sizeof v.x) == 0 && memcmp(&v.y, &v.z, sizeof v.x) == 0)
        put_float(e, v.x);
    else
        put_floats(e, &v.x, 3);
}

/* A number or colour, a texture, or a texture times either. */
static void put_input(lua_export *e, const snell_input *input, bool scalar) {
    const snell_vec3 one = {1, 1, 1};
    snell_vec3 v = input->value;
    if (scalar) v.y = v.z = v.x;
    if (input->texture.index1) {
        put_name(e, "t", CATEGORY_TEXTURE, input->texture.index1 - 1);
        if (memcmp(&v, &one, sizeof v) == 0) return;
        put(e, " * ");
    }
    put_color(e, v);
}

static void put_value(lua_export *e, category which, uint32_t index, const field *f,
                      const void *member) {
    char word[64];
    switch (f->kind) {
    case FIELD_BOOL: put(e, "%s", *(const bool *)member ? "true" : "false"); break;
    case FIELD_INT: put(e, "%d", *(const int32_t *)member); break;
    case FIELD_FLOAT:
        if (strcmp(f->unit, "rad") == 0)
            put_angle(e, *(const float *)member);
        else
            put_float(e, *(const float *)member);
        break;
    case FIELD_VEC2: put_floats(e, member, 2); break;
    case FIELD_VEC3:
        if (f->flags & FIELD_UNIT_LENGTH)
            put_direction(e, f->name, *(const snell_vec3 *)member);
        else
            put_floats(e, member, 3);
        break;
    case FIELD_COLOR: put_color(e, *(const snell_vec3 *)member); break;
    case FIELD_INPUT:
    case FIELD_SCALAR: put_input(e, member, f->kind == FIELD_SCALAR); break;
    case FIELD_CHOICE:
        choice_word(f->choices, *(const int32_t *)member, word, sizeof word);
        put_string(e, word);
        break;
    case FIELD_STRING: put_string(e, *(const char *const *)member); break;
    case FIELD_TEXTURE:
        put_name(e, "t", CATEGORY_TEXTURE, ((const snell_texture_id *)member)->index1 - 1);
        break;
    case FIELD_MATERIAL:
        put_name(e, "m", CATEGORY_MATERIAL, ((const snell_material_id *)member)->index1 - 1);
        break;
    case FIELD_TRANSFORM: put_transform(e, member); break;
    default: put_list(e, which, index, f, list_of(member)); break;
    }
}

static bool is_default(const field *f, const void *member, const void *initial) {
    if (f->kind == FIELD_STRING) return (*(const char *const *)member)[0] == '\0';
    if (field_element_size(f->kind)) return list_of(member).count == 0;
    if (f->kind == FIELD_MATERIAL) return ((const snell_material_id *)member)->index1 == 0;
    if (f->kind == FIELD_TEXTURE) return ((const snell_texture_id *)member)->index1 == 0;
    return memcmp(member, initial, field_size(f->kind)) == 0;
}

/* Of fields that stand for one another the reader takes those of one side only. */
static void check_either(lua_export *e, category which, uint32_t index, const bool *given) {
    const type_info *type = e->d->objects[which].items[index].type;
    const char *at = type->either, *first = NULL;
    while (at && *at) {
        size_t length = strcspn(at, " |;");
        for (uint32_t i = 0; i < type->field_count; i++) {
            const char *name = type->fields[i].name;
            if (!given[i] || strlen(name) != length || strncmp(name, at, length) != 0) continue;
            if (first && memchr(first, '|', (size_t)(at - first)))
                fail_object(e, which, index, NULL, "'%.*s' and '%s' cannot both be given",
                            (int)strcspn(first, " |;"), first, name);
            first = at;
        }
        at += length;
        if (*at == ';') first = NULL;
        at += *at != '\0';
    }
}

void put_fields(lua_export *e, category which, uint32_t index, const char *skip) {
    const object *o = &e->d->objects[which].items[index];
    const type_info *type = o->type;
    char *initial = memory_zeroed(1, type->desc_size);
    bool *given = memory_zeroed(type->field_count + 1, sizeof *given);
    if (initial && given) {
        desc_init(type, initial);
        for (uint32_t i = 0; i < type->field_count; i++) {
            const field *f = &type->fields[i];
            const void *member = (const char *)o->desc + f->offset;
            if (skip && choice_find(skip, f->name) >= 0) continue;
            given[i] = (f->flags & FIELD_REQUIRED) || !is_default(f, member, initial + f->offset);
            if (!given[i]) continue;
            put(e, " %s = ", f->name);
            put_value(e, which, index, f, member);
            put(e, ",");
        }
        check_either(e, which, index, given);
    } else if (!e->status) {
        e->status = error_no_memory();
    }
    free(initial);
    free(given);
}
