/* PNG of bytes as they are. */
#ifndef SNELL_IMAGE_PNG_H
#define SNELL_IMAGE_PNG_H

#include "image/codec.h"

/* Rows, top first, of 1 (grey), 3 or 4 (straight alpha) bytes a pixel: reading gives them back. */
snell_status png_encode_bytes(const void *pixels, uint32_t width, uint32_t height,
                              uint32_t channels, image_buffer *out);

#endif
