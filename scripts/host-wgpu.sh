#!/usr/bin/env bash
# Rain in a frame of wgpu's: builds and runs examples/host_wgpu, a package of its own whose build takes minutes. It writes
# examples/host_wgpu/host_wgpu.png and fails on any message of the validation layer.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
here=$(cd "$(dirname "$0")" && pwd)
"$here/setup.sh" --tests
cd "$here/../examples/host_wgpu"
PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
exec cargo run
