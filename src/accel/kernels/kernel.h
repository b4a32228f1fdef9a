/* One symbol per instruction set: the kernels compiled for it. */
#ifndef SNELL_ACCEL_KERNELS_KERNEL_H
#define SNELL_ACCEL_KERNELS_KERNEL_H

#include "accel/layout.h"

typedef struct trace_kernel {
    void (*trace)(const accel *a, const ray *rays, hit *hits, size_t count,
                  trace_counters *counters);
    void (*occluded)(const accel *a, const ray *rays, uint8_t *blocked, size_t count,
                     trace_counters *counters);
} trace_kernel;

extern const trace_kernel trace_kernel_scalar;
extern const trace_kernel trace_kernel_avx2;
extern const trace_kernel trace_kernel_avx512;

#endif
