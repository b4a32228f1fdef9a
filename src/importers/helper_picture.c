/* The parent's side of a picture: the block that snell-import sent becomes a film. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/picture.h"

enum { SIDE_MAX = 65536, NAMES_SIZE_MAX = 1 << 16 };

static snell_status refused(void) {
    return error_set(SNELL_ERR_SYNTAX, NULL, "the reader's picture is not as it should be");
}

static bool is_fine(const picture_header *h, size_t size) {
    if (memcmp(h->magic, PICTURE_MAGIC, sizeof h->magic) != 0 || h->zero != 0 || h->damaged > 1)
        return false;
    if (h->width - 1 >= SIDE_MAX || h->height - 1 >= SIDE_MAX || h->names_size > NAMES_SIZE_MAX)
        return false;
    if (h->channels < 3 || h->channels > 4) return false;
    if (h->encoded_bits != 0 && h->encoded_bits != 8 && h->encoded_bits != 16) return false;
    uint64_t names = h->names_size + (-h->names_size & 7);
    return size == sizeof *h + names + (uint64_t)h->width * h->height * h->channels * 4;
}

/* Names are text, each ends with a 0 byte, and what they hold may be shown. */
static snell_status take_names(const char *text, size_t size, char **out) {
    *out = NULL;
    if (size == 0) return SNELL_OK;
    if (text[size - 1] != '\0') return refused();
    char *names = memory_resize(NULL, size + 1, 1); /* an empty name ends the list */
    if (names == NULL) return error_no_memory();
    for (size_t i = 0; i < size; i++) {
        unsigned char c = (unsigned char)text[i];
        names[i] = c != 0 && (c < ' ' || c == 0x7f) ? '?' : text[i];
    }
    names[size] = '\0';
    *out = names;
    return SNELL_OK;
}

snell_status picture_take(void *user, const void *data, size_t size) {
    helper_picture *out = user;
    picture_header h;
    if (size < sizeof h) return refused();
    memcpy(&h, data, sizeof h);
    if (!is_fine(&h, size)) return refused();
    const char *at = (const char *)data + sizeof h;
    film taken = {.pixels = NULL};
    char *names;
    snell_status status = take_names(at, (size_t)h.names_size, &names);
    if (!status) status = film_resize(&taken, h.width, h.height, h.channels);
    if (status) {
        free(names);
        return status;
    }
    size_t pixels_size = (size_t)h.width * h.height * h.channels * sizeof(float);
    memcpy(taken.pixels, (const char *)data + size - pixels_size, pixels_size);
    taken.encoded_bits = h.encoded_bits;
    film_free(&out->film);
    free(out->layers);
    *out = (helper_picture){taken, names, h.damaged != 0};
    return SNELL_OK;
}

snell_status helper_read_picture(const char *path, const helper_options *options,
                                 helper_picture *out) {
    return helper_run(path, options, picture_take, out);
}
