#!/usr/bin/env bash
# Pictures of a page of `raindrops report` in a headless browser, at two widths, in light and dark, to see that the page is
# readable; scripts/figures.sh takes docs/pictures/report.png from them. Needs chromium (Debian: apt install chromium).
#
#   scripts/report-pictures.sh RESULT.json…     a page of these
#   scripts/report-pictures.sh                  of two small ones, measured now: two settings of the first CPU driver
#                                               with their pictures, and three numbers of drops in ten processes
#
# Writes out/report/page.html and wide-light, wide-dark, narrow-light and narrow-dark.png beside it. RAINDROPS names the program, else it is built. Exit status: 0; 2 for an error.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
here=$PWD
cd "$(dirname "$0")/.."
fail() { echo "report-pictures: $*" >&2; exit 2; }
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome) ||
  fail "there is no chromium; Debian: apt install chromium"
program=${RAINDROPS:-}
if [ -z "$program" ]; then
  scripts/setup.sh
  scripts/cargo.sh build --release --locked --bin raindrops || fail "the program does not build"
  program=$PWD/target/release/raindrops
fi
folder=$PWD/out/report
rm -rf "$folder"
mkdir -p "$folder"

results=()
for file in "$@"; do results+=("$(cd "$here" && realpath -e "$file")") || fail "$file: no such file"; done
if [ $# = 0 ]; then
  # Where it runs is of no interest, and stands in the command lines.
  cd "$folder"
  "$program" bench --preset paper --drops 20000,50000 --size 320x240 --mask-size 128 --seconds 0.05 --b LP_NUM_THREADS=1 \
    --max-time 100s --pictures pictures --json verdict.json >/dev/null || fail "no verdict"
  "$program" bench --preset paper,fast --drops 10000,20000,50000 --size 320x240 --mask-size 128 --seconds 0.05 \
    --rounds 10 --json bench.json >/dev/null || fail "no result"
  results=(verdict.json bench.json)
fi
"$program" report "${results[@]}" -o "$folder/page.html"

profile=$(mktemp -d)
trap 'rm -rf "$profile"' EXIT
picture() { # name, width, height, 0 for dark or 1 for light
  "$browser" --headless --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir="$profile" \
    --blink-settings=preferredColorScheme="$4" --window-size="$2,$3" --screenshot="$folder/$1.png" \
    "file://$folder/page.html" >"$folder/browser.log" 2>&1 || fail "$(tail -n 1 "$folder/browser.log")"
  [ -s "$folder/$1.png" ] || fail "$browser wrote no picture: $(tail -n 1 "$folder/browser.log")"
}
picture wide-light 1100 2400 1
picture wide-dark 1100 2400 0
picture narrow-light 500 2400 1
picture narrow-dark 500 2400 0
cd "$folder/../.."
echo "report-pictures: $folder" >&2
