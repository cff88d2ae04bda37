//! Step generators of the literature, written from their equations. [`Segments`](isostep_profile::Segments) is compared
//! with them.
//!
//! | generator | method | arithmetic a step |
//! |---|---|---|
//! | [`TimePerStep`] | Stoychitch 2018, eqs 11-14: the next interval from the last | two products, a sum and a quotient of floats |
//! | [`StepsPerTime`] | Stoychitch 2018, eq 17: speed and position summed at a fixed rate | two sums and a comparison at that rate |
//! | [`Avr446`] | Austin (2005) and Atmel's AVR446: the square root's series | one integer division |
//!
//! Each is planned from the steps of one axis and its [`Limits`]. It begins and ends at the start speed, and is an
//! iterator over the intervals between its steps, in ticks: one fewer than there are steps. All of them carry a rounded
//! interval or sum from step to step, so a rounding error is never made up for.
//!
//! There are also two whole methods, with inputs of their own and without limits on acceleration:
//!
//! | method | exact | as its paper makes it |
//! |---|---|---|
//! | Fonseca-Campos 2023, eqs 5-8: frequency by a [`FrequencyRamp`] | [`FrequencyProfile`] | [`TruncatedProfile`], in even microseconds |
//! | Forero 2023, eqs 8-14: ramps in 20 stairs | [`Staircase`] | [`TimedStaircase`], on timers with whole preloads |
#![no_std]
#![forbid(unsafe_code)]

mod avr446;
mod error;
mod float;
mod frequency_error;
mod frequency_profile;
mod frequency_ramp;
mod staircase;
mod steps_per_time;
mod time_per_step;
mod timed_staircase;
mod timer_preload;
mod truncated_profile;

pub use avr446::Avr446;
pub use error::GeneratorError;
pub use float::Float;
pub use frequency_error::FrequencyError;
pub use frequency_profile::{FrequencyEdges, FrequencyProfile, PERIOD_MAX_US, PERIOD_MIN_US};
pub use frequency_ramp::FrequencyRamp;
pub use staircase::{Staircase, StaircaseError, Tread};
pub use steps_per_time::StepsPerTime;
pub use time_per_step::{Correction, TimePerStep};
pub use timed_staircase::{Preload, TimedStaircase, TimedTread};
pub use timer_preload::{PreloadTimer, TimerError};
pub use truncated_profile::TruncatedProfile;

use isostep_profile::{IntervalSplit, Limits, Profile, SpeedProfile};

/// The phases of a move of one axis, in steps (Stoychitch 2018, section 2). Every generator here begins with them.
fn profile(steps: u32, limits: &Limits) -> Result<Profile, GeneratorError> {
    let start = limits.start_speed_steps_s;
    Profile::plan(f64::from(steps), start, start, limits, IntervalSplit::Fastest, SpeedProfile::Trapezoid)
        .map_err(GeneratorError::Profile)
}

/// Refuses a top speed above `max_steps_s`, the fastest that the generator's clock can resolve.
fn check_top_speed(limits: &Limits, max_steps_s: f64) -> Result<(), GeneratorError> {
    let asked = limits.top_speed_steps_s;
    if asked <= max_steps_s { Ok(()) } else { Err(GeneratorError::TopSpeed { asked, max: max_steps_s }) }
}

/// Refuses a start speed outside `min_steps_s` to the top speed.
fn check_start_speed(limits: &Limits, min_steps_s: f64) -> Result<(), GeneratorError> {
    let (asked, max) = (limits.start_speed_steps_s, limits.top_speed_steps_s);
    if asked >= min_steps_s { Ok(()) } else { Err(GeneratorError::StartSpeed { asked, min: min_steps_s, max }) }
}
