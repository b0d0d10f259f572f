#!/usr/bin/env bash
# The examples of the Python package that need large packages: albumentations, Blender, datasets, Jupyter, torch and USD, in
# virtual environments under target/python. Some GB are fetched from PyPI; .ci/run does not call this. Needs the wheel of
# scripts/python.sh, which it builds if it is not there. Blender's module needs Python 3.11.
#
#   scripts/python-large.sh                       all of them
#   scripts/python-large.sh albumentations jupyter    some: albumentations, beside, blender, datasets, jupyter, torch, usd
#
# `beside` is no test: it times this package beside albumentations and kornia, and writes target/python/beside.{md,png}. The machine
# has to be quiet. RAINDROPS_FRAME names a program raindrops whose frame is timed as well.
#
# RAINDROPS_COMMAND names the command that draws what Blender reads, else a development build of it is made.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
work=$PWD/target/python
examples=$PWD/python/examples
wheel=$(echo "$work"/wheels/*.whl)
[ -f "$wheel" ] || wheel=$(scripts/python.sh --wheel | tail -1)
[ $# -gt 0 ] || set -- albumentations blender datasets jupyter torch usd

with() { # name, packages: an environment of its own, as the packages ask for different NumPys
  local at=$work/large-$1
  shift
  [ -x "$at/bin/python" ] || python3 -m venv "$at"
  "$at/bin/python" -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps "$wheel"
  "$at/bin/python" -m pip install --quiet --disable-pip-version-check "$wheel" "$@"
  PATH=$at/bin:$PATH
}

for name in "$@"; do
  echo "python-large: $name" >&2
  case $name in
    albumentations) (with "$name" 'albumentations>=2,<3' && cd "$work" && python "$examples/albumentations_rain.py") ;;
    datasets) (with "$name" datasets pillow && cd "$work" && python "$examples/hf_map.py") ;;
    usd) (with "$name" usd-core && cd "$work" && python "$examples/usd_particles.py") ;;
    blender)
      command=${RAINDROPS_COMMAND-}
      if [ -z "$command" ]; then
        scripts/cargo.sh build --quiet --bin raindrops
        command=${CARGO_TARGET_DIR:-$PWD/target}/debug/raindrops
      fi
      "$command" render assets/scenes/steady-rain.toml --size 160x120 --preset fast --layers -o "$work/rain.exr"
      (with "$name" 'bpy>=4.2,<4.5' 'numpy<2' OpenEXR && python "$examples/../tests/large_blender.py" "$work/rain.exr")
      ;;
    beside)
      environment=$PWD/assets/environments/city.exr
      (with "$name" 'albumentations>=2,<3' kornia && cd "$work" && python "$examples/../benches/beside_others.py" "$environment" \
        ${RAINDROPS_FRAME:+--frame "$RAINDROPS_FRAME"} -o beside.png | tee beside.md)
      ;;
    torch) (with "$name" torch && cd "$work" && python "$examples/torch_dataset.py") ;;
    jupyter)
      (
        with "$name" nbconvert ipykernel
        cd "$work"
        jupyter nbconvert --to notebook --execute --output-dir "$work" --output rain "$examples/rain.ipynb"
        # A picture of each of the two that show one.
        python -c 'import json; cells = json.load(open("rain.ipynb"))["cells"]
shown = [out for cell in cells for out in cell.get("outputs", []) if "image/png" in out.get("data", {})]
assert len(shown) == 2, shown
print(len(shown), "pictures in the notebook")'
      )
      ;;
    *) echo "python-large: there is no example '$name'" >&2; exit 2 ;;
  esac
done
