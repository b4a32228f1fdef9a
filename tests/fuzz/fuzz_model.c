/* A libFuzzer target per reader of model files: built with -DREADER=ply and so on, run by tools/fuzz. What follows
 * "@@" in the input of fuzz_obj is the material library "m". */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "importers/importer.h"

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define READER_IMPORTER JOIN(importer_, READER)
extern const importer READER_IMPORTER;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static char folder[64], model[96], library[96];

static void clean_up(void) {
    unlink(model);
    unlink(library);
    rmdir(folder);
}

static void set_up(void) {
    snprintf(folder, sizeof folder, "%s/snell_fuzz_%d",
             access("/dev/shm", W_OK) ? "/tmp" : "/dev/shm", (int)getpid());
    snprintf(model, sizeof model, "%s/model", folder);
    snprintf(library, sizeof library, "%s/m", folder);
    if (mkdir(folder, 0700) != 0 || atexit(clean_up) != 0) abort();
}

static void put(const char *path, const uint8_t *data, size_t size) {
    FILE *file = fopen(path, "wb");
    if (file == NULL || fwrite(data, 1, size, file) != size || fclose(file) != 0) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const import_options options = {.memory_max = (uint64_t)256 << 20};
    if (folder[0] == 0) set_up();
    bool is_obj = strcmp(READER_IMPORTER.name, "obj") == 0;
    const uint8_t *mark = is_obj && size ? memmem(data, size, "@@", 2) : NULL;
    size_t first = mark ? (size_t)(mark - data) : size;
    put(model, data, first);
    if (mark) put(library, mark + 2, size - first - 2);
    description *d;
    if (description_create(&d)) abort();
    error_clear();
    snell_status status = READER_IMPORTER.read(model, &options, d);
    /* Silence is an error too. */
    if (status ? error_last()->text[0] == 0 || status == SNELL_ERR_INTERNAL
               : d->instance_count == 0)
        abort();
    description_destroy(d);
    return 0;
}
