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

/* Reads the first bytes of a regular file, at most size_max; *data is freed by the caller. */
snell_status file_read_start(const char *path, size_t size_max, void **data, size_t *size);

#endif
