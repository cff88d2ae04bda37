//! A line for each case: what runs, what came of it, and how long the user waited.

use super::chip::Chip;
use crate::stopwatch::Stopwatch;
use crate::variant::Port;

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

/// A whole number with its thousands apart.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let first = (digits.len() + 2) % 3 + 1;
    let (head, tail) = digits.split_at(first.min(digits.len()));
    let groups = tail.as_bytes().chunks(3).map(|group| format!(",{}", String::from_utf8_lossy(group)));
    head.to_owned() + &groups.collect::<String>()
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn thousands_are_set_apart() {
        for (number, text) in [(0, "0"), (999, "999"), (1_000, "1,000"), (30_000, "30,000"), (1_200_000, "1,200,000")] {
            assert_eq!(grouped(number), text);
        }
    }
}
