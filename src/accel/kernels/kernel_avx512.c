#define TRACE_KERNEL trace_kernel_avx512
#include "accel/kernels/trace.inl"
