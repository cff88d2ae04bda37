//! A phase: what an axis does for a while at one acceleration, or at one jerk.
//!
//! A line of constant acceleration is three phases of each axis, a blend two, and the motion of a shaped axis is a row of them.
//! Those of a blend and of a shaped axis are compiled as they are; the axes of a line share more than a phase has
//! ([`TimedPlan`](crate::TimedPlan)).

use libm::floor;

use crate::compile::NEAREST_STEPS;
use crate::fixed::{is_negative, is_zero};
use crate::ramp::constant_accel_time_s;

/// Instants with a smaller difference are the same, s.
pub(crate) const SAME_S: f64 = 1e-10;

/// The motion of an axis for a while, at one acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisPhase {
    /// The instant at which it begins, s from the start of the run.
    pub begin_s: f64,
    /// The place where it begins, steps.
    pub place_steps: f64,
    /// The speed there, steps/s, signed by direction.
    pub speed_steps_s: f64,
    /// The acceleration, steps/s², signed by direction.
    pub accel_steps_s2: f64,
}

impl AxisPhase {
    /// Standing at a place since `begin_s`.
    #[must_use]
    pub const fn rest(begin_s: f64, place_steps: f64) -> Self {
        Self { begin_s, place_steps, speed_steps_s: 0.0, accel_steps_s2: 0.0 }
    }

    pub(crate) fn is_rest(&self) -> bool {
        is_zero(self.speed_steps_s) && is_zero(self.accel_steps_s2)
    }

    /// The amount that it adds to an integral of the place from one instant to another, both of them in it.
    pub(crate) fn integral(&self, from_s: f64, to_s: f64) -> f64 {
        let lasts_s = to_s - from_s;
        let (place_steps, speed_steps_s) = self.at(from_s);
        (place_steps + (0.5 * speed_steps_s + self.accel_steps_s2 * lasts_s * (1.0 / 6.0)) * lasts_s) * lasts_s
    }

    /// The place and the speed of the axis at `t_s` from the start of the run.
    #[inline(always)]
    pub(crate) fn at(&self, t_s: f64) -> (f64, f64) {
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

/// A phase with its end and the steps that the axis makes in it: what an axis compiler compiles. At constant acceleration the axis
/// may turn; at constant jerk it does not.
///
/// A step is due where the axis is half a step from a whole one. An axis that turns makes the steps up to there, and then those of
/// its way back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CountedPhase {
    /// Its beginning; its place is counted from the same whole step as `counts`.
    pub phase: AxisPhase,
    /// The instant at which it ends, s from the start of the run.
    pub end_s: f64,
    /// The place where the axis is then, steps.
    pub end_place_steps: f64,
    /// Its speed then, steps/s, signed by direction.
    pub end_speed_steps_s: f64,
    /// The jerk, steps/s³.
    pub jerk_steps_s3: f64,
    /// The whole step where the axis begins, where it turns, and where it ends. If it does not turn, the second is the third.
    pub counts: [i32; 3],
}

impl CountedPhase {
    /// The number of steps that the axis makes, and how many of them before it turns; if it does not turn, that is all of them.
    #[must_use]
    pub fn step_counts(&self) -> (u32, u32) {
        let [begin, turn, end] = self.counts;
        let out = turn.abs_diff(begin);
        (out + end.abs_diff(turn), out)
    }

    /// The number of steps that the axis makes in the direction of the first.
    #[must_use]
    pub fn turns_after(&self) -> u32 {
        let (steps, out) = self.step_counts();
        if out > 0 { out } else { steps }
    }

    /// The direction of the first step, 1 or -1; 0 if there is none.
    #[must_use]
    pub fn direction(&self) -> i32 {
        let [begin, turn, end] = self.counts;
        if turn == begin { (end - turn).signum() } else { (turn - begin).signum() }
    }

    /// The instant of the `k`-th step, counted from 1, s from the start of the run, by the closed form at constant acceleration.
    pub(crate) fn step_time_s(&self, k: u32) -> f64 {
        let (steps, before) = (f64::from(self.step_counts().0), f64::from(k) - 0.5);
        if is_zero(self.phase.accel_steps_s2) {
            return self.end_s - (steps - before + self.beyond_end()) / self.phase.speed_steps_s.abs();
        }
        let slow = self.slow_end();
        let out = f64::from(slow.out);
        if before < out {
            slow.slows_until_s - slow.time_s(out - before + slow.beyond)
        } else {
            slow.speeds_from_s + slow.time_s(before - out - slow.ahead)
        }
    }

    /// The distance of the axis beyond its last step in its direction where the phase ends, steps; it does not turn.
    pub(crate) fn beyond_end(&self) -> f64 {
        along(is_negative(self.phase.speed_steps_s), self.end_place_steps - f64::from(self.counts[2]))
    }

    /// The slow end of a phase whose acceleration is not 0.
    pub(crate) fn slow_end(&self) -> SlowEnd {
        let Self { phase, end_s, end_place_steps, end_speed_steps_s: to_steps_s, counts: [begin, turn, end], .. } =
            *self;
        let AxisPhase { begin_s, place_steps, speed_steps_s: from_steps_s, accel_steps_s2 } = phase;
        let accel_steps_s2 = accel_steps_s2.abs();
        let (out, back) = (turn.abs_diff(begin), end.abs_diff(turn));
        let [fast_from, fast_to] = [from_steps_s.abs(), to_steps_s.abs()];
        let (ahead, beyond, slows_until_s, speeds_from_s) = (0.0, 0.0, end_s, begin_s);
        let plain =
            SlowEnd { speed_steps_s: 0.0, accel_steps_s2, slows_until_s, speeds_from_s, ahead, beyond, out, back };
        if turns(from_steps_s, to_steps_s) {
            let turn_s = begin_s + fast_from / accel_steps_s2;
            let is_back = is_negative(from_steps_s);
            let peak = along(is_back, place_steps) + from_steps_s * from_steps_s / (2.0 * accel_steps_s2);
            let beyond = peak - along(is_back, f64::from(turn));
            return SlowEnd { slows_until_s: turn_s, speeds_from_s: turn_s, ahead: -beyond, beyond, ..plain };
        }
        // Sizes compare as their bits do.
        if fast_from.to_bits() > fast_to.to_bits() {
            let beyond = along(is_negative(from_steps_s), end_place_steps - f64::from(end));
            SlowEnd { speed_steps_s: fast_to, beyond, ..plain }
        } else {
            let ahead = along(is_negative(to_steps_s), place_steps - f64::from(begin));
            SlowEnd { speed_steps_s: fast_from, ahead, out: 0, back: out + back, ..plain }
        }
    }
}

/// The slow end of a phase: the axis slows down to it, speeds up from it, or does both, if it turns there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlowEnd {
    /// The size of its speed there, and of its acceleration.
    pub(crate) speed_steps_s: f64,
    pub(crate) accel_steps_s2: f64,
    /// The instants up to which it slows down, and from which it speeds up, s from the start of the run.
    pub(crate) slows_until_s: f64,
    pub(crate) speeds_from_s: f64,
    /// As in a [`StepRange`](crate::compile::StepRange).
    pub(crate) ahead: f64,
    pub(crate) beyond: f64,
    /// The number of steps while it slows down, and while it speeds up.
    pub(crate) out: u32,
    pub(crate) back: u32,
}

impl SlowEnd {
    /// The time from the slow end to a place so many steps from it, s. As on a line, no step is nearer than [`NEAREST_STEPS`] to
    /// where the axis stands.
    fn time_s(&self, steps: f64) -> f64 {
        let lead_steps = self.speed_steps_s * self.speed_steps_s / (2.0 * self.accel_steps_s2);
        constant_accel_time_s(steps.max(NEAREST_STEPS - lead_steps).max(0.0), self.speed_steps_s, self.accel_steps_s2)
    }
}

fn along(is_back: bool, steps: f64) -> f64 {
    if is_back { -steps } else { steps }
}

/// True if an axis that begins and ends with these speeds turns on the way.
pub(crate) fn turns(from_steps_s: f64, to_steps_s: f64) -> bool {
    is_negative(from_steps_s) != is_negative(to_steps_s) && !is_zero(from_steps_s) && !is_zero(to_steps_s)
}

/// The step nearest to the place where an axis turns whose two edges there, out and back, are no nearer to each other than
/// two steps at its top speed. `counts` are the whole steps where it begins and ends.
pub(crate) fn turn(place_steps: f64, from_steps_s: f64, accel: f64, counts: [i32; 2], top_steps_s: f64) -> i32 {
    let (accel, is_back) = (accel.abs(), from_steps_s < 0.0);
    let along = |count: i32| if is_back { -count } else { count };
    let apart_steps = accel / (8.0 * top_steps_s * top_steps_s);
    let peak = if is_back { -place_steps } else { place_steps } + from_steps_s * from_steps_s / (2.0 * accel);
    along((floor(peak - apart_steps + 0.5) as i32).max(along(counts[0])).max(along(counts[1])))
}
