#!/usr/bin/env bash
# tools/check_layers passes on this tree and sees each kind of include that points the wrong way.
set -u
here=$(cd "$(dirname "$0")/.." && pwd)
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
failures=0

fail() { echo "FAILED: $*"; failures=$((failures + 1)); }

# plant FILE LINE: a fresh copy of the tree, with a file of the test's own in some rooms and LINE in FILE.
plant() {
    rm -rf "$copy/tree"
    mkdir -p "$copy/tree/apps"
    cp -r "$here/src" "$here/include" "$copy/tree/"
    [ ! -d "$here/apps" ] || cp -r "$here/apps" "$copy/tree/"
    local planted
    for planted in src/simd/planted.h src/render/planted.h apps/other/planted.h "$1"; do
        mkdir -p "$copy/tree/$(dirname "$planted")"
        : >>"$copy/tree/$planted"
    done
    printf '%s\n' "$2" >>"$copy/tree/$1"
}

# expect WHY FILE LINE: with LINE in FILE the check fails and says WHY.
expect() {
    local why=$1 file=$2 line=$3 out
    plant "$file" "$line"
    if out=$("$here/tools/check_layers" "$copy/tree"); then
        fail "$file with '$line' passed"
    elif ! grep -qF "$file:" <<<"$out" || ! grep -qF "$why" <<<"$out"; then
        fail "$file with '$line' gave: $out"
    fi
}

# allow FILE LINE: with LINE in FILE the check passes.
allow() {
    local file=$1 line=$2 out
    plant "$file" "$line"
    out=$("$here/tools/check_layers" "$copy/tree") || fail "$file with '$line' gave: $out"
}

"$here/tools/check_layers" "$here" || fail "this tree breaks its own rule"

expect "base may not include maths" src/base/wrong.h '#include "maths/vec.h"'
expect "base may not include maths" src/base/wrong.h '#include <maths/vec.h>'
expect "base may not include maths" src/base/wrong.h '  #  include "../maths/vec.h"'
expect "maths may not include simd" src/maths/wrong.h '#include "simd/planted.h"'
expect "geometry may not include accel" src/geometry/wrong.c '#include "accel/accel.h"'
expect "accel may not include scene" src/accel/kernels/wrong.inl '#include "scene/records.h"'
expect "no such file" src/base/wrong.h '#include "base/nowhere.h"'
expect "cannot be checked" src/base/wrong.h '#include SOME_HEADER'
expect "not in src/LAYERS" src/cellar/wrong.h '#include <math.h>'
expect "may include only <snell/snell.h>" apps/cli/wrong.c '#include "base/error.h"'
expect "may include only <snell/snell.h>" apps/viewer/wrong.c '#include "../../src/base/error.h"'
expect "not of its own folder" apps/viewer/wrong.c '#include "../other/planted.h"'
expect "the import helper may not include render" apps/import/wrong.c '#include "render/planted.h"'
expect "no such public header" apps/cli/wrong.c '#include <snell/secret.h>'

allow src/api/right.c '#include "importers/importer.h"'
allow src/base/right.c '#include <snell/snell.h>'
allow apps/cli/right.c '#include <snell/snell.h>'
allow apps/import/right.c '#include "importers/importer.h"'
allow apps/import/right.c '#include "scene/description.h"'

[ "$failures" -eq 0 ] && echo "test_layers: passed"
exit "$((failures > 0))"
