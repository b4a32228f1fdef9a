/* An image over u, v: (0, 0) is the corner of the first pixel of the last row (v points up), 1 the
 * far edge. */
#include "textures/texture.h"

#include <string.h>

#include "base/error.h"
#include "image/srgb.h"
#include "maths/functions.h"

/* pixels: rows, top first, interleaved; format says how many bytes each. */
#define IMAGE_FIELDS(F, T)                                                                         \
    F(T, width, INT, NO_DEFAULT, REQUIRED_RANGE(1, 65536), "pixels", "columns")                    \
    F(T, height, INT, NO_DEFAULT, REQUIRED_RANGE(1, 65536), "pixels", "rows")                      \
    F(T, format, CHOICE, DEFAULT(0), CHOICES("rgba8|rgb8|gray8|rgba32f"), "",                      \
      "of pixels, rows top first")                                                                 \
    F(T, pixels, BYTES, NO_DEFAULT, REQUIRED, "", "the image's bytes")                             \
    F(T, encoding, CHOICE, DEFAULT(0), CHOICES("srgb|linear"), "",                                 \
      "of 8-bit colours; floats are linear")                                                       \
    F(T, channel, CHOICE, DEFAULT(0), CHOICES("rgb|r|g|b|a"), "",                                  \
      "one channel as grey, or the colour")                                                        \
    F(T, wrap_u, CHOICE, DEFAULT(0), CHOICES("repeat|clamp|mirror"), "", "beyond 0..1 along u")    \
    F(T, wrap_v, CHOICE, DEFAULT(0), CHOICES("repeat|clamp|mirror"), "", "beyond 0..1 along v")    \
    F(T, filter, CHOICE, DEFAULT(0), CHOICES("linear|nearest"), "", "between pixels")              \
    F(T, map, CHOICE, DEFAULT(0), CHOICES(MAP_CHOICES), "",                                        \
      "what u and v are; auto: the shape's, else object")                                          \
    F(T, uv_offset, VEC2, DEFAULT(0, 0), ANY, "", "added to u, v after scale and rotation")        \
    F(T, uv_scale, VEC2, DEFAULT(1, 1), ANY, "", "u, v are multiplied by this first")              \
    F(T, uv_rotation, FLOAT, DEFAULT(0), ANY, "rad", "then turned by this angle, counter-clockwise")
DESCRIBE(image, IMAGE_FIELDS)

enum { RGBA8, RGB8, GRAY8, RGBA32F };
enum { WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR };
static const size_t pixel_sizes[] = {[RGBA8] = 4, [RGB8] = 3, [GRAY8] = 1, [RGBA32F] = 16};

static snell_status check(const void *desc) {
    const image_desc *image = desc;
    size_t needed = (size_t)image->width * (size_t)image->height * pixel_sizes[image->format];
    if (image->pixels_count != needed)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "image: %d x %d pixels need %zu bytes, not %zu",
                         image->width, image->height, needed, image->pixels_count);
    size_t floats = image->format == RGBA32F ? needed / sizeof(float) : 0;
    for (size_t i = 0; i < floats; i++) {
        float value; /* the caller's bytes may lie anywhere */
        memcpy(&value, (const char *)image->pixels + i * sizeof value, sizeof value);
        if (!(isfinite(value) && value >= 0))
            return error_set(SNELL_ERR_ARGUMENT, NULL,
                             "image: pixel %zu is not a finite number, 0 or more", i / 4);
    }
    return SNELL_OK;
}

/* The pixel number in 0..size-1 for any integer. */
static int64_t wrap_index(int64_t i, int64_t size, int wrap) {
    if (wrap == WRAP_CLAMP) return i < 0 ? 0 : i >= size ? size - 1 : i;
    int64_t period = wrap == WRAP_MIRROR ? 2 * size : size;
    i %= period;
    if (i < 0) i += period;
    return i < size ? i : period - 1 - i;
}

static texel fetch(const image_desc *image, int64_t x, int64_t y) {
    x = wrap_index(x, image->width, image->wrap_u);
    y = wrap_index(y, image->height, image->wrap_v);
    size_t index = (size_t)y * (size_t)image->width + (size_t)x;
    if (image->format == RGBA32F) {
        const float *p = (const float *)image->pixels + 4 * index;
        return (texel){{(double)p[0], (double)p[1], (double)p[2]}, (double)p[3]};
    }
    const uint8_t *p = (const uint8_t *)image->pixels + pixel_sizes[image->format] * index;
    const float *decode = image->encoding == 0 ? srgb_table() : unorm_table();
    if (image->format == GRAY8)
        return (texel){{(double)decode[p[0]], (double)decode[p[0]], (double)decode[p[0]]}, 1};
    double alpha = image->format == RGBA8 ? (double)unorm_table()[p[3]] : 1;
    return (texel){{(double)decode[p[0]], (double)decode[p[1]], (double)decode[p[2]]}, alpha};
}

static texel blend(texel a, texel b, double t) {
    return (texel){dvec3_add(dvec3_scale(a.color, 1 - t), dvec3_scale(b.color, t)),
                   a.alpha * (1 - t) + b.alpha * t};
}

static texel pick_channel(texel t, int channel) {
    double grey[] = {0, t.color.x, t.color.y, t.color.z, t.alpha};
    if (channel == 0) return t;
    return (texel){{grey[channel], grey[channel], grey[channel]}, t.alpha};
}

static texel evaluate(const void *desc, const texture_point *point) {
    const image_desc *image = desc;
    vec2 uv = texture_map(image->map, point);
    double u = (double)uv.x * (double)image->uv_scale.x,
           v = (double)uv.y * (double)image->uv_scale.y;
    if (image->uv_rotation != 0) {
        double c = fn_cos((double)image->uv_rotation), s = fn_sin((double)image->uv_rotation),
               turned = c * u - s * v;
        v = s * u + c * v;
        u = turned;
    }
    double x = (u + (double)image->uv_offset.x) * image->width,
           y = (1 - (v + (double)image->uv_offset.y)) * image->height;
    /* Far outside, a coordinate says nothing any more; this keeps the conversion to integers
     * defined. */
    if (!(fabs(x) < 0x1p40)) x = 0;
    if (!(fabs(y) < 0x1p40)) y = 0;
    if (image->filter == 1)
        return pick_channel(fetch(image, (int64_t)floor(x), (int64_t)floor(y)), image->channel);
    double left = floor(x - 0.5), top = floor(y - 0.5), fx = x - 0.5 - left, fy = y - 0.5 - top;
    int64_t i = (int64_t)left, j = (int64_t)top;
    texel upper = blend(fetch(image, i, j), fetch(image, i + 1, j), fx);
    texel lower = blend(fetch(image, i, j + 1), fetch(image, i + 1, j + 1), fx);
    return pick_channel(blend(upper, lower, fy), image->channel);
}

static void size(const void *desc, uint32_t *width, uint32_t *height) {
    *width = (uint32_t)((const image_desc *)desc)->width;
    *height = (uint32_t)((const image_desc *)desc)->height;
}

const texture_type texture_image = {
    .info = TYPE_INFO(CATEGORY_TEXTURE, image, "image", "an image over the surface"),
    .check = check,
    .evaluate = evaluate,
    .size = size,
};
