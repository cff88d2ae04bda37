//! The laws a move can follow: how its duration is split, and how its speed changes on a ramp.

use core::fmt;

/// How a move's duration is split into its three intervals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IntervalLaw {
    /// As fast as the limits allow: with a cruise, or without where the distance is short (paper 002, eqs 1-8).
    #[default]
    Fastest,
    /// Three equal intervals, as short as the limits allow (paper 004, eqs 1-7). From rest to rest on a trapezoid a
    /// quarter of the way is spent accelerating, half cruising, a quarter decelerating.
    Thirds,
}

/// How speed changes on a ramp. The first three are laws over time, the others over displacement.
///
/// A decelerating ramp is an accelerating one backwards in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpeedLaw {
    /// Linear over time: constant acceleration (paper 002).
    #[default]
    Trapezoid,
    /// Limited jerk: the acceleration rises and falls at constant jerk, and is constant between.
    SCurve,
    /// Half a wave of a cosine over time: jerk without jumps inside the ramp.
    Sine,
    /// Linear over displacement (paper 000, eq 5).
    Linear,
    /// Quadratic over displacement (paper 000, eq 6).
    Quadratic,
    /// Half a wave of a cosine over displacement (paper 000, eq 7).
    Sinusoidal,
    /// Logarithmic over displacement (paper 000, eq 8).
    Logarithmic,
}

impl SpeedLaw {
    /// Every law.
    pub const ALL: [Self; 7] =
        [Self::Trapezoid, Self::SCurve, Self::Sine, Self::Linear, Self::Quadratic, Self::Sinusoidal, Self::Logarithmic];

    /// What people call it, as commands take it.
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

    /// Whether speed is a function of the displacement. Such a ramp never leaves standstill: it needs a start speed.
    #[must_use]
    pub const fn is_over_displacement(self) -> bool {
        matches!(self, Self::Linear | Self::Quadratic | Self::Sinusoidal | Self::Logarithmic)
    }
}

impl fmt::Display for SpeedLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
