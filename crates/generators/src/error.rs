//! Why a generator was refused.

use core::fmt;

use isostep_profile::ProfileError;

/// Why a generator could not be planned. Each variant names the value and the limit it crossed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum GeneratorError {
    /// No generator can run this move: there are no steps, or the limits do not work.
    Profile(ProfileError),
    /// The method cannot begin at this speed, steps/s.
    StartSpeed {
        /// The value that was asked for.
        asked: f64,
        /// The slowest that works.
        min: f64,
        /// The fastest that works.
        max: f64,
    },
    /// Steps would follow each other faster than the generator's clock, steps/s.
    TopSpeed {
        /// The value that was asked for.
        asked: f64,
        /// The fastest that works.
        max: f64,
    },
    /// At this acceleration or deceleration an interval would overflow the generator's counter, steps/s².
    Accel {
        /// The value that was asked for.
        asked: f64,
        /// The smallest that works.
        min: f64,
    },
    /// The move is too long for the generator's counter, steps.
    Steps {
        /// The value that was asked for.
        asked: u32,
        /// The most that works.
        max: u32,
    },
}

impl fmt::Display for GeneratorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Profile(error) => error.fmt(f),
            Self::StartSpeed { asked, min, max } => {
                write!(f, "this generator cannot start at {asked} steps/s: it needs {min} to {max} steps/s")
            }
            Self::TopSpeed { asked, max } => {
                write!(f, "top speed {asked} steps/s is above this generator's clock, {max} steps/s")
            }
            Self::Accel { asked, min } => {
                write!(f, "acceleration {asked} steps/s2 is below {min} steps/s2: an interval would overflow")
            }
            Self::Steps { asked, max } => write!(f, "{asked} steps are more than this generator's {max}"),
        }
    }
}

impl core::error::Error for GeneratorError {}
