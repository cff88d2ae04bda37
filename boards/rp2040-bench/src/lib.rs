//! What the benchmark firmware times, so that a host can do the same work and hold its results against the chip's.
//!
//! # What the firmware prints
//! Lines of `name,cycles,count,checksum` on UART0 (GP0, 115200 8N1), then `end`: cycles of the core's clock, how many
//! results they made, and the [`Checksum`] of those results.
//!
//! | name | results | cycles |
//! |---|---|---|
//! | `plan.LAW.CASE` | each of [`PLAN_CASES`] planned | of the one plan |
//! | `begin.LAW.CASE` | the first segment of each of its axes, which compute what their ramp needs | of all three |
//! | `compile.accel`, `.cruise`, `.decel` | steps of the segments that begin there, of [`ramp`] | of all of them |
//! | `compile.accel.max` and so on | the same | of the slowest |
//! | `compile.LAW.accel` and so on | the same, and their `.max`, of [`law_ramp`] | the same |
//! | `compile.LAW.first` | the segments until [`FIRST_STEPS`] have left, of one axis from the start | of all of them |
//! | `compile.lead` | ticks of motion, here the count | of the segment that has fewest ticks a cycle |
//! | `compile.lead.queue` | the same | of the [`QUEUE_SEGMENTS`] in a row that have fewest |
//! | `compile.LAW.lead`, `compile.LAW.lead.queue` | the same | the same |
//! | `flow.CASE.STAGE` | moves of [`FLOW_CASES`], each of which does that [`Stage`] | of all of them |
//! | `fill` | the words of [`Intervals::fill`], from RAM, into [`BLOCK_WORDS`] at a time | of all of them |
//! | `fill.LAW` | the same, of [`law_ramp`] | of all of them |
//! | each of [`generators`] | its intervals, [`BLOCK_WORDS`] at a time | of all of them |
//! | each of these, `.max` | the same | of the slowest interval |
//!
//! [`Intervals::fill`]: isostep_profile::Intervals::fill
#![no_std]
#![forbid(unsafe_code)]

mod flow;

pub use flow::{
    Checksums, FLOW_CASES, FlowCase, MOVE_MM, Path, START_MM, STEPS_PER_MM, Stage, TIMED_MOVES, Text, Timer, Untimed,
    flow,
};
use isostep_generators::{Avr446, Correction, GeneratorError, StepsPerTime, TimePerStep};
use isostep_profile::{IntervalLaw, Limits, PlanError, Segment, SpeedLaw, SyncMove};

/// Rate of the ticks: the chip's stock clock.
pub const TICK_HZ: u32 = 125_000_000;
/// Of the machine.
pub const AXES: usize = 3;
/// Intervals written between two looks at the clock.
pub const BLOCK_WORDS: usize = 256;
/// Segments that an axis has queued, behind which a short one hides.
pub const QUEUE_SEGMENTS: usize = 32;
/// Of the ramp: 50,000 to accelerate, 20,000 to cruise, 50,000 to decelerate.
pub const STEPS: u32 = 120_000;
/// Of a law's ramps, the steps whose segments are counted as its first.
pub const FIRST_STEPS: u32 = 8;
/// "Steps per time" sums once a step at the top speed: slower, and it could not reach it.
const SERVICE_TICKS: u32 = 125;

/// Of every axis: the papers' ramp at a hundred times their speed.
pub const LIMITS: Limits = Limits {
    start_speed_steps_s: 0.0,
    top_speed_steps_s: 1_000_000.0,
    accel_steps_s2: 10_000_000.0,
    decel_steps_s2: 10_000_000.0,
    jerk_steps_s3: f64::INFINITY,
};

/// For the methods that cannot start from rest: what one step from rest gains, sqrt(2 a), rounded up.
const MOVING_LIMITS: Limits = Limits { start_speed_steps_s: 4_473.0, ..LIMITS };

/// A move of three axes that is planned.
#[derive(Clone, Copy, Debug)]
pub struct PlanCase {
    /// In the firmware's lines.
    pub name: &'static str,
    /// Of the axes.
    pub steps: [i32; 3],
    /// How its time is split.
    pub interval_law: IntervalLaw,
}

/// With a cruise and without, either way.
pub const PLAN_CASES: [PlanCase; 4] = [
    PlanCase { name: "fastest", steps: [120_000, -70_001, 33_333], interval_law: IntervalLaw::Fastest },
    PlanCase { name: "thirds", steps: [120_000, -70_001, 33_333], interval_law: IntervalLaw::Thirds },
    PlanCase { name: "short.fastest", steps: [4_000, -2_801, 1_203], interval_law: IntervalLaw::Fastest },
    PlanCase { name: "short.thirds", steps: [4_000, -2_801, 1_203], interval_law: IntervalLaw::Thirds },
];

/// Of every axis under `law`: of the speed that its ramps need no more than a cruise leaves of [`STEPS`], and of a jerk
/// that reaches the acceleration in 10 ms.
#[must_use]
pub fn law_limits(law: SpeedLaw) -> Limits {
    let start_speed_steps_s = if law.is_over_displacement() { 5_000.0 } else { 0.0 };
    Limits { start_speed_steps_s, top_speed_steps_s: 500_000.0, jerk_steps_s3: 1e9, ..LIMITS }
}

/// `case` under `law`.
///
/// # Errors
/// None: the limits are constants that work.
pub fn plan(law: SpeedLaw, case: &PlanCase) -> Result<SyncMove<3>, PlanError> {
    SyncMove::plan(case.steps, &[law_limits(law); 3], case.interval_law, law, None)
}

/// One axis through ramps of `law`.
///
/// # Errors
/// None: the limits are constants that work.
pub fn law_ramp(law: SpeedLaw) -> Result<SyncMove<1>, PlanError> {
    SyncMove::plan([STEPS as i32], &[law_limits(law)], IntervalLaw::Fastest, law, None)
}

/// One axis through the ramp.
///
/// # Errors
/// None: the limits are constants that work.
pub fn ramp() -> Result<SyncMove<1>, PlanError> {
    SyncMove::plan([STEPS as i32], &[LIMITS], IntervalLaw::Fastest, SpeedLaw::Trapezoid, None)
}

/// The phases of [`ramp`] and their steps, as the firmware's lines name them.
#[must_use]
pub fn phases(ramp: &SyncMove<1>) -> [(&'static str, u32); 3] {
    let counts = ramp.profile.step_counts();
    [("accel", counts.accel), ("cruise", counts.cruise), ("decel", counts.decel)]
}

/// The first segment of each axis of `plan`, which computes what its ramp needs.
#[must_use]
pub fn first_segments(plan: &SyncMove<3>) -> [Option<Segment>; 3] {
    [0, 1, 2].map(|axis| plan.segments(axis, TICK_HZ).next())
}

/// What a plan comes to: as much of it as a checksum needs.
#[must_use]
pub fn plan_checksum(plan: &SyncMove<3>) -> Checksum {
    let mut checksum = Checksum::default();
    checksum.add((plan.profile.duration_s() * f64::from(TICK_HZ)) as u32);
    checksum
}

/// What first segments come to.
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
    /// In the firmware's lines.
    pub name: &'static str,
    /// What it was planned from.
    pub limits: Limits,
    /// Which speed of the closed form its intervals stand for.
    pub stands_for: StandsFor,
}

/// What interval i, from 0, is to be held against.
#[derive(Clone, Copy, Debug)]
pub enum StandsFor {
    /// The speed at displacement i.
    SpeedAtStep,
    /// The time from one step's displacement to the next's; the first step is at `first_steps`.
    TimeBetweenSteps {
        /// Displacement of the first step, steps.
        first_steps: f64,
    },
}

/// Takes each generator in turn.
pub trait Visitor {
    /// `intervals` of `peer`, ticks.
    fn visit<I: Iterator<Item = u32> + Clone>(&mut self, peer: Peer, intervals: I);
}

/// Shows `visitor` every generator over the ramp.
///
/// # Errors
/// None: the limits are constants that work.
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

/// Depends on every word and on their order (FNV-1a, a word at a time).
#[derive(Clone, Copy, Debug)]
pub struct Checksum(u32);

impl Checksum {
    /// Takes in the next word.
    pub fn add(&mut self, word: u32) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0100_0193);
    }

    /// Of all words so far.
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
