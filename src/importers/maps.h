/* Pictures that model files name, as textures. */
#ifndef SNELL_IMPORTERS_MAPS_H
#define SNELL_IMPORTERS_MAPS_H

#include "importers/files.h"
#include "importers/image_decode.h"

typedef enum map_use {
    MAP_COLOR,  /* sRGB */
    MAP_LINEAR, /* numbers, normals */
    MAP_ALPHA   /* the picture's alpha channel alone */
} map_use;

/* How a picture lies on a surface. */
typedef struct map_look {
    map_use use;
    const char *wrap[2];      /* "repeat", "clamp", "mirror"; NULL: repeat */
    const char *channel;      /* "r", "g", "b"; NULL: the colour */
    snell_vec2 offset, scale; /* a scale of 0: 1 */
} map_look;

/* The picture that the file `base` names, in the folders that may be read: as it is named, with either slash, or by
 * its file name alone, since the path may be one of the author's machine. */
snell_status map_load(const char *base, const char *name, const import_options *options,
                      decoded_image *out);
snell_status map_add(description *d, const char *file, const decoded_image *image,
                     const map_look *look, snell_texture_id *out);

#endif
