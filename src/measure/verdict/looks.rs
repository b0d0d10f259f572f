//! When to look at a comparison that is under way, and how narrow an interval each look may give.
//!
//! Whoever looks after every round and stops as soon as he likes what he sees is wrong far more often
//! than in 5 % of cases. So the looks are fixed beforehand, at 10, 20, 40, 80 … rounds, and the 5 % are
//! shared among them: the chances of the looks' intervals to miss the median add up to 5 % at most, and
//! however one stops among them, an interval is wrong in no more.
//!
//! A look's interval reaches from the k-th smallest to the k-th largest of n independent differences.
//! It misses their median with a chance of 2 P(X < k), X binomial of n tosses of a coin, whatever the
//! differences' distribution, if it is continuous. Each look in turn takes the largest k that the rest of
//! the 5 % affords:
//!
//! | rounds | interval from the | misses |
//! |---|---|---|
//! | 10 | 2nd to the 9th | 2.15 % |
//! | 20 | 5th to the 16th | 1.18 % |
//! | 40 | 13th to the 28th | 1.66 % |
//! | together | | 4.99 % |
//!
//! A comparison that ends between two looks, because its time is over or a process fails, has one more look at
//! the rounds that it has, by what is left of the 5 %: when that happens does not depend on which side is ahead.

use super::ERROR;

/// Rounds at the first look; each later one has twice as many as the one before.
const FIRST: usize = 10;

/// A look at a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Rounds, pairs of processes, that it waits for.
    pub rounds: usize,
    /// Its interval reaches from the `rank`-th smallest to the `rank`-th largest difference; 0: there
    /// are too few for any.
    pub rank: usize,
    /// The chance that the interval misses.
    pub error: f64,
}

impl Look {
    /// The narrowest interval of so many rounds that misses with a chance of `error` at most.
    fn within(rounds: usize, error: f64) -> Self {
        let rank = (1..=rounds / 2).take_while(|rank| misses(rounds, *rank) <= error).last();
        Self {
            rounds,
            rank: rank.unwrap_or(0),
            error: rank.map_or(0.0, |rank| misses(rounds, rank)),
        }
    }

    /// The only look at so many rounds, which has all of the 5 %.
    pub fn single(rounds: usize) -> Self {
        Self::within(rounds, ERROR)
    }
}

/// The looks of a comparison of so many rounds at most. With fewer than six no interval is to be had.
pub fn looks(most: usize) -> Vec<Look> {
    let doublings = std::iter::successors(Some(FIRST), |rounds| Some(rounds * 2));
    let mut rounds: Vec<usize> = doublings.take_while(|rounds| *rounds < most).collect();
    rounds.push(most);
    let mut left = ERROR;
    let look = |rounds| {
        let look = Look::within(rounds, left);
        left -= look.error;
        look
    };
    rounds.into_iter().map(look).collect()
}

/// The look of a comparison that ends after so many rounds, other than planned, when `taken` had been taken.
pub fn at_the_end(taken: &[Look], rounds: usize) -> Look {
    Look::within(rounds, ERROR - taken.iter().map(|look| look.error).sum::<f64>())
}

/// The chance that the median of a continuous distribution lies outside of the `rank`-th smallest to the
/// `rank`-th largest of `rounds` independent values: 2 P(X < rank), X binomial(rounds, 1/2).
pub fn misses(rounds: usize, rank: usize) -> f64 {
    // Terms C(n, i) / 2^n, each from the one before; 2^-n is in range up to a thousand rounds.
    let mut term = 0.5f64.powi(rounds as i32);
    let mut sum = 0.0;
    for i in 0..rank {
        sum += term;
        term *= (rounds - i) as f64 / (i + 1) as f64;
    }
    2.0 * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_looks_share_five_percent() {
        let found = looks(40);
        let ranks: Vec<_> = found.iter().map(|look| (look.rounds, look.rank)).collect();
        assert_eq!(ranks, [(10, 2), (20, 5), (40, 13)]);
        // 2 (1 + 10) / 1024, from the definition.
        assert!((found[0].error - 22.0 / 1024.0).abs() < 1e-15);
        for most in 1..=200 {
            let total: f64 = looks(most).iter().map(|look| look.error).sum();
            assert!(total <= 0.05, "{most}: {total}");
        }
    }

    /// However early it ends, all looks together have no more than the 5 %.
    #[test]
    fn a_look_at_the_end_takes_what_is_left() {
        let planned = looks(40);
        for taken in 0..3usize {
            let from = taken.checked_sub(1).map_or(0, |last| planned[last].rounds);
            for rounds in from + 1..planned[taken].rounds {
                let last = at_the_end(&planned[..taken], rounds);
                let before: f64 = planned[..taken].iter().map(|look| look.error).sum();
                assert!(before + last.error <= 0.05, "{taken} {rounds}");
                // More rounds than the last look's give an interval, too.
                assert_eq!(last.rank > 0, rounds >= 6, "{taken} {rounds}");
            }
        }
        assert_eq!(at_the_end(&[], 9), Look::single(9));
    }

    #[test]
    fn too_few_rounds_have_no_interval() {
        assert_eq!(looks(5)[0].rank, 0);
        assert_eq!(looks(6), [Look { rounds: 6, rank: 1, error: 2.0 / 64.0 }]);
    }
}
