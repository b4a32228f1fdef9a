/* Films to files: pictures, animations, and what their formats are. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/api.h"
#include "base/file.h"
#include "base/thread.h"
#include "base/memory.h"
#include "image/aov.h"
#include "image/codec.h"
#include "image/movie.h"

/* ---- pictures ---- */

/* The codec's options from what the caller says, else what the film's scene asks for. */
static snell_status image_settings(const snell_film *f, const snell_image_desc *desc,
                                   image_options *out) {
    if (f->film.pixels == NULL)
        return error_set(SNELL_ERR_STATE, "render first", "the film is empty");
    if (desc && desc->struct_size != sizeof *desc)
        return error_set(SNELL_ERR_VERSION, NULL, "struct_size is another version's");
    if (desc && desc->exposure_set && !(desc->exposure >= -50 && desc->exposure <= 50))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "the exposure is not a number from -50 to 50");
    bool named = desc && desc->tonemap;
    *out = (image_options){.exposure =
                               (double)(desc && desc->exposure_set ? desc->exposure : f->exposure),
                           .tag = desc ? desc->tag : NULL,
                           .bits = desc ? desc->bits : 0,
                           .quality = desc ? desc->quality : 0};
    bool own_white = desc && desc->white_balance;
    snell_status status = white_balance_parse(
        own_white ? desc->white_balance : snell_film_white_balance(f), &out->white);
    if (status) return status;
    return tonemap_find(named ? desc->tonemap : snell_film_look(f, NULL), &out->map);
}

static snell_status find_layer(const snell_film *f, const char *name, const film_layer **out) {
    const char *names[64], *near;
    char hint[96] = "it has none: set snell_render_desc.aov";
    size_t count = f->film.layer_count;
    for (size_t i = 0; i < count; i++) {
        *out = &f->film.layers[i];
        if (strcmp((*out)->name, name) == 0) return SNELL_OK;
        if (i < 64) names[i] = (*out)->name;
    }
    near = count ? closest_word(name, names, count < 64 ? count : 64) : NULL;
    if (near)
        snprintf(hint, sizeof hint, "did you mean '%.60s'?", near);
    else if (count)
        snprintf(hint, sizeof hint, "it has '%.60s'", names[0]);
    return error_set(SNELL_ERR_ARGUMENT, hint, "the film has no AOV '%s'", name);
}

/* A picture of one AOV, made in *room, for a format. */
static snell_status show_layer(const snell_film *f, const image_codec *codec, const char *name,
                               film *room, image_options *options) {
    const film_layer *layer = NULL;
    bool is_light = true;
    snell_status status = find_layer(f, name, &layer);
    if (!status)
        status = codec->linear ? aov_values(layer, room) : aov_show(layer, room, &is_light);
    if (is_light) return status;
    options->exposure = 0;
    options->map = tonemaps[0];
    options->white.on = false;
    return status;
}

static snell_status encode(const snell_film *f, const image_codec *codec,
                           const snell_image_desc *desc, void **data, size_t *size) {
    image_options options;
    film one = {.pixels = NULL};
    const film *from = &f->film;
    snell_status status = image_settings(f, desc, &options);
    if (!status && desc && desc->aov) {
        status = show_layer(f, codec, desc->aov, &one, &options);
        from = &one;
    }
    options.layers = from->layers;
    options.layer_count = from->layer_count;
    options.variance = from->variance;
    options.samples = from->samples;
    image_pixels pixels = {from->pixels, from->width, from->height, from->channels};
    if (!status) status = image_encode(codec, &pixels, &options, data, size);
    film_free(&one);
    return status;
}

snell_status snell_film_encode(const snell_film *f, const char *format,
                               const snell_image_desc *desc, void **data, size_t *size) {
    if (f == NULL || format == NULL || data == NULL || size == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_film_encode: an argument is NULL");
    const image_codec *codec;
    snell_status status = image_codec_find(format, &codec);
    unsigned saved = floatenv_enter();
    if (!status) status = encode(f, codec, desc, data, size);
    floatenv_leave(saved);
    return status;
}

snell_status snell_film_write(const snell_film *f, const char *path, const snell_image_desc *desc) {
    if (f == NULL || path == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_film_write: an argument is NULL");
    const image_codec *codec;
    void *data = NULL;
    size_t size;
    unsigned saved = floatenv_enter();
    snell_status status = image_codec_for_path(path, &codec);
    if (!status) status = encode(f, codec, desc, &data, &size);
    if (!status) status = file_write_atomic(path, data, size);
    free(data);
    floatenv_leave(saved);
    return status;
}

snell_status snell_picture_read_info(const char *path, snell_picture_info *out) {
    if (path == NULL || out == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    if (out->struct_size != sizeof *out)
        return error_set(SNELL_ERR_VERSION, NULL, "struct_size is another version's");
    image_info info;
    snell_status status = image_read_info(path, &info);
    if (status) return status;
    *out = (snell_picture_info){.struct_size = sizeof *out,
                                .width = info.width,
                                .height = info.height,
                                .channels = info.channels,
                                .bits = info.bits,
                                .frames = info.frames,
                                .tag = info.tag,
                                .layers = info.layers};
    memcpy(out->format, info.format, sizeof out->format);
    return SNELL_OK;
}

/* ---- formats ---- */

static size_t codec_count(void) {
    size_t count = 0;
    while (image_codecs[count]) count++;
    return count;
}

static const movie_format *movie_named(const char *name) {
    for (size_t i = 0; movie_formats[i]; i++)
        if (strcmp(movie_formats[i]->name, name) == 0) return movie_formats[i];
    return NULL;
}

/* Those of animations alone come after the codecs. */
static const movie_format *movie_alone(size_t index) {
    for (size_t i = 0; movie_formats[i]; i++) {
        bool codec = false;
        for (size_t k = 0; image_codecs[k]; k++)
            codec |= strcmp(image_codecs[k]->name, movie_formats[i]->name) == 0;
        if (!codec && index-- == 0) return movie_formats[i];
    }
    return NULL;
}

bool snell_picture_format(uint32_t index, snell_picture_format_info *out) {
    if (out == NULL || out->struct_size != sizeof *out) return false;
    size_t count = codec_count();
    const image_codec *codec = index < count ? image_codecs[index] : NULL;
    const movie_format *moving = codec ? movie_named(codec->name) : movie_alone(index - count);
    if (codec == NULL && moving == NULL) return false;
    const image_codec *kind = codec ? codec : moving->codec;
    *out = (snell_picture_format_info){
        .struct_size = sizeof *out,
        .name = codec ? codec->name : moving->name,
        .extension = codec ? codec->extension : moving->extension,
        .extension_too = codec && codec->extension_too ? codec->extension_too : "",
        .help = codec ? codec->help : moving->help,
        .picture = codec != NULL,
        .animation = moving != NULL,
        .stream = moving && moving->streams,
        .built = kind->encode != NULL,
        .linear = kind->linear,
        .layers = codec && codec->has_layers,
        .tag = codec ? codec->has_tag : moving->has_tag,
        .quality = kind->has_quality,
        .side_max = kind->side_max,
        .bits = {kind->bits, kind->bits_other},
        .chroma = moving && moving->has_chroma,
        .alpha = kind->has_alpha};
    return true;
}

/* ---- animations ---- */

struct snell_movie {
    movie *movie;
};

static snell_status movie_open(const char *path, const snell_movie_desc *desc, snell_movie *out) {
    const movie_format *format;
    movie_sink sink = {path, desc->write, desc->user};
    image_options options = {.tag = desc->image ? desc->image->tag : NULL,
                             .bits = desc->image ? desc->image->bits : 0,
                             .quality = desc->image ? desc->image->quality : 0,
                             .chroma = desc->chroma};
    snell_status status = movie_format_find(desc->format, path, &format);
    return status ? status : movie_create(format, &sink, desc->fps, &options, &out->movie);
}

snell_status snell_movie_create(const char *path, const snell_movie_desc *desc, snell_movie **out) {
    snell_movie_desc defaults = SNELL_INIT(movie_desc);
    if (desc == NULL) desc = &defaults;
    if (out == NULL || (path == NULL && (desc->write == NULL || desc->format == NULL)))
        return error_set(SNELL_ERR_ARGUMENT, "give a path, or a format and where the bytes go",
                         "snell_movie_create: an argument is NULL");
    if (desc->struct_size != sizeof *desc ||
        (desc->image && desc->image->struct_size != sizeof *desc->image))
        return error_set(SNELL_ERR_VERSION, NULL, "struct_size is another version's");
    snell_movie *made = memory_zeroed(1, sizeof *made);
    if (made == NULL) return error_no_memory();
    snell_status status = movie_open(path, desc, made);
    if (status)
        free(made);
    else
        *out = made;
    return status;
}

snell_status snell_movie_add(snell_movie *m, const snell_film *f, const snell_image_desc *image) {
    if (m == NULL || f == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_movie_add: an argument is NULL");
    image_options options;
    unsigned saved = floatenv_enter();
    snell_status status = image_settings(f, image, &options);
    image_pixels pixels = {f->film.pixels, f->film.width, f->film.height, f->film.channels};
    if (!status) status = movie_add(m->movie, &pixels, &options);
    floatenv_leave(saved);
    return status;
}

snell_status snell_movie_finish(snell_movie *m, const char *path) {
    if (m == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_movie_finish: an argument is NULL");
    snell_status status = movie_finish(m->movie, path);
    free(m);
    return status;
}

void snell_movie_destroy(snell_movie *m) {
    if (m == NULL) return;
    movie_abandon(m->movie);
    free(m);
}
