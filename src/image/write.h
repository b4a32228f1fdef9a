/* A picture to a file: encoded in memory, then written atomically. */
#ifndef SNELL_IMAGE_WRITE_H
#define SNELL_IMAGE_WRITE_H

#include "image/codec.h"

/* The format by the path's extension. The file is the old one or the complete new one. */
snell_status image_write(const char *path, const image_pixels *pixels,
                         const image_options *options);

#endif
