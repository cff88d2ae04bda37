//! "Time per step" (Stoychitch 2018, section 3.1): each interval is computed from the one before.

use libm::sqrt;

use super::{Float, GeneratorError, check_start_speed, check_top_speed, profile};
use isostep_profile::Limits;
use isostep_profile::StepCounts;

/// The intervals of the first and last five steps, lengthened or not (Stoychitch 2018, eq 14).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Correction {
    /// Eqs 11 and 12 alone.
    Without,
    /// Eq 14 on the interval that is returned. The recurrence goes on from the uncorrected interval: if the corrected
    /// one were fed back, the five factors would multiply, and the paper's own motor would be a sixth too slow after
    /// five steps.
    With,
}

/// 1 + 0.08/i for i = 1 to 5 (Stoychitch 2018, eq 14).
const CORRECTIONS: [f64; 5] = [1.08, 1.04, 1.0 + 0.08 / 3.0, 1.02, 1.016];

/// The recurrence c_i = c_(i-1) / (1 + R c_(i-1)²), with R = a/f² while accelerating, -d/f² while decelerating and
/// c_m = f/v_M between (Stoychitch 2018, eqs 11 to 13). Yields the intervals c_0 to c_(N-2) of N steps, ticks.
///
/// c_i stands for the speed f/c_i at step i, counted from 0, so the closed form of this speed is sqrt(v_s² + 2 a i).
/// The recurrence leaves out the term (a/v)² of that square, so it runs ahead, most where the speed is lowest.
///
/// The paper asks for double precision, which is `TimePerStep<f64>`. The `double` of the 8-bit controllers that it was
/// written for is `TimePerStep<f32>`.
#[derive(Clone, Copy, Debug)]
pub struct TimePerStep<F> {
    counter: F,
    cruise: F,
    accel_r: F,
    decel_r: F,
    correction: Correction,
    /// Intervals already given.
    given: u32,
    accel_end: u32,
    cruise_end: u32,
    steps: u32,
}

impl<F: Float> TimePerStep<F> {
    /// Plans `steps` steps in ticks of `tick_hz`, from the start speed to the start speed.
    ///
    /// # Errors
    /// The value that does not work, and its limit. The top speed must be at most `tick_hz`. The start speed must be at
    /// least the speed that one step from rest reaches, sqrt(2 a) and sqrt(2 d); below it the recurrence diverges.
    pub fn plan(steps: u32, limits: &Limits, correction: Correction, tick_hz: u32) -> Result<Self, GeneratorError> {
        let StepCounts { accel, cruise, .. } = profile(steps, limits)?.step_counts();
        let f = f64::from(tick_hz);
        check_top_speed(limits, f)?;
        let (a, d) = (limits.accel_steps_s2, limits.decel_steps_s2);
        check_start_speed(limits, sqrt(2.0 * a.max(d)).max(CORRECTIONS[0] * f / f64::from(u32::MAX)))?;
        Ok(Self {
            counter: F::from_f64(f / limits.start_speed_steps_s),
            cruise: F::from_f64(f / limits.top_speed_steps_s),
            accel_r: F::from_f64(a / (f * f)),
            decel_r: F::from_f64(-d / (f * f)),
            correction,
            given: 0,
            accel_end: accel,
            cruise_end: accel + cruise,
            steps,
        })
    }

    /// c_i from c_(i-1), for i from 1.
    fn advance(&mut self, i: u32) {
        self.counter = if i <= self.accel_end {
            recur(self.counter, self.accel_r)
        } else if i <= self.cruise_end {
            self.cruise
        } else {
            recur(self.counter, self.decel_r)
        };
    }

    /// c_i, corrected by eq 14.
    fn corrected(&self, i: u32) -> F {
        let from_end = i.min(self.steps - i);
        match (self.correction, from_end) {
            (Correction::With, 1..=5) => self.counter * F::from_f64(CORRECTIONS[from_end as usize - 1]),
            _ => self.counter,
        }
    }
}

/// Stoychitch 2018, eqs 11 and 12.
fn recur<F: Float>(counter: F, r: F) -> F {
    counter / (F::ONE + r * (counter * counter))
}

impl<F: Float> Iterator for TimePerStep<F> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let i = self.given;
        if i + 1 >= self.steps {
            return None;
        }
        if i > 0 {
            self.advance(i);
        }
        self.given += 1;
        Some(self.corrected(i).ticks())
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (self.steps - 1 - self.given) as usize;
        (left, Some(left))
    }
}

impl<F: Float> ExactSizeIterator for TimePerStep<F> {}
