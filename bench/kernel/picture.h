/* A picture of a scene of the kernel benchmark, by its own rays: lit by its light, with shadows, and
 * a little from everywhere. */
#ifndef SNELL_BENCH_KERNEL_PICTURE_H
#define SNELL_BENCH_KERNEL_PICTURE_H

#include "subject.h"

/* size: a multiple of 8; path: .ppm, or another format that snell writes. */
void picture_write(const subject *s, uint32_t size, const char *path);

#endif
