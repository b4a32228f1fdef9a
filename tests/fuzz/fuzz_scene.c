/* A libFuzzer target per reader of scene files: built with -DFORMAT=gltf or pbrt, see tests/CMakeLists.txt. An input is
 * a file; of odd size it is read at its second frame.
 *
 *     cmake --preset asan -B build/fuzz -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DSNELL_FUZZ=ON -DSNELL_SIMD=OFF
 *     cmake --build build/fuzz --target fuzz
 *     build/fuzz/tests/fuzz_gltf -max_len=8192 -max_total_time=60 CORPUS tests/data/gltf tests/data/models
 *     build/fuzz/tests/fuzz_pbrt -max_len=4096 -max_total_time=60 -timeout=20 CORPUS scenes */
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "importers/importer.h"

#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)

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
    snell_status status = import_file(path, TEXT(FORMAT), &options, d);
    if (status == SNELL_ERR_INTERNAL || (status && !error_last()->text[0])) abort();
    description_destroy(d);
    return 0;
}
