//! Machine time made to follow the wall clock.

use std::thread;
use std::time::Duration;

use crate::stopwatch::Stopwatch;

/// Between two looks at the port: some twelve bytes at 115200 baud.
const REST: Duration = Duration::from_millis(1);
/// The most wall time to catch up with at once, so that bytes that arrive meanwhile are not late.
const SLICE_S: f64 = 0.01;
/// A machine further behind than this lets the wall clock go.
const BEHIND_MAX_S: f64 = 0.1;

/// A clock for the machine, `speed` times as fast as the one on the wall.
pub struct Pace {
    stopwatch: Stopwatch,
    speed: f64,
    behind_s: f64,
}

impl Pace {
    /// Starts it at power-up.
    pub fn new(speed: f64) -> Self {
        Self { stopwatch: Stopwatch::start(), speed, behind_s: 0.0 }
    }

    /// How far the machine that stands at `now_ns` should run next, ns since power-up.
    pub fn next_ns(&mut self, now_ns: u64) -> u64 {
        let machine_s = now_ns as f64 * 1e-9;
        let lag_s = self.due_s() - machine_s / self.speed;
        if lag_s > BEHIND_MAX_S {
            self.behind_s += lag_s - SLICE_S;
        }
        let next_s = machine_s + lag_s.min(SLICE_S) * self.speed;
        now_ns.max((next_s * 1e9) as u64)
    }

    /// Waits a little if the machine that stands at `now_ns` is in time.
    #[expect(clippy::disallowed_methods, reason = "the user's own time is what the machine is paced to")]
    pub fn rest(&self, now_ns: u64) {
        if now_ns as f64 * 1e-9 / self.speed + REST.as_secs_f64() > self.due_s() {
            thread::sleep(REST);
        }
    }

    /// By how much wall time the machine was too slow, all in all, s.
    pub fn behind_s(&self) -> f64 {
        self.behind_s
    }

    /// Wall time since power-up, as far as the machine could follow it, s.
    fn due_s(&self) -> f64 {
        self.stopwatch.elapsed_s() - self.behind_s
    }
}
