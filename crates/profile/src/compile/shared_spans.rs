//! A ramp whose acceleration changes, as spans of polynomials.
//!
//! A segment does not need the inverse of a speed profile. A span reaches from one state of the ramp to another. Each state has a
//! time, a displacement, a speed, an acceleration and a jerk in closed form. Over the span, the time is the polynomial
//! in the displacement that has all of these at both ends. The state midway shows how far the polynomial deviates. From
//! this follows how long the span should be if it deviates too far, and how long the next one should be. A span also
//! ends at each of the ramp's corners, where the jerk jumps. So a state is as near to the speed profile as floats are, and no
//! error accumulates.
//!
//! The spans belong to the plan and are the same for each of its axes. The axis that needs a span first computes it and
//! leaves it in [`SharedSpans`]. An axis that does not find it there any more computes it again, from the one before.

use super::hermite::{ERROR_MAX_TICKS, Hermite};
use super::timed_plan::TimedPlan;
use crate::newton::rough_root;
use crate::ramp::{Ramp, RampState};

/// A span aims at this fraction of the longest possible one, because one that deviates too far costs as much as one
/// that does not.
const SAFE_RATIO: f64 = 0.9;
/// A span is tried with at least this ratio of the one tried before.
const RATIO_MIN: f64 = 0.1;
/// A span is tried with at most this ratio of the one tried before.
const RATIO_MAX: f64 = 4.0;
/// Longest span, ticks: half of what a segment may last.
const SPAN_MAX_TICKS: f64 = 1_073_741_824.0;
/// The change that rounding may make in a time that a speed profile computes in floats, as a fraction of it: 2^-48.
const ROUNDING: f64 = 3.552_713_678_800_501e-15;
/// The fraction of the ramp that the first span tries at most.
const FIRST_RATIO: f64 = 1.0 / 16.0;
/// The fraction of the range over which the speed would double that the first span tries at most. It is the limit near
/// standstill.
const DOUBLING_RATIO: f64 = 0.18;
/// Spans begin and end a little nearer to standstill than the first and last step: at this fraction of the
/// displacement.
const BEFORE_STEP: f64 = 0.98;
/// The shortest span that is divided further, as a fraction of the ramp. The deviation of a shorter one is only
/// rounding.
const REACH_RATIO_MIN: f64 = 1e-12;

/// The number of spans that are kept for other axes. Near standstill a slow axis has no step over several spans.
const SHARED: usize = 8;

/// The spans of a plan that were computed last.
#[derive(Clone, Debug)]
pub(super) struct SharedSpans {
    spans: [Span; SHARED],
    /// The number of those that have been computed.
    count: usize,
}

/// A polynomial, and where it ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub(super) hermite: Hermite,
    pub(super) end: Reached,
    /// Its number on its ramp, and which ramp that is.
    pub(super) number: u32,
    pub(super) is_backwards: bool,
}

/// The place up to which the spans have come on a ramp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    /// The parameter of the path and the state of the ramp at that place.
    pub(super) parameter: f64,
    pub(super) state: RampState,
    /// The place that the next span tries to reach, in units of the parameter.
    reach: f64,
    /// The parameter where the last span of the ramp ends.
    pub(super) last: f64,
}

/// A ramp from its slow to its fast end, or backwards. Its parameter is that of the speed profile, time or displacement, counted
/// from where the path begins. Its states are the ramp's, counted from the slow end, so that nothing cancels near
/// standstill.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path<'a> {
    ramp: &'a Ramp,
    is_backwards: bool,
    tick_hz: f64,
}

impl SharedSpans {
    pub(super) const NONE: Self = Self { spans: [Span::NONE; SHARED], count: 0 };

    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    pub(super) fn find(&self, is_backwards: bool, number: u32) -> Option<&Span> {
        let known = &self.spans[..self.count.min(SHARED)];
        known.iter().find(|span| span.number == number && span.is_backwards == is_backwards)
    }

    pub(super) fn keep(&mut self, span: Span) {
        self.spans[self.count % SHARED] = span;
        self.count += 1;
    }
}

impl Span {
    pub(super) const NONE: Self = Self { hermite: Hermite::NONE, end: Reached::NONE, number: 0, is_backwards: false };
}

impl Reached {
    const NONE: Self = Self {
        parameter: 0.0,
        state: RampState { t_s: 0.0, steps: 0.0, speed_steps_s: 0.0, accel_steps_s2: 0.0 },
        reach: 0.0,
        last: 0.0,
    };
}

/// The ratio by which the length of a span should change if it deviates by `error_ratio` of what is allowed. A
/// polynomial over twice the length deviates 2^8 times as much.
fn better_ratio(error_ratio: f64) -> f64 {
    let ratio = SAFE_RATIO / rough_root(error_ratio, 8);
    // `clamp` is not used, because its panic would print floats, for which the chip has no room.
    if ratio < RATIO_MIN { RATIO_MIN } else { ratio.min(RATIO_MAX) }
}

impl TimedPlan {
    pub(super) fn path(&self, is_backwards: bool) -> Path<'_> {
        let ramp = if is_backwards { &self.profile.decel } else { &self.profile.accel };
        Path { ramp, is_backwards, tick_hz: self.clock.tick_hz }
    }
}

impl Path<'_> {
    /// The place where the first span begins.
    pub(super) fn begin(&self, plan: &TimedPlan) -> Reached {
        let end = self.ramp.parameter_end();
        let (first, last) = if self.is_backwards {
            (0.0, end - self.ramp.parameter_before(plan.end_steps * BEFORE_STEP))
        } else {
            (self.ramp.parameter_before(plan.begin_steps * BEFORE_STEP), end)
        };
        let state = self.state(first);
        let reach = ((last - first) * FIRST_RATIO).min(self.ramp.doubling(&state) * DOUBLING_RATIO);
        Reached { parameter: first, state, reach, last }
    }

    /// Goes on to the end of the next span, which is as long as a polynomial allows.
    pub(super) fn next(&self, reached: &mut Reached) -> Hermite {
        let Reached { parameter, state: begin, last, .. } = *reached;
        let mut to = (parameter + reached.reach).min(self.ramp.next_corner(parameter)).min(last);
        let mut is_cut = to < parameter + reached.reach;
        let mut end = self.state(to);
        loop {
            let reach = to - parameter;
            let half = parameter + reach / 2.0;
            let middle = self.state(half);
            let jerk = |state| (state, self.jerk(state, half));
            let hermite = Hermite::between(jerk(&begin), jerk(&end));
            let error_ratio = self.error_ratio(&hermite, [&begin, &middle, &end]);
            let better = reach * better_ratio(error_ratio);
            if error_ratio <= 1.0 || reach <= REACH_RATIO_MIN * last {
                // If a corner cut it short, the length tried before is better.
                let reach = if better > reached.reach || !is_cut { better } else { reached.reach };
                *reached = Reached { parameter: to, state: end, reach, last };
                return hermite;
            }
            (reached.reach, to, is_cut) = (better, parameter + better, false);
            end = self.state(to);
        }
    }

    /// The deviation of the polynomial, as a fraction of what is allowed; infinite if the span lasts too long.
    fn error_ratio(&self, hermite: &Hermite, [begin, middle, end]: [&RampState; 3]) -> f64 {
        let error_ticks = hermite.error_s(middle) * self.tick_hz;
        // In a very long move, 64-bit floats cannot resolve smaller deviations.
        let allowed_ticks = ERROR_MAX_TICKS.max(middle.t_s * self.tick_hz * ROUNDING);
        let ticks = (end.t_s - begin.t_s).abs() * self.tick_hz;
        if ticks > SPAN_MAX_TICKS { f64::INFINITY } else { error_ticks / allowed_ticks }
    }

    fn state(&self, parameter: f64) -> RampState {
        let from_slow_end = if self.is_backwards { self.ramp.parameter_end() - parameter } else { parameter };
        self.ramp.at_parameter(from_slow_end)
    }

    /// The ramp's jerk in `state`. If that is a corner, it is the jerk on the side of `parameter`.
    fn jerk(&self, state: &RampState, parameter: f64) -> f64 {
        let from_slow_end = if self.is_backwards { self.ramp.parameter_end() - parameter } else { parameter };
        self.ramp.jerk(state, from_slow_end)
    }
}
