//! What a survey measures, besides its pictures.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::gpu::Machine;

/// A command of this program that leaves `NAME.json`.
pub(super) struct Step {
    pub name: &'static str,
    /// Words of its command line with a space between them, but for the result.
    words: String,
    pub variables: Vec<(&'static str, &'static str)>,
    /// Time for it alone, of the eight minutes that a survey has.
    pub most: Duration,
}

impl Step {
    fn new(name: &'static str, most_s: u64, words: &str) -> Self {
        let most = Duration::from_secs(most_s);
        Self { name, words: words.into(), variables: Vec::new(), most }
    }

    /// The file that it writes.
    pub fn result(&self, folder: &Path) -> PathBuf {
        folder.join(self.name).with_extension("json")
    }

    /// The words of its command line.
    pub fn arguments(&self, result: &Path) -> Vec<OsString> {
        let words = self.words.split(' ').map(OsString::from);
        words.chain(["--json".into(), result.into()]).collect()
    }
}

/// The steps for a machine: on a CPU they have fewer drops and less rain, so that all finish in time.
pub(super) fn steps(machine: Machine) -> Vec<Step> {
    let [all, few, rates, presets, size, other] = match machine {
        Machine::Cpu => ["125000,1000000", "125000", "8,25", "fast", "512x512", "gpu"],
        Machine::Gpu => [
            "125000,250000,500000,1000000,2000000,4000000",
            "125000,1000000",
            "8,25,100",
            "fast,exact",
            "1024x1024",
            "cpu",
        ],
    };
    let bench = |name, most_s, words: &str| {
        Step::new(name, most_s, &format!("bench --min-frames 3 --seconds {words}"))
    };
    let rain = |name, shutter: &str| {
        let kind = format!("--rain {rates} --size {size} --preset {presets} --shutter {shutter}");
        bench(name, 90, &format!("0.5 {kind}"))
    };
    let mut on_other = bench("laid-out-otherwise", 60, &format!("0.5 --preset fast --drops {all}"));
    on_other.variables = vec![("RAINDROPS_MACHINE", other)];
    vec![
        Step::new("devices", 60, "devices --probe"),
        bench("table-2", 150, &format!("1 --preset paper,fast --drops {all}")),
        bench("exact", 60, &format!("0.5 --preset exact --drops {few}")),
        on_other,
        rain("rain-at-rest", "0"),
        rain("rain-exposed", "1/60"),
        // Few samples and one scene: which models are worth their time here, not what their error is to three digits.
        Step::new(
            "tradeoff",
            120,
            "tradeoff --drops 20000 --size 256x256 --truth-samples 32 --seconds 0.1 --min-frames 2",
        ),
    ]
}
