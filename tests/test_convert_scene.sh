#!/bin/bash
# snell convert SCENE OUT.snell or OUT.lua: whatever is read is the same picture afterwards. $1: the build folder.
models_folder=${SNELL_MODELS:-/nonexistent}
. "$(dirname "$0")/cli.sh"

# same SOURCE [OPTION...]: compiled, and as a program where that can say it, it is the same to the bit
same() {
    local file=$1 kind
    shift
    "$snell" "$file" -s 48x36 -n 1 -q -o source.pfm "$@" 2>err || { fail "$file is not drawn"; return; }
    for kind in snell lua; do
        rm -rf made.*
        if ! "$snell" convert "$file" made.$kind -q "$@" 2>err; then
            [ $kind = lua ] && grep -q "model without lights that" err && continue
            fail "$file does not become .$kind"
            continue
        fi
        "$snell" made.$kind -s 48x36 -n 1 -q -o made.pfm 2>err || fail "$file as .$kind is not drawn"
        cmp -s source.pfm made.pfm || fail "$file as .$kind is another picture"
        pictures=$((pictures + 1))
    done
}

showcase() {
    pictures=0
    for file in "$source_folder"/scenes/*.lua "$source_folder"/scenes/*.pbrt; do same "$file"; done
    same "$source_folder/scenes/solar-system.lua" --frame 40
    [ $pictures -gt 40 ] || fail "only $pictures pictures"
}

formats() {
    for file in "$source_folder"/tests/data/models/*.{obj,ply,stl,glb,gltf} "$source_folder"/tests/data/gltf/*.gltf; do
        case $file in
        *draco* | *webp*) "$snell" "$file" -s 8x8 -n 1 -q -o have.pfm 2>err || continue ;;
        */points.obj | */lines.gltf) continue ;;
        esac
        same "$file"
    done
    built assimp && same "$source_folder/tests/data/models/tetrahedron.off"
    same "$source_folder/tests/data/gltf/animated.gltf" --frame 5
}

models() {
    [ -d "$models_folder" ] || { echo "SKIPPED: SNELL_MODELS names no folder"; return; }
    for file in "$models_folder"/spd-nff/*.nff; do same "$file"; done
}

nff_scene() {
    printf '%s\n' 'b 0.1 0.2 0.3' 'v' 'from 0 1 5' 'at 0 0 0' 'up 0 1 0' 'angle 40' 'hither 1' 'resolution 48 36' \
        'l 3 5 2 0.9 0.8 0.7' 'l -3 5 2' 'f 0.7 0.3 0.1 0.8 0.4 20 0 0' 's 0 0 0 0.5' 'c 1 0 0 0.3 1 1 0 0.1' \
        'f 0.2 0.6 0.3 1 0 0 0 0' 'p 3' '-1 0 0' '-2 0 0' '-1 1 0' 'f 1 1 1 0 0 0 0.9 1.5' 's -1 -0.3 1 0.3' \
        'f 0.7 0.7 0.7 0.8 0 0 0 0' 'pp 4' '-3 -1 -3 0.1 1 0' '3 -1 -3 0 1 0' '3 -1 3 0 1 0.1' '-3 -1 3 0 1 0' >all.nff
    same "$work/all.nff"
    run 0 convert all.nff all.lua -q
    for text in 'camera {' 'light.point {' 'sphere {' 'cone {' 'material.dielectric' 'material.glazed' 'background {'; do
        grep -qF "$text" all.lua || fail "all.lua has no $text"
    done
}

# An object that stands in several places, one of which moves; lamps; textures of the file's own
pbrt_scene() {
    "$snell" "$source_folder/scenes/hello.lua" -s 8x6 -n 1 -o dots.png -q
    printf '%s\n' 'LookAt 0 3 8  0 0.5 0  0 1 0' 'Camera "perspective" "float fov" 40' \
        'Film "rgb" "integer xresolution" 48 "integer yresolution" 36' 'WorldBegin' \
        'LightSource "infinite" "rgb L" [.4 .45 .5]' 'LightSource "distant" "point3 from" [1 2 3] "rgb L" [1 2 1]' \
        'Texture "dots" "spectrum" "imagemap" "string filename" "dots.png" "float scale" 0.7' \
        'ObjectBegin "thing"' 'Material "diffuse" "texture reflectance" "dots"' 'Shape "sphere" "float radius" .4' \
        'Translate .5 .3 0' 'Rotate 30 1 1 0' 'Material "dielectric"' 'Shape "sphere" "float radius" .25' \
        'Shape "trianglemesh" "point3 P" [ -1 0 -1  1 0 -1  1 0 1  -1 0 1] "integer indices" [0 1 2 0 2 3]' 'ObjectEnd' \
        'ObjectInstance "thing"' 'AttributeBegin' 'Translate 1.5 .2 0' 'Rotate 47 .3 1 .2' 'ObjectInstance "thing"' \
        'AttributeEnd' 'AttributeBegin' 'Translate -1.5 .2 .3' 'ActiveTransform EndTime' 'Translate .3 .2 0' \
        'ActiveTransform All' 'ObjectInstance "thing"' 'AttributeEnd' 'Shape "disk" "float radius" 20 "float height" -1' \
        >all.pbrt
    same "$work/all.pbrt"
    same "$work/all.pbrt" # again: into the folder of files that is there
    run 0 convert all.pbrt all.lua -q
    grep -q 'shared = true' all.lua || fail "the object is not shared"
    grep -q ' \* 0.7' all.lua || fail "the texture is not scaled"
    # a program takes the whole scene in, compiled or not
    for kind in pbrt snell; do
        run 0 convert all.pbrt all.snell -q
        echo "include 'all.$kind'" >includes.lua
        run 0 includes.lua -n 1 -q -o included.pfm
        run 0 all.pbrt -n 1 -q -o source.pfm
        cmp -s included.pfm source.pfm || fail "all.$kind included is another picture"
    done
}

# Every AOV, and what the tag and explain say
layers() {
    local all=depth,position,normal,albedo,uv,motion,object_id,crypto_object,crypto_material,direct,light,rays
    built openexr || { echo "SKIPPED: no OpenEXR"; return; }
    for name in motion-blur solids depth-of-field; do
        run 0 convert "$source_folder/scenes/$name.lua" made.snell -q
        run 0 "$source_folder/scenes/$name.lua" -s 48x36 -n 2 --aov $all --strip -q -o a.exr
        run 0 made.snell -s 48x36 -n 2 --aov $all --strip -q -o b.exr
        cmp -s a.exr b.exr || fail "$name: other layers"
    done
    run 0 convert "$source_folder/scenes/whitted-1980.lua" made.snell -q
    run 0 made.snell -s 48x36 -n 2 -q -o b.png
    run 0 "$source_folder/scenes/whitted-1980.lua" -s 48x36 -n 2 -q -o a.png
    [ "$("$snell" info a.png --json | grep '"scene"')" = "$("$snell" info b.png --json | grep '"scene"')" ] ||
        fail "the compiled scene has another hash"
    run 0 explain b.png 20 20
    run 0 bench made.snell -s 8x8 -n 1 --rounds 1
    run 0 info made.snell
    prints "made.snell: snell"
}

command_line() {
    echo 'sphere { radius = param("radius", 1.0, "metres") }' >ball.lua
    run 0 convert ball.lua half.snell -D radius=0.5 --json
    prints '"output": "half.snell"'
    prints '"size": '
    run 0 half.snell -s 16x16 -q -o half.pfm
    run 0 ball.lua -D radius=0.5 -s 16x16 -q -o source.pfm
    cmp -s half.pfm source.pfm || fail "-D is not in the compiled scene"
    wrong "half.snell: -D radius=1: a compiled scene takes no values" "give -D to snell convert" half.snell -D radius=1
    cat ball.lua | "$snell" convert - stdin.snell -q 2>err || fail "standard input does not become a scene"
    echo 'sphere { material = material.lambert { color = 2 } }' >bright.lua
    run 0 convert bright.lua bright.snell
    [ "$(grep -c warning err)" = 1 ] || fail "a warning is not said once"
    run 4 convert bright.lua bright.snell --strict
    wrong "--exposure is for pictures, and B is a scene" "snell render" convert ball.lua x.snell --exposure 1
    wrong "--set is for scenes, and B is a picture" ".snell" convert half.pfm x.png -D a=1
    wrong "convert needs two names" "such as" convert ball.lua
    refuses 5 "none.lua" "" convert none.lua x.snell
    refuses 5 "cannot be used" "mkdir" convert ball.lua none/x.snell
    refuses 2 "would be written over itself" "another name" convert ball.lua ball.lua
    absent x.snell
    run 0 help convert
    prints ".snell"
    head -c 300 half.snell >cut.snell
    refuses 3 "cut.snell: the compiled scene is cut short" "write it again: snell convert ball.lua cut.snell" cut.snell
}

# What is there stays when the new one cannot be written.
old_files_stay() {
    echo old >keep.snell
    echo old >keep.lua
    echo 'sphere { radius = 1 } for i = 1, 500 do sphere { radius = i } end' >many.lua
    run 0 convert many.lua many.snell -q # needs no helper, whose memory the limit would count
    for kind in snell lua; do
        (trap "" XFSZ; ulimit -f 1; "$snell" convert many.snell keep.$kind >out 2>err) && fail "written, and there was no room"
        says "cannot write"
        [ "$(cat keep.$kind)" = old ] || fail "the old keep.$kind is gone"
    done
    [ -z "$(find . -name '*.tmp')" ] || fail "a temporary file is left"
}

parts showcase formats models nff_scene pbrt_scene layers command_line old_files_stay
