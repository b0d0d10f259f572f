//! What is expected of each device, row by row, in the manner of deqp-runner: bounds, and lists of rows that
//! fail, flake or are left out.
//!
//! ```toml
//! [[device]]
//! match = "llvmpipe"              # a part of the device's name, driver or version
//! ratio = 1.05                    # a row fails if its whole interval of B / A lies above …
//! flip = 0.01                     # … or its two pictures are farther apart …
//! error = 0.05                    # … or B's error against the reference is larger
//! fails = ["4,000,000 drops, fast"] # parts of names of rows: known to fail; one that passes is unexpected
//! flakes = ["2,000,000 drops"]      # may fail or pass
//! skips = ["no tone map"]         # not looked at; "=4,000,000 drops, fast, 1024 x 1024" is that row alone
//! passes = { composite = 1.1 }    # a row fails, too, if the whole interval of this pass lies above this
//!
//! [[device.row]]                  # other bounds for some rows
//! match = "paper"
//! ratio = 1.2
//! passes = { drops = 1.3 }
//! ```

use std::path::Path;

use indexmap::IndexMap;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use super::{PassRow, Report, Verdict, VerdictRow};
use crate::files::read_text;
use crate::measure::bench::DeviceHead;
use crate::{Error, Result};

/// An expectations file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expectations {
    device: Vec<DeviceExpectations>,
}

/// What is expected of devices whose name holds `match`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeviceExpectations {
    #[serde(rename = "match")]
    pattern: String,
    #[serde(default, deserialize_with = "bound_of")]
    ratio: Option<f64>,
    #[serde(default, deserialize_with = "bound_of")]
    flip: Option<f64>,
    #[serde(default, deserialize_with = "bound_of")]
    error: Option<f64>,
    #[serde(default)]
    fails: Vec<String>,
    #[serde(default)]
    flakes: Vec<String>,
    #[serde(default)]
    skips: Vec<String>,
    #[serde(default)]
    passes: IndexMap<String, Bound>,
    #[serde(default)]
    row: Vec<RowExpectations>,
}

/// Bounds of some rows, instead of the device's.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RowExpectations {
    #[serde(rename = "match")]
    pattern: String,
    #[serde(default, deserialize_with = "bound_of")]
    ratio: Option<f64>,
    #[serde(default, deserialize_with = "bound_of")]
    flip: Option<f64>,
    #[serde(default, deserialize_with = "bound_of")]
    error: Option<f64>,
    #[serde(default)]
    passes: IndexMap<String, Bound>,
}

/// A bound of a pass.
#[derive(Clone, Copy, Debug, Deserialize)]
struct Bound(#[serde(deserialize_with = "bound")] f64);

/// A bound that a figure can exceed: nothing is over NaN, and no test would ever fail.
fn bound<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<f64, D::Error> {
    let bound = f64::deserialize(from)?;
    match bound.is_finite() && bound >= 0.0 {
        true => Ok(bound),
        false => Err(D::Error::custom(format!(
            "{bound} is no bound; skips names rows that are not judged"
        ))),
    }
}

fn bound_of<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Option<f64>, D::Error> {
    bound(from).map(Some)
}

/// What became of a row.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Within its bounds.
    Pass,
    /// Within its bounds, and faster than the base: the bounds may be set tighter.
    Faster,
    /// Beyond a bound, and not known to be.
    Fail(String),
    /// Beyond a bound, as expected.
    ExpectedFail(String),
    /// Within its bounds, although it is listed to fail.
    UnexpectedPass,
    /// Neither within its bounds nor beyond one: its times are undecided.
    Undecided(&'static str),
    /// Beyond a bound; it is known to be at times.
    Flake(String),
    /// Not looked at.
    Skip,
}

impl Outcome {
    /// Its word, as deqp-runner has it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Pass => "Pass",
            Self::Faster => "Faster",
            Self::Fail(_) => "Fail",
            Self::ExpectedFail(_) => "ExpectedFail",
            Self::UnexpectedPass => "UnexpectedPass",
            Self::Undecided(_) => "Undecided",
            Self::Flake(_) => "KnownFlake",
            Self::Skip => "Skip",
        }
    }

    /// What is to be said of it; nothing of a row that simply passes.
    pub fn why(&self) -> Option<&str> {
        match self {
            Self::Pass => None,
            Self::Fail(why) | Self::ExpectedFail(why) | Self::Flake(why) => Some(why),
            Self::UnexpectedPass => Some("take it from the fails"),
            Self::Undecided(why) => Some(why),
            Self::Faster => Some("its bounds may be set tighter"),
            Self::Skip => Some("left out"),
        }
    }

    /// Whether the file and what was found disagree.
    pub fn is_unexpected(&self) -> bool {
        matches!(self, Self::Fail(_) | Self::UnexpectedPass)
    }
}

impl Expectations {
    /// Reads an expectations file.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read; [`Error::Scene`], with file and line, if it is no such file or a bound is
    /// none.
    pub fn load(path: &Path) -> Result<Self> {
        let text = read_text(path)?;
        toml::from_str(&text).map_err(|error| {
            let line = error.span().map_or(1, |span| text[..span.start].matches('\n').count() + 1);
            Error::Scene {
                place: format!("{}:{line}", path.display()),
                problem: error.message().lines().next().unwrap_or_default().into(),
            }
        })
    }

    /// The expectations of a device: the first whose `match` its summary holds.
    ///
    /// # Errors
    /// [`Error::Scene`] if there are none.
    pub fn of(&self, path: &Path, device: &DeviceHead) -> Result<&DeviceExpectations> {
        let summary = device.summary().to_lowercase();
        let holds = |of: &&DeviceExpectations| summary.contains(&of.pattern.to_lowercase());
        self.device.iter().find(holds).ok_or_else(|| Error::Scene {
            place: path.display().to_string(),
            problem: format!("no [[device]] matches {}", device.summary()),
        })
    }
}

/// Whether a row's name holds `part`, or is what follows a `=`; numbers may have commas at their thousands.
fn is_name(name: &str, part: &str) -> bool {
    let plain = |text: &str| text.replace(',', "");
    match part.strip_prefix('=') {
        Some(whole) => plain(name) == plain(whole),
        None => plain(name).contains(&plain(part)),
    }
}

/// The bounds of a ratio, FLIP, an error and passes, as words.
fn bounds_in_words(bounds: [Option<f64>; 3], passes: &IndexMap<String, Bound>) -> Option<String> {
    let names = ["B / A", "FLIP", "error"].into_iter().zip(bounds);
    let names = names.filter_map(|(name, bound)| Some(format!("{name} {}", bound?)));
    let passes = passes.iter().map(|(name, bound)| format!("pass {name} {}", bound.0));
    let all: Vec<String> = names.chain(passes).collect();
    (!all.is_empty()).then(|| all.join(", "))
}

impl DeviceExpectations {
    /// What becomes of a row.
    pub fn judge(&self, row: &VerdictRow) -> Outcome {
        let is_in = |parts: &[String]| parts.iter().any(|part| is_name(&row.name, part));
        if is_in(&self.skips) {
            return Outcome::Skip;
        }
        match (self.beyond(row), is_in(&self.flakes), is_in(&self.fails)) {
            (Some(why), true, _) => return Outcome::Flake(why),
            (Some(why), false, true) => return Outcome::ExpectedFail(why),
            (Some(why), false, false) => return Outcome::Fail(why),
            (None, ..) => {}
        }
        if let Some(why) = self.undecided(row) {
            return Outcome::Undecided(why);
        }
        match (is_in(&self.flakes), is_in(&self.fails)) {
            (false, true) => Outcome::UnexpectedPass,
            _ if row.verdict == Verdict::Faster => Outcome::Faster,
            _ => Outcome::Pass,
        }
    }

    /// Whether a row of this name is in one of its lists, and so judged by this file alone.
    pub fn lists(&self, name: &str) -> bool {
        let mut all = self.skips.iter().chain(&self.flakes).chain(&self.fails);
        all.any(|part| is_name(name, part))
    }

    /// Why nothing can be said of a row that is beyond no bound; none if it is within them all.
    fn undecided(&self, row: &VerdictRow) -> Option<&'static str> {
        let within = |bound: f64| row.ratio_high.is_some_and(|high| high <= bound);
        let ratio = self.ratio_of(row);
        let is_pass_within =
            |pass: &PassRow, bound: f64| pass.ratio_high.is_some_and(|high| high <= bound);
        match row.verdict {
            // By the threshold; a bound is decided by itself.
            Verdict::Undecided if ratio.is_none_or(|bound| !within(bound)) => Some(
                "neither passed nor failed; more rounds, or more runs at other times, may decide it",
            ),
            _ if !self.passes_of(row).all(|(_, pass, bound)| is_pass_within(pass, bound)) => {
                Some("a pass's bound lies within its interval; more rounds or runs may decide it")
            }
            _ if ratio.is_none_or(within) => None,
            _ => Some("the bound lies within its interval; more rounds or runs may decide it"),
        }
    }

    /// The rows' own bounds that hold for a row.
    fn own(&self, row: &VerdictRow) -> Option<&RowExpectations> {
        self.row.iter().find(|own| is_name(&row.name, &own.pattern))
    }

    /// The bound of a row's ratio.
    fn ratio_of(&self, row: &VerdictRow) -> Option<f64> {
        self.own(row).and_then(|own| own.ratio).or(self.ratio)
    }

    /// The passes of a row that have a bound, the rows' own before the device's.
    fn passes_of<'a>(
        &'a self,
        row: &'a VerdictRow,
    ) -> impl Iterator<Item = (&'a str, &'a PassRow, f64)> {
        let own = self.own(row);
        row.passes.iter().filter_map(move |(name, pass)| {
            let bound = own.and_then(|own| own.passes.get(name)).or(self.passes.get(name))?;
            Some((name.as_str(), pass, bound.0))
        })
    }

    /// The bound that a row is beyond.
    fn beyond(&self, row: &VerdictRow) -> Option<String> {
        let own = self.own(row);
        let flip = own.and_then(|own| own.flip).or(self.flip);
        let error = own.and_then(|own| own.error).or(self.error);
        let over = |what: &str, value: Option<f64>, bound: Option<f64>| {
            let (value, bound) = (value?, bound?);
            (value > bound).then(|| format!("{what} {value:.4}, over the bound {bound}"))
        };
        over("B / A is at least", row.ratio_low, self.ratio_of(row))
            .or_else(|| over("FLIP is", row.flip_between, flip))
            .or_else(|| over("the error is", row.error_b, error))
            .or_else(|| {
                self.passes_of(row).find_map(|(name, pass, bound)| {
                    over(&format!("pass {name}: B / A is at least"), pass.ratio_low, Some(bound))
                })
            })
    }

    /// Its bounds in words: `B / A 1.05, FLIP 0.01; of rows with 'paper': B / A 1.2, pass drops 1.3`. None if it has none.
    pub fn bounds(&self) -> Option<String> {
        let all = bounds_in_words([self.ratio, self.flip, self.error], &self.passes);
        let own = self.row.iter().filter_map(|own| {
            let bounds = bounds_in_words([own.ratio, own.flip, own.error], &own.passes)?;
            Some(match own.pattern.strip_prefix('=') {
                Some(whole) => format!("of row '{whole}': {bounds}"),
                None => format!("of rows with '{}': {bounds}", own.pattern),
            })
        });
        let all: Vec<String> = all.into_iter().chain(own).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }

    /// What in it holds for nothing, in words: names that the rows lack, rows that an earlier name takes, bounds of what was
    /// not measured. It is of no use any more, or misspelt, or the run left it out.
    pub fn unused(&self, report: &Report) -> Vec<String> {
        let rows = &report.rows;
        let Some(first) = rows.first() else { return Vec::new() };
        let like = format!("; one is '{}'", first.name);
        let is_there = |part: &str| rows.iter().any(|row| is_name(&row.name, part));
        let of_rows = self.row.iter().map(|row| &row.pattern);
        let parts = self.fails.iter().chain(&self.flakes).chain(&self.skips).chain(of_rows);
        let is_missing = |part: &str| report.missing.iter().any(|row| is_name(&row.name, part));
        let parts = parts.filter(|part| !is_there(part) && !is_missing(part));
        let parts = parts.map(|part| match part.strip_prefix('=') {
            Some(whole) => format!("no row's name is '{whole}'{like}"),
            None => format!("no row's name contains '{part}'{like}"),
        });
        // The first that a row's name has is taken.
        let is_own = |own: &RowExpectations| {
            rows.iter().any(|row| self.own(row).is_some_and(|taken| std::ptr::eq(taken, own)))
        };
        let shadowed = self.row.iter().filter(|own| is_there(&own.pattern) && !is_own(own));
        let shadowed = shadowed
            .map(|own| format!("a [[device.row]] before it takes all rows of '{}'", own.pattern));
        let everywhere = self.passes.keys().map(|pass| (pass, ""));
        let own = self
            .row
            .iter()
            .flat_map(|own| own.passes.keys().map(|pass| (pass, own.pattern.as_str())));
        let passes = everywhere.chain(own).filter_map(|(pass, of)| {
            // Where no row is of that name, that is said already.
            let mut named = rows.iter().filter(|row| is_name(&row.name, of)).peekable();
            let first = *named.peek()?;
            let known: Vec<&str> = first.passes.keys().map(String::as_str).collect();
            let has_it = named.any(|row| row.passes.contains_key(pass));
            (!has_it).then(|| {
                format!("no row has a pass '{pass}'; {} has {}", first.name, known.join(", "))
            })
        });
        let has_flip = self.flip.is_some() || self.row.iter().any(|own| own.flip.is_some());
        let has_error = self.error.is_some() || self.row.iter().any(|own| own.error.is_some());
        let flip = has_flip && rows.iter().all(|row| row.flip_between.is_none());
        let error = has_error && rows.iter().all(|row| row.error_b.is_none());
        let flip = flip.then_some("flip holds for no row: no pictures were compared");
        let error = error.then_some("error holds for no row: it needs --truth-samples");
        let unmeasured = flip.into_iter().chain(error).map(String::from);
        parts.chain(shadowed).chain(passes).chain(unmeasured).collect()
    }
}
