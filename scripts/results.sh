#!/usr/bin/env bash
# The published tables of this machine, made anew: Table II by presets paper and fast on each CPU driver that
# scripts/setup.sh --drivers installs, with 95 % intervals over fresh processes, and each driver's verdict against
# the first. The machine has to be quiet. Takes 4 minutes a driver for ten rounds where a frame of 4 million drops
# takes a second, and at most 15 for each verdict.
#
#   scripts/results.sh NAME [options of bench]       writes docs/results/NAME.md, and docs/pictures/passes.svg of the
#                                                    first driver; JSON and a page in out/results
#   ROUNDS=20 VERDICTS=no scripts/results.sh 2026-11-epyc --max-time 30m
#
# RAINDROPS names the program, else it is built. Exit status: 0; 2 for an error, with what was measured until then
# in out/results.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
[ $# -gt 0 ] && [[ $1 != -* ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' scripts/results.sh >&2; exit 2; }
name=$1
shift
fail() { echo "results: $*" >&2; exit 2; }
program=${RAINDROPS:-}
if [ -z "$program" ]; then
  scripts/setup.sh
  scripts/cargo.sh build --release --locked --bin raindrops || fail "the program does not build"
  program=target/release/raindrops
fi

drivers=()
for file in /usr/share/vulkan/icd.d/lvp_icd*.json .setup/lavapipe-backports/lvp_icd.json \
  .setup/swiftshader/vk_swiftshader_icd.json; do
  [ ! -e "$file" ] || drivers+=("$file")
done
[ ${#drivers[@]} -gt 0 ] || fail "there is no CPU driver; scripts/setup.sh --drivers fetches them"

folder=out/results
mkdir -p $folder
page=$folder/$name.md
options="${*:+ $*}"
variables="${ROUNDS:+ROUNDS=$ROUNDS }${VERDICTS:+VERDICTS=$VERDICTS }"
{
  echo "# Table II on CPU drivers"
  echo
  echo "Made by \`${variables}scripts/results.sh $name$options\`: medians of wall-clock milliseconds a frame over ${ROUNDS:-10} fresh"
  echo "processes a driver with their 95 % intervals; FPS-T and ms-T are with tone mapping, FPS and ms without; then"
  echo "milliseconds of each pass. Drivers are told apart by their version. The keys are those of"
  echo "[result files](../result-files.md)."
} >"$page"
results=()
for number in "${!drivers[@]}"; do
  driver=${drivers[$number]}
  json=$folder/$name-$number.json
  echo "results: $driver" >&2
  table=$(VK_DRIVER_FILES=$driver "$program" bench --preset paper,fast --rounds "${ROUNDS:-10}" "$@" \
    --json "$json" --format markdown) || fail "$driver: no result"
  results+=("$json")
  printf '\n## Driver %d\n\n%s\n' "$number" "$table" >>"$page"
done
if [ "${VERDICTS:-yes}" = yes ]; then
  for number in "${!drivers[@]}"; do
    [ "$number" != 0 ] || continue
    json=$folder/$name-0-$number.json
    echo "results: ${drivers[$number]} against ${drivers[0]}" >&2
    table=$("$program" bench --preset paper,fast "$@" --a "VK_DRIVER_FILES=${drivers[0]}" \
      --b "VK_DRIVER_FILES=${drivers[$number]}" --json "$json" --format markdown) || fail "no verdict"
    results+=("$json")
    printf '\n## Driver %d against driver 0\n\n%s\n' "$number" "$table" >>"$page"
  done
fi
"$program" report "${results[@]}" -o "$folder/$name.html"
"$program" report "${results[0]}" -o docs/pictures/passes.svg
RAINDROPS=$program RESULT=${results[0]} scripts/made.sh scripts/results.sh passes.svg
cp "$page" "docs/results/$name.md"
echo "results: docs/results/$name.md, $folder/$name.html" >&2
