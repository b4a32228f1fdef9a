/* The two halves of snell convert: of pictures (convert.c) and of scenes (convert_scene.c). */
#ifndef SNELL_CLI_CONVERT_H
#define SNELL_CLI_CONVERT_H

#include "session.h"

/* Does the path's extension name a kind of scene that is written? */
bool convert_writes_scene(const char *path);
/* Options that only the other half has: exit code. */
int convert_check_options(const options *o, bool scene);
/* The first operand as a scene to the second. Exit code. */
int convert_scene(session *s);

#endif
