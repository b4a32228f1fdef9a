/* Words and numbers: small helpers without state. */
#ifndef SNELL_CLI_TEXT_H
#define SNELL_CLI_TEXT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include <snell/snell.h>

/* Of `count` words the one most like `word`, NULL when none is near. */
const char *text_closest(const char *word, const char *const *words, size_t count);
/* Whether `word` is one of "a|b|c"; the next function gives the nearest of them in `out`. */
bool text_choice_has(const char *choices, const char *word);
bool text_choice_closest(const char *choices, const char *word, char *out, size_t size);
/* "a|b|c" as "a, b, c". */
void text_choice_list(const char *choices, char *out, size_t size);

/* Whole numbers and decimals; the entire text must be one. */
bool text_uint(const char *text, uint64_t min, uint64_t max, uint64_t *out);
bool text_number(const char *text, double *out);  /* finite; with '.', whatever the locale */
bool text_bytes(const char *text, uint64_t *out); /* 512M, 8G, 100000 */
/* #rgb, #rrggbb (sRGB), one number (grey), r,g,b (linear), or a name: the sixteen of CSS 1, orange
 * and pink. */
#define TEXT_COLORS                                                                                \
    "white|silver|grey|gray|black|red|maroon|yellow|olive|lime|green|cyan|teal|blue|navy|magenta|" \
    "purple|orange|pink"
bool text_color(const char *text, snell_vec3 *out);

/* Prints with control characters made visible: names come out of other people's files. */
void text_print_safe(FILE *to, const char *text);
/* Prints as one word of a shell. */
void text_print_shell(FILE *to, const char *text);
/* Prints `text` wrapped to `width` columns, each line but the first indented; returns the column
 * where it ended. */
size_t text_print_wrapped(FILE *to, const char *text, size_t column, size_t indent, size_t width);
/* "1.2 GiB"; "12 345 678"; both into a buffer of 32. */
void text_format_bytes(uint64_t bytes, char out[32]);
void text_format_count(uint64_t count, char out[32]);
/* "%.9g" without needless digits: reads back as the same float. */
void text_format_float(float value, char out[32]);

#endif
