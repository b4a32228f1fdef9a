/* The built-in scenes; the table is generated from scenes/ when the program is built. */
#ifndef SNELL_CLI_EXAMPLES_H
#define SNELL_CLI_EXAMPLES_H

#include <stddef.h>

typedef struct example_scene {
    const char *name;
    const unsigned char *text; /* size bytes, then a zero */
    size_t size;
} example_scene;

extern const example_scene example_table[];
extern const size_t example_count;

#endif
