#include "report.h"

#include <errno.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "progress.h"
#include "text.h"

enum { WARNINGS_SHOWN = 10, TEXT_MAX = 2048 };

/* One program, one terminal: the only state of its kind. */
static struct {
    enum report_level level;
    bool json, strict, color_always, color_never, emitted, muted;
    const char *alias_real, *alias_shown;
    unsigned warning_count;
    json_t *warnings, *error;
    pthread_mutex_t mutex;
} state = {.level = LEVEL_NORMAL, .mutex = PTHREAD_MUTEX_INITIALIZER};

void report_setup(const options *o) {
    state.level = LEVEL_NORMAL;
    if (o->given[OPT_VERBOSE] > 0) state.level = LEVEL_VERBOSE;
    if (o->given[OPT_VERBOSE] > 1) state.level = LEVEL_DEBUG;
    if (o->given[OPT_QUIET] > 0) state.level = LEVEL_QUIET;
    state.json = o->value[OPT_JSON] != NULL;
    state.strict = o->value[OPT_STRICT] != NULL;
    const char *color = o->value[OPT_COLOR];
    state.color_always = color != NULL && strcmp(color, "always") == 0;
    state.color_never = color != NULL && strcmp(color, "never") == 0;
}

enum report_level report_level(void) { return state.level; }
bool report_json(void) { return state.json; }
bool report_emitted(void) { return state.emitted; }
void report_lock(void) { pthread_mutex_lock(&state.mutex); }
void report_unlock(void) { pthread_mutex_unlock(&state.mutex); }

bool report_color(int fd) {
    if (state.color_always) return true;
    const char *no_color = getenv("NO_COLOR"), *term = getenv("TERM");
    if (state.color_never || (no_color != NULL && *no_color != '\0')) return false;
    return isatty(fd) && term != NULL && strcmp(term, "dumb") != 0;
}

void report_alias(const char *real, const char *shown) {
    state.alias_real = real;
    state.alias_shown = shown;
}

json_t *report_text(const char *text) {
    json_t *string = json_string(text);
    if (string != NULL) return string;
    /* Not UTF-8: every byte above 127 becomes U+FFFD. */
    size_t length = strlen(text), used = 0;
    char *safe = malloc(length * 3 + 1);
    if (safe == NULL) return json_null();
    for (size_t i = 0; i < length; i++) {
        if ((unsigned char)text[i] < 128) {
            safe[used++] = text[i];
        } else {
            memcpy(safe + used, "\xef\xbf\xbd", 3);
            used += 3;
        }
    }
    safe[used] = '\0';
    string = json_string(safe);
    free(safe);
    return string == NULL ? json_null() : string;
}

/* Copies text, with the alias in place of the real path. */
static void copy_aliased(const char *text, char *out, size_t size) {
    const char *at = NULL;
    if (state.alias_real != NULL && *state.alias_real != '\0') at = strstr(text, state.alias_real);
    if (at == NULL) {
        snprintf(out, size, "%s", text);
    } else {
        snprintf(out, size, "%.*s%s%s", (int)(at - text), text, state.alias_shown,
                 at + strlen(state.alias_real));
    }
}

static const char *status_word(snell_status status) {
    static const char *const words[] = {"ok", "cancelled", "argument",    "state",   "memory",
                                        "io", "syntax",    "unsupported", "version", "internal"};
    size_t index = (size_t)status;
    return index < sizeof words / sizeof words[0] ? words[index] : "internal";
}

static const char *code_word(int code) {
    static const char *const words[] = {"ok",          "some_failed", "usage",  "input",
                                        "unsupported", "io",          "memory", "internal"};
    return words[code];
}

static int status_code(snell_status status) {
    static const int codes[] = {[SNELL_OK] = EXIT_DONE,
                                [SNELL_CANCELLED] = EXIT_SOME_FAILED,
                                [SNELL_ERR_ARGUMENT] = EXIT_INPUT,
                                [SNELL_ERR_STATE] = EXIT_FAULT,
                                [SNELL_ERR_MEMORY] = EXIT_MEMORY,
                                [SNELL_ERR_IO] = EXIT_IO,
                                [SNELL_ERR_SYNTAX] = EXIT_INPUT,
                                [SNELL_ERR_UNSUPPORTED] = EXIT_UNSUPPORTED,
                                [SNELL_ERR_VERSION] = EXIT_FAULT,
                                [SNELL_ERR_INTERNAL] = EXIT_FAULT};
    size_t index = (size_t)status;
    return index < sizeof codes / sizeof codes[0] ? codes[index] : EXIT_FAULT;
}

/* A message as it is shown and kept; texts are never NULL. */
typedef struct shown {
    const char *text, *hint, *file;
    unsigned line, column;
} shown;

static json_t *shown_json(const shown *m, const char *status) {
    json_t *object = json_object();
    if (status != NULL) json_object_set_new(object, "status", json_string(status));
    json_object_set_new(object, status != NULL ? "message" : "text", report_text(m->text));
    json_object_set_new(object, "hint", report_text(m->hint));
    json_object_set_new(object, "file", report_text(m->file));
    json_object_set_new(object, "line", json_integer(m->line));
    json_object_set_new(object, "column", json_integer(m->column));
    return object;
}

/* `kind` is "error", "warning" or NULL for notes. Errors read "snell: duck.lua:3:7: text". */
static void print_message(const char *kind, const shown *m) {
    bool color = report_color(STDERR_FILENO);
    const char *paint = "";
    if (color && kind != NULL) paint = strcmp(kind, "error") == 0 ? "\033[1;31m" : "\033[1;33m";
    report_lock();
    progress_clear();
    fprintf(stderr, "%ssnell:%s ", paint, *paint != '\0' ? "\033[0m" : "");
    /* "x.lua: cannot open 'x.lua'" would name it twice. */
    if (m->file[0] != '\0' && (m->line > 0 || strstr(m->text, m->file) == NULL)) {
        text_print_safe(stderr, m->file);
        if (m->line > 0) fprintf(stderr, ":%u", m->line);
        if (m->line > 0 && m->column > 0) fprintf(stderr, ":%u", m->column);
        fputs(": ", stderr);
    }
    if (kind != NULL && strcmp(kind, "warning") == 0) fputs("warning: ", stderr);
    text_print_safe(stderr, m->text);
    fputc('\n', stderr);
    if (m->hint[0] != '\0') {
        fputs("       ", stderr);
        text_print_safe(stderr, m->hint);
        fputc('\n', stderr);
    }
    report_unlock();
}

static int keep_error(int code, const char *status, const shown *m) {
    print_message("error", m);
    json_decref(state.error);
    state.error = shown_json(m, status);
    json_object_set_new(state.error, "exit", json_integer(code));
    return code;
}

int report_usage(const char *hint, const char *format, ...) {
    char text[TEXT_MAX];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    shown m = {text, hint == NULL ? "" : hint, "", 0, 0};
    return keep_error(EXIT_USAGE, "usage", &m);
}

int report_error(int code, const char *hint, const char *format, ...) {
    char text[TEXT_MAX];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    shown m = {text, hint == NULL ? "" : hint, "", 0, 0};
    return keep_error(code, code_word(code), &m);
}

int report_no_output(int number) {
    return report_error(EXIT_IO, NULL, "standard output cannot be written%s%s",
                        number != 0 ? ": " : "", number != 0 ? strerror(number) : "");
}

int report_status(snell_status status, const char *path) {
    return report_status_as(status_code(status), status, path);
}

int report_status_as(int code, snell_status status, const char *path) {
    const snell_message *last = snell_last_error();
    char text[TEXT_MAX], hint[TEXT_MAX], file[TEXT_MAX];
    copy_aliased(last->text[0] != '\0' ? last->text : status_word(status), text, sizeof text);
    copy_aliased(last->hint, hint, sizeof hint);
    copy_aliased(last->file, file, sizeof file);
    /* A message that does not say which file it is about gets the one at hand. */
    if (file[0] == '\0' && path != NULL && strstr(text, path) == NULL) {
        copy_aliased(path, file, sizeof file);
    }
    if (code == EXIT_FAULT && hint[0] == '\0') {
        snprintf(hint, sizeof hint, "this is a fault in snell itself: please report it");
    }
    shown m = {text, hint, file, last->line, last->column};
    return keep_error(code, code == EXIT_USAGE ? code_word(code) : status_word(status), &m);
}

void report_mute(bool muted) { state.muted = muted; }

static void keep_warning(const shown *m) {
    if (state.muted) return;
    report_lock();
    if (state.warnings == NULL) state.warnings = json_array();
    json_array_append_new(state.warnings, shown_json(m, NULL));
    unsigned count = ++state.warning_count;
    report_unlock();
    if (count <= WARNINGS_SHOWN || state.level >= LEVEL_VERBOSE) {
        print_message("warning", m);
    } else if (count == WARNINGS_SHOWN + 1) {
        shown more = {"there are more; -v or --json shows all", "", "", 0, 0};
        print_message("warning", &more);
    }
}

void report_warning(const char *hint, const char *format, ...) {
    char text[TEXT_MAX];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    shown m = {text, hint == NULL ? "" : hint, "", 0, 0};
    keep_warning(&m);
}

void report_note(const char *format, ...) {
    if (state.level == LEVEL_QUIET || state.muted) return;
    char text[TEXT_MAX];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    report_lock();
    progress_clear();
    text_print_safe(stderr, text);
    fputc('\n', stderr);
    report_unlock();
}

void report_log(void *user, const snell_message *message) {
    (void)user;
    if (state.muted && message->severity < SNELL_ERROR) return;
    char text[TEXT_MAX], hint[TEXT_MAX], file[TEXT_MAX];
    copy_aliased(message->text, text, sizeof text);
    copy_aliased(message->hint, hint, sizeof hint);
    copy_aliased(message->file, file, sizeof file);
    shown m = {text, hint, file, message->line, message->column};
    /* A note with a line is what a scene program prints. */
    bool printed = message->severity == SNELL_INFO && message->line > 0;
    for (char *c = text; printed && *c != '\0'; c++) *c = *c == '\t' ? ' ' : *c;
    enum report_level least = printed                           ? LEVEL_NORMAL
                              : message->severity == SNELL_INFO ? LEVEL_VERBOSE
                                                                : LEVEL_DEBUG;
    if (message->severity >= SNELL_WARNING) {
        keep_warning(&m);
    } else if (state.level >= least) {
        print_message(NULL, &m);
    }
}

int report_strict(void) {
    if (!state.strict || state.warning_count == 0) return EXIT_DONE;
    return report_error(EXIT_UNSUPPORTED, "without --strict they would be accepted",
                        "%u warning%s, and --strict", state.warning_count,
                        state.warning_count == 1 ? "" : "s");
}

void report_begin(void) {
    json_decref(report_take_warnings());
    json_decref(state.error);
    state.error = NULL;
    state.warning_count = 0;
}

json_t *report_take_warnings(void) {
    json_t *warnings = state.warnings == NULL ? json_array() : state.warnings;
    state.warnings = NULL;
    return warnings;
}

json_t *report_take_error(void) {
    json_t *error = state.error;
    state.error = NULL;
    return error;
}

static int emit(json_t *object, int code, size_t precision) {
    state.emitted = true;
    errno = 0;
    bool written = object != NULL &&
                   json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(precision)) == 0;
    json_decref(object);
    if (written && fputc('\n', stdout) != EOF && fflush(stdout) == 0) return code;
    return code != EXIT_DONE ? code : report_no_output(errno);
}

int report_emit(json_t *object, int code) { return emit(object, code, 9); }
int report_emit_exactly(json_t *object, int code) { return emit(object, code, 17); }
