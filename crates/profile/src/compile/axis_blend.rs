//! One axis in a corner, or in a bend of shaped motion.

use super::NEAREST_STEPS;
use crate::fixed::is_negative;
use crate::ramp::constant_accel_time_s;
use crate::shaper::turns;

/// An axis of a blend: it approaches at constant speed, slows down to its slow end, then speeds up from there. An axis
/// that does not turn does one of both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisBlend {
    pub(crate) slow_steps_s: f64,
    /// The size of its acceleration.
    pub(crate) accel_steps_s2: f64,
    /// The instants at which it begins to speed up, and has slowed down, s from the start of the run. If it does not turn, these
    /// are the ends of the corner.
    pub(crate) begin_s: f64,
    pub(crate) end_s: f64,
    pub(crate) is_turned: bool,
    /// As in a [`StepRange`](super::StepRange).
    pub(crate) ahead: f64,
    pub(crate) beyond: f64,
    /// The size of its speed in the approach.
    pub(crate) from_steps_s: f64,
    /// The number of steps that it makes in the approach, while slowing down, and while speeding up.
    pub(crate) approach: u32,
    pub(crate) out: u32,
    pub(crate) back: u32,
}

impl AxisBlend {
    /// An axis with these speeds and places where the corner begins and ends, signed by direction, and the size of its
    /// acceleration. `counts` are the whole steps where it begins, has approached, turns and ends; `ends_s` is when the
    /// corner begins and ends.
    pub(crate) fn new(
        [from_steps_s, to_steps_s]: [f64; 2],
        [from, to]: [f64; 2],
        accel_steps_s2: f64,
        [begin, approached, turn, end]: [i32; 4],
        [begin_s, end_s]: [f64; 2],
    ) -> Self {
        let (approach, out, back) = (approached.abs_diff(begin), turn.abs_diff(approached), end.abs_diff(turn));
        let (is_back, goes_back) = (is_negative(from_steps_s), is_negative(to_steps_s));
        let [fast_from, fast_to] = [from_steps_s.abs(), to_steps_s.abs()];
        let along = |is_back: bool, steps: f64| if is_back { -steps } else { steps };
        let plain = Self { accel_steps_s2, begin_s, out, back, ..Self::even(from_steps_s, approach, end_s) };
        if turns(from_steps_s, to_steps_s) {
            let turn_s = begin_s + fast_from / accel_steps_s2;
            let peak = along(is_back, from) + from_steps_s * from_steps_s / (2.0 * accel_steps_s2);
            let beyond = peak - along(is_back, f64::from(turn));
            return Self { begin_s: turn_s, end_s: turn_s, is_turned: true, ahead: -beyond, beyond, ..plain };
        }
        // Sizes compare as their bits do.
        if fast_from.to_bits() > fast_to.to_bits() {
            let beyond = along(is_back, to - f64::from(end));
            Self { slow_steps_s: fast_to, beyond, ..plain }
        } else {
            let ahead = along(goes_back, from - f64::from(approached));
            Self { slow_steps_s: fast_from, ahead, out: 0, back: out + back, ..plain }
        }
    }

    /// The time from the slow end to a place so many steps from it, s. As on a line, no step is nearer than [`NEAREST_STEPS`] to
    /// where the axis stands.
    pub(crate) fn time_s(&self, steps: f64) -> f64 {
        let lead_steps = self.slow_steps_s * self.slow_steps_s / (2.0 * self.accel_steps_s2);
        constant_accel_time_s(steps.max(NEAREST_STEPS - lead_steps).max(0.0), self.slow_steps_s, self.accel_steps_s2)
    }

    /// An axis that only approaches, by so many steps, up to `end_s`.
    pub(crate) fn even(from_steps_s: f64, approach: u32, end_s: f64) -> Self {
        Self {
            slow_steps_s: 0.0,
            accel_steps_s2: 0.0,
            begin_s: end_s,
            end_s,
            is_turned: false,
            ahead: 0.0,
            beyond: 0.0,
            from_steps_s: from_steps_s.abs(),
            approach,
            out: 0,
            back: 0,
        }
    }
}
