/* Files: what is written is the old file or the complete new one; what is read is bounded. */
#ifndef SNELL_BASE_FILE_H
#define SNELL_BASE_FILE_H

#include "base/error.h"

/* Writes `size` bytes so that `path` holds the old content or all of the new, never a part: a
 * temporary file in the same folder, fsync, rename, fsync of the folder. A symbolic link is
 * followed: the file it points to is replaced, the link stays. The old file's permissions are kept;
 * a file that may not be written is not replaced. What is no regular file (a device, a pipe) is
 * written to directly. On failure (SNELL_ERR_IO, with the place) the temporary is removed and the
 * old file is untouched. */
snell_status file_write_atomic(const char *path, const void *data, size_t size);

/* The same in parts, for what is too large to be held: a file that nobody sees until it is finished.
 * What is no regular file is written to as the parts come, and cannot be patched. Every writer ends
 * by finish or abandon. */
typedef struct file_writer file_writer;
snell_status file_begin(const char *path, file_writer **out);
snell_status file_append(file_writer *w, const void *data, size_t size);
/* Writes over what was appended before. */
snell_status file_patch(file_writer *w, uint64_t offset, const void *data, size_t size);
/* path: another name in the same folder; NULL: the one it was begun with. Frees the writer, also on
 * failure, when there is no new file. */
snell_status file_finish(file_writer *w, const char *path);
void file_abandon(file_writer *w); /* NULL does nothing */

/* Reads the first bytes of a regular file, at most size_max; *data is freed by the caller. */
snell_status file_read_start(const char *path, size_t size_max, void **data, size_t *size);

#endif
