#!/usr/bin/env bash
# Cargo, in the project's folder, where it finds .cargo/config.toml; found itself even where a shell
# does not know of it yet, as right after the installation of Rust.
set -euo pipefail
cd "$(dirname "$0")/.."
PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
command -v cargo >/dev/null || { echo "cargo is missing: install Rust 1.88 or later (https://rustup.rs)" >&2; exit 1; }
case ${1-} in build | run | test | install)
  command -v cc >/dev/null || { echo "there is no C compiler; scripts/setup.sh installs it and all else that is missing" >&2; exit 1; } ;;
esac
exec cargo "$@"
