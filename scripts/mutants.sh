#!/usr/bin/env bash
# Puts each fault of tests/mutants.toml into a copy of the sources (target/mutants) and runs the test that must
# fail: which are killed, which survive, and which are stale. Takes a build and then seconds for each; not a part of CI.
#
#   scripts/mutants.sh                        all of them
#   scripts/mutants.sh --only WORD...         those in whose name, file or test one of the words is
#   scripts/mutants.sh --only layers.rs 'layers numbers_depths'
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
here=$(dirname "$0")
case ${1:-} in
  '') ;;
  --only) shift ;;
  *) echo "usage: scripts/mutants.sh [--only WORD...]" >&2; exit 2 ;;
esac
"$here/setup.sh" --tests
RAINDROPS_MUTANTS=$(IFS='|'; echo "$*")
export RAINDROPS_MUTANTS
exec "$here/cargo.sh" test --test house mutants -- --ignored --exact mutants::every_mutant_is_killed --nocapture
