/* Lua made deterministic and bounded. What is left of its libraries gives the same result on every
 * machine and in every run: no addresses, no clock, no locale, own elementary functions, sorted
 * tables. What is left also ends: steps and memory are counted, and work that C functions do is
 * charged as steps. */
#include "importers/lua_scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/memory.h"
#include "maths/functions.h"

enum { HOOK_STEP = 1000, STRING_MAX = 1 << 20, CPU_SECONDS_MAX = 10 };

/* ---- memory and steps ---- */

static void count_hook(lua_State *L, lua_Debug *activation);

static void spend(lua_scene *s) {
    s->spent = true;
    lua_sethook(s->L, count_hook, LUA_MASKCOUNT, 1);
}

/* Lua hashes strings with a seed made from the clock and from addresses. It shows in one place: the
 * length of a table that has holes and named fields as well depends on how its keys collide. There
 * is no function to choose the seed, so it is set in Lua's global state, after that was filled and
 * before the first string is made: at the second allocation. The state is recognised by the
 * allocator that it names, and everything before the seed must hold the values that lua_newstate
 * gives it; otherwise nothing is touched. sandbox_is_seeded proves the effect. (lstate.h, Lua 5.4;
 * docs/decisions/0006-lua-determinism.md) */
static void set_seed(unsigned char *block, size_t size) {
    enum {
        POINTERS = 0,
        TOTAL = 16,
        DEBT = 24,
        ATOMIC = 40,
        STRINGS = 48,
        REGISTRY_TYPE = 72,
        NIL_VALUE = 80,
        NIL_TYPE = 88,
        SEED = 96,
        END = 104
    };
    static const unsigned char zeros[16] = {0};
    static const unsigned seed = 0x5ee11u;
    for (size_t at = 0; at + END <= size; at += sizeof(void *)) {
        const unsigned char *state = block + at;
        lua_Alloc function;
        size_t total;
        memcpy(&function, state + POINTERS, sizeof function);
        memcpy(&total, state + TOTAL, sizeof total);
        if (function != sandbox_allocate || total != size) continue;
        if (memcmp(state + DEBT, zeros, 8) == 0 && memcmp(state + ATOMIC, zeros, 8) == 0 &&
            memcmp(state + STRINGS, zeros, 16) == 0 && state[REGISTRY_TYPE] == LUA_TNIL &&
            memcmp(state + NIL_VALUE, zeros, 8) == 0 && state[NIL_TYPE] == LUA_TNUMBER)
            memcpy(block + at + SEED, &seed, sizeof seed);
        return;
    }
}

/* With this seed, and no other, Lua walks a table of these keys in this order. */
bool sandbox_is_seeded(lua_State *L) {
    static const char *const keys[] = {"red",  "green", "blue", "cyan",
                                       "pink", "gold",  "grey", "teal"};
    char order[64] = "";
    lua_createtable(L, 0, 8);
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        lua_pushboolean(L, true);
        lua_setfield(L, -2, keys[i]);
    }
    for (lua_pushnil(L); lua_next(L, -2) != 0; lua_pop(L, 1)) {
        size_t used = strlen(order);
        snprintf(order + used, sizeof order - used, "%s ", lua_tostring(L, -2));
    }
    lua_pop(L, 1);
    return strcmp(order, "cyan teal grey gold blue red green pink ") == 0;
}

/* Lua's allocator: also counts, since a step may copy megabytes. It must not raise errors; setting
 * the hook is allowed anywhere. */
void *sandbox_allocate(void *user, void *old, size_t old_size, size_t new_size) {
    lua_scene *s = user;
    size_t had = old ? old_size : 0;
    if (new_size == 0) {
        free(old);
        s->memory -= had;
        return NULL;
    }
    bool long_string = old == NULL && old_size == LUA_TSTRING && new_size > STRING_MAX;
    void *got = NULL;
    if (!long_string && (new_size <= had || new_size - had <= s->memory_max - s->memory))
        got = realloc(old, new_size);
    if (got == NULL) {
        s->string_refused = long_string;
        s->memory_line = s->L ? scene_line(s->L, NULL) : 0;
        return NULL;
    }
    s->memory = s->memory - had + new_size;
    if (s->allocations == 0) {
        s->first_block = got;
        s->first_size = new_size;
    } else if (s->allocations == 1) {
        set_seed(s->first_block, s->first_size);
    }
    s->allocations++;
    s->work += new_size / 32;
    if (s->work > s->work_max && s->L && !s->spent) spend(s);
    return got;
}

double sandbox_cpu_seconds(void) {
    struct timespec now;
    if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) != 0) return 0;
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

/* The first place is the one to name; later ones are only where it passes by. */
_Noreturn static void fail_spent(lua_State *L) {
    failure *first = &scene_of(L)->failure;
    if (first->final) {
        lua_pushstring(L, first->raised);
        lua_error(L);
    }
    first->final = true;
    scene_fail(L, SNELL_ERR_SYNTAX, "is there an endless loop?",
               "the program runs for too long: more than %llu million steps",
               (unsigned long long)(scene_of(L)->work_max / 1000000));
}

/* Once the budget is spent this runs at every instruction, so that no pcall can swallow it. The
 * clock is only a backstop for what no count foresees. */
static void count_hook(lua_State *L, lua_Debug *activation) {
    (void)activation;
    lua_scene *s = scene_of(L);
    if (!s->spent) {
        s->work += HOOK_STEP;
        double used = sandbox_cpu_seconds() - s->cpu_start - s->cpu_excluded;
        if (s->work <= s->work_max && used < CPU_SECONDS_MAX) return;
        spend(s);
    }
    fail_spent(L);
}

void sandbox_charge(lua_State *L, uint64_t steps) {
    lua_scene *s = scene_of(L);
    s->work += steps;
    if (s->work <= s->work_max && !s->spent) return;
    if (!s->spent) spend(s);
    fail_spent(L);
}

/* ---- text ---- */

const char *sandbox_tostring(lua_State *L, int index) {
    index = lua_absindex(L, index);
    if (luaL_callmeta(L, index, "__tostring")) {
        if (!lua_isstring(L, -1)) luaL_error(L, "'__tostring' must return a string");
        return lua_tostring(L, -1);
    }
    switch (lua_type(L, index)) {
    case LUA_TNUMBER:
    case LUA_TSTRING: lua_pushvalue(L, index); return lua_tostring(L, -1);
    case LUA_TBOOLEAN: return lua_pushstring(L, lua_toboolean(L, index) ? "true" : "false");
    default: break;
    }
    if (luaL_getmetafield(L, index, "__name") == LUA_TSTRING) return lua_tostring(L, -1);
    return lua_pushstring(L, luaL_typename(L, index));
}

static int base_tostring(lua_State *L) {
    luaL_checkany(L, 1);
    sandbox_tostring(L, 1);
    return 1;
}

static int base_print(lua_State *L) {
    luaL_Buffer text;
    int count = lua_gettop(L);
    luaL_buffinit(L, &text);
    for (int i = 1; i <= count; i++) {
        if (i > 1) luaL_addchar(&text, '\t');
        sandbox_tostring(L, i);
        luaL_addvalue(&text);
    }
    luaL_pushresult(&text);
    const char *file;
    uint32_t line = scene_line(L, &file);
    if (description_add_message(scene_of(L)->d, SNELL_INFO, file, line, NULL, "%s",
                                lua_tostring(L, -1)))
        scene_fail_last(L, NULL, NULL);
    return 0;
}

/* The stock string.format (upvalue 1) after %p is refused and what it would print as an address is
 * made text. */
static int string_format(lua_State *L) {
    size_t size;
    const char *format = luaL_checklstring(L, 1, &size);
    int argument = 1, count = lua_gettop(L);
    for (size_t i = 0; i < size; i++) {
        if (format[i] != '%') continue;
        i++;
        if (i < size && format[i] == '%') continue;
        while (i < size && strchr("-+ #0123456789.", format[i]) && format[i]) i++;
        argument++;
        if (i < size && format[i] == 'p')
            scene_fail(L, SNELL_ERR_SYNTAX, NULL,
                       "string.format: '%%p' is not available: addresses differ in every run");
        if (i < size && format[i] == 's' && argument <= count &&
            lua_type(L, argument) != LUA_TSTRING) {
            sandbox_tostring(L, argument);
            lua_replace(L, argument);
        }
    }
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, count, 1);
    return 1;
}

static int string_rep(lua_State *L) {
    size_t size, between;
    const char *text = luaL_checklstring(L, 1, &size);
    lua_Integer count = luaL_checkinteger(L, 2);
    const char *separator = luaL_optlstring(L, 3, "", &between);
    if (count <= 0 || size + between == 0) {
        lua_pushliteral(L, "");
        return 1;
    }
    if ((uint64_t)count > STRING_MAX / (size + between) + 1)
        scene_fail(L, SNELL_ERR_MEMORY, NULL, "string.rep: longer than %d MiB", STRING_MAX >> 20);
    sandbox_charge(L, 4 * (uint64_t)count);
    luaL_Buffer out;
    luaL_buffinit(L, &out);
    for (lua_Integer i = 0; i < count; i++) {
        if (i > 0) luaL_addlstring(&out, separator, between);
        luaL_addlstring(&out, text, size);
    }
    luaL_pushresult(&out);
    return 1;
}

/* ---- tables in one order: numbers, then strings ---- */

/* -1, 0, 1; the values at a and b are numbers or strings. */
static int compare_keys(lua_State *L, int a, int b) {
    bool a_text = lua_type(L, a) == LUA_TSTRING, b_text = lua_type(L, b) == LUA_TSTRING;
    if (a_text != b_text) return a_text ? 1 : -1;
    if (!a_text) return lua_compare(L, a, b, LUA_OPLT) ? -1 : lua_compare(L, b, a, LUA_OPLT);
    size_t a_size, b_size;
    const char *x = lua_tolstring(L, a, &a_size), *y = lua_tolstring(L, b, &b_size);
    int order = memcmp(x, y, a_size < b_size ? a_size : b_size);
    if (order != 0) return order < 0 ? -1 : 1;
    return a_size < b_size ? -1 : a_size > b_size;
}

static void check_key(lua_State *L, int index, const char *who) {
    int kind = lua_type(L, index);
    if (kind == LUA_TNUMBER || kind == LUA_TSTRING) return;
    scene_fail(L, SNELL_ERR_SYNTAX, "use numbers and strings as keys",
               "%s: a key that is a %s has no place in a fixed order", who, lua_typename(L, kind));
}

/* The smallest key greater than the one given; one pass over the table. */
static int base_next(lua_State *L) {
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 2);
    bool first = lua_isnil(L, 2);
    if (!first) check_key(L, 2, "next");
    lua_pushnil(L); /* 3: the best key so far */
    uint64_t steps = 0;
    for (lua_pushnil(L); lua_next(L, 1) != 0; lua_pop(L, 1), steps++) { /* 4: key, 5: value */
        check_key(L, 4, "next");
        if (!first && compare_keys(L, 4, 2) <= 0) continue;
        if (!lua_isnil(L, 3) && compare_keys(L, 4, 3) >= 0) continue;
        lua_pushvalue(L, 4);
        lua_replace(L, 3);
    }
    sandbox_charge(L, 8 * steps);
    lua_settop(L, 3);
    if (lua_isnil(L, 3)) return 1;
    lua_pushvalue(L, 3);
    lua_rawget(L, 1);
    return 2;
}

typedef struct sort_key {
    bool text, whole;
    lua_Integer integer;
    double number;
    const char *bytes; /* kept alive by the table */
    size_t size;
} sort_key;

static int compare_sort_keys(const void *x, const void *y) {
    const sort_key *a = x, *b = y;
    if (a->text != b->text) return a->text ? 1 : -1;
    if (a->text) {
        int order = memcmp(a->bytes, b->bytes, a->size < b->size ? a->size : b->size);
        if (order != 0) return order;
        return a->size < b->size ? -1 : a->size > b->size;
    }
    if (a->whole && b->whole) return a->integer < b->integer ? -1 : a->integer > b->integer;
    /* A float key has a fraction or is beyond every integer (Lua turns the others into integers):
     * where its comparison in double says equal, the integer beside it was rounded up to 2^63. */
    if (a->number != b->number) return a->number < b->number ? -1 : 1;
    return a->whole ? -1 : 1;
}

static sort_key *read_keys(lua_State *L, size_t *count) {
    size_t found = 0;
    for (lua_pushnil(L); lua_next(L, 1) != 0; lua_pop(L, 1)) found++;
    sandbox_charge(L, 8 * (uint64_t)found);
    sort_key *keys = lua_newuserdatauv(L, (found + 1) * sizeof *keys, 0);
    size_t i = 0;
    for (lua_pushnil(L); lua_next(L, 1) != 0 && i < found; lua_pop(L, 1), i++) {
        int at = lua_gettop(L) - 1;
        check_key(L, at, "pairs");
        keys[i] = (sort_key){.text = lua_type(L, at) == LUA_TSTRING, .whole = lua_isinteger(L, at)};
        if (keys[i].text) {
            keys[i].bytes = lua_tolstring(L, at, &keys[i].size);
        } else {
            keys[i].number = lua_tonumber(L, at);
            if (keys[i].whole) keys[i].integer = lua_tointeger(L, at);
        }
    }
    qsort(keys, found, sizeof *keys, compare_sort_keys);
    *count = found;
    return keys;
}

/* Upvalues: the table, its sorted keys, the place in them. */
static int pairs_step(lua_State *L) {
    lua_Integer at = lua_tointeger(L, lua_upvalueindex(3));
    for (;;) {
        at++;
        if (lua_rawgeti(L, lua_upvalueindex(2), at) == LUA_TNIL) return 1;
        lua_pushvalue(L, -1);
        if (lua_rawget(L, lua_upvalueindex(1)) != LUA_TNIL) break;
        lua_pop(L, 2); /* removed during the walk */
    }
    lua_pushinteger(L, at);
    lua_replace(L, lua_upvalueindex(3));
    return 2;
}

static int base_pairs(lua_State *L) {
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 1);
    size_t count;
    sort_key *keys = read_keys(L, &count);
    lua_pushvalue(L, 1);
    lua_createtable(L, count < INT32_MAX ? (int)count : 0, 0);
    for (size_t i = 0; i < count; i++) {
        if (keys[i].text)
            lua_pushlstring(L, keys[i].bytes, keys[i].size);
        else if (keys[i].whole)
            lua_pushinteger(L, keys[i].integer);
        else
            lua_pushnumber(L, keys[i].number);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_pushinteger(L, 0);
    lua_pushcclosure(L, pairs_step, 3);
    return 1;
}

/* True if the value at a belongs before the value at b, by the function at 2 if there is one. */
static bool comes_before(lua_State *L, int a, int b) {
    a = lua_absindex(L, a);
    b = lua_absindex(L, b);
    if (lua_isnil(L, 2)) return lua_compare(L, a, b, LUA_OPLT);
    lua_pushvalue(L, 2);
    lua_pushvalue(L, a);
    lua_pushvalue(L, b);
    lua_call(L, 2, 1);
    bool before = lua_toboolean(L, -1);
    lua_pop(L, 1);
    return before;
}

/* Merges the runs [low, middle) and [middle, high) of table `from` into table `to`. */
static void merge_runs(lua_State *L, int from, int to, lua_Integer low, lua_Integer middle,
                       lua_Integer high) {
    lua_Integer left = low, right = middle;
    for (lua_Integer i = low; i < high; i++) {
        bool take_right = left >= middle;
        if (left < middle && right < high) {
            lua_rawgeti(L, from, right);
            lua_rawgeti(L, from, left);
            take_right = comes_before(L, -2, -1);
            lua_pop(L, 2);
        }
        lua_rawgeti(L, from, take_right ? right++ : left++);
        lua_rawseti(L, to, i);
    }
}

/* A stable merge sort: Lua's own takes its pivots from the clock. */
static int table_sort(lua_State *L) {
    luaL_checktype(L, 1, LUA_TTABLE);
    if (!lua_isnoneornil(L, 2)) luaL_checktype(L, 2, LUA_TFUNCTION);
    lua_settop(L, 2);
    lua_Integer count = (lua_Integer)lua_rawlen(L, 1);
    lua_newtable(L); /* 3 */
    int from = 1, to = 3;
    for (lua_Integer width = 1; width < count; width *= 2) {
        sandbox_charge(L, 4 * (uint64_t)count);
        for (lua_Integer low = 1; low <= count; low += 2 * width) {
            lua_Integer middle = low + width, high = low + 2 * width;
            if (middle > count + 1) middle = count + 1;
            if (high > count + 1) high = count + 1;
            merge_runs(L, from, to, low, middle, high);
        }
        int swap = from;
        from = to;
        to = swap;
    }
    for (lua_Integer i = 1; from == 3 && i <= count; i++) {
        lua_rawgeti(L, 3, i);
        lua_rawseti(L, 1, i);
    }
    return 0;
}

/* The stock function (upvalue 1) walks up to the table's length in C when it has upvalue 2
 * arguments or more, at upvalue 3 sixteenths of a step for each element. A length that a metatable
 * makes up could be anything. */
static int table_measured(lua_State *L) {
    luaL_checktype(L, 1, LUA_TTABLE);
    if (luaL_getmetafield(L, 1, "__len") != LUA_TNIL)
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "a table function on a table with __len");
    bool walks = lua_gettop(L) >= lua_tointeger(L, lua_upvalueindex(2));
    uint64_t each = (uint64_t)lua_tointeger(L, lua_upvalueindex(3));
    sandbox_charge(L, walks ? 1 + (uint64_t)lua_rawlen(L, 1) * each / 16 : 1);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, lua_gettop(L) - 1, LUA_MULTRET);
    return lua_gettop(L);
}

static int table_move(lua_State *L) {
    lua_Integer first = luaL_checkinteger(L, 2), last = luaL_checkinteger(L, 3);
    if (last >= first) {
        uint64_t count = (uint64_t)last - (uint64_t)first;
        if (count > 100000000)
            scene_fail(L, SNELL_ERR_SYNTAX, NULL, "table.move: too many elements");
        sandbox_charge(L, 4 * count);
    }
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, lua_gettop(L) - 1, 1);
    return 1;
}

/* ---- base ---- */

static int base_pcall(lua_State *L) {
    luaL_checkany(L, 1);
    bool done = lua_pcall(L, lua_gettop(L) - 1, LUA_MULTRET, 0) == LUA_OK;
    if (scene_of(L)->spent) fail_spent(L);
    if (!done) sandbox_charge(L, 50);
    lua_pushboolean(L, done);
    lua_insert(L, 1);
    return lua_gettop(L);
}

/* Finalisers and weak tables would show when memory is collected. */
static int base_setmetatable(lua_State *L) {
    luaL_checktype(L, 1, LUA_TTABLE);
    luaL_argexpected(L, lua_isnil(L, 2) || lua_istable(L, 2), 2, "nil or table");
    static const char *const refused[] = {"__gc", "__mode"};
    for (int i = 0; i < 2 && lua_istable(L, 2); i++) {
        lua_pushstring(L, refused[i]);
        if (lua_rawget(L, 2) != LUA_TNIL)
            scene_fail(L, SNELL_ERR_SYNTAX, NULL, "setmetatable: '%s' is not available in a scene",
                       refused[i]);
        lua_pop(L, 1);
    }
    if (luaL_getmetafield(L, 1, "__metatable") != LUA_TNIL)
        return luaL_error(L, "cannot change a protected metatable");
    lua_settop(L, 2);
    lua_setmetatable(L, 1);
    return 1;
}

/* ---- maths ---- */

#define MATHS_1(name)                                                                              \
    static int maths_##name(lua_State *L) {                                                        \
        lua_pushnumber(L, fn_##name(luaL_checknumber(L, 1)));                                      \
        return 1;                                                                                  \
    }
MATHS_1(sin)
MATHS_1(cos)
MATHS_1(tan)
MATHS_1(asin)
MATHS_1(acos)
MATHS_1(exp)

static int maths_atan(lua_State *L) {
    double y = luaL_checknumber(L, 1), x = luaL_optnumber(L, 2, 1);
    lua_pushnumber(L, fn_atan2(y, x));
    return 1;
}

static int maths_log(lua_State *L) {
    double x = fn_log(luaL_checknumber(L, 1));
    lua_pushnumber(L, lua_isnoneornil(L, 2) ? x : x / fn_log(luaL_checknumber(L, 2)));
    return 1;
}

/* SplitMix64 (Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators, 2014). */
static uint64_t next_random(lua_scene *s) {
    uint64_t x = s->random += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

static int maths_random(lua_State *L) {
    lua_scene *s = scene_of(L);
    lua_Integer low = 1, high;
    switch (lua_gettop(L)) {
    case 0: lua_pushnumber(L, (double)(next_random(s) >> 11) * 0x1p-53); return 1;
    case 1: high = luaL_checkinteger(L, 1); break;
    case 2:
        low = luaL_checkinteger(L, 1);
        high = luaL_checkinteger(L, 2);
        break;
    default: return luaL_error(L, "wrong number of arguments");
    }
    luaL_argcheck(L, low <= high, lua_gettop(L), "interval is empty");
    uint64_t span = (uint64_t)high - (uint64_t)low, number = next_random(s);
    if (span != UINT64_MAX) { /* numbers of an incomplete last round would favour the low end */
        uint64_t sides = span + 1, excess = (UINT64_MAX % sides + 1) % sides;
        while (number > UINT64_MAX - excess) number = next_random(s);
        number %= sides;
    }
    lua_pushinteger(L, (lua_Integer)((uint64_t)low + number));
    return 1;
}

static int maths_randomseed(lua_State *L) {
    if (lua_type(L, 1) != LUA_TNUMBER)
        scene_fail(L, SNELL_ERR_SYNTAX, "such as math.randomseed(1)",
                   "math.randomseed: needs a number, so that every run is the same");
    lua_Integer whole;
    double number = lua_tonumber(L, 1);
    int exact;
    whole = lua_tointegerx(L, 1, &exact);
    if (!exact) memcpy(&whole, &number, sizeof whole);
    scene_of(L)->random = (uint64_t)whole;
    return 0;
}

/* ---- what there is ---- */

/* Reading a member that is not there. Upvalue 1: the table's name. */
static int unknown_member(lua_State *L) {
    const char *label = lua_tostring(L, lua_upvalueindex(1));
    if (lua_type(L, 2) != LUA_TSTRING) {
        lua_pushnil(L);
        return 1;
    }
    const char *word = lua_tostring(L, 2);
    size_t count = 0, room = 0;
    for (lua_pushnil(L); lua_next(L, 1) != 0; lua_pop(L, 1)) room++;
    const char **names = lua_newuserdatauv(L, (room + 1) * sizeof *names, 0);
    for (lua_pushnil(L); lua_next(L, 1) != 0; lua_pop(L, 1))
        if (lua_type(L, -2) == LUA_TSTRING && count < room) names[count++] = lua_tostring(L, -2);
    sandbox_charge(L, 8 * (uint64_t)room);
    const char *subject = label ? lua_pushfstring(L, "%s has no member", label) : "undefined name";
    scene_fail_unknown(L, label, subject, word, names, count);
}

void sandbox_guard(lua_State *L, const char *label) {
    lua_createtable(L, 0, 2);
    lua_pushstring(L, label); /* nil for the globals */
    lua_pushcclosure(L, unknown_member, 1);
    lua_setfield(L, -2, "__index");
    lua_pushboolean(L, false);
    lua_setfield(L, -2, "__metatable");
    lua_setmetatable(L, -2);
}

/* Copies the named members (a list ended by NULL) of the table at `from` to the one on the top. */
static void keep(lua_State *L, int from, const char *const *names) {
    for (; *names; names++) {
        lua_getfield(L, from, *names);
        lua_setfield(L, -2, *names);
    }
}

/* table[name] = a closure of `function` over the stock function of that name and two numbers. */
static void wrap(lua_State *L, int from, const char *name, lua_CFunction function, int number,
                 int cost) {
    lua_getfield(L, from, name);
    lua_pushinteger(L, number);
    lua_pushinteger(L, cost);
    lua_pushcclosure(L, function, 3);
    lua_setfield(L, -2, name);
}

static void open_string(lua_State *L) {
    static const char *const kept[] = {"byte",    "char", "len",   "lower",
                                       "reverse", "sub",  "upper", NULL};
    luaL_requiref(L, "string", luaopen_string, 0);
    int stock = lua_gettop(L);
    lua_newtable(L);
    keep(L, stock, kept);
    wrap(L, stock, "format", string_format, 0, 0);
    lua_pushcfunction(L, string_rep);
    lua_setfield(L, -2, "rep");
    sandbox_guard(L, "string");
    lua_pushliteral(L, "");
    lua_getmetatable(L, -1); /* of all strings: s:upper() */
    lua_pushvalue(L, -3);
    lua_setfield(L, -2, "__index");
    lua_pushboolean(L, false);
    lua_setfield(L, -2, "__metatable");
    lua_pop(L, 2);
    lua_remove(L, stock);
}

static void open_table(lua_State *L) {
    static const char *const kept[] = {"pack", "unpack", NULL};
    luaL_requiref(L, "table", luaopen_table, 0);
    int stock = lua_gettop(L);
    lua_newtable(L);
    keep(L, stock, kept);
    wrap(L, stock, "insert", table_measured, 3, 24);
    wrap(L, stock, "remove", table_measured, 2, 24);
    wrap(L, stock, "concat", table_measured, 1, 400);
    wrap(L, stock, "move", table_move, 0, 0);
    lua_pushcfunction(L, table_sort);
    lua_setfield(L, -2, "sort");
    sandbox_guard(L, "table");
    lua_remove(L, stock);
}

static void open_maths(lua_State *L) {
    static const char *const kept[] = {
        "abs",        "ceil", "deg", "floor", "fmod", "huge",      "max",  "maxinteger", "min",
        "mininteger", "modf", "pi",  "rad",   "sqrt", "tointeger", "type", "ult",        NULL};
    static const luaL_Reg own[] = {{"sin", maths_sin},
                                   {"cos", maths_cos},
                                   {"tan", maths_tan},
                                   {"asin", maths_asin},
                                   {"acos", maths_acos},
                                   {"atan", maths_atan},
                                   {"exp", maths_exp},
                                   {"log", maths_log},
                                   {"random", maths_random},
                                   {"randomseed", maths_randomseed},
                                   {NULL, NULL}};
    luaL_requiref(L, "math", luaopen_math, 0);
    int stock = lua_gettop(L);
    lua_newtable(L);
    keep(L, stock, kept);
    luaL_setfuncs(L, own, 0);
    sandbox_guard(L, "math");
    lua_remove(L, stock);
}

void sandbox_open(lua_State *L) {
    static const char *const kept[] = {
        "assert", "error",  "getmetatable", "ipairs",   "rawequal", "rawget", "rawlen",
        "rawset", "select", "type",         "tonumber", "_VERSION", NULL};
    static const luaL_Reg own[] = {{"tostring", base_tostring},
                                   {"print", base_print},
                                   {"next", base_next},
                                   {"pairs", base_pairs},
                                   {"pcall", base_pcall},
                                   {"setmetatable", base_setmetatable},
                                   {NULL, NULL}};
    luaL_requiref(L, "_G", luaopen_base, 0);
    int stock = lua_gettop(L);
    lua_newtable(L);
    keep(L, stock, kept);
    luaL_setfuncs(L, own, 0);
    open_string(L);
    lua_setfield(L, -2, "string");
    open_table(L);
    lua_setfield(L, -2, "table");
    open_maths(L);
    lua_setfield(L, -2, "math");
    sandbox_guard(L, NULL);
    lua_rawseti(L, LUA_REGISTRYINDEX, LUA_RIDX_GLOBALS);
    lua_settop(L, stock - 1);
    lua_sethook(L, count_hook, LUA_MASKCOUNT, HOOK_STEP);
}
