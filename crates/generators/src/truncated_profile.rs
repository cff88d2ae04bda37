//! Fonseca-Campos's profiles as its program makes them: with half periods in whole microseconds.

use libm::floor;

use super::frequency_profile::{check_fit, check_periods};
use super::{FrequencyError, FrequencyProfile, FrequencyRamp};
use isostep_profile::StepCounts;

/// Shortest period whose half is still a microsecond, us.
const TRUNCATED_PERIOD_MIN_US: f64 = 2.0;
/// "The program assumes that if N < 20, the motor rotates at omega_min" (Fonseca-Campos 2023, section V).
const RAMP_FROM_STEPS: u32 = 20;
/// Tolerance for rounding: far above the rounding of a few products, far below any distance of a period from a whole
/// number.
const ROUNDING: f64 = 1e-12;

/// A move as Fonseca-Campos's program makes it (section II.B, steps 4 and 5): STEP is high for half a period and low
/// for half a period, and each half is cut down to whole microseconds. So a period is an even number of microseconds,
/// up to 2 us short, and the whole move runs ahead of its profile.
///
/// A move of fewer than 20 steps has no ramps: all its periods are tau_max.
///
/// The program cuts twice, int(1e6/f) and then int(period/2), which is int(1e6/(2 f)). Here the exact number is cut,
/// not its rounded image: a period of 300 us that floats make 299.99999999999994 stays 300. The program's own floats
/// have 24 bits on one of its boards; what they make of such a period is not reproduced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruncatedProfile {
    steps: u32,
    /// Half period of a move without ramps, us: half of tau_max.
    short_half_us: u32,
    /// The profile of a move that is long enough for ramps.
    ramped: Option<FrequencyProfile>,
}

impl TruncatedProfile {
    /// Plans as [`FrequencyProfile::plan`] does. Periods are at least 2 us. Below 20 steps p_N is not used and may be 0
    /// or 1, because a fifth of so few steps may be as little.
    ///
    /// # Errors
    /// The value and the bound: N = 0, 2 p_N > N, p_N < 2 from 20 steps on, a period out of range, tau_min above
    /// tau_max.
    pub fn plan(
        frequency_ramp: FrequencyRamp,
        steps: u32,
        ramp_steps: u32,
        max_period_us: f64,
        min_period_us: f64,
    ) -> Result<Self, FrequencyError> {
        check_periods(max_period_us, min_period_us, TRUNCATED_PERIOD_MIN_US)?;
        check_fit(steps, ramp_steps)?;
        let plan = || FrequencyProfile::plan(frequency_ramp, steps, ramp_steps, max_period_us, min_period_us);
        let ramped = if steps < RAMP_FROM_STEPS { None } else { Some(plan()?) };
        Ok(Self { steps, short_half_us: whole(max_period_us / 2.0), ramped })
    }

    /// N.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Steps of each branch of the equations, as in [`FrequencyProfile::step_counts`]. Below 20 steps, all steps count
    /// as between the ramps.
    #[must_use]
    pub fn step_counts(&self) -> StepCounts {
        let short = StepCounts { accel: 0, cruise: self.steps, decel: 0 };
        self.ramped.map_or(short, |profile| profile.step_counts())
    }

    /// The time for which STEP is high, and then low, in step `i` = 1 to N (clamped to this range), us.
    #[must_use]
    pub fn half_period_us(&self, i: u32) -> u32 {
        self.ramped.map_or(self.short_half_us, |profile| whole(1e6 / profile.frequency_hz(i) / 2.0))
    }

    /// The period of step `i` = 1 to N (clamped to this range), us: two halves.
    #[must_use]
    pub fn period_us(&self, i: u32) -> u32 {
        2 * self.half_period_us(i)
    }

    /// The instants of the rising edges of steps 1 to N, us, the first at 0.
    pub fn edges_us(&self) -> impl Iterator<Item = u64> + use<> {
        let plan = *self;
        (1..=plan.steps).scan(0, move |next_us, i| {
            let edge_us = *next_us;
            *next_us += u64::from(plan.period_us(i));
            Some(edge_us)
        })
    }

    /// The sum of all N periods, us. It is computed by a loop, so its cost grows with N.
    #[must_use]
    pub fn duration_us(&self) -> u64 {
        (1..=self.steps).map(|i| u64::from(self.period_us(i))).sum()
    }
}

/// Cuts down to a whole number. A number that only rounding has put below a whole number becomes that number.
fn whole(half_us: f64) -> u32 {
    floor(half_us * (1.0 + ROUNDING)) as u32
}
