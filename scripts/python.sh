#!/usr/bin/env bash
# The Python package: builds its wheel, installs that in a bare virtual environment, and runs its tests and the examples that
# need no large package; types are checked by mypy --strict. Environments and wheel are in target/python. Needs Python 3.10
# or later with venv, and PyPI for maturin, NumPy and what the tests read files by.
#
#   scripts/python.sh            all of it
#   scripts/python.sh --wheel    only the wheel, whose path is the last line
#   scripts/python.sh --reachable    only whether PyPI can be reached, by its exit status
#
# RAINDROPS_COMMAND names the command that pictures are compared with, else a development build of it is made.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
work=$PWD/target/python
mkdir -p "$work"

environment() { # name: a virtual environment, made if it is not there
  [ -x "$work/$1/bin/pip" ] || python3 -m venv --clear "$work/$1"
}
pip_in() { # name, words of pip install
  local name=$1
  shift
  "$work/$name/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
}

environment build
pip_in build 'maturin>=1.9,<2'
[ "${1-}" != --reachable ] || exit 0
rm -rf "$work/wheels"
"$work/build/bin/maturin" build --release --quiet --locked --manifest-path python/Cargo.toml \
  --interpreter "$work/build/bin/python" --target-dir "$work/cargo" --out "$work/wheels"
wheel=$(echo "$work"/wheels/*.whl)
if [ "${1-}" = --wheel ]; then
  echo "$wheel"
  exit
fi

# A bare one each time: what the wheel forgets to name is missing.
rm -rf "$work/bare"
environment bare
pip_in bare "$wheel"
(cd "$work" && bare/bin/python -c 'import raindrops; print("python: raindrops", raindrops.__version__)')
for example in rainy_dataset video_and_stereo; do
  (cd "$work" && bare/bin/python "$OLDPWD/python/examples/$example.py")
done

pip_in bare 'pytest>=8' 'mypy>=1.11' 'OpenEXR>=3.3' 'pillow>=10'
if [ -z "${RAINDROPS_COMMAND-}" ]; then
  scripts/cargo.sh build --quiet --bin raindrops
  export RAINDROPS_COMMAND=${CARGO_TARGET_DIR:-$PWD/target}/debug/raindrops
fi
# From a folder without the sources, so that the wheel is what is imported.
cd "$work"
bare/bin/python -m mypy --strict --cache-dir "$work/mypy" -p raindrops
for example in rainy_dataset video_and_stereo; do
  bare/bin/python -m mypy --strict --cache-dir "$work/mypy" "$OLDPWD/python/examples/$example.py"
done
exec bare/bin/python -m pytest -q -p no:cacheprovider -c "$OLDPWD/python/pyproject.toml" --rootdir "$OLDPWD/python" \
  --import-mode=importlib "$OLDPWD/python/tests"
