//! The work that the benchmark firmware times. It is a library, so that a host can do the same work and compare the results.
//!
//! # What the firmware prints
//! Lines of `name,cycles,count,checksum` on UART0 (GP0, 115200 8N1), then `end`. `cycles` are cycles of the core's
//! clock, `count` is the number of results they made, and `checksum` is the [`Checksum`] of those results.
//!
//! | name | results | cycles |
//! |---|---|---|
//! | `plan.SPEED_PROFILE.CASE` | each of [`PLAN_CASES`], planned | of the one plan |
//! | `begin.SPEED_PROFILE.CASE` | the first segment of each of its axes, including what their ramp needs | of all three |
//! | `compile.accel`, `.cruise`, `.decel` | steps of the segments of [`ramp`] that begin in that phase | of all of them |
//! | `compile.accel.max` and so on | the same | of the slowest |
//! | `compile.SPEED_PROFILE.accel` and so on | the same for [`speed_profile_ramp`], also with `.max` | the same |
//! | `compile.SPEED_PROFILE.first` | the segments of the first [`FIRST_STEPS`] steps, of one axis from rest | of all of them |
//! | `compile.lead` | ticks of motion (here the count) | of the segment with the fewest ticks per cycle |
//! | `compile.lead.queue` | the same | of the [`QUEUE_SEGMENTS`] in a row with the fewest |
//! | `compile.SPEED_PROFILE.lead`, `compile.SPEED_PROFILE.lead.queue` | the same | the same |
//! | `flow.CASE.STAGE` | moves of [`FLOW_CASES`], each of which passes that [`Stage`] | of all of them |
//! | `float.CASE` | operations of each of [`FLOAT_CASES`] | of all of them |
//! | [`FLOAT_AMONG_DIVISION`] | divisions, each while the chip's divider is in use | of all of them |
//! | `fill` | the words of [`Intervals::fill`], from RAM, [`BLOCK_WORDS`] at a time | of all of them |
//! | `fill.SPEED_PROFILE` | the same for [`speed_profile_ramp`] | of all of them |
//! | each of [`generators`] | its intervals, [`BLOCK_WORDS`] at a time | of all of them |
//! | each of these, `.max` | the same | of the slowest interval |
//!
//! [`Intervals::fill`]: isostep_profile::Intervals::fill
#![no_std]
#![forbid(unsafe_code)]

mod floats;
mod flow;
mod shaped;

pub use floats::{FLOAT_AMONG_DIVISION, FLOAT_CASES, FLOAT_DIVIDE, FLOAT_PAIRS, FloatCase, float_pairs, floats};
pub use flow::{
    Checksums, FLOW_CASES, FlowCase, MOVE_MM, Path, START_MM, STEPS_PER_MM, Stage, TIMED_MOVES, Text, Timer, Untimed,
    flow,
};
use isostep_generators::{Avr446, Correction, GeneratorError, StepsPerTime, TimePerStep};
use isostep_profile::{IntervalSplit, Limits, PlanError, Segment, SpeedProfile, SyncMove};

/// Tick rate: the chip's default clock.
pub const TICK_HZ: u32 = 125_000_000;
/// Axes of the machine.
pub const AXES: usize = 3;
/// Intervals that are written between two readings of the clock.
pub const BLOCK_WORDS: usize = 256;
/// Segments that an axis has queued. A queue this long makes up for a single short segment.
pub const QUEUE_SEGMENTS: usize = 32;
/// Steps of the ramp: 50,000 to accelerate, 20,000 to cruise, 50,000 to decelerate.
pub const STEPS: u32 = 120_000;
/// The segments of this many first steps of a speed profile's ramp are timed separately.
pub const FIRST_STEPS: u32 = 8;
/// Ticks between the sums of the generator "steps per time": one step at the top speed. With more it could not reach
/// that speed.
const SERVICE_TICKS: u32 = 125;

/// Limits of every axis: those of the papers' ramp at a hundred times their speed.
pub const LIMITS: Limits = Limits {
    start_speed_steps_s: 0.0,
    top_speed_steps_s: 1_000_000.0,
    accel_steps_s2: 10_000_000.0,
    decel_steps_s2: 10_000_000.0,
    jerk_steps_s3: f64::INFINITY,
};

/// For the methods that cannot start from rest. The start speed is what one step from rest reaches, sqrt(2 a), rounded
/// up.
const MOVING_LIMITS: Limits = Limits { start_speed_steps_s: 4_473.0, ..LIMITS };

/// A move of three axes that is planned.
#[derive(Clone, Copy, Debug)]
pub struct PlanCase {
    /// The name in the firmware's output lines.
    pub name: &'static str,
    /// Steps of each axis.
    pub steps: [i32; 3],
    /// The split of the move's duration.
    pub interval_split: IntervalSplit,
}

/// Each interval split, with a cruise and without one.
pub const PLAN_CASES: [PlanCase; 4] = [
    PlanCase { name: "fastest", steps: [120_000, -70_001, 33_333], interval_split: IntervalSplit::Fastest },
    PlanCase { name: "thirds", steps: [120_000, -70_001, 33_333], interval_split: IntervalSplit::Thirds },
    PlanCase { name: "short.fastest", steps: [4_000, -2_801, 1_203], interval_split: IntervalSplit::Fastest },
    PlanCase { name: "short.thirds", steps: [4_000, -2_801, 1_203], interval_split: IntervalSplit::Thirds },
];

/// Limits of every axis under `speed_profile`. The start speed is one whose ramps leave room for a cruise in [`STEPS`]. The jerk
/// reaches the acceleration in 10 ms.
#[must_use]
pub fn speed_profile_limits(speed_profile: SpeedProfile) -> Limits {
    let start_speed_steps_s = if speed_profile.is_over_displacement() { 5_000.0 } else { 0.0 };
    Limits { start_speed_steps_s, top_speed_steps_s: 500_000.0, jerk_steps_s3: 1e9, ..LIMITS }
}

/// Plans `case` under `speed_profile`.
///
/// # Errors
/// None: the limits are valid constants.
pub fn plan(speed_profile: SpeedProfile, case: &PlanCase) -> Result<SyncMove<3>, PlanError> {
    SyncMove::plan(case.steps, &[speed_profile_limits(speed_profile); 3], case.interval_split, speed_profile, None)
}

/// Plans one axis through ramps of `speed_profile`.
///
/// # Errors
/// None: the limits are valid constants.
pub fn speed_profile_ramp(speed_profile: SpeedProfile) -> Result<SyncMove<1>, PlanError> {
    SyncMove::plan([STEPS as i32], &[speed_profile_limits(speed_profile)], IntervalSplit::Fastest, speed_profile, None)
}

/// Plans one axis through the ramp.
///
/// # Errors
/// None: the limits are valid constants.
pub fn ramp() -> Result<SyncMove<1>, PlanError> {
    SyncMove::plan([STEPS as i32], &[LIMITS], IntervalSplit::Fastest, SpeedProfile::Trapezoid, None)
}

/// The phases of [`ramp`] with the names in the firmware's output lines, and their steps.
#[must_use]
pub fn phases(ramp: &SyncMove<1>) -> [(&'static str, u32); 3] {
    let counts = ramp.profile.step_counts();
    [("accel", counts.accel), ("cruise", counts.cruise), ("decel", counts.decel)]
}

/// The first segment of each axis of `plan`, including the computation of what its ramp needs.
#[must_use]
pub fn first_segments(plan: &SyncMove<3>) -> [Option<Segment>; 3] {
    [0, 1, 2].map(|axis| plan.segments(axis, TICK_HZ).next())
}

/// A checksum of a plan, over representative values of it.
#[must_use]
pub fn plan_checksum(plan: &SyncMove<3>) -> Checksum {
    let mut checksum = Checksum::default();
    checksum.add((plan.profile.duration_s() * f64::from(TICK_HZ)) as u32);
    checksum
}

/// A checksum of first segments.
#[must_use]
pub fn segments_checksum(segments: [Option<Segment>; 3]) -> Checksum {
    let mut checksum = Checksum::default();
    for segment in segments.into_iter().flatten() {
        checksum.add(segment.steps());
        checksum.add(segment.last_ticks() as u32);
    }
    checksum
}

/// A generator that is timed.
#[derive(Clone, Copy, Debug)]
pub struct Peer {
    /// The name in the firmware's output lines.
    pub name: &'static str,
    /// The limits that it was planned from.
    pub limits: Limits,
    /// The figure in the closed form that its intervals are compared with.
    pub stands_for: StandsFor,
}

/// The quantity of the closed form that interval i, from 0, is compared with.
#[derive(Clone, Copy, Debug)]
pub enum StandsFor {
    /// The speed at displacement i.
    SpeedAtStep,
    /// The time between the displacements of two consecutive steps; the first step is at `first_steps`.
    TimeBetweenSteps {
        /// Displacement of the first step, steps.
        first_steps: f64,
    },
}

/// Visits each generator in turn.
pub trait Visitor {
    /// Receives the `intervals` of `peer`, ticks.
    fn visit<I: Iterator<Item = u32> + Clone>(&mut self, peer: Peer, intervals: I);
}

/// Passes every generator over the ramp to `visitor`.
///
/// # Errors
/// None: the limits are valid constants.
pub fn generators(visitor: &mut impl Visitor) -> Result<(), GeneratorError> {
    let moving = |name, stands_for| Peer { name, limits: MOVING_LIMITS, stands_for };
    let at_step = |name| moving(name, StandsFor::SpeedAtStep);
    let without = Correction::Without;
    visitor.visit(at_step("time-per-step.f32"), TimePerStep::<f32>::plan(STEPS, &MOVING_LIMITS, without, TICK_HZ)?);
    visitor.visit(at_step("time-per-step.f64"), TimePerStep::<f64>::plan(STEPS, &MOVING_LIMITS, without, TICK_HZ)?);
    let corrected = TimePerStep::<f64>::plan(STEPS, &MOVING_LIMITS, Correction::With, TICK_HZ)?;
    visitor.visit(at_step("time-per-step.f64.corrected"), corrected);
    let one = StandsFor::TimeBetweenSteps { first_steps: 1.0 };
    visitor.visit(moving("steps-per-time", one), StepsPerTime::plan(STEPS, &MOVING_LIMITS, SERVICE_TICKS, TICK_HZ)?);
    let zero = StandsFor::TimeBetweenSteps { first_steps: 0.0 };
    let from_rest = Peer { name: "avr446", limits: LIMITS, stands_for: zero };
    visitor.visit(from_rest, Avr446::plan(STEPS, &LIMITS, TICK_HZ)?);
    Ok(())
}

/// A checksum that depends on every word and on their order (FNV-1a, one word at a time).
#[derive(Clone, Copy, Debug)]
pub struct Checksum(u32);

impl Checksum {
    /// Adds the next word.
    pub fn add(&mut self, word: u32) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0100_0193);
    }

    /// The checksum of all words so far.
    #[must_use]
    pub fn value(self) -> u32 {
        self.0
    }
}

impl Default for Checksum {
    fn default() -> Self {
        Self(0x811C_9DC5)
    }
}
