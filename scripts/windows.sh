#!/usr/bin/env bash
# Builds the program for Windows on Debian, tries it under Wine, and packs it. Wine runs Windows' programs on Linux; it is
# not Windows: docs/windows.md says what that leaves open.
#
#   scripts/windows.sh               all three; the zip file lies in out
#   scripts/windows.sh --build       only builds target/x86_64-pc-windows-gnu/release/raindrops.exe
#   scripts/windows.sh --try         only tries what was built, raindrops.exe and target/release/raindrops
#
# Installs what is missing (scripts/setup.sh --windows, 1.7 GB), as root; takes half an hour on two cores. PROFILE=dev builds faster, and programs that are slow.
# Exit status: 0 if every check passes; 1 if one fails; 2 for an error.
set -euo pipefail
usage() { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; }
steps="build try pack"
case ${1-} in
  "") ;;
  --build | --try) steps=${1#--} ;;
  -h | --help) usage; exit 0 ;;
  *) usage >&2; exit 2 ;;
esac
cd "$(dirname "$0")/.."
fail() { echo "windows: $*" >&2; exit 2; }
does() { case " $steps " in *" $1 "*) true ;; *) false ;; esac; }

target=x86_64-pc-windows-gnu
profile=${PROFILE:-release}
folder=${profile/#dev/debug}
built=${CARGO_TARGET_DIR:-target}
scripts/setup.sh --windows || fail "something is missing"

if does build; then
  PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
  # A library that is there is taken. Else it is built from the sources that scripts/setup.sh fetched, which stable compilers
  # do under this variable alone.
  library=$PWD/.setup/rust-src/$(rustc -V | cut -d ' ' -f 2)/library std=()
  if [ ! -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; then
    export RUSTC_BOOTSTRAP=1 __CARGO_TESTS_ONLY_SRC_ROOT=$library
    std=(-Z build-std=std,panic_unwind)
  fi
  scripts/cargo.sh build --locked --profile "$profile" --bin raindrops --target $target "${std[@]}" || fail "it does not build for Windows"
  unset RUSTC_BOOTSTRAP __CARGO_TESTS_ONLY_SRC_ROOT
  echo "windows: $built/$target/$folder/raindrops.exe, $(du -h "$built/$target/$folder/raindrops.exe" | cut -f 1)" >&2
fi
if does try || does pack; then
  scripts/cargo.sh build --locked --profile "$profile" --bin raindrops || fail "it does not build for Linux"
fi

if does try; then
  root=.setup/wine
  as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }
  as_root rm -rf "$root/try"
  as_root mkdir "$root/try"
  as_root cp -r "$built/$target/$folder/raindrops.exe" "$built/$folder/raindrops" scripts/wine.sh assets "$root/try/"
  # Names of processes of its own: whatever is left of them ends with the last check.
  as_root unshare --mount --pid --fork --kill-child \
    sh -c "mount -t proc proc $root/proc && exec chroot $root /usr/bin/env -i PATH=/usr/bin:/bin bash /try/wine.sh" || exit 1
  as_root rm -rf "$root/try"
fi

if does pack; then
  RAINDROPS_WINDOWS=$built/$target/$folder/raindrops.exe RAINDROPS=$built/$folder/raindrops scripts/release.sh
fi
