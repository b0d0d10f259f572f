#!/usr/bin/env bash
# Format, lints and documentation of the whole tree; a warning is an error.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
here=$(dirname "$0")
"$here/cargo.sh" --version >/dev/null # without cargo nothing is installed either
"$here/setup.sh"
"$here/cargo.sh" fmt --all --check
"$here/cargo.sh" clippy --workspace --all-targets -- -D warnings
RUSTDOCFLAGS="-D warnings" "$here/cargo.sh" doc --no-deps

# The library as it is embedded: without the command, the window and what only they need.
"$here/cargo.sh" clippy --no-default-features --lib -- -D warnings
RUSTDOCFLAGS="-D warnings" "$here/cargo.sh" doc --no-default-features --lib --no-deps
tree=$("$here/cargo.sh" tree -e normal --no-default-features --prefix none --format '{p}')
grep -q '^raindrops ' <<<"$tree"
if grep -E '^(winit|egui|egui-winit|ash-window|clap|clap_complete|plotters|indicatif|comfy-table|ctrlc|anyhow) ' <<<"$tree"; then
    echo "check: the above is not to be needed without the features cli and view" >&2
    exit 1
fi
