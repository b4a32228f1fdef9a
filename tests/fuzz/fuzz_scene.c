/* A libFuzzer target per reader of scene files: built with -DFORMAT=gltf and so on, run by tools/fuzz. An input is a
 * file; of odd size it is read at its second frame. A compiled scene (snell) gets the length and checksum that it
 * should have. */
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "../compiled_fix.h"
#include "importers/importer.h"

#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    import_options options = {.memory_max = (uint64_t)64 << 20, .frame = size % 2 ? 2 : 0};
    static int file = -1;
    char path[64];
    uint8_t *copy = malloc(size + 1);
    if (copy == NULL) abort();
    memcpy(copy, data, size);
    if (strcmp(TEXT(FORMAT), "snell") == 0) compiled_fix(copy, size);
    if (file < 0) file = memfd_create("fuzz", 0);
    if (file < 0 || ftruncate(file, 0) || pwrite(file, copy, size, 0) != (ssize_t)size) abort();
    free(copy);
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    description *d;
    if (description_create(&d)) abort();
    snell_status status = import_file(path, TEXT(FORMAT), &options, d);
    if (status == SNELL_ERR_INTERNAL || (status && !error_last()->text[0])) abort();
    description_destroy(d);
    return 0;
}
