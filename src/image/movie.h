/* Animations: pictures one after the other in one file, which grows as they come. One file per format
 * (movie_apng.c, ...), listed in movie.c. */
#ifndef SNELL_IMAGE_MOVIE_H
#define SNELL_IMAGE_MOVIE_H

#include "image/codec.h"

/* Bytes that a format writes over its beginning when it knows how many frames there were. */
typedef struct movie_patch {
    uint64_t offset;
    size_t size;
    uint8_t data[16];
} movie_patch;

typedef struct movie_state {
    uint32_t width, height, channels; /* of every frame, 3 or 4 */
    uint32_t numerator, denominator; /* frames in a second: numerator / denominator, lowest terms */
    image_options options;           /* checked */
    uint32_t frames;                 /* that were added */
    uint64_t size;                   /* of the file so far, without what is being added */
    uint32_t sequence;               /* the format's own */
    uint64_t count_at;               /* the same: where the number of frames lies */
} movie_state;

typedef struct movie_format {
    const char *name, *extension, *help;
    const image_codec *codec; /* whose bits and quality it has, and whether it is built */
    bool has_tag;
    bool streams;    /* needs no patch: it may go into a pipe */
    bool has_chroma; /* a choice of it */
    snell_status (*begin)(movie_state *m, image_buffer *out);
    snell_status (*add)(movie_state *m, const image_pixels *pixels, image_buffer *out);
    /* The file's last bytes; returns how many patches there are, at most MOVIE_PATCHES_MAX. */
    snell_status (*end)(movie_state *m, image_buffer *out, movie_patch *patches, int *patch_count);
} movie_format;
enum { MOVIE_PATCHES_MAX = 2 };

extern const movie_format *const movie_formats[]; /* NULL at the end */
/* By name, or NULL by the path's extension. Unknown: SNELL_ERR_UNSUPPORTED with a list. */
snell_status movie_format_find(const char *name, const char *path, const movie_format **out);

/* Where the bytes go: a file, or whoever takes them in order. */
typedef struct movie_sink {
    const char *path; /* NULL: write */
    bool (*write)(void *user, const void *data, size_t size);
    void *user;
} movie_sink;

typedef struct movie movie;
/* The options' tag is copied. fps: 0.001 to 100000. */
snell_status movie_create(const movie_format *format, const movie_sink *sink, double fps,
                          const image_options *options, movie **out);
/* Every picture has the size and channels of the first. */
snell_status movie_add(movie *m, const image_pixels *pixels, const image_options *options);
/* The file is there, at `path` (NULL: where it was begun; else in the same folder). Nothing was
 * added: SNELL_ERR_STATE, and no file. Frees the movie. */
snell_status movie_finish(movie *m, const char *path);
void movie_abandon(movie *m); /* NULL does nothing */

#endif
