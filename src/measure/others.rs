//! What other programs take of a machine's processors while something is measured.

/// Part of all processors' time from which the others' work makes times doubtful.
const DOUBTFUL: f64 = 0.1;

/// The system's counts of processor time since its start, in ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ticks {
    /// Time of all processors, idle ones too.
    all: u64,
    /// Time in which processors worked, or that a virtual machine was not given.
    busy: u64,
    /// Time of this process and of those that it started and waited for.
    own: u64,
}

impl Ticks {
    /// By `/proc/stat` and `/proc/self/stat`.
    fn read(machine: &str, process: &str) -> Option<Self> {
        let line = machine.lines().next()?.strip_prefix("cpu ")?;
        // User, nice, system, idle, waiting, two kinds of interrupts, stolen; guests' time is in the first two.
        let states = line.split_whitespace().take(8).map(|word| word.parse::<u64>().ok());
        let states = states.collect::<Option<Vec<_>>>().filter(|states| states.len() == 8)?;
        // The name of the program is in brackets, and may have some itself.
        let (_, fields) = process.rsplit_once(')')?;
        let own = fields.split_whitespace().skip(11).take(4).map(|word| word.parse::<u64>().ok());
        let all: u64 = states.iter().sum();
        Some(Self { all, busy: all - states[3] - states[4], own: own.sum::<Option<u64>>()? })
    }

    /// On Linux alone: other systems do not count what a process' children took, which would then be others'.
    fn now() -> Option<Self> {
        if !cfg!(target_os = "linux") {
            return None;
        }
        let file = |path| std::fs::read_to_string(path).ok();
        Self::read(&file("/proc/stat")?, &file("/proc/self/stat")?)
    }

    /// Part of all processors' time since `start` that was neither this process's nor idle.
    fn others_since(self, start: Self) -> Option<f64> {
        let of = |part: fn(Self) -> u64| part(self).saturating_sub(part(start));
        let (all, busy, own) = (of(|t| t.all), of(|t| t.busy), of(|t| t.own));
        (all > 0).then(|| busy.saturating_sub(own) as f64 / all as f64)
    }
}

/// The time from which others' work is counted.
#[derive(Clone, Copy, Debug)]
pub struct Watch(Option<Ticks>);

impl Watch {
    /// From now on.
    pub fn start() -> Self {
        Self(Ticks::now())
    }

    /// What other programs took until now of all processors' time, 0 to 1; none where the system does not tell.
    pub fn others(self) -> Option<f64> {
        Ticks::now()?.others_since(self.0?)
    }
}

/// What such a part makes doubtful, in a line; none if it is small.
pub(super) fn doubt(others: f64) -> Option<String> {
    (others > DOUBTFUL).then(|| {
        format!(
            "other programs took {:.0} % of the processors' time meanwhile; times may be too long",
            100.0 * others
        )
    })
}

#[cfg(test)]
mod tests {
    use super::{Ticks, doubt};

    #[test]
    fn what_is_neither_idle_nor_own_is_of_others() {
        // 600 ticks, of which 200 were idle, 100 waited, and 150 were this process's or its children's.
        let machine =
            |user, idle, waiting| format!("cpu  {user} 7 11 {idle} {waiting} 1 2 3 0 0\n");
        let process =
            |user, child| format!("12 (a) b (c) S 1 2 3 4 5 6 7 8 9 10 {user} 20 {child} 5");
        let start = Ticks::read(&machine(1000, 5000, 30), &process(100, 40)).expect("counts");
        let end = Ticks::read(&machine(1300, 5200, 130), &process(210, 80)).expect("counts");
        assert_eq!(start, Ticks { all: 6054, busy: 1024, own: 165 });
        assert_eq!(end.others_since(start), Some(0.25));
        assert_eq!(start.others_since(start), None);
        assert!(doubt(0.25).is_some_and(|line| line.contains("took 25 %")));
        assert_eq!(doubt(0.1), None);
    }

    #[test]
    fn what_a_system_does_not_tell_is_none() {
        let process = "1 (a) S 1 2 3 4 5 6 7 8 9 10 1 1 1 1";
        for machine in ["", "cpu  1 2 3", "cpu  1 2 3 4 5 6 7 x", "intr 1 2 3 4 5 6 7 8"] {
            assert_eq!(Ticks::read(machine, process), None, "{machine}");
        }
        assert_eq!(Ticks::read("cpu  1 2 3 4 5 6 7 8", "a S 1"), None);
    }
}
