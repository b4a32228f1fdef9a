/* Scenes in Lua: runs a program and takes down what it makes. The language is described in
 * docs/scene.md; how it is kept deterministic, in lua_sandbox.c. */
#include "importers/lua_scene.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "importers/files.h"

enum { INCLUDE_DEPTH_MAX = 8 };
#define WORK_MAX 200000000u
#define MEMORY_MAX ((size_t)1 << 30)

/* The program that runs on this thread: included ones share its budget. */
static _Thread_local lua_scene *innermost;

/* ---- errors ---- */

uint32_t scene_line(lua_State *L, const char **file) {
    lua_Debug activation;
    if (file) *file = scene_of(L)->path;
    for (int level = 0; lua_getstack(L, level, &activation); level++) {
        lua_getinfo(L, "Sl", &activation);
        if (activation.currentline <= 0) continue;
        if (file && activation.source[0] == '@') *file = activation.source + 1;
        return (uint32_t)activation.currentline;
    }
    return 0;
}

static void copy_text(char *to, size_t size, const char *from) { snprintf(to, size, "%s", from); }

/* Wrong values are the file's fault, not the caller's. */
static snell_status of_a_file(snell_status status) {
    return status == SNELL_ERR_ARGUMENT ? SNELL_ERR_SYNTAX : status;
}

static void record(lua_State *L, snell_status status, const char *file, uint32_t line,
                   const char *hint, const char *text) {
    failure *f = &scene_of(L)->failure;
    f->status = status;
    f->line = line;
    copy_text(f->text, sizeof f->text, text);
    copy_text(f->hint, sizeof f->hint, hint ? hint : "");
    copy_text(f->file, sizeof f->file, file ? file : "");
    snprintf(f->raised, sizeof f->raised, "%s:%u: %s", f->file, f->line, f->text);
}

_Noreturn static void raise(lua_State *L) {
    lua_pushstring(L, scene_of(L)->failure.raised);
    lua_error(L);
    abort(); /* lua_error does not return, but its declaration does not say so */
}

void scene_fail(lua_State *L, snell_status status, const char *hint, const char *format, ...) {
    char text[1024], hint_copy[1024];
    const char *file;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    copy_text(hint_copy, sizeof hint_copy, hint ? hint : "");
    uint32_t line = scene_line(L, &file);
    record(L, status, file, line, hint_copy, text);
    raise(L);
}

void scene_fail_last(lua_State *L, const char *type, const char *label) {
    const char *file;
    uint32_t line = scene_line(L, &file);
    error_place((source_place){file, line, 0});
    const snell_message *last = error_last();
    char text[1024];
    copy_text(text, sizeof text, last->text);
    size_t length = type ? strlen(type) : 0;
    if (type && label && strncmp(last->text, type, length) == 0 && last->text[length] == ':')
        snprintf(text, sizeof text, "%s%s", label, last->text + length);
    record(L, of_a_file(last->status), last->file, last->line, last->hint, text);
    raise(L);
}

/* ---- words ---- */

typedef struct word_list {
    const char *label, *words;
} word_list;

static bool in_lists(const word_list *lists, size_t count, const char *label, const char *word) {
    for (size_t i = 0; i < count; i++) {
        bool here = label == NULL ? lists[i].label == NULL
                                  : lists[i].label && strcmp(lists[i].label, label) == 0;
        if (here && choice_find(lists[i].words, word) >= 0) return true;
    }
    return false;
}

/* Looked up only for words that no registered type has, so what arrives needs no change here. */
bool scene_is_later(const char *label, const char *word) {
    static const word_list later[] = {{"word", "aces|agx"}, {"field", "medium"}};
    return in_lists(later, sizeof later / sizeof later[0], label, word);
}

static int compare_words(const void *a, const void *b) {
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* Sorted, because the first of several near words is suggested, and because tables have no order.
 */
void scene_fail_unknown(lua_State *L, const char *label, const char *subject, const char *word,
                        const char **names, size_t count) {
    static const char *const sandboxed =
        "io|os|debug|load|loadfile|loadstring|dofile|require|package|coroutine|collectgarbage|"
        "utf8|xpcall|warn|_G";
    qsort(names, count, sizeof *names, compare_words);
    char list[448] = "", hint[512];
    for (size_t i = 0; i < count; i++) {
        size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", names[i]);
    }
    if (scene_is_later(label, word) || (label && scene_is_later("field", word))) {
        snprintf(hint, sizeof hint, "this version has %s", list);
        scene_fail(L, SNELL_ERR_UNSUPPORTED, label ? hint : NULL, "%s%s'%s' is not in this version",
                   label ? label : "", label ? ": " : "", word);
    }
    if (label == NULL && choice_find("time|frame", word) >= 0)
        scene_fail(L, SNELL_ERR_SYNTAX, "write animation { fps = 24, first = 1, last = 120 } first",
                   "'%s' is read before animation { } has set it", word);
    if (label == NULL && choice_find(sandboxed, word) >= 0)
        scene_fail(L, SNELL_ERR_SYNTAX, "scenes run in a sandbox, the same in every run",
                   "'%s' is not available in a scene", word);
    const char *near = closest_word(word, names, count);
    snprintf(hint, sizeof hint, near ? "did you mean '%s'?" : "it has %s", near ? near : list);
    bool helps = near != NULL || (label != NULL && count > 0);
    scene_fail(L, SNELL_ERR_SYNTAX, helps ? hint : NULL, "%s '%s'", subject, word);
}

/* ---- errors of Lua itself ---- */

/* If the text begins with the place of this activation, the text without it. */
static const char *after_place(const char *text, const lua_Debug *activation) {
    char prefix[LUA_IDSIZE + 32];
    int length =
        snprintf(prefix, sizeof prefix, "%s:%d: ", activation->short_src, activation->currentline);
    return strncmp(text, prefix, (size_t)length) == 0 ? text + length : NULL;
}

/* The message handler: records an error that Lua or the program raised, while the stack still
 * stands. */
static int note_error(lua_State *L) {
    const failure *known = &scene_of(L)->failure;
    const char *text = lua_type(L, 1) == LUA_TSTRING ? lua_tostring(L, 1) : NULL;
    if (known->final || (text && strcmp(text, known->raised) == 0)) return 1;
    char buffer[128];
    if (text == NULL) {
        snprintf(buffer, sizeof buffer, "error with a %s instead of a text", luaL_typename(L, 1));
        text = buffer;
    }
    const char *file;
    uint32_t line = scene_line(L, &file);
    lua_Debug activation;
    for (int level = 0; lua_getstack(L, level, &activation); level++) {
        lua_getinfo(L, "Sl", &activation);
        const char *rest = activation.currentline > 0 ? after_place(text, &activation) : NULL;
        if (rest == NULL) continue;
        text = rest;
        line = (uint32_t)activation.currentline;
        break;
    }
    record(L, SNELL_ERR_SYNTAX, file, line, NULL, text);
    return 1;
}

/* The line on which brackets are first nested `limit` deep; strings and comments are not told apart
 * from the rest. 0: nowhere. */
static uint32_t nesting_line(const char *text, size_t size, int limit) {
    uint32_t line = 1;
    int depth = 0;
    for (size_t i = 0; i < size; i++) {
        if (text[i] == '\n') line++;
        if (strchr("([{", text[i]) && text[i]) depth++;
        if (strchr(")]}", text[i]) && text[i]) depth--;
        if (depth >= limit) return line;
    }
    return 0;
}

_Noreturn static void fail_syntax(lua_State *L, const char *chunk, const char *text, size_t size) {
    const char *message = lua_tostring(L, -1);
    if (message == NULL) message = "the program cannot be read";
    if (strstr(message, "overflow")) { /* of C levels: Lua's parser is recursive */
        record(L, SNELL_ERR_SYNTAX, scene_of(L)->path, nesting_line(text, size, 150), NULL,
               "too deeply nested: Lua reads at most 200 levels");
        raise(L);
    }
    lua_Debug activation;
    uint32_t line = 0;
    if (luaL_loadbufferx(L, "", 0, chunk, "t") == LUA_OK && lua_getinfo(L, ">S", &activation)) {
        size_t length = strlen(activation.short_src);
        if (strncmp(message, activation.short_src, length) == 0 && message[length] == ':') {
            char *end;
            line = (uint32_t)strtoul(message + length + 1, &end, 10);
            if (strncmp(end, ": ", 2) == 0) message = end + 2;
        }
    }
    char copy[1024];
    copy_text(copy, sizeof copy, message);
    record(L, SNELL_ERR_SYNTAX, scene_of(L)->path, line, NULL, copy);
    raise(L);
}

/* ---- running ---- */

typedef struct program {
    const char *text;
    size_t size;
} program;

static int run(lua_State *L) {
    const program *p = lua_touserdata(L, 1);
    lua_scene *s = scene_of(L);
    sandbox_open(L);
    if (!pow_is_ours(L))
        scene_fail(L, SNELL_ERR_INTERNAL, "build snell-import as CMakeLists.txt does",
                   "this build's Lua computes x^y by the C library, which is not repeatable");
    if (!sandbox_is_seeded(L) &&
        description_add_message(s->d, SNELL_WARNING, s->path, 0, "docs/decisions has more",
                                "this build's Lua is unknown: the length of a table with holes may "
                                "differ between runs"))
        scene_fail_last(L, NULL, NULL);
    nodes_open(L);
    transform_open(L);
    objects_open(L);
    solids_open(L);
    files_open(L);
    motion_open(L);
    const char *chunk = lua_pushfstring(L, "@%s", s->path);
    int status = luaL_loadbufferx(L, p->text, p->size, chunk, "t");
    if (status == LUA_ERRMEM) lua_error(L);
    if (status != LUA_OK) fail_syntax(L, chunk, p->text, p->size);
    lua_call(L, 0, 0);
    nodes_draw(L);
    objects_frame_cameras(L);
    files_check_params(L);
    return 0;
}

static void note_memory(lua_scene *s) {
    failure *f = &s->failure;
    f->status = SNELL_ERR_MEMORY;
    f->line = s->memory_line;
    copy_text(f->file, sizeof f->file, s->path);
    f->hint[0] = '\0';
    if (s->string_refused)
        snprintf(f->text, sizeof f->text, "a text longer than 1 MiB");
    else
        snprintf(f->text, sizeof f->text, "the program needs more than %zu MiB of memory",
                 s->memory_max >> 20);
}

static void begin(lua_scene *s, const char *path, const import_options *options, description *d) {
    lua_scene *parent = innermost;
    *s = (lua_scene){.d = d,
                     .options = options,
                     .path = path,
                     .parent = parent,
                     .depth = parent ? parent->depth + 1 : 0,
                     .work = parent ? parent->work : 0,
                     .work_max = WORK_MAX,
                     .cpu_start = sandbox_cpu_seconds(),
                     .random = 1};
    s->memory_max = options->memory_max / 2 < MEMORY_MAX && options->memory_max > 0
                        ? (size_t)options->memory_max / 2
                        : MEMORY_MAX;
    if (parent) s->memory_max = parent->memory_max - parent->memory;
}

static snell_status report(const lua_scene *s) {
    const failure *f = &s->failure;
    return error_set_at(f->status, (source_place){f->file, f->line, 0}, f->hint, "%s", f->text);
}

static snell_status execute(const char *path, program *p, const import_options *options,
                            description *d) {
    lua_scene *s = calloc(1, sizeof *s);
    if (s == NULL) return error_no_memory();
    begin(s, path, options, d);
    innermost = s;
    lua_State *L = lua_newstate(sandbox_allocate, s);
    int result = LUA_ERRMEM;
    if (L) {
        *(lua_scene **)lua_getextraspace(L) = s;
        s->L = L;
        lua_pushcfunction(L, note_error);
        lua_pushcfunction(L, run);
        lua_pushlightuserdata(L, p);
        result = lua_pcall(L, 1, 0, 1);
        s->L = NULL; /* closing is not the program's work */
        lua_close(L);
    }
    innermost = s->parent;
    if (s->parent) s->parent->work = s->work;
    if (result == LUA_ERRMEM && !s->failure.final) note_memory(s);
    if (result != LUA_OK && s->failure.status == SNELL_OK) {
        s->failure.status = SNELL_ERR_SYNTAX;
        copy_text(s->failure.file, sizeof s->failure.file, path);
        copy_text(s->failure.text, sizeof s->failure.text, "an error while handling an error");
    }
    snell_status status = result == LUA_OK ? SNELL_OK : report(s);
    nodes_free(s);
    free(s);
    return status;
}

/* A first line that starts with # is for the shell; a byte order mark is for nobody. */
static program skip_preamble(char *text, size_t size) {
    if (size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0) {
        text += 3;
        size -= 3;
    }
    if (size && text[0] == '#')
        for (size_t i = 0; i < size && text[i] != '\n'; i++) text[i] = ' ';
    return (program){text, size};
}

static snell_status read_scene(const char *path, const import_options *options, description *d) {
    if (!options->allow_programs)
        return error_set_at(SNELL_ERR_UNSUPPORTED, (source_place){path, 0, 0},
                            "the caller did not allow programs",
                            "a Lua scene is a program, and none may run here");
    if (innermost && innermost->depth + 1 >= INCLUDE_DEPTH_MAX)
        return error_set_at(SNELL_ERR_SYNTAX, (source_place){path, 0, 0},
                            "does a file include itself?", "scenes in scenes, more than %d deep",
                            INCLUDE_DEPTH_MAX);
    uint8_t *data;
    size_t size;
    snell_status status = import_read_file(path, NULL, options, &data, &size);
    if (status) {
        error_place((source_place){path, 0, 0});
        return status;
    }
    description_mark mark = description_get_mark(d);
    program p = skip_preamble((char *)data, size);
    status = execute(path, &p, options, d);
    free(data);
    if (status) {
        description_rewind(d, &mark);
        return status;
    }
    snprintf(d->format, sizeof d->format, "lua");
    d->is_model = false;
    return SNELL_OK;
}

/* ---- recognising ---- */

static bool is_word(uint8_t c) { return isalnum(c) || c == '_'; }

static size_t skip_blanks(const uint8_t *text, size_t size, size_t at) {
    while (at < size && (text[at] == ' ' || text[at] == '\t')) at++;
    return at;
}

/* The end of the word at `at`, which goes to `word`. */
static size_t take_word(const uint8_t *text, size_t size, size_t at, char word[32]) {
    size_t length = 0;
    for (; at < size && is_word(text[at]); at++)
        if (length < 31) word[length++] = (char)text[at];
    word[length] = '\0';
    return at;
}

static bool is_vocabulary(const char *word) {
    static const char *const more = "camera|light|material|texture|group|instance|model|include|"
                                    "union|intersection|difference|triangle|transform|param|"
                                    "animation";
    return choice_find(more, word) >= 0 || type_find(CATEGORY_SHAPE, word) != NULL ||
           type_find(CATEGORY_SETTING, word) != NULL;
}

/* "-- comment", or a call from the vocabulary: "sphere {", "light.point {", "param(", "include \"",
 * each perhaps after "local name =". */
static bool is_scene_line(const uint8_t *line, size_t size) {
    char word[32];
    size_t at = skip_blanks(line, size, 0);
    if (size - at >= 2 && line[at] == '-' && line[at + 1] == '-') return true;
    at = take_word(line, size, at, word);
    if (strcmp(word, "local") == 0) at = take_word(line, size, skip_blanks(line, size, at), word);
    size_t next = skip_blanks(line, size, at);
    if (next < size && line[next] == '=')
        at = take_word(line, size, skip_blanks(line, size, next + 1), word);
    if (!is_vocabulary(word)) return false;
    if (at < size && line[at] == '.') at = take_word(line, size, at + 1, word);
    at = skip_blanks(line, size, at);
    return at < size && (line[at] == '{' || line[at] == '(' || line[at] == '"');
}

/* Text, one of whose first lines a scene program could have. */
static bool looks_like_scene(const uint8_t *first, size_t size) {
    bool found = false;
    for (size_t at = 0; at < size; at++) {
        uint8_t c = first[at];
        if ((c < 32 && c != '\n' && c != '\r' && c != '\t' && c != '\f') || c == 127) return false;
    }
    for (size_t at = 0; at < size && !found;) {
        const uint8_t *end = memchr(first + at, '\n', size - at);
        size_t length = end ? (size_t)(end - first) - at : size - at;
        found = is_scene_line(first + at, length);
        at += length + 1;
    }
    return found;
}

static bool recognise(const char *extension, const uint8_t *first, size_t size) {
    return strcmp(extension, ".lua") == 0 || looks_like_scene(first, size);
}

const importer importer_lua = {
    .name = "lua",
    .extensions = ".lua",
    .help = "scenes of snell, programs in Lua 5.4",
    .recognise = recognise,
    .read = read_scene,
};
