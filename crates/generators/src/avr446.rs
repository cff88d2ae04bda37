//! The integer ramp of Austin (2005), *Generate stepper-motor speed profiles in real time*, in the form that Atmel's
//! application note AVR446, *Linear speed control of stepper motor*, gives it.

use libm::sqrt;

use super::{GeneratorError, check_top_speed, profile};
use isostep_profile::Limits;

/// The exact first interval is f sqrt(2/a). The first term of the series is 44 % off; this factor corrects the terms
/// after it.
const FIRST_INTERVAL_FACTOR: f64 = 0.676;
/// The limit at which twice an interval plus a remainder still fits 31 bits.
const FIRST_INTERVAL_MAX_TICKS: f64 = 536_870_912.0;
/// The limit at which the divisor, 4 n, fits 30 bits.
const STEPS_MAX: u32 = 1 << 28;

/// c_n = c_(n-1) - (2 c_(n-1) + rest)/(4 n + 1) in integers, with c_0 = 0.676 f sqrt(2/a), and the remainder of each
/// division carried into the next. Yields the intervals c_0 to c_(N-2) of N steps, ticks.
///
/// Its closed form, from rest, is c_n = f sqrt(2/a) (sqrt(n + 1) - sqrt(n)): step n, counted from 0, is at displacement
/// n. The deceleration counts n down to 0, with the divisor 4 n - 1. The cruise interval is f/v, rounded down to whole
/// ticks.
#[derive(Clone, Copy, Debug)]
pub struct Avr446 {
    phase: Phase,
    interval: u32,
    rest: u32,
    /// Number of steps from the beginning of the acceleration, or to the end of the deceleration.
    n: u32,
    cruise: u32,
    /// The interval with which the deceleration begins.
    last_accel: u32,
    /// Steps already made.
    made: u32,
    decel_start: u32,
    steps: u32,
}

#[derive(Clone, Copy, Debug)]
enum Phase {
    Accel,
    Cruise,
    Decel,
}

impl Avr446 {
    /// Plans `steps` steps from rest to rest, in ticks of `tick_hz`.
    ///
    /// # Errors
    /// The value that does not work, and its limit. The start speed must be 0, the top speed at most `tick_hz`, the
    /// steps at most 2^28, and acceleration and deceleration such that an interval is at most 2^29 ticks.
    pub fn plan(steps: u32, limits: &Limits, tick_hz: u32) -> Result<Self, GeneratorError> {
        profile(steps, limits)?;
        let f = f64::from(tick_hz);
        check_top_speed(limits, f)?;
        if limits.start_speed_steps_s != 0.0 {
            return Err(GeneratorError::StartSpeed { asked: limits.start_speed_steps_s, min: 0.0, max: 0.0 });
        }
        if steps > STEPS_MAX {
            return Err(GeneratorError::Steps { asked: steps, max: STEPS_MAX });
        }
        let least = FIRST_INTERVAL_FACTOR * f / FIRST_INTERVAL_MAX_TICKS;
        let (asked, min) = (limits.accel_steps_s2.min(limits.decel_steps_s2), 2.0 * least * least);
        if asked < min {
            return Err(GeneratorError::Accel { asked, min });
        }
        let first = FIRST_INTERVAL_FACTOR * f * sqrt(2.0 / limits.accel_steps_s2);
        let (first, cruise) = (first as u32, (f / limits.top_speed_steps_s) as u32);
        let phase = if first <= cruise { Phase::Cruise } else { Phase::Accel };
        Ok(Self {
            phase,
            interval: first.max(cruise),
            rest: 0,
            n: 0,
            cruise,
            last_accel: cruise,
            made: 0,
            decel_start: steps - decel_steps(steps, limits),
            steps,
        })
    }

    fn next_interval(&mut self) -> u32 {
        match self.phase {
            Phase::Accel => {
                self.n += 1;
                let faster = self.interval - self.quotient(4 * self.n + 1);
                if self.made >= self.decel_start {
                    self.decelerate();
                    faster
                } else if faster <= self.cruise {
                    (self.phase, self.rest, self.last_accel) = (Phase::Cruise, 0, faster);
                    self.cruise
                } else {
                    faster
                }
            }
            Phase::Cruise if self.made >= self.decel_start => {
                self.decelerate();
                self.last_accel
            }
            Phase::Cruise => self.cruise,
            Phase::Decel => {
                self.n -= 1;
                self.interval + self.quotient(4 * self.n - 1)
            }
        }
    }

    fn decelerate(&mut self) {
        (self.phase, self.n) = (Phase::Decel, self.steps - self.decel_start);
    }

    /// (2 c + rest) / `divisor`. The remainder is kept for the next division.
    fn quotient(&mut self, divisor: u32) -> u32 {
        let dividend = 2 * self.interval + self.rest;
        self.rest = dividend % divisor;
        dividend / divisor
    }
}

/// Steps of the deceleration (AVR446: `decel_val`), at least 1. As in the note, both counts are at least a step, so where the
/// top speed takes less than one, the deceleration may have all steps but the first.
fn decel_steps(steps: u32, limits: &Limits) -> u32 {
    let (a, d) = (limits.accel_steps_s2, limits.decel_steps_s2);
    let top = limits.top_speed_steps_s;
    // The step at which the top speed is reached, and the step at which the deceleration has to begin if it is not
    // reached.
    let to_top = ((top * top / (2.0 * a)) as u32).max(1);
    let to_peak = ((f64::from(steps) * d / (a + d)) as u32).max(1);
    let decel = if to_peak <= to_top { steps - to_peak.min(steps) } else { (f64::from(to_top) * a / d) as u32 };
    decel.clamp(1, steps)
}

impl Iterator for Avr446 {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        if self.made + 1 >= self.steps {
            return None;
        }
        let interval = self.interval;
        self.made += 1;
        // The interval after the last one is not used, and its divisor would be 4 * 0 - 1.
        if self.made + 1 < self.steps {
            self.interval = self.next_interval();
        }
        Some(interval)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (self.steps - 1 - self.made) as usize;
        (left, Some(left))
    }
}

impl ExactSizeIterator for Avr446 {}
