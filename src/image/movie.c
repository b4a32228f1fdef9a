#include "image/movie.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "base/memory.h"

extern const movie_format movie_format_apng, movie_format_webp, movie_format_y4m;
const movie_format *const movie_formats[] = {&movie_format_apng, &movie_format_webp,
                                             &movie_format_y4m, NULL};

struct movie {
    const movie_format *format;
    movie_sink sink;
    file_writer *file; /* NULL: the sink's own, or not begun */
    char *path, *tag;
    movie_state state;
};

static const char *extension_of(const char *path) {
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    return dot ? dot : "";
}

snell_status movie_format_find(const char *name, const char *path, const movie_format **out) {
    const char *word = name ? name : extension_of(path);
    for (size_t i = 0; movie_formats[i]; i++) {
        const movie_format *f = movie_formats[i];
        if (name ? strcmp(f->name, word) != 0 : strcasecmp(f->extension, word) != 0) continue;
        *out = f;
        return SNELL_OK;
    }
    return error_set_at(SNELL_ERR_UNSUPPORTED, (source_place){.file = path},
                        "animations are written as .apng, .webp or .y4m", "'%s' holds no animation",
                        word);
}

static uint32_t common_divisor(uint32_t a, uint32_t b) { return b ? common_divisor(b, a % b) : a; }

/* 23.976 and its like are 24000/1001; the others are taken to thousandths. */
static void set_rate(movie_state *m, double fps) {
    double whole = floor(fps * 1.001 + 0.5);
    uint32_t numerator = (uint32_t)(fps * 1000 + 0.5), denominator = 1000;
    if (whole >= 1 && fabs(fps - whole / 1.001) < 5e-4 && fabs(fps - whole) > 5e-4)
        numerator = (uint32_t)whole * 1000, denominator = 1001;
    uint32_t divisor = common_divisor(numerator, denominator);
    m->numerator = numerator / divisor;
    m->denominator = denominator / divisor;
}

snell_status movie_create(const movie_format *format, const movie_sink *sink, double fps,
                          const image_options *options, movie **out) {
    if (!(fps >= 0.001 && fps <= 100000))
        return error_set(SNELL_ERR_ARGUMENT, "0.001 to 100000", "%g frames a second", fps);
    if (options->chroma != 0 &&
        (!format->has_chroma || (options->chroma != 420 && options->chroma != 444)))
        return error_set(SNELL_ERR_ARGUMENT, "420 or 444, of y4m", "chroma %u of %s",
                         options->chroma, format->extension);
    if (sink->path == NULL && !format->streams)
        return error_set(SNELL_ERR_ARGUMENT, "write it to a file, or y4m",
                         "%s is finished at its beginning, so it cannot go into a pipe",
                         format->name);
    movie *m = memory_zeroed(1, sizeof *m);
    if (m == NULL) return error_no_memory();
    *m = (movie){.format = format, .sink = *sink, .state.options = *options};
    snell_status status = image_options_check(format->codec, format->extension, &m->state.options);
    m->path = memory_copy_string(sink->path ? sink->path : "");
    m->tag = status ? NULL : memory_copy_string(m->state.options.tag);
    if (!status && (m->path == NULL || m->tag == NULL)) status = error_no_memory();
    m->state.options.tag = m->tag;
    set_rate(&m->state, fps);
    if (!status && sink->path) status = file_begin(m->path, &m->file);
    if (status)
        movie_abandon(m);
    else
        *out = m;
    return status;
}

static snell_status put(movie *m, const image_buffer *bytes) {
    m->state.size += bytes->size;
    if (m->file) return file_append(m->file, bytes->data, bytes->size);
    if (m->sink.write(m->sink.user, bytes->data, bytes->size)) return SNELL_OK;
    return error_set(SNELL_ERR_IO, NULL, "the animation cannot be written");
}

static snell_status check_pixels(movie *m, const image_pixels *pixels) {
    movie_state *s = &m->state;
    if (pixels->data == NULL || pixels->width == 0 || pixels->height == 0)
        return error_set(SNELL_ERR_STATE, "render first", "there is no picture to write");
    if (s->frames == 0) {
        s->width = pixels->width;
        s->height = pixels->height;
        s->channels = pixels->channels;
    }
    if (pixels->width == s->width && pixels->height == s->height && pixels->channels == s->channels)
        return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "every frame has the size of the first",
                     "frame %u has %u x %u pixels and %u channels, the first %u x %u and %u",
                     s->frames + 1, pixels->width, pixels->height, pixels->channels, s->width,
                     s->height, s->channels);
}

snell_status movie_add(movie *m, const image_pixels *pixels, const image_options *options) {
    movie_state *s = &m->state;
    image_buffer bytes = {0};
    snell_status status = check_pixels(m, pixels);
    s->options.map = options->map ? options->map : tonemaps[0];
    s->options.exposure = options->exposure;
    s->options.white = options->white;
    if (!status && s->frames == 0) status = m->format->begin(s, &bytes);
    if (!status) status = m->format->add(s, pixels, &bytes);
    if (!status) status = put(m, &bytes);
    if (!status) s->frames++;
    free(bytes.data);
    return status;
}

snell_status movie_finish(movie *m, const char *path) {
    image_buffer bytes = {0};
    movie_patch patches[MOVIE_PATCHES_MAX];
    int count = 0;
    snell_status status = m->state.frames > 0
                              ? m->format->end(&m->state, &bytes, patches, &count)
                              : error_set(SNELL_ERR_STATE, "add frames", "the animation is empty");
    if (!status && bytes.size) status = put(m, &bytes);
    for (int i = 0; !status && m->file && i < count; i++)
        status = file_patch(m->file, patches[i].offset, patches[i].data, patches[i].size);
    if (!status && m->file) {
        status = file_finish(m->file, path);
        m->file = NULL;
    }
    free(bytes.data);
    movie_abandon(m);
    return status;
}

void movie_abandon(movie *m) {
    if (m == NULL) return;
    file_abandon(m->file);
    free(m->path);
    free(m->tag);
    free(m);
}
