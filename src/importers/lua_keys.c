/* mesh { keys = { {time = 0, positions = {..}, normals = {..}}, .. }, indices = .. }: becomes the plain
 * form, key_times and one list of positions and of normals, before the fields are read. */
#include "importers/lua_scene.h"

#include <stdio.h>
#include <string.h>

static const char label[] = "mesh";
static const char form[] = "keys = { {time = 0, positions = {..}}, {time = 1, positions = {..}} }";

/* Leaves the value on the stack. */
static int get(lua_State *L, int table, const char *name) {
    table = lua_absindex(L, table);
    lua_pushstring(L, name);
    return lua_rawget(L, table);
}

static void check_names(lua_State *L, int key, lua_Integer number) {
    for (lua_pushnil(L); lua_next(L, key) != 0; lua_pop(L, 1)) {
        const char *name = lua_type(L, -2) == LUA_TSTRING ? lua_tostring(L, -2) : "a number";
        if (strcmp(name, "time") != 0 && strcmp(name, "positions") != 0 &&
            strcmp(name, "normals") != 0)
            scene_fail(L, SNELL_ERR_SYNTAX, form,
                       "%s: 'keys' [%d] has 'time', 'positions' and 'normals', not '%s'", label,
                       (int)number, name);
    }
}

/* The value on the top, entry number `at` of the list `place`, is a finite number or a list of such:
 * later nobody knows of which key it was. */
static void check_entry(lua_State *L, const char *place, lua_Integer at) {
    if (lua_type(L, -1) == LUA_TNUMBER) values_read_entry(L, label, place, (size_t)at, 0);
    lua_Integer count = lua_istable(L, -1) ? (lua_Integer)lua_rawlen(L, -1) : 0;
    for (lua_Integer i = 1; i <= count && i <= 3; i++) {
        lua_rawgeti(L, -1, i);
        values_read_entry(L, label, place, (size_t)at, (size_t)i);
        lua_pop(L, 1);
    }
}

/* Adds the key's list of this name to the list `all`; returns how many values there are. */
static lua_Integer append(lua_State *L, int key, lua_Integer number, const char *name, int all) {
    int kind = get(L, key, name);
    if (kind != LUA_TTABLE && kind != LUA_TNIL)
        scene_fail(L, SNELL_ERR_SYNTAX, form, "%s: '%s' of key %d must be a list, not a %s", label,
                   name, (int)number, luaL_typename(L, -1));
    lua_Integer count = kind == LUA_TNIL ? 0 : (lua_Integer)lua_rawlen(L, -1),
                before = (lua_Integer)lua_rawlen(L, all);
    sandbox_charge(L, (uint64_t)count);
    char place[48];
    snprintf(place, sizeof place, "keys[%d].%s", (int)number, name);
    for (lua_Integer i = 1; i <= count; i++) {
        lua_rawgeti(L, -1, i);
        check_entry(L, place, i);
        lua_rawseti(L, all, before + i);
    }
    lua_pop(L, 1);
    return count;
}

/* Every key has as many as the first. */
static void check_count(lua_State *L, const char *name, lua_Integer number, lua_Integer count,
                        lua_Integer first) {
    if (count != first)
        scene_fail(L, SNELL_ERR_SYNTAX, "vertices move, none comes or goes",
                   "%s: key %d has %d entries of '%s', the first has %d", label, (int)number,
                   (int)count, name, (int)first);
}

static void append_time(lua_State *L, int key, lua_Integer number, int times) {
    if (get(L, key, "time") == LUA_TNIL)
        scene_fail(L, SNELL_ERR_SYNTAX, form, "%s: 'keys' [%d] has no 'time'", label, (int)number);
    values_read_number(L, -1, label, "time");
    lua_rawseti(L, times, number);
}

void mesh_keys_expand(lua_State *L) {
    static const char *const plain[] = {"positions", "normals", "key_times"};
    if (get(L, 1, "keys") == LUA_TNIL) {
        lua_settop(L, 1);
        return;
    }
    for (int i = 0; i < 3; i++) {
        if (get(L, 1, plain[i]) != LUA_TNIL)
            scene_fail(L, SNELL_ERR_SYNTAX, form, "%s: both 'keys' and '%s'", label, plain[i]);
        lua_pop(L, 1);
    }
    if (!lua_istable(L, -1))
        scene_fail(L, SNELL_ERR_SYNTAX, form, "%s: 'keys' must be a list of keys, not a %s", label,
                   luaL_typename(L, -1));
    lua_Integer count = (lua_Integer)lua_rawlen(L, -1), vertices = 0, normals = 0;
    if (count == 0) scene_fail(L, SNELL_ERR_SYNTAX, form, "%s: 'keys' has no key", label);
    for (int i = 0; i < 3; i++) lua_newtable(L); /* at 3, 4 and 5, as in `plain` */
    for (lua_Integer k = 1; k <= count; k++) {
        if (lua_rawgeti(L, 2, k) != LUA_TTABLE)
            scene_fail(L, SNELL_ERR_SYNTAX, form, "%s: 'keys' [%d] must be a table", label, (int)k);
        check_names(L, 6, k);
        append_time(L, 6, k, 5);
        lua_Integer here = append(L, 6, k, "positions", 3), smooth = append(L, 6, k, "normals", 4);
        if (k == 1) vertices = here, normals = smooth;
        check_count(L, "positions", k, here, vertices);
        check_count(L, "normals", k, smooth, normals);
        lua_settop(L, 5);
    }
    lua_newtable(L); /* the program's own table stays as it is */
    for (lua_pushnil(L); lua_next(L, 1) != 0; lua_pop(L, 1)) {
        lua_pushvalue(L, -2);
        lua_pushvalue(L, -2);
        lua_rawset(L, 6);
    }
    for (int i = 0; i < 3; i++) {
        lua_pushvalue(L, 3 + i);
        if (i != 1 || normals) lua_setfield(L, 6, plain[i]);
        lua_settop(L, 6);
    }
    lua_pushnil(L);
    lua_setfield(L, 6, "keys");
    lua_replace(L, 1);
    lua_settop(L, 1);
}
