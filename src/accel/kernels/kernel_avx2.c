#define TRACE_KERNEL trace_kernel_avx2
#include "accel/kernels/trace.inl"
