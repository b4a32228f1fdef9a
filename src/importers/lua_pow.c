/* Lua's ^ calls the C library's pow, whose last bit differs between machines. The dynamic linker
 * (and the static one) takes a program's own definition before a library's, so this one serves
 * everything in the program snell-import, Lua included. Whether it does is checked each time a
 * scene program starts: see docs/decisions/0006-lua-determinism.md. */
#include "importers/lua_scene.h"

#include "maths/functions.h"

static _Thread_local unsigned long calls;

#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
double
pow(double x, double y) {
    calls++;
    return fn_pow(x, y);
}

bool pow_is_ours(lua_State *L) {
    unsigned long before = calls;
    lua_pushnumber(L, 3);
    lua_pushnumber(L, 0.5);
    lua_arith(L, LUA_OPPOW);
    lua_pop(L, 1);
    return calls == before + 1;
}
