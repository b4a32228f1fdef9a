/* Errors are values: a status, and the text of the calling thread's last error. Nothing here
 * prints. */
#ifndef SNELL_BASE_ERROR_H
#define SNELL_BASE_ERROR_H

#include <snell/snell.h>

#if defined(__GNUC__)
#define PRINTF_LIKE(text, first) __attribute__((format(printf, text, first)))
#else
#define PRINTF_LIKE(text, first)
#endif

/* A place in a file; file NULL: none; line and column from 1, 0 when unknown. */
typedef struct source_place {
    const char *file;
    uint32_t line, column;
} source_place;

/* Records the thread's last error and returns `status`, so that `return error_set(...)` reads well.
 * Texts are cut at 1023 bytes. `hint` says what to do next, or is NULL. */
snell_status error_set(snell_status status, const char *hint, const char *format, ...)
    PRINTF_LIKE(3, 4);
snell_status error_set_at(snell_status status, source_place place, const char *hint,
                          const char *format, ...) PRINTF_LIKE(4, 5);
/* Gives the last error a place if it has none. */
void error_place(source_place place);
void error_clear(void);
const snell_message *error_last(void);

snell_status error_no_memory(void);

/* A log that the context owns; warnings of importers and of the core go here. */
typedef struct log_sink {
    snell_log_fn *write; /* NULL: silent */
    void *user;
} log_sink;
void log_write(const log_sink *sink, snell_severity severity, source_place place, const char *hint,
               const char *format, ...) PRINTF_LIKE(5, 6);

/* Of `choices` (count strings), the one most like `word` by edit distance; NULL when none is near:
 * at most one error in three letters, or one in a word of two to five. */
const char *closest_word(const char *word, const char *const *choices, size_t count);

#endif
