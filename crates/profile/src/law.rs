//! The laws a move can follow: how its duration is split, and how its speed changes on a ramp.

use core::fmt;

/// The way in which a move's duration is split into its three intervals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum IntervalLaw {
    /// As fast as the limits allow: with a cruise, or without one if the distance is short (Stoychitch 2018, eqs 1-8).
    #[default]
    Fastest,
    /// Three equal intervals, as short as the limits allow (Forero 2023, eqs 1-7). A trapezoid from rest to rest then
    /// accelerates over a quarter of the distance, cruises over half of it and decelerates over a quarter.
    Thirds,
}

impl IntervalLaw {
    /// Every law.
    pub const ALL: [Self; 2] = [Self::Fastest, Self::Thirds];
}

/// The law by which speed changes on a ramp. The first three are laws over time, the others over displacement.
///
/// A decelerating ramp is an accelerating ramp seen backwards in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum SpeedLaw {
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

impl SpeedLaw {
    /// Every law.
    pub const ALL: [Self; 7] =
        [Self::Trapezoid, Self::SCurve, Self::Sine, Self::Linear, Self::Quadratic, Self::Sinusoidal, Self::Logarithmic];

    /// The usual name of the law, which commands accept.
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

impl fmt::Display for SpeedLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
