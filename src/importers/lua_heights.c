/* heightfield { heights = function(x, z) .. end, .. }, heightfield { heights = { {0, 1}, {1, 2} } } and
 * heightfield { file = "hills.png", .. }: all become the plain form, a list of numbers, before the
 * fields are read. */
#include "importers/lua_scene.h"

#include "importers/image_decode.h"

static const char label[] = "heightfield";

/* Replaces the table at index 1 by a copy: the program's own stays as it is. */
static void copy_table(lua_State *L) {
    lua_newtable(L);
    for (lua_pushnil(L); lua_next(L, 1) != 0; lua_pop(L, 1)) {
        lua_pushvalue(L, -2);
        lua_pushvalue(L, -2);
        lua_rawset(L, -5);
    }
    lua_replace(L, 1);
}

static bool has(lua_State *L, const char *name) {
    lua_pushstring(L, name);
    bool there = lua_rawget(L, 1) != LUA_TNIL;
    lua_pop(L, 1);
    return there;
}

static int64_t read_count(lua_State *L, const char *name) {
    lua_pushstring(L, name);
    lua_rawget(L, 1);
    int whole;
    lua_Integer count = lua_tointegerx(L, -1, &whole);
    if (!whole || lua_type(L, -1) != LUA_TNUMBER || count < 2 || count > 65536)
        scene_fail(L, SNELL_ERR_SYNTAX, "heightfield { columns = 100, rows = 100, .. }",
                   "%s: '%s' must be an integer from 2 to 65536", label, name);
    lua_pop(L, 1);
    return count;
}

static void read_corner(lua_State *L, const char *name, double out[3]) {
    lua_pushstring(L, name);
    if (lua_rawget(L, 1) != LUA_TNIL) values_read_vec3(L, -1, label, name, out);
    lua_pop(L, 1);
}

/* The heights of the function on the top, at the x and z of each post. */
static void call_function(lua_State *L) {
    int function = lua_gettop(L);
    int64_t columns = read_count(L, "columns"), rows = read_count(L, "rows");
    double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    read_corner(L, "min", low);
    read_corner(L, "max", high);
    lua_newtable(L);
    for (int64_t row = 0; row < rows; row++)
        for (int64_t column = 0; column < columns; column++) {
            double along = (double)row / (double)(rows - 1),
                   across = (double)column / (double)(columns - 1);
            lua_pushvalue(L, function);
            lua_pushnumber(L, low[0] + (high[0] - low[0]) * across);
            lua_pushnumber(L, low[2] + (high[2] - low[2]) * along);
            lua_call(L, 2, 1);
            if (lua_type(L, -1) != LUA_TNUMBER)
                scene_fail(L, SNELL_ERR_SYNTAX, "heights = function(x, z) return 0.1 * x end",
                           "%s: the function 'heights' must return a number", label);
            lua_rawseti(L, -2, (lua_Integer)(row * columns + column) + 1);
        }
    lua_setfield(L, 1, "heights");
}

/* `name` is what the list says: if it is given too, it must be the same. */
static void set_count(lua_State *L, const char *name, size_t count) {
    if (has(L, name) && read_count(L, name) != (int64_t)count)
        scene_fail(L, SNELL_ERR_SYNTAX, "the list of rows says it: leave it out",
                   "%s: '%s' is %d, but 'heights' has %zu", label, name, (int)read_count(L, name),
                   count);
    lua_pushinteger(L, (lua_Integer)count);
    lua_setfield(L, 1, name);
}

/* The rows of the list on the top, one after the other. */
static void join_rows(lua_State *L) {
    int list = lua_gettop(L);
    size_t rows = (size_t)lua_rawlen(L, list), columns = 0;
    lua_newtable(L);
    for (size_t row = 0; row < rows; row++) {
        if (lua_rawgeti(L, list, (lua_Integer)row + 1) != LUA_TTABLE)
            scene_fail(L, SNELL_ERR_SYNTAX, "heights = { {0, 1, 0}, {1, 2, 1} }",
                       "%s: 'heights[%zu]' must be a list of numbers like the rows before it, not "
                       "a %s",
                       label, row + 1, luaL_typename(L, -1));
        size_t length = (size_t)lua_rawlen(L, -1);
        if (row == 0) columns = length;
        if (length != columns)
            scene_fail(L, SNELL_ERR_SYNTAX, "all rows have the same number of posts",
                       "%s: row %zu of 'heights' has %zu numbers, row 1 has %zu", label, row + 1,
                       length, columns);
        sandbox_charge(L, 4 * (uint64_t)length);
        for (size_t column = 0; column < columns; column++) {
            lua_rawgeti(L, -1, (lua_Integer)column + 1);
            values_read_entry(L, label, "heights", row + 1, column + 1);
            lua_rawseti(L, -3, (lua_Integer)(row * columns + column) + 1);
        }
        lua_pop(L, 1);
    }
    set_count(L, "columns", columns);
    set_count(L, "rows", rows);
    lua_setfield(L, 1, "heights");
}

static bool is_nested(lua_State *L) {
    lua_pushliteral(L, "heights");
    bool nested = false;
    if (lua_rawget(L, 1) == LUA_TTABLE) {
        nested = lua_rawgeti(L, -1, 1) == LUA_TTABLE;
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    return nested;
}

/* Grey, or the red channel, from 0 to 1; floats as they are. */
static void read_file(lua_State *L) {
    static const char *const said[] = {"heights", "columns", "rows"};
    for (int i = 0; i < 3; i++)
        if (has(L, said[i]))
            scene_fail(L, SNELL_ERR_SYNTAX, "the picture says it", "%s: both 'file' and '%s'",
                       label, said[i]);
    const decoded_image *image = files_read_image(L, values_get_string(L, label, "file"));
    size_t count = (size_t)image->width * image->height;
    const float *floats = (const void *)image->pixels; /* aligned: memory of its own */
    sandbox_charge(L, 4 * (uint64_t)count);
    lua_newtable(L);
    for (size_t i = 0; i < count; i++) {
        size_t at = i * image->channels;
        lua_pushnumber(L, image->floats ? (double)floats[at] : image->pixels[at] / 255.0);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_setfield(L, 1, "heights");
    lua_pushinteger(L, (lua_Integer)image->width);
    lua_setfield(L, 1, "columns");
    lua_pushinteger(L, (lua_Integer)image->height);
    lua_setfield(L, 1, "rows");
    lua_pushnil(L);
    lua_setfield(L, 1, "file");
}

void heights_expand(lua_State *L) {
    lua_pushliteral(L, "heights");
    bool function = lua_rawget(L, 1) == LUA_TFUNCTION;
    lua_pop(L, 1);
    bool file = has(L, "file"), nested = is_nested(L);
    if (!function && !file && !nested) return;
    copy_table(L);
    if (file) {
        read_file(L);
    } else {
        lua_pushliteral(L, "heights");
        lua_rawget(L, 1);
        if (nested)
            join_rows(L);
        else
            call_function(L);
    }
    lua_settop(L, 1);
}
