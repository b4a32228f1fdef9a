#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { TEXT_MAX = 1024, FILE_MAX = 512 };

typedef struct thread_error {
    snell_message message;
    char text[TEXT_MAX], hint[TEXT_MAX], file[FILE_MAX];
} thread_error;

static _Thread_local thread_error last = {.message = {SNELL_OK, SNELL_ERROR, "", "", "", 0, 0}};

static void copy_text(char *to, size_t size, const char *from) {
    snprintf(to, size, "%s", from ? from : "");
}

static snell_status record(snell_status status, source_place place, const char *hint,
                           const char *format, va_list arguments) {
    char text[TEXT_MAX], hint_copy[TEXT_MAX],
        file[FILE_MAX]; /* arguments may point into the old error */
    vsnprintf(text, sizeof text, format, arguments);
    copy_text(hint_copy, sizeof hint_copy, hint);
    copy_text(file, sizeof file, place.file);
    memcpy(last.text, text, sizeof text);
    memcpy(last.hint, hint_copy, sizeof hint_copy);
    memcpy(last.file, file, sizeof file);
    last.message = (snell_message){.status = status,
                                   .severity = SNELL_ERROR,
                                   .text = last.text,
                                   .hint = last.hint,
                                   .file = last.file,
                                   .line = place.line,
                                   .column = place.column};
    return status;
}

snell_status error_set(snell_status status, const char *hint, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    record(status, (source_place){0}, hint, format, arguments);
    va_end(arguments);
    return status;
}

snell_status error_set_at(snell_status status, source_place place, const char *hint,
                          const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    record(status, place, hint, format, arguments);
    va_end(arguments);
    return status;
}

void error_place(source_place place) {
    if (last.message.file == NULL || last.message.file[0] == '\0') {
        copy_text(last.file, sizeof last.file, place.file);
        last.message.file = last.file;
    }
    if (last.message.line == 0) {
        last.message.line = place.line;
        last.message.column = place.column;
    }
}

void error_clear(void) {
    last.text[0] = last.hint[0] = last.file[0] = '\0';
    last.message = (snell_message){SNELL_OK, SNELL_ERROR, last.text, last.hint, last.file, 0, 0};
}

const snell_message *error_last(void) { return &last.message; }

snell_status error_no_memory(void) {
    return error_set(SNELL_ERR_MEMORY, "use a smaller model or picture, or more memory",
                     "out of memory");
}

void log_write(const log_sink *sink, snell_severity severity, source_place place, const char *hint,
               const char *format, ...) {
    if (sink == NULL || sink->write == NULL) return;
    char text[TEXT_MAX];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    snell_message message = {.status = SNELL_OK,
                             .severity = severity,
                             .text = text,
                             .hint = hint ? hint : "",
                             .file = place.file ? place.file : "",
                             .line = place.line,
                             .column = place.column};
    sink->write(sink->user, &message);
}

/* Of two short words: a letter more, less or other, or two neighbours swapped, count one each (the
 * "optimal string alignment" distance). Words over 63 bytes count as far. */
static size_t edit_distance(const char *a, const char *b) {
    size_t length = strlen(a), columns = strlen(b);
    if (length > 63 || columns > 63) return SIZE_MAX;
    size_t rows[3][64];
    for (size_t j = 0; j <= columns; j++) rows[0][j] = j;
    for (size_t i = 1; i <= length; i++) {
        size_t *row = rows[i % 3];
        const size_t *above = rows[(i + 2) % 3], *above2 = rows[(i + 1) % 3];
        row[0] = i;
        for (size_t j = 1; j <= columns; j++) {
            size_t best = above[j - 1] + (a[i - 1] != b[j - 1]);
            if (above[j] + 1 < best) best = above[j] + 1;
            if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
            bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped && above2[j - 2] + 1 < best) best = above2[j - 2] + 1;
            row[j] = best;
        }
    }
    return rows[length % 3][columns];
}

const char *closest_word(const char *word, const char *const *choices, size_t count) {
    const char *best = NULL;
    size_t length = strlen(word);
    size_t far = length < 2 ? 0 : length < 6 ? 1 : length / 3; /* one error in three letters */
    size_t best_distance = far + 1;
    for (size_t i = 0; i < count; i++) {
        size_t distance = edit_distance(word, choices[i]);
        if (distance < best_distance) {
            best_distance = distance;
            best = choices[i];
        }
    }
    return best;
}
