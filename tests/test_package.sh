#!/bin/bash
# The packages: the tarball works from any folder with its own libraries, the Debian package names what it needs. $1: the build folder.
build=$(cd "${1:?the build folder}" && pwd)
top=$(cd "$(dirname "$0")/.." && pwd)
if grep -q '^SNELL_SANITIZE:[A-Z]*=.' "$build/CMakeCache.txt"; then
    echo "NOT TESTED: a build with sanitizers is not packaged"
    exit 0
fi
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
for name in $(compgen -e SNELL_); do unset "$name"; done
failures=0
fail() {
    failures=$((failures + 1))
    echo "FAILED: $*"
}

SNELL_PACKAGES=tar "$top/tools/package" "$build" "$work/made" >out 2>&1 || fail "no tarball: $(cat out)"
mkdir -p elsewhere/deep
tar -xzf made/snell-*-linux-*.tar.gz -C elsewhere/deep || fail "the tarball does not unpack"
root=$(echo "$work"/elsewhere/deep/snell-*)
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >tetra.obj
echo 'camera { from = {0, 0, 5} } light.headlight { intensity = 40 } sphere {}' >ball.lua
clean() { env -i PATH=/usr/bin:/bin "$@"; }
clean "$root/bin/snell" ball.lua -s 32x24 -n 1 -o ball.png 2>err || fail "no picture: $(cat err)"
"$build/snell" ball.lua -s 32x24 -n 1 -o same.png 2>err
cmp -s ball.png same.png || fail "the packaged program makes another picture"
if "$build/snell" --version | grep -q '^parts.* assimp'; then
    clean "$root/bin/snell" tetra.obj -s 32x24 -n 1 -o tetra.png 2>err || fail "no picture of a model: $(cat err)"
fi
# Only the C library is the system's; the import helper is the tarball's own.
for file in "$root/bin/snell" "$root/libexec/snell-import" "$root"/lib/libsnell.so.*.*.*; do
    clean ldd "$file" | awk '$2 == "=>" { print $3 }' | grep -v "^$root/" |
        grep -vE '/(libc|libm|libdl|libpthread|librt|libresolv)\.so' >foreign && fail "$file needs $(cat foreign)"
done
mv "$root/libexec/snell-import" away
clean "$root/bin/snell" ball.lua -s 32x24 -o none.png 2>err && fail "a scene is read by a helper from elsewhere"
[ -n "$(ls "$root/share/doc/snell/licenses")" ] || fail "there are no licences"

if command -v dpkg-shlibdeps >/dev/null && command -v dpkg-deb >/dev/null; then
    SNELL_PACKAGES=deb "$top/tools/package" "$build" "$work/made" >out 2>&1 || fail "no Debian package: $(cat out)"
    dpkg-deb -f made/*.deb Depends >depends || fail "this is no Debian package"
    grep -q 'libc6' depends && grep -q 'libsleef' depends || fail "it depends on $(cat depends)"
    grep -q 'libsnell' depends && fail "it depends on itself"
    dpkg-deb -c made/*.deb >content
    for file in usr/bin/snell usr/libexec/snell-import usr/include/snell/snell.h usr/share/man/man1/snell.1 usr/lib/pkgconfig/snell.pc; do
        grep -q " \./$file$" content || fail "it lacks $file"
    done
    mkdir installed
    dpkg-deb -x made/*.deb installed
    clean installed/usr/bin/snell ball.lua -s 32x24 -n 1 -o deb.png 2>err || fail "the Debian package makes no picture: $(cat err)"
else
    echo "NOT TESTED: there is no dpkg-shlibdeps"
fi
[ $failures -eq 0 ] || exit 1
echo "all right"
