#include "simd/cpu.h"

#if defined(__x86_64__)
#include <cpuid.h>
#include <stdatomic.h>

enum {
    LEAF1_C_POPCNT = 1 << 23,
    LEAF1_C_OSXSAVE = 1 << 27,
    LEAF1_C_AVX = 1 << 28,
    LEAF7_B_BMI1 = 1 << 3,
    LEAF7_B_AVX2 = 1 << 5,
    LEAF7_B_BMI2 = 1 << 8,
    LEAF7_B_AVX512F = 1 << 16,
    LEAF7_B_AVX512DQ = 1 << 17,
    LEAF7_B_AVX512BW = 1 << 30,
    EXTENDED1_C_LZCNT = 1 << 5,
    XCR0_AVX = 0x06,   /* XMM and YMM state */
    XCR0_AVX512 = 0xe6 /* and opmask, upper ZMM, ZMM 16 to 31 */
};
#define LEAF7_B_AVX512VL (1u << 31)

static bool all(unsigned word, unsigned bits) { return (word & bits) == bits; }

/* XGETBV without -mxsave. */
static unsigned read_xcr0(void) {
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

static snell_isa detect(void) {
    unsigned a, b, c, d, b7, c1, extended;
    if (!__get_cpuid(1, &a, &b, &c1, &d)) return SNELL_ISA_SCALAR;
    if (!all(c1, LEAF1_C_OSXSAVE | LEAF1_C_AVX | LEAF1_C_POPCNT)) return SNELL_ISA_SCALAR;
    if (!__get_cpuid_count(7, 0, &a, &b7, &c, &d)) return SNELL_ISA_SCALAR;
    if (!__get_cpuid(0x80000001u, &a, &b, &extended, &d)) return SNELL_ISA_SCALAR;
    unsigned xcr0 = read_xcr0();
    if (!all(xcr0, XCR0_AVX) || !all(b7, LEAF7_B_AVX2 | LEAF7_B_BMI1 | LEAF7_B_BMI2) ||
        !all(extended, EXTENDED1_C_LZCNT))
        return SNELL_ISA_SCALAR;
    if (!all(xcr0, XCR0_AVX512) ||
        !all(b7, LEAF7_B_AVX512F | LEAF7_B_AVX512DQ | LEAF7_B_AVX512BW | LEAF7_B_AVX512VL))
        return SNELL_ISA_AVX2;
    return SNELL_ISA_AVX512;
}

snell_isa cpu_best_isa(void) {
    /* Kept, because CPUID is slow under a hypervisor. Threads may find it out twice, equally. */
    static atomic_int known = SNELL_ISA_AUTO;
    int isa = atomic_load_explicit(&known, memory_order_relaxed);
    if (isa == SNELL_ISA_AUTO) {
        isa = (int)detect();
        atomic_store_explicit(&known, isa, memory_order_relaxed);
    }
    return (snell_isa)isa;
}

#else

snell_isa cpu_best_isa(void) { return SNELL_ISA_SCALAR; }

#endif
