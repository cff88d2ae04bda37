//! The speed profile: how speed changes on a ramp.

use core::fmt;

/// The change of speed on a ramp. The first three profiles are over time, the others over displacement.
///
/// A decelerating ramp is an accelerating ramp seen backwards in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum SpeedProfile {
    /// Linear over time: constant acceleration (Stoychitch 2018).
    #[default]
    Trapezoid,
    /// Limited jerk: the acceleration rises and falls at constant jerk, and is constant in between.
    SCurve,
    /// Half a wave of a cosine over time: jerk without jumps inside the ramp.
    Sine,
    /// Linear over displacement (Fonseca-Campos 2023, eq 5).
    Linear,
    /// Quadratic over displacement (Fonseca-Campos 2023, eq 6).
    Quadratic,
    /// Half a wave of a cosine over displacement (Fonseca-Campos 2023, eq 7).
    Sinusoidal,
    /// Logarithmic over displacement (Fonseca-Campos 2023, eq 8).
    Logarithmic,
}

impl SpeedProfile {
    /// Every speed profile.
    pub const ALL: [Self; 7] =
        [Self::Trapezoid, Self::SCurve, Self::Sine, Self::Linear, Self::Quadratic, Self::Sinusoidal, Self::Logarithmic];

    /// The usual name of the speed profile, which commands accept.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Trapezoid => "trapezoid",
            Self::SCurve => "s-curve",
            Self::Sine => "sine",
            Self::Linear => "linear",
            Self::Quadratic => "quadratic",
            Self::Sinusoidal => "sinusoidal",
            Self::Logarithmic => "logarithmic",
        }
    }

    /// True if speed is a function of the displacement. Such a ramp never leaves standstill: it needs a start speed.
    #[must_use]
    pub const fn is_over_displacement(self) -> bool {
        !matches!(self, Self::Trapezoid | Self::SCurve | Self::Sine)
    }
}

impl fmt::Display for SpeedProfile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
