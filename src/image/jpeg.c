/* JPEG, 8 bits, sRGB. A transparent picture is laid over black. Colours keep all their pixels from
 * quality 90, a quarter of them below. The tag is one or more comments, "snell: " and a part of it. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/codec.h"

static const char mark[] = "snell: ";
enum { MARK_LENGTH = sizeof mark - 1, COMMENT_MAX = 65533 - MARK_LENGTH };

#if SNELL_HAS_JPEG
#include <turbojpeg.h>

enum { FULL_COLOR_QUALITY = 90 };

static bool write_tag(const char *tag, image_buffer *out) {
    for (size_t left = strlen(tag); left > 0;) {
        size_t part = left < COMMENT_MAX ? left : COMMENT_MAX, length = part + MARK_LENGTH + 2;
        const uint8_t head[4] = {0xff, 0xfe, (uint8_t)(length >> 8), (uint8_t)length};
        if (!image_buffer_add(out, head, sizeof head) ||
            !image_buffer_add(out, mark, MARK_LENGTH) || !image_buffer_add(out, tag, part))
            return false;
        tag += part;
        left -= part;
    }
    return true;
}

/* The comments go behind the JFIF segment, which has to be the first. */
static bool add_tagged(const uint8_t *file, size_t size, const char *tag, image_buffer *out) {
    size_t head = 4 + (size_t)(file[4] << 8 | file[5]);
    return image_buffer_add(out, file, head) && write_tag(tag, out) &&
           image_buffer_add(out, file + head, size - head);
}

static snell_status encode(const image_pixels *pixels, const image_options *options,
                           image_buffer *out) {
    uint8_t *rgb = memory_resize(NULL, (size_t)pixels->width * pixels->height, 3), *file = NULL;
    tjhandle jpeg = tjInitCompress();
    unsigned long size = 0;
    snell_status status = rgb && jpeg ? SNELL_OK : error_no_memory();
    for (uint32_t y = 0; !status && y < pixels->height; y++)
        image_row_8bit(pixels, options, y, 3, rgb + (size_t)3 * y * pixels->width);
    int sampling = options->quality < FULL_COLOR_QUALITY ? TJSAMP_420 : TJSAMP_444;
    /* The accurate DCT gives the same bits with and without SIMD. */
    if (!status &&
        tjCompress2(jpeg, rgb, (int)pixels->width, 0, (int)pixels->height, TJPF_RGB, &file, &size,
                    sampling, (int)options->quality, TJFLAG_ACCURATEDCT) != 0)
        status = error_set(SNELL_ERR_INTERNAL, "try .png", "libturbojpeg failed: %s",
                           tjGetErrorStr2(jpeg));
    if (!status && !add_tagged(file, size, options->tag, out)) status = error_no_memory();
    if (file) tjFree(file);
    if (jpeg) tjDestroy(jpeg);
    free(rgb);
    return status;
}
#endif

/* ---- reading the head: markers with their lengths, up to the scan ---- */

static bool is_frame(uint8_t marker) { /* SOF0 to SOF15; three of them are other things */
    return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

static bool read_segment(uint8_t marker, const uint8_t *p, size_t size, image_info *out,
                         image_buffer *tag) {
    if (is_frame(marker) && size >= 6) {
        out->bits = p[0];
        out->height = (uint32_t)p[1] << 8 | p[2];
        out->width = (uint32_t)p[3] << 8 | p[4];
        out->channels = p[5];
    }
    bool ours = marker == 0xfe && size >= MARK_LENGTH && memcmp(p, mark, MARK_LENGTH) == 0;
    return !ours || image_buffer_add(tag, p + MARK_LENGTH, size - MARK_LENGTH);
}

static bool read_info(const uint8_t *data, size_t size, image_info *out, snell_status *status) {
    if (size < 3 || data[0] != 0xff || data[1] != 0xd8 || data[2] != 0xff) return false;
    image_buffer tag = {0};
    bool memory = true;
    for (size_t at = 2; memory && size - at >= 4 && data[at] == 0xff;) {
        uint8_t marker = data[at + 1];
        if (marker == 0xff) { /* fill */
            at++;
            continue;
        }
        size_t length = (size_t)data[at + 2] << 8 | data[at + 3];
        if (marker == 0xda || length < 2 || length > size - at - 2) break;
        memory = read_segment(marker, data + at + 4, length - 2, out, &tag);
        at += 2 + length;
    }
    if (!memory || !image_info_set_tag(out, tag.data, tag.size))
        *status = error_no_memory();
    else if (out->width == 0 || out->height == 0 || out->channels == 0 || out->bits == 0)
        *status = error_set(SNELL_ERR_SYNTAX, NULL, "the JPEG file's head is broken");
    free(tag.data);
    return true;
}

extern const image_codec image_codec_jpeg;
const image_codec image_codec_jpeg = {
    .name = "jpg",
    .extension = ".jpg",
    .extension_too = ".jpeg",
    .help = "8 bits, sRGB, tone-mapped; without alpha",
    .has_tag = true,
    .has_quality = true,
    .side_max = 65500,
    .bits = 8,
#if SNELL_HAS_JPEG
    .encode = encode,
#else
    .missing = "write .png, or build with -DSNELL_JPEG=ON",
#endif
    .read_info = read_info,
};
