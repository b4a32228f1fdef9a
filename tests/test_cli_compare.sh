#!/bin/bash
# snell compare and snell convert as their users meet them. $1: the build folder.
. "$(dirname "$0")/cli.sh"
prints_by=E
silent() { [ ! -s "$1" ] || fail "$1 is not empty"; }
same() { cmp -s "$1" "$2" || fail "$1 and $2 are not the same"; }
# ppm NAME BYTE...: grey levels of a row of pixels
ppm() {
    local name=$1 byte
    shift
    printf 'P6 %d 1 255\n' $# >"$name"
    for byte in "$@"; do printf "\\x$(printf %x "$byte")%.0s" 1 2 3 >>"$name"; done
}

numbers() {
    ppm a.ppm 0 100 200 255
    ppm b.ppm 0 100 190 255
    run 0 compare a.ppm a.ppm
    prints '^equal$'
    run 1 compare a.ppm b.ppm
    silent err
    prints '^a.ppm  b.ppm  4x1  as shown'
    prints '^differing +1 of 4 pixels \(25 %\)$'
    prints '^largest +0.0392157 at 2,0$' # 10 / 255
    prints '^RMSE +0.0196078$'            # half of it
    prints '^PSNR +34.15 dB$'
    prints '^FLIP +0\.[0-9]+$'
    prints '^relMSE +0.000615'            # (10/255)^2 / ((200/255)^2 + 0.01) / 4
    run 1 compare b.ppm a.ppm             # B is the reference now
    prints '^relMSE +0.000680'
    # what the file is does not matter, only what it shows
    run 0 convert a.ppm a.png
    run 0 compare a.ppm a.png
    run 1 compare a.png b.ppm
    prints '^largest +0.0392157 at 2,0$'
}

# a picture in rows and in tiles, of every kind of levels and most kinds of compression
tiles() {
    built openexr || { echo "NOT TESTED: this build has no OpenEXR"; return; }
    command -v exrmaketiled >/dev/null || { echo "NOT TESTED: there is no exrmaketiled (package openexr)"; return; }
    echo 'camera { from = {0, 0, 4}, at = {0, 0, 0} } background { color = {1, 2, 3}, top = {.1, .2, .3} } sphere {}' >tiles.lua
    run 0 tiles.lua -s 53x37 -n 2 --aov depth -o rows.exr
    run 0 convert rows.exr plain.exr
    local kind size compression
    for compression in none rle zip piz; do
        for kind in -o -m -r; do
            for size in "5 3" "16 16" "64 64"; do
                exrmaketiled $kind -t $size -z $compression plain.exr tiled.exr || fail "exrmaketiled"
                run 0 compare rows.exr tiled.exr
                prints '^equal$'
            done
        done
    done
    exrmaketiled -z b44 plain.exr b44.exr
    run 4 compare rows.exr b44.exr
    says "compression cannot be read"
}

limits() {
    run 0 compare a.ppm b.ppm --max-rmse 0.02 --max-difference 0.04 --max-differing 1 --min-psnr 34
    silent err
    run 0 compare a.ppm b.ppm --max-differing 25% --max-rel-mse 0.001 --max-flip 0.5
    run 1 compare a.ppm b.ppm --max-rmse 0.0196 --max-differing 24.9% --min-psnr 35
    says "RMSE, 0.0196078, is over --max-rmse 0.0196"
    says "the number of differing pixels, 1, is over --max-differing 24.9%"
    says "PSNR, 34.1514, is under --min-psnr 35"
    run 1 compare a.ppm b.ppm --max-rel-mse 0.0006
    run 1 compare a.ppm b.ppm --max-difference 0.039
    run 1 compare a.ppm b.ppm --max-flip 0.0001
    run 1 compare a.ppm b.ppm -q --max-flip 0.0001
    silent out
    silent err
    run 0 compare a.ppm a.ppm -q --max-flip 0 --min-psnr 1000
    # a row on which NaN stands is over any limit but that of differing pixels
    printf 'PF\n2 1\n-1\n\0\0\xc0\x7f\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0' >nan.pfm
    printf 'PF\n2 1\n-1\n\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0' >black.pfm
    run 1 compare nan.pfm black.pfm --max-rmse 1
    says "nan.pfm: warning: 1 pixel is NaN or infinite, the first at 0,0"
    says "1 pixel is NaN or infinite: how far they are apart is not known"
    prints '^left out +1 pixels'
    run 0 compare nan.pfm nan.pfm
    run 4 compare nan.pfm nan.pfm --strict
}

errors() {
    run 1 compare a.ppm b.ppm --error d.ppm --error-map difference
    printf 'P6\n4 1\n255\n\0\0\0\0\0\0\n\n\n\0\0\0' | cmp -s - d.ppm || fail "the differences are not 0 0 10 0"
    run 1 compare a.ppm b.ppm --error flip.png
    run 0 info flip.png
    prints '4x1, 3 channels of 8 bits'
    run 1 compare a.ppm b.ppm --error flip.pfm
    head -c 2 flip.pfm | grep -q PF || fail "the errors as numbers"
    # it is there even where a limit is not kept, and not where there was nothing to compare
    run 1 compare a.ppm b.ppm --max-flip 0 --error over.png
    [ -s over.png ] || fail "no picture of errors over a limit"
    echo "an older file" >old.png
    run 5 compare a.ppm none.ppm --error old.png
    [ "$(cat old.png)" = "an older file" ] || fail "--error of a failed comparison is written"
}

looks() { # of floats: by their own scene, by the command line
    printf '%s\n' 'render { exposure = 1, tonemap = "reinhard" } sphere {} light.headlight { intensity = 40 }' >look.lua
    run 0 look.lua -s 40x30 -n 2 -o look.png
    run 0 look.lua -s 40x30 -n 2 -o look.ppm
    run 0 look.lua -s 40x30 -n 2 -o look.pfm
    if [ $float = exr ]; then
        run 0 look.lua -s 40x30 -n 2 -o look.exr
        run 0 convert look.exr again.png
        says "again.png  40x30  from look.exr"
        same again.png look.png # to the last byte, tag included
        run 0 convert look.exr again.ppm
        same again.ppm look.ppm
        run 0 convert look.exr again.exr
        same again.exr look.exr
        run 0 convert look.exr again.pfm
        same again.pfm look.pfm
        run 0 compare look.exr look.png
        prints '^equal$'
        run 0 compare look.png look.exr --max-flip 0
        run 1 compare look.png look.exr --exposure 0
        run 0 compare look.exr look.pfm # the same light
        prints '^equal$'
        # another look is told by the tag as if render had been asked for it
        run 0 look.lua -s 40x30 -n 2 --exposure -1 --tonemap neutral -o dark.png
        run 0 convert look.exr dark2.png --exposure -1 --tonemap neutral
        run 0 compare dark.png dark2.png
        prints '^equal$'
        run 0 info dark2.png
        prints '--exposure=-1 --tonemap=neutral -o dark2.png$'
        "$snell" look.lua -s 40x30 -n 2 -o - --format exr 2>err | "$snell" convert - - 2>err >pipe.png
        run 0 compare pipe.png look.png
        run 0 convert look.exr plain.png --strip
        run 0 info plain.png
        prints 'does not say how it was made'
    fi
    # a PFM has no tag: what is asked for is done
    run 0 convert look.pfm again.png --exposure 1 --tonemap reinhard
    run 0 compare again.png look.png
    run 0 compare look.pfm look.png --exposure 1 --tonemap reinhard
    run 1 compare look.pfm look.png
    # of a picture as shown no render makes a brighter one
    run 0 convert look.png bright.png --exposure 0.5
    run 0 info bright.png
    prints '--exposure=1 --tonemap=reinhard -o bright.png$'
    prints '^and then snell convert with --exposure=0.5$'
    run 0 convert bright.png bright.ppm --tonemap neutral
    run 0 info bright.ppm
    prints '^and then snell convert with --exposure=0.5 --tonemap=neutral$'
    run 0 convert look.png unchanged.png
    same unchanged.png look.png
}

mistakes() {
    wrong "compare needs two pictures" "such as" compare a.ppm
    wrong "compare needs two pictures" "such as" compare a.ppm b.ppm a.ppm
    wrong "convert needs two names" "such as" convert a.ppm
    wrong "--max-flip: 'x' is not a number" "" compare a.ppm b.ppm --max-flip x
    wrong "--max-differing: '-1' is no number of pixels" "0.1%" compare a.ppm b.ppm --max-differing=-1
    wrong "--max-differing: '101%' is no number of pixels" "0.1%" compare a.ppm b.ppm --max-differing 101%
    wrong "--ppd: '0' is not a number from 1 to 1000" "" compare a.ppm b.ppm --ppd 0
    wrong "--variance-count: '1' is not a whole number from 2" "" compare a.ppm b.ppm --variance-count 1
    wrong "--max-rejected: neither picture has a layer 'variance'" "variance.R" compare a.ppm b.ppm --max-rejected 0
    wrong "--error-map needs --error FILE" "such as" compare a.ppm b.ppm --error-map flip
    wrong "--error-map: there is no 'flup'" "did you mean 'flip'?" compare a.ppm b.ppm --error x.png --error-map flup
    wrong "--error would replace ./b.ppm" "another" compare a.ppm ./b.ppm --error b.ppm
    wrong "--error: 'x.gif' is no kind of picture" ".png" compare a.ppm b.ppm --error x.gif
    wrong "--error cannot be standard output" "" compare a.ppm b.ppm --error -
    wrong "compare does not read standard input" "" compare a.ppm -
    wrong "--exposure and --tonemap change nothing" ".exr" compare a.ppm b.ppm --exposure 1
    wrong "a.ppm: it has no layers" "OpenEXR" compare a.ppm b.ppm --layer depth
    wrong "a.ppm: it has no layers" "OpenEXR" convert a.ppm x.png --layer depth
    wrong "'x.gif' is no kind of picture" ".png" convert a.ppm x.gif
    wrong "'tmp' is a folder" "" convert a.ppm tmp
    wrong "--exposure: '51' is not" "" convert a.ppm x.png --exposure 51
    wrong "x.pfm: --tonemap would change nothing" ".png" convert look.pfm x.pfm --tonemap clip
    wrong "--format is for standard output" "extension" convert a.ppm x.png --format png
    wrong "compare takes no option '--size'" "snell render" compare a.ppm b.ppm --size 3x3
    [ -e x.png ] && fail "a wrong command line wrote a picture"
    run 2 convert a.ppm - --json
    says "the picture and --json both want standard output"
    ppm small.ppm 1 2
    run 3 compare a.ppm small.ppm
    says "snell: small.ppm: the picture has 2 x 1 pixels, the reference 4 x 1"
    says "only pictures of one size can be compared"
}

bad_files() { # each bad input: its exit code and message; the older output survives
    refuses() { # refuses CODE MESSAGE FILE
        echo "an older picture" >old.png
        run "$1" convert "$3" old.png
        says "$2"
        [ "$(cat old.png)" = "an older picture" ] || fail "$3: the older picture is gone"
        run "$1" compare "$3" a.ppm
        says "$2"
        run "$1" compare a.ppm "$3"
        says "$3"
    }
    printf '' >empty.png
    refuses 3 "the file is empty" empty.png
    echo 'sphere {}' >scene.lua
    refuses 4 "this is no picture that snell reads" scene.lua
    says "'snell render' makes a picture of a scene"
    head -c 300 look.png >cut.png
    refuses 3 "cut.png: a broken PNG image" cut.png
    head -c 20 b.ppm >cut.ppm
    refuses 3 "cut.ppm: the file ends early" cut.ppm
    printf 'P6 65536 65536 255\n' >huge.ppm
    refuses 4 "65536 x 65536 pixels is too large" huge.ppm
    printf 'PF\n99999 2\n-1\n' >wide.pfm
    refuses 3 "99999 x 2 pixels cannot be read" wide.pfm
    printf 'RIFF0000WEBPVP8 ' >new.png
    built webp && refuses 3 "a broken WebP image" new.png
    refuses 5 "No such file or directory" none.png
    mkdir -p folder.png
    refuses 5 "Is a directory" folder.png
    mkfifo queue.png
    refuses 5 "not a regular file" ./queue.png
    if [ $float = exr ]; then
        head -c 400 look.exr >cut.exr
        refuses 3 "cut.exr" cut.exr
    fi
    ls -a | grep -q '\.tmp\|^\.snell' && fail "a temporary file is left"
    [ -z "$(ls -A tmp)" ] || fail "something is left in TMPDIR"
}

stopping() { # a comparison that takes long ends when it is told to
    for name in large larger; do
        { printf 'P5 8000 4000 255\n'; head -c 32000000 /dev/urandom; } >$name.ppm
    done
    # the sanitizers' shadow memory needs more than any limit
    if ! ldd "$snell" | grep -qE 'lib[at]san'; then
        run 6 convert large.ppm old.png --memory 64M
        says "--memory"
    fi
    "$snell" compare large.ppm larger.ppm -t 1 --error old.png >out 2>err &
    local job=$!
    sleep 1.5
    kill -TERM $job 2>/dev/null
    wait $job
    local got=$?
    [ $got -eq 143 ] || fail "SIGTERM ends a comparison with $got"
    silent out
    [ "$(cat old.png)" = "an older picture" ] || fail "a stopped comparison wrote its errors"
    rm large.ppm larger.ppm
}

parts numbers tiles limits errors looks mistakes bad_files stopping
