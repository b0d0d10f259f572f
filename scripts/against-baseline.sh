#!/usr/bin/env bash
# Measures this machine and holds the result against results that were kept in a folder, on the same machine at
# other times. The first runs make the baseline; it changes no more after that, so that a slow decline cannot
# creep into it. Options go to `raindrops bench`, and must stay the same.
#
#   scripts/against-baseline.sh FOLDER [options of bench]
#   BASELINE_RUNS=5 FAIL_ABOVE=10% scripts/against-baseline.sh results --preset fast --drops 1000000
#
# FOLDER gets base-1.json … base-N.json (N is BASELINE_RUNS, 3 if unset), and of each run new.json,
# google-benchmark.json, and once there is a baseline verdict.md, verdict.json, verdict.xml. For another baseline,
# delete the old one. RAINDROPS names the program. Exit status: 0; 1 if a row is slower by more than FAIL_ABOVE
# (5% if unset), or is missing; 2 for an error, such as another device than the baseline's.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
[ $# -gt 0 ] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0" >&2; exit 2; }
folder=$1
shift
mkdir -p "$folder"
rm -f "$folder"/verdict.* # an earlier verdict must not be taken for this one
program=${RAINDROPS:-}
if [ -z "$program" ]; then
  program=$(dirname "$0")/../target/release/raindrops
  [ -x "$program" ] || program=raindrops
fi

"$program" bench --rounds 10 "$@" --json "$folder/new.json" --google-benchmark "$folder/google-benchmark.json" \
  --format markdown
runs=${BASELINE_RUNS:-3}
for number in $(seq "$runs"); do
  if [ ! -e "$folder/base-$number.json" ]; then
    mv "$folder/new.json" "$folder/base-$number.json"
    next="no verdict until there are $runs"
    [ "$number" -lt "$runs" ] || next="the baseline is complete, the next run gets a verdict"
    echo "against-baseline: kept as $folder/base-$number.json; $next" >&2
    exit 0
  fi
done
bases=$(printf '%s\n' "$folder"/base-*.json | paste -sd ,)
status=0
"$program" verdict "$bases" "$folder/new.json" --same-device --fail-above "${FAIL_ABOVE:-5%}" --format markdown \
  --json "$folder/verdict.json" --junit "$folder/verdict.xml" >"$folder/verdict.md" || status=$?
if [ -s "$folder/verdict.md" ]; then cat "$folder/verdict.md"; else rm "$folder/verdict.md"; fi
exit $status
