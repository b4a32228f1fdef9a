/* Damaged files, the same in every run. */
#ifndef SNELL_TESTS_MUTANTS_H
#define SNELL_TESTS_MUTANTS_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

static inline uint64_t random_next(uint64_t *state) { /* xorshift64* */
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 2685821657736338717u;
}

/* Overwrites one to four places with a random byte or a word that readers may stumble over. */
static inline void mutate(uint8_t *data, size_t size, uint64_t *seed) {
    static const char *const words[] = {"-1",   "0",  "1e308", "99999999999",
                                        "null", "[]", "{}",    "5121"};
    for (uint64_t n = 1 + random_next(seed) % 4; n > 0; n--) {
        size_t at = random_next(seed) % size;
        if (random_next(seed) % 2) {
            data[at] = (uint8_t)random_next(seed);
            continue;
        }
        const char *word = words[random_next(seed) % 8];
        size_t length = strlen(word);
        if (at + length <= size) memcpy(data + at, word, length);
    }
}

/* The same for texts: besides, pieces are doubled, left out or swapped. data has room for `room` bytes; returns
 * the new size. */
static inline size_t mutate_text(uint8_t *data, size_t size, size_t room, uint64_t *seed) {
    static const char *const words[] = {"nan", "-0",   "/",     "//",
                                        "\n",  "\\\n", "1e-40", " 4294967296 "};
    if (random_next(seed) % 2) mutate(data, size, seed);
    for (uint64_t n = random_next(seed) % 3; n > 0; n--) {
        size_t at = random_next(seed) % size, length = random_next(seed) % 40;
        const char *word = words[random_next(seed) % 8];
        if (at + length > size) length = size - at;
        switch (random_next(seed) % 3) {
        case 0: /* again, further on */
            if (size + length > room) break;
            memmove(data + at + length, data + at, size - at);
            size += length;
            break;
        case 1:
            if (length == size) break;
            memmove(data + at, data + at + length, size - at - length);
            size -= length;
            break;
        default:
            if (at + strlen(word) <= size) memcpy(data + at, word, strlen(word));
        }
    }
    return size;
}

#endif
