/* The parts of the reader that uses libassimp:
 *
 *     assimp.c            the importer, and the files that libassimp may open
 *     assimp_materials.c  materials and textures
 *     assimp_meshes.c     meshes and the node tree
 *
 * libassimp has known faults on hostile files: this code must run in the helper process only. */
#ifndef SNELL_IMPORTERS_ASSIMP_READER_H
#define SNELL_IMPORTERS_ASSIMP_READER_H

#include <assimp/scene.h>

#include "importers/maps.h"
#include "importers/names.h"

typedef struct map_entry { /* textures made before */
    char *path;            /* owned */
    map_use use;
    snell_texture_id id;
} map_entry;

typedef struct reader {
    const char *path; /* as it was typed */
    const import_options *options;
    description *d;
    const struct aiScene *scene;
    char extension[16];  /* ".fbx" */
    char *shown;         /* path with the extension by which libassimp chooses its reader; owned */
    uint32_t *materials; /* per material of the scene: index in the description */
    uint32_t *shapes;    /* per mesh; NO_SHAPE: not drawn */
    map_entry *maps;
    size_t map_count, map_capacity;
    size_t instance_count;
    name_set names;
} reader;
#define NO_SHAPE UINT32_MAX

snell_status reader_warn(reader *r, const char *format, ...) PRINTF_LIKE(2, 3);
snell_status reader_blame(const reader *r, const char *what, snell_status status);
snell_status reader_read_materials(reader *r);
snell_status reader_read_meshes(reader *r);

#endif
