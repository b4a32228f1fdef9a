/* A picture on its way from snell-import, where it is decoded, to a film: one block in shared
 * memory.
 *
 *     picture_import, picture_write ──▶ {header, names of layers, padding, floats} ──▶ picture_take
 * / */
#ifndef SNELL_IMPORTERS_PICTURE_H
#define SNELL_IMPORTERS_PICTURE_H

#include "importers/image_float.h"
#include "importers/importer.h"
#include "scene/records.h"

#define PICTURE_MAGIC "SNELLPIC"
typedef struct picture_header {
    char magic[8];
    uint32_t width, height, channels; /* channels 3 or 4 */
    uint32_t encoded_bits;            /* as film.encoded_bits */
    uint32_t damaged, zero;
    uint64_t
        names_size; /* of the layers, each with its 0; then padding to 8 bytes, then the pixels */
} picture_header;
_Static_assert(sizeof(picture_header) == 40, "no padding");

typedef struct picture {
    picture_header header;
    image_names layers;
    float *pixels; /* as film.pixels */
} picture;

/* In the helper only: reads and decodes a file; options->layer says what of it. */
snell_status picture_import(const char *path, const import_options *options, picture *out);
snell_status picture_write(const picture *p, record_write_fn *write, void *user);
void picture_free(picture *p);

/* The parent's side, a helper_take: checks everything again. user is a helper_picture, which stays
 * as it was when the block is refused (SNELL_ERR_SYNTAX). */
snell_status picture_take(void *user, const void *data, size_t size);

#endif
