/* libFuzzer's door to the glTF reader: an input is a .gltf or .glb file, seen at rest, or at its second
 * frame if its size is odd. With clang:
 *
 *     cmake -S . -B build/fuzz -DCMAKE_C_COMPILER=clang -DSNELL_FUZZ=ON -DSNELL_SANITIZE=address,undefined
 *     cmake --build build/fuzz --target fuzz_gltf
 *     build/fuzz/tests/fuzz_gltf -max_len=8192 CORPUS tests/data/gltf tests/data/models */
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "importers/importer.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    import_options options = {.memory_max = (uint64_t)64 << 20, .frame = size % 2 ? 2 : 0};
    static int file = -1;
    char path[64];
    if (file < 0) file = memfd_create("fuzz", 0);
    if (file < 0 || ftruncate(file, 0) || pwrite(file, data, size, 0) != (ssize_t)size) abort();
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    description *d;
    if (description_create(&d)) abort();
    snell_status status = import_file(path, "gltf", &options, d);
    if (status == SNELL_ERR_INTERNAL || (status && !error_last()->text[0])) abort();
    description_destroy(d);
    return 0;
}
