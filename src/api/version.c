/* What this build is. */
#include <snell/snell.h>

const char *snell_version(void) { return SNELL_VERSION_STRING; }
