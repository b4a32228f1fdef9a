#!/bin/bash
# snell bench as its users meet it; its --json is in test_cli_json.c. $1: the build folder.
. "$(dirname "$0")/cli.sh"
prints_by=E

cat >ball.lua <<'END'
camera { from = {0, 1, 4}, at = {0, 0, 0} }
light.point { position = {3, 3, 3}, intensity = 30 }
sphere { material = material.mirror {} }
plane { point = {0, -1, 0}, material = material.lambert { color = param("grey", 0.5) } }
END
# Long thin triangles, every box of which is nearly the whole.
cat >thin.lua <<'END'
camera { from = {0, 0, 4}, at = {0, 0, 0} }
light.point { position = {1, 3, 3}, intensity = 40 }
local positions, indices = {}, {}
for i = 0, 499 do
  local d = {math.sin(i * .7), math.cos(i * .7), math.sin(i * .31)}
  for _, k in ipairs {-1, 1} do positions[#positions + 1] = {k * d[1], k * d[2], k * d[3]} end
  positions[#positions + 1] = {d[1] + .004, d[2], d[3]}
  for k = 0, 2 do indices[#indices + 1] = 3 * i + k end
end
mesh { positions = positions, indices = indices }
END
{
    echo 'camera { from = {0, 0, 4}, at = {0, 0, 0} } plane { point = {0, 0, -1}, normal = {0, 0, 1} }'
    echo 'for i = 1, 40 do light.point { position = {i / 20, 3, 3} } end'
} >lights.lua
{
    echo 'camera { from = {0, 0, 4}, at = {0, 0, 0} } plane { point = {0, 0, -1}, normal = {0, 0, 1} }'
    echo 'for i = 1, 12 do disk { center = {i / 6 - 1, 0, 1}, normal = {0, 0, -1}, radius = 0.05, material = material.emissive { radiance = 3 } } end'
} >labels.lua

# ---- the table ------------------------------------------------------------------------------------
run 0 bench ball.lua -s 80x60 -n 4 -t 1 --rounds 3
prints '^ball.lua: 80x60, whitted, 4 samples, 1 thread, (scalar|avx2|avx512); 3 rounds, medians$'
for row in load build render '  camera rays' '  trace' '  shade' '  shadows' '  film and rest' write all; do
    prints "^$row +[0-9.]+ .*%$"
done
prints '^camera +19 200 +[0-9.]+ % '
prints '^reflected +[1-9]'
prints '^shadow +[1-9]'
lacks '^refracted'
prints '^nearest hits +[0-9.]+ '
prints '^tree \(BVH\) +[0-9.]+ [KM]?i?B$'
lacks 'triangles tested'
lacks 'many lights'
[ -s err ] && fail "something on standard error"
run 0 bench ball.lua -s 50% -n 1 -i path -D grey=.2 --crop 8x6+1+1 --rounds 1
prints 'path, 1 sample, .*; 1 round$'
run 0 bench ball.lua -s 8x6 -n 32 --noise 5% --rounds 1
prints ': 8x6, whitted, up to [0-9]+ samples?, '
"$snell" bench - -s 8x6 -n 1 --rounds 2 <ball.lua >out 2>err || fail "no rounds of standard input"
prints '^standard input: 8x6, whitted, 1 sample, .*; 2 rounds, medians$'
echo 'sphere { radus = 1 }' | "$snell" bench - >out 2>err
[ "${PIPESTATUS[1]}" -eq 3 ] || fail "an error on standard input"
grep -q '^.*standard input:1' err || fail "an error on standard input has no line"
[ "$(ls)" = "$(printf '%s\n' ball.lua err labels.lua lights.lua out thin.lua tmp)" ] || fail "something was written: $(ls)"

# ---- advice ---------------------------------------------------------------------------------------
run 0 bench thin.lua -s 40x30 -n 1 --rounds 1
prints '^- [0-9]+ triangles tested a ray, where over 15 is much: long thin'
run 0 bench lights.lua -s 40x30 -n 1 --rounds 1
prints 'shadow rays for each ray that looks for a hit'
lacks 'shines by itself'
run 0 bench labels.lua -s 40x30 -n 1 --rounds 1
prints 'shines by itself'
SNELL_ISA=scalar run 0 bench ball.lua -s 8x6 -n 1 --rounds 1
prints '^- rays are traced without SIMD'

# ---- the machine ----------------------------------------------------------------------------------
run 0 bench --rounds 1 -t 2
prints '^balls, whitted, 400x300, 16 samples; snell [0-9.]+, .*; 1 round$'
prints '^ +1 +[0-9.]+ .* 1\.00 '
prints '^ +2 +[0-9.]+ '
run 0 bench --rounds 1 -t 1
[ "$(grep -c '^ *1 ' out)" -eq 1 ] || fail "one thread is measured twice"

# ---- what is wrong --------------------------------------------------------------------------------
refuses 2 "bench takes one FILE" "" bench a.lua b.lua
refuses 2 "--size: bench without FILE" "" bench -s 4x4
refuses 2 "--rounds: '0' is not" "" bench ball.lua --rounds 0
refuses 2 "--rounds: '102' is not" "" bench ball.lua --rounds 102
refuses 2 "bench takes no option '-o'" "" bench ball.lua -o x.png
refuses 5 "nothing.lua" "" bench nothing.lua
echo 'sphere { radus = 1 }' >bad.lua
refuses 3 "bad.lua:1" "" bench bad.lua
timeout 60 "$snell" bench ball.lua -n 100000 --rounds 3 >out 2>err &
pid=$!
sleep 1
kill -TERM $pid
wait $pid
[ $? -eq 143 ] || fail "SIGTERM ended it otherwise than by SIGTERM"
[ -s out ] && fail "stopped, and something on standard output"
[ -n "$(find . -name 'snell-*')" ] && fail "a temporary folder is left"

[ "$failures" -eq 0 ] && echo "bench: ok"
exit "$((failures > 0))"
