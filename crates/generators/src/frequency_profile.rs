//! Fonseca-Campos's profiles by the exact equations, without the truncation to microseconds.

use super::{FrequencyError, FrequencyRamp};
use isostep_profile::StepCounts;

/// Shortest period that can be planned, us: [`SPEED_MAX_STEPS_S`](isostep_profile::SPEED_MAX_STEPS_S).
pub const PERIOD_MIN_US: f64 = 0.1;
/// Longest period that can be planned, us: [`SPEED_MIN_STEPS_S`](isostep_profile::SPEED_MIN_STEPS_S).
pub const PERIOD_MAX_US: f64 = 1e9;
/// Every profile divides by p_N - 1 or by ln p_N.
const RAMP_MIN_STEPS: u32 = 2;

/// A move of N steps whose frequency rises over p_N steps from f_min to f_max, is constant, and falls over the last p_N
/// steps (Fonseca-Campos 2023, eqs 5-8). Its instants are absolute, and nothing is truncated.
///
/// The rule that a move of fewer than 20 steps runs at f_min is part of the printed program, not of the equations. Only
/// [`TruncatedProfile`](super::TruncatedProfile) follows it.
///
/// ```
/// use isostep_generators::{FrequencyRamp, FrequencyProfile};
///
/// // The paper's Table 1: 27 degrees of 1600 steps a revolution, a ramp of a fifth, 4000 to 1500 us.
/// let total_s = |profile| FrequencyProfile::plan(profile, 120, 24, 4_000.0, 1_500.0).map(|plan| plan.duration_s());
/// let saved = 1.0 - total_s(FrequencyRamp::Logarithmic)? / total_s(FrequencyRamp::Linear)?;
/// assert!((0.099..0.100).contains(&saved), "the paper: almost 10 %");
/// # Ok::<(), isostep_generators::FrequencyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyProfile {
    frequency_ramp: FrequencyRamp,
    steps: u32,
    ramp_steps: u32,
    min_hz: f64,
    max_hz: f64,
}

impl FrequencyProfile {
    /// Plans `steps` (N) steps with ramps of `ramp_steps` (p_N) each, from the period `max_period_us` (tau_max, of
    /// f_min) down to `min_period_us` (tau_min, of f_max) and back. Periods are [`PERIOD_MIN_US`] to [`PERIOD_MAX_US`].
    ///
    /// # Errors
    /// The value and the bound: N = 0, p_N < 2, 2 p_N > N, a period out of range, tau_min above tau_max.
    pub fn plan(
        frequency_ramp: FrequencyRamp,
        steps: u32,
        ramp_steps: u32,
        max_period_us: f64,
        min_period_us: f64,
    ) -> Result<Self, FrequencyError> {
        check_periods(max_period_us, min_period_us, PERIOD_MIN_US)?;
        check_fit(steps, ramp_steps)?;
        check_short_ramp(ramp_steps)?;
        Ok(Self { frequency_ramp, steps, ramp_steps, min_hz: 1e6 / max_period_us, max_hz: 1e6 / min_period_us })
    }

    /// The profile of its ramps.
    #[must_use]
    pub fn frequency_ramp(&self) -> FrequencyRamp {
        self.frequency_ramp
    }

    /// N.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// p_N, the steps of each ramp.
    #[must_use]
    pub fn ramp_steps(&self) -> u32 {
        self.ramp_steps
    }

    /// Steps of each branch of the equations: p_N; those between; and p_N + 1, because step N - p_N already belongs to
    /// the last branch. If there are none between, because 2 p_N = N, that step belongs to the acceleration.
    #[must_use]
    pub fn step_counts(&self) -> StepCounts {
        let accel = self.ramp_steps;
        let decel = (accel + 1).min(self.steps - accel);
        StepCounts { accel, cruise: self.steps - accel - decel, decel }
    }

    /// f\[i\], Hz, of step `i` = 1 to N (clamped to this range). Step p_N is the last of the acceleration, step N - p_N
    /// the first of the deceleration; both have f_max.
    #[must_use]
    pub fn frequency_hz(&self, i: u32) -> f64 {
        let i = i.clamp(1, self.steps);
        let left = self.steps - i;
        let ratio = if i <= self.ramp_steps {
            self.frequency_ramp.rising_ratio(i, self.ramp_steps)
        } else if left > self.ramp_steps {
            1.0
        } else {
            self.frequency_ramp.falling_ratio(left, self.ramp_steps)
        };
        // This is exact at both ends, unlike f_min + ratio * span.
        self.min_hz * (1.0 - ratio) + self.max_hz * ratio
    }

    /// 1/f\[i\], s, of step `i` = 1 to N: the time from its rising edge to the next. That of step N ends the move.
    #[must_use]
    pub fn period_s(&self, i: u32) -> f64 {
        1.0 / self.frequency_hz(i)
    }

    /// The instants of the rising edges of steps 1 to N, s, the first at 0; each is the sum of all periods before it.
    #[must_use]
    pub fn edges_s(&self) -> FrequencyEdges {
        FrequencyEdges { profile: *self, given: 0, sum_s: 0.0, rest_s: 0.0 }
    }

    /// The sum of all N periods, s. It is computed by a loop, so its cost grows with N.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        let mut edges = self.edges_s();
        while edges.next().is_some() {}
        edges.sum_s + edges.rest_s
    }
}

/// The rising edges of a [`FrequencyProfile`], s. The sum carries what each addition rounds off (Kahan and Babuska), so
/// the millionth instant is as accurate as the first.
#[derive(Clone, Copy, Debug)]
pub struct FrequencyEdges {
    profile: FrequencyProfile,
    /// Edges already given.
    given: u32,
    sum_s: f64,
    rest_s: f64,
}

impl Iterator for FrequencyEdges {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        if self.given == self.profile.steps {
            return None;
        }
        self.given += 1;
        let edge_s = self.sum_s + self.rest_s;
        let period_s = self.profile.period_s(self.given);
        let sum_s = self.sum_s + period_s;
        let (larger, smaller) = if self.sum_s >= period_s { (self.sum_s, period_s) } else { (period_s, self.sum_s) };
        self.rest_s += (larger - sum_s) + smaller;
        self.sum_s = sum_s;
        Some(edge_s)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (self.profile.steps - self.given) as usize;
        (left, Some(left))
    }
}

impl ExactSizeIterator for FrequencyEdges {}

/// Refuses periods outside `least_us` to [`PERIOD_MAX_US`] or in the wrong order.
pub(super) fn check_periods(max_period_us: f64, min_period_us: f64, least_us: f64) -> Result<(), FrequencyError> {
    let (min, max) = (least_us, PERIOD_MAX_US);
    if !(min..=max).contains(&max_period_us) {
        return Err(FrequencyError::MaxPeriod { asked: max_period_us, min, max });
    }
    if !(min..=max).contains(&min_period_us) {
        return Err(FrequencyError::MinPeriod { asked: min_period_us, min, max });
    }
    if min_period_us > max_period_us {
        return Err(FrequencyError::PeriodOrder { asked: min_period_us, max: max_period_us });
    }
    Ok(())
}

/// Refuses a move without steps, and ramps that do not fit it.
pub(super) fn check_fit(steps: u32, ramp_steps: u32) -> Result<(), FrequencyError> {
    if steps == 0 {
        return Err(FrequencyError::NoSteps);
    }
    if ramp_steps > steps / 2 {
        return Err(FrequencyError::LongRamp { asked: ramp_steps, max: steps / 2, steps });
    }
    Ok(())
}

fn check_short_ramp(ramp_steps: u32) -> Result<(), FrequencyError> {
    if ramp_steps < RAMP_MIN_STEPS {
        return Err(FrequencyError::ShortRamp { asked: ramp_steps, min: RAMP_MIN_STEPS });
    }
    Ok(())
}
