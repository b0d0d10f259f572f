//! How often a verdict is wrong: 10^5 simulated comparisons for each kind of noise, looks and all, by a
//! generator with a fixed seed; and rounds recorded on a busy machine, put together anew.

use crate::common::Random;
use raindrops::measure::verdict::looks::{looks, misses};
use raindrops::measure::verdict::paired::{self, Pair};
use raindrops::measure::verdict::{Verdict, judge, unpaired};
use serde_json::Value;

const COMPARISONS: usize = 100_000;

/// A standard normal value (Box and Muller 1958).
fn normal(random: &mut Random) -> f64 {
    let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.unit()).cos()
}

/// Student's t with two degrees of freedom: tails so heavy that it has no variance.
fn heavy(random: &mut Random) -> f64 {
    let uniform = random.unit().clamp(1e-12, 1.0 - 1e-12);
    (2.0 * uniform - 1.0) / (2.0 * uniform * (1.0 - uniform)).sqrt()
}

/// Noise of one comparison: log time of the n-th process.
type Noise = fn(&mut Random, &mut f64, usize) -> f64;

const NOISES: [(&str, Noise); 5] = [
    ("normal, 3 %", |random, _, _| 0.03 * normal(random)),
    ("heavy tails", |random, _, _| 0.03 * heavy(random)),
    ("half of the processes a third slower", |random, _, _| {
        0.01 * normal(random) + if random.unit() < 0.5 { 0.3 } else { 0.0 }
    }),
    ("a drift of 1 % a process", |random, _, number| 0.03 * normal(random) + 0.01 * number as f64),
    ("a walk of 2 % a process", |random, at, _| {
        *at += 0.02 * normal(random);
        *at + 0.01 * normal(random)
    }),
];

/// Pairs of a comparison with B slower by `ratio`, as they come when the order alternates.
fn pairs(random: &mut Random, noise: Noise, rounds: usize, ratio: f64) -> Vec<Pair> {
    let mut state = 0.0;
    let mut time = |number| noise(random, &mut state, number).exp();
    (0..rounds)
        .map(|round| {
            let (first, second) = (time(2 * round), time(2 * round + 1));
            let (a, b) = if round % 2 == 1 { (second, first) } else { (first, second) };
            (a, ratio * b)
        })
        .collect()
}

/// The verdict of a comparison that ends at the first look that decides, and whether any look's interval
/// missed the true ratio.
fn compare(pairs: &[Pair], ratio: f64) -> (Verdict, bool) {
    let (mut decided, mut missed) = (Verdict::Undecided, false);
    for look in looks(pairs.len()) {
        let found = paired::interval(&pairs[..look.rounds], &look).expect("rounds enough");
        missed |= !(found.low..=found.high).contains(&ratio);
        if decided == Verdict::Undecided {
            decided = judge(Some(found), 0.05);
        }
    }
    (decided, missed)
}

/// Parts of the comparisons that raise a false alarm, and in which an interval misses.
fn rates(noise: Noise, ratio: f64, comparisons: usize) -> (f64, f64, f64) {
    let mut random = Random(2026);
    let (mut slower, mut faster, mut missed) = (0, 0, 0);
    for _ in 0..comparisons {
        let (verdict, misses) = compare(&pairs(&mut random, noise, 40, ratio), ratio);
        slower += usize::from(verdict == Verdict::Slower);
        faster += usize::from(verdict == Verdict::Faster);
        missed += usize::from(misses);
    }
    let part = |count: usize| count as f64 / comparisons as f64;
    (part(slower), part(faster), part(missed))
}

/// Where the differences are independent, three looks together miss in at most the 4.99 % that the
/// binomial tails come to, and in no less than the greatest of them.
#[test]
fn intervals_miss_as_often_as_the_tails_say() {
    let tails: Vec<f64> = looks(40).iter().map(|look| look.error).collect();
    let (sum, most) = (tails.iter().sum::<f64>(), tails.iter().fold(0.0f64, |a, b| a.max(*b)));
    assert!(sum <= 0.05, "the looks' tails come to {sum}");
    // Three standard deviations of a share of 5 % in 10^5.
    let slack = 3.0 * (0.05 * 0.95 / COMPARISONS as f64).sqrt();
    for (name, noise) in &NOISES[..3] {
        let (slower, faster, missed) = rates(*noise, 1.0, COMPARISONS);
        println!("{name}: missed {missed:.4}, slower {slower:.5}, faster {faster:.5}");
        assert!(missed <= sum + slack, "{name}: {missed}");
        assert!(
            missed >= most - slack,
            "{name}: {missed}, the looks do not see what was simulated"
        );
        assert!(slower + faster <= sum + slack, "{name}: false alarms {}", slower + faster);
        assert!((slower - faster).abs() <= 0.005, "{name}: {slower}, {faster}");
    }
}

/// The exact chance of one look, from all 2^10 ways in which ten differences can lie.
#[test]
fn one_look_misses_as_often_as_coins_say() {
    let outside = (0..1u32 << 10).filter(|ways| {
        // The 2nd smallest is over the median if fewer than two lie under it.
        let under = ways.count_ones();
        !(2..=8).contains(&under)
    });
    assert_eq!(outside.count() as f64 / 1024.0, misses(10, 2));
}

/// A drift is the same in every second pair with the other sign: alternation turns it into noise.
#[test]
fn a_drifting_machine_raises_no_more_alarms() {
    for (name, noise) in &NOISES[3..] {
        let (slower, faster, missed) = rates(*noise, 1.0, COMPARISONS / 10);
        println!("{name}: missed {missed:.4}, slower {slower:.5}, faster {faster:.5}");
        assert!(missed <= 0.06, "{name}: {missed}");
        assert!(slower + faster <= 0.01, "{name}: {slower}, {faster}");
    }
}

/// 20 % slower is found where rounds differ by 3 %, and never taken for faster.
#[test]
fn a_real_slowdown_is_found() {
    for (name, noise) in [NOISES[0], NOISES[1], NOISES[4]] {
        let (slower, faster, _) = rates(noise, 1.2, COMPARISONS / 10);
        println!("{name}: slower {slower:.4}, faster {faster:.5}");
        assert!(slower > 0.99 && faster == 0.0, "{name}: {slower}, {faster}");
    }
}

/// Rounds as they were recorded, `tests/data/rounds.json`: stretches of ten processes in their order, from any
/// place on, put together to comparisons. Stretches keep what one process has in common with the next. Long series
/// are taken one at a time, of short ones another for each stretch.
fn recorded(random: &mut Random, series: &[Vec<f64>], ratio: f64) -> Vec<Pair> {
    let is_short = series.iter().any(|series| series.len() < 40);
    let any = |random: &mut Random| &series[random.bits() as usize % series.len()];
    let mut times = Vec::new();
    let one = any(random);
    while times.len() < 80 {
        let series = if is_short { any(random) } else { one };
        let from = random.bits() as usize % series.len();
        times.extend((0..10).map(|n| series[(from + n) % series.len()]));
    }
    let pair = |(round, two): (usize, &[f64])| match round % 2 {
        0 => (two[0], ratio * two[1]),
        _ => (two[1], ratio * two[0]),
    };
    times.chunks_exact(2).enumerate().map(pair).collect()
}

/// Numbers of a JSON list.
fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
}

/// Parts of 10^5 comparisons of recorded rounds that are slower, faster, and in which an interval misses.
fn resampled(series: &[Vec<f64>], ratio: f64) -> [f64; 3] {
    let mut random = Random(11);
    let mut found = [0; 3];
    for _ in 0..COMPARISONS {
        let (verdict, missed) = compare(&recorded(&mut random, series, ratio), ratio);
        found[0] += usize::from(verdict == Verdict::Slower);
        found[1] += usize::from(verdict == Verdict::Faster);
        found[2] += usize::from(missed);
    }
    let [slower, faster, missed] = found.map(|count| count as f64 / COMPARISONS as f64);
    println!("recorded, {ratio}: slower {slower:.5}, faster {faster:.5}, missed {missed:.4}");
    [slower, faster, missed]
}

/// On a quiet machine's noise: no more than one alarm in two hundred where nothing differs, and 20 % found.
#[test]
fn recorded_rounds_raise_no_more_alarms() {
    let file: Value = serde_json::from_str(include_str!("../data/rounds.json")).expect("JSON");
    let series: Vec<Vec<f64>> =
        file["series"].as_array().expect("series").iter().map(numbers).collect();
    assert!(series.iter().all(|series| series.len() == 40) && series.len() == 4);
    for (ratio, least, most) in [(1.0, 0.0, 0.005), (1.1, 0.4, 1.0), (1.2, 0.99, 1.0)] {
        let [slower, faster, missed] = resampled(&series, ratio);
        assert!((least..=most).contains(&slower) && faster <= 0.005, "{slower} {faster}");
        assert!(missed <= 0.06, "{missed}");
    }
}

/// On that of a machine with three times as much work as cores, as `scripts/verdict-trials.sh` recorded it: under
/// two alarms in a hundred, and no slowdown is taken for the contrary.
#[test]
fn a_busy_machine_raises_few_alarms() {
    let text = include_str!("../../docs/results/2026-11-verdict-trials.json");
    let file: Value = serde_json::from_str(text).expect("JSON");
    let trials = file["trials"].as_array().expect("trials");
    let alike = trials.iter().filter(|trial| trial["true_ratio"] == 1.0);
    let in_order = |trial: &Value| {
        let sides = [numbers(&trial["rounds_ms_a"]), numbers(&trial["rounds_ms_b"])];
        // A first in the first round, then B.
        let round = |n: usize| [sides[n % 2][n], sides[1 - n % 2][n]];
        (0..sides[0].len()).flat_map(round).collect()
    };
    let series: Vec<Vec<f64>> = alike.map(in_order).collect();
    assert!(series.len() >= 20 && series.iter().all(|series| series.len() >= 20));
    let [slower, faster, missed] = resampled(&series, 1.0);
    assert!(slower + faster <= 0.02 && missed <= 0.08, "{slower} {faster} {missed}");
    let [_, faster, _] = resampled(&series, 1.2);
    assert!(faster <= 0.001, "{faster}");
}

/// Kept results: the machine of the second day is 5 % slower or faster than that of the first, by chance,
/// and rounds of a day differ by 3 %. One run a side must not cry "slower" in more than 5 %.
#[test]
fn another_day_is_no_slowdown() {
    let mut random = Random(7);
    let mut alarms = 0;
    let comparisons = COMPARISONS / 10;
    for _ in 0..comparisons {
        let mut run = || -> Vec<f64> {
            let day = 0.03 * normal(&mut random);
            (0..10).map(|_| (day + 0.03 * normal(&mut random)).exp()).collect()
        };
        let found = unpaired::interval(&[run()], &[run()]);
        let verdict = judge(found, 0.05);
        alarms += usize::from(matches!(verdict, Verdict::Slower | Verdict::Faster));
    }
    let part = alarms as f64 / comparisons as f64;
    println!("false alarms {part:.4}");
    assert!(part <= 0.05, "{part}");
}
