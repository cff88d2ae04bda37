//! A line for each case: what runs, what came of it, and how long the user waited.

use isostep::screen::grouped;

use super::chip::Chip;
use crate::variant::Port;
use isostep::stopwatch::Stopwatch;

/// A case under way. Its line is told at its end and in one piece, as cases of several chips are under way at once.
pub struct Case {
    line: String,
    stopwatch: Stopwatch,
}

impl Case {
    pub fn begin(chip: Chip, port: Port, axes: usize, rate_steps_s: u32, what: &str) -> Self {
        Self::named(chip, port, &format!("{axes} x {:>9} steps/s, {what}", grouped(rate_steps_s.into())))
    }

    /// One that has no rate.
    pub fn named(chip: Chip, port: Port, what: &str) -> Self {
        let line = format!("    {}: {:<9} {what}", chip.name(), port.name());
        Self { line, stopwatch: Stopwatch::start() }
    }

    pub fn end(self, outcome: &str) {
        eprintln!("{}: {outcome} ({:.1} s)", self.line, self.stopwatch.elapsed_s());
    }
}
