#!/usr/bin/env bash
# Makes the pictures of docs/pictures, and notes in made.txt beside them which step made each, at which commit and on
# what machine (scripts/made.sh).
#
#   scripts/figures.sh                 every step but embedded, fountain, host and report: a few minutes on two cores
#   scripts/figures.sh gallery film       these steps
#   scripts/figures.sh window embedded fountain host report
#   scripts/figures.sh --out DIR figure-4   into DIR, and no note of it: the tracked pictures stay as they are
#
# Steps:
#   gallery                            docs/gallery.md and its pictures, which README and guide show too
#   dash-cam                           the car's picture from a camera that stands
#   shelter                            out of a porch, and the same without its roof for the rain
#   pane                               drops on a window and on a windscreen
#   figure-1 figure-3 figure-4 figure-5 figure-7
#                                      the paper's figures; 7 and gallery need the environments of scripts/setup.sh
#   shapes                             flattened drops
#   film                               three frames
#   window                             the window of the guide: tests/view/guide.rs draws it in a virtual X server
#   embedded                           real rain in a frame of examples/host_ash
#   fountain                           drops that examples/host_ash simulates itself
#   host                               rain in a frame of wgpu's (scripts/host-wgpu.sh); its build takes minutes
#   errors                             error by a drop's size, from docs/results/2026-11-errors.json
#   report                             a page of `raindrops report` in a headless Chromium, which must be there
#                                      (scripts/report-pictures.sh)
#
# Plots of measured times are made on a quiet machine: passes.svg by scripts/results.sh, tradeoff.svg and
# presets.svg by scripts/tradeoff.sh. ray.svg is drawn by hand. RAINDROPS names the program, else it is built.
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
steps=(gallery dash-cam shelter pane figure-1 figure-3 figure-4 figure-5 figure-7 shapes film errors window)
case ${1-} in -*) sed -n '2,/^set /s/^# \{0,1\}//p' scripts/figures.sh >&2; exit 2 ;; esac
[ $# = 0 ] || steps=("$@")
scenes=assets/scenes environments=assets/environments work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
raindrops() { "$RAINDROPS" "$@" 2>>"$work/log" || { tail -n 3 "$work/log" >&2; return 1; }; }

# One line a picture of the gallery: name | caption | arguments of render.
GALLERY='
wide-sunset | A wide lens, 140 degrees, among drops at sunset: perspective draws them out towards the corners. | assets/scenes/wide-sunset.toml --environment assets/environments/sunset.exr
bubbles-at-sunset | Bubbles of air under water. Their rims reflect all light and are silver. | assets/scenes/bubbles-at-sunset.toml --environment assets/environments/sunset.exr
sunrise-drops | Drops that stand still. Each is a lens with the landscape upside down. | assets/scenes/sunrise-drops.toml --environment assets/environments/sunrise.exr
studio | Drops in a studio, with a lamp in each. | assets/scenes/studio.toml --environment assets/environments/studio.exr
dusk | A shower against a low sun out of the picture, exposed for 1/1000 s; far rain is like fog. | assets/scenes/dusk.toml
real-rain | Rain of 100 mm/h at sunrise, the scene of the guide. | --rate 100 --preset fast --size 900x600 --environment assets/environments/sunrise.exr --set camera.position=0,1.7,0 --set camera.target=-0.2,1.95,-1 --set camera.vertical_fov=36
rainbow | Rain of 20 mm/h with the sun behind the camera: both rainbows. | --set rain.rate=20 --preset fast --size 900x520 --set camera.position=0,1.7,0 --set camera.target=-8.83,2.6,4.69 --set camera.vertical_fov=75 --set rain.extent=2000 --set tone_map.key=0.36
dash-cam | From a car at 50 km/h, exposed for 1/60 s: streaks spread from where it drives to. | assets/scenes/dash-cam.toml
film-0096 | One frame of a film, while the rain stands still. | assets/scenes/film.toml --frame 96
drop | One drop close up: the world upside down, bent around at the rim. | assets/scenes/drop.toml
rain | A million equal drops, the rain of the paper. | assets/scenes/rain.toml
figure-7-courtyard | A quarter of a million drops between buildings. | --preset fast --size 384x384 --environment assets/environments/courtyard.exr --drops 250000
'

gallery() { # docs/gallery.md and its pictures
  local name caption rest arguments took page=docs/gallery.md folder=pictures/
  [ $notes = yes ] || page=$out/gallery.md folder=
  for name in sunset sunrise studio courtyard; do need $environments/$name.exr; done
  {
    printf '# Gallery\n\nTwelve pictures, each with its command and the drops in view, hidden ones and those under a pixel included. '
    printf 'Photographs come from `scripts/setup.sh` on Debian and Ubuntu.\n\n'
    printf 'The time is what the command took of the processor, shaders compiled before: %s, %d cores, no GPU.\n' \
      "$("$RAINDROPS" devices | sed -n '1s/^0: //p')" "$(nproc)"
  } >"$work/gallery.md"
  while IFS='|' read -r name caption arguments; do
    [ -n "$name" ] || continue
    read -r name <<<"$name" && read -r caption <<<"$caption" && read -r arguments <<<"$arguments"
    # shellcheck disable=SC2086 # arguments are words
    : >"$work/log"
    { TIMEFORMAT='%U %S'; time raindrops render $arguments -o "$out/$name.png"; } 2>"$work/took" || { cat "$work/took" >&2; return 1; }
    took=$(awk '{ printf "%.1f s", $1 + $2 }' "$work/took")
    [ ${#arguments} -lt 60 ] || arguments=${arguments// --/ \\$'\n'  --}
    rest=${caption#"${caption%%[.:,]*}"} # the heading has the first part
    rest=${rest#[.:,]} && rest=${rest# } && [ -z "$rest" ] || rest="${rest^}"$'\n\n'
    printf '\n## %s\n\n![%s](%s%s.png)\n\n%s```\nraindrops render %s -o %s.png\n```\n\n`%s`, %s\n' "${caption%%[.:,]*}" \
      "${caption%%[.:,]*}" "$folder" "$name" "$rest" "$arguments" "$name" "$(sed -n 's/ in view (.*/ in view/p' "$work/log" | tail -n 1)" "$took" >>"$work/gallery.md"
    made "$name.png"
  done <<<"$GALLERY"
  cp "$work/gallery.md" "$page"
}

dash_cam() { # what a car sees in the gallery, by a camera that stands
  raindrops render $scenes/dash-cam.toml --set 'camera.velocity=[0,0,0]' -o "$out"/dash-cam-at-rest.png
  made dash-cam-at-rest.png
}

shelter() { # rain outside a porch, and as if there were no roof
  raindrops render $scenes/porch.toml -o "$out"/porch.png
  # Far away a roof keeps nothing off.
  raindrops render $scenes/porch.toml --set shelter.from=900,900 --set shelter.to=916,916 -o "$out"/porch-open.png
  made porch.png porch-open.png
}

pane() { # drops on glass, by the reference and by a preset
  raindrops reference $scenes/window.toml --size 800x450 --samples 64 -o "$out"/pane.png
  raindrops reference $scenes/windscreen.toml --size 800x450 --samples 64 --rain-to 2 -o "$out"/windscreen.png
  raindrops render $scenes/windscreen.toml --preset fast --size 800x450 -o "$out"/windscreen-fast.png
  made pane.png windscreen.png windscreen-fast.png
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
  for pair in sunset:1000000 forest:125000 city:500000; do # the gallery has courtyard
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

film() { # falling, halfway round a drop; the gallery has frame 96, which stands still
  local frame
  for frame in 24 150; do
    raindrops render $scenes/film.toml --frame $frame -o "$out/film-$(printf %04d $frame).png"
    made "film-$(printf %04d $frame).png"
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

by_ash() { # by_ash ARGUMENT NAME: a picture of the program by ash
  scripts/cargo.sh run --locked --release -p host_ash "$1" >>"$work/log" 2>&1 || { tail -n 20 "$work/log" >&2; return 1; }
  mv host_ash.png "$out/$2".png
  made "$2".png
}

embedded() { # real rain among the boxes of a program by ash
  by_ash 25 embedded
}

fountain() { # a fountain of its own
  by_ash fountain fountain
}

report() { # a page of two small results in a headless Chromium
  scripts/report-pictures.sh
  cp out/report/wide-light.png "$out"/report.png
  made report.png
}

need() { [ -f "$1" ] || { echo "figures: there is no $1; scripts/setup.sh fetches it on Debian and Ubuntu" >&2; return 1; }; }

for step in "${steps[@]}"; do
  declare -F "${step//-/_}" >/dev/null || { echo "figures: there is no step $step" >&2; exit 2; }
done
if [ -z "${RAINDROPS-}" ]; then
  scripts/setup.sh
  scripts/cargo.sh build --release --locked
  RAINDROPS=target/release/raindrops
fi
RAINDROPS=$(realpath "$RAINDROPS")
export RAINDROPS
for step in "${steps[@]}"; do
  echo "figures: $step" >&2
  made() { [ $notes = no ] || scripts/made.sh "scripts/figures.sh $step" "$@"; }
  "${step//-/_}"
done
echo "figures: in $out" >&2
