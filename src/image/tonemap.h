/* From linear radiance to the 8-bit values of a screen: exposure, a tone map, the sRGB curve. */
#ifndef SNELL_IMAGE_TONEMAP_H
#define SNELL_IMAGE_TONEMAP_H

#include "base/error.h"
#include "maths/vec.h"

typedef struct tonemap {
    const char *name, *help;
    dvec3 (*map)(dvec3 color); /* linear Rec. 709, >= 0 and finite, to linear, meant for 0..1 */
} tonemap;

extern const tonemap *const tonemaps[]; /* NULL at the end; the first is the default */
/* NULL: the first. Unknown names: SNELL_ERR_ARGUMENT with a suggestion. */
snell_status tonemap_find(const char *name, const tonemap **out);

/* 2^stops. */
double tonemap_exposure(double stops);
/* One pixel: scaled by `scale`, mapped. NaN and negative values count as 0, infinity as very much.
 */
dvec3 tonemap_apply(const tonemap *map, double scale, dvec3 color);
/* The 8-bit sRGB value nearest to a linear one (IEC 61966-2-1, clamped before encoding). */
uint8_t tonemap_quantize(double linear);

#endif
