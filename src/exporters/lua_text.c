#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "exporters/lua_export.h"
#include "maths/functions.h"

void put(lua_export *e, const char *format, ...) {
    if (e->status) return;
    va_list list, again;
    va_start(list, format);
    va_copy(again, list);
    int length = vsnprintf(NULL, 0, format, list);
    if (length < 0 || !ARRAY_GROW(e->text, e->size, e->capacity, (size_t)length + 1)) {
        e->status = error_no_memory();
    } else {
        vsnprintf(e->text + e->size, (size_t)length + 1, format, again);
        e->size += (size_t)length;
    }
    va_end(again);
    va_end(list);
}

void put_end(lua_export *e) {
    if (e->size && e->text[e->size - 1] == ',') e->text[--e->size] = '\0';
    put(e, " }");
}

/* The shortest text for which `is` holds, of numbers near `value`. */
static void shortest(double value, bool (*is)(double given, float wanted), float wanted,
                     char out[40]) {
    for (int digits = 1; digits <= 17; digits++) {
        snprintf(out, 40, "%.*g", digits, value);
        double given = strtod(out, NULL);
        if (!is(given, wanted)) continue;
        if (given == floor(given) && fabs(given) < 1e7)
            snprintf(out, 40, "%.0f", given); /* 2e+01 */
        return;
    }
}

static bool is_float(double given, float wanted) { return (float)given == wanted; }

void put_float(lua_export *e, float value) {
    char text[40];
    shortest((double)value, is_float, value, text);
    put(e, "%s", value == 0 && signbit(value) ? "-0.0" : text); /* -0 is the integer */
}

/* As lua_values.c reads an angle. */
static bool is_angle(double given, float wanted) { return (float)(given / (180 / PI)) == wanted; }

void put_angle(lua_export *e, float radians) {
    char text[40];
    shortest((double)radians * (180 / PI), is_angle, radians, text);
    put(e, "%s", radians == 0 && signbit(radians) ? "-0.0" : text);
}

enum { NUMBERS_A_LINE = 24 };

void put_floats(lua_export *e, const float *values, size_t count) {
    put(e, "{");
    for (size_t i = 0; i < count; i++) {
        if (i) put(e, i % NUMBERS_A_LINE ? ", " : ",\n    ");
        put_float(e, values[i]);
    }
    put(e, "}");
}

void put_rows(lua_export *e, const float *values, size_t count, size_t width) {
    enum { ROWS_MAX = 256 };
    if (width == 1 || count > ROWS_MAX) {
        put_floats(e, values, count * width);
        return;
    }
    put(e, "{");
    for (size_t i = 0; i < count; i++) {
        if (i) put(e, i % (NUMBERS_A_LINE / 3) ? ", " : ",\n    ");
        put_floats(e, values + i * width, width);
    }
    put(e, "}");
}

static snell_vec3 normalize(snell_vec3 v) {
    double x = (double)v.x, y = (double)v.y, z = (double)v.z, length = sqrt(x * x + y * y + z * z);
    return (snell_vec3){(float)(x / length), (float)(y / length), (float)(z / length)};
}

/* A rounded unit vector is not always its own normalised one: then a longer one is looked for that
 * is rounded to it. Once by the helper, once by who reads the helper's records. */
void put_direction(lua_export *e, const char *what, snell_vec3 v) {
    enum { TRIES = 1 << 16 };
    snell_vec3 given = v;
    for (int i = 1;; i++) {
        snell_vec3 read = normalize(normalize(given));
        if (memcmp(&read, &v, sizeof v) == 0) break;
        if (i == TRIES) {
            e->status = error_set(SNELL_ERR_UNSUPPORTED, "a compiled scene (.snell) holds all",
                                  "%s: no numbers become exactly this direction", what);
            return;
        }
        double longer = 1 + i * 0.00137;
        given = (snell_vec3){(float)((double)v.x * longer), (float)((double)v.y * longer),
                             (float)((double)v.z * longer)};
    }
    put_floats(e, &given.x, 3);
}

void put_string(lua_export *e, const char *text) {
    put(e, "\"");
    for (; *text; text++) {
        unsigned char c = (unsigned char)*text;
        if (c == '"' || c == '\\')
            put(e, "\\%c", c);
        else if (c < ' ' || c == 0x7f)
            put(e, "\\%03d", c);
        else
            put(e, "%c", c);
    }
    put(e, "\"");
}

/* ---- transforms: by name where that says the same bits ---- */

static bool is_matrix(const transform *t, float x, float y, float z, vec3 offset) {
    const transform other = {{{x, 0, 0, offset.x}, {0, y, 0, offset.y}, {0, 0, z, offset.z}}};
    return memcmp(t, &other, sizeof other) == 0;
}

void put_transform(lua_export *e, const transform *t) {
    vec3 offset = {t->m[0][3], t->m[1][3], t->m[2][3]};
    float scale[3] = {t->m[0][0], t->m[1][1], t->m[2][2]};
    if (is_matrix(t, 1, 1, 1, offset)) {
        put(e, "transform.translate ");
        put_floats(e, &offset.x, 3);
    } else if (is_matrix(t, scale[0], scale[1], scale[2], (vec3){0, 0, 0})) {
        put(e, "transform.scale ");
        put_floats(e, scale, 3);
    } else {
        put(e, "transform.matrix { ");
        for (int i = 0; i < 3; i++) {
            put_floats(e, t->m[i], 4);
            put(e, i < 2 ? ", " : " }");
        }
    }
}

void put_keys(lua_export *e, const motion_key *keys, size_t count) {
    put(e, "{");
    for (size_t i = 0; i < count; i++) {
        put(e, "\n    { time = ");
        put_float(e, keys[i].time);
        put(e, ", transform = ");
        put_transform(e, &keys[i].transform);
        put(e, " },");
    }
    put(e, "\n}");
}

/* ---- names ---- */

static bool is_identifier(const char *name) {
    static const char *const words[] = {"and",   "break", "do",       "else",  "elseif", "end",
                                        "false", "for",   "function", "goto",  "if",     "in",
                                        "local", "nil",   "not",      "or",    "repeat", "return",
                                        "then",  "true",  "until",    "while", NULL};
    if (!isalpha((unsigned char)*name) && *name != '_') return false;
    for (const char *c = name; *c; c++)
        if (!isalnum((unsigned char)*c) && *c != '_') return false;
    for (int i = 0; words[i]; i++)
        if (strcmp(words[i], name) == 0) return false;
    return true;
}

void put_name(lua_export *e, const char *prefix, category which, uint32_t index) {
    const char *name = e->d->objects[which].items[index].name;
    put(e, "%s", prefix);
    if (name[0] == '\0') {
        put(e, "[%u]", index + 1);
    } else if (is_identifier(name)) {
        put(e, ".%s", name);
    } else {
        put(e, "[");
        put_string(e, name);
        put(e, "]");
    }
}

void fail_object(lua_export *e, category which, uint32_t index, const char *hint,
                 const char *format, ...) {
    if (e->status) return;
    char what[256], label[256];
    va_list list;
    va_start(list, format);
    vsnprintf(what, sizeof what, format, list);
    va_end(list);
    const object *o = &e->d->objects[which].items[index];
    description_object_label(e->d, which, index, label, sizeof label);
    e->status = error_set_at(SNELL_ERR_UNSUPPORTED, (source_place){o->file, o->line, 0}, hint,
                             "%s %s: %s", o->type->name, label, what);
}
