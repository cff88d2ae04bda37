//! A ramp whose acceleration changes, as spans of quintics.
//!
//! No law is inverted for a segment. A span reaches from one state of the ramp to another; each state is a time, a
//! displacement, a speed and an acceleration in closed form, and over the span the time is the quintic in the
//! displacement that has all of these at both ends. The state midway tells how far the quintic strays: if too far, the span is halved, and if by far, the next one is twice as long. The ramp's corners, where the
//! jerk jumps, end a span too. So a state is as near to the law as floats are, and nothing accumulates.
//!
//! Segments come from the quintic in fixed point ([`Curve`]).

use super::curve::{Curve, Place};
use super::quintic::Quintic;
use super::setup::View;
use crate::profile::Profile;
use crate::ramp::{Ramp, State};
use crate::segment::Segment;

/// How far a quintic may stray from the law, ticks: a quarter of what a segment may.
pub(super) const STRAY_MAX_TICKS: f64 = 1.0 / 32.0;
/// A span that strays by this share of it was too short: a quintic over twice as long strays 64 times as much.
const SHORT_SHARE: f64 = 1.0 / 128.0;
/// Longest span, ticks: half of what a segment may last.
const SPAN_MAX_TICKS: f64 = 1_073_741_824.0;
/// What the laws' floats may lose of a time, as a share of it: 2^-48.
const ROUNDING: f64 = 3.552_713_678_800_501e-15;
/// At first, the share of the ramp that a span tries.
const FIRST_SHARE: f64 = 1.0 / 16.0;
/// Spans begin and end nearer to standstill than the first and last step, at half a step, so there always is a span.
const BEFORE_STEP: f64 = 0.25;
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
        let first = path.ramp.parameter_at(view.stride * BEFORE_STEP);
        Self::new(path, view, (first, path.ramp.parameter_end()), (0, end))
    }

    /// Over the steps from `begin` on, before `end`, where the move ends.
    pub(super) fn decelerating(plan: &Profile, view: View, begin: u32, end: u32) -> Self {
        let path = Path { ramp: plan.decel, is_backwards: true };
        let last = path.ramp.parameter_end() - path.ramp.parameter_at(view.stride * BEFORE_STEP);
        Self::new(path, view, (0.0, last), (begin, end))
    }

    fn new(path: Path, view: View, (first, last): (f64, f64), (begin, end): (u32, u32)) -> Self {
        Self {
            path,
            view,
            parameter: first,
            state: path.state(first),
            last,
            reach: (last - first) * FIRST_SHARE,
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
        let quintic = self.next_quintic();
        self.curve_end = if self.parameter >= self.last { self.end } else { self.steps_before(self.state.steps) };
        self.curve_end = self.curve_end.clamp(step, self.end);
        let place = Place {
            step,
            count: self.curve_end.wrapping_sub(step),
            steps_after_begin: self.steps_after(&quintic, step),
        };
        self.curve = Curve::new(&quintic, self.view, self.path.is_backwards, place);
    }

    /// Goes on by as much as a quintic holds.
    fn next_quintic(&mut self) -> Quintic {
        let mut to = (self.parameter + self.reach).min(self.path.ramp.next_corner(self.parameter)).min(self.last);
        let mut end = self.path.state(to);
        loop {
            let reach = to - self.parameter;
            let half = self.parameter + reach / 2.0;
            let middle = self.path.state(half);
            let quintic = Quintic::between(&self.state, &end);
            let stray = self.stray(&quintic, &middle, &end);
            if stray <= 1.0 || reach <= SHARE_MIN * self.last {
                if stray <= SHORT_SHARE {
                    self.reach = self.reach.max(2.0 * reach);
                }
                (self.parameter, self.state) = (to, end);
                return quintic;
            }
            (to, end, self.reach) = (half, middle, reach / 2.0);
        }
    }

    /// How far the quintic strays, or, if it is too long, more than that, as a share of what is allowed.
    fn stray(&self, quintic: &Quintic, middle: &State, end: &State) -> f64 {
        let tick_hz = self.view.tick_hz;
        let stray_ticks = quintic.stray_s(middle) * tick_hz;
        // No nearer than 64-bit floats tell in a very long move.
        let allowed_ticks = STRAY_MAX_TICKS.max(middle.t_s * tick_hz * ROUNDING);
        let ticks = (end.t_s - self.state.t_s).abs() * tick_hz;
        if ticks > SPAN_MAX_TICKS { f64::INFINITY } else { stray_ticks / allowed_ticks }
    }

    /// How many steps are due before the ramp is at `ramp_steps`.
    fn steps_before(&self, ramp_steps: f64) -> u32 {
        let nearer_to_slow_end = (ramp_steps / self.view.stride + 0.5) as u32;
        if self.path.is_backwards { self.end - nearer_to_slow_end.min(self.end) } else { nearer_to_slow_end }
    }

    /// How many steps after the quintic's beginning `step` is due; rounding may leave it a little before.
    fn steps_after(&self, quintic: &Quintic, step: u32) -> f64 {
        let begin = quintic.begin_steps / self.view.stride;
        let after = if self.path.is_backwards {
            begin - (f64::from(self.end - step) - 0.5)
        } else {
            f64::from(step) + 0.5 - begin
        };
        after.max(0.0)
    }
}

impl Path {
    fn state(&self, parameter: f64) -> State {
        let from_slow_end = if self.is_backwards { self.ramp.parameter_end() - parameter } else { parameter };
        self.ramp.at_parameter(from_slow_end)
    }
}
