#!/usr/bin/env bash
# Puts each fault of tests/mutants.toml into a copy of the sources (target/mutants) and runs the test that must
# fail: which are killed, which survive, and which are stale. Takes a build and then seconds for each; not a part of CI.
#
#   scripts/mutants.sh                        all of them
#   scripts/mutants.sh --only WORD...         those in whose name, file or test one of the words is
#   scripts/mutants.sh --only layers.rs 'layers numbers_depths'
#   scripts/mutants.sh --generated [PART]     faults made by rule (tests/generated.toml), of one part or of all: how many are
#                                             noticed. RAINDROPS_SHARE=0.1 takes a tenth of them; a run goes on where the last ended
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
here=$(dirname "$0")
case ${1:-} in
  '') ;;
  --only) shift ;;
  --generated) shift; case=generated::most_generated_faults_are_noticed ;;
  *) echo "usage: scripts/mutants.sh [--only WORD... | --generated [PART]]" >&2; exit 2 ;;
esac
"$here/setup.sh" --tests
RAINDROPS_MUTANTS=$(IFS='|'; echo "$*")
export RAINDROPS_MUTANTS
exec "$here/cargo.sh" test --test house -- --ignored --exact "${case:-mutants::every_mutant_is_killed}" --nocapture
