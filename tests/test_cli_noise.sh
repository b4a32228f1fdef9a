#!/bin/bash
# --noise and --time-limit as their users meet them. $1: the build folder.
. "$(dirname "$0")/cli.sh"
says_by=E prints_by=E

cat >lamp.lua <<'END'
render { integrator = "path", width = 48, height = 40, samples = 8, max_depth = 3 }
camera { from = {0, 1.2, 4}, at = {0, 0.8, 0}, fov = 40 }
background { color = {0.2, 0.3, 0.4} }
light.quad { corner = {-0.5, 2, -0.5}, u = {1, 0, 0}, v = {0, 0, 1}, radiance = 8 }
plane { point = {0, 0, 0}, material = material.lambert { color = {0.7, 0.6, 0.5} } }
sphere { center = {0.2, 0.5, 0}, radius = 0.5, material = material.lambert { color = {0.2, 0.4, 0.7} } }
END
sed 's/samples = 8/noise = 0.2/' lamp.lua >own.lua

# ---- a bound --------------------------------------------------------------------------------------
bound() {
    run 0 lamp.lua --noise 8% -o a.png
    says 'a.png  48x40  path  error under [0-9.]+ % \(95 % confidence\)  [0-9]+ to [0-9]+ samples, mean [0-9.]+  '
    run 0 lamp.lua --noise 0.08 -o a.pfm -t 1
    # The command in the tag makes the same picture.
    run 0 info a.png
    prints '--noise=0\.08'
    prints '^error under [0-9.]+ % \(95 % confidence\); 9 of 9 blocks under the noise'
    eval "run 0 $(sed -n 's/^ *snell render \(.*\) -o .*/\1/p' out) -o b.pfm"
    cmp -s a.pfm b.pfm || fail "the tag's command makes another picture"
    # A pixel is explained bit for bit, by the tag and without it.
    for at in "3 5" "20 20" "47 39"; do
        run 0 explain a.png ${at% *} ${at#* }
        prints ": $(pixel ${at% *} ${at#* } 48 40 a.pfm)\$"
    done
    run 0 explain lamp.lua 20 20 --noise 8%
    prints ": $(pixel 20 20 48 40 a.pfm)\$"
    run 2 explain a.png 20 20 --sample 16384
    says 'there is no sample 16384'
    run 0 own.lua -o own.png
    says 'error under [0-9.]+ %'
    run 0 own.lua -n 4 -o own.png
    says 'under 20 % in [0-9.]+ % of blocks  4 samples'
}

json() {
    run 0 lamp.lua --noise 0.5% -n 40 -o c.$float --json
    prints '"noise": \{'
    prints '"confidence": 0.9'
    prints '"blocks": 9'
    prints '"max": 40'
    prints '"samples": 40,'
    run 0 lamp.lua --noise 0.5% -n 40 -o c.png --progress json
    [ $float = exr ] || return 0
    run 0 lamp.lua --noise 0.5% -n 40 --seed 1 -o d.exr
    run 0 compare c.exr d.exr --variance-count 4 --max-rejected 0 --json
    prints '"rejected": 0'
    run 0 convert c.exr samples.pfm --layer samples
}

# ---- layers ---------------------------------------------------------------------------------------
layers() {
    [ $float = exr ] || { echo "NOT TESTED: this build has no OpenEXR"; return; }
    run 0 lamp.lua --noise 8% -o plain.exr
    run 0 lamp.lua --noise 8% --aov depth,emission,direct,indirect,rays -o all.exr
    run 0 info all.exr
    prints '^layers +.*samples.*variance\.B'
    prints '^ +depth: Z'
    run 0 compare plain.exr all.exr --max-rmse 0
    # The z-test finds variance in a file of several parts too.
    run 0 lamp.lua --noise 8% --seed 1 -o other.exr
    run 1 compare plain.exr other.exr --variance-count 4 --json
    sed -n '/"z_test"/,/}/p' out >plain.json
    grep -q '"beyond": [1-9]' plain.json || fail "no z-test"
    run 1 compare all.exr other.exr --variance-count 4 --json
    sed -n '/"z_test"/,/}/p' out | cmp -s - plain.json || fail "another z-test with AOVs"
    run 0 convert all.exr all.pfm --layer samples
    run 0 convert plain.exr plain.pfm --layer samples
    cmp -s all.pfm plain.pfm || fail "AOVs change the samples"
    run 0 lamp.lua --noise 8% --aov depth -o one.png
    [ -s one.depth.png ] || fail "no one.depth.png"
    run 0 lamp.lua --time-limit 1h -n 5 --aov depth -o limited.exr
    run 0 lamp.lua -n 5 --aov depth -o whole.exr
    run 0 convert limited.exr limited.pfm --layer depth
    run 0 convert whole.exr whole.pfm --layer depth
    cmp -s limited.pfm whole.pfm || fail "a time limit changes the depth"
}

# ---- a time ---------------------------------------------------------------------------------------
limit() {
    local n
    for with in "" "--noise 0.1%"; do
        run 0 lamp.lua $with --time-limit 0.3s -o t.pfm
        n=$(sed -n 's/.*  \([0-9]*\) samples  .*/\1/p' err)
        [ "${n:-0}" -ge 2 ] || fail "a time limit does not say how many samples"
        run 0 lamp.lua $with -n "$n" -o n.pfm
        cmp -s t.pfm n.pfm || fail "$with -n $n makes another picture than the time limit"
    done
    run 0 lamp.lua --time-limit 1h -n 3 -o t.pfm
    says '  3 samples'
    run 0 lamp.lua --time-limit 0.2s -o t.png
    run 0 info t.png
    grep -q time out && fail "the tag tells a time"
}

# ---- stopped --------------------------------------------------------------------------------------
stopped() {
    set -m
    "$snell" lamp.lua --noise 0.01% -n 1000000 -s 80x60 -o long.png >out 2>err &
    local pid=$!
    sleep 1.5
    kill -INT $pid
    wait $pid
    [ $? -eq 130 ] || fail "Ctrl-C does not end with 130"
    set +m
    [ -s long.partial.png ] || fail "there is no long.partial.png"
    says_by=E says 'stopped after [0-9.]+ samples a pixel, [0-9.]+ % of the blocks under 0.01 %; the picture is in long.partial.png'
    run 0 explain long.partial.png 40 30
    says 'this is of the samples that it had'
    [ -e long.png ] && fail "a stopped render left long.png"
}

bad() {
    for value in 0 0% -5% abc 101% nan inf '' % 1%%; do
        run 2 lamp.lua --noise "$value" -o x.png
        says "--noise: '$value' is no relative error"
        says 'such as 1% or 0.01'
    done
    for value in 0 0s -3m 90 abc 5x inf s '' 1e400s; do
        run 2 lamp.lua --time-limit "$value" -o x.png
        says "--time-limit: '$value' is no time"
        says 'such as 90s, 10m or 2h'
    done
    run 2 lamp.lua --noise 1% -n 3 -o x.png
    says 'needs --samples 4 or more'
    run 2 explain lamp.lua 1 1 --time-limit 1s
    echo 'render { noise = 2 } sphere {}' >wrong.lua
    run 3 wrong.lua -o x.png
    says 'wrong.lua:1'
    [ -e x.png ] && fail "a wrong command line left a picture"
}

parts bound json layers limit stopped bad
