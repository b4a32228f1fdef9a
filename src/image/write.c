#include "image/write.h"

#include <stdlib.h>

#include "base/file.h"

snell_status image_write(const char *path, const image_pixels *pixels,
                         const image_options *options) {
    const image_codec *codec;
    void *data;
    size_t size;
    snell_status status = image_codec_for_path(path, &codec);
    if (!status) status = image_encode(codec, pixels, options, &data, &size);
    if (status) return status;
    status = file_write_atomic(path, data, size);
    free(data);
    return status;
}
