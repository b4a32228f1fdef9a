/* The walls around an importer: limits of the process, Landlock for files, seccomp for system
 * calls. Entered once, before the scene's file is looked at; there is no way back. */
#ifndef SNELL_IMPORT_SANDBOX_H
#define SNELL_IMPORT_SANDBOX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct sandbox_options {
    const char *file;         /* may be read, and everything in its folder and below */
    const char *const *allow; /* folders that may be read too */
    size_t allow_count;
    uint64_t memory_max; /* bytes besides what the program itself takes; 0: no limit */
    uint64_t time_max;   /* CPU seconds; 0: no limit */
} sandbox_options;

/* What could not be had on this machine: "" when everything stands, else such as "Landlock". */
const char *sandbox_enter(const sandbox_options *options);

#endif
