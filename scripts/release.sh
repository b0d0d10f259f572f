#!/usr/bin/env bash
# Makes an archive of the program that needs no sources: program, scenes, environments, completions, manual pages,
# licences of all crates in it, and a list of what the target machine must have.
#
#   scripts/release.sh [FOLDER]         writes FOLDER/raindrops-VERSION-TARGET.tar.gz; FOLDER is out if not given
#   scripts/release.sh --deb [FOLDER]   also FOLDER/raindrops_VERSION-1_ARCHITECTURE.deb, by cargo-deb (cargo install cargo-deb)
#
# RAINDROPS names the program, else it is built. RAINDROPS_WINDOWS names raindrops.exe of the same sources, which scripts/windows.sh
# builds: then it is packed, as raindrops-VERSION-x86_64-pc-windows-gnu.zip. Exit status: 0; 2 for an error.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
deb=
if [ "${1-}" = --deb ]; then deb=yes; shift; fi
folder=${1:-out}
case $folder in -*) sed -n '2,/^set /s/^# \{0,1\}//p' "$0" >&2; exit 2 ;; esac
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
program=${RAINDROPS:+$(realpath "$RAINDROPS")}
windows=${RAINDROPS_WINDOWS:+$(realpath "$RAINDROPS_WINDOWS")}
cd "$(dirname "$0")/.."
fail() { echo "release: $*" >&2; exit 2; }
if [ -n "$deb" ]; then
  PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
  [ -z "$windows" ] || fail "--deb is for Linux, RAINDROPS_WINDOWS is not"
  command -v cargo-deb >/dev/null || fail "cargo-deb is missing: cargo install cargo-deb"
fi
if [ -z "$program" ]; then
  scripts/setup.sh
  scripts/cargo.sh build --release --locked --bin raindrops || fail "the program does not build"
  program=${CARGO_TARGET_DIR:-target}/release/raindrops
fi

version=$("$program" --version | cut -d ' ' -f 2)
target=$(PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin rustc -vV | sed -n 's/^host: //p')
[ -z "$windows" ] || target=x86_64-pc-windows-gnu
name=raindrops-$version-$target
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
into=$tree/$name
mkdir -p "$into"/{licences,assets,completions}

cp README.md CHANGELOG.md "$into/"
cp -r assets/scenes assets/scene.schema.json assets/low-sun.exr assets/porch assets/sky.exr "$into/assets/"
if [ -d assets/environments ]; then cp -r assets/environments "$into/assets/"; fi
if [ -n "$windows" ]; then
  cp "$windows" "$into/raindrops.exe"
  x86_64-w64-mingw32-strip "$into/raindrops.exe"
  "$program" completions powershell >"$into/completions/raindrops.ps1"
else
  mkdir -p "$into"/{bin,man/man1}
  cp "$program" "$into/bin/raindrops"
  strip "$into/bin/raindrops"
  for shell in bash zsh fish; do "$program" completions $shell >"$into/completions/raindrops.$shell"; done
  "$program" --quiet man -o "$into/man/man1"
fi

# Licences: this program's, the sky model's, and those of each crate that is linked. A crate without a text of its own
# is named with its licence's identifier; the texts of MIT and Apache 2.0 stand beside.
cp LICENSE-MIT LICENSE-APACHE assets/LICENSE-hosek-wilkie "$into/licences/"
scripts/cargo.sh tree --locked -e normal,no-proc-macro --prefix none --format '{p}' --target "$target" >"$tree/linked"
scripts/cargo.sh metadata --locked --format-version 1 --filter-platform "$target" >"$tree/metadata"
python3 - "$tree/linked" "$tree/metadata" >"$into/licences/crates.txt" <<'PYTHON' || fail "no licences"
import json, pathlib, re, sys
linked = {tuple(line.split()[:2]) for line in open(sys.argv[1]) if line.strip()}
names = re.compile(r"(licen[cs]e|copying|notice|copyright|ofl|ufl)", re.IGNORECASE)
found = set()
for package in sorted(json.load(open(sys.argv[2]))["packages"], key=lambda p: (p["name"], p["version"])):
    key = (package["name"], "v" + package["version"])
    if key not in linked or package["name"] == "raindrops":
        continue
    found.add(key)
    folder = pathlib.Path(package["manifest_path"]).parent
    files = [f for f in [*folder.iterdir(), *folder.glob("*/*")] if f.is_file() and f.suffix != ".rs"
             and (names.match(f.name) or (f.parent.name == "fonts" and f.suffix == ".txt"))]
    print("=" * 80 + f"\n{key[0]} {package['version']}: {package['license'] or package['license_file']}")
    print(package["repository"] or "")
    for file in sorted(files):
        print(f"\n--- {file.relative_to(folder)}\n{file.read_text(errors='replace').strip()}")
missing = [key for key in linked - found if key[0] != "raindrops"]
assert not missing and len(found) > 50, (missing, len(found))
PYTHON

installation() {
  echo "raindrops $version for $target"
  echo
  echo "bin/raindrops view assets/scenes/rain.toml --drops 200000"
  echo "bin/raindrops bench --preset paper,fast --drops 125000"
  echo "bin/raindrops render assets/scenes/rain.toml -o rain.png"
  echo
  echo "The machine must have the Vulkan loader (libvulkan.so.1) and a driver for Vulkan 1.3. On Debian and Ubuntu"
  echo "apt-get install libvulkan1 mesa-vulkan-drivers installs both; lavapipe among the drivers needs no GPU. view opens a window"
  echo "and needs X11 or Wayland with their libraries, as a desktop has them; render and bench need neither."
  echo "README.md is that of the sources: the scripts and documents that it names are there. man -l man/man1/raindrops.1 is here."
  echo
  echo "The program is linked with:"
  objdump -p "$into/bin/raindrops" | sed -n 's/^ *NEEDED */  /p'
  echo "and needs the C library $(objdump -T "$into/bin/raindrops" | grep -o 'GLIBC_[0-9.]*' | sort -Vu | tail -n 1 | tr _ ' ') or later."
  echo
  echo "completions: bash into ~/.local/share/bash-completion/completions/raindrops, zsh as _raindrops into a folder of \$fpath,"
  echo "fish into ~/.config/fish/completions. Manual pages: man/man1 into ~/.local/share/man."
}

installation_on_windows() {
  cat <<TEXT
raindrops $version for $target: Windows 10 or later, x86-64

In PowerShell or the command prompt, in this folder:

.\raindrops.exe view assets/scenes/rain.toml --drops 200000
.\raindrops.exe bench --preset paper,fast --drops 125000
.\raindrops.exe render assets/scenes/rain.toml -o rain.png

The machine must have a driver for Vulkan 1.3, as those of AMD, Intel and NVIDIA are; it brings the loader (vulkan-1.dll).
Nothing is installed: delete the folder, and %LOCALAPPDATA%\raindrops with what was measured of devices.
README.md is that of the sources: the scripts and documents that it names are there.

The program is linked with:
$(x86_64-w64-mingw32-objdump -p "$into/raindrops.exe" | sed -n 's/^.*DLL Name: /  /p' | sort -fu)

completions: add the line ". PATH\completions\raindrops.ps1" to the file that \$PROFILE names.
TEXT
}

if [ -n "$windows" ]; then
  installation_on_windows | sed 's/$/\r/' >"$into/INSTALL.txt"
  archive=$folder/$name.zip
  # Every file of one date, so that the same files make the same archive. (The program itself has the time of its stripping.)
  python3 - "$tree" "$archive.part" <<'PYTHON' || fail "no archive"
import pathlib, sys, zipfile
tree = pathlib.Path(sys.argv[1])
with zipfile.ZipFile(sys.argv[2], "w", zipfile.ZIP_DEFLATED) as archive:
    for file in sorted(path for path in tree.glob("raindrops-*/**/*") if path.is_file()):
        archive.writestr(zipfile.ZipInfo(str(file.relative_to(tree))), file.read_bytes(), zipfile.ZIP_DEFLATED)
PYTHON
else
  installation >"$into/INSTALL.txt"
  archive=$folder/$name.tar.gz
  tar --create --directory "$tree" --sort=name --owner=0 --group=0 --numeric-owner "$name" | gzip -n >"$archive.part"
fi
mv "$archive.part" "$archive"
echo "release: $archive, $(du -h "$archive" | cut -f 1)" >&2

# The files of the archive, at the places that Cargo.toml names.
if [ -n "$deb" ]; then
  rm -rf target/package/raindrops
  mkdir -p target/package
  cp -r "$into" target/package/raindrops
  made=$(cargo-deb --no-build --no-strip --output "$folder/" 2>"$tree/deb.log" | tail -n 1) || { cat "$tree/deb.log" >&2; fail "no .deb"; }
  [ -f "$made" ] || { cat "$tree/deb.log" >&2; fail "no .deb"; }
  echo "release: $made, $(du -h "$made" | cut -f 1)" >&2
fi
