/* A description as one flat, self-contained block of bytes: what snell-import sends and a compiled
 * scene (scene/compiled.h) holds.
 *
 * Layout: a header {magic "SNELLREC", version, count of records, size of the block, hash of the
 * types' tables, format, flags}, then records {kind, 0, size}, each a multiple of 8 bytes long. In a
 * record everything follows in the order of the type's table; strings and arrays stand in place
 * behind their lengths, padded to 8 bytes. There are no pointers and no offsets. Numbers are the
 * machine's own: both sides are the same build on the same machine, which magic and hash prove.
 */
#ifndef SNELL_SCENE_RECORDS_H
#define SNELL_SCENE_RECORDS_H

#include "scene/description.h"

/* Where bytes go: returns false when it cannot take them. */
typedef bool record_write_fn(void *user, const void *data, size_t size);
snell_status records_write(const description *d, record_write_fn *write, void *user);

/* Of all that decides a picture: types, fields, places; not of names, files and lines.
 * SNELL_ERR_UNSUPPORTED: a shape by functions of the caller. */
snell_status records_hash(const description *d, uint64_t *out);

/* Did this build write the block? Says nothing else of it. */
bool records_fit(const void *data, size_t size);

/* Adds everything in the block to `d`, checking every count, index and number again: a hostile
 * block gives SNELL_ERR_SYNTAX and leaves `d` as it was, never undefined behaviour. `data` is
 * aligned to 8 bytes, and may change no more while this runs. Arrays are copied once, from the
 * block into `d`. Where `d` already has a name, the new object gets ".2"; settings that `d` already
 * has are kept and the block's left out. */
snell_status records_read(const void *data, size_t size, description *d);

#endif
