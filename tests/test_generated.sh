#!/usr/bin/env bash
# The generated part of the public header, and its implementation, are what the types' tables say; and
# the header needs nothing that a build makes.
cd "$(dirname "$0")/.." || exit 1
printf '#include <snell/snell.h>\nint main(void) { return 0; }\n' |
    "${CC:-cc}" -std=c17 -Wall -Wextra -Werror -I include -fsyntax-only -x c - || exit 1
exec tools/update_api --check "$1"
