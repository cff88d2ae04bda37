//! Why a profile of Fonseca-Campos 2023 was refused.

use core::fmt;

/// Why a frequency profile could not be planned. Each variant names the value and the bound it crossed; a NaN is
/// outside every range.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FrequencyError {
    /// There are no steps.
    NoSteps,
    /// Every profile divides by p_N - 1 or by ln p_N.
    ShortRamp {
        /// The value that was asked for, steps.
        asked: u32,
        /// The fewest that work.
        min: u32,
    },
    /// The two ramps do not fit: 2 p_N > N.
    LongRamp {
        /// The value that was asked for, steps.
        asked: u32,
        /// The most that work, N/2.
        max: u32,
        /// N.
        steps: u32,
    },
    /// The largest period is outside its range, us.
    MaxPeriod {
        /// The value that was asked for.
        asked: f64,
        /// The shortest that works.
        min: f64,
        /// The longest that works.
        max: f64,
    },
    /// The smallest period is outside its range, us.
    MinPeriod {
        /// The value that was asked for.
        asked: f64,
        /// The shortest that works.
        min: f64,
        /// The longest that works.
        max: f64,
    },
    /// The smallest period is above the largest, us.
    PeriodOrder {
        /// The smallest that was asked.
        asked: f64,
        /// The largest.
        max: f64,
    },
}

impl fmt::Display for FrequencyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NoSteps => write!(f, "0 steps: a profile needs at least 1 step"),
            Self::ShortRamp { asked, min } => {
                write!(
                    f,
                    "a ramp of {asked} steps: every profile divides by p_N - 1 or ln p_N, so it needs at least {min}"
                )
            }
            Self::LongRamp { asked, max, steps } => {
                write!(f, "two ramps of {asked} steps do not fit {steps} steps: 2 p_N <= N allows at most {max}")
            }
            Self::MaxPeriod { asked, min, max } => {
                write!(f, "largest period {asked} us is outside {min} to {max} us")
            }
            Self::MinPeriod { asked, min, max } => {
                write!(f, "smallest period {asked} us is outside {min} to {max} us")
            }
            Self::PeriodOrder { asked, max } => {
                write!(f, "smallest period {asked} us is above the largest, {max} us: at most that")
            }
        }
    }
}

impl core::error::Error for FrequencyError {}
