/* PPM, binary (P6), 8 bits, sRGB. A transparent picture is laid over black. The tag is written as
 * comments, one per line of the tag: "# snell: ...". */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/codec.h"
#include "image/pnm.h"

static const char mark[] = " snell: ";
enum { MARK_LENGTH = sizeof mark - 1 };

static bool write_tag(const char *tag, image_buffer *out) {
    while (*tag) {
        size_t length = strcspn(tag, "\r\n"); /* either would end the comment */
        if (!image_buffer_add(out, "#", 1) || !image_buffer_add(out, mark, MARK_LENGTH) ||
            !image_buffer_add(out, tag, length) || !image_buffer_add(out, "\n", 1))
            return false;
        tag += length;
        if (*tag) tag++;
    }
    return true;
}

static snell_status encode(const image_pixels *pixels, const image_options *options,
                           image_buffer *out) {
    char head[64];
    int length = snprintf(head, sizeof head, "%u %u\n255\n", pixels->width, pixels->height);
    uint8_t *row = memory_resize(NULL, pixels->width, 3);
    bool done = row && image_buffer_add(out, "P6\n", 3) && write_tag(options->tag, out) &&
                image_buffer_add(out, head, (size_t)length);
    for (uint32_t y = 0; done && y < pixels->height; y++) {
        image_row_8bit(pixels, options, y, 3, row);
        done = image_buffer_add(out, row, (size_t)pixels->width * 3);
    }
    free(row);
    return done ? SNELL_OK : error_no_memory();
}

/* ---- reading the head ---- */

static bool is_space(uint8_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

bool pnm_skip_space(const uint8_t *data, size_t size, size_t *at,
                    bool (*comment)(void *user, const uint8_t *text, size_t size), void *user) {
    while (*at < size) {
        if (is_space(data[*at])) {
            ++*at;
        } else if (data[*at] == '#') {
            size_t start = ++*at;
            while (*at < size && data[*at] != '\n' && data[*at] != '\r') ++*at;
            if (comment && !comment(user, data + start, *at - start)) return false;
        } else {
            return true;
        }
    }
    return false;
}

bool pnm_read_number(const uint8_t *data, size_t size, size_t *at, uint32_t *out) {
    if (!pnm_skip_space(data, size, at, NULL, NULL)) return false;
    uint64_t value = 0;
    size_t start = *at;
    for (; *at < size && data[*at] >= '0' && data[*at] <= '9'; ++*at) {
        value = value * 10 + (uint64_t)(data[*at] - '0');
        if (value > INT32_MAX) return false;
    }
    *out = (uint32_t)value;
    bool ends = *at < size && (is_space(data[*at]) || data[*at] == '#'); /* not cut off */
    return *at > start && value > 0 && ends;
}

static bool add_comment(void *user, const uint8_t *text, size_t size) {
    image_buffer *tag = user;
    if (size < MARK_LENGTH || memcmp(text, mark, MARK_LENGTH) != 0) return true;
    if (tag->size && !image_buffer_add(tag, "\n", 1)) return false;
    return image_buffer_add(tag, text + MARK_LENGTH, size - MARK_LENGTH);
}

static bool read_info(const uint8_t *data, size_t size, image_info *out, snell_status *status) {
    if (size < 3 || data[0] != 'P' || data[1] != '6' || !(is_space(data[2]) || data[2] == '#'))
        return false;
    size_t at = 2;
    uint32_t largest = 0;
    image_buffer tag = {0};
    bool good = pnm_skip_space(data, size, &at, add_comment, &tag) &&
                pnm_read_number(data, size, &at, &out->width) &&
                pnm_read_number(data, size, &at, &out->height) &&
                pnm_read_number(data, size, &at, &largest) && largest <= 65535;
    if (good && !image_info_set_tag(out, tag.data, tag.size)) {
        *status = error_no_memory();
    } else if (!good) {
        *status = error_set(SNELL_ERR_SYNTAX, NULL, "the PPM file's head is broken");
    }
    free(tag.data);
    out->channels = 3;
    out->bits = largest > 255 ? 16 : 8;
    return true;
}

extern const image_codec image_codec_ppm;
const image_codec image_codec_ppm = {
    .name = "ppm",
    .extension = ".ppm",
    .help = "8 bits, sRGB, tone-mapped; without alpha",
    .has_tag = true,
    .bits = 8,
    .encode = encode,
    .read_info = read_info,
};
