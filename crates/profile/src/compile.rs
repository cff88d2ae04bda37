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
//! (`shared_spans`, `spans`). A few float operations a span derive the polynomial from the law itself (`hermite`); the
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
//! By the curved laws a segment costs 6,800 to 28,000 cycles on average, with the float routines in the RP2040's ROM.
//! Most of that is for spans. A span is computed once for all axes and for all its segments, but near standstill it has
//! only a few segments.

mod axis_blend;
mod cubic;
mod curve;
mod fit;
mod fixed_ramp;
mod hermite;
mod phase;
mod root_and_log2;
mod setup;
mod shared_spans;
mod small_accel;
mod spans;
mod timed_plan;
mod u96;

pub(crate) use self::axis_blend::AxisBlend;
use self::cubic::Cubic;
use self::fixed_ramp::Sample;
use self::phase::Phase;
use self::spans::Spans;
pub use self::timed_plan::TimedPlan;
use self::timed_plan::{Clock, ConstantAccelRamp, Cruise, TimedStepRange};
use self::u96::short_fixed;
use crate::fixed::{is_negative, is_zero};
use crate::profile::Profile;
use crate::segment::Segment;
use crate::shaper::Bend;

/// The distance by which a segment's quadratic may deviate from the closed form, ticks. Rounding to a whole tick adds up to half.
pub const FIT_ERROR_MAX_TICKS: f64 = 0.125;
/// How far it may deviate instead, s, if that is more and the segment would otherwise last less than [`BRIEF_S`]: a
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
    pub(crate) fn phase_ends(&self, bounds: &PhaseBounds) -> [u32; 3] {
        let Self { stride, steps, ahead, .. } = *self;
        let steps_before = |bound: PhaseBound| match bound {
            PhaseBound::Begin => 0,
            PhaseBound::Within(place_steps) => {
                // Dividing by 1, and adding 0, would be as slow as by any number.
                let own_steps = if self.is_longest() { place_steps } else { place_steps / stride };
                nearest(if is_zero(ahead) { own_steps } else { own_steps + ahead }).min(steps)
            }
            PhaseBound::End => steps,
        };
        let accel_end = steps_before(bounds.accel_end);
        [accel_end, steps_before(bounds.cruise_end).max(accel_end), steps]
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
pub(crate) struct PhaseBounds {
    accel_end: PhaseBound,
    cruise_end: PhaseBound,
}

/// A place on a profile.
#[derive(Clone, Copy, Debug)]
enum PhaseBound {
    Begin,
    /// In steps of the longest axis from the beginning of the profile.
    Within(f64),
    End,
}

impl PhaseBounds {
    /// The bounds of no plan.
    pub(crate) const NONE: Self = Self { accel_end: PhaseBound::Begin, cruise_end: PhaseBound::Begin };

    pub(crate) fn of(plan: &Profile) -> Self {
        let bound = |place_steps: f64| {
            if place_steps >= plan.distance_steps() { PhaseBound::End } else { PhaseBound::Within(place_steps) }
        };
        let (has_accel, has_decel) = (plan.t_accel_s() > NO_RAMP_S, plan.t_decel_s() > NO_RAMP_S);
        Self {
            accel_end: if has_accel { bound(plan.accel_end_steps()) } else { PhaseBound::Begin },
            cruise_end: if has_decel { bound(plan.cruise_end_steps()) } else { PhaseBound::End },
        }
    }
}

/// The values of an axis of a blend where its phases begin.
#[derive(Clone, Copy, Debug)]
struct BlendPhases {
    ramp: ConstantAccelRamp,
    /// Begins where it speeds up, and ends where it has slowed down.
    clock: Clock,
    approach: Option<Cruise>,
    is_turned: bool,
    /// If the acceleration changes, this is all of it.
    cubic: Option<Cubic>,
}

/// Compiles one axis of a [`TimedPlan`] into segments.
///
/// Step k of the axis (k = 1 to `steps`) is due when the longest axis has covered (k - 1/2)/`steps` of the distance.
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
    blend: Option<BlendPhases>,
}

/// The steps of one phase.
#[derive(Clone, Debug)]
enum PhaseSteps {
    /// At constant speed or acceleration.
    ConstantAccel(Phase),
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
            phase: PhaseSteps::ConstantAccel(Phase::empty()),
            done: 0,
            base: 0,
            next: None,
            blend: None,
        }
    }

    /// Begins another step range. What belongs to a phase is left, because the first step sets it.
    pub(crate) fn begin(&mut self, step_range: StepRange, timed_plan: &TimedPlan) {
        self.ends = step_range.phase_ends(&timed_plan.bounds);
        (self.step_range, self.index, self.done, self.base, self.blend) = (step_range, 0, 0, 0, None);
    }

    /// Begins an axis of a blend. `approached` is how far it is beyond its last step where the approach ends, steps.
    pub(crate) fn begin_blend(&mut self, axis: &AxisBlend, approached: f64, timed_plan: &TimedPlan) {
        self.begin_bent(axis, approached, timed_plan.clock);
    }

    /// Begins a bend of shaped motion, in ticks of 1/`tick_hz` s; `tick_hz` is above 0. Its segments come from
    /// [`next_of_bend`](Self::next_of_bend).
    pub fn begin_bend(&mut self, bend: &Bend, tick_hz: u32) {
        let ends_s = [bend.leg.begin_s, bend.end_s];
        let clock = Clock::new(ends_s, tick_hz);
        let [begin, turn, end] = bend.counts;
        let from_steps_s = bend.leg.speed_steps_s;
        let places_steps = [bend.leg.place_steps, bend.end_place_steps];
        if !is_zero(bend.jerk_steps_s3) {
            return self.begin_cubic(bend, clock);
        }
        if is_zero(bend.leg.accel_steps_s2) {
            // All of it is an approach, which ends where the bend does.
            let axis = AxisBlend::even(from_steps_s, end.abs_diff(begin), ends_s[1]);
            let beyond = places_steps[1] - f64::from(end);
            let approached = if is_negative(from_steps_s) { -beyond } else { beyond };
            return self.begin_bent(&axis, approached, Clock { begin_ticks: clock.end_ticks, ..clock });
        }
        let speeds_steps_s = [from_steps_s, bend.end_speed_steps_s];
        let accel = bend.leg.accel_steps_s2.abs();
        let axis = AxisBlend::new(speeds_steps_s, places_steps, accel, [begin, begin, turn, end], ends_s);
        self.begin_bent(&axis, 0.0, clock);
    }

    /// Begins a bend whose acceleration changes.
    #[inline(never)]
    fn begin_cubic(&mut self, bend: &Bend, clock: Clock) {
        let [begin, .., end] = bend.counts;
        let along = |x: f64| if end < begin { -x } else { x };
        let (steps, ahead) = (end.abs_diff(begin), along(bend.leg.place_steps - f64::from(begin)));
        let cubic = Cubic {
            speed_steps_s: along(bend.leg.speed_steps_s),
            accel_steps_s2: along(bend.leg.accel_steps_s2),
            jerk_steps_s3: along(bend.jerk_steps_s3),
            lasts_s: bend.end_s - bend.leg.begin_s,
            ahead,
            tick_hz: clock.tick_hz,
            point: 0,
        };
        self.step_range = StepRange { stride: 1.0, before: 0, steps, ahead, beyond: 0.0 };
        (self.ends, self.index, self.done, self.base) = ([0, 0, steps], 0, 0, 0);
        let ramp = ConstantAccelRamp::NONE;
        self.blend = Some(BlendPhases { ramp, clock, approach: None, is_turned: false, cubic: Some(cubic) });
    }

    fn begin_bent(&mut self, axis: &AxisBlend, approached: f64, mut clock: Clock) {
        let AxisBlend { slow_steps_s, accel_steps_s2, begin_s, end_s, ahead, beyond, approach, out, back, .. } = *axis;
        let (turn, steps) = (approach + out, approach + out + back);
        self.step_range = StepRange { stride: 1.0, before: 0, steps, ahead, beyond };
        (self.ends, self.index, self.done, self.base) = ([approach, turn, steps], 0, 0, 0);
        let approach = (approach > 0).then(|| {
            let ticks_per_step = clock.tick_hz / axis.from_steps_s;
            Cruise {
                ticks_per_step,
                start_ticks: clock.begin_ticks - (f64::from(approach) + approached) * ticks_per_step,
            }
        });
        if axis.is_turned {
            (clock.begin_ticks, clock.end_ticks) = (begin_s * clock.tick_hz, end_s * clock.tick_hz);
        }
        let ramp = if out + back > 0 {
            ConstantAccelRamp::new(slow_steps_s, accel_steps_s2, clock.tick_hz)
        } else {
            ConstantAccelRamp::NONE
        };
        self.blend = Some(BlendPhases { ramp, clock, approach, is_turned: axis.is_turned, cubic: None });
    }

    /// After how many of its steps the axis turns; if it does not turn, after all of them. No segment holds steps of both
    /// directions.
    #[must_use]
    pub fn turns_after(&self) -> u32 {
        match self.blend {
            Some(BlendPhases { is_turned: true, .. }) if self.ends[1] > 0 => self.ends[1],
            _ => self.step_range.steps,
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

    /// The next segment; `None` after the last. `timed_plan` must be the one that it has begun with.
    pub fn next(&mut self, timed_plan: &mut TimedPlan) -> Option<Segment> {
        self.next_on(Some(timed_plan))
    }

    /// The next segment of a bend; `None` after the last.
    pub fn next_of_bend(&mut self) -> Option<Segment> {
        self.next_on(None)
    }

    /// Only a line needs a timed plan.
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
                Some(timed_plan) if self.blend.is_none() => self.begin_phase(timed_plan),
                _ => self.begin_blend_phase(),
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

    fn begin_blend_phase(&mut self) {
        let end = self.ends[self.index] - self.done;
        let Some(BlendPhases { ramp, clock, approach, cubic, .. }) = &self.blend else { return };
        let timed = TimedStepRange { clock, step_range: &self.step_range };
        self.base = self.done;
        let phase = self.phase.constant_accel();
        if let Some(cubic) = cubic {
            return phase.change_accel(cubic, timed, end);
        }
        match (self.index, approach) {
            (0, Some(cruise)) => phase.cruise_on(cruise.start_ticks, cruise.ticks_per_step, timed, end),
            (2, _) => phase.accelerate(ramp, timed, end),
            _ => phase.decelerate(ramp, timed, end),
        }
    }

    fn begin_phase(&mut self, timed_plan: &mut TimedPlan) {
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
    fn constant_accel(&mut self) -> &mut Phase {
        if let Self::Curved(_) = self {
            *self = Self::ConstantAccel(Phase::empty());
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
