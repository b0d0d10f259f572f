#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test program, also where one fails. Options go to `cargo test`. The last line
# says how many tests of all programs passed and failed; a program that ends without a result counts as one that failed.
#
#   scripts/test.sh
#   scripts/test.sh --test physics optics::
#
# Exit status: 0 if all passed; else that of `cargo test`.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
here=$(dirname "$0")
"$here/cargo.sh" --version >/dev/null # without cargo nothing is installed either
"$here/setup.sh" --tests
# Its colours stay, although it writes into a pipe.
[ ! -t 1 ] || export CARGO_TERM_COLOR=${CARGO_TERM_COLOR:-always}
all=--no-fail-fast
for option in "$@"; do
  case $option in --) break ;; --no-fail-fast) all= ;; esac
done
log=$(mktemp)
trap 'rm -f "$log"' EXIT
status=0
# Both streams in one, so that each result follows the name of its program.
"$here/cargo.sh" test ${all:+"$all"} "$@" 2>&1 | tee "$log" || status=$?
# A program's own result is its last: a test that fails prints what it said, which may hold other results. Of the documentation's
# tests each group has one.
awk -v status="$status" '
  function ended() {
    # Asked for a list, or to run nothing, programs have none and the status is 0.
    if (status != 0 && program != "" && result == "") { lost++; print "no result: " program (signal ? " " signal : "") }
    count(result); program = ""; result = ""; signal = ""
  }
  function count(line,   words, i) {
    split(line, words, /[ ;]+/)
    for (i = 2; i in words; i++) if (words[i] ~ /^(passed|failed|ignored)$/) sum[words[i]] += words[i - 1]
  }
  { gsub(/\033\[[0-9;]*m/, "") }
  /^ +Running .*\(.*\)$/ { ended(); if ($2 !~ /^benches/) program = $2 == "unittests" ? $3 : $2 }
  /^ +Doc-tests / { ended(); program = $1 " " $2 }
  match($0, /\(signal: .*\)$/) { signal = substr($0, RSTART) }
  /^test result: / { if (program == "" || program ~ /^Doc-tests/) count(result); result = $0 }
  END {
    ended()
    failed = sum["failed"] + lost
    if (status != 0 && failed == 0) failed = 1 # what does not build runs nothing
    printf "%d passed, %d failed, %d ignored\n", sum["passed"], failed, sum["ignored"]
  }' "$log"
exit "$status"
