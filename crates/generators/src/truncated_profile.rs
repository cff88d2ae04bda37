//! Paper 000's profiles as printed: halves of a period in whole microseconds.

use libm::floor;

use super::frequency_profile::{check_fit, check_periods};
use super::{FrequencyError, FrequencyLaw, FrequencyProfile};
use isostep_profile::StepCounts;

/// Shortest period of which a half is still a microsecond, us.
const TRUNCATED_PERIOD_MIN_US: f64 = 2.0;
/// "The program assumes that if N < 20, the motor rotates at omega_min" (paper 000, section V).
const RAMP_FROM_STEPS: u32 = 20;
/// Far above the rounding of a few products, far below any period that is not whole.
const ROUNDING: f64 = 1e-12;

/// A move as paper 000's program makes it (section II.B, steps 4 and 5): STEP is high for half a period and low for
/// half a period, and each half is cut down to whole microseconds. So a period is an even number of microseconds, up to
/// 2 us short, and the whole move runs ahead of its law.
///
/// A move of fewer than 20 steps has no ramps: all its periods are tau_max's.
///
/// The program cuts twice, int(1e6/f) and then int(period/2), which is int(1e6/(2 f)). It is the number that is cut,
/// not its rounded image: a period of 300 us that floats make 299.99999999999994 stays 300. What the program's own
/// floats, of 24 bits on one of its boards, make of such a period is not reproduced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruncatedProfile {
    steps: u32,
    /// Without ramps: half of tau_max, us.
    short_half_us: u32,
    /// The law, for a move that is long enough.
    ramped: Option<FrequencyProfile>,
}

impl TruncatedProfile {
    /// Plans as [`FrequencyProfile::plan`] does. Periods are at least 2 us; below 20 steps p_N is not used, and may be
    /// 0 or 1, as a fifth of so few steps is.
    ///
    /// # Errors
    /// Names the value and the bound: N = 0, 2 p_N > N, p_N < 2 from 20 steps on, a period out of range, tau_min above
    /// tau_max.
    pub fn plan(
        law: FrequencyLaw,
        steps: u32,
        ramp_steps: u32,
        max_period_us: f64,
        min_period_us: f64,
    ) -> Result<Self, FrequencyError> {
        check_periods(max_period_us, min_period_us, TRUNCATED_PERIOD_MIN_US)?;
        check_fit(steps, ramp_steps)?;
        let plan = || FrequencyProfile::plan(law, steps, ramp_steps, max_period_us, min_period_us);
        let ramped = if steps < RAMP_FROM_STEPS { None } else { Some(plan()?) };
        Ok(Self { steps, short_half_us: whole(max_period_us / 2.0), ramped })
    }

    /// N.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Steps of each branch of the equations, as [`FrequencyProfile::step_counts`]; below 20 steps all between the ramps.
    #[must_use]
    pub fn step_counts(&self) -> StepCounts {
        let short = StepCounts { accel: 0, cruise: self.steps, decel: 0 };
        self.ramped.map_or(short, |profile| profile.step_counts())
    }

    /// How long STEP is high, and then low, in step `i` = 1 to N (clamped to them), us.
    #[must_use]
    pub fn half_period_us(&self, i: u32) -> u32 {
        self.ramped.map_or(self.short_half_us, |profile| whole(1e6 / profile.frequency_hz(i) / 2.0))
    }

    /// The period of step `i` = 1 to N (clamped to them), us: two halves.
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

    /// The sum of all N periods, us. Adds them up: its cost grows with N.
    #[must_use]
    pub fn duration_us(&self) -> u64 {
        (1..=self.steps).map(|i| u64::from(self.period_us(i))).sum()
    }
}

/// Cut down to a whole number; one that only rounding has put below a whole number is that number.
fn whole(half_us: f64) -> u32 {
    floor(half_us * (1.0 + ROUNDING)) as u32
}
