/* Smaller copies of an image, each a box-filtered half of the one before. */
#ifndef SNELL_TEXTURES_MIPMAP_H
#define SNELL_TEXTURES_MIPMAP_H

#include "base/error.h"
#include "maths/vec.h"

enum { MIP_LEVELS_MAX = 17 }; /* 65536 pixels down to 1 */

typedef struct mip_level {
    uint32_t width, height;
    const void *pixels; /* as the image's: rows, top first, interleaved */
} mip_level;

typedef struct mipmap {
    mip_level levels[MIP_LEVELS_MAX]; /* [0] is the image itself, borrowed */
    uint32_t count;
    size_t bytes; /* of the levels beyond [0] */
    void *memory;
} mipmap;

/* How pixels are stored. Levels are stored the same way. */
typedef struct mip_format {
    uint32_t channels; /* 1, 3 or 4; the fourth is alpha */
    bool floats;       /* otherwise bytes */
    bool srgb;         /* of byte colours */
} mip_format;

/* Every level has floor(half) the pixels of the one before each way, 1 at least; a pixel is the mean
 * of the area that it covers, in linear light; colour and alpha each by themselves. Bytes are
 * rounded to the nearest, in linear light, at every level. The levels take a third of the image's
 * memory. */
snell_status mipmap_create(const void *pixels, uint32_t width, uint32_t height, mip_format format,
                           mipmap **out);
void mipmap_destroy(mipmap *m);

#endif
