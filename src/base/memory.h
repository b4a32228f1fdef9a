/* Memory that callers check: NULL means none left. An array grows by doubling. */
#ifndef SNELL_BASE_MEMORY_H
#define SNELL_BASE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

/* Like realloc(old, count * size) with the product checked; 64-byte alignment is not promised. */
void *memory_resize(void *old, size_t count, size_t size);
void *memory_zeroed(size_t count, size_t size);
/* Aligned to 64 bytes (a cache line, an AVX-512 register), uninitialised, and on huge pages where it is large;
 * free with memory_free_aligned or free. */
void *memory_aligned(size_t size);
void memory_free_aligned(void *memory);
char *memory_copy_string(const char *text); /* NULL when out of memory */

/* Makes room for `extra` more items: ARRAY_GROW(items, count, capacity, extra) is false when out of
 * memory. */
#define ARRAY_GROW(items, count, capacity, extra)                                                  \
    array_grow((void **)&(items), sizeof *(items), (count), &(capacity), (extra))
bool array_grow(void **items, size_t item_size, size_t count, size_t *capacity, size_t extra);

size_t memory_peak(void); /* bytes, the process's largest resident size; 0 when unknown */

#endif
