//! The seven phases of an S-curve, computed from its limits and the durations of its ramps.

use isostep_profile::{Limits, Profile};

use super::case::Case;

/// Duration of each phase, s, and its jerk, steps/s³.
pub struct Phases(pub [(f64, f64); 7]);

/// The state of a move: place, speed and acceleration.
#[derive(Clone, Copy)]
pub struct State {
    pub t_s: f64,
    pub steps: f64,
    pub speed_steps_s: f64,
    pub accel_steps_s2: f64,
}

impl Phases {
    pub fn of(profile: &Profile, limits: &Limits) -> Self {
        let jerk = limits.jerk_steps_s3;
        let (up_s, flat_up_s) = ramp(profile.t_accel_s(), limits.accel_steps_s2 / jerk);
        let (down_s, flat_down_s) = ramp(profile.t_decel_s(), limits.decel_steps_s2 / jerk);
        Self([
            (up_s, jerk),
            (flat_up_s, 0.0),
            (up_s, -jerk),
            (profile.t_cruise_s(), 0.0),
            (down_s, -jerk),
            (flat_down_s, 0.0),
            (down_s, jerk),
        ])
    }

    /// The states where the phases end, integrated from the entry on.
    pub fn ends(&self, case: &Case) -> [State; 7] {
        let mut at = State { t_s: 0.0, steps: 0.0, speed_steps_s: case.entry_steps_s, accel_steps_s2: 0.0 };
        self.0.map(|(time_s, jerk)| {
            at = at.after(time_s, jerk);
            at
        })
    }
}

impl State {
    fn after(self, t: f64, jerk: f64) -> Self {
        let (v, a) = (self.speed_steps_s, self.accel_steps_s2);
        Self {
            t_s: self.t_s + t,
            steps: self.steps + t * (v + t * (a / 2.0 + t * jerk / 6.0)),
            speed_steps_s: v + t * (a + t * jerk / 2.0),
            accel_steps_s2: a + t * jerk,
        }
    }
}

/// Duration of each jerk of a ramp, and of the constant acceleration between them. The jerk takes `reach_s` to reach
/// the acceleration.
fn ramp(duration_s: f64, reach_s: f64) -> (f64, f64) {
    let jerk_s = reach_s.min(duration_s / 2.0);
    (jerk_s, duration_s - 2.0 * jerk_s)
}
