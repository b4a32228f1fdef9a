#!/bin/bash
# The scenes that bench/renders measures are written whole for the other renderers. $1: the build folder.
build=$(cd "${1:?the build folder}" && pwd)
top=$(cd "$(dirname "$0")/.." && pwd)
export_scene=$build/bench/export_scene
[ -x "$export_scene" ] || { echo "built without benchmarks: skipped"; exit 0; }
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
failures=0

fail() {
    failures=$((failures + 1))
    echo "FAILED: $*"
}
# written SCENE: exports it into $out
written() {
    out=$work/$1
    mkdir "$out"
    "$export_scene" "$top/scenes/peers/$1.lua" "$out" || fail "$1 is not exported"
}
# lines COUNT PATTERN FILE
lines() {
    local found
    found=$(grep -c -- "$2" "$out/$3")
    [ "$found" = "$1" ] || fail "$3 has $found lines with '$2', not $1"
}
absent() {
    for file; do [ ! -e "$out/$file" ] || fail "$file is written"; done
}

written balls
lines 7381 '^sphere{' scene.pov
lines 7381 '^SPHERE ' scene.dat
lines 7381 '"radius"' scene.json
lines 3 '^light_source' scene.pov
lines 1 ', "mirror": 0.5, ' scene.json

written glass
lines 5 '^sphere{.*interior{ior 1.5}' scene.pov
lines 1 '^mesh2{vertex_vectors{1802,' scene.pov
lines 1 '^normal_vectors{1802,' scene.pov
lines 1 '^face_indices{3600,.*interior{ior 1.5}' scene.pov
lines 1 '^plane{.*translate <0,0,5e-05>' scene.pov
lines 1 'element face 3600' mesh-0.ply
absent scene.dat mesh-1.ply

written cornell
lines 1 '"corner": .*"radiance": \[17, 12, 4\]' scene.json
lines 15 '"mesh": ' scene.json
absent scene.pov scene.dat mesh-15.ply
[ "$(stat -c %s "$out/mesh-14.ply")" = 243 ] || fail "mesh-14.ply is cut off"

# What the others lack is refused.
for line in 'torus {}' 'sphere { material = material.ggx {} }' 'group { sphere {} }'; do
    { echo 'camera {} render { width = 8, height = 8, max_depth = 1 } background {}'; echo "$line"; } >"$work/odd.lua"
    "$export_scene" "$work/odd.lua" "$work" 2>"$work/err" && fail "exported: $line"
    grep -q '^export_scene: ' "$work/err" || fail "no message for: $line"
done

[ "$failures" -eq 0 ] && echo "the scenes of bench/renders: all as expected"
exit $((failures > 0))
