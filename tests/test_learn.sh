#!/bin/bash
# docs/learn says what is so: code that it quotes is in the source, and commands print what stands under
# them. tools/learn makes the pages; --check sees what is amiss. $1: the build folder.
build=$(cd "${1:?the build folder}" && pwd)
top=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
failures=0

fail() {
    failures=$((failures + 1))
    echo "FAILED: $*"
    sed 's/^/    /' "$work/log" | head -30
}

"$top/tools/learn" --check "$build" >"$work/log" 2>&1 || fail "docs/learn says what is not so"
quotes=$(sed -n 's/.* \([0-9]*\) quotes.*/\1/p' "$work/log")
[ "${quotes:-0}" -ge 30 ] || fail "only ${quotes:-no} quotes were checked"

# A small page, to be broken.
mkdir -p "$work/good/tools" "$work/good/docs/learn" "$work/good/src"
cp "$top/tools/learn" "$work/good/tools"
cd "$work/good" || exit 1
cat >src/sum.c <<'END'
static int twice(int a) {
    int b = a + a;
    return b;
}

static int thrice(int a) {
    return a + a + a;
}
END
cat >docs/learn/dot.lua <<'END'
render { width = 16, height = 12, samples = 1 }
camera { from = {0, 0, 4}, at = {0, 0, 0} }
background { color = 0.25 }
sphere { radius = 1, material = material.mirror { color = 0.5 }, name = "dot" }
END
echo 'One page: [dot](dot.md)' >docs/learn/README.md
cat >docs/learn/dot.md <<'END'
# Dot

```c src/sum.c twice
    int b = a + a;
    return b;
```

![A dot](img/dot.png)

```text
$ snell render dot.lua -o img/dot.png
$ snell explain dot.lua 8 6
```
END

learn() { "$work/now/tools/learn" "$@" "$build" >"$work/log" 2>&1; }
fresh() {
    rm -rf "$work/now"
    cp -r "$work/good" "$work/now"
    cd "$work/now/docs/learn" || exit 1
}
is_amiss() { # WHAT EXPECTED: --check says so
    learn --check && fail "--check did not see $1"
    grep -qF -- "$2" "$work/log" || fail "--check did not say '$2' about $1"
    fresh
}

fresh
learn || fail "tools/learn: exit $?"
grep -q '^pixel 8,6 of dot.lua, whitted, 1 sample: 0.125 ' dot.md || fail "the page lacks what explain prints"
[ -s img/dot.png ] || fail "there is no picture"
rm -rf "$work/good"
cp -r "$work/now" "$work/good"
learn || fail "a second run: exit $?"
diff -r "$work/good" "$work/now" >"$work/log" || fail "a second run changed something"
learn --check || fail "--check finds fault with what is right"

sed -i 's/a + a;/2 * a;/' ../../src/sum.c
is_amiss "a line of code that changed" "src/sum.c no longer has the lines quoted of twice"
sed -i 's/twice/double/' ../../src/sum.c
is_amiss "a function with another name" "the lines quoted of twice are elsewhere"
rm ../../src/sum.c
is_amiss "a file that went" "there is no"
sed -i 's/^ *return b;$/\n\n\n\n\n\n\n\n&/' dot.md
is_amiss "a long quote" "has 10 lines, not 1 to 8"
sed -i 's/0\.125 /0.126 /' dot.md
is_amiss "another number under a command" "prints something else now"
sed -i 's/^\$ snell explain/$ cat/' dot.md
is_amiss "a command of another program" "is no command of snell"
sed -i 's/snell explain dot.lua 8 6/snell explain dot.lua 99 6/' dot.md
is_amiss "a command that fails" "fails:"
sed -i 's/color = 0.5/color = 0.6/' dot.lua
is_amiss "a picture of another scene" "changed since img/dot.png was made"
rm img/dot.png
is_amiss "a lost picture" "there is no img/dot.png"
cp img/dot.png img/old.png
is_amiss "a picture of no page" "no page makes img/old.png"
head -c 200000 /dev/zero >img/dot.png
is_amiss "a huge picture" "is larger than"
echo '[more](more.md)' >>dot.md
is_amiss "a link to nothing" "there is no more.md"
echo nothing >README.md
is_amiss "a page that the index lacks" "does not lead to dot.md"
sed -i '$d' dot.md
is_amiss "a box without an end" "a box does not end"
SNELL_FULL=1 learn --check || fail "--check with SNELL_FULL finds fault with what is right"
sed -i 's/dot.lua -o/dot.lua --exposure 1 -o/' dot.md
SNELL_FULL=1 is_amiss "a picture by other options" "makes another picture"

[ "$failures" -eq 0 ] && echo "learn: ok"
exit "$((failures > 0))"
