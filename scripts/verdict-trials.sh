#!/usr/bin/env bash
# How often is a verdict wrong on this machine? Comparisons whose true ratio is known: 40 of a program with itself,
# 20 against one that is slower by 20 %, 20 by 10 %. The program is this tree's, in a copy whose benchmark takes
# FRAMES_A_SAMPLE frames as one: 10 in A, and 10, 12 or 11 in B. Takes half an hour to three; other work on the
# machine may go on, and is a part of what is measured.
#
#   scripts/verdict-trials.sh [FILE.json] [options of examples/verdict_trials.rs]
#   scripts/verdict-trials.sh out/trials.json --trials 8,4,4 --max-time 10m
#   PROFILE=dev scripts/verdict-trials.sh
#
# Without a FILE the result goes to out/verdict-trials.json. Exit status: 0; 1 if more than 1 of 40 alarms is false
# or fewer than 19 of 20 slowdowns of 20 % are found; 2 or more for an error.
set -euo pipefail
cd "$(dirname "$0")/.."
output=out/verdict-trials.json
case ${1:-} in
  -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' scripts/verdict-trials.sh; exit 0 ;;
  *.json) output=$1; shift ;;
esac
mkdir -p "$(dirname "$output")"
scripts/setup.sh
[ ! -f .setup/shaderc/libshaderc_combined.a ] || export SHADERC_LIB_DIR=${SHADERC_LIB_DIR:-$PWD/.setup/shaderc}
profile=${PROFILE:-release}
built=$profile
[ "$profile" != dev ] || built=debug

# A copy of the sources with the marked change, built apart: cargo may take what one of two trees of a package has
# built for the other's.
file=src/measure/bench/measure.rs
text='let finished = self.renderer.submit(&self.scene)?;'
put='let mut finished = None; for _ in 0..frames_a_sample() { finished = self.renderer.submit(\&self.scene)?; }'
export CARGO_TARGET_DIR=$PWD/target/verdict-trials
tree=$CARGO_TARGET_DIR/tree
rm -rf "$tree"
mkdir -p "$tree"
git ls-files -z --cached --others --exclude-standard | tar --create --null --ignore-failed-read --files-from=- |
  tar --extract --touch --directory "$tree"
[ "$(grep -cF "$text" "$tree/$file")" = 1 ] || { echo "verdict-trials: $file has changed: '$text' is not there once" >&2; exit 2; }
sed -i "s|$(sed 's/[]\/$*.^[]/\\&/g' <<<"$text")|$put|" "$tree/$file"
cat >>"$tree/$file" <<'END'

/// For trials of the verdict: frames that count as one.
fn frames_a_sample() -> usize {
    std::env::var("FRAMES_A_SAMPLE").ok().and_then(|text| text.parse().ok()).unwrap_or(1)
}
END
PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
(cd "$tree" && cargo build --profile "$profile" --locked --bin raindrops)
cp "$CARGO_TARGET_DIR/$built/raindrops" "$CARGO_TARGET_DIR/program"
cargo build --profile "$profile" --locked --example verdict_trials

# Small, so that a process takes half a second.
exec "$CARGO_TARGET_DIR/$built/examples/verdict_trials" "$CARGO_TARGET_DIR/program" "$output" "$@" -- \
  --preset paper --mask-size 64 --drops 5000 --size 128x128 --seconds 0.1
