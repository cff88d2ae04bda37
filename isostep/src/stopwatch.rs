//! Measures how long the user has waited. This is the tools' only clock: no measured or simulated result depends on it.
#![expect(clippy::disallowed_types, reason = "durations shown to the user are wall-clock time")]

use std::time::Instant;

/// A stopwatch that runs from its creation.
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Time since the start, s.
    pub fn elapsed_s(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}
