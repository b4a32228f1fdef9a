/* Which instruction sets this processor has and the operating system saves. */
#ifndef SNELL_SIMD_CPU_H
#define SNELL_SIMD_CPU_H

#include <snell/snell.h>

/* The best that CPUID and XCR0 allow; SNELL_ISA_SCALAR on other processors. */
snell_isa cpu_best_isa(void);

#endif
