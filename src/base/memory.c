#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>

void *memory_resize(void *old, size_t count, size_t size) {
    if (size != 0 && count > SIZE_MAX / size) return NULL;
    size_t bytes = count * size;
    return realloc(old, bytes ? bytes : 1);
}

void *memory_zeroed(size_t count, size_t size) {
    return calloc(count ? count : 1, size ? size : 1);
}

void *memory_aligned(size_t size) {
    /* Large arrays lie on huge pages where the system has them: fewer faults as they are filled,
     * and fewer misses of the TLB as they are read. */
    enum { LARGE = 4 << 20, HUGE_PAGE = 2 << 20 };
    size_t alignment = size >= LARGE ? HUGE_PAGE : 64;
    if (size > SIZE_MAX - alignment) return NULL;
    size_t rounded = (size + 63) & ~(size_t)63;
    void *memory;
    if (posix_memalign(&memory, alignment, rounded ? rounded : 64)) return NULL;
#ifdef MADV_HUGEPAGE
    if (size >= LARGE) madvise(memory, rounded, MADV_HUGEPAGE);
#endif
    return memory;
}

void memory_free_aligned(void *memory) { free(memory); }

char *memory_copy_string(const char *text) {
    size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    if (copy) memcpy(copy, text, size);
    return copy;
}

bool array_grow(void **items, size_t item_size, size_t count, size_t *capacity, size_t extra) {
    if (extra > SIZE_MAX - count) return false;
    size_t needed = count + extra;
    if (needed <= *capacity) return true;
    size_t wanted = *capacity < 8 ? 8 : *capacity + *capacity / 2;
    if (wanted < needed) wanted = needed;
    void *grown = memory_resize(*items, wanted, item_size);
    if (grown == NULL) return false;
    *items = grown;
    *capacity = wanted;
    return true;
}

size_t memory_peak(void) {
    struct rusage usage;
    if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
    return (size_t)usage.ru_maxrss * 1024;
}
