//! The mathematics of a move, in closed form.
//!
//! A move has **one** profile: the displacement of its longest axis over time. Every axis computes its step instants
//! from that profile, so all axes accelerate, cruise and decelerate over the same intervals.
//!
//! The stages, one file each:
//!
//! 1. [`Limits`]: what an axis may do, checked once.
//! 2. [`Profile`]: planned from limits, distance, end speeds, an [`IntervalSplit`] and a [`SpeedProfile`].
//! 3. [`SyncMove`]: the limits of several axes are scaled onto the longest axis; each axis keeps its signed step count.
//!    A [`chain`] plans moves that follow each other without a stop; its plans are `SyncMove`s, too.
//! 4. [`shaper`]: an axis as a weighted sum of its motion at several instants, if it has a shaper.
//! 5. [`Segments`]: an axis's step instants as short [`Segment`]s, which are replayed by additions alone. [`TimedPlan`]
//!    and [`AxisCompiler`] do the same for several axes, and compute only once what the axes have in common. Axes of blends and
//!    shaped axes have nothing in common: each is compiled [phase](CountedPhase) by phase.
//!
//! This crate knows no clock, no pin and no executor. It allocates nothing and cannot await. Distances are in steps,
//! times in seconds, speeds in steps/s, accelerations in steps/s². Only segments are in ticks, at a rate that the
//! caller chooses.
//!
//! ```
//! use isostep_profile::{IntervalSplit, Limits, SpeedProfile, SyncMove};
//!
//! let limits = Limits {
//!     start_speed_steps_s: 0.0,
//!     top_speed_steps_s: 2_400.0,
//!     accel_steps_s2: 2_500.0,
//!     decel_steps_s2: 2_500.0,
//!     jerk_steps_s3: 50_000.0,
//! };
//! let plan = SyncMove::plan([20_000, -5_000, 0], &[limits; 3], IntervalSplit::Fastest, SpeedProfile::SCurve, None)?;
//! let y_last_s = plan.step_time_s(1, 5_000);
//! assert!(y_last_s < plan.profile.duration_s());
//!
//! // The same instants, in microseconds, by additions only.
//! let y_ticks = plan.segments(1, 1_000_000).flat_map(|segment| segment.ticks());
//! assert_eq!(y_ticks.last(), Some((y_last_s * 1e6).round() as u64));
//! # Ok::<(), isostep_profile::PlanError>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]

mod blend;
pub mod chain;
mod compile;
mod fixed;
mod interval_split;
mod limits;
mod newton;
mod phase;
mod plan;
mod profile;
mod ramp;
mod segment;
pub mod shaper;
mod speed_profile;
mod square_root;
mod sync;

pub use blend::Blend;
pub use compile::{
    AxisCompiler, BRIEF_S, FIT_ERROR_MAX_S, FIT_ERROR_MAX_TICKS, Segments, TimedPlan, fit_error_max_ticks,
};
pub use interval_split::IntervalSplit;
pub use limits::{ACCEL_MAX_STEPS_S2, LimitError, Limits, SPEED_MAX_STEPS_S, SPEED_MIN_STEPS_S};
pub use phase::{AxisPhase, CountedPhase};
pub use profile::{DURATION_MAX_S, Profile, ProfileError, StepCounts};
pub use segment::{Intervals, Segment, Ticks};
pub use speed_profile::SpeedProfile;
pub use sync::{OFFSET_PARTS, PlanError, SyncMove};

/// Runs the examples of the README as doc tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
