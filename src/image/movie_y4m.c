/* YUV4MPEG2, frames that are not compressed, for a program that does it: Y'CbCr of BT.709 (ITU-R
 * BT.709-6, 8 bits, limited range) from the sRGB values, 4:2:0 with each chroma sample in the middle of
 * its four pixels (C420jpeg), or 4:4:4. At an odd edge the last row or column counts twice. A transparent
 * picture is laid over black. */
#include <stdio.h>
#include <stdlib.h>

#include "base/memory.h"
#include "image/movie.h"

extern const image_codec image_codec_ppm;

static snell_status begin(movie_state *m, image_buffer *out) {
    char head[160];
    bool whole = m->options.chroma == 444;
    int length = snprintf(head, sizeof head,
                          "YUV4MPEG2 W%u H%u F%u:%u Ip A1:1 C%s XYSCSS=%s XCOLORRANGE=LIMITED\n",
                          m->width, m->height, m->numerator, m->denominator,
                          whole ? "444" : "420jpeg", whole ? "444" : "420JPEG");
    return image_buffer_add(out, head, (size_t)length) ? SNELL_OK : error_no_memory();
}

static uint8_t rounded(double value) { return (uint8_t)(value + 0.5); }

static double luma_of(const uint8_t *rgb) {
    return (0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]) / 255;
}

static void put_luma(const uint8_t *rgb, uint32_t width, uint8_t *to) {
    for (uint32_t x = 0; x < width; x++) to[x] = rounded(16 + 219 * luma_of(rgb + (size_t)3 * x));
}

/* The chroma of squares of `side` pixels, 1 or 2, in rows of pixels, which may be the same. */
static void put_chroma(const uint8_t *const rows[2], uint32_t side, uint32_t width, uint8_t *blue,
                       uint8_t *red) {
    const double pixels = side * side;
    for (uint32_t x = 0; x < width; x += side) {
        double cb = 0, cr = 0;
        for (uint32_t i = 0; i < side * side; i++) {
            uint32_t column = i % side && x + 1 < width ? x + 1 : x;
            const uint8_t *p = rows[i / side] + (size_t)3 * column;
            double luma = luma_of(p);
            cb += (p[2] / 255.0 - luma) / 1.8556 / pixels;
            cr += (p[0] / 255.0 - luma) / 1.5748 / pixels;
        }
        blue[x / side] = rounded(128 + 224 * cb);
        red[x / side] = rounded(128 + 224 * cr);
    }
}

static snell_status add(movie_state *m, const image_pixels *pixels, image_buffer *out) {
    const uint32_t side = m->options.chroma == 444 ? 1 : 2;
    size_t width = m->width, height = m->height, row = (width + side - 1) / side,
           chroma = row * ((height + side - 1) / side);
    uint8_t *planes = memory_resize(NULL, width * height + 2 * chroma, 1),
            *rgb = memory_resize(NULL, 6, width);
    bool done = planes && rgb;
    for (uint32_t y = 0; done && y < height; y += side) {
        const uint8_t *rows[2] = {rgb, y + 1 < height ? rgb + 3 * width : rgb};
        uint8_t *blue = planes + width * height + y / side * row;
        for (uint32_t i = 0; i < side && y + i < height; i++) {
            image_row_8bit(pixels, &m->options, y + i, 3, rgb + i * 3 * width);
            put_luma(rows[i], m->width, planes + (y + i) * width);
        }
        put_chroma(rows, side, m->width, blue, blue + chroma);
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
    .help = "frames for a video encoder (YUV4MPEG2, BT.709, 4:2:0 or 4:4:4); without alpha",
    .codec = &image_codec_ppm,
    .streams = true,
    .has_chroma = true,
    .begin = begin,
    .add = add,
    .end = end,
};
