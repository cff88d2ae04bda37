//! A leg: the motion of an axis at one acceleration.

use crate::fixed::is_zero;

/// Instants with a smaller difference are the same, s.
pub(super) const SAME_S: f64 = 1e-10;

/// The motion of an axis for a while, at one acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// The instant at which it begins, s from the start of the run.
    pub begin_s: f64,
    /// The place where it begins, steps.
    pub place_steps: f64,
    /// The speed there, steps/s, signed by direction.
    pub speed_steps_s: f64,
    /// The acceleration, steps/s², signed by direction.
    pub accel_steps_s2: f64,
}

impl Leg {
    /// Standing at a place since `begin_s`.
    #[must_use]
    pub const fn rest(begin_s: f64, place_steps: f64) -> Self {
        Self { begin_s, place_steps, speed_steps_s: 0.0, accel_steps_s2: 0.0 }
    }

    pub(super) fn is_rest(&self) -> bool {
        is_zero(self.speed_steps_s) && is_zero(self.accel_steps_s2)
    }

    /// The amount that it adds to an integral of the place from one instant to another, both of them in it.
    pub(super) fn integral(&self, from_s: f64, to_s: f64) -> f64 {
        let lasts_s = to_s - from_s;
        let (place_steps, speed_steps_s) = self.at(from_s);
        (place_steps + (0.5 * speed_steps_s + self.accel_steps_s2 * lasts_s * (1.0 / 6.0)) * lasts_s) * lasts_s
    }

    /// The place and the speed of the axis at `t_s` from the start of the run.
    #[inline(always)]
    pub(super) fn at(&self, t_s: f64) -> (f64, f64) {
        if self.is_rest() {
            return (self.place_steps, 0.0);
        }
        let past_s = t_s - self.begin_s;
        if past_s.to_bits() << 1 <= SAME_S.to_bits() << 1 {
            return (self.place_steps, self.speed_steps_s);
        }
        if is_zero(self.accel_steps_s2) {
            return (self.place_steps + self.speed_steps_s * past_s, self.speed_steps_s);
        }
        let gained_steps_s = self.accel_steps_s2 * past_s;
        (self.place_steps + (self.speed_steps_s + 0.5 * gained_steps_s) * past_s, self.speed_steps_s + gained_steps_s)
    }
}
