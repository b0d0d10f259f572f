#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test. Options go to `cargo test`.
set -euo pipefail
here=$(dirname "$0")
"$here/setup.sh" --tests
exec "$here/cargo.sh" test "$@"
