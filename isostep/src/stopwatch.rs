//! How long the user has waited. The only clock of the tools: nothing that is measured or simulated depends on it.
#![expect(clippy::disallowed_types, reason = "durations shown to the user are wall-clock time")]

use std::time::Instant;

/// Started when made.
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Begins now.
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// How long ago that was, s.
    pub fn elapsed_s(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}
