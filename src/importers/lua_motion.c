/* What moves: animation{}, the globals time and frame, and the field motion of whatever can be drawn.
 * A function of time is sampled, at the end, over the time that the cameras' shutters are open. */
#include "importers/lua_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "cameras/camera.h"
#include "image/aov.h"
#include "scene/settings.h"

/* An included program does not know its cameras yet: a frame before to a frame after, more finely. */
enum { PIECES = MOTION_STEPS, PIECES_UNKNOWN = 64, TIMES_MAX = 1 << 16 };

/* ---- the clock ---- */

static const animation_desc *find_clock(const lua_scene *s) {
    for (; s; s = s->parent) {
        const object *said = description_setting(s->d, "animation");
        if (said) return said->desc;
    }
    return NULL;
}

/* The frame's own time and the length of a frame, in seconds. */
static bool wants_next_frame(const lua_scene *s) {
    const object *said = description_setting(s->d, "render");
    aov_set aovs;
    if (s->options->next_frame) return true;
    if (said == NULL || aov_parse(((const render_desc *)said->desc)->aov, &aovs)) return false;
    return aov_has(aovs, AOV_motion);
}

static void clock_of(const lua_scene *s, double *start, double *frame) {
    animation_desc usual;
    const animation_desc *clock = find_clock(s);
    if (clock == NULL) {
        desc_init(&setting_animation, &usual);
        clock = &usual;
    }
    *frame = 1 / (double)clock->fps;
    *start = (clock->frame - 1) / (double)clock->fps;
}

void motion_set_clock(lua_State *L) {
    const animation_desc *clock = find_clock(scene_of(L));
    if (clock == NULL) return;
    lua_pushglobaltable(L);
    lua_pushliteral(L, "time");
    lua_pushnumber(L, (clock->frame - 1) / (double)clock->fps);
    lua_rawset(L, -3);
    lua_pushliteral(L, "frame");
    lua_pushinteger(L, clock->frame);
    lua_rawset(L, -3);
    lua_pop(L, 1);
}

void motion_give_clock(lua_State *L, import_options *to) {
    const animation_desc *clock = find_clock(scene_of(L));
    if (clock == NULL) return;
    to->frame = (uint32_t)clock->frame;
    to->fps = (double)clock->fps;
}

static lua_Integer get_frame(lua_State *L, const char *name, lua_Integer absent) {
    lua_pushstring(L, name);
    lua_Integer value = absent;
    if (lua_rawget(L, 1) != LUA_TNIL) {
        int whole = 0;
        if (lua_type(L, -1) == LUA_TNUMBER) value = lua_tointegerx(L, -1, &whole);
        if (!whole || value < 1 || value > FRAME_MAX)
            scene_fail(L, SNELL_ERR_SYNTAX, NULL, "animation: '%s' must be an integer from 1 to %d",
                       name, FRAME_MAX);
    }
    lua_pop(L, 1);
    return value;
}

/* animation { fps = 24, first = 1, last = 120 } */
static int animation(lua_State *L) {
    static const char *const names[] = {"fps", "first", "last"};
    const char *label = "animation";
    lua_scene *s = scene_of(L);
    values_need_table(L, label);
    values_check_keys(L, label, names, 3, 0);
    if (find_clock(s))
        scene_fail(L, SNELL_ERR_SYNTAX, "a scene has one clock, also for what it includes",
                   "animation: given a second time");
    snell_param params[4] = {{.name = "first", .kind = SNELL_PARAM_INT},
                             {.name = "last", .kind = SNELL_PARAM_INT},
                             {.name = "frame", .kind = SNELL_PARAM_INT},
                             {.name = "fps", .kind = SNELL_PARAM_FLOAT, .value.f = 24}};
    lua_Integer first = get_frame(L, "first", 1), last = get_frame(L, "last", first + 119);
    if (last < first)
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "animation: 'last' %d comes before 'first' %d",
                   (int)last, (int)first);
    lua_Integer frame = s->options->frame ? (lua_Integer)s->options->frame : first;
    if (frame < first || frame > last)
        scene_fail(L, SNELL_ERR_ARGUMENT, NULL, "frame %d: the animation has frames %d to %d",
                   (int)frame, (int)first, (int)last);
    params[0].value.i = first;
    params[1].value.i = last;
    params[2].value.i = frame;
    lua_pushliteral(L, "fps");
    if (lua_rawget(L, 1) != LUA_TNIL) params[3].value.f = values_read_number(L, -1, label, "fps");
    object_source source = {.name = NULL};
    source.line = scene_line(L, &source.file);
    if (description_add(s->d, CATEGORY_SETTING, "animation", params, 4, source, NULL))
        scene_fail_last(L, NULL, NULL);
    motion_set_clock(L);
    return 0;
}

/* ---- reading keys ---- */

static const placement *need_transform(lua_State *L, const char *label, const char *what) {
    const placement *given = luaL_testudata(L, -1, HANDLE_TRANSFORM);
    if (given == NULL)
        scene_fail(L, SNELL_ERR_SYNTAX, "such as transform.translate{0, 1, 0}",
                   "%s: 'motion' %s a transform, not %s%s", label, what,
                   lua_isnil(L, -1) ? "" : "a ", luaL_typename(L, -1));
    return given;
}

/* Key number `at` of the list on the top. *placed is the program's own transform, alive in the list. */
static motion_key read_key(lua_State *L, const char *label, lua_Integer at,
                           const placement **placed) {
    motion_key key;
    const char *shape = "motion = { {time = 0, transform = a}, {time = 1, transform = b} }";
    if (lua_rawgeti(L, -1, at) != LUA_TTABLE)
        scene_fail(L, SNELL_ERR_SYNTAX, shape, "%s: 'motion' [%d] must be a table", label, (int)at);
    for (lua_pushnil(L); lua_next(L, -2) != 0; lua_pop(L, 1)) {
        const char *name = lua_type(L, -2) == LUA_TSTRING ? lua_tostring(L, -2) : "a number";
        if (strcmp(name, "time") != 0 && strcmp(name, "transform") != 0)
            scene_fail(L, SNELL_ERR_SYNTAX, shape,
                       "%s: 'motion' [%d] has 'time' and 'transform', "
                       "not '%s'",
                       label, (int)at, name);
    }
    lua_pushliteral(L, "time");
    if (lua_rawget(L, -2) == LUA_TNIL)
        scene_fail(L, SNELL_ERR_SYNTAX, shape, "%s: 'motion' [%d] has no 'time'", label, (int)at);
    key.time = (float)values_read_number(L, -1, label, "time");
    lua_pop(L, 1);
    lua_pushliteral(L, "transform");
    lua_rawget(L, -2);
    *placed = need_transform(L, label, "needs in each key");
    key.transform = dtransform_round(*placed);
    lua_pop(L, 2);
    return key;
}

/* Between keys the shorter arc is taken: half a turn may go either way, and a whole one is none. */
static void warn_of_turn(lua_State *L, const char *label, size_t key, const placement *before,
                         const placement *after) {
    double degrees = fabs(transform_turn_between(before, after));
    if (!(degrees >= 180)) return;
    const char *file;
    uint32_t line = scene_line(L, &file);
    if (description_add_message(scene_of(L)->d, SNELL_WARNING, file, line,
                                "put keys in between, or write motion = function(t) .. end",
                                "%s: 'motion' [%zu] turns by %.6g degrees from the key before: "
                                "between keys it turns the shorter way, by less than 180",
                                label, key, degrees))
        scene_fail_last(L, NULL, NULL);
}

/* Pushes the keys of the list on the top. */
static motion_key *read_keys(lua_State *L, const char *label, size_t *count) {
    *count = (size_t)lua_rawlen(L, -1);
    sandbox_charge(L, 16 * (uint64_t)*count);
    motion_key *keys = lua_newuserdatauv(L, (*count + 1) * sizeof *keys, 0);
    const placement *before = NULL, *placed = NULL;
    for (size_t i = 0; i < *count; i++, before = placed) {
        lua_pushvalue(L, -2);
        keys[i] = read_key(L, label, (lua_Integer)i + 1, &placed);
        lua_pop(L, 1);
        if (before) warn_of_turn(L, label, i + 1, before, placed);
    }
    if (motion_check(keys, *count, label)) scene_fail_last(L, NULL, NULL);
    return keys;
}

/* ---- functions of time ---- */

/* Calls the function on the top, which stays there. */
static placement call(lua_State *L, const char *label, double time) {
    lua_pushvalue(L, -1);
    lua_pushnumber(L, time);
    lua_call(L, 1, 1);
    placement p = *need_transform(L, label, "must return");
    lua_pop(L, 1);
    return p;
}

static double mix(double a, double b, double s) { return a + (b - a) * s; }

/* Pushes keys of the function on the top: of a window, and of the moment `next` where that comes after it. */
static motion_key *sample(lua_State *L, const char *label, const double window[2], double next,
                          int pieces, size_t *count) {
    motion_key *keys = lua_newuserdatauv(L, ((size_t)pieces + 2) * sizeof *keys, 0);
    *count = 0;
    for (int i = 0; i <= pieces + (next > window[1]); i++) {
        double time = i > pieces ? next : mix(window[0], window[1], (double)i / pieces);
        lua_pushvalue(L, -2);
        placement p = call(L, label, time);
        lua_pop(L, 1);
        motion_key key = {(float)time, dtransform_round(&p)};
        if (*count == 0 || key.time > keys[*count - 1].time) keys[(*count)++] = key;
    }
    if (motion_check(keys, *count, label)) scene_fail_last(L, NULL, NULL);
    return keys;
}

void motion_read_keys(lua_State *L, const char *label, const field *f, snell_param *out) {
    size_t count;
    const motion_key *keys;
    *out = (snell_param){.name = f->name, .kind = SNELL_PARAM_ARRAY};
    if (lua_isfunction(L, -1)) { /* of a camera: over its own shutter */
        double start, frame, window[2] = {0, 0.5};
        clock_of(scene_of(L), &start, &frame);
        lua_pushliteral(L, "shutter");
        if (lua_rawget(L, 1) == LUA_TTABLE)
            for (int i = 0; i < 2; i++) {
                lua_rawgeti(L, -1, i + 1);
                window[i] = values_read_number(L, -1, label, "shutter");
                lua_pop(L, 1);
            }
        lua_pop(L, 1);
        for (int i = 0; i < 2; i++) window[i] = start + window[i] * frame;
        double next = wants_next_frame(scene_of(L)) ? window[0] + frame : window[0];
        keys = sample(L, label, window, next, PIECES, &count);
    } else {
        if (!lua_istable(L, -1))
            scene_fail(L, SNELL_ERR_SYNTAX, NULL,
                       "%s: 'motion' must be a list of keys or a function of time, not a %s", label,
                       luaL_typename(L, -1));
        keys = read_keys(L, label, &count);
    }
    out->value.array.data = keys;
    out->value.array.count = count;
}

/* ---- what shapes keep until the end ---- */

static uint32_t append(lua_State *L, const motion_key *keys, size_t count, int function,
                       placement now) {
    lua_scene *s = scene_of(L);
    lua_motion made = {
        .count = count, .function = function, .line = scene_line(L, NULL), .now = now};
    if (count) {
        made.keys = memory_resize(NULL, count, sizeof *made.keys);
        if (made.keys) memcpy(made.keys, keys, count * sizeof *keys);
    }
    if ((count && !made.keys) || s->motion_count >= UINT32_MAX - 1 ||
        !ARRAY_GROW(s->motions, s->motion_count, s->motion_capacity, 1)) {
        free(made.keys);
        scene_fail(L, SNELL_ERR_MEMORY, NULL, "out of memory");
    }
    s->motions[s->motion_count++] = made;
    return (uint32_t)s->motion_count;
}

uint32_t motion_add(lua_State *L, const motion_key *keys, size_t count) {
    double start, frame;
    placement now;
    clock_of(scene_of(L), &start, &frame);
    motion_interpolate(keys, count, start, now.m);
    return append(L, keys, count, LUA_NOREF, now);
}

uint32_t motion_read(lua_State *L, const char *label) {
    lua_pushliteral(L, "motion");
    uint32_t made = 0;
    int kind = lua_rawget(L, 1);
    if (kind == LUA_TFUNCTION) {
        double start, frame;
        clock_of(scene_of(L), &start, &frame);
        placement now = call(L, label, start);
        lua_pushvalue(L, -1);
        int function = luaL_ref(L, LUA_REGISTRYINDEX);
        made = append(L, NULL, 0, function, now);
    } else if (kind == LUA_TTABLE) {
        size_t count;
        const motion_key *keys = read_keys(L, label, &count);
        made = motion_add(L, keys, count);
        lua_pop(L, 1);
    } else if (kind != LUA_TNIL) {
        scene_fail(L, SNELL_ERR_SYNTAX, NULL,
                   "%s: 'motion' must be a list of keys or a function of time, not a %s", label,
                   luaL_typename(L, -1));
    }
    lua_pop(L, 1);
    return made;
}

/* When somebody may look, in seconds, and where the next frame counts, a frame after a shutter opens; returns into
 * how many pieces the window is cut. */
static int find_window(const lua_scene *s, double window[2], double *next) {
    double start, frame, open = 0, close = 0.5, last = 0;
    clock_of(s, &start, &frame);
    if (s->parent) {
        window[0] = start - frame;
        window[1] = *next = start + frame;
        return PIECES_UNKNOWN;
    }
    const object_list *cameras = &s->d->objects[CATEGORY_CAMERA];
    for (size_t i = 0; i < cameras->count; i++) {
        const camera_common *c = cameras->items[i].desc;
        open = double_min(open, (double)c->shutter.x);
        close = double_max(close, (double)c->shutter.y);
        last = double_max(last, (double)c->shutter.x);
    }
    window[0] = start + open * frame;
    window[1] = start + close * frame;
    *next = wants_next_frame(s) ? start + (last + 1) * frame : window[1];
    return PIECES;
}

void motion_sample_functions(lua_State *L) {
    lua_scene *s = scene_of(L);
    double window[2], next;
    int pieces = find_window(s, window, &next);
    for (size_t i = 0; i < s->motion_count; i++) { /* a function may add more */
        if (s->motions[i].function == LUA_NOREF) continue;
        const char *label = lua_pushfstring(L, "line %d", (int)s->motions[i].line);
        lua_rawgeti(L, LUA_REGISTRYINDEX, s->motions[i].function);
        size_t count;
        const motion_key *keys = sample(L, label, window, next, pieces, &count);
        motion_key *kept = memory_resize(NULL, count, sizeof *kept);
        if (kept == NULL) scene_fail(L, SNELL_ERR_MEMORY, NULL, "out of memory");
        memcpy(kept, keys, count * sizeof *kept);
        s->motions[i].keys = kept;
        s->motions[i].count = count;
        lua_pop(L, 3);
        luaL_unref(L, LUA_REGISTRYINDEX, s->motions[i].function);
        s->motions[i].function = LUA_NOREF;
    }
}

/* ---- motions in motions ---- */

static int compare_times(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return x < y ? -1 : x > y;
}

/* The moments at which a chain of motions is written down: a part of each turn, and every key. */
static float *chain_times(lua_State *L, const uint32_t *path, size_t depth, size_t *count) {
    lua_scene *s = scene_of(L);
    double window[2], next;
    int pieces = find_window(s, window, &next);
    size_t room = (size_t)pieces + 2, used = 0;
    for (size_t k = 0; k < depth; k++) {
        uint32_t m = s->nodes[path[k]].motion;
        if (m) room += s->motions[m - 1].count;
    }
    if (room > TIMES_MAX)
        scene_fail(L, SNELL_ERR_SYNTAX, "fewer keys", "motions in motions have more than %d keys",
                   TIMES_MAX);
    float *times = lua_newuserdatauv(L, room * sizeof *times, 0);
    for (int i = 0; i <= pieces; i++)
        times[used++] = (float)mix(window[0], window[1], (double)i / pieces);
    if (next > window[1]) times[used++] = (float)next;
    float end = times[used - 1];
    for (size_t k = 0; k < depth; k++) {
        uint32_t m = s->nodes[path[k]].motion;
        for (size_t i = 0; m && i < s->motions[m - 1].count; i++) {
            float time = s->motions[m - 1].keys[i].time;
            if (time > times[0] && time < end) times[used++] = time;
        }
    }
    qsort(times, used, sizeof *times, compare_times);
    *count = 0;
    for (size_t i = 0; i < used; i++)
        if (*count == 0 || times[i] > times[*count - 1]) times[(*count)++] = times[i];
    return times;
}

static bool is_identity(const placement *p) {
    transform rounded = dtransform_round(p);
    return transform_is_identity(&rounded);
}

/* The one motion of the chain, if nothing else in it does anything: its keys are the leaf's. */
static const lua_motion *only_motion(const lua_scene *s, const uint32_t *path, size_t depth) {
    const lua_motion *only = NULL;
    for (size_t k = 0; k < depth; k++) {
        const node *n = &s->nodes[path[k]];
        if (!is_identity(&n->placed) || (only && n->motion)) return NULL;
        if (n->motion) only = &s->motions[n->motion - 1];
    }
    return only;
}

const motion_key *motion_of_chain(lua_State *L, const uint32_t *path, size_t depth, size_t *count) {
    lua_scene *s = scene_of(L);
    const lua_motion *only = only_motion(s, path, depth);
    if (only) {
        lua_pushnil(L);
        *count = only->count;
        return only->keys;
    }
    const float *times = chain_times(L, path, depth, count);
    motion_key *keys = lua_newuserdatauv(L, *count * sizeof *keys, 0);
    sandbox_charge(L, 40 * (uint64_t)(*count * depth));
    for (size_t i = 0; i < *count; i++) {
        placement p = dtransform_identity();
        for (size_t k = 0; k < depth; k++) {
            const node *n = &s->nodes[path[k]];
            placement at;
            if (n->motion) {
                const lua_motion *m = &s->motions[n->motion - 1];
                motion_interpolate(m->keys, m->count, (double)times[i], at.m);
                p = dtransform_multiply(&p, &at);
            }
            p = dtransform_multiply(&p, &n->placed);
        }
        keys[i] = (motion_key){times[i], dtransform_round(&p)};
    }
    lua_remove(L, -2);
    return keys;
}

void motion_open(lua_State *L) {
    lua_pushcfunction(L, animation);
    lua_setglobal(L, "animation");
    motion_set_clock(L); /* that of the program which includes this one */
}

void motion_free_all(lua_scene *s) {
    for (size_t i = 0; i < s->motion_count; i++) free(s->motions[i].keys);
    free(s->motions);
}
