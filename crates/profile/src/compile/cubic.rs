//! A phase whose acceleration changes evenly: the instants of its steps are roots of a cubic. All of it is slow.

use super::fit::Quadratic;
use super::fixed_phase::{FixedPhase, Formula};
use super::fixed_ramp::{ONE, Sample, log2_of};
use super::timed_plan::TimedStepRange;
use super::u96::{fixed, short_fixed};
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
/// A segment's steps last about as long as each other if the last one differs from the first by less than this ratio. What is left of
/// the fourth derivative then is a fifth of the deviation that is allowed.
const EVEN: f32 = 0.125;
/// log2 of the seconds to which a root is exact: less than 10^-11.
const LOG2_EXACT_S: i32 = -37 * ONE;
/// log2 of 72 √3, of 12 and of 6, in units of 2^-16.
const LOG2_72_ROOT_3: i32 = 456_288;
const LOG2_12: i32 = 234_944;
const LOG2_6: i32 = 169_408;

/// An axis that moves from the slow or the fast end of a phase in one direction, and does not turn.
///
/// # Lengths
/// At the speed v, the acceleration a and the jerk j the third derivative of the instants over the steps is (3 a² - j v)/v⁵. A
/// quadratic over n steps deviates by that times n³/(72 √3) at most. (3 a² + |j| v)/v⁵ is the largest at one of a segment's ends. Where
/// the axis is the slowest between them, it would be larger only if the ends were nearly twice as fast, and no segment within the bound
/// is so long. Where this bound is too coarse, the quadratic is compared with the cubic.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic {
    /// Its speed at its beginning, half its acceleration there, and a sixth of its jerk, along its direction.
    speed_steps_s: f64,
    half_accel_steps_s2: f64,
    sixth_jerk_steps_s3: f64,
    lasts_s: f64,
    /// The distance beyond a whole step at which it begins, in its direction.
    ahead: f64,
    /// The units of time in a second.
    unit_hz: f64,
    /// The last place that was sought: the next one is not far from it.
    near: Near,
    /// The distance by which a segment may deviate, and that by which a brief one may, s.
    fit_s: [f32; 2],
}

/// A place on a cubic, about.
#[derive(Clone, Copy, Debug)]
struct Near {
    time_s: f32,
    steps: f32,
    speed_steps_s: f32,
    half_accel_steps_s2: f32,
}

impl Near {
    /// The time at which it is so far, about, s: by Halley's method, without the jerk. `None` where it nearly stands still.
    fn time_at(&self, steps: f64) -> Option<f64> {
        if self.speed_steps_s < 1.0 {
            return None;
        }
        let newton_s = (steps as f32 - self.steps) / self.speed_steps_s;
        let bend = 1.0 + self.half_accel_steps_s2 * newton_s / self.speed_steps_s;
        (bend > 0.0).then(|| f64::from(self.time_s + newton_s / bend))
    }
}

/// log2 of the cube of the steps of a segment that deviates by `fit_s`, s, where the third derivative is 1 s.
fn cubed(fit_s: f32) -> i32 {
    log2_of(fit_s.into()) + LOG2_72_ROOT_3
}

impl Cubic {
    /// The distance that it has gone `t_s` after its beginning, steps, its speed then, and half its acceleration.
    fn at(&self, t_s: f64) -> [f64; 3] {
        let by_jerk = self.sixth_jerk_steps_s3 * t_s;
        let by_accel = by_jerk + self.half_accel_steps_s2;
        let place_steps = (by_accel * t_s + self.speed_steps_s) * t_s;
        let half_accel_steps_s2 = by_accel + by_jerk + by_jerk;
        [place_steps, (by_accel + half_accel_steps_s2 - by_jerk) * t_s + self.speed_steps_s, half_accel_steps_s2]
    }

    /// The distance that it goes to the edge that comes after so many half steps, steps.
    fn steps_to(&self, half_steps: u32) -> f64 {
        0.5 * f64::from(half_steps) - self.ahead
    }

    /// That edge. Its level is log2 of a bound of the third derivative there.
    #[cold]
    pub(super) fn sample(&mut self, half_steps: u32) -> Sample {
        let steps = self.steps_to(half_steps);
        let (mut from_s, mut to_s) = (0.0, self.lasts_s);
        let is_within = |t_s: f64, from_s: f64, to_s: f64| t_s > from_s && t_s < to_s;
        let guess_s = self.near.time_at(steps).filter(|guess_s| is_within(*guess_s, from_s, to_s));
        let mut t_s = guess_s.unwrap_or(0.5 * to_s);
        let [mut speed_steps_s, mut half_accel_steps_s2, mut change_s] = [0.0; 3];
        for _ in 0..TRIES_MAX {
            let at_steps;
            [at_steps, speed_steps_s, half_accel_steps_s2] = self.at(t_s);
            let beyond = at_steps - steps;
            if beyond > 0.0 {
                to_s = t_s;
            } else {
                from_s = t_s;
            }
            change_s = if speed_steps_s > 0.0 { beyond / speed_steps_s } else { to_s };
            let is_newtons = is_within(t_s - change_s, from_s, to_s);
            t_s = if is_newtons { t_s - change_s } else { 0.5 * (from_s + to_s) };
            let change = log2_of((if is_newtons { change_s } else { to_s - from_s }).abs());
            // What is left after a change by Newton's method is less than its square times a/v, and its cube times j/v.
            let accel = log2_of(half_accel_steps_s2.abs()).max(change + log2_of(self.sixth_jerk_steps_s3.abs())) + ONE;
            let left = if is_newtons { 2 * change + accel - log2_of(speed_steps_s) } else { change };
            if left.min(change) < LOG2_EXACT_S {
                break;
            }
        }
        let half_accel = half_accel_steps_s2 as f32;
        let speed = speed_steps_s as f32 - 2.0 * half_accel * change_s as f32;
        self.near =
            Near { time_s: t_s as f32, steps: steps as f32, speed_steps_s: speed, half_accel_steps_s2: half_accel };
        let level = self.level(speed_steps_s, half_accel_steps_s2);
        Sample {
            instant: short_fixed(t_s * self.unit_hz, 0),
            level,
            period_s: if speed > 0.0 { 1.0 / speed } else { 0.0 },
        }
    }

    /// log2 of 3 a² + |j| v over v⁵, at least.
    fn level(&self, speed_steps_s: f64, half_accel_steps_s2: f64) -> i32 {
        let speed = log2_of(speed_steps_s.max(0.0));
        let by_accel = 2 * log2_of(half_accel_steps_s2.abs()) + LOG2_12;
        let by_jerk = log2_of(self.sixth_jerk_steps_s3.abs()) + LOG2_6 + speed;
        // Both are a little too small, and together twice the larger one at most.
        by_accel.max(by_jerk) + ONE + ONE / 4 - 5 * speed
    }

    /// log2 of the steps of a segment that may be near enough, by the level at its beginning.
    #[cold]
    pub(super) fn length(&self, level: i32) -> u8 {
        ((cubed(self.fit_s[1]) - level) / (3 * ONE)).clamp(1, LENGTH_MAX.into()) as u8
    }

    /// True if a quadratic is near enough by its length and by the levels at its ends.
    fn is_bounded(&self, [begin, end]: [Sample; 2], fit: &Quadratic) -> bool {
        begin.level.max(end.level) + 3 * ONE * fit.length as i32 <= cubed(self.fit_s(fit.rise))
    }

    /// The time to the step in the middle between two steps: where the speed hardly changes, the instants are a cubic over the steps,
    /// with these periods at its ends. `None` elsewhere.
    fn half_rise(&self, [begin, end]: [Sample; 2], fit: &Quadratic) -> Option<u64> {
        let shorter_s = begin.period_s - end.period_s;
        (shorter_s.abs() < EVEN * end.period_s).then(|| {
            let later_s = f64::from(shorter_s.abs() * (1_u32 << fit.length) as f32 * 0.125);
            let later = short_fixed(later_s * self.unit_hz, 0);
            let half = fit.rise / 2;
            if shorter_s < 0.0 { half.wrapping_sub(later) } else { half.wrapping_add(later) }
        })
    }

    /// The distance by which a segment that lasts so long may deviate, s.
    fn fit_s(&self, rise: u64) -> f32 {
        self.fit_s[usize::from((rise as f64) < BRIEF_S * self.unit_hz)]
    }

    /// True if an instant, in units of time after the beginning, is near enough to that of the edge after so many half steps, in a
    /// segment that lasts `rise` of these units.
    #[cold]
    fn is_near(&self, half_steps: u32, instant: u64, rise: u64) -> bool {
        let [at_steps, speed_steps_s, _] = self.at(instant as f64 / self.unit_hz);
        (at_steps - self.steps_to(half_steps)).abs() <= FARTHEST * f64::from(self.fit_s(rise)) * speed_steps_s
    }
}

impl FixedPhase {
    /// Makes it the steps of a phase whose acceleration changes.
    #[cold]
    pub(super) fn change_accel(&mut self, counted: &CountedPhase, timed: TimedStepRange) {
        let [begin, .., end] = counted.counts;
        let along = |x: f64| if end < begin { -x } else { x };
        let (clock, point, steps) = (timed.clock, timed.point(), timed.step_range.steps);
        let unit_hz = clock.tick_hz * (1_u64 << point) as f64;
        let speed_steps_s = along(counted.phase.speed_steps_s);
        let half_accel_steps_s2 = 0.5 * along(counted.phase.accel_steps_s2);
        let sixth_jerk_steps_s3 = along(counted.jerk_steps_s3) * (1.0 / 6.0);
        let fit_s = FIT_ERROR_MAX_TICKS / clock.tick_hz;
        let cubic = Cubic {
            speed_steps_s,
            half_accel_steps_s2,
            sixth_jerk_steps_s3,
            lasts_s: counted.end_s - counted.phase.begin_s,
            ahead: along(counted.phase.place_steps - f64::from(begin)),
            unit_hz,
            near: Near {
                time_s: 0.0,
                steps: 0.0,
                speed_steps_s: speed_steps_s as f32,
                half_accel_steps_s2: half_accel_steps_s2 as f32,
            },
            fit_s: [fit_s as f32, fit_s.max(FIT_ERROR_MAX_S) as f32],
        };
        let (formula, origin) = (Formula::Cubic(cubic), fixed(clock.begin_ticks, point.into()) as u64);
        *self = Self { formula, origin, end: steps, reach: steps - 1, backwards: false, point, length: LENGTH_MAX };
    }

    /// Shortens a segment of a cubic until its quadratic is as near as it has to be. `far` is the step at its end;
    /// returns that of the shorter one.
    #[cold]
    pub(super) fn shorten(&mut self, step: u32, first: Sample, fit: &mut Quadratic, mut far: Sample) -> Sample {
        while let Formula::Cubic(cubic) = &self.formula
            && fit.length > 0
        {
            let is_bounded = cubic.is_bounded([first, far], fit);
            if let Some(half_rise) = cubic.half_rise([first, far], fit).filter(|_| is_bounded) {
                fit.bend(half_rise);
                return far;
            }
            let middle = self.sample_after(step, fit.length - 1);
            let half_rise = middle.instant.wrapping_sub(fit.first);
            fit.bend(half_rise);
            if fit.length == 1 || is_bounded || self.is_near(step, fit) {
                return far;
            }
            (far, fit.rise, fit.curvature) = (middle, half_rise, 0);
            fit.length -= 1;
        }
        far
    }

    /// True if the quadratic through three steps of a cubic is as near as it has to be.
    #[cold]
    fn is_near(&self, step: u32, fit: &Quadratic) -> bool {
        let Formula::Cubic(cubic) = &self.formula else { return true };
        // It is exact at the three. In between it is farthest from a cubic at 0.21 and 0.79 of the way, and from a fourth power at
        // 0.15 and 0.85. A half step is the finest that is tried.
        let sixteenths = if fit.length == 2 { 4 } else { 3 };
        [sixteenths, 16 - sixteenths].into_iter().all(|sixteenths: u32| {
            let (before, left) = (u64::from(sixteenths), i64::from(sixteenths * (16 - sixteenths)));
            let instant = fit.first + fit.rise / 16 * before;
            let instant = instant.wrapping_add_signed(-fit.curvature / 128 * left).wrapping_sub(self.origin);
            let half_steps = step * 2 + 1 + ((sixteenths << fit.length) >> 3);
            cubic.is_near(half_steps, instant, fit.rise)
        })
    }
}
