/* A compiled scene, what `snell convert SCENE OUT.snell` writes: a header and the records of the whole
 * description (records.h), so that reading it runs no program and decodes no text or image.
 *
 *     offset  bytes
 *          0      8  89 53 4e 4c 0d 0a 1a 0a: no text, and no longer so after a transfer as text
 *          8      4  0x01020304 in the byte order of all that follows
 *         12      4  the version of this header, 1
 *         16      8  the bytes of the records
 *         24      8  their checksum
 *         32     32  the version of snell that wrote it; text, as the next
 *         64     64  the last name of the file that the description came from; "": not known
 *        128         the records
 *
 * The records are of one build's types: another version refuses the file and says what to do. */
#ifndef SNELL_SCENE_COMPILED_H
#define SNELL_SCENE_COMPILED_H

#include "scene/description.h"

enum { COMPILED_HEADER_SIZE = 128 };

/* Atomic (base/file.h). Parameters of a scene program are left out: they have their values. All types are
 * registered. */
snell_status compiled_write(const description *d, const char *path);

/* Does the file begin as one? */
bool compiled_recognise(const void *first, size_t size);

/* Adds what the file holds to `d`, checking everything (records_read); on failure d is as it was. `data`
 * is the whole file, aligned to 8 bytes; path is for messages.
 *   SNELL_ERR_UNSUPPORTED  made by another version, or on a machine of another kind
 *   SNELL_ERR_SYNTAX   cut short, damaged, or not one at all */
snell_status compiled_read(const char *path, const void *data, size_t size, description *d);

#endif
