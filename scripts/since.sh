#!/usr/bin/env bash
# What has become slower or faster since two fixed commits, the ends of the first two stages: builds them and this tree, and
# judges `fast` of each against this tree's in turn, by the program's own comparison. Small losses, each within what one
# comparison can tell, do not add up unseen so. The machine has to be quiet. With 40 rounds it takes about an hour.
#
#   scripts/since.sh                     all; adds its rows to docs/results/since.csv
#   ROUNDS=12 scripts/since.sh table-2   one of: table-2, rain-at-rest, rain-exposed, streaks, close-up
#
# Results go to out/since, which keeps the old programs. A scene that an old program cannot draw has no row. Exit status: 0;
# 2 for an error.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
fail() { echo "since: $*" >&2; exit 2; }
[ $# -gt 0 ] || set -- table-2 rain-at-rest rain-exposed streaks close-up
folder=$PWD/out/since
mkdir -p "$folder"
scripts/setup.sh
[ ! -f .setup/shaderc/libshaderc_combined.a ] || export SHADERC_LIB_DIR=${SHADERC_LIB_DIR:-$PWD/.setup/shaderc}
PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin

# One folder for all builds, so that dependencies that they share are compiled once.
export CARGO_TARGET_DIR=$PWD/target/verdict
tree=$CARGO_TARGET_DIR/base
trap 'git worktree remove --force "$tree" 2>/dev/null || true' EXIT
for commit in 05437b1 7434b7a; do
  [ ! -x "$folder/$commit" ] || continue
  git rev-parse --quiet --verify "$commit^{commit}" >/dev/null || fail "there is no commit $commit here; fetch the whole history"
  git worktree remove --force "$tree" 2>/dev/null || true
  git worktree add --quiet --detach "$tree" "$commit"
  (cd "$tree" && cargo build --release --locked --bin raindrops) || fail "$commit does not build"
  cp "$CARGO_TARGET_DIR/release/raindrops" "$folder/$commit"
done
cargo build --release --locked --bin raindrops || fail "this tree does not build"
cp "$CARGO_TARGET_DIR/release/raindrops" "$folder/head"

scene() { # name, lines: a scene that every program reads, or refuses
  { echo '[image]'; echo 'width = 1024'; echo 'height = 1024'; printf '%s\n' "${@:2}"; } >"$folder/$1.toml"
}
scene rain-at-rest '[camera]' 'vertical_fov = 60.0' '[rain]' 'rate = 25.0'
scene rain-exposed '[camera]' 'vertical_fov = 60.0' 'shutter = 0.016666666666666666' '[rain]' 'rate = 25.0'
scene streaks '[camera]' 'vertical_fov = 60.0' 'near = 8.0' 'shutter = 4.0' '[rain]' 'count = 1000000'
scene close-up '[[drop]]' 'center = [0.0, 0.0, -3.0]' 'radius = 1.0'

head="$(git describe --always --dirty --exclude '*')"
kept=docs/results/since.csv
[ -f $kept ] || echo "commit,against,scene,row,ratio,low,high,ms_before,ms,rounds,processor" >$kept
for commit in 05437b1 7434b7a; do
  for name in "$@"; do
    what=("$folder/$name.toml")
    [ "$name" != table-2 ] || what=(--drops 125000,1000000,4000000)
    result=$folder/$name-$commit.json
    rm -f "$result"
    "$folder/head" bench "${what[@]}" --preset fast --a-binary "$folder/$commit" --b-binary "$folder/head" \
      --rounds "${ROUNDS:-40}" --json "$result" --format markdown || true
    [ -f "$result" ] || { echo "since: $commit does not draw $name" >&2; continue; }
    python3 - "$result" "$head" "$commit" "$name" >>$kept <<'PY'
import json, sys
result, head, commit, name = sys.argv[1:]
report = json.load(open(result))
for row in report["rows"]:
    if row.get("ratio") is None:
        continue
    figures = [row[key] for key in ("ratio", "ratio_low", "ratio_high", "median_ms_a", "median_ms_b")]
    what = row["name"].replace(",", "")
    print(head, commit, name, what, *(f"{figure:.4g}" for figure in figures), row["rounds"], report["b"]["host"]["cpu"].replace(",", ""), sep=",")
PY
  done
done
column -s, -t $kept | tail -40
