#!/usr/bin/env bash
# Format, lints and documentation of the whole tree; a warning is an error.
set -euo pipefail
here=$(dirname "$0")
"$here/setup.sh"
"$here/cargo.sh" fmt --check
"$here/cargo.sh" clippy --all-targets -- -D warnings
RUSTDOCFLAGS="-D warnings" "$here/cargo.sh" doc --no-deps
