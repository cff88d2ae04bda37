//! Ramps whose speed is a function of time, in a unit square: speed and time from 0 to 1.

use core::f64::consts::PI;

use libm::sqrt;

use super::quarter::sin_cos;
use crate::newton::rising_root;

/// The law of a ramp. It is steepest in the middle, and symmetrical: s(1 - t) = 1 - s(t).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) enum OverTime {
    /// The jerk is constant for `share` of the time, 0 for a while, and the first backwards for `share` again.
    SCurve {
        /// Above 0, to 1/2.
        share: f64,
    },
    /// s(t) = (1 - cos π t)/2.
    Sine,
}

/// How far before a corner is at it.
const CORNER_TOLERANCE: f64 = 1e-12;

impl OverTime {
    /// The steepest slope.
    pub(super) fn peak(self) -> f64 {
        match self {
            Self::SCurve { share } => 1.0 / (1.0 - share),
            Self::Sine => PI / 2.0,
        }
    }

    /// ∫ s from 0 to `t`; 1/2 at 1.
    pub(super) fn travel(self, t: f64) -> f64 {
        let left = 1.0 - t;
        match self {
            Self::SCurve { share } if t <= share => t * t * t / (6.0 * share * (1.0 - share)),
            Self::SCurve { share } if left <= share => 0.5 - left + left * left * left / (6.0 * share * (1.0 - share)),
            Self::SCurve { share } => (t * (t - share) + share * share / 3.0) / (2.0 * (1.0 - share)),
            Self::Sine => sine_travel(t),
        }
    }

    /// s(`t`).
    pub(super) fn speed(self, t: f64) -> f64 {
        let left = 1.0 - t;
        match self {
            Self::SCurve { share } if t <= share => t * t / (2.0 * share * (1.0 - share)),
            Self::SCurve { share } if left <= share => 1.0 - left * left / (2.0 * share * (1.0 - share)),
            Self::SCurve { share } => (t - share / 2.0) / (1.0 - share),
            // Not (1 - cos π t)/2, which cancels near standstill.
            Self::Sine => {
                let (sine, _) = sin_cos(t);
                sine * sine
            }
        }
    }

    /// s'(`t`).
    pub(super) fn slope(self, t: f64) -> f64 {
        match self {
            Self::SCurve { share } => t.min(1.0 - t).min(share) / (share * (1.0 - share)),
            Self::Sine => {
                let (sine, cosine) = sin_cos(t);
                PI * sine * cosine
            }
        }
    }

    /// s''(`t`).
    pub(super) fn bend(self, t: f64) -> f64 {
        match self {
            Self::SCurve { share } if t < share => 1.0 / (share * (1.0 - share)),
            Self::SCurve { share } if 1.0 - t < share => -1.0 / (share * (1.0 - share)),
            Self::SCurve { .. } => 0.0,
            Self::Sine => PI * PI * (0.5 - self.speed(t)),
        }
    }

    /// Where s'' jumps next, after `t`.
    pub(super) fn next_corner(self, t: f64) -> f64 {
        // Rounding may leave a `t` that was a corner a little before it.
        let is_ahead = |corner: &f64| t < corner * (1.0 - CORNER_TOLERANCE);
        match self {
            Self::SCurve { share } => [share, 1.0 - share].into_iter().find(is_ahead).unwrap_or(1.0),
            Self::Sine => 1.0,
        }
    }

    /// When `slow` t + travel(t) is `way`.
    pub(super) fn time(self, slow: f64, way: f64) -> f64 {
        // s is at least t² (and 2 t² until the middle), so the travel is at least t³/3, and that at least t⁴/3.
        let latest = sqrt(sqrt(3.0 * way)).min(way / slow).min(1.0);
        rising_root((0.0, latest), latest, 1e-15, |t| (slow * t + self.travel(t) - way, slow + self.speed(t)))
    }
}

/// (t - sin(π t)/π)/2. It cancels near 0, so there by the series in x = π t: x³/12 π (1 - x²/20 (1 - x²/42 (1 - ...))).
fn sine_travel(t: f64) -> f64 {
    let x = PI * t;
    if t > SERIES_END {
        let (sine, cosine) = sin_cos(t);
        return t / 2.0 - sine * cosine / PI;
    }
    let sum =
        (2..SERIES_TERMS).rev().map(f64::from).fold(1.0, |sum, k| 1.0 - sum * x * x / (2.0 * k * (2.0 * k + 1.0)));
    x * x * t / 12.0 * sum
}

/// Beyond, cancelling costs less than two digits.
const SERIES_END: f64 = 0.25;
/// Of the series: the next is 2^-57 of the sum at its end.
const SERIES_TERMS: u32 = 9;
