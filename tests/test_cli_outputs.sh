#!/bin/bash
# Finished pictures: formats, looks, animations, turntables, cameras, folders. $1: the build folder.
. "$(dirname "$0")/cli.sh"
prints_by=E
has() { command -v "$1" >/dev/null || { echo "NOT TESTED: there is no $1"; return 1; }; }

cat >my.lua <<'END'
camera { from = {0, 1, 4}, at = {0, 0, 0}, name = "front" }
camera { from = {3, 3, 0}, at = {0, 0, 0}, name = "side/top" }
light.directional { direction = {-1, -2, -1}, irradiance = 3 }
background { color = {0.2, 0.3, 0.6} }
box { min = {-1, -1, -1}, max = {1, 1, 1}, material = material.lambert { color = {0.8, 0.3, 0.1} } }
END
cat >unlit.lua <<'END'
camera { from = {0, 1, 4}, at = {0, 0, 0} }
sphere { radius = 1, material = material.lambert { color = {0.8, 0.3, 0.1} } }
END
cat >anim.lua <<'END'
animation { fps = 12, first = 1, last = 6 }
camera { from = {0, 0, 5}, at = {0, 0, 0} }
light.directional { direction = {-1, -2, -1}, irradiance = 3 }
sphere { center = {time * 4 - 1, 0, 0}, radius = 0.5 }
END
cat >tetra.gltf <<'END'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
  {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
 "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
 "buffers": [{"byteLength": 72, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAACAAEAAAABAAMAAAADAAIAAQACAAMA"}]}
END
small=(-s 40x30 -n 1)

formats() {
    local kinds="png ppm pfm"
    for part in jpeg:jpg webp:webp openexr:exr; do
        built "${part%:*}" && kinds+=" ${part#*:}" || echo "NOT TESTED: this build has no ${part%:*}"
    done
    for kind in $kinds; do
        run 0 my.lua "${small[@]}" -o a.$kind
        exists a.$kind
        run 0 info a.$kind
        prints "40x30"
        [ $kind = pfm ] || prints "snell render my.lua .* -o a.$kind"
        [ $kind = pfm ] || { run 0 explain a.$kind 20 15; prints "pixel 20,15 of a.$kind"; }
        run 0 my.lua "${small[@]}" -o - --format $kind
        cmp -s out a.$kind || fail "standard output differs from a.$kind"
    done
    run 0 my.lua "${small[@]}" -o b.png --bits 16
    run 0 info b.png
    prints "channels of 16 bits"
    prints "--bits=16 -o b.png"
    run 0 my.lua "${small[@]}" -o a.pfm
    run 0 convert a.pfm c.png --bits 16 # the same bits later
    run 0 compare b.png c.png
    if built openexr; then
        run 0 my.lua "${small[@]}" -o half.exr --bits 16
        run 0 info half.exr
        prints "channels of 16 bits"
        run 0 compare a.exr half.exr --max-rmse 0.0005
        wrong "--bits: a .exr file has no 8 of them" "16 or 32" my.lua -o x.exr --bits 8
    fi
    if built jpeg; then
        run 0 my.lua "${small[@]}" -o low.jpeg --quality 10
        run 0 my.lua "${small[@]}" -o high.jpg --quality 100
        [ "$(stat -c %s low.jpeg)" -lt "$(stat -c %s high.jpg)" ] || fail "--quality changes nothing"
        run 0 compare a.png high.jpg --max-rmse 0.01
        run 0 convert a.pfm again.jpg
        wrong "--quality: '0' is not" "" my.lua -o x.jpg --quality 0
    fi
    if built webp; then
        wrong "x.webp: a .webp file has at most 16383 pixels a side" ".png" my.lua -s 17000x10 -o x.webp
        wrong "x.webp: a .webp file has at most 16383" "" my.lua -s 17000x10 --turntable 2 -o x.webp
        run 0 my.lua -s 17000x10 -n 1 --crop 20x10+0+0 -o crop.webp
        run 0 my.lua "${small[@]}" --background transparent -o clear.png
        run 0 convert clear.png clear.webp --quality 100
        run 0 compare clear.png clear.webp
        run 0 convert clear.webp again.png
        run 0 compare clear.png again.png
    fi
    wrong "--quality: a .png file loses nothing" ".jpg and .webp" my.lua -o x.png --quality 50
    wrong "--bits: a .ppm file has no 16 of them" "" my.lua -o x.ppm --bits 16
    wrong "--bits: there is no '12'" "'16'" my.lua -o x.png --bits 12
    wrong "--bits: a .pfm file" "" convert a.pfm y.pfm --bits 8
    wrong "'x.apng' is for several pictures" "snell render" convert a.pfm x.apng
    absent x.jpg x.png x.ppm x.exr x.apng y.pfm
    for tool in identify ffprobe; do
        has $tool || continue
        for kind in jpg webp png; do
            [ -e a.$kind ] || continue
            if [ $tool = identify ]; then identify -format '%w %h\n' a.$kind >out 2>err
            else ffprobe -v error -show_entries stream=width,height -of csv=p=0 a.$kind >out 2>err; fi
            grep -q "^40[ ,]30" out || fail "$tool does not understand a.$kind"
        done
    done
}

transparency() {
    for kind in ppm pfm; do
        run 0 my.lua "${small[@]}" --background transparent -o clear.$kind
        says "--background transparent: a .$kind file has no alpha, so black is behind"
    done
    run 0 render my.lua unlit.lua "${small[@]}" --background transparent -o '{name}.clear.ppm'
    grep -c "no alpha" err | grep -qx 1 || fail "that a format has no alpha is not said once"
    run 0 my.lua "${small[@]}" --background transparent -o - --format ppm
    says "no alpha"
    run 4 my.lua "${small[@]}" --background transparent -o strict.ppm --strict
    run 0 my.lua "${small[@]}" --background transparent -o clear.png
    run 0 anim.lua "${small[@]}" --background transparent --frames 1..2 -o clear.apng
    grep -q "no alpha" err && fail "an .apng file has no alpha"
    run 0 my.lua "${small[@]}" --background transparent -o clear.ppm --json
    prints "no alpha"
}

looks() {
    for map in clip reinhard neutral aces agx; do
        run 0 my.lua "${small[@]}" -o $map.png --strip --tonemap $map
    done
    [ "$(md5sum clip.png reinhard.png neutral.png aces.png agx.png | cut -d' ' -f1 | sort -u | wc -l)" = 5 ] ||
        fail "two tone maps are the same"
    run 0 my.lua "${small[@]}" -o plain.png --strip
    cmp -s plain.png clip.png || fail "clip is not the default"
    run 0 my.lua "${small[@]}" -o d65.png --strip --white-balance 6504
    cmp -s plain.png d65.png || fail "D65 changes the picture"
    run 0 my.lua "${small[@]}" -o warm.png --white-balance 3200 --tonemap agx --exposure 0.5
    run 0 info warm.png
    prints "--tonemap=agx --white-balance=3200"
    run 0 my.lua "${small[@]}" -o light.pfm
    run 0 convert light.pfm warm2.png --white-balance 3200 --tonemap agx --exposure 0.5
    run 0 compare warm.png warm2.png
    run 0 compare warm.png light.pfm --white-balance 3200 --tonemap agx --exposure 0.5
    run 1 compare warm.png light.pfm --tonemap agx --exposure 0.5
    { echo 'render { white_balance = 3200, tonemap = "agx", exposure = 0.5 }'; cat my.lua; } >look.lua
    run 0 look.lua "${small[@]}" -o warm3.png --json
    prints '"white_balance": "3200"'
    prints '"tonemap": "agx"'
    run 0 compare warm.png warm3.png
    sed 's/= 3200/= "orange"/' look.lua >bad.lua
    run 3 bad.lua
    says "bad.lua:1:"
    says "'orange' is neither a temperature nor a colour"
    for white in orange '#ffa500' 1,0.376262,0; do
        run 0 my.lua "${small[@]}" -o white.png --strip --white-balance "$white"
        md5sum <white.png
    done | sort -u | wc -l | grep -qx 1 || fail "one colour three ways is not one picture"
    if built openexr; then
        run 0 look.lua "${small[@]}" -o look.exr
        run 0 compare look.exr warm3.png # the tag knows
        run 0 convert look.exr look.png
        run 0 compare look.png warm3.png
        run 0 convert look.exr cold.png --white-balance 6504
        run 0 info cold.png
        prints "--white-balance=6504 -o cold.png"
        wrong "x.exr: --white-balance would change nothing" "" convert look.exr x.exr --white-balance 5000
    fi
    wrong "--white-balance: '999' is no light" "1000 to 25000" my.lua --white-balance 999
    wrong "--white-balance: 'wrm' is no light" "" my.lua --white-balance wrm
}

animations() {
    run 0 anim.lua "${small[@]}" --frames 1..6 -o a.apng
    says "a.apng  40x30  6 frames, 12 a second"
    run 0 info a.apng
    prints "3 channels of 8 bits, 6 frames"
    prints "--frames=1..6 --fps=12 -o a.apng"
    cp a.apng first.apng
    eval "$(sed -n 's/^  snell /"$snell" /p' out)" 2>err || fail "the command that info tells does not work"
    cmp -s a.apng first.apng || fail "the command that info tells makes another animation"
    wrong "a.apng has several frames" "--frame 1" explain a.apng 20 15
    run 0 explain a.apng 20 15 --frame 3
    run 0 anim.lua "${small[@]}" --frames 1..6 -o b.apng -t 1
    cmp -s a.apng b.apng || fail "threads change an animation"
    run 0 anim.lua "${small[@]}" --frames 2..3 --fps 30 -o - --format y4m
    head -c 200 out | head -1 | grep -q '^YUV4MPEG2 W40 H30 F30:1 ' || fail "no y4m head"
    [ "$(stat -c %s out)" = $((2 * (6 + 40 * 30 * 3 / 2) + $(head -c 200 out | head -1 | wc -c))) ] ||
        fail "y4m of another size"
    cp out pipe.y4m
    run 0 anim.lua "${small[@]}" --frames 2..3 --fps 30 --chroma 444 -o whole.y4m
    head -1 whole.y4m | grep -q " C444 " || fail "--chroma 444 is not in the file"
    [ "$(stat -c %s whole.y4m)" = $(($(head -1 whole.y4m | wc -c) + 2 * (6 + 3 * 40 * 30))) ] || fail "the size of whole.y4m"
    wrong "--chroma: a .apng file has no choice of it" ".y4m" anim.lua --frames 2..3 --chroma 444 -o a.apng
    run 0 anim.lua "${small[@]}" --frames 2..3 --fps 30 -o file.y4m
    cmp -s pipe.y4m file.y4m || fail "a y4m file differs from the pipe"
    run 0 anim.lua "${small[@]}" --frame 2 -o one.apng # one frame
    run 0 info one.apng
    prints "1 frame$"
    prints -- "--frame=2"
    run 0 anim.lua "${small[@]}" --frames 1..2 -o n.png # numbered, as before
    grep -v camera anim.lua >bare.lua
    run 0 bare.lua "${small[@]}" --frames 2..4 -o bare.png
    grep -c "added: camera" err | grep -qx 1 || fail "what was added to frames is not said once"
    exists n.0001.png n.0002.png
    if built webp; then
        run 0 anim.lua "${small[@]}" --frames 1..6 -o a.webp
        run 0 info a.webp
        prints "6 frames"
        run 0 anim.lua "${small[@]}" --frames 1..2 -o 'n%02d.webp'
        exists n01.webp n02.webp
        if has webpinfo; then
            webpinfo a.webp >out 2>err || fail "webpinfo refuses a.webp"
            [ "$(grep -c 'ANMF' out)" -ge 6 ] || fail "webpinfo counts other frames"
            grep -q 'No error' out || fail "webpinfo finds errors"
        fi
    fi
    if has ffprobe; then
        for file in a.apng file.y4m; do
            ffprobe -v error -count_frames -show_entries stream=nb_read_frames,r_frame_rate -of csv=p=0 $file >out 2>err
            [ $file = a.apng ] && prints '^12/1,6$' || prints '^30/1,2$'
        done
        ffmpeg -v error -i a.apng -start_number 1 f%d.png 2>err || fail "ffmpeg does not read a.apng"
        run 0 anim.lua "${small[@]}" --frame 4 -o g.png
        run 0 compare f4.png g.png
        ffmpeg -v error -i pipe.y4m -vf 'scale=in_color_matrix=bt709:flags=accurate_rnd+full_chroma_int+bitexact' \
            -pix_fmt rgb24 -start_number 2 y%d.png 2>err || fail "ffmpeg does not read y4m"
        run 0 anim.lua "${small[@]}" --frame 3 -o g.png
        run 0 compare g.png y3.png --max-rmse 0.03
    fi
    wrong "--frames makes several pictures" "y4m" anim.lua --frames 1..2 -o -
    wrong "--aov: an animation has no layers" "numbered" anim.lua --frames 1..2 -o x.apng --aov depth
    wrong "--fps: '0' is not" "" anim.lua --frames 1..2 -o x.apng --fps 0
    wrong "-o: 'x.gif' is no kind of picture" ".apng, .webp or .y4m" anim.lua --frames 1..2 -o x.gif
    # what was there stays, and what was done is saved
    echo 'assert(time < 0.2, "enough")' >>anim.lua
    echo old >x.apng
    run 1 anim.lua "${small[@]}" --frames 1..6 -o x.apng
    says "stopped after 3 of 6 frames; they are in x.partial.apng"
    grep -qx old x.apng || fail "an old file was replaced by half an animation"
    run 0 info x.partial.apng
    prints "3 frames"
    run 3 anim.lua "${small[@]}" --frames 4..6 -o none.apng
    absent none.apng none.partial.apng
    ls -A | grep -q '\.tmp$' && fail "a temporary file is left: $(ls -A)"
}

stopping() {
    run 0 my.lua "${small[@]}" -o w.png
    "$snell" my.lua -s 320x240 -n 64 --turntable 5000 -o long.apng 2>err &
    local pid=$!
    for ((i = 0; i < 100; i++)); do
        sleep 0.1
        [ "$(stat -c %s .snell-*.tmp 2>/dev/null || echo 0)" -gt 3000 ] && break
    done
    kill -TERM $pid # in the background the shell has SIGINT ignored
    wait $pid
    local code=$?
    [ $code = 143 ] || fail "SIGTERM ends with $code"
    says "frames; they are in long.partial.apng"
    grep -q failed err && fail "a frame that was stopped counts as failed"
    absent long.apng
    run 0 info long.partial.apng
    prints ", [0-9]+ frames?$"
    ls -A | grep -q '\.tmp$' && fail "a temporary file is left"
    (trap "" XFSZ; ulimit -f 8; "$snell" my.lua -s 160x120 -n 1 --turntable 30 -o full.apng 2>err) && fail "written, and there was no room"
    says_by=E says "stopped after [1-9][0-9]* of 30 frames; nothing was written"
    [ "$(grep -c 'cannot write' err)" = 1 ] || fail "a full disk is not said once"
    ls -A | grep -q '\.tmp$' && fail "a temporary file is left"
}

turntables() {
    run 0 tetra.gltf "${small[@]}" --turntable 4 -o t.apng
    grep -c added err | grep -qx 1 || fail "what was added is not said once"
    run 0 info t.apng
    prints "--turntable=4 --fps=24 -o t.apng"
    run 0 explain t.apng 20 15 --frame 4
    run 0 tetra.gltf "${small[@]}" --turntable 4 # numbered
    exists tetra.0001.png tetra.0004.png
    absent tetra.0005.png
    run 0 info tetra.0003.png
    prints "--frame=3"
    prints "--turntable=4"
    run 0 tetra.gltf "${small[@]}" --turntable 4 --frame 3 -o third.png
    run 0 compare third.png tetra.0003.png
    run 0 tetra.gltf "${small[@]}" -o still.png
    run 1 compare still.png tetra.0001.png # all of a turn are seen from as far away as the widest needs
    run 0 tetra.gltf "${small[@]}" --turntable 36 --frame 10 --view 20,10 -o a.png
    run 0 tetra.gltf "${small[@]}" --turntable 36 --frame 1 --view 110,10 -o b.png # 90 degrees on
    run 0 compare a.png b.png --max-rmse 0.02
    run 1 compare still.png tetra.0002.png
    run 0 my.lua "${small[@]}" --turntable 5 --frame 2 -o own.png # the file's own camera turns too
    run 0 my.lua "${small[@]}" -o own1.png
    run 1 compare own.png own1.png
    run 0 unlit.lua "${small[@]}" --turntable 4 -o 'ball.%04d.png' # the studio's light turns with it
    grep -c added err | grep -qx 1 || fail "what was added is not said once"
    run 0 compare ball.0001.png ball.0003.png --max-rmse 0.02
    run 0 my.lua "${small[@]}" --turntable 3 --json -o loads.apng # one load for all frames
    [ "$(grep -c '"load": 0.0,' out)" = 2 ] || fail "a frame of a turntable loads the file again"
    wrong "--turntable: its frames are 1 to 4, 5 is none" "" tetra.gltf --turntable 4 --frame 5
    wrong "--turntable: '0' is not" "" tetra.gltf --turntable 0
    wrong "--turntable makes several pictures" "y4m" tetra.gltf --turntable 3 -o -
}

cameras() {
    run 0 my.lua "${small[@]}" --camera all -o '{camera}-{name}.png'
    exists front-my.png side_top-my.png
    run 0 my.lua "${small[@]}" --camera all --json
    exists my.front.png my.side_top.png
    prints '"camera": "side/top"'
    run 0 my.lua "${small[@]}" --camera side/top -o s.png
    run 0 compare s.png my.side_top.png
    run 0 info my.side_top.png
    prints "--camera=side/top"
    run 0 tetra.gltf "${small[@]}" --camera all -o '{name}-{camera}.png' # none of its own
    exists tetra-camera.png
    wrong "-o: '{camera}' means nothing" "{name}" my.lua -o '{camera}.png'
    wrong "--camera all makes several pictures" "{camera}.png" my.lua --camera all -o -
}

folders() {
    mkdir -p models/inner out.d
    cp my.lua tetra.gltf models
    cp tetra.gltf models/my.gltf
    cp tetra.gltf models/inner/deep.gltf
    echo broken >models/broken.glb
    touch models/wood.jpg models/a.mtl models/.hidden.gltf
    run 1 render models "${small[@]}" -o 'out.d/{name}.png'
    exists out.d/my.lua.png out.d/my.gltf.png out.d/tetra.png
    absent out.d/my.png out.d/deep.png out.d/broken.png
    says "1 of 4 files failed"
    says "2 other files in the folder left alone"
    says "models/broken.glb"
    cp tetra.gltf pyramid.gltf
    run 1 render models/ pyramid.gltf "${small[@]}" -o 'out.d/{name}.png' --json
    prints '"failed": 1'
    prints '"others": 2'
    rm models/broken.glb
    run 0 render models "${small[@]}"
    exists my.lua.png tetra.png
    run 3 render models/inner/.. out.d "${small[@]}"
    says "out.d: there is no model in this folder"
    wrong "-o: one name for 3 pictures" "{name}.png" render models -o x.png
}

# A ball of albedo a under light of radiance 1 from everywhere sends back a; so do the surroundings themselves.
surroundings() {
    printf '\0\0\200\77\0\0\200\77\0\0\200\77' >texels
    for _ in 1 2 3 4 5 6 7 8 9 10 11; do cat texels texels >more && mv more texels; done
    { printf 'PF\n64 32\n-1\n' && cat texels; } >white.pfm
    run 0 unlit.lua "${small[@]}" --light white.pfm -o a.pfm
    near 20 15 a.pfm 0.8 0.3 0.1
    near 1 1 a.pfm 1 1 1
    run 0 unlit.lua "${small[@]}" --light white.pfm --background '#000' -o b.pfm
    near 20 15 b.pfm 0.8 0.3 0.1
    near 1 1 b.pfm 0 0 0
    run 0 unlit.lua "${small[@]}" --light white.pfm -o a.png
    run 0 explain a.png 20 15
    prints "pixel 20,15 of a.png"
    printf '\0' | dd of=white.pfm bs=1 seek=23 conv=notrunc 2>err
    run 3 explain a.png 20 15
    says "changed"
    # A white disk that faces the sun of --light sky is as bright as one that faces the studio's key.
    echo 'disk { normal = {-0.49, 0.643, 0.588}, material = material.lambert { color = 1 } }' >disk.lua
    run 0 disk.lua "${small[@]}" --view front --light sky -o day.pfm
    says "added: camera, sun and sky (disk.lua has none)"
    pixel 20 15 40 30 day.pfm | awk '{ exit !($1 > 0.9 && $1 < 1.3 && $3 > 0.9 && $3 < 1.3) }' ||
        fail "--light sky makes white $(pixel 20 15 40 30 day.pfm)"
    pixel 1 1 40 30 day.pfm | awk '{ exit !($3 > 2 * $1) }' || fail "the sky is not blue"
    run 0 disk.lua "${small[@]}" --view front --light sky --background '#000' -o night.pfm
    near 1 1 night.pfm 0 0 0
    [ "$(pixel 20 15 40 30 night.pfm)" = "$(pixel 20 15 40 30 day.pfm)" ] || fail "a background changes the sky's light"
    run 0 disk.lua "${small[@]}" --light sky -o day.png
    run 0 explain day.png 20 15
    run 0 my.lua "${small[@]}" --light sky # it has lights
    grep -q "sky" err && fail "a sky for a scene that has lights"
    wrong "--light: there is no light 'sun'" "roof.hdr" unlit.lua --light sun
    run 5 unlit.lua "${small[@]}" --light no.hdr -o c.png
    absent c.png
    run 4 unlit.lua "${small[@]}" --light my.lua -o c.png
    absent c.png
}
# near X Y FILE.pfm R G B: within 2 %
near() {
    pixel "$1" "$2" 40 30 "$3" | awk -v r="$4" -v g="$5" -v b="$6" '
        function off(x, y) { return x > y ? x - y : y - x }
        { exit !(off($1, r) <= 0.02 && off($2, g) <= 0.02 && off($3, b) <= 0.02) }' ||
        fail "$3 at $1,$2: $(pixel "$1" "$2" 40 30 "$3"), not $4 $5 $6"
}

for test in formats transparency looks animations stopping turntables cameras folders surroundings; do
    mkdir -p "$work/$test"
    cp my.lua anim.lua unlit.lua tetra.gltf "$work/$test"
    cd "$work/$test" && { $test; cd "$work"; }
    echo "ok: $test"
done
[ $failures -eq 0 ] || { echo "$failures failures"; exit 1; }
echo "all right"
