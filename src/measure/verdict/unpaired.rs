//! Results of different times held against each other, where nothing ran in turn.
//!
//! All rounds of one run share its time: what else the machine did, how warm it was. So a run counts as
//! one sample, the median of its rounds' logarithms, however many rounds it has, and the interval is
//! Student's for the difference of two means of runs:
//!
//! ```text
//! d ± t(f, 97.5 %) · s · √(1/k + 1/l),   s² = (4 w² + Σ(mᵢ - m̄)²) / f,   f = 4 + (k - 1) + (l - 1)
//! ```
//!
//! with k runs of A and l of B, their medians mᵢ and each side's mean m̄ of them. The spread s between
//! runs at different times is not known from one run a side. Until there are more it is taken to be that
//! of single rounds within a run, w, as if known from five runs (the 4 w² and the 4 in f); further runs
//! correct it, up or down. On an idle machine with rounds 1 % apart a run a side tells 4 % from nothing;
//! where rounds are 5 % apart it takes 20 %. Kept results are weaker than turns, and say so.

use statrs::distribution::{ContinuousCDF as _, StudentsT};

use super::{ERROR, Interval};
use crate::measure::statistics::median;

/// Degrees of freedom that the spread within runs stands for.
const PRIOR: f64 = 4.0;
/// Rounds of both sides together, in runs of two at least, below which the spread within them is not known.
const LEAST_ROUNDS: usize = 6;
/// Standard deviation over median absolute deviation, of normal values.
const SIGMA_OVER_MAD: f64 = 1.4826;

/// The ratio B / A from the times of each run's rounds; none if there are too few rounds.
pub fn interval(a: &[Vec<f64>], b: &[Vec<f64>]) -> Option<Interval> {
    let (a, b) = (logs(a), logs(b));
    let (of_a, of_b) = (medians(&a), medians(&b));
    let within = spread_within(a.iter().chain(&b))?;
    let (mean_a, mean_b) = (mean(&of_a)?, mean(&of_b)?);
    let squares = |medians: &[f64], mean: f64| -> f64 {
        medians.iter().map(|median| (median - mean).powi(2)).sum()
    };
    let (k, l) = (of_a.len() as f64, of_b.len() as f64);
    let freedom = PRIOR + (k - 1.0) + (l - 1.0);
    let between = squares(&of_a, mean_a) + squares(&of_b, mean_b);
    let s = ((PRIOR * within * within + between) / freedom).sqrt();
    let t = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(1.0 - ERROR / 2.0);
    let (middle, half) = (mean_b - mean_a, t * s * (1.0 / k + 1.0 / l).sqrt());
    Some(Interval::of_logs(middle, middle - half, middle + half))
}

/// The interval of two runs that are alike, one a side, as a part of 1: what a difference must exceed to be
/// told from nothing.
pub fn noise_floor(a: &[Vec<f64>], b: &[Vec<f64>]) -> Option<f64> {
    let found = interval(a, b)?;
    Some((found.high / found.low).sqrt() - 1.0)
}

fn logs(runs: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let log = |run: &Vec<f64>| run.iter().map(|ms| ms.ln()).collect();
    runs.iter().filter(|run| !run.is_empty()).map(log).collect()
}

fn medians(runs: &[Vec<f64>]) -> Vec<f64> {
    runs.iter().map(|run| median(run)).collect()
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Standard deviation of single rounds about their run's median, by the median of absolute deviations,
/// which a few rounds beside another job do not move. A run of n has lost one of its n to the median.
fn spread_within<'a>(runs: impl Iterator<Item = &'a Vec<f64>>) -> Option<f64> {
    let mut deviations = Vec::new();
    for run in runs.filter(|run| run.len() > 1) {
        let middle = median(run);
        let lost = (run.len() as f64 / (run.len() as f64 - 1.0)).sqrt();
        deviations.extend(run.iter().map(|log| lost * (log - middle).abs()));
    }
    (deviations.len() >= LEAST_ROUNDS).then(|| SIGMA_OVER_MAD * median(&deviations))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worked by hand: medians ln 100 and ln 110, deviations of 0.01 within, t(4, 97.5 %) = 2.7764.
    #[test]
    fn one_run_a_side() {
        let run = |ms: f64| vec![ms * (-0.01f64).exp(), ms, ms * 0.01f64.exp()];
        let found = interval(&[run(100.0)], &[run(110.0)]).expect("six rounds");
        let within = 1.4826 * (1.5f64).sqrt() * 0.01;
        let half = 2.776_445 * within * 2f64.sqrt();
        assert!((found.ratio - 1.1).abs() < 1e-12, "{found:?}");
        assert!((found.high / (1.1 * half.exp()) - 1.0).abs() < 1e-6, "{found:?}");
        assert!((found.low / (1.1 * (-half).exp()) - 1.0).abs() < 1e-6, "{found:?}");
        let floor = noise_floor(&[run(100.0)], &[run(110.0)]).expect("six rounds");
        assert!((floor / (half.exp() - 1.0) - 1.0).abs() < 1e-6, "{floor}");
    }

    /// Runs that are farther apart than their rounds widen the interval; runs that agree narrow it.
    #[test]
    fn further_runs_correct_the_spread() {
        let run = |ms: f64| vec![0.99 * ms, ms, 1.01 * ms];
        let width = |base: &[f64]| {
            let base: Vec<_> = base.iter().map(|ms| run(*ms)).collect();
            let found = interval(&base, &[run(100.0)]).expect("rounds");
            (found.high / found.low).ln()
        };
        let one = width(&[100.0]);
        assert!(width(&[100.0; 6]) < 0.7 * one);
        assert!(width(&[80.0, 125.0, 90.0, 110.0, 100.0, 100.0]) > 3.0 * one);
    }

    #[test]
    fn single_rounds_tell_nothing() {
        assert_eq!(interval(&[vec![1.0]], &[vec![2.0]]), None);
        assert_eq!(interval(&[], &[vec![2.0; 8]]), None);
    }
}
