#!/bin/bash
# docs/gallery.md belongs to the scenes and pictures; tools/gallery makes it, and --check sees what is
# amiss. $1: the build folder.
build=$(cd "${1:?the build folder}" && pwd)
top=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
for name in $(compgen -e SNELL_); do unset "$name"; done
failures=0

fail() {
    failures=$((failures + 1))
    echo "FAILED: $*"
    sed 's/^/    /' "$work/log" | head -20
}

"$top/tools/gallery" --check >"$work/log" 2>&1 || fail "the gallery is not that of the scenes"

# A gallery of one small scene, to be broken.
mkdir -p "$work/tools" "$work/scenes" "$work/docs/img"
cp "$top/tools/gallery" "$work/tools"
cat >"$work/scenes/dot.lua" <<'END'
-- A dot
--
-- White, on black.
-- Try:  something else
render { width = 16, height = 12, samples = 1 }
background { color = 0 }
sphere { radius = 1, material = material.lambert { emission = 1 } }
END
cp -r "$work/scenes" "$work/scenes.good"

make_gallery() { "$work/tools/gallery" "$build" >"$work/log" 2>&1 || fail "tools/gallery: exit $?"; }
is_amiss() { # WHAT EXPECTED: --check says so
    "$work/tools/gallery" --check >"$work/log" 2>&1 && fail "--check did not see $1"
    grep -q -- "$2" "$work/log" || fail "--check did not say '$2' about $1"
    rm -rf "$work/scenes" "$work/docs"
    cp -r "$work/scenes.good" "$work/scenes"
    cp -r "$work/docs.good" "$work/docs"
}

make_gallery
grep -q '^White, on black.$' "$work/docs/gallery.md" || fail "the page lacks the scene's words"
grep -q 'something else' "$work/docs/gallery.md" && fail "the page has what to try"
grep -q 'hash `[0-9a-f]\{16\}` · whitted, 16 x 12, 1 samples' "$work/docs/gallery.md" || fail "the page lacks facts"
cp -r "$work/docs" "$work/docs.good"
make_gallery
diff -r "$work/docs" "$work/docs.good" >"$work/log" || fail "a second run changed something"

cp "$work/scenes/dot.lua" "$work/scenes/spot.lua"
is_amiss "a scene without an entry" "spot: the page has no entry"
sed -i 's/radius = 1/radius = 2/' "$work/scenes/dot.lua"
is_amiss "another program" "dot: the scene has changed"
sed -i 's/White/Grey/' "$work/scenes/dot.lua"
is_amiss "other words" "says something else"
rm "$work/docs/img/dot.png"
is_amiss "a lost picture" "there is no docs/img/dot.png"
cp "$work/docs/img/dot.png" "$work/docs/img/old.png"
is_amiss "a picture too many" "old.png: of no scene"
head -c 800000 /dev/zero >"$work/docs/img/dot.png"
is_amiss "a huge picture" "is larger than"
"$work/tools/gallery" --check >"$work/log" 2>&1 || fail "--check finds fault with what is right"

[ "$failures" -eq 0 ] && echo "gallery: ok"
exit "$((failures > 0))"
