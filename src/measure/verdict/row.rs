//! What is said of a row, and of the whole: schema `raindrops-verdict/1`.

use std::path::PathBuf;

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::Interval;
use super::files::Side;

/// Name and version of the format.
pub const SCHEMA: &str = "raindrops-verdict/1";

/// What a comparison comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The whole interval lies below 1 / (1 + threshold).
    Faster,
    /// The whole interval lies above 1 + threshold.
    Slower,
    /// The whole interval lies between the two.
    Same,
    /// None of these: the interval is too wide, or there is none.
    Undecided,
    /// The pictures are farther apart than accepted, whatever the times.
    Different,
}

impl Verdict {
    /// All of them, what is to be looked at first.
    pub const ALL: [Self; 5] =
        [Self::Slower, Self::Faster, Self::Same, Self::Undecided, Self::Different];

    /// Its name, as in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Faster => "faster",
            Self::Slower => "slower",
            Self::Same => "same",
            Self::Undecided => "undecided",
            Self::Different => "different",
        }
    }
}

/// What an interval of ratios says, by a threshold such as 0.05.
pub fn judge(interval: Option<Interval>, threshold: f64) -> Verdict {
    let Some(Interval { low, high, .. }) = interval else { return Verdict::Undecided };
    let (below, above) = (1.0 / (1.0 + threshold), 1.0 + threshold);
    match () {
        () if low > above => Verdict::Slower,
        () if high < below => Verdict::Faster,
        () if low >= below && high <= above => Verdict::Same,
        () => Verdict::Undecided,
    }
}

/// How the times of two results were taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Processes in turn.
    Paired,
    /// Runs at different times.
    Unpaired,
}

/// Two results held against each other.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: String,
    /// The command line, quoted as a shell needs it.
    #[serde(default)]
    pub command: Option<String>,
    /// What the ratios are over.
    pub a: Side,
    /// What they are of.
    pub b: Side,
    /// How its times were taken.
    pub method: Method,
    /// A ratio farther from 1 than this, as a part of 1, is slower or faster.
    pub threshold: f64,
    /// Pictures with a mean FLIP over this are different; none were compared where absent.
    pub max_flip: Option<f64>,
    /// FLIP's pixels a degree of the observer's view.
    pub flip_pixels_per_degree: Option<f64>,
    /// Why it ended before all was decided, if it did.
    pub stopped: Option<String>,
    /// What differs and is allowed to, such as the driver's version.
    pub notes: Vec<String>,
    /// The bounds of `--expect` by which rows fail, in words; none where there is no such file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounds: Option<String>,
    /// How many rows have which verdict.
    #[serde(default)]
    pub counts: IndexMap<String, usize>,
    /// The rows by which the command's exit status is 1, and why, then what `--fail-unused` fails; none
    /// where nothing was to fail it.
    #[serde(default)]
    pub failed: Vec<String>,
    /// The rows of A that B lacks.
    #[serde(default)]
    pub missing: Vec<MissingRow>,
    /// One row a row of the benchmark that both have.
    pub rows: Vec<VerdictRow>,
}

impl Report {
    /// A report on A and B without their pictures; the caller adds its command.
    pub fn of(
        method: Method,
        [a, b]: [Side; 2],
        threshold: f64,
        notes: Vec<String>,
        rows: Vec<VerdictRow>,
    ) -> Self {
        Self {
            schema: SCHEMA.into(),
            command: None,
            a,
            b,
            method,
            threshold,
            max_flip: None,
            flip_pixels_per_degree: None,
            stopped: None,
            notes,
            bounds: None,
            counts: IndexMap::new(),
            failed: Vec::new(),
            missing: Vec::new(),
            rows,
        }
    }
}

/// A row of A that B lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the keys of the result file, see docs/result-files.md")]
pub struct MissingRow {
    pub name: String,
    pub preset: String,
    pub drops: u32,
    /// The rate of real rain, mm/h; none for other rain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_mm_h: Option<f64>,
    pub width: u32,
    pub height: u32,
    pub tone_map: bool,
    pub median_ms_a: f64,
}

impl MissingRow {
    /// What stands in the place of its verdict.
    pub const VERDICT: &'static str = "missing";
}

/// One row of the benchmark, of A and of B.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the keys of the result file, see docs/result-files.md")]
pub struct VerdictRow {
    pub name: String,
    pub preset: String,
    pub drops: u32,
    /// The rate of real rain, mm/h; none for other rain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_mm_h: Option<f64>,
    pub width: u32,
    pub height: u32,
    pub tone_map: bool,
    pub verdict: Verdict,
    /// Time of B over that of A; absent with too few rounds, as are its ends.
    pub ratio: Option<f64>,
    pub ratio_low: Option<f64>,
    pub ratio_high: Option<f64>,
    pub threshold: f64,
    /// Rounds of the side that has fewer.
    pub rounds: usize,
    pub noise_floor: Option<f64>,
    pub median_ms_a: f64,
    pub median_ms_b: f64,
    /// Median of every round, in turn.
    pub rounds_ms_a: Vec<f64>,
    pub rounds_ms_b: Vec<f64>,
    pub flip_between: Option<f64>,
    pub error_a: Option<f64>,
    pub error_b: Option<f64>,
    pub first_stage_that_differs: Option<String>,
    /// What became of it by what is expected, as deqp-runner has it; none where nothing is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outcome: Option<String>,
    /// Files of its two pictures, where they were kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pictures: Option<Pictures>,
    /// Counters that differ: A's value, then B's.
    pub counters: IndexMap<String, (u64, u64)>,
    pub passes: IndexMap<String, PassRow>,
    pub notes: Vec<String>,
}

/// Pictures as PNG, their paths relative to the result file's folder or absolute.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pictures {
    /// Picture of A, tone mapped.
    pub a: PathBuf,
    /// Picture of B, by the exposure of A.
    pub b: PathBuf,
    /// FLIP's error of each pixel in false colours: black for none, violet for 1/16, red for 1/4, yellow for 9/16, white for 1.
    pub difference: PathBuf,
    /// The largest error of a pixel, and its column and row from the upper left.
    #[serde(default)]
    pub largest_flip: Option<f64>,
    #[serde(default)]
    #[allow(missing_docs, reason = "see the line before")]
    pub largest_flip_at: Option<(u32, u32)>,
}

/// One pass of a row, of A and of B.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the keys of the result file, see docs/result-files.md")]
pub struct PassRow {
    pub verdict: Verdict,
    pub ratio: Option<f64>,
    pub ratio_low: Option<f64>,
    pub ratio_high: Option<f64>,
    pub median_ms_a: f64,
    pub median_ms_b: f64,
}

impl VerdictRow {
    /// What is known of the pictures: FLIP of one to the other, by which the row is different if it
    /// exceeds `most`.
    pub fn see(&mut self, flip: f64, most: f64) {
        self.flip_between = Some(flip);
        if flip > most {
            self.verdict = Verdict::Different;
        }
    }
}

impl Report {
    /// Gives every row and pass the verdict that its interval and its pictures have by other bounds. The intervals stay:
    /// they contain the ratio with 95 % confidence whatever is asked of them, all looks together.
    pub fn judge_again(&mut self, threshold: f64, max_flip: Option<f64>) {
        (self.threshold, self.max_flip) = (threshold, max_flip);
        for row in &mut self.rows {
            (row.threshold, row.outcome) = (threshold, None);
            let interval = Interval::of_ends(row.ratio, row.ratio_low, row.ratio_high);
            row.verdict = judge(interval, threshold);
            if let Some((flip, most)) = row.flip_between.zip(max_flip) {
                row.see(flip, most);
            }
            for pass in row.passes.values_mut() {
                let interval = Interval::of_ends(pass.ratio, pass.ratio_low, pass.ratio_high);
                pass.verdict = judge(interval, threshold);
            }
        }
    }

    /// The rows of one verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.rows.iter().filter(|row| row.verdict == verdict).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_intervals_are_judged_by_other_bounds() {
        let side = serde_json::json!({"label": "l", "start": null, "warnings": [],
            "device": {"name": "D", "driver": "V", "driver_info": "1", "api_version": "1.3.0", "type": "CPU"},
            "build": {"version": "0.1.0", "commit": "c"}, "host": {"cpu": "C", "cores": 2, "os": "O"}});
        let pass = |low: f64, high: f64| {
            serde_json::json!({"verdict": "same", "ratio": low, "ratio_low": low, "ratio_high": high,
                "median_ms_a": 1.0, "median_ms_b": 1.0})
        };
        let row = serde_json::json!({"name": "one", "preset": "fast", "drops": 1, "width": 1, "height": 1, "tone_map": true,
            "verdict": "different", "ratio": 1.1, "ratio_low": 1.08, "ratio_high": 1.12, "threshold": 0.05, "rounds": 10,
            "noise_floor": null, "median_ms_a": 1.0, "median_ms_b": 1.0, "rounds_ms_a": [], "rounds_ms_b": [],
            "flip_between": 0.02, "error_a": null, "error_b": null, "first_stage_that_differs": null, "outcome": "Fail",
            "counters": {}, "passes": {"sky": pass(1.3, 1.4), "blend": pass(0.99, 1.01)}, "notes": []});
        let report = serde_json::json!({"schema": SCHEMA, "a": side, "b": side, "method": "paired", "threshold": 0.05,
            "max_flip": 0.01, "flip_pixels_per_degree": 67.0, "stopped": null, "notes": [], "rows": [row]});
        let mut report: Report = serde_json::from_value(report).expect("a report");
        let mut verdicts = |threshold: f64, max_flip: f64| {
            report.judge_again(threshold, Some(max_flip));
            let row = &report.rows[0];
            assert_eq!((row.threshold, &row.outcome), (threshold, &None));
            [row.verdict, row.passes["sky"].verdict, row.passes["blend"].verdict]
        };
        use Verdict::{Different, Same, Slower, Undecided};
        assert_eq!(verdicts(0.05, 0.03), [Slower, Slower, Same]);
        assert_eq!(verdicts(0.1, 0.02), [Undecided, Slower, Same]);
        assert_eq!(verdicts(0.2, 0.03), [Same, Slower, Same]);
        assert_eq!(verdicts(0.2, 0.01), [Different, Slower, Same]);
    }

    #[test]
    fn the_whole_interval_decides() {
        let of = |low: f64, high: f64| {
            judge(Some(Interval { ratio: (low * high).sqrt(), low, high }), 0.05)
        };
        assert_eq!(of(1.06, 1.5), Verdict::Slower);
        assert_eq!(of(1.05, 1.5), Verdict::Undecided, "the limit itself is not exceeded");
        assert_eq!(of(0.5, 0.95), Verdict::Faster);
        assert_eq!(of(0.5, 0.953), Verdict::Undecided);
        assert_eq!(of(0.96, 1.04), Verdict::Same);
        assert_eq!(of(0.94, 1.06), Verdict::Undecided);
        assert_eq!(judge(None, 0.05), Verdict::Undecided);
    }
}
