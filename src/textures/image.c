/* An image over u, v: (0, 0) is the corner of the first pixel of the last row (v points up), 1 the
 * far edge.
 *
 * Seen from close by, or where the footprint is unknown, it is bilinear; from afar trilinear in mip
 * maps (Williams, Pyramidal Parametrics, 1983): the footprint's longer side, in pixels, is that of a
 * pixel of the level. It is as wide in the other direction too: a floor towards the horizon is
 * smoother than it would have to be, and never aliases. */
#include "textures/texture.h"

#include <string.h>

#include "base/error.h"
#include "image/srgb.h"
#include "maths/functions.h"
#include "textures/mipmap.h"

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
    F(T, filter, CHOICE, DEFAULT(0), CHOICES("linear|nearest"), "",                                \
      "between pixels; linear: by mip maps from afar, too")                                        \
    F(T, map, CHOICE, DEFAULT(0), CHOICES(MAP_CHOICES), "",                                        \
      "what u and v are; auto: the shape's, else object")                                          \
    F(T, uv_offset, VEC2, DEFAULT(0, 0), ANY, "", "added to u, v after scale and rotation")        \
    F(T, uv_scale, VEC2, DEFAULT(1, 1), ANY, "", "u, v are multiplied by this first")              \
    F(T, uv_rotation, FLOAT, DEFAULT(0), ANY, "rad", "then turned by this angle, counter-clockwise")
DESCRIBE(image, IMAGE_FIELDS)

enum { RGBA8, RGB8, GRAY8, RGBA32F };
enum { SRGB, LINEAR };
enum { WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR };
enum { FILTER_LINEAR, FILTER_NEAREST };
#define LN2 0.69314718055994530942
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

static texel fetch(const image_desc *image, const mip_level *level, int64_t x, int64_t y) {
    x = wrap_index(x, level->width, image->wrap_u);
    y = wrap_index(y, level->height, image->wrap_v);
    size_t index = (size_t)y * level->width + (size_t)x;
    if (image->format == RGBA32F) {
        const float *p = (const float *)level->pixels + 4 * index;
        return (texel){{(double)p[0], (double)p[1], (double)p[2]}, (double)p[3]};
    }
    const uint8_t *p = (const uint8_t *)level->pixels + pixel_sizes[image->format] * index;
    const float *decode = image->encoding == SRGB ? srgb_table() : unorm_table();
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

/* u, v and the footprint as the image has them: scaled, turned, moved; v down; 1 is the far edge. */
static map_point place(const image_desc *image, const map_point *at) {
    double su = (double)image->uv_scale.x, sv = (double)image->uv_scale.y;
    map_point p = {at->u * su,    at->v * sv,    at->dudx * su,
                   at->dvdx * sv, at->dudy * su, at->dvdy * sv};
    if (image->uv_rotation != 0) {
        double c = fn_cos((double)image->uv_rotation), s = fn_sin((double)image->uv_rotation);
        p = (map_point){c * p.u - s * p.v,       s * p.u + c * p.v,       c * p.dudx - s * p.dvdx,
                        s * p.dudx + c * p.dvdx, c * p.dudy - s * p.dvdy, s * p.dudy + c * p.dvdy};
    }
    p.u += (double)image->uv_offset.x;
    p.v = 1 - (p.v + (double)image->uv_offset.y);
    return p;
}

/* Far outside, a coordinate says nothing any more; this keeps the conversion to integers defined. */
static double tame(double x) { return fabs(x) < 0x1p40 ? x : 0; }

static texel bilinear(const image_desc *image, const mip_level *level, const map_point *at) {
    double x = tame(at->u * level->width), y = tame(at->v * level->height);
    double left = floor(x - 0.5), top = floor(y - 0.5), fx = x - 0.5 - left, fy = y - 0.5 - top;
    int64_t i = (int64_t)left, j = (int64_t)top;
    texel upper = blend(fetch(image, level, i, j), fetch(image, level, i + 1, j), fx);
    texel lower = blend(fetch(image, level, i, j + 1), fetch(image, level, i + 1, j + 1), fx);
    return blend(upper, lower, fy);
}

static void size(const void *desc, uint32_t *width, uint32_t *height) {
    *width = (uint32_t)((const image_desc *)desc)->width;
    *height = (uint32_t)((const image_desc *)desc)->height;
}

/* The square of the footprint's longer side, in pixels of the image. */
static double footprint_square(const image_desc *image, const map_point *at) {
    double w = image->width, h = image->height;
    double ux = at->dudx * w, vx = at->dvdx * h, uy = at->dudy * w, vy = at->dvdy * h;
    return double_max(ux * ux + vx * vx, uy * uy + vy * vy);
}

static texel trilinear(const image_desc *image, const mipmap *maps, const map_point *at) {
    double square = footprint_square(image, at), last = maps->count - 1;
    if (!(square > 1)) return bilinear(image, &maps->levels[0], at);
    double level = fn_log(square) * (0.5 / LN2);
    if (!(level < last)) return bilinear(image, &maps->levels[maps->count - 1], at);
    double finer = floor(level);
    const mip_level *l = &maps->levels[(uint32_t)finer];
    return blend(bilinear(image, l, at), bilinear(image, l + 1, at), level - finer);
}

static texel look_up(const texture *t, const map_point *point) {
    const image_desc *image = t->desc;
    map_point at = place(image, point);
    mip_level whole = {(uint32_t)image->width, (uint32_t)image->height, image->pixels};
    texel seen;
    if (image->filter == FILTER_NEAREST) {
        double x = tame(at.u * whole.width), y = tame(at.v * whole.height);
        seen = fetch(image, &whole, (int64_t)floor(x), (int64_t)floor(y));
    } else if (t->state) {
        seen = trilinear(image, t->state, &at);
    } else {
        seen = bilinear(image, &whole, &at);
    }
    return pick_channel(seen, image->channel);
}

static texel evaluate(const texture *t, const texture_point *point) {
    return texture_through_map(t, point, look_up);
}

static bool filters(const void *desc) {
    const image_desc *image = desc;
    return image->filter == FILTER_LINEAR && (image->width > 1 || image->height > 1);
}

static snell_status prepare(const void *desc, void **state) {
    const image_desc *image = desc;
    static const uint32_t channels[] = {[RGBA8] = 4, [RGB8] = 3, [GRAY8] = 1, [RGBA32F] = 4};
    if (!filters(desc)) return SNELL_OK;
    mip_format format = {channels[image->format], image->format == RGBA32F,
                         image->format != RGBA32F && image->encoding == SRGB};
    mipmap *made = NULL;
    snell_status status = mipmap_create(image->pixels, (uint32_t)image->width,
                                        (uint32_t)image->height, format, &made);
    *state = made;
    return status;
}

static void destroy(void *state) { mipmap_destroy(state); }
static size_t state_size(const void *state) { return ((const mipmap *)state)->bytes; }

const texture_type texture_image = {
    .info = TYPE_INFO(CATEGORY_TEXTURE, image, "image", "an image over the surface"),
    .check = check,
    .prepare = prepare,
    .destroy = destroy,
    .state_size = state_size,
    .filters = filters,
    .evaluate = evaluate,
    .size = size,
};
