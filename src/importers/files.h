/* The files that an importer reads. Besides the scene file itself only files in its folder (or
 * below) and in the folders that the user allowed are read. The sandbox enforces that; these
 * functions hold to it too, so that it is true where the kernel has no Landlock, and say it in a
 * way that users understand. */
#ifndef SNELL_IMPORTERS_FILES_H
#define SNELL_IMPORTERS_FILES_H

#include <string.h>

#include "importers/importer.h"

/* The path, owned by the caller (free), of the file that `base_file` calls `name`: name as it is
 * when absolute, else in base_file's folder, else in the first asset folder that has it. Errors
 * have a text and hint, and no place:
 *   SNELL_ERR_IO  "cannot open 'tex.png': No such file or directory", or "...: Permission denied"
 *                 when it lies outside every folder that may be read. */
snell_status import_resolve(const char *base_file, const char *name, const import_options *options,
                            char **path);

/* The whole regular file, owned by the caller (free), with a 0 byte after the last, which *size
 * does not count. `name`, for messages; NULL: path. A file larger than half of options->memory_max
 * (0: no limit but 4 GiB) gives SNELL_ERR_MEMORY. */
snell_status import_read_file(const char *path, const char *name, const import_options *options,
                              uint8_t **data, size_t *size);

/* The same without a copy where the file's size allows (the rest of its last page is zeros): mapped, of
 * which only what is looked at is read. For the sandbox alone: a file that another program cuts short
 * meanwhile ends the process by a signal. Freed by import_unmap_file. */
snell_status import_map_file(const char *path, const import_options *options, const char **data,
                             size_t *size);
void import_unmap_file(const char *data, size_t size);
/* Bytes of the mark that some editors begin UTF-8 with: 3, or 0. */
static inline size_t import_mark_size(const void *data, size_t size) {
    return size >= 3 && memcmp(data, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
}
/* What lies before `upto` is looked at no more, or seldom: it need not stay in memory. */
void import_forget(const char *data, size_t size, const char *upto);

/* import_resolve and import_read_file. */
snell_status import_read_beside(const char *base_file, const char *name,
                                const import_options *options, uint8_t **data, size_t *size);

/* The extension in lower case with its dot, ".gltf"; "" when there is none or it is longer than
 * out. */
void import_extension(const char *path, char *out, size_t size);

#endif
