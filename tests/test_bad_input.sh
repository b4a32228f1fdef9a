#!/bin/bash
# What must never lose work: each bad input gets a message, its exit code, an end within seconds, and leaves an older
# picture as it was. $1: the build folder.
snell=$(cd "${1:?the build folder}" && pwd)/snell
work=$(mktemp -d) || exit 1
trap 'umount "$work/disk" 2>/dev/null; rm -rf "$work"' EXIT
cd "$work" || exit 1
for name in $(compgen -e SNELL_); do unset "$name"; done
export NO_COLOR=1
failures=0 cases=0

fail() {
    failures=$((failures + 1))
    echo "FAILED: $*"
    sed 's/^/    err: /' err | head -8
}

# refuses WHAT EXIT_CODE MESSAGE ARGUMENT...: an older old.png survives
refuses() {
    local what=$1 code=$2 message=$3 got
    shift 3
    cases=$((cases + 1))
    echo "an older picture" >old.png
    timeout 20 "$snell" "$@" -o old.png >out 2>err
    got=$?
    [ $got -eq "$code" ] || fail "$what: exit $got, not $code"
    grep -qF -- "$message" err || fail "$what: does not say: $message"
    [ "$(cat old.png)" = "an older picture" ] || fail "$what: the older picture is gone"
    [ -z "$(find . -name '*.tmp*' -o -name '.old*')" ] || fail "$what: a temporary file is left"
}

good='camera { from = {0, 0, 5}, at = {0, 0, 0} } light.headlight { intensity = 20 }'
scene() { printf '%s\n' "$@" >bad.lua; }

scene "$good" 'sphere { radus = 1 }'
refuses "an unknown key" 3 "bad.lua:2: sphere: unknown field 'radus'" bad.lua
grep -q "did you mean 'radius'" err || fail "an unknown key: no suggestion"
scene "$good" 'sphere { radius = 1, material = glas }'
refuses "an undefined global" 3 "bad.lua:2:" bad.lua
# what cannot be seen is warned of, and with --strict refused
for nothing in 'mesh { positions = {{0,0,0},{1,0,0},{0,1,0}}, indices = {} }:mesh:2 has no triangles' \
    'mesh { positions = {{0,0,0},{1,2,3},{2,4,6}}, indices = {0,1,2} }:mesh:2 has no triangle with an area' \
    'quadric { square = {1, 1, 1}, constant = 1 }:quadric:2 does not reach into its box' \
    'implicit { f = "x^2 + y^2 + 1", min = {-1,-1,-1}, max = {1,1,1} }:implicit:2 is nowhere below 0 in its box'; do
    scene "$good" "${nothing%%:*}"
    refuses "a shape that is nothing" 4 "bad.lua:2: warning: ${nothing#*:}: nothing of it is drawn" --strict bad.lua
done
scene "$good" 'for i = 1, 20 do quadric { square = {1, 1, 1}, constant = i } end sphere {}'
refuses "many shapes that are nothing" 4 "nothing is drawn of 12 more shapes" --strict bad.lua
scene "$good" 'sphere {} quadric { square = {1, 1, 1}, constant = -1 }' \
    'mesh { positions = {{0,0,0},{1,0,0},{2,0,0},{0,1,0}}, indices = {0,1,2, 0,1,3} }'
"$snell" bad.lua --strict -s 8x8 -o seen.pfm 2>err || fail "what can be seen is refused"
refuses "a missing file" 5 "cannot open 'none.glb'" none.glb
scene "$good" 'sphere { radius = 0/0 }'
refuses "NaN" 3 "bad.lua:2: sphere: 'radius'" bad.lua
scene "$good" 'mesh { positions = {{0,0,0},{1,0,0},{0,1,0}}, indices = {0, 1, 3} }'
refuses "an index out of range" 3 "bad.lua:2: mesh: index 3 of triangle 0 is out of range" bad.lua
scene "$good" 'while true do end'
refuses "an endless loop" 3 "bad.lua:2:" bad.lua
scene "$good" 'while true do pcall(function() while true do end end) end'
refuses "an endless loop in pcall" 3 "bad.lua:2:" bad.lua
{ echo "$good"; printf 'x = '; head -c 100000 /dev/zero | tr '\0' '('; } >bad.lua
refuses "100,000 nested parentheses" 3 "bad.lua:2:" bad.lua

mkdir -p inner
echo secret >secret.ppm
printf '%s\n' "$good" 'mesh { file = "../secret.ply" }' >inner/reads.lua
refuses "a scene that reads outside its folder" 5 "../secret.ply" inner/reads.lua
printf '{"asset":{"version":"2.0"},"buffers":[{"uri":"../secret.ppm","byteLength":36}],"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}' >inner/reads.gltf
refuses "a model that reads outside its folder" 5 "../secret.ppm" inner/reads.gltf
grep -q -- "--allow" err || fail "reading outside: does not name --allow"

printf 'glTF\002\000\000\000\100\000\000\000\050\000\000\000JSON{"asset"' >cut.glb
refuses "a truncated GLB" 3 "cut.glb" cut.glb
printf '{"asset":{"version":"2.0"},\n  "meshes": [' >cut.gltf
refuses "a truncated glTF" 3 "cut.gltf:2" cut.gltf
printf '' >empty.glb
refuses "an empty file" 3 "empty.glb" empty.glb
head -c 4000 /dev/urandom >noise.bin
refuses "a file of noise" 4 "noise.bin" noise.bin

scene "$good" 'sphere { radius = 1 }'
refuses "an absurd size" 2 "1000000000x1" bad.lua --size 1000000000x1
refuses "an unknown tone map" 2 "wrong" bad.lua --tonemap wrong
mkdir -p nothing/inside
touch nothing/picture.png
refuses "a folder without models" 3 "there is no model in this folder" ./nothing

# A full disk: the encoded picture does not fit.
mkdir disk
if [ "$(id -u)" = 0 ] && mount -t tmpfs -o size=32k none disk 2>/dev/null; then
    cases=$((cases + 1))
    echo "an older picture" >disk/old.pfm
    "$snell" bad.lua -s 320x240 -n 1 -o disk/old.pfm >out 2>err
    got=$?
    [ $got -eq 5 ] || fail "a full disk: exit $got, not 5"
    grep -qi "no space" err || fail "a full disk: does not say so"
    [ "$(cat disk/old.pfm)" = "an older picture" ] || fail "a full disk: the older picture is gone"
    [ "$(ls -A disk)" = old.pfm ] || fail "a full disk: a temporary file is left"
else
    echo "a full disk: NOT TESTED (needs root)"
fi

[ $failures -eq 0 ] && { echo "$cases bad inputs refused"; exit 0; }
echo "$failures failures in $cases cases"
exit 1
