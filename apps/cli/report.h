/* What the user is told: errors, warnings, notes, and the one JSON object.
 *
 * Threads: the library's log callback may come from a worker while another draws the progress line,
 * so everything that writes to standard error holds report_lock. */
#ifndef SNELL_CLI_REPORT_H
#define SNELL_CLI_REPORT_H

#include <jansson.h>
#include <snell/snell.h>

#include "options.h"

#define PRINTF_LIKE(text, first) __attribute__((format(printf, text, first)))

enum exit_code {
    EXIT_DONE,
    EXIT_SOME_FAILED,
    EXIT_DIFFERS = EXIT_SOME_FAILED,
    EXIT_USAGE,
    EXIT_INPUT,
    EXIT_UNSUPPORTED,
    EXIT_IO,
    EXIT_MEMORY,
    EXIT_FAULT
};

enum report_level { LEVEL_QUIET, LEVEL_NORMAL, LEVEL_VERBOSE, LEVEL_DEBUG };

void report_setup(const options *o);
enum report_level report_level(void);
bool report_json(void);
bool report_color(int fd);
void report_lock(void);
void report_unlock(void);

/* Each prints `snell: text` (hint on the next line when not NULL), keeps it for --json, and returns
 * the exit code. */
int report_usage(const char *hint, const char *format, ...) PRINTF_LIKE(2, 3);
/* EXIT_IO; number: the errno, 0: not known. */
int report_no_output(int number);
int report_error(int code, const char *hint, const char *format, ...) PRINTF_LIKE(3, 4);
/* The library's last error. `path` is put before a message that names no file; may be NULL. */
int report_status(snell_status status, const char *path);
/* The same with an exit code of the caller's. */
int report_status_as(int code, snell_status status, const char *path);
void report_warning(const char *hint, const char *format, ...) PRINTF_LIKE(2, 3);
/* A line on standard error unless --quiet. */
void report_note(const char *format, ...) PRINTF_LIKE(1, 2);
/* Muted, warnings and notes are neither shown nor kept; errors are. */
void report_mute(bool muted);
void report_log(void *user, const snell_message *message); /* a snell_log_fn */

/* Messages about `real` speak of `shown` instead; NULL, NULL ends it. Both are borrowed. */
void report_alias(const char *real, const char *shown);

/* By --strict: the error that stands for the warnings since report_begin, reported; else 0. */
int report_strict(void);
void report_begin(void); /* forgets warnings and error: another file comes */
json_t *report_take_warnings(void);
json_t *report_take_error(void); /* NULL when there was none */

/* The one object on standard output; takes the reference. Returns `code`, or 5 if writing failed.
 */
int report_emit(json_t *object, int code);
int report_emit_exactly(json_t *object, int code); /* numbers with all their digits */
bool report_emitted(void);
json_t *report_text(const char *text); /* a JSON string, also of bytes that are not UTF-8 */

#endif
