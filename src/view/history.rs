//! What the last frames took.

use std::collections::VecDeque;
use std::time::Duration;

/// Frames that are remembered.
const FRAMES: usize = 160;

/// Wall-clock milliseconds of the last frames, oldest first.
#[derive(Clone, Debug, Default)]
pub struct History {
    frames_ms: VecDeque<f32>,
}

impl History {
    /// Adds a frame.
    pub fn push(&mut self, frame: Duration) {
        if self.frames_ms.len() == FRAMES {
            self.frames_ms.pop_front();
        }
        self.frames_ms.push_back(1e3 * frame.as_secs_f32());
    }

    /// Milliseconds, oldest first.
    pub fn frames_ms(&self) -> impl DoubleEndedIterator<Item = f32> + ExactSizeIterator + '_ {
        self.frames_ms.iter().copied()
    }

    /// Median milliseconds of the last second, so that the figure can be read.
    pub fn median_ms(&self) -> Option<f32> {
        let mut sum = 0.0;
        let recent = self.frames_ms.iter().rev().take_while(|ms| {
            sum += **ms;
            sum < 1e3
        });
        let mut recent: Vec<f32> = recent.copied().collect();
        recent.sort_by(f32::total_cmp);
        recent.get(recent.len() / 2).copied().or_else(|| self.frames_ms.back().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_is_that_of_the_last_second() {
        let mut history = History::default();
        assert_eq!(history.median_ms(), None);
        (0..100).for_each(|_| history.push(Duration::from_millis(500)));
        (0..30).for_each(|_| history.push(Duration::from_millis(100)));
        assert_eq!(history.median_ms(), Some(100.0));
        (0..1000).for_each(|_| history.push(Duration::from_millis(10)));
        assert_eq!(history.frames_ms().len(), FRAMES);
    }
}
