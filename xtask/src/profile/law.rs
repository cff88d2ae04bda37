//! The laws by name.

use clap::ValueEnum;
use isostep_profile::SpeedLaw;
use isostep_profile::generators::FrequencyLaw;

/// How speed changes on a ramp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Law {
    /// Constant acceleration
    Trapezoid,
    /// Limited jerk
    SCurve,
    /// Half a wave of a cosine over time
    Sine,
    /// Paper 000, eq 5
    Linear,
    /// Paper 000, eq 6
    Quadratic,
    /// Paper 000, eq 7
    Sinusoidal,
    /// Paper 000, eq 8
    Logarithmic,
}

impl Law {
    /// As paper 000's law of frequency, if it is one of the four.
    pub fn frequency(self) -> Option<FrequencyLaw> {
        match self {
            Self::Linear => Some(FrequencyLaw::Linear),
            Self::Quadratic => Some(FrequencyLaw::Quadratic),
            Self::Sinusoidal => Some(FrequencyLaw::Sinusoidal),
            Self::Logarithmic => Some(FrequencyLaw::Logarithmic),
            Self::Trapezoid | Self::SCurve | Self::Sine => None,
        }
    }

    /// As the machine's law.
    pub fn speed(self) -> SpeedLaw {
        match self {
            Self::Trapezoid => SpeedLaw::Trapezoid,
            Self::SCurve => SpeedLaw::SCurve,
            Self::Sine => SpeedLaw::Sine,
            Self::Linear => SpeedLaw::Linear,
            Self::Quadratic => SpeedLaw::Quadratic,
            Self::Sinusoidal => SpeedLaw::Sinusoidal,
            Self::Logarithmic => SpeedLaw::Logarithmic,
        }
    }

    /// As it is typed.
    pub fn name(self) -> &'static str {
        self.speed().name()
    }
}
