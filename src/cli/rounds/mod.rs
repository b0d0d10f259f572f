//! Rounds: `bench` in fresh processes, alone or in turn.

pub mod environment;
pub mod pictures;
pub mod process;
pub mod stages;
mod tree;

use std::ffi::OsString;
use std::time::{Duration, Instant};

use clap::ArgMatches;
use humantime::format_duration;
use indicatif::ProgressBar;

use self::process::Arm;
use super::command_line;
use super::interrupt::{Interrupted, is_interrupted};
use super::verdict::notes;
use crate::cli::tell::{about, note, say};
use crate::measure::bench::{Amount, Report};
use crate::measure::verdict::looks::{Look, at_the_end, looks};
use crate::measure::verdict::{self, Method, Side, Verdict, VerdictRow, in_turn};
use crate::picture::flip::PIXELS_PER_DEGREE;
use crate::thousands::counted;

/// What the processes are to measure.
pub struct Work {
    /// Arguments of `bench`, the series apart.
    pub arguments: Vec<OsString>,
    /// Numbers of random drops or rates, each of which can be left out once it is decided; empty: as the scene or
    /// the arguments have it.
    pub series: Vec<Amount>,
    /// Drops placed by hand, which count among a row's.
    pub placed: u32,
    /// A process that takes longer is ended.
    pub timeout: Duration,
}

impl Work {
    /// The arguments for a part of the series.
    fn arguments(&self, series: &[Amount]) -> Vec<OsString> {
        let mut arguments = self.arguments.clone();
        let options: Vec<(&str, String)> = series.iter().map(|amount| amount.option()).collect();
        if let Some((name, _)) = options.first() {
            let values: Vec<&str> = options.iter().map(|(_, value)| value.as_str()).collect();
            arguments.push(format!("{name}={}", values.join(",")).into());
        }
        arguments
    }
}

/// How a comparison went.
pub struct Turns {
    /// All rounds of A and of B; absent if the first round failed.
    pub reports: Option<[Report; 2]>,
    /// The rows, each by the look that decided it, or the last.
    pub rows: Vec<VerdictRow>,
    /// Why it ended before all was decided.
    pub stopped: Option<String>,
    /// What went wrong; what was measured until then is above.
    pub failed: Option<anyhow::Error>,
}

/// Measures A and B in turn, look by look, until each row is decided, `most` rounds are done, or the next round,
/// and after it the pictures if there are to be any, would end after `time`. The order within a round
/// alternates: A B, B A, A B … `fits` refuses what cannot be judged, by B's first result.
pub fn take_turns(
    arms: [&Arm; 2],
    work: &Work,
    most: usize,
    threshold: f64,
    time: Bound,
    bar: &ProgressBar,
    fits: &dyn Fn(&Report) -> crate::Result<()>,
) -> Turns {
    let start = Instant::now();
    let mut turns = Turns { reports: None, rows: Vec::new(), stopped: None, failed: None };
    let mut open = work.series.clone();
    let mut rounds = 0;
    // What the next round takes by the last one, and the longest of all.
    let (mut needed, mut longest) = (None, Duration::ZERO);
    let looks = looks(most);
    for (number, look) in looks.iter().enumerate() {
        while rounds < look.rounds {
            let planned = needed.unwrap_or_default() + longest.mul_f64(time.pictures);
            // The first round compiles the drivers' shaders, which they keep: it says little of the second.
            let planned = if rounds == 1 { Duration::ZERO } else { planned };
            let ends = start.elapsed() + planned;
            if needed.is_some() && ends > time.end {
                let taken = &looks[..number];
                turns.look(&at_the_end(taken, rounds), threshold);
                turns.stopped = Some(format!(
                    "{} took {:.0} s; another would go beyond {} (--max-time)",
                    counted(rounds as u64, "round"),
                    start.elapsed().as_secs_f64(),
                    format_duration(time.end)
                ));
                return turns;
            }
            bar.set_message(progress_line(rounds, most, look, &turns.rows));
            let before = Instant::now();
            if let Err(error) =
                turns.round(arms, work.timeout, &work.arguments(&open), rounds % 2 == 1)
            {
                turns.look(&at_the_end(&looks[..number], rounds), threshold);
                turns.failed = Some(error);
                return turns;
            }
            rounds += 1;
            longest = longest.max(before.elapsed());
            needed = Some(before.elapsed());
            // A scene or a size that differs would differ in all rounds.
            if rounds == 1 {
                turns.look(&Look { rounds, rank: 0, error: 0.0 }, threshold);
                if let Some(Err(error)) = turns.reports.as_ref().map(|[_, of_b]| fits(of_b)) {
                    turns.failed = Some(error.into());
                }
                if turns.failed.is_some() {
                    return turns;
                }
                bar.suspend(|| say_expected(longest, most, time.pictures, time.end));
            }
            bar.set_position(rounds as u64);
        }
        turns.look(look, threshold);
        if turns.failed.is_some() {
            return turns;
        }
        let undecided = |row: &&VerdictRow| row.verdict == Verdict::Undecided;
        let amount = |row: &VerdictRow| Amount::of_row(row.drops, row.rate_mm_h, work.placed);
        let still: Vec<Amount> = turns.rows.iter().filter(undecided).map(amount).collect();
        bar.suspend(|| {
            say!(
                "after {}, {:.0} s: {} of {} undecided{}",
                counted(rounds as u64, "round"),
                start.elapsed().as_secs_f64(),
                still.len(),
                counted(turns.rows.len() as u64, "row"),
                doubtful(&turns.rows)
            );
        });
        if still.is_empty() {
            break;
        }
        let before = effort(&open);
        open.retain(|amount| still.contains(amount));
        if !open.is_empty() {
            needed = needed.map(|needed: Duration| needed.mul_f64(effort(&open) / before));
        }
        if number + 1 == looks.len() {
            let rows = counted(still.len() as u64, "row");
            turns.stopped =
                Some(format!("{rows} undecided after {}", counted(rounds as u64, "round")));
        }
    }
    turns
}

/// Says how long all rounds take, by the first, and `pictures` times as long for pictures.
fn say_expected(first: Duration, most: usize, pictures: f64, end: Duration) {
    let round = first.as_secs_f64();
    let all = round * (most as f64 + pictures);
    let (first, rounds) = (about(round), counted(most as u64, "round"));
    let take = if most == 1 { "takes" } else { "take" };
    match all > end.as_secs_f64() {
        true => note!(
            "the first round took {first}; up to {rounds}, as many as fit into {} (--max-time)",
            format_duration(end)
        ),
        false => note!("the first round took {first}; {rounds} {take} up to {}", about(all)),
    }
}

/// How long a comparison may take.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// No round begins that would end later.
    pub end: Duration,
    /// What pictures take after the rounds, in times of the longest round.
    pub pictures: f64,
}

impl Turns {
    /// What it came to; none if nothing was measured. `max_flip`: the FLIP by which pictures are different, where they were
    /// compared.
    pub fn report(
        &self,
        [a, b]: [&Arm; 2],
        threshold: f64,
        max_flip: Option<f64>,
    ) -> Option<verdict::Report> {
        let [of_a, of_b] = self.reports.as_ref()?;
        let sides = [Side::of(&a.label, of_a), Side::of(&b.label, of_b)];
        let (notes, missing) = notes(&[of_a], &[of_b]);
        let failed = self.failed.as_ref().map(|error| format!("{error:#}"));
        Some(verdict::Report {
            missing,
            command: Some(command_line()),
            max_flip,
            flip_pixels_per_degree: max_flip.map(|_| PIXELS_PER_DEGREE),
            stopped: failed.or_else(|| self.stopped.clone()),
            ..verdict::Report::of(Method::Paired, sides, threshold, notes, self.rows.clone())
        })
    }

    /// One round: a process of either side.
    fn round(
        &mut self,
        arms: [&Arm; 2],
        timeout: Duration,
        arguments: &[OsString],
        b_first: bool,
    ) -> anyhow::Result<()> {
        let mut found = [None, None];
        for side in if b_first { [1, 0] } else { [0, 1] } {
            found[side] = Some(arms[side].bench(arguments, timeout)?);
            if is_interrupted() {
                return Err(Interrupted.into());
            }
        }
        let [Some(a), Some(mut b)] = found else { return Ok(()) };
        // The load that B's first process finds is that of A's.
        b.warnings.retain(|warning| b.host.doubt().as_ref() != Some(warning));
        match &mut self.reports {
            None => self.reports = Some([a, b]),
            Some([all_a, all_b]) => {
                all_a.extend(a);
                all_b.extend(b);
            }
        }
        Ok(())
    }

    /// Judges the rows that were measured up to `look`; the others stay as they were decided before.
    fn look(&mut self, look: &Look, threshold: f64) {
        let Some([a, b]) = &self.reports else { return };
        let due = |report: &Report| {
            let mut report = report.clone();
            report.rows.retain(|row| row.rounds.len() == look.rounds);
            report
        };
        match in_turn(&due(a), &due(b), *look, threshold) {
            Err(error) => self.failed = Some(error.into()),
            Ok(rows) => {
                for row in rows {
                    match self.rows.iter_mut().find(|known| known.name == row.name) {
                        // What is decided stays so, although it is measured along with another row.
                        Some(known) if known.verdict != Verdict::Undecided => {}
                        Some(known) => *known = row,
                        None => self.rows.push(row),
                    }
                }
            }
        }
    }
}

/// What a round of so much takes, roughly.
fn effort(series: &[Amount]) -> f64 {
    series.iter().map(|amount| amount.effort()).sum()
}

fn progress_line(rounds: usize, most: usize, look: &Look, rows: &[VerdictRow]) -> String {
    if rows.iter().all(|row| row.ratio.is_none()) {
        return format!("round {} of at most {most}, first look at {}", rounds + 1, look.rounds);
    }
    let undecided: Vec<_> = rows.iter().filter(|row| row.verdict == Verdict::Undecided).collect();
    let first = undecided.first().and_then(|row| {
        let (ratio, low, high) = (row.ratio?, row.ratio_low?, row.ratio_high?);
        Some(format!("; {}: {ratio:.3} ({low:.3} to {high:.3})", row.name))
    });
    format!(
        "round {} of at most {most}, next look at {}, {} undecided{}",
        rounds + 1,
        look.rounds,
        undecided.len(),
        first.unwrap_or_default()
    )
}

/// The first rows that are undecided, with their intervals.
fn doubtful(rows: &[VerdictRow]) -> String {
    let line = |row: &VerdictRow| {
        let (ratio, low, high) = (row.ratio?, row.ratio_low?, row.ratio_high?);
        Some(format!("\n   {}: {ratio:.3} ({low:.3} to {high:.3})", row.name))
    };
    let undecided = rows.iter().filter(|row| row.verdict == Verdict::Undecided);
    undecided.take(4).filter_map(line).collect()
}

/// Rounds of one arm alone, for a result that is kept; `fits` may refuse the first. If the next would end after `time`,
/// there are fewer, with a warning among the result's.
pub fn alone(
    arm: &Arm,
    work: &Work,
    rounds: usize,
    time: Duration,
    bar: &ProgressBar,
    fits: &dyn Fn(&Report) -> crate::Result<()>,
) -> (Option<Report>, Option<anyhow::Error>) {
    let start = Instant::now();
    let (mut all, mut needed): (Option<Report>, _) = (None, Duration::ZERO);
    for round in 0..rounds {
        bar.set_position(round as u64);
        if let Some(all) = all.as_mut().filter(|_| start.elapsed() + needed > time) {
            all.warnings.push(format!(
                "{round} of {rounds} rounds: another would go beyond {} (--max-time)",
                format_duration(time)
            ));
            break;
        }
        let before = Instant::now();
        let found = arm.bench(&work.arguments(&work.series), work.timeout);
        needed = before.elapsed();
        if round == 0 && rounds > 1 {
            bar.suspend(|| say_expected(needed, rounds, 0.0, time));
        }
        let found = if is_interrupted() { Err(Interrupted.into()) } else { found };
        match (found, &mut all) {
            (Err(error), _) => return (all, Some(error)),
            (Ok(report), None) => match fits(&report) {
                Err(error) => return (None, Some(error.into())),
                Ok(()) => all = Some(report),
            },
            (Ok(report), Some(all)) => all.extend(report),
        }
    }
    (all, None)
}

/// The options of a command as they were given, but for its `own`, for another process of it.
pub fn passed_on(command: &clap::Command, matches: &ArgMatches, own: &[String]) -> Vec<OsString> {
    let mut arguments = Vec::new();
    for argument in command.get_arguments() {
        let id = argument.get_id().as_str();
        let given = matches.value_source(id) == Some(clap::parser::ValueSource::CommandLine);
        if own.iter().any(|own| own == id) || !given {
            continue;
        }
        let mut values: Vec<OsString> =
            matches.get_raw(id).into_iter().flatten().map(OsString::from).collect();
        if argument.get_value_delimiter().is_some() {
            values = vec![values.join(&OsString::from(","))];
        }
        match argument.get_long() {
            None => arguments.extend(values),
            Some(long) if argument.get_action().takes_values() => {
                arguments.extend(values.into_iter().map(|value| {
                    // One argument, so that a value may begin with a dash.
                    let mut option = OsString::from(format!("--{long}="));
                    option.push(value);
                    option
                }));
            }
            Some(long) => arguments.push(format!("--{long}").into()),
        }
    }
    arguments
}

#[cfg(test)]
mod tests {
    use clap::{Arg, ArgAction, Command};

    use super::passed_on;

    /// An option that is given twice stays two; a list stays one.
    #[test]
    fn options_are_passed_on_as_they_were_given() {
        let command = Command::new("bench")
            .arg(Arg::new("set").long("set").action(ArgAction::Append))
            .arg(Arg::new("drops").long("drops").value_delimiter(',').action(ArgAction::Append))
            .arg(Arg::new("quiet").long("quiet").action(ArgAction::SetTrue))
            .arg(Arg::new("rounds").long("rounds"))
            .arg(Arg::new("scene"));
        let given = "bench --set=a=1,2 --set=b=-3 --drops 1,2 --quiet --rounds 5 rain.toml";
        let matches = command.clone().get_matches_from(given.split(' '));
        let passed = passed_on(&command, &matches, &["rounds".into()]);
        assert_eq!(passed, ["--set=a=1,2", "--set=b=-3", "--drops=1,2", "--quiet", "rain.toml"]);
    }
}
