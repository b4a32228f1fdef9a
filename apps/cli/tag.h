/* The text inside a picture that tells how it was made: {"snell": version, "file": as typed,
 * "options": [...]}, the options written as on the command line, and nothing that does not decide
 * the picture. */
#ifndef SNELL_CLI_TAG_H
#define SNELL_CLI_TAG_H

#include <jansson.h>
#include <snell/snell.h>

#include "options.h"

/* The caller frees it; NULL on lack of memory. */
char *tag_make(const options *o, const char *file, const snell_render_desc *desc, uint32_t frame,
               bool partial); /* frame 0: none was asked for */
/* NULL when the tag is not of this form, or an option in it is not render's. */
json_t *tag_read(const char *tag);

#endif
