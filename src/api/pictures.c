/* Films from picture files, and comparing them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "api/api.h"
#include "image/compare.h"
#include "importers/importer.h"
#include "scene/settings.h"

typedef struct phase {
    const char *name;
    snell_progress_fn *progress;
    void *user;
} phase;

static bool report_phase(void *user, double fraction) {
    const phase *p = user;
    snell_progress progress = {
        .struct_size = sizeof progress, .phase = p->name, .fraction = fraction, .seconds_left = -1};
    return p->progress(p->user, &progress);
}

/* ---- reading ---- */

/* One warning says how many pixels are no numbers, and where the first is. */
static void warn_of_pixels(const snell_film *f, const char *path) {
    const film *read = &f->film;
    size_t count = (size_t)read->width * read->height, bad = 0, first = 0;
    for (size_t i = 0; read->encoded_bits == 0 && i < count; i++) {
        const float *p = read->pixels + i * read->channels;
        bool finite = true;
        for (uint32_t c = 0; c < read->channels; c++) finite &= isfinite(p[c]) != 0;
        if (!finite && bad++ == 0) first = i;
    }
    if (bad == 0) return;
    log_write(&f->context->log, SNELL_WARNING, (source_place){.file = path}, NULL,
              "%zu pixel%s NaN or infinite, the first at %zu,%zu", bad, bad == 1 ? " is" : "s are",
              first % read->width, first / read->width);
}

static snell_status read_into(snell_film *f, const char *path, const snell_film_read_desc *desc) {
    phase read = {"read", desc->progress, desc->user};
    helper_options options = {
        .import = {.layer = desc->layer ? desc->layer : "", .memory_max = desc->memory_max},
        .progress = desc->progress ? report_phase : NULL,
        .user = &read};
    helper_picture picture = {.layers = NULL};
    snell_status status = helper_read_picture(path, &options, &picture);
    if (status) return status;
    film_free(&f->film);
    free(f->layers);
    *f = (snell_film){.context = f->context,
                      .film = picture.film,
                      .layers = picture.layers,
                      .tonemap = choice_find(TONEMAP_CHOICES, "clip")};
    if (picture.damaged)
        log_write(&f->context->log, SNELL_WARNING, (source_place){.file = path}, NULL,
                  "the picture is damaged: part of it is grey");
    warn_of_pixels(f, path);
    return SNELL_OK;
}

snell_status snell_film_read(snell_film *f, const char *path, const snell_film_read_desc *desc) {
    snell_film_read_desc defaults = SNELL_INIT(film_read_desc);
    if (desc == NULL) desc = &defaults;
    if (f == NULL || path == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_film_read: an argument is NULL");
    if (desc->struct_size != sizeof *desc)
        return error_set(SNELL_ERR_VERSION, "compile against the library's own header",
                         "snell_film_read: the description has another version's size");
    if (!desc->allow_helper)
        return error_set(SNELL_ERR_UNSUPPORTED, "set allow_helper",
                         "files are read by snell-import, which was not allowed");
    return read_into(f, path, desc);
}

uint32_t snell_film_encoded_bits(const snell_film *f) { return f ? f->film.encoded_bits : 0; }

const char *snell_film_layer(const snell_film *f, uint32_t index) {
    const char *at = f ? f->layers : NULL;
    for (; at && *at; at += strlen(at) + 1)
        if (index-- == 0) return at;
    return NULL;
}

/* ---- comparing ---- */

static snell_status check_sizes(const snell_film *reference, const snell_film *other,
                                const char *what) {
    const film *a = &reference->film, *b = &other->film;
    if (a->pixels == NULL || b->pixels == NULL)
        return error_set(SNELL_ERR_STATE, "read a file or render first", "a film is empty");
    if (a->width == b->width && a->height == b->height) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "only pictures of one size can be compared",
                     "%s has %u x %u pixels, the reference %u x %u", what, b->width, b->height,
                     a->width, a->height);
}

static snell_status check_compare(const snell_film *reference, const snell_film *picture,
                                  const snell_compare_desc *d, const snell_comparison *out) {
    if (reference == NULL || picture == NULL || out == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_film_compare: an argument is NULL");
    if (d->struct_size != sizeof *d || out->struct_size != sizeof *out)
        return error_set(SNELL_ERR_VERSION, "compile against the library's own header",
                         "snell_film_compare: a struct has another version's size");
    if (!(d->exposure >= -50 && d->exposure <= 50))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "the exposure is not a number from -50 to 50");
    if (!(d->pixels_per_degree >= 1 && d->pixels_per_degree <= 1000))
        return error_set(SNELL_ERR_ARGUMENT, NULL,
                         "pixels_per_degree is not a number from 1 to 1000");
    if (d->variance_count == 1)
        return error_set(SNELL_ERR_ARGUMENT, "2 or more, or 0 for very many",
                         "one value has no variance");
    if (d->error_map != SNELL_ERROR_FLIP && d->error_map != SNELL_ERROR_DIFFERENCE)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "error map %d does not exist",
                         (int)d->error_map);
    const snell_film *inputs[] = {reference, picture, d->reference_variance, d->picture_variance};
    for (int i = 0; i < 4 && d->error; i++)
        if (inputs[i] == d->error)
            return error_set(SNELL_ERR_ARGUMENT, "create another film",
                             "the picture of errors cannot replace what is compared");
    snell_status status = check_sizes(reference, picture, "the picture");
    if (!status && d->reference_variance)
        status = check_sizes(reference, d->reference_variance, "the reference's variance");
    if (!status && d->picture_variance)
        status = check_sizes(reference, d->picture_variance, "the picture's variance");
    return status;
}

snell_status snell_film_compare(const snell_film *reference, const snell_film *picture,
                                const snell_compare_desc *desc, snell_comparison *out) {
    snell_compare_desc defaults = SNELL_INIT(compare_desc);
    if (desc == NULL) desc = &defaults;
    snell_status status = check_compare(reference, picture, desc, out);
    if (status) return status;
    phase compare = {"compare", desc->progress, desc->user};
    const snell_film *variances[2] = {desc->reference_variance, desc->picture_variance};
    film error = {.pixels = NULL};
    compare_options options = {.as_shown = desc->as_shown,
                               .exposure = (double)desc->exposure,
                               .pixels_per_degree = (double)desc->pixels_per_degree,
                               .variance_count = desc->variance_count,
                               .error = desc->error ? &error : NULL,
                               .error_map = desc->error_map,
                               .error_values = desc->error_values,
                               .progress = desc->progress ? report_phase : NULL,
                               .user = &compare};
    for (int i = 0; i < 2; i++) options.variances[i] = variances[i] ? &variances[i]->film : NULL;
    status = tonemap_find(desc->tonemap, &options.map);
    if (!status) status = white_balance_parse(desc->white_balance, &options.white);
    if (status) return status;
    snell_comparison found;
    unsigned saved = floatenv_enter();
    status =
        compare_films(&reference->film, &picture->film, &options, reference->context->pool, &found);
    floatenv_leave(saved);
    if (status) {
        film_free(&error);
        return status;
    }
    *out = found;
    if (desc->error == NULL) return SNELL_OK;
    film_free(&desc->error->film);
    free(desc->error->layers);
    *desc->error = (snell_film){.context = desc->error->context,
                                .film = error,
                                .tonemap = choice_find(TONEMAP_CHOICES, "clip")};
    return SNELL_OK;
}
