/* Picture files: encoding in memory, and what the start of a file says about it. One file per
 * format (png.c, exr.c, ...), listed in codec.c. */
#ifndef SNELL_IMAGE_CODEC_H
#define SNELL_IMAGE_CODEC_H

#include "base/error.h"
#include "image/film.h"
#include "image/tonemap.h"
#include "image/white_balance.h"

/* Linear radiance, interleaved, rows top first. */
typedef struct image_pixels {
    const float *data;
    uint32_t width, height;
    uint32_t channels; /* 3: RGB; 4: RGBA, premultiplied */
} image_pixels;

typedef struct image_options {
    const tonemap *map;  /* of 8-bit formats; NULL: the first, clip */
    double exposure;     /* stops, the same */
    white_balance white; /* the same; before the exposure */
    uint32_t bits;       /* of a channel, where a format has a choice (bits_other); 0: its usual */
    uint32_t quality;    /* of formats that lose something: 1 to 100; 0: 90 */
    uint32_t chroma;     /* of y4m: 420 or 444; 0: 420 */
    const char *tag;     /* how the picture was made, UTF-8; NULL or "": none */
    /* Beside the picture, of its size; kept by formats that can (has_layers). */
    const film_layer *layers;
    size_t layer_count;
    /* Of a render with a noise, as in film, for formats with layers; NULL: none. */
    const float *variance;
    const uint32_t *samples;
} image_options;

/* What a file says about itself. */
typedef struct image_info {
    char format[8]; /* "png" */
    uint32_t width, height, channels, bits;
    uint32_t frames; /* of an animation; 0: one picture */
    char *tag;       /* owned; "" when there is none */
    char *layers;    /* owned; beside the colours, "depth: Z" and a line end each; "" for none */
} image_info;

/* Encoders append to this. */
typedef struct image_buffer {
    uint8_t *data;
    size_t size, capacity;
} image_buffer;
bool image_buffer_add(image_buffer *b, const void *data, size_t size); /* false: no memory */

typedef struct image_codec {
    const char *name, *extension, *help;
    const char *extension_too; /* NULL: there is no other */
    bool has_tag;              /* can carry a tag; without, the tag is left out */
    bool linear;               /* floats: neither exposed nor tone-mapped */
    bool has_layers;           /* can carry what a film has beside its light */
    bool has_quality;
    bool has_alpha;            /* without, what is transparent lies over black */
    uint32_t side_max;         /* pixels each way; 0: what there can be */
    uint32_t bits, bits_other; /* of a channel: usually, and by choice; 0: no choice */
    /* NULL: this build cannot; `missing` then says what to do. Bits and quality are never 0. */
    snell_status (*encode)(const image_pixels *pixels, const image_options *options,
                           image_buffer *out);
    const char *missing;
    /* Is it of this format? Then *status says whether its head makes sense, and *out is filled. The
     * bytes may come from anybody. out->tag: allocated or NULL. */
    bool (*read_info)(const uint8_t *data, size_t size, image_info *out, snell_status *status);
} image_codec;

extern const image_codec *const image_codecs[]; /* NULL at the end */
/* By name ("png"). Unknown: SNELL_ERR_UNSUPPORTED with a list. */
snell_status image_codec_find(const char *name, const image_codec **out);
/* By the extension of a path, upper or lower case. */
snell_status image_codec_for_path(const char *path, const image_codec **out);
/* Settles what is left open, and refuses what the format has not; messages name the extension. */
snell_status image_options_check(const image_codec *codec, const char *extension,
                                 image_options *options);

/* The longest tag, in bytes: what read_info needs lies within the first IMAGE_HEAD_MAX bytes. */
enum { IMAGE_QUALITY = 90 }; /* unless somebody says otherwise */
enum { IMAGE_TAG_MAX = 1 << 20, IMAGE_HEAD_MAX = (1 << 20) + (1 << 18) };

/* *data is freed with free. The same pixels and options give the same bytes. */
snell_status image_encode(const image_codec *codec, const image_pixels *pixels,
                          const image_options *options, void **data, size_t *size);

/* By content. Not a picture: SNELL_ERR_UNSUPPORTED; a broken head: SNELL_ERR_SYNTAX. */
snell_status image_parse_info(const uint8_t *data, size_t size, image_info *out);
snell_status image_read_info(const char *path, image_info *out);
void image_info_free(image_info *info);

/* For the codecs: one row of 8 bits, or of 16 with the high byte first; straight alpha; `to` holds
 * width * channels_out values. With channels_out 3 a transparent picture is laid over black. */
void image_row_8bit(const image_pixels *pixels, const image_options *options, uint32_t row,
                    uint32_t channels_out, uint8_t *to);
void image_row_16bit(const image_pixels *pixels, const image_options *options, uint32_t row,
                     uint32_t channels_out, uint8_t *to);
/* Stores a copy of a tag read from a file; false without memory. */
bool image_info_set_tag(image_info *info, const uint8_t *text, size_t size);

#endif
