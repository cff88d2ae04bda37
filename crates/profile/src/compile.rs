//! Compiles an axis of a move into segments, in whole numbers.
//!
//! The plan is in 64-bit floats, of which a Cortex-M0+ spends tens of thousands of cycles on an instant. So an axis
//! takes the few numbers of a phase from it, once a phase (`setup`); from these and from a step's own number its
//! instant comes in fixed point. Nothing accumulates, neither from step to step nor from segment to segment.
//!
//! # Instants
//! With f ticks/s, the step after k others is due at the axis's displacement k + 1/2, in ticks from the start of the
//! move
//!
//! - accelerating at a from the speed v: at √(C² + B (k + 1/2)) - C, where C = f v/a and B = 2 f²/a, with the axis's
//!   own a and v (paper 002, section 2: s = v t + a t²/2, solved for t);
//! - cruising: on a line;
//! - decelerating: by the first, from the other end and backwards in time.
//!
//! So each of these is a line in the odd number 2 k + 1 (`wide`, 96 bits), its root taken on a ramp (`root`, 64 bits). A ramp
//! that hardly accelerates, where C would swallow the rest, is left to floats (`gentle`).
//!
//! Where the acceleration changes, the instants are those of a polynomial of the seventh degree over many segments
//! (`spans`): some floats a span give it from the law itself (`septic`), and the instants come in fixed point (`curve`).
//!
//! # Segments
//! A quadratic through the steps 0, n/2 and n of a ramp strays between them by t''' (n/2)³/(9 √3) at most, t''' being
//! the third derivative at the slow end. n is a power of two that keeps this within the error allowed, found by
//! logarithms (`ramp`), so that the fit is all shifts (`fit`). Step n begins the next segment: two roots a segment. A
//! ramp's last segment may reach beyond it, where the formula goes on smoothly, and hold fewer steps.
//!
//! # Errors
//! Against the closed form, in ticks: half a tick of rounding; the fit, [`FIT_ERROR_MAX_TICKS`] or, where a segment
//! would last less than [`BRIEF_S`], [`FIT_ERROR_MAX_S`]; and 0.02 of fixed point at most (the growth of intervals is
//! rounded to 2^-32 tick, a root to 2^-54 of itself). At 125 MHz that is 5 ns for slow steps and 24 ns for fast ones.
//! `cargo test -p isostep-profile --test segments` holds 10,000 random moves to it, and 2,000 extreme ones.
//!
//! # Cost
//! On a Cortex-M0+ 1,700 cycles a segment of a ramp, most of them for its two roots, 2,200 for a ramp's first, and 8.5
//! a step to fill a buffer (`cargo xtask bench`, emulated). From rest to 1,000,000 steps/s at 10,000,000 steps/s²,
//! three axes are compiled in less than half the time they move, at the worst place.
//!
//! Where the acceleration changes it is 7,400 to 33,000 cycles a segment, by the law, with the floats of the RP2040's ROM: the floats of a span, shared by its
//! segments, of which there are few near standstill.

mod curve;
mod fit;
mod gentle;
mod phase;
mod ramp;
mod root;
mod septic;
mod setup;
mod spans;
mod wide;

use self::phase::Phase;
use self::ramp::Knot;
use self::setup::{EvenRamp, View};
use self::spans::Spans;
use crate::profile::Profile;
use crate::segment::Segment;

/// How far a segment's quadratic may stray from the closed form, ticks. Rounding to a whole tick adds up to half.
pub const FIT_ERROR_MAX_TICKS: f64 = 0.125;
/// How far it may stray if that is more, s, in a segment that would last less than [`BRIEF_S`] otherwise: a fast axis
/// leaves less time to compile.
pub const FIT_ERROR_MAX_S: f64 = 20e-9;
/// Segments that would last less than this may stray by [`FIT_ERROR_MAX_S`], s; they then last some twice of it at
/// most.
pub const BRIEF_S: f64 = 1e-3;

/// A step of a ramp that is nearer to its slow end, where the profile begins or ends, is taken to be that near, steps:
/// standstill has no end of instants.
pub(crate) const NEAREST_STEPS: f64 = 1e-6;

/// How far any segment's quadratic may stray from the closed form at `tick_hz` (ticks/s), ticks.
#[must_use]
pub fn fit_error_max_ticks(tick_hz: u32) -> f64 {
    FIT_ERROR_MAX_TICKS.max(FIT_ERROR_MAX_S * f64::from(tick_hz))
}

/// A ramp as brief is what rounding has left where there is none, s: no step is of it.
const NO_RAMP_S: f64 = 1e-12;

/// Which steps of an axis a profile makes, and when it begins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// Steps of the longest axis for each of this one; at least 1.
    pub(crate) stride: f64,
    /// How many steps there are.
    pub(crate) steps: u32,
    /// By how much less than half a step of the axis the profile is at the first of them.
    pub(crate) ahead: f64,
    /// By how much more than half a step it goes on after the last.
    pub(crate) beyond: f64,
    /// When it begins, s from the start of the run.
    pub(crate) begin_s: f64,
}

impl Stretch {
    /// The steps before the end of each phase.
    pub(crate) fn phase_ends(&self, plan: &Profile) -> [u32; 3] {
        let Self { stride, steps, ahead, .. } = *self;
        let steps_before = |boundary: f64| {
            let is_end = boundary >= plan.distance_steps();
            if is_end { steps } else { ((boundary / stride + ahead + 0.5) as u32).min(steps) }
        };
        let accel_end = if plan.t_accel_s() > NO_RAMP_S { steps_before(plan.accel_end_steps()) } else { 0 };
        let cruise_end = if plan.t_decel_s() > NO_RAMP_S { steps_before(plan.cruise_end_steps()) } else { steps };
        [accel_end, cruise_end.max(accel_end), steps]
    }
}

/// Compiles one axis of a move into segments, one per call of `next`.
///
/// Step k of the axis (k = 1 to `steps`) is due when the master has covered (k - 1/2)/`steps` of the way.
#[derive(Clone, Debug)]
pub struct Segments {
    plan: Profile,
    view: View,
    /// The steps before the end of each phase.
    ends: [u32; 3],
    /// Index of the phase of the next step.
    index: usize,
    part: Part,
    /// Steps already compiled.
    done: u32,
    /// The next step, if the last segment told.
    next: Option<Knot>,
}

/// The steps of one phase.
#[derive(Clone, Debug)]
enum Part {
    /// At constant speed or acceleration.
    Even(Phase),
    /// At an acceleration that changes.
    Curved(Spans),
}

impl Segments {
    pub(crate) fn new(plan: &Profile, stretch: Stretch, tick_hz: u32) -> Self {
        let Stretch { stride, ahead, beyond, begin_s, .. } = stretch;
        let tick_hz = f64::from(tick_hz);
        let (begin_ticks, end_ticks) = (begin_s * tick_hz, (begin_s + plan.duration_s()) * tick_hz);
        let view = View { stride, tick_hz, ahead, beyond, begin_ticks, end_ticks };
        let ends = stretch.phase_ends(plan);
        let mut segments =
            Self { plan: *plan, view, ends, index: 0, part: Part::Even(Phase::empty()), done: 0, next: None };
        segments.begin_part();
        segments
    }

    fn begin_part(&mut self) {
        let (plan, view, end) = (&self.plan, self.view, self.ends[self.index]);
        if end <= self.done {
            return;
        }
        self.part = match (self.index, EvenRamp::of(&plan.accel), EvenRamp::of(&plan.decel)) {
            (0, Some(ramp), _) => Part::Even(Phase::accelerating(ramp, view, end)),
            (0, None, _) => Part::Curved(Spans::accelerating(plan, view, end)),
            (1, ..) => Part::Even(Phase::cruising(plan, view, end)),
            (_, _, Some(ramp)) => Part::Even(Phase::decelerating(ramp, view, end)),
            (_, _, None) => Part::Curved(Spans::decelerating(plan, view, self.done, end)),
        };
        self.next = None;
    }
}

impl Iterator for Segments {
    type Item = Segment;

    fn next(&mut self) -> Option<Segment> {
        if self.done == self.ends[2] {
            return None;
        }
        while self.ends[self.index] <= self.done {
            self.index += 1;
            self.begin_part();
        }
        let first = self.next.take();
        let segment = match &mut self.part {
            Part::Even(phase) => {
                let (segment, next) = phase.segment(self.done, first);
                self.next = next;
                segment
            }
            Part::Curved(spans) => spans.segment(self.done),
        };
        self.done += segment.steps();
        Some(segment)
    }
}
