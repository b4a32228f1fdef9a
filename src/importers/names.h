/* Unique names: formats let names repeat, a description does not. */
#ifndef SNELL_IMPORTERS_NAMES_H
#define SNELL_IMPORTERS_NAMES_H

#include <jansson.h>

#include "scene/description.h"

enum { NAME_MAX_SIZE = 256, NAME_KINDS = CATEGORY_COUNT + 1, NAMES_INSTANCE = CATEGORY_COUNT };

typedef struct name_set {
    json_t *seen[NAME_KINDS]; /* name -> how often it was asked for; a hash table */
} name_set;

void names_deinit(name_set *names);
/* `wanted` (UTF-8, NULL or "": unnamed), with ".2", ".3", ... where it was taken before; into out,
 * which is NAME_MAX_SIZE bytes. kind: a category or NAMES_INSTANCE. */
snell_status names_make_unique(name_set *names, int kind, const char *wanted, char *out);

#endif
