//! A bend whose acceleration changes evenly: the instants of its steps are roots of a cubic.

use super::u96::fixed;
use super::{BRIEF_S, FIT_ERROR_MAX_S, FIT_ERROR_MAX_TICKS};

/// How often a root is drawn nearer at most. Newton's method doubles the digits each time; where it would leave the bracket,
/// the bracket is halved instead.
const TRIES_MAX: u32 = 60;
/// How far a quadratic is from a bend 3/16 of the way from one of its outer steps, or from the other, of the farthest: 0.99 where the
/// instants are a cubic over the steps, and no less than this where the third derivative vanishes, and the fourth is left.
const FARTHEST: f64 = 0.952;
/// A root is exact to this, s.
const EXACT_S: f64 = 1e-11;

/// An axis that moves from the slow or the fast end of a bend in one direction, and does not turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic {
    /// Its beginning, all along its direction: speed, acceleration and jerk.
    pub(super) speed_steps_s: f64,
    pub(super) accel_steps_s2: f64,
    pub(super) jerk_steps_s3: f64,
    pub(super) lasts_s: f64,
    /// The distance beyond a whole step at which it begins, in its direction.
    pub(super) ahead: f64,
    /// Ticks per second.
    pub(super) tick_hz: f64,
    /// Times are in units of 2^-`point` tick.
    pub(super) point: u8,
}

impl Cubic {
    /// The distance that it has gone `t_s` after its beginning, steps, and its speed then.
    fn at(&self, t_s: f64) -> (f64, f64) {
        let Self { speed_steps_s, accel_steps_s2, jerk_steps_s3, .. } = *self;
        let gained = (accel_steps_s2 + 0.5 * jerk_steps_s3 * t_s) * t_s;
        let steps = (speed_steps_s + (0.5 * accel_steps_s2 + jerk_steps_s3 * t_s * (1.0 / 6.0)) * t_s) * t_s;
        (steps, speed_steps_s + gained)
    }

    /// The distance that it goes to the edge that comes after so many half steps, steps.
    fn steps_to(&self, half_steps: u32) -> f64 {
        0.5 * f64::from(half_steps) - self.ahead
    }

    /// The instant of that edge, units of 2^-`point` tick after its beginning.
    #[inline(never)]
    pub(super) fn time(&self, half_steps: u32) -> u64 {
        fixed(self.time_s(self.steps_to(half_steps)) * self.tick_hz, self.point.into()) as u64
    }

    /// The instant at which it has gone so far, s after its beginning.
    fn time_s(&self, steps: f64) -> f64 {
        let (mut from_s, mut to_s) = (0.0, self.lasts_s);
        let mut t_s = 0.5 * to_s;
        for _ in 0..TRIES_MAX {
            let (at, speed_steps_s) = self.at(t_s);
            let beyond = at - steps;
            if beyond > 0.0 {
                to_s = t_s;
            } else {
                from_s = t_s;
            }
            let next_s = if speed_steps_s > 0.0 { t_s - beyond / speed_steps_s } else { from_s - 1.0 };
            let next_s = if next_s > from_s && next_s < to_s { next_s } else { 0.5 * (from_s + to_s) };
            let change_s = (next_s - t_s).abs();
            t_s = next_s;
            if change_s < EXACT_S {
                break;
            }
        }
        t_s
    }

    /// True if an instant, in units of 2^-`point` tick after the beginning, is near enough to that of the edge after so many half
    /// steps, in a segment that lasts `rise` of these units.
    #[inline(never)]
    pub(super) fn is_near(&self, half_steps: u32, instant: u64, rise: u64) -> bool {
        let unit_s =
            1.0 / (self.tick_hz * f64::from(1_u32 << (self.point / 2)) * f64::from(1_u32 << self.point.div_ceil(2)));
        let near_s = if rise as f64 * unit_s < BRIEF_S { FIT_ERROR_MAX_S } else { 0.0 };
        let near_s = near_s.max(FIT_ERROR_MAX_TICKS / self.tick_hz);
        let (at, speed_steps_s) = self.at(instant as f64 * unit_s);
        (at - self.steps_to(half_steps)).abs() <= FARTHEST * near_s * speed_steps_s
    }
}
