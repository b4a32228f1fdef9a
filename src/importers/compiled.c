/* A compiled scene that another scene names: model { file = "tree.snell" }. */
#include "importers/importer.h"
#include "scene/compiled.h"

static bool recognise(const char *extension, const uint8_t *first, size_t size) {
    (void)extension;
    return compiled_recognise(first, size);
}

const importer importer_compiled = {
    .name = "snell",
    .extensions = ".snell",
    .help = "compiled scenes, which snell convert writes",
    .recognise = recognise,
    .read = compiled_import,
};
