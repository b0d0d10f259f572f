//! A program in place of ours, which takes the times it is told to, and `bench` that compares it with itself.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use raindrops::picture::Picture;
use serde_json::Value;
use tempfile::TempDir;

/// A program that `bench` starts: its row takes MS milliseconds, on device DEVICE, at WIDTH pixels; with
/// NOISY 10 to 70 milliseconds, with NOISY_PASS its pass alone. With COLD the first two starts take so many seconds, with MORE there is
/// a second row. `render` copies PICTURE. Each start leaves its number in `started`.
const PROGRAM: &str = r#"#!/bin/sh
echo $$ >> "$HERE/started"
count=$(wc -l < "$HERE/started")
while [ $# -gt 0 ]; do
  case "$1" in --json|-o) file="$2";; render) picture=1;; esac
  shift
done
if [ -n "$picture" ]; then cp "$HERE/${PICTURE:-black}.exr" "$file"; exit 0; fi
[ -n "$COLD" ] && [ "$count" -le 2 ] && sleep "$COLD"
[ -z "$NOISY" ] || MS=$((10 + count * 7 % 13 * 5))
[ -z "$NOISY_PASS" ] || PASS=$((10 + count * 7 % 13 * 5))
[ "$count" = "$CRASH_AT" ] && { echo "raindrops: the device is lost" >&2; exit 2; }
[ "$count" = "$HANG_AT" ] && { sleep 600 & echo $! >> "$HERE/children"; wait; }
[ "$count" = "$RUBBISH_AT" ] && { printf '{"schema": "raindrops-' > "$file"; exit 0; }
row() { cat <<END
{"preset": "paper", "optics": "mask", "primitive": "point", "order": "unsorted", "drops": $1,
   "visible": ${VISIBLE:-200}, "width": ${WIDTH:-64}, "height": 64, "tone_map": true, "samples_ms": [${MS:-10}],
   "median_ms": ${MS:-10}, "p10_ms": 1, "p90_ms": 1, "fps": 1, "passes": {"drops": ${PASS:-${MS:-10}}},
   "counters": {"drops_in_view": ${VISIBLE:-200}, "tiles_done_again": $$},
   "rounds": [{"median_ms": ${MS:-10}, "passes": {"drops": ${PASS:-${MS:-10}}, "sky": 1}}]}
END
}
cat > "$file" <<END
{"schema": "raindrops-bench/1", "environment": "sky",
 "device": {"name": "${DEVICE:-D}", "driver": "V", "driver_info": "${DRIVER:-1}", "api_version": "1.3.0", "type": "CPU"},
 "build": {"version": "0.1.0", "commit": "unknown"}, "host": {"cpu": "C", "cores": 2, "os": "O"},
 "rows": [$(row 1000)${MORE:+, $(row 2000)}]}
END
"#;

/// A folder with the program and two pictures, and `bench` in it.
pub struct Bench(TempDir);

impl Bench {
    /// With nothing measured yet.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let program = folder.path().join("program");
        fs::write(&program, PROGRAM).expect("a program");
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).expect("its mode");
        for (name, value) in [("black", 0.1), ("white", 5.0)] {
            let pixels = vec![glam::Vec3::splat(value); 64 * 64];
            let picture = Picture { width: 64, height: 64, pixels };
            picture.write_exr(&folder.path().join(name).with_extension("exr")).expect("a picture");
        }
        Self(folder)
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = super::raindrops();
        command.current_dir(self.path()).env("HERE", self.path()).args(arguments);
        command
    }

    /// `bench` with the program on both sides.
    pub fn run(&self, arguments: &[&str]) -> Output {
        let both = ["bench", "--a-binary", "program", "--b-binary", "program", "--drops", "1000"];
        self.command(&[&both, arguments].concat()).output().expect("it starts")
    }

    pub fn json(&self, name: &str) -> Value {
        let text = fs::read_to_string(self.path().join(name)).expect("a result");
        serde_json::from_str(&text).expect("JSON")
    }

    /// How many processes were started.
    pub fn started(&self) -> usize {
        fs::read_to_string(self.path().join("started")).unwrap_or_default().lines().count()
    }

    /// None of the processes that were started is alive, nor what they started.
    pub fn all_have_ended(&self) -> bool {
        let read = |name| fs::read_to_string(self.path().join(name)).unwrap_or_default();
        let all = read("started") + &read("children");
        let has_ended = |number: &str| {
            let stat = fs::read_to_string(Path::new("/proc").join(number).join("stat"));
            // Killed, and waited for by nobody.
            stat.map_or(true, |stat| stat.rsplit(')').next().is_some_and(|of| of.starts_with(" Z")))
        };
        // A group that is killed takes a moment to end.
        (0..500).any(|_| {
            let all_have = all.lines().all(has_ended);
            if !all_have {
                std::thread::sleep(Duration::from_millis(10));
            }
            all_have
        })
    }
}
