//! Timers that count up from a preload and interrupt when they overflow (paper 004, eq 14).

use core::fmt;

use libm::ceil;

/// Far above the rounding of a few products, far below any count that is not whole.
const ROUNDING: f64 = 1e-12;

/// A timer of paper 004's PIC18F4550.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreloadTimer {
    /// F_osc, Hz. The timer counts every fourth of its periods.
    pub oscillator_hz: u32,
    /// PS: every how many of those fourths it counts.
    pub prescaler: u32,
    /// N: it overflows after 2^N counts; 1 to 16.
    pub resolution_bits: u32,
}

/// Why a timer cannot make an interval, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimerError {
    /// What was asked.
    pub asked: f64,
    /// One count.
    pub min: f64,
    /// 2^N counts.
    pub max: f64,
}

impl PreloadTimer {
    /// TMR0, which measures the intervals of the staircase: 8 MHz, prescaler 8, 16 bits.
    pub const TMR0: Self = Self { oscillator_hz: 8_000_000, prescaler: 8, resolution_bits: 16 };
    /// TMR1, and TMR3 alike, each of which steps one motor: 8 MHz, prescaler 4, 16 bits.
    pub const TMR1: Self = Self { oscillator_hz: 8_000_000, prescaler: 4, resolution_bits: 16 };

    /// Counts in a second.
    #[must_use]
    pub fn tick_hz(&self) -> f64 {
        f64::from(self.oscillator_hz) / (4.0 * f64::from(self.prescaler))
    }

    /// The preload that would make `interval_s` exact, a fraction as a rule (paper 004, eq 14).
    #[must_use]
    pub fn exact_preload(&self, interval_s: f64) -> f64 {
        f64::from(self.full()) - interval_s * self.tick_hz()
    }

    /// The preload that fits the register: the exact one cut down to a whole number. The interval comes out up to a
    /// count longer.
    ///
    /// # Errors
    /// The interval is shorter than one count or longer than 2^N.
    pub fn preload(&self, interval_s: f64) -> Result<u32, TimerError> {
        let counts = whole_counts(interval_s * self.tick_hz());
        if (1.0..=f64::from(self.full())).contains(&counts) {
            Ok(self.full() - counts as u32)
        } else {
            let (min, max) = (1.0 / self.tick_hz(), f64::from(self.full()) / self.tick_hz());
            Err(TimerError { asked: interval_s, min, max })
        }
    }

    /// Counts from `preload` to the overflow.
    #[must_use]
    pub fn ticks(&self, preload: u32) -> u32 {
        self.full() - preload
    }

    fn full(&self) -> u32 {
        1 << self.resolution_bits
    }
}

/// A preload cut down is a count of ticks rounded up; one that only rounding has put above a whole number is that
/// number.
fn whole_counts(counts: f64) -> f64 {
    ceil(counts * (1.0 - ROUNDING))
}

impl fmt::Display for TimerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { asked, min, max } = self;
        write!(f, "an interval of {asked} s is outside what the timer can count, {min} to {max} s")
    }
}

impl core::error::Error for TimerError {}
