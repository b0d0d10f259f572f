//! Two things measured in turn, round by round: the median of the rounds' log ratios.

use super::Interval;
use super::looks::Look;
use crate::measure::statistics::median;

/// Times of one round: A's and B's process, one right after the other.
pub type Pair = (f64, f64);

/// The ratio B / A at a look; none if there are too few rounds for an interval.
pub fn interval(pairs: &[Pair], look: &Look) -> Option<Interval> {
    of_logs(pairs.iter().map(|(a, b)| (b / a).ln()).collect(), look)
}

/// The interval of a median at a look.
fn of_logs(mut logs: Vec<f64>, look: &Look) -> Option<Interval> {
    if look.rank == 0 || logs.len() != look.rounds {
        return None;
    }
    logs.sort_by(f64::total_cmp);
    let (low, high) = (logs[look.rank - 1], logs[logs.len() - look.rank]);
    Some(Interval::of_logs(median(&logs), low, high))
}

/// How far the same statistic strays from 1 where nothing differs: consecutive rounds of A held against
/// each other, and likewise of B, at the same number of rounds. It is the farther end of their interval,
/// as a part of 1; none if there are too few rounds.
///
/// The order within a pair alternates, so consecutive rounds of one side stand once before and once after the other side:
/// an effect of the order shows here, too.
pub fn noise_floor(pairs: &[Pair]) -> Option<f64> {
    let halves = |side: fn(&Pair) -> f64| {
        pairs.chunks_exact(2).map(move |two| (side(&two[1]) / side(&two[0])).ln())
    };
    let logs: Vec<f64> = halves(|pair| pair.0).chain(halves(|pair| pair.1)).collect();
    // One look, so all 5 % are its own.
    let look = Look::single(logs.len());
    let found = of_logs(logs, &look)?;
    Some(found.high.max(1.0 / found.low) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::looks::looks;
    use super::*;

    #[test]
    fn the_interval_is_that_of_the_order_statistics() {
        // Ratios e^-9, e^-7 … e^9 in another order: the 2nd is e^-7, the 9th e^7, the middle 1.
        let logs = [3.0, -9.0, 9.0, 1.0, -1.0, 7.0, -3.0, 5.0, -5.0, -7.0f64];
        let pairs: Vec<Pair> = logs.iter().map(|log| (2.0, 2.0 * log.exp())).collect();
        let found = interval(&pairs, &looks(40)[0]).expect("ten rounds");
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
        assert!(near(found.ratio, 1.0) && near(found.low, (-7f64).exp()), "{found:?}");
        assert!(near(found.high, 7f64.exp()), "{found:?}");
        assert_eq!(interval(&pairs[..9], &looks(40)[0]), None);
    }

    #[test]
    fn the_floor_is_that_of_the_noise_not_of_the_difference() {
        // B takes twice as long; each side strays by 1 % from round to round.
        let noisy = |n: i32| if n % 2 == 0 { 1.0 } else { 1.01 };
        let pairs: Vec<Pair> = (0..20).map(|n| (noisy(n), 2.0 * noisy(n))).collect();
        let floor = noise_floor(&pairs).expect("twenty rounds");
        assert!((floor - 0.01).abs() < 1e-12, "{floor}");
    }
}
