#!/usr/bin/env bash
# Makes the pictures of docs/pictures, and notes in made.txt beside them which step made each, at which commit and on
# what machine (scripts/made.sh).
#
#   scripts/figures.sh                 every step but embedded, host and report: a few minutes on two cores
#   scripts/figures.sh dusk film       these steps
#   scripts/figures.sh window embedded host report
#   scripts/figures.sh --out DIR figure-4   into DIR, and no note of it: the tracked pictures stay as they are
#
# Steps:
#   dusk dash-cam rainbow real-rain rain
#                                      pictures of README and guide
#   figure-1 figure-3 figure-4 figure-5 figure-7
#                                      the paper's figures; 7 and real-rain need the environments of scripts/setup.sh
#   shapes                             flattened drops
#   film                               three frames
#   window                             the window of the guide: tests/view/guide.rs draws it in a virtual X server
#   embedded                           real rain in a frame of examples/host_ash
#   host                               rain in a frame of wgpu's (scripts/host-wgpu.sh); its build takes minutes
#   errors                             error by a drop's size, from docs/results/2026-11-errors.json
#   report                             a page of `raindrops report` in a headless Chromium, which must be there
#                                      (scripts/report-pictures.sh)
#
# Plots of measured times are made on a quiet machine: passes.svg by scripts/results.sh, tradeoff.svg by
# scripts/tradeoff.sh. ray.svg is drawn by hand. RAINDROPS names the program, else it is built.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
out=docs/pictures notes=yes
if [ "${1-}" = --out ]; then
  [ -n "${2-}" ] || { echo "figures: --out needs a folder" >&2; exit 2; }
  mkdir -p "$2"
  out=$(realpath "$2") notes=no
  shift 2
fi
cd "$(dirname "$0")/.."
steps=(dusk dash-cam rainbow real-rain rain figure-1 figure-3 figure-4 figure-5 figure-7 shapes film errors window)
case ${1-} in -*) sed -n '2,/^set /s/^# \{0,1\}//p' scripts/figures.sh >&2; exit 2 ;; esac
[ $# = 0 ] || steps=("$@")
if [ -z "${RAINDROPS-}" ]; then
  scripts/setup.sh
  scripts/cargo.sh build --release --locked
  RAINDROPS=target/release/raindrops
fi
RAINDROPS=$(realpath "$RAINDROPS")
export RAINDROPS
scenes=assets/scenes environments=assets/environments work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
raindrops() { "$RAINDROPS" "$@" 2>>"$work/log" || { tail -n 3 "$work/log" >&2; return 1; }; }

dusk() { # streaks at dusk
  raindrops render $scenes/dusk.toml -o "$out"/dusk.png
  made dusk.png
}

dash_cam() { # from a car, and the same from a camera that stands
  raindrops render $scenes/dash-cam.toml -o "$out"/dash-cam.png
  raindrops render $scenes/dash-cam.toml --set 'camera.velocity=[0,0,0]' -o "$out"/dash-cam-at-rest.png
  made dash-cam.png dash-cam-at-rest.png
}

rainbow() { # rain of 20 mm/h, the bundled sky's sun behind the camera
  cat >"$work/rainbow.toml" <<'SCENE'
[camera]
position = [0.0, 1.7, 0.0]
target = [-8.83, 2.6, 4.69]
vertical_fov = 75.0
[image]
width = 900
height = 520
[rain]
rate = 20.0
extent = 2000.0
[tone_map]
key = 0.36
[model]
preset = "fast"
SCENE
  raindrops render "$work/rainbow.toml" -o "$out"/rainbow.png
  made rainbow.png
}

real_rain() { # 100 mm/h at sunrise, the scene of the guide
  need $environments/sunrise.exr
  cat >"$work/cloudburst.toml" <<SCENE
[camera]
position = [0.0, 1.7, 0.0]
target = [-0.2, 1.95, -1.0]
vertical_fov = 36.0
[image]
width = 900
height = 600
[environment]
file = "$PWD/$environments/sunrise.exr"
[rain]
rate = 100.0
extent = 300.0
[model]
preset = "fast"
SCENE
  raindrops render "$work/cloudburst.toml" -o "$out"/real-rain.png
  made real-rain.png
}

rain() { # a million drops, one drop
  raindrops render $scenes/rain.toml -o "$out"/rain.png
  raindrops render $scenes/drop.toml -o "$out"/drop.png
  made rain.png drop.png
}

figure_1() { # truth, mask, scene
  raindrops reference $scenes/drop.toml --size 384x384 --samples 64 -o "$out"/figure-1-truth.png
  raindrops render $scenes/drop.toml --size 384x384 --preset paper --samples 1 -o "$out"/figure-1-mask.png
  raindrops render $scenes/rain.toml --size 384x384 --preset paper --drops 250000 -o "$out"/figure-1-rain.png
  made figure-1-truth.png figure-1-mask.png figure-1-rain.png
}

figure_3() { # low and high dynamic range
  raindrops sky -o "$work/sky.png"
  raindrops render $scenes/drop.toml --size 384x384 --environment "$work/sky.png" -o "$out"/figure-3-low.png
  raindrops render $scenes/drop.toml --size 384x384 -o "$out"/figure-3-high.png
  made figure-3-low.png figure-3-high.png
}

figure_4() { # one drop from the distances of Table I
  local name distance fov
  while read -r name distance fov; do
    printf '[camera]\nvertical_fov = %s\n[image]\nwidth = 192\nheight = 192\n[[drop]]\ncenter = [0.0, 0.0, -%s]\n' \
      "$fov" "$distance" >"$work/$name.toml"
    raindrops render "$work/$name.toml" --preset paper -o "$out/figure-4-$name.png"
    made "figure-4-$name.png"
  done <<'TABLE'
level-0 1.45 97
level-1 2.2361 58
level-2 4.1231 31
level-3 8.0623 15.7
level-5 32.0156 3.9
TABLE
}

figure_5() { # the mask
  raindrops mask -o "$work/mask" >/dev/null
  cp "$work/mask/figure-5.png" "$out"/figure-5.png
  made figure-5.png
}

figure_7() { # environments and numbers of drops
  local pair environment
  for pair in sunset:1000000 courtyard:250000 forest:125000 city:500000; do
    environment=$environments/${pair%:*}.exr
    need "$environment"
    raindrops render --preset fast --size 384x384 --environment "$environment" --drops "${pair#*:}" \
      -o "$out/figure-7-${pair%:*}.png"
    made "figure-7-${pair%:*}.png"
  done
}

# shape_row NAME TARGET SIZE: six drops of 1 to 6 mm beside one another across the view
shape_row() {
  printf 'metres = 0.001\n[camera]\nposition = [0.0, 0.0, 0.0]\ntarget = [%s]\nvertical_fov = 0.515\n[image]\nwidth = 380\nheight = 90\n' "$2"
  local x=-14.6 mm
  for mm in 1 2 3 4 5 6; do
    x=$(awk "BEGIN { print $x + 0.5 * $mm }")
    printf '[[drop]]\nshape = "equilibrium"\nradius = %s\ncenter = [%s, %s]\n' "$(awk "BEGIN { print 0.5 * $mm }")" "$x" "$1"
    x=$(awk "BEGIN { print $x + 0.5 * $mm + 1.6 }")
  done
}

shapes() { # flattened drops of 1 to 6 mm, level and from below, by the reference and by each model
  local view
  shape_row "0.0, -1000.0" "0.0, 0.0, -1.0" >"$work/level.toml"
  shape_row "866.03, -500.0" "0.0, 0.86603, -0.5" >"$work/below.toml"
  for view in level below; do
    raindrops reference "$work/$view.toml" -o "$out"/shapes-$view-reference.png
    raindrops render "$work/$view.toml" --preset exact -o "$out"/shapes-$view-exact.png
    raindrops render "$work/$view.toml" --preset fast -o "$out"/shapes-$view-fast.png
    raindrops render "$work/$view.toml" --preset exact --shape stretched -o "$out"/shapes-$view-stretched.png
    raindrops render "$work/$view.toml" --preset exact --shape sphere -o "$out"/shapes-$view-sphere.png
    made shapes-$view-{reference,exact,fast,stretched,sphere}.png
  done
}

film() { # falling, standing still, halfway round a drop
  local frame
  raindrops render $scenes/film.toml -o "$work/film.png"
  for frame in 0024 0096 0150; do
    cp "$work/film-$frame.png" "$out"/
    made "film-$frame.png"
  done
}

errors() { # the figures by which `auto` chooses; measured by raindrops errors assets/environments/*.exr --json FILE
  raindrops errors --from docs/results/2026-11-errors.json --svg "$out"/errors.svg >/dev/null
  made errors.svg
}

window() { # the window with its panel, and two models with their difference
  [ -n "$(command -v Xvfb)" ] || scripts/setup.sh --tests
  RAINDROPS_PICTURES=$(realpath "$out") scripts/cargo.sh test --locked --test view -- --ignored the_guides_pictures \
    >>"$work/log" 2>&1 || { tail -n 20 "$work/log" >&2; return 1; }
  made window.png split.png
  [ $notes = yes ] || return 0
  # Which passes the panel shows: tests/house/docs/figures.rs compares them with the program's.
  passes=$(raindrops plan $scenes/rain.toml | sed -n '/^passes/,$s/^  \([a-z]\+\( [a-z]\+\)*\)  .*/\1/p' | paste -sd,)
  { grep -v '^passes ' "$out"/made.txt; echo "passes of window.png: ${passes//,/, }"; } >"$work/made.txt"
  LC_ALL=C sort "$work/made.txt" >"$out"/made.txt
}

host() { # rain before, behind and beside the boxes of a wgpu program
  scripts/host-wgpu.sh >>"$work/log" 2>&1 || { tail -n 20 "$work/log" >&2; return 1; }
  cp examples/host_wgpu/host_wgpu.png "$out"/host-wgpu.png
  made host-wgpu.png
}

embedded() { # real rain among the boxes of a program by ash
  scripts/cargo.sh run --locked --release -p host_ash 25 >>"$work/log" 2>&1 || { tail -n 20 "$work/log" >&2; return 1; }
  mv host_ash.png "$out"/embedded.png
  made embedded.png
}

report() { # a page of two small results in a headless Chromium
  scripts/report-pictures.sh
  cp out/report/wide-light.png "$out"/report.png
  made report.png
}

need() { [ -f "$1" ] || { echo "figures: there is no $1; scripts/setup.sh fetches it on Debian and Ubuntu" >&2; return 1; }; }

for step in "${steps[@]}"; do
  echo "figures: $step" >&2
  made() { [ $notes = no ] || scripts/made.sh "scripts/figures.sh $step" "$@"; }
  declare -F "${step//-/_}" >/dev/null || { echo "figures: there is no step $step" >&2; exit 2; }
  "${step//-/_}"
done
echo "figures: in $out" >&2
