/* From Lua values to parameters of the generic API, by the types' own tables of fields. */
#include "importers/lua_scene.h"

#include <float.h>
#include <stdio.h>
#include <string.h>

#include "image/srgb.h"
#include "maths/functions.h"

/* ---- handles ---- */

typedef struct handle {
    uint32_t index;
    snell_vec3 factor; /* of a texture: what its colours are multiplied by */
} handle;

static void push_handle(lua_State *L, const char *kind, handle h) {
    handle *made = lua_newuserdatauv(L, sizeof *made, 0);
    *made = h;
    luaL_setmetatable(L, kind);
}

void handle_push(lua_State *L, const char *kind, uint32_t index) {
    push_handle(L, kind, (handle){index, {1, 1, 1}});
}

bool handle_get(lua_State *L, int index, const char *kind, uint32_t *out) {
    const handle *found = luaL_testudata(L, index, kind);
    if (found) *out = found->index;
    return found != NULL;
}

static bool is_one(snell_vec3 v) { return v.x == 1 && v.y == 1 && v.z == 1; }

/* ---- tables ---- */

void values_need_table(lua_State *L, const char *label) {
    if (!lua_istable(L, 1)) {
        char hint[128];
        snprintf(hint, sizeof hint, "write %s { ... }", label);
        scene_fail(L, SNELL_ERR_SYNTAX, hint, "%s: needs a table, not %s%s", label,
                   lua_isnoneornil(L, 1) ? "" : "a ",
                   lua_isnone(L, 1) ? "nothing" : luaL_typename(L, 1));
    }
    lua_settop(L, 1);
}

static bool is_listed(const char *word, const char *const *names, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (strcmp(names[i], word) == 0) return true;
    return false;
}

/* Of several wrong keys the alphabetically first is named, whatever the table's own order. */
void values_check_keys(lua_State *L, const char *label, const char *const *names, size_t count,
                       lua_Integer positional) {
    const char *wrong = NULL;
    for (lua_pushnil(L); lua_next(L, 1) != 0; lua_pop(L, 1)) {
        if (lua_type(L, -2) == LUA_TSTRING) {
            const char *key = lua_tostring(L, -2);
            if (!is_listed(key, names, count) && (wrong == NULL || strcmp(key, wrong) < 0))
                wrong = key;
            continue;
        }
        if (lua_isinteger(L, -2)) {
            lua_Integer at = lua_tointeger(L, -2);
            if (at >= 1 && at <= positional) continue;
        }
        const char *word = sandbox_tostring(L, -2);
        scene_fail(L, SNELL_ERR_SYNTAX, "write name = value", "%s: unexpected value [%s]", label,
                   word);
    }
    sandbox_charge(L, 8);
    if (wrong == NULL) return;
    const char *sorted[96];
    size_t kept = count < 96 ? count : 96;
    memcpy(sorted, names, kept * sizeof *sorted);
    char subject[96];
    snprintf(subject, sizeof subject, "%s: unknown field", label);
    scene_fail_unknown(L, label, subject, wrong, sorted, kept);
}

static bool get(lua_State *L, const char *name) {
    lua_pushstring(L, name);
    return lua_rawget(L, 1) != LUA_TNIL;
}

/* A short picture of the value at the top, for messages. */
static const char *shown(lua_State *L, int index) {
    index = lua_absindex(L, index);
    int kind = lua_type(L, index);
    if (kind == LUA_TSTRING) {
        const char *text = lua_tostring(L, index);
        if (strlen(text) <= 40) return lua_pushfstring(L, "'%s'", text);
        return lua_pushliteral(L, "a long text");
    }
    if (kind == LUA_TNUMBER || kind == LUA_TBOOLEAN) return sandbox_tostring(L, index);
    const char *name = sandbox_tostring(L, index);
    return lua_pushfstring(L, "a %s", name);
}

_Noreturn static void fail_kind(lua_State *L, int index, const char *label, const char *name,
                                const char *wanted) {
    index = lua_absindex(L, index);
    const char *article = wanted[0] == '{' || wanted[0] == 't' ? "" : "a ";
    if (strcmp(wanted, "integer") == 0) article = "an ";
    if (strcmp(wanted, "texture") == 0 || strcmp(wanted, "transform") == 0) article = "a ";
    scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: '%s' must be %s%s, not %s", label, name, article,
               wanted, shown(L, index));
}

/* What a field stores must be a finite float. */
static void check_finite(lua_State *L, const char *label, const char *name, double x) {
    if (x >= -(double)FLT_MAX && x <= (double)FLT_MAX) return;
    scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: '%s' is not a finite number", label, name);
}

double values_read_number(lua_State *L, int index, const char *label, const char *name) {
    if (lua_type(L, index) != LUA_TNUMBER) fail_kind(L, index, label, name, "number");
    double x = lua_tonumber(L, index);
    check_finite(L, label, name, x);
    return x;
}

static void read_numbers(lua_State *L, int index, const char *label, const char *name,
                         const char *wanted, int count, double *out) {
    index = lua_absindex(L, index);
    if (!lua_istable(L, index)) fail_kind(L, index, label, name, wanted);
    if (lua_rawlen(L, index) != (lua_Unsigned)count) {
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: '%s' must be %s: %d numbers, not %d", label,
                   name, wanted, count, (int)(lua_rawlen(L, index) & 0xffffff));
    }
    for (int i = 0; i < count; i++) {
        lua_rawgeti(L, index, i + 1);
        out[i] = values_read_number(L, -1, label, name);
        lua_pop(L, 1);
    }
}

void values_read_vec3(lua_State *L, int index, const char *label, const char *name, double out[3]) {
    read_numbers(L, index, label, name, "{x, y, z}", 3, out);
}

void values_refuse_both(lua_State *L, const char *label, const char *one, const char *other) {
    bool both = get(L, one);
    both &= get(L, other);
    lua_pop(L, 2);
    if (both)
        scene_fail(L, SNELL_ERR_SYNTAX, "leave one of them out: the one stands for the other",
                   "%s: both '%s' and '%s' are given", label, one, other);
}

const char *values_get_string(lua_State *L, const char *label, const char *name) {
    const char *text = NULL;
    if (get(L, name)) {
        if (lua_type(L, -1) != LUA_TSTRING) fail_kind(L, -1, label, name, "text");
        size_t size;
        text = lua_tolstring(L, -1, &size); /* alive in the argument's table */
        if (size == 0 || strlen(text) != size)
            scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: '%s' is empty or holds a zero byte", label,
                       name);
    }
    lua_pop(L, 1);
    return text;
}

bool values_get_bool(lua_State *L, const char *label, const char *name, bool absent) {
    bool value = absent;
    if (get(L, name)) {
        if (!lua_isboolean(L, -1)) fail_kind(L, -1, label, name, "true or false");
        value = lua_toboolean(L, -1);
    }
    lua_pop(L, 1);
    return value;
}

uint32_t values_get_material(lua_State *L, const char *label) {
    uint32_t index = NO_MATERIAL;
    if (get(L, "material") && !handle_get(L, -1, HANDLE_MATERIAL, &index))
        fail_kind(L, -1, label, "material", "material");
    lua_pop(L, 1);
    return index;
}

/* ---- colours ---- */

static bool read_color(lua_State *L, const char *label, const field *f, snell_param *out) {
    int kind = lua_type(L, -1);
    if (kind == LUA_TNUMBER) {
        out->kind = SNELL_PARAM_FLOAT;
        out->value.f = values_read_number(L, -1, label, f->name);
        return true;
    }
    out->kind = SNELL_PARAM_VEC3;
    if (kind == LUA_TSTRING) {
        if (srgb_read_hex(lua_tostring(L, -1), &out->value.v)) return true;
        scene_fail(L, SNELL_ERR_SYNTAX, "such as \"#ff8000\", {1, 0.2, 0} or 0.5",
                   "%s: '%s' is %s, which is not a colour", label, f->name, shown(L, -1));
    }
    if (kind != LUA_TTABLE) return false;
    double v[3];
    read_numbers(L, -1, label, f->name, "{r, g, b}", 3, v);
    out->value.v = (snell_vec3){(float)v[0], (float)v[1], (float)v[2]};
    return true;
}

/* texture * 0.5, texture * {r, g, b}: the same texture, its colours multiplied. */
int texture_multiply(lua_State *L) {
    static const field factor = {.name = "factor", .kind = FIELD_COLOR};
    const handle *given = luaL_testudata(L, 1, HANDLE_TEXTURE);
    int other = given ? 2 : 1;
    if (given == NULL) given = luaL_testudata(L, 2, HANDLE_TEXTURE);
    snell_param by;
    lua_pushvalue(L, other);
    if (given == NULL || lua_isuserdata(L, -1) || !read_color(L, "texture", &factor, &by))
        scene_fail(L, SNELL_ERR_SYNTAX, "such as wood * 0.5, or wood * {1, 0.8, 0.6}",
                   "a texture can only be multiplied by a number or a colour");
    float f = (float)by.value.f;
    snell_vec3 v = by.kind == SNELL_PARAM_FLOAT ? (snell_vec3){f, f, f} : by.value.v;
    push_handle(L, HANDLE_TEXTURE,
                (handle){given->index,
                         {given->factor.x * v.x, given->factor.y * v.y, given->factor.z * v.z}});
    return 1;
}

/* ---- words ---- */

static void read_choice(lua_State *L, const char *label, const field *f, snell_param *out) {
    if (lua_type(L, -1) != LUA_TSTRING) fail_kind(L, -1, label, f->name, "word");
    const char *word = lua_tostring(L, -1);
    out->kind = SNELL_PARAM_STRING;
    out->value.s = word;
    if (choice_find(f->choices, word) >= 0) return;
    char words[32][32], list[512] = "";
    const char *names[32];
    size_t count = 0, known = 1;
    for (const char *c = f->choices; *c; c++) known += *c == '|';
    for (size_t i = 0; i < known && count < 32; i++) {
        choice_word(f->choices, (int)i, words[count], sizeof words[count]);
        if (strcmp(words[count], "default") == 0) continue;
        size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", count ? ", " : "", words[count]);
        names[count] = words[count];
        count++;
    }
    if (scene_is_later("word", word)) {
        char hint[600];
        snprintf(hint, sizeof hint, "this version has %s", list);
        scene_fail(L, SNELL_ERR_UNSUPPORTED, hint, "%s: %s '%s' is not in this version", label,
                   f->name, word);
    }
    const char *near = closest_word(word, names, count);
    char hint[64];
    if (near) snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    scene_fail(L, SNELL_ERR_SYNTAX, near ? hint : NULL, "%s: '%s' is %s; it must be one of %s",
               label, f->name, shown(L, -1), list);
}

/* ---- lists ---- */

/* How many values a list has in all: {1, 2, 3}, or {{1, 2, 3}, ...} with `width` in each. */
static size_t list_length(lua_State *L, int list, const char *label, const field *f, size_t width) {
    size_t length = (size_t)lua_rawlen(L, list);
    sandbox_charge(L, 4 * (uint64_t)length);
    lua_rawgeti(L, list, 1);
    bool nested = lua_istable(L, -1);
    lua_pop(L, 1);
    if (nested) return length * width;
    if (length % width != 0)
        scene_fail(L, SNELL_ERR_SYNTAX, NULL,
                   "%s: '%s' has %llu numbers, which is not a multiple of %d", label, f->name,
                   (unsigned long long)length, (int)width);
    return length;
}

double values_read_entry(lua_State *L, const char *label, const char *name, size_t row,
                         size_t column) {
    double x = lua_type(L, -1) == LUA_TNUMBER ? lua_tonumber(L, -1) : NAN;
    if (x >= -(double)FLT_MAX && x <= (double)FLT_MAX) return x;
    char place[128];
    if (column)
        snprintf(place, sizeof place, "%.60s[%zu][%zu]", name, row, column);
    else
        snprintf(place, sizeof place, "%.60s[%zu]", name, row);
    return values_read_number(L, -1, label, place);
}

/* Pushes number `at` (from 0) of a plain or nested list. */
static void push_element(lua_State *L, int list, const char *label, const field *f, size_t at,
                         size_t width) {
    if (lua_rawgeti(L, list, 1) != LUA_TTABLE) {
        lua_pop(L, 1);
        lua_rawgeti(L, list, (lua_Integer)at + 1);
        return;
    }
    lua_pop(L, 1);
    size_t row = at / width;
    if (lua_rawgeti(L, list, (lua_Integer)row + 1) != LUA_TTABLE ||
        lua_rawlen(L, -1) != (lua_Unsigned)width)
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: '%s' [%llu] must be %d numbers in braces", label,
                   f->name, (unsigned long long)row + 1, (int)width);
    lua_rawgeti(L, -1, (lua_Integer)(at % width) + 1);
    lua_remove(L, -2);
}

static void read_floats(lua_State *L, const char *label, const field *f, size_t width,
                        snell_param *out) {
    int list = lua_gettop(L);
    size_t count = list_length(L, list, label, f, width);
    bool nested = lua_rawgeti(L, list, 1) == LUA_TTABLE;
    lua_pop(L, 1);
    float *made = lua_newuserdatauv(L, (count + 1) * sizeof *made, 0);
    for (size_t i = 0; i < count; i++) {
        push_element(L, list, label, f, i, width);
        made[i] = (float)values_read_entry(L, label, f->name, (nested ? i / width : i) + 1,
                                           nested ? i % width + 1 : 0);
        lua_pop(L, 1);
    }
    out->value.array.data = made;
    out->value.array.count = count / width;
}

static uint32_t read_whole(lua_State *L, const char *label, const field *f, lua_Integer max) {
    int whole;
    lua_Integer value = lua_type(L, -1) == LUA_TNUMBER ? lua_tointegerx(L, -1, &whole) : -1;
    if (lua_type(L, -1) != LUA_TNUMBER || !whole || value < 0 || value > max)
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: '%s' holds %s, not an integer from 0 to %llu",
                   label, f->name, shown(L, -1), (unsigned long long)max);
    return (uint32_t)value;
}

static void read_list(lua_State *L, const char *label, const field *f, snell_param *out) {
    if (!lua_istable(L, -1)) fail_kind(L, -1, label, f->name, field_kind_name(f->kind));
    out->kind = SNELL_PARAM_ARRAY;
    size_t floats = f->kind == FIELD_VEC3S    ? 3
                    : f->kind == FIELD_VEC2S  ? 2
                    : f->kind == FIELD_FLOATS ? 1
                                              : 0;
    if (floats) {
        read_floats(L, label, f, floats, out);
        return;
    }
    int list = lua_gettop(L);
    size_t width = f->kind == FIELD_UINTS ? 3 : 1; /* triangles may be in braces of their own */
    bool nested = lua_rawgeti(L, list, 1) == LUA_TTABLE;
    lua_pop(L, 1);
    if (!nested) width = 1;
    size_t count = list_length(L, list, label, f, width);
    char *made = lua_newuserdatauv(L, (count + 1) * sizeof(snell_material_id), 0);
    for (size_t i = 0; i < count; i++) {
        push_element(L, list, label, f, i, width);
        if (f->kind == FIELD_UINTS) {
            ((uint32_t *)(void *)made)[i] = read_whole(L, label, f, UINT32_MAX);
        } else if (f->kind == FIELD_BYTES) {
            ((uint8_t *)made)[i] = (uint8_t)read_whole(L, label, f, 255);
        } else {
            uint32_t index;
            if (!handle_get(L, -1, HANDLE_MATERIAL, &index))
                fail_kind(L, -1, label, f->name, "list of materials");
            ((snell_material_id *)(void *)made)[i] = (snell_material_id){index + 1, 0};
        }
        lua_pop(L, 1);
    }
    out->value.array.data = made;
    out->value.array.count = count;
}

/* ---- any field ---- */

/* Angles are degrees here and radians inside; the range is checked in degrees too. */
static double read_angle(lua_State *L, const char *label, const field *f) {
    double degrees = values_read_number(L, -1, label, f->name), turn = 180 / PI;
    if (degrees < f->min * turn || degrees > f->max * turn)
        scene_fail(L, SNELL_ERR_SYNTAX, NULL,
                   "%s: '%s' is %.6g degrees; it must be at least %.4g and at most %.6g", label,
                   f->name, degrees, f->min * turn, f->max * turn);
    return degrees / turn;
}

static void read_integer(lua_State *L, const char *label, const field *f, snell_param *out) {
    int whole;
    out->kind = SNELL_PARAM_INT;
    out->value.i = lua_tointegerx(L, -1, &whole);
    if (!whole && lua_tonumber(L, -1) == floor(lua_tonumber(L, -1)))
        out->value.i = INT64_MAX;
    else if (!whole)
        fail_kind(L, -1, label, f->name, "integer");
    if (out->value.i < INT32_MIN || out->value.i > INT32_MAX)
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: '%s' is %s, which is out of range", label,
                   f->name, shown(L, -1));
}

static void read_number_field(lua_State *L, const char *label, const field *f, snell_param *out) {
    if (f->kind == FIELD_INT) {
        read_integer(L, label, f, out);
        return;
    }
    out->kind = SNELL_PARAM_FLOAT;
    out->value.f = strcmp(f->unit, "rad") == 0 ? read_angle(L, label, f)
                                               : values_read_number(L, -1, label, f->name);
}

static void read_reference(lua_State *L, const char *label, const field *f, snell_param *out) {
    uint32_t index;
    const char *wanted = f->kind == FIELD_MATERIAL ? HANDLE_MATERIAL : HANDLE_TEXTURE;
    if (!handle_get(L, -1, wanted, &index)) fail_kind(L, -1, label, f->name, wanted);
    if (!is_one(((const handle *)lua_touserdata(L, -1))->factor))
        scene_fail(L, SNELL_ERR_SYNTAX, "give the texture itself",
                   "%s: '%s' takes a texture as it is, not a multiple of one", label, f->name);
    if (f->kind == FIELD_MATERIAL) {
        out->kind = SNELL_PARAM_MATERIAL;
        out->value.material = (snell_material_id){index + 1, 0};
    } else {
        out->kind = SNELL_PARAM_TEXTURE;
        out->value.texture = (snell_texture_id){index + 1, 0};
    }
}

static void read_vector(lua_State *L, const char *label, const field *f, snell_param *out) {
    double v[3] = {0, 0, 0};
    int count = f->kind == FIELD_VEC2 ? 2 : 3;
    read_numbers(L, -1, label, f->name, count == 2 ? "{x, y}" : "{x, y, z}", count, v);
    out->kind = SNELL_PARAM_VEC3;
    out->value.v = (snell_vec3){(float)v[0], (float)v[1], (float)v[2]};
}

void values_read_field(lua_State *L, const type_info *type, const field *f, const char *label,
                       snell_param *out) {
    (void)type;
    const char *wanted = field_kind_name(f->kind);
    out->name = f->name;
    switch (f->kind) {
    case FIELD_BOOL:
        if (!lua_isboolean(L, -1)) fail_kind(L, -1, label, f->name, wanted);
        out->kind = SNELL_PARAM_BOOL;
        out->value.b = lua_toboolean(L, -1);
        break;
    case FIELD_INT:
    case FIELD_FLOAT:
        if (lua_type(L, -1) != LUA_TNUMBER) fail_kind(L, -1, label, f->name, wanted);
        read_number_field(L, label, f, out);
        break;
    case FIELD_VEC2:
    case FIELD_VEC3: read_vector(L, label, f, out); break;
    case FIELD_COLOR:
        if (!read_color(L, label, f, out)) fail_kind(L, -1, label, f->name, wanted);
        break;
    case FIELD_INPUT:
    case FIELD_SCALAR:
        if (lua_isuserdata(L, -1)) {
            const handle *given = luaL_testudata(L, -1, HANDLE_TEXTURE);
            if (given == NULL) fail_kind(L, -1, label, f->name, wanted);
            out->kind = SNELL_PARAM_INPUT;
            out->value.input = (snell_input){given->factor, {given->index + 1, 0}};
        } else if (f->kind == FIELD_SCALAR && lua_type(L, -1) == LUA_TNUMBER) {
            out->kind = SNELL_PARAM_FLOAT;
            out->value.f = values_read_number(L, -1, label, f->name);
        } else if (f->kind == FIELD_SCALAR || !read_color(L, label, f, out)) {
            fail_kind(L, -1, label, f->name, wanted);
        }
        break;
    case FIELD_CHOICE: read_choice(L, label, f, out); break;
    case FIELD_STRING:
        if (lua_type(L, -1) == LUA_TNUMBER && (f->flags & FIELD_OR_NUMBER) != 0) {
            lua_pushvalue(L, -1); /* its text is kept until another takes its place */
            out->value.s = lua_tostring(L, -1);
            lua_setfield(L, LUA_REGISTRYINDEX, f->name);
        } else if (lua_type(L, -1) == LUA_TSTRING) {
            out->value.s = lua_tostring(L, -1);
        } else {
            fail_kind(L, -1, label, f->name, wanted);
        }
        out->kind = SNELL_PARAM_STRING;
        break;
    case FIELD_TEXTURE:
    case FIELD_MATERIAL: read_reference(L, label, f, out); break;
    case FIELD_TRANSFORM: {
        const placement *given = luaL_testudata(L, -1, HANDLE_TRANSFORM);
        if (given == NULL) fail_kind(L, -1, label, f->name, wanted);
        out->kind = SNELL_PARAM_TRANSFORM;
        out->value.transform = dtransform_round(given);
        break;
    }
    case FIELD_KEYS: motion_read_keys(L, label, f, out); break;
    default: read_list(L, label, f, out); break;
    }
}

/* ---- memory that is not Lua's ---- */

static int box_collect(lua_State *L) {
    box *b = lua_touserdata(L, 1);
    if (b->held) b->destroy(b->held);
    b->held = NULL;
    return 0;
}

box *box_push(lua_State *L, void (*destroy)(void *held)) {
    box *b = lua_newuserdatauv(L, sizeof *b, 0);
    *b = (box){NULL, destroy};
    if (luaL_newmetatable(L, HANDLE_BOX)) {
        lua_pushcfunction(L, box_collect);
        lua_setfield(L, -2, "__gc");
    }
    lua_setmetatable(L, -2);
    return b;
}
