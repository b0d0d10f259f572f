#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test. Options go to `cargo test`.
set -euo pipefail
here=$(dirname "$0")
"$here/cargo.sh" --version >/dev/null # without cargo nothing is installed either
"$here/setup.sh" --tests
exec "$here/cargo.sh" test "$@"
