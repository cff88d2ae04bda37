//! The rise and fall of the step frequency over the step index in Fonseca-Campos 2023 (Fonseca-Campos and others,
//! 2023, *Implementation in Microcontrollers of an Algorithm for the Simple Generation of Speed Profiles in a Stepper
//! Motor*).

use core::f64::consts::PI;
use core::fmt;

use libm::{cos, log};

/// Frequency over the step index on a ramp of p_N steps (Fonseca-Campos 2023, eqs 5-8).
///
/// The paper writes each profile with its own constants a0 to a8. All of them have the same form: a fraction of the span
/// from f_min to f_max, which grows from 0 at the first step to 1 at step p_N, and falls from 1 at step N - p_N to 0 at
/// step N.
///
/// These are the equations. The listings in the paper's appendices are meant to be the same, but differ:
///
/// - Arduino, quadratic: `a2*(i*1) + a3` instead of a2 i² + a3. The ramp is straight, ends at
///   f_min + (f_max - f_min)/(p_N + 1), and jumps to f_max.
/// - MicroPython, logarithmic: a8 has `f_max + f_min` instead of f_max - f_min. The deceleration begins at
///   f_max + 2 f_min, above the top frequency.
/// - MicroPython, all profiles: a move of fewer than 20 steps makes one pulse instead of N.
/// - MicroPython, p_N = 0 or 1, which `int(s*.2)` gives below 10 steps: a division by zero happens before the rule for
///   short moves is applied. In C the quotient is infinite or not a number, and is not used if N < 20.
/// - Arduino: the pins given to the constructor are never stored in `_dirPin` and `_stepPin`.
/// - Arduino: `pN*pN` overflows where an `int` has 16 bits and p_N > 181.
///
/// MicroPython's sinusoidal profile is printed with a broken line. It is read here like Arduino's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrequencyRamp {
    /// Eq 5.
    Linear,
    /// Eq 6.
    Quadratic,
    /// Eq 7: half a wave of a cosine.
    Sinusoidal,
    /// Eq 8.
    Logarithmic,
}

impl FrequencyRamp {
    /// All four, in the paper's order.
    pub const ALL: [Self; 4] = [Self::Linear, Self::Quadratic, Self::Sinusoidal, Self::Logarithmic];

    /// The paper's name of the profile, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Quadratic => "quadratic",
            Self::Sinusoidal => "sinusoidal",
            Self::Logarithmic => "logarithmic",
        }
    }

    /// The fraction of the span at step `i` = 1 to `ramp_steps` of the acceleration, 0 to 1; `ramp_steps` is at
    /// least 2.
    pub(super) fn rising_ratio(self, i: u32, ramp_steps: u32) -> f64 {
        let (i, p) = (f64::from(i), f64::from(ramp_steps));
        match self {
            Self::Linear => (i - 1.0) / (p - 1.0),
            Self::Quadratic => (i * i - 1.0) / (p * p - 1.0),
            Self::Sinusoidal => half_wave((i - 1.0) / (p - 1.0)),
            Self::Logarithmic => log(i) / log(p),
        }
    }

    /// The fraction of the span at `left` = N - i steps before the last one, 0 to 1; `left` is at most `ramp_steps`.
    pub(super) fn falling_ratio(self, left: u32, ramp_steps: u32) -> f64 {
        let (left, p) = (f64::from(left), f64::from(ramp_steps));
        match self {
            Self::Linear => left / p,
            Self::Quadratic => (left * left) / (p * p),
            Self::Sinusoidal => half_wave(left / p),
            Self::Logarithmic => log(left + 1.0) / log(p + 1.0),
        }
    }
}

/// Rises from 0 to 1 while x goes from 0 to 1, as half a wave of a cosine.
fn half_wave(x: f64) -> f64 {
    (1.0 - cos(PI * x)) / 2.0
}

impl fmt::Display for FrequencyRamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
