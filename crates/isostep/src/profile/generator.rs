//! The step generators of Stoychitch 2018, in addition to the exact one.

use std::iter::once;

use clap::ValueEnum;
use isostep_generators::{Correction, GeneratorError, StepsPerTime, TimePerStep};
use isostep_profile::Limits;

/// A generator of steps from a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Generator {
    /// Each step at the instant of the closed form
    Exact,
    /// Each interval from the last one: Stoychitch 2018, eqs 11-13
    TimePerStep,
    /// The same with the first and last five intervals corrected: eq 14
    TimePerStepCorrected,
    /// Speed and position added up at a fixed rate: eq 17
    StepsPerTime,
}

/// The clocks of the generators, Hz.
#[derive(Clone, Copy, Debug)]
pub struct Clocks {
    /// Clock of the time-per-step generators: their intervals are whole ticks.
    pub tick_hz: u32,
    /// The rate at which the steps-per-time generator adds up speed and position.
    pub service_hz: u32,
}

impl Generator {
    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::TimePerStep => "time-per-step",
            Self::TimePerStepCorrected => "time-per-step-corrected",
            Self::StepsPerTime => "steps-per-time",
        }
    }

    /// The generator's name and the option that sets its clock, for error messages.
    pub fn remedy(self) -> String {
        let clock = if self == Self::StepsPerTime { "--service-hz" } else { "--tick-hz" };
        format!("--generator {} ({clock} sets its clock)", self.name())
    }

    /// The instants of the generator's steps, us, the first at 0. `None` for the exact generator, which has a closed
    /// form.
    pub fn edges_us(self, steps: u32, limits: &Limits, clocks: Clocks) -> Result<Option<Vec<f64>>, GeneratorError> {
        let Clocks { tick_hz, service_hz } = clocks;
        let time_per_step = |correction| TimePerStep::<f64>::plan(steps, limits, correction, tick_hz);
        Ok(match self {
            Self::Exact => None,
            Self::TimePerStep => Some(sums_us(time_per_step(Correction::Without)?, tick_hz)),
            Self::TimePerStepCorrected => Some(sums_us(time_per_step(Correction::With)?, tick_hz)),
            Self::StepsPerTime => Some(sums_us(StepsPerTime::plan(steps, limits, 1, service_hz)?, service_hz)),
        })
    }
}

/// Running sums, in us. They are summed in whole ticks, so only the final quotient is rounded.
fn sums_us(intervals: impl Iterator<Item = u32>, tick_hz: u32) -> Vec<f64> {
    let sums = intervals.scan(0_u64, |sum, ticks| {
        *sum += u64::from(ticks);
        Some(*sum)
    });
    once(0).chain(sums).map(|ticks| ticks as f64 * 1e6 / f64::from(tick_hz)).collect()
}
