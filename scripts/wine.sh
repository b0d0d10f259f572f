#!/usr/bin/env bash
# The checks of scripts/windows.sh, which runs them in a Debian of their own: /try has raindrops.exe, raindrops and assets. Both
# draw by the same driver, so that pictures must be the same to the byte. The last line counts the checks.
#
# Exit status: 0 if all pass, else 1.
set -uo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
cd /try || exit 2
mkdir -p home prefix /tmp
export HOME=/try/home WINEPREFIX=/try/prefix WINEDEBUG=-all WINEDLLOVERRIDES="mscoree,mshtml=" XDG_RUNTIME_DIR=/tmp
passed=0 failed=0
check() { # words, command: its output only if it fails
  if "${@:2}" >log 2>&1; then passed=$((passed + 1)); echo "passed: $1"
  else failed=$((failed + 1)); echo "FAILED: $1"; tail -n 20 log | sed 's/^/    /'
  fi
}
has() { # file, text: prints the file if it lacks it
  grep -qF -- "$2" "$1" || { echo "there is no '$2' in $1:"; cat "$1"; return 1; }
}
linux() { ./raindrops --quiet "$@"; }
windows() { wine ./raindrops.exe --quiet "$@"; }
until_true() { # seconds, command
  local left=$(($1 * 5))
  until "${@:2}"; do
    left=$((left - 1))
    [ $left -gt 0 ] || { echo "not within $1 s: ${*:2}"; return 1; }
    sleep 0.2
  done
}
# Processes of Windows whose command line holds a text.
processes() { pgrep -f "raindrops.exe.*$1"; }
none_left() { ! processes "$1" >/dev/null; }

same_pictures() { # scene, options
  local kind
  for kind in exr png; do
    linux render "assets/scenes/$1.toml" "${@:2}" -o "linux.$kind" &&
      windows render "assets/scenes/$1.toml" "${@:2}" -o "windows.$kind" && cmp "linux.$kind" "windows.$kind" || return 1
  done
}

devices() {
  windows devices >devices.txt && has devices.txt llvmpipe && has devices.txt "fit             yes"
}

# What results say of the machine: as on Linux, or nothing.
facts() {
  local options=(bench --preset fast --drops 2000 --size 64x64 --seconds 0.1)
  linux "${options[@]}" --json linux.json && windows "${options[@]}" --json windows.json || return 1
  local cpu
  cpu=$(sed -n 's/^ *"cpu": "\(.*\)",$/\1/p' linux.json)
  has windows.json "\"cpu\": \"${cpu% (family *}\"" && has windows.json '"os": "Windows ' && has windows.json '"load": null' &&
    ! grep '"others"' windows.json
}

memory() {
  windows bench --preset fast --drops 2000 --size 64x64 --duration 3s --json long.json && grep -q '"resident_bytes": [1-9]' long.json &&
    has long.json 'clock is read on Linux only'
}

same_report() {
  linux report linux.json windows.json -o linux.html && windows report linux.json windows.json -o windows.html &&
    cmp linux.html windows.html
}

in_turn() { # B's drivers
  windows bench --preset fast --drops 2000 --size 64x64 --max-time 30s --json verdict.json \
    --a 'VK_DRIVER_FILES=C:\drivers\a.json;C:\drivers\b.json' --b "VK_DRIVER_FILES=$1"
}
lists_of_files() {
  mkdir -p prefix/drive_c/drivers
  cp /usr/share/vulkan/icd.d/lvp_icd*.json prefix/drive_c/drivers/a.json
  cp prefix/drive_c/drivers/a.json prefix/drive_c/drivers/b.json
  in_turn 'C:\drivers\b.json' || return 1
  has verdict.json '"VK_DRIVER_FILES": "C:\\drivers\\a.json;C:\\drivers\\b.json"' || return 1
  ! in_turn 'C:\drivers\b.json;C:\nowhere.json' 2>missing.txt && has missing.txt "there is no file 'C:\\nowhere.json'"
}

rounds() { windows bench --preset fast --drops 2000 --size 64x64 --rounds 20 --seconds 20 --json rounds.json "$@"; }
# The process of a round, by the name of its result.
round() { processes result.json; }

# Ctrl C, while this process waits for a round: Wine 10 itself crashes where an interrupt meets a call of Vulkan.
interrupted() {
  local status=0
  rounds 2>rounds.txt &
  until_true 60 round >/dev/null || return 1
  sleep 1
  kill -INT "$(processes rounds.json | tail -n 1)"
  wait $! || status=$?
  [ $status = 130 ] || { echo "status $status"; cat rounds.txt; return 1; }
  until_true 10 none_left result.json
}

killed_child() {
  rounds 2>rounds.txt &
  until_true 60 round >/dev/null || return 1
  sleep 1
  kill -KILL "$(round | tail -n 1)"
  wait $! && { echo "it ended with status 0"; return 1; }
  has rounds.txt "ended without a result" && until_true 10 none_left raindrops
}

timed_out_child() {
  ! rounds --timeout 1s 2>rounds.txt && has rounds.txt "took longer than 1 s" && until_true 10 none_left result.json
}

killed_parent() {
  rounds 2>rounds.txt &
  until_true 60 round >/dev/null || return 1
  sleep 1
  kill -KILL "$(processes rounds.json | tail -n 1)"
  until_true 10 none_left result.json
}

window() {
  # A session of Wine keeps the display that it began with.
  wineserver -k; wineserver -w
  Xvfb :7 -screen 0 800x600x24 >/dev/null 2>&1 &
  local server=$! status=0
  export DISPLAY=:7
  mkdir -p shots
  until_true 20 xdotool getmouselocation >/dev/null 2>&1 || return 1
  windows view assets/scenes/rain.toml --drops 2000 --size 320x180 -o shots &
  local program=$!
  until_true 60 xdotool search --name raindrops >/dev/null && sleep 3 &&
    xdotool search --name raindrops windowfocus key F12 && until_true 20 compgen -G 'shots/*.png' >/dev/null &&
    xdotool search --name raindrops windowfocus key Escape && until_true 20 none_left shots || status=1
  wait $program || status=1
  kill $server
  unset DISPLAY
  return $status
}

wine --version
check "Wine starts" wineboot --init
check "devices" devices
check "rain.toml, preset paper: EXR and PNG equal Linux' bytes" same_pictures rain --size 160x160 --drops 20000 --preset paper
check "drizzle.toml, preset fast: EXR and PNG equal Linux' bytes" same_pictures drizzle --size 160x90 --preset fast
check "bubbles.toml, preset exact: EXR and PNG equal Linux' bytes" same_pictures bubbles --size 96x54 --preset exact
check "processor and system are Linux' or Windows', load and others absent" facts
check "memory of the process; no clock" memory
check "report of results: equals Linux' bytes" same_report
check "bench of two sides: lists of driver files with ;" lists_of_files
check "rounds that are interrupted: status 130, no process is left" interrupted
check "a round that is killed: an error, no process is left" killed_child
check "a round that takes too long: an error, no process is left" timed_out_child
check "rounds whose parent is killed: no process is left" killed_parent
check "view: a window, a screenshot, Esc" window
echo "$passed passed, $failed failed"
[ $failed = 0 ]
