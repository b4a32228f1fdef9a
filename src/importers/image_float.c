/* Radiance HDR: rows of red, green, blue mantissas and a common exponent, run-length coded (Ward,
 * Real Pixels, Graphics Gems II, 1991). PFM: see image/pfm.c. */
#include "importers/image_float.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum { SIDE_MAX = 65536, HEAD_MAX = 1 << 16 };

snell_status image_make_float_room(decoded_image *image, size_t size_max) {
    if (image->width == 0 || image->height == 0 || image->width > SIDE_MAX ||
        image->height > SIDE_MAX)
        return error_set(SNELL_ERR_SYNTAX, "1 to 65536 pixels each way",
                         "an image of %u x %u pixels cannot be read", image->width, image->height);
    size_t size = (size_t)image->width * image->height * 4 * sizeof(float);
    if (size > IMAGE_SIZE_MAX || size > size_max)
        return error_set(size > IMAGE_SIZE_MAX ? SNELL_ERR_UNSUPPORTED : SNELL_ERR_MEMORY,
                         "make the image smaller", "an image of %u x %u pixels is too large",
                         image->width, image->height);
    image->channels = 4;
    image->floats = true;
    image->pixels = memory_zeroed(size, 1);
    return image->pixels ? SNELL_OK : error_no_memory();
}

typedef struct reader {
    const uint8_t *data;
    size_t size, at;
} reader;

static snell_status broken(const char *what) {
    return error_set(SNELL_ERR_SYNTAX, NULL, "a broken image: %s", what);
}

/* The next line of a head, without its end; false: there is none. */
static bool next_line(reader *r, char *line, size_t room) {
    size_t length = 0;
    while (r->at < r->size && r->at < HEAD_MAX && r->data[r->at] != '\n') {
        if (length + 1 < room) line[length++] = (char)r->data[r->at];
        r->at++;
    }
    line[length] = 0;
    return r->at < r->size && r->data[r->at++] == '\n';
}

/* ---- Radiance ---- */

/* One channel of a row: runs (count over 128, then a value) and literals. */
static bool read_runs(reader *r, uint8_t *row, uint32_t width, uint32_t channel) {
    for (uint32_t x = 0; x < width;) {
        if (r->at >= r->size) return false;
        uint32_t count = r->data[r->at++];
        bool run = count > 128;
        if (run) count -= 128;
        if (count == 0 || count > width - x || r->size - r->at < (run ? 1 : count)) return false;
        for (uint32_t i = 0; i < count; i++)
            row[4 * x++ + channel] = r->data[run ? r->at : r->at + i];
        r->at += run ? 1 : count;
    }
    return true;
}

/* Pixels one by one; 1 1 1 n repeats the one before, n * 256^k times for the k-th such in a row. */
static bool read_plain(reader *r, uint8_t *row, uint32_t width) {
    unsigned shift = 0;
    for (uint32_t x = 0; x < width;) {
        if (r->size - r->at < 4) return false;
        const uint8_t *p = r->data + r->at;
        r->at += 4;
        if (p[0] != 1 || p[1] != 1 || p[2] != 1) {
            memcpy(row + 4 * (size_t)x++, p, 4);
            shift = 0;
            continue;
        }
        uint64_t count = (uint64_t)p[3] << shift;
        if (x == 0 || count > width - x) return false;
        for (; count > 0; count--, x++) memcpy(row + 4 * (size_t)x, row + 4 * (size_t)(x - 1), 4);
        shift = shift < 24 ? shift + 8 : shift;
    }
    return true;
}

static bool read_row(reader *r, uint8_t *row, uint32_t width) {
    const uint8_t *p = r->data + r->at;
    bool coded = width >= 8 && width < 32768 && r->size - r->at >= 4 && p[0] == 2 && p[1] == 2 &&
                 ((uint32_t)p[2] << 8 | p[3]) == width;
    if (!coded) return read_plain(r, row, width);
    r->at += 4;
    for (uint32_t c = 0; c < 4; c++)
        if (!read_runs(r, row, width, c)) return false;
    return true;
}

static snell_status decode_radiance(reader *r, size_t size_max, decoded_image *image) {
    char line[128];
    do {
        if (!next_line(r, line, sizeof line)) return broken("the head has no end");
        if (strncmp(line, "FORMAT=", 7) == 0 && strcmp(line, "FORMAT=32-bit_rle_rgbe") != 0)
            return error_set(SNELL_ERR_UNSUPPORTED, NULL, "a Radiance image that is not of RGBE");
    } while (line[0] != 0);
    if (!next_line(r, line, sizeof line) ||
        sscanf(line, "-Y %7u +X %7u", &image->height, &image->width) != 2)
        return broken("the size is not -Y height +X width");
    snell_status status = image_make_float_room(image, size_max);
    if (status) return status;
    uint8_t *row = memory_resize(NULL, image->width, 4);
    if (row == NULL) return error_no_memory();
    float *to = (float *)(void *)image->pixels;
    for (uint32_t y = 0; !status && y < image->height; y++) {
        if (!read_row(r, row, image->width)) status = broken("the file ends early");
        for (size_t x = 0; !status && x < image->width; x++, to += 4) {
            const uint8_t *p = row + 4 * x;
            double scale = p[3] ? ldexp(1, p[3] - 136) : 0; /* exact: a power of two */
            for (int c = 0; c < 3; c++) to[c] = (float)(p[c] * scale);
            to[3] = 1;
        }
    }
    free(row);
    return status;
}

/* ---- PFM ---- */

static float read_float(const uint8_t *p, bool big) {
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++) bits |= (uint32_t)p[i] << 8 * (big ? 3 - i : i);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static snell_status decode_pfm(reader *r, size_t size_max, decoded_image *image) {
    char kind[8], sides[64], scale[64];
    if (!next_line(r, kind, sizeof kind) || !next_line(r, sides, sizeof sides) ||
        !next_line(r, scale, sizeof scale) ||
        sscanf(sides, "%7u %7u", &image->width, &image->height) != 2)
        return broken("the head");
    snell_status status = image_make_float_room(image, size_max);
    if (status) return status;
    bool big = scale[0] != '-';
    uint32_t channels = kind[1] == 'F' ? 3 : 1;
    if (r->size - r->at < (size_t)image->width * image->height * channels * 4)
        return broken("the file ends early");
    const uint8_t *from = r->data + r->at;
    for (uint32_t y = image->height; y-- > 0;) { /* the last row comes first */
        float *to = (float *)(void *)image->pixels + (size_t)y * image->width * 4;
        for (uint32_t x = 0; x < image->width; x++, to += 4, from += (size_t)4 * channels) {
            for (uint32_t c = 0; c < 3; c++)
                to[c] = read_float(from + (channels == 3 ? 4 * c : 0), big);
            to[3] = 1;
        }
    }
    return SNELL_OK;
}

/* ---- both ---- */

static bool begins(const void *data, size_t size, const char *magic) {
    return size >= strlen(magic) && memcmp(data, magic, strlen(magic)) == 0;
}

bool image_is_float(const void *data, size_t size) {
    return begins(data, size, "#?R") || begins(data, size, "v/1\x01") ||
           begins(data, size, "PF\n") || begins(data, size, "Pf\n");
}

snell_status image_decode_layer(const void *data, size_t size, size_t size_max, const char *layer,
                                image_names *layers, decoded_image *out) {
    reader r = {data, size, 0};
    *out = (decoded_image){.opaque = true};
    snell_status status;
    if (begins(data, size, "v/1\x01"))
        status = image_decode_exr(data, size, size_max, layer, layers, out);
    else if (layer[0])
        status = error_set(SNELL_ERR_ARGUMENT, "only OpenEXR files do", "it has no layers");
    else if (begins(data, size, "#?R"))
        status = decode_radiance(&r, size_max, out);
    else
        status = decode_pfm(&r, size_max, out);
    if (status) image_free(out);
    return status;
}

snell_status image_decode_float(const void *data, size_t size, size_t size_max,
                                decoded_image *out) {
    snell_status status = image_decode_layer(data, size, size_max, "", NULL, out);
    float *value = (float *)(void *)out->pixels;
    size_t count = (size_t)out->width * out->height * 4;
    for (size_t i = 0; i < count; i++)
        if (value[i] < 0) value[i] = 0;
    return status;
}
