#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test. Options go to `cargo test`.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
here=$(dirname "$0")
"$here/cargo.sh" --version >/dev/null # without cargo nothing is installed either
"$here/setup.sh" --tests
exec "$here/cargo.sh" test "$@"
