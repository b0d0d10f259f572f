#!/usr/bin/env bash
# Measures the Vulkan device at hand, in at most eight minutes and without network: for a GPU that is lent
# for half an hour. It builds nothing, so that it can run on a machine without Rust:
#
#   scripts/measure-device.sh [OUTPUT FOLDER] [options of every command, e.g. --device nvidia]
#
# Needs `target/release/raindrops` (or the program that RAINDROPS names) and, for the photographs,
# `assets/environments`, both beside this script's folder. A step that fails is reported and the next one
# runs; a step that takes too long is stopped, and what it wrote by then is kept.
set -uo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
case ${1-} in -*) out=device ;; "") out=device ;; *) out=$1; shift ;; esac
program=${RAINDROPS:-target/release/raindrops}
options=("$@")
[ -x "$program" ] || { echo "measure-device: there is no $program; build it by: scripts/cargo.sh build --release" >&2; exit 2; }
mkdir -p "$out"

readonly started=$SECONDS limit=480 # seconds for everything
failed=0
step() { # name, seconds at most, then the command; its output goes to NAME.txt
  local name=$1 most=$2 left=$((limit - SECONDS + started))
  shift 2
  if [ $left -lt 5 ]; then
    echo "measure-device: $name left out: the $limit seconds are over" >&2
    failed=1
    return
  fi
  local before=$SECONDS
  if timeout "$((most < left ? most : left))" "$program" "$@" >"$out/$name.txt" 2>"$out/$name.log"; then
    echo "measure-device: $name, $((SECONDS - before)) s" >&2
  else
    echo "measure-device: $name failed after $((SECONDS - before)) s: $(tail -n 1 "$out/$name.log")" >&2
    failed=1
  fi
}

step devices 30 devices --probe --json "$out/devices.json"
step table-2 150 bench --preset paper,fast --seconds 1 --min-frames 5 "${options[@]}" \
  --json "$out/table-2.json" --svg "$out/table-2.svg"
step exact 120 bench --preset fast,exact --drops 125000,500000 --seconds 0.5 --min-frames 2 "${options[@]}" \
  --json "$out/exact.json"
photograph=assets/environments/forest.exr
[ -f $photograph ] || { photograph=assets/sky.exr; echo "measure-device: no photographs; the bundled sky instead" >&2; }
for preset in paper fast exact; do
  step "picture-$preset" 30 render --preset $preset --drops 200000 --environment $photograph \
    --size 1024x1024 "${options[@]}" -o "$out/picture-$preset.png"
done
# Few samples and one scene: which models are worth their time here, not what their error is to three digits.
step tradeoff 150 tradeoff --drops 20000 --size 256x256 --truth-samples 32 --seconds 0.2 "${options[@]}" \
  --json "$out/tradeoff.json" --svg "$out/tradeoff.svg"
echo "measure-device: $((SECONDS - started)) s, all of it in $out" >&2
exit $failed
