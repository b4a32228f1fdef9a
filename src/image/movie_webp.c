/* Animated WebP: every frame whole, without blending. It plays for ever. */
#include <stdlib.h>

#include "image/movie.h"
#include "image/webp.h"

extern const image_codec image_codec_webp;

#if SNELL_HAS_WEBP
enum { NO_BLENDING = 2 };

static snell_status begin(movie_state *m, image_buffer *out) {
    uint32_t most = image_codec_webp.side_max;
    if (m->width > most || m->height > most)
        return error_set(SNELL_ERR_UNSUPPORTED, "write .apng",
                         "a WebP has at most %u pixels a side", most);
    const uint8_t animation[6] = {0}; /* transparent behind; 0: played for ever */
    image_pixels size = {.width = m->width, .height = m->height};
    bool tagged = m->options.tag[0] != '\0';
    unsigned flags =
        WEBP_ANIMATION | (m->channels == 4 ? WEBP_ALPHA : 0u) | (tagged ? WEBP_XMP : 0u);
    bool done = image_buffer_add(out, "RIFF\0\0\0\0WEBP", 12) && webp_extended(out, &size, flags) &&
                (!tagged || webp_tag(out, m->options.tag)) &&
                webp_chunk(out, "ANIM", animation, sizeof animation);
    return done ? SNELL_OK : error_no_memory();
}

/* Times are whole milliseconds: those of a frame's begin and end are rounded. */
static uint32_t milliseconds(const movie_state *m, uint32_t frame) {
    double seconds = (double)frame * m->denominator / m->numerator;
    return (uint32_t)(1000 * seconds + 0.5);
}

static snell_status add(movie_state *m, const image_pixels *pixels, image_buffer *out) {
    image_buffer frame = {0};
    uint8_t head[16] = {0}; /* x, y, width, height, duration, flags */
    uint32_t duration = milliseconds(m, m->frames + 1) - milliseconds(m, m->frames);
    webp_put(head + 6, m->width - 1, 3);
    webp_put(head + 9, m->height - 1, 3);
    webp_put(head + 12, duration < 0xffffff ? duration : 0xffffff, 3);
    head[15] = NO_BLENDING;
    bool memory = image_buffer_add(&frame, head, sizeof head);
    snell_status status = memory ? webp_frame(pixels, &m->options, &frame) : error_no_memory();
    if (!status && m->size + frame.size > UINT32_MAX - 64)
        status = error_set(SNELL_ERR_UNSUPPORTED, "write numbered pictures or y4m",
                           "a WebP holds at most 4 GiB");
    if (!status && !webp_chunk(out, "ANMF", frame.data, frame.size)) status = error_no_memory();
    free(frame.data);
    return status;
}

static snell_status end(movie_state *m, image_buffer *out, movie_patch *patches, int *count) {
    (void)out;
    patches[0] = (movie_patch){.offset = 4, .size = 4};
    webp_put(patches[0].data, (uint32_t)m->size - 8, 4);
    *count = 1;
    return SNELL_OK;
}
#endif

extern const movie_format movie_format_webp;
const movie_format movie_format_webp = {
    .name = "webp",
    .extension = ".webp",
    .help = "an animated WebP; with alpha",
    .codec = &image_codec_webp,
    .has_tag = true,
#if SNELL_HAS_WEBP
    .begin = begin,
    .add = add,
    .end = end,
#endif
};
