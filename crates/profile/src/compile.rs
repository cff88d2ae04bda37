//! Compiles an axis of a move into segments, in whole numbers.
//!
//! The plan is in 64-bit floats, in which a Cortex-M0+ would spend tens of thousands of cycles on an instant. So an
//! axis takes a few numbers from the plan once a phase (`setup`). From these and from a step's own number, the step's
//! instant is computed in fixed point. No error accumulates, neither from step to step nor from segment to segment.
//!
//! # Instants
//! With f ticks/s, the step after k others is due at the axis's displacement k + 1/2. In ticks from the start of the
//! move, that is
//!
//! - accelerating at a from the speed v: at √(C² + B (k + 1/2)) - C, where C = f v/a and B = 2 f²/a, with the axis's
//!   own a and v (Stoychitch 2018, section 2: s = v t + a t²/2, solved for t);
//! - cruising: on a line;
//! - decelerating: by the first formula, from the other end and backwards in time.
//!
//! So each of these is a linear function of the odd number 2 k + 1 (`u96`, 96 bits); on a ramp, its root is taken
//! (`root`, 64 bits). On a ramp that hardly accelerates, C would be so large that the difference loses its digits. Such
//! a ramp is computed in floats (`small_accel`).
//!
//! Where the acceleration changes, the instants follow polynomials of the seventh degree, each over many segments
//! (`shared_spans`, `spans`). A few float operations a span derive the polynomial from the speed profile itself (`hermite`); the
//! instants are computed from it in fixed point (`curve`).
//!
//! # Segments
//! A quadratic through the steps 0, n/2 and n of a ramp deviates between them by t''' (n/2)³/(9 √3) at most, where t'''
//! is the third derivative at the slow end. n is a power of two that keeps this within the error allowed. It is found
//! by logarithms (`fixed_ramp`), and as a power of two it reduces the fit to shifts (`fit`). Step n begins the next
//! segment, so a segment costs two roots. The last segment of a ramp may reach beyond the ramp's end, where the formula
//! goes on smoothly, and hold fewer steps.
//!
//! # Errors
//! The error against the closed form, in ticks, is the sum of three parts: half a tick of rounding; the error of the
//! fit, [`FIT_ERROR_MAX_TICKS`] or, if a segment would last less than [`BRIEF_S`], [`FIT_ERROR_MAX_S`]; and at
//! most 0.02 of fixed point (the growth of intervals is rounded to 2^-32 tick, a root to 2^-54 of itself). At 125 MHz
//! the sum is 5 ns for slow steps and 24 ns for fast ones. `cargo test -p isostep-profile segments::` checks
//! 10,000 random moves and 2,000 extreme ones.
//!
//! # Cost
//! On a Cortex-M0+ a segment of a ramp costs 1,540 cycles, most of them for its two roots, and to fill a buffer
//! costs 8.5 cycles a step (`cargo xtask bench`, emulated). From rest to 1,000,000 steps/s at 10,000,000 steps/s²,
//! three axes are compiled in less than half the time they move, even at the worst place.
//!
//! By the curved speed profiles a segment costs 6,800 to 28,000 cycles on average, with the float routines in the RP2040's ROM.
//! Most of that is for spans. A span is computed once for all axes and for all its segments, but near standstill it has
//! only a few segments.

mod cubic;
mod curve;
mod fit;
mod fixed_phase;
mod fixed_ramp;
mod hermite;
mod root_and_log2;
mod setup;
mod shared_spans;
mod small_accel;
mod spans;
mod timed_plan;
mod u96;

use self::fixed_phase::FixedPhase;
use self::fixed_ramp::Sample;
use self::spans::Spans;
pub use self::timed_plan::TimedPlan;
use self::timed_plan::{Clock, ConstantAccelRamp, TimedStepRange};
use self::u96::short_fixed;
use crate::fixed::is_zero;
use crate::phase::{CountedPhase, SlowEnd};
use crate::profile::Profile;
use crate::segment::Segment;

/// The distance by which a segment's quadratic may deviate from the closed form, ticks. Rounding to a whole tick adds up to half.
pub const FIT_ERROR_MAX_TICKS: f64 = 0.125;
/// The distance by which it may deviate instead, s, if that is more and the segment would otherwise last less than [`BRIEF_S`]: a
/// fast axis leaves less time to compile.
pub const FIT_ERROR_MAX_S: f64 = 20e-9;
/// A segment that would last less than this, s, may deviate by [`FIT_ERROR_MAX_S`]. It then lasts about twice this at
/// most.
pub const BRIEF_S: f64 = 1e-3;

/// The smallest distance of a step from the place where the axis stands still, or would stand still if a ramp went on
/// beyond its slow end, steps. A nearer step is taken to be at this distance, because near standstill the instant changes
/// without bound over the displacement. A curved ramp keeps this distance from its slow end.
pub(crate) const NEAREST_STEPS: f64 = 1e-6;

/// The distance by which any segment's quadratic may deviate from the closed form at `tick_hz` (ticks/s), ticks.
#[must_use]
pub fn fit_error_max_ticks(tick_hz: u32) -> f64 {
    FIT_ERROR_MAX_TICKS.max(FIT_ERROR_MAX_S * f64::from(tick_hz))
}

/// A ramp that lasts no longer than this, s, is a rounding error and counts as none. No step lies on it.
const NO_RAMP_S: f64 = 1e-12;

/// The steps of an axis that a profile makes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepRange {
    /// Steps of the longest axis for each of this one; at least 1.
    pub(crate) stride: f64,
    /// The number of steps of the whole move that come before.
    pub(crate) before: u32,
    /// The number of steps.
    pub(crate) steps: u32,
    /// The first of them is due when the profile has gone 1/2 - `ahead` steps of the axis; 0 where a move begins.
    pub(crate) ahead: f64,
    /// The profile goes on for 1/2 + `beyond` steps of the axis after the last of them; 0 where a move ends.
    pub(crate) beyond: f64,
}

impl StepRange {
    /// The number of steps that come before the end of each phase.
    pub(crate) fn phase_ends(&self, boundaries: &PhaseBoundaries) -> [u32; 3] {
        let Self { stride, steps, ahead, .. } = *self;
        let steps_before = |boundary: PhaseBoundary| match boundary {
            PhaseBoundary::Begin => 0,
            PhaseBoundary::Within(place_steps) => {
                // Dividing by 1, and adding 0, would be as slow as by any number.
                let own_steps = if self.is_longest() { place_steps } else { place_steps / stride };
                nearest(if is_zero(ahead) { own_steps } else { own_steps + ahead }).min(steps)
            }
            PhaseBoundary::End => steps,
        };
        let accel_end = steps_before(boundaries.accel_end);
        [accel_end, steps_before(boundaries.cruise_end).max(accel_end), steps]
    }

    /// True if the axis makes as many steps as the longest one.
    pub(crate) fn is_longest(&self) -> bool {
        self.stride.to_bits() == 1_f64.to_bits()
    }

    /// The place of the profile at the first step, steps of the longest axis; above 0.
    pub(crate) fn begin_steps(&self) -> f64 {
        (0.5 - self.ahead).max(NEAREST_STEPS) * self.stride
    }

    /// The distance that the profile goes on after the last step, steps of the longest axis; above 0.
    pub(crate) fn end_steps(&self) -> f64 {
        (0.5 + self.beyond).max(NEAREST_STEPS) * self.stride
    }
}

/// The nearest whole number, halves rounded up; 0 for what is negative.
fn nearest(steps: f64) -> u32 {
    if steps < 0.0 { 0 } else { (short_fixed(steps, 1).wrapping_add(1) >> 1) as u32 }
}

/// The places where the acceleration and the cruise of a profile end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PhaseBoundaries {
    accel_end: PhaseBoundary,
    cruise_end: PhaseBoundary,
}

/// A place on a profile.
#[derive(Clone, Copy, Debug)]
enum PhaseBoundary {
    Begin,
    /// In steps of the longest axis from the beginning of the profile.
    Within(f64),
    End,
}

impl PhaseBoundaries {
    /// The boundaries of no plan.
    pub(crate) const NONE: Self = Self { accel_end: PhaseBoundary::Begin, cruise_end: PhaseBoundary::Begin };

    pub(crate) fn of(plan: &Profile) -> Self {
        let boundary = |place_steps: f64| {
            if place_steps >= plan.distance_steps() { PhaseBoundary::End } else { PhaseBoundary::Within(place_steps) }
        };
        let (has_accel, has_decel) = (plan.t_accel_s() > NO_RAMP_S, plan.t_decel_s() > NO_RAMP_S);
        Self {
            accel_end: if has_accel { boundary(plan.accel_end_steps()) } else { PhaseBoundary::Begin },
            cruise_end: if has_decel { boundary(plan.cruise_end_steps()) } else { PhaseBoundary::End },
        }
    }
}

/// The ramp by which an axis that turns speeds up again.
#[derive(Clone, Copy, Debug)]
struct WayBack {
    ramp: ConstantAccelRamp,
    clock: Clock,
}

/// Compiles an axis into segments: its steps of a line, from what the line's axes share (a [`TimedPlan`]), or those of a phase of its
/// own.
#[derive(Clone, Debug)]
pub struct AxisCompiler {
    step_range: StepRange,
    /// The number of steps that come before the end of each phase.
    ends: [u32; 3],
    /// Index of the phase of the next step.
    index: usize,
    phase: PhaseSteps,
    /// Steps already compiled.
    done: u32,
    /// The number of steps that come before the first that the phase counts.
    base: u32,
    /// The next step, if it is known from the last segment.
    next: Option<Sample>,
    way_back: Option<WayBack>,
}

/// The steps of one phase.
#[derive(Clone, Debug)]
enum PhaseSteps {
    /// At constant speed or acceleration.
    ConstantAccel(FixedPhase),
    /// At an acceleration that changes.
    Curved(Spans),
}

impl AxisCompiler {
    /// An axis compiler without steps.
    #[must_use]
    pub fn empty() -> Self {
        let step_range = StepRange { stride: 1.0, before: 0, steps: 0, ahead: 0.0, beyond: 0.0 };
        Self {
            step_range,
            ends: [0; 3],
            index: 0,
            phase: PhaseSteps::ConstantAccel(FixedPhase::empty()),
            done: 0,
            base: 0,
            next: None,
            way_back: None,
        }
    }

    /// Begins the steps of an axis of a line. Its segments come from [`next`](Self::next). What belongs to a phase is left, because the first step sets it.
    pub(crate) fn begin(&mut self, step_range: StepRange, timed_plan: &TimedPlan) {
        self.ends = step_range.phase_ends(&timed_plan.boundaries);
        (self.step_range, self.index, self.done, self.base) = (step_range, 0, 0, 0);
    }

    /// Begins a phase of an axis, in ticks of 1/`tick_hz` s; `tick_hz` is above 0. Its segments come
    /// from [`next_of_phase`](Self::next_of_phase). None of them holds steps of both directions.
    pub fn begin_phase(&mut self, counted: &CountedPhase, tick_hz: u32) {
        let clock = Clock::new([counted.phase.begin_s, counted.end_s], tick_hz);
        let (steps, _) = counted.step_counts();
        self.step_range = StepRange { stride: 1.0, before: 0, steps, ahead: 0.0, beyond: 0.0 };
        (self.ends, self.index, self.done, self.base) = ([0, steps, steps], 0, 0, 0);
        if steps == 0 {
            return;
        }
        let timed = TimedStepRange { clock: &clock, step_range: &self.step_range };
        if !is_zero(counted.jerk_steps_s3) {
            self.phase.constant_accel().change_accel(counted, timed);
        } else if is_zero(counted.phase.accel_steps_s2) {
            let ticks_per_step = clock.tick_hz / counted.phase.speed_steps_s.abs();
            let start_ticks = clock.end_ticks - (f64::from(steps) + counted.beyond_end()) * ticks_per_step;
            self.phase.constant_accel().cruise_on(start_ticks, ticks_per_step, timed, steps);
        } else {
            self.begin_ramp(counted.slow_end(), clock);
        }
    }

    /// Begins to slow down, or to speed up if there is no step before that.
    fn begin_ramp(&mut self, slow: SlowEnd, mut clock: Clock) {
        let SlowEnd { speed_steps_s, accel_steps_s2, slows_until_s, speeds_from_s, ahead, beyond, out, back } = slow;
        self.step_range = StepRange { ahead, beyond, ..self.step_range };
        self.ends[1] = out;
        if slows_until_s.to_bits() == speeds_from_s.to_bits() {
            // It turns.
            clock.begin_ticks = speeds_from_s * clock.tick_hz;
            clock.end_ticks = clock.begin_ticks;
        }
        let ramp = ConstantAccelRamp::new(speed_steps_s, accel_steps_s2, clock.tick_hz);
        let timed = TimedStepRange { clock: &clock, step_range: &self.step_range };
        let phase = self.phase.constant_accel();
        if out > 0 {
            phase.decelerate(&ramp, timed, out);
            self.way_back = (back > 0).then_some(WayBack { ramp, clock });
        } else {
            phase.accelerate(&ramp, timed, back);
        }
    }

    /// The number of steps.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.step_range.steps
    }

    /// The number of steps of the whole move that come before.
    #[must_use]
    pub fn steps_before(&self) -> u32 {
        self.step_range.before
    }

    /// The next segment of a line; `None` after the last. `timed_plan` must be the one that it has begun with.
    pub fn next(&mut self, timed_plan: &mut TimedPlan) -> Option<Segment> {
        self.next_on(Some(timed_plan))
    }

    /// The next segment of a phase; `None` after the last.
    pub fn next_of_phase(&mut self) -> Option<Segment> {
        self.next_on(None)
    }

    fn next_on(&mut self, mut timed_plan: Option<&mut TimedPlan>) -> Option<Segment> {
        if self.done == self.ends[2] {
            return None;
        }
        if self.done == 0 || self.ends[self.index] <= self.done {
            while self.ends[self.index] <= self.done {
                self.index += 1;
            }
            self.next = None;
            match timed_plan.as_deref_mut() {
                Some(timed_plan) => self.begin_phase_of_line(timed_plan),
                None => self.go_back(),
            }
        }
        let segment = match &mut self.phase {
            PhaseSteps::ConstantAccel(phase) => {
                let (segment, next) = phase.segment(self.done - self.base, self.next.take());
                self.next = next;
                segment
            }
            PhaseSteps::Curved(spans) => spans.segment(self.done, &self.step_range, timed_plan?),
        };
        self.done += segment.steps();
        Some(segment)
    }

    /// Speeds up from where the axis has turned, if it has.
    fn go_back(&mut self) {
        if self.done > 0
            && let Some(WayBack { ramp, clock }) = &self.way_back
        {
            self.base = self.done;
            let timed = TimedStepRange { clock, step_range: &self.step_range };
            self.phase.constant_accel().accelerate(ramp, timed, self.ends[2] - self.done);
        }
    }

    fn begin_phase_of_line(&mut self, timed_plan: &mut TimedPlan) {
        let end = self.ends[self.index];
        let timed = TimedStepRange { clock: &timed_plan.clock, step_range: &self.step_range };
        match (self.index, &timed_plan.accel, &timed_plan.decel) {
            (0, Some(ramp), _) => self.phase.constant_accel().accelerate(ramp, timed, end),
            (1, ..) => self.phase.constant_accel().cruise(timed_plan, &self.step_range, end),
            (2, _, Some(ramp)) => self.phase.constant_accel().decelerate(ramp, timed, end),
            (index, ..) => self.phase = PhaseSteps::Curved(Spans::new(timed_plan, index != 0, (self.done, end))),
        }
    }
}

impl PhaseSteps {
    /// A phase to be set anew in its place: it is large.
    fn constant_accel(&mut self) -> &mut FixedPhase {
        if let Self::Curved(_) = self {
            *self = Self::ConstantAccel(FixedPhase::empty());
        }
        match self {
            Self::ConstantAccel(phase) => phase,
            Self::Curved(_) => unreachable!("it was set to the other kind"),
        }
    }
}

/// The segments of one axis of a plan, one per call of `next`. It has an [`AxisCompiler`] and a [`TimedPlan`] of its own.
#[derive(Clone, Debug)]
pub struct Segments {
    timed_plan: TimedPlan,
    compiler: AxisCompiler,
}

impl Segments {
    pub(crate) fn new(timed_plan: TimedPlan, compiler: AxisCompiler) -> Self {
        Self { timed_plan, compiler }
    }
}

impl Iterator for Segments {
    type Item = Segment;

    fn next(&mut self) -> Option<Segment> {
        self.compiler.next(&mut self.timed_plan)
    }
}
