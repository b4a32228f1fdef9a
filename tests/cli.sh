# What the tests of the command share, each of which begins so, and then stands in an empty folder, $work:
#     . "$(dirname "$0")/cli.sh"          $1: the build folder
# `says` and `prints` look for a text as it stands, or after says_by=E or prints_by=E for a pattern of grep -E.
snell=$(cd "${1:?the build folder}" && pwd)/snell
source_folder=$(cd "$(dirname "$0")/.." && pwd)
[ -x "$snell" ] || { echo "$snell is not built"; exit 1; }
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
for name in $(compgen -e SNELL_); do unset "$name"; done
export NO_COLOR=1 TMPDIR=$work/tmp
mkdir tmp
failures=0 says_by=F prints_by=F

built() { "$snell" --version | grep -q "^parts.* $1"; }
float=pfm # with OpenEXR .exr, and what only that can hold
built openexr && float=exr

fail() {
    failures=$((failures + 1))
    echo "FAILED: $*"
    [ -s out ] && head -c 4000 out | sed 's/^/    out: /' | head -40
    [ -s err ] && sed 's/^/    err: /' err | head -20
}
# run CODE ARGUMENT...: runs snell, keeps out and err, compares the exit code.
run() {
    local want=$1 got
    shift
    timeout 300 "$snell" "$@" >out 2>err </dev/null
    got=$?
    [ $got -eq "$want" ] || fail "snell $*: exit $got, not $want"
}
says() { grep -q$says_by -- "$1" err || fail "not on standard error: $1"; }
prints() { grep -q$prints_by -- "$1" out || fail "not on standard output: $1"; }
lacks() { grep -q$prints_by -- "$1" out && fail "on standard output: $1"; }
# refuses CODE MESSAGE HINT ARGUMENT...: nothing on standard output
refuses() {
    local code=$1 message=$2 hint=$3
    shift 3
    run "$code" "$@"
    says "$message"
    says "$hint"
    [ -s out ] && fail "snell $*: an error, and something on standard output"
}
# wrong MESSAGE HINT ARGUMENT...: the command line itself
wrong() {
    local message=$1
    shift
    refuses 2 "snell: $message" "$@"
}
exists() { for file; do [ -s "$file" ] || fail "there is no $file"; done; }
absent() { for file; do [ ! -e "$file" ] || fail "there is a $file"; done; }
# pixel X Y WIDTH HEIGHT FILE.pfm: its three floats, as text that reads back as the same
pixel() {
    local header
    header=$(head -3 "$5" | wc -c)
    od -An -tf4 -w12 -j $((header + ((($4 - 1 - $2) * $3 + $1) * 12))) -N 12 "$5" | tr -s ' ' | sed 's/^ //; s/ $//'
}
# parts NAME...: runs these functions; the last line of a test
parts() {
    local part before
    for part; do
        before=$failures
        $part
        [ $failures -eq $before ] && echo "ok: $part"
    done
    [ $failures -eq 0 ] || { echo "$failures failures"; exit 1; }
}
