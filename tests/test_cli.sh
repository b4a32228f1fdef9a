#!/bin/bash
# The command as its users meet it: what it says, what it writes, how it ends. $1: the build folder.
. "$(dirname "$0")/cli.sh"
lines() { [ "$(wc -l <"$1")" -le "$2" ] || fail "$1 has more than $2 lines"; }

# ---- one table: help, manual and completion say the same as the parser --------------------------
table() {
    local commands="render explain info compare convert bench example help"
    local command name letter metavar alias
    run 0 help --options
    cp out options
    for page in snell $commands scene; do run 0 help --man $page; cp out man.$page; done
    for shell in bash zsh fish; do run 0 help --completion $shell; cp out completion.$shell; done
    run 0 --help
    cp out help.snell
    for page in $commands; do run 0 $page --help; cat help.snell out >help.$page; done
    [ "$(wc -l <options)" -gt 40 ] || fail "the table of options is short"
    while read -r command name letter metavar alias; do
        if [ "$alias" = alias ]; then
            grep -q -- "$name " help.$command && fail "$command --help mentions the alias $name"
            continue
        fi
        local head="$name"
        [ "$metavar" != - ] && head="$name $metavar"
        [ "$name" = --ground ] && head="--ground[=COLOR]"
        [ "$name" = --svg ] && head="--svg[=VIEW]"
        grep -qE -- "^ +(-., )?${head//[\[\]+]/.}( |\$)" help.$command || fail "$command --help lacks '$head'"
        [ "$letter" = -- ] || grep -qF -- " $letter, $name" help.$command || fail "$command --help lacks $letter, $name"
        grep -qF -- "\\-\\-$(sed 's/^--//; s/-/\\-/g' <<<"$name")\\fR" man.$command || fail "man.$command lacks $name"
        grep -qE -- "[ '|]${name}[ |)']" completion.bash || fail "bash completion lacks $name"
        grep -qF -e "$name[" -e "$name}'[" -e "$name=-[" completion.zsh || fail "zsh completion lacks $name"
        grep -qE -- "-l ${name#--}( |\$)" completion.fish || fail "fish completion lacks $name"
    done <options
    # and nothing more than the parser knows
    for command in $commands; do
        grep -oE '^ +(-., )?--[a-z-]+' help.$command | grep -oE -- '--[a-z-]+' | while read -r name; do
            grep -q "^$command $name " options || echo "$command $name"
        done
    done >unknown
    [ -s unknown ] && fail "help knows options that the parser does not: $(tr '\n' ' ' <unknown)"
    awk 'length > 79' help.* >long
    [ -s long ] && fail "help lines wider than 79 columns: $(cat long)"
    bash -n completion.bash || fail "the bash completion is no bash"
    if command -v groff >/dev/null; then
        for page in snell $commands scene; do
            groff -man -Tutf8 -ww man.$page >/dev/null 2>warnings
            [ -s warnings ] && fail "man.$page: $(head -3 warnings)"
        done
    fi
    source completion.bash
    COMP_WORDS=(snell render --inte) COMP_CWORD=2 COMPREPLY=()
    _snell 2>/dev/null
    [ "${COMPREPLY[*]}" = --integrator ] || fail "bash completes --inte to '${COMPREPLY[*]}'"
    COMP_WORDS=(snell render -i wh) COMP_CWORD=3 COMPREPLY=()
    _snell 2>/dev/null
    [ "${COMPREPLY[*]}" = whitted ] || fail "bash completes -i wh to '${COMPREPLY[*]}'"
}

# ---- the wrong command line: exit 2, a message, a hint -----------------------------------------
usage() {
    wrong "which file, or which command?" "snell --help"
    wrong "there is no command 'rendr'" "did you mean 'snell render'?" rendr x.lua
    wrong "render needs a FILE" "such as" render
    wrong "unknown option '--sise'" "did you mean '--size'?" my.lua --sise 3x3
    wrong "unknown option '--intergrator'" "did you mean '--integrator'?" my.lua --intergrator=appel
    wrong "info takes no option '--size'" "it belongs to 'snell render'" info my.lua --size 3x3
    wrong "render takes no option '-x'" "./-name" my.lua -x
    wrong "--integrator: there is no 'witted'" "did you mean 'whitted'?" my.lua -i witted
    wrong "--tonemap: there is no 'x'" "clip, reinhard, neutral" my.lua --tonemap x
    wrong "--tonemap needs a value" "--tonemap NAME" my.lua --tonemap
    wrong "--quiet takes no value" "" my.lua --quiet=1
    for size in 10 x 0x5 5x0 -1x5 1e2x5 1000000000x1 65537x1 65536x65536 0% -5% 5x5x5 axb '5 x5'; do
        wrong "--size: '$size' is no size" "such as 800x600" my.lua --size="$size"
    done
    for crop in 10x10 10x10+1 0x5+0+0 5x5+-1+0 5x5+1+1+1; do
        wrong "--crop: '$crop' is no rectangle" "top left" my.lua --crop="$crop"
    done
    wrong "--crop: 10x10+795+0 lies outside" "" my.lua --crop 10x10+795+0
    for n in 0 -1 1.5 1048577 99999999999999999999 a ''; do
        wrong "--samples: '$n' is not a whole number from 1 to 1048576" "" my.lua --samples="$n"
    done
    wrong "--max-depth: '1001' is not" "" my.lua --max-depth 1001
    wrong "--min-weight: 'nan' is not a number" "" my.lua --min-weight nan
    wrong "--exposure: '1e9' is not a number" "" my.lua --exposure 1e9
    wrong "--seed: '9223372036854775808' is not" "" my.lua --seed 9223372036854775808 # JSON has no more
    wrong "--view: 'topp' is no direction" "did you mean 'top'?" my.lua --view topp
    wrong "--view: '10,95' is no direction" "azimuth" my.lua --view 10,95
    wrong "--camera and --view exclude each other" "" my.lua --view top -c main
    wrong "--fov: '180' is not a number" "" my.lua --view top --fov 180
    wrong "--background: '#12345' is no colour" "#rrggbb" my.lua --background '#12345'
    wrong "--ground: '1,2' is no colour" "#rrggbb" my.lua --ground=1,2
    wrong "--camera: my.lua has no camera 'mian'" "" my.lua -c mian
    wrong "-o: 'x.gif' is no kind of picture" ".png, .exr, .jpg, .webp, .pfm or .ppm" my.lua -o x.gif
    wrong "-o: 'tmp' is a folder" "tmp" my.lua -o tmp
    wrong "-o is given twice" "" my.lua -o a.png -o b.png
    wrong "-o: one name for 2 pictures" "{name}" my.lua bad.lua -o a.png
    wrong "'my.lua' and './my.lua' would both be written to my.png" "-o" my.lua ./my.lua
    wrong "--format is for standard output" "-o" my.lua --format png
    wrong "--input-format: there is no 'luaa'" "did you mean 'lua'?" my.lua --input-format luaa
    wrong "--set: 'depth' is not NAME=VALUE" "-D depth=5" my.lua -D depth
    wrong "--memory: 'much' is no size" "8G" my.lua --memory much
    wrong "--threads: '0' is not" "" my.lua -t 0
    wrong "there is no example 'helo'" "did you mean 'hello'?" example helo
    wrong "there is no help on 'dielectrc'" "did you mean 'snell help dielectric'?" help dielectrc
    absent my.png
    SNELL_THREADS=x run 2 my.lua
    says "SNELL_THREADS: 'x' is not"
    run 2 my.lua --build bst
    says "--build: there is no 'bst'"
    SNELL_ISA=avx9 run 2 my.lua
    says "SNELL_ISA: there is no 'avx9'"
}

# ---- pictures ------------------------------------------------------------------------------------
small=(-s 64x48 -n 4)
pictures() {
    run 0 my.lua "${small[@]}"
    exists my.png
    lines err 3
    [ -s out ] && fail "a render prints on standard output"
    tail -1 err | grep -qE '^my\.png  64x48  whitted  4 samples  [0-9.]+ s$' || fail "the last line is: $(tail -1 err)"
    run 0 render my.lua "${small[@]}" -q
    lines err 0
    run 0 -q render my.lua -s 64x -n1
    for format in exr pfm ppm png; do
        [ $format = exr ] && "$snell" --version | grep -q 'missing.*openexr' && continue
        run 0 my.lua "${small[@]}" -o a.$format
        exists a.$format
        run 0 my.lua "${small[@]}" -o - --format $format
        cmp -s out a.$format || fail "-o - --format $format differs from a.$format"
    done
}

sizes() {
    has_size() { prints "\"width\": $1,"; prints "\"height\": $2,"; }
    run 0 my.lua -n 1 --json -s 64x; has_size 64 48
    run 0 my.lua -n 1 --json -s x48; has_size 64 48
    run 0 my.lua -n 1 --json -s 10%; has_size 80 60
    run 0 my.lua -n 1 --json --resolution 30x20 --spp 2 --depth 3; has_size 30 20
    prints '"samples": 2,'
    prints '"max_depth": 3,'
    run 0 my.lua -n 1 --json -s 64x48 --crop 10x12+50+30; has_size 10 12
}

# Pixels of a crop equal the whole picture's; PFM is plain floats, bottom row first.
crops() {
    run 0 my.lua "${small[@]}" -o whole.pfm
    run 0 my.lua "${small[@]}" -o part.pfm --crop 16x8+20+10
    local header_whole header_part row
    header_whole=$(($(stat -c %s whole.pfm) - 64 * 48 * 12))
    header_part=$(($(stat -c %s part.pfm) - 16 * 8 * 12))
    for row in 0 7; do # from the top: row 10 + row of the whole
        tail -c +$((header_whole + 1 + ((47 - 10 - row) * 64 + 20) * 12)) whole.pfm | head -c $((16 * 12)) >a
        tail -c +$((header_part + 1 + (7 - row) * 16 * 12)) part.pfm | head -c $((16 * 12)) >b
        [ "$(stat -c %s a)" -eq 192 ] && cmp -s a b || fail "row $row of a crop differs from the whole picture"
    done
}

hash_of() { # hash_of ARGUMENT...
    "$snell" my.lua "${small[@]}" -o hash.png --json "$@" 2>err | sed -n 's/.*"image_hash": "\(.*\)".*/\1/p'
}
differs() { # the option changes the picture
    local got
    got=$(hash_of "$@")
    [ -n "$got" ] && [ "$got" != "$plain" ] || fail "$* changes nothing ('$got')"
}
same() {
    [ "$(hash_of "$@")" = "$plain" ] || fail "$* changes the picture"
}
options_act() {
    plain=$(hash_of)
    [ ${#plain} -eq 16 ] || fail "the image hash is '$plain'"
    same
    same -t 1
    same -t 3
    same --isa scalar
    same --strip
    same --progress json
    same --camera 1
    same --exposure 1   # encoding only: the linear film is the same
    same --tonemap reinhard
    differs --samples 8
    differs -n 1
    differs --seed 7
    same --filter box
    same --filter-radius 0.5
    differs --filter tent
    differs --filter gaussian --filter-radius 2
    differs --view top
    differs --view 30,15
    differs --view bottom --fov 20
    differs --fov 20
    same --fov 40 # hello.lua's own
    differs --background '#ff0000'
    differs --background transparent
    run 0 my.lua "${small[@]}" -o e0.png --strip
    run 0 my.lua "${small[@]}" -o e1.png --strip --exposure 1
    run 0 my.lua "${small[@]}" -o e2.png --strip --tonemap reinhard
    cmp -s e0.png e1.png && fail "--exposure changes nothing"
    cmp -s e0.png e2.png && fail "--tonemap changes nothing"
    [ "$(hash_of --background '#808080')" = "$(hash_of --background grey)" ] || fail "grey is not #808080"
    [ "$(hash_of --background 0)" = "$(hash_of --background black)" ] || fail "0 is not black"
    [ "$(hash_of --view front)" = "$(hash_of --view 0,0)" ] || fail "front is not 0,0"
}

programs() {
    cat >param.lua <<'LUA'
local size = param("size", 1.5, "how large the ball is")
camera { from = {0, 0, 5}, at = {0, 0, 0} }
light.point { position = {2, 2, 4}, intensity = 50 }
sphere { radius = size }
LUA
    run 0 info param.lua
    prints "size=1.5"
    prints "how large the ball is"
    run 0 info param.lua -D size=0.5
    prints "size=0.5"
    run 0 param.lua "${small[@]}" -o p1.pfm
    run 0 param.lua "${small[@]}" -o p2.pfm -D size=0.5
    cmp -s p1.pfm p2.pfm && fail "-D changes nothing"
    run 2 param.lua "${small[@]}" -D sise=2
    says "sise"
    run 0 my.lua --light none "${small[@]}"
    printf 'sphere { radius = 1 }\n' >ball.lua
    run 0 ball.lua "${small[@]}"
    says "added: "
    lines err 3
    run 0 ball.lua "${small[@]}" -o plain.pfm
    run 0 ball.lua "${small[@]}" -o ground.pfm --ground
    run 0 ball.lua "${small[@]}" -o red.pfm --ground=0.9,0.1,0.1
    cmp -s plain.pfm ground.pfm && fail "--ground changes nothing"
    cmp -s red.pfm ground.pfm && fail "the colour of --ground changes nothing"
    # what lies flat is seen, not fought over with a ground in its own plane
    printf 'quad { corner = {-1, 0, 1}, u = {2, 0, 0}, v = {0, 0, -2}, material = material.lambert { color = 0.8 } }\n' >flat.lua
    for ground in "" --ground --ground=0; do
        run 0 flat.lua -i appel -n 1 -s 32x24 --view top --crop 8x8+12+8 -o "flat$ground.pfm" $ground
    done
    cmp -s flat.pfm flat--ground.pfm || fail "the ground is seen through what lies on it"
    cmp -s flat.pfm flat--ground=0.pfm || fail "the black ground is seen through what lies on it"
    run 0 ball.lua "${small[@]}" -o dark.pfm --light none --background 0
    cmp -s plain.pfm dark.pfm && fail "--light none changes nothing"
    run 0 ball.lua "${small[@]}" -o up.pfm --background '#fff'
    says "added: camera, lights (ball.lua"
    printf 'light.point { position = {3, 3, 3}, intensity = 50 }\nsphere { material = material.mirror { color = 0.9 } }\nbackground { color = 0.5 }\n' >mirror.lua
    run 0 mirror.lua "${small[@]}" -o whitted.pfm
    run 0 mirror.lua "${small[@]}" -o appel.pfm -i appel
    cmp -s whitted.pfm appel.pfm && fail "-i changes nothing"
    run 0 mirror.lua "${small[@]}" -o depth.pfm --max-depth 0
    cmp -s whitted.pfm depth.pfm && fail "--max-depth changes nothing"
    run 0 ball.lua "${small[@]}" --fov 20 -o fov20.pfm
    run 0 ball.lua "${small[@]}" --fov 60 -o fov60.pfm
    cmp -s fov20.pfm fov60.pfm && fail "--fov changes nothing"
}

# ---- the output rule and the tag ------------------------------------------------------------------
frames() {
    cat >spin.lua <<'LUA'
animation { fps = 10, first = 1, last = 5 }
camera { from = {0, 0, 5}, at = {0, 0, 0}, shutter = {0, 1} }
light.point { position = {2, 2, 4}, intensity = 50 }
sphere { center = {frame - 3, time, 0}, radius = 0.5,
         motion = function(t) return transform.translate {0, 3 * (t - time), 0} end }
LUA
    mkdir -p shots
    run 0 info spin.lua
    prints "frames 1 to 5, 10 a second; this is frame 1"
    run 0 info spin.lua --frame 4
    prints "this is frame 4"
    run 0 spin.lua "${small[@]}" --frames 2..4 -o 'shots/%03d.pfm'
    exists shots/002.pfm; exists shots/004.pfm; absent shots/001.pfm; absent shots/005.pfm
    cmp -s shots/002.pfm shots/003.pfm && fail "two frames are the same"
    run 0 spin.lua "${small[@]}" --frame 3 -o one.pfm
    cmp -s one.pfm shots/003.pfm || fail "--frame 3 is not the third of --frames"
    run 0 spin.lua "${small[@]}" --frames 3..4
    exists spin.0003.png; exists spin.0004.png
    run 0 info spin.0004.png
    prints "--frame=4"
    run 0 spin.lua "${small[@]}" --frames 1..2 --json
    [ "$(grep -c '"image_hash"' out)" -eq 2 ] || fail "--frames --json has not two pictures"
    run 2 spin.lua "${small[@]}" --frames 5..6 -o shots/x.png # said before frame 5 is made
    absent shots/x.0005.png
    says "--frames: spin.lua has frames 1 to 5, 6 is none"
    run 2 spin.lua --frame 6
    run 2 spin.lua --frame 0
    run 2 spin.lua --frames 3
    run 2 spin.lua --frames 3..2
    run 2 spin.lua --frames 1..2 --frame 1
    run 2 spin.lua --frames 1..2 -o -
    run 2 - --frames 1..2 <spin.lua
    run 2 my.lua --frame 1
    says "has no frames"
    run 2 my.lua --frames 1..50 # said once
    [ "$(grep -c "has no frames" err)" = 1 ] || fail "a scene without frames is not said once"
}

output_rule() {
    rm -f my.png
    echo "my diary" >my.png
    run 5 my.lua "${small[@]}"
    says "my.png is there already, and snell did not make it"
    says "--force"
    [ "$(cat my.png)" = "my diary" ] || fail "somebody else's file is gone"
    run 0 my.lua "${small[@]}" --force --strip
    cmp -s my.png <(echo "my diary") && fail "--force does not overwrite"
    run 5 my.lua "${small[@]}" # stripped: nothing says that snell made it
    rm my.png
    run 0 my.lua "${small[@]}"
    run 0 my.lua "${small[@]}" # tagged: replaced
    echo "my diary" >named.png
    run 0 my.lua "${small[@]}" -o named.png
    run 5 my.lua -o missing/x.png
    says "missing"
    cp my.lua other.lua
    run 5 render my.lua other.lua -o 'missing/{name}.png'
    [ "$(grep -c "the folder 'missing' cannot be used" err)" = 1 ] || fail "a missing folder is not said once"
    run 5 my.lua --frames 1..9 -o 'missing/%d.png' --json
    [ "$(grep -c "the folder 'missing' cannot be used" out)" = 1 ] || fail "a missing folder is not in JSON once"
    absent missing
    if [ "$(id -u)" != 0 ]; then
        mkdir closed
        chmod a-w closed
        run 5 my.lua -o closed/x.png
    fi
    # a failed render leaves the older picture
    cp my.png before.png
    cp bad.lua tmp/my.lua
    run 3 tmp/my.lua
    cmp -s my.png before.png || fail "a failed render changed the older picture"
    rm tmp/my.lua
    "$snell" my.lua "${small[@]}" -o - >/dev/full 2>err
    [ $? -eq 5 ] || fail "a full disk is not exit 5"
    "$snell" help render >/dev/full 2>err
    [ $? -eq 5 ] || fail "a full disk is not exit 5 for help"
    if command -v script >/dev/null; then
        script -qec "$snell my.lua -o -" /dev/null >out 2>&1 </dev/null
        if grep -q "failed to create pseudo-terminal" out; then
            echo "NOT TESTED: -o - to a terminal (no pseudo-terminals here)"
        else
            grep -q "standard output is a terminal" out || fail "-o - to a terminal is not refused"
        fi
    fi
}

tag() {
    run 0 my.lua "${small[@]}" --seed 5 --view 30,15 -o tagged.png --exposure 0.5 --ground=0.3 -t 1
    run 0 info tagged.png
    prints "64x48"
    prints "snell render my.lua --integrator=whitted --size=64x48 --samples=4"
    prints "--seed=5"
    prints "--view=30,15"
    cp out first
    grep -qE -- '--threads|--isa| -t' out && fail "the tag tells threads or ISA"
    # the printed command makes the same bytes
    cp tagged.png before.png
    rm tagged.png
    PATH=$(dirname "$snell"):$PATH bash -c "$(tail -1 first)" 2>err || fail "the printed command fails"
    cmp -s tagged.png before.png || fail "the printed command makes other bytes"
    run 0 my.lua "${small[@]}" -o stripped.png --strip
    run 0 info stripped.png
    prints "does not say how it was made"
    run 0 info my.lua
    prints "cameras"
    prints "lambert"
    prints "acceleration structure"
    run 0 info my.lua --no-build
    prints "more at most while the structure is built"
    lacks "acceleration structure"
    run 5 info nothing.png
    run 5 info nothing.lua
}

# ---- layers beside the picture -------------------------------------------------------------------
aovs() {
    run 0 render --aov list
    prints "depth"
    prints "N.X N.Y N.Z"
    cp out listed
    run 0 help aovs
    prints "render { aov ="
    while read -r line; do grep -qF -- "$line" out || fail "snell help aovs lacks: $line"; done <listed
    awk 'length > 79' out listed | grep -q . && fail "a line of help aovs is wider than 79 columns"
    run 0 my.lua "${small[@]}" -o plain.png
    run 0 my.lua "${small[@]}" -o layers.png --aov depth,normal,light
    says "with layers.depth.png, layers.normal.png, layers.light."
    says "layers.png  64x48"
    lines err 3
    exists layers.depth.png
    exists layers.normal.png
    [ "$("$snell" compare layers.png plain.png --json | jq .differing)" = 0 ] || fail "--aov changes the picture"
    run 0 info layers.depth.png
    prints "--aov=depth,normal,light"
    cp layers.depth.png before.png
    PATH=$(dirname "$snell"):$PATH bash -c "$(tail -1 out | sed 's/-o .*/-o layers.png/')" 2>err || fail "the printed command fails"
    cmp -s layers.depth.png before.png || fail "the printed command makes another depth"
    run 0 my.lua "${small[@]}" -o numbers.pfm --aov normal --json
    [ "$(jq -c '.aovs' out)" = '[{"name":"normal","channels":["N.X","N.Y","N.Z"],"output":"numbers.normal.pfm"}]' ] ||
        fail "--json says: $(jq -c .aovs out)"
    exists numbers.normal.pfm
    run 2 my.lua "${small[@]}" -o numbers.pfm --aov normal,crypto_object
    says "--aov: 'crypto_object' has more channels than a .pfm"
    run 0 my.lua -n 1 -s 8x6 -o every.png --aov all --json
    jq -r '.aovs[].name' out | sed 's/\..*//' | sort -u | cmp -s - <(cut -d' ' -f3 listed | grep . | sort -u) ||
        fail "--aov all is not all: $(jq -c '[.aovs[].name]' out)"
    run 2 my.lua "${small[@]}" -o bad.png --aov depth,nromal
    says "--aov: there is no 'nromal'"
    says "did you mean 'normal'?"
    absent bad.png
    run 2 my.lua "${small[@]}" -o bad.png --aov depth,,normal
    run 2 my.lua "${small[@]}" -o - --aov depth
    says "standard output takes one picture"
    [ -s out ] && fail "a picture on standard output after all"
    # the scene's own list
    printf 'render { aov = "depth" }\nsphere { radius = 1, name = "a/b" }\n' >own.lua
    run 0 own.lua "${small[@]}" -o own.png
    exists own.depth.png
    run 0 own.lua "${small[@]}" -o none.png --aov none
    absent none.depth.png
    printf 'sphere { radius = 1 }\nrender { aov = "dept" }\n' >wrong.lua
    run 3 wrong.lua "${small[@]}" -o own.png
    says "wrong.lua:2"
    says "did you mean 'depth'?"
    # a file of somebody else's is not overwritten by a layer either
    cp own.lua layered.lua
    echo mine >layered.depth.png
    run 5 layered.lua "${small[@]}"
    says "layered.depth.png is there already"
    "$snell" --version | grep -q '^parts.*openexr' || { echo "NOT TESTED: this build has no OpenEXR"; return; }
    run 0 my.lua "${small[@]}" -o layers.exr --aov depth,normal,crypto_object,direct,indirect,emission
    says "with depth, normal, crypto_object"
    run 0 info layers.exr
    prints "depth: Z"
    prints "normal: N.X N.Y N.Z"
    run 0 info layers.exr --json
    [ "$(jq -c '.layers[0]' out)" = '{"name":"depth","channels":"Z"}' ] || fail "info --json: $(jq -c .layers out)"
    run 0 convert layers.exr normal.pfm --layer normal
    cp normal.pfm by_part.pfm
    run 0 convert layers.exr normal.pfm --layer N
    cmp -s normal.pfm by_part.pfm || fail "--layer N and --layer normal differ"
    run 0 my.lua "${small[@]}" -o numbers.pfm --aov normal
    cmp -s normal.pfm numbers.normal.pfm || fail "the layer in .exr is not the one in .pfm"
    run 2 convert layers.exr x.pfm --layer nromal
    says "did you mean 'normal'?"
    "$snell" my.lua "${small[@]}" -o - --format exr --aov depth 2>err | cat >piped.exr
    run 0 info piped.exr
    prints "depth: Z"
    head -c $(($(wc -c <piped.exr) / 2)) piped.exr >cut.exr
    run 0 info cut.exr
    says "its colours are not looked at"
    if command -v exrheader >/dev/null; then
        exrheader layers.exr >header || fail "exrheader does not open it"
        grep -q 'cryptomatte/3ae39a5/hash .*MurmurHash3_32' header || fail "no cryptomatte in the header"
        grep -q 'cryptomatte/3ae39a5/conversion .*uint32_to_float32' header || fail "no conversion in the header"
        grep -qF '"default":' header
    else
        echo "NOT TESTED: there is no exrheader (package openexr)"
    fi
    # what an interrupt saves has them
    set -m
    {
        "$snell" my.lua -n 100000 --progress none -o long.exr --aov depth >out 2>err &
        local child=$!
        sleep 1.5
        kill -INT $child
        wait $child
    } 2>/dev/null
    set +m
    run 0 info long.partial.exr
    prints "depth: Z"
    prints "stopped before it was done"
}

# ---- input ---------------------------------------------------------------------------------------
input() {
    # a name that is nearly that of a file
    refuses 5 "cannot open 'mi.lua': No such file or directory" "did you mean 'my.lua'?" mi.lua
    refuses 5 "cannot open './mi.lua'" "did you mean './my.lua'?" info ./mi.lua
    refuses 5 "cannot open 'nowhere/my.lua'" "" nowhere/my.lua
    grep -q "did you mean" err && fail "a file in a folder that is not there is near"
    run 3 bad.lua
    says "snell: bad.lua:2"
    says "radus"
    says "did you mean 'radius'?"
    run 5 nothing.lua
    says "nothing.lua"
    run 1 my.lua bad.lua "${small[@]}" -o 'tmp/{name}.png'
    exists tmp/my.png
    absent tmp/bad.png
    says "1 of 2 files failed"
    "$snell" - "${small[@]}" -o stdin.pfm --input-format lua <my.lua >out 2>err || fail "standard input is not read"
    run 0 my.lua "${small[@]}" -o file.pfm
    cmp -s stdin.pfm file.pfm || fail "standard input gives another picture"
    "$snell" - "${small[@]}" --input-format lua <bad.lua >out 2>err
    [ $? -eq 3 ] || fail "bad standard input is not exit 3"
    says "standard input:2"
    grep -q "$TMPDIR" err && fail "a message names the temporary file"
    ls -d tmp/snell-* >/dev/null 2>&1 && fail "the temporary folder is left behind"
    SNELL_THREAD=1 run 0 my.lua "${small[@]}"
    says "SNELL_THREAD means nothing"
    says "did you mean SNELL_THREADS?"
    rm -f my.png
    SNELL_THREAD=1 run 4 my.lua "${small[@]}" --strict
    absent my.png
    # the sanitizers' shadow memory needs more than any limit
    if ! ldd "$snell" | grep -qE 'lib[at]san'; then
        run 0 my.lua "${small[@]}" --memory 2G
        cp my.png before.png
        run 6 my.lua -s 6000x6000 -n 1 --memory 64M
        says "memory"
        cmp -s my.png before.png || fail "a failed render changed the older picture"
    fi
    SNELL_THREADS=1 SNELL_ISA=scalar run 0 my.lua "${small[@]}" --json
    prints '"threads": 1,'
    prints '"isa": "scalar",'
    printf 'local nothing = 1\n' >empty.lua
    run 3 empty.lua
    says "empty.lua: there is nothing to see"
    printf 'plane {}\n' >plane.lua
    run 0 plane.lua "${small[@]}"
    printf '\033[31mX' >'a.lua'
    run 3 a.lua
    grep -q $'\033' err && fail "a message passes control characters on"
    cp my.lua $'red\033[31m.lua'
    run 0 $'red\033[31m.lua' "${small[@]}"
    grep -q $'\033' err && fail "a note passes control characters on"
}

# ---- stopping --------------------------------------------------------------------------------------
stopping() {
    local signal want child started ended
    rm -f my.png my.partial.png
    cp "$source_folder/scenes/hello.lua" long.lua
    set -m # a job of its own, so that SIGINT is not ignored as in a script's background
    for signal in INT:130 TERM:143; do
        want=${signal#*:}
        "$snell" long.lua -n 100000 --progress plain -o long.png >out 2>err &
        child=$!
        sleep 1.5
        started=$(date +%s%N)
        kill -"${signal%:*}" $child
        wait $child
        [ $? -eq "$want" ] || fail "SIG${signal%:*} is not $want"
        ended=$(date +%s%N)
        echo "stopped by SIG${signal%:*} after $(((ended - started) / 1000000)) ms"
        [ $((ended - started)) -lt 2000000000 ] || fail "stopping takes too long"
        exists long.partial.png
        absent long.png
        says "they are in long.partial.png"
        grep -q "render" err || fail "no progress in the log"
        run 0 info long.partial.png
        prints "stopped before it was done"
        rm -f long.partial.png
    done 2>/dev/null
    set +m
    run 0 my.lua "${small[@]}" --progress line
    grep -q $'\r' err && fail "a short render shows progress"
}

texts() {
    for command in 'info my.lua' 'info my.lua --json' help 'example hello' 'explain my.lua 3 3 -s 8x8' 'help -h'; do
        $snell $command >/dev/full 2>err && fail "snell $command: a full disk is no error"
        says "standard output cannot be written: No space left on device"
    done
    run 0 --version
    prints "snell 0."
    prints "kernels"
    prints "parts"
    run 0 example
    prints "hello"
    for name in $("$snell" example | awk '{print $1}'); do
        run 0 example "$name"
        cmp -s out "$source_folder/scenes/$name.lua" || fail "example $name is not scenes/$name.lua"
    done
    for topic in formats scene materials lights shapes cameras textures integrators tonemaps exit \
        environment render explain info compare convert bench example help dielectric sphere point perspective lambert; do
        run 0 help $topic
        lines err 0
        [ "$(wc -l <out)" -ge 3 ] || fail "help $topic is short"
    done
    run 0 help dielectric
    prints "ior"
    run 0 help shapes
    prints "sphere"
}

# ---- what a first user met ---------------------------------------------------------------------
obj_text='v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n'
contents() {
    printf "$obj_text" >plain.obj
    for name in named.txt noextension; do
        cp plain.obj $name
        run 0 info ./$name
        prints "$name: obj"
    done
    run 0 info plain.obj
    prints "1 instance of 1 shape: 4 triangles"
    "$snell" - -n 1 -s 8x8 -o obj.pfm <plain.obj >out 2>err || fail "OBJ on standard input is not recognised"
    run 0 plain.obj -n 1 -s 8x8 -o obj2.pfm
    cmp -s obj.pfm obj2.pfm || fail "OBJ on standard input is another picture"
    cp plain.obj wrong.glb
    run 3 wrong.glb
    says "this is no GLB file"
    says "--input-format"
    run 0 info wrong.glb --input-format obj
    prints "wrong.glb: obj"
    run 2 plain.obj -D depth=1
    says "plain.obj takes no values (-D)"
    run 0 plain.obj -n 1 -s 8x8 -o dark.png --light none
    says "the picture will be black"
    run 0 plain.obj -n 1 -s 8x8 -o dark.png --light none --background 1
    grep -q black err && fail "a bright background is called black"
    "$snell" render - -n 4 -s 64x48 -o s.pfm <my.lua >out 2>err || fail "a scene on standard input is not recognised"
    run 0 my.lua "${small[@]}" -o s2.pfm
    cmp -s s.pfm s2.pfm || fail "a scene on standard input gives another picture"
    for line in 'local b = sphere { radius = 1 }' 'light.point{ position = {1, 2, 3} }' '  sphere{}' '-- a scene'; do
        printf '%s\nplane {}\n' "$line" >program
        run 0 info ./program
        prints "program: lua"
    done
    for text in 'hello, world' 'struct sphere { int radius; }' 'body { color: red }' $'sphere { }\1'; do
        printf '%s\n' "$text" >words
        run 4 info ./words
        says "no reader knows this kind of file"
        says "--input-format"
        grep -q -- "--format" err && fail "a hint names --format"
    done
    cp s.png picture 2>/dev/null || { run 0 my.lua "${small[@]}" -o s.png; cp s.png picture; }
    run 4 render ./picture
    says "this is a picture"
    says "snell info FILE"
    printf 'RIFF0000WEBPVP8 ' >picture
    run 4 render ./picture
    says "this is a picture"
    printf 'solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n' >a.stl
    run 0 a.stl -n 1 -s 8x8
    says "added: camera, lights, background (a.stl has none); if it lies on its side: --up y"
    run 0 a.stl -n 1 -s 8x8 --up y
    grep -q "side" err && fail "--up is asked for where it was given"
    printf '#?RADIANCE\n\n-Y 1 +X 1\n' >sky.hdr
    run 4 render sky.hdr
    says "this is a Radiance HDR picture"
    says "snell help environment"
    refuses 3 "ends early" "" info sky.hdr
    printf '\200\100\100\202' >>sky.hdr
    run 0 info sky.hdr # they once were taken for models
    prints "hdr picture, 1x1, 3 channels of 8 bits"
    prints "values      1 to 2"
    run 0 info sky.hdr --json
    [ "$(jq -c '[.format, .range]' out)" = '["hdr",[1,2]]' ] || fail "info --json says of an HDR: $(cat out)"
    run 0 convert sky.hdr sky.pfm
    run 0 info sky.pfm
    prints "values      1 to 2"
    printf 'print("a", "b")\nsphere { }\n' >print.lua
    run 0 print.lua -n 1 -s 8x8
    says "snell: print.lua:1: a b"
    run 0 print.lua -n 1 -s 8x8 -q
    [ -s err ] && fail "--quiet shows what a scene prints"
}

mistakes() {
    hint() { # hint MESSAGE HINT ARGUMENT...: exit 2 and no empty suggestion
        run 2 "${@:3}"
        says "$1"
        says "$2"
        grep -q "''" err && fail "an empty suggestion"
    }
    hint "no camera '7'" "it has 1" my.lua -c 7
    hint "--up: there is no 'w'" "it is one of" my.lua --up w
    hint "unknown option '--ver'" "did you mean '--version'?" my.lua --ver
    hint "--ground: its value follows '='" "did you mean --ground=red?" my.lua --ground red
    hint "--ground= has no value" "--ground alone" my.lua --ground=
    hint "-o: '{nme}' means nothing" "{name}" my.lua -o '{nme}.png'
    hint "--background: 'maroo' is no colour" "did you mean 'maroon'?" my.lua --background maroo
    hint "--exposure: '51' is not a number from -50 to 50" "" my.lua --exposure 51
    hint "-D sise" "did you mean" param.lua -D sise=1
    run 0 my.lua -n 1 -s 8x8 --exposure -50
    run 5 my.lua -o /proc/x.png # even root cannot make a file there
    says "cannot write in /proc"
    cp my.lua red # then red is a file, not a colour
    run 0 my.lua -n 1 -s 8x8 -o '{name}.pfm' --ground red
    plain=
    for color in red=ff0000 lime=00ff00 green=008000 navy=000080 orange=ffa500 pink=ffc0cb silver=c0c0c0; do
        [ "$(hash_of --background ${color%=*})" = "$(hash_of --background "#${color#*=}")" ] || fail "$color"
    done
    ls -a . | grep -q '^\.snell-' && fail "the test of the folder left a file"
}

language() {
    run 0 help scene
    for word in group instance model include 'mesh { file' triangle param transform.look_at print 'material, transform and name' \
        texture.image texture.checker 'view = {30, 12}' 'unless a group or an instance takes it'; do
        prints "$word"
    done
    awk 'length > 79' out >long
    [ -s long ] && fail "lines wider than 79 columns: $(cat long)"
    for topic in group instance model include param transform transforms triangle texture camera light material \
        shape unit units settings print groups ambient background; do
        run 0 help $topic
        [ "$(wc -l <out)" -ge 4 ] || fail "help $topic is short"
        awk 'length > 79' out >long
        [ -s long ] && fail "help $topic is wider than 79 columns: $(cat long)"
    done
    run 0 help image
    prints 'file = "wood.png"'
    run 0 help dielectric
    prints "as every material: name"
    run 0 help sphere
    prints "as every shape: material, transform, motion, name"
    run 0 help glazed
    prints "required"
    run 0 help settings
    for word in "render (setting)" max_depth "background (setting)" "ambient (setting)"; do prints "$word"; done
    run 0 help render
    tail -1 out | grep -qF "'snell help settings'" || fail "help render does not end with the settings"
    prints "auto: what the CPU"
    run 0 help formats
    prints "others that libassimp reads"
    run 0 help --man scene
    for word in group instance model include param transform triangle print; do
        grep -q "^\.SH ${word^^}" out || fail "the manual lacks $word"
    done
    grep -q 'example hello.*:$' out && fail "a sentence of the manual is cut off"
    run 0 --version
    grep -q ' $' out && fail "--version ends a line with a space"
    run 0 --help
    grep -q -- -vv out && fail "--help promises -vv"
    # the examples of the help are programs
    "$snell" help group | sed -n '/^  local/,/^$/p' | sed 's/{ \.\. }/{}/g; s/disk {}/disk { radius = 1 }/' >wheels.lua
    run 0 info wheels.lua
    prints "8 instances of "
    printf 'local red = material.lambert {}\n' >one.lua
    "$snell" help triangle | grep '^  triangle' >>one.lua
    "$snell" help transform | sed -n '/^  local/,/^$/p' >>one.lua
    "$snell" help textures | grep -E '^  (local|plane)' >>one.lua
    run 0 info one.lua
    prints "3 instances of 3 shapes"
    printf '%s\n' 'local m = mesh { positions = {{0,0,0},{1,0,0},{0,1,0},{0,0,1}}, indices = {0,1,2, 0,1,3} }' \
        'for i = 1, 5 do instance { m, transform = transform.translate {i, 0, 0} } end' >five.lua
    run 0 info five.lua
    prints "5 instances of 1 shape: 10 triangles, 2 of them stored"
    # a field is explained for every type that has it
    run 0 help roughness
    prints "in material dielectric"
    prints "in material ggx"
    prints "number or texture, 0 to 1"
    prints "[0.3]"
    run 0 help emission
    [ "$(grep -c '^  emission' out)" -eq 1 ] || fail "the common field emission is explained more than once"
    # words for what has another name here lead to its page; each page of the table is there
    for pair in glass:dielectric metal:conductor matte:lambert plastic:glazed plastic:principled pbr:principled \
        glow:emissive sun:directional sun:sky softbox:quad softbox:disk lamp:point hdri:environment csg:union \
        csg:difference fur:curves hair:curves terrain:heightfield bezier:patch formula:implicit metaballs:blob \
        fractal:julia donut:torus vase:lathe polygon:mesh floor:plane bokeh:perspective keyframe:motion \
        shear:transform appel:integrators clip:tonemaps stl:formats water:dielectric; do
        run 0 help "${pair%:*}"
        grep -q "^${pair#*:} " out || fail "help ${pair%:*} does not show ${pair#*:}"
    done
    run 2 help flass
    grep -q "did you mean" err && fail "'flass' is like no topic"
    run 2 help roughnes
    says "did you mean 'snell help roughness'?"
    for word in roughness emission color from map; do
        "$snell" help $word | awk 'length > 79 { exit 1 }' || fail "help $word is wider than 79 columns"
    done
    # another integrator has its own samples and depth: that is said
    printf 'render { integrator = "whitted", samples = 3, max_depth = 5 } sphere {}\n' >meant.lua
    run 0 meant.lua -i appel -s 8x8 -o meant.pfm
    says "samples 3 and max_depth 5 are meant for whitted: appel takes its own, 4 and 0"
    run 0 meant.lua -i whitted -s 8x8 -o meant.pfm
    grep -q "meant for" err && fail "the scene's own integrator is told so"
    printf 'render { integrator = "whitted", samples = 3 } sphere {}\n' >meant.lua
    run 0 meant.lua -i appel -s 8x8 -o meant.pfm
    says "samples 3 are meant for whitted: appel takes its own, 4"
    # but what the command line chose is not said to be the integrator's own
    run 0 meant.lua -i appel -n 9 -s 8x8 -o meant.pfm
    grep -q "meant for" err && fail "-n is given, and the scene's samples are still spoken of"
    printf 'render { integrator = "whitted", samples = 3, max_depth = 5 } sphere {}\n' >meant.lua
    run 0 meant.lua -i appel -n 9 -s 8x8 -o meant.pfm
    says "the scene's max_depth 5 is meant for whitted: appel takes its own, 0"
    printf 'sphere { material = material.dielectric {} }\n' >glass.lua
    run 0 glass.lua -s 8x8 -o glass.pfm -v
    says "max_depth is 24, not 10: the scene has glass"
    run 0 glass.lua -s 8x8 -o glass.pfm --max-depth 3 -v
    grep -q "max_depth is" err && fail "--max-depth is given, and another depth is spoken of"
}

"$snell" example hello >my.lua || fail "there is no example"
printf '%s\n' '-- a mistake' 'sphere { radus = 1 }' >bad.lua
parts table usage pictures sizes crops options_act programs frames output_rule tag aovs input stopping texts contents mistakes language
