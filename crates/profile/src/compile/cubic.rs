//! A phase whose acceleration changes evenly: the instants of its steps are roots of a cubic. All of it is slow.

use super::fit::Quadratic;
use super::fixed_phase::{FixedPhase, Formula};
use super::fixed_ramp::Sample;
use super::timed_plan::TimedStepRange;
use super::u96::fixed;
use super::{BRIEF_S, FIT_ERROR_MAX_S, FIT_ERROR_MAX_TICKS};
use crate::phase::CountedPhase;

/// log2 of the steps of the longest segment.
const LENGTH_MAX: u8 = 8;

/// The most times that a root is drawn nearer. Newton's method doubles the digits each time; where it would leave the bracket,
/// the bracket is halved instead.
const TRIES_MAX: u32 = 60;
/// The distance of a quadratic from a cubic 3/16 of the way from one of its outer steps, or from the other, as a fraction of the
/// largest: 0.99 where the instants are a cubic over the steps, and no less than this where the third derivative vanishes, and the
/// fourth is left.
const FARTHEST: f64 = 0.952;
/// A root is exact to this, s.
const EXACT_S: f64 = 1e-11;

/// An axis that moves from the slow or the fast end of a phase in one direction, and does not turn.
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
    #[cold]
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
    #[cold]
    pub(super) fn is_near(&self, half_steps: u32, instant: u64, rise: u64) -> bool {
        let unit_s =
            1.0 / (self.tick_hz * f64::from(1_u32 << (self.point / 2)) * f64::from(1_u32 << self.point.div_ceil(2)));
        let near_s = if rise as f64 * unit_s < BRIEF_S { FIT_ERROR_MAX_S } else { 0.0 };
        let near_s = near_s.max(FIT_ERROR_MAX_TICKS / self.tick_hz);
        let (at, speed_steps_s) = self.at(instant as f64 * unit_s);
        (at - self.steps_to(half_steps)).abs() <= FARTHEST * near_s * speed_steps_s
    }
}

impl FixedPhase {
    /// Makes it the steps of a phase whose acceleration changes.
    #[cold]
    pub(super) fn change_accel(&mut self, counted: &CountedPhase, timed: TimedStepRange) {
        let [begin, .., end] = counted.counts;
        let along = |x: f64| if end < begin { -x } else { x };
        let (clock, point, steps) = (timed.clock, timed.point(), timed.step_range.steps);
        let cubic = Cubic {
            speed_steps_s: along(counted.phase.speed_steps_s),
            accel_steps_s2: along(counted.phase.accel_steps_s2),
            jerk_steps_s3: along(counted.jerk_steps_s3),
            lasts_s: counted.end_s - counted.phase.begin_s,
            ahead: along(counted.phase.place_steps - f64::from(begin)),
            tick_hz: clock.tick_hz,
            point,
        };
        let (formula, origin) = (Formula::Cubic(cubic), fixed(clock.begin_ticks, point.into()) as u64);
        *self = Self { formula, origin, end: steps, reach: steps - 1, backwards: false, point, length: LENGTH_MAX };
    }

    /// Shortens a segment of a cubic until its quadratic is as near as it has to be. `far` is the step at its end;
    /// returns that of the shorter one.
    #[cold]
    pub(super) fn shorten(&self, step: u32, cubic: &Cubic, fit: &mut Quadratic, mut far: Sample) -> Sample {
        while fit.length > 0 {
            let middle = self.sample_after(step, fit.length - 1);
            let half_rise = middle.instant.wrapping_sub(fit.first);
            fit.curvature = fit.rise.wrapping_sub(half_rise).wrapping_sub(half_rise) as i64;
            // A quadratic through three steps is exact there. In between it is farthest from a cubic at 0.21 and 0.79 of the way,
            // and from a fourth power at 0.15 and 0.85. A half step is the finest that is tried.
            let sixteenths = if fit.length == 2 { 4 } else { 3 };
            let is_near = |sixteenths: u32| {
                let (before, left) = (u64::from(sixteenths), i64::from(sixteenths * (16 - sixteenths)));
                let instant = fit.first + fit.rise / 16 * before;
                let instant = instant.wrapping_add_signed(-fit.curvature / 128 * left).wrapping_sub(self.origin);
                let half_steps = step * 2 + 1 + ((sixteenths << fit.length) >> 3);
                cubic.is_near(half_steps, instant, fit.rise)
            };
            if fit.length == 1 || is_near(sixteenths) && is_near(16 - sixteenths) {
                return far;
            }
            (far, fit.rise, fit.curvature) = (middle, half_rise, 0);
            fit.length -= 1;
        }
        far
    }
}
