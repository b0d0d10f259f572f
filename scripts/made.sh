#!/usr/bin/env bash
# Notes in docs/pictures/made.txt what made pictures: the script and its step, the commit, the day, the machine.
#
#   scripts/made.sh "scripts/figures.sh gallery" dusk.png
#
# A commit with a + had changes in the sources. RAINDROPS names the program, as in the scripts that call this one; RESULT a file in
# JSON that the pictures are plots of: then the commit is that which was measured.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
[ $# -ge 2 ] || { sed -n '2,/^set /s/^# \{0,1\}//p' scripts/made.sh >&2; exit 2; }
by=$1 table=docs/pictures/made.txt
shift
commit=$(git rev-parse --short=12 HEAD 2>/dev/null || echo unknown)
git diff --quiet HEAD -- src glsl assets build build.rs 2>/dev/null || commit+=+
[ -z "${RESULT-}" ] || commit=$(grep -m 1 -o '"commit": *"[^"]*"' "$RESULT" | cut -d '"' -f 4)
device=$("${RAINDROPS:-target/release/raindrops}" devices | sed -n '1s/^0: //p; 2s/^ *driver */, /p' | tr -d '\n')
touch $table
for picture in "$@"; do
  grep -v "^$picture " $table >$table.part || true
  printf '%-28s %-32s %-14s %s  %s, %d cores\n' "$picture" "$by" "$commit" "$(date -u +%Y-%m-%d)" "$device" "$(nproc)" >>$table.part
  LC_ALL=C sort $table.part >$table
  rm $table.part
done
