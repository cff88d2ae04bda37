//! Prints a line for each case: what runs, its result, and how long the user waited.

use isostep::screen::grouped;

use super::chip::Chip;
use super::port::Port;
use isostep::stopwatch::Stopwatch;

/// A case that is running. Its line is printed in one piece at its end, because cases of several chips run at once.
pub struct Case {
    line: String,
    stopwatch: Stopwatch,
}

impl Case {
    pub fn begin(chip: Chip, port: Port, axes: usize, rate_steps_s: u32, what: &str) -> Self {
        Self::named(chip, port, &format!("{axes} x {:>9} steps/s, {what}", grouped(rate_steps_s.into())))
    }

    /// A case without a rate.
    pub fn named(chip: Chip, port: Port, what: &str) -> Self {
        let line = format!("    {}: {:<9} {what}", chip.name(), port.name());
        Self { line, stopwatch: Stopwatch::start() }
    }

    pub fn end(self, outcome: &str) {
        eprintln!("{}: {outcome} ({:.1} s)", self.line, self.stopwatch.elapsed_s());
    }
}
