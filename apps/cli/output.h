/* Where a picture goes, and whether it may. */
#ifndef SNELL_CLI_OUTPUT_H
#define SNELL_CLI_OUTPUT_H

#include <snell/snell.h>

#include "options.h"

typedef struct output {
    char *path;         /* owned; "-" for standard output */
    const char *given;  /* what -o said; NULL: the default rule */
    const char *format; /* "png", ... for standard output */
    bool force;
} output;

/* Names the picture of `input`, and checks before any work that it can be written. frame: 0, or the
 * number that --frames puts into the name. Exit code. */
int output_plan(output *out, const options *o, const char *input, uint32_t frame);
/* The same for a path as it was given; `label` begins messages, such as "--error: ". */
int output_plan_path(output *out, const options *o, const char *label, const char *path);
void output_free(output *out);
/* Before the first picture: would two inputs write one file? */
int output_check_all(const options *o);
/* Can these AOVs go there? Only .exr has them in the picture's file. */
int output_check_aovs(const output *out, const char *list);
/* Do the film's AOVs lie beside `path`, in files of their own? */
bool output_has_aov_files(const output *out);
/* Where: OUT.NAME.EXT, with a '_' for what a name should not have; freed by the caller, NULL on lack of
 * memory. */
char *output_aov_path(const char *path, const char *name);
/* The picture, and its AOVs. */
int output_write(const output *out, const snell_film *film, const snell_image_desc *desc);
/* Writes OUT.partial.EXT; *path, which the caller frees, names it, NULL when nothing was written.
 */
int output_write_partial(const output *out, const snell_film *film, const snell_image_desc *desc,
                         char **path);

#endif
