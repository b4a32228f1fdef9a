/* Pictures of floats from memory to pixels: Radiance HDR, OpenEXR, PFM. Runs only in the sandboxed
 * helper, like image_decode.h. */
#ifndef SNELL_IMPORTERS_IMAGE_FLOAT_H
#define SNELL_IMPORTERS_IMAGE_FLOAT_H

#include "importers/image_decode.h"

/* Does the content begin as one of them does? */
bool image_is_float(const void *data, size_t size);
/* Linear red, green, blue, alpha; negative values, which filters leave behind, become 0. Errors as
 * image_decode. */
snell_status image_decode_float(const void *data, size_t size, size_t size_max, decoded_image *out);

/* Names, each with its 0, one after the other. */
typedef struct image_names {
    char *text; /* free */
    size_t size;
} image_names;
/* The same, but the values are the file's own, and of OpenEXR a layer or a channel by its full name
 * ("": the colours; others have no layers). *layers, if not NULL, gets the names of all, on
 * success. */
snell_status image_decode_layer(const void *data, size_t size, size_t size_max, const char *layer,
                                image_names *layers, decoded_image *out);

/* For the formats: checks a size that a file claims and makes room for RGBA floats. */
snell_status image_make_float_room(decoded_image *image, size_t size_max);
/* image_exr.c; the build may lack it. */
snell_status image_decode_exr(const void *data, size_t size, size_t size_max, const char *layer,
                              image_names *layers, decoded_image *out);

#endif
