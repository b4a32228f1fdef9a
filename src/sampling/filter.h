/* Pixel filters, by importance: a sample's place is drawn from the filter's shape, so that every
 * sample counts the same and belongs to one pixel. Only filters without negative parts can be drawn
 * from. Two dimensions are two draws: all are products. */
#ifndef SNELL_SAMPLING_FILTER_H
#define SNELL_SAMPLING_FILTER_H

#include "sampling/warp.h"

#define FILTER_CHOICES "box|tent|gaussian|blackman-harris"
#define FILTER_RADIUS_MAX 16 /* pixels */

typedef struct pixel_filter {
    int kind;            /* index into FILTER_CHOICES */
    double radius;       /* pixels */
    distribution1 table; /* of the shape over [-1, 1], where it has no simple inverse */
} pixel_filter;

/* radius 0: the filter's own. false: no memory. */
bool pixel_filter_create(int kind, double radius, pixel_filter *out);
void pixel_filter_free(pixel_filter *f);
/* Pixels from the pixel's centre; the box of radius 1/2 gives s - 1/2 exactly. */
double pixel_filter_offset(const pixel_filter *f, double s);

#endif
