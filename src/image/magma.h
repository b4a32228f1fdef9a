/* The colour map magma: black for 0, over purple and orange to a light yellow for 1, in which
 * errors are drawn. */
#ifndef SNELL_IMAGE_MAGMA_H
#define SNELL_IMAGE_MAGMA_H

#include <stdint.h>

void magma_color(double value, uint8_t srgb[3]); /* NaN is 0 */

#endif
