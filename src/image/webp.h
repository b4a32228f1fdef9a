/* What pictures and animations in WebP share. */
#ifndef SNELL_IMAGE_WEBP_H
#define SNELL_IMAGE_WEBP_H

#include "image/codec.h"

enum webp_flags { WEBP_ANIMATION = 2, WEBP_XMP = 4, WEBP_ALPHA = 16 }; /* of VP8X */

void webp_put(uint8_t *to, uint32_t value, int bytes);
/* Each appends; false: no memory. */
bool webp_chunk(image_buffer *out, const char *name, const void *data, size_t size);
bool webp_extended(image_buffer *out, const image_pixels *pixels, unsigned flags);
bool webp_tag(image_buffer *out, const char *tag);
/* The picture's chunks: VP8L, or VP8 with ALPH before it. */
snell_status webp_frame(const image_pixels *pixels, const image_options *options,
                        image_buffer *out);

#endif
