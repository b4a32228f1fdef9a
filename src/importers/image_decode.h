/* PNG, JPEG and WebP from memory to pixels. Runs only in the sandboxed helper: the bytes are whatever a
 * file says. */
#ifndef SNELL_IMPORTERS_IMAGE_DECODE_H
#define SNELL_IMPORTERS_IMAGE_DECODE_H

#include "scene/description.h"

typedef struct decoded_image {
    uint32_t width, height;
    uint32_t channels; /* 1 grey, 3 RGB, 4 RGBA; 8 bits each */
    uint8_t *pixels;   /* rows, top first, interleaved; free with image_free */
    bool floats;       /* channels is 4 and pixels are linear floats (image_float.h) */
    bool opaque;       /* of floats: alpha is all 1, the file has none */
    bool wide;         /* 16 bits a channel, the high byte first (image_decode_wide) */
    bool damaged;      /* a JPEG that ends early or is odd: part of it is grey */
} decoded_image;

/* Recognises the format by the content. At most size_max bytes of pixels. Errors: SNELL_ERR_SYNTAX
 * (a broken image), SNELL_ERR_UNSUPPORTED (another format, or one that is not built in),
 * SNELL_ERR_MEMORY; without a place, which the caller adds. */
snell_status image_decode(const void *data, size_t size, size_t size_max, decoded_image *out);
/* The same, but PNG files of 16 bits are not rounded to 8. */
snell_status image_decode_wide(const void *data, size_t size, size_t size_max, decoded_image *out);
void image_free(decoded_image *image);
/* "image/png", "image/jpeg" or "image/webp" by how the bytes begin; NULL: another. */
const char *image_media_type(const void *data, size_t size);

/* For the formats: checks the size that a file claims, with channels and `wide`, and makes room. */
snell_status image_make_room(decoded_image *image, size_t size_max);

/* Bytes of pixels that one image may have when nobody says less. */
#define IMAGE_SIZE_MAX ((size_t)1 << 30)

/* The words of the texture "image" for its field `format`. */
const char *image_format_word(const decoded_image *image);
/* Splits off: a copy without alpha (3 channels, or 1 as it is), or the alpha alone (1 channel, all
 * 255 where there is none). */
snell_status image_copy_color(const decoded_image *image, decoded_image *out);
snell_status image_copy_alpha(const decoded_image *image, decoded_image *out);
/* One channel, 0 red to 2 blue; grey where it is all there is. */
snell_status image_copy_channel(const decoded_image *image, uint32_t channel, decoded_image *out);
bool image_has_alpha(const decoded_image *image); /* is any pixel less than opaque? */

#endif
