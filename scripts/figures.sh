#!/usr/bin/env bash
# Makes the pictures of docs/pictures: the README's streaks, rainbows, a million drops, one drop, the paper's figures 1, 3,
# 4, 5 and 7, flattened drops, and three frames of a film; and made.txt, which says by what. Takes some three minutes on
# two cores, if nothing else runs. Figure 7 needs the environments that scripts/setup.sh fetches.
# Not made here: ray.svg, a drawing; window.png and split.png, screenshots of the window (Shift F12 and F12); report.png
# (scripts/report-pictures.sh); host-wgpu.png (scripts/host-wgpu.sh); tradeoff.svg
# (`raindrops tradeoff --svg`).
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh
scripts/cargo.sh build --release
out=docs/pictures scenes=assets/scenes work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p $out
raindrops() { target/release/raindrops "$@" 2>>"$work/log" || { tail -n 3 "$work/log" >&2; exit 1; }; }
step() { echo "figures: $*" >&2; }

step "streaks at dusk (README)"
raindrops render assets/scenes/dusk.toml -o $out/dusk.png

step "rainbows (guide): rain of 20 mm/h, the bundled sky's sun behind the camera"
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
raindrops render "$work/rainbow.toml" -o $out/rainbow.png

if [ -f assets/environments/sunset.exr ]; then
  step "real rain of 100 mm/h at sunset"
  cat >"$work/real-rain.toml" <<SCENE
[camera]
position = [0.0, 1.7, 0.0]
target = [0.3, 1.9, -1.0]
vertical_fov = 50.0
[image]
width = 900
height = 600
[environment]
file = "$PWD/assets/environments/sunset.exr"
[rain]
rate = 100.0
extent = 300.0
[model]
preset = "fast"
SCENE
  raindrops render "$work/real-rain.toml" -o $out/real-rain.png
fi

step "a million drops, one drop"
raindrops render $scenes/rain.toml -o $out/rain.png
raindrops render $scenes/drop.toml -o $out/drop.png

step "figure 1: truth, mask, scene"
raindrops reference $scenes/drop.toml --size 384x384 --samples 64 -o $out/figure-1-truth.png
raindrops render $scenes/drop.toml --size 384x384 --preset paper --samples 1 -o $out/figure-1-mask.png
raindrops render $scenes/rain.toml --size 384x384 --preset paper --drops 250000 -o $out/figure-1-rain.png

step "figure 3: low and high dynamic range"
raindrops sky -o "$work/sky.png"
raindrops render $scenes/drop.toml --size 384x384 --environment "$work/sky.png" -o $out/figure-3-low.png
raindrops render $scenes/drop.toml --size 384x384 -o $out/figure-3-high.png

step "figure 4: one drop from the distances of Table I"
while read -r name distance fov; do
  printf '[camera]\nvertical_fov = %s\n[image]\nwidth = 192\nheight = 192\n[[drop]]\ncenter = [0.0, 0.0, -%s]\n' \
    "$fov" "$distance" >"$work/$name.toml"
  raindrops render "$work/$name.toml" --preset paper -o "$out/figure-4-$name.png"
done <<'TABLE'
level-0 1.45 97
level-1 2.2361 58
level-2 4.1231 31
level-3 8.0623 15.7
level-5 32.0156 3.9
TABLE

step "figure 5: the mask"
raindrops mask -o "$work/mask" >/dev/null
cp "$work/mask/figure-5.png" $out/figure-5.png

step "figure 7: environments and numbers of drops"
for pair in sunset:1000000 courtyard:250000 forest:125000 city:500000; do
  environment=assets/environments/${pair%:*}.exr
  if [ -f "$environment" ]; then
    raindrops render --preset fast --size 384x384 --environment "$environment" --drops "${pair#*:}" \
      -o "$out/figure-7-${pair%:*}.png"
  else
    step "left out: there is no $environment"
  fi
done

step "flattened drops of 1 to 6 mm, level and from below, by the reference and by each model"
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
shape_row "0.0, -1000.0" "0.0, 0.0, -1.0" >"$work/level.toml"
shape_row "866.03, -500.0" "0.0, 0.86603, -0.5" >"$work/below.toml"
for view in level below; do
  raindrops reference "$work/$view.toml" -o $out/shapes-$view-reference.png
  raindrops render "$work/$view.toml" --preset exact -o $out/shapes-$view-exact.png
  raindrops render "$work/$view.toml" --preset fast -o $out/shapes-$view-fast.png
  raindrops render "$work/$view.toml" --preset exact --shape stretched -o $out/shapes-$view-stretched.png
  raindrops render "$work/$view.toml" --preset exact --shape sphere -o $out/shapes-$view-sphere.png
done

step "film: falling, standing still, halfway round a drop"
raindrops render $scenes/film.toml -o "$work/film.png"
for frame in 0024 0096 0150; do cp "$work/film-$frame.png" $out/; done

{
  echo "scripts/figures.sh, $(date -u +%Y-%m-%d), commit $(git rev-parse --short=12 HEAD 2>/dev/null || echo unknown)"
  target/release/raindrops devices | head -n 2
  echo "$(uname -sm), $(nproc) cores"
} >$out/made.txt
