#include "textures/mipmap.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/srgb.h"

/* ---- the nearest sRGB byte of a linear value ---- */

enum { STARTS = 4096 };
static uint8_t starts[STARTS + 1]; /* the byte of i / STARTS */
static double halfway[256];        /* between a byte's value and the next one's */
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void fill_tables(void) {
    const float *decoded = srgb_table();
    for (int i = 0; i < 255; i++) halfway[i] = ((double)decoded[i] + (double)decoded[i + 1]) / 2;
    halfway[255] = INFINITY;
    uint8_t byte = 0;
    for (int i = 0; i <= STARTS; i++) {
        while ((double)i / STARTS > halfway[byte]) byte++;
        starts[i] = byte;
    }
}

static uint8_t srgb_byte(double linear) {
    uint8_t byte = starts[(int)(linear * STARTS)];
    while (linear > halfway[byte]) byte++;
    return byte;
}

static uint8_t plain_byte(double value) { return (uint8_t)(value * 255 + 0.5); }

/* ---- one level from the one before ---- */

/* The source pixels that one pixel of a smaller row (or column) covers, at most 4 of them. */
typedef struct cover {
    uint32_t first, count;
    double weight[4];
} cover;

/* In units of 1/to of a source pixel: pixel x covers x * from .. (x + 1) * from, source pixel i
 * covers i * to .. (i + 1) * to. */
static void fill_covers(uint32_t from, uint32_t to, cover *covers) {
    for (uint32_t x = 0; x < to; x++) {
        uint64_t low = (uint64_t)x * from, high = low + from, i = low / to;
        covers[x] = (cover){.first = (uint32_t)i};
        for (; i * to < high; i++) {
            uint64_t begin = i * to < low ? low : i * to,
                     end = (i + 1) * to > high ? high : (i + 1) * to;
            covers[x].weight[covers[x].count++] = (double)(end - begin) / from;
        }
    }
}

typedef struct reduction {
    const mip_level *from;
    mip_format format;
    const float *decode[4]; /* of each channel's bytes */
    const cover *columns;
} reduction;

static void mean(const reduction *r, const cover *column, const cover *row, double out[4]) {
    uint32_t channels = r->format.channels;
    for (uint32_t c = 0; c < channels; c++) out[c] = 0;
    for (uint32_t j = 0; j < row->count; j++) {
        size_t at = (size_t)(row->first + j) * r->from->width + column->first;
        for (uint32_t i = 0; i < column->count; i++) {
            double weight = row->weight[j] * column->weight[i];
            size_t first = (at + i) * channels;
            if (r->format.floats) {
                float value[4];
                memcpy(value, (const float *)r->from->pixels + first, channels * sizeof *value);
                for (uint32_t c = 0; c < channels; c++) out[c] += weight * (double)value[c];
            } else {
                const uint8_t *p = (const uint8_t *)r->from->pixels + first;
                for (uint32_t c = 0; c < channels; c++)
                    out[c] += weight * (double)r->decode[c][p[c]];
            }
        }
    }
}

/* The same for bytes, where both sizes are just halved: the same sums in another order of scaling by
 * powers of two. */
static void mean_of_four(const reduction *r, uint32_t x, uint32_t y, double out[4]) {
    uint32_t channels = r->format.channels;
    size_t row = (size_t)r->from->width * channels;
    const uint8_t *p = (const uint8_t *)r->from->pixels + y * row + (size_t)x * channels;
    for (uint32_t c = 0; c < channels; c++, p++) {
        const float *decode = r->decode[c];
        double sum = (double)decode[p[0]] + (double)decode[p[channels]];
        sum += (double)decode[p[row]];
        out[c] = (sum + (double)decode[p[row + channels]]) / 4;
    }
}

static void reduce_row(const reduction *r, const cover *row, uint32_t width, void *to) {
    bool halved = !r->format.floats && width * 2 == r->from->width && row->count == 2;
    for (uint32_t x = 0; x < width; x++) {
        double value[4];
        if (halved)
            mean_of_four(r, 2 * x, row->first, value);
        else
            mean(r, &r->columns[x], row, value);
        for (uint32_t c = 0; c < r->format.channels; c++) {
            size_t at = (size_t)x * r->format.channels + c;
            bool coded = r->format.srgb && c < 3;
            if (r->format.floats)
                ((float *)to)[at] = (float)value[c];
            else
                ((uint8_t *)to)[at] =
                    coded ? srgb_byte(clamp01(value[c])) : plain_byte(clamp01(value[c]));
        }
    }
}

static uint32_t half(uint32_t size) { return size > 1 ? size / 2 : 1; }

static size_t pixel_size(mip_format format) {
    return format.channels * (format.floats ? sizeof(float) : 1);
}

static void fill_level(const mip_level *from, mip_format format, mip_level *to, void *pixels,
                       cover *columns, cover *rows) {
    const float *colors = format.srgb ? srgb_table() : unorm_table();
    reduction r = {from, format, {colors, colors, colors, unorm_table()}, columns};
    fill_covers(from->width, to->width, columns);
    fill_covers(from->height, to->height, rows);
    size_t row_size = to->width * pixel_size(format);
    for (uint32_t y = 0; y < to->height; y++)
        reduce_row(&r, &rows[y], to->width, (char *)pixels + y * row_size);
}

snell_status mipmap_create(const void *pixels, uint32_t width, uint32_t height, mip_format format,
                           mipmap **out) {
    pthread_once(&once, fill_tables);
    mipmap *m = memory_zeroed(1, sizeof *m);
    if (m == NULL) return error_no_memory();
    m->levels[m->count++] = (mip_level){width, height, pixels};
    for (uint32_t w = width, h = height; w > 1 || h > 1;) {
        w = half(w), h = half(h);
        m->levels[m->count++] = (mip_level){w, h, NULL};
        m->bytes += (size_t)w * h * pixel_size(format);
    }
    cover *columns = memory_resize(NULL, half(width), sizeof *columns),
          *rows = memory_resize(NULL, half(height), sizeof *rows);
    m->memory = memory_resize(NULL, m->bytes ? m->bytes : 1, 1);
    bool made = columns && rows && m->memory;
    char *at = m->memory;
    for (uint32_t i = 1; made && i < m->count; i++) {
        mip_level *level = &m->levels[i];
        fill_level(&m->levels[i - 1], format, level, at, columns, rows);
        level->pixels = at;
        at += (size_t)level->width * level->height * pixel_size(format);
    }
    free(columns);
    free(rows);
    if (!made) {
        mipmap_destroy(m);
        return error_no_memory();
    }
    *out = m;
    return SNELL_OK;
}

void mipmap_destroy(mipmap *m) {
    if (m) free(m->memory);
    free(m);
}
