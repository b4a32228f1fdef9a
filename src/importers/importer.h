/* One importer per file format family: it reads a file and fills a description. Importers run only
 * in the sandboxed program snell-import (apps/import), never in the host's process. */
#ifndef SNELL_IMPORTERS_IMPORTER_H
#define SNELL_IMPORTERS_IMPORTER_H

#include "image/film.h"
#include "scene/description.h"

typedef struct import_options {
    const char *const *params; /* "name=value" */
    size_t param_count;
    const char *const *asset_dirs; /* may be read besides the file's own folder */
    size_t asset_dir_count;
    const char *up;      /* "x" .. "-z", or NULL: as the format says */
    const char *format;  /* set by import_file: the format that was asked for; NULL: by content */
    const char *layer;   /* of a picture, "" its colours: no scene is read; NULL: a scene */
    bool allow_programs; /* run Lua */
    bool next_frame;     /* what is a function of time is also asked about the next frame */
    uint32_t frame;      /* of an animation; 0: its first; of a model file: at rest */
    /* Set by a scene program that reads a model: the model is a part of it, which has a clock of its
     * own and takes no params. fps 0: 24; animation: name, number or "all"; NULL: the first. */
    bool within;
    bool flat; /* normals that the file leaves out are not made: its faces stay flat */
    double fps;
    const char *animation;
    uint64_t memory_max; /* bytes; 0: in the helper's parent a share of the machine's memory */
    /* How much of the file is read, 0..1; importers may call it as often as they like; may be NULL.
     * Set in the helper only. */
    void (*progress)(void *user, double fraction);
    void *progress_user;
} import_options;

typedef struct importer {
    const char *name;       /* "gltf" */
    const char *extensions; /* ".gltf .glb" */
    const char *help;       /* "glTF 2.0" */
    /* Does the content look like this format? first: the file's first bytes (at most 4096). */
    bool (*recognise)(const char *extension, const uint8_t *first, size_t size);
    /* Fills d. Errors by error_set_at with the file as it was typed, line and column where known.
     */
    snell_status (*read)(const char *path, const import_options *options, description *d);
} importer;

extern const importer
    *const importers[]; /* NULL at the end; the first that recognises the file reads it */

/* Chooses by format name (may be NULL), extension and content, and reads. */
snell_status import_file(const char *path, const char *format, const import_options *options,
                         description *d);

/* ---- the parent's side: starts snell-import, waits, checks its records (helper.c) ---- */
typedef struct helper_options {
    import_options import;
    const char *format;
    double time_max; /* CPU seconds, rounded up; 0: 300 */
    /* Called at least every 100 ms with 0 <= fraction <= 1; false: kill the helper,
     * SNELL_CANCELLED; may be NULL. */
    bool (*progress)(void *user, double fraction);
    void *user;
} helper_options;
/* Starts snell-import on the file, waits for its end, and adds what it found to d; on failure d is
 * as it was. Warnings of the importer are among d's messages. */
snell_status helper_import(const char *path, const helper_options *options, description *d);

/* Does the file begin as a compiled scene (scene/compiled.h)? Such a file needs no helper
 * (helper_compiled.c). */
bool compiled_is_file(const char *path);
/* As an importer's read, in this process. What was decided when the file was written (params, up, another
 * frame) gives SNELL_ERR_ARGUMENT. */
snell_status compiled_import(const char *path, const import_options *options, description *d);

typedef struct helper_picture {
    film film;
    char *layers; /* names, each with its 0; an empty one at the end; NULL: none; free */
    bool damaged; /* a JPEG, part of which is grey */
} helper_picture;
/* Starts snell-import on a picture, of which options->import.layer says what is wanted; on success
 * *out, which need not be empty, is replaced (helper_picture.c). */
snell_status helper_read_picture(const char *path, const helper_options *options,
                                 helper_picture *out);
/* Any other result: `take` gets the sealed block when snell-import is done. */
typedef snell_status helper_take(void *user, const void *data, size_t size);
snell_status helper_run(const char *path, const helper_options *options, helper_take *take,
                        void *user);

#endif
