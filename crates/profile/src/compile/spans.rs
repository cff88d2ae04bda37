//! A ramp whose acceleration changes, as spans of polynomials.
//!
//! No law is inverted for a segment. A span reaches from one state of the ramp to another; each state is a time, a
//! displacement, a speed, an acceleration and a jerk in closed form, and over the span the time is the polynomial in the
//! displacement that has all of these at both ends. The state midway tells how far the polynomial strays, and so how long
//! the span, if that is too far, or the next one should be. The ramp's corners, where the jerk jumps, end a span too. So a
//! state is as near to the law as floats are, and nothing accumulates.
//!
//! Segments come from the polynomial in fixed point ([`Curve`]).

use super::NEAREST_STEPS;
use super::curve::{Curve, Place};
use super::septic::Septic;
use super::setup::View;
use crate::newton::rough_root;
use crate::profile::Profile;
use crate::ramp::{Ramp, State};
use crate::segment::Segment;

/// How far a polynomial may stray from the law, ticks: a quarter of what a segment may.
pub(super) const STRAY_MAX_TICKS: f64 = 1.0 / 32.0;
/// A span tried aims at this share of the longest: the next that fails costs as much.
const SAFE_SHARE: f64 = 0.9;
/// It is not less than this share of the one tried before,
const SHARE_LEAST: f64 = 0.1;
/// nor more than this one.
const SHARE_MOST: f64 = 4.0;
/// Longest span, ticks: half of what a segment may last.
const SPAN_MAX_TICKS: f64 = 1_073_741_824.0;
/// What the laws' floats may lose of a time, as a share of it: 2^-48.
const ROUNDING: f64 = 3.552_713_678_800_501e-15;
/// At first, the share of the ramp that a span tries at most.
const FIRST_SHARE: f64 = 1.0 / 16.0;
/// And of that over which the speed would double, which is what is right near standstill.
const DOUBLING_SHARE: f64 = 0.18;
/// Spans begin and end a little nearer to standstill than the first and last step: at this share of their way.
const BEFORE_STEP: f64 = 0.98;
/// Shorter spans, as shares of the ramp, are not tried: only rounding would be left to see.
const SHARE_MIN: f64 = 1e-12;

/// The spans of one ramp for one axis.
#[derive(Clone, Debug)]
pub(super) struct Spans {
    path: Path,
    view: View,
    /// Where the span ends: the path's parameter and the ramp's state.
    parameter: f64,
    state: State,
    /// Where the last span ends.
    last: f64,
    /// How far the next span tries to reach, of the parameter.
    reach: f64,
    curve: Curve,
    /// The step after the span's last.
    curve_end: u32,
    /// The step after the ramp's last.
    end: u32,
}

/// A ramp, from its slow to its fast end or backwards. Its parameter is what the law is over, time or displacement,
/// from where the path begins. Its states are the ramp's, counted from the slow end: nothing cancels near standstill.
#[derive(Clone, Copy, Debug)]
struct Path {
    ramp: Ramp,
    is_backwards: bool,
}

impl Spans {
    /// Over the steps before `end`.
    pub(super) fn accelerating(plan: &Profile, view: View, end: u32) -> Self {
        let path = Path { ramp: plan.accel, is_backwards: false };
        let first = path.ramp.parameter_before(view.begin_steps() * BEFORE_STEP);
        Self::new(path, view, (first, path.ramp.parameter_end()), (0, end))
    }

    /// Over the steps from `begin` on, before `end`, where the move ends.
    pub(super) fn decelerating(plan: &Profile, view: View, begin: u32, end: u32) -> Self {
        let path = Path { ramp: plan.decel, is_backwards: true };
        let last = path.ramp.parameter_end() - path.ramp.parameter_before(view.end_steps() * BEFORE_STEP);
        Self::new(path, view, (0.0, last), (begin, end))
    }

    fn new(path: Path, view: View, (first, last): (f64, f64), (begin, end): (u32, u32)) -> Self {
        let state = path.state(first);
        Self {
            path,
            view,
            parameter: first,
            last,
            reach: ((last - first) * FIRST_SHARE).min(path.ramp.doubling(&state) * DOUBLING_SHARE),
            state,
            curve: Curve::empty(),
            curve_end: begin,
            end,
        }
    }

    /// The segment that begins at the step with the number `step`.
    pub(super) fn segment(&mut self, step: u32) -> Segment {
        while self.curve_end <= step {
            self.next_span(step);
        }
        self.curve.segment(step, self.curve_end.wrapping_sub(step))
    }

    /// Goes on to a span whose first step, if it has any, is `step`.
    #[inline(never)]
    fn next_span(&mut self, step: u32) {
        let septic = self.next_septic();
        self.curve_end = if self.parameter >= self.last { self.end } else { self.steps_before(self.state.steps) };
        self.curve_end = self.curve_end.clamp(step, self.end);
        let place = Place {
            step,
            count: self.curve_end.wrapping_sub(step),
            steps_after_begin: self.steps_after(&septic, step),
        };
        self.curve = Curve::new(&septic, self.view, self.path.is_backwards, place);
    }

    /// Goes on by as much as a polynomial holds.
    fn next_septic(&mut self) -> Septic {
        let mut to = (self.parameter + self.reach).min(self.path.ramp.next_corner(self.parameter)).min(self.last);
        let mut is_cut = to < self.parameter + self.reach;
        let mut end = self.path.state(to);
        loop {
            let reach = to - self.parameter;
            let half = self.parameter + reach / 2.0;
            let middle = self.path.state(half);
            let jerk = |state| (state, self.path.jerk(state, half));
            let septic = Septic::between(jerk(&self.state), jerk(&end));
            let stray = self.stray(&septic, &middle, &end);
            let better = reach * better_share(stray);
            if stray <= 1.0 || reach <= SHARE_MIN * self.last {
                // Where a corner cut it short, the one tried before was better.
                self.reach = if better > self.reach || !is_cut { better } else { self.reach };
                (self.parameter, self.state) = (to, end);
                return septic;
            }
            (self.reach, to, is_cut) = (better, self.parameter + better, false);
            end = self.path.state(to);
        }
    }

    /// How far the polynomial strays, or, if it is too long, more than that, as a share of what is allowed.
    fn stray(&self, septic: &Septic, middle: &State, end: &State) -> f64 {
        let tick_hz = self.view.tick_hz;
        let stray_ticks = septic.stray_s(middle) * tick_hz;
        // No nearer than 64-bit floats tell in a very long move.
        let allowed_ticks = STRAY_MAX_TICKS.max(middle.t_s * tick_hz * ROUNDING);
        let ticks = (end.t_s - self.state.t_s).abs() * tick_hz;
        if ticks > SPAN_MAX_TICKS { f64::INFINITY } else { stray_ticks / allowed_ticks }
    }

    /// How many steps are due before the ramp is at `ramp_steps`.
    fn steps_before(&self, ramp_steps: f64) -> u32 {
        let axis_steps = ramp_steps / self.view.stride + 0.5;
        if self.path.is_backwards {
            self.end - ((axis_steps - self.view.beyond) as u32).min(self.end)
        } else {
            (axis_steps + self.view.ahead) as u32
        }
    }

    /// How many steps after the span's beginning `step` is due; rounding may leave it a little before.
    fn steps_after(&self, septic: &Septic, step: u32) -> f64 {
        let begin = septic.begin_steps / self.view.stride;
        let after = if self.path.is_backwards {
            begin - (f64::from(self.end - step) - 0.5 + self.view.beyond).max(NEAREST_STEPS)
        } else {
            (f64::from(step) + 0.5 - self.view.ahead).max(NEAREST_STEPS) - begin
        };
        after.max(0.0)
    }
}

/// By what share longer a span should be that strays by `stray` of what is allowed: over twice as long a polynomial
/// strays 2^8 times as much.
fn better_share(stray: f64) -> f64 {
    let share = SAFE_SHARE / rough_root(stray, 8);
    // Not `clamp`: its panic would print floats, for which the chip has no room.
    if share < SHARE_LEAST { SHARE_LEAST } else { share.min(SHARE_MOST) }
}

impl Path {
    fn state(&self, parameter: f64) -> State {
        let from_slow_end = if self.is_backwards { self.ramp.parameter_end() - parameter } else { parameter };
        self.ramp.at_parameter(from_slow_end)
    }

    /// The ramp's jerk in `state`, on the side of `parameter` if that is a corner.
    fn jerk(&self, state: &State, parameter: f64) -> f64 {
        let from_slow_end = if self.is_backwards { self.ramp.parameter_end() - parameter } else { parameter };
        self.ramp.jerk(state, from_slow_end)
    }
}
