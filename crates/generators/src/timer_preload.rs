//! Timers that count up from a preload and interrupt when they overflow (Forero 2023, eq 14).

use core::fmt;

use libm::ceil;

/// Tolerance for rounding: far above the rounding of a few products, far below any distance of a count from a whole
/// number.
const ROUNDING: f64 = 1e-12;

/// A timer of Forero's PIC18F4550.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreloadTimer {
    /// F_osc, Hz. The timer counts a quarter of this frequency, divided by the prescaler.
    pub oscillator_hz: u32,
    /// PS, the prescaler.
    pub prescaler: u32,
    /// N, the bits of the counter: it overflows after 2^N counts; 1 to 16.
    pub resolution_bits: u32,
}

/// Why a timer cannot make an interval, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimerError {
    /// The interval that was asked for.
    pub asked: f64,
    /// The shortest interval: one count.
    pub min: f64,
    /// The longest interval: 2^N counts.
    pub max: f64,
}

impl PreloadTimer {
    /// TMR0, which measures the intervals of the staircase: 8 MHz, prescaler 8, 16 bits.
    pub const TMR0: Self = Self { oscillator_hz: 8_000_000, prescaler: 8, resolution_bits: 16 };
    /// TMR1, and also TMR3, which is the same. Each of them steps one motor: 8 MHz, prescaler 4, 16 bits.
    pub const TMR1: Self = Self { oscillator_hz: 8_000_000, prescaler: 4, resolution_bits: 16 };

    /// Counts in a second.
    #[must_use]
    pub fn tick_hz(&self) -> f64 {
        f64::from(self.oscillator_hz) / (4.0 * f64::from(self.prescaler))
    }

    /// The preload that would make `interval_s` exact; usually not a whole number (Forero 2023, eq 14).
    #[must_use]
    pub fn exact_preload(&self, interval_s: f64) -> f64 {
        f64::from(self.full()) - interval_s * self.tick_hz()
    }

    /// The preload that fits the register: the exact one, cut down to a whole number. The interval becomes longer by up
    /// to one count.
    ///
    /// # Errors
    /// The interval is shorter than one count or longer than 2^N counts.
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

/// Rounds a count up, which is the same as cutting its preload down. A count that only rounding has put above a whole
/// number becomes that number.
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
