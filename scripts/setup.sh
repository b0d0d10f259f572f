#!/usr/bin/env bash
# Installs what a fresh machine lacks to build, run and test raindrops: a Vulkan loader, the software
# driver lavapipe beside whatever other drivers there are (on macOS MoltenVK), the Khronos validation
# layer for the tests, and the shader compiler's library. Quiet when nothing is missing.
#
#   scripts/setup.sh                 what scripts/bench.sh and check.sh need
#   scripts/setup.sh --tests         also what scripts/test.sh needs for the window: a virtual X server
#   scripts/setup.sh --drivers       also SwiftShader and a newer lavapipe, for comparing drivers; the
#                                    last line says how to select all of them (Debian, Ubuntu)
#   scripts/setup.sh --windows       also what scripts/windows.sh needs: MinGW, Rust's standard library for
#                                    Windows, and a Debian 13 with Wine in .setup/wine, 1.7 GB (Debian; root)
#   scripts/setup.sh --help          this text
set -euo pipefail
cd "$(dirname "$0")/.."
setup=.setup
environments=assets/environments

say() { echo "setup: $*" >&2; }

with_tests=no with_drivers=no with_windows=no
for argument in "$@"; do
  case $argument in
    --tests) with_tests=yes ;;
    --drivers) with_drivers=yes ;;
    --windows) with_windows=yes ;;
    -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' scripts/setup.sh; exit 0 ;;
    *) say "unknown argument '$argument'; usage: scripts/setup.sh [--tests] [--drivers] [--windows]"; exit 2 ;;
  esac
done

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else say "cannot install without root; run as root: $*"; return 1
  fi
}

quietly() { # command: its output only if it fails
  local log status=0
  log=$(mktemp)
  "$@" >"$log" 2>&1 </dev/null || status=$?
  [ $status = 0 ] || { cat "$log" >&2; say "failed: $*"; }
  rm -f "$log"
  return $status
}

installed() { # package: is it installed, as far as this package manager knows?
  case $manager in
    apt) dpkg-query -W -f '${Status}' "$1" 2>/dev/null | grep -q 'install ok installed' ;;
    dnf) rpm -q "$1" >/dev/null 2>&1 ;;
    pacman) pacman -Q "$1" >/dev/null 2>&1 ;;
    brew) brew list "$1" >/dev/null 2>&1 ;;
  esac
}

apt_is_fresh() { [ -n "$(find /var/lib/apt/lists -maxdepth 1 -name '*_Packages*' -mtime -2 -print -quit 2>/dev/null)" ]; }
apt_update() { apt_is_fresh || { say "updating the package lists"; quietly as_root apt-get update -qq; }; }

install() { # packages: install by name whichever are missing
  local missing=()
  for package in "$@"; do installed "$package" || missing+=("$package"); done
  [ ${#missing[@]} -gt 0 ] || return 0
  say "installing ${missing[*]}"
  case $manager in
    apt) apt_update
         quietly as_root env DEBIAN_FRONTEND=noninteractive \
           apt-get install -y -qq --no-install-recommends "${missing[@]}" ;;
    dnf) quietly as_root dnf install -y -q "${missing[@]}" ;;
    pacman) quietly as_root pacman -S --needed --noconfirm "${missing[@]}" ;;
    brew) quietly brew install "${missing[@]}" ;;
  esac
}

manager=none
for candidate in apt-get dnf pacman brew; do
  command -v $candidate >/dev/null && { manager=${candidate%-get}; break; }
done

case $manager in
  apt) install build-essential cmake git python3 pkg-config \
         libvulkan1 mesa-vulkan-drivers vulkan-validationlayers \
         libshaderc-dev glslang-dev spirv-tools ;;
  dnf) install gcc-c++ cmake git python3 vulkan-loader mesa-vulkan-drivers vulkan-validation-layers libshaderc-devel ;;
  pacman) install base-devel cmake git python vulkan-icd-loader vulkan-swrast vulkan-validation-layers shaderc ;;
  brew) install cmake python vulkan-loader molten-vk vulkan-validationlayers shaderc ;;
  none) say "no package manager that this script knows (apt, dnf, pacman, brew);" \
            "needed: a C++ compiler, cmake, git, python3, the Vulkan loader, a driver, the validation layer" ;;
esac

# A virtual X server, and the libraries that a program in an X window loads as it starts: a desktop
# has them, a server may not.
if [ $with_tests = yes ]; then
  case $manager in
    apt) install python3-venv xvfb xkb-data libx11-6 libx11-xcb1 libxcursor1 libxi6 libxkbcommon0 libxkbcommon-x11-0 ;;
    dnf) install xorg-x11-server-Xvfb libX11 libX11-xcb libXcursor libXi libxkbcommon libxkbcommon-x11 ;;
    pacman) install xorg-server-xvfb libx11 libxcursor libxi libxkbcommon libxkbcommon-x11 ;;
    brew) ;; # there is no X on macOS
    none) say "needed by the tests of the window: Xvfb" ;;
  esac
fi

# The shader compiler. .cargo/config.toml points the shaderc crate at .setup/shaderc, and then it looks
# nowhere else: where no library lies there it builds itself from source.
shaderc_from_source() {
  say "$1: the shaderc crate builds itself from source (needs cmake, git, python3; over 8 minutes on 2 cores)"
}

# Debian's shaderc comes in pieces that the crate cannot link: the combined archive lacks glslang, the
# shared library lacks symbols. Merged into one archive it links in a second.
merge_shaderc() {
  local into=$setup/shaderc/libshaderc_combined.a libraries script
  [ -f "$into" ] && return 0
  libraries=$(dirname "$(dpkg -L libshaderc-dev 2>/dev/null | grep '/libshaderc_combined.a$' || echo /nowhere/x)")
  if [ ! -f "$libraries/libglslang.a" ] || [ ! -f "$libraries/libSPIRV-Tools.a" ]; then
    shaderc_from_source "no static archives of shaderc, glslang and SPIRV-Tools here"
    return 0
  fi
  mkdir -p "$(dirname "$into")"
  script="CREATE $into.part"$'\n'
  for name in shaderc_combined glslang MachineIndependent GenericCodeGen OSDependent OGLCompiler HLSL \
              SPIRV SPIRV-Tools-opt SPIRV-Tools; do
    [ -f "$libraries/lib$name.a" ] && script+="ADDLIB $libraries/lib$name.a"$'\n'
  done
  ar -M <<<"${script}SAVE"$'\n'END
  mv "$into.part" "$into"
  say "merged the shader compiler's archives into $into"
}

# Elsewhere the package's shared library is linked as it is, by one of the names that the crate knows.
link_shaderc() {
  local into=$setup/shaderc library name
  for name in libshaderc_shared.so libshaderc_shared.dylib; do
    [ -e "$into/$name" ] && return 0
  done
  case $manager in
    dnf) library=$(rpm -ql libshaderc-devel | grep -m 1 '/libshaderc_shared\.so$' || true) ;;
    pacman) library=$(pacman -Qlq shaderc | grep -m 1 '/libshaderc_shared\.so$' || true) ;;
    brew) library=$(brew --prefix shaderc)/lib/libshaderc_shared.dylib ;;
    none) library=$(ldconfig -p 2>/dev/null | sed -n 's|.* => \(/.*/libshaderc_shared\.so\)$|\1|p' | head -n 1 || true) ;;
  esac
  if [ ! -e "$library" ]; then
    shaderc_from_source "no shared library of shaderc here"
    return 0
  fi
  mkdir -p "$into"
  ln -sf "$library" "$into/"
  say "linked $library into $into"
}
if [ $manager = apt ]; then merge_shaderc; else link_shaderc; fi

# Real HDR environments (CC0), from Debian's blender-data: 31 MB fetched, 8 files of 1 MB kept.
# Without them everything works on the bundled sky.
fetch_environments() {
  [ -f $environments/sunset.exr ] && return 0
  local folder
  folder=$(mktemp -d)
  apt_update || true
  if (cd "$folder" && apt-get download -qq blender-data 2>/dev/null && dpkg-deb -x blender-data_*.deb .); then
    mkdir -p $environments
    mv "$folder"/usr/share/blender/datafiles/studiolights/world/* $environments/ &&
      say "fetched $(ls $environments/*.exr | wc -l) HDR environments into $environments"
  else
    say "could not fetch the HDR environments (Debian's blender-data); the bundled sky will do"
  fi
  rm -rf "$folder"
}
if [ $manager = apt ]; then fetch_environments
elif [ ! -d $environments ]; then say "HDR environments are fetched on Debian and Ubuntu only; the bundled sky will do"
fi

# More Vulkan drivers without a GPU, none of them installed system-wide.
fetch_package() { # package, folder: unpack Debian's package there; with further options to apt-get
  local package=$1 into=$2
  shift 2
  (cd "$into" && apt-get "$@" download -qq "$package" 2>/dev/null && dpkg-deb -x "${package%%/*}"_*.deb .)
}

# Other releases of Debian, beside the system's: sets the options of apt-get by which it sees them alone.
releases() { # folder for their lists, releases
  local folder=$1 release
  shift
  chmod 755 "$folder" # apt fetches as a user of its own
  mkdir -p "$folder"/{lists,cache/archives}/partial
  for release in "$@"; do echo "deb http://deb.debian.org/debian $release main"; done >"$folder/sources"
  only=(-o Dir::Etc::sourcelist="$folder/sources" -o Dir::Etc::sourceparts=/dev/null
        -o Dir::State::lists="$folder/lists" -o Dir::Cache="$folder/cache")
}

# SwiftShader, out of Debian's Chromium.
fetch_swiftshader() {
  local into=$setup/swiftshader folder
  [ -f $into/vk_swiftshader_icd.json ] && return 0
  folder=$(mktemp -d)
  if fetch_package chromium-common "$folder"; then
    mkdir -p $into
    cp "$folder"/usr/lib/chromium/{libvk_swiftshader.so,vk_swiftshader_icd.json} $into/
    say "fetched SwiftShader"
  else
    say "could not fetch SwiftShader (Debian's chromium-common)"
  fi
  rm -rf "$folder"
}

# The lavapipe of Debian 12's backports, beside the system's older one. It needs the same LLVM 15,
# which other releases do not have; those come with a newer Mesa themselves.
fetch_newer_lavapipe() {
  local into=$setup/lavapipe-backports folder only
  [ -f $into/lvp_icd.json ] && return 0
  if ! grep -qs '^VERSION_CODENAME=bookworm' /etc/os-release; then
    say "a newer lavapipe is fetched on Debian 12 only"
    return 0
  fi
  folder=$(mktemp -d)
  releases "$folder" bookworm-backports
  if quietly as_root apt-get "${only[@]}" update -qq &&
     fetch_package mesa-vulkan-drivers/bookworm-backports "$folder" "${only[@]}"; then
    mkdir -p $into
    cp "$folder"/usr/lib/*/libvulkan_lvp.so $into/
    # Mesa's own file names the library without a folder, and the loader would take the system's.
    echo '{"file_format_version": "1.0.0", "ICD": {"library_path": "./libvulkan_lvp.so", "api_version": "1.3.0"}}' \
      >$into/lvp_icd.json
    say "fetched the lavapipe of Debian's backports"
  else
    say "could not fetch the lavapipe of Debian's backports (mesa-vulkan-drivers)"
  fi
  rm -rf "$folder"
}

if [ $with_drivers = yes ]; then
  [ $manager = apt ] || { say "--drivers works on Debian and Ubuntu only"; exit 1; }
  apt_update
  fetch_swiftshader
  fetch_newer_lavapipe
  drivers=
  for manifest in /usr/share/vulkan/icd.d/*lvp*.json "$PWD"/$setup/*/*_icd.json; do
    [ -f "$manifest" ] && drivers+=${drivers:+:}$manifest
  done
  say "all of them at once: export VK_DRIVER_FILES=$drivers"
fi

# Rust's standard library for Windows: ready-made by rustup, else its sources, of which cargo builds it. Those must be of the
# compiler's own version.
fetch_windows_library() {
  local version folder only package
  PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
  version=$(rustc -V | cut -d ' ' -f 2)
  [ ! -d "$(rustc --print sysroot)/lib/rustlib/x86_64-pc-windows-gnu" ] || return 0
  [ ! -d "$setup/rust-src/$version" ] || return 0
  if command -v rustup >/dev/null && timeout 90 rustup target add x86_64-pc-windows-gnu >/dev/null 2>&1; then
    say "rustup installed the standard library for Windows"
    return 0
  fi
  folder=$(mktemp -d)
  releases "$folder" trixie trixie-backports sid
  quietly as_root apt-get "${only[@]}" update -qq
  package=$(apt-cache "${only[@]}" madison rust-src | awk -v version="$version+" 'index($3, version) == 1 { print $3; exit }')
  if [ -z "$package" ]; then
    say "Debian has no rust-src of Rust $version, and rustup reaches no server: install the target x86_64-pc-windows-gnu"
    return 1
  fi
  (cd "$folder" && apt-get "${only[@]}" download -qq "rust-src=$package" 2>/dev/null)
  mkdir -p $setup/rust-src
  dpkg-deb --fsys-tarfile "$folder"/rust-src_*.deb | tar -x -C "$folder" "./usr/src/rustc-$version/library"
  mv "$folder/usr/src/rustc-$version" "$setup/rust-src/$version"
  rm -rf "$folder"
  say "fetched the sources of Rust's standard library into $setup/rust-src/$version"
}

# Wine 10 and lavapipe of Debian 13: older ones lack what Rust's programs call.
make_wine() {
  [ ! -d $setup/wine ] || return 0
  say "installing a Debian 13 with Wine in $setup/wine"
  as_root rm -rf $setup/wine.part
  quietly as_root debootstrap --variant=minbase \
    --include=wine64,wine,libvulkan1,mesa-vulkan-drivers,procps,xvfb,xdotool trixie $setup/wine.part http://deb.debian.org/debian
  as_root mv $setup/wine.part $setup/wine
}

if [ $with_windows = yes ]; then
  grep -qs '^ID=debian' /etc/os-release || { say "--windows works on Debian only"; exit 1; }
  install gcc-mingw-w64-x86-64 debootstrap
  fetch_windows_library
  make_wine
fi
