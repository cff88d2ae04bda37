//! A ramp whose acceleration changes, as spans of quintics.
//!
//! No law is inverted per segment. A span reaches from one state of the ramp to another; each state is a time, a
//! displacement, a speed and an acceleration in closed form. Over the span the time is the quintic in the displacement
//! that has these at both ends (Hermite's): its derivatives there are 1/v and -a/v³. The state midway, where a quintic
//! strays most, tells whether it is near enough: if not, the span is halved, and if by far, the next one is twice as
//! long. The ramp's own corners, where the jerk jumps, end a span too.
//!
//! Segments come from the quintic in fixed point, at the cost of five products of 64 bits an instant.

use super::curve::Curve;
use super::setup::View;
use crate::profile::Profile;
use crate::ramp::{Ramp, State};
use crate::segment::Segment;

/// How far a quintic may stray from the law, ticks: a quarter of what a segment may.
pub(super) const STRAY_MAX_TICKS: f64 = 1.0 / 32.0;
/// A span that strays by this share of it was too short: a quintic over twice as long strays 64 times as much.
const SHORT_SHARE: f64 = 1.0 / 128.0;
/// Longest span, ticks, so that its numbers fit.
const SPAN_MAX_TICKS: f64 = 67_108_864.0;
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
    /// The end of the span, as the ramp's parameter and state.
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

/// A ramp as the move takes it. Its parameter is what the law is over, time or displacement, and rises with both.
#[derive(Clone, Copy, Debug)]
struct Path {
    ramp: Ramp,
    /// Where and when the move ends, if the ramp is taken backwards from there: steps and s.
    backwards_from: Option<(f64, f64)>,
}

impl Spans {
    /// Over the steps before `end`.
    pub(super) fn accelerating(plan: &Profile, view: View, end: u32) -> Self {
        let path = Path { ramp: plan.accel, backwards_from: None };
        let first = path.ramp.parameter_at(view.stride * BEFORE_STEP);
        Self::new(path, view, (first, path.ramp.parameter_end()), (0, end))
    }

    /// Over the steps from `begin` on, before `end`, where the move ends.
    pub(super) fn decelerating(plan: &Profile, view: View, begin: u32, end: u32) -> Self {
        let path = Path { ramp: plan.decel, backwards_from: Some((plan.distance_steps(), plan.duration_s())) };
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
        self.curve.segment(step, self.curve_end - step)
    }

    /// Goes on to a span whose first step, if it has any, is `step`.
    fn next_span(&mut self, step: u32) {
        let from = self.state;
        let mut to = self.parameter + self.reach;
        to = to.min(self.path.next_corner(self.parameter)).min(self.last);
        let mut far = self.path.state(to);
        let least = SHARE_MIN * self.last;
        let quintic = loop {
            let reach = to - self.parameter;
            let half = self.parameter + reach / 2.0;
            let middle = self.path.state(half);
            let quintic = Quintic::between(&from, &far);
            let stray_ticks = (quintic.time_s(&middle) - middle.t_s).abs() * self.view.tick_hz;
            let is_short = (far.t_s - from.t_s) * self.view.tick_hz <= SPAN_MAX_TICKS;
            if is_short && stray_ticks <= STRAY_MAX_TICKS || reach <= least {
                if stray_ticks <= STRAY_MAX_TICKS * SHORT_SHARE {
                    self.reach = self.reach.max(2.0 * reach);
                }
                break quintic;
            }
            (to, far, self.reach) = (half, middle, reach / 2.0);
        };
        self.curve_end = if to >= self.last { self.end } else { self.steps_before(far.steps).clamp(step, self.end) };
        self.curve = Curve::new(&quintic, self.view, step, self.curve_end - step);
        (self.parameter, self.state) = (to, far);
    }

    /// How many steps of the axis are due before the master is at `steps`.
    fn steps_before(&self, steps: f64) -> u32 {
        (steps / self.view.stride + 0.5) as u32
    }
}

impl Path {
    fn state(&self, parameter: f64) -> State {
        match self.backwards_from {
            None => self.ramp.at_parameter(parameter),
            Some((steps, t_s)) => {
                let state = self.ramp.at_parameter(self.ramp.parameter_end() - parameter);
                State {
                    t_s: t_s - state.t_s,
                    steps: steps - state.steps,
                    accel_steps_s2: -state.accel_steps_s2,
                    ..state
                }
            }
        }
    }

    /// Every law has its corners at the same places from both ends.
    fn next_corner(&self, parameter: f64) -> f64 {
        self.ramp.next_corner(parameter)
    }
}

/// The time over the displacement between two states: Σ c_i z^i with z from 0 to 1.
pub(super) struct Quintic {
    /// s.
    pub(super) coefficients: [f64; 6],
    /// Where z is 0, steps.
    pub(super) from_steps: f64,
    /// What z is counted in, steps.
    pub(super) steps: f64,
}

impl Quintic {
    fn between(from: &State, to: &State) -> Self {
        let h = to.steps - from.steps;
        let (slope_from, bend_from) = derivatives(from, h);
        let (slope_to, bend_to) = derivatives(to, h);
        // What the value, slope and bend at the end exceed those that the first three terms come to.
        let value = to.t_s - from.t_s - slope_from - bend_from / 2.0;
        let slope = slope_to - slope_from - bend_from;
        let bend = bend_to - bend_from;
        let coefficients = [
            from.t_s,
            slope_from,
            bend_from / 2.0,
            10.0 * value - 4.0 * slope + bend / 2.0,
            -15.0 * value + 7.0 * slope - bend,
            6.0 * value - 3.0 * slope + bend / 2.0,
        ];
        Self { coefficients, from_steps: from.steps, steps: h }
    }

    fn time_s(&self, at: &State) -> f64 {
        let z = (at.steps - self.from_steps) / self.steps;
        self.coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * z + coefficient)
    }
}

/// dt/dz and d²t/dz² where z counts `h` steps: h/v and -h² a/v³.
fn derivatives(state: &State, h: f64) -> (f64, f64) {
    let slope = h / state.speed_steps_s;
    (slope, -slope * slope * state.accel_steps_s2 / state.speed_steps_s)
}
