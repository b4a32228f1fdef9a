/* Which way is up: formats differ, snell's +Y does not. */
#ifndef SNELL_IMPORTERS_UP_H
#define SNELL_IMPORTERS_UP_H

#include "maths/vec.h"

/* The rotation that takes the named axis ("x" .. "-z") to +Y. NULL and unknown words give false and
 * the identity. */
bool import_up_rotation(const char *axis, transform *out);

#endif
