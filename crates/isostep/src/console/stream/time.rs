//! How long a program has taken, and how long it still takes, without the time in which the machine waits for somebody.

use std::time::Duration;

use indicatif::HumanDuration;

use crate::stopwatch::Stopwatch;

/// The time that counts.
pub struct StreamTime {
    gone_s: f64,
    looked: Stopwatch,
}

impl StreamTime {
    /// No time has gone.
    pub fn start() -> Self {
        Self { gone_s: 0.0, looked: Stopwatch::start() }
    }

    /// Counts the time since the last look, unless the machine waits.
    pub fn look(&mut self, waits: bool) {
        let since_s = std::mem::replace(&mut self.looked, Stopwatch::start()).elapsed_s();
        self.count(since_s, waits);
    }

    fn count(&mut self, since_s: f64, waits: bool) {
        self.gone_s += if waits { 0.0 } else { since_s };
    }

    /// In words, after this many of the lines.
    pub fn words(&self, answered: u64, total: usize) -> String {
        let left_s = self.gone_s * (total as f64 - answered as f64).max(0.0) / answered.max(1) as f64;
        let words = |s: f64| HumanDuration(Duration::from_secs_f64(s.round()));
        format!("{} gone, {} left", words(self.gone_s), words(left_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_in_which_the_machine_waits_does_not_count() {
        let mut time = StreamTime::start();
        for (since_s, waits) in [(15.0, false), (600.0, true), (5.0, false)] {
            time.count(since_s, waits);
        }
        assert_eq!(time.words(2, 8), "20 seconds gone, 60 seconds left");
        assert_eq!(StreamTime::start().words(0, 8), "0 seconds gone, 0 seconds left");
    }
}
