#include "importers/maps.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

snell_status map_load(const char *base, const char *name, const import_options *options,
                      decoded_image *out) {
    char path[1024];
    snprintf(path, sizeof path, "%s", name);
    for (char *c = path; *c; c++)
        if (*c == '\\') *c = '/';
    uint8_t *data = NULL;
    size_t size = 0;
    snell_status status = import_read_beside(base, path, options, &data, &size);
    const char *last = strrchr(path, '/');
    if (status && last && last[1])
        status = import_read_beside(base, last + 1, options, &data, &size);
    if (!status) status = image_decode(data, size, IMAGE_SIZE_MAX, out);
    free(data);
    return status;
}

static snell_status add(description *d, const char *file, const decoded_image *part,
                        const map_look *look, snell_texture_id *out) {
    size_t size = (size_t)part->width * part->height * part->channels;
    snell_vec3 scale = {look->scale.x == 0 ? 1 : look->scale.x,
                        look->scale.y == 0 ? 1 : look->scale.y, 0};
    const snell_param params[] = {
        {"width", SNELL_PARAM_INT, {.i = part->width}},
        {"height", SNELL_PARAM_INT, {.i = part->height}},
        {"format", SNELL_PARAM_STRING, {.s = image_format_word(part)}},
        {"pixels", SNELL_PARAM_ARRAY, {.array = {part->pixels, size}}},
        {"encoding", SNELL_PARAM_STRING, {.s = look->use == MAP_COLOR ? "srgb" : "linear"}},
        {"wrap_u", SNELL_PARAM_STRING, {.s = look->wrap[0] ? look->wrap[0] : "repeat"}},
        {"wrap_v", SNELL_PARAM_STRING, {.s = look->wrap[1] ? look->wrap[1] : "repeat"}},
        {"channel", SNELL_PARAM_STRING, {.s = look->channel ? look->channel : "rgb"}},
        {"uv_offset", SNELL_PARAM_VEC3, {.v = {look->offset.x, look->offset.y, 0}}},
        {"uv_scale", SNELL_PARAM_VEC3, {.v = scale}},
        {"map", SNELL_PARAM_STRING, {.s = "uv"}},
    };
    uint32_t index;
    snell_status status =
        description_add(d, CATEGORY_TEXTURE, "image", params, sizeof params / sizeof params[0],
                        (object_source){NULL, file, 0}, &index);
    if (!status)
        *out = (snell_texture_id){index + 1, d->objects[CATEGORY_TEXTURE].items[index].generation};
    return status;
}

snell_status map_add(description *d, const char *file, const decoded_image *image,
                     const map_look *look, snell_texture_id *out) {
    decoded_image part;
    snell_status status =
        look->use == MAP_ALPHA ? image_copy_alpha(image, &part) : image_copy_color(image, &part);
    if (status) return status;
    status = add(d, file, &part, look, out);
    image_free(&part);
    return status;
}
