/* Gives a damaged compiled scene the length and checksum that its records have, so that they are looked at: as
 * scene/compiled.c makes them. */
#ifndef SNELL_TESTS_COMPILED_FIX_H
#define SNELL_TESTS_COMPILED_FIX_H

#include <string.h>

#include "sampling/sampling.h"
#include "scene/compiled.h"

/* The offsets of scene/compiled.h. */
enum {
    COMPILED_ORDER = 8,
    COMPILED_VERSION = 12,
    COMPILED_SIZE = 16,
    COMPILED_SUM = 24,
    COMPILED_WRITER = 32
};

static inline void compiled_fix(uint8_t *file, size_t size) {
    if (size < COMPILED_HEADER_SIZE) return;
    uint64_t sum = 0, there = size - COMPILED_HEADER_SIZE;
    for (size_t at = COMPILED_HEADER_SIZE; at + 8 <= size; at += 8) {
        uint64_t word;
        memcpy(&word, file + at, sizeof word);
        sum = hash_mix(sum ^ word) + 1;
    }
    memcpy(file + COMPILED_SIZE, &there, sizeof there);
    memcpy(file + COMPILED_SUM, &sum, sizeof sum);
}

#endif
