/* The text of an OBJ file before it is read: which text is one, and its lines as the reader wants them. */
#ifndef SNELL_IMPORTERS_OBJ_TEXT_H
#define SNELL_IMPORTERS_OBJ_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* begin[size] is 0. */
typedef struct obj_text {
    const char *begin, *lines; /* lines: the same before its lines were joined, for places */
    size_t size;
    char *copy; /* owned; NULL: the text could stay as it was */
} obj_text;

/* From UTF-8, with a mark or without, or UTF-16: lines that end with \n, each whole though a backslash parted
 * it. text[size] is 0, size > 0; *out begins with zeros and borrows the text. false: out of memory. */
bool obj_text_prepare(const char *text, size_t size, obj_text *out);

/* The first line that says something begins with a word of OBJ, and one of them is a vertex, a face
 * or a material library. */
bool obj_text_is_likely(const uint8_t *first, size_t size);

#endif
