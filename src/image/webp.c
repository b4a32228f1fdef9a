/* WebP, 8 bits, sRGB, straight alpha; quality 100 is lossless. The container is written here: with
 * a tag or several frames it begins with VP8X, and the tag is an XMP packet before the picture,
 * so that the file's start tells it. */
#include "image/webp.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

static uint32_t little_endian(const uint8_t *p) {
    return (uint32_t)p[3] << 24 | (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 | p[0];
}

static uint32_t little_endian_24(const uint8_t *p) {
    return (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 | p[0];
}

/* ---- the tag ---- */

static const char attribute[] = "snell:tag='";

/* What XML does not take as it is in an attribute. */
static const struct {
    char character;
    const char *text;
} escapes[] = {{'&', "&amp;"},  {'<', "&lt;"},   {'>', "&gt;"}, {'\'', "&apos;"},
               {'\n', "&#10;"}, {'\r', "&#13;"}, {'\t', "&#9;"}};
enum { ESCAPE_COUNT = sizeof escapes / sizeof escapes[0] };

/* ---- writing ---- */

#if SNELL_HAS_WEBP
#include <webp/encode.h>

static const char packet_head[] = "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF "
                                  "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">"
                                  "<rdf:Description rdf:about=\"\" xmlns:snell=\"urn:snell\" "
                                  "snell:tag='";
static const char packet_tail[] = "'/></rdf:RDF></x:xmpmeta>";

void webp_put(uint8_t *to, uint32_t value, int bytes) {
    for (int i = 0; i < bytes; i++) to[i] = (uint8_t)(value >> 8 * i);
}

bool webp_chunk(image_buffer *out, const char *name, const void *data, size_t size) {
    uint8_t head[8];
    memcpy(head, name, 4);
    webp_put(head + 4, (uint32_t)size, 4);
    return image_buffer_add(out, head, sizeof head) && image_buffer_add(out, data, size) &&
           image_buffer_add(out, "", size % 2);
}

static bool add_escaped(const char *tag, image_buffer *out) {
    for (; *tag; tag++) {
        int i = 0;
        while (i < ESCAPE_COUNT && escapes[i].character != *tag) i++;
        const char *text = i < ESCAPE_COUNT ? escapes[i].text : tag;
        if (!image_buffer_add(out, text, i < ESCAPE_COUNT ? strlen(text) : 1)) return false;
    }
    return true;
}

bool webp_tag(image_buffer *out, const char *tag) {
    image_buffer packet = {0};
    bool done = image_buffer_add(&packet, packet_head, sizeof packet_head - 1) &&
                add_escaped(tag, &packet) &&
                image_buffer_add(&packet, packet_tail, sizeof packet_tail - 1) &&
                webp_chunk(out, "XMP ", packet.data, packet.size);
    free(packet.data);
    return done;
}

bool webp_extended(image_buffer *out, const image_pixels *pixels, unsigned flags) {
    uint8_t head[10] = {(uint8_t)flags};
    webp_put(head + 4, pixels->width - 1, 3);
    webp_put(head + 7, pixels->height - 1, 3);
    return webp_chunk(out, "VP8X", head, sizeof head);
}

static int on_write(const uint8_t *data, size_t size, const WebPPicture *picture) {
    return image_buffer_add(picture->custom_ptr, data, size);
}

static bool import(const image_pixels *pixels, const image_options *options, WebPPicture *to) {
    uint32_t channels = pixels->channels;
    uint8_t *bytes = memory_resize(NULL, (size_t)pixels->width * pixels->height, channels);
    int stride = (int)(pixels->width * channels);
    for (uint32_t y = 0; bytes && y < pixels->height; y++)
        image_row_8bit(pixels, options, y, channels, bytes + (size_t)y * (size_t)stride);
    bool done = bytes && (channels == 4 ? WebPPictureImportRGBA(to, bytes, stride)
                                        : WebPPictureImportRGB(to, bytes, stride));
    free(bytes);
    return done;
}

snell_status webp_frame(const image_pixels *pixels, const image_options *options,
                        image_buffer *out) {
    WebPConfig config;
    WebPPicture picture;
    if (!WebPConfigInit(&config) || !WebPPictureInit(&picture))
        return error_set(SNELL_ERR_INTERNAL, "try .png", "libwebp is of another version");
    config.quality = (float)options->quality;
    if (options->quality == 100) {
        config.lossless = 1;
        config.exact = 1;    /* also what is transparent */
        config.quality = 70; /* of the effort */
    }
    picture.use_argb = 1; /* what loses is converted by libwebp too */
    picture.width = (int)pixels->width;
    picture.height = (int)pixels->height;
    image_buffer file = {0};
    picture.writer = on_write;
    picture.custom_ptr = &file;
    bool done = import(pixels, options, &picture) && WebPEncode(&config, &picture);
    bool memory = picture.error_code == VP8_ENC_ERROR_OUT_OF_MEMORY ||
                  picture.error_code == VP8_ENC_ERROR_BAD_WRITE || picture.error_code == VP8_ENC_OK;
    unsigned code = (unsigned)picture.error_code;
    WebPPictureFree(&picture);
    snell_status status = SNELL_OK;
    if (!done)
        status = memory ? error_no_memory()
                        : error_set(SNELL_ERR_INTERNAL, "try .png", "libwebp failed: %u", code);
    for (size_t at = 12; !status && at + 8 <= file.size;) { /* the picture's own chunks */
        size_t size = little_endian(file.data + at + 4), all = 8 + size + size % 2;
        bool wanted = memcmp(file.data + at, "VP8X", 4) != 0;
        if (wanted && !image_buffer_add(out, file.data + at, all)) status = error_no_memory();
        at += all;
    }
    free(file.data);
    return status;
}

static snell_status encode(const image_pixels *pixels, const image_options *options,
                           image_buffer *out) {
    image_buffer frame = {0};
    snell_status status = webp_frame(pixels, options, &frame);
    bool tagged = options->tag[0] != '\0', alpha = pixels->channels == 4;
    size_t start = out->size;
    bool done = !status && image_buffer_add(out, "RIFF\0\0\0\0WEBP", 12);
    if (tagged || alpha)
        done = done &&
               webp_extended(out, pixels, (alpha ? WEBP_ALPHA : 0u) | (tagged ? WEBP_XMP : 0u));
    if (tagged) done = done && webp_tag(out, options->tag);
    done = done && image_buffer_add(out, frame.data, frame.size);
    if (done) webp_put(out->data + start + 4, (uint32_t)(out->size - start - 8), 4);
    free(frame.data);
    return status ? status : done ? SNELL_OK : error_no_memory();
}
#endif

/* ---- reading the head ---- */

/* The attribute's value without its escapes, in place of `text`; its length. */
static size_t unescape(char *text, size_t size) {
    size_t used = 0;
    for (size_t at = 0; at < size;) {
        int i = 0;
        size_t length = 0;
        for (; i < ESCAPE_COUNT; i++) {
            length = strlen(escapes[i].text);
            if (length <= size - at && memcmp(text + at, escapes[i].text, length) == 0) break;
        }
        text[used++] = i < ESCAPE_COUNT ? escapes[i].character : text[at];
        at += i < ESCAPE_COUNT ? length : 1;
    }
    return used;
}

static bool read_tag(const uint8_t *p, size_t size, image_info *out) {
    const uint8_t *at = memmem(p, size, attribute, sizeof attribute - 1);
    if (at == NULL) return true;
    at += sizeof attribute - 1;
    const uint8_t *end = memchr(at, '\'', size - (size_t)(at - p));
    if (end == NULL) return true;
    if (!image_info_set_tag(out, at, (size_t)(end - at))) return false;
    out->tag[unescape(out->tag, (size_t)(end - at))] = '\0';
    return true;
}

static void read_size(const uint8_t *name, const uint8_t *p, size_t size, image_info *out) {
    if (memcmp(name, "VP8X", 4) == 0 && size >= 10) {
        out->width = little_endian_24(p + 4) + 1;
        out->height = little_endian_24(p + 7) + 1;
        out->channels = p[0] & 0x10 ? 4 : 3; /* alpha */
    } else if (memcmp(name, "ANMF", 4) == 0) {
        out->frames++;
    } else if (out->width == 0 && memcmp(name, "VP8L", 4) == 0 && size >= 5 && p[0] == 0x2f) {
        uint32_t bits = little_endian(p + 1);
        out->width = (bits & 0x3fff) + 1;
        out->height = (bits >> 14 & 0x3fff) + 1;
        out->channels = bits >> 28 & 1 ? 4 : 3;
    } else if (out->width == 0 && memcmp(name, "VP8 ", 4) == 0 && size >= 10) {
        out->width = (uint32_t)(p[7] << 8 | p[6]) & 0x3fff;
        out->height = (uint32_t)(p[9] << 8 | p[8]) & 0x3fff;
        out->channels = 3;
    }
}

static bool read_info(const uint8_t *data, size_t size, image_info *out, snell_status *status) {
    if (size < 12 || memcmp(data, "RIFF", 4) != 0 || memcmp(data + 8, "WEBP", 4) != 0) return false;
    out->bits = 8;
    for (size_t at = 12; !*status && size - at >= 8;) {
        size_t length = little_endian(data + at + 4), there = size - at - 8;
        const uint8_t *p = data + at + 8;
        read_size(data + at, p, length < there ? length : there, out);
        if (length > there || length + length % 2 > there) break;
        if (memcmp(data + at, "XMP ", 4) == 0 && !read_tag(p, length, out))
            *status = error_no_memory();
        at += 8 + length + length % 2;
    }
    if (!*status && (out->width == 0 || out->height == 0))
        *status = error_set(SNELL_ERR_SYNTAX, NULL, "the WebP file's head is broken");
    return true;
}

extern const image_codec image_codec_webp;
const image_codec image_codec_webp = {
    .name = "webp",
    .extension = ".webp",
    .help = "8 bits, sRGB, tone-mapped; with alpha",
    .has_tag = true,
    .has_alpha = true,
    .has_quality = true,
    .side_max = 16383,
    .bits = 8,
#if SNELL_HAS_WEBP
    .encode = encode,
#else
    .missing = "write .png, or build with -DSNELL_WEBP=ON",
#endif
    .read_info = read_info,
};
