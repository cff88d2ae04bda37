//! Makes machine time follow the wall clock.

use std::thread;
use std::time::Duration;

use crate::stopwatch::Stopwatch;

/// Time between two looks at the port: some twelve bytes at 115200 baud.
const REST: Duration = Duration::from_millis(1);
/// The most wall time that is caught up with in one go, so that bytes that arrive meanwhile are not late.
const SLICE_S: f64 = 0.01;
/// A machine that is further behind than this no longer tries to catch up.
const BEHIND_MAX_S: f64 = 0.1;

/// A clock for the machine, `speed` times as fast as the wall clock.
pub struct Pace {
    stopwatch: Stopwatch,
    speed: f64,
    behind_s: f64,
}

impl Pace {
    /// Starts the clock at the machine's power-up.
    pub fn new(speed: f64) -> Self {
        Self { stopwatch: Stopwatch::start(), speed, behind_s: 0.0 }
    }

    /// The machine time to run to next, for a machine at `now_ns`; both ns since power-up.
    pub fn next_ns(&mut self, now_ns: u64) -> u64 {
        let machine_s = now_ns as f64 * 1e-9;
        let lag_s = self.due_s() - machine_s / self.speed;
        if lag_s > BEHIND_MAX_S {
            self.behind_s += lag_s - SLICE_S;
        }
        let next_s = machine_s + lag_s.min(SLICE_S) * self.speed;
        now_ns.max((next_s * 1e9) as u64)
    }

    /// Waits a little if a machine at `now_ns` is not late.
    #[expect(clippy::disallowed_methods, reason = "the user's own time is what the machine is paced to")]
    pub fn rest(&self, now_ns: u64) {
        if now_ns as f64 * 1e-9 / self.speed + REST.as_secs_f64() > self.due_s() {
            thread::sleep(REST);
        }
    }

    /// The total wall time by which the machine was too slow, s.
    pub fn behind_s(&self) -> f64 {
        self.behind_s
    }

    /// Wall time since power-up, without the time by which the machine was too slow, s.
    fn due_s(&self) -> f64 {
        self.stopwatch.elapsed_s() - self.behind_s
    }
}
