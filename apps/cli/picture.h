/* A picture file as compare and convert read it: pixels, and the tag of how snell made it. */
#ifndef SNELL_CLI_PICTURE_H
#define SNELL_CLI_PICTURE_H

#include <jansson.h>
#include <snell/snell.h>

#include "session.h"
#include "values.h"

typedef struct picture_file {
    const char *path; /* as typed */
    snell_film *film;
    char *tag;      /* "" when there is none; snell_free */
    json_t *parsed; /* NULL when it is not snell's */
} picture_file;

/* Exit code, errors reported; the layer is --layer's. "-": standard input. */
int picture_open(session *s, const char *path, picture_file *out);
void picture_close(picture_file *p);
/* Another layer of the same file, if it has one of that name; else *out is NULL. */
int picture_open_layer(session *s, const picture_file *p, const char *layer, snell_film **out);

typedef struct picture_look {
    float exposure;
    const char *tonemap; /* borrowed */
    char white_balance[WHITE_TEXT_MAX];
} picture_look;
/* How floats are shown: as the command line says, else as the render that made the picture (of files
 * of floats, which have no look of their own), else exposure 0 and clip. */
int picture_read_look(const options *o, const picture_file *p, picture_look *out);

#endif
