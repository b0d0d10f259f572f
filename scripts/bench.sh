#!/usr/bin/env bash
# Installs what is missing, builds, and measures: the paper's Table II on this machine.
# Options go to `raindrops bench`, for example: scripts/bench.sh --preset paper,fast --json out.json
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
here=$(dirname "$0")
"$here/cargo.sh" --version >/dev/null # without cargo nothing is installed either
"$here/setup.sh"
exec "$here/cargo.sh" run --release -- bench "$@"
