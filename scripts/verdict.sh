#!/usr/bin/env bash
# Is this tree slower than another commit, or does it draw something else? Builds both, runs them in turn, and
# writes the verdict as a table for a comment (verdict.md), JSON, JUnit XML and a page. Options go to
# `raindrops bench`.
#
#   scripts/verdict.sh origin/main
#   scripts/verdict.sh v0.1.0 --preset paper,fast --drops 125000 --fail-above 10%
#
# Results go to out/verdict, or to the folder that VERDICT_FOLDER names. Exit status: 0; 1 if --fail-above was
# given and a row is slower, different or missing; 2 for an error.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || { sed -n '2,/^set /s/^# \{0,1\}//p' scripts/verdict.sh >&2; exit 2; }
wanted=$1
shift
fail() { echo "verdict: $*" >&2; exit 2; }

commit=$(git rev-parse --quiet --verify "$wanted^{commit}") ||
  fail "there is no commit '$wanted' here; in a shallow clone fetch it first"
folder=${VERDICT_FOLDER:-out/verdict}
mkdir -p "$folder"
rm -f "$folder"/verdict.* # an earlier verdict must not be taken for this one
scripts/setup.sh
[ ! -f .setup/shaderc/libshaderc_combined.a ] || export SHADERC_LIB_DIR=${SHADERC_LIB_DIR:-$PWD/.setup/shaderc}

# One folder for both builds, so that dependencies are compiled once.
export CARGO_TARGET_DIR=$PWD/target/verdict
tree=$CARGO_TARGET_DIR/base
remove_tree() { git worktree remove --force "$tree" 2>/dev/null || true; }
trap remove_tree EXIT
remove_tree
git worktree prune
git worktree add --quiet --detach "$tree" "$commit"
build() { # tree, name of the program
  (cd "$1" && cargo build --release --locked --bin raindrops) || fail "$2 does not build"
  cp "$CARGO_TARGET_DIR/release/raindrops" "$folder/$2"
}
PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
build "$tree" base
build . head

status=0
"$folder/head" bench --a-binary "$folder/base" --b-binary "$folder/head" "$@" --format markdown \
  --json "$folder/verdict.json" --junit "$folder/verdict.xml" >"$folder/verdict.md" || status=$?
if [ -s "$folder/verdict.md" ]; then cat "$folder/verdict.md"; else rm "$folder/verdict.md"; fi
[ $status -gt 1 ] || "$folder/head" report "$folder/verdict.json" -o "$folder/verdict.html"
exit $status
