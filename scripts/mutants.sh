#!/usr/bin/env bash
# Puts each fault of tests/mutants.toml into a copy of the sources (target/mutants) and runs the test that must
# fail: which are killed, and which survive. Takes a build and then seconds for each; not a part of CI.
#
#   scripts/mutants.sh            all of them
#   scripts/mutants.sh barrier    those in whose names 'barrier' is
set -euo pipefail
here=$(dirname "$0")
"$here/setup.sh" --tests
export RAINDROPS_MUTANTS=${1:-}
exec "$here/cargo.sh" test --test mutants -- --ignored --exact every_mutant_is_killed --nocapture
