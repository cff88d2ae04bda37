//! Measures how long the user has waited, or is to wait. This is the tools' only clock: no measured or simulated result depends on it.
#![expect(clippy::disallowed_types, reason = "durations shown to the user are wall-clock time")]

use std::thread;
use std::time::{Duration, Instant};

/// The time between two looks at what is waited for.
const LOOK_AGAIN: Duration = Duration::from_millis(200);

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

/// The result of `look` as soon as there is one; `None` after `limit_s`.
#[expect(clippy::disallowed_methods, reason = "the user's computer takes its time to mount a drive")]
pub fn within<T>(limit_s: f64, look: impl Fn() -> Option<T>) -> Option<T> {
    let stopwatch = Stopwatch::start();
    loop {
        match look() {
            None if stopwatch.elapsed_s() < limit_s => thread::sleep(LOOK_AGAIN),
            found => return found,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::within;

    #[test]
    fn what_appears_is_waited_for_what_does_not_only_so_long() {
        let looks = std::cell::Cell::new(0);
        let third = || {
            looks.set(looks.get() + 1);
            (looks.get() == 3).then_some("drive")
        };
        assert_eq!(within(10.0, third), Some("drive"));
        assert_eq!(within(0.0, || None::<()>), None);
        assert_eq!(looks.get(), 3);
    }
}
