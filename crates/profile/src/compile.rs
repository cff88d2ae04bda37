//! Compiles an axis of a move into segments, in whole numbers.
//!
//! The plan is in 64-bit floats, which cost a Cortex-M0+ tens of thousands of cycles an instant. So an axis takes from
//! it, once a move, the few numbers that tell its phases; from these and a step's own number each instant comes in fixed
//! point. Nothing accumulates, from step to step or from segment to segment.
//!
//! # Instants
//! With f ticks/s, the step after k others is due at the axis's displacement k + 1/2, in ticks from the start:
//!
//! - accelerating at a from the speed v, at √(C² + B (k + 1/2)) - C, with C = f v/a and B = 2 f²/a, both a and v being
//!   the axis's own (paper 002, section 2: s = v t + a t²/2 solved for t);
//! - decelerating, by the same from the other end, backwards in time;
//! - cruising, on a line.

mod fit;
mod gentle;
mod phase;
mod ramp;
mod root;
mod setup;
mod wide;

use self::phase::{Knot, Phase};
use self::setup::View;
use crate::segment::Segment;
use crate::trapezoid::Trapezoid;

/// How far a segment's quadratic may stray from the closed form, ticks. Rounding to a whole tick adds up to half.
pub const FIT_ERROR_MAX_TICKS: f64 = 0.125;
/// How far it may stray, s, if that is more, in a segment that would otherwise last less than [`BRIEF_S`].
pub const FIT_ERROR_MAX_S: f64 = 20e-9;
/// See [`FIT_ERROR_MAX_S`], s.
pub const BRIEF_S: f64 = 1e-3;

/// How far any segment's quadratic may stray from the closed form at `tick_hz`, ticks.
#[must_use]
pub fn fit_error_max_ticks(tick_hz: u32) -> f64 {
    FIT_ERROR_MAX_TICKS.max(FIT_ERROR_MAX_S * f64::from(tick_hz))
}

/// Compiles one axis of a move into segments, one per call of `next`.
///
/// Step k of the axis (k = 1 to `steps`) is due when the master has covered (k - 1/2)/`steps` of the way.
#[derive(Clone, Copy, Debug)]
pub struct Segments {
    phases: [Phase; 3],
    /// Index of the phase of the next step.
    phase: usize,
    /// Steps already compiled.
    done: u32,
    steps: u32,
    /// The next step, if the last segment told.
    next: Option<Knot>,
}

impl Segments {
    pub(crate) fn new(plan: &Trapezoid, steps: u32, tick_hz: u32) -> Self {
        let share = f64::from(steps) / plan.distance_steps();
        let steps_before = |boundary: f64| ((boundary * share + 0.5) as u32).min(steps);
        let accel_end = steps_before(plan.accel_end_steps());
        let cruise_end = steps_before(plan.cruise_end_steps()).max(accel_end);
        let view = View::new(plan, 1.0 / share, tick_hz);
        let mut phases = [Phase::empty(); 3];
        if accel_end > 0 {
            phases[0] = Phase::accelerating(plan, view, accel_end);
        }
        if cruise_end > accel_end {
            phases[1] = Phase::cruising(plan, view, cruise_end);
        }
        if steps > cruise_end {
            phases[2] = Phase::decelerating(plan, view, steps);
        }
        Self { phases, phase: 0, done: 0, steps, next: None }
    }
}

impl Iterator for Segments {
    type Item = Segment;

    fn next(&mut self) -> Option<Segment> {
        if self.done == self.steps {
            return None;
        }
        while self.phases[self.phase].end <= self.done {
            self.phase += 1;
            self.next = None;
        }
        let phase = &mut self.phases[self.phase];
        let first = self.next.unwrap_or_else(|| phase.knot(self.done));
        let (segment, next) = phase.segment(self.done, first);
        self.done += segment.steps();
        self.next = Some(next);
        Some(segment)
    }
}
