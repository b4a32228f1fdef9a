/* transform.translate, rotate, scale, look_at, matrix; a * b applies b first. */
#include "importers/lua_scene.h"

#include <string.h>

#include "maths/functions.h"

/* What the program holds: where it puts things, and by which angle it turns them, which the matrix
 * does not know: a whole turn is none. */
typedef struct turned {
    placement placed; /* first: others read only this */
    double degrees;   /* about `axis`; 0: does not turn; NaN: not known */
    dvec3 axis;       /* of length 1 */
} turned;

static int push_turned(lua_State *L, placement p, double degrees, dvec3 axis, const char *label) {
    transform rounded = dtransform_round(&p), inverse;
    if (!transform_inverse(&rounded, &inverse))
        scene_fail(L, SNELL_ERR_SYNTAX, "scales must not be 0, nor distances beyond all measure",
                   "%s: flattens what it moves, or is not finite", label);
    turned *made = lua_newuserdatauv(L, sizeof *made, 0);
    *made = (turned){p, degrees, axis};
    luaL_setmetatable(L, HANDLE_TRANSFORM);
    return 1;
}

static int push(lua_State *L, placement p, const char *label) {
    return push_turned(L, p, 0, (dvec3){0, 0, 0}, label);
}

/* The angle of b about a's axis; NaN where it is not known. */
static double degrees_about(const turned *a, const turned *b) {
    if (a->degrees == 0 || b->degrees == 0) return b->degrees;
    double along = dvec3_dot(a->axis, b->axis);
    return fabs(along) > 1 - 1e-9 ? b->degrees * (along > 0 ? 1 : -1) : NAN;
}

double transform_turn_between(const placement *from, const placement *to) {
    const turned *a = (const turned *)from, *b = (const turned *)to;
    return degrees_about(a, b) - a->degrees;
}

placement values_get_placement(lua_State *L, const char *label) {
    lua_pushliteral(L, "transform");
    int kind = lua_rawget(L, 1);
    placement p = dtransform_identity();
    if (kind != LUA_TNIL) {
        const placement *given = luaL_testudata(L, -1, HANDLE_TRANSFORM);
        if (given == NULL)
            scene_fail(L, SNELL_ERR_SYNTAX, "such as transform.translate{0, 1, 0}",
                       "%s: 'transform' must be a transform, not a %s", label,
                       luaL_typename(L, -1));
        p = *given;
    }
    lua_pop(L, 1);
    return p;
}

static int multiply(lua_State *L) {
    const turned *a = luaL_testudata(L, 1, HANDLE_TRANSFORM);
    const turned *b = luaL_testudata(L, 2, HANDLE_TRANSFORM);
    if (a == NULL || b == NULL)
        scene_fail(L, SNELL_ERR_SYNTAX, "a * b applies b first",
                   "a transform can only be multiplied with a transform");
    return push_turned(L, dtransform_multiply(&a->placed, &b->placed),
                       a->degrees + degrees_about(a, b), a->degrees == 0 ? b->axis : a->axis,
                       "transform product");
}

static int translate(lua_State *L) {
    double v[3];
    values_need_table(L, "transform.translate");
    values_read_vec3(L, 1, "transform.translate", "offset", v);
    return push(L, (placement){{{1, 0, 0, v[0]}, {0, 1, 0, v[1]}, {0, 0, 1, v[2]}}},
                "transform.translate");
}

static int scale(lua_State *L) {
    double v[3];
    if (lua_type(L, 1) == LUA_TNUMBER)
        v[0] = v[1] = v[2] = values_read_number(L, 1, "transform.scale", "factor");
    else
        values_read_vec3(L, 1, "transform.scale", "factor", v);
    /* What mirrors also reverses the turns before it. */
    return push_turned(L, (placement){{{v[0], 0, 0, 0}, {0, v[1], 0, 0}, {0, 0, v[2], 0}}},
                       v[0] * v[1] * v[2] < 0 ? NAN : 0, (dvec3){0, 0, 0}, "transform.scale");
}

/* Quarter turns are exact. */
static void turn(double degrees, double *sine, double *cosine) {
    double rest = degrees - 360 * floor(degrees / 360);
    double quarter = floor(rest / 90);
    if (rest == quarter * 90) {
        static const double sines[] = {0, 1, 0, -1};
        *sine = sines[(int)quarter % 4];
        *cosine = sines[((int)quarter + 1) % 4];
        return;
    }
    *sine = fn_sin(rest * (PI / 180));
    *cosine = fn_cos(rest * (PI / 180));
}

static bool get(lua_State *L, const char *name) {
    lua_pushstring(L, name);
    if (lua_rawget(L, 1) != LUA_TNIL) return true;
    lua_pop(L, 1);
    return false;
}

static void get_vec3(lua_State *L, const char *label, const char *name, double v[3]) {
    if (!get(L, name)) scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: '%s' is missing", label, name);
    values_read_vec3(L, -1, label, name, v);
    lua_pop(L, 1);
}

/* Rodrigues' rotation formula as a matrix. */
static int rotate(lua_State *L) {
    static const char *const names[] = {"axis", "angle", "about"};
    const char *label = "transform.rotate";
    values_need_table(L, label);
    values_check_keys(L, label, names, 3, 0);
    double v[3], about[3] = {0, 0, 0}, s, c;
    get_vec3(L, label, "axis", v);
    if (!get(L, "angle"))
        scene_fail(L, SNELL_ERR_SYNTAX, "degrees", "%s: 'angle' is missing", label);
    double degrees = values_read_number(L, -1, label, "angle");
    turn(degrees, &s, &c);
    lua_pop(L, 1);
    if (get(L, "about")) {
        values_read_vec3(L, -1, label, "about", about);
        lua_pop(L, 1);
    }
    dvec3 n = dvec3_normalize((dvec3){v[0], v[1], v[2]});
    if (!(dvec3_length(n) > 0))
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: 'axis' has no length", label);
    double k = 1 - c;
    placement p = {{{c + k * n.x * n.x, k * n.x * n.y - s * n.z, k * n.x * n.z + s * n.y, 0},
                    {k * n.y * n.x + s * n.z, c + k * n.y * n.y, k * n.y * n.z - s * n.x, 0},
                    {k * n.z * n.x - s * n.y, k * n.z * n.y + s * n.x, c + k * n.z * n.z, 0}}};
    for (int i = 0; i < 3; i++)
        p.m[i][3] = about[i] - (p.m[i][0] * about[0] + p.m[i][1] * about[1] + p.m[i][2] * about[2]);
    return push_turned(L, p, degrees, n, label);
}

/* Puts the origin at `from` and turns -Z to `at`, as a camera looks. */
static int look_at(lua_State *L) {
    static const char *const names[] = {"from", "at", "up"};
    const char *label = "transform.look_at";
    values_need_table(L, label);
    values_check_keys(L, label, names, 3, 0);
    double from[3], at[3], up[3] = {0, 1, 0};
    get_vec3(L, label, "from", from);
    get_vec3(L, label, "at", at);
    if (get(L, "up")) {
        values_read_vec3(L, -1, label, "up", up);
        lua_pop(L, 1);
    }
    dvec3 z = dvec3_normalize(
        dvec3_sub((dvec3){from[0], from[1], from[2]}, (dvec3){at[0], at[1], at[2]}));
    dvec3 x = dvec3_cross(dvec3_normalize((dvec3){up[0], up[1], up[2]}), z);
    if (!(dvec3_length(z) > 0))
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: 'from' and 'at' are the same point", label);
    if (!(dvec3_length(x) > 1e-6))
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "%s: 'up' is along the view", label);
    x = dvec3_normalize(x);
    dvec3 y = dvec3_cross(z, x);
    return push_turned(
        L,
        (placement){{{x.x, y.x, z.x, from[0]}, {x.y, y.y, z.y, from[1]}, {x.z, y.z, z.z, from[2]}}},
        NAN, (dvec3){0, 0, 0}, label);
}

/* The numbers of the table at index 1, in one list or in rows of four; returns how many there are. */
static size_t read_matrix(lua_State *L, const char *label, double m[4][4]) {
    size_t count = (size_t)lua_rawlen(L, 1);
    bool rows = lua_rawgeti(L, 1, 1) == LUA_TTABLE;
    lua_pop(L, 1);
    if (rows) count = count > 4 ? 0 : 4 * count;
    for (size_t i = 0; i < count && i < 16; i++) {
        if (!rows) {
            lua_rawgeti(L, 1, (lua_Integer)i + 1);
            m[i / 4][i % 4] = values_read_entry(L, label, "matrix", i + 1, 0);
        } else {
            if (lua_rawgeti(L, 1, (lua_Integer)(i / 4) + 1) != LUA_TTABLE || lua_rawlen(L, -1) != 4)
                scene_fail(L, SNELL_ERR_SYNTAX, "such as {1, 0.5, 0, 0}",
                           "%s: row %zu must be 4 numbers in braces", label, i / 4 + 1);
            lua_rawgeti(L, -1, (lua_Integer)(i % 4) + 1);
            lua_remove(L, -2);
            m[i / 4][i % 4] = values_read_entry(L, label, "matrix", i / 4 + 1, i % 4 + 1);
        }
        lua_pop(L, 1);
    }
    return count;
}

/* Any affine transform by its rows, such as a shear. */
static int matrix(lua_State *L) {
    static const char *const shape = "three rows: { {1, 0.5, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0} }";
    const char *label = "transform.matrix";
    values_need_table(L, label);
    static const char *const names[] = {""};
    values_check_keys(L, label, names, 0, 16);
    double m[4][4] = {{0}};
    size_t count = read_matrix(L, label, m);
    if (count != 12 && count != 16)
        scene_fail(L, SNELL_ERR_SYNTAX, shape, "%s: needs 12 or 16 numbers, row by row", label);
    if (count == 16 && !(m[3][0] == 0 && m[3][1] == 0 && m[3][2] == 0 && m[3][3] == 1))
        scene_fail(L, SNELL_ERR_SYNTAX, "leave the fourth row out",
                   "%s: the fourth row must be 0, 0, 0, 1", label);
    placement p;
    memcpy(p.m, m, sizeof p.m);
    return push_turned(L, p, NAN, (dvec3){0, 0, 0}, label);
}

void transform_open(lua_State *L) {
    static const luaL_Reg functions[] = {{"translate", translate}, {"rotate", rotate},
                                         {"scale", scale},         {"look_at", look_at},
                                         {"matrix", matrix},       {NULL, NULL}};
    luaL_newlib(L, functions);
    sandbox_guard(L, "transform");
    lua_setglobal(L, "transform");
    luaL_newmetatable(L, HANDLE_TRANSFORM);
    lua_pushcfunction(L, multiply);
    lua_setfield(L, -2, "__mul");
    lua_pushboolean(L, false);
    lua_setfield(L, -2, "__metatable");
    lua_pop(L, 1);
}
