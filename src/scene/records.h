/* A description as one flat, self-contained block of bytes: what snell-import sends and (later) a
 * compiled scene is.
 *
 * Layout (little endian, 8-byte aligned): a header {magic "SNELLREC", version, count, total size,
 * hash of the types' tables}, then records {kind, type name hash, size, ...}. There are no
 * pointers: strings and arrays are offsets into the block. Both sides are the same build; the hash
 * of the tables proves it. */
#ifndef SNELL_SCENE_RECORDS_H
#define SNELL_SCENE_RECORDS_H

#include "scene/description.h"

/* Where bytes go: returns false when it cannot take them. */
typedef bool record_write_fn(void *user, const void *data, size_t size);
snell_status records_write(const description *d, record_write_fn *write, void *user);

/* Adds everything in the block to `d`, checking every count, offset, index and number again: a
 * hostile block gives SNELL_ERR_SYNTAX and leaves `d` as it was, never undefined behaviour. The
 * block may change no more while this runs. */
snell_status records_read(const void *data, size_t size, description *d);

#endif
