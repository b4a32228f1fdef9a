/* YUV4MPEG2, frames that are not compressed, for a program that does it: Y'CbCr of BT.709 (ITU-R
 * BT.709-6, 8 bits, limited range) from the sRGB values, 4:2:0 with each chroma sample in the middle of
 * its four pixels (C420jpeg). At an odd edge the last row or column counts twice. A transparent
 * picture is laid over black. */
#include <stdio.h>
#include <stdlib.h>

#include "base/memory.h"
#include "image/movie.h"

extern const image_codec image_codec_ppm;

static snell_status begin(movie_state *m, image_buffer *out) {
    char head[160];
    int length = snprintf(head, sizeof head,
                          "YUV4MPEG2 W%u H%u F%u:%u Ip A1:1 C420jpeg "
                          "XYSCSS=420JPEG XCOLORRANGE=LIMITED\n",
                          m->width, m->height, m->numerator, m->denominator);
    return image_buffer_add(out, head, (size_t)length) ? SNELL_OK : error_no_memory();
}

static uint8_t rounded(double value) { return (uint8_t)(value + 0.5); }

static double luma_of(const uint8_t *rgb) {
    return (0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]) / 255;
}

static void put_luma(const uint8_t *rgb, uint32_t width, uint8_t *to) {
    for (uint32_t x = 0; x < width; x++) to[x] = rounded(16 + 219 * luma_of(rgb + (size_t)3 * x));
}

/* The chroma of two rows of pixels, which may be the same. */
static void put_chroma(const uint8_t *const rows[2], uint32_t width, uint8_t *blue, uint8_t *red) {
    for (uint32_t x = 0; x < width; x += 2) {
        double cb = 0, cr = 0;
        for (int i = 0; i < 4; i++) {
            uint32_t column = i % 2 && x + 1 < width ? x + 1 : x;
            const uint8_t *p = rows[i / 2] + (size_t)3 * column;
            double luma = luma_of(p);
            cb += (p[2] / 255.0 - luma) / 1.8556 / 4;
            cr += (p[0] / 255.0 - luma) / 1.5748 / 4;
        }
        blue[x / 2] = rounded(128 + 224 * cb);
        red[x / 2] = rounded(128 + 224 * cr);
    }
}

static snell_status add(movie_state *m, const image_pixels *pixels, image_buffer *out) {
    size_t width = m->width, height = m->height, half_width = (width + 1) / 2,
           half_height = (height + 1) / 2, chroma = half_width * half_height;
    uint8_t *planes = memory_resize(NULL, width * height + 2 * chroma, 1),
            *rgb = memory_resize(NULL, 6, width);
    bool done = planes && rgb;
    for (uint32_t y = 0; done && y < height; y += 2) {
        const uint8_t *rows[2] = {rgb, y + 1 < height ? rgb + 3 * width : rgb};
        uint8_t *blue = planes + width * height + y / 2 * half_width;
        for (uint32_t i = 0; i < 2 && y + i < height; i++) {
            image_row_8bit(pixels, &m->options, y + i, 3, rgb + i * 3 * width);
            put_luma(rows[i], m->width, planes + (y + i) * width);
        }
        put_chroma(rows, m->width, blue, blue + chroma);
    }
    done = done && image_buffer_add(out, "FRAME\n", 6) &&
           image_buffer_add(out, planes, width * height + 2 * chroma);
    free(planes);
    free(rgb);
    return done ? SNELL_OK : error_no_memory();
}

static snell_status end(movie_state *m, image_buffer *out, movie_patch *patches, int *count) {
    (void)m;
    (void)out;
    (void)patches;
    *count = 0;
    return SNELL_OK;
}

extern const movie_format movie_format_y4m;
const movie_format movie_format_y4m = {
    .name = "y4m",
    .extension = ".y4m",
    .help = "frames for a video encoder (YUV4MPEG2, BT.709, 4:2:0); without alpha",
    .codec = &image_codec_ppm,
    .streams = true,
    .begin = begin,
    .add = add,
    .end = end,
};
