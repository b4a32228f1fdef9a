/* PFM: 32-bit linear floats, RGB, little endian, rows bottom first. No alpha (the colours are those
 * over black) and no tag. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/codec.h"
#include "image/pnm.h"

static void put_float(uint8_t *to, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 4; i++) to[i] = (uint8_t)(bits >> 8 * i);
}

static snell_status encode(const image_pixels *pixels, const image_options *options,
                           image_buffer *out) {
    (void)options; /* linear: neither exposure nor tone map */
    char head[64];
    int length = snprintf(head, sizeof head, "PF\n%u %u\n-1.0\n", pixels->width, pixels->height);
    uint8_t *row = memory_resize(NULL, pixels->width, 12);
    bool done = row && image_buffer_add(out, head, (size_t)length);
    for (uint32_t y = pixels->height; done && y-- > 0;) {
        const float *from = pixels->data + (size_t)y * pixels->width * pixels->channels;
        for (size_t x = 0; x < pixels->width; x++)
            for (size_t c = 0; c < 3; c++)
                put_float(row + 12 * x + 4 * c, from[x * pixels->channels + c]);
        done = image_buffer_add(out, row, (size_t)pixels->width * 12);
    }
    free(row);
    return done ? SNELL_OK : error_no_memory();
}

/* The scale, such as "-1.0", whose sign says the byte order: a word that ends before the data. */
static bool has_scale(const uint8_t *data, size_t size, size_t at) {
    if (!pnm_skip_space(data, size, &at, NULL, NULL)) return false;
    size_t start = at;
    while (at < size && data[at] != 0 && strchr("+-.0123456789eE", data[at])) at++;
    return at > start && at < size && data[at] <= ' ';
}

static bool read_info(const uint8_t *data, size_t size, image_info *out, snell_status *status) {
    if (size < 3 || data[0] != 'P' || (data[1] != 'F' && data[1] != 'f') ||
        !(data[2] == 0x20 || (data[2] >= 9 && data[2] <= 13)))
        return false;
    out->channels = data[1] == 'F' ? 3 : 1;
    out->bits = 32;
    size_t at = 2;
    if (!pnm_read_number(data, size, &at, &out->width) ||
        !pnm_read_number(data, size, &at, &out->height) || !has_scale(data, size, at))
        *status = error_set(SNELL_ERR_SYNTAX, NULL, "the PFM file's head is broken");
    return true;
}

extern const image_codec image_codec_pfm;
const image_codec image_codec_pfm = {
    .name = "pfm",
    .extension = ".pfm",
    .help = "32-bit floats, linear",
    .linear = true,
    .bits = 32,
    .encode = encode,
    .read_info = read_info,
};
