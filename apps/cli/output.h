/* Where a picture goes, and whether it may. */
#ifndef SNELL_CLI_OUTPUT_H
#define SNELL_CLI_OUTPUT_H

#include <snell/snell.h>

#include "options.h"
#include "values.h"

typedef struct output {
    char *path;        /* owned; "-" for standard output */
    const char *given; /* what -o said; NULL: the default rule */
    snell_picture_format_info format;
    bool force;
} output;

/* What a picture is of. */
typedef struct output_subject {
    const char *input;
    bool whole;         /* {name} keeps the extension */
    uint32_t frame;     /* 0, or the number that goes into the name */
    const char *camera; /* "", or the name that does: {camera}, else before the extension */
} output_subject;

/* Names the picture, and checks before any work that it can be written. Exit code. */
int output_plan(output *out, const options *o, const output_subject *subject);
/* The same for a path as it was given; `label` begins messages, such as "--error: ". */
int output_plan_path(output *out, const options *o, const char *label, const char *path);
void output_free(output *out);
/* Can a file of this name be written there? Exit code. */
int output_check_folder(const char *path);
/* Before the first picture: would two inputs write one file? whole: of each input, as above. */
int output_check_all(const options *o, const render_values *v, const bool *whole);
/* Do all frames of an input go into one file? */
bool output_is_movie(const options *o, bool many_frames);
/* A format by its name or extension, without a dot. */
bool output_find_format(const char *word, snell_picture_format_info *out);
/* The extension without its dot; "" for none. */
const char *output_extension(const char *path);
/* The last name of the path without its extension. */
void output_input_name(const char *input, const char **name, size_t *length);
/* OUT.partial.EXT; freed by the caller; NULL on lack of memory. */
char *output_partial_path(const output *out);
bool output_is_standard(const output *out);
/* Without -o, a file that snell did not make stays: exit code. */
int output_check_owner(const output *out, const char *path);
/* Has a picture of this description room there? */
int output_check_size(const output *out, const snell_render_desc *desc);
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
