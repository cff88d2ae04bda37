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
//! that hardly accelerates, where C would swallow the rest, is left to floats (`small_accel`).
//!
//! Where the acceleration changes, the instants are those of a polynomial of the seventh degree over many segments
//! (`spans`): some floats a span give it from the law itself (`hermite`), and the instants come in fixed point (`curve`).
//!
//! # Segments
//! A quadratic through the steps 0, n/2 and n of a ramp deviates between them by t''' (n/2)³/(9 √3) at most, t''' being
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
//! On a Cortex-M0+ 1,540 cycles a segment of a ramp, most of them for its two roots, and 8.5 a step to fill a buffer
//! (`cargo xtask bench`, emulated). From rest to 1,000,000 steps/s at 10,000,000 steps/s², three axes are compiled in less
//! than half the time they move, at the worst place.
//!
//! By the curved laws a segment costs 7,400 to 33,000 cycles on average, in floats of the RP2040's ROM. Most of that is for
//! spans: each is reckoned once for all axes and all its segments, but near standstill a span has few.

mod course;
mod curve;
mod fit;
mod fixed_ramp;
mod hermite;
mod phase;
mod root;
mod setup;
mod small_accel;
mod spans;
mod u96;

pub use self::course::Course;
use self::fixed_ramp::Knot;
use self::phase::Phase;
use self::setup::View;
use self::spans::Spans;
use crate::profile::Profile;
use crate::segment::Segment;

/// How far a segment's quadratic may deviate from the closed form, ticks. Rounding to a whole tick adds up to half.
pub const FIT_ERROR_MAX_TICKS: f64 = 0.125;
/// How far it may deviate if that is more, s, in a segment that would last less than [`BRIEF_S`] otherwise: a fast axis
/// leaves less time to compile.
pub const FIT_ERROR_MAX_S: f64 = 20e-9;
/// Segments that would last less than this may deviate by [`FIT_ERROR_MAX_S`], s; they then last some twice of it at
/// most.
pub const BRIEF_S: f64 = 1e-3;

/// A step of a ramp that is nearer to its slow end, where the profile begins or ends, is taken to be that near, steps:
/// standstill has no end of instants.
pub(crate) const NEAREST_STEPS: f64 = 1e-6;

/// How far any segment's quadratic may deviate from the closed form at `tick_hz` (ticks/s), ticks.
#[must_use]
pub fn fit_error_max_ticks(tick_hz: u32) -> f64 {
    FIT_ERROR_MAX_TICKS.max(FIT_ERROR_MAX_S * f64::from(tick_hz))
}

/// A ramp as brief is what rounding has left where there is none, s: no step is of it.
const NO_RAMP_S: f64 = 1e-12;

/// Which steps of an axis a profile makes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// Steps of the longest axis for each of this one; at least 1.
    pub(crate) stride: f64,
    /// How many steps of the whole move come before.
    pub(crate) before: u32,
    /// How many steps there are.
    pub(crate) steps: u32,
    /// By how much less than half a step of the axis the profile is at the first of them; 0 where a move begins.
    pub(crate) ahead: f64,
    /// By how much more than half a step it goes on after the last; 0 where a move ends.
    pub(crate) beyond: f64,
}

impl Stretch {
    /// The steps before the end of each phase.
    pub(crate) fn phase_ends(&self, bounds: &PhaseBounds) -> [u32; 3] {
        let Self { stride, steps, ahead, .. } = *self;
        let steps_before = |bound: Bound| match bound {
            Bound::Begin => 0,
            Bound::Within(place_steps) => ((place_steps / stride + ahead + 0.5) as u32).min(steps),
            Bound::End => steps,
        };
        let accel_end = steps_before(bounds.accel_end);
        [accel_end, steps_before(bounds.cruise_end).max(accel_end), steps]
    }

    /// How far the profile is at the first step, at the rate of the longest axis; not nothing.
    pub(crate) fn begin_steps(&self) -> f64 {
        (0.5 - self.ahead).max(NEAREST_STEPS) * self.stride
    }

    /// How far it goes on after the last step, likewise.
    pub(crate) fn end_steps(&self) -> f64 {
        (0.5 + self.beyond).max(NEAREST_STEPS) * self.stride
    }
}

/// Where the acceleration and the cruise of a profile end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PhaseBounds {
    accel_end: Bound,
    cruise_end: Bound,
}

/// A place on a profile.
#[derive(Clone, Copy, Debug)]
enum Bound {
    Begin,
    /// Steps of the longest axis from its beginning.
    Within(f64),
    End,
}

impl PhaseBounds {
    /// Of no plan.
    pub(crate) const NONE: Self = Self { accel_end: Bound::Begin, cruise_end: Bound::Begin };

    pub(crate) fn of(plan: &Profile) -> Self {
        let bound = |place_steps: f64| {
            if place_steps >= plan.distance_steps() { Bound::End } else { Bound::Within(place_steps) }
        };
        let (has_accel, has_decel) = (plan.t_accel_s() > NO_RAMP_S, plan.t_decel_s() > NO_RAMP_S);
        Self {
            accel_end: if has_accel { bound(plan.accel_end_steps()) } else { Bound::Begin },
            cruise_end: if has_decel { bound(plan.cruise_end_steps()) } else { Bound::End },
        }
    }
}

/// Compiles one axis of a [`Course`] into segments.
///
/// Step k of the axis (k = 1 to `steps`) is due when the longest axis has covered (k - 1/2)/`steps` of the way.
#[derive(Clone, Debug)]
pub struct Lane {
    stretch: Stretch,
    /// The steps before the end of each phase.
    ends: [u32; 3],
    /// Index of the phase of the next step.
    index: usize,
    phase: PhaseSteps,
    /// Steps already compiled.
    done: u32,
    /// The next step, if the last segment told.
    next: Option<Knot>,
}

/// The steps of one phase.
#[derive(Clone, Debug)]
enum PhaseSteps {
    /// At constant speed or acceleration.
    ConstantAccel(Phase),
    /// At an acceleration that changes.
    Curved(Spans),
}

impl Lane {
    pub(crate) fn new(stretch: Stretch, course: &Course) -> Self {
        let ends = stretch.phase_ends(&course.frame.bounds);
        Self { stretch, ends, index: 0, phase: PhaseSteps::ConstantAccel(Phase::empty()), done: 0, next: None }
    }

    /// How many steps there are.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.stretch.steps
    }

    /// How many steps of the whole move come before.
    #[must_use]
    pub fn steps_before(&self) -> u32 {
        self.stretch.before
    }

    /// The next segment; `None` after the last. `course` is the one it is a lane of.
    pub fn next(&mut self, course: &mut Course) -> Option<Segment> {
        if self.done == self.ends[2] {
            return None;
        }
        if self.done == 0 || self.ends[self.index] <= self.done {
            while self.ends[self.index] <= self.done {
                self.index += 1;
            }
            self.begin_phase(course);
        }
        let segment = match &mut self.phase {
            PhaseSteps::ConstantAccel(phase) => {
                let (segment, next) = phase.segment(self.done, self.next.take());
                self.next = next;
                segment
            }
            PhaseSteps::Curved(spans) => spans.segment(self.done, &self.stretch, course),
        };
        self.done += segment.steps();
        Some(segment)
    }

    fn begin_phase(&mut self, course: &mut Course) {
        let end = self.ends[self.index];
        let view = View { frame: &course.frame, stretch: &self.stretch };
        self.phase = match (self.index, &course.frame.accel, &course.frame.decel) {
            (0, Some(ramp), _) => PhaseSteps::ConstantAccel(Phase::accelerating(ramp, view, end)),
            (1, ..) => PhaseSteps::ConstantAccel(Phase::cruising(view, end)),
            (2, _, Some(ramp)) => PhaseSteps::ConstantAccel(Phase::decelerating(ramp, view, end)),
            (index, ..) => PhaseSteps::Curved(Spans::new(course, index != 0, (self.done, end))),
        };
        self.next = None;
    }
}

/// The segments of one axis of a plan, one per call of `next`: a [`Lane`] and a [`Course`] of its own.
#[derive(Clone, Debug)]
pub struct Segments {
    course: Course,
    lane: Lane,
}

impl Segments {
    pub(crate) fn new(course: Course, lane: Lane) -> Self {
        Self { course, lane }
    }
}

impl Iterator for Segments {
    type Item = Segment;

    fn next(&mut self) -> Option<Segment> {
        self.lane.next(&mut self.course)
    }
}
