#!/usr/bin/env bash
# Frames of an animated model by the command: names of files, one point of view for all, what is refused.
set -u
snell=$(cd "$1" && pwd)/snell
models=$(cd "$(dirname "$0")/data/gltf" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
for name in $(compgen -e SNELL_); do unset "$name"; done
failed=0
fail() { echo "FAILED: $*"; failed=1; }

# In `second` a triangle on the right leaps up by 7 m at frame 7; on the left all stays, and so does the camera.
"$snell" render "$models/animated.gltf" -D animation=second --frames 5..7 --view front --light none --background '#fff' \
    --size 40x30 -n 1 -o film.ppm -q 2>err || fail "it does not render: $(cat err)"
left() { tail -c 3600 "$1" | od -An -v -tu1 -w120 | cut -c1-240; }
[ -s film.0005.ppm ] && [ -s film.0007.ppm ] || fail "no film.0005.ppm and film.0007.ppm"
cmp -s film.0005.ppm film.0007.ppm && fail "nothing moves"
left film.0005.ppm | grep -q ' 0   0   0 ' || fail "nothing is to be seen on the left"
[ "$(left film.0005.ppm)" = "$(left film.0007.ppm)" ] || fail "the camera moves from frame to frame"

"$snell" info "$models/animated.gltf" -D animation=2 --frame 3 >out 2>err || fail "info: $(cat err)"
grep -q '^animation   frames 1 to 7, 24 a second; this is frame 3$' out || fail "info does not tell the frames"
grep -q 'animation=2  (string, default first)  1 first (2 s, frames 1 to 49), 2 second (0.25 s, frames 1 to 7)' out ||
    fail "info does not list the animations"

asked() { # exit code, part of the message, arguments of info
    "$snell" info "${@:3}" >out 2>err
    code=$?
    [ $code = "$1" ] || fail "info ${*:3}: exit code $code, not $1"
    [ -z "$2" ] || grep -qF -- "$2" err || fail "info ${*:3}: $(cat err)"
}
asked 2 'has frames 1 to 49' "$models/animated.gltf" --frame 50
asked 2 "there is no animation 'jump'" "$models/animated.gltf" -D animation=jump
asked 2 'has no frames' "$models/uvs.gltf" --frame 1
asked 2 'takes no values' "$models/uvs.gltf" -D fps=30

cat >walk.lua <<EOT
animation { fps = 10, first = 1, last = 9 }
local m = model { file = "$models/animated.gltf", animation = "second" }
EOT
asked 0 '' walk.lua --allow "$models" --frame 4 # 0.3 s: the triangle has leapt
grep -q 'to  6 8 ' out || fail "a model does not follow the scene's clock: $(grep bounds out)"
asked 0 '' walk.lua --allow "$models" --frame 2
grep -q 'to  6 2 ' out || fail "a model does not follow the scene's clock: $(grep bounds out)"
exit $failed
