//! How long the user has waited. The only clock in xtask: nothing that is measured or simulated depends on it.
#![expect(clippy::disallowed_types, reason = "durations shown to the user are wall-clock time")]

use std::time::Instant;

/// Started when made.
pub struct Stopwatch(Instant);

impl Stopwatch {
    pub fn start() -> Self {
        Self(Instant::now())
    }

    pub fn elapsed_s(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}
