#!/bin/bash
# snell explain as its users meet it. $1: the build folder.
. "$(dirname "$0")/cli.sh"

cp "$source_folder/scenes/whitted-1980.lua" my.lua
cat >box.lua <<'END'
camera { from = {0, 1, 4}, at = {0, 1, 0}, fov = 40 }
light.point { position = {0, 3, 2}, intensity = 20, name = "key" }
light.quad { corner = {-1, 2.5, -1}, u = {2, 0, 0}, v = {0, 0, 2}, radiance = 2, name = "panel" }
box { min = {-1, 0, -1}, max = {1, param("height", 1.0, "of the box"), 1},
      material = material.lambert { color = .5 }, name = "a \"b\" <c>" }
plane { point = {0, 0, 0}, material = material.mirror { color = .8 } }
END

# ---- the same bits as the picture -----------------------------------------------------------------
bits() {
    local i x y
    for i in appel whitted cook path; do
        run 0 my.lua -i $i -s 32x24 -n 3 -o my.pfm
        for x in 7 15 20; do
            for y in 5 12 19; do
                run 0 explain my.lua $x $y -i $i -s 32x24 -n 3
                prints "pixel $x,$y of my.lua, $i, 3 samples: $(pixel $x $y 32 24 my.pfm)"
            done
        done
    done
    run 0 box.lua -s 32x24 -n 2 -o box.png -D height=1.5 --crop 16x12+8+6 --background transparent --seed 3
    run 0 box.lua -s 32x24 -n 2 -o box.pfm -D height=1.5 --crop 16x12+8+6 --seed 3 --background 0.5
    run 0 explain box.png 3 2
    prints "pixel 3,2 of box.png"
    run 0 box.lua -s 32x24 -n 2 -o again.png -D height=1.5 --crop 16x12+8+6 --seed 3 --background 0.5
    run 0 explain again.png 3 2
    prints ": $(pixel 3 2 16 12 box.pfm)"
}

# ---- what is told ---------------------------------------------------------------------------------
tree() {
    run 0 explain my.lua 400 300 -n 1
    prints 'camera ─▶ "bubble" (dielectric) at'
    prints "├─ reflected × 0.05"
    prints "└─ refracted × 0.94"
    prints "ior 1 → 1.5, Fresnel 0.05"
    prints "Beer 0."
    prints "light point:23 at"
    prints "not traced: under min_weight"
    prints "deeper ray"
    prints "(--levels 7)"
    grep -q $'\033' out && fail "colours without a terminal"
    run 0 explain my.lua 400 300 -n 1 --color always
    grep -q $'\033' out || fail "no colours by --color always"
    run 0 explain my.lua 400 300 -n 1 --levels 0
    prints "… 4"
    [ "$(wc -l <out)" -eq 3 ] || fail "--levels 0 shows more than the camera's ray"
    run 0 explain my.lua 400 300 -n 16
    prints "meet first"
    prints "nearest to the mean"
    run 0 explain my.lua 400 300 -n 16 --sample 3
    prints "sample 3"
    lacks "meet first"
    run 0 explain box.lua 60 590 -n 1
    prints 'plane:6 (mirror)'
    run 0 explain box.lua 400 500 -n 1
    prints '"a ?b? <c>" (lambert)'
    prints 'light "key" at'
    prints 'light "panel" at'
    run 0 explain box.lua 5 5 -n 1
    prints "leaves the scene"
}

drawings() {
    run 0 explain box.lua 400 500 -n 1 --dot
    prints "digraph rays {"
    prints '[label="\"a ?b? <c>\"'
    [ "$(tail -1 out)" = "}" ] || fail "the graph does not end"
    if command -v dot >/dev/null; then dot -Tsvg out >tree.svg 2>err || fail "Graphviz refuses it"; fi
    for view in "" =side =top =camera; do
        run 0 explain box.lua 400 500 -n 1 -s 80x60 --size=800x600 --svg$view
        prints '<svg xmlns="http://www.w3.org/2000/svg"'
        prints '"a ?b? &lt;c>"</text>'
        [ "$(tail -1 out)" = "</svg>" ] || fail "the drawing does not end"
        if command -v xmllint >/dev/null; then xmllint --noout out 2>err || fail "it is no XML"; fi
        if [ "$view" = =camera ]; then prints "data:image/png;base64,iVBORw0KGgo"; else prints 'class="section" d="M'; fi
    done
}

# ---- what is wrong --------------------------------------------------------------------------------
mistakes() {
    local usage="explain needs a FILE and the pixel's X and Y"
    run 0 my.lua -s 40x30 -n 2 -o my.png
    refuses 2 "$usage" "such as" explain
    refuses 2 "$usage" "such as" explain my.png
    refuses 2 "$usage" "such as" explain my.png 3
    refuses 2 "$usage" "such as" explain my.png 3 4 5
    refuses 2 "X: 'a' is no pixel" "top left" explain my.png a 4
    refuses 2 "Y: '1.5' is no pixel" "top left" explain my.png 3 1.5
    refuses 2 "there is no pixel 40,0: the picture is 40x30" "from 0" explain my.png 40 0
    refuses 2 "there is no pixel 0,30: the picture is 40x30" "from 0" explain my.png 0 30
    refuses 2 "there is no pixel 9,5: the picture is 8x6" "from 0" explain my.lua 9 5 -s 40x30 --crop 8x6+1+1
    refuses 2 "--sample: there is no sample 2: the pixel has 2" "from 0" explain my.png 3 3 --sample 2
    refuses 2 "--sample: '-1' is no number" "from 0" explain my.png 3 3 --sample=-1
    refuses 2 "--levels: 'x' is not" "" explain my.png 3 3 --levels x
    refuses 2 "--dot and --svg exclude" "" explain my.png 3 3 --dot --svg
    refuses 2 "--svg: there is no 'left'" "side, top, camera" explain my.png 3 3 --svg=left
    refuses 2 "--samples: my.png says itself how it was made" "explain the scene" explain my.png 3 3 -n 4
    refuses 2 "explain takes no option '--output'" "snell render" explain my.png 3 3 --output x.png
    run 0 my.lua -s 40x30 -n 2 -o bare.png --strip
    refuses 3 "bare.png does not say how it was made" "snell explain SCENE X Y" explain bare.png 3 3
    refuses 5 "nothing.png" "" explain nothing.png 3 3
    refuses 5 "nothing.lua" "" explain nothing.lua 3 3
    echo text >text.png
    refuses 4 "text.png" "" explain text.png 3 3
    # a scene that changed in what it says, not in how it says it; and one that is gone
    run 0 explain my.png 3 3
    cp out before
    { echo "-- a comment"; sed 's/name = "bubble"/name = "other"/' "$source_folder/scenes/whitted-1980.lua"; } >my.lua
    run 0 explain my.png 3 3
    head -1 before | cmp -s - <(head -1 out) || fail "another pixel after a comment"
    sed -i 's/ior = 1.5/ior = 1.6/' my.lua
    refuses 3 "my.lua, or what it loads, changed since my.png was made" "render it again" explain my.png 3 3
    mv my.lua elsewhere.lua
    refuses 5 "my.png was made of 'my.lua', which is not there" "where the picture was made" explain my.png 3 3
    cp "$source_folder/scenes/whitted-1980.lua" my.lua
    # beside the picture, from elsewhere; and from standard input
    mkdir -p sub
    (cd sub && "$snell" explain ../my.png 3 3 >../out 2>../err) || fail "the scene beside the picture is not found"
    "$snell" render - -s 40x30 -n 1 -o piped.png <my.lua 2>err || fail "no picture of standard input"
    "$snell" explain piped.png 3 3 <my.lua >out 2>err || fail "standard input again: refused"
    prints "pixel 3,3 of piped.png"
    refuses 3 "" "" explain piped.png 3 3
    # an error in JSON, too
    run 3 explain bare.png 3 3 --json
    prints '"status": "input"'
}

# ---- what the documentation shows ----------------------------------------------------------------
box() { awk -v open="\`\`\`$1" '$0 == open { on = 1; next } /^```$/ { on = 0 } on' "$source_folder/docs/explain.md"; }
documentation() {
    box "lua ball.lua" >ball.lua
    run 0 ball.lua -s 320x240 -n 1 -o ball.png
    run 0 explain ball.png 160 150 --levels 2
    box text >expected
    diff expected out >differences || { cat differences; fail "docs/explain.md shows something else"; }
    run 0 explain ball.png 160 150 --svg
    cmp -s out "$source_folder/docs/img/explain.svg" || fail "docs/img/explain.svg shows something else"
    "$snell" example whitted-1980 >my.lua
    run 0 explain my.lua 412 305 --sample 0 --levels 1
    sed 's/my.lua/my.png/; s/^/    /' out | while IFS= read -r line; do
        grep -qxF -- "$line" "$source_folder/README.md" || echo "$line"
    done >differences
    [ -s differences ] && { cat differences; fail "README.md shows something else"; }
}

parts bits tree drawings mistakes documentation
