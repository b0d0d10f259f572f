//! Rounds: `bench` in fresh processes, alone or in turn.

pub mod environment;
pub mod pictures;
pub mod process;

use std::ffi::OsString;
use std::time::{Duration, Instant};

use clap::ArgMatches;
use indicatif::ProgressBar;

use self::process::{Arm, Limits};
use super::interrupt::{Interrupted, is_interrupted};
use crate::measure::bench::{Amount, Report};
use crate::measure::verdict::looks::{Look, looks};
use crate::measure::verdict::{Verdict, VerdictRow, in_turn};

/// What the processes are to measure.
pub struct Work {
    /// Arguments of `bench`, the series apart.
    pub arguments: Vec<OsString>,
    /// Numbers of random drops or rates, each of which can be left out once it is decided; empty: as the scene or
    /// the arguments have it.
    pub series: Vec<Amount>,
    /// Drops placed by hand, which count among a row's.
    pub placed: u32,
    /// What holds each process back.
    pub limits: Limits,
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

/// Measures A and B in turn, look by look, until each row is decided, `most` rounds are done, or the next
/// look would come after `time`. The order within a round alternates: A B, B A, A B …
pub fn take_turns(
    arms: [&Arm; 2],
    work: &Work,
    most: usize,
    threshold: f64,
    time: Duration,
    bar: &ProgressBar,
) -> Turns {
    let start = Instant::now();
    let mut turns = Turns { reports: None, rows: Vec::new(), stopped: None, failed: None };
    let mut open = work.series.clone();
    let mut rounds = 0;
    let looks = looks(most);
    for (number, look) in looks.iter().enumerate() {
        // Time of a round as it was so far; fewer rows make it shorter.
        let share = if open.is_empty() { 1.0 } else { left(&open, &work.series) };
        let a_round = start.elapsed().as_secs_f64() / f64::from(rounds.max(1) as u32);
        let needed = share * a_round * (look.rounds - rounds) as f64;
        if rounds > 0 && start.elapsed().as_secs_f64() + needed > time.as_secs_f64() {
            turns.stopped = Some(format!(
                "{rounds} rounds took {:.0} s; those up to the next look, at {}, would go on for {needed:.0} s \
                 more (--max-time)",
                start.elapsed().as_secs_f64(),
                look.rounds
            ));
            break;
        }
        while rounds < look.rounds {
            bar.set_message(progress_line(rounds, most, look, &turns.rows));
            let arguments = work.arguments(&open);
            let b_first = rounds % 2 == 1;
            let order = if b_first { [1, 0] } else { [0, 1] };
            let mut found = [None, None];
            for side in order {
                match arms[side].bench(&arguments, work.limits) {
                    Ok(report) => found[side] = Some(report),
                    Err(error) => turns.failed = Some(error),
                }
                if is_interrupted() {
                    turns.failed = Some(Interrupted.into());
                }
                if turns.failed.is_some() {
                    break;
                }
            }
            if let [Some(a), Some(b)] = found {
                match &mut turns.reports {
                    None => turns.reports = Some([a, b]),
                    Some([all_a, all_b]) => {
                        all_a.extend(a);
                        all_b.extend(b);
                    }
                }
                rounds += 1;
            }
            if turns.failed.is_some() {
                // No look is due: the times are kept, without an interval.
                let none = Look { rounds, rank: 0, error: 0.0 };
                turns.look(&none, threshold);
                return turns;
            }
            // A scene or a size that differs would differ in all rounds.
            if rounds == 1 {
                turns.look(&Look { rounds, rank: 0, error: 0.0 }, threshold);
                if turns.failed.is_some() {
                    return turns;
                }
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
            eprintln!(
                "after {rounds} rounds, {:.0} s: {} of {} rows undecided{}",
                start.elapsed().as_secs_f64(),
                still.len(),
                turns.rows.len(),
                doubtful(&turns.rows)
            );
        });
        open.retain(|amount| still.contains(amount));
        if still.is_empty() {
            break;
        }
        if number + 1 == looks.len() {
            turns.stopped = Some(format!("{} rows undecided after {rounds} rounds", still.len()));
        }
    }
    turns
}

impl Turns {
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
                        Some(known) => *known = row,
                        None => self.rows.push(row),
                    }
                }
            }
        }
    }
}

/// Part of the work that is left.
fn left(open: &[Amount], all: &[Amount]) -> f64 {
    let sum = |series: &[Amount]| series.iter().map(|amount| amount.effort()).sum::<f64>();
    sum(open) / sum(all)
}

fn progress_line(rounds: usize, most: usize, look: &Look, rows: &[VerdictRow]) -> String {
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

/// Rounds of one arm alone, for a result that is kept.
pub fn alone(
    arm: &Arm,
    work: &Work,
    rounds: usize,
    bar: &ProgressBar,
) -> (Option<Report>, Option<anyhow::Error>) {
    let mut all: Option<Report> = None;
    for round in 0..rounds {
        bar.set_position(round as u64);
        let found = arm.bench(&work.arguments(&work.series), work.limits);
        let found = if is_interrupted() { Err(Interrupted.into()) } else { found };
        match (found, &mut all) {
            (Err(error), _) => return (all, Some(error)),
            (Ok(report), None) => all = Some(report),
            (Ok(report), Some(all)) => all.extend(report),
        }
    }
    (all, None)
}

/// The options of a command as they were given, but for its `own`, for another process of it.
pub fn passed_on(command: &clap::Command, matches: &ArgMatches, own: &[&str]) -> Vec<OsString> {
    let mut arguments = Vec::new();
    for argument in command.get_arguments() {
        let id = argument.get_id().as_str();
        let given = matches.value_source(id) == Some(clap::parser::ValueSource::CommandLine);
        if own.contains(&id) || !given {
            continue;
        }
        let values = matches.get_raw(id).into_iter().flatten();
        let joined = values.collect::<Vec<_>>().join(&OsString::from(","));
        match argument.get_long() {
            None => arguments.push(joined),
            Some(long) if argument.get_action().takes_values() => {
                // One argument, so that a value may begin with a dash.
                let mut option = OsString::from(format!("--{long}="));
                option.push(joined);
                arguments.push(option);
            }
            Some(long) => arguments.push(format!("--{long}").into()),
        }
    }
    arguments
}
