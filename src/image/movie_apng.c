/* Animated PNG (APNG 1.0, now part of PNG's third edition): every frame is encoded as a PNG, and its
 * IDAT chunks become fdAT chunks with a running number. It plays for ever. */
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "image/movie.h"

extern const image_codec image_codec_png;

static void put32(uint8_t *to, uint32_t value) {
    for (int i = 0; i < 4; i++) to[i] = (uint8_t)(value >> (24 - 8 * i));
}

static uint32_t get32(const uint8_t *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

/* A chunk of two parts, of which the second may be empty. */
static bool add_chunk(image_buffer *out, const char *type, const uint8_t *head, size_t head_size,
                      const uint8_t *body, size_t body_size) {
    uint8_t length[4], check[4];
    size_t start = out->size + 4;
    put32(length, (uint32_t)(head_size + body_size));
    if (!image_buffer_add(out, length, 4) || !image_buffer_add(out, type, 4) ||
        !image_buffer_add(out, head, head_size) || !image_buffer_add(out, body, body_size))
        return false;
    put32(check, (uint32_t)crc32_z(0, out->data + start, out->size - start));
    return image_buffer_add(out, check, 4);
}

static snell_status begin(movie_state *m, image_buffer *out) {
    (void)m; /* the first frame brings signature, header and tag */
    (void)out;
    return SNELL_OK;
}

static bool add_control(movie_state *m, image_buffer *out) {
    uint8_t control[26];
    put32(control, m->sequence++);
    put32(control + 4, m->width);
    put32(control + 8, m->height);
    put32(control + 12, 0);
    put32(control + 16, 0);
    uint32_t numerator = m->denominator, denominator = m->numerator;
    while (numerator > 65535 || denominator > 65535) numerator /= 2, denominator /= 2;
    const uint8_t rest[6] = {(uint8_t)(numerator >> 8),
                             (uint8_t)numerator,
                             (uint8_t)(denominator >> 8),
                             (uint8_t)denominator,
                             0,  /* the frame stays until the next */
                             0}; /* and takes the place of what was there, alpha too */
    memcpy(control + 20, rest, sizeof rest);
    return add_chunk(out, "fcTL", control, sizeof control, NULL, 0);
}

static bool add_counts(movie_state *m, image_buffer *out) {
    uint8_t counts[8] = {0}; /* frames, known at the end; plays, 0 being for ever */
    m->count_at = m->size + out->size;
    put32(counts, 1);
    return add_chunk(out, "acTL", counts, sizeof counts, NULL, 0);
}

/* The chunks of a whole PNG as those of a frame. */
static bool add_frame(movie_state *m, const uint8_t *png, size_t size, image_buffer *out) {
    bool first = m->frames == 0, started = false, done = true;
    if (first) done = image_buffer_add(out, png, 8);
    for (size_t at = 8; done && at + 12 <= size;) {
        size_t length = get32(png + at);
        const char *type = (const char *)png + at + 4;
        const uint8_t *data = png + at + 8;
        bool is_data = memcmp(type, "IDAT", 4) == 0;
        if (is_data && !started) {
            started = true;
            done = (!first || add_counts(m, out)) && add_control(m, out);
        }
        if (done && is_data && !first) {
            uint8_t number[4];
            put32(number, m->sequence++);
            done = add_chunk(out, "fdAT", number, sizeof number, data, length);
        } else if (done && first && memcmp(type, "IEND", 4) != 0) {
            done = image_buffer_add(out, png + at, 12 + length);
        }
        at += 12 + length;
    }
    return done;
}

static snell_status add(movie_state *m, const image_pixels *pixels, image_buffer *out) {
    void *png;
    size_t size;
    image_options options = m->options;
    options.quality = 0;
    snell_status status = image_encode(&image_codec_png, pixels, &options, &png, &size);
    if (status) return status;
    bool done = add_frame(m, png, size, out);
    free(png);
    return done ? SNELL_OK : error_no_memory();
}

static snell_status end(movie_state *m, image_buffer *out, movie_patch *patches, int *count) {
    image_buffer chunk = {0};
    uint8_t counts[8] = {0};
    put32(counts, m->frames);
    bool done = add_chunk(&chunk, "acTL", counts, sizeof counts, NULL, 0) &&
                add_chunk(out, "IEND", NULL, 0, NULL, 0);
    if (done) {
        patches[0] = (movie_patch){.offset = m->count_at + 8, .size = 12};
        memcpy(patches[0].data, chunk.data + 8, 12); /* the counts and their check */
        *count = 1;
    }
    free(chunk.data);
    return done ? SNELL_OK : error_no_memory();
}

extern const movie_format movie_format_apng;
const movie_format movie_format_apng = {
    .name = "apng",
    .extension = ".apng",
    .help = "an animated PNG; with alpha",
    .codec = &image_codec_png,
    .has_tag = true,
    .begin = begin,
    .add = add,
    .end = end,
};
