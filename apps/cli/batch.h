/* What is rendered: the files that were named, and the models in the folders that were. */
#ifndef SNELL_CLI_BATCH_H
#define SNELL_CLI_BATCH_H

#include "options.h"

typedef struct batch {
    options options; /* those given, but the operands are files */
    bool *whole;     /* of each: {name} keeps its extension, since another has the same without */
    char **owned;
    size_t owned_count, folders, others; /* others: files in the folders that are no models */
} batch;

/* Exit code; to be freed whatever that is. A folder's models come by name; its own folders are not
 * looked into. A folder without models is an error. */
int batch_open(const options *o, batch *out);
void batch_free(batch *b);

#endif
