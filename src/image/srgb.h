/* The sRGB transfer function (IEC 61966-2-1). */
#ifndef SNELL_IMAGE_SRGB_H
#define SNELL_IMAGE_SRGB_H

#include <stdbool.h>

#include <snell/snell.h>

double srgb_decode(double encoded); /* 0..1 to linear */
float srgb_to_linear(double shown); /* of a file, cut to 0..1; NaN is 0 */
double srgb_encode(double linear);  /* linear, >= 0, to 0..1 and beyond */
const float *srgb_table(void);      /* srgb_decode(i / 255), i = 0..255 */
const float *unorm_table(void);     /* i / 255 */
/* "#rgb" or "#rrggbb" to linear; false when it is neither. */
bool srgb_read_hex(const char *text, snell_vec3 *out);

#endif
