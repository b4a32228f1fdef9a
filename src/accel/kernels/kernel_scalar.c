#define TRACE_KERNEL trace_kernel_scalar
#include "accel/kernels/trace.inl"
